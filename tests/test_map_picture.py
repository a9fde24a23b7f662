"""The picture of a map: what has no value is not drawn as one, kinds of curves have a legend, axes read plainly."""

from __future__ import annotations

import dataclasses
import itertools
from types import SimpleNamespace

import numpy as np
import pytest

pytest.importorskip("matplotlib")

from percuss import Load, System
from percuss.explore import Sweep, sweep
from percuss.plot import sweep as picture
from percuss.plot.map_axes import round_ticks
from percuss.plot.map_plane import SHADES

SYSTEM = System(s=20.0, d=0.0048, restitution=0.6, load=Load.harmonic(0.9, 1.0))
PLANE = ("restitution=0.2:0.8:4", "load_factor=0.3:0.9:3")


def a_map(*axes: str, quantities: tuple[str, ...] = ("exists", "orbits")) -> Sweep:
    return sweep(SYSTEM, *axes, quantities=list(quantities), workers=1)


def key(figure) -> list[str]:
    return [text.get_text() for legend in figure.legends for text in legend.get_texts()]


@pytest.mark.parametrize("outcome", [2, 3, 4, 5, -1])
def test_cells_without_a_value_are_not_drawn(outcome):
    found = a_map(*PLANE)
    found.arrays["outcome"][1, 2] = outcome
    figure = picture(found)
    for panel in figure.axes:
        drawn = np.ma.getmaskarray(panel.collections[0].get_array()).reshape(3, 4)
        assert drawn[2, 1] and drawn.sum() == 1
    assert key(figure) == ["no value"]
    line = a_map(PLANE[0])
    line.arrays["outcome"][1] = outcome
    assert all(np.isnan(panel.lines[0].get_ydata()[1]) for panel in picture(line).axes)


def test_where_there_is_no_motion_is_a_value():
    found = a_map(*PLANE)
    found.arrays["outcome"][1, 2] = 1
    assert key(picture(found)) == []


def test_kinds_of_curves_have_a_legend():
    kinds = ["fold", "flip", "neimark-sacker", "grazing", "fold"]
    curves = [SimpleNamespace(kind=kind, x=np.array([0.3, 0.6]), y=np.array([0.4, 0.8])) for kind in kinds]
    figure = picture(a_map(*PLANE), curves=curves)
    assert key(figure) == ["fold", "flip", "Neimark–Sacker", "grazing"]
    assert len({line.get_linestyle() for line in figure.legends[0].get_lines()}) == 4


def test_margins_end_at_one_and_rest_is_named():
    found = a_map(*PLANE, quantities=("reduced_margin",))
    values = np.linspace(-50.0, 0.3, 12).reshape(4, 3)
    found.arrays["reduced_margin"][:] = values
    found.arrays["lyapunov"] = np.where(values < -40.0, -np.inf, values / 100.0)
    figure = picture(dataclasses.replace(found, quantities=("reduced_margin", "lyapunov")))
    norm = figure.axes[0].collections[0].norm
    assert (norm.vmin, norm.vmax) == (-1.0, pytest.approx(0.3))
    assert key(figure) == ["−∞: comes to rest"]


def test_axes_read_plainly():
    figure = picture(a_map("s=0.5:20:9:log", "m=1:3:3"))
    assert [tick.get_text() for tick in figure.axes[0].get_xticklabels()] == ["0.5", "1", "2", "5", "10", "20"]
    assert [tick.get_text() for tick in figure.axes[0].get_yticklabels()] == ["1", "2", "3"]
    assert round_ticks(0.001, 1000.0) == pytest.approx([10.0**i for i in range(-3, 4)])


def test_panels_of_a_line_share_their_range():
    found = a_map("load_factor=0.1:1.2:12", quantities=("exists", "phase", "phases", "reduced_margin"))
    assert len({panel.get_xlim() for panel in picture(found).axes}) == 1


@pytest.mark.parametrize("axes", [("load_factor=0.9",), ("load_factor=0.9", "m=1,2")])
def test_one_value_is_seen(axes):
    for panel in picture(a_map(*axes)).axes:
        marked = any(line.get_marker() == "o" for line in panel.lines)
        areas = [np.ptp(mesh.get_coordinates()[..., 0]) for mesh in panel.collections]
        assert marked or min(areas) > 0.0


def test_twelve_colours_of_their_own():
    colours = np.array([[int(shade[i : i + 2], 16) for i in (1, 3, 5)] for shade in SHADES])
    assert len(SHADES) == 12
    assert all(np.abs(a - b).max() > 60 for a, b in itertools.combinations(colours, 2))
