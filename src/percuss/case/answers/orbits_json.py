"""Orbits and their branches as JSON."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from percuss.case.answers.json_values import number as plain_number
from percuss.stability import orbit_multipliers
from percuss.stability.multipliers import NEUTRAL

if TYPE_CHECKING:
    from percuss.explore import Branch, BranchPoint, PointCurve, RestPointCurve
    from percuss.model.checks import ComplexArray
    from percuss.steady import FoundOrbits, PeriodicOrbit

__all__ = ["branch_dict", "curve_dict", "orbit_dict", "orbits_dict", "rest_curve_dict"]


def orbits_dict(found: FoundOrbits) -> dict[str, Any]:
    """What a search found."""
    return {
        "label": found.label,
        "modes": found.modes,
        "orbits": [orbit_dict(orbit, orbit_multipliers(orbit).values) for orbit in found.orbits],
        "complete": found.complete,
        "unseen": found.unseen,
        "halted": found.halted,
        "ended": found.ended,
        "tries": found.tries,
        "sources": {name: tally._asdict() for name, tally in found.sources.items()},
        "resonant_modes": list(found.resonant_modes),
        "dropped": {reason.value: number for reason, number in found.dropped.items()},
    }


def branch_dict(branch: Branch, curves: Sequence[PointCurve] = ()) -> dict[str, Any]:
    """A branch, and all that were switched to from it; and curves of their points over two parameters."""
    others = [other for other in branch.family() if other is not branch]
    return {
        "parameter": branch.parameter,
        "modes": branch.modes,
        **_branch(branch),
        "switched": [_branch(other) for other in others],
        "cascade": [row._asdict() for row in branch.cascade],
        "curves": [curve_dict(curve) for curve in curves],
    }


def curve_dict(curve: PointCurve) -> dict[str, Any]:
    """Points of a branch followed through two parameters."""
    return {
        "type": curve.event.value,
        "label": curve.label,
        "parameters": list(curve.parameters),
        "units": list(curve.units),
        "points": [
            {
                "type": point.kind.value,
                "values": list(point.values),
                "phases": point.orbit.phases.tolist(),
                "speeds": point.orbit.speeds.tolist(),
                "beyond": point.beyond,
            }
            for point in curve.points
        ],
        "curve": {
            "values": curve.values.tolist(),
            "phases": curve.phases.tolist(),
            "is_orbit": curve.is_orbit.tolist(),
            "angles": None if np.isnan(curve.angles).any() else curve.angles.tolist(),
        },
    }


def rest_curve_dict(curve: RestPointCurve) -> dict[str, Any]:
    """A curve of ends of cycles with rest."""
    return {
        "type": curve.event.value,
        "label": curve.label,
        "parameters": list(curve.parameters),
        "units": list(curve.units),
        "points": [
            {"type": point.kind.value, "values": list(point.values), "beyond": point.beyond} for point in curve.points
        ],
        "curve": {
            "values": curve.values.tolist(),
            "release_phases": curve.release_phases.tolist(),
            "event_phases": [plain_number(phase) for phase in curve.event_phases.tolist()],
            "is_orbit": curve.is_orbit.tolist(),
        },
    }


def _branch(branch: Branch) -> dict[str, Any]:
    return {
        "label": branch.label,
        "points": [_point(point) for point in branch.points],
        "branch": {
            "value": branch.values.tolist(),
            "phases": branch.phases.tolist(),
            "times": branch.times.tolist(),
            "speeds": branch.speeds.tolist(),
            "stable": branch.stable.tolist(),
        },
    }


def _point(point: BranchPoint) -> dict[str, Any]:
    return {
        "type": point.kind.value,
        "value": point.value,
        "orbit": orbit_dict(point.orbit, point.multipliers),
        "beyond": point.beyond,
        "impact": point.impact,
        "touch_phase": point.touch_phase,
    }


def orbit_dict(orbit: PeriodicOrbit, multipliers: ComplexArray | None) -> dict[str, Any]:
    """An orbit; its multipliers are null where they grow without bound."""
    impacts = zip(orbit.phases.tolist(), orbit.speeds.tolist(), strict=True)
    values = None if multipliers is None else multipliers.tolist()
    return {
        "label": orbit.label,
        "impacts": [{"phase": phase, "speed": speed} for phase, speed in impacts],
        "flight_times": orbit.flight_times.tolist(),
        "multipliers": [[value.real, value.imag] for value in multipliers.tolist()]
        if multipliers is not None
        else None,
        "stable": None if values is None else max(abs(value) for value in values) < 1.0 - NEUTRAL,
        "admissible": orbit.admissible,
        "reason": orbit.obstacle.value if orbit.obstacle is not None else None,
    }
