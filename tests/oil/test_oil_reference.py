"""The figures of `data/oil.json`, of two programs that share nothing with this one, by case files and the commands."""

from __future__ import annotations

from pathlib import Path

import pytest

from oil_cases import ORBITS, RUNS, case_text

CLOSE = 1e-9  # relative


def is_si(case):
    return case["units"] == "SI"


def put(case, percuss, **more):
    Path("oil.toml").write_text(case_text(case["system"], is_si(case), **more), encoding="utf-8")


@pytest.mark.parametrize("case", ORBITS, ids=lambda case: case["name"][:60])
def test_cycles(case, percuss):
    expect = case["expect"]
    put(case, percuss)
    told = percuss("machine", "oil.toml", "--modes", "0", "--no-plausibility", "--json").json
    period, speed = float(expect["period"]), float(expect["blow_speed"])
    energy = case["system"]["mass"]  # an energy of the answer is one of mass 1
    assert told["period"] == pytest.approx(period, rel=CLOSE)
    assert told["blows"][-1]["speed"] == pytest.approx(speed, rel=CLOSE)
    assert told["blows"][-1]["energy"] * energy == pytest.approx(expect["blow_energy"], rel=CLOSE)
    assert told["stroke"] == pytest.approx(float(expect["stroke"]), rel=CLOSE)
    found, expected = (
        sorted((complex(*z) for z in own), key=lambda z: (-round(abs(z), 7), z.imag))
        for own in (told["multipliers"], expect["multipliers"])
    )
    assert found[: len(expected)] == pytest.approx(expected, abs=1e-6)
    events = expect["events"]
    demands = case["system"]["ports"]
    ports = [
        (e["port"], float(e["time"])) for e in events
        if e["kind"] == "port" and demands[e["port"]].get("on") != "impact"
    ]  # fmt: skip
    changes = [(e["to"], float(e["time"])) for e in events if e["kind"] == "valve" and 0.0 < float(e["time"]) < period]
    assert [(e["port"], pytest.approx(e["time"], abs=CLOSE * period)) for e in told["ports"] if e["time"]] == ports
    assert [
        (e["to"], pytest.approx(e["time"], abs=CLOSE * period)) for e in told["valve"] if e["time"] > 0.0
    ] == changes
    oil = told.get("oil")
    if oil is None:  # it loses nothing, and a closed form answers
        assert expect["losses"]["impact"] == pytest.approx(expect["input_energy"], rel=CLOSE)
        assert told["work_per_cycle"] == pytest.approx(expect["input_energy"], rel=CLOSE)
        return
    plain = {key: oil["loss_energies"][key] for key in expect["losses"]}
    scale = expect["input_energy"]
    assert plain == pytest.approx(expect["losses"], abs=CLOSE * scale)
    assert oil["energy_residual"] == pytest.approx(0.0, abs=1e-12)
    assert oil["losses"] == pytest.approx({k: v / scale for k, v in expect["losses"].items()}, abs=CLOSE)
    assert oil["power_duty"] == pytest.approx(expect["duty"], abs=CLOSE)
    told_si = oil.get("si", {})
    for key, ending in (
        ("efficiency", ""), ("efficiency_of_the_blow", ""), ("input_energy", "_J"), ("input_power", "_W"),
        ("blow_power", "_W"), ("pump_flow", "_m3_s"), ("pumped_volume", "_m3"), ("drawn_volume", "_m3"),
        ("leaked_volume", "_m3"), ("relief_volume", "_m3"), ("mean_pressure", "_Pa"), ("pressure_min", "_Pa"),
        ("pressure_max", "_Pa"), ("pressure_at_blow", "_Pa"),
    ):  # fmt: skip
        value, wanted = told_si[f"{key}{ending}"] if ending and told_si else oil[key], float(expect[key])
        size = expect["pumped_volume"] if key.endswith("volume") else abs(wanted)
        assert value == pytest.approx(wanted, abs=CLOSE * size), key
    if told.get("supply"):
        names = {
            "mean": "mean_pressure",
            "at_blow": "pressure_at_blow",
            "least": "pressure_min",
            "greatest": "pressure_max",
        }
        assert {key: told["supply"][key] for key in names} == pytest.approx(
            {key: float(expect[name]) for key, name in names.items()}, rel=CLOSE
        )
    for _, here, there in oil["checks"]:
        assert here == pytest.approx(there, rel=1e-9)


@pytest.mark.parametrize("case", RUNS, ids=lambda case: case["name"][:60])
def test_runs(case, percuss):
    expect, until = case["expect"], float(case["until"])
    put(case, percuss, start=case["start"], until=until)
    told = percuss("simulate", "oil.toml", "--json").json
    kinds = {"leaves": "release"}
    wanted = [
        (kinds.get(e["kind"], e["kind"]), float(e["time"]), e)
        for e in expect["events"] if e["kind"] in ("impact", "port", "valve", "rest", "leaves")
    ]  # fmt: skip
    seen = [(e["kind"], e["time"], e) for e in told["events"] if e["time"] > 0.0]
    wanted = [one for one in wanted if one[1] > 0.0]  # at the start it rests
    assert [(kind, pytest.approx(time, abs=CLOSE * until)) for kind, time, _ in seen] == [one[:2] for one in wanted]
    fastest = max(float(e["speed"]) for _, _, e in wanted if "speed" in e) if expect["blows"] else 1.0
    for (kind, _, here), (_, _, there) in zip(seen, wanted, strict=True):
        if kind == "impact":
            assert here["speed"] == pytest.approx(float(there["speed"]), abs=CLOSE * fastest)
        elif kind == "valve":
            assert here["to"] == there["to"]
    ends = {
        "runs": ("time", None),
        "rest": ("stalls", "stalls (on the tool)"),
        "no pressure": ("stalls", "stalls (without pressure)"),
    }
    outcome, label = ends[expect["outcome"]]
    assert told["outcome"] == outcome
    assert label is None or told["label"] == label
    assert len([one for one in seen if one[0] == "impact"]) == expect["blows"]
