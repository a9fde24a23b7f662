"""Numbers known within ±: kept as they are written, and what they leave of the figures, against sampling."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from percuss.case import (
    Case,
    compare,
    load_case,
    machine_answer,
    parsed_tolerance,
    steady_answer,
    tolerance,
    uncertainty_of,
)
from percuss.case.answers.machine_answer import machine_report
from percuss.case.answers.steady_report import steady_report
from percuss.errors import CaseError

PUMP = {"load.supply": {"flow": "130 l/min", "accumulator": "2.5 cm^3/bar"}}
HAMMERS = {
    "clock": ("mini-breaker", {}, {"load.amplitude": "± 1 %", "bar.length": "± 2 mm", "contact.restitution": "± 0.01"}),
    "valve": ("valve-breaker", {}, {"load.pressure": "± 2 bar", "load.ports[0].behind": "± 1 mm"}),
    "pump": ("valve-breaker", PUMP, {"load.supply.flow": "± 1 %", "contact.restitution": "± 0.005"}),
}


def _case(name: str) -> Case:
    machine, changed, given = HAMMERS[name]
    case = load_case(machine).varied(changed)
    held = case.to_dict()

    def text(key: str, half: str) -> str:
        table, _, rest = key.partition(".")
        value = held[table]
        for step in rest.replace("[", ".").replace("]", "").split("."):
            value = value[int(step)] if step.isdigit() else value[step]
        return f"{value} {half}"

    return case.varied({key: text(key, half) for key, half in given.items()})


@pytest.mark.parametrize("name", HAMMERS)
def test_a_small_uncertainty_is_what_sampling_finds(name: str) -> None:
    case = _case(name)
    found = uncertainty_of(case, modes=0)
    assert found is not None and not found.stopped
    figures = ["blow_energy", "blow_rate", "impact_velocity"]
    drawn = tolerance(case, (), figures, samples=256, modes=0, workers=1)  # its ranges are the ± of the case
    assert [one.name for one in drawn.job.tolerances] == [key for key, _ in found.given] and not drawn.standard
    for one in found.figures:
        if one.name in figures:  # the rate of a load that keeps time is no question
            # a number that lies anywhere within its ± has a standard deviation of that over the root of 3
            spread = math.sqrt(3.0) * float(np.std(drawn.drawn[one.name]))
            assert one.half == pytest.approx(spread, rel=0.08) and not one.bent
            assert sum(one.shares.values()) == pytest.approx(1.0)
            total = dict(zip((s.name for s in drawn.job.tolerances), drawn._spread(one.name).total or (), strict=True))
            assert one.shares == pytest.approx(total, abs=0.05)


def test_it_scales_with_the_half_width_and_the_headline_says_it() -> None:
    case = load_case("mini-breaker")
    small = uncertainty_of(case.varied({"contact.restitution": "0.1 ± 0.001"}), modes=0)
    great = uncertainty_of(case.varied({"contact.restitution": "0.1 ± 0.002"}), modes=0)
    assert small is not None and great is not None
    energy = small.figures[0].half, great.figures[0].half
    assert energy[1] == pytest.approx(2.0 * energy[0], rel=1e-4)
    given = case.varied({"contact.restitution": "0.1 ± 0.02"})
    answer = replace(steady_answer(given, modes=0), uncertainty=uncertainty_of(given, 0))
    assert answer.uncertainty is not None
    told = answer.uncertainty.told("blow_energy")
    assert told is not None and f"blow energy {told}" in steady_report(answer).summary
    assert "from contact.restitution." in steady_report(answer).summary
    assert answer.to_json_dict()["uncertainty"]["figures"][0]["shares"] == {"contact.restitution": 1.0}
    both = compare([case.varied({"contact.restitution": "0.1 ± 0.02"}), case], modes=0).report()
    energies = next(row for row in both.sections[2].rows if row[0] == "blow energy")
    assert energies[1] == told and "±" not in energies[2]


def test_an_end_at_which_it_does_not_run_is_told() -> None:
    case = load_case("valve-breaker").varied({"load.chamber.force": "9 ± 5 kN"})
    answer = replace(machine_answer(case, 0), uncertainty=uncertainty_of(case, 0))
    assert answer.uncertainty is not None and len(answer.uncertainty.stopped) == 1
    assert "Not all of these hammers run: " in machine_report(answer).summary
    assert "at load.chamber.force = 14 kN" in answer.uncertainty.stopped[0]


def test_what_is_written_is_kept() -> None:
    text = """
title = "9 ± 3"
[system]
s = "20 ± 1"
d = 0.0048
restitution = "0.6 +- 5 %"
[load]
kind = "harmonic"
mean = "0.9 +/- 0.01"
amplitude = 1.0
"""
    case = Case.from_text(text)
    assert case.title == "9 ± 3" and case.system().s == 20.0
    assert case.uncertain == (
        ("system.s", "20 ± 1"),
        ("system.restitution", "0.6 +- 5 %"),
        ("load.mean", "0.9 +/- 0.01"),
    )
    assert Case.from_text(case.to_toml()) == case
    assert case.to_dict()["system"]["restitution"] == 0.6
    assert case.changed(simulation={"impacts": 50}).uncertain == case.uncertain
    moved = case.varied({"load.mean": 0.8, "system.s": "20 ± 2"})
    assert dict(moved.uncertain) == {"system.restitution": "0.6 +- 5 %", "system.s": "20 ± 2"}
    plain = load_case("valve-breaker")
    assert plain.varied({"bar.diameter": "12 ± 0.1 cm"}).machine().bar == plain.machine().bar
    assert parsed_tolerance("bar.diameter=±1mm", plain).unit == "mm"


@pytest.mark.parametrize(
    ("key", "value", "said"),
    [
        ("bar.diameter", "120 ± 0 mm", "half width greater than 0"),
        ("bar.diameter", "120 ± mm", "half width greater than 0"),
        ("bar.diameter", "120 mm ± 1 kg", "half width in a unit of length"),
        ("bar.diameter", "120 ± 1 kg", "length with its unit"),
        ("start.position", "-39 ± 1 mm", "one of"),
    ],
)
def test_refused(key: str, value: str, said: str) -> None:
    with pytest.raises(CaseError, match=said) as refused:
        uncertainty_of(load_case("valve-breaker").varied({key: value}), 0)
    assert refused.value.key == key
