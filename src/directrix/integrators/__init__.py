"""Time steps. Each is a frozen value that names its rule, what it conserves and what it needs."""

from collections.abc import Callable

from directrix.integrators.alpha_family import Alpha, GeneralizedAlpha, HilberHughesTaylor, Newmark
from directrix.integrators.midpoint_family import EnergyDissipating, EnergyMomentum, Midpoint
from directrix.integrators.protocol import Formulation, Integrator
from directrix.integrators.simo_tarnow_doblare import SimoTarnowDoblare

BY_NAME: dict[str, Callable[..., Integrator]] = {
    "energy-momentum": EnergyMomentum,
    "midpoint": Midpoint,
    "energy-dissipating": EnergyDissipating,
    "generalized-alpha": GeneralizedAlpha,
    "hilber-hughes-taylor": HilberHughesTaylor,
    "newmark": Newmark,
    "simo-tarnow-doblare": SimoTarnowDoblare,
}
"""Their names in case files; the parameters are the constructors' own."""

__all__ = [
    "BY_NAME",
    "Alpha",
    "EnergyDissipating",
    "EnergyMomentum",
    "Formulation",
    "GeneralizedAlpha",
    "HilberHughesTaylor",
    "Integrator",
    "Midpoint",
    "Newmark",
    "SimoTarnowDoblare",
]
