"""A recording that comes as bytes, read as a case that names it would have it read."""

from __future__ import annotations

import re
import tempfile
from collections.abc import Callable, Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from percuss.case.apart import read_apart
from percuss.case.plain import plain
from percuss.case.problems import from_validation, raise_all
from percuss.case.recorded import history_load
from percuss.case.schema import HistoryForce, HistoryLoad
from percuss.case.tables import fourier_table
from percuss.case.vetting import plain_mat, vetted
from percuss.errors import CaseError, HistoryError

__all__ = ["SUFFIXES", "read_here", "uploaded_history"]

_PLAIN = (".csv", ".tsv", ".txt", ".dat", ".wav")
_PACKED = (".mat", ".h5", ".hdf5", ".tdms")

SUFFIXES = (*_PLAIN, *_PACKED)
"""What an uploaded recording may be called; the suffix says how it is read."""

_FILE = "load.file"

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
        raise CaseError("upload", _FILE, name, accepted, "save the recording as CSV")
    if suffix in _PLAIN and suffix != ".wav" and max(map(len, data.splitlines()), default=0) > _LONGEST_LINE:
        raise CaseError("upload", _FILE, name, f"a line of more than {_LONGEST_LINE} bytes", "a line for each sample")
    given = {key: value for key, value in options.items() if value not in (None, "")}
    file = _table(f"recording{suffix}", given).file
    if suffix == ".mat":
        try:
            data = plain_mat(data)
        except HistoryError as error:
            raise CaseError("upload", _FILE, None, error.message, error.remedy) from None
    with tempfile.TemporaryDirectory(prefix="percuss-") as folder:
        Path(folder, file).write_bytes(data)
        if suffix in _PACKED or len(data) > _SMALL:
            return read_apart(Path(folder, file), given, halt)
        return read_here(Path(folder, file), given)


def read_here(path: Path, options: Mapping[str, Any]) -> dict[str, Any]:
    """As `uploaded_history`, of a file of ours.

    Raises
    ------
    CaseError, MissingExtraError
        As there.
    """
    folder = str(path.parent)
    table = _table(path.name, dict(options))
    try:
        if path.suffix in _PACKED:
            vetted(path)
        load, notes = history_load(table, "upload", path.parent)
    except HistoryError as error:
        raise CaseError("upload", _FILE, None, error.message, error.remedy) from None
    except CaseError as error:
        raise _without(error, folder) from None
    kind = fourier_table(load)
    if isinstance(table, HistoryLoad):
        kind = {key: kind[key] for key in ("kind", "coefficients")}
    return {
        "load": kind,
        "report": None if load.report is None else plain(asdict(load.report)),
        "notes": [_clean(note, folder) for note in notes],
    }


def _table(file: str, options: dict[str, Any]) -> HistoryForce:
    form = HistoryLoad if "force_scale" in options else HistoryForce
    given = {"kind": "history", "file": file, **options}
    try:
        return form.model_validate(given)
    except ValidationError as error:
        fields = {"load": list(form.model_fields)}
        raise_all(from_validation(error, "upload", {"load": given}, fields))


def _without(error: CaseError, folder: str) -> CaseError:
    """The same problem without the name of our file."""
    value = None if error.key == _FILE else error.value
    return CaseError("upload", error.key, value, _clean(error.accepted, folder), _clean(error.remedy, folder))


def _clean(text: str, folder: str) -> str:
    return re.sub(re.escape(folder) + r"/?", "", text)
