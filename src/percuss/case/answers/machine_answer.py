"""The dispatcher's answer to "how does this machine run, whose piston switches its own valve?"."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple

from percuss.case.answers.blows.transfer import (
    Transfer,
    tool_of,
    transfer_dict,
    transfer_section,
    transfer_sentence,
)
from percuss.case.answers.facts import (
    BAD,
    GOOD,
    PLAIN,
    Fact,
    Grid,
    Report,
    ReportSection,
    Teller,
    counted,
    grid_of,
    json_number,
    json_of,
    number,
    numbers,
    of_tool,
    percent,
    picked,
    plain,
    plain_of,
    plain_value,
    rows_of,
    said,
    settles,
)
from percuss.case.answers.heading import doubts, figures_in_short, machine_section, supply_pressure
from percuss.case.answers.machine_figures import (
    CYCLE,
    OIL,
    POWER,
    BlankBlowReport,
    MachineSensitivity,
    OilReport,
    Running,
    blank_blow_report,
    course_of,
    figures_in_si,
    pressure_curve,
    sensitivities,
)
from percuss.case.answers.whole_hammer import FigureUncertainty, WholeHammer
from percuss.case.case import checked_case
from percuss.errors import ParameterError
from percuss.model.checks import DEFAULT_MODES, count
from percuss.model.load.valve import port_at
from percuss.short_repr import ShortRepr
from percuss.simulate.stop import MAX_MODES
from percuss.steady import self_excited_motion
from percuss.steady.oil.oil_figures import lift_of
from percuss.steady.self_excited.margins import slow_pressure, valve_margins

if TYPE_CHECKING:
    from percuss.case.answers.machine_figures import AtPressure, CycleCurve
    from percuss.case.answers.steady_answer import CaseReach
    from percuss.case.case import Case
    from percuss.case.file_format.contact import BlowQuestion
    from percuss.model import Machine
    from percuss.steady.self_excited.margins import SlowPressure, ValveMargins
    from percuss.steady.self_excited.self_switching import SelfExcited
    from percuss.steady.self_excited.valve_cycle import ValveCycle


# ---- How a machine runs that switches itself, and what of it is told: outcome and label, warnings, margins


@dataclass(frozen=True)
class MachineAnswer(ShortRepr):
    """How a machine runs that switches its own valve, or what keeps it from running.

    Attributes
    ----------
    motion
        Its cycle with elastic modes, or what keeps it from running.
    rigid
        The same of a rigid piston.
    reach
        How far parameters may move before the cycle is lost (`percuss.case.reach_answer`); None unless asked for.
    tool
        The blow on the rod that the case describes, at any speed; None without one.
    plausibility
        Whether figures that no hammer has are told of.
    uncertainty
        What the ± of the numbers of the case leaves of the figures; None where none has one, or it was
        not asked (`percuss.case.uncertainty_of`).
    """

    name: str
    title: str
    motion: SelfExcited
    rigid: SelfExcited
    notes: tuple[str, ...] = ()
    reach: tuple[CaseReach, ...] | None = None
    tool: BlowQuestion | None = None
    plausibility: bool = True
    uncertainty: FigureUncertainty | None = None

    @cached_property
    def whole(self) -> WholeHammer:
        """The machine in its cycle, with what it strikes."""
        obstacle = self.motion.obstacle
        return WholeHammer(self.cycle, "" if obstacle is None else obstacle.value, self.tool)

    @property
    def transfer(self) -> Transfer | None:
        """Where the energy of the cycle goes, into tool and rock; None without a rod to strike, or one blow."""
        return self.whole.transfer

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
    def sensitivities(self) -> tuple[MachineSensitivity, ...]:
        """How energy and rate follow pressure, ports, delays and restitution; empty when it does not run."""
        return sensitivities(self._quick)

    @property
    def _quick(self) -> SelfExcited:
        """What is asked for many machines: with oil that flows a rigid piston."""
        return self.rigid if self.machine.valve.flows else self.motion

    @cached_property
    def oil(self) -> OilReport | None:
        """Where the energy of oil that flows goes; None where the oil loses nothing, or without a cycle."""
        cycle = self.cycle
        return None if cycle is None or cycle.oil is None else OilReport(self.machine, cycle)

    @cached_property
    def curve(self) -> tuple[AtPressure, ...]:
        """Energy and rate over the pressure, with a supply over the flow; empty when it does not run."""
        return pressure_curve(self._quick)

    @cached_property
    def blank(self) -> BlankBlowReport | None:
        """What it does that finds no tool, from the cycle of a rigid piston; None without one."""
        return blank_blow_report(self.rigid)

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
    def course(self) -> CycleCurve:
        """The cycle over time."""
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
        """Blows and valve cycles in a period, "1/1", or where a machine stalls: "on the tool"."""
        obstacle = self.motion.obstacle
        if obstacle is not None and obstacle.value == "stays on the wall":
            return "on the tool"
        if obstacle is not None and obstacle.value == "reaches no port":
            return "in the chamber" if self.machine.valve.chamber.stiffness > 0.0 else "leaves"
        return "" if self.cycle is None else f"{self.cycle.blows}/1"

    @property
    def warnings(self) -> tuple[str, ...]:
        """What a reader of the figures should know, one sentence each."""
        return tuple(of_tool(text, self.tool) for text in _warnings(self))

    def to_json_dict(self) -> dict[str, Any]:
        """The answer in plain values, as `percuss machine --json` prints it."""
        other = None if self.rigid is self.motion else self.rigid
        return {
            **cycle_dict(self),
            "starts_from_rest": bool(self.motion.starts_from_rest),
            "margins": None if self.margins is None else plain_of(self, (*STABILITY, *MARGINS)),
            "supply": None if self.pressure is None else plain_of(self, PRESSURE),
            **({} if self.oil is None else {"oil": json_of(self.oil, OIL, Teller.of(self.machine))}),
            "sensitivities": [plain(asdict(one)) for one in self.sensitivities],
            "pressure_curve": [plain(asdict(one)) for one in self.curve],
            "blank_blow": None if self.blank is None else self.blank.to_json_dict(),
            "rigid": None if other is None else _cycle_dict(other),
            "rigid_si": None if other is None else figures_in_si(self.machine, other.cycle),
            "warnings": list(self.warnings),
            **({} if self.reach is None else {"reach": [one.to_json_dict() for one in self.reach]}),
            **({} if self.tool is None else transfer_dict(self.transfer)),
            **({} if self.uncertainty is None else {"uncertainty": self.uncertainty.to_json_dict()}),
        }


_WORDS = {"stays on the wall": "stalls", "reaches no port": "stalls", "order overtaken": "double blow"}
"""What a machine does that meets an obstacle whose own word says why."""


_NEAR = 1e-9


def _warnings(answer: MachineAnswer) -> list[str]:
    found, machine = [], answer.machine
    if answer.runs and not answer.motion.starts_from_rest:
        found.append("the machine runs, but does not start from rest on the wall: it must be pushed off")
    if exchanged := _exchanged(answer):
        found.append(f"with the {exchanged} of its two ports exchanged the machine would run")
    cycle = answer.cycle
    if cycle is None:
        return found
    pressure = 1.0 if cycle.rebound.pressure is None else cycle.rebound.pressure
    latest = max(port_at(machine.valve, i, pressure).delay for i in range(len(machine.valve.ports)))
    if latest > cycle.period:
        found.append("a delay is longer than the cycle: orders of several cycles are under way at a time")
    gas, mean = None if machine.valve.supply is None else machine.valve.supply.gas, cycle.mean_pressure
    if gas is not None and gas.precharge >= mean:
        precharge, told = supply_pressure(machine, gas.precharge), supply_pressure(machine, mean)
        found.append(f"the precharge of the accumulator, {precharge}, is above the mean pressure, {told}")
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
    return [*found, *(doubts(cycle) if answer.plausibility else ())]


def _exchanged(answer: MachineAnswer) -> str:
    """What of two ports the wrong one has, of a machine that does not run and then would; "" for nothing."""
    valve = answer.machine.valve
    if answer.runs or answer.rigid.runs or len(valve.ports) != 2:
        return ""
    one, other = valve.ports
    for words, name in (("places", "behind"), ("demands", "to")):
        first, second = getattr(one, name), getattr(other, name)
        if first is None or second is None:
            continue
        ports = replace(one, **{name: second}), replace(other, **{name: first})
        machine = answer.machine.with_valve(replace(valve, ports=ports))
        room = answer.motion.room if math.isfinite(answer.motion.room) else None
        if self_excited_motion(machine, modes=0, room=room).runs:
            return words
    return ""


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

OIL_MODES = 8  # by default where the oil flows
SHOWN_MULTIPLIERS = 16  # the greatest multipliers, which are told


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
        **_cycle_dict(motion),
        "failed_condition": _condition(motion),
        "stable": None if motion.cycle is None else bool(motion.cycle.stable),
        "si": answer.si,
        "notes": list(answer.notes),
    }


def machine_numbers(machine: Machine) -> dict[str, Any]:
    """The numbers of a machine: its body, its valve and its gas, dimensionless."""
    valve = machine.valve
    return {
        "s": json_number(machine.body.s),
        "d": json_number(machine.drag),
        "restitution": json_number(machine.contact.restitution),
        "states": {name: json_number(force) for name, force in valve.pairs},
        "chamber": picked(valve.chamber, "force stiffness exponent"),
        "supply": None if valve.supply is None else plain(asdict(valve.supply)),
        "oil": None if valve.oil is None else plain(asdict(valve.oil)),
        "ports": [picked(port, "to behind side delay reads on speed") for port in valve.ports],
        "start_state": valve.start,
    }


def _cycle_dict(motion: SelfExcited) -> dict[str, Any]:
    cycle = motion.cycle
    if cycle is None:
        return plain_of(None, (*CYCLE, *POWER)) | {name: [] for name in ("blows", "ports", "valve", "multipliers")}
    blows = zip(numbers(cycle.blow_times), numbers(cycle.blow_speeds), numbers(cycle.blow_energies), strict=True)
    return {
        **plain_of(Running(motion.machine, cycle), (*CYCLE, *POWER)),
        "blows": [{"time": time, "speed": speed, "energy": energy} for time, speed, energy in blows],
        "ports": [{**picked(one, "port time"), "speed": json_number(-one.velocity)} for one in cycle.uncoverings],
        "valve": [
            {**picked(one, "time to behind work"), "speed": json_number(-one.velocity)} for one in cycle.switches
        ],
        "multipliers": plain_value(cycle.multipliers().values[:SHOWN_MULTIPLIERS]),
    }


def _condition(motion: SelfExcited) -> dict[str, Any] | None:
    obstacle = motion.obstacle
    if obstacle is None:
        return None
    return {"condition": obstacle.value, **picked(obstacle, "words remedy"), **picked(motion, "found needed")}


def machine_answer(case: Case, modes: int | None = None) -> MachineAnswer:
    """How the machine of a case runs whose load the piston switches.

    Parameters
    ----------
    modes
        Elastic modes; by default 32, 8 where the oil flows, whose steps each mode shortens; 0 for a rigid piston.

    Examples
    --------
    >>> from percuss.case import load_case
    >>> answer = machine_answer(load_case("valve-breaker"), modes=0)
    >>> answer.outcome, answer.label, round(answer.cycle.blow_speed * answer.machine.speed_scale, 2)
    ('runs', '1/1', 9.19)
    """
    checked_case(case)
    machine, room = case.machine(), case.room()
    usual = OIL_MODES if machine.valve.flows else DEFAULT_MODES
    kept = usual if modes is None else count("modes", modes, least=0, most=MAX_MODES)
    motion = self_excited_motion(machine, modes=kept, room=room)
    rigid = motion if kept == 0 else self_excited_motion(machine, modes=0, room=room)
    return MachineAnswer(case.file, case.title, motion, rigid, case.notes, tool=tool_of(case))


# ---- The first sentences of the answer for a machine that switches itself: one home for the terminal and for reports


def headline(answer: MachineAnswer) -> str:
    """What the machine does, in one or two sentences."""
    cycle, obstacle = answer.cycle, answer.motion.obstacle
    if obstacle is None:
        assert cycle is not None
        starts = "It starts" if answer.motion.starts_from_rest else "It does not start"
        rest = ", with a rest on the wall" if cycle.rests else ""
        text = (
            f"The machine runs with one blow a cycle{rest}: {cycle_in_short(answer.machine, cycle)}; stable: "
            f"{settles(abs(cycle.multiplier))}. {starts} from rest on the wall."
        )
        if answer.oil is not None:
            text += f" {answer.oil.sentence}"
        return of_tool(text, answer.tool)
    text = f"The machine does not run with one blow a cycle — {obstacle.value}: {obstacle.words}"
    text += f"{decided_by(answer.motion) or decided_by_rigid(answer)}.{_not_lifted(answer)}"
    if cycle is not None and cycle.blows > 1:
        strongest = cycle_in_short(answer.machine, cycle)
        text += f" It runs with {cycle.blows} blows a cycle, the strongest with {strongest}."
    return of_tool(text, answer.tool)


def _not_lifted(answer: MachineAnswer) -> str:
    """What pressure would lift the piston off the wall, where that of its supply does not; where a gas has no oil."""
    obstacle, machine = answer.motion.obstacle, answer.machine
    lift, supply = lift_of(machine) if machine.valve.flows else None, machine.valve.supply
    if obstacle is not None and obstacle.value == "no pressure" and supply is not None and supply.gas is not None:
        empty = supply_pressure(machine, supply.gas.precharge)
        line = "" if supply.compliance else ", and there is no line (supply.line) whose oil it could fall with"
        return f" The accumulator is empty below its precharge, {empty}{line}."
    if lift is None or obstacle is None or obstacle.value != "stays on the wall" or lift.lifts:
        return ""
    reached, needed = supply_pressure(machine, lift.reached), supply_pressure(machine, lift.needed)
    return f" The pressure comes to {reached} there, by {lift.limited_by}, and the return needs more than {needed}."


def cycle_in_short(machine: Machine, cycle: ValveCycle) -> str:
    """Energy, rate and striking speed of a cycle."""
    return figures_in_short(machine, cycle.main_energy, cycle.blow_speed, cycle.blows, cycle.period)


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


# ---- What is told of its stability, its margins and its supply


def _multipliers(answer: Any, _: Teller) -> str:
    found = answer.cycle.multipliers().values.tolist()
    felt = [z for z in found if abs(z) > _NOTHING and z.imag >= 0.0] or [0.0]  # a pair once
    more = f", and {len(felt) - _FEW} smaller ones" if len(felt) > _FEW else ""
    return ", ".join(_complex(z) for z in felt[:_FEW]) + more


def _rhythm_margin(answer: Any) -> float | None:
    own, rigid = answer.cycle.rhythm_multiplier, answer.rigid.cycle
    found = rigid.multiplier if own is None and rigid is not None else own
    return None if found is None else 1.0 - abs(found)


def _rhythm(answer: Any, _: Teller) -> str | None:
    margin = _rhythm_margin(answer)
    if margin is None or not answer.motion.modes:
        return None
    if answer.cycle.rhythm_multiplier is None:
        return f"margin {number(margin)}, that of a rigid piston: here it cannot be told from the ringing"
    return f"margin {number(margin)}, that of the motion as a whole"


def _ringing_margin(answer: Any) -> float | None:
    found = answer.cycle.ringing
    return None if found is None else 1.0 - abs(found.multiplier)


def _ringing_words(answer: Any, _: Teller) -> str | None:
    found = answer.cycle.ringing
    if found is None or not answer.motion.modes:
        return None
    modes = ", ".join(f"{_mode(one.mode)} ({percent(one.share)})" for one in found.told)
    decay = f"down to 1/e in {number(found.decay, 3)} cycles" if math.isfinite(found.decay) else "does not die out"
    return f"margin {number(_ringing_margin(answer) or 0.0)}, {decay}: {modes}"


def _ringing_dict(answer: Any) -> dict[str, Any] | None:
    found = answer.cycle.ringing
    if found is None:
        return None
    modes = [picked(one, "mode share") for one in found.told]
    return {"multiplier": found.multiplier, "decay_cycles": found.decay, "modes": modes}


STABILITY: tuple[Fact[MachineAnswer], ...] = (
    Fact("", "multipliers", "those of the cycle", "", "cycle.multipliers", _multipliers),
    Fact("margin", "margin", "1 minus the greatest modulus of the multipliers", "",
         lambda one: 1.0 - abs(one.cycle.multiplier) if one.cycle is not None else None),
    Fact("margin_rhythm", "rhythm", "the same of those of the motion as a whole", "", _rhythm_margin, _rhythm),
    Fact("rhythm_of", "",
         '`"machine"`, or `"rigid"` where `margin_rhythm` is that of a rigid piston, since no multiplier of the '
         "machine is one of the motion as a whole (more than half by participation)", "",
         lambda one: "machine" if one.cycle is not None and one.cycle.rhythm_multiplier is not None else "rigid"),
    Fact("margin_ringing", "ringing",
         "the same of the others; null for a rigid piston, and where nothing is left of the ringing after a cycle", "",
         _ringing_margin, _ringing_words),
    Fact("ringing", "", "null, or what rings longest, see below", "", _ringing_dict),
    Fact("", "compare", "with a load that keeps time", "", "cycle",
         lambda *_: "the piston's own valve re-times the load after every blow: there is no phase to lose"),
)  # fmt: skip
"""How stable a cycle is."""


def _return(answer: Any, tell: Teller) -> str:
    margins = answer.margins
    sides = ["after" if time >= 0.0 else "before" for time in (margins.return_time, margins.latest_return or 0.0)]
    now = f"it comes {tell(abs(margins.return_time), 'time')} {sides[0]} the blow"
    if margins.latest_return is None:
        return f"{now}; no limit was found within eight periods"
    then = "the machine stops" if margins.beyond is None else margins.beyond.value
    return f"{now}, and may come up to {tell(abs(margins.latest_return), 'time')} {sides[1]} it: beyond, {then}"


def _gas(name: str, then: str) -> Callable[[Any, Teller], str | None]:
    def words(answer: Any, _: Teller) -> str | None:
        gas, factor = answer.machine.valve.chamber, getattr(answer.margins, name)
        if answer.machine.valve.supply is not None or not (gas.force > 0.0 or gas.stiffness > 0.0):
            return None
        if not factor:
            return "no limit was found" if factor is None else "does not start from rest, also without gas"
        more = number(100.0 * (factor - 1.0), 3)
        return f"above {number(factor)} times its force and stiffness ({more} % more) the machine {then}"

    return words


def _supplied(name: str) -> Callable[[Any, Teller], str | None]:
    def words(answer: Any, _: Teller) -> str | None:
        factor = getattr(answer.margins, name)
        if answer.machine.valve.supply is None or factor is None:
            return None if answer.machine.valve.supply is None else "no limit was found"
        return f"below {number(factor)} times as much it does not run, or not steadily"

    return words


MARGINS: tuple[Fact[MachineAnswer], ...] = (
    Fact("return_time", "return", "when the state changes that sends the piston back, after the blow", "time",
         "margins.return_time", _return),
    Fact("latest_return", "", "how late that may be; null where no limit was found", "time", "margins.latest_return"),
    Fact("beyond", "", 'what happens beyond, such as `"double blow"`; or null', "", "margins.beyond.value"),
    Fact("chamber_to_run", "gas, to run", "the factor on the gas up to which the machine runs; or null", "",
         "margins.chamber_to_run", _gas("chamber_to_run", "no longer runs")),
    Fact("chamber_to_start", "gas, to start", "and starts from rest; or null", "", "margins.chamber_to_start",
         _gas("chamber_to_start", "no longer starts from rest")),
    Fact("flow_to_run", "flow, to run", "the factor on the flow of a pump down to which it runs steadily; or null", "",
         "margins.flow_to_run", _supplied("flow_to_run")),
    Fact("accumulator_to_run", "accumulator", "and on its accumulator; or null", "", "margins.accumulator_to_run",
         _supplied("accumulator_to_run")),
)  # fmt: skip
"""How far a machine is from what would stop it."""


def _pressure(name: str) -> Callable[[Any], float]:
    """In Pa, or as a multiple of that of the states where it is not known."""
    return lambda answer: float(getattr(answer.pressure, name)) * (answer.machine.pressure or 1.0)


def _bars(answer: Any, *names: str) -> list[str]:
    return [supply_pressure(answer.machine, getattr(answer.pressure, name)) for name in names]


def _ripple(answer: Any, _: Teller) -> str:
    return "{} to {}, ".format(*_bars(answer, "least", "greatest")) + f"{percent(answer.pressure.ripple)} of the mean"


def _disturbed(answer: Any, _: Teller) -> str:
    found = answer.pressure
    slow = "" if found.slow_multiplier is None else f"; by the pressure alone {number(found.slow_multiplier, 3)}"
    return f"{_complex(found.multiplier)} of a disturbance of the pressure{slow}"


def _memory(answer: Any, _: Teller) -> str | None:
    memory = answer.pressure.memory
    return f"{number(memory, 3)} cycles until it has fallen to 1/e" if math.isfinite(memory) else None


PRESSURE: tuple[Fact[MachineAnswer], ...] = (
    Fact("mean", "pressure", "in Pa; in a dimensionless case as a multiple of that of the states", "",
         _pressure("mean"), lambda one, _: "{} on average, {} at the blow".format(*_bars(one, "mean", "at_blow"))),
    Fact("at_blow", "", "the same at the blow", "", _pressure("at_blow")),
    Fact("least", "", "at least", "", _pressure("least")),
    Fact("greatest", "", "at most", "", _pressure("greatest")),
    Fact("ripple", "ripple", "greatest minus least, as a part of the mean", "", "pressure.ripple",
         _ripple),
    Fact("multiplier", "multiplier", "what is left of a disturbance of the pressure after a cycle, `[re, im]`", "",
         "pressure.multiplier", _disturbed),
    Fact("slow_multiplier", "", "the same for an accumulator so great that the speed follows at once; or null", "",
         "pressure.slow_multiplier"),
    Fact("memory", "memory", "cycles in which such a disturbance falls to 1/e; null when it does not", "",
         "pressure.memory", _memory),
)  # fmt: skip
"""The pressure that a pump and an accumulator give."""


def _mode(mode: int) -> str:
    return f"mode {mode}" if mode else "the motion as a whole"


def _complex(z: complex) -> str:
    return number(z.real, 3) if abs(z.imag) <= 1e-9 * abs(z) else f"{number(z.real, 3)} ± {number(abs(z.imag), 3)}i"


# ---- The report


_FEW = 8  # multipliers that are told
_NOTHING = 1e-12  # a multiplier that is rounding


def machine_report(answer: MachineAnswer) -> Report:
    tell = Teller.of(answer.machine)
    sections: list[ReportSection | Grid] = [
        machine_section(answer.name, answer.machine, answer.notes, answer.motion.room)
    ]
    if (obstacle := answer.motion.obstacle) is not None:
        rows = (("what", obstacle.words), ("remedy", obstacle.remedy))
        sections.append(ReportSection(f"Why not: {obstacle.value}", rows, BAD))
    if answer.cycle is not None:
        sections += [_blows_section(answer, answer.cycle), _events_grid(answer.machine, answer.cycle)]
        if answer.machine.is_si:
            running = Running(answer.machine, answer.cycle)
            sections.append(ReportSection("Power and oil", tuple(rows_of(running, POWER, tell))))
        if answer.oil is not None:
            sections.append(ReportSection("Where the oil's power goes", tuple(rows_of(answer.oil, OIL, tell))))
        if answer.transfer is not None:
            sections.append(transfer_section(answer.transfer))
        if answer.pressure is not None:
            sections.append(ReportSection("Pressure of the supply", tuple(rows_of(answer, PRESSURE, tell))))
        sections.append(
            ReportSection("Stability", tuple(rows_of(answer, STABILITY, tell)), GOOD if answer.cycle.stable else BAD)
        )
    if answer.margins is not None:
        sections.append(ReportSection("Margins (rigid piston)", tuple(rows_of(answer, MARGINS, tell))))
    if answer.sensitivities:
        sections.append(_sensitivity_grid(answer))
    if answer.reach is not None:
        reach = [(row.label, row.words) for row in answer.reach] or [("reach", "no stable motion to follow")]
        sections.append(ReportSection("How far parameters may move", tuple(reach)))
    if answer.blank is not None:
        sections.append(ReportSection("Without the tool (blank blow of a rigid piston)", answer.blank.rows, PLAIN))
    told = [headline(answer), transfer_sentence(answer.transfer) if answer.runs else ""]
    if answer.uncertainty is not None:
        told.append(answer.uncertainty.sentence)
        sections.insert(1, answer.uncertainty.grid)
    summary = " ".join(filter(None, told))
    return Report(answer.title, summary, GOOD if answer.runs else BAD, tuple(sections)).of_tool(answer.tool)


# -- what it does -----------------------------------------------------------------------------------------------------


def _blows_section(answer: MachineAnswer, cycle: ValveCycle) -> ReportSection:
    machine, other = answer.machine, answer.rigid
    rows = rows_of(Running(machine, cycle), CYCLE, Teller.of(machine))
    if other is not answer.motion and other.cycle is not None:
        told = "{cycle.main_energy:energy}, {cycle.blow_speed:speed}, {rate:per_min}, stroke {cycle.stroke:length}"
        told = told if machine.is_si else "speed {cycle.blow_speed}, period {cycle.period}"
        rows.append(("rigid piston", said(told, Running(machine, other.cycle), Teller.of(machine)) or ""))
    kind = f"{counted(answer.motion.modes, 'elastic mode')}" if answer.motion.modes else "rigid piston"
    return ReportSection(f"Cycle, {counted(cycle.blows, 'blow')} in it ({kind})", tuple(rows))


def _events_grid(machine: Machine, cycle: ValveCycle) -> Grid:
    ports = machine.valve.ports
    found = [
        *(_Happens(one.time, f"ports[{one.port}] uncovered", ports[one.port].behind, -one.velocity)
          for one in cycle.uncoverings),
        *(_Happens(one.time, f"valve: {one.to}", max(one.behind, 0.0), -one.velocity) for one in cycle.switches),
        *(_Happens(time, "blow", 0.0, speed)
          for time, speed in zip(cycle.blow_times.tolist(), cycle.blow_speeds.tolist(), strict=True)),
    ]  # fmt: skip
    tell, heading = Teller.of(machine), "Events, from just after the blow"
    return grid_of(heading, sorted(found, key=lambda one: one.time), _HAPPENS, tell)


class _Happens(NamedTuple):
    time: float
    what: str
    behind: float | None
    speed: float


_HAPPENS: tuple[Fact[_Happens], ...] = (
    Fact("", "event", "what happens", "", "what", lambda one, _: one.what),
    Fact("", "time", "after the blow", "time", "time", "{time:time}"),
    Fact("", "behind the wall", "where the piston is, or the port", "length", "behind", "{behind:length}"),
    Fact("", "speed toward it", "of the piston", "speed", "speed", "{speed:speed}"),
)


def _sensitivity_grid(answer: MachineAnswer) -> Grid:
    rows = []
    for one in answer.sensitivities:
        figures = ("", "") if one.energy is None or one.rate is None else (_signed(one.energy), _signed(one.rate))
        stops = [f"{change}: {why}" for change, why in zip(("−10 %", "+10 %"), one.stops, strict=True) if why]
        rows.append((one.parameter, *figures, "; ".join(stops)))
    if any(row[3] for row in rows):
        return Grid("For 10 % more of", ("parameter", "energy", "rate", "does not run at"), tuple(rows))
    return Grid("For 10 % more of", ("parameter", "energy", "rate"), tuple(row[:3] for row in rows))


def _signed(change: float) -> str:
    return f"{'+' if change >= 0.0 else '−'}{number(100.0 * abs(change), 3)} %"
