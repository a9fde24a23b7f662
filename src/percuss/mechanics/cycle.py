"""A cycle: flights and events in an order that repeats, told by the times of its guarded events alone.

Between events the coordinates are free of each other, and every one goes through the cycle by one affine map of its
own, (u, v) → M (u, v) + c. So the state after the blow that begins a cycle follows from the times of the events, by one
2×2 solve for each coordinate, and what is left to solve for are these times: of as many as there are guards met, and of
the blow that ends the cycle, whatever the number of coordinates. A rigid body has one.

With a supply each state of the valve has coordinates of its own, and the pressure is one number more: the map is one of
all of them together, with a projection at each change of the state, and so is the solve. The times are the unknowns
there, too. Where the delay of an order depends on the pressure at which it is given, the delays are solved for inside,
at given times; the derivatives are those with the delays that follow.

Disturbances are columns, of displacement and velocity of every coordinate, and of the pressure, at fixed times. An
event of a motion that is disturbed comes later by δt: with the rates F⁻ and F⁺ on its two sides, and D = diag(α, β) at
a blow, the projection at a change of the state, else 1,

    x ↦ D (x + F⁻ δt) − F⁺ δt,

which with δt = −g·x/(g·F⁻) for a guard g is the saltation matrix D + (F⁺ − D F⁻) gᵀ/(gᵀF⁻) (Leine & Nijmeijer,
Dynamics and Bifurcations of Non-Smooth Mechanical Systems, 2004, ch. 7). The event at a time that another event fixes
is as much later as that one.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from percuss.mechanics.flow import StateFlow
from percuss.mechanics.kernel_cache import ensure_cache
from percuss.model.checks import Array

# ---- The linearised motion through events: flows, and one saltation matrix at each of them
#
# A state is of shape (n, 2), displacement and velocity of every coordinate, where each moves by itself: matrices are of
# shape (n, 2, 2) then, or (2, 2) for all. Or it is one row of all numbers, and matrices are matrices.


class CycleStep(NamedTuple):
    """A flight with the matrix `flow`, the event at its end, `turn`, and the rates of the state before and after it."""

    flow: Array
    before: Array
    after: Array
    turn: Array


def linearised(
    events: Iterable[CycleStep], now: Array, later: Callable[[int, Array, Array], Array]
) -> tuple[Array, list[Array]]:
    """The disturbances after the last event, a state with C columns, and those just before each, wherever it is."""
    # They are `now` before the first flight. `later`: how much later an event is, (C,), of its number, the disturbances
    # there at fixed times, and the rate.
    seen = []
    for i, event in enumerate(events):
        now = event.flow @ now
        shift = later(i, now, event.before)
        seen.append(now + event.before[..., None] * shift)
        now = event.turn @ seen[-1] - event.after[..., None] * shift
    return now, seen


def guarded(row: Array, now: Array, rate: Array) -> Array:
    """How much later a guard is met, whose row weighs a state."""
    return np.asarray(-read(row, now) / read(row, rate))


def read(row: Array, states: Array) -> Array:
    """What a row says of a state, or of each of its columns."""
    return np.asarray(np.tensordot(row, states, row.ndim))


# ---- The cycle through given times: what it must satisfy to repeat, and its derivatives
#
# Derivatives are those of the state at the event, which moves in time with it: an impact is then diag(α, β) of its law,
# and a jump of the force shows only in the accelerations on its two sides.


_STEPS, _NO_MAP = 30, np.empty((0, 0))


class Timing(NamedTuple):
    """When an event of a cycle is: `later` than that with the number `source` among those whose times are unknown.

    It is its own source, 0 later, where it is guarded; −1 is the blow at time 0. `later` holds at the pressure 1 where
    it depends on that at the source. `wrapped`: how many cycles before its source is. `lies`: the bar is laid down
    undeformed, as by a blow after which it rests on the wall.
    """

    source: int
    later: float
    wrapped: int
    guarded: bool
    blow: bool
    lies: bool = False


class Closed(NamedTuple):
    """The motion that belongs to given times of the events, and how far it is from what it should be.

    `start` is the state just after the blow at time 0, and `states` those just before each event; `error` is of the
    guards; `slope` are its derivatives by the unknown times; `delays` are how much later than its source each event is.
    See `Cycle.parts` for what a state is.
    """

    start: Array
    states: list[Array]
    error: Array
    slope: Array
    delays: Array


class ClosureKernels(NamedTuple):
    """The compiled functions, and the room that they work in; see `percuss.mechanics.closure_kernels`."""

    room_for: Callable[..., Any]
    solved: Callable[..., bool]
    corrected: Callable[..., tuple[int, int]]


@cache
def closure_kernels() -> ClosureKernels:
    """Load them, from numba's cache if they are there; else each is compiled when it is first called."""
    ensure_cache()
    from percuss.mechanics import closure_kernels as found

    return ClosureKernels(found.room_for, found.solved, found.corrected)


class Cycle:
    """The events of a cycle in a fixed order, the last one the blow that ends it.

    `turn` is what a blow multiplies displacements and velocities by; `flows` are those of each flight; guards are met
    where `rows` · states = `levels`, in the coordinates of the flight before; rows are of shape (N + 1, 2). `row` are
    all its numbers in one.
    """

    def __init__(
        self, flows: Sequence[StateFlow], turn: Array, timings: Sequence[Timing], rows: Sequence[Array], levels: Array
    ) -> None:
        self.flows, self.turn, self.timings = flows, turn, timings
        self.guards = [i for i, one in enumerate(timings) if one.guarded]
        self.size, self.supplied = flows[0].modes.omega.size, flows[0].compliance < np.inf
        kinds = {id(flow): flow for flow in flows}
        number, self.kinds, self.wrapped = {key: i for i, key in enumerate(kinds)}, len(kinds), 0
        delayed = [i for i, one in enumerate(timings) if self.supplied and one.later > 0.0]
        self.order = np.full((len(timings), 7), -1)
        for i, one in enumerate(timings):
            waits = self.wrapped if one.wrapped else -1
            self.order[i, [0, 1, 2, 3, 5]] = number[id(flows[i])], one.source, one.wrapped, waits, one.blow + one.lies
            self.wrapped += one.wrapped
        self.order[self.guards, 4], self.order[delayed, 6] = np.arange(len(self.guards)), np.arange(len(delayed))
        modal = [(flow.modes.omega, flow.modes.damping, flow.modes.driven) for flow in kinds.values()]
        forces = [
            (flow.held, flow.draw, flow.supplied, 1.0 / flow.compliance, flow.quickening) for flow in kinds.values()
        ]
        later = [one.later for one in timings]
        turned = [self._turned(i) for i in range(len(timings))] if self.supplied else []
        wall = flows[0].modes.end
        guards = [*rows, np.stack([wall, 0.0 * wall], axis=1)]
        parts = (modal, forces, guards, levels, later, turn, turned)
        self.row = np.concatenate([np.asarray(part, dtype=float).reshape(-1) for part in parts])

    @property
    def room(self) -> Any:
        """New room for compiled functions, with the numbers of the cycle in it."""
        return closure_kernels().room_for(self.row, self.order, self.kinds, self.size, self.supplied)

    def times(self, unknowns: Array, delays: Array) -> Array:
        blows = np.append(unknowns, 0.0)  # that at time 0 is the last one
        told = zip(self.timings, delays.tolist(), strict=True)
        return np.array([blows[one.source] + later - one.wrapped * unknowns[-1] for one, later in told])

    def parts(self, state: Array) -> tuple[Array, float]:
        """Displacements and velocities, (N + 1, 2), and the pressure of a state; 1 for a constant pressure."""
        return (state[:-1].reshape(self.size, 2), float(state[-1])) if self.supplied else (state, 1.0)

    def after(self, number: int, state: Array) -> Array:
        """The state just after an event, from that before it."""
        bar, pressure = self.parts(state)
        if self.supplied:
            bar = self._turned(number) @ bar
        if self.timings[number].blow:
            bar = bar * self.turn * (not self.timings[number].lies)
        return np.append(bar, pressure) if self.supplied else bar

    def _turned(self, number: int) -> Array:
        """From the coordinates of a flight to those of the next one."""
        one, other = self.flows[number].modes.mixing, self.flows[(number + 1) % len(self.flows)].modes.mixing
        return np.eye(self.size) if one is other else other.T @ one

    def closed(self, unknowns: Array) -> Closed:
        """The motion that begins at the wall, and closes in all but the position of the first coordinate.

        Raises
        ------
        LinAlgError
            Where there is none.
        """
        return self._solved(np.array(unknowns), 0)

    def _solved(self, unknowns: Array, steps: int) -> Closed:
        room = self.room
        if not closure_kernels().solved(room, unknowns, steps, _NO_MAP):
            raise np.linalg.LinAlgError("no motion with these times closes")
        states = list(room.states)
        if self.supplied:
            states = [np.append(state, load) for state, load in zip(states, room.loads, strict=True)]
        return Closed(states[-1], states[:-1], room.error, room.slope, room.delays)

    def root(self, unknowns: Array) -> tuple[Array, Closed] | None:
        """The times at which everything closes, by Newton's method with steps that keep the order of events."""
        x = np.array(unknowns)
        try:
            return x, self._solved(x, _STEPS)
        except np.linalg.LinAlgError:
            return None

    def slope(self, unknowns: Array) -> Array:
        """The map of (displacements and velocities, times of wrapped events) after the blow, one cycle on."""
        size = 2 * self.size + self.supplied + self.wrapped
        found = np.empty((size, size))
        closure_kernels().solved(self.room, np.array(unknowns), 0, found)
        return found
