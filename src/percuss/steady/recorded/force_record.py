"""A recorded force blow by blow: its cycles, their blows, and when it switches in each of them."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
import numpy.typing as npt

from percuss.errors import LoadError, ParameterError
from percuss.model import System
from percuss.model.checks import Array, finite, numbers
from percuss.recordings.cycle_fit import recorded_phases
from percuss.shown import Shown
from percuss.steady.orbit import Orbit
from percuss.steady.phases import phase_condition
from percuss.steady.recorded.implied import (
    WINDOW,
    Implied,
    Levels,
    changes,
    edge_times,
    implied_by_orbit,
    implied_by_record,
    sought_blows,
)
from percuss.steady.states import SteadyStates

Known = Literal["measured", "restitution", "phase"]

_FEWEST = 3  # blows of which a record tells anything
_NEAR = 1.0 / 8.0  # of a period: an edge farther from where the mean cycle has it is another one
_LOOKS = 257
_MEDIAN = 0.6745  # the median of |x| of a normal x, over its deviation
_SEEN = 0.5  # of the jump of the mean cycle
_FAR = 0.2  # of a period: a blow farther from where the mean cycle has it is another one


@dataclass(frozen=True)
class ForceRecord(Shown):
    """The record that a load was made from, and the times of its blows where they were measured.

    Parameters
    ----------
    time
        Shape (n,), s, increasing.
    force
        Shape (n,), in any unit: it is scaled to the load.
    blows
        Times of the blows (s) on the same clock, by strain, sound or acceleration; None where they are not known.

    Examples
    --------
    >>> ForceRecord([0.0, 1e-4, 2e-4], [1.0, 1.0, -2.0]).blows is None
    True
    """

    time: Array = field(repr=False)
    force: Array = field(repr=False)
    blows: Array | None = field(default=None, repr=False)

    def __init__(self, time: npt.ArrayLike, force: npt.ArrayLike, blows: npt.ArrayLike | None = None) -> None:
        t, p = numbers("time", time), numbers("force", force)
        struck = None if blows is None else numbers("blows", blows)
        if t.ndim != 1 or t.shape != p.shape or t.size < 2:
            raise ParameterError("force", f"shape {p.shape}", "as many values as times, two or more")
        for name, row in (("time", t), ("blows", struck)):
            if row is not None and (row.ndim != 1 or np.any(np.diff(row) <= 0.0)):
                raise ParameterError(name, f"shape {row.shape}", "a row of increasing times")
        for name, row in (("time", t), ("force", p), ("blows", struck)):
            object.__setattr__(self, name, row)


@dataclass(frozen=True)
class Cycles:
    """The cycles of a record, their motion from the first blow to the last one.

    `switches` tells when each edge of the mean cycle occurs in each cycle, NaN where it was not seen, shape (cycles,
    edges); `sample` is the time between samples, `noise` the deviation of the force, and `blows` whence their times are
    known: measured, those that the restitution asks for, or at the phase of the mean cycle.
    """

    motion: Implied
    switches: Array
    sample: float
    noise: float
    blows: Known


def recorded_cycles(
    system: System,
    record: ForceRecord,
    phases: Array,
    rate: float,
    phase: float,
    edges: Array,
    levels: Levels,
    added: float = 0.0,
) -> Cycles | None:
    """The cycles of the record that the load of a system was made from, or None where there are too few.

    `phases` are the load's (rad) at the samples, `rate` what goes by of it in a unit of time of the result; `phase` and
    `edges` are of the mean cycle: at its blow, and after that; `added` is added to the load.
    """
    load = system.load
    frequency = (phases[-1] - phases[0]) / (2.0 * np.pi * (record.time[-1] - record.time[0]))
    seconds = system.time_scale if system.is_si else 1.0 / (2.0 * np.pi * frequency)
    unit = 1.0 / (rate * seconds)  # of the result, per second
    time = record.time * unit
    told = load.value(phases)
    scale = float(np.vdot(told, told) / np.vdot(record.force, told))  # the load holds a part of the record's harmonics
    force, period = rate**2 * (scale * record.force + added), 2.0 * np.pi / rate
    first, last = np.ceil((phases[0] - phase) / (2.0 * np.pi)), np.floor((phases[-1] - phase) / (2.0 * np.pi))
    wanted = np.interp(phase + 2.0 * np.pi * np.arange(first, last + 1.0), phases, time)
    blows = wanted if record.blows is None else _beside(record.blows * unit, wanted, _FAR * period)
    if blows.size < _FEWEST:
        return None
    drag = system.d * rate
    sought = None
    if record.blows is None:
        sought = sought_blows(time, force, blows, drag, system.contact.velocity_factor)
        blows = blows if sought is None else sought
    motion = implied_by_record(time, force, blows, drag)
    bare = force - levels.stiffness * np.interp(time, motion.time, motion.behind)
    switches = _switches(time, bare, motion.blows, edges, levels.at_wall)
    switches[(switches < blows[0]) | (switches > blows[-1])] = np.nan
    known: Known = "phase" if sought is None else "restitution"
    if record.blows is not None:
        known = "measured"
    steps = np.diff(force, 2)  # of white noise with √6 times its deviation
    noise = float(np.median(np.abs(steps))) / (_MEDIAN * math.sqrt(6.0))
    return Cycles(motion, switches, float(np.median(np.diff(time))), noise, known)


def load_phases(system: System, record: ForceRecord) -> Array:
    """The phase of the load (rad) at every sample of the record that it was made from."""
    report = system.load.report
    frequency = system.frequency if report is None else report.frequency
    return recorded_phases(record.time, record.force, frequency)


def _switches(time: Array, force: Array, blows: Array, edges: Array, at_wall: Array) -> Array:
    """When each edge of the mean cycle occurs in each cycle, by the levels of that cycle; shape (cycles, edges)."""
    momentum = np.concatenate([[0.0], np.cumsum(0.5 * np.diff(time) * (force[1:] + force[:-1]))])
    period = float(np.mean(np.diff(blows)))
    window, near = WINDOW * period, np.linspace(-_NEAR * period, _NEAR * period, _LOOKS)
    jumps = at_wall - np.roll(at_wall, 1)
    found = np.full((blows.size - 1, edges.size), np.nan)
    for j, edge in enumerate(edges.tolist()):
        beside = blows[:-1] + edge if 2.0 * edge < period else blows[1:] + (edge - period)
        t = beside[:, None] + near
        rise, now, fall = (np.interp(t + shift, time, momentum) for shift in (window, 0.0, -window))
        change = (rise - 2.0 * now + fall) / (window * jumps[j])
        best = np.argmax(change, axis=1)
        row = np.arange(best.size)
        found[:, j] = np.where(change[row, best] > _SEEN, t[row, best], np.nan)
    ends = found.reshape(-1)
    begin, end = ends + 0.5 * window, np.append(ends[1:], np.nan) - 0.5 * window
    length = end - begin
    with np.errstate(invalid="ignore"):
        level = (np.interp(end, time, momentum) - np.interp(begin, time, momentum)) / length
        level = np.where(length > window, level, np.tile(at_wall, blows.size - 1))
    before = np.concatenate([at_wall[-1:], level[:-1]])
    return edge_times(time, force, ends, (before, level), window).reshape(found.shape)


def _beside(measured: Array, wanted: Array, far: float) -> Array:
    """The longest run of measured blows each of which lies near one of the mean cycle's, one after the other."""
    near = np.abs(measured[:, None] - wanted[None, :])
    which = np.argmin(near, axis=1)
    good = near[np.arange(measured.size), which] < far
    best: list[int] = []
    run: list[int] = []
    for i in range(measured.size):
        run = [*run, i] if good[i] and run and which[i] == which[run[-1]] + 1 else [i] if good[i] else []
        best = run if len(run) > len(best) else best
    return measured[best]


# ---- The motion of the mean cycle: which of the possible blows it has, and what is done where there is none

_TURN = 2.0 * math.pi
_SAMPLES = 4096
_INTO = 1e-6  # of the stroke, how far rounding takes a piston through the wall


@dataclass(frozen=True)
class MeanCycle:
    """The mean cycle from blow to blow in the machine's time, the load's phase there, and what was assumed."""

    system: System
    phase: float
    motion: Implied
    notes: tuple[str, ...]


def measured_phase(record: ForceRecord, phases: Array) -> float | None:
    """The mean phase of the load at the measured blows, or None without any."""
    if record.blows is None:
        return None
    struck = np.interp(record.blows, record.time, phases, left=np.nan, right=np.nan)
    struck = struck[np.isfinite(struck)]
    return float(np.angle(np.exp(1j * struck).mean()) % _TURN) if struck.size else None


def mean_cycle(states: SteadyStates, rate: float, blow: float | None, measured: float | None) -> MeanCycle:
    """The mean cycle that strikes nearest to phase `blow` under the clock; if `measured` just there, whatever R."""
    system = states.system
    if measured is not None:
        t = np.linspace(0.0, _TURN, _SAMPLES + 1)
        force = np.asarray(system.load.value(measured + t))
        motion = implied_by_record(t, force, np.array([0.0, _TURN]), system.d)
        note = "the blows are where they were measured, and the restitution is that of the record"
        return MeanCycle(system, measured, _in_time(motion, rate), (note,))
    if not states.orbits:
        orbit, note = _at_the_fold(states)
        return MeanCycle(orbit.system, orbit.phase, _in_time(implied_by_orbit(orbit), rate), (note,))
    fall = _TURN * float(np.argmin(changes(_sampled(system)))) / _SAMPLES
    wanted = fall if blow is None else finite("blow", blow)
    possible = [one for one in states.orbits if _stays_off(implied_by_orbit(one))]
    if not possible:
        raise LoadError(
            "the piston would pass through the wall in every motion that has the momentum of this load",
            "give the whole force on the piston, of a machine with one blow in a period",
        )
    orbit = min(possible, key=lambda one: abs(math.remainder(one.phase - wanted, _TURN)))
    notes = []
    if blow is None and len(possible) > 1:
        others = ", ".join(f"{one.phase:.4g}" for one in possible if one is not orbit)
        notes.append(
            f"where the blow falls was not measured: of the possible phases, {orbit.phase:.4g} rad is nearest to the "
            f"fall of the force ({others} rad besides)"
        )
    return MeanCycle(system, orbit.phase, _in_time(implied_by_orbit(orbit), rate), tuple(notes))


def _stays_off(motion: Implied) -> bool:
    """Whether the piston of a motion is behind the wall all the time."""
    return bool(motion.behind.min() >= -_INTO * motion.behind.max())


def _at_the_fold(states: SteadyStates) -> tuple[Orbit, str]:
    """The motion at the tip of v_f, which a smaller mean load allows: the blow as the force falls."""
    system, nearest = states.system, states.nearest
    assert nearest is not None
    arcs = phase_condition(system, 1).arcs
    tip = float(arcs.ends[int(np.argmax(arcs.velocities))]) % _TURN
    note = (
        f"no blow fits the whole load, so that its mean is taken {1.0 - nearest.mean / system.load.mean:.2g} of itself "
        "lower: then the blow comes just as the force falls"
    )
    return Orbit(system.with_load(system.load.with_mean(nearest.mean)), 1, tip, True), note


def _sampled(system: System) -> Array:
    return np.asarray(system.load.value(_TURN * np.arange(_SAMPLES) / _SAMPLES))


def _in_time(motion: Implied, rate: float) -> Implied:
    """The same motion in another unit of time."""
    return Implied(
        motion.time / rate, motion.force * rate**2, motion.behind, motion.velocity * rate, motion.blows / rate
    )
