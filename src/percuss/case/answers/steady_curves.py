"""The curves behind a steady answer: v_f and the load over one period, and the branches over the load factor."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from percuss.case.answers.json_values import number, numbers
from percuss.stability import exact_plane, stability_plane, waveform_criterion
from percuss.stability.waveform import waveform_bounds
from percuss.steady import steady_states

if TYPE_CHECKING:
    from percuss.case.case import Case
    from percuss.explore import Boundaries
    from percuss.model import System

__all__ = ["boundaries_dict", "curves_dict"]


def curves_dict(
    case: Case,
    periods: int = 1,
    points: int = 721,
    branches: int = 200,
    load_factor: Sequence[float] | None = None,
    modes: int = 32,
) -> dict[str, Any]:
    """v_f with its level, the load history with the window of the waveform criterion, and all branches.

    Parameters
    ----------
    points
        Of the curves over the load phase, from 0 to 2π.
    branches, load_factor
        Number and range of the load factors of the branches; by default from near 0 to beyond the last fold.
    modes
        Elastic modes of the exact multipliers along the branches.

    Raises
    ------
    LoadError, ResonanceError, ParameterError, CaseError
        As `steady_answer`, and for an empty range.

    Examples
    --------
    >>> from percuss.case import load_case
    >>> found = curves_dict(load_case("mini-breaker"), points=5, branches=3)
    >>> len(found["phase"]), len(found["branches"]["phase"])
    (5, 2)
    """
    system = case.system()
    states = steady_states(system, periods)
    phase = np.linspace(0.0, 2.0 * math.pi, points)
    load = system.load
    right = load.value(phase, "right")
    return {
        "m": int(states.periods),
        "phase": numbers(phase),
        "rigid_velocity": numbers(states.rigid_velocity(phase)),
        "load": numbers(load.value(phase, "left")),
        "load_right": numbers(right),
        "force_N": numbers(system.force_scale * right) if system.is_si else None,
        "level": number(states.level),
        "level_max": number(states.level_max),
        "waveform": _waveform(system, states.orbits),
        "branches": _branches(system, periods, branches, load_factor, modes, states.level_max, states.level),
    }


def _waveform(system: System, orbits: Sequence[Any]) -> dict[str, Any]:
    found = [waveform_criterion(orbit) for orbit in orbits]
    lower, upper = waveform_bounds(system.contact)
    return {
        "lower": number(lower),
        "upper": number(upper),
        "mean": number(system.load.mean),
        "orbits": [
            {
                "phase": number(orbit.phase),
                "ratio": number(one.ratio),
                "force": number(one.force),
                "stable": bool(one.stable),
            }
            for orbit, one in zip(orbits, found, strict=True)
        ],
    }


def _branches(
    system: System,
    periods: int,
    count: int,
    load_factor: Sequence[float] | None,
    modes: int,
    level_max: float,
    level: float,
) -> dict[str, Any]:
    now = system.load.load_factor
    if load_factor is None:
        # the level is proportional to the mean load; with R = 1 and no damping it is 0, and there is no last fold
        highest = now * level_max / level if level > 0.0 else now
        low, high = 0.01 * highest, max(1.1 * highest, min(1.1 * now, 3.0 * highest))
    else:
        low, high = load_factor
    values = np.linspace(low, high, count)
    plane = stability_plane(system, system.restitution, values, periods)
    exact = exact_plane(system, system.restitution, values, periods, modes, plane=plane)
    there = [row for row in range(plane.phase.shape[0]) if np.isfinite(plane.phase[row]).any()]
    return {
        "load_factor": numbers(values),
        "restitution": number(system.restitution),
        "now": number(now),
        "phase": [numbers(plane.phase[row]) for row in there],
        "reduced_stable": [plane.stable[row].tolist() for row in there],
        "stable": [exact.stable[row].tolist() for row in there],
        "margin": [numbers(exact.margin[row]) for row in there],
    }


def boundaries_dict(found: Boundaries) -> dict[str, Any]:
    """Boundaries in plain values; null where a curve has no point."""
    return {
        "x_name": found.x_name,
        "y_name": found.y_name,
        "x": numbers(found.x),
        "curves": [
            {
                "kind": curve.kind,
                "branch": int(curve.branch),
                "x": numbers(curve.x),
                "y": numbers(curve.y),
                "phase": numbers(curve.phase),
            }
            for curve in found.real
        ],
        "failed": [[number(value), why] for value, why in found.failed],
    }
