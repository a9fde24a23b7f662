"""A machine that finds no tool: energies, closed formulas, and plain integration in small steps."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from percuss.errors import ParameterError
from percuss.model import Chamber, Cushion, External, Kept, Machine, Port, Supply, UniformBar, Valve
from percuss.steady import self_excited_motion
from percuss.steady.self_excited.blank_blow import BlankBlow, blank_blow


def machine(
    cushion: Cushion | None, *, back: float = 0.4, power: float = 1.8, front: float | None = None, late: float = 0.0,
    rear: float = 0.0, drag: float = 0.0, kappa: float = 0.0, gas: float = 0.0,
) -> Machine:  # fmt: skip
    """A rear port at 1; the return is ordered by the blow, or by a front port."""
    returning = Port("return", on="impact", delay=late) if front is None else Port("return", front, "front", late)
    ports = (Port("power", 1.0, "back", rear), returning)
    valve = Valve({"return": -back, "power": power}, ports, chamber=Chamber(gas, kappa), cushion=cushion)
    return Machine(UniformBar(20.0, External(drag)), valve, Kept(0.2))


def blank(made: Machine) -> BlankBlow:
    return blank_blow(self_excited_motion(made, modes=0))


@given(st.floats(0.0, 0.5), st.floats(0.0, 20.0), st.floats(1.0, 200.0), st.floats(0.0, 0.9), st.floats(0.0, 0.3))
def test_the_cushion_takes_what_the_piston_brings_and_the_valve_adds(beyond, force, stiffness, returned, kappa) -> None:
    """Without drag, and with the power still on: E + (p − κx/2) x over the way beyond the wall."""
    found = blank(machine(Cushion(beyond, force, stiffness, returned=returned), kappa=kappa))
    brought = found.energy + (1.8 - 0.5 * kappa * found.reach) * found.reach
    assert found.depth == pytest.approx(found.reach - beyond)
    assert found.taken == pytest.approx((1.0 - returned) * brought, rel=1e-9, abs=1e-12)
    assert found.peak_force == pytest.approx(force + stiffness * found.depth)


@given(st.floats(0.1, 2.0), st.floats(0.2, 3.0), st.floats(0.05, 0.8), st.floats(0.6, 20.0))
@settings(max_examples=25)
def test_a_machine_that_goes_on_without_blows(back, power, front, held) -> None:
    """Without delays: rest at the depth z, (a_r + a_p)(S − h) from the valve in a cycle, and f z into the cushion."""
    force = held * back
    motion = self_excited_motion(machine(Cushion(force=force), back=back, power=power, front=front), modes=0)
    assume(motion.runs)
    found = blank_blow(motion)
    fed = (back + power) * (1.0 - front)
    assert found.ending == "cycles without a blow"
    assert 0.5 * found.again**2 == pytest.approx(fed * (1.0 + back / force), rel=1e-7)
    away = math.sqrt(2.0 * back * (1.0 + fed / force))  # at the rear port, from rest in the cushion
    assert found.period > away / back
    lying = fed / force
    assert found.worst_depth == pytest.approx(max(found.depth, lying), rel=1e-7)
    assert found.worst_pass == 1 or found.depth < lying
    assert found.worst_force == force and 1 <= found.worst_pass <= found.passes


@given(st.floats(0.2, 5.0), st.floats(0.5, 1.5), st.floats(5.0, 100.0), st.floats(0.0, 0.3))
@settings(max_examples=25)
def test_with_a_pump_the_pressure_is_that_of_the_cycle(nominal, flow, compliance, kappa) -> None:
    """However the forces are written: for another pressure π they are π p_k, the flow π q and the compliance π² c."""
    cushion = Cushion(0.1, 3.0, 50.0)
    made = machine(cushion, front=0.3, kappa=kappa)

    def written(for_pressure: float) -> Machine:
        supply = Supply(flow * for_pressure, compliance * for_pressure**2)
        return made.with_valve(replace(made.valve.at_pressure(for_pressure), supply=supply))

    motions = [self_excited_motion(written(one), modes=0) for one in (1.0, nominal)]
    assume(all(one.cycle is not None for one in motions))
    one, other = (blank_blow(motion) for motion in motions)
    assert other.pressure * nominal == pytest.approx(one.pressure, rel=1e-6)
    assert (other.speed, other.reach, other.taken) == pytest.approx((one.speed, one.reach, one.taken), rel=1e-6)
    assert (other.ending, other.worst_pass) == (one.ending, one.worst_pass)
    assert other.worst_depth == pytest.approx(one.worst_depth, rel=1e-6)
    if one.again is not None:
        assert (other.again, other.period) == pytest.approx((one.again, one.period), rel=1e-6)


def test_what_becomes_of_the_machine() -> None:
    stiff = Cushion(0.1, 1.0, 100.0)
    assert blank(machine(stiff)).ending == "stops in the cushion"
    assert blank(machine(None)).ending == "leaves" and blank(machine(None)).reach == math.inf
    assert blank(machine(Cushion(force=1.0))).ending == "leaves"
    short = blank(machine(Cushion(0.1, 1.0, 100.0, length=0.05)))
    assert (short.ending, short.depth) == ("strikes the front end", pytest.approx(0.05))
    assert 0.5 * short.front_speed**2 == pytest.approx(short.energy + 1.8 * 0.15 - stiff.energy(0.05))
    assert short.taken == pytest.approx(stiff.energy(0.05))
    weak = blank(machine(None, front=0.3))
    assert weak.depth == weak.peak_force == weak.taken == 0.0
    assert weak.reach == pytest.approx(weak.energy / 0.4)
    swinging = blank(machine(None, kappa=0.5, gas=-0.1, drag=0.3))
    assert swinging.ending == "stops" and math.isfinite(swinging.reach)
    assert blank(machine(stiff, front=0.3)).passes > 3


def test_a_late_return_meets_the_piston_in_the_cushion() -> None:
    """The power holds it there, and lets it go when the return is due."""
    made = machine(Cushion(0.0, 1.0, 200.0), front=0.3, late=0.3)
    found = blank(made)
    assert found.ending == "cycles without a blow"
    assert found.reach == pytest.approx(stepped(made, 1)[0], abs=2e-3)


@given(
    st.floats(0.1, 2.0), st.floats(0.3, 2.0), st.floats(0.1, 0.6), st.floats(0.0, 1.5), st.floats(0.0, 0.4),
    st.floats(0.0, 0.3), st.floats(0.0, 0.2), st.floats(1.0, 100.0), st.floats(0.0, 1.0),
)  # fmt: skip
@settings(max_examples=12)
def test_against_small_steps(back, power, front, late, rear, drag, beyond, stiffness, returned) -> None:
    cushion = Cushion(beyond, 2.5 * power, stiffness, returned=returned)
    made = machine(cushion, back=back, power=power, front=front, late=late, rear=rear, drag=drag, kappa=0.1)
    assume(self_excited_motion(made, modes=0).runs)
    found = blank(made)
    reach, again = stepped(made, 2)
    assert found.reach == pytest.approx(reach, abs=3e-3)
    if again is not None and found.period is not None and found.passes == 4:
        assert found.again == pytest.approx(again, rel=0.02)


def stepped(made: Machine, passes: int, step: float = 5e-4) -> tuple[float, float | None]:
    """How far the piston goes beyond the wall at first, and its speed when it comes again."""
    valve, cushion = made.valve, made.valve.cushion
    cycle = self_excited_motion(made, modes=0).cycle
    state, orders = cycle.rebound.state, cycle.rebound.orders
    u, v, t, reach, met = 0.0, cycle.blow_speed, 0.0, 0.0, 1
    while t < 40.0:
        for at, to in [order for order in orders.pending if order[0] <= t]:
            state, orders = to, type(orders)(orders.last, tuple(o for o in orders.pending if o != (at, to)))
        depth = u - cushion.beyond
        held = cushion.force + cushion.stiffness * depth if depth > 0.0 else 0.0
        push = valve.force(state) - valve.chamber.stiffness * u - made.drag * v
        back = held if v > 0.0 else cushion.returned * held
        if v == 0.0 and depth > 0.0:
            back = min(max(push, cushion.returned * held), held)
        before, speed = u, v
        v += step * (push - back)
        v = 0.0 if speed * v < 0.0 and depth > 0.0 else v
        u, t = u + step * 0.5 * (speed + v), t + step
        reach = max(reach, u) if met == 1 else reach
        for port in valve.ports:
            edge = -port.behind
            if (before >= edge > u) if port.side == "back" else (before <= edge < u):
                orders = orders.after(t, port)
        if before < 0.0 <= u:
            met += 1
            if met == passes:
                return reach, v
    return reach, None


def test_what_is_refused() -> None:
    with pytest.raises(ParameterError, match="modes=0"):
        blank_blow(self_excited_motion(machine(None, back=-0.1), modes=0))
    for wrong in ({"beyond": -0.01}, {"force": -1.0}, {"stiffness": -1.0}, {"length": 0.0}, {"returned": 1.5}):
        with pytest.raises(ParameterError):
            Cushion(**wrong)
    with pytest.raises(ParameterError):
        machine(3.0)
