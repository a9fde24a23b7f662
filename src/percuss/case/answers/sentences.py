"""The first lines of an answer: one home of its sentences, for the terminal and for the report as a file."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from percuss.case.answers.clock_note import CLOCKED, clock_in_short
from percuss.case.answers.facts import Teller
from percuss.case.answers.numerals import counted, number, percent
from percuss.stability import orbit_multipliers
from percuss.steady.orbit import Reason

if TYPE_CHECKING:
    from percuss.case.answers.ends import End, Ends
    from percuss.case.answers.steady_answer import OrbitAnswer, SteadyAnswer, TimedAnswer
    from percuss.model import System, Timed
    from percuss.stability import Stability
    from percuss.steady import PeriodicOrbit, Rest


# ---- Where random starts end, in words: the same for the terminal and for a report


def ends_sentence(ends: Ends, running: set[str], system: System) -> str:
    """The sentence of a summary; `running` holds the labels of the steady motions that can be sustained."""
    if not ends.followed:
        return ""
    there = sum(end.starts for end in ends.ends if end.label in running)
    others = [end for end in ends.ends if end.label not in running]
    many = "The random start" if ends.followed == 1 else f"All {ends.followed} random starts"
    where = "in this motion" if len(running) == 1 else "in one of these motions"
    if running and not others:
        return f"{many} {'ends' if ends.followed == 1 else 'end'} {where}."
    told = [f"{end.starts} {does(end.label, end.starts, _delivered(end, system))}" for end in others]
    if running:
        there_first = [f"{there or 'none'} {'ends' if there == 1 else 'end'} {where}"]
        return f"Of {_starts(ends.followed)}, {', '.join([*there_first, *told])}."
    found = f"Of {_starts(ends.followed)}, {', '.join(told)}."
    if len(others) == 1:
        found = f"{many} {does(others[0].label, ends.followed)}"
        return f"{found}{_with_power(others[0], system)}."
    return found


def _starts(size: int) -> str:
    return counted(size, "random start")


def _with_power(end: End, system: System) -> str:
    text = power(end, system)
    return f": {text}" if text else ""


def power(end: End, system: System) -> str:
    """Power that the impacts take, and main blows, where there are any."""
    if end.delivered_power is None or end.blow_rate is None or not end.delivered_power > 0.0:
        return ""
    rate = f"{number(end.blow_rate)} main blows per load period"
    if system.is_si and system.frequency is not None:
        rate = f"{number(end.blow_rate * system.frequency)} main blows/s"
    return f"{_delivered(end, system)}, {rate}"


def _delivered(end: End, system: System) -> str:
    """``10.7 kW taken by the impacts``, where anything is."""
    return f"{Teller.of(system)(end.delivered_power, 'power')} taken by the impacts" if end.delivered_power else ""


def does(label: str, many: int, more: str = "") -> str:
    """``settle on one blow every load period``; the verb agrees with `many`, and `more` follows the label."""
    s = "s" if many == 1 else ""
    named = f"({label}, {more})" if more else f"({label})"
    name, _, numbers = label.replace("z=", "z/", 1).partition("/")
    if name == "z":
        p, n = (int(x) for x in numbers.split("/"))
        blows = "one blow" if p == 1 else f"{p} blows"
        return f"settle{s} on {blows} {_in_periods(n)} {named}"
    if name in ("chatter", "rest") and numbers:
        how = f"chatter{s} to rest" if name == "chatter" else f"strike{s} and come{s} to rest"
        return f"{how} once {_in_periods(int(numbers))} {named}" if numbers != "?" else f"{how} again and again {named}"
    return {
        "rest": f"come{s} to rest on the wall for good",
        "departed": f"leave{s} the wall for good",
        "aperiodic": f"find{s} no rhythm {named}",
    }.get(label, f"{'has' if many == 1 else 'have'} not settled {named}")


def _in_periods(n: int) -> str:
    return "every load period" if n == 1 else f"in {n} load periods"


# ---- The first lines of an answer: one home of its sentences, for the terminal and for the report as a file


@dataclass(frozen=True)
class Summary:
    """What is said first of an answer.

    Attributes
    ----------
    headline
        Whether the hammer can run with one blow in so many load periods, and how.
    more
        What else it can do, where random starts end, and of the load's clock; or "".
    runs
        Whether it can.
    """

    headline: str
    more: str
    runs: bool

    @property
    def text(self) -> str:
        """All sentences of the summary as one text."""
        return f"{self.headline} {self.more}".rstrip()


def summary_of(answer: SteadyAnswer) -> Summary:
    """The summary of an answer.

    Examples
    --------
    >>> from percuss.case import load_case, steady_answer
    >>> print(summary_of(steady_answer(load_case("mini-breaker"))).headline.split(":")[0])
    The hammer can run with one blow every load period
    """
    running = answer.running
    labels = {f"z=1/{found.orbit.periods}" for found in running}
    clock = clock_in_short(answer.system.load) if answer.clocked is None else CLOCKED
    said = [ends_sentence(answer.starts, labels, answer.system), clock]
    if running:
        return Summary(_can_run(answer, running[0]), _joined(_others(running), *said), True)
    alone = [one for period in answer.periods if period.timed is not None for one in period.timed.alone if one.runs]
    if alone:
        return Summary(_runs_alone(alone[0]), _joined(*said), True)
    rest = "The bar may also come to rest on the wall." if _stays(answer.rest) else ""
    what = f"No steady motion with one impact {_asked([period.states.periods for period in answer.periods])}"
    found = any(period.orbits for period in answer.periods)
    why = "can be sustained; see below for what fails." if found else "exists; see below for the nearest one."
    return Summary(f"{what} {why}", _joined(rest, *said), False)


def _joined(*sentences: str) -> str:
    return " ".join(sentence for sentence in sentences if sentence)


def _can_run(answer: SteadyAnswer, first: OrbitAnswer) -> str:
    orbit, tell = first.orbit, Teller.of(first.orbit.system)
    figures = f"phase {number(first.phase)} rad, striking speed {number(orbit.impact_velocity)}"
    if first.si is not None:
        rate = f"{number(first.si.blow_rate_Hz)} Hz ({number(first.si.blow_rate_per_min)} blows/min)"
        figures = f"{tell(orbit.blow_energy, 'energy')} at {rate}, {tell(orbit.impact_velocity, 'speed')}"
    return (
        f"The hammer can run with one blow {every(first.orbit.periods)}: {figures}; stable, "
        f"{_margins(first)} ({name_of(answer, first)} below)."
    )


def _runs_alone(found: TimedAnswer) -> str:
    orbit = found.orbit
    return (
        f"By {orbit.law.law} the hammer can run with one blow {every(orbit.periods)}: phase {number(orbit.phase)} rad; "
        f"stable, margin {number(found.stability.margin, 3)}. By B77's law, whose blows take no time, it cannot."
    )


def _others(running: tuple[OrbitAnswer, ...]) -> str:
    others = sorted({other.orbit.periods for other in running[1:]})
    if not others:
        return ""
    also = ", ".join(str(m) for m in others)
    return f"It can also settle on m = {also}; which motion it takes depends on how it starts."


def _margins(found: OrbitAnswer) -> str:
    """``rhythm margin 0.86, ringing margin 0.059``; by a law of blows that take time ``margin 0.85 by b77-blow``."""
    judged = found.stability
    if found.timed is not None:
        return f"margin {number(found.timed.stability.margin, 3)} by {found.timed.orbit.law.law}"
    rhythm, ringing = number(judged.margin_rhythm, 3), judged.margin_ringing
    text = f"rhythm margin {rhythm}"
    return text if ringing is None else f"{text}, ringing margin {number(ringing, 3)}"


def _stays(rest: Rest) -> bool:
    """Whether a simulated bar at rest stays there too."""
    return rest.possible and not rest.held_by_waves


def _asked(periods: list[int]) -> str:
    """``every load period``, ``in 1, 2 or 3 load periods``."""
    if len(periods) == 1:
        return every(periods[0])
    return f"in {', '.join(str(m) for m in periods[:-1])} or {periods[-1]} load periods"


def name_of(answer: SteadyAnswer, found: OrbitAnswer) -> str:
    """``orbit 2`` as the cards are numbered."""
    number_of = {id(one): i + 1 for period in answer.periods for i, one in enumerate(period.orbits)}
    return f"orbit {number_of[id(found)]}, m = {found.orbit.periods}"


def every(m: int) -> str:
    """``every load period``, ``in 3 load periods``."""
    return "every load period" if m == 1 else f"in {m} load periods"


# ---- A law that knows the duration of the blow, and its motions beside those of B77's law, in words

ENDED = "this motion does not exist when the blow takes time: it has met another one in a fold"
"""What is said of a motion of B77's law that the duration of the blow ends."""


def law_in_words(law: Timed, system: System) -> str:
    """The numbers of the law."""
    tell = Teller.of(system)
    lasts, centroid = (tell(time, "time", 3, plain=4) for time in (law.duration, law.force_centroid))
    text = (
        f"{law.law}: restitution {number(law.restitution)}, contact {lasts}, centroid of its force after {centroid}; "
    )
    text += "the impact plane moves on from blow to blow" if law.advance_per_impulse else "the impact plane stays"
    text += f"; ringing takes {percent(law.ringing_share)} of the energy before the blow" if law.ringing_share else ""
    return f"{text}; {law.contacts} contacts, where the law holds for one" if law.contacts > 1 else text


def timed_in_words(found: TimedAnswer, judged: Stability | None = None) -> list[str]:
    """A motion in lines: its phase, its blow, its verdict beside that on B77's motion, and what makes it impossible."""
    orbit = found.orbit
    beside = "" if judged is None else f" (B77's rhythm {number(judged.margin_rhythm, 3)})"
    margin = f"{_verdict(found)}; margin {number(found.stability.margin, 3)}{beside}"
    lines = [_phase(found), _blow(found), _timed_delivered(found), margin]
    if orbit.obstacle is Reason.NO_BLOW:
        lines.append("not possible: at the start of the contact the bar would be moving away from the wall")
    elif orbit.violation is not None:
        told = Teller.of(orbit.system)(orbit.violation.depth, "length")
        lines.append(f"not possible: between the blows the bar would be {told} beyond the place of the next one")
    return lines


def _phase(found: TimedAnswer) -> str:
    orbit = found.orbit
    text = f"force centred at {number(orbit.phase, 5)} rad = {number(math.degrees(orbit.phase))}°"
    shift = orbit.phase_shift
    if shift is None:
        return f"{text}; no motion of B77's law corresponds to it"
    when = "later" if shift >= 0.0 else "earlier"
    return f"{text}, {Teller.of(orbit.system)(abs(shift), 'time', 3)} {when} than B77's impact"


def _blow(found: TimedAnswer) -> str:
    orbit, tell = found.orbit, Teller.of(found.orbit.system)
    speed, energy = tell(orbit.rigid_velocity, "speed", plain=6), tell(orbit.blow_energy, "energy", plain=6)
    advance = tell(orbit.advance, "length", 3, plain=4)
    change = orbit.energy_change
    beside = "" if change is None else f" ({'+' if change >= 0.0 else ''}{percent(change)} against B77's rigid motion)"
    text = f"speed {speed}, energy {energy}{beside}"
    return f"{text}; the impact plane moves on by {advance} per blow" if orbit.advance else text


def _timed_delivered(found: TimedAnswer) -> str:
    orbit, tell = found.orbit, Teller.of(found.orbit.system)
    text = f"{tell(orbit.delivered_energy, 'energy', plain=6)} delivered to what is struck"
    ringing = f"; {tell(orbit.ringing_energy, 'energy', plain=6)} ring on in the bar"
    return text + ringing if orbit.ringing_energy else text


def _verdict(found: TimedAnswer) -> str:
    reason, verdict = found.stability.reason, "stable" if found.stability.stable else "unstable"
    return reason if reason.startswith(verdict) else f"{verdict}: {reason}"


# ---- The orbit that a simulated motion has settled on, in a line


def orbit_in_words(orbit: PeriodicOrbit) -> str:
    """Its label, its largest multiplier, and what that means."""
    found = orbit_multipliers(orbit)
    text = f"{orbit.label}, largest multiplier {number(found.largest)}"
    if not found.stable:
        return text
    if found.largest < 0.1:
        return f"{text}: disturbances die out within a cycle"
    cycles = math.ceil(math.log(0.1) / math.log(found.largest))
    return f"{text}: a disturbance dies out to a tenth in {cycles} cycle{'s' if cycles > 1 else ''}"
