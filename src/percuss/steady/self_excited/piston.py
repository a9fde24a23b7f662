"""A rigid piston under its valve: its flights from blow to blow, and the cycle in which it settles.

`piston_kernels` do the work, here for one piston.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from percuss.halting import check_interrupted
from percuss.model import Machine
from percuss.model.load.valve import Orders
from percuss.model.machine import machine_modes
from percuss.steady.self_excited import piston_kernels as kn
from percuss.steady.self_excited.piston_flight import PistonFlight
from percuss.steady.self_excited.valve_cycle import MachineBlow, Rebound, Switch, Uncovering, ValveCycle, ValveFlight

_LEAST = 1e-100  # a stiffness or a drag below it is none: its times would overflow
_REBOUND = 1e-16  # a smaller part of the speed is no rebound: beside a wall it would fly no distance that numbers hold
_ROOM = 8  # for pending orders, at first
_MOST_ROOM = 400  # a leg has no more events


@dataclass(frozen=True)
class BlowToBlow:
    """From just after one blow to the next, or to where nothing follows, the `ending` one of `piston_kernels`."""

    ending: int
    duration: float
    blow_speed: float
    farthest: float
    rebound: Rebound | None
    flights: tuple[ValveFlight, ...]
    switches: tuple[Switch, ...]
    uncoverings: tuple[Uncovering, ...]


@dataclass(frozen=True)
class Piston:
    """A machine with a rigid piston, as numbers."""

    machine: Machine

    @cached_property
    def names(self) -> list[str]:
        """Of the valve's states, which are numbers there."""
        return [name for name, _ in self.machine.valve.pairs]

    @cached_property
    def numbers(self) -> tuple[list[float], list[list[float]], list[float]]:
        """Forces of the states, ports and law as `piston_kernels` have them; of a supply, at the pressure 1."""
        valve, contact, number = self.machine.valve, self.machine.contact, self.names.index
        ports = [(-p.level, -p.sign, float(p.speed is not None), float(number(p.to)), p.delay) for p in valve.ports]
        factor = contact.velocity_factor if abs(contact.velocity_factor) >= _REBOUND else 0.0
        stiffness, drag = (one if one >= _LEAST else 0.0 for one in (valve.chamber.stiffness, self.machine.drag))
        forces = [valve.force(name) for name in self.names]
        return forces, [list(row) for row in zip(*ports, strict=True)], [stiffness, drag, factor]

    def row(self, rebound: Rebound, behind: float = 0.0, room: int = _ROOM) -> list[float]:
        """A rebound as `piston_kernels` have it, with room for so many more pending orders."""
        orders, number = rebound.orders, self.names.index
        row = [rebound.speed, float(number(rebound.state)), float(number(orders.last)), float(len(orders.pending))]
        row += [behind, 0.0]
        row += [value for due, to in orders.pending for value in (due, float(number(to)))]
        return row + [0.0] * (2 * room)

    def rebound(self, row: list[float]) -> Rebound:
        """… and back."""
        orders = row[kn.DUE : kn.DUE + 2 * int(row[kn.COUNT])]
        pending = tuple((due, self.names[int(to)]) for due, to in zip(orders[::2], orders[1::2], strict=True))
        return Rebound(row[kn.V], self.names[int(row[kn.STATE])], Orders(self.names[int(row[kn.LAST])], pending))

    @property
    def start(self) -> Rebound:
        """At rest, with the valve in its starting state."""
        valve = self.machine.valve
        return Rebound(0.0, valve.orders.last, valve.orders)

    @property
    def fast(self) -> Rebound:
        """At the speed that the valve could give at most, in the state that pulls most."""
        row = self.row(self.start)
        kn.fast(*self.numbers, 1.0, row)
        return self.rebound(row)

    def flight(self, state: str, x: float, v: float) -> PistonFlight:
        """That begins in a state."""
        row = self.row(Rebound(v, state, self.machine.valve.orders), x)
        return kn.flight_of(*self.numbers[::2], row)

    def tables(self, rows: int, width: int) -> kn.PistonTables:
        """What `piston_kernels` work on, with so many rows of rebounds of a width."""

        def table(height: int, width: int) -> list[list[float]]:
            return [[0.0] * width for _ in range(height)]

        size = 2 + (width - kn.DUE) // 2
        matrices = [table(size, size + 1) for _ in range(kn.MATRICES)]
        tells, slopes = table(max(rows, 2), kn.TOLD), table(kn.BY_ORDER + size - 2, size)
        return kn.PistonTables(*self.numbers, table(rows, width), slopes, matrices, tells, [0.0] * size)

    def leg(self, rebound: Rebound, behind: float = 0.0, started: bool = False) -> BlowToBlow:
        """The leg that a rebound begins, at which the blow demands first, or a start, at which ports do."""
        check_interrupted()
        room, ending = _ROOM, kn.TOO_MANY
        while ending == kn.TOO_MANY:
            row, log = self.row(rebound, behind, room), list[tuple[Any, ...]]()
            work = self.tables(1, len(row))
            now, told = work.rows[kn.NOW], work.tells[kn.SINGLE]
            ending = kn.leg(work, row, started, now, told, log=log)
            room *= 2
        flights = tuple(self._flight(*one[1:]) for one in log if one[0] == kn.SEGMENT)
        switches = tuple(Switch(one[1], self.names[int(one[2])], *one[3:]) for one in log if one[0] == kn.SWITCH)
        passed = tuple(Uncovering(one[2], one[1], one[3]) for one in log if one[0] == kn.UNCOVERING)
        following = self.rebound(now) if ending == kn.BLOW else None
        duration = told[kn.DURATION] if following else now[kn.TIME]
        return BlowToBlow(ending, duration, told[kn.SPEED], told[kn.FARTHEST], following, flights, switches, passed)

    def _flight(self, time: float, duration: float, flight: PistonFlight, state: float, last: float) -> ValveFlight:
        machine = self.machine
        modes = machine_modes(machine.body, machine.at, flight.stiffness, 0)
        begin = np.array([[-flight.x, -flight.v]])
        return ValveFlight(
            modes=modes, begin=begin, force=-flight.push, duration=duration, state=self.names[int(state)],
            last=self.names[int(last)], time=time,
        )  # fmt: skip

    def cycle(self, rebound: Rebound, blows: int) -> ValveCycle:
        """That through a rebound, with its longest flight first."""
        legs = [self.leg(rebound)]
        while len(legs) < blows and (following := legs[-1].rebound) is not None:
            legs.append(self.leg(following))
        longest = int(np.argmax([leg.duration for leg in legs]))
        now = (legs[longest - 1].rebound or rebound) if longest else rebound
        legs = legs[longest:] + legs[:longest]
        starts = [0.0, *np.cumsum([leg.duration for leg in legs]).tolist()]
        timed = list(zip(starts, legs, strict=False))
        room, closes, size = _ROOM, False, now.numbers.size
        while not closes and room <= _MOST_ROOM:
            row = self.row(now, room=room)
            work = self.tables(kn.FIRST, len(row))
            closes, room = kn.legs_of_cycle(row, blows, work), 2 * room

        def all_of(name: str) -> tuple[Any, ...]:
            return tuple(replace(one, time=start + one.time) for start, leg in timed for one in getattr(leg, name))

        speeds = [(end, leg.blow_speed) for end, leg in zip(starts[1:], legs, strict=True)]
        return ValveCycle(
            machine=self.machine,
            modes=0,
            state=now.state,
            orders=now.orders,
            flights=all_of("flights"),
            struck=tuple(MachineBlow(time, speed, 0.5 * speed**2, 0.0) for time, speed in speeds),
            switches=all_of("switches"),
            uncoverings=all_of("uncoverings"),
            slope=np.array([line[:size] for line in work.matrices[kn.ALL][:size]]),
            lying=tuple(
                sorted((i - 1) % len(legs) for i, leg in enumerate(legs) if any(one.lies for one in leg.flights))
            ),
        )


# ---- The cycle in which a machine ends: some blows from a fast start, then Newton's method

_LAST = 4  # rebounds


@dataclass(frozen=True)
class Lost:
    """What the last blows of a piston without a cycle tell, and its last leg; `started`: that is the first one."""

    why: int
    leg: BlowToBlow
    began: Rebound
    started: bool


@dataclass(frozen=True)
class _Search:
    """A piston, and room to look for its cycle along so many legs."""

    piston: Piston
    most: int = 0
    room: int = _ROOM

    @cached_property
    def work(self) -> kn.PistonTables:
        """What the functions work on."""
        return self.piston.tables(kn.FIRST + self.most, kn.DUE + 2 * self.room)

    def set_out(self, rebound: Rebound) -> list[float]:
        """The rebound, from which is followed."""
        pending = len(rebound.orders.pending)
        kn.copied(self.piston.row(rebound, room=self.room - pending), self.work.rows[kn.NOW])
        return list(self.work.rows[kn.NOW])

    def near(self, row: list[float], blows: int, shrinking: int) -> ValveCycle | None:
        """The cycle of so many blows to which Newton's method leads from a rebound near it, or None."""
        check_interrupted()
        return self.found(blows if kn.cycle_near(row, blows, shrinking, self.work) else 0)

    def found(self, blows: int) -> ValveCycle | None:
        """The cycle of so many blows that was found, with its longest flight first; none of 0."""
        return self.piston.cycle(self.piston.rebound(self.work.rows[kn.NEXT]), blows) if blows else None

    def lost(self, first: list[float], number: int, ending: int) -> Lost:
        """What the legs that were followed from a rebound tell."""
        began, work = first, self.work
        if number > 1:
            legs = work.rows[kn.FIRST : kn.FIRST + number - 1]
            began = list(legs[-1])
            kn.settle(work.forces, work.law, began, max(row[kn.V] for row in [first, *legs]))
        rebound = self.piston.rebound(began)
        return Lost(kn.why_none(number, ending, work.tells), self.piston.leg(rebound), rebound, number == 1)


def cycle_near(machine: Machine, rebound: Rebound, blows: int, *, close: bool = False) -> ValveCycle | None:
    """The cycle of so many blows to which Newton's method leads from a rebound near it (how near: `close`), or None."""
    search = _Search(Piston(machine), 0, _room(rebound))
    return search.near(search.set_out(rebound), blows, kn.CLOSELY if close else kn.SHRINKING)


def _room(rebound: Rebound) -> int:
    return _ROOM + 2 * len(rebound.orders.pending)


def settled(machine: Machine) -> tuple[ValveCycle | None, Lost | None, bool]:
    """The cycle of a fast start, or else of the fastest that tells; and whether a demand replaced an order in it."""
    check_interrupted()
    piston, room, why, part = Piston(machine), _ROOM, kn.UNKNOWN, 1.0
    while why == kn.UNKNOWN and room <= _MOST_ROOM:
        search = _Search(piston, kn.MOST_BLOWS, room)
        why, blows, part = kn.settled(search.work)
        room *= 2
    if blows:
        return search.found(blows), None, why == kn.OVERTAKEN
    row = search.work.rows[kn.NOW]
    kn.fast(*piston.numbers, part, row)
    first = list(row)
    return None, search.lost(first, *kn.followed(search.most, search.work)), False


def starts(machine: Machine, cycle: ValveCycle) -> bool:
    """Whether a rigid piston keeps going from rest on the wall; its own cycle tells when it is sure to."""
    piston, own = Piston(machine), settled(machine)[0] if cycle.modes else cycle
    search = _Search(piston, 0, 4 * _ROOM)
    work, attracts = search.work, False
    if own is not None and own.blows == 1:
        search.set_out(own.rebound)
        kn.copied(work.rows[kn.NOW], work.rows[kn.NEXT])
        work.tells[kn.WHOLE][kn.SPEED], work.tells[kn.WHOLE][kn.DURATION] = own.blow_speed, own.period
        for line, values in zip(work.matrices[kn.ALL], own.slope.tolist(), strict=False):
            line[: len(values)] = values
        attracts = kn.contracts(len(own.slope), work)
    return bool(kn.starts(float(piston.names.index(piston.start.state)), attracts, work))


def continued(machine: Machine, cycle: ValveCycle) -> ValveCycle | None:
    """The cycle with one blow of a machine that differs little from the one that has the given cycle."""
    rebound = cycle.rebound
    search = _Search(Piston(machine), kn.FEW, _room(rebound))
    found = search.near(search.set_out(rebound), 1, kn.CLOSELY)
    if found is not None:
        return found
    search.set_out(rebound)
    number, ending = kn.followed(kn.FEW, search.work)
    for i in reversed(range(number if ending == kn.BLOW else number - 1)):
        found = search.near(search.work.rows[kn.FIRST + i], 1, kn.CLOSELY)
        if found is not None and found.switches:
            return found
    return None
