"""One element through the machine code: for tests and for looking at an element by itself."""
# pyright: basic, reportCallIssue=false

import numpy as np

from directrix.formulations.element import COMMON, Element, record_step
from directrix.formulations.layout import PER_NODE, Layout
from directrix.kernels.call import call_kernel
from directrix.kernels.compile import LANES, kernel_address, padded
from directrix.kernels.jit import compiled

__all__ = ["run_step"]


@compiled
def _call(address, x, at, p, g, out):
    call_kernel(address, x, at, 0, p, 0, g, out)


def run_step(element: Element, layout: Layout, x, parameters, common):
    """Residual (6nn,) and tangent (6nn, 6nn) of one element, computed in every lane.

    ``x`` (nn + rows, PER_NODE) nodes and history, ``common`` up to COMMON scalars. Raises ArithmeticError if two
    lanes differ.
    """
    nn, nd = layout.nn, 6 * layout.nn
    at = np.repeat(PER_NODE * np.arange(len(x)), LANES)
    g = np.zeros(COMMON)
    g[: len(common)] = common
    out = np.zeros((LANES, padded(nd + nd * nd)))
    address = kernel_address(f"step {layout} {element}", lambda: record_step(element, layout, tangent=True))
    _call(address, np.ascontiguousarray(x).ravel(), at, np.repeat(parameters, LANES), g, out.reshape(-1))
    out = out[:, : nd + nd * nd]
    if not np.all(out == out[0]):
        raise ArithmeticError("lanes of one kernel disagree")
    blocks = out[0, nd:].reshape(nn, nn, 6, 6)  # [b, a, i, j]
    return out[0, :nd], blocks.transpose(1, 2, 0, 3).reshape(nd, nd)
