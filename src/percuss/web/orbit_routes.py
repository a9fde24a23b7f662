"""Steady motions, their curves, maps and boundaries; orbits of any label, followed through a parameter."""

from __future__ import annotations

import math
import time
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from starlette.requests import Request
from starlette.responses import Response

from percuss.case import (
    CaseFamily,
    branch_answer,
    diagram_job_of,
    orbits_answer,
    rest_cycles_answer,
    steady_answer,
    sweep_job_of,
    uncertainty_of,
)
from percuss.case.answers.exploring.diagram_answer import diagram_dict, diagram_progress
from percuss.case.answers.exploring.orbits_answer import (
    begun_at,
    branch_dict,
    curve_dict,
    is_rest_label,
    orbits_dict,
    parsed_label,
    rest_cycles_dict,
)
from percuss.case.answers.exploring.playback import Frames, branch_playback
from percuss.case.answers.exploring.point_curves_answer import curves_progress
from percuss.case.answers.exploring.quick_answer import boundaries_dict, curves_dict, quick_dict, quick_structure_dict
from percuss.case.case import json_tables
from percuss.case.parameters.moves import placed
from percuss.halting import halting
from percuss.model.checks import at_once
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
from percuss.web.requests import refused
from percuss.web.shared_by_routes import (
    BINARY,
    Events,
    Questions,
    Tell,
    Terms,
    answer_of,
    case_asked,
    check_steady,
    gate_of,
    limits_of,
    response_of,
)
from percuss.web.workers import Halt

if TYPE_CHECKING:
    from collections.abc import Sequence

    from percuss.case import Case
    from percuss.explore import Sweep
    from percuss.explore.cells import SweepJob
    from percuss.explore.family import Axis
    from percuss.web.settings import Limits
    from percuss.web.workers import Halt, Part


router = Questions()


@router.answer("/api/quick", "Steady motions while a slider moves", quick=True)
def quick(case: Case, asked: QuickAsked, terms: Terms) -> dict[str, Any]:
    """Phases, both criteria, figures in SI; without proofs and integrals."""
    moved = case if asked.values is None else placed(case, asked.values, terms.limits.harmonics)
    if moved.tables.body is not None:
        found = quick_structure_dict(moved, asked.periods)
    else:
        every = asked.multipliers or not terms.kernels.work("multipliers")  # it takes longer, but no kernels
        found = quick_dict(moved, asked.periods, asked.curve, asked.modes, every)
    return found if asked.values is None else {**found, "tables": json_tables(moved, as_given=True)}


@router.answer("/api/steady", "What percuss steady --json answers")
def steady(case: Case, asked: SteadyAsked, terms: Terms) -> dict[str, Any]:
    """Every steady motion, with proofs, energies and figures in SI; once blows can be followed, the rock's share."""
    periods = tuple(sorted(set(asked.periods)))
    check_steady(case.system(), periods, asked.modes, terms.limits)
    answer = steady_answer(case, periods, asked.modes)
    if answer.running:
        known = uncertainty_of(case, asked.modes, answer.running[0].orbit.periods)
        answer = replace(answer, uncertainty=known)
    return (answer if terms.kernels.work("blows") else replace(answer, tool=None)).to_json_dict()


@router.answer("/api/curves", "v_f, the load, and the branches over the load factor", kernels="multipliers")
def curves(case: Case, asked: CurvesAsked, terms: Terms) -> dict[str, Any]:
    """For the φ curve, the waveform criterion and the bifurcation diagram of the closed form."""
    return curves_dict(case, asked.periods, asked.points, asked.branches, asked.load_factor, asked.modes)


@router.post("/api/map", summary="Quantities over a plane of two parameters", response_class=Response, responses=BINARY)
async def plane(request: Request, asked: MapAsked) -> Response:
    """Arrays of shape (len(y), len(x)); over R, the load factor and m within milliseconds."""
    limits = limits_of(request)
    x, y = axis_of(asked.x, "x"), axis_of(asked.y, "y")
    lane = gate_of(request).quick
    case = await lane.run(request, limits.seconds, lambda _: case_asked(asked, limits.harmonics))
    kernels = kernels_of(case, asked.quantities)  # which the case has a say in

    def work(case: Case, halt: Halt) -> Response:
        return response_of(_map(case, x, y, asked, limits, halt))

    return await answer_of(request, asked, work, kernels=kernels)


@router.answer("/api/boundaries", "Fold and flip curves in a plane")
def boundary_curves(case: Case, asked: BoundariesAsked, terms: Terms) -> dict[str, Any]:
    """Each point solved for as a root; null where a curve has none."""
    from percuss.explore import boundaries

    x = axis_of(asked.x, "x")
    if len(x) > terms.limits.boundary_points:
        raise refused(422, f"expected at most {terms.limits.boundary_points} values", "", "x.count", len(x))
    exact: dict[str, Any] = {"modes": asked.modes} if asked.criterion == "exact" else {}
    found = boundaries(
        CaseFamily(case, {x.name: x.unit} if x.unit else {}),
        x,
        (asked.y.name, asked.y.from_, asked.y.to),
        asked.periods,
        asked.criterion,
        kinds=tuple(dict.fromkeys(asked.kinds)),
        progress=lambda _: terms.halt(),
        **exact,
    )
    if terms.halt():
        raise refused(503, "it took too long", "ask for fewer values of x")
    return boundaries_dict(found)


def axis_of(asked: AxisAsked, key: str) -> Axis:
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
    if groups & {"simulation", "lyapunov", "blow", "transfer"}:
        return "motions"
    return "multipliers" if "exact" in groups else None


def _map(case: Case, x: Axis, y: Axis, asked: MapAsked, limits: Limits, halt: Halt) -> Frames:
    begun = time.perf_counter()
    sizes: dict[str, Any] = {"periods": asked.periods, "modes": asked.modes, "impacts": asked.impacts}
    job = replace(sweep_job_of(case, [y, x], asked.quantities, **sizes), workers=at_once(None))
    _check_size(job, limits)
    from percuss.explore.sweeps import Sweep

    columns = job.compute(0, job.size, halt)
    if halt():  # then cells are missing
        raise refused(503, "it took too long", "ask for fewer cells")
    return _packed_map(Sweep.shaped(job, columns), x, y, 1e3 * (time.perf_counter() - begun))


def _check_size(job: SweepJob, limits: Limits) -> None:
    from percuss.explore.cells import fits_plane
    from percuss.explore.parameters import AXES

    fast = fits_plane(job.family, [axis.name for axis in job.axes], job.quantities)
    most = limits.cells if fast else limits.slow_cells
    if job.size > most:
        over = f"{', '.join(AXES[:-1])} and {AXES[-1]}"
        why = "" if fast else f"; only maps over {over}, of what arrays can tell, may be larger"
        remedy = "use percuss sweep for more"
        raise refused(422, f"expected at most {most} cells in one request{why}", remedy, "x.count", job.size)
    if job.stop.most_impacts > limits.impacts:
        raise refused(422, f"expected at most {limits.impacts}", "", "impacts", job.stop.most_impacts)


def _packed_map(found: Sweep, x: Axis, y: Axis, milliseconds: float) -> Frames:
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
    return Frames(header, arrays)


# ---- Orbits of any label: searched for, followed through a parameter, and shown where a branch is looked at

_LABELS = 16  # of the branches in one diagram, at most

_SHARE = 0.7  # of the time of a question, after which what has been followed so far is the answer


@router.answer("/api/orbits", "What percuss orbits --json answers, of one label", kernels="orbits")
def orbits(case: Case, asked: OrbitsAsked, terms: Terms) -> dict[str, Any]:
    """All orbits z=p/n that a search finds, with what may be missing."""
    if is_rest_label(asked.label) and not case.is_machine:
        return rest_cycles_dict(rest_cycles_answer(case, modes=asked.modes), asked.label)
    return orbits_dict(orbits_answer(case, asked.label, modes=asked.modes, tries=asked.tries, seed=asked.seed))


@router.answer("/api/follow", "What percuss follow --json answers", kernels="orbits")
def follow(case: Case, asked: FollowAsked, terms: Terms) -> dict[str, Any]:
    """An orbit followed both ways through a parameter; one that takes too long is answered as far as it has come."""
    along, soon = along_text(asked.along), Halt(_SHARE * terms.limits.seconds)

    def ends(*_: object) -> bool:
        return terms.halt() or soon()

    branch = branch_answer(case, asked.orbit, along, switch=asked.switch, modes=asked.modes, progress=ends)
    return branch_dict(branch, begun=begun_at(case, along))


@router.answer("/api/follow/motion", "The motion at a point of a branch", BINARY, kernels="orbits")
def branch_motion(case: Case, asked: BranchMotionAsked, terms: Terms) -> Frames:
    """Displacement and strain along the bar over whole cycles of an orbit, be it stable or not; as POST /api/motion."""
    if (asked.times is None) == (asked.release is None):
        raise refused(422, "expected either the times of impacts or a release", "", "times", asked.times)
    sizes: dict[str, Any] = {"unit": asked.unit, "modes": asked.modes, **asked.sizes}
    start = asked.release if asked.times is None else asked.times
    assert start is not None
    return branch_playback(case, asked.name, asked.value, start, asked.periods, **sizes)


@router.stream(
    "/api/diagram",
    "All motions over a parameter",
    "a diagram",
    kernels=lambda asked: "motions" if asked.up_to is None else "orbits",
)
def motions_over(case: Case, asked: DiagramAsked, limits: Limits) -> Events:
    """Events ``progress`` with what is found so far, then ``done`` or ``error``; ends when the client leaves."""
    along = f"{along_text(asked.along)}:{asked.values}"
    work = asked.values * (asked.starts + asked.runs) * asked.impacts * (asked.modes + 1)
    if work > limits.start_work:
        message = f"expected values × (starts + runs) × impacts × (modes + 1) to be at most {limits.start_work:.0e}"
        raise refused(422, f"{message}; here {work:.1e}", "take fewer, or use percuss diagram", "values", asked.values)
    if asked.up_to is not None and math.prod(parsed_label(asked.up_to)) > _LABELS:
        message = f"expected a label with at most {_LABELS} up to it"
        raise refused(422, message, "use percuss diagram for more", "up_to", asked.up_to)
    sizes: dict[str, Any] = {"starts": asked.starts, "runs": asked.runs, "modes": asked.modes, "seed": asked.seed}
    sizes |= {"up_to": asked.up_to, "searched": asked.searched, "switch": asked.switch, "tries": asked.tries}
    job = diagram_job_of(case, along, impacts=asked.impacts, **sizes)

    def looks(halt: Halt, tell: Tell) -> None:
        for look in diagram_progress(job, halt):
            tell("done" if look.done == 1.0 else "progress", diagram_dict(case, look))

    return looks


@router.stream("/api/follow/curves", "What happens to an orbit, as curves over a plane", "following points", "orbits")
def curves_over(case: Case, asked: PointCurvesAsked, limits: Limits) -> Events:
    """Events ``progress`` with the curves found so far, then ``done`` or ``error``; ends when the client leaves."""
    across, up = along_text(asked.x), along_text(asked.y)
    if asked.x.name == asked.y.name:
        raise refused(422, "expected two different parameters", "", "y", asked.y.name)

    def looks(halt: Halt, tell: Tell) -> None:
        with halting(halt):
            for share, found in curves_progress(case, asked.orbit, across, up, modes=asked.modes, halt=halt):
                told = {"done": share, "curves": [curve_dict(curve) for curve in found]}
                tell("done" if share == 1.0 else "progress", told)

    return looks


def along_text(asked: AlongAsked) -> str:
    """A parameter and its range as the command line takes them."""
    low, high = (f"{value!r} {asked.unit}".rstrip() for value in (asked.from_, asked.to))
    return f"{asked.name}={low}:{high}"
