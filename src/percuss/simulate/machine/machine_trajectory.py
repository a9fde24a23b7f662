"""A simulated motion of a machine: what happened, and where the bar is at any time."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
import numpy.typing as npt

from percuss.errors import ParameterError
from percuss.model import Machine
from percuss.model.checks import Array, array, callback, choice, finite, unit_interval
from percuss.model.checks import path as checked_path
from percuss.shown import Shown
from percuss.simulate.kernels.codes import CHATTER, IMPACT, RELEASE, REST, VALVE
from percuss.simulate.machine.machine_events import MachineEvents
from percuss.simulate.machine.machine_flight import flight
from percuss.simulate.machine.machine_summary import MachineCycle
from percuss.simulate.machine.mechanism import Mechanism, mechanism
from percuss.simulate.stop import Stop, further

if TYPE_CHECKING:
    import xarray

    from percuss.simulate.engine import Progress
    from percuss.simulate.machine.machine_balance import MachineBalance

__all__ = ["MachineTrajectory"]

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
        from percuss.simulate.machine.machine_balance import machine_balance

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
        from percuss.simulate.machine.machine_going_on import ended_later

        callback("progress", progress)
        return replace(self, **ended_later(self, further(stop, self.stop, self.impacts), progress))

    def to_xarray(self) -> xarray.Dataset:
        """The event table, the states and all that is needed to go on, with names and units."""
        from percuss.simulate.machine.machine_file import to_dataset

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
        from percuss.simulate.machine.machine_file import motion_from
        from percuss.simulate.motion_files import opened

        return cls(**motion_from(*opened(path)))

    def __str__(self) -> str:
        changes = int(np.count_nonzero(self.events.code == VALVE))
        return (
            f"MachineTrajectory {self.label}: {self.impacts} impacts and {changes} changes of the valve in "
            f"{self.end_time - self.begin_time:.6g}, {self.modes} modes, ended by {self.outcome}"
        )
