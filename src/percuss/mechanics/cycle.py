"""A cycle: flights and events in an order that repeats, told by the times of its guarded events alone.

Between events the coordinates are free of each other, and every one goes through the cycle by one affine map of its
own, (u, v) → M (u, v) + c. So the state after the blow that begins a cycle follows from the times of the events, by one
2×2 solve for each coordinate, and what is left to solve for are these times: of as many as there are guards met, and of
the blow that ends the cycle, whatever the number of coordinates. A rigid body has one.

With a supply each state of the valve has coordinates of its own, and the pressure is one number more: the map is one of
all of them together, with a projection at each change of the state, and so is the solve. The times are the unknowns
there, too.

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
from typing import NamedTuple

import numpy as np

from percuss.mechanics.flow import StateFlow, response_of
from percuss.model.checks import Array

# ---- The linearised motion through events: flows, and one saltation matrix at each of them
#
# A state is of shape (n, 2), displacement and velocity of every coordinate, where each moves by itself: matrices are of
# shape (n, 2, 2) then, or (2, 2) for all. Or it is one row of all numbers, and matrices are matrices.


class CycleStep(NamedTuple):
    """A flight and the event at its end.

    `flow` is the matrix of the flight, `turn` that of the event; `before` and `after` are the rates of the state on the
    two sides of the event.
    """

    flow: Array
    before: Array
    after: Array
    turn: Array


def linearised(
    events: Iterable[CycleStep], now: Array, later: Callable[[int, Array, Array], Array]
) -> tuple[Array, list[Array]]:
    """The disturbances after the last event, a state with C columns, and those just before each event, wherever it is.

    They are `now` before the first flight. `later` tells how much later an event is, shape (C,): of its number, the
    disturbances there at fixed times, and the rate.
    """
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


def _moved(matrix: Array, state: Array) -> Array:
    return np.asarray((matrix @ state[..., None])[..., 0])


# ---- The cycle through given times: what it must satisfy to repeat, and its derivatives
#
# Derivatives are those of the state at the event, which moves in time with it: an impact is then diag(α, β) of its law,
# and a jump of the force shows only in the accelerations on its two sides.

_STEPS = 30
_CLOSED = 2e-14  # of the period
_NEARLY, _SUPPLIED = 1e-11, 1e-9  # … where rounding lets no step be smaller, as where a pressure settles slowly
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

    `start` is the state just after the blow at time 0, and `states` those just before each event; `error` is of the
    guards; `slope` are its derivatives by the unknown times. See `Cycle.parts` for what a state is.
    """

    start: Array
    states: list[Array]
    error: Array
    slope: Array


class Cycle:
    """The events of a cycle in a fixed order, the last one the blow that ends it.

    `turn` is what a blow multiplies displacements and velocities by; `flows` are those of each flight; guards are met
    where `rows` · states = `levels`, in the coordinates of the flight before; rows are of shape (N + 1, 2).
    """

    def __init__(
        self, flows: Sequence[StateFlow], turn: Array, timings: Sequence[Timing], rows: Sequence[Array], levels: Array
    ) -> None:
        self.flows, self.turn, self.timings, self.levels = flows, turn, timings, levels
        self.guards = [i for i, one in enumerate(timings) if one.guarded]
        unit, none = np.eye(len(self.guards)), np.zeros(len(self.guards))
        self.by = np.array([(none if t.source < 0 else unit[t.source]) - t.wrapped * unit[-1] for t in timings])
        self.later = np.array([one.later for one in timings])
        self.size = flows[0].modes.omega.size
        self.supplied = flows[0].compliance < np.inf
        self.rows = [np.append(row, 0.0) for row in rows] if self.supplied else rows
        self.events = [self._event(i) for i in range(len(timings))]

    def times(self, unknowns: Array) -> Array:
        """When the events are."""
        return np.asarray(self.by @ unknowns + self.later)

    def parts(self, state: Array) -> tuple[Array, float]:
        """Displacements and velocities, (N + 1, 2), and the pressure of a state; 1 for a constant pressure."""
        return (state[:-1].reshape(self.size, 2), float(state[-1])) if self.supplied else (state, 1.0)

    def after(self, number: int, state: Array) -> Array:
        """The state just after an event, from that before it."""
        return _moved(self.events[number], state)

    def _event(self, i: int) -> Array:
        """The matrix of an event: the law of a blow, or the projection on the coordinates of another state."""
        law = np.diag(self.turn if self.timings[i].blow else np.ones(2))
        if not self.supplied:
            return law
        one, other = self.flows[i].modes.mixing, self.flows[(i + 1) % len(self.flows)].modes.mixing
        whole = np.eye(2 * self.size + 1)
        whole[:-1, :-1] = np.kron(np.eye(self.size) if one is other else other.T @ one, law)
        return whole

    def _flights(self, unknowns: Array) -> list[tuple[Array, Array]]:
        """The matrix of each flight, and where it takes the state 0."""
        spans, found = np.diff(self.times(unknowns), prepend=0.0), {}
        kinds = {id(flow): flow for flow in self.flows}
        for kind, flow in kinds.items():
            mine = [i for i, one in enumerate(self.flows) if id(one) == kind]
            maps = flow.maps(response_of(flow.modes, spans[mine]))
            for k, i in enumerate(mine):
                matrices, pushed, fixed = (one[..., k] for one in maps)
                found[i] = matrices, fixed
                if self.supplied:
                    found[i] = self._with_pressure(flow, matrices, pushed.reshape(-1), fixed, float(spans[i]))
        return [found[i] for i in range(len(self.flows))]

    def _with_pressure(
        self, flow: StateFlow, matrices: Array, pushed: Array, fixed: Array, time: float
    ) -> tuple[Array, Array]:
        """The flight of all coordinates together, and of the pressure, which moves them and follows them."""
        size, c, driven = 2 * self.size, flow.compliance, np.zeros(2 * self.size)
        driven[::2] = flow.modes.driven
        whole, offset = np.zeros((size + 1, size + 1)), np.append(fixed.reshape(-1), 0.0)
        for n, matrix in enumerate(matrices):
            whole[2 * n : 2 * n + 2, 2 * n : 2 * n + 2] = matrix
        whole[:-1, :-1] += np.outer(pushed, flow.spring * driven)
        whole[:-1, -1] = flow.draw * pushed
        whole[-1] = -flow.draw / c * (driven @ whole[:-1])
        whole[-1, :-1] += flow.draw / c * driven
        whole[-1, -1] += 1.0
        offset[-1] = (flow.supplied * time - flow.draw * float(driven @ offset[:-1])) / c
        return whole, offset

    def _rates(self, i: int, state: Array) -> Array:
        """Of a state in a flight."""
        whole, pressure = self.parts(state)
        rates, rise = self.flows[i % len(self.flows)].rates(whole, pressure)
        return np.append(rates.reshape(-1), rise) if self.supplied else rates

    def _steps(self, states: list[Array], flights: list[tuple[Array, Array]]) -> list[CycleStep]:
        """Flights and events of a motion whose states just before the events are given."""
        found = []
        for i, (state, (flow, _), turn) in enumerate(zip(states, flights, self.events, strict=True)):
            after = self._rates(i + 1, self.after(i, state))
            found.append(CycleStep(flow, self._rates(i, state), after, turn))
        return found

    def closed(self, unknowns: Array) -> Closed:
        """The motion that begins at the wall, and closes in all but the position of the first coordinate."""
        flights = self._flights(unknowns)
        now, fixed = np.eye(2 * self.size + 1), np.zeros(2 * self.size + 1)
        if not self.supplied:
            now, fixed = np.array(np.broadcast_to(np.eye(2), (self.size, 2, 2))), np.zeros((self.size, 2))
        maps, offsets = [], []
        for (flow, offset), turn in zip(flights, self.events, strict=True):
            now, fixed = flow @ now, _moved(flow, fixed) + offset
            maps.append(now)
            offsets.append(fixed)
            now, fixed = turn @ now, _moved(turn, fixed)
        solve = self._closing(maps[-1])
        start = solve(offsets[-1][..., None])[..., 0]
        states = [_moved(one, start) + c for one, c in zip(maps, offsets, strict=True)]
        still = np.zeros((*start.shape, unknowns.size))
        _, moves = linearised(self._steps(states, flights), still, lambda i, *_: self.by[i])
        change = solve(moves[-1])
        moves = [one @ change + own for one, own in zip(maps, moves, strict=True)]
        inner = self.guards[:-1]
        error = [float(read(self.rows[i], states[i])) - self.levels[i] for i in inner]
        slope = [read(self.rows[i], moves[i]) for i in inner]
        error.append(float(read(self.rows[-1], states[-1])) - self.levels[-1])
        slope.append(read(self.rows[-1], moves[-1]))
        return Closed(start, states, np.array(error), np.array(slope))

    def _closing(self, whole: Array) -> Callable[[Array], Array]:
        """Solves (I − D M) x = D c for the map M of the cycle; in place of the first line, the beginning at the wall.

        Were it the end, a chamber would make this singular where it turns the cycle by a certain angle.
        """
        turn, row = self.events[-1], self.rows[-1]
        if self.supplied:
            matrix = np.eye(row.size) - turn @ whole
            matrix[0] = np.append(np.stack([self.flows[0].modes.end, 0.0 * self.flows[0].modes.end], axis=1), 0.0)

            def together(c: Array) -> Array:
                """For the columns of c, shape (2N + 3, C)."""
                right = turn @ c
                right[0] = 0.0
                return np.asarray(np.linalg.solve(matrix, right), dtype=float)

            return together
        end, beta = row[:, 0], self.turn[1]
        elastic = np.eye(2) - turn @ whole[1:]
        first = np.array([[end[0], 0.0], np.array([0.0, 1.0]) - beta * whole[0, 1]])

        def apart(c: Array) -> Array:
            """For the columns of c, shape (N + 1, 2, C)."""
            rest = np.linalg.solve(elastic, turn @ c[1:])
            own = np.linalg.solve(first, np.array([-(end[1:] @ rest[:, 0]), beta * c[0, 1]]))
            return np.concatenate([own[None], rest])

        return apart

    def root(self, unknowns: Array) -> tuple[Array, Closed] | None:
        """The times at which everything closes, by Newton's method with steps that keep the order of events."""
        try:
            with np.errstate(over="raise", divide="raise", invalid="raise"):  # of times that are far off
                motion = self.closed(unknowns)
                smallest, nearly = np.inf, _SUPPLIED if self.supplied else _NEARLY
                for _ in range(_STEPS):
                    step = np.linalg.solve(motion.slope, -motion.error)
                    size = float(np.abs(step).max() / unknowns[-1])
                    if not np.isfinite(size):
                        return None
                    if size <= _CLOSED or (smallest <= nearly and size >= 0.5 * smallest):
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
        size = motion.start.size
        unit: Array = np.eye(size + len(wrapped))
        dues: dict[int, Array] = dict(zip(wrapped, unit[size:], strict=True))
        shifts: list[Array] = [0.0 * unit[0]]  # of the blow at time 0, then of each guarded event

        def later(i: int, now: Array, rate: Array) -> Array:
            one = self.timings[i]
            if not one.guarded:
                return dues[i] if one.wrapped else shifts[one.source + 1]
            shifts.append(guarded(self.rows[i], now, rate))
            return shifts[-1]

        steps = self._steps(motion.states, self._flights(unknowns))
        _, seen = linearised(steps, unit[:size].reshape(*motion.start.shape, len(unit)), later)
        after = [shifts[self.timings[i].source + 1] - shifts[-1] for i in wrapped]
        return np.asarray(np.vstack([(self.events[-1] @ seen[-1]).reshape(size, -1), *after]))
