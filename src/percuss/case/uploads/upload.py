"""A recording that comes as bytes, read as a case that names it would have it read."""

from __future__ import annotations

import re
import tempfile
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from percuss.case.case import case_of
from percuss.case.file_format.reading import parsed
from percuss.case.parameters.description import case_dict
from percuss.case.uploads.uploaded_file import FILE, PACKED, history_table, read_here
from percuss.errors import CaseError, HistoryError
from percuss.recordings.separate_process import Died, ReaderBounds, read_apart
from percuss.recordings.text_table import LONGEST_LINE
from percuss.recordings.untrusted_files import MOST_UPLOADED, plain_mat

_PLAIN = (".csv", ".tsv", ".txt", ".dat", ".wav")

SUFFIXES = (*_PLAIN, *PACKED)  # what an uploaded recording may be called; the suffix says how it is read
BOUNDS = ReaderBounds(answer=4_000_000)
"""What reading an upload may take; a thousand harmonics are an answer of 50 000 characters."""

_DIED = "it could not be read within the memory and the time allowed for an upload"

_SMALL = 1_000_000  # bytes that are read in a second or two; what takes longer must be possible to give up


def uploaded_history(
    data: bytes, name: str, options: Mapping[str, Any], halt: Callable[[], bool] | None = None
) -> dict[str, Any]:
    """The load in the bytes of a recording: the table [load] that stands for it, what was found, what was assumed."""
    # The bytes lie in a file of our own naming while they are read; of `name` only the suffix counts. What can be
    # packed or point elsewhere is looked into first, and then read by a process of its own, as is all that is large.
    suffix = Path(name).suffix.lower()
    if suffix not in SUFFIXES:
        accepted = f"expected a name that ends in {', '.join(SUFFIXES)}"
        raise CaseError("upload", FILE, name, accepted, "save the recording as CSV")
    if suffix in _PLAIN and suffix != ".wav" and max(map(len, data.splitlines()), default=0) > LONGEST_LINE:
        raise CaseError("upload", FILE, name, f"a line of more than {LONGEST_LINE} bytes", "a line for each sample")
    given = {key: value for key, value in options.items() if value not in (None, "")}
    file = history_table(f"recording{suffix}", given).file
    if suffix == ".mat":
        try:
            data = plain_mat(data, MOST_UPLOADED)
        except HistoryError as error:
            raise CaseError("upload", FILE, None, error.message, error.remedy) from None
    with tempfile.TemporaryDirectory(prefix="percuss-") as folder:
        Path(folder, file).write_bytes(data)
        if suffix in PACKED or len(data) > _SMALL:
            return _read_apart(Path(folder, file), given, halt)
        return read_here(Path(folder, file), given)


def _read_apart(path: Path, options: Mapping[str, Any], halt: Callable[[], bool] | None) -> dict[str, Any]:
    """What `read_here` finds, found by another process."""
    try:
        return read_apart("percuss.case.uploads.uploaded_file:found_here", path, options, BOUNDS, halt)[0]
    except Died:
        raise CaseError("upload", FILE, None, _DIED, "save it as CSV") from None


def uploaded_case(
    text: str, data: bytes, name: str, harmonics: int, halt: Callable[[], bool] | None = None
) -> dict[str, Any]:
    """A case file and the recording it names, as `case_dict` has them; its harmonics stand in the recording's place."""
    tables = parsed(text, "case")
    load = tables.get("load")
    if not isinstance(load, dict) or load.get("kind") != "history":
        kind = load.get("kind") if isinstance(load, dict) else load
        remedy = 'give the case alone, or name the recording in it: kind = "history" and file = "…"'
        raise CaseError("case", "load.kind", kind, "the load of this case is not a recording", remedy)
    options = {key: value for key, value in load.items() if key not in ("kind", "file")}
    found = uploaded_history(data, name, options, halt)
    described = case_dict(case_of({**tables, "load": found["load"]}, "case", harmonics))
    notes = [*described["notes"], *found["notes"]]
    named, called = (re.split(r"[\\\\/]", str(path))[-1] for path in (load.get("file", ""), name))
    if named != called:
        notes.append(f"the case names the recording {named}; {called} was uploaded")
    return {**described, "history": found["report"], "notes": notes}
