"""Blows that have a closed form: what the waves are checked with, and the limits that formulas in use have.

St Venant (1867) for the uniform striker, Lundberg (1973) for a rectangular wave on rock.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from percuss.errors import ParameterError
from percuss.model.checks import count, non_negative, positive

BEST_BETA = 1.2564312086261697
"""β at which a rectangular wave does most work on rock: e^β = 1 + 2β."""


@dataclass(frozen=True)
class UniformBlow:
    """A uniform striker on a wall or an endless uniform rod: its constant force in the first round trip, 2τ.

    After that the contact of a striker that is no stiffer than the rod ends; only there is the restitution that B77's
    law takes, (Z_2 − Z)/(Z_2 + Z), the ratio of speeds. `passed` is the share of the energy that passes in the first
    step, 4 Z Z_2/(Z + Z_2)².
    """

    force: float
    duration: float
    restitution: float
    passed: float


def uniform_blow(impedance: float, transit: float, velocity: float, rod: float = math.inf) -> UniformBlow:
    """The first step of a blow of a uniform striker of Z and τ on a rod of Z_2 (St Venant 1867).

    Impedances in N·s/m (`rod`: inf for a rigid wall), times in s, velocities in m/s.

    Examples
    --------
    >>> z = 3.14e-4 * (210e9 * 7800) ** 0.5
    >>> round(uniform_blow(z, 1.0 / (210e9 / 7800) ** 0.5, 0.1).force, 6)
    1270.827478
    """
    z, v, duration = (
        positive("impedance", impedance),
        positive("velocity", velocity),
        2.0 * positive("transit", transit),
    )
    if rod == math.inf:
        return UniformBlow(z * v, duration, 1.0, 0.0)
    other = positive("rod", rod)
    both = z + other
    return UniformBlow(v * z * other / both, duration, (other - z) / both, 4.0 * z * other / both**2)


def staircase_force(impedance: float, rod: float, velocity: float, step: int) -> float:
    """Force during the round trip number `step`, from 0 on, of a uniform striker that is stiffer than the rod.

    v Z Z_2/(Z + Z_2) μ^k with μ = (Z − Z_2)/(Z + Z_2): the contact never ends (Fischer 1959).

    Examples
    --------
    >>> staircase_force(2.0, 1.0, 3.0, 1)
    0.6666666666666666
    """
    first = uniform_blow(impedance, 1.0, velocity, rod)
    return first.force * _steps(first, impedance, step)


def staircase_velocity(impedance: float, rod: float, velocity: float, steps: int) -> float:
    """Velocity of the same striker after so many round trips, v μ^k: all of it moves as one then.

    Examples
    --------
    >>> staircase_velocity(2.0, 1.0, 9.0, 2)
    1.0
    """
    return velocity * _steps(uniform_blow(impedance, 1.0, velocity, rod), impedance, steps)


def _steps(first: UniformBlow, impedance: float, steps: int) -> float:
    if not first.restitution < 0.0:
        raise ParameterError("impedance", impedance, "more than that of the rod", "else the contact has one step")
    return float((-first.restitution) ** count("steps", steps, 0))


def two_section_restitution(rear: float, head: float) -> float:
    """R of a striker of two sections with equal transit times on a rigid wall: 1 − 2ρ², ρ = (Z_1 − Z_2)/(Z_1 + Z_2).

    Examples
    --------
    >>> round(two_section_restitution(1.0, 2.0), 9)
    0.777777778
    """
    one, two = positive("rear", rear), positive("head", head)
    rho = (one - two) / (one + two)
    if not -0.5 < rho <= 0.25 * (math.sqrt(5.0) - 1.0):
        accepted = "impedances whose difference is −1/2 to 0.309 times their sum"
        raise ParameterError("rear", rear, accepted, "use strike for all others")
    return 1.0 - 2.0 * rho * rho


def matched_efficiency(beta: float, unloading_ratio: float, feed: float = 0.0) -> float:
    """Share of a rectangular wave's energy that becomes work on rock: 2 (1 − γ)(1 − e^{−β})²/β (Lundberg 1973).

    Under a feed force F with φ (1 − e^{−β}) in the numerator beside the square, paid by the feed: φ = F/(Z v_i) of the
    wave's particle velocity v_i (docs/feed.md, closed forms).

    β = K_1 T/Z, T the duration of the wave: 2 K_1 L/(AE) for a hammer of the rod's impedance; γ is the rock's unloading
    ratio.

    Examples
    --------
    >>> round(matched_efficiency(BEST_BETA, 1e-300), 10)
    0.8145287552
    """
    done = -math.expm1(-positive("beta", beta))
    return 2.0 * (1.0 - _ratio(unloading_ratio)) * (done**2 + non_negative("feed", feed) * done) / beta


def best_efficiency(beta: float, unloading_ratio: float) -> float:
    """The same of the best wave of this duration, which grows like e^{K_1 t/Z}: (1 − γ)(1 − e^{−2β}).

    Examples
    --------
    >>> round(best_efficiency(BEST_BETA, 1e-300), 3)
    0.919
    """
    return -(1.0 - _ratio(unloading_ratio)) * math.expm1(-2.0 * positive("beta", beta))


def _ratio(value: float) -> float:
    found = positive("unloading_ratio", value)
    if found > 1.0:
        raise ParameterError("unloading_ratio", value, "a number greater than 0 and at most 1")
    return found
