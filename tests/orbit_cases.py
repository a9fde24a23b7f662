"""The figures of tests/data/orbits.json: orbits, special points and cycles with rest, made by two other programs.

One works in doubles with the equations for the impact times, the other with 40 digits by Newton's method on the map
from impact to impact; each orbit was also followed for a cycle by a simulation.
"""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np

from percuss import Load, System
from percuss.model.checks import Array
from percuss.steady import PeriodicOrbit

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
