"""The workbench against clients that dawdle, crowd, send too much or leave: over sockets of this machine alone."""

from __future__ import annotations

import asyncio
import json
import os
import socket
import sys
import threading
import time
from collections.abc import AsyncIterator, Iterator
from concurrent.futures import Future
from contextlib import asynccontextmanager, contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("fastapi")

import httpx
import uvicorn

from percuss.case import Case, load_case, steady_answer
from percuss.case.case import case_of
from percuss.case.catalogue.sample_cases import sample_names
from percuss.case.file_format.reading import MAX_KEYS, parsed
from percuss.cli import main
from percuss.cli import serve as serve_command
from percuss.errors import CaseError, Interrupted, UnitError
from percuss.halting import halting
from percuss.stability import exact_plane, stability_plane
from percuss.steady import steady_states
from percuss.units import known_dimension, si
from percuss.web import Limits, Settings, shared_by_routes
from percuss.web.application import _File, create_app
from percuss.web.connections import Crowd, neighbourhood, protocol
from percuss.web.requests import CONTENT_SECURITY_POLICY
from percuss.web.serving import bound, to_open
from percuss.web.shared_by_routes import Memory, _cases
from percuss.web.workers import Halt
from web_client import Client, answered, posted

MACHINE = {"machine": "mini-breaker"}
TOKEN = "a-long-secret-word"
ABOUT = b"GET /api/about HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n"
HELD_BACK = (
    b"POST /api/quick HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Type: application/json\r\nContent-Length: 99\r\n\r\n{"
)
UPLOAD = b"POST /api/history?name=x.csv HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Length: %d\r\n\r\n"

Connection = tuple[asyncio.StreamReader, asyncio.StreamWriter]


class Served:
    """A server of this process, and what its clients do."""

    def __init__(self, server: uvicorn.Server, app: Any, port: int) -> None:
        self.server, self.app, self.port = server, app, port

    async def connect(self, *parts: bytes) -> Connection:
        reader, writer = await asyncio.open_connection("127.0.0.1", self.port)
        for part in parts:
            writer.write(part)
        return reader, writer

    async def ask(self, request: bytes) -> int:
        """The status of an answer on a connection of its own."""
        reader, writer = await self.connect(request)
        status, _ = await asyncio.wait_for(answered(reader), 30.0)
        writer.close()
        return status


@asynccontextmanager
async def serving(**limits: Any) -> AsyncIterator[Served]:
    listening = bound("127.0.0.1", 0)
    settings = Settings(port=listening.getsockname()[1], limits=Limits(**limits))
    app = create_app(settings)
    app.app.state.shelf._files["large.js"] = _File.of(b"/" * 5_000_000, ".js")  # more than the buffers on the way hold
    config = uvicorn.Config(app, http=protocol(settings.limits), log_level="error", timeout_graceful_shutdown=1)
    server = uvicorn.Server(config)
    running = asyncio.create_task(server.serve([listening]))
    try:
        yield Served(server, app, settings.port)
    finally:
        server.should_exit = True
        await running


async def left(connection: Connection) -> bytes:
    """What still comes until the server ends the connection, which it must."""
    try:
        return await asyncio.wait_for(connection[0].read(), 60.0)
    except ConnectionError:
        return b""


# -- dawdling -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("request_", "then"),
    [(ABOUT, b"\r\n"), (ABOUT[:-2] + b"Content-Length: 99999\r\n\r\n", b"x"), (ABOUT, b"GET /".ljust(60_000, b"x"))],
    ids=["blank lines", "a body that nobody asked for", "a head without an end"],
)
def test_bytes_between_requests_do_not_put_off_the_end(request_: bytes, then: bytes) -> None:
    """An answered request, and then a byte now and then: the connection ends all the same."""

    async def ask() -> bytes:
        async with serving(head_seconds=0.5, idle_seconds=0.5) as served:
            connection = await served.connect(request_)
            assert (await answered(connection[0]))[0] == 200

            async def trickle() -> None:
                for i in range(400):
                    connection[1].write(then[i : i + 1] or then[-1:])
                    await asyncio.sleep(0.05)

            trickling = asyncio.create_task(trickle())
            rest = await left(connection)
            assert not trickling.done()
            trickling.cancel()
            return rest

    assert asyncio.run(ask()) == b""


async def test_heads_that_do_not_come_are_not_waited_for() -> None:
    """Silent connections, and those whose heads trickle in, are closed; what keeps to the time is answered."""
    async with serving(head_seconds=0.3) as served:
        kept = await served.connect()
        for _ in range(2):  # also the second one on a connection
            kept[1].write(ABOUT)
            assert (await answered(kept[0]))[0] == 200
        silent = [await served.connect() for _ in range(5)]
        for _, writer in (*silent[1:], kept):
            writer.write(b"GET /api/machines HTTP/1.1\r\nX: ")
        assert [await left(one) for one in (*silent, kept)] == [b""] * 6


async def test_a_connection_in_use_is_kept() -> None:
    """Longer than the time of silence, as long as a request comes within it."""
    async with serving(head_seconds=2.0, idle_seconds=2.0) as served:
        reader, writer = await served.connect()
        codes = []
        for _ in range(6):
            writer.write(ABOUT)
            codes.append((await answered(reader))[0])
            await asyncio.sleep(0.5)
        assert codes == [200] * 6


async def test_a_client_that_does_not_read_is_let_go() -> None:
    """Whether its answers wait within the server, or the server has ended them and waits to close."""
    page = b"GET /static/large.js HTTP/1.1\r\nHost: 127.0.0.1\r\n"
    async with serving(write_seconds=0.6, idle_seconds=0.5) as served:
        deaf = []
        for request in (page + b"\r\n", page + b"Connection: close\r\n\r\n", (page + b"\r\n") * 5):
            connection = socket.socket()
            connection.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
            connection.setblocking(False)
            await asyncio.get_running_loop().sock_connect(connection, ("127.0.0.1", served.port))
            await asyncio.get_running_loop().sock_sendall(connection, request)
            deaf.append(connection)
        while len(served.server.server_state.connections) < 3:
            await asyncio.sleep(0.02)
        until = time.monotonic() + 60.0
        while served.server.server_state.connections and time.monotonic() < until:
            await asyncio.sleep(0.05)
        for connection in deaf:
            connection.close()
        assert len(served.server.server_state.connections) == 0


async def test_a_client_that_reads_slowly_gets_all() -> None:
    """In a longer time than one that does not read is given."""
    async with serving(write_seconds=2.0) as served:
        request = b"GET /static/large.js HTTP/1.1\r\nHost: 127.0.0.1\r\nConnection: close\r\n\r\n"
        reader, _ = await served.connect(request)
        length = int((await reader.readuntil(b"\r\n\r\n")).lower().partition(b"content-length: ")[2].split()[0])
        found = 0
        while part := await reader.read(200_000):
            found += len(part)
            await asyncio.sleep(0.15)
        assert length - found == 0


# -- crowding -------------------------------------------------------------------------------------------------------


async def test_silent_connections_do_not_keep_others_out() -> None:
    """Silent ones, half heads, answered ones and bodies held back, many more than there is room for."""
    async with serving(connections=24, connections_per_address=24) as served:
        kinds, crowd, codes = (b"", b"GET / HT", ABOUT, HELD_BACK), [], []
        for i in range(80):
            crowd.append(await served.connect(kinds[i % 4]))
            if i % 20 == 19:
                codes += [await served.ask(ABOUT), await served.ask(posted("/api/quick", MACHINE))]
        assert len(served.server.server_state.connections) <= 25
        for _, writer in crowd:
            writer.close()
        assert codes == [200] * 8


async def test_what_is_told_just_as_the_work_ends_is_not_lost(monkeypatch: pytest.MonkeyPatch) -> None:
    """The work tells its last event and ends while the stream looks whether the client is still there."""
    monkeypatch.setattr(shared_by_routes, "_LOOK_AFTER", 0.01)
    events, running, loop = asyncio.Queue[Any](), Future[None](), asyncio.get_running_loop()

    class Meanwhile:
        async def is_disconnected(self) -> bool:
            if not running.done():
                loop.call_soon_threadsafe(events.put_nowait, ("done", {}))
                running.set_result(None)
            return False

    told: Any = shared_by_routes._told(Meanwhile(), events, running, Halt(60.0))  # type: ignore[arg-type]
    assert [part async for part in told] == [b": begun\n\n", b"event: done\ndata: {}\n\n"]


def test_without_room_the_answer_is_a_refusal_of_ours(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Crowd, "enter", lambda *_: False)

    async def ask() -> bytes:
        async with serving() as served:
            return await left(await served.connect(ABOUT))

    head, _, body = asyncio.run(ask()).partition(b"\r\n\r\n")
    headers = httpx.Headers([tuple(line.split(b": ", 1)) for line in head.split(b"\r\n")[1:]])  # type: ignore[misc]
    assert head.startswith(b"HTTP/1.1 503") and int(headers["retry-after"]) > 0
    assert headers["content-security-policy"] == CONTENT_SECURITY_POLICY and headers["x-frame-options"] == "DENY"
    assert headers["connection"] == "close" and headers["cache-control"] == "no-store"
    assert json.loads(body)["problems"][0]["message"] == "too many connections"


def test_what_is_no_request_is_refused_in_our_form() -> None:
    async def ask() -> list[bytes]:
        async with serving() as served:
            return [
                await left(await served.connect(text)) for text in (b"\x16\x03\x01\r\n\r\n", b"GET / HTTP/9\r\n\r\n")
            ]

    for found in asyncio.run(ask()):
        head, _, body = found.partition(b"\r\n\r\n")
        assert head.startswith(b"HTTP/1.1 400") and b"content-security-policy" in head and json.loads(body)["problems"]


class Visitor:
    """A connection as the crowd sees it."""

    def __init__(self, since: float | None) -> None:
        self.since, self.dismissed = since, False

    def dawdles_since(self) -> float | None:
        return self.since

    def dismiss(self) -> None:
        self.dismissed = True


def test_who_has_kept_the_server_waiting_longest_makes_room() -> None:
    crowd = Crowd(Limits(connections=5, connections_per_address=3))
    first = [Visitor(None), Visitor(7.0), Visitor(2.0)]
    assert all(crowd.enter(one, "10.0.0.1") for one in first)
    assert crowd.enter(Visitor(9.0), "10.0.0.1")  # no room for this address: of its own
    assert [one.dismissed for one in first] == [False, False, True]
    others = [Visitor(1.0), Visitor(None)]
    assert all(crowd.enter(one, "10.0.0.2") for one in others)
    assert crowd.enter(Visitor(9.5), "10.0.0.3")  # no room at all: of everybody's
    assert [one.dismissed for one in (*first, *others)] == [False, False, True, True, False]


def test_who_is_being_answered_is_not_sent_away() -> None:
    crowd = Crowd(Limits(connections=50, connections_per_address=2))
    busy = [Visitor(None), Visitor(None)]
    assert all(crowd.enter(one, "2001:db8::1") for one in busy)
    assert not crowd.enter(Visitor(None), "2001:db8::2")  # the same network, the same client
    assert crowd.enter(Visitor(None), "2001:db8:0:1::1") and not any(one.dismissed for one in busy)
    for one in busy:
        crowd.leave(one)
        crowd.leave(one)
    assert crowd.enter(Visitor(None), "2001:db8::1")
    assert neighbourhood("::ffff:10.0.0.1") == "10.0.0.1" and neighbourhood("fe80::1%eth0") == "fe80::"


# -- bodies ---------------------------------------------------------------------------------------------------------


async def test_uploads_without_a_body_take_no_place() -> None:
    """More of them than there are places; what has come whole is answered meanwhile."""
    async with serving(heavy=1, heavy_waiting=1) as served:
        held = [await served.connect(UPLOAD % 5000, b"x") for _ in range(6)]
        await asyncio.sleep(0.2)
        codes = [await served.ask(posted("/api/steady", MACHINE)), await served.ask(UPLOAD % 4 + b"a,b\n")]
        for _, writer in held:
            writer.close()
        assert codes == [200, 422]


async def test_bodies_that_come_in_are_bounded_together() -> None:
    """The one that began first, and has not come, gives way; what it held does not count any more."""
    async with serving(held_bytes=50_000) as served:
        slow = await served.connect(UPLOAD % 45_000, b"x" * 40_000)
        await asyncio.sleep(0.2)
        whole = [await served.ask(UPLOAD % 30_000 + b"1\n" * 15_000) for _ in range(3)]
        assert [*whole, (await asyncio.wait_for(answered(slow[0]), 60.0))[0]] == [422, 422, 422, 408]


_TABLES: list[Any] = [
    {"case": {f"t{i}": {} for i in range(80_000)}},
    {"case": {"load": {f"k{i}": {} for i in range(80_000)}}},
    {"case": [{"a": 1} for _ in range(80_000)]},
    {"case": {"load": {"coefficients": [0] * 300_000}}},
    {"case": {"bar": {"length": "1 " + "m" * 900_000}}},
    {"case": {"bar": {"m" * 900_000: 1}}},
]


@pytest.mark.parametrize("asked", _TABLES, ids=["tables", "keys", "objects", "numbers", "text", "key"])
def test_what_has_more_keys_than_a_question_is_not_looked_through(asked: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """Refused at the door: no model of ours ever sees it."""
    monkeypatch.setattr("percuss.web.shared_by_routes._made", lambda *_: pytest.fail("it was looked through"))
    problem = Client().problems("/api/quick", asked)[0]
    assert " more than " in f" {problem['message']}"


def test_a_question_may_have_as_many_values_as_a_load_and_a_start_take() -> None:
    load = {"kind": "fourier", "coefficients": [[0.4, 0.0], *([1.0 / k**2, 0.0] for k in range(1, 1025))]}
    start = {"modal_displacement": [-1.0, *[0.0] * 255], "modal_velocity": [0.0] * 256}
    tables = {"system": {"s": 20.0, "d": 0.1, "restitution": 0.5}, "load": load, "start": start}
    assert Client().answer("/api/case", {"case": tables})["tables"]["system"]["s"] == 20.0
    text = "".join(f"  [{1.0 / k**2}, 0.0],\n" for k in range(1, 1025))
    toml = f"{_SYSTEM}kind = 'fourier'\ncoefficients = [\n[0.4, 0.0],\n{text}]\n"
    assert Client().answer("/api/case", {"toml": toml})["tables"]["system"]["s"] == 20.0


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("".join(f"[a{i}]\n" for i in range(80_000)), "keys and tables"),
        ("".join(f"[[a]]\nk{i}=1\n" for i in range(40_000)), "keys and tables"),
        ("x = {" + ", ".join(f"'k {i}' = 1" for i in range(40_000)) + "}", "keys and tables"),
        ("a." * 60_000 + "b = 1", "twenty parts"),
        ('["a".' + " 'b' . " * 60_000 + "b]", "twenty parts"),
    ],
    ids=["tables", "arrays of tables", "inline", "deep key", "deep table"],
)
def test_a_text_with_more_keys_than_a_case_is_not_parsed(text: str, says: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tomllib.loads", lambda _: pytest.fail("it was parsed"))
    with pytest.raises(CaseError, match=says):
        parsed(text, "x.toml")


def test_a_row_of_numbers_is_no_table() -> None:
    rows = "".join(f"[{i}.5, -{i}.25],\n  [ {i} , 1e-{i} ],\n" for i in range(MAX_KEYS))
    assert len(parsed(f"[load]\ncoefficients = [\n{rows}]\n", "x.toml")["load"]["coefficients"]) == 2 * MAX_KEYS


_HALF = "\ud800"


@pytest.mark.parametrize(
    ("path", "extra"),
    [
        ("/api/case", {"case": {"title": _HALF}}),
        ("/api/case", {"case": {_HALF: {}}}),
        ("/api/case", {"toml": f'title = "{_HALF}"'}),
        ("/api/report", {"case": {"title": f"a{_HALF}"}}),
        ("/api/map", {**MACHINE, "x": {"name": _HALF}, "y": {"name": "s"}}),
        ("/api/simulate", {**MACHINE, "start": {_HALF: 1}}),
        ("/api/quick", {**MACHINE, "values": {_HALF: 1.0}}),
    ],
)
@pytest.mark.parametrize("raw", [False, True], ids=["escaped", "as bytes"])
def test_half_a_character_is_refused(path: str, extra: dict[str, Any], raw: bool) -> None:
    body = json.dumps(extra, ensure_ascii=not raw).encode("utf-8", "surrogatepass")
    found = Client().request("POST", path, content=body, headers={"content-type": "application/json"})
    assert found.status_code == 422 and "surrogate" in found.json()["problems"][0]["message"]
    whole = json.dumps({"case": {"title": "😀"}}).encode()  # both halves, as JSON writes it
    found = Client().request("POST", "/api/case", content=whole, headers={"content-type": "application/json"})
    assert "surrogate" not in found.text


# -- memory ---------------------------------------------------------------------------------------------------------


def test_memories_are_bounded_by_size() -> None:
    memory: Memory[bytes] = Memory(4, 100, lambda _, kept: len(kept))
    for i in range(50):
        memory.put(i % 7, bytes(10 + i % 45))
        kept = {key: found for key in range(7) if (found := memory.find(key)) is not None}
        assert len(kept) <= 4 and sum(map(len, kept.values())) <= 100 and kept[i % 7] == bytes(10 + i % 45)
    memory.put("large", bytes(101))
    assert memory.find("large") is None
    assert memory.get("new", lambda: b"x") == b"x" and memory.get("new", lambda: b"y") == b"x"


def test_large_cases_do_not_fill_the_memory() -> None:
    """Each is known as long as there is room, and not one keeps more than its share."""
    client = Client()
    for i in range(12):
        text = f"# {i}\n" + "#" * 150_000
        client.post("/api/case", {"toml": f"{text}\n{_SYSTEM}kind = 'harmonic'\nmean = 0.4\namplitude = 1.0\n"})
    assert sum(len(str(key)) for key in _cases._kept) <= 1_000_000


_SYSTEM = "[system]\ns = 20.0\nd = 0.1\nrestitution = 0.5\n[load]\n"


def test_a_unit_of_many_characters_is_neither_read_nor_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    """Reading it would take the square of its length: a quarter of a million blanks would take minutes."""
    monkeypatch.setattr("percuss.units._tidy", lambda _: pytest.fail("it was read"))
    for unit in ("N" + " " * 250_000 + "x", "N" * 250_000):
        with pytest.raises(UnitError, match="force"):
            si(f"1 {unit}", "force", "amplitude")
        assert known_dimension(unit) is None


# -- work that nobody waits for -------------------------------------------------------------------------------------


def _hard(harmonics: int, restitution: float = 0.6) -> dict[str, Any]:
    """A load with about as many steady motions as harmonics."""
    waves = np.random.default_rng(1).normal(size=(harmonics, 2)) * np.arange(1, harmonics + 1)[:, None]
    load = {"kind": "fourier", "coefficients": [[1.0, 0.0], *waves.tolist()]}
    return {"system": {"s": 20.0, "d": 0.01, "restitution": restitution}, "load": load}


@pytest.mark.parametrize("halts", [0, 1, 30, 300])
def test_steady_motions_end_wherever_they_are_told_to(halts: int) -> None:
    """At the first look, while the phases are sought, and amid the proofs of the motions."""
    left = [halts]

    def halt() -> bool:
        left[0] -= 1
        return left[0] < 0

    with pytest.raises(Interrupted), halting(halt):
        steady_answer(case_of(_hard(24)), (1, 2, 3), 64).to_json_dict()
    assert left[0] == -1


def test_many_harmonics_at_many_times_do_not_fill_the_memory(monkeypatch: pytest.MonkeyPatch) -> None:
    """They are taken in portions, with the same values; at once, 1024 harmonics of 100 periods took 6.6 GB."""
    motion = steady_states(case_of(_hard(24)).system()).orbits[0]
    times, sizes, outer = np.linspace(0.0, motion.period, 1000), [], np.outer
    whole = motion.end_motion(times, 8)

    def counted(a: Any, b: Any) -> Any:
        found = outer(a, b)
        sizes.append(found.size)
        return found

    monkeypatch.setattr("percuss.steady.forced._AT_ONCE", 2400)
    monkeypatch.setattr("percuss.steady.oscillator._CHUNK", 2400)
    monkeypatch.setattr(np, "outer", counted)
    parts = motion.end_motion(times, 8)
    assert len(sizes) > 10 and max(sizes) <= 2400
    np.testing.assert_allclose(parts, whole, rtol=1e-12, atol=1e-12 * np.abs(whole).max())


def test_many_branches_over_many_cells_do_not_fill_the_memory(monkeypatch: pytest.MonkeyPatch) -> None:
    """A map of them is made in portions, with the same bits; at once, 1024 harmonics over 200 × 200 cells took GB."""
    axis = {"from": 0.1, "to": 0.9, "count": 9}
    asked = {"case": _hard(12), "x": {"name": "restitution", **axis}, "y": {"name": "load_factor", **axis}}
    sizes: list[int] = []

    def counted(system: Any, restitution: Any, *rest: Any) -> Any:
        found = stability_plane(system, restitution, *rest)
        sizes.append(found.phase.size)
        return found

    monkeypatch.setattr("percuss.explore.cells.stability_plane", counted)
    _, whole = Client().arrays("/api/map", asked)
    assert len(sizes) == 1
    monkeypatch.setattr("percuss.explore.cells._MOST", sizes[0] // 5)
    _, parts = Client().arrays("/api/map", asked)
    assert len(sizes) > 5 and max(sizes[1:]) <= sizes[0] // 5
    assert all(np.array_equal(parts[name], whole[name], equal_nan=True) for name in whole)


@pytest.mark.parametrize("workers", [1, 2])
def test_planes_end_between_two_portions(workers: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """As the branches of a curve do; a portion takes the same time for few modes and for many."""
    monkeypatch.setattr(sys.modules["percuss.stability.plane"], "_WORK", 16 * 17)
    system, left = case_of(_hard(12)).system(), [4]
    factor = np.linspace(0.2, 1.0, 24) * system.load.load_factor
    plane = stability_plane(system, 0.6, factor)

    def halt() -> bool:
        left[0] -= 1
        return left[0] < 0

    with pytest.raises(Interrupted), halting(halt):
        exact_plane(system, 0.6, factor, 1, 16, plane=plane, workers=workers)
    with pytest.raises(Interrupted), halting(lambda: True):
        stability_plane(system, 0.6, factor)


def test_a_halt_holds_for_its_block_and_its_thread_alone() -> None:
    answer = case_of(_hard(2))
    with halting(lambda: True):
        for inner in (None, lambda: False):  # a block inside is no shelter from what stops the one around it
            with halting(inner), pytest.raises(Interrupted):
                steady_answer(answer).to_json_dict()
        elsewhere: list[Any] = []
        thread = threading.Thread(target=lambda: elsewhere.append(steady_answer(case_of(_hard(3))).to_json_dict()))
        thread.start()
        thread.join()
        with pytest.raises(Interrupted):
            steady_answer(case_of(_hard(4))).to_json_dict()
    assert elsewhere and steady_answer(case_of(_hard(4))).to_json_dict()
    with halting(None), halting(lambda: False):
        assert steady_answer(case_of(_hard(2))).to_json_dict()


@pytest.mark.parametrize(
    ("path", "more"),
    [("/api/steady", {"periods": [4]}), ("/api/report", {"periods": [4]}), ("/api/quick", {"modes": 256})],
)
async def test_the_lane_is_free_when_the_client_has_left(path: str, more: dict[str, Any]) -> None:
    """Of hundreds of motions, each of which takes a while."""
    async with serving(heavy=1, heavy_waiting=0, quick=1, quick_waiting=0) as served:
        gate = served.app.app.state.gate
        lane = gate.quick if "quick" in path else gate.heavy
        _, writer = await served.connect(posted(path, {"case": _hard(256), **more}))
        while not lane._taken:
            await asyncio.sleep(0.01)
        await asyncio.sleep(0.5)
        writer.close()
        until = time.monotonic() + 60.0
        while lane._taken and time.monotonic() < until:
            await asyncio.sleep(0.02)
        assert lane._taken == 0


@pytest.mark.parametrize("path", ["/api/steady", "/api/report"])
def test_motions_that_nobody_would_wait_for_are_refused(path: str, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("orbit_routes.steady_answer", "case_routes.reported_answers"):
        monkeypatch.setattr(f"percuss.web.{name}", lambda *_: pytest.fail("it was begun"))
    asked = {"case": _hard(1024), "modes": 256, "periods": list(range(1, 9))}
    problem = Client().problems(path, asked)[0]
    assert problem["key"] == "periods" and "harmonics" in problem["message"]


def test_many_periods_of_a_usual_load_are_answered() -> None:
    asked = {**MACHINE, "modes": 32, "periods": [1, 2, 3, 5, 8, 13, 21, 100]}
    assert len(Client().answer("/api/steady", asked)["periods"]) == 8


# -- the token ------------------------------------------------------------------------------------------------------


@contextmanager
def told(monkeypatch: pytest.MonkeyPatch) -> Iterator[list[Settings]]:
    """What the command would serve."""
    found: list[Settings] = []

    class Room:
        @staticmethod
        def serve(settings: Settings, *_: object) -> None:
            found.append(settings)

    real = serve_command.import_module
    with monkeypatch.context() as changed:
        changed.setattr(serve_command, "import_module", lambda name: Room if name.endswith("serving") else real(name))
        yield found


def test_the_token_need_not_be_on_the_command_line(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "token"
    file.write_text(f"{TOKEN}-of-the-file\nanother line\n")
    with told(monkeypatch) as found:
        assert main(["serve", "--host", "0.0.0.0", "--token-file", str(file)]) == 0
        monkeypatch.setenv("PERCUSS_TOKEN", f"{TOKEN}-of-the-environment")
        assert main(["serve", "--host", "0.0.0.0"]) == 0
        assert main(["serve", "--token-file", str(file)]) == 0  # what is said counts more than what is around
        assert main(["serve", "--token", TOKEN, "--seconds", "45"]) == 0
        monkeypatch.setenv("PERCUSS_TOKEN", "")
        assert main(["serve"]) == 0
    assert [one.limits.seconds for one in found] == [30.0, 30.0, 30.0, 45.0, 30.0]
    kinds = ["of-the-file", "of-the-environment", "of-the-file"]
    assert [one.token for one in found] == [*(f"{TOKEN}-{kind}" for kind in kinds), TOKEN, ""]
    assert TOKEN not in capsys.readouterr().out


def test_the_command_serves_every_case_that_the_page_opens(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with told(monkeypatch) as found:
        for name in sample_names():
            assert main(["serve", name]) == 0
        broken = tmp_path / "broken.toml"
        broken.write_text(load_case("valve-breaker").to_toml().replace('to = "power"', 'to = "nowhere"'))
        assert main(["serve", str(broken)]) != 0
    assert [Case.from_text(one.case).is_machine for one in found] == [
        load_case(name).is_machine for name in sample_names()
    ]
    assert "nowhere" in capsys.readouterr().err


def test_a_wrong_token_is_told_without_showing_it(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    short = tmp_path / "short"
    short.write_text("short-word!\n")
    with told(monkeypatch) as found:
        assert main(["serve", "--token-file", str(short)]) == 2
        assert main(["serve", "--token-file", str(tmp_path / "none")]) == 2
        assert main(["serve", "--token-file", str(tmp_path)]) == 2
        assert main(["serve", "--token-file", str(short), "--token", TOKEN]) == 2
        monkeypatch.setenv("PERCUSS_TOKEN", "short-word!")
        assert main(["serve"]) == 2
    said = capsys.readouterr().err
    assert not found and "No such file" in said and "PERCUSS_TOKEN" in said and "short-word" not in said


def test_the_browser_is_not_told_the_token_where_others_can_read_it(tmp_path: Path) -> None:
    assert to_open(Settings(), "") == "http://127.0.0.1:8321/"
    opened = to_open(Settings(token=TOKEN), str(tmp_path))
    page = tmp_path / "percuss.html"
    assert opened == page.as_uri() and TOKEN not in opened
    assert f"url=http://127.0.0.1:8321/#token={TOKEN}" in page.read_text()
    assert os.name == "nt" or page.stat().st_mode & 0o077 == 0
