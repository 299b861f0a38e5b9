"""Collects the saved instants of a run and turns them into a Result."""

from __future__ import annotations

import platform
import time
from collections.abc import Callable, Mapping, Sequence
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from typing import Any, Literal, Protocol, cast

import numpy as np
from numpy.typing import NDArray

from directrix import points
from directrix.audit import Audit
from directrix.discretisation import Discretisation
from directrix.formulations.layout import HISTORY
from directrix.newton import Books
from directrix.result import Energy, Momentum, Result, Status
from directrix.steplog import Log

Array = NDArray[np.float64]

__all__ = ["Feed", "Progress", "Recorder", "feed_of"]

Progress = Callable[[float, str], None]


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
    """Grows one row per saved instant; arrays are copied, so the solver may reuse its own."""

    def __init__(
        self,
        disc: Discretisation,
        kind: Literal["static", "dynamic"],
        record: Sequence[points.Recorder] = (),
        feed: Feed | None = None,
    ) -> None:
        self.disc, self.feed = disc, feed
        self.live = points.Live(record, disc.mesh, kind)
        self.kind: Literal["static", "dynamic"] = kind
        self.rows: list[tuple[Array, ...]] = []
        self.log = Log()
        self.iterations = self.log.iterations
        self.started = time.perf_counter()

    def keep(self, t: float, factor: float, r: Array, x: Array, books: Books, ledger: tuple[float, ...]) -> None:
        """Save an instant with positions ``r`` of the state ``x``.

        ``ledger`` since the start: work, the part of it that prescribed motion did, what was dissipated; by source
        what was dissipated and the work.
        """
        n = len(r)
        if self.feed is not None:
            turns = x[:n, 3:12].reshape(n, 3, 3).transpose(0, 2, 1)
            instant = {"t": np.array(t), "r": r, "R": turns, "v": x[:n, 24:27], "strain": books.strains}
            self.feed.keep(self.disc, self.kind, {**instant, "totals": books.totals, "work": np.array(ledger[0])})
        rotations = [x[:n, a : a + 9].reshape(n, 3, 3).transpose(0, 2, 1).copy() for a in (3, 27)]
        scalars = np.array([t, factor, *ledger])
        self.rows.append(
            (
                scalars, r.copy(), rotations[0], x[:n, 24:27].copy(), rotations[1],
                books.reaction.copy(), books.strains.copy(), books.totals.copy(),
                x[n:, :HISTORY].copy(), books.joints[:, :6].copy(),
            )
        )  # fmt: skip
        self.live.write(t, r, x[:n, 24:27], books.strains, lambda: self._pulled(books.strains, scalars))

    def result(self, status: Status, audit: Audit, info: Mapping[str, Any]) -> Result:
        """Everything saved so far as a Result."""
        self.live.close()
        scalars, r, rotation, v, rates, reaction, strain, totals, history, joints = (
            np.stack(column) for column in zip(*self.rows, strict=True)
        )
        stressed = self._stressed(strain, scalars)
        dt, cuts = self.log.arrays()
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
            mesh=self.disc.mesh,
            t=scalars[:, 0],
            load_factor=scalars[:, 1],
            r=r,
            R=rotation,
            v=v,
            Rdot=rates,
            reaction=reaction,
            strain=strain,
            force=self.disc.section_force(stressed),
            density=self.disc.stored_density(stressed),
            energy=self._energy(totals, scalars),
            momentum=Momentum(totals[:, 2:5], totals[:, 5:8]),
            iterations=np.array(self.iterations, np.int64),
            dt=dt,
            cuts=cuts,
            status=status,
            audit=audit,
            info={**about, **info},
            history=history,
            joints=joints,
            links=self.disc.link_states(r, rotation),
            contacts=self.disc.contact_states(r),
        )

    def _pulled(self, strain: Array, scalars: Array) -> Array:
        """Section forces (stations, 6) of one instant."""
        return self.disc.section_force(self._stressed(strain[None], scalars[None]))[0]

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


@cache
def _version(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return "not installed"
