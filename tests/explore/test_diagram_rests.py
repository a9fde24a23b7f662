"""Cycles with rest in diagrams: their branches are those that are followed alone, on what simulations settle on."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from percuss import Load, System, plot
from percuss.explore import BranchEvent, Diagram, diagram, follow
from percuss.explore.continuation.branch import Branch
from percuss.explore.continuation.rest_following import KEPT_IMPACTS
from percuss.explore.diagrams.diagram_lines import line_of, lines_from, packed
from percuss.explore.diagrams.tracing import rests_traced
from percuss.explore.family import family_of
from percuss.model import Kept, ModalBody
from percuss.steady import rest_cycles

RIGID = System(s=5.0, d=0.0, restitution=0.2, load=Load.harmonic(0.5, 1.0))
ASKED: dict[str, Any] = {"up_to": (1, 1), "searched": 1, "switch": 0, "tries": 4, "modes": 0, "workers": 1}


@pytest.fixture(scope="module")
def found() -> Diagram:
    return diagram(RIGID, "mean=0.44:0.52:5", **ASKED, starts=3, runs=1)


@pytest.fixture(scope="module")
def line(found: Diagram) -> Branch:
    (only,) = found.rest_branches
    return only


def test_it_ends_at_the_onset_of_the_chatter(line: Branch) -> None:
    first, last = line.points
    assert (line.label, first.kind, last.kind) == ("chatter/1", BranchEvent.ONSET, BranchEvent.LIMIT)
    assert first.value == pytest.approx(0.457825216970, abs=1e-10)
    assert (first.impact, first.touch_phase) == (None, None)
    assert "z=p/1" in first.beyond
    assert "chatter/1" in str(first)
    (again,) = lines_from(packed([line], 1 << 20)[0])
    assert again.has_rest and packed([again], 1 << 20) == packed([line], 1 << 20)


def test_the_bar_is_let_go_where_the_load_begins_to_pull(line: Branch) -> None:
    """Load x + cos t: at arccos(-x); from there it flies for longer than the load pulls."""
    release = np.arccos(-line.values)
    assert line.release_phases[:, 0] == pytest.approx(release, abs=1e-12)
    assert np.all(line.times[:, 0, 0] > line.releases[:, 0] + 2.0 * (math.pi - release))
    flights = np.diff(line.times[:, 0, :], axis=-1)
    assert np.all(flights > 0.0)
    assert np.all(flights.sum(axis=-1) < line.rests[:, 0] - line.times[:, 0, 0])
    assert line.times.shape[-1] == KEPT_IMPACTS
    assert line.stable.all()


def test_simulations_settle_on_it(found: Diagram, line: Branch) -> None:
    """The main blow and its energy, within what a straight line between two points is off."""
    settled = [one for one in found.settled if one.label == "chatter/1"]
    assert len(settled) == 4
    for one in settled:
        phase = float(np.interp(one.value, line.values, line.phases[:, 0, 0]))
        assert one.phases[int(np.argmax(one.speeds))] == pytest.approx(phase, abs=2e-3)
        assert one.energy == pytest.approx(np.interp(one.value, line.values, line.energies), rel=2e-3)
    assert line.energies == pytest.approx(0.5 * line.speeds[:, 0, 0] ** 2, rel=1e-9)
    for one in found.settled:
        assert np.isfinite(one.energy) == (one.label not in ("rest", "departed"))


def test_the_dataset_tells_when_the_bar_is_let_go(found: Diagram, line: Branch) -> None:
    dataset = found.to_xarray()
    resting = dataset.isel(row=np.isfinite(dataset["release_phase"].values))
    assert set(resting["label"].values.tolist()) == {"chatter/1"}
    assert set(resting["number"].values.tolist()) == {len(found.branches) + 1}
    assert resting["phase"].values == pytest.approx(line.phases[np.isfinite(line.phases)])
    assert resting.sizes["row"] == np.isfinite(line.phases).sum()
    assert "onset" in dataset["event_type"].values.tolist()


def test_the_picture_tells_them(found: Diagram) -> None:
    (legend,) = plot.diagram(found, quantities=("phase", "speed", "energy")).legends
    told = {text.get_text() for text in legend.get_texts()}
    assert {"chatter/1", "onset", "is let go", "comes to rest"} <= told
    (legend,) = plot.diagram(found, quantities=("speed",)).legends
    assert "is let go" not in {text.get_text() for text in legend.get_texts()}


def test_an_archive_without_them_goes_on(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The question is the same whether they are traced or not: what an archive has of it stays."""
    asked = {**ASKED, "archive": tmp_path / "d.zarr", "starts": 1, "runs": 0}
    with monkeypatch.context() as patched:
        patched.setattr("percuss.explore.diagrams.diagram_job.rests_traced", lambda *_, **__: [])
        diagram(RIGID, "mean=0.44:0.52:3", **asked)
    again = diagram(RIGID, "mean=0.44:0.52:3", **asked, resume=True)
    assert again.done == 1.0
    assert again.rest_branches == ()


def test_only_what_rests_as_a_whole_has_them() -> None:
    """An elastic bar goes on otherwise after each of many touches; of a structure all modes are followed."""
    several = System(
        ModalBody((3.3, 7.3), (0.3, 0.1), (1.0, 0.8), (1.0, -0.5), -0.01), Load.harmonic(0.0, 1.0), Kept(0.4)
    )
    lines = rests_traced(family_of(several), "gap", (-0.0105, -0.0095), [-0.01], 2, stopped=lambda: False)
    assert len(lines) >= 2 and {line.label for line in lines} == {"chatter/1"}
    assert {bool(line.stable.all()) for line in lines} == {True, False}
    endless = System(s=5.0, d=50.0, restitution=1.0, load=Load.harmonic(0.5, 1.0))  # its chatter never ends
    for system, modes, name in ((RIGID, 2, "mean"), (endless, 0, "mean")):
        assert not rests_traced(family_of(system), name, (0.0, 0.6), [0.3, 0.5], modes, stopped=lambda: False)


def test_nothing_is_traced_for_nobody() -> None:
    family = family_of(RIGID)
    assert not rests_traced(family, "mean", (0.44, 0.6), [0.5], 0, stopped=lambda: True)


def test_impacts_are_told_by_release_with_one_rest_and_with_two() -> None:
    """R = 0: one impact while the load pushes ends in rest; of a load with two dips the bar is let go twice."""
    system = replace(RIGID, contact=Kept(0.0)).with_load(Load.fourier([0.9, 0.2, 0.9]))
    (cycle,) = rest_cycles(system, modes=0).orbits
    line = line_of(follow(cycle, "mean", (0.89, 0.91), points=3), lambda mean: system)
    rests = cycle.release_phases.size
    assert rests == 2
    assert line.releases.shape == line.rests.shape == (line.values.size, rests)
    assert line.times.shape == (line.values.size, rests, 1)
    assert np.all(line.releases < line.times[..., 0])
    assert np.all(line.times[..., 0] <= line.rests)
