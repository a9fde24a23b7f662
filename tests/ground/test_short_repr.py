"""How results look at a prompt and in a notebook: short, whole, and safe."""

from __future__ import annotations

import dataclasses
import importlib
import inspect
from dataclasses import dataclass
from html.parser import HTMLParser

import numpy as np
import pytest

from percuss import Load, Start, System, run, steady_states
from percuss.case import load_case, simulation_answer, steady_answer
from percuss.explore import basins, boundaries, experiment, lyapunov_exponent, sweep
from percuss.short_repr import LONGEST, ShortRepr
from percuss.simulate import Event, Events, Starts, Stop, simulate_many
from percuss.stability import stability_of

SYSTEM = System(s=20.0, d=0.0048, restitution=0.6, load=Load.harmonic(0.9, 1.0))
ROOMS = ("steady", "stability", "simulate", "explore", "case", "model", "recordings")


class Cells(HTMLParser):
    """The cells of a table, and whether every element is closed."""

    def __init__(self, text):
        super().__init__()
        self.open, self.cells = [], []
        self.feed(text)
        assert not self.open

    def handle_starttag(self, tag, attrs):
        if tag != "br":
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.cells.append(data)


@pytest.fixture(scope="module")
def results():
    states = steady_states(SYSTEM)
    judged = stability_of(states.orbits[0])
    motion = run(SYSTEM, Start.rigid(time=0.3), modes=8)
    starts = Starts.rigid(-np.ones(500))
    map_of = sweep(SYSTEM, "restitution=0:0.9:40", "load_factor=0.1:1:40", quantities=["orbits", "phase"], workers=1)
    case = load_case("mini-breaker")
    answer = steady_answer(case)
    return [
        SYSTEM, SYSTEM.load, states, states.orbits[0], states.orbits[0].energy, judged, judged.multipliers,
        judged.reduced, judged.waveform, motion, motion.events, next(iter(motion.events)), motion.summary, starts,
        simulate_many(SYSTEM, starts, modes=4), map_of, map_of.axes[0],
        experiment(SYSTEM, starts=40, modes=0, workers=1), lyapunov_exponent(SYSTEM, Start.rigid(time=0.3), modes=0),
        basins(SYSTEM, ("time", 0.0, 6.2, 8), ("velocity", -6.0, -0.1, 8), modes=0, workers=1),
        boundaries(SYSTEM, ("restitution", np.linspace(0.1, 0.9, 9)), ("load_factor", 0.1, 2.0), kinds=("fold",)),
        answer, answer.periods[0], answer.periods[0].orbits[0], answer.periods[0].orbits[0].si, answer.rest,
        simulation_answer(case),
    ]  # fmt: skip


def test_results_print_in_a_line(results):
    for result in results:
        text = repr(result)
        assert "\n" not in text and len(text) <= LONGEST + 60, text
        assert type(result).__name__ in text or str(result).split("\n")[0] in text


def test_results_are_tables_in_notebooks(results):
    for result in results:
        cells = Cells(result._repr_html_()).cells
        shown = [f.name for f in dataclasses.fields(result) if f.repr and not f.name.startswith("_")]
        assert set(shown) <= set(cells)
        assert sum(map(len, cells)) < 6000
    orbits = Cells(steady_states(SYSTEM)._repr_html_()).cells
    assert sum("striking speed" in cell for cell in orbits) == 2  # a line for each


def test_the_truncation_of_an_orbit_prints_in_a_line():
    truncation = steady_states(SYSTEM).orbits[0].truncation
    assert repr(truncation).startswith(f"Truncation(modes={truncation.modes}, few=") and len(repr(truncation)) < 200
    assert str(truncation.modes) in Cells(truncation._repr_html_()).cells


def test_every_public_result_is_shown_so():
    """Public dataclasses that hold arrays or other results."""
    for room in ROOMS:
        module = importlib.import_module(f"percuss.{room}")
        for name in module.__all__:
            made = getattr(module, name)
            if inspect.isclass(made) and dataclasses.is_dataclass(made) and "__repr__" not in vars(made):
                assert issubclass(made, ShortRepr) or len(dataclasses.fields(made)) < 8, f"{room}.{name}"


def test_one_event_by_its_number():
    events = run(SYSTEM, Start.rigid(time=0.3), modes=2, stop=Stop(impacts=9, periodic=False)).events
    every = list(events)
    assert len(every) == len(events) > 8
    for i in (0, 3, -1, -len(events), np.int64(2)):
        one = events[i]
        assert one == every[i]
        assert isinstance(one, Event) and (one.kind, one.time) == (events.kind[i], events.time[i])
        for name in ("phase", "period", "piece", "resolved", "kinetic_energy", "impact_velocity", "energy_lost"):
            assert getattr(one, name) == getattr(events, name)[i]
        assert one.kind in repr(one) and one.kind in one._repr_html_() and one.kind in str(one)
    for i in (len(events), -len(events) - 1):
        with pytest.raises(IndexError):
            events[i]
    for part in (slice(2, 5), slice(None, None, -1), events.kind == "impact", np.array([1, -1])):
        assert isinstance(events[part], Events)
        assert np.array_equal(events[part].time, events.time[part])
        assert repr(events[part])


def test_text_is_escaped():
    @dataclass(frozen=True)
    class Titled(ShortRepr):
        title: str

        def __str__(self) -> str:
            return f"<b>{self.title}"

    text = Titled("<script>alert(1)</script>")._repr_html_()
    assert "<script>" not in text and "<b>" not in text and "&lt;script&gt;" in text
    Cells(text)
