"""A motion of a machine as an xarray dataset and as a NetCDF file, from which it goes on bit for bit."""

from __future__ import annotations

import json
from dataclasses import asdict
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
import numpy.typing as npt

from percuss._version import __version__
from percuss.errors import PercussError
from percuss.model import Machine
from percuss.model.checks import Array, count, finite
from percuss.model.described import describe_machine, machine_from
from percuss.simulate.machine.machine_events import MACHINE_KINDS, MachineEvents
from percuss.simulate.machine.machine_snapshot import KINDS
from percuss.simulate.machine.machine_summary import MACHINE_OUTCOMES, MachineCycle
from percuss.simulate.motion_files import damaged, digest, plain, records, xarray_package
from percuss.simulate.soundness import numbers, shaped, true, within
from percuss.simulate.stop import MAX_MODES, MOST_IMPACTS, Stop

if TYPE_CHECKING:
    import xarray

__all__ = ["MACHINE_FORMAT", "motion_from", "to_dataset"]

MACHINE_FORMAT = "percuss machine trajectory 1"

_TIME, _SPEED, _ENERGY = "unit of time", "bar lengths per unit of time", "bar lengths^2 per unit of time^2"
_COLUMNS = {
    "code": ("int8", "1", f"kind of the event: {', '.join(f'{i} {kind}' for i, kind in enumerate(MACHINE_KINDS))}"),
    "time": ("float64", _TIME, "time of the event"),
    "velocity": ("float64", _SPEED, "velocity of the striking end before it, or of what a port reads"),
    "rebound_velocity": ("float64", _SPEED, "velocity of the striking end after the event"),
    "energy_lost": ("float64", _ENERGY, "energy that the event takes from the bar, per unit of mass"),
    "kinetic_energy": ("float64", _ENERGY, "blow energy: kinetic energy just before an impact, per unit of mass"),
    "state": ("int64", "1", "state of the valve after the event, by its number"),
    "port": ("int64", "1", "number of the port that demands, -1 for other events"),
    "resolved": ("int64", "1", "of a chatter: its impacts recorded singly, the main blow first"),
}
"""Of the event table: types, units and meanings."""

_TOLD = "machine"
_SAID = ("modes", "first_state", "resting", "begin_time", "end_time")


class _Motion(Protocol):
    """What is asked of a motion; a `MachineTrajectory` has it."""

    @property
    def machine(self) -> Machine: ...
    @property
    def events(self) -> MachineEvents: ...
    @property
    def states(self) -> Array: ...
    @property
    def snapshot(self) -> dict[str, npt.NDArray[Any]]: ...
    @property
    def outcome(self) -> str: ...
    @property
    def label(self) -> str: ...
    @property
    def cycle(self) -> MachineCycle | None: ...
    @property
    def stop(self) -> Stop: ...


def to_dataset(motion: _Motion) -> xarray.Dataset:
    """See `MachineTrajectory.to_xarray`."""
    variables: dict[str, Any] = {}
    for name, (_, unit, meaning) in _COLUMNS.items():
        variables[name] = ("event", getattr(motion.events, name), {"long_name": meaning, "units": unit})
    meaning = "gap, rigid velocity, amplitudes at the start and after each event"
    variables["bar_state"] = (("event_and_start", "state_number"), motion.states, {"long_name": meaning})
    for name, array in motion.snapshot.items():
        variables[f"engine_{name}"] = plain(name, array)
    about = {name: getattr(motion, name) for name in _SAID}
    cycle = None if motion.cycle is None else asdict(motion.cycle)
    dataset: xarray.Dataset = xarray_package().Dataset(
        variables,
        attrs={
            "format": MACHINE_FORMAT,
            "percuss_version": __version__,
            "title": str(motion),
            "label": motion.label,
            "outcome": motion.outcome,
            "states": ", ".join(motion.events.states),
            _TOLD: json.dumps(describe_machine(motion.machine)),
            "description": json.dumps({**about, "cycle": cycle, "stop": asdict(motion.stop)}),
        },
    )
    return dataset.assign_attrs(sha256=digest(dataset, _TOLD))


def motion_from(name: str, dataset: xarray.Dataset) -> dict[str, Any]:
    """What the content of a file of this name says, by the names of the fields of a `MachineTrajectory`.

    Raises
    ------
    PercussError
        When it is another file, or a damaged one.
    """
    if dataset.attrs.get("format") != MACHINE_FORMAT:
        found = str(dataset.attrs.get("format", "not a percuss file"))[:80]
        raise PercussError(f"{name}: {found}", f"this version reads '{MACHINE_FORMAT}'")
    try:
        if dataset.attrs["sha256"] == digest(dataset, _TOLD):
            return _fields(dataset)
    except (LookupError, TypeError, ValueError, AttributeError, OverflowError, RecursionError) as error:
        raise damaged(name, str(error)[:200]) from None
    raise damaged(name, "its numbers are not the ones that were written")


def _fields(dataset: xarray.Dataset) -> dict[str, Any]:
    about = json.loads(dataset.attrs["description"])
    machine = machine_from(json.loads(dataset.attrs[_TOLD]))
    states = tuple(name for name, _ in machine.valve.pairs)
    modes = count("modes", about["modes"], least=0, most=MAX_MODES)
    events = MachineEvents(**{name: dataset[name].values for name in _COLUMNS}, states=states)
    _check_events(events, len(machine.valve.ports))
    bars = dataset["bar_state"].values
    numbers("bar_state", bars, (len(events) + 1, 2 * modes + 2))
    engine = [str(key).removeprefix("engine_") for key in dataset.variables if str(key).startswith("engine_")]
    begin, end = finite("begin_time", about["begin_time"]), finite("end_time", about["end_time"])
    true(begin <= end and isinstance(about["resting"], bool), "end_time or resting")
    true(dataset.attrs["outcome"] in MACHINE_OUTCOMES and len(dataset.attrs["label"]) <= 100, "outcome or label")
    return {
        "machine": machine,
        "modes": modes,
        "events": events,
        "states": bars,
        "first_state": count("first_state", about["first_state"], least=0, most=len(states) - 1),
        "resting": about["resting"],
        "outcome": dataset.attrs["outcome"],
        "label": dataset.attrs["label"],
        "cycle": None if about["cycle"] is None else MachineCycle(**about["cycle"]),
        "stop": Stop(**about["stop"]),
        "begin_time": begin,
        "end_time": end,
        "snapshot": {name: records(name, dataset[f"engine_{name}"], KINDS) for name in engine},
    }


def _check_events(events: MachineEvents, ports: int) -> None:
    """Refuse columns that no simulation has left."""
    shape = np.shape(events.code)
    true(len(shape) == 1, "the shape of code")
    for name, (kind, _, _) in _COLUMNS.items():
        values = getattr(events, name)
        if kind == "float64":
            numbers(name, values, shape)
        else:
            shaped(name, values, kind, shape)
    within("code", events.code, 0, len(MACHINE_KINDS) - 1)
    within("state", events.state, 0, len(events.states) - 1)
    within("port", events.port, -1, ports - 1)
    within("resolved", events.resolved, 0, MOST_IMPACTS)
    true(np.all(np.diff(events.time) >= 0.0), "the order of the events")
