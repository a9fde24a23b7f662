"""Benchmarks of the simulator: microseconds per impact beside heyoka and SciPy, hard starts, ensembles.

The peers run in an environment of their own, build/peers, made at the first use (benchmarks/peers/README.md).
"""

from __future__ import annotations

import json
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from percuss import Load, Start, Starts, Stop, System, run, simulate_many
from percuss.model import Kept, Ratio, UniformBar
from percuss.model.body import Body, External, KelvinVoigt, SteppedBar

ROOT = Path(__file__).resolve().parent
PEERS = ROOT.parent / "build" / "peers"
Row = tuple[str, str, str, str]

# What a first sketch reached, as its ratio to heyoka on one machine; and p = 0.7 + cos t, R = 0.6, d = 0.0048
CASES = (
    (0, 5.0, 3.2 / 0.32),
    (8, 5.0, 177 / 0.46),
    (8, 20.0, 609 / 0.41),
    (32, 5.0, 3600 / 0.54),
    (32, 20.0, 15400 / 0.47),
    (128, 5.0, 44000 / 0.77),
)
IMPACTS = 2000
SECONDS = 8.0  # for each case with each peer


def striker(s: float, load: Load | None = None) -> System:
    return System(s=s, d=0.0048, restitution=0.6, load=load or Load.harmonic(0.7, 1.0))


def name_of(modes: int, s: float) -> str:
    return f"N = {modes}, s = {s:g}"


def seconds(task: Callable[[], object], runs: int = 9) -> float:
    """Median wall time of a call, after one that does not count."""
    task()
    times = []
    for _ in range(runs):
        start = time.perf_counter()
        task()
        times.append(time.perf_counter() - start)
    return float(np.median(times))


def per_impact(system: System, modes: int) -> float:
    """Microseconds per impact of a motion of 2000, with all of its events and states recorded."""
    start, stop = Start.rigid(-1.0, time=0.3), Stop(impacts=IMPACTS, periodic=False)
    return 1e6 * seconds(lambda: run(system, start, modes=modes, stop=stop), 21) / IMPACTS


def environment_of_peers() -> str:
    """Makes build/peers, or brings it up to date; why that cannot be, or nothing."""
    python, wanted = PEERS / "bin" / "python", ROOT / "peers" / "requirements.txt"
    installed = PEERS / "requirements.txt"
    if python.exists() and installed.exists() and installed.read_text() == wanted.read_text():
        return ""
    print("making build/peers …", file=sys.stderr, flush=True)
    pip = [str(python), "-m", "pip", "--quiet", "--disable-pip-version-check", "install"]
    try:
        if not python.exists():
            subprocess.run([sys.executable, "-m", "venv", str(PEERS)], check=True)
        subprocess.run([*pip, "-r", str(wanted)], check=True)
        installed.write_text(wanted.read_text())
    except (OSError, subprocess.CalledProcessError) as error:
        return f"the peers cannot be installed: {error}"
    return ""


def peers() -> dict[str, Any]:
    """What the peers need, in their own environment; a message where they cannot be installed."""
    missing = environment_of_peers()
    if missing:
        return {"missing": missing}
    cases = [
        {
            "name": name_of(modes, s), "modes": modes, "s": s, "d": 0.0048, "restitution": 0.6,
            "coefficients": [[0.7, 0.0], [1.0, 0.0]], "start_time": 0.3, "position": -1.0, "impacts": IMPACTS,
            "seconds_budget": SECONDS,
        }
        for modes, s, _ in CASES
    ]  # fmt: skip
    print("the peers take some minutes …", file=sys.stderr, flush=True)
    done = subprocess.run(
        [str(PEERS / "bin" / "python"), str(ROOT / "peers" / "peers.py"), "-"],
        input=json.dumps({"cases": cases}),
        capture_output=True,
        text=True,
    )
    if done.returncode:
        return {"missing": f"the peers failed: {done.stderr.strip().splitlines()[-1]}"}
    found: dict[str, Any] = json.loads(done.stdout)
    if not all(check["passed"] for check in found["checks"]):
        print(f"the peers disagree: {found['checks']}", file=sys.stderr)
    return found


def of_peer(found: dict[str, Any], peer: str, name: str) -> float | None:
    """Microseconds per impact of a peer in a case."""
    for result in found.get(peer, {}).get("results", ()):
        if result["name"] == name:
            return result.get("microseconds_per_impact")
    return None


def motions() -> list[Row]:
    """The steady row of each size, beside the peers in the same run."""
    before = {name_of(n, s): per_impact(striker(s), n) for n, s, _ in CASES}
    found = peers()
    if "missing" in found:
        print(found["missing"], file=sys.stderr)
    rows: list[Row] = []
    for modes, s, goal in CASES:
        name = name_of(modes, s)
        ours = float(np.median([before[name], per_impact(striker(s), modes)]))  # before and after the peers
        tuned, plain, scipy = (of_peer(found, peer, name) for peer in ("heyoka", "heyoka_defaults", "scipy"))
        text = "; ".join(
            f"{label} {theirs:.3g} µs: {theirs / ours:.3g} × slower"
            for label, theirs in (("heyoka", plain), ("heyoka tuned", tuned), ("SciPy", scipy))
            if theirs is not None
        )
        beside = text or found.get("missing", "no peer")
        rows.append((f"simulation, µs per impact, {name}", f"{ours:.2f} µs", f"heyoka/{goal:.3g}", beside))
    return rows


def hard_ones() -> list[Row]:
    """Starts and loads that need more than the steady row: each beside it, in the same run, on one core."""
    rows: list[Row] = []
    stop = Stop(impacts=1, periodic=False)

    def cost(system: System, starts: Starts, modes: int, until: Stop) -> float:
        def task() -> int:
            return int(simulate_many(system, starts, modes=modes, stop=until, workers=1).impacts.sum())

        return 1e6 * seconds(task, 7) / task()

    for modes, s in ((8, 5.0), (32, 5.0), (32, 20.0), (128, 5.0)):
        system = striker(s)
        steady = cost(system, Starts.rigid(time=np.full(8, 0.3)), modes, Stop(impacts=IMPACTS, periodic=False))
        for what, starts in (
            ("ringing", Starts.random(system, 2000, seed=1, distribution="ringing", modes=modes)),
            ("near-grazing", grazing(system, modes)),
        ):
            hard = cost(system, starts, modes, stop)
            name = f"{what} starts, first contact, {name_of(modes, s)}"
            rows.append((name, f"{hard:.1f} µs", "20 ×", f"{hard / steady:.1f} × the steady row"))
    square = Load.square(1.0, 1.3, harmonics=15)
    one = Load.harmonic(square.mean, abs(complex(square.coefficients[1])))
    for modes in (8, 32):
        base = per_impact(striker(5.0, one), modes)
        for what, load in (("15 harmonics", Load.fourier(square.coefficients)), ("exact steps", square)):
            other = per_impact(striker(5.0, load), modes)
            text = f"{other / base:.1f} × one harmonic"
            rows.append((f"square load, {what}, {name_of(modes, 5.0)}", f"{other:.2f} µs", "5 ×", text))
    return rows


def bodies() -> list[Row]:
    """Other bodies and laws of damping, each beside the uniform bar with external damping, in turn in one run.

    Another system moves otherwise, and its search for a contact may need more evaluations: so they are counted.
    """
    start, stop = Start.rigid(-1.0, time=0.3), Stop(impacts=IMPACTS, periodic=False)
    load = Load.harmonic(0.7, 1.0)

    def of(body: Body, modes: int) -> tuple[float, float]:
        """Microseconds for each impact, and evaluations."""
        system = System(body, load, Kept(0.6))
        motion = run(system, start, modes=modes, stop=stop)
        begin = time.process_time()
        for _ in range(10):
            run(system, start, modes=modes, stop=stop)
        spent = time.process_time() - begin
        return 1e5 * spent / motion.impacts, float(motion.snapshot["count"]["work"][0]) / motion.impacts

    rows: list[Row] = []
    steel = UniformBar(5.0, External(0.0048))
    for what, body, modes, goal in (
        ("damping ratio 0.001", UniformBar(5.0, Ratio(0.001)), 32, "1.3 ×"),
        ("Kelvin–Voigt, η = 1e-5", UniformBar(5.0, KelvinVoigt(1e-5)), 32, "–"),
        ("Kelvin–Voigt, η = 1e-6", UniformBar(5.0, KelvinVoigt(1e-6)), 32, "–"),
        ("Kelvin–Voigt, η = 1e-6", UniformBar(5.0, KelvinVoigt(1e-6)), 128, "–"),
        ("overdamped, Kelvin–Voigt η = 0.04", UniformBar(5.0, KelvinVoigt(0.04)), 8, "–"),
        ("stepped bar", SteppedBar(5.0, (2.0, 1.0), (1.0, 2.0), External(0.0048)), 32, "4 ×"),
    ):
        pairs = np.array([(of(body, modes), of(steel, modes)) for _ in range(11)])
        cost, work = np.median(pairs[:, 0] / pairs[:, 1], axis=0)
        text = f"{cost:.2f} × external damping, {work:.2f} × the evaluations"
        rows.append((f"{what}, N = {modes}", f"{np.median(pairs[:, 0, 0]):.2f} µs", goal, text))
    return rows


def grazing(system: System, modes: int) -> Starts:
    """Starts whose flight passes the wall at a distance of 1e-3 … 1e-9: found by halving the starting position."""
    velocity, ring, far = 1.0, np.zeros(modes + 1), 4.0
    ring[1:4] = [0.02, 0.01, 0.005][: min(modes, 3)]
    time_of = np.linspace(0.0, 6.0, 25)
    places = []
    for t in time_of:
        low, high = -far, -1e-3  # misses the wall for a while; hits at once
        for _ in range(60):
            middle = 0.5 * (low + high)
            one = Starts(ring[None, :], np.eye(1, modes + 1) * velocity, np.array([middle]), np.array([t]))
            first = simulate_many(system, one, modes=modes, stop=Stop(impacts=1, time=2.5, periodic=False), workers=1)
            low, high = (middle, high) if first.impacts[0] == 0 else (low, middle)
        places.append(low)
    gaps = np.tile(np.concatenate([np.array(places) - depth for depth in (1e-3, 1e-5, 1e-7, 1e-9)]), 20)
    times = np.tile(time_of, 80)
    rows = np.tile(ring, (times.size, 1))
    return Starts(rows, np.tile(np.eye(1, modes + 1) * velocity, (times.size, 1)), np.minimum(gaps, 0.0), times)


def ensembles() -> list[Row]:
    """All cores beside one, and the time and memory of a million starts, in a process of its own."""
    system = striker(5.0)
    starts, stop = Starts.random(system, 20000, seed=2), Stop(impacts=200, periodic=False)
    ratios = []
    for _ in range(5):
        times = []
        for workers in (1, 2):
            begin = time.perf_counter()
            simulate_many(system, starts, modes=8, stop=stop, workers=workers)
            times.append(time.perf_counter() - begin)
        ratios.append(times[0] / times[1])
    rows = [
        ("ensemble, two cores beside one", f"{np.median(ratios):.2f} ×", "1.9 ×", "20 000 starts × 200 impacts, N = 8")
    ]
    code = (
        "import time, resource; from percuss import *\n"
        "s = System(s=5.0, d=0.0048, restitution=0.6, load=Load.harmonic(0.7, 1.0))\n"
        "a = Starts.random(s, 10**6, seed=3); t = time.perf_counter()\n"
        "m = simulate_many(s, a, modes=8, stop=Stop(impacts=200, periodic=False)); t = time.perf_counter() - t\n"
        "print(t, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6, int(m.impacts.sum()))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    wall, memory, impacts = done.stdout.split()
    text = (
        f"{float(memory):.2f} GB at most (goal 1 GB), {1e6 * float(wall) / int(impacts):.2f} µs of wall time per impact"
    )
    rows.append(("10⁶ starts × 200 impacts, N = 8", f"{float(wall):.0f} s", "180 s", text))
    return rows


def simulation() -> list[Row]:
    """All rows of the simulator."""
    return [*motions(), *hard_ones(), *ensembles()]
