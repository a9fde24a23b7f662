"""Cycles of machines that switch their own valve as problems for times: random machines against the simulator."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from machine_maps import beginning, differences, landed
from machine_oracle import after_blows
from percuss.errors import ParameterError
from percuss.explore import BranchEvent, follow, orbit_seeds
from percuss.explore.attractors.drawn_starts import named
from percuss.model import Chamber, External, Kept, Machine, Port, Ratio, Reversed, Supply, UniformBar, Valve
from percuss.simulate import Start, Stop, run
from percuss.steady import (
    Obstacle,
    SelfExcited,
    ValveCycle,
    orbits,
    pressure_over,
    self_excited_motion,
    slow_pressure,
    valve_margins,
)
from percuss.steady.self_excited.event_sequence import sequence_of
from percuss.steady.self_excited.settling import followed_to, under_pressure
from percuss.steady.self_excited.valve_orbits import valve_rest_cycles

MODES = (0, 1, 4)


def seeds(quick: int, every: int, step: int = 1) -> list[object]:
    """All of them; beyond the first few only in `make slow`."""
    return [pytest.param(i, marks=[] if i < quick else pytest.mark.slow) for i in range(0, every, step)]


def drawn(seed: int) -> tuple[Machine, int]:
    """A machine on a pump, on an accumulator from small to great, or under a constant pressure; and its modes."""
    rng = np.random.default_rng([25, seed])
    back, power, size = rng.uniform(0.2, 1.0), rng.uniform(0.8, 3.0), rng.uniform(0.3, 1.5)
    late = rng.uniform(0.0, 0.3, 2) * rng.integers(0, 2, 2)
    ports = [Port("power", size, "back", late[0], ("centre", 0.0, 0.5)[int(rng.integers(3))])]
    ports.append(
        Port("return", on="impact", delay=late[1]) if seed % 2 else Port("return", 0.1 * size, "front", late[1])
    )
    states = {"return": -back, "power": power}
    if seed % 3 == 0:
        states["between"] = 0.5 * power
        ports.append(Port("between", 0.5 * size, "front"))
    supply = Supply(rng.uniform(0.3, 1.0), 10.0 ** rng.uniform(0.5, 2.5)) if seed % 4 else None
    gas = Chamber(rng.uniform(0.0, 0.1), rng.choice([0.0, rng.uniform(0.0, 0.2)]))
    damping = [External(rng.uniform(0.02, 0.2)), Ratio(rng.uniform(0.05, 0.5))][seed % 2]
    law, bar = (Kept, Reversed)[seed // 2 % 2](rng.uniform(0.1, 0.6)), UniformBar(rng.uniform(3.0, 12.0), damping)
    if supply is not None and seed // 4 % 2:
        supply = replace(supply, quickening=rng.uniform(0.3, 0.9))
    return Machine(bar, Valve(states, ports, None, gas, supply=supply), law), MODES[seed % 3]


def found(machine: Machine, modes: int) -> ValveCycle | None:
    cycle = self_excited_motion(machine, modes=modes).cycle
    return None if cycle is None or cycle.rests else cycle


@pytest.mark.parametrize("seed", seeds(8, 24))
def test_cycles_are_those_of_the_simulator(seed: int) -> None:
    """State, pressure and orders come back after a cycle; the multipliers are those of differences of its map."""
    machine, modes = drawn(seed)
    cycle = found(machine, modes)
    if cycle is None:
        pytest.skip("no cycle without a rest")
    begin = beginning(cycle)
    after = landed(cycle, begin)
    assert after.times == pytest.approx(cycle.blow_times, rel=1e-11)
    assert after.numbers == pytest.approx(begin, rel=1e-10, abs=1e-10)
    own, theirs = np.poly(cycle.multipliers().values), np.poly(np.linalg.eigvals(differences(cycle)))
    assert own[: theirs.size] == pytest.approx(theirs, abs=1e-6 * max(1.0, float(np.abs(theirs).max())))
    assert own[theirs.size :] == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("seed", seeds(10, 24, 3))
def test_an_order_of_events_is_a_problem_for_its_times(seed: int) -> None:
    machine, modes = drawn(seed)
    cycle = found(machine, modes)
    if cycle is None:
        pytest.skip("no cycle without a rest")
    sequence = sequence_of(cycle)
    x = sequence.unknowns(cycle)
    assert x[-1] == cycle.period and sequence.label == f"{cycle.blows}/{sequence.valve_cycles}"
    closed = sequence.closed(machine, modes, x)
    assert np.abs(closed.error).max() < 1e-11
    h = 1e-6
    for i, aside in enumerate(np.eye(x.size)):
        one, other = (sequence.closed(machine, modes, x + sign * h * aside).error for sign in (1.0, -1.0))
        assert (one - other) / (2.0 * h) == pytest.approx(closed.slope[:, i], rel=1e-6, abs=1e-6)
    again = sequence.solved(machine, modes, x * (1.0 + 1e-4))
    assert again is not None and sequence.fault(again) is None and sequence_of(again) == sequence
    assert again.period == pytest.approx(cycle.period, rel=1e-12)
    assert again.multipliers().values == pytest.approx(cycle.multipliers().values, abs=1e-9)
    tests, few = sequence.tests(again), sequence.tests(again, ())
    assert min(tests.values()) > 0.0 and sequence.tests(again, tuple(range(len(sequence.events)))) == tests
    assert few == {name: value for name, value in tests.items() if name.partition(" ")[0] in ("blow", "port", "order")}
    assert np.abs(again.multipliers().values).max() <= again.contraction * (1.0 + 1e-12)


@pytest.mark.parametrize("modes", MODES)
def test_work_and_volume_close_with_a_pump(modes: int) -> None:
    """What the pump gives is what blows and damping take; what the piston draws is what it gives."""
    for seed in (1, 2, 3, 5, 7, 10, 11):
        machine, _ = drawn(seed)
        cycle = found(machine, modes)
        if cycle is None:
            continue
        x, weights = np.polynomial.legendre.leggauss(400)
        lost = 0.0
        for flight in cycle.flights:
            v = flight.at(0.5 * flight.duration * (x + 1.0))[1]
            lost += 0.5 * flight.duration * float(weights @ (flight.modes.damping @ v**2))
        assert cycle.work == pytest.approx(cycle.taken + lost, rel=1e-8)
        draws = dict(machine.valve.pairs)
        ways = [draws[f.state] * float((f.end - f.begin)[:, 0] @ f.modes.driven) for f in cycle.flights]
        assert sum(ways) == pytest.approx(machine.valve.supply.flow * cycle.period, rel=1e-9)
        pressure = slow_pressure(cycle)
        seen = pressure_over(cycle, np.linspace(0.0, cycle.period, 2000, endpoint=False))
        assert pressure.least <= seen.min() + 1e-12 and seen.max() <= pressure.greatest + 1e-12
        assert 0.0 <= pressure.least <= pressure.at_blow + 1e-12 <= pressure.greatest + 2e-12
        assert seen.mean() == pytest.approx(pressure.mean, rel=1e-2)
        assert np.isclose(np.abs(cycle.multipliers().values - pressure.multiplier).min(), 0.0, atol=1e-9)


def test_where_an_order_of_events_ends_is_told() -> None:
    """A return that comes later and later: the piston falls back, and its second blow begins as a touch."""
    ports = (Port("power", 1.0, "back"), Port("return", on="impact", delay=0.1))
    machine = Machine(UniformBar(20.0), Valve({"return": -0.4, "power": 1.8}, ports), Kept(0.2))
    cycle = self_excited_motion(machine, modes=0).cycle
    sequence, before = sequence_of(cycle), np.inf
    for late in np.linspace(0.1, 0.36, 14):
        later = machine.with_valve(replace(machine.valve, ports=(ports[0], replace(ports[1], delay=float(late)))))
        cycle = sequence.solved(later, 0, sequence.unknowns(cycle))
        apart = sequence.tests(cycle)["wall 1"]
        assert apart <= before
        assert (sequence.fault(cycle) is None) == (apart > 0.0) == (late < 0.3324)
        before = apart


@pytest.mark.parametrize(("R", "late", "modes"), [(0.0, 0.4, 0), (0.0, 0.4, 4), (0.2, 1.2, 0), (0.2, 1.2, 3)])
def test_a_cycle_with_rest_is_an_order_of_events(R: float, late: float, modes: int) -> None:
    """Its blows are those of the simulator, but for the last ones of its chatter; nothing of a disturbance is left."""
    machine = late_return(R, 0.3, late, modes)
    motion = run(machine, Start.rigid(0.0, 0.8), modes=modes, stop=Stop(impacts=300))
    (cycle,) = valve_rest_cycles(machine, "chatter" if R else "rest", modes=modes)
    sequence = sequence_of(cycle)
    assert cycle.rests and sequence.fault(cycle) is None and sequence.label == cycle.label
    assert cycle.period == pytest.approx(motion.cycle.period, rel=1e-10)
    struck = motion.events.of("impact")
    begin = np.flatnonzero(np.asarray(struck.impact_velocity) > 0.9 * cycle.blow_speed)[-2]
    seen = np.asarray(struck.time)[begin : begin + cycle.blows], np.asarray(struck.impact_velocity)[begin:]
    assert np.diff(cycle.blow_times) == pytest.approx(np.diff(seen[0]), abs=1e-10)
    assert cycle.blow_speeds == pytest.approx(seen[1][: cycle.blows], rel=1e-9)
    assert np.abs(cycle.multipliers().values).max() < 1e-12
    if R:
        rests = motion.events.of("rest").time
        after = float(rests[rests > struck.time[begin]][0] - struck.time[begin])
        left = sequence.tests(cycle)["rest 0"]
        assert cycle.flights[0].duration - left + np.ptp(cycle.blow_times) == pytest.approx(after, abs=1e-10)


@pytest.mark.parametrize("modes", [0, 2])
def test_rest_begins_where_the_chatter_meets_the_release(modes: int) -> None:
    (cycle,) = valve_rest_cycles(late_return(0.2, 0.3, 1.2, modes), "chatter", modes=modes)
    onset = follow(cycle, "restitution", (0.19, 0.4), value=0.2).ends[1]
    assert onset.kind is BranchEvent.ONSET
    sequence = sequence_of(cycle)
    at = sequence.solved(late_return(onset.value, 0.3, 1.2, modes), modes, sequence.unknowns(onset.valve_cycle))
    assert at is not None and abs(sequence.tests(at)["rest 0"]) < 1e-10
    if modes == 0:  # by hand: the chatter of a constant force ends 2 R v/((1 − R) a) after its first blow
        assert 2.0 * onset.value * at.blow_speed / (1.0 - onset.value) == pytest.approx(1.2, abs=1e-10)


def test_without_restitution_rest_begins_at_a_value_that_both_sides_tell() -> None:
    """The return comes before the blow, or after it, and the piston waits for it on the wall."""
    ports = [Port("power", 1.0, "back"), Port("return", 0.4, "front", delay=0.3)]
    machine = Machine(UniformBar(20.0), Valve({"return": -0.3, "power": 1.0}, ports), Kept(0.0))
    found = []
    for late in (0.1, 0.6):
        ports[1] = replace(ports[1], delay=late)
        cycle = self_excited_motion(machine.with_valve(replace(machine.valve, ports=tuple(ports))), modes=0).cycle
        assert cycle is not None
        branch = follow(cycle, "ports[1].delay", (0.0, 1.0), value=late)
        found += [point.value for point in branch.ends if point.kind is BranchEvent.ONSET]
        assert branch.label == ("1/1" if late == 0.1 else "rest/1")
    assert len(found) == 2 and found[0] == pytest.approx(found[1], abs=1e-10)


# -- all of them: searched for by orders of events --


def late_return(R: float, back: float, late: float, modes: int = 0) -> Machine:
    """A power of 1 that ends so late after the blow (machines of two forces, no gas)."""
    ports = (Port("power", 1.0, "back"), Port("return", on="impact", delay=late))
    bar = UniformBar(20.0, External(0.0 if modes == 0 else 0.1))
    return Machine(bar, Valve({"return": -back, "power": 1.0}, ports), Kept(R))


@pytest.mark.parametrize(
    ("machine", "label", "moduli"),
    [
        (late_return(0.2, 0.3, 0.2), (1, 1), [0.0077]),
        (late_return(0.2, 0.3, 0.5), (2, 1), [0.0016]),
        (late_return(0.2, 0.3, 0.5), (1, 1), []),
        (late_return(0.8, 3.0, 1.0), (1, 1), [1.2309]),  # beyond its flip …
        (late_return(0.8, 3.0, 1.0), (2, 2), [0.9244]),  # … the doubled one is stable
        (late_return(0.8, 1.0, 2.2), (1, 1), []),  # passes the port before: v²/2 = 1.015 > 1
    ],
)
def test_orbits_of_a_late_return(machine: Machine, label: tuple[int, int], moduli: list[float]) -> None:
    found = orbits(machine, *label, modes=0, tries=40)
    assert [abs(one.multiplier) for one in found.orbits] == pytest.approx(moduli, abs=1e-4)
    assert found.label == f"{label[0]}/{label[1]}" and all(one.label == found.label for one in found.orbits)
    assert found.tries == 40 and not found.complete


@pytest.mark.parametrize("seed", seeds(4, 12))
def test_orbits_are_motions_of_the_simulator_and_none_is_missing(seed: int) -> None:
    """Each comes back to 1e-10 with the multipliers of differences; what simulations settle on is among them."""
    machine, modes = drawn(seed)
    ports = list(machine.valve.ports)
    ports[1] = replace(ports[1], delay=0.07 * seed)
    machine = machine.with_valve(replace(machine.valve, ports=tuple(ports)))
    labels = {(1, 1), (2, 2)}
    settled = [run(machine, start, modes=modes, stop=Stop(impacts=300)) for start in named(machine, "wall", 3, seed)]
    settled = [one for one in settled if one.cycle is not None and one.cycle.kind == 0 and 0 < one.cycle.impacts <= 4]
    labels |= {(one.cycle.impacts, one.cycle.periods) for one in settled}
    found = {label: orbits(machine, *label, modes=modes, tries=30).orbits for label in labels}
    for one in settled:
        periods = [orbit.period for orbit in found[one.cycle.impacts, one.cycle.periods]]
        assert any(abs(one.cycle.period - period) < 1e-5 * period for period in periods), one.label
    for cycle in (one for those in found.values() for one in those):
        begin = beginning(cycle)
        assert landed(cycle, begin).numbers == pytest.approx(
            begin, rel=1e-10, abs=1e-10 * max(1.0, abs(cycle.multiplier))
        )
        if abs(cycle.multiplier) < 5.0:
            own, theirs = np.poly(cycle.multipliers().values), np.poly(np.linalg.eigvals(differences(cycle)))
            assert own[: theirs.size] == pytest.approx(theirs, abs=1e-6 * max(1.0, float(np.abs(theirs).max())))


@pytest.mark.parametrize(("modes", "pump", "cycles"), [(0, False, 1), (0, True, 2), (2, False, 2), (1, True, 1)])
def test_orders_may_wait_longer_than_a_cycle(modes: int, pump: bool, cycles: int) -> None:
    """With all delays whole cycles longer the cycle is the same; its multipliers are those of differences."""
    ports = (Port("power", 1.0, "back", 0.1), Port("return", on="impact", delay=0.1))
    valve = Valve({"return": -0.4, "power": 1.8}, ports, supply=Supply(0.7, 30.0) if pump else None)
    machine = Machine(UniformBar(5.0, External(0.1)), valve, Reversed(0.3))
    cycle = found(machine, modes)
    later = tuple(replace(port, delay=port.delay + cycles * cycle.period) for port in ports)
    waiting = [(one.time + k * cycle.period, one.to) for k in range(cycles) for one in cycle.switches]
    rhythm = replace(cycle.rhythm, orders=replace(cycle.orders, pending=tuple(waiting)))
    machine = machine.with_valve(replace(valve, ports=later))
    (same,) = orbits(machine, 1, 1, modes=modes, tries=1, near={"shifted": [rhythm]}).orbits
    assert [due for due, _ in same.orders.pending] == pytest.approx([due for due, _ in waiting])
    assert same.period == pytest.approx(cycle.period, rel=1e-12)
    begin = beginning(same)
    assert landed(same, begin).numbers == pytest.approx(begin, abs=1e-9)
    own, theirs = np.poly(same.multipliers().values), np.poly(np.linalg.eigvals(differences(same)))
    assert own[: theirs.size] == pytest.approx(theirs, abs=1e-6 * np.abs(theirs).max())
    assert [end.kind for end in follow(same, "restitution", (0.28, 0.32), value=0.3).ends] == [BranchEvent.LIMIT] * 2


def test_simulated_motions_are_starts_and_a_search_ends_when_told() -> None:
    machine = late_return(0.8, 3.0, 1.0)
    seeds = orbit_seeds(machine, 2, 2, modes=0, motions=2)
    found = orbits(machine, 2, 2, modes=0, tries=1, near=seeds)
    assert found.sources["simulated motions"].orbits == 1 and len(found.orbits) == 1
    asked = iter([False] * 6)
    found = orbits(machine, 1, 1, modes=0, tries=1000, progress=lambda _: next(asked, True))
    assert found.interrupted and found.tries < 1000
    with pytest.raises(ParameterError, match="loses energy"):
        orbits(late_return(1.0, 0.3, 0.0), 1, 1, modes=0)


# -- the machine that a pump and an accumulator feed -------------------------------------------------------------------


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
    motion = fed(breaker(133, compliance, nitrogen))
    cycle, begins = motion.cycle, motion.cycle.rebound
    waiting = [to for _, to in begins.orders.pending]

    def after(numbers: np.ndarray) -> np.ndarray:
        """Of the speed, when the pending orders are due, and the pressure."""
        start = np.concatenate([[0.0, -numbers[0], numbers[-1]], numbers[1:-1]])
        _, ends = after_blows(motion.machine, start, begins.state, begins.orders.last, waiting)
        return np.concatenate([[-ends[1]], ends[3:], [ends[2]]])

    assert after(begins.numbers) == pytest.approx(begins.numbers, rel=1e-11)
    columns = [
        (after(begins.numbers + aside) - after(begins.numbers - aside)) / (2.0 * aside.sum())
        for aside in np.diag(1e-5 * begins.numbers)
    ]
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


def test_a_constant_pressure_is_refused() -> None:
    machine = Machine(UniformBar(20.0), breaker(133, 1e-3), Kept(0.15))
    with pytest.raises(ParameterError, match="supply"):
        slow_pressure(self_excited_motion(machine.with_valve(replace(machine.valve, supply=None)), modes=0).cycle)


def test_much_more_oil_makes_a_pressure_as_its_square() -> None:
    """A disturbance of such a pressure hardly dies out, and it is one cycle all the same."""
    ports = (Port("power", 1.0, "back"), Port("return", on="impact"))
    means = []
    for flow in (100.0, 300.0):
        motion = fed(Valve({"return": -0.4, "power": 1.8}, ports, supply=Supply(flow, 30.0)))
        assert motion.runs and motion.cycle.blows == 1
        means.append(slow_pressure(motion.cycle).mean)
    assert means[0] > 1e4 and means[1] == pytest.approx(9.0 * means[0], rel=2e-2)


def test_delays_follow_a_high_pressure_at_any_times() -> None:
    """A delay times 1 + χ(π − 1) is that at the pressure 1, which the pump makes hundreds of times as high."""
    ports = (Port("power", 1.0, "back", 0.3), Port("return", on="impact", delay=0.2))
    valve = Valve({"return": -0.4, "power": 1.8}, ports, supply=Supply(10.0, 30.0, quickening=0.6))
    cycle = fed(valve, 0.2, 0.1).cycle
    sequence, machine = sequence_of(cycle), cycle.machine
    assert [event.kind for event in sequence.events] == ["due", "port", "due", "blow"]
    for share in (0.5, 0.8, 1.0, 1.3, 2.0):
        x = share * sequence.unknowns(cycle)
        closed = sequence.closed(machine, 0, x)
        given = np.array([closed.start[-1], closed.states[1][-1]])
        assert closed.delays[[0, 2]] * (1.0 + 0.6 * (given - 1.0)) == pytest.approx([0.2, 0.3], rel=1e-10)
        assert given.min() > 50.0 and sequence.solved(machine, 0, x).period == pytest.approx(cycle.period, rel=1e-9)
