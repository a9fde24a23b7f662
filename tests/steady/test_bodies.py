"""Steady motions of any body, damping and contact law: integration, energy, figures from elsewhere, limits."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from percuss import Load, System, rest_on_wall, steady_states
from percuss.errors import ResonanceError
from percuss.model import (
    UNDAMPED,
    Body,
    Contact,
    Damping,
    External,
    KelvinVoigt,
    Kept,
    Ratio,
    Reversed,
    SteppedBar,
    Table,
    UniformBar,
)
from percuss.steady import Orbit, drag_of, greatest_drag, grows
from strategies import decades

CASES = [
    case for case in json.loads((Path(__file__).parents[1] / "data/blow.json").read_text()) if case["kind"] == "steady"
]
LAWS: list[Damping] = [External(0.0), External(0.4), Ratio(0.02), Ratio(1.0), KelvinVoigt(2e-3), Table((0.3, 0.0, 0.9))]
STRONG: list[Damping] = [External(40.0), KelvinVoigt(0.3), Table((30.0, 1.0))]
SMOOTH = Load.fourier([0.15, 1.0, 0.2j])
STEPS = Load.steps([0.3, 1.9, 4.0], [1.3, -0.9, 0.25])


def stepped(damping: Damping = UNDAMPED, s: float = 2.45) -> SteppedBar:
    return SteppedBar(s, (1.0, 3.0, 1.5), (1.0, 1.0, 0.5), damping)


BODIES: list[Callable[[Damping], Body]] = [lambda damping: UniformBar(2.3, damping), stepped]


# ---------------------------------------------------------------- figures computed elsewhere


def reference_system(case: dict[str, Any]) -> System:
    law = {"external": External, "ratio": Ratio, "kv": KelvinVoigt}[case["damping"]["kind"]]
    body = SteppedBar(
        float(case["s"]),
        tuple(map(float, case["impedances"])),
        tuple(map(float, case["transit_times"])),
        law(float(case["damping"]["value"])),
    )
    load = Load.fourier([complex(float(a), float(b)) for a, b in case["load"]])
    return System(body, load, Kept(float(case["restitution"])))


@pytest.mark.parametrize("case", CASES, ids=lambda case: case["name"])
def test_figures_of_sectioned_bars(case: dict[str, Any]) -> None:
    system, expect = reference_system(case), case["expect"]
    modes = system.body.modes(8)
    assert modes.omega == pytest.approx([float(x) for x in expect["omega_N8"]], rel=1e-12)
    assert modes.gamma == pytest.approx([float(x) for x in expect["gamma_N8"]], rel=1e-12)
    found = steady_states(system, case["m"], modes=16)
    assert found.level == pytest.approx(float(expect["level_c"]), rel=1e-12)
    assert len(found.orbits) == len(expect["states"])
    for orbit, state in zip(found.orbits, expect["states"], strict=True):
        assert orbit.phase == pytest.approx(float(state["phi"]), rel=1e-12)
        assert orbit.impact_velocity == pytest.approx(float(state["striking_speed_N16"]), rel=1e-12)
        assert orbit.blow_energy == pytest.approx(float(state["blow_energy_N16"]), rel=1e-12)
        first = [float(x) for x in state["gap_coordinate_before_impact_N8"]]
        assert orbit.state.velocity[:3] == pytest.approx(first, rel=1e-10)


# ---------------------------------------------------------------- plain integration


def by_steps(square: np.ndarray, damping: np.ndarray, start: float, load: Load, phase: float, end: float) -> Any:
    """A function that carries u, u' from one time to another, by DOP853."""

    def rate(t: float, x: np.ndarray) -> np.ndarray:
        force = float(load.value(phase + (0.5 * (start + end) if load.is_piecewise else t)))
        u, v = np.split(x, 2)
        return np.concatenate([v, force - damping * v - square * u])

    return lambda x: solve_ivp(rate, (start, end), x, method="DOP853", rtol=1e-13, atol=1e-14).y[:, -1]


def by_exponential(square: np.ndarray, damping: np.ndarray, start: float, load: Load, phase: float, end: float) -> Any:
    """The same by the exponential of one matrix, of which the waves of the load are a part."""
    n = square.size
    k = np.array([0.0]) if load.is_piecewise else np.append(0.0, load.harmonics)
    here = phase + (0.5 * (start + end) if load.is_piecewise else start)
    p = np.array([float(load.value(here))]) if load.is_piecewise else load.coefficients[k.astype(int)]
    waves = p * np.exp(1j * k * here)
    a = np.zeros((2 * n + 2 * k.size,) * 2)
    a[:n, n : 2 * n] = np.eye(n)
    a[n : 2 * n, :n], a[n : 2 * n, n : 2 * n] = -np.diag(square), -np.diag(damping)
    a[n : 2 * n, 2 * n : 2 * n + k.size] = 1.0
    rest = a[2 * n :, 2 * n :]
    rest[: k.size, k.size :], rest[k.size :, : k.size] = -np.diag(k), np.diag(k)
    whole = expm(a * (end - start))
    return lambda x: (whole @ np.concatenate([x, waves.real, waves.imag]))[: 2 * n]


def integrated(orbit: Orbit, modes: int, way: Callable[..., Any]) -> np.ndarray:
    """u_0, u_n, u_0', u_n' after a flight from the state just after the impact, from step to step of the load."""
    system, state = orbit.system, orbit.state
    known = system.body.modes(modes, system.load.at)
    square, damping = np.append(0.0, known.omega**2), np.append(system.d, known.damping)
    u = np.append(-known.gamma @ state.rebound, state.rebound)
    now = np.concatenate([u, -system.restitution * np.append(orbit.rigid_velocity, state.velocity)])
    turns = 2.0 * math.pi * np.arange(orbit.periods)
    breaks = np.add.outer(np.mod(np.array(system.load.breaks) - orbit.phase, 2.0 * math.pi), turns).reshape(-1)
    knots = [0.0, *sorted(b for b in breaks if 1e-9 < b < orbit.period - 1e-9), orbit.period]
    for start, end in pairwise(knots):
        now = way(square, damping, start, system.load, orbit.phase, end)(now)
    return now


def check_period(orbit: Orbit, modes: int, way: Callable[..., Any] = by_exponential, tolerance: float = 1e-12) -> None:
    system, state, n = orbit.system, orbit.state, modes + 1
    after = integrated(orbit, modes, way)
    gamma = np.append(1.0, system.body.modes(modes, system.load.at).gamma)
    size = max(1.0, float(np.abs(after).max()))
    assert abs(float(gamma @ after[:n])) <= tolerance * size  # at the wall again
    assert np.abs(after[1:n] - state.displacement).max(initial=0.0) <= tolerance * size
    assert np.abs(after[n:] - np.append(orbit.rigid_velocity, state.velocity)).max() <= tolerance * size
    assert state.rebound == pytest.approx(system.contact.strain_factor * state.displacement, abs=1e-13 * size)
    assert orbit.impact_velocity == pytest.approx(float(gamma @ after[n:]), abs=tolerance * size)


@pytest.mark.parametrize("law", [*LAWS, *STRONG], ids=str)
@pytest.mark.parametrize("body", BODIES, ids=["uniform", "stepped"])
def test_a_period_closes_by_plain_integration(body: Callable[[Damping], Body], law: Damping) -> None:
    made = body(law)
    for r, load in ((0.6, SMOOTH), (0.0, STEPS)):
        load = load.with_mean(0.002) if law.rigid > 1.0 else load
        found = steady_states(System(made, load, Kept(r)), modes=3)
        assert found.orbits
        check_period(found.orbits[-1], 3)


@pytest.mark.parametrize("law", [*LAWS, *STRONG], ids=str)
@pytest.mark.parametrize("r", [0.0, 0.7, 1.0])
def test_a_period_closes_when_the_strain_turns_over(law: Damping, r: float) -> None:
    """Phases and all: the impact moves the bar as a whole against its end, and the flight brings it back."""
    for load in (SMOOTH, STEPS):
        load = load.with_mean(0.002) if law.rigid > 1.0 else load
        for orbit in steady_states(System(UniformBar(2.3, law), load, Reversed(r)), modes=3).orbits:
            check_period(orbit, 3)


@pytest.mark.parametrize("contact", [Kept(0.6), Reversed(0.3)], ids=str)
def test_a_period_closes_step_by_step(contact: Contact) -> None:
    """By a method for any differential equation: what the exponentials of the other tests rest on."""
    for law in (Ratio(0.02), KelvinVoigt(2e-3), Table((0.3, 0.0, 0.9))):
        check_period(
            steady_states(System(UniformBar(2.3, law), SMOOTH, contact), modes=3).orbits[-1], 3, by_steps, 1e-11
        )


@pytest.mark.parametrize("at", [0, 1, 2])
def test_a_load_on_a_shoulder(at: int) -> None:
    system = System(stepped(Ratio(0.02)), SMOOTH.acting_at(at), Kept(0.6))
    orbit = steady_states(system, 2, modes=4).orbits[-1]
    check_period(orbit, 4)
    assert abs(orbit.energy.imbalance) <= 1e-12 * orbit.energy.input
    place = system.body.place(at)
    t = np.linspace(0.0, orbit.period, 20001)
    power = system.load.value(orbit.phase + t) * orbit.velocity([place], t)[0]
    assert orbit.energy.input == pytest.approx(float(np.trapezoid(power, t)), rel=1e-5)


# ---------------------------------------------------------------- energy


@pytest.mark.parametrize("law", [*LAWS, *STRONG], ids=str)
@pytest.mark.parametrize("contact", [Kept(0.4), Reversed(0.4), Reversed(0.0)], ids=str)
@pytest.mark.parametrize("modes", [5, None])
def test_energy_closes(law: Damping, contact: Contact, modes: int | None) -> None:
    for load in (SMOOTH, STEPS):
        load = load.with_mean(0.002) if law.rigid > 1.0 else load
        for orbit in steady_states(System(UniformBar(2.3, law), load, contact), modes=modes).orbits:
            energy = orbit.energy
            scale = abs(energy.input) + energy.damping + energy.impact
            assert abs(energy.imbalance) <= 1e-11 * scale
            assert energy.damping >= -1e-12 * scale
            assert law.is_zero <= (energy.damping == 0.0)


def test_energy_of_a_field() -> None:
    """Kinetic and strain energy before the impact are those of the fields; the law takes its share of both."""
    orbit = steady_states(System(UniformBar(2.3, Ratio(0.05)), SMOOTH, Reversed(0.4)), modes=6).orbits[-1]
    x = np.linspace(0.0, 1.0, 20001)
    field = orbit.field(x, [orbit.period])
    assert 0.5 * np.trapezoid(field.velocity[:, 0] ** 2, x) == pytest.approx(orbit.blow_energy, rel=1e-6)
    strain = 0.5 * 2.3**2 * np.trapezoid(field.strain[:, 0] ** 2, x)
    assert strain == pytest.approx(orbit.strain_energy, rel=1e-6)
    assert orbit.delivered_energy == pytest.approx((1 - 0.4**2) * (orbit.blow_energy + strain), rel=1e-6)


# ---------------------------------------------------------------- relations between bodies


@settings(max_examples=15)
@given(
    impedances=st.lists(st.floats(0.2, 5.0), min_size=2, max_size=5),
    s=decades(0.0, 2.0),
    ratio=st.sampled_from([0.0, 1e-3, 0.1]),
    r=st.floats(0.0, 0.99),
)
def test_a_turned_bar_strikes_alike(impedances: list[float], s: float, ratio: float, r: float) -> None:
    times = [1.0 + 0.3 * i for i in range(len(impedances))]
    bodies = [
        SteppedBar(s, tuple(impedances), tuple(times), Ratio(ratio)),
        SteppedBar(s, tuple(impedances[::-1]), tuple(times[::-1]), Ratio(ratio)),
    ]
    try:
        here, there = (steady_states(System(body, SMOOTH, Kept(r)), 1, modes=20) for body in bodies)
    except ResonanceError:
        assume(False)
    assert len(here.orbits) == len(there.orbits)
    for one, other in zip(here.orbits, there.orbits, strict=True):
        assert other.phase == pytest.approx(one.phase, abs=1e-12)
        assert other.impact_velocity == pytest.approx(one.impact_velocity, rel=1e-8, abs=1e-9)
        t = np.linspace(0.0, one.period, 7)
        assert other.motion(t) == pytest.approx(one.motion(t), abs=1e-8 * one.rigid_stroke)


@pytest.mark.parametrize("law", LAWS, ids=str)
@pytest.mark.parametrize("load", [SMOOTH, STEPS], ids=["smooth", "steps"])
def test_equal_sections_are_a_uniform_bar(law: Damping, load: Load) -> None:
    whole, parts = UniformBar(3.1, law), SteppedBar(3.1, (2.0, 2.0, 2.0), (1.0, 2.0, 0.5), law)
    for modes, contact in ((12, Kept(0.5)), (None, Kept(0.5)), (12, Reversed(0.4))):
        pairs = [steady_states(System(body, load, contact), modes=modes).orbits for body in (whole, parts)]
        for one, other in zip(*pairs, strict=True):
            tolerance = 1e-12 if modes else 1e-8
            assert other.phase == pytest.approx(one.phase, abs=1e-12)
            assert other.impact_velocity == pytest.approx(one.impact_velocity, rel=tolerance)
            assert other.blow_energy == pytest.approx(one.blow_energy, rel=tolerance)
            assert other.energy.input == pytest.approx(one.energy.input, rel=10 * tolerance)
            assert other.admissible == one.admissible
            x, t = np.linspace(0.0, 1.0, 5), np.linspace(0.0, one.period, 6)
            size = tolerance * max(1.0, one.rigid_stroke)
            assert other.field(x, t).displacement == pytest.approx(one.field(x, t).displacement, abs=10 * size)


@pytest.mark.parametrize(("law", "values"), [(Ratio, (1e-8, 1e-10)), (KelvinVoigt, (1e-10, 1e-12))])
def test_weak_damping_tends_to_none(law: Callable[[float], Damping], values: tuple[float, ...]) -> None:
    free = steady_states(System(stepped(), SMOOTH, Kept(0.5)), modes=10).orbits[-1]
    errors = []
    for value in values:
        orbit = steady_states(System(stepped(law(value)), SMOOTH, Kept(0.5)), modes=10).orbits[-1]
        assert orbit.phase == pytest.approx(free.phase, abs=1e-13)  # the rigid motion knows no damping
        errors.append(abs(orbit.impact_velocity - free.impact_velocity))
    assert errors[1] == pytest.approx(1e-2 * errors[0], rel=0.1)


def test_the_sums_of_all_modes_are_the_limit_of_many() -> None:
    for law in (Ratio(0.01), KelvinVoigt(1e-3), External(0.2)):
        system = System(stepped(law), SMOOTH, Kept(0.5))
        whole = steady_states(system).orbits[-1]
        t = np.linspace(0.0, whole.period, 9)
        few, many = (steady_states(system, modes=n).orbits[-1].motion(t) - whole.motion(t) for n in (50, 400))
        assert np.abs(many).max() < 0.2 * np.abs(few).max() < 1e-3
        assert whole.error_bound <= 1e-10


# ---------------------------------------------------------------- the law that turns the strain over


def test_reversed_phases_differ_at_second_order() -> None:
    speeds, off = [(swings + 0.3) / math.pi for swings in (20, 40, 80, 160)], []
    for s in speeds:
        pair = [steady_states(System(UniformBar(s), SMOOTH, law(0.5)), modes=30).orbits[-1] for law in (Kept, Reversed)]
        off.append(abs(pair[0].phase - pair[1].phase))
    assert np.polyfit(np.log(speeds), np.log(off), 1)[0] == pytest.approx(-2.0, abs=0.1)


def test_the_gap_is_closed_at_both_ends_of_a_flight() -> None:
    for law in (External(0.3), Ratio(1e-3)):
        for modes in (None, 7):
            for load in (SMOOTH, STEPS):
                found = steady_states(System(UniformBar(6.0, law), load, Reversed(0.5)), modes=modes)
                for orbit in found.orbits:
                    assert orbit.motion([0.0, orbit.period]) == pytest.approx([0.0, 0.0], abs=1e-12)
                    assert found.rigid_velocity(orbit.phase) == pytest.approx(found.level, abs=1e-2)


def test_full_rebound_grows_only_with_the_strain_kept() -> None:
    phases = [0.3, 2.0]
    body = UniformBar(7.3)
    assert grows(System(body, SMOOTH, Kept(1.0)), phases).all()
    assert not grows(System(body, SMOOTH, Reversed(1.0)), phases).any()
    assert not grows(System(UniformBar(7.3, Ratio(1e-6)), SMOOTH, Kept(1.0)), phases).any()
    assert grows(System(UniformBar(7.3, Table((0.1, 0.0))), SMOOTH, Kept(1.0)), phases).all()


# ---------------------------------------------------------------- resonance, rest, drag


def test_resonance_with_an_undamped_mode_of_any_body() -> None:
    first = float(stepped().frequencies(1)[0])
    for law, refused in (
        (External(0.0), True),
        (Table((0.0, 0.1)), True),
        (Ratio(1e-6), False),
        (External(1e-6), False),
    ):
        system = System(stepped(law, 2.45 / first), SMOOTH, Kept(0.5))
        if refused:
            with pytest.raises(ResonanceError, match=r"k = 1.*n = 1|n = 1"):
                steady_states(system)
        else:
            assert steady_states(system).exists


@pytest.mark.parametrize("law", [External(0.0), External(0.7), KelvinVoigt(0.01), Ratio(0.02)], ids=str)
def test_contact_force_at_rest_by_waves_and_by_receptances(law: Damping) -> None:
    """Sections that are all alike, without the uniform bar's closed form."""
    load = Load.fourier([1.2, 0.5, 0.3j])
    one = rest_on_wall(System(UniformBar(2.7, law), load, Kept(0.5)))
    other = rest_on_wall(System(SteppedBar(2.7, (1.0, 1.0), (1.0, 1.0), law), load, Kept(0.5)))
    assert other.least_contact_force == pytest.approx(one.least_contact_force, rel=1e-9)
    assert other.possible == one.possible


def test_contact_force_of_steps_where_waves_are_not_followed() -> None:
    """Fejér's mean never falls below the least force, and misses it by little where nothing is short."""
    load = Load.steps([0.0, 3.0], [1.0, 0.4])
    exact = rest_on_wall(System(UniformBar(3.7, External(0.5)), load, Kept(0.5))).least_contact_force
    mean = rest_on_wall(System(SteppedBar(3.7, (1.0, 1.0), (1.0, 1.0), External(0.5)), load, Kept(0.5)))
    assert exact - 1e-9 <= mean.least_contact_force <= exact + 0.02


def test_only_external_damping_drags() -> None:
    for law, drags in ((External(0.05), True), (Ratio(0.01), False), (KelvinVoigt(0.01), False)):
        system = System(stepped(law), SMOOTH, Kept(0.5))
        assert (drag_of(steady_states(system).orbits[-1]).force > 0.0) is drags
    heavy = System(stepped(External(3.0)), SMOOTH.with_mean(0.5), Kept(0.3))
    most = greatest_drag(heavy, 1)
    assert most is not None and 0.0 < most < 3.0
    assert steady_states(System(stepped(External(0.999 * most)), heavy.load, heavy.contact)).exists
    assert greatest_drag(System(stepped(Ratio(0.1)), SMOOTH, Kept(0.5)), 1) is None
