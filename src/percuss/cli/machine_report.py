"""The answer for a machine that switches itself, as the report that a person reads."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from percuss.case.answers.facts import Teller, rows_of
from percuss.case.answers.machine_answer import headline
from percuss.case.answers.machine_figures import CYCLE, POWER, Running
from percuss.case.answers.machine_frames import from_this_start
from percuss.case.answers.numerals import counted, number, percent, quantity
from percuss.case.answers.recorded_answer import by_clock, by_valve, recorded_headline
from percuss.case.answers.report_parts import BAD, GOOD, PLAIN, Grid, Report, Section
from percuss.case.answers.simulation_answer import held_down_in_words
from percuss.simulate.machine.fed_running import FedTrajectory

if TYPE_CHECKING:
    from percuss.case import MachineAnswer
    from percuss.case.answers.recorded_answer import RecordedAnswer
    from percuss.case.answers.simulation_answer import MachineMotion
    from percuss.model import Machine, Supply
    from percuss.steady import Interval, Reading, RecordedSwitch
    from percuss.steady.self_excited import SelfExcited, SlowPressure, ValveCycle, ValveMargins

_FEW = 8  # multipliers that are told
_NOTHING = 1e-12  # a multiplier that is rounding


def machine_report(answer: MachineAnswer) -> Report:
    """The report of `percuss machine`."""
    sections: list[Section | Grid] = [machine_section(answer.name, answer.machine, answer.notes, answer.motion.room)]
    if not answer.runs:
        sections.append(_obstacle_section(answer.motion))
    if answer.cycle is not None:
        sections += [_blows_section(answer, answer.cycle), _events_grid(answer.machine, answer.cycle)]
        if answer.machine.is_si:
            running = Running(answer.machine, answer.cycle)
            sections.append(Section("Power and oil", tuple(rows_of(running, POWER, Teller.of(answer.machine)))))
        if answer.pressure is not None:
            sections.append(_pressure_section(answer.machine, answer.pressure))
        sections.append(_stability_section(answer, answer.cycle))
    if answer.margins is not None:
        sections.append(_margins_section(answer, answer.margins))
    if answer.sensitivities:
        sections.append(_sensitivity_grid(answer))
    if answer.blank is not None:
        sections.append(Section("Without the tool (blank blow of a rigid piston)", answer.blank.rows, PLAIN))
    return Report(answer.title, headline(answer), GOOD if answer.runs else BAD, tuple(sections))


# -- the machine ------------------------------------------------------------------------------------------------------


def machine_section(name: str, machine: Machine, notes: tuple[str, ...], room: float) -> Section:
    """What was understood of the machine: bar, valve, ports, gas."""
    rows: list[tuple[str, str]] = [("case", name)]
    valve, bar, tell = machine.valve, machine.bar, Teller.of(machine)
    if bar is not None:
        rows.append(("piston", f"{quantity(bar.length, 'm')} long, {number(bar.mass)} kg"))
    rows.append(("contact", f"restitution R = {number(machine.contact.restitution)}; {machine.contact.sentence}"))
    drag = machine.drag
    rows.append(("drag", f"D/M = {number(drag)}{' per second' if bar is not None else ''}" if drag else "none"))
    gas = valve.chamber
    if gas.force or gas.stiffness:
        at_wall = tell(gas.force, "force")
        growth = gas.stiffness * (1.0 if bar is None else machine.force_scale / machine.length_scale)
        more = number(growth) if bar is None else f"{quantity(growth, 'N')}/m"
        rows.append(("gas", f"{at_wall} at the wall, and {more} more on the way back"))
    if machine.pressure is not None:
        held = "" if valve.supply is None else ", for which the forces below hold"
        rows.append(("supply", f"{number(machine.pressure / 1e5)} bar{held}"))
    if valve.supply is not None:
        rows.append(("pump", _pump_text(machine, valve.supply)))
    with_gas = " with the gas at the wall" if gas.force else ""
    for state, _ in valve.pairs:
        begins = ", the state at the start" if state == valve.start else ""
        force = valve.force(state)
        where = "toward the wall" if force >= 0.0 else "away from the wall"
        rows.append((state, f"{tell(abs(force), 'force')} {where}{with_gas}{begins}"))
    for i in range(len(valve.ports)):
        rows.append((f"ports[{i}]", _port_text(machine, i)))
    if math.isfinite(room):
        rows.append(("room", f"{tell(room, 'length')} behind the wall"))
    rows += [("note", note) for note in notes]
    return Section("Machine", tuple(rows))


def _pump_text(machine: Machine, supply: Supply) -> str:
    unit = machine.pressure
    if unit is None:
        return f"flow {number(supply.flow)}, accumulator {number(supply.compliance)}, pressure 1 for the forces below"
    flow = supply.flow * machine.power_scale / unit
    volume = supply.compliance * machine.energy_scale / unit**2
    return (
        f"{number(6e4 * flow)} l/min into an accumulator of {number(1e11 * volume)} cm³/bar; "
        f"{number(supply.start * unit / 1e5)} bar at the start"
    )


def _port_text(machine: Machine, number_of: int) -> str:
    port, tell = machine.valve.ports[number_of], Teller.of(machine)
    delay = f" after {tell(port.delay, 'time')}" if port.delay else ""
    if port.on == "impact" or port.behind is None:
        return f"every blow: {port.to}{delay}"
    where = "farther than" if port.side == "back" else "nearer than"
    whose = "" if port.reads == "centre" else f", read at x = {number(float(port.reads))} of the bar"
    return f"{where} {tell(port.behind, 'length')} behind the wall: {port.to}{delay}{whose}"


# -- what it does -----------------------------------------------------------------------------------------------------


def _obstacle_section(motion: SelfExcited) -> Section:
    obstacle = motion.obstacle
    assert obstacle is not None
    return Section(f"Why not: {obstacle.value}", (("what", obstacle.words), ("remedy", obstacle.remedy)), BAD)


def _blows_section(answer: MachineAnswer, cycle: ValveCycle) -> Section:
    machine, other = answer.machine, answer.rigid
    rows = rows_of(Running(machine, cycle), CYCLE, Teller.of(machine))
    if other is not answer.motion and other.cycle is not None:
        rows.append(("rigid piston", _rigid_text(machine, other.cycle)))
    kind = f"{counted(answer.motion.modes, 'elastic mode')}" if answer.motion.modes else "rigid piston"
    return Section(f"Cycle, {counted(cycle.blows, 'blow')} in it ({kind})", tuple(rows))


def _rigid_text(machine: Machine, cycle: ValveCycle) -> str:
    tell = Teller.of(machine)
    if not tell.is_si:
        return f"speed {number(cycle.blow_speed)}, period {number(cycle.period)}"
    return (
        f"{tell(cycle.blow_energy, 'energy')}, {tell(cycle.blow_speed, 'speed')}, "
        f"{tell.given(cycle.blows / cycle.period, 'per_min')}, stroke {tell(cycle.stroke, 'length')}"
    )


def _events_grid(machine: Machine, cycle: ValveCycle) -> Grid:
    """Everything that happens in a cycle, in order."""
    tell = Teller.of(machine)
    rows: list[tuple[float, str, float, float | None]]
    rows = [
        (one.time, f"ports[{one.port}] uncovered", -one.velocity, machine.valve.ports[one.port].behind)
        for one in cycle.uncoverings
    ]
    rows += [(one.time, f"valve: {one.to}", -one.velocity, one.behind) for one in cycle.switches]
    blows = zip(cycle.blow_times.tolist(), cycle.blow_speeds.tolist(), strict=True)
    rows += [(time, "blow", speed, 0.0) for time, speed in blows]
    rows.sort(key=lambda row: row[0])
    return Grid(
        "Events, from just after the blow",
        ("event", "time", "behind the wall", "speed toward it"),
        tuple(
            (
                what,
                tell(time, "time"),
                "" if behind is None else tell(max(behind, 0.0), "length"),
                tell(speed, "speed"),
            )
            for time, what, speed, behind in rows
        ),
    )


def _pressure_section(machine: Machine, found: SlowPressure) -> Section:
    rows = [
        ("pressure", f"{_bar(machine, found.mean)} on average, {_bar(machine, found.at_blow)} at the blow"),
        (
            "ripple",
            f"{_bar(machine, found.least)} to {_bar(machine, found.greatest)}, {percent(found.ripple)} of the mean",
        ),
    ]
    slow = "" if found.slow_multiplier is None else f"; by the pressure alone {number(found.slow_multiplier, 3)}"
    rows.append(("multiplier", f"{_complex(found.multiplier)} of a disturbance of the pressure{slow}"))
    if math.isfinite(found.memory):
        rows.append(("memory", f"{number(found.memory, 3)} cycles until it has fallen to 1/e"))
    return Section("Pressure of the supply", tuple(rows))


def _bar(machine: Machine, pressure: float) -> str:
    """The pressure of a supply, as a multiple of the one for which the forces hold where that is not known."""
    return number(pressure) if machine.pressure is None else f"{number(pressure * machine.pressure / 1e5)} bar"


def _stability_section(answer: MachineAnswer, cycle: ValveCycle) -> Section:
    felt = [z for z in cycle.multipliers.tolist() if abs(z) > _NOTHING and z.imag >= 0.0] or [0.0]  # a pair once
    shown = ", ".join(_complex(z) for z in felt[:_FEW])
    more = f", and {len(felt) - _FEW} smaller ones" if len(felt) > _FEW else ""
    rows = [
        ("multipliers", f"{shown}{more}"),
        ("margin", f"{number(1.0 - abs(cycle.multiplier))}, 1 minus the greatest modulus"),
    ]
    if answer.motion.modes:
        rows += _rhythm_and_ringing(answer, cycle)
    rows.append(("compare", "the piston's own valve re-times the load after every blow: there is no phase to lose"))
    return Section("Stability", tuple(rows), GOOD if cycle.stable else BAD)


def _rhythm_and_ringing(answer: MachineAnswer, cycle: ValveCycle) -> list[tuple[str, str]]:
    own, rigid, ringing = cycle.rhythm_multiplier, answer.rigid.cycle, cycle.ringing
    rows = []
    if own is not None:
        rows.append(("rhythm", f"margin {number(1.0 - abs(own))}, that of the motion as a whole"))
    elif rigid is not None:
        text = f"margin {number(1.0 - abs(rigid.multiplier))}, that of a rigid piston"
        rows.append(("rhythm", f"{text}: here it cannot be told from the ringing"))
    if ringing is not None:
        modes = ", ".join(f"{_mode(one.mode)} ({percent(one.share)})" for one in ringing.told)
        decay = (
            f"down to 1/e in {number(ringing.decay, 3)} cycles" if math.isfinite(ringing.decay) else "does not die out"
        )
        rows.append(("ringing", f"margin {number(1.0 - abs(ringing.multiplier))}, {decay}: {modes}"))
    return rows


def _mode(mode: int) -> str:
    return f"mode {mode}" if mode else "the motion as a whole"


def _complex(z: complex) -> str:
    return number(z.real, 3) if abs(z.imag) <= 1e-9 * abs(z) else f"{number(z.real, 3)} ± {number(abs(z.imag), 3)}i"


def _margins_section(answer: MachineAnswer, margins: ValveMargins) -> Section:
    machine, tell = answer.machine, Teller.of(answer.machine)
    now = tell(abs(margins.return_time), "time")
    side = "after" if margins.return_time >= 0.0 else "before"
    if margins.latest_return is None:
        late = f"it comes {now} {side} the blow; no limit was found within eight periods"
    else:
        latest = tell(abs(margins.latest_return), "time")
        then = "the machine stops" if margins.beyond is None else margins.beyond.value
        limit = "after" if margins.latest_return >= 0.0 else "before"
        late = f"it comes {now} {side} the blow, and may come up to {latest} {limit} it: beyond, {then}"
    rows = [("return", late)]
    gas = machine.valve.chamber
    if (gas.force > 0.0 or gas.stiffness > 0.0) and machine.valve.supply is None:
        rows.append(("gas, to run", _factor(margins.chamber_to_run, "no longer runs")))
        rows.append(("gas, to start", _factor(margins.chamber_to_start, "no longer starts from rest")))
    if machine.valve.supply is not None:
        for name, factor in (("flow, to run", margins.flow_to_run), ("accumulator", margins.accumulator_to_run)):
            least = "no limit was found" if factor is None else f"below {number(factor)} times as much it does not run"
            rows.append((name, least if factor is None else f"{least}, or not steadily"))
    return Section("Margins (rigid piston)", tuple(rows))


def _factor(factor: float | None, then: str) -> str:
    if factor is None:
        return "no limit was found"
    if factor == 0.0:
        return "does not start from rest, also without gas"
    more = number(100.0 * (factor - 1.0), 3)
    return f"above {number(factor)} times its force and stiffness ({more} % more) the machine {then}"


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


# ---- A recorded load read as a valve, as the report that a person reads


def recorded_report(answer: RecordedAnswer) -> Report:
    """The report of `percuss machine` for a recorded load: what was read, then the machine's own."""
    whole = machine_report(answer.answer)
    own = (_read_section(answer), _switches_grid(answer), _readings_section(answer), _verdicts_section(answer))
    mark = GOOD if answer.runs else BAD
    return Report(answer.answer.title, recorded_headline(answer), mark, (*own, *whole.sections))


def _read_section(answer: RecordedAnswer) -> Section:
    read, machine, tell = answer.read, answer.read.machine, Teller.of(answer.read.machine)
    cycles = "the mean cycle" if not read.cycles else f"{counted(read.cycles, 'cycle')}, one by one"
    rows = [
        ("read from", cycles),
        ("blow", f"at phase {number(read.phase)} rad of the load, {tell(read.speed, 'speed')}"),
        ("stroke", tell(read.stroke, "length")),
    ]
    if read.restitution is not None:
        low, high = number(read.restitution.low, 3), number(read.restitution.high, 3)
        rows.append(("rebound", f"R = {number(read.restitution.value, 3)} ({low} to {high}) by the measured blows"))
    gas = read.stiffness
    if gas.value > 0.0:
        scale = machine.force_scale / machine.length_scale if machine.is_si else 1.0
        unit = " N/m" if machine.is_si else ""
        slope = f"{number(gas.value * scale)}{unit} ({number(gas.low * scale)} to {number(gas.high * scale)})"
        rows.append(("gas", f"stiffness {slope}, by the slope of the force against the distance"))
    if read.opposing_share is not None:
        text = (
            f"{percent(read.opposing_share)} of the highest force, constant: an estimate, with which the blow comes as "
            "the force falls. If the front chamber is always under supply, it is the ratio of its area to the rear one"
        )
        rows.append(("opposing force", text))
    rows += [("warning", warning) for warning in answer.warnings]
    rows += [("note", note) for note in read.notes]
    return Section("From the record", tuple(rows))


def _switches_grid(answer: RecordedAnswer) -> Grid:
    tell = Teller.of(answer.read.machine)
    rows = []
    for switch in answer.read.switches:
        side = "before" if switch.time.value < 0.0 else "after"
        rows.append(
            (
                switch.to,
                f"{tell(abs(switch.time.value), 'time')} {side} the blow",
                _interval(tell, switch.behind, "length"),
                tell(-switch.velocity.value, "speed"),
                _recorded_port_text(tell, switch),
            )
        )
    columns = ("switch to", "time", "behind the wall", "speed toward it", "port and delay")
    return Grid("Switches of the force", columns, tuple(rows))


def _recorded_port_text(tell: Teller, switch: RecordedSwitch) -> str:
    found = switch.found
    if not found.told_apart:
        return f"not told apart: a delay of {tell(max(found.least, 0.0), 'time')} or more"
    return f"{_interval(tell, found.port, 'length')}, {_interval(tell, found.delay, 'time')}"


def _interval(tell: Teller, interval: Interval, kind: str) -> str:
    value, low, high = (tell(one, kind) for one in interval)
    return value if low == high else f"{value} ({low} to {high})"


def _readings_section(answer: RecordedAnswer) -> Section:
    rows = [("least delays", _reading(answer.read.by_ports)), ("longest", _reading(answer.read.by_delays))]
    rows.append(("of these", "each gives the recorded motion; with longer delays the machine would not run steadily"))
    return Section("The two extreme readings (rigid piston)", tuple(rows))


def _reading(reading: Reading) -> str:
    tell, ports = Teller.of(reading.machine), []
    for port in reading.machine.valve.ports:
        where = "at the blow" if port.behind is None else f"port at {tell(port.behind, 'length')}"
        ports.append(f"{port.to}: {where}, delay {tell(max(port.delay, 0.0), 'time')}")
    return f"{'; '.join(ports)}; {by_valve(reading.cycle)}"


def _verdicts_section(answer: RecordedAnswer) -> Section:
    rows = (
        ("under a clock", by_clock(answer)),
        ("with the valve", by_valve(answer.answer.cycle)),
        ("both", "have the phase, speed and energy of the recorded motion; a clock does not wait for a late blow"),
    )
    return Section("The two verdicts on the recorded motion", rows, GOOD if answer.runs else BAD)


# ---- A simulated motion of a machine that switches its own valve, as the report that a person reads


def machine_motion_report(answer: MachineMotion, last: int | None) -> Report:
    """The report of `percuss simulate` for a machine, with the `last` events; None shows all of them."""
    motion, machine, tell = answer.motion, answer.machine, Teller.of(answer.machine)
    sections: list[Section | Grid] = [machine_section(answer.name, machine, answer.notes, math.inf)]
    rows = [
        ("ended", f"{motion.outcome}, after {counted(motion.impacts, 'impact')} and {tell(motion.end_time, 'time')}"),
        ("modes", counted(motion.modes, "elastic mode") if motion.modes else "rigid piston"),
    ]
    if isinstance(motion, FedTrajectory):
        rows.append(("pressure", _pressures(motion)))
    if motion.cycle is not None:
        rows.append(("period", tell(motion.cycle.period, "time")))
    rows += held_down_in_words(motion.events.held_down)
    sections.append(Section("Motion", tuple(rows)))
    if last != 0 and len(motion.events):
        sections.append(_motion_events_grid(answer, last))
    tone = GOOD if motion.label.startswith("runs") else PLAIN if motion.label == "undecided" else BAD
    return Report(answer.title, from_this_start(answer), tone, tuple(sections))


def _pressures(motion: FedTrajectory) -> str:
    """The pressure of a supply at the start, and after the last blow."""
    last = motion.blow_times[-1:] if motion.impacts else motion.end_time
    values = [float(motion.states[0, 2]), float(motion.pressure(last)[0])]
    first, then = (_bar(motion.machine, value) for value in values)
    return f"{first} at the start, {then} {'at the last blow' if motion.impacts else 'at the end'}"


def _motion_events_grid(answer: MachineMotion, last: int | None) -> Grid:
    """The last events, one a line."""
    events, tell = list(answer.motion.events), Teller.of(answer.machine)
    shown = events if last is None else events[max(len(events) - last, 0) :]
    rows = []
    for event in shown:
        what = event.kind
        if event.kind == "port":
            what = f"ports[{event.port}] demands"
        if event.kind == "valve":
            what = f"valve: {event.state}"
        rows.append((what, tell(event.time, "time"), tell(event.velocity, "speed")))
    heading = "Events" if len(shown) == len(events) else f"The last {len(shown)} of {len(events)} events"
    return Grid(heading, ("event", "time", "speed toward the wall"), tuple(rows))
