"""One list of reasons: a verdict's kind, its sentence, the word in a map's cell, and the obstacle of an orbit agree."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from percuss import Load, System, stability_of, steady_states
from percuss.explore import REASONS, sweep
from percuss.steady import Reason
from percuss.steady.multipliers import VERDICTS

SENTENCES = {
    Reason.STABLE: ("stable: ",),
    Reason.FOLD: ("unstable, beyond the fold", "fold: ", "one of a continuum", "two motions meet here"),
    Reason.FLIP: ("flip",),
    Reason.SPIRAL: ("unstable, a spiral",),
    Reason.ELASTIC: ("elastic mode ",),
    Reason.NEUTRAL: ("neutral: ",),
}


def test_the_numbers_in_archives_keep_their_words() -> None:
    assert REASONS == ("stable", "fold", "flip", "spiral", "elastic", "neutral")
    assert tuple(Reason(word) for word in REASONS) == VERDICTS
    assert len({reason.words for reason in Reason}) == len(Reason)


@settings(max_examples=30, deadline=None)
@given(
    s=st.floats(0.7, 30.0),
    d=st.sampled_from([0.0, 0.01, 0.3]),
    restitution=st.floats(0.0, 0.95),
    factor=st.floats(0.05, 1.5),
    periods=st.integers(1, 3),
    modes=st.sampled_from([0, 4, 12]),
)
def test_the_kind_is_what_the_largest_multiplier_does(
    s: float, d: float, restitution: float, factor: float, periods: int, modes: int
) -> None:
    system = System(s=s, d=d, restitution=restitution, load=Load.harmonic(factor, 1.0))
    for orbit in steady_states(system, periods).orbits:
        found = stability_of(orbit, modes=modes)
        largest = max(found.multipliers.values, key=abs)
        assert found.reason.startswith(SENTENCES[found.kind])
        assert (found.kind is Reason.STABLE) == found.stable
        if orbit.fold or found.stable:
            continue
        assert found.kind is Reason.NEUTRAL or abs(largest) > 1.0
        if found.kind is Reason.ELASTIC:
            assert max(found.reduced.moduli) < 1.0
        if found.kind in (Reason.FOLD, Reason.FLIP):
            assert abs(largest.imag) <= 1e-6 * abs(largest)
            assert (largest.real > 0.0) == (found.kind is Reason.FOLD)
        if found.kind is Reason.SPIRAL:
            assert abs(largest.imag) > 1e-6 * abs(largest)


@pytest.mark.parametrize("s", [0.9, 2.2, 7.0])
def test_a_map_gives_the_reason_of_the_verdict(s: float) -> None:
    """Soft bars too, in which an elastic mode has the greatest share in a flip that B77's criterion sees as well."""
    system = System(s=s, d=0.001, restitution=0.6, load=Load.harmonic(0.9, 1.0))
    axes = ("restitution=0.1:0.9:6", "load_factor=0.1:1.0:6")
    found = sweep(system, *axes, quantities=["reason", "margin"], modes=8, workers=1)
    seen = set()
    for (i, j), number in np.ndenumerate(found["reason"]):
        there = system.with_restitution(found.axes[0].values[i]).with_load_factor(found.axes[1].values[j])
        verdicts = [stability_of(orbit, modes=8) for orbit in steady_states(there, modes=8).orbits]
        if not verdicts:
            assert number == -1
            continue
        best = max(verdicts, key=lambda verdict: verdict.margin)
        assert REASONS[number] == best.kind.value
        seen.add(best.kind)
    assert len(seen) > 1


def test_an_orbit_that_is_not_physical_says_why() -> None:
    seen = set()
    for s in (0.25, 1.1, 20.0):
        for factor in (0.1, 0.25, 0.5, 0.9):
            system = System(s=s, d=0.01, restitution=0.21, load=Load.harmonic(factor, 1.0))
            for orbit in (*steady_states(system, 1).orbits, *steady_states(system, 2).orbits):
                seen.add(orbit.obstacle)
                assert orbit.admissible == (orbit.obstacle is None)
                assert (orbit.obstacle is Reason.NO_BLOW) == (orbit.impact_velocity <= 0.0)
                if orbit.obstacle is Reason.THROUGH_WALL:
                    assert orbit.motion(np.linspace(0.0, orbit.period, 4001)).max() > 0.0
    assert seen == {None, Reason.NO_BLOW, Reason.THROUGH_WALL}
