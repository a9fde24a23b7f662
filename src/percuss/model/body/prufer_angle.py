"""Modes of a chain of sections by the Prüfer angle: every one of them, in order, without a determinant.

With u = r cos θ and N/(Zω) = r sin θ the angle grows by ωτ along a section and stays in its quadrant at a step, where
tan θ' = (Z/Z') tan θ. The angle Θ(ω) at the far end grows with ω, and mode n is the one root of Θ(ω) = nπ: no mode can
be missed, and none is found twice. Angles are kept as a number of half turns and a unit vector with cos θ ≥ 0: nothing
is lost near the quarter turns, where a step of 10⁶ leaves nearly all angles.
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from percuss.halting import look
from percuss.model.body.chain import Chain, chain, sinc_deficit
from percuss.model.checks import Array, ComplexArray

__all__ = ["Waves", "frequencies", "waves"]

_BLOCK = 4096  # modes found at a time: bounds the memory
_LEAST_END = (
    1e-75  # of |φ_n(1)|, where a mode hardly reaches the end: its square stays in the range of double precision
)
_ROUNDING = 4e-16
_MOST_STEPS = 200  # bisection alone needs half of them


class Waves(NamedTuple):
    """Modes n = 1 … N: φ_n = Re(wave e^{iωt}), t the time of a wave from the start of the section; φ_n(1) > 0.

    Parameters
    ----------
    omega
        ω_n, shape (N,).
    wave
        Shape (K, N); the modal mass is 1.
    end
        φ_n(1), shape (N,).
    """

    omega: Array
    wave: ComplexArray
    end: Array


class _March(NamedTuple):
    """What a march from the first section to the last meets at the starts of sections, and at the end."""

    vectors: ComplexArray  # (K, N)
    turns: Array  # (K, N), half turns
    growths: Array  # (K, N), ln r
    angle: Array  # (N,), less the half turns, at the end
    turns_at_end: Array  # (N,)
    slope: Array  # (N,), dΘ/dω


def frequencies(sections: Chain, count: int) -> Array:
    """ω_1 … ω_N of the free chain; shape (count,)."""
    blocks = [np.arange(first, min(first + _BLOCK, count + 1.0)) for first in np.arange(1.0, count + 1.0, _BLOCK)]
    return np.concatenate([_roots(sections, block) for block in blocks])


@lru_cache(maxsize=8)
def waves(impedances: tuple[float, ...], transit_times: tuple[float, ...], s: float, count: int) -> Waves:
    """The first modes of a chain whose transit times add up to 1/s."""
    sections = chain(impedances, transit_times, None, s)
    omega = frequencies(sections, count)
    numbers = np.arange(1.0, count + 1.0)
    blocks = [slice(first, first + _BLOCK) for first in range(0, count, _BLOCK)]
    wave = np.concatenate([_waves(sections, omega[block], numbers[block]) for block in blocks], axis=1)
    end = np.maximum(np.abs(wave[-1]), _LEAST_END)
    for values in (omega, wave, end):
        values.setflags(write=False)
    return Waves(omega, wave, end)


def _march(sections: Chain, omega: Array) -> _March:
    """Vector, half turns and ln r from θ = 0 at the start on."""
    phases = np.outer(sections.transit, omega)
    half = np.floor(phases / np.pi)
    turned = np.exp(1j * phases) * (1.0 - 2.0 * (half % 2.0))
    turned.imag = np.abs(turned.imag)  # rounding must not turn it back
    shape = phases.shape
    vectors, turns, growths = np.empty(shape, complex), np.empty(shape), np.empty(shape)
    vector, turn, growth = np.ones(shape[1], complex), np.zeros(shape[1]), np.zeros(shape[1])
    slope = np.zeros(shape[1])
    z, tau = sections.impedance.tolist(), sections.transit.tolist()
    for i in range(sections.size):
        vectors[i], turns[i], growths[i] = vector, turn, growth
        vector = vector * turned[i]
        over = vector.real < 0.0
        vector = np.where(over, -vector, vector)
        turn = turn + half[i] + over
        slope = slope + tau[i]
        if i + 1 < sections.size and z[i] != z[i + 1]:
            step = z[i] / z[i + 1]
            vector.imag *= step
            stretch = np.abs(vector)
            vector = vector / stretch
            growth = growth + np.log(stretch)
            slope = slope * (step / stretch**2)
    return _March(vectors, turns, growths, np.angle(vector), turn, slope)


def _roots(sections: Chain, numbers: Array) -> Array:
    """The roots of Θ(ω) = nπ: Newton's steps, halving wherever these leave the bracket or do not halve the error."""
    total = float(sections.transit.sum())
    omega = np.pi * numbers / total
    room = (sections.lag + 1e-9) / total
    low, high = np.maximum(omega - room, 0.0), omega + room
    error, todo = np.full(numbers.size, np.inf), np.arange(numbers.size)
    for _ in range(_MOST_STEPS):
        look()
        here = omega[todo]
        end = _march(sections, here)
        off = (end.turns_at_end - numbers[todo]) * np.pi + end.angle
        low[todo] = np.where(off <= 0.0, here, low[todo])
        high[todo] = np.where(off >= 0.0, here, high[todo])
        step = off / end.slope
        newton = here - step
        slow = np.abs(off) > 0.5 * error[todo]
        middle = 0.5 * (low[todo] + high[todo])
        within = (newton > low[todo]) & (newton < high[todo])
        tight = np.abs(step) <= _ROUNDING * here
        done = tight | (high[todo] - low[todo] <= _ROUNDING * here)
        error[todo] = np.abs(off)
        omega[todo] = np.where(done, here, np.where(within & ~slow, newton, middle))
        todo = todo[~done]
        if not todo.size:
            break
    return omega


def _waves(sections: Chain, omega: Array, numbers: Array) -> ComplexArray:
    """The waves of modes, shape (K, N), normalized.

    A march loses digits where the mode fades. So the modes are put together of a march from either end, which meet in
    the section where Z r r' is greatest, among those where both have the zeros of mode n between them.
    """
    left, right = _march(sections, omega), _march(sections.mirrored, omega)
    phases = np.outer(sections.transit, omega)
    back = right._replace(vectors=right.vectors[::-1], turns=right.turns[::-1], growths=right.growths[::-1])
    apart = (left.turns + back.turns - numbers) * np.pi + np.angle(left.vectors) + np.angle(back.vectors) + phases
    weight = np.log(sections.impedance)[:, None] + left.growths + back.growths
    near = np.abs(apart) <= np.maximum(0.5 * np.pi, np.abs(apart).min(axis=0))
    meet = np.argmax(np.where(near, weight, -np.inf), axis=0)
    sign = 1.0 - 2.0 * ((left.turns + numbers) % 2.0)
    from_left = sign * left.vectors
    from_right = (1.0 - 2.0 * (back.turns % 2.0)) * np.conj(back.vectors * np.exp(1j * phases))
    column = np.arange(numbers.size)
    growths = back.growths + (left.growths - back.growths)[meet, column]
    before = np.arange(sections.size)[:, None] <= meet
    units, growths = np.where(before, from_left, from_right), np.where(before, left.growths, growths)
    sizes = np.exp(growths - growths.max(axis=0))
    middles = (units * np.exp(0.5j * phases)).real ** 2  # cos² at the middle of the section
    shares = 2.0 * middles - (2.0 * middles - 1.0) * sinc_deficit(phases.astype(complex)).real
    mass = np.einsum("kn,k,kn->n", sizes**2, 0.5 * sections.impedance * sections.transit, shares)
    return np.asarray(units * (sizes / np.sqrt(mass)))
