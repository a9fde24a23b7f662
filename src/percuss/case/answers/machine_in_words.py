"""The first sentences of the answer for a machine that switches itself: one home for the terminal and for reports."""

from __future__ import annotations

from typing import TYPE_CHECKING

from percuss.case.answers.machine_figures import machine_figures
from percuss.case.answers.machine_units import in_units
from percuss.case.answers.numerals import number, quantity

if TYPE_CHECKING:
    from percuss.case.answers.told_machine import ToldMachine
    from percuss.model import Machine
    from percuss.steady.self_excited import SelfExcited, ValveCycle

__all__ = ["decided_by", "decided_by_rigid", "figures_in_short", "headline"]


def headline(answer: ToldMachine) -> str:
    """What the machine does, in one or two sentences."""
    cycle, obstacle = answer.cycle, answer.motion.obstacle
    if obstacle is None:
        assert cycle is not None
        starts = "It starts" if answer.motion.starts_from_rest else "It does not start"
        rest = ", with a rest on the wall" if cycle.rests else ""
        return (
            f"The machine runs with one blow a cycle{rest}: {figures_in_short(answer.machine, cycle)}; stable, a "
            f"disturbance is down to {number(100.0 * abs(cycle.multiplier), 3)} % after a cycle. "
            f"{starts} from rest on the wall."
        )
    text = f"The machine does not run with one blow a cycle — {obstacle.value}: {obstacle.words}"
    text += f"{decided_by(answer.motion) or decided_by_rigid(answer)}."
    if cycle is not None and cycle.blows > 1:
        strongest = figures_in_short(answer.machine, cycle)
        text += f" It runs with {cycle.blows} blows a cycle, the strongest with {strongest}."
    return text


def figures_in_short(machine: Machine, cycle: ValveCycle) -> str:
    """Energy, rate and striking speed of a cycle."""
    if not machine.is_si:
        return f"striking speed {number(cycle.blow_speed, 5)}, period {number(cycle.period, 5)}"
    si = machine_figures(machine, cycle)
    rate = f"{number(si.blow_rate_Hz)} Hz ({number(si.blow_rate_per_min)} blows/min)"
    return f"{quantity(si.blow_energy_J, 'J')} at {rate}, {number(si.impact_velocity_m_s)} m/s"


_DECIDES = {
    "stays on the wall": ("force", "force at the wall {found}, which must be below {needed}"),
    "reaches no port": ("length", "it goes {found} behind the wall, and the port is at {needed}"),
    "no room": ("length", "a stroke of {found}, and room for {needed}"),
    "cycles without a blow": ("length", "it turns {found} before the wall"),
    "flip": ("", "multiplier of modulus {found}"),
    "double blow": ("time", "the return comes {found} after the blow, and must come within {needed}"),
}
"""The number that decides, by the word of the obstacle: its kind, and what is said of it."""


def decided_by(motion: SelfExcited) -> str:
    """The number that decides, in brackets behind a sentence; nothing where there is none."""
    if motion.obstacle is None or motion.found is None or motion.obstacle.value not in _DECIDES:
        return ""
    kind, text = _DECIDES[motion.obstacle.value]
    if motion.needed is None:
        text = text.partition(", and the port")[0]
    found = in_units(motion.machine, motion.found, kind)
    return f" ({text.format(found=found, needed=in_units(motion.machine, motion.needed or 0.0, kind))})"


def decided_by_rigid(answer: ToldMachine) -> str:
    """The number that decides for a rigid piston, where it meets the same obstacle."""
    rigid = answer.rigid
    same = rigid is not answer.motion and rigid.obstacle is answer.motion.obstacle
    return f"{decided_by(rigid)[:-1]}, as a rigid piston)" if same and decided_by(rigid) else ""
