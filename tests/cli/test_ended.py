"""SIGTERM ends every command as Ctrl-C does: in order, with the same exit code, nothing half made left behind."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

pytest.importorskip("zarr")

LONG = ["hydraulic-drifter", "--workers", "2", "--yes"]
PLANE = ["--x", "restitution=0.1:0.9:300", "--y", "load_factor=0.2:1:300", "--quantity", "label"]
COMMANDS = {
    "sweep": ["sweep", *LONG, *PLANE],
    "experiment": ["experiment", *LONG, "--starts", "9000000"],
    "basins": ["basins", *LONG, "--x", "velocity=-1:1:3000", "--y", "time=0:6:3000"],
    "simulate": ["simulate", "heavy-drifter", "--impacts", "900000000", "--full", "--modes", "0"],
    "claims": ["paper", "claims", "--full", "-o", "audit"],
    "best": ["blow", "stepped-drifter", "--best", "efficiency", "--vary", "bar.sections[2].length=50:150mm",
             "--blows", "90000"],
    "design": ["design", "valve-drifter", "--vary", "bar.diameter=45:50mm", "--vary", "load.ports[0].behind=8:24mm",
               "--vary", "load.ports[1].behind=2:8mm", "--vary", "bar.length=300:400mm", "--hammers", "90000"],
    "sweep in an archive": ["sweep", *LONG, *PLANE, "-o", "a.zarr"],
}  # fmt: skip


def ended(arguments: list[str], folder: Path, which: signal.Signals, seconds: float) -> tuple[int, str]:
    """A command that is told to end after so many seconds of its own work, whatever else the machine does."""
    command = [sys.executable, "-m", "percuss", *arguments]
    with subprocess.Popen(
        command, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True
    ) as process:
        until = time.monotonic() + 120.0
        while process.poll() is None and time.monotonic() < until and _worked(process.pid) < seconds:
            time.sleep(0.05)
        process.send_signal(which)
        _, err = process.communicate(timeout=60)
        return process.returncode, err


def _worked(pid: int) -> float:
    """Seconds of processor."""
    try:
        fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    except OSError:
        return 0.0
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


@pytest.mark.slow
@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="no /proc")
@pytest.mark.parametrize("which", [signal.SIGTERM, signal.SIGINT])
@pytest.mark.parametrize("name", COMMANDS)
def test_every_long_command(name, which, tmp_path):
    seconds = 1.5 if name == "simulate" else 3.0  # in which its record is not full yet
    code, err = ended(COMMANDS[name], tmp_path, which, seconds)
    assert code == 130, err
    assert "interrupted" in err or name == "simulate"
    assert "Traceback" not in err
    assert not list(tmp_path.rglob(".percuss-*.part")) and not list(tmp_path.rglob("*.new"))


def test_a_command_that_has_hardly_begun(tmp_path):
    """Also while modules are loaded, where nobody listens yet."""
    if not Path("/proc/self/stat").exists():
        pytest.skip("no /proc")
    code, err = ended(COMMANDS["sweep"], tmp_path, signal.SIGTERM, 0.5)
    assert code in (130, -signal.SIGTERM), err
    assert "Traceback" not in err


def test_ctrl_c_after_the_answer_changes_nothing():
    """While Python takes itself down: the command is done, and its exit code stands."""
    late = "import atexit, os, signal, sys; atexit.register(os.kill, os.getpid(), signal.SIGINT)"
    script = f"{late}; sys.argv[1:] = ['machines']; from percuss.cli import main; sys.exit(main())"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 0 and done.stderr == "" and "hydraulic-drifter" in done.stdout


BREAKS_OFF = {
    "in code made from text": "exec('raise KeyboardInterrupt')",
    "in a library that makes another error of it": """
    try:
        signal.raise_signal(signal.SIGINT)
    except KeyboardInterrupt:
        raise RuntimeError("while something was built") from None
""",
}
"""Where Ctrl-C may come while modules are loaded: in a named tuple, or in a schema of pydantic's."""


@pytest.mark.parametrize("where", BREAKS_OFF)
def test_ctrl_c_while_modules_are_loaded(where, tmp_path):
    """The exit code is that of an interrupted command, with its one line."""
    (tmp_path / "one").mkdir()
    script = f"""
import signal, sys
from percuss.cli import app, main
def run(_):
    {BREAKS_OFF[where].lstrip()}
app.run = run
sys.exit(main())
"""
    (tmp_path / "one" / "__main__.py").write_text(script, encoding="utf-8")
    command = [sys.executable, "-m", "one"]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(tmp_path), os.environ.get("PYTHONPATH", "")])}
    done = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=60, check=False)
    assert (done.returncode, done.stdout, done.stderr) == (130, "", "\npercuss: interrupted\n")


@pytest.mark.slow
def test_workers_leave_sigterm_to_the_asking_process(tmp_path):
    """A batch system sends it to all processes of a job at once."""
    from percuss.explore.jobs.archive import Archive

    jobs = Path(__file__).resolve().parents[1] / "explore" / "jobs.py"
    command = [sys.executable, str(jobs), str(tmp_path / "a.zarr"), "100000", "0.01", "20", "3"]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True, start_new_session=True) as process:
        until = time.monotonic() + 60.0
        while time.monotonic() < until and len(list((tmp_path / "a.zarr" / "done" / "c").glob("*"))) < 3:
            time.sleep(0.05)
        children = Path(f"/proc/{process.pid}/task/{process.pid}/children")
        for pid in children.read_text().split() if children.exists() else []:
            os.kill(int(pid), signal.SIGTERM)
        time.sleep(0.5)
        assert process.poll() is None
        process.send_signal(signal.SIGINT)
        _, err = process.communicate(timeout=60)
    assert "Interrupted" in err and "died" not in err and "ended as it started" not in err
    with Archive.open(tmp_path / "a.zarr") as archive:
        assert archive.items_done > 0


def test_signals_wait_while_something_is_done_to_its_end():
    from percuss.explore.jobs.pool import undisturbed

    before = signal.getsignal(signal.SIGINT)
    done = []
    with pytest.raises(KeyboardInterrupt), undisturbed():
        signal.raise_signal(signal.SIGINT)
        done.append("all of it")
    assert done and signal.getsignal(signal.SIGINT) is before
