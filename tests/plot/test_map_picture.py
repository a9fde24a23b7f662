"""The picture of a map: what has no value is not drawn as one, kinds of curves have a legend, axes read plainly."""

from __future__ import annotations

import dataclasses
import itertools
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

pytest.importorskip("matplotlib")

from matplotlib import colors, rc_params_from_file

from percuss import Load, Start, System, palette, run
from percuss.case import load_case, steady_answer
from percuss.explore import Sweep, sweep
from percuss.plot import steady as steady_picture
from percuss.plot import sweep as picture
from percuss.plot import trajectory as trajectory_picture
from percuss.plot.map_picture import round_ticks

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
    colours = np.array([[int(shade[i : i + 2], 16) for i in (1, 3, 5)] for shade in palette.AREAS])
    assert len(palette.AREAS) == 12
    assert all(np.abs(a - b).max() > 60 for a, b in itertools.combinations(colours, 2))


FAMILIES = {
    "rest": 0,
    "z=1/1": 1,
    "z=1/2": 2,
    "z=1/17": 2,
    "z=2/1": 3,
    "z=2/2": 3,
    "z=11/11": 3,
    "chatter/1": 4,
    "chatter/105": 4,
    "rest/3": 4,
    "aperiodic": 5,
    "undecided": 6,
    "departed": 6,
}


def test_every_motion_belongs_to_one_of_seven_families():
    assert len(palette.FAMILIES) == 7
    assert {label: palette.family_of(label) for label in FAMILIES} == FAMILIES
    looks = [(family.colour.light, family.hatch) for family in palette.FAMILIES]
    assert len({colour for colour, _ in looks}) == 7
    assert len({hatch for _, hatch in looks if hatch}) == 5  # the two without are the darkest ones


class _Motions:
    """A map of found motions, which are these."""

    quantities, columns, words = ("label",), {}, {}

    def __init__(self, *labels: str) -> None:
        self.axes = a_map(*PLANE).axes
        self.arrays = {
            "label": np.array([labels[i % len(labels)] for i in range(12)]).reshape(4, 3),
            "outcome": np.zeros((4, 3), dtype=int),
        }

    def __getitem__(self, name: str) -> np.ndarray:
        return self.arrays[name]


def _look(figure) -> dict[str, tuple[str, str]]:
    """Of every entry of the legend beside the first panel its colour and its hatch."""
    patches = figure.axes[0].get_legend().get_patches()
    return {patch.get_label(): (colors.to_hex(patch.get_facecolor()), patch.get_hatch()[:1]) for patch in patches}


def test_found_motions_look_the_same_in_every_map():
    many = [f"chatter/{n}" for n in range(1, 6)] + [f"z={n}/{n + 1}" for n in range(1, 6)] + ["rest", "z=1/1"]
    seen: dict[str, set[tuple[str, str]]] = {}
    for labels in (many, ["z=1/1", "rest"], ["rest", "undecided", "z=1/1"], ["aperiodic"]):
        found = _Motions(*labels)
        figure = picture(found)
        mesh = figure.axes[0].collections[0]
        drawn = mesh.cmap(mesh.norm(mesh.get_array())).reshape(3, 4, 4)
        for i, j in itertools.product(range(4), range(3)):
            family = palette.FAMILIES[palette.family_of(str(found["label"][i, j]))]
            assert colors.to_hex(drawn[j, i]) == family.colour.light
        for name, look in _look(figure).items():
            seen.setdefault(name, set()).add(look)
    assert len(seen) == 7 and all(len(looks) == 1 for looks in seen.values())
    assert seen["at rest for good"] != seen["z=1/1, one blow a period"]


def _ends(mappable) -> tuple[str, str]:
    """The colours of the greatest compression (negative) and of the greatest tension."""
    low, high = mappable.norm.vmin, mappable.norm.vmax
    assert low == -high
    return colors.to_hex(mappable.cmap(mappable.norm(low))), colors.to_hex(mappable.cmap(mappable.norm(high)))


def test_compression_is_blue_and_negative_in_every_picture():
    ends = (palette.STRAIN[0].light, palette.STRAIN[-1].light)
    blue, orange = (colors.to_rgb(colour) for colour in ends)
    assert blue[2] > blue[0] and orange[0] > orange[2]
    steady = steady_picture(steady_answer(load_case("mini-breaker")))
    moving = trajectory_picture(run(SYSTEM, Start.rigid(time=0.3), modes=4))
    for figure in (steady, moving):
        image = next(ax.images[0] for ax in figure.axes if ax.images)
        assert _ends(image) == ends
        assert any(palette.SIGN in ax.get_ylabel() for ax in figure.axes)


def test_the_gallery_has_the_colours_of_the_palette():
    docs = Path(__file__).resolve().parents[2] / "docs"
    cycle = rc_params_from_file(str(docs / "matplotlibrc"), use_default_template=False)["axes.prop_cycle"]
    assert [f"#{c.lstrip('#')}" for c in cycle.by_key()["color"]] == list(palette.CYCLE)
    for script in (docs / "gallery").glob("*.py"):
        assert "RdBu" not in script.read_text(encoding="utf-8"), script.name
