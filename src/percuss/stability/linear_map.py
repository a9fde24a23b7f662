"""The linearised map from impact to impact, in the form that its structure gives it (theory §5).

With ξ the perturbation of the modal state at fixed times, flight is ξ → Φ(T) ξ, block by block, and the impact is the
saltation matrix S = D − g hᵀ/(h·ẋ⁻), which carries the change of the flight time: h = c_n on the displacements, ẋ⁻ the
velocity before the impact, and g_n = (1 + R)(w_n, ω_n² u_n − p(φ)). So M = S Φ is block-diagonal plus rank one.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from percuss.model.checks import Array, ComplexArray, choice, count, instance
from percuss.model.load import Side
from percuss.steady import Orbit
from percuss.steady.oscillator import phi1, propagator

__all__ = ["LinearMap", "linear_map"]

_CHUNK = 256  # multipliers whose participation is worked out together


MAX_MODES = 16384  # a map may ask for more than the 4096 that an orbit's fields are bounded to


@dataclass(frozen=True)
class LinearMap:
    """M = DΦ − g (hᵀΦ)/W in modes n = 0 … N; every array of shape (N + 1,).

    Parameters
    ----------
    a, b, c, e
        Φ_n = [[a, b], [c, e]].
    omega
        Undamped frequencies, 0 for the rigid mode.
    sign
        c_n: 1, −2, 2, −2, …
    g, g_velocity
        The two parts of g_n.
    speed
        W, the speed of the striking end before the impact with these modes.
    restitution, decay
        R and E = exp(−dT).
    """

    a: Array
    b: Array
    c: Array
    e: Array
    omega: Array
    sign: Array
    g: Array
    g_velocity: Array
    speed: float
    restitution: float
    decay: float

    def dense(self) -> Array:
        """M as a full matrix of shape (2N + 2, 2N + 2); states ordered u_0, u_0', u_1, u_1', …"""
        size = self.a.size
        matrix = np.zeros((2 * size, 2 * size))
        even, odd = np.arange(0, 2 * size, 2), np.arange(1, 2 * size, 2)
        matrix[even, even], matrix[even, odd] = self.a, self.b
        matrix[odd, even], matrix[odd, odd] = -self.restitution * self.c, -self.restitution * self.e
        jump = np.stack([self.g, self.g_velocity], axis=1).reshape(-1) / self.speed
        flight = np.stack([self.sign * self.a, self.sign * self.b], axis=1).reshape(-1)
        return np.asarray(matrix - np.outer(jump, flight))

    @property
    def trace(self) -> float:
        """Sum of the multipliers."""
        blocks = self.a - self.restitution * self.e
        return float(blocks.sum() - (self.sign * (self.a * self.g + self.b * self.g_velocity)).sum() / self.speed)

    @property
    def trace_of_square(self) -> float:
        """Sum of the squares of the multipliers: tr B² − 2 fᵀBg/W + (fᵀg/W)² with M = B − g fᵀ/W."""
        r = self.restitution
        blocks = self.a**2 - 2.0 * r * self.b * self.c + (r * self.e) ** 2
        carried = self.a * self.g + self.b * self.g_velocity  # the upper half of Bg, and fᵀg mode by mode
        turned = -r * (self.c * self.g + self.e * self.g_velocity)  # the lower half of Bg
        mixed = float((self.sign * (self.a * carried + self.b * turned)).sum()) / self.speed
        return float(blocks.sum()) - 2.0 * mixed + (float((self.sign * carried).sum()) / self.speed) ** 2

    def partial_fractions(self) -> tuple[Array, Array]:
        """Poles ξ_j and residues r_j with det(M − μ)/det(DΦ − μ) = 1 + Σ r_j/(μ − ξ_j).

        The poles are the eigenvalues of the blocks DΦ_n, all real: their product is −R E. Shapes (2N + 2,); for R = 0,
        where one pole of every block is 0 with residue 0, these are kept as they are.
        """
        r, decay = self.restitution, self.decay
        trace = self.a - r * self.e
        root = np.sqrt(trace**2 + 4.0 * r * decay)
        large = 0.5 * (trace + np.where(trace < 0.0, -root, root))
        small = np.where(large != 0.0, -r * decay / np.where(large != 0.0, large, 1.0), 0.0)
        gap = np.where(large != small, large - small, 1.0)

        def numerator(mu: Array) -> Array:
            return self.sign * ((r * decay + self.a * mu) * self.g + self.b * mu * self.g_velocity) / self.speed

        # 1 − (1/W) Σ c_n e₁ᵀΦ(DΦ − μ)⁻¹g: the sign turns once with the adjugate
        residues = np.stack([numerator(large) / gap, -numerator(small) / gap])
        return np.stack([large, small]).reshape(-1), residues.reshape(-1)

    def participation(self, multipliers: ComplexArray) -> ComplexArray:
        """How much the rigid motion takes part in each multiplier: l_0·r_0 with l·r = 1; shape as `multipliers`.

        With B = DΦ the eigenvectors are r = (B − μ)⁻¹g and l = (B − μ)⁻ᵀf, so that l_n·r_n is the n-th part of
        fᵀ(B − μ)⁻²g, the derivative of the secular function.
        """
        found = np.empty(multipliers.size, dtype=complex)
        for i in range(0, multipliers.size, _CHUNK):
            each = self._parts(multipliers[i : i + _CHUNK, None])
            with np.errstate(divide="ignore", invalid="ignore"):
                found[i : i + _CHUNK] = each[:, 0] / each.sum(axis=1)
        return np.where(np.isfinite(found), found, 0.0)

    def _parts(self, mu: ComplexArray) -> ComplexArray:
        """f_nᵀ(B_n − μ)⁻²g_n, relative to the greatest of each row; shape (multipliers, N + 1)."""
        r = self.restitution
        first, last = self.a - mu, -r * self.e - mu
        determinant = first * last + r * self.b * self.c
        # (B − μ)⁻¹ = adj/det, twice; at a pole of one block all else is nothing beside it
        u, v = last * self.g - self.b * self.g_velocity, r * self.c * self.g + first * self.g_velocity
        u, v = last * u - self.b * v, r * self.c * u + first * v
        size = np.abs(determinant)
        least = size.min(axis=1, keepdims=True)
        ratio = np.where(size > 0.0, least, 1.0) / np.where(size > 0.0, determinant, 1.0)
        return np.asarray(self.sign * (self.a * u + self.b * v) * ratio**2)

    def shares(self, multiplier: complex) -> Array:
        """Share of each mode in the eigenvector of a multiplier, by its energy; shape (N + 1,), sum 1."""
        r = self.restitution
        determinant = (self.a - multiplier) * (-r * self.e - multiplier) + r * self.b * self.c
        tiny = 1e-300 + np.finfo(float).tiny
        u = (-r * self.e - multiplier) * self.g - self.b * self.g_velocity
        v = r * self.c * self.g + (self.a - multiplier) * self.g_velocity
        weight = (np.abs(v) ** 2 + np.maximum(self.omega, 1.0) ** 2 * np.abs(u) ** 2) / (
            np.abs(determinant) ** 2 + tiny
        )
        return np.asarray(weight / weight.sum()) if weight.sum() > 0.0 else np.eye(1, weight.size)[0]


def linear_map(orbit: Orbit, modes: int, side: Side = "right") -> LinearMap:
    """The linearised impact-to-impact map of an orbit, with modes 0 … `modes`.

    The orbit is that of the bar with so many modes: its forced part is cut there as well. Where the load jumps at the
    impact, `side` chooses its value.
    """
    instance("orbit", orbit, Orbit)
    modes = count("modes", modes, least=0, most=MAX_MODES)
    choice("side", side, "left", "right")
    system, period = orbit.system, orbit.period
    r, d = system.restitution, system.d
    state = orbit.modal_state(modes)
    omega = np.append(0.0, system.body.modes(modes, system.load.at).omega)
    step = propagator(omega[1:], d, period)
    decay = float(np.exp(-d * period))
    a, e = np.append(1.0, step.a), np.append(decay, step.e)
    b, c = np.append(period * float(phi1(d * period)), step.b), np.append(0.0, step.c)
    sign = np.append(1.0, 2.0 * np.cos(np.pi * np.arange(1, modes + 1)))
    velocity = np.append(orbit.rigid_velocity, state.velocity)
    pull = float(system.load.value(orbit.phase, side)) - omega**2 * np.append(0.0, state.displacement)
    return LinearMap(
        a=a,
        b=b,
        c=c,
        e=e,
        omega=omega,
        sign=sign,
        g=(1.0 + r) * velocity,
        g_velocity=-(1.0 + r) * pull,
        speed=float(sign @ velocity),
        restitution=r,
        decay=decay,
    )
