"""Motions: simulated ones as the command line prints them, and any as frames to be drawn and heard."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fastapi import APIRouter
from starlette.requests import Request
from starlette.responses import Response

from percuss.case import simulation_answer
from percuss.case.answers.motion_frames import motion_frames, orbit_frames
from percuss.web.questions import CaseAsked, MotionAsked, SimulateAsked
from percuss.web.request_bodies import StrictRoute, refused
from percuss.web.shared_by_routes import (
    PROBLEMS,
    Memory,
    answer_of,
    attachment,
    binary,
    limits_of,
    motion_key,
    packed,
    plain_json,
    simulated_case,
)
from percuss.web.steady_routes import BINARY, bytes_of

if TYPE_CHECKING:
    from collections.abc import Mapping

    from percuss.case import Case, SimulationAnswer
    from percuss.web.lanes import Halt
    from percuss.web.settings import Limits

router = APIRouter(route_class=StrictRoute)

NETCDF = {**BINARY, 200: bytes_of("a file of NetCDF", "application/x-netcdf")}

_motions: Memory[SimulationAnswer] = Memory(8, 32_000_000, lambda key, kept: len(key) + kept.motion.states.nbytes)
"""By the bytes of their states."""


@router.post("/api/simulate", summary="What percuss simulate --json answers", responses=PROBLEMS)
async def simulate(request: Request, asked: SimulateAsked) -> Response:
    """Every impact from a start, and what motion it settles on."""
    limits = limits_of(request)

    def work(case: Case, halt: Halt) -> dict[str, Any]:
        return simulated(case, asked, asked.start, asked.simulation, limits, halt).to_json_dict(asked.events)

    return plain_json(await answer_of(request, asked, work, kernels="motions"))


@router.post("/api/simulate/file", summary="A simulated motion as NetCDF", response_class=Response, responses=NETCDF)
async def simulate_file(request: Request, asked: SimulateAsked) -> Response:
    """The whole motion, which percuss simulate --resume follows further."""
    limits = limits_of(request)

    def work(case: Case, halt: Halt) -> bytes:
        answer = simulated(case, asked, asked.start, asked.simulation, limits, halt)
        with tempfile.TemporaryDirectory(prefix="percuss-") as folder:
            file = Path(folder, "motion.nc")
            answer.motion.save(file)
            return file.read_bytes()

    return attachment(await answer_of(request, asked, work, kernels="motions"), "motion.nc", "application/x-netcdf")


@router.post(
    "/api/motion", summary="Displacement and strain along the bar over time", response_class=Response, responses=BINARY
)
async def motion(request: Request, asked: MotionAsked) -> Response:
    """Of a steady motion (`orbit`), or of a simulation."""
    limits = limits_of(request)
    if asked.orbit is not None and (asked.start is not None or asked.simulation is not None):
        raise refused(422, "expected either a steady motion or a start", "leave out start and simulation", "orbit")
    sizes: dict[str, Any] = {
        "cycles": asked.cycles,
        "frames": asked.frames,
        "places": asked.places,
        "points": asked.end_points,
        "window": asked.window,
    }

    def work(case: Case, halt: Halt) -> bytes:
        if asked.orbit is not None:
            found = orbit_frames(case, asked.orbit, asked.periods, **sizes)
        else:
            answer = simulated(case, asked, asked.start, asked.simulation, limits, halt)
            found = motion_frames(answer.motion, settled=asked.show == "settled", **sizes)
        return packed(found.header, found.arrays)

    return binary(await answer_of(request, asked, work, kernels="motions" if asked.orbit is None else None))


def simulated(
    case: Case,
    asked: CaseAsked,
    start: Mapping[str, Any] | None,
    simulation: Mapping[str, Any] | None,
    limits: Limits,
    halt: Halt,
) -> SimulationAnswer:
    """The motion of a case from a start; one that was asked for a moment ago is not computed again.

    Raises
    ------
    Refusal
        When it would take too much, or took too long.
    PercussError
        When there is no such motion.
    """
    key = motion_key(asked, start, simulation)
    known = _motions.find(key)
    if known is not None:
        return known
    answer = simulation_answer(simulated_case(case, start, simulation, limits), halt)
    if answer.motion.outcome == "cancelled":
        raise refused(503, "it took too long", "ask for fewer impacts or modes")
    _motions.put(key, answer)
    return answer
