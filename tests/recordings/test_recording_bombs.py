"""The command line and the library open recordings as carefully as the workbench opens uploads."""

from __future__ import annotations

import subprocess
import sys
import textwrap
import zlib
from pathlib import Path

import pytest

from hostile_recordings import bombs, hdf5, mat, matrix

for needed in ("h5py", "nptdms", "scipy"):
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
    import numpy as np
    from scipy.io import savemat

    from percuss.recordings.recording import read_recording

    savemat(tmp_path / "a.mat", {"force": np.arange(100.0)}, format="4")
    assert read_recording(tmp_path / "a.mat", sample_rate=1e3, unit="kN").values[5] == 5000.0
