"""A trajectory as an xarray dataset and as a NetCDF file, from which it goes on bit for bit."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from dataclasses import asdict, fields
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
import numpy.typing as npt

from percuss._version import __version__
from percuss.errors import PercussError
from percuss.model.checks import count
from percuss.model.checks import path as checked_path
from percuss.model.described import describe_system, system_from
from percuss.simulate.events import KINDS, Events
from percuss.simulate.flight import Anchor
from percuss.simulate.motion_files import damaged, digest, opened, plain, records, xarray_package
from percuss.simulate.restored import RECORDS
from percuss.simulate.simulated_motion import SimulatedMotion
from percuss.simulate.soundness import sound
from percuss.simulate.stop import MAX_MODES, Stop
from percuss.simulate.summary import Cycle
from percuss.whole_file import write_dataset

if TYPE_CHECKING:
    import xarray

__all__ = ["FORMAT", "ensemble_dataset", "motion_from", "read", "to_dataset", "write"]

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
