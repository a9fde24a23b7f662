"""``percuss machine`` as a person uses it: the report, JSON, files, and what it warns of."""

from pathlib import Path

from case_texts import MACHINE
from percuss.case import load_case


def test_the_report_of_the_breaker(percuss):
    done = percuss("machine", "valve-breaker", "--modes", "0", "-o", "cycle.csv")
    first = done.out.splitlines()[2]
    assert first.startswith("The machine runs with one blow a cycle: 3.751 kJ at 9.448 Hz (566.9 blows/min), 9.193 m/s")
    assert "It starts from rest on the wall. 18.5 kW reach the rock, 52.5 % of the input." in first
    done.told("0.0279", "132.2 l/min, 233.2 cm³ a cycle", "35.25 kW", "34.65 kW", "164.2 mm", "43.7 %")
    done.told("7.828 ms after it", "table: cycle.csv")
    table = Path("cycle.csv").read_text(encoding="utf-8")
    assert table.startswith("time_s,striking_end_m,centre_m,force_N,state\n0.0,")


def test_elastic_modes_stand_beside_the_rigid_piston(percuss):
    done = percuss("steady", "valve-drifter", "--modes", "2")  # the same answer by its other name
    assert done.out == percuss("machine", "valve-drifter", "--modes", "2").out
    done.told("Cycle, 1 blow in it (2 elastic modes)", "rigid piston    301.1 J, 10.92 m/s, 3672 blows/min")


def test_a_dimensionless_machine_and_one_that_does_not_run(percuss):
    asked = ("machine", "plain.toml", "--modes", "0")
    Path("plain.toml").write_text(MACHINE, encoding="utf-8")
    done = percuss(*asked)
    done.told("striking speed 2.1409, period 3.1489; stable, a disturbance is down to 4 %")
    assert not any(word in done for word in ("Power and oil", " kW", " mm"))
    Path("plain.toml").write_text(MACHINE.replace("return = -0.4", "return = 0.4"), encoding="utf-8")
    failed = percuss(*asked, "--json").json["failed_condition"]["condition"]
    assert failed in ("stays on the wall", "irregular", "double blow")
    Path("plain.toml").write_text(
        MACHINE.replace('"impact", to = "return"', '"impact", to = "power"'), encoding="utf-8"
    )
    percuss(*asked).told("Why not: stays on the wall", "remedy")
    percuss(*asked, "-o", "none.csv").refused("there is no cycle to write")
    assert not Path("none.csv").exists()


def test_warnings_stand_on_the_standard_error(percuss):
    case = load_case("valve-drifter")
    ports = [*case.to_dict()["load"]["ports"], {"behind": "80 mm", "side": "back", "to": "return"}]
    Path("idle.toml").write_text(case.varied({"load.ports": ports}).to_toml(), encoding="utf-8")
    done = percuss("machine", "idle.toml", "--modes", "0", "--json")
    (warning,) = done.json["warnings"]
    assert "ports[2]" in warning and done.err == f"percuss: warning: {warning}\n"
