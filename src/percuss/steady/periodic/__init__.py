"""Periodic motions with p impacts in n load periods: searched for, proved possible, linearised.

The names are imported when first used: a verdict on one orbit loads nothing of the search.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from percuss.lazy_names import lazy_names

if TYPE_CHECKING:
    from percuss.steady.periodic.found_orbits import Drop, FoundOrbits
    from percuss.steady.periodic.periodic_orbit import PeriodicOrbit, parameter_column, time_rates
    from percuss.steady.periodic.search import orbit_near, orbits

__all__, __getattr__, __dir__ = lazy_names(__name__, __file__)
