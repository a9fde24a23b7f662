"""Orbits with several impacts and the simulator, which share no code: a motion started on an orbit stays on it."""

from __future__ import annotations

import math

import numpy as np
import pytest

from percuss import Kept, Load, System
from percuss.model import KelvinVoigt, Ratio, Reversed, SteppedBar, UniformBar
from percuss.simulate import Start, Stop, run
from percuss.steady import PeriodicOrbit, orbits

COSINE, THREE = Load.harmonic(0.62, 1.0), Load.fourier([0.5, 1.0, 0.4j, -0.2])
SYSTEMS = {
    "rigid": (System(s=5.0, d=0.0, restitution=0.5, load=COSINE), 0, [(2, 1), (3, 1), (2, 2), (5, 1)]),
    "eight modes": (System(s=5.0, d=0.0048, restitution=0.5, load=COSINE), 8, [(2, 1), (2, 2)]),
    "thirty-two modes": (System(s=20.0, d=0.02, restitution=0.5, load=COSINE), 32, [(2, 1)]),
    "dragged": (System(s=3.0, d=0.4, restitution=0.6, load=Load.harmonic(0.4, 1.0)), 4, [(2, 1), (2, 2)]),
    "harmonics": (System(s=2.0, d=0.01, restitution=0.6, load=THREE), 6, [(2, 1), (3, 2)]),
    "waves turned over": (System(UniformBar(5.0, Ratio(1e-3)), COSINE, Reversed(0.5)), 8, [(2, 1), (2, 2)]),
    "overdamped": (System(UniformBar(1.0, KelvinVoigt(0.2)), THREE, Kept(0.5)), 5, [(2, 1), (2, 2)]),
    "square": (System(s=5.0, d=0.01, restitution=0.5, load=Load.square(1.0, 1.2)), 8, [(2, 2)]),
    "steps": (System(s=5.0, d=0.05, restitution=0.4, load=Load.steps([0.0, 1.5, 3.5], [1.4, 0.5, -0.9])), 0, [(2, 3)]),
    "full rebound": (System(s=5.0, d=0.0, restitution=1.0, load=Load.fourier([0.2, 1.0, 0.4j, 0.3])), 0, [(2, 2)]),
    "stepped": (System(SteppedBar(6.0, (1.0, 2.0), (1.0, 1.0)), COSINE, Kept(0.5)), 5, [(2, 1)]),
}
FOUND: dict[str, list[PeriodicOrbit]] = {}


def found(name: str) -> list[PeriodicOrbit]:
    """The orbits of a system, searched for once."""
    if name not in FOUND:
        system, modes, labels = SYSTEMS[name]
        FOUND[name] = [orbit for p, n in labels for orbit in orbits(system, p, n, modes=modes, tries=128).orbits]
    return FOUND[name]


@pytest.mark.parametrize("name", SYSTEMS)
def test_a_motion_started_on_an_orbit_stays_on_it(name: str) -> None:
    assert found(name)
    for orbit in found(name):
        largest = max(1.0, orbit.multipliers().largest)
        motion = run(orbit.system, Start.orbit(orbit), modes=orbit.modes, stop=Stop(orbit.impacts, periodic=False))
        assert len(motion.events) == motion.impacts == orbit.impacts
        times = np.append(orbit.times[1:], orbit.times[0] + orbit.period)
        room = 1e-11 * max(1.0, largest / 10.0)
        assert motion.events.time == pytest.approx(times, rel=0, abs=room)
        assert motion.events.impact_velocity == pytest.approx(np.roll(orbit.speeds, -1), rel=0, abs=10.0 * room)
        assert motion.events.kinetic_energy == pytest.approx(np.roll(orbit.blow_energies, -1), rel=0, abs=10.0 * room)


def test_a_stable_orbit_is_found_by_the_simulation_and_has_its_label() -> None:
    system = System(s=5.0, d=0.0, restitution=0.5, load=Load.harmonic(0.665, 1.0))
    stable = [orbit for orbit in orbits(system, 2, modes=0, tries=60).orbits if orbit.multipliers().stable]
    assert len(stable) == 1
    motion = run(system, Start.orbit(stable[0], velocity=[-1e-4]), modes=0)
    assert (motion.label, motion.outcome) == (stable[0].label, "periodic")
    last = np.sort(np.mod(motion.events.time[-2:], 2.0 * math.pi))
    assert last == pytest.approx(np.sort(stable[0].phases), abs=1e-7)


@pytest.mark.parametrize("name", ["rigid", "harmonics", "waves turned over", "square", "dragged"])
def test_multipliers_by_differences_of_the_simulated_cycle(name: str) -> None:
    """A disturbance of the state after the first impact, carried through the cycle, moves as W says.

    The start stands at the wall, so that only disturbances which leave the striking end there are made; the later time
    of the last impact is taken back to a fixed one by the motion after it.
    """
    orbit = min(found(name), key=lambda one: one.multipliers().largest)
    modes, p = orbit.modes, orbit.impacts
    gamma = np.append(1.0, orbit.system.body.modes(modes, orbit.system.load.at).gamma)
    whole, step = orbit.map().dense(), 1e-6
    for direction in (np.eye(modes + 1)[0], np.eye(modes + 1)[-1]):  # of the velocities
        ends = []
        for sign in (1.0, -1.0):
            start = Start.orbit(orbit, velocity=tuple(sign * step * direction))
            motion = run(orbit.system, start, modes=modes, stop=Stop(p, periodic=False))
            assert motion.impacts == p
            u, v, when = motion.displacement[-1], motion.velocity[-1], motion.events.time[-1]
            known = orbit.system.body.modes(modes, orbit.system.load.at)
            omega, damping = np.append(0.0, known.omega), np.append(orbit.system.d, known.damping)
            force = float(orbit.system.load.value(when))
            back = orbit.times[0] + orbit.period - when
            rate = force - damping * v - omega**2 * u
            ends.append((u + v * back, v + rate * back))
        moved = [(one - other) / (2.0 * step) for one, other in zip(*ends, strict=True)]
        u, v = np.zeros_like(direction), direction
        wanted = whole @ np.stack([u, v], axis=1).reshape(-1)
        scale = np.abs(wanted).max()
        assert moved[0] == pytest.approx(wanted[0::2], abs=1e-4 * scale)
        assert moved[1] == pytest.approx(wanted[1::2], abs=1e-4 * scale)
        assert gamma.size == direction.size
