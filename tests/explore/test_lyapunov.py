"""Lyapunov exponents: of steady motions, of chaos beside the divergence of neighbours, and where there is none."""

import math
from dataclasses import replace

import numpy as np
import pytest

from hammers import HAMMERS, Hammer
from percuss import Load, Start, Starts, Stop, System, Trajectory, run, steady_states
from percuss.errors import ParameterError
from percuss.explore.lyapunov import LYAPUNOV_OUTCOMES, Lyapunov, lyapunov_exponent, lyapunov_many
from percuss.explore.tangent import growths
from percuss.model import Machine, ModalBody, Port, Supply, Valve
from percuss.model.body import Body, External, KelvinVoigt, Ratio, SteppedBar, Table, UniformBar
from percuss.model.checks import Array
from percuss.model.contact import Contact, Kept, Reversed
from percuss.stability import floquet_multipliers
from percuss.steady import Orbit, orbits, self_excited_motion

CHAOTIC = System(s=20.0, d=0.0, restitution=0.6, load=Load.harmonic(0.66, 1.0))
STEPS = System(s=3.0, d=0.1, restitution=0.4, load=Load.steps([0.8, 1.9, 3.3, 4.5], [-0.7, -0.1, 0.8, 1.5]))


def milder(system: System, modes: int = 0) -> Orbit:
    """The steady motion with the smaller multiplier."""
    orbits = steady_states(system, modes=modes).orbits
    return min(orbits, key=lambda orbit: floquet_multipliers(orbit, modes).largest)


def beside(system: System) -> Start:
    """A start beside it."""
    return Start.orbit(milder(system), velocity=[-0.01])


@pytest.mark.parametrize(
    ("s", "d", "restitution", "load", "modes", "which"),
    [
        (20.0, 0.0, 0.6, Load.harmonic(0.77, 1.0), 0, 1),
        (20.0, 0.0048, 0.6, Load.harmonic(0.9, 1.0), 4, 1),
        (5.0, 0.02, 0.3, Load.harmonic(0.45, 1.0), 3, 1),
        (1.3, 0.1, 0.4, Load.harmonic(0.55, 1.0), 6, 1),
        (0.2, 1.86, 0.1, Load.harmonic(0.09, 1.0), 2, 1),  # one overdamped mode
        (6.0, 0.05, 0.0, Load.harmonic(0.27, 1.0), 3, 1),  # no rebound
        (2.0, 0.05, 0.5, Load.fourier([0.4, 1.0, 0.3j]), 4, 1),
        (3.0, 0.1, 0.4, STEPS.load, 4, 1),  # unstable
        (20.0, 0.0, 0.8, Load.harmonic(0.82, 1.0), 0, 1),  # unstable
        (2.0, 0.05, 0.5, Load.harmonic(0.6, 1.0), 4, 0),  # unstable, beyond the fold
    ],
)
def test_a_steady_motion_has_the_logarithm_of_its_largest_multiplier(s, d, restitution, load, modes, which):
    system = System(s=s, d=d, restitution=restitution, load=load)
    orbit = steady_states(system, modes=modes).orbits[which]
    assert orbit.admissible
    expected = floquet_multipliers(orbit, modes)
    numbers = {"impacts": 2000, "discard": 500} if expected.largest < 1.0 else {"impacts": 20, "discard": 8}
    found = lyapunov_exponent(system, Start.orbit(orbit), modes=modes, **numbers)
    assert found.outcome == "done" and found.impacts == numbers["impacts"]
    assert found.exponent == pytest.approx(math.log(expected.largest), rel=1e-3)
    assert found.per_period == pytest.approx(found.exponent, rel=1e-3)


def test_a_pair_of_multipliers_is_averaged_to_many_digits():
    system = System(s=20.0, d=0.0, restitution=0.6, load=Load.harmonic(0.8, 1.0))
    found = lyapunov_exponent(system, beside(system), modes=0)
    assert found.exponent == pytest.approx(math.log(0.6), abs=1e-5)  # |μ|² = R²: theory §11
    assert not found.chaotic


def test_the_cascade_ends_in_chaos():
    systems = [CHAOTIC.with_load_factor(f) for f in (0.66, 0.6675, 0.67, 0.6725, 0.6775, 0.69, 0.77)]
    many = lyapunov_many(systems, [beside(system) for system in systems], modes=0)
    assert [many[i].chaotic for i in range(7)] == [True, True, True, False, False, False, False]
    assert np.all(many.exponent[3:] < -0.05)


@pytest.mark.parametrize("impacts", [50, 200, 500, 2000])
@pytest.mark.parametrize("mean", [1.2, 2.0, 3.0])
def test_a_regular_motion_without_damping_is_not_chaotic(mean, impacts):
    """Around stable motions of a bar that loses nothing differences grow as the number of impacts: by ln n in all."""
    system = System(s=5.0, d=0.0, restitution=1.0, load=Load.harmonic(mean, 1.0))
    orbits = [orbit for m in (1, 2, 3) for orbit in steady_states(system, m, modes=0).orbits]
    stable = [orbit for orbit in orbits if floquet_multipliers(orbit, 0).largest < 1.0 + 1e-6]
    starts = [Start.orbit(orbit, velocity=[off]) for orbit in stable for off in (0.0, 1e-4, 0.001)]
    for discard in (2, 500):
        many = lyapunov_many(system, starts, impacts=impacts, discard=discard, modes=0)
        for one in many:
            assert not one.chaotic and abs(one.exponent) < math.log(impacts) / impacts


def test_chaos_parts_neighbours_at_its_exponent():
    """Pairs of motions 1e-9 apart, over 20 impacts, from many states of a long one."""
    whole = run(CHAOTIC, beside(CHAOTIC), modes=0, stop=Stop(impacts=2600, periodic=False))
    ahead, rates = 20, []
    for i in range(600, 2600 - ahead, 40):
        rate, time = float(whole.states[i, 1]), float(whole.events.phase[i])
        stop = Stop(impacts=ahead, periodic=False)
        pair = [
            run(CHAOTIC, Start.rigid(0.0, rate * (1.0 + 1e-9 * k), time), modes=0, stop=stop).events for k in range(2)
        ]
        apart = np.hypot(
            np.diff([e.time for e in pair], axis=0)[0], np.diff([e.impact_velocity for e in pair], axis=0)[0]
        )
        rates.append(math.log(apart[-1] / apart[7]) / (ahead - 8))
    mean, error = float(np.mean(rates)), float(np.std(rates, ddof=1) / math.sqrt(len(rates)))
    found = lyapunov_exponent(CHAOTIC, beside(CHAOTIC), impacts=20000, modes=0)
    assert found.chaotic and found.error < 0.01
    assert abs(found.exponent - mean) < 4.0 * math.hypot(error, found.error)
    assert error < 0.1 * mean


@pytest.mark.parametrize(
    ("system", "numbers"),
    [
        (System(s=20.0, d=0.0048, restitution=0.6, load=Load.harmonic(0.9, 1.0)), {}),
        (STEPS, {"impacts": 20, "discard": 8}),
    ],
)
def test_the_phase_of_the_load_does_not_matter(system, numbers):
    found = []
    for shift in (0.0, 1.3, 4.0):
        moved = replace(system, load=system.load.shifted(shift))
        found.append(lyapunov_exponent(moved, Start.orbit(milder(moved, 4)), modes=4, **numbers))
    assert {f.outcome for f in found} == {"done"}
    assert [f.exponent for f in found] == pytest.approx([found[0].exponent] * 3, rel=1e-3)


def test_chaos_does_not_feel_the_phase_of_the_load_either():
    systems = [replace(CHAOTIC, load=Load.harmonic(0.6675, 1.0).shifted(shift)) for shift in (0.0, 2.0)]
    one, two = (lyapunov_exponent(system, beside(system), impacts=5000, modes=0) for system in systems)
    assert one.chaotic and abs(one.exponent - two.exponent) < 5.0 * math.hypot(one.error, two.error)


def test_rest_erases_every_difference():
    system = System(s=20.0, d=0.0048, restitution=0.6, load=Load.harmonic(0.9, 1.0))
    found = lyapunov_exponent(system, Start.rigid(-1.0, time=0.3), modes=8)
    assert found.exponent == found.per_period == -math.inf and found.outcome == "rest" and not found.chaotic
    for_good = lyapunov_exponent(System(s=20.0, d=0.1, restitution=0.5, load=Load.harmonic(2.0, 1.0)), modes=0)
    assert for_good.exponent == -math.inf and for_good.outcome == "rest"
    assert "rest" in str(for_good)


def test_a_bar_that_leaves_has_no_exponent():
    found = lyapunov_exponent(System(s=20.0, d=0.0, restitution=0.5, load=Load.harmonic(-0.5, 1.0)), modes=0)
    assert math.isnan(found.exponent) and found.outcome == "departed"


def test_a_rest_before_the_impacts_that_count_is_no_rest():
    system = System(s=20.0, d=0.0, restitution=0.2317, load=Load.harmonic(0.4026, 1.0))
    start = Start.rigid(-1.1976, time=4.9833)
    rests = np.flatnonzero(run(system, start, modes=0, stop=Stop(impacts=600)).events.kind == "rest")
    assert rests.size and 7 < rests[-1] < 14
    found = [
        lyapunov_exponent(system, start, discard=n, modes=0) for n in (14, 60, 500)
    ]  # where the difference begins anew
    assert {f.outcome for f in found} == {"done"}
    assert [f.exponent for f in found] == pytest.approx([math.log(0.2317)] * 3, rel=0.01)
    assert lyapunov_exponent(system, start, discard=2, modes=0).outcome == "rest"


def test_many_are_each_like_one():
    systems = [CHAOTIC.with_load_factor(float(f)) for f in np.linspace(0.6, 0.95, 12)]
    systems.append(System(s=1.0 / math.pi, d=0.0, restitution=0.5, load=Load.harmonic(0.5, 1.0)))  # resonant
    starts = Starts.rigid(-0.5, time=np.linspace(0.0, 3.0, 13))
    one, two = (lyapunov_many(systems, starts, modes=2, impacts=300, discard=50, workers=n) for n in (1, 3))
    for name in ("exponent", "per_period", "error", "impacts", "code"):
        np.testing.assert_array_equal(getattr(one, name), getattr(two, name))
    assert len(one) == 13 and LYAPUNOV_OUTCOMES[one.code[-1]] == "resonance"
    for i in range(12):
        alone = lyapunov_exponent(systems[i], starts[i], modes=2, impacts=300, discard=50)
        assert isinstance(one[i], Lyapunov) and repr(one[i]) == repr(alone)


@pytest.mark.parametrize("numbers", [{"impacts": 5}, {"discard": 0}, {"impacts": 2.5}, {"modes": -1}])
def test_numbers_out_of_range_are_refused(numbers):
    with pytest.raises(ParameterError):
        lyapunov_exponent(CHAOTIC, **numbers)


def test_systems_and_starts_must_go_together():
    with pytest.raises(ParameterError):
        lyapunov_many([CHAOTIC] * 3, Starts.rigid(time=np.zeros(2)), modes=0)
    with pytest.raises(ParameterError):
        lyapunov_many([], modes=0)


# -- any law of contact and of damping, beside motions that start a little apart --------------------------------------

MODES, IMPACTS, DISCARD, APART = 4, 20, 2, 1e-7


def size(system: System, displacement: Array, velocity: Array) -> float:
    """What the growth of a difference is measured by: of u_0, u_0', ω_n q_n and q_n', all together."""
    modes = system.body.modes(MODES, system.load.at)
    q, rate = modes.gamma * displacement[1:], modes.gamma * velocity[1:]
    return float(np.linalg.norm([displacement[0], velocity[0], *(modes.omega * q), *rate]))


def growths_of_a_neighbour(motion: Trajectory) -> list[float]:
    """Logarithms of the growth of a small difference from impact to impact, after the second one.

    It begins as the tangent vector does. After each impact a neighbour starts anew, nearer, before the wall.
    """
    system, times = motion.system, motion.events.time[motion.events.kind == "impact"]
    modes, n = system.body.modes(MODES, system.load.at), np.arange(MODES)
    u = np.append(1.0, 1.0 / (n + 2.0) / modes.gamma)
    v = np.append(1.0, (modes.omega - 0.5 * modes.damping) / (n + 2.0) / modes.gamma)
    time, found = float(times[1]), []
    for following in times[2 : IMPACTS + DISCARD + 1]:
        nearer = -np.copysign(APART / size(system, u, v), u[0] + modes.gamma @ u[1:])
        here = motion.modal([time])
        start = Start.modal(here.displacement[:, 0] + nearer * u, here.velocity[:, 0] + nearer * v, time=time)
        beside = run(system, start, modes=MODES, stop=Stop(impacts=2, periodic=False))
        time = max(float(following), float(beside.events.time[0]))
        u, v = (
            (getattr(beside.modal([time]), name) - getattr(motion.modal([time]), name))[:, 0]
            for name in ("displacement", "velocity")
        )
        found.append(float(np.log(size(system, u, v) / APART)))
    return found


@pytest.mark.parametrize(
    ("body", "contact", "factor"),
    [
        (UniformBar(3.0, External(0.02)), Kept(0.6), 0.66),
        (UniformBar(3.0, External(0.02)), Reversed(0.6), 0.6),
        (UniformBar(0.9, Ratio(0.03)), Reversed(0.5), 0.66),
        (UniformBar(3.0, Ratio(0.03)), Kept(0.6), 0.66),
        (UniformBar(2.0, KelvinVoigt(0.2)), Kept(0.6), 0.66),  # overdamped modes
        (UniformBar(2.0, KelvinVoigt(0.2)), Reversed(0.6), 0.66),
        (UniformBar(2.0, Table((0.5, 0.0, 30.0, 0.1))), Reversed(0.6), 0.6),
        (SteppedBar(3.0, (2.0, 1.0), (0.4, 0.6), Ratio(0.02)), Kept(0.6), 0.5),
    ],
)
def test_neighbours_part_as_the_exponent_says(body: Body, contact: Contact, factor: float) -> None:
    system, start = System(body, Load.harmonic(factor, 1.0), contact), Start.rigid(-0.5, time=0.3)
    motion = run(system, start, modes=MODES, stop=Stop(impacts=IMPACTS + DISCARD + 2, periodic=False))
    assert set(motion.events.kind.tolist()) == {"impact"}
    growth = growths_of_a_neighbour(motion)[1:]
    t = np.arange(1, IMPACTS + 1) / (IMPACTS + 1.0)
    weight = np.exp(-1.0 / (t * (1.0 - t)))
    found = lyapunov_exponent(system, start, modes=MODES, impacts=IMPACTS, discard=DISCARD)
    assert found.impacts == IMPACTS == len(growth)
    assert found.exponent == pytest.approx(float(weight @ growth / weight.sum()), abs=1e-5)


# -- every hammer: periodic motions have the logarithms of their multipliers, and all exponents together the contraction

NO_DELAY = Valve({"return": -0.4, "power": 1.8}, (Port("power", behind=1.0, side="back"), Port("return", on="impact")))
SLIDERS = (Port("power", behind=0.6, side="back", delay=0.3), Port("return", behind=0.2, side="front", delay=0.4))
BAR = UniformBar(20.0, External(0.01))
FED = Valve(NO_DELAY.states, SLIDERS, supply=Supply(0.7, 15.0))
MORE = {
    "under steps": Hammer(System(3.0, 0.1, 0.4, Load.steps([0.5, 3.0], [2.5, -0.3])), 3, ()),
    "machine without delays": Hammer(Machine(BAR, NO_DELAY, Kept(0.3)), 3, ()),
    "machine of sliders": Hammer(Machine(BAR, Valve(NO_DELAY.states, SLIDERS), Kept(0.3)), 2, ()),
    "two blows of a pump": Hammer(Machine(UniformBar(20.0), FED, Reversed(0.3)), 0, ()),
}


def periodic(hammer: Hammer) -> tuple[Start, Array]:
    """A start beside a stable periodic motion, and the logarithms of its multipliers over an impact."""
    what, modes = hammer.what, hammer.modes
    if isinstance(what, Machine):
        cycle = self_excited_motion(what, modes=modes).cycle
        start, moduli, blows = Start.rigid(0.0, -2.0), np.abs(cycle.multipliers().values), cycle.blows
    else:
        every = [one for p, n in ((1, 1), (1, 2), (2, 2)) for one in orbits(what, p, n, modes=modes, tries=60).orbits]
        orbit = min(every, key=lambda one: one.multipliers().largest)
        start, moduli, blows = Start.orbit(orbit, velocity=[1e-4]), orbit.multipliers().moduli, orbit.impacts
    assert moduli.max() < 1.0
    return start, np.sort(np.log(moduli[moduli > 1e-12]))[::-1] / blows


@pytest.mark.parametrize("name", [name for name in (HAMMERS | MORE) if name != "elastic"])  # whose rest alone is stable
def test_all_exponents_of_a_periodic_motion(name: str) -> None:
    hammer = (HAMMERS | MORE)[name]
    start, expected = periodic(hammer)
    found = lyapunov_exponent(hammer.what, start, modes=hammer.modes, every=True)
    assert found.outcome == "done" and found.spectrum[0] == pytest.approx(found.exponent, rel=1e-9)
    assert np.array(found.spectrum[: expected.size]) == pytest.approx(expected, abs=3e-3)
    assert not np.isfinite(found.spectrum[expected.size :]).any()


@pytest.mark.parametrize("law", [Kept(0.4), Reversed(0.4), Kept(0.8)])
@pytest.mark.parametrize("modes", [0, 3])
def test_all_exponents_together_are_the_contraction(law: Contact, modes: int) -> None:
    """Per impact: α^(n−1) β^(n+1) of n coordinates and exp(−d t) of each in flight, without delays."""
    bar, n = UniformBar(7.0, External(0.03)), modes + 1
    for what, start in (
        (System(bar, Load.fourier([0.6, 1.0, 0.4j]), law), Start.rigid(-0.5, time=0.3)),
        (Machine(bar, NO_DELAY, law), None),
    ):
        found = lyapunov_exponent(what, start, modes=modes, impacts=300, discard=20, every=True)
        if found.outcome == "rest":
            continue
        time = found.exponent / found.per_period * (1.0 if isinstance(what, Machine) else 2.0 * math.pi)
        impact = (n - 1) * math.log(abs(law.strain_factor)) + (n + 1) * math.log(abs(law.velocity_factor))
        assert sum(found.spectrum) == pytest.approx(impact - 0.03 * n * time, rel=1e-6)


# -- structures of several modes at rest: what the wall holds remembers

TWO = ModalBody((3.3, 7.3), (0.3, 0.1), (1.0, 0.8), (1.0, -0.5), -0.01)
THREE = ModalBody((2.9, 4.1, 9.0), (0.2, 0.05, 0.3), (1.0, 0.8, 2.0), (1.0, -0.5, 0.7), -0.02)


@pytest.mark.parametrize(
    ("body", "load", "restitution", "near"),
    [(TWO, Load.harmonic(0.0, 1.0), 0.4, 1e-4), (THREE, Load.harmonic(0.0, 1.0), 0.3, 0.1),
     (TWO, Load.square(1.0, 1.2), 0.4, 0.1), (TWO, Load.steps([0.2, 1.0, 3.0], [0.5, -0.4, 1.0]), 0.0, 0.15)],
)  # fmt: skip
def test_structures_remember_what_the_wall_holds(body: ModalBody, load: Load, restitution: float, near: float) -> None:
    """Period by period, as a neighbour that is brought near again each time: a real multiplier, pairs, and chaos."""
    system, turn, periods = System(body, load, Kept(restitution)), 2.0 * math.pi, 60

    def over_a_period(state: Array, time: float) -> Array:
        u, v = np.split(state, 2)
        start = Start.modal(np.append(0.0, u), np.append(0.0, v), time)
        moved = run(system, start, stop=Stop(time=turn + 1e-6, impacts=10**6, periodic=False)).modal([time + turn])
        return np.concatenate([moved.displacement[1:, 0], moved.velocity[1:, 0]])

    motion = run(system, Start.rigid(-1.0), stop=Stop(time=130 * turn, impacts=10**6, periodic=False))
    kind, times = motion.events.kind, motion.events.time
    assert np.count_nonzero(kind == "rest") > 20
    places = 60 * turn + np.linspace(0.0, turn, 64)
    lies = motion.lies[np.searchsorted(times, places, "right")]
    time = begin = float(places[np.flatnonzero(~lies)[np.count_nonzero(~lies) // 2]])
    start = motion.start_at(time)
    here, aside, rates = np.array([*start.displacement[1:], *start.velocity[1:]]), 1e-6, []
    off = np.full(here.size, 1.0) / np.arange(1.0, here.size + 1.0)
    for _ in range(periods):
        off *= aside / np.linalg.norm(off)
        there = over_a_period(here, time)
        off, here, time = over_a_period(here + off, time) - there, there, time + turn
        rates.append(math.log(np.linalg.norm(off) / aside))
    first = int(np.flatnonzero(kind == "impact")[np.count_nonzero(kind == "impact") // 4])
    growth, struck = growths(motion, first, every=False)[:, 0], times[first:][kind[first:] == "impact"][1:]
    counted = (struck > begin + 10 * turn) & (struck < time)
    assert growth[counted].sum() / (periods - 10) == pytest.approx(np.mean(rates[10:]), abs=near)
    found = lyapunov_exponent(system, Start.rigid(-1.0), every=True, impacts=400, discard=200)
    assert found.outcome == "done" and found.modes == here.size // 2
    assert found.spectrum[0] == pytest.approx(found.exponent, rel=1e-9)
    assert not np.isfinite(found.spectrum[-here.size // 2 :]).any()


def test_a_structure_that_rests_for_good_has_the_exponent_of_what_the_wall_holds() -> None:
    system = System(replace(TWO, gap=-1.0), Load.harmonic(0.0, 1.0), Kept(0.4))
    found = lyapunov_exponent(system, Start.rigid(-1.0))
    assert found.outcome == "rest" and found.exponent == -math.inf and math.isfinite(found.per_period)
    motion = run(system, Start.rigid(-1.0))
    t = motion.end_time + np.linspace(0.0, 20.0, 2001)
    whole = run(system, Start.rigid(-1.0), stop=Stop(time=float(t[-1]) + 1.0, periodic=False))
    assert whole.outcome == "rest"
    assert "per load period" in str(found)
