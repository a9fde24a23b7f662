"""``percuss orbits`` and ``percuss follow`` as a person would use them, up to where Ctrl-C comes."""

from __future__ import annotations

import math
import re
import signal
from itertools import count
from pathlib import Path

import numpy as np
import pytest

from cli_cases import CASES
from percuss import Load, System
from percuss.case import Case, branch_answer
from percuss.case.answers.exploring.orbits_answer import branch_report, orbit_at_phases
from percuss.cli.long_commands import JobWatch
from percuss.cli.report_printing import show
from percuss.errors import ParameterError
from percuss.explore import follow
from percuss.steady import orbits, rest_cycles
from random_hammers import random_hammer


def types(points):
    return [point["type"] for point in points]


def test_the_orbits_of_a_label(percuss):
    done = percuss("orbits", "hammer.toml", "--label", "2/1", "--tries", "100")
    done.told("2 orbits, 0 elastic modes.", "0.390789, 2.321002", "yes (proved)")
    answers = percuss("orbits", "hammer.toml", "--up-to", "3/1", "--tries", "100", "--json").json
    assert [answer["label"] for answer in answers] == ["z=1/1", "z=2/1", "z=3/1"]
    assert [len(answer["orbits"]) for answer in answers] == [2, 2, 2]
    assert [answer["complete"] for answer in answers] == [True, True, False]
    assert answers[1]["orbits"][1]["impacts"][0]["phase"] == pytest.approx(0.390789, abs=1e-6)
    assert sum(answers[2]["dropped"].values()) + 2 == answers[2]["tries"] == 100


def test_the_orbits_of_a_machine(percuss):
    asked = ("orbits", "valve-breaker", "--modes", "0", "--tries", "20", "--motions", "1")
    percuss(*asked).told("1 orbit, 0 elastic modes.", "0.105838  9.192967           0.0279174     yes")
    one, two = percuss(*asked, "--up-to", "2/1", "--json").json
    assert [one["label"], two["label"], len(one["orbits"]), len(two["orbits"])] == ["1/1", "2/1", 1, 0]
    assert one["orbits"][0]["impacts"][0]["time"] == one["orbits"][0]["period"]
    percuss(*asked, "--switch").told("1 orbit")


def test_the_largest_labels_are_searched(percuss):
    for label in ("64/1", "1/256", "64/256"):
        percuss("orbits", "other.toml", "--label", label, "--tries", "2", "--motions", "2").told("0 orbits")


@pytest.mark.parametrize("n", [1, 2])
def test_full_rebound_without_drag_has_an_answer(percuss, n):
    answer = percuss("orbits", "full.toml", "--label", f"2/{n}", "--json", "--tries", "50").json
    assert not answer["complete"]
    assert all(orbit["admissible"] for orbit in answer["orbits"])


def test_an_orbit_followed(percuss):
    files = ("-o", "branch.csv", "--plot", "branch.svg")
    done = percuss("follow", "hammer.toml", "--orbit", "2/1:2", "--along", "mean=0.6:1.2", *files)
    done.told("flip", "0.659281674533: z=4/2 begins towards smaller mean, stable", "table: branch.csv")
    assert Path("branch.svg").read_text(encoding="utf-8").startswith("<?xml")
    lines = Path("branch.csv").read_text(encoding="utf-8").splitlines()
    assert lines[0] == "branch,label,point,mean,stable,impact,phase,speed"
    assert lines[1].startswith("1,z=2/1,1,0.6,0,1,")


def test_the_answer_as_json_has_every_branch(percuss):
    asked = ("--orbit", "1/1:phases=2.43", "--along", "load_factor=0.585:0.7", "--switch", "2", "--json")
    answer = percuss("follow", "hammer.toml", *asked).json
    assert [row["label"] for row in answer["cascade"]] == ["z=1/1", "z=2/2", "z=4/4"]
    assert [one["label"] for one in answer["switched"]] == ["z=2/2", "z=4/4"]
    assert answer["points"][0]["type"] == "limit"
    flip = next(point for point in answer["points"] if point["type"] == "flip")
    assert flip["value"] == pytest.approx(0.6549544650505745, abs=1e-11)
    assert len({len(answer["branch"][name]) for name in ("value", "phases", "stable")}) == 1


CURVES = {
    "an onset": (
        "chattering.toml --orbit chatter/1 --along load_factor=0.36:0.38 --curve onset --over restitution=0.01:0.5",
        ["onset"],
        "is_orbit,release_phase,event_phase",
        "restitution=0.1:0.3:2 --y load_factor=0.4:0.5:2",
    ),
    "flip and fold": (
        "hammer.toml --orbit 2/1:2 --along load_factor=0.61:0.8 --curve flip,fold:1 --over restitution=0.498:0.502",
        ["flip", "fold"],
        "is_orbit,impact,phase",
        "restitution=0.49:0.51:2 --y load_factor=0.6:0.7:2",
    ),
}


@pytest.mark.parametrize(("asked", "kinds", "columns", "plane"), CURVES.values(), ids=CURVES)
def test_points_followed_and_laid_over_a_map(percuss, asked, kinds, columns, plane):
    done = percuss("follow", *asked.split(), "--plot", "curves.svg", "-o", "curves.csv", "--json")
    found = done.json["curves"]
    assert [one["type"] for one in found] == kinds
    assert found[0]["parameters"] == ["load_factor", "restitution"] and types(found[-1]["points"]) == ["limit"] * 2
    assert len(found[0]["curve"]["values"]) == len(found[0]["curve"]["is_orbit"])
    assert Path("curves.svg").read_text(encoding="utf-8").startswith("<?xml")
    lines = Path("curves.csv").read_text(encoding="utf-8").splitlines()
    assert lines[0] == f"curve,type,label,point,load_factor,restitution,{columns}"
    assert lines[1].startswith(f"1,{kinds[0]},{found[0]['label']},1,")
    Path("curves.json").write_text(done.out, encoding="utf-8")
    case, *over = asked.partition(" ")[0], "--x", *plane.split(), "--quantity", "exists"
    laid = ("--overlay", "curves.json", "--plot", "map.svg")
    assert percuss("sweep", case, *over, *laid).code == 0
    drawn = Path("map.svg").read_text(encoding="utf-8")
    assert drawn.startswith("<?xml") and (drawn.count("stroke-dasharray") > 2 or "flip" not in kinds)
    other = [word.replace("load_factor=", "mean=") for word in over]
    percuss("sweep", case, *other, *laid).refused("curves over restitution and mean")


def test_points_are_followed_without_ranges(percuss):
    asked = ("--orbit", "1/1:2", "--along", "load_factor", "--curve", "flip", "--over", "restitution", "--modes", "0")
    (curve,) = percuss("follow", "pneumatic-jackleg", *asked, "--json").json["curves"]
    first, *_, last = curve["points"]
    assert first["type"] == last["type"] == "parameter_end"
    assert first["values"][1] == pytest.approx(0.0, abs=1e-8) and last["values"][1] == pytest.approx(1.0, abs=1e-8)


def test_without_a_range_a_branch_goes_to_its_ends():
    case = Case.from_text(CASES["hammer"])
    ends = [(point.kind.value, point.value) for point in branch_answer(case, "2/1:2", "mean").points]
    assert ends[0] == ("grazing_impact_dies", pytest.approx(0.3993131887184041, abs=1e-11))
    assert ends[-1] == ("grazing_touch", pytest.approx(0.5279096824923904, abs=1e-11))
    in_si = Case.from_text(CASES["si"].replace("8 kN", "6.2 kN"))
    keyed = branch_answer(in_si, "1/1:2", "load.mean").values  # in kilonewtons, as in the case
    assert keyed.max() == pytest.approx(10.0 * branch_answer(case, "1/1:2", "mean").values.max(), rel=1e-9)


@pytest.mark.parametrize(
    ("line", "ends"),
    [
        ("other.toml --along mean=0.665:0.66500000001", ["limit", "limit"]),
        ("other.toml --along d=-1:0.01", ["limit", "parameter_end"]),
        ("full.toml --along restitution=0.9:2", ["limit", "parameter_end"]),
    ],
)
def test_ranges_that_end_at_once_have_ends_that_are_named(percuss, line, ends):
    points = percuss("follow", *line.split(), "--json").json["points"]
    assert sorted(types([points[0], points[-1]])) == ends


# -- cycles with rest -------------------------------------------------------------------------------------------------


def test_cycles_with_rest_by_their_label(percuss):
    (cycle,) = percuss("orbits", "resting.toml", "--label", "chatter/1", "--json").json["orbits"]
    assert (cycle["label"], cycle["multipliers"], cycle["stable"]) == ("chatter/1", [[0.0, 0.0]], True)
    assert cycle["release_phase"] == pytest.approx(2.4980915447965089, abs=1e-12)
    assert cycle["rest_phase"] == pytest.approx(6.0181578458150141, abs=1e-12)
    assert cycle["impacts"][0]["phase"] == pytest.approx(5.153035058850553, abs=1e-12)
    percuss("orbits", "resting.toml", "--label", "chatter/1").told("1 cycle chatter/1", "6.018157846")
    percuss("orbits", "resting.toml", "--label", "rest/1").told("0 cycles rest/1")
    both = ("orbits", "resting.toml", "--up-to", "2/1", "--tries", "20", "--motions", "0")
    assert [answer["label"] for answer in percuss(*both, "--json").json] == ["z=1/1", "z=2/1", "chatter/1"]
    percuss(*both).told(", 1 cycle with rest, 0 elastic modes.", "6.018157846")


def test_a_cycle_with_rest_followed(percuss):
    files = ("-o", "rest.csv", "--plot", "rest.svg")
    asked = ("--orbit", "chatter/1:1", "--along", "mean=0.78:0.82")
    answer = percuss("follow", "resting.toml", *asked, *files, "--json").json
    assert types(answer["points"]) == ["limit", "limit"]
    assert answer["points"][0]["orbit"]["label"] == answer["label"] == "chatter/1"
    value, released = answer["branch"]["value"], answer["branch"]["release_phases"]
    lets_go = [math.cos(phase) + mean for mean, (phase,) in zip(value, released, strict=True)]
    assert lets_go == pytest.approx([0.0] * len(value), rel=0, abs=1e-12)
    assert len(answer["branch"]["rest_phases"]) == len(answer["branch"]["phases"]) == len(value)
    lines = Path("rest.csv").read_text(encoding="utf-8").splitlines()
    assert lines[0] == "branch,label,point,mean,stable,impact,phase,speed,release_phase,rest_phase"
    assert lines[1].startswith("1,chatter/1,1,0.78,1,1,")
    assert len(lines) - 1 == sum(len(phases) for phases in answer["branch"]["phases"])
    assert Path("rest.svg").read_text(encoding="utf-8").startswith("<?xml")


def test_the_onset_of_chatter_is_told(capsys):
    (cycle,) = rest_cycles(System(s=5.0, d=0.0, restitution=0.2, load=Load.harmonic(0.46, 1.0)), modes=0).orbits
    show(branch_report("hammer", follow(cycle, "mean", (0.45, 0.46), points=2)))
    told = " ".join(capsys.readouterr().out.split())
    assert re.search(r"onset 0\.4578252\d*: the end of the chatter meets the next release", told) is not None
    assert "multipliers all 0" in told


# -- phases -----------------------------------------------------------------------------------------------------------


def test_phases_say_which_orbit_whatever_impact_comes_first():
    system = System(s=5.0, d=0.0, restitution=0.5, load=Load.harmonic(0.665, 1.0))
    wanted = orbits(system, 2, modes=0).orbits[1]
    for phases in (wanted.phases, wanted.phases[::-1], wanted.phases + 0.2, wanted.phases - 4.0 * math.pi):
        assert orbit_at_phases(system, "", phases.tolist(), (2, 1), 0).times == pytest.approx(wanted.times, abs=1e-9)
    with pytest.raises(ParameterError, match="in order of time"):  # more turns than the label has
        orbit_at_phases(system, "", [3.0, 2.0, 1.0], (3, 1), 0)


def test_flights_of_more_than_a_load_period_are_found_by_phases():
    """z=2/3 of a stiff bar with full rebound: 8.7 rad lie between its two impacts."""
    found = orbit_at_phases(random_hammer(20).system, "", [2.28, 6.0966], (2, 3), 8)
    assert found.flight_times.max() > 2.0 * math.pi
    assert found.phases == pytest.approx([2.28, 6.0966], abs=0.1)
    assert np.all(found.speeds > 0.0)


# -- Ctrl-C -----------------------------------------------------------------------------------------------------------


@pytest.fixture
def ctrl_c_at(monkeypatch):
    """Ctrl-C when the computation asks for the n-th time; gives the count of how often it has asked."""
    plain = JobWatch.asked

    def chosen(number):
        calls = count(1)

        def asked(self, *_):
            if next(calls) == number:
                signal.raise_signal(signal.SIGINT)
            return plain(self, *_)

        monkeypatch.setattr(JobWatch, "asked", asked)
        return calls

    return chosen


def test_a_search_is_interrupted(percuss, ctrl_c_at):
    """What was found is told, of the label that was being searched, too; it is a part of what there is."""
    asked = ("orbits", "hammer.toml", "--label", "3/1", "--motions", "0", "--tries", "3000", "--json")
    calls = ctrl_c_at(-1)
    whole = percuss(*asked).json
    ctrl_c_at(next(calls) // 2)
    told = percuss(*asked)
    part = told.json
    assert (told.code, told.err) == (130, "percuss: interrupted: the search is done for 0 of 1 label\n")
    assert part["interrupted"] and not whole["interrupted"] and not part["complete"]
    assert 0 < part["tries"] < whole["tries"] == 3000
    assert 0 < sum(part["dropped"].values()) + len(part["orbits"]) <= part["tries"]
    phases = [[impact["phase"] for impact in orbit["impacts"]] for orbit in whole["orbits"]]
    for orbit in part["orbits"]:
        assert [impact["phase"] for impact in orbit["impacts"]] in [pytest.approx(one, abs=1e-9) for one in phases]


FOLLOW = ("follow", "hammer.toml", "--orbit", "1/1:phases=2.43", "--along", "mean=0.5:1", "--json")
STOPPED = {
    "labels": (10, ("orbits", "hammer.toml", "--up-to", "3/1", "--tries", "3000"), "the search is done"),
    "a branch": (60, FOLLOW, "the answer is of what was followed until then\n"),
    "reach": (1, ("steady", "possible.toml", "--modes", "0", "--reach-of", "mean,restitution", "--json"),
              "how far 0 of 2 parameters may move is known\n"),
}  # fmt: skip


@pytest.mark.parametrize("name", STOPPED)
def test_what_was_done_before_ctrl_c_is_told(percuss, ctrl_c_at, name):
    number, asked, told = STOPPED[name]
    whole = percuss(*asked).json if name == "reach" else None
    ctrl_c_at(number)
    done = percuss(*asked)
    assert done.code == 130 and done.err.startswith(f"percuss: interrupted: {told}")
    if name == "labels":
        assert "1/1: the search" in done and ("before all tries were made" in done or "3/1" not in done)
    elif name == "reach":
        assert (done.json["reach"], done.json["periods"]) == ([], whole["periods"])
    else:
        assert done.json["branch"]["value"]


def test_ctrl_c_before_the_first_point_leaves_nothing_to_tell(percuss, ctrl_c_at):
    ctrl_c_at(1)
    done = percuss(*FOLLOW)
    assert (done.code, done.out, done.err.strip()) == (130, "", "percuss: interrupted")


def test_a_range_without_the_value_of_the_case_begins_at_its_nearest_end(percuss):
    """The branch of the case at that end, and a point over its own parameter stays where it is."""
    Path("hammer.toml").write_text(CASES["hammer"], encoding="utf-8")  # whose mean is 0.62
    asked = ("follow", "hammer.toml", "--along", "mean=0.64:0.66", "--modes", "0")
    found = percuss(*asked, "--curve", "all", "--over", "mean=0.6:0.7", "--json").json
    own = branch_answer(Case.from_text(CASES["hammer"].replace("0.62", "0.64")), "1/1", "mean=0.64:0.66", modes=0)
    assert (found["begun_at"], found["curves"]) == (0.64, [])
    assert found["branch"]["value"] == own.values.tolist() and found["branch"]["phases"] == own.phases.tolist()
    assert "Begun at 0.64, the end of the range" in " ".join(percuss(*asked).out.split())
