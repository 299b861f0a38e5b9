"""directrix: geometrically exact rods and frames that conserve, and prove it on every run."""

from directrix.curves import arc, helix, line, polyline, spline
from directrix.dynamics import simulate
from directrix.errors import ConvergenceError, DirectrixError, InputError, ModelError
from directrix.formulations import Directors
from directrix.integrators import EnergyMomentum, Midpoint
from directrix.model import Model
from directrix.result import Result, Status
from directrix.section import Section
from directrix.statics import solve_static
from directrix.storage import load

__version__ = "0.1.0"

__all__ = [
    "ConvergenceError",
    "Directors",
    "DirectrixError",
    "EnergyMomentum",
    "InputError",
    "Midpoint",
    "Model",
    "ModelError",
    "Result",
    "Section",
    "Status",
    "arc",
    "helix",
    "line",
    "load",
    "polyline",
    "simulate",
    "solve_static",
    "spline",
]
