"""The picture of a machine that switches its own valve: what stands on it, and that every outcome can be drawn."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("matplotlib")

from case_texts import MACHINE
from percuss import plot
from percuss.case import Case, load_case, machine_answer


def texts(panel: Any) -> list[str]:
    return [found.get_text() for found in panel.texts]


def test_the_picture_of_the_drifter(tmp_path: Path) -> None:
    answer = machine_answer(load_case("valve-drifter"), modes=0)
    figure = plot.machine(answer)
    position, force, loop, pressures, rate = figure.axes
    assert [panel.get_title(loc="left")[:3] for panel in figure.axes[:4]] == ["(a)", "(b)", "(c)", "(d)"]
    assert texts(position) == ["tool", "ports[0]: power", "ports[1]: return"]
    assert position.get_xlabel() == "time after the blow [ms]" and position.get_ylabel() == "position [mm]"
    assert position.get_xlim()[1] == pytest.approx(16.34, rel=1e-3)
    line = position.lines[1]
    assert min(line.get_ydata()) == pytest.approx(-33.6, rel=2e-3)
    assert sorted({round(float(y), 2) for y in force.lines[1].get_ydata()}) == [-2.04, 9.18]
    assert "300.3 J a cycle" in loop.get_title(loc="left")
    assert pressures.get_xlabel() == "pressure of the supply [bar]"
    assert pressures.get_ylabel() == "blow energy [J]" and rate.get_ylabel() == "blows/min"
    at, energy = pressures.lines[0].get_data()
    assert energy[list(at).index(170.0)] == pytest.approx(301.1, rel=1e-3)
    assert plot.save(figure, tmp_path / "drifter.png").stat().st_size > 20_000


@pytest.mark.parametrize(
    ("now", "then", "title"),
    [
        ("", "", "c — runs 1/1"),
        ("restitution = 0.2", "restitution = 0.0", "c — runs 1/1"),
        ('to = "power"}', 'to = "return"}', "c — stalls leaves"),
        ('on = "impact", to = "return"', 'on = "impact", to = "return", delay = 0.4', "c — double blow 2/1"),
        ("kind", "room = 1.01\nkind", "c — no room 1/1"),
    ],
)
def test_every_outcome_can_be_drawn(now: str, then: str, title: str, tmp_path: Path) -> None:
    answer = machine_answer(Case.from_text(MACHINE.replace(now, then, 1), file="c"), modes=0)
    figure = plot.machine(answer)
    assert figure.get_suptitle() == title
    plot.save(figure, tmp_path / "machine.svg")
