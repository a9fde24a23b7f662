"""`percuss simulate`: what it prints and writes, how it is interrupted, and every kind of bad input."""

from __future__ import annotations

import importlib.util
import json
import math
import re
import signal
import subprocess
import sys
import threading
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from case_texts import PLAIN
from percuss import Start, Stop, run
from percuss.case import Case, load_case
from percuss.case.answers.simulation_answer import label_in_words
from percuss.cli import main, simulate
from percuss.cli import simulation_progress as watch
from percuss.cli.arguments import events, start_keys, time_or_text, whole
from percuss.simulate import Trajectory

TABLES = """
[start]
position = -0.5
time = 0.3
[simulation]
modes = 4
impacts = 30
periodic = false
"""


class Done(SimpleNamespace):
    code: int
    out: str
    err: str

    @property
    def json(self) -> Any:
        return json.loads(self.out, parse_constant=lambda name: pytest.fail(f"{name} in JSON"))


@pytest.fixture
def percuss(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Any:
    """The command in this process, which has the kernels, in a folder with `case.toml`."""
    monkeypatch.chdir(tmp_path)
    Path("case.toml").write_text(PLAIN, encoding="utf-8")
    Path("tables.toml").write_text(PLAIN + TABLES, encoding="utf-8")

    def call(*arguments: str) -> Done:
        code = main(["simulate", *arguments])
        captured = capsys.readouterr()
        return Done(code=code, out=captured.out, err=captured.err)

    return call


# -- JSON -----------------------------------------------------------------------------------------------------------


def test_json(percuss: Any) -> None:
    done = percuss("tables.toml", "--json")
    assert (done.code, done.err) == (0, "")
    found = done.json
    case = Case.from_text(PLAIN + TABLES)
    same = run(case.system(), Start.rigid(-0.5, 0.0, 0.3), modes=4, stop=Stop(impacts=30, periodic=False))
    assert (found["outcome"], found["modes"], found["case"], found["label"]) == (
        "impacts",
        4,
        "tables.toml",
        same.label,
    )
    for key in ("time", "phase", "impact_velocity", "rebound_velocity"):
        assert [event[key] for event in found["events"]] == getattr(same.events, key).tolist()  # every digit


def test_json_with_the_last_events_only(percuss: Any) -> None:
    every = percuss("tables.toml", "--json", "--events", "all").json
    last = percuss("tables.toml", "--json", "--events", "last:2").json
    assert last == {**every, "events": every["events"][-2:]}
    assert percuss("tables.toml", "--json", "--events", "none").json == {**every, "events": []}


def test_nothing_happens_and_json_is_still_valid(percuss: Any) -> None:
    found = percuss("case.toml", "--impacts", "0", "--json").json
    assert (found["events"], found["summary"]["blow_rate"]) == ([], None)


# -- options --------------------------------------------------------------------------------------------------------


def test_options_go_before_tables(percuss: Any) -> None:
    found = percuss("tables.toml", "--json", "--impacts", "7", "--modes", "2").json
    assert (found["summary"]["impacts"], found["modes"], found["begin_time"]) == (7, 2, 0.3)
    other = percuss("tables.toml", "--json", "--start", "velocity=1,time=0.5").json
    assert (other["begin_time"], other["modes"]) == (0.5, 4)
    assert other["events"] != percuss("tables.toml", "--json").json["events"]


def test_time_in_radians_and_seconds(percuss: Any) -> None:
    found = percuss("case.toml", "--json", "--time", "5.5", "--full", "--modes", "0").json
    assert (found["outcome"], found["end_time"]) == ("time", 5.5)
    system = load_case("mini-breaker").system()
    found = percuss("mini-breaker", "--json", "--time", "0.2 s", "--full", "--modes", "0").json
    assert found["end_time"] == pytest.approx(0.2 * system.angular_frequency, rel=1e-14)


def test_si_start(percuss: Any) -> None:
    done = percuss("mini-breaker", "--start", "position=-20 mm,velocity=2 m/s,time=1 ms", "--impacts", "3")
    assert done.code == 0
    assert "striking end at -20 mm with velocity 2 m/s" in done.out


def test_full_goes_on_after_a_cycle(percuss: Any) -> None:
    short = percuss("case.toml", "--start", "orbit:2", "--modes", "8", "--json").json
    assert (short["outcome"], short["label"], short["summary"]["impacts"]) == ("periodic", "z=1/1", 3)
    full = percuss("case.toml", "--start", "orbit:2", "--modes", "8", "--impacts", "20", "--full", "--json").json
    assert (full["outcome"], full["label"], full["summary"]["impacts"]) == ("impacts", "z=1/1", 20)


def test_random_start_of_a_seed(percuss: Any) -> None:
    first = percuss("case.toml", "--start", "random", "--seed", "5", "--json", "--impacts", "3").json
    assert percuss("case.toml", "--start", "random", "--seed", "5", "--json", "--impacts", "3").json == first
    assert percuss("case.toml", "--start", "random", "--seed", "6", "--json", "--impacts", "3").json != first


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
def test_start_keys(text: str, found: dict[str, Any]) -> None:
    assert start_keys(text) == found


def test_other_values() -> None:
    assert (whole("0"), whole("1000000000")) == (0, 10**9)
    assert (time_or_text("2"), time_or_text("2 s")) == (2.0, "2 s")
    assert (events("all"), events("last:7"), events("none")) == ((None,), (7,), (0,))


# -- the report -----------------------------------------------------------------------------------------------------


def test_report(percuss: Any) -> None:
    done = percuss("mini-breaker")
    assert (done.code, done.err) == (0, "")
    assert "\x1b" not in done.out
    assert "The hammer settles on one blow every load period (z=1/1): 180 J at 17.5 Hz" in done.out
    assert "ended           a periodic motion is found (periodic)" in done.out and "Events (last 10 of" in done.out
    assert len(re.findall(r"^  impact ", done.out, re.MULTILINE)) == 10


def test_report_of_chosen_events(percuss: Any) -> None:
    assert len(re.findall(r"^  impact ", percuss("tables.toml", "--events", "last:3").out, re.MULTILINE)) == 3
    assert "Events" not in percuss("tables.toml", "--events", "none").out
    assert "Events (all" in percuss("tables.toml", "--events", "all").out


def test_report_of_nothing(percuss: Any) -> None:
    out = percuss("case.toml", "--time", "0.1").out
    assert "none: the bar never strikes" in out
    assert "simulate for longer" in out
    assert "Events" not in out


def test_report_at_a_terminal(percuss: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys.stdout, "isatty", lambda: True, raising=False)
    monkeypatch.setenv("COLUMNS", "90")
    out = re.sub(r"\x1b\[[0-9;]*m", "", percuss("mini-breaker").out)
    assert "Hydraulic breaker for a mini excavator" in out
    assert "before [m/s]" in out
    assert max(len(line) for line in out.splitlines()) <= 90


@pytest.mark.parametrize(
    ("label", "free", "words"),
    [
        ("z=1/1", True, "one blow every load period"),
        ("z=2/3", True, "2 blows in 3 load periods"),
        ("chatter/1", True, "a cycle of one load period: it chatters to rest"),
        ("rest/4", True, "a cycle of 4 load periods: it comes to rest on the wall, until the load pulls it off"),
        ("rest", True, "stays there"),
        ("rest", False, "are not simulated"),
        ("departed", True, "leaves the wall for good"),
        ("aperiodic", True, "no rhythm"),
        ("undecided", True, "so far"),
    ],
)
def test_labels_in_words(label: str, free: bool, words: str) -> None:
    system = SimpleNamespace(body=SimpleNamespace(is_free=free))
    motion = SimpleNamespace(label=label, period_unresolved=False, system=system, modes=2)
    assert words in label_in_words(motion)  # type: ignore[arg-type]


# -- files ----------------------------------------------------------------------------------------------------------


def test_saved_and_resumed_bit_for_bit(percuss: Any) -> None:
    pytest.importorskip("h5netcdf")
    whole_run = percuss("tables.toml", "--json").json
    done = percuss("tables.toml", "--impacts", "11", "-o", "part.nc", "--json")
    assert done.err == "motion: part.nc\n"
    done = percuss("--resume", "part.nc", "--impacts", "30", "--json", "-o", "part.nc")  # onto itself
    assert done.code == 0
    assert done.json["events"] == whole_run["events"]
    assert done.json["summary"] == whole_run["summary"]
    assert Trajectory.load("part.nc").impacts == 30
    assert "run" not in percuss("--resume", "part.nc").err


def test_plot(percuss: Any) -> None:
    pytest.importorskip("matplotlib")
    done = percuss("tables.toml", "--plot", "picture.png")
    assert done.out.endswith("picture: picture.png\n")
    assert Path("picture.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(
    ("arguments", "parts"),
    [
        ([], ["CASE (or --resume FILE)", "usage: percuss simulate"]),
        (["cas.toml"], ["no such file", "did you mean 'case.toml'?"]),
        (["case.toml", "--modus", "3"], ["unknown option '--modus'", "did you mean '--modes'?"]),
        (["case.toml", "--impacts", "-1"], ["--impacts", "whole number from 0"]),
        (["case.toml", "--impacts", "1e3"], ["--impacts", "whole number"]),
        (["case.toml", "--time", "0"], ["argument --time: 0", "greater than 0"]),
        (["case.toml", "--time", "nan"], ["--time", "finite"]),
        (["case.toml", "--time", "2 s"], ["argument --time: '2 s'", "only a case in SI takes units"]),
        (["mini-breaker", "--time", "2 kg"], ["argument --time: '2 kg'", "unit of mass"]),
        (["case.toml", "--modes", "5000"], ["--modes", "4096"]),
        (["case.toml", "--start", "nowhere"], ["--start", "key=value pairs, orbit:K or random"]),
        (["case.toml", "--start", "time=1,time=2"], ["--start", "time is given twice"]),
        (["case.toml", "--start", "positon=-1"], ["argument --start: positon", "did you mean 'position'?"]),
        (["case.toml", "--start", "position=1"], ["argument --start: position = 1", "0 (on the wall) or less"]),
        (["case.toml", "--start", "position=-3 cm"], ["position = '-3 cm'", "only a case in SI takes units"]),
        (["case.toml", "--start", "position=-1,modal_velocity=[0]"], ["one kind of start", "remove modal_velocity"]),
        (
            ["case.toml", "--start", "orbit:9"],
            ["start.orbit = 9", "from 1 to 2", "percuss steady case.toml"],
        ),
        (["case.toml", "--seed", "1"], ["argument --start: seed = 1", "random"]),
        (["case.toml", "--events", "3"], ["--events", "all, none or last:K"]),
        (["case.toml", "-o", "nowhere/run.nc"], ["-o", "there is no folder 'nowhere'"]),
        (["case.toml", "-o", "."], ["-o", "is a directory"]),
        (["case.toml", "-o", "case.toml"], ["-o", "is the case itself"]),
        (["case.toml", "-o", "a.png", "--plot", "a.png"], ["--plot", "different names"]),
        (["case.toml", "--plot", "picture.gif"], ["picture.gif", ".png, .svg or .pdf"]),
        (["case.toml", "--resume", "run.nc"], ["CASE cannot be used with --resume"]),
        (["--resume", "run.nc", "--start", "random"], ["--start cannot be used with --resume"]),
        (["--resume", "run.nc", "--modes", "3"], ["--modes cannot be used with --resume"]),
        (["--resume", "none.nc"], ["none.nc: no such file"]),
        (["--resume", "case.toml"], ["case.toml: not a NetCDF 4 file"]),
        (["--resume", "none.nc", "--time", "2 s"], ["none.nc: no such file"]),
    ],
)
def test_wrong_arguments(percuss: Any, arguments: list[str], parts: list[str]) -> None:
    before = sorted(Path.cwd().iterdir())
    done = percuss(*arguments)
    assert (done.code, done.out) == (2, "")
    assert all(part in done.err for part in parts), done.err
    assert sorted(Path.cwd().iterdir()) == before
    assert Path("case.toml").read_text(encoding="utf-8") == PLAIN


@pytest.mark.parametrize("package", ["xarray", "h5netcdf"])
def test_a_missing_extra_is_said_before_anything_is_computed(
    percuss: Any, monkeypatch: pytest.MonkeyPatch, package: str
) -> None:
    found = importlib.util.find_spec
    monkeypatch.setattr(importlib.util, "find_spec", lambda name, *a: None if name == package else found(name, *a))
    monkeypatch.setattr(simulate, "_answered", lambda *_: pytest.fail("computed"))
    done = percuss("case.toml", "-o", "run.nc")
    assert done.code == 2
    assert f"'{package}'" in done.err
    assert "percuss[io]" in done.err


# -- waiting and interrupting ---------------------------------------------------------------------------------------

ENDLESS = ("case.toml", "--modes", "0", "--start", "orbit:2", "--impacts", "1000000000", "--full")


def interrupting(monkeypatch: pytest.MonkeyPatch, times: int) -> None:
    """Ctrl-C, so many times, while the second stretch is looked at."""
    calls = []
    look = watch.SimulationWatch.__call__

    def call(self: watch.SimulationWatch, progress: Any) -> bool:
        calls.append(progress)
        for _ in range(times if len(calls) == 2 else 0):
            signal.raise_signal(signal.SIGINT)
        return look(self, progress)

    monkeypatch.setattr(watch.SimulationWatch, "__call__", call)


def test_interrupted_keeps_what_is_done(percuss: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("h5netcdf")
    interrupting(monkeypatch, 1)
    before = signal.getsignal(signal.SIGINT)
    done = percuss(*ENDLESS, "--json", "--events", "last:1", "-o", "part.nc")
    assert done.code == 130
    assert signal.getsignal(signal.SIGINT) is before
    assert done.json["outcome"] == "cancelled"
    assert any("interrupted" in warning for warning in done.json["warnings"])
    saved = Trajectory.load("part.nc")
    assert saved.impacts == done.json["summary"]["impacts"] > 0
    assert saved.continued(Stop(impacts=saved.impacts + 5, periodic=False)).impacts == saved.impacts + 5


def test_interrupted_twice_ends_at_once(percuss: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    interrupting(monkeypatch, 2)
    before = signal.getsignal(signal.SIGINT)
    done = percuss(*ENDLESS, "-o", "part.nc")
    assert (done.code, done.out) == (130, "")
    assert done.err.strip() == "percuss: interrupted"
    assert signal.getsignal(signal.SIGINT) is before
    assert not Path("part.nc").exists()


def test_a_bar_for_a_person_who_waits(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setattr(watch, "PATIENCE", -1.0)
    monkeypatch.setenv("FORCE_COLOR", "1")
    progress: Any = SimpleNamespace(impacts=5, time=1.0, fraction=0.25)
    unseen = watch.SimulationWatch(seen=False)
    assert unseen(progress) is False
    unseen.close()
    assert capsys.readouterr() == ("", "")
    seen = watch.SimulationWatch(seen=True)
    seen(progress)
    assert seen._bar.tasks[0].completed == 0.25
    seen.close()
    captured = capsys.readouterr()
    assert captured.out == ""
    assert "simulating" in captured.err


def test_no_bar_for_a_short_simulation(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(watch, "PATIENCE", math.inf)
    seen = watch.SimulationWatch(seen=True)
    seen(SimpleNamespace(impacts=5, time=1.0, fraction=0.25))  # type: ignore[arg-type]
    assert seen._bar is None


def test_another_thread_may_simulate() -> None:
    codes = []
    thread = threading.Thread(target=lambda: codes.append(main(["simulate", "mini-breaker", "--impacts", "2"])))
    thread.start()
    thread.join()
    assert codes == [0]


def test_help_loads_no_compiler() -> None:
    code = (
        "import sys\nfrom percuss.cli import main\nmain(['--help'])\n"
        "try:\n    main(['simulate', '--help'])\nexcept SystemExit:\n    pass\n"
        "sys.exit(', '.join({'numba', 'numpy', 'pydantic', 'rich', 'matplotlib'} & set(sys.modules)) or 0)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert "percuss simulate" in done.stdout


def test_every_outcome_has_words():
    from percuss.case.answers.simulation_answer import ENDINGS
    from percuss.simulate import OUTCOMES

    assert {*ENDINGS, "stalls"} == set(OUTCOMES)  # a valve stalls, a clock does not
