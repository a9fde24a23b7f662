"""Only bodies know their frequencies and mode shapes: nπs, (−1)ⁿ and cos nπx are spelled in `model/body` alone."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import percuss

SOURCE = Path(percuss.__file__).parent

SPELLINGS = {
    "nπs": re.compile(
        r"\bpi \* (?:np\.outer\()?(?:\w+\.)*s\b|\b(?:\w+\.)*s \* (?:np|math)\.pi\b|\bnp\.pi \* (?:\w+\.)+s\b"
    ),
    "cos nπx": re.compile(r"cos\((?:np|math)\.pi \*"),
    "(−1)ⁿ": re.compile(r"% 2, -?\d\.0, -?\d\.0\)|\(-1(?:\.0)?\) ?\*\* ?"),
}

WAVES_OF_A_UNIFORM_BAR = {"steady/resting/rest_on_wall.py"}
"""The contact force of a resting uniform bar by its waves, echo by echo: a closed form of that bar alone."""


def spelled(text: str) -> list[str]:
    """What of a uniform bar's modes a text spells out."""
    return [name for name, pattern in SPELLINGS.items() if pattern.search(text)]


@pytest.mark.parametrize(
    "text",
    [
        "omega = np.pi * s * n",
        "x = math.pi * system.s",
        "np.pi * self.system.s * k",
        "np.cos(np.pi * np.outer(n, x))",
        "np.where(n % 2, -2.0, 2.0)",
        "(-1.0) ** n",
    ],
)
def test_the_spellings_are_seen(text: str) -> None:
    assert spelled(text)


@pytest.mark.parametrize("text", ["T = 2.0 * math.pi * periods", "np.pi * seconds", "s / (math.pi * k)", "n % 2 == 0"])
def test_nothing_else_is(text: str) -> None:
    assert not spelled(text)


def test_only_bodies_know_their_modes() -> None:
    files = [path for path in SOURCE.rglob("*.py") if "model/body" not in path.as_posix()]
    knowing = {path.relative_to(SOURCE).as_posix() for path in files if spelled(path.read_text(encoding="utf-8"))}
    assert knowing == WAVES_OF_A_UNIFORM_BAR
