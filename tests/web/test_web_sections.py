"""Sections of a bar, laws of damping and of strain, and loads of steps, put into the workbench in a real browser."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("fastapi")

from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import Page, expect

from percuss.case.case import case_of
from percuss.case.catalogue.sample_cases import machine_text
from web_desk import Desk, knows, settled, steady_json, until

pytestmark = pytest.mark.browser


PISTON = """
[bar]
sections = [
  {length = "320 mm", diameter = "45 mm"},
  {length = "120 mm", diameter = "30 mm", bore = "8 mm", material = "titanium"},
]
damping_ratio = 0.001
"""


def piston() -> str:
    """The mini-breaker with a stepped piston, as a file."""
    text: str = machine_text("mini-breaker")
    bar = re.search(r"\[bar\].*?(?=\n\[)", text, re.DOTALL)
    assert bar is not None
    return text.replace(bar[0], PISTON)


def shown(page: Page, name: str, value: float) -> None:
    """Until a card of the report shows a value, to the last digit."""
    until(page, f"Number(document.querySelector('[data-figure={name}]')?.dataset.value) === {value!r}")


def told(page: Page, words: str) -> Any:
    """What the server has told of the case that is on the page now."""
    settled(page)
    assert knows(page, "core/state.js:data.info.tables") == knows(page, "core/state.js:data.tables")
    return knows(page, f"state.js:data.info.{words}")


def build_piston(page: Page) -> None:
    page.click("#bar-sections")
    page.click("#sections-add")
    expect(page.locator("#field-bar-sections-1-length")).to_be_focused()
    page.fill("#field-bar-sections-1-length", "120 mm")
    page.fill("#field-bar-sections-1-diameter", "30 mm")
    page.fill("#field-bar-sections-1-bore", "8 mm")
    page.select_option("#field-bar-sections-1-material", "titanium")


def test_a_piston_of_sections_is_built_by_hand(desk: Desk, capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    path = tmp_path / "piston.toml"
    path.write_text(piston(), encoding="utf-8")
    orbits = steady_json(capsys, str(path))["periods"][0]["orbits"]
    truth = next(orbit for orbit in orbits if orbit["stable"] and orbit["admissible"])["si"]
    page = desk.open("machine=mini-breaker")
    build_piston(page)
    assert page.locator("#field-bar-length").count() == 0
    assert len(told(page, "bar.sections")) == 2
    violations = Axe().run(page).response["violations"]
    assert [one["id"] for one in violations if one["impact"] in ("serious", "critical")] == []
    page.click("#tab-report")
    shown(page, "blow_energy_J", truth["blow_energy_J"])
    for card in page.locator("#report-cards [data-figure]").all():
        name = card.get_attribute("data-figure") or ""
        assert float(card.get_attribute("data-value") or "nan") == truth[name], name
    until(page, "location.hash.includes('panel=report')")
    desk.open(page.url.partition("#")[2])
    shown(page, "blow_energy_J", truth["blow_energy_J"])
    page.click("#tab-case")
    expect(page.locator("#field-bar-sections-1-material")).to_have_value("titanium")
    page.click("#sections-remove-1")
    expect(page.locator("#sections tbody tr")).to_have_count(1)
    expect(page.locator("#sections-remove-0")).to_be_disabled()
    page.click("#bar-uniform")
    expect(page.locator("#field-bar-length")).to_have_value("320 mm")
    expect(page.locator("#headline .figures").locator("dd").first).to_have_text("180J")
    until(page, "!location.hash.includes('bar.')")  # the machine as it was


def test_rows_are_moved_from_the_keyboard(desk: Desk) -> None:
    page = desk.open("machine=mini-breaker")
    build_piston(page)
    page.click("#sections-add")
    page.focus("#sections-down-0")
    page.keyboard.press("Enter")
    expect(page.locator("#sections-down-1")).to_be_focused()
    page.keyboard.press("Enter")
    expect(page.locator("#sections-up-2")).to_be_focused()  # it is the last one now
    lengths = page.locator("#sections input[id$=length]")
    assert [box.input_value() for box in lengths.all()] == ["120 mm", "120 mm", "320 mm"]
    expect(page.locator("#field-bar-sections-0-material")).to_have_value("titanium")
    expect(page.locator("#field-bar-sections-2-material")).to_have_value("")
    page.focus("#sections-remove-2")
    page.keyboard.press("Enter")
    expect(page.locator("#sections-remove-1")).to_be_focused()
    assert [piece["length_m"] for piece in told(page, "bar.sections")] == pytest.approx([0.12, 0.12])
    page.click("#bar-uniform")
    expect(page.locator("#field-bar-length")).to_have_value("240 mm")
    expect(page.locator("#field-bar-youngs_modulus")).to_have_value("114 GPa")
    assert told(page, "bar.mass_kg") == pytest.approx(4430.0 * 0.24 * np.pi / 4 * (0.03**2 - 0.008**2), rel=1e-5)


def test_a_wrong_cell_is_told_beside_it(desk: Desk, request: pytest.FixtureRequest) -> None:
    request.node.expected_words = ("422",)
    page = desk.open("machine=mini-breaker")
    build_piston(page)
    for name, wrong, right, words in (
        ("diameter", "30 kg", "30 mm", "unit of mass"),
        ("bore", "40 mm", "8 mm", "less than the diameter"),
        ("density", "1 kg/m^3", "", ""),
    ):
        cell = f"#field-bar-sections-1-{name}"
        page.fill(cell, wrong)
        place = "material" if name == "density" else name  # two answers to one question
        expect(page.locator(f"#field-bar-sections-1-{place}-problem")).to_contain_text(words or "not both")
        expect(page.locator(f"#field-bar-sections-1-{place}")).to_have_attribute("aria-invalid", "true")
        assert page.locator("#field-bar-sections-0-length-problem").inner_text() == ""
        expect(page.locator("#verdict")).to_have_text("No answer")
        page.fill(cell, right)
        expect(page.locator(f"#field-bar-sections-1-{place}-problem")).to_have_text("")
    expect(page.locator("#verdict")).not_to_have_text("No answer")


def test_sections_in_plain_numbers(
    desk: Desk, capsys: pytest.CaptureFixture[str], tmp_path: Path, request: pytest.FixtureRequest
) -> None:
    request.node.expected_words = ("422",)
    load = "load.kind=harmonic&load.mean=0.5&load.amplitude=1"
    page = desk.open(f"system.s=20&system.d=0.005&system.restitution=0.3&system.strain=reversed&{load}")
    page.click("#bar-sections")
    expect(page.locator("#field-system-strain option")).to_have_count(2)  # reversed is not offered
    page.click("#sections-add")
    page.fill("#field-system-impedances-1", "")
    expect(page.locator("#field-system-impedances-problem")).not_to_have_text("")
    page.fill("#field-system-impedances-1", "2.5")
    page.fill("#field-system-transit_times-1", "1.5")
    page.select_option("#field-load-at", "1")
    page.click("#tab-report")
    path = tmp_path / "plain.toml"
    path.write_text(
        "[system]\ns = 20\nd = 0.005\nrestitution = 0.3\nimpedances = [1, 2.5]\ntransit_times = [1, 1.5]\n"
        '[load]\nkind = "harmonic"\nmean = 0.5\namplitude = 1\nat = 1\n',
        encoding="utf-8",
    )
    truth = steady_json(capsys, str(path))["periods"][0]["orbits"]
    speeds = [[orbit["phase"], orbit["impact_velocity"]] for orbit in truth]
    answer = "data.steady?.periods[0].orbits.map((orbit) => [orbit.phase, orbit.impact_velocity])"
    now = f"JSON.stringify({answer}) === JSON.stringify({json.dumps(speeds)})"
    until(page, f"import('/static/core/state.js').then(({{ data }}) => {now})")
    page.click("#tab-case")
    page.click("#bar-uniform")
    expect(page.locator("#sections")).to_have_count(0)
    assert "at" not in knows(page, "core/state.js:data.tables.load")


OF_B77 = "system.s=20&system.d=0.01&system.restitution=0.3&load.kind=harmonic&load.mean=0.5&load.amplitude=1"


@pytest.mark.parametrize("words", ["machine=mini-breaker", OF_B77])
def test_another_law_of_damping_damps_the_first_mode_alike(desk: Desk, words: str) -> None:
    page = desk.open(words)
    table = "bar" if "machine" in words else "system"
    first = told(page, "body.damping[0]")
    others = []
    for law in ("kelvin_voigt", "table", "external", "ratio"):
        page.select_option(f"#field-{table}-damping", law)
        expect(page.locator(f"#field-{table}-damping")).to_have_value(law)
        rates = told(page, "body.damping")
        assert rates[0] == pytest.approx(first, rel=1e-3)  # four digits are written, every time
        others.append(rates[1] / rates[0])
        system = case_of(knows(page, "core/state.js:data.tables"), "page").system()
        assert system.body.damping.kind == law
    assert others == pytest.approx([4.0, 4.0, 1.0, 2.0], rel=1e-3)  # of η, of its table, of a drag, of a ratio
    value = "#field-bar-damping_ratio" if table == "bar" else "#field-system-damping-value"
    page.fill(value, "0.004")
    assert told(page, "laws.damping").startswith("damping ratio 0.004")


def test_strain_and_a_load_of_steps_are_chosen(desk: Desk, request: pytest.FixtureRequest) -> None:
    request.node.expected_words = ("422",)
    page = desk.open("machine=mini-breaker&load.kind=square&load.mean=&load.amplitude=2+kN&load.kappa=1.3")
    before = page.locator("#headline .figures").inner_text()
    page.select_option("#field-load-kind", "steps")
    expect(page.locator("#field-load-values")).to_have_value("2, -2")
    expect(page.locator("#field-load-unit")).to_have_value("kN")
    desk.answered()
    expect(page.locator("#headline .figures")).to_have_text(before, use_inner_text=True)  # the same load
    page.fill("#field-load-breaks", "0, 2, 3")
    expect(page.locator("#field-load-breaks-problem")).to_contain_text("one for each value")
    page.fill("#field-load-values", "2, 0, -2")
    expect(page.locator("#field-load-breaks-problem")).to_have_text("")
    page.select_option("#field-contact-strain", "kept")
    assert knows(page, "core/state.js:data.tables.contact.strain") == "kept"
    page.select_option("#field-contact-strain", "")
    assert "strain" not in knows(page, "core/state.js:data.tables.contact")


@pytest.mark.parametrize("desk", [{"viewport": {"width": 390, "height": 844}, "has_touch": True}], indirect=True)
def test_sections_do_not_stick_out_of_a_phone(desk: Desk) -> None:
    page = desk.open("panel=case&machine=mini-breaker")
    build_piston(page)
    expect(page.locator("#sections tbody tr")).to_have_count(2)
    assert page.evaluate("document.documentElement.scrollWidth") <= 390


def test_the_size_of_a_section_is_an_axis(desk: Desk) -> None:
    page = desk.open("machine=mini-breaker")
    build_piston(page)
    told(page, "bar.sections")
    page.click("#tab-map")
    page.select_option("#map-x", "bar.sections[1].length")
    until(page, "decodeURIComponent(location.hash).includes('x=bar.sections[1].length')")
    page.wait_for_selector("#map[data-coarse='8']")
    expect(page.locator("#map-readout")).to_contain_text("mm")
    page.focus("#map")
    page.keyboard.press("Shift+ArrowRight")
    until(page, "Number(document.querySelector('#map').dataset.design.split(',')[0]) > 121")
    page.click("#tab-case")
    expect(page.locator("#field-bar-sections-1-length")).not_to_have_value("120 mm")
