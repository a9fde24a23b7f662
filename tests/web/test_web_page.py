"""The page of the workbench in a real browser, against a real `percuss serve`: from the click to the changed number."""

from __future__ import annotations

import json
import math
import os
import re
import subprocess
import sys
import threading
import time
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import resources
from itertools import pairwise
from pathlib import Path
from typing import Any

import httpx
import numpy as np
import pytest
from starlette.requests import Request

pytest.importorskip("fastapi")

from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import Browser, ConsoleMessage, Page, expect, sync_playwright

from browser import FLAGS, chromium
from percuss import palette
from percuss.case import Case, load_case, machine_answer, simulation_answer
from percuss.case.catalogue.sample_cases import machine_text, write_history
from percuss.case.file_format.plain_tables import case_of
from percuss.cli import main
from percuss.stability import reduced_criterion
from percuss.steady import steady_states
from percuss.web.page_files import Shelf

PANELS = ("case", "map", "orbits", "branches", "motion", "machine", "blow", "report", "experiment", "lessons")
IMAGES = os.environ.get("PERCUSS_IMAGES")  # a folder: the pictures of docs/workbench.md are made anew there
WAIT = 60_000  # milliseconds, on a machine that does other things as well

pytestmark = pytest.mark.browser
expect.set_options(timeout=WAIT)


@contextmanager
def served(*options: str, **environment: str) -> Iterator[str]:
    """The address of a running `percuss serve`."""
    command = [sys.executable, "-m", "percuss", "serve", "--port", "0", "--no-browser", *options]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env={**os.environ, **environment}) as process:
        assert process.stdout is not None
        line = process.stdout.readline()
        found = re.search(r"http://[^/\s]+/", line)
        threading.Thread(target=process.stdout.read, daemon=True).start()
        try:
            assert found, f"percuss serve said {line!r}"
            yield found[0]
        finally:
            process.terminate()
            try:
                process.wait(20)
            except subprocess.TimeoutExpired:
                process.kill()  # else the suite would wait for ever
                raise


@pytest.fixture(scope="module")
def server() -> Iterator[str]:
    """A server whose kernels are compiled; on a fresh machine that takes longer than a test waits for anything else."""
    with served() as address:
        end = time.monotonic() + 300.0
        while not httpx.get(f"{address}api/about").json()["ready"]:
            assert time.monotonic() < end, "the kernels are not compiled"
            time.sleep(0.1)
        yield address


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    path = chromium()
    with sync_playwright() as playwright:
        found = playwright.chromium.launch(executable_path=path, args=FLAGS)
        yield found
        found.close()


def until(page: Page, true: str, timeout: int = WAIT) -> None:
    """Until a JavaScript expression is true; the page's policy stops Playwright's own way of waiting for one."""
    end = time.monotonic() + timeout / 1000
    while not page.evaluate(true):
        assert time.monotonic() < end, f"never: {true}"
        page.wait_for_timeout(20)


class Desk:
    """A page with what it did: the addresses it asked for, what the console said."""

    def __init__(self, browser: Browser, server: str, **context: Any) -> None:
        context = {"viewport": {"width": 1360, "height": 900}, "reduced_motion": "no-preference", **context}
        self.context = browser.new_context(**context)
        self.page: Page = self.context.new_page()
        self.page.set_default_timeout(WAIT)
        self.server = server
        self.asked: list[str] = []
        self.said: list[str] = []
        self.page.on("request", lambda request: self.asked.append(request.url))
        self.page.on("console", self._heard)
        self.page.on("pageerror", lambda error: self.said.append(str(error)))

    def _heard(self, message: ConsoleMessage) -> None:
        ours = "getImageData" in message.text  # a remark on what `ink` does, not on the page
        if message.type in ("error", "warning") and not ours:
            self.said.append(message.text)

    def open(self, words: str) -> Page:
        self.page.goto("about:blank")  # else only the fragment would change
        self.page.goto(f"{self.server}#{words}")
        self.answered()
        return self.page

    def answered(self) -> None:
        """Until the full answer of the case has come."""
        until(self.page, "document.documentElement.dataset.ready === '1'")
        until(self.page, "document.querySelector('#headline .badge') !== null")


@pytest.fixture
def desk(browser: Browser, server: str, request: pytest.FixtureRequest) -> Iterator[Desk]:
    """A desk of its own for every test, which must have asked nobody else and said nothing on the console."""
    found = Desk(browser, server, **getattr(request, "param", {}))
    yield found
    foreign = [url for url in found.asked if not url.startswith((server, "about:", "data:", "blob:"))]
    found.context.close()
    assert foreign == []
    expected = getattr(request.node, "expected_words", ())
    assert [line for line in found.said if not any(word in line for word in expected)] == []


def figure(page: Page, name: str) -> str:
    """A figure of the headline by its name."""
    cell = page.locator("#headline .figures div", has=page.locator("dt", has_text=re.compile(f"^{name}$")))
    return cell.locator("dd").inner_text().replace("\u202f", " ")


def slide(page: Page, name: str, value: float) -> None:
    page.locator(f"#slide-{name}").evaluate(
        "(input, value) => { input.value = value; input.dispatchEvent(new Event('input', { bubbles: true })); }", value
    )


def ink(page: Page, selector: str) -> int:
    """How much is drawn on a canvas: a checksum of its pixels."""
    found: int = page.locator(selector).evaluate(
        """canvas => {
          const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
          let sum = 0;
          for (let i = 0; i < data.length; i += 5) sum = (sum * 31 + data[i]) | 0;
          return sum;
        }"""
    )
    return found


def knows(page: Page, name: str) -> Any:
    """What a module of the page exports; it is the page's own, not another copy."""
    module, _, export = name.partition(":")
    return page.evaluate(f"import('/static/{module}').then(module => module.{export})")


def moved(page: Page) -> None:
    """Until the motion of the case as it is now is drawn."""
    end = time.monotonic() + WAIT / 1000
    while page.locator("#stage").get_attribute("data-change") != str(knows(page, "state.js:data.changed")):
        assert time.monotonic() < end, page.locator("#motion-status").inner_text()
        page.wait_for_timeout(30)


def steady_json(capsys: pytest.CaptureFixture[str], *arguments: str) -> dict[str, Any]:
    assert main(["steady", *arguments, "--json"]) == 0
    found: dict[str, Any] = json.loads(capsys.readouterr().out)
    return found


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


# --- map


def test_the_map_is_drawn_and_a_click_moves_the_design(desk: Desk) -> None:
    page = desk.open("panel=map&machine=mini-breaker")
    page.wait_for_selector("#map[data-fine='200'][data-curves]")
    before = ink(page, "#map")
    box = page.locator("#map").bounding_box()
    assert box is not None
    page.mouse.click(box["x"] + 0.75 * box["width"], box["y"] + 0.2 * box["height"])
    expect(page.locator("#verdict")).to_have_text("Stable")
    until(page, "Number(document.querySelector('#map').dataset.design.split(',')[0]) > 0.5")
    until(page, "location.hash.includes('contact.restitution=0.6')")
    assert ink(page, "#map") != before
    page.mouse.move(box["x"] + 0.75 * box["width"], box["y"] + 0.2 * box["height"])
    page.mouse.down()
    page.mouse.move(box["x"] + 0.3 * box["width"], box["y"] + 0.15 * box["height"], steps=8)
    page.mouse.up()
    expect(page.locator("#verdict")).to_have_text("No steady motion")


def test_arrow_keys_move_the_design_and_other_axes_can_be_chosen(desk: Desk) -> None:
    page = desk.open("panel=map&machine=mini-breaker")
    page.wait_for_selector("#map[data-fine='200']")
    page.focus("#map")
    for _ in range(4):
        page.keyboard.press("Shift+ArrowRight")
    until(page, "Number(document.querySelector('#map').dataset.design.split(',')[0]) > 0.25")
    page.select_option("#map-x", "load.frequency")
    until(page, "location.hash.includes('x=load.frequency')")
    page.wait_for_selector("#map[data-coarse='8']")
    expect(page.locator("#map-readout")).to_contain_text("Hz")


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


def test_a_slow_map_comes_in_strips_and_does_not_hold_up_a_move(desk: Desk) -> None:
    page = desk.open("panel=map&machine=mini-breaker&x=load.frequency&xr=15:20&y=bar.length&yr=300:340&q=power")
    page.wait_for_selector("#map[data-coarse='8']")
    expect(page.locator("#map-progress")).to_be_visible()
    expect(page.locator("#map-status")).to_contain_text("% of")
    strips = len([url for url in desk.asked if url.endswith("/api/map")])
    page.focus("#map")
    page.keyboard.press("ArrowUp")  # along the map's own axis: the map goes on
    until(page, "Number(document.querySelector('#map').dataset.design.split(',')[1]) > 320")
    page.wait_for_timeout(1000)
    assert len([url for url in desk.asked if url.endswith("/api/map")]) > strips
    assert page.locator("#map").get_attribute("data-fine") is None
    slide(page, "restitution", 0.3)  # another hammer: another map from the beginning
    until(page, "document.querySelector('#map').dataset.coarse === undefined")
    page.wait_for_selector("#map[data-coarse='8']")


def test_strips_grow_while_rows_cost_little_beside_what_a_strip_costs(desk: Desk) -> None:
    page = desk.open("panel=map&machine=mini-breaker")
    strips = """([fixed, row, first]) => import('/static/map_levels.js').then(({ rowsOfNext }) => {
      const strips = [];
      for (let rows = 0; rows < 200; rows += strips.at(-1)[0]) {
        const count = Math.min(rowsOfNext(strips, first), 200 - rows);
        strips.push([count, fixed + row * count]);
      }
      return strips;
    })"""
    assert len(page.evaluate(strips, [180, 0.5, 90])) < 10  # though the first has two rows
    assert len(page.evaluate(strips, [400, 0.0, 400])) < 10
    dear = page.evaluate(strips, [0, 20, 20])
    assert max(ms for _, ms in dear) < 300
    assert max(ms for _, ms in page.evaluate(strips, [0, 300, 300])) < 700  # no less than a row, two to learn from


def test_the_map_s_colour_is_the_verdict_of_that_hammer(desk: Desk) -> None:
    page = desk.open("panel=map&machine=mini-breaker")
    page.wait_for_selector("#map[data-fine='200']")
    seen = set()
    for right, up in ((0.25, 0.6), (0.75, 0.75), (0.75, 0.3)):
        page.locator("#map").scroll_into_view_if_needed()  # another verdict may take more lines above it
        box = page.locator("#map").bounding_box()
        assert box is not None
        x, y = right * box["width"], (1.0 - up) * box["height"]
        page.mouse.click(box["x"] + x, box["y"] + y)
        page.wait_for_timeout(300)  # the diamond stands there now: look beside it
        place = page.locator("#map").evaluate(
            """(canvas, [x, y]) => {
              const ratio = canvas.width / canvas.clientWidth;
              return [...canvas.getContext("2d").getImageData((x + 16) * ratio, y * ratio, 1, 1).data].slice(0, 3);
            }""",
            [x, y],
        )
        named = {name: knows(page, f"colours.js:theme().verdicts.{name}") for name in ("none", "unstable", "stable")}
        colour = "#" + "".join(f"{part:02x}" for part in place)
        found = next(name for name, value in named.items() if value == colour)
        orbits = steady_states(case_of(knows(page, "state.js:data.tables"), "page").system()).orbits
        verdicts = [reduced_criterion(orbit).stable for orbit in orbits]
        truth = "stable" if any(verdicts) else "unstable" if orbits else "none"
        assert found == truth
        seen.add(found)
    assert len(seen) > 1


@pytest.mark.parametrize("desk", [{"reduced_motion": "reduce"}], indirect=True)
def test_a_machine_that_switches_itself_has_its_map(desk: Desk) -> None:
    page = desk.open("panel=map&machine=valve-breaker")
    page.wait_for_selector("#map[data-fine='50']")
    legend = page.locator("#panel-map .legend li").all_inner_texts()
    assert legend == ["runs", "stays on the wall", "reaches no port", "the present design"]
    expect(page.locator("#map-status")).to_have_text("50 × 50 cells, each of a rigid piston.")
    expect(page.locator("#map-readout")).to_contain_text("port 1 → power: place = 130")
    drawn, asked = ink(page, "#map"), len([url for url in desk.asked if url.endswith("/api/map")])
    page.locator("#map").scroll_into_view_if_needed()
    box = page.locator("#map").bounding_box()
    assert box is not None
    page.mouse.click(box["x"] + 0.5 * box["width"], box["y"] + 0.88 * box["height"])  # too little pressure
    expect(page.locator("#verdict")).to_have_text("Stalls, on the tool")
    expect(page.locator("#map-readout")).to_contain_text("stalls")
    assert float(knows(page, "state.js:data.tables.load.pressure").removesuffix(" bar")) < 111
    until(page, f"{STATE}(({{ data }}) => data.info.tables.load.pressure === data.tables.load.pressure)")
    assert len([url for url in desk.asked if url.endswith("/api/map")]) == asked  # along the map's own axes
    page.select_option("#map-q", "blow_energy")
    until(page, f"{STATE}(({{ view }}) => view.q === 'blow_energy')")
    until(page, "document.querySelector('#map-status').innerText.startsWith('50')")
    assert ink(page, "#map") != drawn
    page.select_option("#map-x", "bar.damping")
    page.wait_for_selector("#map[data-fine='50']")
    page.focus("#map")
    page.keyboard.press("Shift+ArrowRight")
    until(page, f"{STATE}(({{ data }}) => data.tables.bar.damping.value > 0.5)")
    page.select_option("#machine", "mini-breaker")  # whose parameters are others
    expect(page.locator("#map-y")).to_have_value("load_factor")
    page.wait_for_selector("#map[data-coarse]")


FOUND = "panel=map&q=label&x=restitution&y=load_factor"


@pytest.mark.parametrize("system", ["20 0.005 0.6", "20 0.05 0.8"])
def test_found_motions_have_their_family_s_colour_and_tell_their_label(desk: Desk, system: str) -> None:
    s, d, restitution = system.split()
    case = f"system.s={s}&system.d={d}&system.restitution={restitution}&load.kind=harmonic&load.mean=0.7"
    page = desk.open(f"{FOUND}&{case}&load.amplitude=1")
    page.wait_for_selector("#map[data-fine='50']")
    legend = page.locator("#panel-map .legend li").all_inner_texts()
    assert set(legend) <= {*(family.name for family in palette.FAMILIES), "the present design"}
    page.locator("#map-status").scroll_into_view_if_needed()
    box = page.locator("#map").bounding_box()
    assert box is not None
    seen: dict[int, str] = {}
    for right, up in ((0.5, 0.9), (0.3, 0.6), (0.75, 0.2), (0.95, 0.45), (0.2, 0.4), (0.85, 0.55)):
        x, y = right * box["width"], (1.0 - up) * box["height"]
        page.mouse.move(box["x"] + x, box["y"] + y)
        expect(page.locator("#map-tip")).to_be_visible()
        page.wait_for_timeout(60)
        label = page.locator("#map-tip strong").inner_text()
        place = [float(number) for number in re.findall(r"= ([\d.]+)", page.locator("#map-tip").inner_text())]
        if not seen:  # the label is that of the hammer in the middle of the cell
            at = [span * round(value / span) for value, span in zip(place, (0.9 / 49, 1.0), strict=True)]
            at[1] = 0.02 + 1.18 / 49 * round((place[1] - 0.02) * 49 / 1.18)
            tables = {
                "system": {"s": float(s), "d": float(d), "restitution": at[0]},
                "load": {"kind": "harmonic", "mean": at[1], "amplitude": 1.0},
                "simulation": {"modes": 0, "impacts": 400},
            }
            assert simulation_answer(case_of(tables, "test")).motion.label == label
        near = page.locator("#map").evaluate(
            """(canvas, [x, y]) => {
              const ratio = canvas.width / canvas.clientWidth;
              const { data } = canvas.getContext("2d").getImageData((x - 4) * ratio, (y - 4) * ratio, 8, 8);
              return [...data];
            }""",
            [x, y],
        )
        colours = {"#" + "".join(f"{part:02x}" for part in near[i : i + 3]) for i in range(0, len(near), 4)}
        number = palette.family_of(label)
        assert palette.FAMILIES[number].colour.light in colours, (label, colours)
        seen[number] = label
    assert len(seen) > 2
    page.mouse.move(box["x"] - 30.0, box["y"])
    expect(page.locator("#map-tip")).to_be_hidden()


def test_the_page_has_the_palette_of_the_pictures(desk: Desk) -> None:
    page = desk.open("panel=motion&machine=mini-breaker")
    ends = [knows(page, f"colours.js:signed({share})") for share in (-1, 1)]
    told = [[int(part) for part in re.findall(r"\d+", colour)] for colour in ends]
    stops = (palette.STRAIN[0].light, palette.STRAIN[-1].light)
    assert told == [[int(stop[i : i + 2], 16) for i in (1, 3, 5)] for stop in stops]
    assert knows(page, "colours.js:theme().kinds") == [kind.light for kind in palette.KINDS]
    page.click("#tab-orbits")
    page.click("#tab-report")
    expect(page.locator('#report-cards [data-figure="momentum_N_s"]')).to_contain_text("N·s")


def test_a_range_that_is_none_is_told_and_no_map_is_shown_over_another(
    desk: Desk, request: pytest.FixtureRequest
) -> None:
    request.node.expected_words = ("422",)
    page = desk.open("panel=map&machine=mini-breaker")
    page.wait_for_selector("#map[data-fine='200'][data-curves]")
    page.fill("#map-x-from", "")
    page.keyboard.press("Tab")
    expect(page.locator("#map-range-problem")).to_contain_text("to a greater one")
    expect(page.locator("#map-x-from")).to_have_attribute("aria-invalid", "true")
    page.fill("#map-x-from", "0.1")
    page.keyboard.press("Tab")
    expect(page.locator("#map-range-problem")).to_have_text("")
    assert page.evaluate("document.activeElement.id") == "map-x-to"  # Tab leads on, though the map is another
    until(page, "location.hash.includes('xr=0.1:0.9')")
    page.wait_for_selector("#map[data-fine='200']")
    page.fill("#map-x-from", "-3")
    page.fill("#map-x-to", "5")
    page.keyboard.press("Tab")
    expect(page.locator("#map-status")).to_contain_text("restitution: expected a number from 0 to 1")
    left, right = (0.25, 0.85)  # the axes are those of the new range: the map of the range before has no place in them
    colours = page.locator("#map").evaluate(
        """(canvas, shares) => shares.map((share) => [...canvas.getContext("2d")
             .getImageData(share * canvas.width, 0.8 * canvas.height, 1, 1).data].join())""",
        [left, right],
    )
    assert colours[0] == colours[1]


def test_the_design_dragged_out_of_the_map_stays_at_its_edge(desk: Desk) -> None:
    page = desk.open("panel=map&machine=mini-breaker")
    page.wait_for_selector("#map[data-fine='200']")
    box = page.locator("#map").bounding_box()
    assert box is not None
    page.mouse.move(box["x"] + 0.5 * box["width"], box["y"] + 0.5 * box["height"])
    page.mouse.down()
    page.mouse.move(box["x"] + box["width"] + 150, box["y"] + 0.5 * box["height"], steps=3)
    page.mouse.up()
    until(page, "document.querySelector('#map').dataset.design.startsWith('0.9,')")


# --- orbits


@pytest.mark.parametrize("desk", [{"viewport": {"width": 1360, "height": 1700}}], indirect=True)
def test_a_slider_moves_the_curve_the_table_and_the_circle(desk: Desk) -> None:
    page = desk.open("panel=orbits&machine=mini-breaker")
    expect(page.locator("#orbit-table tbody tr")).to_have_count(2)
    expect(page.locator("#orbit-table")).to_contain_text("yes")
    charts = [f"#panel-orbits .grid .card:nth-child({i}) figure > canvas" for i in (1, 2, 3, 4)]
    for chart in charts:
        page.wait_for_selector(f"{chart}[data-drawn]")
    page.wait_for_timeout(600)
    before = [ink(page, chart) for chart in charts]
    slide(page, "restitution", 0.45)
    expect(page.locator("#verdict")).to_have_text("Unstable")
    for chart, old in zip(charts, before, strict=True):
        page.locator(chart).scroll_into_view_if_needed()  # out of sight it would not be painted
        until(page, f"document.querySelector('{chart}').dataset.drawn > 1")
        deadline = time.monotonic() + WAIT / 1000
        while ink(page, chart) == old and time.monotonic() < deadline:
            page.wait_for_timeout(50)
        assert ink(page, chart) != old, chart
    slide(page, "load_factor", 1.1)
    expect(page.locator("#verdict")).to_have_text("No steady motion")
    expect(page.locator("#reason")).to_contain_text("load factor")


def test_the_orbits_equal_the_command_line(desk: Desk, capsys: pytest.CaptureFixture[str]) -> None:
    page = desk.open("panel=orbits&machine=hydraulic-drifter")
    orbits = steady_json(capsys, "hydraulic-drifter")["periods"][0]["orbits"]
    rows = page.locator("#orbit-table tbody tr")
    expect(rows).to_have_count(len(orbits))
    expect(page.locator("#orbit-table")).not_to_contain_text("…")
    for row, orbit in zip(rows.all(), orbits, strict=True):
        _, phase, possible, reason, rhythm, ringing, _, _ = (cell.inner_text() for cell in row.locator("td").all())
        assert float(phase.split()[0]) == pytest.approx(orbit["phase"], abs=6e-4)
        assert possible.startswith("yes" if orbit["admissible"] else "no")
        assert reason == orbit["reason"]
        for text, name in ((rhythm, "margin_rhythm"), (ringing, "margin_ringing")):
            assert float(text.replace("−", "-")) == pytest.approx(orbit[name], abs=6e-4)
    shown = knows(page, "state.js:chosen()")
    values = [complex(*pair) for pair in shown["quick"]["multipliers"]["values"]]  # what the unit circle draws
    truth = orbits[shown["number"] - 1]["multipliers"]["moduli"]
    assert sorted(map(abs, values), reverse=True) == pytest.approx(truth, abs=1e-9)


def test_a_motion_that_does_not_strike_has_no_blow(browser: Browser, tmp_path: Path) -> None:
    """No negative speed and no negative stress: a bar so soft that its end would be leaving the wall."""
    (tmp_path / "soft.toml").write_text(
        '[bar]\nlength = "1 m"\ndiameter = "50 mm"\ndamping_ratio = 0.001\n[contact]\nrestitution = 0.21\n[load]\n'
        'kind = "harmonic"\nmean = "25 kN"\namplitude = "100 kN"\nfrequency = "3267 Hz"\n',
        encoding="utf-8",
    )
    with served(str(tmp_path / "soft.toml")) as address:
        page = Desk(browser, address).open("panel=orbits&orbit=1")
        expect(page.locator("#headline")).to_contain_text("the end does not strike forward")
        figures = dict(zip(*(page.locator(f"#headline {tag}").all_inner_texts() for tag in ("dt", "dd")), strict=True))
        for name in ("blow energy", "striking speed", "percussive power", "peak stress"):
            assert figures[name].startswith("–"), name
        assert float(figures["rhythm margin"].replace("−", "-")) < 1.0
        rows = page.locator("#orbit-table tbody tr")
        expect(rows.first).to_contain_text("no: does not strike forward")
        page.context.close()


def test_choosing_the_other_motion_changes_the_headline(desk: Desk) -> None:
    page = desk.open("panel=orbits&machine=mini-breaker")
    expect(page.locator("#verdict")).to_have_text("Stable")
    page.locator("#orbit-table tbody button").first.click()
    expect(page.locator("#verdict")).to_have_text("Unstable")
    expect(page.locator("#orbit-about")).to_contain_text("Motion 1")


def test_a_chart_can_be_enlarged(desk: Desk) -> None:
    page = desk.open("panel=orbits&machine=mini-breaker")
    page.get_by_role("button", name="Enlarge: The load").click()
    expect(page.locator("#zoom .main-svg").first).to_be_visible()
    page.keyboard.press("Escape")
    expect(page.locator("#zoom")).not_to_be_visible()


# --- motion


def test_the_bar_moves_pauses_scrubs_and_each_blow_is_counted(desk: Desk) -> None:
    page = desk.open("panel=motion&machine=mini-breaker")
    page.wait_for_selector("#stage[data-label='z=1/1']")
    page.wait_for_selector("#stage[data-blows]")  # it plays by itself
    expect(page.locator("#heard")).to_have_text(re.compile(r"8\.08.kHz"))
    page.click("#play")
    expect(page.locator("#play")).to_have_text("Play")
    still = ink(page, "#stage")
    page.wait_for_timeout(200)
    assert ink(page, "#stage") == still
    page.locator("#scrub").evaluate("i => { i.value = 500; i.dispatchEvent(new Event('input', { bubbles: true })); }")
    assert ink(page, "#stage") != still
    page.select_option("#zoom-part", "12")  # the ringing after the blow
    expect(page.locator("#slow ~ *, label:has(#slow) output")).to_have_text(re.compile("times slower"))
    page.focus("#scrub")
    page.keyboard.press("Space")
    expect(page.locator("#play")).to_have_text("Pause")
    page.click("#sound")
    expect(page.locator("#sound")).to_have_attribute("aria-pressed", "true")


def test_a_motion_from_a_chosen_start(desk: Desk) -> None:
    words = "panel=motion&source=start&window=settled&cycles=8&system.s=20&system.d=0.005&system.restitution=0.8"
    load = "&load.kind=harmonic&load.mean=0.86&load.amplitude=1&simulation.modes=0"
    page = desk.open(f"{words}{load}&start.position=0&start.velocity=-2.4&start.time=2.85")
    page.wait_for_selector("#stage[data-label='z=2/2']")
    slide(page, "load_factor", 1.0)
    page.wait_for_selector("#stage[data-label='z=1/1']")
    page.locator("#portrait").scroll_into_view_if_needed()
    page.wait_for_selector("#portrait[data-drawn]")
    page.click("#portrait", position={"x": 200, "y": 100})  # a point of the phase portrait is a start, too
    expect(page.locator("#window")).to_have_value("start")
    expect(page.locator("#start-velocity")).not_to_have_value("-2.4")
    page.fill("#start-velocity", "-0.5")
    page.keyboard.press("Tab")
    until(page, "location.hash.includes('start.velocity=-0.5')")
    with page.expect_download() as waiting:
        page.click("#motion-file")
    assert Path(waiting.value.path()).read_bytes()[:4] == b"\x89HDF"


STARTS: dict[str, tuple[dict[str, str], dict[str, Any]]] = {
    "rest": ({"position": "-20 mm", "time": "1.2 ms"}, {"position": "-20 mm", "time": "1.2 ms"}),
    "moving": ({"velocity": "1.5 m/s"}, {"position": "-20 mm", "velocity": "1.5 m/s", "time": "1.2 ms"}),
    "modal": (
        {"modal_displacement": "-0.1, 0.0005, 0.0001", "modal_velocity": "0 0.001 0"},
        {"modal_displacement": [-0.1, 0.0005, 0.0001], "modal_velocity": [0, 0.001, 0], "time": "1.2 ms"},
    ),
    "orbit": ({"orbit": "1", "velocity": "0.1 m/s"}, {"orbit": 1, "periods": 1, "velocity": "0.1 m/s"}),
    "random": ({"seed": "7"}, {"random": "rigid", "seed": 7}),
}
"""What is typed for each kind of start, and the table [start] that it is."""


def test_every_kind_of_start_of_a_case_can_be_chosen(desk: Desk) -> None:
    page = desk.open("panel=motion&machine=mini-breaker&source=start&simulation.modes=8")
    for kind, (typed, table) in STARTS.items():
        page.select_option("#start-kind", kind)
        for key, text in typed.items():
            page.fill(f"#start-{key}", text)
            page.keyboard.press("Tab")
        until(page, "document.querySelector('#start-form') !== null")
        moved(page)
        assert knows(page, "state.js:data.tables.start") == table
        motion = simulation_answer(load_case("mini-breaker").changed(start=table, simulation={"modes": 8})).motion
        expect(page.locator("#stage")).to_have_attribute("data-label", motion.label)
    page.select_option("#start-random", "ringing")
    moved(page)
    assert knows(page, "state.js:data.tables.start.random") == "ringing"


def test_a_wrong_start_is_told_beside_its_field(desk: Desk, request: pytest.FixtureRequest) -> None:
    request.node.expected_words = ("422",)
    page = desk.open("panel=motion&machine=mini-breaker&source=start")
    page.select_option("#start-kind", "moving")
    page.fill("#start-velocity", "2 kg")
    page.keyboard.press("Tab")
    expect(page.locator("#start-velocity-problem")).to_contain_text("velocity")
    expect(page.locator("#start-velocity")).to_have_attribute("aria-invalid", "true")
    page.fill("#start-velocity", "2 m/s")
    page.keyboard.press("Tab")
    expect(page.locator("#start-velocity-problem")).to_have_text("")
    page.select_option("#start-kind", "orbit")
    page.fill("#start-orbit", "9")
    page.keyboard.press("Tab")
    expect(page.locator("#start-orbit-problem")).to_contain_text("1 to 2")


def test_a_late_motion_does_not_take_back_what_is_wrong_with_its_start(
    desk: Desk, request: pytest.FixtureRequest
) -> None:
    request.node.expected_words = ("422",)
    page = desk.open("panel=motion&machine=mini-breaker&source=start")
    moved(page)
    held: list[Any] = []
    page.route("**/api/motion", lambda route: held.append(route))
    page.select_option("#start-kind", "moving")
    for _ in range(100):
        if held:
            break
        page.wait_for_timeout(50)
    page.fill("#start-velocity", "2 kg")
    page.keyboard.press("Tab")
    expect(page.locator("#start-velocity-problem")).to_contain_text("velocity")
    with page.expect_response("**/api/motion"):
        held[0].continue_()
    page.wait_for_timeout(500)  # the late motion is drawn
    expect(page.locator("#start-velocity-problem")).to_contain_text("velocity")


# --- sound


BLOWS = """async ({ pitches, energies }) => {
  const { limited, ring, strike } = await import("/static/sound.js");
  const found = [];
  for (const frequency of pitches)
    for (const energy of energies) {
      const audio = new OfflineAudioContext(1, 44100 * 0.3, 44100);
      strike(audio, limited(audio), { at: 0, ...ring({ frequency, energy, share: 1 }) });
      found.push([frequency, energy, [...(await audio.startRendering()).getChannelData(0)]]);
    }
  return found;
}"""


def test_a_blow_sounds_at_the_first_mode_and_louder_with_its_energy(desk: Desk) -> None:
    page = desk.open("machine=mini-breaker")
    energies = [5.0, 50.0, 500.0, 5000.0]
    levels: dict[float, list[float]] = {}
    for frequency, _, samples in page.evaluate(BLOWS, {"pitches": [1470.0, 8080.0], "energies": energies}):
        wave = np.array(samples)
        spectrum = np.abs(np.fft.rfft(wave * np.hanning(len(wave))))
        tones = np.fft.rfftfreq(len(wave), 1 / 44100)
        ringing = tones > 300.0  # above the thud
        assert tones[ringing][np.argmax(spectrum[ringing])] == pytest.approx(frequency, rel=0.01)
        levels.setdefault(frequency, []).append(float(np.sqrt(np.mean(wave**2))))
    for heard in levels.values():
        assert all(b > 1.1 * a for a, b in pairwise(heard))
        assert max(heard) < 1.0


PLAYED = """async ({ blows, length, rate, begin, seconds, frequency, frames }) => {
  /* the sound of a motion, placed by frames that come at uneven moments, as on a busy page */
  const { AHEAD, Track, limited } = await import("/static/sound.js");
  const audio = new OfflineAudioContext(1, 48000 * seconds, 48000);
  const track = new Track(audio, limited(audio));
  track.load({ blows, length, frequency });
  track.from(begin, rate, 0);
  track.ahead(AHEAD);
  for (const moment of frames)
    audio.suspend(moment).then(() => {
      track.ahead(audio.currentTime + AHEAD);
      audio.resume();
    });
  return [...(await audio.startRendering()).getChannelData(0)];
}"""


def played(page: Page, blows: list[dict[str, Any]], **more: Any) -> tuple[Any, list[Any]]:
    """When blows begin (s) in the sound of a motion, and the sound of each until the next."""
    asked = {"length": 6.25, "rate": 6.25, "begin": 0.7, "seconds": 6, "frequency": 1200.0, **more}
    uneven = np.cumsum(np.random.default_rng(7).uniform(0.008, 0.3, 60))
    frames = [float(moment) for moment in uneven if moment < asked["seconds"] - 0.1]
    wave = np.array(page.evaluate(PLAYED, {"blows": blows, "frames": frames, **asked}))
    loud = np.flatnonzero(np.abs(wave) > 1e-6)
    begins = loud[np.concatenate([[True], np.diff(loud) > 240])]  # after 5 ms of silence
    return begins / 48000.0, np.split(wave, begins[1:])


def test_blows_of_a_steady_motion_sound_evenly(desk: Desk) -> None:
    """However unevenly frames come, the blows are where the motion has them: far within 1 ms, over several turns."""
    page = desk.open("machine=mini-breaker")
    one = [{"time": 1.0, "energy": None, "share": 1.0}]
    begins, _ = played(page, one)
    assert len(begins) == 6 and np.abs(np.diff(begins) - 1.0).max() < 1e-4
    assert begins[0] == pytest.approx(0.3 / 6.25, abs=0.01)  # the limiter looks ahead by some milliseconds
    two = [{"time": time_, "energy": None, "share": share} for time_, share in ((1.0, 1.0), (3.5, 0.97))]
    begins, _ = played(page, two)
    assert np.diff(begins) == pytest.approx(np.resize([0.4, 0.6], len(begins) - 1), abs=1e-3)


@pytest.mark.parametrize("share", [0.3, 0.9, 0.98])
def test_a_weak_blow_is_heard_as_weak(desk: Desk, share: float) -> None:
    """Of a doubled motion: at least 8 dB softer, in the sound that comes out, and of another pitch."""
    page = desk.open("machine=mini-breaker")
    blows = [{"time": 1.0, "energy": 500.0, "share": 1.0}, {"time": 4.0, "energy": 500.0 * share, "share": share}]
    _, sounds = played(page, blows)
    strong, weak = sounds[0], sounds[1]
    level = [10.0 * np.log10(np.mean(sound[:12000] ** 2)) for sound in (strong, weak)]
    assert level[0] - level[1] >= 8.0
    tones = []
    for sound in (strong, weak):
        spectrum = np.abs(np.fft.rfft(sound[:12000] * np.hanning(12000)))
        hertz = np.fft.rfftfreq(12000, 1 / 48000)
        spectrum[hertz < 300.0] = 0.0
        tones.append(float(hertz[np.argmax(spectrum)]))
    assert tones[0] == pytest.approx(1200.0, rel=0.01) and tones[1] < 0.8 * tones[0]


def test_a_pitch_that_cannot_be_heard_is_said(desk: Desk) -> None:
    page = desk.open("machine=mini-breaker")
    heard = "import('/static/sound.js').then(m => [20, 1000, 40000].map(f => m.heardAs({ frequency: f, share: 1 })))"
    low, plain, high = (text.replace("\u202f", " ") for text in page.evaluate(heard))
    assert low == "120 Hz, 50 %; the first mode, 20 Hz, is too low to hear"
    assert plain == "1 kHz, 50 %"
    assert high == "9 kHz, 50 %; the first mode, 40 kHz, is too high to hear"


SCHEDULED = """() => {
  /* every moment of the audio clock for which the page asks a tone */
  window.asked = [];
  const start = OscillatorNode.prototype.start;
  OscillatorNode.prototype.start = function (at) {
    window.asked.push(at);
    return start.call(this, at);
  };
}"""


def test_the_page_places_blows_on_the_audio_clock(desk: Desk) -> None:
    page = desk.open("panel=motion&machine=mini-breaker&slow=0")
    page.wait_for_selector("#stage[data-blows]")
    page.evaluate(SCHEDULED)
    page.click("#sound")
    until(page, "new Set(window.asked).size > 40")
    moments = np.unique(page.evaluate("window.asked"))
    period = 1.0 / load_case("mini-breaker").system().frequency
    even = np.abs(np.diff(moments) - period) < 1e-4
    assert even.mean() > 0.8  # where a busy machine lets the picture stand still the sound begins anew
    page.click("#play")
    page.wait_for_timeout(600)
    still = page.evaluate("window.asked.length")
    page.wait_for_timeout(300)
    assert page.evaluate("window.asked.length") == still


LISTEN = """async ([seconds, gap]) => {
  /* rows of: seconds, the loudness of what came out last, how many blows the page has counted */
  const { output } = await import("/static/sound.js");
  const stage = document.getElementById("stage");
  const ear = output().context.createAnalyser();
  ear.fftSize = 1024;
  output().connect(ear);
  const samples = new Float32Array(ear.fftSize);
  const rows = [];
  const begun = performance.now();
  for (let now = 0; now < seconds; now = (performance.now() - begun) / 1000) {
    ear.getFloatTimeDomainData(samples);
    rows.push([now, Math.max(...samples.map(Math.abs)), Number(stage.dataset.blows ?? 0)]);
    await new Promise((done) => setTimeout(done, gap));
  }
  return rows;
}"""


def test_period_doubling_is_heard(desk: Desk) -> None:
    """Loud, soft, loud, soft, at two intervals in turn."""
    words = "panel=motion&source=start&window=settled&cycles=8&system.s=20&system.d=0.005&system.restitution=0.8"
    load = "&load.kind=harmonic&load.mean=0.86&load.amplitude=1&simulation.modes=0&slow=0"  # a second a load period
    page = desk.open(f"{words}{load}&start.position=0&start.velocity=-2.4&start.time=2.85")
    page.wait_for_selector("#stage[data-label='z=2/2']")
    page.click("#sound")
    time_, level, counted = np.array(page.evaluate(LISTEN, [7.5, 10])).T
    begins = [i for i in range(1, len(level)) if level[i] > 3.0 * max(level[i - 1], 0.01)]
    begins = [i for n, i in enumerate(begins) if n == 0 or time_[i] - time_[begins[n - 1]] > 0.3]
    assert abs(len(begins) - (counted[-1] - counted[0])) <= 1  # every blow, and nothing else
    heard = [float(level[i : i + 10].max()) for i in begins][:-1]
    weak, strong = sorted(float(np.median(part)) for part in (heard[0::2], heard[1::2]))  # a busy machine misses one
    assert strong > 1.2 * weak
    gaps = np.diff(time_[begins])
    gaps = gaps[gaps < 1.5]  # without one that is missed
    assert np.ptp(gaps) > 0.2 and np.all((gaps < 0.95) | (gaps > 1.05))  # 0.81 and 1.19 load periods, of a second


def test_blows_sound_in_real_time_as_well(desk: Desk) -> None:
    page = desk.open("panel=motion&machine=heavy-breaker&slow=0")
    page.wait_for_selector("#stage[data-blows]")
    expect(page.locator("label:has(#slow) output")).to_have_text("real time")
    rate = float(figure(page, "blow rate").removesuffix("Hz"))
    page.click("#sound")
    page.wait_for_timeout(300)
    time_, level, counted = np.array(page.evaluate(LISTEN, [3.0, 4])).T
    blows = counted[-1] - counted[0]
    assert blows == pytest.approx(time_[-1] * rate, abs=2.0)
    listened = np.cumsum(
        np.minimum(np.diff(time_, prepend=time_[0]), 0.02)
    )  # what a busy machine left out is no silence
    assert np.diff(listened[level > 0.05]).max() < 1.5 / rate  # each has its sound, at its own moment
    assert np.quantile(level, 0.05) < 0.5 * np.quantile(level, 0.95)  # and they are kept apart


# --- blow


def blown(page: Page) -> str:
    """The sentence of the blow, once it has come."""
    until(page, "document.querySelector('#blow-stage').dataset.key !== undefined")
    expect(page.locator("#blow-sentence")).to_contain_text("A blow of")
    return page.locator("#blow-sentence").inner_text()


def test_a_blow_says_what_the_command_line_says_and_plays(desk: Desk, capsys: pytest.CaptureFixture[str]) -> None:
    page = desk.open("panel=blow&machine=laboratory-striker")
    assert main(["blow", "laboratory-striker"]) == 0
    assert " ".join(blown(page).split()) in " ".join(capsys.readouterr().out.split())
    frame = "Number(document.querySelector('#blow-stage').dataset.frame)"
    until(page, f"{frame} > 3")  # it plays by itself
    page.click("#blow-play")
    expect(page.locator("#blow-play")).to_have_text("Play")
    page.locator("#blow-scrub").evaluate("s => { s.value = 40; s.dispatchEvent(new Event('input')); }")
    before = ink(page, "#blow-stage")
    page.click("#blow-forth")
    assert page.evaluate(frame) == 41
    assert ink(page, "#blow-stage") != before
    page.locator("#panel-blow").evaluate("panel => { panel.tabIndex = -1; panel.focus(); }")
    page.keyboard.press("ArrowLeft")
    assert page.evaluate(frame) == 40
    assert ink(page, "#blow-stage") == before
    page.keyboard.press("Space")
    expect(page.locator("#blow-play")).to_have_text("Pause")
    until(page, f"{frame} > 45")
    expect(page.locator("#blow-stage")).to_have_attribute("aria-label", re.compile("A blow of"))
    assert "J (" in page.locator("#blow-energies").inner_text()


@pytest.mark.parametrize("desk", [{"reduced_motion": "reduce"}], indirect=True)
def test_a_slider_of_the_blow_changes_its_picture_and_then_the_case(desk: Desk) -> None:
    page = desk.open("panel=blow&machine=mini-breaker")
    before = blown(page)
    page.locator("#blow-scrub").evaluate("s => { s.value = 60; s.dispatchEvent(new Event('input')); }")
    drawn = ink(page, "#blow-stage")
    slider = page.locator("#blow-slide-tool-sections-0-diameter")
    slider.evaluate("s => { s.value = 60; s.dispatchEvent(new Event('input')); }")
    until(page, "document.querySelector('#blow-stage').dataset.wait !== undefined")
    assert ink(page, "#blow-stage") != drawn
    expect(slider).to_have_attribute("aria-valuetext", re.compile("^60"))
    until(page, "location.hash.includes('tool.sections')")
    until(page, f"document.querySelector('#blow-sentence').textContent !== {json.dumps(before)}")
    slider.focus()
    page.keyboard.press("ArrowRight")
    expect(slider).to_have_attribute("aria-valuetext", re.compile(r"^60\.2"))


def test_what_a_case_without_a_tool_strikes_is_said_and_can_be_changed(desk: Desk) -> None:
    page = desk.open("panel=blow&machine=pneumatic-jackleg")
    assert "to the wall" in blown(page)
    expect(page.locator("#blow-notes")).to_contain_text("the bar strikes a rigid wall", ignore_case=True)
    page.select_option("#blow-struck", "rock")
    expect(page.locator("#blow-sentence")).to_contain_text("into the rock")
    expect(page.locator("#blow-slide-rock-stiffness")).to_be_visible()
    page.select_option("#blow-struck", "infinite")
    expect(page.locator("#blow-sentence")).to_contain_text("into the rod")
    page.select_option("#blow-struck", "none")
    expect(page.locator("#blow-sentence")).to_contain_text("to the wall")


def test_the_tool_of_a_machine_comes_back_after_a_wall(desk: Desk) -> None:
    page = desk.open("panel=blow&machine=stepped-drifter")
    before = blown(page)
    for struck, words in (("infinite", "into the rod"), ("wall", "to the wall"), ("rock", "into the rock")):
        page.select_option("#blow-struck", struck)
        expect(page.locator("#blow-sentence")).to_contain_text(words)
    assert page.locator("#blow-sentence").inner_text() == before


@pytest.mark.parametrize("desk", [{"reduced_motion": "reduce"}], indirect=True)
def test_the_blow_is_in_sight_while_its_sliders_are_moved(desk: Desk) -> None:
    page = desk.open("panel=blow&machine=stepped-drifter")
    blown(page)
    slider = page.locator("#blow-sliders input").last
    slider.focus()
    box, picture = slider.bounding_box(), page.locator("#blow-stage").bounding_box()
    assert box is not None and picture is not None
    assert picture["y"] >= 0.0 and picture["y"] + picture["height"] <= box["y"]
    assert box["y"] + box["height"] <= 900.0


def test_a_dimensionless_blow_and_one_that_cannot_be(desk: Desk, request: pytest.FixtureRequest) -> None:
    request.node.expected_words = ("422",)
    plain = "panel=blow&system.s=20&system.d=0.005&system.restitution=0.4&load.kind=harmonic&load.mean=0.6"
    page = desk.open(f"{plain}&load.amplitude=1&tool.impedance=1.5")
    assert "into the rod" in blown(page)
    expect(page.locator("#blow-scale")).to_contain_text("impedance")
    page.locator("#blow-slide-tool-impedance").evaluate("s => { s.value = 3; s.dispatchEvent(new Event('input')); }")
    until(page, "location.hash.includes('tool.impedance=3')")
    page.evaluate("import('/static/state.js').then(({ setKey }) => setKey('tool.impedance', -1))")
    expect(page.locator("#blow-problem")).to_contain_text("tool.impedance: expected a finite number greater than 0")
    expect(page.locator("#blow-problem")).to_contain_text("the case before")
    page.evaluate("import('/static/state.js').then(({ setKey }) => setKey('tool.impedance', 2))")
    expect(page.locator("#blow-problem")).to_have_text("")


def test_the_motion_says_that_its_contact_takes_no_time(desk: Desk) -> None:
    page = desk.open("panel=motion&machine=mini-breaker")
    page.get_by_role("button", name="See one blow by its waves").click()
    expect(page.locator("#panel-blow")).to_be_visible()
    assert "into the rock" in blown(page)


def test_a_thick_piston_strikes_more_than_once(desk: Desk) -> None:
    page = desk.open("panel=lessons")
    for number, says in ((1, "63.1 J"), (3, "in 4 contacts")):
        scene(page, 7, number)
        expect(page.locator("#blow-sentence")).to_contain_text(says)
    page.locator("#blow-slide-bar-diameter").evaluate("s => { s.value = 24; s.dispatchEvent(new Event('input')); }")
    expect(page.locator("#blow-sentence")).not_to_contain_text("contacts")


# --- machine

STATE = "import('/static/state.js').then"


def driven(page: Page, modes: int = 32) -> None:
    """Until the machine of the case as it is now is drawn, with so many modes."""
    end = time.monotonic() + WAIT / 1000
    stage = page.locator("#machine-stage")
    while (stage.get_attribute("data-change"), stage.get_attribute("data-modes")) != (
        str(knows(page, "state.js:data.changed")),
        str(modes),
    ):
        assert time.monotonic() < end, page.locator("#panel-machine").inner_text()
        page.wait_for_timeout(30)


def test_a_machine_says_what_the_command_line_says_and_plays(desk: Desk) -> None:
    page = desk.open("panel=machine&machine=valve-drifter")
    expect(page.locator("#verdict")).to_have_text("Runs")
    driven(page)
    si = machine_answer(load_case("valve-drifter")).to_json_dict()["si"]
    assert figure(page, "blow energy") == "301.1J"
    assert float(figure(page, "striking speed").removesuffix("m/s")) == pytest.approx(
        si["impact_velocity_m_s"], rel=1e-3
    )
    assert float(figure(page, "stroke").removesuffix("mm")) == pytest.approx(1e3 * si["stroke_m"], rel=1e-3)
    assert float(figure(page, "oil flow").removesuffix("l/min")) == pytest.approx(si["oil_flow_l_per_min"], rel=1e-3)
    until(page, "Number(document.querySelector('#machine-stage').dataset.blows) > 0")  # it plays by itself
    expect(page.locator("label", has=page.locator("#machine-slow"))).to_contain_text("180 times slower, 3 s per cycle")
    page.click("#machine-play")
    expect(page.locator("#machine-play")).to_have_text("Play")
    drawn = []
    for part in (0, 350, 700):
        page.locator("#machine-scrub").evaluate(
            "(s, part) => { s.value = part; s.dispatchEvent(new Event('input')); }", part
        )
        drawn.append(ink(page, "#machine-stage"))
    assert len(set(drawn)) == 3
    expect(page.locator("#machine-charts canvas").first).to_have_attribute("data-drawn", re.compile(r"\d"))
    expect(page.locator("#machine-changes tr")).to_have_count(7)  # margins and what changes it come later
    expect(page.locator("#machine-facts")).to_contain_text("Margins, of a rigid piston")
    expect(page.locator("#machine-facts")).to_contain_text("What changes it, with 32 elastic modes")
    said = "blow rate over the pressure: 32 elastic modes, now, rigid piston, now, 32 elastic modes"
    expect(page.locator(f"#machine-charts canvas[aria-label='{said}']")).to_have_count(1)
    expect(page.locator("#reason")).to_contain_text("It starts from rest on the tool")
    page.locator("#panel-machine").evaluate("panel => { panel.tabIndex = -1; panel.focus(); }")
    page.keyboard.press("Space")
    expect(page.locator("#machine-play")).to_have_text("Pause")


@pytest.mark.parametrize("desk", [{"reduced_motion": "reduce"}], indirect=True)
def test_sliders_of_a_machine_change_its_answer_until_it_stops(desk: Desk) -> None:
    page = desk.open("panel=machine&machine=valve-breaker")
    driven(page)
    expect(page.locator("#machine-play")).to_have_text("Play")
    rate, drawn = figure(page, "blows a minute"), ink(page, "#machine-stage")
    slide(page, "load-ports-0-behind", 70)  # the short stroke
    driven(page)
    assert float(rate) == pytest.approx(567, abs=1) and float(figure(page, "blows a minute")) > 700
    assert ink(page, "#machine-stage") != drawn
    until(page, "location.hash.includes('load.ports=')")
    slide(page, "load-pressure", 80)
    expect(page.locator("#verdict")).to_have_text("Stalls, on the tool")
    expect(page.locator("#machine-sentence")).to_contain_text(
        re.compile(r"force at the wall 2\.4\d* kN, which must be below 0 N")
    )
    expect(page.locator("#machine-obstacle")).to_contain_text("What would be needed: make the return force pull")
    expect(page.locator("#machine-play")).to_be_hidden()
    slide(page, "load-pressure", 200)
    expect(page.locator("#verdict")).to_have_text("Runs")
    expect(page.locator("#machine-play")).to_be_visible()
    slide(page, "contact-restitution", 0)
    driven(page)
    assert knows(page, "state.js:data.tables.contact.restitution") == 0


@pytest.mark.parametrize("desk", [{"reduced_motion": "reduce"}], indirect=True)
def test_a_machine_is_shown_from_its_start(desk: Desk, request: pytest.FixtureRequest) -> None:
    request.node.expected_words = ("422",)
    page = desk.open("panel=machine&machine=valve-breaker&simulation.modes=0")
    driven(page)
    expect(page.locator("#machine-start-position")).to_be_hidden()
    page.click("#machine-of-start")
    page.wait_for_selector("#machine-stage[data-label='runs 1/1']")
    expect(page.locator("#machine-sentence")).to_contain_text("From this start the machine runs 1/1: 3.751 kJ")
    expect(page.locator("#machine-start-position")).to_have_value("-39 mm")
    assert knows(page, "state.js:view.machineShow") == "start"
    page.fill("#machine-start-position", "39 mm")
    page.press("#machine-start-position", "Enter")
    expect(page.locator("#machine-start-problem")).to_contain_text("the bar is on the negative side")
    page.click("#machine-start-draw")
    until(page, f"{STATE}(({{ data }}) => data.tables.start.position < 0)")
    assert knows(page, "state.js:data.tables.start.velocity").endswith(" m/s")
    expect(page.locator("#machine-start-problem")).to_be_empty()
    page.wait_for_selector("#machine-stage[data-label]:not([data-label=''])")
    slide(page, "load-pressure", 80)  # whatever the start, it stays on the tool in the end
    page.wait_for_selector("#machine-stage:not([data-label^=runs])")
    expect(page.locator("#machine-play")).to_be_visible()
    page.click("#machine-of-cycle")
    expect(page.locator("#machine-play")).to_be_hidden()


def test_the_forces_of_a_valve_without_a_pressure_move_together(desk: Desk) -> None:
    ports = '[{"behind":1.0,"side":"back","to":"power"},{"on":"impact","to":"return"}]'
    load = f'load.kind=valve&load.states={{"return":-0.4,"power":1.8}}&load.ports={ports}'
    page = desk.open(f"panel=machine&system.s=2000&system.d=0&system.restitution=0.2&system.strain=reversed&{load}")
    driven(page)
    speed = math.sqrt(2.0 * 2.2 / (1.0 - 0.2**2))
    assert float(figure(page, "striking speed")) == pytest.approx(speed, rel=2e-3)
    slide(page, "load-states", 2)
    driven(page)
    assert knows(page, "state.js:data.tables.load.states") == {"return": -0.8, "power": 3.6}
    assert float(figure(page, "striking speed")) == pytest.approx(speed * math.sqrt(2.0), rel=2e-3)
    page.evaluate(f"{STATE}(({{ setKey }}) => setKey('load.states.power', 2.7))")
    driven(page)
    expect(page.locator("#slide-load-states")).to_have_attribute("aria-valuetext", re.compile("^1"))
    slide(page, "load-states", 0.25)
    driven(page)
    assert knows(page, "state.js:data.tables.load.states") == {"return": -0.2, "power": 0.675}


def test_a_clocked_case_offers_a_machine_with_its_valve(desk: Desk) -> None:
    page = desk.open("panel=machine&machine=mini-breaker")
    expect(page.locator("#machine-clocked")).to_contain_text("This case is clocked")
    expect(page.locator("#machine-stage")).to_be_hidden()
    page.click("#machine-open")
    expect(page.locator("#machine-clocked")).to_be_hidden()
    driven(page)
    expect(page.locator("#machine")).to_have_value("valve-breaker")
    for name in ("orbits", "motion", "report", "experiment"):  # they say so, each in a sentence
        page.click(f"#tab-{name}")
        expect(page.locator(f"#panel-{name} > .own")).to_be_visible()
        assert page.locator(f"#panel-{name} > :not(.own)").evaluate_all(
            "all => all.every(one => one.offsetParent === null)"
        )
    page.locator("#panel-experiment .own button").click()
    expect(page.locator("#machine-stage")).to_be_visible()
    page.click("#tab-blow")
    assert "A blow of" in blown(page)
    page.click("#tab-motion")
    page.select_option("#machine", "mini-breaker")
    moved(page)
    expect(page.locator("#panel-motion > .own")).to_be_hidden()
    expect(page.locator("#slide-load_factor")).to_be_visible()


def test_a_load_becomes_a_valve_and_a_clocked_one_again(desk: Desk, request: pytest.FixtureRequest) -> None:
    request.node.expected_words = ("422",)
    page = desk.open("panel=case&machine=heavy-breaker")
    page.select_option("#field-load-kind", "valve")
    expect(page.locator("#field-load-ports-0-behind")).to_have_value(re.compile("mm$"))
    expect(page.locator("#verdict")).to_have_text("Runs")
    rate = float(figure(page, "blow rate").removesuffix("Hz"))
    page.fill("#field-load-ports-0-behind", "-3 mm")
    expect(page.locator("#field-load-ports-0-behind-problem")).to_contain_text("greater than 0")
    page.fill("#field-load-ports-0-behind", "200 mm")
    expect(page.locator("#verdict")).to_have_text("Runs")
    assert float(figure(page, "blow rate").removesuffix("Hz")) != rate
    page.click("#form-plain")
    expect(page.locator("#field-load-states-power")).to_be_visible()
    expect(page.locator("#verdict")).to_have_text("Runs")
    page.click("#form-si")
    until(page, f"{STATE}(({{ data }}) => data.machine?.units === 'SI')")
    expect(page.locator("#field-load-ports-0-behind")).to_have_value(re.compile("m$"))
    page.select_option("#field-load-kind", "square")
    expect(page.locator("#field-load-amplitude")).to_have_value(re.compile("N$"))
    expect(page.locator("#slide-kappa")).to_be_visible()


def test_the_lesson_of_the_valve(desk: Desk) -> None:
    page = desk.open("panel=lessons")
    scene(page, 8, 1)
    expect(page.locator("#verdict")).to_have_text("Unstable")
    speed = float(figure(page, "striking speed"))
    scene(page, 8, 3)
    expect(page.locator("#verdict")).to_have_text("Runs")
    driven(page)
    assert float(figure(page, "striking speed")) == pytest.approx(speed, rel=2e-3)
    assert float(figure(page, "period")) == pytest.approx(2.0 * math.pi, rel=2e-3)
    expect(page.locator("#reason")).to_contain_text(re.compile("a disturbance (39|40)"))
    scene(page, 8, 4)
    expect(page.locator("#verdict")).to_have_text("Runs")
    slide(page, "load-ports-1-delay", 1.8)
    driven(page)
    expect(page.locator("#verdict")).to_have_text("Runs")
    slide(page, "load-ports-1-delay", 1.95)
    driven(page)
    expect(page.locator("#verdict")).to_contain_text("Double blow")


# --- report, experiment, lessons


def test_the_report_is_one_file(desk: Desk) -> None:
    page = desk.open("panel=report&machine=mini-breaker")
    with page.expect_download() as waiting:
        page.click("#report-download")
    text = Path(waiting.value.path()).read_text(encoding="utf-8")
    assert "<svg" in text
    assert "180" in text
    assert not re.search(r"""(src|href)=["']https?:""", text)


def test_an_experiment_fills_up_and_its_results_are_kept(desk: Desk) -> None:
    page = desk.open("panel=experiment&machine=mini-breaker")
    page.fill("#experiment-starts", "40")
    page.click("#experiment-run")
    expect(page.locator("#experiment-status")).to_contain_text("all followed", timeout=60_000)
    shares = page.locator("#experiment-shares .share")
    expect(shares.first).to_have_attribute("data-label", "z=1/1")
    assert page.locator("#experiment-progress").evaluate("bar => bar.value") == 1
    with page.expect_download() as waiting:
        page.get_by_role("button", name="Download CSV").click()
    rows = Path(waiting.value.path()).read_text(encoding="utf-8").strip().splitlines()
    assert len([row for row in rows if not row.startswith("#")]) == 41
    until(page, "location.hash.includes('starts=40')")


def test_an_experiment_can_be_cancelled_and_is_bounded(desk: Desk, request: pytest.FixtureRequest) -> None:
    request.node.expected_words = ("422",)
    page = desk.open("panel=experiment&machine=mini-breaker&emodes=16")
    page.fill("#experiment-starts", "20000")
    page.click("#experiment-run")
    until(page, "document.querySelector('#experiment-status').textContent.includes(' of ')", timeout=60_000)
    page.click("#experiment-cancel")
    expect(page.locator("#experiment-status")).to_contain_text("Cancelled")
    expect(page.locator("#experiment-run")).to_be_enabled()
    done = int(page.locator("#experiment-status").inner_text().split(":")[1].split()[0])
    assert 0 < done < 20000
    with page.expect_download() as waiting:  # what had been followed is kept
        page.get_by_role("button", name="Download CSV").click()
    rows = Path(waiting.value.path()).read_text(encoding="utf-8").strip().splitlines()
    assert len([row for row in rows if not row.startswith("#")]) == done + 1
    page.locator("#experiment-form").evaluate("form => { form.noValidate = true; }")
    page.fill("#experiment-starts", "999999999")
    page.click("#experiment-run")
    expect(page.locator("#experiment-problem")).not_to_have_text("")
    expect(page.locator("#experiment-status")).to_have_text("Not started: no start was followed.")
    expect(page.locator("#experiment-files")).to_be_hidden()


def test_the_fields_of_an_experiment_follow_a_lesson(desk: Desk) -> None:
    page = desk.open("panel=experiment&machine=mini-breaker&starts=40&seed=7")
    expect(page.locator("#experiment-starts")).to_have_value("40")
    page.click("#tab-lessons")
    page.get_by_role("button", name="Begin lesson 4").click()
    page.get_by_role("button", name="3. Count the ends").click()
    expect(page.locator("#experiment-starts")).to_have_value("300")
    expect(page.locator("#experiment-seed")).to_have_value("1")


def test_a_link_to_a_lesson_says_what_to_press(desk: Desk) -> None:
    page = desk.open("lesson=2")
    expect(page.locator("#lesson-words")).to_contain_text("Press a scene")
    page.locator("#lesson-strip .try button").first.click()
    expect(page.locator("#headline .title")).to_have_text("Pneumatic hammer")
    expect(page.locator("#lesson-words")).not_to_contain_text("Press a scene")


def test_every_lesson_sets_its_scenes(desk: Desk) -> None:
    page = desk.open("panel=lessons")
    expect(page.locator(".lesson")).to_have_count(8)
    seen = []
    for number in range(1, 9):
        page.click("#tab-lessons")
        page.get_by_role("button", name=f"Begin lesson {number}").click()
        scenes = page.locator("#lesson-strip .try button")
        for i in range(scenes.count()):
            scenes.nth(i).click()
            expect(scenes.nth(i)).to_have_attribute("aria-pressed", "true")
            expect(page.locator("#lesson-words")).not_to_have_text("")
            expect(page.locator("#headline .badge")).to_be_visible()
            if page.locator("#tab-motion").get_attribute("aria-selected") == "true":
                moved(page)
                seen.append(page.locator("#stage").get_attribute("data-label"))
    assert seen[:4] == ["z=1/1", "z=2/2", "z=4/4", "aperiodic"]  # period doubling, heard
    assert seen[4:6] == ["chatter/1", "rest"]
    expect(page.locator("#verdict")).to_have_text("Runs")  # the last scene of all


def scene(page: Page, lesson: int, number: int) -> None:
    """Open a scene of a lesson, and wait until the headline tells of it."""
    page.click("#tab-lessons")
    page.get_by_role("button", name=f"Begin lesson {lesson}").click()
    page.locator("#lesson-strip .try button").nth(number - 1).click()
    page.wait_for_timeout(100)
    expect(page.locator("#verdict")).not_to_have_text(re.compile("…"))


def test_a_lesson_begins_before_what_it_asks_to_cross(desk: Desk) -> None:
    page = desk.open("panel=lessons")
    for number in (1, 2):  # of the fold, with nothing said of the flip
        scene(page, 1, number)
        expect(page.locator("#verdict")).to_have_text("Stable")
    slide(page, "load_factor", 0.75)
    expect(page.locator("#verdict")).to_have_text("No steady motion")
    scene(page, 2, 2)
    expect(page.locator("#verdict")).to_have_text("Stable")
    slide(page, "load_factor", 0.52)
    expect(page.locator("#verdict")).to_have_text("Unstable")
    expect(page.locator("#reason")).to_contain_text("Flip")


def test_the_headline_tells_of_the_motion_that_plays(desk: Desk) -> None:
    page = desk.open("panel=lessons")
    meanings = [
        "one blow every load period",
        "2 blows in 2 load periods",
        "4 blows in 4 load periods",
        "never repeat",
    ]
    for number, (label, meaning) in enumerate(zip(["z=1/1", "z=2/2", "z=4/4", "aperiodic"], meanings, strict=True), 1):
        scene(page, 3, number)
        expect(page.locator("#verdict")).to_have_text(f"Plays: {label}")
        expect(page.locator("#stage")).to_have_attribute("data-label", label)
        expect(page.locator("#reason")).to_contain_text(meaning)
        tables = knows(page, "state.js:data.tables")
        summary = simulation_answer(case_of(tables, "lesson")).motion.summary
        assert summary.blow_energy is not None
        assert float(figure(page, "mean blow energy")) == pytest.approx(summary.blow_energy, rel=1e-3)
    page.click("#tab-orbits")  # where the steady motion is looked at
    expect(page.locator("#verdict")).to_have_text("Unstable")
    scene(page, 5, 1)
    expect(page.locator("#verdict")).to_have_text("Plays: chatter/1")
    gap = "import('/static/state.js').then(m => document.querySelector('#motion-facts').innerText)"
    assert "4 load periods" in page.evaluate(gap)


def test_an_unstable_motion_is_not_called_steady_and_a_blow_counts_once(desk: Desk) -> None:
    load = "load.kind=harmonic&load.mean=0.5&load.amplitude=1"
    page = desk.open(f"panel=motion&system.s=20&system.d=0.005&system.restitution=0.4&{load}")
    moved(page)
    facts = {
        row.locator("dt").inner_text(): row.locator("dd").inner_text()
        for row in page.locator("#motion-facts > div").all()
    }
    assert facts["steady motion"] == "unstable" and "ended by" not in facts
    assert facts["blows in view"] == "1" and facts["shown"].endswith("1 load period")
    expect(page.locator("#motion-status")).to_contain_text("unstable")
    page.select_option("#cycles", "4")
    expect(page.locator("#motion-facts dd").nth(3)).to_have_text("4")
    expect(page.locator("#stage")).to_have_attribute("aria-label", re.compile("4 blows in view"))
    slide(page, "load_factor", 0.65)
    expect(page.locator("#motion-facts dd").nth(1)).to_have_text("stable")


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


@pytest.mark.parametrize("desk", [{"color_scheme": "light"}, {"color_scheme": "dark"}], indirect=True)
def test_no_serious_accessibility_violation(desk: Desk) -> None:
    found = []
    page = desk.open("panel=case&machine=mini-breaker")
    for panel in (*PANELS, "a valve"):
        show_panel(page, panel)
        for violation in Axe().run(page).response["violations"]:
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
