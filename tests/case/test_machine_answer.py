"""The answer for a machine that switches its own valve: figures, outcomes, changes, JSON; never a hang."""

from __future__ import annotations

import csv
import io
import math
from functools import cache
from typing import Any

import numpy as np
import pytest

from case_texts import MACHINE
from percuss.case import Case, MachineAnswer, load_case, machine_answer
from percuss.case.answers.machine_answer import headline
from percuss.case.answers.machine_figures import course_of, cycle_table
from percuss.errors import CaseError

PORTS = load_case("valve-breaker").to_dict()["load"]["ports"]


@cache
def breaker() -> MachineAnswer:
    return machine_answer(load_case("valve-breaker"), modes=0)


def changed(load: dict[str, Any] | None = None, restitution: float | None = None, **ports: dict[str, Any]) -> Case:
    """The breaker with other keys of [load], and of its ports p0 and p1."""
    case = load_case("valve-breaker")
    values: dict[str, Any] = {f"load.{key}": value for key, value in (load or {}).items()}
    if ports:
        values["load.ports"] = [{**port, **ports.get(f"p{i}", {})} for i, port in enumerate(PORTS)]
    return case.varied(values if restitution is None else {**values, "contact.restitution": restitution})


# -- figures --


def test_energy_and_oil_close() -> None:
    """Input = pressure x oil; what the blows take and the drag makes the input; (1 − R²) of the energy is delivered."""
    answer = breaker()
    si = answer.si
    rate = si["blow_rate_Hz"]
    assert si["oil_per_cycle_cm3"] * 1e-6 * 16e6 * rate == pytest.approx(1e3 * si["input_power_kW"], rel=1e-12)
    assert si["oil_flow_l_per_min"] == pytest.approx(6e4 * 1e-6 * si["oil_per_cycle_cm3"] * rate, rel=1e-12)
    assert si["delivered_energy_J"] == pytest.approx((1.0 - 0.15**2) * si["blow_energy_J"], rel=1e-12)
    times = np.linspace(0.0, answer.cycle.period, 20_001)
    step = times[1]
    speeds = np.diff(answer.cycle.position(times, "centre")) / step
    drag = answer.machine.drag * float((step * speeds**2).sum()) * answer.machine.energy_scale
    assert 1e3 * (si["input_power_kW"] - si["delivered_power_kW"]) / rate == pytest.approx(drag, rel=2e-3)
    # the oil is what the rear area sweeps between the switches
    swept = {switch.to: switch.behind for switch in answer.cycle.switches}
    assert si["oil_per_cycle_cm3"] == pytest.approx(16.0 * 1e2 * (swept["power"] - swept["return"]), rel=1e-12)


def test_without_a_pressure_there_is_no_oil() -> None:
    case = changed({"states": {"return": "-13.12 kN", "power": "12.48 kN"}, "pressure": None})
    answer = machine_answer(case, modes=0)
    si = answer.si
    assert si["oil_flow_l_per_min"] is None and si["oil_per_cycle_cm3"] is None
    assert si["input_power_kW"] == pytest.approx(35.25, rel=1e-3)


def test_the_blank_blow() -> None:
    """Against the return force and the gas, E = f x + κ x²/2; nothing calls for the return where only blows do."""
    si = breaker().si
    x = si["blank_distance_m"]
    assert 4120.0 * x + 0.5 * 20e3 * x**2 == pytest.approx(si["blank_energy_J"], rel=1e-12)
    only_blows = machine_answer(changed(p1={"behind": None, "side": None, "on": "impact"}), modes=0)
    assert only_blows.si["blank_distance_m"] is None


def test_the_blank_blow_goes_into_a_cushion_that_is_assumed() -> None:
    """It stops the piston within 20 mm, a little earlier as the return is due meanwhile, and takes what was brought."""
    blank = breaker().blank
    told = blank.to_json_dict()
    assert blank.assumed and told["assumed"] and told["ending"] == "cycles without a blow"
    assert 0.015 < told["si"]["depth_m"] <= 0.02
    assert told["si"]["taken_J"] == pytest.approx(told["si"]["energy_J"], rel=0.1)
    assert told["si"]["peak_pressure_Pa"] is None
    rows = dict(blank.rows)
    assert "20 mm" in rows["cushion"] and "comes again every" in rows["then"]


def test_the_blank_blow_goes_into_the_cushion_of_the_case() -> None:
    """Where only blows call for the return, nothing pulls the piston out of it again."""
    cushion = {"beyond": "15 mm", "force": "50 kN", "stiffness": "9 MN/m", "area": "20 cm^2"}
    answer = machine_answer(changed({"cushion": cushion}, p1={"behind": None, "side": None, "on": "impact"}), modes=0)
    told, rows = answer.to_json_dict()["blank_blow"], dict(answer.blank.rows)
    si = told["si"]
    assert not told["assumed"] and told["ending"] == "stops in the cushion" and told["passes"] == 1
    assert si["peak_force_N"] == pytest.approx(50e3 + 9e6 * si["depth_m"])
    assert si["peak_pressure_Pa"] == pytest.approx(si["peak_force_N"] / 20e-4)
    assert si["reach_m"] == pytest.approx(si["depth_m"] + 0.015)
    pushed = 21.48e3 * si["reach_m"] - 0.5 * 20e3 * si["reach_m"] ** 2
    assert si["taken_J"] == pytest.approx(si["energy_J"] + pushed, rel=0.01)  # but for the drag
    assert "cushion" not in rows and "stops at once" in rows["then"] and "bar" in rows["peak force"]
    short = machine_answer(changed({"cushion": cushion | {"length": "2 mm"}}), modes=0).blank
    assert "strikes the front end of the housing with" in dict(short.rows)["then"]
    soft = changed(
        {"cushion": {"force": "1 kN"}, "chamber": {"force": "9 kN"}}, p1={"behind": None, "side": None, "on": "impact"}
    )
    leaving = machine_answer(soft, modes=0).blank
    assert "nothing holds the piston back" in dict(leaving.rows)["then"]
    assert leaving.to_json_dict()["si"]["reach_m"] is None


def test_the_blank_blow_of_a_pump_has_its_pressure_and_tells_the_worst_pass() -> None:
    """The pressure for which the areas are told of changes nothing: what the pump gives decides."""
    cushion = {"beyond": "5 mm", "force": "150 kN", "stiffness": "5 MN/m"}
    supply = {"flow": "133 l/min", "accumulator": "20 cm^3/bar"}
    found = []
    for pressure in ("120 bar", "160 bar", "230 bar"):
        answer = machine_answer(changed({"cushion": cushion, "supply": supply, "pressure": pressure}), modes=0)
        found.append(answer.to_json_dict()["blank_blow"])
        rows = dict(answer.blank.rows)
        assert "bar, the mean of the cycle" in rows["pressure"]
        assert f"number {found[-1]['worst_pass']}: " in rows["worst pass"] and "kN" in rows["worst pass"]
    first, *others = (one["si"] for one in found)
    assert all(one["again_m_s"] == pytest.approx(first["again_m_s"], rel=1e-5) for one in others)
    assert all(one["worst_depth_m"] == pytest.approx(first["worst_depth_m"], rel=1e-5) for one in others)
    assert first["worst_depth_m"] > first["depth_m"] and found[0]["worst_pass"] > 1
    assert first["worst_force_N"] == pytest.approx(150e3 + 5e6 * first["worst_depth_m"])


@pytest.mark.parametrize(
    ("cushion", "words"),
    [
        ({"beyond": "-5 mm"}, "would take part of every blow"),
        ({"force": "-5 kN"}, "cushion.force"),
        ({"length": "0 mm"}, "cushion.length"),
        ({"returned": 1.5}, "cushion.returned"),
    ],
)
def test_a_cushion_that_is_none_is_refused(cushion: dict[str, object], words: str) -> None:
    with pytest.raises(CaseError, match=words):
        changed({"cushion": cushion})


def test_the_course_of_a_cycle() -> None:
    answer = breaker()
    course = course_of(answer.machine, answer.cycle)
    assert course.times[0] == 0.0 and course.times[-1] == answer.cycle.period
    assert (np.diff(course.times) >= 0.0).all()
    assert course.centre.min() == pytest.approx(-answer.cycle.stroke, rel=1e-4)
    assert {*course.states} == {"return", "power"} and course.states[0] == course.states[-1] == "power"
    jumps = [i for i in range(len(course.states) - 1) if course.states[i] != course.states[i + 1]]
    assert [course.times[i] for i in jumps] == [switch.time for switch in answer.cycle.switches]
    work = float((0.5 * (course.force[1:] + course.force[:-1]) * np.diff(course.centre)).sum())
    assert work == pytest.approx(answer.cycle.work, rel=1e-6)  # the area of the loop


def test_the_table_of_a_cycle() -> None:
    answer = breaker()
    head, *rows = csv.reader(io.StringIO(cycle_table(answer.machine, answer.cycle)))
    assert head == ["time_s", "striking_end_m", "centre_m", "force_N", "state"]
    assert float(rows[-1][0]) == pytest.approx(0.10584, rel=1e-4) and rows[-1][-1] == "power"
    assert min(float(row[1]) for row in rows) == pytest.approx(-0.1642, rel=1e-3)
    assert float(rows[0][3]) == pytest.approx(21480.0)


# -- changes --


def test_sensitivities_are_those_of_the_formulas() -> None:
    """Without delay, drag and gas: E ∝ p S/(1 − R²), rate ∝ sqrt(p/S)."""
    found = {one.parameter: one for one in machine_answer(Case.from_text(MACHINE), modes=0).sensitivities}
    assert found.keys() == {"pressure", "ports[0].behind", "restitution"}
    roots = math.sqrt(1.1), math.sqrt(0.9)
    assert found["pressure"].energy == pytest.approx(0.1)
    assert found["pressure"].rate == pytest.approx(0.5 * (roots[0] - roots[1]))
    assert found["ports[0].behind"].energy == pytest.approx(0.1)
    assert found["ports[0].behind"].rate == pytest.approx(0.5 * (1.0 / roots[0] - 1.0 / roots[1]))
    squares = [1.0 / (1.0 - (0.2 * factor) ** 2) for factor in (1.1, 0.9)]
    assert found["restitution"].energy == pytest.approx(0.5 * (1.0 - 0.2**2) * (squares[0] - squares[1]))
    assert all(one.stops == (None, None) for one in found.values())


def test_a_change_at_which_the_machine_stops_is_told() -> None:
    answer = machine_answer(changed(p1={"delay": "8 ms"}), modes=0)
    (late,) = [one for one in answer.sensitivities if one.parameter == "ports[1].delay"]
    assert late.stops[0] is None and "strikes again" in str(late.stops[1])
    assert late.energy is not None


def test_the_curve_over_the_pressure() -> None:
    curve = breaker().curve
    at_case = next(one for one in curve if one.pressure == pytest.approx(1.0))
    assert at_case.energy == pytest.approx(0.0, abs=1e-12) and at_case.rate == pytest.approx(0.0, abs=1e-12)
    running = [one for one in curve if one.energy is not None]
    assert [one.energy for one in running] == sorted(one.energy for one in running)
    assert curve[0].energy is None  # at half the pressure the nitrogen keeps it on the tool


# -- what keeps a machine from running --


@pytest.mark.parametrize(
    ("case", "outcome", "label", "told"),
    [
        (changed(p0={"behind": "2 m"}), "stalls", "in the chamber", "421.6 mm behind the tool, and the port is at 2 m"),
        (changed({"chamber": None}, p0={"behind": "9 m"}), "runs", "1/1", "runs with one blow"),
        (changed({"room": "150 mm"}), "no room", "1/1", "a stroke of 164.2 mm, and room for 150 mm"),
        (changed({"chamber": {"force": "16 kN"}}), "stalls", "on the tool", "2.88 kN, which must be below 0 N"),
        (changed({"states": {"power": "1 kN", "return": "2 kN"}, "chamber": None}), "stalls", "on the tool", "pushed"),
        (changed(p1={"delay": "9 ms"}), "double blow", "2/1", "must come within 7.828 ms). It runs with 2 blows"),
        (changed(p0={"delay": "1 s"}), "double blow", "2/1", "order overtaken"),
        (changed(restitution=0.0), "runs with rest", "1/1", "with a rest on the tool"),
        (changed({"ports": PORTS[:1]}), "stalls", "on the tool", "no order is pending"),
        (changed({"chamber": None}, p1={"behind": "130 mm"}), "runs", "1/1", "runs with one blow"),
        (changed({"chamber": None}, p0={"delay": "0 s"}, p1={"behind": "130 mm", "delay": "0 s"}),
         "cycles without a blow", "", "turns the piston round before it strikes"),
    ],
)  # fmt: skip
def test_outcomes(case: Case, outcome: str, label: str, told: str) -> None:
    answer = machine_answer(case, modes=0)
    assert (answer.outcome, answer.label) == (outcome, label)
    assert told in headline(answer)
    found = answer.motion.obstacle
    assert answer.runs == (found is None) == outcome.startswith("runs")


def test_a_machine_that_leaves() -> None:
    """Nothing turns the piston back that has left the wall for a port that does not come."""
    case = changed({"chamber": None, "ports": [{"behind": "9 m", "side": "front", "to": "return"}]})
    answer = machine_answer(case, modes=0)
    assert (answer.outcome, answer.label) == ("stalls", "leaves")


def test_warnings() -> None:
    assert breaker().warnings == ()
    idle = changed({"ports": [*PORTS, {"behind": "1 m", "side": "back", "to": "return"}]})
    assert machine_answer(idle, modes=0).warnings == (
        "no switch of the cycle comes from ports[2]: never reached, or its state was demanded before",
    )
    gas = changed({"chamber": {"force": "11.7 kN", "stiffness": "26 kN/m"}})
    assert "does not start from rest" in machine_answer(gas, modes=0).warnings[0]


@pytest.mark.parametrize(("keys", "words"), [(("behind",), "places"), (("to",), "demands")])
def test_ports_that_are_exchanged_are_found_out(keys: tuple[str, ...], words: str) -> None:
    one, other = PORTS
    turned = [one | {key: other[key] for key in keys}, other | {key: one[key] for key in keys}]
    answer = machine_answer(changed({"ports": turned}), modes=0)
    assert not answer.runs
    assert f"with the {words} of its two ports exchanged the machine would run" in answer.warnings


# -- JSON --


def test_json_has_the_numbers_of_the_cycle() -> None:
    found = breaker().to_json_dict()
    assert found["outcome"] == "runs" and found["label"] == "1/1" and found["failed_condition"] is None
    assert found["blows"] == [
        {"time": found["period"], "speed": pytest.approx(9.193, rel=1e-4), "energy": pytest.approx(42.255, rel=1e-4)}
    ]
    assert [one["port"] for one in found["ports"]] == [0, 1]
    assert [one["to"] for one in found["valve"]] == ["return", "power"]
    assert found["ports"][0]["speed"] < 0.0 < found["ports"][1]["speed"]
    assert found["work_per_cycle"] == pytest.approx(42.02, rel=1e-3)
    assert found["multipliers"][0] == pytest.approx([0.02792, 0.0], rel=1e-3)
    assert found["margins"]["latest_return"] == pytest.approx(7.828e-3, rel=1e-3)
    assert found["margins"]["beyond"] == "double blow"
    assert found["margins"]["chamber_to_run"] == pytest.approx(1.32, rel=5e-3)
    assert found["margins"]["chamber_to_start"] == pytest.approx(1.27, rel=5e-3)


def test_json_of_a_machine_that_does_not_run() -> None:
    found = machine_answer(changed(p0={"behind": "2 m"}), modes=0).to_json_dict()
    condition = found["failed_condition"]
    assert condition["condition"] == "reaches no port" and condition["needed"] == pytest.approx(2.0)
    assert found["period"] is None and found["blows"] == [] and found["si"] is None and found["margins"] is None


def test_a_case_with_a_clock_is_refused() -> None:
    with pytest.raises(CaseError, match="expected 'valve'"):
        machine_answer(load_case("mini-breaker"))
