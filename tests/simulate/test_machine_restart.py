"""Motions of machines saved, read and continued: the same bits as without a break; what is damaged is refused."""

from __future__ import annotations

import json

import numpy as np
import pytest

from machine_strategies import random_machine, random_start
from percuss.case import load_case
from percuss.errors import ParameterError, PercussError
from percuss.model import Load, System
from percuss.simulate import MachineTrajectory, Start, Stop, Trajectory, motion_files, run, run_machine
from percuss.simulate.saved_motion import saved_motion

xarray = pytest.importorskip("xarray")
pytest.importorskip("h5netcdf")


def same(one: MachineTrajectory, other: MachineTrajectory) -> None:
    for name in ("code", "time", "velocity", "rebound_velocity", "energy_lost", "kinetic_energy", "state", "port"):
        assert np.array_equal(getattr(one.events, name), getattr(other.events, name)), name
    assert np.array_equal(one.states, other.states)
    told = [(m.label, m.outcome, repr(m.cycle), m.end_time, m.first_state, m.resting) for m in (one, other)]
    assert told[0] == told[1]


@pytest.mark.parametrize("seed", range(25))
def test_a_broken_motion_is_the_whole_one(seed: int) -> None:
    """Whatever the machine, and wherever it was broken off: at an impact, or at a time between events."""
    rng = np.random.default_rng(seed)
    machine, modes = random_machine(rng)
    start = random_start(rng, machine, modes)
    stop = Stop(impacts=40, time=60.0, periodic=bool(rng.integers(2)))
    whole = run_machine(machine, start, modes=modes, stop=stop)
    for earlier in (Stop(impacts=int(rng.integers(0, 8))), Stop(impacts=40, time=float(rng.uniform(0.0, 10.0)))):
        part = run_machine(machine, start, modes=modes, stop=earlier)
        if part.outcome in ("periodic", "stalls"):
            continue
        again = part.continued(stop)
        same(again, whole)
        assert len(part.events) <= len(whole.events)


def test_a_file_holds_the_motion_and_goes_on(tmp_path) -> None:
    machine = load_case("valve-breaker").machine()
    start = Start.rigid(-0.03, time=2.5)
    whole = run_machine(machine, start, modes=3, stop=Stop(impacts=30, periodic=False))
    part = run_machine(machine, start, modes=3, stop=Stop(impacts=11, periodic=False))
    part.save(tmp_path / "m.nc")
    read = MachineTrajectory.load(tmp_path / "m.nc")
    same(read, part)
    assert read.machine == machine and read.stop == part.stop and read.begin_time == 2.5
    t = np.linspace(2.5, part.end_time, 50)
    assert np.array_equal(read.position([0.0, 1.0], t), part.position([0.0, 1.0], t))
    same(read.continued(Stop(impacts=30, periodic=False)), whole)
    twice = read.continued()
    assert twice.impacts == 22 and np.array_equal(twice.events.time, whole.events.time[: len(twice.events)])
    data = part.to_xarray()
    assert data["time"].attrs["units"] and data.attrs["states"] == "return, power"


def test_a_cancelled_motion_goes_on() -> None:
    machine = load_case("valve-drifter").machine()
    stop = Stop(impacts=10**6, periodic=False)
    part = run_machine(machine, Start.rigid(-0.01), modes=0, stop=stop, progress=lambda now: True)
    assert part.outcome == "cancelled" and part.impacts < 10**6
    known = part.impacts + 20
    whole = run_machine(machine, Start.rigid(-0.01), modes=0, stop=Stop(impacts=known, periodic=False))
    same(part.continued(Stop(impacts=known, periodic=False)), whole)


def test_either_kind_of_motion_is_read_as_what_it_is(tmp_path) -> None:
    system = System(s=5.0, d=0.0048, restitution=0.6, load=Load.harmonic(0.7, 1.0))
    run(system, modes=0, stop=Stop(impacts=3)).save(tmp_path / "clocked.nc")
    run_machine(load_case("valve-breaker").machine(), modes=0, stop=Stop(impacts=3)).save(tmp_path / "machine.nc")
    assert isinstance(saved_motion(tmp_path / "clocked.nc"), Trajectory)
    assert isinstance(saved_motion(tmp_path / "machine.nc"), MachineTrajectory)
    with pytest.raises(PercussError, match="percuss machine trajectory"):
        Trajectory.load(tmp_path / "machine.nc")
    with pytest.raises(PercussError, match="percuss trajectory"):
        MachineTrajectory.load(tmp_path / "clocked.nc")
    with pytest.raises(PercussError, match="no such file"):
        MachineTrajectory.load(tmp_path / "nothing.nc")
    with pytest.raises(ParameterError):
        saved_motion(tmp_path / "machine.nc").continued(3)  # type: ignore[arg-type]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("code", 99), ("state", 5), ("state", -1), ("port", 2), ("time", np.nan), ("velocity", np.inf),
        ("resolved", -1), ("engine_valve_order", 9), ("engine_z", np.nan),
    ],
)  # fmt: skip
def test_what_no_simulation_has_left_is_refused(tmp_path, name: str, value: float) -> None:
    motion = run_machine(load_case("valve-breaker").machine(), modes=2, stop=Stop(impacts=4, periodic=False))
    data = motion.to_xarray().load()
    values = data[name].values.copy()
    values.reshape(-1)[0] = value
    changed = data.assign({name: (data[name].dims, values, data[name].attrs)})
    changed.to_netcdf(tmp_path / "unsealed.nc", engine="h5netcdf")
    with pytest.raises(PercussError, match="not the ones that were written"):
        MachineTrajectory.load(tmp_path / "unsealed.nc")
    sealed = changed.assign_attrs(sha256=motion_files.digest(changed, "machine"))
    sealed.to_netcdf(tmp_path / "sealed.nc", engine="h5netcdf")
    with pytest.raises(PercussError, match="damaged"):
        MachineTrajectory.load(tmp_path / "sealed.nc").continued()


@pytest.mark.parametrize(
    ("field", "value"), [("state", 7), ("last", -1), ("waiting", 100_000), ("memo_state", 9), ("memo_waiting", -3)]
)
def test_places_in_arrays_are_looked_at(field: str, value: int) -> None:
    motion = run_machine(load_case("valve-breaker").machine(), modes=0, stop=Stop(impacts=4, periodic=False))
    motion.snapshot["valve_now"][field] = value
    with pytest.raises(PercussError, match=field):
        motion.continued()
    del motion.snapshot["valve_now"]
    with pytest.raises(PercussError, match="valve_now"):
        motion.continued()


def test_a_description_that_was_changed_is_refused(tmp_path) -> None:
    data = run_machine(load_case("valve-breaker").machine(), modes=0, stop=Stop(impacts=2)).to_xarray()
    about = json.loads(data.attrs["description"])
    for wrong in ({"modes": 3}, {"first_state": 2}, {"resting": 1}, {"end_time": -1.0}, {"stop": {"impacts": -4}}):
        changed = data.assign_attrs(description=json.dumps({**about, **wrong}))
        changed = changed.assign_attrs(sha256=motion_files.digest(changed, "machine"))
        changed.to_netcdf(tmp_path / "x.nc", engine="h5netcdf")
        with pytest.raises(PercussError, match="damaged"):
            MachineTrajectory.load(tmp_path / "x.nc")
