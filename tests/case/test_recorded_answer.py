"""A case with the record of a machine that switches its own valve: what a clock says of it, and what the valve does."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from machine_records import MASS, breaker, recorded_machine
from percuss import plot
from percuss.case import Case, recorded_answer, steady_answer
from percuss.case.answers.heading import CLOCKED
from percuss.case.answers.recorded_answer import recorded_headline
from percuss.case.answers.steady_report import summary_of
from percuss.cli import main
from percuss.model import Kept, Valve
from percuss.steady import Interval

PISTON = f"""
[bar]
length = "1 m"
diameter = "120 mm"
density = "{MASS / (np.pi * 0.06**2):.8f} kg/m^3"
youngs_modulus = "206 GPa"
drag = "{0.5 * MASS:.6f} N*s/m^2"
[contact]
restitution = 0.15
strain = "reversed"
"""


def saved(folder: Path, valve: Valve) -> Path:
    """The record of the breaker under a valve, the times of its blows, and a case of them; returns the case file."""
    told = recorded_machine(valve, Kept(0.15), cycles=10, noise=0.002)
    rows = (f"{t:.6f},{MASS * p:.2f}\n" for t, p in zip(told.time, told.force, strict=True))
    (folder / "force.csv").write_text("time [s],force [N]\n" + "".join(rows), encoding="utf-8")
    (folder / "blows.txt").write_text("".join(f"{t:.7f}\n" for t in told.blows[1:-1]), encoding="utf-8")
    file = folder / "breaker.toml"
    file.write_text(f'{PISTON}[load]\nkind = "history"\nfile = "force.csv"\n', encoding="utf-8")
    return file


BEFORE, AT, LATE = breaker(0.0, 10e-3), breaker(), breaker(3.5e-3)


@pytest.mark.parametrize(
    ("valve", "because", "speed", "energy"),
    [(BEFORE, "unstable", 8.866, 3490.0), (AT, "no motion", 9.192, 3751.0), (LATE, "unstable", 9.058, 3643.0)],
)
def test_a_machine_that_runs_has_another_verdict_under_a_clock(tmp_path, valve, because, speed, energy) -> None:
    """The valve that returns before the blow, at it and 3 ms after it: one motion, and what a clock makes of it."""
    file = saved(tmp_path, valve)
    case = Case.read(file)
    answer = steady_answer(case)
    blows = np.loadtxt(tmp_path / "blows.txt")
    read = recorded_answer(case, 0, blows=blows)
    if valve is AT:  # the tip of v_f, which a record with noise passes or not
        assert answer.clocked in ("no motion", "near the fold", "unstable")
        assert abs(answer.periods[0].states.level / answer.periods[0].states.level_max - 1.0) < 0.02
    else:
        assert answer.clocked == because
    assert CLOCKED in summary_of(answer).text
    assert answer.to_json_dict()["clocked"]["note"] == CLOCKED
    assert read.read.speed == pytest.approx(speed, rel=0.005)
    assert read.runs
    assert read.answer.cycle.stable
    assert abs(read.answer.cycle.multiplier) < 0.05
    assert 0.5 * MASS * read.answer.cycle.blow_speed**2 == pytest.approx(energy, rel=0.02)
    if valve is LATE:
        assert read.clock.exists
        assert not read.clock.stable
        assert read.clock.multiplier == pytest.approx(3.3, abs=0.3)
        assert "Under a clock: unstable (beyond the fold);" in recorded_headline(read)
        assert "with the valve: stable, and a disturbance settles to 1 % in 1 cycle." in recorded_headline(read)
        assert any(
            one.orbit.admissible and one.stability.stable for one in answer.periods[0].orbits
        )  # not the machine's
    if valve is BEFORE:
        assert read.clock.exists
        assert read.clock.multiplier.real < 0.0


def test_the_picture_of_a_record_shows_the_record(tmp_path) -> None:
    """Every sample in its cycle, over the force of the machine and over the harmonics, and what they leave."""
    case = Case.read(saved(tmp_path, LATE))
    force = case.recorded_force[1]
    read = recorded_answer(case, 0, blows=np.loadtxt(tmp_path / "blows.txt"))
    steady = steady_answer(case)
    for answer, picture, cycle in ((read, plot.machine(read), 1e3 / 8.36), (steady, plot.steady(steady), 2.0 * np.pi)):
        (line,) = [one for axes in picture.axes for one in axes.lines if str(one.get_label()).startswith("measured")]
        left = next(axes for axes in picture.axes if "residual" in axes.get_ylabel()).lines[0]
        drawn = np.isfinite(line.get_ydata())
        assert line.get_ydata()[drawn] == pytest.approx(force / 1e3, rel=1e-3)
        at = line.get_xdata()[drawn]
        assert np.count_nonzero(np.diff(at) < 0.0) == np.count_nonzero(~drawn) == 10
        assert np.ptp(at) == pytest.approx(cycle, rel=0.005)
        model = line.get_ydata()[drawn] - left.get_ydata()[drawn]
        assert np.array_equal(left.get_xdata(), line.get_xdata(), equal_nan=True)
        assert answer.measured.off == pytest.approx(np.std(force / 1e3 - model) / np.std(force / 1e3), rel=1e-3)
    assert read.measured.off < 0.05 < steady.measured.off


def test_the_command_reads_a_record(tmp_path, capsys: pytest.CaptureFixture[str]) -> None:
    file, blows = saved(tmp_path, LATE), str(tmp_path / "blows.txt")
    assert main(["machine", str(file), "--modes", "0", "--blows", blows, "--longest-delay", "20 ms"]) == 0
    text = capsys.readouterr().out
    for row in ("From the record", "Switches of the force", "under a clock", "R = 0.1", "8 cycles, one by one"):
        assert row in text, row
    assert main(["machine", str(file), "--modes", "0", "--blows", blows, "--json", "--longest-delay", "20 ms"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["clock"]["exists"] is True and told["clock"]["stable"] is False
    found = told["recorded"]
    power = next(one for one in found["switches"] if one["to"] == "power")
    assert power["behind"][0] == pytest.approx(0.1444, abs=5e-4)
    assert power["delay"][2] == pytest.approx(20e-3)
    assert found["least_delays"]["runs"] is True
    assert told["outcome"] == "runs"


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (["--blow", "3 mm"], "time"),
        (["--blows", "none.txt"], "none.txt"),
        (["--longest-delay", "-1 ms"], "greater than"),
    ],
)
def test_what_is_mistyped_of_a_record(tmp_path, capsys, options, says) -> None:
    file = saved(tmp_path, LATE)
    assert main(["machine", str(file), *options]) == 2
    assert says in capsys.readouterr().err


def _damaged(tmp_path: Path, how: str) -> Path:
    """A case of a record that drifts, or is cut off: as one force, or in one of two channels."""
    file = saved(tmp_path, BEFORE)
    time, force = np.loadtxt(tmp_path / "force.csv", delimiter=",", skiprows=1).T
    span, rear, front = np.ptp(force), force, np.zeros_like(force)
    if how == "drift":
        rear = force + 0.8 * span * (time - time[0]) / np.ptp(time)
    elif how == "clipped":
        rear = np.clip(force, None, force.max() - 0.15 * span)
    else:  # the difference of the channels hides it
        front = 0.05 * span * (2.0 + np.sin(900.0 * time))
        rear = np.clip(force, None, force.max() - 0.15 * span) if how == "rear" else force + front
        front = np.clip(front, None, 0.12 * span) if how == "front" else front
    rows = (f"{t:.6f},{r:.2f},{f:.2f}\n" for t, r, f in zip(time, rear, front, strict=True))
    (tmp_path / "force.csv").write_text("time [s],rear [N],front [N]\n" + "".join(rows), encoding="utf-8")
    two = 'opposing_column = "front [N]"\n' if how in ("rear", "front") else ""
    file.write_text(
        f'{PISTON}[load]\nkind = "history"\nfile = "force.csv"\ncolumn = "rear [N]"\n{two}', encoding="utf-8"
    )
    return file


@pytest.mark.parametrize(
    ("how", "said"),
    [
        ("drift", "the mean drifts by"),
        ("clipped", "of the samples lie exactly at the highest value"),
        ("rear", "of the samples of column rear [N] lie exactly at the highest value"),
        ("front", "of the samples of column front [N] lie exactly at the highest value"),
    ],
)
def test_the_machine_is_told_with_every_warning_about_its_record(tmp_path, capsys, how: str, said: str) -> None:
    file = _damaged(tmp_path, how)
    history = steady_answer(Case.read(file)).history
    assert history is not None and any(said in warning for warning in history.warnings)
    main(["machine", str(file), "--modes", "0", "--json"])
    told = json.loads(capsys.readouterr().out)["warnings"]
    assert set(history.warnings) <= set(told)
    main(["machine", str(file), "--modes", "0"])
    report = " ".join(capsys.readouterr().out.replace("│", " ").split())
    assert all(" ".join(warning.split()) in report for warning in history.warnings)


def test_a_reading_that_misses_the_record_or_cannot_be_is_doubted_first(tmp_path, capsys) -> None:
    file, blows = saved(tmp_path, AT), np.loadtxt(tmp_path / "blows.txt")
    good = recorded_answer(Case.read(file), 0, blows=blows)
    assert (
        good.doubts == () and max(map(abs, good.off.values())) < 0.01 and "Do not trust" not in recorded_headline(good)
    )
    time, force = np.loadtxt(tmp_path / "force.csv", delimiter=",", skiprows=1).T
    for column, values, words in (
        ("force [N]", force + 0.5 * np.ptp(force), "mean force"),
        ("front [bar]", 1e-2 * force, "no pressure is below −1 bar"),
    ):
        rows = (f"{t:.6f},{p:.4f}\n" for t, p in zip(time, values, strict=True))
        (tmp_path / "force.csv").write_text(f"time [s],{column}\n" + "".join(rows), encoding="utf-8")
        area = 'area = "10 cm^2"\n' if "bar" in column else ""
        file.write_text(f'{PISTON}[load]\nkind = "history"\nfile = "force.csv"\n{area}', encoding="utf-8")
        main(["machine", str(file), "--modes", "0", "--json"])
        told = json.loads(capsys.readouterr().out)
        assert any(words in one for one in told["warnings"]), (words, told["warnings"])
    impossible = replace(good.read, restitution=Interval(1.2, 1.1, 1.3), stiffness=Interval(1e4, 9e3, 1.1e4))
    doubted = replace(good, read=impossible)
    assert ["R = 1.2" in doubted.doubts[0], "no gas does" in doubted.doubts[1]] == [True, True]
    assert recorded_headline(doubted).count("Do not trust it") == 2


def test_a_reading_tells_what_the_passage_to_a_recorded_pressure_takes(tmp_path, capsys) -> None:
    """Beside ζ (A v)² of the motion that the recorded force gives by itself; another loss on the way out."""
    file, blows, area, zeta = saved(tmp_path, AT), np.loadtxt(tmp_path / "blows.txt"), 20e-4, 10e5 / (500 / 6e4) ** 2
    time, force = np.loadtxt(tmp_path / "force.csv", delimiter=",", skiprows=1).T
    rows = (f"{t:.6f},{p:.5f}\n" for t, p in zip(time, force / area / 1e5, strict=True))
    (tmp_path / "force.csv").write_text("time [s],line [bar]\n" + "".join(rows), encoding="utf-8")
    load = '[load]\nkind = "history"\nfile = "force.csv"\narea = "20 cm^2"\n'
    passage = 'passage = {drop = "10 bar", at = "500 l/min", out = {drop = "5 bar", at = "500 l/min"}}\n'
    file.write_text(PISTON + load + passage, encoding="utf-8")
    assert main(["machine", str(file), "--modes", "0", "--json", "--blows", str(tmp_path / "blows.txt")]) == 0
    told = json.loads(capsys.readouterr().out)["recorded"]
    (one,) = told["passages"]
    inside = (time > blows[3]) & (time < blows[4])
    push, v = force[inside], np.zeros(inside.sum())
    v[0], step = -0.15 * told["speed"], time[1] - time[0]
    for k in range(1, v.size):
        v[k] = v[k - 1] + step * (push[k - 1] / MASS - 0.5 * v[k - 1])
    drop = np.where(v > 0.0, zeta, 0.5 * zeta) * (area * v) ** 2
    assert one["name"] == "passage"
    assert one["drop"] == pytest.approx(zeta * (area * told["speed"]) ** 2, rel=0.02)
    assert one["at"] == pytest.approx(area * told["speed"], rel=0.01)
    assert one["force_share"] == pytest.approx(area * drop.sum() / np.abs(push).sum(), rel=0.03)
    assert one["energy"] == pytest.approx(float(drop @ np.abs(area * v)) * step, rel=0.04)
    assert one["energy_share"] == pytest.approx(one["energy"] / (0.5 * MASS * told["speed"] ** 2), rel=0.02)
    main(["machine", str(file), "--modes", "0"])
    report = " ".join(capsys.readouterr().out.replace("│", " ").split())
    assert "of the force in the mean, up to" in report
    assert "bar at 1" in report
    for wrong, words in (
        (
            load.replace('area = "20 cm^2"\n', 'column = "line [bar]"\nunit = "N"\n') + passage,
            "load.passage: expected a passage to an area",
        ),
        (load + 'passage = {drop = "10 bar"}\n', "load.passage.at"),
        (load + 'opposing_passage = {drop = "1 bar", at = "1 l/min"}\n', "load.opposing_passage"),
    ):
        file.write_text(PISTON + wrong, encoding="utf-8")
        assert main(["machine", str(file)]) == 2
        assert words in capsys.readouterr().err
