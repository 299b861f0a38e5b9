"""Who dissipated what: every source is booked by itself, and together they are what the ledger knows."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import directrix as dx
from directrix.audit import DynamicBooks
from directrix.cli import app
from directrix.newton import Books

STIFF = {"EA": 2500, "GA1": 950, "GA2": 900, "EI1": 10, "EI2": 12, "GJ": 8}
MASS = {"A_rho": 2.5, "I_rho1": 0.012, "I_rho2": 0.01}
PLAIN = dx.Section.from_moduli(**STIFF, **MASS)
DAMPED = dx.Section.from_moduli(**STIFF, **MASS, damping=0.02)
DT = 0.02


def machine() -> dx.Model:
    """Two damped rods and one that is not, with two dashpots."""
    model = dx.Model(name="machine")
    for k, (name, section) in enumerate((("one", DAMPED), ("two", PLAIN), ("three", DAMPED))):
        ends = (f"{name}.a", f"{name}.b")
        model = model.rod(dx.line((3 * k, 0, 0), (3 * k + 2, 0, 1)), section, name=name, ends=ends, elements=3)
    return (
        model.dashpot("one.b", "two.a", 2.0, name="left")
        .spring("two.b", "three.a", 30.0, damping=0.5, name="right")
        .velocity("one.a", (0, 1, 0.5))
        .velocity("three.b", (0.5, 0, -2), omega=(0, 1, 0))
    )


@pytest.fixture(scope="module")
def run() -> dx.Result:
    return dx.simulate(machine(), 2.0, DT, integrator=dx.EnergyDissipating(0.3, 0.1))


def test_the_sources_add_up_and_each_has_its_formula(run: dx.Result) -> None:
    by = run.energy.by_source
    assert set(by) == {
        "link 'left'", "link 'right'", "damping of rod 'one'", "damping of rod 'three'", "numerical dissipation",
    }  # fmt: skip
    assert all(taken[-1] > 0.0 and np.diff(taken).min() >= 0.0 for taken in by.values())
    np.testing.assert_allclose(sum(by.values()), run.energy.dissipated, rtol=1e-12)
    for name, c in (("left", 2.0), ("right", 0.5)):
        expected = np.cumsum(c * np.diff(run.link(name).length) ** 2 / DT)
        np.testing.assert_allclose(by[f"link {name!r}"][1:], expected, rtol=1e-9)
    for name in ("one", "three"):
        change = np.diff(run.rod(name).strain, axis=0)
        weight = run.mesh.rod(name).s[-1] / change.shape[1]  # two Gauss points an element, of equal weight
        taken = weight / DT * np.einsum("tsi,ij,tsj->t", change, DAMPED.damping, change)
        np.testing.assert_allclose(by[f"damping of rod {name!r}"][1:], np.cumsum(taken), rtol=1e-9)
    assert run.audit.passed and np.abs(run.energy.residual).max() <= 1e-12 * run.energy.total[0]


def test_a_source_is_there_only_where_it_can_take_something() -> None:
    quiet = dx.simulate(machine(), DT, DT, integrator=dx.EnergyMomentum())
    assert "numerical dissipation" not in quiet.energy.by_source
    rod = dx.Model().rod(dx.line((0, 0, 0), (1, 0, 0)), PLAIN, elements=2)
    still = dx.simulate(rod, DT, DT)
    assert still.energy.by_source == {} and "dissipated" not in str(still)
    pulled = rod.clamp("rod1.start").force("rod1.end", (0, 1, 0))
    assert dx.solve_static(pulled, steps=1).energy.by_source == {}


@pytest.mark.parametrize(("dt", "steps"), [(1.0, 2), (1e-3, 100)])
def test_a_stiff_frame_at_rest_has_closed_books(dt: float, steps: int) -> None:
    """Its stresses are rounded, and there is no momentum to which that would be small."""
    stiff = dx.Section.from_moduli(
        EA=4e7, GA1=2e7, GA2=2e7, EI1=1e7, EI2=1e7, GJ=1e7, A_rho=1.0, I_rho1=0.5, I_rho2=0.5
    )
    model = dx.Model().rod(dx.line((0, 0, 0), (0, 120, 0)), stiff, name="column", ends=("a", "b"), elements=5)
    model = model.rod(dx.line((0, 120, 0), (120, 130, 7)), stiff, name="beam", ends=("b", "c"), elements=5)
    audit = dx.simulate(model.clamp("a").fix("c", "x", "y", "z"), dt * steps, dt).audit
    assert audit.passed and len([e for e in audit.entries if e.claimed]) == 3, audit


@pytest.mark.open_ledger("a dashpot is made to give energy")
def test_a_source_that_gives_is_seen_though_energy_is_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    add = DynamicBooks.add

    def giving(self: DynamicBooks, books: Books, dt: float) -> None:
        taken = books.taken.copy()
        if not self.taken.any():
            taken[1] = -0.25
        add(self, books._replace(taken=taken), dt)

    monkeypatch.setattr(DynamicBooks, "add", giving)
    *kept, back = dx.simulate(machine(), 3 * DT, DT).audit.entries
    assert back.law == "dissipation" and not back.holds and all(entry.holds for entry in kept)
    assert back.value == pytest.approx(0.25 / float(back.relative_to), rel=1e-5)


def test_the_sources_are_printed_saved_and_in_the_summary(run: dx.Result, tmp_path: Path) -> None:
    again = dx.load(run.save(tmp_path / "run.vtkhdf"))
    assert list(again.energy.by_source) == list(run.energy.by_source)
    for name, taken in run.energy.by_source.items():
        np.testing.assert_array_equal(again.energy.by_source[name], taken)
        assert f"dissipated by {name}: {taken[-1]:.9g}" in str(again)


@pytest.mark.open_ledger(
    "the stresses are those of the midpoint rule, which does not keep the energy that it is said to"
)
def test_a_run_whose_ledger_does_not_close_ends_with_exit_code_4(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    CliRunner().invoke(app, ["examples", "free_flight", "--copy", str(tmp_path)])
    file = tmp_path / "free_flight.toml"
    file.write_text(file.read_text("utf-8").replace("t_end = 30", "t_end = 2"), "utf-8")
    assert CliRunner().invoke(app, ["run", str(file), "--no-view"]).exit_code == 0
    monkeypatch.setattr(dx.EnergyMomentum, "scheme", dx.Midpoint.scheme)
    done = CliRunner().invoke(app, ["run", str(file), "--no-view"])
    assert done.exit_code == 4 and "FAILED: energy" in done.output
    assert json.loads((tmp_path / "free_flight.run" / "run.json").read_text("utf-8"))["status"]["exit_code"] == 4
