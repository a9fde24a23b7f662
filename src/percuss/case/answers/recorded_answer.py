"""What a recording says of a hammer: a force read as that of a valve, and a strain gauge's record over a blow."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from percuss.case.answers.facts import (
    BAD,
    GOOD,
    Grid,
    Report,
    ReportSection,
    Teller,
    counted,
    json_number,
    number,
    numbers,
    percent,
    picked,
    quantity,
    settles,
)
from percuss.case.answers.machine_answer import MachineAnswer, cycle_in_short, machine_report
from percuss.case.case import checked_case
from percuss.case.file_format.loads import HistoryLoad, recorded_passages
from percuss.model.checks import DEFAULT_MODES, count, finite, positive
from percuss.short_repr import ShortRepr
from percuss.simulate.stop import MAX_MODES
from percuss.stability import stability_of
from percuss.steady import ForceRecord, recorded_valve, self_excited_motion, steady_states
from percuss.steady.recorded.force_record import MeasuredForce, load_phases, measured_load

if TYPE_CHECKING:
    from percuss.case.case import Case
    from percuss.steady import Interval, Reading, RecordedSwitch, RecordedValve
    from percuss.steady.self_excited.valve_cycle import ValveCycle


# ---- A recorded load read as a valve, and what of it is told: the reading, the verdict of a clock, the machine


_OFF, _SHIFTED = 0.01, 0.2  # of rate and stroke, and of the mean force: a reading farther from the record is none


@dataclass(frozen=True)
class ByClock(ShortRepr):
    """What B77's clock says of the recorded motion: whether it exists, is stable, and its multiplier."""

    exists: bool
    stable: bool | None
    multiplier: complex | None


@dataclass(frozen=True)
class PassageShare(ShortRepr):
    """What a passage takes between the place where a pressure was recorded and the face that it acts on.

    Attributes
    ----------
    name
        "passage", or "opposing_passage".
    force_share
        Mean force that it takes over the mean of what was recorded, sign left out.
    drop, at
        The greatest drop of the pressure, Pa, at the greatest flow, m³/s.
    energy
        What it takes in a cycle, J.
    energy_share
        The same over the energy of the blow.
    """

    name: str
    force_share: float
    drop: float
    at: float
    energy: float
    energy_share: float


@dataclass(frozen=True)
class RecordedAnswer(ShortRepr):
    """A recorded load read as a valve.

    Attributes
    ----------
    read
        The switches, ports and delays.
    clock
        The verdict on the recorded motion for a load that keeps time by itself.
    answer
        How the machine of the best reading runs.
    warnings
        What was found wrong with the recording, one sentence each, as `percuss steady` has it.
    record
        The record; None of a load of steps.
    passages
        What the passages of the case take, by the motion of the machine that was read; none without a cycle.
    """

    read: RecordedValve
    clock: ByClock
    answer: MachineAnswer
    warnings: tuple[str, ...] = ()
    record: ForceRecord | None = None
    passages: tuple[PassageShare, ...] = ()

    @cached_property
    def measured(self) -> MeasuredForce | None:
        """The record beside the force on the machine that was read, in its units, each cycle from its blow on."""
        if self.record is None or self.answer.cycle is None:
            return None
        load, course = measured_load(self.read.system, self.record), self.answer.course
        turns = load.turns - self.read.phase / (2.0 * math.pi)
        model = np.interp((turns % 1.0) * self.answer.cycle.period, course.times, course.force)
        return MeasuredForce(turns, (2.0 * math.pi / self.read.period) ** 2 * load.measured, model)

    @property
    def runs(self) -> bool:
        """Whether the machine of the best reading runs."""
        return self.answer.runs

    @property
    def off(self) -> dict[str, float]:
        """By how much rate and stroke of the machine are off the record; nothing of one that does not run."""
        cycle = self.answer.cycle
        if cycle is None or not self.runs:
            return {}
        return {"rate": self.read.period / cycle.period - 1.0, "stroke": cycle.stroke / self.read.stroke - 1.0}

    @property
    def doubts(self) -> tuple[str, ...]:
        """Why the reading is not to be trusted, one sentence each: it misses the record, or has impossible figures."""
        read = self.read
        found = [
            f"{name} of the machine {percent(abs(off))} {'above' if off > 0.0 else 'below'} the record"
            for name, off in self.off.items()
            if abs(off) > _OFF
        ]
        if read.restitution is not None and not 0.0 <= read.restitution.value <= 1.0:
            found.append(f"the measured blows ask for R = {number(read.restitution.value, 3)}, which no contact has")
        if abs(read.mean_change) > _SHIFTED:
            found.append(
                f"the motion asks for a mean force {percent(abs(read.mean_change))} "
                f"{'below' if read.mean_change > 0.0 else 'above'} the recorded one: check areas and zeros"
            )
        if read.stiffness.value * read.stroke > max(map(abs, read.forces)):
            found.append("the gas would grow by more over a stroke than the greatest force of the valve: no gas does")
        return tuple(found)

    def to_json_dict(self) -> dict[str, Any]:
        """The answer in plain values, as `percuss machine --json` prints it for a recorded load.

        What was read is in m, s, m/s and N for a case in SI, else dimensionless.
        """
        read, scale = self.read, Teller.of(self.read.machine).scale
        return {
            **(whole := self.answer.to_json_dict()),
            "warnings": [*self.doubts, *self.warnings, *whole["warnings"]],
            "clock": picked(self.clock, "exists stable multiplier"),
            "recorded": {
                **picked(read, "phase phases restitution opposing_share cycles"),
                "period": json_number(read.period * scale("time")),
                "speed": json_number(read.speed * scale("speed")),
                "stroke": json_number(read.stroke * scale("length")),
                "rate_off": json_number(self.off.get("rate")),
                "stroke_off": json_number(self.off.get("stroke")),
                "force_off": None if self.measured is None else json_number(self.measured.off),
                "passages": [picked(one, "name force_share drop at energy energy_share") for one in self.passages],
                "mean_change": json_number(read.mean_change),
                "stiffness": numbers(k * scale("force") / scale("length") for k in read.stiffness),
                "switches": [_switch(switch, scale) for switch in read.switches],
                "least_delays": _reading_dict(read.by_ports, scale),
                "longest_delays": _reading_dict(read.by_delays, scale),
            },
        }


def _switch(switch: RecordedSwitch, scale: Callable[[str], float]) -> dict[str, Any]:
    intervals = {
        "time": (switch.time, "time"), "behind": (switch.behind, "length"), "velocity": (switch.velocity, "speed"),
        "port": (switch.found.port, "length"), "delay": (switch.found.delay, "time"),
    }  # fmt: skip
    return {
        **picked(switch, "to side by_blow"),
        "told_apart": bool(switch.found.told_apart),
        **{name: numbers(x * scale(dimension) for x in values) for name, (values, dimension) in intervals.items()},
    }


def _reading_dict(reading: Reading, scale: Callable[[str], float]) -> dict[str, Any]:
    """One of the extreme readings: its ports, and whether and how it runs."""
    ports = [
        {
            **picked(port, "to side on"),
            "behind": None if port.behind is None else json_number(port.behind * scale("length")),
            "delay": json_number(port.delay * scale("time")),
        }
        for port in reading.machine.valve.ports
    ]
    multiplier = None if reading.cycle is None else json_number(abs(reading.cycle.multiplier))
    return {"ports": ports, "runs": bool(reading.runs), "multiplier": multiplier}


# ---- The dispatcher's answer for a recorded load: the machine that may have made it, beside the verdict under a clock

_SAME = 0.3  # rad: a root farther from the recorded blow is another motion


def recorded_answer(
    case: Case,
    modes: int | None = None,
    *,
    blow: float | None = None,
    blows: npt.ArrayLike | None = None,
    longest_delay: float | None = None,
) -> RecordedAnswer:
    """Read the load of a case, a recording or steps, as that of a machine whose valve the piston works.

    Parameters
    ----------
    modes
        Elastic modes of the machine's cycle; 32 by default, 0 for a rigid piston.
    blow
        A time (s, on the clock of the recording) at which the piston struck. Of the motions that the load allows, the
        one that strikes nearest is taken; by default the one that strikes nearest to the fall of the force.
    blows
        The times of all blows (s), where they were measured: then every cycle is read by itself, and the restitution
        with it.
    longest_delay
        The longest delay that the valve may have: s, or dimensionless with the case.

    Raises
    ------
    CaseError
        When the recording cannot be read or used, or the piston itself switches the load.
    LoadError
        When the load does not push, or does not switch.

    Examples
    --------
    >>> from percuss.case import Case
    >>> case = Case.from_text('''
    ... [system]
    ... s = 50.0
    ... d = 0.0
    ... restitution = 0.2
    ... [load]
    ... kind = "square"
    ... amplitude = 1.0
    ... kappa = 1.2
    ... ''')
    >>> answer = recorded_answer(case, modes=0)
    >>> answer.clock.exists, [switch.to for switch in answer.read.switches]
    (False, ['power', 'return'])
    """
    checked_case(case)
    kept = DEFAULT_MODES if modes is None else count("modes", modes, least=0, most=MAX_MODES)
    longest = None if longest_delay is None else positive("longest_delay", longest_delay)
    system, samples = case.system(), case.recorded_force
    record, phase = None, None
    if samples is not None:
        record = ForceRecord(*samples, blows)
        if blow is not None:
            place = np.interp(finite("blow", blow), record.time, load_phases(system, record))
            phase = float(place % (2.0 * math.pi))
    elif blow is not None:
        phase = finite("blow", blow) * (system.angular_frequency if system.is_si else 1.0)
    read = recorded_valve(system, blow=phase, record=record, longest_delay=longest)
    motion = self_excited_motion(read.machine, modes=kept)
    rigid = motion if kept == 0 else self_excited_motion(read.machine, modes=0)
    notes = (note for note in case.notes if "as a valve does" not in note)  # which is what a clock would say
    answer = MachineAnswer(case.file, case.title, motion, rigid, (*notes, *read.notes))
    report = case.history_report
    warnings = () if report is None else report.warnings
    return RecordedAnswer(read, _by_clock(read), answer, warnings, record, _passages(case, answer))


def _passages(case: Case, answer: MachineAnswer) -> tuple[PassageShare, ...]:
    """ζ (A v)² of the oil that the piston draws through a passage, by the motion of its striking end."""
    machine, cycle, table, found = answer.machine, answer.cycle, case.load_table, list[PassageShare]()
    if cycle is None or not machine.is_si or not isinstance(table, HistoryLoad):
        return ()
    course, scale = answer.course, Teller.of(machine).scale
    spans = np.diff(course.times) * scale("time")
    inside = spans > 0.0
    spans, way = spans[inside], np.diff(course.centre)[inside] * scale("length")
    force = np.abs(0.5 * (course.force[1:] + course.force[:-1])[inside]) * scale("force")
    for name, area, sign, ways in recorded_passages(table):
        flow = sign * area * way / spans
        drop = np.where(flow > 0.0, *ways) * flow**2
        energy = float(drop * np.abs(flow) @ spans)
        share = area * float(drop @ spans) / float(force @ spans)
        most = int(np.argmax(drop))
        blow = cycle.blow_energy * scale("energy")
        found.append(PassageShare(name, share, float(drop[most]), float(abs(flow[most])), energy, energy / blow))
    return tuple(found)


def _by_clock(read: RecordedValve) -> ByClock:
    orbits = [
        orbit
        for orbit in steady_states(read.system).orbits
        if abs(math.remainder(orbit.phase - read.phase, 2.0 * math.pi)) < _SAME
    ]
    if not orbits:
        return ByClock(False, None, None)
    orbit = min(orbits, key=lambda one: abs(math.remainder(one.phase - read.phase, 2.0 * math.pi)))
    judged = stability_of(orbit)
    values = judged.multipliers.values[list(judged.multipliers.rigid)]
    return ByClock(orbit.admissible, judged.stable, complex(values[np.argmax(np.abs(values))]))


# ---- The first sentences on a recorded load read as a valve: the verdict under a clock, and with the valve


def recorded_headline(answer: RecordedAnswer) -> str:
    """How the machine runs, and how the two verdicts on the same motion differ."""
    cycle = answer.answer.cycle
    first = "Read as a machine whose valve the piston works, the record's machine "
    if cycle is not None and answer.runs:
        first += f"runs: {cycle_in_short(answer.answer.machine, cycle)}"
    else:
        obstacle = answer.answer.motion.obstacle
        first += f"does not run with one blow a cycle{'' if obstacle is None else f' — {obstacle.words}'}"
    doubts = "".join(f" Do not trust it: {doubt}." for doubt in answer.doubts)
    settled = f", and {settles(abs(cycle.multiplier))}" if cycle is not None and cycle.stable else ""
    valve = "no cycle" if cycle is None else f"{'stable' if cycle.stable else 'unstable'}{settled}"
    return f"{first}.{doubts} Under a clock: {by_clock(answer).partition(', ')[0]}; with the valve: {valve}."


def by_clock(answer: RecordedAnswer) -> str:
    """``unstable (flip), multiplier −8.6`` of the recorded motion under a load that keeps time by itself."""
    clock = answer.clock
    if not clock.exists or clock.multiplier is None:
        return "no steady motion with the blow where it is"
    z = clock.multiplier
    turning = abs(z.imag) > 1e-9 * abs(z)
    size = f"a pair of multipliers of modulus {number(abs(z), 3)}" if turning else f"multiplier {number(z.real, 3)}"
    if abs(z) < 1.0:
        return f"{'stable' if clock.stable else 'unstable by its ringing'}, {size}"
    kind = "turning" if turning else "flip" if z.real < 0.0 else "beyond the fold"
    return f"unstable ({kind}), {size}"


def by_valve(cycle: ValveCycle | None) -> str:
    """``stable, multiplier 0.028`` of the machine that was read."""
    if cycle is None:
        return "no cycle"
    size = number(abs(cycle.multiplier), 3)
    return f"{'stable' if cycle.stable else 'unstable'}, greatest multiplier {size}"


# ---- A recorded load read as a valve, as the report that a person reads


def recorded_report(answer: RecordedAnswer) -> Report:
    """The report of `percuss machine` for a recorded load: what was read, then the machine's own."""
    whole = machine_report(answer.answer)
    readings = (
        ("least delays", _reading(answer.read.by_ports)),
        ("longest", _reading(answer.read.by_delays)),
        ("of these", "each gives the recorded motion; with longer delays the machine would not run steadily"),
    )
    verdicts = (
        ("under a clock", by_clock(answer)),
        ("with the valve", by_valve(answer.answer.cycle)),
        ("both", "have the phase, speed and energy of the recorded motion; a clock does not wait for a late blow"),
    )
    mark = GOOD if answer.runs else BAD
    sections = (
        _read_section(answer),
        _switches_grid(answer),
        ReportSection("The two extreme readings (rigid piston)", readings),
        ReportSection("The two verdicts on the recorded motion", verdicts, mark),
        *whole.sections,
    )
    return Report(answer.answer.title, recorded_headline(answer), mark, sections)


def _read_section(answer: RecordedAnswer) -> ReportSection:
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
            f"{percent(read.opposing_share)} of the highest force, constant: an estimate, with which the blow comes as"
        )
        text += " the force falls. If the front chamber is always under supply, it is the ratio of its area to the rear"
        rows.append(("opposing force", f"{text} one"))
    for one in answer.passages:
        drop = f"up to {number(one.drop / 1e5, 3)} bar at {number(6e4 * one.at, 3)} l/min"
        told = f"takes {percent(one.force_share)} of the force in the mean, {drop}"
        told += f", and {quantity(one.energy, 'J', 3)} a blow, {percent(one.energy_share)} of its energy"
        rows.append((one.name.replace("_", " "), told))
    for name, off in answer.off.items():
        rows.append((f"{name} of the machine", f"{'+' if off >= 0.0 else '−'}{percent(abs(off), 2)} beside the record"))
    if answer.measured is not None:
        rows.append(("force of the machine", f"off the recorded one by {percent(answer.measured.off)} of its rms"))
    rows += [("warning", warning) for warning in (*answer.doubts, *answer.warnings)]
    rows += [("note", note) for note in read.notes]
    return ReportSection("From the record", tuple(rows))


def _switches_grid(answer: RecordedAnswer) -> Grid:
    tell = Teller.of(answer.read.machine)

    def interval(values: Interval, kind: str) -> str:
        value, low, high = (tell(one, kind) for one in values)
        return value if low == high else f"{value} ({low} to {high})"

    rows = []
    for switch in answer.read.switches:
        found, time = switch.found, switch.time.value
        when = f"{tell(abs(time), 'time')} {'before' if time < 0.0 else 'after'} the blow"
        port = f"{interval(found.port, 'length')}, {interval(found.delay, 'time')}"
        if not found.told_apart:
            port = f"not told apart: a delay of {tell(max(found.least, 0.0), 'time')} or more"
        rows.append((switch.to, when, interval(switch.behind, "length"), tell(-switch.velocity.value, "speed"), port))
    columns = ("switch to", "time", "behind the wall", "speed toward it", "port and delay")
    return Grid("Switches of the force", columns, tuple(rows))


def _reading(reading: Reading) -> str:
    tell, ports = Teller.of(reading.machine), []
    for port in reading.machine.valve.ports:
        where = "at the blow" if port.behind is None else f"port at {tell(port.behind, 'length')}"
        ports.append(f"{port.to}: {where}, delay {tell(max(port.delay, 0.0), 'time')}")
    return f"{'; '.join(ports)}; {by_valve(reading.cycle)}"
