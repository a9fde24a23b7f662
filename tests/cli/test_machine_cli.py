"""``percuss machine`` and ``identify`` as a person uses them: report, JSON, files, and what they warn of or refuse."""

from pathlib import Path

import numpy as np
import pytest

from case_texts import MACHINE
from percuss.case import Case, CaseFamily, load_case


def test_the_report_of_the_breaker(percuss):
    done = percuss("machine", "valve-breaker", "--modes", "0", "-o", "cycle.csv")
    first = done.out.splitlines()[2]
    assert first.startswith("The machine runs with one blow a cycle: 3.751 kJ at 9.448 Hz (566.9 blows/min), 9.193 m/s")
    assert "It starts from rest on the tool. 18.5 kW reach the rock, 52.5 % of the input." in first
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
    done.told("striking speed 2.1409, period 3.1489; stable: a disturbance settles to 1 % in 2 cycles")
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


def test_numbers_of_a_machine_from_its_blows(percuss):
    """A case is made to blow, its blows are written, and the numbers found from them make it again."""
    rng = np.random.default_rng(1)
    true = load_case("valve-breaker").varied({"contact.restitution": 0.2, "load.pressure": "170 bar"})
    whole = CaseFamily(true, {}).whole({}, modes=0)
    columns = ["rebound_velocity", "rigid_velocity"]
    rows = ["t [ms];rebound [m/s];striking speed [km/h];acc peak [g];remark"]
    for i in range(120):
        back, speed = (whole.value(name) * (1.0 + 0.01 * rng.normal()) for name in columns)
        time = 1e3 * (i + 0.003 * rng.normal()) / whole.value("blow_rate")
        rows.append(f"{time:.3f};{back:.4f};{3.6 * speed:.3f};{30.0 * speed:.1f};ok")
    Path("times.csv").write_text("\n".join(rows), encoding="utf-8")
    asked = ("identify", "valve-breaker", "--blows", "times.csv", "--given", "bar.length=±2%", "--modes", "0")
    done = percuss(*asked, "-o", "found.toml", "--plot", "fit.png", "--report", "fit.html")
    done.told("What fits: load.pressure 1", "bar.length from 0.98 to 1.02 m", "blow rate")
    found = percuss(*asked, "--json").json
    assert found["figures"][0]["name"] == "blow_rate" and found["spare"] == 1 and found["agrees"] and found["runs"]
    pressure, restitution = found["found"]
    assert pressure["low"] < 170.0 < pressure["high"] and pressure["unit"] == "bar" and pressure["given"][0] > 0.05
    assert restitution["low"] < 0.2 < restitution["high"] and restitution["own"] == 0.15
    assert Case.read("found.toml").tables.contact.restitution == pytest.approx(restitution["value"], rel=1e-8)
    assert Path("fit.png").stat().st_size > 10_000 and "The blows that were measured" in Path("fit.html").read_text()
    again = percuss("identify", "found.toml", *asked[2:], "--json").json
    assert [one["value"] for one in again["found"]] == pytest.approx([one["value"] for one in found["found"]], rel=1e-6)


@pytest.mark.parametrize(
    ("heading", "says"),
    [
        ("t [s],rebound", 'no unit of velocity for "rebound"'),
        ("t [s],rebound [bar]", "unit of pressure"),
        ("x,rebound [m/s]", "no column of times"),
        ("t [s],rebound [m/s],speed after [m/s]", "two columns could be the rebound speed"),
        ("t [s],torque [N*m]", "give rebound speeds, too"),
    ],
)
def test_tables_of_blows_that_cannot_be_read(percuss, heading, says):
    size = heading.count(",")
    rows = [",".join([f"{0.1 * i + 0.001 * (i % 3):.4f}", *[f"{1.5 + 0.01 * (i % 4):.3f}"] * size]) for i in range(40)]
    Path("times.csv").write_text("\n".join([heading, *rows]), encoding="utf-8")
    percuss("identify", "valve-breaker", "--blows", "times.csv", "--modes", "0").refused(says)
