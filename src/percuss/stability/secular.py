"""All roots of the secular function F(μ) = 1 + Σ r_j/(μ − ξ_j) in nearly linear time; poles real or complex.

Newton's method for every root at once, each multiplied by the distance from its own pole and deflated by all the others
(Ehrlich–Aberth); for many poles the sums are taken by a tree of multipole expansions (Barnes and Hut's scheme), so that
one sweep costs O(n log n) and not O(n²).
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from percuss.halting import look
from percuss.model.checks import Array, ComplexArray

__all__ = ["cauchy_sums", "secular_roots"]

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
Numbers = npt.NDArray[Any]  # real or complex


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
