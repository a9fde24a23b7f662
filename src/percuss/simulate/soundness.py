"""What a saved motion must be before anything is made of it; of what it goes on from see `percuss.simulate.restored`.

A file may be cut short, changed by a bad disk, or made by somebody who means harm. Shapes and types follow from the
number of modes; whole numbers that are used as places in an array must be places in it; all others must be finite, and
where they count something, no less than 0. Impacts must obey the impact law.
"""

from __future__ import annotations

import math
from dataclasses import fields
from typing import Any

import numpy as np
import numpy.typing as npt

from percuss.model.checks import count, finite
from percuss.simulate.events import IMPACT, KINDS, Events
from percuss.simulate.flight import Anchor
from percuss.simulate.simulated_motion import SimulatedMotion
from percuss.simulate.stop import MAX_MODES, MOST_IMPACTS, OUTCOMES
from percuss.simulate.summary import Cycle

__all__ = ["MOST_PERIODS", "TURN", "numbers", "shaped", "sound", "true", "within"]

_MOST = 1e100
"""No number of a motion is greater: its square must not overflow."""

MOST_PERIODS = 2**53
_ROUNDING = 1e-9
TURN = 2.0 * math.pi
_EVENT_TYPES = {"code": np.int8, "period": np.int64, "resolved": np.int64, "piece": np.int64}
"""Of the columns of events; the others are float64."""


def sound(motion: SimulatedMotion) -> None:
    """Refuse a motion of which not all can be what a simulation has left.

    Raises
    ------
    ValueError
        Which says what cannot be.
    """
    modes = count("modes", motion.modes, least=0, most=MAX_MODES)
    true(motion.outcome in OUTCOMES, f"outcome {str(motion.outcome)[:40]!r}")
    true(isinstance(motion.label, str) and len(motion.label) <= 100, "label")
    true(isinstance(motion.resting, bool), "resting")
    begin, end = finite("begin_time", motion.begin_time), finite("end_time", motion.end_time)
    true(begin <= end, "end_time")
    pieces = max(len(motion.system.load.values), 1)
    _start(motion.start, modes, pieces)
    _events(motion.events, pieces)
    numbers("state", motion.states, (len(motion.events), 2 + 2 * modes))
    _impacts(motion)
    impacts = int(np.count_nonzero(motion.events.code == IMPACT))
    _cycle(motion.cycle, impacts)


def true(good: object, what: str) -> None:
    """Refuse what does not hold."""
    if not good:
        raise ValueError(f"{what} is impossible")


def shaped(name: str, values: npt.NDArray[Any], dtype: npt.DTypeLike, shape: tuple[int, ...]) -> None:
    """Refuse another type or shape."""
    true(isinstance(values, np.ndarray) and values.dtype == np.dtype(dtype), f"the type of {name}")
    true(values.shape == shape, f"the shape {values.shape} of {name}")


def numbers(name: str, values: npt.NDArray[Any], shape: tuple[int, ...]) -> None:
    """Refuse what is not an array of finite numbers of this shape."""
    shaped(name, values, np.float64, shape)
    true(np.all(np.abs(values) <= _MOST), f"a value of {name}")  # false of NaN too


def within(name: str, values: npt.ArrayLike, low: float, high: float) -> None:
    """Refuse numbers outside of an interval, and NaN."""
    array = np.asarray(values)
    true(np.all((array >= low) & (array <= high)), f"a value of {name}")


def _start(start: Anchor, modes: int, pieces: int) -> None:
    within("start_phase", finite("start_phase", start.phase), 0.0, TURN)
    count("start_piece", start.piece, least=0, most=pieces - 1)
    numbers("start_state", np.array([start.gap, start.rigid_rate]), (2,))
    numbers("start_state", start.z, (2, modes))


def _events(events: Events, pieces: int) -> None:
    shape = np.shape(events.code)
    true(len(shape) == 1, "the shape of code")
    for field in fields(Events):
        values = getattr(events, field.name)
        if field.name in _EVENT_TYPES:
            shaped(field.name, values, _EVENT_TYPES[field.name], shape)
        else:
            numbers(field.name, values, shape)
    within("code", events.code, 0, len(KINDS) - 1)
    within("period", events.period, -MOST_PERIODS, MOST_PERIODS)
    within("phase", events.phase, 0.0, TURN)
    within("resolved", events.resolved, 0, MOST_IMPACTS)
    within("piece", events.piece, 0, pieces - 1)
    true(np.all(np.diff(events.time) >= 0.0), "the order of the events")


def _impacts(motion: SimulatedMotion) -> None:
    """The impact law, B77 10, and the wall: what it takes, how fast the end leaves, that nothing is beyond it."""
    contact, events, at = motion.system.contact, motion.events, motion.events.code == IMPACT
    beta = contact.velocity_factor
    speed, blow, most = events.impact_velocity[at], events.kinetic_energy[at], 1.0 + _ROUNDING
    true(np.all(speed >= 0.0) and np.all(blow >= 0.0), "the speed of an impact")
    true(np.all(np.abs(events.rebound_velocity[at] - beta * speed) <= _ROUNDING * speed), "the rebound of an impact")
    taken = (
        events.energy_lost[at] - contact.energy_taken(1.0, 0.0) * blow
    )  # by the strain, where the impact turns it over
    true(np.all((-np.abs(taken) if contact.keeps_strain else taken) >= -_ROUNDING * blow), "what an impact takes")
    true(np.all(events.energy_lost >= 0.0) and not np.any(events.kinetic_energy[~at]), "the energy of an event")
    place, rigid = motion.states[:, 0], motion.states[:, 1]
    noise = _ROUNDING * (1.0 + np.abs(motion.states).max(initial=0.0))
    true(not np.any(place[at]) and np.all(place <= noise), "the place of an event")
    true(np.all(np.abs(rigid[at]) <= most * abs(beta) * np.sqrt(2.0 * blow)), "the mean velocity after an impact")


def _cycle(cycle: Cycle | None, impacts: int) -> None:
    if cycle is None:
        return
    count("first", cycle.first, least=0, most=impacts)
    count("impacts", cycle.impacts, least=1, most=max(impacts, 1))
    count("periods", cycle.periods, least=0, most=MOST_PERIODS)
    count("kind", cycle.kind, least=0, most=2)
