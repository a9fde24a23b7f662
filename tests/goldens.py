"""What commands say as JSON, over the catalogue and 200 random hammers: recorded at one commit, compared at another.

    python tests/goldens.py record before.json
    python tests/goldens.py compare before.json [WORD ...]

With words only the answers are compared whose command line holds one of them.

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
from collections.abc import Iterator, Sequence
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
            "drill-string",
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
BRANCHES = {
    "hydraulic-drifter": ("load_factor=0.3:1.2", "restitution=0.05:0.4", ("--modes", "4")),
    "stopped-oscillator": ("mean=-0.3:0.6", "restitution=0.7:0.9", ()),
    "stopped-beam": ("mean=-20N:20N", "restitution=0.5:0.7", ()),
}
"""Of a sample the parameters along and over which its branches are followed, and options."""
RANDOM = {"steady": (), "simulate": ("--impacts", "60"), "orbits": ("--label", "2/1", "--modes", "0")}
VALVE_SWEEP = ("--x", "pressure=150bar:170bar:3", "--quantity", "runs,blow_energy,rate")
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


def lines() -> Iterator[tuple[str, tuple[str, ...]]]:
    """Every answer by its name, with its command line; "case.toml" is of the random hammer in the name."""
    for sample, commands in SAMPLES.items():
        for command, options in commands.items():
            yield f"{command} {sample}", (command, sample, *options)
    for sample, (along, over, options) in BRANCHES.items():
        yield f"follow {sample}", ("follow", sample, "--along", along, *options)
        yield f"curves {sample}", ("follow", sample, "--along", along, "--curve", "all", "--over", over, *options)
        sized = ("--label", "1/1", "--starts", "2", "--runs", "1")
        yield f"diagram {sample}", ("diagram", sample, "--along", f"{along}:4", *sized, *options)
        yield f"reach {sample}", ("steady", sample, "--reach", *options)
    for modes in ("0", "4"):
        for sample in ("valve-breaker", "valve-drifter"):
            yield f"machine {sample} {modes}", ("machine", sample, "--modes", modes)
        yield f"sweep valve {modes}", ("sweep", "valve-breaker", *VALVE_SWEEP, "--modes", modes)
    yield "basins stopped-oscillator", ("basins", "stopped-oscillator", "--x", "time=0:6.2:8", "--y", "velocity=-2:0:8")
    for seed in range(200):
        for command, options in RANDOM.items():
            yield f"{command} random {seed}", (command, "case.toml", *options)


def answers(words: Sequence[str] = ()) -> dict[str, Any]:
    """Every answer whose name holds one of the words, by its name; all without words."""
    found = {}
    with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
        for name, arguments in lines():
            if not words or any(word in name for word in words):
                if " random " in name:
                    Path("case.toml").write_text(random_case(int(name.split()[-1])), encoding="utf-8")
                found[name] = answer(*arguments)
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
    task, file, *words = sys.argv[1:]
    now = json.loads(json.dumps(answers(words)))
    if task == "record":
        Path(file).write_text(json.dumps(now), encoding="utf-8")
    else:
        before = json.loads(Path(file).read_text(encoding="utf-8"))
        raise SystemExit(compared({name: before[name] for name in before if not words or name in now}, now) > 0)
