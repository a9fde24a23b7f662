"""Rest and release where rounding matters: when the load begins to pull, how long a released bar is out of reach, and
what is said of a motion that was released twice in the same state."""

import math

import numpy as np
import pytest

from percuss import Load, System
from percuss.case.answers.simulation_answer import label_in_words
from percuss.errors import PercussError
from percuss.simulate import Start, Starts, Stop, Trajectory, run, simulate_many

TURN = 2.0 * np.pi


def hammer(factor, restitution=0.8, s=20.0, d=0.005):
    return System(s=s, d=d, restitution=restitution, load=Load.harmonic(factor, 1.0))


# -- laid on the wall when the load begins to pull ---------------------------------------------------------------------


@pytest.mark.parametrize("ulps", [0, 1, 5, 12, 40, -1, -12])
def test_laid_down_as_the_load_begins_to_pull(ulps):
    # p = cos t − cos φ falls through 0 at φ, and the bar is put on the wall some ulps beside it
    rng = np.random.default_rng(3)
    means = [-0.872, *rng.uniform(-0.99, 0.99, 40)]
    for mean in means:
        phase = math.acos(-mean)
        begin = phase + ulps * np.spacing(phase)
        motion = run(System(1.0, 0.0, 0.5, Load.harmonic(mean, 1.0)), Start.rigid(0.0, 0.0, begin), modes=0,
                     stop=Stop(time=0.5))  # fmt: skip
        assert motion.events.kind.tolist() == ["release"], mean
        assert abs(motion.events.time[0] - begin) < 1e-13


def test_laid_down_where_the_load_only_touches_zero():
    # p = cos t − 1 pulls at all times but one, p = 1 + cos t pushes at all times but one
    pulled = run(System(1.0, 0.0, 0.5, Load.harmonic(-1.0, 1.0)), Start.rigid(0.0), modes=0, stop=Stop(time=3.0))
    assert pulled.events.kind.tolist() == ["release"] and pulled.events.time[0] == 0.0
    pushed = run(System(1.0, 0.0, 0.5, Load.harmonic(1.0, 1.0)), Start.rigid(0.0, time=np.pi), modes=0)
    assert (pushed.outcome, len(pushed.events)) == ("rest", 0)
    # p = cos t − cos φ rises through 0 at 2π − φ: no release there, but at the next φ
    phase = math.acos(-0.3)
    for ulps in (-12, -1, 0, 1, 12):
        begin = TURN - phase + ulps * np.spacing(TURN - phase)
        motion = run(System(1.0, 0.0, 0.5, Load.harmonic(0.3, 1.0)), Start.rigid(0.0, time=begin), modes=0,
                     stop=Stop(time=6.0))  # fmt: skip
        assert motion.events.of("release").time == pytest.approx([TURN + phase], abs=1e-12)
    nothing = run(System(1.0, 0.0, 0.5, Load.fourier([0.0])), Start.rigid(0.0), modes=0)
    assert (nothing.outcome, len(nothing.events)) == ("rest", 0)


# -- no contact while the load pulls -----------------------------------------------------------------------------------


def pulls_until(load, begin):
    """When a load that pulls from `begin` on pushes again, on a fine grid."""
    t = begin + np.linspace(1e-6, TURN, 20_001)
    pushes = load.value(t) > 1e-9
    return t[np.argmax(pushes)] if pushes.any() else np.inf


@pytest.mark.parametrize("load", [Load.harmonic(0.4, 1.0), Load.harmonic(-0.1, 1.0), Load.fourier([0.2, 1.0, 0.8j]),
                                  Load.steps([0.0, 2.0, 3.0, 4.5], [1.0, -0.2, 0.0, -1.0])])  # fmt: skip
@pytest.mark.parametrize("modes", [1, 2, 4])
def test_a_released_bar_strikes_nothing_while_the_load_pulls(load, modes):
    # what comes through the bar to its end is pulls alone, so that the end only moves away (d'Alembert)
    seen = 0
    for s, d, restitution in ((2.71, 33.8, 0.0), (2.71, 33.8, 0.5), (0.7, 12.0, 0.5), (1.0, 300.0, 0.3), (9.0, 0.1, 0)):
        system = System(s, d, restitution, load)
        motion = run(system, Start.rigid(0.0, 0.0, 0.3), modes=modes, stop=Stop(time=30.0, periodic=False))
        released, struck = motion.events.of("release").time, motion.events.of("impact").time
        for at in released:
            seen += 1
            free = min(pulls_until(load, at), motion.end_time)
            assert not np.any((struck > at) & (struck < free - 1e-3)), (s, d, restitution)
            assert np.count_nonzero((released > at) & (released < free - 1e-3)) == 0
    assert seen > 4


# -- finitely many impacts ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize("modes", [0, 3])
@pytest.mark.parametrize("load", [Load.harmonic, lambda mean, _: Load.square(1.0, 1.0 + mean)])
def test_without_restitution_there_is_no_chatter(load, modes):
    names = set()
    for mean in np.linspace(0.02, 0.8, 25):
        system = System(s=6.0, d=0.02, restitution=0.0, load=load(mean, 1.0))
        motion = run(system, Start.rigid(-0.5, time=0.3), modes=modes, stop=Stop(impacts=400))
        assert "chatter" not in motion.events.kind, mean
        names.add(motion.label.split("/")[0])
        assert np.all(motion.main_blows)
    assert "rest" in names and "chatter" not in names
    many = simulate_many(system, Starts.random(system, 40, seed=1), modes=modes, stop=Stop(impacts=200))
    assert not any(label.startswith("chatter") for label in many.label)
    moving = run(System(1.0, 0.0, 0.0, Load.fourier([1.0])), Start.rigid(0.0, -1e-7), modes=0)
    assert moving.events.kind.tolist() == ["impact", "rest"]


# -- released twice in the same state ----------------------------------------------------------------------------------


def test_ends_at_the_second_equal_release():
    start = Start.rigid(0.0, -2.4, 2.85)
    motion = run(hammer(0.7837), start, modes=0)
    assert (motion.label, motion.outcome) == ("chatter/5", "periodic") and motion.impacts < 2000
    released = motion.events.of("release")
    assert len(released) == 2 and released.phase[0] == released.phase[1] == pytest.approx(math.acos(-0.7837))
    assert np.diff(released.period) == [5]
    # the impacts after the first release come again after the second
    on = motion.continued(Stop(impacts=motion.impacts + motion.cycle.impacts, periodic=False))
    assert on.label == "chatter/5"
    phases = on.events.of("impact").phase[motion.cycle.first :]
    again = phases[motion.cycle.impacts :]
    assert again == pytest.approx(phases[: again.size], abs=1e-9)
    many = simulate_many(hammer(0.7837), start, modes=0)
    found = (many.label[0], many.impacts[0], many.first[0], many.cycle_impacts[0])
    assert found == ("chatter/5", motion.impacts, motion.cycle.first, motion.cycle.impacts)


def test_of_several_releases_in_a_period():
    load = Load.fourier([0.5, 0.3, 1.0])  # it begins to pull twice in a period
    for restitution in (0.0, 0.1, 0.35):
        motion = run(System(5.0, 0.05, restitution, load), Start.rigid(), modes=2)
        assert motion.outcome == "periodic" and motion.label.split("/")[0] in ("chatter", "rest")
        released = motion.events.of("release")
        same = released.phase == released.phase[-1]
        assert motion.cycle.periods in np.diff(released.period[same])
        assert len(released) <= 6


# p = 0.34688 + cos t, R = 0.6: between two rests the bar bounces for a hundred periods, and errors grow on the way
LONG = 0.34688


@pytest.mark.parametrize("shift", [0.0, 1e-15, 2e-15, 3e-15])
def test_a_period_that_hangs_on_rounding_is_not_stated(shift):
    motion = run(System(20.0, 1e-9, 0.6 + shift, Load.harmonic(LONG, 1.0)), Start.rigid(), modes=0)
    assert (motion.label, motion.cycle, motion.period_unresolved) == ("chatter/?", None, True)
    first, second = motion.events.of("release").phase[-2:]
    assert (motion.outcome, first) == ("unresolved", second)
    assert "rounding" in label_in_words(motion)
    many = simulate_many(motion.system, Start.rigid(), modes=0)
    assert many.label.tolist() == ["chatter/?"] and many.impacts[0] == motion.impacts
    assert many.outcome.tolist() == ["unresolved"]
    on = run(motion.system, Start.rigid(), modes=0, stop=Stop(periodic=False))
    assert (on.outcome, on.impacts, on.period_unresolved) == ("impacts", 2000, True)


def test_a_period_that_is_stated_does_not_hang_on_rounding():
    rng = np.random.default_rng(7)
    stated = 0
    for _ in range(25):
        restitution, mean = rng.uniform(0.2, 0.8), rng.uniform(0.15, 0.8)
        near = [
            run(System(5.0, 0.003, r, Load.harmonic(mean, 1.0)), Start.rigid(), modes=0, stop=Stop(impacts=1500))
            for r in restitution * (1.0 + np.array([0.0, 1e-15, 1e-14, 1e-13]))
        ]
        if near[0].cycle is not None and near[0].cycle.kind:
            stated += 1
            assert len({motion.label for motion in near}) == 1, (restitution, mean)
            assert not near[0].period_unresolved
    assert stated > 8


@pytest.mark.parametrize(("modes", "stated"), [(0, True), (8, False), (32, False)])
def test_the_verdict_is_that_of_the_neighbours(modes, stated):
    # R moved by some ulps, and the release followed to the next rest: the same cycle, or another one each time
    near = 0.8 * (1.0 - np.array([0.0, 1e-15, 1e-14, 1e-13]))
    found, start = [], Start.rigid(0.0, 0.0, math.acos(-0.7837))  # where the load begins to pull
    for restitution in near:
        motion = run(hammer(0.7837, restitution), start, modes=modes, stop=Stop(impacts=1500, time=800 * TURN))
        released = motion.events.of("release").period
        found.append(int(released[1] - released[0]) if released.size > 1 else None)
        if stated:
            assert motion.label == "chatter/5"
        else:
            assert motion.label == ("chatter/?" if motion.period_unresolved else "aperiodic")
            assert motion.period_unresolved == (motion.outcome == "unresolved")
    assert (len(set(found)) == 1) == stated, found


def test_going_on_keeps_the_verdict(tmp_path):
    for system, impacts in ((hammer(0.7837), 2400), (System(20.0, 1e-9, 0.6, Load.harmonic(LONG, 1.0)), 900)):
        stop = Stop(impacts=impacts, periodic=False)
        whole = run(system, modes=0, stop=stop)
        for part in (impacts - 100, impacts - 30):
            first = run(system, modes=0, stop=Stop(impacts=part, periodic=False))
            first.save(tmp_path / "part.nc")
            again = Trajectory.load(tmp_path / "part.nc").continued(stop)
            assert (again.label, again.cycle, again.period_unresolved) == (
                whole.label, whole.cycle, whole.period_unresolved,
            )  # fmt: skip
            assert all(again.snapshot[name].tobytes() == whole.snapshot[name].tobytes() for name in ("now", "sums"))


def test_a_file_of_an_older_version_is_refused(tmp_path):
    dataset = run(hammer(0.95), modes=0, stop=Stop(impacts=3)).to_xarray()
    dataset.attrs |= {"format": "percuss trajectory 1", "percuss_version": "0.1"}
    dataset.to_netcdf(tmp_path / "old.nc", engine="h5netcdf")
    with pytest.raises(PercussError, match=r"written by percuss 0\.1.*from its start"):
        Trajectory.load(tmp_path / "old.nc")


@pytest.mark.parametrize("restitution", [0.0, 0.5])
def test_a_start_at_a_step_within_rounding_is_released_once(restitution):
    """A bar at rest on the wall, its clock one digit before the step that pulls: not laid down between."""
    load = Load.steps([0.0, 1.1, 2.0], [0.5, -0.7, 0.3])
    start = Start.rigid(0.0, 0.0, float(np.nextafter(1.1, 0.0)))
    motion = run(System(1.0, 0.0, restitution, load), start, modes=0, stop=Stop(impacts=3, periodic=False))
    assert motion.events.kind[:2].tolist() == ["release", "impact"]
