"""Many motions of models that differ: run in batches, here or on any executor, and kept under their labels."""

from __future__ import annotations

import os
import pickle
from collections.abc import Callable, Hashable, Iterator, Mapping, Sequence
from concurrent.futures import Executor, Future, as_completed
from dataclasses import dataclass, fields
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from directrix.bundle import Fit, fit_of, run
from directrix.checks import flag, number, reporting, shown, whole
from directrix.dynamics import moved, simulate
from directrix.errors import ModelError
from directrix.keeping import Folder, Many
from directrix.kernels.compile import LANES
from directrix.model import Model
from directrix.motion import Asked, Motion
from directrix.recorder import Progress
from directrix.result import Result
from directrix.threads import one_blas_thread

Array = NDArray[np.float64]
Build = Callable[[Any], Model]
Outcome = tuple[Hashable, Result | None, str]
Member = tuple[Hashable, Any, Folder | None]

__all__ = ["Ensemble", "ensemble"]

ASKED = {field.name for field in fields(Asked)}
NOTHING = None, ""  # is known of a member that was interrupted outside of its steps
SECONDS = 0.1  # of work a batch should have: sending it to another process costs some milliseconds


@dataclass(frozen=True)
class Ensemble:
    """What :func:`ensemble` gives back.

    Attributes
    ----------
    labels : of all members, in the order they were given
    results : one a member; None where there was nothing to run
    failures : label → sentence, for members that were refused or did not reach their end
    """

    labels: tuple[Hashable, ...]
    results: tuple[Result | None, ...]
    failures: Mapping[Hashable, str]

    def __len__(self) -> int:
        return len(self.labels)

    def __iter__(self) -> Iterator[Hashable]:
        return iter(self.labels)

    def __getitem__(self, label: Hashable) -> Result:
        """The result of a member; raises ModelError when there is none."""
        if label not in self.labels:
            raise ModelError(f"there is no member {shown(label)}", f"the labels are {shown(list(self.labels))}")
        result = self.results[self.labels.index(label)]
        if result is None:
            raise ModelError(f"member {shown(label)} has no result: {self.failures[label]}", "mend that member")
        return result

    @property
    def success(self) -> bool:
        """True when every member reached its end."""
        return not self.failures

    @property
    def complete(self) -> tuple[Hashable, ...]:
        """Labels of the members that reached their end."""
        return tuple(label for label in self.labels if label not in self.failures)

    def stack(self, quantity: Callable[[Result], Array]) -> Array:
        """``quantity`` of every complete member, one array with the members first: (len(complete), …).

        ``runs.stack(lambda run: run.node("tip").r)`` is (members, nt, 3). Raises ModelError where the members' arrays
        differ in shape.
        """
        arrays = [np.asarray(quantity(self[label])) for label in self.complete]
        shapes = {a.shape for a in arrays}
        if len(shapes) > 1:
            raise ModelError(
                f"the members' arrays have {len(shapes)} different shapes", "ask for a quantity that all share"
            )
        return np.stack(arrays) if arrays else np.zeros((0,))


def ensemble(
    members: Sequence[Any] | Mapping[Hashable, Any],
    t_end: float,
    dt: float,
    *,
    build: Build | None = None,
    executor: Executor | None = None,
    batch: int | None = None,
    folder: Folder | str | os.PathLike[str] | None = None,
    progress: Progress | None = None,
    bundle: bool = True,
    **options: Any,
) -> Ensemble:
    """Integrate the motion of many models.

    Chains of equal topology lie side by side in the lanes of the processor: the same numbers of elements, order and
    supports, in the order of the chain; all else may differ. Which these are says docs/performance.md; any length will
    do. A member that does not converge there, and any other, runs as :func:`simulate` runs it. What a member
    computes is the same to the last bit whoever is beside it, in whatever batches and wherever it runs; it is what
    ``simulate`` computes but for rounding.

    Parameters
    ----------
    members
        Models, or whatever ``build`` makes models of; labelled by their place, or by the keys of a mapping.
    t_end, dt, options
        As for :func:`simulate`, the same for all.
    build
        Makes the model of a member, where it runs: only the member travels to another process.
    executor
        Any ``concurrent.futures.Executor``: threads (the compiled steps run side by side), processes, or what MPI
        and Dask offer. Without one the members run here, batch after batch.
    batch
        Members to a task, who may lie side by side; by default so many that a task takes about 0.1 s.
    folder
        Where the members are kept, each in a folder with the name of its label: a path, or
        ``dx.Folder(path, resume=True)``, which takes those that are done from there, goes on with those that are not
        and runs those that are new. Every member then runs by itself.
    progress
        Called after every batch with the fraction done and a line of text. What it raises ends the run, which is kept.
    bundle
        False: every member runs by itself, to the bits of ``simulate``. For chains of which no two are alike, each of
        which would have a lane, and leave the others idle.

    Raises
    ------
    ModelError
        An argument or the folder cannot be right, or the members cannot be sent to where the executor runs. A member
        that cannot be right is a failure of that member only.
    """
    labelled = _labelled(members, build)
    number(t_end, "t_end")
    number(dt, "dt", above=0.0)
    side_by_side = flag(bundle, "bundle") and folder is None
    if batch is None:
        size = _batch(labelled, build, t_end / dt, LANES if side_by_side else 1)
    else:
        size = whole(batch, "batch", 1, 10**9)
    many = None if folder is None else Many.claim(folder, [label for label, _ in labelled], "members")
    placed: list[Member] = [(label, member, None if many is None else many.of(label)) for label, member in labelled]
    tasks = [placed[k : k + size] for k in range(0, len(placed), size)]
    settings = {"t_end": t_end, "dt": dt, **options}
    found: dict[Hashable, tuple[Result | None, str]] = {}
    report = reporting(progress)
    ending = "it was not run, or not known to have ended: the ensemble was interrupted"
    try:
        for outcomes in _run(tasks, build, settings, side_by_side, executor):
            found.update({label: (result, sentence) for label, result, sentence in outcomes if result or sentence})
            if any(_interrupted(outcome) for outcome in outcomes):
                raise KeyboardInterrupt  # it was caught where the member ran
            failed = sum(1 for _, sentence in found.values() if sentence)
            more = f", {failed} failed" if failed else ""
            report(len(found) / len(labelled), f"{len(found)} of {len(labelled)} members{more}")
    except KeyboardInterrupt:
        if many is not None:
            ending = f"{ending}. Go on with {many.again}."
    except ModelError as error:
        if not found:
            raise
        ending = f"it was not run: {error.what}"
    else:
        if many is not None:
            many.say(finished=True)
    labels = tuple(label for label, _ in labelled)
    kept = [found.get(label, (None, ending)) for label in labels]
    failures = {label: sentence for label, (_, sentence) in zip(labels, kept, strict=True) if sentence}
    return Ensemble(labels, tuple(result for result, _ in kept), failures)


def _labelled(members: Sequence[Any] | Mapping[Hashable, Any], build: Build | None) -> list[tuple[Hashable, Any]]:
    given: Any = members
    pairs: list[tuple[Hashable, Any]]
    if isinstance(given, Mapping):
        pairs = list(cast("Mapping[Hashable, Any]", given).items())
    elif isinstance(given, Sequence | np.ndarray) and not isinstance(given, str):
        pairs = list(enumerate(cast("Sequence[Any]", given)))
    else:
        raise ModelError(f"{shown(given)} are not members", "give a list of models, or a mapping from labels to models")
    if not pairs:
        raise ModelError("an ensemble needs a member", "give at least one model")
    if build is None:
        for label, member in pairs:
            if not isinstance(member, Model):
                raise ModelError(
                    f"member {shown(label)} is not a model: {shown(member)}", "give models, or build= to make them"
                )
    elif not callable(build):
        raise ModelError(f"{shown(build)} cannot be called", "give a function that makes a model of a member", "build=")
    return pairs


def _batch(members: Sequence[tuple[Hashable, Any]], build: Build | None, steps: float, abreast: int) -> int:
    """Members whose motions take about SECONDS, by the first: 5 ms each, and 2 µs for a step of an element; a whole
    number of times as many as go ``abreast``."""
    first = members[0][1]
    try:
        model = first if build is None else build(first)
        elements = sum(rod.elements for rod in model.rods)
    except Exception:  # a failure of that member, found when it runs
        elements = 10
    size = np.clip(SECONDS / (0.005 + 2e-6 * elements * steps), 1, max(1, len(members) // 8))
    return abreast * int(np.ceil(size / abreast))


def _run(
    tasks: list[list[Member]],
    build: Build | None,
    settings: dict[str, Any],
    side_by_side: bool,
    executor: Executor | None,
) -> Iterator[list[Outcome]]:
    if executor is None:
        for task in tasks:
            yield _task(task, build, settings, side_by_side)
        return
    if not hasattr(executor, "submit"):
        raise ModelError(
            f"{shown(executor)} is not an executor",
            "use concurrent.futures.ProcessPoolExecutor() or the like",
            "executor=",
        )
    pending: list[Future[list[Outcome]]] = []
    try:
        pending += [executor.submit(_task, task, build, settings, side_by_side) for task in tasks]
        for done in as_completed(pending):
            yield done.result()
    except (pickle.PicklingError, AttributeError, TypeError) as error:
        if "pickle" not in str(error).lower():
            raise
        raise ModelError(
            f"a member cannot be sent to another process: {error}",
            "give functions that a module defines, build= to make the models there, or an executor of threads",
            "executor=",
        ) from error
    finally:
        for future in pending:
            future.cancel()


def _interrupted(outcome: Outcome) -> bool:
    _, result, _ = outcome
    return outcome[1:] == NOTHING or (result is not None and result.status.code == "interrupted")


def _task(
    task: Sequence[Member], build: Build | None, settings: Mapping[str, Any], side_by_side: bool
) -> list[Outcome]:
    """Run the members of a batch; what one of them raises is its failure."""
    batch = _Batch(build, settings, side_by_side)
    with one_blas_thread():
        for member in task:
            batch.take(member)
            if batch.interrupted:
                break
        else:
            batch.end()
    return [batch.outcomes[label] for label, _, _ in task if label in batch.outcomes]


class _Batch:
    """Members that run where this is; those of one kind wait until there is one for every lane, or for the end."""

    def __init__(self, build: Build | None, settings: Mapping[str, Any], side_by_side: bool) -> None:
        self.build, self.settings = build, settings
        self.side_by_side = side_by_side and settings.keys() <= ASKED
        self.outcomes: dict[Hashable, Outcome] = {}
        self.waiting: dict[Hashable, list[tuple[Hashable, Model, Fit]]] = {}

    @property
    def interrupted(self) -> bool:
        """True when a run was asked to end."""
        return any(_interrupted(outcome) for outcome in self.outcomes.values())

    def take(self, member: Member) -> None:
        """Run a member, or let it wait."""
        self._keep(member[0], lambda: self._begun(*member))

    def end(self) -> None:
        """Run all who wait."""
        for kind in list(self.waiting):
            if not self.interrupted:
                self._together(self.waiting.pop(kind))

    def _keep(self, label: Hashable, run: Callable[[], Result | None]) -> None:
        try:
            result = run()
        except KeyboardInterrupt:  # while it was built, or after its last step
            self.outcomes[label] = label, *NOTHING
        except Exception as error:
            self.outcomes[label] = label, None, error.what if isinstance(error, ModelError) else repr(error)
        else:
            if result is not None:
                self.outcomes[label] = label, result, "" if result.success else str(result.status)

    def _begun(self, label: Hashable, member: Any, folder: Folder | None) -> Result | None:
        model = member if self.build is None else self.build(member)
        if not self.side_by_side:
            return simulate(model, folder=folder, **self.settings)
        motion = Motion(model, Asked(**self.settings))
        fit = fit_of(motion)
        if fit is None:
            return moved(motion)
        group = self.waiting.setdefault(fit.key, [])
        group.append((label, model, fit))
        if len(group) == LANES:
            self._together(self.waiting.pop(fit.key))
        return None

    def _together(self, group: list[tuple[Hashable, Model, Fit]]) -> None:
        try:
            results = run([fit for _, _, fit in group])
        except KeyboardInterrupt:
            self.outcomes |= {label: (label, *NOTHING) for label, _, _ in group}
            return
        for (label, model, _), result in zip(group, results, strict=True):
            self._keep(
                label, lambda model=model, result=result: simulate(model, **self.settings) if result is None else result
            )
