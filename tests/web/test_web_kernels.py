"""What the workbench answers while its kernels are being loaded, when they cannot be, and to those who do not wait."""

from __future__ import annotations

import asyncio
import logging
import threading
from collections.abc import AsyncIterator, Iterator
from contextlib import asynccontextmanager
from typing import Any

import httpx
import pytest

pytest.importorskip("fastapi")

from starlette.exceptions import HTTPException
from starlette.requests import Request

from percuss.web import Settings, create_app
from percuss.web import workers as kernels
from percuss.web.shared_by_routes import compiled
from web_client import BASE

MACHINE = {"machine": "mini-breaker"}
PLANE = {
    "x": {"name": "restitution", "from": 0.0, "to": 0.6, "count": 3},
    "y": {"name": "load_factor", "from": 0.2, "to": 0.9, "count": 4},
}


class Compiler:
    """Loads a part when it is told to; `parts` that are broken fail."""

    def __init__(self) -> None:
        self.told: dict[str, threading.Event] = {
            part: threading.Event() for part in ("multipliers", "motions", "blows", "machines", "orbits")
        }
        self.broken: set[str] = set()

    def __call__(self, part: str) -> bool:
        assert self.told[part].wait(60.0)
        return part not in self.broken


@pytest.fixture
def compiler(monkeypatch: pytest.MonkeyPatch) -> Iterator[Compiler]:
    found = Compiler()
    monkeypatch.setattr(kernels, "_loaded", found)
    yield found
    for event in found.told.values():
        event.set()


@asynccontextmanager
async def workbench() -> AsyncIterator[tuple[httpx.AsyncClient, Any]]:
    """A client of an application whose kernels are being loaded, and the application."""
    app: Any = create_app(Settings())
    inner = app.app
    inner.state.kernels.begin(lambda: None)
    transport = httpx.ASGITransport(app=app, raise_app_exceptions=False)
    async with httpx.AsyncClient(transport=transport, base_url=BASE, timeout=60.0) as client:
        yield client, inner


async def settled(client: httpx.AsyncClient) -> None:
    while not (await client.get("/api/about")).json()["ready"]:
        await asyncio.sleep(0.01)


def test_the_closed_form_does_not_wait(compiler: Compiler) -> None:
    async def ask() -> tuple[dict[str, Any], dict[str, Any]]:
        async with workbench() as (client, _):
            curves = asyncio.create_task(client.post("/api/curves", json=MACHINE))
            motion = asyncio.create_task(client.post("/api/simulate", json={**MACHINE, "simulation": {"modes": 2}}))
            early = (await client.post("/api/quick", json=MACHINE)).json()
            assert (await client.post("/api/steady", json=MACHINE)).status_code == 200
            reduced = {**MACHINE, **PLANE, "quantities": ["reduced_margin"]}
            assert (await client.post("/api/map", json=reduced)).status_code == 200
            assert not curves.done() and not motion.done()
            compiler.told["multipliers"].set()
            assert (await curves).status_code == 200
            about = (await client.get("/api/about")).json()
            assert not motion.done() and not about["ready"]
            assert about["preparing"] == about["kernels"][1:] == ["motions", "blows", "machines", "orbits"]
            compiler.told["motions"].set()
            assert (await motion).status_code == 200
            for part in ("blows", "machines", "orbits"):
                compiler.told[part].set()
            await settled(client)
            while (await client.get("/api/about")).json()["preparing"]:
                await asyncio.sleep(0.01)
            return early, (await client.post("/api/quick", json=MACHINE)).json()

    early, late = asyncio.run(ask())
    assert len(early["orbits"]) == len(late["orbits"]) == 2
    for one, other in zip(early["orbits"], late["orbits"], strict=True):
        assert one["stable"] == other["stable"] and one["phase"] == other["phase"] and one["si"] == other["si"]
        assert one["margin"] == pytest.approx(other["margin"], abs=1e-12)
        assert one["multipliers"]["values"] and other["multipliers"]["values"] is None  # by another way


@pytest.mark.parametrize(
    ("path", "asked"),
    [
        ("/api/motion", {"machine": "nonesuch"}),
        ("/api/curves", {"case": {"system": {}}}),
        ("/api/map", {**MACHINE, **PLANE, "quantities": ["label", "nonsense"]}),
        ("/api/experiment", {"machine": "nonesuch"}),
    ],
)
async def test_nonsense_is_refused_at_once(compiler: Compiler, path: str, asked: dict[str, Any]) -> None:
    async with workbench() as (client, _), asyncio.timeout(20.0):
        assert ((await client.post(path, json=asked)).status_code) == 422


def test_without_kernels_the_closed_form_goes_on_and_the_rest_is_refused(compiler: Compiler) -> None:
    """As where nothing can be written and there is no home to keep them in."""
    compiler.broken = set(compiler.told)
    for event in compiler.told.values():
        event.set()

    async def ask() -> tuple[list[int], dict[str, Any]]:
        async with workbench() as (client, _):
            await settled(client)
            asked = {"simulate": MACHINE, "curves": MACHINE, "experiment": {**MACHINE, "starts": 5}}
            asked |= dict.fromkeys(("steady", "case", "quick"), MACHINE)
            found = [await client.post(f"/api/{path}", json=body) for path, body in asked.items()]
            return [one.status_code for one in found], found[-1].json()

    codes, quick = asyncio.run(ask())
    assert codes == [503, 503, 503, 200, 200, 200]
    assert quick["orbits"][0]["multipliers"]["values"]  # by the spectrum, which needs none


def test_a_client_that_leaves_does_not_wait_any_more(compiler: Compiler) -> None:
    async def left() -> dict[str, Any]:
        return {"type": "http.disconnect"}

    async def ask() -> None:
        async with workbench() as (_, app), asyncio.timeout(20.0):
            with pytest.raises(HTTPException) as refusal:
                await compiled(Request({"type": "http", "app": app}, left), "motions")
            assert refusal.value.status_code == 503

    asyncio.run(ask())


def test_a_loop_that_waits_is_not_forgotten_when_another_begins(compiler: Compiler) -> None:
    shared = kernels.Kernels()
    waiting, found = threading.Event(), []

    async def first() -> None:
        shared.begin(lambda: None)
        wait = asyncio.create_task(shared.wait("motions", 20.0))
        await asyncio.sleep(0.05)
        waiting.set()
        found.append(await wait)

    async def second() -> None:
        shared.begin(lambda: None)
        for event in compiler.told.values():
            event.set()
        found.append(await shared.wait("motions", 20.0))

    thread = threading.Thread(target=lambda: asyncio.run(first()))
    thread.start()
    assert waiting.wait(10.0)
    asyncio.run(second())
    thread.join()
    assert found == [True, True]


def test_what_fails_before_the_kernels_does_not_stop_them(caplog: pytest.LogCaptureFixture, compiler: Compiler) -> None:
    for event in compiler.told.values():
        event.set()

    async def serve() -> bool:
        mine = kernels.Kernels()
        mine.begin(lambda: 1 / 0)
        return await mine.wait("motions", 20.0) and mine.work("motions")

    with caplog.at_level(logging.ERROR):
        assert asyncio.run(serve())
    assert "ZeroDivisionError" in caplog.text


def test_all_kernels_are_loaded_or_it_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    assert kernels.load()
    monkeypatch.setattr(kernels, "_loaded", lambda part: part == "multipliers")
    assert not kernels.load()
