"""The model is a value; what cannot be right is refused by name."""

from __future__ import annotations

import numpy as np
import pytest

import directrix as dx

SECTION = dx.Section.from_moduli(EA=1e3, GA1=1e3, GA2=1e3, EI1=1.0, EI2=1.0, GJ=1.0, A_rho=1.0, I_rho1=0.1, I_rho2=0.1)
MASSLESS = dx.Section.from_moduli(EA=1e3, GA1=1e3, GA2=1e3, EI1=1.0, EI2=1.0, GJ=1.0)
LINE = dx.line((0, 0, 0), (1, 0, 0))


def rod(**more) -> dx.Model:
    return dx.Model().rod(LINE, SECTION, **{"name": "beam", "ends": ("A", "B"), **more})


def held(**more) -> dx.Model:
    return rod(**more).clamp("A")


def test_a_method_returns_a_new_model() -> None:
    one = rod()
    two = one.clamp("A")
    assert one.supports == () and len(two.supports) == 1 and two != one
    assert one.rod(dx.line((1, 0, 0), (2, 0, 0)), SECTION).rods[1].ends == ("rod2.start", "rod2.end")


def test_touching_ends_of_other_names_are_noted_and_not_joined() -> None:
    model = rod().rod(dx.line((1, 0, 0), (2, 0, 0)), SECTION, name="next", ends=("C", "D"))
    assert any("'B' and 'C'" in note and "not joined" in note for note in model.notes())
    with pytest.raises(dx.ModelError, match="next"):
        dx.solve_static(model.clamp("A").force("B", (0, 0, 1)))


def test_a_junction_at_any_angle_carries_force_and_moment() -> None:
    """An L in one piece: tip load P at the end of leg two; root moment is P × arm."""
    model = (
        dx.Model()
        .rod(LINE, SECTION, name="one", ends=("A", "B"), elements=4)
        .rod(dx.line((1, 0, 0), (1.5, 0.5, np.sqrt(0.5))), SECTION, name="two", ends=("B", "C"), elements=4)
        .clamp("A")
        .force("C", (0, 1e-4, 0))
    )
    result = dx.solve_static(model, steps=1)
    assert result.success and result.info["solver"] == "chain"
    reaction = result.node("A").reaction[-1]
    np.testing.assert_allclose(reaction[:3], [0, -1e-4, 0], atol=1e-12)
    np.testing.assert_allclose(reaction[3:], -np.cross([1.5, 0.5, np.sqrt(0.5)], [0, 1e-4, 0]), rtol=1e-3, atol=1e-9)


def test_named_interior_nodes_fall_on_the_mesh_or_move_it_and_say_so() -> None:
    on = dx.solve_static(held(elements=5, nodes={"P": 0.2}), steps=1)
    assert on.mesh.notes == () and on.node("P").r[0] == pytest.approx([0.2, 0, 0])
    off = dx.solve_static(held(elements=5, nodes={"P": 0.33}).split("beam", {"Q": 0.5}), steps=1)
    assert off.node("P").r[0] == pytest.approx([0.33, 0, 0]) and off.node("Q").r[0] == pytest.approx([0.5, 0, 0])
    assert "rod 'beam': the mesh was fitted" in off.mesh.notes[0]
    assert any("fitted" in note for note in off.audit.notes)


def test_kinks_of_a_polyline_get_nodes() -> None:
    model = (
        dx.Model()
        .rod(dx.polyline([(0, 0, 0), (1, 0, 0), (1, 2, 0)]), SECTION, name="bent", elements=4)
        .clamp("bent.start")
    )
    result = dx.solve_static(model, steps=1)
    assert np.any(np.all(np.isclose(result.mesh.r0, (1, 0, 0)), axis=1))


@pytest.mark.parametrize(
    ("make", "names"),
    [
        (lambda: dx.Model().check(), "no rod"),
        (lambda: rod(name=""), "name of a rod"),
        (lambda: rod().rod(LINE, SECTION, name="beam"), "two rods called 'beam'"),
        (lambda: rod(ends=("A", "A")), "rod 'beam': both ends"),
        (lambda: rod(ends="AB"), "rod 'beam': ends"),
        (lambda: rod(elements=0), "rod 'beam': elements"),
        (lambda: rod(elements=2.5), "rod 'beam': elements"),
        (lambda: rod(order=4), "rod 'beam': order"),
        (lambda: rod(order=1, points=5), "rod 'beam': points"),
        (lambda: dx.Model().rod("line", SECTION, name="beam"), "rod 'beam': 'line' is not a curve"),
        (lambda: dx.Model().rod(LINE, 3.0, name="beam"), "rod 'beam': 3.0 is not a section"),
        (lambda: rod(nodes={"P": 1.5}), "rod 'beam': node 'P'"),
        (lambda: rod(nodes={"A": 0.5}), "two nodes 'A'"),
        (lambda: rod().split("beem", {"P": 0.5}), "did you mean 'beam'"),
        (lambda: rod().clamp("Z").check(), "no node 'Z' for the support"),
        (lambda: rod().force("C", (1, 0, 0)).check(), "no node 'C' for the load"),
        (lambda: rod().force("A", (1, 0)), "force on node 'A'"),
        (lambda: rod().force("A", (1, 0, float("nan"))), "force on node 'A'"),
        (lambda: rod().moment("A", "up"), "moment on node 'A'"),
        (lambda: rod().force("A", lambda t: (t, 0)).check(), "force 'A' at t = 0"),
        (lambda: rod().force("A", lambda t: 1 / t).check(), "force 'A': the function fails"),
        (lambda: rod().distributed("bean", (0, 0, 1)).check(), "no rod 'bean'"),
        (lambda: rod().gravity((0, 0, -9.81)).gravity((0, 0, 1)), "gravity is given twice"),
        (lambda: dx.Model().rod(LINE, MASSLESS).gravity((0, 0, -9.81)).check(), "no rod has mass"),
        (lambda: rod().fix("A"), "nothing is fixed"),
        (lambda: rod().fix("A", "X"), "component of node 'A'"),
        (lambda: rod().fix("A", "rz"), "rz alone"),
        (lambda: rod().clamp("A").pin("A").check(), "node 'A' is held twice in x, y, z"),
        (lambda: rod().clamp("A").prescribe("A", rotation=(0, 0, 1)).check(), "node 'A' is held twice in rx"),
        (lambda: rod().prescribe("A"), "nothing is prescribed"),
        (lambda: rod().velocity("A", (1, 0, 0)).velocity("A", (0, 1, 0)), "node 'A' has two"),
        (lambda: rod().clamp("A").velocity("A", (1, 0, 0)).check(), "node 'A' is held in x"),
        (
            lambda: rod().rod(dx.line((2, 0, 0), (3, 0, 0)), SECTION, name="far", ends=("B", "C")).check(),
            "node 'B' is at .* on rod 'beam'",
        ),
        (lambda: dx.solve_static(rod()), "rod 'beam' .* no support"),
        (
            lambda: dx.simulate(dx.Model().rod(LINE, MASSLESS, name="beam"), 1.0, 0.1),
            "rod 'beam' has no mass",
        ),
        (lambda: dx.solve_static(held(), steps=0), "steps"),
        (lambda: dx.solve_static(held(), steps=1, rotation="euler"), "rotation"),
        (lambda: dx.solve_static(held(), start=dx.solve_static(held(elements=3))), "another mesh"),
        (lambda: dx.solve_static(held()).node("Z"), "no node 'Z'"),
        (lambda: dx.solve_static(held()).rod("Z"), "no rod 'Z'"),
    ],
)
def test_models_that_cannot_be_are_refused_by_name(make, names: str) -> None:
    with pytest.raises(dx.ModelError, match=names) as error:
        make()
    assert error.value.fix and "\n  fix: " in str(error.value)


def test_a_load_that_turns_nan_on_the_way_stops_the_run_and_keeps_it() -> None:
    model = held().force("B", lambda t: (0, 0, float("nan") if t > 0.3 else 0.0))
    for result in (dx.simulate(model, 1.0, 0.1), dx.solve_static(model, steps=10)):
        assert not result.success and result.status.code == "bad_input"
        assert "force on node 'B'" in result.status.sentence
        assert 0.2 < result.t[-1] < 0.4 and np.all(np.isfinite(result.r))
