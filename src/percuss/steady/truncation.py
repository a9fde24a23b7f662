"""How many elastic modes the sums need, and how much the omitted ones can contribute."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING, Protocol

import numpy as np
import numpy.typing as npt

from percuss.halting import look
from percuss.model.checks import Array, ComplexArray
from percuss.shown import Shown
from percuss.steady.oscillator import ModalState, resolvent_bound

if TYPE_CHECKING:
    from percuss.model import System
    from percuss.steady.harmonic import Response


# ---- What modes beyond the last one kept may add where they are hardly damped: sums over small divisors (theory §4)
#
# Without damping the free motion of mode n is |f_n'|/ω_n times (1 + R)/(1 − R)·|cot(πnα)|, α = πsm, which is large
# where it swings nearly a whole number of times between two impacts. How near nα comes to whole numbers, and how
# rarely, is told by the continued fraction of α: its denominators q_j come nearest, ‖q_jα‖ = η_j, no n < q_{j+1} comes
# nearer, and any two of q_j modes in a row are at least η_{j−1} ≥ 1/(2q_j) apart.

# π to 100 digits, as a fraction: a wave speed is taken as the exact number that it is in binary
PI = Fraction(
    31415926535897932384626433832795028841971693993751058209749445923078164062862089986280348253421170679,
    10**100,
)
_LAST = 10**18  # modes beyond this one count for nothing


@lru_cache(maxsize=64)
def convergents(s: float, periods: int) -> tuple[tuple[int, float], ...]:
    """Denominators q_j of πsm and ‖q_jα‖, up to the last mode that could count."""
    alpha = PI * Fraction(s) * periods
    whole = alpha.numerator // alpha.denominator
    rest, before, q = alpha - whole, 0, 1
    found = [(1, float(min(rest, 1 - rest)))]
    while rest and q <= _LAST:
        rest = 1 / rest
        whole = rest.numerator // rest.denominator
        rest -= whole
        before, q = q, whole * q + before
        off = q * alpha % 1
        entry = (q, float(min(off, 1 - off)))
        if found[-1][0] == q:
            found[-1] = entry
        else:
            found.append(entry)
    return tuple(found)


@lru_cache(maxsize=256)
def cubic_sum(s: float, periods: int, start: int, most: float = math.inf, shift: float = 0.0) -> float:
    """A bound of Σ n⁻³ min(`most`, 1 + 1/(2(‖nα‖ − `shift`))) over the modes n = `start` + 1 … 10¹⁸, α = πsm.

    Parameters
    ----------
    s, periods
        Wave speed and m.
    start
        The last mode that is left out of the sum.
    most
        A bound of every factor, inf for none.
    shift
        By how much damping moves nα at most.
    """
    known = convergents(s, periods)
    total = 0.5 / start**2
    for j, (q, eta) in enumerate(known[:-1]):
        end, first = known[j + 1][0], max(start + 1, q)
        if first >= end:
            continue
        near, apart = eta - shift, (known[j - 1][1] if j else 0.5)
        crowd = 4.0 * q * (2.0 + math.log(q)) + 2.0 / apart  # all but the nearest of q modes in a row
        crowd = 0.5 * crowd if shift == 0.0 else crowd if apart > 8.0 * shift else math.inf
        total += _cubes(first, end, q) * min(q * most, crowd)

        def nearest(times: float, near: float = near) -> float:
            return min(most, 0.5 / (times * near) if near > 0.0 else math.inf)

        # the nearest: rη_j among rq_j … (r + 1)q_j in the first half of the block, rη_j from its end in the other
        r = first // q
        for one in range(r, r + 8):
            total += max(one * q, first) ** -3.0 * nearest(one) if one * q < end else 0.0
        if (r + 8) * q < end:
            total += 0.5 * q**-3.0 * (r + 7.0) ** -2.0 * nearest(r + 8.0)
        half = max(first, end // 2)  # from there on ‖nα‖ is about ‖(q_{j+1} − n)α‖
        total += min(_cubes(half, end, q), float(half) ** -3 * (3.0 + math.log1p((end - half) / q))) * nearest(1.0)
    return total


def _cubes(first: int, end: int, step: int) -> float:
    """A bound of the sum of n⁻³ for n = first, first + step, … below `end`."""
    return min(
        float(first) ** -3 + 0.5 / step * float(first) ** -2, math.ceil((end - first) / step) * float(first) ** -3
    )


# ---- How many elastic modes the sums need, and how much the omitted ones can contribute

RELEASED_MODES = 512
"""Modes of the sums where an impact changes the strain: more of them hardly help."""

_PROBES = (256, 2048, 16384, 65536)
_MOST_MODES = 16384
_VAGUE = 1e-9  # share of the stroke above which the plain bound, which grows like 1/d, gives way to the sharper one
_FEW, _SOME = 1e-3, 1e-7  # shares of the stroke that a first and a second look at the motion may leave out


class Untruncated(Protocol):
    """What it takes of a motion to choose the number of its modes; `percuss.steady.orbit.Orbit` has it."""

    @property
    def system(self) -> System: ...
    @property
    def response(self) -> Response: ...
    @property
    def periods(self) -> int: ...
    @property
    def period(self) -> float: ...
    @property
    def phase(self) -> float: ...
    @property
    def requested_modes(self) -> int | None: ...
    @property
    def tolerance(self) -> float: ...
    @property
    def rigid_stroke(self) -> float: ...
    def modal_state(self, modes: int) -> ModalState: ...


@dataclass(frozen=True)
class Truncation(Shown):
    """The modes kept and the modes left out of a motion's sums.

    Parameters
    ----------
    motion
        The motion that they belong to.
    modes
        N, the modes kept.
    few, some
        Smaller numbers of modes that already give the position to 1e-3 and 1e-7 of the stroke.
    state
        State of the modes kept.
    lost
        Bound of the position that the modes left out add at the striking end, where it is known already.
    """

    motion: Untruncated = field(repr=False)
    modes: int
    few: int
    some: int
    state: ModalState = field(repr=False)
    lost: float | None = None

    @cached_property
    def error_bound(self) -> float:
        """Bound of the position error at the striking end relative to the stroke of the rigid motion.

        A bound for a uniform bar under a smooth load whose impacts keep the strain, without damping for the first 10¹⁸
        modes, and for other bodies when their damping outlasts small divisors. Else it is an estimate, as with a load
        that jumps and with Kelvin–Voigt's damping: modes beyond the probe are taken to fall off like those inside it.
        """
        motion, lost = self.motion, self.lost
        if lost is None:  # a requested number of modes: the forced part is cut as well
            probe = max(4 * self.modes, 2048)
            lost = _forced_cut(motion, self.modes, probe) + float(_left_out(motion, probe)[self.modes])
        return lost / motion.rigid_stroke


def truncation(motion: Untruncated) -> Truncation:
    """Choose the number of modes that the tolerance asks for, or take the number requested."""
    if motion.requested_modes is not None:
        n = motion.requested_modes
        lost = None if motion.system.body.is_free else 0.0  # a structure has no other modes
        return Truncation(motion, n, n, n, motion.modal_state(n), lost)
    scale = motion.rigid_stroke
    if not motion.system.contact.keeps_strain:  # what its release sets ringing falls off like 1/n²
        return Truncation(motion, RELEASED_MODES, RELEASED_MODES, RELEASED_MODES, motion.modal_state(RELEASED_MODES))
    largest = motion.response.most_modes
    for probe in [p for p in _PROBES if p < largest] + [largest]:
        look()
        left_out = _left_out(motion, probe)
        if left_out[-1] <= 0.5 * motion.tolerance * scale:
            break
    most = min(probe, _MOST_MODES)

    def enough(share: float) -> int:
        found = np.flatnonzero(left_out <= share * scale)
        return min(most, max(8, int(found[0]))) if found.size else most

    modes = enough(motion.tolerance)
    lost = float(left_out[modes])
    return Truncation(motion, modes, enough(_FEW), enough(_SOME), motion.modal_state(modes), lost)


def _left_out(motion: Untruncated, probe: int) -> Array:
    """Bound of what is lost at the striking end by keeping n = 0 … `probe` modes; shape (probe + 1,)."""
    amplitude = ringing(motion, motion.modal_state(probe).amplitude)
    coupling = np.abs(motion.system.body.modes(probe, motion.system.load.at).gamma)
    lost = np.append(np.cumsum((coupling * amplitude)[::-1])[::-1], 0.0)
    return np.asarray(2.0 * (lost + _beyond(motion, amplitude)))  # at t and, as y(0) = 0 places the wall, at 0


def _forced_cut(motion: Untruncated, modes: int, probe: int) -> float:
    """Bound of the forced motion of all modes after the first `modes`; inf when the load reaches beyond `probe`."""
    body = motion.system.body
    each = body.coupling_bound * motion.response.modal_bounds(probe)[0]
    floor = body.frequency_floor(probe)
    if floor <= 0.0:
        return math.inf
    beyond = body.coupling_bound * motion.response.displacement_tail(floor) * body.transit_time / (math.pi * floor)
    return 2.0 * (float(each[modes:].sum()) + beyond)  # twice as in _left_out


def ringing(motion: Untruncated, amplitude: Array) -> Array:
    """Amplitudes after the impact of the first modes, with those after the jumps of a piecewise load added."""
    return amplitude if motion.response.is_smooth else amplitude + motion.response.ringing(amplitude.size)


def _beyond(motion: Untruncated, amplitude: Array) -> float:
    """Bound of what all modes after the last of `amplitude` add at the striking end, or an estimate of it."""
    system, body, n = motion.system, motion.system.body, amplitude.size
    modes, floor = body.modes(n, system.load.at), body.frequency_floor(n)
    top = slice(n // 2, n)
    shares = modes.damping[top] / modes.omega[top]
    known = system.contact.keeps_strain and floor > 0.0 and shares[-1] <= shares[0]
    last = float(modes.damping[-1])
    each = motion.response.modal_velocity_bound(motion.phase, floor, last) if known else math.inf
    bound = 0.5 * body.coupling_bound * each * body.transit_time / (math.pi * floor**2) if known else math.inf
    if math.isfinite(bound):  # of Σ |f_n'|/ω_n, as |f_n'| ≤ each/ω_n² and ω_{n+j} ≥ floor + jπs
        contact, free = system.contact, not np.any(modes.damping)
        if contact.is_lossless and free:
            return bound  # nothing rings but −f_n'
        damped = resolvent_bound(system, motion.period, floor, last)
        if bound * damped <= _VAGUE * motion.rigid_stroke or (contact.is_lossless and math.isfinite(damped)):
            return bound * damped
        if body.is_harmonic and np.all(modes.damping == last):
            # hardly damped: by how near the modes come to resonance with the impacts
            full, shift = 1.0 / contact.impedance_ratio, last**2 * motion.periods / (8.0 * floor)
            near = cubic_sum(system.s, motion.periods, n, damped / full, shift)
            return float(body.coupling_bound * each / modes.omega[0] ** 3 * full * near)
    order = 3 if motion.response.is_smooth and system.contact.keeps_strain else 2
    numbers = np.arange(1, n + 1)[top]
    return body.coupling_bound * float(np.max(amplitude[top] * numbers**order)) / float((order - 1) * n ** (order - 1))


# ---- How a resting bar rings near resonance with the harmonics of a load of steps: weak damping, exactly (theory §4)
#
# The fronts of step_waves are followed for as long as they live, which takes a least damping. What a smaller one
# changes is a sum of harmonics, p_k (1/cos q_k − 1/cos q'_k) with q_k of the true and q'_k of the greater damping. It
# falls off with the square of the distance from resonance, κ = k − (n − ½)πs: cos q = (−1)ⁿ sin((κ − id/2)/s). Where
# the odd multiples of one resonance all lie near others, their endless sum is taken in closed form: a triangle, or a
# square.

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
