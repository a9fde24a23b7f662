"""A motion broken off, saved, loaded in a new process and continued has the bits of one that was never interrupted."""

from __future__ import annotations

import json
import subprocess
import sys
import textwrap
from pathlib import Path

import numpy as np
import pytest

from machine_strategies import random_machine, random_start, random_supplied
from percuss import Load, System
from percuss.case import load_case
from percuss.errors import ParameterError, PercussError
from percuss.model import Kept, Machine, ModalBody, Port, Supply, UniformBar, Valve
from percuss.simulate import Start, Stop, Trajectory, motion_files, run
from percuss.simulate.kernels.motion_records import COUNT, GRAZED

TWO = ModalBody((3.3, 7.3), (0.3, 0.1), (1.0, 0.8), (1.0, -0.5), -0.01)
ONE = ModalBody((3.3,), (0.3,), (1.0,), (1.0,), -0.01)
STEPS, COSINE = Load.steps([0.4, 2.5, 4.1], [1.5, 0.4, -1.0]), Load.harmonic(0.0, 1.0)
FED = Supply(1.0, 5.0, quickening=0.5)
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
    "structure at rest": (System(TWO, COSINE, Kept(0.4)), 2, {"impacts": 9}, 40),
    "mode at rest": (System(ONE, COSINE, Kept(0.4)), 1, {"impacts": 9}, 40),
    "valve": (load_case("valve-breaker").machine(), 3, {"impacts": 11}, 30),
    "supply": (
        Machine(UniformBar(20.0), Valve({"return": -0.4, "power": 1.8}, PORTS, supply=FED), Kept(0.2)),
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
    if isinstance(hammer.body, ModalBody):
        return Start.rigid(-0.3, 0.0, 0.4)
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


@pytest.mark.parametrize("name", ["resting", "structure at rest", "mode at rest"])
def test_at_any_time(name):
    """Also while the bar or the structure lies on the wall."""
    whole = followed(name, 12)
    for time in np.random.default_rng(1).uniform(0.01, whole.end_time - whole.begin_time, 40):
        part = followed(name, time=time)
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


# ---- Files of machines that no simulation has left


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


# -- files that were cut short, changed or made up ---------------------------------------------------------------------


xarray = pytest.importorskip("xarray")
pytest.importorskip("h5netcdf")

STEPPED = System(s=3.0, d=0.1, restitution=0.8, load=Load.steps([0.4, 2.5, 4.1], [1.5, 0.4, -1.0]))
SMOOTH = System(s=5.0, d=0.0048, restitution=0.6, load=Load.harmonic(0.7, 1.0))


@pytest.fixture(scope="module")
def motions() -> dict[str, Trajectory]:
    stop = Stop(impacts=30, periodic=False)
    start = Start.rigid(-0.3, 0.1, 0.2)
    return {
        "steps": run(STEPPED, start, modes=3, stop=stop),
        "smooth": run(SMOOTH, start, modes=4, stop=stop),
        "rigid": run(SMOOTH, start, modes=0, stop=Stop(impacts=200)),
        "untouched": run(SMOOTH, start, modes=2, stop=Stop(impacts=0)),
        "resting": run(SMOOTH, Start.rigid(0.0, 0.0, 0.0), modes=2, stop=Stop(time=0.5)),
        "released": run(STEPPED, Start.rigid(0.0, 0.0, 0.0), modes=2, stop=Stop(time=3.0)),
        "departed": run(System(1.0, 0.0, 0.5, Load.harmonic(-0.5, 1.0)), Start.rigid(-1.0, 0.0, 0.0), modes=2),
    }


def sealed(dataset: xarray.Dataset) -> xarray.Dataset:
    """With the check sum of what it holds now, as who makes such a file on purpose can write it."""
    try:
        return dataset.assign_attrs(sha256=motion_files.digest(dataset))
    except LookupError:  # what has no check sum any more is refused for that
        return dataset


def damaged(motion: Trajectory, folder: Path, only: tuple[str, ...] = ()) -> list[str]:
    """Files of one motion, each with one thing wrong."""
    whole = motion.to_xarray()
    made: list[str] = []

    def keep(name: str, dataset: xarray.Dataset) -> None:
        sealed(dataset).to_netcdf(folder / name, engine="h5netcdf")
        made.append(str(folder / name))

    for name in [*whole.data_vars, "mode"]:
        if name in ("time", "displacement", "velocity", "mode") or name not in (only or whole):  # made for others
            continue
        array = whole[name]
        if array.size:
            values = array.values
            for dim in array.dims:
                for what, size in (("short", array.sizes[dim] - 1), ("one", 1), ("empty", 0), ("long", 99)):
                    if size == array.sizes[dim]:
                        continue
                    places = np.arange(size) % array.sizes[dim]
                    one = array.isel({dim: places}).rename({d: f"{name}_{d}" for d in array.dims})
                    keep(f"{name}-{dim}-{what}.nc", whole.drop_vars(name).assign({name: one.drop_vars(one.coords)}))
            keep(f"{name}-type.nc", whole.assign({name: (array.dims, values.astype(np.float32), array.attrs)}))
            keep(f"{name}-words.nc", whole.assign({name: (array.dims, values.astype(str))}))
            wrong = (
                (np.nan, -np.inf, 1e200)
                if array.dtype.kind == "f"
                else (99, -99)
                if name == "code"
                else (2**62, -(2**62))
            )
            for value in wrong:
                bad = values.copy()
                bad.reshape(-1)[bad.size // 2] = value
                keep(f"{name}-{value}.nc", whole.assign({name: (array.dims, bad)}))
        keep(f"{name}-missing.nc", whole.drop_vars(name))
    return made


# the whole program of a fresh process: what a crash takes with it is named by the last line
CONTINUE = """
    import sys
    from percuss.errors import PercussError
    from percuss.recordings import separate_process
    from percuss.simulate import Stop, Trajectory
    separate_process.inside = True  # hundreds of files, each of which a process would take longer over
    for name in sys.argv[1:]:
        print(name, flush=True)
        try:
            Trajectory.load(name).continued(Stop(impacts=60, periodic=False))
        except PercussError as error:
            assert "damaged" in str(error), error
        else:
            print("PASSED", name, flush=True)
    print("end")
"""


def tried(files: list[str]) -> list[str]:
    """The files that were followed further; the process must live."""
    command = [sys.executable, "-c", textwrap.dedent(CONTINUE), *files]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300)
    lines = done.stdout.splitlines()
    assert done.returncode == 0 and lines[-1] == "end", (done.returncode, lines[-1:], done.stderr[-800:])
    return [line.removeprefix("PASSED ") for line in lines if line.startswith("PASSED ")]


@pytest.mark.slow
@pytest.mark.parametrize("which", ["steps", "rigid"])
def test_every_variable_damaged_in_every_way(motions, which, tmp_path):
    files = damaged(motions[which], tmp_path)
    assert len(files) > 100
    assert not [name for name in tried(files)]


@pytest.mark.slow
def test_the_arrays_of_the_kernels_damaged(motions, tmp_path):
    """Of these an abort, a crash and endless runs were made: engine_sums of length 1 and their like."""
    files = damaged(motions["steps"], tmp_path, ("engine_sums", "engine_now"))
    assert len(files) > 15
    assert not tried(files)


@pytest.mark.slow
@pytest.mark.parametrize("name", COUNT.names)
def test_whole_numbers_that_are_places(motions, name, tmp_path):
    """Far outside, one too many, one too few: refused wherever such a number is used as a place in an array."""
    motion = motions["steps"]
    whole = motion.to_xarray()
    sound = whole["engine_count"].values
    free = ("period", "anchor_period", "pile", "work", "patience", "rests", "chatters", "release_period", "mark_period")
    free += ("mark_patience", "mark_releases", "mark_chatters", "cycle_periods")
    for value in (-1, len(motion.system.load.values), GRAZED + 1, 2**40, -(2**40)):
        fits = name in free or (0 <= value <= motion.impacts and name not in ("piece", "mode"))
        if fits and name not in ("impacts", "events"):
            continue
        if name == "mode" and 0 <= value <= GRAZED:
            continue
        count = np.where(np.arange(len(COUNT.names)) == COUNT.names.index(name), value, sound)
        changed = whole.assign(engine_count=(whole["engine_count"].dims, count, whole["engine_count"].attrs))
        sealed(changed).to_netcdf(tmp_path / "x.nc", engine="h5netcdf")
        with pytest.raises(PercussError, match="damaged"):
            Trajectory.load(tmp_path / "x.nc").continued(Stop(impacts=60, periodic=False))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("attribute", "key", "value"),
    [
        ("description", "modes", 4.0), ("description", "modes", -1), ("description", "modes", 10**9),
        ("description", "start_phase", 1e9), ("description", "start_piece", 3), ("description", "start_piece", -1),
        ("description", "resting", 1), ("description", "begin_time", float("nan")), ("description", "end_time", -5.0),
        ("description", "end_time", "1"), ("description", "stop", {"impacts": -1}), ("description", "stop", {"x": 1}),
        ("description", "stop", None), ("description", "cycle", {"first": 0}),
        ("description", "cycle", {"first": 10**6, "impacts": 1, "periods": 1, "kind": 0}),
        ("system", "s", float("inf")), ("system", "s", "x"), ("system", "d", -1.0),
        ("system", "load", {"coefficients": [["x"]]}), ("system", "bar", {"length": 0.0}),
        ("system", "load", {"coefficients": [[1.0, 0.0]], "breaks": [0.4], "values": [1.5]}),
        ("system", "load", {"coefficients": [[1.0, 0.0]], "breaks": [0.4, 1.0], "values": [1.5]}),
    ],
)  # fmt: skip
def test_what_is_said_about_it(motions, attribute, key, value, tmp_path):
    dataset = motions["steps"].to_xarray()
    about = {**json.loads(dataset.attrs[attribute]), key: value}
    sealed(dataset.assign_attrs({attribute: json.dumps(about)})).to_netcdf(tmp_path / "x.nc", engine="h5netcdf")
    with pytest.raises(PercussError, match="damaged"):
        Trajectory.load(tmp_path / "x.nc")


@pytest.mark.parametrize("attribute", ["system", "description"])
def test_brackets_without_end(motions, attribute, tmp_path):
    dataset = sealed(motions["steps"].to_xarray().assign_attrs({attribute: "[" * 60_000}))
    dataset.to_netcdf(tmp_path / "x.nc", engine="h5netcdf")
    with pytest.raises(PercussError, match="damaged"):
        Trajectory.load(tmp_path / "x.nc")


@pytest.mark.slow
def test_flipped_bits(motions, tmp_path):
    """A file with any bit changed is refused, or is the same motion: the change was where nothing is kept."""
    motion = motions["steps"]
    motion.save(tmp_path / "whole.nc")
    data = (tmp_path / "whole.nc").read_bytes()
    chance, same = np.random.default_rng(11), 0
    for _ in range(60):
        at, bit = int(chance.integers(len(data))), int(chance.integers(8))
        bad = bytearray(data)
        bad[at] ^= 1 << bit
        (tmp_path / "bad.nc").write_bytes(bad)
        try:
            found = Trajectory.load(tmp_path / "bad.nc")
        except PercussError:
            continue
        same += 1
        assert found.states.tobytes() == motion.states.tobytes()
        assert all(found.snapshot[name].tobytes() == array.tobytes() for name, array in motion.snapshot.items())
        assert found.events.phase.tobytes() == motion.events.phase.tobytes() and found.system == motion.system
    assert same < 50


def test_cut_short(motions, tmp_path):
    motions["steps"].save(tmp_path / "whole.nc")
    data = (tmp_path / "whole.nc").read_bytes()
    for size in range(0, len(data), len(data) // 20):
        (tmp_path / "cut.nc").write_bytes(data[:size])
        with pytest.raises(PercussError, match="damaged"):
            Trajectory.load(tmp_path / "cut.nc")


def test_few_bytes_that_stand_for_many(motions, tmp_path):
    """Nothing is unpacked, and no other file is read."""
    import h5py

    motions["steps"].save(tmp_path / "whole.nc")
    motions["smooth"].save(tmp_path / "other.nc")
    for what in ("huge", "virtual", "linked"):
        path = tmp_path / f"{what}.nc"
        path.write_bytes((tmp_path / "whole.nc").read_bytes())
        with h5py.File(path, "r+") as content:
            del content["state"]
            if what == "huge":
                content.create_dataset("state", shape=(10**6, 10**6), dtype="f8", chunks=(1000, 1000))
            elif what == "virtual":
                layout = h5py.VirtualLayout(shape=(4000,), dtype="f8")
                layout[:] = h5py.VirtualSource(str(tmp_path / "other.nc"), "time", shape=(4000,))
                content.create_virtual_dataset("state", layout)
            else:
                content["state"] = h5py.ExternalLink(str(tmp_path / "other.nc"), "state")
        with pytest.raises(PercussError, match=r"more than|another file"):
            Trajectory.load(path)


def test_whatever_a_simulation_leaves_is_sound(motions, tmp_path):
    for name, motion in motions.items():
        path = tmp_path / f"{name}.nc"
        motion.save(path)
        found = Trajectory.load(path)
        assert found.states.tobytes() == motion.states.tobytes()
        assert (found.label, found.outcome, found.cycle) == (motion.label, motion.outcome, motion.cycle)


LOADS = [
    Load.harmonic(1.5, 1.0), Load.harmonic(0.3, 1.0), Load.harmonic(-0.3, 1.0), Load.fourier([0.2, 0.4, 1.0j]),
    Load.steps([0.4, 2.5, 4.1], [1.5, 0.4, -1.0]), Load.square(1.0, 1.3),
]  # fmt: skip


@pytest.mark.parametrize("load", LOADS, ids=str)
def test_every_motion_that_is_left_goes_on(load):
    """Also one whose load never pulls, and those of strongly damped bars: rounding must not look like damage."""
    for s, d, restitution, modes in (
        (20.0, 0.005, 0.8, 0),
        (20.0, 1e4, 0.5, 3),
        (0.05, 2.0, 1.0, 32),
        (3.0, 0.1, 0.0, 8),
    ):
        for stop in (Stop(impacts=0), Stop(impacts=40, periodic=False), Stop(time=20.3, impacts=300)):
            motion = run(System(s, d, restitution, load), Start.rigid(-0.2, 0.0, 0.7), modes=modes, stop=stop)
            more = motion.continued(Stop(impacts=motion.impacts + 5, periodic=False))
            assert more.impacts >= motion.impacts


def changed(motion: Trajectory, name: str, at: tuple[int, ...] | int | str, value: float, folder: Path) -> Path:
    whole = motion.to_xarray()
    values, about = whole[name].values.copy(), whole[name].attrs
    if isinstance(at, str):  # a column by its name
        at = (0, about["fields"].split().index(at))
    values[at] = value
    sealed(whole.assign({name: (whole[name].dims, values, about)})).to_netcdf(folder / "x.nc", engine="h5netcdf")
    return folder / "x.nc"


MADE_UP = [
    ("engine_z", (0, 0), 1e99), ("engine_z", (1, 2), 0.1), ("engine_now", "gap", -0.5), ("engine_now", "gap", 1.0),
    ("engine_now", "gap_rate", -4.1), ("engine_now", "rigid_rate", -4.1), ("engine_now", "hold", 50.0),
    ("engine_now", "sup", 0.0), ("engine_now", "sup2", 1e9), ("engine_now", "free", 1.0),
    ("engine_now", "since", 1e9),
    ("engine_now", "kinetic_energy", 1e9), ("engine_sums", "all", -1.0), ("engine_sums", "struck", 1e3),
    ("engine_sums", "main", 0.5), ("engine_sums", "speeds", 1e6), ("engine_sums", "taken", 1e6),
    ("engine_now", "struck_period", 7.0), ("engine_past", (3, 0), 1.0), ("engine_past", (0, 1), 9.0),
    ("engine_past", (1, 2), 2.0), ("engine_now", "anchor_phase", 1.0), ("engine_now", "anchor_rigid_rate", 4.1),
    ("engine_cycle", (-1, -1), 0.1),
    ("state", 0, 0.5), ("state", 1, 4.1), ("state", 5, 3.0), ("state", -1, 3.0), ("impact_velocity", 2, 4.1),
    ("rebound_velocity", 2, -4.1), ("kinetic_energy", 3, 9.0), ("energy_lost", 3, 9.0),
]  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize(("name", "at", "value"), MADE_UP)
def test_what_is_told_twice_agrees(motions, name, at, value, tmp_path):
    """A number within all bounds, with the right check sum, that the events or the system contradict."""
    motion = run(SMOOTH, Start.rigid(-0.3, 0.1, 0.2), modes=4, stop=Stop(impacts=20, periodic=False))
    assert motion.continued(Stop(impacts=25, periodic=False)).impacts == 25
    assert motion.events.kind[:4].tolist() == ["impact"] * 4
    if name == "state":
        whole = motion.to_xarray()["state"]
        at = (0, at) if whole.ndim == 2 else at
    path = changed(motion, name, at, value, tmp_path)
    with pytest.raises(PercussError, match="damaged"):
        Trajectory.load(path).continued(Stop(impacts=60, periodic=False))
