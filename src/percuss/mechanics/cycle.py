"""A cycle: flights and events in an order that repeats, told by the times of its guarded events alone.

Between events the coordinates are free of each other, and every one goes through the cycle by one affine map of its
own, (u, v) → M (u, v) + c. So the state after the blow that begins a cycle follows from the times of the events, by one
2×2 solve for each coordinate, and what is left to solve for are these times: of as many as there are guards met, and of
the blow that ends the cycle, whatever the number of coordinates. A rigid body has one.

Disturbances are columns, of displacement and velocity of every coordinate at fixed times. An event of a motion that is
disturbed comes later by δt: with the rates F⁻ and F⁺ on its two sides, and D = diag(α, β) at a blow, else 1,

    x ↦ D (x + F⁻ δt) − F⁺ δt,

which with δt = −g·x/(g·F⁻) for a guard g is the saltation matrix D + (F⁺ − D F⁻) gᵀ/(gᵀF⁻) (Leine & Nijmeijer,
Dynamics and Bifurcations of Non-Smooth Mechanical Systems, 2004, ch. 7). The event at a time that another event fixes
is as much later as that one.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import NamedTuple

import numpy as np

from percuss.mechanics.flow import propagated, rates, response_of
from percuss.model import MachineModes
from percuss.model.checks import Array

# ---- The linearised motion through events: flows, and one saltation matrix at each of them


class CycleStep(NamedTuple):
    """A flight and the event at its end, of n coordinates.

    `flow` is the flight's map of displacement and velocity, shape (n, 2, 2); `before` and `after` are velocity and
    acceleration on the two sides of the event, (n, 2); by `turn`, (2,), it multiplies displacements and velocities.
    """

    flow: Array
    before: Array
    after: Array
    turn: Array


def linearised(
    events: Iterable[CycleStep], now: Array, later: Callable[[int, Array, Array], Array]
) -> tuple[Array, list[Array]]:
    """The disturbances after the last event, shape (n, 2, C), and in the state just before each event, wherever it is.

    They are `now` before the first flight. `later` tells how much later an event is, shape (C,): of its number, the
    disturbances there at fixed times, and the rate.
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


# ---- The cycle through given times: what it must satisfy to repeat, and its derivatives
#
# Derivatives are those of the state at the event, which moves in time with it: an impact is then diag(α, β) of its law,
# and a jump of the force shows only in the accelerations on its two sides.

_STEPS = 30
_CLOSED = 2e-14  # of the period
_NEARLY = 1e-11  # … where rounding lets no step be smaller
_HALVINGS = 5
_OUT_OF_ORDER = 0.02  # of the period, on the way to the solution


class Timing(NamedTuple):
    """When an event of a cycle is: `later` than that with the number `source` among those whose times are unknown.

    It is its own source, 0 later, where it is guarded; −1 is the blow at time 0. `wrapped`: its source is that of the
    cycle before.
    """

    source: int
    later: float
    wrapped: bool
    guarded: bool
    blow: bool


class Closed(NamedTuple):
    """The motion that belongs to given times of the events, and how far it is from what it should be.

    `start` is the state just after the blow at time 0, shape (N + 1, 2), and `states` those just before each event,
    (events, N + 1, 2); `error` is of the guards, and of the first coordinate's place after the cycle, in place of that
    of the last blow; `slope` are its derivatives by the unknown times.
    """

    start: Array
    states: Array
    error: Array
    slope: Array


class Cycle:
    """The events of a cycle in a fixed order, the last one the blow that ends it.

    `turn` is what a blow multiplies displacements and velocities by; `forces` act in each flight; guards are met where
    `rows` · displacements = `levels`.
    """

    def __init__(
        self,
        modes: MachineModes,
        turn: Array,
        forces: list[float],
        timings: Sequence[Timing],
        rows: Array,
        levels: Array,
    ) -> None:
        self.modes, self.turn, self.forces, self.timings, self.rows, self.levels = (
            modes, turn, forces, timings, rows, levels,
        )  # fmt: skip
        self.guards = [i for i, one in enumerate(timings) if one.guarded]
        unit, none = np.eye(len(self.guards)), np.zeros(len(self.guards))
        self.by = np.array([(none if t.source < 0 else unit[t.source]) - t.wrapped * unit[-1] for t in timings])
        self.later = np.array([one.later for one in timings])

    def times(self, unknowns: Array) -> Array:
        """When the events are."""
        return np.asarray(self.by @ unknowns + self.later)

    def turns(self, number: int) -> bool:
        """Whether an event is a blow before the last one."""
        return self.timings[number].blow and number < len(self.timings) - 1

    def _responses(self, unknowns: Array) -> list[tuple[Array, Array, Array]]:
        """Those of the coordinates from each event to the next one."""
        ds, s, q = response_of(self.modes, np.diff(self.times(unknowns), prepend=0.0))
        return list(zip(ds.T, s.T, q.T, strict=True))

    def _events(self, states: Array, responses: list[tuple[Array, Array, Array]]) -> list[CycleStep]:
        """Flights and events of a motion whose states just before the events are given."""
        square, found, kept = self.modes.omega**2, [], np.ones(2)
        for i, (state, (ds, s, q)) in enumerate(zip(states, responses, strict=True)):
            flow = np.stack([1.0 - square * q, s, -square * s, ds], axis=-1).reshape(-1, 2, 2)
            turn = self.turn if self.timings[i].blow else kept
            after = rates(self.modes, turn * state, self.forces[(i + 1) % len(self.forces)])
            found.append(CycleStep(flow, rates(self.modes, state, self.forces[i]), after, turn))
        return found

    def closed(self, unknowns: Array) -> Closed:
        """The motion that closes in all but the position of the first coordinate, and strikes at the end."""
        size, m = self.modes.omega.size, unknowns.size
        responses = self._responses(unknowns)
        now, fixed = np.array(np.broadcast_to(np.eye(2), (size, 2, 2))), np.zeros((size, 2))
        maps, offsets = [], []
        for i, (force, response) in enumerate(zip(self.forces, responses, strict=True)):
            now, fixed = propagated(self.modes, now, 0.0, response), propagated(self.modes, fixed, force, response)
            maps.append(now)
            offsets.append(fixed)
            if self.turns(i):
                now, fixed = self.turn[:, None] * now, self.turn * fixed
        solve = self._closing(now)
        start = solve(fixed[:, :, None])[:, :, 0]
        states = np.array([np.einsum("nij,nj->ni", one, start) + c for one, c in zip(maps, offsets, strict=True)])
        _, moves = linearised(self._events(states, responses), np.zeros((size, 2, m)), lambda i, *_: self.by[i])
        change = solve(moves[-1])
        inner = self.guards[:-1]
        error = [float(self.rows[i] @ states[i][:, 0]) - self.levels[i] for i in inner]
        slope = [self.rows[i] @ (np.einsum("nj,njk->nk", maps[i][:, 0], change) + moves[i][:, 0]) for i in inner]
        error.append(float(start[0, 0] - self.turn[0] * states[-1][0, 0]))
        slope.append(change[0, 0] - self.turn[0] * (maps[-1][0, 0] @ change[0] + moves[-1][0, 0]))
        return Closed(start, states, np.array(error), np.array(slope))

    def _closing(self, maps: Array) -> Callable[[Array], Array]:
        """Solves (I − D M_n) x_n = D c_n for every coordinate, the blow's guard in place of the first line."""
        turn, end = self.turn, self.rows[-1]
        elastic = np.eye(2) - turn[:, None] * maps[1:]
        first = np.array([end[0] * maps[0, 0], np.array([0.0, 1.0]) - turn[1] * maps[0, 1]])

        def solved(c: Array) -> Array:
            """For the columns of c, shape (N + 1, 2, C)."""
            rest = np.linalg.solve(elastic, turn[:, None] * c[1:])
            beside = np.einsum("n,nj,njk->k", end[1:], maps[1:, 0], rest) + end[1:] @ c[1:, 0]
            own = np.linalg.solve(first, np.array([-beside - end[0] * c[0, 0], turn[1] * c[0, 1]]))
            return np.concatenate([own[None], rest])

        return solved

    def root(self, unknowns: Array) -> tuple[Array, Closed] | None:
        """The times at which everything closes, by Newton's method with steps that keep the order of events."""
        try:
            with np.errstate(over="raise", divide="raise", invalid="raise"):  # of times that are far off
                motion = self.closed(unknowns)
                smallest = np.inf
                for _ in range(_STEPS):
                    step = np.linalg.solve(motion.slope, -motion.error)
                    size = float(np.abs(step).max() / unknowns[-1])
                    if not np.isfinite(size):
                        return None
                    if size <= _CLOSED or (smallest <= _NEARLY and size >= 0.5 * smallest):
                        return unknowns + step, self.closed(unknowns + step)
                    smallest = min(smallest, size)
                    for _ in range(_HALVINGS):
                        after = unknowns + step
                        if after[-1] > 0.0 and np.all(np.diff(self.times(after)) > -_OUT_OF_ORDER * after[-1]):
                            break
                        step = 0.5 * step
                    else:
                        return None
                    unknowns = unknowns + step
                    motion = self.closed(unknowns)
        except (np.linalg.LinAlgError, FloatingPointError):
            return None
        return None

    def slope(self, unknowns: Array, motion: Closed) -> Array:
        """The map of (displacements and velocities, times of wrapped events) after the blow, one cycle on.

        On the blow as a section the shift in time is no disturbance.
        """
        wrapped = [i for i, one in enumerate(self.timings) if one.wrapped]
        size = 2 * self.modes.omega.size
        unit: Array = np.eye(size + len(wrapped))
        dues: dict[int, Array] = dict(zip(wrapped, unit[size:], strict=True))
        shifts: list[Array] = [0.0 * unit[0]]  # of the blow at time 0, then of each guarded event

        def later(i: int, now: Array, rate: Array) -> Array:
            one = self.timings[i]
            if not one.guarded:
                return dues[i] if one.wrapped else shifts[one.source + 1]
            shifts.append(guarded(self.rows[i], now, rate))
            return shifts[-1]

        events = self._events(motion.states, self._responses(unknowns))
        _, seen = linearised(events, unit[:size].reshape(-1, 2, len(unit)), later)
        after = [shifts[self.timings[i].source + 1] - shifts[-1] for i in wrapped]
        return np.asarray(np.vstack([(self.turn[:, None] * seen[-1]).reshape(size, -1), *after]))
