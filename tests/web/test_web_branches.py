"""The panel Branches in a real browser: branches, diagrams, structures, and the motion at every place."""

from __future__ import annotations

import json
import math
import re
from typing import Any
from urllib.parse import urlencode

import pytest
from playwright.sync_api import Page, expect

from percuss.case.catalogue.sample_cases import STRUCTURES
from percuss.cli import main
from percuss.explore import BranchEvent
from web_desk import PLAYING, STATE, Desk, came, held, ink, knows, let_go, settled, slide, until

pytest.importorskip("fastapi")


# -- what the tests of the panel branches share ----------------------------------------------------------------------


pytestmark = pytest.mark.browser
RIGID = "bmodes=0&system.s=5&system.d=0&system.restitution=0.5&load.kind=harmonic&load.mean=0.7&load.amplitude=1"


def followed(page: Page) -> str:
    """Until the branches of the present question are drawn, and the motion at a place of them; their labels."""
    page.wait_for_selector("#branches[data-branches][data-spot]")
    until(page, "document.querySelector('#branches-stage').dataset.label !== undefined")
    return page.locator("#branches").get_attribute("data-branches") or ""


def readout(page: Page) -> str:
    return page.locator("#branches-readout").inner_text().replace("\u202f", " ")


def at(page: Page, value: float, phase: float) -> tuple[float, float]:
    """Where a value and a phase are on the screen."""
    page.locator("#branches").scroll_into_view_if_needed()
    box = page.locator("#branches").bounding_box()
    assert box is not None
    frame = json.loads(page.locator("#branches").get_attribute("data-frame") or "")
    (left, right, low, high), (top, bottom, least, most) = frame["x"], frame["y"]
    x = left + (value - low) / (high - low) * (right - left)
    return box["x"] + x, box["y"] + bottom - (phase - least) / (most - least) * (bottom - top)


# -- the panel branches in a real browser ----------------------------------------------------------------------------


def test_branches_are_those_of_the_command_line(desk: Desk, capsys: pytest.CaptureFixture[str]) -> None:
    page = desk.open("panel=branches&bmodes=2&machine=mini-breaker&alongr=0.1:1")
    assert followed(page) == "z=1/1,z=2/2"
    asked = ["--along", "load_factor=0.1:1", "--modes", "2", "--switch", "1", "--json"]
    assert main(["follow", "mini-breaker", *asked]) == 0
    told: dict[str, Any] = json.loads(capsys.readouterr().out)
    rows = page.locator("#branches-events tbody tr")
    points = [(one["label"], point) for one in (told, *told["switched"]) for point in one["points"]]
    assert rows.count() == len(points)
    for i, (label, point) in enumerate(points):
        cells = rows.nth(i).locator("td").all_inner_texts()
        assert float(cells[0]) == pytest.approx(point["value"], rel=1e-6) and cells[1] == label
        assert rows.nth(i).get_attribute("data-event") == point["type"]
        assert cells[3] == point["beyond"].replace("load_factor", "load factor p₀/p₁")
    every = [kind.value for kind in BranchEvent]  # all have words but those on curves over two
    elsewhere = every[every.index("cusp") : every.index("period_halving")]
    assert set(knows(page, "branches/branches_picture.js:EVENTS")) >= {*every} - {*elsewhere}
    fold = next(point for _, point in points if point["type"] == "fold")
    page.click("tr[data-event=fold] button")
    expect(page.locator("#branches-readout")).to_contain_text(f"{fold['value']:.4f}"[:-1])
    until(page, f"Math.abs(document.querySelector('#branches-stage').dataset.value - {fold['value']}) < 1e-3")


def test_branches_of_a_machine_are_those_of_the_command_line(desk: Desk, capsys: pytest.CaptureFixture[str]) -> None:
    page = desk.open("panel=branches&machine=valve-breaker&bmodes=0&alongr=115:200&every=1/1&settled=1")
    assert followed(page) == "1/1"
    assert main(["follow", "valve-breaker", "--along", "load.pressure=115 bar:200 bar", "--modes", "0", "--json"]) == 0
    points = json.loads(capsys.readouterr().out)["points"]
    rows = page.locator("#branches-events > table tbody tr")
    assert rows.evaluate_all("all => all.map(row => row.dataset.event)") == [point["type"] for point in points]
    assert {"fold", "corner", "port_not_reached"} <= {point["type"] for point in points}
    expect(page.locator("#branches-facts")).to_contain_text("9.19\N{NARROW NO-BREAK SPACE}m/s")
    expect(page.locator("#branches-settled")).to_contain_text("runs 1/1")
    expect(page.locator("#branches-every")).to_have_text("Found: 1 branch.")
    assert page.locator("#branches").get_attribute("data-others") == "0"  # it is the branch that was followed
    page.select_option("#branches-up", "period")
    page.locator("#branches").press("End")
    expect(page.locator("#branches-readout")).to_contain_text("supply pressure = 199")
    page.click("#branches-carry")
    until(page, "document.querySelector('#branches-readout').textContent && location.hash.includes('199')")
    page.select_option("#branches-search", "1/1")
    page.locator("#branches-found button").click()
    until(page, "location.hash.includes('begin=1/1:1')")


@pytest.mark.parametrize("desk", PLAYING, indirect=True)
def test_a_place_is_clicked_dragged_and_stepped_along_and_its_motion_plays(desk: Desk) -> None:
    page = desk.open(f"panel=branches&{RIGID}&alongr=0.5:1.1&depth=1")
    assert followed(page) == "z=1/1,z=2/2"
    assert readout(page) == "z=1/1 at load factor p₀/p₁ = 0.7: stable."
    assert "spot=" not in page.url  # the place of the design is not one that was chosen
    page.mouse.move(*at(page, 0.9, 1.9))
    page.mouse.down()
    expect(page.locator("#branches-readout")).to_contain_text("z=1/1 at load factor p₀/p₁ = 0.")
    page.mouse.move(*at(page, 0.56, 2.5), steps=4)
    page.mouse.up()
    expect(page.locator("#branches-readout")).to_contain_text(re.compile(r"z=1/1 .* = 0\.[56]\d*: unstable\."))
    expect(page.locator("#branches-facts")).to_contain_text("unstable")
    page.keyboard.press("ArrowUp")
    expect(page.locator("#branches-readout")).to_contain_text("z=2/2")
    for _ in range(3):
        page.keyboard.press("ArrowRight")
    expect(page.locator("#branches-facts dd").first).to_have_text("z=2/2")
    before = int(page.locator("#branches-stage").get_attribute("data-blows") or 0)
    until(page, f"Number(document.querySelector('#branches-stage').dataset.blows) >= {before + 4}")
    words = readout(page)
    until(page, "location.hash.includes('spot=')")
    link = page.evaluate("location.hash.slice(1)")
    again = desk.open(link)
    followed(again)
    assert readout(again) == words


def test_the_slider_of_the_parameter_moves_the_design_and_the_branches_stay(desk: Desk) -> None:
    page = desk.open(f"panel=branches&{RIGID}&depth=0")
    followed(page)
    asked = lambda: sum(url.endswith("/api/follow") for url in desk.asked)  # noqa: E731
    assert asked() == 1
    slide(page, "load_factor", 0.8)
    until(page, "document.querySelector('#branches').dataset.design === '0.8'")
    expect(page.locator("#branches-readout")).to_contain_text("= 0.8:")  # no place was chosen: it follows the design
    settled(page)
    assert asked() == 1
    page.click("tr[data-event=flip] button")
    settled(page)  # what the button carries is the motion that is shown
    expect(page.locator("#branches-readout")).to_contain_text("0.65495")
    page.click("#branches-carry")
    until(page, "Math.abs(document.querySelector('#branches').dataset.design - 0.654954) < 1e-5")
    expect(page.locator("#slide-load_factor")).to_have_value(re.compile(r"0\.65"))
    slide(page, "restitution", 0.6)
    settled(page)
    assert "0.6549" not in page.locator("#branches-events").inner_text()
    assert asked() == 2


def test_other_motions_are_searched_and_followed(desk: Desk) -> None:
    page = desk.open(f"panel=branches&{RIGID.replace('0.7', '0.62')}&depth=0&up=speed")
    followed(page)
    page.select_option("#branches-search", "2/1")
    page.locator("#branches-found button").nth(1).click()
    until(page, "document.querySelector('#branches').dataset.branches === 'z=2/1'")
    assert "begin=2/1:2" in page.url
    expect(page.locator("#branches-events tbody tr")).to_have_count(4)  # impact dies, flip, fold, touch
    page.get_by_role("button", name="The head's motion").click()
    until(page, "document.querySelector('#branches').dataset.branches === 'z=1/1'")


def test_what_cannot_be_followed_is_said(desk: Desk, request: pytest.FixtureRequest) -> None:
    request.node.expected_words = ("422",)
    page = desk.open(f"panel=branches&{RIGID.replace('0.7', '3')}")
    expect(page.locator("#branches-status")).to_contain_text("There is no steady motion to begin with")
    page = desk.open(f"panel=branches&{RIGID}&begin=9/1:4&along=nothing&spot=x,y&alongr=-:e")
    expect(page.locator("#branches-status")).to_contain_text("orbits z=9/1")
    page.fill("#branches-from", "7")
    page.keyboard.press("Tab")
    expect(page.locator("#branches-range-problem")).to_contain_text("keeps the previous range")


# -- the diagram of the panel branches in a real browser -------------------------------------------------------------


ENDS = (
    BranchEvent.ONSET, BranchEvent.TOUCH, BranchEvent.DEATH, BranchEvent.RELEASE_LOST, BranchEvent.CHANGE,
    BranchEvent.NO_SYSTEM, BranchEvent.LIMIT, BranchEvent.STOPPED,
)  # fmt: skip

EVERY = """import('/static/branches/branches_every.js').then(({ others }) => others([]).map(({ label, points, rows }) =>
  ({ label, points: points.length, value: rows[3].value, time: rows[3].times[0] })))"""


def test_a_cycle_with_rest_is_found_followed_and_moves(desk: Desk) -> None:
    page = desk.open(f"panel=branches&{RIGID.replace('0.7', '0.8')}&alongr=0.6:0.9&depth=0")
    followed(page)
    page.select_option("#branches-search", "chatter/1")
    page.locator("#branches-found button").click()
    until(page, "document.querySelector('#branches').dataset.branches === 'chatter/1'")
    kinds = page.locator("#branches-events tbody tr").evaluate_all("rows => rows.map(row => row.dataset.event)")
    assert kinds == ["onset", "limit"] and "begin=chatter/1:1" in page.url
    assert float(page.locator("#branches-events tbody td").first.inner_text()) == pytest.approx(0.6260373, abs=1e-7)
    expect(page.locator("#panel-branches .legend")).to_contain_text("is let go")
    assert set(knows(page, "branches/branches_picture.js:EVENTS")) >= {kind.value for kind in ENDS}
    page.click("tr[data-event=onset] button")
    until(page, "Math.abs(document.querySelector('#branches-stage').dataset.value - 0.6260373) < 1e-2")
    expect(page.locator("#branches-facts")).to_contain_text("is let go at")
    page.locator("#branches").press("End")
    until(page, "document.querySelector('#branches-stage').dataset.value > 0.88")
    assert page.locator("#branches-stage").get_attribute("data-label") == "chatter/1"


def test_what_simulations_settle_on_is_drawn_below_the_branches(desk: Desk) -> None:
    page = desk.open(f"panel=branches&{RIGID}&alongr=0.68:0.72&depth=0")
    followed(page)
    assert not any(url.endswith("/api/diagram") for url in desk.asked)
    page.check("#branches-simulate")
    expect(page.locator("#branches-settled")).to_have_text(re.compile("^Found: .*z=1/1"))
    expect(page.locator("#panel-branches .legend")).to_contain_text("settled: z=1/1")
    until(page, "location.hash.includes('settled=1')")
    page.uncheck("#branches-simulate")
    expect(page.locator("#panel-branches .legend")).not_to_contain_text("settled")


def test_all_branches_are_drawn_and_each_can_be_looked_at(desk: Desk) -> None:
    page = desk.open(f"panel=branches&tall=1&{RIGID}&alongr=0.62:0.72&depth=0")
    followed(page)
    before = ink(page, "#branches")
    page.select_option("#branches-up-to", "2/2")
    expect(page.locator("#branches-every")).to_have_text(re.compile(r"^Found: \d+ branches\.$"))
    found = page.evaluate(EVERY)
    assert page.locator("#branches-every").inner_text() == f"Found: {len(found)} branches."
    every = int(page.locator("#branches").get_attribute("data-others") or 0)
    assert every == len(found) - 1 > 2  # the one that was followed is not told twice
    assert ink(page, "#branches") != before and "every=2/2" in page.url
    legend = page.locator("#panel-branches .legend")
    expect(legend).to_contain_text("z=2/1, stable")
    assert [one["points"] for one in found if one["label"] == "chatter/1"] == [2]
    expect(legend).to_contain_text("thin: not possible")
    page.click("#branches-more summary")
    expect(page.locator("#branches-more tbody tr")).to_have_count(sum(one["points"] for one in found) - 3)
    other = next(one for one in found if one["label"] == "z=2/1")
    page.mouse.click(*at(page, other["value"], other["time"] % math.tau))
    expect(page.locator("#branches-readout")).to_contain_text("z=2/1")
    until(page, "document.querySelector('#branches-stage').dataset.label === 'z=2/1'")
    page.set_viewport_size({"width": 1280, "height": 1800})  # its first impact is at the top, below the tabs
    page.evaluate("scrollTo(0, 0)")
    settled(page)
    other = next(one for one in found if one["label"] == "chatter/1")
    page.mouse.click(*at(page, other["value"], other["time"] % math.tau))
    until(page, "document.querySelector('#branches-stage').dataset.label === 'chatter/1'")
    until(page, "location.hash.includes('spot=')")
    slide(page, "load_factor", 0.71)  # along the diagram: everything stays
    settled(page)
    assert sum(url.endswith("/api/diagram") for url in desk.asked) == 1
    page.click("#tab-orbits")
    page.click("#tab-branches")
    page.select_option("#branches-up-to", "")
    until(page, "document.querySelector('#branches').dataset.others === '0'")


def test_a_diagram_ends_when_the_hammer_changes_and_when_the_panel_is_left(desk: Desk) -> None:
    page = desk.open(f"panel=branches&{RIGID}&depth=0&every=4/4&settled=1")
    followed(page)
    expect(page.locator("#branches-every")).to_contain_text("branches")
    slide(page, "restitution", 0.55)
    until(page, "document.querySelector('#branches-every-progress').hidden")
    until(page, "!document.querySelector('#branches-every-progress').hidden")  # anew, of the other hammer
    page.click("#tab-orbits")
    assert page.evaluate("document.querySelector('#branches-every-progress').hidden")
    assert page.evaluate("document.querySelector('#branches-settled-progress').hidden")
    page.click("#tab-branches")
    settled(page)
    late = held(page, "follow")  # what comes after the panel was left asks for nothing more
    slide(page, "restitution", 0.56)
    came(page, late)
    page.click("#tab-orbits")
    asked = sum(url.endswith("/api/diagram") for url in desk.asked)
    let_go(page, "follow", late)
    settled(page)
    assert sum(url.endswith("/api/diagram") for url in desk.asked) == asked
    assert page.evaluate("document.querySelector('#branches-every-progress').hidden")


def test_what_happens_to_a_motion_is_laid_over_the_map_as_curves(desk: Desk) -> None:
    plane = "x=restitution&y=load_factor&xr=0.495:0.505&yr=0.62:0.72&curves=1"
    page = desk.open(f"{plane}&{RIGID}")
    expect(page.locator("#map-followed")).to_contain_text("One curve, of a rigid bar")
    assert page.locator("#map-follow").get_attribute("data-found") == "flip"
    expect(page.locator("#map-place .legend")).to_contain_text("flip: period doubling, followed")
    (line,) = page.evaluate("import('/static/map/map_followed.js').then(m => m.followedItems({ name: 'restitution' }))")
    assert sorted((line["x"][0], line["x"][-1])) == pytest.approx([0.495, 0.505])
    page.click("#tab-case")
    settled(page)
    assert sum(url.endswith("/api/follow/curves") for url in desk.asked) == 1  # they are there already
    page.uncheck("#map-follow")
    expect(page.locator("#map-place .legend")).not_to_contain_text("followed")


# -- a structure that is held, on every panel of the workbench in a real browser -------------------------------------


BUDD_DUX = {
    "body": {"kind": "mounted", "spring": 2.8**-2, "gap": -0.1},
    "system": {"restitution": 0.8},
    "load": {"kind": "harmonic", "mean": 0.0, "amplitude": 2.8**-2},
}
"""r = 0.8, ω = 2.8, σ = -0.1 of Budd and Dux, whose motion doubles its period at σ = -0.06857565."""


def link(tables: Any) -> str:
    return urlencode({f"{table}.{key}": value for table, keys in tables.items() for key, value in keys.items()})


def test_every_panel_shows_a_structure_or_says_why_not(desk: Desk) -> None:
    page = desk.open(f"panel=branches&along=gap&alongr=-0.11:-0.06&{link(BUDD_DUX)}")
    assert followed(page) == "z=1/1,z=2/2"
    flip = page.locator("tr[data-event=flip] td").first
    assert float(flip.inner_text().replace("−", "-")) == pytest.approx(-0.06857565, abs=1e-8)
    expect(page.locator("#verdict")).to_have_text("Stable")
    slide(page, "gap", -0.065)
    expect(page.locator("#verdict")).to_have_text("Unstable")
    expect(page.locator("#tab-blow")).to_be_hidden()
    page.evaluate(f"{STATE}(state => state.show({{ panel: 'blow' }}))")  # as a link does
    expect(page.locator("#drawer")).to_be_hidden()
    expect(page.locator("#stage")).to_be_visible()
    page.click("#tab-orbits")
    expect(page.locator("#orbit-table")).to_be_hidden()  # of a bar
    until(page, "document.querySelector('#stage').dataset.change !== undefined")
    page.click("#tab-case")
    expect(page.locator("#field-body-gap")).to_have_value("-0.065")
    page.fill("#field-body-gap", "-0.1")
    expect(page.locator("#verdict")).to_have_text("Stable")
    page.select_option("#map-y", "gap")
    until(page, "document.querySelector('#map').dataset.coarse !== undefined")
    expect(page.locator("#map-place .legend")).to_contain_text("unstable")


def test_a_sample_is_picked_and_told_as_a_structure(desk: Desk) -> None:
    page = desk.open("panel=orbits&machine=mini-breaker")
    assert page.locator("#machine optgroup option").all_inner_texts() == [one.title for one in STRUCTURES]
    page.select_option("#machine", "stopped-beam")
    until(page, "document.querySelector('#stage').getAttribute('aria-label').startsWith('The structure')")
    expect(page.locator("#motion-details")).to_contain_text("4 modes. Space plays")
    for words in ("bar", "hammer", "elastic mode"):
        assert words not in page.locator("#motion-details").inner_text()
    expect(page.locator("#motion-instant")).to_be_hidden()
    page.click("#tab-branches")
    followed(page)
    expect(page.locator("#branches-carry")).to_have_text("Move the structure here")
    expect(page.locator("#panel-branches .row").first).to_contain_text("Modes, at most")
    expect(page.locator("#map-place")).not_to_contain_text("elastic")
