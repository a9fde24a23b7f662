"""What any blow must obey, whatever its numbers: balances, no tension, units, and chains that are the same chain."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from blow_strategies import MIDDLING, bodies, collisions, section, struck
from collisions import Collision
from percuss.blow import Rod, strike
from percuss.model import Section, SectionedBar
from strategies import decades

FIGURES = (
    "impulse", "striker_momentum_after", "rigid_energy_after", "vibration_energy_after", "work_through_face",
    "load_work", "gap_after",
)  # fmt: skip


def scale_of(case: Collision, name: str) -> float:
    speed = max(map(abs, case.velocity)) + max((abs(f) for _, f in case.load), default=0.0) * case.until / case.mass
    if name in ("impulse", "striker_momentum_after"):
        return float(case.mass * speed)
    return float(speed * case.until if name == "gap_after" else case.mass * speed**2)


def assert_same(one: Any, other: Any, case: Collision, tolerance: float = 1e-9, **factors: float) -> None:
    """All figures alike, those of `other` times a factor."""
    for name in FIGURES:
        theirs = getattr(other, name) * factors.get(name, 1.0)
        assert getattr(one, name) == pytest.approx(theirs, abs=tolerance * scale_of(case, name)), name


@settings(max_examples=30)
@given(case=collisions())
def test_momentum_and_energy_close_and_nothing_pulls(case: Collision) -> None:
    blow = struck(case)
    assert abs(blow.momentum_error) < 1e-12
    assert abs(blow.energy_error) < 1e-12
    ends = [*(start for start, _ in case.load[1:]), case.until]
    pushed = sum(f * max(0.0, min(end, case.until) - start) for (start, f), end in zip(case.load, ends, strict=False))
    momentum = case.mass * case.velocity_before + pushed
    assert blow.striker_momentum_after + blow.impulse == pytest.approx(momentum, abs=1e-12 * scale_of(case, "impulse"))
    times = np.linspace(0.0, case.until, 401)[:-1]
    largest = max((one.peak_force for one in blow.contacts), default=0.0)
    assert blow.face_force.at(times).min() >= -1e-12 * largest
    assert blow.vibration_energy_after >= -1e-12 * scale_of(case, "vibration_energy_after")
    if case.end == "rock":
        pressed = blow.bit_force.at(times)
        assert pressed.min() >= -1e-11 * max(1.0, np.abs(pressed).max())
        assert blow.rock_dissipated >= 0.0
        assert blow.rock_stored >= 0.0


@settings(max_examples=20)
@given(case=collisions(), mass=decades(-6.0, 6.0), length=decades(-6.0, 6.0), time=decades(-9.0, 3.0))
def test_units_change_nothing(case: Collision, mass: float, length: float, time: float) -> None:
    """Every number of the blow in other units of mass, length and time."""
    z, force = mass / time, mass * length / time**2
    other = replace(
        case,
        striker=tuple((a * z, b * time) for a, b in case.striker),
        rod=case.rod and tuple((a * z, None if b is None else b * time) for a, b in case.rod),  # type: ignore[misc]
        velocity=tuple(v * length / time for v in case.velocity),
        gap=case.gap * length,
        rock_gap=case.rock_gap * length,
        k1=case.k1 * mass / time**2,
        bit_mass=case.bit_mass * mass,
        joint_masses=tuple((step, m * mass) for step, m in case.joint_masses),
        load=tuple((t * time, f * force) for t, f in case.load),
        until=case.until * time,
    )
    energy = mass * (length / time) ** 2
    factors = dict.fromkeys(FIGURES, 1.0 / energy)
    factors |= dict.fromkeys(("impulse", "striker_momentum_after"), time / (mass * length))
    factors["gap_after"] = 1.0 / length
    assert_same(
        struck(case),
        struck(other),
        case,
        gap_after=1.0 / length,
        **{k: v for k, v in factors.items() if k != "gap_after"},
    )


@settings(max_examples=20)
@given(case=collisions(), share=st.floats(0.05, 0.95), number=st.integers(0, 9), rod=st.booleans())
def test_a_section_in_two_is_the_same_section(case: Collision, share: float, number: int, rod: bool) -> None:
    def halved(rows: Any, i: int) -> Any:
        z, tau = rows[i]
        two = ((z, share), (z, None)) if tau is None else ((z, share * tau), (z, (1.0 - share) * tau))
        return (*rows[:i], *two, *rows[i + 1 :])

    if rod and case.rod:
        i = number % len(case.rod)
        masses = tuple((step + (step > i), mass) for step, mass in case.joint_masses)
        other = replace(case, rod=halved(case.rod, i), joint_masses=masses)
    else:
        i = number % len(case.striker)
        speeds = (*case.velocity[: i + 1], *case.velocity[i:])
        at = case.load_at + (case.load_at > i)
        other = replace(case, striker=halved(case.striker, i), velocity=speeds, load_at=at)
    assert_same(struck(case), struck(other), case)


@settings(max_examples=25)
@given(case=collisions(gaps=False, loads=False), factor=decades(-3.0, 3.0))
def test_without_gaps_all_grows_with_the_speed(case: Collision, factor: float) -> None:
    faster = replace(case, velocity=tuple(factor * v for v in case.velocity))
    slow, fast = struck(case), struck(faster)
    squares = dict.fromkeys(FIGURES[2:6], factor**-2)
    lines = dict.fromkeys(("impulse", "striker_momentum_after", "gap_after"), 1.0 / factor)
    assert_same(slow, fast, case, **squares, **lines)
    assert len(slow.contacts) == len(fast.contacts)
    assert slow.contact_duration == pytest.approx(fast.contact_duration, abs=1e-9 * case.until)


@settings(max_examples=20)
@given(case=collisions(rock=True))
def test_elastic_rock_keeps_nothing(case: Collision) -> None:
    blow = struck(replace(case, gamma=1.0))
    assert blow.rock_dissipated == pytest.approx(0.0, abs=1e-12 * scale_of(case, "load_work"))
    assert blow.residual_penetration == pytest.approx(0.0, abs=1e-12 * case.until)
    assert blow.rock_work == pytest.approx(blow.rock_stored, abs=1e-11 * scale_of(case, "load_work"))


@settings(max_examples=20)
@given(case=collisions(rock=True, gaps=False, transits=3.0))
def test_no_rock_is_a_free_end_and_hard_rock_a_fixed_one(case: Collision) -> None:
    """First order in K and in 1/K; a fixed end may pull, so only until the first tension at the bit."""
    case = replace(case, bit_mass=0.0, gap=0.0)
    soft = replace(case, k1=1e-10)  # a light rod moves by K t²/m of its way more
    assert_same(struck(soft), struck(replace(case, end="free", k1=0.0, gamma=1.0)), case, tolerance=1e-6)
    hard = replace(case, k1=1e6, gamma=1.0)
    stiff = struck(hard)
    fixed = struck(replace(case, end="fixed", k1=0.0, gamma=1.0))
    gauge = sum(tau for _, tau in case.rod)  # type: ignore[union-attr]
    times = np.linspace(0.0, case.until, 801)
    waves = fixed.waves_at(gauge)
    pulled = times[waves.incident.at(times) < -1e-9]
    end = pulled[0] if pulled.size else case.until
    times = times[times < end]
    force, wanted = stiff.face_force.at(times), fixed.face_force.at(times)
    largest = max(1e-300, float(np.abs(wanted).max()))
    assert np.mean(np.abs(force - wanted)) < 1e-3 * largest


@settings(max_examples=20)
@given(case=collisions(rock=False))
def test_a_rod_far_heavier_than_the_striker_is_a_wall(case: Collision) -> None:
    wall = replace(case, rod=None, end="infinite", joint_masses=(), bit_mass=0.0)
    heavy = replace(wall, rod=((1e5 * sum(z for z, _ in case.striker), None),))
    ours, theirs = struck(heavy), struck(wall)
    for name in ("impulse", "striker_momentum_after"):
        assert getattr(ours, name) == pytest.approx(getattr(theirs, name), abs=1e-2 * scale_of(case, name))


@settings(max_examples=20)
@given(case=collisions(rock=False), impedance=MIDDLING)
def test_an_endless_rod_is_its_impedance(case: Collision, impedance: float) -> None:
    endless = replace(case, rod=((impedance, None),), end="infinite", joint_masses=(), bit_mass=0.0)
    other = replace(endless, rod=((impedance, 0.3), (impedance, 0.7), (impedance, None)))
    ours = struck(endless)
    assert_same(ours, struck(other), case)
    striker, _ = bodies(endless)
    alone = strike(
        striker, Rod.of_impedance(impedance, gap=case.gap), list(case.velocity), until=case.until, load=case.load,
        load_at=case.load_at,
    )  # fmt: skip
    assert_same(ours, alone, case)


@settings(max_examples=20)
@given(case=collisions(rock=False, gaps=False, loads=False))
def test_zero_masses_and_no_load_are_nothing(case: Collision) -> None:
    if case.rod is None or len(case.rod) < 2:
        return
    plain = replace(case, joint_masses=(), bit_mass=0.0)
    assert_same(struck(plain), struck(replace(plain, joint_masses=((1, 0.0),), load=((0.0, 0.0),))), case)


def test_a_short_section_becomes_a_lumped_mass() -> None:
    """A lumped mass against a section of the same mass and ever less transit time: first order in that time."""
    striker, mass = SectionedBar([section(1.0, 1.0)]), 0.4
    ends = ((0.8, 1.0), (1.2, None))
    lumped = strike(striker, Rod([section(*ends[0]), section(*ends[1])], joint_masses=((1, mass),)), 1.0, until=6.0)
    errors = []
    for time in (0.04, 0.01):
        rod = Rod([section(*ends[0]), section(mass / time, time), section(*ends[1])])
        errors.append(abs(strike(striker, rod, 1.0, until=6.0).vibration_energy_after - lumped.vibration_energy_after))
    assert errors[1] < 0.4 * errors[0] + 1e-12
    assert errors[1] < 1e-2


def test_the_sections_of_steel_are_those_of_their_impedances() -> None:
    """SI and bare numbers: E, ρ, A, L enter as impedance and transit time only."""
    steel = SectionedBar([Section(0.3, area=1e-3), Section(0.2, area=2e-3, youngs_modulus=1e11, density=9000.0)])
    rod = Rod([Section(0.4, area=1.5e-3), Section(None, area=1e-3)])
    pieces = [(one.impedance, one.transit_time) for one in steel.pieces]
    other = [(one.impedance, one.transit_time) for one in rod.pieces[:1]] + [(rod.pieces[1].impedance, None)]
    first = strike(steel, rod, 9.0, until=1e-3)
    bare = strike(
        SectionedBar([section(*one) for one in pieces]), Rod([section(*one) for one in other]), 9.0, until=1e-3
    )
    for name in FIGURES:
        assert getattr(first, name) == pytest.approx(getattr(bare, name), rel=1e-11, abs=1e-15)
