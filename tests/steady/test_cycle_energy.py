"""Where the energy of a machine's cycle goes: what the valve puts in, blows, damping and rests take."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from percuss.model import (
    Chamber,
    Damping,
    External,
    KelvinVoigt,
    Kept,
    Machine,
    Port,
    Ratio,
    Reversed,
    Table,
    UniformBar,
    Valve,
)
from percuss.steady import Obstacle, ValveCycle, self_excited_motion
from percuss.steady.self_excited.many_pistons import rigid_cycles

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
