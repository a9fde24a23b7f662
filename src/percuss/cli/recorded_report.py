"""A recorded load read as a valve, as the report that a person reads."""

from __future__ import annotations

from typing import TYPE_CHECKING

from percuss.case.answers.machine_units import in_units
from percuss.case.answers.numerals import counted, number, percent
from percuss.case.answers.recorded_in_words import by_clock, by_valve, recorded_headline
from percuss.cli.machine_report import machine_report
from percuss.cli.report_parts import BAD, GOOD, Grid, Report, Section

if TYPE_CHECKING:
    from percuss.case.answers.recorded_answer import RecordedAnswer
    from percuss.model import Machine
    from percuss.steady import Interval, Reading, RecordedSwitch

__all__ = ["recorded_report"]


def recorded_report(answer: RecordedAnswer) -> Report:
    """The report of `percuss machine` for a recorded load: what was read, then the machine's own."""
    whole = machine_report(answer.answer)
    own = (_read_section(answer), _switches_grid(answer), _readings_section(answer), _verdicts_section(answer))
    mark = GOOD if answer.runs else BAD
    return Report(answer.answer.title, recorded_headline(answer), mark, (*own, *whole.sections))


def _read_section(answer: RecordedAnswer) -> Section:
    read, machine = answer.read, answer.read.machine
    cycles = "the mean cycle" if not read.cycles else f"{counted(read.cycles, 'cycle')}, one by one"
    rows = [
        ("read from", cycles),
        ("blow", f"at phase {number(read.phase)} rad of the load, {in_units(machine, read.speed, 'speed')}"),
        ("stroke", in_units(machine, read.stroke, "length")),
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
    rows += [("note", note) for note in read.notes]
    return Section("From the record", tuple(rows))


def _switches_grid(answer: RecordedAnswer) -> Grid:
    machine = answer.read.machine
    rows = []
    for switch in answer.read.switches:
        side = "before" if switch.time.value < 0.0 else "after"
        rows.append(
            (
                switch.to,
                f"{in_units(machine, abs(switch.time.value), 'time')} {side} the blow",
                _interval(machine, switch.behind, "length"),
                in_units(machine, -switch.velocity.value, "speed"),
                _port_text(machine, switch),
            )
        )
    columns = ("switch to", "time", "behind the wall", "speed toward it", "port and delay")
    return Grid("Switches of the force", columns, tuple(rows))


def _port_text(machine: Machine, switch: RecordedSwitch) -> str:
    found = switch.found
    if not found.told_apart:
        return f"not told apart: a delay of {in_units(machine, max(found.least, 0.0), 'time')} or more"
    return f"{_interval(machine, found.port, 'length')}, {_interval(machine, found.delay, 'time')}"


def _interval(machine: Machine, interval: Interval, kind: str) -> str:
    value, low, high = (in_units(machine, one, kind) for one in interval)
    return value if low == high else f"{value} ({low} to {high})"


def _readings_section(answer: RecordedAnswer) -> Section:
    rows = [("least delays", _reading(answer.read.by_ports)), ("longest", _reading(answer.read.by_delays))]
    rows.append(("of these", "each gives the recorded motion; with longer delays the machine would not run steadily"))
    return Section("The two extreme readings (rigid piston)", tuple(rows))


def _reading(reading: Reading) -> str:
    machine = reading.machine
    ports = []
    for port in machine.valve.ports:
        where = "at the blow" if port.behind is None else f"port at {in_units(machine, port.behind, 'length')}"
        ports.append(f"{port.to}: {where}, delay {in_units(machine, max(port.delay, 0.0), 'time')}")
    return f"{'; '.join(ports)}; {by_valve(reading.cycle)}"


def _verdicts_section(answer: RecordedAnswer) -> Section:
    rows = (
        ("under a clock", by_clock(answer)),
        ("with the valve", by_valve(answer.answer.cycle)),
        ("both", "have the phase, speed and energy of the recorded motion; a clock does not wait for a late blow"),
    )
    return Section("The two verdicts on the recorded motion", rows, GOOD if answer.runs else BAD)
