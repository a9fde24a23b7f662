"""A load from a recorded history that a case names, with every refusal translated to its key."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from percuss.case.file_format.load_tables import HistoryForce, HistoryLoad
from percuss.case.file_format.problems import from_parameter
from percuss.case.file_format.suggest import did_you_mean
from percuss.errors import CaseError, HistoryError, ParameterError
from percuss.model import Load
from percuss.units import si

if TYPE_CHECKING:
    from percuss.model.checks import Array
    from percuss.recordings.recording import Recording

__all__ = ["ReadHistory", "history_load", "positive_area", "positive_frequency"]


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

    Raises
    ------
    CaseError
        When the recording cannot be read or used, or does not fit the case.
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
        return ReadHistory(load.acting_at(table.at), recording.notes, recording.time, force)
    except (ParameterError, HistoryError, OSError, ValueError) as error:
        raise _refused(error, table, file) from error


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
    return recording, _force(table, recording, file)


def _force(table: HistoryForce, recording: Recording, file: str) -> Array:
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
