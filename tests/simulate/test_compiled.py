"""What the cache of compiled functions is valid for."""

from __future__ import annotations

import os
import pickle
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

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


@pytest.mark.slow
def test_what_is_compiled_and_what_is_loaded_give_the_same_bits(tmp_path: Path) -> None:
    """Also where another function was used before, which has copies of the same ones."""
    many = (
        "from percuss import simulate_many, Starts; import numpy as np; "
        "simulate_many(system, Starts.rigid(time=np.zeros(2)), modes=32, stop=stop)"
    )
    found = {bits(tmp_path, before) for before in ("", "", many)}
    assert len(found) == 1


def bits(cache: Path, before: str) -> str:
    """A digest of the states of a motion, in a process of its own that does something before."""
    code = (
        "import hashlib; from percuss import Load, Start, Stop, System, run\n"
        "system = System(s=5.0, d=0.0048, restitution=0.6, load=Load.harmonic(0.7, 1.0))\n"
        f"stop = Stop(impacts=300, periodic=False)\n{before}\n"
        "motion = run(system, Start.rigid(-1.0, time=0.3), modes=32, stop=stop)\n"
        "print(hashlib.sha256(motion.states.tobytes()).hexdigest())"
    )
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(cache), "PYTHONPATH": str(Path(percuss.__file__).parents[1])}
    return subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, env=environment, check=True
    ).stdout
