"""Reports in German and Swedish: of every kind of hammer and question nothing stays English but keys and names."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from html import escape
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from machine_records import MASS, breaker, recorded_machine
from percuss.case import (
    MACHINES,
    Case,
    Limit,
    Span,
    blow_answer,
    compare,
    data_sheet_answer,
    design,
    identify,
    load_case,
    reach_answer,
    recorded_answer,
    repeated_answer,
    simulation_answer,
    steady_answer,
    tolerance,
)
from percuss.case.answers.reported import reported_answers
from percuss.errors import ParameterError
from percuss.model import Kept
from percuss.plot.reports.html_report import report_html
from percuss.plot.reports.translation import Translation, translation
from percuss.recordings import BlowRecord

PUMP = {"load.supply": {"flow": "133 l/min", "accumulator": "2.5 cm^3/bar"}}
PLAIN = '[system]\ns = 20.0\nd = 0.0048\nrestitution = {}\n[load]\nkind = "harmonic"\nmean = {}\namplitude = 1.0\n'
NAME = re.compile(r"(?:[A-D] )?[a-z0-9]+(?:-[a-z0-9]+)+|.*\.toml|'?<text>'?|[A-D] ")
Told = tuple[Case, Any, Any, Any]


def whole(case: Case, modes: int | None = None, *, moves: bool = True) -> Told:
    """What a report has of a hammer, and how it starts."""
    answer, blow = reported_answers(case, modes)
    return case, answer, simulation_answer(case) if moves else None, blow


def uncertain() -> Told:
    given = re.sub(r"(?m)^restitution = (\S+)", r'restitution = "\1 ± 0.02"', load_case("mini-breaker").to_toml())
    return whole(Case.from_text(given), moves=False)


def plain(restitution: float, mean: float) -> Told:
    case = Case.from_text(PLAIN.format(restitution, mean))
    return case, steady_answer(case, (1, 2), starts=8), simulation_answer(case), None


def reached(name: str) -> Told:
    case, answer, simulation, blow = whole(load_case(name), moves=False)
    return case, replace(answer, reach=tuple(reach_answer(case, answer.whole.motion))), simulation, blow


def compared() -> Told:
    cases = [load_case("valve-breaker").varied(PUMP), load_case("hydraulic-drifter"), load_case("laboratory-striker")]
    return cases[0], compare(cases, ["valve-breaker", "hydraulic-drifter", "laboratory-striker"]), None, None


def designed() -> Told:
    case = load_case("valve-drifter")
    spans = [Span.parsed(words) for words in ("load.ports[0].behind=8:24mm", "load.pressure=120:200bar")]
    limit = Limit.parsed("flow=60 l/min", "below", True)
    return case, design(case, spans, "blow_energy", [limit], modes=0, most=60), None, None


def toleranced() -> Told:
    case = load_case("valve-breaker")
    return case, tolerance(case, samples=100, modes=0), None, None


def recorded(of: str, tmp_path: Path) -> Told:
    """The record of a breaker, by a clock or as the machine that it is."""
    told = recorded_machine(breaker(0.0, 10e-3), Kept(0.15), cycles=10, noise=0.002)
    rows = (f"{t:.6f},{MASS * p:.2f}\n" for t, p in zip(told.time, told.force, strict=True))
    (tmp_path / "force.csv").write_text("time [s],force [N]\n" + "".join(rows), encoding="utf-8")
    bar = f'length = "1 m"\ndiameter = "120 mm"\ndensity = "{MASS / (np.pi * 0.06**2):.8f} kg/m^3"\ndrag = "44 N*s/m^2"'
    law = 'restitution = 0.15\nstrain = "reversed"\n[load]\nkind = "history"\nfile = "force.csv"\n'
    file = tmp_path / "breaker.toml"
    file.write_text(f"[bar]\n{bar}\n[contact]\n{law}", encoding="utf-8")
    case = Case.read(file)
    answer = recorded_answer(case, 0, blows=told.blows[1:-1]) if of == "machine" else steady_answer(case)
    return case, answer, None, None


def identified() -> Told:
    case, rng = load_case("mini-breaker"), np.random.default_rng(1)
    answer, _ = reported_answers(case, 0)
    rate, speed = answer.whole.value("blow_rate"), answer.whole.value("rigid_velocity")
    assert rate is not None and speed is not None
    times = np.cumsum(np.concatenate([[0.0], (1.0 + 0.01 * rng.normal(size=119)) / rate]))
    record = BlowRecord(times, {"rigid_velocity": speed * (1.0 + 0.01 * rng.normal(size=120))})
    return case, identify(case, record, [Span("contact.restitution", 0.05, 0.4)], modes=0), None, None


def sheet() -> Told:
    case = load_case("valve-drifter")
    return case, data_sheet_answer(case, 175e5, 123 / 6e4, 68.0, 277.0), None, None


def struck(number: int | None) -> Told:
    case = load_case("drill-string")
    if number is None:
        return case, blow_answer(case, fatigue=True), None, None
    case = case.varied({"blow.number": number, "blow.between": "waves", "blow.until": None})
    return case, repeated_answer(case), None, None


QUESTIONS: dict[str, Callable[[], Told]] = {
    "compared": compared,
    "designed": designed,
    "toleranced": toleranced,
    "identified": identified,
    "sheet": sheet,
    "struck": partial(struck, None),
    "repeated": partial(struck, 4),
    "uncertain": uncertain,
    "chatter": partial(plain, 0.6, 0.3),
    "none": partial(plain, 0.3, 0.9),
}

FAST = ("mini-breaker", "compared", "uncertain")
SAMPLES = (*(machine.name for machine in MACHINES), "stopped-beam", "stopped-oscillator")
ALL = [
    pytest.param(name, language, marks=[] if name in FAST and language == "de" else pytest.mark.slow)
    for name in (*SAMPLES, *QUESTIONS, "reached", "pump")
    for language in ("de", "sv")
]


def question(name: str) -> Told:
    if name in QUESTIONS:
        return QUESTIONS[name]()
    if name == "reached":
        return reached("mini-breaker")
    if name == "pump":
        return whole(load_case("valve-breaker").varied(PUMP), 2)
    return whole(load_case(name), 0 if name.startswith("oil") else None)


def left(told: Told, language: str) -> list[str]:
    """What a report has that the catalogue has no words for."""
    translation.cache_clear()
    case, answer, simulation, blow = told
    page = report_html(case, answer, simulation, blow, language)
    assert f'<html lang="{language}">' in page and escape(case.to_toml().splitlines()[0]) in page
    words = translation(language)
    assert isinstance(words, Translation)
    return sorted(one for one in words.missed if not NAME.fullmatch(one))


@pytest.mark.parametrize(("name", "language"), ALL)
def test_nothing_in_a_report_stays_english(name: str, language: str) -> None:
    assert left(question(name), language) == []


@pytest.mark.slow
@pytest.mark.parametrize("of", ["clock", "machine"])
def test_nothing_in_a_report_on_a_record_stays_english(of: str, tmp_path: Path) -> None:
    assert left(recorded(of, tmp_path), "de") == []


def test_words_are_looked_up_by_their_numbers_and_parts() -> None:
    """As a whole, by its parts, with what is filled in; numbers have a comma, and keys and names are left alone."""
    words = translation("de")
    told = {
        "The cycle": "Der Zyklus",
        "Case drill-string": "Fall drill-string",
        "peak stress in the steel 4.5 MPa": "Spitzenspannung im Stahl 4,5 MPa",
        "1.5e-09 m/s": "1,5e-09 m/s",
        "-3.2 kN": "−3,2 kN",
        "length [mm]": "Länge [mm]",
        "load.ports[0].behind": "load.ports[0].behind",
        "Stable; my own words": "Stabil; my own words",
        "": "",
    }
    assert {text: words(text) for text in told} == told
    assert translation("en")("1.5 mm") == "1.5 mm"
    with pytest.raises(ParameterError):
        translation("fr")
