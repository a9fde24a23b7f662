"""Many rigid pistons at once, compiled, against the closed form of each: what they do, and figures of their cycles."""

import numpy as np
import pytest

from percuss.model import Chamber, External, KelvinVoigt, Kept, Machine, Port, Reversed, UniformBar, Valve
from percuss.steady import self_excited_motion
from percuss.steady.self_excited.many_pistons import rigid_cycles
from percuss.steady.self_excited.self_switching import Obstacle

NO_GAS = Chamber()


def breaker(pull=-0.4, push=1.8, port=1.0, delay=0.3, late=0.0, restitution=0.2, drag=0.0, gas=NO_GAS, at=0.0):
    """A machine with a port on the way back, and a front port or, with `at` 0, the blow itself that calls it back."""
    back = Port("power", behind=port, side="back", delay=delay)
    front = Port("return", behind=at, side="front", delay=late) if at else Port("return", on="impact", delay=late)
    valve = Valve({"return": pull, "power": push}, [back, front], chamber=gas)
    return Machine(UniformBar(20.0, External(drag)), valve, Kept(restitution))


FAST = breaker().with_valve(
    Valve({"return": -0.4, "power": 1.8}, [Port("power", 1.0, "back", 0.1), Port("return", speed=1.6, side="front")])
)
"""Called back by its speed."""


def drawn(number, seed=5):
    """Machines of every kind: stiff and soft gas, weak and strong pulls, delays as long as a cycle, R from 0 to 1."""
    rng = np.random.default_rng(seed)
    for _ in range(number):
        yield breaker(
            pull=-(10.0 ** rng.uniform(-1.5, 0.5)),
            push=rng.uniform(-0.05, 2.0),
            port=rng.uniform(0.06, 1.5),
            delay=rng.choice([0.0, 0.3, 10.0 ** rng.uniform(-6.0, 0.7)]),
            late=rng.choice([0.0, 10.0 ** rng.uniform(-4.0, 0.6)]),
            restitution=rng.choice([0.0, 1.0, rng.uniform(0.0, 1.0)]),
            drag=rng.choice([0.0, 10.0 ** rng.uniform(-3.0, 1.0)]),
            at=rng.choice([0.0, 0.05]),
            gas=Chamber(rng.choice([0.0, 0.2]), rng.choice([0.0, 10.0 ** rng.uniform(-3.0, 1.0)])),
        )


def test_each_is_what_the_closed_form_of_it_says():
    machines = [
        breaker(),
        breaker(late=0.5),
        breaker(pull=-0.2, gas=Chamber(0.0, 1.0)),
        breaker(pull=0.1),
        FAST,
        *drawn(25),
    ]
    rooms = [None if i % 3 else 1.2 for i in range(len(machines))]
    found = rigid_cycles(machines, rooms, starts=True)
    assert found.answered.all()
    met = set()
    for i, (machine, room) in enumerate(zip(machines, rooms, strict=True)):
        alone = self_excited_motion(machine, modes=0, room=room)
        assert found.obstacles[i] is alone.obstacle, (i, alone)
        met.add(alone.obstacle)
        cycle = alone.cycle
        assert found.starts[i] == alone.starts_from_rest
        if cycle is None or cycle.blows > 1:
            continue
        wanted = (
            cycle.period, cycle.blow_speed, cycle.main_energy, cycle.stroke, cycle.work, cycle.taken, cycle.duty,
            abs(cycle.multiplier),
        )  # fmt: skip
        numbers = (
            found.period, found.speed, found.energy, found.stroke, found.work, found.taken, found.duty,
            found.multiplier,
        )  # fmt: skip
        np.testing.assert_allclose([number[i] for number in numbers], wanted, rtol=1e-9, atol=1e-11)
    assert {
        None,
        Obstacle.NO_PORT,
        Obstacle.DOUBLE_BLOW,
        Obstacle.ON_THE_WALL,
        Obstacle.NO_ROOM,
        Obstacle.NO_LOSS,
    } <= met, met


def test_with_more_orders_under_way_than_it_holds_it_gives_no_answer():
    """Twenty ports that demand in turn, each long before its order is due, at the blow and on the way back."""
    ports = [Port("ab"[i % 2], behind=0.02 + 0.01 * i, side="back", delay=50.0 + i) for i in range(20)]
    machine = Machine(UniformBar(20.0), Valve({"b": -0.4, "a": 1.8}, [*ports, Port("b", on="impact")]), Kept(0.2))
    found = rigid_cycles([machine, machine])
    assert not found.answered.any() and np.isnan(found.period).all()


def test_none_and_one_without_drag_by_another_law_of_damping():
    assert rigid_cycles([]).obstacles == ()
    valve = breaker(delay=0.0).valve
    found = rigid_cycles([Machine(UniformBar(20.0, KelvinVoigt(1e-4)), valve, Reversed(0.2))])
    assert found.multiplier[0] == pytest.approx(0.04, rel=1e-12)
    assert found.speed[0] ** 2 == pytest.approx(2.0 * 2.2 / (1.0 - 0.04), rel=1e-12)
