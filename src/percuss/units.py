"""Quantities as text, such as ``"341 mm"``, turned into SI numbers.

A closed table holds the units that people write on drawings and data sheets and answers at once; any other
unit is looked up in pint, which is imported only then. A frequency counts cycles: "377 rad/s" is 60 Hz, and
60 rpm is 1 Hz (pint counts a turn as 2π, so turns never reach it).
"""

from __future__ import annotations

import decimal
import difflib
import functools
import math
import re
from typing import Any

from percuss.errors import ParameterError, UnitError

__all__ = ["DIMENSIONS", "TIME_WORDS", "known_dimension", "si", "split_header", "unit_scale"]

# dimension: (SI unit, a usual unit, examples, {unit: factor to SI}). The spelling is that of `_tidy`.
_TABLE: dict[str, tuple[str, str, str, dict[str, float]]] = {
    "length": ("m", "mm", '"300 mm" or "0.3 m"', {
        "m": 1.0, "mm": 1e-3, "cm": 1e-2, "dm": 0.1, "km": 1e3, "um": 1e-6, "in": 0.0254, "inch": 0.0254,
        "ft": 0.3048,
    }),
    "area": ("m^2", "cm^2", '"6.5 cm^2" or "650 mm^2"', {
        "m^2": 1.0, "mm^2": 1e-6, "cm^2": 1e-4, "dm^2": 1e-2, "in^2": 0.0254**2, "ft^2": 0.3048**2,
    }),
    "pressure": ("Pa", "MPa", '"12 MPa" or "120 bar"', {
        "Pa": 1.0, "hPa": 1e2, "kPa": 1e3, "MPa": 1e6, "GPa": 1e9, "bar": 1e5, "mbar": 1e2, "atm": 101325.0,
        "psi": 4.4482216152605 / 0.0254**2, "ksi": 4448.2216152605 / 0.0254**2, "N/m^2": 1.0, "N/mm^2": 1e6,
        "kN/mm^2": 1e9, "kgf/cm^2": 98066.5,
    }),
    "force": ("N", "kN", '"2.5 kN" or "2500 N"', {
        "N": 1.0, "mN": 1e-3, "daN": 10.0, "kN": 1e3, "MN": 1e6, "lbf": 4.4482216152605, "kgf": 9.80665,
    }),
    "frequency": ("Hz", "1/min", '"40 Hz" or "2400 1/min"', {
        "Hz": 1.0, "mHz": 1e-3, "kHz": 1e3, "MHz": 1e6, "1/s": 1.0, "s^-1": 1.0, "1/min": 1 / 60, "min^-1": 1 / 60,
        "bpm": 1 / 60, "rpm": 1 / 60, "blows/min": 1 / 60, "rad/s": 0.5 / math.pi,
    }),
    "density": ("kg/m^3", "g/cm^3", '"7850 kg/m^3" or "7.85 g/cm^3"', {
        "kg/m^3": 1.0, "g/cm^3": 1e3, "kg/dm^3": 1e3, "kg/l": 1e3, "t/m^3": 1e3,
        "lb/in^3": 0.45359237 / 0.0254**3,
    }),
    "time": ("s", "ms", '"20 ms" or "0.02 s"', {
        "s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9, "sec": 1.0, "min": 60.0, "h": 3600.0,
    }),
    "velocity": ("m/s", "mm/s", '"10 m/s" or "1e4 mm/s"', {
        "m/s": 1.0, "mm/s": 1e-3, "cm/s": 1e-2, "m/min": 1 / 60, "km/h": 1 / 3.6, "ft/s": 0.3048,
    }),
    "energy": ("J", "kJ", '"310 J" or "0.31 kJ"', {
        "J": 1.0, "kJ": 1e3, "MJ": 1e6, "mJ": 1e-3, "N*m": 1.0, "kN*m": 1e3,
        "ft*lbf": 0.3048 * 4.4482216152605,
    }),
    "power": ("W", "kW", '"8 kW" or "8000 W"', {
        "W": 1.0, "kW": 1e3, "MW": 1e6, "mW": 1e-3, "J/s": 1.0, "hp": 550.0 * 0.3048 * 4.4482216152605,
    }),
    "volume": ("m^3", "l", '"0.4 l" or "400 cm^3"', {"m^3": 1.0, "l": 1e-3, "dm^3": 1e-3, "cm^3": 1e-6, "ml": 1e-6}),
    "mass": ("kg", "g", '"5 kg" or "5000 g"', {"kg": 1.0, "g": 1e-3, "t": 1e3, "lb": 0.45359237}),
    "stiffness": ("N/m", "kN/mm", '"400 kN/mm" or "0.4 GN/m"', {
        "N/m": 1.0, "mN/m": 1e-3, "kN/m": 1e3, "MN/m": 1e6, "GN/m": 1e9, "N/mm": 1e3, "mN/mm": 1.0, "kN/mm": 1e6,
        "MN/mm": 1e9, "N/um": 1e6, "mN/um": 1e3,
        "lbf/in": 4.4482216152605 / 0.0254,
    }),
    "flow": ("m^3/s", "l/min", '"133 l/min" or "2.2e-3 m^3/s"', {
        "m^3/s": 1.0, "l/min": 1 / 6e4, "l/s": 1e-3, "cm^3/s": 1e-6, "m^3/h": 1 / 3600, "m^3/min": 1 / 60,
    }),
    "compliance": ("m^3/Pa", "cm^3/bar", '"2.5 cm^3/bar" or "25 cm^3/MPa"', {  # volume that an accumulator gives up
        "m^3/Pa": 1.0, "cm^3/bar": 1e-11, "l/bar": 1e-8, "cm^3/MPa": 1e-12, "l/MPa": 1e-9, "mm^3/Pa": 1e-9,
    }),
    "damping": ("N*s/m^2", "kN*s/m^2", '"40 N*s/m^2"', {  # D: force per length of the bar and per velocity
        "N*s/m^2": 1.0, "kN*s/m^2": 1e3, "N/m/(m/s)": 1.0, "Pa*s": 1.0, "kg/(m*s)": 1.0, "kg/m/s": 1.0,
    }),
    "dashpot": ("N*s/m", "kN*s/m", '"40 N*s/m"', {
        "N*s/m": 1.0, "kN*s/m": 1e3, "N/(m/s)": 1.0, "kg/s": 1.0, "N*s/mm": 1e3,
    }),
    "attenuation": ("1/m", "1/km", '"0.004 1/m" or "4 1/km"', {"1/m": 1.0, "m^-1": 1.0, "1/km": 1e-3, "1/mm": 1e3}),
    "specific energy": ("J/m^3", "MJ/m^3", '"220 MJ/m^3" or "220 J/cm^3"', {  # work per volume of rock
        "J/m^3": 1.0, "kJ/m^3": 1e3, "MJ/m^3": 1e6, "GJ/m^3": 1e9, "J/cm^3": 1e6, "J/mm^3": 1e9,
    }),
    "dimensionless": ("1", "%", '0.3 or "30 %"', {"": 1.0, "1": 1.0, "%": 1e-2}),
    "strain": ("m/m", "µm/m", '"250 µm/m" or "2.5e-4 m/m"', {
        "": 1.0, "1": 1.0, "%": 1e-2, "m/m": 1.0, "mm/m": 1e-3, "um/m": 1e-6, "strain": 1.0, "microstrain": 1e-6,
        "ustrain": 1e-6, "ε": 1.0, "mε": 1e-3, "uε": 1e-6, "1e^-3": 1e-3, "1e^-6": 1e-6, "10^-3": 1e-3, "10^-6": 1e-6,
    }),
}  # fmt: skip

DIMENSIONS = tuple(_TABLE)
"""The names of dimensions that `si` knows."""

TIME_WORDS = frozenset(
    {"t", "time", "times", "tid", "zeit", "temps", "tiempo", "tempo", "aika", "elapsed", "timestamp"}
)
"""How a column of time is called, in lower case."""

_LONGEST = 200
"""Characters of a unit: reading one takes the square of their number, and the last few are kept."""
_NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?")
_FACTOR = r"(?:1|[A-Za-z]+)(?:\^-?\d)?"
_UNIT = re.compile(rf"{_FACTOR}(?:[*/]{_FACTOR})*(?:[*/]\({_FACTOR}(?:[*/]{_FACTOR})*\))?")
# pint takes these for pure numbers
_ANGLES = re.compile(r"rad|deg|°|turn|rev|cycle|rpm|rps|count|bit|byte", re.IGNORECASE)
_POWERS = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹⁻", "0123456789-")


def si(value: object, dimension: str, name: str) -> float:
    """The SI value of a quantity written as text.

    Parameters
    ----------
    value
        Text with a number and a unit; a plain number only where the dimension is "dimensionless" or "strain".
    dimension
        One of `DIMENSIONS`.
    name
        What the quantity is called, for the message.

    Returns
    -------
    float
        In m, m², Pa, N, Hz, kg/m³, s, m/s, J, kg, N/m, N·s/m, N·s/m² or 1.

    Raises
    ------
    UnitError
        When the unit is missing, unknown or of another dimension, or the number is not finite.

    Examples
    --------
    >>> si("341 mm", "length", "length")
    0.341
    >>> si("2400 blows/min", "frequency", "frequency")
    40.0
    """
    if all(isinstance(one, str) for one in (value, dimension, name)) and len(str(value)) <= _LONGEST:
        return _remembered(value, dimension, name)
    return _in_si(value, dimension, name)


def _in_si(value: object, dimension: str, name: str) -> float:
    accepted = _accepted(dimension)
    if not isinstance(name, str):
        raise ParameterError("name", name, "what the quantity is called")
    if isinstance(value, bool | bytes | bytearray):
        raise UnitError(name, value, accepted)
    text = value.strip().replace("−", "-") if isinstance(value, str) else _plain(value, name, accepted)
    match = _NUMBER.match(text)
    if match is None:
        raise UnitError(name, value, accepted, _number_remedy(text))
    unit = text[match.end() :].strip()
    if unit[:1] == "," and unit[1:2].isdigit():
        raise UnitError(name, value, accepted, f'write a decimal point: "{text.replace(",", ".", 1)}"')
    if not unit and unit not in _TABLE[dimension][3]:
        raise UnitError(name, value, accepted, f"did you mean {_likely(match[0], dimension)}?")
    scale = _scale(unit, dimension, name, value)
    number = _product(match[0], scale)
    if not math.isfinite(number):
        raise UnitError(name, value, accepted + ", and finite")
    return number


_remembered = functools.lru_cache(maxsize=1024)(_in_si)
"""A case that is varied is read again and again; what is refused is not kept."""


def unit_scale(unit: str, dimensions: tuple[str, ...], name: str) -> tuple[float, str]:
    """The SI value of 1 `unit` and its dimension, which must be one of `dimensions`.

    A number before the unit counts: 1 of "12 MPa" is 12e6 Pa.

    Raises
    ------
    UnitError
        When the unit is unknown or of none of the dimensions.

    Examples
    --------
    >>> unit_scale("bar", ("force", "pressure"), "unit")
    (100000.0, 'pressure')
    """
    dimensions = _dimensions(dimensions)
    text = _text("unit", unit).strip()
    has_number = _NUMBER.match(text) and not text.startswith("1/") and known_dimension(text, dimensions) is None
    text = text if has_number else f"1 {text}"
    refusals = []
    for dimension in dimensions:
        try:
            return si(text, dimension, name), dimension
        except UnitError as error:
            refusals.append(error)
    accepted = " or ".join(f'a unit of {d} such as "{_TABLE[d][1]}"' for d in dimensions)
    raise UnitError(name, unit, accepted, refusals[0].remedy)


def known_dimension(unit: str, dimensions: tuple[str, ...] = DIMENSIONS) -> str | None:
    """The first of the dimensions whose table holds the unit; pint is not asked.

    Examples
    --------
    >>> known_dimension("kgf/cm²"), known_dimension("bar", ("force", "time"))
    ('pressure', None)
    """
    if len(_text("unit", unit)) > _LONGEST:
        return None
    tidy = _tidy(unit)
    return next((d for d in _dimensions(dimensions) if tidy in _TABLE[d][3]), None)


def split_header(text: str) -> tuple[str, str | None]:
    """The name and the unit in the heading of a column; the unit is None where there is none.

    Knows "pressure [bar]", "t (ms)", "force/kN", "p in bar", "Force, kN", "p_bar" and "Time_s". Without
    brackets only units of time, force and pressure count, and "p_min" is a smallest pressure, not minutes.

    Examples
    --------
    >>> split_header("pressure [bar]"), split_header("Time_s"), split_header("p_min")
    (('pressure', 'bar'), ('Time', 's'), ('p_min', None))
    """
    text = _text("text", text).strip().strip("\"'").strip()
    if match := re.fullmatch(r"(.*?)\s*[\[({<]\s*([^\[\](){}<>]+?)\s*[\])}>]", text):
        return match[1], None if match[2] in {"-", ""} else match[2]
    for joint in (r"\s+in\s+", r"\s*[,:/]\s*", r"[_ ]+"):
        match = re.fullmatch(rf"(.+?){joint}([^\s_,:]+)", text)
        if match and (dimension := known_dimension(match[2], ("time", "force", "pressure"))):
            is_time = match[1].lower() in TIME_WORDS
            if is_time == (dimension == "time"):
                return match[1], match[2]
    return text, None


def _dimensions(given: tuple[str, ...]) -> tuple[str, ...]:
    if given is DIMENSIONS:
        return given
    if not isinstance(given, tuple | list) or not given or not all(d in DIMENSIONS for d in given):
        raise ParameterError("dimensions", given, f"some of {', '.join(DIMENSIONS)}")
    return tuple(given)


def _text(name: str, value: object) -> str:
    if not isinstance(value, str):
        raise ParameterError(name, value, "text")
    return value


def _plain(value: object, name: str, accepted: str) -> str:
    try:
        number = float(value)  # type: ignore[arg-type]  # whatever cannot become a float is refused
    except (TypeError, ValueError, OverflowError):
        raise UnitError(name, value, accepted) from None
    if not math.isfinite(number):
        raise UnitError(name, value, accepted)
    return repr(value) if isinstance(value, int | float) and type(value) in (int, float) else repr(number)


def _product(text: str, scale: float) -> float:
    """The double nearest to the decimal product: "341 mm" is 0.341, which 341 * 1e-3 is not."""
    try:
        return float(decimal.Decimal(text) * decimal.Decimal(repr(scale)))
    except (decimal.Overflow, decimal.InvalidOperation):
        return math.inf


@functools.lru_cache(maxsize=1024)
def _tidy(unit: str) -> str:
    """One spelling: µ is u, powers are ^n, products are *, no blanks: "N·s/m²" is "N*s/m^2"."""
    unit = unit.strip().replace("µ", "u").replace("μ", "u")
    unit = re.sub(r"([⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+)", lambda m: "^" + m[1].translate(_POWERS), unit)
    unit = unit.replace("**", "^").replace("^^", "^")
    unit = re.sub(r"\s*([*/^·⋅×])\s*", r"\1", unit)
    unit = re.sub(r"(?<=[A-Za-z])\.(?=[A-Za-z])", "*", unit)
    unit = re.sub(r"[·⋅×\s]+", "*", unit)
    return re.sub(r"([A-Za-z])(-?\d)", r"\1^\2", unit)


def _scale(unit: str, dimension: str, name: str, value: object) -> float:
    if len(unit) > _LONGEST:
        raise UnitError(name, value, _accepted(dimension))
    tidy = _tidy(unit)
    if tidy in (units := _TABLE[dimension][3]):
        return units[tidy]
    accepted = _accepted(dimension)
    if other := known_dimension(tidy, DIMENSIONS):
        raise UnitError(name, value, accepted, f'"{unit}" is a unit of {other}')
    # Case alone is no safe guess ("mPa", "Mm"), and pint would take these without a word.
    alike = [u for u in units if u.lower() == tidy.lower()]
    if not alike and len(tidy) <= 40 and _UNIT.fullmatch(tidy) and not _ANGLES.search(tidy):
        found = _pint_scale(tidy, _TABLE[dimension][0])
        if isinstance(found, float):
            return found
        if found:
            raise UnitError(name, value, accepted, f'"{unit}" is a unit of {found}')
    raise UnitError(name, value, accepted, _near(tidy, unit, dimension))


@functools.cache
def _registry() -> Any:
    import pint  # takes a second

    return pint.UnitRegistry(cache_folder=None)


@functools.lru_cache(maxsize=256)
def _pint_scale(unit: str, target: str) -> float | str | None:
    """The factor to the target unit; the dimension found if another; None for what pint does not know."""
    registry = _registry()
    try:
        quantity = registry.Quantity(1.0, registry.Unit(unit))
        if quantity.dimensionality != registry.Unit("" if target == "1" else target).dimensionality:
            return " ".join(str(quantity.dimensionality).replace("[", "").replace("]", "").split())
        return float(quantity.to("" if target == "1" else target).magnitude)
    except Exception:  # pint raises errors of many libraries for text that is no unit; all mean the same here
        return None


def _near(tidy: str, unit: str, dimension: str) -> str:
    """ "Did you mean" for a unit that nobody knows."""
    if len(unit) > 40:
        return ""
    for d in (dimension, *DIMENSIONS):
        units = {u.lower(): u for u in _TABLE[d][3] if u}
        alike = [units[tidy.lower()]] if tidy.lower() in units else []
        alike = alike or [units[u] for u in difflib.get_close_matches(tidy.lower(), units, n=1, cutoff=0.7)]
        if alike:
            other = "" if d == dimension else f", a unit of {d}"
            meant = _pint_scale(tidy, _TABLE[d][0]) if alike[0].lower() == tidy.lower() else None
            if isinstance(meant, float):  # what SI means by it, and hardly who writes it
                other += f'; what SI calls so is written "{meant:g} {_TABLE[d][0]}"'
            return f'unknown unit "{unit}": did you mean "{alike[0]}"{other}?'
    return f'unknown unit "{unit}"'


def _accepted(dimension: str) -> str:
    if not isinstance(dimension, str) or dimension not in _TABLE:
        raise ParameterError("dimension", dimension, f"one of {', '.join(DIMENSIONS)}")
    examples = _TABLE[dimension][2]
    if dimension == "dimensionless":
        return f"a number, such as {examples}"
    return f"{'an' if dimension[0] in 'aeiou' else 'a'} {dimension} with its unit, such as {examples}"


_USUAL = {
    "pressure": (2e4, 1e8, "bar MPa"), "length": (1e-3, 20.0, "m mm"), "area": (1e-6, 1.0, "cm^2 mm^2 m^2"),
    "force": (10.0, 1e7, "N kN"), "frequency": (0.2, 1e3, "Hz 1/min"), "time": (1e-5, 100.0, "s ms"),
    "mass": (0.05, 1e5, "kg"), "velocity": (0.01, 100.0, "m/s"), "density": (1e3, 2e4, "kg/m^3 g/cm^3"),
    "flow": (1e-5, 0.1, "l/min m^3/s"), "volume": (1e-6, 1.0, "l cm^3 m^3"),
}  # fmt: skip
"""What hammers have, and the units in which it is likely to be written."""


def _likely(number: str, dimension: str) -> str:
    """A bare number with the first unit that makes it what a hammer has, else the SI unit, and the same in another."""
    unit, usual, _, units = _TABLE[dimension]
    least, most, words = _USUAL.get(dimension, (0.0, 0.0, ""))
    meant = next((one for one in words.split() if least <= abs(float(number)) * units[one] <= most), unit)
    other = usual if meant != usual else unit
    return f'"{number} {meant}" (= "{float(number) * units[meant] / units[other]:.6g} {other}")'


def _number_remedy(text: str) -> str:
    if re.match(r"[-+]?(nan|inf)", text, re.IGNORECASE):
        return "NaN and infinity are not quantities"
    if not text:
        return "the text is empty"
    return "the text must start with a number" if len(text) > 40 else f'"{text}" does not start with a number'
