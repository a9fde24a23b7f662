"""What the cache of compiled functions is valid for."""

from __future__ import annotations

import os
import pickle
import platform
import shlex
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

import percuss
from percuss.compiled import BASELINE as BASELINE_NAME
from percuss.compiled import sources_digest


def answer(folder: Path, cache: str = "cache", before: str = "", **target: str) -> tuple[float, int]:
    """What a function says that calls one of another file of the room, in its own process; and hits of the cache."""
    environment = {**os.environ, "PYTHONPATH": str(folder), "NUMBA_CACHE_DIR": str(folder / cache), **target}
    code = f"{before}\nfrom percuss.simulate.kernels.turned import turned; "
    code += "print(turned(0.25), len(turned.stats.cache_hits))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, env=environment, check=True)
    found, hits = done.stdout.split()
    return float(found), int(hits)


HEAD = "from percuss.compiled import {0}\n"
INNER = HEAD.format("inner") + "\n\n@inner\ndef doubled(x):\n    return {0} * x\n"


def room_of(folder: Path) -> Path:
    """A room of kernels of a copy of the package, with a function that calls one of another file."""
    source = Path(percuss.__file__).parent
    shutil.copytree(source, folder / "percuss", ignore=shutil.ignore_patterns("__pycache__", "page"))
    room = folder / "percuss" / "simulate" / "kernels"
    (room / "doubled.py").write_text(INNER.format("2.0"))
    (room / "turned.py").write_text(
        HEAD.format("entry")
        + "from percuss.simulate.kernels.doubled import doubled\n\n\n@entry\ndef turned(x):\n    return doubled(x)\n"
    )
    return room


def test_a_change_in_another_file_is_seen(tmp_path: Path) -> None:
    """numba itself would go on with the machine code of before: it looks at the date of a function's own file only."""
    room = room_of(tmp_path)
    assert answer(tmp_path) == (0.5, 0)
    assert answer(tmp_path) == (0.5, 1)
    (room / "doubled.py").write_text(INNER.format("3.0"))
    [index] = tmp_path.rglob("*turned*.nbi")
    with index.open("rb") as file:
        version = pickle.load(file)
    # what comes after the version may name classes that are no more
    index.write_bytes(pickle.dumps(version) + b"cpercuss.simulate.kernels.layout\nGone\n.")
    assert answer(tmp_path) == (0.75, 0)


BASELINE = {"NUMBA_CPU_NAME": BASELINE_NAME, "NUMBA_CPU_FEATURES": ""}


@pytest.mark.skipif(platform.machine() not in ("x86_64", "AMD64"), reason="the baseline is of x86-64")
def test_machine_code_that_was_brought_serves_its_sources_on_its_processors(tmp_path: Path) -> None:
    room = room_of(tmp_path)
    assert answer(tmp_path, "made", **BASELINE) == (0.5, 0)
    brought = tmp_path / "percuss" / "machine_code"
    brought.mkdir()
    for file in (tmp_path / "made").rglob("*.nb[ci]"):
        shutil.copy(file, brought)
    assert answer(tmp_path, "empty") == (0.5, 1)
    assert not list((tmp_path / "empty").rglob("*.nbc"))
    told = "from percuss.compiled import is_compiled; from percuss.simulate.kernels.turned import turned; "
    assert answer(tmp_path, "empty", told + "assert is_compiled(turned)") == (0.5, 1)
    without = "import percuss.compiled as compiled; compiled._HAS = ('an instruction that it has not',)"
    assert answer(tmp_path, "other", without) == (0.5, 0)
    (room / "doubled.py").write_text(INNER.format("3.0"))
    assert answer(tmp_path, "later") == (0.75, 0)


COMMANDS = """steady mini-breaker; steady hydraulic-drifter --reach; steady valve-breaker; steady drill-string
machine oil-drifter; machine valve-breaker; report hydraulic-drifter -o r.html; report valve-drifter -o v.html
design valve-breaker --most blow_energy --vary bar.length=1100:1300mm --hammers 30
tolerance mini-breaker --samples 100; compare hydraulic-drifter stepped-drifter
identify valve-drifter --pressure 175bar --flow '123 l/min' --rate 68Hz --energy 277J
simulate mini-breaker; simulate valve-breaker; simulate oil-breaker; orbits mini-breaker --label 2/1
follow mini-breaker --along restitution=0.05:0.3; diagram mini-breaker --along restitution=0.05:0.3:4
blow hydraulic-drifter; sweep mini-breaker --x restitution=0:0.9:4 --quantity label,lyapunov
sweep valve-breaker --x 'pressure=140:160 bar:3'; experiment mini-breaker --starts 10
basins mini-breaker --x time=0:6.28:4 --y velocity=-6:-0.1:4 --at position=-0.5"""


@pytest.mark.slow
@pytest.mark.skipif(platform.machine() not in ("x86_64", "AMD64"), reason="the baseline is of x86-64")
def test_with_a_wheel_of_machine_code_no_command_compiles_anything(tmp_path: Path) -> None:
    root = Path(__file__).parents[2]
    pip = [sys.executable, "-m", "pip", "--disable-pip-version-check", "wheel", "--no-deps", "--no-build-isolation"]
    made = {**os.environ, "PERCUSS_MACHINE_CODE": "1"}
    subprocess.run([*pip, "-w", str(tmp_path), str(root)], check=True, capture_output=True, env=made)
    [wheel] = tmp_path.glob("*.whl")
    zipfile.ZipFile(wheel).extractall(tmp_path / "lib")
    environment = {**os.environ, "PYTHONPATH": str(tmp_path / "lib"), "NUMBA_CACHE_DIR": str(tmp_path / "cache")}
    for command in COMMANDS.replace("\n", ";").split(";"):
        words = [sys.executable, "-m", "percuss", *shlex.split(command)]
        subprocess.run(words, check=True, capture_output=True, env=environment, cwd=tmp_path)
    assert not [file.name for file in (tmp_path / "cache").rglob("*.nbc")]


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
