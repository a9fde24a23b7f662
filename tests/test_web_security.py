"""The workbench against what should not be answered: other hosts and pages, no token, too much, and nonsense."""

from __future__ import annotations

import asyncio
import gc
import json
import logging
import os
import re
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from typing import Any

import httpx
import pytest

pytest.importorskip("fastapi")

import schemathesis
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from percuss.cli import main
from percuss.errors import PercussError
from percuss.web import Limits, Settings
from percuss.web.gate import Lane
from percuss.web.guard import CONTENT_SECURITY_POLICY
from percuss.web.problems import Refusal
from percuss.web.serving import address, bound
from percuss.web.settings import is_loopback
from web_client import BASE, Client

MACHINE = {"machine": "mini-breaker"}
TOKEN = "a-long-secret-word"


@pytest.fixture(scope="module")
def client() -> Client:
    return Client()


# -- who asks -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "host",
    [
        "evil.example",
        "127.0.0.1.evil.example",
        "localhost.evil.example:8321",
        "",
        "a@localhost",
        "192.168.0.7:8321",
        "[::2]:8321",
        "localhost:x",
    ],
)
def test_other_names_are_refused(client: Client, host: str) -> None:
    for path in ("/", "/api/about", "/static/workbench.css"):
        assert client.get(path, headers={"host": host}).status_code == 403


@pytest.mark.parametrize("host", ["127.0.0.1:8321", "localhost:9999", "LOCALHOST", "[::1]:8321", "127.9.9.9"])
def test_names_of_this_machine_are_answered(client: Client, host: str) -> None:
    assert client.get("/api/about", headers={"host": host}).status_code == 200


def test_names_of_an_open_server() -> None:
    settings = Settings(host="0.0.0.0", token=TOKEN, names=("hammer.example",))
    assert settings.allows("hammer.example") and settings.allows("192.168.0.7") and settings.allows("fe80::1")
    assert not settings.allows("evil.example")
    assert TOKEN not in repr(settings)
    assert is_loopback("::1") and not is_loopback("192.168.0.7") and not is_loopback("localhost.evil.example")


@pytest.mark.parametrize(
    "origin", ["http://evil.example", "null", "http://localhost:8321", "http://127.0.0.1:9999", "x://["]
)
def test_posts_of_other_pages_are_refused(client: Client, origin: str) -> None:
    found = client.post("/api/quick", MACHINE, headers={"origin": origin})
    assert found.status_code == 403 and found.json()["problems"][0]["key"] == "Origin"


def test_own_pages_and_links_from_elsewhere_are_answered(client: Client) -> None:
    assert (
        client.post("/api/quick", MACHINE, headers={"origin": BASE, "sec-fetch-site": "same-origin"}).status_code == 200
    )
    for site in ("cross-site", "same-site"):
        assert client.get("/", headers={"sec-fetch-site": site}).status_code == 200
        assert client.get("/api/machines", headers={"sec-fetch-site": site}).status_code == 403


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
        "/static/../app.py",
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
    whole = client.get("/static/plotly.min.js", headers={"accept-encoding": "identity"})
    assert whole.status_code == 200 and len(whole.content) > 1_000_000
    assert whole.headers["content-type"].startswith("text/javascript")
    small = client.get("/static/plotly.min.js", headers={"accept-encoding": "gzip"})
    assert small.headers["content-encoding"] == "gzip" and small.content == whole.content
    known = client.get("/static/plotly.min.js", headers={"if-none-match": whole.headers["etag"]})
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
        ("a.mat", b"MATLAB 5.0 MAT-file"),
        ("a.h5", b"\x89HDF\r\n\x1a\n"),
        ("a.wav", b"RIFF\xff\xff\xff\x7fWAVEfmt " + b"\xff" * 100),
    ],
    ids=["columns", "quotes", "lines", "bytes", "mat", "hdf", "wav"],
)
def test_hostile_recordings_are_refused_soon(client: Client, name: str, data: bytes) -> None:
    begun = time.process_time()
    found = client.request("POST", "/api/history", params={"name": name}, content=data)
    assert found.status_code == 422 and found.json()["problems"][0]["key"].startswith("load.")
    assert time.process_time() - begun < 10.0


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
    ],
)
def test_what_is_not_json_is_told_so(client: Client, body: bytes, says: str) -> None:
    found = client.request("POST", "/api/quick", content=body, headers={"content-type": "application/json"})
    assert found.status_code == 400 and says in found.json()["problems"][0]["message"]


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
    ("/api/experiment", {"starts": 100_001}, "starts"),
    ("/api/experiment", {"starts": 100_000, "modes": 32}, "starts"),
    ("/api/experiment", {"impacts": 20_001}, "impacts"),
    ("/api/map", {"x": ("restitution", 0.0, 0.9, 201), "y": ("load_factor", 0.1, 1.0, 200)}, "x.count"),
    ("/api/map", {"x": ("s", 5.0, 9.0, 51), "y": ("load_factor", 0.1, 1.0, 50)}, "x.count"),
    ("/api/boundaries", {"x": ("restitution", 0.0, 0.9, 201), "y": ("load_factor", 0.1, 1.0, None)}, "x.count"),
]


@pytest.mark.parametrize(("path", "asked", "key"), BIG)
def test_what_takes_too_much_is_refused_before_it_is_begun(
    client: Client, path: str, asked: dict[str, Any], key: str
) -> None:
    whole = dict(asked)
    for axis in ("x", "y"):
        if axis in whole:
            name, low, high, count = whole[axis]
            whole[axis] = {"name": name, "from": low, "to": high} | ({} if count is None else {"count": count})
    begun = time.perf_counter()
    assert client.problems(path, {**MACHINE, **whole})[0]["key"] == key
    assert time.perf_counter() - begun < 2.0


@pytest.mark.parametrize(
    ("load", "key"),
    [
        ({"kind": "harmonic", "mean": 0.9, "amplitude": 1.0, "harmonic": 10**9}, "load.harmonic"),
        ({"kind": "square", "amplitude": 1.0, "kappa": 1.0, "harmonics": 10**12}, "load.harmonics"),
        ({"kind": "fourier", "coefficients": [[1.0, 0.0]] * 1026}, "load.coefficients"),
    ],
)
def test_loads_with_too_many_harmonics_are_refused(client: Client, load: dict[str, Any], key: str) -> None:
    tables = {"system": {"s": 20.0, "d": 0.01, "restitution": 0.5}, "load": load}
    assert client.problems("/api/quick", {"case": tables})[0]["key"] == key
    if "coefficients" not in load:
        text = "[system]\ns = 20.0\nd = 0.01\nrestitution = 0.5\n[load]\n" + "".join(
            f"{name} = {json.dumps(value)}\n" for name, value in load.items()
        )
        assert client.problems("/api/quick", {"toml": text})[0]["key"] == key


_HARMONIC = {"kind": "harmonic", "mean": 1e-300, "amplitude": 1e-300}

NONSENSE: list[Any] = [
    None, [], "x", 7, {"case": []}, {"case": "x"}, {"toml": 3}, {"toml": ""}, {"toml": "\0"}, {"machine": "../x"}, {},
    {"machine": None}, {**MACHINE, "toml": "x"}, {**MACHINE, "modes": "32"}, {**MACHINE, "modes": True},
    {**MACHINE, "modes": 1.5}, {**MACHINE, "what": 1}, {"case": {}}, {"case": {"system": 3, "load": []}},
    {"case": {"bar": None, "load": {"kind": {}}}}, {"case": {"load": {"kind": "fourier", "coefficients": [[1]]}}},
    {"case": {"system": {"s": 1e300, "d": 1e300, "restitution": 1}, "load": {**_HARMONIC, "mean": 1e300}}},
    {"case": {"system": {"s": 1e-300, "d": 0, "restitution": 1}, "load": {**_HARMONIC, "amplitude": 1e300}}},
    {"toml": "a = " + "[" * 3000}, {"toml": "a" * 500_001}, {"machine": "\ud800"},
    {"toml": "[load]\ncoefficients = [[1e999, 1" + "0" * 400 + "]]\n"},
]  # fmt: skip


@pytest.mark.parametrize("asked", NONSENSE, ids=lambda asked: repr(asked)[:40])
def test_nonsense_is_refused_in_words(client: Client, asked: Any) -> None:
    body = json.dumps(asked).encode()
    found = client.request("POST", "/api/quick", content=body, headers={"content-type": "application/json"})
    assert found.status_code in (400, 422), found.text
    for problem in found.json()["problems"]:
        assert set(problem) == {"key", "value", "message", "remedy"} and problem["message"]
        assert len(json.dumps(problem)) < 4000


_FIELDS = {
    "/api/quick": {"periods": 1, "curve": 3, "modes": 4, "multipliers": True, "values": {"restitution": 0.2}},
    "/api/curves": {"periods": 1, "points": 5, "branches": 4, "load_factor": [0.1, 0.9], "modes": 3},
    "/api/motion": {"orbit": 1, "periods": 1, "cycles": 1, "frames": 4, "places": 3, "end_points": 9, "window": [0, 1]},
    "/api/simulate": {"start": {"position": -0.5}, "simulation": {"modes": 2, "impacts": 20}, "events": 3},
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


@settings(max_examples=120, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))
@given(st.sampled_from(sorted(_FIELDS)), st.data())
def test_no_field_breaks_the_server(path: str, data: st.DataObject) -> None:
    client = _shared()
    asked = {**MACHINE, **_FIELDS[path]}
    name = data.draw(st.sampled_from(sorted(_FIELDS[path])))
    if path == "/api/motion" and name not in ("orbit", "periods") and data.draw(st.booleans()):
        del asked["orbit"]
        asked["simulation"] = {"modes": 2, "impacts": 20}
    asked[name] = data.draw(_JUNK)
    found = client.post(path, asked)
    assert found.status_code in (200, 400, 422), found.text


_kept: list[Client] = []


def _shared() -> Client:
    if not _kept:
        _kept.append(Client())
    return _kept[0]


# -- the schema -----------------------------------------------------------------------------------------------------

_schema = schemathesis.openapi.from_asgi(
    "/api/openapi.json", Client(Settings(names=("testserver", "localhost"), limits=Limits(seconds=5.0))).app
)


@_schema.parametrize()
@settings(max_examples=30, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))
def test_no_question_of_the_schema_breaks_the_server(case: Any) -> None:
    found = case.call()
    assert found.status_code < 500 or found.status_code == 503, found.text


# -- busy, and stopping ---------------------------------------------------------------------------------------------


def test_more_than_the_lane_holds_is_told_to_come_again() -> None:
    client = Client(Settings(limits=Limits(heavy=1, heavy_waiting=1)))
    begin = threading.Event()

    async def ask() -> list[httpx.Response]:
        lane = client.app.app.state.gate.heavy
        lane.submit(begin.wait)
        asked = [asyncio.create_task(client.arequest("POST", "/api/steady", json=MACHINE)) for _ in range(5)]
        await asyncio.sleep(0.3)
        quick = await client.arequest("POST", "/api/quick", json=MACHINE)
        begin.set()
        return [quick, *await asyncio.gather(*asked)]

    quick, *found = asyncio.run(ask())
    assert quick.status_code == 200
    codes = sorted(one.status_code for one in found)
    assert codes == [200, 200, 429, 429, 429]
    assert all(one.headers["retry-after"] for one in found if one.status_code == 429)
    assert client.post("/api/steady", MACHINE).status_code == 200  # the places are free again


def test_what_takes_too_long_is_given_up_and_keeps_its_place(caplog: pytest.LogCaptureFixture) -> None:
    class Here:
        async def is_disconnected(self) -> bool:
            return False

    async def ask() -> tuple[int, int, int]:
        lane = Lane("test", 1, 0)
        begin = threading.Event()
        with pytest.raises(Refusal) as late:
            await lane.run(Here(), 0.2, lambda halt: begin.wait() and 1 / 0)  # type: ignore[arg-type]
        with pytest.raises(Refusal) as busy:
            await lane.run(Here(), 0.2, lambda halt: True)  # type: ignore[arg-type]
        begin.set()
        await asyncio.sleep(0.2)
        assert await lane.run(Here(), 1.0, lambda halt: True)  # type: ignore[arg-type]
        lane.close()
        with pytest.raises(Refusal) as closed:
            await lane.run(Here(), 1.0, lambda halt: True)  # type: ignore[arg-type]
        return late.value.status_code, busy.value.status_code, closed.value.status_code

    assert asyncio.run(ask()) == (503, 429, 503)
    gc.collect()
    assert "never retrieved" not in caplog.text


def test_a_client_that_leaves_stops_its_computation() -> None:
    class Gone:
        async def is_disconnected(self) -> bool:
            return True

    stopped = threading.Event()

    def work(halt: Any) -> None:
        while not halt():
            time.sleep(0.01)
        stopped.set()

    async def ask() -> None:
        with pytest.raises(Refusal):
            await Lane("test", 1, 0).run(Gone(), 30.0, work)  # type: ignore[arg-type]

    asyncio.run(ask())
    assert stopped.wait(2.0)


def test_an_unforeseen_failure_tells_nothing(client: Client, monkeypatch: Any, caplog: Any) -> None:
    def broken(*_: object) -> None:
        raise KeyError("a secret of somebody")

    monkeypatch.setattr("percuss.web.steady_routes.steady_answer", broken)
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
    assert main(["serve", "--port", "70000"]) == 2
    assert main(["serve", "no-such-case.toml"]) == 2


def test_a_taken_port_is_told() -> None:
    taken = bound("127.0.0.1", 0)
    with pytest.raises(PercussError, match="cannot listen"):
        bound("127.0.0.1", taken.getsockname()[1])
    taken.close()
    with pytest.raises(PercussError, match="cannot listen"):
        bound("no.such.host.invalid", 0)
    assert address(Settings(host="0.0.0.0", token=TOKEN)) == f"http://127.0.0.1:8321/#token={TOKEN}"
    assert address(Settings(host="::1")) == "http://[::1]:8321/"


@pytest.fixture
def server() -> Iterator[tuple[subprocess.Popen[str], str]]:
    command = [sys.executable, "-m", "percuss", "serve", "mini-breaker", "--port", "0", "--no-browser"]
    environment = {**os.environ, "OPENBLAS_NUM_THREADS": "1"}
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=environment)
    assert process.stdout is not None
    line = process.stdout.readline()
    found = re.search(r"http://127\.0\.0\.1:\d+", line)
    assert found is not None, line
    try:
        yield process, found[0]
    finally:
        if process.poll() is None:
            process.kill()
        process.wait()


@pytest.mark.skipif(os.name == "nt", reason="signals of POSIX")
def test_a_server_ends_quickly_with_running_work(server: tuple[subprocess.Popen[str], str]) -> None:
    process, base = server
    asked = {**MACHINE, "starts": 50_000, "modes": 8, "distribution": "field"}
    with httpx.Client(base_url=base, trust_env=False, timeout=30.0) as client:
        assert client.get("/api/case").json()["title"] == "Hydraulic breaker for a mini excavator"
        with client.stream("POST", "/api/experiment", json=asked) as found:
            lines = found.iter_lines()
            assert next(line for line in lines if line.startswith("event")) == "event: progress"
            begun = time.monotonic()
            process.send_signal(signal.SIGINT)
            assert process.wait(15.0) == 0
            assert time.monotonic() - begun < 10.0


def test_experiments_end_when_their_clients_leave(server: tuple[subprocess.Popen[str], str]) -> None:
    _, base = server
    asked = {**MACHINE, "starts": 50_000, "modes": 8, "distribution": "field"}
    with httpx.Client(base_url=base, trust_env=False, timeout=30.0) as client:
        for _ in range(2):  # as many as go at once
            with client.stream("POST", "/api/experiment", json=asked) as found:
                assert found.status_code == 200
                assert next(line for line in found.iter_lines() if line.startswith("event")) == "event: progress"
        until = time.monotonic() + 10.0
        small = {**MACHINE, "starts": 50, "modes": 0}
        while (found := client.post("/api/experiment", json=small)).status_code == 429 and time.monotonic() < until:
            time.sleep(0.1)
        assert found.status_code == 200 and "event: done" in found.text


@pytest.mark.slow
def test_two_hundred_slider_moves_a_second(server: tuple[subprocess.Popen[str], str]) -> None:
    """For 30 s on one worker, none refused, and the memory does not grow.

    A machine that is too slow or too busy for so many gets as many as it can do.
    """
    process, base = server
    seconds = 30
    limits = httpx.Limits(max_connections=48, max_keepalive_connections=48)

    def question(i: int) -> dict[str, Any]:
        turn = 0.05 + 0.4 * ((i * 0.618034) % 1.0), 0.2 + 0.3 * ((i * 0.754878) % 1.0)
        return {**MACHINE, "values": dict(zip(("restitution", "load_factor"), turn, strict=True))}

    async def ask() -> tuple[list[int], float, float, int, int]:
        codes: list[int] = []
        async with httpx.AsyncClient(base_url=base, trust_env=False, timeout=30.0, limits=limits) as client:

            async def move(i: int) -> None:
                codes.append((await client.post("/api/quick", json=question(i))).status_code)

            begun = time.monotonic()
            for i in range(100):
                await move(i)
            rate = min(200.0, 0.7 * 100 / (time.monotonic() - begun))
            begun, early = time.monotonic(), _memory(process.pid)
            tasks = []
            for i in range(int(rate * seconds)):
                await asyncio.sleep(max(0.0, begun + i / rate - time.monotonic()))
                tasks.append(asyncio.create_task(move(i)))
            offered = time.monotonic()
            await asyncio.gather(*tasks)
        return codes, rate, time.monotonic() - offered, early, _memory(process.pid)

    codes, rate, rest, early, late = asyncio.run(ask())
    print(f"{rate:.0f} requests/s offered for {seconds} s; {rest:.2f} s until the last answer; {late - early} kB more")
    assert set(codes) == {200} and len(codes) == int(rate * seconds) + 100
    assert late < early + 30_000


def _memory(pid: int) -> int:
    """Resident memory in kB; 0 where it is not told."""
    try:
        with open(f"/proc/{pid}/status", encoding="ascii") as file:
            return int(next(line for line in file if line.startswith("VmRSS")).split()[1])
    except OSError:
        return 0
