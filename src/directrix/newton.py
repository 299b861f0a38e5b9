"""Newton's iteration for one step: owns the workspace and the factorisation, knows no rods."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from directrix.checks import number, whole
from directrix.contact_groups import Pairs, union
from directrix.discretisation import Discretisation
from directrix.drives import Driver
from directrix.errors import ModelError
from directrix.formulations.contact import SOFTENING, ObstacleElement, PairElement
from directrix.keeping.memory import recall, remember
from directrix.kernels import step as kernel
from directrix.kernels.elements import PAR, SIZE, books_of
from directrix.kernels.judged import BEND, FIRST, GONE
from directrix.kernels.tables import damping_for, tables_for, work_for
from directrix.kernels.trace import cross
from directrix.linear.condensed import Condensed, usual
from directrix.linear.direct import Packaged
from directrix.linear.petsc import Petsc
from directrix.result import Status
from directrix.scheme import Rates, Scheme
from directrix.state import place_all, place_supports

if TYPE_CHECKING:
    from directrix.family import Family

Array = NDArray[np.float64]

UPSIDE_DOWN = 1.0 + 2.0 * np.cos(np.radians(170.0))
"""Σ d0·d1 of a node that turns too far in a step."""

__all__ = ["Books", "Newton", "Outcome", "Settings"]

WORTH = 0.5
"""A step begins with the factors of the last one if its increments are expected to shrink by less than this."""

CARRIED = ("applied", "reaction", "joints", "flow", "ground", "taken", "done", "scale", "notes")
"""What a step leaves in the workspace for its books and for the next one."""


@dataclass(frozen=True)
class Settings:
    """Stopping rule and damping.

    ``tolerance``: unbalanced force (moment) over the largest element force (moment), never below round-off;
    increments must also fall below 1e-9 of the model's size and 1e-9 rad. ``largest_turn`` [rad]: an
    iteration that would turn a node further is shortened. ``rotation`` "exponential" or "cayley". ``retry``: a step
    that is not solved is tried again with other damping. ``threads`` that share the solution of a frame;
    ``linear`` solves it, unless it is None. ``reuse``: its factors are kept while they bring an iteration to its end.
    """

    tolerance: float = 1e-9
    iterations: int = 50
    largest_turn: float = 0.3
    rotation: str = "exponential"
    retry: bool = True
    threads: int = 1
    linear: Petsc | Packaged | None = None
    reuse: bool = True

    def __post_init__(self) -> None:
        whole(self.threads, "threads", 1, 1024)
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
    """What :meth:`Newton.finish` books for a step: totals (11,) and flow (10,) as in the kernels, strains, reactions,
    loads as they acted (n, 6), force and moment on elements from outside (6,), what joints do (joints, ≥ 6); by source
    what was dissipated and the work done on elements; the largest force and moment of an element."""

    totals: Array
    flow: Array
    strains: Array
    reaction: Array
    applied: Array
    ground: Array
    joints: Array
    taken: Array
    done: Array
    scale: Array


class _Tangent(NamedTuple):
    """What the factors were made of: a state, the loads on it, and what drove the elements."""

    x: Array
    external: Array
    driven: list[list[Array]]


class Newton:
    """Solves steps of one discretisation under one scheme.

    ``x`` (≥ n, 40) is a state as in :mod:`directrix.state`; :meth:`solve` moves x1, :meth:`finish` makes it x0.
    """

    def __init__(self, disc: Discretisation, scheme: Scheme, settings: Settings) -> None:
        self.scheme, self.settings = scheme, settings
        self.pairs: Pairs | None = None
        self._use(disc)
        # the compiled loops read 0/1
        self.mask = disc.held.astype(np.uint8)
        self.options = np.array(
            [
                settings.tolerance, *_round_off(disc, scheme.inertia), disc.length, settings.largest_turn,
                settings.iterations, float(settings.rotation == "cayley"), 1.0, np.inf, 0.0,
            ]
        )  # fmt: skip
        self.totals, self.strains = np.zeros(11), np.zeros((disc.stations, 6))
        self.origin: Array = np.zeros(3)
        self.tried: list[Array] = []
        self.family: Family | None = None
        self.start: Array = np.zeros((0, 40))
        """The state that the last :meth:`solve` began with."""
        self.free = not disc.fixed.any() and not any(g.grounded for g in disc.groups)

    def loads(self, factor: float) -> Array:
        """Loads (n, 12) at a load factor; the parameters of the elements follow where they depend on it."""
        if self.family is None:
            return self.disc.external(factor, factor)
        self.tables = self.tables.replaced(par=self.family.parameters(factor))
        return self.family.at(factor).external(factor)

    def place(self, x: Array, factor: float) -> bool:
        """Move supports to where they are at a load factor; True when anything moved."""
        if self.family is None:
            return place_supports(self.disc, x, factor)
        return place_all(self.family.at(factor), x, factor)

    def _use(self, disc: Discretisation) -> None:
        """Tables and workspace for ``disc``."""
        self.disc = disc
        self.tables, self.work = tables_for(disc, self.scheme), work_for(disc, self.scheme)
        self.globals = self.work.common
        self.driver = Driver(disc.drives, self.tables.head[:, [PAR, SIZE]].tolist(), self.tables.par)
        self._sparse: Condensed | None = None
        self._tangent: _Tangent | None = None
        self.rough = any(isinstance(g.element, ObstacleElement | PairElement) and g.element.rough for g in disc.groups)
        # friction jumps between sticking and sliding, and carried rotations count from the last iteration: both have a
        # new tangent each time; the solver of a chain keeps no factors
        self._keeps = self.settings.reuse and not (self.rough or self.tables.carried or self.tables.chain)

    @property
    def sparse(self) -> Condensed:
        """The general solver; a chain needs it only when its own meets a vanishing pivot."""
        if self._sparse is None:
            pattern, linear = self.disc.pattern, self.settings.linear
            threads = self.settings.threads
            make = usual(threads) if linear is None else linear.maker(self._points(), threads)
            self._sparse = Condensed(pattern.rowptr, pattern.column, make)
        return self._sparse

    def _points(self) -> Array:
        """Where the block rows are in the reference (rows, 3); NaN for rows that are no nodes."""
        nodes = self.disc.pattern.node_of_row
        out = np.full((len(nodes), 3), np.nan)
        real = nodes < len(self.disc.mesh.r0)
        out[real] = self.disc.mesh.r0[nodes[real]]
        return out

    def _look_around(self, x: Array) -> None:
        """Take in what rods are about to touch at the state ``x``."""
        near, r = self.disc.near, x[: self.disc.nodes, :3]
        if near is not None and (self.pairs is None or near.outside(self.pairs, r, touching=False)):
            self._bring(near.around(r))

    def _bring(self, pairs: Pairs) -> None:
        before, driver = self.work, self.driver
        self.pairs = pairs
        self._use(self.disc.touching(pairs, self.scheme))
        self.work.reaction[:], self.work.joints[:] = before.reaction, before.joints
        self.driver.follow(driver)

    def solve(self, x: Array, external: Array, moved: bool = False) -> Outcome:
        """Move x1 until it balances ``external`` (n, 12), see :meth:`Discretisation.external`.

        ``moved`` says that supports were displaced since the last step: the positions are then solved for
        first, at the rotations as they are. A step at whose end rods touch that were not looked at is taken again
        with them.
        """
        near = self.disc.near
        self.tried = []
        if near is None or self.pairs is None:
            return self._upright(x, self._balance(x, external, moved))
        start, iterations = x.copy(), 0
        while True:
            outcome = self._balance(x, external, moved)
            iterations += outcome.iterations
            if outcome.status is not None:
                return Outcome(iterations, outcome.status)
            r = x[: self.disc.nodes, :3]
            if not near.outside(self.pairs, r, touching=True):
                at = near.crossed(r - x[: self.disc.nodes, 12:15], r)
                return self._upright(x, Outcome(iterations, None if at < 0 else self._crossed(at)))
            self._bring(union(self.pairs, near.around(r)))
            x[:] = start

    def _upright(self, x: Array, outcome: Outcome) -> Outcome:
        """Refuse a step in which a node turns upside down: where d0 and d1 have no mean, a step balances whatever the
        energy does."""
        if outcome.status is not None or not self.scheme.rates.half:
            return outcome
        n = self.disc.nodes
        dots = np.einsum("ni,ni->n", x[:n, 3:12], x[:n, 15:24])
        node = int(np.argmin(dots))
        if dots[node] >= UPSIDE_DOWN:
            return outcome
        sentence = (
            f"{self.disc.mesh.place(node)} would turn by {np.degrees(turn_of(dots[node])):.0f}° in one step, and half "
            "a turn has no middle."
        )
        return Outcome(outcome.iterations, Status("not_converged", sentence, "Take smaller steps."))

    def _crossed(self, node: int) -> Status:
        return Status(
            "not_converged",
            f"rods passed through one another in one step, at {self.disc.mesh.label(node)}.",
            "Take smaller steps: none should move a rod by its radius. Or raise the stiffness of the contact.",
        )

    def _balance(self, x: Array, external: Array, moved: bool) -> Outcome:
        self.start = start = x.copy()
        notes = self.work.notes
        rate = notes[BEND] * (notes[GONE] + notes[FIRST])  # if this step begins as the last one did
        kept = not moved and self._tangent is not None and bool(rate < WORTH and notes[FIRST] < kernel.LARGE_TURN)
        outcome = self._iterate(self.tables, x, external, moved, kept)
        if kept and outcome.status is not None:
            x[:] = start
            again = self._iterate(self.tables, x, external, moved)
            outcome = Outcome(outcome.iterations + again.iterations, again.status)
        if self.rough and outcome.status is not None:
            x[:] = start
            again = self._by_softer_friction(x, external, moved)
            outcome = Outcome(outcome.iterations + again.iterations, again.status)
        if self.disc.near is not None and outcome.status is not None:
            x[:] = start
            again = self._by_small_moves(x, external, moved)
            outcome = Outcome(outcome.iterations + again.iterations, again.status)
        # a time step is tried again with other damping before it is cut; and positions by themselves, which an
        # iteration may solve for, do not always have the freedom to close joints
        jointed = bool(self.disc.model.joints)
        if (not self.scheme.static and self.settings.retry) or jointed:
            again_for = ("not_converged", "singular") if jointed else ("not_converged",)
            for turn in (self.settings.largest_turn, 0.1):
                if outcome.status is None or outcome.status.code not in again_for:
                    break
                x[:] = start
                self.options[4], self.options[7] = turn, 0.0
                again = self._iterate(self.tables, x, external, moved and not jointed)
                outcome = Outcome(outcome.iterations + again.iterations, again.status)
                self.options[4], self.options[7] = self.settings.largest_turn, 1.0
        if outcome.status is not None and outcome.status.code == "singular" and self.tables.chain:
            x[:] = start
            again = self._iterate(self.tables.replaced(chain=0), x, external, moved)
            outcome = Outcome(outcome.iterations + again.iterations, again.status)
        if outcome.status is not None:
            self._tangent = None
        return outcome

    def _by_softer_friction(self, x: Array, external: Array, moved: bool) -> Outcome:
        """Iterations that jump to and fro between sticking and sliding: the slip speed comes down bit by bit."""
        total, soft, ratio, good = 0, 1e3, 10.0, x.copy()
        reached = np.inf
        while True:
            self.globals[SOFTENING] = soft
            outcome = self._iterate(self.tables, x, external, moved and np.isinf(reached))
            total += outcome.iterations
            if outcome.status is None and soft == 0.0:
                break
            if outcome.status is None:
                reached, good = soft, x.copy()
            elif np.isinf(reached) or ratio < 1.2:
                break
            else:
                ratio **= 0.5
                x[:] = good
            soft = reached / ratio if reached > 0.1 else 0.0
        self.globals[SOFTENING] = 0.0
        return Outcome(total, outcome.status)

    def _by_small_moves(self, x: Array, external: Array, moved: bool) -> Outcome:
        """Iterations that throw rods far beyond where they touch: none may move them by more than part of a radius."""
        assert self.disc.near is not None
        usual = self.options.copy()
        self.options[[5, 7, 8]] = 4.0 * self.settings.iterations, 0.0, 0.2 * self.disc.near.reach
        outcome = self._iterate(self.tables, x, external, moved)
        self.options[:] = usual
        return outcome

    def _iterate(self, tables: object, x: Array, external: Array, moved: bool, kept: bool = False) -> Outcome:
        control = np.array([0, 0, int(moved), 0, int(kept)], np.int64)
        self.work.trail[:, 2:4] = np.nan
        self.options[9] = self._keeps
        while True:
            code = kernel.newton(tables, self.work, x, self.globals, external, self.mask, self.options, control)
            if code in (kernel.SOLVE, kernel.AGAIN):
                du = self._new(x, external, bool(control[2])) if code == kernel.SOLVE else self._through()
                if du is not None:
                    self.work.du[:] = du
                    continue
                code = kernel.SINGULAR
            self.tried.append(self.work.trail[: control[1]].copy())
            return Outcome(int(control[1]), self.verdict(code, int(control[3])))

    def _new(self, x: Array, external: Array, frozen: bool) -> Array | None:
        """Increments through new factors; those of a motion are kept for the next step, with what they were made of."""
        self._tangent = None
        du = self.sparse.solve(self.work.blocks, self.work.rhs)
        if du is not None and self._keeps and not frozen and not self.scheme.static:
            self._tangent = _Tangent(x.copy(), external.copy(), self.driver.remember())
        return du

    def _through(self) -> Array | float:
        """Increments through the factors that are there; what cannot be taken gets a new tangent."""
        du = self.sparse.again(self.work.rhs)
        return np.nan if du is None else du

    @property
    def trail(self) -> Array:
        """The iterations (many, 5) of the last :meth:`solve`, see :class:`directrix.trail.Iterations`."""
        return np.concatenate(self.tried)

    def verdict(self, code: int, blame: int) -> Status | None:
        """What a code of the kernels and the node to blame mean; None for convergence."""
        if code == kernel.CONVERGED:
            return None
        place = self.disc.mesh.place(blame)
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
        self._tangent = None
        for _ in range(count):
            kernel.assemble(self.tables, self.work, x, self.globals, external, self.mask, False)
            du = self.sparse.solve(self.work.blocks, self.work.rhs)
            if du is None:
                break
            self.work.du[:] = du
            moved, turned, _ = kernel.advance(self.tables, self.work, x, False, False, np.inf)
            sizes.append(moved + turned)
        return sizes

    def applied(self, x: Array, external: Array) -> Array:
        """The loads (n, 6) of ``external`` as they act on ``x``, with followers turned."""
        self._look_around(x)
        kernel.internal_forces(self.tables, self.work, x, self.globals, external)
        return self.work.applied.copy()

    def accelerate(self, x: Array, external: Array) -> None:
        """Put the accelerations that balance ``external`` into the rows of the nodes' history (ALPHA).

        A step so short that the mass outweighs everything gives them; the balance at no step corrects them.
        """
        n, rows, common = self.disc.nodes, self.disc.rows, self.globals.copy()
        rates = x[:n, 24:36].copy()
        self._tangent = None
        omega = axial_rates(x[:n])
        self.globals[:2] = 0.0, 1e10 / common[2] ** 2
        x[:n, 24:27], x[:n, 30:33] = rates[:, :3], omega
        x[:n, 27:30] = x[:n, 33:36] = 0.0
        for _ in range(12):
            kernel.assemble(self.tables, self.work, x, self.globals, external, self.mask, False)
            du = self.sparse.solve(self.work.blocks, self.work.rhs)
            if du is None:
                break
            self.work.du[:] = du
            kernel.spread(self.tables, self.work)
            x[n:rows, :6] += self.work.step[n:]
            step = self.globals[1] * self.work.step[:n]
            x[:n, 27:30] += step[:, :3]
            x[:n, 33:36] += np.einsum("nci,ni->nc", x[:n, 3:12].reshape(n, 3, 3), step[:, 3:])
            if np.abs(step).max() <= 1e-14 * max(np.abs(x[:n, 27:30]).max(), np.abs(x[:n, 33:36]).max()):
                break
        for first in (0, 6):  # a0 and v̇0
            kept = x[rows : rows + n, first : first + 6]
            kept[:, :3], kept[:, 3:] = x[:n, 27:30], x[:n, 33:36]
        x[:n, 24:36] = rates
        self.globals[:] = common

    def retime(self, scheme: Scheme, x: Array) -> Array:
        """Take steps of another length from the state ``x`` on; the state as that scheme wants it."""
        if scheme == self.scheme:
            return x
        before, self.scheme, self._tangent = self.scheme, scheme, None
        self.globals[: len(scheme.common)] = scheme.common
        self.options[1:3] = _round_off(self.disc, scheme.inertia)
        if self.tables.damping.size:
            self.tables.damping[:] = damping_for(self.disc, scheme)[0]
        if scheme.rates is not Rates.ALPHA:
            return x
        # an acceleration a0 belongs to an instant that is Δt times a constant away from t0, where it is v̇0
        x, n, rows = x.copy(), self.disc.nodes, self.disc.rows
        known, ratio = x[rows : rows + n], scheme.common[2] / before.common[2]
        known[:, :6] = known[:, 6:12] + ratio * (known[:, :6] - known[:, 6:12])
        return x

    def begin(self, x: Array) -> None:
        """Prepare the rates of ``x`` for a step; before supports move."""
        self._look_around(x)
        kernel.begin(int(self.scheme.rates), self.tables.carried, self.disc.nodes, self.disc.rows, x, self.globals)

    def finish(self, x: Array, before: Array | None = None) -> Books:
        """Book the step and make x1 the start of the next one. The arrays are reused by the next call.

        ``before`` (n, 6) are the loads at the start of the step, where work is booked with the mean.
        """
        work = self.work
        before = work.applied if before is None else before
        kernel.finish(self.tables, work, x, self.globals, before, self.mask, self.totals, self.strains)
        self.driver.shift()
        flow = work.flow
        if self.free:
            flow[5:8] += _moment(self.origin, flow[2:5])
        books = self._about_zero()
        if self.free:
            self._follow(x)
        return books

    def positions(self, x: Array) -> Array:
        """Positions (n, 3) of a state."""
        return x[: self.disc.nodes, :3] + self.origin

    def _follow(self, x: Array) -> None:
        """Measure the positions of a free model from a point that goes along with it."""
        shift = self.shift(x[0, :3])
        if shift is not None:
            x[: self.disc.nodes, :3] -= shift

    def shift(self, first: Array) -> Array | None:
        """By how much the origin moves along with a model whose first node is at ``first``; None where it stays.

        Far from the origin positions lose the digits that strains are made of. The shift is a multiple of a power
        of two, so no digit of a position changes.
        """
        if np.abs(first).max() <= self.disc.length:
            return None
        grain = 2.0 ** np.floor(np.log2(self.disc.length))
        shift = np.rint(first / grain) * grain
        self.origin += shift
        return shift

    def remember(self) -> dict[str, Any]:
        """All that the next step depends on beside its state."""
        return {
            "own": remember(self, "origin", "totals", "strains"),
            "pairs": None if self.pairs is None else list(self.pairs),
            "driven": self.driver.remember(),
            "work": remember(self.work, *CARRIED),
            "tangent": None if self._tangent is None else self._tangent._asdict(),
        }

    def recall(self, memory: dict[str, Any]) -> Books:
        """Go on from what :meth:`remember` gave; the books of the last step."""
        if memory["pairs"] is not None:
            self._bring(tuple(memory["pairs"]))
        if memory["tangent"] is not None:
            self._remake(_Tangent(**memory["tangent"]))
        recall(self, memory["own"])
        recall(self.work, memory["work"])
        self.driver.recall(memory["driven"])
        return self._books()

    def _remake(self, tangent: _Tangent) -> None:
        """The factors of a tangent again, bit by bit."""
        self.driver.recall(tangent.driven)
        x, external = tangent.x.copy(), tangent.external
        kernel.assemble(self.tables, self.work, x, self.globals, external, self.mask, False)
        self._new(x, external, False)

    def _about_zero(self) -> Books:
        if self.free:
            self.totals[5:8] += _moment(self.origin, self.totals[2:5])
        return self._books()

    def _books(self) -> Books:
        work, n, by = self.work, self.disc.nodes, (self.work.taken, self.work.done, self.work.scale)
        applied, reaction = work.applied[:n], work.reaction[:n]
        return Books(self.totals, work.flow, self.strains, reaction, applied, work.ground, work.joints, *by)

    def books_of(self, states: Array, origins: Array) -> tuple[Array, Array]:
        """Totals (k, 11) and strains (k, stations, 6) of states (k, ≥ n, 40) of a model without contact, whose
        positions are measured from ``origins`` (k, 3)."""
        totals, strains = np.zeros((len(states), 11)), np.zeros((len(states), self.disc.stations, 6))
        books_of(self.tables, self.work, states, totals, strains)
        if self.free:
            totals[:, 5:8] += np.cross(origins, totals[:, 2:5])
        return totals, strains

    def books(self, x: Array) -> Books:
        """The books of a state as it is."""
        self._look_around(x)
        kernel.books(self.tables, self.work, x, self.totals, self.strains)
        self.work.flow[:] = 0.0
        self.work.joints[:] = 0.0
        self.work.reaction[:] = 0.0
        self.work.taken[:] = self.work.done[:] = 0.0
        return self._about_zero()


def turn_of(dots: float) -> float:
    """Angle [rad] between two neighbouring nodes from Σ_i d_i·d_i = 1 + 2 cos."""
    return float(np.arccos(np.clip(0.5 * (dots - 1.0), -1.0, 1.0)))


def _moment(at: Array, force: Array) -> tuple[float, ...]:
    """at × force; of three numbers ``numpy.cross`` takes many times longer than a step of a small model may."""
    return cross(at.tolist(), force.tolist())


def axial_rates(x: Array) -> Array:
    """Angular velocities (n, 3) in the frames of the nodes of a state."""
    n = len(x)
    columns, rates = x[:, 3:12].reshape(n, 3, 3), x[:, 27:36].reshape(n, 3, 3)
    omega = 0.5 * np.cross(columns, rates).sum(axis=1)
    return np.einsum("nci,ni->nc", columns, omega)


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
    for body in disc.model.bodies:
        force = max(force, inertia * body.mass * far)
        moment = max(moment, inertia * max(float(np.abs(body.euler).max()), body.mass * far * disc.length))
    return eps * force, eps * moment
