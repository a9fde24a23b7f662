"""The motion of a machine in closed form from an event on: no engine, only the formulas."""

from __future__ import annotations

import numpy as np

from percuss.model.checks import Array
from percuss.simulate.flight import drift, free_motion
from percuss.simulate.machine.mechanism import Mechanism

__all__ = ["flight", "sway"]

_TERMS = 24


def flight(mechanism: Mechanism, displacement: Array, velocity: Array, force: float, tau: Array) -> tuple[Array, Array]:
    """q_i and q_i', each of shape (N+1, len(tau)), at times `tau` ≥ 0 after a state, under a constant force.

    As long as the bar touches nothing. `displacement`, `velocity`: q_i and q_i' there, shape (N+1,).
    """
    elastic, machine = mechanism.slow, mechanism.machine
    d, w, b = machine.drag, mechanism.spring, velocity[0]
    pull = mechanism.gear.gain * force - w * w * displacement[0]
    h, integral = sway(d, w, tau)
    place = displacement[0] + b * h + pull * integral
    rate = b * (1.0 - d * h - w * w * integral) + pull * h
    if not elastic.omega.size:
        return place[None], rate[None]
    left, answer, answer_rate = free_motion(elastic, tau)
    still = force * elastic.statics[:, None]
    z, v = displacement[1:, None] - still, velocity[1:, None]
    q = still + z * left + v * answer
    q_rate = v * answer_rate - z * (elastic.omega[:, None] ** 2 * answer)
    return np.vstack([place, q]), np.vstack([rate, q_rate])


def sway(d: float, w: float, tau: Array) -> tuple[Array, Array]:
    """The answer to a unit push of a damped motion on a spring, h(0) = 0 and h'(0) = 1, and its integral; smooth in w.

    By the power series where little has happened, else by the closed form.
    """
    if w == 0.0:
        return drift(d, tau)
    half = 0.5 * d
    kappa = np.sqrt(complex(half * half - w * w))
    brief = (w * tau < 0.5) & (d * tau < 1.0)
    h, integral = np.empty(tau.shape), np.empty(tau.shape)
    t = tau[brief]
    x, y = d * t, (w * t) ** 2
    before, term = np.zeros(t.size), np.ones(t.size)
    h_series, sum_series = np.ones(t.size), np.full(t.size, 0.5)
    for k in range(1, _TERMS):
        before, term = term, -(x * term + y * before / k) / (k + 1.0)
        h_series += term
        sum_series += term / (k + 2.0)
    h[brief], integral[brief] = t * h_series, t * t * sum_series
    t = tau[~brief]
    if kappa.real > 1e-3 * half:  # the slow rate without cancellation
        rate = w * w / (half + kappa.real)
        slow = np.exp(-rate * t)
        answer = slow * -np.expm1(-2.0 * kappa.real * t) / (2.0 * kappa.real)
        fallen = -np.expm1(-rate * t) - rate * answer
    else:
        fade = np.exp(-half * t)
        turn = kappa * t
        small = np.abs(turn) < 1e-6
        sinh = np.where(small, 1.0 + turn * turn / 6.0, np.sinh(turn) / np.where(small, 1.0, turn)).real
        answer = fade * t * sinh
        fallen = 1.0 - fade * np.cosh(turn).real - half * answer
    h[~brief], integral[~brief] = answer, fallen / w**2
    return h, integral
