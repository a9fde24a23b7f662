"""Who computes the chunks: processes of this machine, or whatever else keeps the same few promises."""

from __future__ import annotations

import ast
import math
import multiprocessing
import os
import pickle
import signal
import sys
import threading
import time
import traceback
from collections import deque
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from multiprocessing import parent_process, resource_tracker
from multiprocessing.connection import Connection, wait
from multiprocessing.context import SpawnProcess
from types import FrameType, ModuleType
from typing import Any, Protocol

from percuss.errors import PercussError
from percuss.explore.jobs.job import Columns, Job
from percuss.model.checks import cores

# ---- A few moments in which Ctrl-C waits


@contextmanager
def undisturbed() -> Iterator[None]:
    """The block runs to its end: Ctrl-C and SIGTERM take effect after it."""
    # zarr writes in a thread of its own. Were its caller interrupted, that thread would go on, and might put an older
    # state of a file in the place of the one that is written at the end. Nor is a process left half started.
    came: list[int] = []
    handlers = {}
    if threading.current_thread() is threading.main_thread():  # no other hears signals
        handlers = {which: signal.getsignal(which) for which in (signal.SIGINT, signal.SIGTERM)}
    handlers = {which: handler for which, handler in handlers.items() if callable(handler)}
    for which in handlers:
        signal.signal(which, lambda sig, _: came.append(sig))
    try:
        yield
    finally:
        for which in reversed(handlers):  # Ctrl-C last: from there on the next line may not be reached
            signal.signal(which, handlers[which])
    for sig in came:
        handler = handlers[signal.Signals(sig)]
        assert callable(handler)
        handler(sig, None)


# ---- What a worker process does: take the job, then chunk after chunk, until the asking process is gone

_READY, _BAD_JOB, _DONE, _FAILED = "ready", "bad job", "done", "failed"
"""The first word of everything that a worker says."""


def work(connection: Connection[Any, Any]) -> None:
    """Answer the asking process until it is gone or kills us."""
    # A job is bytes, a chunk (number, first, last); back go (word, number, …): `_READY`, `_DONE`, `_BAD_JOB`,
    # `_FAILED`.
    for which in (signal.SIGINT, signal.SIGTERM):  # Ctrl-C goes to all of a terminal, SIGTERM to all of a batch job;
        signal.signal(which, signal.SIG_IGN)  # the asking process ends us
    threading.Thread(target=_end_with_parent, daemon=True).start()
    job: Any = None
    try:
        while True:
            message = connection.recv()
            is_job, number = isinstance(message, bytes), message[0]
            answer: tuple[Any, ...] = (_READY, number)
            try:
                if is_job:
                    job = pickle.loads(message)
                else:
                    answer = _DONE, number, job.compute(*message[1:], lambda: False)  # the unwanted are killed
            except BaseException as error:
                answer = _BAD_JOB if is_job else _FAILED, number, _sendable(error)
            connection.send(answer)
    except (EOFError, OSError):
        return  # nobody is there any more


def _end_with_parent() -> None:
    """End this process when its parent dies, even when killed: the parent's end of a pipe closes in any case."""
    parent = parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


def _sendable(error: BaseException) -> BaseException:
    """The error with where it came from; another in its place when it cannot travel."""
    text = "".join(traceback.format_exception(error))
    try:
        pickle.loads(pickle.dumps(error))
    except Exception:
        error = RuntimeError(f"{type(error).__name__}: {error}")
    error.add_note(f"in a worker process:\n{text}")
    return error


# ---- Who computes the chunks: processes of this machine, or whatever else keeps the same few promises

_TRIES = 2  # how often a chunk is begun whose worker dies of it
_THREADS = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS")
"""What keeps a worker on its one core."""


@dataclass(frozen=True)
class Chunk:
    """A portion of a job: its number, its first item and the one after its last."""

    number: int
    first: int
    last: int


class Pool(Protocol):
    """Workers that compute chunks of one job after another."""

    @property
    def workers(self) -> int:
        """How many chunks are computed at once; may change."""

    def begin(self, job: Job) -> None:
        """The chunks that follow are of this job."""

    def submit(self, chunk: Chunk) -> None:
        """Have a chunk computed; returns at once."""

    def finished(self, seconds: float) -> list[tuple[Chunk, Columns]]:
        """The chunks that are ready, waiting at most so long for the first; or the error of one that fails."""

    def cancel(self) -> None:
        """Forget all chunks; within a second nothing of them is computed any more."""

    def close(self) -> None:
        """Let the workers go."""


def packed(job: Job) -> bytes:
    """A job as it travels; PercussError when something in it cannot."""
    try:
        return pickle.dumps(job)
    except Exception as error:  # whatever an object's own pickling raises
        remedy = "define functions and classes at the top of a module, or use workers=1"
        raise PercussError(f"this cannot be sent to other processes: {error}", remedy) from None


def needs_main(job: bytes) -> bool:
    """Whether a job as it travels holds something of the asking script's main part, which its reader must import."""
    return b"__main__" in job


@dataclass
class _Worker:
    """A process, the line to it, and the chunks that it has."""

    process: SpawnProcess
    line: Connection[Any, Any]
    chunks: deque[Chunk] = field(default_factory=deque)
    heard: bool = False


class Processes:
    """Worker processes of this machine, one a core; they end with it, leave Ctrl-C to it, and are replaced."""

    def __init__(self, workers: int | None = None) -> None:
        self._number = cores() if workers is None else workers
        self._workers: list[_Worker] = []
        self._waiting: deque[Chunk] = deque()
        self._deaths: dict[int, int] = {}
        self._job = b""
        self._with_main = False

    @property
    def workers(self) -> int:
        return self._number

    def begin(self, job: Job) -> None:
        """Start what is not running and give the job to all."""
        self._job = packed(job)
        if needs_main(self._job) and not self._with_main:
            self.cancel()  # those that there are do not know it
            self._with_main = True
        self._waiting.clear()
        self._deaths.clear()
        for worker in [worker for worker in self._workers if not worker.process.is_alive()]:
            self._bury(worker)
        while len(self._workers) < self._number:
            self._start()
        for worker in self._workers:
            self._tell(worker, self._job)

    def submit(self, chunk: Chunk) -> None:
        """Put a chunk into the row."""
        self._waiting.append(chunk)
        self._assign()

    def finished(self, seconds: float) -> list[tuple[Chunk, Columns]]:
        """The chunks that are ready, waiting at most so long for the first."""
        ready: list[tuple[Chunk, Columns]] = []
        until = time.monotonic() + seconds
        while not ready:
            lines = {worker.line: worker for worker in self._workers}
            heard = wait(list(lines), max(0.0, until - time.monotonic()))
            for line in heard:
                worker = lines[line]  # type: ignore[index]  # only lines are waited for
                try:
                    message = worker.line.recv()
                except (EOFError, OSError):  # a line closes when its process ends
                    self._died(worker)
                    continue
                worker.heard = True
                self._take(worker, message, ready)
            self._assign()
            if not heard:
                break
        return ready

    def cancel(self) -> None:
        """End the workers at once: they own nothing that could be left half done."""
        for worker in self._workers:
            worker.process.kill()
        for worker in self._workers:
            worker.process.join(1.0)
            worker.line.close()
        self._workers.clear()
        self._waiting.clear()

    close = cancel  # letting them end by themselves would take a second

    def __enter__(self) -> Processes:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    # -- one worker --

    def _start(self) -> None:
        context = multiprocessing.get_context("spawn")
        here, there = context.Pipe()
        process = context.Process(target=work, args=(there,), name="percuss worker", daemon=True)
        with undisturbed(), _surroundings(self._with_main):  # another thread may hear a signal that this one blocks
            process.start()
            there.close()  # so that the line closes when the process ends
            self._workers.append(_Worker(process, here))

    def _tell(self, worker: _Worker, message: object) -> None:
        with suppress(OSError):  # when it has died its line tells, and is listened to
            worker.line.send(message)

    def _assign(self) -> None:
        """A chunk for everyone, then a second one to go on with while the first is fetched and written."""
        for ahead in range(2):
            for worker in self._workers:
                if len(worker.chunks) == ahead and self._waiting:
                    chunk = self._waiting.popleft()
                    worker.chunks.append(chunk)
                    self._tell(worker, (chunk.number, chunk.first, chunk.last))

    def _take(self, worker: _Worker, message: tuple[Any, ...], ready: list[tuple[Chunk, Columns]]) -> None:
        word, _, *rest = message
        if word == _DONE:
            ready.append((worker.chunks.popleft(), rest[0]))
        elif word == _FAILED:
            raise rest[0]
        elif word == _BAD_JOB:
            remedy = "define functions and classes in a module that the workers can import, or use workers=1"
            raise PercussError(f"the job cannot be read by a worker process: {rest[0]}", remedy) from rest[0]

    def _died(self, worker: _Worker) -> None:
        """Replace a worker; the chunk that it was at is tried once more."""
        worker.process.join(1.0)
        code = worker.process.exitcode
        self._bury(worker)
        if not worker.heard:
            remedy = "a script must keep what it does under `if __name__ == '__main__':`; or use workers=1"
            raise PercussError(f"a worker process ended as it started ({_cause(code)})", remedy)
        if worker.chunks:
            chunk = worker.chunks[0]
            self._deaths[chunk.number] = self._deaths.get(chunk.number, 0) + 1
            if self._deaths[chunk.number] >= _TRIES:
                told = f"{_TRIES} workers died while computing items {chunk.first} to {chunk.last - 1} ({_cause(code)})"
                raise PercussError(told, "usually there is too little memory: use fewer workers, or ask for less")
            self._waiting.extendleft(reversed(worker.chunks))
        self._start()
        self._tell(self._workers[-1], self._job)

    def _bury(self, worker: _Worker) -> None:
        worker.line.close()
        self._workers.remove(worker)


def _cause(code: int | None) -> str:
    if code is not None and code < 0:
        with suppress(ValueError):
            return f"killed by {signal.Signals(-code).name}"
    return f"exit code {code}"


@contextmanager
def _surroundings(with_main: bool) -> Iterator[None]:
    """Around the start of a process: one thread for each library, no ear for signals, no script of the asker's."""
    main = sys.modules["__main__"]
    before = {name: os.environ.get(name) for name in _THREADS}
    deaf = hasattr(signal, "pthread_sigmask")
    if deaf:
        resource_tracker.ensure_running()  # it would open the ear again
        mask = signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGINT, signal.SIGTERM])
    os.environ.update(dict.fromkeys(_THREADS, "1"))
    if not with_main:
        sys.modules["__main__"] = ModuleType("__main__")  # of which there is nothing to import
    try:
        yield
    finally:
        sys.modules["__main__"] = main
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value
        if deaf:
            signal.pthread_sigmask(signal.SIG_SETMASK, mask)


# ---- How many processes a job gets: this depends on what is asked, never on how busy the machine is
#
# Worker processes are started without the script that asks, so that it needs no main guard. Only a job that holds
# functions or classes of the script's own main part makes them import it; that is safe where the call stands under
# ``if __name__ == "__main__":``.

SMALL = 3.0  # seconds of work for which no processes are started: they take a second or two themselves


def helpers(job: Job, asked: int | None) -> int:
    """Processes for a job: as many as asked for, or by default all cores for a large one and this process otherwise."""
    if asked == 1 or (asked is None and (cores() == 1 or float(getattr(job, "rough_seconds", math.inf)) <= SMALL)):
        return 1
    try:
        reason = _unreachable() if needs_main(packed(job)) else ""
        if not reason:
            return cores() if asked is None else asked
        remedy = "define functions and classes in a module of their own, or use workers=1"
        raise PercussError(f"worker processes cannot import what this job uses from the main script: {reason}", remedy)
    except PercussError:
        if asked is None:
            return 1
        raise


def _unreachable() -> str:
    """Why worker processes cannot import the main part without running this call again; "" when they can."""
    main = sys.modules["__main__"]
    file = getattr(main, "__file__", None)
    if file is None:
        return "an interactive session has no file"
    line = _line_in(main)
    try:
        with open(file, "rb") as source:
            tree = ast.parse(source.read())
    except (OSError, SyntaxError, ValueError):
        return f"{file} cannot be read"
    for statement in tree.body:
        if statement.lineno <= line <= (statement.end_lineno or statement.lineno) and _is_guard(statement):
            return ""
    return "this call is not under `if __name__ == '__main__':`, which would keep them from running it again"


def _line_in(main: ModuleType) -> int:
    """The line that the main part is at, in the thread that runs it; 0 when it has ended."""
    frame: FrameType | None = sys._current_frames().get(threading.main_thread().ident or 0)
    while frame is not None:
        if frame.f_globals is main.__dict__ and frame.f_code.co_name == "<module>":
            return frame.f_lineno
        frame = frame.f_back
    return 0


def _is_guard(statement: ast.stmt) -> bool:
    if not isinstance(statement, ast.If) or not isinstance(statement.test, ast.Compare):
        return False
    sides = [statement.test.left, *statement.test.comparators]
    names = [side.id for side in sides if isinstance(side, ast.Name)]
    texts = [side.value for side in sides if isinstance(side, ast.Constant)]
    return names == ["__name__"] and texts == ["__main__"] and isinstance(statement.test.ops[0], ast.Eq)
