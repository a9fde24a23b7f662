"""Blows as pictures in time: against the fields of single instants, the balances, and St Venant's collision."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings

from blow_strategies import collisions, struck
from collisions import Collision
from percuss.blow import Wall, strike
from percuss.blow.over_time import cells_over_time, energy_over_time
from percuss.model import Bar


@settings(max_examples=20)
@given(case=collisions())
def test_energy_is_where_the_balance_has_it_and_never_lost(case: Collision) -> None:
    blow = struck(case)
    times = np.linspace(0.0, blow.until, 23)
    found = energy_over_time(blow, times)
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
    for cells, body in zip(cells_over_time(blow, times, 17, 1.0), ("striker", "rod"), strict=True):
        for i, time in enumerate(times):
            along = getattr(blow.state_at(float(time)), body)
            assert (along is None) == (cells is None)
            if cells is None:
                continue
            middle = 0.5 * (cells.edges[:-1] + cells.edges[1:])
            for values, known in ((cells.force[i], along.force), (cells.velocity[i], along.velocity)):
                after = np.searchsorted(along.places, middle)
                inside = (after > 0) & (after < along.places.size)  # of an endless section: where waves have come
                jumps = np.append(along.places[1:][np.diff(along.places) < 1e-9], np.inf)
                inside &= np.min(abs(middle[:, None] - jumps), axis=1) > 1e-9  # where two meet there are four values
                about = after[inside] + np.arange(-2, 2)[:, None]
                sides = known[np.clip(about, 0, known.size - 1)]
                room = 1e-6 * (1.0 + float(abs(known).max(initial=0.0))) + 0.25 * np.ptp(sides, axis=0)  # curved
                assert np.all(values[inside] >= sides.min(axis=0) - room)
                assert np.all(values[inside] <= sides.max(axis=0) + room)
                assert np.all(values[after >= along.places.size] == 0.0)


def test_a_bar_on_a_wall_is_compressed_as_far_as_the_wave_has_come() -> None:
    """E v/c behind the front, nothing before it (St Venant 1867)."""
    bar = Bar(0.5, diameter=0.04)
    blow = strike(bar, Wall(), 8.0)
    transit, stress = bar.transit_time, bar.youngs_modulus * 8.0 * bar.transit_time / 0.5
    own, rod = cells_over_time(blow, np.array([0.25, 0.75, 1.5]) * transit, 8, 1.0)
    assert rod is None
    share = own.force / (bar.area * stress)
    wanted = [[0.0] * 6 + [1.0] * 2, [0.0] * 2 + [1.0] * 6, [0.0] * 4 + [1.0] * 4]  # last: its free end lets go
    assert share == pytest.approx(np.array(wanted), abs=1e-9)
    assert own.velocity[2] == pytest.approx(np.array([-8.0] * 4 + [0.0] * 4), abs=1e-9)
