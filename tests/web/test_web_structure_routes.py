"""Structures that are held in the workbench: over HTTP: the numbers of the library, and words where there are none."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

pytest.importorskip("fastapi")

from percuss.case import load_case, structure_answer
from percuss.case.file_format.plain_tables import case_of
from percuss.case.file_format.reading import parsed, value_at
from percuss.web import Limits, Settings
from percuss.web.shared_by_routes import MOST_MODES
from web_client import Client

BUDD_DUX = {
    "body": {"kind": "mounted", "spring": 2.8**-2, "gap": -0.1},
    "system": {"restitution": 0.8},
    "load": {"kind": "harmonic", "mean": 0.0, "amplitude": 2.8**-2},
}
"""r = 0.8, ω = 2.8, σ = -0.1 of Budd and Dux, whose motion doubles its period at σ = -0.06857565."""

MODES = {
    "body": {"kind": "modes", "omega": [0.9, 2.3], "damping": [0.05, 0.1], "contact": [1.0, 0.7], "drive": [1.0, -0.4],
             "gap": 0.2},
    "system": {"restitution": 0.7},
    "load": {"kind": "harmonic", "mean": 0.0, "amplitude": 1.0},
}  # fmt: skip
IN_SI = {
    "body": {"kind": "mounted", "spring": "20 kN/m", "mass": "2 kg", "gap": "1 mm"},
    "contact": {"restitution": 0.7},
    "load": {"kind": "harmonic", "mean": "1 N", "amplitude": "100 N", "frequency": "10 Hz"},
}
STRUCTURES = [BUDD_DUX, MODES, IN_SI]


@pytest.fixture(scope="module")
def client() -> Client:
    return Client(Settings(limits=Limits(seconds=300.0)))


@pytest.mark.parametrize("name", ["stopped-oscillator", "stopped-beam"])
def test_a_sample_comes_as_a_case_of_the_same_structure(client: Client, name: str) -> None:
    """A table of modes comes as its columns, as what is asked next names no file."""
    assert name in [one["name"] for one in client.get("/api/machines").json()["structures"]]
    found, system = client.get(f"/api/machines/{name}").json(), load_case(name).system()
    again = case_of(found["tables"]).system()
    assert again.body == system.body
    assert again.load.coefficients.tolist() == system.load.coefficients.tolist()
    assert case_of(parsed(found["toml"], "case")).system().body == system.body
    told = [client.answer("/api/steady", asked) for asked in ({"machine": name}, {"case": found["tables"]})]
    assert told[0]["periods"] == told[1]["periods"]


@pytest.mark.parametrize("tables", STRUCTURES, ids=["mounted", "modes", "si"])
def test_the_answers_are_those_of_the_library(client: Client, tables: Any) -> None:
    told = structure_answer(case_of(tables)).to_json_dict()
    assert client.answer("/api/steady", {"case": tables})["periods"] == told["periods"]
    quick = client.answer("/api/quick", {"case": tables})
    for orbit, full in zip(quick["orbits"], told["periods"][0]["orbits"], strict=True):
        assert {name: orbit[name] for name in ("phase", "impact_velocity", "stable")} == {
            name: full[name] for name in ("phase", "impact_velocity", "stable")
        }
    info = client.answer("/api/case", {"case": tables})
    assert info["plain"] is None and info["system"]["gap"] == pytest.approx(case_of(tables).system().body.gap)
    for i, full in enumerate(told["periods"][0]["orbits"], 1):
        header, arrays = client.arrays("/api/motion", {"case": tables, "orbit": i})
        assert header["blows"][0]["impact_velocity"] == full["impact_velocity"]
        assert np.all(np.isfinite(arrays["displacement"])) and np.all(np.isfinite(arrays["strain"]))
        end = arrays["displacement"][:, -1]
        shown = np.interp(arrays["t"], arrays["end_t"][:-1], arrays["end_gap"][:-1])
        np.testing.assert_allclose(end - end[0], shown - shown[0], atol=0.01 * np.ptp(end))


def test_parameters_of_a_structure_are_moved_in_its_tables(client: Client) -> None:
    known = {row["name"]: row for row in client.answer("/api/case", {"case": BUDD_DUX})["parameters"]}
    assert not {"s", "d", "body.spring"} & known.keys()  # a rigid mass has no waves; the spring is the stiffness
    for name, key in (("gap", "body.gap"), ("stiffness", "body.spring"), ("dashpot", "body.dashpot")):
        assert known[name]["movable"] and known[name]["slides"]
        moved = client.answer("/api/place", {"case": BUDD_DUX, "values": {name: 0.05}})
        assert value_at(moved["tables"], key) == 0.05


def test_what_is_about_free_bars_is_refused_in_words(client: Client) -> None:
    for path in ("blow", "report", "curves"):
        assert client.problems(f"/api/{path}", {"case": BUDD_DUX})[0]["message"]
    assert client.problems("/api/orbits", {"case": MODES, "label": "chatter/1"})[0]["key"] == "modes"
    many = {name: [1.0] * (MOST_MODES + 1) for name in ("damping", "contact", "drive")}
    many["omega"] = [1.0 + i for i in range(MOST_MODES + 1)]
    assert (
        client.problems("/api/case", {"case": {**MODES, "body": {"kind": "modes", **many}}})[0]["key"] == "body.omega"
    )
    named = {**MODES, "body": {"kind": "modes", "file": "/etc/passwd"}}
    assert client.problems("/api/case", {"case": named})[0]["key"] == "body.file"
