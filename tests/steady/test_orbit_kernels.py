"""The compiled equations for orbits beside their plain form, over all systems that there are."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

import plain_orbits
from percuss import Load, System
from percuss.errors import ResonanceError
from percuss.model import Body, External, KelvinVoigt, Kept, Mounted, Ratio, Reversed, UniformBar
from percuss.model.checks import Array
from percuss.steady import PeriodicOrbit
from percuss.steady.flight import flight_check
from percuss.steady.periodic.impact_chain import ImpactChain
from percuss.steady.periodic.periodic_orbit import load_turn
from percuss.steady.periodic.search import Outcome, newton

DAMPINGS = (
    lambda size: External(size),
    lambda size: Ratio(min(size / 20.0, 1.0)),
    lambda size: KelvinVoigt(0.01 * size),
)
HAMMER = System(s=5.0, d=0.0048, restitution=0.5, load=Load.harmonic(0.62, 1.0))


@st.composite
def systems(draw: st.DrawFn) -> System:
    """Bars, free and held, loads of harmonics and of steps, dampings from none to overdamped, R from 0 to 1."""
    size = draw(st.just(0.0) | st.floats(1e-4, 30.0))
    body: Body = UniformBar(draw(st.floats(0.1, 30.0)), draw(st.sampled_from(DAMPINGS))(size))
    held = draw(st.booleans())
    if held:
        body = Mounted(
            draw(st.floats(0.1, 20.0)), size, draw(st.floats(0.1, 30.0)), body.damping, draw(st.floats(-1.0, 1.0))
        )
    mean, parts = draw(st.floats(0.05, 1.5)), st.floats(-1.0, 1.0)
    kind = draw(st.sampled_from(["one", "several", "steps"]))
    if kind == "one":
        load = Load.harmonic(mean, 1.0)
    elif kind == "several":
        pairs = draw(st.lists(st.tuples(parts, parts), min_size=2, max_size=6))
        load = Load.fourier([mean, 1.0, *(complex(*pair) for pair in pairs)])
    else:
        breaks = np.sort(np.array(draw(st.lists(st.floats(0.0, 6.28), min_size=2, max_size=5))))
        assume(np.all(np.diff(breaks) > 1e-3))
        values = draw(st.lists(st.floats(-1.0, 2.0), min_size=breaks.size, max_size=breaks.size, unique=True))
        load = Load.steps(breaks, values)
    restitution = draw(st.sampled_from([0.0, 1.0]) | st.floats(0.0, 1.0))
    return System(body, load, draw(st.sampled_from([Kept] if held else [Kept, Reversed]))(restitution))


@st.composite
def chains(draw: st.DrawFn) -> tuple[ImpactChain, Array]:
    """Impacts in load periods, of bars with few and many modes, and times in order."""
    p, n, system = draw(st.integers(1, 8)), draw(st.integers(1, 4)), draw(systems())
    chain = ImpactChain(
        system, p, n, draw(st.sampled_from([0, 1, 2, 7, 16, 64] if system.body.is_free else [1, 2, 7, 16]))
    )
    share = np.sort(np.array(draw(st.lists(st.floats(0.0, 1.0), min_size=p, max_size=p))))
    assume(p == 1 or (np.diff(share).min() > 1e-6 and np.ptp(share) < 1.0 - 1e-6))
    return chain, draw(st.floats(-10.0, 10.0)) + chain.period * share


def rounding(chain: ImpactChain) -> float:
    """Of what is a few numbers: that of the angle ω_N T where it is large."""
    fastest = float(chain.known.omega.max(initial=1.0))
    return 1e-12 + 32.0 * float(np.finfo(float).eps) * fastest * chain.period


@given(case=chains(), rebound=st.none() | st.floats(-5.0, 0.0), xi=st.sampled_from([1.0, -1.0]) | st.floats(-2.0, 2.0))
def test_compiled_equations_are_the_plain_ones(
    case: tuple[ImpactChain, Array], rebound: float | None, xi: float
) -> None:
    """K(ξ) also has its rational form; that it is the characteristic polynomial is tested with the multipliers."""
    chain, times = case
    if chain.is_neutral or not chain.system.body.is_free:
        rebound = 0.0
    try:
        made, plain = chain.passage(times, rebound), plain_orbits.passage(chain, times, rebound)
    except ResonanceError:
        assume(False)
    known, size = chain.known, 1.0 + max(float(np.abs(part).max(initial=0.0)) for part in plain.elastic[2:])
    least = float(np.abs(made.blocks.away(1.0)[2]).min(initial=1.0))
    if chain.system.load.is_piecewise and chain.modes:
        whole = np.expm1(np.pi * (-known.damping + 2j * np.sqrt(known.omega**2 - 0.25 * known.damping**2 + 0j)))
        least *= min(1.0, float(np.abs(whole).min()) ** 2)
    error = rounding(chain) * size / max(least, 1e-30)
    assume(error < 1e-7)
    wide = (1.0 + float(np.abs(plain.rigid).max()) + float(np.abs(plain.elastic[1]).sum(axis=-1).max(initial=0.0))) * (
        1.0 + chain.period
    ) ** 2
    for name in ("force", "rigid", "rebound", "speed", "gap", "closure"):
        assert getattr(made, name) == pytest.approx(getattr(plain, name), rel=0, abs=error * wide), name
    for one, other in zip(made.elastic, plain.elastic, strict=True):
        assert one == pytest.approx(other, rel=0, abs=error * wide)
    at_xi = float(np.abs(made.blocks.away(xi)[2]).min(initial=1.0))
    assume(at_xi > 1e-4)  # in K(ξ) a mode is divided by det(ξ − M_n)
    matrix = made.rational.matrices(np.array([xi]))[0]
    pull = float(np.abs(known.omega**2 * plain.elastic[0]).max(initial=0.0))
    scale = 10.0 * error * (1.0 + float(np.abs(matrix).max()) + pull) / min(1.0, at_xi)
    assert made.bordered(xi) == pytest.approx(matrix, rel=0, abs=scale * wide)


@pytest.mark.parametrize(("p", "n", "modes"), [(1, 1, 3), (2, 1, 0), (2, 1, 8), (3, 1, 0), (4, 1, 2)])
@pytest.mark.parametrize("known", [False, True])
def test_compiled_search_ends_where_the_plain_one_does(p: int, n: int, modes: int, known: bool) -> None:
    """Start by start: where a start ends may turn on rounding, so nearly all of them are compared."""
    chain = ImpactChain(HAMMER, p, n, modes)
    starts = np.sort(np.random.default_rng(p).uniform(0.0, chain.period, (40, p)), axis=1)
    roots = starts[:3] if known else None
    turn = load_turn(HAMMER.load)
    ended = newton(chain, starts, roots, turn)
    same, near, found = 0, 0, 0
    for row, start in enumerate(starts):
        times, rebound, outcome = plain_orbits.newton(chain, start, roots, turn)
        same += outcome == ended.outcome[row]
        if outcome == ended.outcome[row] == Outcome.ROOT:
            found += 1
            if np.abs(ended.times[row] - times).max() < 1e-9:
                near += 1
                assert ended.times[row] == pytest.approx(times, rel=0, abs=1e-11)
                assert ended.rebound[row] == pytest.approx(rebound, rel=0, abs=1e-11)
    assert same > 0.9 * len(starts)
    assert near > 0.9 * found > 0.0


@given(case=chains())
def test_many_starts_end_as_each_alone(case: tuple[ImpactChain, Array]) -> None:
    chain, times = case
    starts = np.stack([times, times + 0.1, times - 0.2])
    try:
        together = newton(chain, starts)
    except ResonanceError:
        assume(False)
    for row, start in enumerate(starts):
        alone = newton(chain, start[None])
        assert alone.outcome[0] == together.outcome[row]
        assert np.array_equal(alone.times[0], together.times[row], equal_nan=True)


@given(
    system=systems(),
    p=st.integers(1, 3),
    n=st.integers(1, 2),
    modes=st.sampled_from([1, 2, 7]),
    seed=st.integers(0, 99),
)
def test_samples_prove_what_bounds_prove(system: System, p: int, n: int, modes: int, seed: int) -> None:
    """The proof by samples never says what that by bounds denies; the greatest maximum is that of a scan."""
    chain = ImpactChain(system, p, n, modes)
    starts = np.sort(np.random.default_rng(seed).uniform(0.0, chain.period, (40, p)), axis=1)
    try:
        ended = newton(chain, starts)
    except ResonanceError:
        return
    for row in np.flatnonzero(ended.outcome == Outcome.ROOT)[:2].tolist():
        rebound = float(ended.rebound[row]) if chain.is_neutral else None
        check_samples(PeriodicOrbit(system, n, tuple(ended.times[row].tolist()), modes, rebound))


def check_samples(orbit: PeriodicOrbit) -> None:
    if orbit.resonant_modes:
        return
    seen = orbit.sampled
    if seen.proven:
        assert np.all(orbit.speeds > 0.0)
        assert all(flight_check(flight).violation is None for flight in orbit.flights)
    heights, size = [-np.inf], 1.0
    for flight in orbit.flights:
        fastest = max(1.0, float(orbit.system.load.harmonics[-1]), float(flight.state.omega.max()))
        number = max(8, int(max(96.0, 8.0 * fastest * flight.period / (2.0 * np.pi))))
        y, rate = flight.end_motion(flight.period / number * np.arange(number + 1), orbit.modes)
        size = max(size, float(np.abs(y).max()), float(np.abs(rate).max()))
        here = np.flatnonzero((rate[:-1] > 1e-6 * size) & (rate[1:] < -1e-6 * size))
        heights += np.maximum(y[here], y[here + 1]).tolist()
    if seen.height > -np.inf:
        flight = orbit.flights[seen.flight]
        place = flight.end_motion(np.array([seen.time + orbit.times[0] - flight.phase]), orbit.modes)[0]
        assert place[0] == pytest.approx(seen.height, rel=0, abs=1e-9 * size)
    if not orbit.system.load.is_piecewise:  # else the samples begin anew at each step
        assert seen.height >= max(heights) - 1e-9 * size
