"""The audit of B77's claims: every verdict can come out either way, and a small audit is whole."""

import json
import math
from dataclasses import replace

import pytest

from percuss.errors import Interrupted, ParameterError, PercussError
from percuss.paper import claims
from percuss.paper.claim_common import (
    HOLDS,
    NOT,
    PARTLY,
    Size,
    Trial,
    lower_curve,
    percent,
    pneumatic,
    tried,
    upper_curve,
)
from percuss.paper.claim_hydraulic import Scatter, verdict_d
from percuss.paper.claim_pneumatic import (
    Allowed,
    Smallest,
    StartsEnd,
    StartsReach,
    allowed,
    ends_of,
    starts_each,
    verdict_a,
    verdict_b,
    verdict_c,
)
from percuss.paper.claim_stability import Motions, Stiffness, verdict_e, verdict_f
from percuss.paper.claims import report
from percuss.stability import stability_of
from percuss.steady import steady_states

SMALL = Size(starts=400, impacts=300)


@pytest.fixture(scope="module")
def small(tmp_path_factory):
    folder = tmp_path_factory.mktemp("audit") / "new" / "folder"
    seen = []
    found = claims.run(folder, seed=2, progress=lambda p: seen.append((p.part, p.done, p.steps)), size=SMALL)
    return found, folder, seen


# -- rules ----------------------------------------------------------------------------------------------------------


def test_tried():
    assert tried([("here", 3, 3), ("there", 2, 2)]).verdict == HOLDS
    assert tried([("here", 3, 0), ("there", 2, 0)]).verdict == NOT
    partly = tried([("here", 3, 3), ("there", 2, 1), ("nowhere", 0, 0)])
    assert partly.verdict == PARTLY and partly.where == "here: at 3 of 3 points; there: at 1 of 2 points"
    assert tried([]).verdict == NOT


def end(load_factor=0.9, one=60, rest=40, cycles=0, starts=100, stable=True, name="wall"):
    return StartsEnd(0.6, load_factor, stable, name, starts, one, rest, cycles, 0, {})


def test_rule_a():
    assert verdict_a([end(), end(1.1)]).verdict == HOLDS
    assert verdict_a([end(), end(1.1, one=59)]).verdict == PARTLY
    assert "p_0 < p_1: at 1 of 1" in verdict_a([end(), end(1.1, one=59)]).where
    assert verdict_a([end(one=59), end(1.1, one=0)]).verdict == NOT
    # one distribution is enough to spoil a point
    assert verdict_a([end(), end(name="field", rest=39)]).verdict == NOT
    # the other reading of the word
    cycles = [end(one=50, rest=0, cycles=50), end(0.5, one=0, rest=0, cycles=99, stable=False)]
    assert verdict_a(cycles).verdict == NOT and verdict_a(cycles, cycles_are_rest=True).verdict == PARTLY


def test_rule_b():
    good = StartsReach(0.8, 1.0, Allowed(1, 2.0, -1.0, True, True, True), 20, 20)
    lost = replace(good, reached=0)
    saddle = StartsReach(0.8, 1.0, Allowed(2, 2.0, -1.0, False, True, False), 20, 0)
    assert verdict_b([good, good]).verdict == HOLDS
    assert verdict_b([good, saddle]).verdict == PARTLY
    assert "stable and admissible: at 1 of 1" in verdict_b([good, saddle]).where
    assert verdict_b([lost, saddle]).verdict == NOT


def test_rule_c():
    def found(smallest, name="wall", ones=1000, starts=1000):
        return Smallest(0.8, 1.0, 1, name, starts, ones, smallest)

    assert verdict_c([found(1000), found(999, "field")]).verdict == HOLDS
    assert verdict_c([found(1000), found(980, "field")]).verdict == PARTLY
    assert "`wall`: at 1 of 1" in verdict_c([found(1000), found(980, "field")]).where
    assert verdict_c([found(600), found(0, "gentle")]).verdict == NOT
    assert verdict_c([found(50, starts=50)]).verdict == NOT  # too few to tell: the interval reaches below 99 %
    assert verdict_c([found(500, ones=500)], among_one_impact=True).verdict == HOLDS
    assert verdict_c([found(500, ones=500)]).verdict == NOT


def test_rule_d():
    good = Scatter(0.5, 1.3, "wall", 50, 0, 0, 0, 1.4, 1.0, 0.3, 0.07, 0.02, 0.07, "aperiodic")
    both = [good, replace(good, distribution="field", main_scatter=0.072)]
    assert verdict_d(both).verdict == HOLDS
    elsewhere = [replace(item, kappa=1.5) for item in both]
    for spoiled in ({"periodic": 1}, {"main_scatter": 0.2}, {"main_scatter": 0.01}, {"main_rate": 1.2}):
        bad = [replace(elsewhere[0], **spoiled), elsewhere[1]]
        assert verdict_d(both + bad).verdict == PARTLY, spoiled
        assert verdict_d(bad).verdict == NOT, spoiled
    # within the bounds, but not the same for two distributions
    assert verdict_d([good, replace(good, distribution="field", main_scatter=0.09)]).verdict == NOT
    assert verdict_d([replace(good, main_scatter=math.nan)]).verdict == NOT
    assert verdict_d([]).verdict == NOT


def test_rule_e():
    good = Motions(10, 10, 5, 5, 20, 20, 30, 0, 0, 40, 0)
    assert verdict_e(good).verdict == HOLDS
    spoiled = {
        "range_open": 9,
        "exact_stable": 4,
        "returned": 19,
        "hydraulic_stable": 1,
        "hydraulic_waveform": 1,
        "hydraulic_settled": 1,
    }
    for name, value in spoiled.items():
        found = verdict_e(replace(good, **{name: value}))
        assert found.verdict == PARTLY and "what fails" in found.where, name
    assert verdict_e(replace(good, **spoiled)).verdict == NOT


def test_rule_f():
    good = Stiffness(20.0, 0.0, 1e-4, 9, 9, 0.99, 50, 0.01, 0.05)
    soft = replace(good, s=1.0, threshold=0.5, agree=0, largest_shift=1.0)
    assert verdict_f([good, soft]).verdict == HOLDS  # only stiff bars count
    for spoiled in ({"threshold": 0.02}, {"agree": 8}, {"largest_shift": 0.06}):
        assert verdict_f([good, replace(good, s=5.0, **spoiled)]).verdict == PARTLY, spoiled
    bad = replace(good, threshold=0.02, agree=8, largest_shift=0.06)
    assert verdict_f([bad]).verdict == NOT and verdict_f([soft]).verdict == NOT
    assert "s = 5 undamped" in verdict_f([good, replace(good, s=5.0, agree=8)]).where


# -- what the rules are fed with -------------------------------------------------------------------------------------


@pytest.mark.parametrize(("r", "m"), [(0.2, 1), (0.8, 1), (0.8, 2), (0.9, 5)])
def test_the_curves_are_where_stability_begins_and_existence_ends(r, m):
    low, high = lower_curve(r, m), upper_curve(r, m)
    assert not steady_states(pneumatic(r, 1.000001 * high), m, modes=0).exists
    for x, stable in ((0.999 * high, True), (1.001 * low, True), (0.999 * low, False)):
        orbits = steady_states(pneumatic(r, x), m, modes=0).orbits
        assert any(stability_of(orbit, modes=0).stable for orbit in orbits) == stable


def test_allowed():
    found = allowed(0.8, 1.0)
    assert [motion.periods for motion in found if motion.stable and motion.admissible] == [1, 2]
    assert all(motion.in_range == motion.stable for motion in found)
    assert allowed(0.3, 0.9) == []


def test_percent():
    assert percent(0, 0) == "–" and percent(10, 10).startswith("100 % [72.2")


# -- a small audit ----------------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_a_small_audit_is_whole(small):
    found, folder, seen = small
    assert [claim.letter for claim in found.claims] == list("abcdef")
    assert {part for part, _, _ in seen} == {*"abcdef", "beyond"}
    assert all(0 <= done < steps for _, done, steps in seen)
    assert sorted(path.name for path in folder.iterdir()) == ["REPORT.md", "claims.json"]
    tree = json.loads((folder / "claims.json").read_text(encoding="utf-8"))
    assert tree["seed"] == 2 and tree["starts_per_claim"] == 400 and list(tree["claims"]) == list("abcdef")
    for claim in tree["claims"].values():
        assert claim["verdict"] in (HOLDS, PARTLY, NOT)
        assert claim["where"] and claim["rule"] and claim["done"] and claim["claim"] and claim["starts"] > 0
        assert claim["tables"] and all(table["rows"] for table in claim["tables"])
    assert [part["title"] for part in tree["beyond"]] == [
        "Chatter and rest",
        "Period doubling",
        "Coexisting motions",
        "The hydraulic hammer that rests",
        "The end of the range at R = 0",
    ]


@pytest.mark.slow
def test_what_theory_says_whatever_the_size(small):
    """What follows from closed forms, and attractors that all starts reach, does not need many starts."""
    found = {claim.letter: claim for claim in small[0].claims}
    assert found["e"].verdict.verdict == HOLDS
    assert found["e"].numbers["hydraulic_stable"] == 0 and found["e"].numbers["range_open"] == 10_000
    assert found["b"].numbers["of these reached"] == found["b"].numbers["stable and admissible"] > 20
    assert found["d"].numbers["starts in a one-impact motion"] == 0
    dead = small[0].findings[-1].table.records()
    assert all(row["in rest/1" if row["p(φ)/p_0"] > 0.0 else "in z=1/1"].startswith("100 %") for row in dead)
    rests = next(part for part in small[0].findings if "rests" in part.title).table.records()
    assert all(row["in rest/1"].startswith("100 %") for row in rests if row["κ"] >= 1.5)


def test_the_same_seed_gives_the_same_numbers():
    trial = Trial(Size(starts=200, impacts=100), 3)
    assert ends_of(trial) == ends_of(trial)
    draws = [t.of(pneumatic(0.6, 0.9), 20, "wall").columns["time"].tolist() for t in (trial, replace(trial, seed=4))]
    assert draws[0] != draws[1]


@pytest.mark.slow
def test_all_rows_share_their_starts_and_the_report_says_so(small):
    """At other points of the plane the same starts, those of `wall` in units of 2πp_0/(1 + R)."""
    trial = Trial(Size(starts=200, impacts=5), 3)
    for name in ("wall", "field", "gentle"):
        one, other = (trial.of(pneumatic(r, x), 20, name) for r, x in ((0.6, 0.9), (0.2, 0.4)))
        assert one.columns["time"].tolist() == other.columns["time"].tolist()
        unit = 1.0 if name != "wall" else (0.9 / 1.6) / (0.4 / 1.2)
        assert one.columns["velocity"] == pytest.approx(unit * other.columns["velocity"], rel=1e-12)
    assert starts_each(claims.DEFAULT) == 476
    assert "all rows of a table have the same ones" in report(small[0])
    assert f"({starts_each(small[0].size)} of each" in " ".join(report(small[0]).split())


def test_an_audit_that_is_no_longer_wanted_writes_nothing(tmp_path):
    with pytest.raises(Interrupted):
        claims.run(tmp_path, size=SMALL, progress=lambda p: p.part == "a" and p.done > 3)
    assert not list(tmp_path.iterdir())


def test_bad_targets(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(PercussError, match="folder"):
        claims.run(tmp_path / "file", size=SMALL)
    with pytest.raises(ParameterError, match="seed"):
        claims.run(tmp_path, seed=-1, size=SMALL)
