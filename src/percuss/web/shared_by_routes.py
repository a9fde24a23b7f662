"""What all routes share: the place in a lane, the answer as JSON or bytes, the checks that need the case."""

from __future__ import annotations

import asyncio
import json
import logging
import struct
import threading
from collections import OrderedDict
from collections.abc import AsyncIterator, Awaitable, Callable, Hashable, Iterator, Mapping, Sequence
from concurrent.futures import Future
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Generic, NamedTuple, TypeVar

import numpy as np
import numpy.typing as npt
from fastapi import APIRouter
from pydantic_core import PydanticSerializationError, to_json
from starlette.requests import Request
from starlette.responses import Response, StreamingResponse

from percuss.case.answers.exploring.playback import Frames
from percuss.case.case import case_of
from percuss.case.catalogue.sample_cases import is_sample, load_case
from percuss.case.file_format.reading import parsed
from percuss.errors import CaseError, PercussError
from percuss.halting import halting
from percuss.web.requests import StrictRoute, problem, problems_of, refused
from percuss.web.workers import Halt, told_when_done

if TYPE_CHECKING:
    from starlette.types import Receive, Scope, Send

    from percuss.case import Case
    from percuss.model import System
    from percuss.web.questions import CaseAsked
    from percuss.web.settings import Limits
    from percuss.web.workers import Admission, Kernels, Lane, Part


# ---- From a request to its case; a case that was asked for a moment ago is not read again

T = TypeVar("T")
Work = TypeVar("Work", bound=Callable[..., Any])

MOST_MODES = 256  # of a structure that is told by a table of its modes


class Memory(Generic[T]):
    """The last few answers, bounded in number and in size; safe for threads."""

    def __init__(self, most: int, size: float, size_of: Callable[[Any, T], float]) -> None:
        self._most, self._room, self._size_of = most, size, size_of
        self._kept: OrderedDict[Hashable, T] = OrderedDict()
        self._sizes: dict[Hashable, float] = {}
        self._lock = threading.Lock()

    def get(self, key: Hashable, make: Callable[[], T]) -> T:
        """What is kept for a key, else what `make` gives."""
        with self._lock:
            if key in self._kept:
                self._kept.move_to_end(key)
                return self._kept[key]
        made = make()
        self.put(key, made)
        return made

    def put(self, key: Hashable, value: T) -> None:
        """Keep a value, and let the oldest go."""
        with self._lock:
            self._forget(key)
            size = self._size_of(key, value)
            while self._kept and (len(self._kept) >= self._most or size > self._room):
                self._forget(next(iter(self._kept)))
            if size <= self._room:
                self._kept[key], self._sizes[key] = value, size
                self._room -= size

    def _forget(self, key: Hashable) -> None:
        if key in self._kept:
            del self._kept[key]
            self._room += self._sizes.pop(key)

    def find(self, key: Hashable) -> T | None:
        """What is kept for a key."""
        with self._lock:
            return self._kept.get(key)


_cases: Memory[Case] = Memory(64, 1_000_000, lambda key, _: len(key))
"""By the characters of their requests; what is made of these takes some thirty times as many bytes."""


def case_key(asked: CaseAsked) -> str:
    """A text that is the same for two requests when they ask for the same case."""
    if asked.machine is not None:
        return f"machine {asked.machine}"
    if asked.toml is not None:
        return f"toml {asked.toml}"
    return f"case {json.dumps(asked.case, sort_keys=True)}"


def case_asked(asked: CaseAsked, harmonics: int) -> Case:
    given = [name for name in ("case", "toml", "machine") if getattr(asked, name) is not None]
    if len(given) != 1:
        raise refused(422, "expected exactly one of case, toml and machine", "", given[1] if given else "case")
    return _cases.get(case_key(asked), lambda: _made(asked, harmonics))


def is_known(asked: CaseAsked) -> bool:
    """Whether the case of a request was read a moment ago."""
    return _cases.find(case_key(asked)) is not None


def _made(asked: CaseAsked, harmonics: int) -> Case:
    if asked.machine is not None:
        if not is_sample(asked.machine):
            remedy = "GET /api/machines lists them"
            raise CaseError("machine", "machine", asked.machine, "no machine of this name", remedy)
        case = load_case(asked.machine)
    elif asked.toml is not None:
        if "\0" in asked.toml:
            raise CaseError("case", "toml", None, "is not text")
        case = case_of(parsed(asked.toml, "case"), harmonics=harmonics)
    else:
        assert asked.case is not None
        case = case_of(asked.case, harmonics=harmonics)
    table = case.tables.body
    if table is not None and len(table.omega or ()) > MOST_MODES:
        remedy = "leave out the highest, or use the command line"
        raise CaseError(case.file, "body.omega", len(table.omega or ()), f"more than {MOST_MODES} modes", remedy)
    _ = case.hammer
    return case


# ---- What all routes share: the place in a lane, the answer as JSON or bytes, the checks that need the case

_FEW = 64  # modes and harmonics of a small question
_LOOK = 0.25  # seconds between two looks at whether the client still waits for the compiler
_UNASKED = 256  # modes that are reckoned with where none are asked for: then the sums take as many as they need
_LOW = 4  # the highest harmonic of a light one: its level has a handful of roots at most
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


def limits_of(request: Request) -> Limits:
    found: Limits = request.app.state.settings.limits
    return found


def gate_of(request: Request) -> Admission:
    found: Admission = request.app.state.gate
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
    """
    limits = limits_of(request)
    if kernels is not None and not request.app.state.kernels.work(kernels):
        if not is_known(asked):  # a request that is not a case is refused at once
            await gate_of(request).quick.run(request, limits.seconds, lambda _: case_asked(asked, limits.harmonics))
        await compiled(request, kernels)
    if quick and kernels is None and is_small(asked):
        case = case_asked(asked, limits.harmonics)
        if not case.is_machine and is_light(case.system()):
            async with gate_of(request).quick.place(limits.seconds) as halt:
                return work(case, halt)
    lane = gate_of(request).quick if quick else gate_of(request).heavy

    def halted(halt: Halt) -> T:
        with halting(halt):
            return work(case_asked(asked, limits.harmonics), halt)

    return await lane.run(request, limits.seconds, halted)


async def compiled(request: Request, part: Part) -> None:
    """Until the kernels of a question are loaded: before it takes a place, and before its time begins."""
    kernels: Kernels = request.app.state.kernels
    async with gate_of(request).waiting():
        while not await kernels.wait(part, _LOOK):
            if await request.is_disconnected():
                raise refused(503, "the client no longer waits for the answer")
    if kernels.failed(part):
        message = "the compiled part of the program, which this needs, could not be loaded here"
        raise refused(503, message, "the server's log says why; steady motions are answered all the same")


@dataclass(frozen=True)
class Terms:
    """On what terms a question is answered: the limits, what stops the work, and the kernels that are there."""

    limits: Limits
    halt: Halt
    kernels: Kernels


class Questions(APIRouter):
    """Routes that are the model of a question and a piece of work on its case."""

    def __init__(self) -> None:
        super().__init__(route_class=StrictRoute)

    def answer(
        self,
        path: str,
        summary: str,
        answers: Any = None,
        *,
        quick: bool | Callable[[Any], bool] = False,
        kernels: Part | Callable[[Any], Part | None] | None = None,
    ) -> Callable[[Work], Work]:
        """A route that answers with what ``work(case, asked, terms)`` gives."""

        def put(work: Work) -> Work:
            async def route(request: Request, asked: Any) -> Response:
                limits, compiled_parts = limits_of(request), request.app.state.kernels
                return await answer_of(
                    request,
                    asked,
                    lambda case, halt: response_of(work(case, asked, Terms(limits, halt, compiled_parts))),
                    quick=quick(asked) if callable(quick) else quick,
                    kernels=kernels(asked) if callable(kernels) else kernels,
                )

            self._add(path, summary, work, route, answers or PROBLEMS)
            return work

        return put

    def stream(
        self, path: str, summary: str, what: str, kernels: Part | Callable[[Any], Part | None]
    ) -> Callable[[Work], Work]:
        """A route of events, from ``prepare(case, asked, limits)``, which refuses before the stream begins."""

        def put(prepare: Work) -> Work:
            async def route(request: Request, asked: Any) -> Response:
                limits, gate = limits_of(request), gate_of(request)
                begin = await gate.quick.run(
                    request, limits.seconds, lambda _: prepare(case_asked(asked, limits.harmonics), asked, limits)
                )
                part = kernels(asked) if callable(kernels) else kernels
                if part is not None:
                    await compiled(request, part)

                def follow(halt: Halt, tell: Tell) -> None:
                    with failures_told(tell, what):
                        begin(halt, tell)

                return await streamed(request, gate.experiments, limits.experiment_seconds, follow)

            self._add(path, summary, prepare, route, STREAM)
            return prepare

        return put

    def _add(self, path: str, summary: str, work: Callable[..., Any], route: Any, answers: Any) -> None:
        asked = work.__annotations__["asked"]
        asked = work.__globals__[asked] if isinstance(asked, str) else asked
        route.__annotations__ = {"request": Request, "asked": asked, "return": Response}
        route.__name__, route.__doc__ = work.__name__, work.__doc__
        kind: dict[str, Any] = {} if answers is PROBLEMS else {"response_class": Response}
        self.post(path, summary=summary, responses=answers, **kind)(route)


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
    few_modes = (
        system.d >= 1e-6 or not system.contact.keeps_strain
    )  # the sums of a released strain are of a fixed length
    return bool(system.load.harmonics[-1] <= _LOW) and system.s >= 2.0 and few_modes


def check_steady(system: System, periods: Sequence[int], modes: int | None, limits: Limits) -> None:
    """Refuse steady motions that nobody would wait for: each costs a sum over harmonics and modes per period."""
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


class Attachment(NamedTuple):
    """A file to be kept; `name` is one of ours."""

    data: bytes
    name: str
    kind: str


def response_of(found: Any) -> Response:
    """What a question is answered with: arrays, a file, or else JSON."""
    if isinstance(found, Frames):
        return Response(packed(found.header, found.arrays), media_type="application/octet-stream")
    if isinstance(found, Attachment):
        kept = {"content-disposition": f'attachment; filename="{found.name}"'}
        return Response(found.data, media_type=found.kind, headers=kept)
    return plain_json(found)


def simulated_case(
    case: Case, start: Mapping[str, Any] | None, simulation: Mapping[str, Any] | None, limits: Limits
) -> Case:
    """The case with another start and other keys of [simulation], within the limits."""
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


# ---- Arrays on their way to the page: a short JSON header and then the numbers as they lie in memory

_KINDS = {"f": "<f4", "b": "|u1", "u": "|u1", "i": "<i2"}  # what each kind of numpy's travels as


def packed(header: Mapping[str, Any], arrays: Mapping[str, npt.NDArray[Any]]) -> bytes:
    """Header and arrays as one byte string: the length of the header in 4 bytes, the header, the arrays."""
    # Everything is little endian; the header is padded so that every array begins at a multiple of 8. Numbers beyond 32
    # bits become infinite, whole numbers are clipped to 16 bits, truth values are 0 and 1.
    parts: list[bytes] = []
    told: list[dict[str, Any]] = []
    offset = 0
    for name, values in arrays.items():
        kind = _KINDS[values.dtype.kind]
        given = np.clip(values, -32768, 32767) if kind == "<i2" else values
        with np.errstate(over="ignore"):
            raw = np.ascontiguousarray(given, dtype=kind).tobytes()
        told.append({"name": name, "dtype": kind[1:], "shape": list(values.shape), "offset": offset, "bytes": len(raw)})
        room = -len(raw) % 8
        parts += [raw, b"\0" * room]
        offset += len(raw) + room
    text = json.dumps({**header, "arrays": told}, allow_nan=False, ensure_ascii=False).encode()
    text += b" " * (-(4 + len(text)) % 8)
    return b"".join([struct.pack("<I", len(text)), text, *parts])


# ---- Long computations told while they go on: server-sent events from a thread, until the last or the client leaves

Tell = Callable[[str, Any], None]  # sends an event: its name, and what it says
Events = Callable[["Halt", Tell], object]  # the work that a stream tells of

DRAWING = threading.Lock()  # matplotlib's settings belong to the whole process: one picture at a time

_PING = 1.0  # seconds of silence after which a comment is sent: writing is how a closed connection shows

_LOOK_AFTER = 0.1  # seconds between two looks at whether the client is still there, and the server not ending

_log = logging.getLogger("percuss.web")

STREAM: dict[int | str, dict[str, Any]] = {
    200: {"description": "server-sent events", "content": {"text/event-stream": {"schema": {"type": "string"}}}},
    **PROBLEMS,
}


async def streamed(request: Request, lane: Lane, seconds: float, work: Callable[[Halt, Tell], object]) -> _Stream:
    """The events that a piece of work tells, the last one ``done`` or ``error``; it stops when the client leaves."""
    place = lane.place(seconds)
    halt = await place.__aenter__()  # a refusal must come before the stream begins
    events: asyncio.Queue[tuple[str, Any]] = asyncio.Queue()
    loop = asyncio.get_running_loop()

    def tell(kind: str, what: Any) -> None:
        if not halt.over:
            loop.call_soon_threadsafe(events.put_nowait, (kind, what))

    running = lane.submit(lambda: work(halt, tell))

    async def end() -> None:
        halt.stop()
        lane.hold(running)
        await place.__aexit__(None, None, None)

    return _Stream(_told(request, events, running, halt), end)


@contextmanager
def failures_told(tell: Tell, what: str) -> Iterator[None]:
    """What goes wrong in the block is the event ``error``; what nobody foresaw is logged besides."""
    try:
        yield
    except Exception as error:
        tell("error", {"problems": problems_of(error)})
        if not isinstance(error, PercussError):
            _log.exception("%s failed", what)


class _Stream(StreamingResponse):
    """Events, and what must be done when they have ended, even when the client left before the first."""

    def __init__(self, events: AsyncIterator[bytes], end: Callable[[], Awaitable[None]]) -> None:
        headers = {"cache-control": "no-store", "x-accel-buffering": "no"}
        super().__init__(events, media_type="text/event-stream", headers=headers)
        self._end = end

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        try:
            await super().__call__(scope, receive, send)
        finally:
            await self._end()


async def _told(
    request: Request, events: asyncio.Queue[tuple[str, Any]], running: Future[Any], halt: Halt
) -> AsyncIterator[bytes]:
    """The events as text, until the last one or until the client leaves."""
    yield b": begun\n\n"
    ended, silent = told_when_done(running), 0.0  # by the loop, behind all that the work has told
    while True:
        try:
            kind, what = await asyncio.wait_for(events.get(), _LOOK_AFTER)
        except TimeoutError:
            silent += _LOOK_AFTER
            if await request.is_disconnected():
                return
            if halt.over:  # here is the loop, which waits for nobody
                late = problem("", None, "it took too long" if halt.late else "the server is stopping", "take fewer")
                yield _event("error", {"problems": [late]})
                return
            if ended.is_set() and events.empty():
                return
            if silent >= _PING:
                silent = 0.0
                yield b": still here\n\n"
            continue
        silent = 0.0
        yield _event(kind, what)
        if kind in ("done", "error"):
            return


def _event(kind: str, what: Any) -> bytes:
    return f"event: {kind}\ndata: {json.dumps(what, allow_nan=False)}\n\n".encode()
