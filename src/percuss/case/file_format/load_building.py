"""From the table [load] of a case to a load, except recordings.

Whatever is refused is a `ParameterError` by the key of the table; of a recording a `CaseError`.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from percuss.case.file_format.load_tables import (
    AnyLoad,
    AreasTable,
    FourierLoad,
    HarmonicLoad,
    HistoryLoad,
    SquareLoad,
    StepsLoad,
    SupplyTable,
    ValveLoad,
)
from percuss.case.file_format.reading import from_parameter
from percuss.case.file_format.values import above_zero, given_in, keyed, number_of
from percuss.errors import CaseError, HistoryError, ParameterError, did_you_mean
from percuss.model import Chamber, Cushion, Load, Port, Supply, Valve
from percuss.units import si

if TYPE_CHECKING:
    from percuss.model.checks import Array
    from percuss.recordings.history import HistoryReport
    from percuss.recordings.recording import Recording


# ---- A load from a recorded history that a case names, with every refusal translated to its key


class ReadHistory(NamedTuple):
    """The load of a recorded history, what was assumed in reading it, and its samples: times (s) and the force."""

    load: Load
    notes: tuple[str, ...]
    time: Array
    force: Array


def history_load(table: HistoryLoad, file: str, folder: Path) -> ReadHistory:
    """The load of a recorded history.

    Its file is looked for in `folder`, that of the case file.
    """
    try:
        recording, force = _recorded(table, file, folder)
        frequency = None if table.frequency is None else above_zero("frequency", table.frequency, "frequency")
        load = Load.history(recording.time, force, frequency=frequency, harmonics=table.harmonics)
        if (counted := getattr(table, "force_scale", None)) is not None:  # of the dimensionless form
            load = load.scaled(1.0 / above_zero("force_scale", counted, "force"))
        if recording.opposing is not None:  # a limit of one channel hides in the difference of both
            load = replace(load, report=_with_clipping(load.report, table, recording))
        return ReadHistory(load.acting_at(table.at), recording.notes, recording.time, force)
    except (ParameterError, HistoryError, OSError, ValueError) as error:
        raise _refused(error, table, file) from error


def _with_clipping(report: HistoryReport | None, table: HistoryLoad, recording: Recording) -> HistoryReport | None:
    """The report, with what is to say of either channel by itself."""
    from percuss.recordings.history import clipped_share, clipping

    if report is None or recording.opposing is None:
        return report
    first = "the first channel" if table.column is None else f"column {table.column}"
    channels = ((first, recording.values), (f"column {table.opposing_column}", recording.opposing))
    said = [text for name, values in channels for text in clipping(clipped_share(values), f" of {name}")]
    return replace(report, warnings=(*report.warnings, *said))


def _refused(error: Exception, table: HistoryLoad, file: str) -> CaseError:
    """The refusal of a recording, with its key."""
    if isinstance(error, CaseError):
        return error
    if isinstance(error, ParameterError):
        return from_parameter(error, file, "load", table.model_dump(by_alias=True))
    if isinstance(error, HistoryError):
        return CaseError(file, "load.file", table.file, error.message, error.remedy)
    return CaseError(file, "load.file", table.file, f"cannot be read: {error}")  # as a path with a null character


def _recorded(table: HistoryLoad, file: str, folder: Path) -> tuple[Recording, Array]:
    """The recording that a case names, and the force on the bar."""
    from percuss.recordings.recording import read_recording  # only histories need it

    path = folder / table.file
    if not path.exists():
        raise CaseError(file, "load.file", table.file, f"no such file as {path}", _other_recordings(path))
    if path.is_dir():
        raise CaseError(file, "load.file", table.file, f"{path} is a directory", _other_recordings(path / "x"))
    rate = None if table.sample_rate is None else above_zero("sample_rate", table.sample_rate, "frequency")
    recording = read_recording(
        path,
        column=table.column,
        unit=table.unit,
        time_column=table.time_column,
        sample_rate=rate,
        opposing_column=table.opposing_column,
        start=table.start,
        end=table.end,
    )
    return recording, _recorded_force(table, recording, file)


def _recorded_force(table: HistoryLoad, recording: Recording, file: str) -> Array:
    """The force on the bar: of the one face, less that of the opposing one."""
    force = recording.values * _area(table.area, "area", recording.quantity, file)
    if recording.opposing is not None:
        return force - recording.opposing * _area(table.opposing_area, "opposing_area", recording.quantity, file)
    if table.opposing_area is not None:
        remedy = "name the column of the pressure that acts on it: opposing_column"
        raise CaseError(file, "load.opposing_area", table.opposing_area, "there is no opposing pressure", remedy)
    return force


def _area(given: str | None, name: str, quantity: str, file: str) -> float:
    """In m² for a pressure; 1 for a force, which takes none."""
    if quantity == "pressure":
        if given is None:
            remedy = f'give it as {name} = "6.5 cm^2"; or name another column or unit when the values are forces'
            raise CaseError(file, f"load.{name}", None, "a recorded pressure needs the area that it acts on", remedy)
        return above_zero(name, given, "area")
    if given is not None:
        remedy = f"leave {name} out, or name the column or unit of a pressure"
        raise CaseError(file, f"load.{name}", given, "the recorded values are forces, which need no area", remedy)
    return 1.0


def _other_recordings(path: Path) -> str:
    """A remedy that names the recordings lying where one was looked for."""
    try:
        names = [entry.name for entry in path.parent.iterdir() if entry.suffix.lower() != ".toml"]
    except OSError:
        return "the path is taken from the folder of the case file"
    return did_you_mean(path.name, names) or "the path is taken from the folder of the case file"


# ---- From the table [load] of a case to a load, except recordings

_MOST_STEPS = 1000
"""Steps of a load; each of the thousands of harmonics is a sum over them."""


def load_of(table: AnyLoad) -> Load:
    """The load that a formula describes: in N with its frequency, or dimensionless."""
    hertz, square_metres = getattr(table, "frequency", None), getattr(table, "area", None)
    frequency = None if hertz is None else above_zero("frequency", hertz, "frequency")
    area = None if square_metres is None else above_zero("area", square_metres, "area")

    def number(value: float | str, name: str) -> float:
        if not isinstance(value, str):
            return value
        if area is not None:
            return si(value, "pressure", name) * area
        with keyed(remedies={name: 'a pressure also needs the area that it acts on: area = "6.5 cm^2"'}):
            return si(value, "force", name)

    given = getattr(table, "unit", None)
    unit = 1.0 if given is None else number(f"1 {given}", "unit")
    if isinstance(table, HarmonicLoad):
        mean, amplitude = number(table.mean, "mean"), number(table.amplitude, "amplitude")
        load = Load.harmonic(mean, amplitude, table.harmonic, frequency=frequency)
    elif isinstance(table, SquareLoad):
        load = Load.square(number(table.amplitude, "amplitude"), table.kappa, table.harmonics, frequency=frequency)
    elif isinstance(table, StepsLoad):
        if len(table.breaks) > _MOST_STEPS:
            raise ParameterError("breaks", f"{len(table.breaks)} phases", f"at most {_MOST_STEPS}")
        load = Load.steps(table.breaks, [unit * p for p in table.values], table.harmonics, frequency=frequency)
    else:
        assert isinstance(table, FourierLoad)
        load = Load.fourier([unit * complex(re, im) for re, im in table.coefficients], frequency=frequency)
    return load.acting_at(table.at)


# ---- From the table [load] of a machine that switches itself to its valve

_PRESSURE = "give pressure, that of the supply, or the forces of the states"
_BEHIND = "the wall is at 0, and the distance is counted away from it"
_BEYOND = "one that began behind the wall would take part of every blow, which is not in the model"


def valve_of(table: ValveLoad) -> Valve:
    """The valve that a table describes: in N, m and s, or dimensionless; what else the table says is checked, too."""
    pressure, room = pressure_of(table), room_of(table)
    states = {name: _state_force(name, given, pressure) for name, given in table.states.items()}
    ports = []
    for i, own in enumerate(table.ports):
        with keyed(f"ports[{i}].", remedies={"behind": _BEHIND}):
            ports.append(Port(**given_in(own)))
        if room is not None and (ports[i].behind or 0.0) >= room:
            accepted = f"a port within the room, {table.room}"
            raise ParameterError(f"ports[{i}].behind", own.behind, accepted, "the piston cannot reach it")
    with keyed("chamber."):
        chamber = Chamber() if table.chamber is None else Chamber(**given_in(table.chamber))
    with keyed("cushion.", remedies={"beyond": _BEYOND}):
        cushion = None if table.cushion is None else Cushion(**given_in(table.cushion))
    supply = None if table.supply is None else _supply(table, table.supply, pressure)
    try:
        return Valve(states, tuple(ports), table.start_state, chamber, cushion, supply)
    except ParameterError as error:
        name = {"start": "start_state"}.get(error.name, error.name).replace("']", "").replace("['", ".")
        near = did_you_mean(error.value, table.states) if name.endswith((".to", "start_state")) else ""
        raise ParameterError(name, error.value, error.accepted, near or error.remedy) from None


def pressure_of(table: ValveLoad) -> float | None:
    """The pressure of the supply in Pa, or None."""
    return None if table.pressure is None else above_zero("pressure", table.pressure, "pressure")


def room_of(table: ValveLoad) -> float | None:
    """How far behind the wall the piston can go: in m, or dimensionless; None without a limit."""
    return None if table.room is None else above_zero("room", table.room, "length")


def _state_force(name: str, given: str | AreasTable, pressure: float | None) -> float:
    key = f"states.{name}"
    if not isinstance(given, AreasTable):
        return number_of(key, given, "force")
    if pressure is None:
        raise ParameterError(key, None, "a force, as there is no pressure for the areas", _PRESSURE)
    areas: dict[str, float] = given_in(given, f"{key}.")
    for side, area in areas.items():
        if area < 0.0:
            raise ParameterError(f"{key}.{side}", getattr(given, side), "an area, 0 or greater")
    return pressure * (areas.get("rear", 0.0) - areas.get("front", 0.0))


def _supply(table: ValveLoad, own: SupplyTable, pressure: float | None) -> Supply:
    flow = above_zero("supply.flow", own.flow, "flow")
    accumulator = above_zero("supply.accumulator", own.accumulator, "compliance")
    start = None if own.start is None else number_of("supply.start", own.start, "pressure")
    if start is not None and start < 0.0:
        raise ParameterError("supply.start", own.start, "a pressure, 0 or greater")
    if table.is_plain:
        return Supply(flow, accumulator, 1.0 if start is None else start)
    for name, state in table.states.items():
        if not isinstance(state, AreasTable):
            remedy = "a piston displaces oil by the areas on which its pressure acts"
            raise ParameterError(f"states.{name}", state, "areas, {front = …, rear = …}, beside a supply", remedy)
    if pressure is None:
        raise ParameterError("pressure", None, "the pressure for which the states hold, beside a supply", _PRESSURE)
    return Supply.of_oil(flow, accumulator, pressure, start)
