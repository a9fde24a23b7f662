"""Pictures of simulated motions: for every kind of motion, with the right things on them."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("matplotlib")

from percuss import Load, Start, Stop, System, Trajectory, plot, run
from percuss.case import MACHINES, load_case, simulation_answer
from percuss.plot.trajectory_picture import MOST_POINTS, window_of

TURN = 2.0 * np.pi


def system(mean: float, restitution: float, **others: Any) -> System:
    return System(s=20.0, d=0.0048, restitution=restitution, load=Load.harmonic(mean, 1.0), **others)


@cache
def motion(kind: str) -> Trajectory:
    start = Start.rigid(time=0.3)
    ball = System(s=1.0, d=0.0, restitution=0.7, load=Load.harmonic(1.0, 0.0))
    endless = Stop(impacts=60_000, periodic=False)
    if kind == "steady":
        return simulation_answer(load_case("mini-breaker").changed(start={"orbit": 2})).motion
    return {
        "chatter": lambda: run(system(0.9, 0.6), start, modes=8),
        "rest": lambda: run(system(1.5, 0.6), start, modes=8),
        "plastic": lambda: run(system(0.7, 0.0), start, modes=0),
        "ball": lambda: run(ball, start, modes=0),
        "chaos": lambda: run(system(0.3, 0.8), start, modes=0, stop=endless),
        "long cycle": lambda: run(system(0.7, 0.6), start, modes=0, stop=endless),
        "flight": lambda: run(system(0.9, 0.6), start, modes=8, stop=Stop(time=0.5)),
        "one": lambda: run(system(0.9, 0.6), start, modes=8, stop=Stop(impacts=1)),
        "nothing": lambda: run(system(0.9, 0.6), start, modes=8, stop=Stop(impacts=0)),
        "on the wall": lambda: run(system(0.9, 0.6), Start.rigid(0.0, 1.0, 0.3), modes=0, stop=Stop(impacts=1)),
    }[kind]()


def titles(figure: Any) -> list[str]:
    return [panel.get_title(loc="left") for panel in figure.axes[:5]]


@pytest.mark.parametrize(
    "kind", ["steady", "chatter", "rest", "plastic", "ball", "chaos", "flight", "one", "nothing", "on the wall"]
)
def test_every_kind_of_motion(kind: str, tmp_path: Path) -> None:
    found = motion(kind)
    figure = plot.trajectory(found)
    assert [title[:3] for title in titles(figure)] == ["(a)", "(b)", "(c)", "(d)", "(e)"]
    assert figure.get_suptitle() == found.label
    assert plot.save(figure, tmp_path / "picture.png").stat().st_size > 5000
    words = [text.get_text() for panel in figure.axes for text in panel.texts]
    assert ("no impact" in words) is (found.impacts == 0)
    gap = figure.axes[0]
    low, high = gap.get_ylim()
    assert low < float(window_of(found).gap.min()) <= 0.0 < high


def test_marks_are_whole_and_do_not_hide_each_other() -> None:
    figure = plot.trajectory(simulation_answer(load_case("laboratory-striker")).motion)
    figure.canvas.draw()
    gap, speeds, impacts = figure.axes[:3]
    rows = {}
    for line in gap.lines:
        if line.get_label() in ("impact", "chatter", "rest"):
            place = line.get_transform().transform(line.get_xydata())
            rows[line.get_label()] = place[:, 1] * 72.0 / figure.dpi
            assert place[:, 1].max() < gap.bbox.y1
    assert rows["chatter"].min() > rows["impact"].max() + 5.0 and rows["rest"].min() > rows["chatter"].max() + 5.0
    for panel in (speeds, impacts):
        dots = [line for line in panel.lines if line.get_marker() == "o" and len(line.get_xdata())]
        assert dots and not any(line.get_clip_on() for line in dots)


def marks(figure: Any) -> dict[str, int]:
    return {line.get_label(): len(line.get_xdata()) for line in figure.axes[0].lines if line.get_label()[0] != "_"}


@pytest.mark.parametrize("kind", ["chatter", "plastic", "ball", "one"])
def test_every_event_of_the_window_is_marked(kind: str) -> None:
    found = motion(kind)
    shown = window_of(found).events
    expected = {name: len(shown.of(name)) for name in np.unique(shown.kind)}
    assert marks(plot.trajectory(found)) == expected
    assert sum(expected.values()) > 0


def test_the_window() -> None:
    chatter = window_of(motion("chatter"))
    assert (chatter.what, chatter.last - chatter.first) == ("the last two cycles", pytest.approx(2.0 * TURN))
    assert window_of(motion("ball")).what == "the whole motion"
    long = window_of(motion("chaos"))
    assert long.what == "the last flights"
    assert long.last - long.first < 100.0 * TURN
    assert len(long.events.of("impact")) >= 4


def test_the_samples_meet_every_event_and_its_jump() -> None:
    window = window_of(motion("plastic"))
    blow = window.events.of("impact")
    at = np.flatnonzero(window.velocity[0] == blow.time[0])
    assert window.velocity[1][at] == pytest.approx([blow.impact_velocity[0], blow.rebound_velocity[0]], abs=1e-9)
    assert np.abs(window.gap[np.isin(window.times, window.events.time)]).max() < 1e-12


def points(panel: Any) -> list[int]:
    return [len(line.get_xdata()) for line in panel.lines]


def test_many_impacts_are_thinned_out() -> None:
    found = motion("chaos")
    assert found.impacts == 60_000
    figure = plot.trajectory(found)
    for panel in figure.axes[1:3]:
        assert max(points(panel)) <= MOST_POINTS
        assert sum(points(panel)) > 10_000


def test_a_thinned_cycle_keeps_all_its_impacts() -> None:
    found = motion("long cycle")
    assert found.cycle is not None
    assert found.impacts - found.cycle.first > MOST_POINTS
    shown = plot.trajectory(found).axes[2].lines[1]
    places = {(round(float(x), 6), round(float(y), 6)) for x, y in zip(*shown.get_data(), strict=True)}
    assert len(places) == found.cycle.impacts


def test_settled_impacts_have_their_own_colour() -> None:
    found = motion("chatter")
    figure = plot.trajectory(found)
    first = found.transient
    assert first is not None
    assert points(figure.axes[1]) == points(figure.axes[2]) == [first, found.impacts - first]
    assert len({line.get_color() for line in figure.axes[1].lines}) == 2
    assert points(plot.trajectory(motion("ball")).axes[2]) == [motion("ball").impacts]  # no cycle: one colour


def test_units_on_the_axes() -> None:
    answer = simulation_answer(load_case("mini-breaker"))
    figure = plot.trajectory(answer)
    assert figure.get_suptitle() == "Hydraulic breaker for a mini excavator — z=1/1"
    assert figure.axes[0].get_ylabel() == "striking end [mm]"
    assert figure.axes[1].get_ylabel() == "striking speed [m/s]"
    speed = answer.summary.si
    assert speed is not None
    assert figure.axes[2].lines[1].get_ydata()[-1] == pytest.approx(speed.impact_velocity_m_s, rel=1e-6)
    plain = plot.trajectory(motion("chatter"))
    assert plain.axes[0].get_xlabel() == "time [load periods]"
    assert plot.trajectory(motion("ball")).axes[0].get_xlabel() == "time [rad]"


def test_rigid_bars_show_energy_and_elastic_ones_strain() -> None:
    assert titles(plot.trajectory(motion("plastic")))[4].startswith("(e) energy")
    figure = plot.trajectory(motion("rest"))
    assert titles(figure)[4].startswith("(e) strain")
    assert figure.axes[4].images[0].get_array().shape[0] == 101


@pytest.mark.parametrize("name", [*(machine.name for machine in MACHINES), "stopped-oscillator", "stopped-beam"])
def test_every_sample_has_a_picture_of_its_motion(name: str) -> None:
    case = load_case(name).changed(simulation={"impacts": 12})
    answer = simulation_answer(case)
    figure = (plot.machine_motion if case.is_machine else plot.trajectory)(answer)
    assert len(figure.axes) >= 4 and all(axes.has_data() for axes in figure.axes[:4])
