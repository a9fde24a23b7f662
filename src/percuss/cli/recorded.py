"""``percuss machine`` of a recorded load: what is said of its blows, and the answer."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from percuss.errors import HistoryError
from percuss.units import si

if TYPE_CHECKING:
    import argparse

    from percuss.case import Case, RecordedAnswer

__all__ = ["asked_of_record", "read_record"]

_OPTIONS = ("blow", "blows", "longest_delay")


def asked_of_record(options: argparse.Namespace) -> list[str]:
    """The options that were given which only a recorded load has."""
    return [f"--{name.replace('_', '-')}" for name in _OPTIONS if getattr(options, name) is not None]


def read_record(case: Case, options: argparse.Namespace) -> RecordedAnswer:
    """The answer for a load that is a recording, or steps.

    Raises
    ------
    UnitError
        For a time without a unit, or with that of another quantity.
    HistoryError
        When the file of the blows cannot be read.
    """
    from percuss.case import recorded_answer

    longest, unit = options.longest_delay, "time" if case.is_si else "dimensionless"
    return recorded_answer(
        case,
        options.modes,
        blow=None if options.blow is None else si(options.blow, "time", "--blow"),
        blows=None if options.blows is None else _times(options.blows),
        longest_delay=None if longest is None else si(longest, unit, "--longest-delay"),
    )


def _times(path: str) -> list[float]:
    """The times of the blows, one in a line."""
    try:
        lines = Path(path).read_text(encoding="utf-8").splitlines()
    except (OSError, ValueError) as error:
        raise HistoryError(f"cannot be read ({error})", "give a text file", path) from None
    found = []
    for number, line in enumerate(lines, 1):
        try:
            if line.strip():
                found.append(float(line))
        except ValueError:
            raise HistoryError(f"line {number} is {line!r:.40}", "give one time in s in a line", path) from None
    return found
