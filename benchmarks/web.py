"""Benchmarks of the workbench: a real server on this machine, asked over its socket as the page asks it."""

from __future__ import annotations

import asyncio
import http.client
import itertools
import json
import os
import re
import subprocess
import sys
import threading
import time
import urllib.request
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests" / "web"))

from web_client import answered, offered, posted

Row = tuple[str, str, str, str]

MACHINE = "mini-breaker"
PLANE = {"x": ("restitution", 0.0, 0.9), "y": ("load_factor", 0.02, 1.2)}


@contextmanager
def server() -> Iterator[tuple[str, int, float]]:
    """A server of its own: its address, its process, and the seconds it took to begin."""
    environment = {**os.environ, "OPENBLAS_NUM_THREADS": "1"}
    command = [sys.executable, "-m", "percuss", "serve", "--port", "0", "--no-browser"]
    begun = time.perf_counter()
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=environment)
    try:
        assert process.stdout is not None
        found = re.search(r"http://\S+?:\d+", process.stdout.readline())
        assert found is not None
        yield found[0], process.pid, time.perf_counter() - begun
    finally:
        process.terminate()
        process.wait()


def asker(base: str) -> Callable[..., None]:
    """A client that costs little beside what it measures: one kept connection of the standard library."""
    connection = http.client.HTTPConnection(base.removeprefix("http://"), timeout=60.0)

    def ask(path: str, asked: Any = None) -> None:
        body = None if asked is None else json.dumps(asked)
        connection.request("GET" if body is None else "POST", path, body, {"Content-Type": "application/json"})
        answer = connection.getresponse()
        text = answer.read()
        assert answer.status == 200, text

    return ask


def ready(base: str) -> None:
    """Until the kernels are loaded: before, a slider's answer takes another way, and the loader half of its core."""
    while True:
        with urllib.request.urlopen(f"{base}/api/about") as answer:
            if json.load(answer)["ready"]:
                return
        time.sleep(0.2)


def processor(pid: int) -> float:
    """Seconds of processor that a process has taken; NaN where it is not told."""
    try:
        with open(f"/proc/{pid}/stat", encoding="ascii") as file:
            fields = file.read().rpartition(")")[2].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")
    except OSError:
        return float("nan")


def moves(number: int, name: str = MACHINE) -> list[dict[str, Any]]:
    """Slider moves, no two alike."""
    turns = np.arange(number)
    r, factor = 0.05 + 0.4 * (0.618034 * turns % 1.0), 0.2 + 0.2 * (0.754878 * turns % 1.0)
    pairs = zip(r.tolist(), factor.tolist(), strict=True)
    return [{"machine": name, "values": {"restitution": a, "load_factor": b}, "curve": 241} for a, b in pairs]


def plane(side: int, quantities: list[str]) -> dict[str, Any]:
    """A map of so many cells on each side."""
    axes = {key: {"name": name, "from": low, "to": high, "count": side} for key, (name, low, high) in PLANE.items()}
    return {"machine": MACHINE, **axes, "quantities": quantities}


def spread(call: Callable[[int], object], runs: int) -> tuple[float, float]:
    """Median and least wall time of a call in milliseconds, after one that does not count."""
    call(0)
    times = []
    for i in range(runs):
        begun = time.perf_counter()
        call(i + 1)
        times.append(1e3 * (time.perf_counter() - begun))
    return float(np.median(times)), min(times)


def offered_moves(base: str, rate: int, seconds: float) -> tuple[float, int]:
    """Slider moves offered at a rate on 48 connections: the rate that was answered, and how many were refused.

    The client sends what was made before and looks at the status alone: with httpx it took as much as the server.
    """
    found = asyncio.run(offered(int(base.rpartition(":")[2]), requests(int(rate * seconds)), rate))
    return len(found.codes) / found.seconds, sum(code != 200 for code in found.codes)


async def asking(port: int, clients: int, seconds: float, gap: float = 0.1) -> list[float]:
    """Milliseconds of the answers to clients that each move a slider every `gap` seconds, or as answers come."""
    sent, times, until = itertools.cycle(requests(2000)), list[float](), time.perf_counter() + seconds

    async def client(number: int) -> None:
        reader, writer = await asyncio.open_connection("127.0.0.1", port)
        await asyncio.sleep(gap * number / clients)
        while (begun := time.perf_counter()) < until:
            writer.write(next(sent))
            assert (await answered(reader))[0] == 200
            times.append(1e3 * (time.perf_counter() - begun))
            await asyncio.sleep(max(0.0, gap - 1e-3 * times[-1]))
        writer.close()

    await asyncio.gather(*map(client, range(clients)))
    return times


def asked_beside(base: str, path: str, asked: Any, seconds: float = 10.0) -> list[float]:
    """The same of one client, while something else is asked for again and again."""
    ended, other = threading.Event(), asker(base)

    def again() -> None:
        while not ended.is_set():
            other(path, asked)

    thread = threading.Thread(target=again)
    thread.start()
    try:
        return asyncio.run(asking(int(base.rpartition(":")[2]), 1, seconds))
    finally:
        ended.set()
        thread.join()


def streamed(base: str, path: str, asked: Any) -> list[float]:
    """Milliseconds to each event of a stream."""
    begun, connection = time.perf_counter(), http.client.HTTPConnection(base.removeprefix("http://"), timeout=60.0)
    connection.request("POST", path, json.dumps(asked), {"Content-Type": "application/json"})
    return [1e3 * (time.perf_counter() - begun) for line in connection.getresponse() if line.startswith(b"data:")]


def told(times: list[float]) -> tuple[str, str]:
    """Median, and the tail beside it."""
    slow, worst = np.percentile(times, 95.0), max(times)
    return f"{np.median(times):.0f} ms", f"{len(times)} answers, 95 % within {slow:.0f} ms, worst {worst:.0f} ms"


def requests(number: int) -> list[bytes]:
    """Slider moves, ready to be sent."""
    return [posted("/api/quick", question) for question in moves(number)]


def web() -> list[Row]:
    """What the page asks, over the socket; the least time is what the machine can do when nothing else runs."""
    rows: list[Row] = []
    with server() as (base, pid, began):
        ask = asker(base)
        rows.append(("percuss serve, from the command to its address and page", f"{began:.1f} s", "", ""))
        begun = time.perf_counter()
        ask("/api/quick", moves(1)[0])
        rows.append(("… to its first answer", f"{began + time.perf_counter() - begun:.1f} s", "", ""))
        ready(base)

        def row(name: str, limit: str, call: Callable[[int], object], runs: int = 21) -> None:
            before = processor(pid)
            middle, least = spread(call, runs)
            spent = 1e3 * (processor(pid) - before) / (runs + 1)
            rows.append((name, f"{middle:.1f} ms", limit, f"least {least:.1f} ms, {spent:.1f} ms of processor"))

        row("GET /", "", lambda i: ask("/"))
        for name in (MACHINE, "heavy-breaker"):
            sliders = moves(202, name)
            row(f"slider move, {name}", "5 ms", lambda i, s=sliders: ask("/api/quick", s[i]), 200)  # type: ignore[misc]
        row("steady answer", "", lambda i: ask("/api/steady", {"machine": MACHINE}))
        row("curves and branches", "", lambda i: ask("/api/curves", {"machine": MACHINE}))
        label = {"modes": 0, "impacts": 400}
        for side, words, limit, quantities, more in (
            (50, "reduced criterion", "100 ms", ["orbits", "reduced_margin"], {}),
            (200, "reduced criterion", "300 ms", ["orbits", "reduced_margin"], {}),
            (16, "multipliers", "500 ms", ["orbits", "stable", "margin"], {}),
            (200, "multipliers", "2 s", ["orbits", "stable", "margin"], {}),
            (8, "motions simulated", "500 ms", ["label"], label),
            (50, "motions simulated", "3 s", ["label"], label),
            (8, "blow energy", "500 ms", ["blow_energy"], {}),
            (50, "blow energy", "3 s", ["blow_energy"], {}),
        ):
            asked = plane(side, quantities) | more
            row(f"map {side} × {side}, {words}", limit, lambda i, a=asked: ask("/api/map", a), 3)  # type: ignore[misc]
        curve = {"machine": MACHINE, "x": plane(40, [])["x"], "y": {"name": "load_factor", "from": 0.02, "to": 1.2}}
        row("fold and flip over 40 values of R", "", lambda i: ask("/api/boundaries", curve), 3)
        row("motion, 240 frames", "", lambda i: ask("/api/motion", {"machine": MACHINE, "orbit": 1}))
        range_ = {"name": "load_factor", "from": 0.02, "to": 1.2}
        sizes = {"values": 2, "starts": 0, "runs": 0, "impacts": 2000, "up_to": "2/2"}
        for modes in (0, 8):
            looks = streamed(base, "/api/diagram", {"machine": MACHINE, "along": range_, "modes": modes, **sizes})
            first, last = f"{looks[0]:.0f} ms", f"{1e-3 * looks[-1]:.1f} s"
            rows.append((f"all motions up to z=2/2, {modes} modes, first look", first, "500 ms", ""))
            rows.append((f"all motions up to z=2/2, {modes} modes, whole", last, "5 s", ""))
        for side, words, more in ((200, "multipliers", ["margin"]), (50, "blow energy", ["blow_energy"])):
            middle, beside = told(asked_beside(base, "/api/map", plane(side, more)))
            rows.append((f"slider move beside a map {side} × {side}, {words}", middle, "60 ms", beside))
        middle, beside = told(asyncio.run(asking(int(base.rpartition(":")[2]), 30, 60.0)))
        rows.append(("slider moves of 30 browsers, each 10 a second, for 60 s", middle, "100 ms", beside))
        rate, refused = offered_moves(base, 200, 10.0)
        rows.append(("slider moves, 200 a second offered for 10 s", f"{rate:.0f}/s", "200/s", f"{refused} refused"))
    return rows


if __name__ == "__main__":
    for line in web():
        print(*line, sep=" | ")
