"""Motions: simulated ones, blows by waves, machines that switch themselves, and random starts as they go."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from starlette.requests import Request
from starlette.responses import Response

from percuss.case import experiment_job_of, simulation_answer
from percuss.case.answers.exploring.exploration import experiment_dict, experiment_progress
from percuss.case.answers.exploring.playback import (
    Frames,
    blow_playback,
    machine_playback,
    motion_playback,
    orbit_playback,
    start_playback,
)
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
from percuss.web.requests import refused
from percuss.web.shared_by_routes import (
    BINARY,
    Attachment,
    Events,
    Memory,
    Questions,
    Tell,
    Terms,
    bytes_of,
    case_asked,
    case_key,
    compiled,
    gate_of,
    limits_of,
    motion_key,
    response_of,
    simulated_case,
)

if TYPE_CHECKING:
    from collections.abc import Mapping

    from percuss.case import Case, SimulationAnswer
    from percuss.case.answers.exploring.exploration import Watched
    from percuss.explore import Experiment
    from percuss.explore.attractors.experiments import ExperimentJob
    from percuss.web.settings import Limits
    from percuss.web.workers import Halt


router = Questions()

NETCDF = {**BINARY, 200: bytes_of("a file of NetCDF", "application/x-netcdf")}

_motions: Memory[SimulationAnswer] = Memory(8, 32_000_000, lambda key, kept: len(key) + kept.motion.states.nbytes)
"""By the bytes of their states."""


@router.answer("/api/simulate", "What percuss simulate --json answers", kernels="motions")
def simulate(case: Case, asked: SimulateAsked, terms: Terms) -> dict[str, Any]:
    """Every impact from a start, and what motion it settles on."""
    return simulated(case, asked, asked.start, asked.simulation, terms).to_json_dict(asked.events)


@router.answer("/api/simulate/file", "A simulated motion as NetCDF", NETCDF, kernels="motions")
def simulate_file(case: Case, asked: SimulateAsked, terms: Terms) -> Attachment:
    """The whole motion, which percuss simulate --resume follows further."""
    motion = simulated(case, asked, asked.start, asked.simulation, terms).motion
    return Attachment(_written("motion.nc", motion.save), "motion.nc", "application/x-netcdf")


def _written(name: str, write: Callable[[Path], object]) -> bytes:
    """What something writes into a file."""
    with tempfile.TemporaryDirectory(prefix="percuss-") as folder:
        path = Path(folder, name)
        write(path)
        return path.read_bytes()


@router.answer(
    "/api/motion",
    "Displacement and strain along the bar over time",
    BINARY,
    kernels=lambda asked: "motions" if asked.orbit is None else None,
)
def motion(case: Case, asked: MotionAsked, terms: Terms) -> Frames:
    """Of a steady motion (`orbit`), or of a simulation."""
    case.system()  # which refuses a machine: it has other pictures
    if asked.orbit is None:
        answer = simulated(case, asked, asked.start, asked.simulation, terms)
        return motion_playback(answer.motion, settled=asked.show == "settled", window=asked.window, **asked.sizes)
    if asked.start is not None or asked.simulation is not None:
        raise refused(422, "expected either a steady motion or a start", "leave out start and simulation", "orbit")
    return orbit_playback(case, asked.orbit, asked.periods, window=asked.window, **asked.sizes)


def simulated(
    case: Case, asked: CaseAsked, start: Mapping[str, Any] | None, simulation: Mapping[str, Any] | None, terms: Terms
) -> SimulationAnswer:
    """The motion of a case from a start; one that was asked for a moment ago is not computed again."""
    key = motion_key(asked, start, simulation)
    known = _motions.find(key)
    if known is not None:
        return known
    answer = simulation_answer(simulated_case(case, start, simulation, terms.limits), terms.halt)
    if answer.motion.outcome == "interrupted":
        raise refused(503, "it took too long", "ask for fewer impacts or modes")
    _motions.put(key, answer)
    return answer


# ---- One blow, resolved by waves: as pictures in time, with the answer of the command line


@router.answer(
    "/api/blow",
    "One blow, resolved by waves",
    BINARY,
    quick=lambda asked: asked.show == "start" and not asked.whole,
    kernels="blows",
)
def blow(case: Case, asked: BlowAsked, terms: Terms) -> Frames:
    """Stress and velocity along striker and tool over time, the force between the faces, and where the energy is."""
    sizes = {"frames": asked.frames, "cells": asked.cells, "most_pieces": terms.limits.pieces}
    return blow_playback(case, asked.show, whole=asked.whole, **sizes)


# ---- A machine that switches its own valve: its cycle over time, with the answer of the command line, and its start-up


@router.answer(
    "/api/machine", "A machine that switches itself", BINARY, quick=lambda asked: not asked.whole and asked.modes == 0
)
def machine(case: Case, asked: MachineAsked, terms: Terms) -> Frames:
    """Position, force and state of the valve over a cycle, or what keeps the machine from running."""
    return machine_playback(case, modes=asked.modes, points=asked.points, whole=asked.whole)


@router.answer("/api/machine/start", "Such a machine from a start", BINARY, quick=True, kernels="machines")
def machine_start(case: Case, asked: MachineStartAsked, terms: Terms) -> Frames:
    """Position, force and state of the valve over the first blows of what percuss simulate follows."""
    case.machine()  # which refuses any other
    found = simulation_answer(simulated_case(case, asked.start, asked.simulation, terms.limits), terms.halt)
    if found.motion.outcome == "interrupted" and terms.halt():
        raise refused(503, "it took too long", "ask for fewer impacts or modes")
    return start_playback(found, asked.blows, asked.points)


# ---- Experiments: random starts, told while they are followed, and the files of what came of them

_experiments: Memory[Experiment] = Memory(
    2, 64_000_000, lambda key, kept: len(key) + sum(column.nbytes for column in kept.columns.values())
)
"""The last ones, as far as they have come: of one that was cancelled the starts that had been followed."""

FILE = {**BINARY, 200: bytes_of("a file", "application/x-netcdf", "text/csv")}


@router.stream("/api/experiment", "Random starts, told as they go", "an experiment", kernels="motions")
def experiment(case: Case, asked: ExperimentAsked, limits: Limits) -> Events:
    """Events ``progress`` with the shares so far, then ``done`` or ``error``; ends when the client leaves."""
    job = _job(case, asked, limits)

    def looks(halt: Halt, tell: Tell) -> None:
        for look in _followed(job, asked, halt):
            tell("progress", look.to_json_dict())
            if look.done == look.size:
                tell("done", experiment_dict(case, look.found))

    return looks


@router.post("/api/experiment/file", summary="An experiment as a file", response_class=Response, responses=FILE)
async def experiment_file(request: Request, asked: ExperimentFileAsked) -> Response:
    """NetCDF or CSV, one row for each start; what was not just computed is computed again, with the same numbers."""
    limits, gate = limits_of(request), gate_of(request)
    await compiled(request, "motions")

    def work(halt: Halt) -> Response:
        from percuss.atomic_write import write_dataset
        from percuss.explore.jobs.archive_export import write_csv

        most = min(asked.first or asked.starts, asked.starts)
        known = _experiments.find(_key(asked))
        if known is None or len(known) < most:
            job = _job(case_asked(asked, limits.harmonics), asked, limits)
            for look in _followed(job, asked, halt, most):
                known = look.found
        if known is None or len(known) < most:
            raise refused(503, "it took too long", "ask for fewer starts")
        if len(known) > most:
            known = replace(known, columns={name: values[:most] for name, values in known.columns.items()})
        name, csv = f"experiment.{asked.format}", asked.format == "csv"
        data = _written(name, partial(write_csv if csv else write_dataset, known.to_xarray()))
        return response_of(Attachment(data, name, "text/csv; charset=utf-8" if csv else "application/x-netcdf"))

    return await gate.experiments.run(request, limits.experiment_seconds, work)


def _job(case: Case, asked: ExperimentAsked, limits: Limits) -> ExperimentJob:
    """The job of a request, within the limits."""
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
    return job


def _key(asked: ExperimentAsked) -> str:
    return f"{case_key(asked)} {[asked.starts, asked.distribution, asked.seed, asked.modes, asked.impacts]}"


def _followed(job: ExperimentJob, asked: ExperimentAsked, halt: Halt, most: int | None = None) -> Iterator[Watched]:
    """Looks at the starts, or at the first of them, as they are followed; what has been followed is kept."""
    for look in experiment_progress(job, halt, most):
        _experiments.put(_key(asked), look.found)  # it may be stopped before the next look
        yield look
