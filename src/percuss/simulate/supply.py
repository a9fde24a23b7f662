"""A rigid piston that a pump and an accumulator feed: its flights, and its motion from event to event."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, field
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from percuss.errors import PercussError
from percuss.halting import look
from percuss.model import Machine
from percuss.model.checks import Array
from percuss.model.load.valve import Orders
from percuss.simulate.engine import Progress
from percuss.simulate.events import IMPACT, PORT, RELEASE, REST, STALLS, VALVE, Cycle, Events, machine_label
from percuss.simulate.flights import Anchor, Modes, Moved, drift, sway
from percuss.simulate.start import Start
from percuss.simulate.stop import Stop
from percuss.simulate.valve import Mechanism

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

    Where the time is infinite, None says that none ever does, or that none does in very many swings. The cells do not
    end at that time, so that a motion that goes on finds the same bits.
    """
    longest = _SHARE / math.sqrt(flight.spring) if flight.spring > 0.0 else math.inf
    begin, cell = 0.0, min(longest, 0.25 * unit)
    for _ in range(_MOST_CELLS):
        look()
        end = begin + cell
        found = _in_cell(flight, watched, begin, end, _FINEST * cell)
        if found is not None:
            return found if found.time <= until else None
        if end >= until:
            return None
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


# ---- The machine as a motion is told of


@dataclass(frozen=True)
class Supplied(Mechanism):
    """A machine with a supply, of which a state is displacement, velocity and pressure."""

    def states(self, rows: Array, phase: Array, piece: npt.NDArray[np.int64]) -> tuple[Array, Array]:
        """See `Flights`."""
        return rows[:, :1], rows[:, 1:2]

    def after(self, anchor: Anchor, tau: Array) -> Modes:
        """See `Flights`."""
        u, v, pressure = anchor.row.tolist()
        place, rate = flight_of(self.machine, self.names[anchor.piece], u, v, pressure).at(tau)
        return Modes(place[None], rate[None])

    def force(self, motion: Moved, t: Array) -> Array:
        """See `Flights`."""
        valve = self.machine.valve
        oil = np.array([force for _, force in valve.pairs])[motion.state(t)] * motion.pressure(t)
        return np.asarray(oil + valve.chamber.force - valve.chamber.stiffness * motion.modal(t).displacement[0])

    def put_in(self, motion: Moved, t: Array, velocity: Array) -> Array:
        """See `Flights`: by the pump, and the constant part of the chamber's force."""
        supply = self.machine.valve.supply
        assert supply is not None
        return np.asarray(supply.flow * motion.pressure(t) + self.machine.valve.chamber.force * velocity[0])

    def stored(self, motion: Moved, t: Array, displacement: Array) -> Array | float:
        """See `Flights`: in the gas and in the accumulator."""
        supply, stiffness = self.machine.valve.supply, self.machine.valve.chamber.stiffness
        assert supply is not None
        return np.asarray(0.5 * stiffness * displacement[0] ** 2 + 0.5 * supply.compliance * motion.pressure(t) ** 2)

    def lost(self, velocity: Array) -> Array:
        """See `Flights`."""
        return np.asarray(self.machine.drag * velocity[0] ** 2)

    @property
    def rates(self) -> tuple[float, float]:
        """See `Flights`."""
        springs = [flight_of(self.machine, name, 0.0, 0.0, 1.0).spring for name in self.names]
        return max(math.sqrt(max(springs)), 1e-300), self.machine.drag


# ---- Whether the blows of a machine with a supply repeat: speed, pressure and orders together

_MOST_IN_CYCLE = 16
_TWICE = 2  # times in a row that a cycle must be met


class Blow(NamedTuple):
    """A blow: when, how fast, what it took, the state just after it, and the states of the valve up to it."""

    time: float
    speed: float
    lost: float
    label: tuple[str, ...]
    numbers: tuple[float, ...]
    changes: tuple[str, ...]
    rested: bool


def cycle_in(blows: Sequence[Blow], impacts: int, tolerance: float) -> Cycle | None:
    """The cycle that the last blows have been on twice, of at most 16 of them; `impacts`: all so far."""
    for n in range(1, _MOST_IN_CYCLE + 1):
        if len(blows) <= _TWICE * n:
            return None
        last = blows[-_TWICE * n :]
        before = blows[-_TWICE * n - n : -n]
        if all(_alike(now, then, tolerance) for now, then in zip(last, before, strict=False)):
            own = blows[-n:]
            changes = [to for blow in own for to in blow.changes]
            return Cycle(
                first=max(impacts - (_TWICE + 1) * n, 0),
                impacts=n,
                periods=changes.count(changes[0]) if changes else 1,
                kind=int(any(blow.rested for blow in own)),
                period=own[-1].time - blows[-n - 1].time,
                energy_lost=float(sum(blow.lost for blow in own)),
                blow_speed=max(blow.speed for blow in own),
            )
    return None


def _alike(now: Blow, then: Blow, tolerance: float) -> bool:
    return now.label == then.label and all(
        abs(a - b) <= tolerance * max(abs(a), abs(b), 1e-6) for a, b in zip(now.numbers, then.numbers, strict=True)
    )


# ---- A rigid piston that a pump and an accumulator feed, followed from event to event

_CHATTER = 1e-10  # of the fastest blow: a slower rebound at a wall to which the valve pushes is at rest
_TOGETHER = 1e-12  # of a flight: an event this little after an order is due comes before it
_MOST_SWITCHES = 1000  # without a blow, in next to no time
_MANY = 60  # blows without a cycle that tell an irregular motion
_FOR_EVER = ("time", "on the tool", "in the chamber", "leaves")
_AGAIN = "use a copy of its file, or simulate again"


@dataclass
class FedState:
    """Where a piston stands: all that the next event depends on; `changes`: states of the valve since the last blow."""

    u: float
    v: float
    pressure: float
    state: str
    last: str
    pending: list[tuple[float, str]]
    time: float = 0.0
    lies: bool = False
    fastest: float = 0.0
    rested: bool = False
    impacts: int = 0
    idle: int = 0
    changes: list[str] = field(default_factory=list)
    blows: list[Blow] = field(default_factory=list)

    def kept(self) -> dict[str, npt.NDArray[Any]]:
        """As an array that a file can hold."""
        return {"supply": np.frombuffer(json.dumps(asdict(self)).encode(), dtype=np.uint8)}

    @classmethod
    def of(cls, kept: dict[str, npt.NDArray[Any]], names: Sequence[str]) -> FedState:
        """The state again.

        Raises
        ------
        PercussError
            When a simulation cannot have left it: it comes from a file that was changed, or made up.
        """
        try:
            about = json.loads(kept["supply"].tobytes())
            about["pending"] = [(float(due), str(to)) for due, to in about["pending"]]
            blows = (Blow(*blow) for blow in about["blows"])
            about["blows"] = [
                blow._replace(label=tuple(blow.label), numbers=tuple(blow.numbers), changes=tuple(blow.changes))
                for blow in blows
            ]
            made = cls(**about)
            told = {made.state, made.last, *(to for _, to in made.pending), *made.changes}
            if not told <= set(names) or not all(map(math.isfinite, (made.u, made.v, made.pressure, made.time))):
                raise ValueError("its numbers are none of a motion")
        except (LookupError, TypeError, ValueError, AttributeError) as error:
            raise PercussError(f"the state to continue from is damaged: {str(error)[:200]}", _AGAIN) from None
        return made


@dataclass
class Fed:
    """A motion on its way, with the events since it began or went on, and the states after them."""

    machine: Machine
    now: FedState
    events: list[tuple[float, ...]] = field(default_factory=list)
    rows: list[tuple[float, float, float]] = field(default_factory=list)
    modes: int = 0

    def __post_init__(self) -> None:
        valve = self.machine.valve
        self.names = [name for name, _ in valve.pairs]
        self.entered = [i for i, port in enumerate(valve.ports) if port.behind is not None]
        self.watched = [Watch(0.0, 1.0, 0.0, 1.0)] + [
            Watch(port.behind, 1.0, 0.0, -1.0 if port.side == "back" else 1.0)
            for port in valve.ports
            if port.behind is not None
        ]

    @classmethod
    def begun(cls, machine: Machine, start: Start) -> tuple[Fed, Anchor, bool]:
        """A motion put at a start, the state there, and whether it rests on the wall."""
        state, orders = start.valve_of(machine)
        u, v, _ = start.state(0, machine)
        supply = machine.valve.supply
        assert supply is not None
        pending = [(due, to) for due, to in orders.pending]
        self = cls(machine, FedState(float(u[0]), float(v[0]), supply.start, state, orders.last, pending))
        now = self.now
        row, piece = np.array([now.u, now.v, now.pressure]), self.names.index(state)
        now.lies = now.u == now.v == 0.0 and self.flight.push > 0.0
        lies = now.lies
        if start.orders is None:
            self._occupied()
        return self, Anchor(start.time, piece, row), lies

    @classmethod
    def restored(cls, machine: Machine, snapshot: dict[str, npt.NDArray[Any]]) -> Fed:
        """A motion that goes on."""
        return cls(machine, FedState.of(snapshot, [name for name, _ in machine.valve.pairs]))

    @property
    def flight(self) -> FedFlight:
        """From where the piston stands on."""
        now = self.now
        return flight_of(self.machine, now.state, now.u, now.v, now.pressure)

    def _record(self, code: int, before: float, after: float, lost: float = 0.0, port: int = -1) -> None:
        now, kinetic = self.now, 0.5 * before * before if code == IMPACT else 0.0
        state = self.names.index(now.state)
        self.events.append((float(code), now.time, before, after, lost, kinetic, float(state), float(port)))
        self.rows.append((now.u, now.v, now.pressure))

    def _demand(self, number: int) -> None:
        """A port demands its state."""
        now = self.now
        before = Orders(now.last, tuple(now.pending))
        after = before.after(now.time, self.machine.valve.ports[number])
        if after is not before:
            now.last, now.pending = after.last, list(after.pending)
            self._record(PORT, now.v, now.v, port=number)
        self._carry_out()

    def _carry_out(self) -> None:
        """Changes the state by the orders that are due."""
        now = self.now
        while now.pending and now.pending[0][0] <= now.time:
            before, now.state = now.state, now.pending.pop(0)[1]
            if now.state != before:
                now.changes.append(now.state)
                self._record(VALVE, now.v, now.v)

    def _occupied(self) -> None:
        """Ports whose region is occupied at the start demand at once."""
        now, ports = self.now, self.machine.valve.ports
        push = self.flight.push - self.flight.drag * now.v
        outwards = now.v < 0.0 or (now.v == 0.0 and push < 0.0)
        for i in self.entered:
            edge = -float(ports[i].behind or 0.0)
            inside = now.u < edge or (now.u == edge and outwards)
            if inside == (ports[i].side == "back"):
                self._demand(i)

    def _next_event(self, until: float) -> str:
        """Goes on to the next event that comes before a time; what ended the motion, or nothing."""
        self._carry_out()
        now, flight = self.now, self.flight
        due = now.pending[0][0] if now.pending else math.inf
        if now.u == 0.0 and now.v == 0.0 and (flight.push > 0.0 or (flight.push == 0.0 and flight.ramp >= 0.0)):
            return self._lie(flight, due, until)
        if now.lies:
            now.lies = False
            self._record(RELEASE, 0.0, 0.0)
        watched, span = list(self.watched), min(due, until) - now.time
        if flight.force != 0.0:  # the accumulator
            c = flight.compliance
            watched.append(Watch(now.pressure + flight.force * now.u / c, -flight.force / c, flight.flow / c, -1.0))
        found = first_passage(flight, watched, span * (1.0 + _TOGETHER), self.machine.valve.time_unit)
        if found is None:
            if due == math.inf and (span == math.inf or never(flight, watched, span)):
                return "leaves" if flight.drifts < 0.0 or flight.spring == 0.0 else "in the chamber"
            if due > until:  # nothing moved, so that going on gives the same bits
                return "time"
            self._fly(flight, due - now.time)
            now.time = due
            return ""
        self._fly(flight, found.time)
        if found.which == 0:
            self._strike()
        elif found.which < len(self.watched):
            now.u = -float(self.machine.valve.ports[self.entered[found.which - 1]].behind or 0.0)
            self._demand(self.entered[found.which - 1])
        else:
            return "without pressure"
        return ""

    def _lie(self, flight: FedFlight, due: float, until: float) -> str:
        """On the wall until an order is due, a growing pressure lifts the piston, or for ever."""
        now = self.now
        if not now.lies:
            now.lies = now.rested = True
            self._record(REST, 0.0, 0.0)
        lifted = now.time + flight.push / -flight.ramp if flight.ramp < 0.0 else math.inf
        if lifted < min(due, until):
            now.pressure = -flight.gas / flight.force
            while self.flight.push > 0.0:
                now.pressure = math.nextafter(now.pressure, math.inf)
            now.time = lifted
        elif min(due, lifted) == math.inf:
            return "on the tool"
        elif due >= until:
            return "time"
        else:
            now.pressure += flight.flow / flight.compliance * (due - now.time)
            now.time = due
        return ""

    def _fly(self, flight: FedFlight, spent: float) -> None:
        now = self.now
        now.u, now.v = flight.at_time(spent)
        now.pressure += (flight.flow * spent - flight.force * (now.u - flight.u)) / flight.compliance
        now.time += spent

    def _strike(self) -> None:
        now, before = self.now, self.now.v
        now.u, now.v = 0.0, self.machine.contact.velocity_factor * before
        now.fastest, now.impacts = max(now.fastest, before), now.impacts + 1
        lost = 0.5 * (before**2 - now.v**2)
        self._record(IMPACT, before, now.v, lost)
        if self.flight.push > 0.0 and abs(now.v) < _CHATTER * now.fastest:
            now.v = 0.0
        label = (now.state, now.last, *(to for _, to in now.pending))
        numbers = (before / max(now.fastest, 1e-300), now.pressure, *(due - now.time for due, _ in now.pending))
        now.blows.append(Blow(now.time, before, lost, label, numbers, tuple(now.changes), now.rested))
        del now.blows[: -(_TWICE + 1) * _MOST_IN_CYCLE - 1]
        now.rested, now.changes = False, []
        for i, port in enumerate(self.machine.valve.ports):
            if port.on == "impact":
                self._demand(i)

    def _to_the_end(self, stop: Stop, progress: Callable[[Progress], object] | None) -> str:
        until, now = math.inf if stop.time is None else stop.time, self.now
        while now.impacts < stop.most_impacts:
            events, time, struck = len(self.events), now.time, now.impacts
            ended = self._next_event(until)
            now.idle = 0 if now.time > time or len(self.events) == events else now.idle + 1
            if ended or now.idle > _MOST_SWITCHES:
                return ended or "on a port"
            if now.impacts > struck:
                if stop.periodic and cycle_in(now.blows, now.impacts, stop.tolerance) is not None:
                    return "periodic"
                fraction = now.impacts / max(stop.most_impacts, 1)
                if stop.time is not None:
                    fraction = max(fraction, now.time / stop.time)
                if progress is not None and progress(Progress(now.impacts, now.time, min(fraction, 1.0))):
                    return "cancelled"
        return "impacts"

    def followed(
        self, stop: Stop, begin_time: float, progress: Callable[[Progress], object] | None = None
    ) -> dict[str, Any]:
        """The motion on until the stop rule holds; what a `Trajectory` has of it, by the names of its fields."""
        ended, now = self._to_the_end(stop, progress), self.now
        cycle = cycle_in(now.blows, now.impacts, stop.tolerance)
        columns = np.array(self.events, dtype=float).reshape(-1, 8).T
        events = Events(
            code=columns[0].astype(np.int8),
            period=np.zeros(columns.shape[1], dtype=np.int64),
            phase=begin_time + columns[1],
            impact_velocity=columns[2],
            rebound_velocity=columns[3],
            energy_lost=columns[4],
            kinetic_energy=columns[5],
            resolved=np.zeros(columns.shape[1], dtype=np.int64),
            piece=columns[6].astype(np.int64),
            port=columns[7].astype(np.int64),
            states=tuple(self.names),
        )
        known = now.time if stop.time is None or ended not in _FOR_EVER else stop.time
        return {
            "events": events,
            "states": np.array(self.rows).reshape(-1, 3),
            "snapshot": now.kept(),
            "outcome": "stalls" if ended in STALLS else ended,
            "label": machine_label(ended, cycle, cycle is None and now.impacts > _MANY),
            "cycle": cycle,
            "end_time": max(begin_time + known, float(events.time[-1]) if len(events) else begin_time),
        }
