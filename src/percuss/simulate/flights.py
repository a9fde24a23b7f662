"""A motion in closed form from an event on, at any time: no engine, only the formulas of theory §2."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np
import numpy.typing as npt

from percuss.mechanics.flow import propagator, series
from percuss.model import System
from percuss.model.checks import Array
from percuss.simulate.spectrum import Spectrum

_TURN = 2.0 * np.pi
_POINTS, _WEIGHTS = np.polynomial.legendre.leggauss(12)


@dataclass(frozen=True)
class Anchor:
    """The state at an instant of free motion.

    Parameters
    ----------
    phase, piece
        Load phase, and the number of the load's step that holds; of a machine the time, and the valve's state.
    row
        The state in the form of the engine: u(1), u_0' and the two rows of amplitudes of the free motion.
    """

    phase: float
    piece: int
    row: Array


@dataclass(frozen=True)
class Modes:
    """u_n and u_n', n = 0 … N, at some times; each of shape (N+1, len(t))."""

    displacement: Array
    velocity: Array


class Moved(Protocol):
    """What is asked of a simulated motion."""

    def state(self, t: npt.ArrayLike) -> npt.NDArray[np.int64]: ...
    def pressure(self, t: npt.ArrayLike) -> Array: ...
    def modal(self, t: npt.ArrayLike) -> Modes: ...


class Flights(Protocol):
    """What moves between two events, and what drives it: a system under a clock, or a machine."""

    def states(self, rows: Array, phase: Array, piece: npt.NDArray[np.int64]) -> tuple[Array, Array]:
        """u_n and u_n' of states, each of shape (states, N+1)."""
        ...

    def after(self, anchor: Anchor, tau: Array) -> Modes:
        """The modes at the times `tau` ≥ 0, ascending, after an anchor, as long as the bar touches nothing."""
        ...

    def force(self, motion: Moved, t: Array) -> Array:
        """The force on the driven end."""
        ...

    def put_in(self, motion: Moved, t: Array, velocity: Array) -> Array:
        """The power that is put in, from the velocities of the modes."""
        ...

    def stored(self, motion: Moved, t: Array, displacement: Array) -> Array | float:
        """Energy beside that of the bar."""
        ...

    def lost(self, motion: Moved, t: Array, velocity: Array) -> Array:
        """The power that damping takes."""
        ...

    @property
    def rates(self) -> tuple[float, float]:
        """The fastest frequency, and the greatest damping."""
        ...

    def breaks(self, begin: float, end: float) -> Array:
        """Times between two others at which the load steps, without an event."""
        ...


@dataclass(frozen=True)
class ClockedFlights:
    """A system under its load."""

    spectrum: Spectrum

    @property
    def system(self) -> System:
        """What moves."""
        return self.spectrum.system

    def states(self, rows: Array, phase: Array, piece: npt.NDArray[np.int64]) -> tuple[Array, Array]:
        """See `Flights`."""
        values = np.asarray(self.system.load.values)
        mean = values[piece] if values.size else np.full(len(rows), self.system.load.mean)
        z = rows[:, 2:].reshape(len(rows), 2, self.spectrum.modes)
        return self.spectrum.modal(z, rows[:, 0], rows[:, 1], phase, mean)

    def after(self, anchor: Anchor, tau: Array) -> Modes:
        """See `Flights`."""
        load = self.system.load
        if not load.is_piecewise:
            return self._within(anchor, tau)
        parts, done, gone = [], 0, 0.0
        while True:
            following = (anchor.piece + 1) % len(load.breaks)
            ahead = load.breaks[following] - anchor.phase
            ahead += _TURN if following == 0 and ahead < 0.0 else 0.0
            ahead = max(ahead, 0.0)
            stop = int(np.searchsorted(tau, gone + ahead, side="left"))
            parts.append(self._within(anchor, tau[done:stop] - gone))
            if stop == tau.size:
                break
            anchor = self._over_step(anchor, ahead, following)
            done, gone = stop, gone + ahead
        return Modes(
            np.concatenate([part.displacement for part in parts], axis=1),
            np.concatenate([part.velocity for part in parts], axis=1),
        )

    def _within(self, anchor: Anchor, tau: Array) -> Modes:
        """Under one form of the load."""
        spectrum, z = self.spectrum, anchor.row[2:].reshape(2, -1)
        d, mean, k = spectrum.system.d, spectrum.mean(anchor.piece), spectrum.k
        turned = np.exp(1j * k * anchor.phase)
        waves = turned[:, None] * np.exp(1j * np.outer(k, tau))  # e^{ik(θ+τ)}, shape (K, T)
        gap, rigid_rate = float(anchor.row[0]), float(anchor.row[1])
        start, _ = spectrum.modal(z, gap, rigid_rate, anchor.phase, mean)
        step = propagator(spectrum.omega[:, None], spectrum.damping[:, None], tau)
        z0, w0 = z[0][:, None], spectrum.free_rate(z)[:, None]
        q = z0 * step.a + w0 * step.b
        rate = z0 * step.c + w0 * step.e
        q = q + (spectrum.response.T @ waves).real + mean * spectrum.statics[:, None]
        rate = rate + ((1j * k[:, None] * spectrum.response).T @ waves).real

        if not spectrum.system.body.is_free:
            mean = 0.0
        _, first, second, _ = series(tau, float(tau.max(initial=0.0)), 0.0, d)
        drifting = rigid_rate - float(((1j * k * turned) @ spectrum.rigid).real)
        steps = turned[:, None] * _turn_less_one(np.outer(k, tau))
        u0 = start[0] + drifting * first + mean * second + (spectrum.rigid @ steps).real
        v0 = rigid_rate + (mean - d * drifting) * first + ((1j * k * spectrum.rigid) @ steps).real
        unit = spectrum.unit[:, None]
        return Modes(np.vstack([u0, q / unit]), np.vstack([v0, rate / unit]))

    def _over_step(self, anchor: Anchor, ahead: float, piece: int) -> Anchor:
        """The anchor at the next step of the load."""
        spectrum = self.spectrum
        at = self._within(anchor, np.array([ahead]))
        u, v = at.displacement[:, 0], at.velocity[:, 0]
        phase = spectrum.system.load.breaks[piece]
        z = spectrum.amplitudes(u, v, phase, spectrum.mean(piece))
        return Anchor(phase, piece, np.concatenate([[float(u[0] + spectrum.unit @ u[1:]), v[0]], z.reshape(-1)]))

    def force(self, motion: Moved, t: Array) -> Array:
        """See `Flights`."""
        return np.asarray(self.system.load.value(t))

    @cached_property
    def _at_load(self) -> Array:
        return self.spectrum.elastic.at_load * self.spectrum.unit

    def put_in(self, motion: Moved, t: Array, velocity: Array) -> Array:
        """See `Flights`."""
        return np.asarray(self.force(motion, t) * (velocity[0] + self._at_load @ velocity[1:]))

    def stored(self, motion: Moved, t: Array, displacement: Array) -> Array | float:
        """See `Flights`."""
        return 0.0

    def lost(self, motion: Moved, t: Array, velocity: Array) -> Array:
        """See `Flights`."""
        damped = self.spectrum.weight * self.spectrum.damping
        return np.asarray(self.system.d * velocity[0] ** 2 + damped @ velocity[1:] ** 2)

    @property
    def rates(self) -> tuple[float, float]:
        """See `Flights`."""
        spectrum = self.spectrum
        fastest = max(float(spectrum.k.max(initial=1.0)), float(spectrum.omega.max(initial=0.0)))
        return fastest, max(self.system.d, float(spectrum.damping.max(initial=0.0)))

    def breaks(self, begin: float, end: float) -> Array:
        """See `Flights`."""
        breaks = np.asarray(self.system.load.breaks)
        if not breaks.size:
            return breaks
        turns = np.arange(np.floor(begin / _TURN), np.floor(end / _TURN) + 1) * _TURN
        every = (turns[:, None] + breaks[None, :]).reshape(-1)
        return np.asarray(every[(every > begin) & (every < end)])


# ---- The rule by which they are integrated


def _turn_less_one(angle: Array) -> Array:
    """e^{iα} − 1 without cancellation."""
    half = np.sin(0.5 * angle)
    return np.asarray(-2.0 * half * half + 1j * np.sin(angle))


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
