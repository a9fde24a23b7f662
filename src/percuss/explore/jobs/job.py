"""What is to be carried out, whoever asks for it: independent items with columns of numbers."""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from operator import itemgetter
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

ASK_FORMAT = 1  # of what is asked, as an archive keeps it; every ask has it as ``percuss``

Columns = dict[str, npt.NDArray[Any]]  # arrays by name, each of shape (items, *shape of one item)


class Runs:
    """Which items are there, as runs of them in order: memory for the gaps, not for the items."""

    def __init__(self) -> None:
        self._all: list[tuple[int, int]] = []

    def gaps(self, first: int, last: int) -> list[tuple[int, int]]:
        """The runs of the items `first` … `last` − 1 that are not there, as (first, last)."""
        found: list[tuple[int, int]] = []
        i = bisect_right(self._all, first, key=itemgetter(1))
        while first < last:
            begin, end = self._all[i] if i < len(self._all) else (last, last)
            if first < begin:
                found.append((first, min(begin, last)))
            first, i = max(first, end), i + 1
        return found

    def add(self, first: int, last: int) -> None:
        """The items `first` … `last` − 1 are there from now on."""
        low, high = bisect_left(self._all, first, key=itemgetter(1)), bisect_right(self._all, last, key=itemgetter(0))
        touched = [*self._all[low:high], (first, last)]
        self._all[low:high] = [(min(a for a, _ in touched), max(b for _, b in touched))]


@dataclass(frozen=True)
class Column:
    """One number, or one small array of numbers, of every item.

    Parameters
    ----------
    dtype
        numpy's name of the type: ``float64``, ``int16``, ``bool``.
    shape
        Of one item.
    unit
        As xarray's ``units`` attribute has it; empty for dimensionless.
    fill
        What an item not yet computed holds; NaN by default for floats, −1 for integers, False for bool.
    meaning
        A sentence, kept beside the data as ``long_name``.
    """

    dtype: str = "float64"
    shape: tuple[int, ...] = ()
    unit: str = ""
    fill: float | int | bool | None = None
    meaning: str = ""

    @property
    def empty(self) -> float | int | bool:
        """The fill value, chosen by the type when none is given."""
        if self.fill is not None:
            return self.fill
        kind = np.dtype(self.dtype).kind
        return False if kind == "b" else -1 if kind in "iu" else float("nan")


class Job(Protocol):
    """Independent items, computed in any order and in any portions, each always the same to the last bit.

    A job travels to other processes and machines, so it must be picklable; what is expensive to build is made where it
    is needed and kept there. One that has an attribute `rough_seconds`, what it takes by rule of thumb, is carried out
    in one process when that is little; the number must not depend on the machine.
    """

    @property
    def size(self) -> int:
        """Number of items."""

    @property
    def columns(self) -> Mapping[str, Column]:
        """What is computed of each item."""

    @property
    def ask(self) -> dict[str, Any]:
        """All that was asked for, of JSON's types: the same ask gives the same numbers."""

    def compute(self, first: int, last: int, stopped: Callable[[], bool]) -> Columns:
        """Items `first` … `last` − 1; an item that fails carries its outcome in a column.

        `stopped` says when the answer is no longer wanted; what is returned then does not matter.
        """
