"""A recording in a file of our own naming, read as a case that names it would have it read."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from percuss.case.answers.facts import plain
from percuss.case.case import fourier_table
from percuss.case.file_format.building import history_load
from percuss.case.file_format.loads import HistoryLoad
from percuss.case.file_format.plain_form import PlainHistoryLoad
from percuss.case.file_format.reading import from_validation, raise_all
from percuss.case.file_format.values import keys_of
from percuss.errors import CaseError, HistoryError
from percuss.recordings.separate_process import Found
from percuss.recordings.untrusted_files import MOST_UPLOADED, vetted

PACKED = (".mat", ".h5", ".hdf5", ".tdms")  # suffixes of what can be packed or point elsewhere

FILE = "load.file"  # the key of a case that names a recording


def read_here(path: Path, options: Mapping[str, Any]) -> dict[str, Any]:
    """What `percuss.case.uploads.upload.uploaded_history` answers, read from a file that we have named."""
    folder = str(path.parent)
    table = history_table(path.name, dict(options))
    try:
        if path.suffix in PACKED:
            vetted(path, MOST_UPLOADED)
        load, notes, *_ = history_load(table, "upload", path.parent)
    except HistoryError as error:
        raise CaseError("upload", FILE, None, error.message, error.remedy) from None
    except CaseError as error:
        raise _without(error, folder) from None
    kind = fourier_table(load)
    if isinstance(table, PlainHistoryLoad):
        kind = {key: kind[key] for key in ("kind", "coefficients")}
    return {
        "load": kind,
        "report": None if load.report is None else plain(asdict(load.report)),
        "notes": [_clean(note, folder) for note in notes],
    }


def found_here(path: Path, options: Mapping[str, Any]) -> Found:
    """`read_here` as the reader of a process of its own."""
    return read_here(path, options), {}


def history_table(file: str, options: dict[str, Any]) -> HistoryLoad:
    """The checked table [load] of a case with this recording."""
    form = PlainHistoryLoad if "force_scale" in options else HistoryLoad
    given = {"kind": "history", "file": file, **options}
    try:
        return form.model_validate(given)
    except ValidationError as error:
        fields = {"load": keys_of(form)}
        raise_all(from_validation(error, "upload", {"load": given}, fields))


def _without(error: CaseError, folder: str) -> CaseError:
    """A copy of the error whose texts do not tell where our file lies."""
    value = None if error.key == FILE else error.value
    return CaseError("upload", error.key, value, _clean(error.accepted, folder), _clean(error.remedy, folder))


def _clean(text: str, folder: str) -> str:
    return re.sub(re.escape(folder) + r"/?", "", text)
