"""The books of a run: what every step conserved, and a verdict in words."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from directrix.formulations.directors import DirectorElement
from directrix.keeping.memory import recall, remember

if TYPE_CHECKING:
    from directrix.discretisation import Discretisation
    from directrix.integrators import Integrator
    from directrix.newton import Books
    from directrix.result import Result

Array = NDArray[np.float64]

__all__ = ["Audit", "DynamicBooks", "Entry", "StaticBooks", "report", "stepped"]

LEDGER = 1e-8  # of its largest term: kinetic or stored energy, work or dissipation so far
LIMIT = 1e-9  # relative; rounding leaves 1e-15 a step
WARN_TURN = np.pi / 6
FOLDED = np.pi / 2  # where interpolated directors bend back with no moment


@dataclass(frozen=True)
class Entry:
    """One line of the audit: a law, how far the run is from it, and how far it may be.

    ``value`` is relative to what ``relative_to`` says; ``claimed`` is False when the scheme does not promise
    this law, which is then reported and not judged.
    """

    law: str
    value: float
    limit: float
    relative_to: str
    claimed: bool = True

    @property
    def holds(self) -> bool:
        """True when within the limit (or not claimed)."""
        return (not self.claimed) or self.value <= self.limit


@dataclass(frozen=True)
class Audit:
    """Every law of a run and what was noticed on the way.

    ``entries`` are the laws; ``largest_turn`` [rad] between two neighbouring nodes of an element and where;
    ``director_loss`` the largest loss of orthonormality of the interpolated directors, √Σ(d_i·d_j − δ_ij)²;
    ``notes`` are warnings in sentences.
    """

    entries: tuple[Entry, ...]
    largest_turn: float = 0.0
    largest_turn_where: str = ""
    director_loss: float = 0.0
    notes: tuple[str, ...] = ()

    @property
    def passed(self) -> bool:
        """True when every claimed law holds."""
        return all(e.holds for e in self.entries)

    @property
    def verdict(self) -> str:
        """One sentence."""
        bad = [e.law for e in self.entries if not e.holds]
        if bad:
            return "FAILED: " + ", ".join(bad)
        claimed = [e.law for e in self.entries if e.claimed]
        return "passed: " + ", ".join(claimed) if claimed else "nothing is claimed by this scheme"


class _Turn:
    """Follows the largest turn of an element and the loss of orthonormality through a run."""

    def __init__(self, disc: Discretisation) -> None:
        self.disc, self.dots, self.element, self.loss = disc, 3.0, 0, 0.0

    def add(self, totals: Array) -> None:
        if totals[8] < self.dots:
            self.dots, self.element = float(totals[8]), int(totals[9])
        self.loss = max(self.loss, float(totals[10]))

    def remember(self) -> dict[str, Any]:
        return remember(self, "dots", "element", "loss")

    def audit(self, entries: list[Entry]) -> Audit:
        angle = float(np.arccos(np.clip(0.5 * (self.dots - 1.0), -1.0, 1.0)))
        where = self.disc.element_place(self.element)
        notes = list(self.disc.mesh.notes)
        if angle > FOLDED and any(isinstance(group.element, DirectorElement) for group in self.disc.groups):
            entries = [*entries, Entry("turn of an element", angle / FOLDED, 1.0, "90°")]
            notes.append(
                f"{where} turned by {np.degrees(angle):.0f}° between its nodes; past a right angle interpolated "
                "directors no longer hold it together, and nothing that came after is true: refine or raise the order"
            )
        elif angle > WARN_TURN:
            notes.append(
                f"{where} turns by {np.degrees(angle):.0f}° between its nodes; above 30° direct interpolation "
                "of directors loses accuracy: refine or raise the order"
            )
        return Audit(tuple(entries), angle, where, float(np.sqrt(self.loss)), tuple(notes))


class DynamicBooks:
    """Adds up the ledger of a motion, one step after the other (read by the loop, never by the solver).

    After every step: total − total(0) = work − dissipated, with no source dissipating less than nothing in any step,
    L − L(0) = ∫ΣF dt and J − J(0) = ∫ΣM dt, loads and supports together. What does not add up is kept as the largest
    deviation seen.
    """

    def __init__(self, disc: Discretisation, integrator: Integrator, first: Books) -> None:
        self.integrator = integrator
        self.mass = sum(
            rod.section.mean_mass * mesh.s[-1] for rod, mesh in zip(disc.model.rods, disc.mesh.rods, strict=True)
        ) + sum(body.mass for body in disc.model.bodies)
        # the energy of strains of 1e-8: what a rod at rest has by rounding is far below and proves nothing
        self.least = 0.5e-16 * sum(
            float(np.diag(rod.section.stiffness)[:3].max() * mesh.s[-1])
            for rod, mesh in zip(disc.model.rods, disc.mesh.rods, strict=True)
        )
        # what a rod at rest has by rounding: strains of 1e-15, over n equal steps √n times those of one
        stiff = max((float(np.diag(rod.section.stiffness)[:3].max()) for rod in disc.model.rods), default=0.0)
        self.rounded = 5e-15 / LIMIT * stiff
        self.reach = float(np.abs(disc.mesh.r0).max()) + disc.length
        self.start = first.totals.copy()
        self.work = self.prescribed = self.dissipated = self.given = 0.0
        self.taken, self.done = np.zeros(len(disc.sources.names)), np.zeros(len(disc.sources.names))
        self.turnover = np.zeros(3)  # Σ|impulse|, Σ|angular impulse|, Σdt²
        self.impulse = np.zeros(6)
        self.settled = 0.0, 0.0  # work and dissipation of the steps that are in all of this
        self.waiting: list[tuple[Array, Array, Array, Array]] = []
        self.off = np.zeros(3)
        self.kinetic = float(first.totals[1])
        self.term = float(first.totals[:2].max())  # largest of stored, kinetic, work and dissipated so far
        self.turn = _Turn(disc)
        self.turn.add(first.totals)

    def add(self, books: Books, dt: float) -> None:
        """Book one step of length ``dt``."""
        # what acts may cancel: a rod that rests on something has the impulse of its weight, not none
        force = max(float(np.linalg.norm(part)) for part in (books.flow[2:5], books.ground[:3], books.reaction[:, :3]))
        moment = max(float(np.linalg.norm(part)) for part in (books.flow[5:8], books.ground[3:]))
        self.add_steps(books.totals[None, :8].copy(), books.flow[None].copy(), np.array([[force, moment]]), dt)
        if self.taken.size:
            self.taken += books.taken
            self.done += books.done
            self.given = max(self.given, -float(books.taken.min()))
        self.turn.add(books.totals)

    def add_steps(self, totals: Array, flow: Array, acting: Array, dt: float) -> list[tuple[float, ...]]:
        """Book several steps of length ``dt``: ``totals`` (m, 8) W, T, L (3), J (3) at their ends, ``flow`` (m, 10) as
        in ``Books``, ``acting`` (m, 2) the size of the forces and moments that act from outside, cancelling or not.
        Gives ``flows`` after each of them, but for what is booked by source.

        The arrays are kept: what only the verdict needs is worked out for many steps at once.
        """
        so_far: list[tuple[float, ...]] = []
        for row in flow[:, (0, 1, 8, 9)].tolist():
            self.work += row[0] + row[1] + row[3]
            self.prescribed += row[1]
            self.dissipated += row[2]
            so_far.append((self.work, self.prescribed, self.dissipated))
        self.waiting.append((totals, flow, acting, np.full((len(flow), 1), dt)))
        if len(self.waiting) >= 512:
            self._settle()
        return so_far

    def _settle(self) -> None:
        if not self.waiting:
            return
        totals, flow, acting, dt = (np.concatenate(parts) for parts in zip(*self.waiting, strict=True))
        self.waiting = []
        work = _on(self.settled[0], flow[:, 0] + flow[:, 1] + flow[:, 9])
        dissipated = _on(self.settled[1], flow[:, 8])
        impulse = _on(self.impulse, dt * flow[:, 2:8])
        self.turnover = _on(self.turnover, np.column_stack([dt * acting, dt * dt]))[-1]
        energy = totals[:, 0] + totals[:, 1]
        terms = (totals[:, 0], totals[:, 1], np.abs(work), np.abs(dissipated))
        self.term = max(self.term, *(float(term.max()) for term in terms))
        self.kinetic = max(self.kinetic, float(totals[:, 1].max()))
        change = totals[:, 2:8] - self.start[2:8] - impulse
        off = np.stack(
            [
                np.abs(energy - self.start[0] - self.start[1] - work + dissipated),
                np.linalg.norm(change[:, :3], axis=1),
                np.linalg.norm(change[:, 3:], axis=1),
            ]
        )
        self.off = np.fmax(self.off, np.fmax.reduce(off, axis=1))
        self.settled, self.impulse = (float(work[-1]), float(dissipated[-1])), impulse[-1]

    def remember(self) -> dict[str, Any]:
        """The books as they are."""
        self._settle()
        names = (
            "work", "prescribed", "dissipated", "given", "taken", "done", "turnover", "impulse", "settled",
            "off", "term", "kinetic",
        )  # fmt: skip
        return {"own": remember(self, *names), "turn": self.turn.remember()}

    def recall(self, memory: dict[str, Any]) -> None:
        """Go on from what :meth:`remember` gave."""
        self.waiting = []
        recall(self, memory["own"])
        recall(self.turn, memory["turn"])

    @property
    def flows(self) -> tuple[float, ...]:
        """Since the start: work, the part of prescribed motion, what was dissipated; by source the last, and work."""
        return self.work, self.prescribed, self.dissipated, *self.taken.tolist(), *self.done.tolist()

    def error(self, energy: float) -> float:
        """How far the ledger is from closing at this energy, relative to the largest term so far."""
        scale = max(self.term, abs(energy), abs(self.work), self.least)
        off = abs(energy - float(self.start[0] + self.start[1]) - self.work + self.dissipated)
        return off / scale if scale > 0.0 else 0.0

    def audit(self) -> Audit:
        """The verdict on all steps booked so far."""
        self._settle()
        momentum = max(
            float(np.sqrt(2.0 * self.mass * self.kinetic)),
            self.turnover[0],
            self.rounded * float(np.sqrt(self.turnover[2])),
        )
        scale = (
            max(self.term, self.least),
            momentum,
            max(momentum * self.reach, self.turnover[1]),
        )
        value = [float(o / s) if s > 0.0 else 0.0 for o, s in zip(self.off, scale, strict=True)]
        claims = self.integrator
        back = Entry("dissipation", float(self.given / scale[0]) if scale[0] > 0.0 else 0.0, LIMIT, f"{scale[0]:.6g}")
        return self.turn.audit(
            [
                Entry("energy", value[0], LEDGER, f"{scale[0]:.6g}", claims.conserves_energy),
                Entry("linear momentum", value[1], LIMIT, f"{scale[1]:.6g}", claims.conserves_momenta),
                Entry("angular momentum", value[2], LIMIT, f"{scale[2]:.6g}", claims.conserves_momenta),
                *((back,) if self.dissipated else ()),
            ]
        )


class StaticBooks:
    """Global balance of every equilibrium: loads and reactions add up to no force and no moment.

    The work of the loads along the path is booked by the trapezoidal rule, so the energy ledger closes only as the
    steps shrink.
    """

    def __init__(self, disc: Discretisation, first: Books) -> None:
        self.length = disc.length
        self.work = self.prescribed = 0.0
        self.done = np.zeros(len(disc.sources.names))
        self.off = np.zeros(2)
        # what balances is what loads bring in or, where stresses balance each other, what elements carry; and where
        # nothing is stressed the force of strains of 1e-8, below which is rounding
        least = 1e-8 * max((float(np.diag(r.section.stiffness)[:3].max()) for r in disc.model.rods), default=0.0)
        self.scale = np.array([least, least * self.length])
        self.turn = _Turn(disc)
        self.turn.add(first.totals)

    def remember(self) -> dict[str, Any]:
        """The books as they are."""
        own = remember(self, "work", "prescribed", "done", "off", "scale")
        return {"own": own, "turn": self.turn.remember()}

    def recall(self, memory: dict[str, Any]) -> None:
        """Go on from what :meth:`remember` gave."""
        recall(self, memory["own"])
        recall(self.turn, memory["turn"])

    @property
    def flows(self) -> tuple[float, ...]:
        """Since the start: work, the part of prescribed motion, nothing dissipated; by source nothing, and work."""
        return self.work, self.prescribed, 0.0, *(0.0 * self.done).tolist(), *self.done.tolist()

    def add(self, books: Books, r: Array) -> None:
        """Book one equilibrium with positions ``r`` (n, 3)."""
        ledger = books.flow[:2]
        on = books.applied + books.reaction
        moments = on[:, 3:] + np.cross(r, on[:, :3])
        balance = np.concatenate([on[:, :3].sum(0), moments.sum(0)]) + books.ground
        self.off = np.fmax(self.off, [np.linalg.norm(balance[:3]), np.linalg.norm(balance[3:])])
        force, moment = (np.linalg.norm(p, axis=1).sum() for p in (on[:, :3], on[:, 3:]))
        force = max(force, moment / self.length, books.scale[0], books.scale[1] / self.length)
        self.scale = np.fmax(self.scale, (force, force * self.length))
        self.work += float(ledger[0] + ledger[1] + books.flow[9])
        self.done += books.done
        self.prescribed += float(ledger[1])
        self.turn.add(books.totals)

    def audit(self) -> Audit:
        """The verdict on all equilibria booked so far."""
        names = ("balance of forces", "balance of moments")
        return self.turn.audit(
            [
                Entry(name, float(o / s) if s > 0.0 else 0.0, 1e-7, f"{s:.6g}")
                for name, o, s in zip(names, self.off, self.scale, strict=True)
            ]
        )


def _on(start: Array | float, values: Array) -> Array:
    """Sums of ``values`` (m, …) so far, from ``start`` on: one after the other, so that it does not matter how many are
    added at a time."""
    return np.cumsum(np.concatenate([np.asarray(start)[None], values]), axis=0)[1:]


def _workers(result: Result) -> dict[str, Array]:
    """Who did work, if there is more than one."""
    by = result.energy.work_by_source
    most = max((float(np.abs(done).max()) for done in by.values()), default=0.0)
    working = {name: done for name, done in by.items() if np.abs(done).max() > 1e-12 * most}
    return working if len(working) > 1 else {}


def stepped(result: Result) -> list[str]:
    """How long steps were and how often they were cut, where that says something."""
    cuts, rejected, dt = result.info.get("cuts", 0), result.info.get("rejected", 0), result.dt
    lengths = [f"steps of {dt.min():.3g} … {dt.max():.3g}"] if dt.size and dt.min() < dt.max() else []
    thrown = [f"{cuts} times cut because Newton failed"] if cuts else []
    thrown += [f"{rejected} taken again because the error was too large"] if rejected else []
    return ["  " + ", ".join(lengths + thrown)] if lengths or thrown else []


def report(result: Result) -> str:
    """The whole result in a few lines, for ``print(result)``."""
    info, audit = result.info, result.audit
    size = f"{info.get('nodes', '?')} nodes, {info.get('elements', '?')} elements ({info.get('solver', '?')} solver)"
    scheme = info.get("integrator") or info.get("control", "load control")
    iterations = result.iterations
    mean = f"{iterations.mean():.2f} Newton iterations a step" if iterations.size else "no step"
    clock = "t" if result.kind == "dynamic" else "load factor"
    lines = [
        f"{result.name}: {'done' if result.success else 'NOT DONE'}: {result.status}",
        f"  {result.kind}, {scheme}, {size}",
        f"  {clock} = {result.t[0]:g} … {result.t[-1]:g}, {iterations.size} steps, {mean}",
        *stepped(result),
        f"  energy: kinetic {result.energy.kinetic[-1]:.9g}, stored {result.energy.stored[-1]:.9g}, "
        f"total {result.energy.total[-1]:.9g}; work done on it {result.energy.work[-1]:.9g}"
        + (f", dissipated {result.energy.dissipated[-1]:.9g}" if result.energy.dissipated[-1] else ""),
        *(f"  dissipated by {name}: {taken[-1]:.9g}" for name, taken in result.energy.by_source.items()),
        *(f"  work of {name}: {done[-1]:.9g}" for name, done in _workers(result).items()),
        f"  {'law':<20}{'deviation':>12}{'allowed':>12}  relative to",
    ]
    for e in audit.entries:
        mark = "ok" if e.holds else "FAILED"
        lines.append(
            f"  {e.law:<20}{e.value:>12.2e}{e.limit:>12.0e}  {e.relative_to:<12} {mark if e.claimed else 'not claimed'}"
        )
    lines.append(f"  audit {audit.verdict}")
    if info.get("elements", 1):
        lines.append(
            f"  largest turn in an element {np.degrees(audit.largest_turn):.1f}° ({audit.largest_turn_where}), "
            f"directors off orthonormal by {audit.director_loss:.1e}"
        )
    if result.stability is None:
        lines += [f"  {point}" for point in result.turning_points]
    else:
        stable = result.stability.stable
        lines.append(f"  stable: {int(stable.sum())} of {len(stable)} saved states")
        lines += [f"  {point}" for point in result.stability.points]
    lines += [f"  note: {note}" for note in audit.notes]
    return "\n".join(lines)
