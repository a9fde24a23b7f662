"""How a resting bar rings near resonance with the harmonics of a load of steps: weak damping, exactly (theory §4).

The fronts of step_waves are followed for as long as they live, which takes a least damping. What a smaller one changes
is a sum of harmonics, p_k (1/cos q_k − 1/cos q'_k) with q_k of the true and q'_k of the greater damping. It falls off
with the square of the distance from resonance, κ = k − (n − ½)πs: cos q = (−1)ⁿ sin((κ − id/2)/s). Where the odd
multiples of one resonance all lie near others, their endless sum is taken in closed form: a triangle, or a square.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
import numpy.typing as npt

from percuss.model.checks import Array, ComplexArray
from percuss.steady.small_divisors import PI, convergents

__all__ = ["NO_RINGING", "Ringing", "ringing_left", "step_harmonics"]

TURN = 2.0 * math.pi
_SIDE = 256
_PLACES = _SIDE * _SIDE  # of the table of a window
_FINEST = 0.5  # radians from place to place
_LOW = 4096  # harmonics looked at one by one
_NEIGHBOURS = np.arange(-8.0, 9.0)  # of the one nearest to a resonance
_MOST_FAMILIES, _MOST_SUMS = 6, 24  # the latter: families times jumps
_TAIL = 1e-5  # of the jumps: where a multiple beyond the table is as large, all multiples are summed
_LEAST = 1e-8  # of the jumps; less counts for nothing
_MOST = 2048  # waves times windows
_LAST_WAVE = 10**9  # quarter waves in the bar; s is hardly known so well


@dataclass(frozen=True)
class _Family:
    """All odd multiples of harmonic k that lies `off` from resonance with the held bar of m = 2n − 1 quarter waves."""

    k: float
    m: int
    off: float

    def holds(self, k: Array, m: Array) -> npt.NDArray[np.bool_]:
        """Which harmonics beside which m belong to it."""
        times = np.rint(k / self.k)
        return np.asarray((k == times * self.k) & (m == times * self.m))

    def at(self, phase: Array, s: float, d: float) -> Array:
        """What a unit jump at phase 0 adds: s/(πk) Re Σ exp(irX)/(r(rκ − id/2)), r = 1, 3, …; X = k·phase + π/2.

        The sum w obeys κw' + wd/2 = −(π/4) sgn sin X and changes its sign with X → X + π.
        """
        x = np.mod(math.copysign(1.0, self.off) * (self.k * phase + 0.5 * math.pi), TURN)
        sign = np.where(x < math.pi, 1.0, -1.0) * math.copysign(1.0, self.off)
        x, off = np.mod(x, math.pi), abs(self.off)
        if d == 0.0:
            w = 0.25 * math.pi / off * (0.5 * math.pi - x)
        elif off == 0.0:
            w = np.full(x.shape, -0.5 * math.pi / d)
        else:
            rate = 0.5 * d / off
            whole = math.expm1(-rate * math.pi)
            w = -0.5 * math.pi / d * (whole - 2.0 * np.expm1(-rate * x)) / (2.0 + whole)
        return np.asarray((s / (math.pi * self.k) * (1.0 if self.m % 4 == 1 else -1.0)) * sign * w)


@dataclass(frozen=True)
class Ringing:
    """What the true damping adds to the contact force found with a greater one.

    Parameters
    ----------
    k, c
        Harmonics and their complex amplitudes.
    summed
        At given times, the harmonics that are summed without end.
    finer
        The sum of the amplitudes of harmonics too fine for a table: the least force is lower by up to as much.
    """

    k: Array
    c: ComplexArray
    summed: Callable[[Array], Array]
    finer: float

    def at(self, times: Array, start: float, length: float) -> Array:
        """At times in a window: Re Σ c_k exp(ikt) by cubic Hermite interpolation in a table, and what is summed."""
        if not self.k.size:
            return self.summed(times)
        h = length / (_PLACES - 1)
        coarse = np.exp(1j * np.outer(start + h * _SIDE * np.arange(_SIDE), self.k)) * self.c
        fine = np.exp(1j * np.outer(h * np.arange(_SIDE), self.k))
        value = (coarse @ fine.T).real.reshape(-1)
        slope = h * ((coarse * (1j * self.k)) @ fine.T).real.reshape(-1)
        place = (times - start) / h
        i = np.clip(place.astype(np.intp), 0, _PLACES - 2)
        x, rise = place - i, value[i + 1] - value[i]
        bend = x * (1.0 - x) * ((1.0 - x) * (slope[i] - rise) - x * (slope[i + 1] - rise))
        return np.asarray(value[i] + x * rise + bend + self.summed(times))


NO_RINGING = Ringing(np.empty(0), np.empty(0, dtype=complex), np.zeros_like, 0.0)


def step_harmonics(places: Array, sizes: Array, k: Array) -> ComplexArray:
    """p_k of jumps `sizes` at the phases `places`, ΣΔ exp(−ikφ)/(iπk), rounding taken as nothing."""
    found = np.exp(-1j * np.outer(k, places)) @ sizes
    rounding = 8.0 * np.finfo(float).eps * (1.0 + k) * float(np.abs(sizes).sum())
    return np.asarray(np.where(np.abs(found) > rounding, found, 0.0) / (1j * math.pi * k))


def ringing_left(places: Array, sizes: Array, s: float, d: float, greater: float, window: float) -> Ringing:
    """What damping d instead of `greater` adds, for tables over windows as long as `window`.

    Parameters
    ----------
    places, sizes
        Phases and heights of the load's jumps.
    s
        Wave speed.
    d, greater
        The true damping and the one that the fronts were followed with.
    window
        Length in phase, radians.
    """
    finest = _FINEST * _PLACES / window
    n = np.arange(1.0, math.floor(min(finest / (math.pi * s), float(_PLACES))) + 2.0)
    near = np.rint((n - 0.5) * math.pi * s)
    k = np.unique(np.concatenate([np.arange(1.0, _LOW + 1), (near[:, None] + _NEIGHBOURS).reshape(-1)]))
    k = k[(k >= 1.0) & (k <= finest)]
    n = np.maximum(np.rint(k / (math.pi * s) + 0.5), 1.0)
    m, off = 2.0 * n - 1.0, k - (n - 0.5) * math.pi * s
    c = step_harmonics(places, sizes, k) * np.where(n % 2, -1.0, 1.0) * _gain(k, off, s, d, greater)
    whole = float(np.abs(sizes).sum())
    order = np.argsort(-np.abs(c))
    order = order[np.abs(c[order]) > _LEAST * whole]
    tail = np.abs(_gain(k, off * (finest / k), s, d, greater)) / (math.pi * finest)
    families: list[_Family] = []
    most = min(_MOST_FAMILIES, max(_MOST_SUMS // places.size, 1))
    for i in order[tail[order] > _TAIL]:
        if len(families) < most and not any(one.holds(k[i], m[i]) for one in families):
            divisor = _odd(math.gcd(int(k[i]), int(m[i])))
            families.append(_Family(float(k[i]) / divisor, int(m[i]) // divisor, float(off[i]) / divisor))
    for one in families:
        order = order[~one.holds(k[order], m[order])]
    order = order[: max(_MOST // places.size, 64)]

    def summed(times: Array) -> Array:
        found = np.zeros(times.shape)
        for one in families:
            for place, size in zip(places, sizes, strict=True):
                found += size * (one.at(times - place, s, d) - one.at(times - place, s, greater))
        return found

    finer = _finer(places, sizes, s, (d, greater), finest, families)
    return Ringing(k[order], np.asarray(c[order]), summed, finer)


def _odd(number: int) -> int:
    """The greatest odd divisor."""
    return number // (number & -number)


def _gain(k: Array, off: Array, s: float, d: float, greater: float) -> ComplexArray:
    """1/sin((κ − id/2)/s) with the true damping, less that with the greater."""

    def inverse(damping: float) -> ComplexArray:
        u = np.asarray((off + 0.125 * damping**2 / k - 0.5j * damping) / s)
        wave = np.exp(-1j * u)  # Im u ≤ 0: it does not grow
        sine = -np.expm1(-2j * u)
        # exactly in resonance without damping is only what the load does not contain, or it would have been refused
        return np.asarray(np.divide(2j * wave, sine, out=np.zeros_like(sine), where=sine != 0.0))

    return inverse(d) - inverse(greater)


def _finer(
    places: Array, sizes: Array, s: float, dampings: tuple[float, float], finest: float, families: Sequence[_Family]
) -> float:
    """Σ|c_k| of the harmonics beyond `finest` that come near a resonance: k/m near πs/2 with m = 2n − 1 odd."""
    found = [q for q, _ in convergents(0.5 * s, 1) if q <= _LAST_WAVE]
    steps = zip([0, *found], found, strict=False)
    odd = {a * q + b * before for before, q in steps for a in range(6) for b in range(-3, 4)}
    alpha = PI * Fraction(s) / 2
    waves = [(round(m * alpha), m) for m in sorted(odd) if m % 2 and 0 < m <= _LAST_WAVE]
    fine = [(float(k), float(m), float(k - m * alpha)) for k, m in waves if k > max(finest, 1.0)]
    k, m, off = np.array(fine).reshape(-1, 3).T
    for one in families:
        left = ~one.holds(k, m)
        k, m, off = k[left], m[left], off[left]
    c = np.abs(step_harmonics(places, sizes, k) * _gain(k, off, s, *dampings))
    return float(c[c > _LEAST * np.abs(sizes).sum()].sum())
