"""Cycles with rest: published figures, closed forms, and the bounces of a chatter one by one."""

from __future__ import annotations

import math
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.integrate import cumulative_trapezoid
from scipy.optimize import brentq
from scipy.special import i1e

from orbit_cases import ENTRIES, of_kind, system_of
from percuss import Kept, Load, System, rest_on_wall
from percuss.errors import ParameterError, ResonanceError
from percuss.model import External, KelvinVoigt, Reversed, SteppedBar, UniformBar
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


# -- Rest on the wall under a load of steps ----------------------------------------------------------------------------


SLOW_20 = pytest.param(20.0, marks=pytest.mark.slow)
PUSHES = Load.steps([0.0, math.pi], [1.0, 0.3])
THREE = Load.steps([0.3, 1.7, 4.0], [1.0, 0.2, 0.6])


def resting(load: Load, s: float, d: float) -> System:
    return System(s=s, d=d, restitution=0.3, load=load)


@cache
def answer_to_a_step(
    s: float, d: float, points: int = 40001
) -> tuple[float, NDArray[np.float64], NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """How the contact force answers a unit step until that has settled: end, fronts, their sizes, what is behind them.

    1/(p cosh √(p(p + d))/s) is a sum of delays 2(−1)^l exp(−T√(p(p + d)))/p, T = (2l + 1)/s. Each is a front exp(−dT/2)
    at t = T and behind it ∫_T^t (dT/2) exp(−du/2) I_1(d/2·√(u² − T²))/√(u² − T²) du.
    """
    until = 40.0 / min(0.5 * d, (0.5 * math.pi * s) ** 2 / d)
    t = np.linspace(0.0, until, points)
    fronts = (2.0 * np.arange(int(until * s / 2.0) + 1) + 1.0) / s
    fronts = fronts[fronts < until]
    sizes = 2.0 * (-1.0) ** np.arange(fronts.size) * np.exp(-0.5 * d * fronts)
    behind = np.zeros(points)
    for number, front in enumerate(fronts):
        u = t[t >= front]
        x = 0.5 * d * np.sqrt(np.maximum(u**2 - front**2, 0.0))
        shape = np.where(x > 1e-8, i1e(x) / np.where(x > 1e-8, x, 1.0), 0.5) * np.exp(x - 0.5 * d * u)
        begin = 0.5 * math.exp(-0.5 * d * front)  # what is ∝ t − T is taken exactly, the rest has no kink
        tail = cumulative_trapezoid(shape - begin, u, initial=0.0)
        behind[t >= front] += 0.5 * d**2 * front * (-1.0) ** number * tail
    return until, fronts, sizes, t, behind


def by_laplace(load: Load, s: float, d: float, times: NDArray[np.float64]) -> NDArray[np.float64]:
    """The periodic contact force: each jump of each past period has its answer, less what that has settled to."""
    until, fronts, sizes, t, behind = answer_to_a_step(s, d)
    slopes = 0.125 * d**2 * fronts * sizes
    met, up, from_ = (np.append(0.0, np.cumsum(x)) for x in (sizes, slopes, slopes * fronts))
    found = load.value(times).copy()
    for jump in load.jumps:
        for past in np.arange(0.0, until - TURN, TURN):
            since = np.mod(times - jump.phase, TURN) + past
            passed = np.searchsorted(fronts, since, side="right")
            answer = met[passed] + up[passed] * since - from_[passed] + np.interp(since, t, behind)
            found += (jump.after - jump.before) * (answer - 1.0)
    return np.asarray(found)


def marched(load: Load, s: float, d: float, columns: int = 200) -> float:
    """The least of f(t) = 2g p(t − τ) − g² f(t − 2τ) over the last period, marched on from f = p."""
    tau = 1.0 / s
    g = math.exp(-0.5 * d * tau)
    steps = math.ceil(32.0 / (d * tau))
    offsets = 2.0 * tau * (np.arange(columns) + 0.5) / columns
    f, least = load.value(offsets), math.inf
    for i in range(1, steps):
        t = offsets + 2.0 * tau * i
        f = 2.0 * g * load.value(np.mod(t - tau, TURN)) - g**2 * f
        if i > steps - TURN / (2.0 * tau):
            least = min(least, float(f.min()))
    return least


def test_the_verdict_does_not_know_how_many_harmonics_were_kept() -> None:
    """Each step of 0.7 is felt doubled, and echoes of many periods add up."""
    found = {rest_on_wall(resting(Load.steps([0.0, math.pi], [1.0, 0.3], k), 50.0, 0.02)) for k in (1, 8, 64, 1024)}
    assert len(found) == 1
    rest = found.pop()
    assert not rest.possible and rest.lifted_by_waves and rest.quasi_static == 0.3
    assert rest.least_contact_force == pytest.approx(-1.98983, abs=1e-5)
    stiff = rest_on_wall(resting(Load.steps([0.0, math.pi], [1.0, 0.02]), 1e5, 0.02))
    assert not stiff.possible and stiff.lifted_by_waves
    assert stiff.least_contact_force < 2 * 0.02 - 1.0  # one doubled step alone


@pytest.mark.parametrize(("s", "d"), [pytest.param(50.0, 0.05, marks=pytest.mark.slow), (7.3, 0.1), (20.0, 0.05)])
@pytest.mark.parametrize("load", [PUSHES, THREE])
def test_hardly_damped_the_recursion_marched_on_ends_there(load: Load, s: float, d: float) -> None:
    found = rest_on_wall(resting(load, s, d)).least_contact_force
    seen = marched(load, s, d)
    assert found - 1e-3 * d <= seen  # what damping bends is of the order d/s
    assert seen <= found + 0.05


@pytest.mark.parametrize(("s", "d"), [(2.3, 1.3), (5.0, 0.5), (0.7, 4.0), (1.3, 9.0), (0.2, 1.0)])
@pytest.mark.parametrize("load", [PUSHES, THREE])
def test_damped_it_is_what_laplace_transform_gives(load: Load, s: float, d: float) -> None:
    """The recursion alone would be wrong by a factor cosh(d/2s) under a constant load."""
    rest = rest_on_wall(resting(load, s, d))
    assert rest.phase is not None
    seen = by_laplace(load, s, d, np.linspace(0.0, TURN, 4001) + 1e-5)
    assert float(seen.min()) >= rest.least_contact_force - 1e-5
    near = by_laplace(load, s, d, rest.phase + np.array([-1e-7, 1e-7]))  # one of them on the right side of a front
    assert float(near.min()) == pytest.approx(rest.least_contact_force, abs=1e-5)


@pytest.mark.parametrize(("a", "b"), [(1, 1), (2, 1), (2, 3), (4, 5), (1, 3), (1, 4), (3, 8), (5, 7)])
def test_undamped_in_step_with_the_load(a: int, b: int) -> None:
    """Double transit 2τ = 2π a/b: f_i + f_{i−a} = 2p_i on b places of the circle, solved as it stands."""
    transit = math.pi * a / b
    rest = rest_on_wall(resting(THREE, 1.0 / transit, 0.0))
    matrix = np.eye(b) + np.roll(np.eye(b), a, axis=0)
    if abs(np.linalg.det(matrix)) < 1e-9:
        assert rest.least_contact_force == -math.inf and not rest.possible
        return
    seen = math.inf
    for start in TURN / b * (np.arange(400) + 0.37) / 400:
        pushed = 2.0 * THREE.value(start + TURN * np.arange(b) / b - transit)
        seen = min(seen, float(np.linalg.solve(matrix, pushed).min()))
    assert rest.least_contact_force == pytest.approx(seen, abs=2e-3)


def test_undamped_resonance_of_the_held_bar_beyond_the_kept_harmonics() -> None:
    for harmonics in (8, 64, 128):
        load = Load.steps([0.0, math.pi], [1.0, 0.3], harmonics)
        rest = rest_on_wall(resting(load, 2.0 * 65.0 / math.pi, 0.0))  # k = 65 meets the first mode
        assert rest.least_contact_force == -math.inf
        assert rest_on_wall(resting(load, 2.0 * 65.0 / math.pi, 0.5)).least_contact_force > -10.0
        # equal halves hold no even harmonic, so that k = 66 cannot meet it
        assert rest_on_wall(resting(load, 2.0 * 66.0 / math.pi, 0.0)).least_contact_force > -1000.0


@pytest.mark.parametrize("jump", [1e-6, 0.1, 0.7])
@pytest.mark.parametrize("d", [0.0, 1e-15, 1e-9, 1e-7, 1e-5, 6e-5])
@pytest.mark.parametrize("odd", [1, 3, 15])
def test_nothing_of_a_resonance_is_lost_where_hardly_anything_damps_it(odd: int, d: float, jump: float) -> None:
    """s = 2/(π·odd): 4τ is `odd` periods, and the echo series is (p(t − τ) − g²p(t − 3τ))·2g/(1 − g⁴)."""
    s = 2.0 / (math.pi * odd)
    rest = rest_on_wall(resting(Load.steps([0.0, math.pi], [1.0, 1.0 - jump]), s, d))
    if d == 0.0:
        assert rest.least_contact_force == -math.inf
        return
    g2 = math.exp(-d / s)
    low, high = 1.0 - jump, 1.0
    known = 2.0 * math.sqrt(g2) * (low - g2 * high) / -math.expm1(-2.0 * d / s)
    # s = 2/(π·odd) is rounded, which counts where damping is as small; the echoes know nothing of dispersion, which
    # turns the resonant harmonics by d/4 and so adds a quarter of a jump
    assert rest.least_contact_force == pytest.approx(known, rel=1e-6 if d > 1e-12 else 0.2, abs=0.3 * jump)
    assert rest.possible == (known >= 0.0)


@pytest.mark.parametrize("away", [1e-9, -1e-7, 1e-5])
@pytest.mark.parametrize("d", [0.0, 1e-13])
def test_beside_resonance_the_waves_grow_to_a_triangle(away: float, d: float) -> None:
    """Undamped, the odd harmonics k lie κ = k·away from theirs: Σ 2Δ/(πk)·s/(k|away|) over odd k is πΔs/(4|away|)."""
    s = 2.0 / math.pi * (1.0 + away)
    for jump in (1e-6, 0.1):
        load = Load.steps([0.0, math.pi], [1.0, 1.0 - jump])
        rest = rest_on_wall(resting(load, s, d))
        known = load.mean - 0.25 * math.pi * jump * s / abs(away)
        assert rest.least_contact_force == pytest.approx(known, rel=1e-3, abs=3.0 * jump)
        assert rest.possible == (known >= 0.0)


@pytest.mark.parametrize("s", [2.0 / math.pi * 1.0003, 2.0 / (3.0 * math.pi) * 0.9999, SLOW_20])
@pytest.mark.parametrize("load", [PUSHES, THREE])
def test_hardly_damped_it_is_the_sum_of_all_echoes(load: Load, s: float) -> None:
    """f(t) = 2g Σ(−g²)^l p(t − (2l + 1)τ), summed as it stands; told at most two jumps too low, not too high."""
    d = 4e-5
    rest = rest_on_wall(resting(load, s, d))
    assert rest.phase is not None
    delays = (2.0 * np.arange(math.ceil(12.0 * s / d)) + 1.0) / s
    weights = 2.0 * np.exp(-0.5 * d * delays)
    weights[1::2] *= -1.0
    beside = rest.phase + np.array([-1e-3, -1e-5, -1e-7, 1e-7, 1e-5, 1e-3]) / s
    seen = min(float(weights @ load.value(np.mod(t - delays, TURN))) for t in beside)
    assert rest.least_contact_force - 0.1 <= seen <= rest.least_contact_force + 2.0


@pytest.mark.parametrize("s", [1e5, 839242.8, 3e7])
def test_waves_nearer_than_phases_can_tell_still_count(s: float) -> None:
    rest = rest_on_wall(resting(Load.steps([0.0, 2.0], [1.0, 0.02]), s, 5e-5))
    assert not rest.possible and -30.0 < rest.least_contact_force < 2 * 0.02 - 0.99  # one doubled step at least


def test_loads_of_steps_and_of_harmonics_ring_alike_near_resonance() -> None:
    """What rings is the first harmonic: 2Δ/π of the square."""
    for s, d in ((2.0 / math.pi * 1.0001, 1e-9), (20.0 / math.pi * (1.0 + 1e-6), 1e-8)):
        steps = Load.steps([0.0, 2.0], [1.0, 0.9])
        waves = Load.steps([0.0, 2.0], [1.0, 0.9], 4000).coefficients
        seen = rest_on_wall(resting(Load.fourier(waves[:11]), s, d)).least_contact_force
        found = rest_on_wall(resting(steps, s, d)).least_contact_force
        assert found < 0.8 * seen < 0.0  # higher harmonics ring too, and make it more


@settings(max_examples=20)
@given(st.floats(0.3, 30.0), st.floats(0.02, 5.0), st.floats(-3.0, 3.0), st.floats(0.1, 10.0), st.floats(0.0, TURN))
def test_it_moves_and_scales_with_the_load(s: float, d: float, more: float, factor: float, turn: float) -> None:
    """A constant force is felt as it is, whatever the damping: f is linear in the load, and knows no phase."""
    first = rest_on_wall(resting(THREE, s, d)).least_contact_force
    load = THREE.with_mean(THREE.mean + more).scaled(factor)
    assert rest_on_wall(resting(load, s, d)).least_contact_force == pytest.approx(
        factor * (first + more), abs=2e-6 * factor
    )
    shifted = rest_on_wall(resting(THREE.shifted(turn), s, d)).least_contact_force
    assert shifted == pytest.approx(first, abs=1e-5)


def test_steps_that_do_not_step() -> None:
    flat = rest_on_wall(resting(Load.steps([0.0, 1.0], [0.4, 0.4]), 3.0, 0.1))
    assert flat.possible and flat.least_contact_force == 0.4 and not flat.lifted_by_waves
    gentle = rest_on_wall(resting(Load.steps([0.0, 1.0], [1.0, 0.9]), 3.0, 0.5))
    assert gentle.possible and 0.7 < gentle.least_contact_force < 0.9


def test_equal_sections_rest_as_a_uniform_bar_does() -> None:
    load, damping = Load.steps([0.0, 2.0, 4.5], [1.0, -0.4, 0.6]), External(0.05)
    whole = rest_on_wall(System(UniformBar(8.0, damping), load, Kept(0.5)))
    parts = rest_on_wall(System(SteppedBar(8.0, (2.0, 2.0), (1.0, 3.0), damping), load, Kept(0.5)))
    assert parts == whole


@pytest.mark.parametrize("s", [0.21, pytest.param(8.1, marks=pytest.mark.slow)])
def test_undamped_a_bar_rests_alike_whichever_law_it_is_named_by(s: float) -> None:
    load = Load.steps([0.0, 2.0, 4.5], [1.0, -0.4, 0.6])
    external, internal = (
        rest_on_wall(System(UniformBar(s, law), load, Kept(0.5))) for law in (External(0.0), KelvinVoigt(0.0))
    )
    assert external == internal
