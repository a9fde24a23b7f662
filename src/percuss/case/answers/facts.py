"""What is told of an answer, each figure once: its keys, what it is called and means, and how it is found.

Answers hold tables of `Fact`. JSON (`json_of`), lines and tables of reports (`rows_of`, `grid_of`) and the reference
(`reference_of`) are made from them; a `Teller` says a value with the unit of its hammer, so that no line is written
twice, with units and without. `Report` is all that stands between an answer and what prints it.
"""

from __future__ import annotations

import csv
import io
import math
import re
import shlex
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import TYPE_CHECKING, Any, Generic, NamedTuple, TypeVar

if TYPE_CHECKING:
    from percuss.model import Machine, System


# ---- Numbers for people to read, and for JSON

_PREFIXES = {-9: "n", -6: "µ", -3: "m", 0: "", 3: "k", 6: "M", 9: "G"}


def counted(size: int, what: str) -> str:
    """So many of a thing: ``1 mode``, ``32 modes``."""
    return f"{size} {what}{'s' if size != 1 else ''}"


def number(value: float, digits: int = 4) -> str:
    """A plain number with so many digits; −0 is 0."""
    return f"{value + 0.0:.{digits}g}"


def quantity(value: float, unit: str, digits: int = 4) -> str:
    """A value in a base unit with the prefix that suits it.

    >>> quantity(5700.0, "J"), quantity(-1782.4, "N", 3), quantity(0.0, "m"), quantity(math.inf, "s")
    ('5.7 kJ', '-1.78 kN', '0 m', 'inf s')
    """
    if value == 0.0 or not math.isfinite(value):
        return f"{number(value, digits)} {unit}"
    size = float(f"{abs(value):.{digits - 1}e}")
    power = min(max(3 * math.floor(math.log10(size) / 3.0), -9), 9)
    return f"{number(value / 10.0**power, digits)} {_PREFIXES[power]}{unit}"


def measured(value: float, unit: str, digits: int = 4) -> str:
    """A value in its unit, with a prefix where it can have one: ``5.7 kJ``, ``9.1 m/s``, ``2.993 N·s``, ``0.4``."""
    if unit.isalpha() and unit != "rad":
        return quantity(value, unit, digits)
    return f"{number(value, digits)} {unit}".rstrip()


def percent(fraction: float, digits: int = 3) -> str:
    """A fraction in percent: ``1.23 %``, ``1150 %``."""
    return f"{number(100.0 * fraction, digits if abs(fraction) < 10.0 else 4)} %"


def settles(largest: float, each: str = "cycle") -> str:
    """How soon a stable motion has forgotten a disturbance, of which each blow or cycle leaves this part at the most.

    >>> settles(0.2003, "blow"), settles(0.0)
    ('a disturbance settles to 1 % in 3 blows', 'a disturbance settles to 1 % in 1 cycle')
    """
    number_of = 1 if largest <= 0.01 else math.ceil(math.log(0.01) / math.log(largest))
    return f"a disturbance settles to 1 % in {counted(number_of, each)}"


def of_tool(words: str, tool: object) -> str:
    """A text about the wall, said of the tool where the hammer has one.

    >>> of_tool("from rest on the wall", "a rod"), of_tool("from rest on the wall", None)
    ('from rest on the tool', 'from rest on the wall')
    """
    return words if tool is None else words.replace("the wall", "the tool")


def every(periods: int) -> str:
    """How often something comes that comes once in so many load periods."""
    return "every load period" if periods == 1 else f"in {periods} load periods"


def rhythm(label: str, blow: str = "blow") -> str:
    """What a label z=p/n says.

    >>> rhythm("z=1/2"), rhythm("z=3/1")
    ('one blow in 2 load periods', '3 blows every load period')
    """
    impacts, periods = (int(part) for part in label.removeprefix("z=").split("/"))
    return f"{f'one {blow}' if impacts == 1 else f'{impacts} {blow}s'} {every(periods)}"


def ordinal(value: int) -> str:
    """The place of a thing in its row.

    >>> ordinal(1), ordinal(12), ordinal(23)
    ('1st', '12th', '23rd')
    """
    ending = "th" if value % 100 in (11, 12, 13) else {1: "st", 2: "nd", 3: "rd"}.get(value % 10, "th")
    return f"{value}{ending}"


def as_typed(name: str) -> str:
    """The name of a case as it is to be typed again: '-' for standard input, quoted where a shell needs it."""
    return "-" if name == "<stdin>" else shlex.quote(name)


def table_text(heads: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """A table as CSV."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(heads)
    writer.writerows(rows)
    return text.getvalue()


# ---- Values for JSON: every number finite or null, numpy's kinds as Python's own


def json_number(value: Any) -> float | int | None:
    """A finite number as Python has it, or None."""
    if value is None or isinstance(value, int):
        return value if value is None else int(value)
    found = float(value)
    return found if math.isfinite(found) else None


def numbers(values: Iterable[Any]) -> list[float | int | None]:
    """A list of the values, each finite or None."""
    found: list[float | int | None] = plain_value(values if hasattr(values, "tolist") else list(values))
    return found


def picked(one: object, names: str) -> dict[str, Any]:
    """Attributes as JSON has them, by their names, which stand with spaces between."""
    return {name: plain_value(getattr(one, name)) for name in names.split()}


def plain(values: dict[str, Any]) -> dict[str, Any]:
    """Numbers made finite or None; text, truth values, lists and tables of them as they are."""
    return {key: plain_value(value) for key, value in values.items()}


def plain_value(value: Any) -> Any:
    """The same of one value; a complex number is a pair."""
    if hasattr(value, "tolist"):
        import numpy as np

        if value.dtype.kind in "fiu" and np.isfinite(value).all():
            return value.tolist()  # as the longest lists are: not number by number
        value = value.tolist()
    if isinstance(value, dict):
        return plain(value)
    if isinstance(value, tuple | list):
        return [plain_value(item) for item in value]
    if isinstance(value, complex):
        return [json_number(value.real), json_number(value.imag)]
    return value if isinstance(value, str | bool) else json_number(value)


# ---- What is told of an answer, each figure once: its keys, what it is called and means, and how it is found


S = TypeVar("S")

_UNITS = {
    "Hz": ("rate", 1.0, "Hz"), "per_min": ("rate", 60.0, "blows/min"),
    "s": ("time", 1.0, "s"), "us": ("time", 1e6, "µs"),
    "m": ("length", 1.0, "m"), "mm": ("length", 1e3, "mm"), "m_s": ("speed", 1.0, "m/s"), "N": ("force", 1.0, "N"),
    "kN": ("force", 1e-3, "kN"), "J": ("energy", 1.0, "J"), "kW": ("power", 1e-3, "kW"),
    "cm3": ("volume", 1e6, "cm³"), "l_per_min": ("flow", 6e4, "l/min"), "Pa": ("pressure", 1.0, "Pa"),
}  # fmt: skip
"""Endings of keys: the dimension, the factor from its SI unit, and how the unit is written."""

_PREFIXED = {"length": "m", "time": "s", "force": "N", "energy": "J", "power": "W", "stress": "Pa"}
_AS_IT_IS = {"speed": "m/s", "momentum": "N·s", "rate": "Hz"}


@dataclass(frozen=True)
class Teller:
    """Says values of a hammer with their units; those of one without scales as plain numbers.

    Without a hammer the values are in SI, or have no scales at all.

    >>> Teller(None, True)(0.0021, "time"), Teller(None, False)(0.0021, "time"), Teller(None, True)(9.1, "speed")
    ('2.1 ms', '0.0021 rad', '9.1 m/s')
    """

    hammer: System | Machine | None
    is_si: bool

    @classmethod
    def of(cls, hammer: System | Machine) -> Teller:
        """That of a system or a machine."""
        return cls(hammer, hammer.is_si)

    def scale(self, dimension: str) -> float:
        """What a value is multiplied by for SI; 1 where there are no scales."""
        hammer = self.hammer
        if not dimension or hammer is None or not self.is_si:
            return 1.0
        if dimension == "rate":
            return 1.0 / hammer.time_scale
        if dimension == "cycles":
            return float(getattr(hammer, "frequency", None) or 1.0)
        if dimension in ("pressure", "volume", "flow"):  # of oil: 1 is the pressure for which the forces hold
            pressure = getattr(hammer, "pressure", None) or 1.0
            work = {"volume": hammer.energy_scale, "flow": hammer.power_scale}.get(dimension)
            return pressure if work is None else work / pressure
        return float(getattr(hammer, f"{dimension}_scale"))

    def __call__(self, value: float, dimension: str, digits: int = 4, plain: int | None = None) -> str:
        """A value in words; a plain number has `plain` digits, if it is to have others."""
        if not self.is_si or not dimension:
            return number(value, plain or digits) + (" rad" if self.unit(dimension) else "")
        value *= self.scale(dimension)
        if dimension in _PREFIXED:
            return quantity(value, _PREFIXED[dimension], digits)
        return f"{number(value, digits)} {_AS_IT_IS[dimension]}"

    def unit(self, dimension: str) -> str:
        """The base unit of such a value; "" where it has none."""
        if self.is_si:
            return {**_PREFIXED, **_AS_IT_IS}.get(dimension, "")
        return "rad" if dimension == "time" and not hasattr(self.hammer, "valve") else ""

    def given(self, value: float, unit: str) -> str:
        """A value in a unit as keys end in it, such as "per_min"."""
        dimension, factor, name = _UNITS[unit]
        return f"{number(value * self.scale(dimension) * factor)} {name}"


def scales_of(hammer: System | Machine, keys: str) -> dict[str, Any] | None:
    """What dimensionless numbers are multiplied by for SI, by keys such as ``speed_m_s``; None without scales."""
    if not hammer.is_si:
        return None
    return {key: float(getattr(hammer, f"{key.partition('_')[0]}_scale")) for key in keys.split()}


class Fact(NamedTuple, Generic[S]):
    """A figure of an answer.

    keys
        Its names in JSON, with spaces between: one that ends in a unit, such as ``stroke_mm``, or begins with ``si.``
        stands under ``si``, any other is dimensionless. "" where it is told in reports alone.
    label
        What it is called before its value, or above its column; "" where it is told in JSON alone.
    meaning
        One sentence, for the reference.
    dimension
        As `Teller` scales it; "rate" per unit of time, "cycles" per load period; "" for a number.
    value
        Of the subject, dimensionless, or the path of its attributes that leads there; None where there is none.
    words
        The text behind the label, where value and unit do not say it, as `said` has it; None for no line.
    """

    keys: str
    label: str
    meaning: str
    dimension: str
    value: str | Callable[[S], Any]
    words: str | Callable[[S, Teller], str | None] | None = None

    def found(self, subject: Any) -> Any:
        """The value of a subject; None, too, where an attribute on its path is None."""
        return _at(subject, self.value) if isinstance(self.value, str) else self.value(subject)

    @property
    def plain_key(self) -> str | None:
        """The key of the dimensionless value."""
        return _plain_key(self)

    def unit(self, key: str) -> str:
        """The unit that a key of it ends in, as in `_UNITS`; "" for none."""
        of = "rate" if self.dimension == "cycles" else self.dimension
        endings = (unit for unit, (known, _, _) in _UNITS.items() if known == of and key.endswith(f"_{unit}"))
        return max(endings, key=len, default="")


@cache  # the answer to a slider asks for some thirty
def _plain_key(fact: Fact[Any]) -> str | None:
    return next((key for key in fact.keys.split() if not fact.unit(key) and not key.startswith("si.")), None)


def _at(subject: Any, path: str) -> Any:
    """What attributes lead to; None where one of them is None, or there is no path."""
    for name in path.split(".") if path else ():
        subject = None if subject is None else getattr(subject, name)
    return subject if path else None


_FIGURE = re.compile(r"\{([\w.]+):?(\w*)\}")


def said(words: str | Callable[[S, Teller], str | None], subject: S, tell: Teller) -> str | None:
    """A text with figures in braces, by their paths and dimensions; None where one of them is None.

    In place of a dimension may stand ``percent``, or a unit as keys end in it, such as ``kW``: None without scales.

    >>> said("{real} and {imag:length} of it, {imag:percent}", 2.0 + 0.5j, Teller(None, True))
    '2 and 500 mm of it, 50 %'
    """
    if not isinstance(words, str):
        return words(subject, tell)
    texts = []
    for path, dimension in _FIGURE.findall(words):
        value = _at(subject, path)
        if value is None:
            return None
        if dimension in _UNITS and not tell.is_si:
            return None  # there are no units
        known = tell.given if dimension in _UNITS else tell
        texts.append(percent(value) if dimension == "percent" else known(value, dimension))
    return _FIGURE.sub(lambda _: texts.pop(0), words)


def figures(table: str) -> tuple[Fact[Any], ...]:
    """Figures that JSON alone has, without units, one in a line: key, meaning and, if the key is none, its attributes.

    A line that ends in a bar is that of what stands there besides, such as an object of its own.

    >>> plain_of(2.0 + 1.0j, figures("real | of a number\\nother | the other part | imag"))
    {'real': 2.0, 'other': 1.0}
    """
    rows = [[cell.strip() for cell in f"{line} ".split(" | ")] for line in table.strip().splitlines()]
    return tuple(Fact(key, "", meaning, "", path[0] if path else key) for key, meaning, *path in rows)


def plain_of(subject: S | None, facts: Iterable[Fact[S]]) -> dict[str, Any]:
    """The dimensionless figures as JSON has them; null without a subject."""
    keyed = ((fact.plain_key, fact) for fact in facts)
    return {key: None if subject is None else plain_value(fact.found(subject)) for key, fact in keyed if key}


def si_of(subject: S | None, facts: Iterable[Fact[S]], tell: Teller) -> dict[str, Any] | None:
    """The figures with units as JSON has them; None without a subject, or scales."""
    if subject is None or not tell.is_si:
        return None
    found = {}
    for fact in facts:
        value = fact.found(subject)
        for key in fact.keys.split():
            if key != fact.plain_key:
                unit = fact.unit(key)
                factor = tell.scale(fact.dimension) * (_UNITS[unit][1] if unit else 1.0)
                found[key.removeprefix("si.")] = None if value is None else plain_value(value * factor)
    return found


def json_of(subject: S | None, facts: Iterable[Fact[S]], tell: Teller) -> dict[str, Any]:
    """The figures without units, and those with them under `si`."""
    facts = tuple(facts)
    return {**plain_of(subject, facts), "si": si_of(subject, facts, tell)}


def flat_of(subject: S, facts: Iterable[Fact[S]], tell: Teller) -> dict[str, Any]:
    """The figures without units and those with them side by side; the latter are null without scales."""
    facts = tuple(facts)
    found = si_of(subject, facts, tell)
    keys = (key for fact in facts for key in fact.keys.split() if key != fact.plain_key)
    return {**plain_of(subject, facts), **(dict.fromkeys(keys) if found is None else found)}


def rows_of(subject: S, facts: Iterable[Fact[S]], tell: Teller) -> list[tuple[str, str]]:
    """The lines of a report: label and text."""
    rows = []
    for fact in (fact for fact in facts if fact.label):
        if fact.words is not None:
            text = said(fact.words, subject, tell)
        else:
            value = fact.found(subject)
            text = None if value is None else tell(value, fact.dimension)
        if text is not None:
            rows.append((fact.label, text))
    return rows


def grid_of(heading: str, subjects: Iterable[S], facts: Iterable[Fact[S]], tell: Teller) -> Grid:
    """A table of a report: a line for each subject, a column for each figure with a label, its unit in the head."""
    shown = [(fact, "" if fact.words else tell.unit(fact.dimension)) for fact in facts if fact.label]
    heads = tuple(f"{fact.label} [{unit}]" if unit else fact.label for fact, unit in shown)
    return Grid(heading, heads, tuple(tuple(_cell(one, fact, tell) for fact, _ in shown) for one in subjects))


def _cell(subject: S, fact: Fact[S], tell: Teller) -> str:
    if fact.words is not None:
        return said(fact.words, subject, tell) or ""
    value = fact.found(subject)
    digits = 9 if fact.dimension == "time" else 6
    return "" if value is None else number(value * tell.scale(fact.dimension), digits)


def reference_of(facts: Iterable[Fact[Any]], si: bool | None) -> str:
    """The figures as a table of the reference, those under `si`, the others, or both: keys, and what they mean."""
    lines = ["| key | value |", "|---|---|"]
    for fact in facts:
        keys = [key.removeprefix("si.") for key in fact.keys.split() if si is None or (key != fact.plain_key) == si]
        if keys:
            lines.append(f"| {', '.join(f'`{key}`' for key in keys)} | {fact.meaning} |")
    return "\n".join(lines)


# ---- What a report is made of: a title, a summary, sections of labelled lines, and grids of figures


GOOD, BAD, PLAIN = "good", "bad", ""


@dataclass(frozen=True)
class ReportSection:
    """A heading and its lines: (label, text). `tone` says whether the news is good, bad or neither."""

    heading: str
    rows: tuple[tuple[str, str], ...]
    tone: str = PLAIN
    level: int = 1


@dataclass(frozen=True)
class Grid:
    """A heading and a table: the names of its columns, and its rows; all but the first column are figures."""

    heading: str
    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]


@dataclass(frozen=True)
class Report:
    """What `percuss.cli.report_printing` prints."""

    title: str
    summary: str
    tone: str
    sections: tuple[ReportSection | Grid, ...]

    def of_tool(self, tool: object) -> Report:
        """The same, said of the tool in place of the wall where the hammer has one."""
        parts: list[ReportSection | Grid] = []
        for part in self.sections:
            heading = of_tool(part.heading, tool)
            if isinstance(part, Grid):
                rows = tuple(tuple(of_tool(cell, tool) for cell in row) for row in part.rows)
                columns = tuple(of_tool(name, tool) for name in part.columns)
                parts.append(replace(part, heading=heading, columns=columns, rows=rows))
            else:
                lines = tuple((label, of_tool(text, tool)) for label, text in part.rows)
                parts.append(replace(part, heading=heading, rows=lines))
        return replace(self, summary=of_tool(self.summary, tool), sections=tuple(parts))
