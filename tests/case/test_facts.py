"""Every figure of every answer has a key, a sentence and a finite value or none; every report says all in words."""

from __future__ import annotations

import json
import math
import re
from importlib import import_module
from pkgutil import iter_modules
from typing import Any

import pytest

from percuss.case import (
    MACHINES,
    answers,
    blow_answer,
    load_case,
    machine_answer,
    simulation_answer,
    steady_answer,
)
from percuss.case.answers.blows.blow_answer import blow_report
from percuss.case.answers.facts import Fact, Report, Teller, json_of, rows_of
from percuss.case.answers.machine_answer import machine_report
from percuss.case.answers.machine_figures import CYCLE, POWER, Running
from percuss.case.answers.simulation_answer import motion_report
from percuss.case.answers.steady_report import steady_report

CLOCKED, VALVES = ([machine.name for machine in MACHINES if machine.valve == valve] for valve in (False, True))
STRUCTURES = ["stopped-oscillator", "stopped-beam"]


def whole(told: Any) -> None:
    """Plain values, every number of them finite."""
    assert json.loads(json.dumps(told, allow_nan=False)) == told


def spoken(report: Report) -> None:
    """Every line has words, and none of them is a number that is none."""
    assert report.title and report.summary
    for part in report.sections:
        assert part.heading and part.rows
        for row in part.rows:
            assert any(row) and not re.search(r"\b(nan|inf|None)\b", " ".join(row)), row


TABLES = {
    f"{module.__name__.rpartition('.')[2]} {name}": table
    for module in (import_module(f"percuss.case.answers.{found.name}") for found in iter_modules(answers.__path__))
    for name, table in vars(module).items()
    if isinstance(table, tuple) and table and isinstance(table[0], Fact)
}
"""All tables of figures."""


@pytest.mark.parametrize("facts", TABLES.values(), ids=TABLES)
def test_every_figure_is_named_and_explained_once(facts: tuple[Fact[Any], ...]) -> None:
    keys = [key for fact in facts for key in fact.keys.split()]
    assert len(keys) == len(set(keys))
    for fact in facts:
        assert fact.keys or fact.label
        assert fact.meaning and not fact.meaning.endswith(".")
        assert sum(not fact.unit(key) and not key.startswith("si.") for key in fact.keys.split()) <= 1


@pytest.mark.parametrize("name", CLOCKED)
def test_what_is_said_of_a_hammer_is_whole(name: str) -> None:
    case = load_case(name)
    steady = steady_answer(case, (1, 2), modes=8)
    whole(steady.to_json_dict())
    spoken(steady_report(steady))
    blow = blow_answer(case)
    whole(blow.to_json_dict())
    spoken(blow_report(blow))
    moved = simulation_answer(case.changed(simulation={"modes": 0, "impacts": 40}))
    whole(moved.to_json_dict())
    spoken(motion_report(moved, None))


@pytest.mark.parametrize("name", STRUCTURES)
def test_what_is_said_of_a_structure_is_whole(name: str) -> None:
    answer = steady_answer(load_case(name), (1, 2))
    whole(answer.to_json_dict())
    spoken(steady_report(answer))


@pytest.mark.parametrize("name", VALVES)
def test_what_is_said_of_a_machine_is_whole(name: str) -> None:
    answer = machine_answer(load_case(name), modes=0)
    whole(answer.to_json_dict())
    spoken(machine_report(answer))
    assert answer.cycle is not None
    running, tell = Running(answer.machine, answer.cycle), Teller.of(answer.machine)
    told = json_of(running, (*CYCLE, *POWER), tell)
    assert told["si"] == answer.si and all(math.isfinite(value) for value in told["si"].values())
    assert [label for label, _ in rows_of(running, CYCLE, tell)] == [fact.label for fact in CYCLE]
    moved = simulation_answer(load_case(name).changed(simulation={"modes": 0}))
    whole(moved.to_json_dict())
    spoken(motion_report(moved, None))


def test_units_are_said_where_there_are_any() -> None:
    """The value, its scale and its unit; a time of a system is in radians of its load, one of a machine is not."""
    system, machine = load_case("mini-breaker").system(), load_case("valve-breaker").machine()
    for hammer in (system, machine):
        tell = Teller.of(hammer)
        assert tell(1.0 / hammer.energy_scale, "energy") == "1 J"
        assert tell(2.0 / hammer.speed_scale, "speed") == "2 m/s"
        assert tell.given(0.5 / tell.scale("rate"), "per_min") == "30 blows/min"
    assert tell(0.02 / machine.length_scale, "length") == "20 mm"
    assert Teller(system, False)(0.25, "time") == "0.25 rad" and Teller(machine, False)(0.25, "time") == "0.25"
    assert Teller(system, False)(1.23456789, "energy", plain=6) == "1.23457"
