"""directrix as a solver of cosseratbench."""
# pyright: basic
# (what cosseratbench hands over has no types where it is not installed)

from __future__ import annotations

from dataclasses import replace
from importlib.metadata import entry_points

import numpy as np
import pytest

pytest.importorskip("cosseratbench", reason="cosseratbench is not installed")
from cosseratbench import registry, solver  # pyright: ignore[reportMissingImports]

from directrix.cosserat_bench import DirectrixSolver


@pytest.fixture(scope="module")
def cantilever():
    return registry.load_experiment("cantilever")


def test_it_is_found_by_its_entry_point_and_is_a_solver() -> None:
    (point,) = entry_points(group="cosseratbench.solvers", name="directrix")
    assert point.load() is DirectrixSolver
    assert isinstance(DirectrixSolver(), solver.Solver)


def test_the_tip_of_the_cantilever_is_where_beam_theory_has_it(cantilever) -> None:
    scenario = cantilever.build()
    trajectory = DirectrixSolver().run(scenario, n_elements=8, n_frames=3)
    assert trajectory.positions[0].shape == (3, 9, 3)
    assert cantilever.metrics["tip_deflection_error"](scenario, trajectory) < 2e-3  # theirs has no shear: 1e-3
    assert np.allclose(trajectory.directors[0][0], scenario.rods[0].directors(8), atol=1e-12)


def test_a_motion_has_the_frames_asked_for(cantilever) -> None:
    scenario = replace(cantilever.build(), quasi_static=False, duration=0.02)
    trajectory = DirectrixSolver(time_step_scale=2.0).run(scenario, n_elements=8, n_frames=5)
    assert np.allclose(trajectory.times, [0, 0.005, 0.01, 0.015, 0.02])
    assert np.all(np.diff(trajectory.positions[0][:, -1, 2]) < 0)  # the load draws it down


def test_what_it_cannot_do_is_refused(cantilever) -> None:
    for name in ("pendulum", "pile", "twist"):
        experiment = registry.load_experiment(name)
        scenario = experiment.build(**{p.name: p.default for p in experiment.parameters})
        with pytest.raises(NotImplementedError):
            DirectrixSolver().run(scenario, n_elements=8, n_frames=3)
    with pytest.raises(NotImplementedError, match="even"):
        DirectrixSolver().run(cantilever.build(), n_elements=7, n_frames=3)
