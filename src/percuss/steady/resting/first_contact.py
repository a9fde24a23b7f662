"""The first contact of a flight, with the proof that there is none before: by Taylor's theorem, cell by cell."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from percuss.model.checks import Array
from percuss.steady.resting.leg import Leg

__all__ = ["Contact", "first_contact"]

_CELLS = 64
_WIDEST = 2.0  # rad, looked at at once
_TOUCH = 1e-14  # of the size of the motion, within which rounding decides whether the bar touches the wall
_STEPS = 80
_CLOSE = 1e-9  # share of the time at which Newton's method is about to end


class Contact(NamedTuple):
    """A contact: its time since the start of the leg, and the velocity of the striking end there."""

    time: float
    speed: float


def first_contact(leg: Leg, begin: float, end: float) -> Contact | None:
    """The first time in [begin, end) at which the striking end reaches the wall; None when there is none.

    Cells are dropped only where y + |y'| h + sup|y''| h²/2 < 0 at their middles; the first that is left has a contact
    when y' exceeds what sup|y''| can take back within twice its width, and y then grows beyond 0.

    Parameters
    ----------
    leg
        The flight.
    begin, end
        Between which times, since the start of the leg. The gap at `begin` is negative, or 0 and falling.
    """
    low, width = begin, _first_window(leg, begin)
    while low < end:
        wide = min(width, end - low)
        found = _within(leg, low, low + wide)
        if found is not None:
            return found if found.time < end else None
        low, width = low + wide, min(2.0 * width, _WIDEST)
    return None


def _first_window(leg: Leg, begin: float) -> float:
    """Some times the flight to be expected of a bar that has just struck, and not longer than y'' stays the same."""
    speed, force, jerk = -leg.rate, leg.acceleration, sum(leg.jerks)
    if leg.start.gap == 0.0 and speed <= 0.0 and begin > 0.0:
        return min(begin, _WIDEST)  # let go: as long as the load has pulled
    if leg.start.gap < 0.0 or speed <= 0.0 or jerk == 0.0:
        return _WIDEST
    steady = abs(force) / jerk + 2.0 * math.sqrt(speed / jerk)
    return min(6.0 * speed / force if force > 0.0 else _WIDEST, steady, _WIDEST)


def _within(leg: Leg, low: float, high: float) -> Contact | None:
    bend, half = min(leg.bend, abs(leg.acceleration) + sum(leg.jerks) * high), 0.5 * (high - low) / _CELLS
    touch = _TOUCH * min(1.0, abs(leg.start.gap) + (abs(leg.rate) + bend * high) * high)
    narrow = max(float(np.spacing(high)), 0.1 * math.sqrt(touch / bend) if bend > 0.0 else 0.0)
    centres: Array = np.asarray(low + half * (2.0 * np.arange(_CELLS) + 1.0), dtype=float)
    while centres.size:
        y, v = leg.gap(centres)
        unsafe = y + np.abs(v) * half + 0.5 * bend * half**2 >= 0.0
        centres, y, v = centres[unsafe], y[unsafe], v[unsafe]
        sure = (v > 3.0 * bend * half) & (y + 3.0 * half * v - 4.5 * bend * half**2 > 0.0)
        if sure.any():
            first = int(np.argmax(sure))
            if first == 0:
                return _refined(leg, float(centres[0] - half), float(centres[0] + 3.0 * half), float(centres[0]))
            centres, y = centres[: first + 2], y[: first + 2]  # the root may be in the next one
        if half < narrow:
            beyond = y > touch
            if beyond.any():  # too narrow for a rising y to be proved: a contact of no speed
                first = int(np.argmax(beyond))
                return Contact(float(centres[first]), max(float(v[first]), 0.0))
            return None
        half *= 0.5
        centres = np.sort(np.concatenate([centres - half, centres + half]))
    return None


def _refined(leg: Leg, low: float, high: float, guess: float) -> Contact:
    """The root of a y that grows between two times, by Newton's method kept between them."""
    t, speed, last = guess, 0.0, math.inf
    for _ in range(_STEPS):
        y, speed = leg.gap_at(t)
        if y < 0.0:
            low = max(low, t)
        else:
            high = min(high, t)
        new = t - y / speed if speed > 0.0 else math.nan
        if not low <= new <= high:
            new = 0.5 * (low + high)
        step, t = abs(new - t), new
        if step <= _CLOSE * t and (step >= 0.5 * last or step <= 2.0 * np.spacing(t)):
            break  # what is left is rounding
        last = step
    return Contact(t, leg.gap_at(t)[1])
