"""Newton's iteration for a state and its load factor together: K Δ = residual + δλ f, closed by one row c·Δ = −gap.

The row is a plane in the space of the directors, so that one iteration serves every control: see :class:`Row`.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from directrix.joints import KINDS
from directrix.kernels import step as kernel
from directrix.kernels.chain import solve_chain
from directrix.newton import Newton
from directrix.result import Status, turn_length
from directrix.rotations import axial, exp

Array = NDArray[np.float64]
Row = Callable[[Array], tuple[Array, float]]
"""x (rows, 40) → (c (n, 6), gap): the row of the control at a state whose Δr and R0 are those of the step's start."""

__all__ = ["Bordered", "Corrected", "Row", "around", "dot", "normal_to", "travelled"]

BLIND = 1e-12  # |cos| of the angle between the row and the path below which the row does not fix a point of it


class Corrected(NamedTuple):
    """How an iteration ended: the load factor, its rows as in :class:`directrix.trail.Iterations`, and a status that is
    None when it converged."""

    factor: float
    trail: Array
    status: Status | None


def dot(a: Array, b: Array, length: float) -> float:
    """Inner product of two increments (n, 6): mean over the nodes of u·u + ℓ² θ·θ."""
    return float(np.sum(a[:, :3] * b[:, :3]) + length**2 * np.sum(a[:, 3:] * b[:, 3:])) / len(a)


def normal_to(tangent: Array, ds: float, length: float) -> Row:
    """The plane at the distance ``ds`` along ``tangent`` (n, 6): mean of u·Δr + ½ℓ² Σ (θ × d_i0)·Δd_i = ds."""
    n = len(tangent)
    u, theta = tangent[:, :3], tangent[:, None, 3:]

    def row(x: Array) -> tuple[Array, float]:
        d1, d0 = x[:n, 3:12].reshape(n, 3, 3), x[:n, 15:24].reshape(n, 3, 3)
        towards = np.cross(theta, d0)
        spin = 0.5 * length**2 * np.cross(d1, towards).sum(axis=1)
        gone = np.sum(u * x[:n, 12:15]) + 0.5 * length**2 * np.sum(towards * (d1 - d0))
        return np.hstack([u, spin]) / n, float(gone) / n - ds

    return row


def travelled(x: Array, nodes: int, length: float) -> float:
    """Distance of a state from the start of its step."""
    turned = x[:nodes, 3:12] - x[:nodes, 15:24]
    return float(np.sqrt((np.sum(x[:nodes, 12:15] ** 2) + 0.5 * length**2 * np.sum(turned**2)) / nodes))


class Bordered:
    """Corrects states of one discretisation onto its equilibrium path; borrows the workspace of a :class:`Newton`."""

    def __init__(self, newton: Newton) -> None:
        self.newton, self.disc = newton, newton.disc
        self.length = turn_length(self.disc.mesh.r0)
        pattern = self.disc.pattern
        self.held = self.disc.held[pattern.node_of_row]  # (rows, 6)

    def correct(self, x: Array, factor: float, row: Row | None) -> Corrected:
        """Move x1 and the load factor until they balance and lie in the row's plane; without one the factor stays."""
        newton, work = self.newton, self.newton.work
        n = self.disc.nodes
        tolerance, floor, size = newton.options[0], newton.options[1:3], newton.options[3]
        limit, cayley = newton.options[4], newton.options[6] > 0.0
        trail = np.full((newton.settings.iterations, 5), np.nan)
        for count in range(1, len(trail) + 1):
            done = trail[:count]
            found = self._increments(x, factor)
            kernel.off_balance(n, work, newton.mask, False, done[-1])
            if isinstance(found, Status):
                return Corrected(factor, done, found)
            out_of_balance, per_factor = found
            rise = 0.0
            if row is not None:
                c, gap = row(x)
                closing = float(np.sum(c * per_factor[:n]))
                if not abs(closing) > BLIND * np.linalg.norm(c) * np.linalg.norm(per_factor[:n]):
                    return Corrected(factor, done, self._blind())
                rise = -(gap + float(np.sum(c * out_of_balance[:n]))) / closing
            moved, turned, bad = kernel.move(out_of_balance + rise * per_factor, n, x, False, cayley, limit)
            done[-1, 2:4] = moved, turned
            if bad >= 0 or not np.isfinite(rise):
                return Corrected(factor, done, newton.verdict(kernel.NON_FINITE, max(bad, 0)))
            factor += float(rise * min(1.0, limit / max(turned, 1e-300)))
            newton.place(x, factor)
            if moved <= 1e-9 * size and turned <= 1e-9:
                newton.applied(x, newton.loads(factor))
                worst, at = kernel.imbalance(n, work, newton.mask, tolerance, floor, size)
                if worst <= 1.0:
                    return Corrected(factor, done, None)
                if not np.isfinite(worst):
                    return Corrected(factor, done, newton.verdict(kernel.NON_FINITE, at))
        newton.applied(x, newton.loads(factor))
        _, at = kernel.imbalance(n, work, newton.mask, tolerance, floor, size)
        return Corrected(factor, trail, newton.verdict(kernel.LIMIT, at))

    def tangent(self, x: Array, factor: float, at_limit: bool = True) -> tuple[Array, float] | Status:
        """Unit tangent (n, 6) of the path at an equilibrium and dλ/ds ≥ 0 along it; Status when there is none.

        ``at_limit`` False also refuses a stiffness that is as good as singular.
        """
        found = self._increments(x, factor, at_limit)
        if isinstance(found, Status):
            return found
        along = found[1][: self.disc.nodes]
        size = np.sqrt(dot(along, along, self.length))
        return (along / size, float(1.0 / size)) if size > 0.0 else (along, np.inf)

    def _increments(self, x: Array, factor: float, at_limit: bool = True) -> tuple[Array, Array] | Status:
        """Increments (rows, 6) of all nodes and multipliers: due to the imbalance, and for one load factor more.

        The second is the difference of two right-hand sides: interior nodes, which are condensed, get their
        part of the load in the assembly.
        """
        newton, work = self.newton, self.newton.work
        rate = self._load_rate(x, factor)
        external = newton.loads(factor)
        # what drives elements need not enter linearly: a small step then, and the state itself last
        h = 1e-6 * max(1.0, abs(factor)) if self.disc.drives else 1.0
        sides = (external, external + h * rate)
        rhs, inside = np.empty((2, *work.rhs.shape)), np.empty((2, len(work.back)))
        for k in (1, 0):
            loads = sides[k]
            newton.driver.place(factor + k * h, factor + k * h)
            bad = kernel.assemble(newton.tables, work, x, newton.globals, loads, newton.mask, False)
            if bad >= 0:
                return self._singular(int(newton.tables.element_node[bad]))
            rhs[k], inside[k] = work.rhs, work.back[:, 12]
        if h != 1.0:
            rhs[1], inside[1] = (a[0] + (a[1] - a[0]) / h for a in (rhs, inside))
        rhs[1][self.held] = self._support_rate(factor)[self.held]
        low, high = around(factor)
        for joint, value in self.disc.driven:
            row = self.disc.pattern.row[self.disc.nodes + joint]
            rhs[1][row, KINDS[self.disc.model.joints[joint].kind].driven] += (value(high) - value(low)) / (high - low)
        solved = self._solve(rhs, at_limit)
        if isinstance(solved, Status):
            return solved
        steps: list[Array] = []
        for k in range(2):
            work.du[:], work.back[:, 12] = solved[k], inside[k]
            kernel.spread(newton.tables, work)
            steps.append(work.step.copy())
        return steps[0], steps[1] - steps[0]

    def _solve(self, rhs: Array, at_limit: bool) -> Array | Status:
        newton, work = self.newton, self.newton.work
        at = 0
        if newton.tables.chain and at_limit:
            out = np.empty_like(rhs)
            rows = [solve_chain(newton.tables.eliminate, work.blocks, rhs[k], work.factors, out[k]) for k in range(2)]
            if max(rows) < 0:
                return out
            at = int(newton.tables.node_of_row[max(rows)])
        solved = newton.sparse.solve(work.blocks, rhs, at_limit=at_limit)
        return self._singular(at) if solved is None else solved

    def _load_rate(self, x: Array, factor: float) -> Array:
        """dF/dλ (n, 12): loads times the factor, and by differences those that are functions of it.

        Of a family of models, of all that is out of balance at a state that stays.
        """
        disc, newton = self.disc, self.newton
        if newton.family is not None:
            low, high = factor - (h := 1e-5 * max(1.0, abs(factor))), factor + h
            out = np.zeros((disc.nodes, 12))
            for p, sign in ((high, 1.0), (low, -1.0)):
                applied = newton.applied(x, newton.loads(p))
                out[:, :6] += sign / (high - low) * (applied - newton.work.internal)
            return out
        rate = disc.external(factor, 1.0) - disc.external(factor, 0.0)
        if any(load.varies for load in disc.loads):
            low, high = around(factor)
            rate += (disc.external(high, factor) - disc.external(low, factor)) / (high - low)
        return rate

    def _support_rate(self, factor: float) -> Array:
        """Displacement and spin (rows, 6) of the supports for one load factor more."""
        rate = np.zeros(self.held.shape)
        low, high = around(factor)
        family, disc = self.newton.family, self.disc
        if family is not None:
            disc = family.at(factor)
            moved = (family.at(high).mesh.r0 - family.at(low).mesh.r0) / (high - low)
            rate[:, :3] = moved[disc.pattern.node_of_row]
        for node, displacement, rotation in disc.prescribed:
            row = self.disc.pattern.row[node]
            if displacement is not None:
                rate[row, :3] += (displacement(high) - displacement(low)) / (high - low)
            if rotation is not None:
                ahead, behind = exp(rotation(high)), exp(rotation(low))
                rate[row, 3:] = axial((ahead - behind) @ exp(rotation(factor)).T) / (high - low)
        return rate

    def _singular(self, node: int) -> Status:
        status = self.newton.verdict(kernel.SINGULAR, node)
        assert status is not None
        return status

    def _blind(self) -> Status:
        return Status("singular", "what drives the path does not move along it.", "Drive it by another displacement.")


def around(factor: float) -> tuple[float, float]:
    """Where functions of the load factor are asked for their slope; not below 0 while the factor is not."""
    h = 1e-5 * max(1.0, abs(factor))
    return (factor if 0.0 <= factor < h else factor - h), factor + h
