"""One steady motion whose blows take time: the bar as a whole between them, and what a blow carries."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from percuss.model import System, Timed
from percuss.model.checks import Array
from percuss.shown import Shown
from percuss.steady.admissible import Violation
from percuss.steady.orbit import Orbit
from percuss.steady.reason import Reason
from percuss.steady.timed_flight import RigidFlight

__all__ = ["TimedOrbit"]

_STRONG_RINGING = 0.05  # of the speed of the blow, from which on it is warned of
_LONG = 0.05  # share of the load period from which on the duration of a blow is warned of
_LOOKED_AT = 8  # elastic modes among which the slowest is looked for


@dataclass(frozen=True)
class TimedOrbit(Shown):
    """A steady motion with one blow every `periods` load periods under a law `Timed`; made by `timed_states`.

    Times are in radians of the load after the centroid of the blow's force; all quantities are dimensionless. The bar
    moves as a whole: the ringing that a blow leaves is taken to die out before the next one.

    Parameters
    ----------
    system, law
        What vibrates, and the law of its blow.
    periods
        m, the load periods per blow.
    phase
        φ_J, the phase of the load at the centroid of the force, in [0, 2π).
    fold
        Whether two steady motions meet here.
    force
        p(φ_J); of a blow during which the load jumps, the load that acts on average.
    b77
        The motion of B77's law with the same restitution that this one continues, or None.
    """

    system: System
    law: Timed
    periods: int
    phase: float
    fold: bool
    force: float
    b77: Orbit | None = None

    @property
    def phase_b77(self) -> float | None:
        """The impact phase of B77's motion, or None."""
        return None if self.b77 is None else self.b77.phase

    @property
    def phase_shift(self) -> float | None:
        """How much later than in B77's motion the centroid of the force is, from −π to π; or None."""
        return None if self.b77 is None else math.remainder(self.phase - self.b77.phase, 2.0 * math.pi)

    @property
    def period(self) -> float:
        """T = 2πm, from blow to blow."""
        return 2.0 * math.pi * self.periods

    # -- the blow --

    @property
    def impulse(self) -> float:
        """J of a blow: p_0 T without drag."""
        return self.law.steady_impulse(self.system.load.mean, self.period, self.system.d)

    @property
    def advance(self) -> float:
        """a, by which the impact plane moves on from blow to blow."""
        return self.law.advance_per_impulse * self.impulse

    @property
    def rigid_velocity(self) -> float:
        """V(φ_J): mean velocity of the bar that it would reach at the centroid of the force without the blow."""
        return self.law.velocity(self.impulse, self.force, self.system.d)

    @property
    def contact_velocity(self) -> float:
        """Mean velocity of the bar at the start of the contact."""
        return float(self.rigid_motion(np.array([self.period - self.law.force_centroid]))[1][0])

    @property
    def rebound_velocity(self) -> float:
        """Mean velocity after the blow, brought back to the centroid of the force: V − J."""
        return self.rigid_velocity - self.impulse

    @property
    def blow_energy(self) -> float:
        """½ V², the kinetic energy of the rigid motion; of B77's motion half the square of its `rigid_velocity`."""
        return 0.5 * self.rigid_velocity**2

    @property
    def ringing_energy(self) -> float:
        """What of the blow's energy rings on in the bar, as in the one blow that the law was taken from."""
        return self.law.ringing_share * self.blow_energy

    @property
    def delivered_energy(self) -> float:
        """What of the blow's energy goes through the face into what is struck: all but rebound and ringing."""
        return self.law.delivered_share * self.blow_energy

    @property
    def energy_change(self) -> float | None:
        """By how much the energy of the blow is greater than that of B77's rigid motion, relative; or None."""
        return None if self.b77 is None else (self.rigid_velocity / self.b77.rigid_velocity) ** 2 - 1.0

    @property
    def contact(self) -> tuple[float, float]:
        """Start and end of the contact, in radians after the centroid of the force."""
        return -self.law.force_centroid, self.law.after_centroid

    @cached_property
    def forces(self) -> tuple[float, ...]:
        """The values of the load that count at the blow: of a load of steps every one that it has during the contact,
        and both sides of a jump at an instantaneous one.
        """
        load = self.system.load
        if not load.is_piecewise:
            return (self.force,)
        breaks, (start, end) = np.asarray(load.breaks), self.contact
        jumps = self.phase + start + np.mod(breaks - self.phase - start, 2.0 * math.pi)
        first = float(load.value(self.phase + start, "left"))
        passed = sorted(float(x) for x in jumps if x <= self.phase + end)
        return tuple(dict.fromkeys([first, *(float(load.value(x)) for x in passed)]))

    @property
    def straddles(self) -> bool:
        """Whether the load jumps where the law says that the blow is, so that it acts with a value between two."""
        return self.law.arm != 0.0 and self.force not in self.forces

    @property
    def ringing_left(self) -> float:
        """Ringing that a blow leaves to the next one, as a speed over that of the blow."""
        return self.law.ringing_left(_slowest_decay(self.system), self.period)

    # -- the flight --

    @cached_property
    def _flight(self) -> RigidFlight:
        return RigidFlight(self.system, self.phase, self.rebound_velocity)

    def rigid_motion(self, t: Array) -> tuple[Array, Array]:
        """Displacement since the centroid of the force, and velocity, of the mean of the bar; shapes of `t`.

        From the end of the contact to the start of the next one.
        """
        return self._flight.motion(t)

    @cached_property
    def violation(self) -> Violation | None:
        """Where the bar as a whole would pass through the impact plane between two blows, or None.

        Decided by bounds, for the rigid motion, to second order in the duration: what passes the plane by less than
        half the greatest load times t_c² counts as none. The elastic motion is that of B77's motion, which `b77` has.
        """
        start, end = self.contact
        undecided = 0.5 * self._flight.greatest_force * self.law.duration**2
        return self._flight.passage(end, self.period + start, undecided)

    @property
    def obstacle(self) -> Reason | None:
        """Why the motion is not physical; None for one that is."""
        if not (self.contact_velocity > 0.0 and self.rigid_velocity > 0.0):
            return Reason.NO_BLOW
        return None if self.violation is None else Reason.THROUGH_WALL

    @property
    def admissible(self) -> bool:
        """Whether the motion is physical as far as the motion of the bar as a whole tells."""
        return self.obstacle is None

    @cached_property
    def warnings(self) -> tuple[str, ...]:
        """What of the law's assumptions this motion does not keep, one sentence each."""
        texts = []
        if self.law.contacts > 1:
            texts.append(
                f"the blow has {self.law.contacts} contacts and the law holds for one: take its figures for a first "
                "guess, and resolve the contacts by waves ('percuss simulate CASE --contact waves')"
            )
        if self.ringing_left > _STRONG_RINGING:
            texts.append(
                f"of the ringing that a blow leaves {100.0 * self.ringing_left:.3g} % of the striking speed is left at "
                "the next blow; the law takes it to have died out"
            )
        if len(self.forces) > 1 and self.law.duration > 0.0:
            texts.append("the load jumps during the contact; the law takes it to change slowly")
        if self.law.duration > _LONG * 2.0 * math.pi:
            share = 100.0 * self.law.duration / (2.0 * math.pi)
            texts.append(f"the contact takes {share:.3g} % of the load period; the law is right for short ones")
        return tuple(texts)

    def __str__(self) -> str:
        where = "admissible" if self.admissible else "not admissible"
        also = "" if self.phase_b77 is None else f" (B77 {self.phase_b77:.6f})"
        return (
            f"TimedOrbit z=1/{self.periods}: phase {self.phase:.6f} rad{also}, speed {self.rigid_velocity:.6g}, {where}"
        )


def _slowest_decay(system: System) -> float:
    """The rate by which the slowest of the first elastic modes dies out, per radian: d_1/2 as a rule."""
    modes = system.body.modes(_LOOKED_AT)
    half = 0.5 * modes.damping
    swinging = half <= modes.omega
    rest = np.sqrt(np.where(swinging, 0.0, half**2 - modes.omega**2))
    return float(np.where(swinging, half, modes.omega**2 / (half + rest + (half == 0.0))).min())
