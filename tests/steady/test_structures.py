"""Structures that are held: published oscillators, both ways to their motions, limits, and branches of them."""

import json
import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from percuss import steady_states
from percuss.errors import LoadError, ParameterError, ResonanceError
from percuss.explore import follow, vary
from percuss.model import External, Kept, Load, ModalBody, Mounted, Reversed, System, UniformBar
from percuss.stability import floquet_multipliers, stability_of
from percuss.steady import PeriodicOrbit, orbit_near, orbits, rest_on_wall

REFERENCE = json.loads((Path(__file__).parents[1] / "data" / "orbits.json").read_text(encoding="utf-8"))
TURN = 2.0 * math.pi


def oscillator(restitution: float, omega: float, wall: float) -> System:
    """x'' + x = cos ωt with x ≤ wall (Budd & Dux 1994), in radians of the load."""
    body = ModalBody((1.0 / omega,), (0.0,), (1.0,), (1.0 / omega**2,), wall)
    return System(body, Load.harmonic(0.0, 1.0), Kept(restitution))


def two_modes() -> tuple[System, dict]:
    found = next(case for case in REFERENCE if case["name"] == "spring_two_modes")
    told = found["system"]
    of = told["structure"]
    body = ModalBody(of["omega"], of["damping"], of["contact"], of["drive"], told["gap"])
    coefficients = [complex(*pair) for pair in told["load"]["coefficients"]]
    return System(body, Load.fourier(coefficients), Kept(told["restitution"])), found


def stepped(system: System, load: Load) -> System:
    return System(system.body, load, system.contact)


# -- published cases ----------------------------------------------------------------------------------------------


def test_the_oscillator_of_budd_and_dux():
    (orbit,) = orbits(oscillator(0.8, 2.8, -0.1), 1, 1).orbits
    assert orbit.speeds[0] * 2.8 == pytest.approx(0.564815013723, abs=1e-11)
    assert orbit.phase / TURN == pytest.approx(0.477970120, abs=1e-9)
    values = orbit.multipliers().values
    assert np.sort_complex(values) == pytest.approx([complex(-0.610515575, i * 0.516982332) for i in (-1, 1)], abs=1e-8)


def test_its_resonant_motion_has_a_double_multiplier():
    found = [orbit for orbit in steady_states(oscillator(0.8, 2.0, 0.0)).orbits if orbit.admissible]
    assert [2.0 * orbit.impact_velocity for orbit in found] == [pytest.approx(20.0 / 3.0, rel=1e-13)]
    assert floquet_multipliers(found[0]).values == pytest.approx([0.8, 0.8], abs=1e-7)


def test_its_flip_along_the_gap():
    branch = follow(orbits(oscillator(0.8, 2.8, -0.1), 1, 1).orbits[0], "gap", (-0.1, 0.0))
    flips = [point.value for point in branch.points if point.kind.value == "flip"]
    assert flips == [pytest.approx(-0.06857565227883914, abs=1e-11)]


@pytest.mark.parametrize("omega", [1.0, 0.7])
def test_the_impact_of_coco_dies_on_its_grazing_curve(omega):
    stiffness, damping, wall = 1.0, 0.1, 1.0
    body = ModalBody((1.0 / omega,), (damping / omega,), (1.0,), (1.0 / omega**2,), wall)
    system = System(body, Load.harmonic(0.0, 0.8), Kept(0.8))
    branch = follow(orbits(system, 1, 1).orbits[0], "amplitude", (0.01, 1.0))
    dies = [point.value for point in branch.points if point.kind.value == "grazing_impact_dies"]
    assert dies == [pytest.approx(wall * math.hypot(stiffness - omega**2, damping * omega), rel=1e-9)]


def test_two_modes_with_a_gap():
    system, told = two_modes()
    found = orbits(system, 1, 1)
    (orbit,), (impact,) = found.orbits, told["impacts"]
    assert found.complete and orbit.proven and orbit.modes == 2
    assert orbit.phase == pytest.approx(float(impact["phase"]), abs=1e-12)
    assert orbit.speeds[0] == pytest.approx(float(impact["speed"]), abs=1e-12)
    wanted = [complex(*pair) for pair in told["multipliers"]]
    assert np.sort_complex(orbit.multipliers().values) == pytest.approx(np.sort_complex(wanted), abs=1e-10)


# -- both ways to the motions with one impact -------------------------------------------------------------------------

bodies = st.integers(1, 4).flatmap(
    lambda n: st.builds(
        ModalBody,
        st.lists(st.floats(0.2, 9.0), min_size=n, max_size=n).map(tuple),
        st.lists(st.floats(1e-3, 3.0), min_size=n, max_size=n).map(tuple),
        st.lists(st.floats(0.1, 2.0), min_size=n, max_size=n).map(tuple),
        st.lists(st.floats(-2.0, 2.0).filter(lambda b: abs(b) > 0.05), min_size=n, max_size=n).map(tuple),
        st.floats(-1.0, 1.0),
    )
)
loads = st.one_of(
    st.builds(lambda p, q, r: Load.fourier([p, 1.0, complex(q, r)]), *[st.floats(-1.0, 1.0)] * 3),
    st.builds(lambda a, b: Load.steps([0.3, 0.3 + a], [1.0, b]), st.floats(0.5, 5.0), st.floats(-2.0, 0.5)),
)
systems = st.builds(System, bodies, loads, st.floats(0.0, 1.0).map(Kept))


@settings(max_examples=20)
@given(systems, st.integers(1, 2))
def test_steady_motions_are_orbits_with_one_impact(system, periods):
    modes = system.body.most_modes
    for orbit in steady_states(system, periods).orbits:
        told = PeriodicOrbit(system, periods, (orbit.phase,), modes)
        size = float(np.abs(told.states[0].amplitude).max()) + abs(system.body.gap) + 1.0
        if not orbit.fold:
            assert abs(told.residual) < 1e-9 * size
        assert abs(told.speeds[0] - orbit.impact_velocity) < 1e-8 * size * (1.0 + max(system.body.omega))
        if min(system.body.delta) > 0.05:
            assert abs(orbit.energy.imbalance) < 1e-7 * size**2 * (1.0 + max(system.body.omega)) ** 2


@settings(max_examples=20)
@given(systems, st.floats(0.05, 6.2))
def test_no_phase_is_missed(system, first):
    """The curve that meets the gap, looked at closely: between two roots it does not change sides."""
    states = steady_states(system)
    phases = np.linspace(first, first + TURN, 400, endpoint=False)
    off = states.contact_place(np.mod(phases, TURN)) - system.body.gap
    scale = float(np.abs(off).max())
    sides = np.sign(np.where(np.abs(off) < 1e-7 * scale, 0.0, off))
    seen = sides[sides != 0.0]
    changes = int(np.count_nonzero(seen != np.roll(seen, 1))) if seen.size else 0
    assert len([orbit for orbit in states.orbits if not orbit.fold]) >= changes


def test_an_integrator_that_knows_no_modes_goes_through_the_same_impacts():
    system, _ = two_modes()
    (orbit,), body = orbits(system, 1, 1).orbits, system.body
    omega, delta, b, a = (np.array(v) for v in (body.omega, body.delta, body.drive, body.contact))
    state = orbit.states[0]
    start = np.concatenate([b * state.rebound, b * -0.7 * state.velocity])

    def rates(t, y):
        q, v = np.split(y, 2)
        return np.concatenate([v, b * (0.2 + np.cos(orbit.phase + t)) - delta * v - omega**2 * q])

    def touch(t, y):
        return a @ y[:2] - body.gap if t > 0.1 else -1.0

    touch.terminal = True
    flown = solve_ivp(rates, (0.0, 10.0), start, rtol=1e-12, atol=1e-13, events=touch, method="DOP853")
    assert flown.t[-1] == pytest.approx(TURN, abs=1e-9)
    assert a @ flown.y[2:, -1] == pytest.approx(orbit.speeds[0], abs=1e-9)


# -- limits --------------------------------------------------------------------------------------------------------


def test_a_bar_on_a_soft_spring_is_a_free_one():
    load, bar = Load.harmonic(0.9, 1.0), UniformBar(5.0, External(0.05))
    free = orbit_near(System(bar, load, Kept(0.6)), [2.2], modes=6)
    body = Mounted(stiffness=1e-7, s=5.0, damping=External(0.05), gap=0.0)
    # the spring holds the bar in the middle of the motion of its mean: the gap that this takes is found by the phase
    held = PeriodicOrbit(System(body, load, Kept(0.6)), 1, free.times, 7)
    place = float(held.residuals[0])
    there = System(Mounted(1e-7, 0.0, 5.0, External(0.05), place), load, Kept(0.6))
    moved = PeriodicOrbit(there, 1, free.times, 7)
    assert abs(moved.residual) < 1e-6 * abs(place)
    assert moved.speeds == pytest.approx(free.speeds, rel=1e-4)


def test_a_stiff_bar_on_a_spring_is_a_rigid_mass():
    load = Load.harmonic(0.1, 1.0)
    rigid = steady_states(System(Mounted(0.5, 0.1), load, Kept(0.6))).orbits
    stiff = steady_states(System(Mounted(0.5, 0.1, s=1e4), load, Kept(0.6)), modes=8).orbits
    assert [o.phase for o in stiff] == pytest.approx([o.phase for o in rigid], abs=1e-6)
    assert [o.impact_velocity for o in stiff] == pytest.approx([o.impact_velocity for o in rigid], rel=1e-3)


def test_a_wall_in_the_distance_and_a_wall_that_presses_have_no_such_motion():
    assert not steady_states(oscillator(0.8, 2.8, 50.0)).exists
    assert not steady_states(oscillator(0.8, 2.8, -50.0)).exists


def test_a_mean_load_is_another_gap():
    body = Mounted(0.6, 0.1)
    pushed = System(body, Load.harmonic(0.3, 1.0), Kept(0.5))
    moved = System(Mounted(0.6, 0.1, gap=-0.5), Load.harmonic(0.0, 1.0), Kept(0.5))
    (one, _), (other, _) = steady_states(pushed).orbits, steady_states(moved).orbits
    assert one.phase == pytest.approx(other.phase, abs=1e-14)


def test_a_mode_that_does_not_move_the_contact_changes_nothing_there():
    system, _ = two_modes()
    body = system.body
    more = ModalBody((*body.omega, 1.4), (*body.delta, 0.2), (*body.contact, 0.0), (*body.drive, 0.7), body.gap)
    (one,) = orbits(system, 1, 1).orbits
    (other,) = orbits(System(more, system.load, system.contact), 1, 1).orbits
    assert other.phase == pytest.approx(one.phase, abs=1e-13)
    lost = one.modal_determinants, other.multipliers().values
    assert lost[1].size == 6 and other.multipliers().largest < 1.0


def test_steps_and_their_harmonics_agree():
    system, _ = two_modes()
    exact = steady_states(stepped(system, Load.square(1.0, 0.8, 512))).orbits
    rough = steady_states(stepped(system, Load.fourier(Load.square(1.0, 0.8, 512).coefficients))).orbits
    assert [o.phase for o in exact] == pytest.approx([o.phase for o in rough], abs=1e-4)


# -- parameters and refusals -----------------------------------------------------------------------------------------


def test_the_parameters_of_structures():
    system = System(Mounted(0.6, 0.1, s=8.0, gap=0.2), Load.harmonic(0.3, 1.0), Kept(0.5))
    for name, value in (("gap", -0.3), ("stiffness", 2.0), ("dashpot", 0.4), ("s", 9.0), ("restitution", 0.1)):
        moved = vary(system, {name: value})
        assert getattr(moved.contact if name == "restitution" else moved.body, name) == value
    with pytest.raises(ParameterError, match="a body that has it"):
        vary(two_modes()[0], {"stiffness": 1.0})


@pytest.mark.parametrize(
    ("wrong", "name"),
    [
        ({"omega": (1.0, -2.0)}, "omega"),
        ({"omega": (0.0, 1.0)}, "omega"),
        ({"delta": (0.1, -1e-3)}, "delta"),
        ({"drive": (1.0,)}, "drive"),
        ({"drive": (0.0, 0.0)}, "feels the load"),
        ({"contact": (0.0, 0.0)}, "moves the contact"),
        ({"gap": math.inf}, "gap"),
    ],
)
def test_a_table_that_is_none(wrong, name):
    good = {"omega": (1.0, 2.0), "delta": (0.1, 0.1), "contact": (1.0, 1.0), "drive": (1.0, 1.0), "gap": 0.1}
    with pytest.raises(ParameterError, match=name):
        ModalBody(**{**good, **wrong})


def test_what_needs_a_free_bar_says_so():
    system, _ = two_modes()
    (orbit,) = (orbit for orbit in steady_states(system).orbits if orbit.admissible)
    judged = stability_of(orbit)
    assert judged.stable and judged.multipliers.largest == pytest.approx(0.6424329487950257, abs=1e-12)
    for asked in (lambda: judged.reduced, lambda: judged.waveform, lambda: rest_on_wall(system), lambda: system.s):
        with pytest.raises(ParameterError, match="bar"):
            asked()
    with pytest.raises(ParameterError, match=r"keeps the strain|uniform bar"):
        System(system.body, system.load, Reversed(0.5))
    with pytest.raises(LoadError):
        steady_states(stepped(system, Load.fourier([0.3])))
    with pytest.raises(ParameterError, match="1 or more"):
        orbits(system, 1, 1, modes=0)


def test_resonance_with_the_load_and_with_the_impacts():
    with pytest.raises(ResonanceError):
        steady_states(oscillator(0.8, 1.0, 0.0))
    with pytest.raises(ResonanceError):
        steady_states(stepped(oscillator(0.8, 0.5, 0.0), Load.steps([0.0, 2.0], [1.0, -0.3])))
    free = System(ModalBody((2.0,), (0.0,), (1.0,), (1.0,), 0.1), Load.harmonic(0.1, 1.0), Kept(0.5))
    states = steady_states(free)  # swings twice between the impacts, whatever its amplitude
    assert not states.exists and "internal resonance" in states.note


def test_an_orbit_has_no_more_modes_than_the_structure() -> None:
    body = ModalBody((0.5, 3.0), (0.1, 0.1), (1.0, 1.0), (1.0, 1.0), 0.01)
    system = System(body, Load.harmonic(0.0, 1.0), Kept(0.8))
    with pytest.raises(ParameterError, match=r"modes = 3: expected at most 2"):
        assert PeriodicOrbit(system, 1, (1.0,), 3).speeds
    assert PeriodicOrbit(system, 1, (1.0,), 2).speeds.size == 1
