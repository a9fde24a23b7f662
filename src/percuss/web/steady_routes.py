"""Steady motions: the quick answer of a slider, the whole one, the curves, maps and boundaries."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Any

import numpy as np
from fastapi import APIRouter
from starlette.requests import Request
from starlette.responses import Response

from percuss.case import steady_answer, structure_answer, sweep_job_of
from percuss.case.answers.quick_answer import boundaries_dict, curves_dict, quick_dict, quick_structure_dict
from percuss.case.file_format.plain_tables import json_tables
from percuss.case.parameters.moves import placed
from percuss.web.questions import AxisAsked, BoundariesAsked, CurvesAsked, MapAsked, QuickAsked, SteadyAsked
from percuss.web.request_bodies import StrictRoute, refused
from percuss.web.shared_by_routes import (
    PROBLEMS,
    answer_of,
    binary,
    case_asked,
    check_steady,
    gate_of,
    limits_of,
    packed,
    plain_json,
)

if TYPE_CHECKING:
    from collections.abc import Sequence

    from percuss.case import Case
    from percuss.explore import Sweep
    from percuss.explore.cells import SweepJob
    from percuss.explore.family import Axis
    from percuss.web.kernel_loading import Part
    from percuss.web.lanes import Halt
    from percuss.web.settings import Limits

router = APIRouter(route_class=StrictRoute)


def bytes_of(what: str, *kinds: str) -> dict[str, Any]:
    """The answer of a route that is not JSON, for the schema."""
    return {
        "description": what,
        "content": {kind: {"schema": {"type": "string", "format": "binary"}} for kind in kinds},
    }


BINARY: dict[int | str, dict[str, Any]] = {
    200: bytes_of("a JSON header and arrays", "application/octet-stream"),
    **PROBLEMS,
}


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
    """The axis of a map.

    Raises
    ------
    Refusal
        When it has neither values nor ends and a number of steps.
    ParameterError
        When its values make no axis.
    """
    from percuss.explore.family import Axis

    if asked.values is not None:
        if (asked.from_, asked.to, asked.count) != (None, None, None):
            raise refused(422, "expected either values, or from, to and count", "", f"{key}.values")
        return Axis(asked.name, np.asarray(asked.values), asked.unit)
    if asked.from_ is None or asked.to is None or asked.count is None:
        raise refused(422, "expected from, to and count, or values", "", key)
    return Axis.linear(asked.name, asked.from_, asked.to, asked.count, asked.unit)


def kernels_of(case: Case, quantities: Sequence[str]) -> Part | None:
    """The kernels without which a map of a case cannot be made.

    Raises
    ------
    ParameterError
        For a quantity that there is not.
    """
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
