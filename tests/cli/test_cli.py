"""The command line: what is printed where, exit codes, every kind of bad input; and the same of real processes."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from case_texts import PLAIN
from percuss.case import MACHINES, Case
from percuss.cli import main
from percuss.cli.arguments import periods

PERCUSS = [sys.executable, "-m", "percuss"]

Run = Callable[..., subprocess.CompletedProcess[str]]


@pytest.fixture
def run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Run:
    """The command in this process, in a folder with `case.toml`."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "case.toml").write_text(PLAIN, encoding="utf-8")

    def call(*arguments: str) -> subprocess.CompletedProcess[str]:
        try:
            code = main(arguments)
        except SystemExit as ended:  # --help
            code = int(ended.code or 0)
        return subprocess.CompletedProcess(arguments, code, *capsys.readouterr())

    return call


@pytest.fixture
def process(tmp_path: Path) -> Run:
    """The command as a process of its own: its streams and its exit code are real."""

    def call(*arguments: str, stdin: str = "") -> subprocess.CompletedProcess[str]:
        done = subprocess.run(
            [*PERCUSS, *arguments],
            cwd=tmp_path,
            input=stdin,
            capture_output=True,
            text=True,
            encoding="utf-8",
            timeout=120,
        )
        assert "Traceback" not in done.stderr
        return done

    (tmp_path / "case.toml").write_text(PLAIN, encoding="utf-8")
    return call


def refused(done: subprocess.CompletedProcess[str], *parts: str) -> None:
    assert done.returncode == 2, done
    assert done.stdout == ""
    assert all(part in done.stderr for part in parts), done.stderr


# -- help -----------------------------------------------------------------------------------------------------------


def test_version(process: Run) -> None:
    from percuss import __version__

    assert process("--version").stdout == f"percuss {__version__}\n"


@pytest.mark.parametrize("arguments", [[], ["--help"], ["-h"], ["help"]])
def test_help(run: Run, arguments: list[str]) -> None:
    done = run(*arguments)
    assert done.returncode == 0
    for word in ("steady", "simulate", "machines", "new", "examples:"):
        assert word in done.stdout


@pytest.mark.parametrize("command", ["steady", "simulate", "machines", "new"])
def test_help_of_a_command(run: Run, command: str) -> None:
    done = run(command, "--help")
    assert done.returncode == 0
    assert "examples:" in done.stdout
    assert run("help", command).stdout == done.stdout


def examples() -> list[str]:
    import percuss.cli.machines
    import percuss.cli.new
    import percuss.cli.simulate
    import percuss.cli.steady
    from percuss.cli.app import _HELP

    texts = [_HELP.split("examples:")[1].split("'percuss COMMAND")[0]]
    cli = percuss.cli
    texts += [module._EXAMPLES for module in (cli.steady, cli.simulate, cli.machines, cli.new)]
    return [line.strip() for text in texts for line in text.splitlines() if line.strip()]


@pytest.mark.slow
def test_every_example_of_the_help_runs(run: Run, tmp_path: Path) -> None:
    done: set[str] = set()
    for line in examples():
        assert line.startswith("percuss ")
        words = line.split(" > ")[0].split()[1:]
        if words[0] == "new" and "-o" in words:
            words.append("--force")  # two of the examples write the same file
        if line not in done:
            assert run(*words).returncode == 0, line
        done.add(line)
    assert (tmp_path / "drifter_pressure.csv").exists()
    assert (tmp_path / "breaker.png").stat().st_size > 5000
    assert len(done) >= 14


def test_help_loads_nothing_heavy() -> None:
    code = (
        "import sys\nfrom percuss.cli import main\n"
        "for words in (['--help'], ['--version'], ['steady', '--help'], ['machines'], ['new', 'mini-breaker']):\n"
        "    try:\n        main(words)\n    except SystemExit:\n        pass\n"
        "heavy = {'numpy', 'pydantic', 'rich', 'matplotlib', 'pint', 'scipy', 'numba'} & set(sys.modules)\n"
        "sys.exit(', '.join(heavy) or 0)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


# -- steady ---------------------------------------------------------------------------------------------------------

ORBIT_KEYS = [
    "phase", "impact_velocity", "modes", "admissible", "violation", "stable", "reason", "margin", "reduced",
    "multipliers", "energy", "si",
]  # fmt: skip
SI_KEYS = [
    "impact_velocity_m_s", "blow_energy_J", "delivered_energy_J", "blow_rate_Hz", "percussive_power_kW",
    "input_power_kW", "efficiency", "stroke_mm", "peak_stress_MPa", "contact_time_us", "mean_force_kN", "momentum_N_s",
]  # fmt: skip


def has(wanted: list[str], found: dict[str, Any]) -> bool:
    return set(wanted) <= found.keys()


def test_json_of_a_plain_case(process: Run) -> None:
    done = process("steady", "case.toml", "--json", "--periods", "1,3", "--modes", "8")
    assert done.returncode == 0
    assert done.stderr == ""
    found = json.loads(done.stdout, parse_constant=lambda name: pytest.fail(f"{name} in JSON"))
    assert has(["case", "system", "periods", "rest"], found)
    assert found["case"] == "case.toml"
    assert has(["s", "d", "restitution", "coefficients"], found["system"])
    assert found["system"]["coefficients"] == [[0.9, 0.0], [1.0, 0.0]]
    assert [period["m"] for period in found["periods"]] == [1, 3]
    first, third = found["periods"]
    assert has(["m", "level", "level_max", "exists", "orbits"], first)
    assert first["exists"] is True
    assert first["level"] < first["level_max"]
    assert third["exists"] is False
    assert third["orbits"] == []
    assert set(third["nearest"]) == {"load_factor", "restitution", "d"}
    phases = [orbit["phase"] for orbit in first["orbits"]]
    assert phases == sorted(phases)
    for orbit in first["orbits"]:
        assert has(ORBIT_KEYS, orbit)
        assert has(["sigma", "a", "schur", "moduli", "stable"], orbit["reduced"])
        assert (len(orbit["reduced"]["a"]), len(orbit["reduced"]["schur"]), len(orbit["reduced"]["moduli"])) == (
            3,
            2,
            2,
        )
        assert has(["modes", "largest", "moduli"], orbit["multipliers"])
        assert orbit["multipliers"]["modes"] == 8
        moduli = orbit["multipliers"]["moduli"]
        assert moduli == sorted(moduli, reverse=True)
        assert moduli[0] == orbit["multipliers"]["largest"]
        assert has(["input", "damping", "impact", "imbalance"], orbit["energy"])
        assert orbit["si"] is None
    assert [orbit["stable"] for orbit in first["orbits"]] == [False, True]
    assert has(["possible", "least_contact_force"], found["rest"])
    assert found["history"] is None


def test_json_of_a_machine(run: Run) -> None:
    found = json.loads(run("steady", "hydraulic-drifter", "--json").stdout)
    stable = [orbit for orbit in found["periods"][0]["orbits"] if orbit["stable"] and orbit["admissible"]]
    assert len(stable) == 1
    assert has(SI_KEYS, stable[0]["si"])
    assert stable[0]["si"]["blow_energy_J"] == pytest.approx(310.0, rel=0.02)
    assert found["history"]["cycles"] == 40
    assert found["periods"][0]["nearest"] is None


def test_json_keeps_every_digit(run: Run) -> None:
    from percuss import Load, System, steady_states

    found = json.loads(run("steady", "case.toml", "--json").stdout)
    states = steady_states(System(s=20.0, d=0.0048, restitution=0.6, load=Load.harmonic(0.9, 1.0)))
    assert found["periods"][0]["level"] == states.level
    assert [orbit["phase"] for orbit in found["periods"][0]["orbits"]] == [orbit.phase for orbit in states.orbits]


def test_report_for_people(process: Run) -> None:
    done = process("steady", "mini-breaker", "--periods", "1..2")
    assert done.returncode == 0
    assert "\x1b" not in done.stdout  # no colours into a pipe
    for part in (
        "The hammer can run with one blow every load period: 180 J at 17.5 Hz",
        "Orbit 2 of 2, m = 1: stable, possible",
        "a stable blow of a rigid, undamped bar needs a force between",
        "(m = 2)",
        "nearest         load factor",
        "a mean force of",
        "closes to",
        "At rest on the wall",
    ):
        assert part in done.stdout, part


def test_no_motion_is_an_answer(run: Run, tmp_path: Path) -> None:
    (tmp_path / "slow.toml").write_text(PLAIN.replace("0.9, 0.0", "5.0, 0.0"), encoding="utf-8")
    done = run("steady", "slow.toml")
    assert done.returncode == 0
    assert "No steady motion" in done.stdout
    assert "nearest" in done.stdout
    assert "come to rest on the wall" in done.stdout


def test_case_from_standard_input(process: Run) -> None:
    done = process("steady", "-", "--json", stdin=PLAIN)
    assert done.returncode == 0
    assert json.loads(done.stdout)["case"] == "<stdin>"


def test_a_file_goes_before_a_machine(run: Run, tmp_path: Path) -> None:
    (tmp_path / "mini-breaker").write_text(PLAIN, encoding="utf-8")
    assert run("steady", "mini-breaker").stdout.startswith("B77 scale\n")


def test_plot(process: Run, tmp_path: Path) -> None:
    done = process("steady", "case.toml", "--json", "--plot", "picture.svg")
    assert done.returncode == 0
    json.loads(done.stdout)  # nothing but JSON on stdout
    assert "picture.svg" in done.stderr
    assert (tmp_path / "picture.svg").stat().st_size > 5000


@pytest.mark.parametrize(
    ("arguments", "parts"),
    [
        (["stedy"], ["unknown command 'stedy'", "did you mean 'steady'?"]),
        (["case.toml"], ["unknown command", "percuss steady case.toml"]),
        (["--versoin"], ["unknown option '--versoin'", "did you mean '--version'?"]),
        (["steady"], ["CASE", "usage: percuss steady"]),
        (["steady", "case.toml", "--jsn"], ["unknown option '--jsn'", "did you mean '--json'?"]),
        (["steady", "case.toml", "--period", "2"], ["unknown option '--period'", "did you mean '--periods'?"]),
        (["steady", "case.toml", "other.toml"], ["one argument too many: 'other.toml'"]),
        (["steady", "case.toml", "--periods", "0"], ["--periods", "between 1 and 1000"]),
        (["steady", "case.toml", "--periods", "-1"], ["--periods"]),
        (["steady", "case.toml", "--periods", "3..1"], ["--periods", "smaller number first"]),
        (["steady", "case.toml", "--periods", "1..1000000"], ["--periods", "between 1 and 1000"]),
        (["steady", "case.toml", "--periods", "one"], ["--periods", "2, 1..4 or 1,3"]),
        (["steady", "case.toml", "--modes", "-1"], ["--modes"]),
        (["steady", "case.toml", "--modes", "1.5"], ["--modes", "whole number"]),
        (["steady", "case.toml", "--modes", "99999"], ["--modes", "4096"]),
        *(
            (["steady", "case.toml", "--starts", wrong], [f"'{wrong}'", "from 0 to 1000 ('percuss experiment' follows"])
            for wrong in ("-1", "1.5", "nan", "1001", "1000000001", "")
        ),
        *(
            (["sweep", "case.toml", "--x", "restitution=0:0.5:3", "--csv", wrong], ["--csv", f"'{wrong}'", "in .csv"])
            for wrong in ("", "x.txt", "csv")
        ),
        (["steady", "case.toml", "--plot", "picture.gif"], ["picture.gif", ".png, .svg or .pdf"]),
        (["steady", "case.toml", "--plot", "nowhere/picture.png"], ["there is no folder 'nowhere'"]),
        (["steady", "cas.toml"], ["cas.toml: no such file", "did you mean 'case.toml'?"]),
        (["steady", "mini-braker"], ["mini-braker", "did you mean 'mini-breaker'?"]),
        (["steady", "."], [".: is a directory", "case.toml"]),
        (["steady", ""], ["no such file"]),
        (["machines", "all"], ["one argument too many: 'all'"]),
        (["new"], ["MACHINE"]),
        (["new", "drifter"], ["no machine of this name", "did you mean 'valve-drifter'?"]),
        (["new", "mini-breaker", "-o", "."], ["is a directory"]),
        (["new", "mini-breaker", "-o", "nowhere/case.toml"], ["there is no folder 'nowhere'"]),
        (["new", "mini-breaker", "-o", "case.toml"], ["'case.toml' exists", "--force"]),
    ],
)
def test_wrong_arguments(run: Run, tmp_path: Path, arguments: list[str], parts: list[str]) -> None:
    before = sorted(tmp_path.iterdir())
    refused(run(*arguments), *parts)
    assert sorted(tmp_path.iterdir()) == before  # nothing written
    assert (tmp_path / "case.toml").read_text(encoding="utf-8") == PLAIN


def test_a_wrong_argument_of_a_process(process: Run) -> None:
    refused(process("stedy"), "unknown command 'stedy'")
    refused(process("steady", "cas.toml"), "did you mean 'case.toml'?")


@pytest.mark.parametrize(
    ("old", "new", "parts"),
    [
        ("restitution", "restitusion", ["case.toml: system.restitusion = 0.6", "did you mean 'restitution'?"]),
        ("d = 0.0048\n", "", ["case.toml: system.d: missing"]),
        ("s = 20.0", "s = -1.0", ["case.toml: system.s = -1.0"]),
        ("s = 20.0", "s = nan", ["case.toml: system.s = nan", "finite"]),
        ("0.6", "1.6", ["case.toml: system.restitution = 1.6", "0 to 1"]),
        ("0.9, 0.0", "-0.9, 0.0", ["case.toml: the load does not push", "p_0"]),
        ("0.9, 0.0", "0.0, 0.0", ["case.toml: the load does not push"]),
        (", [1.0, 0.0]", "", ["case.toml: the load is constant"]),
        ("s = 20.0\nd = 0.0048", "s = 0.15915494309189535\nd = 0.0", ["case.toml: load harmonic k = 1", "n = 2"]),
        ("s = 20.0", "s = 1e300", ["case.toml: system.s"]),
    ],
)
def test_wrong_cases(run: Run, tmp_path: Path, old: str, new: str, parts: list[str]) -> None:
    assert old in PLAIN
    (tmp_path / "case.toml").write_text(PLAIN.replace(old, new, 1), encoding="utf-8")
    refused(run("steady", "case.toml", "--plot", "picture.png", "--json"), *parts)
    assert not (tmp_path / "picture.png").exists()


def test_large_and_binary_files(run: Run, tmp_path: Path) -> None:
    with (tmp_path / "large.toml").open("wb") as file:
        file.truncate(200_000_000)
    refused(run("steady", "large.toml"), "too large")
    (tmp_path / "binary.toml").write_bytes(bytes(range(256)))
    refused(run("steady", "binary.toml"), "binary")


# -- machines and new -----------------------------------------------------------------------------------------------


def test_machines(run: Run) -> None:
    done = run("machines")
    assert done.returncode == 0
    assert all(machine.name in done.stdout for machine in MACHINES)
    listed = json.loads(run("machines", "--json").stdout)
    assert [entry["name"] for entry in listed if not entry["structure"]] == [machine.name for machine in MACHINES]
    assert all(entry["name"] in done.stdout for entry in listed if entry["structure"])


def test_new_to_stdout(run: Run, tmp_path: Path) -> None:
    done = run("new", "hydraulic-drifter")
    assert done.returncode == 0
    assert "-o FILE" in done.stderr
    Case.from_text(done.stdout, folder=tmp_path)
    assert run("new", "mini-breaker").stderr == ""


def test_new_then_steady(run: Run, tmp_path: Path) -> None:
    done = run("new", "hydraulic-drifter", "-o", "my.toml")
    assert done.returncode == 0, done.stderr
    assert {"my.toml", "drifter_pressure.csv"} <= {path.name for path in tmp_path.iterdir()}
    report = run("steady", "my.toml")
    assert report.returncode == 0
    assert "40 cycles" in report.stdout
    refused(run("new", "hydraulic-drifter", "-o", "other.toml"), "drifter_pressure.csv' exists")
    assert not (tmp_path / "other.toml").exists()
    assert run("new", "hydraulic-drifter", "-o", "other.toml", "--force").returncode == 0
    refused(run("new", "hydraulic-drifter", "-o", "drifter_pressure.csv", "--force"), "another name")


def test_new_structure(run: Run, tmp_path: Path) -> None:
    assert run("new", "stopped-beam", "-o", "beam.toml").returncode == 0
    assert "possible" in run("steady", "beam.toml").stdout
    (tmp_path / "beam_modes.csv").unlink()
    assert "beam_modes.csv" in run("steady", "beam.toml").stderr


# -- interruptions --------------------------------------------------------------------------------------------------


def test_interrupted(tmp_path: Path) -> None:
    (tmp_path / "case.toml").write_text(PLAIN.replace("0.9", "0.0001"), encoding="utf-8")
    arguments = [*PERCUSS, "steady", "case.toml", "--periods", "1..1000", "--modes", "4096", "--plot", "picture.png"]
    process = subprocess.Popen(arguments, cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    time.sleep(2.0)
    assert process.poll() is None, "it must still be at work"
    process.send_signal(signal.SIGINT)
    out, errors = process.communicate(timeout=60)
    assert process.returncode == 130
    assert out == ""
    assert errors.strip() == "percuss: interrupted"
    assert not (tmp_path / "picture.png").exists()


@pytest.mark.skipif(os.name != "posix", reason="pipes break in another way")
def test_reader_that_has_seen_enough() -> None:
    read, write = os.pipe()
    os.close(read)  # whoever writes gets EPIPE
    done = subprocess.run([*PERCUSS, "machines"], stdout=write, stderr=subprocess.PIPE, text=True)
    os.close(write)
    assert done.returncode == 0
    assert done.stderr == ""


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs a full device")
def test_output_that_cannot_be_written() -> None:
    with open("/dev/full", "w", encoding="utf-8") as full:
        done = subprocess.run([*PERCUSS, "machines"], stdout=full, stderr=subprocess.PIPE, text=True)
    assert done.returncode == 1
    assert "cannot be written" in done.stderr
    assert "Traceback" not in done.stderr


def test_terminal_without_greek(tmp_path: Path) -> None:
    environment = {**os.environ, "PYTHONIOENCODING": "ascii"}
    done = subprocess.run([*PERCUSS, "steady", "mini-breaker"], env=environment, capture_output=True)
    assert done.returncode == 0
    done.stdout.decode("ascii")


# -- in process -----------------------------------------------------------------------------------------------------


def test_main_returns_codes(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--version"]) == 0
    assert main(["nothing"]) == 2
    assert "unknown command" in capsys.readouterr().err


def test_report_at_a_terminal(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setattr(sys.stdout, "isatty", lambda: True, raising=False)
    monkeypatch.setenv("COLUMNS", "90")
    assert main(["steady", "mini-breaker"]) == 0
    out = re.sub(r"\x1b\[[0-9;]*m", "", capsys.readouterr().out)
    assert "Hydraulic breaker for a mini excavator" in out
    assert max(len(line) for line in out.splitlines()) <= 90


@pytest.mark.parametrize(
    ("text", "found"),
    [("1", (1,)), ("1..3", (1, 2, 3)), ("3,1", (1, 3)), ("1..2,2,5..6", (1, 2, 5, 6)), ("2-4", (2, 3, 4))],
)
def test_periods(text: str, found: tuple[int, ...]) -> None:
    assert periods(text) == found


MADE = {
    "machine": "-o --plot", "simulate": "-o --plot", "steady": "--plot --report", "blow": "-o --csv --plot",
    "follow": "-o --plot", "sweep": "-o --csv --plot", "experiment": "-o --plot", "basins": "-o --plot",
    "diagram": "-o --csv --netcdf --plot", "export": "-o", "paper": "-o",
}  # fmt: skip


@pytest.mark.parametrize("command", MADE)
def test_standard_output_is_no_file_to_be_made(run: Run, command: str) -> None:
    """Alike for all commands: it has the report; nothing is computed before."""
    needed = {"sweep": ["--x", "restitution=0:1:3"], "follow": ["--along", "mean=0:1"], "paper": []}
    needed |= {"basins": ["--x", "position=-1:0:3", "--y", "velocity=0:1:3"], "diagram": ["--along", "mean=0:1"]}
    for option in MADE[command].split():
        case = [] if command == "paper" else ["mini-breaker"]
        told = "standard output has the report; give the name of a file"
        refused(run(command, *case, *needed.get(command, []), option, "-"), told)


def test_new_prints_to_standard_output(run: Run) -> None:
    assert run("new", "mini-breaker", "-o", "-").stdout == run("new", "mini-breaker").stdout != ""
