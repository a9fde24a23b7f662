"""``percuss report`` as a person prints it: the first page on one sheet, nothing cut or on top of something else."""

from __future__ import annotations

import json
import re
from html import unescape
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from percuss.cli.app import run

if TYPE_CHECKING:
    from playwright.sync_api import Browser

PAPERS = {"A4": (680, 1009), "Letter": (703, 941)}  # px within margins of 15 mm
PUMP = """
[load.supply]
flow = "130 l/min"
accumulator = "2.5 cm^3/bar"
"""

BOXES = """() => {
  const wide = document.body.clientWidth, boxes = [];
  const walk = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  while (walk.nextNode()) {
    const node = walk.currentNode, holder = node.parentElement;
    if (!node.data.trim() || holder.closest("figure, title, style")) continue;
    const range = document.createRange();
    range.selectNodeContents(node);
    for (const box of range.getClientRects()) boxes.push([node.data, box.left, box.right, box.top, box.bottom]);
  }
  return {wide, boxes, signed: [...document.querySelectorAll(".signed")].at(-1).getBoundingClientRect().bottom};
}"""


@pytest.mark.parametrize(
    ("machine", "language"), [("valve-drifter", "en"), ("stepped-drifter", "en"), ("pump", "en"), ("pump", "de")]
)
def test_the_report_fits_on_paper(
    machine: str, language: str, browser: Browser, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    case, path = tmp_path / "case.toml", tmp_path / "report.html"
    name = machine if machine != "pump" else "valve-breaker"
    assert run(["new", name, "-o", str(case)]) == 0
    text = case.read_text(encoding="utf-8")
    given = re.sub(r"(?m)^restitution = (\S+)", r'restitution = "\1 ± 0.02"', text)
    assert given != text
    case.write_text(given + (PUMP if machine == "pump" else ""), encoding="utf-8")
    assert run(["report", str(case), "--modes", "0", "-o", str(path), "--no-reach", "--language", language]) == 0
    capsys.readouterr()
    page = browser.new_page()
    page.emulate_media(media="print")
    for wide, high in PAPERS.values():
        page.set_viewport_size({"width": wide, "height": high})
        page.goto(path.as_uri())
        found = page.evaluate(BOXES)
        boxes = found["boxes"]
        assert found["signed"] < high and len(boxes) > 50
        assert [words for words, left, right, *_ in boxes if left < -0.5 or right > found["wide"] + 0.5] == []
        first = [box for box in boxes if box[4] <= found["signed"]]
        for i, (words, left, right, top, bottom) in enumerate(first):
            for other, low, end, above, below in first[:i]:
                over = min(right, end) - max(left, low) > 1.0 and min(bottom, below) - max(top, above) > 4.0
                assert not over, (words, other)
    page.close()
    told = unescape(path.read_text(encoding="utf-8"))
    if language != "en":
        assert "Maßgebend:" in told and "Governs" not in told
        return
    assert run(["steady", str(case), "--modes", "0", "--json"]) == 0
    answer = json.loads(capsys.readouterr().out)
    energy = next(one for one in answer["uncertainty"]["figures"] if one["name"] == "blow_energy")
    card = re.search(r"blow energy<b>([\d.]+) ± ([\d.]+) (k?)J</b>", told)
    assert card is not None
    scale = 1e3 if card[3] else 1.0
    assert float(card[1]) * scale == pytest.approx(energy["value"], abs=energy["half"] * 0.05)
    assert float(card[2]) * scale == pytest.approx(energy["half"], rel=0.05)
    assert "Governs:" in told and "What one-dimensional waves leave out" in told
