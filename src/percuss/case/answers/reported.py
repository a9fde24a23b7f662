"""What a report on any hammer is written from: its motion, what the ± of its numbers leaves of it, its blow."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from percuss.case.answers.blows.blow_answer import blow_answer
from percuss.case.answers.exploring.tolerance import uncertainty_of
from percuss.case.answers.machine_answer import machine_answer
from percuss.case.answers.steady_answer import steady_answer

if TYPE_CHECKING:
    from collections.abc import Sequence

    from percuss.case import BlowAnswer, Case, MachineAnswer, SteadyAnswer


def reported_answers(
    case: Case, modes: int | None = None, periods: Sequence[int] = (1,), *, fatigue: bool = True
) -> tuple[SteadyAnswer | MachineAnswer, BlowAnswer | None]:
    """Its answer, and its blow with the fatigue of its steel where it runs and strikes a tool.

    Parameters
    ----------
    modes, periods
        As `steady_answer` and `machine_answer` take them.
    fatigue
        Whether the blow tells it, which needs the package `rainflow` of the extra `io`.
    """
    answer: SteadyAnswer | MachineAnswer
    answer = machine_answer(case, modes) if case.is_machine else steady_answer(case, tuple(periods), modes)
    whole, blow = answer.whole, None
    if whole.runs and case.uncertain:
        answer = replace(answer, uncertainty=uncertainty_of(case, modes))
    speed = whole.value("rigid_velocity")
    if case.tables.tool is not None and speed is not None and speed > 0.0:
        own = case.blow_question().velocity is None  # else the blow is that of the cycle all the same
        blow = blow_answer(case, None if own else speed, fatigue=fatigue and case.is_si)
    return answer, blow
