"""What is told of a machine's cycle: energy, rhythm and ringing, what a clock would make of its force; crossings."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from percuss import Load, System, stability_of, steady_states
from percuss.mechanics.crossing import Regions, clearances, first_entering
from percuss.mechanics.flow import ModalFlight
from percuss.model import (
    Chamber,
    Damping,
    External,
    KelvinVoigt,
    Kept,
    Machine,
    MachineModes,
    Port,
    Ratio,
    Reversed,
    SteppedBar,
    Table,
    UniformBar,
    Valve,
)
from percuss.stability import floquet_multipliers
from percuss.steady import Obstacle, Orbit, ValveCycle, self_excited_motion
from percuss.steady.self_excited.self_switching import rigid_cycles
from percuss.steady.self_excited.valve_cycle import parted

NODES, WEIGHTS = np.polynomial.legendre.leggauss(20)


def damped(cycle: ValveCycle) -> float:
    """∫ Σ d_n v_n² dt over the flights, by Gauss's rule on panels that resolve every wave and what dies out."""
    total = 0.0
    for flight in cycle.flights:
        fastest, d = float(flight.modes.omega.max()), float(flight.modes.damping.max())
        edges = np.linspace(0.0, flight.duration, 2 + int(flight.duration * fastest / 3.0))
        dying = (1.0 / d if d > 1e-100 else flight.duration) * 1.6 ** np.arange(40)
        edges = np.unique(np.concatenate([edges, dying[dying < flight.duration]]))
        wide = 0.5 * np.diff(edges)[:, None]
        velocity = flight.at((edges[:-1, None] + wide * (1.0 + NODES)).ravel())[1]
        total += float((wide * WEIGHTS).ravel() @ (flight.modes.damping @ velocity**2))
    return total


def imbalance(cycle: ValveCycle) -> float:
    """Of the energy of a cycle, as a part of it."""
    spent = cycle.taken + damped(cycle) + cycle.taken_by_rest
    return abs(cycle.work - spent) / max(cycle.work, spent, float(cycle.blow_energies.max()))


def late(
    law: type, R: float, damping: Damping, delay: float, kappa: float, force: float, s: float = 5.0, reads: object = 0.0
) -> Machine:
    """The order of the blow comes after it, so that the bar lies on the wall where it does not rebound."""
    ports = (Port("power", 1.0, "back", 0.1, reads), Port("return", on="impact", delay=delay))
    return Machine(
        UniformBar(s, damping), Valve({"return": -0.6, "power": 1.2}, ports, chamber=Chamber(force, kappa)), law(R)
    )


dampings = st.one_of(
    st.sampled_from([External(0.0), Ratio(1.0), Table((0.05, 10.0))]),
    st.builds(External, st.floats(0.0, 5.0)), st.builds(Ratio, st.floats(0.0, 1.0)),
    st.builds(KelvinVoigt, st.floats(0.0, 0.1)),
)  # fmt: skip
forces = st.floats(-0.2, 0.3).map(lambda force: force if abs(force) >= 1e-100 else 0.0)  # smaller ones are refused
machines = st.builds(
    late, st.sampled_from([Kept, Reversed]), st.one_of(st.just(0.0), st.floats(0.0, 0.5)), dampings,
    st.floats(0.0, 3.0), st.sampled_from([0.0, 1e-9, 0.2]), forces, st.floats(2.0, 12.0),
    st.sampled_from(["centre", 0.0, 0.4, 1.0]),
)  # fmt: skip


@given(machines, st.sampled_from([1, 2, 4]))
@settings(max_examples=12)
def test_the_energy_of_a_cycle_closes(asked: Machine, modes: int) -> None:
    cycle = self_excited_motion(asked, modes=modes).cycle
    assume(isinstance(cycle, ValveCycle))
    assert imbalance(cycle) <= 1e-9
    assert cycle.taken_by_rest >= 0.0
    assert cycle.rests or cycle.taken_by_rest == 0.0


@pytest.mark.parametrize("kappa", [0.0, 0.2])
def test_what_is_lost_on_lying_down_is_the_strain_that_the_blow_left(kappa: float) -> None:
    """Without restitution no motion is left, and a law that keeps the strain leaves all of it, that of the gas too."""
    cycle = self_excited_motion(late(Kept, 0.0, External(0.05), 0.4, kappa, 0.1), modes=4).cycle
    assert cycle.rests and cycle.blows == 1
    assert cycle.taken_by_rest == pytest.approx(cycle.struck[0].strain, rel=1e-12)
    assert cycle.taken_by_rest > 1e-4 * cycle.work
    assert self_excited_motion(late(Reversed, 0.0, External(0.05), 0.4, kappa, 0.1), modes=4).cycle.taken_by_rest == 0.0


# -- the rigid piston --


def two_force(R: float, kappa: float = 0.0) -> Machine:
    ports = (Port("power", 1.0, "back", 0.2), Port("return", 0.05, "front", 0.3))
    return Machine(UniformBar(20.0), Valve({"return": -0.5, "power": 1.6}, ports, chamber=Chamber(0.0, kappa)), Kept(R))


@given(st.one_of(st.sampled_from([5e-324, 1e-308, 1e-161, 1e-154, 1e-30]), st.floats(0.0, 1e-16, exclude_max=True)))
@settings(max_examples=8)
def test_a_rebound_too_slow_for_numbers_is_none(R: float) -> None:
    """A hop whose height is no number would lead through the wall."""
    for kappa in (0.0, 0.2):
        cycle = self_excited_motion(two_force(R, kappa), modes=0).cycle
        at_rest = self_excited_motion(two_force(0.0, kappa), modes=0).cycle
        assert (cycle.period, cycle.work, cycle.blows) == (at_rest.period, at_rest.work, at_rest.blows)
        assert cycle.rests and cycle.position(np.linspace(0.0, cycle.period, 200)).max() <= 0.0
        assert rigid_cycles([two_force(R, kappa)]).period[0] == pytest.approx(at_rest.period, rel=1e-12)


def test_a_swing_that_ends_at_the_wall_is_no_blow() -> None:
    """Every order is overtaken: the gas alone brings the piston back, to where it began, and nothing puts energy in."""
    ports = (
        Port("power", 0.5675020999910239, "back", 2.120842501376818),
        Port("return", 0.21201359689662821, "front", 0.24525621973584993),
        Port("return", 1.2713136047432443, "back", 0.22484852583793893),
    )
    chamber = Chamber(0.32735206070979667, 0.6574587945827829)
    valve = Valve({"return": -1.647943354436335, "power": 2.5653826082350024}, ports, chamber=chamber)
    machine = Machine(UniformBar(20.0), valve, Kept(9.322542286550017e-08))
    motion = self_excited_motion(machine, modes=0)
    assert motion.cycle is None and motion.obstacle not in (None, Obstacle.NO_LOSS)
    assert rigid_cycles([machine]).obstacles[0] is not None


def test_a_flight_far_out_on_a_soft_gas_brings_back_its_energy() -> None:
    """Out to 10⁹ and back: the speed at the wall follows from the energy, not from the time of the flight."""
    ports = (
        Port("power", 0.6915756845346164, "back"),
        Port("return", 0.026280872338057065, "front", 1.645651197900760),
    )
    valve = Valve({"return": -0.0888135288, "power": 0.188577350327}, ports, chamber=Chamber(-0.2, 1.46e-11))
    machine = Machine(UniformBar(20.0), valve, Kept(0.0))
    cycle = self_excited_motion(machine, modes=0).cycle
    assert cycle.stroke > 1e8
    assert cycle.work == pytest.approx(cycle.taken, rel=1e-12)
    found = rigid_cycles([machine])
    assert found.work[0] == pytest.approx(found.taken[0], rel=1e-12)


# -- rhythm and ringing of an elastic machine -------------------------------------------------------------------------


PORTS = (Port("power", 1.0, "back", 0.1), Port("return", 0.1, "front", 0.05))


def at_the_node(s: float, d: float, R: float, kappa: float) -> Machine:
    """A machine whose load acts in the middle, where the first mode has its node."""
    body = SteppedBar(s, (1.0, 1.0), (1.0, 1.0), External(d))
    valve = Valve({"return": -0.6, "power": 1.4}, PORTS, chamber=Chamber(0.0, kappa))
    return Machine(body, valve, Reversed(R), at=1)


@given(st.floats(2.0, 60.0), st.floats(0.0, 0.3), st.floats(0.05, 0.7), st.sampled_from([0.0, 0.1, 0.3]))
@settings(max_examples=15)
def test_a_mode_that_is_not_excited_rings_by_itself(s: float, d: float, R: float, kappa: float) -> None:
    """Each blow multiplies it by −R, each flight turns and damps it; the rhythm is that of the rigid piston."""
    asked = at_the_node(s, d, R, kappa)
    cycle, rigid = (self_excited_motion(asked, modes=modes).cycle for modes in (1, 0))
    assert cycle.ringing.mode == 1
    turned = math.sqrt((math.pi * s) ** 2 - 0.25 * d**2) * cycle.period
    expected = -R * math.exp(-0.5 * d * cycle.period) * complex(math.cos(turned), abs(math.sin(turned)))
    assert cycle.ringing.multiplier == pytest.approx(expected.real + 1j * abs(expected.imag), rel=1e-8)
    assert cycle.ringing.shares[0].share == pytest.approx(1.0, abs=1e-6)
    assert cycle.ringing.decay == pytest.approx(-1.0 / math.log(abs(expected)), rel=1e-8)
    if abs(rigid.multiplier) > 1e-6:  # below it the rhythm is as good as found again at once
        assert cycle.rhythm_multiplier == pytest.approx(rigid.multiplier, rel=1e-8, abs=1e-10)
    assert rigid.ringing is None and rigid.rhythm_multiplier == rigid.multiplier


@pytest.mark.parametrize("law", [Kept, Reversed])
def test_rhythm_and_ringing_are_all_there_is(law: type) -> None:
    """The greatest multiplier is the greater of the two, and the rhythm of a stiff bar that of the rigid piston."""
    for s in (20.0, 200.0):
        asked = Machine(UniformBar(s, Ratio(0.1)), Valve({"return": -0.6, "power": 1.4}, PORTS), law(0.3))
        cycle, rigid = (self_excited_motion(asked, modes=modes).cycle for modes in (6, 0))
        told = [abs(cycle.rhythm_multiplier), *([abs(cycle.ringing.multiplier)] if cycle.ringing else [])]
        assert max(told) == pytest.approx(abs(cycle.multiplier), rel=1e-9)
        assert cycle.rhythm_multiplier == pytest.approx(rigid.multiplier, abs=2.0 / s)
        if cycle.ringing is not None:
            assert sum(one.share for one in cycle.ringing.shares) == pytest.approx(1.0)
            assert "Ringing: mode" in str(cycle.ringing)


def test_a_bar_that_rests_has_no_ringing() -> None:
    ports = (PORTS[0], Port("return", 0.1, "front", 1.5))
    asked = Machine(UniformBar(20.0, External(0.05)), Valve({"return": -0.3, "power": 1.0}, ports), Reversed(0.0))
    cycle = self_excited_motion(asked, modes=4).cycle
    assert cycle.rests and cycle.ringing is None and cycle.multiplier == 0.0


@pytest.mark.parametrize("pending", [0, 2])
def test_shares_are_what_a_mode_changes_a_multiplier_by(pending: int) -> None:
    """Pérez-Arriaga: the derivative of an eigenvalue by what is added to the diagonal; the units do not matter."""
    modes, size = 3, 8 + pending
    matrix = np.random.default_rng(7).normal(size=(size, size)) / 4.0
    matrix[:2, :2] += np.diag([2.0, 1.0])  # told apart
    rhythm, ringing = parted(matrix, modes)
    rows = np.eye(size)
    own = [[rows[2 * mode] + rows[2 * mode + 1]] for mode in range(modes + 1)]
    own[0] += list(rows[8:])
    parts = [sum(abs(_moved(matrix, one, ringing.multiplier, 1e-6)) for one in ones) for ones in own]
    expected = np.array(parts) / sum(parts)
    assert [expected[one.mode] for one in ringing.shares] == pytest.approx(
        [one.share for one in ringing.shares], abs=1e-6
    )
    assert np.abs(np.linalg.eigvals(matrix) - rhythm).min() < 1e-9
    scale = np.repeat(np.geomspace(1.0, 1e4, size // 2), 2)
    again = parted(matrix * scale[:, None] / scale, modes)
    assert again.ringing.multiplier == pytest.approx(ringing.multiplier)
    assert [one.share for one in again.ringing.shares] == pytest.approx([one.share for one in ringing.shares])


def _moved(matrix: np.ndarray, own: np.ndarray, value: complex, step: float) -> complex:
    ends = [np.linalg.eigvals(matrix + sign * step * np.diag(own)) for sign in (1.0, -1.0)]
    near = [values[np.argmin(np.abs(values - value))] for values in ends]
    return complex(near[0] - near[1]) / (2.0 * step)


# -- the force of a machine as the load of a clock ---------------------------------------------------------------------


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


# -- the first region that is entered in a flight ----------------------------------------------------------------------


SPAN = 6.0
numbers = st.floats(-2.0, 2.0)


@given(
    st.lists(st.tuples(st.floats(0.1, 9.0), st.floats(0.0, 1.0), numbers, numbers, numbers), min_size=1, max_size=3),
    st.lists(st.tuples(st.floats(0.2, 3.0), numbers), min_size=1, max_size=3),
    st.sampled_from([0.0, 1e-3, 1.0]), numbers,
)  # fmt: skip
@settings(max_examples=60)
def test_the_first_entering_is_the_first(coordinates, edges, stiffness, ramp) -> None:
    omega, damping, place, speed, row = np.array(coordinates).T
    omega[0] *= stiffness
    modes = MachineModes(omega, damping, np.ones(omega.size), np.ones(omega.size), np.eye(omega.size))
    flight = ModalFlight(modes=modes, begin=np.stack([place, speed], axis=1), force=0.3, duration=SPAN, ramp=ramp)
    above, drifts = np.array(edges).T
    rows = np.outer(np.linspace(1.0, 0.3, above.size), row)
    levels = rows @ place + above
    found = first_entering(flight, Regions(rows, levels, 1.0, drifts))
    times = np.linspace(0.0, SPAN, 4001)
    r = rows @ flight.at(times)[0] - levels[:, None] - drifts[:, None] * times
    inside = times[(r > 1e-9).any(axis=0)]
    assert found.proven
    assert found.time <= (inside[0] if inside.size else np.inf)
    if np.isfinite(found.time):
        at = rows @ flight.at(np.array([found.time]))[0][:, 0] - levels - drifts * found.time
        assert at[found.which] == pytest.approx(0.0, abs=1e-9)
        assert (r[:, times < found.time] < 1e-9).all()
    apart = clearances(flight, Regions(rows, levels, 1.0, drifts), -1)
    for k, far in enumerate(apart.tolist()):
        alone = first_entering(flight, Regions(rows[k : k + 1], levels[k : k + 1], 1.0, drifts[k : k + 1]))
        assert (far < 0.0) == (alone.time < np.inf) or abs(far) < 1e-9
    rates = rows @ flight.at(times)[1] - drifts[:, None]
    for far, y, rate in zip(apart.tolist(), r, rates, strict=True):  # where no look hides two turns
        size, turns = np.abs(rate), np.flatnonzero(rate[:-1] * rate[1:] < 0.0)
        calm = np.flatnonzero((size[1:-1] < size[:-2]) & (size[1:-1] < size[2:])) + 1
        if np.all((size[calm] > 1e-2 * size.max()) | np.isin(calm, turns) | np.isin(calm - 1, turns)):
            tops = y[turns] + 0.5 * rate[turns] ** 2 / (rate[turns] - rate[turns + 1]) * times[1]
            levels = np.concatenate([y[:1], tops, y[-1:]])
            rises = np.maximum(levels[:-1], -levels[1:])[np.diff(levels) > 0.0]
            assert far == pytest.approx(rises.min(initial=np.inf), abs=1e-5)


@pytest.mark.parametrize("rung", [2e-5, 5e-4, 7e-4, 2e-3])
def test_clearances_see_what_comes_and_goes_at_once(rung: float) -> None:
    """A weak rebound is sent back by a mode that soon dies out, long before the first of evenly spaced looks."""
    modes = MachineModes(np.array([0.0, 60.0]), np.array([0.0, 20.0]), np.array([1.0, 0.0]), np.ones(2), np.eye(2))
    begin = np.array([[rung, -0.01], [-rung, 0.0]])
    flight = ModalFlight(modes=modes, begin=begin, force=-0.3, duration=SPAN)
    (apart,) = clearances(flight, Regions(np.ones((1, 2)), np.zeros(1), 1.0, np.zeros(1)), -1)
    r = flight.at(np.linspace(0.0, 0.3, 100_001))[0].sum(axis=0)
    levels = r[[0, *np.flatnonzero(np.diff(np.sign(np.diff(r)))) + 1]]
    rises = np.maximum(levels[:-1], -levels[1:])[np.diff(levels) > 0.0]
    assert apart == pytest.approx(rises.min(initial=np.inf), abs=1e-9)
