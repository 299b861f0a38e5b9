"""Kinematic formulations: how strains follow from nodal unknowns."""

from directrix.formulations.directors import Directors

__all__ = ["Directors"]
