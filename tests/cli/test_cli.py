"""The command line as a whole: help, what is printed where, exit codes of real processes; steady, machines, new."""

from __future__ import annotations

import json
import os
import re
import shlex
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from case_texts import PLAIN
from percuss import Load, System, __version__, steady_states
from percuss.case import MACHINES, Case
from percuss.cli.app import _HELP, COMMANDS, command_of
from percuss.cli.arguments import events, periods, start_keys, time_or_text, whole

PERCUSS = [sys.executable, "-m", "percuss"]


@pytest.fixture
def process(tmp_path):
    """The command as a process of its own: its streams and its exit code are real."""

    def call(*arguments, stdin=""):
        streams = {"input": stdin, "capture_output": True, "text": True, "encoding": "utf-8"}
        done = subprocess.run([*PERCUSS, *arguments], cwd=tmp_path, timeout=120, **streams)
        assert "Traceback" not in done.stderr
        return done

    (tmp_path / "case.toml").write_text(PLAIN, encoding="utf-8")
    return call


# -- help -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("arguments", [[], ["--help"], ["-h"], ["help"]])
def test_help(percuss, arguments):
    percuss(*arguments).told(*COMMANDS, "examples:")


@pytest.mark.parametrize("command", COMMANDS)
def test_help_of_a_command(percuss, command):
    done = percuss(command, "--help")
    done.told("examples:", f"usage: percuss {command}")
    assert percuss("help", command).out == done.out


@pytest.mark.slow
def test_every_example_of_the_help_runs(percuss):
    quick = ("steady", "simulate", "machines", "new")
    texts = [_HELP.split("examples:")[1].split("'percuss COMMAND")[0], *(command_of(name).examples for name in quick)]
    lines = dict.fromkeys(line.strip() for text in texts for line in text.splitlines() if line.strip())
    assert len(lines) >= 14
    for line in lines:
        name, *words = shlex.split(line.split(" > ")[0])
        if words[0] == "new" and "-o" in words:
            words.append("--force")  # two of the examples write the same file
        assert name == "percuss" and percuss(*words).code == 0, line
    assert Path("drifter_pressure.csv").exists() and Path("breaker.png").stat().st_size > 5000


def test_help_loads_nothing_heavy():
    code = (
        "import sys\nfrom percuss.cli import main\n"
        "for words in ([], ['--version'], ['machines'], ['new', 'mini-breaker'], *([c, '--help'] for c in\n"
        "              'steady machine simulate orbits follow diagram experiment basins show export'.split())):\n"
        "    try:\n        main(words)\n    except SystemExit:\n        pass\n"
        "heavy = {'numpy', 'pydantic', 'rich', 'matplotlib', 'pint', 'scipy', 'numba'} & set(sys.modules)\n"
        "sys.exit(', '.join(heavy) or 0)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize(
    ("text", "found"),
    [("1", (1,)), ("1..3", (1, 2, 3)), ("3,1", (1, 3)), ("1..2,2,5..6", (1, 2, 5, 6)), ("2-4", (2, 3, 4))],
)
def test_periods(text, found):
    assert periods(text) == found


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("position=-1,velocity=0,time=0.3", {"position": -1, "velocity": 0, "time": 0.3}),
        (" position = −3 cm , time = 1e-3", {"position": "−3 cm", "time": 1e-3}),
        ("modal_displacement=[-1, 0.01],time=2", {"modal_displacement": [-1, 0.01], "time": 2}),
        ("orbit:2", {"orbit": 2}),
        ("orbit=2,periods=3", {"orbit": 2, "periods": 3}),
        ("random", {"random": "rigid"}),
        ("random:ringing,seed=4", {"random": "ringing", "seed": 4}),
    ],
)
def test_start_keys(text, found):
    assert start_keys(text) == found


def test_other_values():
    assert (whole()("0"), whole()("1000000000")) == (0, 10**9)
    assert (time_or_text("2"), time_or_text("2 s")) == (2.0, "2 s")
    assert (events("all"), events("last:7"), events("none")) == ((None,), (7,), (0,))


# -- steady ---------------------------------------------------------------------------------------------------------


def test_json_of_a_plain_case(percuss):
    done = percuss("steady", "case.toml", "--json", "--periods", "1,3", "--modes", "8", "--plot", "picture.svg")
    found = done.json  # nothing but JSON on the standard output
    assert done.err == "picture: picture.svg\n" and Path("picture.svg").stat().st_size > 5000
    assert found["case"] == "case.toml"
    assert found["system"]["coefficients"] == [[0.9, 0.0], [1.0, 0.0]]
    assert [period["m"] for period in found["periods"]] == [1, 3]
    first, third = found["periods"]
    assert first["exists"] is True
    assert first["level"] < first["level_max"]
    assert third["exists"] is False
    assert third["orbits"] == []
    assert set(third["nearest"]) == {"load_factor", "restitution", "d"}
    phases = [orbit["phase"] for orbit in first["orbits"]]
    assert phases == sorted(phases)
    for orbit in first["orbits"]:
        assert [len(orbit["reduced"][name]) for name in ("a", "schur", "moduli")] == [3, 2, 2]
        assert orbit["multipliers"]["modes"] == 8
        moduli = orbit["multipliers"]["moduli"]
        assert moduli == sorted(moduli, reverse=True)
        assert moduli[0] == orbit["multipliers"]["largest"]
        assert orbit["si"] is None
    assert [orbit["stable"] for orbit in first["orbits"]] == [False, True]
    states = steady_states(System(s=20.0, d=0.0048, restitution=0.6, load=Load.harmonic(0.9, 1.0)))
    assert first["level"] == states.level and phases == [orbit.phase for orbit in states.orbits]  # every digit


def test_report_for_people(percuss):
    told = "The hammer can run with one blow every load period: 180 J at 17.5 Hz"
    done = percuss("steady", "mini-breaker", "--periods", "1..2")
    done.told(told, "Motion 2 of 2: stable, possible", "nearest         load factor")
    assert "\x1b" not in done.out  # no colours into a pipe


@pytest.mark.parametrize(("command", "column"), [("steady", "margin"), ("simulate", "before [m/s]")])
def test_report_at_a_terminal(percuss, monkeypatch, command, column):
    monkeypatch.setattr(sys.stdout, "isatty", lambda: True, raising=False)
    monkeypatch.setenv("COLUMNS", "90")
    out = re.sub(r"\x1b\[[0-9;]*m", "", percuss(command, "mini-breaker").out)
    assert "Hydraulic breaker for a mini excavator" in out and column in out
    assert max(len(line) for line in out.splitlines()) <= 90


def test_no_motion_is_an_answer(percuss):
    Path("slow.toml").write_text(PLAIN.replace("0.9, 0.0", "5.0, 0.0"), encoding="utf-8")
    percuss("steady", "slow.toml").told("No steady motion", "nearest", "come to rest on the wall")


def test_a_file_goes_before_a_machine(percuss):
    Path("mini-breaker").write_text(PLAIN, encoding="utf-8")
    assert percuss("steady", "mini-breaker").out.startswith("B77 scale\n")


# -- machines, new ----------------------------------------------------------------------------------------------------


def test_machines(percuss):
    done = percuss("machines")
    done.told(*(machine.name for machine in MACHINES))
    listed = percuss("machines", "--json").json
    assert [entry["name"] for entry in listed if not entry["structure"]] == [machine.name for machine in MACHINES]
    done.told(*(entry["name"] for entry in listed if entry["structure"]))


def test_new_to_stdout(percuss, tmp_path):
    done = percuss("new", "hydraulic-drifter")
    assert done.code == 0 and "-o FILE" in done.err
    Case.from_text(done.out, folder=tmp_path)
    plain = percuss("new", "mini-breaker")
    assert plain.err == "" and percuss("new", "mini-breaker", "-o", "-").out == plain.out != ""


def test_new_then_steady(percuss):
    percuss("new", "hydraulic-drifter", "-o", "my.toml").told("wrote my.toml and drifter_pressure.csv")
    assert {"my.toml", "drifter_pressure.csv"} <= {path.name for path in Path().iterdir()}
    percuss("steady", "my.toml").told("40 cycles")
    percuss("new", "hydraulic-drifter", "-o", "second.toml").refused("drifter_pressure.csv' exists")
    assert not Path("second.toml").exists()
    assert percuss("new", "hydraulic-drifter", "-o", "second.toml", "--force").code == 0
    percuss("new", "hydraulic-drifter", "-o", "drifter_pressure.csv", "--force").refused("another name")
    made = percuss("new", "valve-breaker", "-o", "breaker.toml").out
    assert made == "wrote breaker.toml; next: percuss machine breaker.toml\n"


# -- processes ------------------------------------------------------------------------------------------------------


def test_streams_and_exit_codes(process):
    assert process("--version").stdout == f"percuss {__version__}\n"
    done = process("steady", "-", "--json", stdin=PLAIN)
    assert (done.returncode, done.stderr, json.loads(done.stdout)["case"]) == (0, "", "<stdin>")
    for words, told in ((["stedy"], "unknown command 'stedy'"), (["steady", "cas.toml"], "did you mean 'case.toml'?")):
        done = process(*words)
        assert (done.returncode, done.stdout) == (2, "") and told in done.stderr


def worked(pid):
    """Seconds of processor of a process so far; where the system does not say, those since the machine started."""
    try:
        stat = Path(f"/proc/{pid}/stat").read_text(encoding="ascii").rpartition(")")[2].split()
    except OSError:
        return time.monotonic()
    return (int(stat[11]) + int(stat[12])) / os.sysconf("SC_CLK_TCK")


def test_interrupted(tmp_path):
    (tmp_path / "case.toml").write_text(PLAIN.replace("0.9", "0.0001"), encoding="utf-8")
    arguments = [*PERCUSS, "steady", "case.toml", "--periods", "1..1000", "--modes", "4096", "--plot", "picture.png"]
    process = subprocess.Popen(arguments, cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    while worked(process.pid) < 1.5:  # it is past what it imports, where others may make another error of it, or none
        assert process.poll() is None, "it must still be at work"
        time.sleep(0.05)
    process.send_signal(signal.SIGINT)
    out, errors = process.communicate(timeout=60)
    assert (process.returncode, out, errors.strip()) == (130, "", "percuss: interrupted")
    assert not (tmp_path / "picture.png").exists()


@pytest.mark.skipif(os.name != "posix", reason="pipes break in another way")
def test_reader_that_has_seen_enough():
    read, write = os.pipe()
    os.close(read)  # whoever writes gets EPIPE
    done = subprocess.run([*PERCUSS, "machines"], stdout=write, stderr=subprocess.PIPE, text=True, check=False)
    os.close(write)
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs a full device")
def test_output_that_cannot_be_written():
    with open("/dev/full", "w", encoding="utf-8") as full:
        done = subprocess.run([*PERCUSS, "machines"], stdout=full, stderr=subprocess.PIPE, text=True, check=False)
    assert done.returncode == 1 and "cannot be written" in done.stderr and "Traceback" not in done.stderr


def test_terminal_without_greek():
    environment = {**os.environ, "PYTHONIOENCODING": "ascii"}
    done = subprocess.run([*PERCUSS, "steady", "mini-breaker"], env=environment, capture_output=True, check=False)
    assert done.returncode == 0
    done.stdout.decode("ascii")
