"""The files of an archive: a zarr v3 group with an array for each column, and what the attributes say."""

from __future__ import annotations

import asyncio
import contextlib
import errno
import hashlib
import json
import os
import platform
import shlex
import shutil
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from datetime import UTC, datetime
from functools import lru_cache
from importlib import metadata
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from percuss._version import __version__
from percuss.atomic_write import replaced, synced
from percuss.errors import ArchiveError, extra_package
from percuss.explore.jobs.job import Column, Job

# ---- zarr's folder, written so that what it says is there is on the disk: also after a power cut


def zarr_package() -> Any:
    """zarr, imported when an archive is first used."""
    extra_package("zarr", "io")
    import zarr
    import zarr.codecs
    import zarr.storage

    return zarr


def links_in(folder: Path) -> None:
    """Refuse a folder in which something is a link: an archive has none, and would write through them."""
    for here, folders, _ in os.walk(folder):
        for name in folders:
            if os.path.islink(os.path.join(here, name)):
                remedy = "an archive is one folder; put what the link names in its place"
                raise ArchiveError(str(folder), f"{os.path.join(here, name)} is a link", remedy)


@lru_cache(maxsize=1)
def _durable_store() -> Any:
    """A folder as zarr's store; every file in it is whole, and on the disk, before the next one is begun."""
    package = zarr_package()

    class DurableStore(package.storage.LocalStore):  # type: ignore[misc, name-defined]  # zarr is imported late
        """zarr's folder store, made durable: files of zarr's own may be empty after a power cut."""

        async def set(self, key: str, value: Any) -> None:
            if not self._is_open:
                await self._open()
            await asyncio.to_thread(self.set_sync, key, value)

        async def set_if_not_exists(self, key: str, value: Any) -> None:
            if not (self.root / key).exists():
                await self.set(key, value)

        def set_sync(self, key: str, value: Any) -> None:
            self._check_writable()
            path = self.root / key
            _made(path.parent)
            with replaced(path, follow=False) as part, open(part, "wb") as file:
                file.write(value.to_bytes())

    return DurableStore


def _made(folder: Path) -> None:
    """A folder, and its name on the disk."""
    if not folder.is_dir():
        _made(folder.parent)
        folder.mkdir(exist_ok=True)
        synced(folder.parent)


# ---- With what, and by which command, numbers were made

_LIBRARIES = ("numpy", "numba")


def versions() -> dict[str, str]:
    """Of this package, Python, and the libraries on which the last bits of a number may depend."""
    found = {"percuss": __version__, "python": platform.python_version()}
    for name in _LIBRARIES:
        try:
            found[name] = metadata.version(name)
        except metadata.PackageNotFoundError:
            found[name] = "none"
    return found


def command(arguments: Sequence[str]) -> str:
    """How a process was started, from its `sys.argv`; empty when nobody typed it."""
    if not arguments or not arguments[0] or arguments[0] in ("-c", "-"):
        return ""
    program, *rest = arguments
    name = os.path.basename(program)
    if name == "ipykernel_launcher.py":  # a notebook: its temporary connection file tells nobody anything
        return ""
    if name == "__main__.py":
        name = os.path.basename(os.path.dirname(program))
    elif name.endswith(".py"):
        name = f"python {shlex.quote(program)}"
    return " ".join([name.removesuffix(".exe"), *map(_typed, rest)])


def _typed(word: str) -> str:
    """A word as it is typed at a shell; bytes of a file name that are no text as they are."""
    if word.isprintable() or not any("\udc80" <= letter <= "\udcff" for letter in word):
        return shlex.quote(word)
    escaped = (f"\\x{byte:02x}" if byte >= 0x80 or chr(byte) in "\\'" else chr(byte) for byte in os.fsencode(word))
    return f"$'{''.join(escaped)}'"


# ---- What was asked for, as text: the same ask is the same text, and two that differ can be told apart part by part

_DEEPEST = 60  # tables in tables; what asks go through calls itself for each

_SHOWN = 6  # differences that a message lists


def canonical(ask: dict[str, Any]) -> str:
    """The ask as JSON, its keys in order; numbers keep all their digits, infinity included."""
    return json.dumps(ask, sort_keys=True, separators=(",", ":"), ensure_ascii=False)


def digest(ask: dict[str, Any]) -> str:
    """SHA-256 of the canonical text."""
    return hashlib.sha256(canonical(ask).encode()).hexdigest()


def parsed(text: str) -> dict[str, Any]:
    """The ask of a canonical text; ValueError when it is none: no table, or tables in tables without end."""
    try:
        found = json.loads(text)
        deep = _depth(found)
    except RecursionError:
        deep = _DEEPEST + 1
    if deep > _DEEPEST:
        raise ValueError(f"a question nested more than {_DEEPEST} tables deep")
    if not isinstance(found, dict):
        raise ValueError("a question that is not a table")
    return found


def _depth(value: Any) -> int:
    inner = value.values() if isinstance(value, dict) else value if isinstance(value, list) else None
    return 0 if inner is None else 1 + max(map(_depth, inner), default=0)


def differences(old: dict[str, Any], new: dict[str, Any]) -> str:
    """Which parts of two asks differ, in words; empty when none does."""
    # through JSON, so that a tuple and a list of the same numbers do not differ
    one, other = json.loads(canonical(old)), json.loads(canonical(new))
    found = list(_parts("kind", one.get("kind"), other.get("kind"))) or list(_parts("", one, other))
    more = f"; and {len(found) - _SHOWN} more" if len(found) > _SHOWN else ""
    return "; ".join(found[:_SHOWN]) + more


def _parts(name: str, old: Any, new: Any) -> Iterator[str]:
    if isinstance(old, dict) and isinstance(new, dict):
        for key in sorted(old.keys() | new.keys()):
            inner = f"{name}.{key}" if name else key
            if key not in new:
                yield f"{inner}: {_short(old[key])} in the archive, not asked for"
            elif key not in old:
                yield f"{inner}: not in the archive, {_short(new[key])} asked for"
            else:
                yield from _parts(inner, old[key], new[key])
    elif isinstance(old, list) and isinstance(new, list) and len(old) == len(new):
        for i, (one, other) in enumerate(zip(old, new, strict=True)):
            yield from _parts(f"{name}[{_name_of(one, other, i)}]", one, other)
    elif json.dumps(old) != json.dumps(new):  # as text: 1 and true, 0.0 and −0.0 differ, NaN and NaN do not
        yield f"{name}: {_short(old)} in the archive, {_short(new)} asked for"


def _name_of(old: Any, new: Any, position: int) -> object:
    """A list of named things is told by their names where they agree."""
    names = [item.get("name") if isinstance(item, dict) else None for item in (old, new)]
    return names[0] if names[0] is not None and names[0] == names[1] else position


def _short(value: Any, limit: int = 60) -> str:
    if isinstance(value, list) and len(value) > 4:
        return f"{len(value)} values from {_short(value[0], 20)} to {_short(value[-1], 20)}"
    text = json.dumps(value, ensure_ascii=False)
    return text if len(text) <= limit else text[: limit - 1] + "…"


# ---- The files of an archive: a zarr v3 group with an array for each column, and what the attributes say

FORMAT = 2  # of the layout; archives of a higher number are refused. Those of 1 have no check sums.
TITLE = "percuss archive"
DONE = "done"
RESUME = "--resume (resume=True)"  # how to continue an archive, on the command line and in Python
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
    for here, _, files in os.walk(part):
        for file in files:
            synced(os.path.join(here, file))
        synced(here)


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
        group = zarr.open_group(_durable_store()(folder, read_only=mode == "r"), mode=mode, zarr_format=3)
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


def clear(left: Iterable[Path]) -> None:
    """Remove what killed processes left half made."""
    for path in list(left):
        if path.is_dir():
            shutil.rmtree(path, ignore_errors=True)
        else:
            with contextlib.suppress(OSError):
                path.unlink()


# ---- The arrays of an archive on the disk: a column each, chunk by chunk, and the signs of the chunks that are there


def chunk_bounds(number: int, chunk: int, size: int) -> tuple[int, int]:
    """First item of a chunk, and the one after its last."""
    return number * chunk, min((number + 1) * chunk, size)


def arrays_of(group: Any, columns: Mapping[str, Column], size: int, chunk: int) -> dict[str, Any]:
    """An array for each column, and the signs; chunks of fill values too: NaNs keep their bits. Or LookupError."""
    with zarr_package().config.set({"array.write_empty_chunks": True}):
        arrays = {name: group[name] for name in [*columns, DONE]}
    if size < 0 or chunk < 1:
        raise ValueError(f"{size} items in chunks of {chunk}")
    wanted = {name: (c.dtype, (size, *c.shape), chunk) for name, c in columns.items()}
    for name, (dtype, shape, each) in {**wanted, DONE: ("uint8", (-(-size // chunk),), 1)}.items():
        array = arrays[name]
        if (array.dtype, array.shape) != (np.dtype(dtype), shape) or array.chunks[0] != each:
            raise ValueError(f"the column {name} is of another kind")
    return arrays


def readable(array: Any, empty: Any, numbers: list[int], chunk: int) -> tuple[npt.NDArray[Any], list[int]]:
    """What can be read of these chunks of an array, which follow each other, and which of them cannot."""
    if not numbers:
        return np.empty(0, dtype=array.dtype), []
    begin, end = numbers[0] * chunk, min((numbers[-1] + 1) * chunk, array.shape[0])
    try:
        return np.asarray(array[begin:end]), []
    except Exception:  # whatever the codecs make of damage
        found, bad = np.full((end - begin, *array.shape[1:]), empty, dtype=array.dtype), []
    for number in numbers:
        first, last = chunk_bounds(number, chunk, array.shape[0])
        try:
            found[first - begin : last - begin] = array[first:last]
        except Exception:  # as above, of this one
            bad.append(number)
    return found, bad
