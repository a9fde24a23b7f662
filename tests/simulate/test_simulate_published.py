"""Published and closed-form answers of the simulator: a bouncing ball, period doubling of the rigid limit, chatter."""

import mpmath as mp
import numpy as np
import pytest

from percuss import Load, System
from percuss.simulate import Start, Stop, run

TURN = 2.0 * np.pi


# -- a ball: constant load, rigid bar --------------------------------------------------------------------------------


def ball(restitution, **stop):
    system = System(s=1.0, d=0.0, restitution=restitution, load=Load.fourier([9.81]))
    return run(system, Start.rigid(position=-1.0), modes=0, stop=Stop(**stop))


def test_ball_impacts():
    motion = ball(0.9, impacts=100, periodic=False)
    published = [0.45152364, 1.26426619, 1.99573449, 2.65405596]
    assert np.abs(motion.events.time[:4] - published).max() < 6e-9
    first = np.sqrt(2.0 / 9.81)
    exact = first * (1.0 + 2.0 * np.cumsum(np.concatenate([[0.0], 0.9 ** np.arange(1, 100)])))
    assert np.abs(motion.events.time - exact).max() < 1e-13
    assert np.abs(motion.events.impact_velocity / (9.81 * first * 0.9 ** np.arange(100)) - 1.0).max() < 1e-12


@pytest.mark.parametrize(("restitution", "accumulation", "error"), [(0.9, 8.5789491787, 5e-11), (0.7, 2.55863, 5e-6)])
def test_ball_comes_to_rest(restitution, accumulation, error):
    motion = ball(restitution)
    assert motion.outcome == motion.label == "rest"
    assert motion.events.kind[-2:].tolist() == ["chatter", "rest"]
    end = motion.events.of("chatter").time[0]
    assert abs(end - accumulation) < error
    assert end == pytest.approx(np.sqrt(2.0 / 9.81) * (1.0 + restitution) / (1.0 - restitution), rel=1e-13)
    assert motion.events.resolved[-2] == motion.impacts
    assert motion.events.energy_lost.sum() == pytest.approx(9.81, rel=1e-13)


@pytest.mark.parametrize("restitution", [0.0, 1e-9, 0.01, 0.3, 0.99, 0.999])
def test_accumulation_for_any_restitution(restitution):
    motion = ball(restitution, impacts=10**6)
    assert motion.outcome == "rest"
    exact = np.sqrt(2.0 / 9.81) * (1.0 + restitution) / (1.0 - restitution)
    assert motion.events.time[-1] == pytest.approx(exact, rel=1e-12)


# -- chatter under an oscillating load against many digits -----------------------------------------------------------


def accumulation(mean, amplitude, restitution, time, speed, digits=40):
    """When a rigid undamped bar that leaves the wall at `time` with `speed` has chattered to the end."""
    with mp.workdps(digits):
        p0, p1, r, t, w = (mp.mpf(x) for x in (mean, amplitude, restitution, time, speed))
        flight = 2 * w / (p0 + p1 * mp.cos(t))
        while flight > mp.mpf(10) ** -22:
            start, rebound = t, w

            def gap(h, start=start, rebound=rebound):
                moved = mp.cos(start) - mp.cos(start + h) - h * mp.sin(start)
                return (p0 * h / 2 - rebound) + p1 * moved / h

            push = p0 + p1 * mp.cos(t)
            flight = mp.findroot(gap, (1.9 * w / push, 2 * w / push), solver="secant", verify=False, maxsteps=40)
            t += flight
            w = r * (p0 * flight + p1 * (mp.sin(t) - mp.sin(start)) - w)
        return float(t + 2 * w / ((1 - r) * (p0 + p1 * mp.cos(t))))


@pytest.mark.parametrize(
    ("mean", "amplitude", "restitution", "time", "speed"),
    [(1.0, 0.5, 0.5, 0.3, 0.2), (0.6, 1.0, 0.3, 5.5, 0.3), (0.2, 1.0, 0.7, 5.2, 0.02), (2.0, 1.9, 0.8, 3.0, 0.01)],
)
def test_end_of_chatter(mean, amplitude, restitution, time, speed):
    system = System(s=1.0, d=0.0, restitution=restitution, load=Load.harmonic(mean, amplitude))
    motion = run(system, Start.rigid(0.0, -speed, time), modes=0, stop=Stop(time=10.0, periodic=False))
    chatter = motion.events.of("chatter")
    assert chatter.time[0] == pytest.approx(accumulation(mean, amplitude, restitution, time, speed), abs=1e-12)
    assert chatter.rebound_velocity[0] == 0.0


# -- period doubling of the rigid limit ------------------------------------------------------------------------------

DOUBLINGS = [(0.2, 2.544192, 2.732236), (0.5, 1.526824, 1.667131), (0.8, 1.070836, 1.221780)]


def rigid(restitution, ratio):
    return System(s=1.0, d=0.0, restitution=restitution, load=Load.harmonic(1.0, ratio))


@pytest.mark.parametrize(("restitution", "first", "second"), DOUBLINGS)
def test_labels_about_the_doublings(restitution, first, second):
    for ratio, label in (
        (first * 0.997, "z=1/1"),
        (first * 1.003, "z=2/2"),
        (second * 0.9985, "z=2/2"),
        (second * 1.0015, "z=4/4"),
    ):
        phase, speed = one_impact(restitution, ratio)
        start = Start.rigid(0.0, -1.01 * speed, phase)
        assert run(rigid(restitution, ratio), start, modes=0, stop=Stop(impacts=60_000)).label == label


def one_impact(restitution, ratio):
    """Phase and rebound speed of the one-impact motion that doubles, B77 (35)."""
    phase = np.pi - np.arcsin(np.pi / ratio * (1.0 - restitution) / (1.0 + restitution))
    return phase, restitution * TURN / (1.0 + restitution)


def fixed_point(system, impacts, x):
    """A cycle of so many impacts of the engine's own map, by Newton's method, with its derivative."""
    for _ in range(12):
        x1, slope = mapped(system, x, impacts), derivative(system, x, impacts)
        step = np.linalg.solve(slope - np.eye(2), x1 - x)
        x = x - step
        if np.abs(step).max() < 1e-11:
            break
    return x, derivative(system, x, impacts)


def mapped(system, x, impacts):
    motion = run(system, Start.rigid(0.0, -x[1], x[0]), modes=0, stop=Stop(impacts=impacts, periodic=False))
    return np.array([motion.events.phase[-1], -motion.events.rebound_velocity[-1]])


def derivative(system, x, impacts, step=1e-5):
    columns = [
        (mapped(system, x + e, impacts) - mapped(system, x - e, impacts)) / (2.0 * step) for e in step * np.eye(2)
    ]
    return np.array(columns).T


def threshold(restitution, impacts, low, high, x):
    """The load at which a cycle's multiplier passes −1, by secants."""

    def excess(ratio, x):
        x, slope = fixed_point(rigid(restitution, ratio), impacts, x)
        return 1.0 + np.trace(slope) + np.linalg.det(slope), x  # (1 − ξ₁)(1 − ξ₂) at −1

    (a, x), (b, _) = excess(low, x), excess(high, x)
    for _ in range(8):
        low, high, a = high, high - b * (high - low) / (b - a), b
        b, x = excess(high, x)
        if abs(high - low) < 1e-9:
            break
    return high


@pytest.mark.parametrize(("restitution", "first", "second"), DOUBLINGS)
def test_thresholds_of_the_doublings(restitution, first, second):
    phase, speed = one_impact(restitution, first)
    found = threshold(restitution, 1, first - 0.02, first - 0.01, np.array([phase, speed]))
    assert found == pytest.approx(first, abs=1e-6)
    # the cycle of two impacts, from where it has settled
    middle = 0.5 * (first + second)
    start = Start.rigid(0.0, -1.01 * speed, phase)
    motion = run(rigid(restitution, middle), start, modes=0, stop=Stop(impacts=5000))
    assert motion.label == "z=2/2"
    x = np.array([motion.events.phase[-1], -motion.events.rebound_velocity[-1]])
    for ratio in np.linspace(middle, second - 0.02, 6):
        x, _ = fixed_point(rigid(restitution, ratio), 2, x)
    assert threshold(restitution, 2, second - 0.02, second - 0.015, x) == pytest.approx(second, abs=2e-6)
