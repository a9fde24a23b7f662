"""The simulator and the closed-form steady motions, which share no code, agree: an orbit is kept, and what is near it
departs or returns as its exact multipliers say."""

import numpy as np
import pytest
from scipy.optimize import linear_sum_assignment

from percuss import Load, System, steady_states
from percuss.simulate import Start, Stop, run
from percuss.stability import floquet_multipliers, stability_of

TURN = 2.0 * np.pi


def away(a, b):
    """Distance of phases."""
    return np.abs((np.asarray(a) - b + np.pi) % TURN - np.pi)


SYSTEMS = {
    "long bar": (System(s=20.0, d=0.0048, restitution=0.6, load=Load.harmonic(0.9, 1.0)), 1),
    "short waves": (System(s=1.7, d=0.02, restitution=0.55, load=Load.harmonic(0.85, 1.0)), 1),
    "damped": (System(s=3.0, d=0.7, restitution=0.6, load=Load.harmonic(0.3, 1.0)), 1),
    "every second": (System(s=5.0, d=0.05, restitution=0.8, load=Load.harmonic(0.5, 1.0)), 2),
    "harmonics": (System(s=7.0, d=0.01, restitution=0.5, load=Load.fourier([0.7, 1.0, 0.3 - 0.2j, 0.1j, -0.05])), 1),
    "cut square": (System(s=4.0, d=0.1, restitution=0.5, load=Load.fourier(Load.square(1.0, 1.2, 12).coefficients)), 1),
}


def orbits_of(name, modes):
    system, periods = SYSTEMS[name]
    return [orbit for orbit in steady_states(system, periods, modes=modes).orbits if orbit.admissible]


def state_of(orbit, modes):
    """u_n, u_n' just after the impact, in the form that `Start.orbit` makes."""
    u, v, _ = Start.orbit(orbit).state(modes)
    return u, v


CASES = [(name, modes) for name in SYSTEMS for modes in (0, 1, 8)]


@pytest.mark.parametrize(("name", "modes"), CASES)
def test_an_orbit_is_kept(name, modes):
    orbits = orbits_of(name, modes)
    assert orbits
    for orbit in orbits:
        largest = floquet_multipliers(orbit, modes).largest
        impacts = 50 if largest < 1.0 + 1e-9 else min(50, int(np.log(1e4) / np.log(largest)))
        bound = 1e-9 if largest < 1.0 + 1e-9 else 1e-14 * largest**impacts * 1e3
        motion = run(orbit.system, Start.orbit(orbit), modes=modes, stop=Stop(impacts=impacts, periodic=False))
        assert motion.impacts == impacts
        assert away(motion.events.phase, orbit.phase).max() < bound
        expected = orbit.impact_history(impacts + 1)[1:]
        assert np.abs(motion.events.time - expected[:, 0]).max() < bound * impacts + 1e-12 * expected[-1, 0]
        assert np.abs(motion.events.impact_velocity / orbit.impact_velocity - 1.0).max() < 10.0 * bound
        assert np.abs(motion.events.rebound_velocity / orbit.rebound_velocity - 1.0).max() < 10.0 * bound
        assert motion.events.kinetic_energy == pytest.approx(orbit.blow_energy, rel=10.0 * bound)


def test_a_stable_orbit_is_found_and_named():
    for name, modes in CASES:
        for orbit in orbits_of(name, modes):
            if floquet_multipliers(orbit, modes).largest > 0.95:
                continue
            motion = run(orbit.system, Start.orbit(orbit, velocity=[-1e-4]), modes=modes)
            assert (motion.label, motion.outcome) == (f"z=1/{orbit.periods}", "periodic")
            assert away(motion.events.phase[-1], orbit.phase) < 1e-7


# -- the map from impact to impact, by differences -------------------------------------------------------------------


def start_of(x, modes):
    """A start on the wall from phase, u_1 … u_N, u_0' … u_N'."""
    sign = np.where(np.arange(1, modes + 1) % 2, -2.0, 2.0)
    u = np.concatenate([[-sign @ x[1 : modes + 1]], x[1 : modes + 1]])
    return Start.modal(u, x[modes + 1 :], x[0])


def mapped(system, x, modes, impacts=1):
    """The state after the next impacts, in the same form."""
    motion = run(system, start_of(x, modes), modes=modes, stop=Stop(impacts=impacts, periodic=False))
    assert motion.impacts == impacts == len(motion.events)
    return np.concatenate([[motion.events.phase[-1]], motion.displacement[-1, 1:], motion.velocity[-1]])


def derivative(system, x, modes, step=2e-6, impacts=1):
    """Of the map at x, by central differences of the fourth order."""
    columns = []
    for i in range(x.size):
        e = np.zeros(x.size)
        e[i] = step
        moved = [mapped(system, x + h * e, modes, impacts) for h in (1.0, -1.0, 2.0, -2.0)]
        first, second = moved[0] - moved[1], moved[2] - moved[3]
        for part in (first, second):
            part[0] = (part[0] + np.pi) % TURN - np.pi
        columns.append((8.0 * first - second) / (12.0 * step))
    return np.array(columns).T


def vector(orbit, modes):
    u, v = state_of(orbit, modes)
    return np.concatenate([[orbit.phase], u[1:], v])


@pytest.mark.parametrize(("name", "modes"), [case for case in CASES if case[1] != 1])
def test_multipliers(name, modes):
    for orbit in orbits_of(name, modes):
        found = np.linalg.eigvals(derivative(orbit.system, vector(orbit, modes), modes))
        exact = stability_of(orbit, modes=modes).multipliers.values
        distance = np.abs(found[:, None] - exact[None, :])
        rows, columns = linear_sum_assignment(distance)
        assert distance[rows, columns].max() < 1e-5 * max(1.0, np.abs(exact[0]))


def test_elastic_instability_beyond_b77():
    # theory §5: B77's criterion calls it stable
    system = System(s=5.0, d=0.0, restitution=0.8, load=Load.harmonic(0.9, 1.0))
    moduli = []
    for orbit in steady_states(system, 2, modes=8).orbits:
        values = np.linalg.eigvals(derivative(system, vector(orbit, 8), 8, step=1e-5))
        moduli.append(np.abs(values).max())
    assert min(abs(modulus - 1.000147) for modulus in moduli) < 2e-6


@pytest.mark.parametrize("modes", [0, 8])
@pytest.mark.parametrize("name", ["long bar", "short waves", "harmonics"])
def test_growth_of_a_perturbation(name, modes):
    seen = set()
    for orbit in orbits_of(name, modes):
        x = vector(orbit, modes)
        values, vectors = np.linalg.eig(derivative(orbit.system, x, modes))
        exact = stability_of(orbit, modes=modes)
        order = np.argsort(-np.abs(values))
        largest = values[order[0]]
        if abs(largest.imag) > 1e-6 or abs(largest) < 0.05:
            continue
        direction = vectors[:, order[0]].real
        impacts = 4
        size = 1e-6 / max(abs(largest) ** impacts, 1.0)
        ahead = direction * size / np.abs(direction).max()
        plus, minus = (mapped(orbit.system, x + side * ahead, modes, impacts) for side in (1.0, -1.0))
        grown = 0.5 * (plus - minus)
        i = np.abs(ahead).argmax()
        assert grown[i] / ahead[i] == pytest.approx(exact.multipliers.values[0].real ** impacts, rel=1e-3)
        seen.add(exact.stable)
    assert False in seen  # the stable ones turn as they shrink: see test_multipliers
