"""A law that knows the duration of the blow, and its motions beside those of B77's law, in words."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from percuss.case.answers.numerals import number, percent, quantity
from percuss.steady.reason import Reason

if TYPE_CHECKING:
    from percuss.case.answers.timed_answer import TimedAnswer
    from percuss.model import System, Timed
    from percuss.stability import Stability

__all__ = ["ENDED", "law_in_words", "timed_in_words"]

ENDED = "this motion does not exist when the blow takes time: it has met another one in a fold"
"""What is said of a motion of B77's law that the duration of the blow ends."""


def law_in_words(law: Timed, system: System) -> str:
    """The numbers of the law."""
    text = f"{law.law}: restitution {number(law.restitution)}, contact {_time(law.duration, system)}, centroid of its "
    text += f"force after {_time(law.force_centroid, system)}; "
    text += "the impact plane moves on from blow to blow" if law.advance_per_impulse else "the impact plane stays"
    text += f"; ringing takes {percent(law.ringing_share)} of the energy before the blow" if law.ringing_share else ""
    return f"{text}; {law.contacts} contacts, where the law holds for one" if law.contacts > 1 else text


def timed_in_words(found: TimedAnswer, judged: Stability | None = None) -> list[str]:
    """A motion in lines: its phase, its blow, its verdict beside that on B77's motion, and what makes it impossible."""
    orbit, system = found.orbit, found.orbit.system
    beside = "" if judged is None else f" (B77's rhythm {number(judged.margin_rhythm, 3)})"
    margin = f"{_verdict(found)}; margin {number(found.stability.margin, 3)}{beside}"
    lines = [_phase(found), _blow(found), _delivered(found), margin]
    if orbit.obstacle is Reason.NO_BLOW:
        lines.append("not possible: at the start of the contact the bar would be moving away from the wall")
    elif orbit.violation is not None:
        depth = orbit.violation.depth
        told = quantity(depth * system.length_scale, "m") if system.is_si else number(depth)
        lines.append(f"not possible: between the blows the bar would be {told} beyond the place of the next one")
    return lines


def _phase(found: TimedAnswer) -> str:
    orbit, system = found.orbit, found.orbit.system
    text = f"force centred at {number(orbit.phase, 5)} rad = {number(math.degrees(orbit.phase))}°"
    shift = orbit.phase_shift
    if shift is None:
        return f"{text}; no motion of B77's law corresponds to it"
    when = "later" if shift >= 0.0 else "earlier"
    how = quantity(abs(shift) * system.time_scale, "s", 3) if system.is_si else f"{number(abs(shift), 3)} rad"
    return f"{text}, {how} {when} than B77's impact"


def _blow(found: TimedAnswer) -> str:
    orbit, system = found.orbit, found.orbit.system
    if system.is_si:
        speed = f"{number(orbit.rigid_velocity * system.speed_scale)} m/s"
        energy = quantity(orbit.blow_energy * system.energy_scale, "J")
        advance = quantity(orbit.advance * system.length_scale, "m", 3)
    else:
        speed, energy, advance = number(orbit.rigid_velocity, 6), number(orbit.blow_energy, 6), number(orbit.advance)
    change = orbit.energy_change
    beside = "" if change is None else f" ({'+' if change >= 0.0 else ''}{percent(change)} against B77's rigid motion)"
    text = f"speed {speed}, energy {energy}{beside}"
    return f"{text}; the impact plane moves on by {advance} per blow" if orbit.advance else text


def _delivered(found: TimedAnswer) -> str:
    orbit, system = found.orbit, found.orbit.system

    def told(energy: float) -> str:
        return quantity(energy * system.energy_scale, "J") if system.is_si else number(energy, 6)

    text = f"{told(orbit.delivered_energy)} delivered to what is struck"
    return f"{text}; {told(orbit.ringing_energy)} ring on in the bar" if orbit.ringing_energy else text


def _verdict(found: TimedAnswer) -> str:
    reason, verdict = found.stability.reason, "stable" if found.stability.stable else "unstable"
    return reason if reason.startswith(verdict) else f"{verdict}: {reason}"


def _time(radians: float, system: System) -> str:
    return quantity(radians * system.time_scale, "s", 3) if system.is_si else f"{number(radians)} rad"
