"""An oracle for the first contact of an elastic bar in flight: ball arithmetic, interval root isolation, no scan.

Between impacts the modes n = 0..N obey ``u_n'' + d u_n' + (n pi s)^2 u_n = p(t)`` and the gap function is
``y = u_0 + 2 sum (-1)^n u_n``; or each elastic mode has a frequency, a damping and a weight of its own. In closed form
y is a polynomial plus a sum of exponentials, on each stretch over which the load is one formula:

    y(t) = P(t) + Re sum_j c_j exp(lambda_j t),    Re lambda_j <= 0,   t counted from the start of the stretch.

The coefficients come from `flint.arb`, so each is a ball that holds the true number. The search then goes in two tiers:

1. floats screen. An interval of half-width r about c is judged by y(c), y'(c) and a bound on |y''|, with the rounding
   errors of every step bounded and added. Terms too fast for r are not evaluated but bounded by their amplitude.
   An interval is done when y < 0 on it, or when y falls on it (then y < 0 at its left end is enough); what is neither
   is cut into equal parts, the earliest first, many at once.
2. balls decide what is left: an interval on which y rises and may cross zero (interval Newton), and the
   neighbourhood of an extremum too near zero for floats (sign of y'', then the extremum itself).

Flights that are long, or quick at first and slow later, are cut by eight from the whole on, and the terms that an
interval resolves are evaluated there anew. A mode so near critical damping that its two exponentials all but cancel is
``e^{-dt/2} (A cosh kt + B sinh kt / k)`` to the floats, two exponentials to the balls.

Nothing here is shared with the package: it must not be imported.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import Any, NamedTuple

import flint
import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]

__all__ = ["KINDS", "Contact", "Flight", "Undecided", "first_contact", "gap", "random_flight"]

_U = 2.0**-53  # half an ulp of 1
_PARTS = 8  # an undecided interval is cut into so many
_FAST = 1.4  # a term with |lambda| r above this is bounded by its amplitude, not evaluated
_PRECISIONS = (128, 256, 512, 1024)
_CLOSE = 0.04  # a mode with |k| below this part of d/2 is near critical damping
_MANY = 240  # more intervals than this to begin with, and the cuts begin at the whole
_TURNS = 10_000  # intervals the balls look at alone, in one stretch, before the search gives up
_SHARP = 1e-17  # the radius to which a contact time is refined


class Undecided(ArithmeticError):
    """The precision at hand did not decide a sign; `first_contact` answers by raising the precision."""


@dataclass(frozen=True)
class Flight:
    """A flight: the bar, the load and the state of the modes at its start, all floats taken as exact numbers.

    The load is ``Re sum_k coefficients[k] exp(ikt)``, or, with no coefficients, ``values[j]`` from ``breaks[j]`` to the
    next break, periodically; ``time`` is the load's time t at the start of the flight. ``modes`` are rows (omega_n,
    d_n, gamma_n) of elastic modes unlike those of a uniform bar; d is the rigid motion's then.
    """

    s: float
    d: float
    coefficients: tuple[complex, ...]
    breaks: tuple[float, ...]
    values: tuple[float, ...]
    time: float
    displacement: Floats = field(repr=False)
    velocity: Floats = field(repr=False)
    modes: tuple[tuple[float, float, float], ...] = ()


@dataclass(frozen=True)
class Contact:
    """What ends a flight: the flight time, the radius of the ball about it, the speed y' there, and the kind.

    ``contact``: y < 0 on (0, time - radius), and y crosses to positive, with slope ``speed``, within ``radius`` of
    ``time``. ``graze``: the first event is a local maximum with |y| <= tolerance, at ``time`` (whether it is just
    above or just below the wall is not told). ``none``: y < 0 up to the horizon, which is then ``time``.
    """

    time: float
    radius: float
    speed: float
    kind: str


# --------------------------------------------------------------------------------------------- the closed form, balls


class _Stretch:
    """The closed form of all modes, and of y, over a stretch of flight with one formula for the load.

    ``terms`` are (c, lambda, mode) with y's weights 1, 2(-1)^n left out of c; the polynomial is mode 0's alone, and
    ``rest`` bounds what its truncation leaves of y, y', y'' on [0, length].
    """

    def __init__(self, modes: _Modes, constant: Any, length: float, state: tuple[list[Any], list[Any]],
                 forced: tuple[list[Any], list[Any], list[Any], list[Any]], shift: Any) -> None:  # fmt: skip
        u, v = state
        arb, acb = flint.arb, flint.acb
        start, slope, amplitudes, rates = forced
        omega2, damping, weights = modes
        d, self.length = damping[0], length
        # mode 0 under the constant part of the load
        x, w = u[0] - start[0], v[0] - slope[0]
        self.rest = (arb(0), arb(0), arb(0))
        mode_terms: list[list[tuple[Any, Any]]] = [[]]
        self.near: dict[int, tuple[Any, Any, Any, Any]] = {}  # modes near critical damping: A, B, -k^2 and d/2
        span = arb(length) + 1
        if d == 0:
            self.poly = [x, w, constant / 2]
        elif d * span < 0.0625:
            scale = abs(w) * d + abs(constant)
            self.poly, m, factorial, power = [x, w], 1, 1, arb(1)
            tail = arb(1)
            small = arb(2) ** (-flint.ctx.prec)
            while not (tail < small):
                m += 1
                factorial *= m
                self.poly.append((constant - w * d) * power / factorial)  # (-d)^(m-2) (p - d v) / m!
                power *= -d
                tail *= d * span / (m - 1)
            r2 = (2 * scale * tail).abs_upper()
            self.rest = (arb(0, (r2 * span**2).abs_upper()), arb(0, (r2 * span).abs_upper()), arb(0, r2))
        else:
            drift = constant / d
            c = (drift - w) / d
            self.poly = [x - c, drift]
            mode_terms[0].append((acb(c), acb(-d)))
        for n in range(1, len(u)):
            half = damping[n] / 2
            quarter = half * half
            x, w = u[n] - start[n], v[n] - slope[n]
            discriminant = omega2[n] - quarter
            if abs(discriminant) < _CLOSE**2 * quarter:
                self.near[n] = (weights[n] * x, weights[n] * (w + half * x), discriminant, half)
            if discriminant > 0:
                root = discriminant.sqrt()
                mode_terms.append([(acb(x, -(w + half * x) / root), acb(-half, root))])
            elif discriminant < 0:
                root = (-discriminant).sqrt()
                quick = -half - root
                slow = omega2[n] / quick
                over = 1 / (2 * root)
                mode_terms.append([(acb((w - quick * x) * over), acb(slow)), (acb((slow * x - w) * over), acb(quick))])
            else:
                raise Undecided("a mode near critical damping")
        self.mode_terms = mode_terms
        self.still = start
        c_all: list[Any] = list(amplitudes)
        lam_all: list[Any] = list(rates)
        self.plain = [True] * len(c_all)
        for n, terms in enumerate(mode_terms):
            for c, lam in terms:
                self.plain.append(n not in self.near)
                c_all.append(c * weights[n])
                lam_all.append(lam)
        self.gap_poly = list(self.poly)
        for a in shift:
            self.gap_poly[0] = self.gap_poly[0] + a
        self.c, self.lam = c_all, lam_all
        self._columns: Any = None

    def at(self, t: Any) -> tuple[Any, Any, Any]:
        """y, y' and y'' at the local time t."""
        if self._columns is None:
            entries: list[Any] = []
            for c, lam in zip(self.c, self.lam, strict=True):
                first = c * lam
                entries += [c, first, first * lam]
            self._columns = flint.acb_mat(len(self.c), 3, entries)
        y, y1, y2 = self.rest
        p0, p1, p2 = flint.arb(0), flint.arb(0), flint.arb(0)
        for a in reversed(self.gap_poly):
            p2 = p2 * t + 2 * p1
            p1 = p1 * t + p0
            p0 = p0 * t + a
        y, y1, y2 = y + p0, y1 + p1, y2 + p2
        if self.c:
            product = flint.acb_mat(1, len(self.c), [(lam * t).exp() for lam in self.lam]) * self._columns
            y, y1, y2 = y + product[0, 0].real, y1 + product[0, 1].real, y2 + product[0, 2].real
        return y, y1, y2

    def state(self, t: Any) -> tuple[list[Any], list[Any]]:
        """Displacement and velocity of the modes at the local time t (constant load only)."""
        u, v = [], []
        for n, terms in enumerate(self.mode_terms):
            x, w = flint.arb(self.still[n]), flint.arb(0)
            for c, lam in terms:
                e = c * (lam * t).exp()
                x, w = x + e.real, w + (e * lam).real
            if n == 0:
                p0, p1 = flint.arb(0), flint.arb(0)
                for a in reversed(self.poly):
                    p1 = p1 * t + p0
                    p0 = p0 * t + a
                x, w = x + p0 + self.rest[0], w + p1 + self.rest[1]
            u.append(x)
            v.append(w)
        return u, v


class _Modes(NamedTuple):
    """Squares of the frequencies, dampings, and weights in the gap, from the rigid motion up, as balls."""

    omega2: list[Any]
    damping: list[Any]
    weights: list[Any]

    @classmethod
    def of(cls, flight: Flight) -> _Modes:
        arb, count = flint.arb, len(flight.displacement)
        if flight.modes:
            omega, damping, weights = ([arb(float(x)) for x in column] for column in zip(*flight.modes, strict=True))
            return cls([arb(0), *(w * w for w in omega)], [arb(flight.d), *damping], [arb(1), *weights])
        base = (arb.pi() * arb(flight.s)) ** 2
        weights = [1] + [2 if n % 2 == 0 else -2 for n in range(1, count)]
        return cls([base * (n * n) for n in range(count)], [arb(flight.d)] * count, weights)


def _stretches(flight: Flight, horizon: float, on_wall: bool) -> Iterator[tuple[Any, float, _Stretch]]:
    """The stretches of the flight up to the horizon: start (a ball), length (a float, rounded up), closed form."""
    arb, acb = flint.arb, flint.acb
    u = [arb(float(x)) for x in flight.displacement]
    v = [arb(float(x)) for x in flight.velocity]
    count = len(u)
    modes = _Modes.of(flight)
    omega2, damping, weights = modes
    shift = []
    if on_wall:
        total = arb(0)
        for x, w in zip(u, weights, strict=True):
            total = total + x * w
        shift = [-total]
    zero = [arb(0)] * count
    if flight.coefficients:
        p = [acb(complex(x)) for x in flight.coefficients]
        constant = p[0].real
        ks = [k for k in range(1, len(p)) if flight.coefficients[k] != 0]
        if all(d == 0 for d in damping):
            inverse: list[Any] = [1 / (om - k * k) for om in omega2 for k in ks]
        else:
            inverse = [1 / acb(om - k * k, d * k) for om, d in zip(omega2, damping, strict=True) for k in ks]
        start, slope = list(zero), list(zero)
        amplitudes: list[Any] = []
        if ks:
            phased = [p[k] * acb(0, arb(flight.time) * k).exp() for k in ks]
            table = flint.acb_mat(count, len(ks), inverse)
            pair = [x for k, g in zip(ks, phased, strict=True) for x in (g, g * acb(0, k))]
            first = table * flint.acb_mat(len(ks), 2, pair)
            start = [first[n, 0].real for n in range(count)]
            slope = [first[n, 1].real for n in range(count)]
            summed = flint.acb_mat(1, count, weights) * table
            amplitudes = [g * summed[0, i] for i, g in enumerate(phased)]
        # the constant part moves the elastic modes' rest positions, whose sum joins y's polynomial
        for n in range(1, count):
            rest = constant / omega2[n]
            start[n] = start[n] + rest
            shift.append(rest * weights[n])
        forced = (start, slope, amplitudes, [acb(0, k) for k in ks])
        yield arb(0), horizon, _Stretch(modes, constant, horizon, (u, v), forced, shift)
        return
    here = arb(0)
    for begin, end, value in _steps(flight, horizon):
        length = float((end - begin).abs_upper()) * (1 + 4 * _U)
        constant = arb(value)
        start = [arb(0)] + [constant / omega2[n] for n in range(1, count)]
        moved = shift + [start[n] * weights[n] for n in range(1, count)]
        stretch = _Stretch(modes, constant, length, (u, v), (start, zero, [], []), moved)
        here = begin
        yield here, length, stretch
        u, v = stretch.state(end - begin)


def _steps(flight: Flight, horizon: float) -> Iterator[tuple[Any, Any, float]]:
    """The stretches of constant load: begin and end in flight time (balls), and the load there."""
    arb = flint.arb
    time, turn = arb(flight.time), 2 * arb.pi()
    count = len(flight.breaks)
    lap = math.floor((flight.time - flight.breaks[0]) / (2 * math.pi)) - 1
    index = 0
    while True:  # the last break not after the start
        following = index + 1
        at = arb(flight.breaks[following % count]) + turn * (lap + following // count) - time
        if at > 0:
            break
        exact = lap + following // count == 0 and flight.breaks[following % count] == flight.time
        if not (at < 0 or exact):
            raise Undecided("a break at the start")
        index, lap = following % count, lap + following // count
    begin = arb(0)
    while True:
        value = flight.values[index]
        index, lap = (index + 1) % count, lap + (index + 1) // count
        end = arb(flight.breaks[index]) + turn * lap - time
        if not (end < horizon):
            yield begin, arb(horizon), value
            return
        yield begin, end, value
        begin = end


# ------------------------------------------------------------------------------------------------ the screen, floats


class _Pair:
    """``e^{-ht} (A C + B S)``, C = cosh kt and S = sinh kt / k, or cos and sin where k^2 < 0; in floats."""

    def __init__(self, a: float, b: float, half: float, minus_k2: float) -> None:
        self.half, self.root = half, math.sqrt(abs(minus_k2))
        self.turns = minus_k2 > 0.0
        self.slow = half if self.turns else half - self.root  # k is far below h: nothing cancels
        self.ab = [(a, b)]
        for _ in range(3):  # the derivatives have the same form
            a, b = b - half * a, -half * b - minus_k2 * a
            self.ab.append((a, b))

    def value(self, order: int, t: Floats) -> Floats:
        a, b = self.ab[order]
        fade, angle = np.exp(-self.slow * t), self.root * t
        if self.turns:
            return np.asarray(fade * (a * np.cos(angle) + b * np.sin(angle) / self.root))
        reach = -np.expm1(-2.0 * angle) / (2.0 * self.root)
        return np.asarray(fade * (0.5 * a * (1.0 + np.exp(-2.0 * angle)) + b * reach))

    def most(self, order: int, t: Any) -> Any:
        """A bound on the magnitude of a derivative from t on: C <= 1 and S <= t but for the slower decay."""
        a, b = self.ab[order]
        rounding = 16 * _U * self.half**order * (abs(self.ab[0][0]) * self.half + abs(self.ab[0][1])) / self.half
        at = np.maximum(t, 1.0 / self.slow)
        size, push = abs(a) + rounding, abs(b) + rounding * self.half
        return size * np.exp(-self.slow * t) + push * at * np.exp(-self.slow * at)


class _Screen:
    """The closed form in floats, with a bound on everything the floats leave out."""

    def __init__(self, stretch: _Stretch, tolerance: float) -> None:
        length = stretch.length
        terms = [(c, lam) for c, lam, plain in zip(stretch.c, stretch.lam, stretch.plain, strict=True) if plain]
        c = np.array([complex(x) for x, _ in terms], dtype=complex)
        lam = np.array([complex(x) for _, x in terms], dtype=complex)
        blur = math.fsum(float(x.rad()) for x, _ in terms) * 1.01
        fuzz = max((float(x.rad()) / (1e-300 + abs(complex(x))) for _, x in terms), default=0.0)
        if fuzz > 1e-17:
            raise Undecided("rates too blurred for the screen")
        order = np.argsort(np.abs(lam), kind="stable")
        self.c, self.lam = c[order], lam[order]
        size, rate = np.abs(self.c) * (1 + 8 * _U), np.abs(self.lam) * (1 + 8 * _U)
        self.size, self.rate = size, rate
        # the polynomial: cut where its terms no longer count
        span = length * 1.0001 + 1e-9
        poly = [float(a) for a in stretch.gap_poly]
        sums = [0.0, 0.0, 0.0]
        keep = 1
        for m, a in enumerate(poly):
            weight = abs(a) * span**m
            sums[0] += weight
            sums[1] += m * weight / span
            sums[2] += m * (m - 1) * weight / span**2
            if a != 0.0 and weight * m * m > 1e-19 * sums[0]:
                keep = m + 1
        lost0 = sum(abs(a) * span**m for m, a in enumerate(poly) if m >= keep)
        lost1 = sum(m * abs(a) * span ** (m - 1) for m, a in enumerate(poly) if m >= keep)
        blur += math.fsum(float(a.rad()) * span**m for m, a in enumerate(stretch.gap_poly))
        blur1 = math.fsum(m * float(a.rad()) * span ** (m - 1) for m, a in enumerate(stretch.gap_poly) if m)
        self.poly = poly[:keep]
        self.poly2 = 1.0001 * (sums[2] + float(stretch.rest[2].abs_upper())) + 1e-200
        cubic = sum(m * (m - 1) * (m - 2) * abs(a) * span ** (m - 3) for m, a in enumerate(poly) if m > 2)
        self.poly3 = 1.0001 * (cubic + float(stretch.rest[2].abs_upper())) + 1e-200
        # each exponential: phase error |lambda| t while it lasts, some roundings per level, and the sum of the products
        lasts = np.minimum(span, 1.0 / np.maximum(-self.lam.real, 1e-300))
        relative = _U * (12 * rate * lasts + 8 * len(c) + 600)
        self.e0 = 1.01 * (float(size @ relative) + 32 * _U * len(poly) * sums[0] + lost0 + blur) + 1e-290
        self.e1 = 1.01 * (float((size * rate) @ relative) + 32 * _U * len(poly) * sums[1] + lost1 + blur1) + 1e-290
        self.e0 += float(stretch.rest[0].abs_upper())
        self.e1 += float(stretch.rest[1].abs_upper()) + blur * float(rate.max(initial=0.0))
        self.pairs = [_Pair(float(a), float(b), float(half), float(k2)) for a, b, k2, half in stretch.near.values()]
        for pair, balls in zip(self.pairs, stretch.near.values(), strict=True):
            if float(balls[2].rad()) > 1e-16 * abs(float(balls[2])):
                raise Undecided("critical damping too blurred for the screen")
            self.e0 += (8 * len(c) + 600) * _U * pair.most(0, 0.0) + float(balls[0].rad()) + float(balls[1].rad())
            self.e1 += (8 * len(c) + 600) * _U * pair.most(1, 0.0) + pair.half * float(balls[0].rad() + balls[1].rad())
        self.length, self.tolerance = length, tolerance
        self.turns = 0
        self.slack = 64 * _U * length
        # decay: terms in groups of one real part
        self.real, group = np.unique(self.lam.real, return_inverse=True)
        self.steady = self.real.size == 0 or (self.real.size == 1 and self.real[0] == 0.0)
        self.group = np.zeros((self.lam.size, self.real.size))
        self.group[np.arange(self.lam.size), group] = 1.0
        quickest = float(-self.real[0]) if self.real.size else 0.0
        count = math.ceil(length / min(0.25, 30 / (quickest + 1e-9)))
        self.direct = count > _MANY or bool(self.pairs)
        self.roots = _PARTS if self.direct else max(count, 4)
        self.half = [length / (2 * self.roots)]
        self._levels: dict[int, tuple[Any, ...]] = {}

    def level(self, number: int) -> tuple[Any, ...]:
        """What all intervals of a level share: r, the evaluated terms, the offsets from the parent, the bounds."""
        if number not in self._levels:
            while len(self.half) <= number:
                self.half.append(self.half[-1] / _PARTS)
            r = self.half[number]
            low = int(np.searchsorted(self.rate * r, _FAST))
            offset = (2 * np.arange(_PARTS) + 1 - _PARTS) * r
            carries = number > 0 and not self.direct
            turn = np.exp(np.outer(self.lam, offset)) if carries else np.ones((self.lam.size, 1), dtype=complex)
            part, slope = turn[:low], self.lam[:low, None] * turn[:low]
            gemm = np.block([[part.real, slope.real], [-part.imag, -slope.imag]]) if low else np.zeros((0, 0))
            size, rate = self.size.copy(), self.rate
            bound = np.empty((3, self.lam.size))
            bound[0] = np.where(np.arange(size.size) < low, size * rate**2, 0.0)  # |y''|, evaluated terms
            bound[1] = np.where(np.arange(size.size) < low, 0.0, size)  # |y|, the others
            bound[2] = np.where(np.arange(size.size) < low, 0.0, size * rate)  # |y'|, the others
            self._levels[number] = (r, low, offset, turn, gemm, (bound @ self.group) * (1 + 1e-9))
        return self._levels[number]

    def bounds(self, number: int, left: Floats) -> tuple[Any, Any, Any]:
        """On intervals of a level: of |y''| of what is evaluated there, and of |y| and |y'| of what is not."""
        r, _, _, _, _, bound = self.level(number)
        m2, a0, a1 = bound @ (np.exp(np.outer(self.real, left)) * (1 + 1e-9))
        for pair in self.pairs:
            if pair.half * r < _FAST:
                m2 = m2 + pair.most(2, left)
            else:
                a0, a1 = a0 + pair.most(0, left), a1 + pair.most(1, left)
        return m2, a0, a1

    def values(self, number: int, t: Floats) -> tuple[Any, Any]:
        """y and y' at times, of what a level evaluates."""
        r, low, _, _, _, _ = self.level(number)
        p0, p1 = self.polynomial(t)
        if low:
            e = np.exp(np.outer(t, self.lam[:low])) * self.c[:low]
            p0, p1 = p0 + e.real.sum(axis=1), p1 + (e @ self.lam[:low]).real
        for pair in self.pairs:
            if pair.half * r < _FAST:
                p0, p1 = p0 + pair.value(0, t), p1 + pair.value(1, t)
        return p0, p1

    def polynomial(self, t: Floats) -> tuple[Any, Any]:
        p0: Any = np.zeros_like(t)
        p1: Any = np.zeros_like(t)
        for a in reversed(self.poly):
            p1 = p1 * t + p0
            p0 = p0 * t + a
        return p0, p1

    def point(self, t: float) -> tuple[float, float]:
        """y and y' at a time, in floats."""
        e = self.c * np.exp(self.lam * t)
        p0, p1 = self.polynomial(np.array(t))
        for pair in self.pairs:
            p0, p1 = p0 + pair.value(0, np.array(t)), p1 + pair.value(1, np.array(t))
        return float(p0 + e.real.sum()), float(p1 + (e * self.lam).real.sum())

    def second(self, t: float) -> float:
        """A bound on |y''| from the time t on (t may be negative by a rounding)."""
        decay = np.exp(np.minimum(self.lam.real * max(t, 0.0), 0.0))
        pairs = sum(float(pair.most(2, max(t, 0.0))) for pair in self.pairs)
        return (float((self.size * self.rate**2) @ decay) + pairs) * 1.0001 + self.poly2

    def third(self, t: float) -> float:
        """A bound on |y'''| from the time t on."""
        decay = np.exp(np.minimum(self.lam.real * max(t, 0.0), 0.0))
        pairs = sum(float(pair.most(3, max(t, 0.0))) for pair in self.pairs)
        return (float((self.size * self.rate**3) @ decay) + pairs) * 1.0001 + self.poly3


_SPLIT, _RISING, _FLOOR = 1, 2, 3


@dataclass
class _Batch:
    """Intervals of one level still to be cut (kind split), or one interval (kind rising or floor) for the balls."""

    kind: int
    level: int
    centre: Floats
    carried: Complexes | None
    low: float = 0.0
    high: float = 0.0
    slope: float = 0.0


def _judge(screen: _Screen, number: int, centre: Floats, y: Floats, y1: Floats) -> tuple[Any, ...]:
    """The verdict on each interval: 0 done, else split, rising or floor; and the count that matters."""
    r, _, _, _, _, bound = screen.level(number)
    r = r * (1 + 1e-9) + screen.slack
    if screen.steady and not screen.pairs:
        m2, a0, a1 = (bound[i].sum() for i in range(3))
    else:
        m2, a0, a1 = screen.bounds(number, np.maximum(centre - r, 0.0))
    m2 = (m2 + screen.poly2) * 1.0001
    e0, e1 = screen.e0 + a0, screen.e1 + a1
    swing = (m2 * r + e1) * (1 + 1e-12)
    bend = (0.5 * m2 * r * r + e0) * (1 + 1e-12)
    steep = np.abs(y1)
    top = y + steep * r + bend + 1e-15 * (np.abs(y) + steep * r)
    rising = y1 > swing
    falling = y1 < -swing
    done = (top < -screen.tolerance) | falling | (rising & (top < 0.0))
    verdict = np.where(done, 0, np.where(rising, _RISING, _SPLIT))
    deep = m2 * r * r + a0 + a1 * r < 4 * (screen.e0 + screen.tolerance)
    verdict[(verdict == _SPLIT) & (deep | (r < 1e-12 * screen.length))] = _FLOOR
    above = np.flatnonzero(y > e0)
    stop = int(above[0]) + 1 if above.size else centre.size
    return verdict[:stop], bool(above.size), y1 - swing, r


def _gather(screen: _Screen, number: int, centre: Floats, y: Floats, y1: Floats,
            carry: Callable[[Any], Any]) -> tuple[list[_Batch], bool]:  # fmt: skip
    """What is left of the intervals just judged, earliest first, in runs of one kind; and whether y > 0 was seen."""
    verdict, cut, slope, r = _judge(screen, number, centre, y, y1)
    kept = np.flatnonzero(verdict)
    out: list[_Batch] = []
    if not kept.size:
        return out, cut
    kinds = verdict[kept]
    step = (np.diff(kinds) != 0) | ((kinds[1:] != _SPLIT) & (np.diff(kept) > 1))
    edges = [0, *(np.flatnonzero(step) + 1).tolist(), kept.size]
    for i, j in pairwise(edges):
        run = kept[i:j]
        if kinds[i] == _SPLIT:
            out.append(_Batch(_SPLIT, number, centre[run], carry(run)))
        else:
            low, high = float(centre[run[0]] - r), float(centre[run[-1]] + r)
            out.append(_Batch(int(kinds[i]), number, centre[run], None, low, high, float(slope[run].min())))
    return out, cut


def _search(stretch: _Stretch, begin: Any, horizon: float, tolerance: float) -> Contact | None:
    """The first contact or graze on a stretch, or None."""
    screen = _Screen(stretch, tolerance)
    r, low, _, _, gemm, _ = screen.level(0)
    centre = (2 * np.arange(screen.roots) + 1) * r
    if screen.direct:
        p0, p1 = screen.values(0, centre)
        found, crossed = _gather(screen, 0, centre, p0, p1, lambda run: None)
    else:
        carried = screen.c * np.exp(np.outer(centre, screen.lam))
        p0, p1 = screen.polynomial(centre)
        if low:
            value = np.concatenate((carried.real[:, :low], carried.imag[:, :low]), axis=1) @ gemm
            p0, p1 = p0 + value[:, 0], p1 + value[:, 1]
        found, crossed = _gather(screen, 0, centre, p0, p1, lambda run: carried[run])
    stack = found[::-1]
    take = 8
    while stack:
        batch = stack.pop()
        if batch.kind == _RISING:
            contact = _rise(stretch, screen, batch.low, batch.high, batch.slope, begin, horizon)
            if contact is not None:
                return contact
            continue  # y < 0 to its end, or the crossing lies past the end of the stretch
        if batch.kind == _FLOOR:
            contact = _turn(stretch, screen, batch.low, batch.high, begin, horizon, 0)
            if contact is not None:
                return contact
            continue
        parents: Any = batch.carried
        if batch.centre.size > take:
            rest, some = (None, None) if parents is None else (parents[take:], parents[:take])
            stack.append(_Batch(_SPLIT, batch.level, batch.centre[take:], rest))
            batch, parents = _Batch(_SPLIT, batch.level, batch.centre[:take], some), some
            take = min(2 * take, 256)
        number = batch.level + 1
        r, low, offset, turn, gemm, _ = screen.level(number)
        times = (batch.centre[:, None] + offset).ravel()
        if screen.direct:
            p0, p1 = screen.values(number, times)
            found, cut = _gather(screen, number, times, p0, p1, lambda run: None)
            if cut:
                stack.clear()
                crossed = True
            stack.extend(found[::-1])
            continue
        p0, p1 = screen.polynomial(times)
        if low:
            value = np.concatenate((parents.real[:, :low], parents.imag[:, :low]), axis=1) @ gemm
            p0 = p0 + value[:, :_PARTS].ravel()
            p1 = p1 + value[:, _PARTS:].ravel()
        flipped = turn.T

        def carry(run: Any, parents: Any = parents, flipped: Any = flipped) -> Any:
            return parents[run // _PARTS] * flipped[run % _PARTS]

        found, cut = _gather(screen, number, times, p0, p1, carry)
        if cut:
            stack.clear()
            crossed = True
        stack.extend(found[::-1])
    if crossed:
        raise AssertionError("y > 0 was seen, and no contact before it was found")
    return None


# ------------------------------------------------------------------------------------------------------ balls decide


def _answer(begin: Any, local: Any, speed: Any, kind: str, horizon: float) -> Contact | None:
    """A contact at a local time, or None where it lies past the horizon."""
    time = begin + local
    if time > horizon:
        return None
    middle = float(time.mid())
    radius = float((time - middle).abs_upper()) * (1 + 4 * _U)
    return Contact(middle, radius, float(speed.mid()), kind)


def _rise(stretch: _Stretch, screen: _Screen, low: float, high: float, slope: float, begin: Any,
          horizon: float) -> Contact | None:  # fmt: skip
    """The crossing on an interval on which y' >= slope > 0 is proved, or None if y stays below zero there."""
    arb = flint.arb
    guess = 0.5 * (low + high)
    for _ in range(8):
        y, y1 = screen.point(guess)
        move = y / max(y1, slope)
        guess = min(max(guess - move, low), high)
        if abs(move) <= 4 * _U * high + 1e-300 or abs(y) < screen.e0 / 64:
            break
    second = screen.second(low)
    least = arb(slope)
    left, right = arb(low), arb(high)
    below = above = False  # is y < 0 at left, y > 0 at right, known from balls?
    t = arb(guess)
    for _ in range(200):
        y, y1, y2 = stretch.at(t)
        if y < 0 and not (t < left):
            left, below = t, True
        elif y > 0 and not (t > right):
            right, above = t, True
        reach = (y / least).abs_upper()
        # y' between t and the crossing, which is within reach of t if it is in the interval at all
        root = t - y / (y1 + arb(0, (second * reach).abs_upper())).max(least)
        near = arb((root - 1e-25).lower()), arb((root + 1e-25).upper())
        if float(root.rad()) <= _SHARP and near[0] > low and near[1] < high:
            wide = t - reach > low and t + reach < high
            if wide or (below and above) or (stretch.at(near[0])[0] < 0 and stretch.at(near[1])[0] > 0):
                if root > stretch.length:
                    return None
                speed = y1 + y2 * (root - t)
                if float(speed.mid()) ** 2 < 4 * second * screen.tolerance:
                    summit = _summit(stretch, screen, root, begin, horizon)
                    if summit is not None:
                        return summit
                return _answer(begin, root, speed, "contact", horizon)
        new = arb((t - y / y1).mid())
        if not (new < right) and not above:
            if stretch.at(right)[0] < 0:
                return None
            above = bool(stretch.at(right)[0] > 0)
        if not (new > left) and not below:
            below = bool(stretch.at(left)[0] < 0)
            if stretch.at(left)[0] > 0:
                raise AssertionError("y > 0 before the interval: the search missed a contact")
        if not (left < new < right):
            new = arb(((left + right) / 2).mid())
        t = new
    raise Undecided("no sharp crossing")


def _summit(stretch: _Stretch, screen: _Screen, root: Any, begin: Any, horizon: float) -> Contact | None:
    """The summit just after a slow crossing, if y provably turns there within the tolerance: a graze."""
    start = t = flint.arb(root.mid())
    for _ in range(60):
        _, y1, y2 = stretch.at(t)
        if not (y2 < 0):
            return None
        new = flint.arb((t - y1 / y2).mid())
        if abs(new - t) < 1e-22:
            break
        t = new
    y, y1, y2 = stretch.at(t)
    span = t - start
    if not (span > 0 and t < stretch.length and y2 + screen.third(float(start)) * span < 0):
        return None
    return _answer(begin, t, y1, "graze", horizon) if y <= screen.tolerance else None


def _turn(stretch: _Stretch, screen: _Screen, low: float, high: float, begin: Any, horizon: float,
          depth: int) -> Contact | None:  # fmt: skip
    """The first contact or graze on a short interval about an extremum near zero, y <= 0 being known at its start."""
    arb = flint.arb
    low, high = max(low, 0.0), min(high, screen.length)
    if not low < high:
        return None
    screen.turns += 1
    if screen.turns > _TURNS:
        raise ArithmeticError("too near resonance for the screen in floats")
    mid = 0.5 * (low + high)
    half = max(high - mid, mid - low)
    y, y1, y2 = stretch.at(arb(mid))
    third = screen.third(low)
    bend = y2 + arb(0, third * half)
    speed = y1 + arb(0, (abs(bend) * half).abs_upper())
    if speed < 0 or y + abs(speed) * half < -screen.tolerance:
        return None
    if speed > 0:
        slope = float(speed.abs_lower()) * (1 - 4 * _U)
        return None if stretch.at(arb(high))[0] < 0 else _rise(stretch, screen, low, high, slope, begin, horizon)
    if bend > 0:  # convex: the larger end decides
        if stretch.at(arb(high))[0] < 0:
            return None
    elif bend < 0:
        if stretch.at(arb(low))[1] < 0:
            return None
        slope = float((-bend).abs_lower())
        t = arb(mid)
        for _ in range(60):  # Newton on y' for the summit
            y, y1, y2 = stretch.at(t)
            step = y1 / y2
            new = arb((t - step).mid())
            new = arb(low) if not (new > low) else arb(high) if not (new < high) else new
            if abs(new - t) < 1e-22:
                break
            t = new
        y, y1, _ = stretch.at(t)
        top = y + arb(0, (y1 * y1 / slope).abs_upper())
        edge = stretch.at(arb(high))[1]
        if edge > 0:  # y' > 0 throughout
            if stretch.at(arb(high))[0] < 0:
                return None
            top = arb(1)
            t = arb(high)
        if abs(top) <= screen.tolerance:
            return _answer(begin, t, y1, "graze", horizon)
        if top < 0:
            return None
        if top > 0:
            return _climb(stretch, arb(low), t, begin, horizon)
    if depth > 60 or half < 1e-17 * (1 + high):
        # as good as a point: a summit too flat for the sign of y'', unless the balls are merely too wide
        if abs(y + speed * arb(0, half)) <= screen.tolerance and abs(speed) < 1e-9:
            return _answer(begin, arb(mid), y1, "graze", horizon)
        raise Undecided("the shape of y beside an extremum")
    for a, b in ((low, mid), (mid, high)):
        contact = _turn(stretch, screen, a, b, begin, horizon, depth + 1)
        if contact is not None:
            return contact
    return None


def _climb(stretch: _Stretch, low: Any, high: Any, begin: Any, horizon: float) -> Contact | None:
    """The crossing between low, y < 0, and high, y > 0, on which y is concave: Newton from the left stays left."""
    arb = flint.arb
    if not (stretch.at(low)[0] < 0):
        raise Undecided("the sign at the left end")
    t = low
    for _ in range(200):
        y, y1, _ = stretch.at(t)
        if not (y < 0 and y1 > 0):
            break
        step = arb((-y / y1).mid())
        t = t + step
        if step < 1e-20:
            break
    for reach in (1e-18, 1e-17, 1e-16, 1e-15):
        before, after = arb(t.mid()) - reach, arb(t.mid()) + reach
        before = before if before > low else low
        after = after if after < high else high
        if stretch.at(before)[0] < 0 and stretch.at(after)[0] > 0:
            return _answer(begin, arb(t.mid(), reach), stretch.at(t)[1], "contact", horizon)
    raise Undecided("a crossing beside a summit")


def first_contact(flight: Flight, horizon: float, on_wall: bool = False, tolerance: float = 1e-13) -> Contact:
    """The first flight time in (0, horizon] at which y crosses zero upwards, proved.

    ``on_wall``: y(0) is taken as exactly 0 (the computed y(0) is subtracted from y), and y'(0) must be negative.
    A local maximum within ``tolerance`` of zero that comes first, above or below, is a ``graze``.

    `ValueError` where the flight does not start as told; `Undecided` where 1024 bits do not decide (a summit at zero
    to 200 digits, with tolerance 0); `ArithmeticError` where the floats see nothing and the balls would take too long
    (resonance within about 1e-9, relative).
    """
    precision = flint.ctx.prec
    try:
        for bits in _PRECISIONS:
            flint.ctx.prec = bits
            try:
                return _fly(flight, horizon, on_wall, tolerance)
            except Undecided:
                if bits == _PRECISIONS[-1]:
                    raise
    finally:
        flint.ctx.prec = precision
    raise AssertionError


def _fly(flight: Flight, horizon: float, on_wall: bool, tolerance: float) -> Contact:
    first = True
    for begin, _, stretch in _stretches(flight, horizon, on_wall):
        if first:
            y, y1, _ = stretch.at(flint.arb(0))
            if on_wall and not (y1 < 0):
                raise ValueError("a flight from the wall must leave it: y'(0) < 0")
            if not on_wall and not (y < 0):
                raise ValueError("a flight must start away from the wall: y(0) < 0")
            first = False
        contact = _search(stretch, begin, horizon, tolerance)
        if contact is not None:
            return contact
    return Contact(horizon, 0.0, math.nan, "none")


def gap(flight: Flight, time: float, on_wall: bool = False) -> tuple[float, float, float]:
    """y, y' and y'' at a flight time, each rounded from a ball."""
    precision = flint.ctx.prec
    try:
        flint.ctx.prec = _PRECISIONS[0]
        value: tuple[Any, Any, Any] | None = None
        for begin, _, stretch in _stretches(flight, max(time, 1e-9), on_wall):
            value = stretch.at(flint.arb(time) - begin)
        assert value is not None
        return float(value[0]), float(value[1]), float(value[2])
    finally:
        flint.ctx.prec = precision


# -------------------------------------------------------------------------------------------------- flights to try

KINDS = ("steady", "ringing", "grazing", "free", "steps", "damped")
_MODES = (0, 1, 2, 3, 5, 8, 16, 32, 64)


def _log(rng: np.random.Generator, low: float, high: float) -> float:
    return float(math.exp(rng.uniform(math.log(low), math.log(high))))


def random_flight(rng: np.random.Generator, kind: str) -> tuple[Flight, float, bool]:
    """A flight of a kind (see `KINDS`), its horizon, and whether it starts on the wall."""
    if kind == "grazing":
        return _grazing(rng)
    s = _log(rng, 0.3, 100.0)
    count = int(rng.choice(_MODES))
    n = np.arange(1, count + 1)
    sign = np.where(n % 2 == 0, 2.0, -2.0)
    omega = n * math.pi * s
    time = float(rng.uniform(0, 2 * math.pi))
    push = _log(rng, 0.05, 2.0) * (1.0 if rng.random() < 0.9 else -1.0)
    coefficients: tuple[complex, ...] = ()
    breaks: tuple[float, ...] = ()
    values: tuple[float, ...] = ()
    if kind == "steps" or (kind in ("damped", "ringing") and rng.random() < 0.25):
        if rng.random() < 0.5:
            width = float(rng.uniform(0.2, 6.0))
            breaks, values = (0.0, width), (push + float(rng.uniform(0, 2)), push - float(rng.uniform(0, 2)))
        else:
            pieces = int(rng.integers(2, 8))
            breaks = tuple(sorted(float(x) for x in rng.uniform(0, 2 * math.pi, pieces)))
            values = tuple(push + float(x) for x in rng.normal(0, 1, pieces))
        if rng.random() < 0.2:
            time = breaks[int(rng.integers(len(breaks)))]
    else:
        harmonics = int(rng.integers(1, 16))
        raw = (rng.normal(size=harmonics) + 1j * rng.normal(size=harmonics)) / np.arange(1, harmonics + 1)
        coefficients = (complex(push), *(complex(x) for x in raw))
    d = 0.0 if rng.random() < 0.4 else _log(rng, 1e-4, 1.0)
    if kind == "damped":
        d = _log(rng, 1e-3, 50.0)
    elif rng.random() < 0.05:
        d = _log(rng, 1e-14, 1e-6)
    depart = _log(rng, 0.1, 5.0)
    decay = 3.0 if kind in ("steady", "steps") or rng.random() < 0.3 else 1.0 if kind == "ringing" else 2.0
    share = _log(rng, *{"ringing": (0.3, 3.0), "steady": (1e-3, 0.1)}.get(kind, (1e-2, 1.0)))
    phase = rng.uniform(0, 2 * math.pi, count)
    size = share * depart / (math.pi * s) * rng.uniform(0.2, 1.0, count) / n**decay
    u, v = size * np.cos(phase), size * omega * np.sin(phase)
    on_wall = {"steady": True, "free": False}.get(kind, bool(rng.random() < 0.6))
    rigid, speed = -float(sign @ u), -depart
    if on_wall:
        if float(sign @ v) + speed >= -1e-3 * depart:
            speed = -depart - float(sign @ v)
    else:
        rigid -= _log(rng, 1e-3, 1.0)
        speed = depart * float(rng.uniform(-1, 1))
    flight = Flight(s, d, coefficients, breaks, values, time, np.array([rigid, *u]), np.array([speed, *v]))
    return flight, float(rng.uniform(3, 15)), on_wall


def _grazing(rng: np.random.Generator) -> tuple[Flight, float, bool]:
    """A flight away from the wall, its rigid mode shifted so that a summit of y is very near the wall."""
    while True:
        kind = str(rng.choice(["steady", "ringing", "free", "steps", "damped"]))
        flight, horizon, _ = random_flight(rng, kind)
        rate = (len(flight.displacement) - 1) * math.pi * flight.s + 15.0
        window = min(horizon, 400 / rate)
        flint.ctx.prec, precision = _PRECISIONS[0], flint.ctx.prec
        try:
            _, length, stretch = next(iter(_stretches(flight, window, False)))
            screen = _Screen(stretch, 0.0)
            t = np.linspace(0.0, length, int(4 * rate * length) + 16)
            e = screen.c * np.exp(np.outer(t, screen.lam))
            y = screen.polynomial(t)[0] + e.real.sum(axis=1)
            record = np.maximum.accumulate(y)
            peaks = np.flatnonzero((y[1:-1] > y[:-2]) & (y[1:-1] >= y[2:]) & (y[1:-1] >= record[1:-1])) + 1
            peaks = peaks[(y[peaks] > y[0])]
            if not peaks.size:
                continue
            at = flint.arb(float(t[int(rng.choice(peaks))]))
            for _ in range(12):
                _, y1, y2 = stretch.at(at)
                at = flint.arb((at - y1 / y2).mid())
            if not (at > 0 and at < length):
                continue
            value, y1, y2 = stretch.at(at)
            if not (y2 < 0 and abs(y1) < 1e-15):
                continue
            distance = _log(rng, 1e-11, 1e-3) * (1.0 if rng.random() < 0.5 else -1.0)
            u = flight.displacement.copy()
            u[0] = float(flint.arb(float(u[0])) - value + distance)
            start = float(flint.arb(float(u[0])) - flight.displacement[0]) + float(y[0])
            if start > -1e-9:
                continue
        finally:
            flint.ctx.prec = precision
        return replace(flight, displacement=u), horizon, False
