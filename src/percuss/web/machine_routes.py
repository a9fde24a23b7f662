"""A machine that switches its own valve: its cycle over time, with the answer of the command line, and its start-up."""

from __future__ import annotations

from typing import TYPE_CHECKING

from fastapi import APIRouter
from starlette.requests import Request
from starlette.responses import Response

from percuss.case import machine_motion
from percuss.case.answers.machine_frames import machine_frames, start_frames
from percuss.web.questions import MachineAsked, MachineStartAsked
from percuss.web.request_bodies import StrictRoute, refused
from percuss.web.shared_by_routes import answer_of, binary, limits_of, packed, simulated_case
from percuss.web.steady_routes import BINARY

if TYPE_CHECKING:
    from percuss.case import Case
    from percuss.web.lanes import Halt

router = APIRouter(route_class=StrictRoute)


@router.post("/api/machine", summary="A machine that switches itself", response_class=Response, responses=BINARY)
async def machine(request: Request, asked: MachineAsked) -> Response:
    """Position, force and state of the valve over a cycle, or what keeps the machine from running."""

    def work(case: Case, _: Halt) -> bytes:
        modes = 0 if case.is_machine and case.machine().valve.supply is not None else asked.modes  # none under a supply
        found = machine_frames(case, modes=modes, points=asked.points, whole=asked.whole)
        return packed(found.header, found.arrays)

    short = not asked.whole and asked.modes == 0
    return binary(await answer_of(request, asked, work, quick=short))


@router.post(
    "/api/machine/start",
    summary="Such a machine from a start",
    response_class=Response,
    responses=BINARY,
)
async def machine_start(request: Request, asked: MachineStartAsked) -> Response:
    """Position, force and state of the valve over the first blows of what percuss simulate follows."""
    limits = limits_of(request)

    def work(case: Case, halt: Halt) -> bytes:
        if case.is_machine:  # else it is refused below
            case = simulated_case(case, asked.start, asked.simulation, limits)
        found = machine_motion(case, halt)
        if found.motion.outcome == "cancelled" and halt():
            raise refused(503, "it took too long", "ask for fewer impacts or modes")
        frames = start_frames(found, asked.blows, asked.points)
        return packed(frames.header, frames.arrays)

    return binary(await answer_of(request, asked, work, quick=True, kernels="machines"))
