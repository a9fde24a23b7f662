"""Periodic motions with p impacts in n load periods: searched for, proved possible, linearised."""

from percuss.steady.periodic.periodic_orbit import PeriodicOrbit, parameter_column, time_rates
from percuss.steady.periodic.search import Drop, FoundOrbits, orbit_near, orbits

__all__ = ["Drop", "FoundOrbits", "PeriodicOrbit", "orbit_near", "orbits", "parameter_column", "time_rates"]
