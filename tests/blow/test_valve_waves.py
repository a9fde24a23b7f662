"""Machines that switch their own valve by waves: against cycles of their contact law with the restitution found."""

from dataclasses import replace

import numpy as np
import pytest

from percuss.blow import Feed, Rock, Rod, Wall
from percuss.blow.periods import run_valve_by_waves
from percuss.case import load_case
from percuss.errors import ParameterError
from percuss.model import Bar, Chamber, Kept, Machine, Port, Section, Supply, Valve
from percuss.model.body import External
from percuss.steady import self_excited_motion

BAR = Bar(1.0, diameter=0.12, damping=External(0.5))
PORTS = [Port("power", 0.13, "back", 5e-3), Port("return", 0.004, "front", 5e-4)]
VALVE = Valve({"return": -13.12e3, "power": 12.48e3}, PORTS, "return", Chamber(9e3, 2e4))
Z = Section(1.3, diameter=0.14)


FEED = Feed(1.2e4, damping=6e5)


def tool(feed=FEED):
    return Rod([Z], "rock", attenuation=0.01, rock=Rock(1e9, 0.3), feed=feed)


def machine(valve=VALVE, restitution=0.15, bar=BAR):
    return Machine.from_si(bar, valve, Kept(restitution))


SUPPLY = Supply(flow=3.55e4, compliance=1e4)
WAYS = {
    "constant pressure": VALVE,
    "the blow demands": replace(VALVE, ports=(PORTS[0], Port("return", on="impact", delay=2e-3))),
    "no gas": Valve({"return": -4e3, "power": 12e3}, PORTS, "return"),
    "pump and accumulator": replace(VALVE, supply=SUPPLY),
}


@pytest.mark.parametrize("valve", WAYS.values(), ids=WAYS)
def test_the_cycle_is_that_of_the_law_with_the_restitution_of_the_waves(valve):
    """Rate, speed and supply pressure of one blow in a cycle; a blow takes time, so they agree to its share of it."""
    motion = run_valve_by_waves(machine(valve), tool(), 0.039, blows=100, cells=60)
    assert motion.outcome == "impacts"
    assert motion.label == "one blow in a cycle"
    assert motion.stands
    assert motion.left_bound < 0.01
    found = self_excited_motion(machine(valve, float(motion.restitutions.mean())), modes=0).cycle
    assert found.blows == 1
    scale = motion.machine
    assert motion.rate == pytest.approx(1.0 / (found.period * scale.time_scale), rel=1.2e-2)
    assert motion.velocities.mean() == pytest.approx(float(np.max(found.speeds)) * scale.speed_scale, rel=1.2e-2)


def test_oil_that_flows_is_that_of_its_cycle():
    """Rate, speed and input beside the cycle with modes, which has a program of its own, at the restitution found."""
    sample = load_case("oil-breaker").machine()
    rod = Rod([Section(3.0, diameter=0.12)], "rock", attenuation=0.01, rock=Rock(4e8, 0.3), feed=Feed(4e4, damping=5e5))
    motion = run_valve_by_waves(sample, rod, 0.039, blows=120, cells=60)
    assert motion.label == "one blow in a cycle"
    law = replace(sample, contact=Kept(float(motion.restitutions.mean())))
    cycle = self_excited_motion(law, modes=8).cycle
    assert motion.rate == pytest.approx(1.0 / (cycle.period * law.time_scale), rel=1e-2)
    assert motion.velocities.mean() == pytest.approx(float(np.max(cycle.speeds)) * law.speed_scale, rel=3e-3)
    power = cycle.oil.input / cycle.period * law.power_scale
    assert motion.taken / motion.time == pytest.approx(power, rel=2e-2)


def test_hardly_any_loss_is_the_lossless_machine():
    """Whose pressure follows the centre of the piston, not its driven end: they differ by its ringing."""
    supply = replace(SUPPLY, slip=1e-9)
    rates = [
        run_valve_by_waves(machine(replace(VALVE, supply=one)), tool(), 0.039, blows=60, cells=60).rate
        for one in (SUPPLY, supply)
    ]
    assert rates[1] == pytest.approx(rates[0], rel=1e-3)
    assert rates[1] != rates[0]


def test_a_tool_without_feed_is_laid_against_rock():
    motion = run_valve_by_waves(machine(), tool(None), 0.039, blows=30, cells=40)
    assert motion.stands is None
    assert motion.left_bound is None
    assert (motion.main.fed > 0.0).all()


def test_energy_from_the_supply_is_what_states_do():
    """Over the whole run, the supply and gas give what goes into the tool, drag and the striker's motion."""
    motion = run_valve_by_waves(machine(), tool(), 0.039, blows=40, cells=40)
    given = float(motion.impacts.given.sum()) * motion.units.energy
    assert given < motion.taken
    assert given > 0.8 * motion.taken


@pytest.mark.parametrize(
    ("wrong", "says"),
    [
        ({"target": Wall()}, "target"),
        ({"target": Rod([Z], "free")}, "holds"),
        ({"machine": replace(machine(), bar=None)}, "from_si"),
        ({"machine": machine(replace(VALVE, ports=(replace(PORTS[0], reads=1.0), PORTS[1])))}, "centre"),
        ({"blows": 0}, "blows"),
    ],
)
def test_what_cannot_be_followed_is_refused(wrong, says):
    with pytest.raises(ParameterError, match=says):
        run_valve_by_waves(**({"machine": machine(), "target": tool(), "gap": 0.039} | wrong))
