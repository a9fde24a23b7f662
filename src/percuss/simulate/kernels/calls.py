"""The records of a call: when a motion ends, where motions start, what is recorded, and what is kept of each."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from percuss.simulate.kernels.layout import Floats, Wholes


class Rules(NamedTuple):
    """When a motion ends. `skip`: impacts that the sums leave out; `budget`: evaluations at which the call returns."""

    end_period: float
    end_phase: float
    most_impacts: int
    until_cycle: bool
    tolerance: float
    skip: int
    budget: int


EVENT = np.dtype(
    [
        ("phase", "f8"),
        ("before", "f8"),
        ("after", "f8"),
        ("lost", "f8"),
        ("kinetic", "f8"),
        ("kind", "i8"),
        ("period", "i8"),
        ("resolved", "i8"),
        ("piece", "i8"),
    ]
)


class Log(NamedTuple):
    """The record of a stretch of motion: EVENTs, and the state after each: gap, u_0', and the two rows of z."""

    events: npt.NDArray[np.void]
    states: Floats


STATE_NUMBERS = 2  # columns of a state before its amplitudes


class Starts(NamedTuple):
    """u_n and u_n', n = 0, 1, …, of the starts of many motions, rows; their gaps, and their clocks."""

    displacement: Floats
    velocity: Floats
    gap: Floats
    phase: Floats
    period: Wholes
    piece: Wholes


MEMBER = np.dtype(
    [
        ("ended", "i8"),
        ("strikes", "i8"),
        ("first", "i8"),
        ("cycle_impacts", "i8"),
        ("cycle_periods", "i8"),
        ("cycle_kind", "i8"),
        ("wanders", "i8"),
        ("end_time", "f8"),
        ("blow_rate", "f8"),
        ("main_blow_rate", "f8"),
        ("interval_mean", "f8"),
        ("interval_std", "f8"),
        ("main_interval_mean", "f8"),
        ("main_interval_std", "f8"),
        ("impact_velocity", "f8"),
        ("blow_energy", "f8"),
        ("energy_lost_per_period", "f8"),
    ]
)
"""What is kept of a member of an ensemble."""
