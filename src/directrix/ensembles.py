"""Many motions of models that differ: run in batches, here or on any executor, and kept under their labels."""

from __future__ import annotations

import os
import pickle
from collections.abc import Callable, Hashable, Iterator, Mapping, Sequence
from concurrent.futures import Executor, Future, as_completed
from dataclasses import dataclass
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from directrix.checks import number, reporting, shown, whole
from directrix.dynamics import simulate
from directrix.errors import ModelError
from directrix.keeping import Folder, Many
from directrix.model import Model
from directrix.recorder import Progress
from directrix.result import Result

Array = NDArray[np.float64]
Build = Callable[[Any], Model]
Outcome = tuple[Hashable, Result | None, str]
Member = tuple[Hashable, Any, Folder | None]

__all__ = ["Ensemble", "ensemble"]

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
    **options: Any,
) -> Ensemble:
    """Integrate the motion of many models.

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
        and Dask offer. Without one the members run here, one after the other. No bit of what each computes changes.
    batch
        Members to a task; by default so many that a task takes about 0.1 s.
    folder
        Where the members are kept, each in a folder with the name of its label: a path, or
        ``dx.Folder(path, resume=True)``, which takes those that are done from there, goes on with those that are not
        and runs those that are new.
    progress
        Called after every batch with the fraction done and a line of text. What it raises ends the run, which is kept.

    Raises
    ------
    ModelError
        An argument or the folder cannot be right, or the members cannot be sent to where the executor runs. A member
        that cannot be right is a failure of that member only.
    """
    labelled = _labelled(members, build)
    number(t_end, "t_end")
    number(dt, "dt", above=0.0)
    size = _batch(labelled, build, t_end / dt) if batch is None else whole(batch, "batch", 1, 10**9)
    many = None if folder is None else Many.claim(folder, [label for label, _ in labelled], "members")
    placed: list[Member] = [(label, member, None if many is None else many.of(label)) for label, member in labelled]
    tasks = [placed[k : k + size] for k in range(0, len(placed), size)]
    settings = {"t_end": t_end, "dt": dt, **options}
    found: dict[Hashable, tuple[Result | None, str]] = {}
    report = reporting(progress)
    ending = "it was not run, or not known to have ended: the ensemble was interrupted"
    try:
        for outcomes in _run(tasks, build, settings, executor):
            stopped = _interrupted(outcomes[-1])
            known = outcomes if outcomes[-1][1:] != NOTHING else outcomes[:-1]
            found.update({label: (result, sentence) for label, result, sentence in known})
            if stopped:
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


def _batch(members: Sequence[tuple[Hashable, Any]], build: Build | None, steps: float) -> int:
    """Members whose motions take about SECONDS, by the first: 10 ms each, and 2 µs for a step of an element."""
    first = members[0][1]
    try:
        model = first if build is None else build(first)
        elements = sum(rod.elements for rod in model.rods)
    except Exception:  # a failure of that member, found when it runs
        elements = 10
    return int(np.clip(SECONDS / (0.01 + 2e-6 * elements * steps), 1, max(1, len(members) // 8)))


def _run(
    tasks: list[list[Member]], build: Build | None, settings: dict[str, Any], executor: Executor | None
) -> Iterator[list[Outcome]]:
    if executor is None:
        for task in tasks:
            yield _task(task, build, settings)
        return
    if not hasattr(executor, "submit"):
        raise ModelError(
            f"{shown(executor)} is not an executor",
            "use concurrent.futures.ProcessPoolExecutor() or the like",
            "executor=",
        )
    pending: list[Future[list[Outcome]]] = []
    try:
        pending += [executor.submit(_task, task, build, settings) for task in tasks]
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


def _task(task: Sequence[Member], build: Build | None, settings: Mapping[str, Any]) -> list[Outcome]:
    """Run the members of a batch; what one of them raises is its failure."""
    outcomes: list[Outcome] = []
    for label, member, folder in task:
        try:
            result = simulate(member if build is None else build(member), folder=folder, **settings)
        except KeyboardInterrupt:  # while it was built, or after its last step
            outcomes.append((label, *NOTHING))
        except Exception as error:
            what = error.what if isinstance(error, ModelError) else repr(error)
            outcomes.append((label, None, what))
        else:
            outcomes.append((label, result, "" if result.success else str(result.status)))
        if _interrupted(outcomes[-1]):
            break
    return outcomes
