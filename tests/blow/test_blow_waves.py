"""Waves at gauges, the state along the string and the greatest stresses, against brute force."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import rational_program
from blow_strategies import collisions, exact_collisions, section, struck
from collisions import Collision
from percuss.blow import Wall, strike
from percuss.model import SectionedBar

LOOKS = 300


def rod_transit(case: Collision) -> float:
    return float(sum(tau for _, tau in case.rod or () if tau is not None))


@settings(max_examples=40)
@given(case=exact_collisions().filter(lambda case: case.rod is not None), share=st.floats(0.02, 0.98))
def test_gauge_sees_the_waves_of_the_rational_program(case: Collision, share: float) -> None:
    """At a place in the first section of the rod."""
    exact, blow = rational_program.blow(case), struck(case)
    first, tau = exact.rod[0], case.rod[0][1]  # type: ignore[index]
    x = share * (float(tau) if tau is not None else 2.0)
    waves, z = blow.waves_at(x), float(case.rod[0][0])  # type: ignore[index]
    times = np.linspace(0.0, float(case.until), 203)[:-1] + 1e-4
    speed = float(max(map(abs, case.velocity))) * 10.0
    for trace, way, delay in (
        (waves.incident, first.right, x),
        (waves.reflected, first.left, None if tau is None else float(tau) - x),
    ):
        if delay is None:
            continue
        starts = np.array([float(start) for start, _ in way.entered])
        values = np.array([float(value) for _, value in way.entered])
        late = times - delay
        clear = np.abs(late[:, None] - starts).min(axis=1) > 1e-9  # no jump at this very time
        wanted = values[np.searchsorted(starts, late, side="right") - 1]
        found = trace.at(times) / z
        assert np.abs(np.abs(found[clear]) - np.abs(wanted[clear])).max() < 1e-11 * max(1.0, speed)


@settings(max_examples=40)
@given(case=collisions(transits=3.0))
def test_peaks_are_the_extremes_of_the_states(case: Collision) -> None:
    """No state exceeds them, and the state at the place and time of a peak reaches it."""
    blow = struck(case)
    bounds = np.concatenate([[0.0], np.cumsum([tau for _, tau in case.striker])])
    seen = np.zeros((len(case.striker), 2))
    largest = max(
        max(peak.compression, peak.tension) * z for peak, (z, _) in zip(blow.peaks, case.striker, strict=False)
    )
    for t in np.linspace(0.0, case.until, LOOKS + 1)[1:-1] + 1e-7:
        state = blow.state_at(float(t))
        for i in range(len(case.striker)):
            forces = forces_within(state, bounds[i], bounds[i + 1])
            seen[i] = np.maximum(seen[i], [forces.max(), -forces.min()])
    for i, (z, _) in enumerate(case.striker):
        compression, tension = blow.peaks[i].compression * z, blow.peaks[i].tension * z
        assert seen[i, 0] <= compression + 1e-9 * largest
        assert seen[i, 1] <= tension + 1e-9 * largest


def forces_within(state: Any, start: float, end: float) -> np.ndarray:
    """Forces of a state between two places of the striker."""
    x = start + (end - start) * (np.arange(64) + 0.5) / 64.0
    return np.asarray(state.force_at(x))


@settings(max_examples=20)
@given(case=exact_collisions(transits=4))
def test_state_is_the_one_of_the_rational_program(case: Collision) -> None:
    blow = struck(case)
    time = case.until * 5 / 7
    exact = rational_program.blow(replace(case, until=time))
    state, start = blow.state_at(float(time)), 0.0
    for part in exact.striker:
        tau = part.right.transit
        assert tau is not None
        forces = forces_within(state, start, start + float(tau))
        x = float(tau) * (np.arange(64) + 0.5) / 64.0
        wanted = float(part.impedance) * (
            entered(part.right, float(time) - x) - entered(part.left, float(time) - float(tau) + x)
        )
        assert np.mean(np.abs(forces - wanted) > 1e-9 * (1.0 + np.abs(wanted).max())) < 0.05  # at jumps either side
        start += float(tau)


def entered(way: Any, times: np.ndarray) -> np.ndarray:
    starts = np.array([float(start) for start, _ in way.entered])
    values = np.array([float(value) for _, value in way.entered])
    return np.asarray(values[np.searchsorted(starts, times, side="right") - 1])


def test_a_flight_without_contact_can_be_reversed() -> None:
    """A ringing bar, far from the wall: the state, its velocities turned round, comes back."""
    bar = SectionedBar([section(1.0, 1.0)])

    def ringing(x: Any) -> Any:
        return 1.0 + 0.3 * np.cos(np.pi * np.asarray(x)) - 0.2 * np.cos(2.0 * np.pi * np.asarray(x))

    def still(x: Any) -> Any:
        return 0.0 * np.asarray(x)

    time = 0.7
    first = strike(bar, Wall(gap=10.0), None, until=time, field=(ringing, still))
    state = first.state_at(time)
    back = strike(
        bar, Wall(gap=10.0), None, until=time,
        field=(lambda x: 2.0 - state.velocity_at(x), lambda x: state.force_at(x)),
    )  # fmt: skip
    x = np.linspace(0.02, 0.98, 49)
    end = back.state_at(time)
    assert end.velocity_at(x) == pytest.approx(2.0 - ringing(x), abs=1e-10)
    assert end.force_at(x) == pytest.approx(np.zeros(49), abs=1e-10)
