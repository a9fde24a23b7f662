"""Carrying jobs out: the same numbers however they are computed, a clean end whatever happens, nobody left behind."""

from __future__ import annotations

import contextlib
import itertools
import json
import math
import os
import re
import signal
import subprocess
import sys
import textwrap
import threading
import time
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from jobs import COLUMNS, Grid, Kills, Raises, Sines, same, whole
from percuss import Load, System
from percuss.cli import long_commands as carrying
from percuss.cli.arguments import Parser
from percuss.cli.long_commands import CARRYING, JobWatch, carried
from percuss.errors import Interrupted, ParameterError, PercussError, UsageError
from percuss.explore.attractors.experiments import experiment_job
from percuss.explore.jobs.archive import Archive
from percuss.explore.jobs.carrying_out import Sheet, carried_into, carry_out, chunk_of, estimate, measured
from percuss.explore.jobs.job import Column, Runs
from percuss.explore.jobs.pool import SMALL, Chunk, Processes
from percuss.explore.jobs.progress import JobProgress, Meter
from percuss.explore.sweeps import sweep_job
from percuss.short_repr import duration

HERE = Path(__file__).resolve().parent
PATHS = os.pathsep.join(filter(None, [str(HERE), os.environ.get("PYTHONPATH")]))
"""Where other processes find the jobs, and the package where these tests find it."""


def alive(pid: int) -> bool:
    """Whether a process runs; one that has ended and is not yet buried does not."""
    try:
        return "\nState:\tZ" not in Path(f"/proc/{pid}/status").read_text()
    except FileNotFoundError:
        return False


def gone(pids: list[int], seconds: float) -> bool:
    until = time.monotonic() + seconds
    while any(map(alive, pids)) and time.monotonic() < until:
        time.sleep(0.05)
    return not any(map(alive, pids))


@pytest.fixture(scope="module")
def processes():
    with Processes(2) as pool:
        yield pool


# -- the same numbers --


@pytest.mark.parametrize("chunk", [None, 1, 7, 1000])
@pytest.mark.parametrize("archived", [False, True])
def test_here(tmp_path, chunk, archived):
    job, path = Sines(67), tmp_path / "a.zarr"
    found = carry_out(job, workers=1, chunk=chunk, archive=path if archived else None)
    assert same(found, whole(job))
    if archived:
        assert same(Archive.open(path).read(), whole(job))
        assert same(carry_out(job, archive=path, resume=True), whole(job))
    assert {name: values.dtype for name, values in found.items()} == {
        name: np.dtype(column.dtype) for name, column in COLUMNS.items()
    }


@pytest.mark.parametrize("chunk", [1, 7, 50])
def test_processes(processes, tmp_path, chunk):
    job = Sines(101)
    assert same(carry_out(job, pool=processes, chunk=chunk), whole(job))
    assert same(carry_out(job, pool=processes, chunk=chunk, archive=tmp_path / "a.zarr"), whole(job))
    assert same(Archive.open(tmp_path / "a.zarr").read(), whole(job))


class Comes:
    """A pool in this process whose workers come and go as a cluster's do: each time it is asked, another number."""

    def __init__(self, numbers: list[int]) -> None:
        self._numbers, self._waiting = itertools.cycle(numbers), []
        self.most = 0

    @property
    def workers(self) -> int:
        return next(self._numbers)

    def begin(self, job: Any) -> None:
        self._job = job

    def submit(self, chunk: Chunk) -> None:
        self._waiting.append(chunk)
        self.most = max(self.most, len(self._waiting))

    def finished(self, seconds: float) -> list[Any]:
        if not self._waiting:
            return []
        chunk = self._waiting.pop()  # the last first
        return [(chunk, self._job.compute(chunk.first, chunk.last, lambda: False))]


@pytest.mark.parametrize("numbers", [[1], [2, 0], [0, 0, 3, 0], [0, 1, 0, 0, 2], [5, 0, 0, 0]])
def test_workers_that_come_and_go(tmp_path, numbers):
    """Also from none at all for a while to some, whenever they are counted."""
    job, pool = Sines(101), Comes(numbers)
    assert same(carry_out(job, pool=pool, chunk=7, archive=tmp_path / "a.zarr"), whole(job))
    assert pool.most <= 4 * max(numbers)
    assert same(Archive.open(tmp_path / "a.zarr").read(), whole(job))


def test_processes_of_its_own(tmp_path):
    """What takes longer than starting processes is given to them, in portions that a short measurement suggests."""
    job, seen = Sines(400, sleep=0.01), []
    begin = time.monotonic()
    found = carry_out(job, workers=4, archive=tmp_path / "a.zarr", progress=seen.append)
    assert same(found, whole(job))
    assert time.monotonic() - begin < 3.9
    assert seen[-1].done == seen[-1].size == 400 and seen[-1].seconds_left == 0.0
    assert 20 <= Archive.open(tmp_path / "a.zarr").chunk <= 200
    assert all(one.done <= other.done for one, other in itertools.pairwise(seen))


class Slow(Sines):
    def one(self, i: int) -> None:
        if i % 97:
            time.sleep(0.03)


def test_what_turns_out_longer_goes_to_processes(monkeypatch):
    """A few quick items were measured; the rest is slow."""
    began = []

    class Recorded(Processes):
        def begin(self, job: Any) -> None:
            began.append(job)
            super().begin(Sines(400))

    monkeypatch.setattr("percuss.explore.jobs.carrying_out.Processes", Recorded)
    monkeypatch.setattr("percuss.explore.jobs.carrying_out._ENOUGH", 0.001)
    job = Slow(400)
    monkeypatch.setattr(
        "percuss.explore.jobs.carrying_out.measured",
        lambda job, stopped: SimpleNamespace(item_seconds=1e-4, portions=()),
    )
    assert same(carry_out(job, workers=2), whole(job))
    assert began


def test_interrupted_and_resumed_by_others(tmp_path, processes):
    """Begun here, gone on with in processes, with another number of workers: no difference."""
    job, path = Sines(200, sleep=0.001), tmp_path / "a.zarr"
    with pytest.raises(Interrupted):
        carry_out(job, workers=1, archive=path, chunk=7, progress=lambda p: p.done > 60)
    before = Archive.open(path).done.copy()
    assert 0 < before.sum() < before.size
    times = {p: p.stat().st_mtime_ns for p in (path / "sine" / "c").iterdir()}
    assert same(carry_out(job, pool=processes, archive=path, resume=True, chunk=50), whole(job))
    assert Archive.open(path).chunk == 7  # the archive's own
    assert all(p.stat().st_mtime_ns == when for p, when in times.items())  # what was done is not done again


# -- pace --


def test_portions_jump_about_and_are_kept():
    asked = []

    class Counted(Sines):
        def one(self, i: int) -> None:
            asked.append(i)

    pace = measured(Counted(10_000, sleep=0.002), lambda: False)
    assert 0.002 <= pace.item_seconds < 0.02
    firsts = [first for first, _, _ in pace.portions]
    assert max(firsts) - min(firsts) > 2000
    assert sum(last - first for first, last, _ in pace.portions) == len(asked) < 700
    asked.clear()
    job = Counted(40, sleep=0.001)
    carry_out(job, workers=1)
    assert len(asked) < 60


@pytest.mark.parametrize("seconds", [1e-9, 1e-6, 1e-3, 0.3, 100.0])
@pytest.mark.parametrize("size", [1, 10, 10**4, 10**8])
@pytest.mark.parametrize("workers", [1, 2, 64])
def test_chunks(seconds, size, workers):
    chunk = chunk_of(size, seconds, workers)
    assert 1 <= chunk <= size
    if size * seconds < 1e5:
        assert -(-size // chunk) <= 4000
    if size * seconds > 40 * workers:
        longest = 2.2 * max(1.0, workers / 16)
        assert chunk == 1 or 0.8 <= chunk * seconds <= (longest if size / chunk < 3_999 else 30 * longest)
        assert size / chunk >= min(size, 3 * workers)


def test_estimate_of_ten_thousand_million():
    found = estimate(Sines(10**10, sleep=0.001))
    assert 0.5e7 < found.seconds < 3e7
    assert found.bytes == 10**10 * (8 + 24 + 2 + 1)


def test_meter():
    seen: list[JobProgress] = []
    meter = Meter(100, 800, seen.append)
    assert math.isnan(meter.progress().rate)
    meter.start(20, expected=5.0)
    assert meter.progress() == JobProgress(20, 100, 5.0, 16.0, 800)
    time.sleep(0.05)
    meter.add(10)
    assert 50 < meter.rate < 250
    assert meter.progress().fraction == 0.3
    assert not meter.tell() and not meter() and len(seen) == 1  # not again within a tenth of a second
    asked = Meter(1, 1, lambda _: True)
    assert asked() and asked.stopped


def test_sheet():
    sheet = Sheet(Sines(10), 8)
    sheet.put(2, Sines(10).compute(2, 4, lambda: False))
    sheet.put(6, Sines(10).compute(6, 10, lambda: False))
    sheet.put(9, Sines(10).compute(9, 10, lambda: False))
    assert sheet.columns["remainder"].tolist() == [-1, -1, 2, 3, -1, -1, 6, 0] and np.isnan(sheet.columns["sine"][1])


def test_runs():
    """Beside a set, in any order."""
    random = np.random.default_rng(1)
    for _ in range(200):
        runs, there = Runs(), set()
        for _ in range(random.integers(1, 12)):
            first = int(random.integers(0, 30))
            last = first + int(random.integers(1, 6))
            gaps = {i for a, b in runs.gaps(first, last) for i in range(a, b)}
            assert gaps == set(range(first, last)) - there
            runs.add(first, last)
            there |= set(range(first, last))
        gaps = runs.gaps(0, 40)
        assert {i for a, b in gaps for i in range(a, b)} == set(range(40)) - there
        assert all(b < c for (_, b), (c, _) in itertools.pairwise(gaps))


class Once:
    """Takes items, each once."""

    def __init__(self, size: int) -> None:
        self.columns: dict[str, Any] = {}
        self.came, self.sheet = np.zeros(size, dtype=int), Sheet(Sines(size))

    def put(self, first: int, columns: dict[str, Any]) -> None:
        self.came[first : first + columns["even"].size] += 1
        self.sheet.put(first, columns)


@pytest.mark.parametrize("workers", [1, 2])
@pytest.mark.parametrize("archived", [True, False])
def test_items_go_elsewhere_each_once(tmp_path, processes, workers, archived):
    job, place = Sines(300, sleep=0.002), tmp_path / "a.zarr"
    running = {"workers": workers, "archive": place if archived else None, "chunk": 40}
    if archived:
        with pytest.raises(Interrupted):
            carried_into(Once(300), job, progress=lambda now: now.done > 100, **running)
    taken = Once(300)
    assert carried_into(taken, job, resume=archived, **running) == {}
    assert (taken.came == 1).all() and same(taken.sheet.columns, whole(job))
    if archived:
        with Archive.open(place) as archive:
            assert same(archive.read(), whole(job)) and archive.items_done == 300
            assert len(list(archive.parts())) == 1


# -- what goes wrong --


@pytest.mark.parametrize("options", [{"workers": 0}, {"workers": 1.5}, {"chunk": 0}, {"workers": True}])
def test_bad_numbers(options):
    with pytest.raises(ParameterError):
        carry_out(Sines(), **options)


def test_a_worker_that_is_killed_once(tmp_path, processes):
    """Its chunk is tried again; nobody notices."""
    job = Kills(100, memory=str(tmp_path / "killed"))
    assert same(carry_out(job, pool=processes, chunk=10), whole(job))
    assert (tmp_path / "killed").exists()
    assert processes.workers == 2


def test_a_chunk_that_kills_every_worker(tmp_path, processes):
    with pytest.raises(
        PercussError, match=r"2 workers died while computing items 50 to 59 \(killed by SIGKILL\)"
    ) as error:
        carry_out(Kills(100), pool=processes, chunk=10, archive=tmp_path / "a.zarr")
    assert "memory" in str(error.value)
    assert Archive.open(tmp_path / "a.zarr").fraction > 0.0
    assert same(carry_out(Sines(20), pool=processes, chunk=10), whole(Sines(20)))  # the pool is fit for others


@pytest.mark.parametrize("pooled", [False, True])
def test_an_item_that_raises(tmp_path, processes, pooled):
    """It must not; but what was done is kept, and the error says where it came from."""
    with pytest.raises(ZeroDivisionError, match="item 50") as error:
        carry_out(Raises(100), pool=processes if pooled else None, workers=1, chunk=10, archive=tmp_path / "a.zarr")
    notes = "\n".join(error.value.__notes__)
    assert "continue with --resume" in notes and "a.zarr" in notes
    assert ("in a worker process" in notes and "in one" in notes) is pooled
    assert Archive.open(tmp_path / "a.zarr").fraction > 0.0


def test_a_job_that_cannot_travel(processes):
    class Local(Sines):
        pass

    with pytest.raises(PercussError, match="cannot be sent to other processes"):
        carry_out(Local(10), pool=processes, chunk=5)


class Torn(Sines):
    """Falls apart where it arrives."""

    def __reduce__(self) -> Any:
        return _torn, (os.getpid(), self.size)


def _torn(pid: int, size: int) -> Sines:
    if os.getpid() != pid:
        raise ImportError("no module of that name here")
    return Sines(size)


def test_a_job_that_cannot_arrive(processes):
    with pytest.raises(PercussError, match="cannot be read by a worker process: no module of that name"):
        carry_out(Torn(10), pool=processes, chunk=5)
    assert same(carry_out(Sines(20), pool=processes, chunk=10), whole(Sines(20)))


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (lambda found: found.pop("sine"), "announced"),
        (lambda found: found.update(sine=found["sine"][:1]), "column sine: the job computed shape"),
    ],
)
def test_a_job_that_breaks_its_word(change, told):
    class Liar(Sines):
        def compute(self, first: int, last: int, stopped: Any) -> Any:
            found = super().compute(first, last, stopped)
            change(found)
            return found

    with pytest.raises(ValueError, match=told):
        carry_out(Liar(20), workers=1, chunk=10)


def test_more_than_memory_holds():
    with pytest.raises(PercussError, match=r"items take 3\.5e\+05 GB and this machine has"):
        carry_out(Sines(10**13))


def script(folder: Path, text: str) -> Any:
    """What a script without a main guard comes to, that says each time when it is run."""
    (folder / "study.py").write_text(f"print('run')\n{textwrap.dedent(text)}\nprint('end')\n")
    env = {**os.environ, "PYTHONPATH": PATHS}
    command = [sys.executable, str(folder / "study.py")]
    return subprocess.run(command, capture_output=True, text=True, env=env, timeout=100)


def test_a_script_without_a_guard(tmp_path):
    """Worker processes do not import it: it runs once, whatever it asks and however long that takes."""
    done = script(tmp_path, """
        from jobs import Marks
        from percuss.explore.jobs.carrying_out import carry_out
        import os
        os.mkdir("marks") if not os.path.exists("marks") else None
        carry_out(Marks(1000, sleep=0.01, folder="marks"), workers=2)
        print(len(os.listdir("marks")), "processes")
    """.replace('"marks"', repr(str(tmp_path / "marks"))))  # fmt: skip
    assert (done.stdout, done.stderr) == ("run\n2 processes\nend\n", "")


SMALL_CALLS = """
    import dataclasses
    import percuss.explore.jobs.carrying_out as task
    from percuss import Load, System
    from percuss.explore import basins, experiment, sweep
    from percuss.explore.jobs.pool import Processes

    def never(self): raise SystemExit("a process was started")
    Processes._start = never
    quick = task.measured
    task.measured = lambda *given: dataclasses.replace(quick(*given), item_seconds=10.0)  # a very busy machine
    system = System(s=20.0, d=0.0048, restitution=0.6, load=Load.harmonic(0.9, 1.0))
    def own(system): return system.s
    experiment(system, 200)
    basins(system, ("time", 0.0, 6.0, 5), ("velocity", -6.0, -0.1, 5))
    sweep(system, "restitution=0.2,0.6", quantities=["label"], modes=0)
    sweep(system, "restitution=0.2,0.6", quantities=["label", "stable"], modes=0, functions={"own": own})
"""


def test_small_jobs_start_no_processes_however_busy_the_machine(tmp_path):
    done = script(tmp_path, SMALL_CALLS)
    assert (done.stdout, done.stderr) == ("run\nend\n", "")


OWN = """
    from percuss import Load, System
    from percuss.errors import PercussError
    from percuss.explore.jobs.pool import helpers
    from percuss.explore.sweeps import sweep_job
    def own(system): return system.s
    def answer(asked):
        system = System(s=20.0, d=0.0048, restitution=0.6, load=Load.harmonic(0.9, 1.0))
        job = sweep_job(system, "s=1:20:9999", quantities=["label"], functions={"own": own})
        return helpers(job, asked)
    def said(asked):
        try:
            return answer(asked)
        except PercussError as error:
            return str(error)
"""


def test_what_only_the_main_part_has(tmp_path, monkeypatch):
    """Its functions reach workers only from under a guard; elsewhere this process computes, or the error says why."""
    both = OWN + "    print(said(1), said(3), said(None), sep='; ')"
    one, three, default = script(tmp_path, both).stdout.splitlines()[1].split("; ")
    assert (one, default) == ("1", "1")
    assert "not under `if __name__ == '__main__':`" in three and "module of their own, or use workers=1" in three
    guarded = OWN + "    if __name__ == '__main__':\n        print(said(3), said(None) > 0, sep='; ')"
    assert script(tmp_path, guarded).stdout.splitlines()[1] == "3; True"
    other = OWN + "    if __name__ != '__main__':\n        pass\n    else:\n        print(said(3))"
    assert "not under" in script(tmp_path, other).stdout
    typed = subprocess.run([sys.executable, "-c", textwrap.dedent(both)], capture_output=True, text=True, timeout=60)
    assert "an interactive session has no file" in typed.stdout


def test_functions_of_the_main_part_by_processes(tmp_path):
    """Under the guard they import it, and the rest of it runs no second time."""
    (tmp_path / "own.py").write_text(textwrap.dedent("""
        import dataclasses, os
        from jobs import Sines
        from percuss.explore.jobs.carrying_out import carry_out

        class Mine(Sines):
            def one(self, i):
                open(os.path.join(os.environ["MARKS"], str(os.getpid())), "w").close()

        if __name__ == "__main__":
            carry_out(Mine(800, sleep=0.01), workers=2)
            print(len(os.listdir(os.environ["MARKS"])))
    """))  # fmt: skip
    (tmp_path / "marks").mkdir()
    env = {**os.environ, "MARKS": str(tmp_path / "marks")}
    env["PYTHONPATH"] = os.pathsep.join([str(HERE), env.get("PYTHONPATH", "")])
    done = subprocess.run([sys.executable, "own.py"], capture_output=True, text=True, env=env, cwd=tmp_path, timeout=60)
    assert (done.stdout, done.stderr) == ("2\n", "")


def test_what_cannot_travel_is_refused_before_anything_is_computed():
    """Also when it is small: whether it is would depend on the machine."""

    class Local(Sines):
        pass

    with pytest.raises(PercussError, match="use workers=1"):
        carry_out(Local(5), workers=2)
    assert same(carry_out(Local(5), workers=1), whole(Local(5)))
    assert same(carry_out(Local(5)), whole(Local(5)))


def test_rough_seconds_say_what_is_small():
    system = System(s=20.0, d=0.0048, restitution=0.6, load=Load.harmonic(0.9, 1.0))
    assert experiment_job(system, 1000, modes=0).rough_seconds < SMALL < experiment_job(system, modes=0).rough_seconds
    few, many = (sweep_job(system, f"s=1:20:{n}", quantities=["label", "margin"]) for n in (20, 20_000))
    assert few.rough_seconds < SMALL < many.rough_seconds
    by_arrays = sweep_job(system, "restitution=0:0.9:100", "load_factor=0.1:1:100", quantities=["orbits"])
    assert by_arrays.rough_seconds < SMALL


# -- the end --


@pytest.mark.parametrize("workers", [1, 2, 9])
@pytest.mark.parametrize("archived", [False, True])
def test_a_watcher_ends_it(tmp_path, workers, archived):
    begin = []

    def watch(progress: JobProgress) -> bool:
        if progress.done > 20 and not begin:
            begin.append(time.monotonic())
        return bool(begin)

    path = tmp_path / "a.zarr"
    with pytest.raises(Interrupted) as stop:
        carry_out(Sines(5000, sleep=0.005), workers=workers, archive=path if archived else None, progress=watch)
    assert time.monotonic() - begin[0] < 2.0
    assert stop.value.size == 5000 and stop.value.archive == (str(path) if archived else None)
    assert ("--resume" if archived else "saves finished work") in str(stop.value)
    if archived:
        with Archive.open(path) as archive:
            assert archive.items_done == stop.value.done and not archive.is_written


SCRIPT = """
import sys
from pathlib import Path
from jobs import Marks
from percuss.explore.jobs.carrying_out import carry_out
if __name__ == "__main__":
    folder, workers = sys.argv[1:]
    def watch(progress):
        (Path(folder) / "done").write_text(str(progress.done))
    try:
        carry_out(Marks(3000, sleep=0.01, folder=folder), archive=folder + "/a.zarr", resume=True,
                  workers=int(workers), chunk=10, progress=watch)
    except BaseException as error:
        print(type(error).__name__, error, flush=True)
        raise SystemExit(130)
"""


@contextlib.contextmanager
def started(tmp_path: Path, workers: int) -> Any:
    """The script as a process group of its own, some chunks done, and the numbers of all processes."""
    (tmp_path / "script.py").write_text(SCRIPT)
    env = {**os.environ, "PYTHONPATH": PATHS}
    command = [sys.executable, str(tmp_path / "script.py"), str(tmp_path), str(workers)]
    process = subprocess.Popen(
        command, env=env, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True
    )
    try:
        until = time.monotonic() + 30
        done = tmp_path / "done"
        while time.monotonic() < until and not (done.exists() and len(_marks(tmp_path)) == workers + (workers > 8)):
            time.sleep(0.05)
        time.sleep(0.5)
        yield process, _marks(tmp_path)
    finally:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
        process.communicate()


def _marks(folder: Path) -> list[int]:
    return [int(path.name) for path in folder.iterdir() if path.name.isdigit()]


@pytest.mark.parametrize("workers", [1, 3, 9])  # alone, helping, only writing
def test_ctrl_c(tmp_path, workers):
    """Sent to all, as a terminal does: within two seconds it has ended, said how to go on, and nobody is left."""
    with started(tmp_path, workers) as (process, pids):
        assert len(pids) == workers + (workers > 8)
        begin = time.monotonic()
        os.killpg(process.pid, signal.SIGINT)
        out, err = process.communicate(timeout=10)
        assert time.monotonic() - begin < 2.0
        assert process.returncode == 130 and err == ""
        assert out.startswith("Interrupted interrupted after") and "--resume" in out
        assert gone(pids, 1.0)
    with Archive.open(tmp_path / "a.zarr") as archive:
        assert archive.items_done > 0 and not archive.is_written


def test_workers_end_with_a_parent_that_is_killed(tmp_path):
    with started(tmp_path, 3) as (process, pids):
        assert len(pids) == 3
        process.kill()
        process.wait()
        assert gone(pids, 2.0)
        out, err = process.communicate()
        assert (out, err) == ("", "")


def test_ctrl_c_while_processes_start(tmp_path):
    """Before they can ignore it themselves."""
    code = textwrap.dedent("""
        import os, signal, threading, time
        from jobs import Sines
        from percuss.explore.jobs.pool import Processes
        if __name__ == "__main__":
            with Processes(2) as pool:
                threading.Timer(0.05, os.killpg, (os.getpgrp(), signal.SIGINT)).start()
                try:
                    pool.begin(Sines(10))
                    pool.finished(5.0)
                except KeyboardInterrupt:
                    print("interrupted")
    """)
    (tmp_path / "script.py").write_text(code)
    env = {**os.environ, "PYTHONPATH": PATHS}
    process = subprocess.Popen(
        [sys.executable, str(tmp_path / "script.py")], env=env, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        text=True, start_new_session=True,
    )  # fmt: skip
    out, err = process.communicate(timeout=30)
    assert (out, err) == ("interrupted\n", "")


def test_pool_forgets(processes):
    """What was asked before does not come back."""
    processes.begin(Sines(100, sleep=0.2))
    for number in range(5):
        processes.submit(Chunk(number, 10 * number, 10 * number + 10))
    begin = time.monotonic()
    processes.cancel()
    assert time.monotonic() - begin < 1.0
    assert processes.finished(0.1) == []
    assert same(carry_out(Sines(20), pool=processes, chunk=10), whole(Sines(20)))


# -- the command line's share --


def options_of(*arguments: str) -> tuple[Parser, Any]:
    parser = Parser("sweep", "", "", CARRYING)
    return parser, parser.parsed(arguments)


@pytest.fixture
def in_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["--resume"], "-o ARCHIVE"),
        (["--workers", "0"], "1 or greater"),
        (["--workers", "2", "--scheduler", "tcp://127.0.0.1:1"], "not allowed with --workers"),
        (["-o", "map.nc"], "percuss export"),
    ],
)
def test_options_that_do_not_go_together(in_folder, arguments, told):
    with pytest.raises(UsageError, match=re.escape(told)):
        carried(*options_of(*arguments), Grid())


def test_what_takes_long_needs_a_yes(in_folder):
    with pytest.raises(PercussError, match=r"10000000000 items would take about .* (days|years) and 350 GB") as error:
        carried(*options_of("-o", "a.zarr", "--workers", "2"), Sines(10**10, sleep=0.001))
    assert "--yes" in str(error.value) and not Path("a.zarr").exists()
    with pytest.raises(PercussError, match="memory"):
        carried(*options_of("--workers", "2", "--yes"), Sines(10**13))


def test_what_was_begun_needs_no_second_yes(in_folder, monkeypatch):
    with pytest.raises(Interrupted):
        carry_out(Sines(300, sleep=0.005), workers=1, archive="a.zarr", progress=lambda p: p.done > 90)
    monkeypatch.setattr(carrying, "MOST_SECONDS", 0.0)
    with pytest.raises(PercussError, match="would take"):
        carried(*options_of("--workers", "1", "-o", "b.zarr", "--resume"), Sines(300, sleep=0.005))
    parser, options = options_of("--workers", "1", "-o", "a.zarr", "--resume")
    assert same(carried(parser, options, Sines(300, sleep=0.005)), whole(Sines(300)))


def test_lines_in_a_log_file(in_folder, capsys, monkeypatch):
    monkeypatch.setattr(carrying, "FIRST_LINE", 0.3)
    carried(*options_of("--workers", "1"), Sines(150, sleep=0.01))
    lines = capsys.readouterr().err.splitlines()
    assert 1 <= len(lines) <= 6
    assert re.fullmatch(r"percuss: sweep: [\d.]+ %, \d+ of 150, [\d.]+/s, \d+ s left", lines[0])


def test_a_quick_job_writes_no_line_however_long_it_was_prepared(capsys, monkeypatch):
    """Kernels that are compiled first: the pace is known when the work begins, and nothing of it is done by then."""
    now = [1000.0]
    monkeypatch.setattr(carrying.time, "monotonic", lambda: now[0])
    watch = JobWatch("sweep", agreed=True)
    now[0] += 60.0  # compiling
    watch(JobProgress(0, 21, 815.0, 0.026, 100))
    now[0] += 0.03
    watch(JobProgress(21, 21, 815.0, 0.0, 100))
    watch.close()
    assert capsys.readouterr().err == ""
    watch(JobProgress(10, 21, 0.5, 22.0, 100))
    now[0] += carrying.FIRST_LINE
    watch(JobProgress(15, 21, 0.5, 12.0, 100))
    assert capsys.readouterr().err == "percuss: sweep: 71.4 %, 15 of 21, 0.5/s, 12 s left\n"


def test_a_bar_for_a_person(in_folder, capsys, monkeypatch):
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True, raising=False)
    monkeypatch.setattr(carrying, "PATIENCE", 0.0)
    shown: list[Any] = []

    class Bar:
        def update(self, task: object, **what: Any) -> None:
            shown.append(what)

        def stop(self) -> None:
            shown.append("stopped")

    monkeypatch.setattr(carrying, "new_bar", lambda what: (Bar(), 0))
    carried(*options_of("--workers", "1"), Sines(50, sleep=0.01))
    assert shown[-1] == "stopped" and shown[-2]["completed"] == 1.0
    assert shown[-2]["told"].startswith("100 %, 50 of 50")


def test_signals_of_a_watch():
    watch = JobWatch("sweep", agreed=True)
    watch(JobProgress(0, 10, 1.0, 10.0, 80))
    watch.interrupt()
    assert watch(JobProgress(0, 10, 1.0, 10.0, 80)) is True
    with pytest.raises(KeyboardInterrupt):
        watch.interrupt()
    deaf = JobWatch("sweep", agreed=True)
    deaf(JobProgress(0, 10, 1.0, 10.0, 80))
    deaf._heard -= 1.0  # nobody asks: something long runs
    with pytest.raises(KeyboardInterrupt):
        deaf.interrupt()


def test_interrupted_says_the_command(in_folder, monkeypatch):
    monkeypatch.setattr(sys, "argv", ["/usr/bin/percuss", "sweep", "my case.toml", "-o", "a.zarr"])
    before = signal.getsignal(signal.SIGINT)
    threading.Timer(0.8, os.kill, (os.getpid(), signal.SIGINT)).start()
    with pytest.raises(Interrupted) as stop:
        carried(*options_of("-o", "a.zarr", "--workers", "1"), Sines(2000, sleep=0.002))
    assert "to continue: percuss sweep 'my case.toml' -o a.zarr --resume" in str(stop.value)
    assert signal.getsignal(signal.SIGINT) is before


def test_durations():
    assert [duration(x) for x in (0.2, 89, 91, 3599, 86400, 3e7)] == [
        "0 s", "89 s", "1.5 min", "60 min", "24 h", "347 days",
    ]  # fmt: skip


def test_columns_choose_what_is_empty():
    assert [Column(kind).empty for kind in ("int8", "bool")] == [-1, False] and Column("int8", fill=0).empty == 0
    assert json.dumps(Column("uint8", fill=7).empty) == "7"
