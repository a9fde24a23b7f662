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
from percuss.case import Case, load_case, resumed_answer, simulation_answer
from percuss.case.answers.simulation_answer import held_down_sentences, motion_report
from percuss.errors import CaseError
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


# -- changed and written back ---------------------------------------------------------------------------------------


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


# -- answers --------------------------------------------------------------------------------------------------------


def test_resumed_to_a_time_in_seconds(tmp_path: Path) -> None:
    pytest.importorskip("h5netcdf")
    case = load_case("pneumatic-jackleg").changed(simulation={"modes": 0, "impacts": 5, "periodic": False})
    simulation_answer(case).motion.save(tmp_path / "part.nc")
    motion = resumed_answer(tmp_path / "part.nc", time="1 s").motion
    assert motion.outcome == "time"
    assert (motion.end_time - motion.begin_time) * motion.system.time_scale == pytest.approx(1.0, rel=1e-12)


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
    (row,) = held_down_sentences(shares)
    assert row[0] == "held down" and f"{100.0 * shares.max():.2g} % of the energy" in row[1]
    assert row in motion_report(answer, 0).sections[1].rows
