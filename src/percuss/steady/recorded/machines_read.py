"""The machines that a record may be of: switches by ports without delay, by longer delays, or as the cycles tell."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Literal, NamedTuple

import numpy as np
import numpy.typing as npt

from percuss.model import Chamber, Contact, Machine, Port, System, Valve
from percuss.model.checks import Array
from percuss.model.load.valve import Orders
from percuss.shown import Shown
from percuss.steady.recorded.force_record import Implied
from percuss.steady.self_excited.piston import cycle_near
from percuss.steady.self_excited.valve_cycle import Rebound, ValveCycle

# ---- How a place and a delay share in where a valve switches: x_i = h + v_i τ, over all cycles that were recorded
#
# A port at h with the delay τ was passed at t_i − τ, if t_i are the times of the switch. The best delay is the one with
# which the places passed then, x(t_i − τ), agree best, measured by what the record leaves in doubt of times and places.
# All delays with which they agree nearly as well, by the F test, are its interval.

_TRIED = 400
_SURE = 0.95
_FEWEST = 4  # cycles from which on port and delay are told apart
_LEAST = 1e-300
_TOLD = 0.5  # of the possible range: a longer interval tells nothing


class Interval(NamedTuple):
    """A value and the ends of its interval; of several cycles one of 95 %."""

    value: float
    low: float
    high: float


class Doubt(NamedTuple):
    """The standard error of the time of a switch; that of the force times the root of the time between samples."""

    time: float
    force: float


class Seen(NamedTuple):
    """A switch of one cycle: its time in a motion, and between which times its port was passed."""

    motion: Implied
    time: float
    first: float
    last: float
    since_blow: bool
    """Whether the first of them is a blow."""
    doubt: Doubt | None = None
    """Where the motion of the single cycle is known."""


@dataclass(frozen=True)
class PortAndDelay:
    """What is known of the place and of the delay of a switch.

    Attributes
    ----------
    port, delay
        Where they are told apart, of 95 %; else the value is that of the least delay, and the interval the whole range.
    told_apart
        Whether the cycles differ enough for it.
    least, longest
        The least and the longest delay that the motion allows.
    since_blow
        Whether the longest one reaches back to the blow.
    """

    port: Interval
    delay: Interval
    told_apart: bool
    least: float
    longest: float
    since_blow: bool


def spread(values: Array, least: float = 0.0) -> Interval:
    """The mean of a value over the cycles, with the interval of 95 % of that mean, no narrower than ± `least`."""
    from scipy.special import stdtrit  # slow to import

    mean, half = float(np.mean(values)), 0.0
    if values.size > 1:
        half = float(stdtrit(values.size - 1, 0.5 + 0.5 * _SURE) * np.std(values, ddof=1) / np.sqrt(values.size))
    half = max(half, least)
    return Interval(mean, mean - half, mean + half)


def port_and_delay(seen: Sequence[Seen], longest: float) -> PortAndDelay:
    """The place and the delay of one switch, from all cycles in which it was seen."""
    least = float(np.median([one.time - one.last for one in seen]))
    earliest = min(one.time - one.first for one in seen)
    most = max(least, min(longest, earliest))
    delays = np.linspace(least, most, _TRIED)
    places, squares = _agreeing(seen, delays)
    whole = PortAndDelay(
        Interval(float(places[0]), float(places.min()), float(places.max())),
        Interval(float(least), float(least), float(most)),
        False,
        float(least),
        float(most),
        all(one.since_blow for one in seen) and most == earliest,
    )
    if len(seen) < _FEWEST or most == least or any(one.doubt is None for one in seen):
        return whole
    left = _no_more_scattered(squares, len(seen))
    if delays[left[-1]] - delays[left[0]] > _TOLD * (most - least):  # the cycles do not differ by more than their doubt
        return whole
    for _ in range(2):  # the second time within what the first has left
        inside = _nearly_best(squares, len(seen))
        low, high = float(delays[max(inside[0] - 1, 0)]), float(delays[min(inside[-1] + 1, _TRIED - 1)])
        delays = np.linspace(low, high, _TRIED)
        places, squares = _agreeing(seen, delays)
    inside, best = _nearly_best(squares, len(seen)), int(np.argmin(squares))
    held = places[inside[0] : inside[-1] + 1]
    return replace(
        whole,
        port=Interval(float(places[best]), float(held.min()), float(held.max())),
        delay=Interval(float(delays[best]), float(delays[inside[0]]), float(delays[inside[-1]])),
        told_apart=True,
    )


def _agreeing(seen: Sequence[Seen], delays: Array) -> tuple[Array, Array]:
    """The mean place of the port with each delay, and the squares of the differences from it over their doubt."""
    x, variance = (np.stack(rows) for rows in zip(*(_passed(one, delays) for one in seen), strict=True))
    mean = x.mean(axis=0)
    return mean, ((x - mean) ** 2 / np.maximum(variance, _LEAST)).sum(axis=0)


def _passed(one: Seen, delays: Array) -> tuple[Array, Array]:
    """Where the port was passed, and the variance of that: of white noise integrated twice between two blows."""
    when, motion, doubt = one.time - delays, one.motion, one.doubt or Doubt(1.0, 1.0)
    x, v = motion.at(when)
    flight = np.clip(np.searchsorted(motion.blows, when, side="right") - 1, 0, motion.blows.size - 2)
    since, length = when - motion.blows[flight], np.diff(motion.blows)[flight]
    return x, (doubt.time * v) ** 2 + doubt.force**2 * (since * (length - since)) ** 2 / (3.0 * length)


def _nearly_best(squares: Array, cycles: int) -> npt.NDArray[np.intp]:
    """The delays that the F test does not tell from the best one."""
    from scipy.special import fdtri  # slow to import

    return np.flatnonzero(squares <= squares.min() + _scatter(squares, cycles) * float(fdtri(1, cycles - 2, _SURE)))


def _no_more_scattered(squares: Array, cycles: int) -> npt.NDArray[np.intp]:
    """The delays with which the places are not more scattered than with the best one, by the test of two variances."""
    from scipy.special import fdtri  # slow to import

    return np.flatnonzero(
        squares <= (cycles - 2) * _scatter(squares, cycles) * float(fdtri(cycles - 1, cycles - 1, _SURE))
    )


def _scatter(squares: Array, cycles: int) -> float:
    """The square of a difference over its doubt with the best delay, no less than the doubt itself."""
    return max(float(squares.min()) / (cycles - 2), 1.0)


# ---- The machines that a record may be of: switches by ports without delay, by longer delays, or as the cycles tell

_HALVINGS = 6


@dataclass(frozen=True)
class Reading(Shown):
    """A machine by one reading of a record.

    Attributes
    ----------
    machine
        The machine.
    cycle
        Its own cycle near the recorded motion, with a rigid piston; None where there is none.
    """

    machine: Machine
    cycle: ValveCycle | None

    @property
    def runs(self) -> bool:
        """Whether that cycle is stable."""
        return self.cycle is not None and self.cycle.stable

    def __str__(self) -> str:
        return f"Reading: {self.machine}; {'no cycle' if self.cycle is None else self.cycle}"


@dataclass(frozen=True)
class RecordedSwitch(Shown):
    """A change of the force, seen in a record.

    Attributes
    ----------
    to
        The state that follows.
    jump
        Rise of the force at the switch, per mass.
    time
        After the blow that is nearest; negative before it. Over the cycles, with 95 % of their mean.
    behind, velocity
        Where the piston is then, and its velocity away from the wall, with 95 % of their means.
    side
        Of the port: "back" where the force rises, which the piston passes on its way back, "front" where it falls.
    by_blow
        Whether the blow itself may have ordered it: the least delay is then that since the blow.
    found
        The place of the port and the delay.
    seen
        The switch in each cycle.
    """

    to: str
    jump: float
    time: Interval
    behind: Interval
    velocity: Interval
    side: Literal["back", "front"]
    by_blow: bool
    found: PortAndDelay
    seen: tuple[Seen, ...] = field(repr=False, compare=False)

    @property
    def best_delay(self) -> float:
        """The delay that the cycles tell; else the least one."""
        return self.found.delay.value if self.found.told_apart else self.found.least

    def port(self, delay: float) -> Port:
        """The port that has this delay, where the piston was that long before the switch."""
        place = float(np.mean([one.motion.at(one.time - delay)[0] for one in self.seen]))
        struck = (self.by_blow and delay <= self.found.least) or (self.found.since_blow and delay >= self.found.longest)
        if struck or place <= 0.0:
            return Port(self.to, delay=delay, on="impact")
        return Port(self.to, behind=place, side=self.side, delay=delay)

    def __str__(self) -> str:
        when = f"{abs(self.time.value):.5g} {'before' if self.time.value < 0.0 else 'after'} the blow"
        apart = f"port {self.found.port.value:.5g}, delay {self.found.delay.value:.4g}"
        told = apart if self.found.told_apart else f"a delay up to {self.found.delay.high:.4g}"
        return f"{self.to}: {when}, {self.behind.value:.5g} behind the wall at {self.velocity.value:.5g}; {told}"


def state_names(number: int) -> list[str]:
    """Names of so many states, by rising force."""
    return ["return", "power"] if number == 2 else [f"state {i}" for i in range(1, number + 1)]


def machine_read(
    system: System,
    contact: Contact,
    forces: list[float],
    stiffness: float,
    switches: tuple[RecordedSwitch, ...],
    delays: list[float],
) -> Machine:
    """The machine whose switches have these delays; forces per mass, all in the unit of time of the machine."""
    states = dict(zip(state_names(len(forces)), forces, strict=True))
    ports = tuple(switch.port(delay) for switch, delay in zip(switches, delays, strict=True))
    valve = Valve(states, ports, chamber=Chamber(0.0, stiffness))
    if system.bar is None:
        return Machine(system.body, valve, contact, at=system.load.at)
    bar = system.bar
    sized = valve.scaled(bar.mass * bar.length, bar.length)
    return Machine.from_si(bar, sized, contact, at=system.load.at)


def longest_that_run(made: Callable[[list[float]], Reading], switches: tuple[RecordedSwitch, ...]) -> Reading:
    """The machine with the longest delays, all the same part of what the motion allows, with which it runs steadily."""

    def at(part: float) -> Reading:
        return made([s.found.least + part * (s.found.longest - s.found.least) for s in switches])

    least, longest = at(0.0), at(1.0)
    if longest.runs:
        return longest
    low, high = 0.0, 1.0
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        tried = at(middle)
        if tried.runs:
            low, least = middle, tried
        else:
            high = middle
    return least


def cycle_read(machine: Machine, switches: tuple[RecordedSwitch, ...], speed: float) -> ValveCycle | None:
    """The cycle of a machine near the recorded motion, with the orders pending at its blow; None without one."""
    late = [
        (switch.time.value, switch.to)
        for switch, port in zip(switches, machine.valve.ports, strict=True)
        if port.on == "entering" and 0.0 < switch.time.value < port.delay
    ]
    pending, now = sorted(late), switches[-1].to
    orders = Orders(pending[-1][1] if pending else now, tuple(pending))
    rebound = Rebound(-machine.contact.velocity_factor * speed, now, orders)
    return cycle_near(machine, rebound, 1)
