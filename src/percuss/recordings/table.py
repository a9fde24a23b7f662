"""What a file of measured series holds, before a column is chosen."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from percuss.errors import HistoryError
from percuss.units import DIMENSIONS, known_dimension

# ---- The kinds of arrays that the series of a recording are kept in

Array = npt.NDArray[np.float64]
ComplexArray = npt.NDArray[np.complex128]


# ---- What is looked for in a recording: forces and pressures of a load, or strains and stresses of a gauge


@dataclass(frozen=True)
class Sought:
    """The quantities that a column may be of, how such columns are called, and how messages speak of them.

    Parameters
    ----------
    dimensions
        Those of `percuss.units`, in the order in which a unit is tried.
    words
        What the heading of such a column begins with.
    named
        The quantities in a message.
    unit, heading
        A usual unit and a heading with it, for remedies.
    length
        How much of a record is needed besides samples, for a message.
    """

    dimensions: tuple[str, ...]
    words: re.Pattern[str]
    named: str
    unit: str
    heading: str
    length: str = ""

    @property
    def unit_remedy(self) -> str:
        """How to say what the unit is."""
        return f'give unit = "{self.unit}" (or "kN", …), or write it in the heading: "{self.heading} [{self.unit}]"'


LOAD = Sought(
    ("force", "pressure"),
    re.compile(
        r"(p|f|force|kraft|kraeften|druck|press\w*|pressure|tryck|pression|presion|paine|voima|fuerza|load|last)"
        r"(\d|\b|_)",
        re.IGNORECASE,
    ),
    "force or pressure",
    "bar",
    "pressure",
    ", over two whole cycles or more,",
)

_GAUGE = Sought(
    ("strain", "pressure", "force"),
    re.compile(
        r"(strain|stress|force|gauge|gage|eps|epsilon|ε|sigma|σ|dms|dehnung|spannung|kraft|töjning|tojning|spänning|"
        r"déformation|deformation|contrainte|f)(\d|\b|_)",
        re.IGNORECASE,
    ),
    "strain, stress or force",
    "µm/m",
    "strain",
)

SOUGHT = {"load": LOAD, "gauge": _GAUGE}
"""By the word that `read_recording` takes."""


# ---- What a file of measured series holds, before a column is chosen

RATE_REMEDY = 'give the rate of the recorder, in the form sample_rate = "… kHz"'
"""Where nothing in the file tells it."""


@dataclass(frozen=True)
class RecordedTable:
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

    def refused(self, message: str, remedy: str) -> HistoryError:
        """An error that names the file."""
        return HistoryError(message, remedy, self.file)

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


# ---- Samples without a value: how they are left out of a record, and how many may be

MOST_MISSING = 0.1
"""The share of the samples that may be missing."""


def without_gaps(time: Array, values: list[Array], table: RecordedTable, notes: list[str]) -> tuple[Array, list[Array]]:
    """The samples of which all values are there; nothing is filled in: cycles are fitted to samples as they lie."""
    there = np.all(np.isfinite(values), axis=0)
    missing = int(time.size - np.count_nonzero(there))
    if missing == 0:
        return time, values
    first = int(np.argmin(there))
    if missing > MOST_MISSING * time.size:
        raise table.refused(
            f"{missing} of {time.size} samples have no value, the first at {time[first]:.6g} s",
            f"at most {100.0 * MOST_MISSING:.0f} % may be missing: cut the record (from, to), or record again",
        )
    kept = time[there]
    gaps = np.flatnonzero(np.diff(np.concatenate([[1], there.astype(int), [1]])) == -1).size
    longest = float(np.max(np.diff(kept)))
    notes.append(
        f"{missing} of {time.size} samples have no value, in {gaps} gap{'s' if gaps > 1 else ''} of at most "
        f"{1e3 * longest:.3g} ms; they are left out, and nothing is filled in"
    )
    return kept, [v[there] for v in values]
