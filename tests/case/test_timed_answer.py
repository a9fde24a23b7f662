"""What `percuss steady` says of blows that take time: the numbers of the law in their units, beside B77's law."""

from __future__ import annotations

import json
import math
from typing import Any

import pytest

from percuss.blow import strike
from percuss.case import Case, SteadyAnswer, load_case, steady_answer
from percuss.case.answers.exploring.quick_answer import quick_dict
from percuss.case.answers.steady_report import steady_report, summary_of

PLAIN = """
[system]
s = {s}
d = 0.0
restitution = 0.6
law = "{law}"
[load]
kind = "harmonic"
mean = {mean}
amplitude = 1.0
"""
ROD = """
[bar]
length = "0.341 m"
diameter = "49 mm"
[load]
kind = "harmonic"
mean = "4 kN"
amplitude = "9 kN"
frequency = "60 Hz"
[contact]
receiving_area = "28.3 cm^2"
law = "b77-tau"
"""


def answered(law: str = "b77-tau", mean: float = 0.9, s: float = 20.0) -> SteadyAnswer:
    return steady_answer(Case.from_text(PLAIN.format(law=law, mean=mean, s=s)))


def lines(answer: SteadyAnswer) -> str:
    report = steady_report(answer)
    return "\n".join(
        f"{section.heading}\n" + "\n".join(f"{label}: {text}" for label, text in getattr(section, "rows", ()))
        for section in report.sections
    )


def test_the_numbers_of_the_law_in_si() -> None:
    answer = steady_answer(Case.from_text(ROD))
    bar = answer.system.bar
    assert bar is not None
    told = answer.to_json_dict()
    blow, r = told["blow"], answer.system.restitution
    transit = bar.length / bar.wave_speed
    assert blow["law"] == told["contact"]["law"] == "b77-tau"
    assert blow["effective_restitution"] == r
    assert blow["contact_duration"] == pytest.approx(2.0 * transit)
    assert blow["force_centroid"] == pytest.approx(transit)
    # the rod's face moves on by (1 − R) V/2 for two transits, with V = P_0/((1 + R) f mass)
    speed = 4000.0 / ((1.0 + r) * 60.0 * bar.mass)
    assert blow["advance_per_blow"] == pytest.approx((1.0 - r) * speed * transit)
    assert (blow["ringing_share"], blow["contacts"]) == (0.0, 1)
    assert "s later than B77's impact" in lines(answer)


def test_both_laws_stand_side_by_side() -> None:
    answer = answered()
    told = answer.to_json_dict()
    (period,) = told["periods"]
    assert period["blow"]["level"] == pytest.approx(period["level"] * (1.0 - 1.0 / (20.0 * math.pi)))
    b77 = steady_answer(Case.from_text(PLAIN.format(law="b77", mean=0.9, s=20.0))).to_json_dict()
    for orbit, alone, motion in zip(
        period["orbits"], b77["periods"][0]["orbits"], period["blow"]["orbits"], strict=True
    ):
        assert (orbit["phase_b77"], orbit["phase"]) == (alone["phase"], motion["phase"])
        assert orbit["blow_multipliers"] == motion["multipliers"]
        assert motion["phase_shift"] == pytest.approx(orbit["phase"] - orbit["phase_b77"])
        assert motion["margin"] == pytest.approx(1.0 - max(math.hypot(*pair) for pair in motion["multipliers"]))
        assert motion["margin_b77"] == alone["margin_rhythm"]
        assert {key: orbit[key] for key in alone if key != "phase"} == {
            key: value for key, value in alone.items() if key != "phase"
        }
    assert json.dumps(told, allow_nan=False)
    text = lines(answer)
    assert "b77-tau: restitution 0.6, contact 0.1 rad" in text
    assert "Motion 2 of 2: stable, possible; by b77-tau stable, possible" in text
    assert "settles to 1 % in 10 blows" in summary_of(answer).headline and "by b77-tau" in summary_of(answer).headline


def test_without_such_a_law_nothing_is_said_of_one() -> None:
    told = answered("b77").to_json_dict()
    assert "blow" not in told and "blow" not in told["periods"][0]
    assert "phase_b77" not in told["periods"][0]["orbits"][0]
    assert told["contact"]["law"] == "b77"


def test_motions_that_only_the_law_has() -> None:
    """Between the folds of the two laws, 4/π and 1/(1 − q) times that."""
    answer = answered(mean=1.005 * 4.0 / math.pi)
    (period,) = answer.periods
    assert period.timed is not None
    assert not period.orbits and len(period.timed.alone) == 2 and answer.running == ()
    told: dict[str, Any] = answer.to_json_dict()["periods"][0]
    assert [orbit["phase_b77"] for orbit in told["blow"]["orbits"]] == [None, None]
    text = lines(answer)
    assert "Of b77-tau alone" in text and "no motion of B77's law corresponds to it" in text
    assert "b77-tau: 2 steady motions" in text
    assert summary_of(answer).runs and "By b77-tau the hammer can run" in summary_of(answer).headline


def test_the_law_decides_what_runs() -> None:
    """Between the flips of the two laws."""
    answer = answered(mean=0.76)
    found = answer.periods[0].orbits[-1]
    assert found.stability.stable and found.timed is not None and not found.timed.stability.stable
    assert not found.runs and answer.running == ()
    assert "flip" in lines(answer)


def test_only_one_blow_a_period_exists() -> None:
    case = Case.from_text(PLAIN.format(law="b77-tau", mean=0.9, s=20.0))
    told = steady_answer(case, (1, 2)).to_json_dict()
    assert told["blow"]["contact_duration"] == 0.1
    assert [period["blow"]["exists"] for period in told["periods"]] == [True, False]
    assert load_case("mini-breaker").timed_law() is None


STEPPED = """
[bar]
sections = [
    {length = "140 mm", diameter = "36 mm"},
    {length = "160 mm", diameter = "52 mm"},
    {length = "150 mm", diameter = "38 mm"},
]
damping_ratio = 5e-3
[load]
kind = "harmonic"
mean = "3.3 kN"
amplitude = "8.5 kN"
frequency = "60 Hz"
[contact]
restitution = "from the blow"
law = "b77-blow"
[tool]
sections = [{diameter = "52 mm", bore = "12 mm"}]
end = "infinite"
"""


def test_the_energy_that_the_impact_takes_is_divided_between_tool_and_ringing() -> None:
    """As in one blow by waves at the same speed; together they are 1 − R² of the energy of the blow."""
    case = Case.from_text(STEPPED)
    answer = steady_answer(case)
    question = case.blow_question()
    for found in answer.periods[0].orbits:
        assert found.timed is not None
        orbit, scale = found.timed.orbit, answer.system.energy_scale
        blow = strike(question.striker, question.target, orbit.rigid_velocity * answer.system.speed_scale)
        assert orbit.delivered_energy * scale == pytest.approx(blow.work_through_face, rel=1e-9)
        assert orbit.ringing_energy * scale == pytest.approx(blow.vibration_energy_after, rel=1e-9)
        kept = answer.system.restitution**2 * orbit.blow_energy
        assert orbit.delivered_energy + orbit.ringing_energy + kept == pytest.approx(orbit.blow_energy, rel=1e-12)
    assert "218.5 J delivered to what is struck; 2.896 J ring on in the bar" in lines(answer)
    assert "ring on" not in lines(steady_answer(Case.from_text(ROD)))


BLOW = """
[system]
s = 20.0
d = 0.01
restitution = "from the blow"
law = "b77-blow"
[tool]
impedance = 4.0
[load]
kind = "harmonic"
mean = {mean}
amplitude = 1.0
"""


@pytest.mark.parametrize("mean", [0.9, 1.225])
def test_the_quick_answer_has_the_phase_of_the_force_as_the_whole_one(mean: float) -> None:
    """With 1.225 the two motions of B77's law have met already, those of the other law exist."""
    case = Case.from_text(BLOW.format(mean=mean))
    quick, whole = quick_dict(case)["orbits"], steady_answer(case).to_json_dict()["periods"][0]["orbits"]
    assert len(quick) == len(whole) == (2 if mean == 0.9 else 0)
    for one, other in zip(quick, whole, strict=True):
        for key in ("phase", "phase_b77", "blow_multipliers", "advance_per_blow"):
            assert one[key] == other[key]
        assert one["phase"] != one["phase_b77"]
        assert one["blow"][0].startswith("b77-blow: force centred at")
    alone = quick_dict(case)["blow_alone"]
    assert len(alone) == (0 if mean == 0.9 else 2)
    assert all("no motion of B77's law" in lines[0] for lines in alone)
    assert "blow" not in quick_dict(Case.from_text(PLAIN.format(s=20.0, law="b77", mean=0.9)))["orbits"][0]


def test_each_motion_has_the_advance_of_its_own_period() -> None:
    told = steady_answer(Case.from_text(BLOW.format(mean=0.3)), [1, 2]).to_json_dict()
    by_m = [[one["advance_per_blow"] for one in period["orbits"]] for period in told["periods"]]
    assert by_m[0] and by_m[1]
    assert by_m[0][0] == pytest.approx(told["blow"]["advance_per_blow"], rel=1e-12)
    assert by_m[1][0] == pytest.approx(2.0 * by_m[0][0], rel=0.02)  # the drag takes a little


def test_the_picture_shows_the_phases_of_both_laws() -> None:
    from percuss import plot

    figure = plot.steady(steady_answer(Case.from_text(BLOW.format(mean=0.9))))
    assert "◆ by b77-blow" in figure.axes[0].get_title("left")
    key = figure.axes[2].get_legend()
    assert [text.get_text() for text in key.get_texts()] == ["φ = 0.818, ◆ 0.800", "φ = 2.304, ◆ 2.321"]
    diamonds = [
        line.get_xdata()[0] for line in figure.axes[0].lines if line.get_marker() == "D" and len(line.get_xdata())
    ]
    assert diamonds == pytest.approx([0.800243, 2.321351], abs=1e-6)
    plain = plot.steady(steady_answer(Case.from_text(PLAIN.format(s=20.0, law="b77", mean=0.9))))
    assert "◆" not in plain.axes[0].get_title("left")
