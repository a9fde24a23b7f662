"""From a release to the next rest: flights and impacts, one after the other, until a chatter is complete.

Rest forgets everything: the bar leaves the wall undeformed and at rest, so that all that follows is told by the phase
of the release alone. As in a simulation the bar is taken to be away from the wall as long as the load pulls, and for
the time of one wave through it; that no flight touches the wall before its impact is proved from then on. So does the
one mode of a structure, under the load `wall_load`: it is away as long as that pulls, half a period of its own at most.
A structure of several modes leaves with what has moved on while the wall held its contact (`rest_map`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from typing import NamedTuple, Protocol

import numpy as np

from percuss.halting import check_interrupted
from percuss.mechanics.flow import beyond_time, excess, phi1, phi2, propagator, response
from percuss.model import Load, Modes, System
from percuss.model.checks import Array, ComplexArray
from percuss.model.system import half_swing
from percuss.steady.forced import HarmonicResponse
from percuss.steady.oscillator import refuse_resonance
from percuss.steady.trigonometric import TURN, on_circle, trigonometric_roots

# ---- A stretch of free flight under a load without jumps, told by how far the striking end has come since its start
#
# The gap function is y'(0) t and what bends it: every part of that is exact to rounding of its own size, however short
# the time. The ever shorter flights of a chatter then keep their digits.

_FEW = 8  # harmonics, or modes, of which a loop is faster than arrays


class GapState(NamedTuple):
    """The gap and its rate, the velocity of the bar as a whole, and q_n, q_n' of its modes: what each moves it by."""

    gap: float
    rate: float
    rigid: float
    displacement: Array
    velocity: Array


@dataclass(frozen=True)
class ForcedResponse:
    """What the load does to a bar of modes 0 … N, or to a structure, whatever its motion."""

    system: System
    modes: int

    @cached_property
    def known(self) -> Modes:
        """The elastic modes."""
        refuse_resonance(self.system)
        return self.system.body.modes(self.modes, self.system.load.at)

    @cached_property
    def harmonics(self) -> Array:
        """Numbers k of the harmonics; none for steps. Shape (K,)."""
        return np.empty(0) if self.system.load.is_piecewise else self.system.load.harmonics.astype(float)

    @cached_property
    def gains(self) -> ComplexArray:
        """What each harmonic moves the striking end by in each elastic mode; shape (N, K)."""
        if not self.harmonics.size:
            return np.empty((self.modes, 0), dtype=complex)
        response = HarmonicResponse(self.system)
        return np.asarray(self.known.gamma[:, None] * response.gains(self.modes) * response.p)

    @cached_property
    def statics(self) -> Array:
        """… and a constant unit load; shape (N,)."""
        return np.asarray(self.known.gamma / self.known.omega**2)

    @property
    def is_several(self) -> bool:
        """Whether it is a structure of several modes, which move on while the wall holds its contact."""
        return not self.system.body.is_free and self.modes > 1

    @cached_property
    def rigid(self) -> ComplexArray:
        """… and the bar as a whole, in velocity; shape (K,)."""
        if not self.system.body.is_free:
            return np.zeros(self.harmonics.size, dtype=complex)
        p = self.system.load.coefficients[self.harmonics.astype(int)]
        return np.asarray(p / (self.system.d + 1j * self.harmonics))

    @cached_property
    def end(self) -> ComplexArray:
        """… and the striking end; shape (K,)."""
        whole = self.rigid / (1j * self.harmonics)
        return np.asarray(whole + self.gains.sum(axis=0)) if self.modes else whole

    def breaks_after(self, time: float) -> float:
        """The first jump of the load after a time; inf where it has none."""
        breaks = np.asarray(self.system.load.breaks)
        if not breaks.size:
            return np.inf
        turn = 2.0 * np.pi
        ahead = breaks + turn * np.floor((time - breaks) / turn + 1.0)
        return float(np.where(ahead > time + 4.0 * np.spacing(max(time, turn)), ahead, ahead + turn).min())

    def constant(self, time: float) -> float:
        """The constant part of the load from a time on: its mean, or the value of the step."""
        load = self.system.load
        if not load.is_piecewise:
            return load.mean
        return float(load.value(0.5 * (time + self.breaks_after(time))))


@dataclass(frozen=True)
class ReleasedFlight:
    """A flight from a time on, in rad of the load, and a motion then, under a load without jumps."""

    swing: ForcedResponse
    time: float
    start: GapState

    @cached_property
    def push(self) -> float:
        """The constant part of the load."""
        return self.swing.constant(self.time)

    @property
    def whole(self) -> float:
        """What of it moves the bar as a whole."""
        return self.push if self.swing.system.body.is_free else 0.0

    @cached_property
    def turned(self) -> ComplexArray:
        """exp(ikt) at the start."""
        return np.asarray(np.exp(1j * self.swing.harmonics * self.time))

    @cached_property
    def free(self) -> tuple[Array, Array]:
        """What is free in the elastic modes at the start, displacements and velocities."""
        swing, start = self.swing, self.start
        waves = swing.gains * self.turned
        forced = self.push * swing.statics + waves.real.sum(axis=1)
        rate = (waves * (1j * swing.harmonics)).real.sum(axis=1)
        return start.displacement - forced, start.velocity - rate

    @cached_property
    def drift(self) -> float:
        """Velocity of the bar as a whole at the start, but for what the harmonics make of it."""
        return self.start.rigid - float((self.swing.rigid * self.turned).real.sum())

    @cached_property
    def accelerations(self) -> Array:
        """q_n'' just after the start; shape (N,)."""
        swing, (z, rate) = self.swing, self.free
        waves = (swing.gains * (-(swing.harmonics**2) * self.turned)).real.sum(axis=1)
        return np.asarray(waves - swing.known.omega**2 * z - swing.known.damping * rate)

    @cached_property
    def acceleration(self) -> float:
        """… of the striking end."""
        swing = self.swing
        waves = float((1j * swing.harmonics * swing.rigid * self.turned).real.sum())
        return self.whole - swing.system.d * self.drift + waves + float(self.accelerations.sum())

    @cached_property
    def at_rest(self) -> tuple[Array, float]:
        """The same without the velocities that modes 1 … N have, and of the end of a structure."""
        pushes = self.accelerations + self.swing.known.damping * self.start.velocity
        return pushes, float(pushes.sum())

    @cached_property
    def aside(self) -> Array:
        """Velocities of the modes of a structure beside those with which a chatter moves them; shape (N,)."""
        pushes, push = self.at_rest
        return np.asarray(self.start.velocity - self.start.rate * pushes / push)

    @cached_property
    def ringing(self) -> Array:
        """Bound of what each free elastic mode moves the striking end; shape (N,)."""
        z, rate = self.free
        return np.asarray(np.hypot(z, rate / self.swing.known.omega))

    @cached_property
    def bend(self) -> float:
        """Bound of |y''|."""
        known, k, size = self.swing.known, self.swing.harmonics, np.abs(self.swing.end)
        drift = abs(self.whole - self.swing.system.d * self.drift)
        swing = float(self.ringing @ (known.omega * (known.omega + known.damping)))
        return drift + float(k**2 @ size) + swing

    @cached_property
    def jerks(self) -> tuple[float, float]:
        """Bounds of |y'''|: of the smooth part of the motion, and of the free elastic one."""
        known, k, size, d = self.swing.known, self.swing.harmonics, np.abs(self.swing.end), self.swing.system.d
        both = known.omega + known.damping
        smooth = d * abs(self.whole - d * self.drift) + float(k**3 @ size)
        return smooth, float(self.ringing @ (known.omega * both**2))

    def gap(self, t: Array) -> tuple[Array, Array]:
        """Gap function and its velocity at times since the start; both of shape (len(t),)."""
        check_interrupted()
        swing, d = self.swing, self.swing.system.d
        fade, force = t * phi1(d * t), self.whole - d * self.drift
        y, v = self.start.rate * t + force * t**2 * phi2(d * t), self.start.rate + force * fade
        if swing.harmonics.size:
            angle, amplitude = np.outer(t, swing.harmonics), swing.end * self.turned
            turned = np.sin(angle) + 1j * 2.0 * np.sin(0.5 * angle) ** 2  # (exp(ix) − 1)/i
            bent = excess(angle) + 1j * 2.0 * np.sin(0.5 * angle) ** 2  # … − x
            y = y + (bent @ (1j * amplitude)).real
            v = v - (turned @ (swing.harmonics * amplitude)).real
        if swing.modes:
            known, (z, rate), time = swing.known, self.free, t[:, None]
            step, half = propagator(known.omega, known.damping, time), 0.5 * known.damping
            lost, late = np.expm1(-half * time) - step.versine, beyond_time(known.omega, known.damping, step.b, time)
            y = y + ((lost + half * step.b) * z + late * rate).sum(axis=1)
            v = v + (step.c * z + (lost - half * step.b) * rate).sum(axis=1)
        return np.asarray(self.start.gap + y), np.asarray(v)

    def gap_at(self, t: float) -> tuple[float, float]:
        """Gap function and its velocity at a time since the start: as `gap`; sooner with few modes and harmonics."""
        swing, d = self.swing, self.swing.system.d
        if swing.modes > _FEW or swing.harmonics.size > _FEW:
            y, v = self.gap(np.array([t]))
            return float(y[0]), float(v[0])
        check_interrupted()
        fade, bend = (t, 0.5 * t * t) if d == 0.0 else (t * float(phi1(d * t)), t**2 * float(phi2(d * t)))
        force = self.whole - d * self.drift
        height, speed = self.start.rate * t + force * bend, self.start.rate + force * fade
        for k, amplitude in zip(swing.harmonics.tolist(), self._amplitudes, strict=True):
            angle = k * t
            even = 2.0 * math.sin(0.5 * angle) ** 2
            height -= amplitude.imag * excess(angle) + amplitude.real * even
            speed -= k * (amplitude.real * math.sin(angle) - amplitude.imag * even)
        for stiffness, drag, z, rate in self._oscillations:
            _, s, q, w = response(t, stiffness, drag)
            lost = stiffness * w + drag * q  # t − s
            height -= stiffness * q * z + lost * rate
            speed -= stiffness * s * z + (stiffness * q + drag * s) * rate
        return self.start.gap + height, speed

    @cached_property
    def _oscillations(self) -> list[list[float]]:
        """ω², d, displacement and velocity of each mode, of what is free in it."""
        known = self.swing.known
        return np.array([known.omega**2, known.damping, *self.free]).T.tolist() if self.swing.modes else []

    @cached_property
    def _amplitudes(self) -> list[complex]:
        return list((self.swing.end * self.turned).tolist())

    def at(self, t: float) -> GapState:
        """The motion a time after the start."""
        swing, d = self.swing, self.swing.system.d
        gap, speed = (float(part[0]) for part in self.gap(np.array([t])))
        if not swing.modes:
            return GapState(gap, speed, speed, self.start.displacement, self.start.velocity)
        waves = np.exp(1j * swing.harmonics * t) * self.turned
        rigid = float((swing.rigid * waves).real.sum())
        rigid += self.drift * float(np.exp(-d * t)) + self.whole * t * float(phi1(d * t))
        known, (z, rate) = swing.known, self.free
        step = propagator(known.omega, known.damping, t)
        moved = swing.gains * waves
        forced = self.push * swing.statics + moved.real.sum(axis=1)
        forced_rate = (moved * (1j * swing.harmonics)).real.sum(axis=1)
        return GapState(
            gap, speed, rigid, step.a * z + step.b * rate + forced, step.c * z + step.e * rate + forced_rate
        )

    def rates(self, t: Array) -> Array:
        """Velocities of the modes 0 … N, shape (N + 1, len(t))."""
        seen = [self.at(time) for time in t.tolist()]
        return np.array([np.append(one.rigid, one.velocity) for one in seen]).T


# ---- The first contact of a flight, with the proof that there is none before: by Taylor's theorem, cell by cell

_CELLS = 64
_WIDEST = 2.0  # rad, looked at at once
_TOUCH = 1e-14  # of the size of the motion, within which rounding decides whether the bar touches the wall
_STEPS = 80
_CLOSE = 1e-9  # share of the time at which Newton's method is about to end


class Approaching(Protocol):
    """What may touch the wall: its beginning, its gap and rate at times since, and bounds of their derivatives."""

    @property
    def start(self) -> GapState: ...
    @property
    def acceleration(self) -> float: ...
    @property
    def bend(self) -> float: ...
    @property
    def jerks(self) -> tuple[float, float]: ...
    def gap(self, t: Array) -> tuple[Array, Array]: ...
    def gap_at(self, t: float) -> tuple[float, float]: ...


class WallTouch(NamedTuple):
    """A contact: its time since the start of the leg, and the velocity of the striking end there."""

    time: float
    speed: float


def first_contact(leg: Approaching, begin: float, end: float) -> WallTouch | None:
    """The first time in [begin, end) at which the striking end reaches the wall; None when there is none."""
    # Cells are dropped only where y + |y'| h + sup|y''| h²/2 < 0 at their middles; the first that is left has a contact
    # when y' exceeds what sup|y''| can take back within twice its width, and y then grows beyond 0. Times are since the
    # start of the leg; the gap at `begin` is negative, or 0 and falling.
    low, width = begin, _first_window(leg, begin)
    while low < end:
        wide = min(width, end - low)
        found = _within(leg, low, low + wide)
        if found is not None:
            return found if found.time < end else None
        low, width = low + wide, min(2.0 * width, _WIDEST)
    return None


def _first_window(leg: Approaching, begin: float) -> float:
    """Some times the flight to be expected of a bar that has just struck, and not longer than y'' stays the same."""
    speed, force, jerk = -leg.start.rate, leg.acceleration, sum(leg.jerks)
    if leg.start.gap == 0.0 and speed <= 0.0 and begin > 0.0:
        return min(begin, _WIDEST)  # let go: as long as the load has pulled
    if leg.start.gap < 0.0 or speed <= 0.0 or jerk == 0.0:
        return _WIDEST
    steady = abs(force) / jerk + 2.0 * math.sqrt(speed / jerk)
    return min(6.0 * speed / force if force > 0.0 else _WIDEST, steady, _WIDEST)


def _safe(leg: ReleasedFlight) -> float:
    """A time up to which the bar surely flies: by its speed, or by its acceleration where it has none."""
    if leg.start.gap < 0.0:
        return 0.0
    if leg.start.rate < 0.0 and leg.bend > 0.0:
        return -1.5 * leg.start.rate / leg.bend
    if leg.acceleration >= 0.0:
        return 0.0
    jerk = sum(leg.jerks)
    return -2.5 * leg.acceleration / jerk if jerk > 0.0 else math.inf


def _within(leg: Approaching, low: float, high: float) -> WallTouch | None:
    bend, half = min(leg.bend, abs(leg.acceleration) + sum(leg.jerks) * high), 0.5 * (high - low) / _CELLS
    touch = _TOUCH * min(1.0, abs(leg.start.gap) + (abs(leg.start.rate) + bend * high) * high)
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
                return WallTouch(float(centres[first]), max(float(v[first]), 0.0))
            return None
        half *= 0.5
        centres = np.sort(np.concatenate([centres - half, centres + half]))
    return None


def _refined(leg: Approaching, low: float, high: float, guess: float) -> WallTouch:
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
    return WallTouch(t, leg.gap_at(t)[1])


# ---- Where the load lets go of a bar that rests on the wall, and for how long it pulls (theory, Rest and release)

_SAME = 1e-9  # phases nearer than this are one


def release_phases(load: Load) -> Array:
    """The phases in [0, 2π) at which the load begins to pull, increasing; of steps those at which it jumps below 0."""
    if load.is_piecewise:
        values, breaks = np.asarray(load.values), np.asarray(load.breaks)
        return np.asarray(np.sort(on_circle(breaks[(values < 0.0) & (np.roll(values, 1) >= 0.0)])))
    roots, pulls = _zeros(load)
    if not roots.size:
        return np.empty(0)
    return np.asarray(roots[pulls & ~np.roll(pulls, 1)])


@lru_cache(maxsize=64)  # asked for at every release of a bar, and once more for its rest
def _zeros(load: Load) -> tuple[Array, np.typing.NDArray[np.bool_]]:
    """The phases at which a load changes between push and pull, and whether it pulls from each on."""
    k = np.append(0.0, load.harmonics.astype(float))
    roots = trigonometric_roots(k, np.append(complex(load.mean), load.coefficients[load.harmonics]))
    if not roots.size:
        return roots, np.empty(0, dtype=bool)
    middles = 0.5 * (roots + np.append(roots[1:], roots[0] + TURN))
    return roots, np.asarray(load.value(middles) < 0.0)


def pull_lasts(load: Load, phase: float) -> float:
    """How long the load pulls, or is 0, from a phase on at which it begins to; inf when it never pushes again."""
    if load.is_piecewise:
        values, breaks = np.asarray(load.values), np.asarray(load.breaks)
        pushes = np.sort(np.mod(breaks[values > 0.0] - phase, TURN))
        return float(pushes[pushes > 0.0].min(initial=math.inf))
    roots, pulls = _zeros(load)
    ahead = np.mod(roots[~pulls] - phase, TURN)
    return float(ahead[ahead > _SAME].min(initial=math.inf))


def time_to_release(load: Load, phases: Array, time: float) -> tuple[float, int]:
    """How long the load holds a bar on the wall, and the number of the release phase; −1: pulled at once."""
    ahead = np.mod(phases - time, TURN)
    ahead = np.where(TURN - ahead <= 4.0 * np.spacing(max(abs(time), TURN)), 0.0, ahead)
    nearest = int(np.argmin(ahead))
    if ahead[nearest] == 0.0 or float(load.value(time)) >= 0.0:
        return float(ahead[nearest]), nearest
    return 0.0, -1


# ---- From a release to the next rest: flights and impacts, one after the other, until a chatter is complete

MOST_IMPACTS = 20_000
_ERROR = 1e-13  # to which the end of a chatter is known
_LONGEST = 1e-3  # left of a chatter whose sum is taken
_STILL = 1e-13  # of the speeds that occur: a rebound that is slower is none
_AWAY = 1e-2  # of a radian of the load or of the highest mode: how long a structure of several modes is away at least
_RIPPLES = 8  # quarter waves of the last mode for which the ripple of a cut sum may hide the release


class WallImpact(NamedTuple):
    """An impact: its time in rad of the load, unwrapped, and the speed of the striking end just before it."""

    time: float
    speed: float


@dataclass(frozen=True)
class RestPath:
    """A bar let go at `release` (rad), its impacts and the sum of a chatter's rest, to its next rest or `stop`.

    `begun` is the motion as it is let go, and `shape` the q_n in which it lies down.
    """

    release: float
    impacts: tuple[WallImpact, ...]
    rest: float | None
    chatters: bool
    stop: float
    begun: GapState = field(repr=False, compare=False)
    shape: Array = field(repr=False, compare=False)

    def later(self, by: float) -> RestPath:
        """The same so much later."""
        moved = tuple(impact._replace(time=impact.time + by) for impact in self.impacts)
        rest = None if self.rest is None else self.rest + by
        return replace(self, release=self.release + by, impacts=moved, rest=rest, stop=self.stop + by)


def chatter_left(leg: ReleasedFlight, factor: float) -> float | None:
    """How long until the impacts after this one have piled up; None where that is not certain, or not known."""
    # Theory, Chatter: rebound speed w, acceleration P at rest and its rate j. The flights 2w/P, 2Rw/P, … add up to T =
    # 2w/((1 − R)P), and to first order in j and d to T(1 − dT/6 − jT/(3P)). What changes the acceleration otherwise,
    # the elastic modes above all, is part of what is not known. A structure, whose modes begin with the accelerations
    # α_n at rest, moves as −α_n/P of its contact does, with d = Σ d_n α_n/P, but for `aside`; that, and only the second
    # order in time, is not known of it. `factor` is −R, by which the law multiplies velocities, between −1 and 0.
    swing, w, free, k = leg.swing, -leg.start.rate, leg.swing.system.body.is_free, leg.swing.harmonics
    known_modes, d = swing.known, swing.system.d
    push = leg.acceleration - d * w if free else leg.at_rest[1]
    if push <= 0.0:
        return None
    left = 2.0 * w / ((1.0 + factor) * push)
    if left > _LONGEST:
        return None
    if free:
        smooth, elastic = leg.jerks
        known, unknown = (smooth + d * leg.bend) * left / push + d * left, elastic * left / push
        if d != 0.0 or known_modes.is_damped:
            z, rate = leg.free
            other = np.abs(known_modes.damping - d)
            unknown += float(other @ np.hypot(known_modes.omega * z, rate)) / push
        most, waves = known + unknown, swing.end * (-1j * k**3 - d * k**2)
    else:
        omega, damping, share = known_modes.omega, known_modes.damping, leg.at_rest[0] / push
        d, aside = float(damping @ share), np.abs(leg.aside)
        waves = float(known_modes.gamma.sum()) * 1j * k * swing.system.load.coefficients[k.astype(int)]
        known = float(np.abs(waves).sum()) * left / push + abs(d) * left
        unknown = (float(k @ np.abs(waves)) / push + float(omega**2 @ np.abs(share))) * left**2
        unknown += float((damping + omega**2 * left) @ aside) * left / push
        most = known + unknown
    if most > 0.1 or (known**2 + unknown) * left > _ERROR:
        return None
    return float(left * (1.0 - d * left / 6.0 - (waves * leg.turned).real.sum() * left / (3.0 * push)))


class RestSearch:
    """A bar let go at a time (rad), followed from impact to impact until `stop`; `leg`: the flight that begins."""

    def __init__(self, swing: ForcedResponse, release: float, stop: float, begun: GapState | None = None) -> None:
        self.swing, self.stop, self.release = swing, stop, release
        body, modes, none = swing.system.body, swing.modes, np.zeros(swing.modes)
        self.law, free = swing.system.contact, body.is_free
        self.begun = GapState(0.0, 0.0, 0.0, none, none) if begun is None else begun
        self.leg = ReleasedFlight(swing, release, self.begun)
        if swing.is_several:
            self.free_until = release + _AWAY / max(1.0, float(swing.known.omega.max()))
        else:
            pulled = pull_lasts(swing.system.load, release)
            wave = (1.0 + 0.5 / modes) * body.transit_time if modes else 0.0
            self.free_until = release + (max(pulled, wave) if free else min(pulled, half_swing(swing.known)))
        self.ripple = 0.5 * math.pi / float(swing.known.omega[-1]) if modes and free else 0.0
        self.impacts: list[WallImpact] = []
        self.flight = math.inf  # the last one
        self.flown: list[tuple[ReleasedFlight, float, bool]] = []  # how long each, and whether it struck at its end

    def chain(self) -> RestPath:
        """The whole way to the rest."""
        while len(self.impacts) < MOST_IMPACTS and self.strikes():
            time, speed = self.impacts[-1]
            left, chatters = self._rests(speed)
            if left is not None and time + left <= self.stop:
                return self._path(time + left, chatters, time + left, self._shape(left))
        return self._path(None, False, min(self.stop, self.leg.time), self.leg.start.displacement)

    def _path(self, rest: float | None, chatters: bool, stop: float, shape: Array) -> RestPath:
        return RestPath(self.release, tuple(self.impacts), rest, chatters, stop, self.begun, shape)

    def _shape(self, left: float) -> Array:
        """The q_n in which it lies down after the last impact: a bar is undeformed, its end at the wall."""
        # The velocities beside those of the chatter are turned over and over in flights that are ever shorter.
        leg, factor = self.leg, self.law.velocity_factor
        if not self.swing.is_several:
            return np.zeros(self.swing.modes)
        if left == 0.0:
            return leg.start.displacement
        return leg.start.displacement - leg.aside * 2.0 * leg.start.rate / leg.at_rest[1] / (1.0 + factor**2)

    def strikes(self) -> bool:
        """Follow the bar through its next impact; whether there is one before the stop."""
        landed = self._landing()
        if landed is None:
            return False
        time, motion, speed = landed
        self.flight = time - self.impacts[-1].time if self.impacts else math.inf
        self.impacts.append(WallImpact(time, speed))
        u, v = self.law.after(motion.displacement, motion.velocity)
        factor = self.law.velocity_factor
        self.leg = ReleasedFlight(self.swing, time, GapState(0.0, factor * speed, factor * motion.rigid, u, v))
        return True

    # -- flights --

    def _landing(self) -> tuple[float, GapState, float] | None:
        """The next contact: when, the motion and the speed of the striking end; None for none before the stop."""
        while True:
            leg = self.leg
            end = min(self.swing.breaks_after(leg.time), self.stop) - leg.time
            found = self._contact(leg, end)
            if found is not None:
                motion = leg.at(found.time)
                self.flown.append((leg, found.time, True))
                return leg.time + found.time, motion, found.speed
            if leg.time + end >= self.stop:
                return None
            self.flown.append((leg, end, False))
            self.leg = ReleasedFlight(self.swing, leg.time + end, leg.at(end))

    def _contact(self, leg: ReleasedFlight, end: float) -> WallTouch | None:
        begin = self.free_until - leg.time
        if begin >= end:
            return None
        if begin > 0.0 or not self.impacts:
            return self._let_go(leg, max(begin, 0.0), end)
        safe = _safe(leg)
        return first_contact(leg, safe, end) if safe < end else None

    def _let_go(self, leg: ReleasedFlight, begin: float, end: float) -> WallTouch | None:
        """The first contact after a bar let go is surely free; before, the ripple of few modes may lap at the wall."""
        for tries in range(_RIPPLES + 1):
            at = begin + tries * self.ripple
            if at >= end:
                return None
            y, v = (float(part[0]) for part in leg.gap(np.array([at])))
            if y < 0.0:
                return first_contact(leg, at, end)
            if v > 0.0 or tries == _RIPPLES:
                return WallTouch(at, max(v, 0.0))
        return None

    # -- rest --

    def _rests(self, speed: float) -> tuple[float | None, bool]:
        """How long until the bar lies on the wall, if it does without leaving, and whether it chatters until then."""
        leg, factor = self.leg, self.law.velocity_factor
        push = 0.0 if self.swing.is_several else float(self.swing.system.load.value(leg.time))
        scale = abs(leg.drift) + float(np.abs(self.swing.end) @ self.swing.harmonics) + speed
        if -leg.start.rate <= _STILL * scale:
            held = (factor == 0.0 and push > 0.0) or leg.acceleration >= 0.0
            return (0.0 if held else None), factor < 0.0 and len(self.impacts) > 1
        if not -1.0 < factor < 0.0:
            return None, False
        system, contact = self.swing.system, 2.0 * self.swing.system.body.transit_time
        # a law that turns the strain over: the load holds the bar for less than a contact
        held = self.flight < contact and 0.0 <= -2.0 * leg.start.rigid <= push * contact
        if held and not system.contact.keeps_strain:
            return 0.0, len(self.impacts) > 1
        left = chatter_left(leg, factor)
        if left is None or 2.0 * left > self.swing.breaks_after(leg.time) - leg.time:
            return None, False
        return left, True
