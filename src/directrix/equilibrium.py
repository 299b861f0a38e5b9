"""A model about one of its equilibria, linearised: stiffness, mass, damping, rigid motions."""
# pyright: reportUnknownMemberType=false, reportUnknownVariableType=false, reportUnknownArgumentType=false

from __future__ import annotations

from dataclasses import replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import null_space
from scipy.sparse import csc_matrix

from directrix.checks import whole
from directrix.contact_groups import refuse_rod_contacts
from directrix.discretisation import Discretisation, discretise
from directrix.errors import ModelError
from directrix.formulations.attached import LinkElement
from directrix.formulations.director_acceleration import DirectorAcceleration
from directrix.formulations.directors import DirectorStep, Rule
from directrix.hessian import Hessian, largest_entry, not_conservative
from directrix.kernels import step as kernel
from directrix.kernels.tables import in_lanes
from directrix.model import Model
from directrix.newton import Newton, Settings
from directrix.result import Result
from directrix.scheme import Rates, Scheme
from directrix.state import initial_state

Array = NDArray[np.float64]

__all__ = ["Linearised"]

# the tangent of the element with accelerations is K + c_a M, that of a midpoint step ½ K + C/Δt at no step
AT_REST = Scheme(DirectorAcceleration(), Rates.ALPHA, (0.0, 0.0, 1.0, 0.25, 0.5))
MIDPOINT = Scheme(DirectorStep(Rule(w0=0.5, w1=0.5)), Rates.MIDPOINT, (0.0, 0.0))
BALANCED = 1e-7  # of the largest force in an element: what may act on a node of a body that nothing holds


class Linearised:
    """Matrices on the free unknowns of a model about a state."""

    def __init__(self, model: Model, about: Result | None, dynamic: bool) -> None:
        if about is not None and (not isinstance(about, Result) or about.kind != "static"):  # pyright: ignore[reportUnnecessaryIsInstance]
            raise ModelError("about= is not an equilibrium", "give what solve_static returned", "about=")
        if about is not None and not about.success:
            raise ModelError(f"about= did not end well: {about.status.sentence}", "start from an equilibrium", "about=")
        if isinstance(model, Model):  # pyright: ignore[reportUnnecessaryIsInstance]
            refuse_rod_contacts(model, "small motions are about one system")
        self.model, self.scheme = model, AT_REST
        if not dynamic and (model.actuations or model.tendons):
            raise ModelError(
                "linearised buckling does not know what actuation and tendons do in first order",
                "follow the path with solve_static and a control, and look at modes about its states",
            )
        if model.joints:
            raise ModelError(
                f"joint {model.joints[0].name!r}: vibration and buckling have no form for joints yet",
                "give nodes that are joined rigidly one name, or use stiff springs",
            )
        disc = discretise(_without_damping(model if dynamic else _with_mass(model)), self.scheme)
        self.factor = 0.0 if about is None else float(about.load_factor[-1])
        self.disc: Discretisation = disc.driven_at(self.factor, self.factor)
        self.newton = Newton(self.disc, self.scheme, Settings())
        self.conservative = not_conservative(self.newton)
        if np.any(self.disc.external(1.0)[:, 6:]):
            raise ModelError("a load turns with its node, and the stiffness is not symmetric", "leave followers out")
        start = None if about is None else replace(about, v=0.0 * about.v, Rdot=0.0 * about.Rdot)
        self.x = initial_state(self.disc, start, self.scheme)
        self.x[: self.disc.nodes, 24:36] = 0.0
        self.hessian = Hessian(self.newton)
        self.free = ~self.disc.fixed.ravel()

    def checked(self, count: int) -> int:
        """``count`` within what the model has."""
        most = max(1, int(self.free.sum()) // 3)
        return whole(count, "count", 1, most)

    def stiffness(self, strain: Array | None = None, lengths: dict[str, float] | None = None) -> csc_matrix:
        """Stiffness at the state, its shape as it is, with the strains (stations, 6) and lengths of links more."""
        if strain is None:
            return self.hessian.matrix(self.x)
        blocks: list[Array] = []
        for group in self.disc.groups:
            parameters = group.parameters.copy()
            if not group.names:
                first, each = sum(group.layout.sizes[:3]), group.layout.points
                at = group.station[:, None] + np.arange(each)
                parameters[:, first : first + 6 * each] -= strain[at].reshape(len(parameters), -1)
            elif lengths and isinstance(group.element, LinkElement):
                parameters[:, 7] -= [lengths.get(name, 0.0) for name in group.names]  # what a link is without tension
            blocks.append(in_lanes(parameters))
        return self.hessian.matrix(self.x, self.newton.tables.replaced(par=np.concatenate(blocks)))

    def rates(self, response: Array) -> tuple[Array, dict[str, float]]:
        """Strains (stations, 6) and lengths of links for one unit of an increment (6 n,), by a central difference."""
        step = response.reshape(-1, 6)
        size = 1e-5 / max(np.abs(step[:, 3:]).max(), np.abs(step).max() / self.disc.length, 1e-300)
        strains: list[Array] = []
        lengths: list[dict[str, float]] = []
        n = self.disc.nodes
        for sign in (1.0, -1.0):
            x = self.x.copy()
            kernel.move(sign * size * step, self.disc.nodes, x, False, False, np.inf)
            strains.append(self.newton.books(x).strains.copy())
            turned = x[:n, 3:12].reshape(1, n, 3, 3).transpose(0, 1, 3, 2)
            states = self.disc.link_states(x[None, :n, :3], turned)
            lengths.append({f"link {name!r}": float(state[0, 0]) for name, state in states.items()})
        ahead, behind = lengths
        return (strains[0] - strains[1]) / (2.0 * size), {k: (ahead[k] - behind[k]) / (2.0 * size) for k in ahead}

    @cached_property
    def mass(self) -> csc_matrix:
        """Consistent mass at the state."""
        return _coefficient(self.hessian, self.x)

    @property
    def damped(self) -> bool:
        """True when a section or a link is."""
        return any(np.any(rod.section.damping) for rod in self.model.rods) or any(k.damping for k in self.model.links)

    def damping(self) -> csc_matrix:
        """C of M q̈ + C q̇ + K q = 0, from the viscous part of a midpoint step that goes nowhere."""
        disc = discretise(self.model, MIDPOINT).driven_at(self.factor, self.factor)
        return _coefficient(Hessian(Newton(disc, MIDPOINT, Settings())), self.x[: disc.nodes].copy())

    def moved(self, direction: int) -> Array:
        """All nodes by one unit along an axis, on the free unknowns."""
        every = np.zeros((self.disc.nodes, 6))
        every[:, direction] = 1.0
        return every.ravel()[self.free]

    @property
    def total_mass(self) -> float:
        """Of rods and bodies."""
        rods = zip(self.disc.model.rods, self.disc.mesh.rods, strict=True)
        return sum(r.section.A_rho * float(mesh.s[-1]) for r, mesh in rods) + sum(b.mass for b in self.model.bodies)

    def rigid(self) -> Array:
        """Rigid motions (free, k) that supports leave and nothing resists, of unit modal mass.

        By objectivity the stiffness has nothing against them, where no load and no link to the ground acts.
        """
        nodes, newton = self.disc.nodes, self.newton
        none = np.zeros((int(self.free.sum()), 0))
        kernel.internal_forces(newton.tables, newton.work, self.x, newton.globals, np.zeros((nodes, 12)))
        left = np.abs(newton.work.internal).max(axis=0)
        scale = max(newton.work.scale[0], newton.work.scale[1] / self.disc.length)
        if any(g.grounded for g in self.disc.groups):
            return none
        if max(left[:3].max(), left[3:].max() / self.disc.length) > BALANCED * scale + newton.options[1]:
            return none
        r = self.x[:nodes, :3] - self.x[:nodes, :3].mean(axis=0)
        motions = np.zeros((nodes, 6, 6))
        for k, axis in enumerate(np.eye(3)):
            motions[:, k, k] = 1.0
            motions[:, :3, 3 + k], motions[:, 3 + k, 3 + k] = np.cross(axis, r) / self.disc.length, 1 / self.disc.length
        motions = motions.reshape(6 * nodes, 6)
        held = motions[~self.free]
        left_free = motions[self.free] @ (null_space(held, rcond=1e-9) if len(held) else np.eye(6))
        if not left_free.size:
            return none
        factor = np.linalg.cholesky(left_free.T @ (self.mass @ left_free))
        return np.array(np.linalg.solve(factor, left_free.T).T, float)

    def shapes(self, vectors: Array) -> Array:
        """Eigenvectors (free, count) as (count, n, 6)."""
        return np.array([self.hessian.increment(v) for v in vectors.T])


def _coefficient(hessian: Hessian, x: Array) -> csc_matrix:
    """What the second of the common scalars multiplies in the tangent.

    It is made so large that what does not depend on it costs no digits.
    """
    common = hessian.newton.globals.copy()
    rest = hessian.matrix(x, common=common)

    def at(value: float) -> csc_matrix:
        common[1] = value
        return csc_matrix((hessian.matrix(x, common=common) - rest) / value)

    size = max(float(np.abs(at(1.0).diagonal()).max()), 1e-300)
    return at(max(1.0, 1e3 * largest_entry(rest) / size))


def _without_damping(model: Model) -> Model:
    """The model without dashpots, for which accelerations as unknowns have no form."""
    rods = tuple(replace(r, section=replace(r.section, damping=np.zeros((6, 6)))) for r in model.rods)
    links = tuple(replace(k, damping=0.0) for k in model.links if k.stiffness)
    return replace(model, rods=rods, links=links)


def _with_mass(model: Model) -> Model:
    """The model with some mass where it has none: stiffness does not ask for it, meshing for a motion does."""
    rods = tuple(
        replace(rod, section=replace(rod.section, A_rho=rod.section.A_rho or 1.0, I_rho=np.eye(2)))
        for rod in model.rods
    )
    return replace(model, rods=rods)
