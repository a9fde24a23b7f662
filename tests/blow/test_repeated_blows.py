"""Blows that follow each other: against numbers of two other programs, a plain lattice, and what must always hold."""

import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from held_program import Held, repeated
from percuss.blow import Feed, Joint, Rock, Rod, Wall
from percuss.blow.periods import run_by_waves, strike_repeatedly
from percuss.blow.periods.repeated import regime_of
from percuss.errors import ParameterError
from percuss.model import Bar, Kept, Load, Section, SectionedBar, System

STEEL = {"youngs_modulus": 2e11, "density": 8e3}  # c = 5000 m/s, Z = 4e7 times the area
BAR = Bar(0.5, area=1e-3, **STEEL)
Z, MASS, V = 4e4, 4.0, 10.0
FEEDS = json.loads((Path(__file__).parent / "reference_feeds.json").read_text(encoding="utf-8"))

# -- numbers of two programs that share nothing

NAMED = {
    "tool_energy_after": "tool_energy_after", "rock_work": "rock_work", "impulse": "impulse",
    "rock_impulse": "rock_impulse", "returned_energy": "returned_energy", "advance": "advance",
    "greatest_penetration": "greatest_penetration", "penetration_after": "penetration_after",
    "steel_loss": "steel_loss", "joint_loss": "joint_loss", "feed_work": "feed_work",
    "recoil_damper_loss": "recoil_damper_loss", "recoil_spring_work": "recoil_spring_work",
    "joint_energy_change": "joint_energy", "energy_out_of_the_end": "energy_out",
    "vibration_energy_after": "vibration_energy", "face_advance": "face_advance",
    "mean_velocity_after": "mean_velocity_after", "greatest_rock_force": "greatest_rock_force",
}  # fmt: skip
CLOSE = {"matched hammer": 1e-7, "the same with": 1e-7, "feed on a shoulder": 3e-7, "18 kW": 1e-6, "mass at a": 2e-7}
"""At 1600 cells where all jumps lie on the lattice; else contacts begin between its points."""


def scale(case, name):
    length, area, modulus, density = case["striker"]["sections"][0]
    v = case["striker"]["velocity"]
    if "penetration" in name or "advance" in name:
        return 1e-3
    if "impulse" in name:
        return 2.0 * length * area * density * v
    if "velocity" in name:
        return v
    if name.endswith("force"):
        return area * math.sqrt(modulus * density) * v
    return 0.5 * length * area * density * v * v


def rod_of(case):
    tool, rock, feed = case["tool"], case.get("rock"), case.get("feed")
    joints = [
        Joint(one["step"], one["kind"], **{k: v for k, v in one.items() if k not in ("step", "kind") and v is not None})
        for one in tool.get("joints", [])
    ]
    sections = [Section(length, area=a, youngs_modulus=e, density=rho) for length, a, e, rho in tool["sections"]]
    return Rod(
        sections, tool["end"], bit_mass=tool["bit_mass"], joints=joints, attenuation=tool.get("attenuation", ()),
        rock=rock and Rock(rock["k1"], rock["gamma"]),
        feed=feed and Feed(feed["force"], feed.get("at", 0), feed.get("stiffness", 0.0), feed.get("damping", 0.0)),
    )  # fmt: skip


def train_of(case, cells):
    (length, area, modulus, density), blows = case["striker"]["sections"][0], case.get("blows", {})
    return strike_repeatedly(
        Bar(length, area=area, youngs_modulus=modulus, density=density), rod_of(case), case["striker"]["velocity"],
        blows.get("period", case.get("until")), blows.get("number", 1),
        blows_per_crater=0 if blows.get("crater") == "same" else 1, cells=cells, estimate=False,
    )  # fmt: skip


@pytest.mark.parametrize(
    "case", [case for case in FEEDS if case.get("blows", {}).get("between") != "static"], ids=lambda case: case["name"]
)
@pytest.mark.parametrize("cells", [1600, None], ids=["lattice", "exact"])
def test_blows_are_those_of_two_other_programs(case, cells):
    train = train_of(case, cells)
    close = next((value for name, value in CLOSE.items() if case["name"].startswith(name)), 4e-4)
    if "blows" in case:
        close = 3e-5
    if cells is None:
        assert train.lattice is None
        close = 2e-10
    for blow, wanted in zip(train.blows, case["expect"].get("per_blow", [case["expect"]]), strict=True):
        for theirs, ours in NAMED.items():
            if theirs in wanted:
                off = (getattr(blow, ours) - wanted[theirs]) / scale(case, theirs)
                assert abs(off) < close, (theirs, getattr(blow, ours), wanted[theirs])
        shown = [one for one in blow.contacts if one.impulse > 1e-3 * blow.contacts[0].impulse]
        for found, (start, end, impulse, *_) in zip(shown, wanted["contacts"], strict=False):
            assert found.start == pytest.approx(start, abs=1e-7)
            assert end is None or found.end == pytest.approx(end, abs=1e-7)
            assert found.impulse == pytest.approx(impulse, abs=1e-2)
        for found, (start, end, impulse, *_) in zip(blow.bit_contacts, wanted.get("bit_contacts", ()), strict=False):
            assert found.start == pytest.approx(start, abs=1e-7)
            assert (found.end is None) == (end is None)
            assert end is None or found.end == pytest.approx(end, abs=1e-6)
            assert found.impulse == pytest.approx(impulse, abs=1e-2)
        assert abs(blow.energy_error) < 2.0 * close
    expected = case["expect"]
    if expected.get("contraction"):
        assert train.regime.kind == "fixed point"
        assert train.regime.multiplier == pytest.approx(-expected["contraction"], abs=1e-3)
        assert train.mean_rock_force == pytest.approx(expected["mean_rock_force"], rel=1e-5)
    if "joint_opens" in expected:
        opened = [one for one in train.openings if one[0]]
        assert opened[0][1] == pytest.approx(expected["joint_opens"][0], abs=1e-6)


def test_errors_fall_as_the_square_of_the_cells_where_jumps_are_on_the_lattice():
    case = next(case for case in FEEDS if case["name"].startswith("feed on a shoulder"))
    wanted = case["expect"]["tool_energy_after"]
    off = [abs(train_of(case, cells).blows[0].tool_energy_after - wanted) for cells in (100, 200, 400)]
    assert off[0] > 3.5 * off[1] > 12.0 * off[2]


# -- a plain lattice of whole waves, over random tools

TAU = 1e-4
LENGTHS = st.lists(st.integers(6, 16), min_size=1, max_size=3)


@st.composite
def tools(draw):
    """A tool of up to three sections in tenths of the striker's transit time, with everything that may hold it."""
    lengths = draw(LENGTHS)
    areas = [draw(st.sampled_from([0.5, 1.0, 1.6])) * 1e-3 for _ in lengths]
    at = draw(st.integers(0, len(lengths) - 1))
    joints = []
    for step in range(1, len(lengths)):
        kind = draw(st.sampled_from(["none", "mass", "elastic", "contact"]))
        if kind == "mass":
            joints.append(Joint(step, mass=draw(st.floats(0.5, 3.0))))
        elif kind == "elastic" and step != at:
            joints.append(Joint(step, kind, stiffness=draw(st.floats(3e8, 3e9)), damping=draw(st.floats(0.0, 3e4))))
        elif kind == "contact" and step != at:
            joints.append(Joint(step, kind, slack=draw(st.sampled_from([None, 1e-4]))))
    attenuation = [draw(st.sampled_from([0.0, 0.03])) for _ in lengths]
    feed = Feed(
        draw(st.floats(2e3, 3e4)), at, draw(st.sampled_from([0.0, 2e7])), draw(st.sampled_from([0.0, 0.3, 1.0])) * Z
    )
    rock = Rock(draw(st.floats(1e8, 5e8)), draw(st.sampled_from([0.15, 0.4])))
    bit = draw(st.sampled_from([0.0, 2.0]))
    sections = [Section(0.05 * n, area=a, **STEEL) for n, a in zip(lengths, areas, strict=True)]
    return Rod(sections, "rock", bit_mass=bit, joints=joints, attenuation=attenuation, feed=feed, rock=rock)


def plain(rod):
    joints = {}
    for step, one in rod.joint_at.items():
        if one.kind == "contact":
            joints[step] = ("contact", math.inf if one.slack is None else one.slack, 0.0)
        else:
            joints[step] = (one.kind, one.mass or one.stiffness, one.damping)
    return Held(
        (Z, TAU), V, [(4e7 * p.area, (p.end - p.start) / 5000.0) for p in rod.pieces], rod.end, rod.bit_mass,
        rod.rock.stiffness, rod.rock.unloading_ratio,
        [a * (p.end - p.start) for a, p in zip(rod.attenuation, rod.pieces, strict=True)], joints,
        rod.feed.force, rod.feed.at, rod.feed.stiffness, rod.feed.damping,
    )  # fmt: skip


@settings(max_examples=15, deadline=None)
@given(rod=tools(), new=st.booleans())
def test_random_tools_are_those_of_a_plain_lattice(rod, new):
    """Two blows, the plain lattice extrapolated over its step; from a bit in flight errors grow."""
    coarse, fine = (repeated(plain(rod), 2e-3, 2, TAU / cells, new) for cells in (80, 160))
    train = strike_repeatedly(BAR, rod, V, 2e-3, 2, blows_per_crater=int(new), cells=320, estimate=False)
    number = 2 if train.blows[0].stands and coarse[0].stands and fine[0].stands else 1
    for blow, one, two in list(zip(train.blows, coarse, fine, strict=True))[:number]:
        for name, ours, size in (
            ("deepest", blow.greatest_penetration, 1e-3),
            ("impulse", blow.impulse, 2.0 * MASS * V),
            ("rock_impulse", blow.rock_impulse, 2.0 * MASS * V),
            ("feed_impulse", blow.feed_impulse, 2.0 * MASS * V),
            ("feed_work", blow.feed_work, 200.0),
            ("steel", blow.steel_loss, 200.0),
            ("joint", blow.joint_loss, 200.0),
        ):
            error = abs(getattr(two, name) - getattr(one, name))
            best = 2.0 * getattr(two, name) - getattr(one, name)
            assert abs(ours - best) < 4.0 * error + 2e-2 * size, name


@settings(max_examples=40, deadline=None)
@given(rod=tools(), number=st.integers(1, 4), new=st.booleans())
def test_energy_and_momentum_balance(rod, number, new):
    train = strike_repeatedly(BAR, rod, V, 2.5e-3, number, blows_per_crater=int(new), cells=400, estimate=False)
    for blow in train.blows:
        assert abs(blow.energy_error) < 1e-2
        assert blow.recoil_damper_loss >= 0.0
        assert blow.joint_loss >= 0.0
        assert blow.rock_dissipated >= 0.0
    if not any(rod.attenuation):
        given_ = sum(one.impulse + one.feed_impulse - one.rock_impulse for one in train.blows)
        assert abs(given_ - momentum(train)) < 2e-3 * MASS * V * number


def momentum(train):
    """What the tool has at the end, from its speed: whatever moves on is bounded by its energy."""
    mass = (
        sum(p.mass for p in train.target.pieces)
        + train.target.bit_mass
        + sum(one.mass for one in train.target.joint_at.values())
    )
    last = train.blows[-1]
    bound = math.sqrt(2.0 * mass * max(last.energy_left + last.joint_energy, 0.0)) + 1e-9
    found = sum(one.impulse + one.feed_impulse - one.rock_impulse for one in train.blows)
    return min(max(found, -bound), bound)


# -- limits


def drill(feed, attenuation=0.0, gamma=0.25, bit_mass=2.0):
    rock = Rock(3e8, gamma)
    more = {"bit_mass": bit_mass, "attenuation": attenuation, "feed": feed, "rock": rock}
    return Rod([Section(2.0, area=1e-3, **STEEL)], "rock", **more)


def test_a_feed_that_vanishes_is_none():
    bare, pressed = (
        strike_repeatedly(BAR, drill(feed), V, 2e-3, 2, cells=200, estimate=False) for feed in (None, Feed(1e-6))
    )
    for one, other in zip(bare.blows, pressed.blows, strict=True):
        assert one.rock_work == pytest.approx(other.rock_work, rel=1e-7)
        assert one.impulse == pytest.approx(other.impulse, rel=1e-7)


def test_a_preload_is_invisible_until_something_would_have_to_pull():
    """Penetration beyond the static one, and momentum, do not depend on the feed of a long rod."""
    found = []
    for force in (1e3, 8e3, 4e4):
        rod = Rod([Section(6.0, area=1e-3, **STEEL)], "rock", feed=Feed(force), rock=Rock(2.5e8, 0.25))
        blow = strike_repeatedly(BAR, rod, V, 1.6e-3, 1, cells=100, estimate=False).blows[0]
        found.append((blow.greatest_penetration - force / 2.5e8, blow.rock_impulse - force * 1.6e-3, blow.impulse))
    assert np.ptp(found, axis=0) == pytest.approx(np.zeros(3), abs=1e-11)


def test_a_dashpot_of_the_rods_impedance_leaves_nothing():
    """It takes all compression that comes back; what it cannot take is the tension beyond the feed."""
    left = []
    for damping in (0.0, Z):
        rod = drill(Feed(4e4, damping=damping), gamma=1.0, bit_mass=0.0)
        left.append(strike_repeatedly(BAR, rod, V, 6e-3, 1, cells=200, estimate=False).blows[0].energy_left)
    assert left[0] > 50.0
    assert left[1] < 0.02 * left[0]


def test_the_mean_force_on_rock_is_that_of_feed_and_blows():
    """F̄ = Q̄ + f J at a fixed point without drag."""
    train = strike_repeatedly(BAR, drill(Feed(1.2e4, damping=0.5 * Z)), V, 6e-3, 30, cells=100, estimate=False)
    assert train.regime.kind == "fixed point"
    mean = (train.mean("feed_impulse") + train.mean("impulse")) / 6e-3
    assert train.mean_rock_force == pytest.approx(mean, rel=1e-4)


def test_a_machine_strikes_its_fed_tool_as_a_train_does():
    """A clock drives the striker: its settled blow is that of a train at its speed, and so is what the rock keeps."""
    system = System.from_si(BAR, Load.harmonic(1500.0, 5000.0, frequency=40.0), Kept(0.03))
    sections = [Section(0.5, area=1e-3, **STEEL), Section(2.5, area=1e-3, **STEEL)]
    feed, rock = Feed(1.2e4, damping=Z), Rock(4e8, 0.3)
    rod = Rod(sections, "rock", bit_mass=1.0, attenuation=0.02, feed=feed, rock=rock)
    motion = run_by_waves(system, rod, quiet=True, cells=100, estimate=False)
    assert motion.label == "z=1/1"
    assert motion.energy.error < 1e-12
    assert motion.rhythm == (1.0, 0.0)
    assert motion.left_bound < 0.01
    assert motion.main.stands.all()
    speed = float(motion.settled.velocity[0]) * system.speed_scale
    train = strike_repeatedly(BAR, rod, speed, 1.0 / 40.0, 4, cells=200, estimate=False)
    blow = train.blows[-1]
    assert motion.settled.rock_work[0] * system.energy_scale == pytest.approx(blow.rock_dissipated, rel=5e-3)
    assert motion.settled.impulse[0] * MASS * system.speed_scale == pytest.approx(blow.impulse, rel=5e-3)
    assert motion.settled.fed[0] * system.length_scale == pytest.approx(blow.advance, rel=5e-3)


# -- what is read from many blows


@pytest.mark.parametrize(
    ("u", "kind", "multiplier"),
    [
        (1.0 + 0.1 * 0.5 ** np.arange(30), "fixed point", 0.5),
        (1.0 + 0.1 * (-0.3) ** np.arange(30), "fixed point", -0.3),
        (1.0 + 0.1 * (-1.0) ** np.arange(30), "2-cycle", None),
        (1.0 + 0.1 * np.sin(np.arange(60) ** 2), "no periodic régime", None),
        (np.ones(3), "too few blows", None),
    ],
)
def test_a_regime_is_read_from_the_penetrations(u, kind, multiplier):
    found = regime_of(u)
    assert found.kind == kind
    assert found.multiplier is None if multiplier is None else found.multiplier == pytest.approx(multiplier, abs=1e-6)


@pytest.mark.parametrize(
    ("wrong", "says"),
    [
        ({"target": Wall()}, "target"),
        ({"target": Rod.of_impedance(1e4)}, "sections"),
        ({"target": Rod([Section(1.0, area=1e-3)], "free")}, "end"),
        ({"period": 1e-4}, "at least"),
        ({"number": 0}, "number"),
        ({"cells": 3}, "cells"),
    ],
)
def test_what_cannot_be_struck_repeatedly_is_refused(wrong, says):
    asked = {"striker": BAR, "target": drill(None), "velocity": V, "period": 6e-3, "number": 2} | wrong
    with pytest.raises(ParameterError, match=says):
        strike_repeatedly(**asked)


def test_the_error_is_told_from_half_the_cells():
    train = strike_repeatedly(BAR, drill(Feed(8e3), 0.03), V, 2e-3, 2, cells=100)
    finer = strike_repeatedly(BAR, drill(Feed(8e3), 0.03), V, 2e-3, 2, cells=1600, estimate=False)
    off = max(
        abs(a.greatest_penetration / b.greatest_penetration - 1.0)
        for a, b in zip(train.blows, finer.blows, strict=True)
    )
    assert off < train.error < 1e-3


def test_a_train_ends_when_asked_to():
    train = strike_repeatedly(
        BAR, drill(Feed(8e3)), V, 2e-3, 50, cells=50, estimate=False, progress=lambda now: now.impacts == 3
    )
    assert len(train.blows) == 3


def test_a_striker_of_sections_with_a_speed_each():
    own = SectionedBar([Section(0.2, area=1e-3, **STEEL), Section(0.3, area=1e-3, **STEEL)])
    one = strike_repeatedly(own, drill(Feed(8e3)), (V, V), 2e-3, 1, cells=100, estimate=False)
    other = strike_repeatedly(
        BAR, drill(Feed(8e3)), V, 2e-3, 1, cells=one.lattice.cells[0] + one.lattice.cells[1], estimate=False
    )
    assert one.blows[0].rock_work == pytest.approx(other.blows[0].rock_work, rel=1e-4)
    assert replace(one.target).is_held
