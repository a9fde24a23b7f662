"""The archive: what it keeps, what it refuses, and that it survives a full disk, a killed writer and a second one."""

from __future__ import annotations

import contextlib
import errno
import json
import os
import random
import resource
import shutil
import signal
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from jobs import COLUMNS, Grid, Sines, same, whole
from percuss.cli import main
from percuss.errors import ArchiveError
from percuss.explore.jobs import archive as module
from percuss.explore.jobs.archive import LOCK, RESULTS, Archive, Lock, check_free, is_locked
from percuss.explore.jobs.archive_export import dataset_of, write_csv
from percuss.explore.jobs.archive_layout import FORMAT, command, differences
from percuss.explore.jobs.carrying_out import carry_out
from percuss.explore.jobs.job import Column

HERE = Path(__file__).resolve().parent


def halfway(path: Path, job: Sines | None = None, chunk: int = 10) -> Sines:
    """An archive with every second chunk."""
    job = job or Sines(95)
    with Archive.create(path, job, chunk) as archive:
        for number in archive.missing()[::2]:
            archive.write(number, whole_of(job, *archive.bounds(number)))
    return job


def whole_of(job: Sines, first: int, last: int) -> dict[str, Any]:
    return job.compute(first, last, lambda: False)


# -- what it keeps --


def test_what_was_written_is_read(tmp_path):
    job = halfway(tmp_path / "a.zarr")
    with Archive.open(tmp_path / "a.zarr") as archive:
        assert archive.ask == job.ask
        assert (archive.size, archive.chunk, archive.kind) == (95, 10, "sines")
        assert {name: column.empty for name, column in archive.columns.items()} == pytest.approx(
            {name: column.empty for name, column in COLUMNS.items()}, nan_ok=True
        )
        assert [column.meaning for column in archive.columns.values()] == [c.meaning for c in COLUMNS.values()]
        assert archive.missing() == [1, 3, 5, 7, 9]
        assert archive.items_done == 50
        assert archive.fraction == 50 / 95
        found, truth = archive.read(), whole(job)
        known = np.repeat(archive.done, 10)[:95]
        assert same({k: v[known] for k, v in found.items()}, {k: np.asarray(v)[known] for k, v in truth.items()})
        for name, column in COLUMNS.items():
            assert np.array_equal(
                found[name][~known],
                np.full_like(found[name][~known], column.empty),
                equal_nan=column.dtype == "float64",
            )
        assert archive.versions["percuss"]
        assert len(archive.sha256) == 64


def test_nans_keep_their_bits(tmp_path):
    """A chunk of nothing but NaN is written, not left out for the fill value."""
    odd = np.frombuffer(np.uint64(0xFFF8000000000123).tobytes())[0]
    job = Sines(10)
    columns = {**whole(job), "sine": np.full(10, odd)}
    with Archive.create(tmp_path / "a.zarr", job, 10) as archive:
        archive.write(0, columns)
    with Archive.open(tmp_path / "a.zarr") as archive:
        assert archive.read()["sine"].tobytes() == np.full(10, odd).tobytes()


def test_other_readers_can_read_it(tmp_path):
    """xarray opens the folder as it is; metadata are JSON without infinities."""
    xarray = pytest.importorskip("xarray")
    carry_out(Grid(), archive=tmp_path / "g.zarr", chunk=5)
    text = (tmp_path / "g.zarr" / "zarr.json").read_text()
    json.loads(text, parse_constant=lambda name: pytest.fail(f"{name} in JSON"))
    with xarray.open_zarr(tmp_path / "g.zarr", consolidated=False) as dataset:
        assert dataset["sine"].attrs["units"] == "rad"
        assert dataset["powers"].dims == ("item", "powers_0")
        assert np.array_equal(dataset["remainder"].values, whole(Grid())["remainder"])


def test_empty_job(tmp_path):
    assert carry_out(Sines(0), archive=tmp_path / "a.zarr")["powers"].shape == (0, 3)
    with Archive.open(tmp_path / "a.zarr") as archive:
        assert archive.fraction == 1.0 and not archive.missing()


# -- what it refuses --


@dataclass(frozen=True)
class Other(Sines):
    seed: int = 3
    extra: bool = False

    @property
    def columns(self) -> dict[str, Column]:
        return {**COLUMNS, "more": Column()} if self.extra else COLUMNS

    @property
    def ask(self) -> dict[str, Any]:
        return {**super().ask, "seed": self.seed}


@pytest.mark.parametrize(
    ("job", "told"),
    [
        (Other(95, seed=4), "seed: 3 in the archive, 4 asked for"),
        (Sines(96), "size: 95 in the archive, 96 asked for"),
        (Grid(), 'kind: "sines" in the archive, "sweep" asked for'),
        (Other(95, extra=True), "what is kept of the items"),
    ],
)
def test_another_ask_is_refused(tmp_path, job, told):
    halfway(tmp_path / "a.zarr")
    with pytest.raises(ArchiveError, match="another question") as error:
        carry_out(job, archive=tmp_path / "a.zarr", resume=True)
    assert told in str(error.value)
    assert not is_locked(tmp_path / "a.zarr")


def test_differences_name_the_parts():
    def axes(values: list[float]) -> dict[str, Any]:
        return {"axes": [{"name": "restitution", "values": values}], "s": 1.0}

    assert differences(axes([1.0, 2.0]), axes([1.0, 2.0])) == ""
    assert differences({"a": (1, 2)}, {"a": [1, 2]}) == ""
    assert (
        differences(axes([1.0, 2.0]), axes([1.0, 2.5]))
        == "axes[restitution].values[1]: 2.0 in the archive, 2.5 asked for"
    )
    told = differences(axes([float(i) for i in range(9)]), axes([0.0]))
    assert told == "axes[restitution].values: 9 values from 0.0 to 8.0 in the archive, [0.0] asked for"
    assert differences({"a": 1}, {"a": True}) and differences({"a": 0.0}, {"a": -0.0})
    assert not differences({"a": float("nan")}, {"a": float("nan")})
    assert "more" in differences({f"k{i}": i for i in range(20)}, {f"k{i}": -1 - i for i in range(20)})


def test_another_version_is_refused(tmp_path, monkeypatch):
    job = halfway(tmp_path / "a.zarr")
    monkeypatch.setattr(module, "versions", lambda: {"percuss": "99.0"})
    with pytest.raises(ArchiveError, match=r"percuss 0\..* started it and this is 99\.0"):
        carry_out(job, archive=tmp_path / "a.zarr", resume=True)


def test_a_newer_format_is_refused(tmp_path):
    halfway(tmp_path / "a.zarr")
    file = tmp_path / "a.zarr" / "zarr.json"
    about = json.loads(file.read_text())
    about["attributes"]["format"] = FORMAT + 1
    file.write_text(json.dumps(about))
    with pytest.raises(ArchiveError, match="newer version"):
        Archive.open(tmp_path / "a.zarr")


def test_what_exists_is_refused(tmp_path):
    job = halfway(tmp_path / "a.zarr")
    with pytest.raises(ArchiveError, match=r"exists, 52\.6 % done") as error:
        carry_out(job, archive=tmp_path / "a.zarr")
    assert "--resume" in str(error.value)
    (tmp_path / "file").write_text("mine")
    (tmp_path / "folder").mkdir()
    for name in ("file", "folder"):
        with pytest.raises(ArchiveError, match="not an archive"):
            carry_out(job, archive=tmp_path / name)
        with pytest.raises(ArchiveError, match="not an archive"):
            carry_out(job, archive=tmp_path / name, resume=True)
    assert (tmp_path / "file").read_text() == "mine"


def test_a_name_of_glob_characters(tmp_path):
    half = tmp_path / ".a[1]*.zarr.01234567.new"
    half.mkdir()
    (tmp_path / ".a1x.zarr.01234567.new").mkdir()
    halfway(tmp_path / "a[1]*.zarr")
    assert sorted(path.name for path in tmp_path.iterdir()) == [".a1x.zarr.01234567.new", "a[1]*.zarr"]


def test_somebody_is_quicker(tmp_path, monkeypatch):
    """Between the look and the writing."""
    lay_out = module.lay_out

    def late(*arguments: Any) -> None:
        lay_out(*arguments)
        (tmp_path / "a.zarr").mkdir()

    monkeypatch.setattr(module, "lay_out", late)
    with pytest.raises(ArchiveError, match="exists"):
        Archive.create(tmp_path / "a.zarr", Sines(), 10)
    assert [path.name for path in tmp_path.iterdir()] == ["a.zarr"]
    assert not list((tmp_path / "a.zarr").iterdir())


@pytest.mark.parametrize("resume", [False, True])
def test_no_folder_to_put_it_into(tmp_path, resume):
    with pytest.raises(ArchiveError, match="there is no folder"):
        carry_out(Sines(), archive=tmp_path / "none" / "a.zarr", resume=resume)


# -- one writer --


def test_two_writers(tmp_path):
    job = halfway(tmp_path / "a.zarr")
    with Archive.resume(tmp_path / "a.zarr", job):
        with pytest.raises(ArchiveError, match=rf"process {os.getpid()} on .* is writing it"):
            Archive.resume(tmp_path / "a.zarr", job)
        with Archive.open(tmp_path / "a.zarr") as archive:
            assert archive.is_written
    assert not (tmp_path / "a.zarr" / LOCK).exists()
    with Archive.resume(tmp_path / "a.zarr", job) as archive:
        assert len(archive.sessions) == 3


def test_two_processes_resuming_at_once(tmp_path):
    """One goes on, the other is refused; the results are whole."""
    halfway(tmp_path / "a.zarr", Sines(60, sleep=0.02), 5)
    command = [sys.executable, str(HERE / "jobs.py"), str(tmp_path / "a.zarr"), "60", "0.02", "5", "1"]
    both = [subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) for _ in range(2)]
    ends = sorted((process.communicate(timeout=60), process.returncode)[::-1] for process in both)
    assert [code for code, _ in ends] == [0, 1]
    assert "is writing it" in ends[1][1][1]
    with Archive.open(tmp_path / "a.zarr") as archive:
        assert not archive.missing()
        assert same(archive.read(), whole(Sines(60)))


def test_locks_of_the_dead_do_not_count(tmp_path):
    job = halfway(tmp_path / "a.zarr")
    (tmp_path / "a.zarr" / LOCK).write_text(json.dumps({"pid": 2**22 - 7, "host": "elsewhere"}))
    assert not is_locked(tmp_path / "a.zarr")
    Archive.resume(tmp_path / "a.zarr", job).close()


def test_locks_where_the_system_has_none(tmp_path, monkeypatch):
    """Then the file says who writes; other hosts cannot be asked."""
    import socket

    monkeypatch.setattr("percuss.explore.jobs.archive.fcntl", None)
    lock = Lock(tmp_path)
    assert is_locked(tmp_path)
    with pytest.raises(ArchiveError, match="is writing it"):
        Lock(tmp_path)
    lock.release()
    lock.release()
    for who, free in (({"pid": 2**22 - 7, "host": socket.gethostname()}, True), ({"pid": 1, "host": "other"}, False)):
        (tmp_path / LOCK).write_text(json.dumps(who))
        assert is_locked(tmp_path) is not free
        if free:
            Lock(tmp_path).release()
    (tmp_path / LOCK).write_text("")
    Lock(tmp_path).release()


# -- killed --


@pytest.mark.slow
def test_killed_at_any_moment(tmp_path):
    """kill -9 again and again, resumed: bit for bit as undisturbed; only chunks under way are computed again."""
    command = [sys.executable, str(HERE / "jobs.py"), str(tmp_path / "a.zarr"), "300", "0.01", "4", "2"]
    chance = random.Random(5)
    kept: list[set[int]] = [set()]
    patience = 1.0
    for _ in range(12):
        process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        try:
            out, _ = process.communicate(timeout=patience * chance.uniform(0.3, 2.2))
        except subprocess.TimeoutExpired:
            process.kill()
            process.communicate()
        else:
            assert out == "complete\n"
            break
        if (tmp_path / "a.zarr").exists():
            with Archive.open(tmp_path / "a.zarr") as archive:
                kept.append(set(np.flatnonzero(archive.done).tolist()))
                assert kept[-2] <= kept[-1]
        if len(kept) == 1 or kept[-1] == kept[-2]:
            patience *= 1.5  # on a busy machine a command begins late
    assert len(kept) > 2 and kept[-1]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60)
    assert done.stdout == "complete\n", done.stderr
    with Archive.open(tmp_path / "a.zarr") as archive:
        assert same(archive.read(), whole(Sines(300)))
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.zarr"]  # nothing half made is left
    assert not list(tmp_path.rglob("*.partial"))


def test_killed_between_data_and_sign(tmp_path, monkeypatch):
    """Data without their sign do not count."""
    job = Sines(20)
    with Archive.create(tmp_path / "a.zarr", job, 10) as archive:
        archive.write(0, whole_of(job, 0, 10))

        class Killed(BaseException):
            pass

        def dies(*_: object) -> None:
            raise Killed

        archive._arrays["done"] = type("Dies", (), {"__setitem__": dies})()
        with pytest.raises(Killed):
            archive.write(1, whole_of(job, 10, 20))
    with Archive.open(tmp_path / "a.zarr") as archive:
        assert archive.missing() == [1]
        assert np.isnan(archive.read()["sine"][10:]).all()


def test_killed_while_it_was_laid_out(tmp_path, monkeypatch):
    """What is half made never has the archive's name, and goes away with the next try."""

    def dies(*_: object) -> None:
        os.kill(os.getpid(), signal.SIGKILL)

    child = os.fork()
    if child == 0:
        monkeypatch.setattr(module, "lay_out", dies)
        Archive.create(tmp_path / "a.zarr", Sines(), 10)
        os._exit(0)
    os.waitpid(child, 0)
    (half,) = tmp_path.iterdir()
    assert half.name.endswith(".new")
    check_free(tmp_path / "a.zarr")
    assert not list(tmp_path.iterdir())
    halfway(tmp_path / "a.zarr")


# -- disks --


@contextlib.contextmanager
def small_disk(path: Path, size: str) -> Iterator[Path]:
    path.mkdir()
    done = subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={size}", "tmpfs", str(path)], capture_output=True)
    if done.returncode:
        pytest.skip("no rights to mount a disk")
    try:
        yield path
    finally:
        subprocess.run(["umount", "-l", str(path)], check=True)


@pytest.mark.skipif(shutil.which("mount") is None, reason="no mount")
def test_full_disk(tmp_path):
    """The message says so, what was written is there, and with room it goes on."""
    job = Sines(4000)
    with small_disk(tmp_path / "disk", "400k") as disk:
        with pytest.raises(ArchiveError, match="No space left on device") as error:
            carry_out(job, archive=disk / "a.zarr", chunk=50)
        assert "free some space" in str(error.value) and "--resume" in str(error.value)
        with Archive.open(disk / "a.zarr") as archive:
            assert 0 < archive.done.sum() < 80
            found, known = archive.read(), np.repeat(archive.done, 50)
            truth = whole(job)
            assert same({k: v[known] for k, v in found.items()}, {k: np.asarray(v)[known] for k, v in truth.items()})
        subprocess.run(["mount", "-o", "remount,size=8m", str(disk)], check=True)
        assert same(carry_out(job, archive=disk / "a.zarr", resume=True), whole(job))


@pytest.mark.skipif(shutil.which("mount") is None, reason="no mount")
def test_read_only_disk(tmp_path):
    with small_disk(tmp_path / "disk", "4m") as disk:
        job = halfway(disk / "a.zarr")
        subprocess.run(["mount", "-o", "remount,ro", str(disk)], check=True)
        with pytest.raises(ArchiveError, match="cannot be written"):
            carry_out(job, archive=disk / "a.zarr", resume=True)
        with pytest.raises(ArchiveError, match="cannot be written"):
            carry_out(job, archive=disk / "b.zarr")
        with Archive.open(disk / "a.zarr") as archive:
            assert archive.items_done == 50 and not archive.is_written
        assert main(["show", str(disk / "a.zarr")]) == 0


def test_file_size_limit(tmp_path):
    """Where nothing can be mounted: the system refuses to make a file longer."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    job = Sines(4000)
    with Archive.create(tmp_path / "a.zarr", job, 2000) as archive:
        archive.write(0, whole_of(job, 0, 2000))
        old = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (4096, before[1]))
        try:
            with pytest.raises(ArchiveError, match="File too large"):
                archive.write(1, whole_of(job, 2000, 4000))
        finally:
            resource.setrlimit(resource.RLIMIT_FSIZE, before)
            signal.signal(signal.SIGXFSZ, old)
        archive.write(1, whole_of(job, 2000, 4000))
    assert same(Archive.open(tmp_path / "a.zarr").read(), whole(job))


@pytest.mark.parametrize("code", [errno.ENOSPC, errno.EIO])
def test_errors_of_the_disk(tmp_path, monkeypatch, code):
    job = halfway(tmp_path / "a.zarr")
    with Archive.resume(tmp_path / "a.zarr", job) as archive:

        def full(*_: object) -> None:
            raise OSError(code, os.strerror(code))

        archive._arrays["powers"] = type("Full", (), {"__setitem__": full})()
        with pytest.raises(ArchiveError, match=os.strerror(code)):
            archive.write(1, whole_of(job, 10, 20))
        assert archive.missing() == [1, 3, 5, 7, 9]


# -- the commands --


@pytest.fixture
def run(capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)

    def run(*arguments: str) -> tuple[int, str, str]:
        code = main(list(arguments))
        return code, *capsys.readouterr()

    return run


def test_show(run, tmp_path):
    halfway(tmp_path / "a.zarr", Grid(), chunk=5)
    code, out, _ = run("show", "a.zarr")
    assert code == 0
    for text in ("a.zarr: sweep", "58.3 % done: 7 of 12 items", "restitution", "Hz", "float64 × 3", "--resume", "inf",
                 "2 of 3 done, 5 items each"):  # fmt: skip
        assert text in out, out
    carry_out(Grid(), archive=tmp_path / "a.zarr", resume=True)
    _, out, _ = run("show", "a.zarr")
    assert "complete" in out and "to continue" not in out and "resumed" in out
    _, out, _ = run("show", "a.zarr", "--json")
    about = json.loads(out, parse_constant=lambda name: pytest.fail(f"{name} in JSON"))
    assert about["complete"] and about["size"] == 12 and about["columns"]["sine"]["unit"] == "rad"


def test_show_of_what_is_being_written(run, tmp_path):
    with Archive.create(tmp_path / "a.zarr", Sines(), 10):
        _, out, _ = run("show", "a.zarr")
    assert "0 % done: 0 of 100 items, being written" in out and "wait" in out


@pytest.mark.parametrize("name", ["none.zarr", "case.toml"])
def test_show_of_what_is_no_archive(run, tmp_path, name):
    (tmp_path / "case.toml").write_text("title = 'x'")
    code, _, err = run("show", name)
    assert code == 2 and "archive" in err
    code, _, err = run("export", name, "-o", "out.nc")
    assert code == 2 and "archive" in err


def test_export_csv(run, tmp_path):
    halfway(tmp_path / "a.zarr", Grid(), chunk=5)
    code, _, err = run("export", "a.zarr", "-o", "out.csv")
    assert code == 0 and "58.3 % done" in err
    lines = (tmp_path / "out.csv").read_text().splitlines()
    assert lines[0] == "restitution,frequency [Hz],sine [rad],powers_0,powers_1,powers_2,remainder,even"
    assert len(lines) == 13
    x = float(np.sin(1.37))
    assert lines[2].split(",") == ["0.0", "20.0", repr(x), repr(x), repr(x**2), repr(x**3), "1", "false"]
    assert lines[7] == "0.3,30.0,nan,nan,nan,nan,-1,false"  # number 6: not done
    halfway(tmp_path / "b.zarr")
    assert run("export", "b.zarr", "-o", "b.csv")[0] == 0
    assert (tmp_path / "b.csv").read_text().startswith("item,sine [rad],powers_0")


@pytest.mark.parametrize("target", ["out.txt", "none/out.nc", "folder.nc"])
def test_export_to_nowhere(run, tmp_path, target):
    (tmp_path / "folder.nc").mkdir()
    halfway(tmp_path / "a.zarr")
    code, _, err = run("export", "a.zarr", "-o", target)
    assert code == 2 and target.split("/")[0] in err


def test_results_of_kinds(tmp_path, monkeypatch):
    """A kind that is registered is exported as its result has it."""
    xarray = pytest.importorskip("xarray")
    halfway(tmp_path / "a.zarr")

    class Result:
        def __init__(self, archive: Archive) -> None:
            pass

        def to_xarray(self) -> Any:
            return xarray.Dataset({"label": ("start", np.array(["z=1/1", "rest"], dtype=object))})

    monkeypatch.setitem(RESULTS, "sines", f"{__name__}:Result")
    monkeypatch.setitem(globals(), "Result", Result)
    with Archive.open(tmp_path / "a.zarr") as archive:
        found = dataset_of(archive)
        write_csv(found, tmp_path / "a.csv")
    assert list(found) == ["label"] and found.attrs["items"] == 95
    assert (tmp_path / "a.csv").read_text() == "start,label\n0,z=1/1\n1,rest\n"


@pytest.mark.parametrize("until", ["it is laid out", "it is renamed"])
def test_who_was_quicker_is_writing(tmp_path, monkeypatch, until):
    """Two resume what is not there yet: the later is not told to resume, but who writes it, also in the last moment."""
    job, place, exists, seen = Sines(20), tmp_path / "a.zarr", Path.exists, []

    def late(path):
        if path == place and until == "it is renamed" and not seen:
            return bool(seen.append(path))
        return exists(path)

    with Archive.create(place, job, 4):
        monkeypatch.setattr(module, "check_free", lambda path: None)
        monkeypatch.setattr(Path, "exists", late)
        with pytest.raises(ArchiveError, match=f"process {os.getpid()} on .* is writing it — wait"):
            Archive.create(place, job, 4)
    assert not list(tmp_path.glob(".*.new"))


def test_names_that_are_no_text():
    """Bytes of a file name that are no UTF-8 are told as a shell takes them."""
    told = command(["percuss", "sweep", os.fsdecode(b"it's \xff\\.toml"), "a b"])
    assert told == "percuss sweep $'it\\x27s \\xff\\x5c.toml' 'a b'"
    told.encode()
