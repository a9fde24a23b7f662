"""Limits and symmetries of the simulator: phase, stiffness, damping, steps against harmonics; and, over the whole
parameter space, that it ends in time with a sound record."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from percuss import Load, System
from percuss.errors import ResonanceError
from percuss.model import (
    Chamber,
    External,
    HeldBody,
    KelvinVoigt,
    Kept,
    Machine,
    ModalBody,
    Mounted,
    Port,
    Reversed,
    SteppedBar,
    Supply,
    UniformBar,
    Valve,
)
from percuss.simulate import OUTCOMES, Start, Stop, run
from strategies import decades

TURN = 2.0 * np.pi


def first(system, start, modes, impacts=4):
    events = run(system, start, modes=modes, stop=Stop(impacts=impacts, periodic=False)).events.of("impact")
    assert len(events) == impacts
    return events


@pytest.mark.parametrize("phi", [0.1, 2.0, 5.9])
@pytest.mark.parametrize("load", [Load.fourier([0.7, 1.0, 0.3j]), Load.steps([0.4, 2.5, 4.1], [1.5, 0.4, -1.0])])
def test_shifting_load_and_start(load, phi):
    for modes in (0, 4):
        one = first(System(s=3.0, d=0.1, restitution=0.6, load=load), Start.rigid(time=3.0), modes)
        other = first(System(s=3.0, d=0.1, restitution=0.6, load=load.shifted(phi)), Start.rigid(time=3.0 - phi), modes)
        assert other.time + phi == pytest.approx(one.time, abs=1e-11)
        assert other.impact_velocity == pytest.approx(one.impact_velocity, abs=1e-10)


def test_scaling_the_load_and_the_start():
    system = System(s=3.0, d=0.1, restitution=0.6, load=Load.harmonic(0.7, 1.0))
    larger = System(s=3.0, d=0.1, restitution=0.6, load=Load.harmonic(700.0, 1000.0))
    one, other = first(system, Start.rigid(-0.5), 4), first(larger, Start.rigid(-500.0), 4)
    assert other.time == pytest.approx(one.time, abs=1e-12)
    assert other.impact_velocity == pytest.approx(1000.0 * one.impact_velocity, rel=1e-11)


@pytest.mark.parametrize("load", [Load.harmonic(0.7, 1.0), Load.square(1.0, 1.3)])
def test_a_stiff_bar_is_rigid(load):
    rigid = first(System(s=1.0, d=0.05, restitution=0.6, load=load), Start.rigid(time=0.3), 0)
    errors = []
    for s in (1e2, 1e3, 1e4):
        elastic = first(System(s=s, d=0.05, restitution=0.6, load=load), Start.rigid(time=0.3), 8)
        errors.append(np.abs(elastic.time - rigid.time).max())
    # deflection of the order p/s²
    assert errors[0] < 1e-2 and errors[1] < 1e-2 * errors[0] * 5.0 and errors[2] < 1e-2 * errors[1] * 5.0


@pytest.mark.parametrize("load", [Load.harmonic(0.7, 1.0), Load.square(1.0, 1.3)])
@pytest.mark.parametrize("modes", [0, 5])
def test_damping_to_zero(load, modes):
    def times(d):
        return first(System(s=3.0, d=d, restitution=0.6, load=load), Start.rigid(time=0.3), modes, 2).time

    undamped = times(0.0)
    slope = (times(1e-6) - undamped) / 1e-6
    for d in (1e-15, 1e-12, 1e-9, 1e-7):
        assert np.abs(times(d) - undamped - slope * d).max() < 1e-11 + 2e-3 * d


def test_across_critical_damping():
    # mode 1 is critically damped at d = 2πs
    critical = 2.0 * np.pi * 0.7
    times = [
        first(System(s=0.7, d=d, restitution=0.6, load=Load.harmonic(0.7, 1.0)), Start.rigid(-0.1), 3).time
        for d in critical * (1.0 + np.array([-1e-3, -1e-6, -1e-9, 0.0, 1e-9, 1e-6, 1e-3]))
    ]
    slope = (times[6] - times[0]) / (2e-3)
    for t, shift in zip(times, (-1e-3, -1e-6, -1e-9, 0.0, 1e-9, 1e-6, 1e-3), strict=True):
        assert t - times[3] == pytest.approx(slope * shift, abs=2e-5 * abs(shift) + 1e-11 + 10.0 * shift**2)


def test_steps_against_their_harmonics():
    steps = Load.square(1.0, 1.3)
    errors = []
    for harmonics in (50, 200, 800):
        series = Load.fourier(Load.square(1.0, 1.3, harmonics).coefficients)
        one, other = (
            first(System(s=3.0, d=0.05, restitution=0.6, load=load), Start.rigid(time=0.3), 4)
            for load in (steps, series)
        )
        errors.append(np.abs(one.time - other.time).max())
    assert errors[2] < 1e-4 and errors[2] < errors[1] < errors[0] and errors[2] < errors[0] / 20.0


def test_equal_steps_are_no_steps():
    start = Start.rigid(-0.4, 0.1, 0.3)
    constant = first(System(s=3.0, d=0.05, restitution=0.6, load=Load.fourier([0.8])), start, 4, 20)
    steps = first(System(s=3.0, d=0.05, restitution=0.6, load=Load.steps([1.0, 2.0, 2.5], [0.8] * 3)), start, 4, 20)
    assert steps.time == pytest.approx(constant.time, abs=1e-11)


def test_unexcited_modes_change_nothing_of_the_rigid_bar():
    # a harmonic load of zero but for its mean, and R = 1: the mean of the bar moves as without modes until it strikes
    system = System(s=2.0, d=0.3, restitution=1.0, load=Load.harmonic(0.5, 1.0))
    rigid, elastic = (run(system, Start.rigid(-3.0), modes=n, stop=Stop(impacts=1)) for n in (0, 6))
    t = np.linspace(0.0, min(rigid.end_time, elastic.end_time), 30)
    assert elastic.modal(t, "left").displacement[0] == pytest.approx(rigid.modal(t, "left").displacement[0], abs=1e-13)


# -- the whole parameter space ---------------------------------------------------------------------------------------


@st.composite
def loads(draw):
    size = draw(st.sampled_from([1.0, 1.0, 1e-6, 1e6]))
    kind = draw(st.sampled_from(["harmonic", "harmonic", "steps", "fourier", "constant"]))
    mean = draw(st.sampled_from([1.0, 1.0, -1.0])) * draw(st.one_of(st.just(0.0), decades(-4, 0.5), decades(-1, 0.3)))
    if kind == "harmonic":
        return Load.harmonic(size * mean, size, draw(st.integers(1, 9)))
    if kind == "constant":
        return Load.fourier([size * mean])
    if kind == "steps":
        apart = st.lists(st.floats(0.0, 6.28), min_size=2, max_size=8, unique_by=lambda place: round(place, 9))
        breaks = sorted(draw(apart))
        values = draw(
            st.lists(st.one_of(st.just(0.0), st.floats(-2.0, 2.0)), min_size=len(breaks), max_size=len(breaks))
        )
        return Load.steps(breaks, [size * v if abs(v) > 1e-200 else 0.0 for v in values])
    rng = np.random.default_rng(draw(st.integers(0, 2**32)))
    harmonics = draw(st.sampled_from([2, 5, 40]))
    raw = rng.normal(size=(2, harmonics)) / np.arange(1, harmonics + 1) ** draw(st.sampled_from([0.5, 1.0, 2.0]))
    return Load.fourier(size * np.concatenate([[mean], raw[0] + 1j * raw[1]]))


@st.composite
def motions(draw):
    s = draw(st.one_of(decades(math.log10(0.3), 2.0), decades(math.log10(0.3), 6.0)))
    d = draw(st.one_of(st.just(0.0), decades(-13, 0), decades(0, 3)))
    restitution = draw(st.one_of(st.sampled_from([0.0, 1.0, 0.999, 1e-9]), st.floats(0.0, 1.0)))
    system = System(s=s, d=d, restitution=restitution, load=draw(loads()))
    modes = draw(st.sampled_from([0, 1, 2, 3, 8, 20, 64]))
    scale = float(np.abs(system.load.coefficients).sum())
    u, v = np.zeros(modes + 1), np.zeros(modes + 1)
    n = np.arange(1, modes + 1)
    if modes and draw(st.booleans()):
        rng = np.random.default_rng(draw(st.integers(0, 2**32)))
        rate = draw(decades(-3, 1)) * scale * rng.normal(size=modes) / n ** draw(st.sampled_from([1.0, 2.0, 3.0]))
        turn = rng.uniform(0.0, TURN, modes)
        u[1:], v[1:] = rate * np.cos(turn) / (n * np.pi * s), rate * np.sin(turn)
    u[0] = -np.where(n % 2, -2.0, 2.0) @ u[1:] - scale * draw(st.one_of(st.just(0.0), decades(-12, 2)))
    v[0] = scale * draw(st.one_of(st.just(0.0), st.floats(-3.0, 3.0), decades(-9, -3)))
    time = draw(st.one_of(st.just(0.0), st.floats(0.0, TURN), st.floats(-1e3, 1e6)))
    if system.load.is_piecewise and draw(st.booleans()):
        time = draw(st.sampled_from(system.load.breaks))
    impacts = draw(st.sampled_from([0, 1, 50, 1000]))
    limit = draw(st.one_of(st.none(), decades(-9, 3)))
    return (
        system,
        Start.modal(u, v, time),
        modes,
        Stop(impacts=impacts, time=limit, periodic=draw(st.booleans())),
        scale,
    )


@settings(max_examples=100)
@given(motions())
def test_every_motion_ends_with_a_sound_record(motion):
    system, start, modes, stop, scale = motion
    try:
        motion = run(system, start, modes=modes, stop=stop)
    except ResonanceError:
        return
    events, kinds = motion.events, motion.events.kind.tolist()
    assert motion.outcome in OUTCOMES and motion.outcome not in ("memory", "interrupted")
    assert motion.impacts <= stop.impacts
    for name in ("phase", "impact_velocity", "rebound_velocity", "energy_lost", "kinetic_energy"):
        assert np.all(np.isfinite(getattr(events, name))), name
    assert np.all(np.isfinite(motion.states))
    assert np.all((events.phase >= 0.0) & (events.phase < TURN))
    gone = np.diff(events.period) * TURN + np.diff(events.phase)
    assert np.all(gone >= -1e-15)
    assert np.all(events.time >= motion.begin_time - 1e-12 * (1.0 + abs(motion.begin_time)))
    assert np.all(events.time <= motion.end_time + 1e-12 * (1.0 + abs(motion.end_time)))
    hits = events.of("impact")
    if system.s >= 0.3:
        assert np.all(hits.impact_velocity >= 0.0)
    assert hits.rebound_velocity == pytest.approx(-system.restitution * hits.impact_velocity, rel=1e-14, abs=0.0)
    assert np.all(hits.energy_lost >= 0.0)
    assert hits.energy_lost == pytest.approx((1.0 - system.restitution**2) * hits.kinetic_energy, rel=1e-12)
    for before, kind in zip(["start", *kinds], [*kinds, "end"], strict=True):
        assert kind != "release" or before in ("rest", "start")
        assert before != "rest" or kind in ("release", "end")
        assert before != "chatter" or kind in ("rest", "end")
        assert before != "release" or kind != "rest" or system.s < 0.3
    _never_beyond_the_wall(motion, scale)
    assert str(motion) and motion.summary.impacts == motion.impacts


def _never_beyond_the_wall(motion, scale):
    """At random times, but for the ripple of a finite number of modes after a release."""
    if motion.system.load.is_piecewise and motion.end_time - motion.begin_time > 300.0:
        return  # step by step, each by itself
    s, events = motion.system.s, motion.events
    t = np.sort(np.random.default_rng(0).uniform(motion.begin_time, motion.end_time, 60))
    last = np.searchsorted(events.time, t, side="right") - 1
    since = t - np.where(last < 0, motion.begin_time, events.time[np.maximum(last, 0)] if len(events) else 0.0)
    released = np.array([i < 0 or events.code[i] == 4 for i in last])
    rippling = released & (since < (1.0 + 60.0 / max(motion.modes, 1)) / s) & (motion.modes > 0)
    at = motion.modal(t)
    size = scale + np.abs(at.displacement).sum(axis=0).max() + np.abs(at.velocity).sum(axis=0).max()
    assert motion.gap(t)[~rippling].max(initial=0.0) <= 1e-9 * size


# -- no size of its own ------------------------------------------------------------------------------------------------


def under_a_clock(body, load, restitution, modes, law=Kept):
    """The motion of a hammer of which all forces and lengths are multiplied by a number."""

    def followed(size, periodic):
        own = replace(body, gap=body.gap * size) if isinstance(body, HeldBody) else body
        system = System(own, load.scaled(size), law(restitution))
        start = Start.rigid(-0.5 * size, 0.25 * size, 1.0)
        return run(system, start, modes=modes, stop=Stop(impacts=150, time=300.0, periodic=periodic))

    return followed


def switched(valve, restitution, modes, damping=0.05):
    """The same of a machine that switches its own valve."""

    def followed(size, periodic):
        machine = Machine(UniformBar(5.0, External(damping)), valve.scaled(size, size), Kept(restitution))
        start = Start.rigid(-0.5 * size, 0.25 * size)
        return run(machine, start, modes=modes, stop=Stop(impacts=60, time=300.0, periodic=periodic))

    return followed


WAVES, PULSES = Load.fourier([0.3, 1.0, 0.2j]), Load.steps([0.4, 2.5, 4.1], [1.2, 0.1, -1.0])
STEPPED = SteppedBar(4.0, (1.0, 0.5, 0.8), (0.4, 0.3, 0.3), KelvinVoigt(1e-3))
MODAL = ModalBody((0.6, 2.3), (0.05, 0.1), (1.0, 0.8), (1.0, -0.5), 0.3)
ONE = ModalBody((1.3,), (0.2,), (0.7,), (1.0,), -0.2)
PORTS = (Port("power", 1.0, "back", 0.1), Port("return", on="impact"))
LATE = Port("return", on="impact", delay=9.0)
STATES = {"return": -0.4, "power": 1.8}
HAMMERS = {
    "rigid": under_a_clock(UniformBar(5.0, External(0.1)), WAVES, 0.5, 0),
    "rigid under steps": under_a_clock(UniformBar(5.0, External(0.1)), PULSES, 0.5, 0),
    "bar": under_a_clock(UniformBar(5.0, External(0.1)), WAVES, 0.4, 6),
    "bar under steps": under_a_clock(UniformBar(5.0, External(0.1)), PULSES, 0.6, 6),
    "bar whose waves turn over": under_a_clock(UniformBar(2.0), WAVES, 0.6, 4, Reversed),
    "dead bar": under_a_clock(UniformBar(5.0, External(0.1)), PULSES, 0.0, 4),
    "overdamped bar": under_a_clock(UniformBar(1.0, External(30.0)), WAVES, 0.8, 4),
    "stepped": under_a_clock(STEPPED, WAVES, 0.5, 6),
    "stepped under steps": under_a_clock(STEPPED, PULSES, 0.5, 6),
    "one mode": under_a_clock(ONE, WAVES, 0.4, 1),
    "one mode under steps": under_a_clock(ONE, PULSES, 0.4, 1),
    "one dead mode under steps": under_a_clock(ONE, PULSES, 0.0, 1),
    "structure": under_a_clock(MODAL, WAVES, 0.7, 2),
    "structure under steps": under_a_clock(MODAL, PULSES, 0.7, 2),
    "dead structure under steps": under_a_clock(replace(MODAL, gap=-0.3), PULSES, 0.0, 2),
    "structure under nothing": under_a_clock(replace(MODAL, gap=0.0), Load.steps([0.0, 1.0], [0.0, 0.0]), 0.7, 2),
    "mounted": under_a_clock(Mounted(0.8, 0.05, 4.0, gap=0.2), WAVES, 0.5, 6),
    "mounted under steps": under_a_clock(Mounted(0.8, 0.05, 4.0, gap=-0.1), PULSES, 0.5, 6),
    "rigid valve": switched(Valve(STATES, PORTS), 0.2, 0),
    "valve": switched(Valve(STATES, PORTS), 0.2, 4),
    "valve on gas": switched(Valve(STATES, PORTS, chamber=Chamber(0.1, 0.1)), 0.3, 4),
    "valve that stalls on gas": switched(Valve(STATES, (LATE,), "power", Chamber(0.2, 0.9)), 0.3, 4),
    "valve that rests": switched(Valve(STATES, (PORTS[0], LATE)), 0.2, 4),
    "pump": switched(Valve(STATES, PORTS, supply=Supply(1.0, 5.0)), 0.3, 0),
    "pump with gas": switched(Valve(STATES, PORTS, chamber=Chamber(0.1, 0.1), supply=Supply(1.0, 5.0)), 0.3, 0),
    "pump from no pressure": switched(Valve(STATES, PORTS, supply=Supply(0.8, 3.0, 0.0)), 0.4, 0),
    "elastic bar on a pump": switched(Valve(STATES, PORTS, supply=Supply(1.0, 5.0)), 0.3, 4),
    "elastic bar on a pump, with gas": switched(
        Valve(STATES, PORTS, chamber=Chamber(0.1, 0.1), supply=Supply(1.0, 5.0)), 0.3, 3
    ),
}


@pytest.mark.parametrize("periodic", [False, True])
@pytest.mark.parametrize("name", HAMMERS)
def test_forces_and_lengths_times_a_power_of_two_give_the_same_bits(name, periodic):
    usual = HAMMERS[name](1.0, periodic)
    assert len(usual.events) > 1
    for exponent in (-200, -60, -20, -3, 1, 35):
        size = 2.0**exponent
        motion = HAMMERS[name](size, periodic)
        for column, power in (("code", 0), ("time", 0), ("kinetic_energy", 2), ("energy_lost", 2)):
            found = getattr(motion.events, column) / size**power
            assert found.tolist() == getattr(usual.events, column).tolist(), (exponent, column)
        for what in ("outcome", "label", "end_time"):
            assert getattr(motion, what) == getattr(usual, what), exponent
