"""The outline of a bar: to scale, one rectangle for each section, the load where it acts."""

from __future__ import annotations

from xml.etree import ElementTree

import pytest

from percuss.errors import ParameterError
from percuss.model import Bar, Kept, Load, Section, SectionedBar, System, UniformBar
from percuss.plot.reports.bar_outline import bar_outline

SVG = "{http://www.w3.org/2000/svg}"
LOAD = Load.fourier([900.0, 1000.0], frequency=60.0)
PISTON = SectionedBar([Section(0.1, diameter=0.05), Section(0.3, diameter=0.04, bore=0.01)])


def drawn(system: System) -> ElementTree.Element:
    return ElementTree.fromstring(bar_outline(system))


def test_sections_are_drawn_to_one_scale() -> None:
    *sections, wall = drawn(System.from_si(PISTON, LOAD, Kept(0.3))).findall(f"{SVG}rect")
    sizes = [[float(one.attrib[key]) for key in ("x", "y", "width", "height")] for one in sections]
    assert sizes == [[0.0, -62.5, 250.0, 125.0], [250.0, -50.0, 750.0, 100.0]]
    assert float(wall.attrib["x"]) > 1000.0


def test_a_bore_is_drawn_in_its_section() -> None:
    lines = drawn(System.from_si(PISTON, LOAD, Kept(0.3))).findall(f"{SVG}line")
    assert sorted(float(line.attrib["y1"]) for line in lines) == [-12.5, 12.5]
    assert {float(line.attrib["x1"]) for line in lines} == {250.0}


@pytest.mark.parametrize(("at", "arrows", "x"), [(0, 1, -48.0), (1, 2, 202.0)])
def test_the_load_is_drawn_where_it_acts(at: int, arrows: int, x: float) -> None:
    paths = drawn(System.from_si(PISTON, LOAD.acting_at(at), Kept(0.3))).findall(f"{SVG}path")
    assert len(paths) == arrows
    assert all(path.attrib["d"].startswith(f"M{x:g} ") for path in paths)


def test_a_uniform_bar_is_one_rectangle_and_a_system_without_sizes_none() -> None:
    assert len(drawn(System.from_si(Bar(0.4, 1e-3), LOAD, Kept(0.3))).findall(f"{SVG}rect")) == 2
    with pytest.raises(ParameterError):
        bar_outline(System(UniformBar(20.0), Load.harmonic(0.9, 1.0), Kept(0.3)))
