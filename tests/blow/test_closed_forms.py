"""The closed forms against the waves, over the whole range in which they hold."""

from __future__ import annotations

import math
import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from blow_strategies import section
from machine_cases import DRIFTER, bar, rod_for, settled
from percuss import Kept, Load, System
from percuss.blow import Blow, BlowOutcome, Rock, Rod, Wall, closed_forms, effective_blow, strike
from percuss.errors import ParameterError
from percuss.model import Bar, Section, SectionedBar, SteppedBar, Timed, UniformBar
from percuss.simulate import Start
from percuss.steady import timed_states
from strategies import decades


def test_st_venant():
    """L = 1 m, E = 210 GPa, ρ = 7800 kg/m³, S = 3.14 cm², 0.1 m/s."""
    bar = Bar(1.0, 3.14e-4, 210e9, 7800.0)
    blow = strike(bar, Wall(), 0.1)
    assert blow.outcome is BlowOutcome.OVER
    assert blow.contact_duration == pytest.approx(3.854496446637726e-4, rel=1e-14)
    assert blow.contacts[0].peak_force == pytest.approx(1270.82747846, rel=1e-11)
    assert blow.effective_restitution == pytest.approx(1.0, abs=1e-14)
    closed = closed_forms.uniform_blow(bar.impedance, bar.transit_time, 0.1)
    assert closed.force == pytest.approx(blow.contacts[0].peak_force, rel=1e-14)
    assert closed.duration == pytest.approx(blow.contact_duration, rel=1e-14)


@given(s=decades(-1.0, 3.0), ratio=decades(0.0, 4.0))
def test_a_uniform_striker_on_a_rod_that_is_no_less_stiff(s, ratio):
    """One contact of two transit times, R = (Z_2 − Z)/(Z_2 + Z), and no ringing: B77's law is exact."""
    found = effective_blow(UniformBar(s), Rod.of_impedance(ratio * s))
    closed = closed_forms.uniform_blow(s, 1.0 / s, 1.0, ratio * s)
    assert found.restitution == pytest.approx(closed.restitution, abs=1e-13)
    assert found.duration == pytest.approx(closed.duration, rel=1e-12)
    assert found.centroid == pytest.approx(0.5 * closed.duration, rel=1e-12)
    assert found.advance == pytest.approx((1.0 - closed.restitution) / s, rel=1e-10, abs=1e-13)
    assert found.ringing == pytest.approx(0.0, abs=1e-14)
    assert found.contacts == 1


@given(ratio=decades(0.01, 3.0), steps=st.integers(1, 8))
def test_the_staircase(ratio, steps):
    """Force and velocity after each round trip of a striker that is stiffer than the rod."""
    blow = strike(Bar(0.5, ratio, 1.0, 1.0), Rod([section(1.0, None)]), 2.0, until=float(steps) + 0.5)
    for k in range(steps):
        force = closed_forms.staircase_force(ratio, 1.0, 2.0, k)
        assert blow.face_force.at(k + 0.5) == pytest.approx(force, abs=1e-13 * ratio)
    state = blow.state_at(float(steps)).striker
    assert state.velocity[1:-1] == pytest.approx(closed_forms.staircase_velocity(ratio, 1.0, 2.0, steps), abs=1e-13)
    if steps == 1:
        passed = closed_forms.uniform_blow(ratio, 1.0, 1.0, 1.0).passed
        first = strike(Bar(0.5, ratio, 1.0, 1.0), Rod([section(1.0, None)]), 2.0, until=1.0)
        assert first.work_through_face == pytest.approx(passed * first.energy_before, rel=1e-12)


@given(rho=st.floats(-0.499, 0.309))
def test_two_sections_of_equal_transit_times_on_a_wall(rho):
    rear, head = 1.0 + rho, 1.0 - rho
    found = effective_blow(SteppedBar(4.0, (rear, head), (1.0, 1.0)), Wall())
    assert found.restitution == pytest.approx(closed_forms.two_section_restitution(rear, head), abs=1e-12)
    assert found.ringing == pytest.approx(4.0 * rho**2 * (1.0 - rho**2), abs=1e-12)


@given(beta=decades(-1.5, 1.2), gamma=st.floats(0.01, 1.0))
def test_a_matched_hammer_on_rock(beta, gamma):
    """Lundberg's efficiency: the rod is long enough for the first wave to have gone back before anything returns."""
    rod = Rod([section(1.0, 50.0)], "rock", rock=Rock(0.5 * beta, gamma))
    blow = strike(Bar(1.0, 1.0, 1.0, 1.0), rod, 1.0, until=95.0)
    assert blow.rock_dissipated / blow.energy_before == pytest.approx(
        closed_forms.matched_efficiency(beta, gamma), abs=1e-12
    )
    assert blow.bit_force.at(51.0) == pytest.approx(-math.expm1(-0.5 * beta), rel=1e-12)


def test_the_best_beta_is_the_best():
    best = closed_forms.matched_efficiency(closed_forms.BEST_BETA, 0.25)
    assert math.exp(closed_forms.BEST_BETA) == pytest.approx(1.0 + 2.0 * closed_forms.BEST_BETA, rel=1e-14)
    assert best == pytest.approx(0.75 * 0.8145287552, rel=1e-10)
    for other in (0.99, 1.01):
        assert closed_forms.matched_efficiency(other * closed_forms.BEST_BETA, 0.25) < best


def test_an_exponential_wave_does_the_most_work():
    """The best wave of a duration, sent as the field of a long striker through a matched rod."""
    beta, gamma = 2.0, 0.2
    rod = Rod([section(1.0, 60.0)], "rock", rock=Rock(beta, gamma))
    # what is at x in the striker, all of it going right, arrives the later the further it is from the face
    wave = lambda x: math.e ** (beta * (1.0 - x))  # noqa: E731
    blow = strike(Bar(1.0, 1.0, 1.0, 1.0), rod, field=(wave, wave), until=100.0)
    assert blow.rock_dissipated / blow.energy_before == pytest.approx(
        closed_forms.best_efficiency(beta, gamma), rel=1e-10
    )


@given(mass_ratio=decades(-1.0, 2.0))
def test_a_heavy_bit_is_a_fixed_end_and_a_light_one_is_none(mass_ratio):
    assume(mass_ratio > 0.2)
    striker = Bar(1.0, 1.0, 1.0, 1.0)
    rod = [section(mass_ratio, 2.5)]
    fixed, heavy = (
        strike(striker, Rod(rod, "fixed"), 1.0, until=12.0),
        strike(striker, Rod(rod, "free", bit_mass=1e9), 1.0, until=12.0),
    )
    free, light = (
        strike(striker, Rod(rod, "free"), 1.0, until=12.0),
        strike(striker, Rod(rod, "free", bit_mass=1e-7), 1.0, until=12.0),
    )
    for limit, near in ((fixed, heavy), (free, light)):
        assert near.impulse == pytest.approx(limit.impulse, abs=1e-6)
        assert near.rod_energy == pytest.approx(limit.rod_energy, abs=1e-6)


@pytest.mark.parametrize(
    "refused",
    [
        lambda: closed_forms.staircase_force(1.0, 2.0, 1.0, 0),
        lambda: closed_forms.two_section_restitution(10.0, 1.0),
        lambda: closed_forms.matched_efficiency(0.0, 0.5),
        lambda: closed_forms.best_efficiency(1.0, 1.5),
    ],
)
def test_outside_their_range_they_refuse(refused):
    with pytest.raises(ParameterError):
        refused()


def test_stepped_pistons_of_the_literature():
    """Three sections on a wall, and heavy heads 1:1:4: restitution, ringing and contacts."""
    drifter = SectionedBar(
        [
            Section(length, area=area, youngs_modulus=206e9, density=7850.0)
            for length, area in ((0.0731, 1.2566e-3), (0.2187, 1.9635e-3), (0.1493, 9.503e-4))
        ]
    )
    found = effective_blow(drifter, Wall())
    assert (round(found.restitution, 6), round(found.ringing, 3)) == (0.869177, 0.245)
    heavy = effective_blow(SteppedBar(1.0, (1.0, 1.0, 4.0), (2.0, 1.0, 1.0)), Wall())
    assert (round(heavy.restitution, 6), heavy.contacts) == (0.773714, 2)
    equal = effective_blow(SteppedBar(1.0, (1.0, 1.0, 4.0), (1.0, 1.0, 1.0)), Wall())
    assert equal.restitution == pytest.approx(0.44, abs=0.005)
    assert equal.ringing == pytest.approx(0.80, abs=0.01)


def test_contacts_of_stepped_strikers_by_rational_arithmetic():
    """Sections 15 : 5 : 10 of impedances 1 : 2 : 4 on a rod of 2; the drifter's piston on a wall, and on its rod."""
    head = SteppedBar(1.0, (1.0, 2.0, 4.0), (15.0, 5.0, 10.0))
    blow = strike(head, Rod.of_impedance(0.5 * float(head.sections.impedance[-1])), 1.0)
    impulses = [47.64476959813037, 0.940095576617787, 3.5698356826720787, 0.053637671634381615]
    assert [52.0 * one.impulse for one in blow.contacts[:4]] == pytest.approx(impulses, rel=1e-10)
    drifter = SteppedBar(1.0, (1.2566, 1.9635, 0.9503), (0.0731, 0.2187, 0.1493))
    way = 0.4411 * math.sqrt(7850.0 / 206e9)
    one, two = strike(drifter, Wall(), 1.0).contacts
    times = [1.722139276135286e-4, 2.1691711248230118e-4, 2.2929322078309985e-4]
    assert [way * one.end, way * two.start, way * two.end] == pytest.approx(times, rel=1e-10)
    found = effective_blow(drifter, Rod.of_impedance(4.0 * float(drifter.sections.impedance[-1])))
    wanted = 0.41528390670042886, 40.0 * 0.066923600090682378, 40.0 * 0.02807555306396961
    assert (found.restitution, found.duration, found.centroid) == pytest.approx(wanted, rel=1e-9)


# -- the law of a blow that takes time ---------------------------------------------------------------------------------


# -- the law of a blow that takes time, against blows that are resolved by waves under a load


def law_of(blow: Blow, rod: float) -> Timed:
    """The law of a blow on a rod that stays where the blow puts it."""
    assert blow.effective_restitution is not None
    assert blow.contact_duration is not None and blow.force_centroid is not None
    return Timed(blow.effective_restitution, blow.contact_duration, blow.force_centroid, 1.0 / rod)


def pushed(bar: SteppedBar, rod: Rod, load: float) -> Blow:
    """A blow of a bar that a constant load accelerates: mean velocity 1 at the contact's start, force p (1 − m(x))."""
    impedances, transits = np.array(bar.impedances), np.array(bar.transit_times)
    masses = np.append(0.0, np.cumsum(impedances * transits))
    ends = np.append(0.0, np.cumsum(transits))

    def velocity(x: np.ndarray) -> np.ndarray:
        return np.ones_like(x)

    def force(x: np.ndarray) -> np.ndarray:
        return load * (1.0 - np.interp(x, ends / ends[-1], masses / masses[-1]))

    return strike(bar, rod, None, load=[(0.0, load)], field=(velocity, force), until=12.0 / bar.s)


@settings(max_examples=25)
@given(
    impedances=st.lists(st.floats(0.5, 2.0), min_size=1, max_size=3),
    shares=st.lists(st.floats(0.1, 1.0), min_size=3, max_size=3),
    heavier=st.floats(1.5, 20.0),
    load=st.floats(0.01, 2.0),
)
def test_a_load_adds_what_the_law_says_to_the_impulse(
    impedances: list[float], shares: list[float], heavier: float, load: float
) -> None:
    """J = (1 + R)(V − e p) with V at the centroid; exact while the load ends no contact and begins none."""
    bar = SteppedBar(30.0, tuple(impedances), tuple(shares[: len(impedances)]))
    own = np.array(impedances) / np.dot(impedances, bar.transit_times) * sum(bar.transit_times) * bar.s
    impedance = heavier * float(own.max())
    rod = Rod.of_impedance(impedance)
    free = strike(bar, rod, 1.0)
    assume(len(free.contacts) == 1 and free.effective_restitution is not None and free.effective_restitution >= 0.0)
    law = law_of(free, impedance)
    blow = pushed(bar, rod, load)
    assume(blow.contacts[0].end == pytest.approx(law.duration, rel=1e-9))
    at_centroid = 1.0 + load * law.force_centroid
    assert blow.contacts[0].impulse == pytest.approx(law.impulse(at_centroid, load), rel=1e-10)


@pytest.mark.parametrize("s", [5.0, 40.0])
def test_a_uniform_bar_has_the_closed_law(s: float) -> None:
    rod = 4.0 * s  # R = 3/5
    found, closed = law_of(strike(UniformBar(s), Rod.of_impedance(rod), 1.0), rod), Timed.of_uniform_bar(s, 0.6)
    assert (found.restitution, found.duration, found.force_centroid, found.advance_per_impulse) == pytest.approx(
        (closed.restitution, closed.duration, closed.force_centroid, closed.advance_per_impulse), rel=1e-12
    )


def test_from_the_blow_to_the_phase() -> None:
    """The drifter's piston of three sections, from its sections to the phase of the steady motion."""
    bar, rod = SteppedBar(40.0, (1.2566, 1.9635, 0.9503), (0.0731, 0.2187, 0.1493)), 101.13533508847935
    law = law_of(strike(bar, Rod.of_impedance(rod), 1.0), rod)
    orbit = timed_states(System(bar, Load.harmonic(0.66, 1.0), Kept(law.restitution)), law).orbits[1]
    assert orbit.phase == pytest.approx(2.1280786383417226, abs=1e-9)
    assert orbit.phase_b77 == pytest.approx(2.1128830416367776, abs=1e-9)


# -- the table of the page on simulation, where B77's law is right: its rows, computed again


PAGE = (Path(__file__).parents[2] / "docs" / "simulation.md").read_text(encoding="utf-8")


def rows():
    """(striker, R, p_0, s, t_c/T, phase, error of b77, error of b77-blow) of every row; empty cells as above them."""
    text = PAGE.partition("### Where B77's law is right")[2].partition("\n- ")[0]
    above, found = [], []
    for line in re.findall(r"^\|(.*)\|$", text, re.MULTILINE)[2:]:
        cells = [cell.strip() or above[i] for i, cell in enumerate(line.split("|"))]
        above = cells
        found.append((cells[0].split()[0], *(float(cell.replace("−", "-")) for cell in cells[1:])))
    return found


ROWS = rows()


def test_the_table_is_there():
    assert len(ROWS) == 20
    assert {row[3] for row in ROWS} == {5.0, 10.0, 20.0, 40.0, 80.0}


@pytest.mark.parametrize("row", [row for row in ROWS if row[3] in (10.0, 20.0, 40.0)], ids=str)
def test_a_row_is_what_the_package_computes(row):
    """The phase to its last digit; the errors of the laws, of first and of second order in the blow's duration."""
    striker, restitution, mean, s, share, phase, off_b77, off_blow = row
    load = Load.harmonic(mean, 1.0)
    if striker == "uniform":
        system, ratio = System(UniformBar(s), load, Kept(restitution)), (1.0 + restitution) / (1.0 - restitution)
    else:
        system, ratio = bar(s, *DRIFTER, load=load), 4.0
    rod = rod_for(system, ratio)
    blow = effective_blow(system.body, rod)
    law = Timed(blow.restitution, blow.duration, blow.centroid, 1.0 / rod.impedance)
    orbit = timed_states(System(system.body, load, Kept(blow.restitution)), law).orbits[-1]
    assert blow.restitution == pytest.approx(restitution, abs=5e-5)
    assert law.duration / orbit.period == pytest.approx(share, abs=6e-4)
    start = Start.rigid(0.0, orbit.rebound_velocity, orbit.phase)
    motion = settled(system, rod, start, quiet=True, cells=200 if striker == "uniform" else 1600, estimate=False)
    assert motion.phases[0] == pytest.approx(phase, abs=6e-5)
    assert orbit.phase_b77 - motion.phases[0] == pytest.approx(off_b77, abs=5e-4)
    assert abs(orbit.phase - motion.phases[0]) == pytest.approx(off_blow, abs=max(2e-5, 0.2 * off_blow))
