"""The command line and the library open recordings as carefully as the workbench opens uploads."""

from __future__ import annotations

import signal
import subprocess
import sys
import textwrap
import time
import zlib
from pathlib import Path

import numpy as np
import pytest

from hostile_recordings import bombs, hdf5, mat, matrix

for needed in ("h5netcdf", "h5py", "nptdms", "scipy", "xarray"):
    pytest.importorskip(needed)

READ = """
    import resource, sys
    from percuss.errors import HistoryError
    from percuss.recordings.recording import read_recording
    import h5py, nptdms, scipy.io
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    for name in sys.argv[1:]:
        try:
            read_recording(name, sample_rate=1e3, unit="kN")
            told = "READ"
        except HistoryError as error:
            told = str(error)
            assert told.startswith(name), told
        print(name, "|", told)
    print((resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) // 1024)
"""


def test_they_are_refused_and_take_no_memory(tmp_path: Path) -> None:
    """A .mat of 0.5 MB that unpacks to 500 MB, an .h5 of 1.4 kB that holds 6 GB, and whatever else does harm."""
    files = {}
    for what, (name, data, _) in bombs(tmp_path).items():
        if what in ("npz", "mat gzip", "mat gzip of zeros", "mat many cells", "tdms told"):
            continue  # of no kind that is read; no more than may be read; read as far as it goes
        path = tmp_path / f"{what.replace(' ', '-')}{Path(name).suffix}"
        path.write_bytes(data)
        files[str(path)] = what
    packer = zlib.compressobj(9)
    huge = packer.compress(matrix(6, (1, 2**26), b"", 2**29))
    huge += b"".join(packer.compress(bytes(2**20)) for _ in range(500))
    huge += packer.flush()
    (tmp_path / "big.mat").write_bytes(mat((15, huge)))
    (tmp_path / "big.h5").write_bytes(
        hdf5(tmp_path, lambda content: content.create_dataset("force", shape=(8 * 10**8,), dtype="f8", chunks=True))
    )
    for name in ("big.mat", "big.h5"):
        assert (tmp_path / name).stat().st_size < 2_500_000
        files[str(tmp_path / name)] = name
    command = [sys.executable, "-c", textwrap.dedent(READ), *files]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr[-2000:]
    *lines, memory = done.stdout.splitlines()
    assert len(lines) == len(files) and not [line for line in lines if line.endswith("READ")]
    assert int(memory) < 350  # MB; one of them alone took thousands
    told = {files[line.split(" | ")[0]]: line for line in lines}
    for what in ("hdf5 virtual", "hdf5 external data", "mat 7.3 virtual"):
        assert "another file" in told[what]
    assert "unpacks to more than" in told["big.mat"] and "unpacks to more than" in told["big.h5"]


def test_a_line_of_millions_of_columns(tmp_path: Path) -> None:
    from percuss.errors import HistoryError
    from percuss.recordings.recording import read_recording

    (tmp_path / "a.csv").write_bytes(b"1," * 4_900_000)
    with pytest.raises(HistoryError, match="a line of more than"):
        read_recording(tmp_path / "a.csv")


def test_mat_of_version_4_is_read(tmp_path: Path) -> None:
    """It packs nothing."""
    from scipy.io import savemat

    from percuss.recordings.recording import read_recording

    savemat(tmp_path / "a.mat", {"force": np.arange(100.0)}, format="4")
    assert read_recording(tmp_path / "a.mat", sample_rate=1e3, unit="kN").values[5] == 5000.0


def _endless(folder: Path, name: str) -> Path:
    """A file whose heap of shared texts has an object of no size: libhdf5 never comes to the next one."""
    import xarray

    about = {"unit": "kN"}
    dataset = xarray.Dataset({"position": ("n", -1.0 - np.arange(50.0), about)}, coords={"n": np.arange(50.0)})
    dataset.to_netcdf(folder / name, engine="h5netcdf")
    data = bytearray((folder / name).read_bytes())
    at = data.index(b"GCOL")
    data[at + 16 : at + 48] = bytes(32)
    (folder / name).write_bytes(data)
    return folder / name


@pytest.mark.parametrize("door", ["recording", "saved motion", "starts"])
def test_a_damaged_file_that_keeps_its_reader_busy_for_ever(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, door: str
) -> None:
    """32 bytes of it are zero. Whoever reads it is told so, with what to do."""
    from percuss.errors import PercussError
    from percuss.explore.attractors.drawn_starts import table_of
    from percuss.recordings import separate_process
    from percuss.recordings.recording import read_recording
    from percuss.simulate import Trajectory

    read = {
        "recording": lambda path: read_recording(path, sample_rate=1e3),
        "saved motion": Trajectory.load,
        "starts": table_of,
    }[door]
    monkeypatch.setattr(separate_process, "_SECONDS", 3.0)
    path = _endless(tmp_path, "a.h5" if door == "recording" else "a.nc")
    begun = time.monotonic()
    with pytest.raises(PercussError, match=r"within 3 s: it is damaged.* — use a copy of it"):
        read(path)
    assert time.monotonic() - begun < 20.0


@pytest.mark.skipif(sys.platform == "win32", reason="signals")
def test_ctrl_c_ends_the_reading_of_such_a_file(tmp_path: Path) -> None:
    """At once, and the process that reads it goes, too."""
    path = _endless(tmp_path, "a.nc")
    program = "from percuss.cli import main; import sys; sys.exit(main())"
    command = [sys.executable, "-c", program, "simulate", "--resume", str(path)]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as process:
        try:
            child = _child_of(process)
            process.send_signal(signal.SIGINT)
            assert "interrupted" in process.communicate(timeout=60)[1] and process.returncode == 130
            until = time.monotonic() + 60.0
            while Path(f"/proc/{child}").exists() and time.monotonic() < until:
                time.sleep(0.05)
            assert not Path(f"/proc/{child}").exists()
        finally:
            process.kill()


def _child_of(process: subprocess.Popen[str]) -> int:
    children = Path(f"/proc/{process.pid}/task/{process.pid}/children")
    if not children.exists():
        pytest.skip("no /proc with children")
    until = time.monotonic() + 60.0
    while time.monotonic() < until and process.poll() is None:
        if found := children.read_text().split():
            return int(found[0])
        time.sleep(0.1)
    raise AssertionError("nothing was read apart")
