"""Machines that rest on the wall: the energy of lying down, and what repeats itself without reaching a port."""

from __future__ import annotations

import pytest

from percuss.model import Chamber, External, Kept, Machine, Port, Reversed, UniformBar, Valve
from percuss.simulate import Stop, run
from percuss.steady import self_excited_motion


def late(law: type, R: float, delay: float, kappa: float = 0.0, d: float = 0.05, force: float = 0.1) -> Machine:
    ports = (Port("power", 1.0, "back", 0.1), Port("return", on="impact", delay=delay))
    valve = Valve({"return": -0.6, "power": 1.2}, ports, chamber=Chamber(force, kappa))
    return Machine(UniformBar(5.0, External(d)), valve, law(R))


@pytest.mark.parametrize("law", [Kept, Reversed])
@pytest.mark.parametrize("kappa", [0.0, 0.2])
@pytest.mark.parametrize("R", [0.0, 0.1])
def test_the_energy_of_rests_closes_and_is_that_of_the_cycle(law: type, kappa: float, R: float) -> None:
    machine = late(law, R, 2.5, kappa)
    motion = run(machine, modes=4, stop=Stop(impacts=60))
    rests = motion.events.of("rest")
    assert motion.label.startswith("runs with rest") and len(rests) > 1
    balance = motion.energy_balance(motion.begin_time, motion.events.time[-1])
    assert balance.imbalance == pytest.approx(0.0, abs=1e-9 * balance.input)
    last = motion.energy_balance(rests.time[-2], rests.time[-1])
    assert last.imbalance == pytest.approx(0.0, abs=1e-9 * last.input)
    assert 0.0 <= last.rests <= last.impacts
    if law is Kept:
        assert last.rests > 1e-8 * last.input
    if R == 0.0:
        cycle = self_excited_motion(machine, modes=4).cycle
        assert cycle.rests
        assert last.rests == pytest.approx(cycle.taken_by_rest, rel=1e-7, abs=1e-12)
        assert last.impacts == pytest.approx(cycle.taken + cycle.taken_by_rest, rel=1e-7)
        assert last.input == pytest.approx(cycle.work, rel=1e-7)


@pytest.mark.parametrize("modes", [1, 3, 8])
@pytest.mark.parametrize("d", [0.0, 0.05])
def test_a_bar_that_forgets_everything_and_reaches_no_port_stalls(modes: int, d: float) -> None:
    """The law that turns strain over leaves nothing at R = 0: each release begins the same swing on the gas anew."""
    ports = (Port("power", 1.0, "back", 0.1), Port("return", on="impact"))
    valve = Valve({"return": -0.3, "power": 1.0}, ports, chamber=Chamber(0.0, 1.0))
    motion = run(Machine(UniformBar(5.0, External(d)), valve, Reversed(0.0)), modes=modes, stop=Stop(impacts=200))
    assert motion.label == "stalls (in the chamber)"
    assert not len(motion.events.of("valve"))
    assert not len(motion.blow_times) or motion.impacts == 200
    runs = Machine(
        UniformBar(5.0, External(d)), Valve(dict(valve.pairs), ports, chamber=Chamber(0.0, 0.3)), Reversed(0.0)
    )
    assert run(runs, modes=modes).label == "runs with rest 1/1"
