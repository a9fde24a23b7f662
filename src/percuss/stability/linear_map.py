"""The linearised map from impact to impact, in the form that its structure gives it (theory §5).

With ξ the perturbation of the modal state at fixed times, flight is ξ → Φ(T) ξ, block by block, and the impact is the
saltation matrix S = D − g hᵀ/(h·ẋ⁻), which carries the change of the flight time. D = diag(α, β) in every mode, β = −R,
the rigid one too: its position is set so that the striking end stays at 0, which for a state with y = 0 is α times
itself. h is γ_n on the displacements, ẋ⁻ the velocity before the impact and g = Dẋ⁻ − ẋ⁺, in mode n
((α − β) w_n, (α − β) ω_n² u_n − (1 − β) p(φ)) with u_n, w_n just before the impact: the damping drops out. So M = S Φ
is block-diagonal plus rank one. Where the strain turns over with the velocity, α = β, only the load is left in g.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from percuss.model import System
from percuss.model.checks import Array, ComplexArray, choice, count, instance
from percuss.model.load import Side
from percuss.steady import Orbit
from percuss.steady.oscillator import flights, phi1

__all__ = ["LinearMap", "linear_map"]

Numbers = npt.NDArray[Any]  # real where the contact law keeps the strain, else complex
_CHUNK = 256  # multipliers whose participation is worked out together
_TINY = 1e-150
_ASIDE = 2.0  # where a pole is put that stands in for one of the rigid motion

MAX_MODES = 16384  # a map may ask for more than the 4096 that an orbit's fields are bounded to


@dataclass(frozen=True)
class LinearMap:
    """M = DΦ − g (hᵀΦ)/W in modes n = 0 … N, of a body that is held 1 … N; every array of as many.

    Parameters
    ----------
    a, b, c, e
        Φ_n = [[a, b], [c, e]].
    decay
        E_n = exp(−d_n T) = det Φ_n.
    omega
        Undamped frequencies, 0 for the rigid mode.
    gamma
        γ_n: 1, then −2, 2, −2, … for a uniform bar that is driven at its end.
    g, g_velocity
        The two parts of g_n.
    speed
        W, the speed of the striking end before the impact with these modes.
    velocity_factor, strain_factor
        β and α of the contact law.
    """

    a: Array
    b: Array
    c: Array
    e: Array
    decay: Array
    omega: Array
    gamma: Array
    g: Array
    g_velocity: Array
    speed: float
    velocity_factor: float
    strain_factor: float

    def dense(self) -> Array:
        """M as a full matrix of shape (2N + 2, 2N + 2); states ordered u_0, u_0', u_1, u_1', …"""
        size, beta, alpha = self.a.size, self.velocity_factor, self.strain_factor
        matrix = np.zeros((2 * size, 2 * size))
        even, odd = np.arange(0, 2 * size, 2), np.arange(1, 2 * size, 2)
        matrix[even, even], matrix[even, odd] = alpha * self.a, alpha * self.b
        matrix[odd, even], matrix[odd, odd] = beta * self.c, beta * self.e
        jump = np.stack([self.g, self.g_velocity], axis=1).reshape(-1) / self.speed
        flight = np.stack([self.gamma * self.a, self.gamma * self.b], axis=1).reshape(-1)
        return np.asarray(matrix - np.outer(jump, flight))

    @property
    def trace(self) -> float:
        """Sum of the multipliers."""
        blocks = self.strain_factor * self.a + self.velocity_factor * self.e
        return float(blocks.sum() - (self.gamma * (self.a * self.g + self.b * self.g_velocity)).sum() / self.speed)

    @property
    def trace_of_square(self) -> float:
        """Sum of the squares of the multipliers: tr B² − 2 fᵀBg/W + (fᵀg/W)² with M = B − g fᵀ/W."""
        beta, alpha = self.velocity_factor, self.strain_factor
        blocks = (alpha * self.a) ** 2 + 2.0 * alpha * beta * self.b * self.c + (beta * self.e) ** 2
        carried = self.a * self.g + self.b * self.g_velocity  # fᵀg mode by mode, and the upper half of Bg over α
        turned = beta * (self.c * self.g + self.e * self.g_velocity)  # the lower half of Bg
        mixed = float((self.gamma * (self.a * alpha * carried + self.b * turned)).sum()) / self.speed
        return float(blocks.sum()) - 2.0 * mixed + (float((self.gamma * carried).sum()) / self.speed) ** 2

    # -- the secular function --

    def partial_fractions(self) -> tuple[Numbers, Numbers]:
        """Poles ξ_j and residues r_j of 1 + Σ r_j/(μ − ξ_j), whose zeros are the multipliers; shapes (2N + 2,).

        The function is det(M − μ)/det(DΦ − μ) = 1 + (1/W) Σ γ_n [(a_n g_n + b_n g_n') μ − β E_n g_n]/Q_n(μ) with
        Q_n = det(D Φ_n − μ) = μ² − (α a_n + β e_n) μ + α β E_n. Where the law keeps the strain (α = 1) all poles are
        real. Where it turns it over they are β times the eigenvalues of Φ_n, complex ones in pairs. Without drag both
        of the rigid motion are β then, and one is put elsewhere by the factor (μ − α)/(μ − 2): no zero moves.
        A pole of a pair that meets (β = 0) is kept with the residue 0.
        """
        beta, alpha = self.velocity_factor, self.strain_factor
        large, small = self._poles()
        apart = np.abs(large - small) > _TINY
        gap = np.where(apart, large - small, 1.0)
        slope = self.gamma * (self.a * self.g + self.b * self.g_velocity) / self.speed
        constant = self.gamma * (-beta * self.decay) * self.g / self.speed
        first = np.where(apart, (slope * large + constant) / gap, slope)
        second = np.where(apart, -(slope * small + constant) / gap, 0.0)
        if alpha <= 0.0:  # else the two poles of the rigid motion, α and β E, are far apart
            drag = small[0]
            others = np.sum(first[1:] / (_ASIDE - large[1:])) + np.sum(second[1:] / (_ASIDE - small[1:]))
            first *= (large - alpha) / (large - _ASIDE)
            second *= (small - alpha) / (small - _ASIDE)
            aside = (slope[0] * _ASIDE + constant[0]) / (_ASIDE - drag)
            large[0], first[0] = _ASIDE, (_ASIDE - alpha) * (1.0 + others) + aside
            second[0] = (slope[0] * drag + constant[0]) / (drag - _ASIDE)
        return np.stack([large, small]).reshape(-1), np.stack([first, second]).reshape(-1)

    def _poles(self) -> tuple[Numbers, Numbers]:
        """The eigenvalues of the blocks DΦ_n: the larger and the smaller of each; of the rigid motion α and β E."""
        beta, alpha = self.velocity_factor, self.strain_factor
        trace, product = alpha * self.a + beta * self.e, alpha * beta * self.decay
        # trace² − 4 product, written so that nothing cancels where α < 0
        square = (alpha * self.a - beta * self.e) ** 2 + 4.0 * alpha * beta * self.b * self.c
        root = np.sqrt(square) if alpha > 0.0 else np.sqrt(square.astype(complex))
        large = 0.5 * (trace + np.where(trace < 0.0, -root, root))
        alive = np.abs(large) > _TINY  # of a mode damped to nothing within a flight both are 0
        small = np.where(alive, product / np.where(alive, large, 1.0), 0.0)
        if alpha <= 0.0:
            large[0], small[0] = alpha, beta * self.decay[0]
        return large, small

    # -- eigenvectors --

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
        u, v, determinant = self._adjugate(mu, self.g, self.g_velocity)
        u, v, _ = self._adjugate(mu, u, v)
        # (B − μ)⁻¹ = adj/det, twice; at a pole of one block all else is nothing beside it
        size = np.abs(determinant)
        least = size.min(axis=1, keepdims=True)
        ratio = np.where(size > 0.0, least, 1.0) / np.where(size > 0.0, determinant, 1.0)
        return np.asarray(self.gamma * (self.a * u + self.b * v) * ratio**2)

    def _adjugate(self, mu: ComplexArray | complex, u: Any, v: Any) -> tuple[Any, Any, Any]:
        """adj(B_n − μ) of the vectors (u_n, v_n), and det(B_n − μ)."""
        beta, alpha = self.velocity_factor, self.strain_factor
        first, last = alpha * self.a - mu, beta * self.e - mu
        determinant = first * last - alpha * beta * self.b * self.c
        return last * u - alpha * self.b * v, first * v - beta * self.c * u, determinant

    def shares(self, multiplier: complex) -> Array:
        """Share of each mode in the eigenvector of a multiplier, by its energy; shape (N + 1,), sum 1.

        The energy of u_n counts |γ_n|/2 times, once for B77's bar: a mode that the load hardly drives has hardly a
        share, and a bar that is turned round has the same shares.
        """
        u, v, determinant = self._adjugate(multiplier, self.g, self.g_velocity)
        tiny = 1e-300 + np.finfo(float).tiny
        counted = np.where(self.omega == 0.0, 1.0, 0.5 * np.abs(self.gamma))
        weight = counted * (np.abs(v) ** 2 + np.maximum(self.omega, 1.0) ** 2 * np.abs(u) ** 2)
        weight /= np.abs(determinant) ** 2 + tiny
        return np.asarray(weight / weight.sum()) if weight.sum() > 0.0 else np.eye(1, weight.size)[0]


def map_at_impact(system: System, period: float, force: float, displacement: Array, velocity: Array) -> LinearMap:
    """The map of a motion of the given period, from its state just before the impact.

    Parameters
    ----------
    system, period
        What moves, and T.
    force
        p(φ), the load at the impact.
    displacement, velocity
        u_n of the elastic modes 1 … N, shape (N,), and u_n' of the modes 0 … N, shape (N + 1,).
    """
    contact, d = system.contact, system.d
    alpha, beta = contact.strain_factor, contact.velocity_factor
    modes, step = flights(system.body, system.load.at, period, displacement.size)
    first = 0 if system.body.is_free else 1  # a body that is held has no rigid motion
    velocity = velocity[first:]
    omega = np.append(0.0, modes.omega)[first:]
    gamma = np.append(1.0, modes.gamma)[first:]
    decay = np.exp(-np.append(d, modes.damping) * period)
    pull = contact.impulse * force - (alpha - beta) * omega**2 * np.append(0.0, displacement)[first:]
    return LinearMap(
        a=np.append(1.0, step.a)[first:],
        b=np.append(period * float(phi1(d * period)), step.b)[first:],
        c=np.append(0.0, step.c)[first:],
        e=np.append(decay[0], step.e)[first:],
        decay=decay[first:],
        omega=omega,
        gamma=gamma,
        g=(alpha - beta) * velocity,
        g_velocity=-pull,
        speed=float(gamma @ velocity),
        velocity_factor=beta,
        strain_factor=alpha,
    )


def linear_map(orbit: Orbit, modes: int, side: Side = "right") -> LinearMap:
    """The linearised impact-to-impact map of an orbit, with modes 0 … `modes`.

    The orbit is that of the bar with so many modes: its forced part is cut there as well. Where the load jumps at the
    impact, `side` chooses its value.
    """
    instance("orbit", orbit, Orbit)
    modes = count("modes", modes, least=0, most=MAX_MODES)
    choice("side", side, "left", "right")
    state, system = orbit.modal_state(modes), orbit.system
    gamma = system.body.modes(modes, system.load.at).gamma
    # what the load gives in a period, less what drag takes as the bar returns to where the impact moves it from
    bent = (1.0 - system.contact.strain_factor) * float(gamma @ state.displacement) if system.d else 0.0
    rigid = (system.push * orbit.period + system.d * bent) / system.contact.impulse
    force = float(system.load.value(orbit.phase, side))
    return map_at_impact(system, orbit.period, force, state.displacement, np.append(rigid, state.velocity))
