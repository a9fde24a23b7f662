"""Cycles of machines whose oil flows, drawn at random, against a plain Runge-Kutta method with its own events."""

import math

import pytest

from oil_cases import machine_of, random_system
from oil_oracle import Flow
from percuss.steady.oil.oil_cycle import settled_oil

CLOSE = 1e-9


def compare(seed: int, modes: int = 0, transit: float = 0.05) -> bool:
    """One cycle, from its rebound on, by both programs; whether there is one."""
    system = random_system(seed)
    machine = machine_of(system, 1.0 / transit)
    cycle = settled_oil(machine, modes).cycle
    if cycle is None or cycle.rests:
        return False
    rebound, start, period = cycle.rebound, cycle.flights[0].begin, cycle.period
    changes = [(one.time - period, one.to) for one in cycle.switches]  # those before the rebound
    other = Flow(
        system, start[:, 0].copy(), start[:, 1].copy(), 1.0 if rebound.pressure is None else rebound.pressure,
        rebound.state, rebound.orders.last, list(rebound.orders.pending), transit=transit, struck=True,
        before=changes[-2][1] if len(changes) > 1 else "",
        moving_since=changes[-1][0] if changes else -math.inf,
    )  # fmt: skip
    other.run(cycle.blows)
    speed = cycle.blow_speed
    times, speeds, pressures = zip(*other.blows, strict=True)
    assert times == pytest.approx(cycle.blow_times.tolist(), abs=CLOSE * period), seed
    assert speeds == pytest.approx(cycle.blow_speeds.tolist(), rel=CLOSE), seed
    assert [(to, pytest.approx(time, abs=CLOSE * period)) for time, to in other.changes] == [
        (one.to, one.time) for one in cycle.switches
    ], seed
    assert [time for time, _ in other.ports if time] == pytest.approx(
        [one.time for one in cycle.uncoverings if one.time], abs=CLOSE * period
    ), seed
    n = modes + 1  # it closes
    assert other.y[n : 2 * n] == pytest.approx(start[:, 1], abs=CLOSE * speed), seed
    if rebound.pressure is not None:
        assert pressures[-1] == pytest.approx(rebound.pressure, rel=CLOSE), seed
    oil, sums = cycle.oil, other.sums
    assert oil is not None
    found = {
        "input": oil.input, "rear": oil.orifices[0], "front": oil.orifices[1], "leakage": oil.leakage,
        "relief": oil.relief, "return_line": oil.return_line, "drag": oil.drag, "pumped": oil.pumped,
        "drawn": oil.drawn, "leaked": oil.leaked, "relieved": oil.relieved,
    }  # fmt: skip
    assert sums == pytest.approx(found, abs=CLOSE * oil.input), seed
    return True


def test_cycles_of_a_rigid_piston_are_those_of_another_program():
    assert sum(compare(seed) for seed in range(12)) >= 6


@pytest.mark.parametrize(("seed", "modes"), [(5, 1), (9, 4), (2, 4)])
def test_cycles_with_elastic_modes_are_those_of_another_program(seed, modes):
    assert compare(seed, modes, transit=0.6)


@pytest.mark.slow
@pytest.mark.parametrize("first", range(0, 280, 70))
def test_many_cycles_of_a_rigid_piston(first):
    assert sum(compare(1000 + first + i) for i in range(70)) >= 45


@pytest.mark.slow
@pytest.mark.parametrize(("modes", "machines", "transit"), [(1, 28, 1.0), (4, 16, 1.2), (16, 6, 1.6)])
def test_many_cycles_with_elastic_modes(modes, machines, transit):
    found = seed = 0
    while found < machines:
        seed += 1
        assert seed < 10 * machines
        found += compare(2000 + seed, modes, transit)
