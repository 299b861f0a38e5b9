"""The decorator of the compiled loops."""
# pyright: basic

import hashlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

from numba import njit
from numba.core.caching import FunctionCache

__all__ = ["compiled", "inner"]

_FILES = sorted(Path(__file__).parent.glob("*.py"))
_SOURCES = hashlib.sha256(b"\0".join(f.read_bytes() for f in _FILES)).hexdigest()


class _Cache(FunctionCache):
    """Numba looks for changes only in the file of the function itself; loops call loops in other files."""

    def _index_key(self, sig, codegen):
        return (*super()._index_key(sig, codegen), _SOURCES)


def compiled(function: Callable[..., Any]) -> Callable[..., Any]:
    """``numba.njit`` with a cache that notices a change in any file of this folder; 1/0 gives inf, not an error."""
    return _kept(function, nogil=True)


def inner(function: Callable[..., Any]) -> Callable[..., Any]:
    """:func:`compiled` for what only compiled loops call: quicker to compile, not to be called from Python."""
    return _kept(function, no_cpython_wrapper=True, no_cfunc_wrapper=True)


def _kept(function: Callable[..., Any], **options: Any) -> Callable[..., Any]:
    dispatcher: Any = njit(error_model="numpy", **options)(function)
    dispatcher._cache = _Cache(function)
    return dispatcher
