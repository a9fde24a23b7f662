"""What `percuss orbits` and `percuss follow` say to what they cannot answer: one clear line, and no traceback."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest

from percuss import Load, System
from percuss.case.answers.exploring.orbits_answer import orbit_at_phases
from percuss.cli import main
from percuss.errors import ParameterError
from percuss.steady import orbits
from random_hammers import random_hammer

LOAD = "[load]\nkind = 'harmonic'\nmean = {mean}\namplitude = 1.0\n[simulation]\nmodes = {modes}\n"
HAMMER = "[system]\ns = {s}\nd = 0.0\nrestitution = {r}\n" + LOAD
STEPS = "[system]\ns = 5.0\nd = 0.0\nrestitution = 0.5\n[load]\nkind = 'steps'\nbreaks = {0}\nvalues = {1}\n"
CASES = {
    "HAMMER": HAMMER.format(s=5.0, r=0.5, mean=0.665, modes=0),
    "FULL": HAMMER.format(s=5.0, r=1.0, mean=0.3, modes=0),
    "PULLED": HAMMER.format(s=5.0, r=0.5, mean=-0.3, modes=0),
    "DRIVEN": HAMMER.format(s=1.0 / math.pi, r=0.5, mean=0.3, modes=0),
    "RINGING": HAMMER.format(s=2.0 / math.pi, r=0.5, mean=0.3, modes=3),
    "STEP": STEPS.format("[0.0]", "[1.0]"),
    "FLAT": STEPS.format("[0.0, 2.0]", "[1.0, 1.0]"),
}
REFUSED = [
    ("orbits HAMMER --label 65/1", "impacts = 65: expected a whole number from 1 to 64"),
    ("orbits HAMMER --label 0/1", "impacts = 0"),
    ("orbits HAMMER --label 1/0", "periods = 0"),
    ("orbits HAMMER --label 1/257", "periods = 257: expected a whole number from 1 to 256"),
    ("orbits HAMMER --label 1000/1", "impacts and load periods of a cycle"),
    ("orbits HAMMER --label two/1", "impacts and load periods of a cycle"),
    ("orbits HAMMER --label 2.5/1", "impacts and load periods of a cycle"),
    ("orbits HAMMER --label 2/1/1", "impacts and load periods of a cycle"),
    ("orbits HAMMER --label -1/1", "--label"),
    ("orbits HAMMER --label chatter/0", "impacts and load periods of a cycle"),
    ("orbits HAMMER --label 1/1 --up-to 65/1", "impacts = 65"),
    ("orbits HAMMER --label 3/1 --tries 99999999999", "--tries"),
    ("orbits HAMMER --label 3/1 --tries 0 --motions 0", "tries = 0"),
    ("orbits HAMMER --modes 5000", "--modes"),
    ("orbits PULLED --label 2/1", "the load does not push"),
    ("orbits PULLED --label 3/1", "the load does not push"),
    ("orbits FLAT --label 2/1", "the load is constant"),
    ("orbits STEP --label 2/1", "two or more phases"),
    ("orbits DRIVEN --label 3/1", "elastic mode n = 1"),
    ("orbits no-such-hammer", "no such file"),
    ("follow HAMMER --along mean=0.5:1 --orbit 65/1", "impacts = 65"),
    ("follow HAMMER --along mean=0.5:1 --orbit 2/1:0", "orbit = 0"),
    ("follow HAMMER --along mean=0.5:1 --orbit 2/1:99", "one of the 2 orbits z=2/1"),
    ("follow HAMMER --along mean=0.5:1 --orbit 2/1:-1", "P/N:NUMBER"),
    ("follow HAMMER --along mean=0.5:1 --orbit 2/1:1:2", "P/N:NUMBER"),
    ("follow HAMMER --along mean=0.5:1 --orbit 2/1:phases=", "P/N:NUMBER"),
    ("follow HAMMER --along mean=0.5:1 --orbit 2/1:phases=nan,1", "phases in rad"),
    ("follow HAMMER --along mean=0.5:1 --orbit 2/1:phases=0.4,1e300", "phases in rad"),
    ("follow HAMMER --along mean=0.5:1 --orbit 2/1:phases=0.4,0.4", "phases near those of an orbit"),
    ("follow HAMMER --along mean=0.5:1 --orbit 2/1:phases=5,6", "the nearest has 0.329782, 2.07112"),
    ("follow HAMMER --along mean=0.5:1 --orbit 3/1:phases=5,4,3", "phases near those of an orbit, in order of time"),
    ("follow HAMMER --along mean=0.665:0.665", "two different ends"),
    ("follow HAMMER --along mean=1:0.5", "smaller end first"),
    ("follow HAMMER --along mean=1", "'mean=1': expected NAME=FROM:TO"),
    ("follow HAMMER --along mean=0.5:1:5", "'mean=0.5:1:5': expected NAME=FROM:TO"),
    ("follow HAMMER --along mean=1e400:1e401", "mean = inf"),
    ("follow HAMMER --along mean=0.6:0.7 --curve flip --over restitution=", "'restitution=': expected NAME=FROM:TO"),
    ("follow HAMMER --along mean=0.5:inf", "inf"),
    ("follow HAMMER --along mean=nan:1", "nan"),
    ("follow HAMMER --along =0.5:1", "NAME="),
    ("follow HAMMER --along kappa=1:2", "square load"),
    ("follow HAMMER --along sharpness=1:2", "sharpness"),
    ("follow HAMMER --along mean=0.5N:1N", "unit of the case"),
    ("follow HAMMER --along mean=0.5:1 --switch 17", "switch = 17"),
    ("follow PULLED --along mean=-1:1", "the load does not push"),
]


@pytest.fixture
def cases(tmp_path: Path) -> dict[str, str]:
    for name, text in CASES.items():
        (tmp_path / f"{name}.toml").write_text(text, encoding="utf-8")
    return {name: str(tmp_path / f"{name}.toml") for name in CASES}


def asked(line: str, cases: dict[str, str]) -> list[str]:
    return [cases.get(word, word) for word in line.split()]


@pytest.mark.parametrize(("line", "told"), REFUSED, ids=[line for line, _ in REFUSED])
def test_what_is_refused(line: str, told: str, cases: dict[str, str], capsys: pytest.CaptureFixture[str]) -> None:
    assert main(asked(line, cases)) == 2
    out, err = capsys.readouterr()
    assert told in err
    assert not out
    assert "Traceback" not in err


@pytest.mark.parametrize(
    ("line", "ends"),
    [
        ("follow HAMMER --along mean=0.665:0.66500000001 --orbit 1/1", ["limit", "limit"]),
        ("follow HAMMER --along d=-1:0.01 --orbit 1/1", ["parameter_end", "limit"]),
        ("follow FULL --along restitution=0.9:2 --orbit 1/1", ["limit", "parameter_end"]),
    ],
)
def test_ranges_that_end_at_once_have_ends_that_are_named(
    line: str, ends: list[str], cases: dict[str, str], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([*asked(line, cases), "--json"]) == 0
    points = json.loads(capsys.readouterr().out)["points"]
    assert sorted(point["type"] for point in (points[0], points[-1])) == sorted(ends)


def test_the_largest_labels_are_searched(cases: dict[str, str], capsys: pytest.CaptureFixture[str]) -> None:
    for label in ("64/1", "1/256", "64/256"):
        assert main(["orbits", cases["HAMMER"], "--label", label, "--tries", "2", "--motions", "2"]) == 0
        assert "0 orbits" in capsys.readouterr().out


def test_modes_of_free_amplitude_are_named(cases: dict[str, str], capsys: pytest.CaptureFixture[str]) -> None:
    """ω_1 = 2 swings twice in a load period, ω_2 and ω_3 four and six times: a free amplitude of each."""
    assert main(["orbits", cases["RINGING"]]) == 0
    told = capsys.readouterr().out
    assert "3 elastic modes, but for the free amplitude of modes 1, 2, 3." in told
    assert "of elastic modes 1, 2, 3, which come back" in told
    assert main(["orbits", cases["RINGING"], "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["resonant_modes"] == [1, 2, 3]


@pytest.mark.parametrize("n", [1, 2])
def test_full_rebound_without_drag_has_an_answer(n: int, cases: dict[str, str], capsys) -> None:
    assert main(["orbits", cases["FULL"], "--label", f"2/{n}", "--json", "--tries", "50"]) == 0
    answer = json.loads(capsys.readouterr().out)
    assert not answer["complete"]
    assert all(orbit["admissible"] for orbit in answer["orbits"])


# -- phases -----------------------------------------------------------------------------------------------------------


def test_phases_say_which_orbit_whatever_impact_comes_first() -> None:
    system = System(s=5.0, d=0.0, restitution=0.5, load=Load.harmonic(0.665, 1.0))
    wanted = orbits(system, 2, modes=0).orbits[1]
    for phases in (wanted.phases, wanted.phases[::-1], wanted.phases + 0.2, wanted.phases - 4.0 * math.pi):
        assert orbit_at_phases(system, "", phases.tolist(), (2, 1), 0).times == pytest.approx(wanted.times, abs=1e-9)


def test_flights_of_more_than_a_load_period_are_found_by_phases() -> None:
    """z=2/3 of a stiff bar with full rebound: 8.7 rad lie between its two impacts."""
    hammer = random_hammer(20)
    found = orbit_at_phases(hammer.system, "", [2.28, 6.0966], (2, 3), 8)
    assert found.flight_times.max() > 2.0 * math.pi
    assert found.phases == pytest.approx([2.28, 6.0966], abs=0.1)
    assert np.all(found.speeds > 0.0)


def test_more_turns_than_the_label_has_are_refused() -> None:
    system = System(s=5.0, d=0.0, restitution=0.5, load=Load.harmonic(0.665, 1.0))
    with pytest.raises(ParameterError, match="in order of time"):
        orbit_at_phases(system, "", [3.0, 2.0, 1.0], (3, 1), 0)
