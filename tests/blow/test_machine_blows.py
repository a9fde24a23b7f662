"""Single blows on the lattice: closed forms and known answers of contacts, impulses and durations."""

import math

import numpy as np
import pytest

from machine_cases import DRIFTER, S, bar, contacts_of_blow, one_blow, rod_for
from percuss.blow import Rod, Wall


@pytest.mark.parametrize("gap", [0.0, 0.0123, 0.3])
def test_a_uniform_striker_on_a_wall_is_st_venants(gap):
    """Contact 2τ, N = Z v, R = 1, no ringing."""
    impacts = one_blow(bar(S), Wall(), 50, gap)
    assert impacts.size == 1
    assert impacts.start[0] == pytest.approx(gap, abs=1e-12)
    assert impacts.duration[0] * S == pytest.approx(2.0, abs=1e-9)
    assert impacts.peak_force[0] == pytest.approx(S, abs=1e-9)
    assert impacts.restitution[0] == pytest.approx(1.0, abs=1e-12)
    assert (impacts.centroid[0] - gap) * S == pytest.approx(1.0, abs=1e-9)
    assert impacts.ringing_share[0] < 1e-12
    assert impacts.given[0] == 0.0


@pytest.mark.parametrize("restitution", [0.0, 0.3, 0.6, 0.9])
def test_a_uniform_striker_on_a_thicker_rod_has_b77s_restitution(restitution):
    """Contact 2τ, R_eff = −μ exactly, no ringing; delivered: (1 − R²) of the energy."""
    system = bar(S)
    impacts = one_blow(system, rod_for(system, (1.0 + restitution) / (1.0 - restitution)), 50)
    assert impacts.size == 1
    assert -impacts.mean_after[0] == pytest.approx(restitution, abs=1e-12)
    assert impacts.duration[0] * S == pytest.approx(2.0, abs=1e-9)
    assert impacts.ringing_share[0] < 1e-12
    assert impacts.given[0] == pytest.approx(0.5 * (1.0 - restitution**2), abs=1e-12)


def test_a_thick_striker_gives_a_thin_rod_the_staircase():
    """N_k = v [Z Z₂/(Z + Z₂)] μ^k: after five ways there and back the speed is μ⁵."""
    system = bar(S)
    contacts = contacts_of_blow(system, rod_for(system, 0.5), 60, gap=0.0)
    assert contacts.size == 1
    left = 1.0 - contacts["impulse"][0]
    mu = (1.0 - 0.5) / (1.0 + 0.5)
    assert left == pytest.approx(mu**5, abs=1e-12)


@pytest.mark.parametrize("rho", [-0.45, -0.2, 0.1, 0.3])
def test_two_sections_of_equal_transit_time_on_a_wall(rho):
    """Contact 4τ with N = Z₂v, then Z₂v(1 + 2ρ); R = 1 − 2ρ², ringing 4ρ²(1 − ρ²) of the energy."""
    rear, head = 1.0 + rho, 1.0 - rho
    system = bar(S, (rear, head), (1.0, 1.0))
    impacts = one_blow(system, Wall(), 64)
    z = float(system.body.sections.impedance[-1])
    assert impacts.size == 1
    assert impacts.restitution[0] == pytest.approx(1.0 - 2.0 * rho**2, abs=1e-6)
    assert impacts.duration[0] * S == pytest.approx(2.0, abs=1e-9)
    assert impacts.peak_force[0] == pytest.approx(z * max(1.0, 1.0 + 2.0 * rho), rel=1e-6)
    assert impacts.ringing_share[0] == pytest.approx(4.0 * rho**2 * (1.0 - rho**2), abs=1e-6)


def test_a_heavy_head_strikes_a_wall_twice():
    """1 : 1 : 4 of lengths 2 : 1 : 1 (event-driven waves in rational arithmetic): R from two contacts."""
    contacts = contacts_of_blow(bar(S, (1.0, 1.0, 4.0), (2.0, 1.0, 1.0)), Wall(), 80)
    whole = contacts["impulse"].sum()
    assert contacts.size == 2
    assert whole - 1.0 == pytest.approx(0.773714, abs=2e-6)
    assert contacts["impulse"][0] / whole == pytest.approx(0.64, abs=5e-3)


def test_the_drifter_piston_on_a_wall():
    """Three sections of incommensurable lengths (event-driven waves in rational arithmetic): two contacts."""
    areas, lengths = (0.0012566, 0.0019635, 0.0009503), (0.0731, 0.2187, 0.1493)
    system = bar(S, areas, lengths)
    contacts = contacts_of_blow(system, Wall(), 400)
    transit = sum(lengths) * math.sqrt(7850.0 / 206e9)
    ends = np.array([1.722139276135286e-4, 2.1691711248230118e-4, 2.2929322078309985e-4]) / transit
    assert contacts.size == 2
    assert contacts["impulse"].sum() - 1.0 == pytest.approx(0.8691769300136966, abs=1e-4)
    assert contacts["end"][0] - 0.0123 / S == pytest.approx(ends[0] / S, abs=1e-3)
    assert contacts["start"][1] - 0.0123 / S == pytest.approx(ends[1] / S, abs=1e-3)
    assert contacts["end"][1] - 0.0123 / S == pytest.approx(ends[2] / S, abs=1e-3)


def test_four_contacts_of_a_thick_head_on_a_rod():
    """Sections 15 : 5 : 10, impedances 1 : 2 : 4, rod 2 (event-driven waves in rational arithmetic)."""
    system = bar(S, (1.0, 2.0, 4.0), (15.0, 5.0, 10.0))
    contacts = contacts_of_blow(system, rod_for(system, 0.5), 300)
    impulses = np.array([47.64476959813037, 0.940095576617787, 3.5698356826720787, 0.053637671634381615]) / 52.0
    assert contacts.size == 4
    assert contacts["impulse"] == pytest.approx(impulses, abs=2e-6)


def test_the_drifter_piston_on_its_rod():
    """R_eff, duration and force centroid of the blow from rest, to the rounding of the transit times."""
    system = bar(S, *DRIFTER)
    impacts = one_blow(system, rod_for(system, 4.0), 800)
    assert impacts.restitution[0] == pytest.approx(0.41528390670042886, abs=2e-5)
    assert impacts.duration[0] * S == pytest.approx(40.0 * 0.066923600090682378, abs=2e-4)
    assert (impacts.centroid[0] - impacts.start[0]) * S == pytest.approx(40.0 * 0.02807555306396961, abs=2e-4)


def test_an_impulse_is_off_by_the_square_of_the_cell():
    """Contact starts anywhere in a cell; equal transit times of all sections, so that nothing is rounded."""
    system = bar(S, (1.0, 1.0, 4.0), (2.0, 1.0, 1.0))
    errors = []
    for cells in (40, 80, 160):
        gaps = 0.1 + 0.013 * np.arange(12)
        found = [contacts_of_blow(system, Wall(), cells, gap)["impulse"].sum() for gap in gaps]
        errors.append(np.abs(np.array(found) - 1.773714).max())
    assert errors[2] < 3e-5, errors


@pytest.mark.parametrize("ratio", [0.7, 2.0])
def test_a_section_of_the_rods_own_impedance_changes_nothing(ratio):
    from percuss.model import System
    from percuss.model.body import Section, SectionedBar

    piston = SectionedBar([Section(0.2, area=1e-3), Section(0.3, area=2e-3)])
    load = bar(S).load.scaled(1.0, frequency=30.0)
    system = System.from_si(piston, load, bar(S).contact)
    area = 2e-3 * ratio
    plain = contacts_of_blow(system, Rod([Section(None, area=area)]), 100, gap=0.01)
    longer = contacts_of_blow(system, Rod([Section(0.25, area=area), Section(None, area=area)]), 100, gap=0.01)
    assert longer["impulse"].sum() == pytest.approx(plain["impulse"].sum(), abs=1e-4)
    fixed = contacts_of_blow(system, Rod([Section(0.25, area=area)], "fixed"), 100, gap=0.01)
    assert fixed["impulse"].sum() > plain["impulse"].sum()
