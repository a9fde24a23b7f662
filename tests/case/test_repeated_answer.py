"""Blows that follow each other, as a case asks for them: the answer, its report and its JSON."""

import json
from pathlib import Path

import pytest

from percuss.case import Case, load_case, repeated_answer
from percuss.case.answers.blows.repeated_answer import repeated_report
from percuss.case.answers.blows.transfer import tool_of
from percuss.case.answers.whole_hammer import whole_system
from percuss.cli import main
from percuss.errors import CaseError

FEEDS = json.loads((Path(__file__).parents[1] / "blow" / "reference_feeds.json").read_text(encoding="utf-8"))
SECTION = 'area = "10 cm^2", youngs_modulus = "200 GPa", density = "8000 kg/m^3"'
TEXT = """
title = "repeated"
[bar]
length = "0.5 m"
area = "10 cm^2"
youngs_modulus = "200 GPa"
density = "8000 kg/m^3"
[tool]
sections = [{{length = "1 m", {section}, attenuation = "{alpha} 1/m"}}]
bit_mass = "2 kg"
[rock]
stiffness = "400 kN/mm"
unloading_ratio = 0.1
crater = "{crater}"
[feed]
force = "12 kN"
damping = "{damping} N s/m"
[blow]
velocity = "10 m/s"
number = {number}
rate = "{rate} Hz"
between = "waves"
"""
DRILLING = """
[drilling]
bit_diameter = "45 mm"
crater_factor = 0.3
"""


def text(alpha=0.06, damping=8000.0, crater="new", number=9, rate=1.0 / 0.006, more=DRILLING):
    given = {"alpha": alpha, "damping": damping, "crater": crater, "number": number, "rate": rate}
    return TEXT.format(section=SECTION, **given) + more


def answer(**given):
    return repeated_answer(Case.from_text(text(**given)), cells=100)


def test_the_command_repeats_reference_blows(tmp_path, capsys):
    """A fixed point, with the contraction of two other programs; and the same crater met again."""
    file = tmp_path / "case.toml"
    new = text()
    same = text(0.03, 20000.0, "same", 6, 1.0 / 0.003, "")
    for case, wanted in ((new, "a fixed point"), (same, "the same crater")):
        file.write_text(case, encoding="utf-8")
        assert main(["blow", str(file), "--json"]) == 0
        found = json.loads(capsys.readouterr().out)
        reference = next(one for one in FEEDS if "waves" in one["name"] and wanted in one["name"])["expect"]
        for blow, theirs in zip(found["blows"], reference["per_blow"], strict=True):
            for name, size in (("rock_work", 200.0), ("steel_loss", 200.0), ("feed_work", 200.0), ("impulse", 80.0)):
                assert blow[name] == pytest.approx(theirs[name], abs=1e-9 * size)
            for name in ("greatest_penetration", "advance", "residual_penetration"):
                assert blow[name] == pytest.approx(theirs[name], abs=1e-12)
        if reference["contraction"]:
            assert (found["regime"], found["stands"]) == ("fixed point", True)
            assert found["multiplier"] == pytest.approx(-reference["contraction"], abs=1e-3)
            assert found["mean_rock_force"] == pytest.approx(reference["mean_rock_force"], rel=1e-5)
            assert found["advance_per_blow"] == pytest.approx(reference["advance_per_blow"], rel=1e-5)
            told = 60.0 * found["rate_of_penetration"]
            assert told == pytest.approx(reference["rate_of_penetration_m_per_min"], rel=1e-5)
            assert found["specific_energy_rock"] == pytest.approx(reference["specific_energy_rock"], rel=1e-4)


def test_the_report_says_where_the_energy_goes():
    found = answer()
    assert sum(found.shares.values()) == pytest.approx(1.0, abs=1e-3)
    report = repeated_report(found)
    assert "a fixed point" in report.summary
    rows = dict(report.sections[0].rows)
    assert rows["bit"] == "on the rock at every blow"
    assert "m/min" in rows["rate of penetration"]


def test_a_tool_that_nothing_damps_has_no_regime():
    found = answer(alpha=0.0, damping=0.0, number=20)
    assert found.train.regime.kind == "no periodic régime"
    told = " ".join(found.warnings)
    for words in ("undamped steel", "no periodic régime", "one by one"):
        assert words in told


def test_the_machine_leaves_its_tool_the_force_less_the_recoil():
    case = Case.from_text(text().replace('force = "12 kN"', 'force = "12 kN"\nof = "machine"'))
    found = repeated_answer(case, cells=50)
    assert found.machine_force == 12e3
    assert found.feed_force + found.recoil_force == pytest.approx(12e3, rel=3e-4)


def test_a_machine_that_blows_push_back_is_refused():
    case = Case.from_text(text().replace('force = "12 kN"', 'force = "3 kN"\nof = "machine"'))
    with pytest.raises(CaseError, match="push the machine back"):
        repeated_answer(case, cells=50)


def test_options_of_one_blow_are_refused(tmp_path, capsys):
    file = tmp_path / "case.toml"
    file.write_text(text(), encoding="utf-8")
    assert main(["blow", str(file), "--gauge", "0.5m"]) == 2
    assert 'between = "waves"' in capsys.readouterr().err


def test_a_train_of_blows_is_drawn_tabled_and_reported(tmp_path):
    file, made = tmp_path / "case.toml", {name: tmp_path / f"train.{name}" for name in ("csv", "png", "html")}
    file.write_text(text(number=6), encoding="utf-8")
    files = ("--csv", str(made["csv"]), "--plot", str(made["png"]), "--report", str(made["html"]))
    assert main(["blow", str(file), "--cells", "50", *files]) == 0
    head, *rows = made["csv"].read_text(encoding="utf-8").splitlines()
    blows = repeated_answer(Case.read(file), cells=50).train.blows
    place = head.split(",").index("greatest_penetration")
    assert [float(row.split(",")[place]) for row in rows] == pytest.approx([one.greatest_penetration for one in blows])
    assert made["png"].stat().st_size > 10_000
    assert "Where the energy of the striker goes" in made["html"].read_text(encoding="utf-8")


def test_a_whole_hammer_has_what_its_blow_is_worth_and_does_to_rod_and_joints():
    more = {"feed.force": "4 kN", "drilling.bit_diameter": "64 mm", "drilling.crater_factor": 0.3}
    case = load_case("stepped-drifter").varied(more)
    one = whole_system(case.system(), tool_of(case))
    blow, transfer = one.transfer.blow, one.transfer
    rate = 0.3 * blow.residual_penetration / transfer.period
    assert one.value("rate_of_penetration") == pytest.approx(rate)
    assert one.value("rock_share") == pytest.approx(transfer.rock_energy / blow.energy_before)
    assert one.value("steel_tension") == max(peak.tension for peak in transfer.sections[1])
    assert one.value("joint_openings") == 0.0
    bare = load_case("stepped-drifter")
    assert whole_system(bare.system(), tool_of(bare)).value("rate_of_penetration") is None
