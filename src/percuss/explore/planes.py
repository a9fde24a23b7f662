"""Maps over restitution, load factor and m alone: the closed form and the multipliers over whole arrays."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import numpy.typing as npt

from percuss.errors import PercussError
from percuss.explore.cells import Asked, cell_columns, empty_columns, failure
from percuss.explore.family import Family
from percuss.explore.jobs.job import Columns
from percuss.explore.parameters import PERIODS
from percuss.explore.quantities import BRANCHES, QUANTITIES, needs
from percuss.model import System
from percuss.model.checks import Array
from percuss.stability import stability_plane
from percuss.stability.multipliers import NEUTRAL
from percuss.steady.phases import Arcs, forced_response

__all__ = ["AXES", "fits_plane", "plane_columns"]

_MOST = 1 << 20
"""Branches × cells handled at once: a load of a thousand harmonics has two thousand branches."""

AXES = ("restitution", "load_factor", PERIODS)
"""What may vary where arrays answer."""

_NAMES = {"exists", "orbits", "phases", "phase", "reduced_stable", "reduced_margin", "stable", "margin"}


def fits_plane(family: Family, axes: Sequence[str], quantities: Sequence[str]) -> bool:
    """Whether arrays can answer: only R, p_0/p_1 and m vary, and no quantity needs a cell for itself."""
    if not set(axes) <= set(AXES) or not set(quantities) <= _NAMES:
        return False
    try:
        system = family.system({})
        return system.body.is_free and not system.load.is_constant
    except PercussError:
        return False


def plane_columns(asked: Asked, system: System, values: Mapping[str, Array], periods: npt.NDArray[np.int64]) -> Columns:
    """The columns of cells that differ from a system in these parameters and in m."""
    out = empty_columns(asked.names, periods.size, asked.si)
    restitution = values.get("restitution", np.full(periods.size, system.restitution))
    factor = values.get("load_factor", np.full(periods.size, system.load.load_factor))
    bad = ~((restitution >= 0.0) & (restitution <= 1.0))
    out["outcome"][:] = np.where(bad, 4, np.where(factor > 0.0, 0, 1))
    lossless = (system.contact.velocity_factors(restitution) == -1.0) & ~bad & (system.d == 0.0)
    _one_by_one(out, np.flatnonzero(lossless), asked, system, restitution, factor, periods)
    for m in np.unique(periods[~lossless]):
        rows = np.flatnonzero((periods == m) & ~bad & ~lossless)
        try:
            size = max(1, _MOST // Arcs.of(forced_response(system)).ends.size)
            for part in (rows[i : i + size] for i in range(0, rows.size, size)):
                _fill(out, part, asked, system, restitution[part], factor[part], int(m))
        except (PercussError, ArithmeticError) as error:
            out["outcome"][rows] = failure(error)
    return out


def _one_by_one(
    out: Columns,
    rows: npt.NDArray[np.intp],
    asked: Asked,
    system: System,
    restitution: Array,
    factor: Array,
    periods: npt.NDArray[np.int64],
) -> None:
    """The cells with R = 1 and d = 0, where only `steady_states` knows whether the bar's ringing grows for ever."""
    if not rows.size:
        return
    pairs = zip(restitution[rows].tolist(), factor[rows].tolist(), strict=True)
    systems = [system.with_restitution(r).with_load_factor(value) for r, value in pairs]
    n = rows.size
    found = cell_columns(asked, systems, [0] * n, periods[rows].tolist(), [None] * n, lambda: False)
    for name, values in found.items():
        out[name][rows] = values


def _fill(
    out: Columns, rows: npt.NDArray[np.intp], asked: Asked, system: System, restitution: Array, factor: Array, m: int
) -> None:
    plane = stability_plane(system, restitution, factor, m)
    there = ~np.isnan(plane.phase)
    found: dict[str, npt.ArrayLike] = {"exists": there.any(axis=0), "orbits": there.sum(axis=0)}
    reduced = np.where(there, 1.0 - _largest(plane.a), np.nan)
    best = reduced
    found["reduced_margin"] = _greatest(reduced)
    found["reduced_stable"] = np.nan_to_num(found["reduced_margin"], nan=-1.0) > NEUTRAL
    if "exact" in needs(asked.names):
        from percuss.stability.exact_plane import exact_plane

        exact = exact_plane(system, restitution, factor, m, modes=asked.modes, plane=plane, threads=1)
        best = exact.margin
        found["stable"] = exact.stable.any(axis=0)
        found["margin"] = _greatest(exact.margin)
    if "phase" in out:
        at = np.argmax(np.where(np.isnan(best), -np.inf, best), axis=0)
        found["phase"] = np.take_along_axis(plane.phase, at[None], axis=0)[0]
    if "phases" in out:
        phases = np.full((rows.size, BRANCHES), np.nan)
        ordered = np.sort(plane.phase, axis=0)[:BRANCHES].T
        phases[:, : ordered.shape[1]] = ordered
        found["phases"] = phases
    for name in asked.names:
        for key in QUANTITIES[name].columns:
            if key in found:
                out[key][rows] = found[key]


def _largest(a: Array) -> Array:
    """Largest modulus of the roots of a_2 ξ² + a_1 ξ + a_0; shape of one coefficient."""
    a_0, a_1, a_2 = a
    with np.errstate(invalid="ignore", divide="ignore"):
        inside = a_1 * a_1 - 4.0 * a_2 * a_0
        big = -0.5 * (a_1 + np.copysign(np.sqrt(np.maximum(inside, 0.0)), a_1))
        real = np.maximum(np.abs(big / a_2), np.where(big == 0.0, 0.0, np.abs(a_0 / big)))
        return np.asarray(np.where(inside < 0.0, np.sqrt(np.abs(a_0 / a_2)), real))


def _greatest(values: Array) -> Array:
    """Along the branches, without the NaN of those that hold no root; NaN where none does."""
    least = np.where(np.isnan(values), -np.inf, values).max(axis=0)
    return np.asarray(np.where(np.isneginf(least), np.nan, least))
