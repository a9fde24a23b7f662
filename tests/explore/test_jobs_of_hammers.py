"""Every job that asks hammers: the same bits however it is cut, and back from an archive; a new one joins by a line."""

import json
from dataclasses import replace

import numpy as np
import pytest

from percuss import Load, Stop, System
from percuss.case import load_case, sweep_job_of
from percuss.errors import Interrupted
from percuss.explore import QUANTITIES, Archive, Axis, Basins, Experiment, Sweep, carry_out
from percuss.explore.attractors.basin import basins_job
from percuss.explore.attractors.experiments import experiment_job
from percuss.explore.sweeps import sweep_job
from percuss.model import Chamber, External, Kept, Machine, Port, Reversed, UniformBar, Valve

NEVER = lambda: False  # noqa: E731
PNEUMATIC = System(s=20.0, d=0.0, restitution=0.6, load=Load.harmonic(0.7, 1.0))
PORTS = Port("power", behind=1.0, side="back", delay=0.05), Port("return", on="impact")
GAS = Machine(UniformBar(20.0), Valve({"return": -0.3, "power": 1.0}, PORTS, chamber=Chamber(0.0, 1.2)), Kept(0.5))
VALVE = replace(GAS, body=UniformBar(20.0, External(0.01)), contact=Reversed(0.2))
SHORT = Stop(impacts=200)
PLANE = {"x": ("time", 0.0, 6.0, 9), "y": ("velocity", -4.0, -0.5, 7)}
OF_VALVES = {"x": ("position", -1.5, -0.1, 9), "y": ("velocity", -2.0, 2.0, 7), "at": {"state": "power"}}
BLOWS = [name for name, quantity in QUANTITIES.items() if quantity.group == "blow"]
CELLS = "restitution=0.3:0.7:4", "load_factor=0.5:0.9:3"
OVER_VALVES = "pressure=0.5:1.5:6", "ports[0].delay=0:0.6:5"
RUNS = ["stall", "runs", "starts", "blow_energy", "rate", "flow", "multiplier"]

JOBS = {
    "starts": lambda: experiment_job(PNEUMATIC, 90, "field", 2, modes=0, stop=SHORT),
    "elastic starts": lambda: experiment_job(PNEUMATIC, 60, "wall", 2, modes=3, stop=SHORT),
    "starts of a valve": lambda: experiment_job(GAS, 90, "field", 2, modes=0, stop=SHORT),
    "elastic starts of a valve": lambda: experiment_job(GAS, 60, "field", 2, modes=4, stop=SHORT),
    "a plane of starts": lambda: basins_job(PNEUMATIC, **PLANE, stop=SHORT),
    "a plane of starts of a valve": lambda: basins_job(GAS, **OF_VALVES, stop=SHORT),
    "a plane by arrays": lambda: sweep_job(PNEUMATIC, *CELLS, quantities=["phase", "reduced_margin", "phases"]),
    "cells": lambda: sweep_job(PNEUMATIC, *CELLS, quantities=["margin", "label", "blow_rate"], modes=2, stop=SHORT),
    "cells of valves": lambda: sweep_job(
        VALVE, "pressure=0.5:1.5:6", "ports[0].delay=0:0.6:5", quantities=RUNS, modes=0
    ),
    "elastic cells of valves": lambda: sweep_job(VALVE, "pressure=0.5:1.5:5", quantities=RUNS, modes=2),
    "blows": lambda: sweep_job_of(
        load_case("laboratory-striker"), [Axis.parsed("rock.stiffness=50 kN/mm:400 kN/mm:6")], BLOWS
    ),
}
RESULTS = {"experiment": Experiment, "basins": Basins, "sweep": Sweep}


def check_same(one, other):
    assert one.keys() == other.keys()
    for name in one:
        assert one[name].dtype == other[name].dtype and one[name].tobytes() == other[name].tobytes(), name


@pytest.mark.parametrize("name", JOBS)
def test_portions_threads_and_an_archive_change_no_bit(name, tmp_path):
    job = JOBS[name]()
    whole = job.compute(0, job.size, NEVER)
    assert {key: column.dtype for key, column in job.columns.items()} == {
        key: str(values.dtype) for key, values in whole.items()
    }
    assert all(whole[key].shape == (job.size, *column.shape) for key, column in job.columns.items())
    assert json.dumps(job.ask, allow_nan=False) == json.dumps(JOBS[name]().ask)
    for size in (1, 7) if job.size < 50 else (7, 31):
        parts = [job.compute(i, min(i + size, job.size), NEVER) for i in range(0, job.size, size)]
        check_same({key: np.concatenate([part[key] for part in parts]) for key in whole}, whole)
    if hasattr(job, "threads"):
        two = replace(job, threads=2)
        assert two.ask == job.ask
        check_same(two.compute(0, job.size, NEVER), whole)
    path = tmp_path / "job.zarr"
    with pytest.raises(Interrupted):
        carry_out(job, workers=1, archive=path, chunk=max(job.size // 6, 1), progress=lambda now: now.done > 1)
    half = Archive.open(path).result()
    kept = carry_out(job, workers=1, archive=path, resume=True)
    check_same({key: kept[key] for key in whole}, whole)
    found, kind = Archive.open(path).result(), RESULTS[job.ask["kind"]]
    assert isinstance(half, kind) and isinstance(found, kind)
    if kind is Sweep:
        for key in whole:
            assert found.arrays[key].tobytes() == whole[key].tobytes()
    else:
        once = kind.of(job, whole)
        check_same({key: found.columns[key] for key in whole}, whole)
        assert found.stop == job.stop and found.system == job.system and np.array_equal(found.label, once.label)
        assert [share.attractor for share in found.shares] == [share.attractor for share in once.shares]
