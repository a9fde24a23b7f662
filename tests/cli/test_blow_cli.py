"""``percuss blow``: published and independently computed blows through the command, its report, files and refusals."""

from __future__ import annotations

import csv
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from percuss.case import Case, blow_answer, load_case
from percuss.cli import main

CASES = json.loads((Path(__file__).parents[1] / "blow" / "reference_blows.json").read_text(encoding="utf-8"))

ST_VENANT = """
[bar]
length = "1 m"
area = "3.14e-4 m^2"
youngs_modulus = "210 GPa"
density = "7800 kg/m^3"
[blow]
velocity = "0.1 m/s"
"""

MATCHED = """
[bar]
length = "500 mm"
area = "10 cm^2"
youngs_modulus = "200 GPa"
density = "8000 kg/m^3"
[tool]
sections = [{length = "2 m", area = "10 cm^2", youngs_modulus = "200 GPa", density = "8000 kg/m^3"}]
end = "rock"
[rock]
stiffness = "251286241.725234 N/m"
unloading_ratio = 0.25
[blow]
velocity = "10 m/s"
until = "0.8 ms"
"""


def section(row: list[float | None]) -> str:
    length, area, modulus, density = row
    long = "" if length is None else f'length = "{length!r} m", '
    return f'{{{long}area = "{area!r} m^2", youngs_modulus = "{modulus!r} Pa", density = "{density!r} kg/m^3"}}'


def text_of(case: dict[str, Any]) -> str:
    """A reference blow as a case file."""
    rows = ", ".join(section(row) for row in case["striker"]["sections"])
    velocity = case["striker"]["velocity"]
    lines = [f"[bar]\nsections = [{rows}]", "[tool]", f'gap = "{case["gap"]!r} m"']
    target = case["target"]
    if target["kind"] == "wall":
        lines.append('kind = "wall"')
    else:
        lines.append(f"sections = [{', '.join(section(row) for row in target['sections'])}]")
        lines += [f'end = "{target["end"]}"', f'bit_mass = "{target.get("bit_mass", 0.0)!r} kg"']
    if "rock" in target:
        rock = target["rock"]
        lines += ["[rock]", f'stiffness = "{rock["k1"]!r} N/m"', f"unloading_ratio = {rock['gamma']!r}"]
        lines.append(f'gap = "{rock["gap"]!r} m"')
    lines += ["[blow]", f'velocity = "{velocity!r} m/s"', f'until = "{case["until"]!r} s"']
    if "load" in case:
        steps = ", ".join(f'["{time!r} s", "{force!r} N"]' for time, force in case["load"])
        lines.append(f"load = [{steps}]")
    return "\n".join(lines)


def answered(capsys: pytest.CaptureFixture[str], *arguments: str) -> dict[str, Any]:
    assert main(["blow", *arguments, "--json"]) == 0
    found: dict[str, Any] = json.loads(capsys.readouterr().out)
    return found


@pytest.mark.parametrize("case", CASES, ids=lambda case: case["name"])
def test_reference_blows_come_out_of_the_command(
    case: dict[str, Any], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "case.toml"
    file.write_text(text_of(case), encoding="utf-8")
    found, expect = answered(capsys, str(file)), case["expect"]
    energy, speed = expect["kinetic_energy_before"], abs(expect["mean_velocity_before"])
    force = max(row[3] for row in expect["contacts"])
    assert len(found["contacts"]) == len(expect["contacts"])
    for one, other in zip(found["contacts"], expect["contacts"], strict=True):
        assert one[0] == pytest.approx(other[0], abs=1e-9 * case["until"])
        assert (one[1] is None) == (other[1] is None)
        assert one[2] == pytest.approx(other[2], abs=1e-9 * expect["striker_mass"] * speed)
        assert one[3] == pytest.approx(other[3], abs=1e-9 * force)
    scales = {"energy": energy, "work": energy, "velocity": speed, "restitution": 1.0, "efficiency": 1.0}
    scales |= {"momentum": expect["striker_mass"] * speed, "impulse": expect["striker_mass"] * speed}
    scales |= {"penetration": speed * case["until"], "gap": speed * case["until"], "force": force, "mass": 1.0}
    checked = 0
    for name, value in expect.items():
        if not isinstance(value, float | int) or name not in found:
            continue
        scale = next(scale for word, scale in scales.items() if word in name)
        assert found[name] == pytest.approx(value, abs=2e-9 * scale), name
        checked += 1
    assert checked >= 10
    assert found["energy_error"] < 1e-12 and found["momentum_error"] < 1e-12


def test_a_bar_on_a_wall_is_that_of_st_venant(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "case.toml"
    file.write_text(ST_VENANT, encoding="utf-8")
    found = answered(capsys, str(file))
    assert found["contact_duration"] == pytest.approx(3.854496446637726e-4, rel=1e-12)
    assert found["contacts"][0][3] == pytest.approx(1270.82747846, rel=1e-11)
    assert found["effective_restitution"] == pytest.approx(1.0, abs=1e-12)
    assert main(["blow", str(file)]) == 0
    told = capsys.readouterr().out
    assert "gives nothing to the wall: R = 1" in told
    assert "the case has no [tool]: the bar strikes a rigid wall" in told
    assert "In closed form" in told and "the waves give 1.271 kN" in told


def test_the_report_tells_where_the_energy_went_and_what_formulas_say(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "case.toml"
    file.write_text(MATCHED, encoding="utf-8")
    assert main(["blow", str(file)]) == 0
    told = capsys.readouterr().out
    assert "A blow of 200 J at 10 m/s puts" in told and "into the rock" in told
    assert "2(1 − γ)(1 − e^−β)²/β = 61.09 % at β = 1.256; the waves give 61.09 %" in told
    answer = blow_answer(Case.from_text(MATCHED))
    parts = answer.blow.rigid_energy_after + answer.blow.vibration_energy_after + answer.blow.work_through_face
    assert parts == pytest.approx(answer.blow.energy_before, rel=1e-12)


def test_speed_and_window_of_the_options_take_precedence(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "case.toml"
    file.write_text(MATCHED, encoding="utf-8")
    slow, fast = (answered(capsys, str(file), "--velocity", f"{v} m/s", "--until", "0.5 ms") for v in (5, 10))
    assert fast["until"] == slow["until"] == 5e-4
    assert fast["rock_work"] == pytest.approx(4.0 * slow["rock_work"], rel=1e-12)  # without a gap all is homogeneous
    assert fast["contacts"][0][1] == pytest.approx(slow["contacts"][0][1], rel=1e-12)


def test_the_speed_of_a_case_without_one_is_that_of_its_steady_motion() -> None:
    case = load_case("stepped-drifter")
    tables = case.to_dict()
    del tables["blow"]
    from percuss.case.file_format.reading import toml_text

    bare = Case.from_text(toml_text(tables))
    by_speed, whole = blow_answer(bare, until=3e-4), blow_answer(bare, until=3e-4, whole_field=True)
    assert "steady motion" in by_speed.speed
    before = by_speed.blow.mean_velocity_before
    assert whole.blow.mean_velocity_before == pytest.approx(before, rel=1e-9)  # the mean of the field
    assert whole.blow.energy_before > by_speed.blow.energy_before  # the forced strain and the ringing are in it
    assert whole.blow.energy_before == pytest.approx(by_speed.blow.energy_before, rel=0.05)
    assert whole.blow.energy_error < 1e-9


def test_waves_are_saved_as_netcdf_table_and_picture(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    xarray = pytest.importorskip("xarray")
    file, made = tmp_path / "case.toml", [tmp_path / name for name in ("blow.nc", "blow.csv", "blow.png")]
    file.write_text(MATCHED, encoding="utf-8")
    options = ["-o", str(made[0]), "--csv", str(made[1]), "--plot", str(made[2]), "--gauge", "1 m"]
    assert main(["blow", str(file), *options]) == 0
    told = capsys.readouterr().out
    assert all(str(path) in told for path in made)
    with xarray.open_dataset(made[0], engine="h5netcdf") as found:
        assert found["face_force"].max() == pytest.approx(200e3)
        assert json.loads(found.attrs["answer"])["gauge"]["place"] == 1.0
        arrival = float(found["time"][np.argmax(found["incident"].values > 1.0)])
        assert arrival == pytest.approx(1.0 / 5000.0, abs=1e-6)
    with made[1].open(encoding="utf-8") as table:
        rows = list(csv.DictReader(table))
    assert len(rows) == 4001 and "face_force [N]" in rows[0]
    assert made[2].stat().st_size > 20_000


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--velocity", "9"], "unit"),
        (["--velocity", "-9 m/s"], "greater than 0"),
        (["--velocity", "9 m/s", "--from-motion"], "--from-motion"),
        (["--until", "0 s"], "greater than 0"),
        (["--until", "1e9 s"], "at most"),
        (["--gauge", "5 m"], "a place on the rod, from 0 to 2"),
        (["--gauge", "nan m"], "--gauge"),
        (["--plot", "blow.gif"], ".png"),
        (["--csv", "blow.txt"], ".csv"),
        (["-o", "blow.toml"], ".nc"),
        (["--gauge", "5 m"], "to 2 m"),
        (["--velociti", "3 m/s"], "did you mean '--velocity'"),
    ],
)
def test_bad_options_are_refused_with_a_remedy(
    arguments: list[str], said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "case.toml"
    file.write_text(MATCHED, encoding="utf-8")
    assert main(["blow", str(file), *arguments]) == 2
    assert said in capsys.readouterr().err


def test_a_gauge_needs_a_rod(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "case.toml"
    file.write_text(ST_VENANT, encoding="utf-8")
    assert main(["blow", str(file), "--gauge", "0.1 m"]) == 2
    assert "a place on a rod: the target is a wall" in capsys.readouterr().err


def test_a_case_without_speed_and_motion_says_what_it_needs(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "case.toml"
    file.write_text(MATCHED.replace('velocity = "10 m/s"', ""), encoding="utf-8")
    assert main(["blow", str(file)]) == 2
    said = capsys.readouterr().err
    assert "or --velocity" in said and "[load]" in said


def test_a_dimensionless_bar_is_told_in_its_scales(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "case.toml"
    file.write_text(
        '[system]\ns = 20.0\nd = 0.0\nrestitution = 0.5\n[load]\nkind = "harmonic"\nmean = 0.9\namplitude = 1.0\n'
        "[tool]\nimpedance = 3.0\n",
        encoding="utf-8",
    )
    found = answered(capsys, str(file), "--velocity", "1")
    assert found["units"] == "dimensionless"
    assert found["effective_restitution"] == pytest.approx(0.5, abs=1e-12)  # (3 − 1)/(3 + 1)
    assert found["contact_duration"] == pytest.approx(0.1, rel=1e-12)  # 2/s
    assert main(["blow", str(file), "--velocity", "1", "--plot", str(tmp_path / "blow.png")]) == 0
    assert "R = (Z₂ − Z₁)/(Z₂ + Z₁) = 0.5; the waves give 0.5" in capsys.readouterr().out


def gauge_file(folder: Path) -> Path:
    """What a gauge at 1 m of the case above would record, 0.2 ms late, in strain with compression negative."""
    blow = blow_answer(Case.from_text(MATCHED), gauge=1.0)
    time = np.arange(0.0, blow.blow.until, 1e-6)
    assert blow.waves is not None
    force = blow.waves.incident.at(time) + blow.waves.reflected.at(time)
    rows = [f"{t + 2e-4:.7f},{-1.03e6 * f / (1e-3 * 200e9):.4f}" for t, f in zip(time, force, strict=True)]
    file = folder / "gauge.csv"
    file.write_text("t [s],strain\n" + "\n".join(rows), encoding="utf-8")
    return file


def test_a_record_is_laid_over_the_blow(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "case.toml"
    file.write_text(MATCHED, encoding="utf-8")
    options = [str(file), "--gauge", "1 m", "--measured", str(gauge_file(tmp_path)), "--unit", "µm/m"]
    found = answered(capsys, *options)["measured"]
    keys = {"file", "quantity", "sign", "shift", "zero", "scale", "residual", "residual_scaled", "overlap", "notes"}
    assert set(found) == keys
    assert found["quantity"] == "strain" and found["sign"] == -1
    assert found["shift"] == pytest.approx(-2e-4, abs=6e-7)
    assert found["scale"] == pytest.approx(1.03, abs=5e-3)
    assert main(["blow", *options, "--plot", str(tmp_path / "blow.png")]) == 0
    told = capsys.readouterr().out
    assert "Measured at the gauge" in told and "compression negative" in told and "times the computed force" in told


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--unit", "MPa"], "only with --measured"),
        (["--measured", "nowhere.csv"], "no such file"),
        (["--measured", "gauge.csv"], "no unit of strain, stress or force"),
        (["--measured", "gauge.csv", "--unit", "kg"], "a unit of mass"),
        (["--measured", "gauge.csv", "--unit", "µε", "--sample-rate", "fast"], "--sample-rate"),
        (["--measured", "gauge.csv", "--unit", "µε", "--column", "pressure"], "no column"),
        (["--measured", "gauge.csv"], "give --unit"),
        (["--measured", "gauge.csv", "--unit", "µε", "--measured-sign", "up"], "positive"),
        (["--measured", "gauge.csv", "--unit", "µε", "--gauge", "5 m"], "a place on the rod"),
    ],
)
def test_bad_records_are_refused_with_a_remedy(
    arguments: list[str],
    said: str,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("case.toml").write_text(MATCHED, encoding="utf-8")
    gauge_file(tmp_path)
    assert main(["blow", "case.toml", *arguments]) == 2
    assert said in capsys.readouterr().err


def test_a_record_needs_a_rod(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "case.toml"
    file.write_text(ST_VENANT, encoding="utf-8")
    assert main(["blow", str(file), "--measured", str(gauge_file(tmp_path))]) == 2
    said = capsys.readouterr().err
    assert "the target is a wall" in said and "[tool]" in said
