"""An estimated error is close to the true one where the order can be seen, and says so where it cannot."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import directrix as dx
from directrix.cli import app
from directrix.integrators.conformance import _carried_rod  # pyright: ignore[reportPrivateUsage]
from directrix.refinement import _direction  # pyright: ignore[reportPrivateUsage]

SECTION = dx.Section.from_moduli(EA=2500, GA1=950, GA2=950, EI1=10, EI2=12, GJ=8, A_rho=2.5, I_rho1=0.012, I_rho2=0.01)


def beam() -> dx.Model:
    """A clamped beam that is pushed sideways, by one node per half."""
    return (
        dx.Model()
        .rod(dx.line((0, 0, 0), (3, 0, 0)), SECTION, name="rod", ends=("a", "b"), elements=8, order=1)
        .clamp("a")
        .force("b", (0, 1.0, 0.3))
    )


def test_the_error_of_a_mesh_is_that_against_a_fine_one() -> None:
    found = dx.refine(beam(), "node:b:displacement:y", steps=2)
    fine = beam().rods[0]
    exact = dx.solve_static(
        dx.Model().rod(fine.curve, SECTION, name="rod", ends=("a", "b"), elements=128, order=1).clamp("a")
        .force("b", (0, 1.0, 0.3)), steps=2
    ).node("b").displacement[-1, 1]  # fmt: skip
    assert found.step is None and found.mesh.asymptotic and found.mesh.order == pytest.approx(2.0, abs=0.2)
    assert found.mesh.error == pytest.approx(abs(found.value - exact), rel=0.1)
    assert f"order {found.mesh.order:.2f} observed" in str(found)
    two = dx.refine(beam(), "node:b:displacement:y", steps=2, levels=2)
    assert two.mesh.order is None and "two levels" in str(two)
    assert two.mesh.error == pytest.approx(found.mesh.error, rel=0.2)


def test_the_error_of_a_step_has_order_two() -> None:
    model = _carried_rod()
    found = dx.refine(
        model, lambda result: float(result.r[-1, -1, 1]), t_end=0.2, dt=0.00125, levels=3, tolerance=1e-12
    )
    assert found.step is not None and found.both is not None
    assert found.step.asymptotic and found.step.order == pytest.approx(2.0, abs=0.1)
    exact = dx.simulate(model, 0.2, 0.0001, save_every=5000, tolerance=1e-12).r[-1, -1, 1]
    assert found.step.error == pytest.approx(abs(found.value - exact), rel=0.3)


@pytest.mark.parametrize("values", [[1.0, 1.1, 1.0], [1.0, 1.1, 1.3], [1.0, 1.001, 0.9]])
def test_what_does_not_converge_is_not_given_an_order(values: list[float]) -> None:
    found = _direction("h", values, 2.0)
    assert not found.asymptotic and "not in the asymptotic range" in found.sentence
    assert found.error >= np.ptp(values) * 0.99


def test_what_refining_does_not_change_is_said_to_be_still() -> None:
    bar = dx.Model().rod(dx.line((0, 0, 0), (1, 0, 0)), SECTION, name="rod", ends=("a", "b"), elements=2).clamp("a")
    found = dx.refine(bar.force("b", (5.0, 0, 0)), "rod:rod:force:axial", steps=1)
    assert found.mesh.still and found.mesh.asymptotic and found.value == pytest.approx(5.0, rel=1e-2)


@pytest.mark.parametrize(
    ("words", "says"),
    [("node:b", "not a quantity"), ("nodes:b:r:x", "nodes"), ("node:b:r:w", "component 'w'"),
     ("node:q:r:x", "no node 'q'"), ("rod:rod:force:twist", "twist"), ("energy:heat", "heat")],
)  # fmt: skip
def test_words_that_are_no_quantity_are_refused(words: str, says: str) -> None:
    with pytest.raises(dx.ModelError, match=says) as error:
        dx.refine(beam(), words, steps=1, levels=2)
    assert error.value.fix


def test_the_command_line_refines_a_case(tmp_path: Path) -> None:
    CliRunner().invoke(app, ["examples", "free_flight", "--copy", str(tmp_path)])
    file = tmp_path / "free_flight.toml"
    file.write_text(file.read_text("utf-8").replace("t_end = 30", "t_end = 0.4"), "utf-8")
    done = CliRunner().invoke(app, ["refine", str(file), "--quantity", "node:A:r:z", "--levels", "2"])
    assert done.exit_code == 0 and done.output.count("error") == 3, done.output
    wrong = CliRunner().invoke(app, ["refine", str(file), "--quantity", "node:A"])
    assert wrong.exit_code == 2
