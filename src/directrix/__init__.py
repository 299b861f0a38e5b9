"""directrix: geometrically exact rods and frames that conserve, and prove it on every run."""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from directrix import laws
    from directrix.branching import branches
    from directrix.contacts import Cylinder, Plane, Sphere
    from directrix.continuation import continuation
    from directrix.controls import ArcLength, DisplacementControl, Snapshot
    from directrix.curves import arc, helix, line, polyline, spline
    from directrix.dynamics import simulate
    from directrix.ensembles import Ensemble, ensemble
    from directrix.errors import ConvergenceError, DirectrixError, InputError, ModelError
    from directrix.form_finding import form_find
    from directrix.formulations import CrisfieldJelenic, Directors, SimoVuQuoc
    from directrix.functions import harmonic, ramp, table
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
    from directrix.result import Result, Status, TurningPoint
    from directrix.section import Section
    from directrix.stability import BucklingLoads, Modes, buckling, modes
    from directrix.statics import solve_static
    from directrix.storage import load

__version__ = "0.1.0"

__all__ = [
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
    "Result",
    "Section",
    "SimoTarnowDoblare",
    "SimoVuQuoc",
    "Snapshot",
    "Sphere",
    "Status",
    "TurningPoint",
    "arc",
    "branches",
    "buckling",
    "continuation",
    "ensemble",
    "form_find",
    "harmonic",
    "helix",
    "laws",
    "line",
    "load",
    "modes",
    "polyline",
    "ramp",
    "simulate",
    "solve_static",
    "spline",
    "table",
]

# Looked up when used: the command line answers --help without loading a compiler.
_HOME = {
    "branching": ("branches",),
    "continuation": ("continuation",),
    "contacts": ("Cylinder", "Plane", "Sphere"),
    "controls": ("ArcLength", "DisplacementControl", "Snapshot"),
    "curves": ("arc", "helix", "line", "polyline", "spline"),
    "dynamics": ("simulate",),
    "ensembles": ("Ensemble", "ensemble"),
    "errors": ("ConvergenceError", "DirectrixError", "InputError", "ModelError"),
    "form_finding": ("form_find",),
    "formulations": ("CrisfieldJelenic", "Directors", "SimoVuQuoc"),
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
    "result": ("Result", "Status", "TurningPoint"),
    "section": ("Section",),
    "stability": ("BucklingLoads", "Modes", "buckling", "modes"),
    "statics": ("solve_static",),
    "storage": ("load",),
}


def __getattr__(name: str) -> object:
    if name == "laws":
        return import_module("directrix.laws")
    for module, names in _HOME.items():
        if name in names:
            value = globals()[name] = getattr(import_module(f"directrix.{module}"), name)
            return value
    raise AttributeError(f"module 'directrix' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted({*__all__, *globals()})
