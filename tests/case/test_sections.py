"""Stepped bars in case files: sections in SI, impedances in plain numbers; messages, and the way back."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from case_texts import HEAD, SHAFT, plain_case, si_case
from percuss.case import Case, CaseErrors
from percuss.case.file_format.bodies import MATERIALS
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


def test_a_law_of_damping_is_named_by_its_kind() -> None:
    """`law` is a key of [contact], too, which is not what is meant here."""
    with pytest.raises(CaseErrors) as caught:
        Case.from_text(stepped_case(bar='damping = {law = "ratio", value = 0.1}')).system()
    assert [problem.key for problem in caught.value.problems] == ["bar.damping.law", "bar.damping.kind"]
    assert "belongs" not in str(caught.value)
