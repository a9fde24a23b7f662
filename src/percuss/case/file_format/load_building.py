"""From the table [load] of a case to a load, except recordings.

Whatever is refused is a `ParameterError` by the key of the table; of a recording a `CaseError`.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from percuss.case.file_format.load_tables import (
    AnyLoad,
    AreasTable,
    ChamberTable,
    CushionTable,
    FourierForce,
    FourierLoad,
    HarmonicForce,
    HarmonicLoad,
    HistoryForce,
    HistoryLoad,
    PlainChamber,
    PlainCushion,
    PlainPort,
    PlainSupply,
    PortTable,
    SquareForce,
    SquareLoad,
    StepsForce,
    StepsLoad,
    SupplyTable,
    ValveForce,
    ValveLoad,
)
from percuss.case.file_format.reading import from_parameter
from percuss.errors import CaseError, HistoryError, ParameterError, did_you_mean
from percuss.model import Chamber, Cushion, Load, Port, Supply, Valve
from percuss.model.checks import non_negative, positive
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


def positive_frequency(text: str, name: str) -> float:
    """The frequency in Hz, greater than 0."""
    frequency = si(text, "frequency", name)
    if not frequency > 0.0:
        raise ParameterError(name, text, "a frequency greater than 0")
    return frequency


def positive_area(text: str, name: str = "area") -> float:
    """The area in m², greater than 0."""
    area = si(text, "area", name)
    if not area > 0.0:
        raise ParameterError(name, text, "an area greater than 0")
    return area


def history_load(table: HistoryForce, file: str, folder: Path) -> ReadHistory:
    """The load of a recorded history.

    Its file is looked for in `folder`, that of the case file.
    """
    try:
        recording, force = _recorded(table, file, folder)
        frequency = None if table.frequency is None else positive_frequency(table.frequency, "frequency")
        load = Load.history(recording.time, force, frequency=frequency, harmonics=table.harmonics)
        if isinstance(table, HistoryLoad):
            scale = si(table.force_scale, "force", "force_scale")
            if not scale > 0.0:
                raise ParameterError("force_scale", table.force_scale, "a force greater than 0")
            load = load.scaled(1.0 / scale)
        if recording.opposing is not None:  # a limit of one channel hides in the difference of both
            load = replace(load, report=_with_clipping(load.report, table, recording))
        return ReadHistory(load.acting_at(table.at), recording.notes, recording.time, force)
    except (ParameterError, HistoryError, OSError, ValueError) as error:
        raise _refused(error, table, file) from error


def _with_clipping(report: HistoryReport | None, table: HistoryForce, recording: Recording) -> HistoryReport | None:
    """The report, with what is to say of either channel by itself."""
    from percuss.recordings.history import clipped_share, clipping

    if report is None or recording.opposing is None:
        return report
    first = "the first channel" if table.column is None else f"column {table.column}"
    channels = ((first, recording.values), (f"column {table.opposing_column}", recording.opposing))
    said = [text for name, values in channels for text in clipping(clipped_share(values), f" of {name}")]
    return replace(report, warnings=(*report.warnings, *said))


def _refused(error: Exception, table: HistoryForce, file: str) -> CaseError:
    """The refusal of a recording, with its key."""
    if isinstance(error, CaseError):
        return error
    if isinstance(error, ParameterError):
        return from_parameter(error, file, "load", table.model_dump(by_alias=True))
    if isinstance(error, HistoryError):
        return CaseError(file, "load.file", table.file, error.message, error.remedy)
    return CaseError(file, "load.file", table.file, f"cannot be read: {error}")  # as a path with a null character


def _recorded(table: HistoryForce, file: str, folder: Path) -> tuple[Recording, Array]:
    """The recording that a case names, and the force on the bar."""
    from percuss.recordings.recording import read_recording  # only histories need it

    path = folder / table.file
    if not path.exists():
        raise CaseError(file, "load.file", table.file, f"no such file as {path}", _other_recordings(path))
    if path.is_dir():
        raise CaseError(file, "load.file", table.file, f"{path} is a directory", _other_recordings(path / "x"))
    rate = None if table.sample_rate is None else positive_frequency(table.sample_rate, "sample_rate")
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


def _recorded_force(table: HistoryForce, recording: Recording, file: str) -> Array:
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
        return positive_area(given, name)
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

_Formula = HarmonicForce | SquareForce | StepsForce | FourierForce


def load_of(table: AnyLoad) -> Load:
    """The load that a formula describes: in N with its frequency, or dimensionless."""
    return _formula(table).acting_at(table.at)


def _formula(table: AnyLoad) -> Load:
    if isinstance(table, StepsForce | StepsLoad) and len(table.breaks) > _MOST_STEPS:
        raise ParameterError("breaks", f"{len(table.breaks)} phases", f"at most {_MOST_STEPS}")
    if isinstance(table, _Formula):
        return _force(table)
    if isinstance(table, HarmonicLoad):
        return Load.harmonic(table.mean, table.amplitude, table.harmonic)
    if isinstance(table, SquareLoad):
        return Load.square(table.amplitude, table.kappa, table.harmonics)
    if isinstance(table, StepsLoad):
        return Load.steps(table.breaks, table.values, table.harmonics)
    assert isinstance(table, FourierLoad)
    return Load.fourier(_complex(table.coefficients))


def _force(table: _Formula) -> Load:
    frequency = positive_frequency(table.frequency, "frequency")
    area = None if table.area is None else positive_area(table.area)

    def newtons(text: str, name: str) -> float:
        if area is not None:
            return si(text, "pressure", name) * area
        try:
            return si(text, "force", name)
        except ParameterError as error:
            remedy = 'a pressure also needs the area that it acts on: area = "6.5 cm^2"'
            raise ParameterError(name, text, error.accepted, remedy) from None

    if isinstance(table, HarmonicForce):
        mean, amplitude = newtons(table.mean, "mean"), newtons(table.amplitude, "amplitude")
        return Load.harmonic(mean, amplitude, table.harmonic, frequency=frequency)
    if isinstance(table, SquareForce):
        amplitude = newtons(table.amplitude, "amplitude")
        return Load.square(amplitude, table.kappa, table.harmonics, frequency=frequency)
    unit = newtons(f"1 {table.unit}", "unit")
    if isinstance(table, StepsForce):
        return Load.steps(table.breaks, [unit * p for p in table.values], table.harmonics, frequency=frequency)
    return Load.fourier([unit * p for p in _complex(table.coefficients)], frequency=frequency)


def _complex(pairs: tuple[tuple[float, float], ...]) -> list[complex]:
    return [complex(re, im) for re, im in pairs]


# ---- From the table [load] of a machine that switches itself to its valve

_PRESSURE = "give pressure, that of the supply, or the forces of the states"


def valve_of(table: ValveForce | ValveLoad) -> Valve:
    """The valve that a table describes: in N, m and s, or dimensionless; what else the table says is checked, too."""
    pressure = pressure_of(table)
    room = room_of(table)
    states = {name: _state_force(name, given, pressure) for name, given in table.states.items()}
    given: tuple[PortTable | PlainPort, ...] = table.ports
    ports = tuple(_port(f"ports[{i}].", port) for i, port in enumerate(given))
    for i, (port, own) in enumerate(zip(ports, given, strict=True)):
        if port.behind is not None and room is not None and port.behind >= room:
            accepted = f"a port within the room, {table.room}"
            raise ParameterError(f"ports[{i}].behind", own.behind, accepted, "the piston cannot reach it")
    try:
        chamber, cushion = _chamber(table.chamber), _cushion(table.cushion)
        return Valve(states, ports, table.start_state, chamber, cushion, _supply(table, pressure))
    except ParameterError as error:
        name = {"start": "start_state"}.get(error.name, error.name).replace("']", "").replace("['", ".")
        raise ParameterError(name, error.value, error.accepted, _near(error, table)) from None


def pressure_of(table: ValveForce | ValveLoad) -> float | None:
    """The pressure of the supply in Pa, or None."""
    given = table.pressure if isinstance(table, ValveForce) else None
    return None if given is None else _above_zero("pressure", given, "pressure")


def room_of(table: ValveForce | ValveLoad) -> float | None:
    """How far behind the wall the piston can go: in m, or dimensionless; None without a limit."""
    return None if table.room is None else _above_zero("room", table.room, "length")


def _near(error: ParameterError, table: ValveForce | ValveLoad) -> str:
    """The state that was probably meant, else the remedy as it is."""
    from percuss.errors import did_you_mean

    if error.name.endswith(".to") or error.name == "start":
        return did_you_mean(error.value, table.states) or error.remedy
    return error.remedy


def _state_force(name: str, given: Any, pressure: float | None) -> float:
    key = f"states.{name}"
    if not isinstance(given, AreasTable):
        return _value(key, given, "force")
    if pressure is None:
        raise ParameterError(key, None, "a force, as there is no pressure for the areas", _PRESSURE)
    areas = {side: _piston_area(f"{key}.{side}", getattr(given, side)) for side in ("front", "rear")}
    return pressure * (areas["rear"] - areas["front"])


def _piston_area(key: str, given: str | None) -> float:
    if given is None:
        return 0.0
    try:
        return non_negative(key, si(given, "area", key))
    except ParameterError:
        raise ParameterError(key, given, "an area, 0 or greater") from None


def _port(key: str, table: PortTable | PlainPort) -> Port:
    given: dict[str, Any] = {"to": table.to}
    if table.behind is not None:
        given["behind"] = _above_zero(f"{key}behind", table.behind, "length", _BEHIND)
    if table.delay is not None:
        given["delay"] = _value(f"{key}delay", table.delay, "time")
    given |= {name: value for name in ("side", "reads", "on") if (value := getattr(table, name)) is not None}
    try:
        return Port(**given)
    except ParameterError as error:
        raise ParameterError(key + error.name, error.value, error.accepted, error.remedy) from None


_BEHIND = "the wall is at 0, and the distance is counted away from it"


def _chamber(table: ChamberTable | PlainChamber | None) -> Chamber:
    if table is None:
        return Chamber()
    try:
        return Chamber(
            0.0 if table.force is None else _value("force", table.force, "force"),
            0.0 if table.stiffness is None else _value("stiffness", table.stiffness, "stiffness"),
        )
    except ParameterError as error:
        raise ParameterError(f"chamber.{error.name}", error.value, error.accepted, error.remedy) from None


_CUSHION = {"beyond": "length", "force": "force", "stiffness": "stiffness", "length": "length", "area": "area"}


def _cushion(table: CushionTable | PlainCushion | None) -> Cushion | None:
    if table is None:
        return None
    given = {name: value for name in type(table).model_fields if (value := getattr(table, name)) is not None}
    try:
        return Cushion(
            **{
                name: value if name == "returned" else _value(f"cushion.{name}", value, _CUSHION[name])
                for name, value in given.items()
            }
        )
    except ParameterError as error:
        remedy = error.remedy
        if error.name == "beyond":
            remedy = "one that began behind the wall would take part of every blow, which is not in the model"
        raise ParameterError(f"cushion.{error.name}", given[error.name], error.accepted, remedy) from None


def _supply(table: ValveForce | ValveLoad, pressure: float | None) -> Supply | None:
    given: SupplyTable | PlainSupply | None = table.supply
    if given is None:
        return None
    flow = _above_zero("supply.flow", given.flow, "flow")
    accumulator = _above_zero("supply.accumulator", given.accumulator, "compliance")
    start = None if given.start is None else _value("supply.start", given.start, "pressure")
    if start is not None and start < 0.0:
        raise ParameterError("supply.start", given.start, "a pressure, 0 or greater")
    if isinstance(table, ValveLoad):
        return Supply(flow, accumulator, 1.0 if start is None else start)
    for name, state in table.states.items():
        if not isinstance(state, AreasTable):
            remedy = "a piston displaces oil by the areas on which its pressure acts"
            raise ParameterError(f"states.{name}", state, "areas, {front = …, rear = …}, beside a supply", remedy)
    if pressure is None:
        raise ParameterError("pressure", None, "the pressure for which the states hold, beside a supply", _PRESSURE)
    return Supply.of_oil(flow, accumulator, pressure, start)


def _value(key: str, given: float | str, dimension: str) -> float:
    """The number, in base units where it has one."""
    return si(given, dimension, key) if isinstance(given, str) else float(given)


def _above_zero(key: str, given: float | str, dimension: str, remedy: str = "") -> float:
    try:
        return positive(key, _value(key, given, dimension))
    except ParameterError as error:
        raise ParameterError(key, given, f"a {dimension} greater than 0", remedy or error.remedy) from None
