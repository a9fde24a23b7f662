"""The report as a PDF, read again: what stands in HTML stands in it, whole, on its page, and no letter over another."""

from __future__ import annotations

import re
from collections.abc import Iterator
from functools import cache
from typing import Any, NamedTuple

import numpy as np
import pypdfium2
import pytest

from percuss.case import Case, blow_answer, compare, load_case, machine_answer, steady_answer
from percuss.plot.reports.html_report import report_html
from percuss.plot.reports.pdf_report import report_pdf
from percuss.units import unit_scale

PAPERS = {"a4": (210.0, 297.0), "letter": (215.9, 279.4)}
PUMP = {"flow": "133 l/min", "accumulator": "2.5 cm^3/bar"}
DIMENSIONS = ("energy", "frequency", "velocity", "length", "power", "pressure", "flow")
HAMMERS = ("hydraulic-drifter", "valve-breaker", "on a pump")


class Told(NamedTuple):
    """A report by its HTML, its PDF, and the figures in JSON."""

    html: str
    pdf: Any
    json: dict[str, Any]


def case_of(name: str) -> Case:
    return load_case("valve-breaker").varied({"load.supply": PUMP}) if name == "on a pump" else load_case(name)


@cache
def answered(name: str) -> tuple[Case, Any, Any]:
    """A case, its answer and its blow."""
    if name == "compared":
        cases = [load_case("valve-breaker"), load_case("hydraulic-drifter"), load_case("laboratory-striker")]
        return cases[0], compare(cases, [case.file for case in cases]), None
    case = case_of(name)
    answer = machine_answer(case, 2) if case.is_machine else steady_answer(case)
    return case, answer, blow_answer(case, fatigue=True)


@cache
def written(name: str, paper: str, language: str) -> bytes:
    case, answer, blow = answered(name)
    return report_pdf(case, answer, None, blow, paper, language)


def read(name: str, paper: str = "a4", language: str = "en") -> Any:
    return pypdfium2.PdfDocument(written(name, paper, language), autoclose=True)


@pytest.fixture(params=HAMMERS)
def told(request: pytest.FixtureRequest) -> Told:
    case, answer, blow = answered(request.param)
    return Told(report_html(case, answer, blow=blow), read(request.param), answer.to_json_dict())


def boxes(page: Any) -> np.ndarray[Any, Any]:
    """Left, bottom, right and top of every letter in points."""
    text = page.get_textpage()
    chars = [text.get_charbox(i) for i in range(text.count_chars()) if text.get_text_range(i, 1).strip()]
    return np.array(chars)


def overlapping(chars: np.ndarray[Any, Any]) -> Iterator[int]:
    """Letters that cover more than a third of another behind them, but for those of one ligature."""
    left, bottom, right, top = chars.T
    area = np.maximum((right - left) * (top - bottom), 1e-9)
    for i in range(len(chars) - 3):
        wide = np.minimum(right[i], right[i + 3 :]) - np.maximum(left[i], left[i + 3 :])
        high = np.minimum(top[i], top[i + 3 :]) - np.maximum(bottom[i], bottom[i + 3 :])
        shared = np.maximum(wide, 0.0) * np.maximum(high, 0.0)
        if np.any(shared > np.minimum(area[i], area[i + 3 :]) / 3.0):
            yield i


def words(text: str) -> str:
    return re.sub(r"[\s\u200b\ufffe]+", "", text)


def text_of(pdf: Any) -> str:
    return words("".join(page.get_textpage().get_text_range() for page in pdf))


def texts_of(html: str) -> list[str]:
    from html import unescape

    body = re.sub(r"<svg.*?</svg>|<style>.*?</style>|<span></span>", "", html, flags=re.DOTALL)
    return [words(unescape(line)) for text in re.findall(r">([^<]+)<", body) for line in text.splitlines()]


def figures(json: dict[str, Any]) -> dict[str, float]:
    """What the cards of the first page tell, by their labels and in SI, from JSON."""
    transfer = json["transfer"]
    if "machine" in json:
        cycle, margin, stroke = json["si"], json["margins"]["margin"], json["si"]["stroke_m"]
    else:
        motion = next(one for one in json["periods"][0]["orbits"] if one["stable"] and one["admissible"])
        cycle, margin, stroke = motion["si"], motion["margin"], motion["si"]["stroke_mm"] / 1e3
    found = {
        "blow energy": cycle["blow_energy_J"],
        "blow rate": cycle["blow_rate_Hz"],
        "striking speed": cycle["impact_velocity_m_s"],
        "stroke": stroke,
        "power into the rock": transfer["rock_power"],
        "peak stress in the piston": transfer["peak_of_bar"]["stress"],
        "peak stress in the steel": transfer["peak_of_tool"]["stress"],
        "margin": margin,
    }
    if "machine" in json:
        found["oil flow"] = cycle["oil_flow_l_per_min"] / 6e4
        found["pressure of the supply"] = json["supply"]["mean"] if json["supply"] else 160e5
    return found


def test_all_that_stands_in_html_stands_in_the_pdf(told: Told) -> None:
    """Tables are broken over pages, so that each cell is looked for by itself."""
    text = text_of(told.pdf)
    assert not [one for one in texts_of(told.html) if one not in text]


def test_a_pdf_speaks_another_language_as_html_does() -> None:
    case, answer, blow = answered("valve-breaker")
    text = text_of(read("valve-breaker", language="de"))
    assert not [one for one in texts_of(report_html(case, answer, None, blow, "de")) if one not in text]
    assert "Schlagenergie" in text and "blowenergy" not in text


def test_the_figures_of_the_first_page_are_those_of_json(told: Told) -> None:
    text = words(told.pdf[0].get_textpage().get_text_range())
    for label, value in figures(told.json).items():
        found = re.search(words(label) + r"(-?[\d.]+(?:e[+-]\d+)?)(l/min|m/s|bar|[kMGmµ]?(?:Hz|Pa|J|W|m))?", text)
        assert found, label
        factor = 1.0 if found[2] is None else unit_scale(found[2], DIMENSIONS, label)[0]
        assert float(found[1]) == float(f"{value / factor:.3g}"), label


def test_what_speaks_against_the_figures_stands_on_the_first_page() -> None:
    page = words(read("hydraulic-drifter")[0].get_textpage().get_text_range())
    assert words("the first channel falls to -123.7 bar") in page and page.endswith(words("Hydraulic drifter 1 / 6"))


@pytest.mark.parametrize(("paper", "language"), [("a4", "en"), ("letter", "en"), ("a4", "de"), ("letter", "sv")])
@pytest.mark.parametrize("name", [*HAMMERS, "laboratory-striker", "compared"])
def test_no_letter_is_beyond_its_page_or_over_another(name: str, paper: str, language: str) -> None:
    pdf = read(name, paper, language)
    for page in pdf:
        assert page.get_size() == pytest.approx([side / 25.4 * 72.0 for side in PAPERS[paper]], abs=0.1)
        chars = boxes(page)
        room = [*page.get_size(), *page.get_size()]
        assert np.all((chars > 0.0) & (chars < np.array(room))), page.get_label()
        text = page.get_textpage()
        covered = [text.get_text_bounded(*(chars[i] + np.array([-9, -1, 9, 1]))) for i in overlapping(chars)]
        assert not covered
