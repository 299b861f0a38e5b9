"""directrix as a solver of `cosseratbench <https://pypi.org/project/cosseratbench/>`_, found by its entry point.

Rods that start straight, unstretched and at rest, free, pinned or clamped at their ends, under gravity and forces at
the ends. Whatever else a scenario asks for (contact, driven ends, a start that is bent or stretched) is refused, and
the benchmark reports it as unsupported.
"""
# pyright: basic
# (what cosseratbench hands over has no types where it is not installed)

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

import directrix as dx
from directrix.errors import ModelError

try:
    from cosseratbench import Capability, Trajectory  # pyright: ignore[reportMissingImports]
    from cosseratbench.scenario import End, EndCondition  # pyright: ignore[reportMissingImports]
    from cosseratbench.solver import Diverged  # pyright: ignore[reportMissingImports]
except ImportError as error:
    raise ModelError(
        "cosseratbench is not installed", "pip install cosseratbench", "directrix.cosserat_bench"
    ) from error

Array = NDArray[np.float64]
STEP = 1e-3  # s


class DirectrixSolver:
    """Quadratic elements, the energy–momentum step; equilibria by statics.

    Parameters
    ----------
    time_step_scale
        Multiplies the step of a millisecond.
    """

    name = "directrix"
    backend_version = dx.__version__
    capabilities = frozenset({Capability.STRETCH, Capability.SHEAR})

    def __init__(self, time_step_scale: float = 1.0) -> None:
        self.step = STEP * time_step_scale

    def settings(self, scenario: Any, *, n_elements: int, n_frames: int) -> dict[str, Any]:
        """What the adapter chooses for a scenario."""
        if scenario.quasi_static:
            return {"method": "statics", "elements": n_elements // 2, "order": 2}
        step = _steps(scenario.duration / (n_frames - 1), self.step)[0]
        return {"method": "energy-momentum", "time_step": step, "elements": n_elements // 2, "order": 2}

    def run(self, scenario: Any, *, n_elements: int, n_frames: int) -> Any:
        """A quasi-static scenario is its start and then, in all later frames, its equilibrium.

        Raises
        ------
        NotImplementedError
            The scenario asks for what the module refuses.
        cosseratbench.solver.Diverged
            The run did not converge.
        """
        model = _model(scenario, n_elements)
        times = np.linspace(0.0, scenario.duration, n_frames)
        if scenario.quasi_static:
            result = dx.solve_static(model, steps=10)
            frames = np.r_[0, np.full(n_frames - 1, len(result.r) - 1)]
        else:
            step, every = _steps(scenario.duration / (n_frames - 1), self.step)
            result = dx.simulate(model, t_end=step * every * (n_frames - 1), dt=step, save_every=every)
            frames = np.arange(n_frames)
        if not result.success:
            raise Diverged(str(result.status), time=None if scenario.quasi_static else float(result.t[-1]))
        positions: list[Array] = []
        directors: list[Array] = []
        for k in range(len(scenario.rods)):
            mesh = result.mesh.rod(f"rod {k}")
            r, turned = result.r[frames][:, mesh.nodes], result.R[frames][:, mesh.nodes]
            d1 = np.einsum("fnij,nj->fni", turned, mesh.directors[:, :, 0])
            positions.append(r)
            directors.append(_across(r, d1))
        return Trajectory(times, tuple(positions), tuple(directors))


def _steps(interval: float, step: float) -> tuple[float, int]:
    """Step and number of them in an interval."""
    count = max(1, int(np.ceil(interval / step - 1e-9)))
    return interval / count, count


def _across(r: Array, d1: Array) -> Array:
    """(frames, elements, 3): the mean of the end nodes' first directors, made normal to the element."""
    axis = np.diff(r, axis=1)
    axis /= np.linalg.norm(axis, axis=2, keepdims=True)
    mean = d1[:, 1:] + d1[:, :-1]
    mean -= np.einsum("fei,fei->fe", mean, axis)[..., None] * axis
    return mean / np.linalg.norm(mean, axis=2, keepdims=True)


def _model(scenario: Any, n_elements: int) -> dx.Model:
    if scenario.obstacles or len(scenario.rods) > 1:
        raise NotImplementedError("contact is not handed over")
    if n_elements % 2:
        raise NotImplementedError("quadratic elements need an even number of segments")
    model = dx.Model().gravity(tuple(scenario.gravity)) if any(scenario.gravity) else dx.Model()
    for k, rod in enumerate(scenario.rods):
        model = _rod(model, f"rod {k}", rod, n_elements)
    return model


def _rod(model: dx.Model, name: str, rod: Any, n_elements: int) -> dx.Model:
    nodes = np.asarray(rod.centerline, dtype=float)
    span = float(np.linalg.norm(nodes[-1] - nodes[0]))
    length = float(np.linalg.norm(np.diff(nodes, axis=0), axis=1).sum())
    if abs(span - length) > 1e-9 * length or abs(rod.length - length) > 1e-9 * length:
        raise NotImplementedError("a rod that starts bent or stretched is not handed over")
    if rod.start_motion is not None or rod.end_motion is not None:
        raise NotImplementedError("driven ends are not handed over")
    m = rod.material
    section = dx.Section.circle(
        radius=rod.radius, E=m.youngs_modulus, nu=m.youngs_modulus / (2 * m.shear_modulus) - 1, rho=m.density
    )
    ends = (f"{name} start", f"{name} end")
    axis = dx.line(tuple(nodes[0]), tuple(nodes[-1]), d1=tuple(rod.directors(n_elements)[0]))
    model = model.rod(axis, section, name=name, ends=ends, elements=n_elements // 2, order=2)
    for end, node in zip(End, ends, strict=True):
        if rod.condition(end) is EndCondition.PINNED:
            model = model.pin(node)
        elif rod.condition(end) is EndCondition.CLAMPED:
            model = model.clamp(node)
    for load in rod.loads:
        model = model.force(ends[0] if load.at is End.START else ends[1], tuple(load.force))
    return model
