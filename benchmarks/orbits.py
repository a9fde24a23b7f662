"""Orbits of any kind: a point of a branch, a cascade, a search, beside shooting with SciPy and beside plain numpy.

Processor time throughout: wall time depends on who else uses the machine.
"""

from __future__ import annotations

import math
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable

import numpy as np

from percuss import Load, System
from percuss.explore import diagram, follow
from percuss.explore.continuation.orbit_curve import SolutionCurve
from percuss.explore.continuation.walk import CurvePoint
from percuss.explore.family import SystemFamily
from percuss.steady import PeriodicOrbit, orbit_near, orbits

Row = tuple[str, str, str, str]
STEP = 2e-3
GOALS = {0: 0.1, 16: 0.5, 64: 2.0}
TIMES = {1: [2.35], 2: [0.39, 2.32], 4: None}


def hammer(mean: float = 0.62, d: float = 0.0048) -> System:
    return System(s=5.0, d=d, restitution=0.5, load=Load.harmonic(mean, 1.0))


def median(task: Callable[[], object], runs: int = 7) -> float:
    """Median time of a call in seconds, after one that does not count."""
    task()
    times = []
    for _ in range(runs):
        start = time.process_time()
        task()
        times.append(time.process_time() - start)
    return float(np.median(times))


def begun(orbit: PeriodicOrbit) -> tuple[SolutionCurve, CurvePoint]:
    """The curve of an orbit over the mean load, and its point on it."""
    curve = SolutionCurve(SystemFamily(orbit.system), "mean", orbit.impacts, orbit.periods, orbit.modes, 0.25)
    x = curve.unknowns(orbit, orbit.system.load.mean)
    return curve, curve.corrected(x, curve.level)


def walked(orbit: PeriodicOrbit, steps: int) -> CurvePoint:
    """Points along a branch, each with its tangent, without proofs; the systems are made anew."""
    curve, here = begun(orbit)
    for _ in range(steps):
        here = curve.corrected(here.x + STEP * here.tangent, here.tangent)
    return here


def walked_plainly(orbit: PeriodicOrbit, steps: int) -> CurvePoint:
    """The same by the plain form of the equations, array by array."""
    curve, here = begun(orbit)
    for _ in range(steps):
        x = here.x + STEP * here.tangent
        for _ in range(10):
            matrix = curve.matrix(x)
            moved = np.linalg.solve(np.vstack([matrix, here.tangent]), -np.append(curve.motion(x).residuals, 0.0))
            x = x + moved
            if np.abs(moved).max() < 1e-9:
                break
        tangent = np.linalg.solve(np.vstack([matrix, here.tangent]), np.append(np.zeros(x.size - 1), 1.0))
        here = CurvePoint(x, tangent / np.linalg.norm(tangent), 0)
    return here


def shot(mean: float, orbit: PeriodicOrbit, near: np.ndarray) -> np.ndarray:
    """What a user would do: the phase and the velocities after an impact that come back, by shooting.

    SciPy integrates the modes from impact to impact and seeks the root of the map.
    """
    from scipy.integrate import solve_ivp
    from scipy.optimize import root

    system, modes = orbit.system, orbit.modes
    frequencies = np.pi * system.s * np.arange(modes + 1)
    signs = np.append(1.0, 2.0 * (-1.0) ** np.arange(1, modes + 1))

    def rate(t: float, y: np.ndarray) -> np.ndarray:
        u, v = y[: modes + 1], y[modes + 1 :]
        return np.concatenate([v, mean + math.cos(t) - system.d * v - frequencies**2 * u])

    def gap(t: float, y: np.ndarray) -> float:
        return float(signs @ y[: modes + 1])

    gap.terminal, gap.direction = True, 1.0  # type: ignore[attr-defined]  # scipy reads them off the function

    def back(x: np.ndarray) -> np.ndarray:
        now, state = float(x[0]), np.concatenate([[-signs[1:] @ x[1 : modes + 1]], x[1:]])
        for _ in range(orbit.impacts):
            flight = solve_ivp(rate, (now, now + 30.0), state, "DOP853", events=gap, rtol=1e-11, atol=1e-13)
            now, state = float(flight.t_events[0][0]), flight.y_events[0][0].copy()
            state[modes + 1 :] *= -system.restitution
        found: np.ndarray = np.concatenate([[now - orbit.period], state[1:]]) - x
        return found

    found = root(back, near, tol=1e-10)
    assert np.abs(found.fun).max() < 1e-7
    return np.asarray(found.x)


def shooting(orbit: PeriodicOrbit) -> float:
    """Seconds for one orbit of a branch by shooting, from its neighbour."""
    state = orbit.states[0]
    near = np.concatenate(
        [[orbit.times[0]], state.rebound, [orbit.rigid_rebounds[0]], -orbit.system.restitution * state.velocity]
    )
    start = time.process_time()
    shot(orbit.system.load.mean + 1e-3, orbit, near)
    return time.process_time() - start


def points() -> list[Row]:
    """One continued orbit, for several p and N."""
    rows: list[Row] = []
    for modes, goal in GOALS.items():
        for p, times in TIMES.items():
            system = hammer(0.6 if p == 4 else 0.62)
            orbit = (
                orbits(system, p, modes=modes).orbits[0] if times is None else orbit_near(system, times, modes=modes)
            )
            assert orbit is not None
            one = median(lambda o=orbit: walked(o, 40)) / 40  # type: ignore[misc]
            plain = median(lambda o=orbit: walked_plainly(o, 10), 3) / 10  # type: ignore[misc]
            beside = f"{plain / one:.0f} times faster than the same equations in numpy"
            if modes == 0:
                beside += f", {shooting(orbit) / one:.0f} times faster than shooting with SciPy"
            rows.append((f"a point of a branch, z={p}/1, N = {modes}", f"{1e3 * one:.3f} ms", f"{goal} ms", beside))
    few = orbit_near(hammer(), [0.39, 2.32], modes=2)
    assert few is not None
    one = median(lambda: walked(few, 40)) / 40
    beside = f"{shooting(few) / one:.0f} times faster than shooting with SciPy"
    rows.append(("the same, z=2/1, N = 2", f"{1e3 * one:.3f} ms", "–", beside))
    return rows


def branches() -> list[Row]:
    """Whole branches with proofs and events, each of another load, so that nothing is known from before."""
    rows: list[Row] = []
    for modes in (0, 8, 32):
        times, size = [], 0
        for i in range(6):
            orbit = orbit_near(hammer(0.62 + 1e-6 * i, 0.0048 + 1e-6 * i), [0.39, 2.32], modes=modes)
            assert orbit is not None
            start = time.process_time()
            size = follow(orbit, "mean", (0.3, 1.2)).values.size
            times.append(time.process_time() - start)
        told = f"{1e3 * np.median(times[1:]) / size:.1f} ms for each of {size} points"
        rows.append((f"a branch with proofs, z=2/1, N = {modes}", f"{np.median(times[1:]):.3f} s", "–", told))
    first = orbit_near(hammer(0.68, 0.0), [2.35], modes=0)
    assert first is not None
    cascade = median(lambda: follow(first, "mean", (0.58, 0.75), switch=5), 3)
    label = follow(first, "mean", (0.58, 0.75), switch=5).cascade[-1].label
    rows.append(
        (f"a cascade of flips to {label}, N = 0", f"{cascade:.2f} s", "2 s", "with proofs, events and switching")
    )
    return rows


def searches() -> list[Row]:
    """Searches with 10³ tries."""
    rows: list[Row] = []
    for p, modes in ((3, 0), (3, 16), (6, 0)):
        found = median(lambda p=p, n=modes: orbits(hammer(), p, modes=n, tries=1000), 3)  # type: ignore[misc]
        goal = "2 s" if (p, modes) == (3, 0) else "–"
        rows.append((f"search of z={p}/1, 10³ tries, N = {modes}", f"{found:.3f} s", goal, f"{found:.3f} ms per try"))
    return rows


def diagrams() -> list[Row]:
    """A diagram as it is made unless anything else is asked for, on one core."""
    system = System(s=20.0, d=0.0048, restitution=0.5, load=Load.harmonic(0.7, 1.0))
    start = time.process_time()
    found = diagram(system, "load_factor=0.3:1.2:120", workers=1)
    took = time.process_time() - start
    told = f"{len(found.branches)} branches, {len(found.settled)} settled motions, on one core"
    return [(f"a default diagram, N = {found.modes}", f"{took:.1f} s", "60 s", told)]


def compiling() -> list[Row]:
    """The kernels for orbits, compiled into an empty cache."""
    code = (
        "import time; from percuss import Load, System; from percuss.explore import follow; "
        "from percuss.steady import orbit_near; start = time.process_time(); "
        "system = System(s=5.0, d=0.0, restitution=0.5, load=Load.harmonic(0.62, 1.0)); "
        "follow(orbit_near(system, [0.39, 2.32], modes=1), 'mean', (0.61, 0.63)); print(time.process_time() - start)"
    )
    with tempfile.TemporaryDirectory() as folder:
        around = os.environ | {"NUMBA_CACHE_DIR": folder}
        done = subprocess.run([sys.executable, "-c", code], env=around, check=True, capture_output=True, text=True)
    seconds = float(done.stdout)
    return [("compiling the kernels for orbits, once", f"{seconds:.0f} s", "30 s", "and loading numba")]


def orbits_of_any_kind() -> list[Row]:
    """All of them."""
    return [*points(), *branches(), *searches(), *diagrams(), *compiling()]
