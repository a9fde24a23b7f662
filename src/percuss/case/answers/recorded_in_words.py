"""The first sentences on a recorded load read as a valve: the verdict under a clock, and with the valve."""

from __future__ import annotations

from typing import TYPE_CHECKING

from percuss.case.answers.machine_in_words import figures_in_short
from percuss.case.answers.numerals import number

if TYPE_CHECKING:
    from percuss.case.answers.told_record import ToldRecord
    from percuss.steady.self_excited import ValveCycle

__all__ = ["by_clock", "by_valve", "recorded_headline"]


def recorded_headline(answer: ToldRecord) -> str:
    """How the machine runs, and how the two verdicts on the same motion differ."""
    cycle = answer.answer.cycle
    first = "Read as a machine whose valve the piston works, the record's machine "
    if cycle is not None and answer.runs:
        first += f"runs: {figures_in_short(answer.answer.machine, cycle)}"
    else:
        obstacle = answer.answer.motion.obstacle
        first += f"does not run with one blow a cycle{'' if obstacle is None else f' — {obstacle.words}'}"
    return f"{first}. Under a clock: {by_clock(answer)}; with the valve: {by_valve(answer.answer.cycle)}."


def by_clock(answer: ToldRecord) -> str:
    """``unstable (flip), multiplier −8.6`` of the recorded motion under a load that keeps time by itself."""
    clock = answer.clock
    if not clock.exists or clock.multiplier is None:
        return "no steady motion with the blow where it is"
    z = clock.multiplier
    turning = abs(z.imag) > 1e-9 * abs(z)
    size = f"a pair of multipliers of modulus {number(abs(z), 3)}" if turning else f"multiplier {number(z.real, 3)}"
    if abs(z) < 1.0:
        return f"{'stable' if clock.stable else 'unstable by its ringing, its rhythm stable'}, {size}"
    kind = "turning" if turning else "flip" if z.real < 0.0 else "beyond the fold"
    return f"unstable ({kind}), {size}"


def by_valve(cycle: ValveCycle | None) -> str:
    """``stable, multiplier 0.028`` of the machine that was read."""
    if cycle is None:
        return "no cycle"
    size = number(abs(cycle.multiplier), 3)
    return f"{'stable' if cycle.stable else 'unstable'}, greatest multiplier {size}"
