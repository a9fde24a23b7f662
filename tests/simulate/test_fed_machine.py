"""Simulated machines that a pump and an accumulator feed: a second program, the steady cycle, books, ends."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from percuss.errors import ParameterError, PercussError
from percuss.model import Chamber, External, Kept, Machine, Port, Supply, UniformBar, Valve
from percuss.simulate import Start, Stop, run, simulate_many
from percuss.steady import self_excited_motion

PORTS = (Port("power", 1.0, "back", 0.1), Port("return", on="impact"))


def machine(valve: Valve, R: float = 0.3, drag: float = 0.0) -> Machine:
    return Machine(UniformBar(20.0, External(drag)), valve, Kept(R))


def two_force(supply: Supply, back: float = 0.4, power: float = 1.8, chamber: Chamber | None = None) -> Valve:
    return Valve({"return": -back, "power": power}, PORTS, None, chamber or Chamber(), supply=supply)


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


def test_a_great_accumulator_is_a_constant_pressure() -> None:
    constant = Valve({"return": -0.4, "power": 1.8}, PORTS)
    start, stop = Start.rigid(-0.3), Stop(impacts=6, periodic=False)
    fed = run(machine(two_force(Supply(1.0, 1e9))), start, modes=0, stop=stop)
    plain = run(machine(constant), start, modes=0, stop=stop)
    assert fed.blow_times == pytest.approx(plain.blow_times, rel=1e-7)
    assert fed.blow_speeds == pytest.approx(plain.blow_speeds, rel=1e-7)


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
