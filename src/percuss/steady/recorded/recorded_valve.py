"""The machine behind a recorded load: where and when its force switches, read as ports and delays of a valve."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Literal, NamedTuple

import numpy as np
import numpy.typing as npt

from percuss.errors import LoadError, ParameterError
from percuss.model import Chamber, Contact, Machine, Port, System, Valve
from percuss.model.checks import Array, instance, positive
from percuss.model.load.valve import Orders
from percuss.short_repr import ShortRepr
from percuss.steady.phases import level_factor
from percuss.steady.recorded.force_record import (
    WINDOW,
    Cycles,
    ForceRecord,
    Implied,
    Levels,
    MeanCycle,
    by_momentum,
    edge_times,
    levels_between,
    load_phases,
    mean_cycle,
    measured_phase,
    recorded_cycles,
    rough_edges,
)
from percuss.steady.self_excited.piston import cycle_near
from percuss.steady.self_excited.valve_cycle import Rebound, ValveCycle
from percuss.steady.states import SteadyStates, steady_states

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
    since_blow: bool  # whether the first of them is a blow
    doubt: Doubt | None = None  # where the motion of the single cycle is known


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
class Reading(ShortRepr):
    """A machine by one reading of a record.

    Attributes
    ----------
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
class RecordedSwitch(ShortRepr):
    """A change of the force, seen in a record.

    Attributes
    ----------
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


# ---- Each switch of a recorded force with the motion before it: when, where and in which direction it was seen

_RESOLVED = 0.3  # of the time between samples: the deviation of an edge that lies anywhere between two
_PAST_TURN = 0.1
_AT_ONCE = 1.0 / 512.0  # of a period: a fall no farther from the blow than this is ordered by it


def recorded_switch(
    j: int, number: list[int], forces: list[float], edges: Array, motion: Implied, cycles: Cycles | None, longest: float
) -> RecordedSwitch:
    """The switch at the edge j, from all cycles in which it was seen; `number` is the state after each edge."""
    jump = forces[number[j]] - forces[number[j - 1]]
    period = float(motion.blows[-1])
    since = float(edges[j]) if 2.0 * edges[j] < period else float(edges[j]) - period
    still = since * float(motion.at(edges[j] % period)[1]) >= 0.0
    by_blow = jump < 0.0 and since > -_AT_ONCE * period and still
    whole, times = _twice(motion), edges[j : j + 1]
    if cycles is not None:
        whole, times = cycles.motion, cycles.switches[:, j]
    found = [one for t in times if (one := _seen(whole, float(t), jump > 0.0)) is not None]
    if not found:
        cycles, whole = None, _twice(motion)
        found = [one for one in [_seen(whole, float(edges[j]), jump > 0.0)] if one is not None]
    x, v = whole.at([one.time for one in found])
    after = [one.time - whole.blows[np.argmin(np.abs(whole.blows - one.time))] for one in found]
    sample = period / motion.time.size if cycles is None else cycles.sample
    total = math.sqrt(sum((forces[a] - forces[b]) ** 2 for a, b in zip(number, number[-1:] + number[:-1], strict=True)))
    doubt = _doubt(cycles, jump, total, period)
    seen = tuple(one._replace(doubt=doubt) for one in found)
    half = 0.5 * sample  # nothing is known better
    return RecordedSwitch(
        to=state_names(len(forces))[number[j]],
        jump=jump,
        time=spread(np.array(after), half),
        behind=spread(x, half * float(np.abs(v).mean())),
        velocity=spread(v, half * abs(jump)),
        side="back" if jump > 0.0 else "front",
        by_blow=by_blow,
        found=port_and_delay(seen, longest),
        seen=seen,
    )


def _doubt(cycles: Cycles | None, jump: float, jumps: float, period: float) -> Doubt | None:
    """What a record with measured blows leaves in doubt (edges between samples are noise); None for no cycles."""
    if cycles is None or cycles.blows != "measured":
        return None
    momentum = cycles.noise * math.sqrt(2.0 * WINDOW * period * cycles.sample)
    time = math.hypot(_RESOLVED * cycles.sample, momentum / jump)
    between = _RESOLVED * cycles.sample * jumps / math.sqrt(period)
    return Doubt(time, math.hypot(cycles.noise * math.sqrt(cycles.sample), between))


def _seen(motion: Implied, time: float, rises: bool) -> Seen | None:
    """A switch and the times between which its port was passed: on the way back where the force rises."""
    flight = int(np.searchsorted(motion.blows, time, side="right")) - 1
    if not math.isfinite(time) or not 0 <= flight < motion.blows.size - 1:
        return None
    if rises:
        begin = float(motion.blows[flight])
        return Seen(motion, time, begin, min(time, _farthest(motion, flight)), True)
    if motion.at(time)[1] < 0.0:
        return _falling(motion, time, flight, time)
    return None if flight == 0 else _falling(motion, time, flight - 1, float(motion.blows[flight]))


def _falling(motion: Implied, time: float, flight: int, last: float) -> Seen:
    """A port passed on the way to the wall; a little after the turn at the earliest, where it would be touched only."""
    turn = _farthest(motion, flight)
    return Seen(motion, time, turn + _PAST_TURN * (last - turn), last, False)


def _farthest(motion: Implied, flight: int) -> float:
    first = int(np.searchsorted(motion.time, motion.blows[flight], side="right"))
    last = int(np.searchsorted(motion.time, motion.blows[flight + 1]))
    return float(motion.time[first + int(np.argmax(motion.behind[first:last]))])


def _twice(motion: Implied) -> Implied:
    """The mean cycle with the one before it, the blow between them at the time 0."""
    period = float(motion.blows[-1])
    force, behind, velocity = (np.tile(row, 2) for row in (motion.force, motion.behind, motion.velocity))
    time = np.concatenate([motion.time - period, motion.time])
    return Implied(time, force, behind, velocity, np.array([-period, 0.0, period]))


# ---- The machine behind a recorded load: where and when its force switches, read as ports and delays of a valve

_ERRORS = 1.96  # standard errors
_PULLS = 0.02  # of the highest force: a record that pulls with less leaves out what pulls the piston back
_FELT = 0.02  # of the greatest jump: a chamber that adds less over the stroke is none


@dataclass(frozen=True)
class RecordedValve(ShortRepr):
    """A machine that switches itself, as a recorded load shows it; in the units of its machines.

    Attributes
    ----------
    phase
        Of the load at the blow (rad).
    phases
        All phases at which the load lets the piston strike steadily; none where the level is above the fold: `phase` is
        then that of the tip.
    period, speed, stroke
        Of the implied motion of the mean cycle: time from blow to blow, speed of the blow, greatest distance.
    forces
        Of the states at the wall, in rising order.
    stiffness
        Of the gas chamber, by the slope of the force against the distance.
    switches
        The switches of a cycle, in order after the blow.
    cycles
        Cycles of the record that were followed one by one; 0 where only the mean cycle is known.
    restitution
        Speed after a blow over that before it, of the record, where the blows were measured; else None.
    by_ports, by_delays
        The two extreme readings: with the least delays, so that the valve switches where the piston is, and with the
        longest ones (the same part of what each switch allows) with which the machine runs as steadily as it did.
    machine
        The best reading: with the ports and delays that the cycles tell apart, and the least delays of the others.
    mean_at_switch
        The mean force with which the blow would come just as the force falls (per mass).
    opposing_share
        Where the record never pulls, so that it leaves out a constant force that pulls the piston back: that force over
        the highest recorded one, estimated so that the blow comes at the switch. With a front chamber that is always
        under supply it is the ratio of the front area to the rear one.
    mean_change
        By how much the mean force was taken lower for the motion to be possible, over itself.
    notes
        What was taken for granted, one sentence each.
    """

    system: System
    phase: float
    phases: tuple[float, ...]
    period: float
    speed: float
    stroke: float
    forces: tuple[float, ...]
    stiffness: Interval
    switches: tuple[RecordedSwitch, ...]
    cycles: int
    restitution: Interval | None
    by_ports: Reading
    by_delays: Reading
    machine: Machine
    mean_at_switch: float
    opposing_share: float | None
    mean_change: float
    notes: tuple[str, ...]

    def __str__(self) -> str:
        lines = [f"RecordedValve: speed {self.speed:.6g}, period {self.period:.6g}, stroke {self.stroke:.6g}"]
        return "\n".join([*lines, *(f"  {switch}" for switch in self.switches)])


def recorded_valve(
    system: System, *, blow: float | None = None, record: ForceRecord | None = None, longest_delay: float | None = None
) -> RecordedValve:
    """Read a recorded load as that of a machine whose valve the piston works.

    The piston is taken to be rigid, and to strike once in a period. A cycle shows where the piston is when the force
    switches, not where the port is: with a delay the piston has passed it before. Cycles of different speeds tell port
    and delay apart; otherwise the two extreme readings are the answer.

    Parameters
    ----------
    system
        The hammer under the clocked load: a recorded history, or steps. The load must be the whole force on the piston,
        with that of any gas.
    blow
        Phase of the load (rad) at which the blow was recorded. Without it, and without measured blows in `record`, the
        blow that is nearest to the greatest fall of the force is taken.
    record
        The record that the load was made from: then its cycles are read one by one, which gives intervals.
    longest_delay
        The longest delay that the valve may have, in the units of the machine: s for one in SI.

    Returns
    -------
    RecordedValve
        In the units of `Machine`: with SI seconds and bar lengths, else those of the system.

    Raises
    ------
    LoadError
        When the load does not push, is constant, or does not switch.
    HistoryError
        When the record does not hold the cycles of the load.
    ParameterError
        When an argument is none of these, or the load acts on a step of the body.

    Examples
    --------
    >>> from percuss import Load, System
    >>> load = Load.steps([0.0, 2.0, 4.5, 6.0], [-0.4, -0.4, 1.8, -0.4])
    >>> read = recorded_valve(System(s=50.0, d=0.0, restitution=0.2, load=load))
    >>> print(read.machine.valve.ports[0].side, read.switches[0].to)
    back power
    """
    instance("system", system, System)
    longest = math.inf if longest_delay is None else positive("longest_delay", longest_delay)
    states = steady_states(system)
    if states.level_max <= 0.0:
        raise LoadError("no blow can be kept up under any mean load", "give the whole force on the piston")
    rate = system.angular_frequency if system.is_si else 1.0
    phases = None if record is None else load_phases(system, instance("record", record, ForceRecord))
    struck = None if record is None or phases is None else measured_phase(record, phases)
    mean = mean_cycle(states, rate, blow, struck)
    period = float(mean.motion.blows[-1])
    edges, levels = _switching(mean, period)
    cycles = None
    if record is not None and phases is not None:
        added = mean.system.load.mean - system.load.mean
        cycles = recorded_cycles(system, record, phases, rate, mean.phase, edges, levels, added)
    notes = [*mean.notes, *_of_cycles(record, cycles)]
    stiffness = _stiffness(levels, mean.motion)
    if stiffness.value == 0.0:
        levels = levels_between(mean.motion, edges, period, _told(mean), sloped=False)
    fitted, levels, turn = by_momentum(mean.motion, edges, levels)
    if cycles is not None:
        seen = np.roll(cycles.switches, turn, axis=1)
        early = (fitted - seen + cycles.motion.blows[:-1, None] + 0.5 * period) % period - 0.5 * period
        early[:, np.isnan(early).all(axis=0)] = 0.0  # an edge that no cycle shows
        cycles = replace(cycles, switches=seen + np.nanmean(early, axis=0))
    edges, (number, forces) = fitted, levels.states
    switches = tuple(recorded_switch(j, number, forces, edges, mean.motion, cycles, longest) for j in range(edges.size))
    speed = float(mean.motion.speeds[0])
    contact, restitution = _contact(system, cycles, notes)

    def made(delays: list[float]) -> Reading:
        machine = machine_read(system, contact, forces, stiffness.value, switches, delays)
        return Reading(machine, cycle_read(machine, switches, speed))

    by_ports = made([switch.found.least for switch in switches])
    by_delays = longest_that_run(made, switches)
    machine = made([switch.best_delay for switch in switches]).machine
    notes += _of_reading(switches, stiffness)
    at_switch, share = _at_switch(states, rate, forces, mean)
    return RecordedValve(
        system=system,
        phase=mean.phase,
        phases=tuple(orbit.phase for orbit in states.orbits),
        period=period,
        speed=speed,
        stroke=float(mean.motion.behind.max()),
        forces=tuple(forces),
        stiffness=stiffness,
        switches=switches,
        cycles=0 if cycles is None else cycles.switches.shape[0],
        restitution=restitution,
        by_ports=by_ports,
        by_delays=by_delays,
        machine=machine,
        mean_at_switch=at_switch,
        opposing_share=share,
        mean_change=1.0 - mean.system.load.mean / system.load.mean,
        notes=tuple(notes),
    )


def _of_cycles(record: ForceRecord | None, cycles: Cycles | None) -> list[str]:
    """What is taken for granted of the cycles of a record."""
    if record is None:
        return []
    if cycles is None:
        return ["the record holds too few blows to read its cycles one by one: only the mean cycle is read"]
    return ["the blow of each cycle is taken at the phase of the mean cycle's"] if cycles.blows == "phase" else []


def _of_reading(switches: tuple[RecordedSwitch, ...], stiffness: Interval) -> list[str]:
    """What the switches and the gas do not tell."""
    notes = []
    if not all(switch.found.told_apart for switch in switches):
        notes.append("the cycles do not tell all ports and delays apart: they are too few, or too much alike")
    if stiffness.value > 0.0:
        notes.append(
            "the force of the gas at the wall is in the forces of the states: a record does not tell it from that of "
            "the oil, so that margins of the gas are those of its stiffness alone"
        )
    return notes


def _switching(mean: MeanCycle, period: float) -> tuple[Array, Levels]:
    """The edges of the mean cycle as times after the blow, and the levels after each."""
    motion = mean.motion
    rough = motion.time[rough_edges(motion.force[:-1])]
    if rough.size < 2:
        raise LoadError(
            "the load does not switch between levels: it has no two steep edges in a period",
            "a valve is read from a force or a pressure that it switches, recorded at the piston",
        )
    edges, levels = rough, levels_between(motion, rough, period, _told(mean))
    for _ in range(2):
        bare = motion.force - levels.stiffness * motion.behind
        time = np.concatenate([motion.time[:-1] + shift * period for shift in (-1, 0, 1)])
        after = levels.at_wall
        edges = edge_times(time, np.tile(bare[:-1], 3), rough, (np.roll(after, 1), after), WINDOW * period)
        edges = np.sort(edges % period)
        levels = levels_between(motion, edges, period, _told(mean))
    return edges, levels


def _told(mean: MeanCycle) -> float:
    """How many independent numbers the load of a mean cycle is."""
    load = mean.system.load
    return float(mean.motion.time.size if load.is_piecewise else 2 * load.harmonics.size)


def _stiffness(levels: Levels, motion: Implied) -> Interval:
    """Of the gas chamber; 0 where the slope is not told from 0, or is too small to be felt."""
    half = _ERRORS * levels.error
    low, high = max(0.0, levels.stiffness - half), max(0.0, levels.stiffness + half)
    felt = levels.stiffness * float(np.ptp(motion.behind)) > _FELT * float(np.ptp(levels.at_wall))
    return Interval(levels.stiffness if low > 0.0 and felt else 0.0, low, high)


def _contact(system: System, cycles: Cycles | None, notes: list[str]) -> tuple[Contact, Interval | None]:
    """The contact with the restitution of the record where the blows were measured."""
    if cycles is None or cycles.blows != "measured":
        return system.contact, None
    found = spread(cycles.motion.rebounds[1:] / cycles.motion.speeds[:-1])
    if not 0.0 <= found.value <= 1.0:
        notes.append(
            f"the measured blows would need a restitution of {found.value:.3g}, which there is not: the zero of the "
            "force or the clock of the blows is off, and the restitution given is kept"
        )
        return system.contact, found
    return system.contact.with_restitution(found.value), found


def _at_switch(states: SteadyStates, rate: float, forces: list[float], mean: MeanCycle) -> tuple[float, float | None]:
    """The mean force with which the blow comes as the force falls, and the opposing force that this takes."""
    system = states.system
    period = 2.0 * math.pi
    fold = states.level_max / (period * float(level_factor(system.d * period, system.contact.impedance_ratio)))
    left_out = rate**2 * (system.load.mean - mean.system.load.mean)  # of the mean, where it was changed
    low, high = forces[0] + left_out, forces[-1] + left_out
    share = rate**2 * (system.load.mean - fold) / high if low > -_PULLS * high else None
    return rate**2 * fold, share


# ---- One machine from several of its records: cycles of different speeds tell its ports from its delays


def recorded_together(
    first: RecordedValve, *others: RecordedValve, longest_delay: float | None = None
) -> RecordedValve:
    """The reading of the first record, with ports and delays that all records tell together.

    Ports and delays belong to the machine, forces and speeds to each record, at another pressure or with another feed
    force. The records must be in SI, so that their units are the same, and the blows of all must have been measured.

    Parameters
    ----------
    first
        Its forces, its contact and its notes are kept.
    others
        Readings of other records of the same machine.
    longest_delay
        The longest delay that the valve may have (s).

    Raises
    ------
    ParameterError
        When there are no others, one is dimensionless, or they switch in another order.
    """
    longest = math.inf if longest_delay is None else positive("longest_delay", longest_delay)
    read = (instance("first", first, RecordedValve), *(instance("others", one, RecordedValve) for one in others))
    if not others:
        raise ParameterError("others", "none", "one or more readings of other records of the same machine")
    for one in read:
        if not one.system.is_si:
            raise ParameterError("record", "dimensionless", "readings in SI, whose seconds and metres are the same")
        if one.system.length_scale != first.system.length_scale:
            raise ParameterError("record", "another body", "records of one machine")
        if [switch.to for switch in one.switches] != [switch.to for switch in first.switches]:
            raise ParameterError("record", [switch.to for switch in one.switches], "the same switches in each record")
    switches = tuple(
        replace(switch, found=port_and_delay(seen, longest), seen=seen)
        for switch, *same in zip(*(one.switches for one in read), strict=True)
        for seen in [tuple(one for switch_ in (switch, *same) for one in switch_.seen)]
    )
    delays = [switch.best_delay for switch in switches]
    machine = machine_read(
        first.system, first.machine.contact, list(first.forces), first.stiffness.value, switches, delays
    )
    return replace(first, switches=switches, machine=machine, cycles=sum(one.cycles for one in read))
