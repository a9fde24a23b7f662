"""Benchmarks of machines that switch their own valve: motions, steady cycles, maps, and the first use of the kernels.

Processor time throughout, as far as it is one thread's: wall time depends on who else uses the machine.
"""

from __future__ import annotations

import os
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from typing import Any

import numpy as np

from percuss import Load, Start, Stop, System, run
from percuss.case import CaseFamily, Limit, Span, design, load_case, tolerance
from percuss.explore import diagram, follow, sweep
from percuss.explore.continuation.machine_cycles import MachineCurve
from percuss.explore.continuation.walk import CurvePoint
from percuss.explore.family import SystemFamily
from percuss.model import Chamber, External, Kept, Machine, Port, UniformBar, Valve
from percuss.steady import ValveCycle, self_excited_motion
from percuss.steady.self_excited.event_sequence import sequence_of

Row = tuple[str, str, str, str]
IMPACTS = 2000
ROUNDS = 11
STEPS, STEP = 40, 2e-3  # along a branch
BAR = UniformBar(5.0, External(0.0048))


def machine(reads: Any = "centre", stiffness: float = 0.0) -> Machine:
    """Two ports with delays."""
    rear = Port("power", 1.0, "back", 0.2, reads)
    front = Port("return", 0.1, "front", 0.05, reads)
    valve = Valve({"return": -0.5, "power": 1.0}, (rear, front), chamber=Chamber(0.0, stiffness))
    return Machine(BAR, valve, Kept(0.6))


def spent(task: Callable[[], object], times: int) -> float:
    """Processor time of a call."""
    begin = time.process_time()
    for _ in range(times):
        task()
    return (time.process_time() - begin) / times


def motions() -> list[Row]:
    """Motions with all events and states recorded, each beside the clocked square load on the same bar, in turn."""
    stop, start = Stop(impacts=IMPACTS, periodic=False), Start.rigid(-1.0, time=0.3)
    clocked = System(BAR, Load.square(1.0, 1.3), Kept(0.6))
    rows: list[Row] = []
    for what, one, modes in (
        ("ports that read the centre", machine(), 0),
        ("ports that read the centre", machine(), 8),
        ("ports that read the centre", machine(), 32),
        ("ports that read the driven end", machine(0.0), 32),
        ("gas chamber", machine(stiffness=0.1), 32),
    ):

        def own(one: Machine = one, modes: int = modes) -> object:
            return run(one, modes=modes, stop=stop)

        def other(modes: int = modes) -> object:
            return run(clocked, start, modes=modes, stop=stop)

        own(), other()
        pairs = 1e6 / IMPACTS * np.array([(spent(own, 5), spent(other, 5)) for _ in range(ROUNDS)])
        ratios = pairs[:, 0] / pairs[:, 1]
        low, ratio, high = np.quantile(ratios, (0.25, 0.5, 0.75))
        text = (
            f"{ratio:.2f} × the clocked square load, exact steps ({np.median(pairs[:, 1]):.2f} µs); "
            f"middle half {low:.2f} to {high:.2f}"
        )
        rows.append((f"{what}, µs per impact, N = {modes}", f"{np.median(pairs[:, 0]):.2f} µs", "2 ×", text))
    return rows


def cycles() -> list[Row]:
    """Steady cycles with their proof and all multipliers; the last settles slowly and is followed until it is near."""
    rows: list[Row] = []
    for what, one in (
        ("steady cycle and multipliers, valve-breaker", load_case("valve-breaker").machine()),
        ("steady cycle and multipliers, valve-drifter", load_case("valve-drifter").machine()),
        ("steady cycle and multipliers, ports that read the driven end", machine(0.0)),
        ("steady cycle after following, ports that read the centre", machine()),
    ):

        def task(one: Machine = one) -> object:
            cycle = self_excited_motion(one, modes=32).cycle
            return cycle and cycle.multiplier

        task()
        times = [spent(task, 3) for _ in range(ROUNDS)]
        text = f"middle half {1e3 * np.quantile(times, 0.25):.1f} to {1e3 * np.quantile(times, 0.75):.1f} ms"
        goal = "–" if "after following" in what else "20 ms"
        rows.append((f"{what}, N = 32", f"{1e3 * np.median(times):.1f} ms", goal, text))
    return rows


def flowing() -> list[Row]:
    """Cycles of machines whose oil flows: settled from rest, and solved for beside one that is known; a map."""
    rows: list[Row] = []
    for name in ("oil-drifter", "oil-breaker"):
        one = load_case(name).machine()
        for modes, goal in ((0, "2 ms"), (16, "100 ms")):
            cycle = self_excited_motion(one, modes=modes).cycle
            assert cycle is not None
            times = 20 if modes == 0 else 2
            settled = spent(lambda n=modes, m=one: self_excited_motion(m, modes=n), times)
            beside = spent(lambda n=modes, m=one, c=cycle: self_excited_motion(m, modes=n, near=c), times)
            told = f"{1e3 * settled:.1f} ms from rest"
            rows.append((f"a cycle with all losses, {name}, N = {modes}", f"{1e3 * beside:.1f} ms", goal, told))
    family = CaseFamily(load_case("oil-breaker"), {"load.supply.flow": "l/min", "contact.restitution": ""})
    cells = 20
    axes = (f"load.supply.flow=100:150 l/min:{cells}", f"contact.restitution=0.05:0.3:{cells}")
    _ = sweep(family, *(axis[:-2] + "2" for axis in axes), quantities=["blow_energy"], modes=0, workers=1)  # loads
    taken = spent(lambda: sweep(family, *axes, quantities=["blow_energy"], modes=0, workers=1), 1)
    told = f"{cells}² cells, {1e3 * taken / cells**2:.1f} ms each, one process"
    rows.append(
        ("a map of 100² machines whose oil flows, two cores", f"{taken * 1e4 / cells**2 / 2:.0f} s", "60 s", told)
    )
    breaker = self_excited_motion(load_case("oil-breaker").machine(), modes=0).cycle
    assert breaker is not None
    alone = spent(lambda: self_excited_motion(breaker.machine, modes=0, near=breaker), 20)
    for name, ends, of in (
        ("restitution", (0.05, 0.3), {}),
        ("load.supply.flow", (110.0, 140.0), {"family": family, "value": 130.0}),
    ):
        points = follow(breaker, name, ends, **of).values.size
        each = spent(lambda n=name, e=ends, o=of: follow(breaker, n, e, **o), 1) / points
        told = f"{points} points, {each / alone:.0f} × a cycle solved for beside one"
        rows.append((f"a point of a branch over {name}, oil-breaker, N = 0", f"{1e3 * each:.1f} ms", "15 ms", told))
    return rows


def followed() -> list[Row]:
    """A continued cycle of a machine without proofs, and a branch with them; systems are made anew at every point."""
    rows: list[Row] = []
    for modes, goal in ((0, "0.2 ms"), (16, "1 ms")):
        cycle = self_excited_motion(load_case("valve-breaker").machine(), modes=modes).cycle
        assert cycle is not None
        tick, sequence = cycle.period / (2.0 * np.pi), sequence_of(cycle)
        family, here = SystemFamily(cycle.machine), (cycle.contact.restitution,)
        begin = MachineCurve(family, ("restitution",), (0.0625,), sequence, modes, tick)
        point = begin.settled(begin.unknowns(cycle, *here))

        def walked(begin: MachineCurve = begin, point: CurvePoint = point) -> None:
            curve, now = begin.of(begin.sequence), point
            for _ in range(STEPS):
                now = curve.corrected(now.x + STEP * now.tangent, now.tangent, now.tangent, now)

        def branch(cycle: ValveCycle = cycle) -> int:
            return int(follow(cycle, "restitution", (0.05, 0.4)).values.size)

        walked()
        number = branch()
        point_of = 1e3 * float(np.median([spent(walked, 1) for _ in range(ROUNDS)])) / STEPS
        whole = 1e3 * float(np.median([spent(branch, 1) for _ in range(3)])) / number
        beside = f"with proofs, events and multipliers {whole:.2f} ms for each of {number} points"
        rows.append((f"a continued cycle, valve-breaker, N = {modes}", f"{point_of:.3f} ms", goal, beside))
    return rows


def diagrams() -> list[Row]:
    """A diagram as it is made unless anything else is asked for, on one core."""
    one = load_case("valve-breaker").machine()
    diagram(one, "restitution=0.1:0.2:2", modes=0, workers=1)  # which compiles, or loads what was compiled
    start = time.process_time()
    found = diagram(one, "restitution=0.05:0.6", workers=1)
    took = time.process_time() - start
    told = f"{len(found.branches)} branches, {len(found.settled)} settled motions, on one core"
    return [(f"a default diagram, valve-breaker, N = {found.modes}", f"{took:.1f} s", "20 s", told)]


def maps(cells: int = 100) -> list[Row]:
    """A plane of rigid machines."""
    axes, what = (
        (f"restitution=0:0.6:{cells}", f"ports[0].behind=0.4:2:{cells}"),
        ["blow_energy", "rate", "stroke", "stall"],
    )

    def task() -> object:
        return sweep(machine(), *axes, quantities=what, modes=0, workers=1)

    sweep(machine(), "restitution=0:0.6:2", quantities=what, modes=0, workers=1)
    times = [spent(task, 1) for _ in range(3)]
    return [
        (
            f"sweep of {cells}² rigid machines",
            f"{np.median(times):.2f} s",
            "5 s",
            f"{1e6 * np.median(times) / cells**2:.0f} µs for each cell",
        )
    ]


_FIRST = """\
from percuss import Load, Start, Stop, System, run
from percuss.model import Kept, Machine, Port, UniformBar, Valve
stop, bar = Stop(impacts=3, periodic=False), UniformBar(5.0)
def clocked():
    run(System(bar, Load.square(1.0, 1.3), Kept(0.6)), Start.rigid(-1.0, time=0.3), modes=2, stop=stop)
def switched():
    ports = [Port("power", behind=1.0, side="back"), Port("return", on="impact")]
    run(Machine(bar, Valve({"return": -0.5, "power": 1.0}, ports), Kept(0.6)), modes=2, stop=stop)
"""


def first_use() -> list[Row]:
    """The first motion, whose kernels are compiled: alone, and in one process after those of a clocked load."""

    def compiled(calls: str) -> float:
        with tempfile.TemporaryDirectory() as folder:
            before = resource.getrusage(resource.RUSAGE_CHILDREN)
            environment = os.environ | {"NUMBA_CACHE_DIR": folder}
            subprocess.run([sys.executable, "-c", _FIRST + calls], check=True, env=environment)
            after = resource.getrusage(resource.RUSAGE_CHILDREN)
        return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime

    clocked, switched, both = (compiled(calls) for calls in ("clocked()", "switched()", "clocked(); switched()"))
    beside = f"{switched / clocked:.2f} × that of a clocked load ({clocked:.1f} s); both in one process {both:.1f} s"
    return [("first motion of a machine, with its compilation", f"{switched:.1f} s", "–", beside)]


def designs() -> list[Row]:
    """The best hammer over five numbers, on a pump and with 3 m of steel, under four limits."""
    supply = {"flow": "60 l/min", "accumulator": "2.5 cm^3/bar"}
    case = load_case("valve-drifter").varied({"load.supply": supply})
    limits = [
        Limit.parsed("blow_rate=45..60Hz", "want", True), Limit.parsed("steel.stress=430MPa", "below", True),
        Limit.parsed("pressure=200bar", "below", True), Limit.parsed("margin=0.05", "above", True),
    ]  # fmt: skip
    ranges = (
        "load.ports[0].behind=15:30mm load.ports[1].behind=2:8mm load.supply.flow=40:80l/min bar.diameter=44:54mm "
        "load.states.power.rear=5:8cm^2"
    )
    begin = time.process_time()
    found = design(case, [Span.parsed(one) for one in ranges.split()], "rock_power", limits)
    seconds = time.process_time() - begin
    told = f"{found.hammers} hammers, {1e3 * seconds / found.hammers:.0f} ms each, of processor time in one process"
    return [("best hammer over five numbers, on a pump, 3 m of steel", f"{seconds:.0f} s", "60 s", told)]


def tolerances() -> list[Row]:
    """Hammers within the usual tolerances of a drawing, each with its blow by waves."""
    case, rows = load_case("valve-breaker"), []
    for name, supply in (("", {}), (", on a pump", {"flow": "133 l/min", "accumulator": "2.5 cm^3/bar"})):
        here = case.varied({"load.supply": supply}) if supply else case
        begin, before = time.perf_counter(), time.process_time()
        found = tolerance(here)
        seconds, own = time.perf_counter() - begin, time.process_time() - before
        size = found.job.size
        told = (
            f"{size} hammers of 32 modes, {1e3 * seconds / size:.1f} ms each; {own:.0f} s of processor in one process"
        )
        rows.append((f"spread within the tolerances of a drawing{name}", f"{seconds:.0f} s", "30 s", told))
    return rows


def machines() -> list[Row]:
    """All rows of machines."""
    return [
        *motions(),
        *cycles(),
        *flowing(),
        *followed(),
        *diagrams(),
        *maps(),
        *designs(),
        *tolerances(),
        *first_use(),
    ]
