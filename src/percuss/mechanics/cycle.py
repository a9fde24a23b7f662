"""The linearised motion through the events of a cycle: flows, and one saltation matrix at each event.

Disturbances are columns, of displacement and velocity of every coordinate at fixed times. An event of a motion that is
disturbed comes later by δt: with the rates F⁻ and F⁺ on its two sides, and D = diag(α, β) at a blow, else 1,

    x ↦ D (x + F⁻ δt) − F⁺ δt,

which with δt = −g·x/(g·F⁻) for a guard g is the saltation matrix D + (F⁺ − D F⁻) gᵀ/(gᵀF⁻) (Leine & Nijmeijer,
Dynamics and Bifurcations of Non-Smooth Mechanical Systems, 2004, ch. 7). The event at a time that another event fixes
is as much later as that one.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import NamedTuple

import numpy as np

from percuss.model.checks import Array


class Event(NamedTuple):
    """A flight and the event at its end, of n coordinates.

    Parameters
    ----------
    flow
        The flight's map of displacement and velocity; shape (n, 2, 2).
    before, after
        Velocity and acceleration on the two sides of the event; shapes (n, 2).
    turn
        By what the event multiplies displacements and velocities; shape (2,).
    """

    flow: Array
    before: Array
    after: Array
    turn: Array


def linearised(
    events: Iterable[Event], now: Array, later: Callable[[int, Array, Array], Array]
) -> tuple[Array, list[Array]]:
    """The disturbances after the last event, shape (n, 2, C), and in the state just before each event, wherever it is.

    Parameters
    ----------
    events
        In order.
    now
        The disturbances before the first flight.
    later
        How much later an event is, shape (C,): of its number, the disturbances there at fixed times, and the rate.
    """
    seen = []
    for i, event in enumerate(events):
        now = event.flow @ now
        shift = later(i, now, event.before)
        seen.append(now + event.before[:, :, None] * shift)
        now = event.turn[:, None] * seen[-1] - event.after[:, :, None] * shift
    return now, seen


def guarded(row: Array, now: Array, rate: Array) -> Array:
    """How much later a guard is met, whose row weighs the displacements."""
    return np.asarray(-(row @ now[:, 0]) / (row @ rate[:, 0]))
