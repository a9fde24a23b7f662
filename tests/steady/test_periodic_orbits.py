"""Orbits with p impacts in n load periods: the equations for their times, by figures, closed forms, differences."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from orbit_cases import ENTRIES, motions, numbers, of_kind, orbit_at, periods_of, system_of, times_of
from percuss import Load, System, steady_states
from percuss.errors import ParameterError
from percuss.steady import PeriodicOrbit, Reason, orbit_near, orbits, parameter_column, time_rates
from percuss.steady.periodic.impact_chain import ImpactChain
from percuss.steady.periodic.periodic_orbit import slope
from strategies import Drawn, fourier_systems, resonant, square_systems

TURN = 2.0 * math.pi
POINTS = [pytest.param(name, i, id=f"{name}-{i}") for name in of_kind("branch_points")
          for i in range(len(ENTRIES[name]["points"]))]  # fmt: skip


# -- figures ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", of_kind("orbit"))
def test_orbits_of_the_figures(name: str) -> None:
    entry = ENTRIES[name]
    times = times_of(entry)
    found = orbit_near(
        system_of(entry),
        times + 1e-3 * np.sin(np.arange(times.size)),
        periods_of(entry),
        modes=entry["system"]["modes"],
    )
    assert found is not None
    assert found.label == entry["label"]
    assert found.phases == pytest.approx(numbers(entry, "phase"), rel=0, abs=1e-12)
    assert found.speeds == pytest.approx(numbers(entry, "speed"), rel=0, abs=1e-12)
    assert found.flight_times == pytest.approx([float(flight) for flight in entry["flight_times"]], rel=0, abs=1e-12)
    assert found.admissible is entry["admissible"]
    assert found.proven
    assert found.residual < 1e-12
    t = np.linspace(0.0, found.period, 4001)
    y, starts = found.motion(t), found.flight_times.cumsum()
    assert y.max() <= 1e-12
    assert found.motion(np.append(0.0, starts[:-1])) == pytest.approx(0.0, abs=1e-12)
    if (greatest := entry["greatest_gap_between_impacts"]) is not None:
        tops = y[1:-1][(y[1:-1] > y[:-2]) & (y[1:-1] > y[2:]) & (y[1:-1] < -1e-3)]
        assert tops.max() == pytest.approx(greatest, abs=1e-4)


@pytest.mark.parametrize("name", [name for name in of_kind("orbit") if ENTRIES[name]["system"]["modes"]])
def test_what_compiled_functions_say_of_a_flight_is_what_its_sums_say(name: str) -> None:
    orbit = orbit_near(system_of(ENTRIES[name]), times_of(ENTRIES[name]), periods_of(ENTRIES[name]))
    assert orbit is not None
    tops = []  # flight, time and height of every maximum, the highest first
    for i, flight in enumerate(orbit.flights):
        t = np.linspace(0.0, flight.period, 20_001)
        y, rate = flight.end_motion(t, orbit.modes)
        for at in (0.3 * flight.period, 0.9 * flight.period):
            there = np.array([at - 1e-6, at, at + 1e-6])
            (_, height, _), rates = flight.end_motion(there, orbit.modes)
            assert orbit.end_at(i, at)[:2] == pytest.approx([height, rates[1]], rel=1e-9, abs=1e-11)
            assert orbit.end_at(i, at)[2] == pytest.approx((rates[2] - rates[0]) / 2e-6, rel=1e-4, abs=1e-4)
        here = np.flatnonzero((rate[:-1] > 0.0) & (rate[1:] <= 0.0))
        tops += [(i, float(t[k]), float(y[k])) for k in here]
    tops.sort(key=lambda top: -top[2])
    left = [orbit.sampled, *(orbit.sampled_but(flight, time) for flight, time, _ in tops[:1])]
    for (flight, _, height), found in zip(tops, left, strict=False):
        assert found.flight == flight and found.height == pytest.approx(height, abs=1e-5)
    assert tops or orbit.sampled.height == -math.inf
    about = orbit.sampled_but(impact=1 % orbit.impacts)
    assert about.height <= orbit.sampled.height


@pytest.mark.parametrize(("name", "i"), POINTS)
def test_special_points_of_the_figures(name: str, i: int) -> None:
    entry = ENTRIES[name]
    point = entry["points"][i]
    orbit = orbit_at(entry, point)
    assert orbit.residual < 1e-12
    assert orbit.speeds == pytest.approx(numbers(point, "speed"), rel=0, abs=1e-11)
    fold, flip = (np.linalg.svd(orbit.linearised(xi), compute_uv=False) for xi in (1.0, -1.0))
    singular = {"fold": fold, "flip": flip}
    for kind, values in singular.items():
        assert bool(values[-1] < 1e-10 * orbit.speeds.max()) is (point["type"] == kind)
    if point["type"] == "neimark_sacker":
        angle = complex(*point["multipliers"][0])
        values = np.linalg.svd(orbit.linearised(angle / abs(angle)), compute_uv=False)
        assert values[-1] < 1e-9 * orbit.speeds.max()
    if point["type"] == "grazing_touch":
        touch = float(point["touch_phase"]) - orbit.times[0]
        assert orbit.motion(touch) == pytest.approx(0.0, abs=1e-12)
    if point["type"] == "grazing_impact_dies":
        assert orbit.speeds.min() == pytest.approx(0.0, abs=1e-11)


@pytest.mark.parametrize("name", ["branch_21", "elastic_branch_21"])
def test_what_lies_beyond_the_ends_of_a_branch_is_no_orbit(name: str) -> None:
    """The root goes on: beyond a touch it passes the wall, beyond the death of an impact it strikes backwards."""
    entry = ENTRIES[name]
    ends = {point["type"]: point for point in entry["points"]}
    for kind, reason in (("grazing_touch", Reason.THROUGH_WALL), ("grazing_impact_dies", Reason.NO_BLOW)):
        point = ends[kind]
        for side, expected in ((1e-3, None), (-1e-3, reason)):
            system = system_of(entry, float(point["value"]) + side)
            found = orbit_near(system, numbers(point, "phase"), modes=entry["system"]["modes"])
            assert found is not None
            assert found.obstacle is expected
            assert found.proven
            if expected is Reason.THROUGH_WALL:
                assert found.violation is not None
                assert found.phase + found.violation.time == pytest.approx(float(point["touch_phase"]), abs=0.2)
                near = np.linspace(0.0, found.flight_times[0], 20001)[1:-1]
                later = found.flight_times[0] + np.linspace(0.0, found.flight_times[1], 20001)[1:-1]
                passed = np.concatenate([near, later])
                assert found.motion(passed).max() == pytest.approx(found.violation.depth, rel=1e-3)


# -- one impact is the closed form ------------------------------------------------------------------------------------


@settings(max_examples=30)
@given(st.one_of(fourier_systems(8), square_systems(16)), st.sampled_from([0, 1, 6]))
def test_one_impact_is_the_steady_motion(drawn: Drawn, modes: int) -> None:
    assume(not resonant(drawn.system))
    for motion in steady_states(drawn.system, drawn.periods, modes=modes).orbits:
        assume(not motion.fold)
        orbit = PeriodicOrbit(drawn.system, drawn.periods, (motion.phase,), modes)
        state, ours = motion.modal_state(modes), orbit.states[0]
        least = float(np.abs(state.divisor).min(initial=1.0))
        assume(least > 1e-4)  # nearer to resonance neither has the digits
        room = 1e-13 * max(drawn.periods * (1.0 + float(state.omega.max(initial=0.0))), 1.0) / least
        swing = motion.response.rigid_bounds()[0] + abs(motion.rigid_velocity)
        scale = swing + float(np.abs(state.velocity).sum())
        assert orbit.rigid_velocity == pytest.approx(motion.rigid_velocity, abs=room * swing)
        assert orbit.speeds[0] == pytest.approx(motion.impact_velocity, abs=max(1e-13, room) * scale)
        assert ours.velocity == pytest.approx(state.velocity, abs=max(1e-13, room) * scale)
        assert ours.rebound == pytest.approx(state.rebound, abs=max(1e-13, room) * scale)
        assert orbit.blow_energies[0] == pytest.approx(motion.blow_energy, abs=10.0 * room * scale**2)


def test_one_impact_to_thirteen_digits() -> None:
    system = System(s=5.0, d=0.0048, restitution=0.6, load=Load.fourier([0.8, 1.0, 0.2j]))
    motions = steady_states(system, modes=8).orbits
    assert motions
    for motion in motions:
        orbit = PeriodicOrbit(system, 1, (motion.phase,), 8)
        assert orbit.residual < 1e-13
        assert orbit.speeds[0] == pytest.approx(motion.impact_velocity, rel=1e-13)
        assert orbit.rigid_velocity == pytest.approx(motion.rigid_velocity, rel=1e-13)
        assert orbit.modal_state(8).z_velocity == pytest.approx(motion.modal_state(8).z_velocity, abs=1e-13)
        assert orbit.admissible is motion.admissible
        t = np.linspace(0.01, orbit.period - 0.01, 200)
        assert orbit.motion(t) == pytest.approx(motion.motion(t), abs=1e-13)


# -- invariants -------------------------------------------------------------------------------------------------------


def smooth(orbit: PeriodicOrbit) -> bool:
    """Whether differences tell derivatives: away from jumps of the load, where they are one-sided, and resonance."""
    breaks = np.array(orbit.system.load.breaks)
    off = np.abs((np.array(orbit.times)[:, None] - breaks + math.pi) % TURN - math.pi)
    divisor = orbit.modal_determinants() if orbit.modes else np.ones(1)
    return bool(off.min(initial=1.0) > 1e-3 and np.abs(divisor).min() > 0.02) and not orbit_chain(orbit).is_neutral


def orbit_chain(orbit: PeriodicOrbit) -> ImpactChain:
    return ImpactChain(orbit.system, orbit.impacts, orbit.periods, orbit.modes)


@settings(max_examples=40)
@given(motions())
def test_the_matrix_is_the_derivative_of_the_equations(orbit: PeriodicOrbit) -> None:
    assume(smooth(orbit) and orbit.modes < 20)
    chain, times, step = orbit_chain(orbit), np.array(orbit.times), 1e-4
    rows = step * np.eye(times.size)
    one, two = (
        np.array([chain.passage(times + k * row).gap - chain.passage(times - k * row).gap for row in rows])
        for k in (1.0, 2.0)
    )
    found = (8.0 * one - two).T / (12.0 * step)
    assert orbit.linearised() == pytest.approx(found, abs=1e-7 * max(1.0, float(np.abs(found).max())))


@settings(max_examples=20)
@given(motions(), st.integers(0, 3), st.integers(-2, 2))
def test_the_first_impact_and_the_first_period_are_free_to_choose(orbit, first: int, periods: int) -> None:
    assume(smooth(orbit))
    chain, times = orbit_chain(orbit), np.array(orbit.times)
    first %= times.size
    turned = np.concatenate([times[first:], times[:first] + chain.period]) + TURN * periods
    one, other = chain.passage(times), chain.passage(turned)
    scale = 1.0 + np.abs(one.gap).max()
    assert np.roll(one.gap, -first) == pytest.approx(other.gap, abs=1e-11 * scale)
    assert np.roll(one.speed, -first) == pytest.approx(other.speed, abs=1e-11 * scale)
    assert other.closure == pytest.approx(0.0, abs=1e-12 * scale)


@settings(max_examples=20)
@given(motions())
def test_energy_closes_over_the_cycle(orbit) -> None:
    """What the impacts take of energy and what the flights give are one: mode by mode the state comes back."""
    assume(smooth(orbit))
    alpha, beta = orbit.system.contact.strain_factor, orbit.system.contact.velocity_factor
    for i, state in enumerate(orbit.states):
        assert state.rebound == pytest.approx(alpha * state.displacement, abs=1e-15)
        assert state.z_velocity + state.forced_velocity == pytest.approx(beta * state.velocity, abs=1e-12)
        flight = orbit.flights[i]
        y, speed = flight.end_motion(np.array([0.0, flight.period]), orbit.modes)
        scale = 1.0 + np.abs(orbit.speeds).max()
        assert speed == pytest.approx([flight.rebound_velocity, flight.impact_velocity], abs=1e-10 * scale)
        off = orbit.residuals[: orbit.impacts]  # of a structure, each from its gap
        beyond = off[i] if orbit.system.body.is_free else np.roll(off, -1)[i] - off[i]
        assert y == pytest.approx([0.0, beyond], abs=1e-11 * scale)


def test_a_cycle_twice_as_long_holds_the_orbit_twice() -> None:
    """z=1/1 solves the equations of z=2/2, with the multipliers squared: a repeat, not an orbit of its own."""
    system = System(s=5.0, d=0.0048, restitution=0.5, load=Load.harmonic(0.62, 1.0))
    for motion in steady_states(system, modes=4).orbits:
        twice = PeriodicOrbit(system, 2, (motion.phase, motion.phase + TURN), 4)
        assert twice.residual < 1e-13
        assert twice.speeds == pytest.approx(motion.impact_velocity, rel=1e-12)


def test_full_rebound_without_drag_keeps_the_rigid_velocity_as_an_unknown() -> None:
    """R = 1, d = 0, p even: the times do not tell it; with nearly full rebound they do, and tell the same."""
    load = Load.fourier([0.2, 1.0, 0.4j, 0.3])
    lossless = System(s=5.0, d=0.0, restitution=1.0, load=load)
    assert ImpactChain(lossless, 2, 2, 0).is_neutral
    found = orbits(lossless, 2, 2, modes=0, tries=200).orbits
    nearly = orbits(lossless.with_restitution(1.0 - 2e-3), 2, 2, modes=0, tries=200).orbits
    assert len(found) == len(nearly) == 3
    for one, other in zip(found, nearly, strict=True):
        assert one.rebound is not None
        assert other.rebound is None
        assert one.residual < 1e-12
        assert one.times == pytest.approx(other.times, abs=0.01)
        assert one.speeds == pytest.approx(other.speeds, abs=0.02)
        assert 2.0 * one.rigid_velocities.sum() == pytest.approx(0.2 * 2.0 * TURN, rel=1e-12)  # momentum in a cycle


def test_an_undriven_swing_between_all_impacts_is_named() -> None:
    """ω_1 = 2 swings a whole number of times in flights of π: its amplitude is free, and so is that of 2ω_1, …"""
    system = System(s=2.0 / math.pi, d=0.0, restitution=0.5, load=Load.harmonic(0.5, 1.0))
    orbit = PeriodicOrbit(system, 1, (0.5, 0.5 + math.pi), 3)
    assert orbit.resonant_modes == (1, 2, 3)
    assert PeriodicOrbit(system, 1, (0.5, 0.6 + math.pi), 3).resonant_modes == ()
    assert np.isfinite(orbit.speeds).all()


@pytest.mark.parametrize("modes", [0, 4])
@pytest.mark.parametrize("parameter", ["mean", "restitution", "damping", "s"])
def test_times_move_with_a_parameter_as_the_column_says(parameter: str, modes: int) -> None:
    def family(value: float) -> System:
        mean, d, r, s = {"mean": (value, 0.1, 0.5, 2.0), "damping": (0.5, value, 0.5, 2.0)}.get(
            parameter, (0.5, 0.1, value if parameter == "restitution" else 0.5, value if parameter == "s" else 2.0)
        )
        return System(s=s, d=d, restitution=r, load=Load.fourier([mean, 1.0, 0.2j]))

    here = {"mean": 0.5, "restitution": 0.5, "damping": 0.1, "s": 2.0}[parameter]
    orbit = orbits(family(here), 2, modes=modes, tries=60).orbits[0]
    step = 1e-4
    ends = [orbit_near(family(here + k * step), orbit.times, modes=modes) for k in (1.0, -1.0)]
    moved = (np.array(ends[0].times) - ends[1].times) / (2.0 * step)  # type: ignore[union-attr]
    assert time_rates(orbit, family, here) == pytest.approx(moved, rel=1e-5, abs=1e-6)
    assert parameter_column(orbit, family, here)[-1] == pytest.approx(0.0, abs=1e-8)
    assert orbit.off(family(here)) == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("end", [1.0, -1.0])
def test_at_the_end_of_a_range_the_derivative_is_taken_from_inside(end: float) -> None:
    def function(x: float) -> np.ndarray:
        if end * x > 0.0:
            raise ParameterError("x", x, "no more")
        return np.array([x + 3.0 * x**2])

    assert slope(function, 1e-3) == pytest.approx([1.0], rel=1e-12)


# -- what is refused --------------------------------------------------------------------------------------------------


def test_times_that_are_none_are_refused() -> None:
    system = System(s=5.0, d=0.0, restitution=0.5, load=Load.harmonic(0.62, 1.0))
    for times in ([], [1.0, 0.5], [0.0, TURN], [0.0, 0.0], [math.nan], np.linspace(0.0, 1.0, 65)):
        with pytest.raises(ParameterError, match="times"):
            orbit_near(system, times)
    with pytest.raises(ParameterError, match="at most 0"):
        orbit_near(system, [0.4, 2.3], modes=0).modal_state(1)  # type: ignore[union-attr]


def test_an_orbit_is_a_value() -> None:
    system = System(s=5.0, d=0.0, restitution=0.5, load=Load.harmonic(0.62, 1.0))
    orbit = orbit_near(system, [0.4, 2.3], modes=0)
    again = orbit_near(system, np.array([2.3, 0.4 + TURN]) + 3.0 * TURN, modes=0)
    assert orbit is not None
    assert again is not None
    assert again.times == pytest.approx(orbit.times, abs=1e-12)
    with pytest.raises(dataclasses.FrozenInstanceError):
        orbit.modes = 1  # type: ignore[misc]
    assert str(orbit) == "PeriodicOrbit z=2/1: phases 0.390789, 2.321002 rad, admissible, 0 modes"
