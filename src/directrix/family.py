"""Models that depend on one number, as the solvers see them: elements, loads and supports at each of its values."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from directrix.discretisation import Discretisation, discretise
from directrix.errors import ModelError
from directrix.kernels.tables import in_lanes
from directrix.model import Model
from directrix.scheme import Scheme

Array = NDArray[np.float64]

__all__ = ["Family"]

KEPT = 8  # values whose arrays are at hand: an iteration asks for a value and its two neighbours


class Family:
    """``make(p)`` for any p, all on the mesh of ``first``, which it began with. Raises ModelError for another mesh."""

    def __init__(self, make: Callable[[float], Model], first: Discretisation, scheme: Scheme) -> None:
        self.make, self.first, self.scheme = make, first, scheme
        self._known: dict[float, tuple[Discretisation, Array]] = {}

    def at(self, p: float) -> Discretisation:
        """The discretisation of ``make(p)``."""
        return self._look(p)[0]

    def parameters(self, p: float) -> Array:
        """Parameters of all elements, as the compiled loops read them."""
        return self._look(p)[1]

    def _look(self, p: float) -> tuple[Discretisation, Array]:
        if p not in self._known:
            disc = discretise(made(self.make, p), self.scheme)
            self._same(disc, p)
            while len(self._known) >= KEPT:
                del self._known[next(iter(self._known))]
            self._known[p] = disc, np.concatenate([in_lanes(group.parameters) for group in disc.groups])
        return self._known[p]

    def _same(self, disc: Discretisation, p: float) -> None:
        first = self.first
        same = (
            len(disc.groups) == len(first.groups)
            and all(
                a.layout == b.layout and a.element == b.element and np.array_equal(a.conn, b.conn)
                for a, b in zip(disc.groups, first.groups, strict=True)
            )
            and np.array_equal(disc.fixed, first.fixed)
            and disc.mesh.node_names == first.mesh.node_names
        )
        if not same:
            raise ModelError(
                f"the model at {p:g} has other elements, joints or supports than the one it began with",
                "let the parameter change numbers only: loads, lengths, stiffnesses, what is prescribed",
            )


def made(make: Callable[[float], Model], p: float) -> Model:
    """``make(p)``; raises ModelError where that fails or is no model."""
    try:
        model = make(p)
    except ModelError:
        raise
    except Exception as error:  # whatever a user's function raises
        raise ModelError(f"the function that makes the model fails at {p:g}: {error!r}", "return a dx.Model") from error
    if not isinstance(model, Model):  # pyright: ignore[reportUnnecessaryIsInstance]
        raise ModelError(f"the function that makes the model gives {model!r} at {p:g}", "return a dx.Model")
    return model
