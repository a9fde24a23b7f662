"""Ranges of the keys of a case: between two ends, or about the value that the case has."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from percuss.case.case import checked_case
from percuss.case.file_format.reading import half_width
from percuss.case.parameters.case_family import CaseFamily
from percuss.case.parameters.moves import number_held
from percuss.errors import CaseError, ParameterError, PercussError
from percuss.explore.family import Axis
from percuss.model.checks import finite, text
from percuss.units import DIMENSIONS, unit_scale

if TYPE_CHECKING:
    from percuss.case.case import Case

_DIGITS = 9  # of the sizes that are tried: a limit that binds is told to 1e-6


@dataclass(frozen=True)
class Span:
    """The range of a key of a case."""

    name: str
    low: float
    high: float
    unit: str = ""

    def __post_init__(self) -> None:
        texts = {"name": text("name", self.name), "unit": text("unit", self.unit)}
        ends = {"low": finite("low", self.low), "high": finite("high", self.high)}
        if not ends["low"] < ends["high"]:
            accepted = f"a number greater than the least value, {ends['low']:g}"
            raise ParameterError(self.name, self.high, accepted, "the smaller end of a range comes first")
        for name, value in (texts | ends).items():
            object.__setattr__(self, name, value)

    @classmethod
    def parsed(cls, words: str) -> Span:
        """From ``NAME=LOW:HIGH``, numbers with or without a unit.

        Examples
        --------
        >>> Span.parsed("bar.sections[2].length=50:150mm")
        Span(name='bar.sections[2].length', low=50.0, high=150.0, unit='mm')
        """
        if text("vary", words).count("=") != 1 or words.count(":") != 1:
            raise ParameterError("vary", words, "NAME=LOW:HIGH", "for example bar.sections[2].length=50:150mm")
        axis = Axis.parsed(f"{words}:2")
        return cls(axis.name, float(axis.values[0]), float(axis.values[1]), axis.unit)


def parsed_tolerance(words: str, case: Case) -> Span:
    """The range of a key from ``KEY=±0.2mm``, ``KEY=±5%`` or ``KEY=0.1..0.2``; ``+-`` is as good as ``±``.

    Examples
    --------
    >>> from percuss.case import load_case
    >>> parsed_tolerance("load.pressure=±10bar", load_case("valve-breaker"))
    Span(name='load.pressure', low=150.0, high=170.0, unit='bar')
    """
    checked_case(case)
    name, equals, given = text("vary", words).partition("=")
    given = given.strip().replace("+-", "±").replace("+/-", "±")
    if not equals or not (given.startswith("±") or ".." in given):
        example = "for example load.pressure=±10bar, bar.length=±1% or contact.restitution=0.1..0.2"
        raise ParameterError("vary", words, "KEY=±HALF or KEY=LOW..HIGH", example)
    family = CaseFamily(case, {})
    key = family.key(name.strip())
    if not key:
        raise ParameterError("vary", name, "a key of the case", "a dimensionless parameter stands in no drawing")
    if not given.startswith("±"):
        axis = Axis.parsed(f"{key}={given.replace('..', ':')}:2")
        return Span(key, float(axis.values[0]), float(axis.values[1]), axis.unit)
    match = re.fullmatch(r"±\s*(\d+\.?\d*(?:[eE][-+]?\d+)?|\.\d+)\s*([^\d.,-].*)?", given)
    if match is None or not float(match[1]) > 0.0:
        remedy = f'write a decimal point: "{words.replace(",", ".")}"' if re.search(r"\d,\d", given) else ""
        raise ParameterError("vary", words, "a half width greater than 0, such as ±0.2mm or ±5%", remedy)
    half, unit = float(match[1]), (match[2] or "").strip()
    nominal, own = number_held(case, key)
    if nominal is None:
        raise ParameterError("vary", words, "a key that the case holds", f"give the range: {key}=LOW..HIGH")
    if unit == "%":
        half *= 0.01 * abs(nominal)
    elif unit != own:
        (scale, dimension), (size, right) = (unit_scale(one, DIMENSIONS, key) for one in (unit or "1", own or "1"))
        if dimension != right:
            raise ParameterError("vary", words, f"a half width in a unit of {right}", f"such as {key}=±{half:g}{own}")
        half *= scale / size
    return Span(key, rounded(nominal - half), rounded(nominal + half), own)


def uncertain_spans(case: Case) -> tuple[Span, ...]:
    """The ranges of the numbers of a case that are known within ±.

    Raises
    ------
    CaseError
        For one that no figure depends on by a range: a key that holds more than one number, or none of the hammer.
    """
    checked_case(case)
    found = []
    for key, given in case.uncertain:
        half = half_width(given)
        assert half is not None  # the case has read it
        try:
            found.append(parsed_tolerance(f"{key}=±{half[0]!r}{half[1]}", case))
        except ParameterError as error:
            raise CaseError(case.file, key, given, f"expected {error.accepted}", error.remedy) from None
    return tuple(found)


def check_ends(family: CaseFamily, span: Span, made: Callable[[Mapping[str, float]], object]) -> None:
    """Refuse a range with an end that is no value of its key, such as a length of 0; others may depend on it."""
    for end in (span.low, span.high):
        try:
            made({span.name: end})
        except CaseError as error:
            if error.key == family.key(span.name):
                told = f"{end:g} {span.unit}".rstrip()
                raise ParameterError(span.name, told, error.accepted.removeprefix("expected "), error.remedy) from None


def rounded(value: float) -> float:
    """A size as it is tried, and written."""
    return float(f"{value:.{_DIGITS}g}")


def own_value(case: Case, key: str, unit: str) -> float | None:
    """What the case has under a key, in a unit."""
    if not key:
        return None
    value, own = number_held(case, key)
    if value is None or own == unit:
        return value
    try:
        return value * unit_scale(own, DIMENSIONS, key)[0] / unit_scale(unit, DIMENSIONS, key)[0]
    except PercussError:
        return None
