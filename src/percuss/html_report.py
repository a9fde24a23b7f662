"""The report: one HTML file with the figures in SI, the verdicts and the pictures; it needs nothing beside it."""

from __future__ import annotations

import re
import tempfile
from collections.abc import Iterable
from html import escape as escaped
from pathlib import Path
from typing import TYPE_CHECKING, Any

from percuss._version import __version__
from percuss.case.answers.reach_in_words import reach_in_words
from percuss.case.answers.sentences import ENDED, law_in_words, name_of, orbit_in_words, summary_of, timed_in_words
from percuss.neutral import neutral
from percuss.steady.figures import CARDS, REPORTED

if TYPE_CHECKING:
    from percuss.case import Case, OrbitAnswer, SimulationAnswer, SteadyAnswer

__all__ = ["report_html"]

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


def report_html(case: Case, answer: SteadyAnswer, simulation: SimulationAnswer | None = None) -> str:
    """A report on a case, as the text of one HTML file without scripts.

    Parameters
    ----------
    case
        What was asked about; its text is at the end of the report.
    answer
        Its steady motions.
    simulation
        A simulated motion, when one is wanted.

    Raises
    ------
    MissingExtraError
        When matplotlib is not installed.
    """
    from percuss import plot
    from percuss.plot.bar_outline import bar_outline

    parts = [f"<h1>{_safe(answer.title)}</h1>", _summary(answer), _cards(answer)]
    if answer.system.is_si:
        parts.append(f"<div>{bar_outline(answer.system)}</div>")
    parts += [
        _laws(answer),
        _notes(answer),
        "<h2>Steady motions</h2>",
        _orbits(answer),
        _timed(answer),
        _figure(plot.steady(answer), "Phases, load, gap, multipliers"),
    ]
    if answer.reach is not None:
        parts += ["<h2>How far parameters may move</h2>", _reach(answer)]
    if answer.starts.followed:
        parts += ["<h2>Random starts</h2>", _starts(answer)]
    if simulation is not None:
        parts += ["<h2>Simulated motion</h2>", _simulated(simulation)]
        parts.append(_figure(plot.trajectory(simulation), "The motion from the start of the case"))
    parts += ["<h2>Case</h2>", f"<pre>{_safe(case.to_toml())}</pre>"]
    parts.append(f"<footer>percuss {_safe(__version__)}; numbers without a unit are dimensionless</footer>")
    body = "\n".join(parts)
    policy = "default-src 'none'; style-src 'unsafe-inline'; img-src data:"
    return f"""<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta http-equiv="Content-Security-Policy" content="{policy}">
<title>{_safe(answer.title)}</title>
<style>{_STYLE}</style>
</head>
<body>
{body}
</body>
</html>
"""


def _summary(answer: SteadyAnswer) -> str:
    """The first lines of `percuss steady`, word for word."""
    told = summary_of(answer)
    return f"<p><strong>{_safe(told.headline)}</strong> {_safe(told.more)}</p>"


def _cards(answer: SteadyAnswer) -> str:
    chosen = answer.chosen
    if chosen is None or chosen.si is None or chosen.orbit.impact_velocity <= 0.0:
        return ""
    cells = [
        f'<div class="card">{_safe(figure.label)}<b>{_text(getattr(chosen.si, key))} {_safe(unit)}</b></div>'
        for key, (figure, _, unit) in ((key, REPORTED[key]) for key in CARDS)
        if getattr(chosen.si, key) is not None
    ]
    whose = f"{name_of(answer, chosen)}{'' if chosen.runs else ', which cannot be sustained'}"
    return f'<p>Figures of {_safe(whose)}:</p><div class="cards">{"".join(cells)}</div>'


def _orbits(answer: SteadyAnswer) -> str:
    rows = [
        (
            name_of(answer, found),
            _text(found.orbit.phase),
            _striking(found),
            "yes" if found.orbit.admissible else "no",
            "yes" if found.stability.stable else "no",
            _text(found.stability.margin_rhythm),
            _text(found.stability.margin_ringing),
            found.stability.reason,
        )
        for period in answer.periods
        for found in period.orbits
    ]
    if not rows:
        nearest = [period.states.nearest for period in answer.periods if period.states.nearest]
        factor = next((near.load_factor for near in nearest if near.load_factor is not None), None)
        return f"<p>None.{'' if factor is None else f' The nearest load factor with one is {_text(factor)}.'}</p>"
    speed = "striking speed [m/s]" if answer.system.is_si else "striking speed"
    head = (
        "motion",
        "phase [rad]",
        speed,
        "possible",
        "stable",
        "rhythm margin",
        "ringing margin",
        "why",
    )
    return _table(head, rows)


def _reach(answer: SteadyAnswer) -> str:
    """A sentence of each parameter."""
    if not answer.reach or answer.chosen is None:
        return "<p>No stable motion to follow.</p>"
    items = "".join(f"<li>{_safe(reach_in_words(row))}</li>" for row in answer.reach)
    return f"<p>Before {_safe(name_of(answer, answer.chosen))}, is lost:</p><ul>{items}</ul>"


def _timed(answer: SteadyAnswer) -> str:
    """The motions of a law that knows the duration of the blow; nothing where the case has none."""
    if answer.law is None:
        return ""
    rows = []
    for period in answer.periods:
        for found in period.orbits:
            lines = [ENDED] if found.timed is None else timed_in_words(found.timed, found.stability)
            rows.append((name_of(answer, found), *_cells(lines)))
        alone = () if period.timed is None else period.timed.alone
        rows += [(f"alone, m = {period.states.periods}", *_cells(timed_in_words(found))) for found in alone]
    law = f"<p>By {_safe(law_in_words(answer.law, answer.system))}.</p>"
    return law + _table(("motion", "phase", "blow", "verdict"), rows)


def _cells(lines: list[str]) -> tuple[str, str, str]:
    phase, blow, *verdict = [*lines, "", ""]
    return phase, blow, " ".join(verdict).strip()


def _striking(found: OrbitAnswer) -> str:
    """A striking speed; none where the end would be leaving the wall at the moment of impact."""
    if found.orbit.impact_velocity <= 0.0:
        return "– (no blow)"
    return _text(found.orbit.impact_velocity if found.si is None else found.si.impact_velocity_m_s)


def _starts(answer: SteadyAnswer) -> str:
    told = answer.starts.to_json_dict(answer.system)
    scaled = answer.system.is_si
    figures = [end["si"] or {} if scaled else end for end in told["ends"]]
    keys = ("delivered_power_kW", "blow_rate_Hz") if scaled else ("delivered_power", "blow_rate")
    rows = [
        (end["label"], f"{end['starts']} of {told['followed']}", *(_text(shown.get(key)) for key in keys))
        for end, shown in zip(told["ends"], figures, strict=True)
    ]
    units = ("kW", "1/s") if scaled else ("dimensionless", "per load period")
    head = ("motion", "starts", f"power taken by the impacts ({units[0]})", f"main blows ({units[1]})")
    begun = f"On the wall, leaving it with a random speed at a random phase; {told['modes']} elastic modes."
    return f"<p>{begun}</p>{_table(head, rows)}"


def _simulated(answer: SimulationAnswer) -> str:
    motion, summary = answer.motion, answer.summary
    rows = [
        ("motion", motion.label),
        ("ended by", motion.outcome),
        ("impacts", str(motion.impacts)),
        ("impacts per load period", _text(summary.blow_rate)),
    ]
    if answer.orbit is not None:
        rows.insert(1, ("orbit", orbit_in_words(answer.orbit)))
    if summary.si is None:
        rows += [
            ("mean striking speed", _text(summary.impact_velocity)),
            ("mean blow energy", _text(summary.blow_energy)),
        ]
    else:
        rows += [
            ("blow rate [Hz]", _text(summary.si.blow_rate_Hz)),
            ("mean striking speed [m/s]", _text(summary.si.impact_velocity_m_s)),
            ("mean blow energy [J]", _text(summary.si.blow_energy_J)),
        ]
    return _table(("quantity", "value"), rows) + "".join(f"<p>{_safe(text)}</p>" for text in answer.warnings)


def _laws(answer: SteadyAnswer) -> str:
    """What the figures rest on: the law of the contact and that of the damping."""
    system = answer.system
    return f"<p>Contact: {_safe(system.contact.sentence)}. Damping: {_safe(system.body.damping.words)}.</p>"


def _notes(answer: SteadyAnswer) -> str:
    said = [*answer.notes, *(text for p in answer.periods for found in p.orbits for text in found.orbit.warnings)]
    timed = [found for p in answer.periods if p.timed is not None for found in p.timed.orbits]
    said += [text for found in timed for text in found.orbit.warnings]
    return "".join(f"<p>{_safe(text)}</p>" for text in dict.fromkeys(said))


def _table(head: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    top = "".join(f"<th>{_safe(name)}</th>" for name in head)
    body = "".join(f"<tr>{''.join(f'<td>{_safe(cell)}</td>' for cell in row)}</tr>" for row in rows)
    return f'<div class="scroll"><table><thead><tr>{top}</tr></thead><tbody>{body}</tbody></table></div>'


def _figure(figure: Any, caption: str) -> str:
    from percuss import plot

    with tempfile.TemporaryDirectory(prefix="percuss-") as folder:
        path = Path(folder, "figure.svg")
        plot.save(figure, path)
        svg = path.read_text(encoding="utf-8")
    svg = svg[svg.index("<svg") :]
    svg = re.sub(r"<metadata>.*?</metadata>", "", svg, count=1, flags=re.DOTALL)
    return f"<figure>{svg}<figcaption>{_safe(caption)}</figcaption></figure>"


def _text(value: float | None) -> str:
    return "–" if value is None else f"{value:.5g}"


def _safe(text: str) -> str:
    """Text of others: neither markup nor a character that steers what shows it."""
    return escaped(neutral(text))
