"""Cycles of machines that switch their own valve, followed: every point solved again, and against the simulator."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import pytest

from machine_maps import beginning, landed
from percuss.case import Case, branch_answer, load_case, point_curves_answer
from percuss.case.answers.exploring.orbits_answer import orbits_answer
from percuss.case.parameters.case_family import CaseFamily
from percuss.errors import ParameterError
from percuss.explore import Axis, Branch, BranchEvent, diagram, follow, follow_point, reach
from percuss.explore.family import SystemFamily
from percuss.model import Chamber, External, Machine, Port, Ratio, Reversed, Supply, UniformBar, Valve
from percuss.model.contact import Kept
from percuss.steady import ValveCycle, self_excited_motion
from percuss.steady.self_excited.event_sequence import sequence_of

# a machine on a pump with a mode and one of constant pressure without; the others are for `make slow`
SEEDS = [3, 20, *(pytest.param(seed, marks=pytest.mark.slow) for seed in (2, 12, 19, 33))]


def drawn(seed: int) -> tuple[Machine, int]:
    """A random machine, on a pump or not, and its modes."""
    rng = np.random.default_rng([24, seed])
    size, late = rng.uniform(0.3, 1.5), rng.uniform(0.0, 0.2, 2) * rng.integers(0, 2, 2)
    ports = [Port("power", size, "back", late[0]), Port("return", 0.1 * size, "front", late[1])]
    supply = Supply(rng.uniform(0.3, 1.0), 10.0 ** rng.uniform(0.5, 2.5)) if seed % 3 == 0 else None
    states = {"return": -rng.uniform(0.2, 1.0), "power": rng.uniform(0.8, 3.0)}
    valve = Valve(states, ports, None, Chamber(rng.uniform(0.0, 0.1), rng.uniform(0.0, 0.2)), supply=supply)
    damping = [External(rng.uniform(0.02, 0.2)), Ratio(rng.uniform(0.05, 0.5))][seed % 2]
    law = (Kept, Reversed)[seed // 2 % 2](rng.uniform(0.1, 0.6))
    return Machine(UniformBar(rng.uniform(3.0, 12.0), damping), valve, law), (0, 1)[seed % 2]


@lru_cache(maxsize=16)
def followed(seed: int) -> tuple[ValveCycle, str, float, Branch]:
    machine, modes = drawn(seed)
    cycle = self_excited_motion(machine, modes=modes).cycle
    if cycle is None or cycle.rests:
        pytest.skip("no cycle without a rest")
    supply = machine.valve.supply
    name, here = ("pressure", 1.0) if supply is None else ("supply.flow", supply.flow)
    return cycle, name, here, follow(cycle, name, (0.7 * here, 1.3 * here), value=here, switch=1)


def solved(machine: Machine, name: str, value: float, near: ValveCycle) -> ValveCycle:
    """The cycle at another value, by Newton's method from one near it."""
    sequence, other = sequence_of(near), SystemFamily(machine).machine({name: value})
    found = sequence.solved(other, near.modes, sequence.unknowns(near))
    assert found is not None
    return found


@pytest.mark.parametrize("seed", SEEDS)
def test_points_are_cycles_of_the_simulator(seed):
    """Of every point at which the motion is possible: the simulator comes back after a cycle."""
    _, name, _, branch = followed(seed)
    for point in branch.points:
        cycle = point.valve_cycle
        assert cycle.label == branch.label
        if point.kind in (BranchEvent.LIMIT, BranchEvent.FOLD, BranchEvent.FLIP):
            begin = beginning(cycle)
            after = landed(cycle, begin)
            assert after.times == pytest.approx(cycle.blow_times, rel=1e-9), (name, point)
            assert after.numbers == pytest.approx(begin, rel=1e-8, abs=1e-8)


@pytest.mark.parametrize("seed", SEEDS)
def test_points_hold_what_they_are_called(seed):
    """A multiplier is 1 or −1, a pair is on the circle, a test of the order of events is 0."""
    _, _, _, branch = followed(seed)
    names = {"wall": BranchEvent.TOUCH, "order": BranchEvent.CORNER, "edge": BranchEvent.PORT_TOUCH}
    names |= {"port": BranchEvent.PORT_LOST, "blow": BranchEvent.DEATH, "pressure": BranchEvent.PRESSURE_GONE}
    for line in branch.family():
        for point in line.points:
            values = point.valve_cycle.multipliers().values
            if point.kind in (BranchEvent.FOLD, BranchEvent.FLIP):
                assert np.abs(values - (1.0 if point.kind is BranchEvent.FOLD else -1.0)).min() < 1e-6, point
            if point.kind is BranchEvent.NEIMARK_SACKER:
                assert np.abs(np.abs(values) - 1.0).min() < 1e-7
            if point.kind in names.values():
                tests = sequence_of(point.valve_cycle).tests(point.valve_cycle)
                mine = [abs(v) for test, v in tests.items() if names[test.partition(" ")[0]] is point.kind]
                assert min(mine) < 1e-9, (point, mine)
            assert point.kind is not BranchEvent.LOST, point


@pytest.mark.parametrize("seed", SEEDS)
def test_a_branch_is_the_same_from_its_other_end(seed):
    cycle, name, here, branch = followed(seed)
    ends = [point for point in branch.ends if point.kind is BranchEvent.LIMIT]
    if not ends:
        pytest.skip("no end at which the branch could be begun again")
    value, start = ends[0].value, ends[0].valve_cycle
    again = follow(start, name, (0.7 * here, 1.3 * here), family=SystemFamily(cycle.machine), value=value)
    told = sorted((point.kind.value, round(point.value, 7)) for point in branch.points)
    assert sorted((point.kind.value, round(point.value, 7)) for point in again.points) == told


def test_the_doubled_branch_leads_from_flip_to_flip():
    """The period doubles and comes back; from one flip to the other it is one branch, and neither end is lost."""
    ports = [Port("power", 0.7140296444799789, "back", reads=0.0), Port("return", 0.07140296444799789, "front")]
    states = {"return": -0.24281314310808666, "power": 0.9628850182395187}
    valve = Valve(states, ports, chamber=Chamber(0.08850360548549323, 0.1905907861368948))
    machine = Machine(UniformBar(8.444406, External(0.0388671)), valve, Kept(0.3756))
    cycle = self_excited_motion(machine, modes=1).cycle
    assert cycle is not None
    branch = follow(cycle, "pressure", (0.7, 1.3), value=1.0, switch=1)
    flips = [point.value for point in branch.at(BranchEvent.FLIP)]
    ends = [point.value for line in branch.switched for point in line.ends]
    assert len(flips) >= 4 and sorted(ends) == pytest.approx(sorted(flips), rel=1e-10)
    assert all(point.kind is BranchEvent.HALVING for line in branch.switched for point in line.ends)
    for flip in branch.at(BranchEvent.FLIP):
        assert flip.side in ("greater", "smaller") and flip.criticality in ("supercritical", "subcritical")
        stable = flip.beyond.endswith(", stable")
        assert not stable or flip.criticality == "supercritical"


# -- the samples ------------------------------------------------------------------------------------------------------


@lru_cache(maxsize=2)
def breaker(modes: int) -> Branch:
    return branch_answer(load_case("valve-breaker"), "1/1", "pressure=90bar:300bar", modes=modes)


@pytest.mark.parametrize("modes", (0, pytest.param(4, marks=pytest.mark.slow)))
def test_the_breaker_over_its_pressure(modes):
    """It goes on where the return is due before the blow; every orbit is that which is solved for by itself."""
    branch = breaker(modes)
    kinds = [point.kind for point in branch.points]
    assert kinds == [BranchEvent.PORT_LOST, BranchEvent.FOLD, BranchEvent.CORNER, BranchEvent.LIMIT]
    assert branch.at("corner")[0].value == pytest.approx(129.972, abs=1e-3)
    rows = np.flatnonzero(branch.stable)
    assert np.all(np.diff(rows) == 1) and rows[-1] == branch.values.size - 1  # from the fold on
    family = CaseFamily(load_case("valve-breaker"), {"pressure": "bar"})
    for i in rows[2:-1:9]:
        own = self_excited_motion(family.machine({"pressure": float(branch.values[i])}), modes=modes).cycle
        assert own is not None and own.blow_speeds == pytest.approx(branch.speeds[i], rel=1e-9)
        assert own.period == pytest.approx(branch.cycle_times[i], rel=1e-9)


def test_an_end_is_followed_over_two_parameters():
    case = load_case("valve-breaker")
    branch = breaker(0)
    (curve,) = point_curves_answer(case, branch, "corner", "pressure=90bar:300bar", "restitution=0.1:0.2")
    assert curve.event is BranchEvent.CORNER and curve.parameters == ("pressure", "restitution")
    family = CaseFamily(case, {"pressure": "bar"})
    pressure, restitution = curve.values[len(curve.values) // 3]
    machine = family.machine({"pressure": float(pressure), "restitution": float(restitution)})
    near = branch.at("corner")[0].valve_cycle
    found = solved(machine, "pressure", 1.0, near)
    tests = sequence_of(near).tests(found)  # by its own times rounding decides on the order
    assert min(abs(value) for name, value in tests.items() if name.startswith("order")) < 1e-9
    with pytest.raises(ParameterError, match="one of the kinds"):
        follow_point(branch.ends[-1], ("pressure", "restitution"), family=family, values=(300.0, 0.15))


def test_reach_and_search_and_diagram():
    case = load_case("valve-breaker")
    machine = case.machine()
    cycle = self_excited_motion(machine, modes=0).cycle
    found = reach(cycle, "pressure", (0.7, 1.2), value=1.0)
    assert (found.below.kind, found.above.kind) == (BranchEvent.FOLD, BranchEvent.LIMIT)
    assert found.below.value == pytest.approx(120.869018934 / 160.0, rel=1e-9) and found.below.then is not None
    assert orbits_answer(case, "1/1", modes=0, tries=10, motions=2).orbits[0].speeds == pytest.approx(cycle.speeds)
    shown = diagram(machine, "pressure=0.9:1.1:3", up_to=(1, 1), searched=1, starts=2, runs=1, modes=0)
    assert [line.label for line in shown.branches] == ["1/1"] and shown.labels == ("runs 1/1",)
    with pytest.raises(ParameterError, match="pressure"):
        follow(cycle, "nonsense")


def hunting(flow: float) -> Case:
    """The breaker of the tutorial: 73 kg, a stiff gas, a slow valve, and so much oil (l/min) from a pump."""
    ports = [{"behind": "130 mm", "side": "back", "to": "power", "delay": "11 ms"}, {"behind": "4 mm", "side": "front"}]
    ports[1] |= {"to": "return", "delay": "0.5 ms"}
    return load_case("valve-breaker").varied({
        "bar.length": "822 mm", "load.chamber": {"force": "15 kN", "stiffness": "116 kN/m"}, "load.ports": ports,
        "load.supply": {"flow": f"{flow} l/min", "accumulator": "2 cm^3/bar"},
    })  # fmt: skip


def test_pressures_of_a_pump_hunt():
    """A strong blow leaves the next a lower pressure: beyond a flip they alternate, or repeat after three."""
    branch = branch_answer(hunting(155), "1/1", "load.supply.flow=115l/min:160l/min", modes=0, switch=1)
    (flip,) = branch.at(BranchEvent.FLIP)
    assert flip.value == pytest.approx(148.048090465, rel=1e-8) and branch.switched[0].label == "2/2"
    assert (flip.side, flip.criticality) == ("smaller", "supercritical")
    for flow, label in ((125, "3/3"), (120, "2/2")):
        (orbit,) = orbits_answer(hunting(flow), label, modes=0, tries=10, motions=4).orbits
        begin = beginning(orbit)
        assert orbit.stable and landed(orbit, begin).numbers == pytest.approx(begin, rel=1e-10)
    family = CaseFamily(hunting(155), {"load.supply.flow": "l/min"})
    flows = Axis("load.supply.flow", [117, 121, 125], "l/min")
    shown = diagram(family, flows, up_to=(1, 1), searched=1, starts=1, runs=0, modes=0)
    assert {line.label for line in shown.branches} >= {"2/2", "5/5", "7/7"}  # simulations settle on these
    assert set(shown.labels) >= {"runs 2/2", "runs 7/7"}  # by the label of their orbit
