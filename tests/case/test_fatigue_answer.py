"""`percuss blow --fatigue`: the table [steel], what governs, hours by the rate of its own cycle, refusals."""

from __future__ import annotations

import json

import pytest

from percuss.blow import Steel, fatigue
from percuss.case import Case, blow_answer, load_case
from percuss.case.answers.blows.blow_answer import blow_report
from percuss.case.answers.machine_answer import machine_answer
from percuss.errors import CaseError

BAR = '[bar]\nlength = "0.5 m"\narea = "10 cm^2"\n'
TOOL = '[tool]\nsections = [{length = "1.5 m", area = "10 cm^2"}]\nend = "free"\n'
TOOL += '[blow]\nvelocity = "20 m/s"\nuntil = "1.158 ms"\n'


def case_of(steel: str) -> Case:
    return Case.from_text(BAR + TOOL + steel, file="case.toml")


def test_the_table_says_what_the_steel_bears() -> None:
    given = case_of(
        '[steel]\nultimate = "1 GPa"\nfatigue_limit = "380 MPa"\nslope = 7\nknee = 2e6\nnotch = {"rod 0" = 1.5}\n'
        '[steel.tool]\ngrade = "34CrNiMo6 QT"\n'
    )
    found = given.steel()
    assert found.steel == Steel(1e9, 380e6, 7.0, 2e6) and found.tool == Steel(1e9)
    assert (found.name, found.tool_name, found.notches) == ("of the case", "34CrNiMo6 QT", {"rod 0": 1.5})
    assert Case.from_text(given.to_toml()).steel() == found
    assert case_of("").steel().steel == case_of('[steel]\ngrade = "42CrMo4 QT"').steel().steel == Steel(900e6)
    told = blow_answer(given, fatigue=True).fatigue
    assert told is not None
    wanted = fatigue(blow_answer(given).blow, found.steel, found.tool, notches={"rod 0": 1.5})
    assert [one.fatigue.damage for one in told.sections] == [one.damage for one in wanted.sections]


def test_without_a_cycle_of_its_own_a_life_is_a_number_of_blows() -> None:
    answer = blow_answer(case_of(""), fatigue=True)
    assert answer.fatigue is not None
    worst = answer.fatigue.governing
    assert (worst.rate, worst.hours) == (None, None)
    first = blow_report(answer).summary
    assert first.startswith("Governs: rod 0, ") and f"{worst.fatigue.blows:.2g} blows to failure. A blow of " in first


@pytest.mark.parametrize("name", ["stepped-drifter", "valve-drifter", "fed"])
def test_hours_are_blows_over_the_rate_of_the_hammers_own_cycle(name: str) -> None:
    """Under a clock, of a valve, on a pump: the rate is what `percuss steady` and `percuss machine` say."""
    case = load_case("valve-breaker" if name == "fed" else name)
    if name == "fed":
        case = case.varied({"load.supply": {"flow": "150 l/min", "accumulator": "2.5 cm^3/bar"}})
    soft = case.varied({"steel.ultimate": "500 MPa"})
    if name == "stepped-drifter":  # thousands of pieces: a short window has the first pass
        soft, rate = soft.varied({"blow.until": "0.8 ms"}), 50.0
    else:
        machine = machine_answer(case)
        cycle = machine.motion.cycle
        assert cycle is not None
        rate = cycle.blows / cycle.period / machine.machine.time_scale
    answer = blow_answer(soft, fatigue=True)
    assert answer.fatigue is not None
    assert answer.fatigue.rate == pytest.approx(rate, rel=1e-9)
    worst = answer.fatigue.governing
    assert worst.fatigue.blows is not None and worst.hours == pytest.approx(worst.fatigue.blows / rate / 3600.0)
    told = json.loads(json.dumps(answer.to_json_dict()))["fatigue"]
    assert (told["governs"], told["hours"]) == (worst.fatigue.name, worst.hours)
    assert [one["section"] for one in told["sections"]][:1] == ["striker 0"]


@pytest.mark.parametrize(
    ("steel", "said"),
    [
        (
            'fatigue_limit = "950 MPa"',
            "steel.fatigue_limit = '950 MPa': expected an amplitude below the tensile strength",
        ),
        ("slope = -2", "steel.slope = -2.0: expected a number of at least 1"),
        ('notch = {"rod 1" = 2}', "steel.notch = 'rod 1': expected sections that there are: striker 0, rod 0"),
        ('notch = {"rod 0" = 0.5}', "steel.notch = 0.5: expected factors of at least 1"),
        ("notch = 2", "steel.notch = 2: expected a table of factors by section"),
        ('grade = "42CrMo4 QT"\nultimate = "1 GPa"', "steel.ultimate = '1 GPa': expected either a grade or a tensile"),
        ('grade = "42CrMo4"', "did you mean '42CrMo4 QT'?"),
        ("tool = {slope = 0}", "steel.tool.slope = 0"),
    ],
)
def test_a_steel_that_there_is_not_is_refused_with_its_key(steel: str, said: str) -> None:
    with pytest.raises(CaseError) as caught:
        case_of(f"[steel]\n{steel}")
    assert said in str(caught.value)
