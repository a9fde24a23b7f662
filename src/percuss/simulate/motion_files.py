"""What files of saved motions share: read whole or refused, with a sum that shows damage, records as plain numbers."""

from __future__ import annotations

import hashlib
import json
import math
import os
from collections.abc import Mapping
from dataclasses import asdict, fields
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
import numpy.typing as npt

from percuss._version import __version__
from percuss.errors import HistoryError, MissingExtraError, PercussError
from percuss.model.checks import count
from percuss.model.checks import path as checked_path
from percuss.model.described import describe_system, system_from
from percuss.recordings.netcdf_file import netcdf_content
from percuss.recordings.separate_process import Died
from percuss.recordings.untrusted_files import Damaged
from percuss.simulate.events import KINDS, Cycle, Events
from percuss.simulate.kernels.motion_records import COUNT, GRAZED, LOST_CYCLE, NOW, PAST, SUMS, WINDOW
from percuss.simulate.simulated_motion import (
    MOST_PERIODS,
    TURN,
    Anchor,
    SimulatedMotion,
    numbers,
    shaped,
    sound,
    true,
    within,
)
from percuss.simulate.stop import MAX_MODES, Stop
from percuss.whole_file import write_dataset

if TYPE_CHECKING:
    import xarray

    from percuss.simulate.tables import Snapshot

SAID = ("format", "label", "outcome", "description")
"""What is said in every file beside its numbers."""

_REMEDY = "give a file that 'percuss simulate -o', Trajectory.save or MachineTrajectory.save wrote"


_AGAIN = "use a copy of it, or simulate again"


def opened(path: str | os.PathLike[str]) -> tuple[str, xarray.Dataset]:
    """The name of a file and its content, of any format.

    Raises
    ------
    PercussError
        When there is no such file, or it is none that can be read.
    """
    name = checked_path("path", path)
    xarray_package()
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


def digest(dataset: xarray.Dataset, told: str = "system") -> str:
    """SHA-256 of all numbers, their names, types and shapes, and of what is said about them; `told`: of what moves."""
    found = hashlib.sha256()
    for name in sorted(map(str, dataset.variables)):
        values = np.ascontiguousarray(dataset[name].values)
        found.update(f"{name} {values.dtype.newbyteorder('<').str} {values.shape}\n".encode())
        found.update(values.astype(values.dtype.newbyteorder("<"), copy=False).tobytes())
    for name in (*SAID[:3], told, *SAID[3:]):
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
    """The records again; `kinds`: the types of those arrays that hold records.

    Raises
    ------
    ValueError
        When the columns are not the ones that this version knows.
    """
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


def xarray_package() -> Any:
    """The package xarray.

    Raises
    ------
    MissingExtraError
        When it is not installed.
    """
    try:
        import xarray
    except ImportError:
        raise MissingExtraError("xarray", "io") from None
    return xarray


# ---- The state that a motion goes on from, looked at before it is given to the kernels: they check no bound themselves

_MOST_WORK = 2**62

_ENDLESS = ("hold", "last_flight", "since", "pushes")
"""Times among the numbers of the anchor: infinite when nothing bounds them."""

RECORDS = {"now": (NOW, 1), "count": (COUNT, 1), "past": (PAST, WINDOW), "sums": (SUMS, 2)}
"""Type and number of the records of a snapshot."""


def restored(motion: SimulatedMotion) -> Snapshot:
    """The state at the end of a motion, in arrays as the kernels want them.

    Raises
    ------
    PercussError
        When a simulation cannot have left it: it comes from a file that was changed, or made up.
    """
    from percuss.simulate.tables import Snapshot  # the compiled room, which nobody needs who only reads a file

    try:
        _check(motion)
    except ValueError as error:
        told = f"the state to continue from is damaged: {error}"
        raise PercussError(told, "use a copy of its file, or simulate again") from None
    names = ("z", "now", "count", "cycle", "past", "sums")
    return Snapshot(**{name: np.ascontiguousarray(motion.snapshot[name]) for name in names})


def _check(motion: SimulatedMotion) -> None:
    snapshot, system, modes = motion.snapshot, motion.system, motion.modes
    for name in ("z", "now", "count", "cycle", "past", "sums"):
        if name not in snapshot:
            raise ValueError(f"there is no engine_{name}")
    for name in ("z", "cycle"):
        numbers(f"engine_{name}", snapshot[name], (2, modes))
    for name, (kind, size) in RECORDS.items():
        shaped(f"engine_{name}", snapshot[name], kind, (size,))
    for name in ("past", "sums"):
        values = snapshot[name].view(np.float64)
        numbers(f"engine_{name}", values, values.shape)
    _now(snapshot["now"])
    _counts(snapshot["count"], max(len(system.load.values), 1), motion.impacts, len(motion.events))
    from percuss.simulate.remembered import remembered

    remembered(motion)


def _now(now: npt.NDArray[Any]) -> None:
    bounded = now.copy()
    for name in _ENDLESS:
        bounded[name] = np.where(np.isposinf(now[name]), 0.0, now[name])
    values = bounded.view(np.float64)
    numbers("engine_now", values, values.shape)
    phase = float(now["phase"][0])
    within("engine_now", phase, 0.0, TURN)
    # else the load that the kernels see is another one than the phase says
    for name, exact in (("cosine", math.cos(phase)), ("sine", math.sin(phase))):
        within("engine_now", now[name], exact - 1e-9, exact + 1e-9)


def _counts(whole: npt.NDArray[Any], pieces: int, impacts: int, events: int) -> None:
    most = dict.fromkeys(COUNT.names or (), _MOST_WORK)
    least = dict.fromkeys(most, 0)
    for name in ("period", "anchor_period", "release_period", "mark_period", "cycle_periods"):
        least[name], most[name] = -MOST_PERIODS, MOST_PERIODS
    least["cycle_periods"] = 0
    most["piece"], most["mode"], most["cycle_kind"] = pieces - 1, GRAZED, 2
    least["impacts"] = most["impacts"] = impacts  # as many as are recorded
    most |= dict.fromkeys(("run", "anchor", "cycle_impacts", "confirmed", "found_at", "mark"), impacts)
    most |= dict.fromkeys(("rests", "chatters", "mark_releases", "mark_chatters"), events)
    most |= dict.fromkeys(("patience", "mark_patience"), 2 * events + 1)  # doubled when so many have gone by
    most["verdict"], most["events"] = LOST_CYCLE, 0
    for name in most:
        true(least[name] <= whole[name][0] <= most[name], f"{name} of engine_count")


# ---- A trajectory as an xarray dataset and as a NetCDF file, from which it goes on bit for bit

Kind = TypeVar("Kind", bound=SimulatedMotion)

FORMAT = "percuss trajectory 3"
_OLDER = ("percuss trajectory 1", "percuss trajectory 2")
_KINDS = {name: kind for name, (kind, _) in RECORDS.items()}
_UNITS = {
    "time": "rad",
    "phase": "rad",
    "period": "load periods",
    "impact_velocity": "bar lengths per rad",
    "rebound_velocity": "bar lengths per rad",
    "energy_lost": "M L^3 Omega^2",
    "kinetic_energy": "M L^3 Omega^2",
}
_MEANING = {
    "code": f"kind of the event: {', '.join(f'{i} {kind}' for i, kind in enumerate(KINDS))}",
    "period": "load periods elapsed",
    "phase": "phase of the load",
    "time": "2 pi period + phase",
    "impact_velocity": "velocity of the striking end before the event",
    "rebound_velocity": "velocity of the striking end after the event",
    "energy_lost": "energy that the event takes from the bar",
    "kinetic_energy": "blow energy: kinetic energy just before an impact",
    "resolved": "of a chatter: its impacts recorded singly, the main blow first",
    "piece": "number of the step of a piecewise constant load",
}


def to_dataset(motion: SimulatedMotion) -> xarray.Dataset:
    """See `Trajectory.to_xarray`."""
    package = xarray_package()
    variables: dict[str, Any] = {}
    for field in fields(Events):
        values = getattr(motion.events, field.name)
        about = {"long_name": _MEANING[field.name], "units": _UNITS.get(field.name, "1")}
        variables[field.name] = ("event", values, about)
    about = {"long_name": _MEANING["time"], "units": "rad"}
    variables["time"] = ("event", motion.events.time, about)
    for name, values in (("displacement", motion.displacement), ("velocity", motion.velocity)):
        variables[name] = (("event", "mode"), values, {"long_name": f"modal {name} after the event, B77 6"})
    variables["state"] = (("event", "state_number"), motion.states, {"long_name": "gap, rigid velocity, amplitudes"})
    start = np.concatenate([[motion.start.gap, motion.start.rigid_rate], motion.start.z.reshape(-1)])
    variables["start_state"] = ("state_number", start, {"long_name": "state at the start"})
    for name, array in motion.snapshot.items():
        variables[f"engine_{name}"] = plain(name, array)
    dataset: xarray.Dataset = package.Dataset(
        variables,
        coords={"mode": np.arange(motion.modes + 1)},
        attrs={
            "format": FORMAT,
            "percuss_version": __version__,
            "title": str(motion),
            "label": motion.label,
            "outcome": motion.outcome,
            "system": json.dumps(describe_system(motion.system)),
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


def ensemble_dataset(modes: int, columns: Mapping[str, npt.NDArray[Any]]) -> xarray.Dataset:
    """See `Ensemble.to_xarray`: its columns, each of shape (members,) or (members, last)."""
    package = xarray_package()
    variables = {name: (("member", "last")[: values.ndim], values) for name, values in columns.items()}
    dataset: xarray.Dataset = package.Dataset(
        variables, attrs={"modes": modes, "percuss_version": __version__, "title": "percuss ensemble"}
    )
    return dataset


def write(motion: SimulatedMotion, path: str | os.PathLike[str]) -> None:
    """Write the file: whole, or not at all."""
    write_dataset(to_dataset(motion), checked_path("path", path))


def read(path: str | os.PathLike[str], kind: type[Kind]) -> Kind:
    """See `Trajectory.load`; `kind`: the class of the motion."""
    return motion_from(*opened(path), kind)


def motion_from(name: str, dataset: xarray.Dataset, kind: type[Kind]) -> Kind:
    """The motion in the content of a file of this name."""
    if dataset.attrs.get("format") != FORMAT:
        found = str(dataset.attrs.get("format", "not a percuss file"))[:80]
        if found in _OLDER:
            written = str(dataset.attrs.get("percuss_version", "unknown"))[:80]
            reason = f"{name}: written by percuss {written}, whose motions this version cannot continue ('{found}')"
            raise PercussError(reason, "simulate the motion again from its start and save it again")
        raise PercussError(f"{name}: {found}", f"this version reads '{FORMAT}'")
    try:
        if dataset.attrs["sha256"] == digest(dataset):
            motion = _from_dataset(dataset, kind)
            sound(motion)
            return motion
    except (LookupError, TypeError, ValueError, AttributeError, OverflowError, RecursionError) as error:
        raise damaged(name, str(error)[:200]) from None
    raise damaged(name, "its numbers are not the ones that were written")


def _from_dataset(dataset: xarray.Dataset, kind: type[Kind]) -> Kind:
    about = json.loads(dataset.attrs["description"])
    system = system_from(json.loads(dataset.attrs["system"]))
    modes = count("modes", about["modes"], least=0, most=MAX_MODES)
    start = dataset["start_state"].values
    names = ("z", "now", "count", "cycle", "past", "sums")
    engine = {name: records(name, dataset[f"engine_{name}"], _KINDS) for name in names}
    return kind(
        system=system,
        modes=modes,
        events=Events(**{field.name: dataset[field.name].values for field in fields(Events)}),
        states=dataset["state"].values.reshape(-1, 2 * modes + 2),
        start=Anchor(
            about["start_phase"], about["start_piece"], float(start[0]), float(start[1]), start[2:].reshape(2, modes)
        ),
        resting=about["resting"],
        snapshot=engine,
        outcome=dataset.attrs["outcome"],
        label=dataset.attrs["label"],
        cycle=None if about["cycle"] is None else Cycle(**about["cycle"]),
        stop=Stop(**about["stop"]),
        begin_time=about["begin_time"],
        end_time=about["end_time"],
    )
