"""The report: one HTML file with the figures in SI, the verdicts and the pictures; it needs nothing beside it."""

from __future__ import annotations

import re
import tempfile
from collections.abc import Iterable
from html import escape as escaped
from pathlib import Path
from typing import TYPE_CHECKING, Any

from percuss._version import __version__
from percuss.case.answers.blow_answer import BlowAnswer, blow_report
from percuss.case.answers.exploring.comparison import Comparison
from percuss.case.answers.exploring.design import DesignAnswer
from percuss.case.answers.exploring.identify import IdentifyAnswer
from percuss.case.answers.exploring.tolerance import ToleranceAnswer
from percuss.case.answers.facts import Grid, Report, ReportSection
from percuss.case.answers.machine_answer import MachineAnswer, machine_report
from percuss.case.answers.recorded_answer import RecordedAnswer, recorded_report
from percuss.case.answers.simulation_answer import motion_report
from percuss.case.answers.steady_answer import SteadyAnswer
from percuss.case.answers.steady_report import name_of, steady_report
from percuss.short_repr import escape_control
from percuss.steady.figures import CARDS, REPORTED

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from percuss.case import Case, SimulationAnswer

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


def report_html(case: Case, answer: Answer, simulation: SimulationAnswer | None = None) -> str:
    """A case, its steady motions or its cycle, and a simulated motion, as the text of one HTML file without scripts.

    A comparison, and a design, is told with all its cases.
    """
    from percuss import plot
    from percuss.plot.bar_outline import bar_outline

    report, picture, caption = _told(answer)
    parts = [f"<h1>{_safe(report.title)}</h1>", f"<p><strong>{_safe(report.summary)}</strong></p>"]
    if isinstance(answer, SteadyAnswer):
        parts.append(_cards(answer))
        if answer.system.is_si and case.tables.body is None:
            parts.append(f"<div>{bar_outline(answer.system)}</div>")
    parts += map(_part, report.sections)
    parts.append(_figure(picture, caption))
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


def _cards(answer: SteadyAnswer) -> str:
    chosen = answer.chosen
    if chosen is None or chosen.si is None or chosen.orbit.impact_velocity <= 0.0:
        return ""
    cells = [
        f'<div class="card">{_safe(figure.label)}<b>{getattr(chosen.si, key):.5g} {_safe(unit)}</b></div>'
        for key, (figure, _, unit) in ((key, REPORTED[key]) for key in CARDS)
        if getattr(chosen.si, key) is not None
    ]
    whose = f"{name_of(answer, chosen)}{'' if chosen.runs else ', which cannot be sustained'}"
    return f'<p>Figures of {_safe(whose)}:</p><div class="cards">{"".join(cells)}</div>'


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
