"""How long an item takes: measured on a few items spread over the job; their results are kept."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass, field

from percuss.explore.jobs.job import Columns, Job
from percuss.explore.jobs.result_columns import bytes_of
from percuss.model.checks import having

__all__ = ["CHUNK_SECONDS", "Estimate", "Pace", "check_job", "chunk_of", "estimate", "measured"]

CHUNK_SECONDS = 2.0
"""Work in one chunk: writing it takes some hundredths of a second."""

_MANY_CHUNKS = 4000
_LONG_CHUNK = 60.0
"""Each chunk is a file for every column: when there are more, chunks grow, to a minute of work at most."""

_WRITERS = 16
"""Workers whose chunks of a second one process writes without falling behind; for more the chunks grow."""

_ENOUGH = 0.4
"""Seconds of measuring."""

_CLEAR = 0.01
"""Seconds of a portion in which the calls themselves do not count any more."""

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
    """Items of about two seconds of work, fewer (to a half) when every worker would get less than four chunks.

    Examples
    --------
    >>> chunk_of(10**6, 1e-3, workers=2), chunk_of(10**4, 1e-3, workers=4), chunk_of(40, 10.0, workers=2)
    (2000, 1000, 1)
    """
    whole = max(item_seconds, 1e-12) ** -1 * CHUNK_SECONDS * max(1.0, workers / _WRITERS)
    wanted = min(max(size / (4 * workers), 0.5 * whole), whole)
    fewer = min(math.ceil(size / _MANY_CHUNKS), int(whole * _LONG_CHUNK / CHUNK_SECONDS))
    return max(1, min(size, round(wanted)), fewer)


def check_job(job: Job) -> None:
    """Refuse what is no job."""
    having("job", job, ("size", "columns", "ask", "compute"), "a job, such as percuss.case.sweep_job_of makes")


def estimate(job: Job) -> Estimate:
    """What a job would take, from a fraction of a second of it.

    Parameters
    ----------
    job
        Of any size: nothing of its size is made.
    """
    check_job(job)
    pace = measured(job, lambda: False) if job.size else Pace(0.0)
    return Estimate(job.size * pace.item_seconds, bytes_of(job))
