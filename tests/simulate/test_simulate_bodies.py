"""Motions of other bodies, dampings and contact laws: against a numerical integration that shares no code with us."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise
from typing import ClassVar

import mpmath
import numba
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from percuss import Load, Start, Stop, System, run
from percuss.model.body import Bar, Body, Damping, External, KelvinVoigt, Ratio, Shape, SteppedBar, Table, UniformBar
from percuss.model.contact import Kept, Reversed
from percuss.simulate.engine import desk_for, table_of
from percuss.simulate.kernels.modes import damped_phasors
from percuss.simulate.kernels.motion_records import POWERS, RATIO, SINGLY
from percuss.simulate.start import modal_parts
from percuss.steady import si_report, steady_states

LOAD = Load.fourier([0.7, 1.0, 0.3j])


@dataclass(frozen=True)
class Modal(Body):
    """A body that is known by the numbers of its first modes only."""

    omega: tuple[float, ...]
    at: tuple[float, ...]
    weight: tuple[float, ...]
    damping: Damping
    s: float = 3.0
    kind: ClassVar[str] = "modal"
    coupling_bound: ClassVar[float] = 4.0

    def frequencies(self, count):
        return np.array(self.omega[:count])

    def inertia(self, count):
        return np.array(self.weight[:count])

    def shapes(self, x, count):
        """At the load and at the striking end."""
        rows = np.array([[1.0] * count if place == 1.0 else self.at[:count] for place in x]).reshape(-1, count)
        return Shape(rows, np.zeros_like(rows))

    def static_shape(self, x, source=0.0):
        raise NotImplementedError

    def frequency_floor(self, n):
        raise NotImplementedError


def modal(seed: int, modes: int, damping: Damping) -> Modal:
    """Frequencies that are no multiples of one, a load that reaches each mode otherwise, unequal masses."""
    rng = np.random.default_rng(seed)
    omega = tuple((3.0 * (np.arange(modes) + 1.0 + 0.6 * rng.uniform(-1.0, 1.0, modes))).tolist())
    return Modal(omega, tuple(rng.uniform(-1.2, 1.2, modes)), tuple(rng.uniform(0.3, 1.0, modes)), damping)


def integrated(system: System, modes: int, u: np.ndarray, v: np.ndarray, time: float, impacts: int):
    """Times, speeds and energies taken of the first impacts, and the state after them, by DOP853."""
    elastic = system.body.modes(modes, system.load.at)
    omega2 = np.append(0.0, elastic.omega**2)
    damping = np.append(system.body.damping.rigid, elastic.damping)
    gamma = np.append(1.0, elastic.gamma)
    weight = np.append(1.0, elastic.inertia)
    strain = np.append(1.0, np.full(modes, system.contact.strain_factor))
    r, n = system.restitution, modes + 1

    def rate(t, x):
        return np.concatenate([x[n:], gamma * float(system.load.value(t)) - damping * x[n:] - omega2 * x[:n]])

    def gap(t, x):
        return x[:n].sum()

    gap.terminal, gap.direction = True, 1.0
    x, found = np.concatenate([u * gamma, v * gamma]), []
    for _ in range(impacts):
        flight = solve_ivp(rate, (time, time + 60.0), x, "DOP853", events=gap, rtol=1e-12, atol=1e-13, max_step=0.05)
        time, x = float(flight.t_events[0][0]), flight.y_events[0][0].copy()
        speed = x[n:].sum()
        energy = 0.5 * (weight * x[n:] ** 2).sum() + 0.5 * (weight * omega2 * x[:n] ** 2).sum()
        x[:n] *= strain
        x[n:] *= -r
        x[0] -= x[:n].sum()
        left = 0.5 * (weight * x[n:] ** 2).sum() + 0.5 * (weight * omega2 * x[:n] ** 2).sum()
        found.append((time, speed, energy - left, *x))
        x[0] -= 1e-13  # else the next flight begins with a contact
    return np.array(found)


CASES = {
    "ratio": System(UniformBar(2.0, Ratio(0.02)), LOAD, Kept(0.6)),
    "great ratio": System(UniformBar(2.0, Ratio(0.97)), LOAD, Kept(0.6)),
    "kelvin-voigt": System(UniformBar(2.0, KelvinVoigt(0.01)), LOAD, Kept(0.6)),
    "overdamped above": System(UniformBar(2.0, KelvinVoigt(0.15)), LOAD, Kept(0.6)),
    "table": System(UniformBar(2.0, Table((0.3, 0.0, 40.0, 0.1))), LOAD, Kept(0.6)),
    "reversed": System(UniformBar(2.0, Ratio(0.02)), LOAD, Reversed(0.6)),
    "reversed, undamped": System(UniformBar(5.0), LOAD, Reversed(0.8)),
    "reversed, dragged": System(UniformBar(2.0, External(0.3)), LOAD, Reversed(0.6)),
    "reversed, overdamped": System(UniformBar(2.0, External(16.0)), LOAD, Reversed(0.6)),
    "modal, undamped": System(modal(1, 5, External(0.0)), LOAD, Kept(0.6)),
    "modal, dragged": System(modal(2, 5, External(0.4)), LOAD, Kept(0.6)),
    "modal, ratio": System(modal(3, 5, Ratio(0.01)), LOAD, Kept(0.6)),
    "modal, table": System(modal(4, 5, Table((0.0, 9.0, 0.2))), LOAD, Kept(0.6)),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", CASES)
def test_against_integration(name):
    system, modes, impacts = CASES[name], 5, 4
    rng = np.random.default_rng(len(name))
    u, v = 0.02 * rng.normal(size=(2, modes + 1))
    gamma = system.body.modes(modes).gamma
    u[0] = -1.0 - gamma @ u[1:]
    motion = run(system, Start.modal(u, v, 0.4), modes=modes, stop=Stop(impacts=impacts, periodic=False))
    exact = integrated(system, modes, u, v, 0.4, impacts)
    hits = motion.events.of("impact")
    assert hits.time == pytest.approx(exact[:, 0], rel=0.0, abs=2e-9)
    assert hits.impact_velocity == pytest.approx(exact[:, 1], rel=0.0, abs=2e-8)
    assert hits.energy_lost == pytest.approx(exact[:, 2], rel=1e-7, abs=1e-9)
    at = motion.events.code == 0
    n = modes + 1
    assert motion.displacement[at][:, 1:] * gamma == pytest.approx(exact[:, 4 : 3 + n], rel=0.0, abs=2e-8)
    assert motion.velocity[at][:, 1:] * gamma == pytest.approx(exact[:, 4 + n :], rel=0.0, abs=1e-6)


@pytest.mark.parametrize("name", CASES)
def test_the_energy_closes(name):
    balance = run(CASES[name], modes=5, stop=Stop(impacts=40, periodic=False)).energy_balance()
    assert abs(balance.imbalance) <= 1e-9 * (abs(balance.input) + balance.impacts)


def test_how_phasors_are_computed():
    """By the numbers of the modes, not by the kind of the body; a body of one mode is harmonic."""
    laws = {"ratio": RATIO, "kelvin-voigt": SINGLY, "reversed, dragged": POWERS, "modal, ratio": SINGLY}
    for name, law in laws.items():
        assert table_of(CASES[name], 5).bar["law"] == law, name
    assert table_of(CASES["modal, ratio"], 1).bar["law"] == POWERS


@pytest.mark.parametrize("tau", [1e-12, 1e-3, 0.7, 30.0, 3e3])
def test_phasors_one_by_one(tau):
    """e^{(−d/2 + iλ)τ} − 1 to rounding, which for the phase is that of λτ."""
    modes = table_of(System(modal(5, 7, Table((0.0, 1e-9, 1e-3, 0.1, 0.5, 2.0, 6.0))), LOAD, Kept(0.6)), 7).modes
    desk = desk_for(table_of(CASES["table"], 7))
    numba.njit(damped_phasors.py_func)(modes, desk, tau)
    with mpmath.workdps(40):
        exact = [mpmath.expm1(mpmath.mpc(-d, lam) * tau) for d, lam in zip(modes.half, modes.lam, strict=True)]
    found = desk.re + 1j * desk.im
    size = np.minimum(1.0, np.hypot(modes.lam, modes.half) * tau) + modes.lam * tau * np.exp(-modes.half * tau)
    assert np.all(np.abs(found - np.array([complex(value) for value in exact])) <= 1e-15 * size)


@pytest.mark.parametrize("restitution", [0.0, 0.4])
def test_chatter_that_turns_the_strain_over(restitution):
    """A bar pushed on the wall comes to rest when the load turns it round within the time of a contact, 2/s."""
    system = System(UniformBar(8.0), Load.fourier([0.5]), Reversed(restitution))
    motion = run(system, Start.rigid(-0.3), modes=8)
    assert motion.outcome == "rest"
    assert abs(motion.energy_balance().imbalance) <= 1e-12
    speeds = motion.events.of("impact").impact_velocity
    assert speeds[-1] >= 0.0 and (restitution == 0.0) == (speeds.size == 1)


def test_one_compilation_serves_all():
    """Loads with and without harmonics or steps, bars with and without modes: arrays of one type, all writable."""
    loads = (Load.harmonic(0.7, 1.0), Load.square(1.0, 1.3), Load.fourier([0.5]), LOAD)
    tables = [table_of(System(UniformBar(2.0), load, Kept(0.5)), modes) for load in loads for modes in (0, 1, 4)]
    for table in tables:
        arrays = [*table.modes, *table.harmonics, *table[3:]]
        assert all(values.flags.writeable and values.flags.c_contiguous for values in arrays)


def test_steady_motion_starts_where_the_load_acts_at_a_node():
    """A mode with a node at the load is not moved by it: in a start from a steady motion it stands still, too."""
    bar = SteppedBar(7.3, (1.0, 2.5), (0.5, 0.5), KelvinVoigt(3e-4))
    load = replace(Load.harmonic(0.9, 1.0), at=1)
    system = System(bar, load, Kept(0.8))
    assert np.abs(bar.modes(8, 1).at_load).min() < 1e-12
    orbit = steady_states(system, modes=16).orbits[0]
    blow = run(system, Start.orbit(orbit), modes=16, stop=Stop(time=8.0)).events.of("impact")
    assert abs(blow.time[0] - orbit.phase - 2.0 * np.pi) < 1e-12
    assert abs(blow.impact_velocity[0] - orbit.impact_velocity) < 1e-12


def test_what_a_blow_delivers_is_what_the_steady_motion_says():
    """Where the impact turns the strain over, it takes strain energy besides (1 − R²) of the kinetic energy."""
    bar = Bar(length=0.4, area=1.2566e-3, damping_ratio=1e-3)
    system = System.from_si(bar, Load.harmonic(5000.0, 6000.0, frequency=300.0), Reversed(0.6))
    orbit = steady_states(system, modes=32).orbits[1]
    si = run(system, Start.orbit(orbit), modes=32, stop=Stop(time=100.0)).summary.si
    assert abs(si.delivered_energy_J - si_report(orbit).delivered_energy_J) < 1e-9 * si.blow_energy_J
    assert si.delivered_energy_J > (1.0 - 0.6**2) * si.blow_energy_J * (1.0 + 1e-9)


def test_a_profile_on_equal_sections_is_that_on_a_uniform_bar() -> None:
    unit, samples = np.ones(12), (0.0, 0.4, -0.2, 0.1)
    parts = modal_parts(samples, SteppedBar(8.0, (2.0, 2.0), (1.0, 3.0)), unit)
    assert parts == pytest.approx(modal_parts(samples, UniformBar(8.0), unit), abs=1e-12)


UNEVEN = [
    SteppedBar(8.0, (5.0, 1.0, 2.0), (1.0, 1.0, 0.5)),
    SteppedBar(8.0, (5.0, 1.0), (1.0, 2.0), lengths=(3.0, 1.0)),
]


@pytest.mark.parametrize("body", UNEVEN, ids=str)
@pytest.mark.parametrize("modes", [0, 1, 9])
def test_a_start_has_the_momentum_of_its_velocities(body: SteppedBar, modes: int) -> None:
    """However few modes are kept: the rigid velocity is that of the centre of mass."""
    parts = modal_parts(lambda x: np.cos(3.0 * x), body, np.ones(modes))
    ends = np.append(body.sections.start, 1.0)
    means = np.diff(np.sin(3.0 * ends)) / (3.0 * np.diff(ends))
    assert parts[0] == pytest.approx(float(np.diff(body.sections.before) @ means), abs=1e-13)


@pytest.mark.parametrize("body", UNEVEN, ids=str)
def test_a_mode_starts_as_itself(body: SteppedBar) -> None:
    parts = modal_parts(lambda x: body.shapes(x, 3).displacement[:, 2], body, np.ones(6))
    assert parts == pytest.approx([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0], abs=1e-11)


# -- energy ------------------------------------------------------------------------------------------------------------


LOADS = {
    "pneumatic": Load.harmonic(0.7, 1.0),
    "steps": Load.square(1.0, 1.3),
    "harmonics": Load.fourier([0.6, 1.0, 0.4j, -0.2, 0.1 + 0.1j]),
}


def closes(motion, bound=1e-10):
    balance = motion.energy_balance()
    turned = abs(balance.input) + balance.damping + balance.impacts
    assert turned > 0.0
    assert abs(balance.imbalance) < bound * turned, balance
    return balance


@pytest.mark.slow
@pytest.mark.parametrize("modes", [0, 8])
@pytest.mark.parametrize("load", LOADS)
def test_balance_over_a_thousand_impacts(load, modes):
    system = System(s=1.5, d=0.0048, restitution=0.6, load=LOADS[load])
    motion = run(system, Start.rigid(time=0.3), modes=modes, stop=Stop(impacts=1000, periodic=False))
    assert motion.impacts == 1000
    balance = closes(motion)
    assert balance.impacts > 0.0 and balance.damping > 0.0


@pytest.mark.parametrize("modes", [0, 1, 8])
@pytest.mark.parametrize("d", [30.0, 100.0, 1e3, 1e4])
@pytest.mark.parametrize("load", ["pneumatic", "steps"])
def test_balance_with_strong_damping(load, d, modes):
    # what an impact leaves dies out within 1/d of it
    system = System(s=2.0, d=d, restitution=0.5, load=LOADS[load])
    motion = run(system, Start.rigid(-0.1 / d, 0.3, 0.3), modes=modes, stop=Stop(time=40.0, impacts=60, periodic=False))
    assert motion.impacts > 0
    closes(motion, 1e-10)
    middle = 0.5 * (motion.begin_time + motion.end_time)
    balance = motion.energy_balance(None, middle)
    assert abs(balance.imbalance) < 1e-10 * (abs(balance.input) + balance.damping + balance.impacts)


def test_parts_of_a_motion():
    # they begin and end in flight
    system = System(s=5.0, d=0.1, restitution=0.6, load=LOADS["steps"])
    motion = run(system, Start.rigid(time=0.3), modes=3, stop=Stop(impacts=50, periodic=False))
    whole, times = motion.energy_balance(), np.linspace(motion.begin_time, motion.end_time, 4)
    parts = [motion.energy_balance(a, b) for a, b in pairwise(times)]
    for name in ("input", "damping", "impacts", "stored"):
        assert sum(getattr(part, name) for part in parts) == pytest.approx(getattr(whole, name), rel=1e-11)
    assert all(abs(part.imbalance) < 1e-11 * whole.impacts for part in parts)


@pytest.mark.parametrize("modes", [0, 1, 8])
@pytest.mark.parametrize("restitution", [0.0, 0.3])
def test_balance_with_chatter_and_rest(restitution, modes):
    for load in (Load.harmonic(0.7, 1.0), Load.square(1.0, 1.5), Load.steps([0.5, 2.5, 4.0], [1.0, 0.4, -0.8])):
        system = System(s=8.0, d=0.3, restitution=restitution, load=load)
        motion = run(system, Start.rigid(time=0.3), modes=modes, stop=Stop(time=200.0, periodic=False))
        assert {"rest", "release"} <= set(motion.events.kind.tolist())
        closes(motion)


@pytest.mark.parametrize("modes", [1, 4, 16])
def test_balance_of_a_ringing_bar(modes):
    rng = np.random.default_rng(5)
    system = System(s=2.0, d=0.05, restitution=0.7, load=Load.fourier([0.8, 1.0]))
    u, v = rng.normal(size=(2, modes + 1)) * 0.1
    sign = np.where(np.arange(1, modes + 1) % 2, -2.0, 2.0)
    u[0] = -sign @ u[1:] - 0.05
    motion = run(system, Start.modal(u, v, 0.7), modes=modes, stop=Stop(impacts=1000, periodic=False))
    closes(motion)


@pytest.mark.parametrize("modes", [0, 2, 8])
def test_energy_without_losses(modes):
    # a constant load has a potential: −p u(0)
    rng = np.random.default_rng(6)
    push = 0.7
    system = System(s=3.0, d=0.0, restitution=1.0, load=Load.fourier([push]))
    u, v = rng.normal(size=(2, modes + 1)) * 0.05
    sign = np.where(np.arange(1, modes + 1) % 2, -2.0, 2.0)
    u[0] = -sign @ u[1:] - 0.5
    motion = run(system, Start.modal(u, v), modes=modes, stop=Stop(impacts=1000, periodic=False))
    assert motion.impacts == 1000 and np.all(motion.events.energy_lost == 0.0)
    t = np.sort(rng.uniform(0.0, motion.end_time, 400))
    total = motion.energy(t) - push * motion.position(0.0, t)[0]
    assert np.ptp(total) < 1e-11 * np.abs(total).max()
    assert np.ptp(motion.energy(t)) > 1e6 * np.ptp(total)  # it goes to and fro


def test_what_an_impact_takes():
    system = System(s=4.0, d=0.02, restitution=0.35, load=Load.harmonic(0.8, 1.0))
    motion = run(system, Start.random(system, 3, "ringing", modes=5), modes=5, stop=Stop(impacts=60, periodic=False))
    hits = motion.events.of("impact")
    assert len(hits) == 60
    before, after = motion.energy(hits.time, "left"), motion.energy(hits.time)
    assert np.abs(before - after - hits.energy_lost).max() < 1e-11 * before.max()
    weight = np.where(np.arange(6) == 0, 0.5, 1.0)
    velocity = motion.modal(hits.time, "left").velocity
    assert hits.kinetic_energy == pytest.approx(weight @ velocity**2, rel=1e-9, abs=1e-13)
    assert hits.energy_lost == pytest.approx((1.0 - 0.35**2) * hits.kinetic_energy, rel=1e-13)


def test_convergence_in_the_number_of_modes():
    # what the modes left out add to the gap is Σ cos(…)/(nπs)²: times err by 1/N². Their velocities jump, like a wave:
    # speeds err by 1/N
    system = System(s=5.0, d=0.0048, restitution=0.6, load=Load.harmonic(0.7, 1.0))
    counts = np.array([8, 16, 32, 64, 128])

    def impacts(modes):
        motion = run(system, Start.rigid(position=-1.0, time=0.3), modes=modes, stop=Stop(impacts=8, periodic=False))
        return motion.events.time, motion.events.impact_velocity

    reference = impacts(4096)
    errors = np.array([[np.abs(a - b).max() for a, b in zip(impacts(int(n)), reference, strict=True)] for n in counts])
    slopes = np.polyfit(np.log(counts), np.log(errors), 1)[0]
    assert -2.7 < slopes[0] < -1.7
    assert -1.5 < slopes[1] < -0.6
