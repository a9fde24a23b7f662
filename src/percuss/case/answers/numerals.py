"""Numbers for people to read."""

from __future__ import annotations

import math
import shlex
import sys
from collections.abc import Iterable, Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from percuss.model import Machine, System
    from percuss.model.body import Modes
    from percuss.model.checks import Array

_PREFIXES = {-9: "n", -6: "µ", -3: "m", 0: "", 3: "k", 6: "M", 9: "G"}


def counted(size: int, what: str) -> str:
    """So many of a thing.

    Examples
    --------
    >>> counted(1, "mode"), counted(32, "mode")
    ('1 mode', '32 modes')
    """
    return f"{size} {what}{'s' if size != 1 else ''}"


def number(value: float, digits: int = 4) -> str:
    """A plain number with so many digits.

    Examples
    --------
    >>> number(2.0 / 3.0), number(-0.0), number(1234567.0)
    ('0.6667', '0', '1.235e+06')
    """
    return f"{value + 0.0:.{digits}g}"


def quantity(value: float, unit: str, digits: int = 4) -> str:
    """A value in a base unit with the prefix that suits it.

    Examples
    --------
    >>> quantity(5700.0, "J"), quantity(-1782.4, "N", 3), quantity(0.0, "m")
    ('5.7 kJ', '-1.78 kN', '0 m')
    """
    if value == 0.0 or not math.isfinite(value):
        return f"{number(value, digits)} {unit}"
    size = float(f"{abs(value):.{digits - 1}e}")
    power = min(max(3 * math.floor(math.log10(size) / 3.0), -9), 9)
    return f"{number(value / 10.0**power, digits)} {_PREFIXES[power]}{unit}"


def percent(fraction: float, digits: int = 3) -> str:
    """A fraction in percent.

    Examples
    --------
    >>> percent(0.0123)
    '1.23 %'
    """
    return f"{number(100.0 * fraction, digits)} %"


def ordinal(value: int) -> str:
    """The place of a thing in its row.

    Examples
    --------
    >>> ordinal(1), ordinal(12), ordinal(23)
    ('1st', '12th', '23rd')
    """
    ending = "th" if value % 100 in (11, 12, 13) else {1: "st", 2: "nd", 3: "rd"}.get(value % 10, "th")
    return f"{value}{ending}"


def as_typed(name: str) -> str:
    """The name of a case as it is to be typed again: '-' for standard input, quoted where a shell needs it."""
    return "-" if name == "<stdin>" else shlex.quote(name)


# ---- Values for JSON: every number finite or null, numpy's kinds as Python's own


def heading_dict(name: str, title: str, system: System, notes: Sequence[str]) -> dict[str, Any]:
    """What the answer to any question begins with: the case, the system, its recording, what was assumed."""
    history = system.load.report
    return {
        "case": name,
        "title": title,
        "system": system_dict(system),
        "body": body_dict(system),
        "contact": contact_dict(system),
        "history": None if history is None else plain(asdict(history)),
        "notes": list(notes),
    }


def system_dict(system: System) -> dict[str, Any]:
    """The system in plain values."""
    free = system.body.is_free
    return {
        "s": json_number(system.s) if free else None,
        "d": json_number(system.d) if free else None,
        **({} if free else {"gap": json_number(system.body.gap)}),
        "restitution": json_number(system.restitution),
        "coefficients": [[json_number(p.real), json_number(p.imag)] for p in system.load.coefficients.tolist()],
        "load_factor": json_number(system.load.load_factor),
    }


SHOWN_MODES = 8
"""Elastic modes that are told of a body."""


def body_dict(system: System) -> dict[str, Any]:
    """The body in plain values: its first elastic modes under the load, per radian of it, and in SI in Hz, too."""
    modes = system.body.modes(SHOWN_MODES, system.load.at)
    found: dict[str, Any] = {
        "kind": system.body.kind,
        "frequencies": numbers(modes.omega),
        "gamma": numbers(_without_rounding(modes, system) if system.body.is_free else modes.gamma),
        "damping": numbers(modes.damping),
    }
    if system.frequency is not None:
        found["frequencies_Hz"] = numbers(modes.omega * system.frequency)
    return found


_ROUNDING = 8.0 * sys.float_info.epsilon
"""Of the shape of a mode, per radian of its wave; nodes at the load have been seen within a seventh of it."""


def _without_rounding(modes: Modes, system: System) -> Array:
    """γ_n, and 0 where it is rounding: |φ_n(x_p)| at most 8 ε (1 + ω_n/s) times the greatest |φ_n| along the bar."""
    import numpy as np  # what only writes numbers has no need of it

    along = np.abs(system.body.shapes(np.linspace(0.0, 1.0, 65), modes.size).displacement).max(axis=0)
    rounding = _ROUNDING * (1.0 + modes.omega / system.s) * along
    return np.asarray(np.where(np.abs(modes.at_load) > rounding, modes.gamma, 0.0))


def contact_dict(system: System | Machine) -> dict[str, str]:
    """The contact law in plain values."""
    return {"law": system.contact.law, "strain": system.contact.kind}


def json_number(value: Any) -> float | int | None:
    """A finite number as Python has it, or None.

    Examples
    --------
    >>> json_number(1.5), json_number(math.inf), json_number(None)
    (1.5, None, None)
    """
    if value is None:
        return None
    if isinstance(value, int):
        return int(value)
    found = float(value)
    return found if math.isfinite(found) else None


def numbers(values: Iterable[Any]) -> list[float | int | None]:
    """A list of the values, each as `number` gives it: finite or None."""
    import numpy as np

    if isinstance(values, np.ndarray) and values.dtype.kind == "f" and np.isfinite(values).all():
        found: list[float | int | None] = values.tolist()
        return found
    return [json_number(value) for value in values]


def picked(one: object, names: str) -> dict[str, Any]:
    """Attributes as JSON has them, by their names, which stand with spaces between.

    Examples
    --------
    >>> picked(1.5 + 2j, "real imag")
    {'real': 1.5, 'imag': 2.0}
    """
    return {name: plain_value(getattr(one, name)) for name in names.split()}


def plain(values: dict[str, Any]) -> dict[str, Any]:
    """Numbers made finite or None; text, truth values, lists and tables of them as they are."""
    return {key: plain_value(value) for key, value in values.items()}


def plain_value(value: Any) -> Any:
    """The same of one value; a complex number is a pair."""
    if hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, dict):
        return plain(value)
    if isinstance(value, tuple | list):
        return [plain_value(item) for item in value]
    if isinstance(value, complex):
        return [json_number(value.real), json_number(value.imag)]
    return value if isinstance(value, str | bool) else json_number(value)
