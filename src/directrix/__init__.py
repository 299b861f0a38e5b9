"""directrix: geometrically exact rods and frames that conserve, and prove it on every run."""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from directrix import generate, laws
    from directrix.blades import beamdyn
    from directrix.branching import branches
    from directrix.chains import catenary
    from directrix.contacts import Cylinder, Plane, Sphere
    from directrix.continuation import continuation
    from directrix.controls import ArcLength, DisplacementControl, Snapshot
    from directrix.curves import arc, helix, line, polyline, spline, twisted
    from directrix.dynamics import simulate
    from directrix.ensembles import Ensemble, ensemble
    from directrix.errors import ConvergenceError, DirectrixError, InputError, ModelError
    from directrix.form_finding import form_find
    from directrix.formulations import CrisfieldJelenic, Directors, SimoVuQuoc
    from directrix.functions import harmonic, ramp, table
    from directrix.geometry import centreline, from_dxf, from_graph, from_mesh
    from directrix.integrators import (
        EnergyDissipating,
        EnergyMomentum,
        GeneralizedAlpha,
        HilberHughesTaylor,
        Midpoint,
        Newmark,
        SimoTarnowDoblare,
    )
    from directrix.keeping import Folder
    from directrix.linear.petsc import Petsc
    from directrix.model import Model
    from directrix.parts import Keep
    from directrix.points import Recorder
    from directrix.refinement import Refined, refine
    from directrix.result import Result, Status, TurningPoint
    from directrix.section import Section
    from directrix.stability import BucklingLoads, Modes, buckling, modes
    from directrix.statics import solve_static
    from directrix.stepping import Adaptive
    from directrix.storage import load
    from directrix.tapered import taper
    from directrix.viewer import view

__version__ = "0.1.0"

__all__ = [
    "Adaptive",
    "ArcLength",
    "BucklingLoads",
    "ConvergenceError",
    "CrisfieldJelenic",
    "Cylinder",
    "Directors",
    "DirectrixError",
    "DisplacementControl",
    "EnergyDissipating",
    "EnergyMomentum",
    "Ensemble",
    "Folder",
    "GeneralizedAlpha",
    "HilberHughesTaylor",
    "InputError",
    "Keep",
    "Midpoint",
    "Model",
    "ModelError",
    "Modes",
    "Newmark",
    "Petsc",
    "Plane",
    "Recorder",
    "Refined",
    "Result",
    "Section",
    "SimoTarnowDoblare",
    "SimoVuQuoc",
    "Snapshot",
    "Sphere",
    "Status",
    "TurningPoint",
    "arc",
    "beamdyn",
    "branches",
    "buckling",
    "catenary",
    "centreline",
    "continuation",
    "ensemble",
    "form_find",
    "from_dxf",
    "from_graph",
    "from_mesh",
    "generate",
    "harmonic",
    "helix",
    "laws",
    "line",
    "load",
    "modes",
    "polyline",
    "ramp",
    "refine",
    "simulate",
    "solve_static",
    "spline",
    "table",
    "taper",
    "twisted",
    "view",
]

# Looked up when used: the command line answers --help without loading a compiler.
_HOME = {
    "blades": ("beamdyn",),
    "branching": ("branches",),
    "chains": ("catenary",),
    "continuation": ("continuation",),
    "contacts": ("Cylinder", "Plane", "Sphere"),
    "controls": ("ArcLength", "DisplacementControl", "Snapshot"),
    "curves": ("arc", "helix", "line", "polyline", "spline", "twisted"),
    "dynamics": ("simulate",),
    "ensembles": ("Ensemble", "ensemble"),
    "errors": ("ConvergenceError", "DirectrixError", "InputError", "ModelError"),
    "form_finding": ("form_find",),
    "formulations": ("CrisfieldJelenic", "Directors", "SimoVuQuoc"),
    "geometry": ("centreline", "from_dxf", "from_graph", "from_mesh"),
    "functions": ("harmonic", "ramp", "table"),
    "integrators": (
        "EnergyDissipating",
        "EnergyMomentum",
        "GeneralizedAlpha",
        "HilberHughesTaylor",
        "Midpoint",
        "Newmark",
        "SimoTarnowDoblare",
    ),
    "keeping": ("Folder",),
    "linear.petsc": ("Petsc",),
    "model": ("Model",),
    "parts": ("Keep",),
    "points": ("Recorder",),
    "refinement": ("Refined", "refine"),
    "result": ("Result", "Status", "TurningPoint"),
    "section": ("Section",),
    "stability": ("BucklingLoads", "Modes", "buckling", "modes"),
    "statics": ("solve_static",),
    "stepping": ("Adaptive",),
    "storage": ("load",),
    "tapered": ("taper",),
    "viewer": ("view",),
}


def __getattr__(name: str) -> object:
    if name in ("generate", "laws"):
        return import_module(f"directrix.{name}")
    for module, names in _HOME.items():
        if name in names:
            value = globals()[name] = getattr(import_module(f"directrix.{module}"), name)
            return value
    raise AttributeError(f"module 'directrix' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted({*__all__, *globals()})
