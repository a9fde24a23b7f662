"""The report: one HTML file with the figures in SI, the verdicts and the pictures; it needs nothing beside it."""

from __future__ import annotations

import math
import re
import tempfile
from collections.abc import Iterable, Sequence
from datetime import date
from html import escape as escaped
from pathlib import Path
from typing import TYPE_CHECKING, Any

from percuss._version import __version__
from percuss.blow import Rod
from percuss.case.answers.blow_answer import BlowAnswer, blow_report
from percuss.case.answers.exploring.comparison import Comparison
from percuss.case.answers.exploring.design import DesignAnswer
from percuss.case.answers.exploring.identify import IdentifyAnswer
from percuss.case.answers.exploring.tolerance import ToleranceAnswer
from percuss.case.answers.facts import Grid, Report, ReportSection, number
from percuss.case.answers.machine_answer import MachineAnswer, machine_report
from percuss.case.answers.recorded_answer import RecordedAnswer, recorded_report
from percuss.case.answers.simulation_answer import motion_report
from percuss.case.answers.steady_answer import SteadyAnswer
from percuss.case.answers.steady_report import steady_report
from percuss.case.answers.transfer import ASSUMED
from percuss.case.answers.whole_hammer import HEADLINE, WHOLE_FIGURES
from percuss.plot.bar_outline import bar_outline
from percuss.short_repr import escape_control

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from percuss.case import Case, SimulationAnswer
    from percuss.model.body.uniform import Piece

_STYLE = """
:root { color-scheme: light dark; --ink: #222; --paper: #fff; --soft: #f2f4f7; --line: #ccd; }
@media (prefers-color-scheme: dark) { :root { --ink: #eee; --paper: #16181d; --soft: #22262e; --line: #445; } }
body { font: 16px/1.5 system-ui, sans-serif; color: var(--ink); background: var(--paper); margin: 2rem auto;
  max-width: 60rem; padding: 0 1rem; }
h1 { margin-bottom: 0; }
.cards { display: grid; grid-template-columns: repeat(auto-fill, minmax(9rem, 1fr)); gap: .75rem; }
.card { background: var(--soft); border-radius: .5rem; padding: .6rem .8rem; }
.card b { display: block; font-size: 1.4rem; }
table { border-collapse: collapse; width: 100%; font-variant-numeric: tabular-nums; } td, th { border-bottom: 1px solid
  var(--line); padding: .3rem .5rem; text-align: left; vertical-align: top; } .scroll { overflow-x: auto; }
figure { margin: 1.5rem 0; background: #fff; border-radius: .5rem; padding: .5rem; }
.outline { width: 100%; max-height: 10rem; margin: 1rem 0 0; } figure svg { width: 100%; height: auto; }
.signed span { display: inline-block; width: 14rem; border-bottom: 1px solid var(--ink); margin-right: 1rem; }
@media print { body { font-size: 9pt; line-height: 1.3; margin: 0; padding: 0; max-width: none; }
  h1 { font-size: 16pt; } h2 { font-size: 11pt; margin: .8rem 0 .2rem; } td, th { padding: .1rem .4rem; }
  .cards { gap: .4rem; } .card { padding: .2rem .5rem; } .card b { font-size: 11pt; } .signed { margin: .5rem 0 0; }
  ul { margin: .2rem 0; } .outline { margin: 0; max-height: 7rem; }
  @page { margin: 15mm; }
  tr, figure, .card { break-inside: avoid; } h1, h2, h3 { break-after: avoid; } .signed + figure { break-before: page; }
  pre { white-space: pre-wrap; } .scroll { overflow: visible; } }
pre { background: var(--soft); border-radius: .5rem; padding: .8rem; overflow-x: auto; } footer { opacity: .7; }
"""


Answer = (
    SteadyAnswer
    | MachineAnswer
    | RecordedAnswer
    | Comparison
    | BlowAnswer
    | DesignAnswer
    | ToleranceAnswer
    | IdentifyAnswer
)


_SIGNED = """<p class="signed">{date}, percuss {version}</p>
<p class="signed">Name: <span></span> Signature: <span></span></p>"""


def report_html(
    case: Case, answer: Answer, simulation: SimulationAnswer | None = None, blow: BlowAnswer | None = None
) -> str:
    """A case, its steady motions or its cycle, its blow, and a simulated motion, as one HTML file without scripts.

    The first page of one hammer has the answer, a drawing to scale, the few figures that matter, what was assumed, and
    a place to sign; it is printed as such. A comparison, and a design, is told with all its cases.
    """
    from percuss import plot

    report, picture, caption = _told(answer)
    parts = [f"<h1>{_safe(report.title)}</h1>", f"<p><strong>{_safe(report.summary)}</strong></p>"]
    if isinstance(answer, SteadyAnswer | MachineAnswer):
        parts += [*_first_page(case, answer), _SIGNED.format(date=date.today().isoformat(), version=_safe(__version__))]
    parts.append(_figure(picture, caption))
    if blow is not None:
        struck = blow_report(blow)
        parts += ["<h2>The blow</h2>", f"<p><strong>{_safe(struck.summary)}</strong></p>"]
        parts += [_figure(plot.blow(blow), "The blow"), *map(_part, struck.sections)]
    parts += map(_part, report.sections)
    if simulation is not None:
        moved = motion_report(simulation, 0)
        parts += ["<h2>Simulated motion</h2>", f"<p><strong>{_safe(moved.summary)}</strong></p>"]
        parts += map(_part, moved.sections[1:])
        drawn = plot.trajectory if simulation.motion.is_clocked else plot.machine_motion
        parts.append(_figure(drawn(simulation), "The motion from the start of the case"))
    both = answer.comparison if isinstance(answer, DesignAnswer) else answer
    several = zip(both.names, both.cases, strict=True) if isinstance(both, Comparison) else ()
    for heading, told in [(f"Case {name}", one) for name, one in several] or [("Case", case)]:
        parts += [f"<h2>{_safe(heading)}</h2>", f"<pre>{_safe(told.to_toml())}</pre>"]
    parts.append(f"<footer>percuss {_safe(__version__)}; numbers without a unit are dimensionless</footer>")
    body = "\n".join(parts)
    policy = "default-src 'none'; style-src 'unsafe-inline'; img-src data:"
    return f"""<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta http-equiv="Content-Security-Policy" content="{policy}">
<title>{_safe(report.title)}</title>
<style>{_STYLE}</style>
</head>
<body>
{body}
</body>
</html>
"""


def _told(answer: Answer) -> tuple[Report, Figure, str]:
    """What an answer says, its picture, and what that shows."""
    from percuss import plot

    if isinstance(answer, SteadyAnswer):
        return steady_report(answer), plot.steady(answer), "Phases, load, gap, multipliers"
    if isinstance(answer, Comparison):
        return answer.report(), plot.comparison(answer), "Cycles and blows"
    if isinstance(answer, ToleranceAnswer):
        return answer.report(), plot.tolerance(answer), "What dominates, and the figures of all hammers drawn"
    if isinstance(answer, IdentifyAnswer):
        return answer.report(), plot.identify(answer), "The blows that were measured, and those of the hammer that fits"
    if isinstance(answer, DesignAnswer):
        return answer.report(), plot.comparison(answer.comparison), "Cycles and blows, A the case, B the best"
    if isinstance(answer, BlowAnswer):
        return blow_report(answer), plot.blow(answer), "The blow"
    if isinstance(answer, RecordedAnswer):
        return recorded_report(answer), plot.machine(answer.answer), "The cycle of the machine that was read"
    return machine_report(answer), plot.machine(answer), "The cycle"


# ---- The first page of a report on one hammer: the answer, a drawing, the few figures that matter, what was assumed


def _first_page(case: Case, answer: SteadyAnswer | MachineAnswer) -> list[str]:
    whole, given = answer.whole, answer.uncertainty
    parts = []
    hammer = answer.system if isinstance(answer, SteadyAnswer) else answer.machine
    if case.is_si and hammer.bar is not None and case.tables.body is None:
        rod = None if whole.tool is None else whole.tool.target
        tool = rod.pieces if isinstance(rod, Rod) and rod.impedance is None else ()
        parts += [f"<div>{bar_outline(hammer, tool)}</div>", _table(_SIZES, _sizes(hammer.bar.pieces, tool))]
    cells = []
    for name in HEADLINE:
        value = None if name == "stress" and answer.transfer is not None else whole.value(name)  # then told by bodies
        if value is not None and case.is_si and case.tables.body is None and answer.whole.value("impact_velocity"):
            figure = WHOLE_FIGURES[name]
            told = (given and given.told(name)) or figure.tell(value, case.is_si, 3)
            cells.append(f'<div class="card">{_safe(figure.label)}<b>{_safe(told)}</b></div>')
    if cells:
        which = "" if whole.runs else " (in a motion that cannot be sustained)"
        parts.append(f'<h2>Figures{which}</h2><div class="cards">{"".join(cells)}</div>')
    if answer.reach:
        parts += ["<h2>It runs within</h2>", _table((), [(row.label, row.words) for row in answer.reach])]
    said = "".join(f"<li>{_safe(text)}</li>" for text in _assumed(answer))
    parts.append(f"<h2>Assumed</h2><ul>{said}</ul>")
    return parts


_SIZES = ("section", "length [mm]", "diameter [mm]", "bore [mm]")


def _sizes(bar: Sequence[Piece], tool: Sequence[Piece]) -> list[tuple[str, ...]]:
    rows: list[tuple[str, ...]] = []
    for body, pieces in (("bar", bar), ("tool", tool)):
        for i, piece in enumerate(pieces):
            long = "endless" if math.isinf(piece.end) else number(1e3 * (piece.end - piece.start))
            bore = number(1e3 * piece.bore) if piece.bore else "–"
            rows.append((f"{body} {i}", long, number(1e3 * piece.diameter), bore))
    return rows


def _assumed(answer: SteadyAnswer | MachineAnswer) -> list[str]:
    """What the figures stand on, one sentence each."""
    found = [*answer.told_notes] if isinstance(answer, SteadyAnswer) else [*answer.notes, *answer.warnings]
    if isinstance(answer, SteadyAnswer) and not answer.system.body.is_free:
        return [*found, "a structure that moves by its modes, and touches at one place"]
    rigid = getattr(answer.whole.motion, "modes", None) == 0
    found.append("a rigid piston" if rigid else "waves in the piston, by its elastic modes")
    found.append("a bar that stays straight and centred, and faces that meet flat")
    if answer.transfer is not None:
        found.append(ASSUMED)
    return found


def _part(part: ReportSection | Grid) -> str:
    """A section of a report as a heading and a table."""
    if isinstance(part, Grid):
        return f"<h2>{_safe(part.heading)}</h2>{_table(part.columns, part.rows)}"
    return f"<h{part.level + 1}>{_safe(part.heading)}</h{part.level + 1}>{_table((), part.rows)}"


def _table(head: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    names = "".join(f"<th>{_safe(name)}</th>" for name in head)
    top = f"<thead><tr>{names}</tr></thead>" if names else ""
    body = "".join(f"<tr>{''.join(f'<td>{_safe(cell)}</td>' for cell in row)}</tr>" for row in rows)
    return f'<div class="scroll"><table>{top}<tbody>{body}</tbody></table></div>'


def _figure(figure: Any, caption: str) -> str:
    from percuss import plot

    with tempfile.TemporaryDirectory(prefix="percuss-") as folder:
        path = Path(folder, "figure.svg")
        plot.save(figure, path)
        svg = path.read_text(encoding="utf-8")
    svg = svg[svg.index("<svg") :]
    svg = re.sub(r"<metadata>.*?</metadata>", "", svg, count=1, flags=re.DOTALL)
    return f"<figure>{svg}<figcaption>{_safe(caption)}</figcaption></figure>"


def _safe(text: str) -> str:
    """Text of others: neither markup nor a character that steers what shows it."""
    return escaped(escape_control(text))
