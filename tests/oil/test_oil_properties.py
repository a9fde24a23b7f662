"""What holds for every machine whose oil flows: its energy closes, units do not matter, limits and closed forms."""

from copy import deepcopy
from dataclasses import replace

import numpy as np
import pytest

from oil_cases import machine_of, named, random_system
from percuss.explore.lyapunov import lyapunov_exponent
from percuss.steady.oil.oil_cycle import OilUnknowns, settled_oil, slow_oil
from percuss.steady.oil.oil_figures import closed_form, oil_checks
from percuss.steady.self_excited.self_switching import self_excited_motion


def cycle_of(machine, near=None):
    return settled_oil(machine, 0, near).cycle


def constant(system, **more):
    """The same under a constant pressure."""
    return {**deepcopy(system), "supply": {"pressure": 1.0, "leak": 0.0}, **more}


def fed(seed, **more):
    """A machine at random with a pump and a linear accumulator, without relief and limits."""
    system = random_system(seed)
    system["supply"] = {
        "pump": {"flow": 0.55}, "accumulator": {"compliance": 4.0}, "line": 0.0, "start": 1.0, "leak": 0.02
    }  # fmt: skip
    return {**system, **more}


def lossless(system, part=0.0):
    """With all passages a part of what they are."""
    system = deepcopy(system)
    for state in system["states"].values():
        for join in state.values():
            join["zeta_in"], join["zeta_out"] = part * join["zeta_in"], part * join["zeta_out"]
    return system


def closes(seeds):
    """How many of them have a cycle, of which each closes its energy and gives no more than it takes."""
    found = 0
    for seed in seeds:
        cycle = cycle_of(machine_of(random_system(seed)))
        if cycle is None:
            continue
        oil = cycle.oil
        lost = [*oil.orifices, oil.leakage, oil.relief, oil.return_line * (oil.return_line > 0.0), oil.drag]
        assert min(lost) >= 0.0, seed
        assert oil.losses + oil.impact == pytest.approx(oil.input, rel=1e-12), seed
        assert oil.impact <= oil.input, seed
        found += 1
    return found


def test_energy_closes():
    assert closes(range(3000, 3060)) >= 30


@pytest.mark.slow
def test_energy_of_many_closes():
    assert closes(range(4000, 4750)) >= 500


def test_a_start_above_an_ideal_relief_valve_has_the_pump_of_what_is_left():
    """Its pressure is beyond where the power limits the pump, and that of the relief valve is not."""
    assert closes([4739]) == 1


# ---- Units


@pytest.mark.parametrize("seed", [2, 4, 9, 11])
def test_units_do_not_matter(seed):
    machine = machine_of({**random_system(seed), "drag": 0.0})
    force, length, time = 2.0**5, 2.0**9, 2.0**2  # mass 1: force time^2 = length
    other = replace(machine, valve=machine.valve.scaled(force, length, time))
    here, there = cycle_of(machine), cycle_of(other)
    assert there.period == pytest.approx(time * here.period, rel=1e-13)
    assert there.blow_speed == pytest.approx(length / time * here.blow_speed, rel=1e-13)
    assert there.oil.input == pytest.approx(force * length * here.oil.input, rel=1e-13)
    assert there.mean_pressure == pytest.approx(here.mean_pressure, rel=1e-13)


# ---- Limits


def test_without_losses_the_closed_form_answers_and_oil_comes_to_it():
    for seed in range(12):
        system = lossless(constant(random_system(seed), tank=0.0, spool=0.0, force=0.0, gas=None), 0.0)
        machine = machine_of(system)
        bare = machine.with_valve(replace(machine.valve, oil=None))
        exact, plain = (self_excited_motion(one, modes=0).cycle for one in (machine, bare))
        if exact is None or system["drag"]:
            continue
        assert (exact.period, exact.blow_speed, exact.work) == (
            plain.period,
            plain.blow_speed,
            plain.work,
        )  # to the bit
        assert exact.oil is None
        cycle = cycle_of(machine)
        assert (cycle.period, cycle.blow_speed) == pytest.approx((exact.period, exact.blow_speed), rel=1e-12)
        assert cycle.oil.losses == 0.0


@pytest.mark.parametrize(
    "vary",
    [
        lossless,
        lambda system, e: {**system, "tank": 0.05 * e},
        lambda system, e: {**system, "spool": 0.05 * e},
    ],
    ids=["passages", "tank", "spool"],
)
def test_what_is_taken_away_leaves_the_machine_without_it(vary):
    """First differences of a limit fall with the quantity; so the value at 0 is met."""
    for seed in (1, 2, 4):
        system = constant(random_system(seed), spool=0.0, tank=0.0, gas=None)
        near = cycle_of(machine_of(vary(system, 0.0)))
        off = []
        for e in (1e-5, 1e-7, 1e-11):
            cycle = cycle_of(machine_of(vary(system, e)), near)
            off.append(abs(cycle.blow_speed / near.blow_speed - 1.0) + abs(cycle.period / near.period - 1.0))
        assert off[2] < 1e-10, seed
        assert off[1] <= 0.03 * off[0] + 1e-13, seed


def test_a_huge_accumulator_is_a_constant_pressure():
    for seed in (1, 2, 4):
        off = []
        for size in (1e4, 1e6):
            system = fed(seed)
            system["supply"]["accumulator"]["compliance"] = size
            system["supply"]["leak"] = 0.0
            cycle = cycle_of(machine_of(constant(system)))
            system["supply"]["pump"]["flow"] = cycle.oil.drawn / cycle.period
            found = cycle_of(machine_of(system))
            held = cycle_of(machine_of(system).with_valve(found.valve.at_pressure(found.mean_pressure)))
            off.append(abs(found.blow_speed / held.blow_speed - 1.0))
        assert off[1] <= 0.02 * off[0] + 1e-10, (seed, off)


def test_gas_of_a_great_volume_is_its_tangent():
    for seed in (1, 2, 4):
        off = []
        for volume in (1e2, 1e3):
            system = constant(random_system(seed), gas={"force": 0.1, "area": 0.5, "volume": volume, "exponent": 1.3})
            machine = machine_of(system)
            tangent = replace(machine.valve.chamber, exponent=None)
            gas, spring = cycle_of(machine), cycle_of(machine.with_valve(replace(machine.valve, chamber=tangent)))
            off.append(abs(gas.blow_speed / spring.blow_speed - 1.0))
        assert off[0] < 1e-5, seed
        assert off[1] == pytest.approx(0.01 * off[0], rel=0.1), seed  # of second order in u/column


# ---- Closed forms


def test_closed_forms_of_speed_period_and_multipliers():
    spoken = 0
    for seed in range(5000, 5040):
        back = {"on": "impact", "to": "return", "delay": 0.0}
        system = random_system(seed)
        system |= {"spool": 0.0, "ports": [{"behind": 1.0, "side": "back", "to": "power", "delay": 0.0}, back]}
        machine = machine_of(system)
        cycle = cycle_of(machine)
        if cycle is None or cycle.rests:
            continue
        for check in oil_checks(cycle):
            size = 1.0 if "multiplier" in check.name else abs(check.expected)
            assert check.found == pytest.approx(check.expected, abs=1e-10 * size), (seed, check)
            spoken += 1
        closed = closed_form(machine)
        if closed is not None:
            assert (cycle.blow_speed, cycle.period) == pytest.approx(closed, rel=1e-12), seed
    assert spoken >= 12


@pytest.mark.parametrize("seed", [2, 4, 5, 9, 11, 13, 14])
def test_multipliers_are_those_of_differences(seed):
    """Of the map from passage to passage, by differences of the fourth order."""
    cycle = cycle_of(machine_of(random_system(seed)))
    if cycle is None or cycle.passage is None:
        pytest.skip("no cycle")
    passage = cycle.passage
    own = OilUnknowns.of(passage.numbers, passage.state)
    x = own.values(passage.state)
    pressure = [1] + ([2] if own.fed else [])  # speed and pressure: the place is that of the port
    if own.waiting or own.stroke:
        pytest.skip("orders wait at the passage")

    def mapped(i, h):
        state = type(passage.state)(*map(np.array, passage.state))
        own.put(state, np.array([value + h * (j == i) for j, value in enumerate(x)]), x)
        return own.values(passage.returned(state).state)[pressure]

    h = 1e-4
    table = np.array([
        (8.0 * (mapped(i, h) - mapped(i, -h)) - mapped(i, 2.0 * h) + mapped(i, -2.0 * h)) / (12.0 * h) for i in pressure
    ]).T  # fmt: skip
    found = sorted(np.linalg.eigvals(table), key=lambda z: (z.real, z.imag))
    exact = sorted(cycle.multipliers().values.tolist(), key=lambda z: (z.real, z.imag))
    exact = [z for z in exact if abs(z) > 1e-14] if len(exact) > len(found) else exact
    assert found == pytest.approx(exact, abs=1e-7), seed


@pytest.mark.parametrize(("seed", "modes"), [(5000, 0), (5001, 0), (5003, 0), (5002, 2)])
def test_exponents_are_those_of_the_multipliers(seed, modes):
    machine = machine_of(fed(seed))
    cycle = settled_oil(machine, modes, None).cycle
    sizes = np.abs(cycle.multipliers().values)  # that of a coordinate that a port reads is 0
    wanted = np.sort(np.log(sizes[sizes > 1e-12]))[::-1] / cycle.blows
    told = lyapunov_exponent(machine, modes=modes, impacts=200, discard=200, every=True)
    assert told.outcome == "done"
    assert told.exponent == pytest.approx(wanted[0], abs=1e-4)
    assert told.per_period == pytest.approx(wanted[0] * cycle.blows / cycle.period, abs=1e-4)
    assert len(told.spectrum) == len(wanted) or modes
    assert told.spectrum[:2] == pytest.approx(wanted[:2], abs=0.05)


def test_the_multiplier_of_the_pressure_by_the_demand():
    system = named("pump and a huge accumulator")
    cycle = cycle_of(machine_of(system))
    greatest = max(cycle.multipliers().values.tolist(), key=abs)
    assert 1.0 - slow_oil(cycle) == pytest.approx(1.0 - greatest.real, rel=2e-2)
