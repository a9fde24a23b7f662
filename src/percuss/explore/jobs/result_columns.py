"""All columns of a job in memory, and which items are there."""

from __future__ import annotations

import math
import os

import numpy as np
import numpy.typing as npt

from percuss.errors import PercussError
from percuss.explore.jobs.job import Columns, Job

__all__ = ["Sheet", "bytes_of", "check_memory", "runs"]


def bytes_of(job: Job) -> int:
    """What the columns of a job take."""
    item = sum(np.dtype(column.dtype).itemsize * math.prod(column.shape) for column in job.columns.values())
    return job.size * item


def check_memory(job: Job) -> None:
    """Refuse a job whose columns do not fit into memory.

    Raises
    ------
    PercussError
        Which says how much it takes and how much there is.
    """
    needed, there = bytes_of(job) + job.size, _memory()
    if needed > there:
        told = f"{job.size} items take {needed / 1e9:.3g} GB and this machine has {there / 1e9:.3g} GB of memory"
        raise PercussError(told, "ask for fewer, for instance in several parts, or for fewer quantities of each")


class Sheet:
    """The columns of a job, filled in any order.

    Attributes
    ----------
    columns
        Arrays of shape (size, *shape of an item); the fill value where nothing is known.
    known
        Which items are there, bool of shape (size,).
    """

    def __init__(self, job: Job) -> None:
        self.columns: Columns = {
            name: np.full((job.size, *column.shape), column.empty, dtype=column.dtype)
            for name, column in job.columns.items()
        }
        self.known = np.zeros(job.size, dtype=bool)

    def put(self, first: int, last: int, columns: Columns) -> int:
        """Write the items `first` … `last` − 1; returns how many of them are new.

        Raises
        ------
        ValueError
            When the job computed other columns than it announced.
        """
        if columns.keys() != self.columns.keys():
            raise ValueError(f"the job computed {sorted(columns)} and announced {sorted(self.columns)}")
        for name, values in columns.items():
            place = self.columns[name][first:last]
            if np.shape(values) != place.shape:
                raise ValueError(f"column {name}: the job computed shape {np.shape(values)}, not {place.shape}")
            place[...] = values
        new = last - first - int(np.count_nonzero(self.known[first:last]))
        self.known[first:last] = True
        return new

    def part(self, first: int, last: int) -> Columns:
        """The columns of some items."""
        return {name: values[first:last] for name, values in self.columns.items()}

    def gaps(self, first: int, last: int) -> list[tuple[int, int]]:
        """The runs of items that are not there, as (first, last)."""
        return [(first + a, first + b) for a, b in runs(~self.known[first:last])]

    def is_full(self, first: int, last: int) -> bool:
        """Whether all of these items are there."""
        return bool(self.known[first:last].all())


def runs(truth: npt.NDArray[np.bool_]) -> list[tuple[int, int]]:
    """The runs of places where something is true, as (first, last).

    Examples
    --------
    >>> runs(np.array([True, True, False, True]))
    [(0, 2), (3, 4)]
    """
    edges = np.flatnonzero(np.diff(np.concatenate([[False], truth, [False]]).astype(np.int8)))
    return [(int(a), int(b)) for a, b in edges.reshape(-1, 2)]


def _memory() -> float:
    try:
        return float(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES"))
    except (AttributeError, ValueError, OSError):  # not on every system
        return math.inf
