"""Run a job: here or with many workers, kept on disk or not, and always with the same numbers."""

from __future__ import annotations

import math
import os
import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from operator import itemgetter
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from percuss.errors import ArchiveError, Interrupted, PercussError
from percuss.explore.jobs.archive import Archive, Record, check_free
from percuss.explore.jobs.archive_layout import chunk_bounds
from percuss.explore.jobs.job import Column, Columns, Job, Runs
from percuss.explore.jobs.pool import SMALL, Chunk, Pool, Processes, helpers, undisturbed
from percuss.explore.jobs.progress import JobProgress, Meter
from percuss.model.checks import callback, count, flag, having, path
from percuss.short_repr import watched

# ---- All columns of a job in memory, and which items are there


def bytes_of(job: Items, rows: int | None = None) -> int:
    """What the columns of a job take, or of so many of its items."""
    item = sum(np.dtype(column.dtype).itemsize * math.prod(column.shape) for column in job.columns.values())
    return (job.size if rows is None else rows) * item


class Items(Protocol):
    """A job, or an archive."""

    @property
    def size(self) -> int: ...
    @property
    def columns(self) -> Mapping[str, Column]: ...


class Sheet:
    """The columns of a job, or of its first `rows` items, filled in any order; the fill value where nothing is."""

    def __init__(self, job: Items, rows: int | None = None) -> None:
        self._rows = job.size if rows is None else min(rows, job.size)
        needed, there = bytes_of(job, self._rows), _memory()
        if needed > there:
            told = f"{self._rows} items take {needed / 1e9:.3g} GB and this machine has {there / 1e9:.3g} GB of memory"
            raise PercussError(told, "ask for fewer, for instance in several parts, or for fewer quantities of each")
        self.columns: Columns = {
            name: np.full((self._rows, *column.shape), column.empty, dtype=column.dtype)
            for name, column in job.columns.items()
        }

    def put(self, first: int, columns: Columns) -> None:
        """Write the items from `first` on."""
        if first < self._rows:
            for name, values in columns.items():
                place = self.columns[name][first : first + len(values)]
                place[...] = values[: len(place)]


class Sink(Protocol):
    """Where the items of a job go: each once, in any order; `columns` are what `carry_out` gives."""

    columns: Columns

    def put(self, first: int, columns: Columns) -> None:
        """The items from `first` on."""


def checked(job: Job, first: int, last: int, columns: Columns) -> Columns:
    """What a job computed of some items, of the types that it announced."""
    announced = job.columns
    if columns.keys() != announced.keys():
        raise ValueError(f"the job computed {sorted(columns)} and announced {sorted(announced)}")
    for name, values in columns.items():
        shape = (last - first, *announced[name].shape)
        if np.shape(values) != shape:
            raise ValueError(f"column {name}: the job computed shape {np.shape(values)}, not {shape}")
    return {name: np.asarray(values, announced[name].dtype) for name, values in columns.items()}


def joined(records: Iterable[Record]) -> Columns:
    """The columns of records that follow each other."""
    parts = [columns for _, _, columns in sorted(records, key=itemgetter(0))]
    return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}


def _memory() -> float:
    try:
        return float(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES"))
    except (AttributeError, ValueError, OSError):  # not on every system
        return math.inf


# ---- How long an item takes: measured on a few items spread over the job; their results are kept

CHUNK_SECONDS = 2.0  # work in one chunk: writing it takes some hundredths of a second
_MANY_CHUNKS = 4000
_LONG_CHUNK = 60.0
"""Each chunk is a file for every column: when there are more, chunks grow, to a minute of work at most."""

_WRITERS = 16  # workers whose chunks of a second one process writes without falling behind; for more the chunks grow

_ENOUGH = 0.4  # seconds of measuring

_CLEAR = 0.01  # seconds of a portion in which the calls themselves do not count any more

_GROWTH = 8

_GOLDEN = 0.5 * (math.sqrt(5.0) - 1.0)


@dataclass(frozen=True)
class Estimate:
    """What a job would take: seconds of one worker, and bytes of results before they are compressed."""

    seconds: float
    bytes: int


@dataclass(frozen=True)
class Pace:
    """Seconds per item, and the portions by which they were measured: first, last, columns."""

    item_seconds: float
    portions: tuple[tuple[int, int, Columns], ...] = field(default=(), repr=False)


def measured(job: Job, stopped: Callable[[], bool]) -> Pace:
    """Compute portions in many places: they grow until one can be timed, and go on until the mean can be trusted."""
    portions: list[tuple[int, int, Columns]] = []
    items, spent, timed, counted = 1, 0.0, 0.0, 0
    while not stopped():
        # the places jump about: a corner of a map can be much quicker than the rest
        place = (_GOLDEN * (1 + len(portions))) % 1.0
        first = int(place * (job.size - items + 1))
        begin = time.perf_counter()
        portions.append((first, first + items, job.compute(first, first + items, stopped)))
        took = time.perf_counter() - begin
        if len(portions) == 1 and job.size > 1:  # the first loads, or even compiles, what the others find ready
            continue
        spent, timed, counted = spent + took, timed + took, counted + items
        if spent >= _ENOUGH or counted > job.size // 4:
            break
        if took < _CLEAR and items * _GROWTH <= job.size:
            items, timed, counted = items * _GROWTH, 0.0, 0
    return Pace(timed / max(counted, 1), tuple(portions))


def chunk_of(size: int, item_seconds: float, workers: int) -> int:
    """Items of about two seconds of work, fewer (to a half) when every worker would get less than four chunks."""
    whole = max(item_seconds, 1e-12) ** -1 * CHUNK_SECONDS * max(1.0, workers / _WRITERS)
    wanted = min(max(size / (4 * workers), 0.5 * whole), whole)
    fewer = min(math.ceil(size / _MANY_CHUNKS), int(whole * _LONG_CHUNK / CHUNK_SECONDS))
    return max(1, min(size, round(wanted)), fewer)


def check_job(job: Job) -> None:
    having("job", job, ("size", "columns", "ask", "compute"), "a job, such as percuss.case.sweep_job_of makes")


def estimate(job: Job) -> Estimate:
    """What a job would take, from a fraction of a second of it."""
    check_job(job)
    pace = measured(job, lambda: False) if job.size else Pace(0.0)
    return Estimate(job.size * pace.item_seconds, bytes_of(job))


# ---- One job under way: what of it is there, where it is kept, and who computes the rest

_PORTION = 0.25  # seconds of work here between two looks at what is asked

_WAIT = 0.1  # seconds between two looks while others work

_UNIT = 0.5  # seconds of work that are asked of a worker at once: what it has not sent is lost when the job is ended

_AHEAD = 4  # units on their way to a worker and back, behind which a network may hide that it is slow

_EVERY = 1.0  # seconds between two times when what is done of chunks that are not complete is kept …

_SHARE = 0.03  # … more when keeping it would take more than this share of the time

_MOST_UNDERWAY = 1 << 25  # bytes that are kept for chunks that are complete by now, before they are cleared away

_MANY = 16  # workers whose units of half a second one process receives without falling behind; for more they grow

_HELPED = 8  # of so many workers the asking process is one; of more it only writes down what they send

_END = object()


class Task:
    """One call: the job, what is known of it, where it is kept, and who watches."""

    def __init__(self, job: Job, kept: Archive | None, meter: Meter) -> None:
        self.job = job
        self.kept = kept
        self.meter = meter
        self.item_seconds = kept.item_seconds if kept is not None else 0.0
        self.chunk = kept.chunk if kept is not None else 0
        self.chunk_asked = False
        self.there = Runs()
        self._open: dict[int, list[Record]] = {}  # what is there of chunks of the archive that are not complete
        self._pending: list[Record] = []  # of these what is kept nowhere yet
        self._keep_next = -math.inf
        self._most_underway = _MOST_UNDERWAY

    def columns(
        self,
        archive: str | os.PathLike[str] | None,
        workers: int,
        pool: Pool | None,
        chunk: int | None,
        into: Sink | None,
    ) -> Columns:
        """Compute what is missing of the job, and give all its columns, or what `into` has of them."""
        asked = chunk if not self.chunk else self.chunk
        self.chunk_asked = chunk is not None
        at_once = max(1, pool.workers) if pool is not None else workers
        unknown = not self.item_seconds and pool is None and workers > 1
        pace = Pace(0.0)
        if self.job.size and (asked is None or (unknown and (self.kept is None or bool(self.kept.missing())))):
            pace = measured(self.job, self.meter)
            self._heed()
        self.item_seconds = pace.item_seconds or self.item_seconds
        self.chunk = asked or chunk_of(self.job.size, self.item_seconds, at_once)
        done = self.kept.items_done if self.kept is not None else 0
        self.meter.start(done, at_once / self.item_seconds if self.item_seconds else math.nan)
        self.meter.tell()  # which may refuse before anything is written
        self._heed()
        self.sink: Sink = Sheet(self.job) if into is None else into  # after the watcher was told of size and time
        if archive is not None and self.kept is None:
            self.kept = Archive.create(archive, self.job, self.chunk, self.item_seconds)
        self._recall(pace)
        if pool is not None:
            self._elsewhere(pool)
        elif workers == 1:
            self._here()
        elif not self._here(until=SMALL):
            helping = workers <= _HELPED  # which spares the start of a process
            with Processes(max(1, min(workers, len(self._units(workers))) - helping)) as processes:
                self._elsewhere(processes, helping)
        self.meter.tell()
        return self.sink.columns

    @property
    def known(self) -> Columns | None:
        """The columns so far; None before the first ones."""
        return self.sink.columns if hasattr(self, "sink") else None

    def _heed(self) -> None:
        if self.meter.stopped:
            raise KeyboardInterrupt

    def _recall(self, pace: Pace) -> None:
        """What an earlier session did, and what was computed to know the pace."""
        for first, last, columns in self.kept.parts() if self.kept is not None else ():
            self._take(first, last, columns)
        new = sum(self._take(*portion) for portion in pace.portions)
        self.meter.start(self.meter.done + new, self.meter.expected)
        for number in sorted(self._open):
            self._keep(number)
        if self.kept is not None:
            self.kept.keep(self._open_records(), anew=True)
            self._pending = []

    def _put(self, first: int, last: int, columns: Columns) -> None:
        """What was computed of one chunk: known from now on, and kept within a second or so."""
        self.meter.add(self._take(first, last, columns))
        self._keep(first // self.chunk)
        if time.monotonic() >= self._keep_next:
            self.keep_all()

    def _take(self, first: int, last: int, columns: Columns) -> int:
        """Hand over what was not there before, and keep it in mind until its chunk is complete; returns how many."""
        columns, new = checked(self.job, first, last, columns), 0
        for number in range(first // self.chunk, (last - 1) // self.chunk + 1):
            begin, end = self._bounds(number)
            for a, b in self.there.gaps(max(first, begin), min(last, end)):
                part = {name: values[a - first : b - first] for name, values in columns.items()}
                self.sink.put(a, part)
                self.there.add(a, b)
                new += b - a
                if self.kept is not None and not self.kept.done[number]:
                    self._open.setdefault(number, []).append((a, b, part))
                    self._pending.append((a, b, part))
        return new

    def _keep(self, number: int) -> None:
        """Write a chunk when all of it is there."""
        if self.kept is not None and not self.kept.done[number] and not self.there.gaps(*self._bounds(number)):
            self.kept.write(number, joined(self._open.pop(number)))
            self._pending = [record for record in self._pending if record[0] // self.chunk != number]

    def keep_all(self) -> None:
        """Keep what is done of chunks that are not complete."""
        begin = time.monotonic()
        pending, self._pending = self._pending, []
        if self.kept is None or not pending:
            return
        if self.kept.bytes_underway > self._most_underway:
            self.kept.keep(self._open_records(), anew=True)
            self._most_underway = 2 * self.kept.bytes_underway + _MOST_UNDERWAY
        else:
            self.kept.keep(pending)
        self._keep_next = begin + max(_EVERY, (time.monotonic() - begin) / _SHARE)

    def _open_records(self) -> list[Record]:
        """The items that are there, of chunks that are not complete."""
        return [record for records in self._open.values() for record in records]

    def _bounds(self, number: int) -> tuple[int, int]:
        return chunk_bounds(number, self.chunk, self.job.size)

    # -- the two ways --

    def _here(self, until: float = math.inf) -> bool:
        """Compute in this process; False when it turns out that more than so many seconds of work are left."""
        if self._seconds_left() > until:
            return False
        # twice as long is the same thing, found out later
        return all(self._seconds_left() <= 2.0 * until for _ in self._portions(deque(self._units(1))))

    def _portions(self, waiting: deque[Chunk]) -> Iterator[None]:
        """Compute in this process what waits, first come, first taken; yields a few times a second."""
        items = max(1, _portion(self.item_seconds) // 64) if self.item_seconds else 1  # the rest may be slower
        for first, last in self._taken(waiting):
            while first < last:
                upto = min(first + items, last)
                begin = time.perf_counter()
                columns = self.job.compute(first, upto, self.meter)
                took = time.perf_counter() - begin
                self._heed()
                self._put(first, upto, columns)
                self.meter()
                if upto - first == items or took > _PORTION:
                    self.item_seconds = took / (upto - first)
                    items = min(_portion(self.item_seconds), 8 * items)
                first = upto
                yield

    def _seconds_left(self) -> float:
        return (self.job.size - self.meter.done) * self.item_seconds

    def _units(self, workers: int) -> list[Chunk]:
        """What is not there, in parts of chunks of half a second of work each; in chunks where their size was asked."""
        suited = self.chunk
        if self.item_seconds and not self.chunk_asked:
            suited = max(1, int(_UNIT * max(1.0, workers / _MANY) / self.item_seconds))
        step = min(self.chunk, suited)
        found: list[Chunk] = []
        for first, last in self.there.gaps(0, self.job.size):
            while first < last:
                upto = min(first + step, last, self._bounds(first // self.chunk)[1])
                found.append(Chunk(len(found), first, upto))
                first = upto
        return found

    def _elsewhere(self, pool: Pool, helping: bool = False) -> None:
        """Have the workers compute, and write down what they send; in the meantime help them."""
        waiting = deque(self._units(pool.workers + helping))
        if not waiting:
            return
        pool.begin(self.job)
        mine = self._portions(waiting) if helping else iter(())
        out = 0
        while waiting or out or helping:
            there = pool.workers  # none, perhaps, for a while
            ahead = min(_AHEAD, max(1, len(waiting) // max(1, there)))  # at the end, whoever is free takes the next
            while waiting and out < ahead * there:
                pool.submit(waiting.popleft())
                out += 1
            helping = helping and next(mine, _END) is not _END
            for chunk, columns in pool.finished(0.0 if helping else _WAIT):
                out -= 1
                self._put(chunk.first, chunk.last, columns)
            self.meter()
            self._heed()

    def _taken(self, waiting: deque[Chunk]) -> Iterator[tuple[int, int]]:
        """What this process takes from the row."""
        while waiting:
            chunk = waiting.popleft()
            yield from self.there.gaps(chunk.first, chunk.last)


def _portion(item_seconds: float) -> int:
    return max(1, int(min(_PORTION / max(item_seconds, 1e-12), 1e9)))


# ---- Run a job: here or with many workers, kept on disk or not, and always with the same numbers

_MOST_WORKERS, _MOST_ITEMS = 4096, 10**15


def carry_out(
    job: Job,
    *,
    archive: str | os.PathLike[str] | None = None,
    resume: bool = False,
    workers: int | None = None,
    pool: Pool | None = None,
    chunk: int | None = None,
    progress: Callable[[JobProgress], object] | None = None,
) -> Columns:
    """Compute all items of a job.

    The numbers are the same, bit for bit, whatever computes them, in whatever portions and however often it was
    interrupted.

    Parameters
    ----------
    archive
        A folder that keeps what is done, chunk by chunk; see `percuss.explore.Archive`. None is kept by default.
    resume
        Go on with an archive that exists; one that does not is begun.
    workers
        Processes of this machine, of which this one is the first: as many as cores by default, for a job that is
        small by its own reckoning this one alone; any number when there turns out to be little to do. A script needs
        no main guard. A job that holds functions or classes of the script's main part gets processes only where they
        can import it: from a call under ``if __name__ == "__main__":``.
    pool
        Other workers, as `percuss.cluster.pool` gives them; they stay open.
    chunk
        Items that are computed and kept at once; one or two seconds of work by default, as measured on a few items. An
        archive keeps the number that it was begun with.
    progress
        Called a few times a second with a `JobProgress`; something true ends the job. Nothing is written before the
        first one that tells a rate.

    Raises
    ------
    Interrupted
        After Ctrl-C, or when `progress` asked for the end; the archive has what was done.
    ArchiveError
        When the archive exists and is not to be resumed, is of something else, is being written by another process,
        or cannot be written.
    PercussError
        When the results do not fit into memory, the job cannot travel to the other processes asked for, or workers
        die of it.

    Examples
    --------
    >>> import numpy as np
    >>> from percuss.explore.jobs.job import Column
    >>> class Squares:
    ...     size, columns, ask = 5, {"square": Column()}, {"kind": "squares", "size": 5}
    ...     def compute(self, first, last, stopped):
    ...         return {"square": np.arange(first, last) ** 2.0}
    >>> carry_out(Squares())["square"]
    array([ 0.,  1.,  4.,  9., 16.])
    """
    asked: dict[str, Any] = {"archive": archive, "resume": resume, "workers": workers, "pool": pool, "chunk": chunk}
    return carried_into(None, job, progress=progress, **asked)


def carried_into(
    into: Sink | None,
    job: Job,
    *,
    archive: str | os.PathLike[str] | None = None,
    resume: bool = False,
    workers: int | None = None,
    pool: Pool | None = None,
    chunk: int | None = None,
    progress: Callable[[JobProgress], object] | None = None,
) -> Columns:
    """`carry_out`; all items go `into` something instead of memory, where nothing grows with their number."""
    check_job(job)
    for name, number, most in (("chunk", chunk, _MOST_ITEMS), ("workers", workers, _MOST_WORKERS)):
        if number is not None:
            count(name, number, most=most)
    callback("progress", progress)
    if archive is not None:
        path("archive", archive)
    flag("resume", resume)
    if pool is not None:
        having("pool", pool, ("workers", "begin", "submit", "finished"), "workers, as percuss.cluster.pool gives them")
    at_once = 1 if pool is not None else helpers(job, workers)
    kept: Archive | None = None
    if archive is not None and resume and Path(archive).exists():
        kept = Archive.resume(archive, job)
    elif archive is not None:
        check_free(archive)
    with watched(progress) as watch:
        held = bytes_of(job) if into is None or archive is not None else sum(v.nbytes for v in into.columns.values())
        meter = Meter(job.size, held, watch)
        meter.damaged = 0 if kept is None else len(kept.damaged)
        task = Task(job, kept, meter)
        try:
            with _stopping(task, pool, archive is not None):
                return task.columns(archive, at_once, pool, chunk, into)
        finally:
            if task.kept is not None:
                task.kept.close()


@contextmanager
def _stopping(task: Task, pool: Pool | None, archived: bool) -> Iterator[None]:
    """Whatever ends the job early: the workers forget it, and the error says what is kept."""
    try:
        yield
    except KeyboardInterrupt:
        if pool is not None:
            pool.cancel()
        with undisturbed():
            task.keep_all()
        place = None if task.kept is None else str(task.kept.path)
        done = task.meter.done if task.kept is None else task.kept.items_done
        lost = "nothing has been written yet" if archived else "an archive (-o, archive=) saves finished work"
        remedy = "continue with --resume (resume=True)" if place else lost
        raise Interrupted(done, task.job.size, place, remedy, task.known) from None
    except BaseException as error:
        if pool is not None:
            pool.cancel()
        with suppress(ArchiveError):  # it may be the disk that is full
            task.keep_all()
        if task.kept is not None and not isinstance(error, PercussError):
            error.add_note(f"finished work is kept in {task.kept.path}: continue with --resume (resume=True)")
        raise
