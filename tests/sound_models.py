"""Models that are sound, by seed: frames, trees, lattices, arches, suspended bodies, of any stiffness and size."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np

import directrix as dx

__all__ = ["sound"]

Random = np.random.Generator


def sound(seed: int) -> dx.Model:
    """A model that nothing is wrong with: E from 1e2 to 1e12, sizes from 1e-6 to 1e4, slenderness 3 to 1e4."""
    random = np.random.default_rng(seed)
    size, young = 10.0 ** random.uniform(-6, 4), 10.0 ** random.uniform(2, 12)
    kinds = (cantilever, arch, frame, tree, lattice, helix, tied, hung, suspended, stayed, jointed)
    model = kinds[seed % len(kinds)](random, size, young)
    return loaded(random, model, size, young)


def section(random: Random, size: float, young: float) -> dx.Section:
    thickness = size / 10.0 ** random.uniform(0.5, 4.0)
    rho, nu = 10.0 ** random.uniform(0, 4), random.uniform(0.0, 0.5)
    shape: list[Callable[[], dx.Section]] = [
        lambda: dx.Section.circle(radius=thickness, E=young, nu=nu, rho=rho),
        lambda: dx.Section.rectangle(
            width=thickness, height=thickness * random.uniform(0.02, 1), E=young, nu=nu, rho=rho
        ),
        lambda: dx.Section.tube(outer=thickness, wall=thickness * random.uniform(0.02, 0.5), E=young, nu=nu, rho=rho),
    ]
    return shape[random.integers(3)]()


def mesh(random: Random) -> dict[str, int]:
    return {"elements": int(random.integers(1, 5)), "order": int(random.integers(1, 3))}


def place(random: Random, size: float) -> np.ndarray:
    """Somewhere, up to some sizes from the origin."""
    return size * random.uniform(-3, 3, 3) * (random.random() < 0.7)


def cantilever(random: Random, size: float, young: float) -> dx.Model:
    start = place(random, size)
    axis = random.standard_normal(3)
    end = start + size * axis / np.linalg.norm(axis)
    model = dx.Model().rod(dx.line(start, end), section(random, size, young), ends=("a", "b"), **mesh(random))
    held: list[Callable[[], dx.Model]] = [
        lambda: model.clamp("a"),
        lambda: model.clamp("a").pin("b"),
        lambda: model.clamp("a").clamp("b"),
        lambda: model.prescribe("a", displacement=(0, 0, 0.1 * size), rotation=(0, 0, 0)),
        lambda: (
            model.fix("a", "x", "y", "z", "rx", "ry").pin("b")
            if abs(axis[2]) < 0.9 * np.linalg.norm(axis)
            else model.clamp("a")
        ),
    ]
    return held[random.integers(5)]()


def arch(random: Random, size: float, young: float) -> dx.Model:
    """Two hinges about y, or pins at three places that are not in line."""
    rise = size * random.uniform(0.02, 0.6)
    curve = dx.arc((-size, 0, 0), (0, 0, rise), (size, 0, 0))
    given = {"elements": 2 * int(random.integers(1, 4)), "order": 2}
    model = dx.Model().rod(curve, section(random, size, young), ends=("l", "r"), nodes={"crown": 0.5}, **given)
    if random.random() < 0.5:
        return model.fix("l", "x", "y", "z", "rx", "rz").fix("r", "x", "y", "z", "rx", "rz")
    return model.pin("l").pin("r").fix("crown", "y")


def frame(random: Random, size: float, young: float) -> dx.Model:
    """A portal, clamped or on three legs that are pinned."""
    height, parts = size * random.uniform(0.3, 2.0), section(random, size, young)
    feet = [(0, 0), (1, 0), (0.3, 0.8)]
    model = dx.Model()
    for k, (x, y) in enumerate(feet):
        foot, head = np.array([x, y, 0]) * size, np.array([x * size, y * size, height])
        model = model.rod(dx.line(foot, head), parts, name=f"leg{k}", ends=(f"f{k}", f"h{k}"), **mesh(random))
    heads = [np.array([x * size, y * size, height]) for x, y in feet]
    for a, b in ((0, 1), (1, 2)):
        model = model.rod(dx.line(heads[a], heads[b]), parts, name=f"beam{a}", ends=(f"h{a}", f"h{b}"), **mesh(random))
    if random.random() < 0.5:
        return model.clamp("f0")
    return model.pin("f0").pin("f1").pin("f2")


def tree(random: Random, size: float, young: float) -> dx.Model:
    """Branches that grow out of the ends of others, each thinner and softer."""
    ends = [np.zeros(3)]
    model = dx.Model()
    for k in range(int(random.integers(3, 12))):
        root = int(random.integers(len(ends)))
        length = size * random.uniform(0.05, 1.0)
        tip = ends[root] + length * random.standard_normal(3)
        soft = young * 10.0 ** random.uniform(-4, 0)
        ends.append(tip)
        model = model.rod(
            dx.line(ends[root], tip), section(random, length, soft), ends=(f"n{root}", f"n{k + 1}"), **mesh(random)
        )
    return model.clamp("n0")


def lattice(random: Random, size: float, young: float) -> dx.Model:
    """A grid of rods on three pins, or with one clamped corner."""
    nx, ny, parts = int(random.integers(2, 4)), int(random.integers(2, 4)), section(random, size, young)
    model = dx.Model()
    at = {(i, j): size * np.array([i, j, 0.1 * random.standard_normal()]) for i in range(nx) for j in range(ny)}
    for (i, j), r in at.items():
        for step in ((1, 0), (0, 1)):
            other = (i + step[0], j + step[1])
            if other in at:
                model = model.rod(
                    dx.line(r, at[other]), parts, ends=(f"n{i}{j}", f"n{other[0]}{other[1]}"), **mesh(random)
                )
    if random.random() < 0.5:
        return model.clamp("n00")
    return model.pin("n00").fix("n10", "y", "z").fix("n01", "z")


def helix(random: Random, size: float, young: float) -> dx.Model:
    curve = dx.helix(radius=size, pitch=size * random.uniform(0.1, 2.0), turns=random.uniform(0.5, 2.0))
    model = dx.Model().rod(curve, section(random, size, young), ends=("a", "b"), elements=8)
    return model.clamp("a") if random.random() < 0.5 else model.clamp("b").fix("a", "x", "rx", "ry")


def bar(random: Random, size: float, young: float) -> dx.Model:
    return dx.Model().rod(
        dx.line((0, 0, 0), (size, 0, 0)), section(random, size, young), name="bar", ends=("a", "b"),
        nodes={"m": 0.5}, elements=2,
    )  # fmt: skip


def tied(random: Random, size: float, young: float) -> dx.Model:
    """A bar on a hinge that a spring (soft or stiff) or a cable holds, or one that a spring keeps from spinning."""
    stiffness = young * size * 10.0 ** random.uniform(-9, 2)
    model = bar(random, size, young).fix("a", "x", "y", "z", "rx", "rz")
    over = (0.2 * size, 0.0, size)
    if random.random() < 0.4:
        return model.spring("b", over, stiffness)
    if random.random() < 0.5:
        return model.cable("b", over, stiffness, length=0.9 * size)
    model = bar(random, size, young).pin("a").pin("b")
    return model.spring("m", (0.5 * size, size, 0.0), stiffness, offset_a=(0, 0, 0.1 * size))


def hung(random: Random, size: float, young: float) -> dx.Model:
    """A bar with a body that nothing but six springs hold."""
    model = bar(random, size, young).rigid_body("m", 1.0, np.eye(3) * size**2)
    k = young * size * 10.0 ** random.uniform(-9, 2, 6)
    model = model.spring("a", (0, 0, size), k[0]).spring("b", (size, 0, size), k[1])
    model = model.spring("a", (0, size, 0), k[2]).spring("b", (size, size, 0), k[3])
    model = model.spring("a", (-size, 0, 0), k[4])
    return model.spring("m", (0.5 * size, 0.3 * size, 0), k[5], offset_a=(0, 0, 0.3 * size))


def suspended(random: Random, size: float, young: float) -> dx.Model:
    """A bar that the tension of its cables holds, with no stiffness across them but that."""
    model = bar(random, size, young)
    k = young * size * 10.0 ** random.uniform(-6, 2)
    for node, x in (("a", 0.0), ("b", size)):
        for y in (-1.0, 1.0):
            model = model.cable(node, (x, y * size, 0), k, length=random.uniform(0.9, 0.999) * size)
    model = model.spring("m", (0.5 * size, 0, size), k, length=0.9 * size)
    model = model.cable("b", (2 * size, 0, 0), k, length=0.95 * size, offset_a=(0, 0, 0.1 * size))
    return model.spring("m", (0.5 * size, size, 0), k, offset_a=(0, 0, 0.2 * size))


def stayed(random: Random, size: float, young: float) -> dx.Model:
    """A mast on a ball joint with three stays, which a fourth, off its axis, keeps from turning."""
    model = dx.Model().rod(
        dx.line((0, 0, 0), (0, 0, size)), section(random, size, young), name="mast", ends=("foot", "top")
    )
    k = young * size * 10.0 ** random.uniform(-6, 1)
    model = model.pin("foot")
    for angle in np.array([0.0, 2.1, 4.2]) + random.uniform(0, 6):
        model = model.cable("top", (size * np.cos(angle), size * np.sin(angle), 0), k, length=1.3 * size)
    return model.spring("top", (size, size, size), k, offset_a=(0.05 * size, -0.05 * size, 0))


def jointed(random: Random, size: float, young: float) -> dx.Model:
    """An arch of three hinges, a linkage that a spring or a prescribed angle holds, or a mast on two joints."""
    parts, y = section(random, size, young), (0.0, 1.0, 0.0)
    k = young * size**3 * 10.0 ** random.uniform(-9, 0)

    def rods(*places: tuple[float, float]) -> dx.Model:
        model = dx.Model()
        points = [size * np.array([x, 0.0, z]) for x, z in places]
        for i, (a, b) in enumerate(pairwise(points)):
            model = model.rod(dx.line(a, b), parts, name=f"bar{i}", ends=(f"s{i}", f"e{i}"), **mesh(random))
        return model

    match random.integers(4):
        case 0:
            model = rods((0, 0), (1, random.uniform(0.2, 1.0)), (2, 0)).hinge("s0", axis=y).hinge("e0", "s1", axis=y)
            return model.spherical("e1")
        case 1:
            model = rods((0, 0), (0, 1), (2, random.uniform(1, 2)), (2, 0)).hinge("e0", "s1", axis=y)
            model = model.spherical("e1", "s2").cylindrical("e2", axis=y)
            return model.hinge("s0", axis=y, stiffness=k)
        case 2:
            model = rods((0, 0), (0, 1), (2, random.uniform(1, 2)), (2, 0)).hinge("e0", "s1", axis=y)
            model = model.spherical("e1", "s2").cylindrical("e2", axis=y)
            return model.hinge("s0", axis=y, prescribed=0.2)
        case _:
            model = (
                rods((0, 0), (0, 1)).node("body", (0, 0, 1.2 * size)).rigid("e0", "body").spherical("s0", stiffness=k)
            )
            return model.rigid_body("body", 1.0, np.eye(3) * size**2)


def loaded(random: Random, model: dx.Model, size: float, young: float) -> dx.Model:
    """With some loads, on nodes that nothing holds, and weight."""
    held = {s.node for s in model.supports} | {p.node for p in model.prescribed}
    for name in {n for rod in model.rods for n in rod.names} - held:
        if random.random() < 0.3:
            model = model.force(name, young * size**2 * 1e-6 * random.standard_normal(3))
    return model.gravity((0, 0, -9.81)) if random.random() < 0.5 else model
