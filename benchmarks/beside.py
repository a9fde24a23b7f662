"""The rows that compute, of this checkout and of another one, in turn in one run: whether anything became slower.

    python benchmarks/beside.py OTHER_CHECKOUT [--only WORDS] [--rounds 9]

Each checkout has a process of its own, which is kept; a row is run in both, one after the other, in alternating order.
What is compared is processor time, and the ratio pair by pair: a machine that is busy, or changes its speed, changes
both. Prints the median ratio of each row with the range of the middle half, and marks those above 1.05.
"""

from __future__ import annotations

import argparse
import inspect
import json
import os
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
SLOWER = 1.05
LEAST = 0.25  # seconds of processor time in a measurement
IMPACTS = 2000


def tasks() -> dict[str, Callable[[], object]]:
    """By the name of the row; only what both checkouts have, from the public interface."""
    from percuss import Load, Start, Starts, Stop, System, run, stability_of, steady_states
    from percuss.explore import lyapunov_many
    from percuss.simulate import simulate_many
    from percuss.stability import exact_plane, floquet_multipliers, stability_plane

    def pneumatic(s: float = 20.0) -> System:
        return System(s=s, d=0.0048, restitution=0.6, load=Load.harmonic(0.9, 1.0))

    def striker(s: float, load: Any = None) -> System:
        return System(s=s, d=0.0048, restitution=0.6, load=load or Load.harmonic(0.7, 1.0))

    def whole(system: System) -> None:
        for orbit in steady_states(system, modes=32).orbits:
            stability_of(orbit)
            _ = orbit.admissible, orbit.energy, orbit.stroke

    one = {"workers" if "workers" in inspect.signature(simulate_many).parameters else "threads": 1}
    start, stop, first = (
        Start.rigid(-1.0, time=0.3),
        Stop(impacts=IMPACTS, periodic=False),
        Stop(impacts=1, periodic=False),
    )
    found: dict[str, Callable[[], object]] = {}
    for modes, s in ((0, 5.0), (8, 5.0), (8, 20.0), (32, 5.0), (32, 20.0), (128, 5.0)):
        found[f"simulation, N = {modes}, s = {s:g}"] = lambda m=modes, s=s: [
            run(striker(s), start, modes=m, stop=stop) for _ in range(8)
        ]
    for modes in (8, 32, 128):
        ringing = Starts.random(striker(5.0), 4000, seed=1, distribution="ringing", modes=modes)
        found[f"ringing starts, N = {modes}"] = lambda m=modes, a=ringing: simulate_many(
            striker(5.0), a, modes=m, stop=first, **one
        )
    for name, other in bodies().items():
        found[f"{name}, N = 32"] = lambda y=other: [run(y, start, modes=32, stop=stop) for _ in range(8)]
    found["overdamped, N = 8"] = lambda: [
        run(System(s=1.0, d=10.0, restitution=0.6, load=Load.harmonic(0.7, 1.0)), start, modes=8, stop=stop)
        for _ in range(8)
    ]
    square = Load.square(1.0, 1.3, harmonics=15)
    for name, load in (("15 harmonics", Load.fourier(square.coefficients)), ("exact steps", square)):
        found[f"square load, {name}, N = 8"] = lambda p=load: [
            run(striker(5.0, p), start, modes=8, stop=stop) for _ in range(4)
        ]
    many = Starts.random(striker(5.0), 2000, seed=2)
    found["ensemble, N = 8"] = lambda: simulate_many(
        striker(5.0), many, modes=8, stop=Stop(impacts=200, periodic=False), **one
    )
    found["one case, 32 modes"] = lambda: [stability_of(o) for o in steady_states(pneumatic(), modes=32).orbits]
    found["one case with proof, energy, stroke"] = lambda: whole(pneumatic())
    r, factor = np.linspace(0.0, 0.9, 400)[:, None], np.linspace(0.001, 1.0, 400)
    found["plane 400²"] = lambda: stability_plane(pneumatic(), r, factor)
    three = System(s=20.0, d=0.0048, restitution=0.6, load=Load.fourier([0.5, 1.0, 0.3j, 0.2]))
    found["plane 400², 3 harmonics"] = lambda: stability_plane(three, r, factor)
    found["exact plane 60², N = 16"] = lambda: exact_plane(pneumatic(), r[::7], factor[::7], modes=16)
    orbit = steady_states(pneumatic(5.0)).orbits[1]
    for modes in (64, 256, 1024):
        found[f"all multipliers, N = {modes}"] = lambda m=modes: floquet_multipliers(orbit, m)
    cells = [
        pneumatic().with_restitution(float(a)).with_load_factor(float(b)) for a in r[::16, 0] for b in factor[5::16]
    ]
    for modes in (0, 8):
        found[f"label map 25², N = {modes}"] = lambda m=modes: simulate_many(
            cells, Starts.rigid(time=np.full(len(cells), 0.3)), modes=m, **one
        )
        found[f"Lyapunov exponents, N = {modes}"] = lambda m=modes: lyapunov_many(cells[::25], modes=m)
    return found


def bodies() -> dict[str, Any]:
    """Systems with another body or law of damping; none of a checkout without them."""
    from percuss import Load, System

    try:
        from percuss.model import Kept, Ratio, UniformBar
        from percuss.model.body import External, KelvinVoigt, SteppedBar
    except ImportError:
        return {}
    kinds = {
        "damping ratio": UniformBar(5.0, Ratio(0.001)),
        "Kelvin–Voigt": UniformBar(5.0, KelvinVoigt(1e-6)),
        "stepped bar": SteppedBar(5.0, (2.0, 1.0), (1.0, 2.0), External(0.0048)),
    }
    return {name: System(body, Load.harmonic(0.7, 1.0), Kept(0.6)) for name, body in kinds.items()}


def serve() -> None:
    """Names of rows on standard input, seconds of processor time on standard output."""
    rows = tasks()
    print(json.dumps(list(rows)), flush=True)
    for line in sys.stdin:
        task = rows[line.rstrip("\n")]
        begun, times = time.process_time(), 0
        while times == 0 or time.process_time() - begun < LEAST:
            task()
            times += 1
        print((time.process_time() - begun) / times, flush=True)


class Checkout:
    """A process that imports the package from a checkout."""

    def __init__(self, path: Path) -> None:
        environment = {**os.environ, "PYTHONPATH": str(path / "src"), "OPENBLAS_NUM_THREADS": "1"}
        command = [sys.executable, str(Path(__file__).resolve()), "--serve"]
        self.process = subprocess.Popen(
            command, env=environment, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, cwd=path
        )
        assert self.process.stdout is not None
        self.rows: list[str] = json.loads(self.process.stdout.readline())

    def seconds(self, row: str) -> float:
        assert self.process.stdin is not None and self.process.stdout is not None
        print(row, file=self.process.stdin, flush=True)
        return float(self.process.stdout.readline())


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("other", nargs="?", type=Path, help="the checkout to compare with")
    parser.add_argument("--only", default="", help="rows with these words")
    parser.add_argument("--rounds", type=int, default=9)
    parser.add_argument("--serve", action="store_true", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.serve:
        serve()
        return
    if options.other is None or not (options.other / "src" / "percuss").is_dir():
        parser.error("name a checkout, a folder with src/percuss in it")
    here, there = Checkout(ROOT), Checkout(options.other.resolve())
    print(f"{'row':40s} {'here':>9s} {'there':>9s}  here/there (middle half)")
    for row in here.rows:
        if options.only not in row or row not in there.rows:
            continue
        pairs = []
        for i in range(options.rounds + 1):
            order = (here, there) if i % 2 else (there, here)
            times = {id(one): one.seconds(row) for one in order}
            pairs.append((times[id(here)], times[id(there)]))
        a, b = np.array(pairs[1:]).T  # the first compiles, or loads what was compiled
        low, middle, high = np.percentile(a / b, [25, 50, 75])
        mark = "  SLOWER" if middle > SLOWER else ""
        print(
            f"{row:40s} {np.median(a):8.4f}s {np.median(b):8.4f}s  {middle:.3f} ({low:.3f} … {high:.3f}){mark}",
            flush=True,
        )


if __name__ == "__main__":
    main()
