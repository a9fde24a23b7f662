"""Where a multiplier of a motion on a branch, of the reduced or of the exact map, passes the unit circle."""

from __future__ import annotations

import cmath
import itertools
import math
from collections.abc import Callable
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from percuss.explore.boundary_curves.lines import EXACT_SAMPLES, Stretch, orbit_on
from percuss.explore.boundary_curves.roots import Function, bracketed_roots, roots_on
from percuss.model.checks import Array
from percuss.stability.linear_map import LinearMap, linear_map

__all__ = ["FLIP", "SPIRAL", "Crossing", "exact_crossings", "reduced_crossings"]

FLIP, SPIRAL = "flip", "neimark-sacker"

_REAL = 1e-4  # angles this close to 0 or π belong to a fold or a flip, which are found by themselves
_SLOPE = 1e-6  # half the step in t of the slopes that turn a residual into an error of y
_INSIDE = 1e-7  # the ends of a stretch are folds: the samples stay this far inside
_OUTSIDE = 1e-7  # multipliers this little outside the circle are those that cross it
_DEPTH = 6  # halvings of a step in which several multipliers cross


class Crossing(NamedTuple):
    """One crossing on a branch, found to `residual`, an estimate of the error of y.

    `speed`: striking speed of the motion there, dimensionless.
    `outside`: how many other multipliers are outside the unit circle there, so that 0 is an end of stability.
    """

    kind: str
    y: float
    phase: float
    residual: float
    angle: float = math.nan
    outside: float = math.nan
    speed: float = math.nan


def _found(stretch: Stretch, kind: str, f: Function, places: Array) -> list[Crossing]:
    """The crossings at roots of f, with the step that Newton's method would still make in y as their residual."""
    found = []
    for t in places.tolist():
        low, high = max(t - _SLOPE, 0.0), min(t + _SLOPE, 1.0)
        values, ys = f(np.array([low, t, high])), stretch.place(np.array([low, high]))[0]
        rise = float(values[2] - values[0])
        residual = abs(float(values[1]) / rise * float(ys[1] - ys[0])) if rise else math.nan
        y, phase = stretch.place(np.array([t]))
        angle = math.pi if kind == FLIP else math.nan
        found.append(Crossing(kind, float(y[0]), float(phase[0]), residual, angle))
    return found


# -- B77's reduced criterion --


def reduced_crossings(stretch: Stretch, samples: int | None, spirals: bool = True) -> list[Crossing]:
    """Flips, where −1 is a root of B77's quadratic, and spirals, where a pair of its roots is on the circle."""
    nodes = stretch.nodes(samples, _INSIDE)

    def flip(t: Array) -> Array:
        a_0, a_1, a_2 = stretch.quadratic(t)
        return np.asarray((a_0 - a_1 + a_2) / (np.abs(a_0) + np.abs(a_1) + np.abs(a_2)))

    def spiral(t: Array) -> Array:
        a_0, _, a_2 = stretch.quadratic(t)
        return np.asarray((a_2 - a_0) / (np.abs(a_0) + np.abs(a_2)))

    turns = roots_on(flip, nodes)
    found = []
    for crossing, t in zip(_found(stretch, FLIP, flip, turns), turns, strict=True):
        a_0, _, a_2 = (float(a[0]) for a in stretch.quadratic(np.array([t])))
        found.append(crossing._replace(outside=float(abs(a_0) > (1.0 + _OUTSIDE) * abs(a_2))))
    places = roots_on(spiral, nodes) if spirals else np.empty(0)
    for crossing, t in zip(_found(stretch, SPIRAL, spiral, places), places, strict=True):
        a_0, a_1, a_2 = (float(a[0]) for a in stretch.quadratic(np.array([t])))
        if abs(a_1) < (1.0 - _REAL) * abs(a_0 + a_2):
            found.append(crossing._replace(angle=math.acos(-a_1 / (a_0 + a_2)), outside=0.0))
    return found


# -- the exact map --


def exact_crossings(
    stretch: Stretch,
    samples: int | None,
    modes: int,
    spirals: bool = True,
    told: Callable[[float], None] | None = None,
) -> list[Crossing]:
    """Flips and spirals of the map of modes 0 … `modes`: roots of its secular function at −1 and at exp(iθ).

    `told` is called with the share of the samples that is done, 0 to 1.
    """
    nodes = stretch.nodes(samples, _INSIDE, EXACT_SAMPLES)
    steps = itertools.count(1)

    @lru_cache(maxsize=4096)
    def made(t: float) -> LinearMap:
        if told is not None:
            told(min(next(steps) / nodes.size, 1.0) * (0.5 if spirals else 1.0))
        orbit, side = orbit_on(stretch, t)
        return linear_map(orbit, modes, side)

    def matrix(t: float) -> LinearMap:
        stretch.line.go_on()  # its multipliers are solved for again each time
        return made(t)

    def flip(t: Array) -> Array:
        # times the striking speed: where it vanishes the secular function has a pole, which would hide a root beside it
        maps = [matrix(value) for value in t.tolist()]
        return np.array([one.speed * secular(one, -1.0).real for one in maps])

    turns = roots_on(flip, nodes)
    found = [
        crossing._replace(outside=_outside(matrix(float(t))))
        for crossing, t in zip(_found(stretch, FLIP, flip, turns), turns, strict=True)
    ]
    for i in range(nodes.size - 1 if spirals else 0):
        found += _spirals(stretch, matrix, nodes[i], nodes[i + 1], _DEPTH)
        if told is not None:
            told(0.5 + 0.5 * (i + 1) / (nodes.size - 1))
    return found


def secular(matrix: LinearMap, multiplier: complex) -> complex:
    """det(M − μ)/det(DΦ − μ) = 1 + Σ r_j/(μ − ξ_j)."""
    poles, residues = matrix.partial_fractions()
    off = multiplier - poles
    return complex(1.0 + np.sum(residues / np.where(off == 0.0, 1e-300, off)))


def _moduli(matrix: LinearMap) -> tuple[Array, Array]:
    """Moduli of all multipliers, largest first, and their angles."""
    values = np.linalg.eigvals(matrix.dense())
    order = np.argsort(-np.abs(values))
    return np.abs(values)[order], np.abs(np.angle(values[order]))


def _outside(matrix: LinearMap) -> float:
    """How many multipliers are outside the circle; those on it, to within rounding, are not."""
    return float(np.count_nonzero(_moduli(matrix)[0] > 1.0 + _OUTSIDE))


def _spirals(
    stretch: Stretch, matrix: Callable[[float], LinearMap], low: float, high: float, depth: int
) -> list[Crossing]:
    """Pairs of multipliers that cross the circle between two places, one pair after the other."""
    outside = [int(np.count_nonzero(_moduli(matrix(t))[0] > 1.0)) for t in (low, high)]
    most = max(outside)
    if outside[0] == outside[1]:
        return []
    if abs(outside[0] - outside[1]) > 2 and depth:
        middle = 0.5 * (low + high)
        left, right = (_spirals(stretch, matrix, a, b, depth - 1) for a, b in ((low, middle), (middle, high)))
        return left + right

    def excess(t: Array) -> Array:
        return np.array([float(_moduli(matrix(value))[0][most - 1]) - 1.0 for value in t.tolist()])

    ends = np.array([low]), np.array([high])
    place = float(bracketed_roots(excess, *ends, excess(ends[0]), excess(ends[1]))[0])
    angle = float(_moduli(matrix(place))[1][most - 1])
    if not _REAL < angle < math.pi - _REAL:
        return []
    place, angle, off = _polished(matrix, place, angle)
    y, phase = stretch.place(np.array([place]))
    ys = stretch.place(np.array([max(place - _SLOPE, 0.0), min(place + _SLOPE, 1.0)]))[0]
    residual = off * abs(float(ys[1] - ys[0])) / (2.0 * _SLOPE)
    return [Crossing(SPIRAL, float(y[0]), float(phase[0]), residual, angle, _outside(matrix(place)))]


def _polished(matrix: Callable[[float], LinearMap], t: float, angle: float) -> tuple[float, float, float]:
    """Newton's method on the secular function at exp(iθ): place, angle, and the last step of the place."""
    step = math.inf
    for _ in range(6):
        value = secular(matrix(t), cmath.exp(1j * angle))
        by_t = secular(matrix(t + _SLOPE), cmath.exp(1j * angle)) - secular(matrix(t - _SLOPE), cmath.exp(1j * angle))
        by_t /= 2.0 * _SLOPE
        by_angle = secular(matrix(t), cmath.exp(1j * (angle + _SLOPE))) - secular(
            matrix(t), cmath.exp(1j * (angle - _SLOPE))
        )
        by_angle /= 2.0 * _SLOPE
        jacobian = np.array([[by_t.real, by_angle.real], [by_t.imag, by_angle.imag]])
        if abs(np.linalg.det(jacobian)) == 0.0:
            break
        change = np.linalg.solve(jacobian, np.array([value.real, value.imag]))
        if not abs(float(change[0])) < min(step, 1e-5):  # rounding, or somewhere else: what there is is kept
            break
        step = abs(float(change[0]))
        t, angle = min(max(t - float(change[0]), _SLOPE), 1.0 - _SLOPE), angle - float(change[1])
        if step < 1e-15:
            break
    return t, angle, step if math.isfinite(step) else 1e-12
