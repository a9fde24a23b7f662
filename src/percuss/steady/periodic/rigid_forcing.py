"""The forced motion of a bar as a whole, enclosed: U_f, v_f = U_f' and v_f' over intervals of time (theory §4)."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from typing import NamedTuple

import numpy as np

from percuss.model import System
from percuss.model.checks import Array
from percuss.steady.oscillator import phi1, phi2
from percuss.steady.periodic.ball import UNIT, Ball, exactly, hull

__all__ = ["FUNCTION", "Forced", "Forcing", "advances", "forcing_of"]

_TURN = 2.0 * math.pi
FUNCTION = 64.0 * UNIT
"""Relative error of exp, φ_1 and φ_2, at most."""

_WAVE = 16.0 * UNIT  # of an amplitude, a sine, and their product


class Forced(NamedTuple):
    """U_f but for a constant, v_f, and v_f', which may jump: then it is all values that it has."""

    displacement: Ball
    velocity: Ball
    slope: Ball


class Forcing(ABC):
    """The forced motion of one system as a whole.

    Parameters
    ----------
    mean
        Mean load, enclosed.
    """

    def __init__(self, mean: Ball) -> None:
        self.mean = mean

    @abstractmethod
    def over(self, time: Ball) -> Forced:
        """What it is at all times of a ball."""


def forcing_of(system: System) -> Forcing:
    """The forcing of a system: by its steps, or by its harmonics."""
    return _Steps(system) if system.load.is_piecewise else _Waves(system)


def advances(d: float, h: Ball) -> tuple[Ball, Ball, Ball]:
    """E = e^{−dh}, (1 − E)/d and its integral over the flight, for all durations h ≥ 0 of a ball."""
    ends = np.stack([np.maximum(h.mid - h.rad, 0.0) * (1.0 - UNIT), (h.mid + h.rad) * (1.0 + UNIT)])
    room = FUNCTION * (1.0 + d * ends[1])  # the argument of an exponential is rounded, too
    values = np.exp(-d * ends), ends * phi1(d * ends), ends**2 * phi2(d * ends)
    kept, once, again = (hull(part.min(axis=0) * (1.0 - room), part.max(axis=0) * (1.0 + room)) for part in values)
    return kept, once, again


class _Waves(Forcing):
    """Σ of harmonics."""

    def __init__(self, system: System) -> None:
        super().__init__(exactly(system.load.mean))
        self.k = system.load.harmonics.astype(float)
        self.factor = system.load.coefficients[system.load.harmonics] / (system.d + 1j * self.k)
        size = np.abs(self.factor)
        self.sums = [float((size * self.k**power).sum()) * (1.0 + _WAVE * (8.0 + size.size)) for power in range(-1, 4)]

    def over(self, time: Ball) -> Forced:
        """What it is at all times of a ball."""
        angle = np.exp(1j * np.multiply.outer(time.mid, self.k))
        found = [(angle @ (self.factor * (1j * self.k) ** power)).real for power in (-1, 0, 1, 2)]
        noise = [  # of Σ of so many waves, whose angles are rounded
            self.sums[i] * (_WAVE + UNIT * self.k.size) + self.sums[i + 1] * UNIT * np.abs(time.mid) for i in range(4)
        ]
        place, rate, slope, turn = (Ball(value, error) for value, error in zip(found, noise, strict=True))
        r, curve = time.rad, self.sums[4]
        return Forced(
            place.wider(rate.most * r + 0.5 * r**2 * np.minimum(slope.most + r * self.sums[3], self.sums[2])),
            rate.wider(slope.most * r + 0.5 * r**2 * self.sums[3]),
            slope.wider(np.minimum(turn.most * r + 0.5 * r**2 * curve, r * self.sums[3])),
        )


class _Steps(Forcing):
    """Constant between breaks: closed form on each piece from the state that comes back after a turn."""

    def __init__(self, system: System) -> None:
        load, self.d = system.load, system.d
        self.breaks = np.array(load.breaks)
        lengths = np.diff(self.breaks, append=self.breaks[0] + _TURN)
        self.lengths = Ball(lengths, 4.0 * UNIT * np.full(lengths.shape, _TURN))
        values = exactly(load.values)
        super().__init__(_total(values * self.lengths).over(Ball(np.array(_TURN), np.array(8.0 * UNIT))))
        self.force = values - self.mean
        self.kept, self.once, self.again = advances(self.d, self.lengths)
        self.rates, self.places = self._at_breaks()

    def _at_breaks(self) -> tuple[Ball, Ball]:
        """v_f and U_f at the breaks: Σ q h = 0, so that what is divided by 1 − e^{−2πd} vanishes with it."""
        d, count = self.d, self.breaks.size
        terms = []
        for j in range(count):
            after = Ball(self.lengths.mid[j + 1 :].sum(keepdims=True), np.full(1, 32.0 * UNIT * _TURN))
            kept, once, _ = advances(d, after)
            rest = _at(self.again, j) * kept + _at(self.lengths, j) * once
            terms.append(_at(self.force, j) * rest)
        whole = advances(d, Ball(np.array([_TURN]), np.array([8.0 * UNIT])))[1]
        rate, place = -_sum(terms).over(whole), exactly(np.zeros(1))
        rates, places = [rate], [place]
        for j in range(count):
            place = place + rate * _at(self.once, j) + _at(self.force, j) * _at(self.again, j)
            rate = rate * _at(self.kept, j) + _at(self.force, j) * _at(self.once, j)
            rates.append(rate)
            places.append(place)
        return _joined(rates), _joined(places)

    def over(self, time: Ball) -> Forced:
        """What it is at all times of a ball."""
        turns = np.floor((time.mid - self.breaks[0]) / _TURN)
        since = np.clip(time.mid - _TURN * turns - self.breaks[0], 0.0, _TURN)
        inexact = 2.0 * UNIT * (np.abs(time.mid) + 2.0 * _TURN)
        piece = np.clip(np.searchsorted(self.breaks - self.breaks[0], since, side="right") - 1, 0, self.breaks.size - 1)
        into = Ball(np.maximum(since - (self.breaks[piece] - self.breaks[0]), 0.0), 4.0 * inexact)
        kept, once, again = advances(self.d, into)
        force, rate, place = _at(self.force, piece), _at(self.rates, piece), _at(self.places, piece)
        velocity = rate * kept + force * once
        displacement = place + rate * once + force * again
        drag = exactly(self.d)
        r = time.rad + inexact
        everywhere = (np.abs(self.force.mid) + self.force.rad).max() * 2.0  # |v_f'|, as |d v_f| ≤ max |q|
        forces = self._forces(since, r)
        slope = forces - drag * velocity.wider(r * everywhere)
        return Forced(
            displacement.wider(r * velocity.most + 0.5 * r**2 * everywhere), velocity.wider(r * slope.most), slope
        )

    def _forces(self, since: Array, r: Array) -> Ball:
        """All values of the alternating load within r of a time."""
        low, high = np.full(since.shape, np.inf), np.full(since.shape, -np.inf)
        starts, ends = self.breaks - self.breaks[0], np.append(self.breaks[1:] - self.breaks[0], _TURN)
        least, most = self.force.mid - self.force.rad, self.force.mid + self.force.rad
        for turn in (-_TURN, 0.0, _TURN):
            for j in range(starts.size):
                met = (since + r >= starts[j] + turn) & (since - r <= ends[j] + turn)
                low, high = (
                    np.where(met, np.minimum(low, least[j]), low),
                    np.where(met, np.maximum(high, most[j]), high),
                )
        return hull(low, high)


def _at(ball: Ball, which: int | Array) -> Ball:
    """Some of a row of balls, as a row."""
    index = np.atleast_1d(which)
    return Ball(ball.mid[index], ball.rad[index])


def _joined(balls: list[Ball]) -> Ball:
    return Ball(np.concatenate([ball.mid for ball in balls]), np.concatenate([ball.rad for ball in balls]))


def _sum(balls: list[Ball]) -> Ball:
    total = balls[0]
    for ball in balls[1:]:
        total = total + ball
    return total


def _total(ball: Ball) -> Ball:
    """The sum of a row."""
    return _sum([Ball(mid, rad) for mid, rad in zip(ball.mid, ball.rad, strict=True)])
