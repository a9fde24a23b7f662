"""Motions: simulated ones, blows by waves, machines that switch themselves, and random starts as they go."""

from __future__ import annotations

import tempfile
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fastapi import APIRouter
from starlette.requests import Request
from starlette.responses import Response

from percuss.case import experiment_job_of, simulation_answer
from percuss.case.answers.exploring.exploration import experiment_dict, watched_experiment
from percuss.case.answers.playback import blow_frames, machine_frames, motion_frames, orbit_frames, start_frames
from percuss.web.questions import (
    BlowAsked,
    CaseAsked,
    ExperimentAsked,
    ExperimentFileAsked,
    MachineAsked,
    MachineStartAsked,
    MotionAsked,
    SimulateAsked,
)
from percuss.web.requests import StrictRoute, refused
from percuss.web.shared_by_routes import (
    BINARY,
    PROBLEMS,
    STREAM,
    Memory,
    Tell,
    answer_of,
    attachment,
    binary,
    bytes_of,
    case_asked,
    case_key,
    compiled,
    failures_told,
    gate_of,
    limits_of,
    motion_key,
    packed,
    plain_json,
    simulated_case,
    streamed,
)

if TYPE_CHECKING:
    from collections.abc import Mapping

    from percuss.case import Case, SimulationAnswer
    from percuss.explore import Experiment
    from percuss.explore.attractors.experiments import ExperimentJob
    from percuss.web.settings import Limits
    from percuss.web.workers import Halt


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
    """The motion of a case from a start; one that was asked for a moment ago is not computed again."""
    key = motion_key(asked, start, simulation)
    known = _motions.find(key)
    if known is not None:
        return known
    case.system()  # which refuses a machine: it has other pictures
    answer = simulation_answer(simulated_case(case, start, simulation, limits), halt)
    if answer.motion.outcome == "cancelled":
        raise refused(503, "it took too long", "ask for fewer impacts or modes")
    _motions.put(key, answer)
    return answer


# ---- One blow, resolved by waves: as pictures in time, with the answer of the command line


@router.post("/api/blow", summary="One blow, resolved by waves", response_class=Response, responses=BINARY)
async def blow(request: Request, asked: BlowAsked) -> Response:
    """Stress and velocity along striker and tool over time, the force between the faces, and where the energy is."""

    sizes = {"frames": asked.frames, "cells": asked.cells, "most_pieces": limits_of(request).pieces}

    def work(case: Case, _: Halt) -> bytes:
        found = blow_frames(case, asked.show, whole=asked.whole, **sizes)
        return packed(found.header, found.arrays)

    short = asked.show == "start" and not asked.whole
    return binary(await answer_of(request, asked, work, quick=short, kernels="blows"))


# ---- A machine that switches its own valve: its cycle over time, with the answer of the command line, and its start-up


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
        case.machine()  # which refuses any other
        found = simulation_answer(simulated_case(case, asked.start, asked.simulation, limits), halt)
        if found.motion.outcome == "cancelled" and halt():
            raise refused(503, "it took too long", "ask for fewer impacts or modes")
        frames = start_frames(found, asked.blows, asked.points)
        return packed(frames.header, frames.arrays)

    return binary(await answer_of(request, asked, work, quick=True, kernels="machines"))


# ---- Experiments: random starts, told while they are followed, and the files of what came of them

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
