"""The first region that is entered in a flight, some of whose edges move: against looking at many times."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from percuss.mechanics.crossing import Regions, first_entering
from percuss.mechanics.flow import ModalFlight
from percuss.model import MachineModes

SPAN = 6.0
numbers = st.floats(-2.0, 2.0)


@given(
    st.lists(st.tuples(st.floats(0.1, 9.0), st.floats(0.0, 1.0), numbers, numbers, numbers), min_size=1, max_size=3),
    st.lists(st.tuples(st.floats(0.2, 3.0), numbers), min_size=1, max_size=3),
    st.sampled_from([0.0, 1e-3, 1.0]), numbers,
)  # fmt: skip
@settings(max_examples=60)
def test_the_first_entering_is_the_first(coordinates, edges, stiffness, ramp) -> None:
    omega, damping, place, speed, row = np.array(coordinates).T
    omega[0] *= stiffness
    modes = MachineModes(omega, damping, np.ones(omega.size), np.ones(omega.size), np.eye(omega.size))
    flight = ModalFlight(modes=modes, begin=np.stack([place, speed], axis=1), force=0.3, duration=SPAN, ramp=ramp)
    above, drifts = np.array(edges).T
    rows = np.outer(np.linspace(1.0, 0.3, above.size), row)
    levels = rows @ place + above
    found = first_entering(flight, Regions(rows, levels, 1.0, drifts))
    times = np.linspace(0.0, SPAN, 4001)
    r = rows @ flight.at(times)[0] - levels[:, None] - drifts[:, None] * times
    inside = times[(r > 1e-9).any(axis=0)]
    assert found.proven
    assert found.time <= (inside[0] if inside.size else np.inf)
    if np.isfinite(found.time):
        at = rows @ flight.at(np.array([found.time]))[0][:, 0] - levels - drifts * found.time
        assert at[found.which] == pytest.approx(0.0, abs=1e-9)
        assert (r[:, times < found.time] < 1e-9).all()
