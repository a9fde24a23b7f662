"""The first sentence of the answer for a machine that switches itself from a start: one home for terminal and page."""

from __future__ import annotations

from typing import TYPE_CHECKING

from percuss.case.answers.numerals import counted, number, quantity

if TYPE_CHECKING:
    from percuss.case.answers.machine_motion import MachineMotion

__all__ = ["from_this_start"]


def from_this_start(answer: MachineMotion) -> str:
    """How the motion ends, in one sentence."""
    motion, machine, cycle = answer.motion, answer.machine, answer.motion.cycle
    text = f"From this start the machine {_in_words(motion.label)}"
    if cycle is None or not motion.impacts:
        return f"{text}."
    if not machine.is_si:
        return f"{text}: strongest blow {number(cycle.blow_speed)}, period {number(cycle.period)}."
    rate = cycle.blows / (cycle.period * machine.time_scale)
    energy = float(motion.blow_energies[-max(cycle.blows, 1) :].max()) * machine.energy_scale
    return (
        f"{text}: {quantity(energy, 'J')} at {number(rate)} Hz ({number(60.0 * rate)} blows/min), "
        f"{number(cycle.blow_speed * machine.speed_scale)} m/s, after {counted(cycle.first, 'impact')}."
    )


def _in_words(label: str) -> str:
    """The label behind "the machine"."""
    if label.startswith(("runs", "stalls", "cycles")):
        return label
    return {"undecided": "has not settled yet", "irregular": "strikes irregularly"}.get(label, f"ends as '{label}'")
