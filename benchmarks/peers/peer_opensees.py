"""OpenSees through openseespy: elasticBeamColumn (no shear) under the corotational transformation, masses lumped
by the element, weight lumped at the nodes (element loads are refused there); Newmark ½, ¼; Newton to 1e-8 of
the unbalance, banded LU with symmetric numbering (RCM).
"""

from __future__ import annotations

import itertools
from importlib.metadata import version

import common
import numpy as np
import openseespy.opensees as ops
from common import Clock, Rod, Run


def chain(rod: Rod, a, b, n: int, first: int = 1, start: int | None = None, velocity=None) -> list[int]:
    """Nodes and elements from a to b, numbered from ``first``; ``start`` is a node that is there already."""
    a, b = np.array(a, float), np.array(b, float)
    axis = (b - a) / np.linalg.norm(b - a)
    side = np.eye(3)[np.argmin(abs(axis))]
    ops.geomTransf("Corotational", first, *side.tolist())
    nodes, length = [], np.linalg.norm(b - a) / n
    for k, x in enumerate(np.linspace(a, b, n + 1)):
        if k == 0 and start is not None:
            nodes.append(start)
            continue
        tag = first + k
        ops.node(tag, *x.tolist())
        turning = rod.inertia * length / (2 if k in (0, n) else 1)
        ops.mass(tag, 0, 0, 0, turning, turning, turning)
        nodes.append(tag)
        for d, v in enumerate((velocity or {}).get(tuple(np.round(x, 9)), ())):
            ops.setNodeVel(tag, d + 1, float(v), "-commit")
    for k, (i, j) in enumerate(itertools.pairwise(nodes)):
        args = (rod.EA, 1.0, 1.0, rod.GJ, rod.EI, rod.EI, first)  # A, E, G, J, Iy, Iz with E = G = 1
        ops.element("elasticBeamColumn", first + k, i, j, *args, "-mass", rod.mass)
    return nodes


def prepare() -> None:
    ops.constraints("Plain")
    ops.numberer("RCM")
    ops.system("BandGeneral")
    ops.test("NormUnbalance", 1e-8, 30)
    ops.algorithm("Newton")
    ops.integrator("Newmark", 0.5, 0.25)
    ops.analysis("Transient")


def at(node: int) -> np.ndarray:
    return np.array(ops.nodeCoord(node)) + np.array(ops.nodeDisp(node)[:3])


def kinetic(rod: Rod, n: int, nodes: list[int], length: float) -> float:
    total = 0.0
    for k, node in enumerate(nodes):
        v, share = np.array(ops.nodeVel(node)), 0.5 if k in (0, n) else 1.0
        total += 0.5 * share * length * (rod.mass * v[:3] @ v[:3] + rod.inertia * v[3:] @ v[3:])
    return float(total)


def stored(rod: Rod, n: int, first: int, length: float) -> float:
    """Of forces at the ends of the elements, whose moments run straight between them."""
    total = 0.0
    for e in range(first, first + n):
        f = np.array(ops.eleResponse(e, "localForce"))
        total += f[6] ** 2 / rod.EA + f[9] ** 2 / rod.GJ
        for i, j in ((4, 10), (5, 11)):
            total += (f[i] ** 2 - f[i] * f[j] + f[j] ** 2) / (3 * rod.EI)
    return float(0.5 * length * total)


def march(end: float, dt: float, since: float = 0.0) -> float:
    for k in range(round((end - since) / dt)):
        if ops.analyze(1, dt):
            return since + k * dt
    return end


def solve(case: str, n: int, dt: float, variant: str, clock: Clock) -> Run:
    ops.wipe()
    ops.model("basic", "-ndm", 3, "-ndf", 6)
    if case == "swing":
        rod, length = common.SWING, 1.0 / n
        nodes = chain(rod, (0, 0, 0), (1, 0, 0), n)
        ops.fix(nodes[0], 1, 1, 1, 0, 0, 0)
        ops.timeSeries("Constant", 1)
        ops.pattern("Plain", 1, 1)
        weight = rod.mass * common.GRAVITY * length
        for k, node in enumerate(nodes):
            ops.load(node, 0, 0, -weight * (0.5 if k in (0, n) else 1.0), 0, 0, 0)
        prepare()
        with clock.running():
            reached = march(1.0, dt)
        work = -sum(weight * (0.5 if k in (0, n) else 1.0) * at(i)[2] for k, i in enumerate(nodes))
        energy = kinetic(rod, n, nodes, length) + stored(rod, n, 1, length) - work
        return Run(reached >= 1.0, at(nodes[-1]).tolist(), energy, energy / abs(work), reached)
    if case == "flight":
        rod, length, start, legs = common.FLIGHT, 3.0 / n, None, []
        for i, (a, b) in enumerate(common.FLIGHT_LEGS):
            legs.append(chain(rod, a, b, n, 1 + i * 1000, start, common.FLIGHT_VELOCITY))
            start = legs[-1][-1]
        prepare()
        with clock.running():
            reached = march(common.FLIGHT_END, dt)
        done = reached >= common.FLIGHT_END
        energy = sum(kinetic(rod, n, leg, length) + stored(rod, n, 1 + i * 1000, length) for i, leg in enumerate(legs))
        first = 0.5 * sum(
            rod.mass * length * w * (np.dot(v, v))
            for v, w in zip(common.FLIGHT_VELOCITY.values(), (0.5, 1, 0.5), strict=True)
        )
        return Run(
            done,
            at(legs[2][-1]).tolist(),
            energy,
            energy / first - 1,
            reached,
            note=f"lumped masses start with {first:.3f}",
        )
    rod, length = common.SPAGHETTI, 10.0 / n
    nodes = chain(rod, common.LOADED, common.OTHER, n)
    ops.timeSeries("Path", 1, "-time", 0, 2.5, 5.0, 100, "-values", 0, 200, 0, 0)
    ops.pattern("Plain", 1, 1)
    ops.load(nodes[0], 0.1, 0, 0, 0, 1.0, 0.5)
    prepare()
    with clock.running():
        reached = march(common.RELEASE, dt)
    before = kinetic(rod, n, nodes, length) + stored(rod, n, 1, length)
    if reached >= common.RELEASE:
        with clock.running():
            reached = march(common.SPAGHETTI_END, dt, common.RELEASE)
    energy = kinetic(rod, n, nodes, length) + stored(rod, n, 1, length)
    done = reached >= common.SPAGHETTI_END
    return Run(done, at(nodes[0]).tolist(), energy, energy / before - 1 if done else None, reached)


if __name__ == "__main__":
    common.main("OpenSees", version("openseespy"), solve)
