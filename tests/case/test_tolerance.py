"""Tolerances: spreads and indices against plain sampling of closed forms, figures against each hammer's own answer."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import binomtest

from percuss.case import (
    Case,
    Span,
    load_case,
    machine_answer,
    parsed_tolerance,
    standard_tolerances,
    steady_answer,
    tolerance,
)
from percuss.case.answers.exploring.tolerance import tolerance_job
from percuss.errors import ParameterError
from percuss.plot import tolerance as picture

RIGID = """
[bar]
length = "1 m"
diameter = "120 mm"
damping = {kind = "external", value = 0.0}
[contact]
restitution = 0.2
[load]
kind = "valve"
states = {return = "-8 kN", power = "20 kN"}
ports = [{behind = "130 mm", side = "back", to = "power"}, {on = "impact", to = "return"}]
"""
KEYS = (
    "load.ports[0].behind=±20mm",
    "load.states.power=±3kN",
    "load.states.return=±3kN",
    "contact.restitution=0.1..0.3",
)
PUMP = {"load.supply": {"flow": "133 l/min", "accumulator": "2.5 cm^3/bar"}}


def closed_form(places: np.ndarray) -> np.ndarray:
    """Blow energy of a rigid piston without delay and drag: m v²/2 = (P − R) x/(1 − r²), by forces and place."""
    x, power, back, r = 0.11 + 0.04 * places[:, 0], 17e3 + 6e3 * places[:, 1], -11e3 + 6e3 * places[:, 2], places[:, 3]
    return (power - back) * x / (1.0 - (0.1 + 0.2 * r) ** 2)


def test_spreads_and_indices_are_those_of_the_closed_form():
    case = Case.from_text(RIGID)
    found = tolerance(case, [parsed_tolerance(words, case) for words in KEYS], ["blow_energy"], samples=3072, modes=0)
    (spread,) = found.spreads
    rng = np.random.default_rng(1)
    a, b = rng.random((2, 100_000, 4))
    plain = closed_form(a)
    assert (spread.low, spread.median, spread.high) == pytest.approx(np.quantile(plain, [0.05, 0.5, 0.95]), rel=8e-3)
    corners = closed_form(np.array([[0.0, 0.0, 1.0, 0.0], [1.0, 1.0, 0.0, 1.0]]))
    assert spread.corners == pytest.approx(corners, rel=1e-9) and spread.at == ("−−+−", "++−+")
    for i in range(4):
        mixed = a.copy()
        mixed[:, i] = b[:, i]
        alone = np.mean((closed_form(b) - plain.mean()) * (closed_form(mixed) - plain)) / plain.var()
        in_all = 0.5 * np.mean((plain - closed_form(mixed)) ** 2) / plain.var()
        assert spread.total[i] == pytest.approx(in_all, abs=0.02) and spread.first[i] == pytest.approx(alone, abs=0.04)
    assert found.running[0] == 1.0 and found.ranked[0][0].name == "load.ports[0].behind"
    drawn = len(found.drawn["runs"])
    assert found.running[1] == pytest.approx(binomtest(drawn, drawn).proportion_ci().low)


@pytest.mark.parametrize(
    ("name", "values", "keys"),
    [
        ("stepped-drifter", {}, ("load.frequency=±1Hz", "bar.sections[0].length=±2mm")),
        ("valve-drifter", {}, ("load.pressure=±10bar", "tool.sections[0].diameter=±1mm")),
        ("valve-breaker", PUMP, ("load.supply.flow=±5 l/min", "load.chamber.force=±5%")),
    ],
)
def test_every_hammer_drawn_has_the_figures_of_its_own_answer(name, values, keys):
    case = load_case(name).varied(values)
    ranges = [parsed_tolerance(words, case) for words in keys]
    found = tolerance(case, ranges, samples=64, modes=4, workers=1)
    again = tolerance(case, ranges, samples=64, modes=4, workers=2)
    for column, values in found.columns.items():
        assert np.array_equal(values, again.columns[column], equal_nan=True), column
    for row in (0, 2, 9, 40):
        made = found.job.values(found.job.unit_places[row])
        varied = case.varied({one.name: f"{made[one.name]!r} {one.unit}".strip() for one in ranges if one.name in made})
        answer = machine_answer(varied, 4) if case.is_machine else steady_answer(varied, modes=4)
        assert found.columns["runs"][row] == answer.whole.runs
        for figure in found.job.figures if answer.whole.runs else ():
            own = answer.whole.value(figure)
            expected = np.nan if own is None else own
            assert found.columns[figure][row] == pytest.approx(expected, rel=1e-8, nan_ok=True), figure


def test_hammers_that_do_not_run_are_counted_and_the_ranking_is_then_refused():
    """A force of the return above r² P, here 0.8 kN, lets no rebound reach the port: a fifth of the range."""
    case = Case.from_text(RIGID)
    found = tolerance(case, [parsed_tolerance("load.states.return=-12..4kN", case)], samples=768, modes=0)
    assert found.running[0] == pytest.approx(0.8, abs=0.01) and found.running[1] < 0.8 < found.running[2]
    assert found.ranked == () and "too many do not run" in found.summary
    assert found.report().tone == "bad"
    assert len(picture(found).axes) > 2


def test_standard_tolerances_and_what_is_written():
    case = load_case("valve-breaker")
    told = {one.name: (one.low, one.high, one.unit) for one in standard_tolerances(case)}
    assert told["load.ports[0].behind"] == (129.8, 130.2, "mm") and told["load.pressure"] == (144.0, 176.0, "bar")
    assert told["load.states.power.rear"] == (15.2, 16.8, "cm^2")
    assert told["contact.restitution"][:2] == pytest.approx((0.05, 0.25))
    assert parsed_tolerance("ports[0].behind=+-1cm", case) == Span("load.ports[0].behind", 120.0, 140.0, "mm")


@pytest.mark.parametrize(
    ("words", "says"),
    [
        ("load.presure=±1bar", "load.pressure"),
        ("load.pressure=±1mm", "unit of pressure"),
        ("load.pressure=±-1bar", "half width greater than 0"),
        ("load.pressure=5bar", "±HALF"),
        ("contact.restitution=0.3..0.1", "contact.restitution"),
        ("contact.restitution=0.5..1.5", "from 0 to 1"),
    ],
)
def test_what_is_mistyped_of_a_tolerance(words, says):
    case = load_case("valve-breaker")
    with pytest.raises(ParameterError, match=says):
        tolerance_job(case, [parsed_tolerance(words, case)], samples=64, modes=0)


@pytest.mark.slow
def test_what_the_command_draws_has_the_intervals_of_many_more():
    case = load_case("valve-breaker")
    few, many = (tolerance(case, samples=samples, modes=0) for samples in (4096, 100_000))
    for one, other in zip(few.spreads, many.spreads, strict=True):
        size = other.high - other.low
        assert (one.low, one.median, one.high) == pytest.approx((other.low, other.median, other.high), abs=0.03 * size)
        assert one.total == pytest.approx(other.total, abs=0.06)
