"""What a file of measured series holds, before a column is chosen."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass

from percuss.recordings.arrays import Array
from percuss.recordings.sought import LOAD, Sought
from percuss.units import DIMENSIONS, known_dimension

__all__ = ["RATE_REMEDY", "Table", "as_rate", "dimension"]

RATE_REMEDY = 'give the rate of the recorder, in the form sample_rate = "… kHz"'
"""Where nothing in the file tells it."""


@dataclass(frozen=True)
class Table:
    """What a file holds, before a column is chosen."""

    file: str
    names: list[str]  # headings without their units; "" where there is none
    units: list[str | None]
    numeric: list[bool]
    read: Callable[[list[int]], list[Array]]
    where: Callable[[int], str] = lambda i: f"sample {i + 1}"
    sample_rate: float | None = None  # as the file itself says
    stamped: tuple[int, ...] = ()  # columns of dates and times of day, …
    stamps: Callable[[int], list[str]] = lambda i: []  # … and their cells
    sought: Sought = LOAD

    def heading(self, i: int) -> str:
        name = f'"{self.names[i]}"' if self.names[i] else f"column {i + 1}"
        return f"{name} [{self.units[i]}]" if self.units[i] else name

    def listing(self, columns: Iterable[int]) -> str:
        shown = [self.heading(i) for i in columns]
        return ", ".join(shown[:12]) + (f" and {len(shown) - 12} more" if len(shown) > 12 else "")


def as_rate(rate: float) -> str:
    """A sample rate as it is written in a case file."""
    return f'"{1e-3 * rate:.6g} kHz"' if rate > 999.9995 else f'"{rate:.6g} Hz"'


def dimension(unit: str | None) -> str | None:
    """What a unit in a heading measures, as far as the closed table knows."""
    return known_dimension(unit, ("time", "force", "pressure", *DIMENSIONS)) if unit else None
