"""Newton's iteration for one step: owns the workspace and the factorisation, knows no rods."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from directrix.checks import number
from directrix.discretisation import Discretisation
from directrix.errors import ModelError
from directrix.formulations.directors import Rule
from directrix.kernels import step as kernel
from directrix.kernels.tables import tables_for, work_for
from directrix.linear.sparse import BlockSparse
from directrix.result import Status

Array = NDArray[np.float64]

__all__ = ["Books", "Newton", "Outcome", "Settings"]


@dataclass(frozen=True)
class Settings:
    """Stopping rule and damping.

    ``tolerance``: unbalanced force (moment) over the largest element force (moment), never below round-off;
    increments must also fall below 1e-9 of the model's size and 1e-9 rad. ``largest_turn`` [rad]: an
    iteration that would turn a node further is shortened. ``rotation`` "exponential" or "cayley".
    """

    tolerance: float = 1e-9
    iterations: int = 50
    largest_turn: float = 0.3
    rotation: str = "exponential"

    def __post_init__(self) -> None:
        if not 0.0 < number(self.tolerance, "tolerance") < 1.0:
            raise ModelError(
                f"tolerance = {self.tolerance} is not a relative tolerance",
                "give a number between 0 and 1, e.g. 1e-9",
            )


class Outcome(NamedTuple):
    """How an iteration ended: ``status`` is None when it converged."""

    iterations: int
    status: Status | None


class Books(NamedTuple):
    """What :meth:`Newton.finish` books for a step: totals (11,) and flow (8,) as in the kernels, strains, reactions."""

    totals: Array
    flow: Array
    strains: Array
    reaction: Array


class Newton:
    """Solves steps of one discretisation under one rule.

    ``x`` (n, 40) is a state as in :mod:`directrix.state`; :meth:`solve` moves x1, :meth:`finish` makes it x0.
    """

    def __init__(self, disc: Discretisation, rule: Rule, settings: Settings, dt: float = 0.0) -> None:
        self.disc, self.rule, self.settings = disc, rule, settings
        self.tables, self.work = tables_for(disc, rule), work_for(disc)
        self.rate = 0.0 if rule.static else 2.0 / dt
        self.globals = np.array([self.rate, 0.5 * self.rate])
        # the compiled loops read 0/1
        self.mask = disc.fixed.astype(np.uint8)
        self.options = np.array(
            [
                settings.tolerance, *_round_off(disc, 0.5 * self.rate**2), disc.length, settings.largest_turn,
                settings.iterations, float(settings.rotation == "cayley"),
            ]
        )  # fmt: skip
        self.totals, self.strains = np.zeros(11), np.zeros((disc.stations, 6))
        self.origin: Array = np.zeros(3)
        self.free = not disc.fixed.any()

    @cached_property
    def sparse(self) -> BlockSparse:
        """The general solver; a chain needs it only when its own meets a vanishing pivot."""
        return BlockSparse(self.disc.pattern.rowptr, self.disc.pattern.column)

    def solve(self, x: Array, external: Array, moved: bool = False) -> Outcome:
        """Move x1 until it balances ``external`` (n, 6).

        ``moved`` says that supports were displaced since the last step: the positions are then solved for
        first, at the rotations as they are.
        """
        start = x.copy()
        outcome = self._iterate(self.tables, x, external, moved)
        if outcome.status is not None and outcome.status.code == "singular" and self.tables.chain:
            x[:] = start
            outcome = self._iterate(self.tables._replace(chain=0), x, external, moved)
        return outcome

    def _iterate(self, tables: object, x: Array, external: Array, moved: bool) -> Outcome:
        control = np.array([0, 0, int(moved), 0], np.int64)
        while True:
            code = kernel.newton(tables, self.work, x, self.globals, external, self.mask, self.options, control)
            if code != kernel.SOLVE:
                return Outcome(int(control[1]), self._status(code, int(control[3])))
            du = self.sparse.solve(self.work.blocks, self.work.rhs)
            if du is None:
                return Outcome(int(control[1]), self._status(kernel.SINGULAR, int(control[3])))
            self.work.du[:] = du

    def _status(self, code: int, blame: int) -> Status | None:
        if code == kernel.CONVERGED:
            return None
        place = self.disc.mesh.label(blame)
        turn = self.turn_sentence()
        if code == kernel.NON_FINITE:
            return Status(
                "non_finite",
                f"a value that is not finite appeared at {place}.{turn}",
                "Reduce the step, or check sections and loads there.",
            )
        if code == kernel.SINGULAR:
            return Status(
                "singular",
                f"the stiffness is singular at {place}.{turn}",
                "A part can move freely or is at a limit or bifurcation point: add supports or take smaller steps.",
            )
        return Status(
            "not_converged",
            f"Newton's iteration did not converge in {self.settings.iterations} iterations; "
            f"the largest imbalance is at {place}.{turn}",
            "Take smaller steps, or refine the mesh.",
        )

    def turn_sentence(self) -> str:
        """A sentence when an element turns by more than 30° between its nodes, else nothing."""
        angle = turn_of(self.totals[8])
        if angle < np.pi / 6:
            return ""
        where = self.disc.element_place(int(self.totals[9]))
        return f" {where} turns by {np.degrees(angle):.0f}° between its nodes: refine or raise the order."

    def increments(self, x: Array, external: Array, count: int) -> list[float]:
        """Sizes of ``count`` undamped increments (largest displacement plus turn): to see the order of convergence."""
        sizes: list[float] = []
        for _ in range(count):
            kernel.assemble(self.tables, self.work, x, self.globals, external, self.mask, False)
            du = self.sparse.solve(self.work.blocks, self.work.rhs)
            if du is None:
                break
            self.work.du[:] = du
            moved, turned, _ = kernel.advance(self.tables, self.work, x, False, False, np.inf)
            sizes.append(moved + turned)
        return sizes

    def finish(self, x: Array, external: Array, before: Array) -> Books:
        """Book the step and make x1 the start of the next one. The arrays are reused by the next call.

        ``before`` are the loads of the step before: statics books work with the mean, dynamics gives ``external``.
        """
        kernel.finish(self.tables, self.work, x, external, before, self.mask, self.rate, self.totals, self.strains)
        flow = self.work.flow
        if self.free:
            flow[5:] += np.cross(self.origin, flow[2:5])
        books = self._about_zero()
        if self.free:
            self._follow(x)
        return books

    def positions(self, x: Array) -> Array:
        """Positions (n, 3) of a state."""
        return x[:, :3] + self.origin

    def _follow(self, x: Array) -> None:
        """Measure the positions of a free model from a point that goes along with it.

        Far from the origin positions lose the digits that strains are made of. The shift is a multiple of a power
        of two, so no digit of a position changes.
        """
        if np.abs(x[0, :3]).max() > 8.0 * self.disc.length:
            grain = 2.0 ** np.floor(np.log2(self.disc.length))
            shift = np.rint(x[0, :3] / grain) * grain
            x[:, :3] -= shift
            self.origin += shift

    def _about_zero(self) -> Books:
        if self.free:
            self.totals[5:8] += np.cross(self.origin, self.totals[2:5])
        return Books(self.totals, self.work.flow, self.strains, self.work.reaction)

    def books(self, x: Array) -> Books:
        """The books of a state as it is."""
        kernel.books(self.tables, self.work, x, self.totals, self.strains)
        self.work.flow[:] = 0.0
        self.work.reaction[:] = 0.0
        return self._about_zero()


def turn_of(dots: float) -> float:
    """Angle [rad] between two neighbouring nodes from Σ_i d_i·d_i = 1 + 2 cos."""
    return float(np.arccos(np.clip(0.5 * (dots - 1.0), -1.0, 1.0)))


def _round_off(disc: Discretisation, inertia: float) -> tuple[float, float]:
    """What rounding alone can make of the imbalance: force and moment. ``inertia`` = 2/Δt²."""
    eps = 50.0 * np.finfo(float).eps
    far = float(np.abs(disc.mesh.r0).max()) + disc.length
    force = moment = 0.0
    for rod, mesh in zip(disc.model.rods, disc.mesh.rods, strict=True):
        c = np.abs(rod.section.stiffness)
        h = float(np.diff(mesh.s).min()) * mesh.order
        a, b = c[:3].max(), c[3:].max() / h
        mass, spin = inertia * rod.section.A_rho * h, inertia * float(np.abs(rod.section.I_rho).max()) * h
        force = max(force, a * (1.0 + far / h) + b / h + mass * far)
        moment = max(moment, a * (h + far) + b + spin + mass * far * h)
    return eps * force, eps * moment
