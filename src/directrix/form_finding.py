"""Form finding: an equilibrium from a start that is slack or far out of balance.

Implicit dynamic relaxation: the model creeps through a viscous fluid towards lower energy, (K + D/τ) Δ = F − F_int
with D the size of the stiffness at each unknown. The pseudo-time step τ grows while the potential energy falls, and
without a fluid, τ → ∞, this is Newton's iteration, which ends the search. As energy only falls, the way leads to a
stable equilibrium, whatever the start.
"""
# pyright: reportUnknownMemberType=false, reportUnknownVariableType=false, reportUnknownArgumentType=false

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_matrix, diags
from scipy.sparse.linalg import splu

from directrix.audit import StaticBooks
from directrix.checks import reporting, whole
from directrix.critical import PathStability
from directrix.discretisation import discretise
from directrix.errors import ConvergenceError, ModelError
from directrix.hessian import Hessian, nearest_zero, negative_pivots, not_conservative
from directrix.keeping import Folder, Keeper, fingerprint, recall, remember
from directrix.kernels import step as kernel
from directrix.model import Model
from directrix.newton import Newton, Settings
from directrix.recorder import Progress, Recorder
from directrix.result import Result, Status, turn_length
from directrix.state import initial_state, place_supports, stand
from directrix.statics import static_scheme, watch_for
from directrix.watch import Watch

Array = NDArray[np.float64]

__all__ = ["form_find"]

FIRST, LAST = 1e-2, 1e12  # pseudo-time steps: the first one, and the one that is Newton's
GROWTH, CUT = 4.0, 0.25
LARGEST_TURN = 0.3  # rad in an iteration
NEAR = 1e-3  # of the first imbalance: here the iteration of a step along a path takes over
PARTS, BRIEFLY = 10, 50  # of the way of the supports, and iterations after each of them
NUDGES, NUDGE = 6, 1e-3  # times that an unstable equilibrium is left; by so many rad, or parts of the model's size
ROUND_OFF = 1e-13  # of the energies in the sum: a smaller rise is none


def form_find(
    model: Model,
    *,
    start: Result | None = None,
    iterations: int = 2000,
    folder: Folder | str | os.PathLike[str] | None = None,
    tolerance: float = 1e-9,
    threads: int = 1,
    progress: Progress | None = None,
    raise_on_failure: bool = False,
) -> Result:
    """The stable equilibrium that the model falls into under its whole loads and prescribed values.

    Loads act at once; supports go where they are prescribed in ten parts (at once from a ``start``), and the model
    falls after each of them. For cables that hang, nets that are pulled tight, and other shapes that a straight or
    slack start is far from.

    Parameters
    ----------
    model
        Rods, cables, springs, supports and loads; prescribed values at load factor 1. Loads need a potential.
    start
        Begin at the last state of this result instead of the reference.
    iterations
        Most iterations of the relaxation.
    folder
        Where the search is kept while it goes on, as in :func:`directrix.solve_static`.
    tolerance
        Unbalanced over largest element force at which the state is accepted (never below round-off).
    threads
        How many threads share the work on a frame of many junctions; no bit of the result depends on it.
    progress
        Called after each iteration with the fraction done and a line of text.
    raise_on_failure
        Raise ConvergenceError instead of returning a Result with ``success`` False.

    Returns
    -------
    Result
        Two states, the start and the equilibrium, both at load factor 1, with their stability; ``start=`` of later
        runs. ``info["relaxation"]`` counts the iterations before Newton's.

    Raises
    ------
    ModelError
        The model or an argument cannot be right, or a load has no potential.
    """
    iterations = whole(iterations, "iterations", 1, 10**9)
    scheme = static_scheme(model, None)
    disc = discretise(model, scheme)
    newton = Newton(disc, scheme, Settings(tolerance, threads=threads))
    why = not_conservative(newton)
    if why:
        raise ModelError(f"there is no energy to fall: {why}", "use solve_static for such loads")
    x = initial_state(disc, start, scheme)
    asked = {"iterations": iterations, "tolerance": tolerance, "x": x, "parts": start is None}
    print_ = "" if folder is None else fingerprint(disc, scheme, asked, (1.0,))
    loads = disc.external(1.0)
    newton.driver.place(1.0, 1.0)
    newton.driver.shift()
    watch, _ = watch_for(newton, True, None)
    assert watch is not None
    recorder = Recorder(disc, "static")
    ledger = StaticBooks(disc, newton.books(x))
    recorder.keep(1.0, 1.0, x[: disc.nodes, :3], x, newton.books(x), ledger.flows)
    counts = [watch.pivots(x, 1.0)]
    search = _Search(newton, loads, watch, recorder, x, iterations, bool(disc.prescribed) and start is None)
    keeper = Keeper(folder, recorder, print_)
    if keeper.memory is not None:
        search.recall(keeper.memory)
        search.status = search.status if keeper.same else None
        x = search.x
    report = reporting(progress)
    status = keeper.attend(lambda: search.go(report, keeper), lambda: f"iteration {search.taken}")
    books = newton.finish(x, newton.applied(x, loads).copy())
    ledger.add(books, x[: disc.nodes, :3])
    recorder.keep(1.0, 1.0, x[: disc.nodes, :3], x, books, ledger.flows)
    counts.append(watch.pivots(x, 1.0))
    info = {
        "formulation": "Directors()", "tolerance": tolerance, "control": "form finding", "relaxation": search.taken,
        "element": repr(scheme.element),
    }  # fmt: skip
    stability = PathStability(np.array(counts, np.int64), np.zeros(len(counts), bool))
    result = replace(recorder.result(status, ledger.audit(), info, keeper.earlier()), stability=stability)
    result = keeper.finish(result)
    if raise_on_failure and not result.success:
        raise ConvergenceError(result)
    return result


class _Search:
    """The way to a stable equilibrium, one move after the other: supports go on by a part and the model falls, in the
    end until it settles; what it settles in that is not stable is left. ``status`` says how it ended."""

    def __init__(
        self, newton: Newton, loads: Array, watch: Watch, recorder: Recorder, x: Array, most: int, by_parts: bool
    ) -> None:
        self.newton, self.loads, self.watch, self.recorder, self.x, self.most = newton, loads, watch, recorder, x, most
        self.fall = _Fall(newton, loads)
        self.part, self.taken, self.nudges = 1 if by_parts else PARTS, 0, 0
        self.begun, self.limit, self.left = False, 0, 1.0
        self.status: Status | None = None

    def remember(self) -> dict[str, Any]:
        """All that the next move depends on."""
        return {
            "own": remember(self, "x", "part", "taken", "nudges", "begun", "limit", "left"),
            "fall": remember(self.fall, "pace", "first", "stuck"),
            "status": None if self.status is None else vars(self.status), "newton": self.newton.remember(),
            "trail": self.recorder.log.trail.remember(),
        }  # fmt: skip

    def recall(self, memory: Mapping[str, Any]) -> None:
        """Go on from what :meth:`remember` gave."""
        recall(self, memory["own"])
        recall(self.fall, memory["fall"])
        self.status = None if memory["status"] is None else Status(**memory["status"])
        self.newton.recall(memory["newton"])
        self.recorder.log.trail.recall(memory["trail"])

    def go(self, report: Callable[[float, str], None], keeper: Keeper) -> Status:
        """Move on until the end."""
        while self.status is None:
            if keeper.due(self.taken):
                keeper.keep(self.taken, self.part / PARTS, self.remember)
                if keeper.stopping:
                    return keeper.interrupted(f"iteration {self.taken}")
            self.status = self._move(report)
        if self.status.success:
            keeper.keep(self.taken, 1.0, self.remember, done=True)
        return self.status

    def _move(self, report: Callable[[float, str], None]) -> Status | None:
        fall, last = self.fall, self.part == PARTS
        if not self.begun:
            fall.support(self.x, self.part / PARTS)
            fall.begin()
            self.limit = self.most if last else min(self.taken + BRIEFLY, self.most)
            self.begun, self.left = True, 1.0
        if self.taken < self.limit:
            self.left, self.taken = fall.step(self.x), self.taken + 1
            report(self.taken / self.limit, f"imbalance {self.left:.3g} of the first, pseudo-time step {fall.pace:.3g}")
            if not (fall.stuck or (self.left <= NEAR and fall.pace >= LAST)):
                return None
            stand(self.x, fall.disc.nodes)
            if last:
                return self._settled()
        elif last:
            sentence = f"the relaxation did not settle in {self.most} iterations, its imbalance is {self.left:.3g} of"
            return Status(
                "not_converged", f"{sentence} the first.",
                "Raise iterations, go on with start=, or stiffen what moves freely.",
            )  # fmt: skip
        self.part, self.begun = self.part + 1, False
        return None

    def _settled(self) -> Status | None:
        """Newton's iteration, and off again from an equilibrium that the start is symmetric about."""
        outcome = self.newton.solve(self.x, self.loads)
        self.recorder.log.tried(self.newton.trail, solved=outcome.status is None)
        if outcome.status is not None:
            return outcome.status
        if not self.watch.pivots(self.x, 1.0):
            return Status("done", f"a stable equilibrium after {self.taken} iterations of relaxation.")
        self.nudges += 1
        if self.nudges == NUDGES:
            return Status(
                "not_converged",
                f"{self.taken} iterations of relaxation led to equilibria that are not stable.",
                "Begin elsewhere with start=, or refine the mesh.",
            )
        self.fall.nudge(self.x)
        self.fall.begin()
        return None


class _Fall:
    """The relaxation of one model: each step lowers the potential energy, or is tried again with a thicker fluid."""

    def __init__(self, newton: Newton, loads: Array) -> None:
        self.newton, self.loads, self.disc = newton, loads, newton.disc
        self.hessian = Hessian(newton, turn_length(newton.disc.mesh.r0))
        self.begin()

    def begin(self) -> None:
        """Before it falls anew."""
        self.pace, self.first, self.stuck = FIRST, 0.0, False

    def support(self, x: Array, factor: float) -> None:
        """Put supports where they are at a load factor, and the rest near to that."""
        if place_supports(self.disc, x, factor):
            self.spread(x)

    def spread(self, x: Array) -> None:
        """Move the positions to where they balance at the rotations as they are: what supports did at one end is then
        felt everywhere, and no element is folded. The energy of rods is quadratic in positions, so this is one solve.
        """
        hessian, newton = self.hessian, self.newton
        place = np.flatnonzero(hessian.free % 6 < 3)
        off = (newton.applied(x, self.loads) - newton.work.internal).ravel()[hessian.free][place]
        found = np.zeros(len(hessian.free))
        try:
            found[place] = splu(csc_matrix(hessian.matrix(x)[place][:, place])).solve(off)
        except RuntimeError:  # a link alone does not hold a position
            return
        kernel.move(hessian.increment(found), self.disc.nodes, x, True, False, np.inf)

    def energy(self, x: Array) -> tuple[float, float]:
        """Stored energy less the work that the loads can do, and the size of what was added up."""
        stored = float(self.newton.books(x).totals[0])
        work = self.loads[:, :3] * (x[: self.disc.nodes, :3] - self.disc.mesh.r0)
        return stored - float(work.sum()), stored + float(np.abs(work).sum())

    def step(self, x: Array) -> float:
        """Move ``x``; the imbalance before, relative to the first."""
        newton, hessian = self.newton, self.hessian
        off = (newton.applied(x, self.loads) - newton.work.internal).ravel()[hessian.free]
        off = off / hessian.weights[hessian.free]
        left = float(np.linalg.norm(off))
        self.first = self.first or left or 1.0
        stiffness = hessian.matrix(x)
        fluid = np.abs(stiffness.diagonal())
        fluid = np.maximum(fluid, 1e-6 * float(fluid.max()))
        before, start = self.energy(x), x.copy()
        while True:
            try:
                found = splu(csc_matrix(stiffness + diags(fluid / self.pace))).solve(off)
            except RuntimeError:  # singular
                found = np.zeros_like(off)
            _, turned, bad = kernel.move(hessian.increment(found), self.disc.nodes, x, False, False, LARGEST_TURN)
            after = self.energy(x)
            noise = ROUND_OFF * (before[1] + after[1])
            if bad < 0 and np.any(found) and off @ found >= 0.0 and after[0] <= before[0] + noise:
                if turned <= LARGEST_TURN:
                    self.pace = min(GROWTH * self.pace, LAST)
                return left / self.first
            x[:] = start
            self.pace *= CUT
            if self.pace < 1e-12:
                self.stuck = True
                return left / self.first

    def nudge(self, x: Array) -> None:
        """Move ``x`` a little along one of its unstable modes."""
        matrix = self.hessian.matrix(x)
        found = nearest_zero(matrix, negative_pivots(matrix) + 1)
        mode = self.hessian.increment(found.vectors[:, 0])
        size = max(float(np.abs(mode[:, 3:]).max()), float(np.abs(mode[:, :3]).max()) / self.disc.length)
        kernel.move(NUDGE / size * mode, self.disc.nodes, x, False, False, LARGEST_TURN)
