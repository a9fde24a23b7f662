"""The case in the workbench, in a real browser: what is typed, picked and uploaded, and the answer that comes first."""

from __future__ import annotations

import re
from pathlib import Path
from urllib.parse import urlencode

import httpx
import pytest

pytest.importorskip("fastapi")

from playwright.sync_api import Browser, expect

from percuss.case.catalogue.sample_cases import machine_text, write_history
from percuss.cli import main
from percuss.steady.figures import CARDS
from percuss.units import si
from web_desk import Desk, came, figure, held, knows, let_go, served, settled, slide, steady_json, until

pytestmark = pytest.mark.browser


def test_the_answer_comes_first_and_equals_the_command_line(desk: Desk, capsys: pytest.CaptureFixture[str]) -> None:
    page = desk.open("panel=report&machine=mini-breaker")
    expect(page.locator("#report-cards .card")).to_have_count(len(CARDS))
    orbits = steady_json(capsys, "mini-breaker")["periods"][0]["orbits"]
    truth = next(orbit for orbit in orbits if orbit["stable"] and orbit["admissible"])["si"]
    for card in page.locator("#report-cards [data-figure]").all():
        name = card.get_attribute("data-figure") or ""
        assert float(card.get_attribute("data-value") or "nan") == truth[name], name
    expect(page.locator("#verdict")).to_have_text("Stable")
    assert figure(page, "blow energy") == "180J"


@pytest.mark.slow
def test_the_answer_does_not_wait_for_the_compiler(browser: Browser, tmp_path: Path) -> None:
    """On a machine that has never compiled the kernels: the steady motions are told, and what is still to come."""
    with served(NUMBA_CACHE_DIR=str(tmp_path)) as address:
        desk = Desk(browser, address)
        page = desk.open("panel=report&machine=mini-breaker")
        assert figure(page, "blow energy") == "180J"
        expect(page.locator("#report-cards .card")).to_have_count(len(CARDS))
        preparing = page.locator("#preparing")
        expect(preparing).to_contain_text("Compiling")
        assert not httpx.get(f"{address}api/about").json()["ready"]
        page.route("**/api/about", lambda route: route.fulfill(json={"ready": True, "preparing": []}))
        expect(preparing).to_be_hidden()
        desk.context.close()


def test_what_is_typed_changes_the_answer_or_is_told_beside_its_field(
    desk: Desk, request: pytest.FixtureRequest
) -> None:
    request.node.expected_words = ("422",)  # the browser itself remarks on a refused request
    page = desk.open("panel=case&machine=mini-breaker")
    page.fill("#field-bar-length", "640 mm")
    expect(page.locator("#headline .figures").locator("dd").first).not_to_have_text("180J")
    until(page, "location.hash.includes('bar.length=640+mm')")
    for wrong in ("34 kg", "1e400"):
        page.fill("#field-bar-length", wrong)
        expect(page.locator("#field-bar-length-problem")).to_contain_text("expected a length")
        expect(page.locator("#field-bar-length")).to_have_attribute("aria-invalid", "true")
        expect(page.locator("#verdict")).to_have_text("No answer")
        page.fill("#field-bar-length", "320 mm")
        expect(page.locator("#field-bar-length-problem")).to_have_text("")
        expect(page.locator("#verdict")).to_have_text("Stable")
    page.fill("#periods", "0")
    expect(page.locator("#periods")).to_have_attribute("aria-invalid", "true")
    page.keyboard.press("Tab")
    expect(page.locator("#periods")).to_have_value("1")
    assert page.locator("#periods").get_attribute("aria-invalid") is None


def test_a_machine_is_picked_and_shown_in_plain_numbers_and_back(desk: Desk) -> None:
    page = desk.open("panel=case&machine=mini-breaker")
    page.select_option("#machine", "laboratory-striker")
    expect(page.locator("#machine option:checked")).to_contain_text("Laboratory striker")
    expect(page.locator("#field-bar-length")).to_have_value("200 mm")
    page.click("#form-plain")
    expect(page.locator("#field-system-restitution")).to_be_visible()
    assert figure(page, "blow energy") != "7.5J"
    page.click("#form-si")
    expect(page.locator("#field-bar-length")).to_have_value("200 mm")


def test_a_case_goes_out_as_toml_and_comes_back(desk: Desk, tmp_path: Path) -> None:
    page = desk.open("panel=case&machine=mini-breaker")
    slide(page, "restitution", 0.25)
    until(page, "location.hash.includes('contact.restitution=0.25')")
    moved = page.locator("#field-contact-restitution").input_value()
    settled(page)
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
    slide(page, "restitution", 0.4)  # what is changed in a case of one's own is told as of a machine of the catalogue
    settled(page)
    page.click("#changes summary")
    expect(page.locator("#changes li")).to_contain_text(["restitution R: 0.3996"])
    page.click("#reset")
    expect(page.locator("#field-contact-restitution")).to_have_value(moved)
    expect(page.locator("#changes")).to_be_hidden()


def test_wrong_files_are_refused_beside_their_fields(
    desk: Desk, tmp_path: Path, request: pytest.FixtureRequest
) -> None:
    request.node.expected_words = ("422",)
    page = desk.open("panel=case&machine=mini-breaker")
    path = tmp_path / "wrong.toml"
    path.write_text(machine_text("mini-breaker").replace('"320 mm"', '"320 kg"'), encoding="utf-8")
    page.set_input_files("#upload-toml", path)
    expect(page.locator("#field-bar-length-problem")).to_contain_text("In the file: expected a length")
    expect(page.locator("#case-problems")).to_contain_text("not accepted")
    expect(page.locator("#field-bar-length")).to_have_value("320 mm")
    page.fill("#field-bar-length", "330 mm")
    expect(page.locator("#field-bar-length-problem")).to_have_text("")
    path = tmp_path / "short.csv"
    path.write_text("time [s],force [N]\n0,1\n0.001,2\n", encoding="utf-8")
    page.set_input_files("#upload-history", path)
    expect(page.locator("#history-report .problem")).not_to_have_text("")
    expect(page.locator("#verdict")).to_have_text("Stable")  # the load of before is kept


def test_a_measured_history_becomes_the_load(desk: Desk, tmp_path: Path, request: pytest.FixtureRequest) -> None:
    request.node.expected_words = ("422",)
    page = desk.open(
        "panel=case&machine=hydraulic-drifter&load.kind=harmonic&load.mean=4+kN&load.amplitude=10+kN&load.coefficients=&load.unit="
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
    expect(page.locator("#headline .figures dd").first).to_contain_text("310")


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
    page = desk.open("panel=case&machine=mini-breaker")
    page.set_input_files("#upload-toml", tmp_path / "drifter.toml")  # alone it is refused, with what to do
    expect(page.locator("#field-load-kind-problem")).to_contain_text("together")
    if how == "picked":
        page.set_input_files("#upload-toml", files)
    else:
        page.keyboard.press("Escape")  # the drawer is closed
        page.evaluate(DROP, [[file.name, file.read_text(encoding="utf-8")] for file in files])
    expect(page.locator("#history-report")).to_contain_text("cycles used")
    expect(page.locator("#field-load-kind")).to_have_value("fourier")
    expect(page.locator("#headline .figures dd").first).to_contain_text("310")
    expect(page.locator("#case-problems")).to_have_text("")


def test_of_two_machines_picked_in_a_row_the_later_holds(desk: Desk) -> None:
    page = desk.open("panel=case&machine=mini-breaker")
    late = held(page, "machines/heavy-breaker")
    page.select_option("#machine", "heavy-breaker")
    came(page, late)
    page.select_option("#machine", "laboratory-striker")
    expect(page.locator("#field-bar-length")).to_have_value("200 mm")
    late[0].continue_()
    settled(page)  # the late answer has come
    expect(page.locator("#field-bar-length")).to_have_value("200 mm")
    expect(page.locator("#machine")).to_have_value("laboratory-striker")


@pytest.mark.parametrize(
    ("machine", "key", "text", "kind", "how"),
    [
        ("mini-breaker", "bar.length", "32 cm", "length", "linked"),
        ("mini-breaker", "load.frequency", "1050 1/min", "frequency", "typed"),
        ("valve-breaker", "load.ports[1].delay", "4000 us", "time", "typed"),
    ],
)
def test_a_slider_goes_on_from_a_value_in_another_unit(
    desk: Desk, machine: str, key: str, text: str, kind: str, how: str
) -> None:
    """One step of it is a hundredth, whatever the unit."""
    field = re.sub(r"[.\[\]]+", "-", key)
    page = desk.open(f"panel=case&machine={machine}" + (f"&{key}={text}" if how == "linked" else ""))
    if how == "typed":
        page.fill(f"#field-{field}", text)
        page.keyboard.press("Tab")
    settled(page)
    page.focus(f"#slide-{field}")
    page.keyboard.press("ArrowRight")
    settled(page)
    written = str(knows(page, f"core/state.js:data.tables.{key}"))
    assert written != text and si(written, kind, key) == pytest.approx(1.01 * si(text, kind, key), rel=1e-3)


def test_a_slider_moved_before_the_unit_is_known_keeps_its_own(desk: Desk) -> None:
    page = desk.open("panel=case&machine=mini-breaker")
    settled(page)
    late = held(page, "case")
    page.fill("#field-bar-length", "32 cm")
    page.keyboard.press("Tab")
    came(page, late)
    slide(page, "bar-length", 330)
    let_go(page, "case", late)
    settled(page)
    assert si(knows(page, "core/state.js:data.tables.bar.length"), "length", "bar.length") == pytest.approx(
        0.33, rel=1e-3
    )
    expect(page.locator("#slide-bar-length")).to_have_attribute("aria-valuetext", re.compile("^329"))


def test_a_unit_changed_elsewhere_is_that_of_ranges_and_of_the_sliders_of_a_blow(desk: Desk) -> None:
    for dear in ("map", "boundaries"):  # never answered
        held(desk.page, dear)
    page = desk.open("machine=mini-breaker&x=bar.length&xr=300:340 mm")
    expect(page.locator("#map-x-from")).to_have_value("300")
    bar = "{ ...data.tables, bar: { ...data.tables.bar, length: '32 cm' } }"  # as a file may have it
    page.evaluate(f"import('/static/core/state.js').then(({{ data, setTables }}) => setTables({bar}))")
    settled(page)
    assert float(page.locator("#map-x-from").input_value()) < 32.0 < float(page.locator("#map-x-to").input_value())
    page.click("#tab-blow")
    expect(page.locator("#blow-sentence")).to_contain_text("A blow of")
    page.focus("#blow-slide-bar-length")
    page.keyboard.press("ArrowRight")
    settled(page)
    assert si(knows(page, "core/state.js:data.tables.bar.length"), "length", "bar.length") == pytest.approx(
        0.32, rel=0.01
    )


def test_a_number_that_is_known_within_limits_keeps_them(desk: Desk) -> None:
    """In the fields, in the case that is saved, in what a slider leaves of it, and in what is told of the figures."""
    page = desk.open(f"panel=case&machine=valve-breaker&{urlencode({'load.pressure': '160 bar ± 5 %'})}")
    expect(page.locator("#reason")).to_contain_text("blow energy 3.75 ± 0.")
    expect(page.locator("#field-load-pressure")).to_have_value("160 bar ± 5 %")
    slide(page, "contact-restitution", 0.3)
    settled(page)
    assert knows(page, "core/state.js:data.tables.load.pressure") == "160 bar ± 5 %"
    expect(page.locator("#reason")).to_contain_text("; from load.pressure.")
    slide(page, "load-pressure", 150.0)
    settled(page)
    assert knows(page, "core/state.js:data.tables.load.pressure") == "150 bar ± 5 %"
