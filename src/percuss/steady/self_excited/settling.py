"""Where a machine ends that switches its own valve, of any number of modes, with a pump or without.

It is followed from blow to blow, each event proved to be the next one; its cycle is then solved for by the times of its
events, or it rests on the wall and begins anew from there.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import NamedTuple, cast

import numpy as np

from percuss.halting import check_interrupted
from percuss.mechanics.flow import StateFlow, state_flows
from percuss.model import Machine, MachineModes
from percuss.model.checks import Array
from percuss.model.load.valve import Orders
from percuss.model.machine import check_closed_form
from percuss.steady.self_excited.cycle_times import CycleTimes, Switching, rhythm_of, under
from percuss.steady.self_excited.event_sequence import chatter_left, first_met, hold_after_release, sequence_in
from percuss.steady.self_excited.piston import Piston, continued, settled
from percuss.steady.self_excited.valve_cycle import Rebound, ValveCycle, ValveFlight, cycle_told, strain_of

# ---- An elastic machine followed from a start, event by event, each of them proved to be the next one
#
# Cycles are solved for, not simulated; this tells which order of events a machine settles in when that of its rigid
# piston is not it, and what goes on after a rest.

_NO_SPEED = 1e-13  # of the speeds that occur: a slower rebound is none
_CHATTER = 1e-5  # of the valve's unit of time: a chatter is completed when so little of it is left …
_CHATTER_ERROR = 1e-13  # … and its end is known to this
_MOST_EVENTS, _MOST_SUPPLIED_EVENTS = 60, 400  # from blow to blow; a pressure may grow until there is one
_LATELY = 40  # events that tell what a machine without a cycle does
_LONGEST = 16.0  # flights without an event, in periods of the rigid piston


class Laid(NamedTuple):
    """When the last blow before a rest was, flights and events before; `losses`: how often the bar has lain down."""

    time: float
    flights: int
    events: int
    losses: int


class Following:
    """A machine with N = `count` on its way after a blow, undeformed; `ending` is None for as long as it goes on.

    `from_rest` there was no blow: the ports whose regions are occupied demand.
    """

    def __init__(self, machine: Machine, count: int, start: Rebound, period: float, *, from_rest: bool = False) -> None:
        check_closed_form(machine)
        self.machine, self.count, self.start = machine, count, start
        self.flows = state_flows(machine, count)
        self.valve, self.time = Switching(machine.valve, start.state, start.orders), 0.0
        self.now = np.stack([0.0 * self.modes.centre, -start.speed * self.modes.centre], axis=1)
        self.pressure = 1.0 if start.pressure is None else start.pressure
        self.span = _LONGEST * period
        self.ending: str | None = None
        self.flights: list[ValveFlight] = []
        self.events: list[tuple[float, str, object]] = []
        self.states: list[tuple[Array, float]] = []  # just before each event, with the pressure
        self.blows = 0
        self.rests: list[Laid] = []
        self.losses: list[float] = []  # energy that the bar had whenever it lay down
        self._flown = math.inf  # since the blow before, if there was one after the last rest
        self._last: float | None = None  # when the last blow was
        self._turn = np.array([machine.contact.strain_factor, machine.contact.velocity_factor])
        self._hold = -math.inf  # until when no contact is looked for after a release …
        self._wave = -math.inf  # … at least: until that has run through the bar
        ports = machine.valve.ports
        self._struck([i for i, port in enumerate(ports) if port.sign * port.level < 0.0] if from_rest else None)
        if not self.now.any():
            self._released()

    def go_on(self, blows: int) -> None:
        """So many blows more, unless it ends before."""
        wanted = self.blows + blows
        while self.ending is None and self.blows < wanted:
            self._to_blow()

    def _to_blow(self) -> None:
        before = self.blows
        supply = self.machine.valve.supply
        for _ in range(_MOST_EVENTS if supply is None else _MOST_SUPPLIED_EVENTS):
            check_interrupted()
            self._carry_out()
            if -math.inf < self._hold <= self.time:
                self._caught_up()
                if self.blows > before or self.ending is not None:
                    return
            due, held = self.valve.due, self._hold > self.time
            until = due - self.time if due < math.inf else self.span
            until = min(until, self._hold - self.time) if held else until
            flight = self._flight(until, until if held else 0.0)
            time, which = first_met(self.machine, self.flow, flight, wall=not held)
            if math.isinf(time) and due == math.inf and until == self.span and flight.ramp == 0.0:
                self.ending = "nothing follows"
                return
            flight = replace(flight, duration=min(time, until))
            self.flights.append(flight)
            self._moved(flight.end, flight.duration)
            if math.isinf(time):
                if due < math.inf and until != self._hold - flight.time:
                    self.time = due
            elif which == -1:
                self._strike()
            elif which == -2:
                self.ending = "no pressure"
            else:
                self._demand(which)
            if self.blows > before or self.ending is not None:
                return
        self.ending = "no blow"

    @property
    def flow(self) -> StateFlow:
        """In the state of the valve."""
        return self.flows[self.valve.state]

    @property
    def modes(self) -> MachineModes:
        """In the state of the valve."""
        return self.flow.modes

    @property
    def force(self) -> float:
        """On the modes now."""
        return self.flow.force(self.now[:, 0], self.pressure)

    def _flight(self, duration: float, held: float = 0.0) -> ValveFlight:
        return ValveFlight(
            modes=self.modes,
            begin=self.now,
            force=self.force,
            ramp=self.flow.ramp,
            duration=duration,
            state=self.valve.state,
            last=self.valve.orders.last,
            time=self.time,
            held=held,
            pressure=self.pressure,
        )

    def _moved(self, to: Array, duration: float) -> None:
        """To another state of the bar after a time."""
        flow, way = self.flow, float(self.modes.driven @ (to - self.now)[:, 0])
        self.pressure += (flow.supplied * duration - flow.draw * way) / flow.compliance
        self.now, self.time = to, self.time + duration

    def _carry_out(self) -> None:
        while self.valve.due <= self.time:
            self._happened("valve", self.valve.orders.pending[0][1])
            before = self.modes.mixing
            self.valve.carry_out()
            if self.modes.mixing is not before:
                self.now = self.modes.mixing.T @ before @ self.now
            if self.force > 0.0:
                self._hold = min(self._hold, self._wave)

    def _demand(self, number: int) -> None:
        if self.valve.demand(self.time, number, pressure=self.pressure):
            self._happened("port", number)

    def _strike(self) -> None:
        speed = float(self.modes.end @ self.now[:, 1])
        self._happened("impact", speed)
        self._flown = math.inf if self._last is None else self.time - self._last
        self._last, self.blows = self.time, self.blows + 1
        self.now = self._turn * self.now
        self._struck()

    def _struck(self, demanding: list[int] | None = None) -> None:
        """The blow demands, or what does so at a start; the bar flies on, or lies down."""
        for port in self.valve.blow_demands() if demanding is None else demanding:
            self._demand(port)
        self._carry_out()
        wait = self._to_rest()
        if wait is not None:
            self._rest(wait)

    def _to_rest(self) -> float | None:
        """After what time a bar that has just struck lies on the wall; None where it flies."""
        # As in a simulation: at once where the end has no speed and nothing takes it off the wall, or where the valve
        # holds it, and at the end of a chatter where what is left of it is short and known.
        machine, end, now = self.machine, self.modes.end, self.now
        force, R = self.force, -machine.contact.velocity_factor
        push = float(end @ self.flow.rates(now, self.pressure)[0][:, 1])
        rebound = -float(end @ now[:, 1])
        if rebound <= _NO_SPEED * float(np.abs(end) @ np.abs(now[:, 1])):
            forgets = machine.contact.strain_factor == 0.0 and self.modes.size > 0
            return 0.0 if push >= 0.0 or (R == 0.0 and (force > 0.0 or forgets)) else None
        if self._held(force):
            return 0.0
        (left, error), unit = chatter_left(machine, self.flow, now, self.pressure), machine.valve.time_unit
        ends = left <= _CHATTER * unit and 2.0 * left <= self.valve.due - self.time
        return left if ends and error <= _CHATTER_ERROR * unit else None

    def _held(self, force: float) -> bool:
        """Whether the valve turns the rebound within the time of a contact, by a law that turns the strain over."""
        contact, modes, now = self.machine.contact, self.modes, self.now
        if contact.keeps_strain or not -1.0 < contact.velocity_factor < 0.0:
            return False
        time = 2.0 * self.machine.body.transit_time
        pull = float(modes.omega[0]) ** 2 * float(now[0, 0])
        fastest = 0.5 * (force * float(modes.driven[0]) - pull) * time  # of the first coordinate
        if not (0.0 < self._flown < time and 0.0 <= -float(modes.end[0] * now[0, 1]) <= float(modes.end[0]) * fastest):
            return False
        return self.energy <= fastest * fastest

    @property
    def energy(self) -> float:
        """Kinetic and elastic, with that of the chamber."""
        return 0.5 * float(self.now[:, 1] @ self.now[:, 1]) + strain_of(self.flow, self.now)

    def _caught_up(self) -> None:
        """The wall is looked for again: an end of finitely many modes that is there or beyond it is on it."""
        self._hold, end = -math.inf, self.modes.end
        beyond = float(end @ self.now[:, 0])
        if beyond < 0.0:
            return
        self.now = self.now - np.outer(np.eye(len(end))[0], [beyond / end[0], 0.0])
        speed = float(end @ self.now[:, 1])
        if speed > _NO_SPEED * float(np.abs(end) @ np.abs(self.now[:, 1])):
            self._strike()
        elif (wait := self._to_rest()) is not None:
            self._rest(wait)

    def _rest(self, wait: float) -> None:
        """Lies on the wall until the valve pulls, and leaves it undeformed; contacts: see `hold_after_release`."""
        since = self.rests[-1].events if self.rests else 0
        if any(kind == "valve" for _, kind, _ in self.events[since:]):
            self.rests.append(Laid(self.time, len(self.flights), len(self.events), len(self.losses) + 1))
        self._happened("rest", None)
        self.losses.append(self.energy)
        self.now, self._last = 0.0 * self.now, None
        if wait > 0.0:
            self._lie(wait)
            for port in self.valve.blow_demands():  # those of the last of its blows
                self._demand(port)
        while self.force > 0.0:
            ramp, due = self.flow.ramp, self.valve.due
            lifted = self.time - self.force / ramp if ramp < 0.0 else math.inf  # by a growing pressure
            if min(lifted, due) == math.inf:
                self.ending = "on the wall"
                return
            self._lie(min(lifted, due) - self.time)
            if lifted < due:
                self.pressure = -self.flow.held / self.flow.draw
                break
            self.time = due
            self._carry_out()
        self._released()

    def _released(self) -> None:
        """Begins to be pulled off the wall, undeformed: no contact is looked for at first."""
        self._wave, self._hold = (self.time + one for one in hold_after_release(self.machine, self.modes))

    def _lie(self, duration: float) -> None:
        self.flights.append(replace(self._flight(duration), force=0.0, ramp=0.0))
        self._moved(self.now, duration)

    def _happened(self, kind: str, detail: object) -> None:
        self.events.append((self.time, kind, detail))
        self.states.append((self.now, self.pressure))

    def rhythm(self, blows: int, events: list[tuple[float, str, object]] | None = None) -> CycleTimes:
        """That of the last blows, or of the last ones among some events."""
        begin = Switching(self.machine.valve, self.start.state, self.start.orders)
        fed = [(event[0], state[1]) for event, state in zip(self.events, self.states, strict=True)]
        varied = self.machine.valve.delays_vary
        return rhythm_of(begin, self.events if events is None else events, blows, fed if varied else ())

    @property
    def strikes_twice(self) -> bool:
        """Whether the valve did not change between two of the last blows."""
        seen = [kind for _, kind, _ in self.events if kind != "port"]
        return any(pair == ("impact", "impact") for pair in zip(seen[-_LATELY:], seen[1 - _LATELY :], strict=False))

    @property
    def farthest(self) -> float:
        """How far behind the wall the bar was after the last blow but one, or goes in the end."""
        since = [one for one in self.flights if one.time >= self.time - self._flown]
        return max((one.farthest for one in since if one.duration > 0.0), default=0.0)


# ---- The cycle of a machine near a rhythm: Newton's method on the times of its events, then the proof


_EARLY = 1e-8  # of a flight, before its end: where a pressure settles slowly the times are known to no more


def solved(machine: Machine, count: int, rhythm: CycleTimes) -> ValveCycle | None:
    """The cycle with this order of events to which Newton's method leads from these times, if the machine does this."""
    sequence = sequence_in(machine.valve, rhythm)
    if sequence is None:
        return None
    found = sequence.solved(machine, count, np.array([time for time, _ in rhythm.guarded]))
    early = 0.0 if machine.valve.supply is None else _EARLY
    return found if found is not None and sequence.fault(found, early) is None else None


# ---- The cycle of a machine that rests on the wall: what follows a release, until the next one
#
# A bar at rest on the wall has forgotten everything but the pressure of a supply, and leaves undeformed when the valve
# pulls: all other multipliers are 0.

_MOST_RESTS = 4  # in a cycle
_FED = 16  # more rounds of blows, until the pressure of a supply has settled
_SLOW = 1e-3  # of the greatest speed: blows of a chatter that are left out
_SAME, _NEARLY = 1e-9, 1e-2  # of the period: what the last blows before a rest may move, and a pressure that settles


def rest_cycles_of(machine: Machine, count: int, valve_cycles: int = 1) -> tuple[ValveCycle, ...]:
    """The cycles with rest to which a machine comes that is let go at rest in a state of its valve.

    It is followed the longer the more cycles of its valve one is looked for with.
    """
    found, valve = list[ValveCycle](), machine.valve
    if valve.flows:  # whose cycles are found with their rests
        return ()
    for state, _ in valve.pairs:
        if valve.force(state) > 0.0:
            continue
        begin = Rebound(0.0, state, Orders(state), None if valve.supply is None else valve.supply.start)
        motion, cycle = Following(machine, count, begin, valve.time_unit), None
        longer = valve_cycles // 2 + (0 if valve.supply is None else _FED)
        for blows in (*_BLOWS, *[_BLOWS[-1]] * longer):
            motion.go_on(blows)
            cycle = rest_cycle(motion, _SAME if valve.supply is None else _NEARLY)
            if cycle is not None or motion.ending is not None:
                break
        if cycle is not None and all(abs(cycle.period - one.period) > _SAME * one.period for one in found):
            found.append(cycle)
    return tuple(found)


def rest_cycle(motion: Following, near: float = _SAME) -> ValveCycle | None:
    """The cycle of one or a few rests with which a motion has been repeating itself; None for none."""
    times = [rest.time for rest in motion.rests]
    for count in range(1, _MOST_RESTS + 1):
        if len(times) > 2 * count:
            now, before = times[-1] - times[-1 - count], times[-1 - count] - times[-1 - 2 * count]
            if abs(now - before) <= near * now:
                first, last = motion.rests[-1 - count], motion.rests[-1]
                cycle = _by_times(motion, first, last)
                if cycle is not None and abs(cycle.period - now) > near * now:
                    cycle = None  # the pressure is far from it still, and the motion may be another one there
                return cycle if cycle is not None or near > _SAME else _as_followed(motion, first, last)
    return None


def _by_times(motion: Following, first: Laid, last: Laid) -> ValveCycle | None:
    """The cycle between two rests as a solution for its times; None where the end of a chatter lets go."""
    events = _without_slow_bounces(motion.events[: last.events + 1])
    after = sum(kind == "rest" for _, kind, _ in motion.events[: first.events + 1])
    begin = [i for i, (_, kind, _) in enumerate(events) if kind == "rest"][after - 1]
    rhythm = motion.rhythm(sum(kind == "impact" for _, kind, _ in events[begin:]), events)
    sticking = motion.machine.contact.velocity_factor == 0.0
    return solved(motion.machine, motion.count, replace(rhythm, sticking=sticking))


def _as_followed(motion: Following, first: Laid, last: Laid) -> ValveCycle | None:
    """… where ringing presses a bar on the wall that the valve pulls: when it leaves is known to rounding only."""
    if motion.machine.valve.supply is not None:
        return None
    events, size = slice(first.events, last.events), 2 * motion.modes.omega.size if motion.count else 1
    happened = [
        (time - first.time, kind, detail, *before)
        for (time, kind, detail), before in zip(motion.events[events], motion.states[events], strict=True)
    ]
    flights = tuple(
        replace(flight, time=flight.time - first.time) for flight in motion.flights[first.flights : last.flights]
    )
    struck = [kind for _, kind, *_ in happened if kind in ("impact", "rest")]
    lying = [sum(kind == "impact" for kind in struck[:i]) - 1 for i, kind in enumerate(struck) if kind == "rest"]
    blows = struck.count("impact")
    rhythm = motion.rhythm(blows, motion.events[: last.events])
    return cycle_told(
        motion.machine, motion.count, rhythm.state, rhythm.orders, flights, happened, np.zeros((size, size)),
        tuple(sorted({number % blows for number in lying})), math.fsum(motion.losses[first.losses : last.losses]),
    )  # fmt: skip


def _without_slow_bounces(events: list[tuple[float, str, object]]) -> list[tuple[float, str, object]]:
    """Events in which a bar lies down after a few blows of a chatter: those that are left out move nothing else."""
    found, greatest = list[tuple[float, str, object]](), 0.0
    for event in events:
        if event[1] == "impact":
            greatest = max(greatest, float(cast("float", event[2])))
        if event[1] == "rest" and found:
            while [kind for _, kind, _ in found[-2:]] == ["impact", "impact"] and found[-1][2] < _SLOW * greatest:  # type: ignore[operator]
                found.pop()
            event = (found[-1][0], *event[1:]) if found[-1][1] == "impact" else event
        found.append(event)
    return found


# ---- The cycle in which a machine ends: in a rhythm that is known, or in the one it is followed to

_BLOWS = (4, 8, 24, 48)  # after which a cycle is tried, one after the other: at first, only one with rest
_FORGOTTEN = 12  # blows after which little is left of the start
_MOST_IN_CYCLE, _MOST_SUPPLIED = 4, 8


class Settled(NamedTuple):
    """The cycle, None for none, and the motion that was followed, if any."""

    cycle: ValveCycle | None
    motion: Following | None = None


def settled_from(
    machine: Machine, count: int, rhythm: CycleTimes | None, start: Rebound | None, period: float
) -> Settled:
    """The stable cycle near a rhythm, its flights not proved; else where the motion from a rebound, if any, ends."""
    found = _settled(machine, count, rhythm, start, period)
    sound = found.cycle is None or found.cycle.keeps_before_the_wall
    return found if sound else found._replace(cycle=None)


def _settled(machine: Machine, count: int, rhythm: CycleTimes | None, start: Rebound | None, period: float) -> Settled:
    first = None if rhythm is None else solved(machine, count, rhythm)
    if start is None or (first is not None and first.stable):
        return Settled(first)
    motion = Following(machine, count, start, period)
    for blows in _BLOWS:
        motion.go_on(blows)
        if (resting := rest_cycle(motion)) is not None:
            return Settled(resting, motion)
        if motion.ending is not None:
            return Settled(None, motion)
        cycle = _cycle_at(machine, count, motion) if motion.blows >= _FORGOTTEN else None
        if cycle is not None:
            return Settled(cycle, motion)
    return Settled(first, motion)


def _cycle_at(machine: Machine, count: int, motion: Following) -> ValveCycle | None:
    most = _MOST_IN_CYCLE if machine.valve.supply is None else _MOST_SUPPLIED
    for blows in range(1, min(most, motion.blows - 1) + 1):
        cycle = solved(machine, count, motion.rhythm(blows))
        if cycle is not None and cycle.stable:
            return _shortest(machine, count, cycle)
    return None


def _shortest(machine: Machine, count: int, cycle: ValveCycle) -> ValveCycle:
    """The cycle, or that of fewer blows which it goes through again and again: what settles slowly looks longer."""
    for blows in range(1, cycle.blows):
        if cycle.blows % blows == 0:
            times = cycle.rhythm.blow_times[:blows]
            passages = tuple(one for one in cycle.rhythm.passages if one[0] <= times[-1])
            part = solved(machine, count, replace(cycle.rhythm, blow_times=times, passages=passages))
            if part is not None and abs(part.period * (cycle.blows // blows) - cycle.period) <= _SAME * cycle.period:
                return part
    return cycle


def followed_to(machine: Machine, cycle: ValveCycle, rhythm: CycleTimes | None = None) -> ValveCycle | None:
    """The cycle of one blow of a machine little different from that of a cycle, or a rhythm; its order may change."""
    found = solved(machine, cycle.modes, rhythm or cycle.rhythm)
    if found is not None:
        return found
    motion = Following(machine, cycle.modes, cycle.rebound, cycle.period)
    for _ in range(_BLOWS[0]):
        motion.go_on(1)
        found = None if motion.ending or motion.blows < 2 else solved(machine, cycle.modes, motion.rhythm(1))
        if found is not None and found.switches:
            return found
    return None


# ---- The cycle of a machine that a pump and an accumulator feed: first the pressure that results, then Newton's method
#
# Under a constant pressure a cycle draws a volume in its time; the pressure that results is the one at which the pump
# gives just that. It is the cycle's for an accumulator without end, which is then made smaller step by step.

_TRIED = (1.0, 2.0, 0.5, 4.0)  # pressures at which a machine may run
_STEP = 0.25  # of the logarithm of the pressure
_MOST_STEPS = 80
_NEAR = 1e-6
_SMALL_SWING = 0.05  # of the pressure in a cycle: where the steps of the accumulator begin
_MOST_HALVINGS = 40
_STARTED_BLOWS = 120
_ARRIVED = 1e-4  # of the numbers of a rebound: a cycle that attracts is not left any more


def under_pressure(machine: Machine, pressure: float) -> Machine:
    """The machine under a constant pressure."""
    return machine.with_valve(machine.valve.at_pressure(pressure))


def supplied(machine: Machine) -> Settled:
    """The cycle of a rigid piston with a supply, or its motion."""
    balance = _balanced(machine)
    if balance is None:
        start = replace(Piston(machine).fast, pressure=1.0)
        return settled_from(machine, 0, None, start, machine.valve.time_unit)
    start = replace(balance[0].rebound, pressure=balance[1])
    if (cycle := _with_less_oil(machine, *balance)) is not None:
        return Settled(cycle)
    return settled_from(machine, 0, under(balance[0].rhythm, balance[1]), start, balance[0].period)


def _balanced(machine: Machine) -> tuple[ValveCycle, float] | None:
    """The cycle under the constant pressure at which it draws what the pump gives, and that pressure."""
    low = high = None
    for pressure in _TRIED:
        cycle, *_ = settled(under_pressure(machine, pressure))
        if cycle is not None and cycle.blows == 1 and cycle.work > 0.0:
            break
    else:
        return None
    for _ in range(_MOST_STEPS):
        surplus = _surplus(machine, cycle, pressure)
        if surplus > 0.0:
            low = cycle, pressure
        else:
            high = cycle, pressure
        if low is not None and high is not None:
            break
        pressure *= math.exp(math.copysign(_STEP, surplus))
        following = continued(under_pressure(machine, pressure), cycle)
        if following is None:
            return low or high
        cycle = following
    while low is not None and high is not None and high[1] - low[1] > _NEAR * low[1]:
        pressure = math.sqrt(low[1] * high[1])
        between = continued(under_pressure(machine, pressure), low[0])
        if between is None:
            break
        if _surplus(machine, between, pressure) > 0.0:
            low = between, pressure
        else:
            high = between, pressure
    return low or high


def _surplus(machine: Machine, cycle: ValveCycle, pressure: float) -> float:
    """The logarithm of what the pump gives in a cycle over what the piston draws under a constant pressure."""
    supply = machine.valve.supply
    assert supply is not None
    return math.log(supply.flow * cycle.period * pressure / cycle.work)


def _with_less_oil(machine: Machine, cycle: ValveCycle, pressure: float) -> ValveCycle | None:
    """The cycle with the accumulator there is, from one with which the pressure hardly swings."""
    supply, found = machine.valve.supply, None if cycle.rests else cycle
    assert supply is not None
    most = cycle.work / (_SMALL_SWING * pressure**2)
    halvings = min(max(math.ceil(math.log2(most / supply.compliance)), 0), _MOST_HALVINGS)
    for halving in range(halvings, -1, -1):
        if found is None:
            return None
        other = replace(supply, compliance=supply.compliance * 2.0**halving)
        rhythm = under(found.rhythm, pressure) if found is cycle else found.rhythm
        found = followed_to(machine.with_valve(replace(machine.valve, supply=other)), found, rhythm)
    return found


def starts_supplied(machine: Machine, cycle: ValveCycle) -> bool:
    """Whether a machine with a supply keeps going from rest on the wall; its own cycle tells when it is sure to."""
    valve = machine.valve
    assert valve.supply is not None
    begin = Rebound(0.0, valve.orders.last, valve.orders, valve.supply.start)
    motion = Following(machine, 0, begin, cycle.period, from_rest=True)
    wanted = cycle.rebound
    while motion.ending is None and motion.blows < _STARTED_BLOWS:
        motion.go_on(1)
        now = Rebound(-float(motion.now[0, 1]), motion.valve.state, motion.valve.orders, motion.pressure)
        near = abs(now.speed - wanted.speed) + cycle.blow_speed * abs(motion.pressure - (wanted.pressure or 0.0))
        if cycle.stable and not cycle.modes and now.state == wanted.state and near <= _ARRIVED * cycle.blow_speed:
            return True
    return motion.ending is None
