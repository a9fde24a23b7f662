"""The boundaries of steady motions in a plane of two parameters, as curves that are solved for and not read off a grid.

For every value of x all values of y are found at which two motions meet in a fold, one of them doubles its period in a
flip, a pair of its multipliers leaves the unit circle, or the bar begins to touch the wall between two impacts.
"""

from __future__ import annotations

import cmath
import itertools
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache, reduce
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from percuss.errors import Interrupted, ParameterError, PercussError, extra_package
from percuss.explore.boundary_curves.motion_branches import folds_and_stretches
from percuss.explore.boundary_curves.plane_lines import (
    EXACT_SAMPLES,
    FOLD,
    GRAZING_SAMPLES,
    BoundaryCrossing,
    Function,
    Line,
    MotionArc,
    bracketed_roots,
    orbit_on,
    roots_on,
)
from percuss.explore.family import Axis, Family, family_of
from percuss.explore.jobs.archive_export import OfValues
from percuss.explore.jobs.progress import JobProgress, Meter
from percuss.explore.parameters import PARAMETERS, PERIODS
from percuss.halting import check_interrupted, halting
from percuss.model import System
from percuss.model.body import need_free
from percuss.model.checks import DEFAULT_MODES, Array, callback, count, several
from percuss.model.contact import Result
from percuss.short_repr import ShortRepr
from percuss.steady import Orbit
from percuss.steady.flight import a_passage, start_acceleration, stays_off, tops
from percuss.steady.multipliers import LinearMap
from percuss.steady.states import MAX_MODES, MAX_PERIODS

if TYPE_CHECKING:
    from xarray import Dataset


# ---- Where a multiplier of a motion on a branch, of the reduced or of the exact map, passes the unit circle

FLIP, SPIRAL = "flip", "neimark-sacker"

_REAL = 1e-4  # angles this close to 0 or π belong to a fold or a flip, which are found by themselves
_SLOPE = 1e-6  # half the step in t of the slopes that turn a residual into an error of y
_INSIDE = 1e-7  # the ends of a stretch are folds: the samples stay this far inside
_OUTSIDE = 1e-7  # multipliers this little outside the circle are those that cross it
_DEPTH = 6  # halvings of a step in which several multipliers cross


def _crossing(stretch: MotionArc, kind: str, t: float, off: float, angle: float = math.nan) -> BoundaryCrossing:
    """The crossing at a place; `off`: the step in t that Newton's method would still make there."""
    y, phase = stretch.place(np.array([t]))
    low, high = max(t - _SLOPE, 0.0), min(t + _SLOPE, 1.0)
    ys = stretch.place(np.array([low, high]))[0]
    residual = off * abs(float(ys[1] - ys[0])) / (high - low)
    return BoundaryCrossing(kind, stretch.branch, float(y[0]), float(phase[0]), residual, angle)


def _off(f: Function, t: float, low: float = 0.0, high: float = 1.0) -> float:
    """The step in t that Newton's method would still make at a root of f between two places; NaN where f is flat."""
    around = np.clip(np.array([t - _SLOPE, t, t + _SLOPE]), low, high)
    values = f(around)
    rise = float(values[2] - values[0])
    return abs(float(values[1]) / rise) * float(around[2] - around[0]) if rise else math.nan


# -- B77's reduced criterion --


def reduced_crossings(stretch: MotionArc, samples: int | None, spirals: bool = True) -> list[BoundaryCrossing]:
    """Flips, where −1 is a root of B77's quadratic, and spirals, where a pair of its roots is on the circle."""
    nodes = stretch.nodes(samples, _INSIDE)

    def flip(t: Array) -> Array:
        a_0, a_1, a_2 = stretch.quadratic(t)
        return np.asarray((a_0 - a_1 + a_2) / (np.abs(a_0) + np.abs(a_1) + np.abs(a_2)))

    def spiral(t: Array) -> Array:
        a_0, _, a_2 = stretch.quadratic(t)
        return np.asarray((a_2 - a_0) / (np.abs(a_0) + np.abs(a_2)))

    found = []
    for t in roots_on(flip, nodes).tolist():
        a_0, _, a_2 = (float(a[0]) for a in stretch.quadratic(np.array([t])))
        crossing = _crossing(stretch, FLIP, t, _off(flip, t), math.pi)
        found.append(crossing._replace(outside=float(abs(a_0) > (1.0 + _OUTSIDE) * abs(a_2))))
    for t in roots_on(spiral, nodes).tolist() if spirals else ():
        a_0, a_1, a_2 = (float(a[0]) for a in stretch.quadratic(np.array([t])))
        if abs(a_1) < (1.0 - _REAL) * abs(a_0 + a_2):
            angle = math.acos(-a_1 / (a_0 + a_2))
            found.append(_crossing(stretch, SPIRAL, t, _off(spiral, t), angle)._replace(outside=0.0))
    return found


# -- the exact map --


def exact_crossings(
    stretch: MotionArc,
    samples: int | None,
    modes: int,
    spirals: bool = True,
    told: Callable[[float], None] | None = None,
) -> list[BoundaryCrossing]:
    """Flips and spirals of the map of modes 0 … `modes`: roots of its secular function at −1 and at exp(iθ)."""
    nodes = stretch.nodes(samples, _INSIDE, EXACT_SAMPLES)
    steps = itertools.count(1)

    @lru_cache(maxsize=4096)
    def made(t: float) -> LinearMap:
        if told is not None:
            told(min(next(steps) / nodes.size, 1.0) * (0.5 if spirals else 1.0))
        orbit, side = orbit_on(stretch, t)
        return orbit.linear_map(modes, side)

    def matrix(t: float) -> LinearMap:
        check_interrupted()  # its multipliers are solved for again each time
        return made(t)

    def flip(t: Array) -> Array:
        # times the striking speed: where it vanishes the secular function has a pole, which would hide a root beside it
        maps = [matrix(value) for value in t.tolist()]
        return np.array([one.speed * one.secular(-1.0).real for one in maps])

    found = [
        _crossing(stretch, FLIP, t, _off(flip, t), math.pi)._replace(outside=_outside(matrix(t)))
        for t in roots_on(flip, nodes).tolist()
    ]
    for i in range(nodes.size - 1 if spirals else 0):
        found += _spirals(stretch, matrix, nodes[i], nodes[i + 1], _DEPTH)
        if told is not None:
            told(0.5 + 0.5 * (i + 1) / (nodes.size - 1))
    return found


def _moduli(matrix: LinearMap) -> tuple[Array, Array]:
    """Moduli of all multipliers, largest first, and their angles."""
    values = np.linalg.eigvals(matrix.dense())
    order = np.argsort(-np.abs(values))
    return np.abs(values)[order], np.abs(np.angle(values[order]))


def _outside(matrix: LinearMap) -> float:
    """How many multipliers are outside the circle; those on it, to within rounding, are not."""
    return float(np.count_nonzero(_moduli(matrix)[0] > 1.0 + _OUTSIDE))


def _spirals(
    stretch: MotionArc, matrix: Callable[[float], LinearMap], low: float, high: float, depth: int
) -> list[BoundaryCrossing]:
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
    return [_crossing(stretch, SPIRAL, place, off, angle)._replace(outside=_outside(matrix(place)))]


def _polished(matrix: Callable[[float], LinearMap], t: float, angle: float) -> tuple[float, float, float]:
    """Newton's method on the secular function at exp(iθ): place, angle, and the last step of the place."""

    def at(t: float, angle: float) -> complex:
        return matrix(t).secular(cmath.exp(1j * angle))

    step = math.inf
    for _ in range(6):
        value = at(t, angle)
        by_t = at(t + _SLOPE, angle) - at(t - _SLOPE, angle)
        by_angle = at(t, angle + _SLOPE) - at(t, angle - _SLOPE)
        jacobian = np.array([[by_t.real, by_angle.real], [by_t.imag, by_angle.imag]]) / (2.0 * _SLOPE)
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


# ---- Where a steady motion begins or ceases to be possible: the striking end touches the wall between two impacts

GRAZING = "grazing"

_AWAY = 1e-3  # the samples stay this far inside: where the load ceases to push, touches are hard to tell from misses
_NEAR = 1e-6  # share of the stroke by which a first look may mistake one maximum for another
_REACH = 1e-9  # how far beside a touch the motion is asked whether it is possible
_MANY = 256  # looks at a motion from which on those are spared where bounds leave no room for the greatest y
_LOOKS = 17  # places of a maximum that are looked at at once
_PEAKS = 4  # maxima of nearly the same height that are looked at closely
_HALVES = 5  # before a touch is solved for
_STEPS = 80  # halves, or touches that are not the first


def admissible_on(stretch: MotionArc, t: Array, samples: int | None = None) -> npt.NDArray[np.bool_]:
    """Whether the motions at many places of a branch are possible, from the places where that changes."""
    first, switches = _switches(stretch, samples)
    turned = np.searchsorted(np.array([place for place, _ in switches]), np.asarray(t))
    return np.asarray((turned % 2 == 0) == first)


def _switches(
    stretch: MotionArc, samples: int | None, told: Callable[[float], None] | None = None
) -> tuple[bool, list[tuple[float, BoundaryCrossing]]]:
    """Whether the first motion is possible, and every place where that changes."""

    @lru_cache(maxsize=4096)
    def orbit(t: float) -> Orbit:
        check_interrupted()
        return orbit_on(stretch, t)[0]

    nodes = stretch.nodes(samples, _AWAY, GRAZING_SAMPLES)
    first = before = _possible(orbit(float(nodes[0])))
    found = []
    for i in range(1, nodes.size):
        here = _possible(orbit(float(nodes[i])))
        if here != before:
            good, bad = (nodes[i - 1], nodes[i]) if before else (nodes[i], nodes[i - 1])
            found.append(_grazing(stretch, orbit, float(good), float(bad)))
        before = here
        if told is not None:
            told(i / (nodes.size - 1))
    return first, found


def _possible(motion: Orbit) -> bool:
    """Whether a motion is admissible; where a look is enough to say no, the rest of the proof is spared."""
    return motion.impact_velocity > 0.0 and stays_off(motion)


def _grazing(
    stretch: MotionArc, orbit: Callable[[float], Orbit], good: float, bad: float
) -> tuple[float, BoundaryCrossing]:
    """The root of what makes the bad motion impossible; a few halves first: a bare passage is at one place."""
    far, halves = good, _HALVES
    for _ in range(_STEPS):
        if abs(good - bad) <= 4.0 * np.finfo(float).eps * max(good, bad):
            break
        # a passage too shallow to be told from a touch counts as none: farther away the bar is off the wall
        touch = None if halves else _touch(orbit, good, bad) or _touch(orbit, far, bad)
        if touch is None:
            halves = halves - 1 if halves else _HALVES
            middle = 0.5 * (good + bad)
            good, bad = (middle, bad) if _possible(orbit(middle)) else (good, middle)
            continue
        place, off = touch
        beside = place + math.copysign(_REACH * max(1.0, abs(place)), good - bad)
        if (beside - good) * (bad - good) <= 0.0 or _possible(orbit(beside)):
            return place, _crossing(stretch, GRAZING, place, off)
        bad = beside
    ys, phases = stretch.place(np.array([good, bad]))
    off = abs(float(ys[1] - ys[0]))
    return good, BoundaryCrossing(GRAZING, stretch.branch, float(ys[0]), float(phases[0]), off)


def _touch(orbit: Callable[[float], Orbit], good: float, bad: float) -> tuple[float, float] | None:
    """The place between the two where the first motion ceases to be what makes it possible, and the error of it."""
    depth = _fault(orbit(bad))

    def excess(places: Array) -> Array:
        return np.array([depth(orbit(place)) for place in places.tolist()])

    ends = np.array([good]), np.array([bad])
    values = excess(ends[0]), excess(ends[1])
    if not values[0][0] < 0.0 < values[1][0]:
        return None
    place = float(bracketed_roots(excess, *ends, *values)[0])
    return place, _off(excess, place, min(good, bad), max(good, bad))


def _fault(motion: Orbit) -> Callable[[Orbit], float]:
    """What is wrong with a motion, as a function of motions: positive where it is wrong, negative where it is right."""
    if motion.impact_velocity <= 0.0:
        return lambda other: -other.impact_velocity
    if not motion.system.contact.rebounds and start_acceleration(motion) >= 0.0:
        return start_acceleration
    low, high = _beyond(motion)
    return lambda other: _highest(other, low, high)


def _beyond(motion: Orbit) -> tuple[float, float]:
    """The times about a passage through the wall at whose ends the bar is off it, or at an impact."""
    modes, when = motion.truncation.some, a_passage(motion)
    reach = _fine(motion, modes)
    low, high = max(when - reach, 0.0), min(when + reach, motion.period)
    while reach < motion.period:
        y = motion.end_motion(np.array([low, high]), modes)[0]
        if y.max() < 0.0 or (low == 0.0 and high == motion.period):
            break
        reach *= 2.0
        low = max(low - reach, 0.0) if y[0] >= 0.0 else low
        high = min(high + reach, motion.period) if y[1] >= 0.0 else high
    step = min(_fine(motion, modes), 0.25 * (high - low))
    return max(low, step), min(high, motion.period - step)


def _fine(motion: Orbit, modes: int) -> float:
    """A step of time that shows every maximum of so many modes, and of the load."""
    load = motion.system.load
    ringing = float(motion.system.body.modes(modes, load.at).omega[-1]) if modes else 0.0
    fastest = max(ringing, float(load.harmonics.max(initial=1)), 16.0)
    return 2.0 * math.pi / (6.0 * fastest)


def _highest(motion: Orbit, low: float, high: float) -> float:
    """The greatest y between two times: where bounds leave room for it, and there with all modes."""
    count = math.ceil((high - low) / _fine(motion, motion.truncation.some)) + 1
    if count <= _MANY:
        t = np.linspace(low, high, max(count, 5))
    else:
        centres, half = tops(motion, low, high)
        t = np.unique(np.clip(np.concatenate([centres - half, centres, centres + half]), low, high))
    y = motion.end_motion(t, motion.truncation.some)[0]
    middle = np.append(np.insert((y[1:-1] >= y[:-2]) & (y[1:-1] >= y[2:]), 0, y[0] >= y[1]), y[-1] >= y[-2])
    found = np.flatnonzero(middle & (y >= y.max() - _NEAR * motion.rigid_stroke))
    found = found[np.argsort(-y[found])][:_PEAKS]
    return max(_peak(motion, float(t[max(i - 1, 0)]), float(t[min(i + 1, t.size - 1)])) for i in found.tolist())


def _peak(motion: Orbit, low: float, high: float) -> float:
    """The greatest y of one maximum, with all modes: ever narrower looks, then where the speed vanishes."""
    best = -math.inf
    while True:
        t = np.linspace(low, high, _LOOKS)
        y, speed = motion.end_motion(t, motion.modes)
        i = int(np.argmax(y))
        best = max(best, float(y[i]))
        low, high = float(t[max(i - 1, 0)]), float(t[min(i + 1, _LOOKS - 1)])
        if high - low < 1e-7 * motion.period or float(np.ptp(y)) <= 1e-15 * motion.rigid_stroke:
            break
    other = min(max(i + (1 if speed[i] > 0.0 else -1), 0), _LOOKS - 1)
    if speed[i] * speed[other] < 0.0:
        turn = t[i] + (t[other] - t[i]) * speed[i] / (speed[i] - speed[other])
        best = max(best, float(motion.end_motion(np.array([turn]), motion.modes)[0][0]))
    return best


# ---- The boundaries of steady motions in a plane of two parameters, as curves that are solved for

KINDS = (FOLD, FLIP, SPIRAL, GRAZING)  # what can happen on a branch of steady motions

CRITERIA = ("reduced", "exact")

_FAR = 0.75  # in shares of the range of y and of a half turn: points farther apart are not of one curve
_GAP = 1e-3  # what each missing value of x adds to that
_OVER_X = ("y", "phase", "residual", "angle", "outside", "impact_velocity")


@dataclass(frozen=True, eq=False)
class BoundaryCurve(ShortRepr):
    """One boundary over x; every array of shape (n,), NaN where x has none.

    `branch`: the monotone arc of v_f (for a fold: its extremum) on which the curve begins, counted by phase from 0.
    `x`, `y`: the parameters, in their own units. `phase`: load phase of the impact, rad in [0, 2π). `residual`: the
    step in y that Newton's method would still make. `angle`: of the multiplier on the unit circle, in rad: 0 at a fold,
    π at a flip; NaN for a grazing. `outside`: how many other multipliers are outside the circle there: where there are
    some, the motion is unstable on both sides; NaN for folds and grazing. `impact_velocity`: striking speed of the
    motion there, dimensionless; where it is not greater than 0 the motion strikes backward, which a bar does not.
    """

    kind: str
    branch: int
    x: Array
    y: Array
    phase: Array
    residual: Array
    angle: Array
    outside: Array
    impact_velocity: Array

    @property
    def found(self) -> npt.NDArray[np.bool_]:
        return ~np.isnan(self.y)

    def without(self, points: npt.NDArray[np.bool_]) -> BoundaryCurve:
        """The curve with gaps at some of its points."""
        return replace(self, y=np.where(points, math.nan, self.y))


@dataclass(frozen=True, eq=False)
class Boundaries(OfValues):
    """All boundaries of a plane.

    Parameters
    ----------
    x
        Values of the first, shape (n,).
    low, high
        Range of the second.
    curves
        The boundaries, in order of kind.
    failed
        Values of x at which nothing could be computed, with the reason.
    modes
        N of the exact multipliers and of grazing; None for 32 and for the continuous bar.
    """

    x_name: str
    y_name: str
    x: Array
    low: float
    high: float
    curves: tuple[BoundaryCurve, ...]
    failed: tuple[tuple[float, str], ...] = ()
    modes: int | None = None

    def of(self, kind: str) -> tuple[BoundaryCurve, ...]:
        """The curves of one kind."""
        if kind not in KINDS:
            raise ParameterError("kind", kind, f"one of {', '.join(KINDS)}")
        return tuple(curve for curve in self.curves if curve.kind == kind)

    @property
    def real(self) -> tuple[BoundaryCurve, ...]:
        """The curves without points on motions that strike backward."""
        kept = [c if c.kind == GRAZING else c.without(c.impact_velocity <= 0.0) for c in self.curves]
        return tuple(curve for curve in kept if curve.found.any())

    @property
    def of_stability(self) -> tuple[BoundaryCurve, ...]:
        """The curves at which stability or existence of motions that there can be ends.

        Without crossings of motions that are unstable anyhow, or strike backward.
        """
        kept = [c.without(c.outside > 0.0) for c in self.real if c.kind != GRAZING]
        return tuple(curve for curve in kept if curve.found.any())

    def greatest(self, kind: str) -> Array:
        """The greatest y of one kind at every x, NaN where there is none; shape (n,)."""
        return self._extreme(kind, np.fmax)

    def least(self, kind: str) -> Array:
        """The least y of one kind at every x, NaN where there is none; shape (n,)."""
        return self._extreme(kind, np.fmin)

    def _extreme(self, kind: str, choose: np.ufunc) -> Array:
        return np.asarray(reduce(choose, (curve.y for curve in self.of(kind)), np.full(self.x.shape, math.nan)))

    def to_xarray(self) -> Dataset:
        """All curves, over the dimension ``curve`` and over x."""
        over = {name: np.array([getattr(c, name) for c in self.curves]).reshape(-1, self.x.size) for name in _OVER_X}
        variables: dict[str, Any] = {name: (("curve", self.x_name), values) for name, values in over.items()}
        about_each = {name: ("curve", [getattr(c, name) for c in self.curves]) for name in ("kind", "branch")}
        about = {"y": self.y_name, "low": self.low, "high": self.high}
        made: Dataset = extra_package("xarray", "io").Dataset(variables, {self.x_name: self.x, **about_each}, about)
        return made

    def as_json(self) -> dict[str, Any]:
        """All of it as plain values."""
        curves = [
            {name: value.tolist() if isinstance(value, np.ndarray) else value for name, value in vars(curve).items()}
            for curve in self.curves
        ]
        return {**vars(self), "x": self.x.tolist(), "curves": curves}

    @classmethod
    def from_json(cls, row: Mapping[str, Any]) -> Boundaries:
        """`as_json` backwards."""

        def made(one: Mapping[str, Any]) -> BoundaryCurve:
            told: dict[str, Any] = {key: np.array(it) if isinstance(it, list) else it for key, it in one.items()}
            return BoundaryCurve(**told)

        failed = tuple((value, why) for value, why in row["failed"])
        return cls(**{**row, "x": np.array(row["x"]), "curves": tuple(map(made, row["curves"])), "failed": failed})

    def __str__(self) -> str:
        modes = "continuous bar" if self.modes is None else f"{self.modes} modes"
        head = f"{self.y_name} from {self.low:g} to {self.high:g} over {self.x.size} values of {self.x_name}, {modes}"
        return "\n".join([head, *(f"  {c.kind}, branch {c.branch}: {int(c.found.sum())} points" for c in self.curves)])


def linked(kind: str, x: Array, rows: list[list[BoundaryCrossing]], span: float) -> list[BoundaryCurve]:
    """Join the points of one kind to curves: each goes on with the point that is nearest in y and phase."""
    threads: list[dict[int, BoundaryCrossing]] = []
    for i, row in enumerate(rows):
        points = [crossing for crossing in row if crossing.kind == kind]
        pairs = sorted(
            (_distance(thread[max(thread)], point, span) + _GAP * (i - 1 - max(thread)), a, b)
            for a, thread in enumerate(threads)
            for b, point in enumerate(points)
        )
        taken_threads: set[int] = set()
        taken_points: set[int] = set()
        for distance, a, b in pairs:
            if distance < _FAR and a not in taken_threads and b not in taken_points:
                threads[a][i] = points[b]
                taken_threads.add(a)
                taken_points.add(b)
        threads += [{i: point} for b, point in enumerate(points) if b not in taken_points]
    curves = []
    for thread in threads:
        columns = np.full((6, x.size), math.nan)
        for i, point in thread.items():
            columns[:, i] = point.y, point.phase, point.residual, point.angle, point.outside, point.speed
        curves.append(BoundaryCurve(kind, thread[min(thread)].branch, x, *columns))
    return curves


def _distance(a: BoundaryCrossing, b: BoundaryCrossing, span: float) -> float:
    return abs(a.y - b.y) / span + abs(math.remainder(a.phase - b.phase, 2.0 * math.pi)) / math.pi


def boundaries(
    system: System | Family,
    x: Axis | str | tuple[Any, ...],
    y: Axis | str | tuple[Any, ...],
    periods: int = 1,
    criterion: str = "reduced",
    *,
    modes: int | None = None,
    kinds: Sequence[str] = KINDS,
    samples: int | None = None,
    progress: Callable[[JobProgress], object] | None = None,
) -> Boundaries:
    """The boundaries of steady motions with one impact every m load periods, each point solved for as a root.

    Folds do not depend on the criterion. A branch is followed by its phase where y moves the level of B77 (14) alone
    (the load factor, the mean, the amplitude, R), otherwise by y from fold to fold. What happens twice between two
    samples of a branch, and leaves no trace in them, is not found.

    Parameters
    ----------
    system
        The system, or a family of systems, of which x and y are parameters.
    x
        A parameter and its values: text, ``"restitution=0:0.9:31"``, ``(name, values)``, ``(name, first, last,
        number)`` or an `Axis`; besides the family's own, "m" for the load periods per impact.
    y
        Another parameter and the range in which boundaries are looked for: text, ``"load_factor=0:2"``,
        ``(name, lowest, highest)`` or an `Axis`.
    criterion
        ``reduced`` for B77 (29)–(32), ``exact`` for the multipliers of modes 0 … `modes`.
    modes
        N. None: the exact multipliers of 32 modes, and grazing of the continuous bar.
    kinds
        What to look for; grazing takes the longest.
    samples
        Of each branch at first: by default 49, for the exact multipliers 33, for grazing 25, and more for many
        harmonics.
    progress
        Called with a `percuss.explore.JobProgress` that counts values of x, says which part of the present one is done
        and how long the rest will take; once it returns something true, the present value and those that follow are
        given up and count as failed.

    Returns
    -------
    Boundaries
        With a curve for everything that was found; a value of x that fails leaves NaN and says why. Some points may be
        on motions that strike backward, which only the equations have: `Boundaries.real` is without them.

    References
    ----------
    U. Björkenstam, Int. J. Mech. Sci. 19 (1977) 471–481, equations (14), (29)–(32), Figs 5, 6 and 8.

    Examples
    --------
    The range of Fig. 5 at R = 0, 0.3 and 0.6:

    >>> from percuss import Load, System
    >>> pneumatic = System(s=1e7, d=0.0, restitution=0.0, load=Load.harmonic(1.0, 1.0))
    >>> plane = ("restitution", [0.0, 0.3, 0.6]), ("load_factor", 0.0, 2.0)
    >>> found = boundaries(pneumatic, *plane, kinds=("fold", "flip"))
    >>> found.greatest("fold"), found.greatest("flip")
    (array([0.31830989, 0.59114693, 1.27323954]), array([0.26851464, 0.470072  , 0.75684712]))
    """
    family = family_of(system)
    callback("progress", progress)
    if samples is not None:
        count("samples", samples, least=2, most=10**6)
    x_name, values, y_name, low, high = checked_boundaries(family, x, y, periods, criterion, modes, kinds)
    try:
        corner = family.system({y_name: low} if x_name == PERIODS else {x_name: float(values[0]), y_name: low})
    except PercussError:
        pass  # there is none
    else:
        need_free(corner.body, "boundary curves; `follow` finds those of structures")
    meter = Meter(values.size, 0, progress)
    rows: list[list[BoundaryCrossing]] = []
    failed: list[tuple[float, str]] = []
    meter.start(0)
    with halting(meter):
        for value in values.tolist():
            fixed, m = ({}, int(value)) if x_name == PERIODS else ({x_name: value}, periods)
            rows.append([])
            try:
                line = Line(family, fixed, y_name, low, high, m, modes, told=meter.within)
                rows[-1] = _on_line(line, criterion, tuple(kinds), samples)
            except Interrupted:
                failed.append((value, "given up"))
            except PercussError as error:
                failed.append((value, str(error)))
            meter.add(1)
        meter.tell()
    curves = [curve for kind in KINDS if kind in kinds for curve in linked(kind, values, rows, high - low)]
    return Boundaries(x_name, y_name, values, low, high, tuple(curves), tuple(failed), modes)


def checked_boundaries(
    family: Family,
    x: Axis | str | tuple[Any, ...],
    y: Axis | str | tuple[Any, ...],
    periods: int = 1,
    criterion: str = "reduced",
    modes: int | None = None,
    kinds: Sequence[str] = KINDS,
) -> tuple[str, Array, str, float, float]:
    """The names, values and range of a question to `boundaries`; ParameterError when it has no answer."""
    kinds = several("kinds", kinds, f"some of {', '.join(KINDS)}")
    axis, up = Axis.of(x, "x"), Axis.range_of(y, "y")
    name, (low, high) = up.name, up.values.tolist()
    things = [PARAMETERS[own].thing if own in PARAMETERS else own for own in (name, axis.name)]
    if things[0] == things[1]:
        raise ParameterError("y", name, f"a parameter that can be moved beside {axis.name}")
    units: Mapping[str, str] = getattr(family, "units", {})  # of a case's keys; plain numbers have none
    names = {axis.name: axis.unit or units.get(axis.name, ""), name: units.get(name, "")}
    if name == PERIODS:
        raise ParameterError("y", name, "a parameter that is not a whole number")
    if names.pop(PERIODS, None) is not None:
        for value in axis.values.tolist():
            count(PERIODS, int(value) if value == int(value) else value, most=MAX_PERIODS)
    family.check(names)
    count("periods", periods, most=MAX_PERIODS)
    if modes is not None:
        count("modes", modes, least=0, most=MAX_MODES)
    if criterion not in CRITERIA:
        raise ParameterError("criterion", criterion, f"one of {', '.join(CRITERIA)}")
    unknown = [kind for kind in kinds if not isinstance(kind, str) or kind not in KINDS]
    if unknown or not kinds:
        raise ParameterError("kinds", unknown[0] if unknown else kinds, f"some of {', '.join(KINDS)}")
    return axis.name, axis.values, name, low, high


def _on_line(line: Line, criterion: str, kinds: tuple[str, ...], samples: int | None) -> list[BoundaryCrossing]:
    """Everything that happens at one value of x; ParameterError where it does not hold for the contact law."""
    line.middle.contact.need(Result.LEVEL)
    if criterion == "reduced" and {FLIP, SPIRAL} & set(kinds):
        line.middle.contact.need(Result.REDUCED)
    alone = set(kinds) == {FOLD}
    folds, stretches = folds_and_stretches(line, samples or (17 if alone else 33), alone)
    found = folds if FOLD in kinds else []
    exact, grazing = criterion == "exact" and bool({FLIP, SPIRAL} & set(kinds)), GRAZING in kinds
    parts = len(stretches) * max(exact + grazing, 1)  # of the work; the reduced criterion is hardly any
    part = 0

    def told(share: float) -> None:
        if line.told is not None:
            line.told((part + share) / parts)

    for stretch in stretches:
        crossings: list[BoundaryCrossing] = []
        if exact:
            most = DEFAULT_MODES if line.modes is None else line.modes
            crossings += exact_crossings(stretch, samples, most, SPIRAL in kinds, told)
            part += 1
        elif FLIP in kinds or SPIRAL in kinds:
            crossings += reduced_crossings(stretch, samples, SPIRAL in kinds)
        if grazing:
            crossings += [crossing for _, crossing in _switches(stretch, samples, told)[1]]
            part += 1
        found += [crossing for crossing in crossings if crossing.kind in kinds]
    return [crossing._replace(speed=_speed(line, crossing)) for crossing in found]


def _speed(line: Line, crossing: BoundaryCrossing) -> float:
    few = DEFAULT_MODES if line.modes is None else line.modes
    motion = Orbit(line.system(crossing.y), line.periods, crossing.phase, False, few)
    if line.modes is None and motion.impact_velocity < 0.2 * motion.rigid_velocity:
        motion = replace(motion, requested_modes=None)
    return motion.impact_velocity
