"""All roots of the secular function F(μ) = 1 + Σ r_j/(μ − ξ_j) with real poles and residues, in nearly linear time.

Newton's method for every root at once, each multiplied by the distance from its own pole and deflated by its
neighbours (Ehrlich–Aberth); for many poles the sums are taken by a tree of multipole expansions (Barnes and Hut's
scheme on a line), so that one sweep costs O(n log n) and not O(n²).
"""

from __future__ import annotations

import numpy as np

from percuss.model.checks import Array, ComplexArray

__all__ = ["cauchy_sums", "secular_roots"]

_EPS = np.finfo(float).eps
_DIRECT = 512  # below this many poles direct sums are faster
_LEAF = 48
_ORDER = 34  # 3^−34 < 1e-16
_FAR = 3.0  # an expansion is used from 3 radii on
_SWEEPS = 60
_NEIGHBOURS = 12


def secular_roots(poles: Array, residues: Array) -> ComplexArray:
    """Roots of 1 + Σ r_j/(μ − ξ_j) = 0, as many as there are poles.

    A pole whose residue vanishes is itself a root; equal poles are taken together. Each root is right to rounding when
    roots are well separated. The sum of the roots should be Σ ξ_j − Σ r_j: the caller checks it.

    Parameters
    ----------
    poles, residues
        Real, equal shapes (n,).

    Returns
    -------
    numpy.ndarray
        Complex, shape (n,), in no particular order.
    """
    order = np.argsort(poles)
    poles, residues = poles[order], residues[order]
    scale = max(1.0, float(np.abs(poles).max(initial=0.0)))
    starts = np.flatnonzero(np.append(True, np.diff(poles) > 4.0 * _EPS * scale))
    merged = np.add.reduceat(residues, starts) if poles.size else residues
    lone = poles[starts]
    repeated = np.delete(poles, starts)
    live = np.abs(merged) > _EPS * _EPS * scale
    settled = np.concatenate([repeated, lone[~live]]).astype(complex)
    return np.concatenate([settled, _iterate(lone[live], merged[live])])


def _iterate(poles: Array, residues: Array) -> ComplexArray:
    n = poles.size
    if n == 0:
        return np.empty(0, dtype=complex)
    z = _first_guess(poles, residues)
    active = np.arange(n)
    near = min(_NEIGHBOURS, n - 1)
    all_pairs = n <= _DIRECT
    for _ in range(_SWEEPS):
        here = z[active]
        own, strength = poles[active], residues[active]
        total, slope = cauchy_sums(here, poles, residues)
        away = here - own
        with np.errstate(divide="ignore", invalid="ignore"):
            others = total - strength / away
            bend = slope + strength / away**2  # derivative of the sum over the other poles
            f = away * (1.0 + others) + strength
            newton = f / (1.0 + others + away * bend)
            pull = _deflation(z, poles, active, near, all_pairs)
            step = newton / (1.0 + newton * pull)
        step = np.where(np.isfinite(step), step, 1e-3 * (np.abs(away) + np.abs(strength)) * (0.6 + 0.8j))
        limit = 0.5 * np.abs(away) + np.abs(strength) + 0.05
        size = np.abs(step)
        step *= np.minimum(1.0, limit / np.where(size > 0.0, size, 1.0))
        z[active] = here - step
        active = active[np.abs(step) > 4.0 * _EPS * np.maximum(np.abs(here), np.abs(away) * 1e-3)]
        if not active.size:
            break
    return z


def _first_guess(poles: Array, residues: Array) -> ComplexArray:
    """Beside each pole, where it would stand alone, off the real axis so that pairs can part."""
    shift = -residues
    room = np.minimum(np.diff(poles, prepend=poles[0] - 1.0), np.diff(poles, append=poles[-1] + 1.0))
    bounded = np.sign(shift) * np.minimum(np.abs(shift), 0.6 * room + 0.0 * shift)
    lone = np.where(np.abs(shift) > 0.5, shift, bounded)  # a strong residue moves its root far away
    tilt = np.where(np.arange(poles.size) % 2 == 0, 1.0, -1.0)
    return np.asarray(poles + lone + 0.3j * tilt * np.minimum(np.abs(lone) + 1e-16, room))


def _deflation(
    z: ComplexArray, poles: Array, active: np.typing.NDArray[np.intp], near: int, all_pairs: bool
) -> ComplexArray:
    """Σ over the other roots of 1/(z_k − ξ_i) − 1/(z_k − z_i): near neighbours, and all that moved far."""
    n, here = poles.size, z[active]
    if all_pairs:
        index = np.broadcast_to(np.arange(n), (active.size, n))
    else:
        low = np.clip(active - near // 2, 0, n - near - 1)
        index = low[:, None] + np.arange(near + 1)
        moved = np.flatnonzero(np.abs(z - poles) > 1e-3)[:256]
        outside = (moved[None, :] < low[:, None]) | (moved[None, :] > low[:, None] + near)
        index = np.concatenate([index, np.where(outside, moved, active[:, None])], axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        pairs = 1.0 / (here[:, None] - poles[index]) - 1.0 / (here[:, None] - z[index])
    return np.asarray(np.where(index == active[:, None], 0.0, pairs).sum(axis=1))


def cauchy_sums(z: ComplexArray, poles: Array, residues: Array) -> tuple[ComplexArray, ComplexArray]:
    """Σ r_j/(z − ξ_j) and its derivative −Σ r_j/(z − ξ_j)² at every z; poles increasing.

    Direct for few poles, else by a tree; both right to rounding (relative to the sum of the moduli).
    """
    total, slope = np.zeros_like(z), np.zeros_like(z)
    with np.errstate(divide="ignore", invalid="ignore"):
        if poles.size <= _DIRECT:
            _add_direct(z, np.arange(z.size), poles, residues, total, slope)
        else:
            _visit(z, np.arange(z.size), poles, residues, total, slope)
    return total, slope


def _add_direct(
    z: ComplexArray,
    where: np.typing.NDArray[np.intp],
    poles: Array,
    residues: Array,
    total: ComplexArray,
    slope: ComplexArray,
) -> None:
    inverse = 1.0 / (z[where, None] - poles[None, :])
    total[where] += inverse @ residues
    slope[where] -= (inverse * inverse) @ residues


def _visit(
    z: ComplexArray,
    where: np.typing.NDArray[np.intp],
    poles: Array,
    residues: Array,
    total: ComplexArray,
    slope: ComplexArray,
) -> None:
    """Add one node of the tree to the targets `where`: by its expansion if they are far, else through its halves."""
    centre, radius = 0.5 * (poles[0] + poles[-1]), 0.5 * (poles[-1] - poles[0])
    off = z[where] - centre
    far = np.abs(off) > _FAR * radius + 1e-12
    if far.any() and poles.size > _ORDER // 2:
        moments = residues @ ((poles - centre)[:, None] / max(radius, 1e-300)) ** np.arange(_ORDER)
        inverse = 1.0 / off[far]
        x = radius * inverse
        value, derivative = np.zeros_like(x), np.zeros_like(x)
        for order in range(_ORDER - 1, -1, -1):
            value = value * x + moments[order]
            derivative = derivative * x + (order + 1) * moments[order]
        total[where[far]] += value * inverse
        slope[where[far]] -= derivative * inverse**2
        where = where[~far]
    if not where.size:
        return
    if poles.size <= _LEAF:
        _add_direct(z, where, poles, residues, total, slope)
        return
    half = poles.size // 2
    _visit(z, where, poles[:half], residues[:half], total, slope)
    _visit(z, where, poles[half:], residues[half:], total, slope)
