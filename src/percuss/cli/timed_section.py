"""What a law that knows the duration of the blow says, as lines of the report beside those of B77's law."""

from __future__ import annotations

from typing import TYPE_CHECKING

from percuss.case.answers.numerals import counted, number
from percuss.case.answers.timed_in_words import ENDED, timed_in_words
from percuss.cli.report_parts import BAD, GOOD, Section

if TYPE_CHECKING:
    from percuss.case import OrbitAnswer, PeriodAnswer
    from percuss.case.answers.timed_answer import TimedAnswer
    from percuss.model import Timed
    from percuss.stability import Stability

__all__ = ["alone_sections", "existence_row", "timed_heading", "timed_rows"]


def existence_row(period: PeriodAnswer) -> list[tuple[str, str]]:
    """How many motions there are under the law."""
    if period.timed is None:
        return []
    states = period.timed.states
    compared = f"level {number(states.level)}, greatest v_f − e p {number(states.level_max)}"
    return [(states.law.law, f"{counted(len(states.orbits), 'steady motion')}: {compared}")]


def timed_heading(answer: OrbitAnswer, law: Timed | None) -> str:
    """What is added to the heading of a motion of B77's law."""
    if law is None:
        return ""
    return f"; by {law.law} {'no motion' if answer.timed is None else _judged(answer.timed)}"


def timed_rows(answer: OrbitAnswer, law: Timed | None) -> list[tuple[str, str]]:
    """The lines on a motion of B77's law that say what becomes of it when its blows take time."""
    if law is None:
        return []
    return [(law.law, ENDED)] if answer.timed is None else _rows(answer.timed, answer.stability)


def alone_sections(period: PeriodAnswer) -> list[Section]:
    """Cards of the motions that continue none of B77's."""
    if period.timed is None:
        return []
    heading = f"Of {period.timed.states.law.law} alone, m = {period.states.periods}"
    return [
        Section(f"{heading}: {_judged(found)}", tuple(_rows(found, None)), GOOD if found.runs else BAD, level=2)
        for found in period.timed.alone
    ]


def _judged(found: TimedAnswer) -> str:
    verdict = "stable" if found.stability.stable else "unstable"
    return f"{verdict}, {'possible' if found.orbit.admissible else 'not possible'}"


def _rows(found: TimedAnswer, judged: Stability | None) -> list[tuple[str, str]]:
    first, *more = timed_in_words(found, judged)
    rows = [(found.orbit.law.law, first), *(("", text) for text in more)]
    return [*rows, *(("warning", warning) for warning in found.orbit.warnings)]
