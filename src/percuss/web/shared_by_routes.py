"""What all routes share: the place in a lane, the answer as JSON or bytes, the checks that need the case."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, TypeVar

from pydantic_core import PydanticSerializationError, to_json
from starlette.requests import Request
from starlette.responses import Response

from percuss.halting import halting
from percuss.web.asked_cases import case_asked, case_key, is_known
from percuss.web.lanes import Halt
from percuss.web.problem_json import refused

if TYPE_CHECKING:
    from percuss.case import Case
    from percuss.model import System
    from percuss.web.kernel_loading import Kernels, Part
    from percuss.web.lanes import Gate
    from percuss.web.questions import CaseAsked
    from percuss.web.settings import Limits

__all__ = [
    "PROBLEMS",
    "answer_of",
    "attachment",
    "binary",
    "check_steady",
    "compiled",
    "gate_of",
    "limits_of",
    "motion_key",
    "plain_json",
    "simulated_case",
]

T = TypeVar("T")

_FEW = 64
"""Modes and harmonics of a small question."""

_LOOK = 0.25
"""Seconds between two looks at whether the client still waits for the compiler."""

_UNASKED = 256
"""Modes that are reckoned with where none are asked for: then the sums take as many as they need."""

_LOW = 4
"""The highest harmonic of a light one: its level has a handful of roots at most."""

PROBLEMS: dict[int | str, dict[str, Any]] = {
    status: {
        "description": what,
        "content": {"application/json": {"schema": {"$ref": "#/components/schemas/Problems"}}},
    }
    for status, what in {
        400: "not JSON",
        401: "the token is missing or wrong",
        403: "not from this page",
        408: "the body did not come in time",
        413: "too large",
        415: "not application/json",
        422: "cannot be answered: what is wrong, by key",
        429: "busy",
        503: "took too long, or the server stops",
    }.items()
}
"""The answers of every route when it does not answer, for the schema."""


def limits_of(request: Request) -> Limits:
    """The limits of the server."""
    found: Limits = request.app.state.settings.limits
    return found


def gate_of(request: Request) -> Gate:
    """The lanes of this worker."""
    found: Gate = request.app.state.gate
    return found


async def answer_of(
    request: Request,
    asked: CaseAsked,
    work: Callable[[Case, Halt], T],
    *,
    quick: bool = False,
    kernels: Part | None = None,
) -> T:
    """The answer of a piece of work on the case of a request, computed in a thread, once its kernels are loaded.

    A quick one on a small case that needs no kernels is computed at once: handing it to a thread and back would take as
    long again.

    Raises
    ------
    Refusal, PercussError
        See `percuss.web.lanes.Lane.run`, and what the work raises.
    """
    limits = limits_of(request)
    if kernels is not None and not request.app.state.kernels.work(kernels):
        if not is_known(asked):  # a request that is not a case is refused at once
            await gate_of(request).quick.run(request, limits.seconds, lambda _: case_asked(asked, limits.harmonics))
        await compiled(request, kernels)
    if quick and kernels is None and is_small(asked):
        case = case_asked(asked, limits.harmonics)
        if not case.is_machine and is_light(case.system()):
            return work(case, Halt(limits.seconds))
    lane = gate_of(request).quick if quick else gate_of(request).heavy

    def halted(halt: Halt) -> T:
        with halting(halt):
            return work(case_asked(asked, limits.harmonics), halt)

    return await lane.run(request, limits.seconds, halted)


async def compiled(request: Request, part: Part) -> None:
    """Until the kernels of a question are loaded: before it takes a place, and before its time begins.

    Raises
    ------
    Refusal
        503 when the server stops, when the client has left, and when the kernels cannot be had.
    """
    kernels: Kernels = request.app.state.kernels
    async with gate_of(request).waiting():
        while not await kernels.wait(part, _LOOK):
            if await request.is_disconnected():
                raise refused(503, "the client no longer waits for the answer")
    if kernels.failed(part):
        message = "the compiled part of the program, which this needs, could not be loaded here"
        raise refused(503, message, "the server's log says why; steady motions are answered all the same")


def is_small(asked: CaseAsked) -> bool:
    """Whether a case is read in less than a millisecond, and the question asks for little."""
    if getattr(asked, "modes", 0) > _FEW or not {"s", "d"}.isdisjoint(getattr(asked, "values", None) or ()):
        return False
    if asked.machine is not None:
        return is_known(asked)
    load = (asked.case or {}).get("load")
    if not isinstance(load, dict):
        return False
    pairs, numbers = load.get("coefficients", ()), (load.get("harmonic", 1), load.get("harmonics", 1))
    few = all(isinstance(number, int) and number <= _FEW for number in numbers)
    return few and isinstance(pairs, list | tuple) and len(pairs) <= _FEW


def is_light(system: System) -> bool:
    """Whether the steady motions of a system take milliseconds: few of them, and few modes in their sums."""
    if not system.body.is_free:
        return False
    if system.load.is_constant:
        return True
    return bool(system.load.harmonics[-1] <= _LOW) and system.s >= 2.0 and system.d >= 1e-6


def check_steady(system: System, periods: Sequence[int], modes: int | None, limits: Limits) -> None:
    """Refuse steady motions that nobody would wait for: each of them costs a sum over harmonics and modes per period.

    Raises
    ------
    Refusal
        When harmonics × modes × load periods are more than a request may ask for.
    """
    load = system.load
    waves = len(load.breaks) if load.is_piecewise else int(load.harmonics.max(initial=1))
    work = max(waves, 1) * ((_UNASKED if modes is None else modes) + 1) * sum(periods)
    if work > limits.steady_work:
        most = f"at most {limits.steady_work:.0e}"
        message = f"expected harmonics × (modes + 1) × load periods to be {most}; here {work:.1e}"
        raise refused(422, message, "ask for fewer periods at once, or use percuss steady", "periods", list(periods))


def plain_json(tree: Any, status: int = 200) -> Response:
    """A tree of plain values as JSON."""
    try:
        data = to_json(tree)
    except PydanticSerializationError:  # half a surrogate pair, as only a hostile request has it
        data = json.dumps(tree, allow_nan=False, separators=(",", ":")).encode("ascii")
    return Response(data, status, media_type="application/json")


def binary(data: bytes) -> Response:
    """What `percuss.web.packed_arrays.packed` made."""
    return Response(data, media_type="application/octet-stream")


def attachment(data: bytes, name: str, kind: str) -> Response:
    """A file to be kept; `name` is one of ours."""
    return Response(data, media_type=kind, headers={"content-disposition": f'attachment; filename="{name}"'})


def simulated_case(
    case: Case, start: Mapping[str, Any] | None, simulation: Mapping[str, Any] | None, limits: Limits
) -> Case:
    """The case with another start and other keys of [simulation], within the limits.

    Raises
    ------
    Refusal
        When it would take more modes or impacts than one request may.
    CaseError
        When the tables are wrong.
    """
    begin = None if start is None else {key: value for key, value in start.items() if value is not None}
    keys = None if simulation is None else {key: value for key, value in simulation.items() if value is not None}
    changed = case.changed(begin, keys) if begin is not None or keys else case
    found = changed.simulation()
    if found.modes > limits.simulation_modes:
        message = f"expected at most {limits.simulation_modes} in one request"
        raise refused(422, message, "use percuss simulate for more", "simulation.modes", found.modes)
    if found.stop.most_impacts > limits.impacts:
        table = changed.tables.simulation
        if table is not None and table.impacts is not None:
            message = f"expected at most {limits.impacts} in one request"
            raise refused(422, message, "use percuss simulate for more", "simulation.impacts", table.impacts)
        changed = changed.changed(simulation={"impacts": limits.impacts})  # only a time was given
    return changed


def motion_key(asked: CaseAsked, start: Mapping[str, Any] | None, simulation: Mapping[str, Any] | None) -> str:
    """A text that is the same for two requests when they ask for the same simulation."""
    return f"{case_key(asked)} {json.dumps([start, simulation], sort_keys=True)}"
