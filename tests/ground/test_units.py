"""Quantities as text: every unit of the table against pint, what is refused and what the refusal says."""

from __future__ import annotations

import math
import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from percuss import units
from percuss.errors import UnitError
from percuss.units import DIMENSIONS, known_dimension, si, split_header, unit_scale

TABLE = units._TABLE
ENTRIES = [(d, u) for d in DIMENSIONS for u in TABLE[d][3]]
STRAINS = {
    "strain": 1.0,
    "microstrain": 1e-6,
    "ustrain": 1e-6,
    "ε": 1.0,
    "mε": 1e-3,
    "uε": 1e-6,
}  # pint has no strain …
STRAINS |= {"1e^-3": 1e-3, "1e^-6": 1e-6, "10^-3": 1e-3, "10^-6": 1e-6}  # … and takes no number for a unit
OURS = STRAINS | {"rpm": 1 / 60, "bpm": 1 / 60, "blows/min": 1 / 60, "rad/s": 0.5 / math.pi}  # pint counts a turn as 2π


@pytest.fixture(scope="module")
def registry():
    return units._registry()


@pytest.mark.parametrize(("dimension", "unit"), ENTRIES)
def test_every_table_entry_agrees_with_pint(registry, dimension, unit):
    factor, target = TABLE[dimension][3][unit], TABLE[dimension][0]
    if unit in OURS:
        assert factor == pytest.approx(OURS[unit], rel=1e-15)
    elif unit == "%":
        assert factor == 0.01
    else:
        text = unit.replace("lb/", "pound/").replace("kgf", "kilogram_force")
        theirs = registry.Quantity(1.0, registry.Unit("" if text == "1" else text))
        assert factor == pytest.approx(theirs.to("" if target == "1" else target).magnitude, rel=1e-14)


@pytest.mark.parametrize("dimension", DIMENSIONS)
def test_examples_in_messages_are_themselves_accepted(dimension):
    for example in TABLE[dimension][2].split(" or "):
        assert si(example.strip('"'), dimension, "x") > 0


@pytest.mark.parametrize(
    ("text", "dimension", "value"),
    [
        ("341 mm", "length", 0.341),
        ("341mm", "length", 0.341),
        ("  .341  m ", "length", 0.341),
        ("6.5 cm^2", "area", 6.5e-4),
        ("6.5 cm²", "area", 6.5e-4),
        ("6.5 cm2", "area", 6.5e-4),
        ("1e3 mm**2", "area", 1e-3),
        ("210 GPa", "pressure", 2.1e11),
        ("200 bar", "pressure", 2e7),
        ("12 N/mm²", "pressure", 1.2e7),
        ("1 psi", "pressure", 6894.757293168361),
        ("1 lbf", "force", 4.4482216152605),
        ("60 Hz", "frequency", 60.0),
        ("2400 1/min", "frequency", 40.0),
        ("60 rpm", "frequency", 1.0),
        ("60 min⁻¹", "frequency", 1.0),
        ("7.85 g/cm³", "density", 7850.0),
        ("7850 kg m-3", "density", 7850.0),
        ("40 N·s/m²", "damping", 40.0),
        ("40 N s m^-2", "damping", 40.0),
        ("40 N.s/m2", "damping", 40.0),
        ("40 kg/(m s)", "damping", 40.0),
        ("2 µs", "time", 2e-6),
        ("2 μs", "time", 2e-6),  # the Greek letter, the other one is the micro sign
        ("−5 mm", "length", -0.005),
        ("30 %", "dimensionless", 0.3),
        ("0.3", "dimensionless", 0.3),
        (0.3, "dimensionless", 0.3),
        (np.float64(0.3), "dimensionless", 0.3),
        (3, "dimensionless", 3.0),
        ("3 furlong", "length", pytest.approx(603.505, rel=1e-5)),  # pint
        ("1 kgf/mm^2", "pressure", pytest.approx(9.80665e6)),  # pint
    ],
)
def test_accepted(text, dimension, value):
    assert si(text, dimension, "x") == value


def test_377_radians_a_second_are_60_hertz():
    assert si("376.99111843 rad/s", "frequency", "frequency") == pytest.approx(60.0, rel=1e-10)


@pytest.mark.parametrize(
    ("value", "dimension", "parts"),
    [
        (0.3, "length", ["length = 0.3", '"300 mm" or "0.3 m"', 'did you mean "0.3 m" (= "300 mm")?']),
        ("0.3", "length", ['did you mean "0.3 m"']),
        (2, "pressure", ['did you mean "2 bar" (= "0.2 MPa")']),
        (180, "pressure", ['did you mean "180 bar" (= "18 MPa")']),
        (49, "length", ['did you mean "49 mm" (= "0.049 m")']),
        (2e6, "compliance", ['did you mean "2000000.0 m^3/Pa"']),
        ("0,3 m", "length", ["decimal point", '"0.3 m"']),
        ("12 Mpa", "pressure", ['did you mean "MPa"?']),
        ("12 mPa", "pressure", ['did you mean "MPa"', 'is written "0.001 Pa"']),  # millipascal to pint
        ("3 Mm", "length", ['did you mean "mm"', 'is written "1e+06 m"']),  # megametre to pint
        ("60 hz", "frequency", ['did you mean "Hz"?']),
        ("12 Mpa", "force", ['did you mean "MPa", a unit of pressure?']),
        ("3 kN", "length", ['"kN" is a unit of force']),
        ("3 kW", "length", ['"kW" is a unit of']),  # known to pint only
        ("3 banana", "length", ['unknown unit "banana"']),
        ("60 rev/s", "frequency", ['unknown unit "rev/s"']),  # pint would say 377 Hz
        ("60 deg/s", "frequency", ["unknown unit"]),
        ("nan m", "length", ["NaN and infinity"]),
        ("-inf m", "length", ["NaN and infinity"]),
        (math.nan, "length", ["nan"]),
        (math.inf, "dimensionless", ["inf"]),
        ("1e999 m", "length", ["finite"]),
        ("1e999999999999 m", "length", ["finite"]),
        ("", "length", ["empty"]),
        ("long", "length", ['"long" does not start with a number']),
        ("3 m 4", "length", ["unknown unit"]),
        ("3 m^9^9^9^9", "length", ["unknown unit"]),
        ("3 m; import os", "length", ["unknown unit"]),
        ("3 " + "m*" * 3000, "length", ["length = "]),
        ("9" * 5000 + " m", "length", ["finite"]),
        (10**400, "dimensionless", ["length = "]),
        (True, "length", ["length = True"]),
        (None, "length", ["length = None"]),
        ([1.0], "length", ["length = [1.0]"]),
        ("1 000 m", "length", ["unknown unit"]),
        ("5 mm", "dimensionless", ['"mm" is a unit of length']),
    ],
)
def test_refused(value, dimension, parts):
    with pytest.raises(UnitError) as caught:
        si(value, dimension, "length")
    message = str(caught.value)
    assert all(part in message for part in parts), message
    assert len(message) < 400
    assert caught.value.name == "length"


def test_an_unknown_dimension_is_a_mistake_of_the_caller():
    with pytest.raises(ValueError, match="expected one of length, area"):
        si("3 m", "lenght", "x")


@given(st.sampled_from([e for e in ENTRIES if e[0] != "dimensionless"]), st.floats(-1e6, 1e6))
def test_a_value_scales_with_its_unit_and_keeps_its_digits(entry, number):
    dimension, unit = entry
    factor = TABLE[dimension][3][unit]
    assert si(f"{number!r} {unit}", dimension, "x") == pytest.approx(number * factor, rel=4e-16, abs=1e-300)
    scale, found = unit_scale(unit, (dimension,), "unit")
    assert (scale, found) == (factor, dimension)


@given(st.text(max_size=30), st.sampled_from(DIMENSIONS))
def test_any_text_is_a_finite_number_or_a_unit_error(text, dimension):
    try:
        assert math.isfinite(si(text, dimension, "x"))
    except UnitError as error:
        assert str(error)


@given(st.text(max_size=30))
def test_any_heading_can_be_split(text):
    name, unit = split_header(text)
    assert unit is None or unit
    assert len(name) <= len(text)


def test_unit_scale_takes_a_number_too_and_names_what_it_wants():
    assert unit_scale("12 MPa", ("force", "pressure"), "unit") == (12e6, "pressure")
    assert unit_scale("1/min", ("frequency",), "unit") == (1 / 60, "frequency")
    with pytest.raises(UnitError, match="unit = 'mm': expected a unit of force such as \"kN\" or a unit of pressure"):
        unit_scale("mm", ("force", "pressure"), "unit")


@pytest.mark.parametrize(
    ("unit", "scale"),
    [
        ("µm/m", 1e-6),
        ("μm/m", 1e-6),
        ("µε", 1e-6),
        ("microstrain", 1e-6),
        ("1e-6", 1e-6),
        ("10⁻⁶", 1e-6),
        ("10^-6", 1e-6),
        ("%", 1e-2),
        ("mm/m", 1e-3),
        ("m/m", 1.0),
        ("1", 1.0),
        ("250 µm/m", 2.5e-4),
        ("2e-3", 2e-3),
    ],
)
def test_units_of_strain_are_those_of_laboratories(unit, scale):
    assert unit_scale(unit, ("strain", "pressure", "force"), "unit") == (pytest.approx(scale, rel=1e-15), "strain")


def test_known_dimension_does_not_import_pint():
    code = (
        "import sys, percuss.units as u; u.known_dimension('V'); u.si('3 mm', 'length', 'x'); "
        "u.split_header('p [barg]'); print('pint' in sys.modules)"
    )
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert run.stdout.strip() == "False"
    assert known_dimension("V") is None
    assert known_dimension("kN/mm²") == "pressure"


@pytest.mark.parametrize(
    ("heading", "parts"),
    [
        ("pressure [bar]", ("pressure", "bar")),
        ("Zeit [s]", ("Zeit", "s")),
        ("t (ms)", ("t", "ms")),
        ("force/kN", ("force", "kN")),
        ("Kolben p / bar", ("Kolben p", "bar")),
        ("p in bar", ("p", "bar")),
        ("Force, kN", ("Force", "kN")),
        ("force: kN", ("force", "kN")),
        ("p_bar", ("p", "bar")),
        ("pressure_MPa", ("pressure", "MPa")),
        ("Time_s", ("Time", "s")),
        ("t_ms", ("t", "ms")),
        ("force kN", ("force", "kN")),
        ('"p [bar]"', ("p", "bar")),
        ("p [-]", ("p", None)),
        ("T [degC]", ("T", "degC")),
        ("p_min", ("p_min", None)),  # a smallest pressure, not minutes
        ("p_s", ("p_s", None)),
        ("time_bar", ("time_bar", None)),
        ("Time", ("Time", None)),
        ("", ("", None)),
    ],
)
def test_headings(heading, parts):
    assert split_header(heading) == parts


@pytest.mark.parametrize("dimension", ["length", "force", "frequency", "stiffness", "time", "energy", "mass"])
def test_every_prefix_of_si_is_read_or_told(dimension):
    """A prefix that only its case tells from another is read as SI has it, or refused with both that could be meant."""
    base = {"length": "m", "force": "N", "frequency": "Hz", "stiffness": "N/m", "time": "s", "energy": "J", "mass": "g"}
    unit = base[dimension]
    one = si(f"1 {unit}", dimension, dimension)
    for prefix, factor in {"n": 1e-9, "u": 1e-6, "m": 1e-3, "k": 1e3, "M": 1e6, "G": 1e9}.items():
        try:
            assert si(f"7 {prefix}{unit}", dimension, dimension) == pytest.approx(7.0 * factor * one, rel=1e-12)
        except UnitError as error:
            assert (prefix, unit) in {("M", "m"), ("M", "s")}
            assert f'did you mean "m{unit}"; what SI calls so is written "{factor * one:g} {unit}"' in str(error)
