"""The one account of an orbit's figures: each against its definition in SI, and all who read it."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from case_texts import si_case
from percuss import Bar, Kept, Load, Orbit, System, si_report, steady_states
from percuss.case import Case, steady_answer
from percuss.case.answers.exploring.quick_answer import quick_dict
from percuss.explore import QUANTITIES, sweep
from percuss.model import External
from percuss.steady import SIReport
from percuss.steady.figures import CARDS, FIGURES, REPORTED, figures_in_si

PREFIX = {"k": 1e-3, "m": 1e3, "M": 1e-6, "µ": 1e6, "": 1.0}
IN_NAMES = {"m/s": "m_s", "blows/min": "per_min", "µs": "us", "N·s": "N_s", "N·s/m": "N_s_m"}


def defined(orbit: Orbit) -> dict[str, float | None]:
    """The figures in SI from length, area, modulus, density and times, as theory §10 defines them."""
    system, bar = orbit.system, orbit.system.bar
    assert bar is not None and system.frequency is not None
    (piece,) = bar.pieces
    mass = piece.density * piece.area * bar.length
    omega = 2.0 * math.pi * system.frequency
    speed, rigid = (bar.length * omega * v for v in (orbit.impact_velocity, orbit.rigid_velocity))
    field = bar.length * omega * orbit.impact_field((np.arange(2000) + 0.5) / 2000)
    energy = 0.5 * mass * float(np.mean(field**2))
    rate, r = system.frequency / orbit.periods, system.restitution
    phases = (np.arange(20_000 * orbit.periods) + 0.5) * orbit.period / (20_000 * orbit.periods)
    force = system.load.value(orbit.phase + phases) * mass * bar.length * omega**2
    driven = orbit.velocity(0.0, phases)[0] * bar.length * omega
    gap = orbit.motion(phases) * bar.length
    put_in = float(np.mean(force * driven))
    wave = piece.density * math.sqrt(piece.youngs_modulus / piece.density) * speed / 2.0
    drag = system.d * mass * omega
    return {
        "phase": orbit.phase,
        "impact_velocity": speed,
        "rigid_velocity": rigid,
        "blow_energy": energy,
        "delivered": (1.0 - r**2) * energy,
        "blow_rate": rate,
        "power": energy * rate,
        "input_power": put_in,
        "efficiency": (1.0 - r**2) * energy * rate / put_in,
        "stroke": float(np.ptp(gap)),
        "stress": wave * (1.0 + r) if speed > 0.0 else None,
        "receiving_stress": wave * (1.0 - r) if speed > 0.0 else None,
        "contact_time": 2.0 * bar.length * math.sqrt(piece.density / piece.youngs_modulus),
        "mean_force": float(np.mean(system.load.value(phases))) * mass * bar.length * omega**2,
        "momentum": mass * rigid,
        "impulse": mass * (1.0 + r) * rigid,
        "drag": drag,
        "drag_force": drag * rigid,
    }


@settings(max_examples=6, deadline=None)
@given(
    length=st.floats(0.2, 1.5),
    restitution=st.floats(0.0, 0.9),
    frequency=st.floats(20.0, 200.0),
    periods=st.integers(1, 2),
    drag=st.sampled_from([0.0, 30.0]),
)
def test_every_figure_by_its_definition(
    length: float, restitution: float, frequency: float, periods: int, drag: float
) -> None:
    bar = Bar(length=length, diameter=0.05, damping=External(drag))
    load = Load.harmonic(mean=2.0e3, amplitude=9.0e3, frequency=frequency)
    for orbit in steady_states(System.from_si(bar, load, Kept(restitution=restitution)), periods).orbits:
        expected = defined(orbit)
        assert list(expected) == list(FIGURES)
        for name, figure in FIGURES.items():
            if expected[name] is None:
                assert figure.in_si(orbit) is None
                continue
            rough = (
                1e-4 if name in ("blow_energy", "delivered", "power", "input_power", "efficiency", "stroke") else 1e-9
            )
            assert figure.in_si(orbit) == pytest.approx(expected[name], rel=rough, abs=1e-12), name


def test_a_field_of_the_report_ends_in_its_unit() -> None:
    assert list(REPORTED) == list(SIReport.__dataclass_fields__)
    assert set(CARDS) < set(REPORTED)
    for key, (figure, factor, unit) in REPORTED.items():
        assert key.endswith(IN_NAMES.get(unit, unit)), key
        prefix = unit.removesuffix(figure.unit) if unit != "blows/min" else ""
        assert factor == (60.0 if unit == "blows/min" else PREFIX[prefix]), key


def test_all_answers_have_the_same_figures() -> None:
    case = Case.from_text(si_case())
    whole = steady_answer(case).to_json_dict()["periods"][0]["orbits"]
    quick = quick_dict(case)["orbits"]
    for orbit, told, short in zip(steady_states(case.system()).orbits, whole, quick, strict=True):
        report = si_report(orbit)
        assert told["si"] == {key: getattr(report, key) for key in REPORTED}
        assert short["si"] == {key: told["si"][key] for key in short["si"]} and len(short["si"]) == 7
        for name in ("phase", "impact_velocity", "rigid_velocity"):
            assert told[name] == short[name] == FIGURES[name].value(orbit)
        assert figures_in_si(orbit, ["stroke_mm"]) == {"stroke_mm": report.stroke_mm}


def test_a_map_has_the_figures_of_its_best_motion() -> None:
    names = [name for name, quantity in QUANTITIES.items() if quantity.one and name in FIGURES]
    assert set(names) == set(FIGURES) - {"blow_rate"}  # which in a map is that of a simulation
    scaled = Case.from_text(si_case()).system()
    for system in (scaled, System(body=scaled.body, load=scaled.load, contact=scaled.contact)):
        found = sweep(system, "restitution=0.2", quantities=[*names, "margin"], workers=1)
        orbit = min(steady_states(system).orbits, key=lambda one: abs(one.phase - found["phase"][0]))
        for name in names:
            figure, column = FIGURES[name], found.columns[name]
            assert found[name][0] == (figure.in_si(orbit) if system.is_si else figure.value(orbit))
            assert figure.meaning in column.meaning
            assert column.unit == (figure.unit if system.is_si or figure.unit == "rad" else "")


def test_the_impulse_of_a_blow_is_what_the_load_gives_in_its_period() -> None:
    for orbit in steady_states(Case.from_text(si_case()).system()).orbits:
        assert si_report(orbit).impulse_N_s == pytest.approx(4000.0 / 60.0, rel=1e-12)  # p₀T, without drag


def test_without_scales_there_is_nothing_in_si() -> None:
    orbit = steady_states(System(s=20.0, d=0.0, restitution=0.6, load=Load.harmonic(0.9, 1.0))).orbits[1]
    for name, figure in FIGURES.items():
        assert figure.value(orbit) is not None, name
        if figure.scale is not None:
            with pytest.raises(Exception, match="made from SI"):
                figure.in_si(orbit)
