"""A motion saved, loaded in a new process and continued has the same bits as one that was never interrupted."""

import subprocess
import sys
from dataclasses import fields

import numpy as np
import pytest

from percuss import Load, System
from percuss.simulate import Start, Stop, Trajectory, run

STEPS = Load.steps([0.4, 2.5, 4.1], [1.5, 0.4, -1.0])
CASES = {
    # system, modes, first stop, second stop
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
    for field in fields(a.events):
        one, other = getattr(a.events, field.name), getattr(b.events, field.name)
        assert one.dtype == other.dtype and one.tobytes() == other.tobytes(), field.name
    assert a.states.tobytes() == b.states.tobytes()
    for name, one in a.snapshot.items():
        other = b.snapshot[name]
        if name == "count":
            one, other = one.copy(), other.copy()
            one["work"] = other["work"] = 0  # an interrupted flight is begun anew
        assert one.tobytes() == other.tobytes(), name
    assert (a.label, a.outcome, a.cycle, a.begin_time, a.end_time) == (
        b.label, b.outcome, b.cycle, b.begin_time, b.end_time,
    )  # fmt: skip


def start(modes):
    rng = np.random.default_rng(modes)
    u, v = 0.05 * rng.normal(size=(2, modes + 1))
    u[0] = -0.6
    return Start.modal(u, v, 0.3)


@pytest.mark.parametrize("case", CASES)
def test_continued(case, tmp_path):
    system, modes, first, impacts = CASES[case]
    whole = run(system, start(modes), modes=modes, stop=Stop(impacts=impacts, periodic=False))
    part = run(system, start(modes), modes=modes, stop=Stop(**first, periodic=False))
    assert 0 < len(part.events) < len(whole.events) and whole.impacts == impacts
    same(part.continued(Stop(impacts=impacts, periodic=False)), whole)
    part.save(tmp_path / "part.nc")
    same(Trajectory.load(tmp_path / "part.nc"), part)
    same(Trajectory.load(tmp_path / "part.nc").continued(Stop(impacts=impacts, periodic=False)), whole)


def test_at_every_impact():
    system, modes, _, _ = CASES["chatter"]
    whole = run(system, start(modes), modes=modes, stop=Stop(impacts=60, periodic=False))
    for impacts in range(60):
        part = run(system, start(modes), modes=modes, stop=Stop(impacts=impacts, periodic=False))
        assert part.impacts == impacts
        same(part.continued(Stop(impacts=60, periodic=False)), whole)


def test_at_any_time():
    system, modes, _, _ = CASES["resting"]
    whole = run(system, start(modes), modes=modes, stop=Stop(impacts=12, periodic=False))
    for time in np.random.default_rng(1).uniform(0.01, whole.end_time - 0.4, 40):
        part = run(system, start(modes), modes=modes, stop=Stop(time=time, periodic=False))
        assert part.end_time == part.begin_time + time
        same(part.continued(Stop(impacts=12, periodic=False)), whole)


def test_cancelled():
    system, modes, _, _ = CASES["impacts"]
    stop = Stop(impacts=20_000, periodic=False)
    whole = run(system, start(modes), modes=modes, stop=stop)
    part = run(system, start(modes), modes=modes, stop=stop, progress=lambda now: now.impacts > 5000)
    assert part.outcome == "cancelled" and 5000 < part.impacts < 20_000
    same(part.continued(stop), whole)


def test_in_a_new_process(tmp_path):
    cases = {name: CASES[name] for name in ("impacts", "steps", "chatter")}
    for name, (system, modes, first, _) in cases.items():
        run(system, start(modes), modes=modes, stop=Stop(**first, periodic=False)).save(tmp_path / f"{name}-part.nc")
    asked = [f"{name}:{impacts}" for name, (*_, impacts) in cases.items()]
    subprocess.run([sys.executable, "-c", SCRIPT, *asked], check=True, timeout=300, cwd=tmp_path)
    for name, (system, modes, _, impacts) in cases.items():
        whole = run(system, start(modes), modes=modes, stop=Stop(impacts=impacts, periodic=False))
        went_on = Trajectory.load(tmp_path / f"{name}-whole.nc")
        same(went_on, whole)
        times = np.linspace(whole.begin_time, whole.end_time, 50)
        assert np.array_equal(went_on.gap(times), whole.gap(times))
