"""The order of events in a cycle of a machine that switches its own valve, and the cycle as a problem for their times.

An `EventSequence` says in which order a machine strikes, passes its ports, and carries out its orders until all
repeats. It holds no number of a machine: the same one serves at every value of a parameter, until a test of it changes
its sign.
Whoever follows cycles, or looks for them, needs no more than this:

    sequence = sequence_of(cycle)                       # of any cycle without a rest
    x = sequence.unknowns(cycle)                        # the times of ports and blows, the last of them the period
    closed = sequence.closed(machine, modes, x)         # error (len(x),), its slope (len(x), len(x)) by x, the states
    found = sequence.cycle(machine, modes, x)           # the motion with these times, its `slope` and multipliers
    sequence.fault(found)                               # None, or the first thing that is not as the order says, proved
    sequence.tests(found)                               # what changes its sign where the order ends, by its name
    found.slope, found.multipliers                      # of the map from blow to blow: det(slope − 1) is 0 at a fold

`error` is 0 at a cycle. The machine may be any that has the states and ports named. The number of unknowns is that of
ports and blows, whatever the number of modes; the pressure of a supply follows from the times.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import pairwise
from typing import Literal, NamedTuple

import numpy as np

from percuss.errors import ParameterError
from percuss.mechanics.crossing import Regions, first_entering
from percuss.mechanics.cycle import Closed, Cycle, Timing
from percuss.mechanics.flow import ModalFlight, StateFlow, state_flows
from percuss.model import Machine, Valve
from percuss.model.checks import Array
from percuss.model.load.valve import Orders
from percuss.steady.self_excited.rhythm import Rhythm, followed, valve_after
from percuss.steady.self_excited.valve_cycle import ValveCycle, ValveFlight, cycle_told, place_row

_TOGETHER = 1e-12  # of the period: simultaneous events
_KINDS = {"blow": "impact", "due": "valve", "port": "port"}

FaultKind = Literal["order", "direction", "wall", "port", "pressure"]
"""What is not as the order of events says: events change their order; a port or the wall is met from the wrong side;
the bar strikes, or enters a port's region, at another time; the pressure of a supply falls to 0."""


class Fault(NamedTuple):
    """Why a motion is not one with its order of events, and when that shows."""

    kind: FaultKind
    time: float


class SequenceEvent(NamedTuple):
    """A port that demands, an order that is due, or a blow; the valve's state and last demand are those after it.

    `port` is the one passed, or for an order the one that demanded it, −1 for a blow. `source` is the number of the
    event, among ports and blows, at which an order was demanded, −1 for the blow at time 0, and of itself for others;
    `wrapped`: in the cycle before.
    """

    kind: Literal["port", "due", "blow"]
    port: int
    source: int
    wrapped: bool
    state: str
    last: str


class Waiting(NamedTuple):
    """An order that is pending at the blow that begins a cycle: its state, and where it comes from, as of an event."""

    state: str
    source: int
    port: int


# ---- What a machine may meet in a flight


Watched = tuple[ModalFlight, Regions, list[int]]
"""A flight, regions, and by what each is told: the number of a port, −1 for the wall and −2 for the pressure."""


def watched(machine: Machine, flow: StateFlow, flight: ValveFlight, wall: bool = True) -> list[Watched]:
    """The regions that mean something when entered: beyond the wall, no pressure, and ports that demand another state.

    Those of speeds are looked at in the flight of the velocities, apart from the others.
    """
    modes, rows, levels, drifts, which = flow.modes, [], [], [], []
    if wall:
        rows, levels, drifts, which = [modes.end], [0.0], [0.0], [-1]
    ports = [(i, port) for i, port in enumerate(machine.valve.ports) if port.sign != 0.0 and port.to != flight.last]
    for i, port in ports:
        if port.behind is not None:
            rows.append(port.sign * place_row(machine, modes, port.reads))
            levels.append(port.sign * port.level)
            drifts.append(0.0)
            which.append(i)
    if flow.ramp != 0.0:  # p u − q t − (c π + p u) at the start rises through 0 where the pressure falls through it
        size, place = abs(flow.draw), float(modes.driven @ flight.begin[:, 0])
        rows.append(flow.draw / size * modes.driven)
        levels.append((flow.compliance * flight.pressure + flow.draw * place) / size)
        drifts.append(flow.supplied / size)
        which.append(-2)
    scale = max((port.behind for port in machine.valve.ports if port.behind is not None), default=1.0)
    shape = (len(rows), modes.omega.size)
    found: list[Watched] = [
        (flight, Regions(np.array(rows).reshape(shape), np.array(levels), scale, np.array(drifts)), which)
    ]
    if fast := [(i, port, port.speed) for i, port in ports if port.speed is not None]:
        seen = np.array([port.sign * place_row(machine, modes, port.reads) for _, port, _ in fast])
        edges = np.array([speed for *_, speed in fast])
        found.append((flight.of_rates, Regions(seen, edges, edges.max(), 0.0 * edges), [i for i, *_ in fast]))
    return found


def first_met(machine: Machine, flow: StateFlow, flight: ValveFlight, wall: bool = True) -> tuple[float, int]:
    """When something that is `watched` is first entered in a flight, infinite for nothing, and which."""
    found = [(first_entering(one, regions), which) for one, regions, which in watched(machine, flow, flight, wall)]
    first, which = min(found, key=lambda one: one[0].time)
    return first.time, which[first.which] if first.which >= 0 else 0


# ---- The order of events


@dataclass(frozen=True)
class EventSequence:
    """The events of a cycle in order, after the blow at time 0; the last one is the blow that ends it.

    Parameters
    ----------
    state, last, waiting
        Of the valve at time 0, before the blow demands anything.
    events
        In order of time.
    """

    state: str
    last: str
    waiting: tuple[Waiting, ...]
    events: tuple[SequenceEvent, ...]

    # -- what it is called --

    @property
    def blows(self) -> int:
        """In a cycle."""
        return sum(event.kind == "blow" for event in self.events)

    @property
    def valve_cycles(self) -> int:
        """How often the valve goes through its states in a cycle: changes to the state it changes to most often."""
        changes = [event.state for event in self.events if event.kind == "due"]
        return max((changes.count(state) for state in set(changes)), default=0)

    @property
    def label(self) -> str:
        """Blows and valve cycles in a cycle: "1/1"."""
        return f"{self.blows}/{self.valve_cycles}"

    @property
    def drops(self) -> bool:
        """Whether an order is replaced before it is due."""
        asked = [self.last, *(event.last for event in self.events)]
        changes = sum(one != other for one, other in pairwise(asked))
        return changes > sum(event.kind == "due" for event in self.events)

    # -- the problem --

    def unknowns(self, cycle: ValveCycle) -> Array:
        """The times of ports and blows in a cycle with this order, shape (unknowns,)."""
        return np.array([time for time, _ in cycle.rhythm.guarded])

    def posed(self, machine: Machine, modes: int) -> Cycle:
        """The events as a machine has them: its flows, guards and delays."""
        return _posed(self, machine, modes)

    def closed(self, machine: Machine, modes: int, unknowns: Array) -> Closed:
        """What is left to close the motion with given times, its derivatives by them, and the states."""
        return self.posed(machine, modes).closed(unknowns)

    def cycle(self, machine: Machine, modes: int, unknowns: Array, closed: Closed | None = None) -> ValveCycle:
        """The motion with given times, which is a cycle where it closes; `fault` tells whether a machine does this."""
        posed = self.posed(machine, modes)
        closed = posed.closed(unknowns) if closed is None else closed
        flights, times = self._flights(posed, unknowns, closed), posed.times(unknowns)
        happened = []
        for event, flight, state in zip(self.events, flights, closed.states, strict=True):
            detail = event.state if event.kind == "due" else event.port
            happened.append((flight.time + flight.duration, _KINDS[event.kind], detail, *posed.parts(state)))
        guarded, delays = [0.0, *(times[i] for i in posed.guards)], [port.delay for port in machine.valve.ports]
        pending = tuple((guarded[one.source + 1] + delays[one.port] - times[-1], one.state) for one in self.waiting)
        slope = posed.slope(unknowns)
        if modes == 0:  # the piston is at the wall just after the blow
            slope = slope[1:, 1:]
        return cycle_told(machine, modes, self.state, Orders(self.last, pending), flights, happened, slope)

    def solved(self, machine: Machine, modes: int, unknowns: Array) -> ValveCycle | None:
        """The motion to which Newton's method leads from given times; None where it leads nowhere."""
        found = self.posed(machine, modes).root(unknowns)
        return None if found is None else self.cycle(machine, modes, *found)

    def _flights(self, posed: Cycle, unknowns: Array, closed: Closed) -> tuple[ValveFlight, ...]:
        found, state, last, time, begin = [], self.state, self.last, 0.0, closed.start
        for i, (event, end) in enumerate(zip(self.events, posed.times(unknowns).tolist(), strict=True)):
            flow, (start, pressure) = posed.flows[i], posed.parts(begin)
            found.append(
                ValveFlight(
                    modes=flow.modes,
                    begin=start,
                    force=flow.force(start[:, 0], pressure),
                    ramp=flow.ramp,
                    duration=end - time,
                    state=state,
                    last=last,
                    time=time,
                    pressure=pressure,
                )
            )
            state, last, time = event.state, event.last, end
            begin = posed.after(i, closed.states[i])
        return tuple(found)

    # -- whether a machine does this --

    def fault(self, cycle: ValveCycle) -> Fault | None:
        """The first thing in a motion that is not as this order says, proved to be the first; None for none."""
        machine, flights = cycle.machine, cycle.flights
        times = np.array([flight.time + flight.duration for flight in flights])
        late = np.diff(times, prepend=0.0)
        if np.any(late < -_TOGETHER * times[-1]):
            return Fault("order", float(times[late < 0.0][0]))
        if (slow := self._slow(cycle)) is not None:
            return Fault("direction", slow)
        flows = state_flows(machine, cycle.modes)
        for flight in flights:
            if flight.pressure < 0.0:
                return Fault("pressure", flight.time)
            time, which = first_met(machine, flows[flight.state], flight)
            if time < np.inf:
                kind: FaultKind = {-1: "wall", -2: "pressure"}.get(which, "port")  # type: ignore[assignment]
                return Fault(kind, flight.time + time)
        return None

    def _slow(self, cycle: ValveCycle) -> float | None:
        """When the wall or the edge of a port is not met in the way that counts."""
        return next((time for time, speed in sorted(self._speeds(cycle).values()) if not speed > 0.0), None)

    def _speeds(self, cycle: ValveCycle) -> dict[str, tuple[float, float]]:
        """When and how fast the wall and the edges of ports are met, in the way that counts, by the names of tests."""
        machine = cycle.machine
        found = {f"blow {i}": (blow.time, blow.speed) for i, blow in enumerate(cycle.struck)}
        flights = [flight for event, flight in zip(self.events, cycle.flights, strict=True) if event.kind == "port"]
        for i, (one, flight) in enumerate(zip(cycle.uncoverings, flights, strict=True)):
            port, rate = machine.valve.ports[one.port], -one.velocity
            if port.speed is not None:
                rate = float(place_row(machine, flight.modes, port.reads) @ flight.of_rates.end[:, 1])
            found[f"port {i}"] = one.time, port.sign * rate
        return found

    def tests(self, cycle: ValveCycle) -> dict[str, float]:
        """What is above 0 in a cycle of a machine with this order, and changes its sign where the order ends.

        Looked at, not proved; `fault` proves. By their names, i being a number from 0 on:

        "blow i"
            Speed of a blow: a grazing, where it falls to 0 with the wall pulled away from, or the begin of a rest.
        "port i"
            Rate of what a port reads at its edge, in order of time: the piston turns at the port.
        "order i"
            Time from event i − 1 to event i, where nothing fixes it: two events change places.
        "wall i", "edge i.j"
            How far the striking end in flight i is from touching the wall, or from the region of port j: a double blow,
            or a demand more.
        "pressure i"
            The same of the pressure of a supply and 0, as a way of the driven place.
        """
        found = {name: speed for name, (_, speed) in self._speeds(cycle).items()}
        flows = state_flows(cycle.machine, cycle.modes)
        for i, (event, flight) in enumerate(zip(self.events, cycle.flights, strict=True)):
            at_once = event.kind == "due" and cycle.machine.valve.ports[event.port].delay == 0.0
            if not at_once:
                found[f"order {i}"] = flight.duration
            met = -1 if event.kind == "blow" else event.port if event.kind == "port" else None
            for one, regions, which in watched(cycle.machine, flows[flight.state], flight):
                for number, apart in zip(which, clearances(one, regions, which, met), strict=True):
                    name = {-1: f"wall {i}", -2: f"pressure {i}"}.get(number, f"edge {i}.{number}")
                    found[name] = apart
        return found


_LOOKS, _LOOKS_A_MODE = 24, 8  # in a flight
_TURN_STEPS = 4  # of Newton's method to where a place turns


def clearances(flight: ModalFlight, regions: Regions, which: list[int], met: int | None) -> list[float]:
    """How far each region is from being entered in a flight that ends where the one with the number `met` is.

    Between two turns r rises from a least to a greatest value; it enters where these have different signs, and is about
    to where one of them is 0: max(least, −greatest), the least of all rises. Infinite where r never rises.
    """
    modes, found = flight.modes, []
    times = np.linspace(0.0, flight.duration, _LOOKS + _LOOKS_A_MODE * modes.size)
    _, seen = flight.moved(times)
    for row, level, drift, number in zip(regions.rows, regions.levels, regions.drifts, which, strict=True):
        rate = row @ seen - drift
        turns = np.flatnonzero(rate[:-1] * rate[1:] < 0.0)
        t = times[turns] + (times[turns + 1] - times[turns]) * rate[turns] / (rate[turns] - rate[turns + 1])
        for _ in range(_TURN_STEPS if t.size else 0):
            u, v = flight.at(t)
            force = flight.force + flight.ramp * t
            a = modes.driven[:, None] * force - modes.omega[:, None] ** 2 * u - modes.damping[:, None] * v
            step = np.clip((row @ v - drift) / (row @ a), times[turns] - t, times[turns + 1] - t)
            t = np.clip(t - step, times[turns], times[turns + 1])
        t = np.concatenate([[0.0], t, [flight.duration]])
        r = row @ flight.at(t)[0] - level - drift * t
        low, high = r[:-1], r[1:]
        rises = high > low
        if number == met:
            rises[-1] = False
        found.append(float(np.min(np.maximum(low, -high)[rises], initial=np.inf)))
    return found


def sequence_of(cycle: ValveCycle) -> EventSequence:
    """The order of events of a cycle.

    Raises
    ------
    ParameterError
        When it rests on the wall: it is no problem for times then.
    """
    found = None if cycle.rests else sequence_in(cycle.machine.valve, cycle.rhythm)
    if found is None:
        raise ParameterError("cycle", str(cycle), "a cycle without a rest on the wall")
    return found


def sequence_in(valve: Valve, rhythm: Rhythm) -> EventSequence | None:
    """The order of events in a rhythm, by the rules of the valve; None when its end is not its beginning."""
    steps, now = followed(valve, rhythm)
    ends, begins = now.orders, rhythm.orders
    if [to for _, to in ends.pending] != [to for _, to in begins.pending]:
        return None
    if (now.state, ends.last) != (rhythm.state, begins.last):
        return None
    sources = [now.sources[order] for order in ends.pending]  # of those that the cycle began with, a cycle later
    if any(wrapped for *_, wrapped in sources):  # longer than a cycle
        return None
    traced = [(source, port) for source, port, _ in sources]
    events = []
    for kind, _, port, source, wrapped, state, last in steps:
        if wrapped:
            source, port = traced[source]
        events.append(SequenceEvent(kind, port, source, wrapped, state, last))
    waiting = tuple(Waiting(to, *one) for (_, to), one in zip(ends.pending, traced, strict=True))
    return EventSequence(rhythm.state, begins.last, waiting, tuple(events))


_REPEATS = 4  # of a cycle, until its valve begins as it ends


def reordered(valve: Valve, rhythm: Rhythm) -> Rhythm | None:
    """A rhythm whose events are in another order than its valve begins with; None for none that repeats."""
    for _ in range(_REPEATS):
        last, asking = rhythm.orders.last, []
        for event in followed(valve, rhythm)[0]:
            if event.kind == "port" and event.last != last:
                asking.append((event.time, event.port))
            last = event.last
        rhythm = replace(rhythm, passages=tuple(asking))
        now = valve_after(valve, rhythm)
        found = replace(rhythm, state=now.state, orders=now.orders)
        if sequence_in(valve, found) is not None:
            return found
        rhythm = found
    return None


@lru_cache(maxsize=64)
def _posed(sequence: EventSequence, machine: Machine, modes: int) -> Cycle:
    valve, contact, flows = machine.valve, machine.contact, state_flows(machine, modes)
    states, rows, levels, timings = [sequence.state], [], [], []
    for event in sequence.events:
        own, port = flows[states[-1]].modes, valve.ports[event.port] if event.kind != "blow" else None
        met = port if event.kind == "port" else None
        row, part = (place_row(machine, own, met.reads), int(met.speed is not None)) if met else (own.end, 0)
        rows.append(row[:, None] * np.eye(2)[part])
        levels.append(met.level if met else 0.0)
        later = port.delay if port and event.kind == "due" else 0.0
        timings.append(Timing(event.source, later, event.wrapped, event.kind != "due", event.kind == "blow"))
        states.append(event.state)
    turn = np.array([contact.strain_factor, contact.velocity_factor])
    return Cycle([flows[state] for state in states[:-1]], turn, timings, rows, np.array(levels))
