"""Figures that no hammer has are told of, and nothing is said of those that hammers have."""

from __future__ import annotations

from typing import Any

import pytest

from percuss.case import MACHINES, load_case, machine_answer, steady_answer
from percuss.cli import main

LATE = {"load.ports[0].behind": "1 mm", "load.ports[0].delay": "10 ms", "load.ports[1].behind": "0.5 mm"}


@pytest.mark.parametrize(
    ("name", "values", "told"),
    [
        ("valve-drifter", {"load.pressure": "900 bar"}, ["it strikes at 27.5", "the pressure of its oil is 900 bar"]),
        ("valve-drifter", LATE, ["its stroke is 45.63 times the way"]),
        ("stepped-drifter", {"load.frequency": "20 Hz"}, ["it strikes at 23.97 m/s"]),
        ("hydraulic-drifter", {"bar.youngs_modulus": "80000 GPa"}, ["is beyond the yield stress"]),
    ],
)  # fmt: skip
def test_what_no_hammer_has_is_told(name: str, values: dict[str, Any], told: list[str]) -> None:
    case = load_case(name).varied(values)
    answer = machine_answer(case, 0) if case.is_machine else steady_answer(case)
    found = answer.to_json_dict()["warnings" if case.is_machine else "notes"]
    assert [text for text in told if not any(text in one for one in found)] == []


def test_the_machines_of_the_catalogue_are_hammers() -> None:
    for sample in MACHINES:
        case = load_case(sample.name)
        found = machine_answer(case, 0).warnings if case.is_machine else steady_answer(case).told_notes
        assert not any("hardly a hammer" in text for text in found), sample.name


def test_it_can_be_switched_off(tmp_path: Any, capsys: pytest.CaptureFixture[str]) -> None:
    """And the answer is the same but for the sentence."""
    path = tmp_path / "fast.toml"
    path.write_text(load_case("stepped-drifter").varied({"load.frequency": "20 Hz"}).to_toml(), encoding="utf-8")
    told = []
    for more in ([], ["--no-plausibility"]):
        assert main(["steady", str(path), "--starts", "0", *more]) == 0
        told.append(capsys.readouterr().out.splitlines())
    assert [line for line in told[0] if "hardly a hammer" not in line] == told[1] != told[0]
