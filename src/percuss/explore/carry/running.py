"""Carry a job out: here or by many workers, kept on disk or not, and always with the same numbers."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from percuss.errors import Interrupted, ParameterError, PercussError
from percuss.explore.carry.archive import Archive, check_free
from percuss.explore.carry.pace import estimate
from percuss.explore.carry.pool import Pool, cores
from percuss.explore.carry.progress import JobProgress, Meter
from percuss.explore.carry.sheet import bytes_of
from percuss.explore.carry.task import Task
from percuss.explore.job import Columns, Job

__all__ = ["JobProgress", "carry_out", "estimate"]


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
        Processes of this machine: as many as cores by default; 1 computes in this process, and so does any number
        when there is little to do.
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
        When the results do not fit into memory, the job cannot travel to other processes, or workers die of it.

    Examples
    --------
    >>> import numpy as np
    >>> from percuss.explore.job import Column
    >>> class Squares:
    ...     size, columns, ask = 5, {"square": Column()}, {"kind": "squares", "size": 5}
    ...     def compute(self, first, last, stopped):
    ...         return {"square": np.arange(first, last) ** 2.0}
    >>> carry_out(Squares())["square"]
    array([ 0.,  1.,  4.,  9., 16.])
    """
    number = _checked(job, workers, chunk)
    kept = None
    if archive is not None:
        if resume and Path(archive).exists():
            kept = Archive.resume(archive, job)
        else:
            check_free(archive)
    task = Task(job, kept, Meter(job.size, bytes_of(job), progress))
    try:
        with _stopping(task, pool, archive is not None):
            return task.columns(archive, number, pool, chunk)
    finally:
        if task.kept is not None:
            task.kept.close()


def _checked(job: Job, workers: int | None, chunk: int | None) -> int:
    for name, value in (("workers", workers), ("chunk", chunk)):
        if value is not None and (isinstance(value, bool) or not isinstance(value, int) or value < 1):
            raise ParameterError(name, value, "a whole number, 1 or greater")
    return cores() if workers is None else workers


@contextmanager
def _stopping(task: Task, pool: Pool | None, archived: bool) -> Iterator[None]:
    """Whatever ends the job early: the workers forget it, and the error says what is kept."""
    try:
        yield
    except KeyboardInterrupt:
        if pool is not None:
            pool.cancel()
        path = None if task.kept is None else str(task.kept.path)
        done = task.meter.done if task.kept is None else task.kept.items_done
        lost = "nothing is written yet" if archived else "an archive (-o, archive=) would keep what is done"
        remedy = "go on by --resume (resume=True)" if path else lost
        raise Interrupted(done, task.job.size, path, remedy) from None
    except BaseException as error:
        if pool is not None:
            pool.cancel()
        if task.kept is not None and not isinstance(error, PercussError):
            error.add_note(f"what was done is kept in {task.kept.path}: go on by --resume (resume=True)")
        raise
