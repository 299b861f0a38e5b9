"""Work shared among threads so that the numbers do not depend on how many there are."""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterable
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from functools import lru_cache
from typing import Any

from threadpoolctl import ThreadpoolController

__all__ = ["Share", "crew", "in_turn", "one_blas_thread"]

Share = Callable[[Callable[[Any], Any], Iterable[Any]], list[Any]]


def in_turn(work: Callable[[Any], Any], pieces: Iterable[Any]) -> list[Any]:
    """``work(piece)`` for one piece after the other."""
    return [work(piece) for piece in pieces]


@lru_cache(maxsize=1)
def _libraries() -> ThreadpoolController:
    return ThreadpoolController()


@contextmanager
def one_blas_thread() -> Generator[None]:
    """BLAS and LAPACK work on the calling thread alone: how they share work among threads changes the last digits."""
    libraries: Any = _libraries()
    with libraries.limit(limits=1, user_api="blas"):
        yield


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
