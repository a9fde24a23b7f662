"""The machine that a pump and an accumulator feed: known figures, a second program, limits, books that close."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from percuss.errors import ParameterError
from percuss.model import Chamber, External, Kept, Machine, Port, Supply, UniformBar, Valve
from percuss.steady import Obstacle, SelfExcited, pressure_over, self_excited_motion, slow_pressure, valve_margins
from percuss.steady.self_excited.settling import followed_to, under_pressure
from supply_oracle import after_cycle

MASS = 88.8


def breaker(flow: float, compliance: float, nitrogen: float = 1.0) -> Valve:
    """A hydraulic breaker per kilogram, in metres and seconds; l/min and m³ for each 100 bar."""
    ports = (Port("power", 0.13, "back", 0.005), Port("return", 0.004, "front", 0.0005))
    gas = Chamber(9000.0 * nitrogen / MASS, 20000.0 * nitrogen / MASS)
    supply = Supply.of_oil(flow / 6e4, compliance / 100e5, 160e5).scaled(1.0 / MASS, 1.0 / MASS)
    return Valve({"return": -13120.0 / MASS, "power": 12480.0 / MASS}, ports, chamber=gas, supply=supply)


def fed(valve: Valve, R: float = 0.15, drag: float = 0.5) -> SelfExcited:
    return self_excited_motion(Machine(UniformBar(20.0, External(drag)), valve, Kept(R)), modes=0)


@pytest.mark.parametrize(
    ("flow", "bar", "rate", "energy"), [(110, 133, 8.2, 3.0), (133, 160, 9.5, 3.8), (170, 250, 11.1, 6.5)]
)
def test_the_pressure_of_the_breaker_follows_the_flow(flow: float, bar: float, rate: float, energy: float) -> None:
    cycle = fed(breaker(flow, 1e-3)).cycle
    assert cycle.rebound.pressure * 160.0 == pytest.approx(bar, rel=0.01)
    assert 1.0 / cycle.period == pytest.approx(rate, abs=0.06)
    assert MASS * cycle.blow_energy / 1e3 == pytest.approx(energy, abs=0.06)


@pytest.mark.parametrize(("compliance", "nitrogen"), [(1e-3, 1.0), (5e-5, 1.0), (2.5e-4, 1.25)])
def test_cycle_and_multipliers_are_those_of_a_second_program(compliance: float, nitrogen: float) -> None:
    valve = breaker(133, compliance, nitrogen)
    cycle = fed(valve).cycle
    begins = cycle.rebound

    def after(numbers: np.ndarray) -> np.ndarray:
        return after_cycle(valve, 0.15, 0.5, numbers, begins.state, begins.orders)

    assert after(begins.numbers) == pytest.approx(begins.numbers, rel=1e-11)
    columns = []
    for i, step in enumerate(1e-5 * begins.numbers):
        aside = np.zeros(begins.numbers.size)
        aside[i] = step
        columns.append((after(begins.numbers + aside) - after(begins.numbers - aside)) / (2.0 * step))
    found = np.linalg.eigvals(np.array(columns).T)
    assert np.sort_complex(found) == pytest.approx(np.sort_complex(cycle.multipliers().values), abs=1e-6)


def test_a_great_accumulator_holds_the_pressure() -> None:
    """Limit: cycle and rhythm of the constant pressure, and the multiplier of the pressure by its formula."""
    valve = breaker(133, 1.0)
    cycle = fed(valve).cycle
    pressure = slow_pressure(cycle)
    constant = followed_to(under_pressure(cycle.machine, pressure.mean), cycle)
    assert cycle.blow_speed == pytest.approx(constant.blow_speed, rel=1e-4)
    assert cycle.period == pytest.approx(constant.period, rel=1e-4)
    assert pressure.ripple < 1e-4
    left = 1.0 - pressure.multiplier.real
    assert left == pytest.approx(1.0 - pressure.slow_multiplier, rel=1e-3)


def test_without_gas_and_delays_the_pressure_creeps_back_as_the_root_says() -> None:
    """T ~ P^(−1/2) and a constant volume: multiplier 1 − V/(2CP)."""
    ports = (Port("power", 1.0, "back"), Port("return", on="impact"))
    valve = Valve({"return": -0.4, "power": 1.8}, ports, supply=Supply(0.7, 1e4))
    pressure = slow_pressure(fed(valve, 0.2, 0.0).cycle)
    swept = 2.2  # the jump of the force times the distance of the port
    assert 1.0 - pressure.multiplier.real == pytest.approx(0.5 * swept / (1e4 * pressure.mean), rel=1e-3)
    assert pressure.slow_multiplier == pytest.approx(pressure.multiplier.real, rel=1e-6)


@given(
    st.floats(0.1, 1.0), st.floats(0.5, 3.0), st.floats(0.0, 0.6), st.floats(0.0, 0.3), st.floats(0.0, 0.1),
    st.floats(5.0, 50.0), st.floats(0.7, 2.0),
)  # fmt: skip
@settings(max_examples=12)
def test_energy_closes_and_volume_too(back, power, R, drag, kappa, compliance, flow) -> None:
    ports = (Port("power", 1.0, "back", 0.1), Port("return", on="impact"))
    valve = Valve({"return": -back, "power": power}, ports, None, Chamber(0.0, kappa), supply=Supply(flow, compliance))
    cycle = fed(valve, R, drag).cycle
    assume(cycle is not None and cycle.blows == 1 and not cycle.rests)
    x, weights = np.polynomial.legendre.leggauss(80)
    dragged = sum(
        0.5 * drag * one.duration * float(weights @ one.at(0.5 * one.duration * (x + 1.0))[1][0] ** 2)
        for one in cycle.flights
    )
    assert cycle.work == pytest.approx(cycle.taken + dragged, rel=1e-8)
    drawn = math.fsum(dict(valve.pairs)[one.state] * float((one.end - one.begin)[0, 0]) for one in cycle.flights)
    assert drawn == pytest.approx(flow * cycle.period, rel=1e-9)
    pressure = slow_pressure(cycle)
    assert 0.0 <= pressure.least <= pressure.at_blow + 1e-12 and pressure.at_blow <= pressure.greatest + 1e-12
    times = np.linspace(0.0, cycle.period, 400)
    seen = pressure_over(cycle, times)
    assert pressure.least - 1e-9 <= seen.min() and seen.max() <= pressure.greatest + 1e-9
    assert np.trapezoid(seen, times) / cycle.period == pytest.approx(pressure.mean, rel=2e-2)


def test_a_small_accumulator_is_emptied() -> None:
    assert fed(breaker(133, 1e-6)).obstacle is Obstacle.NO_PRESSURE


def test_a_stiff_gas_makes_the_pressure_swing() -> None:
    """The return hardly reaches its port: a low pressure makes a slow cycle, and the pressure overshoots."""
    motion = fed(breaker(60, 2.5e-4))
    assert motion.obstacle is Obstacle.HUNTS
    assert motion.cycle.multiplier.real < -1.0


def test_margins_of_the_supply_are_limits() -> None:
    valve = breaker(133, 2.5e-4)
    motion = fed(valve)
    margins = valve_margins(motion)
    assert margins.flow_to_run < 1.0 and margins.accumulator_to_run < 1.0
    machine, cycle = motion.machine, motion.cycle
    for name, limit in (("flow", margins.flow_to_run), ("compliance", margins.accumulator_to_run)):
        for factor in (0.9, 0.8, 0.7, 0.6, 0.5, 0.4, 0.3, 0.2, 0.1, 0.05):
            if factor < 0.98 * limit:
                break
            changed = replace(valve.supply, **{name: getattr(valve.supply, name) * max(factor, 1.001 * limit)})
            near = followed_to(machine.with_valve(replace(valve, supply=changed)), cycle)
            assert near is not None and near.stable
            cycle = near
        changed = replace(valve.supply, **{name: getattr(valve.supply, name) * 0.98 * limit})
        near = followed_to(machine.with_valve(replace(valve, supply=changed)), cycle)
        assert near is None or not near.stable
        cycle = motion.cycle


def test_much_more_oil_makes_a_pressure_as_its_square() -> None:
    """A disturbance of such a pressure hardly dies out, and it is one cycle all the same."""
    ports = (Port("power", 1.0, "back"), Port("return", on="impact"))
    means = []
    for flow in (100.0, 300.0):
        motion = fed(Valve({"return": -0.4, "power": 1.8}, ports, supply=Supply(flow, 30.0)))
        assert motion.runs and motion.cycle.blows == 1
        means.append(slow_pressure(motion.cycle).mean)
    assert means[0] > 1e4 and means[1] == pytest.approx(9.0 * means[0], rel=2e-2)


def test_a_constant_pressure_is_refused() -> None:
    machine = Machine(UniformBar(20.0), breaker(133, 1e-3), Kept(0.15))
    with pytest.raises(ParameterError, match="supply"):
        slow_pressure(self_excited_motion(machine.with_valve(replace(machine.valve, supply=None)), modes=0).cycle)
