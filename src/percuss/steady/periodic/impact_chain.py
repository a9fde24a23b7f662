"""The motion through p impacts in n load periods, told by the times of the impacts alone.

Between impacts the modes are free of each other, and an impact multiplies each by itself: what couples them is when the
impacts fall. Given the times t_1 < … < t_p < t_1 + T, T = 2πn, every mode has one state that comes back after T, by one
2×2 solve, and the velocity of the bar as a whole one value, by one division. What is left are p equations: over each
flight the striking end comes back to the wall,

    F_i(t_1 … t_p) = Δ_i + e_{i+1}⁻ − e_i⁺ = 0,

with Δ_i the advance of the bar as a whole and e = Σ γ_n u_n what the elastic modes add at the striking end, before and
after the impacts. For p = 1 it is B77 (14). A body that is held has no motion as a whole, and its place is known: there
F_i = e_i⁻ − g, with the gap g. With the times held the states never gain energy from cycle to cycle, so
that violently unstable orbits are found as easily as stable ones.

All functions take times of the shape (…, p): many orbits at once.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from percuss.model import Modes, System
from percuss.model.checks import Array
from percuss.model.load import Side
from percuss.steady.oscillator import Propagator, phi1, phi2, propagator
from percuss.steady.periodic.passage import Blocks, Passage, solved
from percuss.steady.phases import forced_response
from percuss.steady.response import Response

__all__ = ["ImpactChain"]

_NEUTRAL = 1e-3  # 1 − Πβ E_i below which the rigid velocity is an unknown of its own


class _Forced(NamedTuple):
    """The forced motion at the impacts."""

    rigid: Array
    rigid_velocity: Array
    displacement: Array
    velocity: Array


@dataclass(frozen=True)
class ImpactChain:
    """p impacts in n load periods of a system with the modes 0 … N.

    Parameters
    ----------
    system
        What moves.
    impacts, periods
        p and n.
    modes
        N; the forced part is cut there as well.
    """

    system: System
    impacts: int
    periods: int
    modes: int

    @property
    def period(self) -> float:
        """T = 2πn."""
        return 2.0 * math.pi * self.periods

    @cached_property
    def response(self) -> Response:
        """The forced response of the bar."""
        return forced_response(self.system)

    @cached_property
    def known(self) -> Modes:
        """The elastic modes 1 … N."""
        return self.system.body.modes(self.modes, self.system.load.at)

    @cached_property
    def kept_rigid(self) -> float:
        """Πβ E_i: what is left of a change of the rigid velocity after a cycle, whatever the times."""
        return self.system.contact.velocity_factor**self.impacts * math.exp(-self.system.d * self.period)

    @property
    def is_neutral(self) -> bool:
        """Whether the rigid velocity does not follow from the times: R = 1, no drag, an even number of impacts.

        It is then an unknown of its own, and that it comes back is an equation more.
        """
        return self.system.body.is_free and abs(1.0 - self.kept_rigid) < _NEUTRAL

    def _forced(self, times: Array) -> _Forced:
        response, shape = self.response, (*times.shape, self.modes)
        if self.modes:
            rows = response.modal(self.modes, times.reshape(-1))
            u, v = (np.ascontiguousarray(row.T).reshape(shape) for row in rows)
        else:
            u = v = np.zeros(shape)
        return _Forced(response.rigid_displacement(times), response.rigid_velocity(times), u, v)

    def passage(self, times: Array, rebound: Array | None = None, side: Side = "right") -> Passage:
        """The motion through impacts at given times.

        Parameters
        ----------
        times
            t_1 … t_p in order, t_p < t_1 + T; shape (…, p).
        rebound
            Rigid velocity just after the first impact, shape (…,); None for that which comes back after a cycle, or
            where none or every one does, for that which brings the striking end back to the wall best.
        side
            Which value of the load counts where it jumps at an impact.
        """
        flights = np.concatenate([times[..., 1:], times[..., :1] + self.period], axis=-1) - times
        forced = self._forced(times)
        step, blocks, divisor, u, v = self._elastic(flights, forced)
        end = u @ self.known.gamma
        if not self.system.body.is_free:
            return self._held(times, flights, forced, (step, blocks, divisor, u, v), rebound, side)
        decay = self.system.d * flights
        fade, stay = flights * phi1(decay), np.exp(-decay)
        base = (  # F_i but for what r_i adds
            (np.roll(end, -1, axis=-1) - self.system.contact.strain_factor * end)
            + self.system.load.mean * flights**2 * phi2(decay)
            + (np.roll(forced.rigid, -1, axis=-1) - forced.rigid)
        )
        first = self._first_rebound(forced, fade, stay, base) if rebound is None else rebound
        rigid, after, last = self._rigid(forced, fade, stay, first)
        return Passage(
            times=times,
            flights=flights,
            force=self.system.load.value(times, side),
            step=step,
            fade=fade,
            stay=stay,
            rigid=rigid,
            rebound=after,
            displacement=u,
            velocity=v,
            forced=forced.displacement,
            forced_velocity=forced.velocity,
            speed=rigid + v @ self.known.gamma,
            gap=base + (after - forced.rigid_velocity) * fade,
            closure=last - first,
            blocks=blocks,
            divisor=divisor,
        )

    def _held(
        self,
        times: Array,
        flights: Array,
        forced: _Forced,
        elastic: tuple[Propagator, Blocks, Array, Array, Array],
        rebound: Array | None,
        side: Side,
    ) -> Passage:
        """The passage of a body without rigid motion: all of its velocities are 0, and so must be one that is given."""
        step, blocks, divisor, u, v = elastic
        nothing, gamma = np.zeros_like(flights), self.known.gamma
        return Passage(
            times=times,
            flights=flights,
            force=self.system.load.value(times, side),
            step=step,
            fade=nothing,
            stay=nothing,
            rigid=nothing,
            rebound=nothing if rebound is None else nothing + np.asarray(rebound)[..., None],
            displacement=u,
            velocity=v,
            forced=forced.displacement,
            forced_velocity=forced.velocity,
            speed=v @ gamma,
            gap=u @ gamma - self.system.body.gap,
            closure=nothing[..., 0] if rebound is None else nothing[..., 0] - rebound,
            blocks=blocks,
            divisor=divisor,
        )

    # -- the elastic modes --

    def _elastic(self, flights: Array, forced: _Forced) -> tuple[Propagator, Blocks, Array, Array, Array]:
        """Propagators, M_n, det(I − M_n), and u_n, u_n' just before each impact."""
        if not self.modes:
            none, nothing = np.empty((*flights.shape, 0)), np.empty((*flights.shape[:-1], 0))
            return Propagator(*(none,) * 6), Blocks(*(nothing,) * 4), nothing, none, none
        step = propagator(self.known.omega, self.known.damping, flights[..., None])
        blocks, divisor, start = self._returning(step, forced)
        return step, blocks, divisor, *self._before(step, forced, start)

    def _returning(self, step: Propagator, forced: _Forced) -> tuple[Blocks, Array, tuple[Array, Array]]:
        """M_n, det(I − M_n), and the state after the first impact that comes back, less the forced one."""
        alpha, beta = self.system.contact.strain_factor, self.system.contact.velocity_factor
        one, none = np.ones_like(step.b[..., 0, :]), np.zeros_like(step.b[..., 0, :])
        a, b, c, e, u, v = one, none, none, one, none, none
        for i in range(self.impacts):
            sa, sb, sc, se = (part[..., i, :] for part in step[:4])
            a, c = alpha * (sa * a + sb * c), beta * (sc * a + se * c)
            b, e = alpha * (sa * b + sb * e), beta * (sc * b + se * e)
            to = (i + 1) % self.impacts
            u, v = (
                alpha * (sa * u + sb * v) + (alpha - 1.0) * forced.displacement[..., to, :],
                beta * (sc * u + se * v) + (beta - 1.0) * forced.velocity[..., to, :],
            )
        blocks = Blocks(a, b, c, e)
        return blocks, (1.0 - a) * (1.0 - e) - b * c, solved(blocks, 1.0, u, v)

    def _before(self, step: Propagator, forced: _Forced, start: tuple[Array, Array]) -> tuple[Array, Array]:
        """u_n and u_n' just before each impact."""
        alpha, beta = self.system.contact.strain_factor, self.system.contact.velocity_factor
        u, v = start
        found_u, found_v = np.empty_like(forced.displacement), np.empty_like(forced.velocity)
        for i in range(self.impacts):
            sa, sb, sc, se = (part[..., i, :] for part in step[:4])
            to = (i + 1) % self.impacts
            f, fv = forced.displacement[..., to, :], forced.velocity[..., to, :]
            u, v = sa * u + sb * v + f, sc * u + se * v + fv
            found_u[..., to, :], found_v[..., to, :] = u, v
            u, v = alpha * u - f, beta * v - fv
        return found_u, found_v

    # -- the bar as a whole --

    def _rigid(self, forced: _Forced, fade: Array, stay: Array, first: Array) -> tuple[Array, Array, Array]:
        """Velocities just before and just after the impacts, and after the first one a cycle later."""
        beta, mean, swing = self.system.contact.velocity_factor, self.system.load.mean, forced.rigid_velocity
        before, after = np.empty_like(swing), np.empty_like(swing)
        after[..., 0] = now = first
        for i in range(self.impacts):
            to = (i + 1) % self.impacts
            before[..., to] = (now - swing[..., i]) * stay[..., i] + swing[..., to] + mean * fade[..., i]
            now = beta * before[..., to]
            if to:
                after[..., to] = now
        return before, after, now

    def _first_rebound(self, forced: _Forced, fade: Array, stay: Array, base: Array) -> Array:
        """The velocity after the first impact that comes back after a cycle."""
        none = np.zeros(base.shape[:-1])
        _, after, last = self._rigid(forced, fade, stay, none)
        if not self.is_neutral:
            return np.asarray(last / (1.0 - self.kept_rigid))
        beta = self.system.contact.velocity_factor  # else that with the least Σ F_i², which is linear in it
        shares = np.cumprod(np.concatenate([np.ones_like(stay[..., :1]), beta * stay[..., :-1]], axis=-1), axis=-1)
        slope, off = shares * fade, base + (after - forced.rigid_velocity) * fade
        return np.asarray(-(slope * off).sum(axis=-1) / (slope**2).sum(axis=-1))
