"""A rigid piston that a pump and an accumulator feed, followed from event to event."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import numpy.typing as npt

from percuss.errors import ParameterError, PercussError
from percuss.halting import look
from percuss.model import Machine
from percuss.model.checks import Array, array, choice, finite
from percuss.model.load.valve import Orders
from percuss.simulate.engine import Progress
from percuss.simulate.kernels.motion_records import IMPACT, PORT, RELEASE, REST, VALVE
from percuss.simulate.machine.machine_events import MachineCycle, MachineEvents, machine_label
from percuss.simulate.machine.machine_start import MachineStart, placed, state_and_orders
from percuss.simulate.machine.machine_trajectory import MachineTrajectory, Side
from percuss.simulate.machine.mechanism import MachineBalance, mechanism, sway
from percuss.simulate.simulated_motion import drift, panels
from percuss.simulate.stop import Stop

if TYPE_CHECKING:
    import xarray


# ---- The flight of a rigid piston that draws from an accumulator, and the first of several things to happen in it
#
# The displacement obeys u″ + d u′ + K u = f + r t with K = κ + p²/c. What is watched for, places and an empty
# accumulator, are functions α + βu + γt. In a cell of time in which such a function is proved to have no turning point
# the signs at its ends decide; in one in which it is proved not to come to 0 nothing happens; any other cell is halved.

_SHARE = 0.5  # of the reciprocal frequency: a cell
_FINEST = 1e-14  # of a cell that is not halved any more, relative to the longest
_MOST_CELLS = 1 << 16
_EPS = 2.0**-52
_TERMS = 16


@dataclass(frozen=True)
class FedFlight:
    """The flight from a displacement u and a velocity v on.

    Parameters
    ----------
    u, v, pressure
        At its start.
    force, gas, stiffness, drag
        p of the state at the pressure 1, the chamber's force and stiffness, d.
    flow, compliance
        Of the supply.
    """

    u: float
    v: float
    pressure: float
    force: float
    gas: float
    stiffness: float
    drag: float
    flow: float
    compliance: float

    @property
    def spring(self) -> float:
        """K, of the gas and the accumulator together."""
        return self.stiffness + self.force**2 / self.compliance

    @property
    def ramp(self) -> float:
        """r, what the pump adds to the force in a unit of time."""
        return self.force * self.flow / self.compliance

    @property
    def push(self) -> float:
        """Acceleration at the start, without the drag."""
        return self.force * self.pressure + self.gas - self.stiffness * self.u

    def at(self, t: Array) -> tuple[Array, Array]:
        """Displacement and velocity at times from the start on."""
        w2, d = self.spring, self.drag
        h, integral = sway(d, math.sqrt(w2), t) if w2 > 0.0 else drift(d, t)
        twice = (t - h - d * integral) / w2 if self.ramp != 0.0 else 0.0 * t
        slope = 1.0 - d * h - w2 * integral
        u = self.u + self.v * h + self.push * integral + self.ramp * twice
        return u, self.v * slope + self.push * h + self.ramp * integral

    def at_time(self, t: float) -> tuple[float, float]:
        """The same at one time, which is what a search asks for."""
        w2, d = self.spring, self.drag
        h, integral = _answers(d, w2, t)
        twice = (t - h - d * integral) / w2 if self.ramp != 0.0 else 0.0
        u = self.u + self.v * h + self.push * integral + self.ramp * twice
        return u, self.v * (1.0 - d * h - w2 * integral) + self.push * h + self.ramp * integral

    def pressures(self, t: Array, u: Array) -> Array:
        """The pressure at times at which the displacement is u."""
        return np.asarray(self.pressure + (self.flow * t - self.force * (u - self.u)) / self.compliance)

    def pumped(self, t: float) -> float:
        """Work of the pump up to a time: flow times the integral of the pressure."""
        level = self.pressure * t + 0.5 * self.flow * t * t / self.compliance
        if self.ramp == 0.0:
            return self.flow * level
        u, v = self.at_time(t)
        way = self.push * t + 0.5 * self.ramp * t * t - (v - self.v) - self.drag * (u - self.u)
        return self.flow * (level - self.force / self.compliance * way / self.spring)

    @property
    def drifts(self) -> float:
        """The velocity of the line about which it swings."""
        return self.ramp / self.spring if self.ramp else 0.0

    def swing(self, u: float, v: float, t: float) -> tuple[float, float]:
        """Where the line is at a time, and how far from it the piston comes from then on at most."""
        if self.spring == 0.0:
            return u, math.inf
        line = (self.push + self.spring * self.u + self.ramp * t - self.drag * self.drifts) / self.spring
        return line, math.hypot(u - line, (v - self.drifts) / math.sqrt(self.spring)) * (1.0 + 1e-12)

    def push_at(self, u: float, t: float) -> float:
        """Acceleration at a time and place, without the drag."""
        return self.push - self.spring * (u - self.u) + self.ramp * t

    def most_acceleration(self, u: float, v: float, t: float, cell: float) -> float:
        """A bound of the acceleration over a cell from a time on."""
        here = self.push_at(u, t) - self.drag * v
        jerk = self.ramp - self.spring * v - self.drag * here
        if self.spring > 0.0:
            return min(math.hypot(here, jerk / math.sqrt(self.spring)), abs(here) + self._jerk(here, jerk) * cell)
        return abs(here)  # only a drag, which takes the acceleration away

    def _jerk(self, here: float, jerk: float) -> float:
        return math.hypot(jerk, math.sqrt(self.spring) * here)


class Watch(NamedTuple):
    """A function α + βu + γt, and the way in which it passes 0: +1 from below, −1 from above."""

    level: float
    of_place: float
    of_time: float
    way: float


class Passage(NamedTuple):
    """The first passage: when, and which of the functions."""

    time: float
    which: int


def flight_of(machine: Machine, state: str, u: float, v: float, pressure: float) -> FedFlight:
    """The flight of a machine's rigid piston in a state of its valve."""
    gas, supply = machine.valve.chamber, machine.valve.supply
    assert supply is not None
    force = dict(machine.valve.pairs)[state]
    return FedFlight(u, v, pressure, force, gas.force, gas.stiffness, machine.drag, supply.flow, supply.compliance)


def first_passage(flight: FedFlight, watched: Sequence[Watch], until: float, unit: float) -> Passage | None:
    """The first of the functions that passes 0 in its way, after the start and up to a time.

    Where the time is infinite, None says that none ever does, or that none does in very many swings.
    """
    longest = _SHARE / math.sqrt(flight.spring) if flight.spring > 0.0 else math.inf
    begin, cell = 0.0, min(longest, 0.25 * unit)
    for _ in range(_MOST_CELLS):
        look()
        end = min(begin + cell, until)
        found = _in_cell(flight, watched, begin, end, _FINEST * cell)
        if found is not None or end >= until:
            return found
        begin, cell = end, min(2.0 * cell, longest)
        if until == math.inf and never(flight, watched, begin):
            return None
    return None


def _answers(d: float, w2: float, t: float) -> tuple[float, float]:
    """The answer to a unit push of a damped motion on a spring, h(0) = 0 and h'(0) = 1, and its integral.

    By the power series where little has happened, else by the closed form.
    """
    if w2 * t * t < 0.25 and d * t < 0.5:
        x, y = d * t, w2 * t * t
        before, term, h, total = 0.0, 1.0, 1.0, 0.5
        for k in range(1, _TERMS):
            before, term = term, -(x * term + y * before / k) / (k + 1.0)
            h += term
            total += term / (k + 2.0)
        return t * h, t * t * total
    if w2 == 0.0:
        h = -math.expm1(-d * t) / d
        return h, (t - h) / d
    half = 0.5 * d
    square = half * half - w2
    fade = math.exp(-half * t)
    if square <= 1e-6 * half * half:
        rate = math.sqrt(abs(square))
        turn = rate * t
        if square > 0.0:
            shape, cosine = (math.sinh(turn) / turn if turn > 1e-9 else 1.0), math.cosh(turn)
        else:
            shape, cosine = (math.sin(turn) / turn if turn > 1e-9 else 1.0), math.cos(turn)
        h = fade * t * shape
        return h, (1.0 - fade * cosine - half * h) / w2
    fast = math.sqrt(square)
    rate = w2 / (half + fast)  # the slow rate without cancellation
    h = math.exp(-rate * t) * -math.expm1(-2.0 * fast * t) / (2.0 * fast)
    return h, (-math.expm1(-rate * t) - rate * h) / w2


def never(flight: FedFlight, watched: Sequence[Watch], time: float) -> bool:
    """Whether it is proved that none of the functions passes 0 from a time on."""
    u, v = flight.at_time(time)
    line, far = flight.swing(u, v, time)
    if flight.spring == 0.0:
        here = flight.push - flight.drag * v
        still = flight.drag > 0.0 and flight.push == 0.0
        ends = u + v / flight.drag if still else math.copysign(math.inf, v)
        going = v * flight.push >= 0.0 and (v != 0.0 or here != 0.0)
        return (going or still) and all(w.way * _value(w, ends, time) <= 0.0 for w in watched if w.of_time == 0.0)
    for w in watched:
        middle, swing = w.way * _value(w, line, time), abs(w.of_place) * far
        goes = w.way * (w.of_place * flight.drifts + w.of_time)
        if (middle + swing > 0.0 and goes <= 0.0 and middle - swing < 0.0) or (goes > 0.0 and middle <= swing):
            return False
        if goes < 0.0 and middle + swing > 0.0:
            return False
    return True


def _value(watch: Watch, u: float, t: float) -> float:
    return watch.level + watch.of_place * u + watch.of_time * t


def _in_cell(flight: FedFlight, watched: Sequence[Watch], begin: float, end: float, finest: float) -> Passage | None:
    """The first passage in a cell; halves of it wait, the later one first."""
    waiting = [(begin, end)]
    while waiting:
        a, b = waiting.pop()
        ends = (*flight.at_time(a), a), (*flight.at_time(b), b)
        most = flight.most_acceleration(*ends[0], b - a)
        passed, open_ = [], False
        for number, watch in enumerate(watched):
            verdict = _verdict(watch, *ends, most)
            open_ |= verdict is None
            if verdict:
                passed.append(number)
        if open_ and b - a > finest + 4.0 * _EPS * b:
            middle = 0.5 * (a + b)
            waiting += [(middle, b), (a, middle)]
            continue
        if passed:
            times = [(_passing(flight, watched[number], a, b), number) for number in passed]
            return Passage(*min(times))
    return None


def _verdict(
    watch: Watch, begin: tuple[float, float, float], end: tuple[float, float, float], most: float
) -> bool | None:
    """Whether a function passes 0 in a cell, from displacement, velocity and time at its ends; None: it may."""
    a, cell, bend = begin[2], end[2] - begin[2], abs(watch.of_place) * most
    first, last = (watch.way * _value(watch, u, t) for u, _, t in (begin, end))
    rise, later = (watch.way * (watch.of_place * v + watch.of_time) for _, v, _ in (begin, end))
    if a == 0.0 and abs(first) <= 1e-15 * abs(watch.level):
        first = 0.0
    if rise * later > 0.0 and abs(rise) + abs(later) > bend * cell:
        if rise < 0.0 or (a == 0.0 and first == 0.0):
            return False
        return first < 0.0 <= last
    reach = abs(rise) * cell + 0.5 * bend * cell * cell
    if abs(first) > reach:
        return False
    return None


def _passing(flight: FedFlight, watch: Watch, a: float, b: float) -> float:
    """When a function that rises over a cell passes 0 in it."""
    from scipy.optimize import brentq  # slow to import

    def value(t: float) -> float:
        return watch.way * _value(watch, flight.at_time(t)[0], t)

    if value(b) <= 0.0:
        return b
    if value(a) >= 0.0:
        return a
    return float(brentq(value, a, b, xtol=_EPS * b, rtol=4.0 * _EPS))


# ---- Whether the blows of a machine with a supply repeat: speed, pressure and orders together

_MOST_IN_CYCLE = 16
_TWICE = 2  # times in a row that a cycle must be met


class Blow(NamedTuple):
    """A blow: when, how fast, what it took, and the state just after it; `event` counts the events up to it."""

    time: float
    speed: float
    lost: float
    label: tuple[str, ...]
    numbers: Array
    event: int
    rested: bool


def cycle_in(blows: Sequence[Blow], events: Sequence[tuple[float, ...]], tolerance: float) -> MachineCycle | None:
    """The cycle that the last blows have been on twice, of at most 16 of them."""
    for n in range(1, _MOST_IN_CYCLE + 1):
        if len(blows) <= _TWICE * n:
            return None
        last = blows[-_TWICE * n :]
        before = blows[-_TWICE * n - n : -n]
        if all(_alike(now, then, tolerance) for now, then in zip(last, before, strict=False)):
            return _cycle(blows, events, n)
    return None


def _alike(now: Blow, then: Blow, tolerance: float) -> bool:
    if now.label != then.label:
        return False
    scale = np.maximum(np.abs(now.numbers), np.abs(then.numbers))
    return bool(np.all(np.abs(now.numbers - then.numbers) <= tolerance * np.maximum(scale, 1e-6)))


def _cycle(blows: Sequence[Blow], events: Sequence[tuple[float, ...]], n: int) -> MachineCycle:
    own = blows[-n:]
    changes = [int(event[6]) for event in events[blows[-n - 1].event : blows[-1].event] if event[0] == VALVE]
    turns = changes.count(changes[0]) if changes else 1
    return MachineCycle(
        first=max(len(blows) - (_TWICE + 1) * n, 0),
        blows=n,
        valve_cycles=turns,
        kind=int(any(blow.rested for blow in own)),
        period=own[-1].time - blows[-n - 1].time,
        energy_lost=float(sum(blow.lost for blow in own)),
        blow_speed=max(blow.speed for blow in own),
    )


# ---- A simulated motion of a machine that a pump and an accumulator feed: where the piston is, and the pressure

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


# ---- A rigid piston that a pump and an accumulator feed, followed from event to event

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
            before, self.state = self.state, self.orders.pending[0][1]
            self.orders = Orders(self.orders.last, self.orders.pending[1:])
            if self.state != before:
                self.record(int(VALVE), self.v, self.v)

    def next_event(self, until: float) -> str:
        """Goes on to the next event, or to a time; what ended the motion, or nothing."""
        self.carry_out()
        due = self.orders.pending[0][0] if self.orders.pending else math.inf
        stop, flight = min(due, until), self.flight
        if self.u == 0.0 and self.v == 0.0 and (flight.push > 0.0 or (flight.push == 0.0 and flight.ramp >= 0.0)):
            return self._lie(flight, due, until)
        if self.lies:
            self.lies = False
            self.record(int(RELEASE), 0.0, 0.0)
        watched = [self.wall, *self.edges]
        if flight.force != 0.0:  # the accumulator
            c = flight.compliance
            watched.append(Watch(self.pressure + flight.force * self.u / c, -flight.force / c, flight.flow / c, -1.0))
        duration = (stop - self.time) * (1.0 + _TOGETHER)
        found = first_passage(flight, watched, duration, mechanism(self.machine, 0).unit)
        if found is None:
            span = stop - self.time
            stalls = due == math.inf and (span == math.inf or never(flight, watched, span))
            if span < math.inf:
                self._fly(flight, stop, None)
            if stalls:
                return "leaves" if self._leaves(flight) else "in the chamber"
            return "time" if self.time >= until and due > until else ""
        self._fly(flight, stop, found.time)
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

    def _lie(self, flight: FedFlight, due: float, until: float) -> str:
        """On the wall until an order is due, a growing pressure lifts the piston, or for ever."""
        if not self.lies:
            self.lies = self.rested = True
            self.record(int(REST), 0.0, 0.0)
        growth = flight.flow / flight.compliance
        lifted = self.time + flight.push / -flight.ramp if flight.ramp < 0.0 else math.inf
        stop = min(due, until)
        if lifted < stop:
            self.pressure = -flight.gas / flight.force
            while self.flight.push > 0.0:
                self.pressure = math.nextafter(self.pressure, math.inf)
            self.time = lifted
            return ""
        if stop < math.inf:
            self.pressure += growth * (stop - self.time)
            self.time = stop
        if min(due, lifted) == math.inf:
            return "on the tool"
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
    from percuss.simulate.machine.machine_events import STALLS

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
        end_time=max(begin + going.time, float(events.time[-1]) if len(events) else begin),
        snapshot={},
    )
