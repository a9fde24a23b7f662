"""The piston that switches its own valve: known numbers, closed formulas, a second program, invariances."""

from __future__ import annotations

import math
from itertools import accumulate, pairwise

import numpy as np
import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st

from machine_oracle import second
from percuss.errors import ParameterError
from percuss.mechanics.flow import ModalFlight, response
from percuss.model import Chamber, Contact, External, KelvinVoigt, Kept, Machine, Port, Reversed, UniformBar, Valve
from percuss.model.machine import machine_modes
from percuss.simulate import Start
from percuss.steady import Obstacle, SelfExcited, self_excited_motion, valve_margins
from percuss.steady.self_excited import piston_kernels as kn
from percuss.steady.self_excited.piston import BlowToBlow, Piston
from percuss.steady.self_excited.piston_flight import PistonFlight, at, first_crossing, turning_time
from percuss.steady.self_excited.self_switching import rigid_cycles


def rigid(valve: Valve, contact: Contact, drag: float = 0.0, room: float | None = None) -> SelfExcited:
    return self_excited_motion(Machine(UniformBar(20.0, External(drag)), valve, contact), modes=0, room=room)


def followed_legs(valve: Valve, contact: Contact, drag: float, behind: float, most: int = 480) -> list[BlowToBlow]:
    """From a start at rest blow by blow, until nothing follows; the slowest rebounds of a chatter are none."""
    piston = Piston(Machine(UniformBar(20.0, External(drag)), valve, contact))
    legs, greatest = [piston.leg(piston.start, behind, started=True)], 0.0
    while len(legs) < most and (rebound := legs[-1].rebound) is not None:
        row = piston.row(rebound)
        greatest = kn.settle(*piston.numbers[::2], row, greatest)
        legs.append(piston.leg(piston.rebound(row)))
    return legs


def two_force(
    back: float, power: float, port: float = 1.0, *, rear: float = 0.0, front: float | None = None, late: float = 0.0,
    kappa: float = 0.0, start: str = "return",
) -> Valve:  # fmt: skip
    """Return force and power force, a rear port with its delay, and the return at the blow or at a front port."""
    returning = Port("return", on="impact", delay=late) if front is None else Port("return", front, "front", late)
    ports = (Port("power", port, "back", rear), returning)
    return Valve({"return": -back, "power": power}, ports, start, Chamber(0.0, kappa))


def breaker(nitrogen: float = 1.0, port: float = 0.13, later: float = 0.0) -> Valve:
    """A hydraulic breaker of 88.8 kg at 160 bar, per kilogram, in metres and seconds."""
    ports = (Port("power", port, "back", 0.005), Port("return", 0.004, "front", 0.0005 + later))
    gas = Chamber(9000.0 * nitrogen / 88.8, 20000.0 * nitrogen / 88.8)
    return Valve({"return": -13120.0 / 88.8, "power": 12480.0 / 88.8}, ports, chamber=gas)


CYCLES = {
    "no delay": (
        two_force(0.4, 1.8), 0.2, 0.0, 1, 3.1489229421557638951, 2.14087209644418817, 1.2731481481481481, 0.04,
    ),
    "drag, both delays": (
        two_force(0.5, 1.6, rear=0.15, front=0.25, late=0.08), 0.25, 0.08, 1,
        3.5121810979959045353, 2.0546799684069077958, 1.545994653851901433, 0.06649251783368232,
    ),
    "return after the blow": (
        two_force(0.5, 1.0, rear=0.1, front=0.1, late=0.35), 0.6, 0.0, 1,
        4.2807878372251008618, 1.9576619964119258682, 1.9162202460977636254, 0.23004099321848745,
    ),
    "chamber, delays": (
        two_force(0.3, 1.0, rear=0.2, late=0.1, kappa=0.9), 0.5, 0.0, 1,
        2.7929453902278537393, 1.8776721119159642561, 1.1586817504557932185, 0.3094565291800671,
    ),
    "two blows": (
        two_force(0.3, 1.0, front=0.05, late=1.7), 0.5, 0.0, 2,
        5.7608905322139052961, 1.6630677164402595434, 1.3828971147329097613, 0.37511639197659885,
    ),
    "breaker": (
        breaker(), 0.15, 0.5, 1,
        0.10584793787256230694, 9.1919453843183510149, 0.16420744383220033764, 0.02791659042128028,
    ),
}  # fmt: skip
"""Valve, R, d; blows, period, greatest speed, stroke, multiplier, from flights in 40 digits."""


@pytest.mark.parametrize("case", CYCLES)
def test_cycles_known_to_many_digits(case: str) -> None:
    valve, R, d, blows, period, speed, stroke, multiplier = CYCLES[case]
    cycle = rigid(valve, Kept(R), d).cycle
    assert cycle.blows == blows
    assert cycle.period == pytest.approx(period, rel=1e-13)
    assert cycle.blow_speed == pytest.approx(speed, rel=1e-13)
    assert cycle.stroke == pytest.approx(stroke, rel=1e-13)
    assert cycle.multiplier == pytest.approx(multiplier, abs=1e-10)


def test_events_of_the_breaker() -> None:
    cycle = rigid(breaker(), Kept(0.15), 0.5).cycle
    rear, front = cycle.uncoverings
    assert (rear.port, rear.time, rear.velocity) == pytest.approx((0, 0.054550710015983217595, 3.1279382543528920911))
    assert (front.port, front.time, front.velocity) == pytest.approx((1, 0.10541029875077616, -9.0878865203787310508))
    assert [s.to for s in cycle.switches] == ["return", "power"]
    assert [s.time for s in cycle.switches] == pytest.approx([0.000062360878213853324527, 0.059550710015983217595])
    assert cycle.work == pytest.approx(42.013312585081638785, rel=1e-12)


def test_figures_of_the_breaker() -> None:
    motion = rigid(breaker(), Kept(0.15), 0.5)
    cycle = motion.cycle
    assert motion.runs and motion.starts_from_rest
    assert 88.8 * cycle.blow_energy == pytest.approx(3751.0, abs=0.5)
    assert 60.0 / cycle.period == pytest.approx(567.0, abs=0.5)
    assert cycle.swept_length * 16e-4 == pytest.approx(233.2e-6, rel=2e-4)
    assert cycle.duty == pytest.approx(0.437, abs=5e-4)
    assert 88.8 * cycle.work / cycle.period == pytest.approx(35.25e3, rel=1e-3)
    assert 88.8 * cycle.taken / cycle.period == pytest.approx(34.6e3, rel=2e-3)
    legs = followed_legs(motion.machine.valve, Kept(0.15), 0.5, 0.039, 3)
    assert list(accumulate(leg.duration for leg in legs)) == pytest.approx([0.120, 0.227, 0.333], abs=5e-4)
    assert [leg.blow_speed for leg in legs] == pytest.approx([8.78, 9.18, 9.19], abs=5e-3)


def test_the_breaker_with_a_shorter_stroke_and_with_more_nitrogen() -> None:
    short = rigid(breaker(port=0.07), Kept(0.15), 0.5).cycle
    assert (88.8 * short.blow_energy, 60.0 / short.period) == pytest.approx((2128.0, 744.0), abs=0.5)
    more = rigid(breaker(1.15), Kept(0.15), 0.5)
    assert (88.8 * more.cycle.blow_energy, 60.0 / more.cycle.period) == pytest.approx((3646.0, 546.7), abs=0.5)
    for modes in (0, 2, 24):
        starts = [self_excited_motion(rigid(breaker(gas), Kept(0.15), 0.5).machine, modes=modes) for gas in (1.0, 1.29)]
        assert [motion.starts_from_rest for motion in starts] == [True, False]
    stalled = rigid(breaker(1.34), Kept(0.15), 0.5)
    assert stalled.obstacle is Obstacle.NO_PORT
    assert stalled.found < stalled.needed == 0.13


def test_the_drifter() -> None:
    ports = (Port("power", 0.022, "back", 0.001), Port("return", 0.005, "front", 0.0005))
    motion = rigid(Valve({"return": -2040.0 / 5.05, "power": 9180.0 / 5.05}, ports), Kept(0.2), 6.0)
    cycle = motion.cycle
    assert cycle.blow_speed == pytest.approx(10.92, abs=5e-3)
    assert 5.05 * cycle.blow_energy == pytest.approx(301.0, abs=0.5)
    assert 1.0 / cycle.period == pytest.approx(61.2, abs=0.05)
    assert cycle.stroke == pytest.approx(0.0336, abs=5e-5)
    assert cycle.swept_length * 6.6e-4 / cycle.period == pytest.approx(64.8e-3 / 60.0, rel=1e-3)
    assert valve_margins(motion).latest_return == pytest.approx(1.7e-3, abs=5e-5)


def test_margins_of_the_breaker() -> None:
    margins = valve_margins(rigid(breaker(), Kept(0.15), 0.5))
    assert margins.beyond is Obstacle.DOUBLE_BLOW
    assert margins.return_time == pytest.approx(6.236e-5, rel=1e-3)
    assert margins.latest_return == pytest.approx(7.9e-3, abs=1e-4)
    assert margins.chamber_to_run == pytest.approx(1.33, abs=0.01)
    assert margins.chamber_to_start == pytest.approx(1.27, abs=0.005)


# -- closed formulas --

forces = st.tuples(st.floats(0.05, 3.0), st.floats(0.2, 3.0))
rebounds = st.floats(0.0, 0.9)


def none_or(most: float) -> st.SearchStrategy[float]:
    return st.one_of(st.just(0.0), st.floats(1e-9, most))


@given(forces, rebounds, st.floats(0.0, 0.4), st.sampled_from([Kept, Reversed]))
def test_without_delay_and_drag(pair, R, kappa, law) -> None:
    """The work theorem, and one multiplier R² whatever the chamber."""
    back, power = pair
    assume(R**2 * (2.0 * (back + power) / (1.0 - R**2)) + 2.0 * back > 1.01 * kappa)
    cycle = rigid(two_force(back, power, kappa=kappa), law(R)).cycle
    assert cycle.blow_speed**2 == pytest.approx(2.0 * (back + power) / (1.0 - R**2), rel=1e-11)
    assert cycle.multiplier == pytest.approx(R**2, abs=1e-9)
    assert cycle.swept_length == pytest.approx(1.0)


@given(forces, rebounds, st.floats(0.0, 0.5), st.floats(0.05, 0.6), st.floats(0.0, 0.3), st.floats(0.0, 0.3))
@settings(max_examples=30)
def test_the_work_of_the_switches_is_what_the_blows_take(pair, R, rear, front, late, kappa) -> None:
    motion = rigid(two_force(*pair, rear=rear, front=front, late=late, kappa=kappa), Kept(R))
    if motion.cycle is not None:
        assert motion.cycle.work == pytest.approx(motion.cycle.taken, rel=1e-9)


def test_three_states_and_a_chamber() -> None:
    """A middle state does not change the sum of jumps times distances: 47/14."""
    ports = (Port("middle", 0.5, "back"), Port("power", 1.0, "back"), Port("return", on="impact"))
    for kappa in (0.0, 0.1):
        valve = Valve({"return": -0.8, "middle": 0.2, "power": 1.0}, ports, chamber=Chamber(0.0, kappa))
        cycle = rigid(valve, Kept(0.3)).cycle
        assert cycle.blow_speed**2 * (1.0 - 0.09) == pytest.approx(2.0 * (1.0 * 0.5 + 0.8 * 1.0))
        assert [switch.to for switch in cycle.switches] == ["return", "middle", "power"]


@given(forces, rebounds, st.floats(0.0, 0.5), none_or(0.3))
@settings(max_examples=30)
def test_the_two_force_machine_with_a_delayed_rear_port(pair, R, rear, drag) -> None:
    """Multiplier R² e^{−dT} (1 + (a_r + a_p) S e^{dτ}/v_j), S = (1 − e^{−dτ})/d; period and stroke without drag."""
    back, power = pair
    motion = rigid(two_force(back, power, rear=rear), Kept(R), drag)
    cycle = motion.cycle
    assume(cycle is not None and cycle.blows == 1)
    at_port = cycle.uncoverings[0].velocity
    seen = math.expm1(drag * rear) / drag if drag > 0.0 else rear
    factor = 1.0 + (back + power) * seen / at_port
    assert cycle.multiplier == pytest.approx(R**2 * math.exp(-drag * cycle.period) * factor, rel=1e-8, abs=1e-12)
    if drag == 0.0:
        v = cycle.blow_speed
        away = at_port + back * rear
        behind = 1.0 + at_port * rear + 0.5 * back * rear**2
        assert at_port == pytest.approx(math.sqrt(R**2 * v**2 + 2.0 * back))
        assert cycle.period == pytest.approx((at_port - R * v) / back + rear + (away + v) / power, rel=1e-9)
        assert cycle.stroke == pytest.approx(behind + away**2 / (2.0 * power))
        assert cycle.duty == pytest.approx((away + v) / power / cycle.period)


@pytest.mark.parametrize(("R", "back", "sigma"), [(0.2, 0.3, 0.2), (0.5, 1.0, 0.7), (0.8, 1.0, 1.5), (0.6, 0.5, 0.4)])
def test_the_multiplier_with_a_late_return(R: float, back: float, sigma: float) -> None:
    """R² − (a_r + a_p) σ R/v, for a return due σ after the blow that orders it."""
    power = 1.0
    cycle = rigid(two_force(back, power, late=sigma), Kept(R)).cycle
    assert cycle.blows == 1
    late = R**2 - (back + power) * sigma * R / cycle.blow_speed
    assert cycle.multiplier == pytest.approx(late, abs=1e-10)


@pytest.mark.parametrize(("R", "back"), [(0.2, 0.3), (0.5, 1.0), (0.15, 0.2), (0.3, 3.0), (0.8, 0.3)])
def test_the_latest_return_before_a_double_blow(R: float, back: float) -> None:
    """σ = (Rv/a_p)(1 + √(a_r/(a_r + a_p))), where v² = 2 (a_r + a_p) S."""
    margins = valve_margins(rigid(two_force(back, 1.0), Kept(R)))
    v = math.sqrt(2.0 * (1.0 + back))
    assert margins.beyond is Obstacle.DOUBLE_BLOW
    assert margins.latest_return == pytest.approx(R * v * (1.0 + math.sqrt(back / (1.0 + back))), rel=1e-6)


@pytest.mark.parametrize(("R", "back"), [(0.8, 1.0), (0.8, 3.0), (0.8, 0.7)])
def test_the_flip_of_a_late_return(R: float, back: float) -> None:
    """σ = (1 + R²) v/((a_r + a_p) R), which comes first for (1 + q) + √(q(1 + q)) > 1 + 1/R², q = a_r/a_p."""
    assert (1.0 + back) + math.sqrt(back * (1.0 + back)) > 1.0 + 1.0 / R**2
    motion = rigid(two_force(back, 1.0), Kept(R))
    margins = valve_margins(motion)
    last = rigid(two_force(back, 1.0, late=margins.latest_return), Kept(R)).cycle
    assert margins.beyond is Obstacle.FLIP
    assert last.multiplier == pytest.approx(-1.0, abs=1e-6)
    expected = (1.0 + R**2) * last.blow_speed / ((1.0 + back) * R)
    assert margins.latest_return == pytest.approx(expected, rel=1e-6)


@given(st.floats(0.1, 1.0), st.floats(0.0, 2.2))
@settings(max_examples=20)
def test_when_a_chamber_lets_the_machine_start(back: float, kappa: float) -> None:
    """From rest it needs 2 a_r S > κS²; running it needs R²w + 2 a_r S > κS²."""
    assume(abs(2.0 * back - kappa) > 1e-6)
    motion = rigid(two_force(back, 1.0, kappa=kappa), Kept(0.5))
    running = 0.25 * 2.0 * (1.0 + back) / 0.75 + 2.0 * back
    assume(abs(running - kappa) > 1e-6)
    assert motion.runs == (running > kappa)
    assert motion.starts_from_rest == (2.0 * back > kappa)


# -- what keeps it from running --


def test_obstacles_in_their_order() -> None:
    assert rigid(two_force(0.5, 1.0), Kept(1.0)).obstacle is Obstacle.NO_LOSS
    lying = rigid(two_force(-0.1, 1.0), Kept(0.3))
    assert (lying.obstacle, lying.found, lying.needed) == (Obstacle.ON_THE_WALL, pytest.approx(0.1), 0.0)
    assert rigid(two_force(0.3, 1.0, kappa=1.5), Kept(0.5)).obstacle is Obstacle.NO_PORT
    tight = rigid(two_force(0.4, 1.8), Kept(0.2), room=1.2)
    assert (tight.obstacle, tight.needed) == (Obstacle.NO_ROOM, 1.2)
    assert tight.found == pytest.approx(1.2731481481481481)
    early = rigid(two_force(3.0, 1.0, front=1.2), Kept(0.3))
    assert early.obstacle is Obstacle.NO_BLOW and early.found > 0.0
    double = rigid(two_force(0.3, 1.0, front=0.05, late=1.7), Kept(0.5))
    assert double.obstacle is Obstacle.DOUBLE_BLOW and double.found > double.needed
    assert rigid(two_force(3.0, 1.0, front=0.02, late=0.95), Kept(0.8)).obstacle is Obstacle.FLIP
    for motion in (lying, tight, early, double):
        assert motion.obstacle.remedy in str(motion) and not motion.runs


def test_margins_ask_for_a_machine_that_runs() -> None:
    with pytest.raises(ParameterError, match="a machine that runs"):
        valve_margins(rigid(two_force(-0.1, 1.0), Kept(0.3)))


# -- the second program --

SIMULATED = {
    "start-up": (two_force(0.4, 1.8, rear=0.1), 0.3, 0.05, 0.0, 14.0),
    "chamber and drag": (two_force(0.5, 1.0, rear=0.1, front=0.1, late=0.2, kappa=0.4), 0.4, 0.1, -0.4, 14.0),
    "double blow": (two_force(0.3, 1.0, front=0.05, late=1.7), 0.5, 0.0, -1.2, 20.0),
    "an order replaced": (two_force(3.0, 1.0, front=0.02, late=0.95, start="power"), 0.8, 0.0, -0.3, 14.0),
    "speeds": (
        Valve(
            {"return": -0.4, "power": 1.8},
            [Port("power", speed=0.2, side="back", delay=0.5), Port("return", speed=1.1, side="front")],
            chamber=Chamber(0.0, 0.3),
        ),
        0.3,
        0.05,
        -0.4,
        14.0,
    ),
    "stall": (two_force(0.3, 1.0, kappa=0.9), 0.5, 0.1, -0.05, 30.0),
}


@pytest.mark.parametrize("case", SIMULATED)
def test_runs_agree_with_a_second_program(case: str) -> None:
    valve, R, d, u, until = SIMULATED[case]
    other = second(Machine(UniformBar(20.0, External(d)), valve, Kept(R)), 0, Start.rigid(u)).run(until)
    happened, until = other.events, other.time + 1e-6 if other.ending else until
    legs = followed_legs(valve, Kept(R), d, -u, 20)
    starts = [0.0, *accumulate(leg.duration for leg in legs)]
    blows = [(start, leg.blow_speed) for start, leg in zip(starts[1:], legs, strict=True) if leg.ending == kn.BLOW]
    found = [(time, speed) for time, speed in blows if time < until]
    assert np.ravel(found) == pytest.approx(
        np.ravel([(time, v) for time, kind, v in happened if kind == "impact"]), rel=1e-8
    )
    switches = [(t0 + s.time, s.to) for t0, leg in zip(starts, legs, strict=False) for s in leg.switches]
    switches = [two for one, two in pairwise([(0.0, valve.start), *switches]) if two[1] != one[1] and two[0] < until]
    expected = [(time, to) for time, kind, to in happened if kind == "valve"]
    assert [to for _, to in switches] == [to for _, to in expected]
    assert [time for time, _ in switches] == pytest.approx([time for time, _ in expected], rel=1e-8, abs=1e-9)
    assert bool(legs[-1].ending == kn.NOTHING) == (case == "stall")


def test_an_order_replaced_by_a_later_demand() -> None:
    """The rebound reaches the rear port before the return is due; numbers from flights in 40 digits."""
    valve = SIMULATED["an order replaced"][0]
    legs = followed_legs(valve, Kept(0.8), 0.0, 0.3, 3)
    times = list(accumulate(leg.duration for leg in legs))
    assert times == pytest.approx([0.77459666924148337704, 7.5319493700843622191, 11.830504673250941362], rel=1e-13)
    speeds = [0.77459666924148337704, 2.6865970644791119644, 2.1492776515832895715]
    assert [leg.blow_speed for leg in legs] == pytest.approx(speeds, rel=1e-13)


def test_blows_pile_up_and_the_piston_rests_until_the_return() -> None:
    valve = two_force(0.5, 1.0, rear=0.1, late=1.6, start="power")
    legs = followed_legs(valve, Kept(0.2), 0.0, 0.3)
    times = list(accumulate(leg.duration for leg in legs))
    known = [0.77459666924148337704, 1.0844353369380767279, 1.146403070477395398, 1.158796617185259132]
    assert times[:4] == pytest.approx(known, rel=1e-13)
    released = next(t0 + s.time for t0, leg in zip([0.0, *times], legs, strict=False) for s in leg.switches)
    assert released == pytest.approx(2.374596669241483377, rel=1e-12)


# -- invariances and limits --


@given(st.floats(0.01, 100.0), st.floats(0.01, 100.0))
@settings(max_examples=25)
def test_units_do_not_matter(length: float, time: float) -> None:
    a, k = length / time**2, 1.0 / time**2
    ports = (Port("power", length, "back", 0.15 * time), Port("return", 0.25 * length, "front", 0.08 * time))
    valve = Valve({"return": -0.5 * a, "power": 1.6 * a}, ports, chamber=Chamber(0.1 * a, 0.2 * k))
    plain = Valve(
        {"return": -0.5, "power": 1.6}, (Port("power", 1.0, "back", 0.15), Port("return", 0.25, "front", 0.08)),
        chamber=Chamber(0.1, 0.2),
    )  # fmt: skip
    scaled, one = (rigid(valve, Kept(0.25), 0.08 / time).cycle, rigid(plain, Kept(0.25), 0.08).cycle)
    assert scaled.period / time == pytest.approx(one.period, rel=1e-10)
    assert scaled.blow_speed * time / length == pytest.approx(one.blow_speed, rel=1e-10)
    assert scaled.multiplier == pytest.approx(one.multiplier, rel=1e-7)


@given(st.floats(0.0, 30.0), none_or(5.0), none_or(5.0))
def test_the_response_is_that_of_the_oscillator(t: float, stiffness: float, drag: float) -> None:
    ds, s, q, _ = response(t, stiffness, drag)
    root = np.sqrt(complex(stiffness - 0.25 * drag**2))
    angle = root * t
    exact = (np.exp(-0.5 * drag * t) * (np.sin(angle) / root if abs(angle) > 1e-8 else t)).real
    assert s == pytest.approx(exact, rel=1e-9, abs=1e-12)
    assert 1.0 - stiffness * q == pytest.approx(ds + drag * s, abs=1e-11 * (1.0 + stiffness * q))


@pytest.mark.parametrize("stiffness", [1e-90, 1e-30, 1e-12, 1e-6])
def test_a_soft_spring_turns_the_piston_where_none_would(stiffness: float) -> None:
    flight = PistonFlight(1.0, stiffness, 0.0, 1.0, -1.9375)
    assert turning_time(flight) == pytest.approx(1.9375, rel=4.0 * stiffness + 1e-15)


@given(none_or(5.0), none_or(5.0), st.lists(st.floats(0.0, 30.0), min_size=1, max_size=9))
def test_distances_at_many_times_are_those_at_each(stiffness: float, drag: float, times: list[float]) -> None:
    body, begin = UniformBar(20.0, External(drag)), np.array([[-0.4, -1.1]])
    flight = ModalFlight(modes=machine_modes(body, 0, stiffness, 0), begin=begin, force=0.3, duration=30.0)
    square = float(flight.modes.omega[0]) ** 2
    found, each = (
        -flight.at(np.array(times))[0][0],
        [at(PistonFlight(-0.3, square, drag, 0.4, 1.1), t)[0] for t in times],
    )
    scale = 1.0 + np.array(times) ** 2
    assert np.all(np.abs(found - each) <= 1e-12 * scale)


@given(
    st.floats(-1.0, 1.0), st.floats(0.0, 2.0), st.floats(0.0, 2.0), st.floats(0.0, 2.0), st.floats(-2.0, 2.0),
    st.floats(0.01, 3.0),
)  # fmt: skip
@settings(max_examples=75)
@example(1.0, 1e-214, 0.0, 1.0, -1.9375, 1.0)  # a spring that is next to none, and turns the piston all the same
def test_the_first_crossing_is_the_first(push, stiffness, drag, x, v, place) -> None:
    """Against looking at many times; of a place, and of a speed or a place."""
    flight, until = PistonFlight(push, stiffness, drag, x, v), 8.0
    time, where, way, _ = first_crossing(flight, [[place, place], [1.0, -1.0], [0.0, 0.0]], until)
    assert where == (0.0 if way < 0 and where == 0.0 else place if way else 0.0)
    times = np.linspace(0.0, until, 4001)
    seen, speeds = np.array([at(flight, float(t)) for t in times]).T
    changes = np.flatnonzero((seen[:-1] - place) * (seen[1:] - place) < 0.0)
    struck = np.flatnonzero((seen[:-1] > 0.0) & (seen[1:] < 0.0))
    first = min((times[one[0] + 1] for one in (changes, struck) if one.size), default=np.inf)
    if way == 0:
        assert first == np.inf
    else:
        assert at(flight, time)[0] == pytest.approx(where, abs=1e-9)
        assert time <= first + 1e-9
    ports = [[place, place, 0.3, 0.3], [1.0, -1.0, 1.0, -1.0], [0.0, 0.0, 1.0, 1.0]]
    both, where, way, reads = first_crossing(flight, ports, until)
    passed = np.flatnonzero((speeds[:-1] - 0.3) * (speeds[1:] - 0.3) < 0.0)
    assert (both if way else np.inf) <= min(first, times[passed[0] + 1] if passed.size else np.inf) + 1e-9
    assert at(flight, both)[1] == pytest.approx(0.3, abs=1e-9) if reads else (both, abs(way)) == (time, abs(way))


def test_a_chamber_that_turns_the_piston_before_its_port_does_not_start_it() -> None:
    """Without delay and drag a start from rest takes 2 a_r S > κS² and running R²w + 2 a_r S > κS², also close by."""
    margins = valve_margins(rigid(two_force(0.3, 1.0, kappa=1.46), Kept(0.5)))
    assert margins.chamber_to_start == pytest.approx(0.6 / 1.46, rel=1e-6)
    assert margins.chamber_to_run == pytest.approx((0.25 * 2.6 / 0.75 + 0.6) / 1.46, rel=1e-6)


def test_a_spring_that_is_hardly_there_turns_a_piston_as_none_does() -> None:
    """The angle of a swing as slow as this is not lost beside π."""
    assert turning_time(PistonFlight(1.0, 1e-60, 0.0, 1.0, -1.0)) == pytest.approx(1.0, rel=1e-12)
    assert at(PistonFlight(1.0, 1e-60, 1e-40, 1.0, -1.0), 1.0)[0] == pytest.approx(0.5)


# -- many rigid pistons at once ----------------------------------------------------------------------------------------


NO_GAS = Chamber()


def piston_machine(pull=-0.4, push=1.8, port=1.0, delay=0.3, late=0.0, restitution=0.2, drag=0.0, gas=NO_GAS, at=0.0):
    """A machine with a port on the way back, and a front port or, with `at` 0, the blow itself that calls it back."""
    back = Port("power", behind=port, side="back", delay=delay)
    front = Port("return", behind=at, side="front", delay=late) if at else Port("return", on="impact", delay=late)
    valve = Valve({"return": pull, "power": push}, [back, front], chamber=gas)
    return Machine(UniformBar(20.0, External(drag)), valve, Kept(restitution))


FAST = piston_machine().with_valve(
    Valve({"return": -0.4, "power": 1.8}, [Port("power", 1.0, "back", 0.1), Port("return", speed=1.6, side="front")])
)
"""Called back by its speed."""


def drawn(number, seed=5):
    """Machines of every kind: stiff and soft gas, weak and strong pulls, delays as long as a cycle, R from 0 to 1."""
    rng = np.random.default_rng(seed)
    for _ in range(number):
        yield piston_machine(
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
        piston_machine(),
        piston_machine(late=0.5),
        piston_machine(pull=-0.2, gas=Chamber(0.0, 1.0)),
        piston_machine(pull=0.1),
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
    valve = piston_machine(delay=0.0).valve
    found = rigid_cycles([Machine(UniformBar(20.0, KelvinVoigt(1e-4)), valve, Reversed(0.2))])
    assert found.multiplier[0] == pytest.approx(0.04, rel=1e-12)
    assert found.speed[0] ** 2 == pytest.approx(2.0 * 2.2 / (1.0 - 0.04), rel=1e-12)
