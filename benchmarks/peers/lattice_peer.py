"""A peer of the blow: the same strikers on a long rod, by elwaspatid's lattice, timed.

Run with an environment of its own (requirements.txt beside this file), never with the package:

    python lattice_peer.py CASES.json        # or - to read the cases from standard input

The input is {"cases": [{"name", "sections": [[length m, diameter m], …], "rod_diameter", "velocity", "until",
"cells"}]}, all of one material (E = 206 GPa, 7850 kg/m³); `cells` is the number in the shortest section. The output is
one JSON object: for each case the impulse and the contact time that elwaspatid finds, and the median seconds of a run.
"""

from __future__ import annotations

import contextlib
import io
import json
import statistics
import sys
import time
import warnings
from importlib.metadata import version
from itertools import pairwise
from pathlib import Path
from typing import Any

MODULUS, DENSITY = 206e9, 7850.0
ROD = 0.6  # m: its far end lets every wave out, so the length is only for the picture
RUNS = 5


def blow(case: dict[str, Any]) -> tuple[float, float]:
    """(impulse, contact time): the striker is one segment whose cross-section changes, so that its steps can pull."""
    import elwaspatid

    sections = case["sections"]
    length = sum(one[0] for one in sections)
    cells = round(length / (min(one[0] for one in sections) / case["cells"]))
    diameters = [sections[0][1], case["rod_diameter"]]
    bar = elwaspatid.BarSet([MODULUS] * 2, [DENSITY] * 2, [length, ROD], diameters, nmin=cells, right="infinite")
    place = 0.0
    for (before, _), (_, diameter) in pairwise(sections):
        place += before
        bar.changeSection(0, l=place, d=diameter)
    elwaspatid.WP2(bar, nstep=int(case["until"] / bar.dt), left="free", Vinit=case["velocity"])
    force = -bar.seg[0].Force[:, -1]  # it counts tension
    return float(force.sum() * bar.dt), float((force > 0.0).sum() * bar.dt)


def timed(case: dict[str, Any]) -> dict[str, Any]:
    """A case's row of the output."""
    times, found = [], (0.0, 0.0)
    for _ in range(RUNS + 1):
        begun = time.perf_counter()
        with contextlib.redirect_stdout(io.StringIO()), warnings.catch_warnings():
            warnings.simplefilter("ignore")
            found = blow(case)
        times.append(time.perf_counter() - begun)
    return {
        "name": case["name"], "cells": case["cells"], "impulse": found[0], "contact_time": found[1],
        "seconds": statistics.median(times[1:]),
    }  # fmt: skip


def main() -> None:
    text = sys.stdin.read() if sys.argv[1] == "-" else Path(sys.argv[1]).read_text(encoding="utf-8")
    import matplotlib

    matplotlib.use("Agg")  # elwaspatid imports it
    rows = [timed(case) for case in json.loads(text)["cases"]]
    json.dump({"elwaspatid": {"version": version("elwaspatid"), "results": rows}}, sys.stdout)


if __name__ == "__main__":
    main()
