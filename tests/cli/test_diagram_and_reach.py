"""``percuss diagram`` and ``percuss steady --reach`` as a person would use them."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import pytest

from percuss.cli import main
from percuss.explore.jobs.progress import JobProgress

HAMMER = """
[system]
s = 5.0
d = 0.0
restitution = 0.5
[load]
kind = "harmonic"
mean = 0.7
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
mean = "8 kN"
amplitude = "10 kN"
frequency = "50 Hz"
[simulation]
modes = 0
"""

FEW = ["--label", "1/1", "--searched", "1", "--switch", "0", "--starts", "2", "--runs", "1", "--workers", "1"]


@pytest.fixture
def hammer(tmp_path: Path) -> str:
    path = tmp_path / "hammer.toml"
    path.write_text(HAMMER, encoding="utf-8")
    return str(path)


@pytest.fixture
def in_si(tmp_path: Path) -> str:
    path = tmp_path / "si.toml"
    path.write_text(IN_SI, encoding="utf-8")
    return str(path)


def test_a_diagram_with_all_its_files(in_si: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    files = {name: tmp_path / f"d.{name}" for name in ("csv", "nc", "svg", "zarr")}
    asked = ["--csv", str(files["csv"]), "--netcdf", str(files["nc"]), "--plot", str(files["svg"])]
    asked += ["-o", str(files["zarr"]), "--show", "phase,speed,energy"]
    assert main(["diagram", in_si, "--along", "load.mean=6 kN:10 kN:5", *FEW, *asked]) == 0
    told = capsys.readouterr().out
    assert "load.mean from 6 to 10 kN, 0 elastic modes" in told
    assert "fold" in told
    with files["csv"].open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert {row["source"] for row in rows} == {"simulated", "branch"}
    scale = [float(row["speed_m_s [m/s]"]) / float(row["speed"]) for row in rows if float(row["speed"]) > 0.0]
    assert scale == pytest.approx([scale[0]] * len(scale), rel=1e-12)
    assert "m/s" in files["svg"].read_text(encoding="utf-8")
    assert files["nc"].stat().st_size > 0
    again = tmp_path / "again.csv"
    assert main(["export", str(files["zarr"]), "-o", str(again)]) == 0
    assert again.read_text(encoding="utf-8") == files["csv"].read_text(encoding="utf-8")


def test_a_diagram_as_json(hammer: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["diagram", hammer, "--along", "mean=0.6:1:3", *FEW, "--json"]) == 0
    answer = json.loads(capsys.readouterr().out)
    assert answer["values"] == [0.6, 0.8, 1.0]
    assert {one["value"] for one in answer["settled"]} == {0.6, 0.8, 1.0}
    (branch,) = (one for one in answer["branches"] if one["label"] == "z=1/1")
    fold = next(point for point in branch["points"] if point["type"] == "fold")
    assert fold["value"] == pytest.approx(0.954929658551, abs=1e-10)
    assert len(branch["branch"]["phases"]) == len(branch["branch"]["value"]) == len(branch["branch"]["energy"])
    assert branch["branch"]["energy_J"] is None


def test_ctrl_c_keeps_what_was_found(
    hammer: str, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """The answer, the picture and the archive are of the part; the archive goes on."""

    def stopped(self: object, progress: JobProgress) -> bool:
        return progress.done >= 2

    picture, archive = tmp_path / "part.svg", tmp_path / "d.zarr"
    asked = ["diagram", hammer, "--along", "mean=0.6:1:3", *FEW, "-o", str(archive)]
    with monkeypatch.context() as patched:
        patched.setattr("percuss.cli.long_commands.JobWatch.__call__", stopped)
        assert main([*asked, "--plot", str(picture)]) == 130
    told = capsys.readouterr()
    assert "the diagram is not whole" in told.out
    assert "interrupted after" in told.err
    assert picture.exists()
    assert main([*asked, "--resume"]) == 0
    assert "not whole" not in capsys.readouterr().out


@pytest.mark.parametrize(
    ("asked", "told"),
    [
        (["--along", "mean=0.6"], "mean"),
        (["--along", "nothing=0:1"], "nothing"),
        (["--along", "mean=0.6:1", "--label", "2"], "--label"),
        (["--along", "mean=0.6:1", "--show", "colour"], "colour"),
        (["--along", "mean=0.6:1", "--netcdf", "x.csv"], ".nc"),
        (["--along", "mean=0.6:1", "--csv", "x.nc"], ".csv"),
        (["--along", "mean=0.6:1", "--plot", "x.txt"], ".png"),
        (["--along", "mean=0.6:1", "--starts", "0", "--runs", "0", "--searched", "0"], "searched"),
        (["--along", "mean=5 kN:6 kN"], "mean"),
    ],
)
def test_what_cannot_be_asked_is_told(
    hammer: str, asked: list[str], told: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["diagram", hammer, *asked]) == 2
    assert told in capsys.readouterr().err


def test_a_machine_that_switches_itself_has_no_diagram(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["diagram", "valve-breaker", "--along", "pressure=100 bar:200 bar"]) == 2
    assert "keeps time by itself" in capsys.readouterr().err


# -- how far --


def test_how_far_the_load_may_move(in_si: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """From the flip at 0.654954 of the amplitude to the fold at 3/π of it."""
    report = tmp_path / "report.html"
    asked = ["steady", in_si, "--starts", "0", "--modes", "0", "--reach-of", "load.mean", "--report", str(report)]
    assert main(asked) == 0
    told = capsys.readouterr().out
    sentence = (
        "8 kN: down to 6.55 kN, where the period doubles (then z=2/2); up to 9.549 kN, where the motion ceases to"
    )
    assert sentence in told
    assert sentence in report.read_text(encoding="utf-8")


def test_how_far_as_json(hammer: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["steady", hammer, "--modes", "0", "--reach-of", "mean,restitution", "--json"]) == 0
    mean, restitution = json.loads(capsys.readouterr().out)["reach"]
    assert mean["below"]["type"] == "flip"
    assert mean["below"]["value"] == pytest.approx(0.654954465051, abs=1e-10)
    assert mean["above"]["then"] == "chatter/1"
    assert restitution["below"]["value"] < 0.5 < restitution["above"]["value"]


def test_without_a_stable_motion_there_is_nothing_to_follow(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "hammer.toml"
    path.write_text(HAMMER.replace("mean = 0.7", "mean = 0.5"), encoding="utf-8")
    assert main(["steady", str(path), "--starts", "0", "--modes", "0", "--reach"]) == 0
    assert "no stable motion to follow" in capsys.readouterr().out


def test_an_unknown_parameter_is_refused(hammer: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["steady", hammer, "--starts", "0", "--reach-of", "colour"]) == 2
    assert "colour" in capsys.readouterr().err
