"""A periodic motion of an elastic machine that switches its own valve, and its figures."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal, NamedTuple

import numpy as np

from percuss.mechanics.flow import propagated, rates, response_of
from percuss.model import Machine, MachineModes
from percuss.model.checks import Array, ComplexArray
from percuss.model.load.valve import Orders
from percuss.shown import Shown
from percuss.steady.self_excited.elastic_chain import (
    Chain,
    Closed,
    ModalFlight,
    Regions,
    Rhythm,
    energy_of,
    farthest,
    first_entering,
    orders_after,
    place_row,
    rhythm_of,
    steps_of,
)
from percuss.steady.self_excited.piston_legs import Switch, Uncovering
from percuss.steady.self_excited.rigid_cycle import Parted, Place, RigidCycle, Ringing, ValveCycle, parted

_LOOKS = 24  # at each flight
_BEYOND = 1e-9  # of the way to the farthest place


@dataclass(frozen=True)
class Blow(Shown):
    """A blow of an elastic machine.

    Attributes
    ----------
    time, speed
        When, and the speed of the striking end just before.
    kinetic, strain
        Energies just before, per unit of mass; that of the chamber, which follows the driven end, is part of `strain`.
    """

    time: float
    speed: float
    kinetic: float
    strain: float


@dataclass(frozen=True)
class ElasticCycle(ValveCycle):
    """A periodic motion of an elastic machine that switches its own valve.

    Parameters
    ----------
    machine, modes
        The machine, and N.
    flights
        The stretches between events, in order of time.
    struck
        The blows.
    changed, passed
        Changes of the valve's state, with place and velocity of the driven end; passages of ports that demand.
    slope
        Derivative of the map from cycle to cycle: of displacement and velocity of every coordinate, one coordinate
        after the other, and of the times of the pending orders.
    rhythm
        When it strikes and passes ports, and the valve at time 0.
    lies
        Whether the striking end lies on the wall for some time.
    given_up
        Energy that the bar has where it lies down.
    """

    machine: Machine
    modes: int
    flights: tuple[ModalFlight, ...]
    struck: tuple[Blow, ...]
    changed: tuple[Switch, ...]
    passed: tuple[Uncovering, ...]
    slope: Array
    rhythm: Rhythm
    lies: bool = False
    given_up: float = 0.0

    @property
    def blow_times(self) -> Array:
        """When the blows fall, the last one at the period."""
        return np.array([blow.time for blow in self.struck])

    @property
    def blow_speeds(self) -> Array:
        """Speed of the striking end just before each blow."""
        return np.array([blow.speed for blow in self.struck])

    @property
    def blow_energies(self) -> Array:
        """Kinetic energy just before each blow, that of the ringing with it."""
        return np.array([blow.kinetic for blow in self.struck])

    @property
    def switches(self) -> tuple[Switch, ...]:
        """Every change of the valve's state, in order of time."""
        return self.changed

    @property
    def uncoverings(self) -> tuple[Uncovering, ...]:
        """Where ports demand a new state, in order of time; blows that do are not among them."""
        return self.passed

    @cached_property
    def multipliers(self) -> ComplexArray:
        """Multipliers of the map from cycle to cycle, the greatest first, without the neutral one, a shift in time."""
        found: ComplexArray = np.linalg.eigvals(self.slope).astype(complex)
        return found[np.argsort(-np.abs(found), kind="stable")]

    @property
    def rhythm_multiplier(self) -> complex | None:
        """The greatest multiplier of the motion as a whole; None where it cannot be told from the ringing."""
        return self._parted.rhythm

    @property
    def ringing(self) -> Ringing | None:
        """What rings longest; None where nothing is left of the ringing after a cycle."""
        return self._parted.ringing

    @cached_property
    def _parted(self) -> Parted:
        return parted(self.slope, self.modes)

    @property
    def rests(self) -> bool:
        """Whether the striking end lies on the wall for some time."""
        return self.lies

    @cached_property
    def stroke(self) -> float:
        """The greatest distance of the striking end from the wall."""
        row = self.flights[0].modes.end
        return max((farthest(flight, row) for flight in self.flights if flight.duration > 0.0), default=0.0)

    @property
    def keeps_before_the_wall(self) -> bool:
        """Whether the striking end is nowhere found beyond the wall, wherever it is looked at in flight."""
        flights, modes = [one for one in self.flights if not one.held], self.flights[0].modes
        looks = np.concatenate([np.linspace(0.0, one.duration, _LOOKS) for one in flights])
        _, s, q = (np.split(part, len(flights), axis=1) for part in response_of(modes, looks))
        seen = []
        for one, ss, qq in zip(flights, s, q, strict=True):
            u, v = one.begin.T
            pull = one.force * modes.driven - modes.omega**2 * u
            seen.append(modes.end @ u + (modes.end * v) @ ss + (modes.end * pull) @ qq)
        return max(float(y.max()) for y in seen) <= -_BEYOND * min(float(y.min()) for y in seen)

    @property
    def level_difference(self) -> float:
        """The greatest force of the valve minus the least."""
        forces = [force for _, force in self.machine.valve.pairs]
        return max(forces) - min(forces)

    @cached_property
    def work(self) -> float:
        """Energy that the valve puts in in a cycle: its force over the way of the driven end in flight.

        The constant part of the chamber's force is in it: without a rest or a blow that turns the strain over, in which
        the driven end moves in no time, its work is none.
        """
        driven = self.flights[0].modes.driven
        return math.fsum(one.force * float((one.end - one.begin)[:, 0] @ driven) for one in self.flights)

    @property
    def taken(self) -> float:
        """Energy that the blows of a cycle take."""
        return math.fsum(self.machine.contact.energy_taken(blow.kinetic, blow.strain) for blow in self.struck)

    @property
    def taken_by_rest(self) -> float:
        """Energy lost on lying down: what the last blow left, for a bar at rest on the wall is undeformed."""
        return self.given_up

    def _displacement(self, within: Array, place: Place) -> Array:
        row = place_row(self.machine, self.flights[0].modes, place)
        begins = np.array([flight.time for flight in self.flights])
        which = np.maximum(np.searchsorted(begins, within, side="right") - 1, 0)
        found = np.empty(within.shape)
        for number, flight in enumerate(self.flights):
            mine = which == number
            if mine.any():
                found[mine] = row @ flight.at(within[mine] - flight.time)[0]
        return found


# ---- An elastic machine followed from a start, event by event, each of them proved to be the next one
#
# Cycles are solved for, not simulated; this tells which order of events a machine settles in when that of its rigid
# piston is not it, and what goes on after a rest.

_NO_SPEED = 1e-13  # of the speeds that occur: a slower rebound is none
_CHATTER = 1e-5  # of the valve's unit of time: a chatter is completed when so little of it is left …
_CHATTER_ERROR = 1e-13  # … and its end is known to this
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
    """When the last blow before a rest was, after some change of the valve, and how many flights and events before.

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
        self.ending: str | None = None
        self.flights: list[ModalFlight] = []
        self.events: list[tuple[float, str, object]] = []
        self.states: list[Array] = []  # just before each event
        self.blows = 0
        self.rests: list[Laid] = []
        self.losses: list[float] = []  # energy that the bar had whenever it lay down
        self._flown = math.inf  # since the blow before, if there was one after the last rest
        self._last: float | None = None  # when the last blow was
        self._turn = np.array([machine.contact.strain_factor, machine.contact.velocity_factor])
        self._hold = -math.inf  # until when no contact is looked for after a release …
        self._wave = -math.inf  # … at least: until that has run through the bar
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
            if -math.inf < self._hold <= self.time:
                self._caught_up()
                if self.blows > before or self.ending is not None:
                    return
            until = self.orders.pending[0][0] - self.time if self.orders.pending else self.span
            held = self._hold > self.time
            until = min(until, self._hold - self.time) if held else until
            regions, ports = watched(self.machine, self.modes, self.orders.last, wall=not held)
            force = self.machine.valve.force(self.state)
            flight = ModalFlight(self.modes, self.state, self.orders.last, force, self.time, until, self.now, held)
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
                self._hold = min(self._hold, self._wave)
            self._happened("valve", self.state)

    def _demand(self, number: int) -> None:
        before, self.orders = self.orders, self.orders.after(self.time, self.machine.valve.ports[number])
        if self.orders is not before:
            self._happened("port", number)

    def _strike(self) -> None:
        speed = float(self.modes.end @ self.now[:, 1])
        self._happened("impact", speed)
        self._flown = math.inf if self._last is None else self.time - self._last
        self._last, self.blows = self.time, self.blows + 1
        self.now = self._turn * self.now
        self._struck()

    def _struck(self) -> None:
        """The blow demands; the bar flies on, or lies down."""
        for i, port in enumerate(self.machine.valve.ports):
            if port.on == "impact":
                self._demand(i)
        self._carry_out()
        wait = self._to_rest()
        if wait is not None:
            self._rest(wait)

    def _to_rest(self) -> float | None:
        """After what time a bar that has just struck lies on the wall; None where it flies.

        As in a simulation: at once where the end has no speed and nothing takes it off the wall, or where the valve
        holds it, and at the end of a chatter where what is left of it is short and known.
        """
        machine, end, now = self.machine, self.modes.end, self.now
        force, R = machine.valve.force(self.state), -machine.contact.velocity_factor
        acceleration = rates(self.modes, now, force)[:, 1]
        rebound, push = -float(end @ now[:, 1]), float(end @ acceleration)
        if rebound <= _NO_SPEED * float(np.abs(end) @ np.abs(now[:, 1])):
            forgets = machine.contact.strain_factor == 0.0 and self.modes.size > 0
            return 0.0 if push >= 0.0 or (R == 0.0 and (force > 0.0 or forgets)) else None
        if self._held(force):
            return 0.0
        drag = float(self.modes.damping[0])
        push -= drag * rebound
        if not 0.0 < R < 1.0 or push <= 0.0:
            return None
        left, unit = 2.0 * rebound / ((1.0 - R) * push), machine.valve.time_unit
        ahead = self.orders.pending[0][0] - self.time if self.orders.pending else math.inf
        if left > _CHATTER * unit or 2.0 * left > ahead:
            return None
        omega = self.modes.omega[1:]
        bent = omega**2 * now[1:, 0] - force * self.modes.driven[1:]  # ω² times the displacement of the free motion
        jerk = float((np.abs(end[1:]) * omega) @ np.hypot(omega * now[1:, 1], bent))
        otherwise = float(np.abs(end * (self.modes.damping - drag)) @ np.abs(now[:, 1]))  # damped than the whole
        known = drag * left * (1.0 + abs(float(end[0] * acceleration[0])) / push)
        unknown = (jerk * left + otherwise) / push + (float(self.modes.omega[0]) * left) ** 2
        certain = known + unknown <= 0.1 and (known * known + unknown) * left <= _CHATTER_ERROR * unit
        return left * (1.0 - drag * left / 6.0) if certain else None

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
        return energy_of(modes, now) <= fastest * fastest

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
        """Lies on the wall, after the end of its chatter, until the valve pulls, and leaves it undeformed.

        The striking end of finitely many modes moves at once, not after the time of a wave; so no contact is looked for
        while the valve pulls, or, against a chamber, for a part of its time.
        """
        since = self.rests[-1].events if self.rests else 0
        if any(kind == "valve" for _, kind, _ in self.events[since:]):
            self.rests.append(Laid(self.time, len(self.flights), len(self.events), len(self.losses) + 1))
        self.losses.append(energy_of(self.modes, self.now))
        self.now, self._last = 0.0 * self.now, None
        if wait > 0.0:
            self._lie(wait)
            for i, port in enumerate(self.machine.valve.ports):  # the last of its blows
                if port.on == "impact":
                    self._demand(i)
        while self.machine.valve.force(self.state) > 0.0:
            if not self.orders.pending:
                self.ending = "on the wall"
                return
            due = self.orders.pending[0][0]
            self._lie(due - self.time)
            self.time = due
            self._carry_out()
        slowest, N = float(self.modes.omega[0]), self.modes.size
        self._wave = self.time + (1.0 + 0.5 / max(N, 1)) * self.machine.body.transit_time
        self._hold = math.inf if slowest == 0.0 else max(self._wave, self.time + _QUARTER / slowest)

    def _lie(self, duration: float) -> None:
        self.flights.append(ModalFlight(self.modes, self.state, self.orders.last, 0.0, self.time, duration, self.now))
        self.time += duration

    def _happened(self, kind: str, detail: object) -> None:
        self.events.append((self.time, kind, detail))
        self.states.append(self.now)

    def rhythm(self, blows: int) -> Rhythm:
        """That of the last blows."""
        return rhythm_of(self.machine.valve, self.begin, self.events, blows)


# ---- The multipliers of a cycle of an elastic machine: its linearised map from blow to blow, event by event
#
# Each column is a disturbance: of the state at the event, which comes earlier or later by it, of the time of that
# event, and of the times at which the pending orders are due. At a port and at a blow the time follows from the place
# that is met, at an order it is that of the event that demanded it. On the blow as a section the shift in time is no
# disturbance.


def cycle_map(chain: Chain, unknowns: Array, motion: Closed) -> Array:
    """The map of (displacements and velocities, times of the pending orders) after the blow, one cycle on."""
    modes, times = chain.modes, np.concatenate([[0.0], chain.times(unknowns)])
    ways = chain.ways(times)
    wrapped = [i for i, step in enumerate(chain.steps) if step.wrapped]
    size = modes.omega.size
    columns = 2 * size + len(wrapped)
    now, when = np.zeros((size, 2, columns)), np.zeros(columns)
    now.reshape(2 * size, columns)[:, : 2 * size] = np.eye(2 * size)
    dues = {i: np.eye(columns)[2 * size + j] for j, i in enumerate(wrapped)}
    shifts = {-1: when}
    number = 0
    for i, step in enumerate(chain.steps):
        moved = propagated(modes, now, 0.0, ways[i])
        rate = rates(modes, motion.states[i], chain.forces[i])
        if step.kind == "due":
            shift = dues[i] if step.wrapped else shifts[step.source]
        else:
            row = chain.rows[i]
            shift = when - row @ moved[:, 0] / (row @ rate[:, 0])
            shifts[number] = shift
            number += 1
        now, when = moved + rate[:, :, None] * (shift - when), shift
        if step.kind == "blow":
            now = chain.turn[:, None] * now
    after = [shifts[chain.steps[i].source] - when for i in wrapped]
    return np.vstack([now.reshape(2 * size, columns), *after])


# ---- The cycle of an elastic machine near a rhythm: Newton's method on the times of its events, then the proof

_STEPS = 30
_CLOSED = 2e-14  # of the period
_NEARLY = 1e-11  # … where rounding lets no step be smaller
_HALVINGS = 5
_OUT_OF_ORDER = 0.02  # of the period, on the way to the solution
_TOGETHER = 1e-12  # of the period: simultaneous events

Problem = Literal["order", "no root", "direction", "wall", "port"]
"""Why there is no cycle: the valve is not as it was after a cycle, or events change their order; Newton's method finds
none; a port or the wall is met from the wrong side; the bar strikes, or enters a port's region, at another time."""


@dataclass(frozen=True)
class Solved:
    """The cycle, or why it is none and when that shows."""

    cycle: ElasticCycle | None
    problem: Problem | None = None
    time: float | None = None
    proven: bool = True


def solved(machine: Machine, count: int, rhythm: Rhythm) -> Solved:
    """The cycle with this order of events to which Newton's method leads from these times."""
    steps = steps_of(machine.valve, rhythm)
    if steps is None:
        return Solved(None, "order")
    chain = Chain(machine, count, steps, rhythm.state, rhythm.orders.last)
    found = _root(chain, np.array([step.time for step in steps if step.kind != "due"]))
    if found is None:
        return Solved(None, "no root")
    unknowns, motion = found
    times = np.concatenate([[0.0], chain.times(unknowns)])
    if np.any(np.diff(times) < -_TOGETHER * times[-1]):
        return Solved(None, "order", float(times[1:][np.diff(times) < 0.0][0]))
    for row, state, step, time in zip(chain.rows, motion.states, steps, times[1:], strict=True):
        if step.kind != "due" and chain.sign(step) * float(row @ state[:, 1]) <= 0.0:
            return Solved(None, "direction", float(time))
    flights = _flights(chain, times, motion)
    proven = True
    for flight in flights:
        regions, ports = watched(machine, chain.modes, flight.last)
        other = first_entering(flight, regions)
        proven &= other.proven
        if other.which >= 0:
            return Solved(None, "wall" if ports[other.which] < 0 else "port", flight.time + other.time)
    return Solved(_cycle(chain, unknowns, motion, flights, rhythm), proven=proven)


def _root(chain: Chain, unknowns: Array) -> tuple[Array, Closed] | None:
    """The times at which everything closes, by Newton's method with steps that keep the order of events."""
    try:
        motion = chain.closed(unknowns)
        smallest = np.inf
        for _ in range(_STEPS):
            step = np.linalg.solve(motion.slope, -motion.error)
            size = float(np.abs(step).max() / unknowns[-1])
            if not np.isfinite(size):
                return None
            if size <= _CLOSED or (smallest <= _NEARLY and size >= 0.5 * smallest):
                return unknowns + step, chain.closed(unknowns + step)
            smallest = min(smallest, size)
            for _ in range(_HALVINGS):
                after = unknowns + step
                if after[-1] > 0.0 and np.all(np.diff(chain.times(after)) > -_OUT_OF_ORDER * after[-1]):
                    break
                step = 0.5 * step
            else:
                return None
            unknowns = unknowns + step
            motion = chain.closed(unknowns)
    except (np.linalg.LinAlgError, FloatingPointError):
        return None
    return None


def _flights(chain: Chain, times: Array, motion: Closed) -> tuple[ModalFlight, ...]:
    begins = [motion.start, *motion.states[:-1]]
    begins = [begins[0], *(chain.turn * z if chain.turns(i) else z for i, z in enumerate(begins[1:]))]
    return tuple(
        ModalFlight(chain.modes, state, last, force, float(start), float(end - start), begin)
        for state, last, force, start, end, begin in zip(
            chain.states, chain.lasts, chain.forces, times, times[1:], begins, strict=False
        )
    )


def blow_of(modes: MachineModes, time: float, state: Array) -> Blow:
    """The blow that a state just before it makes."""
    speed, strained = state[:, 1], modes.omega * state[:, 0]
    return Blow(time, float(modes.end @ speed), 0.5 * float(speed @ speed), 0.5 * float(strained @ strained))


def switch_of(machine: Machine, driven: Array, time: float, change: tuple[str, str], state: Array) -> Switch:
    """A change of the valve from one state to another."""
    rise = machine.valve.force(change[1]) - machine.valve.force(change[0])
    behind = -float(driven @ state[:, 0])
    return Switch(time, change[1], behind, -float(driven @ state[:, 1]), rise * behind)


def _cycle(
    chain: Chain, unknowns: Array, motion: Closed, flights: tuple[ModalFlight, ...], rhythm: Rhythm
) -> ElasticCycle:
    modes, machine = chain.modes, chain.machine
    struck, changed, passed = [], [], []
    for i, (step, state) in enumerate(zip(chain.steps, motion.states, strict=True)):
        time = flights[i].time + flights[i].duration
        if step.kind == "blow":
            struck.append(blow_of(modes, time, state))
        elif step.kind == "port":
            passed.append(Uncovering(step.port, time, -float(chain.rows[i] @ state[:, 1])))
        else:
            changed.append(switch_of(machine, modes.driven, time, (chain.states[i], step.state), state))
    times, ports = tuple(blow.time for blow in struck), tuple((one.time, one.port) for one in passed)
    now = Rhythm(times, ports, rhythm.state, rhythm.orders)
    now = replace(now, orders=orders_after(machine.valve, now))
    slope = cycle_map(chain, unknowns, motion)
    return ElasticCycle(machine, modes.size, flights, tuple(struck), tuple(changed), tuple(passed), slope, now)


# ---- The cycle of an elastic machine that rests on the wall: what follows a release, until the next one
#
# A bar at rest on the wall has forgotten everything, and leaves undeformed when the valve pulls: all multipliers are 0.

_MOST_RESTS = 4  # in a cycle
_SAME = 1e-9  # of the period: what the last blows before a rest, which are left out, may move


def rest_cycle(motion: Following) -> ElasticCycle | None:
    """The cycle of one or a few rests with which a motion has been repeating itself; None for none."""
    times = [rest.time for rest in motion.rests]
    for count in range(1, _MOST_RESTS + 1):
        if len(times) > 2 * count:
            now, before = times[-1] - times[-1 - count], times[-1 - count] - times[-1 - 2 * count]
            if abs(now - before) <= _SAME * now:
                return _between(motion, motion.rests[-1 - count], motion.rests[-1])
    return None


def _between(motion: Following, first: Laid, last: Laid) -> ElasticCycle:
    start = first.time
    machine, modes = motion.machine, motion.modes
    struck, changed, passed = [], [], []
    state = motion.flights[first.flights].state
    for (time, kind, detail), now in list(zip(motion.events, motion.states, strict=True))[first.events : last.events]:
        if kind == "impact":
            struck.append(blow_of(modes, time - start, now))
        elif kind == "valve":
            changed.append(switch_of(machine, modes.driven, time - start, (state, str(detail)), now))
            state = str(detail)
        elif isinstance(detail, int) and (reads := machine.valve.ports[detail]).on == "entering":
            passed.append(Uncovering(detail, time - start, -float(place_row(machine, modes, reads.reads) @ now[:, 1])))
    flights = tuple(
        replace(flight, time=flight.time - start) for flight in motion.flights[first.flights : last.flights]
    )
    forgotten = np.zeros((2 * modes.omega.size, 2 * modes.omega.size))
    made = tuple(struck), tuple(changed), tuple(passed), forgotten, motion.rhythm(len(struck)), True
    given_up = math.fsum(motion.losses[first.losses : last.losses])
    return ElasticCycle(machine, modes.size, flights, *made, given_up)


# ---- The cycle in which an elastic machine ends: in the rhythm of its rigid piston, or in the one it is followed to

_BLOWS = (4, 8, 24, 48)  # after which a cycle is tried, one after the other: at first, only one with rest
_FORGOTTEN = 12  # blows after which little is left of the start
_MOST_IN_CYCLE = 4


@dataclass(frozen=True)
class Settled:
    """The cycle, None for none; what the motion did in the end; and what the first try met."""

    cycle: ElasticCycle | None
    ending: str | None
    first: Solved


def settled_from(machine: Machine, count: int, rhythm: Rhythm, rigid: RigidCycle | None) -> Settled:
    """The cycle near a rhythm where it is stable; else where the motion ends that begins as the rigid one does.

    Of a cycle it is looked, apart from the proof of each of its flights, whether it keeps before the wall.
    """
    found = _settled(machine, count, rhythm, rigid)
    sound = found.cycle is None or found.cycle.keeps_before_the_wall
    return found if sound else replace(found, cycle=None)


def _settled(machine: Machine, count: int, rhythm: Rhythm, rigid: RigidCycle | None) -> Settled:
    first = solved(machine, count, rhythm)
    if first.cycle is not None and first.cycle.stable:
        return Settled(first.cycle, None, first)
    if rigid is None:
        return Settled(first.cycle, None, first)
    modes = machine.modes(count)
    begin = np.zeros((count + 1, 2))
    begin[:, 1] = -rigid.rebound.speed * modes.centre
    motion = Following(machine, count, begin, rigid.rebound.state, rigid.rebound.orders, rigid.period)
    for blows in _BLOWS:
        motion.go_on(blows)
        if (resting := rest_cycle(motion)) is not None:
            return Settled(resting, None, first)
        if motion.ending is not None:
            return Settled(None, motion.ending, first)
        cycle = _cycle_at(machine, count, motion) if motion.blows >= _FORGOTTEN else None
        if cycle is not None:
            return Settled(cycle, None, first)
    return Settled(first.cycle, None, first)


def _cycle_at(machine: Machine, count: int, motion: Following) -> ElasticCycle | None:
    for blows in range(1, min(_MOST_IN_CYCLE, motion.blows - 1) + 1):
        rhythm = motion.rhythm(blows)
        if steps_of(machine.valve, rhythm) is not None:
            cycle = solved(machine, count, rhythm).cycle
            if cycle is not None and cycle.stable:
                return _shortest(machine, count, cycle)
    return None


def _shortest(machine: Machine, count: int, cycle: ElasticCycle) -> ElasticCycle:
    """The cycle, or that of fewer blows which it goes through again and again: what settles slowly looks longer."""
    for blows in range(1, cycle.blows):
        if cycle.blows % blows == 0:
            part = solved(machine, count, _part(cycle.rhythm, blows)).cycle
            if part is not None and abs(part.period * (cycle.blows // blows) - cycle.period) <= _SAME * cycle.period:
                return part
    return cycle


def _part(rhythm: Rhythm, blows: int) -> Rhythm:
    """That of the first blows, as if they were a cycle."""
    times = rhythm.blow_times[:blows]
    return replace(rhythm, blow_times=times, passages=tuple(one for one in rhythm.passages if one[0] <= times[-1]))
