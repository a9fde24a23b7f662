"""The files of an archive: a zarr v3 group with an array for each column, and what the attributes say."""

from __future__ import annotations

import contextlib
import errno
import shutil
import sys
from collections.abc import Iterable, Iterator, Mapping
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np

from percuss.errors import ArchiveError
from percuss.explore.jobs.job import Column, Job
from percuss.explore.jobs.provenance import command, versions
from percuss.explore.jobs.request_text import canonical, digest
from percuss.explore.jobs.zarr_store import all_synced, store_of, zarr_package

__all__ = [
    "BEGIN",
    "DONE",
    "FORMAT",
    "MEND",
    "RESUME",
    "about_column",
    "checked",
    "clear",
    "column_from",
    "damaged",
    "group_of",
    "lay_out",
    "session",
    "whole_chunks",
    "written",
]

FORMAT = 2
"""Of the layout; archives of a higher number are refused. Those of 1 have no check sums."""

TITLE = "percuss archive"
DONE = "done"
RESUME = "--resume (resume=True)"
"""How to continue an archive, on the command line and in Python."""

BEGIN = "use a copy of it, or start another archive"
MEND = f"{RESUME} recomputes what is damaged and keeps the rest"
"""What helps when an archive is damaged: in what it says of itself, and in a chunk."""

_CHECK = "check"


def lay_out(part: Path, job: Job, chunk: int, item_seconds: float) -> None:
    """The group with its empty arrays."""
    columns: Mapping[str, Column] = job.columns
    now = session()
    about = {
        "title": TITLE,
        "format": FORMAT,
        "kind": str(job.ask.get("kind", "job")),
        "ask": canonical(job.ask),  # as text: JSON of other readers has no infinity
        "sha256": digest(job.ask),
        "size": job.size,
        "chunk": chunk,
        "item_seconds": item_seconds,
        "created": now["started"],
        "sessions": [now],
        "columns": {name: about_column(column) for name, column in columns.items()},
    }
    zarr = zarr_package()
    group = zarr.open_group(zarr.storage.LocalStore(part), mode="a", zarr_format=3)
    check = zarr.codecs.Crc32cCodec()  # of what lies on the disk: damage is found before anything is unpacked
    for name, column in columns.items():
        group.create_array(
            name,
            shape=(job.size, *column.shape),
            chunks=(chunk, *(max(n, 1) for n in column.shape)),
            dtype=column.dtype,
            fill_value=column.empty,
            compressors=(zarr.codecs.ZstdCodec(level=0), check),
            dimension_names=("item", *(f"{name}_{i}" for i in range(len(column.shape)))),
            attributes={"units": column.unit or "1", "long_name": column.meaning},
        )
    chunks = -(-job.size // chunk)
    group.create_array(
        DONE, shape=(chunks,), chunks=(1,), dtype="uint8", fill_value=0, compressors=check, dimension_names=("chunk",)
    )
    group.update_attributes(checked(about))  # last: without them it is no archive
    all_synced(part)


def checked(about: Mapping[str, Any]) -> dict[str, Any]:
    """The attributes with their check sum."""
    plain = {name: value for name, value in about.items() if name != _CHECK}
    return {**plain, _CHECK: digest(plain)}


def group_of(folder: Path, mode: str) -> Any:
    """The zarr group of an archive, looked at before it is believed."""
    zarr = zarr_package()
    if not folder.exists():
        raise ArchiveError(str(folder), "no such archive")
    try:
        store = store_of(folder, read_only=mode == "r")
        group = zarr.open_group(store, mode=mode, zarr_format=3)
        about = dict(group.attrs)
    except (OSError, ValueError, KeyError, TypeError, RecursionError) as error:
        if isinstance(error, PermissionError):
            raise ArchiveError(str(folder), f"cannot be read: {error.strerror}") from None
        about = {}
    if about.get("title") != TITLE:
        remedy = "give the folder that a command's -o (archive=) created"
        raise ArchiveError(str(folder), "not an archive of percuss", remedy)
    if not isinstance(about.get("format"), int) or about["format"] > FORMAT:
        what = f"written by a newer version (format {about.get('format')}; this one reads {FORMAT})"
        raise ArchiveError(str(folder), what, "install that version: its 'percuss show' tells which")
    if about["format"] != 1 and about != checked(about):
        raise damaged(folder, "its description is not the one that was written", BEGIN)
    return group


def damaged(folder: Path, what: str, remedy: str) -> ArchiveError:
    """An archive of which something was lost or changed after it was written."""
    return ArchiveError(str(folder), f"the archive is damaged: {what}", remedy)


def session() -> dict[str, Any]:
    """When, with what and how this process writes into an archive."""
    now = datetime.now(UTC).isoformat(timespec="seconds")
    return {"started": now, "versions": versions(), "command": command(sys.argv)}


def about_column(column: Column) -> dict[str, Any]:
    """A column as the attributes keep it."""
    return {
        "dtype": np.dtype(column.dtype).name,
        "shape": list(column.shape),
        "unit": column.unit,
        "fill": repr(np.dtype(column.dtype).type(column.empty).item()),  # as text: JSON of other readers has no NaN
        "meaning": column.meaning,
    }


def column_from(about: dict[str, Any]) -> Column:
    """The column that the attributes keep."""
    kind, fill = np.dtype(about["dtype"]).kind, about["fill"]
    value = fill == "True" if kind == "b" else int(fill) if kind in "iu" else float(fill)
    return Column(about["dtype"], tuple(about["shape"]), about["unit"], value, about["meaning"])


@contextlib.contextmanager
def written(path: Path) -> Iterator[None]:
    """Whatever the system says against writing, as an `ArchiveError`."""
    try:
        yield
    except OSError as error:
        full = error.errno in (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)
        remedy = "choose a place where you may write"
        if full:
            remedy = f"free some space: finished work is kept, continue with {RESUME}"
        raise ArchiveError(str(path), f"cannot be written: {error.strerror or error}", remedy) from error


@contextlib.contextmanager
def whole_chunks() -> Iterator[None]:
    """Arrays opened here write chunks also when all of one is the fill value: NaNs keep their bits."""
    with zarr_package().config.set({"array.write_empty_chunks": True}):
        yield


def clear(left: Iterable[Path]) -> None:
    """Remove what killed processes left half made."""
    for path in list(left):
        if path.is_dir():
            shutil.rmtree(path, ignore_errors=True)
        else:
            with contextlib.suppress(OSError):
                path.unlink()
