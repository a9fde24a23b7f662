"""The motion through p impacts as arrays, and the 2×2 solve by which a mode comes back after a cycle."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from percuss.model.checks import Array
from percuss.steady.oscillator import Propagator

__all__ = ["Blocks", "Numbers", "Passage", "solved"]

Numbers = npt.NDArray[Any]  # real for a real ξ, else complex
_SINGULAR = 256.0 * np.finfo(float).eps  # det(ξ − M_n) below this is rounding


class Blocks(NamedTuple):
    """M_n = [[a, b], [c, e]], the map of the elastic modes over a whole cycle; every array of shape (…, N)."""

    a: Array
    b: Array
    c: Array
    e: Array


class Passage(NamedTuple):
    """The motion through the impacts at given times; i counts impacts, and the flights that follow them.

    Parameters
    ----------
    times, flights
        t_i, and h_i = t_{i+1} − t_i; shapes (…, p).
    force
        p(t_i), from one side where the load jumps; shape (…, p).
    step
        Propagators over the flights; shapes (…, p, N).
    fade, stay
        (1 − E_i)/d and E_i = exp(−dh_i) of the rigid motion; shapes (…, p).
    rigid, rebound
        Velocity of the bar as a whole just before and just after each impact; shapes (…, p).
    displacement, velocity
        u_n and u_n' just before each impact; shapes (…, p, N).
    forced, forced_velocity
        f_n and f_n' there; shapes (…, p, N).
    speed
        Velocity of the striking end just before each impact; shape (…, p).
    gap
        F_i; shape (…, p).
    closure
        By how much the rigid velocity just after the first impact has changed after a cycle; shape (…,).
    blocks
        M_n.
    divisor
        det(I − M_n): 0 in internal resonance; shape (…, N).
    """

    times: Array
    flights: Array
    force: Array
    step: Propagator
    fade: Array
    stay: Array
    rigid: Array
    rebound: Array
    displacement: Array
    velocity: Array
    forced: Array
    forced_velocity: Array
    speed: Array
    gap: Array
    closure: Array
    blocks: Blocks
    divisor: Array

    @property
    def resonant(self) -> npt.NDArray[np.bool_]:
        """Which modes come back after a cycle by themselves, so that their amplitude is free; shape (…, N)."""
        return np.asarray(np.abs(self.divisor) <= _SINGULAR)


def solved(blocks: Blocks, xi: complex, u: Numbers, v: Numbers) -> tuple[Numbers, Numbers]:
    """(ξ − M_n)⁻¹(u_n, v_n), which broadcast with the blocks; in resonance the shortest that fits best."""
    a, e = xi - blocks.a, xi - blocks.e
    divisor = a * e - blocks.b * blocks.c
    singular = np.abs(divisor) <= _SINGULAR
    if not singular.any():
        return (e * u + blocks.b * v) / divisor, (blocks.c * u + a * v) / divisor
    size = np.abs(a) ** 2 + np.abs(e) ** 2 + np.abs(blocks.b) ** 2 + np.abs(blocks.c) ** 2
    size, safe = np.where(size > 0.0, size, 1.0), np.where(singular, 1.0, divisor)
    best_u = (np.conj(a) * u - blocks.c * v) / size
    best_v = (-blocks.b * u + np.conj(e) * v) / size
    return (
        np.where(singular, best_u, (e * u + blocks.b * v) / safe),
        np.where(singular, best_v, (blocks.c * u + a * v) / safe),
    )
