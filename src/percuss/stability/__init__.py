"""Stability of steady motions: B77's reduced criterion, exact Floquet multipliers, the waveform criterion, verdicts."""

from percuss.stability.multipliers import LinearMap, Multipliers, floquet_multipliers, linear_map
from percuss.stability.orbit_multipliers import OrbitMultipliers, characteristic, orbit_map, orbit_multipliers
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
