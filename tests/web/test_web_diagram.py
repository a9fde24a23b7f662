"""The diagram of the panel Branches in a real browser: cycles with rest, all branches, what simulations settle on."""

from __future__ import annotations

import math
import re

import pytest

pytest.importorskip("fastapi")

from playwright.sync_api import expect

from branches_desk import RIGID, STILL, at, followed
from percuss.explore import BranchEvent
from percuss.model import Load, System
from percuss.stability import waveform_criterion
from percuss.steady import steady_states
from web_desk import Desk, ink, knows, settled, slide, until

pytestmark = pytest.mark.browser

ENDS = (
    BranchEvent.ONSET, BranchEvent.TOUCH, BranchEvent.DEATH, BranchEvent.RELEASE_LOST, BranchEvent.CHANGE,
    BranchEvent.NO_SYSTEM, BranchEvent.LIMIT, BranchEvent.STOPPED,
)  # fmt: skip

EVERY = """import('/static/branches_every.js').then(({ others }) => others([]).map(({ label, points, rows }) =>
  ({ label, points: points.length, value: rows[3].value, time: rows[3].times[0] })))"""


@pytest.mark.parametrize("desk", STILL, indirect=True)
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
    assert set(knows(page, "branches_picture.js:EVENTS")) >= {kind.value for kind in ENDS}
    page.click("tr[data-event=onset] button")
    until(page, "Math.abs(document.querySelector('#branches-stage').dataset.value - 0.6260373) < 1e-2")
    expect(page.locator("#branches-facts")).to_contain_text("is let go at")
    page.locator("#branches").press("End")
    until(page, "document.querySelector('#branches-stage').dataset.value > 0.88")
    assert page.locator("#branches-stage").get_attribute("data-label") == "chatter/1"


@pytest.mark.parametrize("desk", STILL, indirect=True)
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


@pytest.mark.parametrize("desk", STILL, indirect=True)
def test_all_branches_are_drawn_and_each_can_be_looked_at(desk: Desk) -> None:
    page = desk.open(f"panel=branches&{RIGID}&alongr=0.62:0.72&depth=0")
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


@pytest.mark.parametrize("desk", STILL, indirect=True)
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


def beside_the_flip(restitution: float, load_factor: float) -> float:
    """How far the load at the impact is from what it is where the rigid z=1/1 doubles its period, in closed form."""
    system = System(s=5.0, d=0.0, restitution=restitution, load=Load.harmonic(load_factor, 1.0))
    found = [waveform_criterion(orbit) for orbit in steady_states(system, 1).orbits]
    return min(abs(one.ratio - one.lower) for one in found)


@pytest.mark.parametrize("desk", STILL, indirect=True)
def test_what_happens_to_a_motion_is_laid_over_the_map_as_curves(desk: Desk) -> None:
    plane = "panel=map&x=restitution&y=load_factor&xr=0.495:0.505&yr=0.62:0.72&curves=1"
    page = desk.open(f"{plane}&{RIGID}")
    expect(page.locator("#map-followed")).to_contain_text("One curve, of a rigid bar")
    assert page.locator("#map-follow").get_attribute("data-found") == "flip"
    expect(page.locator("#panel-map .legend")).to_contain_text("flip: period doubling, followed")
    (line,) = page.evaluate("import('/static/map_followed.js').then(m => m.followedItems({ name: 'restitution' }))")
    assert sorted((line["x"][0], line["x"][-1])) == pytest.approx([0.495, 0.505])
    assert all(beside_the_flip(x, y) < 1e-8 for x, y in zip(line["x"], line["y"], strict=True))
    page.click("#tab-case")
    page.click("#tab-map")
    assert sum(url.endswith("/api/follow/curves") for url in desk.asked) == 1  # they are there already
    page.uncheck("#map-follow")
    expect(page.locator("#panel-map .legend")).not_to_contain_text("followed")
