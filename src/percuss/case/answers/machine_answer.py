"""The dispatcher's answer to "how does this machine run, whose piston switches its own valve?"."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

from percuss.case.answers.facts import Teller, plain_of
from percuss.case.answers.machine_figures import (
    CYCLE,
    POWER,
    Running,
    Sensitivity,
    ToldBlank,
    course_of,
    figures_in_si,
    pressure_curve,
    sensitivities,
    told_blank,
)
from percuss.case.answers.numerals import json_number as number
from percuss.case.answers.numerals import number as numerals_number
from percuss.case.answers.numerals import numbers, picked, plain, plain_value
from percuss.case.case import checked_case
from percuss.case.file_format.start_and_simulation import DEFAULT_MODES
from percuss.errors import ParameterError
from percuss.model.checks import count
from percuss.shown import Shown
from percuss.simulate.stop import MAX_MODES
from percuss.steady import self_excited_motion
from percuss.steady.self_excited import slow_pressure, valve_margins

if TYPE_CHECKING:
    from percuss.case.answers.machine_figures import AtPressure, Course
    from percuss.case.case import Case
    from percuss.model import Machine
    from percuss.steady.self_excited import Ringing, SelfExcited, SlowPressure, ValveCycle, ValveMargins


# ---- How a machine runs that switches itself, and what of it is told: outcome and label, warnings, margins


@dataclass(frozen=True)
class MachineAnswer(Shown):
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
        return None if cycle is None or self.machine.valve.supply is None else slow_pressure(cycle)

    @cached_property
    def sensitivities(self) -> tuple[Sensitivity, ...]:
        """How energy and rate follow pressure, ports, delays and restitution; empty when it does not run."""
        return sensitivities(self.motion)

    @cached_property
    def curve(self) -> tuple[AtPressure, ...]:
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
    def si(self) -> dict[str, Any] | None:
        """The figures of the cycle with their units, by their keys in JSON; None without a cycle, or scales."""
        return figures_in_si(self.machine, self.cycle)

    @property
    def outcome(self) -> str:
        """What the machine does in one word or few: "runs", "stalls", "double blow", "cycles without a blow", …."""
        obstacle, cycle = self.motion.obstacle, self.motion.cycle
        if obstacle is None:
            return "runs with rest" if cycle is not None and cycle.rests else "runs"
        return _WORDS.get(obstacle.value, str(obstacle.value))

    @property
    def label(self) -> str:
        """Blows per valve cycle and valve cycles per period, "1/1", or where a machine stalls: "on the tool"."""
        obstacle = self.motion.obstacle
        if obstacle is not None and obstacle.value == "stays on the wall":
            return "on the tool"
        if obstacle is not None and obstacle.value == "reaches no port":
            return "in the chamber" if self.machine.valve.chamber.stiffness > 0.0 else "leaves"
        return "" if self.cycle is None else f"{self.cycle.blows}/1"

    @property
    def warnings(self) -> tuple[str, ...]:
        """What a reader of the figures should know, one sentence each."""
        return tuple(_warnings(self))

    def to_json_dict(self) -> dict[str, Any]:
        """The answer in plain values, as `percuss machine --json` prints it."""
        other = None if self.rigid is self.motion else self.rigid
        return {
            **cycle_dict(self),
            "starts_from_rest": bool(self.motion.starts_from_rest),
            "margins": _margins(self),
            "supply": _supply(self),
            "sensitivities": [plain(asdict(one)) for one in self.sensitivities],
            "pressure_curve": [plain(asdict(one)) for one in self.curve],
            "blank_blow": None if self.blank is None else self.blank.to_json_dict(),
            "rigid": None if other is None else _cycle(other),
            "rigid_si": None if other is None else figures_in_si(self.machine, other.cycle),
            "warnings": list(self.warnings),
        }


_WORDS = {"stays on the wall": "stalls", "reaches no port": "stalls", "order overtaken": "double blow"}
"""What a machine does that meets an obstacle whose own word says why."""


_NEAR = 1e-9


def _warnings(answer: MachineAnswer) -> list[str]:
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


def _ringing(answer: MachineAnswer) -> float:
    """How far a place of the bar swings about its centre after the blow, at most: v/ω_1, v L/(π C) of a uniform one."""
    reads = any(port.reads != "centre" for port in answer.machine.valve.ports)
    assert answer.cycle is not None
    slowest = float(answer.machine.body.frequencies(1)[0])
    return answer.cycle.blow_speed / slowest if reads and answer.motion.modes else 0.0


def _hysteresis(answer: MachineAnswer) -> float:
    """The least distance of two ports that demand different states."""
    ports = [port for port in answer.machine.valve.ports if port.behind is not None]
    apart = [abs((a.behind or 0.0) - (b.behind or 0.0)) for a in ports for b in ports if a.to != b.to]
    return min(apart, default=math.inf)


# ---- The answer for a machine that switches itself in plain values, with the names that other programs read

SHOWN_MULTIPLIERS = 16
"""The greatest multipliers, which are told."""


def cycle_dict(answer: MachineAnswer) -> dict[str, Any]:
    """What of it tells of the cycle itself."""
    motion, machine = answer.motion, answer.machine
    return {
        "case": answer.name,
        "title": answer.title,
        "machine": machine_numbers(machine),
        "modes": motion.modes,
        "outcome": answer.outcome,
        "label": answer.label,
        **_cycle(motion),
        "failed_condition": _condition(motion),
        "stable": None if motion.cycle is None else bool(motion.cycle.stable),
        "si": answer.si,
        "notes": list(answer.notes),
    }


def machine_numbers(machine: Machine) -> dict[str, Any]:
    """The numbers of a machine: its body, its valve and its gas, dimensionless."""
    valve = machine.valve
    return {
        "s": number(machine.body.s),
        "d": number(machine.drag),
        "restitution": number(machine.contact.restitution),
        "states": {name: number(force) for name, force in valve.pairs},
        "chamber": picked(valve.chamber, "force stiffness"),
        "supply": None if valve.supply is None else plain(asdict(valve.supply)),
        "ports": [picked(port, "to behind side delay reads on") for port in valve.ports],
        "start_state": valve.start,
    }


def _cycle(motion: SelfExcited) -> dict[str, Any]:
    cycle = motion.cycle
    if cycle is None:
        return plain_of(None, (*CYCLE, *POWER)) | {name: [] for name in ("blows", "ports", "valve", "multipliers")}
    blows = zip(numbers(cycle.blow_times), numbers(cycle.blow_speeds), numbers(cycle.blow_energies), strict=True)
    return {
        **plain_of(Running(motion.machine, cycle), (*CYCLE, *POWER)),
        "blows": [{"time": time, "speed": speed, "energy": energy} for time, speed, energy in blows],
        "ports": [{**picked(one, "port time"), "speed": number(-one.velocity)} for one in cycle.uncoverings],
        "valve": [{**picked(one, "time to behind work"), "speed": number(-one.velocity)} for one in cycle.switches],
        "multipliers": plain_value(cycle.multipliers[:SHOWN_MULTIPLIERS]),
    }


def _condition(motion: SelfExcited) -> dict[str, Any] | None:
    obstacle = motion.obstacle
    if obstacle is None:
        return None
    return {"condition": obstacle.value, **picked(obstacle, "words remedy"), **picked(motion, "found needed")}


def _margins(answer: MachineAnswer) -> dict[str, Any] | None:
    margins, cycle = answer.margins, answer.cycle
    if margins is None or cycle is None:
        return None
    rigid, own, ringing = answer.rigid.cycle, cycle.rhythm_multiplier, cycle.ringing
    rhythm = rigid.multiplier if own is None and rigid is not None else own
    return {
        "margin": number(1.0 - abs(cycle.multiplier)),
        "margin_rhythm": None if rhythm is None else number(1.0 - abs(rhythm)),
        "rhythm_of": "rigid" if own is None else "machine",
        "margin_ringing": None if ringing is None else number(1.0 - abs(ringing.multiplier)),
        "ringing": None if ringing is None else _ringing_json(ringing),
        "beyond": None if margins.beyond is None else margins.beyond.value,
        **picked(margins, "return_time latest_return chamber_to_run chamber_to_start flow_to_run accumulator_to_run"),
    }


def _supply(answer: MachineAnswer) -> dict[str, Any] | None:
    """The pressure over the cycle; in Pa where that of the states is known."""
    found, unit = answer.pressure, answer.machine.pressure or 1.0
    if found is None:
        return None
    pressures = {name: number(getattr(found, name) * unit) for name in ("at_blow", "mean", "least", "greatest")}
    return pressures | picked(found, "ripple multiplier slow_multiplier memory")


def _ringing_json(ringing: Ringing) -> dict[str, Any]:
    return {
        "multiplier": plain_value(ringing.multiplier),
        "decay_cycles": number(ringing.decay),
        "modes": [picked(one, "mode share") for one in ringing.told],
    }


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


# ---- The first sentences of the answer for a machine that switches itself: one home for the terminal and for reports


def headline(answer: MachineAnswer) -> str:
    """What the machine does, in one or two sentences."""
    cycle, obstacle = answer.cycle, answer.motion.obstacle
    if obstacle is None:
        assert cycle is not None
        starts = "It starts" if answer.motion.starts_from_rest else "It does not start"
        rest = ", with a rest on the wall" if cycle.rests else ""
        return (
            f"The machine runs with one blow a cycle{rest}: {figures_in_short(answer.machine, cycle)}; stable, a "
            f"disturbance is down to {numerals_number(100.0 * abs(cycle.multiplier), 3)} % after a cycle. "
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
    tell, rate = Teller.of(machine), cycle.blows / cycle.period
    if not tell.is_si:
        return f"striking speed {numerals_number(cycle.blow_speed, 5)}, period {numerals_number(cycle.period, 5)}"
    rates = f"{tell.given(rate, 'Hz')} ({tell.given(rate, 'per_min')})"
    return f"{tell(cycle.blow_energy, 'energy')} at {rates}, {tell(cycle.blow_speed, 'speed')}"


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
    tell = Teller.of(motion.machine)
    return f" ({text.format(found=tell(motion.found, kind), needed=tell(motion.needed or 0.0, kind))})"


def decided_by_rigid(answer: MachineAnswer) -> str:
    """The number that decides for a rigid piston, where it meets the same obstacle."""
    rigid = answer.rigid
    same = rigid is not answer.motion and rigid.obstacle is answer.motion.obstacle
    return f"{decided_by(rigid)[:-1]}, as a rigid piston)" if same and decided_by(rigid) else ""
