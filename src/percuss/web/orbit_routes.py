"""Steady motions, their curves, maps and boundaries; orbits of any label, followed through a parameter."""

from __future__ import annotations

import math
import time
from typing import TYPE_CHECKING, Any

import numpy as np
from fastapi import APIRouter
from starlette.requests import Request
from starlette.responses import Response

from percuss.case import (
    branch_answer,
    diagram_job_of,
    orbits_answer,
    rest_cycles_answer,
    steady_answer,
    structure_answer,
    sweep_job_of,
)
from percuss.case.answers.exploring.diagram_answer import diagram_dict, watched_diagram
from percuss.case.answers.exploring.orbits_answer import (
    branch_dict,
    curve_dict,
    is_rest_label,
    orbits_dict,
    parsed_label,
    rest_cycles_dict,
)
from percuss.case.answers.exploring.point_curves_answer import watched_curves
from percuss.case.answers.exploring.quick_answer import boundaries_dict, curves_dict, quick_dict, quick_structure_dict
from percuss.case.answers.playback import branch_frames
from percuss.case.file_format.plain_tables import json_tables
from percuss.case.parameters.moves import placed
from percuss.halting import halting
from percuss.web.questions import (
    AlongAsked,
    AxisAsked,
    BoundariesAsked,
    BranchMotionAsked,
    CurvesAsked,
    DiagramAsked,
    FollowAsked,
    MapAsked,
    OrbitsAsked,
    PointCurvesAsked,
    QuickAsked,
    SteadyAsked,
)
from percuss.web.requests import StrictRoute, refused
from percuss.web.shared_by_routes import (
    BINARY,
    PROBLEMS,
    STREAM,
    Tell,
    answer_of,
    binary,
    case_asked,
    check_steady,
    compiled,
    failures_told,
    gate_of,
    limits_of,
    packed,
    plain_json,
    streamed,
)
from percuss.web.workers import Halt

if TYPE_CHECKING:
    from collections.abc import Sequence

    from percuss.case import Case
    from percuss.explore import Sweep
    from percuss.explore.cells import SweepJob
    from percuss.explore.diagrams.diagram_job import DiagramJob
    from percuss.explore.family import Axis
    from percuss.web.settings import Limits
    from percuss.web.workers import Halt, Part


router = APIRouter(route_class=StrictRoute)


@router.post("/api/quick", summary="Steady motions while a slider moves", responses=PROBLEMS)
async def quick(request: Request, asked: QuickAsked) -> Response:
    """Phases, both criteria, figures in SI; without proofs and integrals."""

    harmonics = limits_of(request).harmonics
    every = asked.multipliers or not request.app.state.kernels.work("multipliers")  # it takes longer, but no kernels

    def answer(case: Case) -> dict[str, Any]:
        if case.tables.body is not None:
            return quick_structure_dict(case, asked.periods)
        return quick_dict(case, asked.periods, asked.curve, asked.modes, every)

    def work(case: Case, _: Halt) -> dict[str, Any]:
        if asked.values is None:
            return answer(case)
        moved = placed(case, asked.values, harmonics)
        return {**answer(moved), "tables": json_tables(moved)}

    return plain_json(await answer_of(request, asked, work, quick=True))


@router.post("/api/steady", summary="What percuss steady --json answers", responses=PROBLEMS)
async def steady(request: Request, asked: SteadyAsked) -> Response:
    """Every steady motion, with proofs, energies and figures in SI."""
    periods, limits = tuple(sorted(set(asked.periods))), limits_of(request)

    def work(case: Case, _: Halt) -> dict[str, Any]:
        check_steady(case.system(), periods, asked.modes, limits)
        if case.tables.body is not None:
            return structure_answer(case, periods, asked.modes).to_json_dict()
        return steady_answer(case, periods, asked.modes).to_json_dict()

    return plain_json(await answer_of(request, asked, work))


@router.post("/api/curves", summary="v_f, the load, and the branches over the load factor", responses=PROBLEMS)
async def curves(request: Request, asked: CurvesAsked) -> Response:
    """For the φ curve, the waveform criterion and the bifurcation diagram of the closed form."""
    factors = asked.load_factor
    if factors is not None and not factors[0] < factors[1]:
        raise refused(422, "expected a range from a lower to a higher value", "", "load_factor", factors)

    def work(case: Case, _: Halt) -> dict[str, Any]:
        return curves_dict(case, asked.periods, asked.points, asked.branches, factors, asked.modes)

    return plain_json(await answer_of(request, asked, work, kernels="multipliers"))


@router.post("/api/map", summary="Quantities over a plane of two parameters", response_class=Response, responses=BINARY)
async def plane(request: Request, asked: MapAsked) -> Response:
    """Arrays of shape (len(y), len(x)); over R, the load factor and m within milliseconds."""
    limits = limits_of(request)
    x, y = axis_of(asked.x, "x"), axis_of(asked.y, "y")
    lane = gate_of(request).quick
    case = await lane.run(request, limits.seconds, lambda _: case_asked(asked, limits.harmonics))
    kernels = kernels_of(case, asked.quantities)
    return binary(
        await answer_of(request, asked, lambda case, halt: _map(case, x, y, asked, limits, halt), kernels=kernels)
    )


@router.post("/api/boundaries", summary="Fold and flip curves in a plane", responses=PROBLEMS)
async def boundary_curves(request: Request, asked: BoundariesAsked) -> Response:
    """Each point solved for as a root; null where a curve has none."""
    limits = limits_of(request)
    x = axis_of(asked.x, "x")
    if len(x) > limits.boundary_points:
        raise refused(422, f"expected at most {limits.boundary_points} values", "", "x.count", len(x))
    return plain_json(await answer_of(request, asked, lambda case, halt: _boundaries(case, x, asked, halt)))


def axis_of(asked: AxisAsked, key: str) -> Axis:
    """The axis of a map."""
    from percuss.explore.family import Axis

    if asked.values is not None:
        if (asked.from_, asked.to, asked.count) != (None, None, None):
            raise refused(422, "expected either values, or from, to and count", "", f"{key}.values")
        return Axis(asked.name, np.asarray(asked.values), asked.unit)
    if asked.from_ is None or asked.to is None or asked.count is None:
        raise refused(422, "expected from, to and count, or values", "", key)
    return Axis.linear(asked.name, asked.from_, asked.to, asked.count, asked.unit)


def kernels_of(case: Case, quantities: Sequence[str]) -> Part | None:
    """The kernels without which a map of a case cannot be made."""
    from percuss.explore.quantities import MACHINE_QUANTITIES, QUANTITIES, checked, needs

    known = MACHINE_QUANTITIES if case.is_machine else QUANTITIES
    groups = needs(checked(quantities, known), known)
    if "machine" in groups:
        return "machines"
    if groups & {"simulation", "lyapunov", "blow"}:
        return "motions"
    return "multipliers" if "exact" in groups else None


def _map(case: Case, x: Axis, y: Axis, asked: MapAsked, limits: Limits, halt: Halt) -> bytes:
    begun = time.perf_counter()
    job = sweep_job_of(case, [y, x], asked.quantities, periods=asked.periods, modes=asked.modes, impacts=asked.impacts)
    _check_size(job, limits)
    from percuss.explore.sweeps import Sweep

    columns = job.compute(0, job.size, halt)
    if halt():  # then cells are missing
        raise refused(503, "it took too long", "ask for fewer cells")
    return _packed_map(Sweep.shaped(job, columns), x, y, 1e3 * (time.perf_counter() - begun))


def _check_size(job: SweepJob, limits: Limits) -> None:
    from percuss.explore.cells import AXES, fits_plane

    fast = fits_plane(job.family, [axis.name for axis in job.axes], job.quantities)
    most = limits.cells if fast else limits.slow_cells
    if job.size > most:
        over = f"{', '.join(AXES[:-1])} and {AXES[-1]}"
        why = "" if fast else f"; only maps over {over}, of what arrays can tell, may be larger"
        remedy = "use percuss sweep for more"
        raise refused(422, f"expected at most {most} cells in one request{why}", remedy, "x.count", job.size)
    if job.stop.most_impacts > limits.impacts:
        raise refused(422, f"expected at most {limits.impacts}", "", "impacts", job.stop.most_impacts)


def _packed_map(found: Sweep, x: Axis, y: Axis, milliseconds: float) -> bytes:
    from percuss.explore.quantities import CELL_OUTCOMES

    arrays, about = {}, {}
    for name in ("outcome", *found.quantities):
        values, words = found[name], found.words.get(name)
        if values.dtype.kind == "U":  # labels: as numbers of their words
            texts, numbers = np.unique(values, return_inverse=True)
            words, values = tuple(texts.tolist()), numbers.reshape(values.shape).astype(np.int16)
        column = found.columns.get(name)
        about[name] = {
            "unit": column.unit if column else "",
            "meaning": column.meaning if column else "",
            "words": None if words is None else list(words),
        }
        arrays[name] = values
    header = {
        "x": {"name": x.name, "unit": x.unit, "values": x.values.tolist()},
        "y": {"name": y.name, "unit": y.unit, "values": y.values.tolist()},
        "periods": found.ask.get("periods"),
        "modes": found.ask["modes"],
        "quantities": about,
        "outcomes": list(CELL_OUTCOMES),
        "milliseconds": milliseconds,
    }
    return packed(header, arrays)


def _boundaries(case: Case, x: Axis, asked: BoundariesAsked, halt: Halt) -> dict[str, Any]:
    from percuss.case import CaseFamily
    from percuss.explore import boundaries

    family = CaseFamily(case, {x.name: x.unit} if x.unit else {})
    exact: dict[str, Any] = {"modes": asked.modes} if asked.criterion == "exact" else {}
    found = boundaries(
        family,
        x,
        (asked.y.name, asked.y.from_, asked.y.to),
        asked.periods,
        asked.criterion,
        kinds=tuple(dict.fromkeys(asked.kinds)),
        halt=halt,
        **exact,
    )
    if halt():
        raise refused(503, "it took too long", "ask for fewer values of x")
    return boundaries_dict(found)


# ---- Orbits of any label: searched for, followed through a parameter, and shown where a branch is looked at

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
        sizes: dict[str, Any] = {"unit": asked.unit, "modes": asked.modes, "cycles": asked.cycles}
        sizes |= {"frames": asked.frames, "places": asked.places, "points": asked.end_points}
        start = asked.release if asked.times is None else asked.times
        assert start is not None
        found = branch_frames(case, asked.name, asked.value, start, asked.periods, **sizes)
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
    """A parameter and its range as the command line takes them."""
    if not asked.from_ < asked.to:
        raise refused(422, "expected a range from a lower to a higher value", "", key, [asked.from_, asked.to])
    low, high = (f"{value!r} {asked.unit}".rstrip() for value in (asked.from_, asked.to))
    return f"{asked.name}={low}:{high}"
