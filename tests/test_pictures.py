"""Pictures show the numbers of the result under the names of the tables, and refuse what is not there."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
import pytest
from fake_result import fake_result
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure
from typer.testing import CliRunner

from directrix.cli import app
from directrix.errors import ModelError
from directrix.modal import Modes
from directrix.pictures.command import options_of
from directrix.pictures.convergence import slope
from directrix.pictures.ledger import sides
from directrix.plot import Plots
from directrix.quantities import QUANTITIES, series
from directrix.result import Energy, Result
from directrix.trail import Iterations

matplotlib.use("Agg")

from matplotlib import pyplot

RESULT, STATIC = fake_result(order=2, elements=3), fake_result("static", order=2, elements=3)
OTHER = replace(RESULT, name="other", r=RESULT.r + 1.0, v=2.0 * RESULT.v, force=0.5 * RESULT.force)


@pytest.fixture(autouse=True)
def _closed() -> Any:
    yield
    pyplot.close("all")


def lines(ax: Any) -> dict[str, np.ndarray]:
    return {line.get_label(): np.asarray(line.get_ydata()) for line in ax.lines}


# ---- histories and orbits ----


def test_every_quantity_has_a_history() -> None:
    links = {"band": np.stack([RESULT.t, 2.0 * RESULT.t], -1)}
    result = replace(RESULT, links=links, contacts=links)
    for name, kind in QUANTITIES.items():
        of: Any = {"node": "B", "rod": ("mid", 0.4), "link": "band", "contact": "band"}.get(kind.owner)
        if kind.owner == "joint":
            continue
        ax: Any = Plots(result).history(of, name)
        values = series(result, name, of).values
        assert len(ax.lines) == values.shape[1]
        for line, column in zip(ax.lines, values.T, strict=True):
            np.testing.assert_array_equal(line.get_ydata(), column)
        assert ax.get_xlabel() == "t [time]" and kind.words.split()[0] in ax.get_ylabel()
        if any(kind.dimensions):
            assert "[" in ax.get_ylabel()
        pyplot.close("all")


def test_names_are_those_of_the_tables() -> None:
    frame = RESULT.to_pandas("rods")
    at = RESULT.mesh.rods[1].stations[2]
    rows = frame[(frame["rod"] == "mid") & (frame["s"] == at)]
    for name in ("N", "V2", "M1", "T", "Gamma3", "Omega1"):
        drawn = np.asarray(Plots(RESULT).history(("mid", float(at)), name).lines[0].get_ydata())
        np.testing.assert_allclose(drawn, rows[name], atol=1e-12)
    nodes = RESULT.to_pandas("nodes").query("name == 'C'")
    for name in ("r", "displacement", "rotation", "v"):
        drawn = Plots(RESULT).history("C", name, "y").lines[0].get_ydata()
        np.testing.assert_array_equal(drawn, nodes[f"{name}_y"])


def test_several_results_in_one_picture() -> None:
    ax: Any = Plots(RESULT).history("C", "v", "y", others={"twice": OTHER})
    drawn = lines(ax)
    np.testing.assert_array_equal(drawn["twice"], 2.0 * drawn["three-rod frame"])
    assert len({line.get_color() for line in ax.lines}) == 2
    ax = Plots(RESULT).history("C", others=[OTHER])
    assert list(lines(ax))[3] == "other, $u_x$"
    assert len({(line.get_color(), line.get_linestyle()) for line in ax.lines}) == 6
    flat = Figure().add_subplot()
    assert Plots(RESULT).orbit("C", others=OTHER, ax=flat) is flat  # type: ignore[arg-type]
    np.testing.assert_array_equal(flat.lines[3].get_xdata(), OTHER.node("C").r[:, 0])
    ax = Plots(STATIC).path("C", "y", others={"again": STATIC})
    assert len(ax.lines) == 2 and ax.get_legend() is not None


def test_orbits_and_phases() -> None:
    ax: Any = Plots(RESULT).orbit("C", ("r", "x"), ("r", "z"))
    np.testing.assert_array_equal(ax.lines[0].get_xdata(), RESULT.node("C").r[:, 0])
    np.testing.assert_array_equal(ax.lines[0].get_ydata(), RESULT.node("C").r[:, 2])
    assert ax.get_aspect() == 1.0 and ax.get_xlabel() == "position x [length]"
    ax = Plots(RESULT).orbit(("mid", 0.3), ("displacement", "x"), "kinetic")
    np.testing.assert_array_equal(ax.lines[0].get_ydata(), RESULT.energy.kinetic)
    with pytest.raises(ModelError, match="v has 3 components"):
        Plots(RESULT).orbit("C", y="v")


@pytest.mark.parametrize(
    ("draw", "says"),
    [
        (lambda p: p.history("C", "speed"), r"no history of 'speed'\n.*use one of r, displacement"),
        (lambda p: p.history(None, "v"), "v is that of a node"),
        (lambda p: p.history("C", "total"), "total is that of the whole run"),
        (lambda p: p.history("C", "force"), "this is no point of a rod"),
        (lambda p: p.history(("mid", 9.0), "N"), "no arclength s = 9"),
        (lambda p: p.history(("mid", 1.0), "reaction"), "not of a point"),
        (lambda p: p.history("C", "v", "N"), "no component of v 'N'"),
        (lambda p: p.history(None, "total", "x"), "total has no components"),
        (lambda p: p.history("band", "tension"), "no link 'band'"),
        (lambda p: p.history(None, "tension"), "name the link"),
        (lambda p: p.history("C", others=["run.vtkhdf"]), "is no result"),
        (lambda p: p.section_forces("leg"), "no rod 'leg'"),
        (lambda p: p.section_forces(components="Q"), "no component of a section 'Q'"),
        (lambda p: p.section_forces(components=()), "names nothing"),
        (lambda p: p.section_forces(components=("N", "M1", "Omega1")), "more than two units"),
        (lambda p: p.section_forces(at=99), "no saved instant 99"),
        (lambda p: p.diagram("M3"), "no component of a section 'M3'"),
        (lambda p: p.diagram(scale=float("nan")), "scale = nan"),
        (lambda p: p.newton([3]), "3 is no result"),
        (lambda p: p.convergence(), "nothing is known of the iterations"),
        (lambda p: p.refinement([RESULT, RESULT], "C"), "differ neither"),
    ],
)
def test_what_is_not_there_is_said(draw: Any, says: str) -> None:
    with pytest.raises(ModelError, match=says):
        draw(Plots(RESULT))


# ---- section forces ----


@pytest.mark.parametrize("order", [1, 2, 3])
def test_section_forces_go_through_the_stress_points(order: int) -> None:
    result = fake_result(order=order, elements=2)
    ax: Any = Plots(result).section_forces("mid", ("N",), at=5)
    s, drawn = (np.asarray(a) for a in ax.lines[0].get_data())
    rod = result.mesh.rods[1]
    many = len(s) // 2
    for e in range(2):
        own = slice(order * e, order * (e + 1))
        part = slice(many * e, many * (e + 1))
        law = np.polynomial.Polynomial.fit(rod.stations[own], result.rod("mid").force[5, own, 2], order - 1)
        np.testing.assert_allclose(drawn[part], law(s[part]), rtol=1e-9, atol=1e-9)
        assert (s[part][0], s[part][-1]) == (rod.s[order * e], rod.s[order * (e + 1)])


def test_section_forces_of_all_rods_and_both_units() -> None:
    ax: Any = Plots(RESULT).section_forces(envelope=True)
    twin = ax.figure.axes[1]
    assert "section force [force]" in ax.get_ylabel() and "[force·length]" in twin.get_ylabel()
    assert ax.get_xlabel() == "s [length]" and [t.get_text() for t in ax.texts] == ["left", "mid", "right"]
    names = [t.get_text() for t in ax.get_legend().get_texts()]
    assert names == ["$V_1$", "$V_2$", "$N$", "$M_1$", "$M_2$", "$T$"]
    ends = [float(np.asarray(line.get_xdata())[-1]) for line in twin.lines]
    assert sorted(set(ends)) == [3.0, 6.0, 9.0]
    band = next(c for c in twin.collections if isinstance(c, PolyCollection)).get_paths()[0].vertices
    m1 = np.asarray(twin.lines[0].get_ydata())
    assert band[:, 1].min() <= m1.min() and band[:, 1].max() >= m1.max()
    first = np.asarray(Plots(RESULT).section_forces("left", "M1", 3).lines[0].get_ydata())
    assert band[:, 1].min() <= first.min() and band[:, 1].max() >= first.max()
    for pen in (ax, twin):
        low, high = pen.get_ylim()
        assert low == -high  # both zeros at one height


def test_the_diagram_stands_on_the_deformed_axis() -> None:
    """Ordinates of M1 go along d2, as long as scale × moment."""
    ax: Any = Plots(RESULT).diagram("M1", 4, scale=0.1)
    rod, d = RESULT.mesh.rods[0], RESULT.directors("left")[4]
    hatch = [np.column_stack(line.get_data_3d()) for line in ax.lines if len(line.get_data_3d()[0]) == 2]
    foot, tip = hatch[0]
    np.testing.assert_allclose(foot, RESULT.r[4, rod.nodes[0]], atol=1e-12)
    forces = RESULT.rod("left").force[4, :2, 3]
    start = forces[0] - (forces[1] - forces[0]) * rod.stations[0] / (rod.stations[1] - rod.stations[0])
    np.testing.assert_allclose(tip - foot, 0.1 * start * d[0, :, 1], atol=1e-9)
    np.testing.assert_allclose(hatch[1][0], RESULT.r[4, rod.nodes[2]], atol=1e-12)  # where the first element ends
    flat = fake_result(planar=True, order=2)
    ax = Plots(flat).diagram("M2", 4)
    assert ax.name == "rectilinear" and "force·length" in ax.get_title()
    reach = max(
        np.linalg.norm(np.diff(np.column_stack(line.get_data()), axis=0)) for line in ax.lines
        if len(line.get_xdata()) == 2
    )  # fmt: skip
    size = np.linalg.norm(np.ptp(np.append(flat.r[4], flat.mesh.r0, axis=0), axis=0))
    assert reach <= 0.15 * size * (1 + 1e-9)
    Plots(replace(flat, force=0.0 * flat.force)).diagram("M2")


# ---- ledger ----


def ledgered() -> Result:
    """Loads give, a drive takes out, a damper dissipates; closes but for 1e-3."""
    t = RESULT.t
    load, drive, loss = 0.5 * t, -0.2 * t, 0.1 * t
    stored = RESULT.energy.stored
    kinetic = RESULT.energy.total[0] + load + drive - loss - stored + 1e-3 * (t > 1)
    by = {"loads": load, "drive": drive}
    return replace(RESULT, energy=Energy(kinetic, stored, load + drive, 0 * t, loss, {"damper": loss}, by))


def test_the_sides_of_the_ledger_differ_by_the_residual() -> None:
    result = ledgered()
    there, came = sides(result)
    assert list(there) == ["kinetic", "stored", "dissipated: damper", "given to drive"]
    assert list(came) == ["at the start", "work of loads"]
    assert all(np.all(a >= -1e-12) for side in (there, came) for a in side.values())
    difference = sum(there.values()) - sum(came.values())
    np.testing.assert_allclose(difference, result.energy.residual, atol=1e-12)
    ax: Any = Plots(result).ledger()
    tops = [c.get_paths()[0].vertices[:, 1].max() for c in ax.collections[:4]]
    assert max(tops) == pytest.approx(float(sum(there.values()).max()))
    lows = [c.get_paths()[0].vertices[:, 1].min() for c in ax.collections[4:]]
    assert min(lows) == pytest.approx(-float(sum(came.values()).max()))
    assert "residual, at most 1.0e-03" in [t.get_text() for t in ax.get_legend().get_texts()]
    assert ax.get_ylabel() == "energy [force·length]"
    Plots(STATIC).ledger()


# ---- convergence ----


def test_convergence_draws_the_last_tries() -> None:
    rows = np.array([[9.0, 1.0, 0.3, 0.1, 2], [1.0, 2.0, 0.1, 0.0, 2], [0.0, 3.0, 0.2, 0.4, 1]])
    trail = Iterations(np.array([4, 5]), np.array([True, False]), np.array([2, 1]), rows)
    result = replace(RESULT, trail=trail)
    for of, lines in (("force", ([9.0, 1.0], [])), ("turn", ([0.1], [0.4])), (None, ([0.1], [0.4]))):
        ax: Any = Plots(result).convergence(of)
        assert tuple(line.get_ydata().tolist() for line in ax.lines[:2]) == lines
        said = [text.get_text() for text in ax.get_legend().get_texts()]
        assert said[:2] == ["step 5, solved", "step 6, not solved"]
        assert said[2] == f"last furthest from balance at {RESULT.mesh.label(1)}"
    assert len(Plots(result).convergence(tries=1).lines[0].get_ydata()) == 1


def test_newton_counts_iterations() -> None:
    ax: Any = Plots(RESULT).newton({"more": replace(RESULT, iterations=np.array([3, 5]))})
    assert [t.get_text() for t in ax.get_legend().get_texts()] == [
        "three-rod frame, 156 in all, 4.00 a step", "more, 8 in all, 4.00 a step",
    ]  # fmt: skip
    with pytest.raises(ModelError, match="no step was taken"):
        Plots(replace(RESULT, iterations=np.zeros(0, np.int64))).newton()


@pytest.mark.parametrize("by", ["dt", "elements"])
def test_refinement_shows_the_order(by: str) -> None:
    def run(k: int) -> Result:
        size = 0.1 / 2**k if by == "dt" else 4 * 2**k
        error = np.full(3, 0.01 / 4**k)  # second order
        return replace(RESULT, r=RESULT.r + error, info={by: size, "elements" if by == "dt" else "dt": 8})

    runs = [run(k) for k in (2, 0, 1)]
    exact = float(RESULT.node("C").displacement[-1, 0])
    ax: Any = Plots(runs[0]).refinement(runs[1:], "C", component="x", exact=exact)
    x, y = ax.lines[0].get_data()
    np.testing.assert_allclose(y, [0.01, 0.0025, 0.000625], rtol=1e-9)
    np.testing.assert_allclose(x, [0.1, 0.05, 0.025] if by == "dt" else [4, 8, 16])
    assert ax.texts[0].get_text() == "order 2.00" and ax.get_xscale() == ax.get_yscale() == "log"
    ax = Plots(runs[0]).refinement(runs[1:], quantity=lambda result: result.r[-1, 0])
    assert len(ax.lines[0].get_data()[0]) == 2 and "against the finest" in ax.get_title()
    assert slope(np.array([1.0, 2.0]), np.array([1.0, 8.0])) == pytest.approx(3.0)
    with pytest.raises(ModelError, match="2 results show no convergence"):
        Plots(runs[0]).refinement(runs[1:2], "C")
    with pytest.raises(ModelError, match="no error to draw"):
        Plots(runs[0]).refinement([runs[1], runs[2]], quantity=lambda _: 1.0)


# ---- modes ----


def modes_of(result: Result, planar: bool) -> Modes:
    n, stations = len(result.mesh.r0), result.strain.shape[1]
    shapes = np.zeros((3, n, 6))
    for k in range(3):
        shapes[k, :, 1 if planar else k] = np.sin((k + 1) * np.arange(n))
    nothing = np.zeros((3, stations, 6))
    state = result.mesh.r0, np.tile(np.eye(3), (n, 1, 1)), nothing[0], nothing[0]
    return Modes(
        np.array([1.0, 2.5, 0.0]), np.array([39.0, 246.0, -1.0]), shapes, result.mesh, np.array([6j, 15j, 1.0]),
        np.array([0.0, 0.02, 0.0]), np.zeros((3, 3)), nothing, nothing, state,
    )  # fmt: skip


@pytest.mark.parametrize("planar", [True, False])
def test_modes_are_drawn_with_their_frequencies(planar: bool) -> None:
    result = fake_result(planar=planar)
    modes = modes_of(result, planar)
    axes = modes.plot()
    assert [ax.name for ax in axes] == ["rectilinear" if planar else "3d"] * 3
    assert [ax.get_title() for ax in axes] == [
        "mode 1: 1 per unit of time", "mode 2: 2.5 per unit of time\ndamping ratio 0.02", "mode 3: does not swing",
    ]  # fmt: skip
    if planar:
        swings = [np.column_stack(line.get_data()) for line in axes[0].lines]
        np.testing.assert_allclose(swings[3], modes.motion(1, None, 3).r[0, result.mesh.rods[0].nodes, :2])
    given = [Figure().add_subplot(projection="3d") for _ in range(2)]
    assert modes.plot(2, axes=given) == tuple(given)
    with pytest.raises(ModelError, match="3 modes do not fit 2 axes"):
        modes.plot(3, axes=given)


# ---- the command ----


@pytest.mark.parametrize(
    ("picture", "given", "options", "name"),
    [
        ("ledger", {}, {}, "ledger"),
        ("history", {"quantity": "total"}, {"of": None, "quantity": "total", "component": None}, "history-total"),
        (
            "history", {"rod": "mid", "s": 0.5, "component": "N"},
            {"of": ("mid", 0.5), "quantity": "force", "component": "N"}, "history-mid-0.5-N-force",
        ),
        ("orbit", {"node": "B", "over": "r.x"}, {"of": "B", "x": ("r", "x")}, "orbit-B-r.x"),
        ("diagram", {"component": "M2", "at": 3}, {"component": "M2", "at": 3}, "diagram-M2-3"),
        ("path", {"node": "B"}, {"node": "B", "component": "y"}, "path-B"),
    ],
)  # fmt: skip
def test_options_become_arguments(picture: str, given: Any, options: Any, name: str) -> None:
    assert options_of(picture, given, RESULT) == (options, name)


def command(*args: object) -> tuple[int, str]:
    done = CliRunner().invoke(app, [str(a) for a in args])
    return done.exit_code, done.stdout + done.stderr


def test_the_command_draws(tmp_path: Path) -> None:
    saved = RESULT.save(tmp_path / "a.vtkhdf")
    other = OTHER.save(tmp_path / "b.vtkhdf")
    for args, name in (
        (["--what", "history", "--node", "B", "--quantity", "v", "--beside", other], "history-B-v.png"),
        (
            ["section_forces", "--rod", "mid", "--component", "M1", "--at", 3, "--envelope"],
            "section_forces-mid-M1-3.png",
        ),
        (["orbit", "--node", "B", "--over", "r.x", "--quantity", "v.x"], "orbit-B-v.x-r.x.png"),
    ):
        assert command("plot", saved, *args) == (0, f"wrote {tmp_path / name}\n")
        assert (tmp_path / name).read_bytes().startswith(b"\x89PNG")
    assert command("plot", saved, "--what", "diagram", "--out", tmp_path / "d.pdf")[0] == 0
    assert (tmp_path / "d.pdf").read_bytes().startswith(b"%PDF")
    for args, says in (
        ([], "what to draw has to be said once"),
        (["energy", "--what", "energy"], "said once"),
        (["newton", "--at", "2"], "newton takes no --at [DX400]\n  fix: it takes --beside"),
        (["history", "--rod", "mid"], "--rod and --s together"),
        (["orbit"], "orbit: of which node?"),
        (["history", "--node", "B", "--quantity", "speed"], "no history of 'speed'"),
    ):
        code, said = command("plot", saved, *args)
        assert code == 2 and says in said, said
