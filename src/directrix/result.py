"""What a run gives back: plain arrays, a status and the audit. Knows no solver."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from os import PathLike
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from directrix.checks import shown
from directrix.errors import ModelError
from directrix.marks import Mark
from directrix.trail import Iterations

if TYPE_CHECKING:
    import pandas
    import xarray

    from directrix.audit import Audit
    from directrix.critical import PathStability
    from directrix.plot import Plots

Array = NDArray[np.float64]

__all__ = [
    "Energy", "JointHistory", "LinkHistory", "Mesh", "Momentum", "NodeHistory", "Result", "RodHistory", "RodMesh",
    "Status", "TurningPoint", "turn_length",
]  # fmt: skip


@dataclass(frozen=True)
class RodMesh:
    """One rod as it was meshed: where its nodes and its stress stations are.

    Attributes
    ----------
    name : the rod's name
    nodes : (m,) indices of the rod's nodes, in the direction of the rod
    s : (m,) arclength of those nodes on the reference axis
    directors : (m, 3, 3) reference directors at those nodes, columns d1, d2, d3
    order : polynomial order of its elements; (m − 1)/order elements
    stations : (q,) arclength of the stress (Gauss) points
    first_station : index of the first of them in ``Result.strain``
    outline : (k, 2) closed polygon of the section in (d1, d2), or (0, 2) when the section has no shape
    """

    name: str
    nodes: NDArray[np.int64]
    s: Array
    directors: Array
    order: int
    stations: Array
    first_station: int
    outline: Array


@dataclass(frozen=True)
class Mesh:
    """The discretised model as a result needs it: names and places, no mechanics.

    ``node_names`` maps a name to a node index, ``r0`` is (n, 3) reference positions,
    ``notes`` are sentences about what meshing changed. ``joints`` are the joints' names, ``joint_nodes`` (joints, 2)
    the nodes of their base and of what moves, −1 for the ground, and ``joint_arms`` (joints, 2, 3) the way from these
    nodes to the joint in the reference; on the ground its place. ``marks`` are what pictures show beside the
    rods: supports, loads, springs and masses.
    """

    rods: tuple[RodMesh, ...]
    node_names: Mapping[str, int]
    r0: Array
    notes: tuple[str, ...] = ()
    joints: tuple[str, ...] = ()
    joint_nodes: NDArray[np.int64] = field(default_factory=lambda: np.zeros((0, 2), np.int64))
    joint_arms: Array = field(default_factory=lambda: np.zeros((0, 2, 3)))
    marks: tuple[Mark, ...] = ()

    @cached_property
    def loose(self) -> NDArray[np.int64]:
        """Indices of the nodes that are on no rod."""
        on = np.zeros(len(self.r0), bool)
        for rod in self.rods:
            on[rod.nodes] = True
        return np.flatnonzero(~on)

    def rod(self, name: str) -> RodMesh:
        """The rod called ``name``; raises ModelError with the names there are."""
        for rod in self.rods:
            if isinstance(name, str) and rod.name == name:  # pyright: ignore[reportUnnecessaryIsInstance]
                return rod
        raise ModelError(f"there is no rod {shown(name)}", f"rods: {', '.join(r.name for r in self.rods)}")

    def node(self, name: str | int) -> int:
        """Index of a node given by name or index; raises ModelError with the names there are."""
        if isinstance(name, str):
            if name in self.node_names:
                return self.node_names[name]
            raise ModelError(f"there is no node {name!r}", f"nodes: {', '.join(self.node_names)}")
        whole = isinstance(name, (int, np.integer)) and not isinstance(name, bool)  # pyright: ignore
        if whole and 0 <= name < len(self.r0):
            return int(name)
        raise ModelError(f"there is no node {shown(name)}", f"node indices are 0 … {len(self.r0) - 1}")

    def label(self, index: int) -> str:
        """A name a user recognises: the node's own, or its place on a rod; of a joint behind the nodes."""
        if index >= len(self.r0):
            return f"joint {self.joints[index - len(self.r0)]!r}"
        for name, k in self.node_names.items():
            if k == index:
                return name
        for rod in self.rods:
            hit = np.flatnonzero(rod.nodes == index)
            if hit.size:
                return f"{rod.name} at s = {rod.s[hit[0]]:.4g}"
        return f"node {index}"

    def place(self, index: int) -> str:
        """The same as part of a sentence: "node 'tip' of rod 'arm'"."""
        label = self.label(index)
        if label not in self.node_names:
            return label
        rods = [repr(rod.name) for rod in self.rods if index in rod.nodes]
        if not rods:
            return f"node {label!r}"
        return f"node {label!r} of rod{'s' * (len(rods) > 1)} {', '.join(rods[:3])}" + " …" * (len(rods) > 3)


@dataclass(frozen=True)
class Status:
    """How a run ended. ``code`` is for programs, ``sentence`` and ``advice`` for people.

    Codes: ``done``, ``not_converged``, ``non_finite``, ``singular``, ``bad_input``, ``interrupted``, ``stopped``,
    ``step_limit``.
    """

    code: str
    sentence: str
    advice: str = ""

    @property
    def success(self) -> bool:
        """True when everything that was asked for was computed."""
        return self.code in ("done", "stopped")

    def __str__(self) -> str:
        return self.sentence + (f" {self.advice}" if self.advice else "")


@dataclass(frozen=True)
class Energy:
    """Energies at the saved instants, each (nt,).

    ``work`` is all that came in from outside since the start, by loads and by prescribed motion
    (``prescribed`` is the second part alone); ``dissipated`` what viscous and numerical damping took.
    ``residual`` is the ledger: total − total[0] − work + dissipated, zero up to round-off
    for a conserving step. ``by_source`` is ``dissipated`` by its sources, name → (nt,): links by name, the damping of
    every rod's section, fluids, numerical dissipation; ``work_by_source`` is ``work`` by what did it: loads, supports,
    actuation, tendons, fluids that flow.
    """

    kinetic: Array
    stored: Array
    work: Array
    prescribed: Array
    dissipated: Array
    by_source: Mapping[str, Array] = field(default_factory=dict[str, Array])
    work_by_source: Mapping[str, Array] = field(default_factory=dict[str, Array])

    @cached_property
    def total(self) -> Array:
        """Kinetic plus stored energy (nt,)."""
        return self.kinetic + self.stored

    @cached_property
    def residual(self) -> Array:
        """What the ledger does not explain (nt,)."""
        return self.total - self.total[0] - self.work + self.dissipated


@dataclass(frozen=True)
class Momentum:
    """Linear and angular momentum (about the origin) at the saved instants, each (nt, 3)."""

    linear: Array
    angular: Array


@dataclass(frozen=True)
class NodeHistory:
    """A node through the run.

    ``r`` (nt, 3) position, ``R`` (nt, 3, 3) rotation from the reference, ``v`` (nt, 3) velocity,
    ``displacement`` (nt, 3), ``reaction`` (nt, 6): force (3) and moment (3) that supports exert on the
    node, in the global frame (dynamics: over the step that ends at t; zero at the start).
    """

    r: Array
    R: Array
    v: Array
    displacement: Array
    reaction: Array


@dataclass(frozen=True)
class RodHistory:
    """A rod through the run: ``strain`` and ``force`` (nt, stations, 6) at arclengths ``s`` (stations,).

    Components (shear 1, shear 2, axial, bending 1, bending 2, torsion) in the section's frame.
    """

    s: Array
    strain: Array
    force: Array

    def stress(self, section: Any, **options: Any) -> Array:
        """Stresses (nt, stations, points, 3) of a `sectionproperties` section; see ``directrix.shapes.stress``."""
        from directrix.shapes import stress

        return stress(section, self.force, **options)


@dataclass(frozen=True)
class TurningPoint:
    """Where the load factor turns back along a static path.

    ``kind`` "limit point (maximum)" or "limit point (minimum)" of the load factor; ``load_factor`` there;
    ``arc_length`` from the start of the run; ``index`` of the saved instant that is this state.
    """

    kind: str
    load_factor: float
    arc_length: float
    index: int

    def __str__(self) -> str:
        return f"{self.kind} at load factor {self.load_factor:.9g}, arc length {self.arc_length:.6g}"


@dataclass(frozen=True)
class LinkHistory:
    """A spring, dashpot or cable through the run: ``length`` and elastic ``tension``, each (nt,)."""

    length: Array
    tension: Array


@dataclass(frozen=True)
class ContactHistory:
    """A contact through the run, each (nt,): ``gap`` the smallest distance of surfaces, negative where they overlap
    (infinite where rods are far apart), ``force`` the sum of the normal forces at the saved instants."""

    gap: Array
    force: Array


@dataclass(frozen=True)
class JointHistory:
    """A joint through the run.

    ``force`` and ``moment`` (nt, 3) that it exerts on its second node, on its only one when the ground is the other,
    the moment about the joint; springs, dampers, stops and drives included (dynamics: over the step that ends at t;
    zero at the start). ``coordinate`` (nt,): angle [rad] of a hinge, displacement of a slider or cylindrical joint,
    zero for others.
    """

    force: Array
    moment: Array
    coordinate: Array


@dataclass(frozen=True)
class Result:
    """Everything a run computed, at ``nt`` saved instants of ``n`` nodes.

    Attributes
    ----------
    kind : "static" or "dynamic"
    name : title of the case
    mesh : names and places
    t : (nt,) time (statics: the load factor)
    load_factor : (nt,) load factor (dynamics: ones)
    r, R : (nt, n, 3) positions and (nt, n, 3, 3) rotations from the reference
    v, Rdot : (nt, n, 3) velocities and (nt, n, 3, 3) generalised rotation rates (dR/dt of the scheme,
        from which every director velocity follows); zero in statics
    reaction : (nt, n, 6) support forces and moments on the nodes
    strain, force : (nt, stations, 6)
    density : (nt, stations) stored energy per unit of reference length; (0, 0) where nobody worked it out
    energy, momentum : histories
    iterations : (steps,) Newton iterations of every step taken
    dt : (steps,) length of every step of a motion; they add up to the time from the start to the end
    trail : what was out of balance and what moved in the iterations of the last steps, taken or not; see
        :class:`directrix.trail.Iterations`
    cuts : (steps,) how many times a step of a motion was tried too long before it was taken: its equations were not
        solved, or its error was too large; both are (0,) in statics, where ``info["cuts"]`` counts
    status : how it ended
    audit : the books of every step, and the verdict
    info : what ran: versions, integrator, formulation, step, tolerance, wall time
    links : (nt, 2) length and elastic tension of each link, by name; see :meth:`link`
    contacts : (nt, 2) smallest gap and sum of normal forces of each contact, by name; see :meth:`contact`
    joints : (nt, joints, 6) force and moment of every joint on what it moves; see :meth:`joint`
    history : (nt, rows, 12) multipliers and coordinates of joints, one row each, then what a formulation or a scheme
        carries beside the nodes, to go on with ``start=``; no rows for most
    turning_points : limit points of a path that was followed, in the order of the path
    stability : negative pivots of the saved states and critical points of a path; None where nobody looked
    """

    kind: Literal["static", "dynamic"]
    name: str
    mesh: Mesh
    t: Array
    load_factor: Array
    r: Array
    R: Array
    v: Array
    Rdot: Array
    reaction: Array
    strain: Array
    force: Array
    energy: Energy
    momentum: Momentum
    iterations: NDArray[np.int64]
    status: Status
    audit: Audit
    info: Mapping[str, Any] = field(default_factory=dict[str, Any])
    density: Array = field(default_factory=lambda: np.zeros((0, 0)))
    history: Array = field(default_factory=lambda: np.zeros((0, 0, 12)))
    joints: Array = field(default_factory=lambda: np.zeros((0, 0, 6)))
    links: Mapping[str, Array] = field(default_factory=dict[str, Array])
    contacts: Mapping[str, Array] = field(default_factory=dict[str, Array])
    turning_points: tuple[TurningPoint, ...] = ()
    stability: PathStability | None = None
    dt: Array = field(default_factory=lambda: np.zeros(0))
    cuts: NDArray[np.int64] = field(default_factory=lambda: np.zeros(0, np.int64))
    trail: Iterations = field(default_factory=Iterations)

    @cached_property
    def arc_length(self) -> Array:
        """Length (nt,) of the path through the saved states, which grows where the load factor may turn back.

        The distance of two states is the root mean square over the nodes of |Δr|² + ½ℓ² Σ|Δd_i|², that is of
        displacement and, for small turns, ℓ times the turn; ℓ is the size of the model over 2π.
        """
        length = turn_length(self.mesh.r0)
        squares = np.sum(np.diff(self.r, axis=0) ** 2, axis=2)
        squares += 0.5 * length**2 * np.sum(np.diff(self.R, axis=0) ** 2, axis=(2, 3))
        return np.concatenate([[0.0], np.cumsum(np.sqrt(squares.mean(axis=1)))])

    @property
    def success(self) -> bool:
        """True when everything that was asked for was computed."""
        return self.status.success

    def node(self, name: str | int) -> NodeHistory:
        """History of one node, by name or index; raises ModelError for an unknown one."""
        k = self.mesh.node(name)
        r = self.r[:, k]
        return NodeHistory(r, self.R[:, k], self.v[:, k], r - self.mesh.r0[k], self.reaction[:, k])

    def rod(self, name: str) -> RodHistory:
        """History of one rod, by name; raises ModelError for an unknown one."""
        rod = self.mesh.rod(name)
        part = slice(rod.first_station, rod.first_station + len(rod.stations))
        return RodHistory(rod.stations, self.strain[:, part], self.force[:, part])

    def link(self, name: str) -> LinkHistory:
        """History of one spring, dashpot or cable, by name; raises ModelError for an unknown one."""
        if name not in self.links:
            raise ModelError(f"there is no link {name!r}", f"links: {', '.join(self.links) or 'none'}")
        return LinkHistory(*self.links[name].T)

    def contact(self, name: str) -> ContactHistory:
        """History of one contact, by name; raises ModelError for an unknown one."""
        if name not in self.contacts:
            raise ModelError(f"there is no contact {name!r}", f"contacts: {', '.join(self.contacts) or 'none'}")
        return ContactHistory(*self.contacts[name].T)

    def joint(self, name: str) -> JointHistory:
        """History of one joint, by name; raises ModelError for an unknown one."""
        if name not in self.mesh.joints:
            raise ModelError(f"there is no joint {name!r}", f"joints: {', '.join(self.mesh.joints) or 'none'}")
        k = self.mesh.joints.index(name)
        return JointHistory(self.joints[:, k, :3], self.joints[:, k, 3:], self.history[:, k, 6])

    def joint_ends(self, at: int) -> Array:
        """At saved instant ``at``, of every joint's base and of what it moves (joints, 2, 2, 3): the node, and the
        point that it carries there; on the ground both are the place of the joint."""
        nodes, arms = self.mesh.joint_nodes, self.mesh.joint_arms
        ground = nodes < 0
        foot = np.where(ground[..., None], arms, self.r[at, nodes])
        turned = np.einsum("jeik,jek->jei", self.R[at, nodes], arms)
        return np.stack([foot, foot + np.where(ground[..., None], 0.0, turned)], axis=2)

    def directors(self, name: str) -> Array:
        """Directors at the nodes of one rod, (nt, m, 3, 3), columns d1, d2, d3."""
        rod = self.mesh.rod(name)
        return self.R[:, rod.nodes] @ rod.directors

    @cached_property
    def plot(self) -> Plots:
        """Pictures: ``shape``, ``motion``, ``energy``, ``momentum``, ``history``, ``path``; needs matplotlib."""
        from directrix.plot import Plots

        return Plots(self)

    def view(self, path: str | PathLike[str]) -> str:
        """Write one self-contained HTML page (orbit, playback, fields in colour); returns its path.

        Several results on one page: :func:`directrix.view`.
        """
        from directrix.viewer import write_html

        return write_html(self, path)

    def movie(self, path: str | PathLike[str], **options: Any) -> str:
        """Write the motion as a .gif or .mp4 file; returns its path. ``options``: ``seconds``, ``fps``, ``width``,
        ``height``, ``field``, see ``directrix.movie.write_movie``; needs matplotlib."""
        from directrix.movie import write_movie

        return write_movie(self, path, **options)

    def save(self, path: str | PathLike[str]) -> str:
        """Write one HDF5 file that ParaView opens (VTKHDF) and ``dx.load`` reads; returns its path."""
        from directrix.storage.vtkhdf import save

        return save(self, path)

    def to_pandas(self, table: str = "nodes") -> pandas.DataFrame:
        """One table as a DataFrame; see ``directrix.exports.to_pandas``."""
        from directrix.exports import to_pandas

        return to_pandas(self, table)

    def to_xarray(self) -> xarray.Dataset:
        """Everything as labelled arrays; see ``directrix.exports.to_xarray``."""
        from directrix.exports import to_xarray

        return to_xarray(self)

    def to_pyvista(self, at: int | None = None) -> Any:
        """One saved instant (PolyData), or all (MultiBlock), for PyVista; see ``directrix.exports.to_pyvista``."""
        from directrix.exports import to_pyvista

        return to_pyvista(self, at)

    def to_csv(self, folder: str | PathLike[str]) -> str:
        """Write every table as a CSV file into a folder, which it returns; see ``directrix.exports.to_csv``."""
        from directrix.exports import to_csv

        return to_csv(self, folder)

    def to_npz(self, path: str | PathLike[str]) -> str:
        """Write the arrays for NumPy; returns the path. See ``directrix.exports.to_npz``."""
        from directrix.exports import to_npz

        return to_npz(self, path)

    def to_mat(self, path: str | PathLike[str]) -> str:
        """Write the arrays for MATLAB; returns the path. See ``directrix.exports.to_mat``."""
        from directrix.exports import to_mat

        return to_mat(self, path)

    def to_xlsx(self, path: str | PathLike[str]) -> str:
        """Write every table as a sheet of an Excel file; returns the path. See ``directrix.exports.to_xlsx``."""
        from directrix.exports import to_xlsx

        return to_xlsx(self, path)

    def to_gltf(
        self, path: str | PathLike[str], *, frames: int = 240, duration: float | None = None, up: str = "z"
    ) -> str:
        """Write an animation for any viewer of 3-D scenes; returns the path. See ``directrix.exports.to_gltf``."""
        from directrix.exports import to_gltf

        return to_gltf(self, path, frames=frames, duration=duration, up=up)

    def _repr_html_(self) -> str:
        from directrix.notebook import result_html

        return result_html(self)

    def __str__(self) -> str:
        from directrix.audit import report

        return report(self)


def turn_length(r0: Array) -> float:
    """ℓ that turns are multiplied by in the length of a path: the diagonal of the box of ``r0`` (n, 3), over 2π."""
    return float(np.linalg.norm(np.ptp(r0, axis=0))) / (2.0 * np.pi)
