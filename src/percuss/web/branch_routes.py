"""Orbits of any label: searched for, followed through a parameter, and shown where a branch is looked at."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from fastapi import APIRouter
from starlette.requests import Request
from starlette.responses import Response

from percuss.case import branch_answer, diagram_job_of, orbits_answer, rest_branch_answer, rest_cycles_answer
from percuss.case.answers.diagram_answer import diagram_dict, watched_diagram
from percuss.case.answers.motion_frames import branch_frames, rest_branch_frames
from percuss.case.answers.orbits_answer import (
    branch_dict,
    curve_dict,
    is_rest_label,
    orbits_dict,
    parsed_label,
    rest_branch_dict,
    rest_cycles_dict,
)
from percuss.case.answers.point_curves_answer import watched_curves
from percuss.halting import halting
from percuss.web.lanes import Halt
from percuss.web.questions import (
    AlongAsked,
    BranchMotionAsked,
    DiagramAsked,
    FollowAsked,
    OrbitsAsked,
    PointCurvesAsked,
)
from percuss.web.request_bodies import StrictRoute, refused
from percuss.web.shared_by_routes import (
    PROBLEMS,
    STREAM,
    Tell,
    answer_of,
    binary,
    case_asked,
    compiled,
    failures_told,
    gate_of,
    limits_of,
    packed,
    plain_json,
    streamed,
)
from percuss.web.steady_routes import BINARY

if TYPE_CHECKING:
    from percuss.case import Case
    from percuss.explore.diagrams.diagram_job import DiagramJob

router = APIRouter(route_class=StrictRoute)

_LABELS = 16
"""Of the branches in one diagram, at most."""

_SHARE = 0.7
"""Of the time of a question, after which what has been followed so far is the answer."""


@router.post("/api/orbits", summary="What percuss orbits --json answers, of one label", responses=PROBLEMS)
async def orbits(request: Request, asked: OrbitsAsked) -> Response:
    """All orbits z=p/n that a search finds, with what may be missing."""

    def work(case: Case, _: Halt) -> dict[str, Any]:
        if is_rest_label(asked.label):
            return rest_cycles_dict(rest_cycles_answer(case, modes=asked.modes), asked.label)
        return orbits_dict(orbits_answer(case, asked.label, modes=asked.modes, tries=asked.tries, seed=asked.seed))

    return plain_json(await answer_of(request, asked, work, kernels="orbits"))


@router.post("/api/follow", summary="What percuss follow --json answers", responses=PROBLEMS)
async def follow(request: Request, asked: FollowAsked) -> Response:
    """An orbit followed both ways through a parameter; one that takes too long is answered as far as it has come."""
    along, seconds = along_text(asked.along), _SHARE * limits_of(request).seconds
    rests = is_rest_label(asked.orbit.partition(":")[0])
    if rests and asked.switch:
        raise refused(422, "nothing branches off a cycle with rest", "expected 0", "switch", asked.switch)

    def work(case: Case, halt: Halt) -> dict[str, Any]:
        soon = Halt(seconds)

        def ends() -> bool:
            return halt() or soon()

        if rests:
            return rest_branch_dict(rest_branch_answer(case, asked.orbit, along, modes=asked.modes, halt=ends))
        return branch_dict(branch_answer(case, asked.orbit, along, switch=asked.switch, modes=asked.modes, halt=ends))

    return plain_json(await answer_of(request, asked, work, kernels="orbits"))


@router.post(
    "/api/follow/motion", summary="The motion at a point of a branch", response_class=Response, responses=BINARY
)
async def branch_motion(request: Request, asked: BranchMotionAsked) -> Response:
    """Displacement and strain along the bar over whole cycles of an orbit, be it stable or not; as POST /api/motion."""
    if (asked.times is None) == (asked.release is None):
        raise refused(422, "expected either the times of impacts or a release", "", "times", asked.times)

    def work(case: Case, _: Halt) -> bytes:
        at = (case, asked.name, asked.value)
        sizes: dict[str, Any] = {"unit": asked.unit, "modes": asked.modes, "cycles": asked.cycles}
        sizes |= {"frames": asked.frames, "places": asked.places, "points": asked.end_points}
        if asked.times is not None:
            found = branch_frames(*at, asked.times, asked.periods, **sizes)
        else:
            assert asked.release is not None
            found = rest_branch_frames(*at, asked.release, asked.periods, **sizes)
        return packed(found.header, found.arrays)

    return binary(await answer_of(request, asked, work, kernels="orbits"))  # which come after those of motions


@router.post("/api/diagram", summary="All motions over a parameter", responses=STREAM)
async def motions_over(request: Request, asked: DiagramAsked) -> Response:
    """Events ``progress`` with what is found so far, then ``done`` or ``error``; ends when the client leaves."""
    limits, gate = limits_of(request), gate_of(request)
    along = f"{along_text(asked.along)}:{asked.values}"
    work = asked.values * (asked.starts + asked.runs) * asked.impacts * (asked.modes + 1)
    if work > limits.start_work:
        message = f"expected values × (starts + runs) × impacts × (modes + 1) to be at most {limits.start_work:.0e}"
        raise refused(422, f"{message}; here {work:.1e}", "take fewer, or use percuss diagram", "values", asked.values)
    if asked.up_to is not None and math.prod(parsed_label(asked.up_to)) > _LABELS:
        message = f"expected a label with at most {_LABELS} up to it"
        raise refused(422, message, "use percuss diagram for more", "up_to", asked.up_to)

    def made(_: Halt) -> tuple[Case, DiagramJob]:
        case = case_asked(asked, limits.harmonics)
        sizes: dict[str, Any] = {"starts": asked.starts, "runs": asked.runs, "modes": asked.modes, "seed": asked.seed}
        sizes |= {"up_to": asked.up_to, "searched": asked.searched, "switch": asked.switch, "tries": asked.tries}
        return case, diagram_job_of(case, along, impacts=asked.impacts, **sizes)

    case, job = await gate.quick.run(request, limits.seconds, made)
    await compiled(request, "motions" if asked.up_to is None else "orbits")  # which come after those of motions

    def follow_passes(halt: Halt, tell: Tell) -> None:
        with failures_told(tell, "a diagram"):
            for look in watched_diagram(job, halt):
                tell("done" if look.done == 1.0 else "progress", diagram_dict(case, look))

    return await streamed(request, gate.experiments, limits.experiment_seconds, follow_passes)


@router.post("/api/follow/curves", summary="What happens to an orbit, as curves over a plane", responses=STREAM)
async def curves_over(request: Request, asked: PointCurvesAsked) -> Response:
    """Events ``progress`` with the curves found so far, then ``done`` or ``error``; ends when the client leaves."""
    limits, gate = limits_of(request), gate_of(request)
    across, up = along_text(asked.x, "x"), along_text(asked.y, "y")
    if asked.x.name == asked.y.name:
        raise refused(422, "expected two different parameters", "", "y", asked.y.name)
    case = await gate.quick.run(request, limits.seconds, lambda _: case_asked(asked, limits.harmonics))
    await compiled(request, "orbits")

    def follow_points(halt: Halt, tell: Tell) -> None:
        with failures_told(tell, "following points"), halting(halt):
            for share, curves in watched_curves(case, asked.orbit, across, up, modes=asked.modes, halt=halt):
                told = {"done": share, "curves": [curve_dict(curve) for curve in curves]}
                tell("done" if share == 1.0 else "progress", told)

    return await streamed(request, gate.experiments, limits.experiment_seconds, follow_points)


def along_text(asked: AlongAsked, key: str = "along") -> str:
    """A parameter and its range as the command line takes them.

    Raises
    ------
    Refusal
        When the range is none.
    """
    if not asked.from_ < asked.to:
        raise refused(422, "expected a range from a lower to a higher value", "", key, [asked.from_, asked.to])
    low, high = (f"{value!r} {asked.unit}".rstrip() for value in (asked.from_, asked.to))
    return f"{asked.name}={low}:{high}"
