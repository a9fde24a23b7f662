"""A job's numbers on disk, chunk by chunk: readable at any moment, and continued where it was broken off.

An archive is a zarr v3 group in a folder: one array for each column, cut into chunks of items; the array `done` holds
1 for every chunk whose data are all there, and is written after them; the attributes hold what was asked for, its
SHA-256, the versions and when it was written. It is written by the asking process alone. A file appears under its
name when it is whole and on the disk, the folder itself under its name when it can be resumed; the items of chunks that
are not complete are kept in a file beside them, every second. Everything has a check sum: what was changed is not
believed, and computed again when the archive is resumed.
"""

from __future__ import annotations

import os
import secrets
import shutil
from glob import escape
from importlib import import_module
from operator import attrgetter
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from percuss.errors import ArchiveError
from percuss.explore.jobs.archive_layout import (
    BEGIN,
    FORMAT,
    MEND,
    RESUME,
    about_column,
    checked,
    clear,
    column_from,
    damaged,
    group_of,
    lay_out,
    session,
    written,
)
from percuss.explore.jobs.archive_lock import Lock, is_locked
from percuss.explore.jobs.chunk_arrays import ChunkArrays, chunk_bounds
from percuss.explore.jobs.deferred_interrupt import undisturbed
from percuss.explore.jobs.job import Columns, Job
from percuss.explore.jobs.partial_chunks import Record, Underway
from percuss.explore.jobs.provenance import versions
from percuss.explore.jobs.request_text import differences, digest, parsed
from percuss.explore.jobs.zarr_store import links_in, zarr_package
from percuss.model.checks import path as checked_path
from percuss.whole_file import PARTS, synced

__all__ = ["FORMAT", "RESULTS", "Archive", "check_free"]

RESULTS = {
    "basins": "percuss.explore.attractors.basin:Basins.from_archive",
    "diagram": "percuss.explore.diagrams.diagram:Diagram.from_archive",
    "experiment": "percuss.explore.attractors.experiments:Experiment.from_archive",
    "sweep": "percuss.explore.sweeps:Sweep.from_archive",
}
"""What makes the result of each kind of job out of an archive: ``module:function``, imported when it is used."""


class Archive:
    """An archive, opened by `create`, `open` or `resume`; a context that lets go of it at the end.

    Attributes
    ----------
    path
        The folder.
    ask
        What was asked for, as the job told it.
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
            self._arrays = ChunkArrays(path, group, self.columns, self.size, self.chunk)
            self._group = group
            self._underway = Underway(path, self.columns, self.size)
        except (LookupError, TypeError, ValueError, AttributeError, OverflowError, RecursionError) as error:
            raise damaged(path, repr(error)[:200], BEGIN) from None
        self.done, unread = self._arrays.signs()
        if unread and lock is None:
            raise damaged(path, f"whether chunk {unread[0]} is there cannot be read", MEND)
        self.damaged: tuple[int, ...] = tuple(unread)

    @classmethod
    def create(cls, path: str | os.PathLike[str], job: Job, chunk: int, item_seconds: float = 0.0) -> Archive:
        """A new archive of a job, empty and locked for this process.

        Raises
        ------
        ArchiveError
            When there is something of that name, or it cannot be written.
        """
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
                part.rename(target)
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
        """An archive of exactly this job, to go on with; locked for this process.

        Raises
        ------
        ArchiveError
            When it is of another job or another version of this package, or another process writes it.
        """
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
        """All columns of one chunk, and then the sign that it is there.

        Raises
        ------
        ArchiveError
            When the disk is full or cannot be written; what was there stays readable.
        """
        first, last = self.bounds(number)
        with written(self.path), undisturbed():
            self._arrays.write(first, last, columns)
            self._arrays.sign(number, 1)
            self.done[number] = True
            if self.done.all():
                self._underway.remove()

    def keep(self, records: list[Record], anew: bool = False) -> None:
        """Items of chunks that are not complete yet, besides those that are kept already, or `anew` instead of them.

        Raises
        ------
        ArchiveError
            As `write`.
        """
        with written(self.path), undisturbed():
            (self._underway.begin if anew else self._underway.add)(records)

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
        return int(np.count_nonzero(self.known))

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
        empty = np.repeat(~self.done, self.chunk)[: self.size]
        found: Columns = {}
        for name, column in self.columns.items():
            found[name], bad = self._arrays.column(name, self.done)
            if bad:
                first, last = self.bounds(bad[0])
                raise damaged(self.path, f"chunk {bad[0]} (items {first} to {last - 1}) of the column {name}", MEND)
            found[name][empty] = column.empty  # of a chunk under way some columns may be there
        for first, last, columns in self._underway.records():
            here = empty[first:last]
            for name, values in columns.items():
                found[name][first:last][here] = values[here]
        return found

    def result(self) -> Any:
        """What the job was made for, a `Sweep`, an `Experiment`, …; None when this version knows no such kind."""
        if self.kind not in RESULTS:
            return None
        module, _, name = RESULTS[self.kind].partition(":")
        try:
            return attrgetter(name)(import_module(module))(self)
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
        bad = {*self.damaged, *(number for name in self.columns for number in self._arrays.column(name, self.done)[1])}
        for number in sorted(bad):
            self._arrays.sign(number, 0)
            self.done[number] = False
        self.damaged = tuple(sorted(bad))

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
    """Refuse a name under which no archive can be begun.

    Raises
    ------
    ArchiveError
        When there is something of that name, or no folder to put it into, or one that cannot be written.
    """
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
    try:
        with Archive.open(target) as archive:
            what = f"the archive exists, {100.0 * archive.fraction:.3g} % done"
        return ArchiveError(str(target), what, f"continue it with {RESUME}, or give another name")
    except ArchiveError:
        return ArchiveError(str(target), "exists and is not an archive", "give another name")
