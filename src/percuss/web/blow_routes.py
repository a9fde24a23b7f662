"""One blow, resolved by waves: as pictures in time, with the answer of the command line."""

from __future__ import annotations

from typing import TYPE_CHECKING

from fastapi import APIRouter
from starlette.requests import Request
from starlette.responses import Response

from percuss.case.answers.blow_frames import blow_frames
from percuss.web.questions import BlowAsked
from percuss.web.request_bodies import StrictRoute
from percuss.web.shared_by_routes import answer_of, binary, limits_of, packed
from percuss.web.steady_routes import BINARY

if TYPE_CHECKING:
    from percuss.case import Case
    from percuss.web.lanes import Halt

router = APIRouter(route_class=StrictRoute)


@router.post("/api/blow", summary="One blow, resolved by waves", response_class=Response, responses=BINARY)
async def blow(request: Request, asked: BlowAsked) -> Response:
    """Stress and velocity along striker and tool over time, the force between the faces, and where the energy is."""

    sizes = {"frames": asked.frames, "cells": asked.cells, "most_pieces": limits_of(request).pieces}

    def work(case: Case, _: Halt) -> bytes:
        found = blow_frames(case, asked.show, whole=asked.whole, **sizes)
        return packed(found.header, found.arrays)

    short = asked.show == "start" and not asked.whole
    return binary(await answer_of(request, asked, work, quick=short, kernels="blows"))
