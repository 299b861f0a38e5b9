"""Work shared among threads so that the numbers do not depend on how many there are."""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterable
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from functools import lru_cache
from threading import Lock
from typing import Any

from threadpoolctl import ThreadpoolController

__all__ = ["Share", "crew", "in_turn", "one_blas_thread"]

_LOCK = Lock()
_HELD: list[Any] = []
"""The limit that is set, and one more for everyone who asked for it."""

Share = Callable[[Callable[[Any], Any], Iterable[Any]], list[Any]]


def in_turn(work: Callable[[Any], Any], pieces: Iterable[Any]) -> list[Any]:
    """``work(piece)`` for one piece after the other."""
    return [work(piece) for piece in pieces]


@lru_cache(maxsize=1)
def _libraries() -> ThreadpoolController:
    return ThreadpoolController()


@contextmanager
def one_blas_thread() -> Generator[None]:
    """BLAS and LAPACK work on the calling thread alone: how they share work among threads changes the last digits.

    The limit is that of the process: the first to ask sets it, the last to leave takes it back.
    """
    with _LOCK:
        if not _HELD:
            libraries: Any = _libraries()
            _HELD.append(libraries.limit(limits=1, user_api="blas"))
        _HELD.append(None)
    try:
        yield
    finally:
        with _LOCK:
            _HELD.pop()
            if len(_HELD) == 1:
                _HELD.pop().restore_original_limits()


@contextmanager
def crew(threads: int) -> Generator[Share]:
    """``share(work, pieces)``: a list of ``work(piece)`` by so many threads, BLAS on one thread each.

    Pieces must not depend on one another, and not on the number of threads.
    """
    with one_blas_thread():
        if threads == 1:
            yield in_turn
        else:
            with ThreadPoolExecutor(threads) as pool:
                yield lambda work, pieces: list(pool.map(work, pieces))
