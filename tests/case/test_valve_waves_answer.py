"""A machine with a valve by waves, as `percuss simulate --contact waves` has it."""

import json
import math

import numpy as np
import pytest

from percuss import plot
from percuss.case import Case, load_case, valve_waves_answer
from percuss.case.answers.blows.valve_waves_answer import valve_waves_report
from percuss.cli import main
from percuss.errors import CaseError

FED = {"feed.force": "12 kN", "feed.damping": "600 kN s/m", "tool.sections[0].attenuation": "0.01 1/m"}


def test_the_breaker_settles_with_a_feed_and_a_damper(tmp_path, capsys):
    file = tmp_path / "breaker.toml"
    file.write_text(load_case("valve-breaker").varied(FED).to_toml(), encoding="utf-8")
    assert main(["simulate", str(file), "--contact", "waves", "--cells", "40", "--impacts", "60", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["label"] == "one blow in a cycle"
    assert found["rate"] == pytest.approx(found["law_rate"], rel=0.01)
    assert found["speed"] == pytest.approx(found["law_speed"], rel=0.02)
    assert found["restitution"] == pytest.approx(0.156, abs=2e-3)
    assert found["stands"]
    assert found["left_bound"] < 0.05
    assert found["blows"][-1]["stands"]


def test_oil_drives_the_piston_into_a_hole():
    """The advance by specific energy is what the rock keeps over it; by a crater factor a share of what is fed."""
    bits = {"drilling.bit_diameter": "140 mm", "simulation.impacts": 40}
    for worth in ({"drilling.specific_energy": "200 MJ/m^3"}, {"drilling.crater_factor": 0.4}):
        found = valve_waves_answer(load_case("oil-breaker").varied(FED | bits | worth), cells=40).to_json_dict()
        advance = 0.4 * found["fed"]
        if "drilling.specific_energy" in worth:
            advance = found["rock_power"] / found["rate"] / (0.25 * math.pi * 0.14**2 * 200e6)
        assert found["rate_of_penetration"] == pytest.approx(advance * found["rate"], rel=1e-12)
        assert found["label"] == "one blow in a cycle"
        assert found["rate"] == pytest.approx(found["law_rate"], rel=0.02)


def test_without_a_feed_the_answer_says_so():
    answer = valve_waves_answer(load_case("valve-breaker").varied({"simulation.impacts": 20}), cells=40)
    assert any(text.startswith("no feed") for text in answer.warnings)
    report = valve_waves_report(answer, 3)
    assert "blow rate" in dict(report.sections[0].rows)
    assert len(report.sections[1].rows) == 3


def test_the_picture_tells_every_impact(tmp_path):
    """Of a machine, and of a hammer under a clock: as many points as there are impacts."""
    for name in ("oil-breaker", "drill-string"):
        to = tmp_path / f"{name}.svg"
        assert main(["simulate", name, "--contact", "waves", "--cells", "40", "--impacts", "8", "--plot", str(to)]) == 0
        assert to.stat().st_size > 10_000
    answer = valve_waves_answer(load_case("valve-breaker").varied({"simulation.impacts": 8}), cells=40)
    speed, back, energy = plot.by_waves(answer).axes
    assert [len(axes.lines) for axes in (speed, back, energy)] == [3, 2, 3]
    np.testing.assert_allclose(back.lines[0].get_ydata()[-4:], answer.motion.restitutions[-4:])
    assert speed.lines[0].get_ydata()[-1] == pytest.approx(answer.motion.velocities[-1])


def test_a_machine_without_a_tool_is_refused():
    text = load_case("valve-breaker").to_toml()
    bare = text[: text.index("[tool]")].rstrip() + "\n"
    with pytest.raises(CaseError):
        valve_waves_answer(Case.from_text(bare), cells=40)
