"""A report as one HTML file without scripts, which needs nothing beside it."""

from __future__ import annotations

from collections.abc import Iterable
from html import escape as escaped
from typing import TYPE_CHECKING

from percuss.plot.reports.report_pages import (
    Answer,
    Block,
    Bullets,
    Cards,
    Footer,
    Heading,
    Lead,
    Listing,
    Picture,
    Rows,
    Signed,
    report_blocks,
)
from percuss.short_repr import escape_control

if TYPE_CHECKING:
    from percuss.case import BlowAnswer, Case, SimulationAnswer

_STYLE = """
:root { color-scheme: light dark; --ink: #222; --paper: #fff; --soft: #f2f4f7; --line: #ccd; }
@media (prefers-color-scheme: dark) { :root { --ink: #eee; --paper: #16181d; --soft: #22262e; --line: #445; } }
body { font: 16px/1.5 system-ui, sans-serif; color: var(--ink); background: var(--paper); margin: 2rem auto;
  max-width: 60rem; padding: 0 1rem; }
h1 { margin-bottom: 0; }
.cards { display: grid; grid-template-columns: repeat(auto-fill, minmax(12rem, 1fr)); gap: .75rem; }
.card { background: var(--soft); border-radius: .5rem; padding: .6rem .8rem; hyphens: auto; overflow-wrap: anywhere; }
.card b { display: block; font-size: 1.4rem; }
table { border-collapse: collapse; width: 100%; font-variant-numeric: tabular-nums; } td, th { border-bottom: 1px solid
  var(--line); padding: .3rem .5rem; text-align: left; vertical-align: top; } .scroll { overflow-x: auto; }
figure { margin: 1.5rem 0; background: #fff; border-radius: .5rem; padding: .5rem; }
table:not(:has(thead)) td:first-child { white-space: nowrap; }
.outline { width: 100%; max-height: 10rem; margin: 1rem 0 0; } figure svg { width: 100%; height: auto; }
.signed span { display: inline-block; width: 14rem; border-bottom: 1px solid var(--ink); margin-right: 1rem; }
@media print { body { font-size: 9pt; line-height: 1.3; margin: 0; padding: 0; max-width: none; }
  h1 { font-size: 16pt; } h2 { font-size: 11pt; margin: .8rem 0 .2rem; } td, th { padding: .1rem .4rem; }
  .cards { gap: .4rem; grid-template-columns: repeat(auto-fill, minmax(9rem, 1fr)); }
  .card { padding: .2rem .5rem; } .card b { font-size: 11pt; } .signed { margin: .5rem 0 0; }
  ul { margin: .2rem 0; } .outline { margin: 0; max-height: 7rem; }
  @page { margin: 15mm; }
  tr, figure, .card { break-inside: avoid; } h1, h2, h3 { break-after: avoid; }
  .signed + :not(.signed, footer) { break-before: page; } figure { margin: 4mm 0 0; } figure svg { max-height: 200mm; }
  pre { white-space: pre-wrap; } .scroll { overflow: visible; } }
pre { background: var(--soft); border-radius: .5rem; padding: .8rem; overflow-x: auto; } footer { opacity: .7; }
"""


def report_html(
    case: Case,
    answer: Answer,
    simulation: SimulationAnswer | None = None,
    blow: BlowAnswer | None = None,
    language: str = "en",
) -> str:
    """The text of the file, in English, German ("de") or Swedish ("sv"); the first page is printed as such."""
    blocks = report_blocks(case, answer, simulation, blow, language)
    title = next(block.text for block in blocks if isinstance(block, Heading))
    body = "\n".join(map(_element, blocks))
    policy = "default-src 'none'; style-src 'unsafe-inline'; img-src data:"
    return f"""<!doctype html>
<html lang="{language}">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta http-equiv="Content-Security-Policy" content="{policy}">
<title>{_safe(title)}</title>
<style>{_STYLE}</style>
</head>
<body>
{body}
</body>
</html>
"""


def _element(block: Block) -> str:
    match block:
        case Heading(text, level):
            return f"<h{level}>{_safe(text)}</h{level}>"
        case Lead(text):
            return f"<p><strong>{_safe(text)}</strong></p>"
        case Rows(columns, rows):
            top = f"<thead>{_row(columns, 'th')}</thead>" if columns else ""
            body = "".join(_row(row, "td") for row in rows)
            return f'<div class="scroll"><table>{top}<tbody>{body}</tbody></table></div>'
        case Cards(cards):
            cells = [f'<div class="card">{_safe(label)}<b>{_safe(text)}</b></div>' for label, text in cards]
            return f'<div class="cards">{"".join(cells)}</div>'
        case Bullets(items):
            return f"<ul>{''.join(f'<li>{_safe(text)}</li>' for text in items)}</ul>"
        case Signed(text, name, hand):
            lines = " ".join(f"{_safe(one)} <span></span>" for one in (name, hand))
            return f'<p class="signed">{_safe(text)}</p>\n<p class="signed">{lines}</p>'
        case Picture(svg, caption):
            return (
                f"<figure>{svg}<figcaption>{_safe(caption)}</figcaption></figure>" if caption else f"<div>{svg}</div>"
            )
        case Listing(text):
            return f"<pre>{_safe(text)}</pre>"
        case Footer(text):
            return f"<footer>{_safe(text)}</footer>"


def _row(cells: Iterable[str], kind: str) -> str:
    return f"<tr>{''.join(f'<{kind}>{_safe(cell)}</{kind}>' for cell in cells)}</tr>"


def _safe(text: str) -> str:
    """Text of others: neither markup nor a character that steers what shows it."""
    return escaped(escape_control(text))
