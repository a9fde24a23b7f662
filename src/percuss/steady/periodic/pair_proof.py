"""All orbits with two impacts of a rigid bar, with proof that there are no others: interval Newton's method.

Boxes of times (t, h), which together hold every pair of impacts, are thrown away where an equation cannot vanish, or
kept where Krawczyk's operator shows that there is exactly one root (Krawczyk, Computing 4 (1969) 187–201; Neumaier,
Interval Methods for Systems of Equations, 1990, ch. 5), and halved otherwise. All bounds hold rounding included. Where
the load has steps the derivative is the set of all that it has in the box, for which the same holds.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from percuss.halting import check_interrupted
from percuss.mechanics.flow import phi1, phi2
from percuss.model import System
from percuss.model.checks import Array
from percuss.steady.periodic.periodic_orbit import SAME

# ---- Numbers with a bound of their error, in rows: midpoint-radius arithmetic, whose rounding goes into the radius
#
# A sum or a product in doubles is off by at most half a unit in the last place; a whole one is counted (Rump, Acta
# Numerica 19 (2010) 287–449, §10).

UNIT = float(np.finfo(float).eps)
_MORE = 1.0 + 16.0 * UNIT  # for what is rounded in computing a radius itself
_TINY = 1e-300


@dataclass(frozen=True, slots=True, eq=False)
class Ball:
    """All numbers within `rad` of `mid`; arrays of one shape, or shapes that broadcast.

    Examples
    --------
    >>> third = Ball(np.array(1.0), np.array(0.0)) * Ball(np.array(1.0 / 3.0), np.array(1e-16))
    >>> bool(third.rad < 4e-16), bool((third - exactly(1.0 / 3.0)).may_vanish)
    (True, True)
    """

    mid: Array
    rad: Array

    def __add__(self, other: Ball) -> Ball:
        mid = self.mid + other.mid
        return Ball(mid, (self.rad + other.rad + UNIT * np.abs(mid)) * _MORE + _TINY)

    def __sub__(self, other: Ball) -> Ball:
        return self + -other

    def __neg__(self) -> Ball:
        return Ball(-self.mid, self.rad)

    def __mul__(self, other: Ball) -> Ball:
        mid = self.mid * other.mid
        off = np.abs(self.mid) * other.rad + (np.abs(other.mid) + other.rad) * self.rad
        return Ball(mid, (off + UNIT * np.abs(mid)) * _MORE + _TINY)

    def over(self, divisor: Ball) -> Ball:
        """The quotient; a divisor that may vanish gives a radius that is infinite."""
        least = np.abs(divisor.mid) - divisor.rad
        safe = np.where(least > 0.0, divisor.mid, 1.0)
        mid = self.mid / safe
        off = (self.rad + np.abs(mid) * divisor.rad) / np.where(least > 0.0, least, 1.0)
        return Ball(mid, np.where(least > 0.0, (off + 2.0 * UNIT * np.abs(mid)) * _MORE + _TINY, np.inf))

    @property
    def most(self) -> Array:
        """A bound of its modulus."""
        return np.asarray((np.abs(self.mid) + self.rad) * _MORE)

    @property
    def may_vanish(self) -> npt.NDArray[np.bool_]:
        """Whether 0 may be among its numbers."""
        return np.asarray(~(np.abs(self.mid) > self.rad * _MORE))

    def wider(self, by: Array) -> Ball:
        """With a greater radius."""
        return Ball(self.mid, (self.rad + by) * _MORE)


def exactly(value: npt.ArrayLike) -> Ball:
    """Doubles as they are."""
    mid = np.asarray(value, dtype=float)
    return Ball(mid, np.zeros_like(mid))


def hull(low: Array, high: Array) -> Ball:
    """All numbers from one to another."""
    mid = 0.5 * (low + high)
    return Ball(mid, np.maximum(high - mid, mid - low) * _MORE + UNIT * np.abs(mid) + _TINY)


# ---- The forced motion of a bar as a whole, enclosed: U_f, v_f = U_f' and v_f' over intervals of time (theory §4)

_TURN = 2.0 * math.pi
FUNCTION = 64.0 * UNIT  # relative error of exp, φ_1 and φ_2, at most

_WAVE = 16.0 * UNIT  # of an amplitude, a sine, and their product


class Forced(NamedTuple):
    """U_f but for a constant, v_f, and v_f', which may jump: then it is all values that it has."""

    displacement: Ball
    velocity: Ball
    slope: Ball


def advances(d: float, h: Ball) -> tuple[Ball, Ball, Ball]:
    """E = e^{−dh}, (1 − E)/d and its integral over the flight, for all durations h ≥ 0 of a ball."""
    ends = np.stack([np.maximum(h.mid - h.rad, 0.0) * (1.0 - UNIT), (h.mid + h.rad) * (1.0 + UNIT)])
    room = FUNCTION * (1.0 + d * ends[1])  # the argument of an exponential is rounded, too
    values = np.exp(-d * ends), ends * phi1(d * ends), ends**2 * phi2(d * ends)
    kept, once, again = (hull(part.min(axis=0) * (1.0 - room), part.max(axis=0) * (1.0 + room)) for part in values)
    return kept, once, again


class _Waves:
    """Σ of harmonics; `mean` is the mean load, enclosed."""

    def __init__(self, system: System) -> None:
        self.mean = exactly(system.load.mean)
        self.k = system.load.harmonics.astype(float)
        self.factor = system.load.coefficients[system.load.harmonics] / (system.d + 1j * self.k)
        size = np.abs(self.factor)
        self.sums = [float((size * self.k**power).sum()) * (1.0 + _WAVE * (8.0 + size.size)) for power in range(-1, 4)]

    def over(self, time: Ball) -> Forced:
        angle = np.exp(1j * np.multiply.outer(time.mid, self.k))
        found = [(angle @ (self.factor * (1j * self.k) ** power)).real for power in (-1, 0, 1, 2)]
        noise = [  # of Σ of so many waves, whose angles are rounded
            self.sums[i] * (_WAVE + UNIT * self.k.size) + self.sums[i + 1] * UNIT * np.abs(time.mid) for i in range(4)
        ]
        place, rate, slope, turn = (Ball(value, error) for value, error in zip(found, noise, strict=True))
        r, curve = time.rad, self.sums[4]
        return Forced(
            place.wider(rate.most * r + 0.5 * r**2 * np.minimum(slope.most + r * self.sums[3], self.sums[2])),
            rate.wider(slope.most * r + 0.5 * r**2 * self.sums[3]),
            slope.wider(np.minimum(turn.most * r + 0.5 * r**2 * curve, r * self.sums[3])),
        )


class _Steps:
    """Constant between breaks: closed form on each piece from the state that comes back after a turn."""

    def __init__(self, system: System) -> None:
        load, self.d = system.load, system.d
        self.breaks = np.array(load.breaks)
        lengths = np.diff(self.breaks, append=self.breaks[0] + _TURN)
        self.lengths = Ball(lengths, 4.0 * UNIT * np.full(lengths.shape, _TURN))
        values = exactly(load.values)
        areas = values * self.lengths
        total = _sum([Ball(mid, rad) for mid, rad in zip(areas.mid, areas.rad, strict=True)])
        self.mean = total.over(Ball(np.array(_TURN), np.array(8.0 * UNIT)))
        self.force = values - self.mean
        self.kept, self.once, self.again = advances(self.d, self.lengths)
        self.rates, self.places = self._at_breaks()

    def _at_breaks(self) -> tuple[Ball, Ball]:
        """v_f and U_f at the breaks: Σ q h = 0, so that what is divided by 1 − e^{−2πd} vanishes with it."""
        d, count = self.d, self.breaks.size
        terms = []
        for j in range(count):
            after = Ball(self.lengths.mid[j + 1 :].sum(keepdims=True), np.full(1, 32.0 * UNIT * _TURN))
            kept, once, _ = advances(d, after)
            rest = _at(self.again, j) * kept + _at(self.lengths, j) * once
            terms.append(_at(self.force, j) * rest)
        whole = advances(d, Ball(np.array([_TURN]), np.array([8.0 * UNIT])))[1]
        rate, place = -_sum(terms).over(whole), exactly(np.zeros(1))
        rates, places = [rate], [place]
        for j in range(count):
            place = place + rate * _at(self.once, j) + _at(self.force, j) * _at(self.again, j)
            rate = rate * _at(self.kept, j) + _at(self.force, j) * _at(self.once, j)
            rates.append(rate)
            places.append(place)
        return _joined(rates), _joined(places)

    def over(self, time: Ball) -> Forced:
        turns = np.floor((time.mid - self.breaks[0]) / _TURN)
        since = np.clip(time.mid - _TURN * turns - self.breaks[0], 0.0, _TURN)
        inexact = 2.0 * UNIT * (np.abs(time.mid) + 2.0 * _TURN)
        piece = np.clip(np.searchsorted(self.breaks - self.breaks[0], since, side="right") - 1, 0, self.breaks.size - 1)
        into = Ball(np.maximum(since - (self.breaks[piece] - self.breaks[0]), 0.0), 4.0 * inexact)
        kept, once, again = advances(self.d, into)
        force, rate, place = _at(self.force, piece), _at(self.rates, piece), _at(self.places, piece)
        velocity = rate * kept + force * once
        displacement = place + rate * once + force * again
        drag = exactly(self.d)
        r = time.rad + inexact
        everywhere = (np.abs(self.force.mid) + self.force.rad).max() * 2.0  # |v_f'|, as |d v_f| ≤ max |q|
        forces = self._forces(since, r)
        slope = forces - drag * velocity.wider(r * everywhere)
        return Forced(
            displacement.wider(r * velocity.most + 0.5 * r**2 * everywhere), velocity.wider(r * slope.most), slope
        )

    def _forces(self, since: Array, r: Array) -> Ball:
        """All values of the alternating load within r of a time."""
        low, high = np.full(since.shape, np.inf), np.full(since.shape, -np.inf)
        starts, ends = self.breaks - self.breaks[0], np.append(self.breaks[1:] - self.breaks[0], _TURN)
        least, most = self.force.mid - self.force.rad, self.force.mid + self.force.rad
        for turn in (-_TURN, 0.0, _TURN):
            for j in range(starts.size):
                met = (since + r >= starts[j] + turn) & (since - r <= ends[j] + turn)
                low, high = (
                    np.where(met, np.minimum(low, least[j]), low),
                    np.where(met, np.maximum(high, most[j]), high),
                )
        return hull(low, high)


def _at(ball: Ball, which: int | Array) -> Ball:
    """Some of a row of balls, as a row."""
    index = np.atleast_1d(which)
    return Ball(ball.mid[index], ball.rad[index])


def _joined(balls: list[Ball]) -> Ball:
    return Ball(np.concatenate([ball.mid for ball in balls]), np.concatenate([ball.rad for ball in balls]))


def _sum(balls: list[Ball]) -> Ball:
    total = balls[0]
    for ball in balls[1:]:
        total = total + ball
    return total


# ---- Two impacts of a rigid bar, enclosed: the two equations for their times over boxes of times, and their
# derivatives
#
# The unknowns are the time t of one impact and the flight h after it; the other flight takes T − h. It is `ImpactChain`
# for p = 2 and no elastic modes, written out.

_HALF = exactly(0.5)


class Pairs(NamedTuple):
    """F_1 and F_2 over boxes, their derivatives by t and by h, and what F_1 is in proportion to, but for h."""

    first: Ball
    second: Ball
    by_t: tuple[Ball, Ball]
    by_h: tuple[Ball, Ball]
    per_flight: Ball


class PairEquations:
    """The equations of z=2/n, of the bar without its elastic modes."""

    def __init__(self, system: System, periods: int) -> None:
        self.forcing, self.d = _Steps(system) if system.load.is_piecewise else _Waves(system), system.d
        self.beta = float(system.contact.velocity_factor)
        length = 2.0 * math.pi * periods
        self.period = Ball(np.array(length), np.array(UNIT * length))
        left = advances(self.d, Ball(np.array([length]), np.array([UNIT * length])))[0]
        square = exactly(self.beta) * exactly(self.beta)
        self.square, self.divisor = square, exactly(1.0) - square * Ball(left.mid[0], left.rad[0])

    def over(self, t: Ball, h: Ball) -> Pairs:
        """The equations over boxes; t and h of the shape (B,)."""
        d, mean, beta = exactly(self.d), self.forcing.mean, exactly(self.beta)
        one, two = self.forcing.over(t), self.forcing.over(t + h)
        rest = self.period - h
        (kept, once, again), (kept_2, once_2, again_2) = advances(self.d, h), advances(self.d, rest)
        v, w = one.velocity, two.velocity
        rise = self._rise(v, w, t, h)
        # the rigid velocity after either impact, r and q, with their derivatives
        gain = w - v * kept + mean * once
        gain_2 = v - w * kept_2 + mean * once_2
        gain_t, gain_h = two.slope - one.slope * kept, two.slope + (d * v + mean) * kept
        gain_2t, gain_2h = one.slope - two.slope * kept_2, -(two.slope + d * w + mean) * kept_2
        back = self.square * kept_2
        r = (back * gain + beta * gain_2).over(self.divisor)
        r_t = (back * gain_t + beta * gain_2t).over(self.divisor)
        r_h = (back * gain_h + d * back * gain + beta * gain_2h).over(self.divisor)
        before = kept * r + gain
        q, q_t = beta * before, beta * (kept * r_t + gain_t)
        q_h = beta * (kept * r_h - d * kept * r + gain_h)
        before_1 = kept_2 * (q - w) + v + mean * once_2
        moved = two.displacement - one.displacement
        return Pairs(
            (r - v) * once + mean * again + moved,
            (q - w) * once_2 + mean * again_2 - moved,
            ((r_t - one.slope) * once + rise, (q_t - two.slope) * once_2 - rise),
            (before + r_h * once, (q_h - two.slope) * once_2 - before_1 - rise),
            self._per_flight(r, t, h, one),
        )

    def _between(self, t: Ball, h: Ball) -> Ball:
        """v_f' at all times from the one impact to the other."""
        low, high = t.mid - t.rad, t.mid + t.rad + np.maximum(h.mid + h.rad, 0.0)
        return self.forcing.over(hull(low, high)).slope

    def _rise(self, v: Ball, w: Ball, t: Ball, h: Ball) -> Ball:
        """v_f(t + h) − v_f(t), for short flights by what lies between."""
        plain, mean_slope = w - v, self._between(t, h)
        steady = mean_slope * h
        narrow = steady.rad < plain.rad
        return Ball(np.where(narrow, steady.mid, plain.mid), np.where(narrow, steady.rad, plain.rad))

    def _per_flight(self, r: Ball, t: Ball, h: Ball, one: Forced) -> Ball:
        """F_1/(hφ_1) = r + h(φ_2(p_0 + d v_f) + ∫ (1 − s) v_f'(t + sh) ds)/φ_1, s from 0 to 1; for R = 0 over h."""
        ends = [self.d * np.maximum(h.mid - h.rad, 0.0) * (1.0 - UNIT), self.d * (h.mid + h.rad) * (1.0 + UNIT)]
        least, most = 1.0 - FUNCTION, 1.0 + FUNCTION
        first, second = (hull(phi(ends[1]) * least, phi(ends[0]) * most) for phi in (phi1, phi2))  # which fall with h
        grown = second * (self.forcing.mean + exactly(self.d) * one.velocity) + _HALF * self._between(t, h)
        per_time = grown.over(first)
        return r + h * per_time if self.beta else per_time


# ---- All orbits with two impacts of a rigid bar, with proof that there are no others: interval Newton's method

_COARSE = 0.5  # rad, of the first boxes
_WIDER = 1.1  # what is looked at is so much wider than a box, so that roots on an edge are inside
_NARROWEST = 1e-9  # rad; a box that is undecided then has a root that is none or many
_MOST = 3_000_000  # boxes
_AT_ONCE = 1 << 15
_SHARPER = 8  # times that the enclosure of a root is made narrower
_PRECISE = 1e-9  # rad


class _Enclosed(NamedTuple):
    """Boxes in which there is exactly one root, and how much narrower it is known; each array of the shape (K, 2)."""

    mid: Array
    rad: Array
    root: Array
    error: Array


def proved_pairs(system: System, periods: int, turn: float) -> Array | None:
    """The times t_1 and t_2 of all pairs of impacts that solve the equations, each once, to 1e-9; shape (K, 2)."""
    # None where that is not proved: where a root is degenerate, as at a fold or at a step of the load, where the rigid
    # velocity does not follow from the times (R = 1 without drag), where it would take millions of boxes, and of a body
    # that is held. `turn` is after how long the load repeats.
    if not system.body.is_free:
        return None
    equations = PairEquations(system, periods)
    if not equations.divisor.mid > 1e-3:  # the rigid velocity does not follow from the times
        return None
    every = _boxes(equations, turn, math.pi * periods)
    if every is None:
        return None
    found = _sharpened(equations, every)
    period = 2.0 * math.pi * periods
    kept: list[int] = []
    for i in range(found.root.shape[0]):
        again = [j for j in kept if _apart(found, i, j, period, turn)[0] <= SAME]
        if float(found.error[i].max()) > _PRECISE or not all(_apart(found, i, j, period, turn)[1] for j in again):
            return None
        if not again:
            kept.append(i)
    return np.stack([found.root[kept, 0], found.root[kept].sum(axis=1)], axis=1)


def _boxes(equations: PairEquations, turn: float, longest: float) -> _Enclosed | None:
    """The boxes with one root each, of boxes that hold all times; None where some stay undecided."""
    mid, rad = _covering(turn, longest)
    kept: list[_Enclosed] = []
    looked = 0
    while mid.size:
        looked += mid.shape[0]
        if looked > _MOST or rad.min() < _NARROWEST:
            return None
        halves = []
        for first in range(0, mid.shape[0], _AT_ONCE):
            check_interrupted()
            part = slice(first, first + _AT_ONCE)
            found, left = _decided(equations, mid[part], rad[part])
            kept.append(found)
            halves.append(left)
        mid, rad = (np.concatenate(parts) for parts in zip(*halves, strict=True))
    return _Enclosed(*(np.concatenate(parts) for parts in zip(*kept, strict=True)))


def _apart(found: _Enclosed, one: int, other: int, period: float, turn: float) -> tuple[float, bool]:
    """How far two roots are apart, but for shifts, and whether the first is surely in the box of the second."""
    t, h = found.root[one].tolist()
    forms = np.array([[t, h], [t + h, period - h]])
    off = forms - found.root[other]
    forms[:, 0] -= turn * np.rint(off[:, 0] / turn)
    off = np.abs(forms - found.root[other]).max(axis=1)
    nearest = int(np.argmin(off))
    room = found.rad[other] - np.abs(forms[nearest] - found.mid[other])
    return float(off[nearest]), bool(np.all(2.0 * found.error[one].sum() + 1e-14 * period < room))


def _covering(turn: float, longest: float) -> tuple[Array, Array]:
    """Boxes that cover t in [0, turn], h in [0, longest]: the shorter flight comes first."""
    counts = [max(1, math.ceil(side / _COARSE)) for side in (turn, longest)]
    rads = np.array(
        [0.5 * side / count * (1.0 + 4.0 * UNIT) for side, count in zip((turn, longest), counts, strict=True)]
    )
    axes = [(np.arange(count) + 0.5) * 2.0 * rad for count, rad in zip(counts, rads, strict=True)]
    mid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 2)
    return mid, np.broadcast_to(rads, mid.shape).copy()


def _decided(equations: PairEquations, mid: Array, rad: Array) -> tuple[_Enclosed, tuple[Array, Array]]:
    """The boxes with one root, with its enclosure; and halves of those that are undecided."""
    wide = _WIDER * rad
    low, high = np.maximum(mid[:, 1] - wide[:, 1], 0.0), mid[:, 1] + wide[:, 1]  # no flight is shorter than 0
    place = np.stack([mid[:, 0], 0.5 * (low + high)], axis=1)
    wide = np.stack([wide[:, 0], 0.5 * (high - low)], axis=1)
    whole, values, noise = _looked_at(equations, place, wide)
    steep = _matrices([[ball.most for ball in row] for row in zip(whole.by_t, whole.by_h, strict=True)])
    reach = (steep @ wide[..., None])[..., 0] * (1.0 + 8.0 * UNIT) + noise
    empty = (np.abs(values) > reach * (1.0 + 8.0 * UNIT)).any(axis=1)
    empty |= ~whole.per_flight.may_vanish | ~whole.second.may_vanish
    root, error, one, none = _krawczyk(whole, values, noise, place, wide)
    one &= ~empty
    split = ~(empty | one | none)
    halves = _halved(mid[split], rad[split], steep[split])
    return _Enclosed(place[one], wide[one], root[one], error[one]), halves


def _looked_at(equations: PairEquations, mid: Array, rad: Array) -> tuple[Pairs, Array, Array]:
    """The equations over boxes, their values in the middle, and how inexact those are; shapes (B, 2)."""
    none = np.zeros(mid.shape[0])
    point = equations.over(Ball(mid[:, 0], none), Ball(mid[:, 1], none))
    values, noise = (np.stack(part, axis=1) for part in zip(*((b.mid, b.rad) for b in point[:2]), strict=True))
    return equations.over(Ball(mid[:, 0], rad[:, 0]), Ball(mid[:, 1], rad[:, 1])), values, noise


def _matrices(rows: list[list[Array]]) -> Array:
    return np.stack([np.stack(row, axis=1) for row in rows], axis=1)


def _krawczyk(
    whole: Pairs, values: Array, noise: Array, mid: Array, wide: Array
) -> tuple[Array, Array, npt.NDArray[np.bool_], npt.NDArray[np.bool_]]:
    """Krawczyk's operator m − AF(m) + (1 − AF')(X − m): its middle, its radius; whether it is inside, or elsewhere."""
    rows = list(zip(whole.by_t, whole.by_h, strict=True))
    matrix, spread = (_matrices([[getattr(ball, part) for ball in row] for row in rows]) for part in ("mid", "rad"))
    with np.errstate(all="ignore"):
        determinant = matrix[:, 0, 0] * matrix[:, 1, 1] - matrix[:, 0, 1] * matrix[:, 1, 0]
        usable = np.isfinite(determinant) & (determinant != 0.0)
        safe = np.where(usable, determinant, 1.0)
        turned = [[matrix[:, 1, 1], -matrix[:, 0, 1]], [-matrix[:, 1, 0], matrix[:, 0, 0]]]
        inverse = _matrices(turned) / safe[:, None, None]
        size = np.abs(inverse)
        away = np.abs(np.eye(2) - inverse @ matrix) + 8.0 * UNIT * (size @ np.abs(matrix) + 1.0) + size @ spread
        centre = mid - (inverse @ values[..., None])[..., 0]
        rounding = 8.0 * UNIT * (np.abs(mid) + (size @ np.abs(values)[..., None])[..., 0])
        error = (1.0 + 32.0 * UNIT) * ((size @ noise[..., None])[..., 0] + rounding + (away @ wide[..., None])[..., 0])
        off = np.abs(centre - mid) * (1.0 + 2.0 * UNIT)
        one = usable & (off + error < wide).all(axis=1)
        none = usable & (off - error > wide).any(axis=1)
    return centre, error, one, none


def _halved(mid: Array, rad: Array, steep: Array) -> tuple[Array, Array]:
    """Each box as two, cut where that narrows the equations most."""
    share = (steep / np.maximum(steep.max(axis=2, keepdims=True), 1e-300)).max(axis=1) * rad
    axis = np.where(share[:, 1] > share[:, 0], 1, 0)
    rows = np.arange(mid.shape[0])
    half = rad.copy()
    half[rows, axis] *= 0.5 * (1.0 + 4.0 * UNIT)
    ends = [mid.copy(), mid.copy()]
    for end, sign in zip(ends, (-1.0, 1.0), strict=True):
        end[rows, axis] += sign * half[rows, axis]
    return np.concatenate(ends), np.concatenate([half, half])


def _sharpened(equations: PairEquations, found: _Enclosed) -> _Enclosed:
    """The roots known better, by the same operator over what it gave."""
    for _ in range(_SHARPER if found.mid.size else 0):
        whole, values, noise = _looked_at(equations, found.root, found.error)
        better, narrower, _, _ = _krawczyk(whole, values, noise, found.root, found.error)
        use = np.all(narrower < found.error, axis=1, keepdims=True)
        found = found._replace(root=np.where(use, better, found.root), error=np.where(use, narrower, found.error))
    return found
