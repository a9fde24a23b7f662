"""What the tests of the panel Branches share: a rigid bar, and where things are on the diagram."""

from __future__ import annotations

import json

from playwright.sync_api import Page

from web_desk import until

__all__ = ["RIGID", "STILL", "at", "followed", "readout"]

RIGID = "bmodes=0&system.s=5&system.d=0&system.restitution=0.5&load.kind=harmonic&load.mean=0.7&load.amplitude=1"
STILL = [{"reduced_motion": "reduce"}]


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
