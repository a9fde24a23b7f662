"""Benchmarks: what the package promises about speed, beside what a user would take instead, in one run.

Run with `make bench`. Prints tables and writes them to build/bench/RESULTS.md; `--keep` updates benchmarks/RESULTS.md,
with `--only GROUP` the table of that group alone.
Times are medians of several runs; machines differ and are noisy, so look at the ratios.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # small matrices: threads only cost

import argparse
import math
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from datetime import date
from pathlib import Path

import numpy as np

from blow import blow
from comparing import compared
from explore_cells import explore_cells
from explore_running import explore_running
from machines import machines
from orbits import orbits_of_any_kind
from page import page
from percuss import Load, System, stability_of, steady_states
from percuss.stability import floquet_multipliers, stability_plane
from simulation import bodies, simulation
from web import web

ROOT = Path(__file__).resolve().parent
Row = tuple[str, str, str, str]


def median(task: Callable[[], object], runs: int = 7) -> float:
    """Median wall time of a call in seconds, after one call that does not count."""
    task()
    times = []
    for _ in range(runs):
        start = time.perf_counter()
        task()
        times.append(time.perf_counter() - start)
    return float(np.median(times))


def process(*arguments: str) -> Callable[[], object]:
    """Run this Python with the arguments as a whole process."""
    return lambda: subprocess.run([sys.executable, *arguments], check=True, stdout=subprocess.DEVNULL)


def peak(*arguments: str) -> float:
    """The most memory that such a process takes, in MB; begun by a small one, as Linux counts what it came from."""
    small = "import os, sys; child = os.posix_spawn(sys.executable, [sys.executable, *sys.argv[1:]], os.environ); "
    small += "print('\\n', os.wait4(child, 0)[2].ru_maxrss)"
    done = subprocess.run([sys.executable, "-S", "-c", small, *arguments], check=True, stdout=subprocess.PIPE)
    return int(done.stdout.split()[-1]) / (1e6 if sys.platform == "darwin" else 1e3)


def pneumatic(s: float = 20.0, d: float = 0.0048) -> System:
    return System(s=s, d=d, restitution=0.6, load=Load.harmonic(0.9, 1.0))


def processes() -> list[Row]:
    """Whole processes, beside starting Python and beside importing NumPy."""
    empty, numpy = median(process("-c", "pass")), median(process("-c", "import numpy"))
    rows: list[Row] = []
    with tempfile.TemporaryDirectory() as folder:
        case, report, blows = (str(Path(folder) / name) for name in ("drifter.toml", "report.html", "blows.csv"))
        noise = 1.0 + 0.01 * np.random.default_rng(1).normal(size=(200, 2))
        table = np.column_stack([np.cumsum(0.106 * noise[:, 0]), 1.4 * noise[:, 1]])
        np.savetxt(blows, table, "%.6f", ",", header="time [s],rebound speed [m/s]", comments="")
        subprocess.run([sys.executable, "-m", "percuss", "new", "hydraulic-drifter", "-o", case], check=True)
        for name, limit, words in (
            ("--help", 0.05, ["--help"]),
            ("steady, measured history", 0.7, ["steady", case]),
            ("steady --starts 0, measured history", 0.7, ["steady", case, "--starts", "0"]),
            ("steady --json, measured history", 0.5, ["steady", case, "--json"]),
            ("steady, harmonic load", 0.7, ["steady", "mini-breaker"]),
            ("simulate", 0.6, ["simulate", "mini-breaker"]),
            ("machine, rigid and N = 32, margins and what 10 % more do", 0.6, ["machine", "valve-breaker"]),
            ("machine, with oil that flows", 0.6, ["machine", "oil-drifter"]),
            ("blow", 0.6, ["blow", "hydraulic-drifter"]),
            ("orbits", 0.7, ["orbits", "mini-breaker"]),
            ("follow", 0.7, ["follow", "mini-breaker", "--along", "restitution=0.05:0.3"]),
            ("steady --reach, harmonic load", 1.5, ["steady", "pneumatic-jackleg", "--reach"]),
            ("steady --reach, measured history", 1.5, ["steady", case, "--reach"]),
            ("steady --reach, a valve that the piston switches", 1.5, ["steady", "valve-breaker", "--reach"]),
            ("steady --reach, a valve with ringing", 1.5, ["steady", "valve-drifter", "--reach"]),
            ("follow --curve all, over two parameters", 10.0, [
                "follow", "mini-breaker", "--along", "load_factor=0.2:1.2", "--over", "restitution=0:0.6",
                "--curve", "all",
            ]),
            ("diagram, 120 values", 2.5, ["diagram", "pneumatic-jackleg", "--along", "load_factor=0.3:1.2:120"]),
            ("sweep, labels, 12 × 12", 0.7, [
                "sweep", "mini-breaker", "--x", "restitution=0:0.6:12", "--y", "load_factor=0.2:1:12",
                "--quantity", "label",
            ]),
            ("sweep, Lyapunov exponents of 400 values, N = 8", 60.0, [
                "sweep", "pneumatic-jackleg", "--x", "load_factor=0.3:1.2:400", "--quantity", "lyapunov",
                "--modes", "8", "--yes",
            ]),
            ("compare, two drifters and their blows", 3.0, ["compare", "hydraulic-drifter", "stepped-drifter"]),
            ("report, under a clock", 3.0, ["report", "hydraulic-drifter", "-o", report]),
            ("report, a valve with ringing", 3.0, ["report", "valve-drifter", "-o", report]),
            ("report, a stepped piston", 3.0, ["report", "stepped-drifter", "-o", report]),
            ("identify, two numbers of 200 blows", 3.0, ["identify", "valve-breaker", "--blows", blows]),
        ):  # fmt: skip
            arguments = ["-m", "percuss", *words]
            taken = median(process(*arguments), 7 if limit < 2.0 else 3)
            beside = f"{taken / empty:.1f} × python -c pass, {taken / numpy:.2f} × import numpy"
            rows.append(
                (f"percuss {name}", f"{taken:.3f} s", f"{limit} s", f"{beside}; {peak(*arguments):.0f} MB at most")
            )
    return rows


def one_case() -> list[Row]:
    """One case in the library, beside finding the same orbit by integrating the modes until they settle."""

    def verdicts() -> None:
        for orbit in steady_states(pneumatic(), modes=32).orbits:
            stability_of(orbit)

    def everything() -> None:
        for orbit in steady_states(pneumatic(), modes=32).orbits:
            stability_of(orbit)
            _ = orbit.admissible, orbit.energy, orbit.stroke

    seconds, whole = median(verdicts, 21), median(everything, 21)
    integrated, impacts = settle_by_integration(pneumatic(), modes=2)
    times = f"{integrated / seconds:.0f}"
    beside = f"{times} times faster than scipy's DOP853 to one settled orbit with 2 modes ({impacts} impacts)"
    with_all = f"{whole / seconds:.1f} × the row above"
    return [
        ("one case: phases and 32-mode multipliers of both orbits", f"{1e3 * seconds:.1f} ms", "10 ms", beside),
        ("the same with proof of admissibility, energy and stroke", f"{1e3 * whole:.1f} ms", "10 ms", with_all),
    ]


def settle_by_integration(system: System, modes: int) -> tuple[float, int]:
    """What a user would do without closed forms: integrate mode by mode from impact to impact until nothing changes."""
    from scipy.integrate import solve_ivp

    frequencies = np.pi * system.s * np.arange(modes + 1)
    signs = np.append(1.0, 2.0 * (-1.0) ** np.arange(1, modes + 1))

    def rate(t: float, y: np.ndarray) -> np.ndarray:
        u, v = y[: modes + 1], y[modes + 1 :]
        return np.concatenate([v, float(system.load.value(t)) - system.d * v - frequencies**2 * u])

    def gap(t: float, y: np.ndarray) -> float:
        return float(signs @ y[: modes + 1])

    gap.terminal, gap.direction = True, 1.0  # type: ignore[attr-defined]  # scipy reads them off the function
    start = time.perf_counter()
    state, now, last, impacts = np.zeros(2 * modes + 2), 2.3, 0.0, 0
    state[modes + 1] = -2.1  # near the stable orbit, so that no blow is weak
    while impacts < 60:
        flight = solve_ivp(rate, (now, now + 60.0), state, "DOP853", events=gap, rtol=1e-9, atol=1e-12)
        now, state = float(flight.t_events[0][0]), flight.y_events[0][0].copy()
        state[modes + 1 :] *= -system.restitution
        impacts += 1
        phase = now % (2.0 * math.pi)
        if abs(phase - last) < 1e-6:
            break
        last = phase
    return time.perf_counter() - start, impacts


def planes() -> list[Row]:
    """10⁶ points of the stability plane, beside one point at a time."""
    r, factor = np.linspace(0.0, 0.9, 1000)[:, None], np.linspace(0.001, 1.0, 1000)
    whole = median(lambda: stability_plane(pneumatic(), r, factor), 3)
    grid = [(float(a), float(b)) for a in r[::250, 0] for b in factor[::250]]
    single = median(lambda: [stability_plane(pneumatic(), a, b) for a, b in grid], 3) / len(grid)
    rows = [
        (
            "pneumatic plane, 10⁶ points, phases + reduced criterion",
            f"{whole:.2f} s",
            "1 s",
            f"{1e6 * single / whole:.0f} times faster than point by point",
        )
    ]
    three = System(s=20.0, d=0.0048, restitution=0.6, load=Load.fourier([0.5, 1.0, 0.3j, 0.2]))
    square = System(s=20.0, d=0.0048, restitution=0.6, load=Load.square(1.0, 1.4, harmonics=15))
    for name, system in (("3 harmonics", three), ("square wave, 15 harmonics", square)):
        other = median(lambda system=system: stability_plane(system, r, factor), 3)  # type: ignore[misc]
        rows.append((f"the same with {name}", f"{other:.2f} s", "–", f"{other / whole:.1f} × the pneumatic plane"))
    return rows


def multipliers() -> list[Row]:
    """Cost of all multipliers against N, beside a dense eigensolver."""
    orbit = steady_states(pneumatic(s=5.0)).orbits[1]
    rows: list[Row] = []
    times: dict[int, float] = {}
    for modes in (64, 256, 1024, 4096):
        times[modes] = median(lambda modes=modes: floquet_multipliers(orbit, modes), 15)  # type: ignore[misc]
        beside = f"{1e6 * times[modes] / modes:.2g} µs per mode"
        if modes <= 256:
            dense = median(lambda modes=modes: np.linalg.eigvals(orbit.linear_map(modes).dense()), 3)  # type: ignore[misc]
            beside += f", {dense / times[modes]:.1f} times faster than dense eigenvalues"
        rows.append((f"all multipliers, N = {modes}", f"{1e3 * times[modes]:.2g} ms", "–", beside))
    slope = math.log(times[4096] / times[256]) / math.log(4096 / 256)
    rows.append(("growth of that cost from N = 256 to 4096", f"N^{slope:.2f}", "N^1", "dense eigenvalues: N^3"))
    return rows


GROUPS: dict[str, tuple[str, Callable[[], list[Row]]]] = {
    "processes": ("Whole processes", processes),
    "case": ("One case", one_case),
    "planes": ("Stability planes", planes),
    "multipliers": ("Multipliers", multipliers),
    "orbits": ("Orbits of any kind", orbits_of_any_kind),
    "simulation": ("Simulation", simulation),
    "bodies": ("Simulation of other bodies and laws of damping", bodies),
    "machines": ("Machines that switch themselves", machines),
    "blow": ("The blow", blow),
    "cells": ("Cells of maps", explore_cells),
    "running": ("Archive and workers", explore_running),
    "web": ("The server of the workbench", web),
    "page": ("The page of the workbench", page),
}

_HEAD = "# Benchmark results"
_TABLE = "| what | median | goal | beside |\n| --- | --- | --- | --- |\n"


def measured(name: str) -> str:
    """The section of one group, printed as it comes."""
    title, rows = GROUPS[name]
    about = f"{date.today()}, Python {sys.version.split()[0]}, NumPy {np.__version__}, {os.cpu_count()} cores"
    text = f"## {title}\n\n`{name}`, one run: {about}.\n\n{_TABLE}"
    print(text, end="", flush=True)
    for row in rows():
        line = f"| {' | '.join(row)} |\n"
        text += line
        print(line, end="", flush=True)
    print(flush=True)
    return text


def sections(text: str) -> dict[str, str]:
    """The sections of a file of results, by their titles."""
    parts = text.split("\n## ")[1:]
    return {part.partition("\n")[0]: f"## {part.rstrip()}\n" for part in parts}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--keep", action="store_true", help="update benchmarks/RESULTS.md, the groups measured now")
    parser.add_argument("--only", choices=sorted(GROUPS), action="append", help="one group; may be given several times")
    parser.add_argument(
        "--compare", metavar="REF", help="beside another commit, in turn; fails where a row is 5 %% worse"
    )
    options = parser.parse_args()
    if options.compare:
        sys.exit(compared(options.compare, options.only or list(GROUPS)))
    target = (ROOT if options.keep else ROOT.parent / "build" / "bench") / "RESULTS.md"
    target.parent.mkdir(parents=True, exist_ok=True)
    known = sections(target.read_text(encoding="utf-8")) if target.exists() else {}
    for name in options.only or GROUPS:
        known[GROUPS[name][0]] = measured(name)
        found = [known[title] for title, _ in GROUPS.values() if title in known]
        introduction = "Medians of the runs of `make bench` named below; the ratios are what travels."
        target.write_text("\n".join([f"{_HEAD}\n\n{introduction}\n", *found]), encoding="utf-8")


if __name__ == "__main__":
    main()
