"""The contact force of a uniform bar that rests on the wall under a load of steps, by its waves (theory §4).

A jump Δ of the load reaches the wall after the transit time τ = 1/s as a jump 2gΔ of the contact force, g = e^{−dτ/2},
and comes back from the free end with the opposite sign: f(t) = 2g p(t − τ) − g² f(t − 2τ). Its harmonics are those of
the load over cos q_0, q_0 = (k − id/2)τ. Damping also bends what is behind a front, q = q_0 + d²τ/(8k) + …: the first
order of that gives slopes between the fronts, and the rest is a sum of waves whose coefficients fall off like k⁻³.
"""

from __future__ import annotations

import math

import numpy as np

from percuss.model import Load
from percuss.model.checks import Array, ComplexArray
from percuss.steady.near_resonance import NO_RINGING, Ringing, ringing_left, step_harmonics

__all__ = ["least_contact_force"]

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
