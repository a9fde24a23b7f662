"""Stability of steady motions: B77's reduced criterion, exact Floquet multipliers, the waveform criterion, verdicts.

The names are imported when first used: a verdict loads nothing of the planes.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from percuss.lazy_names import lazy_names

if TYPE_CHECKING:
    from percuss.stability.cycle_multipliers import OrbitMultipliers, characteristic, orbit_map, orbit_multipliers
    from percuss.stability.multipliers import LinearMap, Multipliers, floquet_multipliers, linear_map
    from percuss.stability.plane import ExactPlane, Plane, exact_plane, stability_plane
    from percuss.stability.verdict import (
        Reduced,
        Stability,
        TimedStability,
        Waveform,
        reduced_criterion,
        stability_of,
        timed_stability,
        waveform_criterion,
    )

__all__, __getattr__, __dir__ = lazy_names(__name__, __file__)
