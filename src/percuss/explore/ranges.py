"""Where along the one axis of a map something is true: ranges whose ends are solved for between its values."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from percuss.errors import ParameterError
from percuss.explore.axis import Axis
from percuss.explore.parameters import PERIODS
from percuss.explore.sweep_job import SweepJob
from percuss.explore.sweeps import Sweep

__all__ = ["Range", "true_ranges"]

_HALVES = 30
_LAST = 1e-9  # share of the axis to which an end is found


@dataclass(frozen=True)
class Range:
    """A part of an axis, in its unit.

    Attributes
    ----------
    first, last
        Its ends, inside it.
    opens, closes
        Whether it ends there, and not with the axis.
    """

    first: float
    last: float
    opens: bool
    closes: bool


def true_ranges(job: SweepJob, found: Sweep, quantity: str) -> tuple[Range, ...]:
    """Where a yes-or-no quantity of a map with one axis is true.

    An end lies between two neighbouring values of the axis; the cells between them are asked until it is known to 1e-9
    of the axis. What begins and ends between two neighbours is not seen.

    Parameters
    ----------
    job, found
        The map's job and what it came to.
    quantity
        Such as ``stable``, ``exists`` or ``admissible``.

    Raises
    ------
    ParameterError
        For a map with more than one axis, or a quantity that is not yes or no.

    Examples
    --------
    >>> from percuss import Load, System
    >>> from percuss.explore import Sweep
    >>> from percuss.explore.sweep_question import sweep_job
    >>> rigid = System(s=1e7, d=0.0, restitution=0.5, load=Load.harmonic(0.9, 1.0))
    >>> job = sweep_job(rigid, "load_factor=0.1:1.2:12", quantities=["reduced_stable"])
    >>> found = Sweep.shaped(job, job.compute(0, job.size, lambda: False))
    >>> [(round(part.first, 6), round(part.last, 6)) for part in true_ranges(job, found, "reduced_stable")]
    [(0.654954, 0.95493)]
    """
    if len(job.axes) != 1:
        raise ParameterError("axes", len(job.axes), "a map with one axis")
    values, truth = job.axes[0].values, found[quantity]
    if truth.dtype != bool or truth.ndim != 1:
        raise ParameterError("quantity", quantity, "one that is yes or no, such as stable or exists")
    ranges = []
    edges = np.flatnonzero(np.diff(np.concatenate([[False], truth, [False]]).astype(int)))
    for i, j in zip(edges[::2].tolist(), (edges[1::2] - 1).tolist(), strict=True):
        opens, closes = i > 0, j < values.size - 1
        first = _end(job, quantity, float(values[i]), float(values[i - 1])) if opens else float(values[i])
        last = _end(job, quantity, float(values[j]), float(values[j + 1])) if closes else float(values[j])
        ranges.append(Range(first, last, opens, closes))
    return tuple(ranges)


def _end(job: SweepJob, quantity: str, inside: float, outside: float) -> float:
    """The last value at which it is true, from one where it is towards one where it is not."""
    axis = job.axes[0]
    if axis.name == PERIODS:
        return inside
    alone = replace(job, quantities=(quantity,), functions=())
    for _ in range(_HALVES):
        if abs(outside - inside) <= _LAST * float(np.ptp(axis.values)):
            break
        middle = 0.5 * (inside + outside)
        cell = replace(alone, axes=(Axis(axis.name, np.array([middle]), axis.unit),))
        if cell.compute(0, 1, lambda: False)[quantity][0]:
            inside = middle
        else:
            outside = middle
    return inside
