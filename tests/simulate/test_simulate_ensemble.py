"""Ensembles: each member by itself, the same bits for any number of threads, in any order, from any thread or fork."""

import multiprocessing
import sys
import threading
from dataclasses import fields

import numpy as np
import pytest

from percuss import Load, System
from percuss.errors import ParameterError, ResonanceError
from percuss.model import Kept, ModalBody
from percuss.simulate import Ensemble, Start, Starts, Stop, run, simulate_many

SYSTEM = System(s=5.0, d=0.0048, restitution=0.6, load=Load.harmonic(0.7, 1.0))
STEPS = System(s=3.0, d=0.1, restitution=0.5, load=Load.steps([0.4, 2.5, 4.1], [1.5, 0.4, -1.0]))
CHATTER = System(s=3.0, d=0.1, restitution=0.4, load=Load.harmonic(0.7, 1.0))
STOP = Stop(impacts=300)
TWO = ModalBody((0.6, 2.3), (0.05, 0.1), (1.0, 0.8), (1.0, -0.5), 0.3)
COSINE, RESTING = Load.harmonic(0.0, 1.0), ModalBody((3.3, 7.3), (0.3, 0.1), (1.0, 0.8), (1.0, -0.5), -0.01)
ALL = {
    "smooth": (SYSTEM, 4),
    "steps": (STEPS, 4),
    "chatter": (CHATTER, 4),
    "structure": (System(TWO, Load.harmonic(0.2, 1.0), Kept(0.7)), 2),
    "structure under steps": (System(TWO, Load.square(1.0, 0.8), Kept(0.6)), 2),
    "structure that rests": (System(RESTING, COSINE, Kept(0.4)), 2),
    "mode that rests": (
        System(ModalBody((3.3,), (0.3,), (1.0,), (1.0,), -0.01), Load.harmonic(0.0, 1.0), Kept(0.4)),
        1,
    ),
}


def columns(ensemble):
    return {
        field.name: value
        for field in fields(ensemble)
        if isinstance(value := getattr(ensemble, field.name), np.ndarray)
    }


def same(a, b, order=slice(None)):
    one, other = columns(a), columns(b)
    assert one.keys() == other.keys() and len(one) > 15
    for name in one:
        assert one[name][order].tobytes() == other[name].tobytes(), name
    assert a.label[order].tolist() == b.label.tolist()


@pytest.mark.parametrize("system", [SYSTEM, STEPS, CHATTER], ids=["smooth", "steps", "chatter"])
def test_threads_and_order(system):
    starts = Starts.random(system, 120, seed=4, distribution="ringing", modes=4)
    one = simulate_many(system, starts, modes=4, stop=STOP, threads=1, keep=7)
    for threads in (2, 5):
        same(one, simulate_many(system, starts, modes=4, stop=STOP, threads=threads, keep=7))
    order = np.random.default_rng(0).permutation(120)
    mixed = Starts(starts.displacement[order], starts.velocity[order], starts.gap[order], starts.time[order])
    same(one, simulate_many(system, mixed, modes=4, stop=STOP, threads=2, keep=7), order)
    assert len(set(one.label.tolist())) >= 1 and np.all(one.impacts > 0)


def test_many_systems():
    systems = [SYSTEM.with_restitution(r) for r in np.linspace(0.3, 0.9, 9)] + [STEPS, CHATTER, SYSTEM]
    one = simulate_many(systems, Start.rigid(time=0.3), modes=3, stop=STOP, threads=1)
    same(one, simulate_many(systems, Start.rigid(time=0.3), modes=3, stop=STOP, threads=5))
    order = np.arange(12)[::-1]
    back = simulate_many([systems[i] for i in order], [Start.rigid(time=0.3)] * 12, modes=3, stop=STOP, threads=2)
    same(one, back, order)
    assert len(set(one.label.tolist())) > 2


@pytest.mark.parametrize("name", ALL)
def test_equal_to_single_runs(name):
    system, modes = ALL[name]
    starts = Starts.random(system, 25, seed=5, modes=modes)
    many = simulate_many(system, starts, modes=modes, stop=STOP, keep=9)
    for i, start in enumerate(starts):
        motion = run(system, start, modes=modes, stop=STOP)
        assert (many.label[i], many.outcome[i], many.impacts[i]) == (motion.label, motion.outcome, motion.impacts)
        cycle, hits = motion.cycle, motion.events.of("impact")
        if cycle is not None:
            found = (many.first[i], many.cycle_impacts[i], many.cycle_periods[i], many.cycle_kind[i])
            assert found == (cycle.first, cycle.impacts, cycle.periods, cycle.kind)
            summary = motion.summary
            assert many.blow_rate[i] == pytest.approx(summary.blow_rate, rel=1e-9)
            assert many.main_blow_rate[i] == pytest.approx(summary.main_blow_rate, rel=1e-6)
            assert many.interval_mean[i] == pytest.approx(summary.interval_mean, rel=1e-9)
            assert many.interval_std[i] == pytest.approx(summary.interval_std, rel=1e-6, abs=1e-6)
            assert many.impact_velocity[i] == pytest.approx(summary.impact_velocity, rel=1e-6)
            assert many.blow_energy[i] == pytest.approx(summary.blow_energy, rel=1e-6)
            assert many.energy_lost_per_period[i] == pytest.approx(summary.energy_lost_per_period, rel=1e-6)
        else:
            assert many.first[i] == -1 and many.cycle_impacts[i] == 0
        last = min(9, len(hits))
        assert np.array_equal(many.last_phase[i, 9 - last :], hits.phase[-last:])
        assert np.array_equal(many.last_velocity[i, 9 - last :], hits.impact_velocity[-last:])
        assert np.array_equal(many.last_time[i, 9 - last :], hits.time[-last:])
        assert np.all(np.isnan(many.last_time[i, : 9 - last]))


def test_statistics_without_a_cycle():
    system = System(s=1.0, d=0.0, restitution=0.5, load=Load.harmonic(1.0, 1.75))  # chaotic
    stop = Stop(impacts=1000, periodic=False)
    start = Start.rigid(0.0, -2.1, 2.5)
    many = simulate_many(system, [start, start], modes=0, stop=stop, discard=400)
    assert many.label.tolist() == ["aperiodic"] * 2
    hits = run(system, start, modes=0, stop=stop).events
    gone = np.diff(hits.time[399:])
    assert many.interval_mean[0] == pytest.approx(gone.mean(), rel=1e-11)
    assert many.interval_std[0] == pytest.approx(gone.std(), rel=1e-9)
    assert many.blow_rate[0] == pytest.approx(2.0 * np.pi / gone.mean(), rel=1e-11)
    assert many.impact_velocity[0] == pytest.approx(hits.impact_velocity[400:].mean(), rel=1e-11)
    assert many.energy_lost_per_period[0] == pytest.approx(
        hits.energy_lost[400:].sum() / gone.sum() * 2.0 * np.pi, rel=1e-11
    )


def test_everything():
    starts = Starts.random(CHATTER, 6, seed=1, modes=2)
    whole = simulate_many(CHATTER, starts, modes=2, stop=STOP, keep="everything", threads=2)
    least = simulate_many(CHATTER, starts, modes=2, stop=STOP)
    assert len(whole.trajectories) == 6 and least.trajectories == () and least.last_time is None
    assert whole.label.tolist() == least.label.tolist() == [motion.label for motion in whole.trajectories]
    for start, motion in zip(starts, whole.trajectories, strict=True):
        alone = run(CHATTER, start, modes=2, stop=STOP)
        assert alone.states.tobytes() == motion.states.tobytes()
    assert sum(whole.shares.values()) == pytest.approx(1.0)


def test_keep_nothing_and_more_than_there_is():
    starts = Starts.random(SYSTEM, 3, seed=1)
    assert simulate_many(SYSTEM, starts, modes=1, stop=Stop(impacts=5), keep=0).last_phase is None
    kept = simulate_many(SYSTEM, starts, modes=1, stop=Stop(impacts=5, periodic=False), keep=600)
    assert kept.last_phase.shape == (3, 600)
    assert np.isnan(kept.last_phase[:, :595]).all() and np.isfinite(kept.last_phase[:, 595:]).all()
    assert np.all(np.diff(kept.last_time[:, 595:]) > 0.0)
    long = simulate_many(SYSTEM, starts, modes=1, stop=Stop(impacts=900, periodic=False), keep=600)
    assert np.isfinite(long.last_phase).all()


def test_by_time():
    starts = Starts.random(STEPS, 40, seed=9, modes=2)
    many = simulate_many(STEPS, starts, modes=2, stop=Stop(time=40.0, periodic=False))
    for i in range(0, 40, 8):
        motion = run(STEPS, starts[i], modes=2, stop=Stop(time=40.0, periodic=False))
        assert many.impacts[i] == motion.impacts and many.outcome[i] == motion.outcome


def test_progress_and_cancel():
    seen = []
    starts = Starts.random(SYSTEM, 500, seed=1)
    simulate_many(SYSTEM, starts, modes=1, stop=Stop(impacts=50), threads=2, progress=lambda now: seen.append(now))
    assert [now.done for now in seen] == sorted(now.done for now in seen) and seen[-1].done == 500
    assert seen[-1].fraction == 1.0 and len(seen) > 3
    stopped = simulate_many(SYSTEM, starts, modes=1, stop=Stop(impacts=50), threads=2, progress=lambda now: True)
    done = stopped.outcome != "cancelled"
    assert 0 < np.count_nonzero(done) < 500
    whole = simulate_many(SYSTEM, starts, modes=1, stop=Stop(impacts=50))
    assert np.array_equal(stopped.impacts[done], whole.impacts[done])


def test_an_exception_in_progress_comes_through():
    def fails(_):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        simulate_many(SYSTEM, Starts.random(SYSTEM, 200), modes=1, stop=Stop(impacts=50), progress=fails)
    assert len(simulate_many(SYSTEM, Starts.random(SYSTEM, 4), modes=1, stop=Stop(impacts=5))) == 4


def test_from_several_threads_at_once():
    starts = Starts.random(SYSTEM, 60, seed=2, modes=3)
    alone = simulate_many(SYSTEM, starts, modes=3, stop=STOP, threads=1)
    found: list[Ensemble] = []
    workers = [
        threading.Thread(target=lambda: found.append(simulate_many(SYSTEM, starts, modes=3, stop=STOP, threads=2)))
        for _ in range(4)
    ]
    for worker in workers:
        worker.start()
    for worker in workers:
        worker.join(timeout=120)
    assert len(found) == 4
    for each in found:
        same(alone, each)


def _in_a_child(pipe):
    starts = Starts.random(SYSTEM, 40, seed=2, modes=3)
    pipe.send(simulate_many(SYSTEM, starts, modes=3, stop=STOP, threads=2).end_time)
    pipe.close()


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="no fork")
@pytest.mark.filterwarnings("ignore::DeprecationWarning")
def test_after_a_fork():
    starts = Starts.random(SYSTEM, 40, seed=2, modes=3)
    ours = simulate_many(SYSTEM, starts, modes=3, stop=STOP, threads=2)
    context = multiprocessing.get_context("fork")
    receiver, sender = context.Pipe(False)
    child = context.Process(target=_in_a_child, args=(sender,), daemon=True)
    child.start()
    try:
        assert receiver.poll(120), "hangs after a fork"
        assert receiver.recv().tobytes() == ours.end_time.tobytes()
    finally:
        child.kill()


def test_nonsense_is_refused():
    for wrong in (
        lambda: simulate_many([], Start.rigid()),
        lambda: simulate_many(SYSTEM, []),
        lambda: simulate_many([SYSTEM, SYSTEM], Starts.random(SYSTEM, 3)),
        lambda: simulate_many(SYSTEM, Start.rigid(), keep="all"),
        lambda: simulate_many(SYSTEM, Start.rigid(), keep=-1),
        lambda: simulate_many(SYSTEM, Start.rigid(), threads=0),
        lambda: simulate_many(SYSTEM, Start.rigid(), modes=-1),
        lambda: simulate_many(SYSTEM, Start.modal([-1.0, 0.1]), modes=0),
        lambda: simulate_many("system", Start.rigid()),
    ):
        with pytest.raises((ParameterError, TypeError)):
            wrong()
    resonant = System(s=1.0 / np.pi, d=0.0, restitution=0.5, load=Load.harmonic(0.7, 1.0))
    with pytest.raises(ResonanceError):
        simulate_many([SYSTEM, resonant], Start.rigid(), modes=2)


def test_memory_is_for_what_is_kept():
    starts = Starts.random(SYSTEM, 2000, seed=1)
    stop = Stop(impacts=3, periodic=False)
    bytes_of = lambda many: sum(column.nbytes for column in columns(many).values())  # noqa: E731
    least = bytes_of(simulate_many(SYSTEM, starts, modes=1, stop=stop))
    kept = bytes_of(simulate_many(SYSTEM, starts, modes=1, stop=stop, keep=10))
    assert least < 2000 * 200
    assert kept - least == 2000 * 10 * 3 * 8


def test_as_dataset():
    many = simulate_many(SYSTEM, Starts.random(SYSTEM, 5, seed=1), modes=1, stop=Stop(impacts=30), keep=4)
    dataset = many.to_xarray()
    assert dataset["label"].values.tolist() == many.label.tolist()
    assert dataset["last_phase"].dims == ("member", "last")
    assert np.array_equal(dataset["blow_rate"].values, many.blow_rate, equal_nan=True)
