"""How a place and a delay share in where a valve switches: x_i = h + v_i τ, over all cycles that were recorded.

A port at h with the delay τ was passed at t_i − τ, if t_i are the times of the switch. The best delay is the one with
which the places passed then, x(t_i − τ), agree best, measured by what the record leaves in doubt of times and places.
All delays with which they agree nearly as well, by the F test, are its interval.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from percuss.model.checks import Array
from percuss.steady.recorded.implied import Implied

__all__ = ["Doubt", "Interval", "PortAndDelay", "Seen", "port_and_delay", "spread"]

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
    """The place and the delay of one switch, from all cycles in which it was seen.

    Parameters
    ----------
    seen
        The switch in each cycle.
    longest
        The longest delay that the valve may have.
    """
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
    """Where the port was passed, and the variance of that.

    White noise of the force, integrated twice between two blows at which the place is known, leaves that variance.
    """
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
