"""All steady motions of a system whose blows take time, beside those of B77's law."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from percuss.errors import ParameterError
from percuss.mechanics.flow import phi1
from percuss.model import System, Timed
from percuss.model.checks import Array, array, count, instance, numbers
from percuss.model.contact import impedance_ratio
from percuss.model.load import Side
from percuss.short_repr import ShortRepr
from percuss.steady.flight import Flight, Violation, flight_check
from percuss.steady.forced import HarmonicResponse, forced_response
from percuss.steady.multipliers import Multipliers, Reason, Repeating
from percuss.steady.orbit import Orbit
from percuss.steady.oscillator import modal_state
from percuss.steady.phases import Arcs, level_at
from percuss.steady.states import MAX_PERIODS, SteadyStates, steady_states
from percuss.steady.trigonometric import TURN, on_circle

# ---- One steady motion whose blows take time: the bar as a whole between them, and what a blow carries

_STRONG_RINGING = 0.05  # of the speed of the blow, from which on it is warned of
_LONG = 0.05  # share of the load period from which on the duration of a blow is warned of
_LOOKED_AT = 8  # elastic modes among which the slowest is looked for


@dataclass(frozen=True)
class TimedOrbit(Repeating):
    """A steady motion with one blow every `periods` load periods under a law `Timed`; made by `timed_states`.

    Times are in radians of the load after the centroid of the blow's force; all quantities are dimensionless. The bar
    moves as a whole: the ringing that a blow leaves is taken to die out before the next one.

    Parameters
    ----------
    phase
        φ_J, the phase of the load at the centroid of the force, in [0, 2π).
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

    impacts = 1
    modes = 0

    @property
    def label(self) -> str:
        """z=1/m."""
        return f"z=1/{self.periods}"

    @property
    def times(self) -> tuple[float, ...]:
        """The phase of its blow."""
        return (self.phase,)

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
    def _flight(self) -> Flight:
        rebound, nothing = self.rebound_velocity, np.empty(0)
        state = modal_state(self.system, self.period, (nothing, nothing))
        return Flight(self.system, 0, self.phase, self.period, state, rebound, rebound, self.rigid_velocity)

    def rigid_motion(self, t: Array) -> tuple[Array, Array]:
        """Displacement since the centroid of the force, and velocity, of the mean of the bar; shapes of `t`.

        From the end of the contact to the start of the next one.
        """
        return self._flight.rigid_motion(np.asarray(t, dtype=float))

    def motion(self, t: npt.ArrayLike) -> Array:
        """How far the bar as a whole is before the place of its next contact; 0 during contacts. Shape (len(t),)."""
        start, end = self.contact
        times = np.mod(array("t", t, -np.inf, np.inf), self.period)
        flies = (times > end) & (times < self.period + start)
        there = self.rigid_motion(np.append(times[flies], self.period + start))[0]
        found = np.zeros(times.size)
        found[flies] = there[:-1] - there[-1]
        return found

    @cached_property
    def _between_contacts(self) -> tuple[Flight, float]:
        """The flight from the end of a contact to the start of the next, and what of its places is not decided."""
        start, end = self.contact
        places, speeds = self.rigid_motion(np.array([end, self.period + start]))
        greatest_force = self._flight.response.rigid_bounds()[1] + abs(self.system.load.mean)
        undecided = 0.5 * greatest_force * self.law.duration**2
        leaving, arrival = (float(speed) for speed in speeds)
        flown = replace(
            self._flight, phase=self.phase + end, period=self.period + start - end, rigid_rebound=leaving,
            rebound_velocity=leaving, impact_velocity=arrival, start_gap=float(places[0] - places[1]) - undecided,
        )  # fmt: skip
        return flown, undecided

    @property
    def stroke(self) -> float:
        """Range of the motion of the bar as a whole between its contacts."""
        flown = self._between_contacts[0]
        return flown.mean_range(flown.rigid_rebound)

    @property
    def impact_velocity(self) -> float:
        """`contact_velocity`, as other motions call it."""
        return self.contact_velocity

    @property
    def energy(self) -> None:
        """None: what damping takes of the ringing is not told by the law."""

    @property
    def figures(self) -> dict[str, float | None]:
        """The figures that maps and reports have, by name; dimensionless, None where there is none."""
        own = {"impulse": self.impulse, "mean_force": self.impulse / self.period, "contact_time": self.law.duration}
        return {**super().figures, **own}

    @cached_property
    def violation(self) -> Violation | None:
        """Where the bar as a whole would pass through the impact plane between two blows, or None.

        Decided by bounds, for the rigid motion, to second order in the duration: what passes the plane by less than
        half the greatest load times t_c² counts as none. The elastic motion is that of B77's motion, which `b77` has.
        """
        flown, undecided = self._between_contacts
        found = flight_check(replace(flown, rigid_stroke=self.stroke or 1.0)).violation
        return None if found is None else Violation(found.time + self.contact[1], found.depth + undecided)

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

    # -- is it stable --
    #
    # With t the time of the force's centroid and W the mean velocity that the bar would reach there, a blow and the
    # flight after it map (t, W) to (t', W'). J = (1 + R)(1 + δ)(W − e p) leaves W − J; the drag and the load make W' of
    # that until t'; and the bar moves by A J + t_J [(W' − p' t_J) − (W − p t_J)], as both contacts begin t_J earlier,
    # where it meets the impact plane. The map is linearised here; without duration and advance it is B77's for a rigid
    # bar. What is of second order in the duration is kept as this map has it, not as the waves have it.

    def _slope(self, force: float) -> Array:
        """(dt, dW) before a blow to (dt', dW') before the next one; shape (2, 2)."""
        law, d, period, load = self.law, self.system.d, self.period, self.system.load
        slope = 0.0 if load.is_piecewise else float(load.derivative(self.phase))
        before, after, centroid = self.rigid_velocity, self.rebound_velocity, law.force_centroid
        kept, moved = math.exp(-d * period), period * float(phi1(d * period))
        push_before, push_after = force - d * before, force - d * after  # accelerations of the mean
        columns = []
        for dt, dw in ((1.0, 0.0), (0.0, 1.0)):
            dj = law.impulse(dw, slope * dt, d)
            left = dw - dj
            lag = (law.advance_per_impulse * dj + (centroid * kept - moved) * left - centroid * dw) + dt * (
                after + push_after * (moved - centroid * kept) + centroid**2 * slope
            )
            later = lag / (before - centroid * push_before + centroid**2 * slope)
            columns.append((later, kept * (left - push_after * dt) + push_before * later))
        return np.array(columns).T

    def _multipliers(self, side: Side) -> Multipliers:
        """Both; of a load that jumps during the contact those of its first or its last value there."""
        return self._under(self.forces[0 if side == "left" else -1])

    def _under(self, force: float) -> Multipliers:
        values = np.linalg.eigvals(self._slope(force)).astype(complex).tolist()
        values.sort(key=lambda x: (-round(abs(x), 13), -x.real, -x.imag))
        return Multipliers(self.label, 0, np.array(values), self.system)

    def judged(self, modes: int | None = None) -> Multipliers:
        """`multipliers`; of a load that jumps during the contact those of its worst value there."""
        self.multipliers(modes)
        return max(map(self._under, self.forces), key=lambda one: one.largest)

    @property
    def verdict(self) -> Reason | None:  # type: ignore[override]
        """What the multipliers say; None where the load jumps just where the blow is, which the law cannot judge."""
        return None if self.straddles else Reason.FOLD if self.fold else super().verdict

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


# ---- Which load phases are impact phases when the blow takes time (`percuss.model.Timed`): all of them, with proof
#
# With W the mean velocity that the bar would reach at the centroid of the blow's force, J the impulse and a = A J the
# advance of the impact plane, the flight from W − J to W over T moves the bar by a. That asks for J = p_0 T − d a and
#
#     v_f(φ) − e p(φ) = c − a E/(T φ1(dT)) − [p_0 T/(1 + R) − J/((1 + R)(1 + δ))]
#
# with c of B77 (14) and δ of the drag during the contact; without damping c − a/T. Under harmonics the left side is a
# sum of waves. Under a load of steps it jumps by −e Δp where the load does; a level inside such a jump is met by a blow
# during which the load jumps, whose mean load lies between the two values.

_SAME = 1e-9  # phases this near are one root, if the curve passes in the same direction


class TimedRoot(NamedTuple):
    """An impact phase, whether two motions meet there, and the load that acts on average during the blow."""

    phase: float
    fold: bool
    force: float


@lru_cache(maxsize=32)
def _armed(system: System, arm: float) -> HarmonicResponse:
    """The response with v_f − e p in place of v_f, for `Arcs`; without the mean load."""
    response = HarmonicResponse(system)
    return response.meeting(response.rigid_factor - arm * response.p)


def _matched(phases: Array, phases_b77: Array, curve: Array, curve_b77: Array) -> list[int | None]:
    """Of each root of one curve the root of the other one that it continues, or None."""
    # Between the two laws the condition moves in proportion: (1 − ε) of the one plus ε of the other. A root of the one
    # goes over to a root of the other, without meeting a fold that ends it, exactly if both curves pass their levels in
    # the same direction there and neither has another root between the two. The curves, less their levels, are told in
    # the middle between each root and the one after it.
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


# ---- All steady motions of a system whose blows take time, beside those of B77's law


@dataclass(frozen=True)
class TimedStates(ShortRepr):
    """The steady motions with one blow every `periods` load periods under a law `Timed`.

    Parameters
    ----------
    system, law, periods
        The system, with the restitution of the law, the law, and m.
    b77
        The steady motions of B77's law with the same restitution.
    """

    system: System
    law: Timed
    periods: int
    b77: SteadyStates

    @cached_property
    def level(self) -> float:
        """What v_f − e p meets at the phases: c − a/T without drag."""
        law, period, d, mean = self.law, 2.0 * math.pi * self.periods, self.system.d, self.system.load.mean
        impulse = law.steady_impulse(mean, period, d)
        weight = math.exp(-d * period) / (period * float(phi1(d * period)))
        slower = law.velocity(mean * period, 0.0) - law.velocity(impulse, 0.0, d)  # by the drag; 0 without it
        lowered = law.advance_per_impulse * impulse * weight + slower
        return float(level_at(mean, d, impedance_ratio(law.restitution), period)) - lowered

    @property
    def level_max(self) -> float:
        """max (v_f − e p): motions exist while level ≤ level_max."""
        if self._stepwise:
            arcs, lifted = self._arcs, self.law.arm * np.asarray(self.system.load.values)
            return float(max((arcs.velocities[:-1] - lifted).max(), (arcs.velocities[1:] - lifted).max()))
        return self._arcs.highest - self.law.arm * self.system.load.mean

    def curve(self, phase: npt.ArrayLike) -> Array:
        """v_f − e p at the given load phases (rad), right-sided at a jump of the load."""
        theta = numbers("phase", phase)
        return forced_response(self.system).rigid_velocity(theta) - self.law.arm * self.system.load.value(theta)

    @property
    def _stepwise(self) -> bool:
        return self.system.load.is_piecewise and self.law.arm != 0.0

    @cached_property
    def _roots(self) -> tuple[TimedRoot, ...]:
        if self._stepwise:
            return self._among_steps()
        phases, folds = self._arcs.roots(self.level + self.law.arm * self.system.load.mean)
        forces = self.system.load.value(phases)
        return tuple(TimedRoot(*one) for one in zip(phases.tolist(), folds.tolist(), forces.tolist(), strict=True))

    @cached_property
    def _arcs(self) -> Arcs:
        arm = self.law.arm if not self.system.load.is_piecewise else 0.0
        return Arcs.of(forced_response(self.system) if arm == 0.0 else _armed(self.system, arm))

    def _among_steps(self) -> tuple[TimedRoot, ...]:
        """On the pieces, where v_f meets the level raised by e p_i, and at the breaks between them."""
        arcs, forces = self._arcs, np.asarray(self.system.load.values)
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

    @cached_property
    def orbits(self) -> tuple[TimedOrbit, ...]:
        """Every motion in order of phase, physically possible or not."""
        roots = self._roots
        kept = self.b77.orbits
        phases, phases_b77 = np.array([root.phase for root in roots]), np.array([orbit.phase for orbit in kept])
        partners = _matched(
            phases,
            phases_b77,
            self.curve(_middles(phases)) - self.level,
            self.b77.rigid_velocity(_middles(phases_b77)) - self.b77.level,
        )
        return tuple(
            TimedOrbit(self.system, self.law, self.periods, *root, None if i is None else kept[i])
            for root, i in zip(roots, partners, strict=True)
        )

    @property
    def ended(self) -> tuple[Orbit, ...]:
        """The motions of B77's law that have no motion here: the duration of the blow ends them in a fold."""
        continued = {orbit.b77.phase for orbit in self.orbits if orbit.b77 is not None}
        return tuple(orbit for orbit in self.b77.orbits if orbit.phase not in continued)

    @property
    def exists(self) -> bool:
        """Whether any motion of this kind exists."""
        return bool(self._roots)

    def __str__(self) -> str:
        head = f"z=1/{self.periods}, {self.law.law}: level {self.level:.6g}, max {self.level_max:.6g}, "
        return "\n".join([f"{head}{len(self.orbits)} orbits", *(f"  {orbit}" for orbit in self.orbits)])


def _middles(phases: Array) -> Array:
    return np.asarray(phases + 0.5 * np.diff(np.append(phases, phases[:1] + TURN)))


def timed_states(system: System, law: Timed, periods: int = 1, *, modes: int | None = None) -> TimedStates:
    """Every steady motion with one blow every `periods` load periods when the blow takes time.

    The phases are roots of v_f(φ) − e p(φ) = c(R) − a/T, with e = 2 t_J − t_c and the advance a = A J, and
    V(φ) = J/(1 + R) + e p(φ); a drag changes both a little. All roots are found, whatever the load. Right to first
    order in the duration over the period.

    Parameters
    ----------
    system
        The bar and its load; its restitution is replaced by that of the law.
    modes
        Elastic modes of the motions of B77's law beside it, as in `steady_states`.

    Raises
    ------
    LoadError, ResonanceError
        As `steady_states`.
    ParameterError
        When the contact takes as long as the time from blow to blow, and for periods or modes out of range.

    Examples
    --------
    >>> from percuss import Load, System, Timed
    >>> system = System(s=20.0, d=0.0048, restitution=0.6, load=Load.harmonic(0.9, 1.0))
    >>> for orbit in timed_states(system, Timed.of_uniform_bar(20.0, 0.6)).orbits:
    ...     print(f"{orbit.phase:.6f} {orbit.phase_b77:.6f} {orbit.rigid_velocity:.6f} {orbit.admissible}")
    0.783913 0.800558 3.533740 True
    2.348080 2.331435 3.533740 True
    """
    instance("system", system, System), instance("law", law, Timed)
    m = count("periods", periods, most=MAX_PERIODS)
    if not law.duration < 2.0 * math.pi * m:
        raise ParameterError(
            "duration", law.duration, f"less than the time from blow to blow, {2.0 * math.pi * m:.4g} rad",
            "such a contact has no flight after it: resolve it by waves",
        )  # fmt: skip
    same = system if system.restitution == law.restitution else system.with_restitution(law.restitution)
    return TimedStates(same, law, m, steady_states(same, m, modes=modes))
