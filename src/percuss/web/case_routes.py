"""The catalogue, the check of a case, the upload of a recording, and the report as a download."""

from __future__ import annotations

from dataclasses import asdict
from importlib.util import find_spec
from typing import TYPE_CHECKING, Annotated, Any, get_args

from fastapi import Path, Query
from starlette.requests import Request
from starlette.responses import Response

from percuss._version import __version__
from percuss.case import MACHINES
from percuss.case.answers.reported import reported_answers
from percuss.case.case import without_files
from percuss.case.catalogue.sample_cases import STRUCTURES, file_beside, is_sample, machine_text
from percuss.case.file_format.bodies import MATERIALS
from percuss.case.parameters.description import case_dict
from percuss.case.parameters.moves import placed
from percuss.case.uploads.upload import uploaded_case, uploaded_history
from percuss.palette import palette_dict
from percuss.plot.reports.html_report import report_html
from percuss.plot.reports.pdf_report import report_pdf
from percuss.web.motion_routes import simulated
from percuss.web.questions import CaseAsked, HistoryAsked, PlaceAsked, ReportAsked
from percuss.web.requests import bounded_body, refused
from percuss.web.shared_by_routes import (
    DRAWING,
    PROBLEMS,
    Attachment,
    Questions,
    Terms,
    answer_of,
    check_steady,
    gate_of,
    limits_of,
    plain_json,
)
from percuss.web.workers import Part

if TYPE_CHECKING:
    from percuss.case import Case


router = Questions()

_FAST = {"exists", "orbits", "phases", "phase", "reduced_stable", "reduced_margin", "stable", "margin"}


@router.get("/api/about", summary="What this server is, and what one request may ask for")
async def about(request: Request) -> Response:
    """Answered without the token; `ready` once the kernels are compiled, for which simulated motions wait. `preparing`:
    of all `kernels` those that are not compiled yet; the first is under way."""
    from percuss.case.answers.whole_hammer import WHOLE_FIGURES
    from percuss.explore import QUANTITIES, REASONS
    from percuss.steady import Reason
    from percuss.steady.figures import CARDS

    settings = request.app.state.settings
    quantities = [
        {
            "name": name,
            "meaning": next(iter(quantity.columns.values())).meaning
            if name != "label"
            else "the motion that it ends in",
            "unit": next(iter(quantity.columns.values())).unit,
            "kind": _kind(name, next(iter(quantity.columns.values())).dtype),
            "words": list(REASONS) if name == "reason" else None,
            "fast": name in _FAST,
        }
        for name, quantity in QUANTITIES.items()
    ]
    return plain_json(
        {
            "name": "percuss",
            "version": __version__,
            "token": bool(settings.token),
            "case": bool(settings.case),
            "ready": request.app.state.kernels.settled("machines"),
            "preparing": request.app.state.kernels.preparing(),
            "kernels": list(get_args(Part)),
            "limits": settings.limits.to_json_dict(),
            "quantities": quantities,
            "palette": palette_dict(),
            "reasons": {reason.value: reason.words for reason in Reason},
            "cards": [_card(key) for key in CARDS],
            "figures": [{"name": name, "label": one.label} for name, one in WHOLE_FIGURES.items()],
            "distributions": ["wall", "field", "gentle"],
            "starts": ["rigid", "still", "ringing"],
            "materials": {
                word: {"youngs_modulus_Pa": found.youngs_modulus, "density_kg_m3": found.density}
                for word, found in MATERIALS.items()
            },
        }
    )


def _card(key: str) -> dict[str, Any]:
    """A figure of the report: the key of its value in the JSON of an orbit, and the factor from there to its unit."""
    from percuss.steady.figures import REPORTED

    figure, factor, unit = REPORTED[key]
    whole = figure.unit if unit != "blows/min" else unit
    return {
        "key": key,
        "label": figure.label,
        "meaning": figure.meaning,
        "unit": whole,
        "factor": 1.0 if whole == unit else 1.0 / factor,
    }


def _kind(name: str, dtype: str) -> str:
    if name in ("label", "reason"):
        return "word"
    return {"b": "flag", "i": "count"}.get(dtype[0], "number")


@router.get("/api/machines", summary="The catalogue", responses=PROBLEMS)
async def machines() -> Response:
    """Mass in kg, blow rate in Hz, blow energy in J; `valve`: the piston switches the load. And structures."""
    structures = [asdict(structure) for structure in STRUCTURES]
    return plain_json({"machines": [asdict(machine) for machine in MACHINES], "structures": structures})


_MISSING = {404: PROBLEMS[422], **PROBLEMS}


async def _described_as_asked(request: Request, asked: CaseAsked, text: str | None = None) -> Response:
    found = await answer_of(request, asked, lambda case, _: described(case), quick=True)
    return plain_json(found if text is None else {**found, "toml": text})


@router.get("/api/machines/{name}", summary="One machine, as POST /api/case answers", responses=_MISSING)
async def machine(request: Request, name: Annotated[str, Path(max_length=64, examples=["mini-breaker"])]) -> Response:
    """Or one structure. A recording comes as its harmonics, a table of modes as its columns."""
    if not is_sample(name):
        raise refused(404, "no machine of this name", "GET /api/machines lists them", "name", name)
    return await _described_as_asked(
        request, CaseAsked(machine=name), None if file_beside(name) else machine_text(name)
    )


@router.get("/api/case", summary="The case that the server was started with", responses=_MISSING)
async def opening(request: Request) -> Response:
    """As POST /api/case answers; 404 without one."""
    text = request.app.state.settings.case
    if not text:
        raise refused(404, "the server was started without a case")
    return await _described_as_asked(request, CaseAsked.model_construct(toml=text))


@router.answer("/api/case", "Check a case", quick=True)
def check(case: Case, asked: CaseAsked, terms: Terms) -> dict[str, Any]:
    """Its tables, its text, its numbers in SI and without dimension, and what a map may vary."""
    return described(case)


@router.answer("/api/place", "Move a case to other values of its parameters", quick=True)
def place(case: Case, asked: PlaceAsked, terms: Terms) -> dict[str, Any]:
    """As POST /api/case answers, of the case with these values."""
    return case_dict(placed(case, asked.values, terms.limits.harmonics))


def described(case: Any) -> dict[str, Any]:
    given, plain = case_dict(case), without_files(case)
    if plain is case:
        return given
    return {**case_dict(plain), "history": given["history"], "notes": given["notes"]}


_FILE = {
    "requestBody": {
        "required": True,
        "content": {"application/octet-stream": {"schema": {"type": "string", "format": "binary"}}},
    }
}


@router.post(
    "/api/case/recorded",
    summary="Check a case file together with the recording that it names",
    responses=PROBLEMS,
    openapi_extra=_FILE,
)
async def recorded(
    request: Request, name: Annotated[str, Query(max_length=200)], toml_bytes: Annotated[int, Query(ge=1, le=1_000_000)]
) -> Response:
    """The body is the case file, so many bytes of TOML, and right after it the recording; as POST /api/case answers."""
    limits = limits_of(request)
    _is_file(request)
    body = await bounded_body(request, limits.upload_bytes, limits.body_seconds)
    if len(body) <= toml_bytes:
        remedy = "send the bytes of the recording right after those of the case"
        raise refused(422, "no recording after the case", remedy, "toml_bytes", toml_bytes)
    try:
        text = body[:toml_bytes].decode("utf-8")
    except UnicodeDecodeError:
        raise refused(422, "the case is not text in UTF-8", "", "toml_bytes", toml_bytes) from None
    most = limits.harmonics
    found = await gate_of(request).heavy.run(
        request, limits.seconds, lambda halt: uploaded_case(text, body[toml_bytes:], name, most, halt)
    )
    return plain_json(found)


def _is_file(request: Request) -> None:
    """Refuse what a form of another page can send without asking."""
    kind = request.headers.get("content-type", "").partition(";")[0].strip().lower()
    if kind in ("application/x-www-form-urlencoded", "multipart/form-data", "text/plain"):
        raise refused(415, "the body must be the file itself", "send Content-Type: application/octet-stream")


@router.post("/api/history", summary="Turn a recording into a load", responses=PROBLEMS, openapi_extra=_FILE)
async def history(request: Request, asked: Annotated[HistoryAsked, Query()]) -> Response:
    """The body is the file; of its name only the suffix counts. The options are those of [load] in a case."""
    limits = limits_of(request)
    _is_file(request)
    data = await bounded_body(request, limits.upload_bytes, limits.body_seconds)  # before it takes a place
    options = asked.model_dump(by_alias=True, exclude={"name"})
    for key in ("column", "time_column", "opposing_column"):  # a column may be told by its number
        text = options[key]
        options[key] = int(text) if text.isascii() and text.isdigit() and len(text) < 6 else text
    found = await gate_of(request).heavy.run(
        request, limits.seconds, lambda halt: uploaded_history(data, asked.name, options, halt)
    )
    return plain_json(found)


# ---- The report as a download

_FILES = {
    200: {
        "description": "HTML, or PDF",
        "content": {
            "text/html": {"schema": {"type": "string"}},
            "application/pdf": {"schema": {"type": "string", "format": "binary"}},
        },
    },
    **PROBLEMS,
}


def _of_report(asked: ReportAsked) -> Part | None:
    """The kernels that a report needs: blows come after motions."""
    return "blows" if asked.case is None or "tool" in asked.case else "motions" if asked.simulate else None


@router.answer(
    "/api/report",
    "A report in one file",
    _FILES,
    kernels=_of_report,
)
def report(case: Case, asked: ReportAsked, terms: Terms) -> Attachment:
    """With figures and the numbers in SI, and the blow; `simulate` adds the motion from the start of the case."""
    motion = simulated(case, asked, None, None, terms) if asked.simulate else None
    periods = tuple(sorted(set(asked.periods)))
    if not case.is_machine:
        check_steady(case.system(), periods, asked.modes, terms.limits)
    answer, blow = reported_answers(case, asked.modes, periods, fatigue=find_spec("rainflow") is not None)
    with DRAWING:
        if asked.paper:
            data = report_pdf(case, answer, motion, blow, asked.paper, asked.language)
            return Attachment(data, "report.pdf", "application/pdf")
        page = report_html(case, answer, motion, blow, asked.language)
        return Attachment(page.encode(), "report.html", "text/html; charset=utf-8")
