"""What the long commands share: workers or a cluster, an archive, a progress bar, and a Ctrl-C that loses nothing."""

from __future__ import annotations

import math
import os
import signal
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, Protocol, TypeVar

from percuss.case.answers.numerals import number
from percuss.cli.arguments import need, whole
from percuss.cli.waiting import sign
from percuss.errors import Interrupted, PercussError
from percuss.shown import duration

if TYPE_CHECKING:
    import argparse

    from percuss.cli.arguments import Parser
    from percuss.explore.jobs.job import Columns, Job
    from percuss.explore.jobs.progress import JobProgress


class Listener(Protocol):
    """What Ctrl-C interrupts."""

    def interrupt(self, *_: object) -> None: ...
    def close(self) -> None: ...


W = TypeVar("W", bound=Listener)

PATIENCE = 0.5
"""Seconds before a progress bar is shown."""

FIRST_LINE = 10.0
"""Seconds of work before the first line of progress in a log file; the next ones come at growing intervals."""

MOST_SECONDS = 3600.0
MOST_BYTES = 10 * 10**9
"""What needs no ``--yes``."""

UNHEARD = 0.5
"""Seconds without a report of progress after which Ctrl-C no longer waits for the next one."""

SCHEDULER_TIMEOUT = 10.0
"""Seconds for a scheduler to answer."""


def add_carrying(parser: Parser) -> None:
    """The options of a long command."""
    add = parser.add_argument
    add("-o", "--output", metavar="ARCHIVE", help="save finished work in this folder (name.zarr), for --resume")
    add("--resume", action="store_true", help="continue the archive given by -o; start it if there is none")
    add("--workers", metavar="N", type=whole, help="processes on this machine (default: all cores)")
    add("--scheduler", metavar="ADDRESS", help="compute on a dask cluster instead: tcp://host:8786")
    add("--yes", action="store_true", help="start even if it takes more than an hour or 10 GB")


def check_carrying(parser: Parser, options: argparse.Namespace) -> None:
    """Refuse what does not go together or cannot be kept, before anything is computed."""
    if options.workers is not None and options.workers < 1:
        parser.error("argument --workers: a whole number, 1 or greater")
    if options.workers is not None and options.scheduler is not None:
        parser.error("argument --scheduler: not allowed with --workers: the cluster has its own workers")
    if options.scheduler is not None:
        need("distributed", "cluster")
    if options.output is None:
        if options.resume:
            parser.error("argument --resume: name the archive: -o ARCHIVE")
        return
    need("zarr", "io")
    if os.path.splitext(options.output)[1].lower() in (".nc", ".csv", ".json", ".toml"):
        remedy = "an archive is a folder: name it .zarr; 'percuss export' turns it into one NetCDF or CSV file"
        parser.error(f"argument -o: '{options.output}': {remedy}")
    if not options.resume:
        from percuss.explore.jobs.archive import check_free

        check_free(options.output)


def carried(parser: Parser, options: argparse.Namespace, job: Job) -> Columns:
    """A job carried out as the options say; all its columns. After Ctrl-C the error says how to go on."""
    from percuss.explore.jobs.carrying_out import carry_out

    with carrying(parser, options) as running:
        return carry_out(job, **running)


@contextmanager
def carrying(parser: Parser, options: argparse.Namespace) -> Iterator[dict[str, Any]]:
    """The keyword arguments of `percuss.explore.carry_out` that the options say, in charge of Ctrl-C for the block."""
    check_carrying(parser, options)
    agreed = options.yes or (options.resume and os.path.exists(options.output))  # when it was begun
    with listening(Watch(parser.prog.rpartition(" ")[2], agreed)) as watch:
        running: dict[str, Any] = {"archive": options.output, "resume": options.resume, "progress": watch}
        if options.scheduler is None:
            running["workers"] = options.workers
        else:
            from percuss.cluster import pool

            running["pool"] = pool(options.scheduler, SCHEDULER_TIMEOUT)
        try:
            yield running
        except Interrupted as stop:
            again = _to_go_on(stop, options.output is not None)
            raise Interrupted(stop.done, stop.size, stop.archive, again, stop.partial) from None
        finally:
            if "pool" in running:
                running["pool"].close()


@contextmanager
def watching(parser: Parser, patience: float = UNHEARD) -> Iterator[Watch]:
    """A progress bar, and an end by Ctrl-C, for what is kept nowhere; see `Watch` for the patience."""
    with listening(Watch(parser.prog.rpartition(" ")[2], True, patience)) as watch:
        yield watch


class Watch:
    """The progress callback: a bar for a person, now and then a line for a log file, and the end after Ctrl-C.

    Parameters
    ----------
    what
        The command.
    agreed
        Whether whatever it takes is fine.
    patience
        Seconds without a report of progress after which Ctrl-C no longer waits for the next one.
    """

    def __init__(self, what: str, agreed: bool, patience: float = UNHEARD) -> None:
        self.interrupted = False
        self._patience = patience
        self._what, self._agreed = what, agreed
        self._seen = sys.stderr is not None and sys.stderr.isatty()
        self._since = self._heard = time.monotonic()
        self._next_line = math.inf  # until the work begins: preparing, such as compiling, says nothing of its pace
        self._bar: Any = None
        self._task: Any = None
        self._damage_told = False

    def __call__(self, progress: JobProgress) -> bool:
        self._heard = now = time.monotonic()
        self._tell_of_damage(progress.damaged)
        if progress.rate == progress.rate:  # until it is known, nothing is to be told
            self._agree(progress)
            if self._seen and now - self._since > PATIENCE:
                self._draw(progress)
            elif self._next_line == math.inf:
                self._next_line = now + FIRST_LINE
            elif not self._seen and now >= self._next_line:
                self._next_line = now + max(FIRST_LINE, 0.1 * (now - self._since))
                print(f"percuss: {self._what}: {_line(progress)}", file=sys.stderr, flush=True)
        return self.interrupted

    def asked(self) -> bool:
        """Whether to stop, for a computation that knows no share of its work."""
        self._heard = time.monotonic()
        return self.interrupted

    def interrupt(self, *_: object) -> None:
        """The handler of Ctrl-C: an end in order, or at once when nobody asks, or when it is said twice."""
        if self.interrupted or time.monotonic() - self._heard > self._patience:
            raise KeyboardInterrupt
        self.interrupted = True

    def close(self) -> None:
        """Take the bar away."""
        if self._bar is not None:
            self._bar.stop()
            self._bar = None

    def _agree(self, progress: JobProgress) -> None:
        """Ask once, before anything is written."""
        if self._agreed:
            return
        if progress.seconds_left > MOST_SECONDS or progress.bytes > MOST_BYTES:
            takes = f"about {duration(progress.seconds_left)} and {_size(progress.bytes)}"
            told = f"{progress.size - progress.done} items would take {takes}"
            raise PercussError(told, "ask for fewer, or add --yes to start anyway")
        self._agreed = True

    def _tell_of_damage(self, chunks: int) -> None:
        """Once, before anything is drawn."""
        if chunks and not self._damage_told:
            what = "1 chunk of the archive was" if chunks == 1 else f"{chunks} chunks of the archive were"
            print(f"percuss: note: {what} damaged and will be recomputed", file=sys.stderr, flush=True)
        self._damage_told = True

    def _draw(self, progress: JobProgress) -> None:
        if self._bar is None:
            self._bar, self._task = new_bar(self._what)
        sign()
        self._bar.update(self._task, completed=progress.fraction, told=_line(progress))


@contextmanager
def listening(watch: W) -> Iterator[W]:
    """The block ends by Ctrl-C as the watch says."""
    mine = threading.current_thread() is threading.main_thread()  # only it may handle signals
    before = signal.signal(signal.SIGINT, watch.interrupt) if mine else None
    try:
        yield watch
    finally:
        watch.close()
        if mine:
            signal.signal(signal.SIGINT, before or signal.SIG_DFL)


def _to_go_on(stop: Interrupted, archived: bool) -> str:
    from percuss.explore.jobs.archive_layout import command

    if stop.archive is None:
        return "nothing has been written yet" if archived else "-o ARCHIVE saves finished work, for --resume"
    line = command(sys.argv)
    if not line.startswith("percuss "):
        return "to continue, give the same command with --resume"
    return f"to continue: {line}{'' if '--resume' in sys.argv else ' --resume'}"


def _line(progress: JobProgress) -> str:
    left = f", {duration(progress.seconds_left)} left" if progress.seconds_left == progress.seconds_left else ""
    done = f"{int(1000.0 * progress.fraction) / 10.0:g} %"
    return f"{done}, {progress.done} of {progress.size}, {number(progress.rate, 3)}/s{left}"


def _size(bytes_: int) -> str:
    for size, name in ((10**12, "TB"), (10**9, "GB"), (10**6, "MB")):
        if bytes_ >= size:
            return f"{number(bytes_ / size, 3)} {name}"
    return f"{bytes_ / 1000:.0f} kB"


def new_bar(what: str, remaining: bool = False) -> tuple[Any, Any]:
    """A progress bar, whose task tells of itself in `told`."""
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

    left = (TimeRemainingColumn(),) if remaining else ()
    columns = (TextColumn(what), BarColumn(), TextColumn("{task.fields[told]}"), *left)
    bar = Progress(*columns, console=Console(stderr=True), transient=True)
    bar.start()
    return bar, bar.add_task("", total=1.0, told="")
