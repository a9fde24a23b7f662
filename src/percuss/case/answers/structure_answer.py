"""The steady motions with one impact of a structure that is held: what `percuss steady` says of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from percuss.case.answers.numerals import heading_dict, picked, plain_value
from percuss.case.answers.numerals import json_number as number
from percuss.case.answers.reach_in_words import reach_dict
from percuss.case.case import checked_case
from percuss.errors import ParameterError
from percuss.model.checks import several
from percuss.shown import Shown
from percuss.stability import floquet_multipliers
from percuss.stability.multipliers import NEUTRAL
from percuss.steady import steady_states

if TYPE_CHECKING:
    from percuss.case.answers.reach_in_words import CaseReach
    from percuss.case.case import Case
    from percuss.model import System
    from percuss.stability import Multipliers
    from percuss.steady import Orbit, SteadyStates


@dataclass(frozen=True)
class StructureMotion(Shown):
    """One motion, and its multipliers; where the load jumps at the impact the worse ones of the two sides."""

    orbit: Orbit
    multipliers: Multipliers

    @property
    def stable(self) -> bool:
        """Whether small disturbances die out."""
        return self.multipliers.largest < 1.0 - NEUTRAL and not self.orbit.fold

    def to_json_dict(self) -> dict[str, Any]:
        """The motion in plain values."""
        orbit = self.orbit
        found = {
            **picked(orbit, "phase impact_velocity rebound_velocity blow_energy admissible fold"),
            "energy": picked(orbit.energy, "input damping impact"),
            "reason": None if orbit.obstacle is None else orbit.obstacle.value,
            "multipliers": plain_value(self.multipliers.values),
            "stable": self.stable,
        }
        if orbit.system.is_si:
            found["impact_velocity_m_s"] = number(orbit.impact_velocity * orbit.system.speed_scale)
            found["blow_energy_J"] = number(orbit.blow_energy * orbit.system.energy_scale)
        return found


@dataclass(frozen=True)
class StructureAnswer(Shown):
    """The answer to "what steady motions with one impact does this structure have?".

    Parameters
    ----------
    name, title, system, notes
        As of a `SteadyAnswer`.
    states
        For every m that was asked for; its `level_max` is how far the contact would come at most.
    motions
        Those of each of them, by phase.
    reach
        How far parameters may move before `chosen` is lost (`percuss.case.reach_answer`); None unless it was asked for.
    """

    name: str
    title: str
    system: System
    notes: tuple[str, ...]
    states: tuple[SteadyStates, ...]
    motions: tuple[tuple[StructureMotion, ...], ...]
    reach: tuple[CaseReach, ...] | None = None

    @property
    def chosen(self) -> StructureMotion | None:
        """The first motion that is possible and stable."""
        each = (one for motions in self.motions for one in motions)
        return next((one for one in each if one.stable and one.orbit.admissible), None)

    @property
    def runs(self) -> bool:
        """Whether one of the motions is possible and stable."""
        return self.chosen is not None

    def to_json_dict(self) -> dict[str, Any]:
        """The answer in plain values."""
        periods = [
            {
                "periods": states.periods,
                "modes": states.modes,
                "gap": number(states.level),
                "greatest_place": number(states.level_max),
                "note": states.note,
                "orbits": [one.to_json_dict() for one in motions],
            }
            for states, motions in zip(self.states, self.motions, strict=True)
        ]
        reach = {} if self.reach is None else {"reach": reach_dict(self.reach)}
        return {**heading_dict(self.name, self.title, self.system, self.notes), "periods": periods, **reach}


def structure_answer(case: Case, periods: Sequence[int] = (1,), modes: int | None = None) -> StructureAnswer:
    """The steady motions with one impact of the structure of a case, all of them, with their multipliers.

    Parameters
    ----------
    case
        A case with a table [body].
    periods
        The m to answer for.
    modes
        N; None for all that its table has, or 32 of a bar.

    Raises
    ------
    ParameterError
        For a case of a free bar, of which `steady_answer` tells.
    LoadError, ResonanceError
        When the load is constant, or drives an undamped mode at its own frequency.

    Examples
    --------
    >>> from percuss.case import Case
    >>> tables = '''
    ... [body]
    ... kind = "mounted"
    ... spring = 0.25
    ... [system]
    ... restitution = 0.8
    ... [load]
    ... kind = "harmonic"
    ... mean = 0.0
    ... amplitude = 0.25
    ... '''
    >>> answer = structure_answer(Case.from_text(tables))
    >>> [round(one.orbit.impact_velocity, 9) for one in answer.motions[0]]
    [3.333333333, -3.333333333]
    """
    checked_case(case)
    system = case.system()
    if system.body.is_free:
        raise ParameterError("case", case.title, "a case with a table [body]", "ask steady_answer of a free bar")
    asked = several("periods", periods, "whole numbers of load periods, such as [1, 2]")
    states = tuple(steady_states(system, m, modes=modes) for m in asked)
    motions = tuple(tuple(_judged(orbit) for orbit in each.orbits) for each in states)
    return StructureAnswer(case.file, case.title, system, case.notes, states, motions)


def _judged(orbit: Orbit) -> StructureMotion:
    sides = [floquet_multipliers(orbit, orbit.modes, side=side) for side in orbit.system.load.sides]
    return StructureMotion(orbit, max(sides, key=lambda found: found.largest))
