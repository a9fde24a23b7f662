"""The panel Branches in a real browser: what is followed, what happens on it, and the motion at every place."""

from __future__ import annotations

import json
import re
from typing import Any

import pytest

pytest.importorskip("fastapi")

from playwright.sync_api import expect

from branches_desk import RIGID, STILL, at, followed, readout
from percuss.cli import main
from percuss.explore import BranchEvent
from web_desk import Desk, knows, settled, slide, until

pytestmark = pytest.mark.browser


@pytest.mark.parametrize("desk", STILL, indirect=True)
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
    assert set(knows(page, "branches_picture.js:EVENTS")) >= {kind.value for kind in BranchEvent}  # all have words
    fold = next(point for _, point in points if point["type"] == "fold")
    page.click("tr[data-event=fold] button")
    expect(page.locator("#branches-readout")).to_contain_text(f"{fold['value']:.4f}"[:-1])
    until(page, f"Math.abs(document.querySelector('#branches-stage').dataset.value - {fold['value']}) < 1e-3")


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


@pytest.mark.parametrize("desk", STILL, indirect=True)
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


@pytest.mark.parametrize("desk", STILL, indirect=True)
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
    page = desk.open("panel=branches&machine=valve-breaker")
    expect(page.locator("#panel-branches .own")).to_contain_text("this machine has no clock")
