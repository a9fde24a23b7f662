"""Phases of blows that take time against a uniform bar whose waves are followed on a lattice, blow by blow."""

from __future__ import annotations

import math

import numpy as np
import pytest

from percuss import Load, System, Timed, timed_states
from percuss.steady import TimedOrbit

CELLS = 64


class Waves:
    """A uniform bar of impedance s before a rod of impedance `rod` that stays where it is pushed; mass 1, length 1.

    Waves move by a cell in a step. A cell in which the contact begins is shared in proportion, and one that ends a
    contact is not, so that a phase is right to about a cell.
    """

    def __init__(self, system: System, rod: float, phase: float, velocity: float) -> None:
        self.system, self.rod, self.time = system, rod, phase
        self.ahead, self.back = np.full(CELLS, 0.5 * velocity), np.full(CELLS, 0.5 * velocity)
        self.gap, self.step = 0.0, 1.0 / (system.s * CELLS)

    def followed(self, blows: int) -> np.ndarray:
        """The phases of the force's centroid of so many blows."""
        phases, impulse, moment = [], 0.0, 0.0
        while len(phases) < blows:
            push = self._push()
            middle = self.time + 0.5 * self.step
            impulse, moment = impulse + push, moment + push * middle
            if push == 0.0 and impulse > 0.0:
                phases.append(moment / impulse)
                impulse = moment = 0.0
            self.time += self.step
        return np.mod(phases, math.tau)

    def _push(self) -> float:
        """One step; the impulse on the bar in it."""
        s, coming = self.system.s, float(self.ahead[-1])
        load = float(self.system.load.value(self.time + 0.5 * self.step))
        closed = 1.0 if self.gap == 0.0 and coming > 0.0 else 0.0
        left = self.gap - 2.0 * coming * self.step
        if not closed:
            if self.gap > 0.0 and left <= 0.0:
                closed = 1.0 - self.gap / (2.0 * coming * self.step)
            self.gap = max(left, 0.0)
        face = 2.0 * s * coming / (s + self.rod)
        returned = closed * (face - coming) + (1.0 - closed) * coming
        driven = float(self.back[0]) + load / s
        self.ahead = np.append(driven, self.ahead[:-1])
        self.back = np.append(self.back[1:], returned)
        velocity, strain = self.ahead + self.back, self.ahead - self.back
        velocity = velocity * math.exp(-self.system.d * self.step)
        self.ahead, self.back = 0.5 * (velocity + strain), 0.5 * (velocity - strain)
        return closed * s * (2.0 * coming - face) * self.step


def settled(system: System, orbit: TimedOrbit) -> float:
    """How much later than the law says the blows come, on average over the last ones, in radians."""
    ratio = (1.0 - system.restitution) / (1.0 + system.restitution)
    rod = system.s / ratio if ratio else 1e12 * system.s
    waves = Waves(system, rod, orbit.phase + 1.0 / system.s, orbit.rebound_velocity)
    return float(np.mean(waves.followed(22)[10:]) - orbit.phase)


@pytest.mark.parametrize(
    ("r", "mean", "d", "apart"),
    [(0.6, 0.9, 0.0, 0.04), (0.3, 0.5, 0.0, 0.06), (0.6, 0.5, 0.3, 0.1), (0.6, 0.35, 0.6, 0.1)],
)
def test_the_waves_in_a_uniform_bar_strike_when_the_law_says(r: float, mean: float, d: float, apart: float) -> None:
    """At s = 5, where the phase is off by far more when the duration or the drag during the contact is left out."""
    system = System(5.0, d, r, Load.harmonic(mean, 1.0))
    orbit = timed_states(system, Timed.of_uniform_bar(5.0, r)).orbits[-1]
    assert orbit.phase_shift is not None and orbit.phase_shift > apart
    assert settled(system, orbit) == pytest.approx(0.0, abs=0.015)


def test_the_drag_counts_during_a_contact_with_a_wall() -> None:
    system = System(5.0, 0.3, 1.0, Load.harmonic(0.9, 1.0))
    orbit = timed_states(system, Timed.of_uniform_bar(5.0, 1.0)).orbits[-1]
    assert orbit.phase_shift is not None and orbit.phase_shift > 0.1
    assert settled(system, orbit) == pytest.approx(0.0, abs=0.02)
