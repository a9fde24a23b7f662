"""Case files of machines that switch their own valve: read, written, refused in words that help."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from case_texts import VALVE, plain_case
from percuss.case import Case, load_case
from percuss.case.answers.heading import machine_section
from percuss.case.answers.simulation_answer import motion_report, simulation_answer
from percuss.case.case import case_of
from percuss.case.parameters.description import plain_tables
from percuss.errors import CaseError
from percuss.model import Chamber, Machine, Port, Valve
from percuss.model.load.valve import port_at
from percuss.simulate import Start

PLAIN = plain_case("d = 0.01", kind=VALVE, restitution=0.2)
BREAKER = load_case("valve-breaker").to_toml()


def test_plain_numbers_are_the_valve() -> None:
    machine = Case.from_text(PLAIN).machine()
    ports = (Port("power", 0.6, "back", 0.1), Port("return", on="impact"))
    assert machine.valve == Valve({"return": -0.3, "power": 1.0}, ports, chamber=Chamber(0.05, 0.1))
    assert (machine.body.s, machine.drag, machine.contact.restitution) == (20.0, 0.01, 0.2)
    assert not machine.is_si and machine.pressure is None


def test_areas_under_a_pressure_are_forces() -> None:
    case = load_case("valve-breaker")
    by_force = case.varied({"load.states": {"return": "-13.12 kN", "power": "12.48 kN"}})
    assert dict(case.machine().valve.pairs) == pytest.approx(dict(by_force.machine().valve.pairs), rel=1e-13)
    machine = case.machine()
    assert machine.pressure == pytest.approx(16e6)
    assert machine.valve.force("return") * machine.force_scale == pytest.approx(-4120.0)
    assert machine.valve.force("power") * machine.force_scale == pytest.approx(21480.0)
    assert machine.valve.chamber.stiffness == pytest.approx(20e3 / machine.bar.mass)
    behind = [port.behind * machine.length_scale for port in machine.valve.ports]
    assert behind == pytest.approx([0.13, 0.004])
    assert [port.delay for port in machine.valve.ports] == pytest.approx([5e-3, 5e-4])


def test_a_port_may_read_a_speed() -> None:
    """In SI, written and read again, varied and told; its number is dimensionless in the machine."""
    text = BREAKER.replace('behind = "4 mm"', 'speed = "5 m/s"')
    case = Case.from_text(Case.from_text(text).to_toml())
    machine = case.machine()
    assert machine.valve.ports[1].speed * machine.speed_scale == pytest.approx(5.0, rel=1e-12)
    faster = case.varied({"load.ports[1].speed": "6 m/s"}).machine()
    assert faster.valve.ports[1].speed * machine.speed_scale == pytest.approx(6.0, rel=1e-12)
    assert "faster than 5 m/s toward the wall" in str(machine_section("", machine, (), math.inf))


def test_delays_may_follow_the_pressure_of_a_pump() -> None:
    supply = {"flow": "133 l/min", "accumulator": "2.5 cm^3/bar", "quickening": 0.5}
    case = load_case("valve-breaker").varied({"load.supply": supply})
    machine = Case.from_text(case.to_toml()).machine()
    assert machine == case.machine() and machine.valve.supply.quickening == 0.5
    assert port_at(machine.valve, 0, 1.5).delay == pytest.approx(4e-3) and "0.5 (P/P0" in str(
        machine_section("", machine, (), math.inf)
    )
    assert case_of(plain_tables(case)).machine().valve.supply.quickening == 0.5
    assert case.varied({"load.supply.quickening": 0.25}).machine().valve.supply.quickening == 0.25
    with pytest.raises(CaseError, match=r"load\.supply\.quickening.*below 1"):
        case.varied({"load.supply.quickening": 1.0}).machine()


numbers = st.floats(-1e6, 1e6).filter(lambda value: value == 0.0 or abs(value) > 1e-6)
names = st.text(st.characters(codec="utf-8", exclude_categories=("C",)), min_size=1, max_size=8).filter(str.strip)


@given(
    states=st.dictionaries(names, numbers, min_size=1, max_size=5).filter(lambda found: any(found.values())),
    behind=st.floats(1e-6, 1e6),
    delay=st.floats(0.0, 1e6),
    place=st.one_of(st.just("centre"), st.floats(0.0, 1.0)),
    stiffness=st.floats(1e-6, 1e6),
    room=st.none() | st.floats(1e-3, 1e6),
    data=st.data(),
)
def test_any_valve_survives_writing(states, behind, delay, place, stiffness, room, data) -> None:
    to, start = data.draw(st.sampled_from(sorted(states))), data.draw(st.sampled_from(sorted(states)))
    port = {"to": to, "behind": behind, "side": "back", "delay": delay, "reads": place}
    load = {"kind": "valve", "states": states, "ports": [port], "start_state": start}
    load |= {"chamber": {"stiffness": stiffness}} | ({} if room is None else {"room": room})
    tables = {"system": {"s": 5.0, "d": 0.0, "restitution": 0.2}, "load": load}
    if room is not None and behind >= room:
        with pytest.raises(CaseError, match="within the room"):
            case_of(tables)
        return
    case = case_of(tables)
    assert Case.from_text(case.to_toml()) == case
    valve = case.machine().valve
    assert dict(valve.pairs) == states and valve.start == start
    assert valve.ports == (Port(to, behind, "back", delay, place),)
    assert case.room() == room


# -- what is refused --


# -- a machine where a clock is meant, and the other way round --


def test_a_machine_is_no_system_and_says_what_answers_for_it() -> None:
    case = load_case("valve-breaker")
    for ask in (case.system, case.load):
        with pytest.raises(CaseError, match=r"load\.kind = 'valve': .*'percuss machine' .*'percuss simulate'"):
            ask()
    assert isinstance(case.machine(), Machine) and case.is_machine
    assert case.history_report is None and case.notes == ()


def test_a_clocked_load_is_no_machine() -> None:
    case = load_case("mini-breaker")
    with pytest.raises(CaseError, match=r"load\.kind = '\w+': expected 'valve'.*'percuss steady'"):
        case.machine()
    assert not case.is_machine and case.room() is None


def test_the_restitution_of_a_machine_may_be_that_of_its_blow() -> None:
    case = load_case("valve-drifter").varied({"contact.restitution": "from the blow"})
    assert 0.0 <= case.machine().contact.restitution < 1.0
    assert "is that of the blow" in case.notes[0]


# -- start and end of a simulation --


def test_a_machine_starts_on_the_wall_unless_it_is_placed() -> None:
    case = load_case("valve-breaker")
    length = case.machine().length_scale
    assert case.start().displacement == (-0.039 / length,)
    assert case.varied({"start.position": None}).start() == Start.rigid(0.0)
    moved = case.changed(start={"velocity": "-2 m/s"}).start()
    assert (moved.displacement, moved.velocity) == ((0.0,), (-2.0 / length,))
    assert case.changed(simulation={"time": "2 s", "modes": 3}).simulation().stop.time == 2.0
    assert Case.from_text(PLAIN + "[start]\nposition = -0.5\n[simulation]\ntime = 7.0\n").simulation().stop.time == 7.0


@pytest.mark.parametrize("start", [{"orbit": 1}, {"random": "rigid"}, {"position": "-1 mm", "time": "1 ms"}])
def test_a_machine_has_no_phase_to_start_at(start: dict[str, object]) -> None:
    case = load_case("valve-breaker").changed(start=start)
    with pytest.raises(CaseError, match="machine that switches itself"):
        case.start()


@pytest.mark.parametrize("modes", [0, 1])
def test_a_motion_tells_the_pressure_at_its_start(modes: int) -> None:
    supply = {"flow": "133 l/min", "accumulator": "2.5 cm^3/bar", "start": "100 bar"}
    case = load_case("valve-breaker").varied({"load.supply": supply}).changed(simulation={"modes": modes, "impacts": 3})
    answer = simulation_answer(case)
    assert answer.to_json_dict()["pressure"]["at_start"] == pytest.approx(1e7, rel=1e-9)
    assert "100 bar at the start" in str(motion_report(answer, 0))
