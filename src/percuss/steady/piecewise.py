"""Forced response to a piecewise-constant load, mode by mode without any Fourier series (theory §7)."""

from __future__ import annotations

import math
from functools import cached_property
from itertools import pairwise

import numpy as np

from percuss.model import System
from percuss.model.checks import Array
from percuss.steady.harmonic import Field, mode_shapes, static_shape
from percuss.steady.oscillator import free_sum, mode_frequencies, phi1, phi2, propagator
from percuss.steady.resonance import refuse_resonance

__all__ = ["PiecewiseResponse"]

TURN = 2.0 * math.pi
_WHOLE = 64.0 * np.finfo(float).eps


class PiecewiseResponse:
    """Periodic motion under a load that is constant between its breaks; the twin of HarmonicResponse.

    Between two breaks every mode moves about its static displacement p_i/ω² as a free oscillator; the state at the
    first break follows from periodicity. Resonance is refused as there.
    """

    def __init__(self, system: System) -> None:
        refuse_resonance(system)
        self.system = system
        self.starts = np.asarray(system.load.breaks)
        self.values = np.asarray(system.load.values)
        self.lengths = np.diff(np.append(self.starts, self.starts[0] + TURN))
        self.pull = self.values - system.load.mean
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

    def locate(self, theta: Array, side: str = "right") -> tuple[np.typing.NDArray[np.intp], Array]:
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
    def flat(self) -> np.typing.NDArray[np.bool_]:
        """On which pieces v_f does not change but for rounding; shape (pieces,)."""
        rate = np.abs(self.pull - self.system.d * self.knot_velocity)
        return np.asarray(rate * self.lengths <= 32.0 * np.finfo(float).eps * self.rigid_bounds()[0])

    def force(self, theta: Array) -> Array:
        """p(θ) with its mean, right-sided at a jump."""
        return self.system.load.value(theta)

    # -- modes --

    def knots(self, modes: int) -> tuple[Array, Array]:
        """Departure from the static displacement, and velocity, of each elastic mode at the start of each piece.

        Shapes (pieces, modes). Those of the most modes asked for are kept: every look at a motion needs them.
        """
        u, v = self._knots if self._knots[0].shape[1] >= modes else self._computed_knots(modes)
        if u.shape[1] > self._knots[0].shape[1]:
            self._knots = u, v
        return u[:, :modes], v[:, :modes]

    def _computed_knots(self, modes: int) -> tuple[Array, Array]:
        omega = mode_frequencies(self.system.s, modes)
        static = self.values[:, None] / omega**2
        steps = [propagator(omega, self.system.d, length) for length in self.lengths]
        jumps = static - np.roll(static, -1, axis=0)  # change of the departure at the end of each piece
        shift_u, shift_v = np.zeros_like(omega), np.zeros_like(omega)
        for step, jump in zip(steps, jumps, strict=True):
            shift_u, shift_v = (
                step.a * shift_u + step.b * shift_v + jump,
                step.c * shift_u + step.e * shift_v,
            )
        whole = propagator(omega, self.system.d, TURN)
        # (I − Φ)⁻¹, with det(I − Φ) = (1 − h)² + 2 h(1 − cos λT), h = exp(−dT/2)
        loss = -np.expm1(-0.5 * self.system.d * TURN)
        det = loss**2 + 2.0 * whole.versine
        turning = self._turning(omega)  # whole swings in a turn that the load does not drive: any state comes back
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

    def _turning(self, omega: Array) -> np.typing.NDArray[np.bool_]:
        return np.asarray((self.system.d == 0.0) & (np.abs(omega - np.rint(omega)) <= _WHOLE * omega))

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
        omega = mode_frequencies(self.system.s, modes)[:, None]
        knot_u, knot_v = self.knots(modes)
        step = propagator(omega, self.system.d, since[None, :])
        u, v = knot_u[piece].T, knot_v[piece].T
        static = self.values[piece][None, :] / omega**2
        return step.a * u + step.b * v + static, step.c * u + step.e * v

    def elastic(self, x: Array, theta: Array, modes: int, *, cut: bool = False) -> Field:
        """Elastic part of the forced motion by `modes` modes; the static shape in closed form unless `cut` as well."""
        x = np.asarray(x, dtype=float)
        theta = np.asarray(theta, dtype=float).reshape(-1)
        rows = np.concatenate(mode_shapes(x, modes))
        rise, bend = static_shape(self.system, x, modes if cut else None)
        force = self.force(theta)
        ring, speed = np.empty((rows.shape[0], theta.size)), np.empty((rows.shape[0], theta.size))
        piece, since = self.locate(theta)
        omega = mode_frequencies(self.system.s, modes)
        knots_u, knots_v = self.knots(modes)
        for here in _visits(piece):
            start = knots_u[piece[here][0]], knots_v[piece[here][0]]
            ring[:, here], speed[:, here] = free_sum(omega, self.system.d, start, since[here], rows)
        half = x.size
        return Field(ring[:half] + np.outer(rise, force), speed[:half], ring[half:] + np.outer(bend, force))

    def end_motion(self, theta: Array, modes: int, *, cut: bool = False) -> tuple[Array, Array]:
        """Forced displacement (but for a constant) and velocity of the striking end, rigid part and elastic part."""
        elastic = self.elastic(np.array([1.0]), theta, modes, cut=cut)
        return (
            elastic.displacement[0] + self.rigid_displacement(theta),
            elastic.velocity[0] + self.rigid_velocity(theta),
        )


def _visits(piece: np.typing.NDArray[np.intp]) -> list[slice] | list[np.typing.NDArray[np.bool_]]:
    """The places of each piece: visit by visit, in which times at one distance stay so, unless these are very many."""
    changes = np.flatnonzero(np.diff(piece)) + 1
    numbers = np.unique(piece)
    if changes.size + 1 > 2 * numbers.size + 2:
        return [piece == i for i in numbers]
    ends = [0, *changes.tolist(), piece.size] if piece.size else []
    return [slice(a, b) for a, b in pairwise(ends)]
