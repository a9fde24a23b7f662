"""Numbers that vanish at points of codimension two: smooth along a curve of folds, flips, grazings, corners, pairs."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TypeAlias

import numpy as np

from percuss.explore.continuation.indicators import indicator
from percuss.explore.continuation.solution_curve import turning, twice
from percuss.explore.point_curves.conditions import Condition, Corner, Death, Touch, curvature
from percuss.explore.point_curves.extended_curve import ExtendedCurve, ExtendedPoint
from percuss.explore.point_curves.kinds import CurveEvent
from percuss.explore.point_curves.multiplier_conditions import Multiplier, Pair
from percuss.explore.point_curves.quick_motion import QuickMotion
from percuss.model.checks import Array
from percuss.model.load import Side
from percuss.steady import PeriodicOrbit

__all__ = ["Tests", "tests_of"]

Tests: TypeAlias = list[tuple[CurveEvent, Callable[[ExtendedPoint], float]]]
"""Kinds of points, and of each the number that vanishes there."""

_APART = 1e-4  # of ξ from 1 or −1, for the derivative of g
_FAR = 1e4  # ξ at which the multipliers that are finite count no more
_ASIDE, _SHARE = 1e-3, 0.05  # rad, along the doubled branch, and of its shortest flight


def tests_of(curve: ExtendedCurve, first: ExtendedPoint) -> Tests:
    """What is looked at between a point of a curve and the next one.

    Parameters
    ----------
    curve
        The curve.
    first
        The point.
    """
    condition = curve.condition

    def of_orbit(number: Callable[[PeriodicOrbit, Array], float]) -> Callable[[ExtendedPoint], float]:
        return lambda point: number(curve.motion(point.x), curve.extra(point.x))

    fold = CurveEvent.WITH_FOLD, of_orbit(lambda orbit, _: indicator(orbit, 1.0))
    flip = CurveEvent.WITH_FLIP, of_orbit(lambda orbit, _: indicator(orbit, -1.0))
    if isinstance(condition, Multiplier) and condition.xi > 0.0:
        p = curve.impacts
        before = first.tangent[p + 1 : p + 3]
        cusp = CurveEvent.CUSP, lambda point: float(point.tangent[p + 1 : p + 3] @ before)
        return [flip, cusp, (CurveEvent.RESONANCE_1, of_orbit(lambda orbit, _: double(orbit, condition)))]
    if isinstance(condition, Multiplier):
        bent = CurveEvent.GENERALIZED_FLIP, of_orbit(lambda orbit, _: bend_of_the_doubled(orbit, condition))
        return [fold, bent, (CurveEvent.RESONANCE_2, of_orbit(lambda orbit, _: double(orbit, condition)))]
    if isinstance(condition, Pair):
        turns = (
            (CurveEvent.RESONANCE_1, 0), (CurveEvent.RESONANCE_4, 90),
            (CurveEvent.RESONANCE_3, 120), (CurveEvent.RESONANCE_2, 180),
        )  # fmt: skip
        others = (
            (CurveEvent.WITH_FOLD, of_orbit(lambda orbit, extra: indicator(orbit, 1.0) * (1.0 - extra[0]))),
            (CurveEvent.WITH_FLIP, of_orbit(lambda orbit, extra: indicator(orbit, -1.0) * (1.0 + extra[0]))),
        )  # without the pair itself, where that comes to 1 or −1
        return [*others, *((kind, of_orbit(_turn(degrees))) for kind, degrees in turns)]
    if isinstance(condition, Corner):
        sides: tuple[Side, Side] = ("left", "right")
        return [
            (kind, of_orbit(lambda orbit, _, xi=xi, side=side: indicator_on(orbit, xi, side)))  # type: ignore[misc]
            for kind, xi in ((CurveEvent.WITH_FOLD, 1.0), (CurveEvent.WITH_FLIP, -1.0))
            for side in sides
        ]
    flat = CurveEvent.FLAT_GRAZING, of_orbit(lambda orbit, extra: curvature(orbit, condition, extra))
    return [fold, flip, flat, *_resonant(condition, of_orbit)]


def _turn(degrees: int) -> Callable[[PeriodicOrbit, Array], float]:
    cosine = round(math.cos(math.radians(degrees)), 12)
    return lambda _, extra: float(extra[0]) - cosine


def _resonant(condition: Condition, of_orbit: Callable[..., Callable[[ExtendedPoint], float]]) -> Tests:
    def number(orbit: PeriodicOrbit, extra: Array) -> float:
        if isinstance(condition, Death):
            return growing(orbit)
        assert isinstance(condition, Touch)
        number = condition.flight + 1
        times = np.insert(np.array(orbit.times), number, orbit.times[condition.flight] + extra[0])
        wide = PeriodicOrbit(orbit.system, orbit.periods, tuple(times.tolist()), orbit.modes, orbit.rigid_rebounds[0])
        alone = orbit.modes + orbit.system.body.is_free == 1
        return growing(wide) if alone else 1.0  # where several modes move no impact begins at a touch

    return [(CurveEvent.RESONANT_GRAZING, of_orbit(number))]


def indicator_on(orbit: PeriodicOrbit, xi: float, side: Side) -> float:
    """`indicator` with the load on one side of a step."""
    matrix = orbit.bordered(xi, side).real
    return float(np.linalg.det(matrix / np.linalg.norm(matrix, axis=1, keepdims=True)))


def double(orbit: PeriodicOrbit, condition: Multiplier) -> float:
    """dg/dξ at the multiplier: 0 where it is a double one."""
    ahead, behind = (condition.at(orbit, condition.xi * (1.0 + h)).real for h in (_APART, -_APART))
    return (ahead - behind) / (2.0 * _APART)


def growing(orbit: PeriodicOrbit) -> float:
    """What the greatest multiplier times the speed of an impact tends to as that goes to 0.

    det(ξ − W) times the speeds is a polynomial of degree 2N + 2 in ξ; where an impact has no speed its first
    coefficient vanishes, and the second is this number, up to a factor that does not change its sign.
    """

    def scaled(xi: float) -> float:
        rest = float(np.prod(orbit.modal_determinants(xi).real / xi**2))
        return float(np.linalg.det(orbit.bordered(xi).real)) / xi * rest

    return 0.5 * (scaled(_FAR) + scaled(-_FAR))


def bend_of_the_doubled(orbit: PeriodicOrbit, condition: Multiplier) -> float:
    """The coefficient of the third order of the doubled orbit: its sign is the side towards which that begins.

    With G the equations of the cycle told as one of twice the period, G_x q = 0 and w G_x = 0, it is
    w·(G_xxx q³/6 + G_xx q h), G_x h = −G_xx q²/2 (Kuznetsov, Elements of Applied Bifurcation Theory, 2004, § 5.4).
    """
    p, aside = orbit.impacts, min(_ASIDE, _SHARE * float(orbit.flight_times.min()))
    here = twice(np.array([*orbit.times, orbit.rigid_rebounds[0]]), p, orbit.periods)

    def matrix(x: Array) -> Array:
        wide = QuickMotion(orbit.system, 2 * orbit.periods, tuple(x[:-1].tolist()), orbit.modes, float(x[-1]))
        found = np.array(wide.bordered().real)
        found[:, 0] -= turning(wide) * found[:, -1]
        return found

    left, sizes, right = np.linalg.svd(matrix(here))
    way, row = right[-1], left[:, -1]
    way = way if way[:p] @ condition.border[1][:p] > 0.0 else -way
    row = row if row[:p] @ condition.border[0][:p] > 0.0 else -row

    def cubic(size: float) -> float:
        second = (matrix(here + size * way) - matrix(here - size * way)) @ way / (2.0 * size)
        inner = -0.5 * (right[:-1].T @ ((left[:, :-1].T @ second) / sizes[:-1]))
        slopes = (
            row @ matrix(here + side * way + side**2 * inner) @ (way + 2.0 * side * inner) for side in (size, -size)
        )
        return float(sum(slopes)) / (6.0 * size**2)

    return (4.0 * cubic(0.5 * aside) - cubic(aside)) / 3.0
