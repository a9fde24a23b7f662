"""Periodic motions of every hammer, whatever way they were found: one set of questions, answered alike."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from hammers import HAMMERS, Hammer
from percuss import Load, Start, Stop, System, run
from percuss.errors import ParameterError
from percuss.explore import Boundaries, Branch, Diagram, PointCurve, boundaries, diagram, follow_point
from percuss.model import Machine
from percuss.stability import floquet_multipliers, stability_of
from percuss.steady import RestCycle, orbits, rest_cycles, steady_states
from percuss.steady.figures import FIGURES

RESTING = {
    "smooth": HAMMERS["smooth"],
    "damped": Hammer(System(3.0, 0.1, 0.5, Load.square(1.0, 1.3, 5)), 3, ()),
    "strikes twice": Hammer(System(5.0, 0.0, 0.5, Load.harmonic(0.46, 1.0)), 0, ()),
}


def found(hammer: Hammer) -> list[Any]:
    """Motions of some labels, with one blow in a cycle and with several."""
    labels = ((1, 1),) if isinstance(hammer.what, Machine) else ((1, 1), (2, 1), (2, 2))
    return [one for label in labels for one in orbits(hammer.what, *label, modes=hammer.modes, tries=40)]


@pytest.mark.parametrize("name", HAMMERS)
def test_every_motion_answers_what_all_are_asked(name: str) -> None:
    hammer = HAMMERS[name]
    motions = found(hammer)
    assert motions
    for one in motions:
        judged = stability_of(one)
        assert one.stable == judged.stable == (one.multipliers().largest < 1.0)
        assert one.verdict is judged.kind and one.admissible and one.obstacle is None
        assert floquet_multipliers(one).moduli == pytest.approx(one.multipliers(hammer.modes).moduli)
        assert judged.margin == pytest.approx(
            1.0 - max(m for m in (one.multipliers().rhythm, one.multipliers().ringing) if m is not None)
        )
        with pytest.raises(ParameterError, match="modes"):
            one.multipliers(hammer.modes + 1)
        assert set(one.figures) == set(FIGURES)
        assert len(one.times) == len(one.phases) == len(one.speeds) == one.impacts
        assert None not in {
            one.figures[key] for key in FIGURES if key not in ("efficiency", "stress", "receiving_stress")
        }
        t = np.linspace(0.0, one.period, 301)
        assert -one.motion(t).min() == pytest.approx(one.stroke, rel=3e-3) and one.motion(t).max() < 1e-9


@pytest.mark.parametrize("name", HAMMERS)
def test_a_branch_gives_its_motions_and_what_is_recorded_of_them(name: str, tmp_path: Path) -> None:
    hammer = HAMMERS[name]
    one, along = found(hammer)[0], "restitution"
    here = hammer.what.contact.restitution  # type: ignore[attr-defined]
    branch = one.follow(along, (here - 0.02, here + 0.02), record={"stroke": lambda motion: motion.stroke})
    assert branch.parameter == along and len(branch) == branch.values.size == len(branch.motions)
    at = int(np.argmin(np.abs(branch.values - here)))
    assert branch[at].figures["blow_energy"] == pytest.approx(one.figures["blow_energy"], rel=1e-6)
    assert branch.recorded["stroke"][at] == pytest.approx(one.stroke, rel=1e-6)
    smooth = np.logical_and.reduce([branch.values != point.value for point in branch.points])
    assert np.array_equal(np.sum(np.abs(branch.multipliers) > 1.0, axis=1)[smooth], branch.unstable[smooth])
    branch.save(tmp_path / "branch.nc")
    again = Branch.load(tmp_path / "branch.nc")
    assert (
        json.dumps(again.as_json()) == json.dumps(branch.as_json()) and str(again) == str(branch) and not again.motions
    )
    assert again[at].phases == pytest.approx(branch[at].phases)
    with pytest.raises(ParameterError, match="record"):
        one.follow(along, record={"stroke": 3.0})


def test_energy_and_stroke_of_a_cycle_with_rest_are_those_of_a_simulation() -> None:
    for hammer in RESTING.values():
        assert isinstance(hammer.what, System)
        for cycle in rest_cycles(hammer.what, modes=hammer.modes):
            begin = cycle.chains[0].release
            last = begin + 1.5 * cycle.period
            motion = run(
                hammer.what,
                Start.rigid(0.0, 0.0, begin),
                modes=hammer.modes,
                stop=Stop(time=1.5 * cycle.period, periodic=False),
            )
            balance, t = motion.energy_balance(begin, begin + cycle.period), np.linspace(0.0, cycle.period, 97)
            assert motion.gap(begin + t) == pytest.approx(cycle.motion(t), abs=1e-9 * cycle.stroke)
            assert balance.input == pytest.approx(cycle.energy.input, rel=1e-9)
            assert balance.damping == pytest.approx(cycle.energy.damping, rel=1e-9, abs=1e-12)
            assert cycle.stable and cycle.rests and stability_of(cycle).reason.endswith("erases all disturbances")
            assert cycle.figures["mean_force"] == pytest.approx(hammer.what.load.mean)
            assert last > begin


def test_energy_of_several_blows_is_that_of_a_simulation() -> None:
    for name in ("smooth", "elastic", "structure"):
        hammer = HAMMERS[name]
        for one in found(hammer):
            if one.impacts == 1:
                continue
            motion = run(
                hammer.what, Start.orbit(one), modes=hammer.modes, stop=Stop(time=1.2 * one.period, periodic=False)
            )
            balance = motion.energy_balance(one.phase, one.phase + one.period * (1.0 - 1e-9))
            assert balance.damping == pytest.approx(one.energy.damping, rel=1e-5, abs=1e-9)
            assert -motion.gap(one.phase + np.linspace(0.0, one.period, 4001)).min() == pytest.approx(
                one.stroke, rel=1e-5
            )


def test_a_continuous_bar_is_followed_with_a_number_of_modes_alone() -> None:
    system = System(s=5.0, d=0.0, restitution=0.5, load=Load.harmonic(0.62, 1.0))
    with pytest.raises(ParameterError, match="steady_states\\(system, modes=32\\)"):
        steady_states(system)[1].follow("mean", (0.6, 0.65))
    assert steady_states(system, modes=4)[1].follow("mean", (0.6, 0.65)).modes == 4


def test_what_is_found_has_length_order_and_a_table() -> None:
    system = System(s=5.0, d=0.0, restitution=0.5, load=Load.harmonic(0.62, 1.0))
    for every in (orbits(system, 1, modes=0), rest_cycles(system, modes=0), steady_states(system)):
        assert len(every) == len(every.orbits) and list(every) == list(every.orbits) and every[0] is every.orbits[0]
        assert list(every.to_pandas()["label"]) == [one.label for one in every]
    assert isinstance(rest_cycles(system, modes=0)[0], RestCycle)


def test_diagrams_boundaries_and_curves_are_saved_and_read(tmp_path: Path) -> None:
    system, place = System(5.0, 0.0, 0.5, Load.harmonic(0.62, 1.0)), tmp_path / "kept.nc"
    flip = orbits(system, 1, modes=0)[1].follow("mean", (0.3, 1.2)).at("flip")[0]
    every: list[Any] = [
        boundaries(system, ("restitution", [0.3, 0.4]), ("load_factor", 0.1, 1.0)),
        diagram(system, "mean=0.7:0.8:2", up_to=(1, 1), searched=1, switch=0, starts=1, runs=0, modes=0, workers=1),
        follow_point(flip, ("restitution", "mean"), ((0.48, 0.52), (0.3, 1.2)), most=9),
    ]
    for one, kind in zip(every, (Boundaries, Diagram, PointCurve), strict=True):
        one.save(place)
        again = kind.load(place)
        assert json.dumps(again.as_json()) == json.dumps(one.as_json()) and str(again) == str(one)
        assert len(one.to_pandas())
        one.save(tmp_path / "table.csv")
        with pytest.raises(ParameterError, match=f"{Branch.__name__}.save wrote"):
            Branch.load(place)
