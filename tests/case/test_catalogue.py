"""The catalogue: every machine runs, meets its figures, and can be written back."""

from __future__ import annotations

from pathlib import Path

import pytest

from percuss.case import MACHINES, Case, load_case, steady_answer
from percuss.case.catalogue.sample_cases import (
    HISTORY_FILE,
    Machine,
    is_machine,
    machine_text,
    uses_history,
    write_history,
)
from percuss.errors import CaseError

NAMES = [
    "hydraulic-drifter",
    "heavy-drifter",
    "stepped-drifter",
    "mini-breaker",
    "heavy-breaker",
    "dth-4-inch",
    "dth-6-inch",
    "pneumatic-jackleg",
    "pile-hammer",
    "laboratory-striker",
]


def test_ten_machines() -> None:
    assert [machine.name for machine in MACHINES] == NAMES
    assert all(is_machine(name) for name in NAMES)


@pytest.mark.parametrize("machine", MACHINES, ids=NAMES)
def test_machine_meets_its_figures(machine: Machine) -> None:
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


@pytest.mark.parametrize("name", NAMES)
def test_case_is_commented_and_reads_back(name: str, tmp_path: Path) -> None:
    text = machine_text(name)
    assert "synthetic" in text
    assert text.startswith("# ")
    case = Case.from_text(text, folder=tmp_path)
    assert Case.from_text(case.to_toml(), folder=tmp_path) == case


def test_laboratory_restitution() -> None:
    assert load_case("laboratory-striker").system().restitution == pytest.approx(0.358, abs=5e-4)


def test_history_is_averaged() -> None:
    report = load_case("hydraulic-drifter").history_report
    assert report is not None
    assert report.cycles == 40
    assert report.frequency == pytest.approx(60.0, rel=1e-3)
    assert not report.frequency_given
    assert [uses_history(name) for name in NAMES] == [True] + 9 * [False]


def test_history_is_the_same_every_time(tmp_path: Path) -> None:
    first, second = tmp_path / HISTORY_FILE, tmp_path / "again.csv"
    write_history(first)
    write_history(second)
    assert first.read_bytes() == second.read_bytes()


def test_unknown_machine() -> None:
    with pytest.raises(CaseError, match=r"did you mean 'mini-breaker'\?"):
        machine_text("mini-braker")
