"""Which load phases are impact phases when the blow takes time (`percuss.model.Timed`): all of them, with proof.

With W the mean velocity that the bar would reach at the centroid of the blow's force, J the impulse and a = A J the
advance of the impact plane, the flight from W − J to W over T moves the bar by a. That asks for J = p_0 T − d a and

    v_f(φ) − e p(φ) = c − a E/(T φ1(dT)) − [p_0 T/(1 + R) − J/((1 + R)(1 + δ))]

with c of B77 (14) and δ of the drag during the contact; without damping c − a/T. Under harmonics the left side is a
sum of waves. Under a load of steps it jumps by −e Δp where the load does; a level inside such a jump is met by a blow
during which the load jumps, whose mean load lies between the two values.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import NamedTuple

import numpy as np

from percuss.model import System, Timed
from percuss.model.checks import Array
from percuss.model.contact import impedance_ratio
from percuss.steady.harmonic import HarmonicResponse
from percuss.steady.level import level_at
from percuss.steady.oscillator import phi1
from percuss.steady.phases import Arcs, forced_response
from percuss.steady.trigonometric import TURN, on_circle

__all__ = ["TimedCondition", "TimedRoot", "matched_roots", "timed_condition"]

_SAME = 1e-9  # phases this near are one root, if the curve passes in the same direction


class TimedRoot(NamedTuple):
    """An impact phase, whether two motions meet there, and the load that acts on average during the blow."""

    phase: float
    fold: bool
    force: float


@dataclass(frozen=True)
class TimedCondition:
    """The curve v_f − e p and the level that it meets at the impact phases.

    Parameters
    ----------
    system, law
        The bar, its load, and the law of its blow.
    level
        The right-hand side above.
    """

    system: System
    law: Timed
    level: float

    def curve(self, theta: Array) -> Array:
        """v_f − e p, right-sided at a jump of the load; shape of `theta`."""
        return forced_response(self.system).rigid_velocity(theta) - self.law.arm * self.system.load.value(theta)

    @property
    def highest(self) -> float:
        """The greatest v_f − e p: motions exist while the level is not above it."""
        if self._stepwise:
            arcs, lifted = self._arcs, self.law.arm * self._forces
            return float(max((arcs.velocities[:-1] - lifted).max(), (arcs.velocities[1:] - lifted).max()))
        return self._arcs.highest - self.law.arm * self._kept_mean

    @cached_property
    def roots(self) -> tuple[TimedRoot, ...]:
        """All impact phases, increasing."""
        if self._stepwise:
            return self._among_steps()
        phases, folds = self._arcs.roots(self.level + self.law.arm * self._kept_mean)
        forces = self.system.load.value(phases)
        return tuple(TimedRoot(*one) for one in zip(phases.tolist(), folds.tolist(), forces.tolist(), strict=True))

    @property
    def _stepwise(self) -> bool:
        """Whether the curve jumps."""
        return self.system.load.is_piecewise and self.law.arm != 0.0

    @property
    def _kept_mean(self) -> float:
        return self.system.load.mean

    @property
    def _forces(self) -> Array:
        return np.asarray(self.system.load.values)

    @cached_property
    def _arcs(self) -> Arcs:
        arm = self.law.arm if not self.system.load.is_piecewise else 0.0
        return Arcs.of(forced_response(self.system) if arm == 0.0 else _armed(self.system, arm))

    def _among_steps(self) -> tuple[TimedRoot, ...]:
        """On the pieces, where v_f meets the level raised by e p_i, and at the breaks between them."""
        arcs, forces = self._arcs, self._forces
        raised = self.level + self.law.arm * forces
        noise = arcs.tolerance + 8.0 * np.finfo(float).eps * abs(self.law.arm) * float(np.abs(forces).max())
        start, end = arcs.velocities[:-1] - raised, arcs.velocities[1:] - raised
        flat = arcs.response.flat & (np.abs(start) <= noise)
        start, end = (np.where(np.abs(x) <= noise, 0.0, x) for x in (start, end))
        found = [
            TimedRoot(0.5 * float(arcs.ends[i] + arcs.ends[i + 1]), True, float(forces[i]))
            for i in np.flatnonzero(flat)
        ]
        inside = np.flatnonzero(start * end < 0.0)
        phases = arcs.invert(inside, raised[inside])
        found += [TimedRoot(float(x), False, float(forces[i])) for x, i in zip(phases, inside, strict=True)]
        for i in range(forces.size):
            before, after = float(end[i - 1]), float(start[i])
            if before * after > 0.0 or flat[i] or flat[i - 1]:
                continue
            # just before the break the curve comes from the end of its piece, or from its start where that is the level
            comes, goes = before or float(start[i - 1]), after or float(end[i])
            force = (float(arcs.velocities[i]) - self.level) / self.law.arm
            found.append(TimedRoot(float(arcs.ends[i]), comes * goes > 0.0, force))
        return tuple(sorted(TimedRoot(float(on_circle(np.array(x))), fold, force) for x, fold, force in found))


@lru_cache(maxsize=32)
def _armed(system: System, arm: float) -> HarmonicResponse:
    """The response with v_f − e p in place of v_f, for `Arcs`; without the mean load."""
    response = HarmonicResponse(system)
    response.rigid_factor = response.rigid_factor - arm * response.p
    return response


def timed_condition(system: System, law: Timed, periods: int) -> TimedCondition:
    """The condition for impacts once in `periods` load periods."""
    period, d, mean = 2.0 * math.pi * periods, system.d, system.load.mean
    impulse = law.steady_impulse(mean, period, d)
    weight = math.exp(-d * period) / (period * float(phi1(d * period)))
    slower = law.velocity(mean * period, 0.0) - law.velocity(impulse, 0.0, d)  # by the drag; 0 without it
    lowered = law.advance_per_impulse * impulse * weight + slower
    return TimedCondition(system, law, float(level_at(mean, d, impedance_ratio(law.restitution), period)) - lowered)


def matched_roots(phases: Array, phases_b77: Array, curve: Array, curve_b77: Array) -> list[int | None]:
    """Of each root of one curve the root of the other one that it continues, or None.

    Between the two laws the condition moves in proportion: (1 − ε) of the one plus ε of the other. A root of the one
    goes over to a root of the other, without meeting a fold that ends it, exactly if both curves pass their levels in
    the same direction there and neither has another root between the two.

    Parameters
    ----------
    phases, phases_b77
        Roots in [0, 2π), increasing.
    curve, curve_b77
        Each curve less its level in the middle between each root and the one after it; shapes of the roots.
    """
    rises, rises_b77 = _directions(curve), _directions(curve_b77)
    found: list[int | None] = []
    for phase, rise in zip(phases, rises, strict=True):
        ahead, back = np.mod(phases_b77 - phase, TURN), np.mod(phase - phases_b77, TURN)
        near = [int(np.argmin(away)) for away in (ahead, back)] if phases_b77.size else []
        choice = [i for i in near if rises_b77[i] == rise and _clear(float(phase), float(phases_b77[i]), phases)]
        found.append(min(choice, key=lambda i: min(ahead[i], back[i]), default=None))
    return found


def _directions(between: Array) -> Array:
    """1 where a curve passes its level upwards, −1 downwards, 0 where it touches it."""
    return np.asarray((np.sign(between) - np.sign(np.roll(between, 1))) / 2.0)


def _clear(phase: float, other: float, phases: Array) -> bool:
    """Whether no other root lies between a root and one of the other law, the shorter way."""
    way = math.remainder(other - phase, TURN)
    if abs(way) <= _SAME:
        return True
    along = np.mod((phases - phase) * math.copysign(1.0, way), TURN)
    return not np.any((along > 0.0) & (along < abs(way)) & (phases != phase))
