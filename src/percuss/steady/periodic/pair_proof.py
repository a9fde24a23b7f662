"""All orbits with two impacts of a rigid bar, with proof that there are no others: interval Newton's method.

Boxes of times (t, h), which together hold every pair of impacts, are thrown away where an equation cannot vanish, or
kept where Krawczyk's operator shows that there is exactly one root (Krawczyk, Computing 4 (1969) 187–201; Neumaier,
Interval Methods for Systems of Equations, 1990, ch. 5), and halved otherwise. All bounds hold rounding included. Where
the load has steps the derivative is the set of all that it has in the box, for which the same holds.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from percuss.halting import look
from percuss.model import System
from percuss.model.checks import Array
from percuss.steady.periodic.ball import UNIT, Ball
from percuss.steady.periodic.pair_equations import PairEquations, Pairs
from percuss.steady.periodic.sameness import SAME

__all__ = ["proved_pairs"]

_COARSE = 0.5  # rad, of the first boxes
_WIDER = 1.1  # what is looked at is so much wider than a box, so that roots on an edge are inside
_NARROWEST = 1e-9  # rad; a box that is undecided then has a root that is none or many
_MOST = 3_000_000  # boxes
_AT_ONCE = 1 << 15
_SHARPER = 8  # times that the enclosure of a root is made narrower
_PRECISE = 1e-9  # rad


class _Enclosed(NamedTuple):
    """Boxes in which there is exactly one root, and how much narrower it is known; each array of the shape (K, 2)."""

    mid: Array
    rad: Array
    root: Array
    error: Array


def proved_pairs(system: System, periods: int, turn: float) -> Array | None:
    """The times of all pairs of impacts that solve the equations, each once; None where that is not proved.

    It is not where a root is degenerate, as at a fold or at a step of the load, where the rigid velocity does not
    follow from the times (R = 1 without drag), and where it would take millions of boxes.

    Parameters
    ----------
    system, periods
        The rigid bar, and n; of a body that is held nothing is proved.
    turn
        After how long the load repeats.

    Returns
    -------
    numpy.ndarray
        t_1 and t_2, shape (K, 2): to 1e-9.
    """
    if not system.body.is_free:
        return None
    equations = PairEquations(system, periods)
    if not equations.is_solvable:
        return None
    every = _boxes(equations, turn, math.pi * periods)
    if every is None:
        return None
    found = _sharpened(equations, every)
    period = 2.0 * math.pi * periods
    kept: list[int] = []
    for i in range(found.root.shape[0]):
        again = [j for j in kept if _apart(found, i, j, period, turn)[0] <= SAME]
        if float(found.error[i].max()) > _PRECISE or not all(_apart(found, i, j, period, turn)[1] for j in again):
            return None
        if not again:
            kept.append(i)
    return np.stack([found.root[kept, 0], found.root[kept].sum(axis=1)], axis=1)


def _boxes(equations: PairEquations, turn: float, longest: float) -> _Enclosed | None:
    """The boxes with one root each, of boxes that hold all times; None where some stay undecided."""
    mid, rad = _covering(turn, longest)
    kept: list[_Enclosed] = []
    looked = 0
    while mid.size:
        looked += mid.shape[0]
        if looked > _MOST or rad.min() < _NARROWEST:
            return None
        halves = []
        for first in range(0, mid.shape[0], _AT_ONCE):
            look()
            part = slice(first, first + _AT_ONCE)
            found, left = _decided(equations, mid[part], rad[part])
            kept.append(found)
            halves.append(left)
        mid, rad = (np.concatenate(parts) for parts in zip(*halves, strict=True))
    return _Enclosed(*(np.concatenate(parts) for parts in zip(*kept, strict=True)))


def _apart(found: _Enclosed, one: int, other: int, period: float, turn: float) -> tuple[float, bool]:
    """How far two roots are apart, but for shifts, and whether the first is surely in the box of the second."""
    t, h = found.root[one].tolist()
    forms = np.array([[t, h], [t + h, period - h]])
    off = forms - found.root[other]
    forms[:, 0] -= turn * np.rint(off[:, 0] / turn)
    off = np.abs(forms - found.root[other]).max(axis=1)
    nearest = int(np.argmin(off))
    room = found.rad[other] - np.abs(forms[nearest] - found.mid[other])
    return float(off[nearest]), bool(np.all(2.0 * found.error[one].sum() + 1e-14 * period < room))


def _covering(turn: float, longest: float) -> tuple[Array, Array]:
    """Boxes that cover t in [0, turn], h in [0, longest]: the shorter flight comes first."""
    counts = [max(1, math.ceil(side / _COARSE)) for side in (turn, longest)]
    rads = np.array(
        [0.5 * side / count * (1.0 + 4.0 * UNIT) for side, count in zip((turn, longest), counts, strict=True)]
    )
    axes = [(np.arange(count) + 0.5) * 2.0 * rad for count, rad in zip(counts, rads, strict=True)]
    mid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 2)
    return mid, np.broadcast_to(rads, mid.shape).copy()


def _decided(equations: PairEquations, mid: Array, rad: Array) -> tuple[_Enclosed, tuple[Array, Array]]:
    """The boxes with one root, with its enclosure; and halves of those that are undecided."""
    wide = _WIDER * rad
    low, high = np.maximum(mid[:, 1] - wide[:, 1], 0.0), mid[:, 1] + wide[:, 1]  # no flight is shorter than 0
    place = np.stack([mid[:, 0], 0.5 * (low + high)], axis=1)
    wide = np.stack([wide[:, 0], 0.5 * (high - low)], axis=1)
    whole, values, noise = _looked_at(equations, place, wide)
    steep = _steepness(whole)
    reach = (steep @ wide[..., None])[..., 0] * (1.0 + 8.0 * UNIT) + noise
    empty = (np.abs(values) > reach * (1.0 + 8.0 * UNIT)).any(axis=1)
    empty |= ~whole.per_flight.may_vanish | ~whole.second.may_vanish
    root, error, one, none = _krawczyk(whole, values, noise, place, wide)
    one &= ~empty
    split = ~(empty | one | none)
    halves = _halved(mid[split], rad[split], steep[split])
    return _Enclosed(place[one], wide[one], root[one], error[one]), halves


def _looked_at(equations: PairEquations, mid: Array, rad: Array) -> tuple[Pairs, Array, Array]:
    """The equations over boxes, their values in the middle, and how inexact those are; shapes (B, 2)."""
    none = np.zeros(mid.shape[0])
    point = equations.over(Ball(mid[:, 0], none), Ball(mid[:, 1], none))
    values, noise = (np.stack(part, axis=1) for part in zip(*((b.mid, b.rad) for b in point[:2]), strict=True))
    return equations.over(Ball(mid[:, 0], rad[:, 0]), Ball(mid[:, 1], rad[:, 1])), values, noise


def _steepness(whole: Pairs) -> Array:
    """Bounds of the moduli of the derivatives; shape (B, 2, 2)."""
    return _matrices([[ball.most for ball in row] for row in zip(whole.by_t, whole.by_h, strict=True)])


def _matrices(rows: list[list[Array]]) -> Array:
    """Matrices of rows of numbers; shape (B, 2, 2)."""
    return np.stack([np.stack(row, axis=1) for row in rows], axis=1)


def _krawczyk(
    whole: Pairs, values: Array, noise: Array, mid: Array, wide: Array
) -> tuple[Array, Array, npt.NDArray[np.bool_], npt.NDArray[np.bool_]]:
    """Krawczyk's operator m − AF(m) + (1 − AF')(X − m): its middle, its radius; whether it is inside, or elsewhere."""
    rows = list(zip(whole.by_t, whole.by_h, strict=True))
    matrix, spread = (_matrices([[getattr(ball, part) for ball in row] for row in rows]) for part in ("mid", "rad"))
    with np.errstate(all="ignore"):
        determinant = matrix[:, 0, 0] * matrix[:, 1, 1] - matrix[:, 0, 1] * matrix[:, 1, 0]
        usable = np.isfinite(determinant) & (determinant != 0.0)
        safe = np.where(usable, determinant, 1.0)
        turned = [[matrix[:, 1, 1], -matrix[:, 0, 1]], [-matrix[:, 1, 0], matrix[:, 0, 0]]]
        inverse = _matrices(turned) / safe[:, None, None]
        size = np.abs(inverse)
        away = np.abs(np.eye(2) - inverse @ matrix) + 8.0 * UNIT * (size @ np.abs(matrix) + 1.0) + size @ spread
        centre = mid - (inverse @ values[..., None])[..., 0]
        rounding = 8.0 * UNIT * (np.abs(mid) + (size @ np.abs(values)[..., None])[..., 0])
        error = (1.0 + 32.0 * UNIT) * ((size @ noise[..., None])[..., 0] + rounding + (away @ wide[..., None])[..., 0])
        off = np.abs(centre - mid) * (1.0 + 2.0 * UNIT)
        one = usable & (off + error < wide).all(axis=1)
        none = usable & (off - error > wide).any(axis=1)
    return centre, error, one, none


def _halved(mid: Array, rad: Array, steep: Array) -> tuple[Array, Array]:
    """Each box as two, cut where that narrows the equations most."""
    share = (steep / np.maximum(steep.max(axis=2, keepdims=True), 1e-300)).max(axis=1) * rad
    axis = np.where(share[:, 1] > share[:, 0], 1, 0)
    rows = np.arange(mid.shape[0])
    half = rad.copy()
    half[rows, axis] *= 0.5 * (1.0 + 4.0 * UNIT)
    ends = [mid.copy(), mid.copy()]
    for end, sign in zip(ends, (-1.0, 1.0), strict=True):
        end[rows, axis] += sign * half[rows, axis]
    return np.concatenate(ends), np.concatenate([half, half])


def _sharpened(equations: PairEquations, found: _Enclosed) -> _Enclosed:
    """The roots known better, by the same operator over what it gave."""
    for _ in range(_SHARPER if found.mid.size else 0):
        whole, values, noise = _looked_at(equations, found.root, found.error)
        better, narrower, _, _ = _krawczyk(whole, values, noise, found.root, found.error)
        use = np.all(narrower < found.error, axis=1, keepdims=True)
        found = found._replace(root=np.where(use, better, found.root), error=np.where(use, narrower, found.error))
    return found
