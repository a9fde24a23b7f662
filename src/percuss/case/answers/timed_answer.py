"""What a law that knows the duration of the blow says of the steady motions of a case, beside B77's law."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from percuss.case.answers.json_values import number, plain
from percuss.shown import Shown
from percuss.stability import timed_stability
from percuss.steady import timed_states

if TYPE_CHECKING:
    from percuss.model import System, Timed
    from percuss.stability import Stability, TimedStability
    from percuss.steady import Orbit, TimedOrbit, TimedStates

__all__ = ["TimedAnswer", "TimedPeriod", "blow_dict", "timed_period"]


@dataclass(frozen=True)
class TimedAnswer(Shown):
    """One steady motion whose blows take time, and its stability."""

    orbit: TimedOrbit
    stability: TimedStability

    @property
    def runs(self) -> bool:
        """Whether a hammer can sustain this motion: admissible and stable."""
        return self.orbit.admissible and self.stability.stable

    def to_json_dict(self, judged: Stability | None = None) -> dict[str, Any]:
        """The motion in plain values; with the verdict on the motion of B77's law, if it continues one."""
        orbit, verdict = self.orbit, self.stability
        violation = orbit.violation
        return plain(
            {
                "phase": orbit.phase,
                "phase_b77": orbit.phase_b77,
                "phase_shift": orbit.phase_shift,
                "rigid_velocity": orbit.rigid_velocity,
                "contact_velocity": orbit.contact_velocity,
                "impulse": orbit.impulse,
                "blow_energy": orbit.blow_energy,
                "energy_change": orbit.energy_change,
                "delivered_energy": orbit.delivered_energy,
                "ringing_energy": orbit.ringing_energy,
                "advance": orbit.advance,
                "contact_start": orbit.contact[0],
                "contact_end": orbit.contact[1],
                "ringing_left": orbit.ringing_left,
                "admissible": orbit.admissible,
                "passage_time": None if violation is None else violation.time,
                "passage_depth": None if violation is None else violation.depth,
                "stable": verdict.stable,
                "reason": verdict.reason,
                "margin": verdict.margin,
                "margin_b77": None if judged is None else judged.margin_rhythm,
                "multipliers": self.multipliers,
                "warnings": list(orbit.warnings),
            }
        )

    @property
    def in_orbit(self) -> dict[str, Any]:
        """What stands in the motion of B77's law: both multipliers, and the advance in m or lengths of the bar."""
        orbit = self.orbit
        length = orbit.system.length_scale if orbit.system.is_si else 1.0
        return {"blow_multipliers": self.multipliers, "advance_per_blow": number(orbit.advance * length)}

    @property
    def multipliers(self) -> list[list[float]]:
        """Both multipliers as pairs [re, im]."""
        return [[value.real, value.imag] for value in self.stability.multipliers]


@dataclass(frozen=True)
class TimedPeriod(Shown):
    """All motions with one blow in `states.periods` load periods under the law, in order of phase."""

    states: TimedStates
    orbits: tuple[TimedAnswer, ...]

    def continuing(self, orbit: Orbit) -> TimedAnswer | None:
        """The motion that continues one of B77's, or None where the duration of the blow ends it."""
        found = (one for one in self.orbits if one.orbit.phase_b77 == orbit.phase)
        return next(found, None)

    @property
    def alone(self) -> tuple[TimedAnswer, ...]:
        """The motions that continue none of B77's."""
        return tuple(one for one in self.orbits if one.orbit.b77 is None)

    def to_json_dict(self, judged: Mapping[float, Stability]) -> dict[str, Any]:
        """Level, existence and motions; with the verdicts on the motions of B77's law by their phases."""
        return {
            "level": number(self.states.level),
            "level_max": number(self.states.level_max),
            "exists": self.states.exists,
            "orbits": [
                one.to_json_dict(None if one.orbit.phase_b77 is None else judged[one.orbit.phase_b77])
                for one in self.orbits
            ],
        }


def timed_period(system: System, law: Timed, periods: int, modes: int | None) -> TimedPeriod:
    """The answer of the law for one blow in so many load periods."""
    states = timed_states(system, law, periods, modes=modes)
    return TimedPeriod(states, tuple(TimedAnswer(orbit, timed_stability(orbit)) for orbit in states.orbits))


def blow_dict(law: Timed, system: System, periods: Sequence[int]) -> dict[str, Any]:
    """The numbers of the law: in seconds and metres for a system in SI, else in radians and lengths of the bar.

    The advance is that of a blow in the first of the `periods`; it goes with the impulse, and so with m.
    """
    time, length = (system.time_scale, system.length_scale) if system.is_si else (1.0, 1.0)
    period = 2.0 * math.pi * (periods[0] if periods else 1)
    advance = law.advance_per_impulse * law.steady_impulse(system.load.mean, period, system.d)
    return plain(
        {
            "law": law.law,
            "effective_restitution": law.restitution,
            "contact_duration": law.duration * time,
            "force_centroid": law.force_centroid * time,
            "advance_per_blow": advance * length,
            "ringing_share": law.ringing_share,
            "contacts": law.contacts,
        }
    )
