"""The figures of tests/data/orbits.json: orbits, special points and cycles with rest, made by two other programs.

One works in doubles with the equations for the impact times, the other with 40 digits by Newton's method on the map
from impact to impact; each orbit was also followed for a cycle by a simulation.
"""

from __future__ import annotations

import itertools
import json
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import strategies as st

from percuss import Kept, Load, System
from percuss.explore import BranchEvent, SystemFamily, follow
from percuss.model import External, KelvinVoigt, ModalBody, Mounted, Ratio, Reversed, UniformBar
from percuss.model.checks import Array
from percuss.steady import PeriodicOrbit, RestCycle, rest_cycles

ENTRIES: dict[str, dict[str, Any]] = {
    entry["name"]: entry
    for entry in json.loads((Path(__file__).parent / "data" / "orbits.json").read_text(encoding="utf-8"))
}


def of_kind(kind: str) -> list[str]:
    """Names of the entries of a kind whose system is a free bar."""
    return [
        name for name, entry in ENTRIES.items() if entry["kind"] == kind and "structure" not in entry.get("system", {})
    ]


def system_of(entry: dict[str, Any], mean: float | None = None) -> System:
    """The system of an entry, with another mean load if one is given."""
    given = entry["system"]
    form = given["load"]
    if form["kind"] == "fourier":
        load = Load.fourier(form["coefficients"])
    elif form["kind"] == "square":
        load = Load.square(form["amplitude"], form["kappa"])
    else:
        load = Load.steps(form["breaks"], form["values"])
    if mean is not None:
        load = load.with_mean(mean)
    return System(s=given["s"], d=given["d"], restitution=given["restitution"], load=load)


def periods_of(entry: dict[str, Any]) -> int:
    """n of the label."""
    return int(entry["label"].rpartition("/")[2])


def times_of(entry: dict[str, Any]) -> Array:
    """When the impacts are, unwrapped."""
    flights = [float(flight) for flight in entry["flight_times"]]
    return float(entry["impacts"][0]["phase"]) + np.append(0.0, np.cumsum(flights)[:-1])


def numbers(point: dict[str, Any], key: str) -> Array:
    """A number of every impact."""
    return np.array([float(impact[key]) for impact in point["impacts"]])


def orbit_at(entry: dict[str, Any], point: dict[str, Any]) -> PeriodicOrbit:
    """The orbit at a point of a branch, with the figures' own impact times: all in one period, or one in each."""
    phases = numbers(point, "phase")
    periods = phases.size if entry["name"] == "cascade" else 1
    times = phases + (2.0 * math.pi * np.arange(phases.size) if periods > 1 else 0.0)
    system = system_of(entry, float(point["value"]))
    return PeriodicOrbit(system, periods, tuple(times.tolist()), entry["system"]["modes"])


@dataclass(frozen=True)
class Made:
    """A family of systems that a function makes of the values of parameters."""

    of: Callable[..., System]

    def system(self, values: Mapping[str, float]) -> System:
        return self.of(**values)

    def check(self, names: Mapping[str, str]) -> None: ...

    def describe(self) -> dict[str, Any]:
        return {}


def only(system: System, modes: int = 0) -> RestCycle:
    """The one cycle with rest."""
    (cycle,) = rest_cycles(system, modes=modes).orbits
    return cycle


def after(calls: int) -> Callable[[], bool]:
    """What tells a computation to stop once it has asked so often."""
    asked = itertools.count(1)
    return lambda: next(asked) > calls


TABLE = ModalBody((0.6, 2.3, 7.1), (0.05, 0.1, 20.0), (1.0, 0.8, 0.3), (1.0, -0.5, 0.0), 0.3)


@st.composite
def motions(draw: st.DrawFn) -> PeriodicOrbit:
    """The motion through impacts at any times: most are no orbits, but all linearise the same way."""
    law = draw(
        st.sampled_from([External(0.0), External(0.03), External(0.9), Ratio(2e-3), Ratio(1.0), KelvinVoigt(0.1)])
    )
    contact = draw(st.sampled_from([Kept, Reversed]))(
        draw(st.sampled_from([0.0, 0.4, 0.9, 1.0]) | st.floats(0.0, 0.95))
    )
    load = draw(st.sampled_from([
        Load.harmonic(0.5, 1.0), Load.fourier([0.4, 1.0, 0.3j, -0.2]), Load.square(1.0, 1.3),
        Load.steps([0.2, 1.0, 3.0], [1.5, -0.3, -0.4]),
    ]))  # fmt: skip
    p, n = draw(st.integers(1, 5)), draw(st.integers(1, 3))
    flights = 0.1 + 0.9 * np.array(draw(st.lists(st.floats(0.0, 1.0), min_size=p, max_size=p)))
    times = 0.3 + 2.0 * math.pi * n * np.append(0.0, np.cumsum(flights / flights.sum())[:-1])
    speed, gap = draw(st.sampled_from([0.7, 1.9, 6.1])), draw(st.sampled_from([-0.4, 0.0, 0.7]))
    body, modes = UniformBar(speed, law), draw(st.sampled_from([0, 1, 4, 20]))
    held = draw(st.sampled_from([None, None, None, Mounted(0.6, 0.1, speed, law, gap), TABLE]))
    if held is not None:
        body, contact, modes = held, Kept(contact.restitution), min(max(modes, 1), held.most_modes or modes)
    return PeriodicOrbit(System(body, load, contact), n, tuple(times.tolist()), modes)


def both_ways(orbit: PeriodicOrbit, name: str, between: tuple[float, float], room: float = 1e-9) -> bool:
    """Every point of a branch is an orbit, nothing is lost, and from another orbit of it the same events are met.

    Whether there was another one: a place at an end may have just ceased to be one.
    """
    branch = follow(orbit, name, between)
    assert BranchEvent.LOST not in {point.kind for point in branch.points}
    assert all(point.orbit.residual < 1e-9 for point in branch.points)
    middle, family = branch.values.size // 3, SystemFamily(orbit.system)
    there, times = float(branch.values[middle]), tuple(branch.times[middle].tolist())
    other = PeriodicOrbit(family.system({name: there}), orbit.periods, times, orbit.modes, orbit.rebound).from_first
    if not other.admissible:
        return False
    again = follow(other, name, between, family=family, value=there)
    expected, found = ([(p.kind.value, p.value) for p in one.points] for one in (branch, again))
    if expected[0][0] == "closed":
        expected, found = sorted(expected[1:-1]), sorted(found[1:-1])
    elif expected[0][0] != found[0][0] or abs(expected[0][1] - found[0][1]) > 1e-8:
        found.reverse()
    assert [kind for kind, _ in found] == [kind for kind, _ in expected]
    assert [at for _, at in found] == pytest.approx([at for _, at in expected], rel=room, abs=room)
    return True
