"""Collects the saved instants of a run and turns them into a Result."""

from __future__ import annotations

import platform
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from itertools import chain
from typing import Any, Literal, NamedTuple, Protocol, cast

import numpy as np
from numpy.typing import NDArray

from directrix import points
from directrix.audit import Audit
from directrix.discretisation import Discretisation
from directrix.formulations.layout import HISTORY
from directrix.growing import Growing
from directrix.newton import Books
from directrix.parts import Parts
from directrix.result import Energy, Momentum, Result, Status
from directrix.steplog import Log

Array = NDArray[np.float64]

__all__ = ["Feed", "Instants", "Progress", "Recorder", "feed_of"]

Progress = Callable[[float, str], None]


class Instants(NamedTuple):
    """Instants to be saved, k of them: times and load factors (k,), positions ``r`` (k, n, 3) of states ``x``
    (k, ≥ n, 40), totals (k, 11), strains (k, stations, 6), reactions (k, n, 6) and what joints do (k, joints, ≥ 6) as
    in ``Books``; ``ledger`` (k, …) as :meth:`Recorder.keep` has it."""

    t: Array
    factor: Array
    r: Array
    x: Array
    totals: Array
    strains: Array
    reaction: Array
    joints: Array
    ledger: Array


class Feed(Protocol):
    """A ``progress`` that is shown the saved instants as well, while a run goes on."""

    def keep(self, disc: Discretisation, kind: Literal["static", "dynamic"], instant: Mapping[str, Array]) -> None:
        """``instant`` has t, r (n, 3), R (n, 3, 3), v (n, 3), strain (stations, 6), totals and work. They are the
        run's own: to be read now, not to be written."""
        ...


def feed_of(progress: object) -> Feed | None:
    """``progress`` itself if it wants to see instants."""
    return cast("Feed", progress) if hasattr(progress, "keep") else None


class Recorder:
    """Grows one row per saved instant, of which so many are ``expected``; arrays are copied, so the solver may reuse
    its own.

    Rows and iterations that were taken away with :meth:`take` come back, through ``earlier``, for the result.
    """

    def __init__(
        self,
        disc: Discretisation,
        kind: Literal["static", "dynamic"],
        parts: Parts | None = None,
        record: Sequence[points.Recorder] = (),
        feed: Feed | None = None,
        expected: int = 16,
    ) -> None:
        self.disc, self.feed = disc, feed
        self.parts = Parts(disc.mesh) if parts is None else parts
        self.live = points.Live(record, disc.mesh, kind)
        self.kind: Literal["static", "dynamic"] = kind
        self.rows = Growing(expected)
        self.log = Log()
        self.iterations = self.log.iterations
        self.away = self.steps_away = self.size = 0
        self.started = time.perf_counter()

    @property
    def count(self) -> int:
        """Rows so far."""
        return self.away + self.rows.count

    def keep(self, t: float, factor: float, r: Array, x: Array, books: Books, ledger: tuple[float, ...]) -> None:
        """Save an instant with positions ``r`` of the state ``x``.

        ``ledger`` since the start: work, the part of it that prescribed motion did, what was dissipated; by source
        what was dissipated and the work.
        """
        totals, strains, reaction, joints = books.totals, books.strains, books.reaction, books.joints
        self.keep_all(
            Instants(
                np.array([t]), np.array([factor]), r[None], x[None], totals[None], strains[None], reaction[None],
                joints[None], np.array([ledger]),
            )
        )  # fmt: skip

    def keep_all(self, of: Instants) -> None:
        """Save instants that follow one another."""
        count, n = of.r.shape[:2]
        turns, spins = (of.x[:, :n, a : a + 9].reshape(count, n, 3, 3).transpose(0, 1, 3, 2) for a in (3, 27))
        row = {
            "scalars": np.concatenate([np.stack([of.t, of.factor], -1), of.ledger], -1), "totals": of.totals,
            "r": of.r, "R": turns, "v": of.x[:, :n, 24:27], "Rdot": spins,
            "reaction": of.reaction, "strain": of.strains,
            "history": of.x[:, n:, :HISTORY], "joints": of.joints[..., :6],
        }  # fmt: skip
        if self.feed is not None or self.live.points:
            for k in range(count):
                self._show({name: value[k] for name, value in row.items()})
        if not self.parts.whole:  # what follows from all of a state has to be found out now
            row |= self._derived(row)
        self.size += self.rows.add(self.parts.of(row))

    def _show(self, row: Mapping[str, Array]) -> None:
        """An instant to whoever looks on while the run goes on."""
        t, work = row["scalars"][0], row["scalars"][2]
        if self.feed is not None:
            instant = {name: row[name] for name in ("r", "R", "v", "strain", "totals")}
            self.feed.keep(self.disc, self.kind, {"t": np.array(t), **instant, "work": np.array(work)})
        self.live.write(t, row["r"], row["v"], row["strain"], lambda: self._pulled(row["strain"], row["scalars"]))

    def take(self) -> dict[str, Any]:
        """Rows and iterations since the last time, to be put where ``earlier`` of :meth:`result` finds them."""
        iterations = np.array(self.iterations[self.steps_away :], np.int64)
        return {"rows": self.rows.count, "iterations": iterations, **self.rows.rows()}

    def forget(self) -> None:
        """What was taken is safe."""
        self.away, self.steps_away, self.size = self.count, len(self.iterations), 0
        self.rows.clear()

    def go_on(self, earlier: Iterable[Mapping[str, Any]]) -> None:
        """Begin again behind what ``earlier`` gives, as :meth:`take` gave it."""
        self.rows.clear()
        self.away = self.size = 0
        del self.iterations[:]
        for part in earlier:
            self.away += part["rows"]
            self.iterations.extend(part["iterations"].tolist())
        self.steps_away = len(self.iterations)
        self.live.go_on(self.away)

    def adopt(self, result: Result, rows: int, steps: int) -> None:
        """Begin again behind the first ``rows`` of a result that this kind of run left, which wait to be taken."""
        energy, sources = result.energy, self.disc.sources.names
        none = np.zeros(len(result.t))
        taken = [energy.by_source.get(name, none) for name in sources]
        done = [energy.work_by_source.get(name, none) for name in sources]
        scalars = [result.t, result.load_factor, energy.work, energy.prescribed, energy.dissipated, *taken, *done]
        totals = np.zeros((len(result.t), 11))
        totals[:, 0], totals[:, 1] = energy.stored, energy.kinetic
        totals[:, 2:5], totals[:, 5:8] = result.momentum.linear, result.momentum.angular
        columns = {"scalars": np.stack(scalars, -1), "totals": totals}
        columns |= {name: getattr(result, name) for name in self.parts.names()}
        if not self.parts.whole:
            columns |= {f"link {name}": value for name, value in result.links.items()}
            columns |= {f"contact {name}": value for name, value in result.contacts.items()}
        self.rows.clear()
        self.rows.add({name: value[:rows] for name, value in columns.items()})
        self.iterations.extend(result.iterations[:steps].tolist())
        self.live.go_on(rows)

    def result(
        self, status: Status, audit: Audit, info: Mapping[str, Any], earlier: Iterable[Mapping[str, Any]] = ()
    ) -> Result:
        """Everything saved so far as a Result."""
        self.live.close()
        dt, cuts = self.log.arrays()
        waiting = self.rows.rows()
        found = waiting if not self.away else dict[str, Array]()
        first = 0
        # one part at a time: all of them twice may be more than there is room for
        for part in chain(earlier, [{"rows": self.rows.count, **waiting}]) if self.away else ():
            last = first + part["rows"]
            for name in part.keys() - {"rows", "iterations"}:
                if name not in found:
                    found[name] = np.empty((self.count, *part[name].shape[1:]))
                found[name][first:last] = part[name]
            first = last
        if self.parts.whole:
            found |= self._derived(found)
        scalars, totals = found["scalars"], found["totals"]
        about = {
            "directrix": _version("directrix"),
            "python": platform.python_version(),
            **{name: _version(name) for name in ("numpy", "scipy", "llvmlite", "h5py")},
            "elements": self.disc.elements,
            "nodes": self.disc.nodes,
            "solver": "chain" if self.disc.pattern.chain else "sparse",
            "wall_seconds": time.perf_counter() - self.started,
        }
        return Result(
            kind=self.kind,
            name=self.disc.model.name,
            mesh=self.parts.mesh,
            t=scalars[:, 0],
            load_factor=scalars[:, 1],
            energy=self._energy(totals, scalars),
            momentum=Momentum(totals[:, 2:5], totals[:, 5:8]),
            iterations=np.array(self.iterations, np.int64),
            trail=self.log.trail.iterations(),
            dt=dt,
            cuts=cuts,
            status=status,
            audit=audit,
            info={**about, **self.parts.info, **info},
            links=_named(found, "link "),
            contacts=_named(found, "contact "),
            history=found["history"],
            joints=found["joints"],
            **self.parts.filled(found, len(scalars)),
        )

    def _pulled(self, strain: Array, scalars: Array) -> Array:
        """Section forces (stations, 6) of one instant."""
        return self.disc.section_force(self._stressed(strain[None], scalars[None]))[0]

    def _derived(self, of: Mapping[str, Array]) -> dict[str, Array]:
        """Section forces, energy densities, links and contacts of rows (nt, …)."""
        stressed = self._stressed(of["strain"], of["scalars"])
        links = self.disc.link_states(of["r"], of["R"])
        contacts = self.disc.contact_states(of["r"])
        found = {"force": self.disc.section_force(stressed), "density": self.disc.stored_density(stressed)}
        found |= {f"link {name}": state for name, state in links.items()}
        return found | {f"contact {name}": state for name, state in contacts.items()}

    def _energy(self, totals: Array, scalars: Array) -> Energy:
        sources = self.disc.sources
        work, prescribed, dissipated = scalars[:, 2:5].T
        taken, done = (dict(zip(sources.names, a, strict=True)) for a in np.split(scalars[:, 5:].T, 2))
        working = {name: a for name, a in done.items() if name in sources.working}
        by_loads = work - prescribed - sum(working.values())
        return Energy(
            totals[:, 1], totals[:, 0], work, prescribed, dissipated,
            {name: a for name, a in taken.items() if name in sources.lossy},
            {"loads": by_loads, "supports": prescribed, **working},
        )  # fmt: skip

    def _stressed(self, strain: Array, scalars: Array) -> Array:
        """The part of the strains (nt, stations, 6) that is stressed."""
        if not self.disc.model.actuations:
            return strain
        return strain - np.array([self.disc.intrinsic(t, factor) for t, factor in scalars[:, :2].tolist()])


def _named(found: Mapping[str, Array], kind: str) -> dict[str, Array]:
    return {name.removeprefix(kind): value for name, value in found.items() if name.startswith(kind)}


@cache
def _version(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return "not installed"
