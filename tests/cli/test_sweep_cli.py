"""`percuss sweep`, `experiment` and `basins`: what they print and write, how they go on, every kind of bad input."""

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
from types import SimpleNamespace

import numpy as np
import pytest

from case_texts import plain_case
from percuss import Load, System
from percuss.case import load_case
from percuss.cli import main
from percuss.explore import REASONS, boundaries, sweep
from percuss.explore.attractors.basin import BasinsJob
from percuss.explore.attractors.experiments import ExperimentJob
from percuss.explore.quantities import CYCLE_KINDS
from percuss.simulate import OUTCOMES

CASE = 'title = "B77 scale"\n' + plain_case() + "[simulation]\nmodes = 2\nimpacts = 200\n"
SYSTEM = System(s=20.0, d=0.0048, restitution=0.6, load=Load.harmonic(0.9, 1.0))
BASINS = ("basins", "hydraulic-drifter", "--modes", "2")
PLANE = ("--x", "restitution=0.2:0.8:4", "--y", "load_factor=0.3:0.9:3")


@pytest.fixture
def percuss(tmp_path, monkeypatch, capsys):
    """The command in this process, in a folder with `case.toml`."""
    monkeypatch.chdir(tmp_path)
    Path("case.toml").write_text(CASE, encoding="utf-8")

    def command(*arguments):
        code = main([str(argument) for argument in arguments])
        out, err = capsys.readouterr()
        return SimpleNamespace(code=code, out=out, err=err, json=lambda: json.loads(out))

    return command


# -- sweep ------------------------------------------------------------------------------------------------------------


def test_a_map_of_a_machine_that_switches_its_own_valve(percuss):
    over = ("--x", "pressure=80 bar,160 bar", "--y", "ports[0].behind=100 mm,130 mm")
    asked = ("--quantity", "stall,runs,blow_energy,flow", "--modes", 0, "--plot", "map.png", "--csv", "map.csv")
    done = percuss("sweep", "valve-breaker", *over, *asked)
    assert done.code == 0 and Path("map.png").stat().st_size > 0
    assert re.search(r"stall\s+runs 50 %, stays on the wall 50 %", done.out)
    assert re.search(r"bar\s+rigid", done.out) and "load period" not in done.out
    rows = list(csv.DictReader(Path("map.csv").read_text(encoding="utf-8").splitlines()))
    assert [row["stall"] for row in rows] == ["stays on the wall"] * 2 + ["runs"] * 2
    told = percuss("sweep", "valve-breaker", *over, *asked[:4], "--json").json()
    assert told["periods"] is None and told["modes"] == 0
    assert told["quantities"]["stall"]["values"][1] == ["runs", "runs"]
    assert told["quantities"]["flow"]["unit"] == "m³/s"
    assert told["quantities"]["blow_energy"]["values"][0] == [None, None]


def test_where_a_machine_runs_is_solved_for(percuss):
    asked = ("--x", "pressure=100 bar:200 bar:3", "--quantity", "runs", "--modes", 0)
    done = percuss("sweep", "valve-breaker", *asked)
    assert re.search(r"runs\s+120\.\d+ to 200 bar", done.out), done.out
    refused = percuss("sweep", "valve-breaker", *asked, "--y", "ports[0].behind=100 mm,130 mm", "--curves")
    assert refused.code == 2 and "load that keeps time" in refused.err


def test_a_map_for_people(percuss):
    done = percuss("sweep", "case.toml", *PLANE, "--quantity", "orbits,stable,label", "--modes", 2, "--plot", "map.png")
    assert done.code == 0, done.err
    assert "12 cells over restitution and load_factor" in done.out
    assert "0.2 to 0.8, 4 values" in done.out and "chatter/1" in done.out and "picture: map.png" in done.out
    assert Path("map.png").read_bytes()[:4] == b"\x89PNG"


def test_a_map_of_one_axis_says_where_it_is_stable(percuss):
    """To the solved boundaries: a flip below, a fold above; and a line for each value."""
    ask = ("sweep", "case.toml", "--x", "load_factor=0.3:1.3:11", "--quantity", "stable,reason,orbits,phase")
    done = percuss(*ask, "--csv", "map.csv")
    assert done.code == 0, done.err
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
    assert "Values (40 of 200; --csv FILE writes all)" in done.out
    table = done.out[done.out.index("Values") :].splitlines()
    assert len(table) == 42 and table[2].split()[0] == "0.3" and table[-1].split()[0] == "1.3"
    assert "Values" not in percuss("sweep", "case.toml", *PLANE, "--quantity", "exists").out


def test_a_table_holds_words(percuss):
    """Reasons, outcomes and codes of labels; also of an archive that is exported."""
    axes = ("--x", "load_factor=-0.2,0.3,0.9", "--quantity", "reason,label,stable")
    assert percuss("sweep", "case.toml", *axes, "--csv", "a.csv", "-o", "a.zarr").code == 0
    assert percuss("export", "a.zarr", "-o", "b.csv").code == 0
    assert Path("a.csv").read_bytes() == Path("b.csv").read_bytes()
    with open("a.csv", encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["outcome"] for row in rows] == ["does not push", "ok", "ok"]
    assert rows[0]["reason"] == "" and rows[2]["reason"] == "stable" and rows[1]["reason"] in REASONS
    assert {row["label_outcome"] for row in rows} <= set(OUTCOMES) and rows[2]["label_kind"] in CYCLE_KINDS
    assert percuss("experiment", "case.toml", "--starts", 20, "--modes", 0, "-o", "e.zarr").code == 0
    assert percuss("export", "e.zarr", "-o", "e.csv").code == 0
    with open("e.csv", encoding="utf-8", newline="") as file:
        assert {row["code"] for row in csv.DictReader(file)} <= set(OUTCOMES)


def test_a_map_for_programs(percuss):
    done = percuss(
        "sweep", "case.toml", *PLANE, "--quantity", "phase,stable,reason", "--modes", 8, "--json", "--curves"
    )
    found = done.json()
    direct = sweep(SYSTEM, PLANE[1], PLANE[3], quantities=["phase", "stable", "reason"], modes=8, workers=1)
    assert [axis["name"] for axis in found["axes"]] == ["restitution", "load_factor"]
    assert found["quantities"]["stable"]["values"] == direct["stable"].tolist()
    phases = np.array(found["quantities"]["phase"]["values"], dtype=float)
    assert np.array_equal(phases, direct["phase"], equal_nan=True)
    assert found["quantities"]["reason"]["values"][2][2] == "stable"
    assert {curve["kind"] for curve in found["curves"]} == {"fold", "flip"}


def test_a_map_is_kept_and_resumed(percuss):
    ask = ("sweep", "case.toml", *PLANE, "--quantity", "label,phase", "--modes", 2)
    assert percuss(*ask, "-o", "map.zarr").code == 0
    again = percuss(*ask, "-o", "map.zarr")
    assert again.code == 2 and "--resume" in again.err
    assert percuss(*ask, "-o", "map.zarr", "--resume").code == 0
    other = percuss(*ask[:-1], 3, "-o", "map.zarr", "--resume")
    assert other.code == 2 and "modes" in other.err
    shown = percuss("show", "map.zarr")
    assert shown.code == 0 and "complete" in shown.out and "load_factor" in shown.out
    assert percuss("export", "map.zarr", "-o", "map.nc").code == 0
    xarray = pytest.importorskip("xarray")
    with xarray.open_dataset("map.nc") as data:
        direct = sweep(SYSTEM, PLANE[1], PLANE[3], quantities=["phase"], modes=2, workers=1)
        assert np.array_equal(data["phase"].values, direct["phase"], equal_nan=True)
        assert data["phase"].attrs["units"] == "rad"
        assert "chatter/1" in data["label"].values.astype(str)
    assert percuss("export", "map.zarr", "-o", "map.csv").code == 0
    assert len(Path("map.csv").read_text(encoding="utf-8").splitlines()) == 13


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["case.toml"], "--x"),
        (["case.toml", "--x", "friction=0:1:3"], "restitution, load_factor"),
        (["case.toml", "--x", "load_facto=0:1:3"], "did you mean 'load_factor'"),
        (["case.toml", "--x", "restitution=0:1:3", "--quantity", "stabil"], "exists, orbits"),
        (["case.toml", "--x", "restitution=0:1:3", "--quantity", ","], "one or more names"),
        (["case.toml", "--x", "restitution=0.9:0:3"], "swap the two ends"),
        (["case.toml", "--x", "restitution=0:1"], "FROM:TO:NUMBER"),
        (["case.toml", "--x", "restitution=0:1:0"], "restitution"),
        (["case.toml", "--x", "restitution=0:1:3", "--y", "restitution=0:1:3"], "one axis only"),
        (["case.toml", "--x", "restitution=0:0.9:100000", "--y", "s=1:20:100000", "--quantity", "label"], "--yes"),
        (["case.toml", "--x", "restitution=0:1:3", "--curves"], "--y"),
        (["case.toml", "--x", "restitution=0:1:3", "--periods", "1..3"], "m an axis"),
        (["case.toml", "--x", "restitution=0:1:3", "--plot", "map.gif"], ".png, .svg or .pdf"),
        (["case.toml", "--x", "restitution=0:1:3", "--csv", "none/map.csv"], "no folder 'none'"),
        (["case.toml", "--x", "restitution=0:1:3", "--resume"], "-o"),
        (["case.toml", "--x", "restitution=0:1:3", "-o", "map.nc"], "percuss export"),
        (["case.toml", "--x", "restitution=0:1:3", "--workers", "0"], "1 or greater"),
        (["case.toml", "--x", "s=1 m:2 m:3"], "s"),
        (["none.toml", "--x", "s=1:2:3"], "no such file"),
    ],
)
def test_maps_that_cannot_be_made(percuss, arguments, says):
    done = percuss("sweep", *arguments)
    assert (done.code, done.out) == (2, "") and says in done.err, done.err
    assert [path.name for path in Path().iterdir()] == ["case.toml"]


# -- experiment and basins --------------------------------------------------------------------------------------------


def test_an_experiment(percuss):
    ask = ("experiment", "case.toml", "--starts", 300, "--seed", 5, "--modes", 0)
    done = percuss(*ask, "--plot", "starts.png")
    assert done.code == 0, done.err
    assert "300, wall, seed 5" in done.out and "Attractors" in done.out
    found = percuss(*ask, "--json", "--workers", 2).json()
    assert (found["starts"], found["seed"], found["distribution"]) == (300, 5, "wall")
    assert sum(share["share"] for share in found["shares"]) == pytest.approx(1.0)
    keys = {"label", "share", "low", "high", "phases", "impact_velocities"}
    assert all(share.keys() == keys and share["low"] <= share["share"] <= share["high"] for share in found["shares"])
    assert percuss(*ask, "--json").json() == found
    assert percuss(*ask, "-o", "e.zarr", "--json").json() == found
    assert percuss(*ask, "-o", "e.zarr", "--resume", "--json").json() == found
    refused = percuss("experiment", "case.toml", "--starts", 300, "--seed", 6, "--modes", 0, "-o", "e.zarr", "--resume")
    assert refused.code == 2 and "seed" in refused.err


def test_own_starts(percuss):
    Path("mine.csv").write_text("position,velocity,time\n-1,0,0.3\n-2,1,0.5\n0,-1,2\n", encoding="utf-8")
    found = percuss("experiment", "case.toml", "--distribution", "mine.csv", "--modes", 0, "--json").json()
    assert found["starts"] == 3


def test_basins(percuss):
    ask = ("basins", "case.toml", "--x", "time=0:6.2:9", "--y", "velocity=-6:-0.1:7", "--modes", 0)
    done = percuss(*ask, "--plot", "basins.png", "-o", "b.zarr")
    assert done.code == 0, done.err
    assert "63 starts" in done.out and Path("basins.png").exists()
    found = percuss(*ask, "--json").json()
    assert np.shape(found["image"]) == (7, 9) and found["attractors"][0]["label"]
    assert percuss("show", "b.zarr").code == 0
    assert percuss("export", "b.zarr", "-o", "b.nc").code == 0


def test_units_of_a_plane_are_those_of_the_case(percuss):
    ask = ("basins", "hydraulic-drifter", "--modes", 0, "--impacts", 100, "--json")
    system = load_case("hydraulic-drifter").system()
    done = percuss(*ask, "--x", "time=0:20 ms:4", "--y", "velocity=-6 m/s:-0.1:3", "--at", "position=-30 mm")
    assert done.code == 0, done.err
    found = done.json()
    time, velocity = (axis["values"] for axis in found["axes"])
    assert np.allclose(time, np.linspace(0.0, 0.02, 4) / system.time_scale, rtol=1e-13)
    assert np.allclose(velocity, np.linspace(-6.0, -0.1, 3) / system.speed_scale, rtol=1e-13)
    assert found["at"] == {"position": pytest.approx(-0.03 / system.length_scale, rel=1e-13)}
    plain = [f"{name}=" + ",".join(map(repr, values)) for name, values in (("time", time), ("velocity", velocity))]
    same = percuss(*ask, "--x", plain[0], "--y", plain[1], "--at", f"position={found['at']['position']!r}")
    assert same.json() == found
    assert found["si"] == {
        "length_m": system.length_scale,
        "speed_m_s": system.speed_scale,
        "time_s": system.time_scale,
        "energy_J": system.energy_scale,
        "frequency_Hz": system.frequency,
    }


def test_scales_of_an_experiment(percuss):
    ask = ("--starts", 20, "--modes", 0, "--impacts", 100, "--json")
    system = load_case("hydraulic-drifter").system()
    assert percuss("experiment", "hydraulic-drifter", *ask).json()["si"]["speed_m_s"] == system.speed_scale
    assert percuss("experiment", "case.toml", *ask).json()["si"] is None


@pytest.mark.parametrize(
    "ask",
    [
        ("experiment", "case.toml", "--starts", 1_000_000_000),
        ("basins", "case.toml", "--x", "time=0:6:100000", "--y", "velocity=-6:0:100000"),
    ],
)
def test_what_no_memory_holds_is_refused_after_a_sample(percuss, monkeypatch, ask):
    for job in (ExperimentJob, BasinsJob):

        def compute(self, first, last, stopped, whole=job.compute):
            assert last - first < 1_000_000, "computed before it was agreed to"
            return whole(self, first, last, stopped)

        monkeypatch.setattr(job, "compute", compute)
    done = percuss(*ask, "--modes", 0)
    assert (done.code, done.out) == (2, "") and "--yes" in done.err and re.search(r"\d [GT]B", done.err)
    monkeypatch.setattr("percuss.explore.jobs.carrying_out._memory", lambda: 64e9)
    done = percuss(*ask, "--modes", 0, "--yes")
    assert (done.code, done.out) == (2, "") and "of memory" in done.err


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["experiment", "case.toml", "--distribution", "walls"], "wall"),
        (["experiment", "case.toml", "--starts", "0"], "at least one start"),
        (["experiment", "case.toml", "--starts", "many"], "whole number"),
        (["experiment", "case.toml", "--distribution", "case.toml"], "case.toml"),
        (["basins", "case.toml", "--x", "time=0:6:5"], "--y"),
        (["basins", "case.toml", "--x", "time=0:6:5", "--y", "phase=0:6:5"], "position, velocity, time"),
        (["basins", "case.toml", "--x", "time=0:6:5", "--y", "position=0:1:5"], "the wall is at 0"),
        (["basins", "case.toml", "--x", "time=0:6:5", "--y", "velocity=-1:0:5", "--at", "time=1"], "not on an axis"),
        (["basins", "case.toml", "--x", "time=0:6:5", "--y", "velocity=-1:0:5", "--at", "place=1"], "position"),
        (["experiment", "case.toml", "--impacts", "0"], "at least one impact"),
        ([*BASINS, "--x", "time=0:6:5", "--y", "velocity=-1:0:5", "--impacts", "0"], "at least one impact"),
        ([*BASINS, "--x", "time=0:6 furlongs:4", "--y", "velocity=-6:-1:3"], "a unit of length"),
        ([*BASINS, "--x", "time=0:6 mm:4", "--y", "velocity=-6:-1:3"], "a unit of length"),
        ([*BASINS, "--x", "time=0:6:4", "--y", "u_1=-1 mm:1 mm:3"], "only position, velocity, time have units"),
        ([*BASINS, "--x", "time=0:6:4", "--y", "velocity=-6:-1:3", "--at", "position=-3 s"], "a unit of time"),
        ([*BASINS, "--x", "time=0:6:4", "--y", "velocity=-6:-1:3", "--at", "u_1=3 mm"], "have units"),
        ([*BASINS, "--x", "time=0:6:4", "--y", "velocity=-6:-1:3", "--at", "position=far"], "NAME=NUMBER"),
        (["basins", "case.toml", "--x", "time=0:6 ms:4", "--y", "velocity=-6:-1:3"], "units need a case in SI"),
        (
            ["basins", "case.toml", "--x", "time=0:6:4", "--y", "velocity=-6:-1:3", "--at", "position=-3 mm"],
            "units need a case in SI",
        ),
    ],
)
def test_starts_that_there_are_not(percuss, arguments, says):
    done = percuss(*arguments)
    assert (done.code, done.out) == (2, "") and says in done.err, done.err


# -- interruptions ----------------------------------------------------------------------------------------------------

# Seconds of work beyond the first part of its archive, so that a signal finds it at work and not done.
LONG = ["sweep", "case.toml", "--x", "restitution=0.1:0.8:80", "--y", "load_factor=0.2:0.9:80", "--quantity", "label",
        "--modes", "16", "--impacts", "20000", "-o", "map.zarr"]  # fmt: skip


def begun(arguments, folder):
    """The command in a process group of its own, once a part of its archive is written."""
    child = subprocess.Popen(
        [sys.executable, "-m", "percuss", *arguments],
        cwd=folder,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    ends = time.monotonic() + 120.0
    while time.monotonic() < ends and child.poll() is None:
        if len(list(folder.glob("map.zarr/done/c/*"))) >= 1:
            return child
        time.sleep(0.02)
    out, err = child.communicate()
    raise AssertionError(f"nothing was written: {out}{err}")


@pytest.mark.slow
@pytest.mark.skipif(os.name != "posix", reason="process groups and signals")
def test_killed_and_interrupted_maps_go_on(percuss, tmp_path):
    assert percuss(*LONG[:-1], "whole.zarr").code == 0
    for how in (signal.SIGKILL, signal.SIGINT):
        shutil.rmtree("map.zarr", ignore_errors=True)
        child = begun(LONG, tmp_path)
        sent = time.monotonic()
        os.kill(child.pid, how)
        _, err = child.communicate(timeout=60)
        if how == signal.SIGINT:
            assert time.monotonic() - sent < 4.0
            assert child.returncode == 130
            assert "--resume" in err
        assert percuss("show", "map.zarr").code == 0
        done = percuss(*LONG, "--resume")
        assert done.code == 0, done.err
    for name in ("whole", "map"):
        assert percuss("export", f"{name}.zarr", "-o", f"{name}.csv").code == 0
    assert Path("whole.csv").read_bytes() == Path("map.csv").read_bytes()
