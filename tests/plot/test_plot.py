"""Pictures: made for every kind of answer, with the right number of things on them, in every format."""

from __future__ import annotations

import subprocess
import sys
import warnings
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("matplotlib")

from case_texts import plain_case
from percuss import Load, System, plot, steady_states
from percuss.case import Case, SteadyAnswer, load_case, steady_answer
from percuss.errors import ParameterError, PercussError
from percuss.plot.canvas import units_of

SQUARE = """
title = "Square"
[system]
s = 20.0
d = 0.0048
restitution = 0.6
[load]
kind = "square"
amplitude = 1.0
kappa = 1.1
"""
NOTHING = SQUARE.replace("kappa = 1.1", "kappa = 1.99")


@pytest.fixture(scope="module")
def striker() -> SteadyAnswer:
    return steady_answer(load_case("laboratory-striker"), (1, 2))


@pytest.mark.parametrize(("suffix", "start"), [(".png", b"\x89PNG"), (".svg", b"<?xml"), (".pdf", b"%PDF")])
def test_formats(striker: SteadyAnswer, tmp_path: Path, suffix: str, start: bytes) -> None:
    figure = plot.steady(striker)
    path = plot.save(figure, tmp_path / f"picture{suffix}")
    assert path.read_bytes().startswith(start)
    assert path.stat().st_size > 5000


def test_same_answer_same_picture(striker: SteadyAnswer, tmp_path: Path) -> None:
    first = plot.save(plot.steady(striker), tmp_path / "a.svg").read_bytes()
    assert plot.save(plot.steady(striker), tmp_path / "b.svg").read_bytes() == first


def test_a_title_that_no_font_has_is_drawn_without_a_word(tmp_path: Path) -> None:
    case = Case.from_text('title = "🔨"\n' + plain_case())
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert plot.save(plot.steady(steady_answer(case, starts=0)), tmp_path / "a.png").stat().st_size > 5000


def test_panels_carry_units(striker: SteadyAnswer) -> None:
    axes = plot.steady(striker).axes
    assert [panel.get_title(loc="left")[:3] for panel in axes[:5]] == ["(a)", "(b)", "(c)", "(d)", "(e)"]
    assert axes[1].get_ylabel() == "force [N]"
    assert axes[2].get_xlabel() == "time after impact [ms]"
    assert units_of(load_case("heavy-breaker").system()).force_label == "force [kN]"


def test_the_legend_names_what_is_in_view_and_says_what_is_not() -> None:
    answer = steady_answer(load_case("hydraulic-drifter"), range(1, 7))
    panel = plot.steady(answer).axes[0]
    low, high = panel.get_ylim()
    named = {line.get_label(): line.get_ydata()[0] for line in panel.lines if str(line.get_label()).startswith("level")}
    levels = {f"level, m = {period.states.periods}": period.states.level for period in answer.periods}
    assert named == {name: level for name, level in levels.items() if low < level < high}
    assert 0 < len(named) < 6
    texts = [text.get_text() for text in panel.get_legend().get_texts()]
    assert "far above" in " ".join(texts) and all(str(m) in " ".join(texts) for m in range(1, 7))


def test_the_picture_of_the_waves_says_what_is_not_in_it(striker: SteadyAnswer) -> None:
    chosen = striker.chosen
    assert chosen is not None and chosen.si is not None
    title = plot.steady(striker).axes[4].get_title(loc="left")
    assert f"stress of the blow itself, {chosen.si.peak_stress_MPa:.0f} MPa" in title and "is not in it" in title


def test_steady_states_without_a_case(tmp_path: Path) -> None:
    system = load_case("pneumatic-jackleg").system()
    plain = System(s=system.s, d=system.d, restitution=system.restitution, load=Load.harmonic(0.7, 1.0))
    for one, unit in ((system, "[mm]"), (plain, "u(1, t)")):
        figure = plot.steady(steady_states(one))
        assert unit in figure.axes[2].get_ylabel()
        assert plot.save(figure, tmp_path / "states.png").stat().st_size > 5000
    both = [plot.steady(answer) for answer in (steady_states(system), steady_answer(load_case("pneumatic-jackleg")))]
    for a, b in zip(both[0].axes[:4], both[1].axes[:4], strict=True):
        assert [tuple(line.get_ydata()) for line in a.lines] == [tuple(line.get_ydata()) for line in b.lines]


@pytest.mark.parametrize("name", ["margin", "lyapunov"])
@pytest.mark.parametrize("values", [(-7.0, 0.04), (-0.2, 0.9), (0.1, 0.5), (-3.0, -0.1), (0.0, 0.0)])
def test_zero_is_the_middle_of_diverging_scales(name: str, values: tuple[float, float]) -> None:
    from percuss.plot.map_picture import _signed

    options, bar = _signed(np.array(values), name)
    assert options["norm"](0.0) == 0.5 and 0.0 in bar["ticks"]


def test_markers_tell_stable_from_unstable(striker: SteadyAnswer) -> None:
    panel = plot.steady(striker).axes[0]
    shown = [line for line in panel.lines if line.get_marker() == "o" and len(line.get_xdata()) == 1]
    orbits = striker.periods[0].orbits
    assert [float(line.get_xdata()[0]) for line in shown] == [found.orbit.phase for found in orbits]
    fills = [
        "white" if not found.stability.stable else line.get_color() for found, line in zip(orbits, shown, strict=True)
    ]
    assert [line.get_markerfacecolor() for line in shown] == fills


def test_square_load(tmp_path: Path) -> None:
    answer = steady_answer(Case.from_text(SQUARE), (1, 2, 3))
    load = plot.steady(answer).axes[1].lines[0]
    # both values at each jump: the wall of the square wave is upright
    jump = answer.system.load.jumps[1].phase
    at = [float(y) for x, y in zip(load.get_xdata(), load.get_ydata(), strict=True) if x == jump]
    assert set(at) == {1.0, -1.0}
    assert plot.save(plot.steady(answer), tmp_path / "square.png").stat().st_size > 5000


def test_no_orbit_is_drawn_too(tmp_path: Path) -> None:
    answer = steady_answer(Case.from_text(NOTHING))
    assert not answer.periods[0].states.exists
    figure = plot.steady(answer)
    assert sum("no steady motion" in text.get_text() for panel in figure.axes for text in panel.texts) == 3
    assert plot.save(figure, tmp_path / "none.png").stat().st_size > 5000


def test_wrong_targets(striker: SteadyAnswer, tmp_path: Path) -> None:
    figure = plot.steady(striker)
    with pytest.raises(ParameterError, match=r"\.png, \.svg, \.pdf"):
        plot.save(figure, tmp_path / "picture.gif")
    with pytest.raises(PercussError, match="cannot be written"):
        plot.save(figure, tmp_path / "none" / "picture.png")


def test_no_pyplot_and_no_early_import() -> None:
    code = (
        "import sys, percuss.plot\n"
        "assert 'matplotlib' not in sys.modules\n"
        "from percuss.case import load_case, steady_answer\n"
        "percuss.plot.steady(steady_answer(load_case('mini-breaker')))\n"
        "assert 'matplotlib' in sys.modules and 'matplotlib.pyplot' not in sys.modules\n"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


def test_missing_matplotlib_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    from percuss.errors import MissingExtraError
    from percuss.plot.canvas import new_figure

    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    with pytest.raises(MissingExtraError, match=r"percuss\[plot\]"):
        new_figure(1.0, 1.0)
