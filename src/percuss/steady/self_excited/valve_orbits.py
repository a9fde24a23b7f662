"""The periodic motions of a machine without a clock: searched for by orders of events, and solved for by their times.

A start is a stretch of a motion from blow to blow: of the rigid piston, from a random rebound, or one that is given, as
of a simulation. Its order of events is kept, and Newton's method closes it by the times. Whatever it finds is looked at
before it is called an orbit: the order of events must be the valve's own, everything must be met in the way that
counts, and nothing else may happen in between, which is proved.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import replace
from functools import cached_property
from typing import Any, cast

import numpy as np

from percuss.errors import Interrupted, ParameterError
from percuss.halting import check_interrupted, halting
from percuss.mechanics.oil import OilMotion, oil_machine
from percuss.model import Machine
from percuss.model.checks import DEFAULT_MODES, Array, count, instance
from percuss.model.load.valve import Orders
from percuss.steady.oil.oil_cycle import cycle_from, from_rebound, goes_on
from percuss.steady.periodic.found_orbits import MOST_IMPACTS, MOST_PERIODS, Drop, FoundOrbits, Tally
from percuss.steady.self_excited.cycle_times import CycleTimes, under, valve_after
from percuss.steady.self_excited.event_sequence import EventSequence, sequence_in
from percuss.steady.self_excited.piston import BlowToBlow, Piston
from percuss.steady.self_excited.settling import rest_cycles_of, under_pressure
from percuss.steady.self_excited.valve_cycle import Rebound, ValveCycle

RANDOM = "random rebounds"  # what starts are called that nobody gave

RELEASED = "releases from rest"

_MOST_MODES = 4096
_MOST_TRIES = 10**7
_EVERY, _LONG = 8, 60  # of so many random motions of oil that flows one is followed for so many blows
_SETTLING = 6  # blows after a random rebound, at most, before the stretch that is tried
_SAME = 1e-7  # of the period, and of the speed
_REACH = 1.5  # random speeds, over what the valve could give at most
_PRESSURES = 1.0  # of the logarithm of a random pressure

_FAULTS = {
    "order": Drop.OUT_OF_ORDER,
    "direction": Drop.NO_BLOW,
    "wall": Drop.THROUGH_WALL,
    "port": Drop.ANOTHER_PORT,
    "pressure": Drop.NO_PRESSURE,
}


def valve_orbits(
    machine: Machine,
    blows: int,
    valve_cycles: int = 1,
    *,
    modes: int = DEFAULT_MODES,
    tries: int = 400,
    seed: int = 0,
    near: Mapping[str, Iterable[CycleTimes]] | None = None,
    halt: Callable[[], bool] | None = None,
) -> FoundOrbits:
    """The periodic motions of a machine with so many blows in so many cycles of its valve; see `orbits`."""
    instance("machine", machine, Machine)
    p, n = count("impacts", blows, most=MOST_IMPACTS), count("periods", valve_cycles, most=MOST_PERIODS)
    kept, wanted = count("modes", modes, least=0, most=_MOST_MODES), count("tries", tries, most=_MOST_TRIES)
    start = count("seed", seed, least=0, most=2**63 - 1)
    if machine.contact.is_lossless and machine.body.damping.is_zero:
        raise ParameterError("machine", str(machine), "a machine that loses energy", "give a restitution below 1")
    search, interrupted = (_OilSearch if machine.valve.flows else _ValveSearch)(machine, p, n, kept), False
    with halting(halt):
        try:
            for name, rhythms in (near or {}).items():
                search.tried(name, (instance("near", rhythm, CycleTimes) for rhythm in rhythms))
            search.tried(RANDOM, search.drawn(np.random.default_rng(start), wanted))
        except Interrupted:
            if halt is None or not halt():  # told from outside: nobody waits for a part
                raise
            interrupted = True
    return search.result(interrupted)


def valve_rest_cycles(machine: Machine, rest: str, valve_cycles: int = 1, *, modes: int = 32) -> FoundOrbits:
    """The cycles of a machine in which it rests on the wall, of the label chatter/n or rest/n: `rest` is the word."""
    # A bar at rest has forgotten what was before, so that there is one at most for each state in which the valve lets
    # go.
    kept, wanted = count("modes", modes, least=0, most=_MOST_MODES), count("periods", valve_cycles, most=MOST_PERIODS)
    every = rest_cycles_of(instance("machine", machine, Machine), kept, wanted)
    found = tuple(cycle for cycle in every if cycle.label == f"{rest}/{wanted}")
    tries = sum(machine.valve.force(state) <= 0.0 for state, _ in machine.valve.pairs)
    impacts = max((cycle.blows for cycle in found), default=0)
    tallies = {RELEASED: Tally(tries, len(found))}
    return FoundOrbits(
        cast("Any", machine), impacts, wanted, kept, cast("Any", found), (), tries, {}, None, False, tallies, rest=rest
    )


class _ValveSearch:
    """The roots found so far, with a verdict on each, and the tries, by where they started and what became of them."""

    def __init__(self, machine: Machine, blows: int, valve_cycles: int, modes: int) -> None:
        self.machine, self.blows, self.valve_cycles, self.modes = machine, blows, valve_cycles, modes
        self.roots: list[tuple[ValveCycle, Drop | None]] = []
        self.dropped: Counter[Drop] = Counter()
        self.met: Counter[int] = Counter()  # the orbits at which random tries ended
        self.sources: dict[str, Tally] = {}

    def tried(self, name: str, starts: Iterable[CycleTimes | None]) -> None:
        """Newton's method from stretches of motions, from each in turn; None is one that is none."""
        for rhythm in starts:
            check_interrupted()
            before = self._good
            number = None if rhythm is None else self._followed(rhythm)
            if number is None:
                self.dropped[Drop.LOST] += 1
            elif number >= 0 and self.roots[number][1] is None and name == RANDOM:
                self.met[number] += 1
            tries, orbits = self.sources.get(name, Tally(0, 0))
            self.sources[name] = Tally(tries + 1, orbits + self._good - before)

    @property
    def _good(self) -> int:
        return sum(1 for _, reason in self.roots if reason is None)

    def _followed(self, rhythm: CycleTimes) -> int | None:
        """The number of the root to which a stretch leads; None for none."""
        sequence = sequence_in(self.machine.valve, rhythm)
        if sequence is None or (sequence.blows, sequence.valve_cycles) != (self.blows, self.valve_cycles):
            return None
        found = sequence.solved(self.machine, self.modes, np.array([time for time, _ in rhythm.guarded]))
        if found is None:
            return None
        for number, (other, reason) in enumerate(self.roots):
            if _is_same(found, other):
                self.dropped[reason or Drop.KNOWN] += 1
                return number
        reason = self._verdict(sequence, found)
        self.roots.append((first_longest(found) if reason is None else replace(found, obstacle=reason), reason))
        if reason is not None:
            self.dropped[reason] += 1
        return len(self.roots) - 1

    def _verdict(self, sequence: EventSequence, cycle: ValveCycle) -> Drop | None:
        """Why a root is no orbit."""
        fault = sequence.fault(cycle)
        if fault is not None:
            return _FAULTS[fault.kind]
        if any(_is_same(cycle, cycle, shift) for shift in range(1, self.blows)):
            return Drop.REPEAT
        if sequence_in(self.machine.valve, cycle.rhythm) != sequence:
            return Drop.OUT_OF_ORDER
        return None if cycle.keeps_before_the_wall else Drop.THROUGH_WALL

    def drawn(self, random: np.random.Generator, wanted: int) -> Iterator[CycleTimes | None]:
        """Stretches of motions of the rigid piston, some blows after a random rebound."""
        machine, piston, pressure = self.machine, Piston(self.machine), 1.0
        for _ in range(wanted):
            if machine.valve.supply is not None:
                pressure = float(np.exp(random.uniform(-_PRESSURES, _PRESSURES)))
                piston = Piston(under_pressure(machine, pressure))
            state = piston.names[int(random.integers(len(piston.names)))]
            speed = _REACH * max(piston.fast.speed, 0.1 * _speed(machine)) * float(random.uniform())
            begin: Rebound | None = Rebound(speed, state, Orders(state))
            for _ in range(int(random.integers(_SETTLING + 1))):
                begin = None if begin is None else piston.leg(begin).rebound
            stretch = None if begin is None else _stretch(piston, begin, self.blows)
            yield None if stretch is None else under(stretch, pressure)

    def result(self, interrupted: bool) -> FoundOrbits:
        ended = sum(self.met.values())
        unseen = sum(1 for times in self.met.values() if times == 1) / ended if ended else None
        listed = sorted(self.roots, key=lambda root: root[0].period)
        good = tuple(cycle for cycle, reason in listed if reason is None)
        others = tuple(cycle for cycle, reason in listed if reason not in (None, Drop.REPEAT))
        dropped = {drop: self.dropped[drop] for drop in Drop if self.dropped[drop]}
        tries = sum(tally.tries for tally in self.sources.values())
        return FoundOrbits(
            cast("Any", self.machine), self.blows, self.valve_cycles, self.modes, cast("Any", good),
            cast("Any", others), tries, dropped, unseen, False, self.sources, ended, interrupted,
        )  # fmt: skip


class _OilSearch(_ValveSearch):
    """The same of a machine whose oil flows: from passages of motions, each of which is followed for a while.

    With elastic modes each cycle of the rigid piston is followed on with them.
    """

    def drawn(self, random: np.random.Generator, wanted: int) -> Iterator[Any]:
        machine, numbers = self.machine, oil_machine(self.machine, 0)
        names = [name for name, _ in machine.valve.pairs]
        for i in range(wanted):
            pressure = None
            if machine.valve.supply is not None:
                pressure = float(np.exp(random.uniform(-_PRESSURES, _PRESSURES)))
            state = names[int(random.integers(len(names)))]
            start = Rebound(_REACH * _speed(machine) * float(random.uniform()), state, Orders(state), pressure)
            motion = from_rebound(numbers, start)
            blows = int(random.integers(_SETTLING + 1)) if i % _EVERY else _LONG
            yield None if goes_on(motion, blows + self.blows) else motion

    def _followed(self, rhythm: Any) -> int | None:
        found = cycle_from(rhythm, self.blows) if isinstance(rhythm, OilMotion) else None
        if found is None or (found.blows, found.valve_cycles) != (self.blows, self.valve_cycles):
            return None
        if self.modes:
            found = self._elastic(found)
            if found is None:
                return None
        for number, (other, reason) in enumerate(self.roots):
            if _is_same(found, other):
                self.dropped[reason or Drop.KNOWN] += 1
                return number
        self.roots.append((found, None))
        return len(self.roots) - 1

    def _elastic(self, rigid: ValveCycle) -> ValveCycle | None:
        if (known := self._known.get(rigid.period)) is not None:
            return known
        motion = from_rebound(oil_machine(self.machine, self.modes), rigid.rebound)
        found = None if goes_on(motion, 2 * self.blows) else cycle_from(motion, self.blows)
        if found is not None:
            self._known[rigid.period] = found
        return found

    @cached_property
    def _known(self) -> dict[float, ValveCycle]:
        return {}


def _speed(machine: Machine) -> float:
    """What the greatest force makes of rest on the way from the farthest port."""
    way = max((port.behind for port in machine.valve.ports if port.behind is not None), default=1.0)
    return float(np.sqrt(2.0 * max(abs(machine.valve.force(name)) for name, _ in machine.valve.pairs) * way))


def _stretch(piston: Piston, begin: Rebound, blows: int) -> CycleTimes | None:
    """So many blows of the rigid piston after a rebound; None where they do not come, or it rests in between."""
    legs: list[BlowToBlow] = []
    now: Rebound | None = begin
    while now is not None and len(legs) < blows:
        legs.append(piston.leg(now))
        now = legs[-1].rebound
    if now is None or any(one.lies for leg in legs for one in leg.flights):
        return None
    ends = np.cumsum([leg.duration for leg in legs])
    if not np.all(np.diff(ends, prepend=0.0) > 0.0):
        return None
    starts = zip([0.0, *ends[:-1].tolist()], legs, strict=True)
    passages = tuple((start + one.time, one.port) for start, leg in starts for one in leg.uncoverings)
    return CycleTimes(tuple(ends.tolist()), passages, begin.state, begin.orders)


def _numbers(cycle: ValveCycle) -> Array:
    """Flights from blow to blow over the period, and speeds over the greatest one, shape (2, blows)."""
    return np.array([cycle.flight_times / cycle.period, cycle.blow_speeds / max(cycle.blow_speed, 1e-300)])


def _is_same(one: ValveCycle, other: ValveCycle, shift: int | None = None) -> bool:
    """Whether two cycles are the same but for which blow is the first, or for a shift by so many blows."""
    if abs(one.period - other.period) > _SAME * one.period:
        return False
    a, b = _numbers(one), _numbers(other)
    shifts = range(one.blows) if shift is None else [shift]
    return any(float(np.abs(np.roll(a, k, axis=1) - b).max()) <= _SAME for k in shifts)


def rotated(cycle: ValveCycle, blow: int) -> ValveCycle:
    """The same cycle from another of its blows on."""
    rhythm, time = cycle.rhythm, float(cycle.blow_times[blow])
    valve = valve_after(cycle.machine.valve, rhythm, blow)

    def moved(t: float) -> float:
        return t - time if t > time else t - time + cycle.period

    times = sorted(moved(t) for t in rhythm.blow_times)
    passages = tuple(sorted((moved(t), port) for t, port in rhythm.passages))
    fed = tuple(sorted((moved(t), pressure) for t, pressure in rhythm.pressures))
    again = replace(
        rhythm, blow_times=tuple(times), passages=passages, state=valve.state, orders=valve.orders, pressures=fed
    )
    sequence = sequence_in(cycle.machine.valve, again)
    found = None if sequence is None else sequence.solved(
        cycle.machine, cycle.modes, np.array([t for t, _ in again.guarded])
    )  # fmt: skip
    return cycle if found is None else found


def first_longest(cycle: ValveCycle) -> ValveCycle:
    """The same cycle, with its longest flight from blow to blow first."""
    longest = int(np.argmax(cycle.flight_times))
    return cycle if longest == 0 else rotated(cycle, longest - 1)
