"""``percuss machine`` as a person uses it: the report, JSON, files, and what is mistyped."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from percuss.case import load_case
from percuss.cli import main


def told(capsys: pytest.CaptureFixture[str], *arguments: str, code: int = 0) -> str:
    assert main(["machine", *arguments]) == code
    return capsys.readouterr().out


def refused(capsys: pytest.CaptureFixture[str], *arguments: str) -> str:
    assert main(list(arguments)) == 2
    printed = capsys.readouterr()
    assert printed.out == "" and "Traceback" not in printed.err
    return printed.err


def test_the_report_of_the_breaker(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    table = tmp_path / "cycle.csv"
    text = told(capsys, "valve-breaker", "--modes", "0", "-o", str(table))
    first = text.splitlines()[2]
    assert first.startswith("The machine runs with one blow a cycle: 3.751 kJ at 9.448 Hz (566.9 blows/min), 9.193 m/s")
    assert first.endswith("It starts from rest on the wall.")
    rows = (
        "0.0279",
        "132.2 l/min, 233.2 cm³ a cycle",
        "35.25 kW",
        "34.65 kW",
        "164.2 mm",
        "43.7 %",
        "7.828 ms after it",
    )
    assert all(row in text for row in rows)
    assert f"table: {table}" in text
    assert table.read_text(encoding="utf-8").startswith("time_s,striking_end_m,centre_m,force_N,state\n0.0,")


def test_elastic_modes_stand_beside_the_rigid_piston(capsys: pytest.CaptureFixture[str]) -> None:
    text = told(capsys, "valve-drifter", "--modes", "2")
    assert "Cycle, 1 blow in it (2 elastic modes)" in text
    assert "rigid piston    301.1 J, 10.92 m/s, 3672 blows/min" in text


def test_a_dimensionless_machine_and_one_that_does_not_run(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    plain = """
[system]
s = 20.0
d = 0.0
restitution = 0.2
[load]
kind = "valve"
states = {return = -0.4, power = 1.8}
ports = [{behind = 1.0, side = "back", to = "power"}, {on = "impact", to = "return"}]
"""
    path = tmp_path / "plain.toml"
    path.write_text(plain, encoding="utf-8")
    text = told(capsys, str(path), "--modes", "0")
    assert "striking speed 2.1409, period 3.1489; stable, a disturbance is down to 4 %" in text
    assert "Power and oil" not in text and " kW" not in text and " mm" not in text
    path.write_text(plain.replace("return = -0.4", "return = 0.4"), encoding="utf-8")
    text = told(capsys, str(path), "--modes", "0", "--json")
    assert json.loads(text)["failed_condition"]["condition"] in ("stays on the wall", "irregular", "double blow")
    path.write_text(plain.replace('{on = "impact", to = "return"}', '{on = "impact", to = "power"}'), encoding="utf-8")
    text = told(capsys, str(path), "--modes", "0")
    assert "Why not: stays on the wall" in text and "remedy" in text
    table = str(tmp_path / "none.csv")
    assert "there is no cycle to write" in refused(capsys, "machine", str(path), "--modes", "0", "-o", table)
    assert not Path(table).exists()


def test_warnings_stand_on_the_standard_error(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    case = load_case("valve-drifter")
    ports = [*case.to_dict()["load"]["ports"], {"behind": "80 mm", "side": "back", "to": "return"}]
    path = tmp_path / "idle.toml"
    path.write_text(case.varied({"load.ports": ports}).to_toml(), encoding="utf-8")
    assert main(["machine", str(path), "--modes", "0", "--json"]) == 0
    printed = capsys.readouterr()
    found = json.loads(printed.out)
    assert "ports[2]" in found["warnings"][0]
    assert printed.err == f"percuss: warning: {found['warnings'][0]}\n"


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["machine", "mini-breaker"], "load.kind = '"),
        (["machine", "valve-braker"], "did you mean 'valve-breaker'?"),
        (["machine", "valve-breaker", "--mode", "3"], "did you mean '--modes'?"),
        (["machine", "valve-breaker", "--modes", "-1"], "give a whole number from 0"),
        (["machine", "valve-breaker", "--plot", "x.jpg"], "the name must end in .png, .svg or .pdf"),
        (["machine", "valve-breaker", "-o", "x.toml"], "the name must end in .csv"),
        (["machine", "valve-breaker", "-o", "/no/folder/x.csv"], "there is no folder"),
        (["machine"], "the following arguments are required: CASE"),
        (["machin", "valve-breaker"], "did you mean 'machine'?"),
        (["steady", "valve-breaker"], "'percuss machine' answers for a valve that the piston switches"),
        (["simulate", "valve-breaker", "--contact", "waves"], "'percuss machine' answers for a valve"),
        (["experiment", "valve-breaker", "--distribution", "wide"], "expected wall, field, gentle, or a file"),
        (["basins", "valve-breaker", "--x", "time=0:6:2", "--y", "velocity=-6:-1:2"], "no clock drives the machine"),
    ],
)  # fmt: skip
def test_what_is_mistyped_or_asked_of_the_wrong_command(
    arguments: list[str], said: str, capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert said in refused(capsys, *arguments)


def test_the_blow_of_a_machine_is_resolved_by_waves(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    assert main(["blow", "valve-drifter", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["case"] == "valve-drifter"
    path = tmp_path / "no-speed.toml"
    path.write_text(load_case("valve-drifter").varied({"blow.velocity": None}).to_toml(), encoding="utf-8")
    assert "'percuss machine' tells the striking speed" in refused(capsys, "blow", str(path))


def test_the_next_command_of_a_new_case(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    path = tmp_path / "breaker.toml"
    assert main(["new", "valve-breaker", "-o", str(path)]) == 0
    assert capsys.readouterr().out == f"wrote {path}; next: percuss machine {path}\n"


# -- percuss simulate ---------------------------------------------------------------------------------------------


def test_a_machine_is_followed_from_its_start(capsys: pytest.CaptureFixture[str]) -> None:
    """From rest 39 mm behind the tool; blows of an independent program."""
    assert main(["simulate", "valve-breaker", "--modes", "0", "--impacts", "3", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    blows = [event for event in found["events"] if event["kind"] == "impact"]
    assert [event["time_s"] for event in blows] == pytest.approx([0.120, 0.227, 0.333], abs=1e-3)
    assert [event["speed"] for event in blows] == pytest.approx([8.78, 9.18, 9.19], abs=6e-3)
    kinds = [(event["kind"], event["to"]) for event in found["events"] if event["kind"] in ("port", "valve")]
    assert kinds[:4] == [("port", "return"), ("valve", "power"), ("port", "power"), ("valve", "return")]
    assert found["outcome"] == "impacts" and found["cycle"] is None


def test_the_simulation_settles_on_the_cycle_of_the_report(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["simulate", "valve-drifter", "--modes", "0"]) == 0
    text = capsys.readouterr().out
    assert "From this start the machine runs 1/1: 301.1 J at 61.2 Hz (3672 blows/min), 10.92 m/s" in text
    assert "valve: power" in text and "ports[0] demands" in text


def test_a_simulation_of_a_machine_that_stalls(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    gas = load_case("valve-breaker").varied({"load.chamber": {"force": "12 kN", "stiffness": "40 kN/m"}})
    path = tmp_path / "gas.toml"
    path.write_text(gas.to_toml(), encoding="utf-8")
    assert main(["simulate", str(path), "--modes", "0", "--start", "position=0"]) == 0
    assert "From this start the machine stalls (in the chamber)." in capsys.readouterr().out


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["-o", "nowhere/motion.nc"], "there is no folder 'nowhere'"),
        (["--plot", "motion.gif"], ".png, .svg or .pdf"),
        (["--start", "orbit:1"], "start.orbit = 1: expected a start by position and velocity"),
        (["--start", "random"], "start.random = 'rigid': expected a start by position and velocity"),
        (["--start", "position=1"], "position"),
    ],
)
def test_what_a_simulation_of_a_machine_does_not_take(
    options: list[str], said: str, capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert said in refused(capsys, "simulate", "valve-drifter", *options)


def test_a_simulated_motion_is_written_drawn_and_continued(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("h5netcdf")
    monkeypatch.chdir(tmp_path)
    asked = ["simulate", "valve-drifter", "--modes", "2", "--full", "--json"]
    assert main([*asked, "--impacts", "30"]) == 0
    whole = json.loads(capsys.readouterr().out)
    assert main([*asked, "--impacts", "9", "-o", "part.nc", "--plot", "part.png"]) == 0
    printed = capsys.readouterr()
    assert "motion: part.nc" in printed.err and "picture: part.png" in printed.err
    assert (tmp_path / "part.png").read_bytes()[:4] == b"\x89PNG"
    assert main(["simulate", "--resume", "part.nc", "--impacts", "30", "--json", "-o", "part.nc"]) == 0
    again = json.loads(capsys.readouterr().out)
    assert again["events"] == whole["events"] and again["label"] == whole["label"]
    assert main(["simulate", "--resume", "part.nc", "--time", "1 s", "--plot", "on.svg"]) == 0
    assert "From this start the machine" in capsys.readouterr().out and (tmp_path / "on.svg").exists()
    assert "more than the 30 that the file holds" in refused(
        capsys, "simulate", "--resume", "part.nc", "--impacts", "5"
    )
    assert "more than the" in refused(capsys, "simulate", "--resume", "part.nc", "--time", "1 ms")


def test_which_starts_run(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    gas = load_case("valve-breaker").varied({"load.chamber": {"force": "11.4 kN", "stiffness": "25.3 kN/m"}})
    path = tmp_path / "gas.toml"
    path.write_text(gas.to_toml(), encoding="utf-8")
    asked = ["experiment", str(path), "--starts", "60", "--distribution", "field", "--modes", "0", "--seed", "1"]
    assert main([*asked, "--plot", str(tmp_path / "starts.png"), "--workers", "1"]) == 0
    text = capsys.readouterr().out
    assert "The machine runs from" in text and "and stalls from" in text and "period [s]" in text
    assert main([*asked, "--json", "--workers", "1"]) == 0
    told = json.loads(capsys.readouterr().out)
    shares = {share["label"]: share for share in told["shares"]}
    assert shares["runs 1/1"]["period"] == pytest.approx(0.1213, rel=1e-3) and "frequency_Hz" not in told["si"]
    assert sum(share["share"] for share in told["shares"]) == pytest.approx(1.0)
    plane = ["--x", "position=-250:-10mm:6", "--y", "velocity=-8:8m/s:5", "--at", "state=power", "--modes", "0"]
    assert main(["basins", str(path), *plane, "--plot", str(tmp_path / "basins.png"), "--workers", "1"]) == 0
    assert "power" in capsys.readouterr().out
    assert "'return', 'power'" in refused(capsys, "basins", str(path), *plane[:5], "state=shut")
    assert "no clock" in refused(capsys, "basins", str(path), "--x", "time=0:1:2", *plane[2:])
    assert main(["experiment", str(path), "--starts", "9", "--modes", "0", "-o", str(tmp_path / "m.zarr")]) == 0
    assert main(["export", str(tmp_path / "m.zarr"), "-o", str(tmp_path / "m.csv")]) == 0
    heading, first = (tmp_path / "m.csv").read_text().splitlines()[:2]
    assert "position [bar lengths]" in heading and ("return" in first or "power" in first)
