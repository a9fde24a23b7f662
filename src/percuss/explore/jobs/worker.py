"""What a worker process does: take the job, then chunk after chunk, until the asking process is gone."""

from __future__ import annotations

import os
import pickle
import signal
import threading
import traceback
from multiprocessing import parent_process
from multiprocessing.connection import Connection
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from percuss.explore.jobs.job import Job

READY, BAD_JOB, DONE, FAILED = "ready", "bad job", "done", "failed"
"""The first word of everything that a worker says."""


def work(connection: Connection[Any, Any]) -> None:
    """Answer the asking process until it is gone or kills us.

    A job comes as bytes, a chunk as (number, first, last); what goes back is (word, …): `READY`, `BAD_JOB` with the
    error, `DONE` with number and columns, or `FAILED` with number and error.
    """
    for which in (signal.SIGINT, signal.SIGTERM):  # Ctrl-C goes to all of a terminal, SIGTERM to all of a batch job;
        signal.signal(which, signal.SIG_IGN)  # the asking process ends us
    threading.Thread(target=_end_with_parent, daemon=True).start()
    job: Job | None = None
    try:
        while True:
            message = connection.recv()
            if isinstance(message, bytes):
                job, answer = _unpacked(message)
            else:
                assert job is not None
                answer = _computed(job, *message)
            connection.send(answer)
    except (EOFError, OSError):
        return  # nobody is there any more


def _end_with_parent() -> None:
    """End this process when its parent dies, even when killed: the parent's end of a pipe closes in any case."""
    parent = parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


def _unpacked(message: bytes) -> tuple[Job | None, tuple[Any, ...]]:
    try:
        job: Job = pickle.loads(message)
        return job, (READY,)
    except Exception as error:
        return None, (BAD_JOB, _sendable(error))


def _computed(job: Job, number: int, first: int, last: int) -> tuple[Any, ...]:
    try:
        return DONE, number, job.compute(first, last, _never)
    except BaseException as error:
        return FAILED, number, _sendable(error)


def _never() -> bool:
    """A worker that is no longer wanted is killed."""
    return False


def _sendable(error: BaseException) -> BaseException:
    """The error with where it came from; another in its place when it cannot travel."""
    text = "".join(traceback.format_exception(error))
    try:
        pickle.loads(pickle.dumps(error))
    except Exception:
        error = RuntimeError(f"{type(error).__name__}: {error}")
    error.add_note(f"in a worker process:\n{text}")
    return error
