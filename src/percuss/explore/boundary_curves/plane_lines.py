"""A line through a plane of parameters, x fixed and y moving, and what lies on it: folds, and stretches of branches."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple, TypeAlias

import numpy as np

from percuss.explore.family import Family
from percuss.halting import check_interrupted
from percuss.model import System
from percuss.model.checks import Array
from percuss.model.load import Side
from percuss.steady import Orbit
from percuss.steady.forced import forced_response
from percuss.steady.phases import Arcs, PhaseCondition, level_of, phase_condition

SAMPLES, EXACT_SAMPLES, GRAZING_SAMPLES = 49, 33, 25
"""Places of a stretch that are looked at first: for the reduced criterion, for the exact map, and for grazing.

Under a load of K harmonics by `PER_HARMONIC` more for each: what happens on a branch turns as often as they do.
"""

PER_HARMONIC = 8


@dataclass(frozen=True)
class Line:
    """All systems at one x, m load periods an impact: y from `low` to `high`, `fixed` stays; `told` of the share."""

    family: Family
    fixed: dict[str, float]
    name: str
    low: float
    high: float
    periods: int
    modes: int | None
    tolerance: float = 1e-11
    told: Callable[[float], None] | None = field(default=None, repr=False)
    _systems: dict[float, System] = field(default_factory=dict, repr=False)
    _known: dict[float, PhaseCondition] = field(default_factory=dict, repr=False)

    @property
    def period(self) -> float:
        """T = 2πm."""
        return 2.0 * math.pi * self.periods

    def system(self, y: float) -> System:
        """The system at a value of y, made once."""
        check_interrupted()
        if y not in self._systems:
            self._systems[y] = self.family.system({**self.fixed, self.name: y})
        return self._systems[y]

    def condition(self, y: float) -> PhaseCondition:
        """The curve whose arcs meet a level at the impact phases, at a value of y, made once."""
        if y not in self._known:
            self._known[y] = self.condition_of(self.system(y))
        return self._known[y]

    def condition_of(self, system: System) -> PhaseCondition:
        """The same of any system on the line; under steps v_f stands for it, right to second order in 1/s."""
        response = forced_response(system)
        if response.is_smooth:
            return phase_condition(system, self.periods, self.modes)
        return PhaseCondition(Arcs.of(response), level_of(system, self.period))

    @cached_property
    def middle(self) -> System:
        """The system in the middle of the range: its arcs are those of all where y moves the level alone."""
        return self.system(0.5 * (self.low + self.high))


FOLD = "fold"


class BoundaryCrossing(NamedTuple):
    """One crossing on a branch to `residual` in y; `outside`: how many other multipliers, 0 at an end of stability."""

    kind: str
    branch: int
    y: float
    phase: float
    residual: float
    angle: float = math.nan
    outside: float = math.nan
    speed: float = math.nan


@dataclass(frozen=True)
class MotionArc(ABC):
    """A part of one branch, arc number `branch`, over t in [0, 1]; from `start` to `stop`, values of y or phases."""

    line: Line
    branch: int
    start: float
    stop: float

    def nodes(self, samples: int | None, inside: float, least: int = SAMPLES) -> Array:
        """Increasing places, `inside` the ends, at which what happens on it shows: more of many harmonics."""
        many = least + PER_HARMONIC * int(self.line.middle.load.harmonics.max(initial=0))
        return np.linspace(inside, 1.0 - inside, samples or many)

    @abstractmethod
    def place(self, t: Array) -> tuple[Array, Array]:
        """y and phase; shapes of `t`."""

    @abstractmethod
    def quadratic(self, t: Array) -> tuple[Array, Array, Array]:
        """a_0, a_1, a_2 of B77 (29)–(31); shapes of `t`."""


def orbit_on(stretch: MotionArc, t: float) -> tuple[Orbit, Side]:
    """The orbit at a place of a stretch, and the side from which its load is to be taken should it jump there."""
    y, phase = (float(v[0]) for v in stretch.place(np.array([t])))
    system = stretch.line.system(y)
    side: Side = "right"
    if system.load.is_piecewise:
        ahead, behind = (float(stretch.place(np.array([v]))[1][0]) for v in (min(t + 1e-3, 1.0), max(t - 1e-3, 0.0)))
        rising = math.remainder(ahead - behind, 2.0 * math.pi) > 0.0
        side = "right" if (t < 0.5) == rising else "left"
    line = stretch.line
    return Orbit(system, line.periods, phase, False, line.modes, line.tolerance), side


def phase_at(arcs: Arcs, arc: int, height: float) -> float:
    """Where an arc meets a height, on the arc itself and not back on the circle."""
    for end in (arc, arc + 1):
        if height == arcs.velocities[end]:
            return float(arcs.ends[end])
    return arcs.phase_on(arc, height)


# ---- All roots of a function on an interval that a sampling shows: brackets, near touches, and their polishing

Function: TypeAlias = Callable[[Array], Array]

_EPS = float(np.finfo(float).eps)
_GOLDEN = 0.381966011250105
_NEAR = 0.25  # a sample whose neighbours promise an extreme nearer to 0 than this share of it is looked at closely


def bracketed_roots(f: Function, low: Array, high: Array, f_low: Array, f_high: Array, steps: int = 120) -> Array:
    """One root in each bracket, to rounding, by inverse quadratic steps (Chandrupatla 1997)."""
    x1, x2, f1, f2 = (np.array(v, dtype=float) for v in (high, low, f_high, f_low))
    t = np.full(x1.shape, 0.5)
    best = np.where(np.abs(f1) < np.abs(f2), x1, x2)
    active = np.flatnonzero((f1 != 0.0) & (f2 != 0.0))
    for _ in range(steps):
        if not active.size:
            break
        a, b, fa, fb = x1[active], x2[active], f1[active], f2[active]
        x = a + t[active] * (b - a)
        fx = f(x)
        same = np.sign(fx) == np.sign(fa)
        c, fc = np.where(same, a, b), np.where(same, fa, fb)
        b, fb = np.where(same, b, a), np.where(same, fb, fa)
        x1[active], f1[active], x2[active], f2[active] = x, fx, b, fb
        best[active] = np.where(np.abs(fb) < np.abs(fx), b, x)
        limit = (2.0 * _EPS * np.abs(best[active]) + 1e-300) / np.maximum(np.abs(b - x), 1e-300)
        t[active] = np.clip(_next_step((x, b, c), (fx, fb, fc)), limit, 1.0 - np.minimum(limit, 1.0))
        active = active[(limit <= 0.5) & (fx != 0.0)]
    return np.asarray(best)


def _next_step(x: tuple[Array, Array, Array], f: tuple[Array, Array, Array]) -> Array:
    """Where in the bracket to look next, as a share of it: by inverse quadratic interpolation, else the middle."""
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        xi, phi = (x[0] - x[1]) / (x[2] - x[1]), (f[0] - f[1]) / (f[2] - f[1])
        step = f[0] / (f[1] - f[0]) * f[2] / (f[1] - f[2])
        step += (x[2] - x[0]) / (x[1] - x[0]) * f[0] / (f[2] - f[0]) * f[1] / (f[2] - f[1])
        safe = (phi**2 < xi) & ((1.0 - phi) ** 2 < 1.0 - xi) & np.isfinite(step)
    return np.where(safe, step, 0.5)


def roots_on(f: Function, nodes: Array) -> Array:
    """The roots of a continuous function that its values at the nodes show, increasing; shape (n,)."""
    # Every change of sign between two nodes gives one root. Where the function turns back before it reaches zero, and
    # its three nearest values let an extreme beyond or near zero be expected, the extreme is looked for, so that two
    # roots between two nodes are found as well. Where it is NaN there are no roots; where it changes its sign through a
    # pole neither.
    values = f(nodes)
    low, high, f_low, f_high = [nodes[:-1]], [nodes[1:]], [values[:-1]], [values[1:]]
    for i in _promising(values):
        turn, value = _extreme(f, nodes[i - 1 : i + 2], values[i - 1 : i + 2])
        if np.sign(value) != np.sign(values[i]):
            inner, inner_values = np.array([nodes[i - 1], turn, nodes[i + 1]]), np.array([values[i], value, values[i]])
            for parts, part in (
                (low, inner[:-1]), (high, inner[1:]), (f_low, inner_values[:-1]), (f_high, inner_values[1:]),
            ):  # fmt: skip
                parts.append(part)
    a, b, fa, fb = (np.concatenate(x) for x in (low, high, f_low, f_high))
    ends = nodes[values == 0.0]
    with np.errstate(invalid="ignore"):
        crossed = fa * fb < 0.0
    a, b, fa, fb = a[crossed], b[crossed], fa[crossed], fb[crossed]
    found = bracketed_roots(f, a, b, fa, fb)
    if found.size:
        poles = ~(np.abs(f(found)) <= np.maximum(np.abs(fa), np.abs(fb)))
        found = found[~poles]
    return np.asarray(np.unique(np.concatenate([found, ends])))


def _promising(values: Array) -> list[int]:
    """Inner nodes at which |f| is least among neighbours of one sign, and a parabola comes near zero or beyond."""
    found = []
    for i in range(1, values.size - 1):
        left, here, right = values[i - 1 : i + 2] * np.sign(values[i])
        if not (0.0 < here <= left and here <= right) or not np.isfinite(left + right):
            continue
        bend = left - 2.0 * here + right
        if bend > 0.0 and here - 0.125 * (right - left) ** 2 / bend <= _NEAR * here:
            found.append(i)
    return found


def _extreme(f: Function, x: Array, values: Array) -> tuple[float, float]:
    """The extreme of f between the first and the last of three places, or the first value found beyond zero."""
    sign = float(np.sign(values[1]))
    a, b, c = (float(v) for v in x)
    best = sign * float(values[1])
    for _ in range(60):
        right = c - b > b - a
        trial = b + _GOLDEN * (c - b) if right else b - _GOLDEN * (b - a)
        value = sign * float(f(np.array([trial]))[0])
        if value < 0.0:
            return trial, sign * value
        if value < best:
            a, b, c, best = (b, trial, c, value) if right else (a, trial, b, value)
        elif right:
            c = trial
        else:
            a = trial
        if c - a < 1e-9 * max(abs(b), 1.0):
            break
    return b, sign * best
