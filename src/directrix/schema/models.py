"""The case file as pydantic sees it: every table, key and bound. TOML and JSON share it.

Units are whatever consistent set the user works in; angles are in radians unless the key says degrees.
"""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import Discriminator, Field, Tag, model_validator

from directrix.checks import step_count
from directrix.errors import ModelError
from directrix.parts import FIELDS, Keep
from directrix.schema.base import (
    ACCELERATION,
    ANGLE,
    CURVATURE,
    DEGREES,
    DRAG,
    FORCE,
    FORCE_PER_AREA_LENGTH,
    FORCE_PER_LENGTH,
    FORCE_PER_SPEED,
    INERTIA,
    LENGTH,
    MASS,
    MOMENT,
    SPEED,
    STRESS,
    TIME,
    Name,
    NotNegative,
    Numbers,
    Place,
    Places,
    Positive,
    Speed,
    Spin,
    Strict,
    Tolerance,
    Vector,
    refuse,
)
from directrix.schema.functions import Angles, PlaceTable, Time, TurnTable, VectorTable, check_table
from directrix.schema.geometry import AnyGeometry, Catenary, Centreline
from directrix.schema.joints import AnyJoint, Node
from directrix.schema.sections import Section

__all__ = ["CURVES", "CaseFile", "Dynamics", "Output", "Statics"]


def _vector_or_table(value: object) -> str:
    return "table" if isinstance(value, dict | VectorTable) else "vector"


Displacement = Annotated[
    Annotated[Place, Tag("vector")] | Annotated[PlaceTable, Tag("table")], Discriminator(_vector_or_table)
]
Turning = Annotated[
    Annotated[Angles, Tag("vector")] | Annotated[TurnTable, Tag("table")], Discriminator(_vector_or_table)
]
_F = Annotated[float, FORCE]
_M = Annotated[float, MOMENT]
_Q = Annotated[float, FORCE_PER_LENGTH]
_G = Annotated[float, ACCELERATION]
_I = Annotated[float, INERTIA]
Forces = Annotated[tuple[_F, _F, _F], Field(strict=False)]
Moments = Annotated[tuple[_M, _M, _M], Field(strict=False)]
LineLoads = Annotated[tuple[_Q, _Q, _Q], Field(strict=False)]
Accelerations = Annotated[tuple[_G, _G, _G], Field(strict=False)]
Inertias = Annotated[tuple[_I, _I, _I], Field(strict=False)]


Twist = tuple[float, Annotated[float, ANGLE]]

# --- rods


class Arc(Strict):
    """Circular arc through three points."""

    start: Place
    through: Place
    end: Place


class Helix(Strict):
    """Circular helix around an axis."""

    radius: Annotated[Positive, LENGTH]
    pitch: Annotated[float, LENGTH]
    """Climb per turn."""
    turns: float
    """Number of turns; negative winds left-handed."""
    origin: Place = (0.0, 0.0, 0.0)
    """A point of the axis; the helix starts beside it."""
    axis: Vector = (0.0, 0.0, 1.0)
    """Direction of the axis."""
    toward: Vector | None = None
    """Direction from the axis to the start; default: the Cartesian axis least aligned with ``axis``."""


CURVES = ("line", "arc", "helix", "polyline", "spline", "catenary", "centreline")


class Rod(Strict):
    """One rod: a section, a mesh, and exactly one of line, arc, helix, polyline, spline, catenary, centreline."""

    name: Name
    section: Name
    """Name of a ``[section.…]`` of this file."""
    line: Annotated[tuple[Place, Place], Field(strict=False)] | None = None
    """Straight from the first to the second point."""
    arc: Arc | None = None
    """Circular arc."""
    helix: Helix | None = None
    """Circular helix."""
    polyline: Places | None = None
    """Straight between the points."""
    spline: Annotated[tuple[Place, ...], Field(strict=False, min_length=3)] | None = None
    """Smooth through three points or more."""
    catenary: Catenary | None = None
    """Chain that hangs between two points."""
    centreline: Centreline | None = None
    """Smooth through the points of a file."""
    twist: (
        Annotated[float, ANGLE]
        | Annotated[tuple[Annotated[Twist, Field(strict=False)], ...], Field(strict=False, min_length=2)]
        | None
    ) = None
    """Turn [rad] of the sections about the axis at its end, or pairs (fraction of the arclength, angle)."""
    d1: Vector | None = None
    """Its part normal to the axis at the start is the first director.

    Default: the Cartesian axis least aligned with the rod there, ties to the lowest.
    """
    directors: Literal["tangent", "chord"] = "tangent"
    """Directors follow the curve, or the chord of every element."""
    ends: Annotated[tuple[Name, Name], Field(strict=False)] | None = None
    """Names of the end nodes; equal names join rods rigidly. Default: ``<name>.start``, ``<name>.end``."""
    nodes: dict[Name, Annotated[float, Field(gt=0.0, lt=1.0)]] = Field(default_factory=dict[str, float])
    """Names of interior nodes, by their fraction of the arclength."""
    elements: Annotated[int, Field(ge=1, le=1_000_000)]
    order: Literal[1, 2, 3] = 2
    """Polynomial order of the elements."""
    points: Annotated[int, Field(ge=1, le=4)] | None = None
    """Gauss points for the stresses of an element; default ``order``."""

    @model_validator(mode="after")
    def _one_curve(self) -> Self:
        given = [key for key in CURVES if getattr(self, key) is not None]
        if len(given) != 1:
            has = f"has {' and '.join(given)}" if given else "has no curve"
            raise refuse(f"rod {self.name!r} {has}", f"give exactly one of {', '.join(CURVES)}")
        return self


# --- supports, loads, initial motion


class Support(Strict):
    """A node that cannot move: ``type`` or the list of ``dofs``."""

    node: Name
    type: Literal["clamp", "pin"] | None = None
    """``clamp`` holds position and rotation, ``pin`` the position."""
    dofs: Annotated[tuple[Literal["x", "y", "z", "rx", "ry", "rz"], ...], Field(strict=False, min_length=1)] | None = (
        None
    )
    """Components held, in the global frame."""

    @model_validator(mode="after")
    def _one_way(self) -> Self:
        if (self.type is None) == (self.dofs is None):
            raise refuse(
                "a support needs either type or dofs",
                'write type = "clamp", type = "pin" or e.g. dofs = ["x", "y"]',
            )
        return self


class Turn(Strict):
    """A rigid turn about a line: carries the node along and turns it."""

    axis: Vector
    """Direction of the line; right-handed."""
    degrees: Annotated[float, DEGREES]
    """The angle; its plain number is in degrees."""
    about: Place = (0.0, 0.0, 0.0)
    """A point of the line."""
    time: Time | None = None
    """Factor on ``degrees``; statics ramps it unless given, dynamics needs it."""

    @model_validator(mode="after")
    def _direction(self) -> Self:
        if not any(self.axis):
            raise refuse("axis = [0, 0, 0] has no direction", "give the direction of the line", "axis")
        return self


class Prescribe(Strict):
    """A node that is moved: displacement and rotation vector from the reference, a rigid turn on top."""

    node: Name
    displacement: Displacement | None = None
    """Vector (times ``time``), or a table ``{ t = […], value = [[…], …] }``."""
    rotation: Turning | None = None
    """Rotation vector in radians (times ``time``), or a table."""
    turn: Turn | None = None
    """Rigid turn that follows the displacement."""
    time: Time | None = None
    """Factor on displacement and rotation given as vectors."""

    @model_validator(mode="after")
    def _something(self) -> Self:
        if self.displacement is None and self.rotation is None and self.turn is None:
            raise refuse(f"nothing is prescribed at node {self.node!r}", "give displacement, rotation or turn")
        if self.rotation is not None and self.turn is not None:
            raise refuse("rotation and turn both say how the node turns", "give one of them", "turn")
        if self.time is not None and not any(isinstance(m, tuple) for m in (self.displacement, self.rotation)):
            raise refuse(
                "there is no vector that time could multiply",
                "leave time out: a table or a turn has its own",
                "time",
            )
        return self


class Load(Strict):
    """A vector, and when it acts."""

    value: Vector
    """Vector in the global frame."""
    time: Time | None = None
    """Factor of time (statics: of the load factor, which multiplies the load as well unless ``constant``)."""
    constant: bool = False
    """Statics: not multiplied by the load factor."""


class Force(Load):
    """Force at a node."""

    value: Forces
    """Vector in the global frame."""

    node: Name
    follower: bool = False
    """It turns with the node; ``value`` is then its direction in the reference."""


class Moment(Load):
    """Spatial moment at a node."""

    value: Moments
    """Vector in the global frame."""

    node: Name
    follower: bool = False
    """It turns with the node; ``value`` is then its direction in the reference."""


class Distributed(Load):
    """Force per reference length along a rod."""

    value: LineLoads
    """Vector in the global frame."""

    rod: Name
    follower: bool = False
    """It turns with the sections; ``value`` is then its direction in the reference."""


class Pressure(Strict):
    """Pressure on one side of a rod: value · width per reference length, along a director."""

    rod: Name
    value: Annotated[float, STRESS]
    width: Annotated[Positive, LENGTH] = 1.0
    along: Literal["d1", "d2", "-d1", "-d2"] = "d1"
    """The director that it pushes along; the force follows the section."""
    time: Time | None = None
    """Factor of time (statics: of the load factor, which multiplies the load as well unless ``constant``)."""
    constant: bool = False
    """Statics: not multiplied by the load factor."""


class Gravity(Load):
    """Acceleration of free fall."""

    value: Accelerations
    """Vector in the global frame."""


class Velocity(Strict):
    """Initial velocity of one node."""

    node: Name
    v: Speed
    omega: Spin = (0.0, 0.0, 0.0)


class RigidVelocity(Strict):
    """Initial velocity of the whole model: v + omega × (r − about)."""

    v: Speed
    omega: Spin = (0.0, 0.0, 0.0)
    about: Place = (0.0, 0.0, 0.0)


# --- what is attached


def _name_or_place(value: object) -> str:
    return "node" if isinstance(value, str) else "place"


End = Annotated[Annotated[Name, Tag("node")] | Annotated[Place, Tag("place")], Discriminator(_name_or_place)]


class Link(Strict):
    """A straight link from a point of a node to a point of another, or to a place on the ground."""

    name: Name | None = None
    """"link1", "link2", … unless given."""
    a: Name
    """Node of the first point."""
    b: End
    """Node of the second point, or the place [x, y, z] on the ground."""
    offset_a: Place = (0.0, 0.0, 0.0)
    """From the node to the first point, in the reference; turns with the node."""
    offset_b: Place = (0.0, 0.0, 0.0)
    """From the node to the second point."""


class Spring(Link):
    """Linear spring."""

    stiffness: Annotated[Positive, FORCE_PER_LENGTH]
    length: Annotated[NotNegative, LENGTH] | None = None
    """Without tension; the distance in the reference unless given."""
    damping: Annotated[NotNegative, FORCE_PER_SPEED] = 0.0
    """Force per rate of length."""


class Cable(Spring):
    """Pulls and does not push."""

    width: Annotated[Positive, LENGTH] | None = None
    """Length over which the change is smooth; a thousandth of ``length`` unless given."""


class Dashpot(Link):
    """Force proportional to the rate of length, in dynamics."""

    damping: Annotated[Positive, FORCE_PER_SPEED]


# --- what drives and resists


Offset = tuple[Annotated[float, LENGTH], Annotated[float, LENGTH]]
Curvatures = tuple[Annotated[float, CURVATURE], Annotated[float, CURVATURE]]


class Along(Strict):
    """A factor along a rod, piecewise linear, constant before the first and after the last place."""

    s: Annotated[tuple[Annotated[float, LENGTH], ...], Field(strict=False, min_length=2)]
    """Arclengths from the start of the rod."""
    factor: Numbers
    """One for each."""

    @model_validator(mode="after")
    def _table(self) -> Self:
        check_table(self.s, self.factor, "s", "factor")
        return self


class OffsetTable(Strict):
    """Where a tendon runs, piecewise linear along its rod."""

    fraction: Numbers
    """Of the arclength."""
    offset: Annotated[tuple[Annotated[Offset, Field(strict=False)], ...], Field(strict=False, min_length=2)]
    """Distance from the axis along d1 and d2, one pair for each."""

    @model_validator(mode="after")
    def _table(self) -> Self:
        check_table(self.fraction, self.offset, "fraction", "offset")
        return self


class Actuate(Strict):
    """Strain at which a rod is without stress; what is given adds up."""

    rod: Name
    curvature: Annotated[Curvatures, Field(strict=False)] | None = None
    """Bending 1 and bending 2, about d1 and d2."""
    twist: Annotated[float, CURVATURE] | None = None
    elongation: float | None = None
    strain: Annotated[tuple[float, float, float, float, float, float], Field(strict=False)] | None = None
    """Shear 1, shear 2, axial, bending 1, bending 2, torsion."""
    along: Along | None = None
    """Factor along the rod."""
    time: Time | None = None
    """Factor of time; statics ramps with the load factor unless given."""


class Tendon(Strict):
    """A tendon without friction along a rod or from node to node, of given tension."""

    name: Name | None = None
    """"tendon1", "tendon2", … unless given."""
    rod: Name | None = None
    """The rod that it goes along, through the ends of its elements."""
    nodes: Annotated[tuple[Name, ...], Field(strict=False, min_length=2)] | None = None
    """The nodes that it goes through."""
    tension: Annotated[NotNegative, FORCE]
    offset: Annotated[Offset, Field(strict=False)] = (0.0, 0.0)
    """Along a rod: distance from the axis along d1 and d2."""
    offset_end: Annotated[Offset, Field(strict=False)] | None = None
    """The same at the end of the rod, linear between; ``offset`` unless given."""
    route: OffsetTable | None = None
    """Along a rod: where it runs, in place of offset and offset_end."""
    offsets: Places | None = None
    """Through nodes: from each node to its point, in the reference."""
    time: Time | None = None
    """Factor of time (statics: of the load factor, which multiplies the tension as well unless ``constant``)."""
    constant: bool = False
    """Statics: not multiplied by the load factor."""

    @model_validator(mode="after")
    def _one_way(self) -> Self:
        if (self.rod is None) == (self.nodes is None):
            raise refuse("a tendon needs either rod or nodes", "name the rod it goes along, or the nodes")
        if self.offsets is not None and self.rod is not None:
            raise refuse("offsets belong to nodes", "a tendon along a rod has offset and offset_end", "offsets")
        if self.route is not None and (self.rod is None or {"offset", "offset_end"} & self.model_fields_set):
            raise refuse(
                "route is all that is said of where a tendon along a rod runs", "leave the others out", "route"
            )
        return self


class Drag(Strict):
    """Quadratic drag of a fluid: −normal |v_n| v_n − tangential |v_t| v_t per reference length."""

    rod: Name
    normal: Annotated[NotNegative, DRAG]
    """½ ρ C_n d."""
    tangential: Annotated[NotNegative, DRAG] = 0.0
    """½ ρ C_t π d."""
    flow: Speed = (0.0, 0.0, 0.0)
    """Velocity of the fluid."""
    time: Time | None = None
    """Factor on ``flow`` (statics: of the load factor, which multiplies it as well unless ``constant``)."""
    constant: bool = False
    """Statics: the flow is not multiplied by the load factor."""


class PointMass(Strict):
    """Mass on a node."""

    node: Name
    mass: Annotated[Positive, MASS]


class RigidBody(PointMass):
    """Rigid body on a node, its centre of mass there or ``offset`` from it."""

    inertia: Annotated[tuple[Inertias, Inertias, Inertias], Field(strict=False)]
    """3×3 about its centre of mass, in the reference frame."""
    offset: Place | None = None
    """From the node to its centre of mass, which is then a node "NODE.body" in a rigid joint of that name."""


# --- what rods may touch


class Plane(Strict):
    """A plane."""

    kind: Literal["plane"]
    point: Place
    normal: Vector
    """To where the rods are."""


class Sphere(Strict):
    """A sphere."""

    kind: Literal["sphere"]
    center: Place
    radius: Annotated[NotNegative, LENGTH]
    inside: bool = False
    """The rods are within it."""


class Cylinder(Strict):
    """A cylinder without ends."""

    kind: Literal["cylinder"]
    point: Place
    """A point of its axis."""
    axis: Vector
    radius: Annotated[NotNegative, LENGTH]
    inside: bool = False
    """The rods are within it: a pipe."""


RodNames = Annotated[tuple[Name, ...], Field(strict=False, min_length=1)]


class Touch(Strict):
    """What all contacts have."""

    name: Name | None = None
    """"contact1", "contact2", … unless given."""
    stiffness: Annotated[Positive, FORCE_PER_AREA_LENGTH]
    """Force per penetration and per length of rod."""
    friction: NotNegative = 0.0
    """Coulomb's coefficient, in dynamics."""
    slip_speed: Annotated[Positive, SPEED] | None = None
    """Sliding speed below which friction falls off; needed with friction."""
    radius: Annotated[Positive, LENGTH] | None = None
    """Of the rods; that of a round section unless given."""
    width: Annotated[Positive, LENGTH] | None = None
    """Penetration over which the force rises; a tenth of the radius unless given."""


class Contact(Touch):
    """Rods against a surface that is fixed."""

    obstacle: Annotated[Plane | Sphere | Cylinder, Field(discriminator="kind")]
    rods: RodNames | None = None
    """All unless given."""
    radius: Annotated[NotNegative, LENGTH] | None = None
    """Of the rods; that of a round section unless given."""


PointsOfPiece = Annotated[int, Field(ge=1, le=6)]


class SelfContact(Touch):
    """Rods against one another and each against itself."""

    rods: RodNames | None = None
    """All unless given."""
    points: PointsOfPiece = 2
    """Of every piece between two nodes, which are held against the pieces that come near."""


class ContactBetween(Touch):
    """Rods against others."""

    rods: RodNames
    others: RodNames
    points: PointsOfPiece = 2
    """Of every piece between two nodes, which are held against the pieces that come near."""


# --- what to do


Scheme = Literal[
    "energy-momentum", "midpoint", "energy-dissipating", "generalized-alpha", "hilber-hughes-taylor", "newmark",
    "simo-tarnow-doblare",
]  # fmt: skip
Formulation = Literal["directors", "simo-vu-quoc", "crisfield-jelenic"]
PARAMETERS: dict[str, tuple[str, ...]] = {
    "energy-dissipating": ("chi_stress", "chi_velocity"),
    "generalized-alpha": ("rho_inf",),
    "hilber-hughes-taylor": ("alpha",),
    "newmark": ("beta", "gamma"),
}


class Reach(Strict):
    """A displacement of a node that is to be reached."""

    node: Name
    component: Literal["x", "y", "z"]
    displacement: Annotated[float, LENGTH]
    """From the reference; reached when it is this much or more, in the sense of its sign."""

    @model_validator(mode="after")
    def _sense(self) -> Self:
        if self.displacement == 0.0:
            raise refuse("a displacement of 0 has no sense to be reached in", "give a small one", "displacement")
        return self


LoadFactors = Annotated[tuple[float, ...], Field(strict=False)]


class ArcLength(Strict):
    """Follow the path by its own length: the load factor may rise and fall."""

    kind: Literal["arc-length"]
    ds: Positive
    """Length of the first step; steps grow up to 4 ds and shrink down to ds/4096."""
    max_steps: Annotated[int, Field(ge=1, le=1_000_000)] = 200
    max_load_factor: float | None = None
    """The run ends where the load factor rises to this."""
    min_load_factor: float | None = None
    """The run ends where the load factor falls to this."""
    until: Reach | None = None
    """The run ends when a node has moved so far."""
    load_factors: LoadFactors = ()
    """Load factors to stop at on the way, wherever the path crosses them."""
    load_step: Positive | None = None
    """Largest change of the load factor in a step, for paths along which next to nothing moves."""
    branch: int | Annotated[tuple[int, ...], Field(strict=False)] = ()
    """Which bifurcation to leave the path at: 1 or -1 for the two sides of the first one, 2 or -2 for the second, …"""


class DisplacementControl(Strict):
    """Drive one displacement of one node to a value; the load factor follows."""

    kind: Literal["displacement"]
    node: Name
    component: Literal["x", "y", "z"]
    to: Annotated[float, LENGTH]
    """Displacement from the reference to reach."""
    steps: Annotated[int, Field(ge=1, le=1_000_000)] = 10
    """Equal parts of the way; they are cut when needed."""
    load_factors: LoadFactors = ()
    """Load factors to stop at on the way, wherever the path crosses them."""


Solver = Literal["rslab", "pardiso"]


class Statics(Strict):
    """Equilibria while the load factor goes from 0 to 1, or along the path of a control."""

    formulation: Formulation = "directors"
    """The others are there for comparison."""

    steps: Annotated[int, Field(ge=1, le=1_000_000_000)] = 10
    """Equal parts of the load path; they are cut when needed. Not with a control."""
    control: Annotated[ArcLength | DisplacementControl, Field(discriminator="kind")] | None = None
    """What drives the path in place of the load factor."""
    tolerance: Tolerance = 1e-9
    """Unbalanced over largest element force."""
    rotation: Literal["exponential", "cayley"] = "exponential"
    """Update of the rotations in an iteration; both reach the same state."""
    stability: bool | None = None
    """Count the negative pivots at every saved state and look for critical points; with a control unless said."""
    linear: Solver | None = None
    """Package that solves a frame of many joints; SciPy unless given."""

    @model_validator(mode="after")
    def _one_drive(self) -> Self:
        if self.control is not None and "steps" in self.model_fields_set:
            raise refuse("steps are those of load control, and there is a control", "leave steps out", "steps")
        return self


class Adaptive(Strict):
    """Steps as long as an error allows."""

    tolerance: Tolerance = 1e-3
    """Largest local error of a step, of positions over the size of the model and of rotations in radians."""
    dt_min: Annotated[Positive, TIME] | None = None
    """Shortest step; 1e-9 of the whole time unless given."""
    dt_max: Annotated[Positive, TIME] | None = None
    """Longest step; a tenth of the whole time unless given."""
    save_at: Annotated[Positive, TIME] | None = None
    """Steps end at the multiples of this interval, and those states are kept; every one of ``save_every`` otherwise."""


class Dynamics(Strict):
    """Motion from t = 0 to t_end."""

    t_end: Annotated[Positive, TIME]
    dt: Annotated[Positive, TIME]
    """Time step; ``t_end`` must be a whole number of them. The first step that is tried, with ``adaptive``."""
    adaptive: Adaptive | None = None
    """Steps as long as an error allows, in place of equal ones."""
    integrator: Scheme = "energy-momentum"
    chi_stress: NotNegative | None = None
    """energy-dissipating: what a step takes from changes of strain; 0.5 unless given."""
    chi_velocity: Annotated[float, Field(ge=0.0, lt=1.0 / 3.0)] | None = None
    """energy-dissipating: what a step takes from changes of speed, on a lumped mass; 0 unless given."""
    rho_inf: Annotated[float, Field(ge=0.0, le=1.0)] | None = None
    """generalized-alpha: spectral radius at infinity; 0.8 unless given."""
    alpha: Annotated[float, Field(ge=0.0, le=1.0 / 3.0)] | None = None
    """hilber-hughes-taylor: 0.1 unless given."""
    beta: Positive | None = None
    """newmark: ¼ unless given."""
    gamma: Positive | None = None
    """newmark: ½ unless given."""
    load_rule: Literal["midpoint", "average"] = "midpoint"
    """A load acts over a step with its value at the middle, or with the mean of its end values."""
    tolerance: Tolerance = 1e-9
    """Unbalanced over largest element force."""
    linear: Solver | None = None
    """Package that solves a frame of many joints; SciPy unless given."""

    @property
    def parameters(self) -> dict[str, float]:
        """What the file says of the integrator's own parameters."""
        names = PARAMETERS.get(self.integrator, ())
        return {k: getattr(self, k) for k in names if getattr(self, k) is not None}

    @model_validator(mode="after")
    def _own_parameters(self) -> Self:
        for owner, names in PARAMETERS.items():
            for name in names:
                if owner != self.integrator and getattr(self, name) is not None:
                    raise refuse(f"{name} belongs to {owner}, not to {self.integrator}", "leave it out", name)
        return self

    @model_validator(mode="after")
    def _whole_steps(self) -> Self:
        try:
            if self.adaptive is None:
                step_count(0.0, self.t_end, self.dt)
        except ModelError as error:
            raise refuse(error.what, error.fix, "dt") from None
        return self


class Output(Strict):
    """What is kept."""

    save_every: Annotated[int, Field(ge=1, le=1_000_000_000)] = 1
    """Keep every so many steps; the last one is always kept."""
    keep: Annotated[tuple[Name, ...] | None, Field(strict=False, min_length=1)] = None
    """Names of the nodes and rods to keep; all unless given."""
    fields: Annotated[tuple[Literal["velocity", "reaction", "force"], ...], Field(strict=False)] = FIELDS
    """What to keep of them beside positions and rotations; "force" with the strains."""
    checkpoint_seconds: Annotated[float, Field(ge=0.0)] = 20.0
    """Time between two checkpoints."""
    checkpoint_steps: Annotated[int, Field(ge=1, le=1_000_000_000)] | None = None
    """A checkpoint after so many steps as well."""

    @property
    def keeps(self) -> Keep | None:
        """What is kept, as the solvers take it; None is all."""
        keep = Keep(self.keep, self.fields)
        return None if keep == Keep() else keep


class Record(Strict):
    """A point of a rod whose history goes to ``record-NAME.csv`` while the run goes on."""

    rod: Name
    s: Annotated[NotNegative, LENGTH]
    """Arclength on the reference axis; any, not only that of a node."""
    quantities: Annotated[
        tuple[Literal["r", "displacement", "v", "strain", "force"], ...], Field(strict=False, min_length=1)
    ] = ("r", "force")
    """Position, displacement, velocity; strain and section force in the section's frame."""
    name: Annotated[str, Field(pattern=r"^[\w.-]+$")] | None = None
    """Of the file; default: rod and ``s``."""


class Units(Strict):
    """The units of plain numbers, in which the case is computed: length, time, and force or mass."""

    length: str = "m"
    time: str = "s"
    mass: str | None = None
    """kg unless given, or what the force makes of it."""
    force: str | None = None
    """In place of a mass."""

    @model_validator(mode="after")
    def _force_or_mass(self) -> Self:
        if self.force is not None and self.mass is not None:
            raise refuse(
                "force and mass are both given, and one follows from the other", "keep one", "mass", code="DX304"
            )
        return self


class CaseFile(Strict):
    """A case: sections, rods, nodes, what joins, holds, moves and loads them, and one analysis."""

    schema_: Annotated[str, Field(alias="$schema")] = ""
    """For editors: where the JSON schema is. In TOML a first line ``#:schema PATH`` says the same."""
    format_version: Annotated[int, Field(ge=1)] = 1
    """Of the case format; 1 is that of this directrix."""
    units: Units = Units()

    title: str = ""
    description: str = ""
    section: dict[Name, Section] = Field(default_factory=dict[str, Section])
    rod: Annotated[tuple[Rod, ...], Field(strict=False)] = ()
    geometry: Annotated[tuple[AnyGeometry, ...], Field(strict=False)] = ()
    node: Annotated[tuple[Node, ...], Field(strict=False)] = ()
    joint: Annotated[tuple[AnyJoint, ...], Field(strict=False)] = ()
    support: Annotated[tuple[Support, ...], Field(strict=False)] = ()
    prescribe: Annotated[tuple[Prescribe, ...], Field(strict=False)] = ()
    force: Annotated[tuple[Force, ...], Field(strict=False)] = ()
    moment: Annotated[tuple[Moment, ...], Field(strict=False)] = ()
    distributed: Annotated[tuple[Distributed, ...], Field(strict=False)] = ()
    pressure: Annotated[tuple[Pressure, ...], Field(strict=False)] = ()
    gravity: Gravity | None = None
    velocity: Annotated[tuple[Velocity, ...], Field(strict=False)] = ()
    spring: Annotated[tuple[Spring, ...], Field(strict=False)] = ()
    cable: Annotated[tuple[Cable, ...], Field(strict=False)] = ()
    dashpot: Annotated[tuple[Dashpot, ...], Field(strict=False)] = ()
    actuate: Annotated[tuple[Actuate, ...], Field(strict=False)] = ()
    tendon: Annotated[tuple[Tendon, ...], Field(strict=False)] = ()
    drag: Annotated[tuple[Drag, ...], Field(strict=False)] = ()
    point_mass: Annotated[tuple[PointMass, ...], Field(strict=False)] = ()
    rigid_body: Annotated[tuple[RigidBody, ...], Field(strict=False)] = ()
    contact: Annotated[tuple[Contact, ...], Field(strict=False)] = ()
    self_contact: Annotated[tuple[SelfContact, ...], Field(strict=False)] = ()
    contact_between: Annotated[tuple[ContactBetween, ...], Field(strict=False)] = ()
    rigid_velocity: RigidVelocity | None = None
    statics: Statics | None = None
    dynamics: Dynamics | None = None
    record: Annotated[tuple[Record, ...], Field(strict=False)] = ()
    output: Output = Output()

    @property
    def grounded(self) -> bool:
        """True when something holds a part of the model."""
        links = (*self.spring, *self.cable, *self.dashpot)
        return bool(
            self.support
            or self.prescribe
            or any(joint.b is None for joint in self.joint)
            or any(not isinstance(link.b, str) for link in links)
        )

    @model_validator(mode="after")
    def _something(self) -> Self:
        if not self.rod and not self.node and not self.geometry:
            raise refuse(
                "the file has neither a [[rod]] nor a [[node]]",
                "add a [[rod]] with its [section.…], or a [[node]] with a [[rigid_body]]",
            )
        return self

    @model_validator(mode="after")
    def _one_analysis(self) -> Self:
        if self.statics is None and self.dynamics is None:
            raise refuse(
                "the file has neither [statics] nor [dynamics]", "add one of them: it says what to solve", code="DX218"
            )
        if self.statics is not None and self.dynamics is not None:
            raise refuse(
                "the file has both [statics] and [dynamics]",
                "one file, one analysis: keep one",
                "dynamics",
                code="DX218",
            )
        if self.statics is not None and not self.grounded:
            raise refuse(
                "nothing is held, and statics needs a support for every part of the model",
                "add a [[support]] or a [[joint]] with the ground, or replace [statics] by [dynamics]",
                "statics",
            )
        for key in ("velocity", "rigid_velocity"):
            if self.statics is not None and getattr(self, key):
                raise refuse(f"[{key}] means nothing in statics", "remove it, or replace [statics] by [dynamics]", key)
        return self
