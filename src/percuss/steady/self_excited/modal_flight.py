"""The flight of an elastic body under a constant force: every coordinate of the machine by itself, in closed form."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from percuss.model import MachineModes
from percuss.model.checks import Array
from percuss.steady.oscillator import phi1, phi2, propagator

__all__ = ["ModalFlight", "energy_of", "propagated", "rates", "response_of"]

_SMALL = 0.5  # the series are taken where κt² and dt are no greater, and doubled from there
_TERMS = 16


def response_of(modes: MachineModes, t: Array) -> tuple[Array, Array, Array]:
    """s′, s and q of every coordinate (see `piston_flight`) at the times t; each of shape (N + 1, len(t)).

    The motion as a whole is taken from its series, which is exact down to no chamber and no drag.
    """
    ds, s, q = np.empty((3, modes.omega.size, t.size))
    square, drag = float(modes.omega[0]) ** 2, float(modes.damping[0])
    if square == 0.0:
        ds[0], s[0], q[0] = np.exp(-drag * t), t * phi1(drag * t), t * t * phi2(drag * t)
    else:
        ds[0], s[0], q[0] = on_gas(t, square, drag)
    if modes.size:
        omega, damping = modes.omega[1:, None], modes.damping[1:, None]
        step = propagator(omega, damping, t[None, :])
        one_less = -np.expm1(-0.5 * damping * t) + step.versine - 0.5 * damping * step.b  # 1 − a
        ds[1:], s[1:], q[1:] = step.e, step.b, one_less / omega**2
    return ds, s, q


def on_gas(t: Array, square: float, drag: float) -> tuple[Array, Array, Array]:
    """As `piston_flight.response`, of many times together: power series, and doubling the time."""
    longest = float(np.abs(t).max(initial=0.0))
    doublings = 0
    while square * longest**2 > _SMALL or drag * longest > _SMALL:
        longest *= 0.5
        doublings += 1
    t = t * 0.5**doublings
    z, b = square * t * t, drag * t
    before, now = np.zeros_like(t), np.ones_like(t)
    ds, s, q = np.ones_like(t), np.ones_like(t), np.full_like(t, 0.5)
    for n in range(1, _TERMS):
        before, now = now, -(b * n * now + z * before) / (n * (n + 1))
        ds, s, q = ds + (n + 1) * now, s + now, q + now / (n + 2)
    s, q = s * t, q * t * t
    for _ in range(doublings):
        ds, s, q = ds * ds - square * s * s, s * (1.0 - square * q + ds), 2.0 * q + s * s - square * q * q
    return ds, s, q


def propagated(modes: MachineModes, state: Array, force: float, response: tuple[Array, Array, Array]) -> Array:
    """The state (N + 1, 2) after a time whose response is given, or the columns of (N + 1, 2, C) without force."""
    ds, s, q = response
    square = modes.omega**2
    if state.ndim == 3:
        ds, s, q, square = ds[:, None], s[:, None], q[:, None], square[:, None]
    u, v = state[:, 0], state[:, 1]
    pull = -square * u if force == 0.0 else force * modes.driven - square * u
    return np.stack([u + v * s + pull * q, v * ds + pull * s], axis=1)


def rates(modes: MachineModes, state: Array, force: float) -> Array:
    """Velocity and acceleration of a state (N + 1, 2)."""
    u, v = state[:, 0], state[:, 1]
    return np.stack([v, force * modes.driven - modes.omega**2 * u - modes.damping * v], axis=1)


def energy_of(modes: MachineModes, state: Array) -> float:
    """Kinetic energy, and elastic energy with that of the chamber, of a state (N + 1, 2); per unit of mass."""
    strained, v = modes.omega * state[:, 0], state[:, 1]
    return 0.5 * float(v @ v + strained @ strained)


@dataclass(frozen=True)
class ModalFlight:
    """A stretch without an event.

    Parameters
    ----------
    modes
        The coordinates.
    state, last
        Of the valve, and what was demanded last.
    force
        Towards the wall.
    time, duration
        When it begins, and how long it lasts.
    begin
        Displacements and velocities of the coordinates at the start; shape (N + 1, 2).
    """

    modes: MachineModes
    state: str
    last: str
    force: float
    time: float
    duration: float
    begin: Array

    def at(self, t: Array) -> tuple[Array, Array]:
        """Displacements and velocities of the coordinates at times after its start; each of shape (N + 1, len(t))."""
        ds, s, q = response_of(self.modes, t)
        u, v = self.begin[:, :1], self.begin[:, 1:]
        pull = (self.force * self.modes.driven - self.modes.omega**2 * self.begin[:, 0])[:, None]
        return u + v * s + pull * q, v * ds + pull * s

    @property
    def end(self) -> Array:
        """The state at its end; shape (N + 1, 2)."""
        ds, s, q = response_of(self.modes, np.array([self.duration]))
        return propagated(self.modes, self.begin, self.force, (ds[:, 0], s[:, 0], q[:, 0]))
