"""A motion broken off, saved, loaded in a new process and continued has the bits of one that was never interrupted."""

import json
import subprocess
import sys

import numpy as np
import pytest

from machine_strategies import random_machine, random_start, random_supplied
from percuss import Load, System
from percuss.case import load_case
from percuss.errors import ParameterError, PercussError
from percuss.model import Kept, Machine, Port, Supply, UniformBar, Valve
from percuss.simulate import Start, Stop, Trajectory, motion_files, run

STEPS = Load.steps([0.4, 2.5, 4.1], [1.5, 0.4, -1.0])
PORTS = (Port("power", 1.0, "back", 0.1), Port("return", on="impact"))
HAMMERS = {
    # hammer, modes, first stop, second stop
    "impacts": (System(s=5.0, d=0.0048, restitution=0.6, load=Load.harmonic(0.7, 1.0)), 8, {"impacts": 37}, 200),
    "rigid": (System(s=5.0, d=0.0, restitution=0.9, load=Load.harmonic(0.4, 1.0)), 0, {"impacts": 100}, 300),
    "time": (System(s=5.0, d=0.01, restitution=0.7, load=Load.harmonic(0.6, 1.0)), 5, {"time": 123.4}, 200),
    "steps": (System(s=3.0, d=0.1, restitution=0.8, load=STEPS), 4, {"time": 55.5}, 200),
    "resting": (System(s=3.0, d=0.1, restitution=0.0, load=STEPS), 3, {"time": 10.3}, 50),
    "chatter": (System(s=3.0, d=0.1, restitution=0.5, load=Load.square(1.0, 1.5)), 2, {"impacts": 23}, 300),
    "overdamped": (System(s=0.5, d=9.0, restitution=0.7, load=Load.harmonic(0.6, 1.0)), 6, {"impacts": 11}, 60),
    "harmonics": (
        System(s=2.0, d=0.1, restitution=0.7, load=Load.fourier([0.6, 1.0, 0.5j, 0.2, -0.1])), 3, {"impacts": 64}, 130,
    ),
    "valve": (load_case("valve-breaker").machine(), 3, {"impacts": 11}, 30),
    "supply": (
        Machine(UniformBar(20.0), Valve({"return": -0.4, "power": 1.8}, PORTS, supply=Supply(1.0, 5.0)), Kept(0.2)),
        2, {"time": 7.7}, 30,
    ),
}  # fmt: skip

SCRIPT = """
import sys
from percuss.simulate import Stop, Trajectory
for case in sys.argv[1:]:
    name, impacts = case.split(":")
    motion = Trajectory.load(f"{name}-part.nc")
    motion.continued(Stop(impacts=int(impacts), periodic=False)).save(f"{name}-whole.nc")
"""


def same(a, b):
    assert a.events.states == b.events.states
    for name, one in a.events.columns().items():
        other = getattr(b.events, name)
        assert one.dtype == other.dtype and one.tobytes() == other.tobytes(), name
    assert a.states.tobytes() == b.states.tobytes() and a.start.row.tobytes() == b.start.row.tobytes()
    for name, one in a.snapshot.items() if a.is_clocked else ():
        other = b.snapshot[name]
        if name == "count":
            one, other = one.copy(), other.copy()
            one["work"] = other["work"] = 0  # an interrupted flight is begun anew
        assert one.tobytes() == other.tobytes(), name
    for name in ("hammer", "label", "outcome", "cycle", "begin_time", "end_time", "resting"):
        assert getattr(a, name) == getattr(b, name), name


def start(hammer, modes):
    rng = np.random.default_rng(modes)
    if isinstance(hammer, Machine):
        return Start.rigid(-0.03, time=2.5)
    u, v = 0.05 * rng.normal(size=(2, modes + 1))
    u[0] = -0.6
    return Start.modal(u, v, 0.3)


def followed(name, impacts=None, **stop):
    hammer, modes, first, _ = HAMMERS[name]
    stop = stop or ({"impacts": impacts} if impacts is not None else first)
    return run(hammer, start(hammer, modes), modes=modes, stop=Stop(**stop, periodic=False))


@pytest.mark.parametrize("name", HAMMERS)
def test_continued(name, tmp_path):
    impacts = HAMMERS[name][3]
    whole, part = followed(name, impacts), followed(name)
    assert 0 < len(part.events) < len(whole.events) and whole.impacts == impacts
    same(part.continued(Stop(impacts=impacts, periodic=False)), whole)
    part.save(tmp_path / "part.nc")
    read = Trajectory.load(tmp_path / "part.nc")
    same(read, part)
    times = np.linspace(part.begin_time, part.end_time, 50)
    assert read.stop == part.stop and np.array_equal(read.position([0.0, 1.0], times), part.position([0.0, 1.0], times))
    same(read.continued(Stop(impacts=impacts, periodic=False)), whole)
    assert read.continued().impacts == 2 * part.impacts
    assert part.to_xarray()["time"].attrs["units"]
    table = part.to_pandas()
    assert table["kind"].tolist() == part.events.kind.tolist() and table["time"].tolist() == part.events.time.tolist()


@pytest.mark.parametrize("seed", range(35))
def test_a_broken_motion_of_a_machine_is_the_whole_one(seed: int) -> None:
    """Whatever the machine, and wherever it was broken off: at an impact, or at a time between events."""
    rng = np.random.default_rng(seed)
    if seed < 25:
        machine, modes = random_machine(rng)
        begin = random_start(rng, machine, modes)
    else:
        (machine, begin), modes = random_supplied(rng), int(rng.integers(0, 6))
    stop = Stop(impacts=40, time=60.0, periodic=bool(rng.integers(2)))
    whole = run(machine, begin, modes=modes, stop=stop)
    for earlier in (
        Stop(impacts=int(rng.integers(0, 8)), time=60.0),
        Stop(impacts=40, time=float(rng.uniform(0.0, 10.0))),
    ):
        part = run(machine, begin, modes=modes, stop=earlier)
        if part.outcome not in ("periodic", "stalls"):
            same(part.continued(stop), whole)
            assert len(part.events) <= len(whole.events)


def test_at_every_impact():
    whole = followed("chatter", 60)
    for impacts in range(60):
        part = followed("chatter", impacts)
        assert part.impacts == impacts
        same(part.continued(Stop(impacts=60, periodic=False)), whole)


def test_at_any_time():
    whole = followed("resting", 12)
    for time in np.random.default_rng(1).uniform(0.01, whole.end_time - 0.4, 40):
        part = followed("resting", time=time)
        assert part.end_time == part.begin_time + time
        same(part.continued(Stop(impacts=12, periodic=False)), whole)


@pytest.mark.parametrize("name", ["impacts", "valve"])
def test_interrupted(name):
    hammer, modes, _, _ = HAMMERS[name]
    stop = Stop(impacts=20_000, periodic=False)
    part = run(hammer, start(hammer, modes), modes=modes, stop=stop, progress=lambda now: now.impacts > 500)
    assert part.outcome == "interrupted" and 500 < part.impacts < 20_000
    known = part.impacts + 20
    same(part.continued(Stop(impacts=known, periodic=False)), followed(name, known))


def test_in_a_new_process(tmp_path):
    names = ("impacts", "steps", "chatter", "valve", "supply")
    for name in names:
        followed(name).save(tmp_path / f"{name}-part.nc")
    asked = [f"{name}:{HAMMERS[name][3]}" for name in names]
    subprocess.run([sys.executable, "-c", SCRIPT, *asked], check=True, timeout=300, cwd=tmp_path)
    for name in names:
        whole = followed(name, HAMMERS[name][3])
        went_on = Trajectory.load(tmp_path / f"{name}-whole.nc")
        same(went_on, whole)
        times = np.linspace(whole.begin_time, whole.end_time, 50)
        assert np.array_equal(went_on.gap(times), whole.gap(times))


def test_files_of_format_3_are_read(tmp_path):
    """Which knew no ports."""
    part = followed("chatter")
    old = part.to_xarray().load().drop_vars("port").assign_attrs(format="percuss trajectory 3")
    old.assign_attrs(sha256=motion_files.digest(old)).to_netcdf(tmp_path / "old.nc", engine="h5netcdf")
    read = Trajectory.load(tmp_path / "old.nc")
    same(read, part)
    same(read.continued(), part.continued())


# ---- Files of machines that no simulation has left; for those of systems see `test_simulate_damage`


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("code", 99), ("piece", 5), ("piece", -1), ("port", 2), ("phase", np.nan), ("impact_velocity", np.inf),
        ("resolved", -1), ("period", 1), ("engine_valve_order", 9), ("engine_z", np.nan),
    ],
)  # fmt: skip
def test_what_no_simulation_has_left_is_refused(tmp_path, name: str, value: float) -> None:
    data = run(HAMMERS["valve"][0], modes=2, stop=Stop(impacts=4, periodic=False)).to_xarray().load()
    values = data[name].values.copy()
    values.reshape(-1)[0] = value
    changed = data.assign({name: (data[name].dims, values, data[name].attrs)})
    changed.to_netcdf(tmp_path / "unsealed.nc", engine="h5netcdf")
    with pytest.raises(PercussError, match="not the ones that were written"):
        Trajectory.load(tmp_path / "unsealed.nc")
    sealed = changed.assign_attrs(sha256=motion_files.digest(changed))
    sealed.to_netcdf(tmp_path / "sealed.nc", engine="h5netcdf")
    with pytest.raises(PercussError, match="damaged"):
        Trajectory.load(tmp_path / "sealed.nc").continued()


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("state", 7), ("last", -1), ("waiting", 100_000), ("memo_state", 9), ("memo_waiting", -3), ("before", 2),
        ("handed", 1), ("force", np.nan), ("charge", np.inf),
    ],
)  # fmt: skip
@pytest.mark.parametrize("name", ["valve", "supply"])
def test_places_in_arrays_are_looked_at(name: str, field: str, value: float) -> None:
    motion = run(HAMMERS[name][0], modes=0, stop=Stop(impacts=4, periodic=False))
    motion.snapshot["valve_now"][field] = value
    with pytest.raises(PercussError, match=r"a (value|number) of"):
        motion.continued()
    del motion.snapshot["valve_now"]
    with pytest.raises(PercussError, match="valve_now"):
        motion.continued()
    with pytest.raises(ParameterError):
        motion.continued(3)  # type: ignore[arg-type]


def test_a_description_that_was_changed_is_refused(tmp_path) -> None:
    data = run(HAMMERS["valve"][0], modes=0, stop=Stop(impacts=2)).to_xarray()
    about = json.loads(data.attrs["description"])
    for wrong in ({"modes": 3}, {"start_piece": 2}, {"resting": 1}, {"end_time": -1.0}, {"stop": {"impacts": -4}}):
        changed = data.assign_attrs(description=json.dumps({**about, **wrong}))
        changed = changed.assign_attrs(sha256=motion_files.digest(changed))
        changed.to_netcdf(tmp_path / "x.nc", engine="h5netcdf")
        with pytest.raises(PercussError, match="damaged"):
            Trajectory.load(tmp_path / "x.nc")
