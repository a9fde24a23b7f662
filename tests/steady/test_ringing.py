"""Rhythm and ringing of an elastic machine: a mode that the load does not excite, perturbed eigenvalues, scales."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from percuss.model import Chamber, External, Kept, Machine, Port, Ratio, Reversed, SteppedBar, UniformBar, Valve
from percuss.steady import self_excited_motion
from percuss.steady.self_excited.valve_cycle import parted

PORTS = (Port("power", 1.0, "back", 0.1), Port("return", 0.1, "front", 0.05))


def at_the_node(s: float, d: float, R: float, kappa: float) -> Machine:
    """A machine whose load acts in the middle, where the first mode has its node."""
    body = SteppedBar(s, (1.0, 1.0), (1.0, 1.0), External(d))
    valve = Valve({"return": -0.6, "power": 1.4}, PORTS, chamber=Chamber(0.0, kappa))
    return Machine(body, valve, Reversed(R), at=1)


@given(st.floats(2.0, 60.0), st.floats(0.0, 0.3), st.floats(0.05, 0.7), st.sampled_from([0.0, 0.1, 0.3]))
@settings(max_examples=15)
def test_a_mode_that_is_not_excited_rings_by_itself(s: float, d: float, R: float, kappa: float) -> None:
    """Each blow multiplies it by −R, each flight turns and damps it; the rhythm is that of the rigid piston."""
    asked = at_the_node(s, d, R, kappa)
    cycle, rigid = (self_excited_motion(asked, modes=modes).cycle for modes in (1, 0))
    assert cycle.ringing.mode == 1
    turned = math.sqrt((math.pi * s) ** 2 - 0.25 * d**2) * cycle.period
    expected = -R * math.exp(-0.5 * d * cycle.period) * complex(math.cos(turned), abs(math.sin(turned)))
    assert cycle.ringing.multiplier == pytest.approx(expected.real + 1j * abs(expected.imag), rel=1e-8)
    assert cycle.ringing.shares[0].share == pytest.approx(1.0, abs=1e-6)
    assert cycle.ringing.decay == pytest.approx(-1.0 / math.log(abs(expected)), rel=1e-8)
    if abs(rigid.multiplier) > 1e-6:  # below it the rhythm is as good as found again at once
        assert cycle.rhythm_multiplier == pytest.approx(rigid.multiplier, rel=1e-8, abs=1e-10)
    assert rigid.ringing is None and rigid.rhythm_multiplier == rigid.multiplier


@pytest.mark.parametrize("law", [Kept, Reversed])
def test_rhythm_and_ringing_are_all_there_is(law: type) -> None:
    """The greatest multiplier is the greater of the two, and the rhythm of a stiff bar that of the rigid piston."""
    for s in (20.0, 200.0):
        asked = Machine(UniformBar(s, Ratio(0.1)), Valve({"return": -0.6, "power": 1.4}, PORTS), law(0.3))
        cycle, rigid = (self_excited_motion(asked, modes=modes).cycle for modes in (6, 0))
        told = [abs(cycle.rhythm_multiplier), *([abs(cycle.ringing.multiplier)] if cycle.ringing else [])]
        assert max(told) == pytest.approx(abs(cycle.multiplier), rel=1e-9)
        assert cycle.rhythm_multiplier == pytest.approx(rigid.multiplier, abs=2.0 / s)
        if cycle.ringing is not None:
            assert sum(one.share for one in cycle.ringing.shares) == pytest.approx(1.0)
            assert "Ringing: mode" in str(cycle.ringing)


def test_a_bar_that_rests_has_no_ringing() -> None:
    ports = (PORTS[0], Port("return", 0.1, "front", 1.5))
    asked = Machine(UniformBar(20.0, External(0.05)), Valve({"return": -0.3, "power": 1.0}, ports), Reversed(0.0))
    cycle = self_excited_motion(asked, modes=4).cycle
    assert cycle.rests and cycle.ringing is None and cycle.multiplier == 0.0


@pytest.mark.parametrize("pending", [0, 2])
def test_shares_are_what_a_mode_changes_a_multiplier_by(pending: int) -> None:
    """Pérez-Arriaga: the derivative of an eigenvalue by what is added to the diagonal; the units do not matter."""
    modes, size = 3, 8 + pending
    matrix = np.random.default_rng(7).normal(size=(size, size)) / 4.0
    matrix[:2, :2] += np.diag([2.0, 1.0])  # told apart
    rhythm, ringing = parted(matrix, modes)
    rows = np.eye(size)
    own = [[rows[2 * mode] + rows[2 * mode + 1]] for mode in range(modes + 1)]
    own[0] += list(rows[8:])
    parts = [sum(abs(_moved(matrix, one, ringing.multiplier, 1e-6)) for one in ones) for ones in own]
    expected = np.array(parts) / sum(parts)
    assert [expected[one.mode] for one in ringing.shares] == pytest.approx(
        [one.share for one in ringing.shares], abs=1e-6
    )
    assert np.abs(np.linalg.eigvals(matrix) - rhythm).min() < 1e-9
    scale = np.repeat(np.geomspace(1.0, 1e4, size // 2), 2)
    again = parted(matrix * scale[:, None] / scale, modes)
    assert again.ringing.multiplier == pytest.approx(ringing.multiplier)
    assert [one.share for one in again.ringing.shares] == pytest.approx([one.share for one in ringing.shares])


def _moved(matrix: np.ndarray, own: np.ndarray, value: complex, step: float) -> complex:
    ends = [np.linalg.eigvals(matrix + sign * step * np.diag(own)) for sign in (1.0, -1.0)]
    near = [values[np.argmin(np.abs(values - value))] for values in ends]
    return complex(near[0] - near[1]) / (2.0 * step)
