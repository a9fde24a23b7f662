"""Run a job: here or with many workers, kept on disk or not, and always with the same numbers."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from percuss.errors import ArchiveError, Interrupted, PercussError
from percuss.explore.jobs.archive import Archive, check_free
from percuss.explore.jobs.deferred_interrupt import undisturbed
from percuss.explore.jobs.item_time import check_job, estimate
from percuss.explore.jobs.job import Columns, Job
from percuss.explore.jobs.job_under_way import Task
from percuss.explore.jobs.pool import Pool
from percuss.explore.jobs.process_count import helpers
from percuss.explore.jobs.progress import JobProgress, Meter
from percuss.explore.jobs.result_columns import bytes_of
from percuss.model.checks import callback, count, flag, having, path
from percuss.notebook import watched

__all__ = ["JobProgress", "carry_out", "estimate"]

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
    job
        What is to be computed.
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

    Returns
    -------
    dict
        All columns, arrays of shape (size, …), with the shape of one item behind the size.

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
    _check(job, workers, chunk)
    callback("progress", progress)
    _check_places(archive, resume, pool)
    number = 1 if pool is not None else helpers(job, workers)
    kept = _resumed(archive, resume, job)
    with watched(progress) as watch:
        meter = Meter(job.size, bytes_of(job), watch)
        meter.damaged = 0 if kept is None else len(kept.damaged)
        task = Task(job, kept, meter)
        try:
            with _stopping(task, pool, archive is not None):
                return task.columns(archive, number, pool, chunk)
        finally:
            if task.kept is not None:
                task.kept.close()


def _check(job: Job, workers: int | None, chunk: int | None) -> None:
    check_job(job)
    if chunk is not None:
        count("chunk", chunk, most=_MOST_ITEMS)
    if workers is not None:
        count("workers", workers, most=_MOST_WORKERS)


def _check_places(archive: object, resume: object, pool: object) -> None:
    """Where it is computed and kept."""
    if archive is not None:
        path("archive", archive)
    flag("resume", resume)
    if pool is not None:
        having("pool", pool, ("workers", "begin", "submit", "finished"), "workers, as percuss.cluster.pool gives them")


def _resumed(archive: str | os.PathLike[str] | None, resume: bool, job: Job) -> Archive | None:
    """The archive to go on with; None where there is none yet, in a place that is free then."""
    if archive is None:
        return None
    if resume and Path(archive).exists():
        return Archive.resume(archive, job)
    check_free(archive)
    return None


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
