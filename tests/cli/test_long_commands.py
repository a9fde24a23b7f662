"""`percuss sweep`, `experiment`, `basins`, `diagram`: files, going on where they were broken off, answers."""

import csv
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from cli_cases import CASES
from percuss import Load, System
from percuss.case import load_case
from percuss.explore import REASONS, boundaries, sweep
from percuss.explore.attractors.basin import BasinsJob
from percuss.explore.attractors.experiments import ExperimentJob
from percuss.explore.attractors.hammers import CYCLE_KINDS
from percuss.simulate import OUTCOMES

SYSTEM = System(s=20.0, d=0.0048, restitution=0.6, load=Load.harmonic(0.9, 1.0))
PLANE = ("--x", "restitution=0.2:0.8:4", "--y", "load_factor=0.3:0.9:3")
FEW = ("--label", "1/1", "--searched", "1", "--switch", "0", "--starts", "2", "--runs", "1")
GAS = load_case("valve-breaker").varied({"load.chamber": {"force": "11.4 kN", "stiffness": "25.3 kN/m"}}).to_toml()
STATES = ("--x", "position=-250:-10mm:6", "--y", "velocity=-8:8m/s:5", "--at", "state=power", "--modes", "0")

JOBS = {
    "sweep": ("sweep", "light.toml", *PLANE, "--quantity", "label,phase", "--modes", "2"),
    "line": ("sweep", "case.toml", "--x", "load_factor=0.3:1.3:11", "--quantity", "stable,orbits"),
    "valve": ("sweep", "valve-breaker", "--x", "pressure=100:160 bar:4", "--quantity", "stall,flow", "--modes", "0"),
    "experiment": ("experiment", "light.toml", "--starts", "300", "--seed", "5", "--modes", "0"),
    "machine": ("experiment", "gas.toml", "--starts", "60", "--distribution", "field", "--modes", "0", "--seed", "1"),
    "basins": ("basins", "light.toml", "--x", "time=0:6.2:9", "--y", "velocity=-6:-0.1:7", "--modes", "0"),
    "states": ("basins", "gas.toml", *STATES),
    "diagram": ("diagram", "si.toml", "--along", "load.mean=6 kN:10 kN:5", *FEW),
}
TOLD = {
    "sweep": "12 cells over restitution and load_factor", "line": "11 cells over load_factor", "valve": "4 cells",
    "experiment": "300, wall, seed 5", "machine": "and stalls from", "basins": "63 starts", "states": "power",
    "diagram": "load.mean from 6 to 10 kN, 0 elastic modes",
}  # fmt: skip


@pytest.fixture(autouse=True)
def gas(tmp_path):
    """A breaker whose gas lets it run from some starts only."""
    (tmp_path / "gas.toml").write_text(GAS, encoding="utf-8")


WHOLE = {}


@pytest.fixture
def whole(percuss):
    """The answer of a job, as JSON, by two workers: computed when it is first asked for."""

    def answer(name):
        if name not in WHOLE:
            WHOLE[name] = percuss(*JOBS[name], "--json", "--workers", 2).json
        return WHOLE[name]

    return answer


@pytest.mark.parametrize("name", JOBS)
def test_every_file_of_a_job(percuss, whole, name):
    """The same answer with one worker, with two, kept, and kept already; an archive is exported as what it is."""
    ask = JOBS[name]
    kinds = {"sweep": ("csv",), "diagram": ("csv", "netcdf")}.get(ask[0], ())
    files = {kind: f"made.{kind.removesuffix('netcdf')}{'nc' * (kind == 'netcdf')}" for kind in kinds}
    made = [word for kind, file in files.items() for word in (f"--{kind}", file)]
    done = percuss(*ask, "--workers", 1, "-o", "kept.zarr", "--plot", "made.svg", *made)
    done.told(TOLD[name], "picture: made.svg", "kept.zarr", *files.values())
    assert "<svg" in Path("made.svg").read_text(encoding="utf-8")
    percuss(*ask, "-o", "kept.zarr").refused("--resume")
    assert percuss(*ask, "--json", "-o", "kept.zarr", "--resume").json == whole(name)
    other = [word.replace("0.3:1.3:11", "0.3:1.2:11").replace("160 bar", "150 bar") for word in ask]
    other += ["--modes", "1"] if other == list(ask) else []
    percuss(*other, "-o", "kept.zarr", "--resume").refused("kept.zarr")
    percuss("show", "kept.zarr").told("complete", "what was asked for", "SHA-256")
    percuss("export", "kept.zarr", "-o", "again.csv").told("again.csv")
    if "csv" in files:
        assert Path("again.csv").read_bytes() == Path("made.csv").read_bytes()
    percuss("export", "kept.zarr", "-o", "again.nc").told("again.nc")


@pytest.mark.parametrize("name", JOBS)
def test_broken_off_and_gone_on_with(percuss, whole, monkeypatch, name):
    """Ctrl-C keeps what is done, says how to go on, and what comes of it is what comes of all at once."""
    ask, at_once = JOBS[name], whole(name)
    with monkeypatch.context() as patched:
        patched.setattr("percuss.explore.jobs.progress._LOOK", 0.0)  # however fast the job is
        patched.setattr("percuss.explore.jobs.carrying_out.chunk_of", lambda size, *_, **__: max(1, size // 8))

        def stopped(watch, progress):
            if progress.done >= progress.size // 3:
                signal.raise_signal(signal.SIGINT)
            return watch.asked()

        patched.setattr("percuss.cli.long_commands.JobWatch.__call__", stopped)
        broken = percuss(*ask, "--workers", 1, "-o", "kept.zarr", "--plot", "part.svg")
    assert broken.code == 130 and "interrupted after" in broken.err and "--resume" in broken.err
    assert ("the diagram is not whole" in broken.out) == Path("part.svg").exists() == (ask[0] == "diagram")
    percuss("show", "kept.zarr").told("% done", "to continue")
    assert percuss(*ask, "--json", "-o", "kept.zarr", "--resume").json == at_once


LONG = ("sweep", "case.toml", "--x", "restitution=0.1:0.8:80", "--y", "load_factor=0.2:0.9:80", "--quantity", "label",
        "--modes", "16", "--impacts", "20000", "-o", "map.zarr")  # fmt: skip
"""Seconds of work beyond the first part of its archive, so that a signal finds it at work and not done."""


@pytest.mark.slow
@pytest.mark.skipif(os.name != "posix", reason="process groups and signals")
def test_killed_and_interrupted_processes_go_on(percuss, tmp_path):
    assert percuss(*LONG[:-1], "whole.zarr").code == 0
    for how in (signal.SIGKILL, signal.SIGINT):
        shutil.rmtree("map.zarr", ignore_errors=True)
        pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True, "start_new_session": True}
        with subprocess.Popen([sys.executable, "-m", "percuss", *LONG], cwd=tmp_path, **pipes) as child:
            ends = time.monotonic() + 120.0
            while time.monotonic() < ends and child.poll() is None and not list(tmp_path.glob("map.zarr/done/c/*")):
                time.sleep(0.02)
            assert child.poll() is None and list(tmp_path.glob("map.zarr/done/c/*"))
            sent = time.monotonic()
            os.kill(child.pid, how)
            _, err = child.communicate(timeout=60)
        if how == signal.SIGINT:
            assert time.monotonic() - sent < 4.0 and child.returncode == 130 and "--resume" in err
        assert percuss("show", "map.zarr").code == 0
        done = percuss(*LONG, "--resume")
        assert done.code == 0, done.err
    for name in ("whole", "map"):
        assert percuss("export", f"{name}.zarr", "-o", f"{name}.csv").code == 0
    assert Path("whole.csv").read_bytes() == Path("map.csv").read_bytes()


@pytest.mark.parametrize(
    "ask",
    [
        ("experiment", "case.toml", "--starts", 1_000_000_000),
        ("basins", "case.toml", "--x", "time=0:6:100000", "--y", "velocity=-6:0:100000"),
    ],
)
def test_what_takes_too_much_is_refused_after_a_sample(percuss, monkeypatch, ask):
    for job in (ExperimentJob, BasinsJob):

        def compute(self, first, last, stopped, whole=job.compute):
            assert last - first < 1_000_000, "computed before it was agreed to"
            return whole(self, first, last, stopped)

        monkeypatch.setattr(job, "compute", compute)
    done = percuss(*ask, "--modes", 0)
    done.refused("--yes")
    assert re.search(r"\d [MGT]B", done.err)
    if ask[0] == "basins":  # starts of an experiment are counted and forgotten
        monkeypatch.setattr("percuss.explore.jobs.carrying_out._memory", lambda: 64e9)
        percuss(*ask, "--modes", 0, "--yes").refused("of memory")


# -- what the answers say ---------------------------------------------------------------------------------------------


def rows_of(path):
    with open(path, encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def test_a_map_of_a_machine_that_switches_its_own_valve(percuss):
    over = ("--x", "pressure=80 bar,160 bar", "--y", "ports[0].behind=100 mm,130 mm")
    asked = ("--quantity", "stall,runs,blow_energy,flow", "--modes", 0)
    done = percuss("sweep", "valve-breaker", *over, *asked, "--csv", "map.csv")
    assert re.search(r"stall\s+runs 50 %, stays on the wall 50 %", done.out)
    assert re.search(r"bar\s+rigid", done.out) and "load period" not in done
    assert [row["stall"] for row in rows_of("map.csv")] == ["stays on the wall"] * 2 + ["runs"] * 2
    told = percuss("sweep", "valve-breaker", *over, *asked, "--json").json
    assert told["periods"] is None and told["modes"] == 0
    assert told["quantities"]["stall"]["values"][1] == ["runs", "runs"]
    assert told["quantities"]["flow"]["unit"] == "m³/s"
    assert told["quantities"]["blow_energy"]["values"][0] == [None, None]


def test_where_a_machine_runs_is_solved_for(percuss):
    asked = ("--x", "pressure=100 bar:200 bar:3", "--quantity", "runs", "--modes", 0)
    done = percuss("sweep", "valve-breaker", *asked)
    assert re.search(r"runs\s+120\.\d+ to 200 bar", done.out), done.out
    plane = ("--y", "ports[0].behind=100 mm,130 mm", "--curves")
    percuss("sweep", "valve-breaker", *asked, *plane).refused("load that keeps time")


def test_a_map_of_one_axis_says_where_it_is_stable(percuss):
    """To the solved boundaries: a flip below, a fold above; and a line for each value."""
    ask = ("sweep", "light.toml", "--x", "load_factor=0.3:1.3:11", "--quantity", "stable,reason,orbits,phase")
    done = percuss(*ask, "--csv", "map.csv")
    line = re.search(r"Along load_factor\n  stable +(\S+) to (\S+)\n", done.out)
    plane = ("restitution", [0.6]), ("load_factor", 0.3, 1.5)
    ends = boundaries(SYSTEM, *plane, criterion="exact", kinds=("fold", "flip", "neimark-sacker")).of_stability
    solved = np.array([curve.y[0] for curve in ends])
    for found in map(float, line.groups()):
        assert np.abs(solved - found).min() < 2e-6
    table = done.out[done.out.index("Values") :].splitlines()
    assert table[1].split() == ["load_factor", "stable", "reason", "orbits", "phase", "[rad]"]
    assert len(table) == 2 + 11 + 1 and table[-1] == "table: map.csv"
    direct = sweep(SYSTEM, "load_factor=0.3:1.3:11", quantities=["stable", "orbits"], workers=1)
    rows = [row.split() for row in table[2:13]]
    assert [row[1] == "yes" for row in rows] == direct["stable"].tolist()
    assert [int(row[3]) for row in rows] == direct["orbits"].tolist()


def test_a_long_table_is_thinned_and_says_so(percuss):
    done = percuss("sweep", "case.toml", "--x", "load_factor=0.3:1.3:200", "--quantity", "exists")
    done.told("Values (40 of 200; --csv FILE writes all)")
    table = done.out[done.out.index("Values") :].splitlines()
    assert len(table) == 42 and table[2].split()[0] == "0.3" and table[-1].split()[0] == "1.3"
    assert "Values" not in percuss("sweep", "case.toml", *PLANE, "--quantity", "exists")


def test_a_table_holds_words(percuss):
    """Reasons, outcomes and codes of labels; also of an archive that is exported."""
    axes = ("--x", "load_factor=-0.2,0.3,0.9", "--quantity", "reason,label,stable")
    assert percuss("sweep", "light.toml", *axes, "--csv", "a.csv").code == 0
    rows = rows_of("a.csv")
    assert [row["outcome"] for row in rows] == ["does not push", "ok", "ok"]
    assert rows[0]["reason"] == "" and rows[2]["reason"] == "stable" and rows[1]["reason"] in REASONS
    assert {row["label_outcome"] for row in rows} <= set(OUTCOMES) and rows[2]["label_kind"] in CYCLE_KINDS
    for case, name in (("light.toml", "e"), ("gas.toml", "m")):
        asked = ("--starts", 20, "--modes", 0, "-o", f"{name}.zarr")
        assert percuss("experiment", case, *asked).code == 0
        assert percuss("export", f"{name}.zarr", "-o", f"{name}.csv").code == 0
    assert {row["code"] for row in rows_of("e.csv")} <= set(OUTCOMES)
    heading, first = Path("m.csv").read_text().splitlines()[:2]
    assert "position [bar lengths]" in heading and ("return" in first or "power" in first)


def test_a_map_for_programs(percuss):
    asked = ("--quantity", "phase,stable,reason,label", "--modes", 8, "--curves", "-o", "map.zarr", "--json")
    found = percuss("sweep", "light.toml", *PLANE, *asked).json
    direct = sweep(SYSTEM, PLANE[1], PLANE[3], quantities=["phase", "stable", "reason"], modes=8, workers=1)
    assert [axis["name"] for axis in found["axes"]] == ["restitution", "load_factor"]
    assert found["quantities"]["stable"]["values"] == direct["stable"].tolist()
    phases = np.array(found["quantities"]["phase"]["values"], dtype=float)
    assert np.array_equal(phases, direct["phase"], equal_nan=True)
    assert found["quantities"]["reason"]["values"][2][2] == "stable"
    assert {curve["kind"] for curve in found["curves"]} == {"fold", "flip"}
    assert percuss("export", "map.zarr", "-o", "map.nc").code == 0
    xarray = pytest.importorskip("xarray")
    with xarray.open_dataset("map.nc") as data:
        assert np.array_equal(data["phase"].values, direct["phase"], equal_nan=True)
        assert data["phase"].attrs["units"] == "rad"
        assert "chatter/1" in data["label"].values.astype(str)


def test_an_experiment(percuss, whole):
    found = whole("experiment")
    assert (found["starts"], found["seed"], found["distribution"]) == (300, 5, "wall") and found["si"] is None
    assert sum(share["share"] for share in found["shares"]) == pytest.approx(1.0)
    keys = {"label", "share", "low", "high", "phases", "impact_velocities"}
    assert all(share.keys() == keys and share["low"] <= share["share"] <= share["high"] for share in found["shares"])
    Path("mine.csv").write_text("position,velocity,time\n-1,0,0.3\n-2,1,0.5\n0,-1,2\n", encoding="utf-8")
    own = percuss("experiment", "light.toml", "--distribution", "mine.csv", "--modes", 0, "--json")
    assert own.json["starts"] == 3
    scaled = percuss("experiment", "hydraulic-drifter", "--starts", 20, "--modes", 0, "--impacts", 100, "--json").json
    assert scaled["si"]["speed_m_s"] == load_case("hydraulic-drifter").system().speed_scale


def test_which_starts_of_a_machine_run(percuss, whole):
    percuss(*JOBS["machine"]).told("The machine runs from", "and stalls from", "period [s]")
    told = whole("machine")
    shares = {share["label"]: share for share in told["shares"]}
    assert shares["runs 1/1"]["period"] == pytest.approx(0.1213, rel=1e-3) and "frequency_Hz" not in told["si"]
    assert sum(share["share"] for share in told["shares"]) == pytest.approx(1.0)
    percuss("basins", "gas.toml", *STATES[:5], "state=shut").refused("'return', 'power'")
    percuss("basins", "gas.toml", "--x", "time=0:1:2", *STATES[2:]).refused("no clock")


def test_basins(whole):
    found = whole("basins")
    assert np.shape(found["image"]) == (7, 9) and found["attractors"][0]["label"]


def test_units_of_a_plane_are_those_of_the_case(percuss):
    ask = ("basins", "hydraulic-drifter", "--modes", 0, "--impacts", 100, "--json")
    system = load_case("hydraulic-drifter").system()
    done = percuss(*ask, "--x", "time=0:20 ms:4", "--y", "velocity=-6 m/s:-0.1:3", "--at", "position=-30 mm")
    found = done.json
    time, velocity = (axis["values"] for axis in found["axes"])
    assert np.allclose(time, np.linspace(0.0, 0.02, 4) / system.time_scale, rtol=1e-13)
    assert np.allclose(velocity, np.linspace(-6.0, -0.1, 3) / system.speed_scale, rtol=1e-13)
    assert found["at"] == {"position": pytest.approx(-0.03 / system.length_scale, rel=1e-13)}
    plain = [f"{name}=" + ",".join(map(repr, values)) for name, values in (("time", time), ("velocity", velocity))]
    same = percuss(*ask, "--x", plain[0], "--y", plain[1], "--at", f"position={found['at']['position']!r}")
    assert same.json == found
    scales = {"length_m": system.length_scale, "speed_m_s": system.speed_scale, "time_s": system.time_scale}
    assert found["si"] == scales | {"energy_J": system.energy_scale, "frequency_Hz": system.frequency}


def test_a_diagram(percuss):
    percuss(*JOBS["diagram"], "--csv", "d.csv", "--plot", "d.svg", "--show", "phase,speed,energy").told("fold")
    rows = rows_of("d.csv")
    assert {row["source"] for row in rows} == {"simulated", "branch"}
    scale = [float(row["speed_m_s [m/s]"]) / float(row["speed"]) for row in rows if float(row["speed"]) > 0.0]
    assert scale == pytest.approx([scale[0]] * len(scale), rel=1e-12)
    assert "m/s" in Path("d.svg").read_text(encoding="utf-8")
    answer = percuss("diagram", "possible.toml", "--along", "mean=0.6:1:3", *FEW, "--json").json
    assert answer["values"] == [0.6, 0.8, 1.0]
    assert {one["value"] for one in answer["settled"]} == {0.6, 0.8, 1.0}
    (branch,) = (one for one in answer["branches"] if one["label"] == "z=1/1")
    fold = next(point for point in branch["points"] if point["type"] == "fold")
    assert fold["value"] == pytest.approx(0.954929658551, abs=1e-10)
    assert len(branch["branch"]["phases"]) == len(branch["branch"]["value"]) == len(branch["branch"]["energy"])
    assert branch["branch"]["energy_J"] is None


# -- how far parameters may move --------------------------------------------------------------------------------------


def test_how_far_the_load_may_move(percuss):
    """From the flip at 0.654954 of the amplitude to the fold at 3/π of it."""
    asked = ("--starts", "0", "--modes", "0", "--reach-of", "load.mean", "--report", "report.html")
    sentence = (
        "8 kN: down to 6.55 kN, where the period doubles (then 2 blows in 2 load periods); up to 9.549 kN, where the "
        "motion ceases to"
    )
    percuss("steady", "si.toml", *asked).told(sentence)
    assert sentence in Path("report.html").read_text(encoding="utf-8")
    mean, restitution = percuss(
        "steady", "possible.toml", "--modes", "0", "--reach-of", "mean,restitution", "--json"
    ).json["reach"]
    assert mean["below"]["type"] == "flip"
    assert mean["below"]["value"] == pytest.approx(0.654954465051, abs=1e-10)
    assert mean["above"]["then"] == "chatter/1"
    assert restitution["below"]["value"] < 0.5 < restitution["above"]["value"]


def test_without_a_stable_motion_there_is_nothing_to_follow(percuss):
    Path("half.toml").write_text(CASES["possible"].replace("mean = 0.7", "mean = 0.5"), encoding="utf-8")
    asked = ("--starts", "0", "--modes", "0", "--reach")
    percuss("steady", "half.toml", *asked).told("no stable motion to follow")
    assert json.loads(percuss("steady", "half.toml", *asked, "--json").out)["reach"] == []
