"""Rest: the bar lying on the wall for all time, a steady state of its own (theory §4)."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
import numpy.typing as npt

from percuss.model import Load, System
from percuss.model.body import need_free
from percuss.model.checks import Array, ComplexArray, instance
from percuss.short_repr import ShortRepr
from percuss.steady.oscillator import PI, convergents, held_resonance
from percuss.steady.trigonometric import TURN, on_circle, trigonometric_roots

# ---- How a resting bar rings near resonance with the harmonics of a load of steps: weak damping, exactly (theory §4)
#
# The fronts of step_waves are followed for as long as they live, which takes a least damping. What a smaller one
# changes is a sum of harmonics, p_k (1/cos q_k − 1/cos q'_k) with q_k of the true and q'_k of the greater damping. It
# falls off with the square of the distance from resonance, κ = k − (n − ½)πs: cos q = (−1)ⁿ sin((κ − id/2)/s). Where
# the odd multiples of one resonance all lie near others, their endless sum is taken in closed form: a triangle, or a
# square.

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
        """What a unit jump at phase 0 adds: s/(πk) Re Σ exp(irX)/(r(rκ − id/2)), r = 1, 3, …; X = k·phase + π/2."""
        # The sum w obeys κw' + wd/2 = −(π/4) sgn sin X and changes its sign with X → X + π.
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
class DampingForce:
    """What the true damping adds to the contact force found with a greater one: harmonics k and their amplitudes c, and
    at given times those that are `summed` without end.

    `finer`: the sum of the amplitudes of harmonics too fine for a table; the least force is lower by up to as much.
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


NO_RINGING = DampingForce(np.empty(0), np.empty(0, dtype=complex), np.zeros_like, 0.0)


def step_harmonics(places: Array, sizes: Array, k: Array) -> ComplexArray:
    """p_k of jumps `sizes` at the phases `places`, ΣΔ exp(−ikφ)/(iπk), rounding taken as nothing."""
    found = np.exp(-1j * np.outer(k, places)) @ sizes
    rounding = 8.0 * np.finfo(float).eps * (1.0 + k) * float(np.abs(sizes).sum())
    return np.asarray(np.where(np.abs(found) > rounding, found, 0.0) / (1j * math.pi * k))


def ringing_left(places: Array, sizes: Array, s: float, d: float, greater: float, window: float) -> DampingForce:
    """What damping d instead of `greater` adds, with jumps `sizes` at `places`, for tables over windows of a length."""
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
            common = math.gcd(int(k[i]), int(m[i]))
            divisor = common // (common & -common)  # its odd part
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
    return DampingForce(k[order], np.asarray(c[order]), summed, finer)


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


# ---- The contact force of a uniform bar that rests on the wall under a load of steps, by its waves (theory §4)
#
# A jump Δ of the load reaches the wall after the transit time τ = 1/s as a jump 2gΔ of the contact force, g =
# e^{−dτ/2}, and comes back from the free end with the opposite sign: f(t) = 2g p(t − τ) − g² f(t − 2τ). Its harmonics
# are those of the load over cos q_0, q_0 = (k − id/2)τ. Damping also bends what is behind a front, q = q_0 + d²τ/(8k) +
# …: the first order of that gives slopes between the fronts, and the rest is a sum of waves whose coefficients fall off
# like k⁻³.

_DEAD = 30.0  # waves are left out when they have decayed to e^{−30}
_MOST_FRONTS = 1 << 19
_HARMONICS = 8192.0  # per unit of damping; leaves out 1e-9 of a jump
_FEWEST, _MOST_HARMONICS = 1 << 10, 1 << 18
_SIDES = (0.01, 0.99)  # where between two fronts the slow part is taken, on the safe side of its own jumps
_LOOKS = 1 << 16  # the least number of places around the circle for the smooth part


def least_contact_force(load: Load, s: float, d: float) -> tuple[float, float]:
    """The least contact force over the load period, and the load phase where it is."""
    # Right to about 1e-6 of a jump, or of the force where that is more, when all fronts can be followed. Where more
    # than about half a million are alive (d below 2e-5 times the square of the number of jumps) they are followed with
    # a greater damping, and the harmonics near resonance are mended in closed form. Resonant ringing is then right to
    # one or two jumps, however large it is. Waves too fine for a table, up to 10⁹ quarter waves in the bar, are taken
    # off with all their amplitudes: the force is mostly told too low, by up to about two jumps (by up to half a jump
    # too high at s < 0.1). Without damping the waves have no finite sum for nearly any s; those up to 10⁹ are what is
    # told, and none of the load's harmonics may be one of the resting bar's frequencies.
    jumps = load.jumps
    places, sizes = np.array([jump.phase for jump in jumps]), np.array([jump.after - jump.before for jump in jumps])
    living = max(d, _DEAD * len(jumps) ** 2 / (math.pi * _MOST_FRONTS))
    echoes = _DEAD * s / living  # per jump, until they have died out
    around = echoes * len(jumps) <= _MOST_FRONTS
    ringing = NO_RINGING
    if living > d:
        ringing = ringing_left(places, sizes, s, d, living, TURN if around else 4.0 / s)
    follow = _around if around else _behind_the_jumps
    least, phase = follow(load, places, sizes, s, living, ringing)
    return least - ringing.finer, phase


def _around(load: Load, places: Array, sizes: Array, s: float, d: float, ringing: DampingForce) -> tuple[float, float]:
    """All fronts of a period in order, with the slopes between them."""
    tau = 1.0 / s
    g, number = math.exp(-0.5 * d * tau), np.arange(math.ceil(_DEAD * s / d) + 1)
    signs = np.where(number % 2, -1.0, 1.0) * np.exp(-d * tau * (number + 0.5))  # (−1)^l g^{2l+1}
    fronts = np.mod(places[:, None] + (2 * number + 1) * tau, TURN).reshape(-1)
    order = np.argsort(fronts)
    fronts = fronts[order]
    lengths = np.diff(np.append(fronts, fronts[0] + TURN))
    steps = (2.0 * sizes[:, None] * signs).reshape(-1)[order]
    bends = (0.25 * d**2 * tau * sizes[:, None] * ((2 * number + 1) * signs)).reshape(-1)[order]
    level, slope = _centred(np.cumsum(steps), lengths), _centred(np.cumsum(bends), lengths)
    bent = np.append(0.0, np.cumsum(slope * lengths)[:-1])
    bent -= float((bent + 0.5 * slope * lengths) @ lengths) / TURN
    after = level + bent + load.mean * 2.0 * g / (1.0 + g * g)  # just after each front
    smooth = _smooth_part(load, places, sizes, s, d)
    grid = TURN * np.arange(smooth.size) / smooth.size
    at_fronts = np.interp(fronts, grid, smooth, period=TURN)
    piece = np.searchsorted(fronts, grid, side="right") - 1
    between = after[piece] + slope[piece] * np.mod(grid - fronts[piece], TURN) + smooth
    before_next = after + slope * lengths + np.roll(at_fronts, -1)
    apart = lengths > _together(2.0 * tau * float(number[-1]), tau)
    clear = apart[piece]
    times = np.concatenate([fronts[apart], (fronts + lengths)[apart], grid[clear]])
    forces = np.concatenate([(after + at_fronts)[apart], before_next[apart], between[clear]])
    inside = np.concatenate([*((fronts + x * lengths)[apart] for x in _SIDES), grid[clear]])
    forces += ringing.at(np.mod(inside, TURN), 0.0, TURN)
    best = int(np.argmin(forces))
    return float(forces[best]), float(times[best] % TURN)


def _together(oldest: float, tau: float) -> float:
    """Times this near are one: between fronts that meet there is no force to look at."""
    return max(4.0 * np.finfo(float).eps * oldest, 1e-9 * tau)


def _centred(values: Array, lengths: Array) -> Array:
    """A piecewise-constant function without its mean."""
    return np.asarray(values - float(values @ lengths) / TURN)


def _smooth_part(load: Load, places: Array, sizes: Array, s: float, d: float) -> Array:
    """What the fronts and the slopes between them leave of the exact force; on a grid around the circle."""
    tau = 1.0 / s
    most = min(_MOST_HARMONICS, max(_FEWEST, 1 << math.ceil(math.log2(max(_HARMONICS * d, 1.0)))))
    k = np.arange(1, most + 1).astype(float)
    p = step_harmonics(places, sizes, k)
    exact = np.asarray(np.sqrt(k * (k - 1j * d)) * tau, dtype=complex)
    front = np.asarray((k - 0.5j * d) * tau, dtype=complex)
    off = _transfer(exact) - _transfer(front) * (1.0 + np.tan(front) * d**2 * tau / (8.0 * k))
    places_around = max(_LOOKS, 4 * most)
    spectrum = np.zeros(places_around // 2 + 1, dtype=complex)
    spectrum[1 : most + 1] = 0.5 * places_around * p * off
    constant = load.mean * (1.0 - 1.0 / math.cosh(min(0.5 * d * tau, 700.0)))
    return np.asarray(np.fft.irfft(spectrum, places_around) + constant)


def _transfer(q: ComplexArray) -> ComplexArray:
    """1/cos q for Im q ≤ 0, without overflow."""
    wave = np.exp(-1j * q)
    return np.asarray(2.0 * wave / (1.0 + wave**2))


def _behind_the_jumps(
    load: Load, places: Array, sizes: Array, s: float, d: float, ringing: DampingForce
) -> tuple[float, float]:
    """The fronts of the first two echoes after each jump, which then repeat and decay (d/s < 1e-4 bends none)."""
    tau = 1.0 / s
    g = math.exp(-0.5 * d * tau)
    settled = 2.0 * g / (1.0 + g * g)
    ages = TURN * np.arange(math.ceil(_DEAD / (math.pi * d)) + 1)
    apart = _together(float(ages[-1]) + TURN, tau)
    least, phase = math.inf, 0.0
    for i, place in enumerate(places):
        past = np.mod(place - places, TURN)[:, None] + ages  # time since each jump of each period
        echo = np.floor(past / (2.0 * tau) + 1e-9)
        wave = np.where(echo % 2, 1.0, -1.0) * np.exp(-d * tau * (echo + 1.0)) * sizes[:, None]  # (−g²)^{l+1} Δ
        first = 2.0 * tau * (echo + 1.0) - past
        # the next jump of the force from each, and the one after: κ[(−g²)^{l+1} − (−g²)^{l+2}]Δ with κ = 2g/(1 + g²)
        step = settled * (1.0 + g * g) * wave
        fronts = np.concatenate([[0.0], first.reshape(-1), (first + 2.0 * tau).reshape(-1)])
        start = settled * (float(load.value(place)) - float(wave.sum()))
        steps = np.concatenate([[start], step.reshape(-1), (-g * g * step).reshape(-1)])
        order = np.argsort(fronts, kind="stable")
        fronts, forces = fronts[order], np.cumsum(steps[order])
        end = min(4.0 * tau, float(np.mod(places[(i + 1) % places.size] - place, TURN)) or TURN)
        lengths = np.minimum(np.append(fronts[1:], end), end) - fronts
        clear = lengths > apart
        if float(lengths[clear].sum()) < 0.5 * end:  # s so great that most fronts are nearer than phases are told
            clear = lengths > 0.0
        times = place + tau + np.concatenate([(fronts + x * lengths)[clear] for x in _SIDES])
        forces = np.tile(forces[clear], 2) + ringing.at(times, place + tau, end)
        best = int(np.argmin(forces)) if forces.size else -1
        if best >= 0 and forces[best] < least:
            least, phase = float(forces[best]), float(times[best])
    return least, phase % TURN


# ---- Rest: the bar lying on the wall for all time, a steady state of its own (theory §4)

_SMOOTHED, _LOOKED = 1024, 1 << 16  # harmonics of steps, and phases looked at, where their waves are not followed
_EPS = np.finfo(float).eps


@dataclass(frozen=True)
class Rest(ShortRepr):
    """The bar at rest on the wall.

    Parameters
    ----------
    possible
        The verdict, by the contact force with the waves in the bar: whether it never pulls.
    least_contact_force
        Its least value over the load period, dimensionless; −inf when the resting bar is driven in resonance.
    phase
        Load phase of the least contact force, or None.
    quasi_static
        The least value of p(t) itself, the contact force without waves: the limit s → ∞ under a smooth load.
    """

    possible: bool
    least_contact_force: float
    phase: float | None
    quasi_static: float

    @property
    def lifted_by_waves(self) -> bool:
        """Whether waves alone lift the end off, for moments of a wave's way through the bar: the load never pulls."""
        return not self.possible and self.quasi_static >= 0.0

    @property
    def held_by_waves(self) -> bool:
        """Whether waves alone hold the end at the wall while the load pulls: a simulation, without them, lets go."""
        return self.possible and self.quasi_static < 0.0

    def __str__(self) -> str:
        word = "possible" if self.possible else "not possible"
        return (
            f"Rest: {word}, least contact force {self.least_contact_force:.6g} (quasi-static {self.quasi_static:.6g})"
        )


def rest_on_wall(system: System) -> Rest:
    """Is u(1, t) ≡ 0 a steady state, and how hard does the bar press?

    The verdict goes by the contact force with every wave resolved: of a uniform bar driven at its end
    f = p_0 + Re Σ p_k exp(ikt)/cos q_k, of any body the receptance from the load to the striking end over that of the
    striking end itself in place of 1/cos q_k. A jump of the load doubles in it and comes back with every echo, so that
    steps can lift off a bar that the load itself never pulls: `quasi_static` tells. A simulation takes the load itself
    as the contact force of a bar at rest.

    On a uniform bar with external damping, driven at its end, steps are taken exactly, whatever harmonics are kept
    beside them (theory §4); where hardly anything damps them the force may be told a jump or two too low, never a
    resonance overlooked. For other bodies, places and dampings the first 1024 harmonics of the steps are summed with
    Fejér's weights, a mean over about 1/1000 of the period that overshoots nowhere: shorter pulls are not seen.

    Examples
    --------
    >>> from percuss import Load, System
    >>> rest_on_wall(System(s=20.0, d=0.0, restitution=0.5, load=Load.harmonic(1.5, 1.0))).possible
    True
    >>> print(rest_on_wall(System(50.0, 0.02, 0.3, Load.steps([0.0, 3.14], [1.0, 0.3]))))
    Rest: not possible, least contact force -1.91723 (quasi-static 0.3)
    """
    load = instance("system", system, System).load
    need_free(system.body, "rest on the wall")
    if load.is_piecewise:
        return _under_steps(system)
    k = load.harmonics.astype(float)
    p: ComplexArray = load.coefficients[load.harmonics]
    quasi_static, _ = _least(k, p, load.mean)
    transfer = system.body.held_transfer(k, load.at)
    if not np.all(np.isfinite(transfer)):
        return Rest(False, -math.inf, None, quasi_static)
    least, phase = _least(k, p * transfer, load.mean)
    return Rest(least >= 0.0, least, phase, quasi_static)


def _under_steps(system: System) -> Rest:
    load, body, quasi_static = system.load, system.body, min(system.load.values)
    if not load.jumps:
        return Rest(quasi_static >= 0.0, quasi_static, None, quasi_static)
    if not (body.is_harmonic and body.damping.is_even and load.at == 0):
        least, phase = _smoothed(system)
    elif system.d == 0.0 and held_resonance(load, body.frequency_floor(1)):
        least, phase = -math.inf, None
    else:
        least, phase = least_contact_force(load, system.s, system.d)
    return Rest(least >= 0.0, least, phase, quasi_static)


def _smoothed(system: System) -> tuple[float, float | None]:
    """The least contact force by the first harmonics of steps, summed with Fejér's weights, and its phase."""
    jumps, k = system.load.jumps, np.arange(1.0, _SMOOTHED + 1.0)
    places, sizes = np.array([jump.phase for jump in jumps]), np.array([jump.after - jump.before for jump in jumps])
    p, transfer = step_harmonics(places, sizes, k), system.body.held_transfer(k, system.load.at)
    if np.any(~np.isfinite(transfer) & (p != 0.0)):
        return -math.inf, None
    spectrum = np.zeros(_LOOKED // 2 + 1, dtype=complex)
    felt = p != 0.0
    weights = (1.0 - k / (_SMOOTHED + 1.0))[felt]
    spectrum[1 : _SMOOTHED + 1][felt] = 0.5 * _LOOKED * weights * p[felt] * transfer[felt]
    force = np.fft.irfft(spectrum, _LOOKED) + system.load.mean
    best = int(np.argmin(force))
    return float(force[best]), 2.0 * math.pi * best / _LOOKED


def _least(k: np.typing.NDArray[np.float64], p: ComplexArray, mean: float) -> tuple[float, float | None]:
    """Least value of mean + Re Σ p_k exp(ikt) and where it is taken."""
    felt = np.abs(p) > _EPS * max(abs(mean), float(np.abs(p).max(initial=0.0)))
    k, p = k[felt], p[felt]  # strong damping swallows the others before they reach the wall
    if not k.size:
        return mean, None
    if k.size == 1:
        return mean - float(np.abs(p[0])), float(on_circle((np.pi - np.angle(p[0])) / k[0]))
    phases = trigonometric_roots(k, 1j * k * p)
    values = mean + (np.exp(1j * np.outer(phases, k)) @ p).real
    best = int(np.argmin(values))
    return float(values[best]), float(phases[best])
