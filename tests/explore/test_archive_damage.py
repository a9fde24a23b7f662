"""Archives after bad disks, power cuts and links that somebody laid: never other numbers in silence, and mended."""

from __future__ import annotations

import json
import os
import random
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pytest

from jobs import Sines, same, whole
from percuss import atomic_write
from percuss.cli import main
from percuss.errors import ArchiveError, Interrupted
from percuss.explore.jobs import archive_layout as layout
from percuss.explore.jobs.archive import FILE, LOCK, Archive
from percuss.explore.jobs.archive_layout import digest, parsed
from percuss.explore.jobs.carrying_out import carry_out
from percuss.explore.jobs.job import Columns

pytest.importorskip("zarr")
HERE = Path(__file__).resolve().parent


@dataclass(frozen=True)
class Counted(Sines):
    """Remembers which items were computed in this process."""

    computed: list[int] = field(default_factory=list, compare=False)

    def compute(self, first: int, last: int, stopped: Callable[[], bool]) -> Columns:
        self.computed.extend(range(first, last))
        return super().compute(first, last, stopped)


def full(path: Path, size: int = 60, chunk: int = 10) -> Path:
    carry_out(Sines(size), archive=path, chunk=chunk, workers=1)
    return path


def half(path: Path) -> Path:
    """With two whole chunks of six, and five items of a third."""
    with Archive.create(path, Sines(60), 10) as archive:
        for number in (0, 3):
            first, last = archive.bounds(number)
            archive.write(number, Sines(60).compute(first, last, lambda: False))
        archive.keep([(12, 15, Sines(60).compute(12, 15, lambda: False))])
        archive.keep([(15, 17, Sines(60).compute(15, 17, lambda: False))])
    return path


def part_of(columns: Columns, which: np.ndarray) -> Columns:
    return {name: np.asarray(values)[which] for name, values in columns.items()}


# -- changed and lost --


def flip(folder: Path, chance: random.Random) -> Path:
    """One bit of one file, all bytes of the archive alike."""
    files = sorted(path for path in folder.rglob("*") if path.is_file())
    (file,) = chance.choices(files, [path.stat().st_size for path in files])
    data = bytearray(file.read_bytes())
    data[chance.randrange(len(data))] ^= 1 << chance.randrange(8)
    file.write_bytes(data)
    return file


@pytest.mark.parametrize(("flips", "seed"), [(12, 1), pytest.param(300, 2, marks=pytest.mark.slow)])
@pytest.mark.parametrize("made", [full, half])
def test_flipped_bits(tmp_path, made, flips, seed):
    """What is read of a changed archive is what was written, or it is refused; resumed it is as if nothing were."""
    truth, chance = whole(Sines(60)), random.Random(seed)
    made(tmp_path / "whole.zarr")
    with Archive.open(tmp_path / "whole.zarr") as archive:
        written = archive.known
    refused = mended = 0
    for i in range(flips):
        bad = tmp_path / f"{i}.zarr"
        shutil.copytree(tmp_path / "whole.zarr", bad)
        file = flip(bad, chance)
        try:
            with Archive.open(bad) as archive:
                found, known = archive.read(), archive.known
            assert not (known & ~written).any(), file
            assert same(part_of(found, known), part_of(truth, known)), file
            assert np.isnan(found["sine"][~known]).all(), file
        except ArchiveError:
            refused += 1
        try:
            assert same(carry_out(Sines(60), archive=bad, resume=True, workers=1), truth), file
            mended += 1
        except ArchiveError as error:
            assert "damaged" in str(error) or "not an archive" in str(error) or "version" in str(error), error
            assert file.name == "zarr.json"
        shutil.rmtree(bad)
    assert refused > flips // 12 and mended > 0


@pytest.mark.parametrize("chunk", ["sine/c/2", "powers/c/2/0", "even/c/5"])
@pytest.mark.parametrize("how", ["missing", "short", "empty", "other"])
def test_a_damaged_chunk_is_computed_again(tmp_path, chunk, how):
    """Told where it is read, and what helps; of all items only those of the chunk are computed."""
    file = full(tmp_path / "a.zarr") / chunk
    data = file.read_bytes()
    if how == "missing":
        file.unlink()
    else:
        file.write_bytes({"short": data[:-3], "empty": b"", "other": bytes(len(data))}[how])
    number = int(chunk.split("/")[2])
    told = rf"damaged: chunk {number} \(items {10 * number} to {10 * number + 9}\)"
    with Archive.open(tmp_path / "a.zarr") as archive, pytest.raises(ArchiveError, match=told) as error:
        archive.read()
    assert "--resume" in str(error.value)
    job = Counted(60)
    seen: list[int] = []
    found = carry_out(
        job, archive=tmp_path / "a.zarr", resume=True, workers=1, progress=lambda p: seen.append(p.damaged)
    )
    assert same(found, whole(Sines(60)))
    assert set(job.computed) == set(range(10 * number, 10 * number + 10)) and set(seen) == {1}
    with Archive.open(tmp_path / "a.zarr") as archive:
        assert same(archive.read(), whole(Sines(60)))


def test_a_sign_that_cannot_be_read(tmp_path):
    (full(tmp_path / "a.zarr") / "done" / "c" / "4").write_bytes(b"\0")
    with pytest.raises(ArchiveError, match="chunk 4"):
        Archive.open(tmp_path / "a.zarr")
    job = Counted(60)
    assert same(carry_out(job, archive=tmp_path / "a.zarr", resume=True, workers=1), whole(Sines(60)))
    assert set(job.computed) == set(range(40, 50))


def test_the_command_tells_of_damage(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    ask = ["sweep", "mini-breaker", "--x", "restitution=0:0.9:40", "-o", "a.zarr", "--workers", "1"]
    assert main(ask) == 0
    next((tmp_path / "a.zarr").glob("*/c/0")).unlink()
    capsys.readouterr()
    assert main(["export", "a.zarr", "-o", "a.csv"]) == 2
    assert "damaged" in (told := capsys.readouterr().err) and "--resume" in told
    assert not (tmp_path / "a.csv").exists()
    assert main([*ask, "--resume"]) == 0
    assert "1 chunk of the archive was damaged" in capsys.readouterr().err
    assert main(["export", "a.zarr", "-o", "a.csv"]) == 0


def test_archives_without_check_sums_are_read_and_continued(tmp_path):
    """Those of the first format."""
    import zarr

    half(tmp_path / "a.zarr")
    with zarr.config.set({"array.write_empty_chunks": True}):
        for name in ("sine", "powers", "remainder", "even", "done"):
            old = zarr.open_array(tmp_path / "a.zarr" / name, mode="r")
            values, shape, chunks, fill = old[:], old.shape, old.chunks, old.fill_value
            shutil.rmtree(tmp_path / "a.zarr" / name)
            new = zarr.create_array(
                zarr.storage.LocalStore(tmp_path / "a.zarr"), name=name, shape=shape, chunks=chunks,
                dtype=values.dtype, fill_value=fill, compressors=None,
            )  # fmt: skip
            new[:] = values
    file = tmp_path / "a.zarr" / "zarr.json"
    about = json.loads(file.read_text())
    about["attributes"]["format"] = 1
    del about["attributes"]["check"]
    file.write_text(json.dumps(about))
    assert same(carry_out(Sines(60), archive=tmp_path / "a.zarr", resume=True, workers=1), whole(Sines(60)))


# -- what is believed --


def retold(path: Path, **attributes: object) -> None:
    """The attributes changed by somebody who knows how check sums are made."""
    file = path / "zarr.json"
    about = json.loads(file.read_text())
    about["attributes"] = layout.checked({**about["attributes"], **attributes})
    file.write_text(json.dumps(about))


@pytest.mark.parametrize(
    "ask", ["[" * 100_000, '{"a":' * 100_000, '{"a":' + "[" * 900 + "]" * 900 + "}", "[]", "{", "7", '{"a":1}']
)
@pytest.mark.parametrize("command", [["show"], ["show", "--json"], ["export", "-o", "out.nc"]])
def test_an_ask_that_is_none(tmp_path, monkeypatch, capsys, ask, command):
    """Brackets without end are an error, not the end of Python's stack."""
    monkeypatch.chdir(tmp_path)
    full(tmp_path / "a.zarr")
    retold(tmp_path / "a.zarr", ask=ask)
    first, *rest = command
    assert main([first, "a.zarr", *rest]) == 2
    assert "damaged" in capsys.readouterr().err


def test_the_whole_of_the_group_is_brackets(tmp_path, capsys):
    (full(tmp_path / "a.zarr") / "zarr.json").write_text("[" * 100_000)
    assert main(["show", str(tmp_path / "a.zarr")]) == 2
    assert "not an archive" in capsys.readouterr().err


@pytest.mark.parametrize(
    "attributes",
    [
        {"size": 61}, {"size": -60}, {"chunk": 0}, {"chunk": 7}, {"columns": {}}, {"columns": {"sine": 1}},
        {"sessions": 1}, {"sha256": "0" * 64}, {"size": "x"}, {"created": None, "chunk": None},
    ],
)  # fmt: skip
def test_attributes_that_cannot_be(tmp_path, attributes):
    full(tmp_path / "a.zarr")
    retold(tmp_path / "a.zarr", **attributes)
    if attributes == {"columns": {}}:  # an archive of nothing, but well-formed
        return
    with pytest.raises((ArchiveError, AttributeError), match="damaged"):
        Archive.open(tmp_path / "a.zarr").read()


def test_asks_and_their_hash():
    assert parsed('{"a":[1,{"b":Infinity}]}') == {"a": [1, {"b": float("inf")}]}
    assert digest(parsed('{"b":1,"a":2}')) == digest({"a": 2, "b": 1})


# -- links --


def test_a_lock_that_is_a_link(tmp_path):
    """The file that it names stays as it was."""
    full(tmp_path / "a.zarr")
    (tmp_path / "mine").write_text("mine")
    (tmp_path / "a.zarr" / LOCK).symlink_to(tmp_path / "mine")
    with pytest.raises(ArchiveError):
        Archive.resume(tmp_path / "a.zarr", Sines(60))
    assert (tmp_path / "mine").read_text() == "mine"


@pytest.mark.parametrize("name", ["sine/c/1", "done/c/1", FILE])
def test_files_that_are_links(tmp_path, name):
    """They are replaced, not written through; what is read through one has its check sum like everything."""
    half(tmp_path / "a.zarr")
    (tmp_path / "mine").write_text("mine")
    file = tmp_path / "a.zarr" / name
    file.unlink(missing_ok=True)
    file.symlink_to(tmp_path / "mine")
    assert same(carry_out(Sines(60), archive=tmp_path / "a.zarr", resume=True, workers=1), whole(Sines(60)))
    assert (tmp_path / "mine").read_text() == "mine"
    assert not file.is_symlink()


def test_a_folder_that_is_a_link(tmp_path):
    half(tmp_path / "a.zarr")
    shutil.move(tmp_path / "a.zarr" / "sine", tmp_path / "elsewhere")
    (tmp_path / "a.zarr" / "sine").symlink_to(tmp_path / "elsewhere")
    with pytest.raises(ArchiveError, match="is a link"):
        carry_out(Sines(60), archive=tmp_path / "a.zarr", resume=True)


# -- the order on the disk --


def test_data_are_on_the_disk_before_their_sign(tmp_path, monkeypatch):
    """Every file is brought to the disk before it has its name, and its name before the next one is begun."""
    told: list[tuple[str, str]] = []
    fsync, replace = os.fsync, os.replace

    def synced(handle: int) -> None:
        told.append(("sync", os.readlink(f"/proc/self/fd/{handle}")))
        fsync(handle)

    def renamed(old: str, new: str) -> None:
        told.append(("name", str(new)))
        assert told[-2] == ("sync", str(old))
        replace(old, new)

    if not Path("/proc/self/fd").exists():
        pytest.skip("no /proc")
    with Archive.create(tmp_path / "a.zarr", Sines(60), 10) as archive:
        monkeypatch.setattr(os, "fsync", synced)
        monkeypatch.setattr(os, "replace", renamed)
        archive.write(2, Sines(60).compute(20, 30, lambda: False))
    home = tmp_path / "a.zarr"
    names = [Path(what) for kind, what in told if kind == "name"]
    assert sorted(path.relative_to(home).parts[0] for path in names[:-1]) == ["even", "powers", "remainder", "sine"]
    assert names[-1] == home / "done" / "c" / "2"
    for name in names:
        at = told.index(("name", str(name)))
        assert told[at + 1] == ("sync", str(name.parent)), told
    assert ("sync", str(home / "powers" / "c")) in told  # a new folder's name too


def test_a_failed_sync_is_no_done_chunk(tmp_path, monkeypatch):
    import errno

    with Archive.create(tmp_path / "a.zarr", Sines(60), 10) as archive:

        def fails(_: int) -> None:
            raise OSError(errno.EIO, "Input/output error")

        with monkeypatch.context() as patch:
            patch.setattr(atomic_write.os, "fsync", fails)
            with pytest.raises(ArchiveError, match="Input/output error"):
                archive.write(0, Sines(60).compute(0, 10, lambda: False))
        assert not archive.done.any()
    with Archive.open(tmp_path / "a.zarr") as archive:
        assert archive.items_done == 0


# -- what is done is kept --


def test_items_of_chunks_that_are_not_complete(tmp_path):
    half(tmp_path / "a.zarr")
    with Archive.open(tmp_path / "a.zarr") as archive:
        assert np.flatnonzero(archive.known).tolist() == [*range(10), *range(12, 17), *range(30, 40)]
        assert (archive.items_done, archive.fraction) == (25, 25 / 60)
        assert same(part_of(archive.read(), archive.known), part_of(whole(Sines(60)), archive.known))
    job = Counted(60)
    assert same(carry_out(job, archive=tmp_path / "a.zarr", resume=True, workers=1), whole(Sines(60)))
    assert sorted(job.computed) == [10, 11, *range(17, 30), *range(40, 60)]
    assert not (tmp_path / "a.zarr" / FILE).exists()


@pytest.mark.parametrize("cut", [1, 20, 50])
def test_a_record_cut_short(tmp_path, cut):
    """Killed, or out of room, while it was written: what came before counts."""
    file = half(tmp_path / "a.zarr") / FILE
    data = file.read_bytes()
    file.write_bytes(data[:-cut])
    with Archive.open(tmp_path / "a.zarr") as archive:
        assert archive.items_done == 23
    job = Counted(60)
    assert same(carry_out(job, archive=tmp_path / "a.zarr", resume=True, workers=1), whole(Sines(60)))
    assert len(job.computed) == 37


def test_a_job_that_was_told_to_stop_keeps_all_items(tmp_path):
    """However large the chunks are."""
    job = Counted(2000, sleep=0.002)
    with pytest.raises(Interrupted) as stop:
        carry_out(job, archive=tmp_path / "a.zarr", chunk=2000, workers=1, progress=lambda p: p.done >= 150)
    assert stop.value.done >= 150
    with Archive.open(tmp_path / "a.zarr") as archive:
        assert archive.items_done == stop.value.done and not archive.done.any()
        known = set(np.flatnonzero(archive.known).tolist())
    again = Counted(2000)
    assert same(carry_out(again, archive=tmp_path / "a.zarr", resume=True, workers=1), whole(Sines(2000)))
    assert not set(again.computed) & known


def test_an_error_keeps_all_items(tmp_path):
    from jobs import Raises

    with pytest.raises(ZeroDivisionError):
        carry_out(Raises(100, bad=70), archive=tmp_path / "a.zarr", chunk=100, workers=1)
    with Archive.open(tmp_path / "a.zarr") as archive:
        assert archive.items_done > 0 and not archive.done.any()


@pytest.mark.parametrize("workers", [1, 2])
@pytest.mark.parametrize("how", [signal.SIGKILL, signal.SIGINT, signal.SIGTERM])
def test_ended_while_a_large_chunk_is_under_way(tmp_path, how, workers):
    """A kill loses a second of work and a little more, not a chunk."""
    command = [sys.executable, str(HERE / "jobs.py"), str(tmp_path / "a.zarr"), "3000", "0.01", "0", str(workers)]
    begin = time.monotonic()
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
    file = tmp_path / "a.zarr" / FILE
    while time.monotonic() < begin + 60 and not (file.exists() and file.stat().st_size > 5000):
        time.sleep(0.05)
    process.send_signal(how)
    process.communicate(timeout=60)
    with Archive.open(tmp_path / "a.zarr") as archive:
        known = archive.known
        assert known.sum() > 50
        assert same(part_of(archive.read(), known), part_of(whole(Sines(3000)), known))


def test_compaction_keeps_what_is_needed(tmp_path, monkeypatch):
    """The file of items under way does not grow without end."""
    from percuss.explore.jobs import carrying_out as task

    monkeypatch.setattr(task, "_MOST_UNDERWAY", 2000)
    monkeypatch.setattr(task, "_EVERY", 0.0)
    monkeypatch.setattr(task, "_SHARE", 1e9)
    sizes: list[int] = []

    def look(progress: object) -> bool:
        file = tmp_path / "a.zarr" / FILE
        sizes.append(file.stat().st_size if file.exists() else 0)
        return False

    found = carry_out(Sines(4000, sleep=0.0005), archive=tmp_path / "a.zarr", chunk=200, workers=1, progress=look)
    assert same(found, whole(Sines(4000)))
    assert max(sizes) < 4000 * 40 / 2
