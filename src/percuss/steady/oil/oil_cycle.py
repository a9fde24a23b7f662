"""The cycle of a machine whose oil flows: Newton's method on the passage of a port, from a motion that has settled."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from percuss.halting import check_interrupted
from percuss.mechanics import oil_records as kn
from percuss.mechanics.oil import OilEvent, OilMachine, OilMotion, oil_kernels, oil_machine, states_at
from percuss.model import Machine
from percuss.model.checks import Array
from percuss.model.load.valve import Orders, port_at
from percuss.steady.self_excited.valve_cycle import Rebound, ValveCycle, ValveFlight, cycle_told

_SETTLING, _LONGER, _MOST = 12, 160, 1200  # blows that are followed
_NEWTON, _LEADS = 24, 0.1  # steps, and how much less the next one is where derivatives are kept
_NEAR, _CLOSE = 1e-9, 1e-11  # steps after which derivatives are renewed, and, where they are, nothing is left to do
_SHORTER = 1e-7  # of the scales: a cycle that is one of fewer blows
_ALIKE = 1e-3  # blows that differ by no more may repeat
_MOST_BLOWS = 8  # in a cycle
_LOOKS = 96  # times of a period in which a chamber's pressure is looked at


@dataclass(frozen=True, kw_only=True)
class OilFlight(ValveFlight):
    """A flight of Taylor steps: those recorded from its start on, and the numbers of its machine."""

    numbers: OilMachine
    steps: tuple[Array, ...]

    @property
    def lies(self) -> bool:
        """Whether the bar lies on the wall."""
        return bool(self.steps) and bool(self.steps[0][7])

    def looked(self, t: Array) -> tuple[Array, Array, Array]:
        """Bar (2, N + 1, t), pressure and force at times after its start."""
        n, none = self.numbers.modes + 1, t.size == 0 or not self.steps
        if none:
            bar = np.repeat(self.begin.T[:, :, None], t.size, axis=2).reshape(2, n, t.size)
            return bar, np.full(t.size, self.pressure), np.full(t.size, self.force)
        begins = np.array([step[0] for step in self.steps]) - self.time
        which = np.clip(np.searchsorted(begins, t, side="right") - 1, 0, len(self.steps) - 1)
        return states_at(self.numbers, self.steps, t - begins[which], which.astype(np.int64))

    def at(self, t: Array) -> tuple[Array, Array]:
        """Displacements and velocities of the coordinates at times after its start; each of shape (N + 1, len(t))."""
        bar = self.looked(np.asarray(t, dtype=float))[0]
        return bar[0], bar[1]

    def moved(self, t: Array) -> tuple[Array, Array]:
        """How far the coordinates have moved since its start, and velocities."""
        places, rates = self.at(t)
        return places - self.begin[:, :1], rates

    @property
    def farthest(self) -> float:
        """The greatest distance of the striking end from the wall, looked for at many times."""
        seen = self.modes.end @ self.at(np.linspace(0.0, self.duration, _LOOKS))[0]
        return float(-seen.min())


class OilSettled(NamedTuple):
    """Where a machine ends: its cycle, or how the motion ended: "on the wall", "nothing follows", "no pressure", …."""

    cycle: ValveCycle | None
    ending: str = ""
    motion: OilMotion | None = None
    starts: bool = False


# ---- A motion from a start


def from_rest(numbers: OilMachine) -> OilMotion:
    """At rest on the wall, under the pressure at the start; the ports whose regions are occupied demand."""
    valve, n = numbers.machine.valve, numbers.modes + 1
    orders, supply = valve.orders, valve.supply
    pressure = 1.0 if supply is None else supply.start
    motion = OilMotion.begun(numbers, np.zeros((n, 2)), pressure, orders.last, orders, resting=True)
    motion.run(0.0, entering=[i for i, port in enumerate(valve.ports) if port.sign * port.level < 0.0])
    return motion


def from_rebound(numbers: OilMachine, start: Rebound) -> OilMotion:
    """Just after a blow, which demands; the bar is undeformed."""
    own = numbers.own
    bar = np.stack([0.0 * own.centre, -start.speed * own.centre], axis=1)
    pressure = 1.0 if start.pressure is None else start.pressure
    motion = OilMotion.begun(numbers, bar, pressure, start.state, start.orders, struck=True)
    motion.run(0.0, entering=[i for i, port in enumerate(numbers.machine.valve.ports) if port.on == "impact"])
    return motion


def goes_on(motion: OilMotion, blows: int) -> str:
    """So many blows more, or why not."""
    wanted = motion.blows + blows
    while motion.blows < wanted:
        before, idle = motion.blows, motion.idle
        ended = motion.run(motion.time + idle, wanted, most=1 << 18)
        if ended == kn.NO_PRESSURE or ended == kn.EMPTY_LINE:
            return "no pressure"
        if motion.blows == before:
            if motion.state.now[kn.RESTING] > 0.0:
                return "on the wall"
            return "no blow" if any(e.time > motion.time - idle and e.kind == "valve" for e in motion.events[-8:]) \
                else "nothing follows"  # fmt: skip
    return ""


# ---- The passage of a port, and Newton's method on it


class OilUnknowns(NamedTuple):
    """What may change at the passage of a port: bar, pressure, orders that wait, and a running stroke."""

    fed: bool
    coordinates: int
    waiting: int
    stroke: bool

    @classmethod
    def of(cls, numbers: OilMachine, state: kn.OilState) -> OilUnknowns:
        stroke = bool(state.now[kn.STROKE] < math.inf)
        return cls(numbers.fed, numbers.modes + 1, int(state.now[kn.COUNT]), stroke)

    @property
    def size(self) -> int:
        return 2 * self.coordinates + self.fed + self.waiting + self.stroke

    def values(self, state: kn.OilState) -> Array:
        now, time = state.now, state.now[kn.TIME]
        dues = state.orders[: self.waiting, 0] - time
        return np.concatenate([
            state.bar.reshape(-1), [now[kn.PRESSURE]] * self.fed, dues, [now[kn.STROKE] - time] * self.stroke,
        ])  # fmt: skip

    def put(self, state: kn.OilState, values: Array, before: Array) -> None:
        """The values into a state at time 0; the blend of a running stroke follows its end."""
        n, fed = 2 * self.coordinates, int(self.fed)
        state.bar[:] = values[:n].reshape(2, -1)
        if fed:
            state.now[kn.PRESSURE] = values[n]
        state.orders[: self.waiting, 0] = values[n + fed : n + fed + self.waiting]
        if self.stroke:
            state.now[kn.STROKE] = values[-1]
            state.blend[0] -= state.blend[1] * (values[-1] - before[-1])

    def seeded(self, state: kn.OilState) -> None:
        """A direction for each of them."""
        n, fed = 2 * self.coordinates, int(self.fed)
        for i in range(n + fed):
            state.bars[i, i] = 1.0
        for i in range(self.waiting):
            state.dues[i, n + fed + i] = 1.0
        if self.stroke:
            state.shift[-1] = 1.0
            state.blends[0, :, -1] = -state.blend[1, :4]

    def map(self, motion: OilMotion, row: Array) -> tuple[Array, Array]:
        """The derivatives of what is there when the port is met again, (size, size), and of when, (size,)."""
        state, n, fed = motion.state, 2 * self.coordinates, int(self.fed)
        rates = motion.rates
        late = -(row @ state.bars[:n]) / float(row @ rates[:n])
        rows = [state.bars[: n + fed] + np.outer(rates[: n + fed], late), state.dues[: self.waiting] - late]
        return np.vstack([*rows, state.shift[None] - late] if self.stroke else rows), late

    def scales(self, numbers: OilMachine) -> Array:
        """Sizes of them that count."""
        g = numbers.law.numbers
        return np.concatenate([
            np.full(self.coordinates, g[kn.SPEED] * g[kn.UNIT]), np.full(self.coordinates, g[kn.SPEED]),
            [1.0] * self.fed, np.full(self.waiting + self.stroke, g[kn.UNIT]),
        ])  # fmt: skip


@dataclass(frozen=True, eq=False)
class PortPassage:
    """The state at the passage of a port, not demanded yet, and of a cycle of so many blows the map of it."""

    numbers: OilMachine
    port: int
    state: kn.OilState
    blows: int = 1
    slope: Array | None = None

    @property
    def row(self) -> Array:
        """What the port reads, of displacements and velocities."""
        law, n = self.numbers.law, self.numbers.modes + 1
        first = n if law.ports[self.port, kn.OF_SPEED] else 0
        row = np.zeros(2 * n)
        row[first : first + n] = law.reads[self.port]
        return row

    def of(self, machine: Machine) -> PortPassage:
        """The same for a machine that differs little: with its passages, and on the side of its limits."""
        numbers = oil_machine(machine, self.numbers.modes)
        state = _copied(self.state)
        if state.now[kn.STROKE] == math.inf:
            state.blend[0] = numbers.law.joins[int(state.now[kn.STATE])]
        again = OilMotion.again(numbers, state)
        oil_kernels().begun(numbers.law, again.state, again.work)
        return PortPassage(numbers, self.port, again.state, self.blows)

    def returned(self, state: kn.OilState, directions: int = 0) -> OilMotion | None:
        """A motion from a state there until the port is met again after the blows; None where it is not."""
        motion = OilMotion.again(self.numbers, state, directions)
        if directions:
            OilUnknowns.of(self.numbers, state).seeded(motion.state)
        until = self.numbers.idle * self.blows
        ended = motion.run(until, section=self.port, since=float(self.blows), entering=[self.port], most=1 << 16)
        return motion if ended == kn.AT_SECTION and motion.blows == self.blows else None

    @property
    def is_shorter(self) -> bool:
        """Whether its cycle is one of fewer blows, several times."""
        unknowns = OilUnknowns.of(self.numbers, self.state)
        scales, here = unknowns.scales(self.numbers), unknowns.values(self.state)
        for blows in (part for part in range(1, self.blows) if self.blows % part == 0):
            motion = replace(self, blows=blows).returned(self.state)
            if motion is None or OilUnknowns.of(self.numbers, motion.state) != unknowns:
                continue
            if float(np.max(np.abs(unknowns.values(motion.state) - here) / scales)) < _SHORTER:
                return True
        return False

    def solved(self) -> PortPassage | None:
        """The passage that repeats, by Newton's method; None where it does not converge."""
        state = OilMotion.again(self.numbers, self.state).state
        unknowns = OilUnknowns.of(self.numbers, state)
        scales = unknowns.scales(self.numbers)
        slope, best, step = None, math.inf, np.zeros(unknowns.size)
        for _ in range(_NEWTON):  # with the derivatives of an earlier step, corrected, for as long as these lead on
            fresh = slope is None
            motion = self.returned(state, unknowns.size if fresh else 0)
            if motion is None or OilUnknowns.of(self.numbers, motion.state) != unknowns:
                return None
            x = unknowns.values(state)
            off = unknowns.values(motion.state) - x
            if slope is None:
                slope = unknowns.map(motion, self.row)[0]
            else:  # C. G. Broyden, Math. Comp. 19 (1965) 577, method 1
                slope = slope + np.outer(off, step / scales**2) / float(np.sum((step / scales) ** 2))
            try:
                step[:] = np.linalg.solve(np.eye(unknowns.size) - slope, off)
            except np.linalg.LinAlgError:
                return None
            size = float(np.max(np.abs(step) / scales))
            if not size < 1e3:
                return None
            if not (fresh or size <= _LEADS * best):
                slope = None
                continue
            state = _copied(state)
            unknowns.put(state, x + step, x)
            oil_kernels().begun(self.numbers.law, state, motion.work)
            if fresh and (size <= _CLOSE or (size <= _NEAR and size >= _LEADS * best)):  # as rounding lets it
                return replace(self, state=state, slope=slope)
            best = size
            if size <= _NEAR:
                slope = None
        return None


def _copied(state: kn.OilState) -> kn.OilState:
    return kn.OilState(*(np.array(one) for one in state))


def passage_of(motion: OilMotion) -> PortPassage | None:
    """A passage in which a motion now comes to a port: one at which nothing waits, where there is one."""
    numbers, found = motion.numbers, []
    for port in range(len(numbers.machine.valve.ports)):
        if numbers.law.ports[port, kn.ON_IMPACT]:
            continue
        copy = OilMotion.again(numbers, _copied(motion.state))
        if copy.run(numbers.idle, 64.0, section=port, most=1 << 16) == kn.AT_SECTION:
            state = _copied(copy.state)
            waits = int(state.now[kn.COUNT]) + 2 * bool(state.now[kn.STROKE] < math.inf)
            found.append((waits, port, PortPassage(numbers, port, state)))
    return min(found, key=lambda one: one[:2])[2] if found else None


def cycle_from(motion: OilMotion, blows: int) -> ValveCycle | None:
    """The cycle of so many blows to which Newton's method leads from where a motion is now."""
    passage = passage_of(motion)
    solved = None if passage is None else replace(passage, blows=blows).solved()
    return None if solved is None or solved.is_shorter else cycle_at(solved)


class OilGrowths(NamedTuple):
    """Logarithms of the growth of small differences, (passes, exponents), with the blows and the time of each pass."""

    growth: Array
    blows: npt.NDArray[np.int64]
    times: Array
    whole: bool


def growths_from(motion: OilMotion, blows: int, every: bool) -> OilGrowths:
    """From one passage of a port to the next, for at least so many blows of a motion that is on its way."""
    passage, found, counts, times = passage_of(motion), list[Array](), list[int](), list[float]()
    if passage is None:
        return OilGrowths(np.zeros((0, 1)), np.zeros(0, np.int64), np.zeros(0), False)
    numbers, state, row = passage.numbers, passage.state, passage.row
    now = OilUnknowns.of(numbers, state)
    scales, level = now.scales(numbers), np.zeros((1, now.size))
    level[0, : row.size] = row * scales[: row.size]
    within = np.linalg.svd(level)[2][1:].T  # what stays on the section
    ways = within if every else within.mean(axis=1, keepdims=True)
    most = ways.shape[1]
    while sum(counts) < blows:
        check_interrupted()
        motion = OilMotion.again(numbers, state, now.size)
        now.seeded(motion.state)
        ended = motion.run(numbers.idle, section=passage.port, since=1.0, entering=[passage.port], most=1 << 16)
        if ended != kn.AT_SECTION:
            break
        state, now = motion.state, OilUnknowns.of(numbers, motion.state)
        before, scales = scales, now.scales(numbers)
        ways, upper = np.linalg.qr(now.map(motion, row)[0] * before / scales[:, None] @ ways)
        with np.errstate(divide="ignore"):
            one = np.log(np.abs(np.diag(upper)))
        found.append(np.append(one, np.full(most - one.size, -np.inf)))
        counts.append(motion.blows)
        times.append(motion.time)
    growth = np.array(found).reshape(-1, most)
    return OilGrowths(growth, np.array(counts, dtype=np.int64), np.array(times), sum(counts) >= blows)


# ---- The cycle as other machines have it


def cycle_at(passage: PortPassage) -> ValveCycle | None:
    """The cycle of a passage that repeats, from the strongest blow on."""
    numbers = passage.numbers
    motion = OilMotion.again(numbers, passage.state)
    state, orders = numbers.names[int(passage.state.now[kn.STATE])], motion.orders
    motion.run(numbers.idle * passage.blows, float(passage.blows), entering=[passage.port])
    struck = [e for e in motion.events if e.kind == "impact"]
    if len(struck) < passage.blows:
        return None
    ends = numbers.own.end
    strongest = max(range(len(struck)), key=lambda i: float(ends @ struck[i].state[:, 1]))
    start, bar = _rebound_at(numbers, motion.events, strongest, state, orders)
    if strongest + 1 < len(struck):
        motion = OilMotion.again(numbers, passage.state)
        motion.run(blows=float(strongest + 1), entering=[passage.port])
    return _recorded(start, bar, passage, motion.state)


def _rebound_at(
    numbers: OilMachine, events: Sequence[OilEvent], blow: int, state: str, orders: Orders
) -> tuple[Rebound, Array]:
    """The valve just before a blow demands anything, with times from it on, and the bar just after."""
    valve, seen = numbers.machine.valve, -1
    for event in events:
        if event.kind == "impact":
            seen += 1
            if seen == blow:
                bar = event.state * numbers.turn
                if not numbers.modes:
                    bar[0, 0] = 0.0
                pending = tuple((due - event.time, to) for due, to in orders.pending)
                speed = -float(numbers.own.centre @ bar[:, 1])
                pressure = event.pressure if numbers.fed else None
                return Rebound(speed, state, Orders(orders.last, pending), pressure), bar
        elif event.kind == "port":
            orders = orders.after(event.time, port_at(valve, event.detail, event.pressure))
        elif event.kind == "valve":
            state = numbers.names[event.detail]
            orders = Orders(orders.last, orders.pending[1:])
    raise AssertionError("no such blow")


def _recorded(start: Rebound, bar: Array, passage: PortPassage, state: kn.OilState) -> ValveCycle | None:
    """The cycle from a rebound on, with its flights and its balance."""
    numbers, blows = passage.numbers, passage.blows
    motion = OilMotion.again(numbers, state, recorded=True)
    motion.state.now[kn.WALL] = 1.0 if float(numbers.own.end @ motion.state.bar[1]) < 0.0 else 2.0
    motion.run(numbers.idle * blows, float(blows))
    events = [*_demands(numbers, start, bar), *motion.events]
    last = max((i for i, e in enumerate(events) if e.kind == "impact"), default=-1)
    if motion.blows < blows:
        return None
    events = events[: last + 1]
    marks = [e for e in events if e.kind in ("impact", "port", "valve", "rest", "leaves")]
    flights, begun, now = [], 0.0, start.state
    orders, step, before, pressure = start.orders, 0, bar, 1.0 if start.pressure is None else start.pressure
    for event in marks:
        steps = tuple(motion.steps[step : event.step])
        if event.time > begun or event.kind == "impact":
            flights.append(OilFlight(
                modes=numbers.own, begin=before, force=0.0, duration=event.time - begun, state=now, last=orders.last,
                time=begun, pressure=pressure, numbers=numbers, steps=steps,
            ))  # fmt: skip
        begun, step, before, pressure = event.time, event.step, event.state, event.pressure
        if event.kind == "port":
            orders = orders.after(event.time, port_at(numbers.machine.valve, event.detail, event.pressure))
        elif event.kind == "valve":
            now, orders = numbers.names[event.detail], Orders(orders.last, orders.pending[1:])
        elif event.kind == "impact":
            before = event.state * numbers.turn
        elif event.kind == "rest":
            before = 0.0 * before
    happened = [
        (e.time, e.kind, numbers.names[e.detail] if e.kind == "valve" else e.detail, e.state, e.pressure)
        for e in marks
        if e.kind in ("impact", "port", "valve")
    ]
    assert passage.slope is not None
    slope = passage.slope
    if not numbers.modes:  # at the passage of a port the place is no unknown
        kept = [i for i in range(len(slope)) if i != (1 if passage.row[1] else 0)]
        slope = slope[np.ix_(kept, kept)]
    else:  # one coordinate after the other
        n = numbers.modes + 1
        order = [*np.arange(2 * n).reshape(2, n).T.reshape(-1), *range(2 * n, len(slope))]
        slope = slope[np.ix_(order, order)]
    blow, lying = 0, [blows - 1] if state.now[kn.RESTING] > 0.0 else []
    for event in marks:
        blow += event.kind == "impact"
        lying += [blow - 1] if event.kind == "rest" and blow else []
    told = cycle_told(
        numbers.machine,
        numbers.modes,
        start.state,
        start.orders,
        tuple(flights),
        happened,
        slope,
        tuple(sorted(set(lying))),
    )
    return replace(told, oil=motion.balance, passage=passage)


def _demands(numbers: OilMachine, start: Rebound, bar: Array) -> Iterator[OilEvent]:
    """What the blow at time 0 demands, and carries out at once."""
    valve, orders = numbers.machine.valve, start.orders
    pressure = 1.0 if start.pressure is None else start.pressure
    for port, own in enumerate(valve.ports):
        if own.on == "impact" and own.to != orders.last:
            yield OilEvent(0.0, "port", port, bar, pressure, 0)
            orders = orders.after(0.0, port_at(valve, port, pressure))
    while orders.pending and orders.pending[0][0] <= 0.0:
        yield OilEvent(0.0, "valve", numbers.names.index(orders.pending[0][1]), bar, pressure, 0)
        orders = Orders(orders.last, orders.pending[1:])


# ---- Where a machine settles


def near_oil(machine: Machine, cycle: ValveCycle) -> ValveCycle | None:
    """The cycle of a machine that differs little from that of a cycle."""
    passage: PortPassage | None = cycle.passage
    solved = None if passage is None else passage.of(machine).solved()
    return None if solved is None else cycle_at(solved)


def elastic_cycle(rigid: ValveCycle, modes: int) -> ValveCycle | None:
    """The cycle with elastic modes to which Newton's method leads from that of the rigid piston."""
    passage: PortPassage = rigid.passage
    numbers, state = oil_machine(rigid.machine, modes), passage.state
    again = OilMotion.again(numbers, state._replace(bar=np.outer(state.bar, numbers.own.centre)))
    oil_kernels().begun(numbers.law, again.state, again.work)
    solved = replace(passage, numbers=numbers, state=again.state).solved()
    return None if solved is None or solved.is_shorter else cycle_at(solved)


def starts_oil(machine: Machine) -> bool:
    """Whether a machine keeps going from rest on the wall."""
    return not goes_on(from_rest(oil_machine(machine, 0)), _SETTLING)


def settled_oil(machine: Machine, modes: int = 0, near: ValveCycle | None = None) -> OilSettled:
    """The cycle in which a machine settles whose oil flows: near another, from rest, or else pushed off the wall."""
    numbers = oil_machine(machine, modes)
    if near is not None and near.modes == modes and (beside := near_oil(machine, near)) is not None:
        return OilSettled(beside)
    if modes:
        rigid = settled_oil(machine, 0)
        if rigid.cycle is None:
            return rigid
        if (cycle := elastic_cycle(rigid.cycle, modes)) is not None:
            return OilSettled(cycle, starts=rigid.starts)
        begun = from_rebound(numbers, rigid.cycle.rebound)
        ending = goes_on(begun, _SETTLING)
        return OilSettled(None, ending, begun, rigid.starts) if ending else _cycle_of(begun, rigid.starts)
    first = from_rest(numbers)
    ending = goes_on(first, _SETTLING)
    if not ending:
        return _cycle_of(first, True)
    found = OilSettled(None, ending, first)
    for start in _pushes(numbers):
        motion = from_rebound(numbers, start)
        if not goes_on(motion, _SETTLING):
            other = _cycle_of(motion, False)
            if other.cycle is not None:
                return other
    return found


def _pushes(numbers: OilMachine) -> Iterator[Rebound]:
    """Rebounds of blows as strong as the power stroke of the farthest port gives, and weaker."""
    machine, fed = numbers.machine, numbers.fed
    valve = machine.valve
    way = max((port.behind for port in valve.ports if port.behind is not None), default=0.0)
    push = max(valve.force(name) for name, _ in valve.pairs)
    speed = math.sqrt(max(2.0 * push * way, 0.0))
    restitution = machine.contact.restitution
    back = min(valve.pairs, key=lambda pair: pair[1])[0]
    for pressure in (1.0, 0.6, 1.6) if fed else (None,):
        for part in (1.0, 0.5):
            yield Rebound(part * max(restitution, 0.05) * speed, back, Orders(back), pressure)


def _cycle_of(motion: OilMotion, starts: bool) -> OilSettled:
    """The cycle in which a motion that goes on settles."""
    for more in (_SETTLING, _LONGER, _MOST):
        for blows in _alike(motion):
            cycle = cycle_from(motion, blows)
            if cycle is not None:
                return OilSettled(cycle, "", motion, starts)
        ending = goes_on(motion, more)
        if ending:
            return OilSettled(None, ending, motion, starts)
    return OilSettled(None, "irregular", motion, starts)


def _alike(motion: OilMotion) -> list[int]:
    """Numbers of blows that a cycle may have: one, and after how many the last speeds are alike."""
    end = motion.numbers.own.end
    speeds = np.array([float(end @ e.state[:, 1]) for e in motion.events if e.kind == "impact"])[-4 * _MOST_BLOWS :]
    found = [1]
    for blows in range(2, _MOST_BLOWS + 1):
        if speeds.size > 2 * blows and np.all(np.abs(speeds[blows:] - speeds[:-blows]) <= _ALIKE * speeds.max()):
            found.append(blows)
            break
    return found


_PRESSURE_STEP = 1e-4  # of the pressure


def slow_oil(cycle: ValveCycle) -> float | None:
    """The multiplier of the pressure of an accumulator so great that the speed follows at once (docs/oil.md, 4).

    1 − (T/C) (dq/dP + G + g), q the demand of the machine held at a pressure; None where it does not run so.
    """
    supply, mean, demands = cycle.valve.supply, cycle.mean_pressure, []
    assert supply is not None
    for pressure in (mean * (1.0 - _PRESSURE_STEP), mean * (1.0 + _PRESSURE_STEP)):
        held = settled_oil(cycle.machine.with_valve(cycle.valve.at_pressure(pressure))).cycle
        if held is None or held.oil is None or held.blows > 1:
            return None
        demands.append(held.oil.drawn / held.period / pressure)
    slope = (demands[1] - demands[0]) / (2.0 * _PRESSURE_STEP * mean)
    leakage = 0.0 if cycle.valve.oil is None else cycle.valve.oil.leakage
    return 1.0 - cycle.period / supply.capacity(mean) * (slope + leakage + supply.slip)
