"""The workbench against what should not be answered: other hosts and pages, no token, too much, and nonsense."""

from __future__ import annotations

import asyncio
import errno
import gc
import gzip
import json
import logging
import os
import re
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import partial
from typing import Any

import httpx
import numpy as np
import pytest

pytest.importorskip("fastapi")

from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from hostile_recordings import bombs, hdf5
from percuss.case import load_case
from percuss.case.file_format.reading import toml_text
from percuss.case.uploads.upload import uploaded_history
from percuss.cli import main
from percuss.errors import CaseError, Interrupted, PercussError
from percuss.explore import boundaries
from percuss.web import Limits, Settings, case_routes, hammer_routes, motion_routes, orbit_routes, workers
from percuss.web.requests import CONTENT_SECURITY_POLICY, Refusal
from percuss.web.serving import address, bound
from percuss.web.settings import is_loopback
from percuss.web.workers import Admission, Lane
from web_client import BASE, Client, offered, posted

MACHINE = {"machine": "mini-breaker"}
TOKEN = "a-long-secret-word"


@pytest.fixture(scope="module")
def client() -> Client:
    return Client()


# -- who asks -------------------------------------------------------------------------------------------------------


EVIL = "http://evil.example"
WHO: list[tuple[str, dict[str, str], int]] = [
    *(("GET /api/about", {"host": host}, 403) for host in (
        "evil.example", "127.0.0.1.evil.example", "localhost.evil.example:8321", "", "a@localhost", "192.168.0.7:8321",
        "[::2]:8321", "localhost:x")),
    *(("GET /api/about", {"host": host}, 200) for host in (
        "127.0.0.1:8321", "localhost:9999", "LOCALHOST", "[::1]:8321", "127.9.9.9")),
    *((f"GET {path}", {"host": "evil.example"}, 403) for path in ("/", "/static/workbench.css")),
    *(("POST /api/quick", {"origin": origin}, 403) for origin in (
        EVIL, "null", "http://localhost:8321", "http://127.0.0.1:9999", "x://[")),
    ("POST /api/quick", {"origin": BASE, "sec-fetch-site": "same-origin"}, 200),
    *((f"GET {path}", {"sec-fetch-site": site}, status) for site in ("cross-site", "same-site")
      for path, status in (("/", 200), ("/api/machines", 403))),
    *(("GET /api/machines", {"referer": referer}, status) for referer, status in (
        (f"{EVIL}/x", 403), ("x://[", 403), (f"{BASE}/", 200))),
    *(("GET /", {"referer": referer}, 200) for referer in (f"{EVIL}/x", "x://[")),  # links from elsewhere
    *((f"HEAD {path}", {}, 200) for path in ("/", "/static/workbench.css", "/favicon.ico")),
    ("OPTIONS /api/quick", {"origin": EVIL, "access-control-request-method": "POST"}, 403),
    ("OPTIONS /api/quick", {}, 405),
    ("HEAD /api/quick", {}, 405),
]  # fmt: skip
"""Who asks for what, and whether it is answered: other hosts and pages are not, names of this machine are."""


@pytest.mark.parametrize(("asked", "headers", "status"), WHO)
def test_other_hosts_and_pages_are_refused(client: Client, asked: str, headers: dict[str, str], status: int) -> None:
    method, path = asked.split()
    found = client.request(method, path, headers=headers, **({"json": MACHINE} if method == "POST" else {}))
    assert found.status_code == status
    assert status != 403 or method != "POST" or found.json()["problems"][0]["key"] == "Origin"


def test_names_of_an_open_server() -> None:
    settings = Settings(host="0.0.0.0", token=TOKEN, names=("hammer.example",))
    assert settings.allows("hammer.example") and settings.allows("192.168.0.7") and settings.allows("fe80::1")
    assert not settings.allows("evil.example")
    assert TOKEN not in repr(settings)
    assert is_loopback("::1") and not is_loopback("192.168.0.7") and not is_loopback("localhost.evil.example")


def test_what_a_proxy_adds_changes_nothing() -> None:
    """Host and Origin are those that the browser sent; a proxy passes them on."""
    client = Client(Settings(names=("hammer.example",)))
    added = {"x-forwarded-host": "hammer.example", "x-forwarded-proto": "https", "forwarded": "host=hammer.example"}
    assert client.get("/api/machines", headers={"host": "evil.example", **added}).status_code == 403
    for origin, status in (("https://hammer.example", 200), ("https://evil.example", 403)):
        headers = {"host": "hammer.example", "x-forwarded-host": "evil.example", "origin": origin}
        assert client.post("/api/quick", MACHINE, headers=headers).status_code == status


@pytest.mark.parametrize("packing", ["gzip", "br", "identity, gzip"])
def test_packed_bodies_are_refused(client: Client, packing: str) -> None:
    headers = {"content-type": "application/json", "content-encoding": packing}
    for path in ("/api/quick", "/api/history?name=x.csv"):
        kind = headers if "quick" in path else {"content-encoding": packing}
        found = client.request("POST", path, content=gzip.compress(json.dumps(MACHINE).encode()), headers=kind)
        assert found.status_code == 415 and "compressed" in found.json()["problems"][0]["message"]


@pytest.mark.parametrize(
    "kind", ["text/plain", "application/x-www-form-urlencoded", "multipart/form-data; boundary=x", ""]
)
def test_what_a_form_could_send_is_refused(client: Client, kind: str) -> None:
    body = json.dumps(MACHINE).encode()
    headers = {"content-type": kind} if kind else {}
    assert client.request("POST", "/api/quick", content=body, headers=headers).status_code == 415
    if kind:
        assert client.request("POST", "/api/history?name=x.csv", content=body, headers=headers).status_code == 415


def test_the_token() -> None:
    client = Client(Settings(token=TOKEN))
    about = client.get("/api/about")
    assert about.status_code == 200 and about.json()["token"] is True and TOKEN not in about.text
    assert client.get("/").status_code == 200
    for given_ in ("", "Bearer", "Bearer x", f"Basic {TOKEN}", f"Bearer {TOKEN}x", "Bearer é"):
        found = client.get("/api/machines", headers={"authorization": given_.encode("utf-8")})  # type: ignore[dict-item]
        assert found.status_code == 401 and found.headers["www-authenticate"] == "Bearer"
    assert client.get("/api/openapi.json").status_code == 401
    assert client.get("/api/machines", headers={"authorization": f"Bearer {TOKEN}"}).status_code == 200


def test_every_answer_carries_the_policy(client: Client) -> None:
    found = [
        client.get("/"),
        client.get("/nothing"),
        client.get("/api/about"),
        client.post("/api/quick", MACHINE),
        client.post("/api/quick", {}),
        client.get("/", headers={"host": "evil.example"}),
        client.request("DELETE", "/api/quick"),
        client.post("/api/report", MACHINE),
    ]
    assert [one.status_code for one in found] == [200, 404, 200, 200, 422, 403, 405, 200]
    for one in found:
        assert one.headers["content-security-policy"] == CONTENT_SECURITY_POLICY
        assert one.headers["x-content-type-options"] == "nosniff"
        assert one.headers["x-frame-options"] == "DENY"
        assert one.headers["cross-origin-resource-policy"] == "same-origin"
        assert "server" not in one.headers and "access-control-allow-origin" not in one.headers
    assert "'unsafe-inline'" not in CONTENT_SECURITY_POLICY.split("style-src")[0]
    assert found[3].headers["cache-control"] == "no-store"


# -- files ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "path",
    [
        "/static/../application.py",
        "/static/..%2fapp.py",
        "/static/%2e%2e/%2e%2e/cli/app.py",
        "/static//etc/passwd",
        "/static/%2Fetc%2Fpasswd",
        "/static/..\\app.py",
        "/static/index.html%00.js",
        "/static/",
        "/static/.",
        "/api/machines/..%2f..%2fpyproject",
        "/api/machines/..",
        "/api/docs",
        "/docs",
        "/redoc",
    ],
)
def test_no_path_opens_a_file(client: Client, path: str) -> None:
    found = client.request("GET", httpx.URL(BASE).copy_with(raw_path=path.encode()))  # type: ignore[arg-type]
    assert found.status_code == 404
    assert "import" not in found.text and "root:" not in found.text


def test_static_files_come_whole_small_or_not_at_all(client: Client) -> None:
    whole = client.get("/static/workbench.css", headers={"accept-encoding": "identity"})
    assert whole.status_code == 200 and len(whole.content) > 10_000
    assert whole.headers["content-type"].startswith("text/css")
    small = client.get("/static/workbench.css", headers={"accept-encoding": "gzip"})
    assert small.headers["content-encoding"] == "gzip" and small.content == whole.content
    known = client.get("/static/workbench.css", headers={"if-none-match": whole.headers["etag"]})
    assert known.status_code == 304 and not known.content


@pytest.mark.parametrize("name", ["/etc/passwd", "../../x.csv", "x.csv\0", "a" * 190 + ".csv", "con.csv"])
def test_the_name_of_an_upload_is_no_path(client: Client, name: str, tmp_path: Any) -> None:
    found = client.request("POST", "/api/history", params={"name": name}, content=b"time [s],force [N]\n0,1\n")
    assert found.status_code == 422 and "passwd" not in found.json()["problems"][0]["message"]


@pytest.mark.parametrize(
    ("name", "data"),
    [
        ("a.csv", b"1," * 4_900_000),
        ("a.csv", b'"' * 9_900_000),
        ("a.txt", b"\n" * 9_900_000),
        ("a.csv", b"\xff\xfe" * 1000),
        ("a.wav", b"RIFF\xff\xff\xff\x7fWAVEfmt " + b"\xff" * 100),
    ],
    ids=["columns", "quotes", "lines", "bytes", "wav"],
)
def test_hostile_recordings_are_refused_soon(client: Client, name: str, data: bytes) -> None:
    begun = time.process_time()
    found = client.request("POST", "/api/history", params={"name": name}, content=data)
    assert found.status_code == 422 and found.json()["problems"][0]["key"].startswith("load.")
    assert time.process_time() - begun < 10.0


@pytest.mark.slow
def test_packed_recordings_cannot_do_harm(client: Client, tmp_path: Any) -> None:
    """Refused before they are unpacked, in words; no other file is read."""
    for what, (name, data, says) in bombs(tmp_path).items():
        found = client.request(
            "POST", "/api/history", params={"name": name, "sample_rate": "1 kHz", "unit": "kN"}, content=data
        )
        assert found.status_code == 422, what
        problem = found.json()["problems"][0]
        assert problem["key"] == "load.file" and re.search(says, problem["message"]), (what, problem)
        assert str(tmp_path) not in found.text and "percuss-" not in found.text


def test_what_a_reader_dies_of_is_a_refusal(monkeypatch: pytest.MonkeyPatch, tmp_path: Any) -> None:
    """As is what it takes too long over, or is stopped in."""
    from percuss.recordings.separate_process import ReaderBounds

    data = hdf5(tmp_path, lambda content: content.create_dataset("force", data=np.ones(4000)))
    with pytest.raises(Interrupted):
        uploaded_history(data, "recording.h5", {}, lambda: True)
    for bounds in (ReaderBounds(seconds=0.0), ReaderBounds(answer=5), ReaderBounds(memory=2**20)):
        with monkeypatch.context() as changed:
            changed.setattr("percuss.case.uploads.upload.BOUNDS", bounds)
            with pytest.raises(CaseError, match="memory and the time"):
                uploaded_history(data, "recording.h5", {})


def test_a_large_text_is_read_apart_and_can_be_given_up(monkeypatch: pytest.MonkeyPatch) -> None:
    rows = b"force [kN]\n" + b"".join(b"%d\n" % (50 - i % 100) for i in range(400_000))
    options = {"sample_rate": "1 kHz"}
    with pytest.raises(Interrupted):
        uploaded_history(rows, "a.csv", options, lambda: True)
    found = uploaded_history(rows, "a.csv", options)
    monkeypatch.setattr("percuss.case.uploads.upload._SMALL", len(rows))
    assert found == uploaded_history(rows, "a.csv", options)


def test_a_body_that_does_not_come_is_not_waited_for() -> None:
    client = Client(Settings(limits=Limits(body_seconds=0.2)))

    async def slow() -> Any:
        yield b"{"
        await asyncio.sleep(5.0)
        yield b"}"

    for path in ("/api/quick", "/api/history?name=x.csv"):
        headers = {"content-type": "application/json"} if "quick" in path else {}
        assert client.request("POST", path, content=slow(), headers=headers).status_code == 408


# -- too much -------------------------------------------------------------------------------------------------------


def test_large_bodies_are_refused_whether_they_say_so_or_not() -> None:
    client = Client(Settings(limits=Limits(json_bytes=5000, upload_bytes=20_000)))

    async def parts(number: int) -> Any:
        for _ in range(number):
            yield b" " * 1000

    headers = {"content-type": "application/json"}
    for path, number in (("/api/quick", 6), ("/api/history?name=x.csv", 21)):
        for content in (b" " * 1000 * number, parts(number)):
            found = client.request("POST", path, content=content, headers=headers if "quick" in path else {})
            assert found.status_code == 413, path
    lie = client.request("POST", "/api/quick", content=b"{}", headers={**headers, "content-length": "9" * 30})
    assert lie.status_code == 413


@pytest.mark.parametrize(
    ("body", "says"),
    [
        (b"{", "not JSON"),
        (b'{"machine": NaN}', "NaN"),
        (b'{"case": {"system": {"s": Infinity}}}', "Infinity"),
        (b'{"case": {"system": {"s": 1e999}}}', "out of range"),
        (b'{"case": {"system": {"s": 1' + b"0" * 30 + b"}}}", "out of range"),
        (b'{"a": 1' + b"0" * 5000 + b"}", "not JSON"),
        (b"[" * 100_000, "deeper"),
        (b'{"case": ' + b"[" * 40 + b"]" * 40 + b"}", "deeper"),
        (b'{"machine": "\xff"}', "not JSON"),
        (b'{"machine": "mini-breaker", "machine": "heavy-breaker"}', "twice"),
    ],
)
def test_what_is_not_json_is_told_so(client: Client, body: bytes, says: str) -> None:
    found = client.request("POST", "/api/quick", content=body, headers={"content-type": "application/json"})
    assert found.status_code == 400 and says in found.json()["problems"][0]["message"]


_PLAIN = {"s": 20.0, "d": 0.01, "restitution": 0.5}
_LOUD: list[tuple[dict[str, Any], str]] = [
    ({"kind": "harmonic", "mean": 0.9, "amplitude": 1.0, "harmonic": 10**9}, "load.harmonic"),
    ({"kind": "square", "amplitude": 1.0, "kappa": 1.0, "harmonics": 10**12}, "load.harmonics"),
    ({"kind": "fourier", "coefficients": [[1.0, 0.0]] * 1026}, "load.coefficients"),
]
BIG: list[tuple[str, dict[str, Any], str]] = [
    ("/api/quick", {"modes": 257}, "modes"),
    ("/api/quick", {"periods": 101}, "periods"),
    ("/api/steady", {"periods": list(range(1, 10))}, "periods"),
    ("/api/steady", {"modes": 5000}, "modes"),
    ("/api/simulate", {"simulation": {"modes": 257}}, "simulation.modes"),
    ("/api/simulate", {"simulation": {"impacts": 20_001}}, "simulation.impacts"),
    ("/api/motion", {"frames": 2001}, "frames"),
    ("/api/motion", {"places": 130}, "places"),
    ("/api/motion", {"cycles": 65}, "cycles"),
    ("/api/machine", {"modes": 257}, "modes"),
    ("/api/machine", {"points": 2001}, "points"),
    ("/api/experiment", {"starts": 100_001}, "starts"),
    ("/api/experiment", {"starts": 100_000, "modes": 32}, "starts"),
    ("/api/experiment", {"impacts": 20_001}, "impacts"),
    ("/api/map", {"x": ("restitution", 0.0, 0.9, 201), "y": ("load_factor", 0.1, 1.0, 200)}, "x.count"),
    ("/api/map", {"x": ("s", 5.0, 9.0, 51), "y": ("load_factor", 0.1, 1.0, 50)}, "x.count"),
    ("/api/boundaries", {"x": ("restitution", 0.0, 0.9, 201), "y": ("load_factor", 0.1, 1.0, None)}, "x.count"),
    *(("/api/quick", {"machine": None, "case": {"system": _PLAIN, "load": load}}, key) for load, key in _LOUD),
    *(("/api/quick", {"machine": None, "toml": toml_text({"system": _PLAIN, "load": load})}, key)
      for load, key in _LOUD),
]  # fmt: skip


@pytest.mark.parametrize(("path", "asked", "key"), BIG)
def test_what_takes_too_much_is_refused_before_it_is_begun(
    client: Client, path: str, asked: dict[str, Any], key: str
) -> None:
    whole = dict(asked)
    for axis in ("x", "y"):
        if axis in whole:
            name, low, high, count = whole[axis]
            whole[axis] = {"name": name, "from": low, "to": high} | ({} if count is None else {"count": count})
    begun = time.process_time()
    assert client.problems(path, {**MACHINE, **whole})[0]["key"] == key
    assert time.process_time() - begun < 2.0


_HARMONIC = {"kind": "harmonic", "mean": 1e-300, "amplitude": 1e-300}

NONSENSE: list[Any] = [
    None, [], "x", 7, {"case": []}, {"case": "x"}, {"toml": 3}, {"toml": ""}, {"toml": "\0"}, {"machine": "../x"}, {},
    {"machine": None}, {**MACHINE, "toml": "x"}, {**MACHINE, "modes": "32"}, {**MACHINE, "modes": True},
    {**MACHINE, "modes": 1.5}, {**MACHINE, "what": 1}, {"case": {}}, {"case": {"system": 3, "load": []}},
    {"case": {"bar": None, "load": {"kind": {}}}}, {"case": {"load": {"kind": "fourier", "coefficients": [[1]]}}},
    {"case": {"system": {"s": 1e300, "d": 1e300, "restitution": 1}, "load": {**_HARMONIC, "mean": 1e300}}},
    {"case": {"system": {"s": 1e-300, "d": 0, "restitution": 1}, "load": {**_HARMONIC, "amplitude": 1e300}}},
    {"toml": "a = " + "[" * 3000}, {"toml": "a" * 500_001}, {"machine": "\ud800"},
    {"toml": "[load]\ncoefficients = [[1e999, 1" + "0" * 400 + "]]\n"}, {"toml": "a = 0x" + "f" * 9000},
    {"toml": "a." * 60_000 + "b = 1"}, {"toml": "[" + '"a" . ' * 20_000 + "b]"},
    {"toml": "x = {" + "a." * 30_000 + "b = 1}"},
    {"case": {f"k{i}": 1 for i in range(20_000)}}, {"toml": "".join(f"k{i} = 1\n" for i in range(9000))},
]  # fmt: skip


@pytest.mark.parametrize("asked", NONSENSE, ids=lambda asked: repr(asked)[:40])
def test_nonsense_is_refused_in_words(client: Client, asked: Any) -> None:
    body = json.dumps(asked).encode()
    found = client.request("POST", "/api/quick", content=body, headers={"content-type": "application/json"})
    assert found.status_code in (400, 422), found.text
    for problem in found.json()["problems"]:
        assert set(problem) == {"key", "value", "message", "remedy"} and problem["message"]
        assert len(json.dumps(problem)) < 4000
    assert len(found.content) < 50_000


_FIELDS = {
    "/api/quick": {"periods": 1, "curve": 3, "modes": 4, "multipliers": True, "values": {"restitution": 0.2}},
    "/api/curves": {"periods": 1, "points": 5, "branches": 4, "load_factor": [0.1, 0.9], "modes": 3},
    "/api/motion": {"orbit": 1, "periods": 1, "cycles": 1, "frames": 4, "places": 3, "end_points": 9, "window": [0, 1]},
    "/api/machine": {"modes": 2, "points": 9, "whole": False, "machine": "valve-drifter"},
    "/api/blow": {"show": "start", "frames": 3, "cells": 4, "whole": False},
    "/api/simulate": {"start": {"position": -0.5}, "simulation": {"modes": 2, "impacts": 20}, "events": 3},
    "/api/follow/motion": {
        "name": "load_factor",
        "value": 0.35,
        "times": [1.98],
        "periods": 1,
        "modes": 1,
        "frames": 3,
    },
    "/api/place": {"values": {"restitution": 0.2, "load.frequency": 17.0}},
}
_KEYS = [
    *("position", "velocity", "orbit", "modes", "impacts", "time", "random", "seed", "x"),
    *("restitution", "s", "d", "load_factor", "bar.length", "kappa"),
]
_JUNK = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(-(2**63), 2**63 - 1),
    st.floats(allow_nan=False, allow_infinity=False),
    st.text(max_size=8),
    st.lists(st.floats(-9, 9), max_size=3),
    st.dictionaries(
        st.sampled_from(_KEYS),
        st.one_of(st.floats(-1e9, 1e9), st.integers(-3, 50), st.sampled_from(["rigid", "1 m", ""])),
        max_size=3,
    ),
)


@settings(max_examples=60, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))
@given(path=st.sampled_from(sorted(_FIELDS)), data=st.data())
def test_no_field_breaks_the_server(client: Client, path: str, data: st.DataObject) -> None:
    asked = {**MACHINE, **_FIELDS[path]}
    name = data.draw(st.sampled_from(sorted(_FIELDS[path].keys() - {"machine"})))
    if path == "/api/motion" and name not in ("orbit", "periods") and data.draw(st.booleans()):
        del asked["orbit"]
        asked["simulation"] = {"modes": 2, "impacts": 20}
    asked[name] = data.draw(_JUNK)
    found = client.post(path, asked)
    assert found.status_code in (200, 400, 422), found.text


# -- the schema -----------------------------------------------------------------------------------------------------

_ROUTES = [
    f"{method} {route.path}"
    for room in (case_routes, hammer_routes, motion_routes, orbit_routes)
    for route in room.router.routes
    for method in sorted(route.methods)
]
_CHECKED = ("not_a_server_error", "status_code_conformance", "content_type_conformance")


@pytest.fixture(scope="module")
def questions() -> tuple[dict[str, Any], list[Any]]:
    """What the schema asks by its routes, and the checks of answers; it is read where it is asked, which takes long."""
    import schemathesis

    app = Client(Settings(names=("testserver", "localhost"), limits=Limits(seconds=5.0))).app
    asked = [one.ok() for one in schemathesis.openapi.from_asgi("/api/openapi.json", app).get_all_operations()]
    checks = [check for check in schemathesis.checks.CHECKS.get_all() if check.__name__ in _CHECKED]
    assert sorted(one.label for one in asked) == sorted(_ROUTES)
    return {one.label: one for one in asked}, checks


@pytest.mark.parametrize("label", _ROUTES)
def test_no_question_of_the_schema_breaks_the_server(questions: Any, label: str) -> None:
    """The bodies too: right ones and wrong ones of every field."""

    asks, checks = questions

    @given(asks[label].as_strategy())
    @settings(max_examples=15, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))
    def asked(case: Any) -> None:
        found = case.call()
        assert found.status_code < 500 or found.status_code == 503, found.text
        if found.status_code != 503:
            case.validate_response(found, checks=checks)

    asked()


# -- busy, and stopping ---------------------------------------------------------------------------------------------


async def test_more_than_the_lane_holds_is_told_to_come_again() -> None:
    client = Client(Settings(limits=Limits(heavy=1, heavy_waiting=1)))
    begin = threading.Event()
    client.app.app.state.gate.heavy.submit(begin.wait)
    asked = [asyncio.create_task(client.arequest("POST", "/api/steady", json=MACHINE)) for _ in range(5)]
    while sum(one.done() for one in asked) < 3:
        await asyncio.sleep(0.01)
    assert (await client.arequest("POST", "/api/quick", json=MACHINE)).status_code == 200
    begin.set()
    found = await asyncio.gather(*asked)
    assert sorted(one.status_code for one in found) == [200, 200, 429, 429, 429]
    assert all(one.headers["retry-after"] for one in found if one.status_code == 429)
    free = await client.arequest("POST", "/api/steady", json=MACHINE)
    assert free.status_code == 200  # the places are free again


class Waits:
    """A request whose client is there, or has gone."""

    def __init__(self, gone: bool = False) -> None:
        self.gone = gone

    async def is_disconnected(self) -> bool:
        return self.gone


async def refusal(lane: Lane, seconds: float, work: Any, gone: bool = False) -> int:
    """The status with which a lane refuses work."""
    with pytest.raises(Refusal) as told:
        await lane.run(Waits(gone), seconds, work)  # type: ignore[arg-type]
    return told.value.status_code


async def test_what_takes_too_long_is_given_up_and_keeps_its_place(caplog: pytest.LogCaptureFixture) -> None:
    lane, begin = Lane("test", 1, 0), threading.Event()
    assert await refusal(lane, 0.2, lambda halt: begin.wait() and 1 / 0) == 503
    assert await refusal(lane, 0.2, lambda halt: True) == 429
    begin.set()
    while lane._taken:
        await asyncio.sleep(0.01)
    assert await lane.run(Waits(), 60.0, lambda halt: True)  # type: ignore[arg-type]
    lane.close()
    assert await refusal(lane, 1.0, lambda halt: True) == 503
    gc.collect()
    assert "never retrieved" not in caplog.text


async def test_long_computations_let_quick_answers_go_first(monkeypatch: pytest.MonkeyPatch) -> None:
    """For a while: with more quick questions than can be answered they get their half."""
    quick, order, began = Lane("quick", 1, 1), list[str](), threading.Event()
    heavy = Lane("heavy", 1, 0, quick)

    def work(halt: Any) -> bool:
        began.set()
        halt()
        order.append("long")
        return True

    for room, wanted in ((60.0, ["quick", "long"]), (0.0, ["long", "quick"])):
        monkeypatch.setattr(workers, "_GIVEN", room)
        order.clear()
        began.clear()
        async with quick.place(60.0):
            running = asyncio.create_task(heavy.run(Waits(), 60.0, work))  # type: ignore[arg-type]
            while not began.is_set() or not (order or room):
                await asyncio.sleep(0.01)
            order.append("quick")
        assert await running and order == wanted


async def test_what_looks_at_the_clock_itself_is_told_as_late() -> None:
    """And not as a wrong question, when it ends before the lane has seen that it is late."""

    def work(halt: Any) -> None:
        raise Interrupted(0, 1, None)

    assert await refusal(Lane("test", 1, 0), 30.0, work) == 503


def test_a_client_that_leaves_before_the_stream_begins_frees_its_place(monkeypatch: pytest.MonkeyPatch) -> None:
    """But not before its computation has ended."""
    client, ended = Client(), threading.Event()
    monkeypatch.setattr("percuss.web.motion_routes._followed", lambda *_: [] * ended.wait(10.0))
    body = json.dumps({**MACHINE, "starts": 10}).encode()
    headers = [(b"host", b"127.0.0.1:8321"), (b"content-type", b"application/json")]
    scope = {"type": "http", "asgi": {"spec_version": "2.3"}, "http_version": "1.1", "method": "POST"}
    scope |= {"path": "/api/experiment", "query_string": b"", "headers": headers}

    async def ask() -> int:
        left, asked = asyncio.Event(), [{"type": "http.request", "body": body, "more_body": False}]

        async def receive() -> dict[str, Any]:
            if asked:
                return asked.pop()
            await left.wait()
            return {"type": "http.disconnect"}

        async def send(_: Any) -> None:
            """As of a connection on which nothing is read."""
            left.set()
            await asyncio.sleep(60.0)

        await client.app(scope, receive, send)
        lane = client.app.app.state.gate.experiments
        await asyncio.sleep(0.3)
        taken = lane._taken
        ended.set()
        while lane._taken:
            await asyncio.sleep(0.01)
        return taken

    assert asyncio.run(asyncio.wait_for(ask(), 60.0)) == 1


async def test_a_client_that_leaves_stops_its_computation() -> None:
    stopped = threading.Event()

    def work(halt: Any) -> None:
        while not halt():
            time.sleep(0.01)
        stopped.set()

    await refusal(Lane("test", 1, 0), 30.0, work, gone=True)
    assert stopped.wait(2.0)


async def test_boundaries_end_when_their_client_leaves() -> None:
    """The lane is free again, though the curves would take a minute; each kind of search asks often."""
    case = load_case("mini-breaker").varied({"bar.damping_ratio": None, "bar.drag": "1 N*s/m^2"})
    system, x = case.system(), ("restitution", np.linspace(0.05, 0.9, 60))
    hard: list[tuple[tuple[str, float, float], dict[str, Any]]] = [
        (("load_factor", 0.05, 1.2), {"criterion": "exact", "modes": 200}),
        (("s", 5.0, 60.0), {}),
        (("d", 1e-3, 0.5), {"kinds": ("grazing",)}),
    ]

    found: list[Any] = []

    def work(halt: Any, y: tuple[str, float, float], options: dict[str, Any]) -> None:
        found.append(boundaries(system, x, y, progress=lambda _: halt(), **options))

    for y, options in hard:
        lane = Lane("test", 1, 0)
        await refusal(lane, 60.0, partial(work, y=y, options=options), gone=True)
        async with asyncio.timeout(60.0):
            while lane._taken:
                await asyncio.sleep(0.02)
        assert len(found[-1].failed) > 50 and {why for _, why in found[-1].failed} == {"given up"}
    whole = boundaries(system, ("restitution", [0.2]), hard[0][0], kinds=("fold",))
    assert not whole.failed and whole.greatest("fold")[0] > 0.0


async def test_work_in_line_is_refused_when_the_server_ends() -> None:
    lane, begin = Lane("test", 1, 5), threading.Event()
    lane.submit(begin.wait)
    waiting = asyncio.create_task(refusal(lane, 30.0, lambda halt: True))
    await asyncio.sleep(0.05)
    lane.close()
    begin.set()
    assert await waiting == 503


async def test_the_gate_can_be_closed_again_and_while_a_wait_runs_out() -> None:
    gate = Admission(Limits())
    with pytest.raises(Refusal) as told:
        async with gate.waiting(0.05):
            try:
                await asyncio.sleep(30.0)
            finally:
                gate.close()
    gate.close()
    assert told.value.status_code == 503


def test_an_unforeseen_failure_tells_nothing(client: Client, monkeypatch: Any, caplog: Any) -> None:
    def broken(*_: object) -> None:
        raise KeyError("a secret of somebody")

    monkeypatch.setattr("percuss.web.orbit_routes.steady_answer", broken)
    with caplog.at_level(logging.ERROR, "percuss.web"):
        found = client.post("/api/steady", MACHINE)
    assert found.status_code == 500 and "secret" not in found.text and "Traceback" not in found.text
    assert found.json()["problems"][0]["message"]
    assert "secret" in caplog.text


# -- the command ----------------------------------------------------------------------------------------------------


def test_an_open_server_needs_a_token(capsys: pytest.CaptureFixture[str]) -> None:
    for host in ("0.0.0.0", "::", "192.168.0.7", "hammer.example"):
        assert main(["serve", "--host", host, "--no-browser"]) == 2
        assert "needs a token" in capsys.readouterr().err
    assert main(["serve", "--token", "short"]) == 2
    for wrong in (["--port", "70000"], ["--host", ""], ["--name", ""], ["--name", "a b"], ["--workers", "0"]):
        assert main(["serve", *wrong, "--no-browser"]) == 2
    capsys.readouterr()
    assert main(["serve", "mini-braker", "--no-browser"]) == 2
    assert "did you mean 'mini-breaker'?" in capsys.readouterr().err
    assert main(["serve", "no-such-case.toml"]) == 2


def test_a_taken_port_is_told() -> None:
    taken = bound("127.0.0.1", 0)
    with pytest.raises(PercussError, match="--port 0"):
        bound("127.0.0.1", taken.getsockname()[1])
    taken.close()
    with pytest.raises(PercussError, match="address of this machine"):
        bound("no.such.host.invalid", 0)
    assert address(Settings(host="0.0.0.0", token=TOKEN)) == f"http://127.0.0.1:8321/#token={TOKEN}"
    assert address(Settings(host="::1")) == "http://[::1]:8321/"


def test_a_privileged_port_and_a_missing_extra_are_told(monkeypatch: Any, capsys: Any) -> None:
    def denied(*_: object) -> None:
        raise PermissionError(errno.EACCES, "Permission denied")

    with monkeypatch.context() as changed, pytest.raises(PercussError, match="below 1024"):
        changed.setattr(socket.socket, "bind", denied)
        bound("127.0.0.1", 80)
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    assert main(["serve", "--no-browser"]) == 2
    assert "pip install 'percuss[web]'" in capsys.readouterr().err


@contextmanager
def serving(*options: str) -> Iterator[tuple[subprocess.Popen[str], str]]:
    """A server of its own, and its address; it has nothing to complain of."""
    command = [sys.executable, "-m", "percuss", "serve", "mini-breaker", "--port", "0", "--no-browser", *options]
    environment = {**os.environ, "OPENBLAS_NUM_THREADS": "1"}
    with tempfile.TemporaryFile("w+") as errors:
        process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=errors, text=True, env=environment)
        assert process.stdout is not None
        line = process.stdout.readline()
        found = re.search(r"http://127\.0\.0\.1:\d+", line)
        assert found is not None, line
        try:
            yield process, found[0]
        finally:
            if process.poll() is None:
                process.terminate()
            process.wait()
        errors.seek(0)
        told = [line for line in errors.read().splitlines() if "compiling" not in line and "kernels of" not in line]
        assert told == []


@pytest.fixture(scope="module")
def server() -> Iterator[tuple[subprocess.Popen[str], str]]:
    """One server for all clients that it must outlive, and of which it has nothing to say."""
    with serving() as found:
        yield found


def _port(base: str) -> int:
    return int(base.rpartition(":")[2])


LONG = {**MACHINE, "starts": 50_000, "modes": 8, "distribution": "field"}
GRID = {
    "x": {"name": "restitution", "from": 0.05, "to": 0.9, "count": 40},
    "y": {"name": "load_factor", "from": 0.05, "to": 1.2, "count": 40},
}


@pytest.mark.skipif(os.name == "nt", reason="signals of POSIX")
@pytest.mark.parametrize("which", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize("workers", ["1", pytest.param("2", marks=pytest.mark.slow)])
def test_a_server_ends_in_order_with_running_work(which: int, workers: str) -> None:
    """A stream, a map and one in line, a body that does not come, and silence; nothing is complained of."""

    async def ask(process: subprocess.Popen[str], port: int) -> bytes:
        connections = [await asyncio.open_connection("127.0.0.1", port) for _ in range(12)]
        told = [posted("/api/experiment", LONG), posted("/api/quick", MACHINE)[:-5], b"GET / HT", b""]
        told += [posted("/api/map", {**MACHINE, **GRID, "quantities": ["blow_energy"]})] * 8
        for (_, writer), request in zip(connections, told, strict=True):
            writer.write(request)
        first = await connections[0][0].readuntil(b"event: progress")
        process.send_signal(which)
        rest = await asyncio.gather(*(reader.read() for reader, _ in connections))
        assert {answer[9:12] for answer in rest[4:]} <= {b"503", b"429", b"200", b""}, rest[4:]
        return first

    with serving("--workers", workers) as (process, base):
        assert b"200 OK" in asyncio.run(ask(process, _port(base)))
        assert process.wait(15.0) == 0


_TOLD_AMID_A_SUBMIT = """
import os, signal, sys, threading
from percuss.cli import main

def start(thread, begin=threading.Thread.start):
    if thread.name.startswith("percuss-quick"):  # begun by the pool, which holds its locks
        os.kill(os.getpid(), signal.SIGTERM)
    begin(thread)

threading.Thread.start = start
sys.exit(main(["serve", "--port", "0", "--no-browser"]))
"""


@pytest.mark.skipif(os.name == "nt", reason="signals of POSIX")
def test_a_signal_may_come_while_work_is_handed_over() -> None:
    with subprocess.Popen([sys.executable, "-c", _TOLD_AMID_A_SUBMIT], stdout=subprocess.PIPE) as process:
        try:
            assert process.stdout is not None
            base = f"http://127.0.0.1:{process.stdout.readline().decode().split('/')[2].rpartition(':')[2]}"
            with suppress(httpx.TransportError), httpx.Client(base_url=base, trust_env=False, timeout=5.0) as client:
                client.post("/api/quick", json={**MACHINE, "modes": 100})
            assert process.wait(15.0) == 0
        finally:
            process.kill()


@pytest.mark.skipif(not hasattr(os, "killpg"), reason="processes of POSIX")
def test_workers_are_begun_again_and_do_not_outlive_their_supervisor() -> None:
    with serving("--workers", "2") as (process, base):
        with httpx.Client(base_url=base, trust_env=False, timeout=30.0) as client:
            assert client.get("/api/case").status_code == 200
        children = _children(process.pid)
        if not children:
            pytest.skip("this system does not tell children")
        os.kill(children[-1], signal.SIGKILL)
        for _ in range(4):
            with httpx.Client(base_url=base, trust_env=False, timeout=30.0) as client:
                assert client.post("/api/quick", json=MACHINE).status_code == 200
        process.kill()
        process.wait()
        for _ in range(1200):
            try:
                socket.create_connection(("127.0.0.1", _port(base)), 1.0).close()
            except OSError:
                break
            time.sleep(0.05)
        else:
            pytest.fail("a worker stays behind")


def _children(pid: int) -> list[int]:
    try:
        with open(f"/proc/{pid}/task/{pid}/children", encoding="ascii") as file:
            return sorted(int(word) for word in file.read().split())
    except OSError:
        return []


def _sent(base: str, *parts: bytes) -> bytes:
    """What comes back on a connection until it is closed."""
    with socket.create_connection(("127.0.0.1", _port(base)), 30.0) as connection:
        with suppress(OSError):
            for part in parts:
                connection.sendall(part)
        found = b""
        with suppress(ConnectionError):
            while part := connection.recv(65_536):
                found += part
        return found


HEAD = b"Host: 127.0.0.1\r\nConnection: close\r\n"
QUICK = b"POST /api/quick HTTP/1.1\r\nContent-Type: application/json\r\n" + HEAD


def test_heads_and_trailers_are_bounded(server: tuple[subprocess.Popen[str], str]) -> None:
    process, base = server
    chunk = b'1a\r\n{"machine":"mini-breaker"}\r\n0\r\n'
    assert _sent(base, QUICK + b"Transfer-Encoding: chunked\r\n\r\n" + chunk + b"\r\n")[:12] == b"HTTP/1.1 200"
    while not httpx.get(f"{base}/api/about").json()["ready"]:  # with the kernels
        time.sleep(0.1)
    early = _memory(process.pid)
    for endless in (b"X: " + b"a" * 1_000_000, b"X: a\r\n" * 100_000):
        assert _sent(base, b"GET / HTTP/1.1\r\n", HEAD, *[endless] * 30)[:12] in (b"HTTP/1.1 400", b"")
    assert _sent(base, b"GET /", *[b"a" * 1_000_000] * 30)[:12] in (b"HTTP/1.1 400", b"")
    for endless in (b"X: a\r\n" * 100_000, b"X: " + b"a" * 1_000_000):
        assert b"200" not in _sent(base, QUICK + b"Transfer-Encoding: chunked\r\n\r\n" + chunk, *[endless] * 30)
    large = b"GET /api/about HTTP/1.1\r\n" + HEAD + b"X: " + b"a" * 60_000 + b"\r\n\r\n"
    assert _sent(base, large)[:12] == b"HTTP/1.1 200"
    assert _memory(process.pid) < early + 20_000  # kB


def test_upgrades_are_answered_as_if_they_were_none(server: tuple[subprocess.Popen[str], str]) -> None:
    _, base = server
    for name in (b"websocket", b"h2c"):
        extra = (
            b"Host: 127.0.0.1\r\nConnection: Upgrade, close\r\nUpgrade: " + name + b"\r\nSec-WebSocket-Version: 13\r\n"
        )
        assert _sent(base, b"GET /api/about HTTP/1.1\r\n" + extra + b"\r\n")[:12] == b"HTTP/1.1 200"


def test_clients_that_leave_leave_nothing_behind(server: tuple[subprocess.Popen[str], str]) -> None:
    """Not on standard error, see `serving`; and their places are free again."""
    _, base = server

    async def leave(request: bytes, after: float) -> None:
        _, writer = await asyncio.open_connection("127.0.0.1", _port(base))
        writer.write(request)
        await writer.drain()
        await asyncio.sleep(after)
        writer.close()

    async def ask() -> None:
        maps = posted("/api/map", {**MACHINE, **GRID, "quantities": ["margin", "blow_energy"]})
        y = {"name": "load_factor", "from": 0.05, "to": 1.2}
        curves = posted("/api/boundaries", {**MACHINE, "x": GRID["x"], "y": y, "criterion": "exact"})
        for i in range(6):
            await asyncio.gather(*(leave(maps, 0.08 * j + 0.03 * i) for j in range(3)), leave(curves, 0.1 * i))

    asyncio.run(ask())
    with httpx.Client(base_url=base, trust_env=False, timeout=60.0) as client:
        until = time.monotonic() + 60.0
        while (found := client.post("/api/steady", json=MACHINE)).status_code == 429 and time.monotonic() < until:
            time.sleep(0.1)
    assert found.status_code == 200


@pytest.mark.parametrize("behind", [b"", posted("/api/quick", MACHINE)], ids=["alone", "with another behind it"])
def test_experiments_end_when_their_clients_leave(server: tuple[subprocess.Popen[str], str], behind: bytes) -> None:
    """Nothing is complained of, see `serving`."""
    _, base = server
    for _ in range(2):  # as many as go at once
        with socket.create_connection(("127.0.0.1", _port(base)), 30.0) as connection:
            connection.sendall(posted("/api/experiment", LONG) + behind)
            found = b""
            while b"event: progress" not in found:
                found += connection.recv(65_536)
    with httpx.Client(base_url=base, trust_env=False, timeout=30.0) as client:
        until, small = time.monotonic() + 60.0, {**MACHINE, "starts": 50, "modes": 0}
        while (answer := client.post("/api/experiment", json=small)).status_code == 429 and time.monotonic() < until:
            time.sleep(0.1)
    assert answer.status_code == 200 and "event: done" in answer.text


@pytest.mark.slow
def test_two_hundred_slider_moves_a_second(server: tuple[subprocess.Popen[str], str]) -> None:
    """Offered for 30 s to one worker: each is answered, none refused, and the memory does not grow."""
    process, base = server
    turns = np.arange(6000)
    r, factor = 0.05 + 0.4 * (0.618034 * turns % 1.0), 0.2 + 0.3 * (0.754878 * turns % 1.0)
    moves = [
        posted("/api/quick", {**MACHINE, "values": {"restitution": a, "load_factor": b}, "curve": 241})
        for a, b in zip(r.tolist(), factor.tolist(), strict=True)
    ]
    asyncio.run(offered(_port(base), moves[:600], 200.0))  # caches fill
    early = _memory(process.pid)
    found = asyncio.run(offered(_port(base), moves, 200.0))
    grown = _memory(process.pid) - early
    print(f"{len(moves)} offered at 200/s, answered at {len(moves) / found.seconds:.0f}/s; {grown} kB more")
    assert len(found.codes) == 6000 and set(found.codes) == {200}
    assert grown < 20_000


def _memory(pid: int) -> int:
    """Resident memory in kB; 0 where it is not told."""
    try:
        with open(f"/proc/{pid}/status", encoding="ascii") as file:
            return int(next(line for line in file if line.startswith("VmRSS")).split()[1])
    except OSError:
        return 0
