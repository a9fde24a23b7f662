"""Every endpoint of the workbench: what it answers, and that this is what the command line prints."""

from __future__ import annotations

import csv
import io
import json
import math
import time
import tomllib
from typing import Any

import numpy as np
import pytest

pytest.importorskip("fastapi")

from percuss import steady_states
from percuss.case import MACHINES, Case, load_case, machine_answer, simulation_answer
from percuss.case.answers.exploring.quick_answer import quick_dict
from percuss.case.answers.machine_answer import cycle_dict
from percuss.case.answers.playback import machine_frames, start_frames
from percuss.case.catalogue.sample_cases import machine_text, write_history
from percuss.case.file_format.plain_tables import case_of, json_tables, without_files
from percuss.case.parameters.description import parameters
from percuss.case.parameters.moves import placed
from percuss.cli import main
from percuss.errors import CaseError, Interrupted, ParameterError
from percuss.halting import halting
from percuss.model import Load
from percuss.palette import palette_dict
from percuss.recordings.recording import read_recording
from percuss.stability import stability_plane
from web_client import Client, events

NAMES = [machine.name for machine in MACHINES if not machine.valve]
VALVES = ["valve-breaker", "valve-drifter"]
PLAIN = {
    "system": {"s": 20, "d": 0.0048, "restitution": 0.6},
    "load": {"kind": "harmonic", "mean": 0.9, "amplitude": 1.0},
}
PLANE = {
    "x": {"name": "restitution", "from": 0.0, "to": 0.9, "count": 7},
    "y": {"name": "load_factor", "from": 0.05, "to": 1.0, "count": 5},
}


@pytest.fixture(scope="module")
def client() -> Client:
    return Client()


def printed(capsys: pytest.CaptureFixture[str], *arguments: str) -> Any:
    assert main(list(arguments)) == 0
    return json.loads(capsys.readouterr().out)


# -- cases ----------------------------------------------------------------------------------------------------------


def test_about_and_the_catalogue(client: Client) -> None:
    about = client.get("/api/about").json()
    assert about["token"] is False and about["case"] is False
    assert about["limits"]["upload_bytes"] == 10_000_000
    assert about["palette"] == palette_dict() and len(about["palette"]["families"]) == 7
    assert {"stable", "label", "margin"} <= {quantity["name"] for quantity in about["quantities"]}
    assert about["materials"]["titanium"] == {"youngs_modulus_Pa": 114e9, "density_kg_m3": 4430.0}
    machines = client.get("/api/machines").json()["machines"]
    assert [machine["name"] for machine in machines] == [*NAMES, *VALVES]
    assert [machine["name"] for machine in machines if machine["valve"]] == VALVES


@pytest.mark.parametrize("name", NAMES)
def test_a_machine_comes_as_a_case_of_the_same_system(client: Client, name: str) -> None:
    found = client.get(f"/api/machines/{name}").json()
    system = load_case(name).system()
    again = case_of(found["tables"])
    np.testing.assert_array_equal(again.system().load.coefficients, system.load.coefficients)
    assert again.system().s == system.s and found["scales"]["frequency_Hz"] == system.frequency
    assert Case.from_text(found["toml"]).system().d == system.d
    plain = case_of(found["plain"]).system()
    t = np.linspace(0.0, 6.0, 25)
    np.testing.assert_allclose(plain.load.value(t), system.load.value(t), rtol=1e-13)
    uniform = system.s * system.frequency * math.pi
    if "sections" in found["tables"]["bar"]:  # a heavy land between lighter ends holds a mode of higher frequency
        assert 1.1 * uniform < found["bar"]["first_mode_Hz"] < 1.5 * uniform
    else:
        assert found["bar"]["first_mode_Hz"] == pytest.approx(uniform, rel=1e-12)
    assert (found["history"] is None) == (name != "hydraulic-drifter")


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


def test_null_is_not_given(client: Client) -> None:
    tables = {**PLAIN, "start": None, "system": {**PLAIN["system"]}, "load": {**PLAIN["load"], "harmonic": None}}
    found = client.answer("/api/case", {"case": tables})
    assert "start" not in found["tables"] and "harmonic" not in found["tables"]["load"]


def test_a_history_is_no_part_of_a_case(client: Client) -> None:
    text = '[bar]\nlength = "1 m"\n[contact]\nrestitution = 0.1\n[load]\nkind = "history"\nfile = "/etc/passwd"\n'
    assert client.problems("/api/case", {"toml": text})[0]["key"] == "load.kind"


def test_an_upload_is_read_as_the_command_line_reads_it(client: Client, tmp_path: Any) -> None:
    write_history(tmp_path / "pressure.csv")
    data = (tmp_path / "pressure.csv").read_bytes()
    found = client.request("POST", "/api/history?name=C:\\\\x\\\\mine.CSV&area=6.5 cm^2", content=data).json()
    case = load_case("hydraulic-drifter")
    here = case_of({**json_tables(case), "load": found["load"]})
    np.testing.assert_array_equal(here.system().load.coefficients, case.system().load.coefficients)
    assert found["report"]["frequency"] == here.system().frequency
    refused = client.request("POST", "/api/history?name=mine.csv", content=data)
    assert refused.status_code == 422 and refused.json()["problems"][0]["key"] == "load.area"
    plain = client.request("POST", "/api/history?name=a.csv&area=1 cm^2&force_scale=1 kN", content=data).json()
    assert set(plain["load"]) == {"kind", "coefficients"}
    broken = client.request("POST", "/api/history?name=mine.csv", content=b"nothing,here\n")
    assert broken.status_code == 422 and "percuss-" not in broken.text
    assert (
        client.request("POST", "/api/history?name=mine.exe", content=data).json()["problems"][0]["key"] == "load.file"
    )


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
    asked = f"/api/case/recorded?name={name}&toml_bytes={len(text)}"
    found = client.request("POST", asked, content=text + record).json()
    case = load_case("hydraulic-drifter")
    np.testing.assert_array_equal(case_of(found["tables"]).system().load.coefficients, case.system().load.coefficients)
    assert found["history"]["cycles"] == case.history_report.cycles and found["tables"]["load"]["kind"] == "fourier"
    other = client.request("POST", asked.replace(name, "other.csv"), content=text + record).json()
    assert any(name in note and "other.csv" in note for note in other["notes"])

    def refusal(path: str, content: bytes) -> dict[str, Any]:
        answer = client.request("POST", path, content=content)
        assert answer.status_code == 422, answer.text
        problem: dict[str, Any] = answer.json()["problems"][0]
        return problem

    assert refusal(asked, text)["key"] == "toml_bytes"
    assert refusal(asked, text[:-1] + b"\xff" + record)["key"] == "toml_bytes"
    assert refusal(asked, text + b"nothing,here\n")["key"].startswith("load")
    plain = machine_text("mini-breaker").encode()
    assert refusal(f"/api/case/recorded?name=a.csv&toml_bytes={len(plain)}", plain + record)["key"] == "load.kind"
    wrong = text.replace(b"[bar]", b'[bar]\ncolour = "red"')
    path = f"/api/case/recorded?name={name}&toml_bytes={len(wrong)}"
    assert refusal(path, wrong + record)["key"] == "bar.colour"
    alone = client.problems("/api/case", {"toml": text.decode()})[0]
    assert alone["key"] == "load.kind" and "together" in alone["remedy"]


_PACKED = ["a.mat", "packed.mat", "A.H5", "packed.hdf5", "a.tdms"]


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.slow] * (name in ("packed.mat", "A.H5"))) for name in _PACKED]
)
def test_packed_uploads_are_read_as_the_command_line_reads_them(client: Client, tmp_path: Any, name: str) -> None:
    for package in ("scipy", "h5py", "nptdms"):
        pytest.importorskip(package)
    import h5py
    from nptdms import ChannelObject, TdmsWriter
    from scipy.io import savemat

    t = np.arange(1500) / 1000.0
    recorded = {"time": t, "force": 1e3 * (5.0 + 9.0 * np.cos(40.0 * np.pi * t))}
    path, packed = tmp_path / name.lower(), name.startswith("packed")
    if path.suffix == ".mat":
        savemat(path, {**recorded, "note": "as measured", "more": {"a": [1.0]}}, do_compression=packed)
    elif path.suffix == ".tdms":
        with TdmsWriter(path) as file:
            file.write_segment([ChannelObject("run", key, column) for key, column in recorded.items()])
    else:
        with h5py.File(path, "w") as content:
            options = {"compression": "gzip", "shuffle": True, "fletcher32": True, "chunks": (400,)} if packed else {}
            for key, column in recorded.items():
                content.create_dataset(f"run/{key}", data=column, **options)
    column = "run/force" if path.suffix in (".h5", ".hdf5") else "force"
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


# -- moving ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", NAMES)
def test_every_movable_parameter_moves_to_its_value(name: str) -> None:
    case = without_files(load_case(name))
    for row in parameters(case):
        if not row["movable"] or row["name"] == "load.scale":
            continue
        value = 1.01 * row["value"]
        moved = {again["name"]: again for again in parameters(placed(case, {row["name"]: value}))}
        assert moved[row["name"]]["value"] == pytest.approx(value, rel=1e-12)
        assert moved[row["name"]]["unit"] == row["unit"]
    scaled = placed(case, {"load.scale": 2.0}).system().load
    np.testing.assert_allclose(scaled.coefficients, 2.0 * case.system().load.coefficients, rtol=1e-14)


def test_moves_of_a_square_load_and_refusals() -> None:
    case = case_of({**PLAIN, "load": {"kind": "square", "amplitude": 1.0, "kappa": 1.1}})
    moved = placed(case, {"load_factor": 0.4, "restitution": 0.3, "s": 30.0}).system()
    assert moved.load.load_factor == pytest.approx(0.4, abs=1e-12)
    assert (moved.restitution, moved.s) == (0.3, 30.0)
    for values in ({"nothing": 1.0}, {"kappa": math.inf}):
        with pytest.raises(ParameterError):
            placed(case, values)
    with pytest.raises(CaseError):
        placed(case, {"restitution": 2.0})
    with pytest.raises(ParameterError, match="greater than 0"):
        placed(load_case("mini-breaker"), {"s": 0.0})


@pytest.mark.parametrize("name", NAMES)
def test_another_s_leaves_all_other_numbers_of_a_machine_alone(name: str) -> None:
    case = without_files(load_case(name))
    now, moved = case.system(), placed(case, {"s": 7.5, "restitution": 0.25}).system()
    assert (moved.s, moved.restitution) == (pytest.approx(7.5, rel=1e-12), 0.25)
    assert moved.d == pytest.approx(now.d, rel=1e-12)
    np.testing.assert_allclose(moved.load.coefficients, now.load.coefficients, rtol=1e-12)


def test_place_answers_as_case_does(client: Client) -> None:
    found = client.answer("/api/place", {"machine": "mini-breaker", "values": {"restitution": 0.25}})
    assert found["tables"]["contact"] == {"restitution": 0.25}
    assert found == client.answer("/api/case", {"case": found["tables"]})
    quick = client.answer("/api/quick", {"machine": "mini-breaker", "values": {"restitution": 0.25}})
    assert quick["tables"] == found["tables"] and quick["restitution"] == 0.25


# -- steady motions -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["hydraulic-drifter", "mini-breaker", "laboratory-striker"])
def test_steady_is_what_the_command_line_prints(client: Client, name: str, capsys: pytest.CaptureFixture[str]) -> None:
    told = printed(capsys, "steady", name, "--json", "--periods", "1,2")
    assert client.answer("/api/steady", {"machine": name, "periods": [2, 1]}) == told
    tables = client.get(f"/api/machines/{name}").json()["tables"]
    found = client.answer("/api/steady", {"case": tables, "periods": [1, 2]})
    for key in ("periods", "system", "rest", "title"):
        assert found[key] == told[key]


def test_a_case_file_is_answered_as_the_command_line_does(
    client: Client, tmp_path: Any, capsys: pytest.CaptureFixture[str]
) -> None:
    text = client.answer("/api/case", {"case": PLAIN})["toml"]
    (tmp_path / "mine.toml").write_text(text)
    told = printed(capsys, "steady", str(tmp_path / "mine.toml"), "--json", "--modes", "8")
    found = client.answer("/api/steady", {"toml": text, "modes": 8})
    assert {**found, "case": 0, "title": 0} == {**told, "case": 0, "title": 0}


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("multipliers", [False, True])
def test_the_quick_answer_is_the_whole_one_but_for_rounding(client: Client, name: str, multipliers: bool) -> None:
    quick = client.answer("/api/quick", {"machine": name, "multipliers": multipliers})
    whole = client.answer("/api/steady", {"machine": name})["periods"][0]
    assert {key: quick[key] for key in ("m", "level", "level_max", "exists", "nearest", "note")} == {
        key: whole[key] for key in ("m", "level", "level_max", "exists", "nearest", "note")
    }
    for one, other in zip(quick["orbits"], whole["orbits"], strict=True):
        for key in ("phase", "impact_velocity", "rigid_velocity", "stable", "reduced", "waveform"):
            assert one[key] == other[key]
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
    assert client.problems("/api/curves", {"case": PLAIN, "load_factor": [1.0, 0.5]})[0]["key"] == "load_factor"


# -- maps -----------------------------------------------------------------------------------------------------------


def test_a_map_is_what_the_command_line_prints(client: Client, capsys: pytest.CaptureFixture[str]) -> None:
    names = ["orbits", "stable", "margin", "phases"]
    told = printed(
        capsys, "sweep", "mini-breaker", "--x", "load_factor=0.05:1:5", "--y", "restitution=0:0.9:7", "--json",
        "--quantity", ",".join(names),
    )  # fmt: skip
    header, arrays = client.arrays("/api/map", {"machine": "mini-breaker", **PLANE, "quantities": names})
    assert header["x"]["values"] == told["axes"][1]["values"] and header["y"]["values"] == told["axes"][0]["values"]
    for name in names:
        expected = np.array(told["quantities"][name]["values"], dtype=float)
        np.testing.assert_allclose(arrays[name], expected, rtol=1e-6, atol=1e-7)
        assert header["quantities"][name]["meaning"]
    assert [header["outcomes"][code] for code in arrays["outcome"].ravel()] == ["ok"] * 35


def test_maps_over_keys_with_units_and_of_words(client: Client) -> None:
    x = {"name": "bar.length", "unit": "mm", "values": [300.0, 320.0, 340.0]}
    asked = {"machine": "mini-breaker", "x": x, "y": PLANE["y"], "quantities": ["reason", "blow_energy", "admissible"]}
    header, arrays = client.arrays("/api/map", asked)
    assert arrays["blow_energy"].shape == (5, 3) and header["quantities"]["blow_energy"]["unit"] == "J"
    assert "flip" in header["quantities"]["reason"]["words"]
    small = {"x": {**PLANE["x"], "count": 2}, "y": {**PLANE["y"], "count": 2}, "quantities": ["label"]}
    header, arrays = client.arrays("/api/map", {"case": PLAIN, **small, "modes": 0, "impacts": 200})
    words = [header["quantities"]["label"]["words"][i] for i in arrays["label"].ravel()]
    assert all(words)


def test_boundaries_bound_the_map(client: Client) -> None:
    asked = {"case": PLAIN, "x": {**PLANE["x"], "count": 4}, "y": {"name": "load_factor", "from": 0.02, "to": 2.0}}
    found = client.answer("/api/boundaries", asked)
    fold = next(curve for curve in found["curves"] if curve["kind"] == "fold")
    system = case_of(PLAIN).system()
    for r, factor in zip(fold["x"], fold["y"], strict=True):
        if factor is not None:
            plane = stability_plane(system, r, [0.999 * factor, 1.001 * factor])
            assert plane.roots.tolist() == [2, 0]


# -- motions --------------------------------------------------------------------------------------------------------


def test_frames_of_an_orbit_are_its_fields(client: Client) -> None:
    asked = {"machine": "mini-breaker", "orbit": 2, "frames": 40, "places": 9, "end_points": 300, "cycles": 2}
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
    assert client.problems("/api/motion", {**asked, "orbit": 3})[0]["key"] == "orbit"
    assert client.problems("/api/motion", {**asked, "start": {}})[0]["key"] == "orbit"
    assert client.problems("/api/motion", {**asked, "window": [0.2, 0.1]})[0]["key"] == "window"


@pytest.mark.parametrize("show", ["start", "settled"])
def test_frames_of_a_simulation_are_its_fields(client: Client, show: str) -> None:
    asked = {
        "machine": "mini-breaker",
        "simulation": {"modes": 4},
        "frames": 30,
        "places": 5,
        "cycles": 3 if show == "start" else 2,  # what it settles on was followed for two cycles
        "show": show,
    }
    header, arrays = client.arrays("/api/motion", asked)
    motion = simulation_answer(load_case("mini-breaker").changed(simulation={"modes": 4})).motion
    assert header["label"] == motion.label == "z=1/1" and header["outcome"] == "periodic"
    t = np.linspace(header["begin"], min(header["end"], motion.end_time), 30)
    places = np.linspace(0.0, 1.0, 5)
    np.testing.assert_allclose(arrays["displacement"], motion.position(places, t).T, rtol=1e-5, atol=1e-6)
    assert header["end"] - header["begin"] == pytest.approx(2.0 * math.pi * asked["cycles"])
    inside = (motion.events.time >= header["begin"]) & (motion.events.time <= header["end"])
    assert len(header["blows"]) == int(inside.sum())
    assert arrays["poincare_phase"].size == motion.impacts
    assert np.isnan(arrays["end_velocity"]).sum() == int(inside.sum())
    assert np.all(np.diff(arrays["end_t"]) >= 0.0)


def falling(restitution: float, mean: float) -> dict[str, Any]:
    """A rigid bar let go off the wall."""
    load = {"kind": "harmonic", "mean": mean, "amplitude": 1.0}
    start = {"position": -0.5, "velocity": 0.0, "time": 0.3}
    system = {"s": 20, "d": 0.005, "restitution": restitution}
    return {"system": system, "load": load, "start": start, "simulation": {"modes": 0, "impacts": 1500}}


@pytest.mark.parametrize("restitution, mean", [(0.2, 0.9), (0.0, 0.44), (0.4, 0.6)])
@pytest.mark.parametrize("cycles", [1, 4, 32])
def test_what_a_motion_settles_on_has_nothing_of_the_way_there(
    client: Client, restitution: float, mean: float, cycles: int
) -> None:
    tables = falling(restitution, mean)
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


def test_simulate_is_what_the_command_line_prints(client: Client, capsys: pytest.CaptureFixture[str]) -> None:
    told = printed(
        capsys, "simulate", "mini-breaker", "--json", "--modes", "4", "--start", "position=-0.5", "--events", "last:7"
    )
    asked = {"machine": "mini-breaker", "start": {"position": -0.5}, "simulation": {"modes": 4}, "events": 7}
    assert client.answer("/api/simulate", asked) == told
    file = client.post("/api/simulate/file", {**asked})
    assert file.status_code == 200 and file.content[:4] == b"\x89HDF"
    assert client.problems("/api/simulate", {**asked, "start": {"position": 1.0}})[0]["key"] == "start.position"
    assert client.problems("/api/simulate", {**asked, "start": {"orbit": 9}})[0]["key"] == "start.orbit"


def test_a_time_alone_does_not_ask_for_a_million_impacts(client: Client) -> None:
    found = client.answer("/api/simulate", {"case": PLAIN, "simulation": {"modes": 0, "time": 60.0, "periodic": False}})
    assert found["outcome"] == "time" and found["end_time"] == pytest.approx(60.0)


# -- blows ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["laboratory-striker", "mini-breaker"])
def test_a_blow_is_what_the_command_line_prints(client: Client, name: str, capsys: pytest.CaptureFixture[str]) -> None:
    header, arrays = client.arrays("/api/blow", {"machine": name, "frames": 31, "cells": 20})
    assert {**header["answer"], "case": ""} == {**printed(capsys, "blow", name, "--json"), "case": ""}
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
    quick, fields = client.arrays("/api/blow", {"machine": "mini-breaker", "whole": False})
    whole, others = client.arrays("/api/blow", {"machine": "mini-breaker"})
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


def test_a_blow_that_cannot_be_is_told_by_its_key(client: Client) -> None:
    bad = {**PLAIN, "tool": {"impedance": -1.0}}
    assert client.problems("/api/blow", {"case": bad})[0]["key"] == "tool.impedance"
    assert client.problems("/api/blow", {"machine": "mini-breaker", "frames": 602})[0]["key"] == "frames"


# -- machines that switch themselves --------------------------------------------------------------------------------


@pytest.mark.parametrize("name", VALVES)
def test_a_machine_with_its_valve_comes_as_a_case_of_the_same_machine(client: Client, name: str) -> None:
    found = client.get(f"/api/machines/{name}").json()
    machine = load_case(name).machine()
    assert found["system"] is None and found["scales"]["time_s"] == 1.0
    assert case_of(found["tables"]).machine() == machine
    plain = case_of(found["plain"])
    again = client.answer("/api/case", {"case": found["plain"]})
    assert again["bar"] is None and again["plain"]["load"] == found["plain"]["load"]
    assert plain.machine().valve == machine.valve and plain.machine().drag == machine.drag
    assert found["bar"]["first_mode_Hz"] == pytest.approx(machine.body.s / 2.0, rel=1e-12)
    assert found["body"]["kind"] == "uniform"
    told = {**found["plain"], "load": {**found["plain"]["load"], "room": 2.0, "at": 0}}
    assert client.answer("/api/case", {"case": told})["plain"]["load"]["room"] == 2.0


@pytest.mark.parametrize(("name", "energy", "rate"), [("valve-breaker", 3751.0, 9.448), ("valve-drifter", 301.1, 61.2)])
def test_a_cycle_over_time(client: Client, name: str, energy: float, rate: float) -> None:
    header, arrays = client.arrays("/api/machine", {"machine": name, "modes": 0, "points": 101, "whole": False})
    answer = header["answer"]
    assert answer == cycle_dict(machine_answer(load_case(name), 0))
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


def test_the_whole_answer_of_a_machine_is_the_command_line_s(
    client: Client, capsys: pytest.CaptureFixture[str]
) -> None:
    header, _ = client.arrays("/api/machine", {"machine": "valve-drifter", "modes": 0, "points": 2})
    told = printed(capsys, "machine", "valve-drifter", "--modes", "0", "--json")
    assert {**header["answer"], "case": ""} == {**told, "case": ""}
    assert header["sentence"].startswith("The machine runs with one blow a cycle: 301.1 J")


def test_a_machine_that_does_not_run_says_what_it_would_need(client: Client) -> None:
    tables = client.get("/api/machines/valve-breaker").json()["tables"]
    tables["load"]["chamber"]["stiffness"] = "140 kN/m"
    header, arrays = client.arrays("/api/machine", {"case": tables, "whole": False})
    assert arrays == {} and not header["runs"] and header["answer"]["period"] is None
    assert "58.29 mm behind the wall, and the port is at 130 mm" in header["sentence"]
    assert header["answer"]["failed_condition"]["remedy"].startswith("put the port nearer")
    assert header["modes"] == 32


def test_a_machine_on_its_pump_has_a_rigid_piston_whatever_the_page_asks_for(client: Client) -> None:
    tables = client.get("/api/machines/valve-breaker").json()["tables"]
    tables["load"]["supply"] = {"flow": "133 l/min", "accumulator": "2.5 cm^3/bar"}
    header, arrays = client.arrays("/api/machine", {"case": tables, "modes": 32, "whole": False})
    assert header["runs"] and header["modes"] == 0
    pushing = arrays["force"][arrays["state"] == 1].astype(float)
    assert pushing.max() > 1.1 * pushing.min()  # the pressure falls while the piston draws


def test_a_machine_from_its_start_is_the_simulated_motion(client: Client) -> None:
    words = {"start": {"position": -0.1}, "simulation": {"modes": 2}}
    asked = {"machine": "valve-breaker", **words, "blows": 3, "points": 50}
    header, sent = client.arrays("/api/machine/start", asked)
    found = simulation_answer(load_case("valve-breaker").changed(words["start"], words["simulation"]))
    frames, motion = start_frames(found, 3, 50), found.motion
    assert header["label"] == motion.label and header["answer"] == frames.header["answer"]
    assert all(sent[name] == pytest.approx(values, rel=1e-6, abs=1e-9) for name, values in frames.arrays.items())
    t = frames.arrays["t"]
    assert np.all(np.diff(t) >= 0.0) and t[0] == 0.0 and t[-1] == motion.blow_times[2]
    assert [blow["speed"] for blow in header["answer"]["blows"]] == motion.blow_speeds[:3].tolist()
    assert frames.arrays["striking_end"] == pytest.approx(motion.gap(t) * motion.machine.length_scale, abs=1e-12)
    for change in motion.events.of("valve"):
        if change.time < t[-1]:
            first = int(np.flatnonzero(t == change.time)[0])
            before, after = (header["states"][number] for number in frames.arrays["state"][[first - 1, first]])
            assert before != after == change.state
    assert client.problems("/api/machine/start", {"machine": "mini-breaker"})[0]["key"] == "load.kind"
    assert client.problems("/api/machine/start", {**asked, "start": {"position": 0.1}})[0]["key"] == "start.position"
    assert client.problems("/api/machine/start", {**asked, "blows": 0})[0]["key"] == "blows"


def test_a_machine_that_never_moves_has_a_start_of_no_blows() -> None:
    still = load_case("valve-breaker").varied({"load.chamber.force": "15 kN"}).changed({"position": 0.0}, {"modes": 0})
    frames = start_frames(simulation_answer(still))
    assert frames.header["label"] == "stalls (on the tool)" and not frames.header["answer"]["blows"]
    assert np.all(frames.arrays["centre"] == 0.0) and np.all(np.isfinite(frames.arrays["velocity"]))


def test_the_map_of_a_machine_is_that_of_percuss_sweep(client: Client) -> None:
    named = {row["name"]: row for row in client.get("/api/machines/valve-breaker").json()["parameters"]}
    assert "load.scale" not in named  # the pressure is the same
    assert named["load.ports[0].behind"]["label"] == "port 1 → power: place"
    assert (named["contact.restitution"]["low"], named["load.pressure"]["unit"]) == (0.0, "bar")
    x = {"name": "load.ports[0].behind", "unit": "mm", "values": [70, 130]}
    y = {"name": "load.pressure", "unit": "bar", "values": [80.0, 120.0, 160.0]}
    names = ["stall", "blow_energy", "rate"]
    asked = {"machine": "valve-breaker", "x": x, "y": y}
    header, arrays = client.arrays("/api/map", {**asked, "quantities": names, "modes": 0})
    assert header["quantities"]["stall"]["words"][:3] == ["runs", "no loss", "stays on the wall"]
    case = load_case("valve-breaker")
    for j, pressure in enumerate(y["values"]):
        for i, place in enumerate(x["values"]):
            ports = [dict(port) for port in case.to_dict()["load"]["ports"]]
            ports[0]["behind"] = f"{place} mm"
            other = case.varied({"load.ports": ports, "load.pressure": f"{pressure} bar"})
            answer = machine_answer(other, 0)
            assert (arrays["stall"][j, i] == 0) == answer.runs
            energy = answer.to_json_dict()["si"]["blow_energy_J"] if answer.runs else math.nan
            assert arrays["blow_energy"][j, i] == pytest.approx(energy, rel=1e-9, nan_ok=True)
    problem = client.problems("/api/map", {**asked, "quantities": ["orbits"]})[0]
    assert problem["key"] == "quantities"


def test_a_clocked_case_is_no_machine_and_a_machine_has_no_clock(client: Client) -> None:
    problem = client.problems("/api/machine", {"machine": "mini-breaker"})[0]
    assert problem["key"] == "load.kind" and "'valve'" in problem["message"]
    for path in ("quick", "steady", "curves", "motion", "place", "report"):
        more = {"values": {"restitution": 0.2}} if path == "place" else {}
        problems = client.problems(f"/api/{path}", {"machine": "valve-drifter", **more})
        assert "percuss machine" in problems[0]["remedy"], path
    bad = {**PLAIN, "load": {"kind": "valve", "states": {"a": -1.0}, "ports": [{"to": "b", "on": "impact"}]}}
    assert client.problems("/api/machine", {"case": bad})[0]["key"] == "load.ports[0].to"


def test_the_search_for_a_cycle_can_be_given_up() -> None:
    with halting(lambda: True), pytest.raises(Interrupted):
        machine_frames(load_case("valve-drifter"))


# -- experiments and reports ----------------------------------------------------------------------------------------


def test_an_experiment_ends_with_what_the_command_line_prints(
    client: Client, capsys: pytest.CaptureFixture[str]
) -> None:
    told = printed(
        capsys, "experiment", "mini-breaker", "--starts", "150", "--modes", "0", "--seed", "3", "--json",
        "--distribution", "field",
    )  # fmt: skip
    asked = {"machine": "mini-breaker", "starts": 150, "modes": 0, "seed": 3, "distribution": "field"}
    found = client.post("/api/experiment", asked)
    assert found.headers["content-type"].startswith("text/event-stream")
    seen = events(found.text)
    assert [name for name, _ in seen[:-1]] == ["progress"] * (len(seen) - 1) and seen[-1][0] == "done"
    assert seen[-1][1] == told
    done = [data["done"] for name, data in seen if name == "progress"]
    assert done == sorted(done) and done[-1] == 150
    assert sum(share["share"] for share in seen[-2][1]["shares"]) == pytest.approx(1.0)
    text = client.post("/api/experiment/file", {**asked, "format": "csv"})
    rows = list(csv.reader(io.StringIO(text.text)))
    assert len(rows) == 151 and "attachment" in text.headers["content-disposition"]
    again = Client().post("/api/experiment/file", {**asked, "format": "csv"})
    assert again.text == text.text
    assert client.post("/api/experiment/file", asked).content[:4] == b"\x89HDF"


@pytest.mark.parametrize("kept", [True, False])
def test_the_first_starts_of_an_experiment_are_those_of_the_whole(kept: bool) -> None:
    client = Client()
    asked = {"machine": "mini-breaker", "starts": 60, "modes": 0, "seed": 11 + kept, "format": "csv"}
    if kept:
        client.post("/api/experiment", {name: value for name, value in asked.items() if name != "format"})
    some = client.post("/api/experiment/file", {**asked, "first": 23})
    whole = client.post("/api/experiment/file", asked)
    first, rows = (list(csv.reader(io.StringIO(found.text))) for found in (some, whole))
    assert len(rows) == 61 and first == rows[:24]


def test_the_report_is_one_file(client: Client) -> None:
    tables = json_tables(load_case("mini-breaker"))
    tables["title"] = '<script>alert("$x")</script> & $\\frac{'
    found = client.post("/api/report", {"case": tables, "simulate": True})
    assert found.status_code == 200, found.text
    text = found.text
    assert "<script" not in text and "&lt;script&gt;" in text
    assert text.count("<svg") == 3 and "blow energy" in text and "src=" not in text
    assert "http-equiv" in text and "default-src 'none'" in text
    none = client.post("/api/report", {"case": {**PLAIN, "load": {"kind": "harmonic", "mean": 9.0, "amplitude": 1.0}}})
    assert "No steady motion with one impact every load period exists" in none.text
    assert "The bar may also come to rest on the wall." in none.text
    assert "<td>nearest</td><td>load factor" in none.text


def test_the_report_tells_one_case_in_one_kind_of_units(client: Client) -> None:
    """Of a machine every speed and energy is in SI: none of them stands dimensionless beside it."""
    text = client.post("/api/report", {"machine": "mini-breaker", "simulate": True}).text
    orbit = steady_states(load_case("mini-breaker").system()).orbits[-1]
    scale = load_case("mini-breaker").system().speed_scale
    assert f"{orbit.impact_velocity * scale:.4g} m/s" in text
    assert f"{orbit.impact_velocity:.4g} " not in text
    assert "<td>striking speed</td>" in text and "<td>blow</td>" in text
    assert "N·s" in text and "N s" not in text
    plain = client.post("/api/report", {"case": PLAIN}).text
    assert " m/s" not in plain and "at the striking end" in plain


# -- load -----------------------------------------------------------------------------------------------------------


def test_slider_moves_are_quick(client: Client) -> None:
    """A bound that no busy machine misses; benchmarks/web.py measures."""
    took = []
    for i in range(40):
        begun = time.process_time()
        client.answer("/api/quick", {"machine": "mini-breaker", "values": {"load_factor": 0.3 + 0.001 * i}})
        took.append(time.process_time() - begun)
    assert sorted(took)[20] < 0.1


def test_a_load_that_switches_is_told_with_its_clock(client: Client) -> None:
    """What the headline of the page takes its note from; one that does not switch has none."""
    plain = {"s": 20.0, "d": 0.01, "restitution": 0.2}
    square = {"kind": "square", "amplitude": 1.0, "kappa": 1.2}
    smooth = {"kind": "harmonic", "mean": 0.3, "amplitude": 1.0}
    told = client.answer("/api/case", {"case": {"system": plain, "load": square}})
    assert "as a valve does" in told["clock"]
    assert told["clock"] in told["notes"]
    assert client.answer("/api/case", {"case": {"system": plain, "load": smooth}})["clock"] == ""
