"""The dispatcher's answer to "what does one blow of this hammer do?"."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from percuss.case.answers.blow_formulas import Formula, formulas, left_out
from percuss.case.answers.blow_in_words import blow_in_words
from percuss.case.answers.blow_json import blow_dict
from percuss.case.answers.told_blow import ToldBlow
from percuss.case.case import checked_case
from percuss.errors import CaseError, ParameterError
from percuss.model.body import Body, SizedBody
from percuss.model.checks import Array, flag, non_negative, positive

if TYPE_CHECKING:
    from percuss.blow import Blow
    from percuss.blow.question import Field
    from percuss.case.case import Case
    from percuss.case.file_format.tool_building import BlowQuestion
    from percuss.steady import Orbit

__all__ = ["BlowAnswer", "blow_answer"]

_MIDDLE = 0.5
"""Where a gauge is unless told otherwise, as a share of the first section of the rod."""


@dataclass(frozen=True)
class BlowAnswer(ToldBlow):
    """The answer to "what does one blow of this hammer do?"; attributes are those of `ToldBlow`."""

    @cached_property
    def formulas(self) -> tuple[Formula, ...]:
        """The closed forms that apply to such a blow, with what the waves gave."""
        return formulas(self)

    @cached_property
    def left_out(self) -> tuple[tuple[str, str], ...]:
        """What the theory of one-dimensional waves leaves out of this blow, with its numbers."""
        return left_out(self)

    @property
    def sentence(self) -> str:
        """What became of the energy of the blow, in one sentence."""
        return blow_in_words(self)

    def to_json_dict(self) -> dict[str, Any]:
        """The answer in plain values, as `percuss blow --json` prints it."""
        return blow_dict(self)


def blow_answer(
    case: Case,
    velocity: float | None = None,
    *,
    until: float | None = None,
    gauge: float | None = None,
    whole_field: bool = False,
    most_pieces: int | None = None,
) -> BlowAnswer:
    """One blow of a case.

    Parameters
    ----------
    velocity
        Of the striker toward the target, in m/s (dimensionless: lengths per radian), instead of that of the case.
    until
        End of the window in s (dimensionless: radians), instead of that of the case.
    gauge
        Where the waves are told of, m from the struck face (dimensionless: time of a wave); by default the middle of
        the rod's first section.
    whole_field
        Start from the whole field of the steady motion just before its impact, with its strain.
    most_pieces
        Of waves, as `percuss.blow.strike` counts them, after which the window is cut short.

    Raises
    ------
    CaseError
        When the case has no speed and no steady motion to take it from.
    ParameterError
        For values out of range.

    Examples
    --------
    >>> from percuss.case import load_case
    >>> answer = blow_answer(load_case("laboratory-striker"))
    >>> answer.blow.energy_error < 1e-12
    True
    """
    from percuss.blow import strike  # loads the compiler

    checked_case(case)
    velocity, until = (None if x is None else positive(n, x) for n, x in (("velocity", velocity), ("until", until)))
    gauge = None if gauge is None else non_negative("gauge", gauge)
    question = case.blow_question()
    if velocity is not None:
        if flag("whole_field", whole_field):
            raise ParameterError("velocity", velocity, "either a velocity or the field of the steady motion, not both")
        question = replace(question, velocity=velocity)
    if until is not None:
        question = replace(question, until=until)
    field: Field | None = None
    speed, notes = "as the case says" if velocity is None else "as asked for", _notes(case, question)
    given = question.velocity
    if whole_field or given is None:
        orbit, which = _motion(case)
        speed = f"that of steady motion {which} just before its impact"
        field, given = (_field_of(orbit, question.striker), None) if whole_field else (None, _mean_speed(orbit))
    found = strike(
        question.striker,
        question.target,
        given,
        until=question.until,
        load=question.load,
        load_at=question.load_at,
        field=field,
        **({} if most_pieces is None else {"most_pieces": most_pieces}),
    )
    return BlowAnswer(case.file, case.title, found, speed, _gauge(found, gauge), notes)


def _gauge(blow: Blow, asked: float | None) -> float | None:
    """The place of the gauge, checked; None where there is no rod."""
    from percuss.blow import Rod

    if asked is not None:
        blow.waves_at(asked)
        return asked
    if not isinstance(blow.target, Rod):
        return None
    pieces = blow.target.pieces if isinstance(blow.striker, SizedBody) and blow.target.impedance is None else ()
    first = pieces[0].end - pieces[0].start if pieces else float("inf")
    if first == float("inf"):
        return blow.striker.length if isinstance(blow.striker, SizedBody) else blow.striker.transit_time
    return _MIDDLE * first


def _notes(case: Case, question: BlowQuestion) -> tuple[str, ...]:
    from percuss.blow import Wall

    if case.tables.tool is None and isinstance(question.target, Wall):
        return ("the case has no [tool]: the bar strikes a rigid wall",)
    if case.tables.tool is None:
        return ("the case has no [tool]: the bar strikes an endless rod of the receiving area",)
    return ()


# -- the steady motion that a speed comes from ------------------------------------------------------------------------


def _motion(case: Case) -> tuple[Orbit, str]:
    """The steady motion to look at first, and its number."""
    from percuss.case.answers.steady_answer import steady_answer

    remedy = 'say how fast it strikes: velocity = "9 m/s" in [blow], or --velocity'
    if case.tables.load is None or getattr(case.tables, "contact", ...) is None:
        accepted = "a velocity, or a [load] and a [contact] whose steady motion has one"
        raise CaseError(case.file, "blow.velocity", None, accepted, remedy)
    if case.is_machine:
        told = f"'percuss machine' tells the striking speed of its cycle; {remedy}"
        raise CaseError(case.file, "blow.velocity", None, "a velocity, as the load has no period", told)
    answer = steady_answer(case)
    chosen = answer.chosen
    if chosen is None:
        raise CaseError(case.file, "blow.velocity", None, "a velocity: the case has no steady motion", remedy)
    number = answer.periods[0].orbits.index(chosen) + 1
    return chosen.orbit, str(number)


def _mean_speed(orbit: Orbit) -> float:
    """Mean velocity of the bar just before the impact, in the units of the case."""
    system = orbit.system
    return orbit.rigid_velocity * (system.length_scale / system.time_scale if system.is_si else 1.0)


def _field_of(orbit: Orbit, striker: SizedBody | Body) -> Field:
    """Velocity and compressive force along the bar just before the impact, in the units of the case."""
    from percuss.blow.striker import striker_sections

    system, sections = orbit.system, striker_sections(striker)
    scale = system.length_scale / system.time_scale if system.is_si else 1.0
    ends = np.cumsum(sections.length)[:-1] / sections.length.sum()
    stiffness = sections.impedance * sections.speed  # E A of each section

    def velocity(x: Array) -> Array:
        return scale * orbit.velocity(x, orbit.period)[:, 0]

    def force(x: Array) -> Array:
        return -stiffness[np.searchsorted(ends, x, side="right")] * orbit.strain(x, orbit.period)[:, 0]

    return velocity, force
