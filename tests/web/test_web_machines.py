"""The panels Blow and Machine of the workbench in a real browser: one blow, and the machine that switches itself."""

from __future__ import annotations

import json
import math
import re

import pytest

pytest.importorskip("fastapi")

from playwright.sync_api import Page, expect

from percuss.case import load_case, machine_answer
from percuss.cli import main
from web_desk import PLAYING, STATE, Desk, blown, driven, figure, ink, knows, moved, slide, until

pytestmark = pytest.mark.browser


# --- blow


@pytest.mark.parametrize("desk", PLAYING, indirect=True)
def test_a_blow_says_what_the_command_line_says_and_plays(desk: Desk, capsys: pytest.CaptureFixture[str]) -> None:
    page = desk.open("panel=blow&machine=laboratory-striker")
    assert main(["blow", "laboratory-striker"]) == 0
    assert " ".join(blown(page).split()) in " ".join(capsys.readouterr().out.split())
    expect(page.locator("#blow-facts")).to_contain_text("exact but for rounding")
    frame = "Number(document.querySelector('#blow-stage').dataset.frame)"
    until(page, f"{frame} > 3")  # it plays by itself
    page.click("#blow-play")
    expect(page.locator("#blow-play")).to_have_attribute("aria-label", "Play")
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
    expect(page.locator("#blow-play")).to_have_attribute("aria-label", "Pause")
    until(page, f"{frame} > 45")
    expect(page.locator("#blow-stage")).to_have_attribute("aria-label", re.compile("A blow of"))
    assert "J (" in page.locator("#blow-energies").inner_text()


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


def test_the_tool_comes_back_after_a_wall_and_the_blow_stays_in_sight_of_its_sliders(desk: Desk) -> None:
    page = desk.open("panel=blow&machine=stepped-drifter")
    before = blown(page)
    slider = page.locator("#blow-sliders input").last
    slider.focus()
    box, picture = slider.bounding_box(), page.locator("#blow-stage").bounding_box()
    assert box is not None and picture is not None
    assert picture["y"] >= 0.0 and picture["y"] + picture["height"] <= box["y"]
    assert box["y"] + box["height"] <= 900.0
    for struck, words in (("infinite", "into the rod"), ("wall", "to the wall"), ("rock", "into the rock")):
        page.select_option("#blow-struck", struck)
        expect(page.locator("#blow-sentence")).to_contain_text(words)
    assert page.locator("#blow-sentence").inner_text() == before


WRITTEN = """
  window.written = new Map();  // of each canvas what stands on it: [text, left, right, top, bottom] in its own pixels
  const { clearRect, fillText } = CanvasRenderingContext2D.prototype;
  CanvasRenderingContext2D.prototype.clearRect = function (...box) {
    window.written.set(this.canvas.id, []);
    clearRect.apply(this, box);
  };
  CanvasRenderingContext2D.prototype.fillText = function (text, x, y, ...more) {
    const size = this.measureText(text), { a, d } = this.getTransform();
    window.written.get(this.canvas.id)?.push([
      text, a * (x - size.actualBoundingBoxLeft), a * (x + size.actualBoundingBoxRight),
      d * (y - size.actualBoundingBoxAscent), d * (y + size.actualBoundingBoxDescent),
    ]);
    fillText.call(this, text, x, y, ...more);
  };
"""


def on_the_stage(page: Page) -> list[str]:
    """The words on the stage of the blow; none of them is cut off or stands in another."""
    words = page.evaluate("window.written.get('blow-stage')")
    width, height = page.locator("#blow-stage").evaluate("canvas => [canvas.width, canvas.height]")
    for i, (text, left, right, top, bottom) in enumerate(words):
        assert left >= 0.0 and right <= width and top >= 0.0 and bottom <= height, text
        for other, *box in words[:i]:
            assert right <= box[0] or box[1] <= left or bottom <= box[2] or box[3] <= top, f"{text} over {other}"
    return [text.replace("\u202f", " ") for text, *_ in words]


def test_the_stage_of_a_blow_shows_what_holds_the_tool(desk: Desk) -> None:
    desk.page.add_init_script(WRITTEN)
    page = desk.open("panel=blow&machine=drill-string")
    before, stage = blown(page), "document.querySelector('#blow-stage')"
    for width, height in ((390, 844), (1366, 768)):
        page.set_viewport_size({"width": width, "height": height})
        until(page, f"(one => one.width > 0.4 * {width} && one.width === Math.round(one.clientWidth))({stage})")
        assert {"feed 8 kN", "sleeve 1.8 kg", "bit of 2.2 kg, rock"} <= set(on_the_stage(page))
    shares = page.locator("#blow-shares")
    expect(shares).to_contain_text(re.compile("rock 66.*steel 9.*left in the tool 22.*the feed adds"))
    slider = page.locator("#blow-slide-feed-damping")
    slider.evaluate("s => { s.value = 3e4; s.dispatchEvent(new Event('input')); }")
    until(page, f"document.querySelector('#blow-sentence').textContent !== {json.dumps(before)}")
    before = blown(page)
    assert "feed 8 kN, dashpot 30 kN·s/m" in on_the_stage(page)
    expect(shares).to_contain_text("recoil damper")
    page.locator("#blow-slide-feed-force").evaluate("s => { s.value = 4; s.dispatchEvent(new Event('input')); }")
    until(page, f"document.querySelector('#blow-sentence').textContent !== {json.dumps(before)}")
    blown(page)
    assert "feed 4 kN, dashpot 30 kN·s/m" in on_the_stage(page)
    page.select_option("#blow-struck", "wall")  # which bears no feed, and is not drilled
    expect(page.locator("#blow-sentence")).to_contain_text("to the wall")
    page.select_option("#blow-struck", "rock")
    expect(page.locator("#blow-sentence")).to_contain_text("into the rock")
    blown(page)
    assert "feed 8 kN" in on_the_stage(page)


def test_a_dimensionless_blow_and_one_that_cannot_be(desk: Desk, request: pytest.FixtureRequest) -> None:
    request.node.expected_words = ("422",)
    plain = "panel=blow&system.s=20&system.d=0.005&system.restitution=0.4&load.kind=harmonic&load.mean=0.6"
    page = desk.open(f"{plain}&load.amplitude=1&tool.impedance=1.5")
    assert "into the rod" in blown(page)
    expect(page.locator("#blow-scale")).to_contain_text("impedance")
    page.locator("#blow-slide-tool-impedance").evaluate("s => { s.value = 3; s.dispatchEvent(new Event('input')); }")
    until(page, "location.hash.includes('tool.impedance=3')")
    page.evaluate("import('/static/core/state.js').then(({ setKey }) => setKey('tool.impedance', -1))")
    expect(page.locator("#blow-problem")).to_contain_text("tool.impedance: expected a finite number greater than 0")
    expect(page.locator("#blow-problem")).to_contain_text("the case before")
    page.evaluate("import('/static/core/state.js').then(({ setKey }) => setKey('tool.impedance', 2))")
    expect(page.locator("#blow-problem")).to_have_text("")


def test_the_motion_says_that_its_contact_takes_no_time(desk: Desk) -> None:
    page = desk.open("panel=orbits&machine=mini-breaker")
    page.get_by_role("button", name="See one blow by its waves").click()
    expect(page.locator("#panel-blow")).to_be_visible()
    assert "into the rock" in blown(page)


# --- machine


@pytest.mark.parametrize("desk", PLAYING, indirect=True)
def test_a_machine_says_what_the_command_line_says_and_plays(desk: Desk) -> None:
    page = desk.open("panel=orbits&machine=valve-drifter")
    expect(page.locator("#verdict")).to_have_text("Runs")
    driven(page)
    si = machine_answer(load_case("valve-drifter")).to_json_dict()["si"]
    assert figure(page, "blow energy") == "301J"
    assert float(figure(page, "striking speed").removesuffix("m/s")) == pytest.approx(
        si["impact_velocity_m_s"], rel=5e-3
    )
    assert float(figure(page, "stroke").removesuffix("mm")) == pytest.approx(1e3 * si["stroke_m"], rel=5e-3)
    assert float(figure(page, "oil flow").removesuffix("l/min")) == pytest.approx(si["oil_flow_l_per_min"], rel=5e-3)
    until(page, "Number(document.querySelector('#machine-stage').dataset.blows) > 0")  # it plays by itself
    expect(page.locator("label", has=page.locator("#machine-slow"))).to_contain_text(re.compile(r"1/\d+ speed"))
    page.click("#machine-play")
    expect(page.locator("#machine-play")).to_have_attribute("aria-label", "Play")
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
    page.locator("#machine-stage").evaluate("stage => { stage.tabIndex = -1; stage.focus(); }")
    page.keyboard.press("Space")
    expect(page.locator("#machine-play")).to_have_attribute("aria-label", "Pause")


def test_sliders_of_a_machine_change_its_answer_until_it_stops(desk: Desk) -> None:
    page = desk.open("panel=orbits&machine=valve-breaker")
    driven(page)
    expect(page.locator("#machine-play")).to_have_attribute("aria-label", "Play")
    rate, drawn = figure(page, "blow rate"), ink(page, "#machine-stage")
    slide(page, "load-ports-0-behind", 70)  # the short stroke
    driven(page)
    assert float(rate.removesuffix("Hz")) == pytest.approx(9.45, abs=0.02)
    assert float(figure(page, "blow rate").removesuffix("Hz")) > 11.7
    assert ink(page, "#machine-stage") != drawn
    until(page, "location.hash.includes('load.ports=')")
    slide(page, "load-pressure", 80)
    expect(page.locator("#verdict")).to_have_text("Stalls, on the tool")
    expect(page.locator("#machine-sentence")).to_contain_text(
        re.compile(r"force at the tool 2\.4\d* kN, which must be below 0 N")
    )
    expect(page.locator("#machine-obstacle")).to_contain_text("What would be needed: make the return force pull")
    expect(page.locator("#machine-scale")).to_be_hidden()
    slide(page, "load-pressure", 200)
    expect(page.locator("#verdict")).to_have_text("Runs")
    expect(page.locator("#machine-scale")).to_be_visible()
    slide(page, "contact-restitution", 0)
    driven(page)
    assert knows(page, "core/state.js:data.tables.contact.restitution") == 0


def test_a_machine_is_shown_from_its_start(desk: Desk, request: pytest.FixtureRequest) -> None:
    request.node.expected_words = ("422",)
    page = desk.open("panel=orbits&machine=valve-breaker&simulation.modes=0")
    driven(page)
    expect(page.locator("#machine-start-position")).to_be_hidden()
    page.click("#machine-of-start")
    page.wait_for_selector("#machine-stage[data-label='runs 1/1']")
    expect(page.locator("#machine-sentence")).to_contain_text("From this start the machine runs 1/1: 3.751 kJ")
    expect(page.locator("#machine-start-position")).to_have_value("-39 mm")
    assert knows(page, "core/state.js:view.machineShow") == "start"
    page.fill("#machine-start-position", "39 mm")
    page.press("#machine-start-position", "Enter")
    expect(page.locator("#machine-start-problem")).to_contain_text("the bar is on the negative side")
    page.click("#machine-start-draw")
    until(page, f"{STATE}(({{ data }}) => data.tables.start.position < 0)")
    assert knows(page, "core/state.js:data.tables.start.velocity").endswith(" m/s")
    expect(page.locator("#machine-start-problem")).to_be_empty()
    page.wait_for_selector("#machine-stage[data-label]:not([data-label=''])")
    slide(page, "load-pressure", 80)  # whatever the start, it stays on the tool in the end
    page.wait_for_selector("#machine-stage:not([data-label^=runs])")
    expect(page.locator("#machine-scale")).to_be_visible()
    page.click("#machine-of-cycle")
    expect(page.locator("#machine-scale")).to_be_hidden()


def test_the_forces_of_a_valve_without_a_pressure_move_together(desk: Desk) -> None:
    ports = '[{"behind":1.0,"side":"back","to":"power"},{"on":"impact","to":"return"}]'
    load = f'load.kind=valve&load.states={{"return":-0.4,"power":1.8}}&load.ports={ports}'
    page = desk.open(f"panel=orbits&system.s=2000&system.d=0&system.restitution=0.2&system.strain=reversed&{load}")
    driven(page)
    speed = math.sqrt(2.0 * 2.2 / (1.0 - 0.2**2))
    assert float(figure(page, "striking speed")) == pytest.approx(speed, rel=5e-3)
    slide(page, "load-states", 2)
    driven(page)
    assert knows(page, "core/state.js:data.tables.load.states") == {"return": -0.8, "power": 3.6}
    expect(page.locator("#slide-load-states")).to_have_attribute("aria-valuetext", re.compile("^2"))
    assert float(figure(page, "striking speed")) == pytest.approx(speed * math.sqrt(2.0), rel=5e-3)
    page.evaluate(f"{STATE}(({{ setKey }}) => setKey('load.states.power', 2.7))")
    driven(page)
    expect(page.locator("#slide-load-states")).to_have_attribute("aria-valuetext", re.compile("^1"))
    slide(page, "load-states", 0.25)
    driven(page)
    assert knows(page, "core/state.js:data.tables.load.states") == {"return": -0.2, "power": 0.675}


def test_the_screen_is_of_the_kind_of_the_case(desk: Desk) -> None:
    """A clocked load and a machine that switches itself have each their stage, their sliders and their details."""
    page = desk.open("panel=orbits&machine=mini-breaker")
    parts = [["#stage", "#orbit-table", "#motion-details", "#slide-load_factor"]]
    parts += [["#machine-stage", "#machine-details", "#slide-load-pressure"]]
    for machine, (here, gone) in (("valve-breaker", parts[::-1]), ("mini-breaker", parts)):
        page.select_option("#machine", machine)
        (driven if machine == "valve-breaker" else moved)(page)
        for part in here:
            expect(page.locator(part)).to_be_visible()
        for part in gone:
            expect(page.locator(part)).not_to_be_visible()
        page.click("#tab-blow")
        assert "A blow of" in blown(page)
        expect(page.locator("#blow-stage")).to_be_visible()
        page.click("#tab-orbits")


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
    until(page, f"{STATE}(({{ data }}) => data.machine?.units !== 'SI')")  # its headline is a line shorter
    expect(page.locator("#verdict")).to_have_text("Runs")
    page.click("#form-si")
    until(page, f"{STATE}(({{ data }}) => data.machine?.units === 'SI')")
    expect(page.locator("#field-load-ports-0-behind")).to_have_value(re.compile("m$"))
    page.select_option("#field-load-kind", "square")
    expect(page.locator("#field-load-amplitude")).to_have_value(re.compile("N$"))
    expect(page.locator("#slide-kappa")).to_be_visible()
