"""Stepped bars in SI: their figures, their sizes and what they refuse."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest

from percuss import steady_states
from percuss.errors import ParameterError
from percuss.model import Bar, Kept, Load, Ratio, Section, SectionedBar, SteppedBar, System
from percuss.model.described import describe_system, system_from
from percuss.plot.canvas import stress_of

FIGURES = json.loads((Path(__file__).parents[1] / "data" / "blow.json").read_text(encoding="utf-8"))
MODES = next(case for case in FIGURES if case["kind"] == "modes")
PISTON = SectionedBar([Section(0.12, diameter=0.052), Section(0.25, diameter=0.04, bore=0.01)], Ratio(1e-3))
LOAD = Load.fourier([900.0, 1000.0], frequency=60.0)


def test_modes_of_three_sections_and_two_materials() -> None:
    bar = SectionedBar(
        [Section(length, area, youngs_modulus=e, density=rho) for length, area, e, rho in MODES["sections"]]
    )
    wanted = {key: np.array(value, dtype=float) for key, value in MODES["expect"].items()}
    assert bar.mass == pytest.approx(wanted["mass"], rel=1e-14)
    assert bar.transit_time == pytest.approx(wanted["transit_time"], rel=1e-14)
    assert 2.0 * np.pi * bar.natural_frequencies(12) == pytest.approx(wanted["angular_frequency"], rel=1e-12)
    body = bar.body(100.0)
    end = body.modes(12).end
    driven = body.shapes(np.array([0.0]), 12).displacement[0]
    sign = np.sign(driven)  # the reference has the driven end positive
    assert sign * driven * end == pytest.approx(wanted["phi_driven_end"], rel=1e-12)
    assert sign * end == pytest.approx(wanted["phi_striking_end"], rel=1e-12)


def test_equal_sections_are_the_uniform_bar() -> None:
    bar, parts = Bar(0.4, 1e-3), SectionedBar([Section(0.1, 1e-3), Section(0.3, 1e-3)])
    for name in ("length", "mass", "transit_time", "wave_speed", "impedance", "contact_duration"):
        assert getattr(parts, name) == pytest.approx(getattr(bar, name), rel=1e-14)
    assert parts.natural_frequencies(5) == pytest.approx(bar.natural_frequencies(5), rel=1e-13)
    one, other = (System.from_si(own, LOAD, Kept(0.5)) for own in (bar, parts))
    assert other.load.coefficients == pytest.approx(one.load.coefficients, rel=1e-13)
    assert other.force_scale == pytest.approx(one.force_scale, rel=1e-13)


def test_a_section_with_a_bore_is_a_tube() -> None:
    hollow, plain = PISTON.pieces[1], PISTON.pieces[0]
    assert hollow.area == pytest.approx(math.pi / 4.0 * (0.04**2 - 0.01**2), rel=1e-14)
    assert (hollow.diameter, hollow.bore, plain.bore) == (0.04, 0.01, 0.0)
    by_area = SectionedBar([Section(0.1, area=2e-3, bore=0.01)]).pieces[0]
    assert math.pi / 4.0 * (by_area.diameter**2 - 0.01**2) == pytest.approx(2e-3, rel=1e-14)


def test_steps_lie_where_the_sections_meet() -> None:
    body = PISTON.body(377.0)
    assert body.places == (0.0, pytest.approx(0.12 / 0.37, rel=1e-15))
    soft = SectionedBar([Section(0.1, 1e-3, youngs_modulus=70e9), Section(0.2, 1e-3)])
    at = np.array([0.0, *soft.body(1.0).places[1:], 1.0])
    assert soft.youngs_modulus_at(at).tolist() == [70e9, 210e9, 210e9]


def test_the_stress_is_that_of_the_material_at_each_place() -> None:
    parts = [Section(0.1, 1e-3, youngs_modulus=70e9, density=2700.0), Section(0.2, 1e-3)]
    system = System.from_si(SectionedBar(parts, Ratio(0.05)), LOAD, Kept(0.6))
    orbit = steady_states(system).orbits[0]
    step, t = system.body.place(1), np.array([1.0, 3.0])
    at = np.array([step - 1e-9, step + 1e-9])
    strain = orbit.strain(at, t)
    before, after = system.stress(at, strain)
    assert np.abs(strain[0] / strain[1]) == pytest.approx(3.0, rel=1e-2)
    assert before == pytest.approx(after, rel=1e-2)  # equal areas: the same force, the same stress
    assert system.stress(at, strain[:, 0]) == pytest.approx([before[0], after[0]])
    assert stress_of(system, at, strain)[0] == pytest.approx(before / 1e6)
    plain = System(s=5.0, d=0.0, restitution=0.3, load=Load.harmonic(0.5, 1.0))
    assert stress_of(plain, at, strain) is strain
    with pytest.raises(ParameterError, match="from_si"):
        plain.stress(at, strain)
    with pytest.raises(ParameterError, match="a row for each of 3"):
        system.stress([0.0, 0.5, 1.0], strain)


def test_a_system_of_it_goes_through_json() -> None:
    system = System.from_si(PISTON, LOAD.acting_at(1), Kept(0.3))
    again = system_from(json.loads(json.dumps(describe_system(system))))
    assert again.body == system.body and again.bar == PISTON and again.load.at == 1
    assert isinstance(again.body, SteppedBar) and again.frequency == 60.0


def test_areas_that_jump_by_nearly_a_million() -> None:
    bar = SectionedBar([Section(0.2, 1.1e-6), Section(0.2, 1.0), Section(0.2, 1.1e-6)])
    assert np.all(np.diff(bar.natural_frequencies(20)) > 0.0)
    assert bar.body(1.0).modes(20).inertia.min() > 0.0
