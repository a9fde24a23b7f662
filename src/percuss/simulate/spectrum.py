"""The body cut at mode N under its load, as plain arrays: frequencies, forced response, and the state in two forms."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from percuss.errors import ResonanceError
from percuss.mechanics.flow import propagator, series
from percuss.model import HeldBody, System
from percuss.model.body import Modes
from percuss.model.checks import Array, ComplexArray

# ---- What damping makes of elastic modes: which of them swing, and how fast

# A mode with d_n/2 beyond this part of ω_n is treated as if overdamped: its amplitude and phase lose their meaning
_NEARLY_OVERDAMPED = 0.95


class DampedModes:
    """Elastic modes with frequencies ω_n and damping d_n, which those who inherit give: as fields, or computed."""

    if TYPE_CHECKING:  # a property here would be in the way of a field

        @property
        def omega(self) -> Array: ...
        @property
        def damping(self) -> Array: ...
        @property
        def statics(self) -> Array: ...
        @property
        def unit(self) -> Array: ...
        @property
        def inertia(self) -> Array: ...

    @cached_property
    def square(self) -> Array:
        """λ_n² = ω_n² − d_n²/4, negative where overdamped; shape (N,)."""
        half = 0.5 * self.damping
        return np.asarray((self.omega - half) * (self.omega + half))

    @cached_property
    def lam(self) -> Array:
        """λ_n, and 1 where overdamped; shape (N,)."""
        return np.sqrt(np.where(self.square > 0.0, self.square, 1.0))

    @cached_property
    def creeps(self) -> npt.NDArray[np.bool_]:
        """Which modes are overdamped or nearly so: the kernels keep their state in another form; shape (N,)."""
        return np.asarray(0.5 * self.damping > _NEARLY_OVERDAMPED * self.omega)


# ---- The body cut at mode N under its load, as plain arrays: frequencies, forced response, and the state in two forms

# Where a load at a node of a mode does not move it, B77's u_n would be of no use
_NODE = 1e-12
# Forced amplitudes this much larger than off resonance would leave no digit of an impact's time
_RESONANT = 1e10


@dataclass(frozen=True)
class Spectrum(DampedModes):
    """Modes 1 … N of a system as q_n = γ_n u_n, what mode n adds to the gap; ResonanceError at an own frequency."""

    system: System
    modes: int

    def __post_init__(self) -> None:
        near = (np.abs(self.stiffness) * _RESONANT < (self.k**2)[:, None]) & (self.pk != 0.0)[:, None]
        if near.any():
            i, n = np.argwhere(near)[0]
            raise ResonanceError(int(self.k[i]), int(n) + 1)

    # -- the modes --

    @cached_property
    def elastic(self) -> Modes:
        """The body's modes 1 … N under the load."""
        return self.system.body.modes(self.modes, self.system.load.at)

    @property
    def omega(self) -> Array:
        """ω_n, shape (N,)."""
        return self.elastic.omega

    @property
    def damping(self) -> Array:
        """d_n, shape (N,)."""
        return self.elastic.damping

    @property
    def inertia(self) -> Array:
        """What q_n'²/2 is multiplied by to be the kinetic energy of mode n; shape (N,)."""
        return self.elastic.inertia

    @cached_property
    def unit(self) -> Array:
        """q_n of u_n = 1; shape (N,)."""
        return units(self.elastic)

    @property
    def weight(self) -> Array:
        """What half u_n'² is multiplied by to be the kinetic energy of mode n; shape (N,)."""
        return np.asarray(self.elastic.inertia * self.unit**2)

    @cached_property
    def statics(self) -> Array:
        """q_n under a constant unit load; shape (N,)."""
        return np.asarray(self.elastic.gamma / self.omega**2)

    # -- the load --

    @cached_property
    def pk(self) -> ComplexArray:
        """p_1 … p_K, shape (K,); none for a load of exact steps."""
        load = self.system.load
        pk = np.asarray(load.coefficients[1:])
        if load.is_piecewise or not pk.any():
            return np.zeros(0, dtype=complex)
        return pk[: int(np.flatnonzero(pk)[-1]) + 1]

    @cached_property
    def k(self) -> Array:
        """1 … K as floats, shape (K,)."""
        return np.arange(1.0, self.pk.size + 1.0)

    @cached_property
    def stiffness(self) -> ComplexArray:
        """ω_n² + ikd_n − k², shape (K, N)."""
        return np.asarray(self.elastic.stiffness(self.k).T)

    @cached_property
    def response(self) -> ComplexArray:
        """Complex amplitude of q_n under harmonic k; shape (K, N)."""
        pk = self.pk[:, None]
        return np.asarray(self.elastic.gamma[None, :] * pk / np.where(pk == 0.0, 1.0, self.stiffness))

    @cached_property
    def rigid(self) -> ComplexArray:
        """Complex amplitude of u_0 under harmonic k; shape (K,)."""
        if not self.system.body.is_free:
            return np.zeros(self.k.shape, dtype=complex)
        return np.asarray(self.pk / (1j * self.k * self.system.d - self.k**2))

    @cached_property
    def gap(self) -> ComplexArray:
        """Complex amplitude of the gap function under harmonic k; shape (K,)."""
        return np.asarray(self.rigid + self.response.sum(axis=1))

    def mean(self, piece: int) -> float:
        """The constant part of the load: its mean, or the value of the step number `piece`."""
        load = self.system.load
        return load.values[piece] if load.is_piecewise else load.mean

    def forced(self, phase: npt.ArrayLike, mean: npt.ArrayLike) -> tuple[Array, Array]:
        """q_n and q_n' of the forced motion at load phases; each of the shape of `phase`, and (N,) behind."""
        phases = np.asarray(phase, dtype=float)
        turned = np.exp(1j * self.k * phases[..., None])
        shape = (turned @ self.response).real + np.asarray(mean)[..., None] * self.statics
        return np.asarray(shape), np.asarray(((1j * self.k * turned) @ self.response).real)

    def forced_strain_beyond(self, x: Array, phase: Array, mean: Array) -> Array:
        """Strain of the forced motion in the modes above N, as the closed form has it (theory §2); (x, phase)."""
        body, at = self.system.body, self.system.load.at
        static = body.static(x, at).strain - body.static(x, at, self.modes).strain
        with np.errstate(all="ignore"):
            whole = body.receptance(self.k, x, at).strain - body.receptance(self.k, x, at, self.modes).strain
        clear = np.isfinite(whole) & (np.abs(whole) < _RESONANT)  # else a mode above N is in resonance
        beyond = np.where(clear, whole, 0.0).T * self.pk
        return np.asarray(static[:, None] * mean + (beyond @ np.exp(1j * np.outer(self.k, phase))).real)

    # -- the state in two forms: B77's u_n, u_n', and the kernels' amplitudes of the free motion --

    def amplitudes(self, displacement: Array, velocity: Array, phase: float, mean: float) -> Array:
        """Amplitudes z of the free motion, shape (2, N), from u_n and u_n', n = 0 … N, each of shape (N+1,)."""
        shape, rate = self.forced(phase, mean)
        q = self.unit * displacement[1:] - shape
        w = self.unit * velocity[1:] - rate
        return np.stack([q, np.where(self.creeps, w, -(w + 0.5 * self.damping * q) / self.lam)])

    def free_rate(self, z: Array) -> Array:
        """q_n'(0) of the free motion from its amplitudes z, shape (…, 2, N): creeping modes keep it as it is."""
        oscillating = -self.lam * z[..., 1, :] - 0.5 * self.damping * z[..., 0, :]
        return np.asarray(np.where(self.creeps, z[..., 1, :], oscillating))

    def modal(
        self, z: Array, gap: npt.ArrayLike, rigid_rate: npt.ArrayLike, phase: npt.ArrayLike, mean: npt.ArrayLike
    ) -> tuple[Array, Array]:
        """u_n and u_n', n = 0 … N, from the kernels' form of one state or many, z of (…, 2, N), the others of (…)."""
        shape, rate = self.forced(phase, mean)
        q, w = z[..., 0, :] + shape, self.free_rate(z) + rate
        first = np.asarray(gap) - q.sum(axis=-1)
        displacement = np.concatenate([first[..., None], q / self.unit], axis=-1)
        return displacement, np.concatenate([np.asarray(rigid_rate)[..., None], w / self.unit], axis=-1)


@lru_cache(maxsize=16)
def spectrum_of(system: System, modes: int) -> Spectrum:
    """That of a system, kept for its next motion."""
    return Spectrum(system, modes)


def units(modes: Modes) -> Array:
    """q_n of u_n = 1, γ_n, shape (N,); for a load at a node of a mode, as if it were at the striking end."""
    return np.where(np.abs(modes.at_load) > _NODE, modes.gamma, 1.0 / modes.inertia)


# ---- Bodies that are held


def state_of(body: HeldBody, at: int, modes: int, u: Array, v: Array, gap: Array) -> tuple[Array, Array]:
    """u_n and u_n', n = 0 … N, of starts of a structure; each of shape (starts, N + 1), u_0 = −g and u_0' = 0."""
    # `u`, `v` are rows of the modes 0 … N, of which the first numbers do not count; or rows of one number, for which
    # the structure is bent by a force at its contact until this is at `gap`, (starts,), and moves with the speed v.
    found = np.zeros((2, gap.size, modes + 1))
    if u.shape[1] == 1:
        shape = body.bent(modes, at)
        found[0, :, 1:] = (gap + body.gap)[:, None] * shape
        found[1, :, 1:] = v[:, :1] * shape
    else:
        for rows, given in zip(found, (u, v), strict=True):
            size = min(given.shape[1], modes + 1)
            rows[:, 1:size] = given[:, 1:size]
    found[0, :, 0] = -body.gap
    return found[0], found[1]


# ---- A motion in closed form from an event on, at any time: no engine, only the formulas of theory §2

_TURN = 2.0 * np.pi
_POINTS, _WEIGHTS = np.polynomial.legendre.leggauss(12)


@dataclass(frozen=True)
class Anchor:
    """The state at an instant of free motion; `row`: u(1), u_0', free amplitudes, a supply's charge, as the engine."""

    phase: float
    piece: int
    row: Array


@dataclass(frozen=True)
class ModalMotion:
    """u_n and u_n', n = 0 … N, at some times; each of shape (N+1, len(t))."""

    displacement: Array
    velocity: Array


@dataclass(frozen=True)
class Moment:
    """A motion at some times: load phases or times, the modes, the valve's states, and the pressure of a supply."""

    time: Array
    modes: ModalMotion
    piece: npt.NDArray[np.int64]
    pressure: Array | None


@dataclass(frozen=True)
class ClockedFlights:
    """What moves between two events, and what drives it: a system under its load. `Mechanism` is a machine's."""

    spectrum: Spectrum

    @property
    def system(self) -> System:
        return self.spectrum.system

    def states(self, rows: Array, phase: Array, piece: npt.NDArray[np.int64]) -> tuple[Array, Array]:
        """u_n and u_n' of states, each of shape (states, N+1)."""
        values = np.asarray(self.system.load.values)
        mean = values[piece] if values.size else np.full(len(rows), self.system.load.mean)
        z = rows[:, 2:].reshape(len(rows), 2, self.spectrum.modes)
        return self.spectrum.modal(z, rows[:, 0], rows[:, 1], phase, mean)

    def after(self, anchor: Anchor, tau: Array) -> ModalMotion:
        """The modes at the times `tau` ≥ 0, ascending, after an anchor, as long as the bar touches nothing."""
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
        return ModalMotion(
            np.concatenate([part.displacement for part in parts], axis=1),
            np.concatenate([part.velocity for part in parts], axis=1),
        )

    def _within(self, anchor: Anchor, tau: Array) -> ModalMotion:
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
        return ModalMotion(np.vstack([u0, q / unit]), np.vstack([v0, rate / unit]))

    def _over_step(self, anchor: Anchor, ahead: float, piece: int) -> Anchor:
        """The anchor at the next step of the load."""
        spectrum = self.spectrum
        at = self._within(anchor, np.array([ahead]))
        u, v = at.displacement[:, 0], at.velocity[:, 0]
        phase = spectrum.system.load.breaks[piece]
        z = spectrum.amplitudes(u, v, phase, spectrum.mean(piece))
        return Anchor(phase, piece, np.concatenate([[float(u[0] + spectrum.unit @ u[1:]), v[0]], z.reshape(-1)]))

    def force(self, at: Moment) -> Array:
        """The force on the driven end."""
        return np.asarray(self.system.load.value(at.time))

    @cached_property
    def _at_load(self) -> Array:
        return self.spectrum.elastic.at_load * self.spectrum.unit

    def put_in(self, at: Moment) -> Array:
        velocity = at.modes.velocity
        return np.asarray(self.force(at) * (velocity[0] + self._at_load @ velocity[1:]))

    def stored(self, at: Moment) -> Array | float:
        """Energy beside that of the bar."""
        return 0.0

    def lost(self, at: Moment) -> Array:
        """The power that damping takes."""
        damped, velocity = self.spectrum.weight * self.spectrum.damping, at.modes.velocity
        return np.asarray(self.system.d * velocity[0] ** 2 + damped @ velocity[1:] ** 2)

    @property
    def rates(self) -> tuple[float, float]:
        """The fastest frequency, and the greatest damping."""
        spectrum = self.spectrum
        fastest = max(float(spectrum.k.max(initial=1.0)), float(spectrum.omega.max(initial=0.0)))
        return fastest, max(self.system.d, float(spectrum.damping.max(initial=0.0)))

    def breaks(self, begin: float, end: float) -> Array:
        """Times between two others at which the load steps, without an event."""
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
    """Gauss's rule on panels of at most two radians of the fastest wave."""
    # What an impact or a step of the load leaves at `a` dies out at rates up to d, the drift and overdamped modes among
    # them, and its square at 2d: from 1/d after `a` on the panels double until the waves bound them.
    width = 2.0 / fastest
    first = min(1.0 / d, b - a) if d > 0.0 else width
    doublings = max(int(np.ceil(np.log2(width / first))), 0) if first < width else 0
    edges = a + np.concatenate([[0.0], first * 2.0 ** np.arange(doublings)])
    edges = edges[edges < b] if doublings else np.array([a])
    count = int(np.ceil((b - edges[-1]) / width)) + 1
    edges = np.concatenate([edges[:-1], np.linspace(edges[-1], b, count + 1)])
    left, wide = edges[:-1, None], np.diff(edges)[:, None]
    return (left + 0.5 * wide * (_POINTS + 1.0)).reshape(-1), (0.5 * wide * _WEIGHTS).reshape(-1)
