"""The catalogue, the check of a case, the upload of a recording, and the report as a download."""

from __future__ import annotations

import threading
from dataclasses import asdict
from typing import TYPE_CHECKING, Annotated, Any, get_args

from fastapi import APIRouter, Path, Query
from starlette.requests import Request
from starlette.responses import Response

from percuss._version import __version__
from percuss.case import MACHINES, steady_answer
from percuss.case.catalogue.sample_cases import STRUCTURES, file_beside, is_sample, machine_text
from percuss.case.file_format.body_tables import MATERIALS
from percuss.case.file_format.plain_tables import without_files
from percuss.case.parameters.description import case_dict
from percuss.case.parameters.moves import placed
from percuss.case.uploads.upload import uploaded_case, uploaded_history
from percuss.html_report import report_html
from percuss.palette import palette_dict
from percuss.web.motion_routes import simulated
from percuss.web.questions import CaseAsked, PlaceAsked, ReportAsked
from percuss.web.requests import StrictRoute, bounded_body, refused
from percuss.web.shared_by_routes import PROBLEMS, answer_of, attachment, check_steady, gate_of, limits_of, plain_json
from percuss.web.workers import Part

if TYPE_CHECKING:
    from percuss.case import Case
    from percuss.web.workers import Halt


router = APIRouter(route_class=StrictRoute)

_FAST = {"exists", "orbits", "phases", "phase", "reduced_stable", "reduced_margin", "stable", "margin"}


@router.get("/api/about", summary="What this server is, and what one request may ask for")
async def about(request: Request) -> Response:
    """Answered without the token; `ready` once the kernels are compiled, for which simulated motions wait. `preparing`:
    of all `kernels` those that are not compiled yet; the first is under way."""
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


@router.get(
    "/api/machines/{name}", summary="One machine, as POST /api/case answers", responses={404: PROBLEMS[422], **PROBLEMS}
)
async def machine(request: Request, name: Annotated[str, Path(max_length=64, examples=["mini-breaker"])]) -> Response:
    """Or one structure. A recording comes as its harmonics, a table of modes as its columns."""
    if not is_sample(name):
        raise refused(404, "no machine of this name", "GET /api/machines lists them", "name", name)
    asked = CaseAsked(machine=name)
    found = await answer_of(request, asked, lambda case, _: _described(case), quick=True)
    return plain_json(found if file_beside(name) else {**found, "toml": machine_text(name)})


@router.get(
    "/api/case", summary="The case that the server was started with", responses={404: PROBLEMS[422], **PROBLEMS}
)
async def opening(request: Request) -> Response:
    """As POST /api/case answers; 404 without one."""
    text = request.app.state.settings.case
    if not text:
        raise refused(404, "the server was started without a case")
    return plain_json(
        await answer_of(request, CaseAsked.model_construct(toml=text), lambda c, _: _described(c), quick=True)
    )


@router.post("/api/case", summary="Check a case", responses=PROBLEMS)
async def check(request: Request, asked: CaseAsked) -> Response:
    """Its tables, its text, its numbers in SI and without dimension, and what a map may vary."""
    return plain_json(await answer_of(request, asked, lambda case, _: _described(case), quick=True))


@router.post("/api/place", summary="Move a case to other values of its parameters", responses=PROBLEMS)
async def place(request: Request, asked: PlaceAsked) -> Response:
    """As POST /api/case answers, of the case with these values."""
    harmonics = limits_of(request).harmonics
    return plain_json(
        await answer_of(request, asked, lambda case, _: case_dict(placed(case, asked.values, harmonics)), quick=True)
    )


def _described(case: Any) -> dict[str, Any]:
    given, plain = case_dict(case), without_files(case)
    if plain is case:
        return given
    return {**case_dict(plain), "history": given["history"], "notes": given["notes"]}


Text = Annotated[str, Query(max_length=200)]
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
async def recorded(request: Request, name: Text, toml_bytes: Annotated[int, Query(ge=1, le=1_000_000)]) -> Response:
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


@router.post(
    "/api/history",
    summary="Turn a recording into a load",
    responses=PROBLEMS,
    openapi_extra=_FILE,
)
async def history(
    request: Request,
    name: Text,
    column: Text = "",
    unit: Text = "",
    time_column: Text = "",
    sample_rate: Text = "",
    opposing_column: Text = "",
    opposing_area: Text = "",
    start: Annotated[str, Query(alias="from", max_length=200)] = "",
    end: Annotated[str, Query(alias="to", max_length=200)] = "",
    area: Text = "",
    frequency: Text = "",
    force_scale: Text = "",
    harmonics: Annotated[int | None, Query(ge=1, le=1024)] = None,
) -> Response:
    """The body is the file; of its name only the suffix counts. The options are those of [load] in a case."""
    limits = limits_of(request)
    _is_file(request)
    lane = gate_of(request).heavy
    data = await bounded_body(request, limits.upload_bytes, limits.body_seconds)  # before it takes a place
    options: dict[str, Any] = {
        "column": _column(column),
        "unit": unit,
        "time_column": _column(time_column),
        "sample_rate": sample_rate,
        "opposing_column": _column(opposing_column),
        "opposing_area": opposing_area,
        "from": start,
        "to": end,
        "area": area,
        "frequency": frequency,
        "force_scale": force_scale,
        "harmonics": harmonics,
    }
    found = await lane.run(request, limits.seconds, lambda halt: uploaded_history(data, name, options, halt))
    return plain_json(found)


def _column(text: str) -> int | str:
    return int(text) if text.isascii() and text.isdigit() and len(text) < 6 else text


# ---- The report as a download

_drawing = threading.Lock()
"""matplotlib's settings belong to the whole process: one picture at a time."""


@router.post(
    "/api/report",
    summary="A report in one HTML file",
    response_class=Response,
    responses={200: {"description": "HTML", "content": {"text/html": {"schema": {"type": "string"}}}}, **PROBLEMS},
)
async def report(request: Request, asked: ReportAsked) -> Response:
    """With figures and the numbers in SI; `simulate` adds the motion from the start of the case."""
    limits = limits_of(request)

    def work(case: Case, halt: Halt) -> bytes:
        periods = tuple(sorted(set(asked.periods)))
        check_steady(case.system(), periods, asked.modes, limits)
        answer = steady_answer(case, periods, asked.modes)
        motion = simulated(case, asked, None, None, limits, halt) if asked.simulate else None
        with _drawing:
            return report_html(case, answer, motion).encode()

    return attachment(
        await answer_of(request, asked, work, kernels="motions" if asked.simulate else None),
        "report.html",
        "text/html; charset=utf-8",
    )
