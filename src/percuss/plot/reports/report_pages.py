"""What stands in a report as a file, page by page: blocks that HTML and PDF are written from."""

from __future__ import annotations

import math
import re
import tempfile
from collections.abc import Callable, Iterable, Iterator, Sequence
from datetime import date
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from percuss._version import __version__
from percuss.blow import Rod
from percuss.case.answers.blows.blow_answer import BlowAnswer, blow_report
from percuss.case.answers.blows.repeated_answer import RepeatedAnswer, repeated_report
from percuss.case.answers.blows.transfer import assumed
from percuss.case.answers.exploring.comparison import Comparison
from percuss.case.answers.exploring.design import DesignAnswer
from percuss.case.answers.exploring.identify import DataSheetAnswer, IdentifyAnswer
from percuss.case.answers.exploring.tolerance import ToleranceAnswer
from percuss.case.answers.facts import Grid, Report, ReportSection, number
from percuss.case.answers.machine_answer import MachineAnswer, machine_answer, machine_report
from percuss.case.answers.recorded_answer import RecordedAnswer, recorded_report
from percuss.case.answers.simulation_answer import motion_report
from percuss.case.answers.steady_answer import SteadyAnswer
from percuss.case.answers.steady_report import steady_report
from percuss.case.answers.whole_hammer import HEADLINE, WHOLE_FIGURES
from percuss.plot.reports.bar_outline import bar_outline
from percuss.plot.reports.translation import translation

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from percuss.case import Case, SimulationAnswer
    from percuss.model.body.uniform import Piece

Answer = (
    SteadyAnswer
    | MachineAnswer
    | RecordedAnswer
    | Comparison
    | BlowAnswer
    | RepeatedAnswer
    | DesignAnswer
    | ToleranceAnswer
    | IdentifyAnswer
    | DataSheetAnswer
)


# ---- What a page is made of, whatever it is written as


class Heading(NamedTuple):
    """A heading, the title at level 1."""

    text: str
    level: int = 2


class Lead(NamedTuple):
    """The answer in a sentence or few."""

    text: str


class Rows(NamedTuple):
    """Rows of cells, below the names of the columns where they have any."""

    columns: Sequence[str]
    rows: Sequence[Sequence[str]]


class Cards(NamedTuple):
    """The few figures that matter: label and text."""

    cards: Sequence[tuple[str, str]]


class Bullets(NamedTuple):
    """Sentences, one below the other."""

    items: Sequence[str]


class Signed(NamedTuple):
    """Date and version, with room for a name and a signature; what comes behind it begins a page."""

    text: str
    name: str = "Name:"
    hand: str = "Signature:"


class Picture(NamedTuple):
    """A picture as SVG, and what it shows; "" where that needs no words."""

    svg: str
    caption: str = ""


class Listing(NamedTuple):
    """A text with its lines as they are."""

    text: str


class Footer(NamedTuple):
    """The last line."""

    text: str


Block = Heading | Lead | Rows | Cards | Bullets | Signed | Picture | Listing | Footer


BLOW = "Forces, waves, stresses, and where the energy goes"
"""What the picture of a blow shows."""

GLOSSARY = "docs/glossary.md"
"""Where the terms are explained, in the documentation."""


def report_blocks(
    case: Case,
    answer: Answer,
    simulation: SimulationAnswer | None = None,
    blow: BlowAnswer | None = None,
    language: str = "en",
) -> list[Block]:
    """What a report has of a case, its steady motions or its cycle, its blow, and a simulated motion, in a language.

    The first page of one hammer has the answer, a drawing to scale, the few figures that matter, what was assumed, and
    a place to sign, which other reports have at their end. A comparison, and a design, is told with all its cases.
    """
    from percuss import plot

    words = translation(language)
    drawn = partial(picture_of, words=words)
    report, picture, caption = answer_told(answer)
    blocks: list[Block] = [Heading(report.title, 1), Lead(report.summary)]
    signed = Signed(f"{date.today().isoformat()}, percuss {__version__}")
    hammer = answer.answer if isinstance(answer, RecordedAnswer) else answer
    figures: list[Block] = [drawn(picture, caption)]
    if isinstance(hammer, SteadyAnswer | MachineAnswer):
        blocks += [*_first_page(case, hammer, words), *_warned(answer), signed]
        figures.insert(0 if isinstance(hammer, SteadyAnswer) else 1, Heading("Appendix: all figures"))
    if isinstance(hammer, MachineAnswer):
        blocks.append(figures.pop(0))
    if blow is not None:
        struck = blow_report(blow)
        blocks += [Heading("The blow by waves"), Lead(struck.summary), drawn(plot.blow(blow), BLOW)]
        blocks += _parts(struck.sections)
    blocks += [*figures, *_parts(report.sections)]
    if simulation is not None:
        moved = motion_report(simulation, 0)
        shown = plot.trajectory if simulation.motion.is_clocked else plot.machine_motion
        blocks += [Heading("Simulated motion"), Lead(moved.summary), *_parts(moved.sections[1:])]
        blocks.append(drawn(shown(simulation), "The motion from the start of the case"))
    both = answer.comparison if isinstance(answer, DesignAnswer) else answer
    several = zip(both.names, both.cases, strict=True) if isinstance(both, Comparison) else ()
    for heading, told in [(f"Case {name}", one) for name, one in several] or [("Case", case)]:
        blocks += [Heading(heading), Listing(told.to_toml())]
    if signed not in blocks:
        blocks.append(signed)
    blocks.append(Footer(f"percuss {__version__}; numbers without a unit are dimensionless; terms: {GLOSSARY}"))
    return [_said(block, words) for block in blocks]


def _said(block: Block, words: Callable[[str], str]) -> Block:
    """A block in other words; a picture has its own, and what is listed stays."""

    def told(value: Any) -> Any:
        if isinstance(value, str):
            return words(value)
        return value if isinstance(value, int) else [told(one) for one in value]

    if isinstance(block, Listing):
        return block
    return block._replace(**{name: told(value) for name, value in block._asdict().items() if name != "svg"})


def answer_told(answer: Answer) -> tuple[Report, Figure, str]:
    """What an answer says, its picture, and what that shows."""
    from percuss import plot

    if isinstance(answer, SteadyAnswer):
        return (
            steady_report(answer),
            plot.steady(answer),
            "Phases of the blows, load, stroke, stability, stress",
        )
    if isinstance(answer, Comparison):
        return answer.report(), plot.comparison(answer), "Cycles and blows"
    if isinstance(answer, ToleranceAnswer):
        return answer.report(), plot.tolerance(answer), "What dominates, and the figures of all hammers drawn"
    if isinstance(answer, IdentifyAnswer):
        return answer.report(), plot.identify(answer), "The blows that were measured, and those of the hammer that fits"
    if isinstance(answer, DataSheetAnswer):
        found = machine_answer(answer.best, modes=0)
        return answer.report(), plot.machine(found), "The cycle of the machine that the data sheet tells of"
    if isinstance(answer, DesignAnswer):
        return answer.report(), plot.comparison(answer.comparison), "Cycles and blows, A the case, B the best"
    if isinstance(answer, BlowAnswer):
        return blow_report(answer), plot.blow(answer), BLOW
    if isinstance(answer, RepeatedAnswer):
        return (
            repeated_report(answer),
            plot.repeated(answer),
            "Penetration and energies of each blow",
        )
    if isinstance(answer, RecordedAnswer):
        return recorded_report(answer), plot.machine(answer), "The cycle of the machine that was read, over the record"
    return machine_report(answer), plot.machine(answer), "The cycle"


# ---- The first page of a report on one hammer: the answer, a drawing, the few figures that matter, what was assumed


def _first_page(case: Case, answer: SteadyAnswer | MachineAnswer, words: Callable[[str], str]) -> list[Block]:
    whole, given = answer.whole, answer.uncertainty
    blocks: list[Block] = []
    hammer = answer.system if isinstance(answer, SteadyAnswer) else answer.machine
    if case.is_si and hammer.bar is not None and case.tables.body is None:
        rod = None if whole.tool is None else whole.tool.target
        tool = rod.pieces if isinstance(rod, Rod) and rod.impedance is None else ()
        blocks += [Picture(bar_outline(hammer, tool, words)), Rows(_SIZES, _sizes(hammer.bar.pieces, tool))]
    cards = []
    for name in HEADLINE:
        value = None if name == "stress" and answer.transfer is not None else whole.value(name)  # then told by bodies
        if value is not None and case.is_si and case.tables.body is None and answer.whole.value("impact_velocity"):
            figure = WHOLE_FIGURES[name]
            told = (given and given.told(name)) or figure.tell(value, case.is_si, 3)
            cards.append((figure.label, told))
    if cards:
        which = "" if whole.runs else " (in a motion that cannot be sustained)"
        blocks += [Heading(f"Figures{which}"), Cards(cards)]
    if answer.reach:
        blocks += [Heading("It runs within"), Rows((), [(row.label, row.words) for row in answer.reach])]
    return [*blocks, Heading("Assumed"), Bullets(_assumed(answer))]


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
    found = [*answer.notes]
    if isinstance(answer, SteadyAnswer) and not answer.system.body.is_free:
        return [*found, "a structure that moves by its modes, and touches at one place"]
    rigid = getattr(answer.whole.motion, "modes", None) == 0
    found.append("a rigid piston" if rigid else "waves in the piston, by its elastic modes")
    found.append("a bar that stays straight and centred, and faces that meet flat")
    if answer.transfer is not None:
        found.append(assumed(answer.transfer.blow.target))
    return found


def _warned(answer: Answer) -> list[Block]:
    """What speaks against the figures, if anything does."""
    if isinstance(answer, SteadyAnswer):
        doubted = [text for text in answer.told_notes if text not in answer.notes]
        found = [*doubted, *(answer.history.warnings if answer.history is not None else ())]
    elif isinstance(answer, RecordedAnswer):
        found = [*answer.doubts, *answer.warnings, *answer.answer.warnings]
    else:
        found = [*answer.warnings] if isinstance(answer, MachineAnswer) else []
    return [Heading("Warnings"), Bullets(found)] if found else []


def _parts(sections: Iterable[ReportSection | Grid]) -> Iterator[Block]:
    """Sections of a report as headings and tables."""
    for part in sections:
        if isinstance(part, Grid):
            yield from (Heading(part.heading), Rows(part.columns, part.rows))
        else:
            yield from (Heading(part.heading, part.level + 1), Rows((), part.rows))


def picture_of(figure: Figure, caption: str, words: Callable[[str], str] = str) -> Picture:
    """A figure as a block, its texts in other words; the same figure gives the same bytes."""
    from percuss import plot
    from percuss.plot.canvas import reword

    reword(figure, words)
    with tempfile.TemporaryDirectory(prefix="percuss-") as folder:
        path = Path(folder, "figure.svg")
        plot.save(figure, path)
        svg = path.read_text(encoding="utf-8")
    svg = svg[svg.index("<svg") :]
    return Picture(re.sub(r"<metadata>.*?</metadata>", "", svg, count=1, flags=re.DOTALL), caption)
