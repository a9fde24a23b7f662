"""From a release to the next rest: flights and impacts, one after the other, until a chatter is complete.

Rest forgets everything: the bar leaves the wall undeformed and at rest, so that all that follows is told by the phase
of the release alone. As in a simulation the bar is taken to be away from the wall as long as the load pulls, and for
the time of one wave through it; that no flight touches the wall before its impact is proved from then on. So does the
one mode of a structure, under the load `wall_load`: it is away as long as that pulls, half a period of its own at most.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from percuss.model.set_at_wall import half_swing
from percuss.steady.resting.first_contact import Contact, first_contact
from percuss.steady.resting.leg import Leg, Motion, Swing
from percuss.steady.resting.releases import pull_lasts

__all__ = ["MOST_IMPACTS", "Chain", "Course", "Impact", "chain_from", "chatter_left"]

MOST_IMPACTS = 20_000
_ERROR = 1e-13  # to which the end of a chatter is known
_LONGEST = 1e-3  # left of a chatter whose sum is taken
_STILL = 1e-13  # of the speeds that occur: a rebound that is slower is none
_RIPPLES = 8  # quarter waves of the last mode for which the ripple of a cut sum may hide the release


class Impact(NamedTuple):
    """An impact: its time in rad of the load, unwrapped, and the speed of the striking end just before it."""

    time: float
    speed: float


@dataclass(frozen=True)
class Chain:
    """A bar that is let go, from there to its next rest.

    Parameters
    ----------
    release
        When it is let go, in rad of the load.
    impacts
        Its impacts; of a chatter those that were followed one by one, with the others summed.
    rest
        When it comes to rest; None when it did not until `stop`.
    chatters
        Whether it rests because its impacts have piled up.
    stop
        Up to when it was followed.
    """

    release: float
    impacts: tuple[Impact, ...]
    rest: float | None
    chatters: bool
    stop: float


def chatter_left(leg: Leg, factor: float) -> float | None:
    """How long it takes until the impacts after this one have piled up; None where that is not certain, or not known.

    Theory, Chatter: rebound speed w, acceleration P at rest and its rate j. The flights 2w/P, 2Rw/P, … add up to
    T = 2w/((1 − R)P), and to first order in j and d to T(1 − dT/6 − jT/(3P)). What changes the acceleration otherwise,
    the elastic modes above all, is part of what is not known.

    Parameters
    ----------
    leg
        The flight after an impact.
    factor
        −R, by which the law multiplies velocities; between -1 and 0.
    """
    swing, w, d = leg.swing, -leg.rate, leg.swing.system.d
    if not swing.system.body.is_free:
        return _left_of_a_mode(leg, factor)
    push = leg.acceleration - d * w
    if push <= 0.0:
        return None
    left = 2.0 * w / ((1.0 + factor) * push)
    if left > _LONGEST:
        return None
    smooth, elastic = leg.jerks
    known, unknown = (smooth + d * leg.bend) * left / push + d * left, elastic * left / push
    if d != 0.0 or swing.known.is_damped:
        z, rate = leg.free
        other = np.abs(swing.known.gamma * (swing.known.damping - d))
        unknown += float(other @ np.hypot(swing.known.omega * z, rate)) / push
    if known + unknown > 0.1 or (known**2 + unknown) * left > _ERROR:
        return None
    k = swing.harmonics
    waves = (swing.end * leg.turned * (-1j * k**3 - d * k**2)).real.sum()
    return float(left * (1.0 - d * left / 6.0 - waves * left / (3.0 * push)))


def _left_of_a_mode(leg: Leg, factor: float) -> float | None:
    """The same of one mode, y'' = P − d y' − ω² y: only the second order in time is not known."""
    known, load, w, k = leg.swing.known, leg.swing.system.load, -leg.rate, leg.swing.harmonics
    d, gamma = float(known.damping[0]), float(known.gamma[0])
    push = leg.acceleration - d * w
    if push <= 0.0:
        return None
    left = 2.0 * w / ((1.0 + factor) * push)
    if left > _LONGEST:
        return None
    forces = gamma * load.coefficients[k.astype(int)]
    first = float(k @ np.abs(forces)) * left / push + d * left
    second = (float(k**2 @ np.abs(forces)) / push + float(known.omega[0]) ** 2) * left**2
    if first > 0.1 or (first**2 + second) * left > _ERROR:
        return None
    rate = float((1j * k * forces * leg.turned).real.sum())
    return left * (1.0 - d * left / 6.0 - rate * left / (3.0 * push))


def chain_from(swing: Swing, release: float, stop: float) -> Chain:
    """Follow a bar that is let go at a phase of the load.

    Parameters
    ----------
    swing
        The system.
    release, stop
        When it is let go, and when to give up; in rad of the load.
    """
    return Course(swing, release, stop).chain()


class Course:
    """A bar that is let go, as it is followed from impact to impact.

    Attributes
    ----------
    leg
        The flight that begins: after the release, then after the last impact or jump of the load.
    impacts
        Those that were followed.
    """

    def __init__(self, swing: Swing, release: float, stop: float) -> None:
        self.swing, self.stop, self.release = swing, stop, release
        body, modes = swing.system.body, swing.modes
        self.law = swing.system.contact
        none = np.zeros(modes)
        self.leg = Leg(swing, release, Motion(0.0, 0.0, 0.0, none, none))
        pulled, free = pull_lasts(swing.system.load, release), body.is_free
        wave = (1.0 + 0.5 / modes) * body.transit_time if modes else 0.0
        self.free_until = release + (max(pulled, wave) if free else min(pulled, half_swing(swing.known)))
        self.ripple = 0.5 * math.pi / float(swing.known.omega[-1]) if modes and free else 0.0
        self.impacts: list[Impact] = []
        self.flight = math.inf  # the last one

    def chain(self) -> Chain:
        """The whole way to the rest."""
        while len(self.impacts) < MOST_IMPACTS and self.strikes():
            time, speed = self.impacts[-1]
            left, chatters = self._rests(speed)
            if left is not None and time + left <= self.stop:
                return Chain(self.release, tuple(self.impacts), time + left, chatters, time + left)
        return Chain(self.release, tuple(self.impacts), None, False, min(self.stop, self.leg.time))

    def strikes(self) -> bool:
        """Follow the bar through its next impact; whether there is one before the stop."""
        landed = self._landing()
        if landed is None:
            return False
        time, motion, speed = landed
        self.flight = time - self.impacts[-1].time if self.impacts else math.inf
        self.impacts.append(Impact(time, speed))
        u, v = self.law.after(motion.displacement, motion.velocity)
        factor = self.law.velocity_factor
        self.leg = Leg(self.swing, time, Motion(0.0, factor * speed, factor * motion.rigid, u, v))
        return True

    # -- flights --

    def _landing(self) -> tuple[float, Motion, float] | None:
        """The next contact: when, the motion and the speed of the striking end; None for none before the stop."""
        while True:
            leg = self.leg
            end = min(self.swing.breaks_after(leg.time), self.stop) - leg.time
            found = self._contact(leg, end)
            if found is not None:
                motion = leg.at(found.time)
                return leg.time + found.time, motion, found.speed
            if leg.time + end >= self.stop:
                return None
            self.leg = Leg(self.swing, leg.time + end, leg.at(end))

    def _contact(self, leg: Leg, end: float) -> Contact | None:
        begin = self.free_until - leg.time
        if begin >= end:
            return None
        if begin > 0.0 or not self.impacts:
            return self._let_go(leg, max(begin, 0.0), end)
        safe = self._safe(leg)
        return first_contact(leg, safe, end) if safe < end else None

    def _let_go(self, leg: Leg, begin: float, end: float) -> Contact | None:
        """The first contact after the time for which a bar let go is known to be free.

        The ripple of a finite number of modes may still lap at the wall then; a bar that comes back is a contact.
        """
        for tries in range(_RIPPLES + 1):
            at = begin + tries * self.ripple
            if at >= end:
                return None
            y, v = (float(part[0]) for part in leg.gap(np.array([at])))
            if y < 0.0:
                return first_contact(leg, at, end)
            if v > 0.0 or tries == _RIPPLES:
                return Contact(at, max(v, 0.0))
        return None

    @staticmethod
    def _safe(leg: Leg) -> float:
        """A time up to which the bar surely flies: by its speed, or by its acceleration where it has none."""
        if leg.start.gap < 0.0:
            return 0.0
        if leg.rate < 0.0 and leg.bend > 0.0:
            return -1.5 * leg.rate / leg.bend
        if leg.acceleration >= 0.0:
            return 0.0
        jerk = sum(leg.jerks)
        return -2.5 * leg.acceleration / jerk if jerk > 0.0 else math.inf

    # -- rest --

    def _rests(self, speed: float) -> tuple[float | None, bool]:
        """How long until the bar lies on the wall, if it does without leaving, and whether it chatters until then."""
        leg, factor = self.leg, self.law.velocity_factor
        push = float(self.swing.system.load.value(leg.time))
        scale = abs(leg.drift) + float(np.abs(self.swing.end) @ self.swing.harmonics) + speed
        if -leg.rate <= _STILL * scale:
            held = (factor == 0.0 and push > 0.0) or leg.acceleration >= 0.0
            return (0.0 if held else None), factor < 0.0 and len(self.impacts) > 1
        if self._is_held(push):
            return 0.0, factor < 0.0 and len(self.impacts) > 1
        if not -1.0 < factor < 0.0:
            return None, False
        left = chatter_left(leg, factor)
        if left is None or 2.0 * left > self.swing.breaks_after(leg.time) - leg.time:
            return None, False
        return left, True

    def _is_held(self, push: float) -> bool:
        """Whether the load holds the bar, by a law that turns the strain over, for less than a contact."""
        system = self.swing.system
        if system.contact.keeps_strain or not -1.0 < self.law.velocity_factor < 0.0:
            return False
        contact = 2.0 * system.body.transit_time
        return self.flight < contact and 0.0 <= -2.0 * self.leg.start.rigid <= push * contact
