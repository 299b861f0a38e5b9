"""Time steps. Each is a frozen value that names its rule, what it conserves and what it needs."""

from directrix.integrators.midpoint_family import EnergyMomentum, Integrator, Midpoint

__all__ = ["EnergyMomentum", "Integrator", "Midpoint"]
