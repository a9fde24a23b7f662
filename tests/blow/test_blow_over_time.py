"""Blows as pictures in time: against the fields of single instants, the balances, and St Venant's collision."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from hypothesis import given, settings
from scipy.interpolate import BarycentricInterpolator

from blow_strategies import collisions, struck
from collisions import Collision
from percuss.blow import Wall, fields, strike
from percuss.blow.kernels.wave_records import MOST_DEGREE
from percuss.model import Bar
from percuss.model.checks import Array

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
