"""Experiments: random starts, told while they are followed, and the files of what came of them."""

from __future__ import annotations

import tempfile
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from fastapi import APIRouter
from starlette.requests import Request
from starlette.responses import Response

from percuss.case import experiment_job_of
from percuss.case.answers.exploration import experiment_dict, watched_experiment
from percuss.web.questions import ExperimentAsked, ExperimentFileAsked
from percuss.web.request_bodies import StrictRoute, refused
from percuss.web.shared_by_routes import (
    STREAM,
    Memory,
    Tell,
    attachment,
    case_asked,
    case_key,
    compiled,
    failures_told,
    gate_of,
    limits_of,
    streamed,
)
from percuss.web.steady_routes import BINARY, bytes_of

if TYPE_CHECKING:
    from percuss.case import Case
    from percuss.explore import Experiment
    from percuss.explore.attractors.experiments import ExperimentJob
    from percuss.web.lanes import Halt
    from percuss.web.settings import Limits

router = APIRouter(route_class=StrictRoute)

_experiments: Memory[Experiment] = Memory(
    2, 64_000_000, lambda key, kept: len(key) + sum(column.nbytes for column in kept.columns.values())
)
"""The last ones, as far as they have come: of one that was cancelled the starts that had been followed."""

FILE = {**BINARY, 200: bytes_of("a file", "application/x-netcdf", "text/csv")}


@router.post("/api/experiment", summary="Random starts, told as they go", response_class=Response, responses=STREAM)
async def experiment(request: Request, asked: ExperimentAsked) -> Response:
    """Events ``progress`` with the shares so far, then ``done`` or ``error``; ends when the client leaves."""
    limits, gate = limits_of(request), gate_of(request)
    case, job = await gate.quick.run(request, limits.seconds, lambda _: _job(asked, limits))
    await compiled(request, "motions")

    def work(halt: Halt, tell: Tell) -> None:
        _follow(case, job, asked, halt, tell)

    return await streamed(request, gate.experiments, limits.experiment_seconds, work)


@router.post("/api/experiment/file", summary="An experiment as a file", response_class=Response, responses=FILE)
async def experiment_file(request: Request, asked: ExperimentFileAsked) -> Response:
    """NetCDF or CSV, one row for each start; what was not just computed is computed again, with the same numbers."""
    limits, gate = limits_of(request), gate_of(request)
    await compiled(request, "motions")

    def work(halt: Halt) -> bytes:
        most = min(asked.first or asked.starts, asked.starts)
        known = _experiments.find(_key(asked))
        if known is None or _size(known) < most:
            case, job = _job(asked, limits)
            known = _follow(case, job, asked, halt, lambda kind, what: None, most)
        if known is None or _size(known) < most:
            raise refused(503, "it took too long", "ask for fewer starts")
        return _file(_first(known, most), asked.format)

    lane, seconds = gate.experiments, limits.experiment_seconds
    kind = "text/csv; charset=utf-8" if asked.format == "csv" else "application/x-netcdf"
    return attachment(await lane.run(request, seconds, work), f"experiment.{asked.format}", kind)


def _job(asked: ExperimentAsked, limits: Limits) -> tuple[Case, ExperimentJob]:
    """The job of a request, within the limits."""
    case = case_asked(asked, limits.harmonics)
    most = case.simulation().stop.most_impacts
    impacts = min(most, limits.impacts) if asked.impacts is None else asked.impacts
    job = experiment_job_of(case, asked.starts, asked.distribution, asked.seed, modes=asked.modes, impacts=impacts)
    if job.modes > limits.simulation_modes:
        message = f"expected at most {limits.simulation_modes} in one request"
        raise refused(422, message, "give modes", "modes", job.modes)
    work = asked.starts * impacts * (job.modes + 1)
    if work > limits.start_work:
        message = f"expected starts × impacts × (modes + 1) to be at most {limits.start_work:.0e}; here {work:.1e}"
        raise refused(422, message, "take fewer, or use percuss experiment", "starts", asked.starts)
    return case, job


def _key(asked: ExperimentAsked) -> str:
    return f"{case_key(asked)} {[asked.starts, asked.distribution, asked.seed, asked.modes, asked.impacts]}"


def _size(found: Experiment) -> int:
    """How many starts have been followed."""
    return len(found)


def _first(found: Experiment, most: int) -> Experiment:
    """The first starts of an experiment as one of its own."""
    if _size(found) == most:
        return found
    return replace(found, columns={name: values[:most] for name, values in found.columns.items()})


def _follow(
    case: Case, job: ExperimentJob, asked: ExperimentAsked, halt: Halt, tell: Tell, most: int | None = None
) -> Experiment | None:
    """Follow the starts, or the first of them, telling how far it is; the experiment, or None when it was stopped."""
    with failures_told(tell, "an experiment"):
        for look in watched_experiment(job, halt, most):
            _experiments.put(_key(asked), look.found)  # it may be stopped before the next look
            tell("progress", look.to_json_dict())
            if look.is_done:
                tell("done", experiment_dict(case, look.found))
                return look.found
    return None


def _file(found: Experiment, kind: str) -> bytes:
    from percuss.explore.jobs.archive_export import write_csv, write_netcdf

    with tempfile.TemporaryDirectory(prefix="percuss-") as folder:
        path = Path(folder, f"experiment.{kind}")
        (write_csv if kind == "csv" else write_netcdf)(found.dataset, path)
        return path.read_bytes()
