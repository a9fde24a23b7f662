"""`percuss blow --best`: report, JSON, the case that is saved, the picture, every kind of bad input."""

import json
import signal
from pathlib import Path

import pytest

from percuss.case import Case, Span, best_answer, blow_answer, load_case
from percuss.cli import main
from percuss.errors import ParameterError

SEARCH = ("blow", "laboratory-striker", "--best", "efficiency", "--vary", "bar.length=50:400mm", "--blows", "40")


@pytest.fixture
def percuss(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)

    def command(*arguments):
        try:
            code = main(list(arguments))
        except SystemExit as stop:
            code = stop.code
        return code, *capsys.readouterr()

    return command


def test_the_saved_case_gives_what_was_told(percuss):
    code, out, _ = percuss(*SEARCH, "--below", "300MPa", "--json", "-o", "best.toml", "--plot", "best.png")
    told = json.loads(out)
    best = Case.read("best.toml")
    blow = blow_answer(best).blow
    assert code == 0 and told["allowed"] and Path("best.png").read_bytes()[:4] == b"\x89PNG"
    assert told["figures"]["rock_efficiency"]["best"] == blow.efficiency >= told["figures"]["rock_efficiency"]["own"]
    assert told["figures"]["peak_stress"]["best"] <= 300e6
    assert best.tables.bar.length == f"{told['varied'][0]['best']!r} mm"
    assert told["varied"][0]["own"] == 200.0 and told["best_case"]["bar"]["length"] == best.tables.bar.length


def test_the_report_tells_the_change(percuss):
    code, out, _ = percuss(*SEARCH)
    assert code == 0
    for word in ("The best blow found: efficiency", "the case as it is", "bar.length", "peak stress", "MPa", "seed 0"):
        assert word in out


def test_a_limit_that_nothing_keeps(percuss):
    code, out, _ = percuss(*SEARCH, "--below", "1 kPa")
    assert code == 0 and "No blow within these ranges" in out


@pytest.mark.parametrize(
    ("more", "told"),
    [
        (("--best", "rock-energy"), "say what may vary"),
        (("--best", "beauty", "--vary", "bar.length=1:2mm"), "rock-energy, efficiency"),
        (("--vary", "bar.length=1:2mm"), "only with --best"),
        (("--best", "efficiency", "--vary", "bar.length=1mm"), "NAME=LOW:HIGH"),
        (("--best", "efficiency", "--vary", "bar.lenth=1:2mm"), "bar.length"),
        (("--best", "efficiency", "--vary", "bar.length=2:1mm"), "smaller end first"),
        (("--best", "efficiency", "--vary", "bar.length=1:2kg"), "length"),
        (("--best", "efficiency", "--vary", "length=1:2mm", "--vary", "bar.length=1:2mm"), "each key once"),
        (("--best", "efficiency", "--vary", "bar.length=1:2mm", "--below", "3 kg"), "--below"),
        (("--best", "efficiency", "--vary", "bar.length=1:2mm", "-o", "best.nc"), ".toml"),
        (("--best", "efficiency", "--vary", "bar.length=1:2mm", "--gauge", "1m"), "not with --best"),
        (("--best", "efficiency", "--vary", "restitution=0:1"), "a key of the case"),
        (("--best", "efficiency", "--vary", "load.scale=1:2"), "a key of the case"),
        (("--best", "efficiency", "--vary", "contact.receiving_area=1:2cm^2"), "depends on"),
        (("--best", "efficiency", "--vary", "bar.length=1:2"), "such as bar.length=1:2mm"),
        (("--best", "efficiency", "--vary", "head.length=1:2mm"), "a key of the case: bar.length"),
        (("--best", "efficiency", "--vary", "bar.length=1:2mm", "--blows", "3"), "20 or greater"),
    ],
)
def test_bad_questions_are_refused_at_once(percuss, more, told):
    code, out, err = percuss("blow", "laboratory-striker", *more)
    assert code not in (0, None) and not out and told in " ".join(err.split())


WALL = """
[bar]
sections = [{length = "0.3 m", diameter = "40 mm"}, {length = "0.1 m", diameter = "30 mm"}]
[blow]
velocity = "10 m/s"
"""


@pytest.mark.parametrize(
    ("objective", "told"), [("rock-energy", "[rock]"), ("efficiency", "[rock]"), ("incident-energy", "[tool]")]
)
def test_what_no_blow_of_the_case_has_is_refused(percuss, objective, told):
    Path("wall.toml").write_text(WALL, encoding="utf-8")
    code, out, err = percuss("blow", "wall.toml", "--best", objective, "--vary", "bar.sections[1].length=50:150mm")
    assert code == 2 and not out and told in err


def test_the_case_itself_is_not_written_over(percuss):
    Path("wall.toml").write_text(WALL, encoding="utf-8")
    code, _, err = percuss(
        "blow", "wall.toml", "--best", "peak-stress", "--vary", "bar.sections[1].length=50:150mm", "-o", "wall.toml"
    )
    assert code == 2 and "is the case itself" in err and Path("wall.toml").read_text(encoding="utf-8") == WALL


def test_a_recording_is_found_from_another_folder(percuss):
    assert percuss("new", "hydraulic-drifter", "-o", "drifter.toml")[0] == 0
    Path("found").mkdir()
    search = ("--best", "efficiency", "--vary", "bar.length=300:400mm", "--blows", "20")
    assert percuss("blow", "drifter.toml", *search, "-o", "found/best.toml")[0] == 0
    own, best = Case.read("drifter.toml"), Case.read("found/best.toml")
    assert best.tables.load.file == "../drifter_pressure.csv"
    assert best.load().coefficients == pytest.approx(own.load().coefficients)


def test_ctrl_c_ends_with_the_best_so_far(percuss, monkeypatch):
    heard = []

    def told(self, progress):
        heard.append(progress)
        if len(heard) == 12:
            signal.raise_signal(signal.SIGINT)
        return self.interrupted

    monkeypatch.setattr("percuss.cli.long_commands.JobWatch.__call__", told)
    code, out, err = percuss(*SEARCH, "--json", "-o", "best.toml")
    found = json.loads(out)
    assert code == 130 and "interrupted" in err and len(heard) == 12
    assert found["complete"] is False and found["blows"] == 11
    best = blow_answer(Case.read("best.toml")).blow
    assert best.efficiency == found["figures"]["rock_efficiency"]["best"] >= found["figures"]["rock_efficiency"]["own"]


def test_a_range_above_what_the_case_has(percuss):
    """The case itself is not tried, and may be better."""
    code, out, _ = percuss(*SEARCH[:5], "bar.length=30:60mm", "--blows", "30", "--json")
    found = json.loads(out)
    assert code == 0 and found["varied"][0]["own"] == 200.0 and 30.0 <= found["varied"][0]["best"] <= 60.0
    assert found["figures"]["rock_efficiency"]["best"] < found["figures"]["rock_efficiency"]["own"]


def test_short_names_where_only_one_key_has_them():
    case = load_case("laboratory-striker")
    long, short = (
        best_answer(case, [Span.parsed(text)], "efficiency", most=20)
        for text in ("rock.stiffness=50:400kN/mm", "stiffness=50:400kN/mm")
    )
    assert long.values == short.values
    with pytest.raises(ParameterError, match=r"bar\.sections\[0\]"):
        best_answer(load_case("stepped-drifter"), [Span.parsed("head.length=50:150mm")], most=20)


@pytest.mark.parametrize("low", ["-50", "0"])
def test_ends_of_ranges_are_values(low):
    case, key = load_case("stepped-drifter"), "bar.sections[2].length"
    with pytest.raises(ParameterError, match=rf"{low} mm'?: expected a length greater than 0"):
        best_answer(case, [Span.parsed(f"{key}={low}:150mm")], "rock-energy", most=20)
