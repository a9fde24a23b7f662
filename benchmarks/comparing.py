"""The benchmarks of this checkout beside those of another commit, group by group in turn, row by row."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections.abc import Iterable
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
OTHER = ROOT / "build" / "bench" / "other"
WORSE = 1.05
TURNS = 3
"""How often a row that looks worse is measured again, in both: only what is worse each time is."""

_FIGURE = re.compile(r"([\d.]+)\s*(µs|ms|s|/s)")
_SECONDS = {"µs": 1e-6, "ms": 1e-3, "s": 1.0}


def compared(reference: str, groups: Iterable[str]) -> int:
    """Prints every row with its figure there, here, and the ratio; the number of rows that are worse."""
    git = ["git", "-C", str(ROOT)]
    subprocess.run([*git, "worktree", "remove", "--force", str(OTHER)], capture_output=True, check=False)
    subprocess.run([*git, "worktree", "add", "--quiet", "--detach", str(OTHER), reference], check=True)
    try:
        return sum(_group(name, reference) for name in groups)
    finally:
        subprocess.run([*git, "worktree", "remove", "--force", str(OTHER)], check=True)


def _group(name: str, reference: str) -> int:
    before, now = _rows(OTHER, name), _rows(ROOT, name)
    worse = {row for row in now if row in before and _ratio(before[row], now[row]) > WORSE}
    for _ in range(TURNS - 1):
        if not worse:
            break
        again, anew = _rows(OTHER, name), _rows(ROOT, name)
        worse = {row for row in worse if row in again and row in anew and _ratio(again[row], anew[row]) > WORSE}
    for row, figure in now.items():
        there = before.get(row, "–")
        ratio = f"{_ratio(there, figure):.2f}" if _seconds(there) and _seconds(figure) else "–"
        print(f"| {row} | {reference} {there} | {figure} | {ratio} |{' WORSE' if row in worse else ''}", flush=True)
    return len(worse)


def _rows(checkout: Path, name: str) -> dict[str, str]:
    """The figures of a group in a checkout, by their rows, from a process of its own."""
    environment = {**os.environ, "PYTHONPATH": str(checkout / "src")}
    script = [sys.executable, str(checkout / "benchmarks" / "run.py"), "--only", name]
    done = subprocess.run(script, cwd=checkout, env=environment, capture_output=True, text=True, check=False)
    if done.returncode:
        print(f"{name} fails in {checkout}: {done.stderr.strip().splitlines()[-1:]}", file=sys.stderr)
        return {}
    lines = [line.strip("| \n").split(" | ") for line in done.stdout.splitlines() if line.startswith("| ")]
    return {line[0]: line[1] for line in lines[2:]}


def _seconds(figure: str) -> tuple[float, float] | None:
    """A figure as seconds, or as what is done in one turned over, and half of its last digit; None for others."""
    found = _FIGURE.fullmatch(figure)
    if found is None or not float(found[1]):
        return None
    number, half = float(found[1]), 0.5 * 10.0 ** -len(found[1].partition(".")[2])
    if found[2] == "/s":
        return 1.0 / number, half / number**2
    return number * _SECONDS[found[2]], half * _SECONDS[found[2]]


def _ratio(before: str, now: str) -> float:
    """How much worse a figure is, in the best case of what was rounded; 1 for what is no time."""
    there, here = _seconds(before), _seconds(now)
    return 1.0 if there is None or here is None else (here[0] - here[1]) / (there[0] + there[1])
