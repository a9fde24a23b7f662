"""The page of the workbench in a real browser: its head, the case, links, paper, and what everybody needs."""

from __future__ import annotations

import json
import os
import re
import time
import zlib
from importlib import resources
from pathlib import Path
from typing import Any

import httpx
import numpy as np
import pytest
from starlette.requests import Request

pytest.importorskip("fastapi")

from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import Browser, Page, expect

from percuss.case import Case
from percuss.case.catalogue.sample_cases import machine_text, write_history
from percuss.case.file_format.plain_tables import case_of
from percuss.cli import main
from percuss.web.page_files import Shelf
from web_desk import (
    PANELS,
    WAIT,
    Desk,
    blown,
    driven,
    figure,
    ink,
    knows,
    served,
    slide,
    steady_json,
    until,
)

IMAGES = os.environ.get("PERCUSS_IMAGES")  # a folder: the pictures of docs/workbench.md are made anew there

pytestmark = pytest.mark.browser


# --- what is served


def test_the_modules_are_loaded_at_once() -> None:
    """Every module stands in index.html: the browser asks for all of them without reading one after the other."""
    folder = Path(str(resources.files("percuss.web").joinpath("page")))
    request = Request({"type": "http", "method": "GET", "path": "/", "headers": []})
    index = bytes(Shelf().answer(request, "index.html").body).decode()
    preloaded = re.findall(r'rel="modulepreload" href="/static/([^"]+)"', index)
    assert preloaded == sorted(path.name for path in folder.glob("*.js"))
    assert not re.search(r"""(?:src|href|from|import)\s*[=(]?\s*["'](?:https?:)?//""", index)


NOTES = """
import { panel as first } from "./case_panel.js";
import { h, put } from "./dom.js";
import { on, view } from "./state.js";

const panel = {
  name: "notes",
  title: "Notes",
  defaults: { page: 3 },
  start: (section) => on("view", () => put(section, h("p", {}, `page ${view.page}`))),
};
export const PANELS = [first, panel];
"""


def test_a_panel_is_one_object_in_the_list(desk: Desk, request: pytest.FixtureRequest) -> None:
    """What a panel exports is all that the page needs of it: its tab, its section, its part of the address."""
    request.node.expected_words = ("preload",)  # the browser itself remarks on modules that this list leaves out
    desk.page.route("**/static/panels.js", lambda route: route.fulfill(content_type="text/javascript", body=NOTES))
    page = desk.open("machine=mini-breaker")
    assert page.locator("#tabs button").all_inner_texts() == ["Case", "Notes"]
    page.click("#tab-notes")
    expect(page.locator("#panel-notes")).to_have_text("page 3")
    until(page, "location.hash.startsWith('#panel=notes')")
    assert "page" not in page.evaluate("new URLSearchParams(location.hash.slice(1)).keys().toArray()")
    page.evaluate("location.hash += '&page=7'")
    expect(page.locator("#panel-notes")).to_have_text("page 7")


# --- case


def test_the_answer_comes_first_and_equals_the_command_line(desk: Desk, capsys: pytest.CaptureFixture[str]) -> None:
    page = desk.open("panel=report&machine=mini-breaker")
    expect(page.locator("#report-cards .card")).to_have_count(15)
    orbits = steady_json(capsys, "mini-breaker")["periods"][0]["orbits"]
    truth = next(orbit for orbit in orbits if orbit["stable"] and orbit["admissible"])["si"]
    for card in page.locator("#report-cards [data-figure]").all():
        name = card.get_attribute("data-figure") or ""
        assert float(card.get_attribute("data-value") or "nan") == truth[name], name
    expect(page.locator("#verdict")).to_have_text("Stable")
    assert figure(page, "blow energy") == "180J"


def test_the_answer_does_not_wait_for_the_compiler(browser: Browser, tmp_path: Path) -> None:
    """On a machine that has never compiled the kernels: the steady motions are told, and what is still to come."""
    with served(NUMBA_CACHE_DIR=str(tmp_path)) as address:
        desk = Desk(browser, address)
        page = desk.open("panel=report&machine=mini-breaker")
        assert figure(page, "blow energy") == "180J"
        expect(page.locator("#report-cards .card")).to_have_count(15)
        preparing = page.locator("#preparing")
        expect(preparing).to_contain_text("being compiled")
        assert not httpx.get(f"{address}api/about").json()["ready"]
        page.route("**/api/about", lambda route: route.fulfill(json={"ready": True}))
        expect(preparing).to_be_hidden()
        desk.context.close()


def test_a_value_typed_into_the_case_changes_the_answer(desk: Desk) -> None:
    page = desk.open("machine=mini-breaker")
    page.fill("#field-bar-length", "640 mm")
    expect(page.locator("#headline .figures").locator("dd").first).not_to_have_text("180J")
    until(page, "location.hash.includes('bar.length=640+mm')")


def test_a_wrong_value_is_told_beside_its_field(desk: Desk, request: pytest.FixtureRequest) -> None:
    request.node.expected_words = ("422",)  # the browser itself remarks on a refused request
    page = desk.open("machine=mini-breaker")
    page.fill("#field-bar-length", "34 kg")
    expect(page.locator("#field-bar-length-problem")).to_contain_text("length")
    expect(page.locator("#field-bar-length")).to_have_attribute("aria-invalid", "true")
    expect(page.locator("#verdict")).to_have_text("No answer")
    page.fill("#field-bar-length", "320 mm")
    expect(page.locator("#field-bar-length-problem")).to_have_text("")
    expect(page.locator("#verdict")).to_have_text("Stable")


def test_a_machine_is_picked_and_shown_in_plain_numbers_and_back(desk: Desk) -> None:
    page = desk.open("machine=mini-breaker")
    page.select_option("#machine", "laboratory-striker")
    expect(page.locator("#headline .title")).to_contain_text("Laboratory striker")
    expect(page.locator("#field-bar-length")).to_have_value("200 mm")
    page.click("#form-plain")
    expect(page.locator("#field-system-restitution")).to_be_visible()
    assert figure(page, "blow energy") != "7.5J"
    page.click("#form-si")
    expect(page.locator("#field-bar-length")).to_have_value("200 mm")


def test_a_case_goes_out_as_toml_and_comes_back(desk: Desk, tmp_path: Path) -> None:
    page = desk.open("machine=mini-breaker")
    slide(page, "restitution", 0.25)
    until(page, "location.hash.includes('contact.restitution=0.25')")
    moved = page.locator("#field-contact-restitution").input_value()
    page.wait_for_timeout(400)
    with page.expect_download() as waiting:
        page.click("#case-download")
    path = tmp_path / "case.toml"
    waiting.value.save_as(path)
    assert f"restitution = {moved}" in path.read_text(encoding="utf-8")
    page.select_option("#machine", "heavy-breaker")
    expect(page.locator("#field-bar-length")).to_have_value("1.01 m")
    page.set_input_files("#upload-toml", path)
    expect(page.locator("#field-bar-length")).to_have_value("320 mm")
    expect(page.locator("#field-contact-restitution")).to_have_value(moved)


def test_a_wrong_case_file_is_refused_beside_the_field(
    desk: Desk, tmp_path: Path, request: pytest.FixtureRequest
) -> None:
    request.node.expected_words = ("422",)
    page = desk.open("machine=mini-breaker")
    path = tmp_path / "wrong.toml"
    path.write_text(machine_text("mini-breaker").replace('"320 mm"', '"320 kg"'), encoding="utf-8")
    page.set_input_files("#upload-toml", path)
    expect(page.locator("#field-bar-length-problem")).to_contain_text("In the file: expected a length")
    expect(page.locator("#case-problems")).to_contain_text("not accepted")
    expect(page.locator("#field-bar-length")).to_have_value("320 mm")
    page.fill("#field-bar-length", "330 mm")
    expect(page.locator("#field-bar-length-problem")).to_have_text("")


def test_a_wrong_recording_is_refused_beside_its_field(
    desk: Desk, tmp_path: Path, request: pytest.FixtureRequest
) -> None:
    request.node.expected_words = ("422",)
    page = desk.open("machine=mini-breaker")
    path = tmp_path / "short.csv"
    path.write_text("time [s],force [N]\n0,1\n0.001,2\n", encoding="utf-8")
    page.set_input_files("#upload-history", path)
    expect(page.locator("#history-report .problem")).not_to_have_text("")
    expect(page.locator("#verdict")).to_have_text("Stable")  # the load of before is kept


def test_a_measured_history_becomes_the_load(desk: Desk, tmp_path: Path, request: pytest.FixtureRequest) -> None:
    request.node.expected_words = ("422",)
    page = desk.open(
        "machine=hydraulic-drifter&load.kind=harmonic&load.mean=4+kN&load.amplitude=10+kN&load.coefficients=&load.unit="
    )
    path = tmp_path / "pressure.csv"
    write_history(path)
    page.set_input_files("#upload-history", path)
    expect(page.locator("#history-report")).to_contain_text("area")  # a pressure needs one
    page.locator("#panel-case summary").click()
    page.fill("[data-history=area]", "6.5 cm^2")
    page.get_by_role("button", name="Read it again").click()
    expect(page.locator("#history-report")).to_contain_text("cycles used")
    expect(page.locator("#field-load-kind")).to_have_value("fourier")
    expect(page.locator("#headline .figures dd").first).to_contain_text("309.9")


DROP = """files => {
  const bag = new DataTransfer();
  for (const [name, text] of files) bag.items.add(new File([text], name));
  document.body.dispatchEvent(new DragEvent("drop", { dataTransfer: bag, bubbles: true, cancelable: true }));
}"""


@pytest.mark.parametrize("how", ["picked", "dropped"])
def test_a_case_and_its_recording_are_taken_together(
    desk: Desk, tmp_path: Path, how: str, request: pytest.FixtureRequest
) -> None:
    request.node.expected_words = ("422",)
    assert main(["new", "hydraulic-drifter", "-o", str(tmp_path / "drifter.toml")]) == 0
    files = sorted(tmp_path.iterdir())
    assert len(files) == 2
    page = desk.open("machine=mini-breaker")
    page.set_input_files("#upload-toml", tmp_path / "drifter.toml")  # alone it is refused, with what to do
    expect(page.locator("#field-load-kind-problem")).to_contain_text("together")
    if how == "picked":
        page.set_input_files("#upload-toml", files)
    else:
        page.click("#tab-map")
        page.evaluate(DROP, [[file.name, file.read_text(encoding="utf-8")] for file in files])
    expect(page.locator("#history-report")).to_contain_text("cycles used")
    expect(page.locator("#field-load-kind")).to_have_value("fourier")
    expect(page.locator("#headline .figures dd").first).to_contain_text("309.9")
    expect(page.locator("#case-problems")).to_have_text("")


def test_of_two_machines_picked_in_a_row_the_later_holds(desk: Desk) -> None:
    page = desk.open("machine=mini-breaker")
    held: list[Any] = []
    page.route("**/api/machines/heavy-breaker", lambda route: held.append(route))
    page.select_option("#machine", "heavy-breaker")
    page.wait_for_timeout(100)
    page.select_option("#machine", "laboratory-striker")
    expect(page.locator("#field-bar-length")).to_have_value("200 mm")
    held[0].continue_()
    page.wait_for_timeout(500)  # the late answer has come
    expect(page.locator("#field-bar-length")).to_have_value("200 mm")
    expect(page.locator("#machine")).to_have_value("laboratory-striker")


def test_a_number_beyond_all_bounds_is_told_beside_its_field(desk: Desk, request: pytest.FixtureRequest) -> None:
    request.node.expected_words = ("422",)
    page = desk.open("machine=mini-breaker")
    page.fill("#field-bar-length", "1e400")
    expect(page.locator("#field-bar-length-problem")).to_contain_text("expected a length")
    page.fill("#field-bar-length", "320 mm")
    page.fill("#periods", "0")
    expect(page.locator("#periods")).to_have_attribute("aria-invalid", "true")
    page.keyboard.press("Tab")
    expect(page.locator("#periods")).to_have_value("1")
    assert page.locator("#periods").get_attribute("aria-invalid") is None


# --- sections, damping, strain, steps

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
    end = time.monotonic() + WAIT / 1000
    while knows(page, "state.js:data.info?.tables") != knows(page, "state.js:data.tables"):
        assert time.monotonic() < end, page.locator("#headline").inner_text()
        page.wait_for_timeout(30)
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
    until(page, f"import('/static/state.js').then(({{ data }}) => {now})")
    page.click("#tab-case")
    page.click("#bar-uniform")
    expect(page.locator("#sections")).to_have_count(0)
    assert "at" not in knows(page, "state.js:data.tables.load")


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
        system = case_of(knows(page, "state.js:data.tables"), "page").system()
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
    assert knows(page, "state.js:data.tables.contact.strain") == "kept"
    page.select_option("#field-contact-strain", "")
    assert "strain" not in knows(page, "state.js:data.tables.contact")


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


# --- the link


def test_a_link_reproduces_the_view(desk: Desk, browser: Browser, server: str) -> None:
    page = desk.open("panel=orbits&machine=mini-breaker")
    slide(page, "load_factor", 0.34)
    page.get_by_role("button", name=re.compile("^Motion 1 of 2")).click()
    until(page, "location.hash.includes('orbit=1') && location.hash.includes('load.mean')")
    page.wait_for_timeout(500)
    other = Desk(browser, server)
    twin = other.open(page.url.partition("#")[2])
    expect(twin.locator("#tab-orbits")).to_have_attribute("aria-selected", "true")
    expect(twin.locator("#orbit-table")).to_have_text(page.locator("#orbit-table").inner_text(), use_inner_text=True)
    expect(twin.locator("#headline .figures")).to_have_text(
        page.locator("#headline .figures").inner_text(), use_inner_text=True
    )
    other.context.close()


def test_a_link_reproduces_an_uploaded_case(desk: Desk, browser: Browser, server: str, tmp_path: Path) -> None:
    path = tmp_path / "own.toml"
    text = machine_text("laboratory-striker")
    path.write_text(re.sub(r'title = ".*"', 'title = "A hammer of my own"', text), encoding="utf-8")
    page = desk.open("panel=case&machine=mini-breaker")
    page.set_input_files("#upload-toml", path)
    expect(page.locator("#headline .title")).to_have_text("A hammer of my own")
    page.click("#tab-map")
    page.select_option("#map-q", "reduced_margin")
    until(page, "location.hash.includes('q=reduced_margin') && !location.hash.includes('machine=')")
    other = Desk(browser, server)
    twin = other.open(page.url.partition("#")[2])
    expect(twin.locator("#headline .title")).to_have_text("A hammer of my own")
    expect(twin.locator("#map-q")).to_have_value("reduced_margin")
    same = page.locator("#headline .figures").inner_text()
    expect(twin.locator("#headline .figures")).to_have_text(same, use_inner_text=True)
    other.context.close()


def test_a_link_to_the_plain_form_and_a_link_to_nothing(desk: Desk, request: pytest.FixtureRequest) -> None:
    request.node.expected_words = ("404",)
    page = desk.open("machine=mini-breaker")
    page.click("#form-plain")
    until(page, "location.hash.includes('system.s=')")
    page.reload()
    desk.answered()
    expect(page.locator("#field-system-restitution")).to_have_value("0.1")
    expect(page.locator("#verdict")).to_have_text("Stable")
    page.click("#form-si")
    expect(page.locator("#field-bar-length")).to_have_value("320 mm")
    desk.open("machine=no-such-hammer")
    expect(page.locator("#verdict")).to_have_text("No answer")
    page.select_option("#machine", "mini-breaker")
    expect(page.locator("#verdict")).to_have_text("Stable")
    page.route("**/api/machines/heavy-breaker", lambda route: route.abort())
    request.node.expected_words = ("404", "ERR_FAILED")
    page.select_option("#machine", "heavy-breaker")
    expect(page.locator("#verdict")).to_have_text("No answer")
    expect(page.locator("#machine")).to_have_value("mini-breaker")  # the one that is there
    page.unroute("**/api/machines/heavy-breaker")
    page.select_option("#machine", "heavy-breaker")
    expect(page.locator("#field-bar-length")).to_have_value("1.01 m")
    page.select_option("#machine", "mini-breaker")
    expect(page.locator("#verdict")).to_have_text("Stable")


def test_a_link_keeps_what_the_hammer_strikes(desk: Desk) -> None:
    """Tables without a form of their own stay with the case, in its address and in its file."""
    page = desk.open("machine=mini-breaker&rock.stiffness=200 kN/mm")
    expect(page.locator("#verdict")).to_have_text("Stable")
    page.fill("#field-bar-length", "330 mm")
    until(page, "location.hash.includes('bar.length=330') && location.hash.includes('rock.stiffness=200')")
    with page.expect_download() as coming:
        page.click("#case-download")
    case = Case.from_text(coming.value.path().read_text(encoding="utf-8"))
    assert case.blow_question().target.rock.stiffness == 2e8
    assert case.system().bar.length == 0.33  # as it is now, though the answer may not have come


def test_the_token_is_taken_out_of_the_address(browser: Browser) -> None:
    word = "a-word-for-the-tests"
    with served("--token", word) as address:
        desk = Desk(browser, address)
        page = desk.open(f"token={word}&panel=report&machine=mini-breaker")
        expect(page.locator("#verdict")).to_have_text("Stable")
        assert word not in page.url
        desk.context.close()


def test_going_back_shows_the_panel_before(desk: Desk) -> None:
    page = desk.open("panel=case&machine=mini-breaker")
    page.click("#tab-report")
    until(page, "location.hash.includes('panel=report')")
    page.go_back()
    expect(page.locator("#panel-case")).to_be_visible()


def test_going_back_shows_the_machine_before(desk: Desk) -> None:
    page = desk.open("panel=orbits&machine=mini-breaker")
    page.select_option("#machine", "heavy-breaker")
    until(page, "location.hash.includes('machine=heavy-breaker')")
    page.go_back()
    expect(page.locator("#headline .title")).to_have_text("Hydraulic breaker for a mini excavator")
    expect(page.locator("#machine")).to_have_value("mini-breaker")


@pytest.mark.parametrize(
    "words",
    [
        "panel=map&machine=mini-breaker&xr=e:-&q=nothing&x=nothing",
        "panel=case&machine=mini-breaker&load.kind=fourier&load.coefficients=5",
        "panel=case&machine=mini-breaker&load.kind=fourier&load.coefficients=[[1,2],3]",
        "panel=nothing&m=0&orbit=99&lesson=9&scene=9&cycles=0&machine=mini-breaker",
    ],
)
def test_nonsense_in_a_link_is_told_and_can_be_left(desk: Desk, request: pytest.FixtureRequest, words: str) -> None:
    request.node.expected_words = ("422",)
    page = desk.open(words)
    page.wait_for_timeout(300)
    assert "is not a function" not in page.locator("body").inner_text()
    assert "expected a valid number" not in page.locator("#map-status").inner_text()
    page.select_option("#machine", "heavy-breaker")
    expect(page.locator("#slide-bar-length")).to_have_attribute("aria-valuetext", re.compile("^1\\.01"))
    page.fill("#periods", "1")
    expect(page.locator("#verdict")).to_have_text("Stable")


# --- on paper


def pictures_of(data: bytes) -> list[tuple[float, float]]:
    """Of every picture in a PDF its width over its height: in pixels, and as it is printed."""
    objects = dict(re.findall(rb"(?:^|\n)(\d+) 0 obj\s(.*?)endobj", data, re.DOTALL))
    pixels: dict[bytes, float] = {}
    for number, body in objects.items():
        size = [re.search(rb"/%s (\d+)" % name, body) for name in (b"Width", b"Height")]
        if b"/Subtype /Image" in body and size[0] and size[1] and int(size[0][1]) > 200:
            pixels[number] = int(size[0][1]) / int(size[1][1])
    found = []
    for page_ in objects.values():
        if not re.search(rb"/Type /Page\b", page_):
            continue
        names = dict(re.findall(rb"/(X\d+) (\d+) 0 R", page_))
        content = re.search(rb"/Contents (\d+) 0 R", page_)
        assert content is not None
        packed = re.search(rb"stream\r?\n(.*?)endstream", objects[content[1]], re.DOTALL)
        assert packed is not None
        kept, now = [], np.eye(3)
        words: list[bytes] = []
        for word in zlib.decompressobj().decompress(packed[1]).split():
            if word == b"q":
                kept.append(now)
            elif word == b"Q":
                now = kept.pop()
            elif word == b"cm":
                a, b, c, d, e, f = (float(number) for number in words[-6:])
                now = np.array([[a, b, 0.0], [c, d, 0.0], [e, f, 1.0]]) @ now
            elif word == b"Do" and pixels.get(names.get(words[-1][1:], b"")):
                printed = np.hypot(*now[0, :2]) / np.hypot(*now[1, :2])
                found.append((pixels[names[words[-1][1:]]], float(printed)))
            words.append(word)
    return found


@pytest.mark.parametrize("panel, least", [("orbits", 4), ("motion", 2)])
def test_pictures_keep_their_proportions_on_paper(desk: Desk, panel: str, least: int) -> None:
    page = desk.open(f"panel={panel}&machine=mini-breaker")
    page.locator(f"#panel-{panel} figure.chart canvas").first.scroll_into_view_if_needed()
    page.wait_for_selector(f"#panel-{panel} canvas[data-drawn]")
    page.wait_for_timeout(500)
    found = pictures_of(page.pdf())
    assert len(found) >= least
    for pixels, printed in found:
        assert printed == pytest.approx(pixels, rel=0.01)


@pytest.mark.parametrize("desk", [{"color_scheme": "dark"}], indirect=True)
def test_paper_is_light_and_a_stable_disc_stays_a_disc(desk: Desk) -> None:
    page = desk.open("panel=orbits&machine=mini-breaker")
    page.wait_for_timeout(500)
    chart = "#panel-orbits .grid .card:nth-child(1) figure > canvas"
    dark = ink(page, chart)
    page.evaluate("dispatchEvent(new Event('beforeprint'))")
    assert knows(page, "colours.js:theme().dark") is False
    assert ink(page, chart) != dark
    page.evaluate("dispatchEvent(new Event('afterprint'))")
    assert knows(page, "colours.js:theme().dark") is True
    page.emulate_media(media="print")
    assert page.evaluate("getComputedStyle(document.documentElement).colorScheme") == "light"
    look = "getComputedStyle(document.querySelector('.badge.good'), '::before')"
    disc = page.evaluate(f"(({{ width, borderLeftWidth, backgroundColor }}) => [width, borderLeftWidth])({look})")
    assert disc == ["0px", "7px"]  # filled by its edge: a background is left out on paper
    assert page.evaluate("getComputedStyle(document.querySelector('.badge')).printColorAdjust") == "exact"


# --- for everybody


def show_panel(page: Page, name: str) -> None:
    """A panel of the case, or the machine of another one."""
    if name == "a valve":
        page.click("#tab-machine")
        page.click("#machine-open")
        return driven(page)
    page.click(f"#tab-{name}")
    page.wait_for_timeout(300)


@pytest.mark.parametrize(
    ("desk", "rules"),
    [({"color_scheme": "light"}, None), ({"color_scheme": "dark"}, ["color-contrast"])],
    indirect=["desk"],
)
def test_no_serious_accessibility_violation(desk: Desk, rules: list[str] | None) -> None:
    """All rules in one scheme; of the other the colours, which are all that differs."""
    options = {"resultTypes": ["violations"]} | ({"runOnly": rules} if rules else {})
    found = []
    page = desk.open("panel=case&machine=mini-breaker")
    for panel in (*PANELS, "a valve"):
        show_panel(page, panel)
        for violation in Axe().run(page, options=options).response["violations"]:
            if violation["impact"] in ("serious", "critical"):
                where = [node["html"][:160] for node in violation["nodes"][:3]]
                found.append((panel, violation["id"], where))
    assert found == []


@pytest.mark.parametrize("desk", [{"color_scheme": "dark"}], indirect=True)
def test_dark_and_light(desk: Desk) -> None:
    page = desk.open("panel=orbits&machine=mini-breaker")
    background = "getComputedStyle(document.body).backgroundColor"
    dark = page.evaluate(background)
    chart = "#panel-orbits .grid .card:nth-child(1) figure > canvas"
    page.wait_for_selector(f"{chart}[data-drawn]")
    page.wait_for_timeout(500)
    before = ink(page, chart)
    page.click("#theme")
    expect(page.locator("#theme")).to_have_text("Theme: light")
    assert page.evaluate(background) != dark
    page.wait_for_timeout(100)
    assert ink(page, chart) != before
    page.reload()
    desk.answered()
    expect(page.locator("#theme")).to_have_text("Theme: light")


@pytest.mark.parametrize("desk", [{"viewport": {"width": 390, "height": 844}, "has_touch": True}], indirect=True)
def test_a_phone_shows_one_column_and_nothing_sticks_out(desk: Desk) -> None:
    page = desk.open("panel=case&machine=mini-breaker")
    for panel in (*PANELS, "a valve"):
        show_panel(page, panel)
        assert page.evaluate("document.documentElement.scrollWidth") <= 390, panel
        assert page.evaluate("document.querySelector('main').clientWidth") > 340, panel


@pytest.mark.parametrize("desk", [{"viewport": {"width": 390, "height": 844}, "has_touch": True}], indirect=True)
def test_an_enlarged_chart_fills_a_phone(desk: Desk) -> None:
    page = desk.open("panel=motion&machine=mini-breaker")
    page.get_by_role("button", name="Enlarge: The striking end").tap()
    expect(page.locator("#zoom .main-svg").first).to_be_visible()
    dialog, plot = (page.locator(which).bounding_box() for which in ("#zoom", "#zoom .nsewdrag"))
    title = page.locator("#zoom .xtitle").bounding_box()
    assert dialog is not None
    assert plot is not None
    assert title is not None
    assert plot["width"] > 0.6 * dialog["width"]
    assert title["y"] + title["height"] < dialog["y"] + dialog["height"]


def test_the_keyboard_reaches_everything(desk: Desk) -> None:
    page = desk.open("panel=case&machine=mini-breaker")
    page.keyboard.press("Tab")
    assert page.evaluate("document.activeElement.className") == "skip"
    for _ in range(5):
        page.keyboard.press("Tab")
        if page.evaluate("document.activeElement.id") == "share":
            break
    for _ in range(4):
        page.keyboard.press("Tab")
        if page.evaluate("document.activeElement.id") == "tab-case":
            break
    assert page.evaluate("document.activeElement.id") == "tab-case"
    outline = page.evaluate("getComputedStyle(document.activeElement).outlineWidth")
    assert outline == "3px"
    page.keyboard.press("ArrowRight")
    expect(page.locator("#panel-map")).to_be_visible()
    page.keyboard.press("End")
    expect(page.locator("#panel-lessons")).to_be_visible()
    page.focus("#slide-restitution")
    before = page.locator("#slide-restitution").input_value()
    page.keyboard.press("ArrowRight")
    until(page, "location.hash.includes('contact.restitution')")
    assert page.locator("#slide-restitution").input_value() != before


def test_the_focus_stays_when_what_has_it_is_painted_anew(desk: Desk) -> None:
    held: list[Any] = []
    desk.page.route("**/api/steady", lambda route: held.append(route))
    page = desk.open("panel=motion&machine=mini-breaker")
    for _ in range(100):
        if held:
            break
        page.wait_for_timeout(50)
    here = "document.activeElement.textContent || document.activeElement.id"
    page.get_by_role("button", name=re.compile("^Motion 1 of 2")).focus()
    held[0].continue_()
    expect(page.locator("#headline .figures div").nth(4)).not_to_contain_text("…")  # the peak stress has come
    assert page.evaluate(here) == "Motion 1"
    page.get_by_role("button", name="From a start").focus()
    page.keyboard.press("Enter")
    expect(page.locator("#start-kind")).to_be_visible()
    assert page.evaluate(here) == "From a start"
    page.focus("#window")
    page.keyboard.press("ArrowDown")
    until(page, "location.hash.includes('window=start') || location.hash.includes('source=start')")
    assert page.evaluate("document.activeElement.id") == "window"


def test_the_focus_is_seen_wherever_it_goes(desk: Desk) -> None:
    page = desk.open("panel=map&machine=mini-breaker")
    seen = {}
    for _ in range(60):
        page.keyboard.press("Tab")
        name, style, width = page.evaluate(
            """() => {
              const here = document.activeElement;
              const { outlineStyle, outlineWidth } = getComputedStyle(here);
              return [here.id || here.className || here.tagName, outlineStyle, Number.parseFloat(outlineWidth)];
            }"""
        )
        if name == "BODY":
            break
        seen[name] = (style, width)
    assert {"machine", "sound", "share", "tab-map", "slide-restitution", "periods", "map-x", "map-q", "map"} <= set(
        seen
    )
    assert {name: ring for name, ring in seen.items() if ring[0] == "none" or ring[1] < 3.0} == {}


def test_the_policy_holds_and_a_title_is_never_markup(desk: Desk) -> None:
    page = desk.open("panel=report&machine=mini-breaker&title=%3Cimg+src%3Dx+onerror%3Dalert(1)%3E")
    expect(page.locator("#headline .title")).to_contain_text("<img")
    assert page.locator("#headline img").count() == 0
    page.evaluate(
        """() => {
          const script = document.createElement("script");
          script.textContent = "window.x = 1";
          document.head.append(script);
        }"""
    )
    assert page.evaluate("window.x === undefined")
    assert any("Content Security Policy" in line for line in desk.said)
    desk.said.clear()


# --- the pictures of the documentation


@pytest.mark.skipif(not IMAGES, reason="PERCUSS_IMAGES names no folder for the pictures")
def test_pictures(desk: Desk) -> None:
    from PIL import Image

    folder = Path(IMAGES or ".")
    desk.page.set_viewport_size({"width": 1360, "height": 1080})
    views = {
        "case": "panel=case&machine=hydraulic-drifter",
        "map": "panel=map&machine=mini-breaker",
        "orbits": "panel=orbits&machine=hydraulic-drifter",
        "branches": "panel=branches&bmodes=0&depth=3&alongr=0.75:1&settled=1&spot=0.8,2.84&system.s=20&system.d=0.005"
        "&system.restitution=0.8&load.kind=harmonic&load.mean=0.945&load.amplitude=1&title=Pneumatic+hammer",
        "motion": "panel=motion&machine=hydraulic-drifter",
        "machine": "panel=machine&machine=valve-breaker",
        "blow": "panel=blow&machine=stepped-drifter",
        "report": "panel=report&machine=hydraulic-drifter",
        "experiment": "panel=experiment&system.s=20&system.d=0.005&system.restitution=0.8&load.kind=harmonic"
        "&load.mean=0.945&load.amplitude=1&title=Pneumatic+hammer",
        "lessons": "panel=lessons&machine=mini-breaker",
    }
    for name, words in views.items():
        page = desk.open(words)
        page.wait_for_timeout(2500)
        if name == "map":
            page.wait_for_selector("#map[data-fine][data-curves]", timeout=120_000)
            page.wait_for_timeout(8000)  # the last points of the curves
        if name == "branches":
            expect(page.locator("#branches-settled")).to_contain_text("Found", timeout=120_000)
        if name == "motion":
            page.click("#play")
        if name == "machine":
            until(page, "document.querySelector('#machine-stage').dataset.whole === 'true'")
            page.locator("#machine-scrub").evaluate("s => { s.value = 530; s.dispatchEvent(new Event('input')); }")
        if name == "blow":
            blown(page)
            page.locator("#blow-scrub").evaluate("s => { s.value = 100; s.dispatchEvent(new Event('input')); }")
        if name == "experiment":
            page.click("#experiment-run")
            expect(page.locator("#experiment-status")).to_contain_text("all followed", timeout=60_000)
        path = folder / f"workbench-{name}.png"
        page.screenshot(path=path)
        with Image.open(path) as picture:  # a palette: half the bytes
            small = picture.convert("RGB").quantize(255, method=Image.Quantize.FASTOCTREE, dither=Image.Dither.NONE)
        small.save(path, optimize=True)
        assert path.stat().st_size < 150_000
