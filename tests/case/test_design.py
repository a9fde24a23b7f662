"""The best hammer: found again by brute force, limits that bind, what no hammer keeps, the same again."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from scipy.stats.qmc import Sobol, scale

from percuss.case import CaseFamily, Limit, Span, compare, design, load_case
from percuss.errors import ParameterError
from percuss.plot import design_plane
from percuss.plot.reports.html_report import report_html

PUMP = {"load.supply": {"flow": "60 l/min", "accumulator": "2.5 cm^3/bar"}}
HAMMERS = {
    "clock": (
        load_case("stepped-drifter"), "bar.sections[2].diameter=34:48mm", "bar.sections[0].diameter=30:50mm",
        "rock_power", "power=15 kW",  # stresses have ridges, where waves meet
    ),
    "valve": (
        load_case("valve-drifter"), "load.ports[0].behind=8:24mm", "load.pressure=120:200bar",
        "blow_energy", "flow=60 l/min",
    ),
    "pump": (
        load_case("valve-drifter").varied(PUMP), "load.ports[0].behind=8:24mm", "load.states.power.rear=4:8cm^2",
        "power", "pressure=180 bar",
    ),
}  # fmt: skip


@pytest.mark.parametrize(
    "name, modes, across",
    [("valve", 0, 21), *(pytest.param(*row, marks=pytest.mark.slow) for row in
        (("valve", 4, 46), ("clock", None, 21), ("pump", 2, 46)))],
)  # fmt: skip
def test_brute_force_finds_no_better_hammer(name, modes, across):
    """Nor one that is as good far from it; what binds does so to 1e-6."""
    case, *words, figure, limit = HAMMERS[name]
    spans, limit = [Span.parsed(one) for one in words], Limit.parsed(limit, "below", True)
    found = design(case, spans, figure, [limit], modes=modes, most=300)
    assert found.allowed and found.binding == (limit.figure,) and f"at its limits: {limit.figure}" in found.summary
    assert found.best.value(limit.figure) == pytest.approx(limit.high, rel=1e-6)

    family, near, grid = CaseFamily(case, {span.name: span.unit for span in spans}), None, []
    for x in itertools.product(*(np.linspace(span.low, span.high, across) for span in spans)):
        values = {span.name: value for span, value in zip(spans, x, strict=True)}
        one = family.whole(values, modes=modes, near=near)
        one = one if one.runs or near is None else family.whole(values, modes=modes)
        near = one if one.runs and modes else None
        if one.runs and one.value(limit.figure) <= limit.high:
            grid.append(one.value(figure))
    assert len(grid) > 0.1 * across**2
    assert max(grid) < found.best.value(figure) == pytest.approx(max(grid), rel=1.5 / across)


@pytest.mark.slow
def test_brute_force_over_five_numbers_finds_no_better_hammer():
    """3584 hammers, in boxes that shrink about the best of them: on a pump, with 3 m of steel, under four limits."""
    case = HAMMERS["pump"][0]
    words = (
        "load.ports[0].behind=15:30mm load.ports[1].behind=2:8mm load.supply.flow=40:80l/min bar.diameter=44:54mm "
        "load.states.power.rear=5:8cm^2"
    )
    spans = [Span.parsed(one) for one in words.split()]
    limits = [
        Limit.parsed("blow_rate=45..60Hz", "want", True), Limit.parsed("steel.stress=430MPa", "below", True),
        Limit.parsed("pressure=200bar", "below", True), Limit.parsed("margin=0.05", "above", True),
    ]  # fmt: skip
    found = design(case, spans, "rock_power", limits, modes=4)

    family, best, near = CaseFamily(case, {span.name: span.unit for span in spans}), (0.0, np.zeros(5)), None
    ends = np.array([(span.low, span.high) for span in spans])
    low, high = ends.T
    for seed in range(14):
        for x in scale(Sobol(5, rng=seed).random(256), low, high):
            one = family.whole({span.name: float(v) for span, v in zip(spans, x, strict=True)}, modes=4, near=near)
            near = one if one.runs else near
            kept = one.runs and all(
                (limit.low or 0.0) <= one.value(limit.figure) <= (limit.high or np.inf) for limit in limits
            )
            best = max(best, (one.value("rock_power"), x), key=lambda pair: pair[0]) if kept else best
        half = 0.4 * (high - low)
        low, high = np.maximum(ends[:, 0], best[1] - half), np.minimum(ends[:, 1], best[1] + half)
    assert found.allowed and best[0] < found.best.value("rock_power") < 1.02 * best[0]


def test_a_plane_tells_which_hammers_about_the_best_keep_the_limits_and_what_others_miss():
    case, *words, _, _ = HAMMERS["valve"]
    spans, limits = [Span.parsed(one) for one in words], [Limit("flow", high=1e-3), Limit("blow_energy", low=150.0)]
    found = design(case, spans, "blow_energy", limits, modes=0, most=40)
    plane, family = found.plane(4), CaseFamily(case, {span.name: span.unit for span in spans})
    for i, j in np.ndindex(4, 4):
        one = family.whole({spans[0].name: plane.x[i], spans[1].name: plane.y[j]}, modes=4)
        if not one.runs:
            assert plane.missed[i, j] == 2 and np.isnan(plane.values[i, j])
            continue
        assert plane.values[i, j] == pytest.approx(one.value("blow_energy"), rel=1e-7)
        over = [one.value("flow") / 1e-3 - 1.0, 1.0 - one.value("blow_energy") / 150.0]
        assert plane.missed[i, j] == (int(np.argmax(over)) if max(over) > 0.0 else -1)
    assert {0, 1, -1} <= set(plane.missed.ravel())
    assert len(design_plane(plane).axes) == 2  # with the bar of its colours


def test_what_no_hammer_keeps_is_told_with_the_nearest_and_the_limit_that_costs_most():
    """Harder blows, or fewer: both rise with the pressure, and one limit wants more of it, the other less."""
    case, span = load_case("valve-drifter"), Span.parsed("load.pressure=100:200bar")
    limits = [Limit("blow_energy", low=420.0), Limit.parsed("blow_rate=30..40 Hz", "want", True)]
    found = design(case, [span], "power", limits, modes=0, most=120)

    def beyond(pressure: float) -> tuple[float, float]:
        one = CaseFamily(case, {"load.pressure": "bar"}).whole({"load.pressure": pressure}, modes=0)
        return max(0.0, 1.0 - one.value("blow_energy") / 420.0), max(0.0, one.value("blow_rate") / 40.0 - 1.0)

    own = beyond(found.values[0])
    assert sum(own) <= min(sum(beyond(p)) for p in np.linspace(100.0, 200.0, 101)) + 1e-6
    assert not found.allowed and list(found.excess.values()) == pytest.approx([x for x in own if x], rel=1e-6)
    worst = max(found.excess, key=found.excess.get)
    assert worst == ("blow_energy", "blow_rate")[int(np.argmax(own))]
    assert f"{worst} costs most" in found.summary and "No hammer found" in found.report().summary


def test_the_answer_is_that_of_both_cases_and_the_same_again():
    case, spans = load_case("valve-drifter"), [Span.parsed("load.ports[0].behind=8:24mm")]
    found, again, other = (design(case, spans, "power", modes=2, most=40, seed=seed) for seed in (5, 5, 6))
    assert found.to_json_dict() == again.to_json_dict() != other.to_json_dict()
    both = compare([case, case.varied({"load.ports[0].behind": f"{found.values[0]!r} mm"})], modes=2)
    told = found.to_json_dict()
    assert told["figures"] == both.to_json_dict()["figures"] and found.own_values == (22.0,)
    assert "<figure>" in report_html(case, found)


def test_what_stands_at_the_end_of_its_range_is_named():
    found = design(load_case("valve-drifter"), [Span.parsed("load.pressure=120:200bar")], modes=0, most=40)
    assert found.ends == {"load.pressure": "upper"} and found.values == (200.0,)
    assert "load.pressure stands at the upper end of its range" in found.summary


def test_what_a_search_is_not_begun_with():
    case, span = load_case("mini-breaker"), Span.parsed("contact.restitution=0.1:0.3")
    with pytest.raises(ParameterError, match="a figure that this hammer has"):
        design(case, [span], "blow_energy", [Limit("flow", high=1e-3)], modes=0)
    with pytest.raises(ParameterError, match="ranges in which a hammer"):
        design(load_case("valve-breaker"), [Span.parsed("load.pressure=1:2bar")], "power", modes=0, most=20)
