"""A record read as a valve: what the machine that made it was comes back, within the stated intervals."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest

from machine_records import MASS, Told, breaker, drifter, recorded_machine
from percuss import Bar, Load, System
from percuss.errors import LoadError, ParameterError
from percuss.model import Chamber, Kept, Machine, Port, UniformBar, Valve
from percuss.steady import ForceRecord, recorded_together, recorded_valve, self_excited_motion, steady_states
from percuss.steady.recorded.force_record import changes, edge_times, implied_by_record, rough_edges, sought_blows


def own_cycle(machine: Machine):
    found = self_excited_motion(machine, modes=0)
    assert found.cycle is not None
    return found


def bar(mass: float = MASS, length: float = 1.0) -> Bar:
    density = mass / (length * math.pi * 0.06**2)
    return Bar(length, diameter=0.12, density=density, youngs_modulus=density * 5100.0**2, drag=0.5 * mass)


def hammer(told: Told, restitution: float = 0.15, mass: float = MASS) -> System:
    """The piston under the record as a clocked load, in SI."""
    return System.from_si(bar(mass), Load.history(told.time, mass * told.force), Kept(restitution))


def measured(told: Told) -> ForceRecord:
    return ForceRecord(told.time, told.force, told.blows[1:-1])


LATE = breaker(return_delay=3.5e-3)
EARLY = breaker(return_delay=0.0, front=10e-3)
REAL = {"noise": 0.02, "ringing": 0.1, "rate": 20e3}


# ---------------------------------------------------------------- what the mean cycle tells


@pytest.mark.parametrize(
    ("ports", "gas", "restitution"),
    [
        ([("power", 1.0, "back", 0.0), ("return", 0.05, "front", 0.0)], 0.0, 0.2),
        ([("power", 1.0, "back", 0.1), ("return", 0.2, "front", 0.05)], 0.0, 0.0),
        ([("power", 1.0, "back", 0.0), ("return", 0.02, "front", 0.25)], 0.0, 0.5),
    ],
)
def test_steps_of_a_machine_give_its_switches_and_its_own_cycle_again(ports, gas, restitution) -> None:
    valve = Valve({"return": -0.4, "power": 1.8}, [Port(to, behind=h, side=side, delay=t) for to, h, side, t in ports])
    cycle = own_cycle(Machine(UniformBar(80.0), valve, Kept(restitution))).cycle
    rate = 2.0 * math.pi / cycle.period
    times = {switch.to: switch.time for switch in cycle.switches}
    breaks = sorted((time * rate % (2.0 * math.pi), valve.force(to)) for to, time in times.items())
    load = Load.steps([b for b, _ in breaks], [p / rate**2 for _, p in breaks])
    read = recorded_valve(System(s=80.0, d=0.0, restitution=restitution, load=load), blow=0.0)
    assert read.speed * rate == pytest.approx(cycle.blow_speed, rel=1e-9)
    assert read.stroke == pytest.approx(cycle.stroke, rel=1e-5)
    assert read.stiffness.value == 0.0
    assert np.array(read.forces) * rate**2 == pytest.approx([-0.4, 1.8], rel=1e-3)
    for switch in cycle.switches:
        seen = next(one for one in read.switches if one.to == switch.to)
        assert seen.behind.low <= switch.behind <= seen.behind.high
        assert seen.velocity.low <= switch.velocity / rate <= seen.velocity.high
    again = own_cycle(read.by_ports.machine)
    assert again.runs
    assert again.cycle.period * read.system.body.s / 80.0 == pytest.approx(2.0 * math.pi, rel=2e-3)
    assert again.cycle.blow_speed == pytest.approx(read.speed, rel=2e-3)


@pytest.mark.parametrize(("valve", "at_blow"), [(EARLY, False), (breaker(), True), (LATE, True)])
def test_a_real_record_gives_levels_chamber_and_places(valve: Valve, at_blow: bool) -> None:
    """Noise of 2 %, ringing of a tenth of the jump: the switches to 1 mm, nitrogen and forces to some percent."""
    told = recorded_machine(valve, Kept(0.15), cycles=12, **REAL)
    read = recorded_valve(hammer(told), record=measured(told))
    cycle = own_cycle(Machine.from_si(bar(), valve.scaled(MASS, 1.0), Kept(0.15))).cycle
    assert read.cycles == 10
    assert read.speed == pytest.approx(cycle.blow_speed, rel=0.01)
    assert read.restitution.value == pytest.approx(0.15, abs=0.004)
    assert read.stiffness.low <= 20e3 / MASS <= read.stiffness.high
    assert np.array(read.forces) == pytest.approx([valve.force("return"), valve.force("power")], rel=0.03)
    for switch in cycle.switches:
        seen = next(one for one in read.switches if one.to == switch.to)
        assert seen.behind.value == pytest.approx(switch.behind, abs=1e-3)
        if switch.behind > 1e-3:  # else some of the cycles switch before the blow
            assert seen.velocity.value == pytest.approx(switch.velocity, abs=0.05)
        assert not seen.found.told_apart
    assert next(one for one in read.switches if one.to == "return").by_blow == at_blow
    for found in (read.by_ports, read.by_delays):
        assert found.runs
        assert found.cycle.period == pytest.approx(cycle.period, rel=0.01)
        assert found.cycle.blow_energy == pytest.approx(cycle.blow_energy, rel=0.05)
    delays = [
        max(port.delay for port in one.valve.ports)
        for one in (read.by_ports.machine, read.machine, read.by_delays.machine)
    ]
    assert delays[0] == delays[1] < 4e-3
    assert delays[2] > 15e-3


@pytest.mark.parametrize("rise", [0.0, 0.5e-3, 1e-3, 1.5e-3])
@pytest.mark.parametrize(("valve", "most"), [(breaker(), 4e-3), (LATE, 5e-4), (EARLY, 3e-3)])
def test_a_force_that_changes_gradually_gives_a_machine_of_the_recorded_rate(
    valve: Valve, most: float, rise: float
) -> None:
    """A fall before and behind the blow is no step of the same momentum on both sides: rates came out 1 % fast."""
    told = recorded_machine(valve, Kept(0.15), rise=rise)
    read = recorded_valve(hammer(told), record=ForceRecord(told.time, told.force))
    cycle = own_cycle(read.machine).cycle
    assert cycle.period == pytest.approx(float(np.diff(told.blows).mean()), rel=most)
    assert cycle.blow_speed == pytest.approx(read.speed, rel=1e-2)
    assert cycle.stroke == pytest.approx(read.stroke, rel=1e-2)


def test_a_drifter_without_gas() -> None:
    told = recorded_machine(drifter(), Kept(0.2), drag=6.0, cycles=30, rate=50e3, noise=0.02)
    density = 5.05 / (0.341 * math.pi * 0.0245**2)
    piston = Bar(0.341, diameter=0.049, density=density, youngs_modulus=2.1e11, drag=6.0 * 5.05 / 0.341)
    system = System.from_si(piston, Load.history(told.time, 5.05 * told.force), Kept(0.2))
    read = recorded_valve(system, record=measured(told))
    assert read.stiffness.value == 0.0
    back = next(one for one in read.switches if one.to == "power")
    assert back.behind.value * 0.341 == pytest.approx(0.02680, abs=1e-4)
    found = own_cycle(read.machine)
    assert found.cycle.blow_speed * 0.341 == pytest.approx(10.92, rel=0.01)
    assert 1.0 / found.cycle.period == pytest.approx(61.2, rel=0.01)


def test_the_blow_is_where_it_was_measured_or_chosen_or_at_the_fall() -> None:
    """A switch to return late, after the blow, and one before it look alike in the force: the blow must be known."""
    told = recorded_machine(EARLY, Kept(0.15), cycles=12)
    system = hammer(told)
    phases = [orbit.phase for orbit in steady_states(system).orbits]
    alone = recorded_valve(system)
    assert "where the blow falls was not measured" in " ".join(alone.notes)
    assert alone.phases == tuple(phases)
    true = 2.0 * math.pi * (told.blows[3] / (told.blows[-1] / 12) % 1.0)
    chosen = recorded_valve(system, blow=true)
    assert math.remainder(chosen.phase - true, 2.0 * math.pi) == pytest.approx(0.0, abs=0.01)
    assert {alone.phase, chosen.phase} == set(phases)
    assert [one.by_blow for one in alone.switches if one.to == "return"] == [True]
    assert [one.by_blow for one in chosen.switches if one.to == "return"] == [False]
    known = recorded_valve(system, record=measured(told))
    assert next(one for one in known.switches if one.to == "return").behind.value == pytest.approx(0.01, abs=3e-4)


# ---------------------------------------------------------------- port and delay


def varied(valve: Valve | None, seed: int, cycles: int = 40) -> Told:
    """Cycles of different restitutions under one valve, or of different pressures."""
    draw = np.random.default_rng(seed)
    if valve is not None:
        contacts = [Kept(R) for R in draw.uniform(0.1, 0.2, cycles)]
        return recorded_machine(valve, contacts, cycles=cycles, noise=0.01)
    valves = [breaker(pressure=p) for p in draw.uniform(155.0, 165.0, cycles)]
    return recorded_machine(valves, Kept(0.15), cycles=cycles, noise=0.01)


@pytest.mark.slow
@pytest.mark.parametrize(("valve", "seed", "late"), [(breaker(), 3, 0.5e-3), (LATE, 4, 3.5e-3), (None, 3, 0.5e-3)])
def test_cycles_that_differ_tell_port_and_delay_apart(valve: Valve | None, seed: int, late: float) -> None:
    told = varied(valve, seed)
    read = recorded_valve(hammer(told), record=measured(told))
    power, back = (next(one for one in read.switches if one.to == to).found for to in ("power", "return"))
    assert power.told_apart
    assert power.port.low <= 0.130 <= power.port.high
    assert power.delay.low <= 5e-3 <= power.delay.high
    assert power.port.high - power.port.low < 8e-3
    assert back.told_apart
    assert back.port.low <= 4e-3 <= back.port.high
    assert back.delay.low <= late <= back.delay.high
    ports = {port.to: port for port in read.machine.valve.ports}
    assert ports["power"].behind == pytest.approx(power.port.value)
    assert own_cycle(read.machine).cycle.blow_speed == pytest.approx(9.1, rel=0.02)


def test_two_records_at_different_pressures_tell_them_apart_together() -> None:
    read = []
    for pressure in (150.0, 170.0):
        told = recorded_machine(breaker(pressure=pressure), Kept(0.15), cycles=12, noise=0.01)
        read.append(recorded_valve(hammer(told), record=measured(told)))
        assert not any(switch.found.told_apart for switch in read[-1].switches)
    both = recorded_together(*read)
    power = next(one for one in both.switches if one.to == "power").found
    assert power.told_apart
    assert power.port.low <= 0.130 <= power.port.high
    assert power.delay.low <= 5e-3 <= power.delay.high
    assert both.cycles == 20
    assert both.forces == read[0].forces
    with pytest.raises(ParameterError, match="others"):
        recorded_together(read[0])
    with pytest.raises(ParameterError, match="first"):
        recorded_together(1, read[0])


def test_the_longest_delay_bounds_the_readings() -> None:
    told = recorded_machine(breaker(), Kept(0.15), cycles=12)
    read = recorded_valve(hammer(told), record=measured(told), longest_delay=6e-3)
    assert max(switch.found.delay.high for switch in read.switches) == pytest.approx(6e-3)
    places = {port.to: port.behind for port in read.by_delays.machine.valve.ports}
    assert places["power"] == pytest.approx(0.1458 - 6e-3 * 3.27, abs=1e-3)
    assert read.by_delays.runs


# ---------------------------------------------------------------- forces that are not recorded


@pytest.mark.parametrize("share", [0.3, 0.5125])
def test_the_area_ratio_that_puts_the_blow_at_the_switch(share: float) -> None:
    """The record is of the rear chamber alone; the front one pulls with a constant force that nobody recorded."""
    supply = 16e-4 * 160e5 / MASS
    valve = Valve(
        {"return": -share * supply, "power": (1.0 - share) * supply},
        [Port("power", behind=0.13, side="back", delay=5e-3), Port("return", on="impact")],
    )
    told = recorded_machine(valve, Kept(0.15), cycles=12)
    told.force += share * supply
    read = recorded_valve(hammer(told))
    assert read.opposing_share == pytest.approx(share, abs=0.005)
    assert "no blow fits the whole load" in read.notes[0]
    found = own_cycle(read.machine)
    assert found.cycle.blow_speed == pytest.approx(told.speeds[-1], rel=0.02)
    assert recorded_valve(hammer(recorded_machine(LATE, Kept(0.15), cycles=8))).opposing_share is None


# ---------------------------------------------------------------- motions, edges, and what is refused


@pytest.mark.parametrize("drag", [0.0, 0.5, 400.0])
def test_the_implied_motion_is_that_of_the_equation(drag: float) -> None:
    """u″ + d u′ = p under a force of waves, by its closed solution from blow to blow; 400/s is far overdamped."""
    time = np.linspace(0.0, 0.3, 60001)
    k = 2.0 * np.pi / 0.1
    force = 30.0 + 100.0 * np.cos(k * time)
    blows = np.array([0.02, 0.11, 0.19])
    found = implied_by_record(time, force, blows, drag)
    for begin, end in pairwise(blows.tolist()):
        t = np.linspace(begin, end, 200)
        wave = 100.0 / (1j * k * (1j * k + drag)) * np.exp(1j * k * t)
        drift = 15.0 * (t - begin) ** 2 if drag == 0.0 else 30.0 * (t - begin) / drag
        fade = t - begin if drag == 0.0 else -np.expm1(-drag * (t - begin)) / drag
        forced = wave.real - wave.real[0] + drift
        u = forced - forced[-1] * fade / fade[-1]
        assert found.at(t[1:-1])[0] == pytest.approx(-u[1:-1], abs=2e-7)
        moved = np.linspace(begin + 1e-3, end - 1e-3, 50)
        slope = (found.at(moved + 1e-5)[0] - found.at(moved - 1e-5)[0]) / 2e-5
        assert found.at(moved)[1] == pytest.approx(slope, abs=1e-3)
    assert found.at(blows)[0] == pytest.approx(0.0, abs=1e-12)


def test_blows_that_were_not_measured_follow_from_the_restitution() -> None:
    valves = [breaker(3.5e-3, pressure=p) for p in np.random.default_rng(5).uniform(155.0, 165.0, 20)]
    told = recorded_machine(valves, Kept(0.15), cycles=20)
    rough = told.blows[1:-1] + np.random.default_rng(1).uniform(-5e-4, 5e-4, 19)
    rough[[0, -1]] = told.blows[[1, -2]]
    found = sought_blows(told.time, told.force, rough, 0.5, -0.15)
    assert found == pytest.approx(told.blows[1:-1], abs=5e-5)
    motion = implied_by_record(told.time, told.force, found, 0.5)
    assert motion.rebounds[1:] == pytest.approx(0.15 * motion.speeds[:-1], rel=1e-6)


def test_an_edge_is_where_the_step_with_its_momentum_is() -> None:
    """A ramp counts at its middle, ringing does not count."""
    time = np.linspace(0.0, 1.0, 4001)
    for force in (
        np.clip((time - 0.48) / 0.04, 0.0, 1.0),
        (time >= 0.5) * (1.0 + 0.3 * np.exp(-(time - 0.5) / 0.01) * np.cos(2.0 * np.pi * (time - 0.5) / 0.004)),
    ):
        found = edge_times(time, force, np.array([0.49]), (np.zeros(1), np.ones(1)), 0.06)
        assert found == pytest.approx([0.5], abs=3e-4)
    square = np.where((np.arange(1024) >= 200) & (np.arange(1024) < 700), 1.0, -1.0)
    assert rough_edges(square).tolist() == [200, 700]
    assert changes(square)[[200, 700, 500]].tolist() == [2.0, -2.0, 0.0]
    assert rough_edges(np.cos(2.0 * np.pi * np.arange(1024) / 1024)).size == 0


def test_three_levels_are_three_states() -> None:
    load = Load.steps([0.0, 2.0, 4.0, 6.0], [-0.5, 0.8, 2.2, -0.5])
    read = recorded_valve(System(s=50.0, d=0.0, restitution=0.2, load=load))
    assert [name for name, _ in read.machine.valve.pairs] == ["state 1", "state 2", "state 3"]
    assert np.array(read.forces) == pytest.approx([-0.5, 0.8, 2.2], rel=1e-3)
    assert sorted(switch.to for switch in read.switches) == ["state 1", "state 2", "state 3"]


def test_what_is_refused() -> None:
    smooth = System(s=20.0, d=0.0, restitution=0.2, load=Load.harmonic(0.3, 1.0))
    with pytest.raises(LoadError, match="does not switch"):
        recorded_valve(smooth)
    with pytest.raises(LoadError, match="constant"):
        recorded_valve(smooth.with_load(Load.fourier([0.3])))
    with pytest.raises(ParameterError, match="record"):
        recorded_valve(smooth, record=3)
    with pytest.raises(ParameterError, match="force"):
        ForceRecord([0.0, 1.0], [1.0])
    with pytest.raises(ParameterError, match="increasing"):
        ForceRecord([0.0, 1.0, 1.0], [1.0, 1.0, 2.0])


def test_a_chamber_is_part_of_the_machine_read() -> None:
    told = recorded_machine(breaker(), Kept(0.15), cycles=12)
    read = recorded_valve(hammer(told), record=measured(told))
    gas = read.machine.valve.chamber
    assert isinstance(gas, Chamber)
    assert gas.force == 0.0
    assert gas.stiffness == pytest.approx(20e3 / MASS, rel=0.02)


def test_no_motion_is_read_that_passes_through_the_wall() -> None:
    """Of two phases with the momentum of the load, the one nearest to its fall would have the piston in the wall."""
    load = Load.steps([0.0, 2.0, 4.5, 6.0], [-0.4, -0.4, 1.8, -0.4])
    read = recorded_valve(System(s=50.0, d=0.0, restitution=0.2, load=load))
    assert all(switch.behind.value > 0.0 for switch in read.switches)
    assert [switch.to for switch in read.switches] == ["power", "return"]
