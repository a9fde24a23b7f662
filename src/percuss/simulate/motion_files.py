"""A motion as a NetCDF file, from which it goes on bit for bit; read whole or refused, with a sum that shows damage."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Callable, Mapping
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from percuss._version import __version__
from percuss.atomic_write import write_dataset
from percuss.errors import HistoryError, PercussError, extra_package
from percuss.model import Machine, System
from percuss.model.checks import count
from percuss.model.checks import path as checked_path
from percuss.model.described import describe_machine, describe_system, machine_from, system_from
from percuss.recordings.file_formats import netcdf_content
from percuss.recordings.separate_process import Died
from percuss.recordings.untrusted_files import Damaged
from percuss.short_repr import watched
from percuss.simulate.events import KINDS, Events, MotionCycle, joined
from percuss.simulate.kernels.motion_records import TURNING, VALVE_NOW
from percuss.simulate.sound import OF_SNAPSHOT, RECORDS, Motion, kept, kept_valve, sound, width
from percuss.simulate.spectrum import Anchor
from percuss.simulate.stop import MAX_MODES, Stop

if TYPE_CHECKING:
    import pandas
    import xarray

    from percuss.simulate.engine import Clocked, Progress
    from percuss.simulate.oil import FlowingOil
    from percuss.simulate.valve import SelfSwitching


_REMEDY = "give a file that 'percuss simulate -o', Trajectory.save wrote"


_AGAIN = "use a copy of it, or simulate again"
_DESCRIBED = ("system", "machine")  # of which a file has one


def opened(path: str | os.PathLike[str]) -> tuple[str, xarray.Dataset]:
    """The name of a file and its content, of any format; PercussError when it cannot be read."""
    name = checked_path("path", path)
    extra_package("xarray", "io")
    try:
        return name, netcdf_content(Path(name))
    except FileNotFoundError:
        raise PercussError(f"{name}: no such file", _REMEDY) from None
    except Died as error:
        raise PercussError(error.message, _AGAIN) from None
    except Damaged:
        raise PercussError(f"{name}: not a NetCDF 4 file, or a damaged one", _REMEDY) from None
    except HistoryError as error:
        raise PercussError(error.message if error.file else f"{name}: {error.message}", _REMEDY) from None
    except OSError as error:
        raise PercussError(f"{name}: cannot be read: {error.strerror or error}", _REMEDY) from None


def damaged(name: str, what: str) -> PercussError:
    """The refusal of a file that is not what was written."""
    return PercussError(f"{name}: the file is damaged: {what}", _AGAIN)


def digest(dataset: xarray.Dataset) -> str:
    """SHA-256 of all numbers, their names, types and shapes, and of what is said about them."""
    found = hashlib.sha256()
    for name in sorted(map(str, dataset.variables)):
        values = np.ascontiguousarray(dataset[name].values)
        found.update(f"{name} {values.dtype.newbyteorder('<').str} {values.shape}\n".encode())
        found.update(values.astype(values.dtype.newbyteorder("<"), copy=False).tobytes())
    for name in ("format", "label", "outcome", *(told for told in _DESCRIBED if told in dataset.attrs), "description"):
        found.update(f"{name} {dataset.attrs[name]}\n".encode())
    return found.hexdigest()


def plain(name: str, array: npt.NDArray[Any]) -> tuple[list[str], npt.NDArray[Any], dict[str, str]]:
    """Records as rows of plain numbers, with the names of the columns beside them."""
    names = array.dtype.names
    about = {} if names is None else {"fields": " ".join(names)}
    if names is not None:
        array = array.view(_number_of(array.dtype)).reshape(array.shape[0], -1)
    return [f"engine_{name}_{i}" for i in range(array.ndim)], array, about


def _number_of(kind: np.dtype[Any]) -> np.dtype[Any]:
    """What the fields of a record are kept as; their bits as whole numbers where they are of several types."""
    types = {kind[i] for i in range(len(kind.names or ()))}
    return types.pop() if len(types) == 1 else np.dtype(np.int64)


def records(name: str, data: xarray.DataArray, kinds: Mapping[str, np.dtype[Any]]) -> npt.NDArray[Any]:
    """The records again, of the types `kinds`; ValueError when the columns are not the ones that this version knows."""
    values = np.ascontiguousarray(data.values)
    if name not in kinds:
        return values
    kind = kinds[name]
    names = kind.names or ()
    if (
        data.attrs.get("fields") != " ".join(names)
        or values.dtype != _number_of(kind)
        or values.shape[1:] != (len(names),)
    ):
        raise ValueError(f"engine_{name} has other columns")
    return values.view(kind).reshape(-1)


# ---- The state that a motion goes on from, looked at before it is given to the kernels: they check no bound themselves


def continued(motion: Motion, stop: Stop, progress: Callable[[Progress], object] | None) -> dict[str, Any]:
    """What a motion that is followed further has otherwise than the one it goes on from, by the names of fields."""
    moved: Clocked | SelfSwitching | FlowingOil
    try:
        (kept if motion.is_clocked else kept_valve)(motion)
    except ValueError as error:
        told = f"the state to continue from is damaged: {error}"
        raise PercussError(told, "use a copy of its file, or simulate again") from None
    if motion.is_clocked:
        from percuss.simulate.engine import Clocked, Snapshot, prepared

        arrays = {name: np.ascontiguousarray(motion.snapshot[name]) for name in OF_SNAPSHOT}
        moved = Clocked(*prepared(motion.system, motion.modes), Snapshot(**arrays))
    elif motion.hammer.valve.flows:
        from percuss.simulate.oil import FlowingOil

        moved = FlowingOil.restored(motion.hammer, motion.modes, motion.snapshot)
    else:
        from percuss.simulate.valve import SelfSwitching

        moved = SelfSwitching.restored(motion.mechanism, motion.snapshot, stop)
    with watched(progress) as watch:
        made = moved.followed(stop, motion.begin_time, watch)
    made["events"] = joined([motion.events, made["events"]])
    made["states"] = np.concatenate([motion.states, made["states"]])
    return made | {"stop": stop}


# ---- A trajectory as an xarray dataset and as a NetCDF file

FORMAT = "percuss trajectory 4"
_READ = "percuss trajectory 3"  # an older one that is still read
_OLDER = ("percuss trajectory 1", "percuss trajectory 2")
_KINDS = {name: kind for name, (kind, _) in RECORDS.items()} | {"valve_now": VALVE_NOW, "valve_past": TURNING}
_CLOCKED = {"speed": "bar lengths per rad", "energy": "M L^3 Omega^2", "phase": "rad", "period": "load periods"}
_OWN = {"speed": "bar lengths per unit of time", "energy": "bar lengths^2 per unit of time^2"}
_OWN |= {"phase": "unit of time", "period": "1"}
_COLUMNS = {
    "code": ("int8", "1", f"kind of the event: {', '.join(f'{i} {kind}' for i, kind in enumerate(KINDS))}"),
    "period": ("int64", "period", "load periods elapsed; 0 without a clock"),
    "phase": ("float64", "phase", "phase of the load; of a machine the time"),
    "impact_velocity": ("float64", "speed", "velocity of the striking end before it, or of what a port reads"),
    "rebound_velocity": ("float64", "speed", "velocity of the striking end after the event"),
    "energy_lost": ("float64", "energy", "energy that the event takes from the bar, of a machine per unit of mass"),
    "kinetic_energy": ("float64", "energy", "blow energy: kinetic energy just before an impact"),
    "resolved": ("int64", "1", "of a chatter: its impacts recorded singly, the main blow first"),
    "piece": ("int64", "1", "number of the step of a piecewise constant load, or of the state of a valve"),
    "port": ("int64", "1", "number of the port that demands, -1 for other events"),
}
"""Of the event table: types, units and meanings."""


def to_dataset(motion: Motion) -> xarray.Dataset:
    """See `Trajectory.to_xarray`."""
    package = extra_package("xarray", "io")
    units, hammer = _CLOCKED if motion.is_clocked else _OWN, motion.hammer
    variables: dict[str, Any] = {}
    for name, (_, unit, meaning) in _COLUMNS.items():
        about = {"long_name": meaning, "units": units.get(unit, unit)}
        variables[name] = ("event", getattr(motion.events, name), about)
    about = {"long_name": "2 pi period + phase", "units": units["phase"]}
    variables["time"] = ("event", motion.events.time, about)
    for name, values in (("displacement", motion.displacement), ("velocity", motion.velocity)):
        variables[name] = (("event", "mode"), values, {"long_name": f"modal {name} after the event, B77 6"})
    variables["state"] = (("event", "state_number"), motion.states, {"long_name": "gap, rigid velocity, amplitudes"})
    variables["start_state"] = ("state_number", motion.start.row, {"long_name": "state at the start"})
    for name, array in motion.snapshot.items():
        variables[f"engine_{name}"] = plain(name, array)
    described = describe_system(hammer) if isinstance(hammer, System) else describe_machine(hammer)
    dataset: xarray.Dataset = package.Dataset(
        variables,
        coords={"mode": np.arange(motion.modes + 1)},
        attrs={
            "format": FORMAT,
            "percuss_version": __version__,
            "title": str(motion),
            "label": motion.label,
            "outcome": motion.outcome,
            _DESCRIBED[not motion.is_clocked]: json.dumps(described),
            "description": json.dumps(
                {
                    "modes": motion.modes,
                    "cycle": None if motion.cycle is None else asdict(motion.cycle),
                    "stop": asdict(motion.stop),
                    "begin_time": motion.begin_time,
                    "end_time": motion.end_time,
                    "start_phase": motion.start.phase,
                    "start_piece": motion.start.piece,
                    "resting": motion.resting,
                }
            ),
        },
    )
    return dataset.assign_attrs(sha256=digest(dataset))


def to_table(motion: Motion) -> pandas.DataFrame:
    """See `Trajectory.to_pandas`."""
    events = motion.events
    table: pandas.DataFrame = (
        extra_package("pandas", "io")
        .DataFrame({"time": events.time, "kind": events.kind, **events.columns()})
        .drop(columns="code")
    )
    return table.assign(state=np.array(events.states)[events.piece]) if events.states else table


def ensemble_dataset(modes: int, columns: Mapping[str, npt.NDArray[Any]]) -> xarray.Dataset:
    """See `Ensemble.to_xarray`: its columns, each of shape (members,) or (members, last)."""
    package = extra_package("xarray", "io")
    variables = {name: (("member", "last")[: values.ndim], values) for name, values in columns.items()}
    dataset: xarray.Dataset = package.Dataset(
        variables, attrs={"modes": modes, "percuss_version": __version__, "title": "percuss ensemble"}
    )
    return dataset


def write(motion: Motion, path: str | os.PathLike[str]) -> None:
    """Write the file: whole, or not at all."""
    write_dataset(to_dataset(motion), checked_path("path", path))


def motion_from(name: str, dataset: xarray.Dataset, kind: type[Motion]) -> Motion:
    """The motion in the content of a file of this name."""
    found = str(dataset.attrs.get("format", "not a percuss file"))[:80]
    if found in _OLDER:
        written = str(dataset.attrs.get("percuss_version", "unknown"))[:80]
        reason = f"{name}: written by percuss {written}, whose motions this version cannot continue ('{found}')"
        raise PercussError(reason, "simulate the motion again from its start and save it again")
    if found not in (FORMAT, _READ):
        raise PercussError(f"{name}: {found}", f"this version reads '{FORMAT}'")
    try:
        if dataset.attrs["sha256"] == digest(dataset):
            if found == _READ:  # which knew no ports
                dataset = dataset.assign(port=("event", np.full(dataset["code"].size, -1)))
            motion = _from_dataset(dataset, kind)
            sound(motion, {column: kind for column, (kind, _, _) in _COLUMNS.items()})
            return motion
    except (LookupError, TypeError, ValueError, AttributeError, OverflowError, RecursionError) as error:
        raise damaged(name, str(error)[:200]) from None
    raise damaged(name, "its numbers are not the ones that were written")


def _from_dataset(dataset: xarray.Dataset, kind: type[Motion]) -> Motion:
    about = json.loads(dataset.attrs["description"])
    clocked = "system" in dataset.attrs
    hammer = (system_from if clocked else machine_from)(json.loads(dataset.attrs[_DESCRIBED[not clocked]]))
    modes = count("modes", about["modes"], least=0, most=MAX_MODES)
    engine = [str(key).removeprefix("engine_") for key in dataset.variables if str(key).startswith("engine_")]
    states = tuple(name for name, _ in hammer.valve.pairs) if isinstance(hammer, Machine) else ()
    return kind(
        hammer=hammer,
        modes=modes,
        events=Events(**{name: dataset[name].values for name in _COLUMNS}, states=states),
        states=dataset["state"].values.reshape(-1, width(hammer, modes)),
        start=Anchor(about["start_phase"], about["start_piece"], dataset["start_state"].values),
        resting=about["resting"],
        snapshot={name: records(name, dataset[f"engine_{name}"], _KINDS) for name in engine},
        outcome={"cancelled": "interrupted"}.get(dataset.attrs["outcome"], dataset.attrs["outcome"]),  # its name before
        label=dataset.attrs["label"],
        cycle=None if about["cycle"] is None else MotionCycle(**about["cycle"]),
        stop=Stop(**about["stop"]),
        begin_time=about["begin_time"],
        end_time=about["end_time"],
    )
