"""The one screen of the workbench in a real browser: what stands where, what is typed, undo, and late answers."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

import pytest

pytest.importorskip("fastapi")

from playwright.sync_api import Page, expect

from percuss.case.catalogue.sample_cases import MACHINES, STRUCTURES, machine_text
from web_desk import Desk, came, figure, finished, held, knows, let_go, settled, slide, until

if TYPE_CHECKING:
    from pathlib import Path

pytestmark = pytest.mark.browser

SIZES = ((1366, 650), (1366, 768), (1920, 1080))

LAYOUT = """() => {
  /* what is out of the window, cut off, or on top of something else */
  const found = [];
  const name = (one) => one.id ? `#${one.id}` : `${one.localName}.${one.className}`;
  const [wide, high] = [innerWidth, innerHeight];
  for (const selector of ["#headline", "#stage-place", "#map-place", "#controls .slider", "#drawers"]) {
    const box = document.querySelector(selector).getBoundingClientRect();
    const inside = box.left >= 0 && box.top >= 0 && box.right <= wide && box.bottom <= high && box.height;
    if (!inside) found.push(`${selector}: out of the window`);
  }
  const { scrollHeight, scrollWidth } = document.documentElement;
  if (scrollHeight > high || scrollWidth > wide) found.push(`the page scrolls: ${scrollWidth} x ${scrollHeight}`);
  const words = [];
  for (const place of document.querySelectorAll("#top, #headline, #controls, #map-place, .play, #drawers")) {
    const walk = document.createTreeWalker(place, NodeFilter.SHOW_TEXT);
    while (walk.nextNode()) {
      const node = walk.currentNode, holder = node.parentElement;
      const text = node.data.trim();
      if (!text || holder.closest("option, .hidden-words, .sheet, .tip") || !holder.checkVisibility()) continue;
      const range = document.createRange();
      range.selectNodeContents(node);
      let clip = holder;
      while (clip !== place && getComputedStyle(clip).overflowX === "visible") clip = clip.parentElement;
      const scrolls = ["auto", "scroll"].includes(getComputedStyle(clip).overflowY);
      const edge = clip.getBoundingClientRect();
      for (const box of range.getClientRects()) {
        if (scrolls && box.bottom > edge.bottom) continue;
        const across = box.left < edge.left - 1 || box.right > edge.right + 1;
        const down = box.top < edge.top - 2 || box.bottom > edge.bottom + 2;
        if (across || down) found.push(`${name(clip)}: “${text}” is cut off`);
        words.push([text, holder, box]);
      }
    }
    for (const box of place.querySelectorAll("input:not([type=range], [type=checkbox])"))
      if (box.checkVisibility() && box.scrollWidth > box.clientWidth + 1) found.push(`${name(box)}: “${box.value}”`);
    for (const box of place.querySelectorAll("select")) {
      if (!box.checkVisibility()) continue;
      const twin = box.cloneNode();
      const { text } = box.selectedOptions[0];
      twin.append(new Option(text));
      twin.style.cssText = "position: absolute; visibility: hidden; width: auto; max-width: none";
      box.after(twin);
      if (twin.offsetWidth > box.offsetWidth + 1) found.push(`${name(box)}: “${text}” is cut off`);
      twin.remove();
    }
  }
  const controls = [...document.querySelectorAll("button, select, input:not([type=range]), summary")]
    .filter((one) => one.checkVisibility() && !one.closest(".hidden-words"))
    .map((one) => [name(one), one, one.getBoundingClientRect(), one.closest("#controls, .drawer-body")])
    .filter(([, , box, scrolled]) => !scrolled || box.bottom < scrolled.getBoundingClientRect().bottom);
  for (const all of [words, controls])
    for (const [i, [text, holder, a]] of all.entries())
      for (const [other, beside, b] of all.slice(0, i)) {
        const across = Math.min(a.right, b.right) - Math.max(a.left, b.left);
        const down = Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top);
        if (holder !== beside && across > 1 && down > 3) found.push(`“${text}” over “${other}”`);
      }
  return [...new Set(found)];
}"""


BLANK = """() => [...document.querySelectorAll(".place canvas:not(#blows-inset)")]
  .filter((one) => one.checkVisibility() && one.width && one.height)
  .filter((one) => !one.getContext("2d").getImageData(0, 0, one.width, one.height).data.some((value) => value))
  .map((one) => `blank: ${one.id || one.ariaLabel}`)"""


def test_everything_is_in_one_window(desk: Desk) -> None:
    """Of every sample: verdict, stage, map, reasons and sliders at once and drawn, no word cut off or under another."""
    page = desk.open("machine=mini-breaker")
    found = {}

    def look(what: str) -> None:
        settled(page, "margins")
        for width, height in SIZES:
            page.set_viewport_size({"width": width, "height": height})
            settled(page, "margins")
            if wrong := [*page.evaluate(LAYOUT), *page.evaluate(BLANK)]:
                found[what, width, height] = wrong

    for machine in (*MACHINES, *STRUCTURES):
        page.select_option("#machine", machine.name)
        look(machine.name)
    page.select_option("#machine", "mini-breaker")
    settled(page)
    page.click("#pin")
    for factor in (0.2, 1.1):  # the longest words, beside the change and what is kept
        slide(page, "load_factor", factor)
        look(f"{factor}")
    page.click("#tab-lessons")
    page.get_by_role("button", name="Begin lesson 1").click()
    look("lesson")
    assert found == {}


BOXES = """() => {
  const places = ["#headline", "#stage-place", "#stage", "#map-place", "#map", "#strip-place", "#drawers", ".play",
    "#slide-load_factor", "#slide-load_factor-value", "#map-readout", "#map-x", "#map-y", "#map-q"];
  const found = Object.fromEntries(places.map((place) => [place, document.querySelector(place)]));
  for (const cell of document.querySelectorAll("#headline .figures div")) found[cell.lastChild.textContent] = cell;
  const box = ({ left, top, width, height }) => [left, top, width, height].map(Math.round).join();
  const verdict = document.querySelector("#verdict").textContent;
  return [verdict, Object.entries(found).map(([name, one]) => [name, box(one.getBoundingClientRect())])];
}"""


def test_nothing_jumps_while_a_slider_is_dragged_across_the_flip_and_the_fold(desk: Desk) -> None:
    page = desk.open("machine=mini-breaker")
    finished(page)
    seen: dict[str, set[str]] = {}
    verdicts = set()
    for name in ("load_factor", "bar-length"):  # along the map, and to another map
        slider = page.locator(f"#slide-{name}").bounding_box()
        assert slider is not None
        y = slider["y"] + slider["height"] / 2
        page.mouse.move(slider["x"] + 0.2 * slider["width"], y)
        page.mouse.down()
        for share in (*range(20, 100, 4), *range(98, 20, -6)):
            page.mouse.move(slider["x"] + 0.01 * share * slider["width"], y)
            page.wait_for_timeout(40)
            verdict, boxes = page.evaluate(BOXES)
            verdicts.add(verdict)
            for place, box in boxes:
                seen.setdefault(place, set()).add(box)
        page.mouse.up()
    assert verdicts >= {"Stable", "Unstable", "No steady motion"}
    assert {place: boxes for place, boxes in seen.items() if len(boxes) > 1} == {}


# --- what is typed beside a slider


LENGTH = "#slide-bar-length-value"


def typed(page: Page, field: str, text: str) -> str:
    """What a field says once a text was typed into it and answered."""
    page.fill(field, text)
    page.keyboard.press("Enter")
    settled(page)
    return page.locator(field).input_value().replace("\u202f", " ")


def metres(page: Page) -> float:
    return float(knows(page, "core/state.js:data.info.bar.length_m"))


def test_a_unit_that_is_typed_does_not_spoil_the_slider(desk: Desk) -> None:
    page = desk.open("machine=mini-breaker")
    settled(page)
    energy = float(figure(page, "blow energy").removesuffix("J"))
    assert energy == pytest.approx(180.0, rel=0.02)
    for text in ("32 cm", "0.32 m", "0,32 m", "320"):
        assert typed(page, LENGTH, text) == "320 mm"
    page.focus("#slide-bar-length")
    page.keyboard.press("ArrowRight")
    settled(page)
    assert metres(page) == pytest.approx(0.3232)
    assert page.locator(LENGTH).input_value().replace("\u202f", " ") == "323.2 mm"
    assert float(figure(page, "blow energy").removesuffix("J")) == pytest.approx(energy, rel=0.03)
    assert typed(page, "#slide-load-frequency-value", "1050 1/min") == "17.5 Hz"
    for text in ("0,36", "36 %", ".36"):
        assert typed(page, "#slide-restitution-value", text) == "0.36"
        assert knows(page, "core/state.js:data.tables.contact.restitution") == 0.36


@pytest.mark.parametrize(
    ("words", "field", "value"),
    [
        ("bar.length=32 cm", LENGTH, "320 mm"),
        ("bar.length=0.32 m", LENGTH, "320 mm"),
        ("load.frequency=1050 1/min", "#slide-load-frequency-value", "17.5 Hz"),
    ],
)
def test_a_unit_in_a_link_does_not_spoil_the_slider(desk: Desk, words: str, field: str, value: str) -> None:
    page = desk.open(f"machine=mini-breaker&{words}")
    settled(page)
    assert page.locator(field).input_value().replace("\u202f", " ") == value
    slider = page.locator(field.removesuffix("-value"))
    low, high, now = (float(slider.evaluate(f"one => one.{part}")) for part in ("min", "max", "value"))
    assert low < now < high
    assert now == pytest.approx(float(value.split()[0]))


def test_what_cannot_be_is_told_beside_the_field_and_a_double_click_goes_back(desk: Desk) -> None:
    page = desk.open("machine=mini-breaker")
    settled(page)
    for text, words in (
        ("32 kg", "a length is needed"),
        ("much", "does not begin with a number"),
        ("3 mn", "not a unit"),
    ):
        typed(page, LENGTH, text)
        expect(page.locator("#slide-bar-length-problem")).to_contain_text(words)
        expect(page.locator(LENGTH)).to_have_attribute("aria-invalid", "true")
        assert metres(page) == 0.32  # the hammer is as it was
    assert typed(page, LENGTH, "400 mm") == "400 mm"
    expect(page.locator("#slide-bar-length-problem")).to_be_empty()
    page.locator("#slide-bar-length").dblclick()
    settled(page)
    assert metres(page) == pytest.approx(0.32)


def test_the_ends_of_a_slider_can_be_typed(desk: Desk) -> None:
    page = desk.open("machine=mini-breaker")
    settled(page)
    slider, low, high = "#slide-bar-length", *(f"[aria-label='Bar length: {end}']" for end in ("from", "to"))
    page.fill(low, "30 cm")
    page.fill(high, "340")
    page.keyboard.press("Enter")
    assert page.locator(slider).evaluate("one => [one.min, one.max].map(Number)") == [300.0, 340.0]
    page.fill(high, "200 mm")  # less than the other end
    page.keyboard.press("Enter")
    assert page.locator(high).input_value().startswith("340")
    typed(page, f"{slider}-value", "350 mm")  # beyond its end, which gives way
    assert page.locator(slider).evaluate("one => Number(one.max)") == 350.0


# --- undo


def design(page: Page) -> list[Any]:
    """Machine, restitution and length of what is on the page, once all is at rest."""
    settled(page)
    tables = knows(page, "core/state.js:data.tables")
    return [page.locator("#machine").input_value(), tables["contact"]["restitution"], tables["bar"]["length"]]


def test_designs_are_undone_and_done_again_a_gesture_at_a_time(desk: Desk) -> None:
    page = desk.open("machine=mini-breaker")
    designs = [design(page)]
    expect(page.locator("#undo")).to_be_disabled()
    expect(page.locator("#changes")).to_be_hidden()
    box = page.locator("#slide-restitution").bounding_box()
    assert box is not None
    page.mouse.move(box["x"] + 0.5 * box["width"], box["y"] + box["height"] / 2)
    page.mouse.down()
    for share in (0.4, 0.5, 0.6):  # written more than once while it is dragged, and one step all the same
        page.mouse.move(box["x"] + share * box["width"], box["y"] + box["height"] / 2, steps=4)
        page.wait_for_timeout(250)
    page.mouse.up()
    designs.append(design(page))
    typed(page, LENGTH, "400 mm")
    designs.append(design(page))
    page.click("#tab-case")  # a drawer is no step
    settled(page)
    page.click("#tab-experiment")
    expect(page.locator("#changes summary")).to_be_visible()
    page.click("#changes summary")
    expect(page.locator("#changes li")).to_have_count(2)
    expect(page.locator("#changes li", has_text="ength")).to_have_text(
        re.compile(r"bar length: 400\smm \(was 320\smm\)")
    )
    page.select_option("#machine", "heavy-breaker")
    designs.append(design(page))
    assert len({str(one) for one in designs}) == 4
    ways = [lambda: page.click("#undo"), lambda: page.keyboard.press("Control+z"), lambda: page.go_back()]
    for undo, before in zip(ways, designs[-2::-1], strict=True):
        undo()
        until(page, f"document.querySelector('#machine').value === '{before[0]}'")
        assert design(page) == before
    expect(page.locator("#undo")).to_be_disabled()
    again = [lambda: page.click("#redo"), lambda: page.keyboard.press("Control+y"), lambda: page.go_forward()]
    for redo, after in zip(again, designs[1:], strict=True):
        redo()
        until(page, f"document.querySelector('#machine').value === '{after[0]}'")
        assert design(page) == after
    expect(page.locator("#redo")).to_be_disabled()


def test_undo_in_an_own_case_leaves_what_its_changes_are_of(desk: Desk, tmp_path: Path) -> None:
    path = tmp_path / "own.toml"
    path.write_text(machine_text("mini-breaker"), encoding="utf-8")
    page = desk.open("panel=case&machine=heavy-breaker")
    page.set_input_files("#upload-toml", path)
    page.click("#drawer-close")
    begun = design(page)
    expect(page.locator("#changes")).to_be_hidden()
    for field, value in (("#slide-restitution-value", "0.27"), (LENGTH, "400 mm")):
        typed(page, field, value)
        settled(page)
    expect(page.locator("#changes li")).to_have_count(2)
    page.click("#undo")
    expect(page.locator("#changes li")).to_have_count(1)
    page.reload()
    expect(page.locator("#changes li")).to_have_count(1)
    page.click("#undo")
    expect(page.locator("#changes")).to_be_hidden()
    assert design(page) == begun
    page.click("#redo")
    expect(page.locator("#changes li")).to_have_count(1)


def test_changes_are_taken_back_one_by_one_or_all(desk: Desk) -> None:
    page = desk.open("machine=mini-breaker")
    begun = design(page)
    for _ in range(2):
        slide(page, "restitution", 0.27)
        typed(page, LENGTH, "400 mm")
        expect(page.locator("#changes li")).to_have_count(2)
        page.click("#changes summary")
        page.locator("#changes li", has_text="ength").locator("button").click()
        expect(page.locator("#changes li")).to_have_count(1)
        assert design(page)[1:] == [0.27, begun[2]]
        page.click("#reset")
        expect(page.locator("#changes")).to_be_hidden()
        assert design(page) == begun
        expect(page.locator("#reset")).to_be_disabled()


# --- late answers


def test_a_slow_answer_is_never_that_of_another_place(desk: Desk) -> None:
    """The figures are pale while they are of an earlier state, and never of a place that the sliders have left."""
    page = desk.open("machine=mini-breaker")
    settled(page)
    before = page.locator("#headline .figures").inner_text()
    pale = "getComputedStyle(document.querySelector('#headline .figures')).opacity < 0.5"
    late = held(page, "quick")
    slide(page, "restitution", 0.27)
    came(page, late)
    slide(page, "restitution", 0.18)
    until(page, pale)
    assert page.locator("#headline .figures").inner_text() == before
    first = late.pop()
    first.continue_()
    second = came(page, late)  # asked for only now, of where the slider is
    assert second.request.post_data_json["values"] == {"restitution": 0.18}
    until(page, pale)
    expect(page.locator("#map-readout")).to_contain_text(re.compile(r"estitution.* = 0\.18,.*…"))
    assert page.locator("#slide-restitution-value").input_value() == "0.18"
    let_go(page, "quick", late)
    settled(page)
    assert not page.evaluate(pale)
    assert knows(page, "core/state.js:data.tables.contact.restitution") == 0.18
    after = page.locator("#headline .figures").inner_text()
    desk.open("machine=mini-breaker&contact.restitution=0.18")
    settled(page)
    assert page.locator("#headline .figures").inner_text() == after != before


# --- for everybody


@pytest.mark.parametrize("desk", [{"forced_colors": "active"}], indirect=True)
def test_forced_colours_show_what_is_chosen(desk: Desk) -> None:
    """Not by a colour of the page's own, of which none is left: by that of the system for what is highlighted."""
    page = desk.open("panel=orbits&machine=mini-breaker")
    settled(page)
    page.click("#tab-case")
    look = """selector => {
      const { backgroundColor, borderColor, color, outlineStyle } = getComputedStyle(document.querySelector(selector));
      return [backgroundColor, borderColor, color, outlineStyle].join(" ");
    }"""
    for chosen, other in (
        ("#tab-case", "#tab-orbits"),
        ("#headline .segments [aria-pressed=false]", "#headline .segments [aria-pressed=true]"),
        ("#explore", "#tab-report"),
        ("#form-si", "#form-plain"),
    ):
        assert page.evaluate(look, chosen) != page.evaluate(look, other), chosen
