"""`percuss simulate`: what it prints and writes, by a law and by waves, of machines too; how it is interrupted."""

from __future__ import annotations

import math
import re
import signal
import threading
from pathlib import Path
from types import SimpleNamespace

import pytest

from case_texts import plain_case
from cli_cases import CASES
from percuss import Start, Stop, run
from percuss.case import Case, load_case
from percuss.case.answers.simulation_answer import ENDINGS, label_sentence
from percuss.cli import long_commands, main
from percuss.cli.long_commands import JobWatch
from percuss.simulate import OUTCOMES, Trajectory


@pytest.fixture
def simulated(percuss):
    return lambda *arguments: percuss("simulate", *arguments)


# -- options and JSON -------------------------------------------------------------------------------------------------


def test_json(simulated):
    done = simulated("tables.toml", "--json")
    found, case = done.json, Case.from_text(CASES["tables"])
    same = run(case.system(), Start.rigid(-0.5, 0.0, 0.3), modes=4, stop=Stop(impacts=30, periodic=False))
    told = tuple(found[name] for name in ("outcome", "modes", "case", "label"))
    assert done.err == "" and told == ("impacts", 4, "tables.toml", same.label)
    for key in ("time", "phase", "impact_velocity", "rebound_velocity"):
        assert [event[key] for event in found["events"]] == getattr(same.events, key).tolist()  # every digit
    every, last, none = (
        simulated("tables.toml", "--json", "--events", which).json for which in ("all", "last:2", "none")
    )
    assert every == found and last == {**every, "events": every["events"][-2:]} and none == {**every, "events": []}
    nothing = simulated("case.toml", "--impacts", "0", "--json").json
    assert (nothing["events"], nothing["summary"]["blow_rate"]) == ([], None)


def test_options_go_before_tables(simulated):
    found = simulated("tables.toml", "--json", "--impacts", "7", "--modes", "2").json
    assert (found["summary"]["impacts"], found["modes"], found["begin_time"]) == (7, 2, 0.3)
    other = simulated("tables.toml", "--json", "--start", "velocity=1,time=0.5").json
    assert (other["begin_time"], other["modes"]) == (0.5, 4)
    assert other["events"] != simulated("tables.toml", "--json").json["events"]


def test_time_in_radians_and_seconds(simulated):
    found = simulated("case.toml", "--json", "--time", "5.5", "--full", "--modes", "0").json
    assert (found["outcome"], found["end_time"]) == ("time", 5.5)
    system = load_case("mini-breaker").system()
    found = simulated("mini-breaker", "--json", "--time", "0.2 s", "--full", "--modes", "0").json
    assert found["end_time"] == pytest.approx(0.2 * system.angular_frequency, rel=1e-14)


def test_full_goes_on_after_a_cycle(simulated):
    asked = ("case.toml", "--start", "orbit:2", "--modes", "8", "--json")
    short, full = simulated(*asked).json, simulated(*asked, "--impacts", "20", "--full").json
    assert (short["outcome"], short["label"], short["summary"]["impacts"]) == ("periodic", "z=1/1", 3)
    assert (full["outcome"], full["label"], full["summary"]["impacts"]) == ("impacts", "z=1/1", 20)


# -- the report -------------------------------------------------------------------------------------------------------


def test_report(simulated):
    done = simulated("mini-breaker")
    assert done.err == "" and "\x1b" not in done
    done.told("The hammer settles on one blow every load period (z=1/1): 180 J at 17.5 Hz")
    done.told("ended           a periodic motion is found (periodic)", "Events (last 10 of")
    assert len(re.findall(r"^  impact ", done.out, re.MULTILINE)) == 10
    done = simulated("mini-breaker", "--start", "position=-20 mm,velocity=2 m/s,time=1 ms", "--impacts", "3")
    done.told("striking end at -20 mm with velocity 2 m/s")


def test_report_of_chosen_events(simulated):
    assert len(re.findall(r"^  impact ", simulated("tables.toml", "--events", "last:3").out, re.MULTILINE)) == 3
    assert "Events" not in simulated("tables.toml", "--events", "none")
    assert "Events (all" in simulated("tables.toml", "--events", "all")
    nothing = simulated("case.toml", "--time", "0.1")
    nothing.told("none: the bar never strikes", "simulate for longer")
    assert "Events" not in nothing


@pytest.mark.parametrize(
    ("label", "free", "words"),
    [
        ("z=1/1", True, "one blow every load period"),
        ("z=2/3", True, "2 blows in 3 load periods"),
        ("chatter/1", True, "a cycle of one load period: it chatters to rest"),
        ("rest/4", True, "a cycle of 4 load periods: it comes to rest on the wall, until the load pulls it off"),
        ("rest", True, "stays there"),
        ("rest", False, "stays there"),
        ("departed", True, "leaves the wall for good"),
        ("aperiodic", True, "no rhythm"),
        ("undecided", True, "so far"),
    ],
)
def test_labels_in_words(label, free, words):
    system = SimpleNamespace(body=SimpleNamespace(is_free=free))
    assert words in label_sentence(SimpleNamespace(label=label, period_unresolved=False, system=system, modes=2))


def test_every_outcome_has_words():
    assert {*ENDINGS, "stalls"} == set(OUTCOMES)  # a valve stalls, a clock does not


# -- files ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("asked", "more", "part", "whole"),
    [(("tables.toml",), (), "11", "30"), (("valve-drifter", "--modes", "2"), ("--full",), "9", "30")],
)
def test_saved_and_resumed_bit_for_bit(simulated, asked, more, part, whole):
    pytest.importorskip("h5netcdf")
    all_of_it = simulated(*asked, *more, "--impacts", whole, "--json").json
    done = simulated(*asked, *more, "--impacts", part, "-o", "part.nc", "--plot", "part.png", "--json")
    assert done.err == "motion: part.nc\npicture: part.png\n" and Path("part.png").read_bytes()[:4] == b"\x89PNG"
    again = simulated("--resume", "part.nc", "--impacts", whole, "--json", "-o", "part.nc").json  # onto itself
    assert all(again[name] == all_of_it[name] for name in ("events", "label", "outcome"))
    assert Trajectory.load("part.nc").impacts == int(whole)


def test_a_motion_of_a_machine_goes_on(simulated):
    pytest.importorskip("h5netcdf")
    assert simulated("valve-drifter", "--modes", "0", "--full", "--impacts", "9", "-o", "part.nc").code == 0
    done = simulated("--resume", "part.nc", "--time", "1 s", "--plot", "on.svg")
    done.told("From this start the machine", "picture: on.svg")
    simulated("--resume", "part.nc", "--impacts", "5").refused("more than the 9 that the file holds")
    simulated("--resume", "part.nc", "--time", "1 ms").refused("more than the")


# -- machines that switch their own valve -----------------------------------------------------------------------------


def test_a_machine_is_followed_from_its_start(simulated):
    """From rest 39 mm behind the tool; blows of an independent program."""
    found = simulated("valve-breaker", "--modes", "0", "--impacts", "3", "--json").json
    blows = [event for event in found["events"] if event["kind"] == "impact"]
    assert [event["time_s"] for event in blows] == pytest.approx([0.120, 0.227, 0.333], abs=1e-3)
    assert [event["speed"] for event in blows] == pytest.approx([8.78, 9.18, 9.19], abs=6e-3)
    kinds = [(event["kind"], event["to"]) for event in found["events"] if event["kind"] in ("port", "valve")]
    assert kinds[:4] == [("port", "return"), ("valve", "power"), ("port", "power"), ("valve", "return")]
    assert found["outcome"] == "impacts" and found["cycle"] is None


# -- by waves ---------------------------------------------------------------------------------------------------------

FAR = "[start]\nposition = -3.0\n"
BY_WAVES = ("--contact", "waves", "--cells")


@pytest.fixture
def far(tmp_path):
    (tmp_path / "far.toml").write_text(plain_case("d = 0.01") + FAR, encoding="utf-8")


def test_the_motion_by_waves_beside_the_law(simulated, far):
    done = simulated("far.toml", *BY_WAVES, "100")
    done.told("By waves the hammer settles on one blow every load period (z=1/1); by the law b77: z=1/1.")
    done.told("an endless rod of 4 times the impedance", "Beside the laws", "+0.018")
    found = simulated("far.toml", *BY_WAVES, "100", "--events", "last:2", "--json").json
    assert (found["label"], found["outcome"], len(found["impacts"])) == ("z=1/1", "periodic", 2)
    assert found["settled"]["restitutions"] == [pytest.approx(0.6, abs=1e-4)]
    law = found["beside"][0]
    assert law["label"] == "z=1/1"
    assert found["settled"]["phases"][0] - law["phases"][0] == pytest.approx(law["phase_difference"], abs=1e-9)
    assert law["phase_difference"] == pytest.approx(0.0184, abs=1e-4)
    assert found["energy"]["error"] < 1e-11 and found["uncertainty"]["phase"] < 1e-5
    assert found["settled"]["si"] is None


def test_a_hammer_in_si_has_its_figures(simulated):
    found = simulated("heavy-drifter", *BY_WAVES, "100", "--events", "none", "--json").json
    assert found["settled"]["si"]["blow_rate_Hz"] == pytest.approx(42.0)
    assert 5.0 < found["settled"]["si"]["velocities_m_s"][0] < 15.0
    assert found["impacts"] == []


def test_a_tool_on_rock_is_fed_and_the_rock_keeps_a_part(simulated):
    found = simulated("mini-breaker", *BY_WAVES, "32", "--impacts", "60", "--full", "--json").json
    assert found["outcome"] == "impacts"
    si = found["settled"]["si"]
    assert 0.0 < si["rock_work_J"][0] < si["given_J"][0]
    assert 0.0 < found["settled"]["rock_power"] < found["settled"]["delivered_power"]
    assert 1e-5 < si["fed_m"][0] < 1e-2
    done = simulated("mini-breaker", *BY_WAVES, "32", "--impacts", "5", "--full")
    done.told("a rod on rock, which is fed by what each blow leaves of the penetration", "the rock keeps")


def test_the_tool_of_the_case_and_the_law_that_knows_the_blow(simulated):
    timed = plain_case("d = 0.01").replace("restitution = 0.6\n", 'restitution = "from the blow"\nlaw = "b77-blow"\n')
    Path("timed.toml").write_text(f"{timed}{FAR}[tool]\nimpedance = 4.0\n", encoding="utf-8")
    beside = simulated("timed.toml", *BY_WAVES, "100", "--json").json["beside"]
    assert (beside[0]["law"], beside[-1]["law"]) == ("b77", "b77-blow, steady")
    assert abs(beside[-1]["phase_difference"]) < 3e-3


# -- waiting and interrupting -----------------------------------------------------------------------------------------

ENDLESS = ("case.toml", "--modes", "0", "--start", "orbit:2", "--impacts", "1000000000", "--full")


def interrupting(monkeypatch, times):
    """Ctrl-C, so many times, while the second stretch is looked at."""
    calls = []
    look = JobWatch.share

    def call(self, *progress):
        calls.append(progress)
        for _ in range(times if len(calls) == 2 else 0):
            signal.raise_signal(signal.SIGINT)
        return look(self, *progress)

    monkeypatch.setattr(JobWatch, "share", call)


def test_interrupted_keeps_what_is_done(simulated, monkeypatch):
    pytest.importorskip("h5netcdf")
    interrupting(monkeypatch, 1)
    before = signal.getsignal(signal.SIGINT)
    done = simulated(*ENDLESS, "--json", "--events", "last:1", "-o", "part.nc")
    assert done.code == 130 and done.json["outcome"] == "interrupted"
    assert signal.getsignal(signal.SIGINT) is before
    assert any("interrupted" in warning for warning in done.json["warnings"])
    saved = Trajectory.load("part.nc")
    assert saved.impacts == done.json["summary"]["impacts"] > 0
    assert saved.continued(Stop(impacts=saved.impacts + 5, periodic=False)).impacts == saved.impacts + 5


def test_interrupted_twice_ends_at_once(simulated, monkeypatch):
    interrupting(monkeypatch, 2)
    before = signal.getsignal(signal.SIGINT)
    done = simulated(*ENDLESS, "-o", "part.nc")
    assert (done.code, done.out, done.err.strip()) == (130, "", "percuss: interrupted")
    assert signal.getsignal(signal.SIGINT) is before
    assert not Path("part.nc").exists()


def test_an_end_at_once_is_told_to_whoever_listened_before():
    """A compiler makes another error of it, and the command must know better."""
    heard, before = [], signal.getsignal(signal.SIGINT)
    signal.signal(signal.SIGINT, lambda which, _: heard.append(which))
    try:
        with pytest.raises(KeyboardInterrupt), long_commands.watching(SimpleNamespace(command="simulate")):
            signal.raise_signal(signal.SIGINT)  # nothing has begun that would be kept
    finally:
        signal.signal(signal.SIGINT, before)
    assert heard == [signal.SIGINT]


def test_while_kernels_are_compiled_ctrl_c_ends_at_once():
    """However patient the watch is: nobody asks it until they are there."""

    def compile_extra():
        with pytest.raises(KeyboardInterrupt):
            watch.interrupt()

    watch = JobWatch("simulate", patience=math.inf)
    with pytest.raises(KeyboardInterrupt):  # what has not begun has nothing to keep
        watch.interrupt()
    assert not watch.share(0.0, "begun")
    watch.interrupt()
    assert watch.interrupted
    watch = JobWatch("simulate", patience=math.inf)
    assert not watch.share(0.0, "begun")
    code = compile_extra.__code__.replace(co_filename=str(Path(long_commands.__file__).parents[1] / "compiled.py"))
    type(compile_extra)(code, globals(), closure=compile_extra.__closure__)()


def test_a_bar_for_a_person_who_waits(monkeypatch, capsys):
    """And a line now and then in a file of messages."""
    unseen = JobWatch("simulate")
    assert unseen.share(0.25, "5 impacts") is False
    assert capsys.readouterr() == ("", "")
    monkeypatch.setattr("sys.stderr.isatty", lambda: True, raising=False)
    monkeypatch.setenv("FORCE_COLOR", "1")
    hasty = JobWatch("simulate")
    hasty.share(0.25, "5 impacts")
    assert hasty._bar is None  # a short one needs none
    monkeypatch.setattr(long_commands, "PATIENCE", -1.0)
    seen = JobWatch("simulate")
    seen.share(0.25, "5 impacts")
    assert seen._bar.tasks[0].completed == 0.25
    seen.close()
    captured = capsys.readouterr()
    assert captured.out == "" and "simulate" in captured.err and "25 %, 5 impacts" in captured.err


def test_another_thread_may_simulate():
    codes = []
    thread = threading.Thread(target=lambda: codes.append(main(["simulate", "mini-breaker", "--impacts", "2"])))
    thread.start()
    thread.join()
    assert codes == [0]
