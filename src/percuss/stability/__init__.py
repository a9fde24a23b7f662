"""Stability of steady motions: B77's reduced criterion, exact Floquet multipliers, the waveform criterion, verdicts."""

from percuss.stability.plane import ExactPlane, Plane, exact_plane, stability_plane
from percuss.stability.verdict import (
    Reduced,
    Stability,
    TimedStability,
    Waveform,
    floquet_multipliers,
    reduced_criterion,
    stability_of,
    timed_stability,
    waveform_criterion,
)
from percuss.steady.multipliers import CycleMap, LinearMap, Multipliers

__all__ = [
    "CycleMap",
    "ExactPlane",
    "LinearMap",
    "Multipliers",
    "Plane",
    "Reduced",
    "Stability",
    "TimedStability",
    "Waveform",
    "exact_plane",
    "floquet_multipliers",
    "reduced_criterion",
    "stability_of",
    "stability_plane",
    "timed_stability",
    "waveform_criterion",
]
