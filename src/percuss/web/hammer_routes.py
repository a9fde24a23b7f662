"""What is asked of a whole hammer: the best, tolerances, others beside it, numbers by measured blows, fatigue."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from percuss.atomic_write import write_whole
from percuss.case import CaseFamily, Limit, Span, compare, design, identify, load_case, parsed_tolerance, parsed_unknown
from percuss.case.answers.exploring.design import search_told
from percuss.case.answers.exploring.tolerance import ToleranceAnswer, tolerance_job
from percuss.case.answers.facts import Grid
from percuss.case.answers.whole_hammer import whole_figure
from percuss.case.catalogue.sample_cases import is_sample
from percuss.errors import ParameterError
from percuss.halting import halting
from percuss.web.case_routes import described
from percuss.web.questions import HammerAsked
from percuss.web.shared_by_routes import DRAWING, Events, Questions, Tell

if TYPE_CHECKING:
    from percuss.case import Case, DesignPlane
    from percuss.optimum import SearchProgress
    from percuss.plot.reports.report_pages import Answer
    from percuss.web.settings import Limits
    from percuss.web.workers import Halt

router = Questions()

Told = Callable[[float, str], bool]  # the share that is done and what it is, in words; true: stop


class _Found(NamedTuple):
    answer: Answer
    case: Case | None = None  # that of the answer, to go on with
    plane: DesignPlane | None = None


@router.stream(
    "/api/hammer",
    "A question about the whole hammer",
    "the question",
    kernels=lambda asked: "blows" if asked.case is None or "tool" in asked.case else None,
)
def hammer(case: Case, asked: HammerAsked, limits: Limits) -> Events:
    """Events ``progress`` with the share that is done, then ``done``, with summary, sections, pictures as SVG and the
    case to go on with, if any, or ``error``; ends when the client leaves."""
    begin = _ASKED[asked.question](case, asked)

    def looks(halt: Halt, tell: Tell) -> None:
        from percuss import plot
        from percuss.plot.reports.report_pages import answer_told, picture_of

        def told(share: float, words: str) -> bool:
            tell("progress", {"done": share, "told": words})
            return halt()

        with halting(halt):
            found = begin(told)
            with DRAWING:
                report, drawn, caption = answer_told(found.answer)
                pictures = [picture_of(drawn, caption)]
                if found.plane is not None:
                    about = "Hammers about the best, and which limits they miss"
                    pictures.append(picture_of(plot.design_plane(found.plane), about))
        sections = [
            {"heading": part.heading, "columns": part.columns if isinstance(part, Grid) else (), "rows": part.rows}
            for part in report.sections
        ]
        told_of = {"summary": report.summary, "tone": report.tone, "sections": sections}
        case_of = None if found.case is None else described(found.case)
        tell("done", {**told_of, "pictures": [one._asdict() for one in pictures], "case": case_of})

    return looks


def _limit(words: str, is_si: bool) -> Limit:
    for sign, sense in (("<", "below"), (">", "above")):
        if sign in words:
            return Limit.parsed(words.replace(sign, "=", 1), sense, is_si)
    return Limit.parsed(words, "want", is_si)


def _design(case: Case, asked: HammerAsked) -> Callable[[Told], _Found]:
    spans = [Span.parsed(words) for words in asked.vary]
    limits, figure = [_limit(words, case.is_si) for words in asked.limits], whole_figure(asked.figure)
    if not spans:
        raise ParameterError("vary", "", "one range or more", "say what may vary, such as bar.length=300:400mm")

    def begin(told: Told) -> _Found:
        def progress(now: SearchProgress) -> bool:
            return told(now.fraction, search_told(now, figure, case.is_si))

        sizes: dict[str, Any] = {"modes": asked.modes, "seed": asked.seed, "most": asked.hammers}
        answer = design(case, spans, asked.figure, limits, greatest=asked.greatest, **sizes, progress=progress)
        wanted = asked.plane and len(spans) > 1 and answer.complete
        return _Found(answer, answer.case, answer.plane(progress=progress) if wanted else None)

    return begin


def _tolerance(case: Case, asked: HammerAsked) -> Callable[[Told], _Found]:
    from percuss.explore import carry_out

    spans = [parsed_tolerance(words, case) for words in asked.vary]
    job = tolerance_job(case, spans, (), samples=asked.hammers, seed=asked.seed, modes=asked.modes)

    def begin(told: Told) -> _Found:
        columns = carry_out(
            job, workers=1, progress=lambda now: told(now.done / now.size, f"{now.done} of {now.size} hammers")
        )
        return _Found(ToleranceAnswer(case, job, columns, not spans and not case.uncertain))

    return begin


def _compare(case: Case, asked: HammerAsked) -> Callable[[Told], _Found]:
    cases, names, family = [case], ["the case"], CaseFamily(case, {})
    for words in asked.beside:
        if "=" in words:
            pairs = [[part.strip() for part in pair.partition("=")] for pair in words.split(",")]
            found = {family.key(key) or key: _number(value) for key, _, value in pairs}
            if not found.keys() <= set(family.keys):  # nothing but its numbers: a file would be read
                raise ParameterError("beside", words, "keys of the case that hold a number")
            cases.append(case.varied(found))
        elif is_sample(words):
            cases.append(load_case(words))
        else:
            raise ParameterError("beside", words, "KEY=VALUE, or a machine of the catalogue")
        names.append(words)
    if len(cases) < 2:
        raise ParameterError("beside", "", "a machine of the catalogue, or other numbers", "such as pressure=150 bar")

    def begin(told: Told) -> _Found:
        told(0.0, f"{len(cases)} hammers")
        return _Found(compare(cases, names, asked.modes))

    return begin


def _number(text: str) -> float | str:
    try:
        return float(text)
    except ValueError:
        return text


def _identify(case: Case, asked: HammerAsked) -> Callable[[Told], _Found]:
    from percuss.recordings import read_blows

    vary = [parsed_unknown(words, case) for words in asked.vary]
    given = [parsed_tolerance(words, case) for words in asked.given]
    with tempfile.TemporaryDirectory(prefix="percuss-") as folder:
        path = Path(folder, "blows.csv")
        write_whole(path, asked.blows)
        record = read_blows(path)

    def begin(told: Told) -> _Found:
        told(0.0, f"{record.time.size} blows")
        answer = identify(case, record, vary, given, modes=asked.modes)
        return _Found(answer, answer.best)

    return begin


def _fatigue(case: Case, _: HammerAsked) -> Callable[[Told], _Found]:
    from percuss.case import blow_answer

    def begin(told: Told) -> _Found:
        told(0.0, "one blow, and the stresses that it leaves in every section")
        return _Found(blow_answer(case, fatigue=True))

    return begin


_ASKED = {
    "design": _design, "tolerance": _tolerance, "compare": _compare, "identify": _identify, "fatigue": _fatigue,
}  # fmt: skip
