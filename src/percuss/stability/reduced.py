"""B77's reduced stability criterion (29)–(32): valid for s ≫ 1/π.

For s → ∞ it is the criterion of the rigid bar and holds for every contact law. What it adds for a finite s, the
feedback σ of the elastic modes, holds for the law that keeps the strain; for others σ = 0.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
import numpy.typing as npt

from percuss.model.body import need_free
from percuss.model.checks import Array, instance
from percuss.model.contact import Result
from percuss.shown import Shown
from percuss.steady import Orbit

__all__ = ["Reduced", "elastic_feedback", "quadratic_coefficients", "reduced_criterion", "schur_quotients"]

X = TypeVar("X", float, Array)


@dataclass(frozen=True)
class Reduced(Shown):
    """The reduced criterion for one orbit, all numbers dimensionless.

    Parameters
    ----------
    sigma
        σ, the feedback of the elastic modes; 0 for a contact law that it does not hold for.
    a
        a_0, a_1, a_2 of a_2 ξ² + a_1 ξ + a_0 = 0.
    schur
        |a_0/a_2| and |a_1/(a_0 + a_2)|; stable when both are less than 1.
    moduli
        Moduli of the two roots ξ, largest first.
    other_side
        The same with the load's value on the other side of a jump at the impact phase, or None.
    """

    sigma: float
    a: tuple[float, float, float]
    schur: tuple[float, float]
    moduli: tuple[float, float]
    other_side: Reduced | None = None

    @property
    def stable(self) -> bool:
        """Whether both Schur quotients are less than 1, on both sides of a jump."""
        here = max(self.schur) < 1.0
        return here and (self.other_side is None or self.other_side.stable)


def elastic_feedback(orbit: Orbit) -> float:
    """σ = (1/(p_0 T)) Σ_k Re[g_k(1) p_k ik exp(ikφ)] with the body's receptance g_k, the sum over all modes.

    For B77's bar g_k(1) = 2 Σ_{n≥1} (−1)ⁿ H_nk. That is the forced elastic velocity of the striking end at the impact,
    in units of p_0 T. A piecewise load enters with the harmonics that it keeps: the sum over all k does not converge
    without damping.

    Raises
    ------
    ParameterError
        For a contact law that changes the strain: the multipliers do not depend on σ then.
    """
    orbit.system.contact.need(Result.FEEDBACK)
    return orbit.response.by_harmonics.end_velocity(orbit.phase) / (orbit.system.load.mean * orbit.period)


def quadratic_coefficients(
    d: float, velocity_factor: npt.ArrayLike, period: float, sigma: npt.ArrayLike, slope: npt.ArrayLike
) -> tuple[Array, Array, Array]:
    """a_0, a_1, a_2 of B77 (29)–(31), β = −R of the contact law; `slope` is v_f'(φ)/p_0. Broadcasts."""
    a_0, a_1, a_2 = _coefficients(d, period, *(np.asarray(x, dtype=float) for x in (velocity_factor, sigma, slope)))
    return np.asarray(a_0), np.asarray(a_1), np.asarray(a_2)


def _coefficients(d: float, period: float, beta: X, sigma: X, slope: X) -> tuple[X, X, X]:
    """a_0, a_1, a_2 for scalars or arrays; scalars take a tenth of the time of arrays of size 1."""
    decay, gain = math.exp(-d * period), -math.expm1(-d * period) / (d * period) if d * period else 1.0
    impulse = 1.0 - beta
    fed = impulse * sigma
    a_2 = 1.0 + fed
    a_1 = -1.0 - beta**2 * decay - gain * impulse**2 * slope - (1.0 + beta * decay) * fed
    a_0 = beta * decay * (beta + fed)
    return a_0, a_1, a_2


def schur_quotients(a_0: Array, a_1: Array, a_2: Array) -> tuple[Array, Array]:
    """|a_0/a_2| and |a_1/(a_0 + a_2)| (B77 32); inf where a denominator vanishes."""
    with np.errstate(divide="ignore", invalid="ignore"):
        first, second = np.abs(a_0 / a_2), np.abs(a_1 / (a_0 + a_2))
    return np.where(np.isnan(first), np.inf, first), np.where(np.isnan(second), np.inf, second)


def reduced_criterion(orbit: Orbit) -> Reduced:
    """B77's criterion for an orbit, with both one-sided values where the load jumps at the impact.

    For a contact law that turns the strain over it is that of the rigid bar, σ = 0; the multipliers of an elastic one
    differ from it at first order in 1/s there.

    References
    ----------
    U. Björkenstam, Int. J. Mech. Sci. 19 (1977) 471–481, equations (29)–(32).
    """
    need_free(instance("orbit", orbit, Orbit).system.body, "B77's reduced criterion")
    load = orbit.system.load
    *left, right = (float(load.value(orbit.phase, side)) for side in load.sides)
    other = _with_force(orbit, left[0], None) if left and left[0] != right else None
    return _with_force(orbit, right, other)


def _with_force(orbit: Orbit, force: float, other: Reduced | None) -> Reduced:
    system = orbit.system
    v_phi = float(orbit.response.rigid_velocity(np.array([orbit.phase]))[0])
    slope = (force - system.load.mean - system.d * v_phi) / system.load.mean  # v_f' = p − p_0 − d v_f
    sigma = elastic_feedback(orbit) if system.contact.holds(Result.FEEDBACK) else 0.0
    a_0, a_1, a_2 = _coefficients(system.d, orbit.period, system.contact.velocity_factor, sigma, slope)
    schur = _quotient(a_0, a_2), _quotient(a_1, a_0 + a_2)
    return Reduced(sigma, (a_0, a_1, a_2), schur, _moduli(a_0, a_1, a_2), other)


def _quotient(above: float, below: float) -> float:
    return abs(above / below) if below else math.inf


def _moduli(a_0: float, a_1: float, a_2: float) -> tuple[float, float]:
    """Moduli of the roots of a_2 ξ² + a_1 ξ + a_0, largest first, without cancellation."""
    if a_2 == 0.0:
        return (math.inf, abs(a_0 / a_1) if a_1 else math.inf)
    discriminant = a_1 * a_1 - 4.0 * a_2 * a_0
    if discriminant < 0.0:
        modulus = math.sqrt(a_0 / a_2)
        return (modulus, modulus)
    big = -0.5 * (a_1 + math.copysign(math.sqrt(discriminant), a_1))
    first, second = abs(big / a_2), abs(a_0 / big) if big else 0.0
    return (max(first, second), min(first, second))
