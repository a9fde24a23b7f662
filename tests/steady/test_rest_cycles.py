"""Cycles with rest: published figures, closed forms, and the bounces of a chatter one by one."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.optimize import brentq

from orbit_cases import ENTRIES, of_kind, system_of
from percuss import Load, System
from percuss.errors import ParameterError, ResonanceError
from percuss.model import Reversed, UniformBar
from percuss.steady import RestCycle, rest_cycles

TURN = 2.0 * math.pi


def labels(system: System, modes: int = 0) -> list[str]:
    return [cycle.label for cycle in rest_cycles(system, modes=modes).orbits]


def cosine(mean: float, restitution: float) -> System:
    return System(s=5.0, d=0.0, restitution=restitution, load=Load.harmonic(mean, 1.0))


def only(system: System, modes: int = 0) -> RestCycle:
    (cycle,) = rest_cycles(system, modes=modes).orbits
    return cycle


@pytest.mark.parametrize("name", of_kind("rest_cycle"))
def test_the_figures_of_other_programs(name: str) -> None:
    entry = ENTRIES[name]
    cycle = only(system_of(entry), entry["system"]["modes"])
    assert (cycle.label, cycle.periods, cycle.multipliers().values.tolist()) == (
        entry["label"],
        entry["periods"],
        [0.0, 0.0],
    )
    assert cycle.release_phase == pytest.approx(float(entry["release_phase"]), rel=0, abs=1e-13)
    assert cycle.rest_phase == pytest.approx(float(entry["rest_begins"]), rel=0, abs=1e-12)
    known = entry["impacts"]
    few = slice(len(known))
    assert cycle.phases[few] == pytest.approx([float(one["phase"]) for one in known], rel=0, abs=1e-12)
    assert cycle.speeds[few] == pytest.approx([float(one["speed"]) for one in known], rel=0, abs=1e-12)
    assert float(cycle.rest_times[0]) == pytest.approx(TURN - float(entry["rest_begins_after_release"]), abs=1e-12)


@pytest.mark.parametrize("restitution", [0.0, 0.2, 0.5, 0.8])
def test_under_a_square_load_all_of_it_is_closed(restitution: float) -> None:
    """Pulled for b = (2 − κ)π the bar strikes b(1 + √2) after its release with √2 b, and rests after A b more."""
    whole = 1.0 + math.sqrt(2.0) + 2.0 * math.sqrt(2.0) * restitution / (1.0 - restitution)
    least = 2.0 * whole / (1.0 + whole)
    entry = ENTRIES["kappa_star"]["values"][f"{restitution:g}"]
    assert least == pytest.approx(float(entry), abs=1e-12)
    label = "rest/1" if restitution == 0.0 else "chatter/1"
    for kappa in (least + 1e-9, 0.5 * (least + 2.0)):
        cycle = only(System(s=5.0, d=0.0, restitution=restitution, load=Load.square(1.0, kappa)))
        pull = (2.0 - kappa) * math.pi
        assert cycle.label == label
        assert cycle.times[0] - cycle.chains[0].release == pytest.approx(pull * (2.0 + math.sqrt(2.0)), abs=1e-12)
        assert cycle.speeds[0] == pytest.approx(math.sqrt(2.0) * pull, abs=1e-12)
        assert float(cycle.rest_times[0]) == pytest.approx(TURN - pull - whole * pull, abs=1e-11)
    below = System(s=5.0, d=0.0, restitution=restitution, load=Load.square(1.0, least - 1e-9))
    assert label not in labels(below)


@pytest.mark.parametrize("mean", [0.35, 0.6, 0.9, 0.999])
def test_without_restitution_one_equation_tells_the_blow(mean: float) -> None:
    release = math.acos(-mean)

    def gap(t: float) -> float:
        since = t - release
        return mean * since**2 / 2.0 - math.cos(t) + math.cos(release) - math.sin(release) * since

    pushes = TURN - release
    blow = brentq(gap, pushes, release + 1.5 * TURN, xtol=1e-14)
    cycle = only(cosine(mean, 0.0))
    assert cycle.label == "rest/1" and cycle.speeds.size == 1
    assert cycle.release_phase == pytest.approx(release, rel=0, abs=1e-12)
    assert cycle.times[0] == pytest.approx(blow, rel=0, abs=1e-11)
    assert cycle.rest_phase == cycle.phases[0]


@pytest.mark.parametrize(
    ("restitution", "onset"),
    [(0.2, 0.457825216972), (0.3, 0.513626912256), (0.5, 0.626037331653), (0.7, 0.748522031949), (0.8, 0.817348052782)],
)
def test_chatter_begins_where_its_end_meets_the_next_release(restitution: float, onset: float) -> None:
    above, below = (rest_cycles(cosine(onset + by, restitution), modes=0, most=1) for by in (4e-11, -4e-11))
    assert ([cycle.label for cycle in above.orbits], below.orbits) == (["chatter/1"], ())


def test_a_load_that_never_pulls_lets_nothing_go() -> None:
    assert labels(cosine(0.999, 0.5)) == ["chatter/1"]
    for mean in (1.0, 1.2):
        found = rest_cycles(cosine(mean, 0.5), modes=0)
        assert (found.orbits, found.releases, found.leads_to) == ((), (), ())


def test_a_bar_that_is_never_laid_down_has_no_such_cycle() -> None:
    for system in (cosine(0.8, 1.0), cosine(0.3, 0.8), cosine(-0.2, 0.5)):
        found = rest_cycles(system, modes=0, most=8)
        assert found.orbits == () and set(found.leads_to) == {-1}


def test_bounces_followed_one_by_one_end_where_the_sum_says() -> None:
    """The first impacts of a chatter again, by nothing but the free fall between them (undamped, rigid)."""
    cycle = only(System(s=5.0, d=0.3, restitution=0.6, load=Load.fourier([0.8, 1.0, 0.2j])))
    flights = np.diff(cycle.times)
    assert np.all(flights > 0.0) and np.all(np.diff(flights[3:]) < 0.0)
    ratio = flights[-1] / flights[-2]
    assert ratio == pytest.approx(0.6, abs=1e-3)
    left = cycle.chains[0].rest - cycle.times[-1]
    assert left == pytest.approx(flights[-1] * ratio / (1.0 - ratio), rel=1e-3)


def test_several_releases_in_a_period() -> None:
    load = Load.fourier([0.6, 0.1, 1.0])  # pulls twice in a period, not quite alike
    found = rest_cycles(System(s=5.0, d=0.0, restitution=0.2, load=load), modes=0)
    assert len(found.releases) == 2 and found.leads_to == (0, 0)
    (cycle,) = found.orbits
    assert (cycle.label, cycle.release_phases.size) == ("chatter/1", 2)
    assert cycle.rest_times.min() > 0.0
    whole = cycle.rest_times.sum() + sum(chain.rest - chain.release for chain in cycle.chains)
    assert whole == pytest.approx(TURN, abs=1e-12)


def test_a_shift_of_the_load_shifts_the_cycle() -> None:
    for load in (Load.harmonic(0.8, 1.0), Load.steps([0.0, 2.0, 4.5], [1.2, 0.9, -0.9])):
        first = only(System(s=5.0, d=0.01, restitution=0.4, load=load), 6)
        second = only(System(s=5.0, d=0.01, restitution=0.4, load=load.shifted(1.3)), 6)
        assert first.label == second.label
        off = np.mod(second.rest_phase - first.rest_phase + 1.3 + math.pi, TURN) - math.pi
        other = np.mod(second.rest_phase - first.rest_phase - 1.3 + math.pi, TURN) - math.pi
        assert min(abs(off), abs(other)) < 1e-9
        assert first.speeds[:5] == pytest.approx(second.speeds[:5], rel=1e-9)


def test_steps_are_the_limit_of_their_own_splitting() -> None:
    whole = System(s=5.0, d=0.02, restitution=0.4, load=Load.steps([0.0, 4.5], [1.1, -0.9]))
    split = System(
        s=5.0, d=0.02, restitution=0.4, load=Load.steps([0.0, 1.0, 3.0, 4.5, 5.0], [1.1, 1.1, 1.1, -0.9, -0.9])
    )
    first, second = only(whole, 8), only(split, 8)
    assert first.label == second.label
    assert first.rest_phase == pytest.approx(second.rest_phase, rel=0, abs=1e-11)


def test_bad_input() -> None:
    with pytest.raises(ParameterError):
        rest_cycles("system")  # type: ignore[arg-type]
    for wrong in ({"modes": -1}, {"most": 0}, {"most": 257}):
        with pytest.raises(ParameterError):
            rest_cycles(cosine(0.8, 0.5), **wrong)
    with pytest.raises(ResonanceError):
        rest_cycles(System(s=1.0 / math.pi, d=0.0, restitution=0.5, load=Load.harmonic(0.8, 1.0)), modes=2)


def test_waves_turned_over() -> None:
    system = System(UniformBar(40.0), Load.harmonic(0.85, 1.0), Reversed(0.3))
    assert labels(system, 4)
