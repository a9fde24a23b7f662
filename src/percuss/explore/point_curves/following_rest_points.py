"""Ends of cycles with rest followed through two parameters: onsets, touches, deaths, the last release."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from percuss.errors import Interrupted, ParameterError, PercussError
from percuss.explore.continuation.next_point import Strayed
from percuss.explore.continuation.rest_branch import RestBranchPoint
from percuss.explore.family import Family
from percuss.explore.point_curves.kinds import CurveEvent
from percuss.explore.point_curves.line_roots import root_on_line
from percuss.explore.point_curves.onsets import Held
from percuss.explore.point_curves.plane_walk import PlaneWalk
from percuss.explore.point_curves.ranges import Ranges, units_of
from percuss.explore.point_curves.rest_point_curve import RestCurvePoint, RestPointCurve
from percuss.explore.point_curves.rest_start import rest_condition
from percuss.explore.point_curves.rest_walk import RestPlane, RestWalk
from percuss.explore.point_curves.rest_way import TURN
from percuss.halting import halting
from percuss.model.checks import Array

__all__ = ["followed_rest_point"]

_SAME, _BESIDE = 1e-6, 1e-2  # of a unit, by which the start may be off, and where the bar is held before


def followed_rest_point(
    point: RestBranchPoint,
    family: Family,
    names: tuple[str, str],
    here: tuple[float, float],
    bounds: Ranges,
    most: int,
    halt: Callable[[], bool] | None,
) -> RestPointCurve:
    """Follow the end of a branch of cycles with rest through two parameters, both ways; see `follow_point`."""
    units = np.array(units_of(bounds, here))
    condition, side = rest_condition(point)
    plane = RestPlane(family, names, units, condition)
    box = np.array(bounds).T / units
    start, slopes = _start(plane, point, np.array(here) / units, box)
    steep = float(np.linalg.norm(slopes))
    left = np.array([slopes[1], -slopes[0]]) / steep  # the number grows to the left of this direction
    condition, parts = plane.condition, []
    for way, slope in ((left, steep), (-left, -steep)):
        walk = PlaneWalk(replace(plane, condition=condition), start, way, slope, box)
        with halting(halt):
            parts.append(RestWalk(point.cycle, walk, math.copysign(side, slope * side)).walked(most))
        if walk.end is CurveEvent.CLOSED:
            break
    return _told(point, plane, parts)


def _start(plane: RestPlane, point: RestBranchPoint, here: Array, box: Array) -> tuple[Array, Array]:
    """The point of the curve, and the derivatives of the number there."""
    try:
        reach = _BESIDE if isinstance(plane.condition, Held) else _SAME
        for _ in range(2):
            slopes = plane.slopes(here, box)
            axis = np.zeros(2)
            inside = np.abs(slopes) * np.where((here == box[0]) | (here == box[1]), 1e-9, 1.0)
            axis[int(np.argmax(inside))] = 1.0  # not off the edge of the plane
            here, _ = root_on_line(plane.number, here, axis, float(slopes @ axis) or math.inf, reach)
            plane.arrived(here)
    except Interrupted:
        raise
    except (Strayed, PercussError) as error:
        told = ", ".join(f"{name} = {value:.9g}" for name, value in zip(plane.names, plane.values(here), strict=True))
        raise ParameterError("point", str(point), f"a point of the systems with {told}", str(error)) from None
    return here, slopes


def _told(point: RestBranchPoint, plane: RestPlane, parts: list[RestWalk]) -> RestPointCurve:
    """The curve of one walk that closes, or of two from one place, the second of them backward."""
    passed, happened = list(parts[0].passed), list(parts[0].happened)
    if len(parts) > 1:
        passed = [*parts[1].passed[:0:-1], *passed]
        happened = [*parts[1].happened[::-1], *happened]
    else:
        happened.insert(0, happened[-1])
    known = getattr(plane.family, "units", {})
    return RestPointCurve(
        point.kind,
        point.cycle.label,
        point.cycle.modes,
        plane.names,
        values=np.array([plane.values(one.place) for one in passed]),
        release_phases=np.mod([one.release for one in passed], TURN),
        event_phases=np.mod([one.time for one in passed], TURN),
        is_orbit=np.array([one.is_cycle for one in passed], dtype=bool),
        units=(known.get(plane.names[0], ""), known.get(plane.names[1], "")),
        points=tuple(RestCurvePoint(one.kind, plane.values(one.place), one.beyond) for one in happened),
    )
