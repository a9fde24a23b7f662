"""A recorded force blow by blow: its cycles, their blows, and when it switches in each of them."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
import numpy.typing as npt

from percuss.errors import ParameterError
from percuss.model import System
from percuss.model.checks import Array, numbers
from percuss.recordings.recorded_cycles import recorded_phases
from percuss.shown import Shown
from percuss.steady.recorded.edges import WINDOW, Levels, edge_times
from percuss.steady.recorded.implied import Implied, implied_by_record, sought_blows

__all__ = ["Cycles", "ForceRecord", "load_phases", "recorded_cycles"]

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

    Raises
    ------
    ParameterError
        For rows of different lengths, values that are not finite, or a time that does not increase.

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
    """The cycles of a record.

    Parameters
    ----------
    motion
        From the first blow to the last one.
    switches
        When each edge of the mean cycle occurs in each cycle, NaN where it was not seen; shape (cycles, edges).
    sample
        Time between samples.
    noise
        Standard deviation of the force from sample to sample.
    blows
        Whence the times of the blows are known: they were measured; they are those that the restitution asks for; or
        they are at the phase of the mean cycle.
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

    Parameters
    ----------
    phases
        Of the load (rad) at the samples of the record.
    rate
        The load's phase that goes by in a unit of time of the result.
    phase
        Of the load at the blow of the mean cycle.
    edges
        Of the mean cycle: times after the blow, in the unit of the result.
    levels
        After each edge; forces per mass, and lengths in those of the body.
    added
        What is added to the force of the record, in the unit of the load.
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
    """The phase of the load (rad) at every sample of the record that it was made from.

    Raises
    ------
    HistoryError
        When the record does not hold two cycles of the load.
    """
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
