"""The model: rods, supports, loads and initial velocities, as frozen values. A method that adds returns a new model."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any, Self, cast

import numpy as np
from numpy.typing import ArrayLike

from directrix.actuators import Actuation, Drag, Tendon, numbers, value_at
from directrix.attachments import Body, Link
from directrix.checks import Vec, choice, flag, nearest, number, shown, text, vector, whole
from directrix.contacts import Contact, Obstacle, RodContact, named_rods
from directrix.curves import Curve, Polyline, twisted
from directrix.errors import ModelError
from directrix.findings import Finding, closer, remarks
from directrix.joints import Joint
from directrix.section import Section

VecOrFn = Vec | Callable[[float], ArrayLike]
DOFS = ("x", "y", "z", "rx", "ry", "rz")
SAME_PLACE = 1e-9  # of the model's size
MOST = 1_000_000  # elements of a rod
ROD = ("curve", "section", "name", "ends", "elements", "order", "points", "nodes", "twist")
OPTIONS = tuple(f.name for f in fields(Joint))[4:]  # behind name, kind, nodes

__all__ = [
    "DOFS", "Distributed", "Force", "Gravity", "Model", "Moment", "Node", "Prescribed", "Pressure", "RigidVelocity",
    "Rod", "Support", "Vec", "VecOrFn", "Velocity",
]  # fmt: skip


@dataclass(frozen=True)
class Node:
    """A node that is on no rod: bodies, links and joints attach to it."""

    name: str
    at: Vec


@dataclass(frozen=True)
class Rod:
    """A rod: its axis, section, end nodes, mesh; ``nodes`` pairs names with fractions of arclength."""

    name: str
    curve: Curve
    section: Section
    ends: tuple[str, str]
    elements: int
    order: int = 2
    points: int | None = None
    nodes: tuple[tuple[str, float], ...] = ()

    @property
    def names(self) -> tuple[str, ...]:
        """All its named nodes."""
        return (*self.ends, *(name for name, _ in self.nodes))


@dataclass(frozen=True)
class Support:
    """Components of a node that do not move."""

    node: str
    dofs: tuple[str, ...]


@dataclass(frozen=True)
class Prescribed:
    """Displacement and rotation vector (from the reference, applied on the left) of a node, given."""

    node: str
    displacement: VecOrFn | None = None
    rotation: VecOrFn | None = None


@dataclass(frozen=True)
class Force:
    """Dead force on a node, global frame; with ``follower`` it turns with the node, and its components are
    those in the reference."""

    node: str
    value: VecOrFn
    constant: bool = False
    follower: bool = False


@dataclass(frozen=True)
class Moment:
    """Spatial moment on a node, global frame; with ``follower`` it turns with the node, and its components are
    those in the reference."""

    node: str
    value: VecOrFn
    constant: bool = False
    follower: bool = False


@dataclass(frozen=True)
class Distributed:
    """Dead force per unit reference length of a rod, global frame; with ``follower`` it turns with the sections, and
    its components are those in the reference."""

    rod: str
    value: VecOrFn
    constant: bool = False
    follower: bool = False


@dataclass(frozen=True)
class Pressure:
    """Pressure on one side of a rod: the force ``value`` · ``width`` per unit reference length along a director."""

    rod: str
    value: float | Callable[[float], ArrayLike]
    width: float = 1.0
    along: str = "d1"
    constant: bool = False


@dataclass(frozen=True)
class Gravity:
    """Acceleration of gravity on everything that has mass."""

    value: VecOrFn
    constant: bool = False


@dataclass(frozen=True)
class Velocity:
    """Initial velocity and angular velocity of one node."""

    node: str
    v: Vec
    omega: Vec = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class RigidVelocity:
    """Initial velocity of the whole model as one rigid body."""

    v: Vec
    omega: Vec = (0.0, 0.0, 0.0)
    about: Vec = (0.0, 0.0, 0.0)


Load = Force | Moment | Distributed | Gravity | Pressure
SIDES = ("d1", "d2", "-d1", "-d2")


def _value(value: Any, what: str) -> VecOrFn:
    return cast("Callable[[float], ArrayLike]", value) if callable(value) else vector(value, what)


@dataclass(frozen=True)
class Model:
    """Rods and what acts on them. Start from ``Model()`` and add; every method returns a new model.

    Raises ModelError as soon as something cannot be right; :meth:`check` looks at the whole.
    """

    name: str = "model"
    rods: tuple[Rod, ...] = ()
    supports: tuple[Support, ...] = ()
    prescribed: tuple[Prescribed, ...] = ()
    loads: tuple[Load, ...] = ()
    velocities: tuple[Velocity | RigidVelocity, ...] = ()
    links: tuple[Link, ...] = ()
    bodies: tuple[Body, ...] = ()
    actuations: tuple[Actuation, ...] = ()
    drags: tuple[Drag, ...] = ()
    tendons: tuple[Tendon, ...] = ()
    contacts: tuple[Contact, ...] = ()
    rod_contacts: tuple[RodContact, ...] = ()
    joints: tuple[Joint, ...] = ()
    nodes: tuple[Node, ...] = ()
    imported: tuple[str, ...] = ()
    """What was moved, merged or left out when geometry was read; ``notes`` repeats it."""

    def graph(self, graph: Any, section: Any = None, **options: Any) -> Model:
        """Add the edges of a networkx graph as rods; see :func:`dx.from_graph`, also for what is raised."""
        from directrix.geometry.graph import from_graph

        return from_graph(graph, section=section, model=self, **options)

    def node(self, name: str, at: Any) -> Self:
        """Add a node that is on no rod, at the place ``at`` (3,): bodies, links and joints attach to it.

        What moves of it in dynamics needs mass, or a joint, link or support that says how. Raises ModelError for a name
        that is taken or a place that is none.
        """
        name = text(name, "name of a node")
        if any(other.name == name for other in self.nodes):
            raise ModelError(f"there are two nodes called {name!r}", "give each node a name of its own", code="DX422")
        return replace(self, nodes=(*self.nodes, Node(name, vector(at, f"place of node {name!r}"))))

    def rod(
        self,
        curve: Curve,
        section: Section,
        *,
        name: str | None = None,
        ends: tuple[str, str] | None = None,
        elements: int = 10,
        order: int = 2,
        points: int | None = None,
        nodes: Mapping[str, float] | None = None,
        twist: Any = None,
    ) -> Self:
        """Add a rod.

        Parameters
        ----------
        curve, section
            Axis and cross-section; one from :func:`dx.taper` varies along the rod.
        name
            Its name; "rod1", "rod2", … by default.
        ends
            Names of its end nodes; equal names at equal places are rigidly joined. Default "<name>.start", "….end".
        elements
            Number of elements; more where kinks or named nodes ask for it.
        order
            1, 2 or 3. Linear elements are too flexible on coarse meshes.
        points
            Gauss points for the stresses; None is the reduced rule, as many as ``order``.
        nodes
            Names of interior nodes and where they are, as fractions of the arclength.
        twist
            Turn [rad] of the directors about the axis beyond those of the curve: at the end, pairs (fraction, angle)
            or a function of the fraction; see :func:`dx.twisted`.
        """
        given = {
            "name": name, "ends": ends, "elements": elements, "order": order, "points": points, "nodes": nodes,
            "twist": twist,
        }  # fmt: skip
        return self.add_rods([{"curve": curve, "section": section, **given}])

    def add_rods(self, rods: Iterable[Mapping[str, Any]]) -> Self:
        """Add many rods at once: of each the arguments of :meth:`rod` by name. Time grows with their number.

        Raises ModelError as :meth:`rod`, and for what is no argument of it.
        """
        taken = {rod.name for rod in self.rods}
        made: list[Rod] = []
        for given in rods:
            name = given.get("name")
            name = text(name if name is not None else f"rod{len(taken) + 1}", "name of a rod")
            if name in taken:
                raise ModelError(f"there are two rods called {name!r}", "give each rod a name of its own", code="DX422")
            for key in given:
                choice(key, "argument of a rod", ROD)
            for key in ("curve", "section"):
                if key not in given:
                    raise ModelError(f"rod {name!r} has no {key}", f"give {key}=")
            taken.add(name)
            made.append(_made_rod(**{**given, "name": name}))
        return replace(self, rods=(*self.rods, *made))

    def split(self, rod: str, nodes: Mapping[str, float]) -> Self:
        """Name interior nodes of a rod by their fractions of its arclength."""
        old = self._rod(text(rod, "name of a rod"))
        inner = list(old.nodes)
        for node, fraction in _named(nodes, f"rod {rod!r}"):
            inner.append(_interior(f"rod {rod!r}", node, fraction, (*old.ends, *(n for n, _ in inner))))
        new = replace(old, nodes=tuple(inner))
        return replace(self, rods=tuple(new if r is old else r for r in self.rods))

    def named(self, name: str) -> Self:
        """The same model under another name."""
        return replace(self, name=text(name, "name of the model"))

    def clamp(self, node: str) -> Self:
        """Hold position and rotation of a node."""
        return self.fix(node, *DOFS)

    def pin(self, node: str) -> Self:
        """Hold the position of a node."""
        return self.fix(node, "x", "y", "z")

    def fix(self, node: str, *dofs: str) -> Self:
        """Hold components of a node: "x", "y", "z", "rx", "ry", "rz" (two or three rotations, never one alone)."""
        node = text(node, "name of a node")
        if not dofs:
            raise ModelError(f"node {node!r}: nothing is fixed", f"name components of {', '.join(DOFS)}")
        for dof in dofs:
            choice(dof, f"component of node {node!r}", DOFS)
        if sum(dof[0] == "r" for dof in set(dofs)) == 1:
            (only,) = {dof for dof in dofs if dof[0] == "r"}
            raise ModelError(
                f"node {node!r}: {only} alone is no constraint that finite rotations have",
                "fix two rotations (it then turns about the third axis) or all three",
            )
        return replace(self, supports=(*self.supports, Support(node, tuple(d for d in DOFS if d in dofs))))

    def prescribe(self, node: str, *, displacement: Any = None, rotation: Any = None) -> Self:
        """Move a node: vectors or functions of time (statics: of the load factor; a vector ramps with it)."""
        node = text(node, "name of a node")
        if displacement is None and rotation is None:
            raise ModelError(f"node {node!r}: nothing is prescribed", "give displacement= or rotation=")
        u, t = (
            None if v is None else _value(v, f"prescribed {k} of node {node!r}")
            for k, v in (("displacement", displacement), ("rotation", rotation))
        )
        return replace(self, prescribed=(*self.prescribed, Prescribed(node, u, t)))

    def force(self, node: str, f: Any, *, constant: bool = False, follower: bool = False) -> Self:
        """Force on a node: a vector or a function of time.

        Dead, or with ``follower`` turning with the node: F = R f, R its rotation from the reference.
        """
        node = text(node, "name of a node")
        new = Force(node, _value(f, f"force on node {node!r}"), flag(constant, "constant"), flag(follower, "follower"))
        return replace(self, loads=(*self.loads, new))

    def moment(self, node: str, m: Any, *, constant: bool = False, follower: bool = False) -> Self:
        """Spatial moment on a node: a vector or a function of time; with ``follower`` it turns with the node."""
        node = text(node, "name of a node")
        new = Moment(
            node, _value(m, f"moment on node {node!r}"), flag(constant, "constant"), flag(follower, "follower")
        )
        return replace(self, loads=(*self.loads, new))

    def distributed(self, rod: str, f: Any, *, constant: bool = False, follower: bool = False) -> Self:
        """Force per unit reference length of a rod: a vector or a function of time.

        Dead, or with ``follower`` turning with the sections: R f, R their rotation from the reference.
        """
        rod = text(rod, "name of a rod")
        value = _value(f, f"distributed load on rod {rod!r}")
        new = Distributed(rod, value, flag(constant, "constant"), flag(follower, "follower"))
        return replace(self, loads=(*self.loads, new))

    def pressure(self, rod: str, p: Any, *, width: float = 1.0, along: str = "d1", constant: bool = False) -> Self:
        """Pressure on one side of a rod, a number or a function of time: p · ``width`` per unit reference length.

        The force pushes ``along`` a director, "d1", "d2", "-d1" or "-d2", and follows the section.
        """
        rod = text(rod, "name of a rod")
        value = numbers(p, 1, f"pressure on rod {rod!r}")
        number(width, f"width of the pressure on rod {rod!r}", above=0.0)
        choice(along, "direction of a pressure", SIDES)
        new = Pressure(rod, value, float(width), along, flag(constant, "constant"))
        return replace(self, loads=(*self.loads, new))

    def gravity(self, g: Any, *, constant: bool = False) -> Self:
        """Acceleration of gravity: a vector or a function of time."""
        if any(isinstance(load, Gravity) for load in self.loads):
            raise ModelError("gravity is given twice", "give one vector")
        return replace(self, loads=(*self.loads, Gravity(_value(g, "gravity"), flag(constant, "constant"))))

    def spring(
        self, a: str, b: str | Vec, stiffness: float, *, length: float | None = None, damping: float = 0.0,
        offset_a: Vec = (0.0, 0.0, 0.0), offset_b: Vec = (0.0, 0.0, 0.0), name: str | None = None,
    ) -> Self:  # fmt: skip
        """A spring from a point of node ``a`` to one of node ``b`` (or a place on the ground); see :class:`Link`."""
        return self._link(Link(self._link_name(name), a, b, stiffness, length, damping, offset_a, offset_b))

    def dashpot(
        self, a: str, b: str | Vec, damping: float, *, offset_a: Vec = (0.0, 0.0, 0.0),
        offset_b: Vec = (0.0, 0.0, 0.0), name: str | None = None,
    ) -> Self:  # fmt: skip
        """A dashpot: a force ``damping`` times the rate of the distance, in dynamics; see :class:`Link`."""
        return self._link(Link(self._link_name(name), a, b, 0.0, None, damping, offset_a, offset_b))

    def cable(
        self, a: str, b: str | Vec, stiffness: float, *, length: float | None = None, width: float | None = None,
        damping: float = 0.0, offset_a: Vec = (0.0, 0.0, 0.0), offset_b: Vec = (0.0, 0.0, 0.0), name: str | None = None,
    ) -> Self:  # fmt: skip
        """A straight cable without mass that pulls and does not push; the change is smooth over ``width``."""
        made = Link(self._link_name(name), a, b, stiffness, length, damping, offset_a, offset_b, True, width)
        return self._link(made)

    def actuate(
        self, rod: str, *, curvature: Any = None, twist: Any = None, elongation: Any = None, strain: Any = None,
        along: bool = False,
    ) -> Self:  # fmt: skip
        """Change the strain at which a rod is without stress, as muscles and swelling do; see :class:`Actuation`.

        ``curvature`` (bending 1, bending 2), ``twist``, ``elongation`` or all six as ``strain``: values, or functions
        of t, with ``along`` of (t, s).
        """
        new = Actuation(rod, curvature, twist, elongation, strain, along)
        if any(other.rod == new.rod for other in self.actuations):
            raise ModelError(f"rod {rod!r} is actuated twice", "give one actuation, their sum if that is meant")
        return replace(self, actuations=(*self.actuations, new))

    def tendon(
        self, along: str | Iterable[str], tension: Any, *, offset: Any = (0.0, 0.0), name: str | None = None,
        constant: bool = False,
    ) -> Self:  # fmt: skip
        """A tendon along a rod, or from node to node, with a tension that is a number or a function of time.

        See :class:`Tendon`.
        """
        name = f"tendon{len(self.tendons) + 1}" if name is None else name
        new = Tendon(name, along if isinstance(along, str) else tuple(along), tension, offset, constant)
        if any(other.name == new.name for other in self.tendons):
            raise ModelError(
                f"there are two tendons called {name!r}", "give each tendon a name of its own", code="DX422"
            )
        return replace(self, tendons=(*self.tendons, new))

    def drag(
        self, rod: str, normal: float, tangential: float = 0.0, *, flow: Any = (0.0, 0.0, 0.0), constant: bool = False
    ) -> Self:
        """Quadratic drag of a fluid on a rod; ``flow`` is the fluid's velocity, a vector or a function of time.

        See :class:`Drag`.
        """
        new = Drag(rod, normal, tangential, flow, constant)
        if any(other.rod == new.rod for other in self.drags):
            raise ModelError(f"rod {rod!r} has two drags", "give one, their sum if that is meant")
        return replace(self, drags=(*self.drags, new))

    def point_mass(self, node: str, m: float) -> Self:
        """A mass on a node."""
        return self.rigid_body(node, m, np.zeros((3, 3)))

    def rigid_body(self, node: str, mass: float, inertia: ArrayLike, *, offset: Any = None) -> Self:
        """A rigid body on a node; ``inertia`` (3, 3) about its centre of mass, in the reference frame.

        The centre of mass is at the node, or ``offset`` from it: then at a node "<node>.body" of its own, in a rigid
        joint of that name. Raises ModelError for a mass or an inertia that no body has, and for a second body on it.
        """
        node = text(node, "node of a body")
        if offset is not None:
            arm, own = np.array(vector(offset, f"offset of the body on node {node!r}")), f"{node}.body"
            places = self._places()
            if node not in places:
                raise ModelError(
                    f"there is no node {node!r} for the body",
                    f"{nearest(node, places)}add rods and nodes before a body that is off its node",
                    code="DX420",
                )
            apart = self.node(own, tuple((np.asarray(places[node]) + arm).tolist()))
            return apart.rigid_body(own, mass, inertia).rigid(node, own, name=own)
        body = Body(node, mass, np.asarray(inertia))
        if any(other.node == node for other in self.bodies):
            raise ModelError(f"node {node!r} has two bodies", "give one, their sum if that is meant")
        return replace(self, bodies=(*self.bodies, body))

    def contact(
        self, obstacle: Obstacle, *, stiffness: float, rods: str | Sequence[str] | None = None, friction: float = 0.0,
        slip_speed: float | None = None, radius: float | None = None, width: float | None = None,
        name: str | None = None,
    ) -> Self:  # fmt: skip
        """Hold rods (all unless named) off a ``dx.Plane``, ``dx.Sphere`` or ``dx.Cylinder``; see :class:`Contact`.

        ``stiffness`` is a force per penetration and per length of rod. Friction is that of dynamics.
        """
        made = Contact(
            self._contact_name(name), stiffness, named_rods(rods, "rods"), friction, slip_speed, radius, width, obstacle
        )
        return replace(self, contacts=(*self.contacts, made))

    def self_contact(
        self, *, stiffness: float, rods: str | Sequence[str] | None = None, friction: float = 0.0,
        slip_speed: float | None = None, radius: float | None = None, width: float | None = None, points: int = 2,
        name: str | None = None,
    ) -> Self:  # fmt: skip
        """Hold rods (all unless named) off one another and off themselves; see :class:`RodContact`.

        Parts nearer than half a turn of the tightest bend, π times the radius along the axis, do not touch.
        """
        made = RodContact(
            self._contact_name(name), stiffness, named_rods(rods, "rods"), friction, slip_speed, radius, width, None,
            points,
        )  # fmt: skip
        return replace(self, rod_contacts=(*self.rod_contacts, made))

    def contact_between(
        self, rods: str | Sequence[str], others: str | Sequence[str], *, stiffness: float, friction: float = 0.0,
        slip_speed: float | None = None, radius: float | None = None, width: float | None = None, points: int = 2,
        name: str | None = None,
    ) -> Self:  # fmt: skip
        """Hold ``rods`` off ``others``; see :class:`RodContact`."""
        first, second = named_rods(rods, "rods"), named_rods(others, "others")
        if first is None or second is None:
            raise ModelError("contact_between needs two sides", "name them, or use self_contact for all rods")
        made = RodContact(
            self._contact_name(name), stiffness, first, friction, slip_speed, radius, width, second, points
        )
        return replace(self, rod_contacts=(*self.rod_contacts, made))

    def _contact_name(self, name: str | None) -> str:
        taken = [c.name for c in (*self.contacts, *self.rod_contacts)]
        name = f"contact{len(taken) + 1}" if name is None else name
        if name in taken:
            raise ModelError(
                f"there are two contacts called {name!r}", "give each contact a name of its own", code="DX422"
            )
        return name

    def rigid(self, a: str, b: str | None = None, *, name: str | None = None) -> Self:
        """Join two nodes (or a node and the ground) rigidly, as they are in the reference, near or far.

        Raises ModelError as :meth:`hinge`.
        """
        return self._joint(name, "rigid", a, b)

    def spherical(self, a: str, b: str | None = None, *, name: str | None = None, **options: Any) -> Self:
        """A ball joint: all turning is free.

        ``options``: ``at``, ``stiffness`` (moment per angle) against any relative rotation, ``damping`` (moment per
        relative spin); see :meth:`hinge`, also for what is raised.
        """
        return self._joint(name, "spherical", a, b, **options)

    def hinge(self, a: str, b: str | None = None, *, axis: Vec, name: str | None = None, **options: Any) -> Self:
        """A hinge between node ``a`` and node ``b``, or ``a`` and the ground.

        Its angle q [rad] is that of ``b`` relative to ``a`` (of ``a`` relative to the ground) about the axis, zero in
        the reference, any number of turns. Constraints hold at the end of every step, their multipliers do no work
        (Betsch & Steinmann 2002; Betsch & Leyendecker 2006).

        Parameters
        ----------
        a, b
            Names of its nodes.
        axis
            Its direction in the reference; turns with ``a``.
        name
            Its name; "joint1", "joint2", … by default.
        options
            ``at``: its place in the reference; that of ``b`` (of ``a`` on the ground) by default.
            ``stiffness``, ``rest``: a spring, ½ stiffness (q − rest)²; moment per angle, and an angle.
            ``damping``: moment per rate of q, in dynamics.
            ``drive``: a moment that pushes q up, a number or a function of time (statics: times the load factor).
            ``prescribed``: q, a number or a function of time (statics: of the load factor; a number ramps with it).
            ``stops``: (lower, upper) angles, beyond which springs of ``stop_stiffness`` act, the change smooth over
            ``stop_width``, a thousandth of the way between them by default.

        Raises
        ------
        ModelError
            A value cannot be right, two things act on q that exclude each other, or the name is taken. Joints that
            hold what others or supports hold already are found when a run starts.
        """
        return self._joint(name, "hinge", a, b, axis=axis, **options)

    def universal(
        self, a: str, b: str | None = None, *, axes: tuple[Vec, Vec], name: str | None = None, **options: Any
    ) -> Self:
        """A universal (Cardan) joint: its perpendicular ``axes`` stay so, the first on ``a``, the second on ``b``.

        ``options`` as for :meth:`spherical`; raises ModelError as :meth:`hinge`.
        """
        try:
            first, second = axes
        except (TypeError, ValueError):
            raise ModelError(f"axes = {shown(axes)} are not two vectors", "give axes=(u, v)") from None
        return self._joint(name, "universal", a, b, axis=first, second=second, **options)

    def cylindrical(self, a: str, b: str | None = None, *, axis: Vec, name: str | None = None, **options: Any) -> Self:
        """``b`` slides along and turns about the line through the joint along ``axis``, which ``a`` carries.

        ``options`` as for :meth:`hinge`, on the displacement along the axis: forces for moments, lengths for angles.
        Raises ModelError as it does.
        """
        return self._joint(name, "cylindrical", a, b, axis=axis, **options)

    def slider(self, a: str, b: str | None = None, *, axis: Vec, name: str | None = None, **options: Any) -> Self:
        """``b`` slides along ``axis``, which ``a`` carries, and does not turn against ``a``.

        ``options`` as for :meth:`cylindrical`; raises ModelError as :meth:`hinge`.
        """
        return self._joint(name, "slider", a, b, axis=axis, **options)

    def planar(self, a: str, b: str | None = None, *, normal: Vec, name: str | None = None, at: Any = None) -> Self:
        """``b`` moves in the plane through the joint with ``normal``, which ``a`` carries, and turns about it.

        Nothing acts on its freedom but links and loads. Raises ModelError as :meth:`hinge`.
        """
        return self._joint(name, "planar", a, b, axis=normal, at=at)

    def _joint(self, name: str | None, kind: str, a: str, b: str | None, **options: Any) -> Self:
        name = text(f"joint{len(self.joints) + 1}" if name is None else name, "name of a joint")
        if any(other.name == name for other in self.joints):
            raise ModelError(f"there are two joints called {name!r}", "give each joint a name of its own", code="DX422")
        for key in options:
            if key not in OPTIONS:
                raise ModelError(
                    f"joint {name!r}: there is no {key}=", f"{nearest(key, OPTIONS)}use {', '.join(OPTIONS)}"
                )
        return replace(self, joints=(*self.joints, Joint(name, kind, a, b, **options)))

    def _link_name(self, name: str | None) -> str:
        return f"link{len(self.links) + 1}" if name is None else name

    def _link(self, link: Link) -> Self:
        if any(other.name == link.name for other in self.links):
            raise ModelError(
                f"there are two links called {link.name!r}", "give each link a name of its own", code="DX422"
            )
        return replace(self, links=(*self.links, link))

    def velocity(self, node: str, v: Any, omega: Any = (0, 0, 0)) -> Self:
        """Initial velocity of this node alone (the shape functions do the rest)."""
        node = text(node, "name of a node")
        if any(isinstance(given, Velocity) and given.node == node for given in self.velocities):
            raise ModelError(f"node {node!r} has two initial velocities", "give one, their sum if that is meant")
        new = Velocity(node, vector(v, f"velocity of node {node!r}"), vector(omega, f"omega of node {node!r}"))
        return replace(self, velocities=(*self.velocities, new))

    def rigid_velocity(self, v: Any = (0, 0, 0), omega: Any = (0, 0, 0), about: Any = (0, 0, 0)) -> Self:
        """Initial velocity of the whole model, v + omega × (r − about); nodal ones are added to it."""
        new = RigidVelocity(*(vector(x, k) for k, x in (("v", v), ("omega", omega), ("about", about))))
        return replace(self, velocities=(*self.velocities, new))

    def check(self, *, static: bool = False, dynamic: bool = False, meshed: bool = True) -> tuple[Finding, ...]:
        """Look at the whole; raises ModelError for the first thing that cannot be right, and returns what may be wrong.

        ``static`` and ``dynamic`` also ask for what these need: supports for every part, mass for every rod. Without
        ``meshed`` what takes a mesh is left out: whether parts can move although something holds them.
        """
        if not self.rods and not self.nodes:
            raise ModelError(f"{self.name}: there is no rod", "add one with .rod(curve, section, ...), or a .node(...)")
        places = self._places()
        self._known(places)
        self._values()
        held = self._held()
        for given in self.velocities:
            if isinstance(given, Velocity):
                for k, dof in enumerate(DOFS):
                    if dof in held.get(given.node, ()) and (*given.v, *given.omega)[k] != 0.0:
                        raise ModelError(
                            f"node {given.node!r} is held in {dof} and has an initial velocity there",
                            "remove one of them (a prescribed motion moves the node by itself)",
                        )
        if dynamic:
            for rod in self.rods:
                if rod.section.A_rho == 0.0:
                    raise ModelError(f"rod {rod.name!r} has no mass", "give its section rho= or A_rho=", code="DX427")
                if np.trace(rod.section.I_rho) == 0.0:
                    raise ModelError(
                        f"rod {rod.name!r} has no rotary inertia, its sections could turn at infinite speed",
                        "give its section I_rho1= and I_rho2=",
                        code="DX427",
                    )
        said = remarks(self, static=static) if static or dynamic else ()
        if not (static and meshed):
            return said
        from directrix.diagnosis import examine_model, refuse  # it needs the solvers

        return *refuse(examine_model(self)), *said

    def _repr_html_(self) -> str:
        from directrix.notebook import model_html

        return model_html(self)

    def notes(self) -> tuple[str, ...]:
        """What a reader of the model may want to know: assumptions of sections, ends that touch and are not joined."""
        said = [*self.imported, *(a for rod in self.rods for a in rod.section.assumptions)]
        places = self._places()
        names, points = list(places), np.array(list(places.values())).reshape(-1, 3)
        size = self._size(list(points))
        joined = {frozenset(joint.nodes) for joint in self.joints}
        for k, j in sorted(closer(points, SAME_PLACE * size)):
            a, b = names[k], names[j]
            if frozenset((a, b)) not in joined:
                said.append(
                    f"nodes {a!r} and {b!r} are at the same place and not joined: give them one name to join them"
                )
        return tuple(dict.fromkeys(said))

    def _rod(self, name: str) -> Rod:
        for rod in self.rods:
            if rod.name == name:
                return rod
        names = [r.name for r in self.rods]
        raise ModelError(
            f"there is no rod {name!r}", f"{nearest(name, names)}rods are {', '.join(names) or 'none'}", code="DX421"
        )

    @staticmethod
    def _size(points: list[Any]) -> float:
        return float(max(np.ptp(np.array(points), axis=0).max(), 1e-300))

    def _places(self) -> dict[str, Any]:
        """Where the named nodes are; refuses one name at two places."""
        found: dict[str, tuple[Any, str]] = {node.name: (np.array(node.at), "") for node in self.nodes}
        ends = [(rod, name, f) for rod in self.rods for name, f in [(rod.ends[0], 0.0), (rod.ends[1], 1.0), *rod.nodes]]
        points = [place_on(rod.curve, f) for rod, _, f in ends]
        size = self._size([*points, *(point for point, _ in found.values())])
        for (rod, name, _), point in zip(ends, points, strict=True):
            if name in found:
                other, owner = found[name]
                gap = float(np.linalg.norm(point - other))
                if gap > SAME_PLACE * size:
                    first = f"on rod {owner!r}" if owner else "by itself"
                    raise ModelError(
                        f"node {name!r} is at {_show(other)} {first} and at {_show(point)} "
                        f"on rod {rod.name!r}, {gap:.3g} apart",
                        "give the ends the same position, or different names",
                        code="DX423",
                    )
            found[name] = (point, rod.name)
        return {name: point for name, (point, _) in found.items()}

    def _known(self, places: Mapping[str, Any]) -> None:
        about: list[tuple[str, str]] = [("support", s.node) for s in self.supports]
        about += [("prescribed motion", p.node) for p in self.prescribed]
        about += [("load", load.node) for load in self.loads if isinstance(load, (Force, Moment))]
        about += [("initial velocity", v.node) for v in self.velocities if isinstance(v, Velocity)]
        about += [(f"link {k.name!r}", node) for k in self.links for node in (k.a, k.b) if isinstance(node, str)]
        about += [("body", body.node) for body in self.bodies]
        about += [(f"joint {joint.name!r}", node) for joint in self.joints for node in joint.nodes]
        for tendon in self.tendons:
            about += [(f"tendon {tendon.name!r}", n) for n in tendon.along if not isinstance(tendon.along, str)]
        for what, node in about:
            if node not in places:
                raise ModelError(
                    f"there is no node {node!r} for the {what}",
                    f"{nearest(node, places)}nodes are {', '.join(places)}",
                    code="DX420",
                )
        rods = [load.rod for load in self.loads if isinstance(load, (Distributed, Pressure))]
        rods += [a.rod for a in self.actuations] + [d.rod for d in self.drags]
        for name in (*rods, *(t.along for t in self.tendons if isinstance(t.along, str))):
            self._rod(name)
        self._touching()
        if any(isinstance(load, Gravity) for load in self.loads) and not (
            self.bodies or any(r.section.A_rho for r in self.rods)
        ):
            raise ModelError("gravity is given and no rod has mass", "give the sections rho= or A_rho=", code="DX427")

    def _touching(self) -> None:
        """Rods of the contacts are there, and have a radius and a width."""
        for touch in (*self.contacts, *self.rod_contacts):
            names = touch.rods or tuple(rod.name for rod in self.rods)
            for name in (*names, *((touch.others or ()) if isinstance(touch, RodContact) else ())):
                radius = touch.radius_of(name, self._rod(name).section)
                touch.width_of(radius)
                if isinstance(touch, RodContact) and radius == 0.0:
                    raise ModelError(f"{touch.where}: rod {name!r} has no radius, nothing can touch it", "give radius=")

    def _values(self) -> None:
        """Functions of time are tried once, so that a wrong one is found before anything runs."""
        tried: list[tuple[str, Any]] = []
        for p in self.prescribed:
            tried += [
                (f"prescribed {k} of node {p.node!r}", v)
                for k, v in (("displacement", p.displacement), ("rotation", p.rotation))
            ]
        for joint in self.joints:
            for key, given in (("prescribed", joint.prescribed), ("drive", joint.drive)):
                if callable(given):
                    number(_called(given, f"{key} of joint {joint.name!r}"), f"{key} of joint {joint.name!r} at t = 0")
        for load in self.loads:
            if isinstance(load, Pressure):
                if callable(load.value):
                    value_at(load.value, 1, f"the pressure on rod {load.rod!r}", 0.0)
                continue
            place = "" if isinstance(load, Gravity) else load.rod if isinstance(load, Distributed) else load.node
            tried.append((f"{type(load).__name__.lower()} {place!r}" if place else "gravity", load.value))
        for what, value in tried:
            if callable(value):
                vector(_called(value, what), f"{what} at t = 0")
        for driven in (*self.drags, *self.tendons):
            driven.at(0.0, 1.0)
        for actuation in self.actuations:
            actuation.at(0.0, 1.0, np.zeros(1))

    def _held(self) -> dict[str, set[str]]:
        """Held components of every node; refuses a component that is held twice."""
        held: dict[str, set[str]] = {}
        given: Iterable[tuple[str, tuple[str, ...]]] = [
            *((s.node, s.dofs) for s in self.supports),
            *((p.node, DOFS[:3]) for p in self.prescribed if p.displacement is not None),
            *((p.node, DOFS[3:]) for p in self.prescribed if p.rotation is not None),
        ]
        for node, dofs in given:
            twice = held.setdefault(node, set()) & set(dofs)
            if twice:
                raise ModelError(
                    f"node {node!r} is held twice in {', '.join(d for d in DOFS if d in twice)}",
                    "keep one support or prescribed motion",
                    code="DX424",
                )
            held[node] |= set(dofs)
        return held


def _made_rod(
    *, curve: Any, section: Any, name: str, ends: Any = None, elements: Any = 10, order: Any = 2, points: Any = None,
    nodes: Any = None, twist: Any = None,
) -> Rod:  # fmt: skip
    """A rod that can be right; raises ModelError."""
    where = f"rod {name!r}"
    if not all(hasattr(curve, a) for a in ("position", "frames", "length", "breaks")):
        raise ModelError(
            f"{where}: {shown(curve)} is not a curve",
            "use dx.line, dx.arc, dx.helix, dx.polyline or dx.spline",
        )
    if not isinstance(section, Section):  # pyright: ignore[reportUnnecessaryIsInstance]
        raise ModelError(f"{where}: {shown(section)} is not a section", "use dx.Section")
    if twist is not None:
        curve = twisted(curve, twist)
    pair: Any = ends if ends is not None else (f"{name}.start", f"{name}.end")
    if not isinstance(pair, (tuple, list)) or len(cast("list[Any]", pair)) != 2:
        raise ModelError(f"{where}: ends = {shown(pair)} are not two names", 'give ends=("A", "B")')
    start, end = (text(e, f"{where}: name of an end") for e in cast("list[Any]", pair))
    if start == end:
        raise ModelError(f"{where}: both ends are called {start!r}", "a closed ring needs two rods")
    order = whole(order, f"{where}: order", 1, 3)
    elements = whole(elements, f"{where}: elements", 1, MOST)
    if not 0.0 < curve.length < np.inf:
        raise ModelError(f"{where}: its axis is {curve.length:g} long", "give it a finite length")
    if points is not None:
        points = whole(points, f"{where}: points", 1, order + 1)
    inner: list[tuple[str, float]] = []
    for node, fraction in _named(nodes, where):
        inner.append(_interior(where, node, fraction, (start, end, *(n for n, _ in inner))))
    return Rod(name, curve, section, (start, end), elements, order, points, tuple(inner))


def _called(value: Any, what: str) -> Any:
    """``value`` at t = 0."""
    try:
        return value(0.0)
    except Exception as error:  # whatever a user's function raises
        raise ModelError(f"{what}: the function fails at t = 0: {error!r}", "it is called with one number") from error


def place_on(curve: Curve, fraction: float) -> Any:
    """Place at a fraction of the arclength; the ends of a straight line are known."""
    if isinstance(curve, Polyline) and len(curve.points) == 2 and fraction in (0.0, 1.0):
        return np.array(curve.points[int(fraction)])
    return curve.position(fraction * curve.length)


def _named(nodes: Any, where: str) -> list[tuple[Any, Any]]:
    if nodes is not None and not isinstance(nodes, Mapping):
        raise ModelError(f"{where}: nodes = {shown(nodes)} are not names with fractions", 'give nodes={"P": 0.5}')
    return list(cast("Mapping[Any, Any]", nodes or {}).items())


def _interior(where: str, node: Any, fraction: Any, taken: tuple[str, ...]) -> tuple[str, float]:
    node = text(node, f"{where}: name of an interior node")
    if node in taken:
        raise ModelError(
            f"{where}: there are two nodes {node!r} on it", "give each node a name of its own", code="DX422"
        )
    if not 0.0 < number(fraction, f"{where}: fraction of node {node!r}") < 1.0:
        raise ModelError(
            f"{where}: node {node!r} at {fraction} is not inside the rod",
            "give a fraction of its arclength between 0 and 1",
        )
    return node, float(fraction)


def _show(point: Any) -> str:
    return "(" + ", ".join(f"{c:g}" for c in point) + ")"
