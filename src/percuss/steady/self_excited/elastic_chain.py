"""The way of an elastic machine through a given order of events: what it must satisfy to repeat, and its derivatives.

Under a force that is constant between known times every coordinate goes through the cycle by one affine map of its own,
(u, v) → M (u, v) + c. So the state after the blow follows from the times of the events, and what is left to solve for
are these times: as many as there are ports passed and blows, whatever N (theory, "The machine that switches itself").
Derivatives are those of the state at the event, which moves in time with it: an impact is then diag(α, β) of its law,
and a jump of the force shows only in the accelerations on its two sides.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from typing import Any, Literal, NamedTuple, cast

import numpy as np
import numpy.typing as npt

from percuss.errors import ParameterError
from percuss.mechanics.flow import propagated, rates, response_of
from percuss.model import Machine, MachineModes, Valve
from percuss.model.checks import Array, count, finite, instance, numbers, several, text
from percuss.model.load.valve import MOST_PORTS, Orders
from percuss.steady.self_excited.rigid_cycle import RigidCycle

# ---- The flight of an elastic body under a constant force: every coordinate of the machine by itself


def energy_of(modes: MachineModes, state: Array) -> float:
    """Kinetic energy, and elastic energy with that of the chamber, of a state (N + 1, 2); per unit of mass."""
    strained, v = modes.omega * state[:, 0], state[:, 1]
    return 0.5 * float(v @ v + strained @ strained)


@dataclass(frozen=True)
class ModalFlight:
    """A stretch without an event.

    Parameters
    ----------
    modes
        The coordinates.
    state, last
        Of the valve, and what was demanded last.
    force
        Towards the wall.
    time, duration
        When it begins, and how long it lasts.
    begin
        Displacements and velocities of the coordinates at the start; shape (N + 1, 2).
    held
        Whether the bar has just left the wall at rest, so that no contact is looked for.
    """

    modes: MachineModes
    state: str
    last: str
    force: float
    time: float
    duration: float
    begin: Array
    held: bool = False

    def moved(self, t: Array) -> tuple[Array, Array]:
        """How far the coordinates have moved since its start, and velocities; each of shape (N + 1, len(t))."""
        ds, s, q = response_of(self.modes, t)
        v = self.begin[:, 1:]
        pull = (self.force * self.modes.driven - self.modes.omega**2 * self.begin[:, 0])[:, None]
        return v * s + pull * q, v * ds + pull * s

    def at(self, t: Array) -> tuple[Array, Array]:
        """Displacements and velocities of the coordinates at times after its start; each of shape (N + 1, len(t))."""
        moved, velocities = self.moved(t)
        return self.begin[:, :1] + moved, velocities

    @property
    def end(self) -> Array:
        """The state at its end; shape (N + 1, 2)."""
        ds, s, q = response_of(self.modes, np.array([self.duration]))
        return propagated(self.modes, self.begin, self.force, (ds[:, 0], s[:, 0], q[:, 0]))


# ---- Order and times of the events in a cycle of a machine that switches itself: what Newton's method starts from


class Step(NamedTuple):
    """An event of a cycle, in its order.

    Attributes
    ----------
    kind
        "port": a port is entered and demands; "due": the state changes; "blow".
    time
        As it was where the order was found.
    source
        The unknown that its time is: the number of the port's passage or of the blow, in their common order; of a
        "due", that of the event that demanded it, −1 for the blow at time 0.
    later
        What is added to that time: the delay of a "due".
    wrapped
        Whether the demand was made in the cycle before.
    port
        Number of the port.
    state
        Of the valve after the event.
    last
        The state that was demanded last, after the event.
    """

    kind: Literal["port", "due", "blow"]
    time: float
    source: int
    later: float
    wrapped: bool
    port: int
    state: str
    last: str


@dataclass(frozen=True)
class Rhythm:
    """When a machine strikes and passes its ports in a cycle, roughly: from a simulation, or from another cycle.

    Parameters
    ----------
    blow_times
        Of the blows after that at time 0; the last one is the period.
    passages
        Time and number of each port that demands, in order of time; blows that do are not among them.
    state, orders
        Of the valve just after the blow at time 0, before that blow demands anything.

    Examples
    --------
    >>> from percuss.model import Port, Valve
    >>> valve = Valve({"return": -0.4, "power": 1.8}, [Port("power", 1.0, "back"), Port("return", on="impact")])
    >>> events = [(1.5, "port", 0), (1.5, "valve", "power"), (3.0, "impact", 2.1)]
    >>> events += [(3.0, "port", 1), (3.0, "valve", "return")]
    >>> again = [(time + 3.0, kind, detail) for time, kind, detail in events]
    >>> Rhythm.of_events(valve, events + again).passages
    ((1.5, 0),)
    """

    blow_times: tuple[float, ...]
    passages: tuple[tuple[float, int], ...]
    state: str
    orders: Orders

    def __post_init__(self) -> None:
        times = numbers("blow_times", self.blow_times, "times after 0, in order").reshape(-1)
        if not times.size or times[0] <= 0.0 or np.any(np.diff(times) <= 0.0):
            raise ParameterError("blow_times", self.blow_times, "times after 0, in order")
        object.__setattr__(self, "blow_times", tuple(times.tolist()))
        object.__setattr__(self, "passages", _passages(self.passages))
        text("state", self.state, "the name of a state")
        instance("orders", self.orders, Orders)

    @property
    def period(self) -> float:
        """Duration of the cycle."""
        return self.blow_times[-1]

    @classmethod
    def of_rigid(cls, cycle: RigidCycle) -> Rhythm:
        """That of a rigid piston."""
        passages = tuple((uncovering.time, uncovering.port) for uncovering in cycle.uncoverings)
        return cls(tuple(cycle.blow_times.tolist()), passages, cycle.rebound.state, cycle.rebound.orders)

    @classmethod
    def of_events(cls, valve: Valve, events: Iterable[tuple[float, str, object]], blows: int = 1) -> Rhythm:
        """That of the last blows of a motion.

        Parameters
        ----------
        valve
            Which the motion switched.
        events
            All from the start on, in order: the time, what happened ("port", "valve" or "impact"; others are passed
            over), and the number of the port or the new state.
        blows
            In a cycle.

        Raises
        ------
        ParameterError
            When there are not more blows than in a cycle.
        """
        instance("valve", valve, Valve)
        return rhythm_of(valve, (valve.orders.last, valve.orders), events, count("blows", blows, most=64))


def rhythm_of(
    valve: Valve, begin: tuple[str, Orders], events: Iterable[tuple[float, str, object]], blows: int
) -> Rhythm:
    """As `Rhythm.of_events`, of a motion that began with any state and orders of the valve."""
    (state, orders), heard = begin, _events(valve, events)
    struck: list[tuple[int, float, str, Orders]] = []
    for i, (time, kind, detail) in enumerate(heard):
        if kind == "impact":
            struck.append((i, time, state, orders))
        elif kind == "port":
            assert isinstance(detail, int)
            orders = orders.after(time, valve.ports[detail])
        elif kind == "valve":
            state, orders = str(detail), replace(orders, pending=orders.pending[1:])
    if len(struck) <= blows:
        raise ParameterError("events", f"{len(struck)} blows", f"more than the {blows} of a cycle")
    first, start, state, orders = struck[-1 - blows]
    passages = tuple(
        (time - start, detail)
        for time, kind, detail in heard[first : struck[-1][0]]
        if kind == "port" and isinstance(detail, int) and valve.ports[detail].on == "entering"
    )
    pending = tuple((due - start, to) for due, to in orders.pending)
    times = tuple(time - start for _, time, _, _ in struck[-blows:])
    return Rhythm(times, passages, state, replace(orders, pending=pending))


_EVENT = "a time, what happened, and a port's number or a state"


def _passages(given: object) -> tuple[tuple[float, int], ...]:
    accepted = "the time and the number of each port"
    pairs = several("passages", cast("Iterable[Any]", given), accepted)
    if any(not isinstance(pair, tuple | list) or len(pair) != 2 for pair in pairs):
        raise ParameterError("passages", given, accepted)
    return tuple((finite("passages", time), count("passages", port, least=0, most=MOST_PORTS)) for time, port in pairs)


def _events(valve: Valve, given: Iterable[tuple[float, str, object]]) -> list[tuple[float, str, object]]:
    """The events, checked."""
    found: list[tuple[float, str, object]] = []
    for event in several("events", given, _EVENT):
        if not isinstance(event, tuple | list) or len(event) != 3:
            raise ParameterError("events", event, _EVENT)
        time, kind, detail = event
        if kind == "port":
            detail = count("events", detail, least=0, most=len(valve.ports) - 1)
        elif kind == "valve":
            valve.force(str(detail))
        found.append((finite("events", time), str(kind), detail))
    return found


def steps_of(valve: Valve, rhythm: Rhythm) -> tuple[Step, ...] | None:
    """Every event of a cycle, by the rules of the valve; None when the end of the cycle is not its beginning."""
    steps, now = _followed(valve, rhythm)
    return tuple(now.closed(steps)) if now.closes(rhythm) else None


def orders_after(valve: Valve, rhythm: Rhythm) -> Orders:
    """The orders just after the blow that ends a cycle, with times from that blow on."""
    orders = _followed(valve, rhythm)[1].orders
    return replace(orders, pending=tuple((due - rhythm.period, to) for due, to in orders.pending))


def _followed(valve: Valve, rhythm: Rhythm) -> tuple[list[Step], _Now]:
    """The steps of a cycle, and the valve at its end."""
    told = [(time, -1) for time in rhythm.blow_times] + list(rhythm.passages)
    told.sort(key=lambda event: (event[0], event[1] >= 0))
    steps: list[Step] = []
    now = _Now(valve, rhythm)
    now.strike(0.0, -1)
    for number, (time, port) in enumerate(told):
        steps += now.carried_out(time)
        if port < 0:
            steps.append(Step("blow", time, number, 0.0, False, -1, now.state, now.orders.last))
            if number < len(told) - 1:
                now.strike(time, number)
        else:
            now.demand(time, number, port)
            steps.append(Step("port", time, number, 0.0, False, port, now.state, now.orders.last))
    return steps, now


class _Now:
    """The valve on its way through the cycle, and which event demanded each order that is pending."""

    def __init__(self, valve: Valve, rhythm: Rhythm) -> None:
        self.valve, self.state, self.orders = valve, rhythm.state, rhythm.orders
        self.sources: dict[tuple[float, str], tuple[int, float, bool]] = {
            order: (-2 - i, 0.0, True) for i, order in enumerate(rhythm.orders.pending)
        }

    def strike(self, time: float, number: int) -> None:
        for i, port in enumerate(self.valve.ports):
            if port.on == "impact":
                self.demand(time, number, i)

    def demand(self, time: float, number: int, port: int) -> None:
        before, self.orders = self.orders, self.orders.after(time, self.valve.ports[port])
        if self.orders is not before:
            self.sources[self.orders.pending[-1]] = (number, self.valve.ports[port].delay, False)

    def carried_out(self, until: float) -> list[Step]:
        found = []
        while self.orders.pending and self.orders.pending[0][0] < until:
            order, *left = self.orders.pending
            source, later, wrapped = self.sources[order]
            self.state, self.orders = order[1], replace(self.orders, pending=tuple(left))
            found.append(Step("due", order[0], source, later, wrapped, -1, self.state, self.orders.last))
        return found

    def closes(self, rhythm: Rhythm) -> bool:
        """Whether the valve is in the end as it was at the beginning."""
        same = [to for _, to in self.orders.pending] == [to for _, to in rhythm.orders.pending]
        return same and (self.state, self.orders.last) == (rhythm.state, rhythm.orders.last)

    def closed(self, steps: list[Step]) -> list[Step]:
        """The steps, with the orders of the cycle before traced to the events of this one."""
        ends = [self.sources[order] for order in self.orders.pending]

        def traced(step: Step) -> Step:
            if not step.wrapped:
                return step
            source, later, _ = ends[-2 - step.source]
            return step._replace(source=source, later=later)

        return [traced(step) for step in steps]


# ---- The way of an elastic machine through a given order of events: what it must satisfy to repeat, and its
# derivatives


def place_row(machine: Machine, modes: MachineModes, place: str | float) -> Array:
    """What each coordinate moves a place of the body by, "centre" or 0 to 1."""
    return modes.centre if isinstance(place, str) else modes.at(machine.body, np.array([place]))[0]


@dataclass(frozen=True)
class Closed:
    """The motion that belongs to given times of the events, and how far it is from what it should be.

    Parameters
    ----------
    start
        Displacements and velocities of the coordinates just after the blow at time 0; shape (N + 1, 2).
    states
        … and just before each event; shape (steps, N + 1, 2).
    error
        Of the passages and of the blows before the last one, and of the first coordinate's position after the cycle.
    slope
        Its derivatives by the unknown times.
    """

    start: Array
    states: Array
    error: Array
    slope: Array


class Chain:
    """The events of a cycle in a fixed order.

    Parameters
    ----------
    machine, count
        The machine, and N.
    steps
        The events; the last one is the blow that ends the cycle.
    state, last
        Of the valve just after the blow at time 0, and what was demanded last.
    """

    def __init__(self, machine: Machine, count: int, steps: tuple[Step, ...], state: str, last: str) -> None:
        self.machine, self.modes, self.steps = machine, machine.modes(count), steps
        self.unknowns = sum(step.kind != "due" for step in steps)
        contact = machine.contact
        self.turn = np.array([contact.strain_factor, contact.velocity_factor])
        self.by = np.array([self._by(step) for step in steps])
        self.shift = np.array([step.later for step in steps])
        self.rows = np.array([self._row(step) for step in steps])
        self.levels = np.array([self._level(step) for step in steps])
        self.states = [state, *(step.state for step in steps[:-1])]
        self.lasts = [last, *(step.last for step in steps[:-1])]
        self.forces = [machine.valve.force(name) for name in self.states]

    def _by(self, step: Step) -> Array:
        by = np.zeros(self.unknowns)
        if step.source >= 0:
            by[step.source] += 1.0
        if step.wrapped:
            by[-1] -= 1.0
        return by

    def _row(self, step: Step) -> Array:
        if step.kind == "port":
            return place_row(self.machine, self.modes, self.machine.valve.ports[step.port].reads)
        return self.modes.end if step.kind == "blow" else 0.0 * self.modes.end

    def _level(self, step: Step) -> float:
        behind = self.machine.valve.ports[step.port].behind if step.kind == "port" else None
        return -(behind or 0.0)

    def sign(self, step: Step) -> float:
        """Whether the wall or the edge of a port is met on the way to the wall, 1, or away from it, −1."""
        return -1.0 if step.kind == "port" and self.machine.valve.ports[step.port].side == "back" else 1.0

    def times(self, unknowns: Array) -> Array:
        """When the events are."""
        return np.asarray(self.by @ unknowns + self.shift)

    def ways(self, times: Array) -> list[tuple[Array, Array, Array]]:
        """The responses of the coordinates from each event to the next one."""
        ds, s, q = response_of(self.modes, np.diff(times))
        return list(zip(ds.T, s.T, q.T, strict=True))

    def turns(self, number: int) -> bool:
        """Whether an event is a blow before the last one."""
        return self.steps[number].kind == "blow" and number < len(self.steps) - 1

    def closed(self, unknowns: Array) -> Closed:
        """The motion that closes in all but the position of the first coordinate, and strikes at the end."""
        size, m = self.modes.omega.size, self.unknowns
        times = np.concatenate([[0.0], self.times(unknowns)])
        by = np.vstack([np.zeros(m), self.by])
        ways = self.ways(times)
        now, fixed = np.array(np.broadcast_to(np.eye(2), (size, 2, 2))), np.zeros((size, 2))
        maps, offsets = [], []
        for i, force in enumerate(self.forces):
            now, fixed = propagated(self.modes, now, 0.0, ways[i]), propagated(self.modes, fixed, force, ways[i])
            maps.append(now)
            offsets.append(fixed)
            if self.turns(i):
                now, fixed = self.turn[:, None] * now, self.turn * fixed
        solve = _closing(self.modes.end, self.turn, now)
        start = solve(fixed[:, :, None])[:, :, 0]
        states = np.array([_applied(one, start) + rest for one, rest in zip(maps, offsets, strict=True)])
        moved, moves = np.zeros((size, 2, m)), []
        for i, force in enumerate(self.forces):
            moved = propagated(self.modes, moved, 0.0, ways[i])
            moved = moved + rates(self.modes, states[i], force)[:, :, None] * (by[i + 1] - by[i])
            moves.append(moved)
            if self.turns(i):
                moved = self.turn[:, None] * moved
        change = solve(moved)
        watched = [i for i, step in enumerate(self.steps[:-1]) if step.kind != "due"]
        error = [float(self.rows[i] @ states[i][:, 0]) - self.levels[i] for i in watched]
        slope = [self.rows[i] @ (np.einsum("nj,njk->nk", maps[i][:, 0], change) + moves[i][:, 0]) for i in watched]
        error.append(float(start[0, 0] - self.turn[0] * states[-1][0, 0]))
        slope.append(change[0, 0] - self.turn[0] * (maps[-1][0, 0] @ change[0] + moves[-1][0, 0]))
        return Closed(start, states, np.array(error), np.array(slope))


def _applied(maps: Array, state: Array) -> Array:
    return np.asarray(np.einsum("nij,nj->ni", maps, state))


def _closing(end: Array, turn: Array, maps: Array) -> Callable[[Array], Array]:
    """Solves (I − D M_n) x_n = D c_n for every coordinate, the striking end at the wall in place of the first line."""
    elastic = np.eye(2) - turn[:, None] * maps[1:]
    first = np.array([end[0] * maps[0, 0], np.array([0.0, 1.0]) - turn[1] * maps[0, 1]])

    def solved(c: Array) -> Array:
        """For the columns of c, shape (N + 1, 2, C)."""
        rest = np.linalg.solve(elastic, turn[:, None] * c[1:])
        beside = np.einsum("n,nj,njk->k", end[1:], maps[1:, 0], rest) + end[1:] @ c[1:, 0]
        own = np.linalg.solve(first, np.array([-beside - end[0] * c[0, 0], turn[1] * c[0, 1]]))
        return np.concatenate([own[None], rest])

    return solved


# ---- When a place of the body first enters a region in a flight, or the proof that it does not: bounds, not a scan
#
# In a cell of time of the width h, r, r′ and r″ are known at its left edge, and |r‴| is bounded from the free motion of
# the derivatives: the acceleration a of a coordinate obeys a″ + d a′ + ω² a = 0, so that in every regime of damping
# |a′| ≤ |a′₀| + ω² min(h, 1/ω)|a₀|. A cell is done with when Taylor's theorem proves that r keeps its sign there, or
# only falls, or only rises; others are halved.
#
# A place that leaves an edge is measured from there by how far it has moved, and not by where it is: the way back after
# a slow rebound is far less than the rounding error of a place. A rebound too short for the cells is a parabola.

_EPS = 2.0**-52
_CELLS = 32
_NARROWEST = 1e-13  # of the flight: narrower cells are not split
_MOST_WORK = 20_000_000  # coordinates × times
_BENT = 0.1  # of the acceleration: what the third derivative adds to it until a short rebound turns
_TOUCH = 1e-11  # of the levels: an edge met this nearly at the end of the flight is met there


@dataclass(frozen=True)
class Regions:
    """What is looked at: r = rows · displacements − levels, entered where r rises through 0.

    Parameters
    ----------
    rows, levels
        Shapes (k, N + 1) and (k,).
    scale
        Length against which a touch is small.
    """

    rows: Array
    levels: Array
    scale: float


@dataclass(frozen=True)
class Entering:
    """The first time at which a region is entered, infinite for none, which one, and whether this is proved."""

    time: float
    which: int
    proven: bool


@dataclass(frozen=True)
class _Cells:
    """r and its derivatives at left edges of cells, and the bound of the third; each of shape (k, cells)."""

    r: Array
    first: Array
    second: Array
    third: Array

    def greatest(self, h: float) -> Array:
        """A bound of r above, within the cells."""
        bent = np.maximum(self.second, 0.0) * (0.5 * h * h)
        return self.r + np.maximum(self.first, 0.0) * h + bent + self.third * (h**3 / 6.0)

    def least(self, h: float) -> Array:
        bent = np.minimum(self.second, 0.0) * (0.5 * h * h)
        return self.r + np.minimum(self.first, 0.0) * h + bent - self.third * (h**3 / 6.0)

    def greatest_rate(self, h: float) -> Array:
        return self.first + np.maximum(self.second, 0.0) * h + self.third * (0.5 * h * h)

    def least_rate(self, h: float) -> Array:
        return self.first + np.minimum(self.second, 0.0) * h - self.third * (0.5 * h * h)


_MOST_HALVINGS = 200  # each leaves at most half, or Newton's method converges


@dataclass(frozen=True)
class _Sight:
    """r of some rows in a flight, `off` being r at its start."""

    flight: ModalFlight
    rows: Array
    off: Array

    def cells(self, left: Array, h: float) -> _Cells:
        flight, modes = self.flight, self.flight.modes
        omega, damping = modes.omega[:, None], modes.damping[:, None]
        moved, v = flight.moved(left)
        a = (flight.force * modes.driven)[:, None] - omega**2 * (flight.begin[:, :1] + moved) - damping * v
        jerk = np.abs(omega**2 * v + damping * a) + omega * np.minimum(omega * h, 1.0) * np.abs(a)
        rows = self.rows
        return _Cells(self.off[:, None] + rows @ moved, rows @ v, rows @ a, np.abs(rows) @ jerk)

    def r(self, region: int, t: float) -> float:
        return float(self.off[region] + self.rows[region] @ self.flight.moved(np.array([t]))[0][:, 0])

    def root(self, region: int, start: float, stop: float) -> float:
        """Where r rises through 0 between two times: Newton's method, halving where it would leave them."""
        row, off, t = self.rows[region], self.off[region], 0.5 * (start + stop)
        for _ in range(_MOST_HALVINGS):
            moved, v = self.flight.moved(np.array([t]))
            r, rate = float(off + row @ moved[:, 0]), float(row @ v[:, 0])
            start, stop = (t, stop) if r < 0.0 else (start, t)
            step = t - r / rate if rate > 0.0 else start
            if abs(step - t) <= 4.0 * _EPS * stop or stop - start <= 4.0 * _EPS * stop:
                return t
            t = step if start < step < stop else 0.5 * (start + stop)
        return t

    def bounces(self, span: float) -> Array:
        """When what leaves an edge is back there, where the parabola from the start decides that; else infinite."""
        found, flight = np.full(len(self.rows), np.inf), self.flight
        omega, damping = flight.modes.omega, flight.modes.damping
        v, a = rates(flight.modes, flight.begin, flight.force).T
        first, second = self.rows @ v, self.rows @ a
        for region in np.flatnonzero((self.off == 0.0) & (first < 0.0) & (second > 0.0)).tolist():
            turned = float(-first[region] / second[region])
            jerk = np.abs(omega**2 * v + damping * a) + omega * np.minimum(3.0 * omega * turned, 1.0) * np.abs(a)
            bent = float(np.abs(self.rows[region]) @ jerk) * turned
            if 3.0 * turned <= span and bent <= _BENT * second[region]:
                found[region] = self.root(region, 1.5 * turned, 3.0 * turned)
        return found


def first_entering(flight: ModalFlight, regions: Regions) -> Entering:
    """The first region that is entered before the end of the flight; one whose edge is met at its end is not."""
    span, best, which, work, proven = flight.duration, np.inf, -1, 0, True
    if span <= 0.0 or not len(regions.rows):
        return Entering(np.inf, -1, True)
    h, touch = span / _CELLS, _TOUCH * regions.scale
    slow = touch / span
    off, leaves = regions.rows @ flight.begin[:, 0] - regions.levels, regions.rows @ flight.begin[:, 1] < 0.0
    sight = _Sight(flight, regions.rows, np.where((np.abs(off) <= touch) & leaves, 0.0, off))
    bounces = sight.bounces(span)
    bounced = np.isfinite(bounces)
    if bounced.any():
        best, which = float(bounces.min()), int(np.argmin(bounces))
    left: Array = _halved(h * np.arange(0, _CELLS, 2), 2.0 * h)
    while left.size:
        work += left.size * flight.modes.omega.size
        if h < _NARROWEST * span or work > _MOST_WORK:
            proven = False
            break
        now = sight.cells(left, h)
        from_rest = (now.r <= touch) & (now.first <= slow) & (now.second + now.third * h < 0.0)
        falls = now.greatest_rate(h) < 0.0
        sinks = (left == 0.0) & (now.r >= -touch) & (now.first >= -slow) & (now.second - now.third * h > 0.0)
        sinks &= ~bounced[:, None]
        if (at_once := np.any(sinks & (now.r <= touch), axis=1)).any():
            return Entering(0.0, int(np.argmax(at_once)), True)
        done = (now.greatest(h) < 0.0) | (now.least(h) > 0.0) | falls | from_rest | bounced[:, None]
        rises = ~done & (now.least_rate(h) > 0.0)
        for region, cell in zip(*np.nonzero(rises), strict=True):
            start = float(left[cell])
            stop = min(start + h, span)
            over = touch if stop >= span * (1.0 - 1e-12) else 0.0
            if now.r[region, cell] < 0.0 and start < best and sight.r(region, stop) > over:
                time = sight.root(region, start, stop)
                if time < best:
                    best, which = time, int(region)
        open_ = np.any(~(done | rises), axis=0) & (left < best)
        left = _halved(left[open_], h)
        h *= 0.5
    return Entering(best, which, proven)


def _halved(left: npt.NDArray[np.floating], h: float) -> Array:
    """Left edges of the halves of cells."""
    return np.asarray(np.sort(np.concatenate([left, left + 0.5 * h])), dtype=float)


def farthest(flight: ModalFlight, row: Array) -> float:
    """The greatest of −row · displacements in a flight, by bounds: cells that cannot hold it are dropped."""
    sight, span = _Sight(flight, -row[None, :], -row @ flight.begin[:, :1]), flight.duration
    best = max(sight.r(0, 0.0), sight.r(0, span))
    h = span / _CELLS
    left: Array = _halved(h * np.arange(0, _CELLS, 2), 2.0 * h)
    while left.size and h > _NARROWEST * span:
        now = sight.cells(left, h)
        best = max(best, float(now.r.max()))
        level = (now.greatest_rate(h)[0] < 0.0) | (now.least_rate(h)[0] > 0.0)  # the edges are looked at
        left = left[(now.greatest(h)[0] > best * (1.0 + 1e-14)) & ~level]
        if left.size == 1:  # the top: one cell, bent down all over it?
            only = sight.cells(left, h)
            if float(only.second[0, 0] + only.third[0, 0] * h) < 0.0:
                return max(best, _top(sight, float(left[0]), min(float(left[0]) + h, span)))
        left = _halved(left, h)
        h *= 0.5
    return best


def _top(sight: _Sight, start: float, stop: float) -> float:
    """The greatest r between two times between which it is bent down."""
    from scipy.optimize import brentq  # slow to import

    def rate(t: float) -> float:
        return float(sight.rows[0] @ sight.flight.moved(np.array([t]))[1][:, 0])

    if rate(start) <= 0.0 or rate(stop) >= 0.0:
        return max(sight.r(0, start), sight.r(0, stop))
    return sight.r(0, float(brentq(rate, start, stop, xtol=_EPS * stop, rtol=4.0 * _EPS)))
