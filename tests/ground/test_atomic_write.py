"""Files are whole or not there, whatever the disk does and whoever lays links: one helper, used by every writer."""

from __future__ import annotations

import errno
import os
import resource
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from percuss import Load, System, atomic_write, plot
from percuss.atomic_write import PARTS, write_whole
from percuss.cli import main
from percuss.errors import PercussError
from percuss.paper.figure import PaperFigure
from percuss.simulate import Stop, run

SYSTEM = System(s=20.0, d=0.0048, restitution=0.6, load=Load.harmonic(0.9, 1.0))


def _motion(path: Path) -> None:
    pytest.importorskip("h5netcdf")
    run(SYSTEM, modes=2, stop=Stop(impacts=40, periodic=False)).save(path)


def _picture(path: Path) -> None:
    pytest.importorskip("matplotlib")
    from percuss.plot.canvas import new_figure

    figure = new_figure(2.0, 2.0)
    figure.add_subplot().plot([0.0, 1.0])
    plot.save(figure, path)


def _table(path: Path) -> None:
    PaperFigure("fig", "title", {"x": np.arange(3000.0)}, lambda *_: None).write_csv(path)


def _history(path: Path) -> None:
    from percuss.case.catalogue.sample_cases import write_history

    write_history(path)


def _map(path: Path) -> None:
    xarray = pytest.importorskip("xarray")
    from percuss.explore.jobs.archive_export import write_csv

    write_csv(xarray.Dataset({"x": ("item", np.arange(4000.0))}, {"item": np.arange(4000)}), path)


WRITERS: dict[str, Callable[[Path], None]] = {
    "motion.nc": _motion, "picture.png": _picture, "picture.svg": _picture, "table.csv": _table,
    "history.csv": _history, "map.csv": _map,
}  # fmt: skip


@pytest.fixture(params=WRITERS)
def writer(request: pytest.FixtureRequest) -> tuple[str, Callable[[Path], None]]:
    return request.param, WRITERS[request.param]


def test_nothing_is_left_beside_it(writer, tmp_path):
    name, write = writer
    write(tmp_path / name)
    assert [path.name for path in tmp_path.iterdir()] == [name]
    assert (tmp_path / name).stat().st_size > 100


@pytest.mark.parametrize("left", ["{}.part", ".{}.part", "{}.tmp"])
def test_files_and_links_of_others_stay(writer, left, tmp_path):
    """Under names that could be thought of as temporary ones."""
    name, write = writer
    (tmp_path / "mine").write_text("mine")
    (tmp_path / left.format(name)).symlink_to(tmp_path / "mine")
    write(tmp_path / name)
    assert (tmp_path / "mine").read_text() == "mine" and (tmp_path / left.format(name)).is_symlink()


def test_a_link_that_is_named_stays_a_link(writer, tmp_path):
    name, write = writer
    (tmp_path / "there").mkdir()
    (tmp_path / "there" / name).write_text("before")
    (tmp_path / name).symlink_to(tmp_path / "there" / name)
    write(tmp_path / name)
    assert (tmp_path / name).is_symlink() and (tmp_path / "there" / name).stat().st_size > 100


@pytest.mark.parametrize("mode", [0o600, 0o640, 0o664])
def test_who_may_read_it_stays(mode, tmp_path):
    (tmp_path / "a.txt").write_text("before")
    (tmp_path / "a.txt").chmod(mode)
    write_whole(tmp_path / "a.txt", "after")
    assert (tmp_path / "a.txt").stat().st_mode & 0o777 == mode
    write_whole(tmp_path / "new.txt", "new")
    umask = os.umask(0)
    os.umask(umask)
    assert (tmp_path / "new.txt").stat().st_mode & 0o777 == 0o666 & ~umask


def test_no_room(writer, tmp_path):
    """The system refuses to make a file longer: an error in words, what was there before, and no stump."""
    name, write = writer
    (tmp_path / name).write_text("before")
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    old = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    try:
        resource.setrlimit(resource.RLIMIT_FSIZE, (1000, before[1]))
        with pytest.raises(PercussError, match="cannot be written"):
            write(tmp_path / name)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
        signal.signal(signal.SIGXFSZ, old)
    assert (tmp_path / name).read_text() == "before"
    assert [path.name for path in tmp_path.iterdir()] == [name]


@pytest.mark.parametrize("code", [errno.ENOSPC, errno.EIO])
def test_a_disk_that_fails_when_it_is_asked(writer, tmp_path, monkeypatch, code):
    """Written, but not on the disk: it does not take the place of what was there."""
    name, write = writer
    (tmp_path / name).write_text("before")

    def fails(_: int) -> None:
        raise OSError(code, os.strerror(code))

    monkeypatch.setattr(atomic_write.os, "fsync", fails)
    with pytest.raises(PercussError, match="cannot be written"):
        write(tmp_path / name)
    assert (tmp_path / name).read_text() == "before"
    assert [path.name for path in tmp_path.iterdir()] == [name]


def test_what_is_no_file(writer, tmp_path):
    name, write = writer
    (tmp_path / name).mkdir()
    os.mkfifo(tmp_path / f"pipe-{name}")
    for path in (tmp_path / name, tmp_path / f"pipe-{name}", tmp_path / "none" / name):
        with pytest.raises(PercussError):
            write(path)
    assert not list(tmp_path.glob(PARTS))


def test_a_full_disk_does_not_end_python(tmp_path):
    """HDF5 cannot close a file that it cannot write, and ends the process later when its objects go away."""
    if subprocess.run(
        ["mount", "-t", "tmpfs", "-o", "size=40k", "tmpfs", str(tmp_path)], capture_output=True
    ).returncode:
        pytest.skip("no rights to mount a disk")
    code = (
        "import sys\nfrom percuss import Load, System\nfrom percuss.errors import PercussError\n"
        "from percuss.simulate import Stop, run\n"
        "system = System(20.0, 0.0048, 0.6, Load.harmonic(0.9, 1.0))\n"
        "motion = run(system, modes=8, stop=Stop(impacts=300, periodic=False))\n"
        "try:\n    motion.save(sys.argv[1])\nexcept PercussError as error:\n    print(error)\n"
    )
    try:
        done = subprocess.run(
            [sys.executable, "-c", code, str(tmp_path / "a.nc")], capture_output=True, text=True, timeout=120
        )
        assert done.returncode == 0, (done.returncode, done.stderr)
        assert "No space left on device — free some space" in done.stdout
        assert not list(tmp_path.iterdir())
    finally:
        subprocess.run(["umount", "-l", str(tmp_path)], check=True)


def test_new_does_not_follow_a_link_to_nothing(tmp_path, capsys):
    (tmp_path / "case.toml").symlink_to(tmp_path / "elsewhere")
    assert main(["new", "mini-breaker", "-o", str(tmp_path / "case.toml")]) == 2
    assert not (tmp_path / "elsewhere").exists()
