"""The way of an elastic machine through a given order of events: what it must satisfy to repeat, and its derivatives.

Under a force that is constant between known times every coordinate goes through the cycle by one affine map of its own,
(u, v) → M (u, v) + c. So the state after the blow follows from the times of the events, and what is left to solve for
are these times: as many as there are ports passed and blows, whatever N (theory, "The machine that switches itself").
Derivatives are those of the state at the event, which moves in time with it: an impact is then diag(α, β) of its law,
and a jump of the force shows only in the accelerations on its two sides.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from percuss.model import Machine, MachineModes
from percuss.model.checks import Array
from percuss.steady.self_excited.modal_flight import propagated, rates, response_of
from percuss.steady.self_excited.rhythm import Step

__all__ = ["Chain", "Closed", "place_row"]


def place_row(machine: Machine, modes: MachineModes, place: str | float) -> Array:
    """What each coordinate moves a place of the body by, "centre" or 0 to 1."""
    return modes.centre if isinstance(place, str) else modes.at(machine.body, np.array([place]))[0]


@dataclass(frozen=True)
class Closed:
    """The motion that belongs to given times of the events, and how far it is from what it should be.

    Parameters
    ----------
    start
        Displacements and velocities of the coordinates just after the blow at time 0; shape (N + 1, 2).
    states
        … and just before each event; shape (steps, N + 1, 2).
    error
        Of the passages and of the blows before the last one, and of the first coordinate's position after the cycle.
    slope
        Its derivatives by the unknown times.
    """

    start: Array
    states: Array
    error: Array
    slope: Array


class Chain:
    """The events of a cycle in a fixed order.

    Parameters
    ----------
    machine, count
        The machine, and N.
    steps
        The events; the last one is the blow that ends the cycle.
    state, last
        Of the valve just after the blow at time 0, and what was demanded last.
    """

    def __init__(self, machine: Machine, count: int, steps: tuple[Step, ...], state: str, last: str) -> None:
        self.machine, self.modes, self.steps = machine, machine.modes(count), steps
        self.unknowns = sum(step.kind != "due" for step in steps)
        contact = machine.contact
        self.turn = np.array([contact.strain_factor, contact.velocity_factor])
        self.by = np.array([self._by(step) for step in steps])
        self.shift = np.array([step.later for step in steps])
        self.rows = np.array([self._row(step) for step in steps])
        self.levels = np.array([self._level(step) for step in steps])
        self.states = [state, *(step.state for step in steps[:-1])]
        self.lasts = [last, *(step.last for step in steps[:-1])]
        self.forces = [machine.valve.force(name) for name in self.states]

    def _by(self, step: Step) -> Array:
        by = np.zeros(self.unknowns)
        if step.source >= 0:
            by[step.source] += 1.0
        if step.wrapped:
            by[-1] -= 1.0
        return by

    def _row(self, step: Step) -> Array:
        if step.kind == "port":
            return place_row(self.machine, self.modes, self.machine.valve.ports[step.port].reads)
        return self.modes.end if step.kind == "blow" else 0.0 * self.modes.end

    def _level(self, step: Step) -> float:
        behind = self.machine.valve.ports[step.port].behind if step.kind == "port" else None
        return -(behind or 0.0)

    def sign(self, step: Step) -> float:
        """Whether the wall or the edge of a port is met on the way to the wall, 1, or away from it, −1."""
        return -1.0 if step.kind == "port" and self.machine.valve.ports[step.port].side == "back" else 1.0

    def times(self, unknowns: Array) -> Array:
        """When the events are."""
        return np.asarray(self.by @ unknowns + self.shift)

    def ways(self, times: Array) -> list[tuple[Array, Array, Array]]:
        """The responses of the coordinates from each event to the next one."""
        ds, s, q = response_of(self.modes, np.diff(times))
        return list(zip(ds.T, s.T, q.T, strict=True))

    def turns(self, number: int) -> bool:
        """Whether an event is a blow before the last one."""
        return self.steps[number].kind == "blow" and number < len(self.steps) - 1

    def closed(self, unknowns: Array) -> Closed:
        """The motion that closes in all but the position of the first coordinate, and strikes at the end."""
        size, m = self.modes.omega.size, self.unknowns
        times = np.concatenate([[0.0], self.times(unknowns)])
        by = np.vstack([np.zeros(m), self.by])
        ways = self.ways(times)
        now, fixed = np.array(np.broadcast_to(np.eye(2), (size, 2, 2))), np.zeros((size, 2))
        maps, offsets = [], []
        for i, force in enumerate(self.forces):
            now, fixed = propagated(self.modes, now, 0.0, ways[i]), propagated(self.modes, fixed, force, ways[i])
            maps.append(now)
            offsets.append(fixed)
            if self.turns(i):
                now, fixed = self.turn[:, None] * now, self.turn * fixed
        solve = _closing(self.modes.end, self.turn, now)
        start = solve(fixed[:, :, None])[:, :, 0]
        states = np.array([_applied(one, start) + rest for one, rest in zip(maps, offsets, strict=True)])
        moved, moves = np.zeros((size, 2, m)), []
        for i, force in enumerate(self.forces):
            moved = propagated(self.modes, moved, 0.0, ways[i])
            moved = moved + rates(self.modes, states[i], force)[:, :, None] * (by[i + 1] - by[i])
            moves.append(moved)
            if self.turns(i):
                moved = self.turn[:, None] * moved
        change = solve(moved)
        watched = [i for i, step in enumerate(self.steps[:-1]) if step.kind != "due"]
        error = [float(self.rows[i] @ states[i][:, 0]) - self.levels[i] for i in watched]
        slope = [self.rows[i] @ (np.einsum("nj,njk->nk", maps[i][:, 0], change) + moves[i][:, 0]) for i in watched]
        error.append(float(start[0, 0] - self.turn[0] * states[-1][0, 0]))
        slope.append(change[0, 0] - self.turn[0] * (maps[-1][0, 0] @ change[0] + moves[-1][0, 0]))
        return Closed(start, states, np.array(error), np.array(slope))


def _applied(maps: Array, state: Array) -> Array:
    return np.asarray(np.einsum("nij,nj->ni", maps, state))


def _closing(end: Array, turn: Array, maps: Array) -> Callable[[Array], Array]:
    """Solves (I − D M_n) x_n = D c_n for every coordinate, the striking end at the wall in place of the first line."""
    elastic = np.eye(2) - turn[:, None] * maps[1:]
    first = np.array([end[0] * maps[0, 0], np.array([0.0, 1.0]) - turn[1] * maps[0, 1]])

    def solved(c: Array) -> Array:
        """For the columns of c, shape (N + 1, 2, C)."""
        rest = np.linalg.solve(elastic, turn[:, None] * c[1:])
        beside = np.einsum("n,nj,njk->k", end[1:], maps[1:, 0], rest) + end[1:] @ c[1:, 0]
        own = np.linalg.solve(first, np.array([-beside - end[0] * c[0, 0], turn[1] * c[0, 1]]))
        return np.concatenate([own[None], rest])

    return solved
