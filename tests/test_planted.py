"""NaN and infinity, planted at every number that public functions take: each is refused, and the refusal names it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest

import directrix as dx

SECTION = dx.Section.from_moduli(EA=1e3, GA1=1e3, GA2=1e3, EI1=1.0, EI2=1.0, GJ=1.0, A_rho=1.0, I_rho1=0.1, I_rho2=0.1)
BEAM = dx.Model().rod(dx.line((0, 0, 0), (1, 0, 0)), SECTION, name="beam", ends=("A", "B"), elements=2).clamp("A")
PAIR = BEAM.rod(dx.line((0, 1, 0), (1, 1, 0)), SECTION, name="other", elements=2)
TOUCH = {"stiffness": 1.0, "friction": 0.1, "slip_speed": 0.1, "radius": 0.1, "width": 0.01}
MODULI = {
    "EA": 1.0,
    "GA1": 1.0,
    "GA2": 1.0,
    "EI1": 1.0,
    "EI2": 1.0,
    "GJ": 1.0,
    "A_rho": 1.0,
    "I_rho1": 1.0,
    "I_rho2": 1.0,
}
FREE = {"stiffness": 1.0, "rest": 0.1, "damping": 0.1, "drive": 1.0}
STOPS = {"stops": (-1.0, 1.0), "stop_stiffness": 1.0, "stop_width": 0.1}

# every public function that takes numbers: what it is, fixed arguments, then all the numbers it takes
CALLS: dict[str, tuple[Callable[..., Any], tuple[Any, ...], dict[str, Any]]] = {
    "line": (dx.line, (), {"start": (0.0, 0.0, 0.0), "end": (1.0, 0.0, 0.0), "d1": (0.0, 1.0, 0.0)}),
    "arc": (dx.arc, (), {"start": (0.0, 0, 0), "through": (1.0, 1, 0), "end": (2.0, 0, 0), "d1": (0.0, 0, 1)}),
    "helix": (dx.helix, (), {"radius": 1.0, "pitch": 0.3, "turns": 2.0, "origin": (0.0, 0, 0), "axis": (0.0, 0, 1),
                             "toward": (1.0, 0, 0)}),
    "polyline": (dx.polyline, (), {"points": ((0.0, 0, 0), (1.0, 0, 0), (1.0, 1, 0))}),
    "spline": (dx.spline, (), {"points": ((0.0, 0, 0), (1.0, 0, 0), (1.0, 1, 0))}),
    "circle": (dx.Section.circle, (), {"radius": 1.0, "E": 1.0, "nu": 0.3, "rho": 1.0, "shear_factor": 0.9,
                                       "torsion_constant": 1.0, "damping": 0.1}),
    "tube": (dx.Section.tube, (), {"outer": 1.0, "wall": 0.1, "E": 1.0, "nu": 0.3, "rho": 1.0}),
    "rectangle": (dx.Section.rectangle, (), {"width": 1.0, "height": 2.0, "E": 1.0, "nu": 0.3, "rho": 1.0}),
    "from_moduli": (dx.Section.from_moduli, (), {**MODULI, "damping": 0.1}),
    "Section": (lambda **k: dx.Section(**k, order="shear-axial"), (),
                {"stiffness": np.eye(6), "A_rho": 1.0, "I_rho": np.eye(2), "damping": 0.1 * np.eye(6),
                 "outline": np.array([[0.0, 0], [1.0, 0], [0, 1.0]])}),
    "damped": (SECTION.damped, (), {"damping": 0.1}),
    "node": (BEAM.node, ("P",), {"at": (0.0, 1.0, 0.0)}),
    "rod": (lambda *, nodes: BEAM.split("beam", {"P": nodes}), (), {"nodes": 0.5}),
    "prescribe": (BEAM.prescribe, ("B",), {"displacement": (0.0, 0, 1), "rotation": (0.0, 0, 1)}),
    "force": (BEAM.force, ("B",), {"f": (0.0, 0, 1)}),
    "moment": (BEAM.moment, ("B",), {"m": (0.0, 0, 1)}),
    "distributed": (BEAM.distributed, ("beam",), {"f": (0.0, 0, 1)}),
    "pressure": (BEAM.pressure, ("beam",), {"p": 1.0, "width": 2.0}),
    "gravity": (BEAM.gravity, (), {"g": (0.0, 0, 1)}),
    "spring": (BEAM.spring, ("B", (1.0, 0.0, 1.0)), {"stiffness": 1.0, "length": 1.0, "damping": 0.1,
                                                     "offset_a": (0.0, 0, 0.1)}),
    "ground": (lambda *, b: BEAM.spring("B", b, 1.0), (), {"b": (1.0, 0.0, 1.0)}),
    "offset_b": (BEAM.spring, ("A", "B", 1.0), {"offset_b": (0.0, 0, 0.1)}),
    "dashpot": (BEAM.dashpot, ("B", (1.0, 0.0, 1.0)), {"damping": 0.1, "offset_a": (0.0, 0, 0.1)}),
    "cable": (BEAM.cable, ("B", (1.0, 0.0, 1.0)), {"stiffness": 1.0, "length": 1.0, "width": 0.1, "damping": 0.1}),
    "actuate": (BEAM.actuate, ("beam",), {"curvature": (0.1, 0.2), "twist": 0.1, "elongation": 0.1,
                                          "strain": (0.0, 0, 0.1, 0, 0, 0)}),
    "tendon": (BEAM.tendon, ("beam",), {"tension": 1.0, "offset": (0.1, 0.0)}),
    "drag": (BEAM.drag, ("beam",), {"normal": 1.0, "tangential": 0.1, "flow": (1.0, 0, 0)}),
    "point_mass": (BEAM.point_mass, ("B",), {"m": 1.0}),
    "rigid_body": (BEAM.rigid_body, ("B",), {"mass": 1.0, "inertia": np.eye(3), "offset": (0.1, 0.0, 0.0)}),
    "contact": (BEAM.contact, (dx.Plane((0, 0, -1), (0, 0, 1)),), TOUCH),
    "self_contact": (BEAM.self_contact, (), TOUCH),
    "contact_between": (PAIR.contact_between, ("beam", "other"), TOUCH),
    "Plane": (dx.Plane, (), {"point": (0.0, 0, 0), "normal": (0.0, 0, 1)}),
    "Sphere": (dx.Sphere, (), {"center": (0.0, 0, 0), "radius": 1.0}),
    "Cylinder": (dx.Cylinder, (), {"point": (0.0, 0, 0), "axis": (0.0, 0, 1), "radius": 1.0}),
    "hinge": (BEAM.hinge, ("B",), {"axis": (0.0, 0, 1), "at": (1.0, 0, 0), **FREE, **STOPS}),
    "slider": (BEAM.slider, ("B",), {"axis": (0.0, 0, 1), "at": (1.0, 0, 0), **FREE}),
    "cylindrical": (BEAM.cylindrical, ("B",), {"axis": (0.0, 0, 1), "at": (1.0, 0, 0), **FREE}),
    "spherical": (BEAM.spherical, ("B",), {"at": (1.0, 0, 0), "stiffness": 1.0, "damping": 0.1}),
    "universal": (BEAM.universal, ("B",), {"axes": ((0.0, 0, 1), (0.0, 1, 0)), "at": (1.0, 0, 0)}),
    "planar": (BEAM.planar, ("B",), {"normal": (0.0, 0, 1), "at": (1.0, 0, 0)}),
    "velocity": (BEAM.velocity, ("B",), {"v": (0.0, 0, 1), "omega": (0.0, 0, 1)}),
    "rigid_velocity": (BEAM.rigid_velocity, (), {"v": (0.0, 0, 1), "omega": (0.0, 0, 1), "about": (0.0, 0, 1)}),
    "simulate": (dx.simulate, (BEAM,), {"t_end": 0.1, "dt": 0.1, "tolerance": 1e-9}),
    "solve_static": (dx.solve_static, (BEAM,), {"tolerance": 1e-9}),
    "Adaptive": (dx.Adaptive, (), {"tolerance": 0.1, "dt_min": 0.1, "dt_max": 1.0, "first": 0.5, "save_at": 1.0}),
    "ArcLength": (dx.ArcLength, (), {"ds": 0.1, "load_factors": (0.5, 1.0), "load_step": 0.1}),
    "DisplacementControl": (dx.DisplacementControl, ("B", "y"), {"to": 0.1, "load_factors": (0.5, 1.0)}),
    "EnergyDissipating": (dx.EnergyDissipating, (), {"chi_stress": 0.1, "chi_velocity": 0.1}),
    "GeneralizedAlpha": (dx.GeneralizedAlpha, (), {"rho_inf": 0.5}),
    "HilberHughesTaylor": (dx.HilberHughesTaylor, (), {"alpha": 0.1}),
    "Newmark": (dx.Newmark, (), {"beta": 0.25, "gamma": 0.5}),
    "ramp": (dx.ramp, (), {"value": (1.0, 2.0), "t0": 0.0, "t1": 1.0}),
    "harmonic": (dx.harmonic, (), {"value": (1.0, 2.0), "frequency": 1.0, "phase": 0.1, "mean": 0.1}),
    "table": (dx.table, (), {"times": (0.0, 1.0), "values": (0.0, 1.0)}),
}  # fmt: skip
# words for an argument that is not spoken of by its own name
SAID = {
    ("line", "start"): "point 0 of the line", ("line", "end"): "point 1 of the line", ("arc", "start"): "point 0 of",
    ("arc", "through"): "point 1 of", ("arc", "end"): "point 2 of", ("polyline", "points"): "point",
    ("spline", "points"): "point", ("rod", "nodes"): "'P'", ("node", "at"): "place of node 'P'",
    ("ground", "b"): "place =", ("universal", "axes"): "joint 'joint1'", ("planar", "normal"): "axis",
    ("table", "times"): "time of a table", ("table", "values"): "table",
    ("hinge", "stops"): "stop", ("spring", "offset_a"): "offset of its first point",
    ("dashpot", "offset_a"): "offset of its first point", ("offset_b", "offset_b"): "offset of its second point",
}  # fmt: skip


def planted(value: Any, bad: float) -> Iterator[Any]:
    """The value with ``bad`` at each of its numbers in turn."""
    if isinstance(value, float):
        yield bad
        return
    array = np.array(value, float)
    for k in range(array.size):
        if k and array.size > 9 and k % 5:
            continue  # a 6×6 has enough of them
        spoiled = array.copy()
        spoiled.flat[k] = bad
        yield spoiled if isinstance(value, np.ndarray) else as_tuple(spoiled.tolist())


def as_tuple(value: Any) -> Any:
    return tuple(as_tuple(v) for v in value) if isinstance(value, list) else value


@pytest.mark.parametrize("name", CALLS)
def test_what_is_not_finite_is_refused_by_name(name: str) -> None:
    call, fixed, good = CALLS[name]
    for key, value in good.items():
        alone = {k: v for k, v in good.items() if (name, k) != ("actuate", "strain") or key == "strain"}
        for bad in (np.nan, np.inf, -np.inf):
            for spoiled in planted(value, bad):
                with pytest.raises(dx.ModelError) as error:
                    call(*fixed, **{**alone, key: spoiled})
                    pytest.fail(f"{name}({key}={spoiled!r}) gets through")
                said, word = str(error.value), SAID.get((name, key), key)
                assert word in said and error.value.fix, f"{name}: {key} is not in: {said}"


@pytest.mark.parametrize("name", CALLS)
def test_the_numbers_themselves_are_taken(name: str) -> None:
    """Without the planted value the same calls are good, so it was that which was refused."""
    call, fixed, good = CALLS[name]
    call(*fixed, **{k: v for k, v in good.items() if (name, k) != ("actuate", "strain")})
