"""The pictures of a blow and of a search: the panels that the target calls for, and what the curves say."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

pytest.importorskip("matplotlib")

from percuss import plot
from percuss.blow.closed_forms import matched_efficiency
from percuss.case import Case, Span, best_answer, blow_answer
from percuss.errors import ParameterError

BAR = """
[bar]
length = "0.5 m"
area = "10 cm^2"
youngs_modulus = "200 GPa"
density = "8000 kg/m^3"
[blow]
velocity = "10 m/s"
until = "1 ms"
"""
SECTIONS = 'sections = [{length = "2 m", area = "10 cm^2", youngs_modulus = "200 GPa", density = "8000 kg/m^3"}]\n'
ROCK = f'[tool]\n{SECTIONS}end = "rock"\n[rock]\nstiffness = "400 kN/mm"\nunloading_ratio = 0.3\n'


def panels(text: str) -> dict[str, Any]:
    """By what their titles say after the mark, in the order of the marks."""
    figure = plot.blow(blow_answer(Case.from_text(text)))
    titled = sorted((axes.get_title(loc="left"), axes) for axes in figure.axes if axes.get_title(loc="left"))
    assert [title[:3] for title, _ in titled] == [f"({mark})" for mark in "abcdefg"[: len(titled)]]
    return {title[4:]: axes for title, axes in titled}


def test_each_target_has_its_panels() -> None:
    always = {"waves in the striker (left of the face) and in what it strikes", "greatest stress at each place",
              "where the energy went"}  # fmt: skip
    assert set(panels(BAR)) == always | {"force between the faces"}
    rod = panels(f'{BAR}[tool]\n{SECTIONS}end = "free"')
    assert set(rod) == always | {"force between the faces", "gauge at 1 m"}
    assert set(panels(BAR + ROCK)) == always | {"forces", "gauge at 1 m", "the rock", "efficiency"}
    elastic = panels(BAR + ROCK.replace("0.3", "1.0"))
    assert "the rock" in elastic and "efficiency" not in elastic  # which keeps nothing


def test_a_matched_hammer_stands_on_lundbergs_curve() -> None:
    """β = K₁T/Z with T = 2L/c = 0.2 ms, Z = 4e4 N·s/m: 2; its later waves do not reach the rock in 1 ms."""
    axes = panels(BAR + ROCK)["efficiency"]
    point = next(line for line in axes.lines if "this blow" in line.get_label())
    assert point.get_xdata()[0] == pytest.approx(2.0, rel=1e-9)
    assert point.get_ydata()[0] == pytest.approx(100.0 * matched_efficiency(2.0, 0.3), rel=1e-6)


def test_the_greatest_stresses_touch_the_exact_ones_of_the_sections() -> None:
    axes = panels(BAR + ROCK)["greatest stress at each place"]
    lowest = min(float(np.min(patch.get_data().values)) for patch in axes.patches)
    dots = [float(line.get_ydata()[0]) for line in axes.lines if line.get_marker() == "." and len(line.get_ydata())]
    assert min(dots) * (1.0 + 1e-9) <= lowest == pytest.approx(min(dots), rel=0.02)


def test_a_search_beside_the_case() -> None:
    found = best_answer(Case.from_text(BAR + ROCK), [Span.parsed("bar.length=100:500mm")], "efficiency", most=20)
    titles = [axes.get_title(loc="left") for axes in plot.best(found).axes]
    assert [title[:3] for title in sorted(titles)] == ["(a)", "(b)", "(c)", "(d)"]
    with pytest.raises(ParameterError):
        plot.best(blow_answer(Case.from_text(BAR)))
