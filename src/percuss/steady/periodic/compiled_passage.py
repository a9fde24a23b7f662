"""The motion through impacts at given times, as `ImpactChain.passage` has it: one orbit, by compiled functions."""

from __future__ import annotations

import numpy as np

from percuss.model.checks import Array
from percuss.steady.oscillator import Propagator
from percuss.steady.periodic.impact_chain import ImpactChain
from percuss.steady.periodic.orbit_kernels import orbit_kernels
from percuss.steady.periodic.passage import Blocks, Passage
from percuss.steady.periodic.system_numbers import numbers_of

__all__ = ["compiled_passage"]

_GIVEN = 0  # as in the kernels: the velocity after the first impact
_TIME, _FLIGHT, _FORCE, _, _, _FADE, _STAY, _RIGID, _REBOUND, _SPEED, _OFF = range(11)  # rows of `impacts`


def compiled_passage(chain: ImpactChain, times: Array, rebound: float) -> tuple[Passage, float, float]:
    """The motion through impacts at times of the shape (p,), the mean velocity just after the first one given.

    With it det K(1) and det K(−1), each row taken by its length.
    """
    numbers = numbers_of(chain.system, chain.modes)
    room = numbers.room(chain.impacts)
    flip, fold = (
        orbit_kernels().singularity(numbers.row, room, chain.period, times, _GIVEN, rebound, xi) for xi in (-1.0, 1.0)
    )
    rows = room.impacts
    a, b, c, e, u, v, f, rate = room.carried.transpose(0, 2, 1)
    blocks = _cycle(chain, a, b, c, e)
    passage = Passage(
        times=rows[_TIME],
        flights=rows[_FLIGHT],
        force=rows[_FORCE],
        step=Propagator(a, b, c, e, np.full_like(a, np.nan), np.full_like(a, np.nan)),  # the last two serve one impact
        fade=rows[_FADE],
        stay=rows[_STAY],
        rigid=rows[_RIGID],
        rebound=rows[_REBOUND],
        displacement=u,
        velocity=v,
        forced=f,
        forced_velocity=rate,
        speed=rows[_SPEED],
        gap=rows[_OFF],
        closure=room.whole[0],
        blocks=blocks,
        divisor=(1.0 - blocks.a) * (1.0 - blocks.e) - blocks.b * blocks.c,
    )
    return passage, fold, flip


def _cycle(chain: ImpactChain, a: Array, b: Array, c: Array, e: Array) -> Blocks:
    """M_n, flight by flight; a … e of the shape (p, N)."""
    alpha, beta = chain.system.contact.strain_factor, chain.system.contact.velocity_factor
    none = np.zeros(chain.modes)
    found = none + 1.0, none, none, none + 1.0
    for pa, pb, pc, pe in zip(a, b, c, e, strict=True):
        ma, mb, mc, me = found
        found = (
            alpha * (pa * ma + pb * mc), alpha * (pa * mb + pb * me),
            beta * (pc * ma + pe * mc), beta * (pc * mb + pe * me),
        )  # fmt: skip
    return Blocks(*found)
