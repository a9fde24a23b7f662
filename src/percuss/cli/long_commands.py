"""What takes long: workers or a cluster, an archive, a progress bar, a Ctrl-C that loses nothing; archives shown."""

from __future__ import annotations

import math
import os
import signal
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType
from typing import TYPE_CHECKING, Any

from percuss.case.answers.facts import number, picked
from percuss.cli.arguments import Option, command, made, need, option, whole
from percuss.cli.waiting import COMPILING, doing, sign
from percuss.errors import Interrupted, PercussError
from percuss.short_repr import duration

if TYPE_CHECKING:
    import argparse

    from percuss.case.answers.facts import Report
    from percuss.cli.arguments import Parser
    from percuss.explore.jobs.archive import Archive
    from percuss.explore.jobs.job import Columns, Job
    from percuss.explore.jobs.progress import JobProgress

PATIENCE = 0.5  # seconds before a progress bar is shown
FIRST_LINE = 10.0
"""Seconds of work before the first line of progress in a log file; the next ones come at growing intervals."""

MOST_SECONDS = 3600.0
MOST_BYTES = 10 * 10**9  # what needs no ``--yes``
UNHEARD = 0.5  # seconds without a report of progress after which Ctrl-C no longer waits for the next one
SELDOM = 5.0  # the same where it is asked more seldom, as in a long proof
SCHEDULER_TIMEOUT = 10.0  # seconds for a scheduler to answer
CARRYING: tuple[Option, ...] = (
    made("-o, --output ARCHIVE", "save finished work in this folder (name.zarr), for --resume"),
    option("--resume", "continue the archive given by -o; start it if there is none"),
    option("--workers N", "processes on this machine (default: all cores)", whole(1)),
    option("--scheduler ADDRESS", "compute on a dask cluster instead: tcp://host:8786"),
    option("--yes", "start even if it takes more than an hour or 10 GB"),
)
"""The options of a job."""


def check_carrying(parser: Parser, options: argparse.Namespace) -> None:
    """Refuse what does not go together or cannot be kept, before anything is computed."""
    if options.workers is not None and options.scheduler is not None:
        parser.error("argument --scheduler: not allowed with --workers: the cluster has its own workers")
    if options.scheduler is not None:
        need("cluster", "distributed")
    if options.output is None:
        if options.resume:
            parser.error("argument --resume: name the archive: -o ARCHIVE")
        return
    need("io", "zarr")
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
    with watching(parser, agreed=agreed) as watch:
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
def watching(parser: Parser, patience: float = UNHEARD, agreed: bool = True) -> Iterator[JobWatch]:
    """A progress bar, and an end by Ctrl-C, for the time of the block."""
    watch = JobWatch(parser.command, agreed, patience)
    mine = threading.current_thread() is threading.main_thread()  # only it may handle signals
    before = signal.getsignal(signal.SIGINT)

    def interrupt(which: int, frame: FrameType | None) -> None:
        try:
            watch.interrupt()
        except KeyboardInterrupt:
            if callable(before):
                before(which, frame)  # which notes it: a compiler makes another error of it
            raise

    if mine:
        signal.signal(signal.SIGINT, interrupt)
    try:
        yield watch
    finally:
        watch.close()
        if mine:
            signal.signal(signal.SIGINT, before or signal.SIG_DFL)


class JobWatch:
    """The progress of a command: a bar for a person, lines for a log; after `patience` s of silence Ctrl-C acts."""

    def __init__(self, what: str, agreed: bool = True, patience: float = UNHEARD) -> None:
        self.interrupted = False
        self._patience = patience
        self._what, self._agreed = what, agreed
        self._seen = sys.stderr is not None and sys.stderr.isatty()
        self._since = time.monotonic()
        self._heard = self._since if patience == SELDOM else None  # what has not begun has nothing to keep
        self._next_line = math.inf  # until the work begins: preparing, such as compiling, says nothing of its pace
        self._bar: Any = None
        self._task: Any = None
        self._damage_told = False

    def __call__(self, progress: JobProgress) -> bool:
        """How far a job is."""
        self._tell_of_damage(progress.damaged)
        if progress.rate != progress.rate:  # until it is known, nothing is to be told
            return self.interrupted
        self._agree(progress)
        told = f"{progress.done} of {progress.size}, {number(progress.rate, 3)}/s"
        return self._shown(progress.fraction, told, progress.seconds_left)

    def share(self, fraction: float, told: str) -> bool:
        """How far a computation is that knows no more than its share of the work, 0 to 1."""
        gone = time.monotonic() - self._since
        return self._shown(fraction, told, gone * (1.0 - fraction) / fraction if fraction else math.nan)

    def asked(self, *_: object) -> bool:
        """Whether to stop, for a computation that knows no share of its work."""
        self._heard = time.monotonic()
        return self.interrupted

    def interrupt(self, *_: object) -> None:
        """The handler of Ctrl-C: an end in order, or at once when nobody asks, while compiling, and the second time."""
        unheard = self._heard is None or time.monotonic() - self._heard > self._patience
        if self.interrupted or unheard or doing(threading.get_ident()) == COMPILING:
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

    def _shown(self, fraction: float, told: str, left: float) -> bool:
        """Draw the bar, or write a line when it is time for one; whether to stop."""
        self._heard = now = time.monotonic()
        line = f"{_percent(fraction)}, {told}{f', {duration(left)} left' if left == left else ''}"
        if self._seen and now - self._since > PATIENCE:
            if self._bar is None:
                self._bar, self._task = new_bar(self._what)
            sign()
            self._bar.update(self._task, completed=fraction, told=line)
        elif self._next_line == math.inf:
            self._next_line = now + FIRST_LINE
        elif not self._seen and now >= self._next_line:
            self._next_line = now + max(FIRST_LINE, 0.1 * (now - self._since))
            print(f"percuss: {self._what}: {line}", file=sys.stderr, flush=True)
        return self.interrupted


def _to_go_on(stop: Interrupted, archived: bool) -> str:
    from percuss.explore.jobs.archive_layout import command

    if stop.archive is None:
        return "nothing has been written yet" if archived else "-o ARCHIVE saves finished work, for --resume"
    line = command(sys.argv)
    if not line.startswith("percuss "):
        return "to continue, give the same command with --resume"
    return f"to continue: {line}{'' if '--resume' in sys.argv else ' --resume'}"


def _size(bytes_: int) -> str:
    for size, name in ((10**12, "TB"), (10**9, "GB"), (10**6, "MB")):
        if bytes_ >= size:
            return f"{number(bytes_ / size, 3)} {name}"
    return f"{bytes_ / 1000:.0f} kB"


def _percent(fraction: float) -> str:
    """Never 100 % of what is not complete."""
    return f"{int(1000.0 * fraction) / 10.0:g} %"


def new_bar(what: str) -> tuple[Any, Any]:
    """A progress bar, whose task tells of itself in `told`."""
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn

    columns = (TextColumn(what), BarColumn(), TextColumn("{task.fields[told]}"))
    bar = Progress(*columns, console=Console(stderr=True), transient=True)
    bar.start()
    return bar, bar.add_task("", total=1.0, told="")


# ---- Archives: what is in one, how far it is, and all of it in one file

_KINDS = (".nc", ".csv")
_ARCHIVE = option("ARCHIVE", "the folder that -o created")


@command(
    """\
What is in an archive that 'percuss sweep' or 'percuss experiment' writes: what was asked for, how complete it is,
which versions wrote it, and how to continue it. You can look at an archive while it is being written.""",
    """\
  percuss show map.zarr
  percuss show map.zarr --json""",
    _ARCHIVE,
    option("--json", "print all of it as JSON, the whole question included"),
)
def show(_: Parser, options: argparse.Namespace) -> int:
    from percuss.cli.report_printing import answered
    from percuss.explore.jobs.archive import Archive

    with Archive.open(options.archive) as archive:
        return answered(options, lambda: _json(archive), lambda: archive_report(archive, options.archive), indent=1)


@command(
    """\
Write what an archive holds into one file: NetCDF with named coordinates and units, or CSV with a line for each item.
Items that an incomplete archive lacks are NaN, or −1 in columns of whole numbers.""",
    """\
  percuss export map.zarr -o map.nc
  percuss export experiment.zarr -o starts.csv""",
    _ARCHIVE,
    made("-o, --output FILE", f"the file, {' or '.join(_KINDS)}", _KINDS, ("io", "xarray"), required=True),
)
def export(_: Parser, options: argparse.Namespace) -> int:
    from percuss.atomic_write import write_dataset
    from percuss.explore.jobs.archive import Archive
    from percuss.explore.jobs.archive_export import dataset_of, write_csv

    with Archive.open(options.archive) as archive:
        write = write_csv if options.output.lower().endswith(".csv") else write_dataset
        write(dataset_of(archive), options.output)
        print(f"{archive.kind}: {options.output}")
        if archive.missing():
            print(f"percuss: note: {_how_far(archive)}; the rest is empty", file=sys.stderr)
    return 0


def archive_report(archive: Archive, name: str) -> Report:
    """What `percuss show` prints for people."""
    from percuss.case.answers.facts import BAD, GOOD, PLAIN, Grid, Report, ReportSection

    missing = bool(archive.missing())
    # what was asked: short values as they are and long ones by their size
    asked = tuple(_rows("", {name: v for name, v in archive.ask.items() if name not in ("kind", "percuss", "axes")}))
    sections: list[ReportSection | Grid] = [ReportSection("what was asked for", asked)]
    axes = archive.ask.get("axes")
    if isinstance(axes, list) and all(isinstance(axis, dict) and axis.get("values") for axis in axes):
        sections.append(Grid("axes", ("name", "values", "from", "to", "unit"), tuple(map(_axis, axes))))
    columns = []
    for column_name, column in archive.columns.items():
        kind = column.dtype + (f" × {' × '.join(map(str, column.shape))}" if column.shape else "")
        unit = f", {column.unit}" if column.unit else ""
        columns.append((column_name, f"{kind}{unit}{': ' if column.meaning else ''}{column.meaning}"))
    sections += [ReportSection("columns", tuple(columns)), ReportSection("how it was made", tuple(_origin(archive)))]
    if missing:
        last = archive.sessions[-1]["command"]
        again = last if not last or last.endswith(" --resume") else f"{last} --resume"
        how = f"the same command with --resume (resume=True){': ' if again else ''}{last}"
        how = again if again.startswith("percuss ") else how
        waits = "wait: a process is writing it" if archive.is_written else how
        sections.append(ReportSection("to continue", (("command", waits),), BAD))
    summary = f"{_how_far(archive)}{', being written' if archive.is_written else ''}" if missing else "complete"
    return Report(f"{name}: {archive.kind}", summary, PLAIN if missing else GOOD, tuple(sections))


def _how_far(archive: Archive) -> str:
    return f"{_percent(archive.fraction)} done: {archive.items_done} of {archive.size} items"


def _axis(axis: dict[str, Any]) -> tuple[str, ...]:
    values = axis["values"]
    return str(axis.get("name")), str(len(values)), _brief(values[0]), _brief(values[-1]), str(axis.get("unit") or "")


def _rows(prefix: str, values: dict[str, Any]) -> Iterator[tuple[str, str]]:
    for name, value in values.items():
        if isinstance(value, dict):
            yield from _rows(f"{prefix}{name}.", value)
        elif value is not None and value != "":
            yield f"{prefix}{name}", _brief(value)


def _brief(value: Any) -> str:
    if isinstance(value, list) and len(value) > 12:
        return f"{len(value)} values, {_brief(value[0])} … {_brief(value[-1])}"
    if isinstance(value, list):
        return ", ".join(_brief(item) for item in value)
    if isinstance(value, dict):
        return "; ".join(f"{name} {_brief(item)}" for name, item in value.items() if item is not None)
    return f"{value:.12g}" if isinstance(value, float) else str(value)


def _origin(archive: Archive) -> list[tuple[str, str]]:
    chunks = len(archive.done)
    rows = [
        ("started", archive.created),
        ("versions", ", ".join(f"{name} {number}" for name, number in archive.versions.items())),
        ("chunks", f"{int(archive.done.sum())} of {chunks} done, {archive.chunk} items each"),
        ("asked, SHA-256", archive.sha256),
    ]
    if archive.sessions[0]["command"]:
        rows.append(("command", archive.sessions[0]["command"]))
    if len(archive.sessions) > 1:
        rows.append(("resumed", f"{len(archive.sessions) - 1} times, last {archive.sessions[-1]['started']}"))
    return rows


def _json(archive: Archive) -> dict[str, Any]:
    return {
        **picked(archive, "kind size fraction chunk created sha256 sessions"),
        "done": archive.items_done,
        "complete": not archive.missing(),
        "being_written": archive.is_written,
        "chunks": len(archive.done),
        "chunks_done": int(archive.done.sum()),
        "columns": {name: picked(column, "dtype shape unit meaning") for name, column in archive.columns.items()},
        "ask": _finite(archive.ask),
    }


def _finite(value: Any) -> Any:
    """JSON has no infinity: as text."""
    if isinstance(value, dict):
        return {name: _finite(item) for name, item in value.items()}
    if isinstance(value, list):
        return [_finite(item) for item in value]
    if isinstance(value, float) and value - value != 0.0:
        return str(value)
    return value
