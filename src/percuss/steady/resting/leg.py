"""A stretch of free flight under a load without jumps, told by how far the striking end has come since its start.

The gap function is y'(0) t and what bends it: every part of that is exact to rounding of its own size, however short
the time. The ever shorter flights of a chatter then keep their digits.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from percuss.halting import look
from percuss.model import Modes, System
from percuss.model.checks import Array, ComplexArray
from percuss.steady.harmonic import HarmonicResponse
from percuss.steady.oscillator import phi1, phi2, propagator
from percuss.steady.resonance import refuse_resonance

__all__ = ["Leg", "Motion", "Swing"]

_FEW = 8  # harmonics, of which a loop is faster than arrays


class Motion(NamedTuple):
    """The gap and its rate, the velocity of the bar as a whole, and u_n, u_n' of its elastic modes."""

    gap: float
    rate: float
    rigid: float
    displacement: Array
    velocity: Array


@dataclass(frozen=True)
class Swing:
    """What the load does to a bar of modes 0 … N, whatever its motion; or to the one mode of a structure at its wall.

    Parameters
    ----------
    system, modes
        The system, and N.
    """

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
        """What each harmonic moves each elastic mode; shape (N, K)."""
        if not self.harmonics.size:
            return np.empty((self.modes, 0), dtype=complex)
        response = HarmonicResponse(self.system)
        return np.asarray(response.gains(self.modes) * response.p)

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
        return np.asarray(whole + self.known.gamma @ self.gains) if self.modes else whole

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
class Leg:
    """A flight from a time on, under a load without jumps.

    Parameters
    ----------
    swing
        The system.
    time
        When it starts, in rad of the load.
    start
        The motion then.
    """

    swing: Swing
    time: float
    start: Motion

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
        forced = self.push / swing.known.omega**2 + waves.real.sum(axis=1)
        rate = (waves * (1j * swing.harmonics)).real.sum(axis=1)
        return start.displacement - forced, start.velocity - rate

    @cached_property
    def drift(self) -> float:
        """Velocity of the bar as a whole at the start, but for what the harmonics make of it."""
        return self.start.rigid - float((self.swing.rigid * self.turned).real.sum())

    @property
    def rate(self) -> float:
        """Velocity of the striking end at the start."""
        return self.start.rate

    @cached_property
    def acceleration(self) -> float:
        """Acceleration of the striking end just after the start."""
        swing, (z, rate) = self.swing, self.free
        known, k = swing.known, swing.harmonics
        waves = float((-(k**2) * swing.end * self.turned).real.sum())
        elastic = float(known.gamma @ (-(known.omega**2) * z - known.damping * rate))
        return self.whole - swing.system.d * self.drift + waves + elastic

    @cached_property
    def ringing(self) -> Array:
        """Bound of what each free elastic mode moves the striking end; shape (N,)."""
        z, rate = self.free
        return np.asarray(np.abs(self.swing.known.gamma) * np.hypot(z, rate / self.swing.known.omega))

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
        look()
        swing, d = self.swing, self.swing.system.d
        fade, force = t * phi1(d * t), self.whole - d * self.drift
        y, v = self.start.rate * t + force * t**2 * phi2(d * t), self.start.rate + force * fade
        if swing.harmonics.size:
            angle, amplitude = np.outer(t, swing.harmonics), swing.end * self.turned
            turned = np.sin(angle) + 1j * 2.0 * np.sin(0.5 * angle) ** 2  # (exp(ix) − 1)/i
            bent = _excess(angle) + 1j * 2.0 * np.sin(0.5 * angle) ** 2  # … − x
            y = y + (bent @ (1j * amplitude)).real
            v = v - (turned @ (swing.harmonics * amplitude)).real
        if swing.modes:
            known, (z, rate), time = swing.known, self.free, t[:, None]
            step, half = propagator(known.omega, known.damping, time), 0.5 * known.damping
            lost = np.expm1(-half * time) - step.versine
            y = y + ((lost + half * step.b) * z + self._bent(step.b, time) * rate) @ known.gamma
            v = v + (step.c * z + (lost - half * step.b) * rate) @ known.gamma
        return np.asarray(self.start.gap + y), np.asarray(v)

    def gap_at(self, t: float) -> tuple[float, float]:
        """Gap function and its velocity at a time since the start: as `gap`; sooner for a rigid bar."""
        swing, d = self.swing, self.swing.system.d
        if swing.modes or swing.harmonics.size > _FEW:
            y, v = self.gap(np.array([t]))
            return float(y[0]), float(v[0])
        look()
        fade, bend = (t, 0.5 * t * t) if d == 0.0 else (t * float(phi1(d * t)), t**2 * float(phi2(d * t)))
        force = self.push - d * self.drift
        height, speed = self.rate * t + force * bend, self.rate + force * fade
        for k, amplitude in self._waves:
            angle = k * t
            even = 2.0 * math.sin(0.5 * angle) ** 2
            height -= amplitude.imag * _excess_of(angle) + amplitude.real * even
            speed -= k * (amplitude.real * math.sin(angle) - amplitude.imag * even)
        return self.start.gap + height, speed

    @cached_property
    def _waves(self) -> list[tuple[float, complex]]:
        return list(zip(self.swing.harmonics.tolist(), (self.swing.end * self.turned).tolist(), strict=True))

    def _bent(self, b: Array, time: Array) -> Array:
        """Φ's b − t, without cancellation where the modes ring; shape (len(t), N)."""
        known = self.swing.known
        half = 0.5 * known.damping
        square = known.omega**2 - half**2
        rate = np.sqrt(np.abs(square))
        angle = np.where(square > 0.0, rate, 1.0) * time
        exact = np.expm1(-half * time) * b / np.exp(-half * time) + _excess(angle) / np.where(square > 0.0, rate, 1.0)
        return np.asarray(np.where((square > 0.0) & (half * time < 1.0), exact, b - time))

    def at(self, t: float) -> Motion:
        """The motion a time after the start."""
        swing, d = self.swing, self.swing.system.d
        gap, speed = (float(part[0]) for part in self.gap(np.array([t])))
        if not swing.modes:
            return Motion(gap, speed, speed, self.start.displacement, self.start.velocity)
        waves = np.exp(1j * swing.harmonics * t) * self.turned
        rigid = float((swing.rigid * waves).real.sum())
        rigid += self.drift * float(np.exp(-d * t)) + self.whole * t * float(phi1(d * t))
        known, (z, rate) = swing.known, self.free
        step = propagator(known.omega, known.damping, t)
        moved = swing.gains * waves
        forced = self.push / known.omega**2 + moved.real.sum(axis=1)
        forced_rate = (moved * (1j * swing.harmonics)).real.sum(axis=1)
        return Motion(gap, speed, rigid, step.a * z + step.b * rate + forced, step.c * z + step.e * rate + forced_rate)


def _excess_of(x: float) -> float:
    """The sine of x less x, exact for small x."""
    if abs(x) >= 1.0:
        return math.sin(x) - x
    y, series = x * x, 1.0
    for j in range(19, 3, -2):
        series = 1.0 - y * series / ((j - 1.0) * j)
    return -x * y / 6.0 * series


def _excess(x: Array) -> Array:
    """The sine of x less x, exact for small x."""
    small = np.abs(x) < 1.0
    y = np.where(small, x, 0.0) ** 2
    series = np.ones_like(y)
    for j in range(19, 3, -2):  # 1 − x²/20 + …, by Horner's rule
        series = 1.0 - y * series / ((j - 1.0) * j)
    return np.asarray(np.where(small, -x * y / 6.0 * series, np.sin(x) - x))
