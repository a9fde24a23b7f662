"""The first lines of an answer: one home of its sentences, for the terminal and for the report as a file."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from percuss.case.answers.clock_note import CLOCKED, clock_in_short
from percuss.case.answers.ends_in_words import ends_sentence
from percuss.case.answers.numerals import number, quantity

if TYPE_CHECKING:
    from percuss.case.answers.steady_answer import OrbitAnswer, SteadyAnswer
    from percuss.case.answers.timed_answer import TimedAnswer
    from percuss.steady import Rest

__all__ = ["Summary", "every", "name_of", "summary_of"]


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
    figures = f"phase {number(first.phase)} rad, striking speed {number(first.orbit.impact_velocity)}"
    if first.si is not None:
        rate = f"{number(first.si.blow_rate_Hz)} Hz ({number(first.si.blow_rate_per_min)} blows/min)"
        figures = f"{quantity(first.si.blow_energy_J, 'J')} at {rate}, {number(first.si.impact_velocity_m_s)} m/s"
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
