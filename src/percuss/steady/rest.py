"""Rest: the bar lying on the wall for all time, a steady state of its own (theory §4)."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from percuss.model import Load, System
from percuss.model.body import need_free
from percuss.model.checks import Array, ComplexArray, instance
from percuss.shown import Shown
from percuss.steady.oscillator import held_resonance
from percuss.steady.trigonometric import on_circle, trigonometric_roots
from percuss.steady.truncation import NO_RINGING, Ringing, ringing_left, step_harmonics

# ---- The contact force of a uniform bar that rests on the wall under a load of steps, by its waves (theory §4)
#
# A jump Δ of the load reaches the wall after the transit time τ = 1/s as a jump 2gΔ of the contact force, g =
# e^{−dτ/2}, and comes back from the free end with the opposite sign: f(t) = 2g p(t − τ) − g² f(t − 2τ). Its harmonics
# are those of the load over cos q_0, q_0 = (k − id/2)τ. Damping also bends what is behind a front, q = q_0 + d²τ/(8k) +
# …: the first order of that gives slopes between the fronts, and the rest is a sum of waves whose coefficients fall off
# like k⁻³.

TURN = 2.0 * math.pi
_DEAD = 30.0  # waves are left out when they have decayed to e^{−30}
_MOST_FRONTS = 1 << 19
_HARMONICS = 8192.0  # per unit of damping; leaves out 1e-9 of a jump
_FEWEST, _MOST_HARMONICS = 1 << 10, 1 << 18
_SIDES = (0.01, 0.99)  # where between two fronts the slow part is taken, on the safe side of its own jumps
_LOOKS = 1 << 16  # the least number of places around the circle for the smooth part


def least_contact_force(load: Load, s: float, d: float) -> tuple[float, float]:
    """The least contact force over the load period, and the load phase where it is.

    Right to about 1e-6 of a jump, or of the force where that is more, when all fronts can be followed. Where more than
    about half a million are alive (d below 2e-5 times the square of the number of jumps) they are followed with a
    greater damping, and the harmonics near resonance are mended in closed form. Resonant ringing is then right to one
    or two jumps, however large it is. Waves too fine for a table, up to 10⁹ quarter waves in the bar, are taken off
    with all their amplitudes: the force is mostly told too low, by up to about two jumps (by up to half a jump too
    high at s < 0.1). Without damping the waves have no finite sum for nearly any s; those up to 10⁹ are what is told.

    Parameters
    ----------
    load
        A load with jumps. Without damping none of its harmonics may be one of the resting bar's frequencies.
    s, d
        Wave speed and damping.
    """
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


def _around(load: Load, places: Array, sizes: Array, s: float, d: float, ringing: Ringing) -> tuple[float, float]:
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
    load: Load, places: Array, sizes: Array, s: float, d: float, ringing: Ringing
) -> tuple[float, float]:
    """The fronts of the first two echoes after each jump: what follows until the next one is their decaying repetition.

    So many fronts are alive that damping, d/s < 1e-4, bends nothing.
    """
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

_SMOOTHED, _PLACES = 1024, 1 << 16  # harmonics of steps, and phases looked at, where their waves are not followed
_EPS = np.finfo(float).eps


@dataclass(frozen=True)
class Rest(Shown):
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
    spectrum = np.zeros(_PLACES // 2 + 1, dtype=complex)
    felt = p != 0.0
    weights = (1.0 - k / (_SMOOTHED + 1.0))[felt]
    spectrum[1 : _SMOOTHED + 1][felt] = 0.5 * _PLACES * weights * p[felt] * transfer[felt]
    force = np.fft.irfft(spectrum, _PLACES) + system.load.mean
    best = int(np.argmin(force))
    return float(force[best]), 2.0 * math.pi * best / _PLACES


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
