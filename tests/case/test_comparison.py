"""Hammers side by side: the differences of their cases, and of their figures, which are those of each by itself."""

from __future__ import annotations

import pytest

from percuss.case import compare, load_case, machine_answer, steady_answer
from percuss.errors import ParameterError
from percuss.plot import comparison
from percuss.plot.reports.html_report import report_html

FASTER = {"load.pressure": "180 bar", "load.ports[0].behind": "120 mm"}


def test_hammers_of_different_kinds_have_the_figures_of_their_own_answers():
    breaker, clocked = load_case("valve-breaker"), load_case("heavy-breaker")
    found = compare([breaker, clocked, breaker.varied(FASTER)], modes=4)
    rows = {row.name: row for row in found.figures}
    told = [machine_answer(one, 4).si for one in (breaker, breaker.varied(FASTER))]
    si = steady_answer(clocked, modes=4).chosen.si
    for name, key, factor in (
        ("blow_energy", "blow_energy_J", 1.0), ("blow_rate", "blow_rate_Hz", 1.0), ("stroke", "stroke_m", 1.0),
        ("impact_velocity", "impact_velocity_m_s", 1.0), ("input_power", "input_power_kW", 1e3),
        ("flow", "oil_flow_l_per_min", 1 / 6e4), ("contact_time", "contact_time_us", 1e-6),
    ):  # fmt: skip
        own, other = (factor * one[key] for one in told)
        row = rows[name]
        assert (row.values[0], row.values[2]) == pytest.approx((own, other), rel=1e-12), name
        assert row.changes[0] == 0.0 and row.changes[2] == pytest.approx(other / own - 1.0, rel=1e-9), name
    assert rows["blow_energy"].values[1] == si.blow_energy_J and rows["flow"].values[1] is None
    assert rows["stress"].values[1] == pytest.approx(1e6 * si.peak_stress_MPa)
    assert rows["margin"].values[0] == pytest.approx(
        1.0 - max(abs(machine_answer(breaker, 4).cycle.multipliers().values))
    )
    assert ("load.pressure", ("160 bar", "", "180 bar")) in found.differences
    assert found.summary.startswith("B against A: blow energy +5") and "C against A" in found.summary


def test_a_hammer_that_cannot_run_is_said():
    drifter = load_case("stepped-drifter")
    found = compare([drifter, drifter.varied({"contact.restitution": 0.25})], names=("old", "new"))
    assert found.runs == (True, False) and found.summary.endswith("B cannot sustain its motion.")
    assert [key for key, _ in found.differences] == ["contact.restitution"]
    before, after = found.blows  # each at the speed of its own motion, not at that of [blow]
    assert after.blow.energy_before / before.blow.energy_before == pytest.approx(0.8464, abs=1e-3)
    own = steady_answer(drifter).transfer
    rows = {row.name: row.values[0] for row in found.figures}
    assert rows["rock_power"] == own.rock_power and rows["steel.stress"] == own.peaks[1].stress
    assert len(comparison(found).axes) == 5
    page = report_html(drifter, found)
    assert page.count("<pre>") == 2 and found.summary.split(",")[0] in page


def test_structures_and_dimensionless_hammers():
    beam = load_case("stopped-beam")
    found = compare([beam, beam.varied({"contact.restitution": 0.5})])
    assert {"blow_energy", "impact_velocity", "stroke"} < {row.name for row in found.figures}
    assert "stress" not in {row.name for row in found.figures}
    plain = load_case("stopped-oscillator")
    assert all(row.unit == "" for row in compare([plain, plain]).figures)
    assert compare([plain, plain]).summary == "B against A: the same case as A."
    for cases, what in (((beam,), "2 to 8 cases"), ((beam, plain), "all in SI, or all dimensionless")):
        with pytest.raises(ParameterError, match=what):
            compare(cases)
