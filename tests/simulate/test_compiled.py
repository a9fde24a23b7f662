"""What the cache of compiled functions is valid for."""

from __future__ import annotations

import os
import pickle
import shutil
import subprocess
import sys
from pathlib import Path

import percuss
from percuss.compiled import sources_digest


def answer(folder: Path) -> tuple[float, int]:
    """What a function says that calls one of another file of the room, in its own process; and hits of the cache."""
    environment = {**os.environ, "PYTHONPATH": str(folder), "NUMBA_CACHE_DIR": str(folder / "cache")}
    code = "from percuss.simulate.kernels.turned import turned; print(turned(0.25), len(turned.stats.cache_hits))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, env=environment, check=True)
    found, hits = done.stdout.split()
    return float(found), int(hits)


def test_a_change_in_another_file_is_seen(tmp_path: Path) -> None:
    """numba itself would go on with the machine code of before: it looks at the date of a function's own file only."""
    source = Path(percuss.__file__).parent
    shutil.copytree(source, tmp_path / "percuss", ignore=shutil.ignore_patterns("__pycache__", "page"))
    room = tmp_path / "percuss" / "simulate" / "kernels"
    head = "from percuss.compiled import {0}\n"
    inner = head.format("inner") + "\n\n@inner\ndef doubled(x):\n    return {0} * x\n"
    (room / "doubled.py").write_text(inner.format("2.0"))
    (room / "turned.py").write_text(
        head.format("entry")
        + "from percuss.simulate.kernels.doubled import doubled\n\n\n@entry\ndef turned(x):\n    return doubled(x)\n"
    )
    assert answer(tmp_path) == (0.5, 0)
    assert answer(tmp_path) == (0.5, 1)
    (room / "doubled.py").write_text(inner.format("3.0"))
    [index] = tmp_path.rglob("*turned*.nbi")
    with index.open("rb") as file:
        version = pickle.load(file)
    # what comes after the version may name classes that are no more
    index.write_bytes(pickle.dumps(version) + b"cpercuss.simulate.kernels.layout\nGone\n.")
    assert answer(tmp_path) == (0.75, 0)


def test_the_digest_is_of_all_files_of_the_room_and_of_the_functions_own(tmp_path: Path) -> None:
    own = tmp_path / "mine.py"
    own.write_text("a = 1")
    sources_digest.cache_clear()
    before = sources_digest(own)
    own.write_text("a = 2")
    assert sources_digest(own) == before  # asked for once in a process
    sources_digest.cache_clear()
    assert sources_digest(own) != before
