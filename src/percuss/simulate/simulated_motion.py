"""A simulated motion: what happened, and where the bar is at any time."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from functools import cached_property
from itertools import pairwise
from typing import Any, Literal, Protocol

import numpy as np
import numpy.typing as npt

from percuss.errors import ParameterError
from percuss.model import System
from percuss.model.checks import Array, array, choice, count, finite
from percuss.shown import Shown
from percuss.simulate.events import (
    CHATTER,
    IMPACT,
    KINDS,
    RELEASE,
    REST,
    Cycle,
    Events,
    Summary,
    main_blows,
    summary_of,
)
from percuss.simulate.kernels.motion_records import LOST_CYCLE
from percuss.simulate.spectrum import Spectrum
from percuss.simulate.stop import MAX_MODES, MOST_IMPACTS, OUTCOMES, Stop

# ---- The motion in closed form from an event on, at any place and time: no engine, only the formulas of theory §2

_TURN = 2.0 * np.pi


class Oscillators(Protocol):
    """Damped oscillators, each array of shape (N,); a `Spectrum` is such."""

    @property
    def omega(self) -> Array: ...
    @property
    def damping(self) -> Array: ...
    @property
    def square(self) -> Array: ...
    @property
    def lam(self) -> Array: ...


@dataclass(frozen=True)
class Anchor:
    """The state at an instant of free motion.

    Parameters
    ----------
    phase, piece
        Load phase, and the number of the load's step that holds.
    gap, rigid_rate, z
        u(1), u_0' and the amplitudes of the free motion, shape (2, N).
    """

    phase: float
    piece: int
    gap: float
    rigid_rate: float
    z: Array


@dataclass(frozen=True)
class Modes:
    """u_n and u_n', n = 0 … N, at some times; each of shape (N+1, len(t))."""

    displacement: Array
    velocity: Array


def modal_motion(spectrum: Spectrum, anchor: Anchor, tau: Array) -> Modes:
    """The modes at the times `tau` ≥ 0, ascending, after an anchor, as long as the bar touches nothing."""
    load = spectrum.system.load
    if not load.is_piecewise:
        return _within(spectrum, anchor, tau)
    parts, done, gone = [], 0, 0.0
    while True:
        following = (anchor.piece + 1) % len(load.breaks)
        ahead = load.breaks[following] - anchor.phase
        ahead += _TURN if following == 0 and ahead < 0.0 else 0.0
        ahead = max(ahead, 0.0)
        stop = int(np.searchsorted(tau, gone + ahead, side="left"))
        last = done + stop - done == tau.size
        parts.append(_within(spectrum, anchor, tau[done:stop] - gone))
        if last:
            break
        anchor = _over_step(spectrum, anchor, ahead, following)
        done, gone = stop, gone + ahead
    return Modes(
        np.concatenate([part.displacement for part in parts], axis=1),
        np.concatenate([part.velocity for part in parts], axis=1),
    )


def _within(spectrum: Spectrum, anchor: Anchor, tau: Array) -> Modes:
    """Under one form of the load."""
    d, mean, k = spectrum.system.d, spectrum.mean(anchor.piece), spectrum.k
    turned = np.exp(1j * k * anchor.phase)
    waves = turned[:, None] * np.exp(1j * np.outer(k, tau))  # e^{ik(θ+τ)}, shape (K, T)
    start, _ = spectrum.modal(anchor.z, anchor.gap, anchor.rigid_rate, anchor.phase, mean)
    left, h, h_rate = free_motion(spectrum, tau)
    z0, w0 = anchor.z[0][:, None], spectrum.free_rate(anchor.z)[:, None]
    q = z0 * left + w0 * h
    rate = w0 * h_rate - z0 * (spectrum.omega[:, None] ** 2 * h)
    q = q + (spectrum.response.T @ waves).real + mean * spectrum.statics[:, None]
    rate = rate + ((1j * k[:, None] * spectrum.response).T @ waves).real

    if not spectrum.system.body.is_free:
        mean = 0.0
    first, second = drift(d, tau)
    drifting = anchor.rigid_rate - float(((1j * k * turned) @ spectrum.rigid).real)
    steps = turned[:, None] * _turn_less_one(np.outer(k, tau))
    u0 = start[0] + drifting * first + mean * second + (spectrum.rigid @ steps).real
    v0 = anchor.rigid_rate + (mean - d * drifting) * first + ((1j * k * spectrum.rigid) @ steps).real
    unit = spectrum.unit[:, None]
    return Modes(np.vstack([u0, q / unit]), np.vstack([v0, rate / unit]))


def _over_step(spectrum: Spectrum, anchor: Anchor, ahead: float, piece: int) -> Anchor:
    """The anchor at the next step of the load."""
    at = _within(spectrum, anchor, np.array([ahead]))
    u, v = at.displacement[:, 0], at.velocity[:, 0]
    phase = spectrum.system.load.breaks[piece]
    z = spectrum.amplitudes(u, v, phase, spectrum.mean(piece))
    return Anchor(phase, piece, float(u[0] + spectrum.unit @ u[1:]), float(v[0]), z)


def free_motion(spectrum: Oscillators, tau: Array) -> tuple[Array, Array, Array]:
    """e, h and h' of the free motion q = q(0) e + q'(0) h, q' = q'(0) h' − q(0) ω² h; each of shape (N, T)."""
    half, square = 0.5 * spectrum.damping[:, None], spectrum.square[:, None]
    t = tau[None, :]
    fade = np.exp(-half * t)
    lam = spectrum.lam[:, None]
    c, h = fade * np.cos(lam * t), fade * np.sin(lam * t) / lam
    e, rate = c + half * h, c - half * h
    over = spectrum.square <= 0.0
    if over.any():
        kappa = np.sqrt(-square[over])
        slow = spectrum.omega[over, None] ** 2 / (half[over] + kappa)  # d/2 − κ
        fade, safe = np.exp(-slow * t), np.where(kappa > 0.0, kappa, 1.0)
        h[over] = fade * np.where(kappa > 0.0, -np.expm1(-2.0 * kappa * t) / (2.0 * safe), t)
        e[over] = fade + slow * h[over]
        rate[over] = fade * np.exp(-2.0 * kappa * t) - slow * h[over]
    return e, h, rate


def drift(d: float, tau: Array) -> tuple[Array, Array]:
    """(1 − e^{−dτ})/d and its integral, for any d ≥ 0."""
    x = d * tau
    small = x < 0.5
    series = np.zeros_like(x)
    for k in range(18, 0, -1):  # Σ (−x)^j/(j+2)!
        series = (1.0 - x * series) / (k + 1.0)
    series = np.where(small, series, 0.0)
    first = np.where(small, tau * (1.0 - x * series), -np.expm1(-x) / (d if d else 1.0))
    return first, np.where(small, tau**2 * series, (tau - first) / (d if d else 1.0))


def _turn_less_one(angle: Array) -> Array:
    """e^{iα} − 1 without cancellation."""
    half = np.sin(0.5 * angle)
    return np.asarray(-2.0 * half * half + 1j * np.sin(angle))


# ---- A simulated motion: what happened, and where the bar is at any time

Side = Literal["left", "right"]


@dataclass(frozen=True)
class SimulatedMotion(Shown):
    """What a simulation has left, and all that is read off it; `Trajectory` says what each of its parts is."""

    system: System
    modes: int
    events: Events
    states: Array
    start: Anchor
    resting: bool
    snapshot: dict[str, npt.NDArray[np.generic]]
    outcome: str
    label: str
    cycle: Cycle | None
    stop: Stop
    begin_time: float
    end_time: float

    # -- what happened --

    @property
    def impacts(self) -> int:
        """The number of impacts."""
        return int(np.count_nonzero(self.events.code == IMPACT))

    @property
    def main_blows(self) -> npt.NDArray[np.bool_]:
        """Which impacts are main blows: a completed chatter counts once. Shape (impacts,)."""
        return main_blows(self.events)

    @property
    def period_unresolved(self) -> bool:
        """Whether the motion repeats, as it was released twice in the same state, in a time that hangs on rounding."""
        return self.cycle is None and unresolved(self.snapshot["count"]) > 0

    @cached_property
    def summary(self) -> Summary:
        """Blow rate, its scatter, energies; in SI besides for a system made from SI."""
        return summary_of(self.system, self.events, self.cycle, over=self.outcome in ("rest", "departed"))

    @property
    def transient(self) -> int | None:
        """Impacts before the periodic motion; None when none was found."""
        return None if self.cycle is None else self.cycle.first

    # -- the state --

    @cached_property
    def spectrum(self) -> Spectrum:
        """Frequencies and forced response of the modes."""
        return Spectrum(self.system, self.modes)

    def _anchor(self, i: int) -> Anchor:
        """The state after event number i; −1 is the start."""
        if i < 0:
            return self.start
        row, n = self.states[i], self.modes
        z = np.stack([row[2 : 2 + n], row[2 + n :]])
        return Anchor(float(self.events.phase[i]), int(self.events.piece[i]), float(row[0]), float(row[1]), z)

    def _at(self, i: int) -> tuple[Array, Array]:
        a = self._anchor(i)
        return self.spectrum.modal(a.z, a.gap, a.rigid_rate, a.phase, self.spectrum.mean(a.piece))

    @cached_property
    def _modal_states(self) -> tuple[Array, Array]:
        n, e = self.modes, self.events
        z = self.states[:, 2:].reshape(len(e), 2, n)
        values = np.asarray(self.system.load.values)
        mean = values[e.piece] if values.size else np.full(len(e), self.system.load.mean)
        return self.spectrum.modal(z, self.states[:, 0], self.states[:, 1], e.phase, mean)

    @property
    def displacement(self) -> Array:
        """u_n after each event, n = 0 … N; shape (events, N+1)."""
        return self._modal_states[0]

    @property
    def velocity(self) -> Array:
        """u_n' after each event, n = 0 … N; shape (events, N+1)."""
        return self._modal_states[1]

    def modal(self, t: npt.ArrayLike, side: Side = "right") -> Modes:
        """u_n(t) and u_n'(t), each of shape (N+1, len(t)).

        Parameters
        ----------
        t
            Times (rad) from `begin_time` to `end_time`.
        side
            At the time of an event: the state after it (``right``) or before it (``left``).

        Raises
        ------
        ParameterError
            For times outside the simulated ones.
        """
        choice("side", side, "left", "right")
        times = array("t", t, -np.inf, np.inf)
        if times.size and (times.min() < self.begin_time or times.max() > self.end_time):
            accepted = f"times from {self.begin_time:.6g} to {self.end_time:.6g}"
            raise ParameterError("t", f"{times.min():.6g} … {times.max():.6g}", accepted, "simulate for longer")
        order = np.argsort(times, kind="stable")
        ordered = times[order]
        last = np.searchsorted(self.events.time, ordered, side=side) - 1
        u, v = np.empty((self.modes + 1, times.size)), np.empty((self.modes + 1, times.size))
        for i in np.unique(last):
            here = np.flatnonzero(last == i)
            part = self._between(int(i), ordered[here])
            u[:, order[here]], v[:, order[here]] = part.displacement, part.velocity
        return Modes(u, v)

    def _between(self, i: int, times: Array) -> Modes:
        rests = self.events.code[i] == REST if i >= 0 else self.resting
        nothing = np.zeros((self.modes + 1, times.size))
        if rests and not self.system.body.is_free and i >= 0:  # as it was struck last
            return Modes(self._at(i)[0][:, None] + nothing, nothing)
        if rests:
            return Modes(nothing, nothing)
        if i + 1 < len(self.events) and self.events.code[i + 1] == CHATTER:
            return Modes(self._at(i)[0][:, None] + nothing, nothing)  # infinitely many bounces of less than 1e-9
        periods, phase = divmod(self.begin_time, _TURN) if i < 0 else (self.events.period[i], self.events.phase[i])
        return modal_motion(self.spectrum, self._anchor(i), np.maximum((times - periods * _TURN) - phase, 0.0))

    # -- fields --

    def position(self, x: npt.ArrayLike, t: npt.ArrayLike) -> Array:
        """u(x, t), with the wall at u = 0; shape (len(x), len(t))."""
        return self._shapes(x) @ self.modal(t).displacement

    def bar_velocity(self, x: npt.ArrayLike, t: npt.ArrayLike, side: Side = "right") -> Array:
        """u_t(x, t); shape (len(x), len(t))."""
        return self._shapes(x) @ self.modal(t, side).velocity

    def strain(self, x: npt.ArrayLike, t: npt.ArrayLike) -> Array:
        """u_x(x, t), negative in compression; shape (len(x), len(t)). 0 in a bar that rests on the wall.

        The free motion has N modes; the forced one is summed over all of them, so that −s² u_x(0, t) = p(t).
        """
        places, times = array("x", x, 0.0, 1.0), array("t", t, -np.inf, np.inf)
        slopes = self.system.body.shapes(places, self.modes).strain * self.spectrum.unit
        found = slopes @ self.modal(times).displacement[1:]
        load, flies = self.system.load, ~self._rests(times)
        steps = np.asarray(load.values)
        mean = steps[load.piece(times[flies])] if steps.size else np.full(int(flies.sum()), load.mean)
        found[:, flies] += self.spectrum.forced_strain_beyond(places, times[flies], mean)
        return np.asarray(found)

    def gap(self, t: npt.ArrayLike) -> Array:
        """Gap function y(t) = u(1, t): 0 at contact, negative between; shape (len(t),).

        After a release, for the time of one wave and as long as the load pulls, the ripple of a finite number of modes
        may show above 0.
        """
        return np.asarray(self.position(1.0, t)[0])

    def energy(self, t: npt.ArrayLike, side: Side = "right") -> Array:
        """Kinetic and elastic energy ½ ∫ u_t² dx + ½ s² ∫ u_x² dx of the bar; shape (len(t),)."""
        at = self.modal(t, side)
        weight = np.append(0.5, 0.5 * self.spectrum.weight)
        stiffness = 0.5 * self.spectrum.weight * self.spectrum.omega**2
        return np.asarray(weight @ at.velocity**2 + stiffness @ at.displacement[1:] ** 2)

    def contact_force(self, t: npt.ArrayLike) -> Array:
        """Force p(t) with which a bar that rests presses on the wall, quasi-static; 0 elsewhere. Shape (len(t),)."""
        times = array("t", t, self.begin_time, self.end_time)
        return np.where(self._rests(times), self.system.load.value(times), 0.0)

    def _rests(self, times: Array) -> npt.NDArray[np.bool_]:
        last = np.searchsorted(self.events.time, times, side="right") - 1
        codes = np.append(self.events.code, REST if self.resting else RELEASE)
        return np.asarray(codes[last] == REST)

    def _shapes(self, x: npt.ArrayLike) -> Array:
        places = array("x", x, 0.0, 1.0)
        shapes = self.system.body.shapes(places, self.modes).displacement * self.spectrum.unit
        return np.column_stack([np.ones(places.size), shapes])


def unresolved(count: npt.NDArray[Any]) -> int:
    """The kind of a cycle with rest whose number of load periods is lost, by the engine's whole numbers; else 0."""
    return int(count["cycle_kind"][0]) if count["verdict"][0] == LOST_CYCLE else 0


# ---- Where the energy of a simulated motion goes, by quadrature over its closed forms

_POINTS, _WEIGHTS = np.polynomial.legendre.leggauss(12)


@dataclass(frozen=True)
class EnergyBalance(Shown):
    """Energy between two instants; dimensionless.

    Attributes
    ----------
    input
        Work of the load.
    damping, impacts
        Taken by damping, and by impacts, chatter and rest.
    stored
        Rise of the kinetic and elastic energy of the bar.
    """

    input: float
    damping: float
    impacts: float
    stored: float

    @property
    def imbalance(self) -> float:
        """Input less damping, impacts and what is stored: 0 but for rounding."""
        return self.input - self.damping - self.impacts - self.stored


def energy_balance(motion: SimulatedMotion, first: float | None = None, last: float | None = None) -> EnergyBalance:
    """Energy between two times; see `Trajectory.energy_balance`."""
    begin = motion.begin_time if first is None else finite("first", first)
    end = motion.end_time if last is None else finite("last", last)
    if not motion.begin_time <= begin <= end <= motion.end_time:
        accepted = f"two times in order from {motion.begin_time:.6g} to {motion.end_time:.6g}"
        raise ParameterError("first, last", f"{begin:.6g}, {end:.6g}", accepted)
    times = motion.events.time
    inside = (times > begin) & (times <= end)
    edges = np.unique(np.concatenate([[begin], times[inside], _breaks(motion, begin, end), [end]]))
    fastest = max(float(motion.spectrum.k.max(initial=1.0)), float(motion.spectrum.omega.max(initial=0.0)))
    put_in = lost = 0.0
    at_load = motion.spectrum.elastic.at_load * motion.spectrum.unit
    damped = motion.spectrum.weight * motion.spectrum.damping
    for a, b in pairwise(edges):
        if b - a <= 1e-14 * max(abs(a), 1.0):
            continue
        t, w = panels(a, b, fastest, max(motion.system.d, float(motion.spectrum.damping.max(initial=0.0))))
        velocity = motion.modal(t).velocity
        driven = velocity[0] + at_load @ velocity[1:]
        put_in += float(w @ (np.asarray(motion.system.load.value(t)) * driven))
        lost += float(w @ (motion.system.d * velocity[0] ** 2 + damped @ velocity[1:] ** 2))
    taken = float(motion.events.energy_lost[inside].sum())
    stored = motion.energy(np.array([begin, end]))
    return EnergyBalance(put_in, lost, taken, float(stored[1] - stored[0]))


def _breaks(motion: SimulatedMotion, begin: float, end: float) -> Array:
    breaks = np.asarray(motion.system.load.breaks)
    if not breaks.size:
        return breaks
    turns = np.arange(np.floor(begin / _TURN), np.floor(end / _TURN) + 1) * _TURN
    every = (turns[:, None] + breaks[None, :]).reshape(-1)
    return np.asarray(every[(every > begin) & (every < end)])


def panels(a: float, b: float, fastest: float, d: float) -> tuple[Array, Array]:
    """Gauss's rule on panels of at most two radians of the fastest wave.

    What an impact or a step of the load leaves at `a` dies out at rates up to d, the drift and overdamped modes among
    them, and its square at 2d: from 1/d after `a` on the panels double until the waves bound them.
    """
    width = 2.0 / fastest
    first = min(1.0 / d, b - a) if d > 0.0 else width
    doublings = max(int(np.ceil(np.log2(width / first))), 0) if first < width else 0
    edges = a + np.concatenate([[0.0], first * 2.0 ** np.arange(doublings)])
    edges = edges[edges < b] if doublings else np.array([a])
    count = int(np.ceil((b - edges[-1]) / width)) + 1
    edges = np.concatenate([edges[:-1], np.linspace(edges[-1], b, count + 1)])
    left, wide = edges[:-1, None], np.diff(edges)[:, None]
    return (left + 0.5 * wide * (_POINTS + 1.0)).reshape(-1), (0.5 * wide * _WEIGHTS).reshape(-1)


# ---- What a saved motion must be before anything is made of it; of what it goes on from see
# `percuss.simulate.motion_files`
#
# A file may be cut short, changed by a bad disk, or made by somebody who means harm. Shapes and types follow from the
# number of modes; whole numbers that are used as places in an array must be places in it; all others must be finite,
# and where they count something, no less than 0. Impacts must obey the impact law.

_MOST = 1e100
"""No number of a motion is greater: its square must not overflow."""

MOST_PERIODS = 2**53
_ROUNDING = 1e-9
TURN = 2.0 * math.pi
_EVENT_TYPES = {"code": np.int8, "period": np.int64, "resolved": np.int64, "piece": np.int64}
"""Of the columns of events; the others are float64."""


def sound(motion: SimulatedMotion) -> None:
    """Refuse a motion of which not all can be what a simulation has left.

    Raises
    ------
    ValueError
        Which says what cannot be.
    """
    modes = count("modes", motion.modes, least=0, most=MAX_MODES)
    true(motion.outcome in OUTCOMES, f"outcome {str(motion.outcome)[:40]!r}")
    true(isinstance(motion.label, str) and len(motion.label) <= 100, "label")
    true(isinstance(motion.resting, bool), "resting")
    begin, end = finite("begin_time", motion.begin_time), finite("end_time", motion.end_time)
    true(begin <= end, "end_time")
    pieces = max(len(motion.system.load.values), 1)
    _start(motion.start, modes, pieces)
    _events(motion.events, pieces)
    numbers("state", motion.states, (len(motion.events), 2 + 2 * modes))
    _impacts(motion)
    impacts = int(np.count_nonzero(motion.events.code == IMPACT))
    _cycle(motion.cycle, impacts)


def true(good: object, what: str) -> None:
    """Refuse what does not hold."""
    if not good:
        raise ValueError(f"{what} is impossible")


def shaped(name: str, values: npt.NDArray[Any], dtype: npt.DTypeLike, shape: tuple[int, ...]) -> None:
    """Refuse another type or shape."""
    true(isinstance(values, np.ndarray) and values.dtype == np.dtype(dtype), f"the type of {name}")
    true(values.shape == shape, f"the shape {values.shape} of {name}")


def numbers(name: str, values: npt.NDArray[Any], shape: tuple[int, ...]) -> None:
    """Refuse what is not an array of finite numbers of this shape."""
    shaped(name, values, np.float64, shape)
    true(np.all(np.abs(values) <= _MOST), f"a value of {name}")  # false of NaN too


def within(name: str, values: npt.ArrayLike, low: float, high: float) -> None:
    """Refuse numbers outside of an interval, and NaN."""
    array = np.asarray(values)
    true(np.all((array >= low) & (array <= high)), f"a value of {name}")


def _start(start: Anchor, modes: int, pieces: int) -> None:
    within("start_phase", finite("start_phase", start.phase), 0.0, TURN)
    count("start_piece", start.piece, least=0, most=pieces - 1)
    numbers("start_state", np.array([start.gap, start.rigid_rate]), (2,))
    numbers("start_state", start.z, (2, modes))


def _events(events: Events, pieces: int) -> None:
    shape = np.shape(events.code)
    true(len(shape) == 1, "the shape of code")
    for field in fields(Events):
        values = getattr(events, field.name)
        if field.name in _EVENT_TYPES:
            shaped(field.name, values, _EVENT_TYPES[field.name], shape)
        else:
            numbers(field.name, values, shape)
    within("code", events.code, 0, len(KINDS) - 1)
    within("period", events.period, -MOST_PERIODS, MOST_PERIODS)
    within("phase", events.phase, 0.0, TURN)
    within("resolved", events.resolved, 0, MOST_IMPACTS)
    within("piece", events.piece, 0, pieces - 1)
    true(np.all(np.diff(events.time) >= 0.0), "the order of the events")


def _impacts(motion: SimulatedMotion) -> None:
    """The impact law, B77 10, and the wall: what it takes, how fast the end leaves, that nothing is beyond it."""
    contact, events, at = motion.system.contact, motion.events, motion.events.code == IMPACT
    beta = contact.velocity_factor
    speed, blow, most = events.impact_velocity[at], events.kinetic_energy[at], 1.0 + _ROUNDING
    true(np.all(speed >= 0.0) and np.all(blow >= 0.0), "the speed of an impact")
    true(np.all(np.abs(events.rebound_velocity[at] - beta * speed) <= _ROUNDING * speed), "the rebound of an impact")
    taken = (
        events.energy_lost[at] - contact.energy_taken(1.0, 0.0) * blow
    )  # by the strain, where the impact turns it over
    true(np.all((-np.abs(taken) if contact.keeps_strain else taken) >= -_ROUNDING * blow), "what an impact takes")
    true(np.all(events.energy_lost >= 0.0) and not np.any(events.kinetic_energy[~at]), "the energy of an event")
    place, rigid = motion.states[:, 0], motion.states[:, 1]
    noise = _ROUNDING * np.abs(motion.states).max(initial=0.0)
    true(not np.any(place[at]) and np.all(place <= noise), "the place of an event")
    true(np.all(np.abs(rigid[at]) <= most * abs(beta) * np.sqrt(2.0 * blow)), "the mean velocity after an impact")


def _cycle(cycle: Cycle | None, impacts: int) -> None:
    if cycle is None:
        return
    count("first", cycle.first, least=0, most=impacts)
    count("impacts", cycle.impacts, least=1, most=max(impacts, 1))
    count("periods", cycle.periods, least=0, most=MOST_PERIODS)
    count("kind", cycle.kind, least=0, most=2)
