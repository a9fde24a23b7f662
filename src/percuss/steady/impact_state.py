"""The state of the elastic modes at the impact of a steady motion (B77 12, 13; theory §4).

With D = diag(α, β) of the contact law, β = −R, and Φ the propagator over the impact period T, the transient just after
the impact is z = (I − DΦ)⁻¹(D − I) f, and the state just before it x = (I − ΦD)⁻¹(I − Φ) f; with α = 1 the velocity is
f' det(I − Φ)/det(I − DΦ), and the displacement the same before and after.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from percuss.model import System
from percuss.model.checks import Array
from percuss.steady.oscillator import flights

__all__ = ["ModalState", "modal_state", "resolvent_bound"]

_TURNED = 4.0 * np.finfo(float).eps  # error of the angle λT, relative: nearer to whole turns is resonance itself


@dataclass(frozen=True)
class ModalState:
    """Elastic modes n = 1 … N at the impact; every array of shape (N,), dimensionless.

    Parameters
    ----------
    omega
        Undamped frequencies ω_n.
    displacement, velocity
        u_n and u_n' just before the impact.
    rebound
        u_n just after the impact: the contact law's α times `displacement`.
    z, z_velocity
        Transient part (u_n − f_n, u_n' − f_n') just after the impact.
    forced_velocity
        f_n' at the impact phase.
    divisor
        det(I − DΦ): how near the mode is to resonance with the impacts (0 = resonant).
    """

    omega: Array
    displacement: Array
    velocity: Array
    rebound: Array
    z: Array
    z_velocity: Array
    forced_velocity: Array
    divisor: Array

    @property
    def amplitude(self) -> Array:
        """Bound of |z_n(t)| for all t ≥ 0, because the energy of a free oscillation never grows; shape (N,)."""
        return np.asarray(np.hypot(self.z, self.z_velocity / self.omega))

    def first(self, modes: int) -> ModalState:
        """The first `modes` of the modes; itself when it has no more."""
        if modes >= self.omega.size:
            return self
        return ModalState(*(getattr(self, name)[:modes] for name in self.__dataclass_fields__))


def modal_state(system: System, period: float, forced: tuple[Array, Array]) -> ModalState:
    """Solve the steady condition mode by mode.

    Parameters
    ----------
    system, period
        The system and the impact period T = 2πm.
    forced
        f_n and f_n' at the impact phase, each of shape (N,).
    """
    (f, f_velocity), contact = forced, system.contact
    alpha, beta, impulse = contact.strain_factor, contact.velocity_factor, contact.impulse
    released = 1.0 - alpha  # 0 for the law that keeps the strain
    modes, step = flights(system.body, system.load.at, period, f.size)
    omega, d = modes.omega, modes.damping
    loss = -np.expm1(-0.5 * d * period)  # 1 − exp(−dT/2)
    half_d_b = 0.5 * d * step.b
    still = loss**2 + 2.0 * step.versine  # det(I − Φ)
    kept = loss * (1.0 - beta * step.half) + (1.0 + beta) * step.versine - impulse * half_d_b  # det(I − DΦ) for α = 1
    divisor = kept + released * (step.a - beta * step.half**2)
    one_minus_a = loss + step.versine - half_d_b
    singular = divisor <= 2.0 * (1.0 + beta) * (_TURNED * omega * period) ** 2  # only without damping
    safe = np.where(singular, 1.0, divisor)
    push = -impulse * f_velocity
    # an undamped mode in exact resonance with the impacts only fixes its velocity
    z = (push * step.b * alpha - released * (1.0 - beta * step.e) * f) / safe
    z = np.where(singular, 0.0, z)
    z_velocity = (push * (one_minus_a + released * step.a) - released * beta * step.c * f) / safe
    z_velocity = np.where(singular, -f_velocity, z_velocity)
    velocity = f_velocity * (still + released * (step.a - step.half**2)) - released * step.c * f
    velocity = np.where(singular, 0.0, velocity / safe)
    displacement = np.where(singular, f, f * (kept / safe) + push * step.b / safe)
    return ModalState(omega, displacement, velocity, f + z, z, z_velocity, f_velocity, divisor)


def resolvent_bound(system: System, period: float, omega: float, d: float) -> float:
    """A number B with ω_n |z_n| + |z_n'| ≤ B |f_n'| for every mode from one with `omega` and `d` on; inf when d = 0.

    For the contact law that keeps the strain, and modes whose share of critical damping does not rise.
    """
    contact = system.contact
    half = float(np.exp(-0.5 * d * period))
    rate = float(np.sqrt(max(omega**2 - 0.25 * d**2, 0.0)))
    if rate == 0.0:
        return float("inf")
    slip = 0.5 * d / rate * half
    least = -float(np.expm1(-0.5 * d * period)) * (1.0 - contact.velocity_factor * half) - contact.impulse * slip
    if least <= 0.0:
        return float("inf")
    return contact.impulse * (half * omega / rate + 1.0 + half + slip) / least
