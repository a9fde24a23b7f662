"""Benchmarks of the workbench: a real server on this machine, asked over its socket as the page asks it."""

from __future__ import annotations

import asyncio
import http.client
import json
import os
import re
import subprocess
import sys
import time
import urllib.request
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests" / "web"))

from web_client import offered, posted

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
        for side, limit in ((50, "100 ms"), (200, "300 ms")):
            short, whole = plane(side, ["orbits", "reduced_margin"]), plane(side, ["orbits", "margin"])
            row(f"map {side} × {side}, reduced criterion", limit, lambda i, a=short: ask("/api/map", a), 7)  # type: ignore[misc]
            row(f"map {side} × {side}, multipliers", "", lambda i, a=whole: ask("/api/map", a), 3)  # type: ignore[misc]
        curve = {"machine": MACHINE, "x": plane(40, [])["x"], "y": {"name": "load_factor", "from": 0.02, "to": 1.2}}
        row("fold and flip over 40 values of R", "", lambda i: ask("/api/boundaries", curve), 3)
        row("motion, 240 frames", "", lambda i: ask("/api/motion", {"machine": MACHINE, "orbit": 1}))
        rate, refused = offered_moves(base, 200, 10.0)
        rows.append(("slider moves, 200 a second offered for 10 s", f"{rate:.0f}/s", "200/s", f"{refused} refused"))
    return rows


if __name__ == "__main__":
    for line in web():
        print(*line, sep=" | ")
