"""What the answers say: ends of starts, drag, power, motions that do not strike, loads that switch as a valve does."""

from __future__ import annotations

import json
import math
import re
from collections import Counter
from typing import Any

import numpy as np
import pytest

from percuss import Bar, Kept, Load, System, si_report, steady_states
from percuss.case import Case, load_case, machine_answer, steady_answer
from percuss.case.answers.heading import CLOCKED, clock_in_short, clock_note, clocked_because
from percuss.case.answers.machine_answer import machine_report
from percuss.case.answers.steady_answer import End, Ends, ends_of
from percuss.case.answers.steady_report import ends_section, ends_sentence, steady_report
from percuss.cli import main
from percuss.model.machine import switching_of
from percuss.steady import drag_of, greatest_drag
from percuss.steady.phases import level

PLAIN = """
[system]
s = 20.0
d = {d}
restitution = {r}
[load]
kind = "harmonic"
mean = {mean}
amplitude = 1.0
"""


def as_in_b77(name: str, ratio: float) -> Case:
    """A machine whose strain is kept and whose damping is a drag: this share of what is critical in the first mode."""
    case = load_case(name)
    bar = case.system().bar
    assert isinstance(bar, Bar)
    drag = 2.0 * ratio * math.pi * bar.wave_speed * bar.mass_per_length / bar.length
    return case.varied({"bar.damping_ratio": None, "bar.drag": f"{drag!r} N*s/m^2", "contact.strain": "kept"})


def plain(mean: float, r: float, d: float = 0.0048) -> Case:
    return Case.from_text(PLAIN.format(mean=mean, r=r, d=d))


def rows_of(case: Case) -> dict[str, list[str]]:
    """The lines of a report by their labels."""
    found: dict[str, list[str]] = {}
    for section in steady_report(steady_answer(case)).sections:
        for label, text in getattr(section, "rows", ()):
            found.setdefault(label, []).append(text)
    return found


# ---------------------------------------------------------------- random starts


@pytest.mark.parametrize("name", ["heavy-drifter", "pneumatic-jackleg", "mini-breaker"])
def test_the_starts_are_those_of_an_experiment(name: str) -> None:
    """The same starts and the same ends as `percuss experiment` finds with so many."""
    from percuss.case import experiment_job_of
    from percuss.explore.attractors.experiments import Experiment

    case = load_case(name)
    ends = ends_of(case, 24)
    job = experiment_job_of(case, 24)
    found = Experiment.of(job, job.compute(0, 24, lambda: False))
    assert {end.label: end.starts for end in ends.ends} == Counter(found.label.tolist())
    assert ends.followed == 24
    assert [end.starts for end in ends.ends] == sorted((end.starts for end in ends.ends), reverse=True)


def test_a_bar_that_hovers_is_followed_for_so_many_evaluations_and_told() -> None:
    """Hardly any mean force and much damping: thousands of load periods pass between two impacts."""
    case = Case.from_text(PLAIN.format(mean=1.83e-6, r=0.5, d=141.6).replace("s = 20.0", "s = 1.46"))
    ends = ends_of(case, 4)
    assert ends.followed == 4
    assert ends.note.startswith("4 of 4 not followed to their end: each would take more than 400000 evaluations")
    assert ends.note in dict(ends_section(ends, "case.toml", case.system()).rows)["note"]
    assert ends == ends_of(case, 4)


@pytest.mark.parametrize("d", [1e4, 1e6])
def test_starts_of_a_strongly_damped_bar_are_followed_to_their_end(d: float) -> None:
    ends = ends_of(plain(0.3, 0.5, d), 24)
    assert [(end.label, end.starts) for end in ends.ends] == [("chatter/1", 24)]
    assert ends.note == ""


def test_the_power_of_an_end_is_that_of_its_motion() -> None:
    """A start that ends in the steady motion delivers what the closed form says."""
    answer = steady_answer(as_in_b77("heavy-drifter", 6e-5), starts=24)
    si, system = answer.running[0].si, answer.system
    assert si is not None
    (there,) = [end for end in answer.starts.to_json_dict(system)["ends"] if end["label"] == "z=1/1"]
    assert there["si"]["delivered_power_kW"] == pytest.approx(1e-3 * si.delivered_energy_J * si.blow_rate_Hz, rel=1e-6)
    assert there["si"]["blow_rate_Hz"] == pytest.approx(si.blow_rate_Hz, rel=1e-9)


def test_the_summary_claims_no_more_than_the_starts_show() -> None:
    answer = steady_answer(as_in_b77("heavy-drifter", 6e-5), starts=24)
    there = sum(end.starts for end in answer.starts.ends if end.label == "z=1/1")
    assert 0 < there < 24
    summary = steady_report(answer).summary
    assert "The hammer can run with one blow every load period" in summary
    (other,) = [end for end in answer.starts.to_json_dict(answer.system)["ends"] if end["label"] != "z=1/1"]
    power = f"{other['si']['delivered_power_kW']:.4g} kW taken by the impacts"
    ends = f"{there} end in this motion, {24 - there} find no rhythm (aperiodic, {power})."
    assert f"Of 24 random starts, {ends}" in summary
    surely = steady_report(steady_answer(load_case("mini-breaker"), starts=24)).summary
    assert "All 24 random starts end in this motion." in surely
    assert "random start" not in steady_report(steady_answer(load_case("mini-breaker"))).summary


def test_without_a_steady_motion_the_summary_tells_what_happens_instead() -> None:
    """Above the fold nothing strikes once a period for ever; the bar chatters, and does work all the same."""
    from percuss import Start, Stop, run

    case = plain(0.9, 0.3)
    answer = steady_answer(case, starts=16)
    assert not answer.running
    summary = steady_report(answer).summary
    assert "No steady motion with one impact every load period exists" in summary
    (end,) = answer.starts.ends
    assert end.label == "chatter/1"
    assert "All 16 random starts chatter to rest once every load period (chatter/1): " in summary
    assert end.delivered_power is not None
    # what the wall takes of a motion simulated by itself, over many periods
    motion = run(case.system(), Start.rigid(0.0, -1.0, 0.3), modes=32, stop=Stop(time=400.0, periodic=False))
    late = motion.events.time > 100.0
    periods = 2 * math.pi * math.floor((400.0 - 100.0) / (2 * math.pi))
    late &= motion.events.time <= 100.0 + periods
    assert end.delivered_power == pytest.approx(float(motion.events.energy_lost[late].sum()) / periods, rel=1e-6)


def test_starts_that_were_not_followed_say_why(capsys: pytest.CaptureFixture[str], monkeypatch) -> None:
    from percuss import compiled

    assert main(["steady", "mini-breaker", "--starts", "0"]) == 0
    assert "not followed: none were asked for" in capsys.readouterr().out
    monkeypatch.setattr(compiled, "is_compiled", lambda _: False)
    assert main(["steady", "mini-breaker"]) == 0
    told = capsys.readouterr().out
    assert "not followed: the simulator has not been compiled on this computer yet" in told
    assert "'percuss steady mini-breaker --starts 24' does it" in told
    assert main(["steady", "mini-breaker", "--starts", "2"]) == 0  # asked for: it is compiled, and said so
    said = capsys.readouterr()
    assert "2 of 2 settle on one blow every load period" in said.out
    assert "compiling the simulator" in said.err


def test_the_kernels_are_known_to_be_compiled() -> None:
    """After a motion was followed the cache holds the kernels; in an empty one they are not."""
    import os
    import subprocess
    import sys

    ends_of(load_case("mini-breaker"), 1)
    code = "import sys; from percuss.compiled import is_compiled; "
    code += "from percuss.simulate.kernels.motion import follow; sys.exit(not is_compiled(follow))"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
    elsewhere = {**os.environ, "NUMBA_CACHE_DIR": os.path.join(os.path.dirname(__file__), "no-such-cache")}
    assert subprocess.run([sys.executable, "-c", code], check=False, env=elsewhere).returncode == 1


def test_the_command_that_follows_more_can_be_typed() -> None:
    ends, system = Ends(1, 0, 100, ()), plain(0.3, 0.5).system()
    for name, typed in (("<stdin>", "-"), ("my case.toml", "'my case.toml'"), ("mini-breaker", "mini-breaker")):
        assert f"'percuss experiment {typed}' follows more" in ends_section(ends, name, system).rows[0][1]


@pytest.mark.parametrize(
    ("label", "words"),
    [
        ("z=2/3", "All 2 random starts settle on 2 blows in 3 load periods (z=2/3)."),
        ("rest/1", "All 2 random starts strike and come to rest once every load period (rest/1)."),
        ("rest", "All 2 random starts come to rest on the wall for good."),
        ("undecided", "All 2 random starts have not settled (undecided)."),
    ],
)
def test_ends_in_words(label: str, words: str) -> None:
    ends = Ends(2, 0, 100, (End(label, 2, None, None),))
    assert ends_sentence(ends, set(), plain(0.3, 0.5).system()) == words


# ---------------------------------------------------------------- two margins


def test_a_sweep_has_the_two_margins_of_the_single_answer() -> None:
    from percuss.explore import Axis, sweep
    from percuss.stability import stability_of

    system = plain(0.6, 0.5).system()
    names = ["margin", "margin_rhythm", "margin_ringing"]
    found = sweep(system, Axis("restitution", [0.4, 0.55, 0.6]), quantities=names, modes=6, workers=1)
    for i, r in enumerate((0.4, 0.55, 0.6)):
        verdicts = [stability_of(orbit, modes=6) for orbit in steady_states(system.with_restitution(r)).orbits]
        best = max(verdicts, key=lambda verdict: verdict.margin)
        assert float(found["margin"][i]) == best.margin
        assert float(found["margin_rhythm"][i]) == best.margin_rhythm
        assert float(found["margin_ringing"][i]) == best.margin_ringing
    rigid = sweep(system, Axis("restitution", [0.55]), quantities=["margin", "margin_ringing"], modes=0, workers=1)
    assert np.isnan(rigid["margin_ringing"]).all()
    assert np.isfinite(rigid["margin"]).all()


def test_the_rhythm_hardly_changes_where_the_ringing_changes_its_mode() -> None:
    """1.5 per cent more stiffness: another elastic mode rings longest, the blows find back as before."""
    case = as_in_b77("heavy-drifter", 6e-5)
    young = case.system().bar.youngs_modulus  # type: ignore[union-attr]
    verdicts = [
        steady_answer(case.varied({"bar.youngs_modulus": f"{factor * young / 1e9:.6f} GPa"})).running[0].stability
        for factor in (1.0, 1.015)
    ]
    one, other = verdicts
    assert one.multipliers.ringing_mode != other.multipliers.ringing_mode
    assert one.margin_rhythm == pytest.approx(other.margin_rhythm, abs=2e-4)


# ---------------------------------------------------------------- drag


def test_the_drag_is_the_damping_of_the_whole_bar() -> None:
    bar = Bar(length=0.341, diameter=0.049, drag=900.0)
    system = System.from_si(bar, Load.harmonic(4.0e3, 9.0e3, frequency=60.0), Kept(restitution=0.2))
    for orbit in steady_states(system).orbits:
        si, drag = si_report(orbit), drag_of(orbit)
        assert si.drag_N_s_m == pytest.approx(900.0 * 0.341, rel=1e-12)
        assert 1e3 * si.drag_force_kN == pytest.approx(900.0 * 0.341 * si.rigid_velocity_m_s, rel=1e-12)
        assert drag.force * system.force_scale == pytest.approx(1e3 * si.drag_force_kN, rel=1e-12)
        assert drag.of_mean == pytest.approx(1e3 * si.drag_force_kN / 4.0e3, rel=1e-12)
        taken = 1.0 - si.delivered_energy_J * si.blow_rate_Hz / (1e3 * si.input_power_kW)
        assert drag.of_input == pytest.approx(taken, rel=1e-9)


@pytest.mark.parametrize(("d", "warned"), [(0.0, False), (0.04, False), (0.06, True)])
def test_a_strong_drag_is_warned_of(d: float, warned: bool) -> None:
    """At R = 0.6 the rigid motion strikes with 2π p_0/1.6: the drag is 20 % of the push from d = 0.051 on."""
    system = System(s=20.0, d=d, restitution=0.6, load=Load.harmonic(0.3, 1.0))
    for orbit in steady_states(system).orbits:
        assert any("drags the whole bar" in text for text in orbit.warnings) == warned
        assert (drag_of(orbit).of_mean > 0.2) == warned


def test_less_drag_is_named_as_a_remedy() -> None:
    system = System(s=20.0, d=0.3, restitution=0.2, load=Load.harmonic(0.33, 1.0))
    assert not steady_states(system).orbits
    found = greatest_drag(system, 1)
    assert found is not None
    assert 0.0 < found < 0.3
    # where the level touches the greatest v_f, which for one harmonic is 1/√(1 + d²)
    assert float(level(0.33, found, 0.2, 2 * math.pi)) == pytest.approx(1.0 / math.hypot(1.0, found), rel=1e-6)
    assert steady_states(System(s=20.0, d=0.999 * found, restitution=0.2, load=Load.harmonic(0.33, 1.0))).orbits
    text = " ".join(rows_of(plain(0.33, 0.2, 0.3))["or"])
    assert f"d = {found:.4g} (now 0.3)" in text
    assert greatest_drag(System(s=20.0, d=0.3, restitution=0.2, load=Load.harmonic(5.0, 1.0)), 1) is None
    assert greatest_drag(System(s=20.0, d=0.0, restitution=0.2, load=Load.harmonic(0.5, 1.0)), 1) is None


def test_questions_that_are_none() -> None:
    from percuss.errors import LoadError, ParameterError

    with pytest.raises(ParameterError, match="orbit"):
        drag_of(3)  # type: ignore[arg-type]
    with pytest.raises(ParameterError, match="system"):
        greatest_drag(None, 1)  # type: ignore[arg-type]
    with pytest.raises(ParameterError, match="periods"):
        greatest_drag(plain(0.3, 0.5).system(), 0)
    with pytest.raises(LoadError):
        greatest_drag(plain(-0.3, 0.5).system(), 1)
    with pytest.raises(ParameterError, match="load"):
        switching_of("square")  # type: ignore[arg-type]
    for starts in (0, 1001, 2.5):
        with pytest.raises(ParameterError, match="starts"):
            ends_of(plain(0.3, 0.5), starts)  # type: ignore[arg-type]


# ---------------------------------------------------------------- figures


@pytest.mark.parametrize("scale", [1e-7, 1e-4])
def test_a_tiny_machine_has_the_efficiency_of_a_large_one(scale: float) -> None:
    """Lengths times `scale`, frequency over it, force times its square: the same numbers without dimension."""

    def answer(size: float) -> tuple[float | None, float]:
        bar = Bar(length=0.3 * size, diameter=0.05 * size, damping_ratio=1e-4)
        load = Load.harmonic(2.0e3 * size**2, 6.0e3 * size**2, frequency=60.0 / size)
        si = si_report(steady_states(System.from_si(bar, load, Kept(restitution=0.2))).orbits[1])
        return si.efficiency, si.blow_energy_J

    (efficiency, energy), (whole, large) = answer(scale), answer(1.0)
    assert energy == pytest.approx(large * scale**3, rel=1e-9)  # down to 1e-19 J
    assert efficiency is not None
    assert efficiency == pytest.approx(whole, rel=1e-9)


def test_where_nothing_is_put_in_there_is_no_efficiency() -> None:
    """R = 1 without damping takes nothing, whatever the size."""
    bar = Bar(length=0.3, diameter=0.05)
    load = Load.harmonic(2.0e3, 6.0e3, frequency=60.0)
    for orbit in steady_states(System.from_si(bar, load, Kept(restitution=1.0)), modes=0).orbits:
        assert si_report(orbit).efficiency is None


def test_the_power_is_accounted_for() -> None:
    for name, ratio in (("laboratory-striker", 1e-5), ("mini-breaker", 2e-5)):
        for found in steady_answer(as_in_b77(name, ratio)).periods[0].orbits:
            si, r = found.si, found.orbit.system.restitution
            assert si is not None
            kept = r**2 * 1e3 * si.percussive_power_kW
            assert 1e3 * si.percussive_power_kW == pytest.approx(
                si.delivered_energy_J * si.blow_rate_Hz + kept, rel=1e-12
            )
    text = rows_of(as_in_b77("laboratory-striker", 1e-5))["power"][0]
    assert "percussive 150.1 W (energy before the impact times rate) = 130.9 W taken by the impact + 19.25 W" in text


def test_a_motion_that_does_not_strike_has_no_stress_and_no_blow() -> None:
    """A bar so soft that its ringing end moves back faster than the bar as a whole moves forward."""
    bar = Bar(length=1.0, diameter=0.05, damping_ratio=0.001)
    load = Load.harmonic(2.5e4, 1.0e5, frequency=bar.wave_speed / (2.0 * math.pi * 0.252))
    system = System.from_si(bar, load, Kept(restitution=0.21))
    backward = [orbit for orbit in steady_states(system).orbits if orbit.impact_velocity < 0.0]
    assert backward
    for orbit in backward:
        si = si_report(orbit)
        assert (si.peak_stress_MPa, si.receiving_stress_MPa) == (None, None)
        assert si.impact_velocity_m_s < 0.0


# ---------------------------------------------------------------- loads that switch


def trapezoid(edge: float, harmonics: int = 60) -> Load:
    t = np.arange(4096) / 4096
    values = np.interp(t, [0.0, edge, 0.45, 0.45 + edge, 1.0], [-1.0, 1.0, 1.0, -1.0, -1.0])
    coefficients = np.fft.rfft(values)[: harmonics + 1] / values.size
    coefficients[1:] *= 2.0
    coefficients[0] = 0.2
    return Load.fourier(coefficients)


@pytest.mark.parametrize(
    ("load", "switches"),
    [
        (Load.square(3.0, 1.3), True),
        (Load.steps([0.0, 2.0, 3.0], [1.0, 0.95, -1.0]), True),
        (Load.fourier(Load.square(3.0, 1.3, 5).coefficients), True),
        (Load.fourier(Load.square(3.0, 1.0, 29).coefficients), True),
        (trapezoid(0.02), True),
        (trapezoid(0.15), True),
        (trapezoid(0.35), False),
        (Load.harmonic(0.9, 1.0), False),
        (Load.fourier([0.3, 1.0, 0.3j]), False),
        (Load.fourier([0.3]), False),
        (Load.steps([0.0, 1.0, 2.0, 3.0, 4.0, 5.0], [0.0, 0.5, 1.0, 1.0, 0.5, 0.0]), False),
    ],
)
def test_which_loads_switch(load: Load, switches: bool) -> None:
    for same in (load, load.scaled(-1e5), load.shifted(1.0)):
        assert (switching_of(same) is not None) == switches
        assert bool(clock_note(same)) == switches


@pytest.fixture
def drill(tmp_path):
    """A record of a drill at 70 Hz: 20 cycles of a pressure that switches, their lengths scattered by 0.9 %."""
    draw = np.random.default_rng(1)
    lengths = (1.0 + 0.009 * draw.standard_normal(21)) / 70.0
    ends = np.concatenate([[0.0], np.cumsum(lengths)])
    time = np.arange(0.0, ends[20], 1.0 / 20e3)
    which = np.searchsorted(ends, time, side="right") - 1
    phase = (time - ends[which]) / lengths[which]
    edge = 0.5 * (np.tanh((phase - 0.02) / 0.01) - np.tanh((phase - 0.55) / 0.01))
    pressure = 2.0 + 14.0 * edge + 0.2 * draw.standard_normal(time.size)
    lines = ["time [s],pressure [MPa]", *(f"{a:.6f},{b:.4f}" for a, b in zip(time, pressure - 8.0, strict=True))]
    (tmp_path / "drill.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")
    (tmp_path / "drill.toml").write_text(
        '[bar]\nlength = "400 mm"\ndiameter = "45 mm"\ndamping_ratio = 2e-5\n[contact]\nrestitution = 0.2\n'
        '[load]\nkind = "history"\nfile = "drill.csv"\narea = "12 cm^2"\n',
        encoding="utf-8",
    )
    return tmp_path


def test_a_record_that_switches_says_so_in_the_first_lines(drill, capsys, monkeypatch) -> None:
    monkeypatch.chdir(drill)
    short = "The recorded load switches as a valve does: stability is judged as if it kept time by itself"
    turning = "This verdict is for a load that keeps time by itself"
    for command in (
        ["steady", "drill.toml"],
        ["simulate", "drill.toml", "--impacts", "20"],
        ["experiment", "drill.toml", "--starts", "8", "--modes", "0", "--workers", "1"],
    ):
        assert main(command) == 0
        told = capsys.readouterr().out
        assert (turning if command[0] == "steady" else short) in told.split("\n\n")[0], command
        assert "the load switches between two levels" in told, command
        assert main([*command, "--json"]) == 0
        notes = json.loads(capsys.readouterr().out)["notes"]
        assert any("the load switches between two levels" in note for note in notes), command


def test_a_formula_that_switches_has_the_note_and_the_first_lines_only_what_turns_on_the_clock() -> None:
    """Who types a formula has chosen its clock, but not that this keeps the hammer from running."""
    case = Case.from_text(
        '[system]\ns = 20.0\nd = 0.01\nrestitution = 0.2\n[load]\nkind = "square"\namplitude = 1.0\nkappa = 1.2\n'
    )
    assert clock_in_short(case.load()) == ""
    assert any("as a valve does" in note for note in rows_of(case)["note"])
    answer = steady_answer(case)
    assert answer.clocked == "no motion"
    assert steady_report(answer).summary.endswith(CLOCKED)
    assert answer.to_json_dict()["clocked"] == {"because": "no motion", "note": CLOCKED}
    assert not plain(0.3, 0.2).notes


@pytest.mark.parametrize(
    ("load", "levels", "motions", "because"),
    [
        (Load.square(3.0, 1.3), [(0.5, 1.0)], [(True, True)], None),
        (Load.square(3.0, 1.3), [(0.5, 1.0)], [(True, True), (False, False)], None),
        (Load.square(3.0, 1.3), [(0.5, 1.0)], [(True, True), (True, False)], "unstable"),
        (Load.square(3.0, 1.3), [(0.5, 1.0)], [(True, False), (False, True)], "unstable"),
        (Load.square(3.0, 1.3), [(0.5, 1.0)], [(False, True)], "no motion"),
        (Load.square(3.0, 1.3), [(1.01, 1.0)], [], "no motion"),
        (Load.square(3.0, 1.3), [(0.985, 1.0)], [(True, True)], "near the fold"),
        (Load.square(3.0, 1.3), [(0.975, 1.0)], [(True, True)], None),
        (Load.steps([0.0, 1.0, 2.0, 3.0, 4.0, 5.0], [0.0, 0.5, 1.0, 1.0, 0.5, 0.0]), [(0.5, 1.0)],
         [(True, True), (True, False)], None),
        (Load.harmonic(0.9, 1.0), [(1.01, 1.0)], [], None),
    ],
)  # fmt: skip
def test_when_a_verdict_turns_on_the_clock(load: Load, levels, motions, because) -> None:
    assert clocked_because(load, levels, motions) == because


@pytest.mark.parametrize(("low", "high"), [(-0.2, np.inf), (-0.5, 0.5), (-0.2, 0.2)])
def test_a_clipped_record_is_not_called_a_valve(tmp_path, low: float, high: float) -> None:
    """A sensor at its limits makes levels too; what lay beyond them is unknown."""
    time = np.arange(0.0, 1.0, 1.0 / 20e3)
    wave = np.sin(2.0 * np.pi * 40.0 * time) + 1e-3 * np.random.default_rng(2).standard_normal(time.size)
    load = Load.history(time, 1e4 * np.clip(wave, low, high))
    assert load.report is not None
    assert load.report.clipped > 0.3
    assert any("reached its limit" in text for text in load.report.warnings)
    assert clock_note(load) == clock_in_short(load) == ""
    assert Load.history(time, 1e4 * wave).report.clipped == 0.0


# ---------------------------------------------------------------- at rest


@pytest.mark.parametrize(("mean", "d", "stays"), [(0.3, 1e4, False), (1.3, 1e4, True), (1.3, 0.0048, True)])
def test_what_is_said_of_rest_agrees_with_where_starts_end(mean: float, d: float, stays: bool) -> None:
    """Damping swallows the waves before they reach the wall, but a simulation goes by the load, which pulls."""
    answer = steady_answer(plain(mean, 0.5, d), starts=8)
    assert answer.rest.possible
    assert answer.rest.held_by_waves == (not stays)
    assert {end.label for end in answer.starts.ends} == ({"rest"} if stays else {"chatter/1"})
    report = steady_report(answer)
    (text,) = [dict(section.rows)["rest"] for section in report.sections if section.heading == "At rest on the wall"]
    assert ("may stay at rest" in text) == stays
    assert ("lets the bar go" in text) == (not stays)
    assert ("may also come to rest" in report.summary) == stays


# ---------------------------------------------------------------- the report as a file


def test_the_report_of_the_command_line_stands_by_itself(tmp_path, capsys) -> None:
    """One HTML file: nothing is fetched, no scripts, the figures of the answer in it."""
    target = tmp_path / "breaker.html"
    assert main(["steady", "mini-breaker", "--starts", "6", "--report", str(target)]) == 0
    assert f"report: {target}" in capsys.readouterr().out
    text = target.read_text(encoding="utf-8")
    assert text.startswith("<!doctype html>")
    assert text.count("<svg") == 2  # the bar to scale, and its motion
    assert "<script" not in text
    assert not re.findall(r'(?:src|href)="(?!#|data:)[^"]+"', text)
    si = steady_answer(load_case("mini-breaker")).running[0].si
    assert si is not None
    assert f"blow energy<b>{si.blow_energy_J:.3g} J" in text
    assert "All 6 random starts end in this motion." in text
    assert [path.name for path in tmp_path.iterdir()] == ["breaker.html"]  # nothing half done beside it


BACKWARD = """
[system]
s = 0.1869
d = 0.02
restitution = 0.0
[load]
kind = "fourier"
coefficients = [[0.09699, 0.0], [-0.5538, 0.9776], [-0.3106, -0.3288]]
"""


@pytest.mark.parametrize(
    "case", [plain(0.3, 0.6), plain(0.9, 0.3), Case.from_text(BACKWARD), load_case("mini-breaker")]
)
def test_the_report_as_a_file_says_first_what_the_terminal_says(case: Case) -> None:
    """Whether it can run, what happens instead, and where random starts end: by the same sentences."""
    from html import unescape

    from percuss.plot.reports.html_report import report_html

    answer = steady_answer(case, (1, 2), starts=8)
    text = unescape(re.sub("<[^>]+>", "", report_html(case, answer)))
    summary = steady_report(answer).summary
    assert summary in text
    assert "random start" in summary
    assert "keep this motion up" not in text


@pytest.mark.parametrize(
    ("name", "answered", "told"),
    [("stopped-beam", steady_answer, steady_report), ("valve-drifter", machine_answer, machine_report)],
)
def test_the_report_as_a_file_is_there_for_every_hammer(name: str, answered: Any, told: Any) -> None:
    from html import unescape

    from percuss.plot.reports.html_report import report_html

    case = load_case(name)
    answer = answered(case)
    page, report = report_html(case, answer), told(answer)
    text = unescape(re.sub("<[^>]+>", "\n", page)).split("\n")
    assert "<svg" in page and {report.title, report.summary, case.to_toml().splitlines()[0]} <= {*text}
    cells = {cell for part in report.sections for row in part.rows for cell in row}
    assert {part.heading for part in report.sections} | cells <= {*text, ""}


def test_the_report_as_a_file_tells_no_speed_of_what_does_not_strike() -> None:
    from percuss.plot.reports.html_report import report_html

    case = Case.from_text(BACKWARD)
    answer = steady_answer(case)
    speeds = [found.orbit.impact_velocity for found in answer.periods[0].orbits]
    assert min(speeds) < 0.0
    text = report_html(case, answer)
    assert text.count("none: the striking end would be leaving the wall") == sum(speed <= 0.0 for speed in speeds)
    assert text.count(" taken by the impact (R); ") == sum(speed > 0.0 for speed in speeds)
    told = [orbit["impact_velocity"] for orbit in answer.to_json_dict()["periods"][0]["orbits"]]
    assert told == speeds  # signed: docs/json.md says what a negative one means


@pytest.mark.filterwarnings("error")
def test_a_title_steers_neither_a_picture_nor_a_page() -> None:
    """matplotlib has no glyph for ESC, and the letters behind a reversal would be read backward."""
    from percuss import plot
    from percuss.case import simulation_answer
    from percuss.plot.reports.html_report import report_html

    title = "mine\x1b[2J \u202eand $x$\nyours"
    case = Case.from_text('title = "mine\\u001b[2J \\u202eand $x$\\nyours"\n' + PLAIN.format(mean=0.3, r=0.6, d=0.0048))
    assert case.title == title
    shown = r"mine\u001b[2J \u202eand $x$\u000ayours"
    answer, simulation = steady_answer(case), simulation_answer(case)
    assert plot.steady(answer).get_suptitle() == shown
    assert plot.trajectory(simulation).get_suptitle().startswith(f"{shown} — ")
    text = report_html(case, answer, simulation)
    assert not set(text) & {"\x1b", "\u202e"}
    assert r"mine\u001b[2J \u202eand $x$" in text
