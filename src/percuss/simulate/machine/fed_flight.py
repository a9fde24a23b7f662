"""The flight of a rigid piston that draws from an accumulator, and the first of several things to happen in it.

The displacement obeys u″ + d u′ + K u = f + r t with K = κ + p²/c. What is watched for, places and an empty
accumulator, are functions α + βu + γt. In a cell of time in which such a function is proved to have no turning point
the signs at its ends decide; in one in which it is proved not to come to 0 nothing happens; any other cell is halved.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from percuss.halting import look
from percuss.model import Machine
from percuss.model.checks import Array
from percuss.simulate.flight import drift
from percuss.simulate.machine.machine_flight import sway

__all__ = ["FedFlight", "Passage", "Watch", "first_passage", "flight_of"]

_SHARE = 0.5  # of the reciprocal frequency: a cell
_FINEST = 1e-14  # of a cell that is not halved any more, relative to the longest
_MOST_CELLS = 1 << 16
_EPS = 2.0**-52
_TERMS = 16


@dataclass(frozen=True)
class FedFlight:
    """The flight from a displacement u and a velocity v on.

    Parameters
    ----------
    u, v, pressure
        At its start.
    force, gas, stiffness, drag
        p of the state at the pressure 1, the chamber's force and stiffness, d.
    flow, compliance
        Of the supply.
    """

    u: float
    v: float
    pressure: float
    force: float
    gas: float
    stiffness: float
    drag: float
    flow: float
    compliance: float

    @property
    def spring(self) -> float:
        """K, of the gas and the accumulator together."""
        return self.stiffness + self.force**2 / self.compliance

    @property
    def ramp(self) -> float:
        """r, what the pump adds to the force in a unit of time."""
        return self.force * self.flow / self.compliance

    @property
    def push(self) -> float:
        """Acceleration at the start, without the drag."""
        return self.force * self.pressure + self.gas - self.stiffness * self.u

    def at(self, t: Array) -> tuple[Array, Array]:
        """Displacement and velocity at times from the start on."""
        w2, d = self.spring, self.drag
        h, integral = sway(d, math.sqrt(w2), t) if w2 > 0.0 else drift(d, t)
        twice = (t - h - d * integral) / w2 if self.ramp != 0.0 else 0.0 * t
        slope = 1.0 - d * h - w2 * integral
        u = self.u + self.v * h + self.push * integral + self.ramp * twice
        return u, self.v * slope + self.push * h + self.ramp * integral

    def at_time(self, t: float) -> tuple[float, float]:
        """The same at one time, which is what a search asks for."""
        w2, d = self.spring, self.drag
        h, integral = _answers(d, w2, t)
        twice = (t - h - d * integral) / w2 if self.ramp != 0.0 else 0.0
        u = self.u + self.v * h + self.push * integral + self.ramp * twice
        return u, self.v * (1.0 - d * h - w2 * integral) + self.push * h + self.ramp * integral

    def pressures(self, t: Array, u: Array) -> Array:
        """The pressure at times at which the displacement is u."""
        return np.asarray(self.pressure + (self.flow * t - self.force * (u - self.u)) / self.compliance)

    def pumped(self, t: float) -> float:
        """Work of the pump up to a time: flow times the integral of the pressure."""
        level = self.pressure * t + 0.5 * self.flow * t * t / self.compliance
        if self.ramp == 0.0:
            return self.flow * level
        u, v = self.at_time(t)
        way = self.push * t + 0.5 * self.ramp * t * t - (v - self.v) - self.drag * (u - self.u)
        return self.flow * (level - self.force / self.compliance * way / self.spring)

    @property
    def drifts(self) -> float:
        """The velocity of the line about which it swings."""
        return self.ramp / self.spring if self.ramp else 0.0

    def swing(self, u: float, v: float, t: float) -> tuple[float, float]:
        """Where the line is at a time, and how far from it the piston comes from then on at most."""
        if self.spring == 0.0:
            return u, math.inf
        line = (self.push + self.spring * self.u + self.ramp * t - self.drag * self.drifts) / self.spring
        return line, math.hypot(u - line, (v - self.drifts) / math.sqrt(self.spring)) * (1.0 + 1e-12)

    def push_at(self, u: float, t: float) -> float:
        """Acceleration at a time and place, without the drag."""
        return self.push - self.spring * (u - self.u) + self.ramp * t

    def most_acceleration(self, u: float, v: float, t: float, cell: float) -> float:
        """A bound of the acceleration over a cell from a time on."""
        here = self.push_at(u, t) - self.drag * v
        jerk = self.ramp - self.spring * v - self.drag * here
        if self.spring > 0.0:
            return min(math.hypot(here, jerk / math.sqrt(self.spring)), abs(here) + self._jerk(here, jerk) * cell)
        return abs(here)  # only a drag, which takes the acceleration away

    def _jerk(self, here: float, jerk: float) -> float:
        return math.hypot(jerk, math.sqrt(self.spring) * here)


class Watch(NamedTuple):
    """A function α + βu + γt, and the way in which it passes 0: +1 from below, −1 from above."""

    level: float
    of_place: float
    of_time: float
    way: float


class Passage(NamedTuple):
    """The first passage: when, and which of the functions."""

    time: float
    which: int


def flight_of(machine: Machine, state: str, u: float, v: float, pressure: float) -> FedFlight:
    """The flight of a machine's rigid piston in a state of its valve."""
    gas, supply = machine.valve.chamber, machine.valve.supply
    assert supply is not None
    force = dict(machine.valve.pairs)[state]
    return FedFlight(u, v, pressure, force, gas.force, gas.stiffness, machine.drag, supply.flow, supply.compliance)


def first_passage(flight: FedFlight, watched: Sequence[Watch], until: float, unit: float) -> Passage | None:
    """The first of the functions that passes 0 in its way, after the start and up to a time.

    Where the time is infinite, None says that none ever does, or that none does in very many swings.
    """
    longest = _SHARE / math.sqrt(flight.spring) if flight.spring > 0.0 else math.inf
    begin, cell = 0.0, min(longest, 0.25 * unit)
    for _ in range(_MOST_CELLS):
        look()
        end = min(begin + cell, until)
        found = _in_cell(flight, watched, begin, end, _FINEST * cell)
        if found is not None or end >= until:
            return found
        begin, cell = end, min(2.0 * cell, longest)
        if until == math.inf and _never(flight, watched, begin):
            return None
    return None


def _answers(d: float, w2: float, t: float) -> tuple[float, float]:
    """The answer to a unit push of a damped motion on a spring, h(0) = 0 and h'(0) = 1, and its integral.

    By the power series where little has happened, else by the closed form.
    """
    if w2 * t * t < 0.25 and d * t < 0.5:
        x, y = d * t, w2 * t * t
        before, term, h, total = 0.0, 1.0, 1.0, 0.5
        for k in range(1, _TERMS):
            before, term = term, -(x * term + y * before / k) / (k + 1.0)
            h += term
            total += term / (k + 2.0)
        return t * h, t * t * total
    if w2 == 0.0:
        h = -math.expm1(-d * t) / d
        return h, (t - h) / d
    half = 0.5 * d
    square = half * half - w2
    fade = math.exp(-half * t)
    if square <= 1e-6 * half * half:
        rate = math.sqrt(abs(square))
        turn = rate * t
        if square > 0.0:
            shape, cosine = (math.sinh(turn) / turn if turn > 1e-9 else 1.0), math.cosh(turn)
        else:
            shape, cosine = (math.sin(turn) / turn if turn > 1e-9 else 1.0), math.cos(turn)
        h = fade * t * shape
        return h, (1.0 - fade * cosine - half * h) / w2
    fast = math.sqrt(square)
    rate = w2 / (half + fast)  # the slow rate without cancellation
    h = math.exp(-rate * t) * -math.expm1(-2.0 * fast * t) / (2.0 * fast)
    return h, (-math.expm1(-rate * t) - rate * h) / w2


def _never(flight: FedFlight, watched: Sequence[Watch], time: float) -> bool:
    """Whether it is proved that none of the functions passes 0 from a time on."""
    u, v = flight.at_time(time)
    line, far = flight.swing(u, v, time)
    if flight.spring == 0.0:
        here = flight.push - flight.drag * v
        still = flight.drag > 0.0 and flight.push == 0.0
        ends = u + v / flight.drag if still else math.copysign(math.inf, v)
        going = v * flight.push >= 0.0 and (v != 0.0 or here != 0.0)
        return (going or still) and all(w.way * _value(w, ends, time) <= 0.0 for w in watched if w.of_time == 0.0)
    for w in watched:
        middle, swing = w.way * _value(w, line, time), abs(w.of_place) * far
        goes = w.way * (w.of_place * flight.drifts + w.of_time)
        if (middle + swing > 0.0 and goes <= 0.0 and middle - swing < 0.0) or (goes > 0.0 and middle <= swing):
            return False
        if goes < 0.0 and middle + swing > 0.0:
            return False
    return True


def _value(watch: Watch, u: float, t: float) -> float:
    return watch.level + watch.of_place * u + watch.of_time * t


def _in_cell(flight: FedFlight, watched: Sequence[Watch], begin: float, end: float, finest: float) -> Passage | None:
    """The first passage in a cell; halves of it wait, the later one first."""
    waiting = [(begin, end)]
    while waiting:
        a, b = waiting.pop()
        ends = (*flight.at_time(a), a), (*flight.at_time(b), b)
        most = flight.most_acceleration(*ends[0], b - a)
        passed, open_ = [], False
        for number, watch in enumerate(watched):
            verdict = _verdict(watch, *ends, most)
            open_ |= verdict is None
            if verdict:
                passed.append(number)
        if open_ and b - a > finest + 4.0 * _EPS * b:
            middle = 0.5 * (a + b)
            waiting += [(middle, b), (a, middle)]
            continue
        if passed:
            times = [(_passing(flight, watched[number], a, b), number) for number in passed]
            return Passage(*min(times))
    return None


def _verdict(
    watch: Watch, begin: tuple[float, float, float], end: tuple[float, float, float], most: float
) -> bool | None:
    """Whether a function passes 0 in a cell, from displacement, velocity and time at its ends; None: it may."""
    a, cell, bend = begin[2], end[2] - begin[2], abs(watch.of_place) * most
    first, last = (watch.way * _value(watch, u, t) for u, _, t in (begin, end))
    rise, later = (watch.way * (watch.of_place * v + watch.of_time) for _, v, _ in (begin, end))
    if a == 0.0 and abs(first) <= 1e-15 * abs(watch.level):
        first = 0.0
    if rise * later > 0.0 and abs(rise) + abs(later) > bend * cell:
        if rise < 0.0 or (a == 0.0 and first == 0.0):
            return False
        return first < 0.0 <= last
    reach = abs(rise) * cell + 0.5 * bend * cell * cell
    if abs(first) > reach:
        return False
    return None


def _passing(flight: FedFlight, watch: Watch, a: float, b: float) -> float:
    """When a function that rises over a cell passes 0 in it."""
    from scipy.optimize import brentq  # slow to import

    def value(t: float) -> float:
        return watch.way * _value(watch, flight.at_time(t)[0], t)

    if value(b) <= 0.0:
        return b
    if value(a) >= 0.0:
        return a
    return float(brentq(value, a, b, xtol=_EPS * b, rtol=4.0 * _EPS))
