"""The kinds of values that only `percuss simulate` takes."""

from __future__ import annotations

import argparse
import math
import re
from collections.abc import Callable
from typing import Any

__all__ = ["events", "start_keys", "time_or_text", "up_to", "whole"]

_MOST = 10**9


def whole(text: str) -> int:
    """A whole number, 0 or greater.

    Examples
    --------
    >>> whole("2000")
    2000
    """
    return up_to(_MOST)(text)


def up_to(most: int, beyond: str = "") -> Callable[[str], int]:
    """The kind of a whole number from 0 to `most`; `beyond` is said to those who want more.

    Examples
    --------
    >>> up_to(1000)("24")
    24
    """

    def kind(text: str) -> int:
        if not re.fullmatch(r"\d{1,10}", text, re.ASCII) or int(text) > most:
            raise argparse.ArgumentTypeError(f"'{text}': give a whole number from 0 to {most}{beyond}")
        return int(text)

    return kind


def time_or_text(text: str) -> float | str:
    """A number of radians, or text with a unit, which the case looks at.

    Examples
    --------
    >>> time_or_text("6.5"), time_or_text("20 ms")
    (6.5, '20 ms')
    """
    value = _plain(text)
    return text if value is None else value


def events(text: str) -> tuple[int | None]:
    """``all``, ``last:K`` or ``none`` as the number of last events to show, None for all; in a tuple.

    Examples
    --------
    >>> events("all"), events("last:3"), events("none")
    ((None,), (3,), (0,))
    """
    if text == "all":
        return (None,)
    if text == "none":
        return (0,)
    match = re.fullmatch(r"last:(\d{1,10})", text, re.ASCII)
    if match is None:
        raise argparse.ArgumentTypeError(f"'{text}': give all, none or last:K, for example last:20")
    return (int(match[1]),)


def start_keys(text: str) -> dict[str, Any]:
    """``position=-1,time=0.3``, ``orbit:2``, ``random`` or ``random:ringing`` as the keys of [start].

    Examples
    --------
    >>> start_keys("position=-3 cm,time=0.3")
    {'position': '-3 cm', 'time': 0.3}
    >>> start_keys("orbit:2"), start_keys("random")
    ({'orbit': 2}, {'random': 'rigid'})
    """
    found: dict[str, Any] = {}
    for part in re.split(r",(?![^\[]*\])", text):
        name, sign, value = part.strip().partition("=")
        if not sign:
            name, sign, value = name.partition(":")
        if name == "random" and not sign:
            value = "rigid"
        elif not sign or not name.strip():
            raise argparse.ArgumentTypeError(
                f"'{text}': give key=value pairs, orbit:K or random, for example position=-1,velocity=0,time=0.3"
            )
        if name.strip() in found:
            raise argparse.ArgumentTypeError(f"'{text}': {name.strip()} is given twice")
        found[name.strip()] = _value(value.strip())
    return found


def _value(text: str) -> Any:
    if text.startswith("[") and text.endswith("]"):
        return [_value(item.strip()) for item in text[1:-1].split(",") if item.strip()]
    if re.fullmatch(r"[+-]?\d{1,18}", text, re.ASCII):
        return int(text)
    value = _plain(text)
    return text if value is None else value


def _plain(text: str) -> float | None:
    try:
        value = float(text.replace("−", "-"))
    except ValueError:
        return None
    if not math.isfinite(value):
        raise argparse.ArgumentTypeError(f"'{text}': expected a finite number")
    return value
