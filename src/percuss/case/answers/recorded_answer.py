"""What a recording says of a hammer: a force read as that of a valve, and a strain gauge's record over a blow."""

from __future__ import annotations

import math
import os
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
import numpy.typing as npt

from percuss.case.answers.blow_answer import BlowAnswer
from percuss.case.answers.facts import BAD, GOOD, Fact, Grid, Report, ReportSection, Teller, figures, plain_of, rows_of
from percuss.case.answers.machine_answer import MachineAnswer, cycle_in_short, machine_report
from percuss.case.answers.numerals import counted, json_number, number, numbers, percent, picked, quantity
from percuss.case.case import checked_case
from percuss.case.file_format.start_and_simulation import DEFAULT_MODES
from percuss.errors import HistoryError, ParameterError
from percuss.model.checks import Array, choice, count, finite, instance, positive
from percuss.shown import Shown
from percuss.simulate.stop import MAX_MODES
from percuss.stability import stability_of
from percuss.steady import ForceRecord, recorded_valve, self_excited_motion, steady_states
from percuss.steady.recorded.force_record import load_phases

if TYPE_CHECKING:
    from percuss.blow.gauges import RecordFit
    from percuss.case.case import Case
    from percuss.recordings import Recording
    from percuss.steady import Interval, Reading, RecordedSwitch, RecordedValve
    from percuss.steady.self_excited import ValveCycle


# ---- A recorded load read as a valve, and what of it is told: the reading, the verdict of a clock, the machine


@dataclass(frozen=True)
class ByClock(Shown):
    """What B77's clock says of the recorded motion: whether it exists, is stable, and its multiplier."""

    exists: bool
    stable: bool | None
    multiplier: complex | None


@dataclass(frozen=True)
class RecordedAnswer(Shown):
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
    """

    read: RecordedValve
    clock: ByClock
    answer: MachineAnswer
    warnings: tuple[str, ...] = ()

    @property
    def runs(self) -> bool:
        """Whether the machine of the best reading runs."""
        return self.answer.runs

    def to_json_dict(self) -> dict[str, Any]:
        """The answer in plain values, as `percuss machine --json` prints it for a recorded load.

        What was read is in m, s, m/s and N for a case in SI, else dimensionless.
        """
        read, scale = self.read, Teller.of(self.read.machine).scale
        return {
            **(whole := self.answer.to_json_dict()),
            "warnings": [*self.warnings, *whole["warnings"]],
            "clock": picked(self.clock, "exists stable multiplier"),
            "recorded": {
                **picked(read, "phase phases restitution opposing_share cycles"),
                "period": json_number(read.period * scale("time")),
                "speed": json_number(read.speed * scale("speed")),
                "stroke": json_number(read.stroke * scale("length")),
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
    return RecordedAnswer(read, _by_clock(read), answer, () if report is None else report.warnings)


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
    return f"{first}. Under a clock: {by_clock(answer)}; with the valve: {by_valve(answer.answer.cycle)}."


def by_clock(answer: RecordedAnswer) -> str:
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
    rows += [("warning", warning) for warning in answer.warnings]
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


# ---- A record of a strain gauge, as it lies over the computed force of a blow


@dataclass(frozen=True)
class MeasuredGauge(Shown):
    """A record of strain, stress or force at a gauge, laid over the computed force there.

    Attributes
    ----------
    file
        Where it was read.
    quantity
        "strain", "stress" or "force"; times E A, times A or as it is, it is the force at the gauge.
    sign
        1 where compression is positive in the record, −1 where it is negative.
    shift
        What is added to the record's time to make it that of the blow, s.
    zero
        What the record shows without a force, N in its own sign; it is taken off.
    scale
        The factor on the computed force that fits the record best; 1 where they agree.
    residual
        Root mean square of measured less computed force in the window, over the greatest computed force.
    residual_scaled
        The same with the factor.
    overlap
        Share of the blow's window that the record covers.
    time, force
        Shape (n,): the record on the clock of the blow, s, and N with compression positive.
    notes
        What was assumed, one sentence each.
    """

    file: str
    quantity: Literal["strain", "stress", "force"]
    sign: int
    shift: float
    zero: float
    scale: float
    residual: float
    residual_scaled: float
    overlap: float
    time: Array = field(repr=False)
    force: Array = field(repr=False)
    notes: tuple[str, ...] = ()

    @property
    def rows(self) -> tuple[tuple[str, str], ...]:
        """The lines of a report."""
        return (*rows_of(self, MEASURED, Teller(None, True)), *(("note", note) for note in self.notes))

    def to_json_dict(self) -> dict[str, Any]:
        """Its numbers in plain values, without the series."""
        return plain_of(self, MEASURED)


MEASURED: tuple[Fact[MeasuredGauge], ...] = (
    Fact("file", "record", "the record", "", "file",
         lambda one, _: f"{one.file}, {one.quantity}, compression {'positive' if one.sign > 0 else 'negative'}"),
    *figures("""
quantity | `"strain"`, `"stress"` or `"force"`
sign | 1 if compression is positive in the record, −1 if it is negative
"""),
    Fact("shift", "clock", "what is added to the record's time to make it that of the blow, in s", "", "shift",
         lambda one, _: f"{quantity(one.shift, 's', 5)} added to the time of the record"),
    Fact("zero", "zero", "what the record shows without a force, in N in its own sign; it is taken off", "", "zero",
         "{zero:force} taken off"),
    Fact("scale", "scale", "the factor on the computed force that fits the record best", "", "scale",
         "the record is {scale} times the computed force"),
    Fact("residual", "residual",
         "root mean square of measured less computed force in the window, over the greatest computed force", "",
         "residual", "{residual:percent} of the computed peak (rms); {residual_scaled:percent} after scaling"),
    Fact("residual_scaled", "", "the same with the factor `scale`", "", "residual_scaled"),
    Fact("overlap", "overlap", "share of the window that the record covers", "", "overlap",
         "the record covers {overlap:percent} of the window"),
    Fact("notes", "", "a list of texts: what was assumed", "", "notes"),
)  # fmt: skip
"""How a record fits a blow."""


_SIGNS = {"auto": None, "positive": 1, "negative": -1}
_FEW_SAMPLES = 10
"""Samples while a wave runs through the striker and back, below which the record says little of its shape."""
_PARTLY = 0.5
_UNLIKE = 0.15
"""Residual over the peak, after scaling, that is told of: a wrong place of the gauge gives more."""


def measured_gauge(
    answer: BlowAnswer,
    path: str | os.PathLike[str],
    *,
    column: str | int | None = None,
    unit: str | None = None,
    sample_rate: float | str | None = None,
    sign: Literal["auto", "positive", "negative"] = "auto",
) -> MeasuredGauge:
    """Lay a measured record over the computed force at the gauge of a blow.

    Parameters
    ----------
    answer
        What `blow_answer` gives, of a case in SI with a rod.
    path, column, unit, sample_rate
        As `percuss.recordings.read_recording` has them; strain, stress or force.
    sign
        How the record writes compression: "positive", "negative", or "auto" for the one that fits better.

    Raises
    ------
    HistoryError
        When the record cannot be read, is constant, or nothing in it resembles the computed force.
    ParameterError
        For a dimensionless case, for a wall, and where the area of the rod at the gauge is not known.

    Examples
    --------
    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> from percuss.case import blow_answer, load_case
    >>> answer = blow_answer(load_case("laboratory-striker"))
    >>> time = np.arange(0.0, answer.blow.until, 1e-6)
    >>> force = answer.waves.incident.at(time) + answer.waves.reflected.at(time)
    >>> with TemporaryDirectory() as folder:
    ...     file = Path(folder, "gauge.csv")
    ...     _ = file.write_text("t [s],force [N]\\n" + "".join(f"{t},{-1.02 * f}\\n" for t, f in zip(time, force)))
    ...     found = measured_gauge(answer, file)
    >>> found.sign, round(found.scale, 2)
    (-1, 1.02)
    """
    from percuss.blow.gauges import fitted_record
    from percuss.recordings import read_recording

    instance("answer", answer, BlowAnswer)
    choice("sign", sign, *_SIGNS)
    waves = answer.waves
    if waves is None:
        remedy = "the target is a wall: give the case a [tool]"
        raise ParameterError("measured", "a record", "a blow on a rod", remedy)
    if not answer.is_si:
        remedy = "describe the bar and the rod by their sizes, in [bar] and [tool]"
        raise ParameterError("measured", "a record", "a case in SI: the case is dimensionless", remedy)
    record = read_recording(path, column=column, unit=unit, sample_rate=sample_rate, sensor="gauge")
    force = record.values * _force_of_one(answer, record)
    try:
        fit = fitted_record(waves, answer.blow.until, record.time, force, sign=_SIGNS[sign])
    except ParameterError as error:
        raise HistoryError(f"expected {error.accepted}", error.remedy, str(record.path)) from None
    kind: Any = "stress" if record.quantity == "pressure" else record.quantity
    found = (fit.sign, fit.shift, fit.zero, fit.scale, fit.residual, fit.residual_scaled, fit.overlap)
    notes = (*record.notes, *_record_notes(answer, record, fit, sign == "auto"))
    series = record.time + fit.shift, fit.sign * (force - fit.zero)
    return MeasuredGauge(str(record.path), kind, *found, *series, notes)


def _force_of_one(answer: BlowAnswer, record: Recording) -> float:
    """The force in N, compression positive, that 1 in the record stands for."""
    if record.quantity == "force":
        return 1.0
    # the section of the rod under the gauge; of two that meet there, the later one, as for the waves
    place, pieces = answer.gauge, answer.pieces[1]
    piece = next((p for p in pieces if place is not None and place < p.end), pieces[-1] if pieces else None)
    if piece is None:
        remedy = "give the rod sections with area and youngs_modulus in [tool], or a record of force"
        raise ParameterError("measured", record.quantity, "a rod whose area at the gauge is known", remedy)
    return piece.area * (piece.youngs_modulus if record.quantity == "strain" else 1.0)  # N = E A ε


def _record_notes(answer: BlowAnswer, record: Recording, fit: RecordFit, chosen: bool) -> list[str]:
    from percuss.blow.bodies import striker_sections

    found = []
    if chosen:
        which = "positive" if fit.sign > 0 else "negative"
        found.append(f"compression is taken as {which} in the record, which fits better")
    there_and_back = 2.0 * float(striker_sections(answer.blow.striker).transit.sum())
    seen = there_and_back / float(np.median(np.diff(record.time)))
    if seen < _FEW_SAMPLES:
        found.append(f"only {number(seen, 2)} samples while a wave runs through the striker and back: sample faster")
    if fit.overlap < _PARTLY:
        found.append(f"the record covers only {percent(fit.overlap)} of the window: compare with a shorter --until")
    if fit.residual_scaled > _UNLIKE:
        found.append("the shapes differ: check the place of the gauge, the sections and the window")
    return found
