"""The page in German and Swedish: the catalogue of words is whole, nothing of the screen stays English, numbers have a
comma, and longer words have their room."""

from __future__ import annotations

import json
import re
from html import unescape
from importlib import resources

import pytest

pytest.importorskip("fastapi")

from playwright.sync_api import expect

from percuss.case import load_case, steady_answer
from percuss.plot.reports.html_report import report_html
from percuss.plot.reports.translation import Translation
from test_web_screen import LAYOUT
from web_desk import PANELS, Desk, figure, knows, settled, slide

pytestmark = pytest.mark.browser

GERMAN, SWEDISH = {"locale": "de-DE"}, {"locale": "sv-SE"}
ALL = (
    *((name, GERMAN) for name in ("mini-breaker", "valve-breaker")),
    *(
        pytest.param(name, language, marks=pytest.mark.slow)
        for name in (
            "mini-breaker",
            "hydraulic-drifter",
            "drill-string",
            "valve-breaker",
            "oil-drifter",
            "stopped-beam",
        )
        for language in (GERMAN, SWEDISH)
        if language is SWEDISH or name not in ("mini-breaker", "valve-breaker")
    ),
)
PHRASES = json.loads(resources.files("percuss.web").joinpath("page/core/words.json").read_text(encoding="utf-8"))
NOT_SAID = "import('/static/core/words.js').then(words => [...words.missed].filter(one => !/^[\\w.]+[=<]/.test(one)))"


def test_every_phrase_has_both_languages() -> None:
    """Each with as many numbers and as many words filled in as in English, and with what ends it."""
    assert len(PHRASES) > 1000
    for english, others in PHRASES.items():
        assert len(others) == 2, english
        for other in others:
            assert other.strip() == other != "", english
            for mark in ("#", "{}"):
                numbered = re.sub(r"\{\d\}", "{}", re.sub(r"#\d", "#", other))
                assert numbered.count(mark) == english.count(mark), (english, other)


@pytest.mark.parametrize(("name", "desk"), ALL, indirect=["desk"])
def test_nothing_on_the_page_stays_english(desk: Desk, name: str) -> None:
    """Every drawer of a sample of every kind, with all that folds out; and the screen has room for all words."""
    page = desk.open(f"machine={name}")
    page.set_viewport_size({"width": 1366, "height": 650})
    settled(page)
    assert page.evaluate(LAYOUT) == []
    for panel in PANELS:
        if panel == "branches" and name == "oil-drifter":
            continue  # to follow its cycle takes minutes
        page.evaluate(f"import('/static/core/state.js').then(state => state.show({{panel: '{panel}', tall: 1}}))")
        settled(page)
        page.evaluate("document.querySelectorAll('details:not(.menu)').forEach(one => one.open = true)")
        settled(page)
    if name == "mini-breaker":
        for factor in (0.2, 1.1):  # unstable, and none
            slide(page, "load_factor", factor)
            settled(page)
    assert page.evaluate(NOT_SAID) == []


@pytest.mark.parametrize(("desk", "language"), [(GERMAN, "de"), (SWEDISH, "sv")], indirect=["desk"], ids=["de", "sv"])
def test_a_report_translates_as_the_page_does(desk: Desk, language: str) -> None:
    """Every phrase with numbers and words filled in, capitalized, in pairs, with more around it; and a report."""
    page = desk.module("core/words.js")
    case = load_case("mini-breaker")
    report = report_html(case, steady_answer(case))
    texts = [
        unescape(text) for text in re.findall(r">([^<]+)<", re.sub(r"<style>.*?</style>", "", report, flags=re.DOTALL))
    ]
    phrases = [one.replace("#", "-1.5e-09").replace("{}", "7.25 mm") for one in PHRASES]
    some = phrases[::9]
    texts += [*phrases, *(one[0].upper() + one[1:] for one in some)]
    texts += [f"{one}; {other} — nobody's 3.5 words" for one, other in zip(some, some[7:], strict=False)]
    texts += [f"{one} [bar], {other}" for one, other in zip(some, some[5:], strict=False)]
    theirs = page.evaluate("texts => import('/static/core/words.js').then(words => texts.map(words.tr))", texts)
    words = Translation(language)
    differing = [(text, words(text), other) for text, other in zip(texts, theirs, strict=True) if words(text) != other]
    assert differing == []
    assert words.missed == {*page.evaluate("import('/static/core/words.js').then(words => [...words.missed])")}


@pytest.mark.parametrize("desk", [GERMAN, SWEDISH], indirect=True, ids=["de", "sv"])
def test_lessons_are_told_in_the_language(desk: Desk) -> None:
    """Every scene with its prediction, its reason and its target, and the question at the end."""
    page = desk.open("panel=lessons")
    texts = page.evaluate(
        "import('/static/lessons/lessons.js').then(m => m.LESSONS.flatMap(l => [l.title, l.goal, "
        "...m.questionOf(l.question).choices, m.questionOf(l.question).words, m.questionOf(l.question).why, "
        "...l.scenes.flatMap(s => [s.show, s.say, s.target, m.questionOf(s.predict).words, "
        "m.questionOf(s.predict).why, ...m.questionOf(s.predict).choices])]))"
    )
    told = page.evaluate(f"import('/static/core/words.js').then(words => {json.dumps(texts)}.map(words.tr))")
    assert page.evaluate(NOT_SAID) == []
    assert [one for one, other in zip(texts, told, strict=True) if one == other and len(one) > 3] == []
    page.locator("#panel-lessons .lesson button").first.click()
    settled(page)
    expect(page.locator("#lesson-strip")).to_be_visible()
    assert page.evaluate(NOT_SAID) == []


@pytest.mark.parametrize("desk", [GERMAN], indirect=True)
def test_numbers_have_the_comma_of_the_language(desk: Desk) -> None:
    """Figures, fields and what is typed; another language is chosen, and kept for the next time."""
    page = desk.open("machine=mini-breaker")
    assert page.evaluate("document.documentElement.lang") == "de"
    assert figure(page, "Schlagfrequenz") == "17,5Hz"
    expect(page.locator("#verdict")).to_have_text("Stabil")
    page.fill("#slide-restitution-value", "0,36")
    page.press("#slide-restitution-value", "Enter")
    settled(page)
    expect(page.locator("#slide-restitution-value")).to_have_value("0,36")
    assert knows(page, "core/state.js:data.tables.contact.restitution") == 0.36
    page.click("#settings summary")
    page.select_option("#language", "en")
    expect(page.locator("#verdict")).to_have_text("Unstable")
    assert figure(page, "blow rate") == figure(page, "blow rate").replace(",", ".")
    page.reload()
    expect(page.locator("#tab-orbits")).to_have_text("All motions")
