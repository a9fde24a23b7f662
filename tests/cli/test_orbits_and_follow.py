"""``percuss orbits`` and ``percuss follow`` as a person would use them."""

from __future__ import annotations

import json
import math
import re
import signal
from collections.abc import Callable
from itertools import count
from pathlib import Path

import pytest

from percuss import Load, System
from percuss.case import Case, branch_answer
from percuss.case.answers.exploring.orbits_answer import branch_report
from percuss.cli import main
from percuss.cli.long_commands import Watch
from percuss.cli.report_printing import show
from percuss.explore import follow_rest_cycle
from percuss.steady import rest_cycles

HAMMER = """
[system]
s = 5.0
d = 0.0
restitution = 0.5
[load]
kind = "harmonic"
mean = 0.62
amplitude = 1.0
[simulation]
modes = 0
"""

IN_SI = """
[bar]
length = "0.4 m"
diameter = "50 mm"
[contact]
restitution = 0.5
[load]
kind = "harmonic"
mean = "6.2 kN"
amplitude = "10 kN"
frequency = "50 Hz"
[simulation]
modes = 0
"""


@pytest.fixture
def hammer(tmp_path: Path) -> str:
    path = tmp_path / "hammer.toml"
    path.write_text(HAMMER, encoding="utf-8")
    return str(path)


def test_the_orbits_of_a_label(hammer: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["orbits", hammer, "--label", "2/1", "--tries", "100"]) == 0
    told = capsys.readouterr().out
    assert "2 orbits, 0 elastic modes." in told
    assert "0.390789, 2.321002" in told
    assert "yes (proved)" in told
    assert main(["orbits", hammer, "--label", "1/1", "--up-to", "3/1", "--tries", "100", "--json"]) == 0
    answers = json.loads(capsys.readouterr().out)
    assert [answer["label"] for answer in answers] == ["z=1/1", "z=2/1", "z=3/1"]
    assert [len(answer["orbits"]) for answer in answers] == [2, 2, 2]
    assert [answer["complete"] for answer in answers] == [True, True, False]
    assert answers[1]["orbits"][1]["impacts"][0]["phase"] == pytest.approx(0.390789, abs=1e-6)
    assert sum(answers[2]["dropped"].values()) + 2 == answers[2]["tries"] == 100


def test_an_orbit_followed(hammer: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    table, picture = tmp_path / "branch.csv", tmp_path / "branch.svg"
    files = ["-o", str(table), "--plot", str(picture)]
    assert main(["follow", hammer, "--orbit", "2/1:2", "--along", "mean=0.6:1.2", *files]) == 0
    told = capsys.readouterr().out
    assert "flip" in told
    assert "0.659281674533: z=4/2 begins towards smaller mean, stable" in told
    assert picture.read_text(encoding="utf-8").startswith("<?xml")
    lines = table.read_text(encoding="utf-8").splitlines()
    assert lines[0] == "branch,label,point,mean,stable,impact,phase,speed"
    assert lines[1].startswith("1,z=2/1,1,0.6,0,1,")


def test_the_answer_as_json_has_every_branch(hammer: str, capsys: pytest.CaptureFixture[str]) -> None:
    asked = ["--orbit", "1/1:phases=2.43", "--along", "load_factor=0.585:0.7", "--switch", "2", "--json"]
    assert main(["follow", hammer, *asked]) == 0
    answer = json.loads(capsys.readouterr().out)
    assert [row["label"] for row in answer["cascade"]] == ["z=1/1", "z=2/2", "z=4/4"]
    assert [one["label"] for one in answer["switched"]] == ["z=2/2", "z=4/4"]
    assert answer["points"][0]["type"] == "limit"
    flip = next(point for point in answer["points"] if point["type"] == "flip")
    assert flip["value"] == pytest.approx(0.6549544650505745, abs=1e-11)
    assert len(answer["branch"]["value"]) == len(answer["branch"]["phases"]) == len(answer["branch"]["stable"])


def test_an_onset_followed_and_laid_over_a_map(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    hammer = tmp_path / "chattering.toml"
    hammer.write_text(
        HAMMER.replace("restitution = 0.5", "restitution = 0.05").replace("0.62", "0.37"), encoding="utf-8"
    )
    asked = ["follow", str(hammer), "--orbit", "chatter/1", "--along", "load_factor=0.36:0.38", "--curve", "onset"]
    picture, table, curves = tmp_path / "curves.svg", tmp_path / "curves.csv", tmp_path / "curves.json"
    files = ["--plot", str(picture), "-o", str(table)]
    assert main([*asked, "--over", "restitution=0.01:0.5", *files, "--json"]) == 0
    told = capsys.readouterr().out
    (curve,) = json.loads(told)["curves"]
    assert (curve["type"], curve["label"], curve["parameters"]) == (
        "onset",
        "chatter/1",
        ["load_factor", "restitution"],
    )
    assert [point["type"] for point in curve["points"]] == ["limit", "limit"]
    assert len(curve["curve"]["values"]) == len(curve["curve"]["event_phases"]) == len(curve["curve"]["is_orbit"])
    assert picture.read_text(encoding="utf-8").startswith("<?xml")
    lines = table.read_text(encoding="utf-8").splitlines()
    assert lines[0] == "curve,type,label,point,load_factor,restitution,is_orbit,release_phase,event_phase"
    assert len(lines) == len(curve["curve"]["values"]) + 1
    curves.write_text(told, encoding="utf-8")
    sweep = [
        "sweep",
        str(hammer),
        "--x",
        "restitution=0.1:0.3:2",
        "--y",
        "load_factor=0.4:0.5:2",
        "--quantity",
        "exists",
    ]
    drawn = tmp_path / "map.svg"
    assert main([*sweep, "--overlay", str(curves), "--plot", str(drawn)]) == 0
    assert drawn.read_text(encoding="utf-8").startswith("<?xml")
    assert main([*asked[:-1], "flip", "--over", "restitution=0.01:0.5"]) == 2
    assert "there are: onset" in capsys.readouterr().err


def test_points_are_followed_without_ranges(capsys: pytest.CaptureFixture[str]) -> None:
    asked = ["--orbit", "1/1:2", "--along", "load_factor", "--curve", "flip", "--over", "restitution", "--modes", "0"]
    assert main(["follow", "pneumatic-jackleg", *asked, "--json"]) == 0
    (curve,) = json.loads(capsys.readouterr().out)["curves"]
    first, *_, last = curve["points"]
    assert first["type"] == last["type"] == "parameter_end"
    assert first["values"][1] == pytest.approx(0.0, abs=1e-8) and last["values"][1] == pytest.approx(1.0, abs=1e-8)


def test_points_followed_and_laid_over_a_map(hammer: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    asked = ["follow", hammer, "--orbit", "2/1:2", "--along", "load_factor=0.61:0.8", "--curve", "flip,fold:1"]
    asked += ["--over", "restitution=0.498:0.502"]
    picture, table, curves = tmp_path / "curves.svg", tmp_path / "curves.csv", tmp_path / "curves.json"
    assert main([*asked, "--plot", str(picture), "-o", str(table), "--json"]) == 0
    told = capsys.readouterr().out
    answer = json.loads(told)
    assert [one["type"] for one in answer["curves"]] == ["flip", "fold"]
    assert answer["curves"][0]["parameters"] == ["load_factor", "restitution"]
    assert [point["type"] for point in answer["curves"][1]["points"]] == ["limit", "limit"]
    assert picture.read_text(encoding="utf-8").startswith("<?xml")
    lines = table.read_text(encoding="utf-8").splitlines()
    assert lines[0] == "curve,type,label,point,load_factor,restitution,is_orbit,impact,phase"
    assert lines[1].startswith("1,flip,z=2/1,1,")
    curves.write_text(told, encoding="utf-8")
    sweep = ["sweep", hammer, "--x", "restitution=0.49:0.51:2", "--quantity", "exists", "--overlay", str(curves)]
    drawn = tmp_path / "map.svg"
    assert main([*sweep, "--y", "load_factor=0.6:0.7:2", "--plot", str(drawn)]) == 0
    assert drawn.read_text(encoding="utf-8").count("stroke-dasharray") > 2
    assert main([*sweep, "--y", "mean=0.6:0.7:2", "--plot", str(drawn)]) == 2
    assert "curves over restitution and mean" in capsys.readouterr().err
    assert main([*sweep, "--y", "load_factor=0.6:0.7:2"]) == 2


def test_a_key_of_the_case_in_its_unit() -> None:
    case = Case.from_text(IN_SI)
    branch = branch_answer(case, "1/1:2", "frequency=45 Hz:55 Hz")
    assert branch.values[[0, -1]].tolist() == [45.0, 55.0]
    assert abs(branch.phases - branch.phases[0]).max() < 1e-12  # a rigid bar knows no frequency


def test_without_a_range_a_branch_goes_to_its_ends() -> None:
    case = Case.from_text(HAMMER)
    branch = branch_answer(case, "2/1:2", "mean")
    ends = [(point.kind.value, point.value) for point in branch.points]
    assert ends[0] == ("grazing_impact_dies", pytest.approx(0.3993131887184041, abs=1e-11))
    assert ends[-1] == ("grazing_touch", pytest.approx(0.5279096824923904, abs=1e-11))
    keyed = branch_answer(Case.from_text(IN_SI), "1/1:2", "load.mean").values  # in kilonewtons, as in the case
    assert keyed.max() == pytest.approx(10.0 * branch_answer(case, "1/1:2", "mean").values.max(), rel=1e-9)


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["orbits", "CASE", "--label", "2"], "impacts and load periods"),
        (["orbits", "CASE", "--label", "2/1", "--up-to", "1/1"], "--up-to"),
        (["follow", "CASE", "--orbit", "2/1:9", "--along", "mean=0.5:1"], "one of the 2 orbits"),
        (["follow", "CASE", "--orbit", "1/1:first", "--along", "mean=0.5:1"], "P/N:NUMBER"),
        (["follow", "CASE", "--orbit", "2/1:phases=0.4", "--along", "mean=0.5:1"], "2 phases"),
        (["follow", "CASE", "--along", "mean=0.7:1"], "a range that holds 0.62"),
        (["follow", "CASE", "--orbit", "chatter/1", "--along", "d=1:2"], "a range that holds 0"),
        (["follow", "CASE", "--along", "mean=0.6:0.63", "--curve", "flip", "--over", "d=1:2"], "a range that holds 0"),
        (["follow", "CASE", "--orbit", "chatter/1:1", "--along", "mean=0.5:1"], "one of the 0 cycles chatter/1"),
        (["follow", "CASE", "--orbit", "rest/1:phases=2", "--along", "mean=0.5:1"], "chatter/N:NUMBER"),
        (["follow", "CASE", "--orbit", "chatter/1", "--along", "mean=0.5:1", "--switch", "2"], "--switch"),
        (["follow", "CASE", "--along", "mean="], "NAME="),
        (["follow", "CASE", "--along", "mean=0:1", "--curve", "flip", "--over", "mean=0:1"], "another"),
        (["follow", "CASE", "--along", "nothing=0:1"], "nothing"),
        (["follow", "CASE", "--along", "mean=0.5:1", "-o", "branch.txt"], ".csv"),
        (["follow", "CASE", "--along", "mean=0.6:0.63", "--curve", "flip"], "--over"),
        (["follow", "CASE", "--along", "mean=0.6:0.63", "--curve", "flop", "--over", "restitution=0:0.9"], "one of"),
        (["follow", "CASE", "--along", "mean=0.61:0.63", "--curve", "flip:9", "--over", "restitution=0:0.9"], "flip:9"),
        (
            ["follow", "CASE", "--along", "mean=0.61:0.63", "--curve", "flip", "--over", "d=0:1"],
            "has no flip, but limit",
        ),
        (["sweep", "CASE", "--x", "mean=0.6:0.7:2", "--overlay", "curves.json"], "--plot"),
        (["sweep", "CASE", "--x", "mean=0.6:0.7:2", "--y", "d=0:1:2", "--plot", "a.png", "--overlay", "CASE"], "curve"),
    ],
)
def test_what_cannot_be_answered_is_told(
    hammer: str, arguments: list[str], told: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([hammer if word == "CASE" else word for word in arguments]) == 2
    assert told in capsys.readouterr().err


def test_cycles_with_rest_by_their_label(hammer: str, capsys: pytest.CaptureFixture[str]) -> None:
    text = Path(hammer).read_text(encoding="utf-8").replace("mean = 0.62", "mean = 0.8")
    Path(hammer).write_text(text, encoding="utf-8")
    assert main(["orbits", hammer, "--label", "chatter/1", "--json"]) == 0
    (cycle,) = json.loads(capsys.readouterr().out)["orbits"]
    assert (cycle["label"], cycle["multipliers"], cycle["stable"]) == ("chatter/1", [[0.0, 0.0]], True)
    assert cycle["release_phase"] == pytest.approx(2.4980915447965089, abs=1e-12)
    assert cycle["rest_phase"] == pytest.approx(6.0181578458150141, abs=1e-12)
    assert cycle["impacts"][0]["phase"] == pytest.approx(5.153035058850553, abs=1e-12)
    assert main(["orbits", hammer, "--label", "chatter/1"]) == 0
    told = capsys.readouterr().out
    assert "1 cycle chatter/1" in told and "6.018157846" in told
    assert main(["orbits", hammer, "--label", "rest/1"]) == 0
    assert "0 cycles rest/1" in capsys.readouterr().out
    assert main(["orbits", hammer, "--label", "chatter/1", "--up-to", "2/1"]) == 2


def test_cycles_with_rest_are_listed_after_the_orbits(hammer: str, capsys: pytest.CaptureFixture[str]) -> None:
    text = Path(hammer).read_text(encoding="utf-8").replace("mean = 0.62", "mean = 0.8")
    Path(hammer).write_text(text, encoding="utf-8")
    asked = ["orbits", hammer, "--up-to", "2/1", "--tries", "20", "--motions", "0"]
    assert main([*asked, "--json"]) == 0
    assert [answer["label"] for answer in json.loads(capsys.readouterr().out)] == ["z=1/1", "z=2/1", "chatter/1"]
    assert main(asked) == 0
    told = capsys.readouterr().out
    assert ", 1 cycle with rest, 0 elastic modes." in told and "6.018157846" in told


def test_a_cycle_with_rest_followed(hammer: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = Path(hammer).read_text(encoding="utf-8").replace("mean = 0.62", "mean = 0.8")
    Path(hammer).write_text(text, encoding="utf-8")
    table, picture = tmp_path / "rest.csv", tmp_path / "rest.svg"
    asked = ["follow", hammer, "--orbit", "chatter/1:1"]
    assert main([*asked, "--along", "mean=0.78:0.82", "-o", str(table), "--plot", str(picture), "--json"]) == 0
    answer = json.loads(capsys.readouterr().out)
    assert [point["type"] for point in answer["points"]] == ["limit", "limit"]
    assert answer["points"][0]["orbit"]["label"] == answer["label"] == "chatter/1"
    value, released = answer["branch"]["value"], answer["branch"]["release_phases"]
    assert [math.cos(phase) + mean for mean, (phase,) in zip(value, released, strict=True)] == pytest.approx(
        [0.0] * len(value), rel=0, abs=1e-12
    )
    assert len(answer["branch"]["rest_phases"]) == len(answer["branch"]["phases"]) == len(value)
    lines = table.read_text(encoding="utf-8").splitlines()
    assert lines[0] == "branch,label,point,mean,stable,impact,phase,speed,release_phase,rest_phase"
    assert lines[1].startswith("1,chatter/1,1,0.78,1,1,")
    assert len(lines) - 1 == sum(len(phases) for phases in answer["branch"]["phases"])
    assert picture.read_text(encoding="utf-8").startswith("<?xml")


def test_the_onset_of_chatter_is_told(capsys: pytest.CaptureFixture[str]) -> None:
    (cycle,) = rest_cycles(System(s=5.0, d=0.0, restitution=0.2, load=Load.harmonic(0.46, 1.0)), modes=0).cycles
    show(branch_report("hammer", follow_rest_cycle(cycle, "mean", (0.45, 0.46), points=2)))
    told = " ".join(capsys.readouterr().out.split())
    assert re.search(r"onset 0\.4578252\d*: the end of the chatter meets the next release", told) is not None
    assert "multipliers all 0" in told


# -- Ctrl-C ------------------------------------------------------------------------------------------------------------


@pytest.fixture
def ctrl_c_at(monkeypatch: pytest.MonkeyPatch) -> Callable[[int], None]:
    """Ctrl-C when the computation asks for the n-th time."""

    def chosen(number: int) -> None:
        calls = count(1)
        plain = Watch.asked

        def asked(self: Watch) -> bool:
            if next(calls) == number:
                signal.raise_signal(signal.SIGINT)
            return plain(self)

        monkeypatch.setattr(Watch, "asked", asked)

    return chosen


def test_a_search_is_interrupted(
    hammer: str, capsys: pytest.CaptureFixture[str], ctrl_c_at: Callable[[int], None]
) -> None:
    """What was found is told, of the label that was being searched, too; it is a part of what there is."""
    asked = ["orbits", hammer, "--label", "3/1", "--motions", "0", "--tries", "3000", "--json"]
    assert main(asked) == 0
    whole = json.loads(capsys.readouterr().out)
    ctrl_c_at(6)
    assert main(asked) == 130
    told = capsys.readouterr()
    part = json.loads(told.out)
    assert told.err == "percuss: interrupted: the search is done for 0 of 1 label\n"
    assert part["halted"] and not whole["halted"] and not part["complete"]
    assert 0 < part["tries"] < whole["tries"] == 3000
    assert 0 < sum(part["dropped"].values()) + len(part["orbits"]) <= part["tries"]
    phases = [[impact["phase"] for impact in orbit["impacts"]] for orbit in whole["orbits"]]
    for orbit in part["orbits"]:
        assert [impact["phase"] for impact in orbit["impacts"]] in [pytest.approx(one, abs=1e-9) for one in phases]


def test_labels_searched_before_ctrl_c_are_told(
    hammer: str, capsys: pytest.CaptureFixture[str], ctrl_c_at: Callable[[int], None]
) -> None:
    ctrl_c_at(10)
    assert main(["orbits", hammer, "--label", "1/1", "--up-to", "3/1", "--tries", "3000"]) == 130
    told = capsys.readouterr()
    assert "1/1: the search" in told.out
    assert "before all tries were made" in told.out or "3/1" not in told.out
    assert told.err.startswith("percuss: interrupted: the search is done for ")


def test_an_orbit_is_followed_until_ctrl_c(
    hammer: str, capsys: pytest.CaptureFixture[str], ctrl_c_at: Callable[[int], None]
) -> None:
    ctrl_c_at(60)
    assert main(["follow", hammer, "--orbit", "1/1:phases=2.43", "--along", "mean=0.5:1", "--json"]) == 130
    told = capsys.readouterr()
    assert json.loads(told.out)["branch"]["value"]
    assert told.err == "percuss: interrupted: the answer is of what was followed until then\n"


def test_ctrl_c_before_the_first_point_leaves_nothing_to_tell(
    hammer: str, capsys: pytest.CaptureFixture[str], ctrl_c_at: Callable[[int], None]
) -> None:
    ctrl_c_at(1)
    assert main(["follow", hammer, "--orbit", "1/1:phases=2.43", "--along", "mean=0.5:1", "--json"]) == 130
    told = capsys.readouterr()
    assert (told.out, told.err.strip()) == ("", "percuss: interrupted")


def test_reach_is_interrupted(
    hammer: str, capsys: pytest.CaptureFixture[str], ctrl_c_at: Callable[[int], None]
) -> None:
    """The steady motions and the parameters that were done before are told."""
    hammer = str(Path(hammer).with_name("possible.toml"))
    Path(hammer).write_text(HAMMER.replace("0.62", "0.7"), encoding="utf-8")
    asked = ["steady", hammer, "--modes", "0", "--reach-of", "mean,restitution", "--json"]
    assert main(asked) == 0
    whole = json.loads(capsys.readouterr().out)
    ctrl_c_at(1)
    assert main(asked) == 130
    told = capsys.readouterr()
    part = json.loads(told.out)
    assert part["reach"] == []
    assert part["periods"] == whole["periods"]
    assert told.err == "percuss: interrupted: how far 0 of 2 parameters may move is known\n"
