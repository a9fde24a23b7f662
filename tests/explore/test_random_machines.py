"""Random machines that switch their own valve: their cycles, branches and ends against the simulator and themselves.

And what random starts settle on is found by its label.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest

from machine_maps import beginning, differences, landed
from percuss.explore import Branch, BranchEvent, diagram, experiment, follow, orbit_seeds
from percuss.explore.family import SystemFamily
from percuss.model import Chamber, External, Kept, Machine, Port, Ratio, Reversed, Supply, UniformBar, Valve
from percuss.steady import ValveCycle, orbits, self_excited_motion
from percuss.steady.self_excited.event_sequence import sequence_in, sequence_of
from percuss.steady.self_excited.settling import rest_cycles_of
from percuss.steady.self_excited.valve_orbits import valve_rest_cycles

MODES = (0, 1, 4, 16)
OF_TESTS = {
    "wall": BranchEvent.TOUCH, "order": BranchEvent.CORNER, "edge": BranchEvent.PORT_TOUCH, "rest": BranchEvent.ONSET,
    "port": BranchEvent.PORT_LOST, "blow": BranchEvent.DEATH, "pressure": BranchEvent.PRESSURE_GONE,
}  # fmt: skip
ENDS = {BranchEvent.NONSMOOTH_FOLD: BranchEvent.CORNER, BranchEvent.ORDER_LOST: BranchEvent.CORNER}


MORE = 504
"""From this seed on delays follow the pressure of a pump, are longer, and the swing of the pressure is greater."""


def drawn(seed: int) -> tuple[Machine, int]:
    """A random machine, on a pump or not, in turn of 0, 1, 4 and 16 modes; some blows leave it on the wall."""
    rng = np.random.default_rng([26, seed])
    size, late = rng.uniform(0.3, 1.5), rng.uniform(0.0, 0.3, 2) * rng.integers(0, 2, 2)
    ports = [Port("power", size, "back", late[0])]
    on_blow = Port("return", on="impact", delay=4.0 * late[1])
    ports.append(on_blow if seed // 8 % 2 else Port("return", 0.1 * size, "front", late[1]))
    supply = Supply(rng.uniform(0.3, 1.0), 10.0 ** rng.uniform(0.5, 2.5)) if seed // 4 % 2 else None
    states = {"return": -rng.uniform(0.2, 1.0), "power": rng.uniform(0.8, 3.0)}
    valve = Valve(states, ports, None, Chamber(rng.uniform(0.0, 0.1), rng.uniform(0.0, 0.2)), supply=supply)
    damping = [External(rng.uniform(0.02, 0.2)), Ratio(rng.uniform(0.05, 0.5))][seed % 2]
    law = (Kept, Reversed)[seed // 2 % 2](rng.uniform(0.1, 0.6) if seed % 5 else 0.0)
    machine = Machine(UniformBar(rng.uniform(3.0, 12.0), damping), valve, law)
    if seed >= MORE and supply is not None:
        later = tuple(replace(port, delay=rng.uniform(0.1, 0.5) * size) for port in ports)
        fed = replace(supply, quickening=rng.uniform(0.3, 0.9), compliance=10.0 ** rng.uniform(0.5, 1.5))
        machine = machine.with_valve(replace(valve, ports=later, supply=fed))
    return machine, MODES[seed % 4]


def cycles_of(machine: Machine, modes: int) -> list[ValveCycle]:
    own = self_excited_motion(machine, modes=modes).cycle
    settled = [] if own is None or own.rests else [own]
    return settled + list(rest_cycles_of(machine, modes))


def check_against_simulator(cycle: ValveCycle) -> None:
    """It comes back after a cycle, with the multipliers of differences; what rests is what a simulation comes to."""
    begin = beginning(cycle)
    after = landed(cycle, begin)
    scale = max(1.0, abs(cycle.multiplier))
    assert after.times == pytest.approx(cycle.blow_times, rel=1e-10)
    assert after.numbers == pytest.approx(begin, rel=1e-10, abs=1e-10 * scale)
    if cycle.contact.velocity_factor == 0.0:  # beside a blow that leaves no speed there is another one
        return
    sequence = sequence_of(cycle)
    solved = sequence.solved(cycle.machine, cycle.modes, sequence.unknowns(cycle))
    assert solved is not None and sequence.fault(solved) is None
    step = min(max(1e-4 * min(sequence.tests(solved).values()), 1e-7), 1e-5)  # nothing else may happen beside it
    own, theirs = np.poly(cycle.multipliers().values), np.poly(np.linalg.eigvals(differences(cycle, step)))
    assert own[: theirs.size] == pytest.approx(theirs, abs=1e-6 * max(1.0, float(np.abs(theirs).max())))


def check_events(machine: Machine, name: str, branch: Branch) -> None:
    """Each event of a branch is one of the cycle that is solved for again at its value, on its defining number."""
    for point in branch.points:
        cycle, values = point.valve_cycle, point.multipliers
        sequence = sequence_of(cycle)
        assert point.kind is not BranchEvent.LOST, point
        if point.kind in (BranchEvent.FOLD, BranchEvent.FLIP):
            assert np.abs(values - (1.0 if point.kind is BranchEvent.FOLD else -1.0)).min() < 1e-6, point
        elif point.kind is BranchEvent.NEIMARK_SACKER:
            assert np.abs(np.abs(values) - 1.0).min() < 1e-7, point
        elif point.kind is BranchEvent.LIMIT:
            other = sequence.solved(
                SystemFamily(machine).machine({name: point.value}), cycle.modes, sequence.unknowns(cycle)
            )
            assert other is not None and other.blow_times == pytest.approx(cycle.blow_times, rel=1e-9), point
        elif (kind := ENDS.get(point.kind, point.kind)) in OF_TESTS.values():
            if kind is BranchEvent.ONSET and not cycle.contact.keeps_strain:  # it may be held within a contact
                continue
            kinds = {kind, BranchEvent.CORNER} if kind is BranchEvent.ONSET else {kind}
            tests = sequence.tests(cycle).items()
            near = sorted(abs(v) for test, v in tests if OF_TESTS[test.partition(" ")[0]] in kinds)
            together = kind is BranchEvent.DEATH and near[1] < 1e-6  # several impacts die at once: a singular equation
            assert near[0] < (1e-7 if together else 1e-9), point


def events_of(branch: Branch, here: float) -> list[tuple[str, float]]:
    """What happens, in order; two folds within 1e-5 may be passed in one step, and are left out."""
    found: list[tuple[str, float]] = []
    for point in branch.points:
        one = point.kind.value, round(point.value, 7)
        if found and one[0] == found[-1][0] == "fold" and abs(one[1] - found[-1][1]) < 1e-5 * here:
            found.pop()
        else:
            found.append(one)
    return sorted(found)


def check_branch(cycle: ValveCycle, machine: Machine) -> Counter[str]:
    """± 30 % of the pressure or the flow: its events hold, and from an end of it everything is the same."""
    supply = machine.valve.supply
    name, here = ("pressure", 1.0) if supply is None else ("supply.flow", supply.flow)
    bounds = 0.7 * here, 1.3 * here
    branch = follow(cycle, name, bounds, value=here)
    check_events(machine, name, branch)
    told = events_of(branch, here)
    for end in branch.ends:
        if end.kind is BranchEvent.LIMIT:
            again = follow(end.valve_cycle, name, bounds, family=SystemFamily(machine), value=end.value)
            assert events_of(again, here) == told
            break
    return Counter(kind for kind, _ in told)


@pytest.mark.parametrize(
    "seeds",
    [
        range(8),
        range(MORE + 4, MORE + 8),
        *(pytest.param(range(i, i + 124), marks=pytest.mark.slow) for i in range(8, MORE, 124)),
        pytest.param(range(MORE + 8, MORE + 64), marks=pytest.mark.slow),
    ],
    ids=str,
)
def test_cycles_branches_and_ends_of_random_machines(seeds: range) -> None:
    found = 0
    for seed in seeds:
        machine, modes = drawn(seed)
        for cycle in cycles_of(machine, modes):
            found += 1
            if not cycle.rests:
                check_against_simulator(cycle)
            if sequence_in(machine.valve, cycle.rhythm) is not None:  # else the end of a chatter lets go
                check_branch(cycle, machine)
    assert found > len(seeds) // 2


# -- what random starts settle on is found by its label --

ON_BLOW = (Port("power", 0.84, "back"), Port("return", on="impact", delay=1.5))
CROWDED = (
    *(Port("power", 1.18, "back"), Port("return", speed=1.74, side="front")),
    *(Port("third", 0.24, "back", 0.53), Port("third", on="impact", delay=0.73)),
)
MACHINES = {
    "orders that change nothing": (
        Machine(UniformBar(5.0, Ratio(0.03)), Valve({"return": -1.05, "power": 1.7}, ON_BLOW), Kept(0.87)), 0
    ),
    "a port demands what the blow has demanded": (
        Machine(
            UniformBar(9.0, Ratio(0.5)),
            Valve({"return": -1.27, "power": 1.64, "third": 0.3}, CROWDED, chamber=Chamber(0.04, 0.26)),
            Kept(0.85),
        ),
        0,
    ),
    "an end that rings as it leaves the wall": drawn(58),
    "a pump whose pressure settles slowly": drawn(236),
    "a rest on a pump that settles slowly": drawn(189),
    "a rest on a pump with one bounce more once it has settled": drawn(222),
}  # fmt: skip


@pytest.mark.parametrize(
    ("machine", "modes"),
    [pytest.param(*one, id=name, marks=[pytest.mark.slow] * ("pump" in name)) for name, one in MACHINES.items()],
)
def test_what_starts_settle_on_is_found_by_its_label(machine: Machine, modes: int) -> None:
    settled = [one for one in experiment(machine, 40, modes=modes, workers=1).attractors if "/" in one.label]
    assert settled
    for motion in settled:
        blows, valve_cycles = motion.label.split()[-1].split("/")
        if blows in ("rest", "chatter"):
            found = valve_rest_cycles(machine, blows, int(valve_cycles), modes=modes)
        else:
            near = orbit_seeds(machine, int(blows), int(valve_cycles), modes=modes)
            found = orbits(machine, int(blows), int(valve_cycles), modes=modes, tries=20, near=near)
        told = [(one.period, one.blow_speed) for one in found.orbits]  # type: ignore[attr-defined]
        figures = motion.figures["period"], max(motion.figures["impact_velocities"])
        assert any(figures == pytest.approx(one, rel=1e-7) for one in told)


@pytest.mark.parametrize(("seed", "not_followed"), [(9, [0.2868]), (24, [])])
def test_what_a_diagram_settles_on_lies_on_its_branches(seed: int, not_followed: list[float]) -> None:
    """Between chatter and one blow in a cycle are windows of more and more blows, each narrower.

    A chatter whose valve lets go of the bar while it rings is not followed; each branch is there once.
    """
    machine, modes = drawn(seed)
    found, left = diagram(machine, "restitution=0.05:0.8:20", modes=modes, workers=1), []
    labels = Counter(line.label for line in found.branches)
    assert {"chatter/1", "2/1", "1/1"} <= set(labels) and max(labels.values()) == 1
    for motion in found.settled:
        lines = [line for line in found.branches if line.label == motion.label.split()[-1]]
        rows = [np.sort(row) for line in lines for row in line.speeds_at(motion.value)]
        told = min([motion.speeds.size, *(row.size for row in rows)])
        own = np.sort(motion.speeds)[-told:]
        if not any(own == pytest.approx(row[-told:], abs=5e-3 * own[-1]) for row in rows):
            left.append(motion.value)
    assert left == pytest.approx(not_followed, abs=1e-4)
