"""Stepped bars in case files: sections in SI, impedances in plain numbers; messages, and the way back."""

from __future__ import annotations

import math
from typing import Any

import pytest

from percuss.case import Case
from percuss.case.file_format.plain_tables import case_of, json_tables
from percuss.case.file_format.section_tables import MATERIALS
from percuss.case.file_format.writing import toml_text
from percuss.case.parameters.description import plain_tables
from percuss.errors import CaseError
from percuss.model import External, Ratio, SectionedBar, SteppedBar, UniformBar

HEAD = '{length = "120 mm", diameter = "52 mm"}'
SHAFT = '{length = "250 mm", diameter = "40 mm", bore = "8 mm", material = "titanium"}'


def si_case(sections: str = f"[{HEAD}, {SHAFT}]", bar: str = "", load: str = "") -> str:
    return f"""
[bar]
sections = {sections}
{bar}
[load]
kind = "harmonic"
mean = "4 kN"
amplitude = "9 kN"
frequency = "60 Hz"
{load}
[contact]
restitution = 0.2
strain = "kept"
"""


def plain_case(system: str, load: str = "") -> str:
    return f"""
[system]
s = 5.0
restitution = 0.6
d = 0.0048
{system}
[load]
kind = "harmonic"
mean = 0.9
amplitude = 1.0
{load}
"""


def refusal(text: str) -> str:
    with pytest.raises(CaseError) as caught:
        Case.from_text(text, file="case.toml")
    return str(caught.value)


def test_sections_make_a_stepped_bar() -> None:
    system = Case.from_text(si_case(bar="damping_ratio = 2e-3", load="at = 1")).system()
    assert isinstance(system.bar, SectionedBar) and isinstance(system.body, SteppedBar)
    head, shaft = system.bar.pieces
    assert head.area == pytest.approx(math.pi / 4.0 * 0.052**2, rel=1e-14)
    assert shaft.area == pytest.approx(math.pi / 4.0 * (0.04**2 - 0.008**2), rel=1e-14)
    assert (shaft.youngs_modulus, shaft.density) == MATERIALS["titanium"]
    assert (head.youngs_modulus, head.density) == MATERIALS["steel"]
    assert system.body.damping == Ratio(2e-3) and system.load.at == 1
    assert system.body.places[1] == pytest.approx(120.0 / 370.0, rel=1e-14)


def test_sections_share_the_material_of_the_bar_unless_they_have_their_own() -> None:
    own = '{length = "1 m", area = "1 cm^2", density = "5000 kg/m^3"}'
    bar = (
        Case.from_text(si_case(f"[{HEAD}, {own}]", 'youngs_modulus = "100 GPa"\ndensity = "8000 kg/m^3"')).system().bar
    )
    assert bar is not None
    assert [(piece.youngs_modulus, piece.density) for piece in bar.pieces] == [(1e11, 8000.0), (1e11, 5000.0)]


def test_a_drag_is_spread_as_the_mass_is() -> None:
    system = Case.from_text(si_case(bar='drag = "40 N*s/m^2"')).system()
    bar = system.bar
    assert bar is not None and isinstance(bar.damping, External)
    assert bar.rigid_drag == pytest.approx(40.0 * 0.37, rel=1e-14)


def test_impedances_and_transit_times_make_a_stepped_bar() -> None:
    body = Case.from_text(plain_case("impedances = [2, 1.0]\ntransit_times = [1.0, 2.0]")).system().body
    assert body == SteppedBar(5.0, (2.0, 1.0), (1.0, 2.0), External(0.0048))
    assert isinstance(Case.from_text(plain_case("")).system().body, UniformBar)


@pytest.mark.parametrize("text", [si_case(load="at = 1"), plain_case("impedances = [2, 1]\ntransit_times = [1, 2]")])
def test_a_case_reads_back(text: str) -> None:
    case = Case.from_text(text)
    assert Case.from_text(toml_text(case.to_dict())).system() == case.system()
    assert case_of(json_tables(case)).system() == case.system()
    plain = case_of(plain_tables(case)).system()
    assert plain.body.frequencies(9) == pytest.approx(case.system().body.frequencies(9), rel=1e-13)
    assert plain.load.at == case.system().load.at


NAMED: list[tuple[str, str, list[str]]] = [
    ("[]", "", ["bar.sections", "a list of sections"]),
    ('"two"', "", ["bar.sections = 'two'", "a list of sections"]),
    ("[1.0]", "", ["bar.sections[0] = 1.0", "a table"]),
    (f"[{HEAD}, {{diameter = '4 cm'}}]", "", ["bar.sections[1].length: missing"]),
    (f"[{HEAD}, {{length = '4 cm'}}]", "", ["bar.sections[1].area", "either an area or a diameter"]),
    (f"[{{length = '0 mm', diameter = '4 cm'}}, {HEAD}]", "", ["bar.sections[0].length = '0 mm'", "greater than 0"]),
    (f"[{HEAD}, {{length = '-4 mm', diameter = '4 cm'}}]", "", ["bar.sections[1].length = '-4 mm'", "greater than 0"]),
    (f"[{HEAD}, {{length = 4.0, diameter = '4 cm'}}]", "", ["bar.sections[1].length = 4.0"]),
    (f"[{HEAD}, {{length = '4 s', diameter = '4 cm'}}]", "", ["bar.sections[1].length = '4 s'"]),
    ("[{length = '1 m', area = '1 cm^2', diameter = '4 cm'}]", "", ["bar.sections[0].area", "or a diameter"]),
    ("[{length = '1 m', diameter = '4 cm', bore = '4 cm'}]", "", ["bar.sections[0].bore", "less than the diameter"]),
    ("[{length = '1 m', diameter = '4 cm', bore = '-1 cm'}]", "", ["bar.sections[0].bore", "0 or greater"]),
    ("[{length = '1 m', diamter = '4 cm'}]", "", ["bar.sections[0].diamter = '4 cm'", "did you mean 'diameter'?"]),
    ("[{length = '1 m', diameter = '4 cm', material = 'stel'}]", "", ["material = 'stel'", "did you mean 'steel'?"]),
    (
        "[{length = '1 m', diameter = '4 cm', material = 'steel', density = '1 kg/m^3'}]",
        "",
        ["bar.sections[0].material", "not both"],
    ),
    (f"[{HEAD}]", 'length = "1 m"', ["bar.length = '1 m'", "either sections or a length"]),
    (f"[{HEAD}]", 'diameter = "1 m"', ["bar.diameter = '1 m'", "either sections or a diameter"]),
    (f"[{', '.join([HEAD] * 201)}]", "", ["bar.sections", "1 to 200"]),
]


@pytest.mark.parametrize(("sections", "bar", "parts"), NAMED)
def test_what_is_wrong_with_sections_is_told_by_their_key(sections: str, bar: str, parts: list[str]) -> None:
    found = refusal(si_case(sections, bar))
    assert "\n" not in found
    for part in parts:
        assert part in found


@pytest.mark.parametrize(
    ("system", "parts"),
    [
        ("impedances = [1, 2]", ["system.transit_times", "both impedances and transit_times"]),
        ("transit_times = [1, 2]", ["system.impedances", "both impedances and transit_times"]),
        ("impedances = [1, 2]\ntransit_times = [1]", ["system.transit_times", "as many as"]),
        ("impedances = [1, 0]\ntransit_times = [1, 1]", ["system.impedances", "greater than 0"]),
        ("impedances = [1, nan]\ntransit_times = [1, 1]", ["system.impedances", "finite"]),
        (f"impedances = {[1] * 201}\ntransit_times = {[1] * 201}", ["system.impedances", "1 to 200"]),
        ('impedances = [1, 2]\ntransit_times = [1, 1]\nstrain = "reversed"', ["system.strain", "uniform bar", "kept"]),
    ],
)
def test_what_is_wrong_with_impedances(system: str, parts: list[str]) -> None:
    found = refusal(plain_case(system))
    for part in parts:
        assert part in found


def test_a_load_at_a_step_that_is_not_there() -> None:
    assert "load.at = 2" in refusal(si_case(load="at = 2"))


def test_the_strain_is_not_reversed_in_sections() -> None:
    found: Any = refusal(si_case().replace('"kept"', '"reversed"'))
    assert "contact.strain" in found and "uniform bar" in found
