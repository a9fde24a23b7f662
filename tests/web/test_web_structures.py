"""A structure that is held, on every panel of the workbench in a real browser."""

from __future__ import annotations

import re
from typing import Any
from urllib.parse import urlencode

import pytest

pytest.importorskip("fastapi")

from playwright.sync_api import expect

from branches_desk import STILL, followed
from percuss.case.catalogue.sample_cases import STRUCTURES
from web_desk import Desk, slide, until

BUDD_DUX = {
    "body": {"kind": "mounted", "spring": 2.8**-2, "gap": -0.1},
    "system": {"restitution": 0.8},
    "load": {"kind": "harmonic", "mean": 0.0, "amplitude": 2.8**-2},
}
"""r = 0.8, ω = 2.8, σ = -0.1 of Budd and Dux, whose motion doubles its period at σ = -0.06857565."""


def link(tables: Any) -> str:
    return urlencode({f"{table}.{key}": value for table, keys in tables.items() for key, value in keys.items()})


@pytest.mark.browser
@pytest.mark.parametrize("desk", STILL, indirect=True)
def test_every_panel_shows_a_structure_or_says_why_not(desk: Desk) -> None:
    page = desk.open(f"panel=branches&along=gap&alongr=-0.11:-0.06&{link(BUDD_DUX)}")
    assert followed(page) == "z=1/1,z=2/2"
    flip = page.locator("tr[data-event=flip] td").first
    assert float(flip.inner_text().replace("−", "-")) == pytest.approx(-0.06857565, abs=1e-8)
    expect(page.locator("#verdict")).to_have_text("Stable")
    slide(page, "gap", -0.065)
    expect(page.locator("#verdict")).to_have_text("Unstable")
    for name in ("orbits", "blow", "report"):
        page.click(f"#tab-{name}")
        note = page.locator(f"#panel-{name} .own:not([hidden])")
        expect(note).to_contain_text(re.compile("structure.* Open the panel Branches"))
    page.click("#tab-motion")
    until(page, "document.querySelector('#stage').dataset.change !== undefined")
    page.click("#tab-case")
    expect(page.locator("#field-body-gap")).to_have_value("-0.065")
    page.fill("#field-body-gap", "-0.1")
    expect(page.locator("#verdict")).to_have_text("Stable")
    page.click("#tab-map")
    page.select_option("#map-y", "gap")
    until(page, "document.querySelector('#map').dataset.coarse !== undefined")
    expect(page.locator("#panel-map .legend")).to_contain_text("unstable")


@pytest.mark.browser
@pytest.mark.parametrize("desk", STILL, indirect=True)
def test_a_sample_is_picked_and_told_as_a_structure(desk: Desk) -> None:
    page = desk.open("panel=motion&machine=mini-breaker")
    assert page.locator("#machine optgroup option").all_inner_texts() == [one.title for one in STRUCTURES]
    page.select_option("#machine", "stopped-beam")
    until(page, "document.querySelector('#stage').getAttribute('aria-label').startsWith('The structure')")
    expect(page.locator("#panel-motion")).to_contain_text("4 modes. Space plays")
    for words in ("bar", "hammer", "elastic mode"):
        assert words not in page.locator("#panel-motion").inner_text()
    expect(page.locator("#motion-instant")).to_be_hidden()
    page.click("#tab-branches")
    followed(page)
    expect(page.locator("#branches-carry")).to_have_text("Move the structure here")
    expect(page.locator("#panel-branches .row").first).to_contain_text("Modes, at most")
    page.click("#tab-map")
    expect(page.locator("#panel-map")).not_to_contain_text("elastic")
