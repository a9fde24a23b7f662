"""Hammers drawn at random over the whole parameter space, for what must hold of every one of them."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from percuss import Kept, Load, System
from percuss.model import External, KelvinVoigt, ModalBody, Ratio, Reversed, UniformBar

__all__ = ["RandomHammer", "random_hammer", "random_structure"]

TURN = 2.0 * math.pi


class RandomHammer(NamedTuple):
    """A system and how many elastic modes it has."""

    system: System
    modes: int


def random_hammer(seed: int) -> RandomHammer:
    """A hammer with 0, 8 or 32 modes, soft or stiff, undamped to overdamped, of any R, under harmonics or steps."""
    random = np.random.default_rng([16, seed])
    modes = (0, 8, 32)[seed % 3]
    rebound = float(random.choice([0.0, 1.0, *random.uniform(0.0, 0.95, 6)]))
    size = float(10.0 ** random.uniform(-5.0, 0.7))
    laws = [External(0.0), External(size), External(size), Ratio(min(size, 1.0)), KelvinVoigt(size)]
    law = laws[int(random.integers(len(laws)))]
    contact = Reversed(rebound) if random.random() < 0.2 else Kept(rebound)
    speed = float(10.0 ** random.uniform(-0.3, 1.5))
    return RandomHammer(System(UniformBar(speed, law), random_load(random, rebound), contact), modes)


def random_structure(seed: int) -> System:
    """A structure of two or three modes near its stop, hardly damped to overdamped, under harmonics or steps."""
    random = np.random.default_rng([7, seed])
    modes = int(random.integers(2, 4))
    omega, delta = np.sort(random.uniform(1.5, 12.0, modes)), 10.0 ** random.uniform(-2.0, 0.7, modes)
    contact, drive = random.uniform(0.3, 1.5, modes), random.uniform(-1.0, 1.0, modes)
    load = (Load.harmonic(0.0, 1.0), Load.square(1.0, 1.2), Load.fourier([0.1, 0.6, 0.3j]))[seed % 3]
    body = ModalBody(tuple(omega), tuple(delta), tuple(contact), tuple(drive), float(random.uniform(-0.06, 0.01)))
    return System(body, load, Kept(float(random.choice([0.0, 0.2, 0.4, 0.6]))))


def random_load(random: np.random.Generator, rebound: float) -> Load:
    """Up to four harmonics, or two to four steps, with a mean at which motions with an impact in each period exist."""
    push = random.uniform(0.1, 1.1) * (1.0 + rebound) / (1.0 - min(rebound, 0.9)) / math.pi
    if random.random() < 0.6:
        number = int(random.integers(1, 5))
        waves = (random.normal(size=number) + 1j * random.normal(size=number)) / np.arange(1, number + 1)
        return Load.fourier([min(push, 2.0) * float(np.abs(waves).max()), *waves.tolist()])
    number = int(random.integers(2, 5))
    breaks = np.sort(random.uniform(0.0, TURN, number))
    values = random.normal(size=number)
    shares = np.diff(breaks, append=breaks[0] + TURN) / TURN
    values += min(push, 2.0) * float(np.ptp(values)) / 2.0 - float(shares @ values)
    return Load.steps(breaks.tolist(), values.tolist())
