"""A rigid piston that a pump and an accumulator feed, followed from event to event."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from percuss.errors import ParameterError
from percuss.model import Machine
from percuss.model.load.valve import Orders
from percuss.simulate.engine import Progress
from percuss.simulate.kernels.codes import IMPACT, PORT, RELEASE, REST, VALVE
from percuss.simulate.machine.fed_flight import FedFlight, Watch, first_passage, flight_of
from percuss.simulate.machine.fed_returns import Blow, cycle_in
from percuss.simulate.machine.fed_trajectory import FedTrajectory
from percuss.simulate.machine.machine_events import MachineEvents
from percuss.simulate.machine.machine_start import MachineStart, placed, state_and_orders
from percuss.simulate.machine.machine_summary import MachineCycle, machine_label
from percuss.simulate.machine.mechanism import mechanism
from percuss.simulate.stop import Stop

__all__ = ["run_fed"]

_CHATTER = 1e-10  # of the fastest blow: a slower rebound at a wall to which the valve pushes is at rest
_TOGETHER = 1e-12  # of a flight: an event this little after an order is due comes before it
_MOST_SWITCHES = 1000  # without a blow, in next to no time
_MANY = 60  # blows without a cycle that tell an irregular motion


@dataclass
class _Going:
    """The piston on its way."""

    machine: Machine
    u: float
    v: float
    pressure: float
    state: str
    orders: Orders
    time: float = 0.0
    lies: bool = False
    fastest: float = 0.0
    events: list[tuple[float, ...]] = field(default_factory=list)
    rows: list[tuple[float, float, float]] = field(default_factory=list)
    blows: list[Blow] = field(default_factory=list)
    rested: bool = False

    def __post_init__(self) -> None:
        valve = self.machine.valve
        self.names = [name for name, _ in valve.pairs]
        self.entered = [i for i, port in enumerate(valve.ports) if port.behind is not None]
        self.wall = Watch(0.0, 1.0, 0.0, 1.0)
        self.edges = [
            Watch(port.behind, 1.0, 0.0, -1.0 if port.side == "back" else 1.0)
            for port in valve.ports
            if port.behind is not None
        ]

    @property
    def flight(self) -> FedFlight:
        return flight_of(self.machine, self.state, self.u, self.v, self.pressure)

    def record(self, code: int, before: float, after: float, lost: float = 0.0, port: int = -1) -> None:
        kinetic = 0.5 * before * before if code == IMPACT else 0.0
        state = self.names.index(self.state)
        self.events.append((float(code), self.time, before, after, lost, kinetic, float(state), float(port)))
        self.rows.append((self.u, self.v, self.pressure))

    def demand(self, number: int) -> None:
        """A port demands its state."""
        before, self.orders = self.orders, self.orders.after(self.time, self.machine.valve.ports[number])
        if self.orders is not before:
            self.record(int(PORT), self.v, self.v, port=number)
        self.carry_out()

    def carry_out(self) -> None:
        """Changes the state by the orders that are due."""
        while self.orders.pending and self.orders.pending[0][0] <= self.time:
            self.state = self.orders.pending[0][1]
            self.orders = Orders(self.orders.last, self.orders.pending[1:])
            self.record(int(VALVE), self.v, self.v)

    def next_event(self, until: float) -> str:
        """Goes on to the next event, or to a time; what ended the motion, or nothing."""
        self.carry_out()
        due = self.orders.pending[0][0] if self.orders.pending else math.inf
        stop, flight = min(due, until), self.flight
        if self.u == 0.0 and self.v == 0.0 and (flight.push > 0.0 or (flight.push == 0.0 and flight.ramp >= 0.0)):
            return self._lie(flight, stop, until)
        if self.lies:
            self.lies = False
            self.record(int(RELEASE), 0.0, 0.0)
        watched = [self.wall, *self.edges]
        if flight.force != 0.0:  # the accumulator
            c = flight.compliance
            watched.append(Watch(self.pressure + flight.force * self.u / c, -flight.force / c, flight.flow / c, -1.0))
        duration = (stop - self.time) * (1.0 + _TOGETHER)
        found = first_passage(flight, watched, duration, mechanism(self.machine, 0).unit)
        if found is None and stop == math.inf:
            return "leaves" if self._leaves(flight) else "in the chamber"
        self._fly(flight, stop, None if found is None else found.time)
        if found is None:
            return "time" if self.time >= until and due > until else ""
        if found.which == 0:
            self._strike()
        elif found.which <= len(self.edges):
            self.u = -float(self.machine.valve.ports[self.entered[found.which - 1]].behind or 0.0)
            self.demand(self.entered[found.which - 1])
        else:
            return "without pressure"
        return ""

    def _leaves(self, flight: FedFlight) -> bool:
        return flight.drifts < 0.0 or flight.spring == 0.0

    def _lie(self, flight: FedFlight, stop: float, until: float) -> str:
        """On the wall until an order is due, a growing pressure lifts the piston, or for ever."""
        if not self.lies:
            self.lies = self.rested = True
            self.record(int(REST), 0.0, 0.0)
        growth = flight.flow / flight.compliance
        lifted = self.time + flight.push / -flight.ramp if flight.ramp < 0.0 else math.inf
        if min(stop, lifted) == math.inf:
            return "on the tool"
        if lifted < stop:
            self.pressure = -flight.gas / flight.force
            while self.flight.push > 0.0:
                self.pressure = math.nextafter(self.pressure, math.inf)
            self.time = lifted
            return ""
        self.pressure += growth * (stop - self.time)
        self.time = stop
        return "time" if stop >= until else ""

    def _fly(self, flight: FedFlight, stop: float, duration: float | None) -> None:
        spent = stop - self.time if duration is None else duration
        self.u, self.v = flight.at_time(spent)
        self.pressure += (flight.flow * spent - flight.force * (self.u - flight.u)) / flight.compliance
        self.time = stop if duration is None else self.time + duration

    def _strike(self) -> None:
        contact, before = self.machine.contact, self.v
        self.u, self.v = 0.0, contact.velocity_factor * before
        self.fastest = max(self.fastest, before)
        lost = 0.5 * (before**2 - self.v**2)
        self.record(int(IMPACT), before, self.v, lost)
        pushed = self.flight.push > 0.0
        if pushed and abs(self.v) < _CHATTER * self.fastest:
            self.v = 0.0
        orders = [(due - self.time, to) for due, to in self.orders.pending]
        label = (self.state, self.orders.last, *(to for _, to in orders))
        numbers = np.array([before / max(self.fastest, 1e-300), self.pressure, *(due for due, _ in orders)])
        self.blows.append(Blow(self.time, before, lost, label, numbers, len(self.events), self.rested))
        self.rested = False
        for i, port in enumerate(self.machine.valve.ports):
            if port.on == "impact":
                self.demand(i)


def run_fed(
    machine: Machine, start: MachineStart, stop: Stop, progress: Callable[[Progress], object] | None
) -> FedTrajectory:
    """Follow a machine with a supply; see `run_machine`."""
    state, orders = state_and_orders(start, machine)
    u, v, _ = placed(start, machine, 0)
    begin, supply = start.bar.time, machine.valve.supply
    assert supply is not None
    if np.size(u) > 1 and (np.any(u[1:]) or np.any(v[1:])):
        raise ParameterError("start", "elastic modes", "a rigid start, for a machine whose pressure follows it")
    going = _Going(machine, float(u[0]), float(v[0]), supply.start, state, orders)
    first, resting = (going.u, going.v, going.pressure), going.u == going.v == 0.0 and going.flight.push > 0.0
    going.lies = resting
    if start.orders is None:
        _occupied(going)
    ended, cycle = _followed(going, stop, progress)
    return _made(going, stop, begin, first, state, resting, ended, cycle)


def _occupied(going: _Going) -> None:
    """Ports whose region is occupied at the start demand at once."""
    push, ports = going.flight.push - going.flight.drag * going.v, going.machine.valve.ports
    outwards = going.v < 0.0 or (going.v == 0.0 and push < 0.0)
    for i in going.entered:
        edge = -float(ports[i].behind or 0.0)
        inside = going.u < edge or (going.u == edge and outwards)
        if inside == (ports[i].side == "back"):
            going.demand(i)


def _followed(
    going: _Going, stop: Stop, progress: Callable[[Progress], object] | None
) -> tuple[str, MachineCycle | None]:
    until = math.inf if stop.time is None else stop.time
    cycle, idle, struck = None, 0, 0
    while len(going.blows) < stop.most_impacts:
        events, now = len(going.events), going.time
        ended = going.next_event(until)
        idle = 0 if going.time > now or len(going.events) == events else idle + 1
        if ended or idle > _MOST_SWITCHES:
            return ended or "on a port", cycle
        if len(going.blows) > struck:
            struck = len(going.blows)
            cycle = cycle_in(going.blows, going.events, stop.tolerance)
            if cycle is not None and stop.periodic:
                return "periodic", cycle
            if progress is not None and progress(_gone(going, stop)):
                return "cancelled", cycle
    return "impacts", cycle


def _gone(going: _Going, stop: Stop) -> Progress:
    fraction = len(going.blows) / max(stop.most_impacts, 1)
    if stop.time is not None:
        fraction = max(fraction, going.time / stop.time)
    return Progress(len(going.blows), going.time, min(fraction, 1.0))


def _made(
    going: _Going, stop: Stop, begin: float, first: tuple[float, float, float], state: str, resting: bool,
    ended: str, cycle: MachineCycle | None,
) -> FedTrajectory:  # fmt: skip
    from percuss.simulate.machine.machine_summary import STALLS

    columns = np.array(going.events, dtype=float).reshape(-1, 8).T
    events = MachineEvents(
        code=columns[0].astype(np.int8),
        time=begin + columns[1],
        velocity=columns[2],
        rebound_velocity=columns[3],
        energy_lost=columns[4],
        kinetic_energy=columns[5],
        state=columns[6].astype(np.int64),
        port=columns[7].astype(np.int64),
        resolved=np.zeros(columns.shape[1], dtype=np.int64),
        states=tuple(going.names),
    )
    known = stop.time if stop.time is not None and (ended == "time" or ended in STALLS) else going.time
    return FedTrajectory(
        machine=going.machine,
        modes=0,
        events=events,
        states=np.array([first, *going.rows]),
        first_state=going.names.index(state),
        resting=resting,
        outcome="stalls" if ended in STALLS else ended,
        label=machine_label(ended, cycle, cycle is None and len(going.blows) > _MANY),
        cycle=cycle,
        stop=stop,
        begin_time=begin,
        end_time=max(begin + known, float(events.time[-1]) if len(events) else begin),
        snapshot={},
    )
