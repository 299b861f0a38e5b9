"""Models with one fault each: what makes them, and what the message must name."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any
from unittest.mock import patch

import numpy as np

import directrix as dx

__all__ = ["FAULTY", "Case"]

Case = tuple[str, Callable[[], object], tuple[str, ...]]

SECTION = dx.Section.from_moduli(EA=1e5, GA1=4e4, GA2=4e4, EI1=10, EI2=10, GJ=8, A_rho=1, I_rho1=1e-3, I_rho2=1e-3)
MODULI = dict(EA=1e5, GA1=4e4, GA2=4e4, EI1=10.0, EI2=10.0, GJ=8.0)
NAN, INF = float("nan"), float("inf")
O, X, Y, Z = (0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)


def line(*given: tuple[str, tuple[float, ...], tuple[float, ...], str, str]) -> dx.Model:
    """Rods (name, from, to, first node, last node)."""
    model = dx.Model()
    for name, a, b, first, last in given:
        model = model.rod(dx.line(a, b), SECTION, name=name, ends=(first, last), elements=4)
    return model


def bar(section: dx.Section = SECTION, size: float = 1.0) -> dx.Model:
    axis = dx.line(O, (size, 0, 0))
    return dx.Model().rod(axis, section, name="bar", ends=("a", "b"), nodes={"m": 0.5}, elements=4)


def mast() -> dx.Model:
    return line(("mast", O, (0, 0, 2), "foot", "top"))


def tower() -> dx.Model:
    """Twelve members: three storeys of two posts, a head and a brace."""
    rods: list[tuple[str, tuple[float, ...], tuple[float, ...], str, str]] = []
    for k in range(3):
        low, high = (0.0, 0.0, float(k)), (0.0, 0.0, k + 1.0)
        right, above = (1.0, 0.0, float(k)), (1.0, 0.0, k + 1.0)
        rods += [
            ("mast" if k == 0 else f"left{k}", low, high, f"l{k}", f"l{k + 1}"),
            (f"right{k}", right, above, f"r{k}", f"r{k + 1}"),
            (f"head{k}", high, above, f"l{k + 1}", f"r{k + 1}"),
            (f"brace{k}", low, above, f"l{k}", f"r{k + 1}"),
        ]
    return line(*rods)


def two() -> dx.Model:
    """Two rods in line with a gap, the first clamped."""
    return line(("one", O, X, "a", "b"), ("two", (1.5, 0, 0), (2.5, 0, 0), "c", "d")).clamp("a")


def joined() -> dx.Model:
    """Two rods end to end, the first clamped, for a joint between b and c."""
    return line(("one", O, X, "a", "b"), ("two", X, (2, 0, 0), "c", "d")).clamp("a")


def linkage() -> dx.Model:
    """Four bars, the ground one of them, with a freedom left."""
    bars = line(
        ("crank", O, Z, "a", "b"), ("coupler", Z, (2, 0, 1), "c", "d"), ("rocker", (2, 0, 1), (2, 0, 0), "e", "f")
    )
    bars = bars.hinge("a", axis=Y).hinge("b", "c", axis=Y)
    return bars.spherical("d", "e").cylindrical("f", axis=Y)


def static(model: dx.Model) -> object:
    """All that a check says."""
    return "\n".join(map(str, model.check(static=True)))


def dynamic(model: dx.Model) -> object:
    return "\n".join(map(str, model.check(dynamic=True)))


def run(model: dx.Model, **how: Any) -> object:
    return str(dx.solve_static(model, **how).status)


def scaled(size: float, young: float) -> dx.Model:
    """A bar on a hinge about y, of any size."""
    section = dx.Section.circle(radius=0.01 * size, E=young, nu=0.3, rho=1.0)
    return bar(section, size).fix("a", "x", "y", "z", "rx", "rz")


def yielding(force: float) -> dx.Model:
    """Bends with at most a unit moment, whatever the curvature."""

    def energy(strain: Any) -> Any:
        shear, other, axial, bent, sideways, twist = strain
        stiff = 50.0 * (shear * shear + other * other + axial * axial + twist * twist)
        return stiff + (1.0 + bent * bent) ** 0.5 + (1.0 + sideways * sideways) ** 0.5

    soft = dx.Section.hyperelastic(energy, metric=np.eye(6))
    hose = dx.Model().rod(dx.line(O, X), soft, name="hose", ends=("a", "b"), elements=4)
    return hose.clamp("a").force("b", (0, force, 0))


def struck(cuts: int) -> object:
    """A blow that a step of Newmark's cannot follow, cut so many times at most."""
    model = bar().clamp("a").force("b", (0, 1e6, 0))
    with patch("directrix.stepping.MOST_CUTS", cuts):
        return str(dx.simulate(model, 1.0, 0.1, integrator=dx.Newmark()).status)


def arch() -> dx.Model:
    axis = dx.arc((-1, 0, 0), (0, 0, 0.5), X)
    return dx.Model().rod(axis, SECTION, name="arch", ends=("l", "r"), nodes={"crown": 0.5}, elements=4)


def rolled(elements: int) -> dx.Model:
    """A strip rolled up to a full circle by elements too few for it."""
    axis = dx.line(O, X, d1=Y)
    strip = dx.Model().rod(axis, SECTION, name="strip", ends=("a", "b"), elements=elements, order=1)
    return strip.clamp("a").moment("b", (0, 0, 2.0 * np.pi * 10.0))


MOTIONS: list[Case] = [
    ("nothing held", lambda: static(bar()), ("rod 'bar' can move freely", "rigid body", "no support")),
    ("second part", lambda: static(two()), ("rod 'two'", "no support")),
    ("tower", lambda: static(tower()), ("part 'mast' (12 members)", "no support")),
    (
        "tower on one foot",
        lambda: static(tower().pin("l0")),
        ("part 'mast' (12 members)", "rotation about every axis", "node 'l0'", "'r3'"),
    ),
    (
        "tower on two feet",
        lambda: static(tower().pin("l0").pin("r0")),
        ("part 'mast' (12 members)", "rotation about x", "node 'l0'", "largest at nodes 'l3', 'r3'"),
    ),
    ("mast on a ball", lambda: static(mast().pin("foot")), ("rod 'mast'", "every axis", "node 'foot'", "'top'")),
    (
        "mast on a hinge",
        lambda: static(mast().fix("foot", "x", "y", "z", "rx", "rz")),
        ("rod 'mast'", "rotation about y through node 'foot' (0, 0, 0)", "largest at node 'top'"),
    ),
    (
        "mast that falls over",
        lambda: static(mast().fix("foot", "x", "y", "z", "rx", "rz").gravity((0, 0, -9.8))),
        ("rod 'mast'", "rotation about y", "'foot'", "topple"),
    ),
    (
        "pushed on a hinge",
        lambda: static(mast().fix("foot", "x", "y", "z", "rx", "rz").force("top", X)),
        ("rod 'mast'", "rotation about y", "'foot'", "push"),
    ),
    ("spin between pins", lambda: static(bar().pin("a").pin("b")), ("rod 'bar'", "rotation about x", "own axis")),
    (
        "spin under load",
        lambda: static(bar().pin("a").pin("b").distributed("bar", (0, 0, -1))),
        ("rod 'bar'", "rotation about x", "own axis"),
    ),
    (
        "spin of a slanted rod",
        lambda: static(line(("stay", O, (1, 1, 0), "a", "b")).pin("a").pin("b")),
        ("rod 'stay'", "rotation about (0.7071, 0.7071, 0)", "own axis"),
    ),
    ("slider", lambda: static(bar().fix("a", "y", "z", "rx", "ry", "rz")), ("rod 'bar'", "translation along x", "'a'")),
    (
        "slider that turns",
        lambda: static(bar().fix("a", "x", "y", "rx", "ry")),
        ("rod 'bar'", "translation along z", "rotation about z through node 'a'", "'b'"),
    ),
    ("turns alone held", lambda: static(bar().fix("a", "rx", "ry", "rz")), ("rod 'bar'", "in every direction")),
    (
        "sheet on ice",
        lambda: static(tower().fix("l0", "y").fix("r0", "y").fix("l3", "y")),
        ("part 'mast'", "translation in the plane normal to y", "rotation about y"),
    ),
    (
        "hung from one point",
        lambda: static(two().spring("c", (1.5, 0, 2), 9.0).spring("c", (1.5, 2, 0), 9.0).spring("c", (0, 0, 0), 9.0)),
        ("rod 'two'", "rotation about every axis", "node 'c'", "'d'"),
    ),
    (
        "springs that meet",
        lambda: static(
            tower().spring("l0", (9, 9, 9), 1.0).spring("l3", (9, 9, 9), 1.0).spring("r0", (9, 9, 9), 1.0)
        ),
        ("part 'mast'", "every axis through (9, 9, 9)"),
    ),
    ("on one spring", lambda: static(two().spring("b", "c", 9.0)), ("rod 'two'", "normal to x", "node 'c'", "'d'")),
    (
        "two that go together",
        lambda: static(
            line(("one", O, X, "a", "b"), ("two", (1, 0, 1), (2, 0, 1), "c", "d"))
            .fix("a", "x", "y", "z", "rx", "rz").fix("c", "x", "y", "z", "rx", "rz").spring("b", "d", 9.0)
        ),
        ("rod 'one' can move freely", "with it rod 'two'", "rotation about y", "'a'", "'c'"),
    ),
    (
        "by a dashpot alone",
        lambda: static(bar().fix("a", "x", "y", "z", "rx", "rz").dashpot("b", (1, 0, 1), 2.0, name="damper")),
        ("rod 'bar'", "rotation about y", "'b'"),
    ),
    (
        "by a slack cable",
        lambda: static(bar().fix("a", "x", "y", "z", "rx", "rz").cable("b", Z, 1e3, length=2.0, name="stay")),
        ("rod 'bar'", "rotation about y", "until link 'stay' is taut"),
    ),
    (
        "by two slack cables",
        lambda: static(
            two().cable("c", "b", 1e3, length=2.0, name="left").cable("d", "b", 1e3, length=2.0, name="right")
            .spring("c", (1.5, 0, 3), 1.0).spring("c", (1.5, 3, 0), 1.0).spring("d", (2.5, 0, 3), 1.0)
            .spring("d", (2.5, 3, 0), 1.0).spring("c", (1.5, 1, 1), 1.0, offset_a=(0, 0.2, 0))
        ),
        ("rod 'two'", "translation along x", "link 'left' and link 'right' are taut"),
    ),
    (
        "not joined",
        lambda: static(line(("one", O, X, "a", "b"), ("two", X, (2, 0, 0), "c", "d")).clamp("a")),
        ("rod 'two'", "nodes 'c' and 'b' are at the same place and not joined: give them one name"),
    ),
    (
        "nearly joined",
        lambda: static(line(("one", O, X, "a", "b"), ("two", (1.0002, 0, 0), (2, 0, 0), "c", "d")).clamp("a")),
        ("rod 'two'", "'c' and 'b' are 0.0002 apart"),
    ),
    (
        "end on a rod",
        lambda: static(line(("beam", O, X, "a", "b"), ("post", (0.3, 0, 0), (0.3, 0, 1), "c", "d")).clamp("a")),
        ("rod 'post'", "node 'c' lies on rod 'beam'", "0.3"),
    ),
    (
        "rod on an end",
        lambda: static(line(("post", O, Z, "a", "b"), ("beam", (-1, 0, 1), (3, 0, 1), "c", "d")).clamp("a")),
        ("rod 'beam'", "node 'b' lies on rod 'beam'", "0.25"),
    ),
    (
        "a pinned link of no length",
        lambda: static(line(("one", O, X, "a", "b"), ("two", X, (2, 0, 0), "c", "d")).clamp("a").spring("b", "c", 9.0)),
        ("rod 'two'", "every axis through node 'c'", "one name"),
    ),
    (
        "arch that falls aside",
        lambda: static(
            arch().pin("l").pin("r").force("crown", (0, 0, -1))
        ),
        ("rod 'arch'", "rotation about x", "node 'l'", "'crown'", "topple"),
    ),
    ("small and soft", lambda: static(scaled(1e-6, 1e2)), ("rod 'bar'", "rotation about y", "'a'", "'b'")),
    ("small and stiff", lambda: static(scaled(1e-6, 1e12)), ("rod 'bar'", "rotation about y", "'a'", "'b'")),
    ("large and soft", lambda: static(scaled(1e4, 1e2)), ("rod 'bar'", "rotation about y", "'a'", "'b'")),
    ("large and stiff", lambda: static(scaled(1e4, 1e12)), ("rod 'bar'", "rotation about y", "'a'", "'b'")),
    ("a run says it as well", lambda: run(mast().pin("foot")), ("rod 'mast'", "every axis", "'foot'")),
    (
        "buckling of what is free",
        lambda: dx.buckling(mast().pin("foot").force("top", (0, 0, -1))),
        ("rod 'mast'", "every axis", "'foot'"),
    ),
    (
        "a pendulum is told so",
        lambda: run(line(("bob", O, (0, 0, -1), "a", "b")).pin("a").gravity((0, 0, -9.8))),
        ("reached load factor 1", "rod 'bob' is held by nothing but the tension that the loads cause", "'a'"),
    ),
]  # fmt: skip

VALUES: list[Case] = [
    ("no torsion", lambda: dx.Section.from_moduli(**{**MODULI, "GJ": 0.0}), ("GJ = 0",)),
    ("no extension", lambda: dx.Section.from_moduli(**{**MODULI, "EA": 0.0}), ("EA = 0",)),
    (
        "no bending in a matrix",
        lambda: dx.Section(stiffness=np.diag([1.0, 1, 1, 0, 1, 1]), order="shear-axial"),
        ("bending 1 (EI1) costs no energy",),
    ),
    (
        "no torsion in a matrix",
        lambda: dx.Section(stiffness=np.diag([1.0, 1, 1, 0, 1, 1]), order="axial-first"),
        ("torsion (GJ) costs no energy",),
    ),
    (
        "coupled to nothing",
        lambda: dx.Section(stiffness=np.eye(6) + np.eye(6, k=1) + np.eye(6, k=-1), order="shear-axial"),
        ("costs no energy",),
    ),
    (
        "as good as no torsion",
        lambda: static(bar(dx.Section.from_moduli(**{**MODULI, "GJ": 1e-12})).clamp("a")),
        ("torsion stiffness of rod 'bar'",),
    ),
    ("stiffness is no number", lambda: dx.Section.from_moduli(**{**MODULI, "EI1": NAN}), ("EI1", "nan")),
    ("infinite modulus", lambda: dx.Section.circle(radius=0.1, E=INF, nu=0.3), ("E = inf",)),
    ("force is no number", lambda: bar().force("b", (0, NAN, 0)), ("force on node 'b'", "component y")),
    ("infinite load along", lambda: bar().distributed("bar", (0, 0, INF)), ("rod 'bar'", "component z")),
    ("infinite gravity", lambda: bar().gravity((0, 0, -INF)), ("gravity", "component z")),
    ("place is no number", lambda: dx.line(O, (1, NAN, 0)), ("component y", "nan")),
    ("spring is no number", lambda: bar().spring("b", Z, NAN, name="tie"), ("link 'tie'", "stiffness")),
    ("infinite cable", lambda: bar().cable("b", Z, 1.0, length=INF, name="tie"), ("link 'tie'", "length")),
    ("inertia is no number", lambda: bar().rigid_body("b", 1.0, np.diag([1, NAN, 1])), ("node 'b'", "inertia")),
    ("displacement is no number", lambda: bar().prescribe("b", displacement=(NAN, 0, 0)), ("node 'b'", "component x")),
    ("velocity is no number", lambda: bar().velocity("b", (0, 0, NAN)), ("velocity of node 'b'", "component z")),
    ("no mass", lambda: dynamic(bar(dx.Section.from_moduli(**MODULI))), ("rod 'bar' has no mass",)),
    (
        "no polar inertia",
        lambda: dynamic(bar(dx.Section.from_moduli(**MODULI, A_rho=1.0))),
        ("rod 'bar' has no rotary inertia",),
    ),
    (
        "no inertia about one axis",
        lambda: dynamic(bar(dx.Section.from_moduli(**MODULI, A_rho=1.0, I_rho1=1.0))),
        ("sections of rod 'bar'", "about one of their axes"),
    ),
    ("a body without mass", lambda: bar().point_mass("b", 0.0), ("node 'b'", "mass = 0")),
    ("held twice", lambda: static(bar().clamp("a").fix("a", "y")), ("node 'a' is held twice in y",)),
    (
        "held and moved",
        lambda: static(bar().clamp("a").prescribe("a", displacement=X)),
        ("node 'a' is held twice in x, y, z",),
    ),
    (
        "moved twice",
        lambda: static(bar().prescribe("a", displacement=X).prescribe("a", displacement=Y)),
        ("node 'a' is held twice",),
    ),
    ("held and thrown", lambda: dynamic(bar().clamp("a").velocity("a", X)), ("node 'a' is held in x", "velocity")),
    ("load on a support", lambda: static(bar().clamp("a").force("a", Y)), ("force on node 'a' acts on y", "support")),
    (
        "moment on a support",
        lambda: static(bar().clamp("a").moment("a", Z)),
        ("moment on node 'a' acts on rz", "a support holds"),
    ),
    (
        "moved and loaded",
        lambda: static(bar().clamp("a").prescribe("b", displacement=X).force("b", Y)),
        ("force on node 'b' acts on y", "prescribed motion moves"),
    ),
    ("one rotation", lambda: bar().fix("a", "x", "rz"), ("node 'a'", "rz alone")),
    (
        "weight without mass",
        lambda: static(bar(dx.Section.from_moduli(**MODULI)).clamp("a").gravity(Z)),
        ("gravity", "no rod has mass"),
    ),
    ("dashpot in statics", lambda: static(bar().clamp("a").dashpot("b", Z, 1.0, name="d")), ("link 'd'", "damping")),
    (
        "velocity in statics",
        lambda: static(bar().clamp("a").velocity("b", X)),
        ("initial velocities play no part in statics",),
    ),
    (
        "nearly the same place",
        lambda: dynamic(line(("one", O, X, "a", "b"), ("two", (1, 0, 2e-4), (2, 0, 0), "c", "d"))),
        ("nodes 'b' and 'c' are 0.0002 apart",),
    ),
]  # fmt: skip

RUNS: list[Case] = [
    ("element that turns too far", lambda: run(rolled(4)), ("rod 'strip', element", "45°", "more elements", "'b'")),
    (
        "more than it can carry",
        lambda: run(yielding(3.0)),
        ("rod 'hose' bends", "largest at 'b'", "0.151 % of"),
    ),
    (
        "a blow too hard for the step",
        lambda: struck(0),
        ("asked node 'b' of rod 'bar' to turn by", "No part is near"),
    ),
    (
        "a blow too hard for the mesh",
        lambda: struck(12),
        ("was cut 12 times", "rod 'bar', element 1 turns by 179° between its nodes: refine", "the stress makes its"),
    ),
    (
        "a function that breaks",
        lambda: run(bar().clamp("a").force("b", lambda t: (0, 0, NAN if t > 0.3 else 0.0))),
        ("force on node 'b'", "t = 0.4"),
    ),
]

JOINTS: list[Case] = [
    (
        "a hinge alone",
        lambda: static(joined().hinge("b", "c", axis=Y)),
        ("rod 'two'", "rotation about y through node 'c' (1, 0, 0)", "largest at node 'd'"),
    ),
    ("a ball alone", lambda: static(joined().spherical("b", "c")), ("rod 'two'", "every axis through node 'c'")),
    (
        "a cardan alone",
        lambda: static(joined().universal("b", "c", axes=(Y, Z))),
        ("rod 'two'", "every axis normal to x through node 'c'"),
    ),
    ("a slider alone", lambda: static(joined().slider("b", "c", axis=X)), ("rod 'two'", "translation along x")),
    (
        "a sleeve alone",
        lambda: static(joined().cylindrical("b", "c", axis=X)),
        ("rod 'two'", "translation along x and rotation about x"),
    ),
    (
        "a table alone",
        lambda: static(joined().planar("b", "c", normal=Z)),
        ("rod 'two'", "plane normal to z and rotation about z"),
    ),
    ("a drive that nothing withstands", lambda: static(joined().hinge("b", "c", axis=Y, drive=1.0)), ("push it",)),
    (
        "a linkage",
        lambda: static(linkage()),
        ("rod 'crank' can move freely: rotation about y through node 'a'", "rod 'coupler': translation along x", "'e'"),
    ),
    (
        "a stop that is not reached",
        lambda: static(joined().hinge("b", "c", axis=Y, name="knee", stops=(-0.1, 0.1), stop_stiffness=9.0)),
        ("rod 'two'", "rotation about y", "until joint 'knee' is at a stop"),
    ),
    (
        "two that hold the same",
        lambda: static(joined().hinge("b", "c", axis=Y, name="p").spherical("b", "c", name="q")),
        ("joints 'p', 'q'",),
    ),
    ("a joint on what is held", lambda: static(joined().rigid("b", "c").hinge("a", axis=Y, name="p")), ("joint 'p'",)),
    (
        "a node on its own",
        lambda: static(joined().rigid("b", "c").node("n", Z)),
        ("nothing is attached to node 'n'", "support"),
    ),
    (
        "a node on one spring",
        lambda: static(joined().rigid("b", "c").node("n", (3, 0, 0)).spring("d", "n", 1.0)),
        ("node 'n'", "translation in the plane normal to x"),
    ),
    (
        "a point that turns without inertia",
        lambda: dx.simulate(
            bar().node("n", (2, 0, 0)).point_mass("n", 1.0).spring("b", "n", 1.0).moment("n", Z), 1.0, 0.1
        ),
        ("node 'n' has no rotary inertia",),
    ),
    (
        "a node without mass",
        lambda: dx.simulate(bar().node("n", (2, 0, 0)).spherical("b", "n"), 1.0, 0.1),
        ("node 'n' has no mass, and nothing says how it turns",),
    ),
]  # fmt: skip

FAULTY = [*MOTIONS, *VALUES, *RUNS, *JOINTS]
