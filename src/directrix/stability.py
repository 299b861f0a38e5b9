"""Vibration and linearised buckling about an equilibrium: matrices from the elements, eigenvalues by SciPy."""
# pyright: reportUnknownMemberType=false, reportUnknownVariableType=false, reportUnknownArgumentType=false
# pyright: reportOptionalSubscript=false

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import LinAlgError, eigh
from scipy.sparse import coo_matrix, csc_matrix
from scipy.sparse.linalg import ArpackNoConvergence, LinearOperator, eigsh, splu

from directrix.checks import whole
from directrix.contact_groups import refuse_rod_contacts
from directrix.diagnosis import at_start, refuse
from directrix.discretisation import Discretisation, discretise
from directrix.errors import ModelError
from directrix.formulations.director_acceleration import DirectorAcceleration
from directrix.kernels import step as kernel
from directrix.kernels.elements import element_tangents
from directrix.kernels.tables import Tables, in_lanes
from directrix.model import Model
from directrix.newton import Newton, Settings
from directrix.result import Mesh, Result
from directrix.scheme import Rates, Scheme
from directrix.state import initial_state

Array = NDArray[np.float64]
Pair = tuple[Array, Array]
SMALL = 300  # unknowns up to which matrices are treated as full

__all__ = ["BucklingLoads", "Modes", "buckling", "modes"]

# the tangent of the element with accelerations is K + c_a M
AT_REST = Scheme(DirectorAcceleration(), Rates.ALPHA, (0.0, 0.0, 1.0, 0.25, 0.5))


@dataclass(frozen=True)
class Modes:
    """Natural vibrations about an equilibrium, by rising ω².

    ``frequencies`` (count,) in cycles per unit of time, 0 where ω² ≤ 0; ``squares`` (count,) = ω², negative where the
    equilibrium is unstable; ``shapes`` (count, n, 6) displacement and spin of the nodes, with unit modal mass.
    """

    frequencies: Array
    squares: Array
    shapes: Array
    mesh: Mesh

    @property
    def stable(self) -> bool:
        """True when no ω² is negative beyond round-off."""
        return bool(self.squares[0] > -1e-9 * np.abs(self.squares).max())


@dataclass(frozen=True)
class BucklingLoads:
    """Linearised buckling about an equilibrium, by rising size of the factor.

    ``factors`` (count,): the loads that act times this make the stiffness singular; ``shapes`` (count, n, 6)
    displacement and spin of the nodes, largest displacement (or spin) 1.
    """

    factors: Array
    shapes: Array
    mesh: Mesh


def modes(model: Model, about: Result | None = None, count: int = 10) -> Modes:
    """Natural frequencies and shapes about an equilibrium: K φ = ω² M φ with the consistent mass.

    Parameters
    ----------
    model
        Rods with mass, supports, what is attached. Dead loads do not enter but through the state.
    about
        A static result whose last state is the equilibrium; the reference unless given.
    count
        How many, from the lowest up; at most a third of the unknowns.

    Raises
    ------
    ModelError
        Something cannot be right: a state in motion, loads that turn with their node, too many modes.
    """
    system = _System(model, about, dynamic=True)
    count = system.checked(count)
    stiffness, mass = system.matrix(), system.mass()
    try:
        shift = -1e-2 * _size_of_squares(stiffness, mass, count)
        squares, vectors = _lowest(stiffness, mass, count, shift)
    except (ArpackNoConvergence, RuntimeError) as error:
        raise ModelError(f"the eigenvalues could not be found: {error}", "ask for fewer modes, or refine") from None
    order = np.argsort(squares)
    squares = squares[order]
    frequencies = np.sqrt(np.maximum(squares, 0.0)) / (2.0 * np.pi)
    return Modes(frequencies, squares, system.shapes(vectors[:, order]), system.disc.mesh)


def _lowest(stiffness: csc_matrix, mass: csc_matrix, count: int, shift: float) -> Pair:
    """The ``count`` eigenvalues nearest above ``shift`` and their vectors, of unit modal mass."""
    if stiffness.shape[0] <= SMALL:
        try:  # of M and K − shift M: the low ones, of which there are few, are its largest
            theta, vectors = eigh(mass.toarray(), (stiffness - shift * mass).toarray())
            theta, vectors = theta[-count:], vectors[:, -count:]
            return 1.0 / theta + shift, vectors / np.sqrt(theta)
        except LinAlgError:  # there are eigenvalues below the shift
            pass
    return cast("Pair", eigsh(stiffness, k=count, M=mass, sigma=shift))


def _size_of_squares(stiffness: csc_matrix, mass: csc_matrix, count: int) -> float:
    """About the largest of the ``count`` lowest |ω²|, by some rounds of inverse iteration: a free body has no inverse
    stiffness, so the eigenvalues are sought from below zero, and this says how far below."""
    tiny = 1e-13 * float(np.abs(stiffness.diagonal()).max() / np.abs(mass.diagonal()).max())
    factored = splu(csc_matrix(stiffness + tiny * mass))
    block = np.random.default_rng(0).standard_normal((stiffness.shape[0], count + 4))
    for _ in range(6):
        block = np.linalg.qr(factored.solve(mass @ block))[0]
    small = eigh(block.T @ (stiffness @ block), block.T @ (mass @ block), eigvals_only=True)
    return max(float(np.sort(np.abs(small))[count - 1]), tiny)


def buckling(model: Model, about: Result | None = None, count: int = 4) -> BucklingLoads:
    """Linearised buckling: (K + μ K') φ = 0.

    The loads not marked constant are the pattern. K' is the stiffness of the section forces that they cause in first
    order, in the shape of the state: what they change in that shape before buckling is not seen, nor what they change
    in the tension of links.
    Factors count from the state ``about``, in loads of the model: about the reference they are the buckling loads.

    Parameters
    ----------
    model
        Rods, supports and the loads that may buckle them.
    about
        A static result whose last state is the equilibrium; the reference unless given.
    count
        How many factors, by rising size; both signs count.

    Raises
    ------
    ModelError
        Something cannot be right: no loads, a part that can move freely, loads that turn with their node.
    """
    system = _System(model, about, dynamic=False)
    refuse(at_start(system.newton, system.x, stressed=about is not None))
    count = system.checked(count)
    stiffness = system.matrix()
    factored = splu(stiffness)
    f = system.disc.external(1.0, 1.0)[:, :6] - system.disc.external(1.0, 0.0)[:, :6]
    if not np.any(f.ravel()[system.free]):
        raise ModelError(
            "there is no load that could buckle the model", "give a load that is neither constant nor on a support"
        )
    response = np.zeros(system.free.shape)
    response[system.free] = factored.solve(f.ravel()[system.free])
    strain = system.strain_rate(response)
    size = 1e-3 / np.abs(strain).max()
    rate = (system.matrix(size * strain) - system.matrix(-size * strain)) / (2.0 * size)
    n = stiffness.shape[0]
    operator: Any = LinearOperator
    inverse = operator((n, n), matvec=factored.solve, dtype=float)
    try:
        inverses, vectors = cast("Pair", eigsh(-rate, k=count, M=stiffness, Minv=inverse, which="LM"))
    except (ArpackNoConvergence, RuntimeError) as error:
        raise ModelError(
            f"the buckling factors could not be found: {error}", "ask for fewer, or refine the mesh"
        ) from None
    order = np.argsort(-np.abs(inverses))
    with np.errstate(divide="ignore"):
        factors = 1.0 / inverses[order]
    shapes = system.shapes(vectors[:, order])
    largest = np.abs(shapes[:, :, :3]).max(axis=(1, 2), keepdims=True)
    turned = np.abs(shapes[:, :, 3:]).max(axis=(1, 2), keepdims=True)
    return BucklingLoads(factors, shapes / np.where(largest > 1e-6 * turned, largest, turned), system.disc.mesh)


class _System:
    """Matrices on the free unknowns of a model about a state."""

    def __init__(self, model: Model, about: Result | None, dynamic: bool) -> None:
        if about is not None and (not isinstance(about, Result) or about.kind != "static"):  # pyright: ignore[reportUnnecessaryIsInstance]
            raise ModelError("about= is not an equilibrium", "give what solve_static returned", "about=")
        if about is not None and not about.success:
            raise ModelError(f"about= did not end well: {about.status.sentence}", "start from an equilibrium", "about=")
        if isinstance(model, Model):  # pyright: ignore[reportUnnecessaryIsInstance]
            refuse_rod_contacts(model, "small motions are about one system")
        self.scheme = AT_REST
        if not dynamic and (model.actuations or model.tendons):
            raise ModelError(
                "linearised buckling does not know what actuation and tendons do in first order",
                "follow the path with solve_static and a control, and look at modes about its states",
            )
        disc = discretise(model if dynamic else _with_mass(model), self.scheme)
        factor = 0.0 if about is None else float(about.load_factor[-1])
        self.disc: Discretisation = disc.driven_at(factor, factor)
        if np.any(self.disc.external(1.0)[:, 6:]):
            raise ModelError("a load turns with its node, and the stiffness is not symmetric", "leave followers out")
        if model.joints:
            raise ModelError(
                f"joint {model.joints[0].name!r}: vibration and buckling have no form for joints yet",
                "give nodes that are joined rigidly one name, or use stiff springs",
            )
        self.newton = Newton(self.disc, self.scheme, Settings())
        start = None if about is None else _at_rest(about)
        self.x = initial_state(self.disc, start, self.scheme)
        self.x[: self.disc.nodes, 24:36] = 0.0
        self.free = ~self.disc.fixed.ravel()

    def checked(self, count: int) -> int:
        """``count`` within what the model has."""
        most = max(1, int(self.free.sum()) // 3)
        return whole(count, "count", 1, most)

    def _tangent(self, tables: Tables, ca: float) -> csc_matrix:
        newton, n = self.newton, self.disc.nodes
        g = newton.globals.copy()
        g[1] = ca
        rows: list[Any] = []
        columns: list[Any] = []
        values: list[Array] = []
        for k, group in enumerate(self.disc.groups):
            ne, nn = group.conn.shape
            out = np.empty((ne, 6 * nn, 6 * nn))
            element_tangents(tables, newton.work, self.x, g, k, out)
            at = (6 * group.conn[:, :, None] + np.arange(6)).reshape(ne, -1)
            rows.append(np.repeat(at, 6 * nn, axis=1).ravel())
            columns.append(np.tile(at, (1, 6 * nn)).ravel())
            values.append(out.ravel())
        entries = np.concatenate(values)
        whole = coo_matrix((entries, (np.concatenate(rows), np.concatenate(columns))), shape=(6 * n, 6 * n)).tocsc()
        kept = csc_matrix(whole[:, np.flatnonzero(self.free)][np.flatnonzero(self.free)])
        return csc_matrix(0.5 * (kept + kept.T))  # the Hessian: the rest vanishes at an equilibrium

    def matrix(self, strain: Array | None = None) -> csc_matrix:
        """Stiffness at the state, its shape as it is, with the strains (stations, 6) more."""
        if strain is None:
            return self._tangent(self.newton.tables, 0.0)
        blocks: list[Array] = []
        for group in self.disc.groups:
            parameters = group.parameters.copy()
            if not group.names:
                first, each = sum(group.layout.sizes[:3]), group.layout.points
                at = group.station[:, None] + np.arange(each)
                parameters[:, first : first + 6 * each] -= strain[at].reshape(len(parameters), -1)
            blocks.append(in_lanes(parameters))
        return self._tangent(self.newton.tables._replace(par=np.concatenate(blocks)), 0.0)

    def strain_rate(self, response: Array) -> Array:
        """Strains (stations, 6) for one unit of an increment (6 n,), by a central difference."""
        step = response.reshape(-1, 6)
        size = 1e-5 / max(np.abs(step[:, 3:]).max(), np.abs(step).max() / self.disc.length)
        found: list[Array] = []
        for sign in (1.0, -1.0):
            x = self.x.copy()
            kernel.move(sign * size * step, self.disc.nodes, x, False, False, np.inf)
            found.append(self.newton.books(x).strains.copy())
        return (found[0] - found[1]) / (2.0 * size)

    def mass(self) -> csc_matrix:
        """Consistent mass at the state."""
        tables = self.newton.tables
        return csc_matrix(self._tangent(tables, 1.0) - self._tangent(tables, 0.0))

    def shapes(self, vectors: Array) -> Array:
        """Eigenvectors (free, count) as (count, n, 6)."""
        out = np.zeros((vectors.shape[1], len(self.free)))
        out[:, self.free] = vectors.T
        return out.reshape(len(out), -1, 6)


def _at_rest(about: Result) -> Result:
    """An equilibrium as a start of a motion."""
    return replace(about, v=0.0 * about.v, Rdot=0.0 * about.Rdot)


def _with_mass(model: Model) -> Model:
    """The model with some mass where it has none: stiffness does not ask for it, meshing for a motion does."""
    rods = tuple(
        replace(
            rod, section=replace(rod.section, A_rho=rod.section.A_rho or 1.0, I_rho=np.eye(2), damping=np.zeros((6, 6)))
        )
        for rod in model.rods
    )
    return replace(model, rods=rods)
