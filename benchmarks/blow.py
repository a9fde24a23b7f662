"""Benchmarks of the blow: one blow, a sweep of blows, and beside the lattice of elwaspatid, error and time.

The peer runs in the environment of the peers, build/peers (benchmarks/peers/README.md).
"""

from __future__ import annotations

import json
import subprocess
import time
from collections.abc import Callable
from typing import Any

import numpy as np

from percuss.blow import Feed, Joint, Rock, Rod, strike
from percuss.blow.periods import run_by_waves, strike_repeatedly
from percuss.model import Bar, Kept, Load, Ratio, Section, SectionedBar, System
from percuss.simulate import Start, Stop
from simulation import PEERS, ROOT, environment_of_peers

Row = tuple[str, str, str, str]
MODULUS = 206e9

# Sections (length m, diameter m), diameter of the endless rod, and the exact impulse in N·s at 11 m/s: in rational
# arithmetic, as tests/blow does it.
PISTONS = {
    "uniform striker": ((((0.5, 0.04),), 0.08), 86.80848820399318),
    "drifter piston, three sections": ((((0.0731, 0.04), (0.2187, 0.05), (0.1493, 0.03478)), 0.06), 75.0015155608182),
}
SPEED, UNTIL = 11.0, 3e-4
CELLS = (4, 16, 64)
SWEPT = 10_000
TRANSITS = 251.0  # of the bar in a load period: s = 40
PERIODS = 20


def seconds(task: Callable[[], object], runs: int = 9) -> float:
    """Median wall time of a call, after one that does not count."""
    task()
    times = []
    for _ in range(runs):
        start = time.perf_counter()
        task()
        times.append(time.perf_counter() - start)
    return float(np.median(times))


def piston(sections: tuple[tuple[float, float], ...]) -> SectionedBar:
    return SectionedBar([Section(length, diameter=d, youngs_modulus=MODULUS) for length, d in sections])


def blow() -> list[Row]:
    """The rows."""
    return [*beside_lattice(), *with_rock(), *repeated(), *machines()]


def beside_lattice() -> list[Row]:
    """The same blows by percuss and by the lattice: time, and error of the impulse."""
    found = peer()
    rows: list[Row] = []
    for name, ((sections, diameter), exact) in PISTONS.items():
        striker, rod = piston(sections), Rod([Section(None, diameter=diameter, youngs_modulus=MODULUS)])
        error = abs(strike(striker, rod, SPEED, until=UNTIL).impulse / exact - 1.0)
        ours = seconds(lambda striker=striker, rod=rod: strike(striker, rod, SPEED, until=UNTIL).impulse)  # type: ignore[misc]
        theirs = [row for row in found.get("elwaspatid", {}).get("results", ()) if row["name"] == name]
        beside = "; ".join(
            f"elwaspatid, {row['cells']} cells: {row['seconds'] / ours:.2g} × the time, "
            f"error {abs(row['impulse'] / exact - 1.0):.1g}"
            for row in theirs
        )
        figures = f"error {error:.1g}; {beside or found.get('missing', 'no peer')}"
        rows.append((f"blow on an endless rod, {name}", f"{1e3 * ours:.2f} ms", "–", figures))
    return rows


def peer() -> dict[str, Any]:
    """What elwaspatid finds; a message where it cannot be had."""
    python = PEERS / "bin" / "python"
    missing = environment_of_peers()
    if missing:
        return {"missing": missing}
    cases = [
        {
            "name": name, "sections": sections, "rod_diameter": diameter, "velocity": SPEED, "until": UNTIL,
            "cells": cells,
        }
        for name, ((sections, diameter), _) in PISTONS.items()
        for cells in CELLS
    ]  # fmt: skip
    done = subprocess.run(
        [str(python), str(ROOT / "peers" / "lattice_peer.py"), "-"],
        input=json.dumps({"cases": cases}),
        capture_output=True,
        text=True,
    )
    if done.returncode:
        return {"missing": f"elwaspatid failed: {done.stderr.strip().splitlines()[-1]}"}
    found: dict[str, Any] = json.loads(done.stdout)
    return found


def with_rock() -> list[Row]:
    """A piston of three sections, a rod of two, rock; and a sweep of such blows on one core."""
    striker = piston(PISTONS["drifter piston, three sections"][0][0])
    until = 20.0 * striker.transit_time

    def drill(stiffness: float) -> Rod:
        sections = [Section(0.4, diameter=0.045), Section(1.1, diameter=0.038)]
        return Rod(sections, "rock", bit_mass=1.5, rock=Rock(stiffness, unloading_ratio=0.3))

    one = seconds(lambda: strike(striker, drill(4e8), 10.0, until=until).efficiency)
    rows = [("blow: 3 + 2 sections, bit, rock, 20 transits", f"{1e3 * one:.1f} ms", "20 ms", "efficiency and energies")]
    lengths, stiffnesses = np.linspace(0.15, 0.6, 100), np.geomspace(5e7, 2e9, SWEPT // 100)
    begun = time.perf_counter()
    for length in lengths:
        hammer = Bar(float(length), diameter=0.04)
        for stiffness in stiffnesses:
            _ = strike(hammer, drill(float(stiffness)), 10.0, until=4.0 * hammer.transit_time + 1e-3).efficiency
    whole = time.perf_counter() - begun
    beside = f"{1e3 * whole / SWEPT:.2f} ms for a blow, one core"
    rows.append(
        (f"sweep of {SWEPT} blows: length of a hammer, stiffness of the rock", f"{whole:.1f} s", "60 s", beside)
    )
    return rows


def repeated() -> list[Row]:
    """60 blows of a drifter of 18 kW on two rods, each with the waves of those before; and of a short tool, exactly."""
    piston, rod = Bar(0.6, 1.03e-3), {"area": 1.03e-3}
    tool = Rod(
        [Section(0.5, **rod), Section(3.66, **rod), Section(3.66, **rod)], "rock", bit_mass=2.2,
        joints=[Joint(2, mass=1.8)], attenuation=(0.0, 0.004, 0.004), rock=Rock(2.5e8, 0.2), feed=Feed(8e3),
    )  # fmt: skip
    taken = seconds(lambda: strike_repeatedly(piston, tool, 10.9, 1.0 / 60.0, 60, estimate=False), 3)
    cells = strike_repeatedly(piston, tool, 10.9, 1.0 / 60.0, 1, cells=400, estimate=False).lattice
    beside = f"{cells.steps} steps a blow, {sum(cells.cells)} cells"
    short = Rod(
        [Section(1.0, **rod)], "rock", bit_mass=2.0, attenuation=0.06, rock=Rock(4e8, 0.1),
        feed=Feed(1.2e4, damping=8e3),
    )  # fmt: skip
    exact = seconds(lambda: strike_repeatedly(piston, short, 10.0, 6e-3, 60), 3)
    return [
        ("60 blows of an 18 kW drifter with their waves", f"{taken:.1f} s", "5 s", beside),
        ("60 blows on a short tool with a damper, exact waves", f"{exact:.1f} s", "5 s", ""),
    ]


def machines() -> list[Row]:
    """A load period of a damped machine at s = 40, every contact resolved by waves."""
    section = Section(0.5, diameter=0.04, youngs_modulus=MODULUS)
    bars = {"uniform bar": SectionedBar([section], Ratio(2e-3))}
    name = "drifter piston, three sections"
    bars[name] = SectionedBar(piston(PISTONS[name][0][0]).sections, Ratio(2e-3))
    endless = Rod([Section(None, diameter=0.06, youngs_modulus=MODULUS)])
    drill = [Section(3.0, diameter=0.05), Section(0.12, diameter=0.06)]
    rods = {"on an endless rod": endless, "on a rod with bit and rock": Rod(drill, "rock", rock=Rock(4e8, 0.3))}
    rows = []
    for bar_name, bar in bars.items():
        for rod_name, rod in rods.items():
            load = Load.harmonic(900.0, 2000.0, frequency=1.0 / (TRANSITS * bar.transit_time))
            system, stop = System.from_si(bar, load, Kept(0.3)), Stop(time=PERIODS * 2.0 * np.pi, periodic=False)

            def motion(system: System = system, rod: Rod = rod, stop: Stop = stop) -> object:
                return run_by_waves(system, rod, Start.rigid(), stop, estimate=False)

            cells = run_by_waves(system, rod, Start.rigid(), stop, estimate=False).lattice.cells
            period = seconds(motion, 5) / PERIODS
            beside = f"{sum(cells)} cells of bar and rod"
            rows.append((f"machine by waves, s = 40, {bar_name} {rod_name}", f"{1e3 * period:.1f} ms", "20 ms", beside))
    return rows
