"""The page of the workbench in a real browser: what is served, links, paper, and what everybody needs."""

from __future__ import annotations

import os
import re
from importlib import resources
from pathlib import Path

import pytest
from starlette.requests import Request

pytest.importorskip("fastapi")

from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import Browser, Page, Route, expect

from percuss.case import Case, steady_answer
from percuss.case.case import case_of
from percuss.case.catalogue.sample_cases import machine_text
from percuss.web.application import Shelf
from web_desk import PANELS, Desk, blown, came, driven, figure, held, ink, knows, let_go, served, settled, slide, until

IMAGES = os.environ.get("PERCUSS_IMAGES")  # a folder: the pictures of docs/workbench.md are made anew there

pytestmark = pytest.mark.browser


# --- what is served


def test_the_modules_of_the_screen_are_loaded_at_once() -> None:
    """All that main.js imports stands in index.html, what a drawer needs does not, and nothing comes from elsewhere."""
    request = Request({"type": "http", "method": "GET", "path": "/", "headers": []})
    index = bytes(Shelf().answer(request, "index.html").body).decode()
    preloaded = set(re.findall(r'rel="modulepreload" href="/static/([^"]+)"', index))
    folder = Path(str(resources.files("percuss.web").joinpath("page")))
    for name in preloaded:
        source = (folder / name).read_text()
        wanted = re.findall(r'^(?:import|export|\}) .*?"(\.[^"]+)";$', source, re.MULTILINE)
        assert {
            (folder / name).parent.joinpath(one).resolve().relative_to(folder.resolve()).as_posix() for one in wanted
        } <= preloaded
    assert {"main.js", "core/dom.js", "map/map_panel.js"} <= preloaded
    assert not {"case/case_panel.js", "branches/branches_panel.js", "lessons/lessons.js"} & preloaded
    assert not re.search(r"""(?:src|href|from|import)\s*[=(]?\s*["'](?:https?:)?//""", index)


NOTES = """
import { h, put } from "./core/dom.js";
import { effect } from "./core/signals.js";
import { view } from "./core/state.js";

const start = (section) => effect(() => put(section, h("p", {}, `page ${view.page}`)));
export const PANELS = [
  { name: "case", title: "Case as a form", load: () => import("./case/case_panel.js") },
  { name: "notes", title: "Notes", defaults: { page: 3 }, load: async () => ({ start }) },
];
"""


def test_a_panel_is_one_object_in_the_list(desk: Desk, request: pytest.FixtureRequest) -> None:
    """What stands in the list is all that the page needs of a panel: its tab, its section, its part of the address."""
    request.node.expected_words = ("preload",)  # the browser itself remarks on modules that this list leaves out
    desk.page.route("**/static/panels.js", lambda route: route.fulfill(content_type="text/javascript", body=NOTES))
    page = desk.open("machine=mini-breaker")
    assert page.locator("#drawers button").all_inner_texts() == ["Case as a form", "Notes"]
    page.click("#tab-notes")
    expect(page.locator("#panel-notes")).to_have_text("page 3")
    until(page, "location.hash.startsWith('#panel=notes')")
    assert "page" not in page.evaluate("new URLSearchParams(location.hash.slice(1)).keys().toArray()")
    page.evaluate("location.hash += '&page=7'")
    expect(page.locator("#panel-notes")).to_have_text("page 7")


# --- whether what is shown is of the present state


def figures_of(page: Page) -> dict[str, float]:
    """The figures in SI of the steady motion of the headline, by the library, of the case as it is on the page."""
    case = case_of(knows(page, "core/state.js:data.tables"), "page")
    orbits = steady_answer(case).to_json_dict()["periods"][0]["orbits"]
    found: dict[str, float] = orbits[knows(page, "core/state.js:chosen().number") - 1]["si"]
    return found


def test_the_page_says_when_its_figures_are_those_of_the_state_shown(desk: Desk) -> None:
    page = desk.open("panel=orbits&machine=mini-breaker")
    settled(page)
    late = held(page, "steady")
    slide(page, "restitution", 0.15)
    assert page.locator("#headline").get_attribute("aria-busy") == "true"  # from the move on
    came(page, late)
    settled(page, "steady")
    assert page.locator("#headline").get_attribute("aria-busy") == "true"
    until(page, "getComputedStyle(document.querySelector('#headline .figures')).opacity < 0.5")
    assert "…" in figure(page, "peak stress")
    let_go(page, "steady", late)
    settled(page)
    assert page.locator("#headline").get_attribute("aria-busy") == "false"
    truth = figures_of(page)
    assert float(figure(page, "peak stress").removesuffix("MPa")) == pytest.approx(truth["peak_stress_MPa"], rel=5e-3)
    assert float(figure(page, "blow energy").removesuffix("J")) == pytest.approx(truth["blow_energy_J"], rel=5e-3)


def test_a_question_that_fails_leaves_the_page_settled(desk: Desk, request: pytest.FixtureRequest) -> None:
    request.node.expected_words = ("500",)
    page = desk.open("machine=mini-breaker")
    page.route("**/api/map", lambda route: route.fulfill(status=500))
    page.select_option("#map-q", "power")
    settled(page)
    page.route("**/api/quick", lambda route: route.fulfill(status=500))
    slide(page, "load_factor", 0.3)
    settled(page)
    assert page.locator("#verdict").inner_text() == "No answer"


def test_a_move_outlives_a_restart_of_the_server(browser: Browser) -> None:
    with served() as address:
        desk = Desk(browser, address)
        page = desk.open("panel=orbits&machine=mini-breaker")
        settled(page)
    slide(page, "restitution", 0.15)
    expect(page.locator("#away")).to_contain_text("Reconnecting")
    slide(page, "load_factor", 0.3)
    with served("--port", address.strip("/").rpartition(":")[2]):
        settled(page)
        expect(page.locator("#away")).to_be_hidden()
        case = case_of(knows(page, "core/state.js:data.tables"), "page")
        assert case.system().restitution == pytest.approx(0.15, abs=1e-3)
        assert case.system().load.load_factor == pytest.approx(0.3, abs=1e-3)
        truth = figures_of(page)
        stress = float(figure(page, "peak stress").removesuffix("MPa"))
        assert stress == pytest.approx(truth["peak_stress_MPa"], rel=5e-3)
    desk.context.close()


def test_an_effect_that_throws_does_not_silence_the_others(desk: Desk) -> None:
    page = desk.open("panel=orbits&machine=mini-breaker")
    settled(page)
    before = figure(page, "blow energy")
    page.evaluate(
        """async () => {
          const { data } = await import("/static/core/state.js");
          const { effect } = await import("/static/core/signals.js");
          effect(() => { if (data.quick) throw new Error("of the test"); });
          effect(() => { document.title = `heard ${data.quick.changed}`; });
        }"""
    )
    slide(page, "restitution", 0.15)
    settled(page)
    assert page.title() == f"heard {knows(page, 'core/state.js:data.changed')}"
    assert figure(page, "blow energy") != before
    assert [line for line in desk.said if "of the test" not in line] == []
    desk.said.clear()


def test_the_page_tells_how_far_the_compiler_is(desk: Desk) -> None:
    kernels = ["multipliers", "motions", "blows", "machines", "orbits"]
    preparing = kernels[2:]

    def about(route: Route) -> None:
        answer = route.fetch().json()
        route.fulfill(json={**answer, "ready": not preparing, "kernels": kernels, "preparing": preparing})

    desk.page.route("**/api/about", about)
    page = desk.open("panel=report&machine=mini-breaker")
    words = page.locator("#preparing")
    expect(words).to_contain_text("2 of 5 parts, now blows resolved by waves")
    assert page.locator("#preparing progress").evaluate("bar => bar.position") == pytest.approx(0.4)
    preparing.clear()
    expect(words).to_be_hidden()


# --- the link


def test_a_link_reproduces_the_view(desk: Desk, browser: Browser, server: str) -> None:
    page = desk.open("panel=orbits&machine=mini-breaker")
    slide(page, "load_factor", 0.34)
    page.get_by_role("button", name=re.compile("^Motion 1 of 2")).click()
    settled(page)
    assert "orbit=1" in page.url and "load.mean" in page.url
    other = Desk(browser, server)
    twin = other.open(page.url.partition("#")[2])
    expect(twin.locator("#tab-orbits")).to_have_attribute("aria-expanded", "true")
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
    expect(page.locator("#machine option:checked")).to_have_text("A hammer of my own")
    page.click("#drawer-close")
    page.select_option("#map-q", "reduced_margin")
    until(page, "location.hash.includes('q=reduced_margin') && !location.hash.includes('machine=')")
    other = Desk(browser, server)
    twin = other.open(page.url.partition("#")[2])
    expect(twin.locator("#machine option:checked")).to_have_text("A hammer of my own")
    expect(twin.locator("#map-q")).to_have_value("reduced_margin")
    same = page.locator("#headline .figures").inner_text()
    expect(twin.locator("#headline .figures")).to_have_text(same, use_inner_text=True)
    other.context.close()


def test_a_link_to_the_plain_form_and_a_link_to_nothing(desk: Desk, request: pytest.FixtureRequest) -> None:
    request.node.expected_words = ("404",)
    page = desk.open("panel=case&machine=mini-breaker")
    page.click("#form-plain")
    until(page, "location.hash.includes('system.s=')")
    page.reload()
    desk.answered()
    expect(page.locator("#field-system-restitution")).to_have_value("0.1")
    expect(page.locator("#verdict")).to_have_text("Stable")
    page.click("#form-si")
    expect(page.locator("#field-bar-length")).to_have_value("320 mm")
    desk.open("panel=case&machine=no-such-hammer")
    expect(page.locator("#verdict")).to_have_text("No answer")
    page.select_option("#machine", "mini-breaker")
    expect(page.locator("#verdict")).to_have_text("Stable")
    page.route("**/api/machines/heavy-breaker", lambda route: route.fulfill(status=500))
    request.node.expected_words = ("404", "500")
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
    page = desk.open("panel=case&machine=mini-breaker&rock.stiffness=200 kN/mm")
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
    with served("mini-breaker", "--token", word) as address:
        desk = Desk(browser, address)
        page = desk.open(f"token={word}&panel=report")  # of the case that is served
        expect(page.locator("#machine option:checked")).to_have_text("Hydraulic breaker for a mini excavator")
        assert word not in page.url
        desk.context.close()


@pytest.mark.parametrize(
    "words",
    [
        "machine=mini-breaker&xr=e:-&q=nothing&x=nothing",
        "panel=case&machine=mini-breaker&load.kind=fourier&load.coefficients=5",
        "panel=nothing&m=0&orbit=99&lesson=9&scene=9&cycles=0&machine=mini-breaker",
    ],
)
def test_nonsense_in_a_link_is_told_and_can_be_left(desk: Desk, request: pytest.FixtureRequest, words: str) -> None:
    request.node.expected_words = ("422",)
    page = desk.open(words)
    settled(page)
    assert "is not a function" not in page.locator("body").inner_text()
    assert "expected a valid number" not in page.locator("#map-status").inner_text()
    page.select_option("#machine", "heavy-breaker")
    expect(page.locator("#slide-bar-length")).to_have_attribute("aria-valuetext", re.compile("^1\\.01"))
    page.fill("#periods", "1")
    expect(page.locator("#verdict")).to_have_text("Stable")


# --- on paper


def test_pictures_keep_their_proportions_on_paper(desk: Desk) -> None:
    page = desk.open("panel=orbits&machine=mini-breaker")
    settled(page)
    page.evaluate("dispatchEvent(new Event('beforeprint'))")  # what was out of sight is drawn, too
    page.evaluate("window.requestAnimationFrame = () => 0")  # and nothing anew once the page is laid out on paper
    page.emulate_media(media="print")
    page.set_viewport_size({"width": 600, "height": 800})
    found = page.locator("canvas[data-drawn]:visible").evaluate_all(
        "all => all.map(one => [one.width / one.height, one.clientWidth / one.clientHeight])"
    )
    assert len(found) >= 6
    for pixels, printed in found:
        assert printed == pytest.approx(pixels, rel=0.01)


@pytest.mark.parametrize("desk", [{"color_scheme": "dark"}], indirect=True)
def test_paper_is_light_and_a_stable_disc_stays_a_disc(desk: Desk) -> None:
    page = desk.open("panel=orbits&machine=mini-breaker")
    chart = "#panel-orbits canvas[data-change]"
    settled(page)
    dark = ink(page, chart)
    page.evaluate("dispatchEvent(new Event('beforeprint'))")
    assert knows(page, "pictures/colours.js:theme().dark") is False
    assert ink(page, chart) != dark
    page.evaluate("dispatchEvent(new Event('afterprint'))")
    assert knows(page, "pictures/colours.js:theme().dark") is True
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
        page.select_option("#machine", "valve-breaker")
        return driven(page)
    if name:
        page.click(f"#tab-{name}")
    settled(page)


@pytest.mark.parametrize(
    ("desk", "rules"),
    [
        ({"color_scheme": "light"}, None),
        ({"color_scheme": "dark"}, ["color-contrast"]),
    ],
    indirect=["desk"],
)
def test_no_accessibility_violation(desk: Desk, rules: list[str] | None) -> None:
    """All rules in one scheme; of the other the colours, which are all that differs."""
    options = {"resultTypes": ["violations"]} | ({"runOnly": rules} if rules else {})
    found = []
    page = desk.open("machine=mini-breaker")
    for panel in (*PANELS, "a valve"):
        show_panel(page, panel)
        for violation in Axe().run(page, options=options).response["violations"]:
            found.append((panel, violation["id"], [node["html"][:160] for node in violation["nodes"][:3]]))
    assert found == []


@pytest.mark.parametrize("desk", [{"color_scheme": "dark"}], indirect=True)
def test_dark_and_light(desk: Desk) -> None:
    page = desk.open("panel=orbits&machine=mini-breaker")
    background = "getComputedStyle(document.body).backgroundColor"
    dark = page.evaluate(background)
    chart = "#panel-orbits canvas[data-change]"
    page.wait_for_selector(f"{chart}[data-drawn]")
    settled(page)
    before = ink(page, chart)
    page.click("#theme")
    expect(page.locator("#theme")).to_have_attribute("aria-label", "Theme: light")
    assert page.evaluate(background) != dark
    settled(page)
    assert ink(page, chart) != before
    page.reload()
    desk.answered()
    expect(page.locator("#theme")).to_have_attribute("aria-label", "Theme: light")


@pytest.mark.parametrize("desk", [{"viewport": {"width": 390, "height": 844}, "has_touch": True}], indirect=True)
def test_a_phone_shows_one_column_and_nothing_sticks_out(desk: Desk) -> None:
    page = desk.open("machine=mini-breaker")
    for panel in (*PANELS, "a valve"):
        show_panel(page, panel)
        assert page.evaluate("document.documentElement.scrollWidth") <= 390, panel
        assert page.evaluate("document.querySelector('main').clientWidth") > 340, panel


def test_the_keyboard_reaches_everything(desk: Desk) -> None:
    page = desk.open("machine=mini-breaker")
    settled(page)
    page.keyboard.press("Tab")
    assert page.evaluate("document.activeElement.className") == "skip"
    places = ["machine", "tab-lessons", "sound", "theme", "slide-restitution", "play", "map-y", "map", "map-x"]
    places.append("tab-case")
    for place in places:  # in this order
        for _ in range(60):
            page.keyboard.press("Tab")
            if page.evaluate("document.activeElement.id") == place:
                break
        assert page.evaluate("document.activeElement.id") == place
        assert page.evaluate("getComputedStyle(document.activeElement).outlineWidth") == "3px", place
    page.keyboard.press("Enter")
    expect(page.locator("#panel-case")).to_be_visible()
    page.keyboard.press("Escape")
    expect(page.locator("#drawer")).to_be_hidden()
    assert page.evaluate("document.activeElement.id") == "tab-case"
    page.focus("#slide-restitution")
    before = page.locator("#slide-restitution").input_value()
    page.keyboard.press("ArrowRight")
    until(page, "location.hash.includes('contact.restitution')")
    assert page.locator("#slide-restitution").input_value() != before


def test_the_focus_stays_when_what_has_it_is_painted_anew(desk: Desk) -> None:
    page = desk.page
    late = held(page, "steady")
    page.goto(f"{desk.server}#panel=orbits&machine=mini-breaker")
    came(page, late)
    here = "document.activeElement.textContent || document.activeElement.id"
    page.get_by_role("button", name=re.compile("^Motion 1 of 2")).focus()
    late[0].continue_()
    expect(page.locator("#headline .figures div").nth(4)).not_to_contain_text("…")  # the peak stress has come
    assert page.evaluate(here) == "1"
    page.get_by_role("button", name="From a start").focus()
    page.keyboard.press("Enter")
    expect(page.locator("#start-kind")).to_be_visible()
    assert page.evaluate(here) == "From a start"
    page.focus("#window")
    page.keyboard.press("ArrowDown")
    until(page, "location.hash.includes('window=start') || location.hash.includes('source=start')")
    assert page.evaluate("document.activeElement.id") == "window"


def test_the_policy_holds_and_a_title_is_never_markup(desk: Desk) -> None:
    page = desk.open("panel=report&machine=mini-breaker&title=%3Cimg+src%3Dx+onerror%3Dalert(1)%3E")
    expect(page.locator("#changes li")).to_contain_text("<img", use_inner_text=False)
    assert page.locator("#changes img").count() == 0
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
    desk.page.set_viewport_size({"width": 1366, "height": 768})
    views = {
        "screen": "machine=mini-breaker",
        "case": "panel=case&tall=1&machine=hydraulic-drifter",
        "map": "machine=mini-breaker",
        "orbits": "panel=orbits&tall=1&machine=hydraulic-drifter",
        "branches": "panel=branches&tall=1&bmodes=0&depth=3&alongr=0.75:1&every=2/2&settled=1&spot=0.8,2.84"
        "&system.s=20&system.d=0.005&system.restitution=0.8&load.kind=harmonic&load.mean=0.945&load.amplitude=1&title=Pneumatic+hammer",
        "blow": "panel=blow&machine=drill-string",
        "report": "panel=report&machine=hydraulic-drifter",
        "experiment": "panel=experiment&system.s=20&system.d=0.005&system.restitution=0.8&load.kind=harmonic"
        "&load.mean=0.945&load.amplitude=1&title=Pneumatic+hammer",
        "lessons": "panel=lessons&machine=mini-breaker",
    }
    for name, words in views.items():
        page = desk.open(words)
        settled(page)  # with the last points of all curves
        if name in ("screen", "map"):
            page.click("#play")
            until(page, "Number(document.querySelector('#stage').dataset.blows) > 9")
            page.click("#play")
            settled(page)
        if name == "blow":
            blown(page)
            page.locator("#blow-scrub").evaluate("s => { s.value = 100; s.dispatchEvent(new Event('input')); }")
        if name == "experiment":
            page.click("#experiment-run")
            expect(page.locator("#experiment-status")).to_contain_text("all followed")
        path = folder / f"workbench-{name}.png"
        page.screenshot(path=path)
        with Image.open(path) as picture:  # a palette: half the bytes
            small = picture.convert("RGB").quantize(255, method=Image.Quantize.FASTOCTREE, dither=Image.Dither.NONE)
        small.save(path, optimize=True)
        assert path.stat().st_size < 150_000


LOOK = """one => {
  const look = getComputedStyle(one);
  return ["backgroundColor", "color", "borderTopColor", "borderBottomColor", "outlineStyle"].map(name => look[name]);
}"""


@pytest.mark.parametrize("desk", [{"forced_colors": "active"}], indirect=True)
def test_what_is_chosen_is_seen_in_forced_colours(desk: Desk) -> None:
    """A place, a motion, a drawer and a switch that is pressed look other than those that are not."""
    page = desk.open("machine=mini-breaker&panel=hammer")
    settled(page)
    page.click("#pin")
    settled(page)
    for chosen, other in (
        ("#explore", "#tab-lessons"),
        ("#headline .segments [aria-pressed=true]", "#headline .segments [aria-pressed=false]"),
        ("#tab-hammer", "#tab-orbits"),
        ("#pin", "#sound"),
    ):
        pressed, plain = (page.locator(one).first.evaluate(LOOK) for one in (chosen, other))
        assert pressed != plain, chosen
