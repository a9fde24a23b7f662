"""How a machine runs that switches itself, and what of it is told: outcome and label, warnings, margins."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

from percuss.case.answers.machine_changes import Sensitivity, pressure_curve, sensitivities
from percuss.case.answers.machine_course import course_of
from percuss.case.answers.told_blank import ToldBlank, told_blank
from percuss.errors import ParameterError
from percuss.shown import Shown
from percuss.steady.self_excited import RigidCycle, slow_pressure, valve_margins

if TYPE_CHECKING:
    from percuss.case.answers.machine_changes import Running
    from percuss.case.answers.machine_course import Course
    from percuss.model import Machine
    from percuss.steady.self_excited import Obstacle, SelfExcited, SlowPressure, ValveCycle, ValveMargins

__all__ = ["ToldMachine"]


@dataclass(frozen=True)
class ToldMachine(Shown):
    """How a machine runs, or what keeps it from running; `MachineAnswer` says what the fields are."""

    name: str
    title: str
    motion: SelfExcited
    rigid: SelfExcited
    notes: tuple[str, ...] = ()

    @cached_property
    def margins(self) -> ValveMargins | None:
        """How far it is from what would stop it; None when it does not run."""
        return valve_margins(self.rigid) if self.motion.runs and self.rigid.runs else None

    @cached_property
    def pressure(self) -> SlowPressure | None:
        """The pressure over the cycle, where a supply makes it follow the piston; None without one, or a cycle."""
        cycle = self.motion.cycle
        fed = isinstance(cycle, RigidCycle) and self.machine.valve.supply is not None
        return slow_pressure(cycle) if fed and isinstance(cycle, RigidCycle) else None

    @cached_property
    def sensitivities(self) -> tuple[Sensitivity, ...]:
        """How energy and rate follow pressure, ports, delays and restitution; empty when it does not run."""
        return sensitivities(self.motion)

    @cached_property
    def curve(self) -> tuple[Running, ...]:
        """Energy and rate over the pressure, with a supply over the flow; empty when it does not run."""
        return pressure_curve(self.motion)

    @cached_property
    def blank(self) -> ToldBlank | None:
        """What it does that finds no tool, from the cycle of a rigid piston; None without one."""
        return told_blank(self.rigid)

    @property
    def machine(self) -> Machine:
        """The machine."""
        return self.motion.machine

    @property
    def cycle(self) -> ValveCycle | None:
        """The periodic motion, also one that is not possible, such as one for which there is no room."""
        return self.motion.cycle

    @property
    def runs(self) -> bool:
        """Whether there is a stable cycle with one blow."""
        return self.motion.runs

    @cached_property
    def course(self) -> Course:
        """The cycle over time.

        Raises
        ------
        ParameterError
            When there is none.
        """
        if self.cycle is None:
            raise ParameterError("course", self.outcome, "a machine with a cycle")
        return course_of(self.machine, self.cycle)

    @property
    def outcome(self) -> str:
        """What the machine does in one word or few: "runs", "stalls", "double blow", "cycles without a blow", …."""
        return _outcome(self.motion)

    @property
    def label(self) -> str:
        """Blows per valve cycle and valve cycles per period, "1/1", or where a machine stalls: "on the tool"."""
        return _label(self.motion)

    @property
    def warnings(self) -> tuple[str, ...]:
        """What a reader of the figures should know, one sentence each."""
        return tuple(_warnings(self))


def _outcome(motion: SelfExcited) -> str:
    obstacle, cycle = motion.obstacle, motion.cycle
    if obstacle is None:
        assert cycle is not None
        return "runs with rest" if cycle.rests else "runs"
    word: str = obstacle.value
    return _WORDS.get(word, word)


_WORDS = {"stays on the wall": "stalls", "reaches no port": "stalls", "order overtaken": "double blow"}
"""What a machine does that meets an obstacle whose own word says why."""


def _label(motion: SelfExcited) -> str:
    obstacle: Obstacle | None = motion.obstacle
    if obstacle is not None and obstacle.value == "stays on the wall":
        return "on the tool"
    if obstacle is not None and obstacle.value == "reaches no port":
        return "in the chamber" if motion.machine.valve.chamber.stiffness > 0.0 else "leaves"
    return "" if motion.cycle is None else f"{motion.cycle.blows}/1"


_NEAR = 1e-9


def _warnings(answer: ToldMachine) -> list[str]:
    found, machine = [], answer.machine
    if answer.runs and not answer.motion.starts_from_rest:
        found.append("the machine runs, but does not start from rest on the wall: it must be pushed off")
    cycle = answer.cycle
    if cycle is None:
        return found
    latest = max((port.delay for port in machine.valve.ports), default=0.0)
    if latest > cycle.period:
        found.append("a delay is longer than the cycle: orders of several cycles are under way at a time")
    used = {uncovering.port for uncovering in cycle.uncoverings}
    idle = [i for i, port in enumerate(machine.valve.ports) if port.on != "impact" and i not in used]
    if idle and answer.runs:
        which = ", ".join(f"ports[{i}]" for i in idle)
        found.append(f"no switch of the cycle comes from {which}: never reached, or its state was demanded before")
    for i in idle:
        edge = machine.valve.ports[i].behind
        if edge is not None and abs(edge - cycle.stroke) <= _NEAR * cycle.stroke:
            found.append(f"the piston turns at the edge of ports[{i}]: the least change decides whether it is passed")
    if answer.runs and not answer.rigid.runs and answer.rigid.obstacle is not None:
        found.append(f"a rigid piston would not run: {answer.rigid.obstacle.words}")
    if _ringing(answer) > _hysteresis(answer):
        found.append("the ports are so near each other that the ringing of the bar may pass both")
    return found


def _ringing(answer: ToldMachine) -> float:
    """How far a place of the bar swings about its centre after the blow, at most: v/ω_1, v L/(π C) of a uniform one."""
    reads = any(port.reads != "centre" for port in answer.machine.valve.ports)
    assert answer.cycle is not None
    slowest = float(answer.machine.body.frequencies(1)[0])
    return answer.cycle.blow_speed / slowest if reads and answer.motion.modes else 0.0


def _hysteresis(answer: ToldMachine) -> float:
    """The least distance of two ports that demand different states."""
    ports = [port for port in answer.machine.valve.ports if port.behind is not None]
    apart = [abs((a.behind or 0.0) - (b.behind or 0.0)) for a in ports for b in ports if a.to != b.to]
    return min(apart, default=math.inf)
