"""Stored energies of sections: a plain Python function of the six strains is all that a law needs.

The function is called once with recording scalars; stress, tangent and machine code are derived from that record.
It may use + − × ÷, powers and NumPy's sqrt, exp, log, sin, cos, tanh, sinh and cosh, and must be smooth:
no comparison, no absolute value.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from directrix.checks import number
from directrix.errors import ModelError
from directrix.kernels.trace import Graph, Sym, derivative, needed, replay

Array = NDArray[np.float64]
Energy = Callable[[Sequence[Any]], Any]

__all__ = ["Energy", "Law", "stiffening_bending", "tension_only"]

SMOOTH = "use + − × ÷, powers and NumPy's sqrt, exp, log, sin, cos, tanh, sinh, cosh; no comparison, no abs"


@dataclass(frozen=True)
class Law:
    """A stored energy W(ε) per unit length, recorded once; two laws are equal when their records are.

    ``fingerprint`` stands for the record and the metric. :meth:`record` raises ModelError for a function that is no
    smooth energy of six strains.
    """

    fingerprint: str
    graph: Graph = field(compare=False, repr=False)
    outputs: tuple[Sym, ...] = field(compare=False, repr=False)
    metric: Array = field(compare=False, repr=False)

    @classmethod
    def record(cls, energy: Energy, metric: Array | None = None) -> Law:
        """Record ``energy(strain)``, strain = (shear 1, shear 2, axial, bending 1, bending 2, torsion).

        ``metric`` (6, 6), symmetric and positive definite, is the G of the discrete gradient and stands for the
        stiffness in tolerances and numerical damping; ∂²W/∂ε² at no strain unless given.
        """
        graph = Graph()
        strain = graph.inputs("e", 6)
        what = f"the energy {getattr(energy, '__name__', 'of a section')!r}"
        try:
            w = energy(strain)
        except Exception as error:  # whatever a user's function raises
            raise ModelError(f"{what} cannot be recorded: {error!r}", SMOOTH) from error
        if not isinstance(w, Sym):
            raise ModelError(f"{what} gives {w!r}, which does not depend on the strains", "return one energy")
        with np.errstate(all="ignore"):  # what is not finite is refused below
            w = w - replay(graph, [w], lambda _, __: 0.0)[0]
        stress = [derivative(graph, [w], {e: 1.0})[0] for e in strain]
        at = needed(graph, [w, *stress])
        text = repr([(i, graph.ops[i]) for i in at]) + repr([s.index for s in (w, *stress)])
        law = cls("", graph, (w, *stress), np.eye(6))
        with np.errstate(all="ignore"):
            finite = np.isfinite(law.energy([0.0] * 6)) and np.all(np.isfinite(law.hessian))
        if not finite:
            raise ModelError(f"{what} or its derivatives are not finite at no strain", SMOOTH)
        metric = law.hessian if metric is None else metric
        digest = hashlib.sha256(text.encode() + metric.tobytes()).hexdigest()[:16]
        return cls(digest, graph, (w, *stress), metric)

    def energy(self, e: Sequence[Any]) -> Any:
        """W(ε) − W(0), for six scalars of any kind."""
        return replay(self.graph, self.outputs[:1], lambda _, k: e[k])[0]

    def stress(self, e: Sequence[Any]) -> list[Any]:
        """∂W/∂ε, for six scalars of any kind."""
        return replay(self.graph, self.outputs[1:], lambda _, k: e[k])

    @cached_property
    def hessian(self) -> Array:
        """∂²W/∂ε² at no strain, (6, 6)."""
        graph = self.graph
        inputs = [Sym(graph, i) for i, (op, _, _) in enumerate(graph.ops) if op == "in"]
        columns = [derivative(graph, self.outputs[1:], {e: 1.0}) for e in inputs]
        return np.array([replay(graph, column, lambda _, __: 0.0) for column in columns], float).T

    def forces(self, strain: Array) -> Array:
        """Section forces (…, 6) from strains (…, 6)."""
        return np.stack(np.broadcast_arrays(*self.stress([strain[..., k] for k in range(6)])), -1)


def stiffening_bending(*, EA: float, GA1: float, GA2: float, EI1: float, EI2: float, GJ: float, onset: float) -> Energy:
    """Bending that stiffens exponentially, as rubbers and tissues do (after Fung 1967); linear in all else.

    W = ½(GA1 Γ1² + GA2 Γ2² + EA Γ3² + GJ Ω3²) + ½ β (exp(q) − 1), q = (EI1 Ω1² + EI2 Ω2²)/β, β = ½(EI1 + EI2) κ²,
    κ = ``onset``: at that curvature the moment is e times the linear one. Raises ModelError for a value that
    is not positive.
    """
    given = {"EA": EA, "GA1": GA1, "GA2": GA2, "EI1": EI1, "EI2": EI2, "GJ": GJ, "onset": onset}
    for name, value in given.items():
        number(value, name, above=0.0)
    beta = 0.5 * (EI1 + EI2) * onset**2

    def energy(e: Sequence[Any]) -> Any:
        straight = GA1 * e[0] ** 2 + GA2 * e[1] ** 2 + EA * e[2] ** 2 + GJ * e[5] ** 2
        return 0.5 * straight + 0.5 * beta * np.exp((EI1 * e[3] ** 2 + EI2 * e[4] ** 2) / beta)

    return energy


def tension_only(*, EA: float, GA1: float, GA2: float, EI1: float, EI2: float, GJ: float, width: float) -> Energy:
    """A cable: axial force EA Γ3 in tension, next to none in compression, with a smooth change; linear in all else.

    The axial part is ½ EA p², p = ½(Γ3 + √(Γ3² + w²)), w = ``width``; at Γ3 = 0 a tension of EA·width/4 is left. Raises
    ModelError for a value that is not positive.
    """
    given = {"EA": EA, "GA1": GA1, "GA2": GA2, "EI1": EI1, "EI2": EI2, "GJ": GJ, "width": width}
    for name, value in given.items():
        number(value, name, above=0.0)

    def energy(e: Sequence[Any]) -> Any:
        part = 0.5 * (e[2] + np.sqrt(e[2] ** 2 + width**2))
        rest = GA1 * e[0] ** 2 + GA2 * e[1] ** 2 + EI1 * e[3] ** 2 + EI2 * e[4] ** 2 + GJ * e[5] ** 2
        return 0.5 * EA * part**2 + 0.5 * rest

    return energy
