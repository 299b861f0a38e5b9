"""Vibration and linearised buckling about an equilibrium: matrices from the elements, eigenvalues by SciPy."""
# pyright: reportUnknownMemberType=false, reportUnknownVariableType=false, reportUnknownArgumentType=false
# pyright: reportOptionalSubscript=false

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import LinAlgError, eig, eigh
from scipy.sparse import csc_matrix
from scipy.sparse.linalg import ArpackNoConvergence, LinearOperator, eigs, eigsh, splu

from directrix.checks import Vec, vector
from directrix.diagnosis import at_start, refuse
from directrix.equilibrium import Linearised
from directrix.errors import ModelError
from directrix.hessian import negative_pivots
from directrix.modal import Modes
from directrix.model import Model
from directrix.result import Mesh, Result
from directrix.spinning import Spin

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
Pair = tuple[Array, Array]
SMALL = 300  # unknowns up to which matrices are treated as full
ON_AXIS = 1e-9  # of a load: what of it may point away from the axis of a spin

__all__ = ["BucklingLoads", "Modes", "buckling", "modes"]


@dataclass(frozen=True)
class BucklingLoads:
    """Linearised buckling about an equilibrium, by rising size of the factor.

    ``factors`` (count,): the loads that act times this make the stiffness singular; ``shapes`` (count, n, 6)
    displacement and spin of the nodes, largest displacement (or spin) 1.
    """

    factors: Array
    shapes: Array
    mesh: Mesh


def modes(
    model: Model, about: Result | None = None, count: int = 10, *, spin: Vec | None = None,
    centre: Vec = (0.0, 0.0, 0.0),
) -> Modes:  # fmt: skip
    """Natural frequencies and shapes about an equilibrium: K φ = ω² M φ with the consistent mass.

    Where a section or a link is damped, or in a steady spin, (λ² M + λ (C + G) + K) φ = 0 in its place: C the damping,
    G the gyroscopic terms, K with the centrifugal ones.

    Parameters
    ----------
    model
        Rods with mass, supports, what is attached. Dead loads do not enter but through the state.
    about
        A static result whose last state is the equilibrium; the reference unless given. In a spin the state to look for
        the steady one from.
    count
        How many, from the lowest up; at most a third of the unknowns.
    spin
        Angular velocity of everything about an axis, supports included: the steady state is computed first, and
        frequencies are those seen from the turning frame. Loads of the model act in full, along the axis alone.
    centre
        A point of that axis.

    Raises
    ------
    ModelError
        Something cannot be right: a state in motion, loads that turn with their node, too many modes, no steady state.
    """
    system = Linearised(model, about, dynamic=True)
    count = system.checked(count)
    try:
        if spin is None and not system.damped:
            stiffness, mass = system.stiffness(), system.mass
            squares, vectors = _undamped(system, stiffness, mass, count)
            values = np.where(squares < 0.0, np.sqrt(np.abs(squares)) + 0j, 1j * np.sqrt(np.abs(squares)))
        else:
            values, vectors = _quadratic(system, count, spin, centre)
            squares = -np.real(values**2)
    except (ArpackNoConvergence, RuntimeError) as error:
        raise ModelError(f"the eigenvalues could not be found: {error}", "ask for fewer modes, or refine") from None
    return _described(system, squares, values, vectors)


def _described(system: Linearised, squares: Array, values: Complex, vectors: NDArray[Any]) -> Modes:
    """The modes with all that is said of them."""
    disc, mass = system.disc, system.mass
    along = np.array([np.abs(vectors.conj().T @ (mass @ system.moved(k))) ** 2 for k in range(3)]).T
    shapes = system.shapes(vectors)
    books = system.newton.books(system.x)
    strain = books.strains.copy()
    bent: list[NDArray[Any]] = []
    pulled: list[NDArray[Any]] = []
    for shape in shapes:
        parts = [shape.real] if not np.iscomplexobj(shape) else [shape.real, shape.imag]
        rates = [system.rates(part.ravel())[0] if np.any(part) else np.zeros_like(strain) for part in parts]
        size = [1e-6 / max(float(np.abs(r).max()), 1e-300) for r in rates]
        forces = [
            (disc.section_force(strain + h * r) - disc.section_force(strain - h * r)) / (2.0 * h)
            for h, r in zip(size, rates, strict=True)
        ]
        bent.append(rates[0] if len(rates) == 1 else rates[0] + 1j * rates[1])
        pulled.append(forces[0] if len(forces) == 1 else forces[0] + 1j * forces[1])
    sizes = np.abs(values)
    n = disc.nodes
    state = (
        system.x[:n, :3].copy(), system.x[:n, 3:12].reshape(n, 3, 3).transpose(0, 2, 1).copy(), strain,
        disc.section_force(strain),
    )  # fmt: skip
    ratios = np.where(sizes > 0.0, -values.real / np.where(sizes > 0.0, sizes, 1.0), 0.0)
    return Modes(
        np.abs(values.imag) / (2.0 * np.pi), squares, shapes, disc.mesh, values,
        ratios if np.iscomplexobj(vectors) else np.zeros(len(values)), along / system.total_mass, np.array(bent),
        np.array(pulled), state,
    )  # fmt: skip


def _undamped(system: Linearised, stiffness: csc_matrix, mass: csc_matrix, count: int) -> Pair:
    """The ``count`` lowest ω² and their vectors (free, count) of unit modal mass, rigid motions among them exactly."""
    rigid = system.rigid()
    size = _size_of_squares(stiffness, mass, count)
    shift = -1e-2 * size
    while negative_pivots(csc_matrix(stiffness - shift * mass)) and shift > -1e12 * size:  # unstable: from below all
        shift *= 4.0
    squares, vectors = _lowest(stiffness, mass, count, shift)
    if rigid.shape[1]:
        inside = rigid.T @ (mass @ vectors)
        vectors = vectors - rigid @ inside
        modal = np.sqrt(np.einsum("nk,nk->k", vectors, mass @ vectors))
        elastic = modal > 0.5
        vectors = np.hstack([rigid, vectors[:, elastic] / modal[elastic]])
        squares = np.concatenate([np.zeros(rigid.shape[1]), squares[elastic]])
    order = np.argsort(squares, kind="stable")[:count]
    return squares[order], vectors[:, order]


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


def _quadratic(system: Linearised, count: int, spin: Vec | None, centre: Vec) -> tuple[Complex, Complex]:
    """The ``count`` smallest λ of (λ² M + λ C + K) φ = 0, one of each conjugate pair, and their vectors (free, count)
    of unit modal mass."""
    stiffness, first = _turning(system, spin, centre) if spin is not None else (system.stiffness(), None)
    mass = system.mass
    if system.damped:
        damping = system.damping()
        first = damping if first is None else csc_matrix(first + damping)
    assert first is not None
    n = stiffness.shape[0]
    unit = np.sqrt(_size_of_squares(stiffness, mass, count))  # of λ
    shift = 1e-3  # a free body has no inverse stiffness
    k, c, m = stiffness, csc_matrix(unit * first), csc_matrix(unit**2 * mass)
    factored = splu(csc_matrix(k + shift * c + shift**2 * m))

    def inverse(z: NDArray[Any]) -> NDArray[Any]:
        """(A − shift B)⁻¹ B z of the linear form in (q, λ q)."""
        q, p = z[:n], m @ z[n:]
        low = -factored.solve(np.asarray(p + c @ q + shift * (m @ q)))
        return np.concatenate([low, q + shift * low])

    wanted = min(2 * count + 4, 2 * n - 2)
    if n <= SMALL // 4:
        values, vectors = cast("tuple[Complex, Complex]", eig(np.array([inverse(e) for e in np.eye(2 * n)]).T))
    else:
        operator: Any = LinearOperator
        start = np.random.default_rng(0).standard_normal(2 * n)
        of = operator((2 * n, 2 * n), matvec=inverse, dtype=float)
        values, vectors = cast("tuple[Complex, Complex]", eigs(of, wanted, which="LM", v0=start, ncv=2 * wanted + 8))
    seen = np.abs(values) > 1e-14 * np.abs(values).max()
    found = unit * (1.0 / values[seen] + shift)
    vectors = vectors[:n, seen]
    upper = np.flatnonzero(found.imag >= -1e-12 * np.abs(found))
    order = upper[np.argsort(np.abs(found[upper]), kind="stable")][:count]
    found, vectors = found[order], vectors[:, order]
    modal = np.sqrt(np.einsum("nk,nk->k", vectors.conj(), mass @ vectors).real)
    largest = vectors[np.argmax(np.abs(vectors), axis=0), np.arange(len(order))]
    return found, vectors / (modal * largest / np.abs(largest))


def _turning(system: Linearised, spin: Vec, centre: Vec) -> tuple[csc_matrix, csc_matrix]:
    """Move the system to its steady spin; stiffness with the centrifugal part, and gyroscopic matrix."""
    turning = Spin(np.array(vector(spin, "spin")), np.array(vector(centre, "centre")))
    if not np.any(turning.rate):
        raise ModelError("spin = (0, 0, 0) is none", "leave it out", "spin=")
    external = system.disc.external(1.0)
    axis = turning.rate / np.linalg.norm(turning.rate)
    off = np.abs(np.cross(external[:, :6].reshape(-1, 3), axis)).max()
    if off > ON_AXIS * np.abs(external).max(initial=0.0) and off > 0.0:
        raise ModelError(
            "a load points away from the axis of the spin: in a turning frame it would not stand still",
            "leave it out, or let it act along the axis",
            "spin=",
        )
    turning.settle(system.newton, system.hessian, system.x, external)
    stiffness = csc_matrix(system.stiffness() + turning.stiffness(system.hessian, system.x))
    return stiffness, turning.gyroscopic(system.hessian, system.x)


def buckling(model: Model, about: Result | None = None, count: int = 4) -> BucklingLoads:
    """Linearised buckling: (K + μ K') φ = 0.

    The loads not marked constant are the pattern. K' is the stiffness of the section forces and of the tension of links
    that they cause in first order, in the shape of the state: what they change in that shape before buckling is not
    seen; for that follow the path (:attr:`Result.stability`).
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
    system = Linearised(model, about, dynamic=False)
    refuse(at_start(system.newton, system.x, stressed=about is not None))
    count = system.checked(count)
    stiffness = system.stiffness()
    factored = splu(stiffness)
    f = system.disc.external(1.0, 1.0)[:, :6] - system.disc.external(1.0, 0.0)[:, :6]
    if not np.any(f.ravel()[system.free]):
        raise ModelError(
            "there is no load that could buckle the model", "give a load that is neither constant nor on a support"
        )
    response = np.zeros(system.free.shape)
    response[system.free] = factored.solve(f.ravel()[system.free])
    strain, lengths = system.rates(response)
    size = 1e-3 / max(
        float(np.abs(strain).max()), max((abs(v) for v in lengths.values()), default=0.0) / system.disc.length
    )
    ahead, behind = (system.stiffness(h * strain, {name: h * v for name, v in lengths.items()}) for h in (size, -size))
    rate = (ahead - behind) / (2.0 * size)
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
