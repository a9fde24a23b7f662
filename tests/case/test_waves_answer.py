"""What a case says of its machine by waves: what is struck, where it starts and when it ends; the answer with laws."""

import math

import pytest

from percuss.blow import Rod, Wall
from percuss.blow.periods.wave_motion import rigid_state
from percuss.case import Case, load_case, waves_answer
from percuss.case.answers.blows.waves_answer import stop_of, struck_by, waves_report
from percuss.simulate import Stop

PLAIN = """
[system]
s = 20.0
d = 0.01
restitution = {restitution}
{system}
[load]
kind = "harmonic"
mean = 0.9
amplitude = 1.0
{more}
"""


def case_of(restitution="0.6", system="", more=""):
    return Case.from_text(PLAIN.format(restitution=restitution, system=system, more=more))


def case_of_steel(more):
    return Case.from_text(f"""
[bar]
length = "0.3 m"
area = "16 cm^2"
[contact]
restitution = 0.1
[load]
kind = "harmonic"
frequency = "80 Hz"
mean = "6 kN"
amplitude = "16 kN"
{more}
""")


def test_without_a_tool_the_rod_gives_a_uniform_bar_its_restitution():
    target, pushed_back, note = struck_by(case_of())
    assert isinstance(target, Rod)
    assert target.impedance == pytest.approx(80.0)
    assert not pushed_back
    assert "4 times" in note
    wall = struck_by(case_of("1.0"))
    assert wall.target == Wall()
    assert wall.note == ""


def test_the_tool_of_a_case_is_struck_and_pushed_back_as_it_says():
    found = struck_by(case_of(system='law = "b77-tau"\nadvance = "pushed back"', more="[tool]\nimpedance = 3.0"))
    assert found.target.impedance == pytest.approx(60.0)
    assert found.pushed_back
    assert found.note == ""


def test_a_tool_on_rock_is_fed_and_one_with_a_free_end_pushed_back():
    case = load_case("hydraulic-drifter")
    assert struck_by(case)[:2] == (case.tool(), False)
    assert struck_by(case).note.startswith("no feed")
    assert case.tool().end == "rock"
    free = struck_by(case_of_steel('[tool]\nsections = [{length = "1 m", area = "20 cm^2"}]\nend = "free"'))
    assert free.target.end == "free"
    assert free.pushed_back


def test_starts_become_rigid_ones():
    case = case_of(more="[start]\nposition = -3.0\nvelocity = 0.5\ntime = 1.0")
    assert rigid_state(case.start(), case.system()) == (3.0, 0.5, 1.0)
    case = case_of(more="[start]\norbit = 2")
    gap, velocity, _ = rigid_state(case.start(), case.system())
    assert gap == pytest.approx(0.0, abs=1e-9)
    assert velocity == pytest.approx(-0.6 * 0.9 * math.tau / 1.6, rel=0.05)


def test_limits_are_those_of_the_simulation():
    assert stop_of(case_of()) == Stop(2000, 200 * math.tau, tolerance=1e-6)
    found = stop_of(case_of(more="[simulation]\ntime = 40.0\nimpacts = 7\nperiodic = false\ntolerance = 1e-4"))
    assert found == Stop(impacts=7, time=40.0, periodic=False, tolerance=1e-4)


def test_the_motion_of_a_steady_start_stays_beside_the_law():
    answer = waves_answer(case_of(more="[start]\norbit = 2\n[simulation]\nmodes = 4"), cells=50)
    assert answer.motion.label == answer.law.label == "z=1/1"
    assert answer.beside[0].phase_difference == pytest.approx(0.0184, abs=2e-4)
    assert abs(answer.beside[0].velocity_difference) < 0.01
    assert answer.warnings == ()


def test_who_wants_no_more_gets_what_there_is():
    answer = waves_answer(case_of(), lambda progress: True, cells=50)
    assert answer.motion.outcome == "interrupted"
    assert any("interrupted" in warning for warning in answer.warnings)
    assert answer.to_json_dict()["outcome"] == "interrupted"


def test_an_undamped_piston_of_sections_is_told_of_its_ringing():
    case = Case.from_text("""
[system]
s = 40.0
impedances = [1.2566, 1.9635, 0.9503]
transit_times = [0.0731, 0.2187, 0.1493]
restitution = "from the blow"
law = "b77-blow"
[tool]
impedance = 4.0
[load]
kind = "harmonic"
mean = 0.66
amplitude = 1.0
[start]
position = 0.0
velocity = -1.2
time = 2.11
[simulation]
time = 200.0
modes = 0
""")
    answer = waves_answer(case, cells=50)
    assert answer.motion.label == "irregular"
    assert any("ringing" in warning for warning in answer.warnings)


def test_an_answer_says_when_the_blows_have_another_restitution_than_the_law():
    """On a rod of three times the impedance (3 − 1)/(3 + 1), less 0.01 as the load pushes meanwhile."""
    told = "the blows have R = 0.49 (median), the law beside them 0.6"
    answer = waves_answer(case_of(more="[tool]\nimpedance = 3.0\n[start]\nposition = -3.0"), cells=30)
    assert any(told in warning for warning in answer.warnings)
    answer = waves_answer(case_of(more="[tool]\nimpedance = 4.0\n[start]\nposition = -3.0"), cells=30)
    assert not any("the blows have R" in warning for warning in answer.warnings)


def test_a_feed_and_a_damper_give_the_drifter_a_rhythm_and_say_whether_blows_may_be_taken_one_by_one():
    more = {"feed.force": "4 kN", "feed.damping": "40 kN s/m", "tool.sections[0].attenuation": "0.01 1/m"}
    answer = waves_answer(load_case("hydraulic-drifter").varied(more), quiet=True, cells=40)
    motion = answer.motion
    assert motion.label == "z=1/1"
    assert motion.settled.restitution[0] == pytest.approx(0.142, abs=2e-3)
    settled = answer.to_json_dict()["settled"]
    assert settled["rhythm"] == [1.0, 0.0]
    assert settled["left_bound"] < 0.05
    assert settled["stands"] == [1.0]
    report = waves_report(answer, 0)
    rows = dict(next(section.rows for section in report.sections if section.heading == "Motion by waves"))
    assert rows["bit"] == "on the rock at every blow"
    assert "may be taken one by one" in rows["one by one"]
    assert "recoil damper" in rows["struck"]
