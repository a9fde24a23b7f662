"""The one dispatcher: a case and a question in, an answer object out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from percuss.case.answers.clock_note import CLOCKED, Clocked, clocked_because
from percuss.case.answers.ends import Ends, ends_of, not_followed
from percuss.case.answers.json_values import contact_dict, heading_dict, plain
from percuss.case.answers.reach_in_words import reach_dict
from percuss.case.answers.steady_json import orbit_dict, period_dict, rest_dict, with_blow
from percuss.case.answers.timed_answer import TimedAnswer, TimedPeriod, blow_dict, timed_period
from percuss.case.case import checked_case
from percuss.model.body import need_free
from percuss.model.checks import count, several
from percuss.shown import Shown
from percuss.stability import stability_of
from percuss.steady import drag_of, greatest_drag, rest_on_wall, si_report, steady_states

if TYPE_CHECKING:
    from percuss.case.answers.reach_in_words import CaseReach
    from percuss.case.case import Case
    from percuss.model import System, Timed
    from percuss.recordings.history import HistoryReport
    from percuss.stability import Stability
    from percuss.steady import Drag, Orbit, Rest, SIReport, SteadyStates

__all__ = ["OrbitAnswer", "PeriodAnswer", "SteadyAnswer", "steady_answer"]


@dataclass(frozen=True)
class OrbitAnswer(Shown):
    """One steady motion: the orbit, its stability and, for a case in SI, its report.

    `timed`: where the case has a law that knows the duration of the blow, the motion of that law which continues it.
    `ended`: whether there is none under that law.
    """

    orbit: Orbit
    stability: Stability
    si: SIReport | None
    timed: TimedAnswer | None = None
    ended: bool = False

    @property
    def drag(self) -> Drag:
        """What the damping does to the motion of the bar as a whole."""
        return drag_of(self.orbit)

    @property
    def runs(self) -> bool:
        """Whether a hammer can sustain this motion: admissible and stable, by the law of the case."""
        if self.ended:
            return False
        return self.orbit.admissible and self.stability.stable if self.timed is None else self.timed.runs

    @property
    def phase(self) -> float:
        """The phase of the blow by the law of the case."""
        return self.orbit.phase if self.timed is None else self.timed.orbit.phase

    def to_json_dict(self) -> dict[str, Any]:
        """The motion in plain values."""
        told = orbit_dict(self.orbit, self.stability, self.drag, self.si)
        return with_blow(told, self.timed) if self.ended or self.timed is not None else told


@dataclass(frozen=True)
class PeriodAnswer(Shown):
    """All steady motions with one impact in `states.periods` load periods, in order of phase.

    `greatest_drag`: where there is none, the greatest d with which there is one, all else kept; None without one.
    `timed`: the same by a law that knows the duration of the blow, where the case has one.
    """

    states: SteadyStates
    orbits: tuple[OrbitAnswer, ...]
    greatest_drag: float | None = None
    timed: TimedPeriod | None = None

    def to_json_dict(self) -> dict[str, Any]:
        """The motions in plain values."""
        told = period_dict(self.states, [answer.to_json_dict() for answer in self.orbits], self.greatest_drag)
        if self.timed is None:
            return told
        return {**told, "blow": self.timed.to_json_dict({one.orbit.phase: one.stability for one in self.orbits})}


@dataclass(frozen=True)
class SteadyAnswer(Shown):
    """The answer to "what steady motions does this hammer have?".

    Attributes
    ----------
    name, title
        The case as it was named, and its title.
    system
        The system; `system.load.report` tells of a recorded history.
    notes
        What was assumed in reading the recording and of the load's clock.
    periods
        One entry for every number m of load periods that was asked for.
    rest
        Lying on the wall for all time.
    starts
        Where random starts end.
    law
        The law of a blow that takes time, where the case names one; None for B77's impact.
    reach
        How far parameters may move before `chosen` is lost (`percuss.case.reach_answer`); None unless it was asked for.
    """

    name: str
    title: str
    system: System
    notes: tuple[str, ...]
    periods: tuple[PeriodAnswer, ...]
    rest: Rest
    starts: Ends = field(default_factory=lambda: not_followed("none were asked for"))
    law: Timed | None = None
    reach: tuple[CaseReach, ...] | None = None

    @property
    def history(self) -> HistoryReport | None:
        """What was found in the recording, or None when the load is a formula."""
        return self.system.load.report

    @property
    def running(self) -> tuple[OrbitAnswer, ...]:
        """The admissible and stable orbits, fewest load periods per impact first."""
        found = [answer for period in self.periods for answer in period.orbits if answer.runs]
        return tuple(sorted(found, key=lambda answer: answer.orbit.periods))

    @property
    def clocked(self) -> Clocked | None:
        """Why the verdict turns on the load's keeping time by itself; None where it does not."""
        levels = [(period.states.level, period.states.level_max) for period in self.periods]
        motions = [(found.orbit.admissible, found.runs) for period in self.periods for found in period.orbits]
        return clocked_because(self.system.load, levels, motions)

    @property
    def chosen(self) -> OrbitAnswer | None:
        """The orbit to look at first: a running one, else an admissible one, else any; None without orbits."""
        found = [answer for period in self.periods for answer in period.orbits]
        ranked = sorted(found, key=lambda a: (not a.runs, not a.orbit.admissible, a.orbit.periods))
        return ranked[0] if ranked else None

    def to_json_dict(self) -> dict[str, Any]:
        """The answer in plain values, as `percuss steady --json` prints it."""
        return {
            **heading_dict(self.name, self.title, self.system, self.notes),
            **self._blow(),
            "clocked": None if self.clocked is None else {"because": self.clocked, "note": CLOCKED},
            "periods": [period.to_json_dict() for period in self.periods],
            "rest": rest_dict(self.rest, self.system.contact),
            "starts": plain(self.starts.to_json_dict(self.system)),
            "reach": None if self.reach is None else reach_dict(self.reach),
        }

    def _blow(self) -> dict[str, Any]:
        """The law of the blow, where it takes time."""
        if self.law is None:
            return {}
        asked = [period.states.periods for period in self.periods]
        contact = {**contact_dict(self.system), "law": self.law.law}
        return {"contact": contact, "blow": blow_dict(self.law, self.system, asked)}


def steady_answer(
    case: Case, periods: Sequence[int] = (1,), modes: int | None = None, *, starts: int = 0
) -> SteadyAnswer:
    """All steady motions of a case with one impact in m load periods, for every m of `periods`.

    Parameters
    ----------
    periods
        Numbers of load periods per impact.
    modes
        Elastic modes for the mode sums and for the multipliers; by default the sums take as many as their
        tolerance needs and the multipliers 32.
    starts
        How many random starts to follow besides, 0 to 1000; see `percuss.case.answers.ends.ends_of`.

    Raises
    ------
    LoadError
        When the load does not push or is constant.
    ResonanceError
        When an undamped bar is driven at one of its own frequencies.
    CaseError
        When the recording of the case cannot be used.

    Examples
    --------
    >>> from percuss.case import load_case
    >>> answer = steady_answer(load_case("laboratory-striker"))
    >>> [found.stability.stable for found in answer.periods[0].orbits]
    [False, True]
    """
    checked_case(case)
    need_free(case.system().body, "this answer; `structure_answer` tells of a structure")
    asked = several("periods", periods, "whole numbers of load periods, such as [1, 2]")
    system, law = case.system(), case.timed_law()
    found = [_period_answer(system, law, m, modes) for m in asked]
    number = count("starts", starts, least=0)
    ends = ends_of(case, number, modes) if number else not_followed("none were asked for")
    return SteadyAnswer(case.file, case.title, system, case.notes, tuple(found), rest_on_wall(system), ends, law)


def _period_answer(system: System, law: Timed | None, m: int, modes: int | None) -> PeriodAnswer:
    timed = None if law is None else timed_period(system, law, m, modes)
    states = steady_states(system, m, modes=modes) if timed is None else timed.states.b77
    orbits = tuple(_orbit_answer(orbit, timed) for orbit in states.orbits)
    return PeriodAnswer(states, orbits, greatest_drag(system, m) if states.nearest is not None else None, timed)


def _orbit_answer(orbit: Orbit, timed: TimedPeriod | None) -> OrbitAnswer:
    found = None if timed is None else timed.continuing(orbit)
    ended = timed is not None and found is None
    return OrbitAnswer(orbit, stability_of(orbit), si_report(orbit) if orbit.system.is_si else None, found, ended)
