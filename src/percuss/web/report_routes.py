"""The report as a download."""

from __future__ import annotations

import threading
from typing import TYPE_CHECKING

from fastapi import APIRouter
from starlette.requests import Request
from starlette.responses import Response

from percuss.case import steady_answer
from percuss.html_report import report_html
from percuss.web.motion_routes import simulated
from percuss.web.questions import ReportAsked
from percuss.web.request_bodies import StrictRoute
from percuss.web.shared_by_routes import PROBLEMS, answer_of, attachment, check_steady, limits_of

if TYPE_CHECKING:
    from percuss.case import Case
    from percuss.web.lanes import Halt

router = APIRouter(route_class=StrictRoute)

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
