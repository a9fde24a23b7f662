"""What commands say as JSON, over the catalogue and 200 random hammers: recorded at one commit, compared at another.

    python tests/goldens.py record before.json
    python tests/goldens.py compare before.json

`compare` tells each number that moved by more than 1e-12 of its size, and the greatest move of each command; what
stands on one side only, and every word that changed, is told, too. A rebuilding keeps its record outside the
repository.
"""

from __future__ import annotations

import contextlib
import io
import json
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from percuss.cli.app import run
from percuss.model import External
from random_hammers import random_hammer

CLOCKED = {
    "steady": ("--periods", "1..2"),
    "simulate": (),
    "orbits": ("--label", "2/2", "--modes", "4"),
    "blow": (),
    "sweep": ("--x", "restitution=0.1:0.6:6", "--quantity", "stable,blow_energy,reduced_margin"),
    "experiment": ("--starts", "12", "--modes", "2", "--seed", "1"),
}
STRUCTURES = {"steady": (), "simulate": (), "orbits": ("--label", "2/1"), "sweep": ("--x", "restitution=0.4:0.7:4")}
VALVES = {"machine": ("--modes", "4"), "simulate": (), "experiment": ("--starts", "12", "--modes", "2", "--seed", "1")}
SAMPLES = {
    **dict.fromkeys(
        (
            "hydraulic-drifter",
            "heavy-drifter",
            "stepped-drifter",
            "mini-breaker",
            "heavy-breaker",
            "dth-4-inch",
            "dth-6-inch",
            "pneumatic-jackleg",
            "pile-hammer",
            "laboratory-striker",
        ),
        CLOCKED,
    ),
    **dict.fromkeys(("stopped-oscillator", "stopped-beam"), STRUCTURES),
    **dict.fromkeys(("valve-breaker", "valve-drifter"), VALVES),
}
RANDOM = {"steady": (), "simulate": ("--impacts", "60"), "orbits": ("--label", "2/1", "--modes", "0")}
SAME = 1e-12


def answer(*arguments: str) -> Any:
    """The JSON of a command, or what it says instead."""
    said, wrong = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(said), contextlib.redirect_stderr(wrong):
        code = run([*arguments, "--json"])
    return json.loads(said.getvalue()) if said.getvalue() else {"exit": code, "says": wrong.getvalue()}


def random_case(seed: int) -> str:
    """A random hammer of one bar as a case of plain numbers."""
    system, modes = random_hammer(seed)
    law, load = system.body.damping, system.load
    (value,) = vars(law).values()
    damping = f"d = {value}" if isinstance(law, External) else f"damping = {{kind = '{law.kind}', value = {value}}}"
    force = (
        f"kind = 'fourier'\ncoefficients = {[[p.real, p.imag] for p in load.coefficients.tolist()]}"
        if not load.breaks
        else f"kind = 'steps'\nbreaks = {list(load.breaks)}\nvalues = {list(load.values)}"
    )
    strain = "reversed" if system.contact.strain_factor < 0.0 else "kept"
    return (
        f"[system]\ns = {system.body.s}\n{damping}\nrestitution = {system.contact.restitution}\nstrain = '{strain}'\n"
        f"[load]\n{force}\n[simulation]\nmodes = {modes}\n"
    )


def answers() -> dict[str, Any]:
    """Every answer by its command line."""
    found = {}
    for sample, commands in SAMPLES.items():
        for command, options in commands.items():
            found[f"{command} {sample}"] = answer(command, sample, *options)
    with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
        for seed in range(200):
            Path("case.toml").write_text(random_case(seed), encoding="utf-8")
            for command, options in RANDOM.items():
                found[f"{command} random {seed}"] = answer(command, "case.toml", *options)
    return found


def moves(before: Any, now: Any, place: str = "") -> Iterator[tuple[str, float, str]]:
    """Where two answers differ: the place, by how much of its size, and what it was and is."""
    if isinstance(before, dict) and isinstance(now, dict):
        for key in sorted({*before, *now}):
            yield from moves(before.get(key, "nothing"), now.get(key, "nothing"), f"{place}.{key}")
    elif isinstance(before, list) and isinstance(now, list) and len(before) == len(now):
        size = max((abs(x) for x in before if isinstance(x, float)), default=0.0)
        for number, (a, b) in enumerate(zip(before, now, strict=True)):
            for where, move, text in moves(a, b, f"{place}[{number}]"):
                yield (
                    where,
                    min(move, abs(a - b) / size) if size and isinstance(a, float) and isinstance(b, float) else move,
                    text,
                )
    elif before != now:
        numbers = all(isinstance(x, int | float) and not isinstance(x, bool) for x in (before, now))
        yield (
            place,
            abs(before - now) / max(abs(before), abs(now)) if numbers else float("inf"),
            f"{before!r:.60} -> {now!r:.60}",
        )


def compared(before: dict[str, Any], now: dict[str, Any]) -> int:
    """How many places moved by more than rounding; each is printed, with the greatest move of each command."""
    greatest: dict[str, float] = {}
    told = 0
    for line in sorted({*before, *now}):
        for place, move, text in moves(before.get(line), now.get(line)):
            greatest[line.split()[0]] = max(greatest.get(line.split()[0], 0.0), move)
            if move > SAME:
                told += 1
                print(f"{line}{place}: {text} ({move:.1e})")
    print(
        f"{len(now)} answers, {told} places moved by more than {SAME}; greatest by command: {greatest or 'none at all'}"
    )
    return told


if __name__ == "__main__":
    task, file = sys.argv[1:]
    if task == "record":
        Path(file).write_text(json.dumps(answers()), encoding="utf-8")
    else:
        raise SystemExit(
            compared(json.loads(Path(file).read_text(encoding="utf-8")), json.loads(json.dumps(answers()))) > 0
        )
