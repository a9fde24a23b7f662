"""Every question to the workbench: the answer of the command line or of the library, or a refusal by its key."""

from __future__ import annotations

import csv
import io
import json
import math
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("fastapi")

from percuss import case as cases
from percuss import steady_states
from percuss.case import MACHINES, Case, load_case, machine_answer, simulation_answer
from percuss.case.answers.exploring import orbits_answer as told
from percuss.case.answers.exploring import playback
from percuss.case.answers.exploring.diagram_answer import diagram_dict
from percuss.case.answers.exploring.quick_answer import quick_dict
from percuss.case.case import case_of, json_tables
from percuss.case.catalogue.sample_cases import STRUCTURES, machine_text, write_history
from percuss.case.file_format.reading import parsed, value_at
from percuss.case.parameters.description import case_dict
from percuss.cli import main
from percuss.errors import Interrupted
from percuss.halting import halting
from percuss.model import Load
from percuss.palette import palette_dict
from percuss.recordings.recording import read_recording
from percuss.stability import stability_plane
from percuss.web import Limits, Settings
from percuss.web.shared_by_routes import MOST_MODES
from web_client import Client, events

NAMES = [machine.name for machine in MACHINES if not machine.valve]
VALVES = ["valve-breaker", "valve-drifter", "oil-drifter", "oil-breaker"]
MINI: dict[str, Any] = {"machine": "mini-breaker"}
PLAIN = {
    "system": {"s": 20, "d": 0.0048, "restitution": 0.6},
    "load": {"kind": "harmonic", "mean": 0.9, "amplitude": 1.0},
}
RIGID = {
    "system": {"s": 5.0, "d": 0.0, "restitution": 0.5},
    "load": {"kind": "harmonic", "mean": 0.62, "amplitude": 1.0},
}
MEAN = {"name": "mean", "from": 0.3, "to": 1.2}
PLANE = {
    "x": {"name": "restitution", "from": 0.0, "to": 0.9, "count": 7},
    "y": {"name": "load_factor", "from": 0.05, "to": 1.0, "count": 5},
}
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


@pytest.fixture(scope="module")
def client() -> Client:
    return Client(Settings(limits=Limits(seconds=300.0)))  # on a machine on which the kernels are not compiled, too


def printed(capsys: pytest.CaptureFixture[str], *arguments: str) -> Any:
    assert main(list(arguments)) == 0
    return json.loads(capsys.readouterr().out)


def streamed(client: Client, path: str, asked: Any) -> list[tuple[str, Any]]:
    """The events of an answer."""
    found = client.post(f"/api/{path}", asked)
    assert found.status_code == 200, found.text
    assert found.headers["content-type"].startswith("text/event-stream")
    return events(found.text)


def answered(client: Client, path: str, asked: Any) -> Any:
    """What a route answers, as JSON: of frames the answer of the command line, of a stream the last event."""
    found = client.post(f"/api/{path}", asked)
    assert found.status_code == 200, found.text
    if path in ("blow", "machine"):
        return {**client.arrays(f"/api/{path}", asked)[0]["answer"], "case": ""}
    if found.headers["content-type"].startswith("text/event-stream"):
        seen = events(found.text)
        assert [name for name, _ in seen] == ["progress"] * (len(seen) - 1) + ["done"]
        return seen[-1][1]
    return found.json()


# -- what the command line prints, and what the library answers -----------------------------------------------------

COMMANDS: list[tuple[str, dict[str, Any], str]] = [
    *(("steady", {"machine": name, "periods": [2, 1]}, f"steady {name} --periods 1,2") for name in
      ("hydraulic-drifter", "mini-breaker", "laboratory-striker")),
    ("simulate", {**MINI, "start": {"position": -0.5}, "simulation": {"modes": 4}, "events": 7},
     "simulate mini-breaker --modes 4 --start position=-0.5 --events last:7"),
    *(("blow", {"machine": name, "frames": 31, "cells": 20}, f"blow {name}") for name in
      ("laboratory-striker", "mini-breaker")),
    ("machine", {"machine": "valve-drifter", "modes": 0, "points": 2}, "machine valve-drifter --modes 0"),
    ("follow", {**MINI, "along": {"name": "restitution", "from": 0.3, "to": 0.4}, "modes": 0},  # beside the case's own
     "follow mini-breaker --along restitution=0.3:0.4 --modes 0"),
    ("experiment", {**MINI, "starts": 150, "modes": 0, "seed": 3, "distribution": "field"},
     "experiment mini-breaker --starts 150 --modes 0 --seed 3 --distribution field"),
]  # fmt: skip


@pytest.mark.parametrize(("path", "asked", "command"), COMMANDS, ids=lambda part: part if isinstance(part, str) else "")
def test_an_answer_is_what_the_command_line_prints(
    client: Client, path: str, asked: Any, command: str, capsys: pytest.CaptureFixture[str]
) -> None:
    wanted = printed(capsys, *command.split(), "--json")
    assert answered(client, path, asked) == (wanted if path not in ("blow", "machine") else {**wanted, "case": ""})


_Z21 = "2/1:phases=0.39,2.32"
_STRIKER = {"machine": "laboratory-striker", "modes": 0}
_DRIFTER = {"machine": "valve-drifter", "modes": 0}
_SCALE = {"name": "scale", "from": 0.8, "to": 1.2}
_FEW = {"starts": 2, "runs": 1, "modes": 0}
_LINES = {"starts": 0, "runs": 0, "modes": 0, "up_to": "1/1", "searched": 1, "tries": 20}
LIBRARY: list[tuple[str, dict[str, Any], Callable[[Case], Any]]] = [
    *(("case", {"case": tables}, case_dict) for tables in (PLAIN, BUDD_DUX, MODES, IN_SI)),
    ("quick", MINI, quick_dict),
    ("orbits", {"case": RIGID, "label": "2/1", "modes": 0, "tries": 60},
     lambda case: told.orbits_dict(cases.orbits_answer(case, "2/1", modes=0, tries=60))),
    ("orbits", {**_STRIKER, "label": "chatter/1"},
     lambda case: told.rest_cycles_dict(cases.rest_cycles_answer(case, modes=0), "chatter/1")),
    ("follow", {"case": RIGID, "orbit": _Z21, "along": MEAN, "modes": 0, "switch": 1},
     lambda case: told.branch_dict(cases.branch_answer(case, _Z21, "mean=0.3:1.2", modes=0, switch=1))),
    ("follow", {**_STRIKER, "orbit": "chatter/1:1", "along": {"name": "load_factor", "from": 0.54, "to": 0.61}},
     lambda case: told.branch_dict(cases.branch_answer(case, "chatter/1:1", "load_factor=0.54:0.61",
                                                                 modes=0))),
    ("follow", {**MINI, "along": {"name": "load.frequency", "unit": "Hz", "from": 16.0, "to": 19.0}, "modes": 2},
     lambda case: told.branch_dict(cases.branch_answer(case, "1/1", "load.frequency=16 Hz:19 Hz", modes=2))),
    ("orbits", {**_DRIFTER, "label": "1/1", "tries": 20},
     lambda case: told.orbits_dict(cases.orbits_answer(case, "1/1", modes=0, tries=20))),
    ("follow", {**_DRIFTER, "along": _SCALE},
     lambda case: told.branch_dict(cases.branch_answer(case, "1/1", "scale=0.8:1.2", modes=0))),
    ("diagram", {**_DRIFTER, "along": _SCALE, "values": 2, **_LINES},
     lambda case: diagram_dict(case, cases.diagram_answer(case, "scale=0.8:1.2:2", switch=1, **_LINES))),
    ("diagram", {"case": RIGID, "along": {"name": "mean", "from": 0.6, "to": 0.9}, "values": 4, **_FEW},
     lambda case: diagram_dict(case, cases.diagram_answer(case, "mean=0.6:0.9:4", up_to=None, impacts=2000, **_FEW))),
    ("diagram", {"case": RIGID, "along": {"name": "mean", "from": 0.6, "to": 0.9}, "values": 2, **_LINES},
     lambda case: diagram_dict(case, cases.diagram_answer(case, "mean=0.6:0.9:2", switch=1, **_LINES))),
]  # fmt: skip


@pytest.mark.parametrize(("path", "asked", "answer"), LIBRARY, ids=lambda part: part if isinstance(part, str) else "")
def test_an_answer_is_that_of_the_library(client: Client, path: str, asked: Any, answer: Callable[[Case], Any]) -> None:
    case = case_of(asked["case"]) if "case" in asked else load_case(asked["machine"])
    found, wanted = answered(client, path, asked), json.loads(json.dumps(answer(case)))
    if path == "case":
        found, wanted = {**found, "title": ""}, {**wanted, "title": ""}
    assert found == wanted


FRAMES: list[tuple[str, dict[str, Any], Callable[[Case], playback.Frames]]] = [
    ("motion", {**MINI, "orbit": 2, "frames": 40, "places": 9},
     lambda case: playback.orbit_playback(case, 2, frames=40, places=9)),
    ("motion", {**MINI, "simulation": {"modes": 4}, "show": "start", "cycles": 3},
     lambda case: playback.motion_playback(simulation_answer(case.changed(simulation={"modes": 4})).motion,
                                         settled=False, cycles=3)),
    ("blow", {**MINI, "whole": False}, lambda case: playback.blow_playback(case, whole=False)),
    ("machine", {"machine": "valve-breaker", "modes": 0, "whole": False},
     lambda case: playback.machine_playback(case, modes=0, whole=False)),
    ("machine/start", {"machine": "valve-breaker", "simulation": {"modes": 2}, "blows": 3, "points": 50},
     lambda case: playback.start_playback(simulation_answer(case.changed(simulation={"modes": 2})), 3, 50)),
]  # fmt: skip


@pytest.mark.parametrize(("path", "asked", "frames"), FRAMES, ids=lambda part: part if isinstance(part, str) else "")
def test_arrays_are_those_of_the_library(
    client: Client, path: str, asked: Any, frames: Callable[[Case], playback.Frames]
) -> None:
    header, arrays = client.arrays(f"/api/{path}", asked)
    wanted = frames(load_case(asked["machine"]))
    del header["arrays"]
    assert header == json.loads(json.dumps(wanted.header)) and arrays.keys() == wanted.arrays.keys()
    for name, values in wanted.arrays.items():
        np.testing.assert_allclose(arrays[name], values, rtol=1e-6, atol=1e-30)


# -- refusals -------------------------------------------------------------------------------------------------------

_BAD_VALVE = {"kind": "valve", "states": {"a": -1.0}, "ports": [{"to": "b", "on": "impact"}]}
_MANY = {name: [1.0 + i for i in range(MOST_MODES + 1)] for name in ("omega", "damping", "contact", "drive")}
_ELSEWHERE = {"name": "restitution", "from": 0.499, "to": 0.501}
_OVER = {"case": RIGID, "orbit": _Z21, "modes": 0, "x": _ELSEWHERE, "y": {**MEAN, "from": 0.55, "to": 0.7}}
_AT = {"case": RIGID, "name": "mean", "value": 0.62}
_ALL = {"case": RIGID, "along": MEAN, "values": 4, "starts": 2, "runs": 1, "modes": 0}
REFUSED: list[tuple[str, dict[str, Any], str]] = [
    ("case", {"toml": '[bar]\nlength = "1 m"\n[contact]\nrestitution = 0.1\n[load]\nkind = "history"\n'
              'file = "/etc/passwd"\n'}, "load.kind"),
    ("case", {"case": {**MODES, "body": {"kind": "modes", **_MANY}}}, "body.omega"),
    ("case", {"case": {**MODES, "body": {"kind": "modes", "file": "/etc/passwd"}}}, "body.file"),
    ("curves", {"case": PLAIN, "load_factor": [1.0, 0.5]}, "load_factor"),
    ("motion", {**MINI, "orbit": 3}, "orbit"),
    ("motion", {**MINI, "orbit": 2, "start": {}}, "orbit"),
    ("motion", {**MINI, "orbit": 2, "window": [0.2, 0.1]}, "window"),
    ("simulate", {**MINI, "start": {"position": 1.0}}, "start.position"),
    ("simulate", {**MINI, "start": {"orbit": 9}}, "start.orbit"),
    ("blow", {"case": {**PLAIN, "tool": {"impedance": -1.0}}}, "tool.impedance"),
    ("blow", {**MINI, "frames": 602}, "frames"),
    ("machine", MINI, "load.kind"),
    ("machine", {"case": {**PLAIN, "load": _BAD_VALVE}}, "load.ports[0].to"),
    ("machine/start", MINI, "load.kind"),
    ("machine/start", {"machine": "valve-breaker", "start": {"position": 0.1}}, "start.position"),
    ("machine/start", {"machine": "valve-breaker", "blows": 0}, "blows"),
    ("map", {"machine": "valve-breaker", "quantities": ["orbits"], **PLANE}, "quantities"),
    ("orbits", {"case": RIGID, "label": "x"}, "label"),
    ("orbits", {"case": RIGID, "label": "65/1"}, "impacts"),
    ("orbits", {"case": RIGID, "label": "2/1", "tries": 0}, "tries"),
    ("orbits", {"case": RIGID, "label": "chatter/x"}, "label"),
    ("follow", {"case": RIGID, "along": {**MEAN, "from": 2.0}}, "along"),
    ("follow", {"case": RIGID, "along": {**MEAN, "name": "what"}}, "parameter"),
    ("follow", {"case": RIGID, "along": {**MEAN, "unit": "Hz"}}, "mean"),
    ("follow", {"case": RIGID, "along": MEAN, "orbit": "1/1:9"}, "orbit"),
    ("follow", {"case": RIGID, "along": MEAN, "switch": 17}, "switch"),
    ("follow", {"case": RIGID, "along": MEAN, "orbit": "chatter/1:2"}, "orbit"),
    ("follow", {"case": RIGID, "along": MEAN, "orbit": "chatter/1", "switch": 1}, "switch"),
    ("follow/motion", _AT, "times"),
    ("follow/motion", {**_AT, "times": [1.0], "release": 1.0}, "times"),
    ("follow/motion", {**_AT, "release": 1.0, "modes": 0}, "release"),
    ("follow/motion", {**_AT, "times": []}, "times"),
    ("follow/motion", {**_AT, "times": [2.0, 1.0]}, "times"),
    ("follow/motion", {**_AT, "times": [0.0, 9.0], "periods": 1}, "times"),
    ("follow/motion", {**_AT, "name": "what", "times": [1.0]}, "parameter"),
    ("follow/motion", {**_AT, "value": 5.0, "times": [1.0], "modes": 0}, "times"),
    ("follow/curves", {**_OVER, "y": _ELSEWHERE}, "y"),
    ("follow/curves", {**_OVER, "x": {**_ELSEWHERE, "to": 0.1}}, "x"),
    ("diagram", {**_ALL, "up_to": "5/4"}, "up_to"),
    ("diagram", {**_ALL, "up_to": "x"}, "label"),
    ("diagram", {**_ALL, "starts": 0, "runs": 0}, "starts"),
    ("diagram", {**_ALL, "values": 400, "impacts": 20_000, "modes": 256, "starts": 32}, "values"),
    ("diagram", {**_ALL, "along": {**MEAN, "name": "what"}}, "parameter"),
    *((path, {"case": BUDD_DUX}, "") for path in ("blow", "curves")),
    *((path, {"machine": "valve-drifter", **more}, "load.kind") for path, more in [
        ("quick", {}), ("steady", {}), ("curves", {}), ("motion", {}),
        ("follow/motion", {"name": "scale", "value": 1.0, "times": [0.016]}),
        ("place", {"values": {"restitution": 0.2}})]),
    *((path, {"machine": "valve-drifter", "along": MEAN}, "parameter") for path in ("follow", "diagram")),
]  # fmt: skip


@pytest.mark.parametrize(
    ("path", "asked", "key"), REFUSED, ids=[f"{i} {path} {key}" for i, (path, _, key) in enumerate(REFUSED)]
)
def test_what_cannot_be_answered_is_said_by_its_key(client: Client, path: str, asked: Any, key: str) -> None:
    problem = client.problems(f"/api/{path}", asked)[0]
    assert problem["message"] and problem["key"].startswith(key)
    assert asked.get("machine") != "valve-drifter" or key != "load.kind" or "percuss machine" in problem["remedy"]


def test_all_problems_of_a_case_come_at_once_with_their_keys(client: Client) -> None:
    tables = json_tables(load_case("mini-breaker"))
    tables["bar"]["length"] = "34 kg"
    tables["contact"]["restitution"] = "much"
    tables["load"]["men"] = tables["load"].pop("mean")
    problems = client.problems("/api/case", {"case": tables})
    assert {problem["key"] for problem in problems} == {"bar.length", "contact.restitution", "load.men"}
    assert any("did you mean" in problem["remedy"] for problem in problems)
    text = client.problems("/api/case", {"toml": "[bar]\nlength = 3 mm\n"})
    assert "not valid TOML" in text[0]["message"]


# -- cases ----------------------------------------------------------------------------------------------------------


def test_about_and_the_catalogue(client: Client) -> None:
    about = client.get("/api/about").json()
    assert about["token"] is False and about["case"] is False
    assert about["limits"]["upload_bytes"] == 10_000_000
    assert about["palette"] == palette_dict() and len(about["palette"]["families"]) == 7
    assert {"stable", "label", "margin"} <= {quantity["name"] for quantity in about["quantities"]}
    assert about["materials"]["titanium"] == {"youngs_modulus_Pa": 114e9, "density_kg_m3": 4430.0}
    found = client.get("/api/machines").json()
    assert [machine["name"] for machine in found["machines"]] == [*NAMES, *VALVES]
    assert [machine["name"] for machine in found["machines"] if machine["valve"]] == VALVES
    assert [one["name"] for one in found["structures"]] == [one.name for one in STRUCTURES]


@pytest.mark.parametrize("name", [*NAMES, *VALVES, *(one.name for one in STRUCTURES)])
def test_a_sample_comes_as_a_case_of_the_same_hammer(client: Client, name: str) -> None:
    """A table of modes comes as its columns and a recording as its harmonics: what is asked next names no file."""
    found, case = client.get(f"/api/machines/{name}").json(), load_case(name)
    again = case_of(found["tables"])
    assert (found["history"] is None) == (name != "hydraulic-drifter")
    if case.is_machine:
        machine = case.machine()
        assert again.machine() == machine and found["system"] is None and found["scales"]["time_s"] == 1.0
        plain = case_of(found["plain"]).machine()
        assert plain.valve == machine.valve and plain.drag == machine.drag
        other = client.answer("/api/case", {"case": found["plain"]})
        assert other["bar"] is None and other["plain"]["load"] == found["plain"]["load"]
        asked = {**found["plain"], "load": {**found["plain"]["load"], "room": 2.0, "at": 0}}
        assert client.answer("/api/case", {"case": asked})["plain"]["load"]["room"] == 2.0
        assert found["bar"]["first_mode_Hz"] == pytest.approx(machine.body.s / 2.0, rel=1e-12)
        return
    system = case.system()
    assert again.system().body == system.body
    np.testing.assert_array_equal(again.system().load.coefficients, system.load.coefficients)
    assert case_of(parsed(found["toml"], "case")).system().body == system.body
    if found["plain"] is None:  # a structure
        return
    plain = case_of(found["plain"]).system()
    t = np.linspace(0.0, 6.0, 25)
    np.testing.assert_allclose(plain.load.value(t), system.load.value(t), rtol=1e-13)
    uniform = system.s * system.frequency * math.pi
    if len(found["tables"]["bar"].get("sections", ())) > 1:  # a heavy land holds a mode of higher frequency
        assert 1.1 * uniform < found["bar"]["first_mode_Hz"] < 1.5 * uniform
    else:
        assert found["bar"]["first_mode_Hz"] == pytest.approx(uniform, rel=1e-12)


def test_null_is_not_given(client: Client) -> None:
    tables = {**PLAIN, "start": None, "system": {**PLAIN["system"]}, "load": {**PLAIN["load"], "harmonic": None}}
    found = client.answer("/api/case", {"case": tables})
    assert "start" not in found["tables"] and "harmonic" not in found["tables"]["load"]


def test_a_place_is_the_case_with_these_values(client: Client) -> None:
    asked = {**MINI, "values": {"restitution": 0.25}}
    found = client.answer("/api/place", asked)
    assert found["tables"]["contact"] == {"restitution": 0.25}
    assert found == client.answer("/api/case", {"case": found["tables"]})
    quick = client.answer("/api/quick", asked)
    assert quick["tables"] == found["tables"] and quick["restitution"] == 0.25
    known = {row["name"]: row for row in client.answer("/api/case", {"case": BUDD_DUX})["parameters"]}
    assert not {"s", "d", "body.spring"} & known.keys()  # a rigid mass has no waves; the spring is the stiffness
    for name, key in (("gap", "body.gap"), ("stiffness", "body.spring"), ("dashpot", "body.dashpot")):
        assert known[name]["movable"] and known[name]["slides"]
        moved = client.answer("/api/place", {"case": BUDD_DUX, "values": {name: 0.05}})
        assert value_at(moved["tables"], key) == 0.05


def test_a_load_that_switches_is_told_with_its_clock(client: Client) -> None:
    """What the headline of the page takes its note from; one that does not switch has none."""
    square = {"kind": "square", "amplitude": 1.0, "kappa": 1.2}
    told = client.answer("/api/case", {"case": {**PLAIN, "load": square}})
    assert "as a valve does" in told["clock"] and told["clock"] in told["notes"]
    assert client.answer("/api/case", {"case": PLAIN})["clock"] == ""


# -- recordings -----------------------------------------------------------------------------------------------------


def test_an_upload_is_read_as_the_command_line_reads_it(client: Client, tmp_path: Any) -> None:
    write_history(tmp_path / "pressure.csv")
    data = (tmp_path / "pressure.csv").read_bytes()

    def ask(words: str, content: bytes = data) -> Any:
        return client.request("POST", f"/api/history?{words}", content=content)

    found = ask("name=C:\\\\x\\\\mine.CSV&area=6.5 cm^2").json()
    case = load_case("hydraulic-drifter")
    here = case_of({**json_tables(case), "load": found["load"]})
    np.testing.assert_array_equal(here.system().load.coefficients, case.system().load.coefficients)
    assert found["report"]["frequency"] == here.system().frequency
    assert set(ask("name=a.csv&area=1 cm^2&force_scale=1 kN").json()["load"]) == {"kind", "coefficients"}
    broken = ask("name=mine.csv", b"nothing,here\n")
    assert broken.status_code == 422 and "percuss-" not in broken.text
    for words, key in (("name=mine.csv", "load.area"), ("name=mine.exe", "load.file")):
        assert ask(words).status_code == 422 and ask(words).json()["problems"][0]["key"] == key


def test_two_faces_of_a_part_of_an_upload(client: Client) -> None:
    t = np.arange(5000) / 5000.0
    wave = np.cos(100.0 * np.pi * t)
    rows = "".join(f"{a:.4f},{60 + 140 * b:.6f},{40 - 20 * b:.6f}\n" for a, b in zip(t, wave, strict=True))
    asked = {"name": "two.csv", "column": "p1", "area": "6.5 cm^2", "opposing_column": "p2"}
    asked |= {"opposing_area": "4 cm^2", "from": "0.2 s", "to": "0.8 s"}
    content = b"t [s],p1 [bar],p2 [bar]\n" + rows.encode()
    found = client.request("POST", "/api/history", params=asked, content=content).json()
    assert found["report"]["cycles"] == 30
    load = case_of({**json_tables(load_case("hydraulic-drifter")), "load": found["load"]}).load()
    assert load.mean == pytest.approx(60e5 * 6.5e-4 - 40e5 * 4e-4, rel=1e-4)


def test_a_case_and_its_recording_are_taken_together(client: Client, tmp_path: Any) -> None:
    """What `percuss new hydraulic-drifter` writes: its TOML names a recording that lies beside it."""
    assert main(["new", "hydraulic-drifter", "-o", str(tmp_path / "drifter.toml")]) == 0
    text = (tmp_path / "drifter.toml").read_bytes()
    name = tomllib.loads(text.decode())["load"]["file"]
    record = (tmp_path / name).read_bytes()

    def ask(case: bytes, recording: bytes, name: str = name, length: int | None = None) -> Any:
        path = f"/api/case/recorded?name={name}&toml_bytes={len(case) if length is None else length}"
        return client.request("POST", path, content=case + recording)

    found, case = ask(text, record).json(), load_case("hydraulic-drifter")
    np.testing.assert_array_equal(case_of(found["tables"]).system().load.coefficients, case.system().load.coefficients)
    assert found["history"]["cycles"] == case.history_report.cycles and found["tables"]["load"]["kind"] == "fourier"
    assert any(name in note and "other.csv" in note for note in ask(text, record, "other.csv").json()["notes"])
    for refused, key in (
        (ask(text, b""), "toml_bytes"),
        (ask(text[:-1] + b"\xff", record), "toml_bytes"),
        (ask(text, b"nothing,here\n"), "load"),
        (ask(machine_text("mini-breaker").encode(), record, "a.csv"), "load.kind"),
        (ask(text.replace(b"[bar]", b'[bar]\ncolour = "red"'), record), "bar.colour"),
    ):
        assert refused.status_code == 422 and refused.json()["problems"][0]["key"].startswith(key)
    alone = client.problems("/api/case", {"toml": text.decode()})[0]
    assert alone["key"] == "load.kind" and "together" in alone["remedy"]


@pytest.mark.parametrize("name", ["A.MAT", "packed.hdf5"])
def test_packed_uploads_are_read_as_the_command_line_reads_them(client: Client, tmp_path: Any, name: str) -> None:
    h5py, scipy_io = pytest.importorskip("h5py"), pytest.importorskip("scipy.io")
    t = np.arange(1500) / 1000.0
    recorded = {"time": t, "force": 1e3 * (5.0 + 9.0 * np.cos(40.0 * np.pi * t))}
    path = tmp_path / name.lower()
    if path.suffix == ".mat":
        scipy_io.savemat(path, {**recorded, "note": "as measured", "more": {"a": [1.0]}}, do_compression=True)
    else:
        packing = {"compression": "gzip", "shuffle": True, "fletcher32": True, "chunks": (400,)}
        with h5py.File(path, "w") as content:
            for key, column in recorded.items():
                content.create_dataset(f"run/{key}", data=column, **packing)
    column = "run/force" if path.suffix == ".hdf5" else "force"
    clock = column.replace("force", "time")
    asked = {"name": name, "column": column, "unit": "N", "time_column": clock}
    found = client.request("POST", "/api/history", params=asked, content=path.read_bytes())
    assert found.status_code == 200, found.text
    tables = json_tables(load_case("hydraulic-drifter"))
    here = case_of({**tables, "load": found.json()["load"]}).system()
    history = read_recording(path, column=column, unit="N", time_column=clock)
    whole = Load.history(history.time, history.values)
    assert found.json()["report"]["frequency"] == whole.frequency
    np.testing.assert_allclose(here.force_scale * here.load.coefficients, whole.coefficients, rtol=1e-12, atol=1e-9)
    assert list(found.json()["notes"]) == list(history.notes)
    refused = client.request("POST", "/api/history", params={**asked, "column": "nothing"}, content=path.read_bytes())
    assert refused.status_code == 422 and "no column" in refused.json()["problems"][0]["message"]


# -- steady motions -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("multipliers", [False, True])
@pytest.mark.parametrize(
    "asked",
    [*({"machine": name} for name in ("hydraulic-drifter", "stepped-drifter", "pile-hammer")), {"case": BUDD_DUX}],
    ids=lambda asked: asked.get("machine") or asked["case"]["body"]["kind"],
)
def test_the_quick_answer_is_the_whole_one_but_for_rounding(client: Client, asked: Any, multipliers: bool) -> None:
    quick = client.answer("/api/quick", {**asked, "multipliers": multipliers})
    whole = client.answer("/api/steady", asked)["periods"][0]
    structure = "case" in asked
    keys = () if structure else ("m", "level", "level_max", "exists", "nearest", "note")
    assert {key: quick[key] for key in keys} == {key: whole[key] for key in keys}
    for one, other in zip(quick["orbits"], whole["orbits"], strict=True):
        for key in ("phase", "impact_velocity", "stable", *(() if structure else ("rigid_velocity", "reduced"))):
            assert one[key] == other[key]
        if structure:
            continue
        assert one["waveform"] == other["waveform"]
        assert one["margin"] == pytest.approx(other["margin"], abs=1e-12)
        assert one["multipliers"]["dominant_mode"] == other["multipliers"]["dominant_mode"]
        for key, value in one["si"].items():
            assert value == pytest.approx(other["si"][key], rel=1e-14)
        if multipliers:
            moduli = [math.hypot(*pair) for pair in one["multipliers"]["values"]]
            assert moduli == pytest.approx(other["multipliers"]["moduli"], abs=1e-12)
            assert one["reason"] == other["reason"]


def test_quick_at_a_jump_of_the_load_and_without_a_motion() -> None:
    square = case_of({**PLAIN, "load": {"kind": "square", "amplitude": 1.0, "kappa": 1.2}})
    for orbit in quick_dict(square)["orbits"]:
        assert orbit["reason"] and orbit["multipliers"]["values"]
    none = quick_dict(case_of({**PLAIN, "load": {"kind": "harmonic", "mean": 9.0, "amplitude": 1.0}}), curve=5)
    assert not none["exists"] and none["nearest"]["load_factor"] > 0.0 and len(none["curve"]["load"]) == 5


def test_curves_hold_the_roots_and_the_branches(client: Client) -> None:
    found = client.answer("/api/curves", {"case": PLAIN, "points": 181, "branches": 61})
    states = steady_states(case_of(PLAIN).system())
    np.testing.assert_allclose(found["rigid_velocity"], states.rigid_velocity(found["phase"]), atol=1e-12)
    assert found["level"] == states.level and found["force_N"] is None
    factors = np.array(found["branches"]["load_factor"])
    plane = stability_plane(states.system, 0.6, factors)
    mine = np.array(found["branches"]["phase"], dtype=float)
    np.testing.assert_array_equal(mine, plane.phase)
    assert factors[0] < found["branches"]["now"] < factors[-1]
    assert np.isnan(mine[:, -1]).all() and not np.isnan(mine[:, 0]).any()  # beyond the fold there is nothing
    assert [orbit["phase"] for orbit in found["waveform"]["orbits"]] == [orbit.phase for orbit in states.orbits]
    elastic = {**PLAIN, "system": {"s": 50, "d": 0, "restitution": 1}}
    assert client.answer("/api/curves", {"case": elastic, "branches": 5})["level"] == 0.0


# -- maps -----------------------------------------------------------------------------------------------------------


def test_a_map_is_what_the_command_line_prints(client: Client, capsys: pytest.CaptureFixture[str]) -> None:
    names = ["orbits", "stable", "margin", "phases"]
    told = printed(
        capsys, "sweep", "mini-breaker", "--x", "load_factor=0.05:1:5", "--y", "restitution=0:0.9:7", "--json",
        "--quantity", ",".join(names),
    )  # fmt: skip
    header, arrays = client.arrays("/api/map", {**MINI, **PLANE, "quantities": names})
    assert header["x"]["values"] == told["axes"][1]["values"] and header["y"]["values"] == told["axes"][0]["values"]
    for name in names:
        expected = np.array(told["quantities"][name]["values"], dtype=float)
        np.testing.assert_allclose(arrays[name], expected, rtol=1e-6, atol=1e-7)
        assert header["quantities"][name]["meaning"]
    assert [header["outcomes"][code] for code in arrays["outcome"].ravel()] == ["ok"] * 35


def test_maps_over_keys_with_units_and_of_words(client: Client) -> None:
    x = {"name": "bar.length", "unit": "mm", "values": [300.0, 320.0, 340.0]}
    asked = {**MINI, "x": x, "y": PLANE["y"], "quantities": ["reason", "blow_energy", "admissible"]}
    header, arrays = client.arrays("/api/map", asked)
    assert arrays["blow_energy"].shape == (5, 3) and header["quantities"]["blow_energy"]["unit"] == "J"
    assert "flip" in header["quantities"]["reason"]["words"]
    small = {"x": {**PLANE["x"], "count": 2}, "y": {**PLANE["y"], "count": 2}, "quantities": ["label"]}
    header, arrays = client.arrays("/api/map", {"case": PLAIN, **small, "modes": 0, "impacts": 200})
    assert all(header["quantities"]["label"]["words"][i] for i in arrays["label"].ravel())


def test_boundaries_bound_the_map(client: Client) -> None:
    asked = {"case": PLAIN, "x": {**PLANE["x"], "count": 4}, "y": {"name": "load_factor", "from": 0.02, "to": 2.0}}
    found = client.answer("/api/boundaries", asked)
    fold = next(curve for curve in found["curves"] if curve["kind"] == "fold")
    system = case_of(PLAIN).system()
    for r, factor in zip(fold["x"], fold["y"], strict=True):
        if factor is not None:
            plane = stability_plane(system, r, [0.999 * factor, 1.001 * factor])
            assert plane.roots.tolist() == [2, 0]


def test_the_map_of_a_machine_is_that_of_its_cases(client: Client) -> None:
    named = {row["name"]: row for row in client.get("/api/machines/valve-breaker").json()["parameters"]}
    assert "load.scale" not in named  # the pressure is the same
    assert named["load.ports[0].behind"]["label"] == "port 1 → power: place"
    assert (named["contact.restitution"]["low"], named["load.pressure"]["unit"]) == (0.0, "bar")
    x = {"name": "load.ports[0].behind", "unit": "mm", "values": [70, 130]}
    y = {"name": "load.pressure", "unit": "bar", "values": [80.0, 120.0, 160.0]}
    asked = {"machine": "valve-breaker", "x": x, "y": y, "quantities": ["stall", "blow_energy", "rate"], "modes": 0}
    header, arrays = client.arrays("/api/map", asked)
    assert header["quantities"]["stall"]["words"][:3] == ["runs", "no loss", "stays on the wall"]
    case = load_case("valve-breaker")
    for j, pressure in enumerate(y["values"]):
        for i, place in enumerate(x["values"]):
            other = case.varied({"load.ports[0].behind": f"{place} mm", "load.pressure": f"{pressure} bar"})
            answer = machine_answer(other, 0)
            assert (arrays["stall"][j, i] == 0) == answer.runs
            energy = answer.to_json_dict()["si"]["blow_energy_J"] if answer.runs else math.nan
            assert arrays["blow_energy"][j, i] == pytest.approx(energy, rel=1e-9, nan_ok=True)


# -- motions --------------------------------------------------------------------------------------------------------


def test_frames_of_an_orbit_are_its_fields(client: Client) -> None:
    asked = {**MINI, "orbit": 2, "frames": 40, "places": 9, "end_points": 300, "cycles": 2}
    header, arrays = client.arrays("/api/motion", asked)
    orbit = steady_states(load_case("mini-breaker").system()).orbits[1]
    assert header["period"] == orbit.period and header["begin"] == orbit.phase
    t = np.linspace(0.0, 2.0 * orbit.period, 40)
    field = orbit.field(np.linspace(0.0, 1.0, 9), t)
    np.testing.assert_allclose(arrays["displacement"], field.displacement.T, rtol=2e-6, atol=1e-7)
    np.testing.assert_allclose(arrays["strain"], field.strain.T, rtol=2e-5, atol=1e-9)
    assert np.nanmax(arrays["end_gap"]) < 1e-6 and np.isnan(arrays["end_velocity"]).sum() == 2
    assert [blow["kind"] for blow in header["blows"]] == ["impact"] * 3
    scale = load_case("mini-breaker").system().energy_scale
    assert header["blows"][0]["energy_J"] == pytest.approx(scale * orbit.delivered_energy)
    zoomed, close = client.arrays("/api/motion", {**asked, "window": [0.1, 0.2]})
    assert close["t"][0] == np.float32(0.1) and close["t"][-1] == np.float32(0.2)
    assert zoomed["blows"] == header["blows"]


@pytest.mark.parametrize("tables", [BUDD_DUX, MODES, IN_SI], ids=["mounted", "modes", "si"])
def test_frames_of_a_structure_are_its_motion(client: Client, tables: Any) -> None:
    assert client.answer("/api/case", {"case": tables})["system"]["gap"] == pytest.approx(
        case_of(tables).system().body.gap
    )
    for i, full in enumerate(client.answer("/api/steady", {"case": tables})["periods"][0]["orbits"], 1):
        header, arrays = client.arrays("/api/motion", {"case": tables, "orbit": i})
        assert header["blows"][0]["impact_velocity"] == full["impact_velocity"]
        assert np.all(np.isfinite(arrays["displacement"])) and np.all(np.isfinite(arrays["strain"]))
        end = arrays["displacement"][:, -1]
        shown = np.interp(arrays["t"], arrays["end_t"][:-1], arrays["end_gap"][:-1])
        np.testing.assert_allclose(end - end[0], shown - shown[0], atol=0.01 * np.ptp(end))


@pytest.mark.parametrize(("show", "cycles"), [("start", 3), ("settled", 2)])  # what it settles on was followed for two
def test_frames_of_a_simulation_are_its_fields(client: Client, show: str, cycles: int) -> None:
    asked = {**MINI, "simulation": {"modes": 4}, "frames": 30, "places": 5, "cycles": cycles, "show": show}
    header, arrays = client.arrays("/api/motion", asked)
    motion = simulation_answer(load_case("mini-breaker").changed(simulation={"modes": 4})).motion
    assert header["label"] == motion.label == "z=1/1" and header["outcome"] == "periodic"
    t = np.linspace(header["begin"], min(header["end"], motion.end_time), 30)
    places = np.linspace(0.0, 1.0, 5)
    np.testing.assert_allclose(arrays["displacement"], motion.position(places, t).T, rtol=1e-5, atol=1e-6)
    assert header["end"] - header["begin"] == pytest.approx(2.0 * math.pi * cycles)
    inside = (motion.events.time >= header["begin"]) & (motion.events.time <= header["end"])
    assert len(header["blows"]) == int(inside.sum()) == np.isnan(arrays["end_velocity"]).sum()
    assert arrays["poincare_phase"].size == motion.impacts
    assert np.all(np.diff(arrays["end_t"]) >= 0.0)


@pytest.mark.parametrize(("restitution", "mean", "cycles"), [(0.2, 0.9, 1), (0.0, 0.44, 4), (0.4, 0.6, 32)])
def test_what_a_motion_settles_on_has_nothing_of_the_way_there(
    client: Client, restitution: float, mean: float, cycles: int
) -> None:
    """Of a rigid bar let go off the wall."""
    tables = {
        "system": {"s": 20, "d": 0.005, "restitution": restitution},
        "load": {"kind": "harmonic", "mean": mean, "amplitude": 1.0},
        "start": {"position": -0.5, "velocity": 0.0, "time": 0.3},
        "simulation": {"modes": 0, "impacts": 1500},
    }
    header, arrays = client.arrays("/api/motion", {"case": tables, "cycles": cycles, "frames": 97, "places": 2})
    motion = simulation_answer(case_of(tables, "test")).motion
    assert motion.cycle is not None and motion.cycle.periods == 1
    assert header["end"] - header["begin"] == pytest.approx(2.0 * math.pi * cycles, abs=1e-4)
    settled = motion.events.of("impact")[motion.cycle.first :]
    assert header["begin"] >= settled.time[0] - 1e-9
    cycle = np.linspace(settled.time[0], motion.end_time, 2000)
    assert arrays["end_gap"][np.isfinite(arrays["end_gap"])].min() >= motion.gap(cycle).min() - 1e-5
    blows = [blow for blow in header["blows"] if blow["kind"] == "impact"]
    assert len(blows) == cycles * motion.cycle.impacts + 1  # the one at the end is the first of the next cycle
    times = [blow["time"] for blow in blows]
    assert times[0] == 0.0 and times == sorted(times)
    speeds = np.array([blow["impact_velocity"] for blow in blows])
    np.testing.assert_allclose(speeds[motion.cycle.impacts :], speeds[: -motion.cycle.impacts], atol=1e-5)
    assert np.all(np.diff(arrays["end_t"]) >= 0.0) and arrays["end_t"][-1] == pytest.approx(arrays["t"][-1])
    assert header["summary"]["blow_rate"] == motion.summary.blow_rate


def test_frames_of_rest_chatter_and_departure(client: Client) -> None:
    chatter = {**PLAIN, "system": {**PLAIN["system"], "restitution": 0.2}}
    header, arrays = client.arrays("/api/motion", {"case": chatter, "simulation": {"modes": 0}, "cycles": 2})
    assert header["label"].startswith("chatter") and "rest" in {blow["kind"] for blow in header["blows"]}
    assert np.nanmax(arrays["end_gap"]) < 1e-6
    gone = {**PLAIN, "load": {"kind": "harmonic", "mean": -0.5, "amplitude": 1.0}}
    header, arrays = client.arrays("/api/motion", {"case": gone, "simulation": {"modes": 0}})
    assert header["outcome"] == "departed" and np.isfinite(arrays["displacement"]).all()


def test_a_motion_is_a_file_and_a_time_alone_does_not_ask_for_a_million_impacts(client: Client) -> None:
    file = client.post("/api/simulate/file", {**MINI, "simulation": {"modes": 4}})
    assert file.status_code == 200 and file.content[:4] == b"\x89HDF"
    found = client.answer("/api/simulate", {"case": PLAIN, "simulation": {"modes": 0, "time": 60.0, "periodic": False}})
    assert found["outcome"] == "time" and found["end_time"] == pytest.approx(60.0)


# -- blows ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["laboratory-striker", "mini-breaker"])
def test_frames_of_a_blow_keep_its_energy(client: Client, name: str) -> None:
    header, arrays = client.arrays("/api/blow", {"machine": name, "frames": 31, "cells": 20})
    assert header["sentence"].startswith("A blow of ") and header["units"] == "SI"
    times = np.linspace(0.0, 3e-4, 31)
    assert arrays["t"] == pytest.approx(times) and header["end"] == pytest.approx(3e-4)
    for body in ("striker", "rod"):
        cells = arrays[f"{body}_edges"].size - 1
        assert arrays[f"{body}_stress"].shape == arrays[f"{body}_velocity"].shape == (31, cells)
    parts = ("rigid", "vibration", "rod", "rock_dissipated", "rock_stored")
    whole = sum(arrays[f"energy_{part}"].astype(float) for part in parts)
    assert whole == pytest.approx(np.full(31, header["energy_before"]), rel=1e-5)
    touching = [any(begin <= t < (end or 1.0) for begin, end in header["contacts"]) for t in times]
    assert arrays["touching"].astype(bool).tolist() == touching and touching[0] and not touching[-1]


def test_a_blow_while_a_slider_moves_is_the_start_of_the_whole_one(client: Client) -> None:
    quick, fields = client.arrays("/api/blow", {**MINI, "whole": False})
    whole, others = client.arrays("/api/blow", MINI)
    assert quick["sentence"] is None and quick["answer"] is None and whole["answer"]["units"] == "SI"
    for name in ("striker_stress", "rod_stress", "rod_velocity", "energy_rod", "energy_rigid"):
        far = abs(fields[name] - others[name]) > 1e-5 * float(abs(others[name]).max())
        assert np.mean(far) < 1e-3, name  # a front may round to either cell


def test_a_blow_on_the_wall_and_a_dimensionless_one(client: Client) -> None:
    header, arrays = client.arrays("/api/blow", {"case": PLAIN, "show": "contact"})
    assert header["units"] == "dimensionless" and header["rod"] is None and "rod_stress" not in arrays
    assert header["striker"]["areas"] is None and "rigid wall" in header["notes"][0]
    struck = {**PLAIN, "tool": {"impedance": 1.5}, "blow": {"velocity": 1.0}}
    header, arrays = client.arrays("/api/blow", {"case": struck, "show": "window"})
    assert header["rod"]["end"] == "infinite" and header["rod"]["impedances"] == [30.0]
    assert float(arrays["face_force"].max()) == pytest.approx(20.0 * 1.5 / 2.5)  # Z Z'/(Z + Z') of the speed


def test_a_blow_tells_what_holds_its_tool(client: Client) -> None:
    tool = {"sections": [{"length": "0.4 m", "diameter": "40 mm", "attenuation": "0.01 1/m"}] * 3, "end": "rock"}
    joints = [{"at": 1, "kind": "contact", "slack": "0.1 mm"}, {"at": 2, "kind": "elastic", "stiffness": "2 GN/m"}]
    tables = {"tool": {**tool, "joints": joints, "bit_mass": "1.5 kg"}, "rock": {"stiffness": "200 kN/mm"}}
    case = {"bar": {"length": "0.3 m", "diameter": "40 mm"}, "blow": {"velocity": "8 m/s"}, **tables}
    case |= {"load": IN_SI["load"], "contact": {"restitution": 0.3}}
    rod = client.arrays("/api/blow", {"case": case, "show": "contact"})[0]["rod"]
    assert rod["feed"] is None and rod["attenuation"] == [0.01] * 3 and rod["bit_mass"] == 1.5
    contact, elastic = rod["joints"]
    assert (contact["at"], contact["kind"], contact["slack"], len(contact["opens"]) > 0) == (1, "contact", 1e-4, True)
    assert (elastic["at"], elastic["kind"], elastic["stiffness"]) == (2, "elastic", 2e9)
    rod = client.arrays("/api/blow", {"machine": "drill-string", "whole": False})[0]["rod"]
    assert rod["feed"] == {"force": 8e3, "at": 0, "stiffness": 0.0, "damping": 0.0}
    assert [(one["at"], one["mass"]) for one in rod["joints"]] == [(2, 1.8)]


# -- machines that switch themselves --------------------------------------------------------------------------------


@pytest.mark.parametrize(("name", "energy", "rate"), [("valve-breaker", 3751.0, 9.448), ("valve-drifter", 301.1, 61.2)])
def test_a_cycle_over_time(client: Client, name: str, energy: float, rate: float) -> None:
    header, arrays = client.arrays("/api/machine", {"machine": name, "modes": 0, "points": 101, "whole": False})
    answer = header["answer"]
    assert answer["si"]["blow_energy_J"] == pytest.approx(energy, rel=1e-3)
    assert answer["si"]["blow_rate_Hz"] == pytest.approx(rate, rel=1e-3)
    assert header["runs"] and header["sentence"] is None and header["units"] == "SI"
    t, centre = arrays["t"].astype(float), arrays["centre"].astype(float)
    assert t[0] == 0.0 and t[-1] == pytest.approx(answer["period"]) and np.all(np.diff(t) >= 0.0)
    assert centre.min() == pytest.approx(-answer["si"]["stroke_m"], rel=1e-3)
    assert arrays["striking_end"].max() <= 1e-6
    speed = arrays["velocity"].astype(float)
    assert speed[-1] == pytest.approx(answer["si"]["impact_velocity_m_s"], rel=0.03)
    taken = np.trapezoid(arrays["force"].astype(float), centre)  # what the blows and the drag take
    assert taken == pytest.approx(1e3 * answer["si"]["input_power_kW"] * answer["period"], rel=1e-3)
    assert header["states"] == ["return", "power"] and set(arrays["state"].tolist()) == {0, 1}
    pushes = arrays["force"][arrays["state"] == 1]
    assert pushes.min() > 0.0 > arrays["force"][arrays["state"] == 0].max()


def test_a_machine_that_does_not_run_says_what_it_would_need(client: Client) -> None:
    tables = client.get("/api/machines/valve-breaker").json()["tables"]
    tables["load"]["chamber"]["stiffness"] = "140 kN/m"
    header, arrays = client.arrays("/api/machine", {"case": tables, "whole": False})
    assert arrays == {} and not header["runs"] and header["answer"]["period"] is None
    assert "58.29 mm behind the tool, and the port is at 130 mm" in header["sentence"]
    assert header["answer"]["failed_condition"]["remedy"].startswith("put the port nearer")
    assert header["modes"] == 32


def test_a_machine_on_its_pump_has_the_modes_and_the_report_that_are_asked_for(client: Client) -> None:
    tables = client.get("/api/machines/valve-breaker").json()["tables"]
    tables["load"]["supply"] = {"flow": "133 l/min", "accumulator": "2.5 cm^3/bar"}
    page = client.post("/api/report", json={"case": tables, "modes": 2, "simulate": True}).text
    assert "Simulated motion" in page and page.count("<svg") == 4  # to scale, its cycle, the motion, its blow
    header, arrays = client.arrays("/api/machine", {"case": tables, "modes": 4, "whole": False})
    assert header["runs"] and header["modes"] == 4
    pushing = arrays["force"][arrays["state"] == 1].astype(float)
    assert pushing.max() > 1.1 * pushing.min()  # the pressure falls while the piston draws


def test_a_machine_from_its_start_is_the_simulated_motion() -> None:
    motion = simulation_answer(load_case("valve-breaker").changed({"position": -0.1}, {"modes": 2}))
    frames, moved = playback.start_playback(motion, 3, 50), motion.motion
    t, states = frames.arrays["t"], frames.header["states"]
    assert frames.header["label"] == moved.label
    assert np.all(np.diff(t) >= 0.0) and t[0] == 0.0 and t[-1] == moved.blow_times[2]
    assert [blow["speed"] for blow in frames.header["answer"]["blows"]] == moved.blow_speeds[:3].tolist()
    assert frames.arrays["striking_end"] == pytest.approx(moved.gap(t) * moved.machine.length_scale, abs=1e-12)
    for change in moved.events.of("valve"):
        if change.time < t[-1]:
            first = int(np.flatnonzero(t == change.time)[0])
            before, after = (states[number] for number in frames.arrays["state"][[first - 1, first]])
            assert before != after == change.state


def test_a_machine_that_never_moves_has_a_start_of_no_blows() -> None:
    still = load_case("valve-breaker").varied({"load.chamber.force": "15 kN"}).changed({"position": 0.0}, {"modes": 0})
    frames = playback.start_playback(simulation_answer(still))
    assert frames.header["label"] == "stalls (on the tool)" and not frames.header["answer"]["blows"]
    assert np.all(frames.arrays["centre"] == 0.0) and np.all(np.isfinite(frames.arrays["velocity"]))


def test_the_search_for_a_cycle_can_be_given_up() -> None:
    with halting(lambda: True), pytest.raises(Interrupted):
        playback.machine_playback(load_case("valve-drifter"))


# -- branches -------------------------------------------------------------------------------------------------------


def test_the_motion_at_every_place_of_a_branch_has_its_impacts(client: Client) -> None:
    """The z=2/1 of shared systems of the tests: two impacts in one load period, through a flip and a fold."""
    asked = {"case": RIGID, "orbit": _Z21, "along": MEAN, "modes": 0, "switch": 1}
    followed = client.answer("/api/follow", asked)
    assert {point["type"] for point in followed["points"]} == {"grazing_impact_dies", "flip", "fold", "grazing_touch"}
    for branch in [followed, *followed["switched"]]:
        rows, periods = branch["branch"], int(branch["label"].split("/")[1])
        for i in range(1, len(rows["value"]) - 1, 5):
            asked = {"case": RIGID, "name": "mean", "modes": 0, "frames": 90, "periods": periods}
            place = {"value": rows["value"][i], "times": rows["times"][i]}
            header, arrays = client.arrays("/api/follow/motion", {**asked, **place})
            assert header["label"] == branch["label"] and header["orbit"]["admissible"]
            assert header["orbit"]["stable"] == rows["stable"][i]
            assert header["period"] == pytest.approx(2.0 * math.pi * periods)
            assert header["end"] - header["begin"] == pytest.approx(header["period"], abs=1e-9)
            speeds = sorted(blow["impact_velocity"] for blow in header["blows"])
            np.testing.assert_allclose(speeds, sorted(rows["speeds"][i]), atol=1e-9)
            assert np.nanmax(arrays["end_gap"]) < 1e-6  # never beyond the wall
            assert arrays["displacement"][0, -1] == pytest.approx(arrays["displacement"][-1, -1], abs=1e-6)
            assert float(arrays["load"].mean()) == pytest.approx(rows["value"][i], abs=0.02)


def test_cycles_with_rest_are_told_like_orbits_and_seen_to_move(client: Client) -> None:
    along = {"name": "load_factor", "from": 0.54, "to": 0.61}
    found = client.answer("/api/follow", {**_STRIKER, "orbit": "chatter/1:1", "along": along})
    of_orbits = client.answer("/api/follow", {"case": RIGID, "orbit": _Z21, "along": MEAN, "modes": 0})
    assert found.keys() == of_orbits.keys() and {point["type"] for point in found["points"]} == {"onset", "limit"}
    for point in found["points"]:
        assert point.keys() == of_orbits["points"][0].keys()
        assert point["orbit"].keys() == {*of_orbits["points"][0]["orbit"], "release_phase", "rest_phase"}
    rows = found["branch"]
    assert [sum(each) for each in rows["impacts"]] == [len(times) for times in rows["times"]]
    for i in range(0, len(rows["value"]), 12):
        place = {"value": rows["value"][i], "release": rows["release_phases"][i][0]}
        header, arrays = client.arrays("/api/follow/motion", {**_STRIKER, "name": "load_factor", **place, "cycles": 2})
        assert header["label"] == "chatter/1" and header["end"] - header["begin"] == pytest.approx(4.0 * math.pi)
        kinds = [blow["kind"] for blow in header["blows"]]
        struck = [blow["time"] + header["begin"] for blow in header["blows"] if blow["kind"] == "impact"]
        assert kinds[0] == "release" and kinds[-2:] == ["chatter", "rest"]
        assert struck[:3] == pytest.approx(rows["times"][i][:3], abs=1e-9)
        assert np.nanmax(arrays["end_gap"]) < 1e-9


def test_an_impact_that_dies_of_a_cycle_with_rest_is_told_by_its_number() -> None:
    load = {"kind": "fourier", "coefficients": [[0.711, 0.0], [1.0, 0.0], [1.52, 0.81]]}
    case = case_of({"system": {"s": 5.0, "d": 0.0, "restitution": 0.0}, "load": load})
    found = told.branch_dict(cases.branch_answer(case, "rest/1", "mean=0.6:0.711", modes=0))
    death, end = found["points"]
    assert (death["type"], death["impact"], death["touch_phase"]) == ("grazing_impact_dies", 1, None)
    assert death["orbit"]["impacts"][0]["speed"] < 1e-5
    assert (end["type"], end["impact"]) == ("limit", None)


def test_the_motion_at_a_key_of_the_case_is_told_in_its_unit(client: Client) -> None:
    along = {"name": "load.frequency", "unit": "Hz", "from": 16.0, "to": 19.0}
    rows = client.answer("/api/follow", {**MINI, "along": along, "modes": 2})["branch"]
    asked = {**MINI, "name": "load.frequency", "unit": "Hz", "value": rows["value"][2], "modes": 2}
    header, _ = client.arrays("/api/follow/motion", {**asked, "times": rows["times"][2], "cycles": 3})
    assert [blow["time"] for blow in header["blows"]] == pytest.approx([2.0 * math.pi * k for k in (1, 2, 3)], abs=1e-8)
    assert header["time_scale_s"] == pytest.approx(1.0 / (2.0 * math.pi * rows["value"][2]))


def test_curves_over_a_plane_are_those_of_the_command_line_and_each_is_told_once(client: Client) -> None:
    case, up, across = case_of(RIGID), "mean=0.55:0.7", "restitution=0.499:0.501"
    seen = answered(client, "follow/curves", _OVER)["curves"]
    branch = cases.branch_answer(case, _Z21, up, modes=0)
    curves = told.branch_dict(branch, cases.point_curves_answer(case, branch, "all", up, across))["curves"]
    assert len(curves) > 1 and seen[: len(curves)] == curves
    places = [(one["type"], np.array(one["curve"]["values"]).mean(axis=0).round(4).tolist()) for one in seen]
    assert len({str(place) for place in places}) == len(places)
    wrong = streamed(client, "follow/curves", {**_OVER, "orbit": "1/1:9"})
    assert [kind for kind, _ in wrong] == ["error"] and wrong[0][1]["problems"][0]["key"] == "orbit"


def test_the_onset_of_a_rest_is_followed_over_a_plane(client: Client) -> None:
    resting = {
        "system": {"s": 5.0, "d": 0.001, "restitution": 0.0},
        "load": {"kind": "harmonic", "mean": 0.31, "amplitude": 1.0},
    }
    plane = {"x": {"name": "d", "from": 0.0, "to": 0.002}, "y": {"name": "mean", "from": 0.3, "to": 0.32}}
    (curve,) = answered(client, "follow/curves", {"case": resting, "orbit": "rest/1", "modes": 0, **plane})["curves"]
    assert (curve["type"], curve["label"]) == ("onset", "rest/1")  # which both lines meet
    assert curve["curve"]["values"][-1] == pytest.approx([0.303314471053, 0.0], abs=1e-9)
    assert curve["curve"]["event_phases"] == pytest.approx(curve["curve"]["release_phases"])


# -- questions about the whole hammer -------------------------------------------------------------------------------

BLOWS = "time [s],rebound speed [m/s]\n" + "".join(
    f"{0.106 * i + 1e-4 * (i % 3)},{1.4 + 0.01 * (i % 5)}\n" for i in range(60)
)
HAMMERS: list[tuple[dict[str, Any], str]] = [
    ({"question": "design", "vary": ["load.ports[0].behind=8:24mm", "bar.diameter=46:52mm"], "hammers": 40, "modes": 0,
      "limits": ["blow_rate=60..64 Hz", "flow<70 l/min"], "figure": "power", "plane": True},
     "design valve-drifter --vary load.ports[0].behind=8:24mm --vary bar.diameter=46:52mm --hammers 40 --modes 0 "
     "--most power --want blow_rate=60..64Hz --below flow=70l/min"),
    ({"question": "tolerance", "vary": ["load.pressure=±5%"], "hammers": 64, "modes": 0},
     "tolerance valve-drifter --vary load.pressure=±5% --samples 64 --modes 0"),
    ({"question": "compare", "beside": ["valve-breaker"], "modes": 0}, "compare valve-drifter valve-breaker --modes 0"),
    ({"question": "compare", "beside": ["contact.restitution=0.3, load.pressure=150bar"], "modes": 0},
     "compare valve-drifter --set contact.restitution=0.3,load.pressure=150bar --modes 0"),
    ({"question": "identify", "blows": BLOWS, "vary": ["load.pressure", "contact.restitution"], "modes": 0},
     "identify valve-drifter --blows blows.csv --vary load.pressure --vary contact.restitution --modes 0"),
    ({"question": "fatigue"}, "blow valve-drifter --fatigue"),
]  # fmt: skip


@pytest.mark.parametrize(("asked", "command"), HAMMERS, ids=[asked["question"] for asked, _ in HAMMERS])
def test_a_question_about_the_whole_hammer_is_answered_as_by_its_command(
    client: Client, asked: dict[str, Any], command: str, tmp_path: Path, monkeypatch: Any, capsys: Any
) -> None:
    machine = "valve-breaker" if asked["question"] == "identify" else "valve-drifter"
    found = answered(client, "hammer", {"machine": machine, **asked})
    assert all(one["svg"].startswith("<svg") for one in found["pictures"])
    assert len(found["pictures"]) == (2 if asked.get("plane") else 1)
    told = {cell for section in found["sections"] for row in section["rows"] for cell in row}
    monkeypatch.chdir(tmp_path)
    Path("blows.csv").write_text(BLOWS)
    assert main(command.replace("identify valve-drifter", "identify valve-breaker").split()) == 0
    printed = " ".join(capsys.readouterr().out.split())
    assert found["summary"] in printed
    assert sum(" ".join(cell.split()) in printed for cell in told) > 0.8 * len(told)
    takes = asked["question"] in ("design", "identify")
    assert (found["case"] is not None) is takes
    if takes:
        assert answered(client, "case", {"case": found["case"]["tables"]})["tables"] == found["case"]["tables"]


@pytest.mark.parametrize(
    ("asked", "told"),
    [
        ({"question": "design"}, "one range or more"),
        ({"question": "design", "vary": ["bar.length=1:2:3"]}, "NAME=LOW:HIGH"),
        ({"question": "design", "vary": ["bar.length=300:350mm"], "limits": ["speed<1"]}, "speed"),
        ({"question": "compare"}, "a machine of the catalogue, or other numbers"),
        ({"question": "compare", "beside": ["../valve-breaker.toml"]}, "a machine of the catalogue"),
        ({"question": "compare", "beside": ["load.kind=history,load.file=/etc/passwd"]}, "expected one of"),
        ({"question": "compare", "beside": ["start.position=-3 mm"]}, "expected one of"),
        ({"question": "identify", "blows": "a,b\n1,2\n"}, "no column of times"),
    ],
)  # fmt: skip
def test_a_question_that_cannot_be_answered_says_why(client: Client, asked: dict[str, Any], told: str) -> None:
    found = client.post("/api/hammer", {"machine": "valve-breaker", **asked})
    assert found.status_code == 422 and told in found.text, found.text


# -- experiments and reports ----------------------------------------------------------------------------------------


def test_an_experiment_is_told_while_it_is_followed_and_kept_as_a_file(client: Client) -> None:
    asked = {**MINI, "starts": 150, "modes": 0, "seed": 3, "distribution": "field"}
    seen = [data for name, data in streamed(client, "experiment", asked) if name == "progress"]
    done = [data["done"] for data in seen]
    assert done == sorted(done) and done[-1] == 150
    assert sum(share["share"] for share in seen[-1]["shares"]) == pytest.approx(1.0)
    text = client.post("/api/experiment/file", {**asked, "format": "csv"})
    rows = list(csv.reader(io.StringIO(text.text)))
    assert len(rows) == 151 and "attachment" in text.headers["content-disposition"]
    for kept, other in ((True, client), (False, Client())):  # of what was followed, and of what was not
        first = other.post("/api/experiment/file", {**asked, "format": "csv", "first": 23, "seed": 3 if kept else 4})
        again = other.post("/api/experiment/file", {**asked, "format": "csv", "seed": 3 if kept else 4})
        assert (again.text == text.text) is kept
        assert first.text.splitlines() == again.text.splitlines()[:24]
    assert client.post("/api/experiment/file", asked).content[:4] == b"\x89HDF"


def test_the_report_is_one_file_in_one_kind_of_units(client: Client) -> None:
    """Of a machine every speed and energy is in SI: none of them stands dimensionless beside it."""
    tables = json_tables(load_case("mini-breaker"))
    tables["title"] = '<script>alert("$x")</script> & $\\frac{'
    text = client.post("/api/report", {"case": tables, "simulate": True}).text
    assert "<script" not in text and text.count("<svg") == 4 and "default-src 'none'" in text
    system = load_case("mini-breaker").system()
    orbit = steady_states(system).orbits[-1]
    assert f"{orbit.impact_velocity * system.speed_scale:.4g} m/s" in text
    assert f"{orbit.impact_velocity:.4g} " not in text
    plain = client.post("/api/report", {"case": PLAIN}).text
    assert " m/s" not in plain and "at the striking end" in plain
