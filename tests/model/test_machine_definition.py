"""The machine that switches its own valve: its modes against an eigenvalue problem of their own, its scales."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import brentq

from percuss.errors import Interrupted
from percuss.halting import halting, interruptible
from percuss.model import Bar, Chamber, External, Kept, Machine, Port, Ratio, Reversed, SteppedBar, UniformBar, Valve

PORTS = (Port("power", behind=0.13, side="back", delay=5e-3), Port("return", behind=0.004, side="front", delay=5e-4))


def valve(stiffness: float = 0.0) -> Valve:
    return Valve({"return": -0.4, "power": 1.8}, PORTS, chamber=Chamber(0.1, stiffness))


@given(s=st.floats(0.5, 100.0), stiffness=st.floats(1e-6, 1e3), modes=st.integers(0, 40), reads=st.floats(0.0, 1.0))
def test_modes_solve_the_equations_of_the_bars_own_coordinates(
    s: float, stiffness: float, modes: int, reads: float
) -> None:
    """r'' + ω² r + κ e eᵀ r = e p in the own coordinates r = V m."""
    body = UniformBar(s, External(0.01))
    machine = Machine(body, valve(stiffness), Kept(0.2))
    found, n = machine.modes(modes), np.arange(modes + 1)
    root = np.where(n == 0, 1.0, np.sqrt(2.0))
    driven = root * np.where(n % 2, -1.0, 1.0)  # where the striking end moves the same way in every mode
    stiff = np.diag((n * np.pi * s) ** 2) + stiffness * np.outer(driven, driven)
    assert found.mixing @ np.diag(found.omega**2) @ found.mixing.T == pytest.approx(stiff, abs=1e-12 * stiff.max())
    assert found.mixing @ found.mixing.T == pytest.approx(np.eye(modes + 1), abs=1e-12)
    assert found.mixing @ found.driven == pytest.approx(driven, abs=1e-11)
    assert found.mixing @ found.end == pytest.approx(root, abs=1e-11)
    assert found.mixing @ found.centre == pytest.approx(np.eye(modes + 1)[0], abs=1e-12)
    assert np.all(found.damping == 0.01)
    shapes = found.at(body, np.array([0.0, reads, 1.0]))
    wave = driven * np.cos(n * np.pi * reads)
    assert shapes == pytest.approx(np.array([driven, wave, root]) @ found.mixing, abs=1e-9)


def test_modes_come_to_the_bar_on_a_spring() -> None:
    """θ tan θ = κ/s² of the continuous bar, θ = ω/s."""
    s, stiffness = 2.0, 3.0
    found = Machine(UniformBar(s), valve(stiffness), Kept(0.2)).modes(400)
    for i in range(3):
        low, high = i * np.pi + 1e-9, (i + 0.5) * np.pi - 1e-9
        theta = brentq(lambda t: t * np.tan(t) - stiffness / s**2, low, high, xtol=1e-15)
        assert found.omega[i] == pytest.approx(s * theta, rel=1e-3)


@pytest.mark.parametrize("body", [UniformBar(20.0, Ratio(1e-3)), SteppedBar(20.0, (1.0, 3.0), (0.4, 0.6))])
def test_without_a_chamber_they_are_the_bodys_own(body: UniformBar | SteppedBar) -> None:
    found, own = Machine(body, valve(), Kept(0.2)).modes(5), body.modes(5)
    assert found.omega[0] == found.damping[0] == 0.0
    assert np.array_equal(found.omega[1:], own.omega) and np.array_equal(found.damping[1:], own.damping)
    assert found.end[1:] * found.driven[1:] == pytest.approx(own.gamma, rel=1e-14)
    assert np.array_equal(found.mixing, np.eye(6))


def test_one_free_motion_less_stiff_goes_over_into_the_rigid_one() -> None:
    soft = Machine(UniformBar(20.0), valve(1e-9), Kept(0.2)).modes(4)
    free = Machine(UniformBar(20.0), valve(), Kept(0.2)).modes(4)
    assert soft.omega == pytest.approx(free.omega, abs=1e-4) and soft.end == pytest.approx(free.end, abs=1e-9)


def test_si_numbers_are_those_of_one_kilogram_and_one_second() -> None:
    oil = Valve({"return": -13120.0, "power": 12480.0}, PORTS, chamber=Chamber(9000.0, 20000.0))
    bar = Bar(length=1.25, diameter=0.12)
    machine = Machine.from_si(bar, oil, Reversed(0.15), pressure=160e5)
    assert machine.valve.force("power") * machine.force_scale == pytest.approx(21480.0)
    assert machine.valve.ports[0].behind == pytest.approx(0.13 / 1.25)
    assert machine.valve.ports[0].delay == 5e-3
    gas = machine.valve.chamber.stiffness * machine.force_scale / machine.length_scale
    assert gas == pytest.approx(20000.0)
    assert machine.body.s == pytest.approx(np.sqrt(2.1e11 / 7850.0) / 1.25)
    assert machine.energy_scale == pytest.approx(bar.mass * 1.25**2)
    assert "power" in str(machine)


def test_many_modes_on_gas_are_given_up_at_once():
    """Their matrix is one long call into LAPACK; one mode fewer or more than what is waited for by itself agree."""
    chamber = Chamber(0.1, 2.0)
    ports = [Port("power", behind=1.0, side="back"), Port("return", on="impact")]
    machine = Machine(UniformBar(20.0), Valve({"return": -0.4, "power": 1.8}, ports, chamber=chamber), Kept(0.2))
    few, many = machine.modes(299), machine.modes(300)
    assert few.omega[:100] == pytest.approx(many.omega[:100], rel=1e-6)
    with pytest.raises(Interrupted), halting(lambda: True):
        machine.modes(1500)
    with pytest.raises(ZeroDivisionError):
        interruptible(lambda: 1 // 0)
    assert interruptible(lambda: 5) == 5
