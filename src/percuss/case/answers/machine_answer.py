"""The dispatcher's answer to "how does this machine run, whose piston switches its own valve?"."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from percuss.case.answers.machine_json import machine_dict
from percuss.case.answers.told_machine import ToldMachine
from percuss.case.case import checked_case
from percuss.case.file_format.start_and_simulation import DEFAULT_MODES, MAX_MODES
from percuss.model.checks import count
from percuss.steady import self_excited_motion

if TYPE_CHECKING:
    from percuss.case.case import Case

__all__ = ["MachineAnswer", "machine_answer"]


@dataclass(frozen=True)
class MachineAnswer(ToldMachine):
    """How a machine runs that switches its own valve, or what keeps it from running.

    Attributes
    ----------
    name, title
        The case as it was named, and its title.
    motion
        Its cycle with elastic modes, or what keeps it from running.
    rigid
        The same of a rigid piston.
    notes
        What was assumed, one sentence each.
    """

    def to_json_dict(self) -> dict[str, Any]:
        """The answer in plain values, as `percuss machine --json` prints it."""
        return machine_dict(self)


def machine_answer(case: Case, modes: int | None = None) -> MachineAnswer:
    """How the machine of a case runs whose load the piston switches.

    Parameters
    ----------
    modes
        Elastic modes; 32 by default, 0 for a rigid piston, which a machine with a supply has by default and needs.

    Raises
    ------
    CaseError
        When the load of the case is another.

    Examples
    --------
    >>> from percuss.case import load_case
    >>> answer = machine_answer(load_case("valve-breaker"), modes=0)
    >>> answer.outcome, answer.label, round(answer.cycle.blow_speed * answer.machine.speed_scale, 2)
    ('runs', '1/1', 9.19)
    """
    checked_case(case)
    machine, room = case.machine(), case.room()
    usual = DEFAULT_MODES if machine.valve.supply is None else 0
    kept = usual if modes is None else count("modes", modes, least=0, most=MAX_MODES)
    motion = self_excited_motion(machine, modes=kept, room=room)
    rigid = motion if kept == 0 else self_excited_motion(machine, modes=0, room=room)
    return MachineAnswer(case.file, case.title, motion, rigid, case.notes)
