"""Energy closes over a thousand impacts; without losses it stays; the motion converges in the number of modes."""

from itertools import pairwise

import numpy as np
import pytest

from percuss import Load, System
from percuss.simulate import Start, Stop, run

LOADS = {
    "pneumatic": Load.harmonic(0.7, 1.0),
    "steps": Load.square(1.0, 1.3),
    "harmonics": Load.fourier([0.6, 1.0, 0.4j, -0.2, 0.1 + 0.1j]),
}


def closes(motion, bound=1e-10):
    balance = motion.energy_balance()
    turned = abs(balance.input) + balance.damping + balance.impacts
    assert turned > 0.0
    assert abs(balance.imbalance) < bound * turned, balance
    return balance


@pytest.mark.slow
@pytest.mark.parametrize("modes", [0, 8])
@pytest.mark.parametrize("load", LOADS)
def test_balance_over_a_thousand_impacts(load, modes):
    system = System(s=1.5, d=0.0048, restitution=0.6, load=LOADS[load])
    motion = run(system, Start.rigid(time=0.3), modes=modes, stop=Stop(impacts=1000, periodic=False))
    assert motion.impacts == 1000
    balance = closes(motion)
    assert balance.impacts > 0.0 and balance.damping > 0.0


@pytest.mark.parametrize("modes", [0, 1, 8])
@pytest.mark.parametrize("d", [30.0, 100.0, 1e3, 1e4])
@pytest.mark.parametrize("load", ["pneumatic", "steps"])
def test_balance_with_strong_damping(load, d, modes):
    # what an impact leaves dies out within 1/d of it
    system = System(s=2.0, d=d, restitution=0.5, load=LOADS[load])
    motion = run(system, Start.rigid(-0.1 / d, 0.3, 0.3), modes=modes, stop=Stop(time=40.0, impacts=60, periodic=False))
    assert motion.impacts > 0
    closes(motion, 1e-10)
    middle = 0.5 * (motion.begin_time + motion.end_time)
    balance = motion.energy_balance(None, middle)
    assert abs(balance.imbalance) < 1e-10 * (abs(balance.input) + balance.damping + balance.impacts)


def test_parts_of_a_motion():
    # they begin and end in flight
    system = System(s=5.0, d=0.1, restitution=0.6, load=LOADS["steps"])
    motion = run(system, Start.rigid(time=0.3), modes=3, stop=Stop(impacts=50, periodic=False))
    whole, times = motion.energy_balance(), np.linspace(motion.begin_time, motion.end_time, 4)
    parts = [motion.energy_balance(a, b) for a, b in pairwise(times)]
    for name in ("input", "damping", "impacts", "stored"):
        assert sum(getattr(part, name) for part in parts) == pytest.approx(getattr(whole, name), rel=1e-11)
    assert all(abs(part.imbalance) < 1e-11 * whole.impacts for part in parts)


@pytest.mark.parametrize("modes", [0, 1, 8])
@pytest.mark.parametrize("restitution", [0.0, 0.3])
def test_balance_with_chatter_and_rest(restitution, modes):
    for load in (Load.harmonic(0.7, 1.0), Load.square(1.0, 1.5), Load.steps([0.5, 2.5, 4.0], [1.0, 0.4, -0.8])):
        system = System(s=8.0, d=0.3, restitution=restitution, load=load)
        motion = run(system, Start.rigid(time=0.3), modes=modes, stop=Stop(time=200.0, periodic=False))
        assert {"rest", "release"} <= set(motion.events.kind.tolist())
        closes(motion)


@pytest.mark.parametrize("modes", [1, 4, 16])
def test_balance_of_a_ringing_bar(modes):
    rng = np.random.default_rng(5)
    system = System(s=2.0, d=0.05, restitution=0.7, load=Load.fourier([0.8, 1.0]))
    u, v = rng.normal(size=(2, modes + 1)) * 0.1
    sign = np.where(np.arange(1, modes + 1) % 2, -2.0, 2.0)
    u[0] = -sign @ u[1:] - 0.05
    motion = run(system, Start.modal(u, v, 0.7), modes=modes, stop=Stop(impacts=1000, periodic=False))
    closes(motion)


@pytest.mark.parametrize("modes", [0, 2, 8])
def test_energy_without_losses(modes):
    # a constant load has a potential: −p u(0)
    rng = np.random.default_rng(6)
    push = 0.7
    system = System(s=3.0, d=0.0, restitution=1.0, load=Load.fourier([push]))
    u, v = rng.normal(size=(2, modes + 1)) * 0.05
    sign = np.where(np.arange(1, modes + 1) % 2, -2.0, 2.0)
    u[0] = -sign @ u[1:] - 0.5
    motion = run(system, Start.modal(u, v), modes=modes, stop=Stop(impacts=1000, periodic=False))
    assert motion.impacts == 1000 and np.all(motion.events.energy_lost == 0.0)
    t = np.sort(rng.uniform(0.0, motion.end_time, 400))
    total = motion.energy(t) - push * motion.position(0.0, t)[0]
    assert np.ptp(total) < 1e-11 * np.abs(total).max()
    assert np.ptp(motion.energy(t)) > 1e6 * np.ptp(total)  # it goes to and fro


def test_what_an_impact_takes():
    system = System(s=4.0, d=0.02, restitution=0.35, load=Load.harmonic(0.8, 1.0))
    motion = run(system, Start.random(system, 3, "ringing", modes=5), modes=5, stop=Stop(impacts=60, periodic=False))
    hits = motion.events.of("impact")
    assert len(hits) == 60
    before, after = motion.energy(hits.time, "left"), motion.energy(hits.time)
    assert np.abs(before - after - hits.energy_lost).max() < 1e-11 * before.max()
    weight = np.where(np.arange(6) == 0, 0.5, 1.0)
    velocity = motion.modal(hits.time, "left").velocity
    assert hits.kinetic_energy == pytest.approx(weight @ velocity**2, rel=1e-9, abs=1e-13)
    assert hits.energy_lost == pytest.approx((1.0 - 0.35**2) * hits.kinetic_energy, rel=1e-13)


def test_convergence_in_the_number_of_modes():
    # what the modes left out add to the gap is Σ cos(…)/(nπs)²: times err by 1/N². Their velocities jump, like a wave:
    # speeds err by 1/N
    system = System(s=5.0, d=0.0048, restitution=0.6, load=Load.harmonic(0.7, 1.0))
    counts = np.array([8, 16, 32, 64, 128])

    def impacts(modes):
        motion = run(system, Start.rigid(position=-1.0, time=0.3), modes=modes, stop=Stop(impacts=8, periodic=False))
        return motion.events.time, motion.events.impact_velocity

    reference = impacts(4096)
    errors = np.array([[np.abs(a - b).max() for a, b in zip(impacts(int(n)), reference, strict=True)] for n in counts])
    slopes = np.polyfit(np.log(counts), np.log(errors), 1)[0]
    assert -2.7 < slopes[0] < -1.7
    assert -1.5 < slopes[1] < -0.6
