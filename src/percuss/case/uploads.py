"""A recording that comes as bytes, read as a case that names it would have it read."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from percuss.case.apart import read_apart
from percuss.case.uploaded_file import FILE, PACKED, history_table, read_here
from percuss.case.vetting import plain_mat
from percuss.errors import CaseError, HistoryError

__all__ = ["SUFFIXES", "uploaded_history"]

_PLAIN = (".csv", ".tsv", ".txt", ".dat", ".wav")

SUFFIXES = (*_PLAIN, *PACKED)
"""What an uploaded recording may be called; the suffix says how it is read."""

_LONGEST_LINE = 20_000
"""Bytes of one line: millions of columns would be looked at one by one."""

_SMALL = 1_000_000
"""Bytes that are read in a second or two; what takes longer must be possible to give up."""


def uploaded_history(
    data: bytes, name: str, options: Mapping[str, Any], halt: Callable[[], bool] | None = None
) -> dict[str, Any]:
    """The load in the bytes of a recording: the table [load] that stands for it, what was found, what was assumed.

    The bytes lie in a file of our own naming while they are read; of `name` only the suffix counts. What can be packed
    or point elsewhere is looked into first, and then read by a process of its own, as is all that is large.

    Parameters
    ----------
    data
        The file.
    name
        What it is called where it comes from.
    options
        The other keys that [load] takes with ``kind = "history"``; with ``force_scale`` the load is dimensionless.
    halt
        Asked while another process reads; the recording is given up once it returns true.

    Raises
    ------
    CaseError
        When the recording cannot be read or used, or an option is wrong; with the key in [load].
    MissingExtraError
        When the package that reads it is not installed.
    Interrupted
        When `halt` returned true.

    Examples
    --------
    >>> import math
    >>> rows = [f"{t / 1000},{5 + 9 * math.cos(0.3 * t)}" for t in range(1000)]
    >>> text = "time [s],force [kN]\\n" + "\\n".join(rows)
    >>> uploaded_history(text.encode(), "mine.csv", {})["load"]["kind"]
    'fourier'
    """
    suffix = Path(name).suffix.lower()
    if suffix not in SUFFIXES:
        accepted = f"expected a name that ends in {', '.join(SUFFIXES)}"
        raise CaseError("upload", FILE, name, accepted, "save the recording as CSV")
    if suffix in _PLAIN and suffix != ".wav" and max(map(len, data.splitlines()), default=0) > _LONGEST_LINE:
        raise CaseError("upload", FILE, name, f"a line of more than {_LONGEST_LINE} bytes", "a line for each sample")
    given = {key: value for key, value in options.items() if value not in (None, "")}
    file = history_table(f"recording{suffix}", given).file
    if suffix == ".mat":
        try:
            data = plain_mat(data)
        except HistoryError as error:
            raise CaseError("upload", FILE, None, error.message, error.remedy) from None
    with tempfile.TemporaryDirectory(prefix="percuss-") as folder:
        Path(folder, file).write_bytes(data)
        if suffix in PACKED or len(data) > _SMALL:
            return read_apart(Path(folder, file), given, halt)
        return read_here(Path(folder, file), given)
