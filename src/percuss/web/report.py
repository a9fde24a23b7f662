"""The report: one HTML file with the figures in SI, the verdicts and the pictures; it needs nothing beside it."""

from __future__ import annotations

import re
import tempfile
from collections.abc import Iterable
from dataclasses import replace
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from percuss._version import __version__

if TYPE_CHECKING:
    from percuss.case import Case, OrbitAnswer, SimulationAnswer, SteadyAnswer

__all__ = ["report_html"]

T = TypeVar("T", "SteadyAnswer", "SimulationAnswer")

_CARDS = (
    ("blow energy", "blow_energy_J", "J"),
    ("blow rate", "blow_rate_Hz", "Hz"),
    ("blows per minute", "blow_rate_per_min", "1/min"),
    ("percussive power", "percussive_power_kW", "kW"),
    ("striking speed", "impact_velocity_m_s", "m/s"),
    ("stroke", "stroke_mm", "mm"),
    ("peak stress", "peak_stress_MPa", "MPa"),
    ("delivered per blow", "delivered_energy_J", "J"),
    ("efficiency", "efficiency", ""),
    ("mean contact force", "mean_force_kN", "kN"),
    ("contact time", "contact_time_us", "µs"),
    ("momentum", "momentum_N_s", "N s"),
)

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
figure svg { width: 100%; height: auto; }
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

    parts = [f"<h1>{escape(answer.title)}</h1>", _summary(answer), _cards(answer.chosen), _notes(answer)]
    parts += [
        "<h2>Steady motions</h2>",
        _orbits(answer),
        _figure(plot.steady(_drawable(answer)), "Phases, load, gap, multipliers"),
    ]
    if simulation is not None:
        parts += ["<h2>Simulated motion</h2>", _simulated(simulation)]
        parts.append(_figure(plot.trajectory(_drawable(simulation)), "The motion from the start of the case"))
    parts += ["<h2>Case</h2>", f"<pre>{escape(case.to_toml())}</pre>"]
    parts.append(f"<footer>percuss {escape(__version__)}; numbers without a unit are dimensionless</footer>")
    body = "\n".join(parts)
    policy = "default-src 'none'; style-src 'unsafe-inline'; img-src data:"
    return f"""<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta http-equiv="Content-Security-Policy" content="{policy}">
<title>{escape(answer.title)}</title>
<style>{_STYLE}</style>
</head>
<body>
{body}
</body>
</html>
"""


def _drawable(answer: T) -> T:
    """The same answer with a title in which matplotlib finds no formula."""
    return replace(answer, title=answer.title.replace("$", r"\$"))


def _summary(answer: SteadyAnswer) -> str:
    chosen = answer.chosen
    if chosen is None:
        text = "No steady motion exists with these parameters."
        nearest = next((period.states.nearest for period in answer.periods if period.states.nearest), None)
        if nearest is not None:
            text += f" The nearest load factor with one is {_text(nearest.load_factor)}."
        return f"<p>{escape(text)}</p>"
    verdict = "A hammer can keep this motion up" if chosen.runs else "No hammer keeps this motion up"
    orbit = chosen.orbit
    often = "every load period" if orbit.periods == 1 else f"in {orbit.periods} load periods"
    what = f"one impact {often}, at phase {_text(orbit.phase)} rad"
    return f"<p><strong>{escape(verdict)}</strong>: {escape(what)}; {escape(chosen.stability.reason)}.</p>"


def _cards(chosen: OrbitAnswer | None) -> str:
    if chosen is None or chosen.si is None:
        return ""
    cells = [
        f'<div class="card">{escape(name)}<b>{_text(getattr(chosen.si, key))} {escape(unit)}</b></div>'
        for name, key, unit in _CARDS
        if getattr(chosen.si, key) is not None
    ]
    return f'<div class="cards">{"".join(cells)}</div>'


def _orbits(answer: SteadyAnswer) -> str:
    rows = [
        (
            f"1/{found.orbit.periods}",
            _text(found.orbit.phase),
            _text(found.orbit.impact_velocity),
            "yes" if found.orbit.admissible else "no",
            "yes" if found.stability.stable else "no",
            _text(found.stability.margin),
            found.stability.reason,
        )
        for period in answer.periods
        for found in period.orbits
    ]
    if not rows:
        return "<p>None.</p>"
    head = ("motion", "phase (rad)", "striking speed", "possible", "stable", "margin", "why")
    return _table(head, rows)


def _simulated(answer: SimulationAnswer) -> str:
    motion, summary = answer.motion, answer.summary
    rows = [
        ("motion", motion.label),
        ("ended by", motion.outcome),
        ("impacts", str(motion.impacts)),
        ("impacts per load period", _text(summary.blow_rate)),
        ("mean striking speed", _text(summary.impact_velocity)),
        ("mean blow energy", _text(summary.blow_energy)),
    ]
    if summary.si is not None:
        rows += [
            ("blow rate (Hz)", _text(summary.si.blow_rate_Hz)),
            ("blow energy (J)", _text(summary.si.blow_energy_J)),
        ]
    return _table(("quantity", "value"), rows) + "".join(f"<p>{escape(text)}</p>" for text in answer.warnings)


def _notes(answer: SteadyAnswer) -> str:
    said = [*answer.notes, *(text for p in answer.periods for found in p.orbits for text in found.orbit.warnings)]
    return "".join(f"<p>{escape(text)}</p>" for text in dict.fromkeys(said))


def _table(head: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    top = "".join(f"<th>{escape(name)}</th>" for name in head)
    body = "".join(f"<tr>{''.join(f'<td>{escape(cell)}</td>' for cell in row)}</tr>" for row in rows)
    return f'<div class="scroll"><table><thead><tr>{top}</tr></thead><tbody>{body}</tbody></table></div>'


def _figure(figure: Any, caption: str) -> str:
    from percuss import plot

    with tempfile.TemporaryDirectory(prefix="percuss-") as folder:
        path = Path(folder, "figure.svg")
        plot.save(figure, path)
        svg = path.read_text(encoding="utf-8")
    svg = svg[svg.index("<svg") :]
    svg = re.sub(r"<metadata>.*?</metadata>", "", svg, count=1, flags=re.DOTALL)
    return f"<figure>{svg}<figcaption>{escape(caption)}</figcaption></figure>"


def _text(value: float | None) -> str:
    return "–" if value is None else f"{value:.5g}"
