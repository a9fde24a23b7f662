"""An elastic machine followed from a start, event by event, each of them proved to be the next one.

Cycles are solved for, not simulated; this tells which order of events a machine settles in when that of its rigid
piston is not it, and what goes on after a rest.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from percuss.model import Machine, MachineModes
from percuss.model.checks import Array
from percuss.model.load.valve import Orders
from percuss.steady.self_excited.elastic_chain import place_row
from percuss.steady.self_excited.first_entering import Regions, first_entering
from percuss.steady.self_excited.modal_flight import ModalFlight, energy_of, rates
from percuss.steady.self_excited.rhythm import Rhythm, rhythm_of

__all__ = ["Following", "Laid", "watched"]

_CHATTER = 1e-9  # of the greatest speed: a slower rebound at a wall to which the valve pushes is at rest
_MOST_EVENTS = 60  # of a flight from blow to blow
_QUARTER = 0.3  # of the time in which a chamber turns a released machine round, in radians of its frequency
_LONGEST = 16.0  # flights without an event, in periods of the rigid piston


def watched(machine: Machine, modes: MachineModes, last: str, wall: bool = True) -> tuple[Regions, list[int]]:
    """The regions that mean something when entered: beyond the wall, and those of ports that demand another state."""
    rows, levels, ports = ([modes.end], [0.0], [-1]) if wall else ([], [], [])
    for i, port in enumerate(machine.valve.ports):
        if port.behind is not None and port.to != last:
            sign = -1.0 if port.side == "back" else 1.0
            rows.append(sign * place_row(machine, modes, port.reads))
            levels.append(-sign * port.behind)
            ports.append(i)
    scale = max((port.behind for port in machine.valve.ports if port.behind is not None), default=1.0)
    return Regions(np.array(rows), np.array(levels), scale), ports


class Laid(NamedTuple):
    """When a rest began, after some change of the valve, and how many flights and events there were before.

    `losses`: how many times the bar has lain down, this one counted.
    """

    time: float
    flights: int
    events: int
    losses: int


class Following:
    """A machine on its way; `ending` is None for as long as it goes on.

    Parameters
    ----------
    machine, count
        The machine, and N.
    begin
        Displacements and velocities of the coordinates just after a blow, or at rest on the wall; shape (N + 1, 2).
    state, orders
        Of the valve.
    period
        Roughly the time between blows.
    """

    def __init__(self, machine: Machine, count: int, begin: Array, state: str, orders: Orders, period: float) -> None:
        self.machine, self.modes = machine, machine.modes(count)
        self.now, self.state, self.orders, self.time = begin, state, orders, 0.0
        self.begin = state, orders
        self.span = _LONGEST * period
        self.greatest = 0.0
        self.ending: str | None = None
        self.flights: list[ModalFlight] = []
        self.events: list[tuple[float, str, object]] = []
        self.states: list[Array] = []  # just before each event
        self.blows = 0
        self.rests: list[Laid] = []
        self.losses: list[float] = []  # energy that the bar had whenever it lay down
        self._turn = np.array([machine.contact.strain_factor, machine.contact.velocity_factor])
        self._hold = -math.inf  # until when no contact is looked for after a release
        self._struck()

    def go_on(self, blows: int) -> None:
        """So many blows more, unless it ends before."""
        wanted = self.blows + blows
        while self.ending is None and self.blows < wanted:
            self._to_blow()

    def _to_blow(self) -> None:
        before = self.blows
        for _ in range(_MOST_EVENTS):
            self._carry_out()
            until = self.orders.pending[0][0] - self.time if self.orders.pending else self.span
            held = self._hold > self.time
            until = min(until, self._hold - self.time) if held else until
            regions, ports = watched(self.machine, self.modes, self.orders.last, wall=not held)
            force = self.machine.valve.force(self.state)
            flight = ModalFlight(self.modes, self.state, self.orders.last, force, self.time, until, self.now)
            found = first_entering(flight, regions)
            if math.isinf(found.time) and not self.orders.pending and until == self.span:
                self.ending = "nothing follows"
                return
            flight = replace(flight, duration=min(found.time, until))
            self.flights.append(flight)
            self.now, self.time = flight.end, self.time + flight.duration
            if math.isinf(found.time):
                if self.orders.pending and until != self._hold - flight.time:
                    self.time = self.orders.pending[0][0]
            elif ports[found.which] < 0:
                self._strike()
            else:
                self._demand(ports[found.which])
            if self.blows > before or self.ending is not None:
                return
        self.ending = "no blow"

    def _carry_out(self) -> None:
        while self.orders.pending and self.orders.pending[0][0] <= self.time:
            (_, self.state), *left = self.orders.pending
            self.orders = replace(self.orders, pending=tuple(left))
            if self.machine.valve.force(self.state) > 0.0:
                self._hold = -math.inf
            self._happened("valve", self.state)

    def _demand(self, number: int) -> None:
        before, self.orders = self.orders, self.orders.after(self.time, self.machine.valve.ports[number])
        if self.orders is not before:
            self._happened("port", number)

    def _strike(self) -> None:
        speed = float(self.modes.end @ self.now[:, 1])
        self._happened("impact", speed)
        self.greatest, self.blows = max(self.greatest, speed), self.blows + 1
        self.now = self._turn * self.now
        self._struck()

    def _struck(self) -> None:
        """The blow demands; a bar that leaves with hardly any speed lies down where it is pushed on or back at once."""
        for i, port in enumerate(self.machine.valve.ports):
            if port.on == "impact":
                self._demand(i)
        self._carry_out()
        speed, force = -float(self.modes.end @ self.now[:, 1]), self.machine.valve.force(self.state)
        if speed <= _CHATTER * self.greatest:
            back = float(self.modes.end @ rates(self.modes, self.now, force)[:, 1])
            if force > 0.0 or back >= 0.0:
                self._rest()

    def _rest(self) -> None:
        """Lies on the wall until the valve pulls, and leaves it undeformed.

        The striking end of finitely many modes moves at once, not after the time of a wave; so no contact is looked for
        while the valve pulls, or, against a chamber, for a part of its time.
        """
        since = self.rests[-1].events if self.rests else 0
        if any(kind == "valve" for _, kind, _ in self.events[since:]):
            self.rests.append(Laid(self.time, len(self.flights), len(self.events), len(self.losses) + 1))
        self.losses.append(energy_of(self.modes, self.now))
        self.now = 0.0 * self.now
        while self.machine.valve.force(self.state) > 0.0:
            if not self.orders.pending:
                self.ending = "on the wall"
                return
            begun, self.time = self.time, self.orders.pending[0][0]
            lying = ModalFlight(self.modes, self.state, self.orders.last, 0.0, begun, self.time - begun, self.now)
            self.flights.append(lying)
            self._carry_out()
        slowest, wave = float(self.modes.omega[0]), self.machine.body.transit_time
        self._hold = math.inf if slowest == 0.0 else self.time + max(wave, _QUARTER / slowest)

    def _happened(self, kind: str, detail: object) -> None:
        self.events.append((self.time, kind, detail))
        self.states.append(self.now)

    def rhythm(self, blows: int) -> Rhythm:
        """That of the last blows."""
        return rhythm_of(self.machine.valve, self.begin, self.events, blows)
