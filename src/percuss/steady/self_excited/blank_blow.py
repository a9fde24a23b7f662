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
from percuss.shown import Shown
from percuss.steady.self_excited.margins import mean_pressure
from percuss.steady.self_excited.piston_flight import (
    Flight,
    acceleration,
    at,
    first_crossing,
    last_place,
    turning_places,
    turning_time,
)
from percuss.steady.self_excited.piston_legs import Piston, Rebound
from percuss.steady.self_excited.rigid_cycle import RigidCycle, under_pressure
from percuss.steady.self_excited.self_switching import SelfExcited, piston_of

_MOST_PASSES = 64
_MOST_EVENTS = 40 * _MOST_PASSES
_TOGETHER = 1e-12  # of a flight: an event this little after an order is due comes before it
_SAME = 1e-9  # of the speed and of the time between passes
_LEAST = 1e-100  # a stiffness or a drag below it is none: its times would overflow

BlankEnding = Literal[
    "stops in the cushion", "stops", "strikes the front end", "leaves", "cycles without a blow", "goes on"
]
"""What becomes of a machine without its tool.

It "stops" where no port is reached any more, "leaves" where nothing holds the piston back, and "goes on" where its
passes do not repeat.
"""


@dataclass(frozen=True)
class BlankBlow(Shown):
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
    cushion
        In place of that of the valve.

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
    if not isinstance(cycle, RigidCycle):
        raise ParameterError("motion", str(motion), "a machine with a cycle, with modes=0")
    leg = cycle.legs[int(np.argmax(cycle.blow_speeds))]
    assert leg.rebound is not None
    given = motion.machine.valve.cushion if cushion is None else instance("cushion", cushion, Cushion)
    piston, fed = piston_of(motion.machine), motion.machine.valve.supply is not None
    pressure = mean_pressure(cycle) if fed else 1.0
    piston = under_pressure(piston, pressure) if fed else piston
    return replace(_Blank(piston, given, leg.rebound, leg.blow_speed).followed(), pressure=pressure)


class _Blank:
    """The piston on its way without a tool; x is its distance behind the place of the blow."""

    def __init__(self, piston: Piston, cushion: Cushion | None, rebound: Rebound, speed: float) -> None:
        self.piston, self.cushion = piston, cushion
        self.x, self.v, self.time = 0.0, -speed, 0.0
        self.state, self.orders = rebound.state, rebound.orders
        self.stiffness, self.drag = (
            value if value >= _LEAST else 0.0 for value in (piston.valve.chamber.stiffness, piston.drag)
        )
        self.where: Literal["free", "in", "out"] = "free" if cushion is None or cushion.beyond > 0.0 else "in"
        self.passes = [(0.0, speed)]
        self.reach = 0.0  # … in this pass
        self.reaches: list[float] = []  # … in those before
        self.front_speed = 0.0
        self.ending: BlankEnding | None = None
        self.repeats = False

    def followed(self) -> BlankBlow:
        """Goes on until it is known what becomes of it."""
        for _ in range(_MOST_EVENTS):
            self._carry_out()
            self._fly()
            if self.ending is None and self._repeated():
                self.ending, self.repeats = "cycles without a blow", True
            if self.ending is not None or len(self.passes) > _MOST_PASSES:
                break
        return self._told()

    def _told(self) -> BlankBlow:
        reaches = [*self.reaches, self.reach]
        reach, most = reaches[0], max(reaches)
        worst = next(i for i, one in enumerate(reaches) if one >= most * (1.0 - _SAME))
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
        figures = *first, worst + 1, *self._into(reaches[worst]), self.front_speed
        return BlankBlow(*figures, self.ending or "goes on", len(self.passes), period, again)

    def _into(self, reach: float) -> tuple[float, float]:
        """Depth in the cushion, and its greatest force, of a piston that goes so far beyond the wall."""
        if self.cushion is None or reach <= self.cushion.beyond:
            return 0.0, 0.0
        if reach == math.inf:  # it pushes less than the valve, at any depth
            return math.inf, self.cushion.force
        depth = reach - self.cushion.beyond
        return depth, self.cushion.force + self.cushion.stiffness * depth

    # -- its way --

    def _carry_out(self) -> None:
        while self.orders.pending and self.orders.pending[0][0] <= self.time:
            (_, self.state), *left = self.orders.pending
            self.orders = replace(self.orders, pending=tuple(left))

    def _demand(self, number: int) -> None:
        self.orders = self.orders.after(self.time, self.piston.valve.ports[number])

    def _flight(self) -> Flight:
        push, stiffness = -self.piston.valve.force(self.state), self.stiffness
        if self.cushion is not None and self.where != "free":
            part = 1.0 if self.where == "in" else self.cushion.returned
            push += part * (self.cushion.force - self.cushion.stiffness * self.cushion.beyond)
            stiffness += part * self.cushion.stiffness
        return Flight(push, stiffness, self.drag, self.x, self.v)

    def _fly(self) -> None:
        """To the next event."""
        until = self.orders.pending[0][0] - self.time if self.orders.pending else math.inf
        flight = self._flight()
        if self.where == "free":
            self._fly_free(flight, until)
        elif self.where == "in" and self.v >= 0.0 and acceleration(flight) >= 0.0:
            self._hold(until)
        elif self.where == "in":
            self._fly_in(flight, until)
        else:
            self._fly_out(flight, until)

    def _went(self, flight: Flight, duration: float, place: float | None = None) -> None:
        """To where a flight is after a time, or to a place."""
        x, v = at(flight, duration)
        self.x, self.v, self.time = x if place is None else place, v, self.time + duration
        self.reach = max(self.reach, -self.x)

    def _due(self, flight: Flight, until: float) -> None:
        due = self.orders.pending[0][0]
        self._went(flight, until)
        self.time = due

    def _fly_free(self, flight: Flight, until: float) -> None:
        """Beside no cushion: to a port, to the place of the blow, or into the cushion."""
        edges, ways = self.piston.numbers[1][:2]
        front = None if self.cushion is None else -self.cushion.beyond
        places = [edges, ways] if front is None else [[*edges, front], [*ways, -1.0]]
        time, place, way = first_crossing(flight, places, until * (1.0 + _TOGETHER))
        if way == 0 and until == math.inf:
            self.reach = max([self.reach, *(-x for x in turning_places(flight))])
            goes = last_place(flight) == -math.inf
            self.ending = "leaves" if goes else "stops"
            self.reach = math.inf if goes else max(self.reach, -last_place(flight))
            return
        duration = time if way else until
        self.reach = max([self.reach, *(-x for x in turning_places(flight, duration))])
        if way == 0:
            self._due(flight, until)
            return
        self._went(flight, duration, place)
        if way < 0 and place == 0.0:
            self.passes.append((self.time, -self.v))
            self.reaches.append(self.reach)
            self.reach = 0.0
        for number, passed in enumerate(zip(edges, ways, strict=True)):
            if passed == (place, way):
                self._demand(number)
        if way < 0 and place == front:
            self.where = "in"

    def _fly_in(self, flight: Flight, until: float) -> None:
        """Into the cushion, until it turns, or to the front end."""
        assert self.cushion is not None
        end = math.inf if self.cushion.length is None else self.cushion.beyond + self.cushion.length
        turning = turning_time(flight)
        stop = min(turning, until)
        time, _, way = first_crossing(flight, [[-end], [-1.0]], stop * (1.0 + _TOGETHER))
        if way:
            self._went(flight, time, -end)
            self.ending, self.front_speed = "strikes the front end", -self.v
        elif stop == math.inf:
            goes = last_place(flight) == -math.inf
            self.ending = "leaves" if goes else "stops in the cushion"
            self.reach = math.inf if goes else max(self.reach, -last_place(flight))
        elif turning <= until:
            self._went(flight, turning)
            self.v = 0.0
        else:
            self._due(flight, until)

    def _hold(self, until: float) -> None:
        """At rest in the cushion, or going back where more pulls than pushes."""
        self.where = "out"
        if self.v > 0.0 or acceleration(self._flight()) > 0.0:
            return
        self.where = "in"
        if until == math.inf:
            self.ending = "stops in the cushion"
        else:
            self.time = self.orders.pending[0][0]

    def _fly_out(self, flight: Flight, until: float) -> None:
        """Out of the cushion, until it turns in it, or leaves it."""
        assert self.cushion is not None
        if self.v <= 0.0 and acceleration(flight) <= 0.0:  # the valve has changed
            self.where = "in"
            return
        turning = turning_time(flight)
        stop = min(turning, until)
        time, _, way = first_crossing(flight, [[-self.cushion.beyond], [1.0]], stop * (1.0 + _TOGETHER))
        if way:
            self._went(flight, time, -self.cushion.beyond)
            self.where = "free"
        elif stop == math.inf:
            self.ending = "stops in the cushion"
        elif turning <= until:
            self._went(flight, turning)
            self.v, self.where = 0.0, "in"
        else:
            self._due(flight, until)

    def _repeated(self) -> bool:
        """Whether the last passes were like the ones before."""
        if len(self.passes) < 4 or self.x != 0.0:
            return False
        (a, _), (b, u), (c, v), (d, w) = self.passes[-4:]
        steady = max(abs(w - v), abs(v - u)) <= _SAME * w
        return steady and max(abs((d - c) - (c - b)), abs((c - b) - (b - a))) <= _SAME * (d - c)
