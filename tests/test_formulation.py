"""The director element against what defines it."""

from __future__ import annotations

import numpy as np
import sympy

from directrix.formulations.conformance import random_parameters
from directrix.formulations.directors import DirectorStep, Rule, audit, residual
from directrix.formulations.element import record_audit, record_step
from directrix.formulations.layout import Layout
from directrix.kernels.trace import Graph, derivative, dot, needed

RULES = {"energy-momentum": Rule(0.5, 0.5), "midpoint": Rule(0.0, 0.0, 1.0), "static": Rule(static=True)}


def test_energy_step_does_exactly_the_work_of_the_stored_energy() -> None:
    """With the energy–momentum rule f·Δx = ΔW for any two states, with the midpoint rule it is not."""
    rng = np.random.default_rng(1)
    layout = Layout(3, 2, False)
    p = random_parameters(rng, layout)
    p = p.tolist()
    q0, q1 = ([[rng.standard_normal(3).tolist() for _ in range(4)] for _ in range(layout.nn)] for _ in range(2))
    stored = [audit(layout, q, q, p)[0] for q in (q0, q1)]

    def work(rule: Rule) -> float:
        # positions alone: directors held, so that forces on r do all the work
        held = [[x1[0], *x0[1:]] for x0, x1 in zip(q0, q1, strict=True)]
        still = [[[0.0] * 3] * 4] * layout.nn
        step = [[np.subtract(x1[0], x0[0]).tolist(), *x0[1:]] for x0, x1 in zip(q0, held, strict=True)]
        out = np.array(residual(layout, rule, held, step, still, p, [0.0, 0.0])[0]).reshape(-1, 6)
        stored[1] = audit(layout, held, q1, p)[0]
        return sum(float(np.dot(f[:3], np.subtract(b[0], a[0]))) for f, a, b in zip(out, q0, held, strict=True))

    scale = max(abs(s) for s in stored)
    assert abs(work(RULES["energy-momentum"]) - (stored[1] - stored[0])) <= 1e-13 * scale


def test_float_trace_and_sympy_agree() -> None:
    layout, rule = Layout(2, 1, True), Rule(0.5, 0.5)
    rng = np.random.default_rng(2)
    p = random_parameters(rng, layout).tolist()
    q1, q0, v0 = ([[rng.standard_normal(3).tolist() for _ in range(4)] for _ in range(2)] for _ in range(3))
    floats, _ = residual(layout, rule, q1, q0, v0, p, [3.0, 2.0])
    s = sympy.Symbol("s")
    symbolic = [
        [[s * c if (i, k) == (0, 0) else c for c in v] for k, v in enumerate(node)] for i, node in enumerate(q1)
    ]
    exact, _ = residual(layout, rule, symbolic, q0, v0, p, [3.0, 2.0])
    np.testing.assert_allclose([float(e.subs(s, 1.0)) if hasattr(e, "subs") else e for e in exact], floats, rtol=1e-12)


def test_recorded_operations_are_merged_and_dead_ones_dropped() -> None:
    graph = Graph()
    a = graph.inputs("x", 3)
    b = graph.inputs("p", 3)
    assert (a[0] * b[0]).index == (b[0] * a[0]).index
    assert (a[0] + 0.0).index == a[0].index
    assert graph.value_of((a[0] * 0.0).index) == 0.0
    unused = a[1] * a[2]
    product = dot(a, b)
    assert unused.index not in needed(graph, [product])
    # d(a·b) in the direction a_0 += 2 is 2 b_0
    (slope,) = derivative(graph, [product], {a[0]: 2.0})
    assert slope.index == (2.0 * b[0]).index


def test_size_of_the_traces() -> None:
    """The price of the two-node element, so that a change of it is seen."""

    def count(recorded) -> int:
        graph, out = recorded
        return sum(graph.ops[i][0] in ("add", "sub", "mul", "div") for i in needed(graph, out))

    element, layout = DirectorStep(Rule(0.5, 0.5)), Layout(2, 1, True)
    assert count(record_step(element, layout, tangent=True)) <= 2800
    assert count(record_step(element, layout, tangent=False)) <= 950
    assert count(record_audit(element, layout)) <= 540
