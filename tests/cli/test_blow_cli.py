"""``percuss blow``: published and independently computed blows by the command: report, files, the best blow."""

from __future__ import annotations

import csv
import json
import signal
from pathlib import Path

import numpy as np
import pytest

from cli_cases import WAVES
from percuss.case import Case, Span, best_answer, blow_answer, load_case, machine_answer
from percuss.case.answers.blows.transfer import LEFT_OUT
from percuss.case.parameters.case_family import CaseFamily
from percuss.cli.long_commands import JobWatch
from percuss.errors import CaseError, ParameterError

ST_VENANT = """
[bar]
length = "1 m"
area = "3.14e-4 m^2"
youngs_modulus = "210 GPa"
density = "7800 kg/m^3"
[blow]
velocity = "0.1 m/s"
"""


@pytest.fixture
def struck(percuss):
    """`percuss blow` of the text of a case."""

    def command(text, *arguments):
        Path("struck.toml").write_text(text, encoding="utf-8")
        return percuss("blow", "struck.toml", *arguments)

    return command


def test_a_bar_on_a_wall_is_that_of_st_venant(struck):
    found = struck(ST_VENANT, "--json").json
    assert found["contact_duration"] == pytest.approx(3.854496446637726e-4, rel=1e-12)
    assert found["contacts"][0][3] == pytest.approx(1270.82747846, rel=1e-11)
    assert found["effective_restitution"] == pytest.approx(1.0, abs=1e-12)
    done = struck(ST_VENANT)
    done.told("gives nothing to the wall: R = 1", "the case has no [tool]: the bar strikes a rigid wall")
    done.told("In closed form", "the waves give 1.271 kN")


def test_fatigue_tells_what_governs_first_and_what_it_leaves_out(struck):
    case = (
        ST_VENANT.replace("0.1 m/s", "20 m/s")
        + '[tool]\nsections = [{length = "3 m", diameter = "20 mm"}]\nend = "free"\n'
    )
    done = struck(case, "--fatigue")
    done.told("Governs: rod 0, ", "the case has no [steel]: 42CrMo4 QT is assumed", LEFT_OUT, "Fatigue of the sections")
    assert done.out.splitlines()[2].startswith("Governs: ")
    struck(case, "--fatigue", "--report", "blow.html").told("report: blow.html")
    page = Path("blow.html").read_text(encoding="utf-8")
    assert "Governs: rod 0, " in page and "Fatigue of the sections" in page and "safety factor" in page
    struck(case, "--best", "peak-stress", "--vary", "length=0.1:1m", "--fatigue").refused("--fatigue")


def test_a_dimensionless_case_has_no_fatigue(struck):
    plain = "[system]\ns = 20.0\nd = 0.0\nrestitution = 0.5\n[tool]\nimpedance = 40.0\n[blow]\nvelocity = 0.1\n"
    struck(plain, "--fatigue").refused("struck.toml: a dimensionless case has no stresses, and so no fatigue")
    struck(plain + "[steel]\nslope = 5\n").refused("a dimensionless case has no stresses, and so no fatigue")


def test_the_report_tells_where_the_energy_went_and_what_formulas_say(percuss):
    done = percuss("blow", "blow.toml")
    done.told("A blow of 200 J at 10 m/s puts", "into the rock")
    done.told("2(1 − γ)(1 − e^−β)²/β = 61.09 % at β = 1.256; the waves give 61.09 %")
    blow = blow_answer(Case.from_text(WAVES)).blow
    told = percuss("blow", "blow.toml", "--json").json
    figures = {key for key, value in told.items() if isinstance(value, float) and hasattr(blow, key)}
    assert len(figures) > 15 and all(told[key] == getattr(blow, key) for key in figures)
    parts = blow.rigid_energy_after + blow.vibration_energy_after + blow.work_through_face
    assert parts == pytest.approx(blow.energy_before, rel=1e-12)


def test_the_speed_of_a_case_without_one_is_that_of_its_steady_motion():
    bare = load_case("stepped-drifter").varied({"blow.velocity": None})
    by_speed, whole = blow_answer(bare, until=3e-4), blow_answer(bare, until=3e-4, whole_field=True)
    assert "steady motion" in by_speed.speed
    before = by_speed.blow.mean_velocity_before
    assert whole.blow.mean_velocity_before == pytest.approx(before, rel=1e-9)  # the mean of the field
    assert whole.blow.energy_before > by_speed.blow.energy_before  # the forced strain and the ringing are in it
    assert whole.blow.energy_before == pytest.approx(by_speed.blow.energy_before, rel=0.05)
    assert whole.blow.energy_error < 1e-9


def test_waves_are_saved_as_netcdf_table_and_picture(percuss):
    xarray = pytest.importorskip("xarray")
    made = ("-o", "blow.nc", "--csv", "blow.csv", "--plot", "blow.png")
    percuss("blow", "blow.toml", *made, "--gauge", "1 m").told(*made[1::2])
    with xarray.open_dataset("blow.nc", engine="h5netcdf") as found:
        assert found["face_force"].max() == pytest.approx(200e3)
        assert json.loads(found.attrs["answer"])["gauge"]["place"] == 1.0
        arrival = float(found["time"][np.argmax(found["incident"].values > 1.0)])
        assert arrival == pytest.approx(1.0 / 5000.0, abs=1e-6)
    with open("blow.csv", encoding="utf-8") as table:
        rows = list(csv.DictReader(table))
    assert len(rows) == 4001 and "face_force [N]" in rows[0]
    assert Path("blow.png").stat().st_size > 20_000


def test_a_case_without_speed_and_motion_says_what_it_needs(struck):
    struck(WAVES.replace('velocity = "10 m/s"', "")).refused("or --velocity", "[load]")


PUMP = {"load.supply.flow": "133 l/min", "load.supply.accumulator": "2.5 cm^3/bar"}


@pytest.mark.parametrize(("machine", "more"), [("valve-drifter", {}), ("valve-breaker", {}), ("valve-breaker", PUMP)])
def test_the_blow_of_a_machine_has_the_speed_of_its_own_cycle(struck, machine, more):
    """That of the rigid piston; in a sweep, too. What does not run has none, and no field of a motion under a clock."""
    case = load_case(machine).varied({"blow.velocity": None, **more})
    told, cycle = struck(case.to_toml(), "--json").json, machine_answer(case, modes=0).motion.cycle
    speed = cycle.blow_speed * case.machine().speed_scale
    assert told["mean_velocity_before"] == pytest.approx(speed, rel=1e-12) and "own cycle" in told["velocity_from"]
    swept = CaseFamily(case, {"rock.stiffness": "kN/mm"}).blow({"rock.stiffness": 300.0})
    assert swept.mean_velocity_before == pytest.approx(speed, rel=1e-12)
    with pytest.raises(CaseError, match="leave the field out"):
        blow_answer(case, whole_field=True)
    with pytest.raises(CaseError, match="one blow in a cycle"):
        blow_answer(case.varied({"load.ports[1].delay": "40 ms"}))


def test_a_dimensionless_bar_is_told_in_its_scales(struck):
    load = '[load]\nkind = "harmonic"\nmean = 0.9\namplitude = 1.0\n'
    text = f"[system]\ns = 20.0\nd = 0.0\nrestitution = 0.5\n{load}[tool]\nimpedance = 3.0\n"
    found = struck(text, "--velocity", "1", "--json").json
    assert found["units"] == "dimensionless"
    assert found["effective_restitution"] == pytest.approx(0.5, abs=1e-12)  # (3 − 1)/(3 + 1)
    assert found["contact_duration"] == pytest.approx(0.1, rel=1e-12)  # 2/s
    struck(text, "--velocity", "1", "--plot", "blow.png").told("R = (Z₂ − Z₁)/(Z₂ + Z₁) = 0.5; the waves give 0.5")


# -- beside a measurement ---------------------------------------------------------------------------------------------


def gauge_file():
    """What a gauge at 1 m of the case would record, 0.2 ms late, in strain with compression negative."""
    blow = blow_answer(Case.from_text(WAVES), gauge=1.0)
    time = np.arange(0.0, blow.blow.until, 1e-6)
    force = blow.waves.incident.at(time) + blow.waves.reflected.at(time)
    rows = [f"{t + 2e-4:.7f},{-1.03e6 * f / (1e-3 * 200e9):.4f}" for t, f in zip(time, force, strict=True)]
    Path("gauge.csv").write_text("t [s],strain\n" + "\n".join(rows), encoding="utf-8")


def test_a_record_is_laid_over_the_blow(percuss):
    gauge_file()
    percuss("blow", "blow.toml", "--measured", "gauge.csv").refused("no unit of strain, stress or force", "give --unit")
    options = ("blow", "blow.toml", "--gauge", "1 m", "--measured", "gauge.csv", "--unit", "µm/m")
    found = percuss(*options, "--json").json["measured"]
    keys = {"file", "quantity", "sign", "shift", "zero", "scale", "residual", "residual_scaled", "overlap", "notes"}
    assert set(found) == keys
    assert found["quantity"] == "strain" and found["sign"] == -1
    assert found["shift"] == pytest.approx(-2e-4, abs=6e-7)
    assert found["scale"] == pytest.approx(1.03, abs=5e-3)
    done = percuss(*options, "--plot", "blow.png")
    done.told("Measured at the gauge", "compression negative", "times the computed force")


# -- the best blow ----------------------------------------------------------------------------------------------------

SEARCH = ("blow", "laboratory-striker", "--best", "efficiency", "--vary", "bar.length=50:400mm", "--blows", "40")


def test_the_saved_case_gives_what_was_told(percuss):
    told = percuss(*SEARCH, "--below", "300MPa", "--json", "-o", "best.toml", "--plot", "best.png").json
    best = Case.read("best.toml")
    blow = blow_answer(best).blow
    assert told["allowed"] and Path("best.png").read_bytes()[:4] == b"\x89PNG"
    assert told["figures"]["rock_efficiency"]["best"] == blow.efficiency >= told["figures"]["rock_efficiency"]["own"]
    assert told["figures"]["peak_stress"]["best"] <= 300e6
    assert best.tables.bar.length == f"{told['varied'][0]['best']!r} mm"
    assert told["varied"][0]["own"] == 200.0 and told["best_case"]["bar"]["length"] == best.tables.bar.length
    done = percuss(*SEARCH)
    done.told("The best blow found: efficiency", "the case as it is", "bar.length", "peak stress", "MPa", "seed 0")
    percuss(*SEARCH, "--below", "1 kPa").told("No blow within these ranges")


def test_a_recording_is_found_from_another_folder(percuss):
    assert percuss("new", "hydraulic-drifter", "-o", "drifter.toml").code == 0
    Path("found").mkdir()
    search = ("--best", "efficiency", "--vary", "bar.length=300:400mm", "--blows", "20")
    assert percuss("blow", "drifter.toml", *search, "-o", "found/best.toml").code == 0
    own, best = Case.read("drifter.toml"), Case.read("found/best.toml")
    assert best.tables.load.file == "../drifter_pressure.csv"
    assert best.load().coefficients == pytest.approx(own.load().coefficients)


def test_ctrl_c_ends_with_the_best_so_far(percuss, monkeypatch):
    heard, share = [], JobWatch.share

    def told(self, *progress):
        heard.append(progress)
        if len(heard) == 12:
            signal.raise_signal(signal.SIGINT)
        return share(self, *progress)

    monkeypatch.setattr("percuss.cli.long_commands.JobWatch.share", told)
    done = percuss(*SEARCH, "--json", "-o", "best.toml")
    found = done.json
    assert done.code == 130 and "interrupted: the best of 11 blows so far" in done.err and len(heard) == 12
    assert found["complete"] is False and found["blows"] == 11
    best = blow_answer(Case.read("best.toml")).blow
    assert best.efficiency == found["figures"]["rock_efficiency"]["best"] >= found["figures"]["rock_efficiency"]["own"]


def test_a_design_is_saved_and_gone_on_from(percuss, monkeypatch):
    search = ["--vary", "load.ports[0].behind=8:24mm", "--want", "blow_rate=62..66Hz", "--modes", "0"]
    search += ["--hammers", "60"]
    done = percuss("design", "valve-drifter", "--most", "power", *search, "-o", "best.toml", "--report", "best.html")
    done.told("The best hammer found: percussive power", "at its limits: blow_rate", "62 Hz to 66 Hz", "binds")
    first = percuss("design", "valve-drifter", "--most", "power", *search, "--json").json
    heard = iter([True, False, True])
    monkeypatch.setattr("percuss.cli.long_commands.JobWatch.share", lambda *_: next(heard))
    none = percuss("design", "best.toml", *search)
    assert none.code == 130 and "nothing has been found yet" in none.err
    cut = percuss("design", "best.toml", "--most", "power", *search, "--json")
    assert cut.code == 130 and "interrupted: the best of 1 hammers so far" in cut.err
    assert cut.json["varied"][0]["best"] == first["varied"][0]["best"] and cut.json["allowed"]


def test_the_plane_about_the_best_is_drawn_and_its_end_loses_nothing(percuss, monkeypatch):
    asked = ["design", "valve-drifter", "--vary", "load.ports[0].behind=8:24mm", "--vary", "bar.diameter=46:52mm"]
    asked += ["--most", "power", "--modes", "0", "--hammers", "20", "--plane", "plane.svg"]
    percuss(*asked).told("The best hammer found", "plane: plane.svg")
    assert "</svg>" in Path("plane.svg").read_text()
    monkeypatch.setattr("percuss.cli.long_commands.JobWatch.share", lambda _, share, told: "of 625" in told)
    cut = percuss(*asked)
    assert cut.code == 130 and "The best hammer found" in cut.out and "the plane is left out" in cut.err
    assert percuss(*asked[:4], "--plane", "plane.svg").code == 2


def test_a_range_above_what_the_case_has(percuss):
    """The case itself is not tried, and may be better."""
    found = percuss(*SEARCH[:5], "bar.length=30:60mm", "--blows", "30", "--json").json
    assert found["varied"][0]["own"] == 200.0 and 30.0 <= found["varied"][0]["best"] <= 60.0
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
