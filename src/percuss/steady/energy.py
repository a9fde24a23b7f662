"""Energy over one impact period, term by term in closed form, so that the balance checks the orbit (theory §4).

Input ∮ p u_t(0, t) dt, damping d ∮∫ u_t² dx dt, impact ½(1 − R²) ∫ u_t(x, 0⁻)² dx. The velocity is split into the
forced part f' and the free part z' (for the mean motion: v_f and r); δ = z(T) − z(0).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from percuss.model.checks import Array, ComplexArray
from percuss.shown import Shown
from percuss.steady.harmonic import HarmonicResponse
from percuss.steady.oscillator import dissipated, mode_frequencies, phi1, phi2
from percuss.steady.piecewise import PiecewiseResponse

if TYPE_CHECKING:
    from percuss.steady.motion import Motion

__all__ = ["Energy", "energy_balance"]


@dataclass(frozen=True)
class Energy(Shown):
    """Energy over one impact period, dimensionless.

    Parameters
    ----------
    input
        Put in by the load.
    damping
        Taken by the viscous damping.
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


def energy_balance(motion: Motion) -> Energy:
    """The energy balance of an orbit with the modes that its sums use."""
    response = motion.response
    if isinstance(response, HarmonicResponse):
        rigid, elastic = _rigid_harmonic(motion, response), _elastic_harmonic(motion, response)
        put_in, damped = rigid[0] + elastic[0], rigid[1] + elastic[1]
    else:
        put_in, damped = _piecewise(motion, response)
    return Energy(put_in, damped, motion.delivered_energy)


def _rigid_harmonic(motion: Motion, response: HarmonicResponse) -> tuple[float, float]:
    d, p0, period = motion.system.d, motion.system.load.mean, motion.period
    k, p, v = response.k, response.p, response.rigid_factor
    turn = np.exp(1j * k * motion.phase)
    v_phi = float((v * turn).real.sum())
    start = -motion.system.restitution * motion.rigid_velocity - v_phi
    once, twice = period * float(phi1(d * period)), period**2 * float(phi2(d * period))
    fade = once / (d - 1j * k) * (d * start - p0)  # ∮ exp(ikt) r(t) dt
    half_turns = 0.5 * period
    put_in = half_turns * float((np.conj(p) * v).real.sum()) + float((p * turn * fade).real.sum())
    put_in += p0 * float(motion.rigid_motion(np.array([period]))[0][0])
    end = p0 * once + start * math.exp(-d * period)
    free = p0 * (p0 * twice + start * once) - 0.5 * (end**2 - start**2)
    damped = d * half_turns * float(np.sum(np.abs(v) ** 2)) + 2.0 * d * float((v * turn * fade).real.sum())
    return put_in, damped + free if d > 0.0 else 0.0


def _elastic_harmonic(motion: Motion, response: HarmonicResponse) -> tuple[float, float]:
    d, k, p, state = motion.system.d, response.k, response.p, motion.state
    square = state.omega**2
    end, end_velocity = (a[:, 0] for a in motion.transient(np.array([motion.period])))
    jump, jump_velocity = end - state.z, end_velocity - state.z_velocity
    gain = response.gains(state.omega.size)
    turned = p * np.exp(1j * k * motion.phase)
    work = np.conj(gain) * (square[:, None] * jump[:, None] + 1j * k * jump_velocity[:, None])  # ∮ exp(ikt) z'(t) dt
    put_in = 2.0 * (float((work @ turned).real.sum()) + motion.system.load.mean * float(jump.sum()))
    free = 0.5 * float(np.sum(state.z_velocity**2 - end_velocity**2 + square * (state.z**2 - end**2)))
    cross = 2.0 * d * float(((gain * work) @ (1j * k * turned)).real.sum())
    damped = 2.0 * (free + cross) if d > 0.0 else 0.0
    if motion.requested_modes is None:
        driven, spread = response.shapes(np.array([0.0]))[0][:, 0], _mean_square_shape(response)
    else:
        driven, spread = 2.0 * gain.sum(axis=0), 2.0 * (np.abs(gain) ** 2).sum(axis=0)
    weight = 0.5 * motion.period * np.abs(p) ** 2
    put_in += float(np.sum(weight * (1j * k * driven).real))
    damped += d * float(np.sum(weight * k**2 * spread))
    return put_in, damped


def _mean_square_shape(response: HarmonicResponse) -> Array:
    """∫₀¹ |g_k(x)|² dx in closed form; shape (K,)."""
    q: ComplexArray = response.q
    a, b = 2.0 * q.real, 2.0 * np.abs(q.imag)
    bounded = np.minimum(b, 600.0)
    hyperbolic = np.where(bounded > 0.0, np.sinh(bounded) / np.where(b > 0.0, b, 1.0), 1.0)
    whole = (hyperbolic + np.sin(a) / a) / (np.abs(q) ** 2 * 2.0 * (np.sinh(0.5 * bounded) ** 2 + np.sin(0.5 * a) ** 2))
    return np.asarray((whole - 1.0 / np.abs(q) ** 4) / response.system.s**4)


def _piecewise(motion: Motion, response: PiecewiseResponse) -> tuple[float, float]:
    """Between its breaks a piecewise load is constant: every mode is a free oscillator about its static place."""
    ahead = np.mod(response.starts[None, :] - motion.phase, 2.0 * math.pi)
    ahead = (ahead + 2.0 * math.pi * np.arange(motion.periods)[:, None]).reshape(-1)
    knots = np.unique(np.concatenate([[0.0], ahead, [motion.period]]))
    knots = knots[np.append(True, np.diff(knots) > 1e-13)]
    knots[-1] = motion.period
    d, lengths = motion.system.d, np.diff(knots)
    force = motion.system.load.value(motion.phase + 0.5 * (knots[1:] + knots[:-1]))
    u, v = motion.rigid_motion(knots)
    put_in = float(force @ np.diff(u))
    damped = put_in - 0.5 * float(v[-1] ** 2 - v[0] ** 2) if d > 0.0 else 0.0
    f, f_velocity = response.modal(motion.modes, motion.phase + knots)
    f[:, -1], f_velocity[:, -1] = f[:, 0], f_velocity[:, 0]  # a whole number of turns, to the last digit
    z, z_velocity = motion.transient(knots)
    w, w_velocity = f + z, f_velocity + z_velocity
    omega = mode_frequencies(motion.system.s, motion.modes)[:, None]
    put_in += 2.0 * float((force[None, :] * np.diff(w, axis=1)).sum())
    away = w[:, :-1] - force[None, :] / omega**2
    damped += 2.0 * float(dissipated(omega, d, (away, w_velocity[:, :-1]), lengths[None, :]).sum())
    return put_in, damped
