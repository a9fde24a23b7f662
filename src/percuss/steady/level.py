"""The level that the rigid velocity must meet at an impact: the right-hand side of B77 (14)."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from percuss.errors import ParameterError
from percuss.model import System
from percuss.model.body import need_free
from percuss.model.checks import Array, non_negative, numbers, positive
from percuss.model.contact import impedance_ratio, restitutions

__all__ = ["langevin", "level", "level_at", "level_factor", "level_of", "ratio_at"]

_SERIES = (1 / 3, -1 / 45, 2 / 945, -1 / 4725, 2 / 93555, -1382 / 638512875, 4 / 18243225, -3617 / 162820783125)
_SMALL = 0.2  # the series with 8 terms is right to 1e-17 relative below this


def langevin(x: npt.ArrayLike) -> Array:
    """coth x − 1/x for x ≥ 0, right to full relative precision down to x = 0, where it is 0."""
    x = np.asarray(x, dtype=float)
    small = x < _SMALL
    y = np.where(small, x, 0.0)
    series = np.zeros_like(y)
    for coefficient in reversed(_SERIES):
        series = coefficient + y**2 * series
    safe = np.where(small, 1.0, x)
    return np.asarray(np.where(small, y * series, 1.0 / np.tanh(safe) - 1.0 / safe))


def level_factor(damping: npt.ArrayLike, ratio: npt.ArrayLike) -> Array:
    """c/(p_0 T) as a function of dT and the law's impedance ratio: [coth(dT/2) − 2/(dT)]/2 + (1 − R)/(2(1 + R)).

    Both terms are positive, so no digit is lost anywhere; as d → 0 the first one vanishes.
    """
    return 0.5 * langevin(0.5 * np.asarray(damping, dtype=float)) + 0.5 * np.asarray(ratio, dtype=float)


def level(mean: npt.ArrayLike, d: float, restitution: npt.ArrayLike, period: float) -> Array:
    """c(d, R) of B77 (14) for mean load p_0 and impact period T (all dimensionless); broadcasts over p_0 and R."""
    mean, restitution = numbers("mean", mean), restitutions(restitution)
    try:
        return level_at(mean, non_negative("d", d), impedance_ratio(restitution), positive("period", period))
    except ValueError as error:
        if isinstance(error, ParameterError):
            raise
        raise ParameterError("mean", f"shape {mean.shape}", "numbers in a shape that fits the restitution's") from None


def level_at(mean: npt.ArrayLike, d: float, ratio: npt.ArrayLike, period: float) -> Array:
    """`level` of numbers that have been looked at, for any law, by its `Contact.impedance_ratio`."""
    return np.asarray(mean, dtype=float) * period * level_factor(d * period, ratio)  # B77 (14)


def level_of(system: System, period: float) -> float:
    """c of a system with impacts every T = `period`."""
    need_free(system.body, "the level of B77 (14)")
    return float(level_at(system.load.mean, system.d, system.contact.impedance_ratio, period))


def ratio_at(mean: float, d: float, height: Array, period: float) -> Array:
    """The impedance ratio at which the level has this height, `level_at` backwards; shape of `height`.

    Examples
    --------
    >>> import numpy as np
    >>> ratio_at(0.9, 0.0, np.array([float(level_at(0.9, 0.0, 0.25, 6.28))]), 6.28).round(12)
    array([0.25])
    """
    return np.asarray(2.0 * height / (mean * period) - float(langevin(np.array(0.5 * d * period))))
