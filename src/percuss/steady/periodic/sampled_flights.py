"""The flights of an orbit at many samples: the greatest maximum of the gap function, and a quick proof with bounds."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from percuss.steady.periodic.impact_motion import ImpactMotion
from percuss.steady.periodic.orbit_kernels import orbit_kernels
from percuss.steady.periodic.system_numbers import numbers_of

__all__ = ["SampledFlights", "sampled_flights", "samples_are_many"]

PER_WAVE = 8.0
MOST = 3e7  # samples of a mode in a cycle, which take a tenth of a second


class SampledFlights(NamedTuple):
    """What samples of the flights tell.

    Parameters
    ----------
    height
        The greatest local maximum of the gap function inside the flights; minus infinity where there is none.
    time, flight
        When, after the impact from which that flight starts, and the number of the flight.
    proven
        Whether they prove, with a bound of y'' over each flight, that each impact strikes and the bar stays off the
        wall between them. That they do not means nothing: the bar may be near the wall somewhere.
    """

    height: float
    time: float
    flight: int
    proven: bool


@lru_cache(maxsize=64)
def sampled_flights(motion: ImpactMotion) -> SampledFlights:
    """Look at the flights eight times in each period of the fastest mode, by compiled functions; the last are kept."""
    numbers, found = numbers_of(motion.system, motion.modes), np.empty(4)
    rebound = float(motion.rigid_rebounds[0]) if motion.rebound is None else motion.rebound
    place = np.array([*motion.times, rebound])
    orbit_kernels().flown(numbers.row, numbers.room(motion.impacts), motion.period, place, found)
    height, time, flight, proven = found.tolist()
    return SampledFlights(height if not math.isnan(height) else -math.inf, time, int(flight), proven == 1.0)


def samples_are_many(motion: ImpactMotion) -> bool:
    """Whether the samples of a cycle would take longer than a proof flight by flight: at very large s."""
    if motion.modes == 0:
        return False
    fastest = float(motion.system.body.modes(motion.modes, motion.system.load.at).omega[-1])
    return PER_WAVE * fastest * motion.period / (2.0 * math.pi) * motion.modes > MOST
