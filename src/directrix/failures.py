"""Why a run ended, by name: which member, which rotation increment, and the mode that is nearest to giving way."""
# pyright: reportUnknownMemberType=false, reportUnknownVariableType=false, reportUnknownArgumentType=false

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from directrix.kernels.tables import in_lanes
from directrix.mechanisms import parts_of
from directrix.motions import Part, axis_words, free_motions, largest_nodes
from directrix.newton import Newton
from directrix.result import Status
from directrix.tangents import whole_tangent

Array = NDArray[np.float64]
NOTHING = 1e-13  # of the entries of a tangent: what is no stiffness
CLOSE = 0.1  # of the stiffness without stress: below it a state is near a limit or a buckling load
FAR = 0.5  # of it: above this the loads have not much to do with it
RIGID = 0.05  # misfit of a rigid motion that still is one
LIMIT = (
    "the loads are at a limit or buckling load of that part; stay below it, stiffen the part, or follow the path with "
    "control=dx.ArcLength(…) or dx.DisplacementControl(…)."
)
REFINE = "Give the rod more elements or a higher order."
WHY = ("singular", "not_converged", "non_finite")

__all__ = ["Nearest", "explained", "nearest_mode"]


@dataclass(frozen=True, eq=False)
class Nearest:
    """The mode nearest to giving way: ``shape`` (n, 6) displacement and turn of the nodes, largest displacement (or
    turn) one; ``share`` its stiffness over that of the same shape without stress."""

    shape: Array
    share: float


def explained(newton: Newton, x: Array, status: Status, *, static: bool = True) -> Status:
    """The status of a step that failed, with what can be said of the last good state ``x``."""
    if status.code not in WHY:
        return status
    sentence = f"{status.sentence} {_turning(newton)}".strip()
    found = nearest_mode(newton, x) if np.all(np.isfinite(x)) else None
    if found is None:
        return Status(status.code, sentence, status.advice)
    if found.share > FAR:
        return Status(status.code, f"{sentence} No part is near to giving way.", status.advice)
    words = f"Nearest to giving way: {_in_words(newton, x, found.shape)}; {_share_words(found.share)}."
    advice = status.advice
    if static and found.share < CLOSE:
        advice = f"{REFINE} If that changes nothing, {LIMIT}" if newton.turn_sentence() else f"Likely {LIMIT}"
    return Status(status.code, f"{sentence} {words}", advice)


def nearest_mode(newton: Newton, x: Array) -> Nearest | None:
    """The free motion of least |stiffness|, by inverse iteration on the scaled tangent; None when it finds none."""
    from scipy.sparse import csc_matrix, diags, identity
    from scipy.sparse.linalg import splu

    disc = newton.disc
    free = np.flatnonzero(~disc.held.ravel())
    kept = csc_matrix(whole_tangent(newton, x)[free][:, free])
    if not len(free) or not np.all(np.isfinite(kept.data)):
        return None
    largest = abs(kept).max(axis=1).toarray().ravel()
    scale = 1.0 / np.sqrt(np.where(largest > 0.0, largest, 1.0))
    scaled = csc_matrix(diags(scale) @ kept @ diags(scale))
    try:
        factored = splu(csc_matrix(scaled + 1e-14 * identity(len(free))))
    except RuntimeError:
        return None
    block = np.random.default_rng(0).standard_normal((len(free), min(4, len(free))))
    for _ in range(12):
        block = factored.solve(np.linalg.qr(block)[0])
        if not np.all(np.isfinite(block)):
            return None
    q = np.linalg.qr(block)[0]
    values, vectors = np.linalg.eigh(q.T @ (scaled @ q))
    nearest = int(np.argmin(np.abs(values)))
    vector = scale * (q @ vectors[:, nearest])
    shape = np.zeros(disc.held.size)
    shape[free] = vector
    relaxed = whole_tangent(newton, x, newton.tables.replaced(par=_without_stress(newton, x)))
    share = float(shape @ (whole_tangent(newton, x) @ shape)) / max(float(shape @ (relaxed @ shape)), 1e-300)
    share = share if abs(values[nearest]) > NOTHING else 0.0
    out = shape.reshape(-1, 6)[: disc.nodes]
    far, turned = np.abs(out[:, :3]).max(), np.abs(out[:, 3:]).max()
    return Nearest(out / (far if far > 1e-6 * turned * disc.length else turned), share)


def _without_stress(newton: Newton, x: Array) -> Array:
    """Parameters of the kernels with the strains of ``x`` as those of the reference."""
    books = newton.books(x)
    strains = books.strains.copy()
    blocks: list[Array] = []
    for group in newton.disc.groups:
        parameters = group.parameters.copy()
        if not group.names:
            first, each = sum(group.layout.sizes[:3]), group.layout.points
            at = group.station[:, None] + np.arange(each)
            parameters[:, first : first + 6 * each] += strains[at].reshape(len(parameters), -1)
        blocks.append(in_lanes(parameters))
    return np.concatenate(blocks)


def _turning(newton: Newton) -> str:
    """The largest turn of the last iteration, where it says something."""
    step = newton.work.step[: newton.disc.nodes]
    turns = np.linalg.norm(step[:, 3:], axis=1)
    node = int(np.argmax(np.where(np.isfinite(turns), turns, np.inf)))
    if not np.isfinite(turns[node]):
        return f"Its last iteration asked for a turn that is no number, at {newton.disc.mesh.place(node)}."
    if turns[node] < 1e-6:
        return ""
    return f"Its last iteration asked {newton.disc.mesh.place(node)} to turn by {_degrees(float(turns[node]))}."


def _degrees(angle: float) -> str:
    degrees = float(np.degrees(angle))
    return f"{degrees:.3g}°" if degrees < 3600.0 else f"{degrees / 360.0:.0f} full turns"


def _share_words(share: float) -> str:
    if share == 0.0:
        return "nothing resists it"
    if share < 0.0:
        return "the stress makes its stiffness negative"
    return f"its stiffness is {100.0 * share:.3g} % of what it is without stress"


def _in_words(newton: Newton, x: Array, shape: Array) -> str:
    """Which part moves how, and where most."""
    mesh, parts = newton.disc.mesh, parts_of(newton.disc, x)
    scaled = [shape[p.nodes] * [1.0, 1.0, 1.0, p.size, p.size, p.size] for p in parts]
    first = int(np.argmax([np.linalg.norm(s) / np.sqrt(len(s)) for s in scaled]))
    part, moved = parts[first], scaled[first]
    far = np.linalg.norm(moved[:, :3], axis=1)
    spun = np.linalg.norm(moved[:, 3:], axis=1)
    rigid = part.moved().reshape(-1, 6)
    q: Array = np.asarray(np.linalg.lstsq(rigid, moved.ravel(), rcond=None)[0], float)
    if np.linalg.norm(rigid @ q - moved.ravel()) <= RIGID * np.linalg.norm(moved):
        how = f"moves as it is, {_rounded(part, q, newton)}"
    elif far.max() > 1e-3 * spun.max():
        how = f"bends or stretches, moving along {axis_words(moved[far.argmax(), :3])}"
    else:
        how = f"twists, turning about {axis_words(moved[spun.argmax(), 3:])}"
    top = largest_nodes(far if far.max() > 1e-3 * spun.max() else spun, part.nodes, mesh)
    return f"{part.name} {how}" + (f", largest at {', '.join(map(repr, top))}" if top else "")


def _rounded(part: Part, q: Array, newton: Newton) -> str:
    """A motion that is nearly rigid in words, small remainders left out."""
    kept = np.where(np.abs(q) > RIGID * np.abs(q).max(), q, 0.0).astype(np.float64)
    return free_motions(part, kept[:, None], newton.disc.mesh)
