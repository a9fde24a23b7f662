"""The catalogue: every machine runs, meets its figures, and can be written back."""

from __future__ import annotations

from pathlib import Path

import pytest

from percuss.case import MACHINES, Case, load_case, machine_answer, simulation_answer, steady_answer
from percuss.case.catalogue.sample_cases import (
    HISTORY_FILE,
    STRUCTURES,
    SampleMachine,
    file_beside,
    is_sample,
    machine_text,
    sample_names,
    uses_history,
    write_beside,
)

NAMES, VALVES = ([machine.name for machine in MACHINES if machine.valve == valve] for valve in (False, True))


@pytest.mark.parametrize(
    ("name", "modes", "speed"), [("stopped-oscillator", 1, 0.2017196477), ("stopped-beam", 4, None)]
)
def test_a_structure_has_one_stable_motion(name: str, modes: int, speed: float | None) -> None:
    """That of the oscillator has a published speed, V = 0.564815013723 at the time scale 2.8."""
    case = load_case(name)
    (motion,) = steady_answer(case).running
    assert case.system().body.most_modes == modes
    if speed is not None:
        assert motion.orbit.impact_velocity == pytest.approx(speed, rel=1e-9)
    assert is_sample(name)


def test_what_a_case_names_is_written_beside_it(tmp_path: Path) -> None:
    assert [file_beside(name) for name in ("stopped-beam", "stopped-oscillator", "hydraulic-drifter")] == [
        "beam_modes.csv", None, HISTORY_FILE,
    ]  # fmt: skip
    write_beside("stopped-beam", tmp_path / "beam_modes.csv")
    (tmp_path / "beam.toml").write_text(machine_text("stopped-beam"), encoding="utf-8")
    assert Case.read(tmp_path / "beam.toml").system() == load_case("stopped-beam").system()


@pytest.mark.parametrize("machine", [machine for machine in MACHINES if not machine.valve], ids=NAMES)
def test_machine_meets_its_figures(machine: SampleMachine) -> None:
    answer = steady_answer(load_case(machine.name))
    assert len(answer.running) == 1, "one stable, admissible motion with one impact every load period"
    orbit, si, bar = answer.running[0].orbit, answer.running[0].si, answer.system.bar
    assert si is not None
    assert bar is not None
    assert bar.mass == pytest.approx(machine.mass, rel=0.02)
    assert si.blow_rate_Hz == pytest.approx(machine.blow_rate, rel=0.001)
    assert si.blow_energy_J == pytest.approx(machine.blow_energy, rel=0.02)
    # theory §10: mean force = mass · v (1 + R) · blow rate
    mean_force = machine.mass * si.rigid_velocity_m_s * (1.0 + answer.system.restitution) * machine.blow_rate
    assert 1e3 * si.mean_force_kN == pytest.approx(mean_force, rel=0.02)
    assert answer.running[0].stability.waveform.stable
    assert answer.running[0].stability.disagreement is None
    assert si.drag_force_kN == 0.0
    assert orbit.warnings == ()
    assert si.efficiency == pytest.approx(1.0, abs=1e-3)  # what rings loses next to nothing


@pytest.mark.parametrize(
    ("name", "speed", "energy", "per_minute", "stroke", "flow", "input_kW", "multiplier"),
    [
        ("valve-breaker", 9.192, 3751.0, 566.9, 0.1642, 132.2, 35.3, 0.0279),
        ("valve-drifter", 10.92, 301.0, 3672.0, 0.0336, 64.8, 18.4, 0.0248),
    ],
)
def test_a_machine_with_its_valve_meets_its_class(
    name: str, speed: float, energy: float, per_minute: float, stroke: float, flow: float, input_kW: float,
    multiplier: float,
) -> None:  # fmt: skip
    """Figures of an independent computation (to the digits given here), in the classes that the comments name."""
    machine = next(machine for machine in MACHINES if machine.name == name)
    answer = machine_answer(load_case(name), modes=0)
    si = answer.si
    assert answer.runs and answer.motion.starts_from_rest
    assert si["impact_velocity_m_s"] == pytest.approx(speed, rel=5e-4)
    assert si["blow_energy_J"] == pytest.approx(energy, rel=1e-3)
    assert si["blow_rate_per_min"] == pytest.approx(per_minute, rel=5e-4)
    assert si["stroke_m"] == pytest.approx(stroke, rel=1e-3)
    assert si["oil_flow_l_per_min"] == pytest.approx(flow, rel=1e-3)
    assert si["input_power_kW"] == pytest.approx(input_kW, rel=3e-3)
    assert abs(answer.motion.cycle.multiplier) == pytest.approx(multiplier, rel=3e-3)
    assert machine.blow_energy == pytest.approx(energy, rel=1e-3)
    assert 60.0 * machine.blow_rate == pytest.approx(per_minute, rel=1e-3)
    assert answer.machine.bar.mass == pytest.approx(machine.mass, rel=1e-3)


@pytest.mark.parametrize("name", NAMES + VALVES)
def test_case_is_commented_and_reads_back(name: str, tmp_path: Path) -> None:
    text = machine_text(name)
    assert ("synthetic" if name in NAMES else "no maker's") in text
    assert text.startswith("# ")
    case = Case.from_text(text, folder=tmp_path)
    assert Case.from_text(case.to_toml(), folder=tmp_path) == case


def test_history_is_averaged() -> None:
    report = load_case("hydraulic-drifter").history_report
    assert report is not None
    assert report.cycles == 40
    assert report.frequency == pytest.approx(60.0, rel=1e-3)
    assert not report.frequency_given
    assert [uses_history(name) for name in NAMES] == [True] + 10 * [False]


@pytest.mark.parametrize("name", sample_names())
def test_a_simulation_from_its_own_start_ends_in_the_motion_of_its_line(name: str) -> None:
    case = load_case(name)
    sample = next(one for one in (*MACHINES, *STRUCTURES) if one.name == name)
    if case.is_machine:
        told = simulation_answer(case)
        assert told.motion.label == "runs 1/1"
        return
    told, apart = simulation_answer(case), getattr(sample, "from_rest", "")
    assert told.motion.label == (apart or "z=1/1") and told.motion.outcome == "periodic"
    if isinstance(sample, SampleMachine) and not apart:
        assert told.summary.si is not None
        assert told.summary.si.main_blow_rate_Hz == pytest.approx(sample.blow_rate, rel=0.01)
        assert told.summary.si.blow_energy_J == pytest.approx(sample.blow_energy, rel=0.01)
