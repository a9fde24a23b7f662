"""Case files of machines that switch their own valve: read, written, refused in words that help."""

from __future__ import annotations

import json
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from percuss.case import Case, CaseErrors, load_case
from percuss.case.file_format.plain_tables import case_of, json_tables
from percuss.errors import CaseError
from percuss.model import Chamber, Machine, Port, Valve
from percuss.simulate import Start

PLAIN = """
[system]
s = 20.0
d = 0.01
restitution = 0.2
[load]
kind = "valve"
states = {return = -0.3, power = 1.0}
ports = [{behind = 0.6, side = "back", to = "power", delay = 0.1}, {on = "impact", to = "return"}]
chamber = {force = 0.05, stiffness = 0.1}
"""

BREAKER = load_case("valve-breaker").to_toml()


def refusal(text: str) -> str:
    with pytest.raises(CaseError) as caught:
        Case.from_text(text, file="c").machine()
    return str(caught.value)


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


@pytest.mark.parametrize("text", [PLAIN, BREAKER], ids=["plain", "si"])
def test_a_case_with_a_valve_survives_writing_and_json(text: str) -> None:
    case = Case.from_text(text)
    assert Case.from_text(case.to_toml()) == case
    assert case_of(json.loads(json.dumps(json_tables(case)))) == case
    assert Case.from_text(case.to_toml()).machine() == case.machine()


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


@pytest.mark.parametrize(
    ("now", "then", "told"),
    [
        ('to = "power"', 'to = "powr"', "c: load.ports[0].to = 'powr': .*did you mean 'power'?"),
        ('start_state = "return"', 'start_state = "retrun"', "load.start_state = 'retrun': .*did you mean 'return'?"),
        ('behind = "130 mm"', 'behind = "-130 mm"', "load.ports[0].behind = '-130 mm': .*the wall is at 0"),
        ('behind = "130 mm"', "behind = 130", "load.ports[0].behind = 130: expected a length with its unit"),
        ('behind = "130 mm"', 'behnd = "130 mm"', "load.ports[0].behnd = .*did you mean 'behind'?"),
        ('delay = "5 ms"', 'delay = "5 mm"', 'load.ports[0].delay = .*"mm" is a unit of length'),
        ('delay = "5 ms"', 'delay = "-5 ms"', "load.ports[0].delay = '-5 ms': expected a finite number, 0 or greater"),
        ('delay = "5 ms"', 'on = "impact"', "load.ports[0].behind = '130 mm': expected nothing beside on='impact'"),
        ('delay = "5 ms"', "reads = 2", 'load.ports[0].reads = 2: expected "centre"'),
        ('side = "back"', 'side = "rear"', "load.ports[0].side = 'rear': expected 'back' or 'front'"),
        ('side = "back", ', "", "load.ports[0].side: expected both behind and side"),
        ('{front = "8.2 cm^2"}', "-13", "load.states.return = -13: expected a force .*areas beside a pressure"),
        ('{front = "8.2 cm^2"}', '"-13 kg"', 'load.states.return = .*"kg" is a unit of mass'),
        ('{front = "8.2 cm^2"}', '{frnt = "8.2 cm^2"}', "load.states.return.frnt = .*did you mean 'front'?"),
        ('{front = "8.2 cm^2"}', '{front = "8.2 cm"}', 'load.states.return.front = .*"cm" is a unit of length'),
        ('{front = "8.2 cm^2"}', '{front = "-8 cm^2"}', "load.states.return.front = '-8 cm^2': expected an area, 0 or"),
        ('pressure = "160 bar"', "", "load.states.return: .*no pressure for the areas"),
        ('pressure = "160 bar"', 'pressure = "-1 bar"', "load.pressure = '-1 bar': expected a pressure greater than 0"),
        ('stiffness = "20 kN/m"', 'stiffnes = "2 N/m"', "load.chamber.stiffnes = .*did you mean 'stiffness'?"),
        ('stiffness = "20 kN/m"', 'stiffness = "-2 N/m"', "load.chamber.stiffness = '-2 N/m': expected a finite"),
        ('pressure = "160 bar"', 'pressure = "160 bar"\nroom = "0 m"', "load.room = '0 m': expected a length greater"),
        ('pressure = "160 bar"', 'pressure = "160 bar"\nroom = "13 cm"', "load.ports[0].behind = .*the room, 13"),
        ('kind = "valve"', 'kind = "vavle"', "load.kind = 'vavle': .*did you mean 'valve'?"),
        ('pressure = "160 bar"', 'pressure = "1e300 bar"', "load.states.return = .*check the scales"),
        ('behind = "130 mm"', 'behind = "1e-30 mm"', "load.ports[0].behind: .*check the units"),
        ('pressure = "160 bar"', 'pressure = "160 bar"\nat = 3', "load.at = 3: "),
    ],
)  # fmt: skip
def test_what_is_wrong_with_a_valve_is_told_by_its_key(now: str, then: str, told: str) -> None:
    assert now in BREAKER
    text = refusal(BREAKER.replace(now, then, 1))
    first, _, last = told.partition(".*")
    assert first in text and last in text and "\n" not in text


@pytest.mark.parametrize(
    ("now", "then", "told"),
    [
        ("return = -0.3", 'return = "3 kN"', "load.states.return = '3 kN': .*only a case in SI takes units"),
        ("behind = 0.6", "behind = nan", "load.ports[0].behind = nan: expected a finite number"),
        ("behind = 0.6", "behind = 0.0", "load.ports[0].behind = 0.0: expected a finite number greater than 0"),
        ("chamber =", "pressure = 3.0\nchamber =", "load.pressure = 3.0: unknown key"),
    ],
)
def test_what_is_wrong_in_plain_numbers(now: str, then: str, told: str) -> None:
    assert now in PLAIN
    text = refusal(PLAIN.replace(now, then, 1))
    first, _, last = told.partition(".*")
    assert first in text and last in text


def test_several_problems_are_told_together() -> None:
    text = BREAKER.replace('"130 mm"', '"130 kg"').replace('"20 kN/m"', '"20 kN"').replace('"0.5 ms"', '"0.5"')
    with pytest.raises(CaseErrors) as caught:
        Case.from_text(text)
    keys = {"load.ports[0].behind", "load.ports[1].delay", "load.chamber.stiffness"}
    assert {problem.key for problem in caught.value.problems} == keys


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


def test_room_in_bar_lengths() -> None:
    case = load_case("valve-drifter").varied({"load.room": "50 mm"})
    assert case.room() == pytest.approx(0.05 / 0.341)
    assert math.isclose(load_case("valve-breaker").varied({"load.room": "0.2 m"}).room() or 0.0, 0.2)
