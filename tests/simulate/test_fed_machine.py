"""Simulated machines that a pump and an accumulator feed: a second program, the steady cycle, books, ends."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from machine_strategies import random_supplied
from percuss.errors import ParameterError, PercussError
from percuss.model import Chamber, External, Kept, Machine, Port, Reversed, Supply, UniformBar, Valve
from percuss.model.body import KelvinVoigt, Ratio
from percuss.simulate import Start, Stop, Trajectory, run, simulate_many
from percuss.steady import self_excited_motion
from supply_oracle import begun, follow, piston

PORTS = (Port("power", 1.0, "back", 0.1), Port("return", on="impact"))


def machine(valve: Valve, R: float = 0.3, drag: float = 0.0) -> Machine:
    return Machine(UniformBar(20.0, External(drag)), valve, Kept(R))


def two_force(supply: Supply, back: float = 0.4, power: float = 1.8, chamber: Chamber | None = None) -> Valve:
    return Valve({"return": -back, "power": power}, PORTS, None, chamber or Chamber(), supply=supply)


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=5)
def test_events_are_those_of_plain_integration(seed: int) -> None:
    made, start = random_supplied(np.random.default_rng(seed))
    motion = run(made, start, modes=0, stop=Stop(impacts=4, time=15.0, periodic=False))
    u, v = start.displacement, start.velocity
    now = begun(made.valve, float(u[0]), float(v[0]), made.valve.supply.start)
    follow(now, made.valve, made.contact.restitution, made.drag, 4, 15.0)
    ours = [(e.time, e.kind) for e in motion.events if e.kind in ("impact", "port", "valve")]
    theirs = [(time, kind) for time, kind, _ in now.events]
    for (time, kind), (other, same) in zip(ours, theirs, strict=False):
        if abs(time - other) > 1e-7:
            break
        assert kind == same
    else:
        assert abs(len(ours) - len(theirs)) <= 2
        return
    near = min(abs(g) for g in _grazes(motion, time))
    assert near < 1e-4  # a place that is touched rather than passed: rounding decides


def _grazes(motion: Trajectory, time: float) -> list[float]:
    """How near the piston is to a place, with how small a speed, about a time."""
    times = np.clip(time + np.linspace(-1e-3, 1e-3, 21), motion.begin_time, motion.end_time)
    at = motion.modal(times)
    u, v = at.displacement, at.velocity
    places = [0.0, *(port.behind for port in motion.machine.valve.ports if port.behind)]
    return [float(np.min(np.abs(u[0] + place) + v[0] ** 2)) for place in places]


def test_the_motion_settles_on_the_steady_cycle() -> None:
    made = machine(two_force(Supply(1.0, 5.0), chamber=Chamber(0.05, 0.1)), 0.4, 0.05)
    cycle = self_excited_motion(made, modes=0).cycle
    motion = run(made, modes=0, stop=Stop(tolerance=1e-11))
    assert motion.label == "runs 1/1"
    assert motion.cycle.period == pytest.approx(cycle.period, rel=1e-10)
    assert motion.blow_speeds[-1] == pytest.approx(cycle.blow_speed, rel=1e-9)
    assert motion.pressure(motion.blow_times[-1:])[0] == pytest.approx(cycle.rebound.pressure, rel=1e-9)
    times = np.linspace(motion.blow_times[-2], motion.blow_times[-1], 50)
    assert motion.position(1.0, times)[0] == pytest.approx(cycle.position(times - times[0]), abs=1e-8)


def test_a_growing_pressure_lifts_the_piston_off_the_wall() -> None:
    """The pump begins at no pressure: the piston lies until the return force overcomes the gas."""
    valve = two_force(Supply(0.8, 3.0, start=0.0), chamber=Chamber(0.3, 0.0))
    motion = run(machine(valve), modes=0, stop=Stop(impacts=60))
    release = motion.events.of("release")[0]
    assert release.time == pytest.approx(3.0 * (0.3 / 0.4) / 0.8, rel=1e-12)
    assert motion.pressure([release.time])[0] == pytest.approx(0.75, rel=1e-12)
    assert motion.resting and motion.impacts > 0
    assert motion.force([0.5 * release.time])[0] > 0.0


def test_an_accumulator_runs_empty() -> None:
    motion = run(machine(two_force(Supply(0.02, 0.2))), modes=0)
    assert (motion.outcome, motion.label) == ("stalls", "stalls (without pressure)")
    assert motion.pressure([motion.end_time])[0] == pytest.approx(0.0, abs=1e-12)


def test_stalls() -> None:
    pushing = Valve({"power": 1.0}, (Port("power", on="impact"),), supply=Supply(1.0, 2.0))
    assert run(machine(pushing), modes=0).label == "stalls (on the tool)"
    leaving = Valve({"return": -1.0}, (Port("return", 0.5, "back"),), supply=Supply(1.0, 2.0))
    assert run(machine(leaving, drag=2.0), modes=0).label == "stalls (leaves)"


IMPACT = Port("return", on="impact")
LASTING = {
    "stalls (on the tool)": (Valve({"power": 1.0}, (Port("power", on="impact"),), supply=Supply(1.0, 2.0)), 0.0),
    "stalls (leaves)": (Valve({"power": -1.0}, (Port("power", 0.5, "back"),), supply=Supply(1.0, 2.0)), 2.0),
    "stalls (in the chamber)": (
        Valve({"return": 0.0, "power": 0.8}, (PORTS[0], IMPACT), None, Chamber(-0.2, 1.15), supply=Supply(0.5, 5.0)),
        0.12,
    ),
}


@pytest.mark.parametrize("label", LASTING)
def test_a_stall_is_told_and_followed_to_the_time_asked_for(label: str) -> None:
    valve, drag = LASTING[label]
    made, start = machine(valve, 0.45, drag), Start.rigid(-0.8, 0.3).with_valve("power")
    motion = run(made, start, modes=0, stop=Stop(time=30.0))
    assert (motion.label, motion.outcome, motion.end_time) == (label, "stalls", 30.0)
    assert motion.position(1.0, np.linspace(0.0, 30.0, 3000)).max() < 1e-12
    now = begun(replace(valve, start="power"), -0.8, 0.3, 1.0)
    follow(now, valve, 0.45, drag, 8, 30.0)
    theirs = [time for time, kind, _ in now.events if kind == "impact"]
    assert motion.blow_times[: len(theirs)] == pytest.approx(theirs, abs=1e-6)
    assert len(theirs) == min(motion.impacts, 8) and run(made, start, modes=0).impacts == motion.impacts


def test_a_great_accumulator_is_a_constant_pressure() -> None:
    constant = Valve({"return": -0.4, "power": 1.8}, PORTS)
    start, stop = Start.rigid(-0.3), Stop(impacts=6, periodic=False)
    fed = run(machine(two_force(Supply(1.0, 1e9))), start, modes=0, stop=stop)
    plain = run(machine(constant), start, modes=0, stop=stop)
    assert fed.blow_times == pytest.approx(plain.blow_times, rel=1e-7)
    assert fed.blow_speeds == pytest.approx(plain.blow_speeds, rel=1e-7)


@pytest.mark.parametrize("law", [Kept, Reversed])
@pytest.mark.parametrize("compliance", [1.5, 6.0])
def test_elastic_motions_are_those_of_plain_integration(law: type[Kept | Reversed], compliance: float) -> None:
    """Bars that ring while the pressure follows the place where it acts; the drag is that of all modes."""
    valve = two_force(Supply(0.9, compliance), chamber=Chamber(0.05, 0.3))
    made, modes = Machine(UniformBar(6.0, External(0.1)), valve, law(0.3)), 3
    motion = run(made, Start.rigid(-0.3, 0.2), modes=modes, stop=Stop(impacts=5, periodic=False))
    now = begun(valve, -0.3, 0.2, 1.0, modes)
    follow(now, valve, 0.3, 0.1, 5, bar=piston(made, modes), turned=law is Reversed)
    own = [event for event in motion.events if event.kind in ("impact", "port", "valve")]
    for event, (time, kind, detail) in zip(own, now.events, strict=False):
        assert (event.kind, event.time) == (kind, pytest.approx(time, abs=1e-7))
        if kind == "impact":
            assert event.impact_velocity == pytest.approx(detail, rel=1e-6)
    assert motion.impacts == 5 and abs(len(own) - len(now.events)) <= 2
    assert motion.pressure([motion.blow_times[-1]])[0] == pytest.approx(now.pressure, rel=1e-7)


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=16)
def test_energy_closes(seed: int) -> None:
    rng = np.random.default_rng(seed)
    (made, start), modes = random_supplied(rng), int(rng.integers(0, 6))
    if modes:
        damping = [External(0.0), Ratio(0.3), KelvinVoigt(0.01), External(3.0)][int(rng.integers(4))]
        law = (Kept, Reversed)[int(rng.integers(2))](made.contact.restitution)
        made = replace(made, body=UniformBar(float(rng.uniform(3.0, 20.0)), damping), contact=law)
    motion = run(made, start, modes=modes, stop=Stop(impacts=8, time=40.0))
    balance = motion.energy_balance()
    size = max(abs(balance.input), abs(balance.impacts), abs(balance.stored), float(motion.energy(0.0)[0]))
    assert abs(balance.imbalance) <= 1e-10 * size


@pytest.mark.parametrize("modes", [0, 4])
def test_ensembles_are_single_motions(modes: int) -> None:
    made = Machine(UniformBar(20.0, External(0.05)), two_force(Supply(1.0, 5.0), chamber=Chamber(0.05, 0.1)), Kept(0.4))
    empty = replace(made, valve=two_force(Supply(0.02, 0.2)))
    starts, stop = [Start.rigid(-0.2), Start.rigid(-0.7, 0.3)], Stop(tolerance=1e-8)
    many = simulate_many([made, empty], starts, modes=modes, stop=stop)
    for i, (machine_of, start) in enumerate(zip([made, empty], starts, strict=True)):
        motion = run(machine_of, start, modes=modes, stop=stop)
        assert (many.label[i], many.outcome[i], many.impacts[i]) == (motion.label, motion.outcome, motion.impacts)
        period = math.nan if motion.cycle is None else motion.cycle.period
        assert many.period[i] == pytest.approx(period, rel=0.0, abs=0.0, nan_ok=True)
    assert many.label[0].startswith("runs 1/1") and many.label[1] == "stalls (without pressure)"


def test_refusals() -> None:
    made = machine(two_force(Supply(1.0, 5.0)))
    with pytest.raises(PercussError, match="without a supply"):
        run(machine(Valve({"return": -0.4, "power": 1.8}, PORTS)), modes=0, stop=Stop(impacts=1)).pressure([0.0])
    with pytest.raises(ParameterError):
        run(made, modes=0, stop=Stop(impacts=3)).pressure([math.inf])
