"""A job's numbers on disk, chunk by chunk: readable at any moment, and continued where it was broken off.

An archive is a zarr v3 group in a folder: one array for each column, cut into chunks of items; the array `done` holds
1 for every chunk whose data are all there, and is written after them; the attributes hold what was asked for, its
SHA-256, the versions and when it was written. It is written by the asking process alone. A file appears under its
name when it is whole and on the disk, the folder itself under its name when it can be resumed; the items of chunks that
are not complete are kept in a file beside them, every second. Everything has a check sum: what was changed is not
believed, and computed again when the archive is resumed.
"""

from __future__ import annotations

import json
import os
import secrets
import shutil
import socket
import struct
import zlib
from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from glob import escape
from importlib import import_module
from operator import attrgetter
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from percuss.atomic_write import PARTS, replaced, synced
from percuss.errors import ArchiveError
from percuss.explore.jobs.archive_layout import (
    BEGIN,
    DONE,
    MEND,
    RESUME,
    about_column,
    arrays_of,
    checked,
    chunk_bounds,
    clear,
    column_from,
    damaged,
    differences,
    digest,
    group_of,
    lay_out,
    links_in,
    parsed,
    readable,
    session,
    versions,
    written,
    zarr_package,
)
from percuss.explore.jobs.job import Column, Columns, Job, Runs
from percuss.explore.jobs.pool import undisturbed
from percuss.model.checks import path as checked_path

# ---- The items of chunks that are not complete yet, kept beside them, so that a kill loses a second of work and no
# more
#
# A file to which records are added: the first item, the one after the last, and the bytes of all columns of the items
# between, with a check sum. A record that was being written when the process was killed is passed over, and so is all
# behind it.

FILE = ".percuss-underway"  # name of the file inside the folder of the archive
Record = tuple[int, int, Columns]  # first item, the one after the last, and their columns
_HEAD = struct.Struct("<8sQQQI")
_MARK = b"percuss2"
_APPEND = os.O_WRONLY | os.O_CREAT | os.O_APPEND | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_BINARY", 0)


class Underway:
    """The file of one archive; `bytes`: that this process knows to be in it."""

    def __init__(self, folder: Path, columns: Mapping[str, Column], size: int) -> None:
        self.bytes = 0
        self._file = folder / FILE
        self._item = np.dtype([(name, np.dtype(c.dtype).newbyteorder("<"), c.shape) for name, c in columns.items()])
        self._size = size

    def records(self) -> Iterator[Record]:
        """All that are whole, in the order in which they were kept."""
        try:
            if self._file.is_symlink():
                return
            data = memoryview(self._file.read_bytes())
        except OSError:
            return
        at = 0
        while at + _HEAD.size <= len(data):
            mark, first, last, size, check = _HEAD.unpack_from(data, at)
            body = data[at + _HEAD.size : at + _HEAD.size + size]
            fits = mark == _MARK and first < last <= self._size
            fits = fits and size == self._item.itemsize * (last - first) == len(body)
            if not fits or check != _check(first, last, body):
                return
            rows = np.frombuffer(body, self._item, last - first)
            yield first, last, {name: rows[name].astype(rows[name].dtype.newbyteorder("=")) for name in self._names}
            at += _HEAD.size + size

    def keep(self, records: Iterable[Record], anew: bool) -> None:
        """Keep more, or `anew` these and nothing else; OSError when the disk is full or cannot be written."""
        data = b"".join(self._packed(*record) for record in records)
        if not anew:
            handle = os.open(self._file, _APPEND, 0o666)
            try:
                left = memoryview(data)
                while left:
                    left = left[os.write(handle, left) :]
            finally:
                os.close(handle)
        elif data:
            with replaced(self._file, follow=False) as part, open(part, "wb") as file:
                file.write(data)
        else:
            self._file.unlink(missing_ok=True)
        self.bytes = len(data) + (0 if anew else self.bytes)

    @property
    def _names(self) -> tuple[str, ...]:
        return self._item.names or ()

    def _packed(self, first: int, last: int, columns: Columns) -> bytes:
        rows = np.empty(last - first, self._item)
        for name in self._names:
            rows[name] = columns[name]
        body = rows.tobytes()
        return _HEAD.pack(_MARK, first, last, len(body), _check(first, last, body)) + body


def _check(first: int, last: int, body: bytes | memoryview) -> int:
    return zlib.crc32(body, zlib.crc32(struct.pack("<QQ", first, last)))


# ---- One writer at a time: a file that tells who writes, and that the system frees when the writer dies

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None  # type: ignore[assignment]


LOCK = ".percuss-lock"  # name of the file inside the folder that it locks

_NO_LINK = getattr(os, "O_NOFOLLOW", 0)


class Lock:
    """The right to write into a folder, until `release` or the end of the process, however that comes."""

    def __init__(self, folder: Path, name: str | None = None) -> None:
        self._file = folder / LOCK
        self._name = name or str(folder)
        self._handle: int | None = self._taken()

    def release(self) -> None:
        """Let others write; does nothing the second time."""
        if self._handle is None:
            return
        with suppress(OSError):
            self._file.unlink()  # first, so that nobody takes a file that is about to go
        os.close(self._handle)
        self._handle = None

    def moved(self, folder: Path) -> None:
        """The folder was given another name; the lock went with it."""
        self._file = folder / LOCK
        self._name = str(folder)

    def _taken(self) -> int:
        while True:
            handle = os.open(self._file, os.O_RDWR | os.O_CREAT | _NO_LINK, 0o666)
            try:
                if not _free(handle, self._file):
                    raise busy(self._file.parent, self._name)
                if not _same(handle, self._file):  # its holder has just let go and taken the file away
                    os.close(handle)
                    continue
                os.ftruncate(handle, 0)
                os.pwrite(handle, json.dumps({"pid": os.getpid(), "host": socket.gethostname()}).encode(), 0)
            except BaseException:
                with suppress(OSError):
                    os.close(handle)
                raise
            return handle


def busy(folder: Path, name: str | None = None) -> ArchiveError:
    """The refusal of a folder that somebody writes into, with who it is; `name`: what the message calls it."""
    who = _holder(folder / LOCK)
    whose = f"process {who['pid']} on {who['host']}" if who else "another process"
    remedy = f"wait for it, or end it; if it is long dead remove {folder / LOCK}"
    return ArchiveError(name or str(folder), f"{whose} is writing it", remedy)


def is_locked(folder: Path) -> bool:
    """Whether somebody writes into the folder now; a lock that a dead process left does not count."""
    file = folder / LOCK
    try:
        handle = os.open(file, os.O_RDWR | _NO_LINK)
    except OSError:
        return file.exists() and _alive(_holder(file))
    try:
        return not _free(handle, file)
    finally:
        os.close(handle)


def _free(handle: int, file: Path) -> bool:
    """Take the system's lock where there is one; else look whether the process that left the file lives."""
    if fcntl is not None:
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
            return True
        except BlockingIOError:
            return False
        except OSError:  # this file system has no locks
            pass
    return not _alive(_holder(file))


def _same(handle: int, file: Path) -> bool:
    try:
        return os.path.samestat(os.fstat(handle), os.stat(file))
    except FileNotFoundError:
        return False


def _holder(file: Path) -> dict[str, Any]:
    try:
        found = json.loads(file.read_text())
        return {"pid": int(found["pid"]), "host": str(found["host"])}
    except (OSError, ValueError, KeyError, TypeError, RecursionError):
        return {}


def _alive(who: dict[str, Any]) -> bool:
    """Nobody can tell of another host, and Windows has no harmless question: they count as alive."""
    if not who:
        return False
    if who["host"] != socket.gethostname() or os.name == "nt":
        return True
    try:
        os.kill(who["pid"], 0)
    except ProcessLookupError:
        return False
    except OSError:
        return True
    return True


# ---- A job's numbers on disk, chunk by chunk: readable at any moment, and continued where it was broken off

_BATCH = 1 << 16  # items that are read at once

RESULTS = {
    "basins": "percuss.explore.attractors.basin:Basins.from_archive",
    "diagram": "percuss.explore.diagrams.diagram:Diagram.from_archive",
    "experiment": "percuss.explore.attractors.experiments:Experiment.from_archive",
    "shares": "percuss.explore.attractors.shares:Shares.from_archive",
    "sweep": "percuss.explore.sweeps:Sweep.from_archive",
}
"""What makes the result of each kind of job out of an archive: ``module:function``, imported when it is used."""


class Archive:
    """An archive, opened by `create`, `open` or `resume`; a context that lets go of it at the end.

    Attributes
    ----------
    columns
        What is kept of each item.
    size, chunk
        Items, and how many of them are written at once.
    created
        When, in UTC, ISO 8601.
    sessions
        Every time it was written into: ``started``, ``versions``, ``command``.
    done
        Which chunks are complete, bool of shape (chunks,).
    damaged
        The chunks that were found damaged as the archive was resumed: they are computed again.
    """

    def __init__(self, path: Path, group: Any, lock: Lock | None) -> None:
        self.path = path
        self._lock = lock
        try:
            about = dict(group.attrs)
            self.ask: dict[str, Any] = parsed(about["ask"])
            self.sha256 = str(about["sha256"])
            if self.sha256 != digest(self.ask):
                raise ValueError("the question is not the one that was asked")
            self.size, self.chunk = int(about["size"]), int(about["chunk"])
            self.created = str(about["created"])
            self.sessions: list[dict[str, Any]] = list(about["sessions"])
            self.item_seconds = float(about.get("item_seconds", 0.0))
            self.columns = {name: column_from(dict(what)) for name, what in about["columns"].items()}
            self._arrays = arrays_of(group, self.columns, self.size, self.chunk)
            self._group = group
            self._underway = Underway(path, self.columns, self.size)
        except (LookupError, TypeError, ValueError, AttributeError, OverflowError, RecursionError) as error:
            raise damaged(path, repr(error)[:200], BEGIN) from None
        signs, unread = readable(self._arrays[DONE], 0, list(range(-(-self.size // self.chunk))), 1)
        self.done: npt.NDArray[np.bool_] = signs.astype(bool)
        if unread and lock is None:
            raise damaged(path, f"whether chunk {unread[0]} is there cannot be read", MEND)
        self.damaged: tuple[int, ...] = tuple(unread)

    @classmethod
    def create(cls, path: str | os.PathLike[str], job: Job, chunk: int, item_seconds: float = 0.0) -> Archive:
        """A new archive of a job, empty and locked for this process; ArchiveError when something has its name."""
        check_free(path)
        target = Path(os.path.abspath(path))
        part = target.with_name(f".{target.name}.{secrets.token_hex(4)}.new")
        lock: Lock | None = None
        try:
            with written(target):
                part.mkdir()
                lock = Lock(part, str(target))
                lay_out(part, job, chunk, item_seconds)
                if target.exists():  # a rename would take the place of an empty folder, also of one just made
                    raise _exists(target)
                try:
                    part.rename(target)
                except OSError:
                    if target.exists():  # since then
                        raise _exists(target) from None
                    raise
                synced(target.parent)
            lock.moved(target)
            return cls(target, group_of(target, "r+"), lock)
        except BaseException:
            if lock is not None:
                lock.release()
            shutil.rmtree(part, ignore_errors=True)
            raise

    @classmethod
    def open(cls, path: str | os.PathLike[str]) -> Archive:
        """An archive to look at, whether or not it is complete and somebody writes it.

        Raises
        ------
        ArchiveError
            When it is none, is damaged, or was written by a newer version.
        """
        folder = Path(os.path.abspath(checked_path("path", path)))
        return cls(folder, group_of(folder, "r"), None)

    @classmethod
    def resume(cls, path: str | os.PathLike[str], job: Job) -> Archive:
        """An archive of exactly this job and version of this package, to go on with; locked for this process."""
        folder = Path(os.path.abspath(path))
        group_of(folder, "r")
        links_in(folder)
        with written(folder):
            lock = Lock(folder)
        try:
            archive = cls(folder, group_of(folder, "r+"), lock)
            archive._check_same(job)
            with written(folder):
                clear(folder.rglob(PARTS))  # of files that were being written when somebody was killed
                archive._give_up_damaged()
                archive.sessions.append(session())
                archive._group.update_attributes(checked({**archive._group.attrs, "sessions": archive.sessions}))
            return archive
        except BaseException:
            lock.release()
            raise

    def write(self, number: int, columns: Columns) -> None:
        """All columns of one chunk, then the sign that it is there; what was there stays readable when this fails."""
        first, last = self.bounds(number)
        with written(self.path), undisturbed():
            for name in self.columns:
                self._arrays[name][first:last] = columns[name]
            self._sign(number, True)
            if self.done.all():
                self._underway.keep((), anew=True)

    def keep(self, records: list[Record], anew: bool = False) -> None:
        """Items of chunks that are not complete yet, besides those kept already, or `anew` instead of them."""
        with written(self.path), undisturbed():
            if records or anew:
                self._underway.keep(records, anew)

    @property
    def bytes_underway(self) -> int:
        """What `keep` has written, some of it of chunks that are complete by now."""
        return self._underway.bytes

    def bounds(self, number: int) -> tuple[int, int]:
        """First item of a chunk, and the one after its last."""
        return chunk_bounds(number, self.chunk, self.size)

    def missing(self) -> list[int]:
        """The chunks that are not done, in order."""
        found: list[int] = np.flatnonzero(~self.done).tolist()
        return found

    @property
    def known(self) -> npt.NDArray[np.bool_]:
        """Which items are there, in chunks that are complete and in others; bool of shape (size,)."""
        found: npt.NDArray[np.bool_] = np.repeat(self.done, self.chunk)[: self.size]
        for first, last, _ in self._underway.records():
            found[first:last] = True
        return found

    @property
    def items_done(self) -> int:
        """How many items are there, in chunks that are complete and in others."""
        whole = sum(last - first for first, last in map(self.bounds, np.flatnonzero(self.done).tolist()))
        return whole + sum(last - first for first, last, _ in self._unfinished())

    @property
    def fraction(self) -> float:
        """The share of the items that are done, 0 to 1."""
        return self.items_done / self.size if self.size else 1.0

    @property
    def kind(self) -> str:
        """What sort of job it is: ``sweep``, ``experiment``, …"""
        return str(self.ask.get("kind", "job"))

    @property
    def versions(self) -> dict[str, str]:
        """The versions of this package, Python and the libraries with which the archive was begun."""
        return dict(self.sessions[0]["versions"])

    @property
    def is_written(self) -> bool:
        """Whether a process writes it at this moment."""
        return self._lock is not None or is_locked(self.path)

    def read(self) -> Columns:
        """All columns, shape (size, …); what is not done holds the column's fill value.

        Raises
        ------
        ArchiveError
            When a chunk that was complete is lost or was changed; with which, and what helps.
        """
        found = {name: np.full((self.size, *c.shape), c.empty, c.dtype) for name, c in self.columns.items()}
        for first, last, columns in self.parts():
            for name, values in columns.items():
                found[name][first:last] = values
        return found

    def parts(self) -> Iterator[Record]:
        """What is done, some chunks at a time: first item, the one after the last, and all columns; as of `read`."""
        for numbers in self._batches():
            first, last = self.bounds(numbers[0])[0], self.bounds(numbers[-1])[1]
            columns: Columns = {}
            for name in self.columns:
                columns[name], bad = self._column(name, numbers)
                if bad:
                    first, last = self.bounds(bad[0])
                    raise damaged(self.path, f"chunk {bad[0]} (items {first} to {last - 1}) of the column {name}", MEND)
            yield first, last, columns
        yield from self._unfinished()

    def _unfinished(self) -> Iterator[Record]:
        """What is done of chunks that are not complete, each item once."""
        there = Runs()
        for begin, end, columns in self._underway.records():
            for first, last in there.gaps(begin, end):
                there.add(first, last)
                for number in range(first // self.chunk, (last - 1) // self.chunk + 1):
                    a, b = self.bounds(number)
                    a, b = max(a, first), min(b, last)
                    if not self.done[number]:
                        yield a, b, {name: values[a - begin : b - begin] for name, values in columns.items()}

    def _batches(self) -> Iterator[list[int]]:
        """The numbers of the chunks that are complete: neighbours together, as many as take some MB."""
        most = max(1, _BATCH // self.chunk)
        done = np.flatnonzero(self.done)
        for run in np.split(done, np.flatnonzero(np.diff(done) > 1) + 1):
            for i in range(0, run.size, most):
                yield run[i : i + most].tolist()

    def result(self, **asked: Any) -> Any:
        """What the job was made for, a `Sweep`, an `Experiment`, …; None when this version knows no such kind.

        `asked`: of its ``from_archive``, as `rows` of an `Experiment`.
        """
        if self.kind not in RESULTS:
            return None
        module, _, name = RESULTS[self.kind].partition(":")
        try:
            return attrgetter(name)(import_module(module))(self, **asked)
        except (KeyError, TypeError, ValueError, AttributeError):  # an archive of somebody else's job
            return None

    def close(self) -> None:
        """Let others write."""
        if self._lock is not None:
            self._lock.release()

    def __enter__(self) -> Archive:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    # -- resuming --

    def _give_up_damaged(self) -> None:
        """What is damaged does not count as done any more."""
        found = (self._column(name, numbers)[1] for numbers in self._batches() for name in self.columns)
        bad = {*self.damaged, *(number for numbers in found for number in numbers)}
        for number in sorted(bad):
            self._sign(number, False)
        self.damaged = tuple(sorted(bad))

    def _sign(self, number: int, done: bool) -> None:
        self._arrays[DONE][number : number + 1] = np.full(1, done, dtype=np.uint8)
        self.done[number] = done

    def _column(self, name: str, numbers: list[int]) -> tuple[npt.NDArray[Any], list[int]]:
        """A column of chunks that follow each other, and those of them that are not there as they were written."""
        array, inner = self._arrays[name], ["0"] * len(self.columns[name].shape)
        found, bad = readable(array, self.columns[name].empty, numbers, self.chunk)
        # of a file that is not there zarr gives the fill value
        gone = [n for n in numbers if array.size and not self.path.joinpath(name, "c", str(n), *inner).is_file()]
        return found, sorted({*bad, *gone})

    def _check_same(self, job: Job) -> None:
        begun = self.versions.get("percuss")
        if begun != versions()["percuss"]:
            what = f"percuss {begun} started it and this is {versions()['percuss']}: the numbers could differ"
            raise ArchiveError(str(self.path), what, f"continue with percuss {begun}, or start another archive")
        told = differences(self.ask, job.ask)
        kept, wanted = ({name: about_column(one) for name, one in of.columns.items()} for of in (self, job))
        if not told and (self.size != job.size or kept != wanted):
            told = "what is kept of the items"
        if told or self.sha256 != digest(job.ask):
            remedy = "ask for the same again, or give another name"
            raise ArchiveError(str(self.path), f"the archive answers another question: {told}", remedy)


def check_free(path: str | os.PathLike[str]) -> None:
    """Refuse a name under which no archive can be begun: a taken one, or in a folder that cannot be written."""
    zarr_package()
    target = Path(os.path.abspath(path))
    if target.exists() or target.is_symlink():
        raise _exists(target)
    if not target.parent.is_dir():
        raise ArchiveError(str(target), f"there is no folder {target.parent}", "create it, or give another name")
    if not os.access(target.parent, os.W_OK):
        raise ArchiveError(str(target), f"the folder {target.parent} cannot be written", "give another name")
    # what killed processes were about to lay out; they had computed nothing yet
    clear(half for half in target.parent.glob(f".{escape(target.name)}.????????.new") if not is_locked(half))


def _exists(target: Path) -> ArchiveError:
    if is_locked(target):  # also where two have just begun it, of which one was first
        return busy(target)
    try:
        with Archive.open(target) as archive:
            what = f"the archive exists, {100.0 * archive.fraction:.3g} % done"
        return ArchiveError(str(target), what, f"continue it with {RESUME}, or give another name")
    except ArchiveError:
        return ArchiveError(str(target), "exists and is not an archive", "give another name")
