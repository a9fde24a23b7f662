"""The elastic machine that switches its own valve: known cycles, a second program, limits, invariances."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from machine_oracle import after_blows
from percuss.errors import ParameterError
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
    SteppedBar,
    Table,
    UniformBar,
    Valve,
)
from percuss.simulate import run
from percuss.steady import CycleTimes, Obstacle, ValveCycle, self_excited_motion, sensitivities
from percuss.steady.self_excited.self_switching import why_unstable
from percuss.steady.self_excited.settling import solved


def machine(
    s: float, d: float, R: float, forces: list[float], ports: list[Port], kappa: float = 0.0, law: type = Kept
) -> Machine:
    states = {str(i): force for i, force in enumerate(forces)}
    return Machine(UniformBar(s, External(d)), Valve(states, ports, chamber=Chamber(0.0, kappa)), law(R))


KNOWN = {
    "delay, drag": (
        machine(5.0, 0.02, 0.2, [-0.5, 1.8], [Port("1", 1.0, "back", 0.2), Port("0", 0.1, "front", 0.0)]), 4,
        3.4562201430679648892, 2.6219179822116689211, 2.7017440977476061015, 1.6530722563885873891,
        2.6809147638653712202,
        [-0.8846417068134584, -0.8128088151164342, 0.5361796265574846, -0.5200959061568755, 0.4279627653186622],
    ),
    "three states": (
        machine(
            5.0, 0.03, 0.25, [-0.5, 1.5, 0.4],
            [Port("1", 1.0, "back", 0.1), Port("2", 0.4, "front", 0.02), Port("0", 0.05, "front", 0.03)],
        ), 4,
        3.6523387578505352152, 2.5819973835926865599, 1.9304535121153480705, 1.6107140062464116023,
        1.940993247590846454,
        [-0.9770001804058548, -0.8367783351688105, -0.5008740379563716 + 0.05525512027694923j,
         -0.5008740379563716 - 0.05525512027694923j],
    ),
    "chamber, ports at the driven end, return pending over the blow": (
        machine(
            8.0, 0.05, 0.15, [-0.6, 1.4],
            [Port("1", 1.0, "back", 0.12, 0.0), Port("0", 0.08, "front", 0.1, 0.0)], 0.25,
        ), 8,
        3.5921225125647305754, 2.2839153758032988077, 2.1557265066126951215, 1.4176488143774391439,
        2.2661634168035851264,
        [-0.935096117698131, 0.8725204883157182, -0.8223535969410174, 0.7798501611163235, -0.6556844650822355],
    ),
    "breaker": (
        machine(
            5123.0, 2.0, 0.15, [-46.3963963963964, 241.8918918918919],
            [Port("1", 0.13, "back", 0.005), Port("0", 0.004, "front", 0.0005)], 225.22522522522524,
        ), 4,
        0.10711242944227619744, 8.9771528589047199151, 39.92734236917076051, 0.16107844372830571995,
        41.765230725984419508,
        [-0.8894122297855016, 0.7596935388735587, -0.6869356950700154, -0.3812014270244869, 0.3186045217189481],
    ),
}  # fmt: skip
"""Machine, N; period, speed, kinetic energy, stroke, work and multipliers, from flights in 40 digits."""


@pytest.mark.parametrize("case", KNOWN)
def test_cycles_known_to_many_digits(case: str) -> None:
    known, N, *figures, multipliers = KNOWN[case]
    motion = self_excited_motion(known, modes=N)
    cycle = motion.cycle
    assert motion.runs and isinstance(cycle, ValveCycle)
    found = [cycle.period, cycle.blow_speed, cycle.main_energy, cycle.stroke, cycle.work]
    assert found == pytest.approx(figures, rel=1e-10)
    size = len(multipliers)
    assert np.sort_complex(cycle.multipliers().values[:size]) == pytest.approx(np.sort_complex(multipliers), abs=1e-9)


def test_events_of_the_breaker() -> None:
    cycle = self_excited_motion(KNOWN["breaker"][0], modes=4).cycle
    rear, front = cycle.uncoverings
    assert (rear.port, rear.time, rear.velocity) == pytest.approx((0, 0.056548457142294014799, 2.9609650317224934342))
    assert (front.port, front.time, front.velocity) == pytest.approx((1, 0.106662110220655534, -8.8347929250402342478))
    assert [s.to for s in cycle.switches] == ["0", "1"]
    assert [s.time for s in cycle.switches] == pytest.approx([0.000049680778379336566456, 0.061548457142294014799])


# -- the second program --

INTEGRATED = {
    "kept": machine(4.0, 0.05, 0.3, [-0.6, 1.2], [Port("1", 1.0, "back", 0.1), Port("0", on="impact")]),
    "reversed, chamber": machine(
        4.0, 0.05, 0.4, [-0.6, 1.2], [Port("1", 1.0, "back", 0.1), Port("0", 0.1, "front", 0.02)], 0.2, Reversed,
    ),
    "an order pending over the blow": machine(
        6.0, 0.02, 0.25, [-0.5, 1.5], [Port("1", 1.0, "back", 0.1, 0.0), Port("0", 0.05, "front", 0.1)], 0.1,
    ),
    "no restitution": machine(
        5.0, 0.05, 0.0, [-0.6, 1.2], [Port("1", 1.0, "back"), Port("0", 0.25, "front")],
    ),
    "called back by its speed": machine(
        5.0, 0.05, 0.3, [-0.4, 1.8], [Port("1", 1.0, "back", 0.1), Port("0", None, "front", 0.05, 0.0, speed=1.6)], 0.1,
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", INTEGRATED)
def test_cycle_and_multipliers_agree_with_a_second_program(case: str) -> None:
    """The state after a cycle is that before it, and differences of the map have the same eigenvalues."""
    asked = INTEGRATED[case]
    cycle = self_excited_motion(asked, modes=2).cycle
    rhythm, begin = cycle.rhythm, cycle.flights[0].begin.T.reshape(-1)
    waiting = [to for _, to in rhythm.orders.pending]

    def mapped(x: np.ndarray) -> tuple[float, np.ndarray]:
        numbers = np.concatenate([x[:6], [1.0], x[6:]])
        time, after = after_blows(asked, numbers, rhythm.state, rhythm.orders.last, waiting, cycle.blows)
        return time, np.delete(after, 6)

    start = np.concatenate([begin, [due for due, _ in rhythm.orders.pending]])
    time, end = mapped(start)
    assert time == pytest.approx(cycle.period, rel=1e-9)
    assert end == pytest.approx(start, abs=1e-9)
    h = 1e-5
    if asked.contact.velocity_factor == 0.0:
        return  # a start off the wall would strike it at once
    slope = np.array([(mapped(start + h * e)[1] - mapped(start - h * e)[1]) / (2.0 * h) for e in np.eye(start.size)]).T
    found = np.linalg.eigvals(slope)
    largest = np.sort_complex(found[np.argsort(-np.abs(found))][:4])
    assert largest == pytest.approx(np.sort_complex(cycle.multipliers().values[:4]), abs=1e-6)


# -- limits and invariances --


def two_force(law: type, s: float, damping: Damping, R: float, rear: float, late: float, **rest: float) -> Machine:
    reads = rest.get("reads", "centre")
    ports = (Port("power", 1.0, "back", rear, reads), Port("return", 0.1, "front", late))
    valve = Valve({"return": -0.6, "power": 1.4}, ports, chamber=Chamber(0.0, rest.get("kappa", 0.0)))
    return Machine(UniformBar(s, damping), valve, law(R))


@pytest.mark.parametrize("law", [Kept, Reversed])
@pytest.mark.parametrize("kappa", [0.0, 0.3])
def test_a_stiff_bar_is_a_rigid_piston(law: type, kappa: float) -> None:
    """The difference falls as 1/s², and no mode is none."""
    rigid = self_excited_motion(two_force(law, 10.0, Ratio(0.3), 0.3, 0.1, 0.05, kappa=kappa), modes=0).cycle
    off = []
    for s in (1e2, 1e3):
        stiff = two_force(law, s, Ratio(0.3), 0.3, 0.1, 0.05, kappa=kappa)
        cycle = self_excited_motion(stiff, modes=3).cycle
        off.append(abs(cycle.period - rigid.period))
        assert cycle.multiplier.real == pytest.approx(rigid.multiplier.real, abs=30.0 / s)
    assert off[1] < 0.02 * off[0] < 1e-4


def test_without_modes_the_chain_is_the_rigid_piston() -> None:
    asked = two_force(Kept, 10.0, External(0.05), 0.3, 0.1, 0.2, kappa=0.2)
    rigid = self_excited_motion(asked, modes=0).cycle
    chain = solved(asked, 0, rigid.rhythm)
    assert chain.period == pytest.approx(rigid.period, rel=1e-13)
    assert chain.stroke == pytest.approx(rigid.stroke, rel=1e-12)
    assert chain.work == pytest.approx(rigid.work, rel=1e-12)
    assert chain.multiplier.real == pytest.approx(rigid.multiplier.real, rel=1e-9)
    times = np.linspace(-1.0, 9.0, 57).reshape(3, 19)
    assert chain.position(times) == pytest.approx(rigid.position(times), abs=1e-12)


dampings = st.one_of(
    st.sampled_from([External(0.0), Ratio(1.0), Table((0.05, 0.1))]),
    st.builds(External, st.floats(0.0, 0.2)), st.builds(Ratio, st.floats(0.0, 1.0)),
    st.builds(KelvinVoigt, st.floats(0.0, 0.1)),
)  # fmt: skip
machines = st.builds(
    two_force, st.sampled_from([Kept, Reversed]), st.floats(2.0, 80.0), dampings, st.floats(0.0, 0.7),
    st.one_of(st.just(0.0), st.floats(0.0, 0.3)), st.floats(0.0, 0.3),
    reads=st.sampled_from(["centre", 0.0, 0.4, 1.0]), kappa=st.sampled_from([0.0, 1e-9, 0.2]),
)  # fmt: skip


@given(machines, st.sampled_from([1, 2, 5, 12]))
@settings(max_examples=15)
def test_a_cycle_closes_and_keeps_to_its_side_of_the_wall(asked: Machine, modes: int) -> None:
    motion = self_excited_motion(asked, modes=modes)
    cycle = motion.cycle
    if not isinstance(cycle, ValveCycle) or cycle.rests:
        return
    scale = cycle.stroke
    times = np.linspace(0.0, cycle.period, 1500, endpoint=False)
    assert cycle.position(times).max() < 1e-9 * scale
    assert -cycle.position(times).min() <= scale * (1.0 + 1e-9)
    assert cycle.position(cycle.blow_times * (1.0 - 1e-12)) == pytest.approx(0.0, abs=1e-8 * scale)
    for passed in cycle.uncoverings:
        port = asked.valve.ports[passed.port]
        assert cycle.position(passed.time, port.reads) == pytest.approx(-port.behind, abs=1e-8)
    if asked.body.damping.is_zero and asked.contact.keeps_strain:
        assert cycle.work == pytest.approx(cycle.taken, rel=1e-8)


# -- what else there is --


def test_a_cycle_is_found_again_from_any_rhythm_near_it() -> None:
    asked, modes, *_ = KNOWN["delay, drag"]
    cycle = self_excited_motion(asked, modes=modes).cycle
    rhythm = replace(cycle.rhythm, blow_times=(cycle.period + 0.01,))
    for near in (cycle, rhythm):
        again = self_excited_motion(asked, modes=modes, near=near).cycle
        assert again.period == pytest.approx(cycle.period, rel=1e-13)
    with pytest.raises(ParameterError, match="near"):
        self_excited_motion(asked, modes=0, near=cycle)


def test_the_rhythm_of_a_list_of_events() -> None:
    asked, modes, *_ = KNOWN["chamber, ports at the driven end, return pending over the blow"]
    cycle = self_excited_motion(asked, modes=modes).cycle
    events = [(0.2, "port", 0), (0.32, "valve", "1")]
    for lap in (1.0, 1.0 + cycle.period, 1.0 + 2.0 * cycle.period):
        events += [(lap - 0.05, "port", 1), (lap, "impact", 2.28), (lap + 0.05, "valve", "0")]
        events += [(lap + 1.6, "port", 0), (lap + 1.7, "valve", "1")]
    rhythm = CycleTimes.of_events(asked.valve, events)
    assert (rhythm.state, rhythm.orders.last, len(rhythm.orders.pending)) == ("1", "0", 1)
    assert self_excited_motion(asked, modes=modes, near=rhythm).cycle.period == pytest.approx(cycle.period, rel=1e-12)
    with pytest.raises(ParameterError, match="blows"):
        CycleTimes.of_events(asked.valve, events[:4])


def test_a_late_return_without_restitution_rests() -> None:
    """Rest forgets everything: the first flight after it is that of an undeformed bar, and all multipliers are 0."""
    ports = [Port("1", 1.0, "back", 0.1), Port("0", on="impact", delay=0.4)]
    motion = self_excited_motion(machine(8.0, 0.05, 0.0, [-0.6, 1.2], ports), modes=4)
    cycle = motion.cycle
    assert motion.runs and cycle.rests and cycle.multiplier == 0.0
    assert cycle.switches[0].time == pytest.approx(0.4)
    assert np.abs(cycle.position(np.linspace(0.0, 0.4, 9))).max() < 1e-12
    rigid = self_excited_motion(machine(8.0, 0.05, 0.0, [-0.6, 1.2], ports), modes=0).cycle
    assert cycle.period == pytest.approx(rigid.period, rel=0.05)


def test_unstable_cycles_are_named() -> None:
    """B77's law feeds the ringing of a lossless bar where restitution is high."""
    fed = machine(5.0, 0.0, 0.85, [-0.4, 1.8], [Port("1", 1.0, "back"), Port("0", on="impact")])
    motion = self_excited_motion(fed, modes=2)
    assert motion.obstacle is Obstacle.FLIP and not motion.cycle.stable and not motion.runs
    assert motion.found > motion.needed == 1.0
    for obstacle, multiplier in ((Obstacle.SPIRAL, 1.0 + 0.1j), (Obstacle.GROWS, 1.1), (Obstacle.FLIP, -1.1)):
        assert why_unstable(complex(multiplier)) is obstacle


def test_sensitivities_of_closed_formulas() -> None:
    """Without delay v² = 2 Σ Δ_i x_i/(1 − R²): energy as the pressure and as the port; rate as their square root."""
    back, power, R = 0.4, 1.8, 0.2
    ports = [Port("1", 1.0, "back"), Port("0", on="impact")]
    motion = self_excited_motion(machine(10.0, 0.0, R, [-back, power], ports), modes=0)
    cycle, found = motion.cycle, {(s.quantity, s.port): s for s in sensitivities(motion)}
    energy, rate = (back + power) / (1.0 - R**2), 1.0 / cycle.period
    by_pressure, by_port, by_R = found["pressure", None], found["behind", 0], found["restitution", None]
    assert (by_pressure.energy, by_pressure.rate) == pytest.approx((energy, 0.5 * rate), rel=1e-7)
    assert (by_port.energy, by_port.rate) == pytest.approx((energy, -0.5 * rate), rel=1e-7)
    assert by_R.energy == pytest.approx(energy * 2.0 * R / (1.0 - R**2), rel=1e-7)
    v, c = math.sqrt(2.0 * energy), cycle.uncoverings[0].velocity
    assert found["delay", 0].energy == pytest.approx((back + power) * c / (1.0 - R**2), rel=1e-3)  # x_1 = 1 + cτ
    assert found["delay", 1].energy == pytest.approx(-(back + power) * R * v / (1.0 - R**2), rel=1e-3)


def test_sensitivities_of_an_elastic_machine() -> None:
    asked = two_force(Reversed, 30.0, Ratio(0.05), 0.2, 0.1, 0.05)
    elastic, rigid = (sensitivities(self_excited_motion(asked, modes=modes)) for modes in (4, 0))
    for one, other in zip(elastic, rigid, strict=True):
        assert (one.quantity, one.port) == (other.quantity, other.port)
        assert one.energy == pytest.approx(other.energy, rel=0.3, abs=0.15)
        assert one.rate == pytest.approx(other.rate, rel=0.3, abs=0.02)
    with pytest.raises(ParameterError, match="runs"):
        sensitivities(self_excited_motion(two_force(Kept, 10.0, External(0.0), 1.0, 0.0, 0.0)))


def test_a_stepped_bar() -> None:
    body = SteppedBar(20.0, (1.0, 2.0), (1.0, 1.0), External(0.05))
    ports = (Port("power", 1.0, "back", 0.1, 0.3), Port("return", 0.1, "front", 0.02))
    asked = Machine(body, Valve({"return": -0.6, "power": 1.2}, ports), Kept(0.2))
    motion = self_excited_motion(asked, modes=6)
    rigid = self_excited_motion(asked, modes=0)
    assert motion.runs
    assert motion.cycle.period == pytest.approx(rigid.cycle.period, rel=0.02)
    assert motion.cycle.position(motion.cycle.uncoverings[0].time, 0.3) == pytest.approx(-1.0)


def test_a_cycle_that_settles_slowly_is_not_taken_for_several_blows() -> None:
    """With strain kept and hardly any damping the motion still alternates when two blows first close."""
    ports = [Port("power", 1.0, "back", 0.2), Port("return", 0.1, "front", 0.05)]
    found = self_excited_motion(
        machine(5.0, 0.0048, 0.6, [-0.5, 1.0], [replace(p, to=to) for p, to in zip(ports, "10", strict=True)])
    )
    assert found.runs and found.cycle.blows == 1
    assert found.cycle.period == pytest.approx(5.21272482, rel=1e-8)
    assert abs(found.cycle.multiplier) == pytest.approx(0.99057, abs=1e-4)


# -- the end of a chatter --

PRESSED = {
    "stepped": (
        Machine(
            SteppedBar(2.226, (0.4464, 0.6845, 0.4282, 2.6568), (0.877, 0.6475, 0.408, 0.429), External(0.023)),
            Valve(
                {"s0": -0.3483, "s1": 1.8496},
                (Port("s1", 1.3735, "back", reads=0.444), Port("s0", on="impact", delay=0.1233)),
            ),
            Kept(0.1249),
        ), 2, 4.98617,
    ),
    "uniform": (
        Machine(
            UniformBar(2.365),
            Valve(
                {"s0": -0.776, "s1": 0.8145},
                (Port("s1", 0.9374, "back", 0.0538), Port("s0", 0.2403, "front", reads=0.911)),
            ),
            Kept(0.2129),
        ), 4, 5.5287,
    ),
    "nothing left": (
        machine(5.0, 0.05, 0.0, [-0.6, 1.2], [Port("1", 1.0, "back"), Port("0", 0.15, "front")], law=Reversed),
        2, 4.2993,
    ),
}  # fmt: skip
"""Machines whose valve pulls while the ringing presses the end on the wall; N, and the period."""


@pytest.mark.parametrize("case", PRESSED)
def test_a_chatter_ends_as_it_does_in_a_simulation(case: str) -> None:
    """After the same blow, and at the same time; none of its ever smaller rebounds is lost in rounding."""
    asked, modes, period = PRESSED[case]
    cycle, motion = self_excited_motion(asked, modes=modes).cycle, run(asked, modes=modes)
    assert cycle.rests
    assert cycle.period == pytest.approx(period, rel=1e-4)
    assert cycle.period == pytest.approx(motion.cycle.period, rel=1e-10)
    struck = motion.events.of("impact").time
    assert cycle.blows == np.count_nonzero(struck > motion.end_time - (1.0 - 1e-6) * motion.cycle.period)
    assert cycle.taken + cycle.taken_by_rest == pytest.approx(motion.cycle.energy_lost, rel=1e-8)


def random_striker(seed: int) -> tuple[Machine, int]:
    """A soft bar of a few sections that chatters, and its modes."""
    rng = np.random.default_rng(seed)

    def within(low: float, high: float) -> float:
        return float(rng.uniform(low, high))

    sections = int(rng.integers(1, 5))
    damping = External(within(0.0, 0.03)) if rng.uniform() < 0.5 else Ratio(within(0.0, 0.01))
    sizes = rng.uniform(0.3, 3.0, sections).tolist(), rng.uniform(0.3, 1.0, sections).tolist()
    bar = SteppedBar(within(2.0, 4.0), tuple(sizes[0]), tuple(sizes[1]), damping)
    back = Port("power", within(0.8, 1.5), "back", within(0.0, 0.1), within(0.0, 1.0))
    late = Port("return", on="impact", delay=within(0.0, 0.3))
    early = Port("return", within(0.05, 0.4), "front", within(0.0, 0.1), within(0.0, 1.0))
    states = {"return": -within(0.2, 1.0), "power": within(0.5, 2.0)}
    valve = Valve(states, (back, late if rng.uniform() < 0.5 else early))
    return Machine(bar, valve, Kept(within(0.0, 0.3))), int(rng.integers(1, 6))


def beyond_the_wall(cycle: ValveCycle) -> float:
    """How far the striking end is beyond the wall at most, looked at 400 times in each flight.

    Not where the bar has just left the wall at rest: the end of finitely many modes moves a little beyond it at once.
    """
    most, held = 0.0, False
    for flight in cycle.flights:
        held = not flight.begin.any() or (held and flight.held)
        if not held:
            times = np.linspace(0.0, flight.duration, 400)
            most = max(most, float((flight.modes.end @ flight.at(times)[0]).max()))
    return most


@pytest.mark.parametrize("seeds", [range(40), pytest.param(range(40, 540), marks=pytest.mark.slow)], ids=len)
def test_no_cycle_passes_through_the_wall(seeds: range) -> None:
    found = 0
    for seed in seeds:
        asked, modes = random_striker(seed)
        cycle = self_excited_motion(asked, modes=modes).cycle
        if isinstance(cycle, ValveCycle):
            found += 1
            assert beyond_the_wall(cycle) <= 1e-9 * cycle.stroke, seed
    assert found > len(seeds) // 2


def test_a_cycle_that_passes_through_the_wall_is_known_as_such() -> None:
    """Whatever is proved of its flights: a cycle is looked at before it is told of."""
    cycle = self_excited_motion(PRESSED["stepped"][0], modes=2).cycle
    assert cycle.keeps_before_the_wall
    first, *rest = [flight for flight in cycle.flights if not flight.held and flight.begin.any()]
    through = replace(first, begin=first.begin * [[1.0, -1.0]])  # the blow turned nothing over
    assert not replace(cycle, flights=(through, *rest)).keeps_before_the_wall
