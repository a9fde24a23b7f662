"""Where the energy of a cycle goes: it closes for every hammer, and the blow is that of the cycle itself."""

from __future__ import annotations

import numpy as np
import pytest

from percuss.blow import strike
from percuss.case import Case, load_case, machine_answer, steady_answer
from percuss.case.answers.blows.transfer import Transfer
from percuss.case.answers.exploring.exploration import sweep_job_of
from percuss.case.answers.machine_answer import machine_report
from percuss.case.answers.steady_report import steady_report
from percuss.case.case import case_of, json_tables
from percuss.explore.family import Axis
from percuss.explore.sweeps import Sweep

PUMP = {"load.supply": {"flow": "133 l/min", "accumulator": "2.5 cm^3/bar"}}
PLAIN = """
[system]
s = 20.0
d = 0.05
restitution = 0.3
strain = "reversed"
[tool]
impedance = 50.0
[load]
kind = "harmonic"
mean = 0.5
amplitude = 1.0
"""


def struck(name: str, tool: dict[str, object]) -> Case:
    """The machine without its rock, on another tool."""
    return case_of(
        {key: table for key, table in json_tables(load_case(name)).items() if key != "rock"} | {"tool": tool}
    )


def found(case: Case, modes: int | None = None) -> Transfer:
    answer = machine_answer(case, modes) if case.is_machine else steady_answer(case, modes=modes)
    assert answer.transfer is not None
    return answer.transfer


@pytest.mark.parametrize(
    ("name", "values", "modes"),
    [
        ("stepped-drifter", {}, None),
        ("hydraulic-drifter", {"contact.restitution": "from the blow"}, None),
        ("dth-4-inch", {}, None),
        ("pile-hammer", {}, None),
        ("valve-drifter", {}, 0),
        ("valve-drifter", {"contact.restitution": "from the blow"}, 8),
        ("valve-breaker", PUMP, 0),
        ("valve-breaker", PUMP, 4),
        ("plain", {}, None),
    ],
)
def test_the_energy_of_a_cycle_closes(name: str, values: dict[str, object], modes: int | None) -> None:
    """Input, cycle and waves are three computations of their own: they meet within 1e-9 of the input."""
    one = found(Case.from_text(PLAIN) if name == "plain" else load_case(name).varied(values), modes)
    told = one.blow
    parts = (one.drag_loss, one.ringing_before, one.rebound_difference, told.vibration_energy_after)
    assert sum(parts) + one.steel_energy + told.rock_work == pytest.approx(one.input, rel=1e-9)
    assert one.imbalance < 1e-9
    assert told.mean_velocity_before == pytest.approx(
        one.motion.rigid_velocity * (one.motion.system.speed_scale if one.motion.system.is_si else 1.0), rel=1e-12
    )
    if values.get("contact.restitution") == "from the blow":
        assert abs(one.rebound_difference) < 1e-9 * one.input


def test_the_blow_is_that_of_the_cycle_and_not_of_the_table() -> None:
    """Pressure up by half: energies rise as much, and the speed in [blow] plays no part."""
    case = load_case("valve-drifter").varied({"blow.velocity": "3 m/s"})
    one = found(case, 0)
    question = case.blow_question()
    again = strike(question.striker, question.target, one.blow.mean_velocity_before)
    assert one.rock_energy == again.rock_work and one.blow.mean_velocity_before > 10.0
    told = machine_answer(case, 0).to_json_dict()["transfer"]
    assert told["rock_power"] == pytest.approx(again.rock_work / one.period, rel=1e-13)
    assert told["overall_efficiency"] == pytest.approx(told["rock_power"] / told["input_power"], rel=1e-13)
    peak = max(again.peaks[0].compression, again.peaks[0].tension)
    assert told["peak_of_bar"]["stress"] == peak and told["peak_of_bar"]["section"] == 0


@pytest.mark.parametrize(
    ("name", "axis", "modes"),
    [
        ("valve-drifter", "load.pressure=150 bar,190 bar", 0),
        ("stepped-drifter", "rock.stiffness=300 kN/mm,500 kN/mm", None),
        ("stepped-drifter", "restitution=0.1,0.2", None),
        ("hydraulic-drifter", "m=1,2", None),
    ],
)
def test_a_cell_is_the_answer_of_its_own_hammer(name: str, axis: str, modes: int | None) -> None:
    case = load_case(name)
    job = sweep_job_of(case, [Axis.parsed(axis)], ["rock_power", "overall_efficiency"], modes=modes)
    cells = Sweep.shaped(job, job.compute(0, job.size, lambda: False))
    key, _, texts = axis.partition("=")
    for i, text in enumerate(texts.split(",")):
        if key == "m":  # there is no motion with m = 2
            one = steady_answer(case, [int(text)]).transfer
            assert (one is None) == (text == "2") == bool(np.isnan(cells["rock_power"][i]))
        else:
            one = found(case.varied({f"contact.{key}": float(text)} if key == "restitution" else {key: text}), modes)
        assert not cells["outcome"][i]
        if one is None:
            continue
        assert cells["rock_power"][i] == pytest.approx(one.rock_power, rel=1e-9)
        assert cells["overall_efficiency"][i] == pytest.approx(one.overall_efficiency, rel=1e-6)


def test_what_is_said_of_it() -> None:
    text = str(steady_report(steady_answer(load_case("stepped-drifter"))))
    assert "8.821 kW reach the rock, 60.3 % of the input." in text
    assert "nothing holds against the rock (no feed)" in text and "so much more rebounds by waves" in text
    endless = machine_answer(struck("valve-drifter", {"sections": [{"diameter": "60 mm"}]}), 0)
    told = str(machine_report(endless))
    assert "Into the tool" in told and "gone down the endless rod" in told and "reach the rock" not in told
    assert endless.to_json_dict()["transfer"]["rock_power"] is None


def test_a_hammer_of_any_lengths_has_its_transfer() -> None:
    """Beside the catalogue's, whose waves are in few pieces: nearly its figures, with R from the same blow."""
    own, lengths = load_case("stepped-drifter"), {"bar.sections[2].length": "130.01 mm"}
    exact, near = found(own), found(own.varied(lengths))
    told = steady_answer(own.varied(lengths)).to_json_dict()["transfer"]
    assert (exact.blow.fineness.name, told["fineness"]) == ("EXACT", "smoothed")
    assert near.rock_energy == pytest.approx(exact.rock_energy, rel=5e-4) and near.imbalance < 5e-4
    assert near.blow.effective_restitution == pytest.approx(exact.blow.effective_restitution or 0.0, abs=5e-4)
    for one, other in zip(near.peaks, exact.peaks, strict=True):
        assert one is not None and other is not None
        assert one.stress == pytest.approx(other.stress, rel=1e-3)
    assert "without steps below 0.01 %" in str(steady_report(steady_answer(own.varied(lengths))))
    same = found(own.varied(lengths | {"contact.restitution": "from the blow"}))
    assert abs(same.rebound_difference) < 1e-9 * same.input


def test_without_a_tool_nothing_is_said() -> None:
    for name in ("heavy-drifter", "pneumatic-jackleg"):
        assert "transfer" not in steady_answer(load_case(name)).to_json_dict()
    assert "transfer" not in machine_answer(struck("valve-drifter", {"kind": "wall"}), 0).to_json_dict()
