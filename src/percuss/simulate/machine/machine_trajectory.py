"""A simulated motion of a machine: what happened, and where the bar is at any time."""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from dataclasses import asdict, dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal, Protocol

import numpy as np
import numpy.typing as npt

from percuss._version import __version__
from percuss.errors import ParameterError, PercussError
from percuss.model import Machine
from percuss.model.checks import Array, array, callback, choice, count, finite, unit_interval
from percuss.model.checks import path as checked_path
from percuss.model.described import describe_machine, machine_from
from percuss.shown import Shown, watched
from percuss.simulate.engine import Progress
from percuss.simulate.kernels.motion_records import CHATTER, IMPACT, RELEASE, REST, VALVE
from percuss.simulate.machine.machine_engine import KINDS, ending, followed, put_back, room_for
from percuss.simulate.machine.machine_events import MACHINE_KINDS, MACHINE_OUTCOMES, MachineCycle, MachineEvents
from percuss.simulate.machine.mechanism import Mechanism, flight, mechanism
from percuss.simulate.motion_files import damaged, digest, plain, records, xarray_package
from percuss.simulate.simulated_motion import numbers, shaped, true, within
from percuss.simulate.stop import MAX_MODES, MOST_IMPACTS, Stop, further

if TYPE_CHECKING:
    import xarray

    from percuss.simulate.machine.mechanism import MachineBalance

Side = Literal["left", "right"]


@dataclass(frozen=True)
class MachineTrajectory(Shown):
    """A simulated motion of a machine that switches its own valve; made by `run_machine`.

    Lengths are those of the bar, times in the machine's unit: seconds for a machine made from SI, with energies per
    kilogram of it and bar length squared, see `Machine`.

    Attributes
    ----------
    machine, modes
        What moved, and N, the number of its elastic modes.
    events
        The event table.
    states
        The state after the start and after each event in the form of the engine, shape (events + 1, 2N + 2).
    first_state
        The number of the valve's state at the start.
    resting
        Whether the bar rests on the wall at the start.
    outcome
        How it ended: one of `percuss.simulate.MACHINE_OUTCOMES`.
    label
        What motion it is at the end: ``runs n/m``, n blows in a valve cycle and m valve cycles until it repeats;
        ``double blow n/m`` with n of 2 or more; ``runs with rest n/m``; ``cycles without blow``; ``stalls (…)``, see
        `percuss.simulate.STALLS`; ``irregular``, or ``undecided`` where too little was followed to tell.
    cycle
        The periodic motion, or None when none was found.
    stop
        The rule it was stopped by.
    begin_time, end_time
        First and last time for which the motion is known.
    snapshot
        What `continued` goes on from.
    """

    machine: Machine
    modes: int
    events: MachineEvents
    states: Array
    first_state: int
    resting: bool
    outcome: str
    label: str
    cycle: MachineCycle | None
    stop: Stop
    begin_time: float
    end_time: float
    snapshot: dict[str, npt.NDArray[Any]] = field(repr=False)

    @property
    def impacts(self) -> int:
        """The number of impacts."""
        return int(np.count_nonzero(self.events.code == IMPACT))

    @property
    def blow_times(self) -> Array:
        """When the impacts fall; shape (impacts,)."""
        return self.events.of("impact").time

    @property
    def blow_speeds(self) -> Array:
        """Striking speed of each impact; shape (impacts,)."""
        return self.events.of("impact").velocity

    @property
    def blow_energies(self) -> Array:
        """Kinetic energy just before each impact; shape (impacts,)."""
        return self.events.of("impact").kinetic_energy

    # -- the state --

    @cached_property
    def mechanism(self) -> Mechanism:
        """The machine's numbers."""
        return mechanism(self.machine, self.modes)

    @cached_property
    def _times(self) -> Array:
        return np.concatenate([[self.begin_time], self.events.time])

    @cached_property
    def _valve(self) -> npt.NDArray[np.int64]:
        return np.concatenate([[self.first_state], self.events.state])

    @cached_property
    def _codes(self) -> npt.NDArray[np.int8]:
        return np.concatenate([[REST if self.resting else RELEASE], self.events.code]).astype(np.int8)

    @cached_property
    def _lies(self) -> npt.NDArray[np.bool_]:
        """Whether the bar rests on the wall after each event; dues come and go there, until it is released."""
        lies, found = False, np.empty(self._codes.size, dtype=bool)
        for i, code in enumerate(self._codes.tolist()):
            lies = code == REST or (lies and code not in (RELEASE, IMPACT))
            found[i] = lies
        return found

    def _after(self, t: Array, side: Side = "right") -> npt.NDArray[np.int64]:
        """The event that each time follows, from 0, the start, on."""
        if t.size and not (self.begin_time <= t.min() and t.max() <= self.end_time):
            accepted = f"times from {self.begin_time:.6g} to {self.end_time:.6g}"
            raise ParameterError("t", f"{t.min():.6g} … {t.max():.6g}", accepted, "simulate for longer")
        return np.maximum(np.searchsorted(self._times, t, side=side) - 1, 0)

    def ends(self, t: npt.ArrayLike, side: Side = "right") -> tuple[Array, Array]:
        """q_i and q_i' at some times, each of shape (N+1, len(t))."""
        choice("side", side, "left", "right")
        times = array("t", t, -np.inf, np.inf)
        last = self._after(times, side)
        q, rate = np.zeros((self.modes + 1, times.size)), np.zeros((self.modes + 1, times.size))
        for i in np.unique(last).tolist():
            if self._lies[i]:
                continue
            here = np.flatnonzero(last == i)
            place, speed = self._placed(i)
            if i + 1 < self._codes.size and self._codes[i + 1] == CHATTER:
                q[:, here] = place[:, None]  # infinitely many bounces of next to no height
                continue
            force = float(self.mechanism.forces[self._valve[i]])
            tau = np.maximum(times[here] - self._times[i], 0.0)
            q[:, here], rate[:, here] = flight(self.mechanism, place, speed, force, tau)
        return q, rate

    def _placed(self, i: int) -> tuple[Array, Array]:
        return self.mechanism.placed(self.states[i], int(self._valve[i]))

    def modal(self, t: npt.ArrayLike, side: Side = "right") -> tuple[Array, Array]:
        """B77's u_n(t) and u_n'(t), each of shape (N+1, len(t)).

        Parameters
        ----------
        t
            Times from `begin_time` to `end_time`.
        side
            At the time of an event: the state after it (``right``) or before it (``left``).

        Raises
        ------
        ParameterError
            For times outside the simulated ones.
        """
        q, rate = self.ends(t, side)
        return self.mechanism.bars(q), self.mechanism.bars(rate)

    def before(self, x: npt.ArrayLike, t: float) -> float:
        """u(x, t) at one place and time, before what happens then."""
        return float((self._shapes(unit_interval("x", x)) @ self.ends(np.array([finite("t", t)]), "left")[0])[0, 0])

    def position(self, x: npt.ArrayLike, t: npt.ArrayLike) -> Array:
        """u(x, t), with the wall at u = 0; shape (len(x), len(t))."""
        return self._shapes(x) @ self.ends(t)[0]

    def bar_velocity(self, x: npt.ArrayLike, t: npt.ArrayLike, side: Side = "right") -> Array:
        """u_t(x, t); shape (len(x), len(t))."""
        return self._shapes(x) @ self.ends(t, side)[1]

    def centre(self, t: npt.ArrayLike) -> Array:
        """Position of the centre of mass; shape (len(t),)."""
        own = self.machine.modes(self.modes).centre / self.mechanism.end
        return np.asarray(own @ self.ends(t)[0])

    def gap(self, t: npt.ArrayLike) -> Array:
        """Gap function y(t) = u(1, t): 0 at contact, negative between; shape (len(t),)."""
        return np.asarray(self.ends(t)[0].sum(axis=0))

    def state(self, t: npt.ArrayLike) -> npt.NDArray[np.int64]:
        """The number of the valve's state, in the order of its states; shape (len(t),)."""
        return self._valve[self._after(array("t", t, -np.inf, np.inf))]

    def force(self, t: npt.ArrayLike) -> Array:
        """Force on the driven end, p_k − κu(0, t), with that of the chamber; shape (len(t),)."""
        at_driven = self.position(self.machine.body.place(self.machine.at), t)[0]
        return np.asarray(self.mechanism.forces[self.state(t)] - self.machine.valve.chamber.stiffness * at_driven)

    def energy(self, t: npt.ArrayLike, side: Side = "right") -> Array:
        """Kinetic and elastic energy of the bar, and that of the chamber, ½κu(0, t)²; shape (len(t),)."""
        q, rate = self.ends(t, side)
        m, speed = (q.T / self.mechanism.end).T, (rate.T / self.mechanism.end).T
        omega = self.machine.modes(self.modes).omega[:, None]
        return np.asarray(0.5 * (speed**2).sum(axis=0) + 0.5 * ((omega * m) ** 2).sum(axis=0))

    def _shapes(self, x: npt.ArrayLike) -> Array:
        places = array("x", x, 0.0, 1.0)
        return self.machine.modes(self.modes).at(self.machine.body, places) / self.mechanism.end

    def energy_balance(self, first: float | None = None, last: float | None = None) -> MachineBalance:
        """The energy that the valve put in and where it went, between two times (default: the whole motion)."""
        from percuss.simulate.machine.mechanism import machine_balance

        return machine_balance(self, first, last)

    # -- going on, files --

    def continued(
        self, stop: Stop | None = None, progress: Callable[[Progress], object] | None = None
    ) -> MachineTrajectory:
        """The same motion followed further, with the same bits as if it had never been interrupted.

        Parameters
        ----------
        stop
            The new rule; impacts and time count from the start of the motion, not from here. None: as many impacts
            again, whether a periodic motion is found or not.
        progress
            See `run_machine`.
        """
        pass

        callback("progress", progress)
        return replace(self, **ended_later(self, further(stop, self.stop, self.impacts), progress))

    def to_xarray(self) -> xarray.Dataset:
        """The event table, the states and all that is needed to go on, with names and units."""
        pass

        return to_dataset(self)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write a NetCDF file that `MachineTrajectory.load` reads."""
        from percuss.whole_file import write_dataset

        write_dataset(self.to_xarray(), checked_path("path", path))

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> MachineTrajectory:
        """The motion in a NetCDF file; `continued` goes on from it bit for bit.

        Raises
        ------
        PercussError
            When the file cannot be read or is not a motion of a machine.
        """
        pass
        from percuss.simulate.motion_files import opened

        return cls(**motion_from(*opened(path)))

    def __str__(self) -> str:
        changes = int(np.count_nonzero(self.events.code == VALVE))
        return (
            f"MachineTrajectory {self.label}: {self.impacts} impacts and {changes} changes of the valve in "
            f"{self.end_time - self.begin_time:.6g}, {self.modes} modes, ended by {self.outcome}"
        )


# ---- A motion of a machine followed further, with the same bits as if it had never been interrupted


class _Motion(Protocol):
    """What is asked of a motion; a `MachineTrajectory` has it."""

    @property
    def mechanism(self) -> Mechanism: ...
    @property
    def events(self) -> MachineEvents: ...
    @property
    def states(self) -> Array: ...
    @property
    def begin_time(self) -> float: ...
    @property
    def snapshot(self) -> dict[str, npt.NDArray[Any]]: ...


def ended_later(motion: _Motion, stop: Stop, progress: Callable[[Progress], object] | None = None) -> dict[str, Any]:
    """What `MachineTrajectory.continued` has otherwise than the motion it goes on from, by the names of fields."""
    numbers = motion.mechanism
    plant, room = put_back(motion.snapshot, numbers), room_for(numbers, stop)
    room.states[0] = motion.states[-1]
    with watched(progress) as watch:
        stretch = followed(plant, numbers, stop, room, motion.begin_time, watch)
    return {
        "events": MachineEvents.of_all([motion.events, stretch.events]),
        "states": np.concatenate([motion.states, stretch.states[1:]]),
        "stop": stop,
        **ending(stretch, numbers, stop, motion.begin_time),
    }


# ---- A motion of a machine as an xarray dataset and as a NetCDF file, from which it goes on bit for bit

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


class _SavedMotion(Protocol):
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


def to_dataset(motion: _SavedMotion) -> xarray.Dataset:
    """See `MachineTrajectory.to_xarray`."""
    variables: dict[str, Any] = {}
    for name, (_, unit, meaning) in _COLUMNS.items():
        variables[name] = ("event", getattr(motion.events, name), {"long_name": meaning, "units": unit})
    meaning = "gap, rigid velocity, amplitudes at the start and after each event"
    variables["bar_state"] = (("event_and_start", "state_number"), motion.states, {"long_name": meaning})
    for name, values in motion.snapshot.items():
        variables[f"engine_{name}"] = plain(name, values)
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
