"""Benchmarks of the cells of maps: planes of orbits with their multipliers, and label maps by simulation.

Wall time depends on who else uses the machine, so that processor time (user and system, all threads) stands beside it.
"""

from __future__ import annotations

import resource
import time
from collections.abc import Callable

import numpy as np

from percuss import Load, Starts, System, simulate_many
from percuss.explore.lyapunov import lyapunov_many
from percuss.stability import exact_plane, floquet_multipliers, stability_plane
from percuss.steady import Orbit, steady_states

Row = tuple[str, str, str, str]


def pneumatic(s: float = 20.0) -> System:
    return System(s=s, d=0.0048, restitution=0.6, load=Load.harmonic(0.9, 1.0))


def grid(cells: int) -> tuple[np.ndarray, np.ndarray]:
    """Restitutions and load factors of a plane."""
    return np.linspace(0.0, 0.9, cells)[:, None], np.linspace(1.0 / cells, 1.0, cells)


def clocked(task: Callable[[], object]) -> tuple[float, float]:
    """Wall time and processor time of a call."""
    before, start = resource.getrusage(resource.RUSAGE_SELF), time.perf_counter()
    task()
    wall, after = time.perf_counter() - start, resource.getrusage(resource.RUSAGE_SELF)
    return wall, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def reduced(cells: int = 1000) -> list[Row]:
    """Orbits and B77's criterion."""
    r, factor = grid(cells)
    wall, cpu = min(clocked(lambda: stability_plane(pneumatic(), r, factor)) for _ in range(3))
    return [(f"pneumatic plane, {cells}²: orbits and reduced verdict", f"{wall:.2f} s", "1 s", f"CPU {cpu:.2f} s")]


def exact(cells: int = 1000, modes: int = 16) -> list[Row]:
    """The same with exact multipliers, beside one orbit at a time."""
    r, factor = grid(cells)
    exact_plane(pneumatic(), r[:2], factor[:2], modes=modes)
    rows: list[Row] = []
    for s in (20.0, 1.0):
        system = pneumatic(s)
        plane = stability_plane(system, r, factor)
        wall, cpu = clocked(lambda system=system, plane=plane: exact_plane(system, r, factor, 1, modes, plane=plane))  # type: ignore[misc]
        orbits = int(plane.roots.sum())
        single = pneumatic(s).with_load_factor(0.45)
        alone = [clocked(lambda orbit=orbit: floquet_multipliers(orbit, modes))[1] for orbit in _fresh(single, 20)]  # type: ignore[misc]
        beside = (
            f"CPU {cpu:.1f} s, {1e6 * cpu / max(orbits, 1):.1f} µs for each of {orbits} orbits; one at a time "
            f"{1e6 * float(np.median(alone)):.0f} µs"
        )
        rows.append((f"pneumatic plane, {cells}², s = {s:g}: exact, N = {modes}", f"{wall:.1f} s", "60 s", beside))
    return rows


def _fresh(system: System, times: int) -> list[Orbit]:
    """The stable orbit of a system, again and again, with nothing of it computed."""
    return [steady_states(system).orbits[-1] for _ in range(times)]


def labels(cells: int = 200) -> list[Row]:
    """Label maps: one motion for each cell, to its attractor."""
    r, factor = grid(cells)
    base = pneumatic()
    rows: list[Row] = []
    for modes, goal in ((0, "60 s"), (8, "180 s")):

        def task(modes: int = modes) -> object:
            systems = [base.with_restitution(float(a)).with_load_factor(float(b)) for a in r[:, 0] for b in factor]
            return simulate_many(systems, Starts.rigid(time=np.full(cells**2, 0.3)), modes=modes)

        simulate_many(base, Starts.rigid(time=np.full(2, 0.3)), modes=modes)
        wall, cpu = clocked(task)
        beside = f"CPU {cpu:.1f} s, {1e6 * cpu / cells**2:.0f} µs for each cell"
        rows.append((f"label map, {cells}², N = {modes}", f"{wall:.1f} s", goal, beside))
    return rows


def exponents(cells: int = 20) -> list[Row]:
    """Lyapunov exponents: 500 and then 2000 impacts for each cell."""
    r, factor = grid(cells)
    base = pneumatic()
    systems = [base.with_restitution(float(a)).with_load_factor(float(b)) for a in r[:, 0] for b in factor]
    rows: list[Row] = []
    for modes, goal in ((0, "–"), (8, "78 s")):
        lyapunov_many(systems[:2], modes=modes)
        wall, cpu = clocked(lambda modes=modes: lyapunov_many(systems, modes=modes))  # type: ignore[misc]
        beside = f"CPU {1e3 * cpu / cells**2:.1f} ms for each cell"
        rows.append((f"Lyapunov exponents, {cells}², N = {modes}", f"{wall:.1f} s", goal, beside))
    return rows


def explore_cells() -> list[Row]:
    """All rows."""
    return [*reduced(), *exact(), *labels(), *exponents()]


if __name__ == "__main__":
    for row in explore_cells():
        print(f"| {' | '.join(row)} |", flush=True)
