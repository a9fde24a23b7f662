"""Forced response of the bar, whatever form its load has: by harmonics, or exactly between the breaks of steps.

Where a response is asked for `modes`, these are the modes of those of its sums that have no closed form; `cut` ends the
others there too. `is_smooth`: its modes fall off like 1/n³, and nothing rings, as the load does not jump.
"""

from __future__ import annotations

import math
from functools import cached_property, lru_cache
from itertools import pairwise
from typing import NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from percuss.halting import check_interrupted
from percuss.mechanics.flow import phi1, phi2, propagator
from percuss.model import Body, Modes, System
from percuss.model.checks import Array, ComplexArray
from percuss.steady.oscillator import free_sum, refuse_resonance
from percuss.steady.trigonometric import TURN, phases_of_waves, turns_of_waves

# ---- Forced response to a load given by harmonics: sums over all modes as the body has them (theory §4)

_AT_ONCE = 1 << 20  # harmonics × times
_KEPT_GAINS = 1 << 14  # numbers, modes × harmonics, of the tables that are kept
_LARGEST_MATRIX = 1 << 21  # harmonics × modes of one probe
_FEWEST, _MOST = 1024, 65536  # modes of a probe


class Field(NamedTuple):
    """Displacement, velocity and strain; equal shapes, dimensionless."""

    displacement: Array
    velocity: Array
    strain: Array


class HarmonicResponse:
    """Periodic motion under the harmonics p_k, without rigid drift; ResonanceError at an own frequency (B77 16)."""

    is_smooth = True

    def __init__(self, system: System) -> None:
        self.system = system
        self.k = system.load.harmonics.astype(float)
        self.p: ComplexArray = system.load.coefficients[system.load.harmonics]
        free = 1.0 if system.body.is_free else 0.0  # else there is no rigid motion
        self.rigid_factor: ComplexArray = free * self.p / (system.d + 1j * self.k)
        self._end: dict[int | None, tuple[ComplexArray, ComplexArray]] = {}
        refuse_resonance(system)

    def meeting(self, waves: ComplexArray) -> HarmonicResponse:
        """The same with another curve in place of its rigid velocity, for `percuss.steady.phases.Arcs`."""
        other = HarmonicResponse(self.system)
        other.rigid_factor = waves
        return other

    @property
    def by_harmonics(self) -> HarmonicResponse:
        """Itself; of another response that to the harmonics which the load keeps."""
        return self

    # -- rigid part --

    def rigid_velocity(self, theta: Array) -> Array:
        """v_f(θ), the periodic rigid velocity (theory §4); shape of `theta`."""
        return self._waves(theta, self.rigid_factor)

    def rigid_acceleration(self, theta: Array) -> Array:
        """v_f'(θ)."""
        return self._waves(theta, 1j * self.k * self.rigid_factor)

    def rigid_displacement(self, theta: Array) -> Array:
        """The periodic antiderivative of v_f with mean zero."""
        return self._waves(theta, self.rigid_factor / (1j * self.k))

    def rigid_bounds(self) -> tuple[float, float]:
        """Bounds of |v_f| and of the alternating force, which is none on a body that is held."""
        force = float(np.abs(self.p).sum()) if self.system.body.is_free else 0.0
        return float(np.abs(self.rigid_factor).sum()), force

    def force(self, theta: Array) -> Array:
        """p(θ) with its mean."""
        return self.system.load.mean + self._waves(theta, self.p)

    # -- where it meets a level --

    @cached_property
    def ends(self) -> Array:
        """The phases in [0, 2π), increasing, between which v_f is monotone: its critical points."""
        return turns_of_waves(self.k, self.rigid_factor)

    @property
    def flat(self) -> npt.NDArray[np.bool_]:
        """On which of the arcs that begin there v_f does not change but for rounding: nowhere."""
        return np.zeros(self.ends.shape, dtype=bool)

    def turning(self, velocities: Array) -> npt.NDArray[np.bool_]:
        """At which ends v_f turns round, from v_f there and a turn later at the first one: at all."""
        return np.ones(velocities.shape, dtype=bool)

    def phases_at(
        self, ends: Array, velocities: Array, arc: npt.NDArray[np.intp], level: Array, plain: bool = False
    ) -> Array:
        """The phase on each arc where v_f equals a level; `plain`: in plain numbers, which round otherwise."""
        return phases_of_waves(self.k, self.rigid_factor, ends, velocities, arc, level, plain)

    def slope_on(self, arc: int, theta: Array) -> Array:
        """v_f'(θ) on an arc, at its ends too."""
        return self.rigid_acceleration(theta)

    def plateau(self, phase: float) -> tuple[float, float] | None:
        """First and last phase of the arc around `phase` if v_f is flat there, or None."""
        return None

    # -- elastic part --

    def shapes(self, x: Array, modes: int | None = None) -> tuple[ComplexArray, ComplexArray]:
        """g_k(x), the motion per harmonic of the load, and its slope, of all modes or the first; shapes (K, len(x))."""
        found = self.system.body.receptance(self.k, x, self.system.load.at, modes)
        return found.displacement, found.strain

    def end_shape(self, modes: int | None = None) -> ComplexArray:
        """g_k(1) of all modes, or of the first ones; shape (K,). Not to be written into."""
        if modes is None:
            return _end_shape(self.system.body, self.system.load.at, self.k.tobytes())
        return self.system.body.modes(modes, self.system.load.at).gamma @ self.gains(modes)

    def driven_shape(self) -> ComplexArray:
        """The motion of the place where the load acts, per harmonic, of all modes; shape (K,)."""
        body, at = self.system.body, self.system.load.at
        return self.shapes(np.array([body.place(at)]))[0][:, 0]

    def gains(self, modes: int) -> ComplexArray:
        """1/(ω_n² + ik d_n − k²) of the modes n = 1 … `modes`; shape (modes, K). Not to be written into."""
        made = _known_gains if modes * self.k.size <= _KEPT_GAINS else _gains
        return made(self.system.body, self.k.tobytes(), modes)

    def elastic(self, x: Array, theta: Array, modes: int = 0, *, cut: bool = False) -> Field:
        """Elastic part of the forced motion with the mean's static shape, (x, θ); all modes, or the first `cut`."""
        kept = modes if cut else None
        shape, slope = self.shapes(x, kept)
        waves = self.p[:, None] * np.exp(1j * np.outer(self.k, theta))
        rise, bend = self.system.body.static(np.asarray(x, dtype=float), self.system.load.at, kept)
        mean = self.system.load.mean
        return Field(
            (shape.T @ waves).real + mean * rise[:, None],
            ((shape * (1j * self.k)[:, None]).T @ waves).real,
            (slope.T @ waves).real + mean * bend[:, None],
        )

    def end_motion(self, theta: Array, modes: int = 0, *, cut: bool = False) -> tuple[Array, Array]:
        """Forced displacement (but for a constant) and velocity of the striking end, rigid part and elastic part."""
        both, size = np.empty((theta.size, 2)), max(1, _AT_ONCE // self.k.size)
        multiplied = self._at_end(modes if cut else None)[0]
        for i in range(0, theta.size, size):  # else a thousand harmonics at all times would fill the memory
            check_interrupted()
            waves = np.exp(1j * np.outer(theta[i : i + size], self.k))
            both[i : i + size] = (waves @ multiplied).real
        return both[:, 0], both[:, 1]

    def end_velocity(self, theta: float, modes: int = 0, *, cut: bool = False) -> float:
        """Elastic part of the forced velocity of the striking end at one load phase; all modes, or the first ones."""
        return float((np.exp(1j * theta * self.k) @ self._at_end(modes if cut else None)[1]).real)

    def end_rates(self, modes: int = 0, *, cut: bool = False) -> tuple[float, float]:
        """Bounds of the second and third derivative of the striking end's forced elastic motion."""
        shapes, forced = np.abs(self.end_shape(modes if cut else None)), self.k**2 * np.abs(self.p)
        slope = float((self.k * np.abs(self.p)).sum())
        return float(forced @ shapes), float((self.k * forced) @ shapes) + slope

    def _at_end(self, modes: int | None) -> tuple[ComplexArray, ComplexArray]:
        """What multiplies exp(ikθ) there: in displacement and velocity, shape (K, 2); in elastic velocity, (K,)."""
        if modes not in self._end:
            elastic = self.p * self.end_shape(modes)
            whole = elastic + self.rigid_factor / (1j * self.k)
            self._end[modes] = np.stack([whole, 1j * self.k * whole], axis=1), 1j * self.k * elastic
        return self._end[modes]

    # -- one mode at a time --

    def modal(self, modes: int, theta: Array) -> tuple[Array, Array]:
        """(f_n, f_n') of the elastic modes n = 1 … `modes`, each of shape (modes, len(θ))."""
        gain = self.gains(modes)
        waves = self.p[:, None] * np.exp(1j * np.outer(self.k, theta))
        mean = self.system.load.mean / self.system.body.modes(modes).omega ** 2
        return (gain @ waves).real + mean[:, None], ((gain * (1j * self.k)) @ waves).real

    def modal_apart(self, modes: int, theta: Array) -> tuple[Array, Array]:
        """As `modal`, term by term in real numbers: the same bits alone and in a row, as no matrix product has."""
        gain = self.gains(modes)
        waves = self.p[:, None] * np.exp(1j * np.outer(self.k, theta))
        both = np.stack([waves, 1j * self.k[:, None] * waves], axis=1)  # displacement and velocity; (K, 2, len(θ))
        total = np.zeros((2, modes, waves.shape[1]))
        total[0] = (self.system.load.mean / self.system.body.modes(modes).omega ** 2)[:, None]
        for column, pair in zip(gain.T, both, strict=True):
            total += column.real[:, None] * pair.real[:, None, :]
            total -= column.imag[:, None] * pair.imag[:, None, :]
        return total[0], total[1]

    def modal_bounds(self, modes: int) -> tuple[Array, Array]:
        """Bounds over all phases of |f_n| and of |f_n'|; each of shape (modes,)."""
        gain, size = np.abs(self.gains(modes)), np.abs(self.p)
        still = abs(self.system.load.mean) / self.system.body.modes(modes).omega ** 2
        return still + gain @ size, gain @ (self.k * size)

    def displacement_tail(self, omega: float) -> float:
        """P with |f_n| ≤ P/ω_n² for every mode with ω_n ≥ `omega`; inf when that is too low."""
        room = 1.0 - float(np.abs(self.k * (self.k - 1j * self.system.d)).max()) / omega**2
        greatest = abs(self.system.load.mean) + float(np.abs(self.p).sum())
        return greatest / room if room > 0.0 else math.inf

    def modal_velocity_bound(self, theta: float, omega: float, damping: float) -> float:
        """P such that |f_n'(θ)| ≤ P/ω_n² for every mode with ω_n ≥ `omega`; inf when `omega` is too low for one."""
        # f_n' = p'/ω² + Re Σ ik p_k exp(ikθ) (k² − ikd) H_nk/ω², where d_n grows no faster than ω_n² from `damping` on.
        shift = np.abs(self.k * (self.k - 1j * damping))
        room = omega**2 - shift
        if np.any(room <= 0.0):
            return math.inf
        slope = abs(float((1j * self.k * self.p * np.exp(1j * self.k * theta)).real.sum()))
        return slope + float(np.sum(self.k * np.abs(self.p) * shift / room))

    def ringing(self, modes: int) -> Array:
        return np.zeros(modes)

    @property
    def most_modes(self) -> int:
        """As many as make a matrix of a bearable size."""
        return max(_FEWEST, min(_MOST, _LARGEST_MATRIX // max(1, self.k.size)))

    def _waves(self, theta: Array, factor: ComplexArray) -> Array:
        theta = np.asarray(theta, dtype=float)
        flat = np.exp(1j * np.outer(theta.reshape(-1), self.k)) @ factor
        return np.asarray(flat.real.reshape(theta.shape))


@lru_cache(maxsize=32)
def _end_shape(body: Body, at: int, k: bytes) -> ComplexArray:
    """g_k(1), which stays while R and the load's strength are moved; shape (K,)."""
    found = body.receptance(np.frombuffer(k), np.array([1.0]), at).displacement[:, 0]
    found.setflags(write=False)
    return found


def _gains(body: Body, k: bytes, modes: int) -> ComplexArray:
    found = np.asarray(1.0 / body.modes(modes).stiffness(np.frombuffer(k)), dtype=complex)
    found.setflags(write=False)
    return found


_known_gains = lru_cache(maxsize=16)(_gains)  # the same for every mean load, phase and contact law


# ---- Forced response to a piecewise-constant load, mode by mode without any Fourier series (theory §7)

_WHOLE = 64.0 * np.finfo(float).eps
_PROBED = 512  # the ringing after a jump falls off like 1/n²: more modes hardly help


class PiecewiseResponse:
    """The twin of HarmonicResponse between the breaks of a load: each mode swings about its static place."""

    is_smooth = False

    def __init__(self, system: System) -> None:
        refuse_resonance(system)
        self.system = system
        self.starts = np.asarray(system.load.breaks)
        self.values = np.asarray(system.load.values)
        self.lengths = np.diff(np.append(self.starts, self.starts[0] + TURN))
        self.pull = (self.values - system.load.mean) * (1.0 if system.body.is_free else 0.0)
        self._knots = (np.empty((self.starts.size, 0)), np.empty((self.starts.size, 0)))
        self._rigid_knots()

    def _rigid_knots(self) -> None:
        d, dx, pull = self.system.d, self.lengths, self.pull
        rest = TURN - np.cumsum(dx)  # from the end of each piece to the end of the turn
        # v(1 − E) = Σ pull·dx·[φ1(d dx) exp(−d rest)], from which Σ pull·dx = 0 is taken out so that d → 0 is smooth
        weight = -dx * phi2(d * dx) * np.exp(-d * rest) - rest * phi1(d * rest)
        v = float(np.sum(pull * dx * weight)) / (TURN * float(phi1(d * TURN)))
        velocities, positions, u = [], [], 0.0
        for force, length in zip(pull, dx, strict=True):
            velocities.append(v)
            positions.append(u)
            u += v * length * float(phi1(d * length)) + force * length**2 * float(phi2(d * length))
            v = v * math.exp(-d * length) + force * length * float(phi1(d * length))
        self.knot_velocity, self.knot_position = np.array(velocities), np.array(positions)
        areas = self.knot_position * dx + self._cubic(dx)
        self.mean_position = float(areas.sum()) / TURN

    def _cubic(self, dx: Array) -> Array:
        """∫ of the displacement over a piece, from its start, less its start value times the length."""
        d = self.system.d
        x = d * dx
        small = np.abs(x) < 0.3
        y = np.where(small, x, 0.0)
        phi3 = np.zeros_like(y)
        for j in range(15, 2, -1):  # 1/6 − x/24 + …
            phi3 = (1.0 - y * phi3) / j
        phi3 = np.where(small, phi3 / 2.0, (0.5 - phi2(x)) / np.where(small, 1.0, x))
        return np.asarray(self.knot_velocity * dx**2 * phi2(x) + self.pull * dx**3 * phi3)

    def locate(self, theta: Array, side: str = "right") -> tuple[npt.NDArray[np.intp], Array]:
        """Piece and time since its start of each phase."""
        piece = self.system.load.piece(theta, "left" if side == "left" else "right")
        since = np.mod(np.asarray(theta, dtype=float) - self.starts[piece], TURN)
        return piece, np.where(since > self.lengths[piece] + 1e-9, 0.0, since)

    # -- rigid part --

    def rigid_velocity(self, theta: Array) -> Array:
        """v_f(θ); shape of `theta`."""
        piece, since = self.locate(theta)
        d = self.system.d
        return np.asarray(self.knot_velocity[piece] * np.exp(-d * since) + self.pull[piece] * since * phi1(d * since))

    def rigid_acceleration(self, theta: Array, side: str = "right") -> Array:
        """v_f'(θ), one-sided at a jump."""
        piece, since = self.locate(theta, side)
        d = self.system.d
        start = self.pull[piece] - d * self.knot_velocity[piece]
        return np.asarray(start * np.exp(-d * since))

    def rigid_displacement(self, theta: Array) -> Array:
        """The periodic antiderivative of v_f with mean zero."""
        piece, since = self.locate(theta)
        d = self.system.d
        moved = self.knot_velocity[piece] * since * phi1(d * since) + self.pull[piece] * since**2 * phi2(d * since)
        return np.asarray(self.knot_position[piece] + moved - self.mean_position)

    def rigid_bounds(self) -> tuple[float, float]:
        """Bounds of |v_f| and of the alternating force; v_f is monotone between the breaks."""
        return float(np.abs(self.knot_velocity).max()), float(np.abs(self.pull).max())

    @cached_property
    def flat(self) -> npt.NDArray[np.bool_]:
        """On which pieces v_f does not change but for rounding; shape (pieces,)."""
        rate = np.abs(self.pull - self.system.d * self.knot_velocity)
        return np.asarray(rate * self.lengths <= 32.0 * np.finfo(float).eps * self.rigid_bounds()[0])

    def force(self, theta: Array) -> Array:
        """p(θ) with its mean, right-sided at a jump."""
        return self.system.load.value(theta)

    # -- where it meets a level --

    @property
    def ends(self) -> Array:
        """The breaks of the load."""
        return self.starts

    def turning(self, velocities: Array) -> npt.NDArray[np.bool_]:
        """At a break v_f has a kink, and may go on in its direction."""
        rise = np.where(self.flat, 0.0, np.sign(np.diff(velocities)))
        turning = np.roll(rise, 1) * rise < 0.0
        return np.append(turning, turning[0])

    def phases_at(
        self, ends: Array, velocities: Array, arc: npt.NDArray[np.intp], level: Array, plain: bool = False
    ) -> Array:
        """The phase on each piece where v_f equals a level between its ends."""
        d, v = self.system.d, self.knot_velocity[arc]
        x = d * (level - v) / (self.pull[arc] - d * v)  # v_f moves exponentially: 1 − exp(−dτ) = x
        with np.errstate(divide="ignore", invalid="ignore"):
            stretch = np.where(x == 0.0, 1.0, -np.log1p(-x) / np.where(x == 0.0, 1.0, x))
        return np.asarray(ends[arc] + (level - v) / (self.pull[arc] - d * v) * stretch)

    def slope_on(self, arc: int, theta: Array) -> Array:
        """v_f'(θ) on a piece, at its ends too."""
        return np.asarray(self.pull[arc] - self.system.d * self.rigid_velocity(theta))

    def plateau(self, phase: float) -> tuple[float, float] | None:
        """First and last phase of the piece around `phase` if v_f is flat there, or None."""
        piece = int(self.locate(np.array([phase]))[0][0])
        start = float(self.starts[piece])
        return (start, start + float(self.lengths[piece])) if self.flat[piece] else None

    # -- modes --

    def knots(self, modes: int) -> tuple[Array, Array]:
        """Departure from the static displacement, and velocity, of each mode at each piece's start; (pieces, modes)."""
        u, v = self._knots if self._knots[0].shape[1] >= modes else self._computed_knots(modes)
        if u.shape[1] > self._knots[0].shape[1]:
            self._knots = u, v
        return u[:, :modes], v[:, :modes]

    def _computed_knots(self, modes: int) -> tuple[Array, Array]:
        known = self.system.body.modes(modes)
        omega, d = known.omega, known.damping
        static = self.values[:, None] / omega**2
        steps = [propagator(omega, d, length) for length in self.lengths]
        jumps = static - np.roll(static, -1, axis=0)  # change of the departure at the end of each piece
        shift_u, shift_v = np.zeros_like(omega), np.zeros_like(omega)
        for step, jump in zip(steps, jumps, strict=True):
            shift_u, shift_v = (step.a * shift_u + step.b * shift_v + jump, step.c * shift_u + step.e * shift_v)
        whole = propagator(omega, d, TURN)
        # (I − Φ)⁻¹, with det(I − Φ) = (1 − h)² + 2 h(1 − cos λT), h = exp(−dT/2)
        loss = -np.expm1(-0.5 * d * TURN)
        det = loss**2 + 2.0 * whole.versine
        turning = _turning(known)  # whole swings in a turn that the load does not drive: any state comes back
        det = np.where(turning, 1.0, det)
        u = np.where(turning, 0.0, ((1.0 - whole.e) * shift_u + whole.b * shift_v) / det)
        v = np.where(turning, 0.0, (whole.c * shift_u + (1.0 - whole.a) * shift_v) / det)
        us, vs = [], []
        for step, jump in zip(steps, jumps, strict=True):
            us.append(u)
            vs.append(v)
            u, v = step.a * u + step.b * v + jump, step.c * u + step.e * v
        knot_u, knot_v = np.array(us), np.array(vs)
        if turning.any():
            own_u, own_v = self._own_swing(omega[turning], knot_u[:, turning], knot_v[:, turning])
            knot_u[:, turning] -= own_u
            knot_v[:, turning] -= own_v
        return knot_u, knot_v

    def _own_swing(self, omega: Array, knot_u: Array, knot_v: Array) -> tuple[Array, Array]:
        """What undriven modes swing at their own frequency, at the knots: not a part of the motion that is forced."""
        start = knot_u - 1j * knot_v / omega  # the departure of a piece is Re start·exp(iωt) from its begin
        length, back = self.lengths[:, None], np.exp(-1j * self.starts[:, None] * omega)
        other = np.conj(start) * -np.expm1(-2j * omega * length) / (2j * omega)
        swing = (back * (start * length + other)).sum(axis=0) / TURN
        here = swing / back
        return np.asarray(here.real), np.asarray((1j * omega * here).real)

    def modal(self, modes: int, theta: Array) -> tuple[Array, Array]:
        """(f_n, f_n') of the elastic modes n = 1 … `modes`, each of shape (modes, len(θ))."""
        piece, since = self.locate(np.asarray(theta, dtype=float).reshape(-1))
        known = self.system.body.modes(modes)
        knot_u, knot_v = self.knots(modes)
        step = propagator(known.omega[:, None], known.damping[:, None], since[None, :])
        u, v = knot_u[piece].T, knot_v[piece].T
        static = self.values[piece][None, :] / known.omega[:, None] ** 2
        return step.a * u + step.b * v + static, step.c * u + step.e * v

    modal_apart = modal

    def elastic(self, x: Array, theta: Array, modes: int, *, cut: bool = False) -> Field:
        """Elastic part of the forced motion by `modes` modes; the static shape in closed form unless `cut` as well."""
        x = np.asarray(x, dtype=float)
        theta = np.asarray(theta, dtype=float).reshape(-1)
        body, at = self.system.body, self.system.load.at
        rows = np.concatenate(body.driven_shapes(x, modes, at))
        rise, bend = body.static(x, at, modes if cut else None)
        force = self.force(theta)
        ring, speed = np.empty((rows.shape[0], theta.size)), np.empty((rows.shape[0], theta.size))
        piece, since = self.locate(theta)
        known = body.modes(modes, at)
        knots_u, knots_v = self.knots(modes)
        for here in _visits(piece):
            start = knots_u[piece[here][0]], knots_v[piece[here][0]]
            ring[:, here], speed[:, here] = free_sum(known.omega, known.damping, start, since[here], rows)
        half = x.size
        return Field(ring[:half] + np.outer(rise, force), speed[:half], ring[half:] + np.outer(bend, force))

    def end_motion(self, theta: Array, modes: int, *, cut: bool = False) -> tuple[Array, Array]:
        """Forced displacement (but for a constant) and velocity of the striking end, rigid part and elastic part."""
        elastic = self.elastic(np.array([1.0]), theta, modes, cut=cut)
        return (
            elastic.displacement[0] + self.rigid_displacement(theta),
            elastic.velocity[0] + self.rigid_velocity(theta),
        )

    def end_velocity(self, theta: float, modes: int, *, cut: bool = False) -> float:
        """Elastic part of the forced velocity of the striking end at one load phase."""
        return float(self.elastic(np.array([1.0]), np.array([theta]), modes, cut=cut).velocity[0, 0])

    def end_rates(self, modes: int, *, cut: bool = False) -> tuple[float, float]:
        """Nothing but ringing."""
        return 0.0, 0.0

    def modal_bounds(self, modes: int) -> tuple[Array, Array]:
        """Bounds over all phases of |f_n|, but for what rings, and of |f_n'|; each of shape (modes,)."""
        omega = self.system.body.modes(modes).omega
        u, v = self.knots(modes)
        return float(np.abs(self.values).max()) / omega**2, np.hypot(omega * u, v).max(axis=0)

    def displacement_tail(self, omega: float) -> float:
        """P with |f_n| ≤ P/ω_n², but for what rings."""
        return float(np.abs(self.values).max())

    def modal_velocity_bound(self, theta: float, omega: float, damping: float) -> float:
        """No bound: after a jump the velocity falls off like 1/ω only."""
        return math.inf

    def ringing(self, modes: int) -> Array:
        """Greatest amplitudes of free motion after the jumps; shape (modes,)."""
        u, v = self.knots(modes)
        return np.asarray(np.hypot(u, v / self.system.body.modes(modes).omega).max(axis=0))

    @property
    def most_modes(self) -> int:
        """A few hundred."""
        return _PROBED

    @cached_property
    def by_harmonics(self) -> HarmonicResponse:
        """The response to the harmonics that the load keeps beside its steps."""
        return HarmonicResponse(self.system)


def _turning(modes: Modes) -> npt.NDArray[np.bool_]:
    """Which modes swing a whole number of times in a turn, undamped."""
    whole = np.abs(modes.omega - np.rint(modes.omega)) <= _WHOLE * modes.omega
    return np.asarray((modes.damping == 0.0) & whole)


def _visits(piece: npt.NDArray[np.intp]) -> list[slice] | list[npt.NDArray[np.bool_]]:
    """The places of each piece: visit by visit, in which times at one distance stay so, unless these are very many."""
    changes = np.flatnonzero(np.diff(piece)) + 1
    numbers = np.unique(piece)
    if changes.size + 1 > 2 * numbers.size + 2:
        return [piece == i for i in numbers]
    ends = [0, *changes.tolist(), piece.size] if piece.size else []
    return [slice(a, b) for a, b in pairwise(ends)]


# ---- Of a system

Response: TypeAlias = HarmonicResponse | PiecewiseResponse


@lru_cache(maxsize=32)
def forced_response(system: System) -> Response:
    """The forced response, exact for the load's own form; the last few are kept: all motions of a system share one."""
    return PiecewiseResponse(system) if system.load.is_piecewise else HarmonicResponse(system)
