"""What a machine does that finds no tool: its rigid piston flies on, into the cushion at the front end.

As everywhere beside the wall the flights are closed. In the cushion two more forces act that are affine in the place:
one on the way in, and a part of it on the way out.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from percuss.errors import ParameterError
from percuss.model import Cushion
from percuss.model.checks import instance
from percuss.model.machine import check_closed_form
from percuss.short_repr import ShortRepr
from percuss.steady.self_excited.cycle_times import Switching, valve_after
from percuss.steady.self_excited.piston import Piston
from percuss.steady.self_excited.piston_flight import (
    READS,
    PistonFlight,
    acceleration,
    at,
    first_crossing,
    last_place,
    turning_places,
    turning_time,
)
from percuss.steady.self_excited.self_switching import SelfExcited
from percuss.steady.self_excited.settling import under_pressure

_MOST_PASSES = 64
_MOST_EVENTS = 40 * _MOST_PASSES
_TOGETHER = 1e-12  # of a flight: an event this little after an order is due comes before it
_SAME = 1e-9  # of the speed and of the time between passes

BlankEnding = Literal[
    "stops in the cushion", "stops", "strikes the front end", "leaves", "cycles without a blow", "goes on"
]
"""What becomes of a machine without its tool.

It "stops" where no port is reached any more, "leaves" where nothing holds the piston back, and "goes on" where its
passes do not repeat.
"""


@dataclass(frozen=True)
class BlankBlow(ShortRepr):
    """What a machine does that finds no tool; dimensionless, energies and forces per unit of mass.

    Attributes
    ----------
    speed
        At the place of the blow, which the piston passes.
    cushion
        The one it goes into, of the valve or assumed; None without one.
    reach
        How far beyond the wall it goes at first; infinite when nothing turns it.
    depth, peak_force, taken
        How deep it goes into the cushion at first, the greatest force of the cushion there, and the energy that the
        cushion keeps of that.
    worst_pass, worst_depth, worst_force
        The pass in which it goes deepest, from 1 on, how deep, and the greatest force of the cushion there.
    front_speed
        At which it strikes the front end of the housing; 0 when it does not.
    ending
        What becomes of the machine.
    passes
        How often it passes the place of the blow until it stops or strikes the front end; of one that cycles, until
        what it does repeats.
    period, again
        Of a machine that cycles without a blow: the time between passes, and their speed; else None.
    pressure
        Under which it moves, as a multiple of that for which the forces of the states hold: with a supply the mean
        pressure of the cycle, else 1.
    """

    speed: float
    cushion: Cushion | None
    reach: float
    depth: float
    peak_force: float
    taken: float
    worst_pass: int
    worst_depth: float
    worst_force: float
    front_speed: float
    ending: BlankEnding
    passes: int
    period: float | None
    again: float | None
    pressure: float = 1.0

    @property
    def energy(self) -> float:
        """Kinetic energy at the place of the blow."""
        return 0.5 * self.speed**2


def blank_blow(motion: SelfExcited, *, cushion: Cushion | None = None) -> BlankBlow:
    """What a machine does from the moment at which the tool is not there for its strongest blow.

    Parameters
    ----------
    motion
        The cycle of a rigid piston, from `self_excited_motion` with modes=0.

    Raises
    ------
    ParameterError
        When there is no such cycle.

    Notes
    -----
    Blows demand nothing, as there are none; the ports do. A supply is taken to hold its mean pressure. A piston that is
    pushed less than the cushion holds lies in the cushion, until the valve changes; the oil does not leak.

    Examples
    --------
    >>> from percuss.model import Cushion, Kept, Machine, Port, UniformBar, Valve
    >>> from percuss.steady import self_excited_motion
    >>> ports = [Port("power", behind=1.0, side="back"), Port("return", on="impact")]
    >>> valve = Valve({"return": -0.4, "power": 1.8}, ports, cushion=Cushion(force=10.0, stiffness=100.0))
    >>> found = blank_blow(self_excited_motion(Machine(UniformBar(20.0), valve, Kept(0.2)), modes=0))
    >>> print(f"{found.ending}, {found.depth:.4f} deep, with {found.taken:.4f} taken")
    stops in the cushion, 0.1473 deep, with 2.5568 taken
    """
    cycle = instance("motion", motion, SelfExcited).cycle
    if cycle is None or cycle.modes:
        raise ParameterError("motion", str(motion), "a machine with a cycle, with modes=0")
    check_closed_form(motion.machine)
    machine, strongest = motion.machine, int(np.argmax(cycle.blow_speeds))
    given = machine.valve.cushion if cushion is None else instance("cushion", cushion, Cushion)
    pressure = cycle.mean_pressure
    machine = machine if machine.valve.supply is None else under_pressure(machine, pressure)
    valve = valve_after(machine.valve, cycle.rhythm, strongest)
    return replace(_Blank(Piston(machine), given, valve, cycle.blow_speed).followed(), pressure=pressure)


class _Blank:
    """The piston on its way without a tool, x behind the place of the blow; the cushion is a state on either way."""

    def __init__(self, piston: Piston, cushion: Cushion | None, valve: Switching, speed: float) -> None:
        self.piston, self.cushion, self.valve = piston, cushion, valve
        self.x, self.v, self.time = 0.0, -speed, 0.0
        self.where: Literal["free", "in", "out"] = "free" if cushion is None or cushion.beyond > 0.0 else "in"
        length = math.inf if cushion is None or cushion.length is None else cushion.length
        self.front = -math.inf if cushion is None else -cushion.beyond
        ports = list(zip(*piston.numbers[1][: READS + 1], strict=True))
        fast = [one for one in ports if one[READS]]
        guards = {
            "free": ports if cushion is None else [*ports, (self.front, -1.0, 0.0)],
            "in": [*fast, (self.front - length, -1.0, 0.0)],
            "out": [*fast, (self.front, 1.0, 0.0)],
        }
        self.guards = {where: list(zip(*rows, strict=True)) for where, rows in guards.items()}
        self.passes = [(0.0, speed)]
        self.reaches = [0.0]  # beyond the wall, in each pass
        self.front_speed = 0.0
        self.ending: BlankEnding | None = None
        self.repeats = False

    def followed(self) -> BlankBlow:
        """Goes on until it is known what becomes of it."""
        for _ in range(_MOST_EVENTS):
            while self.valve.due <= self.time:
                self.valve.carry_out()
            self._go_on()
            if self.ending is None and self._repeated():
                self.ending, self.repeats = "cycles without a blow", True
            if self.ending is not None or len(self.passes) > _MOST_PASSES:
                break
        return self._told()

    def _told(self) -> BlankBlow:
        reach, most = self.reaches[0], max(self.reaches)
        worst = next(i for i, one in enumerate(self.reaches) if one >= most * (1.0 - _SAME))
        depth, peak = self._into(reach)
        taken = 0.0
        if depth == math.inf:
            taken = math.inf if peak > 0.0 else 0.0
        elif self.cushion is not None:
            turned = self.front_speed == 0.0 or len(self.passes) > 1
            taken = (1.0 - self.cushion.returned * turned) * self.cushion.energy(depth)
        again, period = None, None
        if self.repeats:
            (before, _), (last, again) = self.passes[-2:]
            period = last - before
        first = self.passes[0][1], self.cushion, reach, depth, peak, taken
        figures = *first, worst + 1, *self._into(self.reaches[worst]), self.front_speed
        return BlankBlow(*figures, self.ending or "goes on", len(self.passes), period, again)

    def _into(self, reach: float) -> tuple[float, float]:
        """Depth in the cushion, and its greatest force, of a piston that goes so far beyond the wall."""
        if self.cushion is None or reach <= self.cushion.beyond:
            return 0.0, 0.0
        if reach == math.inf:  # it pushes less than the valve, at any depth
            return math.inf, self.cushion.force
        depth = reach - self.cushion.beyond
        return depth, self.cushion.force + self.cushion.stiffness * depth

    def _flight(self, where: Literal["free", "in", "out"]) -> PistonFlight:
        flight = self.piston.flight(self.valve.state, self.x, self.v)
        if self.cushion is None or where == "free":
            return flight
        part, stiffness = 1.0 if where == "in" else self.cushion.returned, self.cushion.stiffness
        push = flight.push + part * (self.cushion.force + stiffness * self.front)
        return flight._replace(push=push, stiffness=flight.stiffness + part * stiffness)

    def _go_on(self) -> None:
        """To the next event."""
        if self.where == "out" and self.v <= 0.0 and acceleration(self._flight("out")) <= 0.0:
            self.where = "in"  # the valve has changed
        flight, until = self._flight(self.where), self.valve.due - self.time
        if self.where == "in" and self.v >= 0.0 and acceleration(flight) >= 0.0:
            if self.v > 0.0 or acceleration(self._flight("out")) > 0.0:
                self.where = "out"
            elif until == math.inf:
                self.ending = "stops in the cushion"
            else:
                self.time = self.valve.due
            return
        turning = math.inf if self.where == "free" else turning_time(flight)
        stop = min(turning, until)
        time, place, way, reads = first_crossing(flight, self.guards[self.where], stop * (1.0 + _TOGETHER))
        duration = time if way else stop
        self._reached(*(-x for x in turning_places(flight, duration)))
        if duration == math.inf:
            self.ending = "stops" if self.where == "free" else "stops in the cushion"
            self._reached(-last_place(flight))
            if last_place(flight) == -math.inf:
                self.ending = "leaves"
            return
        (self.x, self.v), self.time = at(flight, duration), self.time + duration
        if way and reads:
            self.v = place
        elif way:
            self.x = place
        self._reached(-self.x)
        if way:
            self._passed(place, way, reads)
        elif turning <= until:
            self.v, self.where = 0.0, "in"
        else:
            self.time = self.valve.due

    def _reached(self, *beyond: float) -> None:
        self.reaches[-1] = max([self.reaches[-1], *beyond])

    def _passed(self, place: float, way: int, reads: int) -> None:
        for number, passed in enumerate(zip(*self.piston.numbers[1][: READS + 1], strict=True)):
            if passed == (place, way, reads):
                self.valve.demand(self.time, number)
        if reads:
            return
        if self.where == "in":
            self.ending, self.front_speed = "strikes the front end", -self.v
        elif self.where == "out":
            self.where = "free"
        else:
            if way < 0 and place == 0.0:
                self.passes.append((self.time, -self.v))
                self.reaches.append(0.0)
            self.where = "in" if way < 0 and place == self.front else "free"

    def _repeated(self) -> bool:
        """Whether the last passes were like the ones before."""
        if len(self.passes) < 4 or self.x != 0.0:
            return False
        (a, _), (b, u), (c, v), (d, w) = self.passes[-4:]
        steady = max(abs(w - v), abs(v - u)) <= _SAME * w
        return steady and max(abs((d - c) - (c - b)), abs((c - b) - (b - a))) <= _SAME * (d - c)
