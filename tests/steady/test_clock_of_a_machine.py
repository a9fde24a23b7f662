"""The force that a machine has made itself, as the load of a clock: the same motion, and another verdict (B77 14)."""

from __future__ import annotations

import math

import numpy as np
import pytest

from percuss import Load, System, stability_of, steady_states
from percuss.model import Chamber, External, Kept, Machine, Port, Ratio, Reversed, UniformBar, Valve
from percuss.stability import floquet_multipliers
from percuss.steady import Orbit, ValveCycle, self_excited_motion


def machine(late: float, *, R: float = 0.3, back: float = 0.6) -> Machine:
    """A machine whose return comes so late after the blow, or, where that is negative, at a port before it."""
    returning = Port("return", on="impact", delay=late) if late >= 0.0 else Port("return", -late, "front")
    valve = Valve({"return": -back, "power": 1.4}, (Port("power", 1.0, "back", 0.1), returning))
    return Machine(UniformBar(20.0, External(0.02)), valve, Reversed(R))


def clocked(asked: Machine, cycle: ValveCycle, modes: int) -> tuple[Orbit, float]:
    """The steady motion under the force history of a cycle whose blow is nearest to its own; and 2π/T."""
    rate = 2.0 * math.pi / cycle.period
    forces = dict(asked.valve.pairs)
    starts = [switch.time for switch in cycle.switches]
    states = [switch.to for switch in cycle.switches]
    if starts[0] > 0.0:
        starts, states = [0.0, *starts], [states[-1], *states]
    load = Load.steps([rate * t for t in starts], [forces[name] / rate**2 for name in states])
    system = System(UniformBar(asked.body.s / rate, External(0.02 / rate)), load, asked.contact)
    orbits = steady_states(system, modes=modes).orbits
    return min(orbits, key=lambda orbit: 1.0 - math.cos(orbit.phase)), rate


@pytest.mark.parametrize("modes", [0, 6])
@pytest.mark.parametrize("late", [-0.3, -0.1, 0.1, 0.3])
def test_a_clock_drives_the_same_motion(late: float, modes: int) -> None:
    asked = machine(late)
    cycle = self_excited_motion(asked, modes=modes).cycle
    orbit, rate = clocked(asked, cycle, modes)
    assert math.remainder(orbit.phase, 2.0 * math.pi) == pytest.approx(0.0, abs=1e-7)
    assert orbit.impact_velocity * rate == pytest.approx(cycle.blow_speed, rel=1e-8)


@pytest.mark.parametrize("late", [-0.3, -0.1, 0.1, 0.3])
def test_a_clock_does_not_wait_for_a_late_blow(late: float) -> None:
    """Two multipliers of the product R²e^{−dT} instead of one; after the blow the load pushes more than its mean."""
    asked = machine(late)
    cycle = self_excited_motion(asked, modes=0).cycle
    orbit, _ = clocked(asked, cycle, 0)
    found = floquet_multipliers(orbit, 0).values
    assert found.size == 2
    assert np.prod(found).real == pytest.approx(0.3**2 * math.exp(-0.02 * cycle.period), rel=1e-9)
    assert abs(cycle.multiplier) < 1.0
    assert np.abs(found - cycle.multiplier).min() > 0.01
    assert stability_of(orbit, modes=0).stable == (np.abs(found).max() < 1.0)
    if late > 0.0:
        assert not stability_of(orbit, modes=0).stable and found.real.max() > 2.0


@pytest.mark.parametrize(("R", "stable"), [(0.05, True), (0.5, False)])
def test_an_early_return_turns_unstable_under_a_clock_alone(R: float, stable: bool) -> None:
    """A clocked motion needs p(φ)/p_0 > −((1 − R)/(1 + R))², with hardly any drag; the machine runs on both sides."""
    asked = machine(-0.3, R=R, back=0.15)
    cycle = self_excited_motion(asked, modes=0).cycle
    orbit, _ = clocked(asked, cycle, 0)
    mean = (1.0 + R) * cycle.blow_speed / cycle.period
    assert stability_of(orbit, modes=0).stable == stable == (-0.15 / mean > -(((1.0 - R) / (1.0 + R)) ** 2))
    assert cycle.stable


# -- limits --


@pytest.mark.parametrize("modes", [0, 4])
@pytest.mark.parametrize("law", [Kept, Reversed])
@pytest.mark.parametrize("what", ["delay of the return", "delay of the power", "gas", "force of the gas", "drag"])
def test_delays_and_gas_vanish_smoothly(what: str, law: type, modes: int) -> None:
    """A tenth of either changes period, speed and rhythm a tenth as much."""

    def figures(small: float) -> np.ndarray:
        late = {what: small}
        ports = (
            Port("power", 1.0, "back", late.get("delay of the power", 0.0)),
            Port("return", 0.1, "front", late.get("delay of the return", 0.0)),
        )
        damping = External(small) if what == "drag" else Ratio(0.2)
        gas = Chamber(late.get("force of the gas", 0.0), late.get("gas", 0.0))
        valve = Valve({"return": -0.6, "power": 1.4}, ports, chamber=gas)
        cycle = self_excited_motion(Machine(UniformBar(20.0, damping), valve, law(0.2)), modes=modes).cycle
        return np.array([cycle.period, cycle.blow_speed, cycle.stroke, cycle.rhythm_multiplier.real])

    none = figures(0.0)
    far, near = (np.abs(figures(small) - none) for small in (1e-4, 1e-5))
    assert far.max() > 1e-7
    assert near == pytest.approx(0.1 * far, rel=0.02, abs=1e-9)
