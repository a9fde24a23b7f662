"""Peers of the simulator: the same flights and impacts computed by heyoka and by SciPy, timed and checked.

Run with an environment of its own (requirements.txt beside this file), never with the package:

    python peers.py CASES.json        # or - to read the cases from standard input

The input is {"cases": [...]}, the fields of each case being those of `Case`; the output is one JSON object (README.md).
The motion, dimensionless: modes n = 0…N with uₙ″ + d uₙ′ + (nπs)² uₙ = p(t) and p(t) = Re Σ pₖ exp(ikt), moving where
the gap y = u₀ + 2 Σ (−1)ⁿ uₙ is negative. When y reaches 0 from below, every uₙ stays and every uₙ′ becomes −R uₙ′.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # short vectors: threads only cost

import argparse
import importlib
import json
import math
import statistics
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]
Simulation = Callable[[int, int, float], list[float]]
"""(impacts, floor, seconds) → times of impact: stops after `impacts`, or after `seconds` once `floor` are there."""

RUNS = 5  # at most; fewer where the budget ends
FIRST = 5  # impacts whose times are given and compared
FLOORS = {"heyoka": 20, "scipy": FIRST}  # impacts simulated even when the budget is spent
LARGEST_MODES = 200  # above, heyoka's straight-line code takes minutes to compile: compact mode
GAP_LIMIT, TIME_LIMIT = 1e-9, 1e-7  # what the checks allow: y during the motion, times of the peers against each other
HORIZON = 200.0 * math.pi  # a flight longer than this is an impact that was missed


@dataclass(frozen=True, slots=True)
class Case:
    """One simulation. `coefficients` are p₀, p₁, … as [re, im]; the bar starts at rest with u₀ = `position`."""

    name: str
    modes: int
    s: float
    d: float
    restitution: float
    coefficients: tuple[complex, ...]
    start_time: float
    position: float
    impacts: int
    seconds_budget: float

    @classmethod
    def read(cls, table: Mapping[str, Any]) -> Case:
        """A case from its JSON table."""
        return cls(**{**table, "coefficients": tuple(complex(*pair) for pair in table["coefficients"])})

    @property
    def harmonics(self) -> list[tuple[int, float, float]]:
        """(k, a, b) for every term a cos kt + b sin kt of the load that is not zero."""
        terms = enumerate(self.coefficients[1:], 1)
        return [(k, c.real, -c.imag) for k, c in terms if c != 0]

    @property
    def frequencies(self) -> Vector:
        """nπs for n = 0…N."""
        return math.pi * self.s * np.arange(self.modes + 1, dtype=np.float64)

    @property
    def signs(self) -> Vector:
        """Weights of the modes in the gap: 1, −2, 2, −2, …"""
        return np.append(1.0, 2.0 * (-1.0) ** np.arange(1, self.modes + 1))

    @property
    def start(self) -> Vector:
        """Displacements, then velocities."""
        return np.append(self.position, np.zeros(2 * self.modes + 1))


class Heyoka:
    """heyoka's adaptive Taylor integrator, compiled for one case when made; README.md says why in this form."""

    def __init__(self, case: Case, tuned: bool = True) -> None:
        hy: Any = importlib.import_module("heyoka")
        if sys.prefix != sys.base_prefix:  # compiled code goes to the environment, not to the user's home
            hy.llvm_state.set_diskcache_path(str(Path(sys.prefix) / "heyoka-cache"))
        self.case, self.times = case, list[float]()
        self.impacts, self.floor, self.deadline = case.impacts, 0, math.inf
        modes = range(case.modes + 1)
        u = [hy.make_vars(f"u{n}") for n in modes]
        v = [hy.make_vars(f"v{n}") for n in modes]  # uₙ′ over the frequency of its mode: alike large, so longer steps
        scales = [1.0, *(float(w) if tuned else 1.0 for w in case.frequencies[1:])]
        load = hy.expression(case.coefficients[0].real)
        for k, a, b in case.harmonics:
            load += a * hy.cos(k * hy.time) + b * hy.sin(k * hy.time)
        rates = [(u[n], scales[n] * v[n]) for n in modes]
        stiffness = [0.0, *(float(w) ** 2 for w in case.frequencies[1:])]
        rates += [(v[n], (load - stiffness[n] * u[n]) / scales[n] - case.d * v[n]) for n in modes]
        gap = hy.sum([float(weight) * u[n] for n, weight in enumerate(case.signs)])
        impact = hy.t_event(gap, callback=self.impact(), direction=hy.event_direction.positive)
        compact = case.modes > LARGEST_MODES
        options = {"compact_mode": compact}
        if tuned:
            options |= {"fast_math": True, "slp_vectorize": True}
        self.integrator = hy.taylor_adaptive(rates, case.start, time=case.start_time, t_events=[impact], **options)
        self.time_limit = hy.taylor_outcome.time_limit

    def impact(self) -> Callable[[Any, int], bool]:
        """What happens at an impact: a function, since the integrator would copy any other object."""
        velocities, factor, times = slice(self.case.modes + 1, None), -self.case.restitution, self.times

        def reverse(integrator: Any, direction: int) -> bool:
            integrator.state[velocities] *= factor
            times.append(integrator.time)
            if len(times) >= self.impacts:
                return False
            return len(times) < self.floor or time.perf_counter() < self.deadline

        return reverse

    def reset(self, impacts: int, floor: int, seconds: float) -> None:
        """Back to the start."""
        self.times.clear()
        self.impacts, self.floor, self.deadline = impacts, floor, time.perf_counter() + seconds
        self.integrator.time = self.case.start_time
        self.integrator.state[:] = self.case.start
        self.integrator.reset_cooldowns()

    def simulate(self, impacts: int, floor: int, seconds: float) -> list[float]:
        """Times of impact."""
        self.reset(impacts, floor, seconds)
        outcome, before = self.time_limit, -1
        while outcome == self.time_limit:  # in pieces, so that a missed impact ends the run
            if len(self.times) == before:
                raise RuntimeError(f"no impact between t = {self.times[-1:]} and {self.integrator.time}")
            before = len(self.times)
            outcome = self.integrator.propagate_until(self.integrator.time + HORIZON)[0]
        if int(outcome) != -1:  # anything but the stop that the first and only event asked for
            raise RuntimeError(f"integration ended at t = {self.integrator.time} with outcome {outcome}")
        return self.times.copy()

    def largest_gap(self, impacts: int, samples: int = 8) -> float:
        """Largest gap inside and at the end of the steps up to that many impacts, from the Taylor polynomials."""
        self.reset(impacts, impacts, math.inf)
        integrator, largest = self.integrator, -math.inf
        end = self.case.start_time + impacts * HORIZON
        while len(self.times) < impacts and integrator.time < end and largest <= GAP_LIMIT:
            before = integrator.time
            integrator.step(write_tc=True)
            for at in np.linspace(before, integrator.time, samples + 1)[1:]:
                state = integrator.update_d_output(at)
                largest = max(largest, float(self.case.signs @ state[: self.case.modes + 1]))
        return largest


class SciPy:
    """SciPy's DOP853 from impact to impact, each found as a terminal event."""

    terminal, direction = True, 1.0  # of the event, which this object is when called

    def __init__(self, case: Case) -> None:
        self.integrate: Any = importlib.import_module("scipy.integrate").solve_ivp
        self.case, self.count = case, case.modes + 1
        self.stiffness, self.signs, self.harmonics = case.frequencies**2, case.signs, case.harmonics

    def __call__(self, t: float, state: Vector) -> float:
        """The gap."""
        return float(self.signs @ state[: self.count])

    def rate(self, t: float, state: Vector) -> Vector:
        """Velocities, then accelerations."""
        u, v = state[: self.count], state[self.count :]
        load = self.case.coefficients[0].real
        for k, a, b in self.harmonics:
            load += a * math.cos(k * t) + b * math.sin(k * t)
        rate = np.empty_like(state)
        rate[: self.count] = v
        rate[self.count :] = load - self.case.d * v - self.stiffness * u
        return rate

    def simulate(self, impacts: int, floor: int, seconds: float) -> list[float]:
        """Times of impact."""
        deadline = time.perf_counter() + seconds
        now, state, times = self.case.start_time, self.case.start, list[float]()
        options = {"method": "DOP853", "events": self, "rtol": 1e-10, "atol": 1e-12}
        while len(times) < impacts and (len(times) < floor or time.perf_counter() < deadline):
            flight = self.integrate(self.rate, (now, now + HORIZON), state, t_eval=(), **options)  # keeps no steps
            if flight.status != 1:
                raise RuntimeError(f"no impact after t = {now}: {flight.message}")
            now, state = float(flight.t_events[0][0]), flight.y_events[0][0].copy()
            state[self.count :] *= -self.case.restitution
            times.append(now)
        return times


def timed(simulate: Simulation, case: Case, floor: int) -> dict[str, Any]:
    """Median time per impact of up to `RUNS` equal runs; the first ends with a quarter of the budget, if not before."""
    runs, spent, impacts, times = list[float](), 0.0, case.impacts, list[float]()
    while not runs or (len(runs) < RUNS and spent + runs[-1] <= case.seconds_budget):
        start = time.perf_counter()
        times = simulate(impacts, floor, math.inf if runs else case.seconds_budget / 4)
        runs.append(time.perf_counter() - start)
        spent, impacts = spent + runs[-1], len(times)
    per_impact = 1e6 * statistics.median(runs) / impacts
    row = {"name": case.name, "impacts": impacts, "microseconds_per_impact": per_impact}
    return {**row, "first_times": times[:FIRST], "runs": len(runs)}


def with_heyoka(case: Case, tuned: bool = True) -> dict[str, Any]:
    """One result of heyoka, with the time that compiling took and the largest gap seen up to the first impacts."""
    start = time.perf_counter()
    peer = Heyoka(case, tuned)
    compiled = time.perf_counter() - start
    gap = peer.largest_gap(min(FIRST, case.impacts))  # also the first call, which does not count
    row = timed(peer.simulate, case, FLOORS["heyoka"])
    return {**row, "largest_gap": gap, "compile_seconds": compiled}


def with_heyoka_defaults(case: Case) -> dict[str, Any]:
    """The same with heyoka's own options and the modes as they stand in the equation."""
    return with_heyoka(case, tuned=False)


def with_scipy(case: Case) -> dict[str, Any]:
    """One result of SciPy."""
    return timed(SciPy(case).simulate, case, FLOORS["scipy"])


def measured(name: str, measure: Callable[[Case], dict[str, Any]], cases: Sequence[Case]) -> dict[str, Any]:
    """All results of a peer, or why there are none."""
    try:
        importlib.import_module(name)
    except Exception as error:  # a broken binary may raise anything: the other peer goes on
        return {"error": f"{type(error).__name__}: {error}"}
    results = list[dict[str, Any]]()
    for case in cases:
        try:
            results.append(measure(case))
        except Exception as error:  # one case that fails leaves the others
            results.append({"name": case.name, "error": f"{type(error).__name__}: {error}"})
    return {"version": version(name), "results": results}


def compared(one: Mapping[str, Any], other: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Whether heyoka stayed at y ≤ 0 and the first times of impact of the two agree, for each case that both have."""
    checks = list[dict[str, Any]]()
    for a, b in zip(one.get("results", ()), other.get("results", ()), strict=False):
        if "error" in a or "error" in b:
            continue
        difference = max(abs(x - y) for x, y in zip(a["first_times"], b["first_times"], strict=False))
        passed = difference <= TIME_LIMIT and a["largest_gap"] <= GAP_LIMIT
        checks.append({"name": a["name"], "largest_difference": difference, "passed": passed})
    return checks


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("cases", help="JSON file with the cases, - for standard input")
    source = parser.parse_args().cases
    text = sys.stdin.read() if source == "-" else Path(source).read_text(encoding="utf-8")
    cases = [Case.read(table) for table in json.loads(text)["cases"]]
    heyoka, scipy = measured("heyoka", with_heyoka, cases), measured("scipy", with_scipy, cases)
    defaults = measured("heyoka", with_heyoka_defaults, cases)
    checks = compared(heyoka, scipy) + compared(defaults, scipy)
    print(json.dumps({"heyoka": heyoka, "heyoka_defaults": defaults, "scipy": scipy, "checks": checks}))


if __name__ == "__main__":
    main()
