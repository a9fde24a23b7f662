"""The one dispatcher: a case and a question in, an answer object out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from percuss.stability import stability_of
from percuss.steady import rest_on_wall, si_report, steady_states

if TYPE_CHECKING:
    from percuss.case.case import Case
    from percuss.model import System
    from percuss.model.history import HistoryReport
    from percuss.stability import Stability
    from percuss.steady import Orbit, Rest, SIReport, SteadyStates

__all__ = ["OrbitAnswer", "PeriodAnswer", "SteadyAnswer", "steady_answer"]


@dataclass(frozen=True)
class OrbitAnswer:
    """One steady motion: the orbit, its stability and, for a case in SI, its report."""

    orbit: Orbit
    stability: Stability
    si: SIReport | None

    @property
    def runs(self) -> bool:
        """Whether a hammer can keep this motion up: admissible and stable."""
        return self.orbit.admissible and self.stability.stable


@dataclass(frozen=True)
class PeriodAnswer:
    """All steady motions with one impact in `states.periods` load periods, in order of phase."""

    states: SteadyStates
    orbits: tuple[OrbitAnswer, ...]


@dataclass(frozen=True)
class SteadyAnswer:
    """The answer to "what steady motions does this hammer have?".

    Attributes
    ----------
    name, title
        The case as it was named, and its title.
    system
        The system; `system.load.report` tells of a recorded history.
    notes
        What was assumed in reading the recording.
    periods
        One entry for every number m of load periods that was asked for.
    rest
        Lying on the wall for all time.
    """

    name: str
    title: str
    system: System
    notes: tuple[str, ...]
    periods: tuple[PeriodAnswer, ...]
    rest: Rest

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
    def chosen(self) -> OrbitAnswer | None:
        """The orbit to look at first: a running one, else an admissible one, else any; None without orbits."""
        found = [answer for period in self.periods for answer in period.orbits]
        ranked = sorted(found, key=lambda a: (not a.runs, not a.orbit.admissible, a.orbit.periods))
        return ranked[0] if ranked else None

    def to_json_dict(self) -> dict[str, Any]:
        """The answer in plain values, as `percuss steady --json` prints it."""
        from percuss.case.answer_json import answer_dict

        return answer_dict(self)


def steady_answer(case: Case, periods: Sequence[int] = (1,), modes: int | None = None) -> SteadyAnswer:
    """All steady motions of a case with one impact in m load periods, for every m of `periods`.

    Parameters
    ----------
    periods
        Numbers of load periods per impact.
    modes
        Elastic modes for the mode sums and for the multipliers; by default the sums take as many as their
        tolerance needs and the multipliers 32.

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
    system = case.system()
    found = []
    for m in periods:
        states = steady_states(system, m, modes=modes)
        orbits = tuple(_orbit_answer(orbit) for orbit in states.orbits)
        found.append(PeriodAnswer(states, orbits))
    return SteadyAnswer(case.file, case.title, system, case.notes, tuple(found), rest_on_wall(system))


def _orbit_answer(orbit: Orbit) -> OrbitAnswer:
    return OrbitAnswer(orbit, stability_of(orbit), si_report(orbit) if orbit.system.is_si else None)
