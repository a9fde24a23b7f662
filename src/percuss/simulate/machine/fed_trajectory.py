"""A simulated motion of a machine that a pump and an accumulator feed: where the piston is, and the pressure."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from percuss.errors import ParameterError, PercussError
from percuss.model.checks import Array, array, choice, finite
from percuss.simulate.balance import panels
from percuss.simulate.machine.fed_flight import FedFlight, flight_of
from percuss.simulate.machine.machine_balance import MachineBalance
from percuss.simulate.machine.machine_trajectory import MachineTrajectory, Side

if TYPE_CHECKING:
    from collections.abc import Callable

    import xarray

    from percuss.simulate.engine import Progress
    from percuss.simulate.stop import Stop

__all__ = ["FedTrajectory"]

_ANEW = "call run_machine again with another stop; the events are an array for each quantity"


@dataclass(frozen=True)
class FedTrajectory(MachineTrajectory):
    """A simulated motion of a machine with a supply, as a `MachineTrajectory`; its piston is rigid.

    `states` are displacement, velocity and pressure after the start and after each event, shape (events + 1, 3).
    """

    def pressure(self, t: npt.ArrayLike) -> Array:
        """The pressure, as a multiple of that for which the forces of the states hold; shape (len(t),).

        Raises
        ------
        ParameterError
            For times outside the simulated ones.
        """
        return self._followed(t, "right")[2]

    def ends(self, t: npt.ArrayLike, side: Side = "right") -> tuple[Array, Array]:
        """Displacement and velocity at some times, each of shape (1, len(t))."""
        u, v, _ = self._followed(t, side)
        return u[None], v[None]

    def force(self, t: npt.ArrayLike) -> Array:
        """Force on the piston, with that of the chamber; shape (len(t),)."""
        u, _, pressure = self._followed(t, "right")
        valve = self.machine.valve
        oil = np.array([force for _, force in valve.pairs])[self.state(t)] * pressure
        return np.asarray(oil + valve.chamber.force - valve.chamber.stiffness * u)

    def energy(self, t: npt.ArrayLike, side: Side = "right") -> Array:
        """Energy of the piston, of the gas, ½κu², and of the accumulator, ½cπ²; shape (len(t),)."""
        u, v, pressure = self._followed(t, side)
        supply, gas = self.machine.valve.supply, self.machine.valve.chamber
        assert supply is not None
        return np.asarray(0.5 * v**2 + 0.5 * gas.stiffness * u**2 + 0.5 * supply.compliance * pressure**2)

    def energy_balance(self, first: float | None = None, last: float | None = None) -> MachineBalance:
        """What the pump put in, with the constant part of the chamber's force, and where it went between two times.

        `stored` has the energy of the accumulator in it.
        """
        begin = self.begin_time if first is None else finite("first", first)
        end = self.end_time if last is None else finite("last", last)
        if not self.begin_time <= begin <= end <= self.end_time:
            accepted = f"two times in order from {self.begin_time:.6g} to {self.end_time:.6g}"
            raise ParameterError("first, last", f"{begin:.6g}, {end:.6g}", accepted)
        inside = (self.events.time > begin) & (self.events.time <= end)
        edges = np.unique(np.concatenate([[begin], self.events.time[inside], [end]]))
        pumped = dragged = 0.0
        for a, b in pairwise(edges.tolist()):
            flight = self._from(a)
            pumped += flight.pumped(b - a)
            if flight.drag > 0.0 and not (flight.u == flight.v == flight.push == 0.0):
                t, w = panels(0.0, b - a, max(flight.spring**0.5, 1e-300), flight.drag)
                dragged += flight.drag * float(w @ flight.at(t)[1] ** 2)
        moved = np.diff(self.ends(np.array([begin, end]))[0][0])[0]
        taken = float(self.events.energy_lost[inside].sum())
        stored = self.energy(np.array([begin, end]))
        put_in = pumped + self.machine.valve.chamber.force * float(moved)
        return MachineBalance(put_in, dragged, taken, float(stored[1] - stored[0]))

    def continued(
        self, stop: Stop | None = None, progress: Callable[[Progress], object] | None = None
    ) -> MachineTrajectory:
        """Refused: a motion with a supply is followed anew, which takes some milliseconds for a blow.

        Raises
        ------
        PercussError
            Always.
        """
        raise PercussError("a motion of a machine with a supply does not go on", _ANEW)

    def to_xarray(self) -> xarray.Dataset:
        """Refused, as `continued`.

        Raises
        ------
        PercussError
            Always.
        """
        raise PercussError("a motion of a machine with a supply is not written to a file", _ANEW)

    def _from(self, time: float) -> FedFlight:
        """The flight from a time on; on the wall, one that stays there while the pump works."""
        u, v, pressure = (float(x[0]) for x in self._followed(np.array([time]), "right"))
        which = int(self._after(np.array([time]))[0])
        flight = self._flight(which, u, v, pressure)
        if self._lies[which]:
            return FedFlight(0.0, 0.0, pressure, 0.0, 0.0, 0.0, flight.drag, flight.flow, flight.compliance)
        return flight

    def _flight(self, which: int, u: float, v: float, pressure: float) -> FedFlight:
        state = self.events.states[int(self._valve[which])]
        return flight_of(self.machine, state, u, v, pressure)

    def _followed(self, t: npt.ArrayLike, side: Side) -> tuple[Array, Array, Array]:
        """Displacement, velocity and pressure."""
        choice("side", side, "left", "right")
        times = array("t", t, -np.inf, np.inf)
        last = self._after(times, side)
        found = np.zeros((3, times.size))
        for i in np.unique(last).tolist():
            here = np.flatnonzero(last == i)
            tau = np.maximum(times[here] - self._times[i], 0.0)
            u, v, pressure = self.states[i].tolist()
            flight = self._flight(i, u, v, pressure)
            if self._lies[i]:
                found[2, here] = pressure + flight.flow / flight.compliance * tau
                continue
            found[0, here], found[1, here] = flight.at(tau)
            found[2, here] = flight.pressures(tau, found[0, here])
        return found[0], found[1], found[2]
