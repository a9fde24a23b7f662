"""Exact waves of a tool that is fed: closed forms, limits, and balances that must always close."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from percuss.blow import Feed, Joint, Rock, Rod, blows_one_by_one, strike, strike_again
from percuss.errors import ParameterError
from percuss.model import Bar, Section

STEEL = {"youngs_modulus": 2e11, "density": 8e3}  # c = 5000 m/s, Z = 4e7 times the area
BAR, V, Z, T = Bar(0.5, area=1e-3, **STEEL), 10.0, 4e4, 2e-4
ENERGY = 200.0


def rod(lengths=(6.0,), k1=2.5e8, gamma=0.25, bit_mass=0.0, **more):
    sections = [Section(length, area=1e-3, **STEEL) for length in lengths]
    return Rod(sections, "rock", bit_mass=bit_mass, rock=Rock(k1, gamma), **more)


def test_a_preload_is_invisible_until_something_would_have_to_pull():
    free = strike(BAR, rod(), V, until=2.2e-3)
    beta = 2.5e8 * T / Z
    for force in (0.0, 1e3, 8e3, 4e4):
        blow = strike(BAR, rod(feed=Feed(force)), V, until=2.2e-3)
        assert blow.greatest_penetration - force / 2.5e8 == pytest.approx(free.greatest_penetration, rel=1e-12)
        phi, done = force / (0.5 * Z * V), -math.expm1(-beta)
        share = 2.0 * 0.75 / beta * (done**2 + phi * done)
        assert blow.rock_dissipated / ENERGY == pytest.approx(share, rel=1e-12)


def test_attenuation_and_joints_have_closed_forms():
    lost = strike(BAR, rod(attenuation=0.03, feed=Feed(8e3)), V, until=2.2e-3)
    kept = strike(BAR, rod(feed=Feed(8e3)), V, until=2.2e-3)
    fall = math.exp(-0.03 * 6.0)
    added = [blow.greatest_penetration - 8e3 / 2.5e8 for blow in (lost, kept)]
    assert added[0] / added[1] == pytest.approx(fall, rel=1e-12)
    ends = [Section(4.0, area=1e-3, **STEEL), Section(None, area=1e-3, **STEEL)]
    for joint, q in (
        (Joint(1, mass=1.8), 2.0 * Z * T / 1.8),
        (Joint(1, "elastic", stiffness=1e9), 2.0 * 1e9 * T / Z),
    ):
        blow = strike(BAR, Rod(ends, joints=[joint]), V, until=1.4e-3)
        assert blow.energy_out_of_the_end / ENERGY == pytest.approx(1.0 + math.expm1(-q) / q, rel=1e-8)
        assert blow.energy_error < 1e-13


def test_nothing_that_holds_is_the_blow_of_before():
    plain = strike(BAR, rod((1.0, 1.0), bit_mass=2.0), V, until=2.5e-3)
    for more in (
        {"feed": Feed(0.0)},
        {"attenuation": 0.0},
        {"joints": [Joint(1, mass=0.0)]},
        {"joints": [Joint(1, "contact", slack=0.0)]},
    ):
        same = strike(BAR, rod((1.0, 1.0), bit_mass=2.0, **more), V, until=2.5e-3)
        assert same.rock_work == plain.rock_work and same.impulse == plain.impulse
    for more in ({"feed": Feed(1e-9)}, {"attenuation": 1e-13}):
        near = strike(BAR, rod((1.0, 1.0), bit_mass=2.0, **more), V, until=2.5e-3)
        assert near.rock_work == pytest.approx(plain.rock_work, abs=1e-10 * ENERGY)


@st.composite
def held_tools(draw):
    number = draw(st.integers(1, 3))
    joints = []
    for step in range(1, number):
        kind = draw(st.sampled_from(["none", "mass", "elastic", "contact", "slack"]))
        joints += {
            "none": [],
            "mass": [Joint(step, mass=1.5)],
            "elastic": [Joint(step, "elastic", stiffness=10.0 ** draw(st.floats(8, 10)), damping=1e4)],
            "contact": [Joint(step, "contact")],
            "slack": [Joint(step, "contact", slack=10.0 ** draw(st.floats(-5, -3)))],
        }[kind]
    rigid = [0] + [s for s in range(1, number) if all(one.at != s or one.kind == "mass" for one in joints)]
    force = draw(st.one_of(st.just(0.0), st.floats(2, 5).map(lambda x: 10.0**x)))
    feed = Feed(
        force, draw(st.sampled_from(rigid)), draw(st.sampled_from([0.0, 2e7])), draw(st.sampled_from([0.0, 1e4, 4e4]))
    )
    return rod(
        [draw(st.floats(0.4, 2.0)) for _ in range(number)], 10.0 ** draw(st.floats(7.5, 9.3)),
        draw(st.sampled_from([0.05, 0.3, 1.0])), draw(st.sampled_from([0.0, 2.0])), joints=joints, feed=feed,
        attenuation=[draw(st.sampled_from([0.0, 0.01, 0.1])) for _ in range(number)],
    )  # fmt: skip


def closes(tool):
    blow = strike(BAR, tool, V, until=1.2e-3, most_pieces=30_000)
    for again in (False, True, False):  # the next blows, on the tool as they find it
        if blow.fineness.name != "EXACT" or blow.outcome.name == "TOO_MANY_PIECES":
            return
        assert blow.energy_error < 1e-10 and blow.tool_momentum_error < 1e-10
        left = blow.rod_energy - blow.joint_energy_change + blow.bit_kinetic_energy_after
        blow = strike_again(blow, new_rock=again, most_pieces=30_000)
        assert blow.tool_energy_before == pytest.approx(left, rel=1e-9, abs=1e-12)


@settings(max_examples=40, deadline=None)
@given(held_tools())
def test_energy_and_momentum_close_in_any_tool(tool):
    closes(tool)


@pytest.mark.slow
@settings(max_examples=400, deadline=None)
@given(held_tools())
def test_energy_and_momentum_close_in_many_tools(tool):
    closes(tool)


def test_the_force_on_a_machine_is_shared_by_its_tool_and_its_blows():
    tool = rod((2.0,), 3e8, bit_mass=2.0, attenuation=0.01, feed=Feed(8e3))
    found = blows_one_by_one(
        lambda one, crater: strike(BAR, one, V, until=2.5e-3, crater=crater), tool, rate=50.0, of_machine=True
    )
    assert found.feed_force + found.recoil_force == pytest.approx(8e3, rel=1e-10)
    assert found.mean_rock_force == pytest.approx(8e3, rel=1e-10)
    with pytest.raises(ParameterError, match="rate × impulse"):
        weak = replace(tool, feed=Feed(100.0))
        blows_one_by_one(lambda one, _: strike(BAR, one, V, until=2.5e-3), weak, rate=50.0, of_machine=True)


def test_gauges_and_peaks_of_a_tool_with_losses_agree():
    tool = rod((1.5, 1.0), 3e8, bit_mass=2.0, attenuation=(0.02, 0.0), feed=Feed(8e3, 1))
    blow = strike(BAR, tool, V, until=2e-3)
    for i, (start, length) in enumerate(((0.0, 1.5), (1.5, 1.0))):
        peak, places = blow.peaks[1 + i], np.linspace(0.001, 0.999, 23) * length
        high, low = np.array([blow.force_range_at(float(start + x)) for x in places]).T
        assert high.max() <= peak.compression * 1e-3 * (1.0 + 0.02 * length)
        assert -low.min() <= peak.tension * 1e-3 * (1.0 + 0.02 * length)
