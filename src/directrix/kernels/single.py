"""One element through the machine code: for tests and for looking at an element by itself."""
# pyright: basic, reportCallIssue=false

import numpy as np

from directrix.formulations.directors import PER_NODE, Layout, Rule, record_step
from directrix.kernels.call import call_kernel
from directrix.kernels.compile import LANES, kernel_address, padded
from directrix.kernels.jit import compiled

__all__ = ["run_step"]


@compiled
def _call(address, x, at, p, g, out):
    call_kernel(address, x, at, 0, p, 0, g, out)


def run_step(layout: Layout, rule: Rule, states, parameters, dt):
    """Residual (6nn,) and tangent (6nn, 6nn) of one element, computed in every lane.

    ``states``: (r (nn, 3), R (nn, 3, 3)) of x1, x0 (with Δr for r) and the rate.
    Raises ArithmeticError if two lanes differ.
    """
    nn, nd = layout.nn, 6 * layout.nn
    x = np.zeros((nn, PER_NODE))
    for k, (r, q) in enumerate(states):
        x[:, 12 * k : 12 * k + 12] = np.concatenate([r, np.swapaxes(q, 1, 2).reshape(nn, 9)], 1)
    at = np.repeat(PER_NODE * np.arange(nn), LANES)
    out = np.zeros((LANES, padded(nd + nd * nd)))
    address = kernel_address(f"step {layout} {rule}", lambda: record_step(layout, rule, tangent=True))
    _call(address, x.ravel(), at, np.repeat(parameters, LANES), np.array(dt, float), out.reshape(-1))
    out = out[:, : nd + nd * nd]
    if not np.all(out == out[0]):
        raise ArithmeticError("lanes of one kernel disagree")
    blocks = out[0, nd:].reshape(nn, nn, 6, 6)  # [b, a, i, j]
    return out[0, :nd], blocks.transpose(1, 2, 0, 3).reshape(nd, nd)
