"""The greatest force at every place: that of single instants, at most the exact one of the section, St Venant's."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import example, given, settings

from blow_strategies import collisions, exact_collisions, struck
from collisions import Collision
from percuss.blow import Rod, Wall, strike
from percuss.errors import ParameterError
from percuss.model import Bar, Section

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
