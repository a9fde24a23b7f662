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
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from percuss.mechanics.flow import Propagator, phi1, phi2, propagator
from percuss.model import Contact, Modes, System
from percuss.model.checks import Array, ComplexArray
from percuss.model.load import Side
from percuss.steady.harmonic import Response
from percuss.steady.oscillator import comes_back
from percuss.steady.phases import forced_response

# ---- The motion through p impacts as arrays, and the 2×2 solve by which a mode comes back after a cycle
#
# Near internal resonance every flight takes a mode through nearly whole half turns, and M_n is nearly the diagonal
# matrix of the impacts alone. What is left is found by itself, so that det(ξ − M_n) at ξ = ±1 is not a difference of
# ones.

Numbers = npt.NDArray[Any]  # real for a real ξ, else complex


class Blocks(NamedTuple):
    """M_n = [[a, b], [c, e]], the map of the elastic modes over a whole cycle; every array of shape (…, N).

    Parameters
    ----------
    b, c
        The entries beside the diagonal.
    whole_a, whole_e
        What a and e would be if each flight were the nearest number of half turns, without damping.
    off_a, off_e
        What a and e are besides.
    terms, angle, factor
        As for `comes_back`.
    """

    b: Array
    c: Array
    whole_a: Array
    whole_e: Array
    off_a: Array
    off_e: Array
    terms: Array
    angle: Array
    factor: Array

    @property
    def a(self) -> Array:
        """How much of u_n comes back as u_n."""
        return self.whole_a + self.off_a

    @property
    def e(self) -> Array:
        """How much of u_n' comes back as u_n'."""
        return self.whole_e + self.off_e

    @staticmethod
    def of(contact: Contact, damping: Array, omega: Array, step: Sequence[Array], flights: Array) -> Blocks:
        """The map over flights, shape (…, p), with propagators [a, b, c, e] over each, shapes (…, p, N)."""
        alpha, beta, p = contact.strain_factor, contact.velocity_factor, flights.shape[-1]
        loss = -np.expm1(-0.5 * damping * flights[..., None])
        lag = 0.5 * damping * step[1]
        cosine = step[0] - lag
        sign = np.copysign(1.0, cosine)
        cancels = np.abs(cosine) > 0.5
        sum_of = np.where(cancels, cosine + sign * (1.0 - loss), 1.0)
        near = np.where(cancels, (step[1] * step[2] + lag**2) / sum_of - sign * loss, cosine - sign)
        one, none = np.ones_like(loss[..., 0, :]), np.zeros_like(loss[..., 0, :])
        whole_a, whole_e, off_a, off_e, b, c = one, one, none, none, none, none
        for i in range(p):
            sa, sb, sc, se = (part[..., i, :] for part in step[:4])
            a, e = near[..., i, :] + lag[..., i, :], near[..., i, :] - lag[..., i, :]
            off_a, c = alpha * (sa * off_a + a * whole_a + sb * c), beta * (sc * (whole_a + off_a) + se * c)
            off_e, b = beta * (se * off_e + e * whole_e + sc * b), alpha * (sa * b + sb * (whole_e + off_e))
            whole_a, whole_e = alpha * sign[..., i, :] * whole_a, beta * sign[..., i, :] * whole_e
        factor = np.full_like(omega, 1.0 + beta if p == 1 else 2.0)
        terms = (2.0 * np.abs(near) + np.abs(step[1] * step[2])).sum(axis=-2)
        return Blocks(b, c, whole_a, whole_e, off_a, off_e, terms, omega * flights.sum(axis=-1, keepdims=True), factor)

    def away(self, xi: complex) -> tuple[Numbers, Numbers, Numbers, npt.NDArray[np.bool_]]:
        """ξ − a, ξ − e and det(ξ − M_n), and which modes are in resonance."""
        a, e = (xi - self.whole_a) - self.off_a, (xi - self.whole_e) - self.off_e
        divisor = a * e - self.b * self.c
        return a, e, divisor, comes_back(divisor, self.terms, self.angle, self.factor)


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

    @property
    def divisor(self) -> Array:
        """det(I − M_n): 0 in internal resonance; shape (…, N)."""
        return np.asarray(self.blocks.away(1.0)[2])

    @property
    def resonant(self) -> npt.NDArray[np.bool_]:
        """Which modes come back after a cycle by themselves, so that their amplitude is free; shape (…, N)."""
        return self.blocks.away(1.0)[3]


def solved(blocks: Blocks, xi: complex, u: Numbers, v: Numbers) -> tuple[Numbers, Numbers]:
    """(ξ − M_n)⁻¹(u_n, v_n), which broadcast with the blocks; in resonance the shortest that fits best."""
    a, e, divisor, singular = blocks.away(xi)
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


# ---- The motion through p impacts in n load periods, told by the times of the impacts alone

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
        step, blocks, u, v = self._elastic(flights, forced)
        end = u @ self.known.gamma
        if not self.system.body.is_free:
            return self._held(times, flights, forced, (step, blocks, u, v), rebound, side)
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
        )

    def _held(
        self,
        times: Array,
        flights: Array,
        forced: _Forced,
        elastic: tuple[Propagator, Blocks, Array, Array],
        rebound: Array | None,
        side: Side,
    ) -> Passage:
        """The passage of a body without rigid motion: all of its velocities are 0, and so must be one that is given."""
        step, blocks, u, v = elastic
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
        )

    # -- the elastic modes --

    def _elastic(self, flights: Array, forced: _Forced) -> tuple[Propagator, Blocks, Array, Array]:
        """Propagators, M_n, and u_n, u_n' just before each impact."""
        if not self.modes:
            none, nothing = np.empty((*flights.shape, 0)), np.empty((*flights.shape[:-1], 0))
            return Propagator(*(none,) * 6), Blocks(*(nothing,) * 9), none, none
        step = propagator(self.known.omega, self.known.damping, flights[..., None])
        blocks = Blocks.of(self.system.contact, self.known.damping, self.known.omega, step[:4], flights)
        return step, blocks, *self._before(step, forced, self._returning(step, blocks, forced))

    def _returning(self, step: Propagator, blocks: Blocks, forced: _Forced) -> tuple[Array, Array]:
        """The state after the first impact that comes back, less the forced one."""
        alpha, beta = self.system.contact.strain_factor, self.system.contact.velocity_factor
        u = v = np.zeros_like(step.b[..., 0, :])
        for i in range(self.impacts):
            sa, sb, sc, se = (part[..., i, :] for part in step[:4])
            to = (i + 1) % self.impacts
            u, v = (
                alpha * (sa * u + sb * v) + (alpha - 1.0) * forced.displacement[..., to, :],
                beta * (sc * u + se * v) + (beta - 1.0) * forced.velocity[..., to, :],
            )
        return solved(blocks, 1.0, u, v)

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


# ---- The linearised motion through p impacts, as p equations for the shifts of their times (theory: several impacts)
#
# With ρ the change of a mode's state at fixed times and δt_i the shift of impact i, a cycle later ξ times both,
#
#     ρ_{i+1} = D Φ(h_i) ρ_i + s_{i+1} δt_{i+1},   s = Dẋ⁻ − ẋ⁺ = ((α − β) v⁻, (α − β) ω² u⁻ − (1 − β) p),
#
# the saltation (Leine & Nijmeijer, Dynamics and Bifurcations of Non-Smooth Mechanical Systems, 2004, ch. 7). Every mode
# is eliminated, one 2×2 solve for each shift; that the striking end comes back to the wall over each flight is then
# K(ξ) δt = 0 (of a body that is held: that it is there at each impact). K(1) is the derivative of the equations for the
# times, and nothing is divided by the speed of an impact, so that all stays finite where one dies.

_NUMBERS = 1 << 20  # in an array of a sweep


def bordered(chain: ImpactChain, passage: Passage, xi: complex) -> Numbers:
    """K(ξ) with the change of the rigid velocity after the first impact as an unknown more, which comes last.

    The last row says that it is ξ times itself after a cycle. Shape (…, p + 1, p + 1).
    """
    p, beta, is_free = chain.impacts, chain.system.contact.velocity_factor, chain.system.body.is_free
    kind = complex if isinstance(xi, complex) else float
    found: Numbers = np.zeros((*passage.times.shape[:-1], p + 1, p + 1), dtype=kind)
    width = max(1, _NUMBERS // (passage.times.size * p))
    for first in range(0, chain.modes, width):
        found[..., :p, :p] = found[..., :p, :p] + _elastic(chain, passage, xi, slice(first, first + width))
    if not is_free:
        for i in range(p):
            found[..., i, i] += beta * passage.speed[..., i]
        found[..., p, p] = -1.0
        return found
    jump = -chain.system.contact.impulse * passage.force
    rate: Numbers = np.zeros((*passage.times.shape[:-1], p + 1), dtype=kind)  # of the rigid velocity, by each unknown
    rate[..., p] = 1.0
    for i in range(p):
        found[..., i, :] += passage.fade[..., i, None] * rate
        rate = beta * passage.stay[..., i, None] * rate
        to, turned = (i + 1, 1.0) if i + 1 < p else (0, xi)
        rate[..., to] = rate[..., to] + turned * jump[..., to]
        found[..., i, i] -= beta * passage.speed[..., i]
        found[..., i, to] += turned * passage.speed[..., to]
    found[..., p, :] = rate
    found[..., p, p] -= xi
    return found


def eliminated(matrix: Numbers) -> Numbers:
    """K(ξ) itself, shape (…, p, p), of the bordered matrix."""
    corner = matrix[..., -1:, -1:]
    return np.asarray(matrix[..., :-1, :-1] - matrix[..., :-1, -1:] * matrix[..., -1:, :-1] / corner)


def _elastic(chain: ImpactChain, passage: Passage, xi: complex, some: slice) -> Numbers:
    """What some of the elastic modes add to K(ξ): how each flight (row) moves the striking end per shift (column).

    Sweep by sweep with arrays of the shape (…, shifts, modes): first from nothing, then from the state that is ξ times
    itself after a cycle.
    """
    p, contact, known = chain.impacts, chain.system.contact, chain.known
    alpha, beta, gamma = contact.strain_factor, contact.velocity_factor, known.gamma[some]
    kick = (alpha - beta) * passage.velocity[..., some]
    pull = (alpha - beta) * known.omega[some] ** 2 * passage.displacement[..., some]
    kick_rate = pull - contact.impulse * passage.force[..., None]
    shape = (*passage.times.shape[:-1], p, gamma.size)
    u: Numbers = np.zeros(shape, dtype=complex if isinstance(xi, complex) else float)
    v: Numbers
    found: Numbers
    v, found = np.zeros_like(u), np.zeros((*shape[:-1], p), dtype=u.dtype)
    for last in (False, True):
        for i in range(p):
            a, b, c, e = (part[..., i, None, some] for part in passage.step[:4])
            start = u @ gamma if last else 0.0
            u, v = a * u + b * v, c * u + e * v
            if last:
                found[..., i, :] = u @ gamma - start if chain.system.body.is_free else start
            u, v = alpha * u, beta * v
            to, turned = (i + 1, 1.0) if i + 1 < p else (0, xi)
            u[..., to, :] = u[..., to, :] + turned * kick[..., to, :]
            v[..., to, :] = v[..., to, :] + turned * kick_rate[..., to, :]
        if not last:
            u, v = solved(Blocks(*(part[..., None, some] for part in passage.blocks)), xi, u, v)
    return found


# ---- det K(ξ) for many ξ at once: every mode is a pole of K(ξ) of rank two, which needs to be looked at only once
#
# With M_n the map of mode n through the cycle, r_j what the shift of impact j leaves of it a cycle later and R_i how
# its state after the first impact moves the striking end over flight i, K(ξ) is A_0 + ξA_1 + Σ R_i (ξ − M_n)⁻¹ r_j, the
# column of the first impact ξ times; and (ξ − M)⁻¹ = (ξ + adj)/det(ξ − M) for a 2×2 matrix.

_AWAY = 2.0  # a ξ that no mode has for an eigenvalue


class ManyNumbers(NamedTuple):
    """K(ξ) of one motion as a rational function of ξ, with the rigid velocity as an unknown more.

    Parameters
    ----------
    steady, turned
        A_0 and A_1; shapes (p + 1, p + 1).
    first, second
        γ_n R_i r_j and γ_n R_i adj(−M_n) r_j; shapes (N, p, p).
    blocks
        M_n.
    """

    steady: Array
    turned: Array
    first: Array
    second: Array
    blocks: Blocks

    @staticmethod
    def of(chain: ImpactChain, passage: Passage) -> ManyNumbers:
        """Of a motion whose times have the shape (p,)."""
        rows, columns, blocks = _rows(chain, passage), _columns(chain, passage), passage.blocks
        gamma = chain.known.gamma
        first = np.einsum("kin,kjn,n->nij", rows, columns, gamma)
        turned = np.stack(
            [-blocks.e * columns[0] + blocks.b * columns[1], blocks.c * columns[0] - blocks.a * columns[1]]
        )
        second = np.einsum("kin,kjn,n->nij", rows, turned, gamma)
        none = np.zeros((chain.impacts + 1, chain.impacts + 1))
        modes = ManyNumbers(none, none, first, second, blocks)
        ends = [bordered(chain, passage, xi) - modes.matrices(np.array([xi]))[0].real for xi in (_AWAY, -_AWAY)]
        return modes._replace(steady=0.5 * (ends[0] + ends[1]), turned=(ends[0] - ends[1]) / (2.0 * _AWAY))

    def matrices(self, xi: ComplexArray | Array) -> ComplexArray:
        """K(ξ) for an array of ξ, shape (m,); shape (m, p + 1, p + 1)."""
        xi = np.asarray(xi, dtype=complex)
        a, b, c, e = self.blocks.a, self.blocks.b, self.blocks.c, self.blocks.e
        weight = 1.0 / ((xi[:, None] - a) * (xi[:, None] - e) - b * c)
        p = self.steady.shape[0] - 1
        found: ComplexArray = np.asarray(self.steady + xi[:, None, None] * self.turned, dtype=complex)
        elastic = (xi[:, None] * weight) @ self.first.reshape(-1, p * p) + weight @ self.second.reshape(-1, p * p)
        elastic = elastic.reshape(-1, p, p)
        elastic[:, :, 0] *= xi[:, None]
        found[:, :p, :p] += elastic
        return found

    def directions(self, xi: ComplexArray | Array) -> ComplexArray:
        """det K(ξ) over its modulus; shape (m,)."""
        return np.asarray(np.linalg.slogdet(self.matrices(xi))[0])

    @property
    def poles(self) -> ComplexArray:
        """The eigenvalues of all M_n; shape (2N,)."""
        half = 0.5 * (self.blocks.a + self.blocks.e)
        root = np.sqrt((half**2 - (self.blocks.a * self.blocks.e - self.blocks.b * self.blocks.c)).astype(complex))
        return np.concatenate([half + root, half - root])


def _rows(chain: ImpactChain, passage: Passage) -> Array:
    """R_i: how u_n and u_n' after the first impact move the striking end over each flight; shape (2, p, N)."""
    alpha, beta = chain.system.contact.strain_factor, chain.system.contact.velocity_factor
    one, none = np.ones(chain.modes), np.zeros(chain.modes)
    u, v, found = (one, none), (none, one), np.empty((2, chain.impacts, chain.modes))
    for i in range(chain.impacts):
        a, b, c, e = (part[i] for part in passage.step[:4])
        for k in range(2):
            moved = a * u[k] + b * v[k]
            found[k, i] = moved - u[k] if chain.system.body.is_free else u[k]
        u, v = (
            tuple(alpha * (a * u[k] + b * v[k]) for k in range(2)),
            tuple(beta * (c * u[k] + e * v[k]) for k in range(2)),
        )
    return found


def _columns(chain: ImpactChain, passage: Passage) -> Array:
    """r_j: what the shift of each impact leaves of u_n and u_n' at the end of the cycle; shape (2, p, N)."""
    contact, known = chain.system.contact, chain.known
    alpha, beta = contact.strain_factor, contact.velocity_factor
    kick = (alpha - beta) * passage.velocity
    pull = (alpha - beta) * known.omega**2 * passage.displacement
    found = np.stack([kick, pull - contact.impulse * passage.force[:, None]])
    for i in range(1, chain.impacts):
        a, b, c, e = (part[i] for part in passage.step[:4])
        u, v = found[0, 1 : i + 1], found[1, 1 : i + 1]
        found[0, 1 : i + 1], found[1, 1 : i + 1] = alpha * (a * u + b * v), beta * (c * u + e * v)
    return found
