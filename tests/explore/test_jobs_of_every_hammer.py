"""Experiments, basins and maps of every kind of hammer: the same bits however they are cut, kept and gone on with."""

from __future__ import annotations

import json
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
import pytest

from hammers import HAMMERS
from percuss import Bar, Kept, Load, Stop, System, run
from percuss.case import load_case, sweep_job_of
from percuss.errors import Interrupted
from percuss.explore import MACHINE_QUANTITIES, QUANTITIES, Archive, Axis, Basins, Experiment, carry_out
from percuss.explore.attractors.basin import basins_job
from percuss.explore.attractors.experiments import experiment_job
from percuss.explore.jobs.pool import Processes
from percuss.explore.sweeps import sweep_job
from percuss.model import Machine
from percuss.model.described import describe_machine, describe_system, machine_from, system_from

NEVER = lambda: False  # noqa: E731
STOP = Stop(impacts=100)
PLACES = ("position", -1.5, -0.1, 6), ("velocity", -2.0, -0.1, 4)
SEVERAL = System(s=8.0, d=0.3, restitution=0.2, load=Load.fourier([0.3, *(1.0 / k for k in range(1, 13))]))
ROOTS = ["phase", "reduced_margin", "margin", "phases"]
BLOWS = [name for name, quantity in QUANTITIES.items() if quantity.group == "blow"]
MAPPED = [name for name, quantity in MACHINE_QUANTITIES.items() if quantity.group == "machine"]


def mapped(name: str) -> Any:
    """A map of all that a hammer's cells may say."""
    what, modes, axes = HAMMERS[name]
    quantities = MAPPED if isinstance(what, Machine) else ["phase", "margin", "label", "blow_rate"]
    return sweep_job(what, *axes, quantities=quantities, modes=modes, stop=Stop(impacts=50))


JOBS: dict[str, Callable[..., Any]] = {
    **{
        f"experiment of {name}": partial(experiment_job, what, 24, "field", 2, modes=modes, stop=STOP)
        for name, (what, modes, _) in HAMMERS.items()
    },
    **{
        f"basins of {name}": partial(basins_job, what, *PLACES, modes=modes, stop=STOP)
        for name, (what, modes, _) in HAMMERS.items()
    },
    **{f"map of {name}": partial(mapped, name) for name in HAMMERS},
    "map of roots": partial(sweep_job, SEVERAL, "load_factor=0.05:1.2:20", "restitution=0:0.9:5", quantities=ROOTS),
    "map of blows": lambda: sweep_job_of(
        load_case("laboratory-striker"), [Axis.parsed("rock.stiffness=50 kN/mm:400 kN/mm:6")], BLOWS
    ),
}


def same(one: dict[str, Any], other: dict[str, Any]) -> None:
    """Bit for bit."""
    assert one.keys() == other.keys()
    for name in one:
        assert one[name].dtype == other[name].dtype and one[name].tobytes() == other[name].tobytes(), name


@pytest.mark.parametrize("make", JOBS.values(), ids=JOBS)
def test_however_it_is_cut(make: Callable[..., Any]) -> None:
    """In portions, and on threads: numpy may round a single number otherwise than the same number in a row."""
    job = make()
    whole = job.compute(0, job.size, NEVER)
    for name, column in job.columns.items():
        found = whole[name]
        assert found.dtype == np.dtype(column.dtype) and found.shape == (job.size, *column.shape), name
    for size in (1, max(job.size // 3, 2)):
        parts = [job.compute(i, min(i + size, job.size), NEVER) for i in range(0, job.size, size)]
        same({name: np.concatenate([part[name] for part in parts]) for name in whole}, whole)
    if "map" not in job.ask["kind"] and "sweep" not in job.ask["kind"]:
        two = make(threads=2)
        same(two.compute(0, job.size, NEVER), whole)
        assert two.ask == job.ask


@pytest.mark.parametrize("make", JOBS.values(), ids=JOBS)
def test_interrupted_kept_and_gone_on_with(
    make: Callable[..., Any], tmp_path: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whatever is there is that of the whole; the archive has the question, and gives the result back."""
    monkeypatch.setattr("percuss.explore.jobs.progress._LOOK", 0.0)  # however fast the job is
    job, path = make(), tmp_path / "a.zarr"
    chunk = max(1, job.size // 8)
    with pytest.raises(Interrupted):
        carry_out(job, workers=1, archive=path, chunk=chunk, progress=lambda now: now.done >= job.size // 3)
    with Archive.open(path) as archive:
        assert 0 < archive.items_done < job.size
        part, known = archive.read(), archive.known
    whole = carry_out(job, workers=1, archive=path, resume=True)
    same(whole, make().compute(0, job.size, NEVER))
    same({name: values[known] for name, values in part.items()}, {name: whole[name][known] for name in part})
    with Archive.open(path) as archive:
        again = archive.result()
        assert archive.ask == json.loads(json.dumps(job.ask))
    again.save(tmp_path / "a.nc")
    loaded = type(again).load(tmp_path / "a.nc")
    assert loaded.ask == again.ask and loaded.to_xarray().identical(again.to_xarray())
    assert len(again.to_pandas()) == job.size
    if isinstance(again, Experiment | Basins):
        assert (again.stop, again.system) == (STOP, job.system)
        same(again.columns, whole)
        once = type(again).of(job, whole)
        assert np.array_equal(again.label, once.label)
        assert [share.attractor for share in again.shares] == [share.attractor for share in once.shares]
    else:
        for name in set(again.quantities) & set(whole):
            assert again[name].tobytes() == whole[name].tobytes(), name


@pytest.mark.parametrize("name", [name for name in JOBS if "map" not in name])
def test_every_start_ends_as_its_own_motion(name: str) -> None:
    job = JOBS[name]()
    found = (Experiment if job.ask["kind"] == "experiment" else Basins).of(job, job.compute(0, job.size, NEVER))
    labels, starts = found.label.ravel().tolist(), job.starts(0, job.size)
    for i in range(0, job.size, 2):
        motion = run(job.system, starts[i], modes=job.modes, stop=STOP)
        assert (labels[i], found.columns["impacts"][i]) == (motion.label, motion.impacts)
        if "period" in found.columns:
            period = np.nan if motion.cycle is None else motion.cycle.period
            assert np.array_equal(found.columns["period"][i], period, equal_nan=True)
    names = np.array([attractor.label for attractor in found.attractors])
    assert names[found.numbers].tolist() == labels


def test_processes_and_questions_of_their_own() -> None:
    jobs = [make() for make in JOBS.values()]
    asks = {json.dumps(job.ask, sort_keys=True) for job in jobs}
    assert len(asks) == len(jobs)
    with Processes(2) as pool:
        for name in ("experiment of twins", "basins of machine", "map of smooth"):
            job = JOBS[name]()
            same(carry_out(job, pool=pool, chunk=11), job.compute(0, job.size, NEVER))


BAR = Bar(length=0.341, diameter=0.049, damping_ratio=1e-3)
IN_SI = System.from_si(BAR, Load.harmonic(5e3, 6e3, frequency=60.0), Kept(restitution=0.6))


@pytest.mark.parametrize("what", [*(one.what for one in HAMMERS.values()), IN_SI], ids=[*HAMMERS, "si"])
def test_a_hammer_comes_back_from_its_description(what: Any) -> None:
    describe, made = (describe_machine, machine_from) if isinstance(what, Machine) else (describe_system, system_from)
    again = made(json.loads(json.dumps(describe(what))))
    if what.bar is None:
        assert again == what and hash(again) == hash(what)
    else:
        assert (again.load, again.bar, again.s, again.d) == (what.load, what.bar, what.s, what.d)
        assert (again.energy_scale, again.frequency) == (what.energy_scale, what.frequency)
