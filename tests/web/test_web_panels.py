"""Panels of the workbench in a real browser: the map and the orbits."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest

pytest.importorskip("fastapi")

from playwright.sync_api import Route, expect

from percuss import palette
from percuss.case import simulation_answer
from percuss.case.case import case_of
from percuss.stability import reduced_criterion
from percuss.steady import steady_states
from web_client import unpacked
from web_desk import (
    STATE,
    Desk,
    came,
    figure,
    finished,
    held,
    ink,
    knows,
    let_go,
    point,
    settled,
    slide,
    steady_json,
    until,
)

pytestmark = pytest.mark.browser


# --- map


def test_clicks_drags_and_keys_move_the_design_on_the_map(desk: Desk) -> None:
    page = desk.open("machine=mini-breaker")
    page.wait_for_selector("#map[data-fine='200'][data-curves]")
    before = ink(page, "#map")
    page.mouse.click(*point(page, "#map", 0.75, 0.8))
    expect(page.locator("#verdict")).to_have_text("Stable")
    until(page, "Number(document.querySelector('#map').dataset.design.split(',')[0]) > 0.5")
    until(page, "location.hash.includes('contact.restitution=0.6')")
    assert ink(page, "#map") != before
    page.mouse.move(*point(page, "#map", 0.75, 0.8))
    page.mouse.down()
    page.mouse.move(*point(page, "#map", 0.3, 0.85), steps=8)
    expect(page.locator("#verdict")).to_have_text("No steady motion")
    x, y = point(page, "#map", 1.0, 0.5)
    page.mouse.move(x + 150, y, steps=3)  # out of the map: it stays at its edge
    page.mouse.up()
    until(page, "document.querySelector('#map').dataset.design.startsWith('0.9,')")
    page.focus("#map")
    for _ in range(4):
        page.keyboard.press("Shift+ArrowLeft")
    until(page, "Number(document.querySelector('#map').dataset.design.split(',')[0]) < 0.8")
    page.select_option("#map-x", "load.frequency")
    until(page, "location.hash.includes('x=load.frequency')")
    page.wait_for_selector("#map[data-coarse='8']")
    expect(page.locator("#map-readout")).to_contain_text("Hz")


def test_a_slow_map_comes_in_strips_and_does_not_hold_up_a_move(desk: Desk) -> None:
    strips = held(desk.page, "map")
    page = desk.open("machine=mini-breaker&x=load.frequency&xr=15:20&y=bar.length&yr=300:340&q=power")
    came(page, strips)
    strips.pop(0).continue_()
    page.wait_for_selector("#map[data-coarse='8']")
    came(page, strips)  # the first strip of the finer map: it does not come as long as this test likes
    expect(page.locator("#map-progress")).to_be_visible()
    page.focus("#map")
    page.keyboard.press("ArrowUp")  # along the map's own axis: the map goes on
    settled(page)
    assert float((page.locator("#map").get_attribute("data-design") or "").split(",")[1]) > 320
    strip = strips.pop()
    assert strips == []  # nothing but this one strip was asked for
    strip.continue_()
    expect(page.locator("#map-status")).to_contain_text("% of")
    assert len(came(page, strips).request.post_data_json["x"]["values"]) > 8
    strips.clear()
    slide(page, "restitution", 0.3)  # another hammer: another map from the beginning
    assert len(came(page, strips).request.post_data_json["x"]["values"]) == 8


def map_of(route: Route) -> dict[str, Any]:
    """The values of a map that was asked for, which goes on to the page."""
    response = route.fetch()
    _, arrays = unpacked(response.body())
    route.fulfill(response=response)
    return arrays


@pytest.mark.parametrize("quantity", ["margin", "stable"])
def test_colours_and_legend_are_right_from_the_first_strip_on(desk: Desk, quantity: str) -> None:
    """The strips and the coarse map around them have one scale, which is that of the legend."""
    asked = held(desk.page, "map")
    plane = "x=bar.length&xr=160:480 mm&y=restitution&yr=0:0.9"
    page = desk.open(f"machine=mini-breaker&{plane}&q={quantity}")
    known = []
    for _ in range(2):  # the coarse map and the first strip of a finer one, and no more
        came(page, asked)
        known.append(map_of(asked.pop(0)))
    came(page, asked)
    settled(page)
    legend = [text.replace("\u202f", " ") for text in page.locator("#map-place .legend li").all_inner_texts()]
    if quantity == "stable":
        motions = np.concatenate([part["orbits"].ravel() > 0 for part in known])
        stable = np.concatenate([part["stable"].ravel() == 1 for part in known])
        kinds = ("no steady motion", ~motions), ("steady motion, unstable", motions & ~stable)
        seen = dict([*kinds, ("stable steady motion", stable)])
        assert [name for name in legend if name in seen] == [name for name, cells in seen.items() if cells.any()]
    else:
        values = np.concatenate([part[quantity].ravel() for part in known])
        low, high = min(max(float(np.nanmin(values)), -1.0), 0.0), max(float(np.nanmax(values)), 0.0)
        assert "the border of stability" in legend[2]
        ends = [float(legend[i].split()[0].replace("−", "-")) for i in (0, 4)]
        assert ends == pytest.approx([low, high], abs=0.01 * (high - low))
    let_go(page, "map", asked)


def test_curves_come_some_points_at_a_time(desk: Desk) -> None:
    """As few as a busy machine answers in time: 25 at once took it 30 s, and the finer map went with them."""
    asked = held(desk.page, "boundaries")
    page = desk.open("machine=mini-breaker&x=bar.length&xr=160:480 mm&y=restitution&yr=0:0.9&q=margin")
    counts = []
    for _ in range(3):
        route = came(page, asked)
        page.wait_for_timeout(500)  # it takes longer than a piece of the map may
        counts.append(len(route.request.post_data_json["x"]["values"]))
        asked.pop(0).continue_()
    assert counts[0] == 2 and max(counts) < 8
    let_go(page, "boundaries", asked)


PHONE = [{"viewport": {"width": 390, "height": 844}, "has_touch": True}]


@pytest.mark.parametrize("desk", PHONE, indirect=True)
@pytest.mark.parametrize(("panel", "place"), [("map", "design"), ("branches", "spot")])
def test_a_swipe_moves_the_page_and_a_tap_the_design(desk: Desk, panel: str, place: str) -> None:
    page = desk.open(f"panel={panel}&machine=mini-breaker")
    canvas = page.locator(f"#{panel}")
    scrolled = "[...document.querySelectorAll('#screen, .drawer-body')].reduce((sum, one) => sum + one.scrollTop, 0)"
    page.wait_for_selector(f"#{panel}[data-{place}]")
    finished(page)
    canvas.evaluate("canvas => canvas.scrollIntoView({ block: 'center' })")
    x, y = point(page, f"#{panel}", 0.6, 0.5)
    if panel == "map":
        before = canvas.get_attribute("data-design")
        page.touchscreen.tap(x, y + 15)
        finished(page)
        assert canvas.get_attribute("data-design") != before
    before, top = canvas.get_attribute(f"data-{place}"), page.evaluate(scrolled)
    finger = page.context.new_cdp_session(page)

    def swipe(x: float, y: float) -> None:
        finger.send("Input.dispatchTouchEvent", {"type": "touchStart", "touchPoints": [{"x": x, "y": y}]})
        for up in range(20, 220, 20):
            finger.send("Input.dispatchTouchEvent", {"type": "touchMove", "touchPoints": [{"x": x, "y": y - up}]})
        finger.send("Input.dispatchTouchEvent", {"type": "touchEnd", "touchPoints": []})
        finished(page)

    if panel == "map":
        swipe(x, y + 15)  # it begins on the design
        assert canvas.get_attribute("data-design") != before and page.evaluate(scrolled) == top
        before = canvas.get_attribute("data-design")
    swipe(x - 100, y)
    until(page, f"{scrolled} > {top} + 100")
    assert canvas.get_attribute(f"data-{place}") == before


def test_late_answers_are_taken_for_what_they_are(desk: Desk) -> None:
    page = desk.open("machine=mini-breaker")
    finished(page)
    readout = page.locator("#map-readout")
    expect(readout).to_contain_text(re.compile(r"load factor p₀/p₁ = [\d.]+: stable"))
    late = held(page, "quick")
    slide(page, "load_factor", 1.1)
    came(page, late)
    settled(page, "quick")
    expect(readout).to_contain_text("load factor p₀/p₁ = 1.1: …")  # never an answer at another place
    let_go(page, "quick", late)
    finished(page)
    expect(readout).to_contain_text("load factor p₀/p₁ = 1.1: no steady motion")
    maps = held(page, "map")
    page.select_option("#map-q", "power")
    came(page, maps)
    page.select_option("#map-q", "margin")
    maps.pop().continue_()  # a map of the quantity before
    came(page, maps)
    settled(page)
    assert page.locator("#map-status .problem").count() == 0
    expect(page.locator("#map-place .legend")).to_contain_text("W")
    let_go(page, "map", maps)
    expect(page.locator("#map-place .legend")).to_contain_text("the border of stability")


def test_a_map_of_the_hammer_before_tells_nothing_of_this_one(desk: Desk) -> None:
    page = desk.open("machine=mini-breaker")
    finished(page)
    beside, (x, y) = point(page, "#map", 0.4, 0.6), point(page, "#map", 0.0, 0.6)
    page.mouse.move(*beside)
    expect(page.locator("#map-tip")).to_be_visible()
    page.mouse.move(x - 30.0, y)
    expect(page.locator("#map-tip")).to_be_hidden()
    maps = held(page, "map")
    drawn = ink(page, "#map")
    page.evaluate("import('/static/core/state.js').then(({ setKey }) => setKey('bar.damping_ratio', 0.2))")
    came(page, maps)
    settled(page)
    assert ink(page, "#map") != drawn  # it is pale
    page.mouse.move(*beside)
    settled(page)
    expect(page.locator("#map-tip")).to_be_hidden()
    let_go(page, "map", maps)
    finished(page)
    page.mouse.move(beside[0] + 1.0, beside[1])
    expect(page.locator("#map-tip")).to_be_visible()


def test_strips_grow_while_rows_cost_little_beside_what_a_strip_costs(desk: Desk) -> None:
    page = desk.open("machine=mini-breaker")
    strips = """([fixed, row, first]) => import('/static/map/map_levels.js').then(({ rowsOfNext }) => {
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
    page = desk.open("machine=mini-breaker")
    page.wait_for_selector("#map[data-fine='200']")
    seen = set()
    for right, up in ((0.25, 0.6), (0.75, 0.75), (0.75, 0.3)):
        x, y = point(page, "#map", right, up)
        page.mouse.click(x, y)
        finished(page)  # the diamond stands there now: look beside it
        place = page.locator("#map").evaluate(
            """(canvas, [right, up]) => [...canvas.getContext("2d").getImageData(
              right * canvas.width + 16 * canvas.width / canvas.clientWidth, (1 - up) * canvas.height, 1, 1).data]
                .slice(0, 3)""",
            [right, up],
        )
        named = {
            name: knows(page, f"pictures/colours.js:theme().verdicts.{name}") for name in ("none", "unstable", "stable")
        }
        colour = "#" + "".join(f"{part:02x}" for part in place)
        found = next(name for name, value in named.items() if value == colour)
        orbits = steady_states(case_of(knows(page, "core/state.js:data.tables"), "page").system()).orbits
        verdicts = [reduced_criterion(orbit).stable for orbit in orbits]
        truth = "stable" if any(verdicts) else "unstable" if orbits else "none"
        assert found == truth
        seen.add(found)
    assert len(seen) > 1


def test_a_machine_that_switches_itself_has_its_map(desk: Desk) -> None:
    page = desk.open("machine=valve-breaker")
    page.wait_for_selector("#map[data-fine='50']")
    legend = page.locator("#map-place .legend li").all_inner_texts()
    assert legend == ["runs", "stays on the wall", "reaches no port", "the present design"]
    expect(page.locator("#map-status")).to_have_text("50 × 50 cells, each of a rigid piston.")
    expect(page.locator("#map-readout")).to_contain_text("port 1 → power: place = 130")
    drawn, asked = ink(page, "#map"), len([url for url in desk.asked if url.endswith("/api/map")])
    page.mouse.click(*point(page, "#map", 0.5, 0.12))  # too little pressure
    expect(page.locator("#verdict")).to_have_text("Stalls, on the tool")
    expect(page.locator("#map-readout")).to_contain_text("stalls")
    assert float(knows(page, "core/state.js:data.tables.load.pressure").removesuffix(" bar")) < 111
    until(page, f"{STATE}(({{ data }}) => data.info.tables.load.pressure === data.tables.load.pressure)")
    assert len([url for url in desk.asked if url.endswith("/api/map")]) == asked  # along the map's own axes
    page.select_option("#map-q", "blow_energy")
    until(page, f"{STATE}(({{ view }}) => view.q === 'blow_energy')")
    until(page, "document.querySelector('#map-status').innerText.startsWith('50')")
    assert ink(page, "#map") != drawn
    page.select_option("#machine", "mini-breaker")  # whose parameters are others
    expect(page.locator("#map-y")).to_have_value("load_factor")
    page.wait_for_selector("#map[data-coarse]")


def test_a_map_of_a_hammer_with_a_tool_on_rock_shows_what_its_blow_does(desk: Desk) -> None:
    page = desk.open("machine=drill-string&q=steel_tension")
    page.wait_for_selector("#map[data-coarse]")
    expect(page.locator("#map-place .legend")).to_contain_text("MPa")
    of_blow = {"rock_share", "steel_tension", "rate_of_penetration", "joint_openings"}
    offered = "options => options.map(({ value }) => value)"
    assert of_blow <= set(page.locator("#map-q option").evaluate_all(offered))
    page.select_option("#machine", "oil-drifter")  # of which no hole is known, and whose tool has no joints
    page.wait_for_selector("#map-q option[value='stall']", state="attached")
    assert of_blow & set(page.locator("#map-q option").evaluate_all(offered)) == {"rock_share", "steel_tension"}


FOUND = "q=label&x=restitution&y=load_factor"


def test_found_motions_have_their_family_s_colour_and_tell_their_label(desk: Desk) -> None:
    case = "system.s=20&system.d=0.005&system.restitution=0.6&load.kind=harmonic&load.mean=0.7"
    page = desk.open(f"{FOUND}&{case}&load.amplitude=1")
    page.wait_for_selector("#map[data-fine='50']")
    legend = page.locator("#map-place .legend li").all_inner_texts()
    assert set(legend) <= {*(family.name for family in palette.FAMILIES), "the present design"}
    seen: dict[int, str] = {}
    for right, up in ((0.5, 0.9), (0.3, 0.6), (0.75, 0.2), (0.95, 0.45), (0.2, 0.4), (0.85, 0.55)):
        page.mouse.move(*point(page, "#map", right, up))
        expect(page.locator("#map-tip")).to_be_visible()
        finished(page)
        label = page.locator("#map-tip strong").inner_text()
        place = [float(number) for number in re.findall(r"= ([\d.]+)", page.locator("#map-tip").inner_text())]
        if not seen:  # the label is that of the hammer in the middle of the cell
            at = [span * round(value / span) for value, span in zip(place, (0.9 / 49, 1.0), strict=True)]
            at[1] = 0.02 + 1.18 / 49 * round((place[1] - 0.02) * 49 / 1.18)
            tables = {
                "system": {"s": 20.0, "d": 0.005, "restitution": at[0]},
                "load": {"kind": "harmonic", "mean": at[1], "amplitude": 1.0},
                "simulation": {"modes": 0, "impacts": 400},
            }
            assert simulation_answer(case_of(tables, "test")).motion.label == label
        near = page.locator("#map").evaluate(
            """(canvas, [right, up]) => [...canvas.getContext("2d").getImageData(
              right * canvas.width - 4, (1 - up) * canvas.height - 4, 8, 8).data]""",
            [right, up],
        )
        colours = {"#" + "".join(f"{part:02x}" for part in near[i : i + 3]) for i in range(0, len(near), 4)}
        number = palette.family_of(label)
        assert palette.FAMILIES[number].colour.light in colours, (label, colours)
        seen[number] = label
    assert len(seen) > 2
    x, y = point(page, "#map", 0.0, 1.0)
    page.mouse.move(x - 30.0, y)
    expect(page.locator("#map-tip")).to_be_hidden()


def test_the_page_has_the_palette_of_the_pictures(desk: Desk) -> None:
    page = desk.open("panel=orbits&machine=mini-breaker")
    ends = [knows(page, f"pictures/colours.js:signed({share})") for share in (-1, 1)]
    told = [[int(part) for part in re.findall(r"\d+", colour)] for colour in ends]
    stops = (palette.STRAIN[0].light, palette.STRAIN[-1].light)
    assert told == [[int(stop[i : i + 2], 16) for i in (1, 3, 5)] for stop in stops]
    assert knows(page, "pictures/colours.js:theme().kinds") == [kind.light for kind in palette.KINDS]
    page.click("#tab-report")
    expect(page.locator('#report-cards [data-figure="momentum_N_s"]')).to_contain_text("N·s")


def test_a_range_that_is_none_is_told_and_no_map_is_shown_over_another(
    desk: Desk, request: pytest.FixtureRequest
) -> None:
    request.node.expected_words = ("422",)
    page = desk.open("machine=mini-breaker")
    page.wait_for_selector("#map[data-fine='200'][data-curves]")
    page.fill("#map-x-from", "")
    page.keyboard.press("Tab")
    expect(page.locator("#map-range-problem")).to_contain_text("to a greater one")
    expect(page.locator("#map-x-from")).to_have_attribute("aria-invalid", "true")
    page.fill("#map-x-from", "0.1")
    page.keyboard.press("Tab")
    expect(page.locator("#map-range-problem")).to_have_text("")
    assert page.evaluate("document.activeElement.id") == "map-x"  # Tab leads on, though the map is another
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


# --- orbits


@pytest.mark.parametrize("desk", [{"viewport": {"width": 1360, "height": 1700}}], indirect=True)
def test_a_slider_moves_the_curve_the_table_and_the_circle(desk: Desk) -> None:
    page = desk.open("panel=orbits&machine=mini-breaker")
    expect(page.locator("#orbit-table tbody tr")).to_have_count(2)
    expect(page.locator("#orbit-table")).to_contain_text("yes")
    charts = [f"#orbit-table + .grid figure:nth-child({i}) > canvas" for i in (1, 2, 3)]
    for chart in charts:
        page.wait_for_selector(f"{chart}[data-drawn]")
    settled(page)
    before = [(ink(page, chart), page.locator(chart).get_attribute("data-drawn")) for chart in charts]
    slide(page, "restitution", 0.45)
    settled(page)
    expect(page.locator("#verdict")).to_have_text("Unstable")
    for chart, (old, drawn) in zip(charts, before, strict=True):
        page.locator(chart).scroll_into_view_if_needed()  # out of sight it would not be painted
        until(page, f"document.querySelector('{chart}').dataset.drawn > {drawn}")
        assert ink(page, chart) != old, chart
    slide(page, "load_factor", 1.1)
    expect(page.locator("#verdict")).to_have_text("No steady motion")
    expect(page.locator("#headline")).to_contain_text("exists from a load factor")


def test_the_orbits_equal_the_command_line(desk: Desk, capsys: pytest.CaptureFixture[str]) -> None:
    page = desk.open("panel=orbits&machine=hydraulic-drifter")
    answer = steady_json(capsys, "hydraulic-drifter")
    orbits = answer["periods"][0]["orbits"]
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
    shown = knows(page, "core/state.js:chosen()")
    values = [complex(*pair) for pair in shown["quick"]["multipliers"]["values"]]  # what the unit circle draws
    truth = orbits[shown["number"] - 1]["multipliers"]["moduli"]
    assert sorted(map(abs, values), reverse=True) == pytest.approx(truth, abs=1e-9)
    assert float(figure(page, "into the rock ▸").removesuffix("J")) == pytest.approx(
        answer["transfer"]["rock_energy"], abs=0.5
    )
    page.get_by_role("button", name="into the rock").click()
    expect(page.locator("#drawer-title")).to_have_text("One blow by waves")


def test_a_motion_that_does_not_strike_has_no_blow(desk: Desk) -> None:
    """No negative speed and no negative stress: a bar so soft that its end would be leaving the wall."""
    bar = "bar.length=1 m&bar.diameter=50 mm&bar.damping_ratio=0.001&contact.restitution=0.21&load.kind=harmonic"
    load = "load.mean=25 kN&load.amplitude=100 kN&load.frequency=3267 Hz"
    page = desk.open(f"panel=orbits&orbit=1&{bar}&{load}")
    expect(page.locator("#headline")).to_contain_text("the end does not strike forward")
    for name in ("blow energy", "striking speed", "percussive power", "peak stress"):
        assert figure(page, name).startswith("–"), name
    row = page.locator("#orbit-table tbody tr").first
    expect(row).to_contain_text("no: does not strike forward")
    assert float(row.locator("td").nth(4).inner_text().replace("−", "-")) < 1.0  # the rhythm margin


def test_a_structure_leaves_nothing_on_the_orbits_of_a_bar(desk: Desk) -> None:
    page = desk.open("panel=orbits&machine=stopped-oscillator")
    expect(page.locator("#orbit-table")).to_be_hidden()
    late = held(page, "quick")
    page.select_option("#machine", "mini-breaker")
    came(page, late)
    page.click("#theme")  # all is drawn anew while there is no answer yet
    settled(page, "quick")
    assert desk.said == []
    let_go(page, "quick", late)
    settled(page)
    expect(page.locator("#orbit-table tbody tr")).to_have_count(2)


def test_choosing_the_other_motion_changes_the_headline_and_a_chart_can_be_saved(desk: Desk) -> None:
    page = desk.open("panel=orbits&machine=mini-breaker")
    expect(page.locator("#verdict")).to_have_text("Stable")
    page.locator("#orbit-table tbody button").first.click()
    expect(page.locator("#verdict")).to_have_text("Not possible")
    expect(page.locator("#orbit-about")).to_contain_text("Motion 1")
    chart = page.locator("figure", has=page.get_by_label("Save: Impact phases")).first
    for kind in ("SVG", "PNG", "CSV"):
        if chart.get_by_role("button", name=kind).is_hidden():
            chart.locator("summary").click()
        with page.expect_download() as waiting:
            chart.get_by_role("button", name=kind).click()
        assert waiting.value.suggested_filename.endswith(f".{kind.lower()}")


# -- questions about the whole hammer -------------------------------------------------------------------------------


def test_the_best_hammer_is_found_shown_and_taken(desk: Desk) -> None:
    page = desk.open("panel=hammer&machine=valve-drifter")
    page.select_option("#hammer-vary-add", "load.ports[0].behind")
    expect(page.locator("#hammer-vary")).to_have_value("load.ports[0].behind=19.8:24.2 mm")
    page.fill("#hammer-vary", "load.ports[0].behind=10:14mm")
    page.select_option("#hammer-limits-add", "flow")
    page.locator("#hammer-limits").press_sequentially("60 l/min")
    page.fill("#hammer-hammers", "20")
    page.click("#hammer-run")
    expect(page.locator("#hammer-summary")).to_contain_text("The best hammer found: power into the rock")
    expect(page.locator("#hammer-status")).to_have_text("Answered.")
    assert page.locator("#hammer-answer img").evaluate("image => image.decode().then(() => image.naturalWidth > 300)")
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    page.click("#hammer-take")
    settled(page)
    best = knows(page, "core/state.js:data.tables.load.ports[0].behind")
    assert 10.0 <= float(best.removesuffix(" mm")) <= 14.0
    expect(page.locator("#hammer-status")).to_contain_text("The case has changed since")


def test_a_question_is_cancelled_and_a_mistake_is_told_with_its_remedy(desk: Desk) -> None:
    page = desk.open("panel=hammer&machine=valve-drifter&ask=tolerance")
    page.fill("#hammer-hammers", "10000")
    page.click("#hammer-run")
    expect(page.locator("#hammer-status")).to_contain_text("hammers")
    page.click("#hammer-cancel")
    expect(page.locator("#hammer-status")).to_have_text("Cancelled.")
    page.select_option("#hammer-question", "compare")
    page.fill("#hammer-beside", "nonsense")
    page.click("#hammer-run")
    expect(page.locator("#hammer-problem")).to_contain_text("a machine of the catalogue")
    desk.said.clear()  # the browser tells of the refusal, too
