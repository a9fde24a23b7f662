"""From rest to rest: the map of a structure of several modes, which move on while the wall holds its contact.

A rest begins with all modes still, in a shape whose contact is at the wall, at some time: N numbers. The held structure
moves on until the force of the wall would turn to a pull, is let go with the velocities that it has then, and flies and
strikes until it comes to rest again. A cycle is a fixed point of that map; its derivative is carried along, through the
saltation at every impact, and tells the multipliers. Of one mode the map forgets all it is given.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from percuss.mechanics.flow import propagator
from percuss.mechanics.held_structure import HeldMotion, HeldStructure, Modal, held_structure
from percuss.model.checks import Array
from percuss.steady.resting.flight_chain import ForcedResponse, GapState, RestPath, RestSearch, first_contact
from percuss.steady.trigonometric import TURN

# ---- From a rest until the wall lets go


class Lying(NamedTuple):
    """When a structure comes to rest, in rad of the load, and the q_n in which it does."""

    time: float
    shape: Array


def begins(held: HeldStructure, lying: Lying) -> tuple[float, int, Modal]:
    """Phase, step of the load and state with which the wall begins to hold a structure."""
    state = lying.shape, np.zeros_like(lying.shape)
    if not held.system.load.is_piecewise:
        return lying.time, 0, state
    _, phase, piece = held.system.load.on_steps(lying.time)
    return float(phase), int(piece), state


@dataclass(frozen=True)
class _Pull:
    """With how much force the wall would pull, as `first_contact` asks a flight how far it is from the wall."""

    motion: HeldMotion

    def gap(self, t: Array) -> tuple[Array, Array]:
        force, rate = self.motion.force(t)
        return -force, -rate

    def gap_at(self, t: float) -> tuple[float, float]:
        force, rate = self.gap(np.array([t]))
        return float(force[0]), float(rate[0])

    @cached_property
    def start(self) -> GapState:
        return GapState(*self.gap_at(0.0), 0.0, np.empty(0), np.empty(0))

    @cached_property
    def bend(self) -> float:
        """Bound of its second derivative."""
        motion, (k, _) = self.motion, self.motion.held.waves
        return float(k**2 @ np.abs(motion.waves) + np.abs(motion.held.free[0]) ** 2 @ np.abs(motion.fading))

    @property
    def acceleration(self) -> float:
        return self.bend

    jerks = (0.0, 0.0)


def _let_go(held: HeldStructure, lying: Lying, stop: float) -> tuple[float, GapState] | None:
    """When the wall lets go, and the motion then; None where it does not before the stop."""
    for begin, length, _, motion in held.legs(*begins(held, lying)):
        pull, end = _Pull(motion), min(length, stop - lying.time - begin)
        found = first_contact(pull, 0.0, end) if pull.start.gap < 0.0 else None
        if found is not None or pull.start.gap >= 0.0:
            wait = 0.0 if found is None else found.time
            place, rate = motion.at(np.array([wait]))
            return lying.time + begin + wait, GapState(0.0, 0.0, 0.0, place[:, 0], rate[:, 0])
        if end < length:
            break
    return None


# ---- … and from there to the next rest, with the derivative


@dataclass(frozen=True)
class RestToRest:
    """The way of a structure from a rest to the next one."""

    held: HeldStructure
    begin: Lying
    path: RestPath
    search: RestSearch

    @property
    def end(self) -> Lying:
        """The next rest."""
        assert self.path.rest is not None
        return Lying(self.path.rest, self.path.shape)

    @cached_property
    def derivative(self) -> Array:
        """Of the next rest by the one before, in coordinates across the contact and time; shape (N, N)."""
        # At fixed times differences move freely, of the held structure and of the one that flies; where the force of
        # the wall vanishes one passes into the other, as both have the same accelerations there. `end` is what they
        # move the contact by, which is lost beside what they move the modes by when flights are short.
        held, path, (root, _, across) = self.held, self.path, self.held.basis
        n, known, load = root.size, held.known, held.system.load
        late = np.append(np.zeros(n - 1), 1.0)
        place = np.column_stack([across / root[:, None], np.zeros(n)])
        # as it lies down the modes begin to move with what the load and their springs do beside the force of the wall
        pushes = known.gamma * float(load.value(self.begin.time)) - known.omega**2 * self.begin.shape
        rate = -np.outer(pushes - pushes.sum() / known.inertia / (1.0 / known.inertia).sum(), late)
        exponents, forth, back = held.exponents
        amounts = np.einsum("hni,nic->hc", forth, np.stack([place, rate], axis=1))
        amounts *= np.exp(exponents * (path.release - self.begin.time))[:, None]
        place, rate = np.einsum("nih,hc->inc", back, amounts).real
        end, left = np.zeros(n), 0.0
        flights = [*self.search.flown, (self.search.leg, 0.0, False)]
        for (leg, duration, struck), (after, *_) in pairwise(flights):
            half, step = 0.5 * known.damping, propagator(known.omega, known.damping, duration)
            less = (np.expm1(-half * duration) - step.versine + half * step.b)[:, None]  # a − 1
            moved = less * place + step.b[:, None] * rate
            place, rate = place + moved, step.c[:, None] * place + step.e[:, None] * rate
            end = end + moved.sum(axis=0)
            if struck:
                factor, out = self.search.law.velocity_factor, after.start.velocity
                into = leg.at(duration).velocity
                late = -end / into.sum()
                place = place + np.outer(into, late)
                rate = factor * (rate + np.outer(after.accelerations + known.damping * (out - into), late))
                last = place, rate
                place, rate = place - np.outer(out, late), rate - np.outer(after.accelerations, late)
                end = -out.sum() * late
        place, rate = last
        leg, factor = self.search.leg, self.search.law.velocity_factor
        if self.end.time != leg.time:
            push, left = leg.at_rest[1], self.end.time - leg.time
            grows = known.gamma.sum() * float(load.derivative(leg.time)) * late - known.omega**2 @ place
            late = late - 2.0 * rate.sum(axis=0) / ((1.0 + factor) * push) - left * grows / push
        return np.vstack([across.T @ (root[:, None] * place), late])


def next_rest(swing: ForcedResponse, lying: Lying, stop: float) -> RestToRest | None:
    """The way to the next rest, or as far as the stop; None where the wall does not let go before."""
    held = held_structure(swing.system, swing.modes)
    released = _let_go(held, lying, stop)
    if released is None:
        return None
    search = RestSearch(swing, released[0], stop, released[1])
    return RestToRest(held, lying, search.chain(), search)


def ways_from(swing: ForcedResponse, lying: Lying, rests: int, periods: int) -> list[RestToRest]:
    """The ways of so many rests, or as far as so many load periods and one more."""
    found: list[RestToRest] = []
    while len(found) < rests and (not found or found[-1].path.rest is not None):
        way = next_rest(swing, found[-1].end if found else lying, lying.time + TURN * (periods + 1))
        if way is None:
            break
        found.append(way)
    return found


# ---- Fixed points of it

_STEPS, _HALVINGS = 10, 3
_CLOSE = 3e-13  # of the shape, and rad: where Newton's method ends


class FixedRests(NamedTuple):
    """The ways of a cycle from rest to rest."""

    ways: tuple[RestToRest, ...]

    @property
    def matrix(self) -> Array:
        """Of the last rest by the first; shape (N, N)."""
        found = self.ways[0].derivative
        for way in self.ways[1:]:
            found = way.derivative @ found
        return found


def closed_near(swing: ForcedResponse, lying: Lying, rests: int, periods: int) -> FixedRests | None:
    """The cycle of so many rests and load periods to which Newton's method comes from a rest near one of it."""
    root, _, across = held_structure(swing.system, swing.modes).basis
    scale = max(float(np.abs(root * lying.shape).max()), 1e-300)

    def off(lying: Lying) -> tuple[Array, list[RestToRest]]:
        ways = ways_from(swing, lying, rests, periods)
        if len(ways) < rests or ways[-1].path.rest is None:
            return np.full(root.size, np.inf), ways
        here = ways[-1].end
        shape = across.T @ (root * (here.shape - lying.shape)) / scale
        return np.append(shape, here.time - lying.time - TURN * periods), ways

    beside, ways = off(lying)
    for _ in range(_STEPS):
        if not np.all(np.isfinite(beside)):
            return None
        unit = np.append(np.full(root.size - 1, scale), 1.0)
        try:
            step = np.linalg.solve(np.eye(root.size) - FixedRests(tuple(ways)).matrix, unit * beside)
        except np.linalg.LinAlgError:
            return None
        size, share = float(np.abs(step / unit).max()), 1.0
        for _ in range(_HALVINGS):
            there = Lying(lying.time + share * step[-1], lying.shape + share * (across @ step[:-1]) / root)
            now, new = off(there)
            if size < 1e-9 or float(np.abs(now).max()) < float(np.abs(beside).max()):
                break
            share *= 0.5
        else:
            return None
        lying, beside, ways = there, now, new
        if size <= _CLOSE or (size < 1e-9 and float(np.abs(now).max()) <= _CLOSE):
            return FixedRests(tuple(ways)) if np.all(np.isfinite(beside)) else None
    return None
