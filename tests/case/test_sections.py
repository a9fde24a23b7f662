"""Stepped bars in case files: sections in SI, impedances in plain numbers; messages, and the way back."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import pytest

from case_texts import HEAD, SHAFT, plain_case, refusal, si_case
from percuss.case import Case, CaseErrors
from percuss.case.file_format.body_tables import MATERIALS
from percuss.case.file_format.plain_tables import case_of, json_tables
from percuss.case.file_format.reading import toml_text
from percuss.case.parameters.description import plain_tables
from percuss.model import External, Ratio, SectionedBar, SteppedBar, UniformBar


def stepped_case(sections: str = f"[{HEAD}, {SHAFT}]", bar: str = "", load: str = "") -> str:
    return si_case(bar, load, 'strain = "kept"', sizes=f"sections = {sections}")


def test_sections_make_a_stepped_bar() -> None:
    system = Case.from_text(stepped_case(bar="damping_ratio = 2e-3", load="at = 1")).system()
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
        Case.from_text(stepped_case(f"[{HEAD}, {own}]", 'youngs_modulus = "100 GPa"\ndensity = "8000 kg/m^3"'))
        .system()
        .bar
    )
    assert bar is not None
    assert [(piece.youngs_modulus, piece.density) for piece in bar.pieces] == [(1e11, 8000.0), (1e11, 5000.0)]


def test_a_drag_is_spread_as_the_mass_is() -> None:
    system = Case.from_text(stepped_case(bar='drag = "40 N*s/m^2"')).system()
    bar = system.bar
    assert bar is not None and isinstance(bar.damping, External)
    assert bar.rigid_drag == pytest.approx(40.0 * 0.37, rel=1e-14)


def test_impedances_and_transit_times_make_a_stepped_bar() -> None:
    keys = "impedances = [2, 1.0]\ntransit_times = [1.0, 2.0]"
    body = Case.from_text(plain_case(f"d = 0.0048\n{keys}")).system().body
    assert body == SteppedBar(20.0, (2.0, 1.0), (1.0, 2.0), External(0.0048))
    assert Case.from_text(plain_case(keys)).system().body == replace(body, damping=External(0.0))
    assert isinstance(Case.from_text(plain_case()).system().body, UniformBar)


@pytest.mark.parametrize(
    "text", [stepped_case(load="at = 1"), plain_case("impedances = [2, 1]\ntransit_times = [1, 2]")]
)
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
    (
        "[{length = '1 m', diameter = '4 cm', bore = '4 cm'}]",
        "",
        ["bore = '4 cm'", "less than the diameter, 4 cm"],
    ),
    ("[{length = '1 m', diameter = '4 cm', bore = '-1 cm'}]", "", ["bar.sections[0].bore = '-1 cm'", "0 or greater"]),
    ("[{length = '1 m', diamter = '4 cm'}]", "", ["bar.sections[0].diamter = '4 cm'", "did you mean 'diameter'?"]),
    ("[{length = '1 m', diameter = '4 cm', material = 'stel'}]", "", ["material = 'stel'", "did you mean 'steel'?"]),
    (
        "[{length = '1 m', diameter = '4 cm', material = 'steel', density = '1 kg/m^3'}]",
        "",
        ["bar.sections[0].material", "not both"],
    ),
    (f"[{HEAD}]", 'length = "1 m"', ["bar.length = '1 m'", "either sections or a length"]),
    (f"[{HEAD}]", 'diameter = "1 m"', ["bar.diameter = '1 m'", "either sections or a diameter"]),
    (f"[{', '.join([HEAD] * 201)}]", "", ["bar.sections = '201 of them': expected 1 to 200"]),
    (f"[{HEAD}, {{length = '4 cm', diameter = '40 km'}}]", "", ["bar.sections[1].diameter = '40 km'", "1,000,000"]),
    (f"[{HEAD}, {{length = '4 cm', area = '4 km^2'}}]", "", ["bar.sections[1].area = '4 km^2'", "1,000,000 times"]),
    (f"[{HEAD}]", 'youngs_modulus = "-2 GPa"', ["bar.youngs_modulus = '-2 GPa'", "greater than 0"]),
    (f"[{HEAD}]", 'strain = "kept"', ["bar.strain = 'kept'", "it belongs in [contact]"]),
    (f"[{HEAD}]", 'd = "1 mm"', ["bar.d", "it is the drag"]),
]


@pytest.mark.parametrize(("sections", "bar", "parts"), NAMED)
def test_what_is_wrong_with_sections_is_told_by_their_key(sections: str, bar: str, parts: list[str]) -> None:
    found = refusal(stepped_case(sections, bar))
    assert "\n" not in found
    for part in parts:
        assert part in found


@pytest.mark.parametrize(
    ("system", "parts"),
    [
        ("impedances = [1, 2]", ["system.transit_times", "both impedances and transit_times"]),
        ("transit_times = [1, 2]", ["system.impedances", "both impedances and transit_times"]),
        ("impedances = [1, 2]\ntransit_times = [1]", ["system.transit_times", "as many as"]),
        ("impedances = [1, 0]\ntransit_times = [1, 1]", ["system.impedances[1] = 0.0", "greater than 0"]),
        ("impedances = [1, 1e6]\ntransit_times = [1, 1]", ["system.impedances[1] = 1000000.0", "1,000,000 times"]),
        ("impedances = [1, 1e9, 1]\ntransit_times = [1, 1, 1]", ["system.impedances[1]", "its neighbour's"]),
        ('sections = [{length = "1 m"}]', ["system.sections", "impedances and transit_times"]),
        ("impedances = [1, nan]\ntransit_times = [1, 1]", ["system.impedances", "finite"]),
        (f"impedances = {[1] * 201}\ntransit_times = {[1] * 201}", ["system.impedances", "1 to 200"]),
        ('impedances = [1, 2]\ntransit_times = [1, 1]\nstrain = "reversed"', ["system.strain", "uniform bar", "kept"]),
    ],
)
def test_what_is_wrong_with_impedances(system: str, parts: list[str]) -> None:
    found = refusal(plain_case(f"d = 0.0048\n{system}"))
    for part in parts:
        assert part in found


def test_a_law_of_damping_is_named_by_its_kind() -> None:
    """`law` is a key of [contact], too, which is not what is meant here."""
    with pytest.raises(CaseErrors) as caught:
        Case.from_text(stepped_case(bar='damping = {law = "ratio", value = 0.1}')).system()
    assert [problem.key for problem in caught.value.problems] == ["bar.damping.law", "bar.damping.kind"]
    assert "belongs" not in str(caught.value)


def test_two_laws_of_damping() -> None:
    found = refusal(stepped_case(bar='damping_ratio = 0.1\ndamping = {kind = "ratio", value = 0.1}'))
    assert "bar.damping: expected either damping_ratio or damping, not both" in found


def test_a_load_at_a_step_that_is_not_there() -> None:
    assert "load.at = 2" in refusal(stepped_case(load="at = 2"))


def test_the_strain_is_not_reversed_in_sections() -> None:
    found: Any = refusal(stepped_case().replace('"kept"', '"reversed"'))
    assert "contact.strain" in found and "uniform bar" in found
