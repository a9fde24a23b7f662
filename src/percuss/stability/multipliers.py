"""Exact Floquet multipliers of an orbit with N elastic modes (not in B77; theory §5), and which motion each belongs to.

They are exact for the modes and the contact law of the system. What they say of the elastic modes is said by the law:
where an impact keeps the strain (B77) some of these may grow, where it turns the strain over, as waves in a uniform bar
do, their multipliers have a modulus of about R e^{−d_n T/2}.

A multiplier belongs to a mode by its participation factor l_n·r_n, the product of the mode's parts of its left and
right eigenvectors with l·r = 1 (Pérez-Arriaga, Verghese & Schweppe, IEEE Trans. PAS-101 (1982) 3117–3125). No scale of
the states enters. Over the modes the factors of one multiplier sum to 1, over the multipliers those of one mode to 2.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from percuss.errors import ConvergenceError
from percuss.halting import look
from percuss.mechanics.flow import phi1
from percuss.model import HeldBody, System
from percuss.model.checks import Array, ComplexArray, choice, count, instance
from percuss.model.load import Side
from percuss.shown import Shown
from percuss.steady import Orbit
from percuss.steady.oscillator import flights

# ---- The linearised map from impact to impact, in the form that its structure gives it (theory §5)
#
# With ξ the perturbation of the modal state at fixed times, flight is ξ → Φ(T) ξ, block by block, and the impact is the
# saltation matrix S = D − g hᵀ/(h·ẋ⁻), which carries the change of the flight time. D = diag(α, β) in every mode, β =
# −R, the rigid one too: its position is set so that the striking end stays at 0, which for a state with y = 0 is α
# times itself. h is γ_n on the displacements, ẋ⁻ the velocity before the impact and g = Dẋ⁻ − ẋ⁺, in mode n ((α − β)
# w_n, (α − β) ω_n² u_n − (1 − β) p(φ)) with u_n, w_n just before the impact: the damping drops out. So M = S Φ is
# block-diagonal plus rank one. Where the strain turns over with the velocity, α = β, only the load is left in g.

Numbers = npt.NDArray[Any]  # real where the contact law keeps the strain, else complex
_CHUNK = 256  # multipliers whose participation is worked out together
_TINY_MODE = 1e-150
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
        apart = np.abs(large - small) > _TINY_MODE
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
        alive = np.abs(large) > _TINY_MODE  # of a mode damped to nothing within a flight both are 0
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


# ---- All roots of the secular function F(μ) = 1 + Σ r_j/(μ − ξ_j) in nearly linear time; poles real or complex
#
# Newton's method for every root at once, each multiplied by the distance from its own pole and deflated by all the
# others (Ehrlich–Aberth); for many poles the sums are taken by a tree of multipole expansions (Barnes and Hut's
# scheme), so that one sweep costs O(n log n) and not O(n²).

_EPS = np.finfo(float).eps
_DIRECT = 512  # below this many poles direct sums are faster
_LEAF = 48
_ORDER = 34  # 3^−34 < 1e-16
_FAR = 3.0  # an expansion is used from 3 radii on
_SWEEPS = 400
_SETTLED = 1e-11  # steps below this that no longer shrink are rounding
_PATIENCE = 12  # sweeps without a smaller step after which a root is left where it is
_LOOSE = 1e-7  # and counts as found only if its steps were this small

Index = npt.NDArray[np.intp]


def secular_roots(poles: Numbers, residues: Numbers) -> tuple[ComplexArray, bool]:
    """Roots of 1 + Σ r_j/(μ − ξ_j) = 0, as many as there are poles, and whether all of them converged.

    A pole whose residue vanishes is itself a root; equal poles are taken together. Each root is right to rounding when
    roots are well separated. The sum of the roots should be Σ ξ_j − Σ r_j: the caller checks it.

    Parameters
    ----------
    poles, residues
        Real or complex, equal shapes (n,).

    Returns
    -------
    roots, converged
        Complex, shape (n,), in no particular order; and a truth value.
    """
    if not poles.size:
        return np.empty(0, dtype=complex), True
    scale = max(1.0, float(np.abs(poles).max()))
    order, starts = _groups(poles, 4.0 * _EPS * scale)
    poles, residues = poles[order], residues[order]
    merged = np.add.reduceat(residues, starts)
    lone = poles[starts]
    repeated = np.delete(poles, starts)
    live = np.abs(merged) > _EPS * _EPS * scale
    settled = np.concatenate([repeated, lone[~live]]).astype(complex)
    lone, merged = lone[live], merged[live]
    if np.iscomplexobj(lone) and np.all(np.diff(lone.real) > 0.0) and not lone.imag.any():
        lone, merged = lone.real, merged.real
    roots, converged = _iterate(lone, merged)
    return np.concatenate([settled, roots]), converged


def _groups(poles: Numbers, width: float) -> tuple[Index, Index]:
    """An order in which equal poles follow each other, and where each of them begins; real parts increase."""
    order = np.argsort(poles.real)
    column = np.cumsum(np.append(0, np.diff(poles.real[order]) > width))
    if np.iscomplexobj(poles):
        order = order[np.lexsort((poles.imag[order], column))]
        fresh = (np.diff(column) > 0) | (np.diff(poles.imag[order]) > width)
    else:
        fresh = np.diff(column) > 0
    return order, np.flatnonzero(np.append(True, fresh))


def _iterate(poles: Numbers, residues: Numbers) -> tuple[ComplexArray, bool]:
    n = poles.size
    if n == 0:
        return np.empty(0, dtype=complex), True
    flat = not np.iscomplexobj(poles)
    z = _first_guess(poles.real, residues.real) if flat else _guess_in_the_plane(poles, residues)
    active = np.arange(n)
    best, stalled = np.full(n, np.inf), np.zeros(n, dtype=int)
    weights = np.stack([residues, np.ones(n)], axis=1)
    for _ in range(_SWEEPS):
        look()
        here = z[active]
        own, strength = poles[active], residues[active]
        sums, slopes = cauchy_sums(here, poles.astype(complex), weights, flat=flat)
        away = here - own
        by_real = z[np.argsort(z.real)]
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            others = sums[:, 0] - strength / away
            bend = slopes[:, 0] + strength / away**2  # derivative of the sum over the other poles
            newton = (away * (1.0 + others) + strength) / (1.0 + others + away * bend)
            crowd, _ = cauchy_sums(here, by_real, np.ones((n, 1)), flat=flat)
            pull = sums[:, 1] - 1.0 / away - crowd[:, 0]
            step = newton / (1.0 + newton * pull)
        step = np.where(np.isfinite(step), step, 1e-3 * (np.abs(away) + np.abs(strength)) * (0.6 + 0.8j))
        limit = 0.5 * np.abs(away) + np.abs(strength) + 0.05
        size = np.abs(step)
        step *= np.minimum(1.0, limit / np.where(size > 0.0, size, 1.0))
        z[active] = here - step
        size = np.abs(step)
        better = size < 0.5 * best[active]
        best[active] = np.where(better, size, best[active])
        stalled[active] = np.where(better, 0, stalled[active] + 1)
        patience = np.where(size < _SETTLED, 2, np.where(size < _LOOSE, _PATIENCE, _SWEEPS))
        resting = stalled[active] >= patience  # only rounding moves it about
        active = active[(size > 4.0 * _EPS * np.maximum(np.abs(here), np.abs(away) * 1e-3)) & ~resting]
        if not active.size:
            break
    return z, bool(not active.size and best.max() < _LOOSE)


def _first_guess(poles: Array, residues: Array) -> ComplexArray:
    """Beside each pole, where it would stand alone but nearer than the next pole, off the axis so that pairs can part.

    Among poles that crowd, strong residues nearly cancel: most of their roots stay in the crowd, and would come back to
    it slowly from where each residue alone would send them. The few that lie far away are soon there.
    """
    shift = -residues
    room = np.minimum(np.diff(poles, prepend=poles[0] - 1.0), np.diff(poles, append=poles[-1] + 1.0))
    lone = np.sign(shift) * np.minimum(np.abs(shift), 0.6 * room)
    tilt = np.where(np.arange(poles.size) % 2 == 0, 1.0, -1.0)
    return np.asarray(poles + lone + 0.3j * tilt * np.minimum(np.abs(lone) + 1e-16, room))


def _guess_in_the_plane(poles: ComplexArray, residues: ComplexArray) -> ComplexArray:
    """Beside each pole, where it would stand alone; turned a little, so that two of a pair can part along the axis."""
    return np.asarray(poles - residues * (1.0 + 0.1j))


def cauchy_sums(
    z: ComplexArray, sources: ComplexArray, weights: Numbers, *, flat: bool = True
) -> tuple[ComplexArray, ComplexArray]:
    """Σ_j w_j/(z − s_j) and its derivative −Σ_j w_j/(z − s_j)² at every z; a source at z itself does not count.

    Direct for few sources, else by a tree; both right to rounding relative to the sum of the moduli.

    Parameters
    ----------
    z
        Shape (m,).
    sources
        Shape (n,), real parts increasing.
    weights
        Shape (n, w).
    flat
        Whether the sources lie along the real axis: a tree over the plane is parted along both axes.

    Returns
    -------
    tuple of numpy.ndarray
        Two arrays of shape (m, w).
    """
    total = np.zeros((z.size, weights.shape[1]), dtype=complex)
    slope = np.zeros_like(total)
    with np.errstate(divide="ignore", invalid="ignore"):
        if sources.size <= _DIRECT:
            _add_direct(z, np.arange(z.size), sources, weights, total, slope)
        else:
            _visit(z, np.arange(z.size), sources, weights, total, slope, flat)
    return total, slope


def _add_direct(
    z: ComplexArray, where: Index, sources: ComplexArray, weights: Numbers, total: ComplexArray, slope: ComplexArray
) -> None:
    off = z[where, None] - sources[None, :]
    inverse = np.where(off == 0.0, 0.0, 1.0 / off)
    total[where] += inverse @ weights
    slope[where] -= (inverse * inverse) @ weights


def _visit(
    z: ComplexArray,
    where: Index,
    sources: ComplexArray,
    weights: Numbers,
    total: ComplexArray,
    slope: ComplexArray,
    flat: bool,
) -> None:
    """Add one node of the tree to the targets `where`: by its expansion if they are far, else through its halves."""
    if not flat:  # the longer side of the node is parted
        sides = np.ptp(sources.real), np.ptp(sources.imag)
        along = np.argsort(sources.imag if sides[1] > sides[0] else sources.real, kind="stable")
        sources, weights = sources[along], weights[along]
    centre = 0.5 * (sources[0] + sources[-1])
    radius = float(np.abs(sources - centre).max())
    off = z[where] - centre
    far = np.abs(off) > _FAR * radius + 1e-12
    if far.any() and sources.size > _ORDER // 2:
        powers = ((sources - centre)[:, None] / max(radius, 1e-300)) ** np.arange(_ORDER)
        moments = powers.T @ weights
        inverse = 1.0 / off[far]
        x = (radius * inverse)[:, None]
        value = np.zeros((x.size, weights.shape[1]), dtype=complex)
        derivative = np.zeros_like(value)
        for order in range(_ORDER - 1, -1, -1):
            value = value * x + moments[order]
            derivative = derivative * x + (order + 1) * moments[order]
        total[where[far]] += value * inverse[:, None]
        slope[where[far]] -= derivative * inverse[:, None] ** 2
        where = where[~far]
    if not where.size:
        return
    if sources.size <= _LEAF:
        _add_direct(z, where, sources, weights, total, slope)
        return
    half = sources.size // 2
    _visit(z, where, sources[:half], weights[:half], total, slope, flat)
    _visit(z, where, sources[half:], weights[half:], total, slope, flat)


# ---- Exact Floquet multipliers of an orbit with N elastic modes (not in B77; theory §5), and which motion each belongs
# to

NEUTRAL = 1e-10
"""Moduli this close to 1 are neither stable nor unstable: rounding would decide."""

TURNING = 1e-6
"""Part of its modulus from which on the imaginary part of a multiplier makes it one of a pair that turns."""

_DENSE = 40  # up to this many modes a dense eigensolve is as fast
_TRACE = 1e-11  # relative error of the sums of the roots and of their squares
_DENSE_CHECK = 300  # up to this many it may stand in for roots that failed their check
_TINY = 1e-6  # multipliers this small beside the largest, or beside 1, are taken for 0
_NEAR = 64  # multipliers of very many modes among which each of the rigid motion is looked for


@dataclass(frozen=True)
class Multipliers(Shown):
    """The Floquet multipliers of the map from impact to impact.

    Parameters
    ----------
    modes
        N: modes 0 … N were kept.
    values
        All 2N + 2 multipliers, of a body that is held 2N, largest modulus first; complex, dimensionless.
    dominant_mode
        The mode with the greatest share of energy in the eigenvector of the first multiplier; 0 is the rigid motion.
    """

    modes: int
    values: ComplexArray
    dominant_mode: int
    _orbit: Orbit = field(repr=False, compare=False)
    _map: LinearMap = field(repr=False, compare=False)
    _side: Side = field(repr=False, compare=False)

    @property
    def system(self) -> System:
        """What the orbit is one of."""
        return self._orbit.system

    @property
    def moduli(self) -> Array:
        """Moduli, largest first."""
        return np.asarray(np.abs(self.values))

    @property
    def largest(self) -> float:
        """Largest modulus: less than 1 when the orbit is stable."""
        return float(np.abs(self.values).max())  # of equal ones the first in `values` may be an ulp off

    @cached_property
    def rigid(self) -> tuple[int, int]:
        """Places in `values` of the two that belong to the rigid motion: those in which it takes part most.

        Of a body that is held those of its first mode.
        """
        if self.modes <= _DENSE_CHECK:
            return _rigid_pair(self._map, self.values)
        return _matched(self._orbit, self._side, self._map, self.values)

    @property
    def ringing_mode(self) -> int:
        """The mode that dominates the slowest of all others, 1 … N; 0 without elastic modes."""
        slowest = _slowest(self.rigid, self.values.size)
        number = 1 if self.system.body.is_free else 2
        return 0 if slowest is None else number + int(np.argmax(self._map.shares(complex(self.values[slowest]))[1:]))

    @property
    def rhythm(self) -> float:
        """Largest modulus of the two multipliers of the rigid motion."""
        return float(np.abs(self.values[list(self.rigid)]).max())

    @property
    def ringing(self) -> float | None:
        """Largest modulus of those of the elastic modes; None when there are none."""
        slowest = _slowest(self.rigid, self.values.size)
        return None if slowest is None else float(np.abs(self.values[slowest]))


def floquet_multipliers(orbit: Orbit, modes: int = 32, *, side: Side = "right") -> Multipliers:
    """All multipliers of an orbit, exact for the bar with modes 0 … `modes`.

    Few modes go to a dense eigensolver; many to the secular function, whose cost grows in proportion to N.

    Parameters
    ----------
    orbit
        The orbit.
    modes
        N, 0 to 16384.
    side
        Which value of the load counts when it jumps at the impact.

    Raises
    ------
    ParameterError
        For N out of range.
    ConvergenceError
        When the roots fail the check by the trace of the map.
    """
    n = count("modes", modes, least=0, most=MAX_MODES)
    body = instance("orbit", orbit, Orbit).system.body
    n = body.chosen(n) if isinstance(body, HeldBody) else n
    matrix = linear_map(orbit, n, side)
    values = np.linalg.eigvals(matrix.dense()).astype(complex) if n <= _DENSE else _secular(matrix)
    values = values[np.lexsort((values.imag, -values.real, -np.round(np.abs(values), 13)))]
    shares = matrix.shares(complex(values[0]))
    first = 0 if body.is_free else 1
    return Multipliers(n, values, first + int(np.argmax(shares)), orbit, matrix, side)


def _rigid_pair(matrix: LinearMap, values: ComplexArray) -> tuple[int, int]:
    """The two multipliers in which the rigid motion takes part most.

    By the real part: where two multipliers meet, their factors grow without bound with opposite signs. Multipliers of 0
    (R = 0 has one in every block) have no eigenvectors of their own: together they have what the others leave of 2.
    """
    size = values.size
    if size == 2:
        return 0, 1
    alive = int(np.count_nonzero(np.abs(values) > _TINY * max(1.0, float(np.abs(values[0])))))
    part = matrix.participation(values[:alive]).real
    found = np.argsort(-part, kind="stable")[:2].tolist()
    left = 2.0 - float(part.sum()) if alive < size else 0.0
    if left > 1.5:
        found = [size - 2, size - 1]
    elif alive < size and (len(found) < 2 or left > part[found[1]]):
        found = [*found[:1], size - 1]
    first, second = sorted(found)
    return first, second


def _matched(orbit: Orbit, side: Side, matrix: LinearMap, values: ComplexArray) -> tuple[int, int]:
    """Positions of the two rigid multipliers among those of very many modes: nearest to where few modes have them."""
    few = floquet_multipliers(orbit, _DENSE, side=side)
    found: list[int] = []
    for one in few.values[list(few.rigid)]:
        near = np.argsort(np.abs(values - one), kind="stable")[:_NEAR]
        near = near[~np.isin(near, found)]
        lost = abs(one) <= _TINY * max(1.0, few.largest)
        part = matrix.participation(values[near]).real
        found.append(int(near[np.argmin(np.abs(values[near]))] if lost else near[np.argmax(part)]))
    first, second = sorted(found)
    return first, second


def _slowest(rigid: tuple[int, int], size: int) -> int | None:
    """Place of the largest multiplier that is not of the rigid motion, among `size` in order of modulus."""
    return next((i for i in range(size) if i not in rigid), None)


def _secular(matrix: LinearMap) -> ComplexArray:
    """Roots of the secular function, believed only when all converged and two power sums fit the map."""
    values, converged = secular_roots(*matrix.partial_fractions())
    scale = max(1.0, float(np.abs(values).max()))
    room = _TRACE * np.sqrt(values.size)
    first = abs(complex(values.sum()) - matrix.trace) / scale
    second = abs(complex((values**2).sum()) - matrix.trace_of_square) / scale**2
    if converged and first <= room and second <= room:
        return values
    if matrix.a.size <= _DENSE_CHECK:
        return np.asarray(np.linalg.eigvals(matrix.dense()).astype(complex))
    raise ConvergenceError(
        f"the multipliers of {matrix.a.size - 1} modes crowd too closely, velocities times "
        f"{matrix.velocity_factor:g} at the impact: they miss the trace of their map by {first:.1e}",
        f"ask for at most {_DENSE_CHECK - 1} modes",
    )
