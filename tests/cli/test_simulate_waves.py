"""``percuss simulate --contact waves`` as a person uses it: the report, JSON, refusals."""

import json

import pytest

from percuss.cli import main

CASE = """
[system]
s = 20.0
d = 0.01
restitution = 0.6
[load]
kind = "harmonic"
mean = 0.9
amplitude = 1.0
[start]
position = -3.0
"""


@pytest.fixture
def case(tmp_path):
    path = tmp_path / "case.toml"
    path.write_text(CASE, encoding="utf-8")
    return str(path)


def answer(capsys, *arguments):
    assert main(["simulate", *arguments, "--contact", "waves", "--json"]) == 0
    return json.loads(capsys.readouterr().out)


def test_the_report_has_the_motion_beside_the_law(case, capsys):
    assert main(["simulate", case, "--contact", "waves", "--cells", "100"]) == 0
    text = capsys.readouterr().out
    assert "By waves the hammer settles on one blow every load period (z=1/1); by the law b77: z=1/1." in text
    assert "an endless rod of 4 times the impedance" in text
    assert "Beside the laws" in text
    assert "+0.018" in text


def test_json_tells_phases_and_differences(case, capsys):
    found = answer(capsys, case, "--cells", "100", "--events", "last:2")
    assert found["label"] == "z=1/1"
    assert found["outcome"] == "periodic"
    assert found["settled"]["restitutions"] == [pytest.approx(0.6, abs=1e-4)]
    law = found["beside"][0]
    assert law["label"] == "z=1/1"
    assert found["settled"]["phases"][0] - law["phases"][0] == pytest.approx(law["phase_difference"], abs=1e-9)
    assert law["phase_difference"] == pytest.approx(0.0184, abs=1e-4)
    assert len(found["impacts"]) == 2
    assert found["energy"]["error"] < 1e-11
    assert found["settled"]["si"] is None
    assert found["uncertainty"]["phase"] < 1e-5


def test_a_machine_in_si_has_its_figures(capsys):
    found = answer(capsys, "heavy-drifter", "--cells", "100", "--events", "none")
    assert found["settled"]["si"]["blow_rate_Hz"] == pytest.approx(42.0)
    assert 5.0 < found["settled"]["si"]["velocities_m_s"][0] < 15.0
    assert found["impacts"] == []


def test_a_tool_on_rock_is_fed_and_the_rock_keeps_a_part(capsys):
    found = answer(capsys, "mini-breaker", "--cells", "32", "--impacts", "60", "--full")
    assert found["outcome"] == "impacts"
    si = found["settled"]["si"]
    assert 0.0 < si["rock_work_J"][0] < si["given_J"][0]
    assert 0.0 < found["settled"]["rock_power"] < found["settled"]["delivered_power"]
    assert 1e-5 < si["fed_m"][0] < 1e-2
    assert main(["simulate", "mini-breaker", "--contact", "waves", "--cells", "32", "--impacts", "5", "--full"]) == 0
    text = capsys.readouterr().out
    assert "a rod on rock, which is fed by what each blow leaves of the penetration" in text
    assert "the rock keeps" in text


def test_the_tool_of_the_case_and_the_law_that_knows_the_blow(tmp_path, capsys):
    path = tmp_path / "timed.toml"
    path.write_text(
        CASE.replace("restitution = 0.6\n", 'restitution = "from the blow"\nlaw = "b77-blow"\n')
        + "[tool]\nimpedance = 4.0\n",
        encoding="utf-8",
    )
    found = answer(capsys, str(path), "--cells", "100")
    names = [one["law"] for one in found["beside"]]
    assert names[0] == "b77"
    assert names[-1] == "b77-blow, steady"
    assert abs(found["beside"][-1]["phase_difference"]) < 3e-3


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--modes", "8", "--contact", "waves"], "--modes cannot be used with --contact waves"),
        (["-o", "x.nc", "--contact", "waves"], "--output cannot be used with --contact waves"),
        (["--cells", "200"], "--cells is for --contact waves"),
        (["--quiet"], "--quiet is for --contact waves"),
        (["--cells", "3", "--contact", "waves"], "give 16 or more"),
        (["--contact", "wave"], "invalid choice"),
    ],
)
def test_options_that_do_not_go_together_are_refused(case, capsys, options, said):
    assert main(["simulate", case, *options]) == 2
    assert said in capsys.readouterr().err
