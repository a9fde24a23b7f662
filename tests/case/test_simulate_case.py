"""Simulation in cases: the tables [start] and [simulation], the dispatcher, and its JSON."""

from __future__ import annotations

import inspect
import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from case_texts import FOURIER, plain_case, si_case
from percuss import Start, Stop, run, steady_states
from percuss.case import Case, CaseErrors, load_case, resumed_answer, simulation_answer, steady_answer
from percuss.case.answers.simulation_answer import held_down_in_words, motion_report
from percuss.errors import CaseError, ParameterError, PercussError, ResonanceError
from percuss.model.checks import DEFAULT_MODES
from percuss.simulate import DISTRIBUTIONS
from percuss.stability import floquet_multipliers

SI = si_case("damping_ratio = 1e-3", sizes='length = "300 mm"\ndiameter = "49 mm"')
PLAIN = plain_case(kind=FOURIER)
SQUARE = plain_case(kind='kind = "square"\namplitude = 1.0\nkappa = 1.1', restitution=0.2)

OMEGA = 2.0 * math.pi * 60.0


def plain(start: str = "", simulation: str = "") -> Case:
    return Case.from_text(f"{PLAIN}\n[start]\n{start}\n[simulation]\n{simulation}\n", file="case.toml")


def physical(start: str = "", simulation: str = "") -> Case:
    return Case.from_text(f"{SI}\n[start]\n{start}\n[simulation]\n{simulation}\n", file="case.toml")


# -- what the tables say --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("text", [PLAIN, SI, f"{PLAIN}\n[start]\n[simulation]\n"])
def test_without_tables_the_defaults_of_run(text: str) -> None:
    case = Case.from_text(text)
    assert case.start() == Start.rigid()
    assert case.simulation().stop == Stop()
    assert case.simulation().modes == inspect.signature(run).parameters["modes"].default == DEFAULT_MODES


def test_rigid_start_in_plain_numbers() -> None:
    assert plain("position = -2\nvelocity = 0.5\ntime = 0.3").start() == Start.rigid(-2.0, 0.5, 0.3)
    assert plain("time = 0.3").start() == Start.rigid(time=0.3)


def test_rigid_start_in_si() -> None:
    start = physical('position = "−3 cm"\nvelocity = "2 m/s"\ntime = "1.2 ms"').start()
    assert start.displacement == pytest.approx((-0.1,), rel=1e-14)
    assert start.velocity == pytest.approx((2.0 / (0.3 * OMEGA),), rel=1e-14)
    assert start.time == pytest.approx(1.2e-3 * OMEGA, rel=1e-14)


def test_plain_numbers_are_dimensionless_in_si_too() -> None:
    assert physical("position = -0.5\nvelocity = 1\ntime = 2.0").start() == Start.rigid(-0.5, 1.0, 2.0)


def test_modal_start() -> None:
    case = plain("modal_displacement = [-1, 0.01]\nmodal_velocity = [0.0, 0.2]\ntime = 0.3")
    assert case.start() == Start((-1.0, 0.01), (0.0, 0.2), 0.3)
    assert plain("modal_displacement = [-1.0]").start() == Start((-1.0,))
    assert plain("modal_velocity = [-1.0, 0.5]").start() == Start((0.0, 0.0), (-1.0, 0.5))


def test_simulation_table() -> None:
    found = plain(simulation="modes = 8\nimpacts = 50\ntime = 7.5\nperiodic = false\ntolerance = 1e-6").simulation()
    assert found.modes == 8
    assert found.stop == Stop(impacts=50, time=7.5, periodic=False, tolerance=1e-6)
    assert physical(simulation='time = "2 s"').simulation().stop.time == pytest.approx(2.0 * OMEGA, rel=1e-14)
    assert plain(simulation="time = 7.5").simulation().stop == Stop(time=7.5)


@pytest.mark.parametrize("periods", [1, 2])
def test_start_on_a_steady_motion(periods: int) -> None:
    case = plain(f"orbit = 2\nperiods = {periods}", "modes = 4").changed()
    orbits = steady_states(case.system(), periods, modes=4).orbits
    if len(orbits) < 2:
        with pytest.raises(CaseError, match="there is none"):
            case.start()
        return
    u, v, gap = case.start().state(4)
    expected = Start.orbit(orbits[1]).state(4)
    assert np.array_equal(u, expected[0])
    assert np.array_equal(v, expected[1])
    assert gap == expected[2] == 0.0


def test_a_start_on_the_stable_motion_stays_there() -> None:
    case = plain("orbit = 2", "modes = 8")
    motion = simulation_answer(case).motion
    orbit = steady_states(case.system(), modes=8).orbits[1]
    assert (motion.label, motion.impacts) == ("z=1/1", 3)
    assert motion.events.phase == pytest.approx(np.full(3, orbit.phase), abs=1e-9)
    assert motion.events.impact_velocity == pytest.approx(np.full(3, orbit.impact_velocity), rel=1e-9)


@pytest.mark.parametrize(
    ("keys", "displacement", "velocity"),
    [
        ("velocity = 0.01", [0.0], [0.01]),
        ("position = -0.02", [-0.02], [0.0]),
        ("modal_velocity = [0.01, -0.002]", [0.0, 0.0], [0.01, -0.002]),
        ("modal_displacement = [-0.02, 0.001]\nmodal_velocity = [0.0, 0.01]", [-0.02, 0.001], [0.0, 0.01]),
    ],
)
def test_a_disturbed_steady_motion(keys: str, displacement: list[float], velocity: list[float]) -> None:
    case = plain(f"orbit = 2\n{keys}", "modes = 4").changed()
    orbit = steady_states(case.system(), modes=4).orbits[1]
    u, v, gap = case.start().state(4)
    expected = Start.orbit(orbit, displacement, velocity).state(4)
    assert np.array_equal(u, expected[0])
    assert np.array_equal(v, expected[1])
    assert gap == expected[2]
    rest = Start.orbit(orbit).state(4)
    assert np.allclose((u - rest[0])[: len(displacement)], displacement, atol=1e-15)
    assert np.allclose((v - rest[1])[: len(velocity)], velocity, atol=1e-15)


def test_a_disturbance_has_units() -> None:
    case = load_case("mini-breaker").changed(start={"orbit": 1, "position": "-1 mm", "velocity": "0.1 m/s"})
    system = case.system()
    orbit = steady_states(system).orbits[0]
    u, v, gap = case.start(0).state(0)
    assert gap == u[0] == pytest.approx(-1e-3 / system.length_scale, rel=1e-14)
    after = -system.restitution * orbit.rigid_velocity
    assert v[0] - after == pytest.approx(0.1 / system.speed_scale, rel=1e-12)


@pytest.mark.parametrize("number", [1, 2])
def test_a_small_disturbance_grows_or_fades_as_the_multipliers_say(number: int) -> None:
    """A rigid bar: its two multipliers against the distance from the motion, impact after impact."""
    case = plain(f"orbit = {number}\nvelocity = 1e-6", "modes = 0\nimpacts = 6\nperiodic = false")
    orbit = steady_states(case.system(), modes=0).orbits[number - 1]
    values = floquet_multipliers(orbit, 0).values
    away = simulation_answer(case).motion.events.phase - orbit.phase
    # each deviation is the sum of two geometric series with these ratios
    trace, determinant = values.sum().real, values.prod().real
    expected = trace * away[1:-1] - determinant * away[:-2]
    assert np.abs(away).max() > 1e-6
    largest = np.abs([away[:-2], away[1:-1], away[2:]]).max(axis=0)
    assert np.all(np.abs(away[2:] - expected) < 10.0 * largest**2 + 1e-11)  # what is not linear, and rounding


@pytest.mark.parametrize("kind", DISTRIBUTIONS)
def test_random_start(kind: str) -> None:
    case = plain(f'random = "{kind}"\nseed = 7')
    assert case.start() == Start.random(case.system(), seed=7, distribution=kind)
    assert case.start() != plain(f'random = "{kind}"').start()
    assert plain(f'random = "{kind}"\nseed = 7\ntime = 0.25').start() == case.start().at(0.25)


def test_square_and_recorded_loads_run() -> None:
    square = Case.from_text(f"{SQUARE}[simulation]\nmodes = 0\nimpacts = 20\n")
    assert simulation_answer(square).motion.impacts > 0
    drifter = load_case("hydraulic-drifter")
    answer = simulation_answer(drifter)
    assert answer.motion.label == "z=1/1"
    assert answer.system.load.report is not None
    assert answer.notes == drifter.notes
    stable = steady_answer(drifter).running[0]
    assert stable.si is not None
    assert answer.summary.si is not None
    assert answer.summary.si.blow_energy_J == pytest.approx(stable.si.blow_energy_J, rel=1e-4)


def test_a_constant_load_runs() -> None:
    text = PLAIN.replace(", [1.0, 0.0]", "").replace("0.9, 0.0", "1.0, 0.0").replace("d = 0.0048", "d = 0.0")
    answer = simulation_answer(Case.from_text(f"{text}[simulation]\nmodes = 0\n"))
    assert answer.motion.label == "rest"
    # a ball under gravity 1 dropped from height 1: sqrt(2) (1 + 2R/(1 - R)) until it lies still
    assert answer.motion.events.time[-1] == pytest.approx(math.sqrt(2.0) * (1.0 + 1.2 / 0.4), rel=1e-12)


# -- changed and written back ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "case",
    [
        plain("position = -1.5\ntime = 0.3", "modes = 8\nimpacts = 5\nperiodic = false"),
        plain("modal_displacement = [-1, 0.01]\nmodal_velocity = [0.0, 0.2]"),
        physical('position = "-3 cm"\nvelocity = "2 m/s"\ntime = "1.2 ms"', 'time = "2 s"\ntolerance = 1e-6'),
        plain('random = "ringing"\nseed = 3'),
        plain(),
    ],
)
def test_written_back(case: Case) -> None:
    again = Case.from_text(case.to_toml())
    assert again == case
    assert hash(again) == hash(case)
    assert again.to_dict() == case.to_dict()


def test_changed_tables() -> None:
    case = plain("position = -2.0\ntime = 0.3", "modes = 8\nimpacts = 5")
    other = case.changed(start={"velocity": 1.0}, simulation={"impacts": 7})
    assert other.start() == Start.rigid(-1.0, 1.0, 0.0)  # [start] is another one
    assert (other.simulation().modes, other.simulation().stop.impacts) == (8, 7)  # [simulation] is amended
    assert case.changed() == case
    assert case.start() == Start.rigid(-2.0, 0.0, 0.3)


def test_changed_keeps_a_recording_that_is_gone() -> None:
    case = load_case("hydraulic-drifter")  # its history lay in a temporary folder
    changed = case.changed(start={"position": "-10 mm"})
    assert changed.system() == case.system()
    assert changed.notes == case.notes


# -- what is wrong --------------------------------------------------------------------------------------------------


def refusal(make: Any, *tables: str) -> str:
    with pytest.raises(CaseError) as caught:
        make(*tables)
    assert all(line.startswith("case.toml: ") for line in str(caught.value).splitlines())
    return str(caught.value)


WRONG_STARTS = [
    ("position = 0.1", ["start.position = 0.1", "0 (on the wall) or less"]),
    ('position = "-1 m"', ["start.position = '-1 m'", "only a case in SI takes units"]),
    ("position = nan", ["start.position = nan", "finite"]),
    ("position = true", ["start.position = True", "finite number"]),
    ("positon = -1.0", ["start.positon = -1.0", "[start] takes position, velocity, time", "'position'?"]),
    ("velocity = inf", ["start.velocity = inf", "finite"]),
    ("time = 1e16", ["start.time = 1e+16", "1e+12"]),
    ("modal_displacement = []", ["start.modal_displacement = []", "a list of numbers"]),
    ("modal_displacement = -1.0", ["start.modal_displacement = -1.0", "a list of numbers"]),
    ('modal_displacement = [-1.0, "x"]', ["start.modal_displacement", "number 1 of the list is x"]),
    ("modal_velocity = [nan]", ["start.modal_velocity", "finite", "number 0"]),
    (
        "modal_displacement = [-1.0, 0.0]\nmodal_velocity = [0.0]",
        ["start.modal_velocity", "as many as modal_displacement: 2"],
    ),
    (
        "position = -1.0\nvelocity = 0.0\nmodal_velocity = [0.0]",
        ["position and velocity (rigid)", "(modal)", "remove modal_velocity, or position and velocity"],
    ),
    ('orbit = 1\nrandom = "rigid"', ["one kind of start", "remove random, or orbit"]),
    ("orbit = 1\nseed = 3\nvelocity = 0.1", ["one kind of start", "remove seed, or orbit and velocity"]),
    ("orbit = 1\nposition = -1e13", ["start.position = -1", "at most 1e+12"]),
    ("orbit = 1\nmodal_velocity = [1e13]", ["start.modal_velocity", "at most 1e+12"]),
    ("position = -1e13", ["start.position = -1", "at most 1e+12"]),
    ("orbit = 1\nposition = 0.1", ["start.position = 0.1", "0 (on the wall) or less"]),
    ("orbit = 1\nvelocity = 0.1\nmodal_velocity = [0.1]", ["one kind of start", "(rigid)", "(modal)"]),
    ("orbit = 1\nmodal_displacement = [-0.1]\nmodal_velocity = [0.0, 0.1]", ["start.modal_velocity"]),
    ("orbit = 0", ["start.orbit = 0", "1 or greater"]),
    ("orbit = 1.5", ["start.orbit = 1.5", "whole number"]),
    ("orbit = 1\nperiods = 1001", ["start.periods = 1001", "from 1 to 1000"]),
    ("orbit = 1\ntime = 0.3", ["start.time = 0.3", "remove time"]),
    ("periods = 2", ["start.periods = 2", "add orbit = 1"]),
    ("seed = 2", ["start.seed = 2", 'add random = "rigid"']),
    ('random = "ringin"', ["start.random = 'ringin'", "did you mean 'ringing'?"]),
    ('random = "rigid"\nseed = -1', ["start.seed = -1", "0 or greater"]),
]
WRONG_SIMULATIONS = [
    ("modes = -1", ["simulation.modes = -1", "from 0 to 4096"]),
    ("modes = 5000", ["simulation.modes = 5000", "from 0 to 4096"]),
    ("modes = 1.5", ["simulation.modes = 1.5", "whole number"]),
    ("impacts = -1", ["simulation.impacts = -1"]),
    ("time = 0", ["simulation.time = 0", "greater than 0"]),
    ('time = "2 s"', ["simulation.time = '2 s'", "only a case in SI takes units"]),
    ("periodic = 1", ["simulation.periodic = 1", "true or false"]),
    ("tolerance = 1.0", ["simulation.tolerance = 1.0", "from 1e-13 to 0.1"]),
    ("impact = 5", ["simulation.impact = 5", "did you mean 'impacts'?"]),
]
WRONG_SI_STARTS = [
    ('position = "3 cm"', ["start.position = '3 cm'", "0 (on the wall) or less"]),
    ('position = "-3"', ["start.position = '-3'", "with its unit"]),
    ('position = "-3 kg"', ["start.position = '-3 kg'", "unit of mass"]),
    ('velocity = "2 m"', ["start.velocity = '2 m'", "unit of length"]),
    ("velocity = [2]", ["start.velocity = [2]", "a unit of velocity"]),
]


@pytest.mark.parametrize(
    ("make", "tables", "parts"),
    [(plain, (start,), parts) for start, parts in WRONG_STARTS]
    + [(plain, ("", simulation), parts) for simulation, parts in WRONG_SIMULATIONS]
    + [(physical, (start,), parts) for start, parts in WRONG_SI_STARTS]
    + [(physical, ("", 'time = "-2 s"'), ["simulation.time = '-2 s': expected a time greater than 0"])],
)
def test_wrong_starts_and_simulations(make: Any, tables: tuple[str, ...], parts: list[str]) -> None:
    message = refusal(make, *tables)
    assert all(part in message for part in parts), message


def test_all_problems_together() -> None:
    with pytest.raises(CaseErrors) as caught:
        plain("position = 1.0", "modes = -1")
    assert [problem.key for problem in caught.value.problems] == ["start.position", "simulation.modes"]


def test_a_start_that_does_not_fit_the_simulation() -> None:
    case = plain("modal_displacement = [-1.0, 0.0, 0.1]", "modes = 1")
    assert "start.modal_displacement" in refusal(case.start)
    assert "at most 2 (modes 0 to 1)" in refusal(lambda: simulation_answer(case))
    beyond = plain("modal_displacement = [-1.0, -0.75]")  # u(1) = -1 + 1.5
    message = refusal(beyond.start)
    assert "start.modal_displacement" in message
    assert "it is at 0.5" in message


def test_a_steady_motion_that_is_none() -> None:
    assert "start.orbit = 3: expected a number from 1 to 2" in refusal(plain("orbit = 3").start)
    assert "in 3 load periods, and there is none" in refusal(plain("orbit = 1\nperiods = 3").start)


def test_resonance_is_named() -> None:
    text = PLAIN.replace("s = 20.0", f"s = {1.0 / (2.0 * math.pi)!r}").replace("d = 0.0048", "d = 0.0")
    with pytest.raises(ResonanceError):
        simulation_answer(Case.from_text(text))


# -- answers --------------------------------------------------------------------------------------------------------


def test_the_answer_is_what_run_gives() -> None:
    case = plain("position = -0.5\ntime = 0.3", "modes = 8\nimpacts = 30\nperiodic = false")
    answer = simulation_answer(case)
    same = run(case.system(), Start.rigid(-0.5, 0.0, 0.3), modes=8, stop=Stop(impacts=30, periodic=False))
    assert np.array_equal(answer.motion.states, same.states)
    assert (answer.name, answer.title, answer.motion.impacts) == ("case.toml", "case", 30)


def test_interrupted_by_its_progress() -> None:
    seen = []
    case = plain(simulation="modes = 0\nimpacts = 1000000\nperiodic = false")
    answer = simulation_answer(case, lambda progress: seen.append(progress) or len(seen) == 2)
    assert answer.motion.outcome == "interrupted"
    assert 0 < answer.motion.impacts == seen[-1].impacts < 1000000
    assert any("interrupted" in warning for warning in answer.warnings)


def test_resumed_bit_for_bit(tmp_path: Path) -> None:
    pytest.importorskip("h5netcdf")
    case = plain("time = 0.3", "modes = 4\nperiodic = false")
    part = simulation_answer(case.changed(simulation={"impacts": 13}))
    part.motion.save(tmp_path / "part.nc")
    whole = simulation_answer(case.changed(simulation={"impacts": 40})).motion
    found = resumed_answer(tmp_path / "part.nc", impacts=40)
    assert np.array_equal(found.motion.states, whole.states)
    assert np.array_equal(found.motion.events.time, whole.events.time)
    assert found.title == "part"
    assert resumed_answer(tmp_path / "part.nc").motion.impacts == 26
    assert resumed_answer(tmp_path / "part.nc", time=whole.events.time[20]).motion.impacts < 40
    with pytest.raises(ParameterError, match="more than the 13"):
        resumed_answer(tmp_path / "part.nc", impacts=13)
    with pytest.raises(ParameterError, match="more than the"):
        resumed_answer(tmp_path / "part.nc", time=1.0)
    with pytest.raises(ParameterError, match="no scales"):
        resumed_answer(tmp_path / "part.nc", time="2 s")


def test_resumed_to_a_time_in_seconds(tmp_path: Path) -> None:
    pytest.importorskip("h5netcdf")
    case = load_case("pneumatic-jackleg").changed(simulation={"modes": 0, "impacts": 5, "periodic": False})
    simulation_answer(case).motion.save(tmp_path / "part.nc")
    motion = resumed_answer(tmp_path / "part.nc", time="1 s").motion
    assert motion.outcome == "time"
    assert (motion.end_time - motion.begin_time) * motion.system.time_scale == pytest.approx(1.0, rel=1e-12)


def test_resumed_from_nothing(tmp_path: Path) -> None:
    pytest.importorskip("h5netcdf")
    with pytest.raises(PercussError, match="no such file"):
        resumed_answer(tmp_path / "none.nc")


# -- JSON -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "case",
    [
        plain("time = 0.3", "modes = 4"),
        plain("", "impacts = 0"),
        physical("", "modes = 2\nimpacts = 6"),
        Case.from_text(f"{SQUARE}[simulation]\nmodes = 0\n"),
    ],
)
def test_json_is_plain_and_complete(case: Case) -> None:
    answer = simulation_answer(case)
    found = answer.to_json_dict()
    assert len(found["events"]) == len(answer.motion.events)
    assert json.loads(answer.to_json_text()) == json.loads(json.dumps(found, allow_nan=False))
    assert json.loads(answer.to_json_text(0))["events"] == []
    for row, event in zip(found["events"], answer.motion.events, strict=True):
        assert (row["kind"], row["time"], row["impact_velocity"]) == (event.kind, event.time, event.impact_velocity)
        assert 0.0 <= row["phase"] < 2.0 * math.pi
        assert (row["time_s"] is None) is not case.is_si


def test_json_of_the_last_events() -> None:
    answer = simulation_answer(plain("time = 0.3", "modes = 0"))
    every = answer.to_json_dict()["events"]
    assert answer.to_json_dict(last=3)["events"] == every[-3:]
    assert answer.to_json_dict(last=10**9)["events"] == every
    assert answer.to_json_dict(last=0)["events"] == []


def test_a_title_cannot_break_the_text() -> None:
    case = Case.from_text('title = "\\"events\\": []"\n' + PLAIN + "[simulation]\nmodes = 0\nimpacts = 2\n")
    found = json.loads(simulation_answer(case).to_json_text())
    assert found["title"] == '"events": []'
    assert len(found["events"]) == 2


def test_that_the_load_holds_the_bar_down_is_told() -> None:
    """Of a bar whose impacts turn the strain over; one that keeps it is never held so."""
    case = plain(simulation="impacts = 60\nmodes = 4")
    kept = simulation_answer(case)
    answer = simulation_answer(case.varied({"system.strain": "reversed"}))
    told = answer.to_json_dict()["held_down"]
    assert kept.to_json_dict()["held_down"] is None
    shares = answer.motion.events.held_down
    assert told == {"rests": shares.size, "greatest_share": shares.max()} and 0.0 < shares.max() < 1.0
    (row,) = held_down_in_words(shares)
    assert row[0] == "held down" and f"{100.0 * shares.max():.2g} % of the energy" in row[1]
    assert row in motion_report(answer, 0).sections[1].rows
