"""Waves at gauges, states, cells over time, the greatest forces: against brute force, each other, and St Venant."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scipy.interpolate import BarycentricInterpolator

import rational_program
from blow_strategies import collisions, exact_collisions, section, struck
from collisions import Collision
from percuss.blow import Rock, Rod, Trace, Wall, fields, strike
from percuss.blow.kernels.wave_records import MOST_DEGREE
from percuss.errors import ParameterError
from percuss.model import Bar, Section, SectionedBar
from percuss.model.checks import Array

# -- waves at gauges, the state along the string and the greatest stresses, against brute force


LOOKS = 50


def rod_transit(case: Collision) -> float:
    return float(sum(tau for _, tau in case.rod or () if tau is not None))


@settings(max_examples=25)
@given(case=exact_collisions().filter(lambda case: case.rod is not None), share=st.floats(0.02, 0.98))
def test_gauge_sees_the_waves_of_the_rational_program(case: Collision, share: float) -> None:
    """At a place in the first section of the rod."""
    exact, blow = rational_program.blow(case), struck(case)
    first, tau = exact.rod[0], case.rod[0][1]  # type: ignore[index]
    x = share * (float(tau) if tau is not None else 2.0)
    waves, z = blow.waves_at(x), float(case.rod[0][0])  # type: ignore[index]
    times = np.linspace(0.0, float(case.until), 203)[:-1] + 1e-4
    speed = float(max(map(abs, case.velocity))) * 10.0
    for trace, way, delay, sign in (
        (waves.incident, first.right, x, 1.0),
        (waves.reflected, first.left, None if tau is None else float(tau) - x, -1.0),
    ):
        if delay is None:
            continue
        late = times - delay
        starts = np.array([float(start) for start, _ in way.entered])
        clear = np.abs(late[:, None] - starts).min(axis=1) > 1e-9  # no jump at this very time
        wanted = entered(way, late)
        found = trace.at(times) / z
        assert found[clear] == pytest.approx(sign * wanted[clear], abs=1e-11 * max(1.0, speed))


@settings(max_examples=15)
@given(case=collisions(transits=3.0))
def test_peaks_are_the_extremes_of_the_states(case: Collision) -> None:
    """No state exceeds them, and the state at the place and time of a peak reaches it."""
    blow = struck(case)
    seen = np.zeros((len(case.striker), 2))
    largest = max(
        max(peak.compression, peak.tension) * z for peak, (z, _) in zip(blow.peaks, case.striker, strict=False)
    )
    for t in np.linspace(0.0, case.until, LOOKS + 1)[1:-1] + 1e-7:
        state = blow.state_at(float(t))
        for i in range(len(case.striker)):
            forces = forces_within(state, i)
            seen[i] = np.maximum(seen[i], [forces.max(), -forces.min()])
    for i, (z, _) in enumerate(case.striker):
        compression, tension = blow.peaks[i].compression * z, blow.peaks[i].tension * z
        assert seen[i, 0] <= compression + 1e-9 * largest
        assert seen[i, 1] <= tension + 1e-9 * largest


def forces_within(state: Any, number: int) -> np.ndarray:
    """Forces of a state in a section of the striker, both at each jump."""
    return np.asarray(state.striker.force[state.striker.section == number])


@settings(max_examples=20)
@given(case=exact_collisions(transits=4))
def test_state_is_the_one_of_the_rational_program(case: Collision) -> None:
    blow = struck(case)
    time = case.until * 5 / 7
    exact = rational_program.blow(replace(case, until=time))
    state, start = blow.state_at(float(time)).striker, 0.0
    for i, part in enumerate(exact.striker):
        tau = float(part.right.transit or 0)
        inside = state.section == i
        x, forces, speeds = state.places[inside] - start, state.force[inside], state.velocity[inside]
        assert x[0] == pytest.approx(0.0, abs=1e-12)
        assert x[-1] == pytest.approx(tau, rel=1e-12)
        middles = 0.5 * (x[:-1] + x[1:])
        wide = np.diff(x) > 1e-9
        f = entered(part.right, float(time) - middles[wide])
        g = entered(part.left, float(time) - tau + middles[wide])
        z, scale = float(part.impedance), 10.0 * float(max(map(abs, case.velocity)))
        for side in (slice(None, -1), slice(1, None)):
            assert forces[side][wide] == pytest.approx(z * (f - g), abs=1e-11 * z * scale)
            assert speeds[side][wide] == pytest.approx(f + g, abs=1e-11 * scale)
        start += tau


def entered(way: Any, times: np.ndarray) -> np.ndarray:
    starts = np.array([float(start) for start, _ in way.entered])
    values = np.array([float(value) for _, value in way.entered])
    return np.asarray(values[np.maximum(np.searchsorted(starts, times, side="right") - 1, 0)])


def ringing(x: np.ndarray, t: float) -> tuple[np.ndarray, np.ndarray]:
    """Velocity and force of a free uniform bar of unit impedance, length and wave speed, in two of its modes."""
    one, two = np.pi * x, 2.0 * np.pi * x
    velocity = 1.0 + 0.3 * np.cos(one) * np.cos(np.pi * t) - 0.2 * np.cos(two) * np.cos(2.0 * np.pi * t)
    return velocity, 0.3 * np.sin(one) * np.sin(np.pi * t) - 0.2 * np.sin(two) * np.sin(2.0 * np.pi * t)


@pytest.mark.parametrize("time", [0.3, 0.7, 1.0, 5.1])
def test_a_flight_without_contact_is_that_of_the_modes_and_can_be_reversed(time: float) -> None:
    """The state with its velocities turned round, in a frame that moves along, comes back to the start."""
    bar, wall = SectionedBar([section(1.0, 1.0)]), Wall(gap=10.0)
    ahead = strike(bar, wall, None, until=time, field=(lambda x: ringing(x, 0.0)[0], lambda x: ringing(x, 0.0)[1]))
    state = ahead.state_at(time).striker
    for found, wanted in zip((state.velocity, state.force), ringing(state.places, time), strict=True):
        assert found == pytest.approx(wanted, abs=2e-9)
    back = strike(
        bar, wall, None, until=time, field=(lambda x: 2.0 - ringing(x, time)[0], lambda x: ringing(x, time)[1])
    )
    state = back.state_at(time).striker
    assert state.velocity == pytest.approx(2.0 - ringing(state.places, 0.0)[0], abs=2e-9)
    assert state.force == pytest.approx(np.zeros(state.places.size), abs=2e-9)


@settings(max_examples=30)
@given(case=exact_collisions().filter(lambda case: case.rod is not None), share=st.floats(0.02, 0.98))
def test_energy_that_passes_a_gauge_is_that_of_its_waves(case: Collision, share: float) -> None:
    """Z ∫ f² − Z ∫ g² through the struck face is the work of the face; tool energy is ∫ F²/Z."""
    blow = struck(case)
    at_face = blow.waves_at(0.0)
    passed = at_face.incident_energy - at_face.reflected_energy
    scale = float(case.mass * max(map(abs, case.velocity)) ** 2)
    assert passed == pytest.approx(blow.work_through_face, abs=1e-11 * max(1.0, scale) * 10.0)
    tau = case.rod[0][1]  # type: ignore[index]
    waves = blow.waves_at(share * (float(tau) if tau is not None else 2.0))
    times = np.unique(np.concatenate([waves.incident.times, waves.reflected.times]))
    middles = 0.5 * (times[:-1] + times[1:])
    force = waves.incident.at(middles) + waves.reflected.at(middles)
    total = float(np.sum(force**2 * np.diff(times))) / waves.impedance
    assert waves.tool_energy == pytest.approx(total, rel=1e-10, abs=1e-14)


# -- traces against plain polynomials, and the greatest force of a long blow against its states


SERIES = np.polynomial.Chebyshev
NODES, WEIGHTS = np.polynomial.legendre.leggauss(12)


@st.composite
def traces(draw: st.DrawFn) -> Trace:
    """Pieces of different lengths and degrees, some of them constant or 0."""
    size, width = draw(st.integers(1, 6)), draw(st.integers(1, 7))
    lengths = draw(st.lists(st.floats(0.1, 2.0), min_size=size, max_size=size))
    rows = [draw(st.lists(st.floats(-1.0, 1.0), min_size=1, max_size=width)) for _ in range(size)]
    coefficients = np.array([row + [0.0] * (width - len(row)) for row in rows])
    return Trace(np.cumsum([0.0, *lengths]), coefficients)


def series(trace: Trace) -> list[np.polynomial.Chebyshev]:
    ends = zip(trace.times[:-1], trace.times[1:], strict=True)
    return [SERIES(row, domain=pair) for row, pair in zip(trace.coefficients, ends, strict=True)]


@given(traces(), traces())
def test_integrals_of_products_are_those_of_polynomials(one: Trace, other: Trace) -> None:
    expected = 0.0
    for p in series(one):
        for q in series(other):
            low, high = max(p.domain[0], q.domain[0]), min(p.domain[1], q.domain[1])
            if high > low:
                t = 0.5 * (low + high) + 0.5 * (high - low) * NODES
                expected += 0.5 * float((high - low) * (p(t) * q(t) @ WEIGHTS))
    assert one.product_integral(other) == pytest.approx(expected, rel=1e-11, abs=1e-11)


@given(traces())
def test_the_integral_of_a_square_is_that_of_the_product_with_a_copy(trace: Trace) -> None:
    copy = Trace(trace.times, trace.coefficients)
    assert trace.product_integral(trace) == pytest.approx(trace.product_integral(copy), rel=1e-12, abs=1e-300)


@given(traces())
def test_no_value_of_a_piece_exceeds_its_peak_and_one_reaches_it(trace: Trace) -> None:
    x = np.cos(np.linspace(0.0, np.pi, 2001))
    for row, peak in zip(trace.coefficients, trace.piece_peaks, strict=True):
        greatest = np.polynomial.chebyshev.chebval(x, row).max()
        assert greatest - 1e-13 <= peak <= greatest + 1e-4


@settings(max_examples=5)
@given(st.floats(0.5, 3.0), st.floats(5.0, 9.0))
def test_no_state_of_a_long_blow_exceeds_its_peaks(bit: float, transits: float) -> None:
    """Thousands of bent pieces, in blocks: what is passed over must not matter."""
    sizes = ((0.0731, 0.04), (0.2187, 0.05), (0.1493, 0.03478))
    striker = SectionedBar([Section(length, diameter=d) for length, d in sizes])
    rod = Rod(
        [Section(0.4, diameter=0.045), Section(1.1, diameter=0.038)],
        "rock",
        bit_mass=bit,
        rock=Rock(4e8, unloading_ratio=0.3),
    )
    blow = strike(striker, rod, 10.0, until=transits * striker.transit_time)
    for i, peak in enumerate(blow.peaks[:3]):
        area = 0.25 * np.pi * sizes[i][1] ** 2
        both = (1.0, peak.compression, peak.compression_time), (-1.0, peak.tension, peak.tension_time)
        for sign, value, when in both:
            assert when is not None
            found = []
            for time in np.append(np.linspace(0.0, blow.until, 60), when):
                state = blow.state_at(float(time)).striker
                found.append(float((sign * state.force[state.section == i]).max()) / area)
            assert max(found) <= value * (1.0 + 1e-9)
            assert found[-1] >= value * (1.0 - 1e-3)


# -- blows as pictures in time: against the fields of single instants, the balances, and St Venant's collision


ENOUGH = 0.5 - 0.5 * np.cos(np.linspace(0.0, np.pi, MOST_DEGREE + 9))
"""Places in a piece of a wave, of which its polynomial is known everywhere."""


@settings(max_examples=20)
@given(case=collisions())
def test_energy_is_where_the_balance_has_it_and_never_lost(case: Collision) -> None:
    blow = struck(case)
    times = np.linspace(0.0, blow.until, 23)
    found = blow.energy_over_time(times)
    whole = found.rigid + found.vibration + found.rod + found.rock_dissipated + found.rock_stored
    scale = max(blow.energy_before, abs(blow.load_work), float(whole.max()))
    at_end = (
        (found.rigid, blow.rigid_energy_after),
        (found.vibration, blow.vibration_energy_after),
        (found.rod, blow.rod_energy + blow.bit_kinetic_energy_after),
        (found.rock_dissipated, blow.rock_dissipated),
        (found.rock_stored, blow.rock_stored),
    )
    for part, known in at_end:
        assert part[-1] == pytest.approx(known, abs=1e-10 * scale)
    assert whole[-1] - whole[0] == pytest.approx(blow.load_work, abs=1e-9 * scale)
    if not case.load:
        assert whole == pytest.approx(np.full(times.size, whole[0]), abs=1e-9 * scale)
    assert np.all(np.diff(found.rock_dissipated) >= -1e-12 * scale)


@settings(max_examples=20)
@given(case=collisions())
def test_cells_have_what_the_field_of_an_instant_has_there(case: Collision) -> None:
    blow = struck(case)
    times = np.linspace(0.0, blow.until, 5)[1:4]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(fields, "_POINTS", ENOUGH)
        states = [blow.state_at(float(time)) for time in times]
    for cells, body in zip(blow.cells_over_time(times, 17, 1.0), ("striker", "rod"), strict=True):
        for i, state in enumerate(states):
            along = getattr(state, body)
            assert (along is None) == (cells is None)
            if cells is None:
                continue
            middle = 0.5 * (cells.edges[:-1] + cells.edges[1:])
            for values, known in ((cells.force[i], along.force), (cells.velocity[i], along.velocity)):
                size = 1.0 + float(abs(known).max(initial=0.0))
                inside = np.zeros(middle.size, dtype=bool)
                for places, row in pieces(along.places, along.section, known):
                    edge = 1e-9 * (1.0 + places[-1])  # where two pieces meet there may be a jump
                    here = (middle > places[0] + edge) & (middle < places[-1] - edge)
                    assert values[here] == pytest.approx(polynomial(places, row)(middle[here]), abs=1e-6 * size)
                    inside |= here
                beyond = middle > (along.places[-1] if along.places.size else 0.0)  # where no wave has come yet
                assert np.all(values[beyond] == 0.0)
                assert np.count_nonzero(inside | beyond) >= 0.7 * middle.size


def pieces(places: Array, section: Array, values: Array) -> Iterator[tuple[Array, Array]]:
    """The places and values of each piece, which both its ends belong to."""
    for number in np.unique(section):
        here = section == number
        x, y = places[here], values[here]
        first = np.flatnonzero(np.diff(x) == 0.0)
        size = int(first[0]) + 1 if first.size else x.size
        yield from zip(x.reshape(-1, size), y.reshape(-1, size), strict=True)


def polynomial(places: Array, values: Array) -> BarycentricInterpolator:
    """Through a piece, which is one; its ends count only where there are no others: they may be beyond a jump there."""
    inner = slice(1, -1) if places.size > 2 else slice(None)
    return BarycentricInterpolator(places[inner], values[inner])


def test_a_bar_on_a_wall_is_compressed_as_far_as_the_wave_has_come() -> None:
    """E v/c behind the front, nothing before it (St Venant 1867)."""
    bar = Bar(0.5, diameter=0.04)
    blow = strike(bar, Wall(), 8.0)
    transit, stress = bar.transit_time, bar.youngs_modulus * 8.0 * bar.transit_time / 0.5
    own, rod = blow.cells_over_time(np.array([0.25, 0.75, 1.5]) * transit, 8, 1.0)
    assert rod is None
    share = own.force / (bar.area * stress)
    wanted = [[0.0] * 6 + [1.0] * 2, [0.0] * 2 + [1.0] * 6, [0.0] * 4 + [1.0] * 4]  # last: its free end lets go
    assert share == pytest.approx(np.array(wanted), abs=1e-9)
    assert own.velocity[2] == pytest.approx(np.array([-8.0] * 4 + [0.0] * 4), abs=1e-9)


# -- the greatest force at every place: that of single instants, at most the exact one of the section, St Venant's


CELLS = 24
TWO_PEAKS = Collision(
    striker=((1.1547819846894583, 1.0), (7.498942093324558, 1.0)), velocity=(1.0, 1.0), until=8.0,
    rod=((10.0, 1.0), (8.659643233600654, 1.0)), end="free", bit_mass=10.0, joint_masses=((1, 10.0),),
)  # fmt: skip
"""In the last section the greatest force is where a wave has a maximum that is not its greatest within the piece."""
GOLDEN = 0.3819660112501051
"""No instant that is a golden part of a step is one at which breaks of waves in whole numbers meet."""


@settings(max_examples=20)
@given(case=collisions())
@example(case=TWO_PEAKS)
def test_no_place_has_more_than_its_section(case: Collision) -> None:
    blow = struck(case)
    own, speed = len(case.striker), (2.0 * blow.energy_before / blow.striker_mass) ** 0.5
    known = (blow.peaks[:own], case.striker), (blow.peaks[own:], case.rod or ())
    for body, (peaks, chain) in zip(blow.force_envelope(CELLS, 2.0), known, strict=True):
        if body is None:
            assert not chain
            continue
        area = np.array([float(z) for z, _ in chain])  # stresses are forces over impedances, E = ρ = 1
        for name in ("compression", "tension"):
            most = (np.array([getattr(peak, name) for peak in peaks]) * area)[body.section]
            values = getattr(body, name)
            rounding = 1e-9 * float(most.max(initial=0.0)) + 1e-13 * speed * float(area.max())
            assert (values >= 0.0).all() and (values <= most + rounding).all()


@settings(max_examples=20)
@given(case=exact_collisions())
def test_stepwise_waves_are_never_missed(case: Collision) -> None:
    """What cells show at instants between all breaks is within what they show at most."""
    blow = struck(case)
    times = blow.until * (np.arange(60) + GOLDEN) / 60.0
    envelopes, shown = blow.force_envelope(CELLS, 2.0), blow.cells_over_time(times, CELLS, 2.0)
    for most, cells in zip(envelopes, shown, strict=True):
        if most is None or cells is None:
            assert most is cells is None
            continue
        np.testing.assert_allclose(most.edges, cells.edges)
        scale = max(float(abs(cells.force).max()), 1e-300)
        assert (cells.force.max(axis=0) <= most.compression + 1e-9 * scale).all()
        assert ((-cells.force).max(axis=0) <= most.tension + 1e-9 * scale).all()


def test_a_bar_on_a_wall_is_pressed_everywhere_alike() -> None:
    bar = Bar(0.5, area=1e-3)
    own, rod = strike(bar, Wall(), 10.0).force_envelope(50, 1.0)
    force = 10.0 * 1e-3 * (bar.youngs_modulus * bar.density) ** 0.5
    np.testing.assert_allclose(own.compression, force, rtol=1e-12)
    assert rod is None and not own.tension.any()


def test_a_pulse_comes_back_from_a_free_end_as_tension() -> None:
    """Its whole force at every place that it has passed alone, 2τ long."""
    bar, length = Bar(0.2, area=1e-3), 2.0
    speed = bar.wave_speed
    until = 1.6 * length / speed
    blow = strike(bar, Rod([Section(length, area=1e-3)], "free"), 10.0, until=until)
    _, rod = blow.force_envelope(80, 1.0)
    assert rod is not None
    force = 0.5 * 10.0 * 1e-3 * (bar.youngs_modulus * bar.density) ** 0.5
    x = 0.5 * (rod.edges[1:] + rod.edges[:-1])
    back, passed = (2.0 * length - x) / speed, (x + 2.0 * bar.length) / speed
    alone = np.maximum(back, passed) < until
    np.testing.assert_allclose(rod.compression, force, rtol=1e-12)
    np.testing.assert_allclose(rod.tension[alone], force, rtol=1e-12)
    assert alone.sum() > 40 and not rod.tension[back > until].any()


def test_nonsense_is_refused() -> None:
    blow = strike(Bar(0.5, area=1e-3), Wall(), 10.0)
    for cells, reach in ((0, 1.0), (10, 0.0), (10, float("nan"))):
        with pytest.raises(ParameterError):
            blow.force_envelope(cells, reach)
