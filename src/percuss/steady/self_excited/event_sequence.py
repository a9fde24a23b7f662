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
from percuss.mechanics.crossing import Regions, clearances, first_entering
from percuss.mechanics.cycle import Closed, Cycle, Timing
from percuss.mechanics.flow import ModalFlight, StateFlow, state_flows
from percuss.model import Machine, MachineModes, Valve
from percuss.model.checks import Array
from percuss.model.load.valve import Orders, port_at
from percuss.model.machine import check_closed_form
from percuss.steady.self_excited.cycle_times import CycleTimes, followed, valve_after
from percuss.steady.self_excited.valve_cycle import (
    ValveCycle,
    ValveFlight,
    cycle_label,
    cycle_told,
    place_row,
    strain_of,
)

_TOGETHER = 1e-12  # of the period: simultaneous events
_SHORT = 1e-4  # of the period: flights of a chatter that are not looked into
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
    `wrapped`: how many cycles before. `laid`: a blow lays the bar down, undeformed; `lies`: it stays on the wall.
    """

    kind: Literal["port", "due", "blow"]
    port: int
    source: int
    wrapped: int
    state: str
    last: str
    laid: bool = False
    lies: bool = False


class Waiting(NamedTuple):
    """An order that is pending at the blow that begins a cycle: its state, and where it comes from, as of an event."""

    state: str
    source: int
    port: int
    wrapped: int


# ---- What a machine may meet in a flight


Watched = tuple[ModalFlight, Regions, list[int]]
"""A flight, regions, and by what each is told: the number of a port, −1 for the wall and −2 for the pressure."""


def watched(machine: Machine, flow: StateFlow, flight: ValveFlight, wall: bool = True) -> list[Watched]:
    """The regions that mean something: beyond the wall, no pressure, and ports that demand another state."""
    # Those of speeds are looked at in the flight of the velocities, apart from the others.
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
        return cycle_label(self.blows, self.valve_cycles, len(self.lying))

    @property
    def lying(self) -> tuple[int, ...]:
        """Numbers of the blows after which the bar lies on the wall."""
        return tuple(i for i, blow in enumerate(one for one in self.events if one.kind == "blow") if blow.laid)

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
        flights, times = self._flights(machine, posed, unknowns, closed), posed.times(unknowns, closed.delays)
        happened = []
        for event, flight, state in zip(self.events, flights, closed.states, strict=True):
            detail = event.state if event.kind == "due" else event.port
            happened.append((flight.time + flight.duration, _KINDS[event.kind], detail, *posed.parts(state)))
        given = [(0.0, closed.start), *((times[i], closed.states[i]) for i in posed.guards)]
        pending = []
        for one in self.waiting:
            time, at = given[one.source + 1]
            delay = port_at(machine.valve, one.port, posed.parts(at)[1]).delay
            pending.append((time + delay - one.wrapped * times[-1], one.state))
        slope = posed.slope(unknowns)
        if modes == 0:  # the piston is at the wall just after the blow
            slope = slope[1:, 1:]
        taken = 0.0
        for i, event in enumerate(self.events):
            if event.laid:
                bar = posed.turn * posed.parts(closed.states[i])[0]
                taken += 0.5 * float(bar[:, 1] @ bar[:, 1]) + strain_of(posed.flows[i], bar)
        orders = Orders(self.last, tuple(pending))
        return cycle_told(machine, modes, self.state, orders, flights, happened, slope, self.lying, taken)

    def solved(self, machine: Machine, modes: int, unknowns: Array) -> ValveCycle | None:
        """The motion to which Newton's method leads from given times; None where it leads nowhere."""
        found = self.posed(machine, modes).root(unknowns)
        return None if found is None else self.cycle(machine, modes, *found)

    def _flights(self, machine: Machine, posed: Cycle, unknowns: Array, closed: Closed) -> tuple[ValveFlight, ...]:
        struck = [port.to for port in machine.valve.ports if port.on == "impact"][-1:]  # what a blow demands last
        found, state, last, time, begin = [], self.state, [self.last, *struck][-1], 0.0, closed.start
        times = posed.times(unknowns, closed.delays).tolist()
        wave = hold = -np.inf
        for i, (event, end) in enumerate(zip(self.events, times, strict=True)):
            flow, (start, pressure) = posed.flows[i], posed.parts(begin)
            before = self.events[i - 1]
            if not before.lies and (before.laid or (before.kind == "due" and self.events[i - 2].lies)):
                wave, hold = (time + one for one in hold_after_release(machine, flow.modes))
            elif before.kind == "due" and machine.valve.force(state) > 0.0:
                hold = min(hold, wave)
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
                    held=max(min(hold, end) - time, 0.0),
                    pressure=pressure,
                )
            )
            state, time = event.state, end
            last = struck[0] if struck and event.kind == "blow" else event.last
            begin = posed.after(i, closed.states[i])
        return tuple(found)

    # -- whether a machine does this --

    def fault(self, cycle: ValveCycle, early: float = 0.0) -> Fault | None:
        """The first thing in a motion that is not as this order says, proved to be the first; None for none."""
        machine, flights = cycle.machine, cycle.flights
        times = np.array([flight.time + flight.duration for flight in flights])
        late = np.diff(times, prepend=0.0)
        if np.any(late < -_TOGETHER * times[-1]):
            return Fault("order", float(times[late < 0.0][0]))
        if (slow := self._slow(cycle)) is not None:
            return Fault("direction", slow)
        flows = state_flows(machine, cycle.modes)
        for i, flight in enumerate(flights):
            if flight.pressure < 0.0:
                return Fault("pressure", flight.time)
            if flight.lies:
                if not flows[flight.state].force(flight.begin[:, 0], flight.pressure) > 0.0:
                    return Fault("order", flight.time)
                continue
            if self._ends_a_chatter(i, flight, times[-1]):
                continue
            seen = replace(
                flight, duration=flight.duration * (1.0 - early)
            )  # a guard at its end may be met by rounding
            for part, wall in parts(seen, flows[flight.state]):
                time, which = first_met(machine, flows[flight.state], part, wall)
                if time < np.inf:
                    kind: FaultKind = {-1: "wall", -2: "pressure"}.get(which, "port")  # type: ignore[assignment]
                    return Fault(kind, part.time + time)
        return None

    def _ends_a_chatter(self, number: int, flight: ValveFlight, period: float) -> bool:
        """Whether a flight is one of the last of a chatter, in which rounding would decide whether it is one."""
        bounces = self.events[number].kind == self.events[number - 1].kind == "blow"
        return bounces and bool(self.lying) and flight.duration < _SHORT * period

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

    def tests(self, cycle: ValveCycle, within: tuple[int, ...] | None = None) -> dict[str, float]:
        """What is above 0 in a cycle of a machine with this order, and changes its sign where the order ends.

        Looked at, not proved; `fault` proves. `within`: the numbers of the flights in which clearances are looked for,
        which costs most; all by default. By their names, i being a number from 0 on:

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
        "rest i"
            How long a bar that lies down after a chatter rests before event i, which lets it go.
        """
        found = {name: speed for name, (_, speed) in self._speeds(cycle).items()}
        flows = state_flows(cycle.machine, cycle.modes)
        for i, (event, flight) in enumerate(zip(self.events, cycle.flights, strict=True)):
            at_once = event.kind == "due" and cycle.machine.valve.ports[event.port].delay == 0.0
            if not at_once:
                found[f"order {i}"] = flight.duration
            if self._ends_a_chatter(i, flight, cycle.period):
                continue
            if flight.lies:
                if self.events[i - 1].laid and cycle.contact.velocity_factor < 0.0:
                    del found[f"order {i}"]
                    found[f"rest {i}"] = flight.duration - self._chatter(cycle, i - 1)
                continue
            if within is not None and i not in within:
                continue
            flow = flows[flight.state]
            met = -1 if event.kind == "blow" else event.port if event.kind == "port" else None
            looked = [one for part, wall in parts(flight, flow) for one in watched(cycle.machine, flow, part, wall)]
            for one, regions, which in looked:
                apart = clearances(one, regions, which.index(met) if met in which else -1)
                for number, far in zip(which, apart.tolist(), strict=True):
                    name = {-1: f"wall {i}", -2: f"pressure {i}"}.get(number, f"edge {i}.{number}")
                    found[name] = min(far, found.get(name, np.inf))
        return found

    def _chatter(self, cycle: ValveCycle, number: int) -> float:
        """How long a chatter goes on after a blow after which the bar is laid down."""
        flight, contact = cycle.flights[number], cycle.contact
        bar = np.array([contact.strain_factor, contact.velocity_factor]) * flight.end
        flow = state_flows(cycle.machine, cycle.modes)[flight.state]
        pressure = cycle.flights[(number + 1) % len(cycle.flights)].pressure
        left = chatter_time(cycle.machine, flow, bar, pressure)
        if left == np.inf:  # of none, the bar flies on, or the valve holds it at once by a law that turns strain over
            return cycle.period if contact.keeps_strain else 0.0
        return left


_QUARTER = 0.3  # of the time in which a chamber turns a released machine round, in radians of its frequency


def hold_after_release(machine: Machine, modes: MachineModes) -> tuple[float, float]:
    """How long no contact is looked for when a bar leaves the wall at rest: at least, and while the valve pulls."""
    # The striking end of finitely many modes moves at once, not after the time of a wave.
    slowest, wave = float(modes.omega[0]), (1.0 + 0.5 / max(modes.size, 1)) * machine.body.transit_time
    return wave, np.inf if slowest == 0.0 else max(wave, _QUARTER / slowest)


def chatter_left(machine: Machine, flow: StateFlow, bar: Array, pressure: float) -> tuple[float, float]:
    """How long the chatter of a bar that has just struck goes on, with the error of that; infinite where it is none."""
    end, R = flow.modes.end, -machine.contact.velocity_factor
    force, drag = flow.force(bar[:, 0], pressure), float(flow.modes.damping[0])
    acceleration, rebound = flow.rates(bar, pressure)[0][:, 1], -float(end @ bar[:, 1])
    push = float(end @ acceleration) - drag * rebound
    if not 0.0 < R < 1.0 or push <= 0.0:
        return np.inf, np.inf
    left, omega = 2.0 * rebound / ((1.0 - R) * push), flow.modes.omega[1:]
    bent = omega**2 * bar[1:, 0] - force * flow.modes.driven[1:]  # ω² times the displacement of the free motion
    jerk = float((np.abs(end[1:]) * omega) @ np.hypot(omega * bar[1:, 1], bent))
    otherwise = float(np.abs(end * (flow.modes.damping - drag)) @ np.abs(bar[:, 1]))  # damped than the whole
    known = drag * left * (1.0 + abs(float(end[0] * acceleration[0])) / push)
    unknown = (jerk * left + otherwise) / push + (float(flow.modes.omega[0]) * left) ** 2
    error = (known * known + unknown) * left if known + unknown <= 0.1 else np.inf
    return left * (1.0 - drag * left / 6.0), error


_MOST_BOUNCES, _FAR = 400, 1e3  # times what a chatter would last
_EXACT = 1e-13  # of the valve's unit of time


def chatter_time(machine: Machine, flow: StateFlow, bar: Array, pressure: float) -> float:
    """How long a bar that has just struck bounces until it lies on the wall; infinite where it leaves it instead."""
    contact, end, gone = machine.contact, flow.modes.end, 0.0
    for _ in range(_MOST_BOUNCES):
        left, error = chatter_left(machine, flow, bar, pressure)
        if left == np.inf or error <= _EXACT * machine.valve.time_unit:
            return gone + left
        flight = ModalFlight(
            modes=flow.modes, begin=bar, force=flow.force(bar[:, 0], pressure), ramp=flow.ramp, duration=_FAR * left
        )
        t = first_entering(flight, Regions(end[None, :], np.zeros(1), 1.0, np.zeros(1))).time
        if not t < np.inf:
            return np.inf
        gone += t
        bar = np.array([contact.strain_factor, contact.velocity_factor]) * replace(flight, duration=t).end
        bar[0, 0] -= float(end @ bar[:, 0]) / float(end[0])
    return np.inf


def parts(flight: ValveFlight, flow: StateFlow) -> list[tuple[ValveFlight, bool]]:
    """A flight, with whether contact is looked for in it: in two where it is not at first."""
    if flight.held == 0.0:
        return [(flight, True)]
    first = replace(flight, duration=min(flight.held, flight.duration))
    if flight.held >= flight.duration:
        return [(first, False)]
    begin, later = first.end, first.duration
    drawn = flow.draw * float(flow.modes.driven @ (begin - flight.begin)[:, 0])
    then = replace(
        flight,
        begin=begin,
        force=flight.force + flight.ramp * later,
        duration=flight.duration - later,
        held=0.0,
        time=flight.time + later,
        pressure=flight.pressure + (flow.supplied * later - drawn) / flow.compliance,
    )
    return [(first, False), (then, True)]


def sequence_of(cycle: ValveCycle) -> EventSequence:
    """The order of events of a cycle.

    Raises
    ------
    ParameterError
        When the end of a chatter lets go of the bar, or the valve is not at the end of the cycle what it was.
    """
    check_closed_form(cycle.machine)
    found = sequence_in(cycle.machine.valve, cycle.rhythm)
    if found is None and cycle.rests:
        raise ParameterError(
            "cycle", str(cycle), "a cycle in which the valve lets go of a bar at rest, not its ringing"
        )
    if found is None:
        raise ParameterError("cycle", str(cycle), "a cycle at whose end the valve and its orders are as at its begin")
    return found


def sequence_in(valve: Valve, rhythm: CycleTimes) -> EventSequence | None:
    """The order of events in a rhythm, by the rules of the valve; None when its end is not its beginning."""
    steps, now = followed(valve, rhythm)
    ends, begins = now.orders, rhythm.orders
    if [to for _, to in ends.pending] != [to for _, to in begins.pending]:
        return None
    if (now.state, ends.last) != (rhythm.state, begins.last):
        return None
    traced, events = list[tuple[int, int, int]](), list[SequenceEvent]()
    for number, order in enumerate(ends.pending):
        (source, port, began), wrapped = now.sources[order], 1
        while began:  # a cycle before it was one further back among those that wait
            if source <= number:
                return None
            number, wrapped = source, wrapped + 1
            source, port, began = now.sources[ends.pending[number]]
        traced.append((source, port, wrapped))
    for kind, _, port, source, began, state, last in steps:
        wrapped = 0
        if began:
            source, port, wrapped = traced[source]
        events.append(SequenceEvent(kind, port, source, wrapped, state, last))
    waiting = tuple(Waiting(to, *one) for (_, to), one in zip(ends.pending, traced, strict=True))
    laid = _laid(valve, rhythm, events)
    return None if laid is None else EventSequence(rhythm.state, begins.last, waiting, laid)


def _laid(valve: Valve, rhythm: CycleTimes, events: list[SequenceEvent]) -> tuple[SequenceEvent, ...] | None:
    """The events, with where the bar lies on the wall for as long as the valve presses; None where it does not."""
    # When the end of a chatter lets go is not told by the times of the blows.
    if not rhythm.lying and not rhythm.sticking:
        return tuple(events)
    guarded = [i for i, event in enumerate(events) if event.kind != "due"]
    struck = [i for i in guarded if events[i].kind == "blow"]
    found = list(events)
    for number, at in enumerate(struck):
        state, following = events[at].state, [*range(at + 1, len(events)), *range(at)]
        source = -1 if at == struck[-1] else guarded.index(at)
        for i in following:  # what the blow demands at once
            one = events[i]
            if one.kind != "due" or one.source != source or one.wrapped or valve.ports[one.port].delay > 0.0:
                break
            state = one.state
        pressed = valve.force(state) > 0.0
        laid = number in rhythm.lying or (rhythm.sticking and pressed)
        if laid and not pressed and not rhythm.sticking:
            return None
        found[at] = found[at]._replace(laid=laid, lies=laid and pressed)
        for i in following if laid and pressed else ():
            if events[i].kind != "due" or not valve.force(events[i].state) > 0.0:
                break
            found[i] = found[i]._replace(lies=True)
    return tuple(found)


_REPEATS = 4  # of a cycle, until its valve begins as it ends


def reordered(valve: Valve, rhythm: CycleTimes) -> CycleTimes | None:
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
        blow = event.kind == "blow"
        timings.append(Timing(event.source, later, event.wrapped, event.kind != "due", blow, event.laid))
        states.append(event.state)
    passed = [flows[state] for state in states[:-1]]
    for i, flow in enumerate(passed):
        if sequence.events[i - 1].lies:
            passed[i] = flow._replace(held=0.0, draw=0.0)
    turn = np.array([contact.strain_factor, contact.velocity_factor])
    return Cycle(passed, turn, timings, rows, np.array(levels))
