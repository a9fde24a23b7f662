"""Orbits, branches and the motions on them over HTTP: the numbers of the library, for every kind of parameter."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

pytest.importorskip("fastapi")

from percuss.case import (
    branch_answer,
    diagram_answer,
    load_case,
    orbits_answer,
    point_curves_answer,
    rest_cycles_answer,
)
from percuss.case.answers.exploring.diagram_answer import diagram_dict
from percuss.case.answers.exploring.orbits_answer import branch_dict, orbits_dict, rest_cycles_dict
from percuss.case.file_format.plain_tables import case_of
from percuss.web import Limits, Settings
from web_client import Client, events

RIGID = {
    "system": {"s": 5.0, "d": 0.0, "restitution": 0.5},
    "load": {"kind": "harmonic", "mean": 0.62, "amplitude": 1.0},
}
MEAN = {"name": "mean", "from": 0.3, "to": 1.2}


@pytest.fixture(scope="module")
def client() -> Client:
    return Client(Settings(limits=Limits(seconds=300.0)))  # on a machine on which the kernels are not compiled, too


@pytest.fixture(scope="module")
def followed(client: Client) -> Any:
    """The z=2/1 of shared systems of the tests: two impacts in one load period, through a flip and a fold."""
    asked = {"case": RIGID, "orbit": "2/1:phases=0.39,2.32", "along": MEAN, "modes": 0, "switch": 1}
    return client.answer("/api/follow", asked)


def test_the_answers_are_those_of_the_library(client: Client, followed: Any) -> None:
    case = case_of(RIGID)
    assert followed == branch_dict(branch_answer(case, "2/1:phases=0.39,2.32", "mean=0.3:1.2", modes=0, switch=1))
    assert {point["type"] for point in followed["points"]} == {"grazing_impact_dies", "flip", "fold", "grazing_touch"}
    found = client.answer("/api/orbits", {"case": RIGID, "label": "2/1", "modes": 0, "tries": 60})
    assert found == orbits_dict(orbits_answer(case, "2/1", modes=0, tries=60)) and len(found["orbits"]) == 2


def test_the_motion_at_every_place_of_a_branch_has_its_impacts(client: Client, followed: Any) -> None:
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


def test_cycles_with_rest_are_listed_followed_and_seen_to_move(client: Client, followed: Any) -> None:
    case = load_case("laboratory-striker")
    listed = client.answer("/api/orbits", {"machine": "laboratory-striker", "label": "chatter/1", "modes": 0})
    assert listed == rest_cycles_dict(rest_cycles_answer(case, modes=0), "chatter/1") and len(listed["orbits"]) == 1
    along = {"name": "load_factor", "from": 0.54, "to": 0.61}
    asked = {"machine": "laboratory-striker", "modes": 0}
    found = client.answer("/api/follow", {**asked, "orbit": "chatter/1:1", "along": along})
    assert found == branch_dict(branch_answer(case, "chatter/1:1", "load_factor=0.54:0.61", modes=0))
    assert found.keys() == followed.keys() and {point["type"] for point in found["points"]} == {"onset", "limit"}
    for point in found["points"]:
        assert point.keys() == followed["points"][0].keys()
        assert point["orbit"].keys() == {*followed["points"][0]["orbit"], "release_phase", "rest_phase"}
    rows = found["branch"]
    assert [sum(each) for each in rows["impacts"]] == [len(times) for times in rows["times"]]
    for i in range(0, len(rows["value"]), 12):
        place = {"value": rows["value"][i], "release": rows["release_phases"][i][0]}
        header, arrays = client.arrays("/api/follow/motion", {**asked, "name": "load_factor", **place, "cycles": 2})
        assert header["label"] == "chatter/1" and header["end"] - header["begin"] == pytest.approx(4.0 * math.pi)
        kinds = [blow["kind"] for blow in header["blows"]]
        struck = [blow["time"] + header["begin"] for blow in header["blows"] if blow["kind"] == "impact"]
        assert kinds[0] == "release" and kinds[-2:] == ["chatter", "rest"]
        assert struck[:3] == pytest.approx(rows["times"][i][:3], abs=1e-9)
        assert np.nanmax(arrays["end_gap"]) < 1e-9


def test_an_impact_that_dies_of_a_cycle_with_rest_is_told_by_its_number() -> None:
    load = {"kind": "fourier", "coefficients": [[0.711, 0.0], [1.0, 0.0], [1.52, 0.81]]}
    case = case_of({"system": {"s": 5.0, "d": 0.0, "restitution": 0.0}, "load": load})
    found = branch_dict(branch_answer(case, "rest/1", "mean=0.6:0.711", modes=0))
    death, end = found["points"]
    assert (death["type"], death["impact"], death["touch_phase"]) == ("grazing_impact_dies", 1, None)
    assert death["orbit"]["impacts"][0]["speed"] < 1e-5
    assert (end["type"], end["impact"]) == ("limit", None)


def test_a_key_of_the_case_is_followed_in_its_unit(client: Client) -> None:
    along = {"name": "load.frequency", "unit": "Hz", "from": 16.0, "to": 19.0}
    found = client.answer("/api/follow", {"machine": "mini-breaker", "along": along, "modes": 2})
    case = load_case("mini-breaker")
    assert found == branch_dict(branch_answer(case, "1/1", "load.frequency=16 Hz:19 Hz", modes=2))
    rows = found["branch"]
    asked = {"machine": "mini-breaker", "name": "load.frequency", "unit": "Hz", "value": rows["value"][2], "modes": 2}
    header, _ = client.arrays("/api/follow/motion", {**asked, "times": rows["times"][2], "cycles": 3})
    assert [blow["time"] for blow in header["blows"]] == pytest.approx([2.0 * math.pi * k for k in (1, 2, 3)], abs=1e-8)
    assert header["time_scale_s"] == pytest.approx(1.0 / (2.0 * math.pi * rows["value"][2]))


@pytest.mark.parametrize(
    "path, wrong, key",
    [
        ("orbits", {"label": "x"}, "label"),
        ("orbits", {"label": "65/1"}, "impacts"),
        ("orbits", {"label": "2/1", "tries": 0}, "tries"),
        ("follow", {"along": {**MEAN, "from": 2.0}}, "along"),
        ("follow", {"along": {**MEAN, "to": 0.5}}, "mean"),
        ("follow", {"along": {**MEAN, "name": "what"}}, "parameter"),
        ("follow", {"along": {**MEAN, "unit": "Hz"}}, "mean"),
        ("follow", {"along": MEAN, "orbit": "1/1:9"}, "orbit"),
        ("follow", {"along": MEAN, "switch": 17}, "switch"),
        ("orbits", {"label": "chatter/x"}, "label"),
        ("follow", {"along": MEAN, "orbit": "chatter/1:2"}, "orbit"),
        ("follow", {"along": MEAN, "orbit": "chatter/1", "switch": 1}, "switch"),
        ("follow/motion", {"name": "mean", "value": 0.62}, "times"),
        ("follow/motion", {"name": "mean", "value": 0.62, "times": [1.0], "release": 1.0}, "times"),
        ("follow/motion", {"name": "mean", "value": 0.62, "release": 1.0, "modes": 0}, "release"),
        ("follow/motion", {"name": "mean", "value": 0.62, "times": []}, "times"),
        ("follow/motion", {"name": "mean", "value": 0.62, "times": [2.0, 1.0]}, "times"),
        ("follow/motion", {"name": "mean", "value": 0.62, "times": [0.0, 9.0], "periods": 1}, "times"),
        ("follow/motion", {"name": "what", "value": 0.62, "times": [1.0]}, "parameter"),
        ("follow/motion", {"name": "mean", "value": 5.0, "times": [1.0], "modes": 0}, "times"),
    ],
)
def test_what_cannot_be_answered_is_said_by_its_key(client: Client, path: str, wrong: Any, key: str) -> None:
    assert client.problems(f"/api/{path}", {"case": RIGID, **wrong})[0]["key"] == key


def test_a_machine_that_switches_itself_has_no_branches(client: Client) -> None:
    for path, more in (("orbits", {"label": "1/1"}), ("follow", {"along": MEAN})):
        assert client.problems(f"/api/{path}", {"machine": "valve-drifter", **more})[0]["message"]


def streamed(client: Client, path: str, asked: Any) -> list[tuple[str, Any]]:
    """The events of an answer."""
    found = client.post(path, asked)
    assert found.status_code == 200, found.text
    return events(found.text)


def test_what_simulations_settle_on_is_told_while_it_comes_in(client: Client) -> None:
    along = {"name": "mean", "from": 0.6, "to": 0.9}
    asked = {"case": RIGID, "along": along, "values": 4, "starts": 2, "runs": 1, "modes": 0}
    told = streamed(client, "/api/diagram", asked)
    assert [kind for kind, _ in told] == ["progress", "progress", "done"]
    case = case_of(RIGID)
    whole = diagram_answer(case, "mean=0.6:0.9:4", up_to=None, starts=2, runs=1, modes=0, impacts=2000)
    assert told[-1][1] == diagram_dict(case, whole)
    assert {one["label"] for one in told[-1][1]["settled"]} >= {"z=1/1"}
    lines = {"values": 2, "starts": 0, "runs": 0, "up_to": "1/1", "searched": 1, "tries": 20}
    told = streamed(client, "/api/diagram", {**asked, **lines})
    whole = diagram_answer(
        case, "mean=0.6:0.9:2", up_to="1/1", searched=1, tries=20, switch=1, starts=0, runs=0, modes=0
    )
    assert [kind for kind, _ in told] == ["progress", "done"]
    assert told[-1][1] == diagram_dict(case, whole) and len(told[-1][1]["branches"]) > 1
    assert client.problems("/api/diagram", {**asked, "up_to": "5/4"})[0]["key"] == "up_to"
    assert client.problems("/api/diagram", {**asked, "up_to": "x"})[0]["key"] == "label"
    assert client.problems("/api/diagram", {**asked, "starts": 0, "runs": 0})[0]["key"] == "starts"
    assert client.problems("/api/diagram", {**asked, "values": 400, "impacts": 20_000, "modes": 256, "starts": 32})
    assert client.problems("/api/diagram", {**asked, "along": {**along, "name": "what"}})[0]["key"] == "parameter"
    assert client.problems("/api/diagram", {"machine": "valve-drifter", "along": along})


def test_curves_over_a_plane_are_those_of_the_command_line_and_each_is_told_once(client: Client) -> None:
    case, up, across = case_of(RIGID), "mean=0.55:0.7", "restitution=0.499:0.501"
    plane = {"x": {"name": "restitution", "from": 0.499, "to": 0.501}, "y": {"name": "mean", "from": 0.55, "to": 0.7}}
    asked = {"case": RIGID, "orbit": "2/1:phases=0.39,2.32", "modes": 0, **plane}
    told = streamed(client, "/api/follow/curves", asked)
    assert [kind for kind, _ in told[:-1]] == ["progress"] * (len(told) - 1) and told[-1][0] == "done"
    branch = branch_answer(case, "2/1:phases=0.39,2.32", up, modes=0)
    curves = branch_dict(branch, point_curves_answer(case, branch, "all", up, across))["curves"]
    assert len(curves) > 1 and told[-1][1]["curves"][: len(curves)] == curves
    places = [
        (one["type"], np.array(one["curve"]["values"]).mean(axis=0).round(4).tolist()) for one in told[-1][1]["curves"]
    ]
    assert len({str(place) for place in places}) == len(places)
    assert client.problems("/api/follow/curves", {**asked, "y": plane["x"]})[0]["key"] == "y"
    assert client.problems("/api/follow/curves", {**asked, "x": {**plane["x"], "to": 0.1}})[0]["key"] == "x"
    wrong = streamed(client, "/api/follow/curves", {**asked, "orbit": "1/1:9"})
    assert [kind for kind, _ in wrong] == ["error"] and wrong[0][1]["problems"][0]["key"] == "orbit"


def test_the_onset_of_a_rest_is_followed_over_a_plane(client: Client) -> None:
    resting = {
        "system": {"s": 5.0, "d": 0.001, "restitution": 0.0},
        "load": {"kind": "harmonic", "mean": 0.31, "amplitude": 1.0},
    }
    plane = {"x": {"name": "d", "from": 0.0, "to": 0.002}, "y": {"name": "mean", "from": 0.3, "to": 0.32}}
    told = streamed(client, "/api/follow/curves", {"case": resting, "orbit": "rest/1", "modes": 0, **plane})
    (curve,) = told[-1][1]["curves"]  # which both lines meet
    assert (curve["type"], curve["label"]) == ("onset", "rest/1")
    assert curve["curve"]["values"][-1] == pytest.approx([0.303314471053, 0.0], abs=1e-9)
    assert curve["curve"]["event_phases"] == pytest.approx(curve["curve"]["release_phases"])
