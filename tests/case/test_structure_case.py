"""Cases of structures that are held: the table [body], its file of modes, and all that can be wrong with them."""

import json
import math
import re

import pytest

from percuss import plot
from percuss.case import Case, branch_answer, load_case, orbits_answer, steady_answer
from percuss.cli import main
from percuss.errors import CaseError, ParameterError
from percuss.explore import sweep
from percuss.model import ModalBody, Mounted

MODES = "omega,damping,contact,drive\n# the first\n0.6,0.05,1.0,1.0\n2.3,0.1,0.8,-0.5\n"
PLAIN = """
title = "two modes"
[body]
kind = "modes"
file = "modes.csv"
gap = 0.3
[system]
restitution = 0.7
[load]
kind = "fourier"
coefficients = [[0.2, 0.0], [1.0, 0.0]]
"""
MASS = """
[body]
kind = "mounted"
mass = "2 kg"
spring = "20 kN/m"
dashpot = "15 N*s/m"
gap = "1 mm"
[contact]
restitution = 0.7
[load]
kind = "harmonic"
mean = "0 N"
amplitude = "200 N"
frequency = "25 Hz"
"""


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "modes.csv").write_text(MODES, encoding="utf-8")
    (tmp_path / "case.toml").write_text(PLAIN, encoding="utf-8")
    (tmp_path / "mass.toml").write_text(MASS, encoding="utf-8")
    return tmp_path


def test_a_file_of_modes_and_its_columns_are_the_same(folder):
    case = Case.read("case.toml")
    body = ModalBody((0.6, 2.3), (0.05, 0.1), (1.0, 0.8), (1.0, -0.5), 0.3)
    assert case.system().body == body and case.notes == ()
    lists = "omega = [2.3, 0.6]\ndamping = [0.1, 0.05]\ncontact = [0.8, 1.0]\ndrive = [-0.5, 1.0]"
    assert Case.from_text(PLAIN.replace('file = "modes.csv"', lists)).system() == case.system()
    again = Case.from_text(case.to_toml(), folder=folder)
    assert again == case and again.system() == case.system()
    assert case.varied({"body.gap": -0.1}).system().body.gap == -0.1
    (folder / "modes.csv").write_text(MODES.replace(",", ";").replace("omega;", "omega ;") + "\n", encoding="utf-8")
    assert Case.read("case.toml").system().body == body


def test_a_mass_and_a_bar_on_a_spring_in_si():
    system, omega = Case.from_text(MASS).system(), 2.0 * math.pi * 25.0
    mass = Mounted(20e3 / (2.0 * omega**2), 15.0 / (2.0 * omega), gap=1e-3)
    assert system.body.stiffness == pytest.approx(mass.stiffness) and system.body.dashpot == pytest.approx(mass.dashpot)
    assert system.body.gap == pytest.approx(1e-3) and system.force_scale == pytest.approx(2.0 * omega**2)
    (orbit,) = orbits_answer(Case.from_text(MASS), "1/1").orbits
    assert orbit.speeds[0] * system.speed_scale == pytest.approx(1.86, abs=0.01)
    bar = '[bar]\nlength = "300 mm"\ndiameter = "40 mm"\n'
    on_spring = Case.from_text(bar + MASS.replace('mass = "2 kg"\n', "")).system()
    assert on_spring.body.s > 100.0 and on_spring.length_scale == pytest.approx(0.3)
    assert on_spring.body.gap == pytest.approx(1e-3 / 0.3)
    plain = '[body]\nkind = "mounted"\nspring = 0.5\n[system]\ns = 6.0\nd = 0.01\nrestitution = 0.5\n'
    assert Case.from_text(plain + PLAIN[PLAIN.index("[load]") :]).system().body.s == 6.0


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("0.6,", "0.6x,", "line 3, column omega, not '0.6x'"),
        ("0.1,0.8", ",0.8", "line 4, column damping, not 'nothing'"),
        (",-0.5", "", "line 4, column drive"),
        ("0.8,-0.5", "0.8,nan", "line 4, column drive"),
        ("0.6,", "0,", "omega greater than 0 in line 3"),
        ("0.6,0.05", "0.6,-0.05", "damping of 0 or more in line 3"),
        ("contact,", "touch,", "one column contact"),
        (MODES[MODES.index("#") :], "", "a line for each mode"),
        ("1.0,1.0\n2.3,0.1,0.8,-0.5", "1.0,0\n2.3,0.1,0.8,0", "feels the load"),
    ],
)
def test_a_file_of_modes_that_is_none(folder, old, new, said):
    assert old in MODES
    (folder / "modes.csv").write_text(MODES.replace(old, new), encoding="utf-8")
    with pytest.raises(CaseError, match=re.escape(said)) as refused:
        Case.read("case.toml")
    assert refused.value.key.startswith("body.")


@pytest.mark.parametrize(
    ("text", "old", "new", "key"),
    [
        (PLAIN, '"modes.csv"', '"none.csv"', "body.file"),
        (PLAIN, 'file = "modes.csv"', "omega = [1.0]", "body.damping"),
        (PLAIN, 'file = "modes.csv"', 'file = "modes.csv"\nomega = [1.0]', "body.file"),
        (PLAIN, 'kind = "modes"', 'kind = "beam"', "body.kind"),
        (PLAIN, "gap = 0.3", 'gap = "1 mm"', "body.gap"),
        (PLAIN, "gap = 0.3", "spring = 1.0", "body.spring"),
        (PLAIN, "restitution = 0.7", "restitution = 0.7\ns = 5.0", "system.s"),
        (PLAIN, "restitution = 0.7", 'restitution = 0.7\nstrain = "reversed"', "system.strain"),
        (PLAIN, "restitution = 0.7", 'restitution = 0.7\nlaw = "b77-tau"', "system.law"),
        (PLAIN, "[load]", "[tool]\nimpedance = 3.0\n[load]", "tool"),
        (PLAIN, PLAIN[PLAIN.index("[body]") : PLAIN.index("[system]")], "", "system.s"),
        (MASS, 'spring = "20 kN/m"', "spring = 5.0", "body.spring"),
        (MASS, 'spring = "20 kN/m"\n', "", "body.spring"),
        (MASS, 'spring = "20 kN/m"', 'spring = "0 N/m"', "body.spring"),
        (MASS, '"15 N*s/m"', '"15 N*s/m^2"', "body.dashpot"),
        (MASS, 'mass = "2 kg"\n', "", "body.mass"),
        (MASS, "[contact]", '[bar]\nlength = "1 m"\ndiameter = "1 cm"\n[contact]', "body.mass"),
        (MASS, "[contact]\nrestitution = 0.7\n", "", "contact"),
    ],
)
def test_tables_that_do_not_go_together(folder, text, old, new, key):
    assert old in text
    with pytest.raises(CaseError) as refused:
        Case.from_text(text.replace(old, new), folder=folder)
    assert refused.value.key == key


def test_answers_of_a_structure(folder, capsys):
    case = Case.read("case.toml")
    answer = steady_answer(case, [1, 2])
    assert answer.running and answer.rest is None and len(answer.periods[0].orbits) == 2
    first = answer.to_json_dict()["periods"][0]
    assert first["gap"] == 0.3 and first["orbits"][0]["stable"] and first["orbits"][0]["reason"] is None
    assert first["orbits"][0]["phase"] == pytest.approx(0.36067474794776)
    for asked in (lambda: steady_answer(case, starts=3), lambda: case.blow_question()):
        with pytest.raises((ParameterError, CaseError), match=r"held|free"):
            asked()
    for command in ("steady case.toml", "steady mass.toml", "simulate case.toml", "simulate mass.toml"):
        assert main(command.split()) == 0
        assert "gap" in capsys.readouterr().out
    assert main(["steady", "case.toml", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["system"]["gap"] == 0.3
    assert main(["steady", "case.toml", "--starts", "3"]) == 2
    assert "percuss experiment" in capsys.readouterr().err
    assert main(["steady", "stopped-oscillator", "--reach-of", "stiffness"]) == 0
    told = capsys.readouterr().out.partition("How far")[2]
    assert "where the structure touches the wall between two impacts" in told
    assert not any(word in told for word in ("bar ", "blow", "hammer"))
    assert main(["follow", "case.toml", "--orbit", "1/1", "--along", "gap=0.2:0.4", "--json"]) == 0
    ends = [point["value"] for point in json.loads(capsys.readouterr().out.split("percuss:")[0])["points"]]
    assert sorted(ends) == [0.2, 0.4]


def test_a_map_leaves_out_what_only_free_bars_have(folder):
    system = Case.read("case.toml").system()
    found = sweep(system, "gap=0.1,0.3", workers=1)
    assert found.quantities == ("exists", "orbits", "phase", "stable", "margin")
    for name in ("reduced_stable", "reduced_margin", "rest", "stress"):
        with pytest.raises(ParameterError, match=f"quantities = '{name}'"):
            sweep(system, "gap=0.1,0.3", quantities=["exists", name], workers=1)


@pytest.mark.parametrize(("name", "unit"), [("case.toml", "dimensionless"), ("mass.toml", "mm")])
def test_the_picture_of_a_structure(folder, name, unit):
    assert main(["steady", name, "--periods", "1,2", "--plot", "structure.png"]) == 0
    assert (folder / "structure.png").stat().st_size > 5000
    answer = steady_answer(Case.read(name), [1, 2])
    load, contact, multipliers = plot.steady(answer).axes
    assert contact.get_ylabel() == f"contact from the wall [{unit}]"
    forward = [one for period in answer.periods for one in period.orbits if one.orbit.impact_velocity > 0.0]
    assert len(contact.get_lines()) == len(forward) + 1  # and the wall
    for line, one in zip(contact.get_lines(), forward, strict=False):
        assert not one.orbit.admissible or max(line.get_ydata()) < 1e-9
    assert len(load.get_lines()) == len(forward) + 2
    assert sum(len(found.get_offsets()) for found in multipliers.collections) <= sum(
        one.stability.multipliers.values.size for one in forward
    )
    assert len(plot.steady(answer.periods[0].states).axes) == 3


def test_words_of_the_samples_are_those_of_a_structure(capsys):
    assert main(["experiment", "stopped-oscillator", "--starts", "5"]) == 0
    told = capsys.readouterr().out
    assert "field" in told and "1 elastic mode\n" in told
    asked = ["--label", "1/1", "--searched", "1", "--starts", "1", "--runs", "0", "--tries", "9", "--switch", "0"]
    assert main(["diagram", "stopped-oscillator", "--along", "gap=-0.11:-0.1:2", "--yes", *asked]) == 0
    assert ", 1 mode; branches: " in capsys.readouterr().out
    assert main(["simulate", "stopped-oscillator"]) == 0
    told = capsys.readouterr().out
    assert "The structure settles on one impact every load period" in told and "; 1 mode" in told
    assert main(["orbits", "stopped-beam", "--label", "chatter/1"]) == 0
    assert "no: several modes move on while the wall holds the contact" in capsys.readouterr().out


def test_a_mode_that_chatters_is_told_of_as_a_cycle_with_rest(tmp_path, capsys):
    text = (
        PLAIN[: PLAIN.index("file")] + "omega = [3.3]\ndamping = [0.3]\ncontact = [1.0]\ndrive = [1.0]\ngap = -0.01\n"
    )
    text += PLAIN[PLAIN.index("[system]") :].replace("0.7", "0.4").replace("0.2, 0.0", "0.0, 0.0")
    (tmp_path / "rests.toml").write_text(text, encoding="utf-8")
    assert main(["orbits", str(tmp_path / "rests.toml"), "--label", "chatter/1"]) == 0
    assert "1 cycle chatter/1, 1 mode." in capsys.readouterr().out
    assert main(["simulate", str(tmp_path / "rests.toml")]) == 0
    assert "until the force of load and spring pulls it off" in capsys.readouterr().out
    two = text.replace("[3.3]", "[3.3, 7.3]").replace("[0.3]", "[0.3, 0.1]")
    two = two.replace("contact = [1.0]", "contact = [1.0, 0.8]").replace("drive = [1.0]", "drive = [1.0, -0.5]")
    (tmp_path / "rests.toml").write_text(two, encoding="utf-8")
    assert main(["orbits", str(tmp_path / "rests.toml"), "--label", "chatter/1", "--json"]) == 0
    answer = json.loads(capsys.readouterr().out)
    assert not answer["complete"] and [one["stable"] for one in answer["orbits"]] == [False, True, True]
    assert answer["orbits"][2]["multipliers"][0] == pytest.approx([-0.578555, 0.0], abs=1e-6)


def test_how_far_the_gap_may_move(capsys):
    assert main(["steady", "stopped-oscillator", "--reach-of", "gap", "--json"]) == 0
    (row,) = json.loads(capsys.readouterr().out)["reach"]
    assert row["above"]["type"] == "flip" and row["above"]["value"] == pytest.approx(-0.06857565227883914, abs=1e-11)
    assert main(["steady", "stopped-oscillator", "--reach-of", "gap,load_factor,restitution"]) == 0
    told = capsys.readouterr().out
    assert "0: down to -0.03142, where the period doubles" in told  # the mean of a load that has none may be either
    assert "0.8: down to 0; up to 1, where a mode resonates" in told
    assert not {"bar", "blow", "blows", "hammer"} & set(told.split())
    assert main(["steady", "stopped-oscillator", "--reach-of", ","]) == 2
    assert main(["follow", "stopped-oscillator", "--along", "s=1:5"]) == 2
    assert "a parameter that the case has" in capsys.readouterr().err


def test_a_load_without_a_mean_is_moved_by_its_own_scale():
    """In N as without dimensions: a parameter that is 0 does not tell by how much it should change."""
    case = load_case("stopped-beam")
    branch, plain = (branch_answer(case, "1/1", name) for name in ("load.mean", "mean"))
    assert branch.values.size < 100
    unit = branch.points[0].value / plain.points[0].value
    assert [point.value / unit for point in branch.points] == pytest.approx([p.value for p in plain.points], rel=1e-9)
