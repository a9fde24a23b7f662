"""A report as one PDF, on A4 or Letter, set by typst: what HTML is written from, laid out in pages."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

from percuss.errors import extra_package
from percuss.model.checks import choice
from percuss.plot.reports.report_pages import Answer, Block, report_blocks
from percuss.short_repr import escape_control

if TYPE_CHECKING:
    from percuss.case import BlowAnswer, Case, SimulationAnswer

PAPERS = {"a4": "a4", "letter": "us-letter"}
"""Papers, and what typst calls them."""

_PAGES = """
#let blocks = json("blocks.json")
#let soft = rgb("f2f4f7")
#let line = 0.4pt + rgb("ccccdd")
#let title = blocks.at(0).text

// A long word, such as a key of a case, may be broken behind its points and slashes.
#let cell(it) = {
  show regex("\\S{16,}"): word => word.text.replace(regex("[./_\\])]"), found => found.text + sym.zws)
  it
}

#let heading(b) = std.heading(level: b.level, b.text)
#let lead(b) = block(strong(b.text))
#let cards(b) = std.grid(
  columns: (1fr,) * 4, gutter: 5pt,
  ..b.cards.map(((label, value)) => block(
    fill: soft, radius: 3pt, inset: 5pt, width: 100%, height: 27pt,
    text(7pt, label) + linebreak() + strong(text(10.5pt, value)))),
)
#let bullets(b) = list(..b.items)
#let signed(b) = {
  block(b.text, above: 1.6em)
  block[#b.name #box(width: 5cm, stroke: (bottom: line), height: 1em) #h(1em)
    #b.hand #box(width: 5cm, stroke: (bottom: line), height: 1em)]
}
#let rows(b) = if b.rows.len() > 0 {
  let wide = calc.max(..b.rows.map(row => row.len()))
  std.table(
    columns: if b.columns.len() == 0 { (auto,) * (wide - 1) + (1fr,) } else { (auto,) * wide },
    stroke: (x, y) => (bottom: line), inset: (x: 4pt, y: 2.6pt), align: left + top,
    ..if b.columns.len() > 0 {
      (std.table.header(..b.columns.map(name => strong(text(hyphenate: true, cell(name))))),)
    },
    ..b.rows.flatten().map(cell),
  )
}
#let picture(b) = block(breakable: false, above: 1.2em, layout(size => {
  let drawn = image(bytes(b.svg), width: 100%, alt: b.caption)
  let room = size.height - 80pt  // for a heading and the first sentences above
  let fits = measure(drawn, width: size.width).height <= room
  if fits { drawn } else { align(center, image(bytes(b.svg), height: room, alt: b.caption)) }
  if b.caption != "" { block(above: 5pt, text(7.5pt, b.caption)) }
}))
#let listing(b) = block(fill: soft, radius: 3pt, inset: 6pt, width: 100%, text(7.5pt, raw(b.text, block: true)))
#let footer(b) = text(7pt, luma(40%), b.text)

#set document(title: title, date: none)
#set page(
  paper: sys.inputs.paper, margin: (x: 15mm, top: 14mm, bottom: 16mm),
  footer: context text(7pt, luma(40%), grid(
    columns: (1fr, auto), title, counter(page).display("1 / 1", both: true))),
)
#set text(font: "DejaVu Sans", size: 8pt, lang: sys.inputs.language)
#set par(leading: 0.5em)
#show raw: set text(font: "DejaVu Sans Mono")
#show std.heading: set block(above: 1.1em, below: 0.6em)
#show std.heading.where(level: 1): set text(15pt)
#show std.heading.where(level: 2): set text(10pt)
#show std.heading.where(level: 3): set text(8.5pt)
#let told = (heading: heading, lead: lead, cards: cards, bullets: bullets, signed: signed, rows: rows,
  picture: picture, listing: listing, footer: footer)
#for (i, b) in blocks.enumerate() {
  if i > 0 and b.kind != "footer" and blocks.at(i - 1).kind == "signed" { pagebreak() }
  (told.at(b.kind))(b)
}
"""


def report_pdf(
    case: Case,
    answer: Answer,
    simulation: SimulationAnswer | None = None,
    blow: BlowAnswer | None = None,
    paper: str = "a4",
    language: str = "en",
) -> bytes:
    """The content of the file; `paper` is "a4" or "letter". Letters are those of the pictures, which matplotlib has."""
    typst = extra_package("typst", "report")
    choice("paper", paper, *PAPERS)
    from matplotlib import get_data_path

    blocks = [_plain(block) for block in report_blocks(case, answer, simulation, blow, language)]
    files = {"main.typ": _PAGES.encode(), "blocks.json": json.dumps(blocks).encode()}
    fonts = [Path(get_data_path(), "fonts", "ttf")]
    inputs = {"paper": PAPERS[paper], "language": language}
    made: bytes = typst.compile(files, font_paths=fonts, sys_inputs=inputs)
    return made


def _plain(block: Block) -> dict[str, Any]:
    """A block as JSON, by its kind."""
    fields = {name: value if name == "svg" else _harmless(value) for name, value in block._asdict().items()}
    return {"kind": type(block).__name__.lower(), **fields}


def _harmless(value: Any) -> Any:
    """Text of others without characters that steer what shows it."""
    if isinstance(value, str):
        return escape_control(value)
    return value if isinstance(value, int) else [_harmless(one) for one in value]
