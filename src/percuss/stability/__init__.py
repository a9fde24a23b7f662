"""Stability of steady motions: B77's reduced criterion, exact Floquet multipliers, the waveform criterion, verdicts."""

from percuss.stability.exact_plane import ExactPlane, exact_plane
from percuss.stability.linear_map import LinearMap, linear_map
from percuss.stability.multipliers import Multipliers, floquet_multipliers
from percuss.stability.orbit_multipliers import OrbitMultipliers, characteristic, orbit_map, orbit_multipliers
from percuss.stability.plane import Plane, stability_plane
from percuss.stability.reduced import Reduced, reduced_criterion
from percuss.stability.timed_verdict import TimedStability, timed_stability
from percuss.stability.verdict import Stability, stability_of
from percuss.stability.waveform import Waveform, waveform_criterion

__all__ = [
    "ExactPlane",
    "LinearMap",
    "Multipliers",
    "OrbitMultipliers",
    "Plane",
    "Reduced",
    "Stability",
    "TimedStability",
    "Waveform",
    "characteristic",
    "exact_plane",
    "floquet_multipliers",
    "linear_map",
    "orbit_map",
    "orbit_multipliers",
    "reduced_criterion",
    "stability_of",
    "stability_plane",
    "timed_stability",
    "waveform_criterion",
]
