"""Energy over one impact period, term by term in closed form, so that the balance checks the orbit (theory §4).

Input ∮ p u_t(x_p, t) dt, damping Σ d_n ∮ u_n'² dt, and what the contact law takes of kinetic and strain energy at the
impact. The velocity is split into the forced part f' and the free part z' (for the mean motion: v_f and r);
δ = z(T) − z(0). What the forced part alone loses is what the load puts into it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from percuss.mechanics.flow import one_for_all, phi1, phi2, propagator
from percuss.model import System
from percuss.model.checks import Array
from percuss.shown import Shown
from percuss.steady.flight import Flown
from percuss.steady.forced import HarmonicResponse, PiecewiseResponse


@dataclass(frozen=True)
class Energy(Shown):
    """Energy over one impact period, dimensionless.

    Parameters
    ----------
    input
        Put in by the load.
    damping
        Taken by the damping.
    impact
        Taken by the impact.
    """

    input: float
    damping: float
    impact: float

    @property
    def imbalance(self) -> float:
        """input − damping − impact; rounding alone makes it differ from 0."""
        return self.input - self.damping - self.impact


def exchange(motion: Flown) -> tuple[float, float]:
    """Energy put in by the load, and taken by the damping, over a flight that takes whole load periods."""
    response = motion.response
    if isinstance(response, PiecewiseResponse):
        return _under_steps(motion, response)
    rigid, elastic = _rigid(motion, response.by_harmonics), _elastic(motion, response.by_harmonics)
    return rigid[0] + elastic[0], rigid[1] + elastic[1]


def _rigid(motion: Flown, response: HarmonicResponse) -> tuple[float, float]:
    d, p0, period = motion.system.d, motion.system.push, motion.period
    k, p, v = response.k, response.p, response.rigid_factor
    if not motion.system.body.is_free:
        return 0.0, 0.0
    turn = np.exp(1j * k * motion.phase)
    v_phi = float((v * turn).real.sum())
    start = motion.rigid_rebound - v_phi
    once, twice = period * float(phi1(d * period)), period**2 * float(phi2(d * period))
    fade = once / (d - 1j * k) * (d * start - p0)  # ∮ exp(ikt) r(t) dt
    half_turns = 0.5 * period
    put_in = half_turns * float((np.conj(p) * v).real.sum()) + float((p * turn * fade).real.sum())
    put_in += p0 * float(motion.rigid_motion(np.array([period]))[0][0])
    end = p0 * once + start * math.exp(-d * period)
    free = p0 * (p0 * twice + start * once) - 0.5 * (end**2 - start**2)
    damped = d * half_turns * float(np.sum(np.abs(v) ** 2)) + 2.0 * d * float((v * turn * fade).real.sum())
    return put_in, damped + free if d > 0.0 else 0.0


def _elastic(motion: Flown, response: HarmonicResponse) -> tuple[float, float]:
    k, p, state, system = response.k, response.p, motion.state, motion.system
    modes, gain = system.body.modes(state.omega.size, system.load.at), response.gains(state.omega.size)
    driven = modes.weight @ gain if motion.cut else response.driven_shape()
    square, weight = state.omega**2, modes.weight
    end, end_velocity = (a[:, 0] for a in motion.transient(np.array([motion.period])))
    jump, jump_velocity = end - state.z, end_velocity - state.z_velocity
    turned = p * np.exp(1j * k * motion.phase)
    work = np.conj(gain) * (square[:, None] * jump[:, None] + 1j * k * jump_velocity[:, None])  # ∮ exp(ikt) z'(t) dt
    put_in = float(weight @ ((work @ turned).real + system.load.mean * jump))
    free = 0.5 * (state.z_velocity**2 - end_velocity**2 + square * (state.z**2 - end**2))
    cross = 2.0 * modes.damping * ((gain * work) @ (1j * k * turned)).real
    damped = float(weight @ np.where(modes.damping > 0.0, free + cross, 0.0))
    forced = float(np.sum(0.5 * motion.period * np.abs(p) ** 2 * (1j * k * driven).real))
    return put_in + forced, damped + forced if np.any(modes.damping) else 0.0


def _under_steps(motion: Flown, response: PiecewiseResponse) -> tuple[float, float]:
    """Between its breaks a piecewise load is constant: every mode is a free oscillator about its static place."""
    ahead = np.mod(response.starts[None, :] - motion.phase, 2.0 * math.pi)
    ahead = (ahead + 2.0 * math.pi * np.arange(motion.periods)[:, None]).reshape(-1)
    knots = np.unique(np.concatenate([[0.0], ahead, [motion.period]]))
    knots = knots[np.append(True, np.diff(knots) > 1e-13)]
    knots[-1] = motion.period
    system, lengths = motion.system, np.diff(knots)
    force = system.load.value(motion.phase + 0.5 * (knots[1:] + knots[:-1]))
    u, v = motion.rigid_motion(knots)
    put_in = float(force @ np.diff(u))
    damped = put_in - 0.5 * float(v[-1] ** 2 - v[0] ** 2) if system.d > 0.0 else 0.0
    f, f_velocity = response.modal(motion.modes, motion.phase + knots)
    f[:, -1], f_velocity[:, -1] = f[:, 0], f_velocity[:, 0]  # a whole number of turns, to the last digit
    z, z_velocity = motion.transient(knots)
    w, w_velocity = f + z, f_velocity + z_velocity
    modes = system.body.modes(motion.modes, system.load.at)
    omega, damping = modes.omega[:, None], modes.damping[:, None]
    put_in += float(modes.weight @ (np.diff(w, axis=1) @ force))
    away = w[:, :-1] - force[None, :] / omega**2
    lost = _dissipated(omega, damping, (away, w_velocity[:, :-1]), lengths[None, :])
    return put_in, damped + float(modes.weight @ lost.sum(axis=1))


def _dissipated(omega: Array, d: npt.ArrayLike, start: tuple[Array, Array], t: Array) -> Array:
    """d ∫₀ᵗ z'² of free oscillators from (z, z'), from z' = Re Z exp((−d/2 + iλ)t); overdamped ones by their loss."""
    z, v = start
    d = one_for_all(d)
    if not np.any(d):
        return np.zeros(np.broadcast_shapes(np.shape(omega), np.shape(z), np.shape(t)))
    ringing = omega > 0.5 * d * (1.0 + 1e-3)
    rate = np.sqrt(np.where(ringing, omega**2 - 0.25 * d**2, 1.0))
    exponent = -0.5 * d + 1j * rate
    amplitude = exponent * (z - 1j * (v + 0.5 * d * z) / rate)
    swing = (amplitude**2 * np.expm1(2.0 * exponent * t) / (2.0 * exponent)).real
    lost = 0.5 * (np.abs(amplitude) ** 2 * -np.expm1(-d * t) + d * swing)
    step = propagator(omega, d, t)
    end, end_v = step.a * z + step.b * v, step.c * z + step.e * v
    fallen = 0.5 * (v**2 - end_v**2 + omega**2 * (z**2 - end**2))
    return np.asarray(np.where(ringing, lost, fallen))


# ---- What damping takes in flights of any duration, which quadrature gives to rounding

_NODES = 12  # of Gauss's rule, in half a period of the fastest that moves


class Stretch(NamedTuple):
    """A flight: the phase of the load at its start, how long it takes, and velocities of the modes 0 … N in it."""

    phase: float
    duration: float
    rates: Callable[[Array], Array]


def damped(system: System, modes: int, flights: Iterable[Stretch]) -> float:
    """Energy that the damping of the body with modes 0 … N takes in flights."""
    known, load = system.body.modes(modes, system.load.at), system.load
    share = np.append(system.d, known.damping * known.weight)
    if not share.any():
        return 0.0
    fastest = max(1.0, *known.omega[-1:].tolist(), *load.harmonics[-1:].tolist())
    nodes, weights = np.polynomial.legendre.leggauss(_NODES)
    found = []
    for phase, duration, rates in flights:
        ahead = np.mod(np.asarray(load.breaks) - phase, 2.0 * math.pi)
        ahead = (ahead[:, None] + 2.0 * math.pi * np.arange(duration // (2.0 * math.pi) + 1)).reshape(-1)
        even = np.linspace(0.0, duration, math.ceil(duration * fastest / math.pi) + 1)
        edges = np.unique(np.concatenate([even, ahead[ahead < duration]]))
        half = 0.5 * np.diff(edges)[:, None]
        t = (edges[:-1, None] + half * (nodes + 1.0)).reshape(-1)
        found.append(float(share @ rates(t) ** 2 @ (half * weights).reshape(-1)))
    return math.fsum(found)
