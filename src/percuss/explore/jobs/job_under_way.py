"""One job under way: what of it is there, where it is kept, and who computes the rest."""

from __future__ import annotations

import math
import os
import time
from collections import deque
from collections.abc import Iterator

import numpy as np

from percuss.explore.jobs.archive import Archive
from percuss.explore.jobs.item_time import Pace, chunk_of, measured
from percuss.explore.jobs.job import Columns, Job
from percuss.explore.jobs.partial_chunks import Record
from percuss.explore.jobs.pool import Chunk, Pool, Processes
from percuss.explore.jobs.process_count import SMALL
from percuss.explore.jobs.progress import Meter
from percuss.explore.jobs.result_columns import Sheet, check_memory, runs

__all__ = ["Task"]

_PORTION = 0.25
"""Seconds of work here between two looks at what is asked."""

_WAIT = 0.1
"""Seconds between two looks while others work."""

_UNIT = 0.5
"""Seconds of work that are asked of a worker at once: what it has not sent is lost when the job is ended."""

_EVERY = 1.0
"""Seconds between two times when what is done of chunks that are not complete is kept …"""

_SHARE = 0.03
"""… more when keeping it would take more than this share of the time."""

_MOST_UNDERWAY = 1 << 25
"""Bytes that are kept for chunks that are complete by now, before they are cleared away."""

_MANY = 16
"""Workers whose units of half a second one process receives without falling behind; for more they grow."""

_HELPED = 8
"""Of so many workers the asking process is one; of more it only writes down what they send."""

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
        self._pending: list[tuple[int, int]] = []  # runs of items that are kept nowhere yet
        self._keep_next = -math.inf
        self._most_underway = _MOST_UNDERWAY

    def columns(
        self, archive: str | os.PathLike[str] | None, workers: int, pool: Pool | None, chunk: int | None
    ) -> Columns:
        """Compute what is missing of the job, and give all its columns."""
        asked = chunk if not self.chunk else self.chunk
        self.chunk_asked = chunk is not None
        at_once = max(1, pool.workers) if pool is not None else workers
        unknown = not self.item_seconds and pool is None and workers > 1
        pace = self._pace(needed=asked is None or (unknown and (self.kept is None or bool(self.kept.missing()))))
        self.item_seconds = pace.item_seconds or self.item_seconds
        self.chunk = asked or chunk_of(self.job.size, self.item_seconds, at_once)
        self._foretell(at_once)
        check_memory(self.job)  # after the watcher was told of size and time
        if archive is not None and self.kept is None:
            self.kept = Archive.create(archive, self.job, self.chunk, self.item_seconds)
        self.sheet = Sheet(self.job)
        self._recall(pace)
        if pool is not None:
            self._elsewhere(pool)
        elif workers == 1:
            self._here()
        elif not self._here(until=SMALL):
            self._shared(workers)
        self.meter.tell()
        return self.sheet.columns

    @property
    def known(self) -> Columns | None:
        """All columns so far; None before the first ones."""
        return self.sheet.columns if hasattr(self, "sheet") else None

    def _pace(self, needed: bool) -> Pace:
        if not self.job.size or not needed:
            return Pace(0.0)
        pace = measured(self.job, self.meter)
        self._heed()
        return pace

    def _foretell(self, workers: int) -> None:
        """Let the watcher refuse before anything is written."""
        done = self.kept.items_done if self.kept is not None else 0
        expected = workers / self.item_seconds if self.item_seconds else math.nan
        self.meter.start(done, expected)
        self.meter.tell()
        self._heed()

    def _heed(self) -> None:
        if self.meter.stopped:
            raise KeyboardInterrupt

    def _recall(self, pace: Pace) -> None:
        """What an earlier session did, and what was computed to know the pace."""
        numbers: set[int] = set()
        if self.kept is not None:
            found, known = self.kept.read(), self.kept.known
            for first, last in runs(known):
                self.sheet.put(first, last, {name: values[first:last] for name, values in found.items()})
            known[np.repeat(self.kept.done, self.chunk)[: known.size]] = False
            numbers = set((np.flatnonzero(known) // self.chunk).tolist())
        new = 0
        for first, last, columns in pace.portions:
            new += self.sheet.put(first, last, columns)
            numbers.update(range(first // self.chunk, (last - 1) // self.chunk + 1))
        self.meter.start(self.meter.done + new, self.meter.expected)
        for number in sorted(numbers):
            self._keep(number)
        if self.kept is not None:
            self.kept.keep(self._open_records(), anew=True)

    def _put(self, first: int, last: int, columns: Columns) -> None:
        """What was computed of one chunk: known from now on, and kept within a second or so."""
        self.meter.add(self.sheet.put(first, last, columns))
        self._pending.append((first, last))
        self._keep(first // self.chunk)
        if time.monotonic() >= self._keep_next:
            self.keep_all()

    def _keep(self, number: int) -> None:
        """Write a chunk when all of it is there."""
        first, last = self._bounds(number)
        if self.kept is not None and not self.kept.done[number] and self.sheet.is_full(first, last):
            self.kept.write(number, self.sheet.part(first, last))

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
            new = [run for run in pending if not self.kept.done[run[0] // self.chunk]]
            self.kept.keep([(first, last, self.sheet.part(first, last)) for first, last in new])
        self._keep_next = begin + max(_EVERY, (time.monotonic() - begin) / _SHARE)

    def _open_records(self) -> list[Record]:
        """The items that are there, of chunks that are not complete."""
        found: list[Record] = []
        for number in self._open():
            first, last = self._bounds(number)
            known = runs(self.sheet.known[first:last])
            found += [(first + a, first + b, self.sheet.part(first + a, first + b)) for a, b in known]
        return found

    def _bounds(self, number: int) -> tuple[int, int]:
        return number * self.chunk, min((number + 1) * self.chunk, self.job.size)

    def _open(self) -> list[int]:
        """The chunks of which something is not there."""
        gaps = self.sheet.gaps(0, self.job.size)
        return sorted({n for first, last in gaps for n in range(first // self.chunk, (last - 1) // self.chunk + 1)})

    # -- the two ways --

    def _here(self, until: float = math.inf) -> bool:
        """Compute in this process; False when it turns out that more than so many seconds of work are left."""
        if self._seconds_left() > until:
            return False
        # twice as long is the same thing, found out later
        return all(self._seconds_left() <= 2.0 * until for _ in self._portions(self._runs()))

    def _portions(self, runs: Iterator[tuple[int, int]]) -> Iterator[None]:
        """Compute runs of items in this process; yields a few times a second."""
        items = max(1, _portion(self.item_seconds) // 64) if self.item_seconds else 1  # the rest may be slower
        for first, last in runs:
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

    def _runs(self) -> Iterator[tuple[int, int]]:
        """What is not there, one chunk after the other where they are kept."""
        if self.kept is None:
            yield from self.sheet.gaps(0, self.job.size)
            return
        for number in self._open():
            yield from self.sheet.gaps(*self._bounds(number))

    def _shared(self, workers: int) -> None:
        """Among processes of this machine, started for this job."""
        helping = workers <= _HELPED  # which spares the start of a process
        with Processes(max(1, min(workers, len(self._units(workers))) - helping)) as processes:
            self._elsewhere(processes, helping)

    def _units(self, workers: int) -> list[Chunk]:
        """What is not there, in parts of chunks of half a second of work each; in chunks where their size was asked."""
        suited = self.chunk
        if self.item_seconds and not self.chunk_asked:
            suited = max(1, int(_UNIT * max(1.0, workers / _MANY) / self.item_seconds))
        step = min(self.chunk, suited)
        found: list[Chunk] = []
        for number in self._open():
            for first, last in self.sheet.gaps(*self._bounds(number)):
                found += [Chunk(len(found) + i, a, min(a + step, last)) for i, a in enumerate(range(first, last, step))]
        return found

    def _elsewhere(self, pool: Pool, helping: bool = False) -> None:
        """Have the workers compute, and write down what they send; in the meantime help them."""
        waiting = deque(self._units(pool.workers + helping))
        if not waiting:
            return
        pool.begin(self.job)
        mine = self._portions(self._taken(waiting)) if helping else iter(())
        out = 0
        while waiting or out or helping:
            ahead = 2 if len(waiting) > 2 * pool.workers else 1  # towards the end, whoever is free takes the next
            while waiting and out < ahead * pool.workers:
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
            yield from self.sheet.gaps(chunk.first, chunk.last)


def _portion(item_seconds: float) -> int:
    return max(1, int(min(_PORTION / max(item_seconds, 1e-12), 1e9)))
