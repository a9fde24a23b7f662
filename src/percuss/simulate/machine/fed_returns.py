"""Whether the blows of a machine with a supply repeat: speed, pressure and orders together."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from percuss.model.checks import Array
from percuss.simulate.kernels.codes import VALVE
from percuss.simulate.machine.machine_summary import MachineCycle

__all__ = ["Blow", "cycle_in"]

_MOST_IN_CYCLE = 16
_TWICE = 2  # times in a row that a cycle must be met


class Blow(NamedTuple):
    """A blow: when, how fast, what it took, and the state just after it; `event` counts the events up to it."""

    time: float
    speed: float
    lost: float
    label: tuple[str, ...]
    numbers: Array
    event: int
    rested: bool


def cycle_in(blows: Sequence[Blow], events: Sequence[tuple[float, ...]], tolerance: float) -> MachineCycle | None:
    """The cycle that the last blows have been on twice, of at most 16 of them."""
    for n in range(1, _MOST_IN_CYCLE + 1):
        if len(blows) <= _TWICE * n:
            return None
        last = blows[-_TWICE * n :]
        before = blows[-_TWICE * n - n : -n]
        if all(_alike(now, then, tolerance) for now, then in zip(last, before, strict=False)):
            return _cycle(blows, events, n)
    return None


def _alike(now: Blow, then: Blow, tolerance: float) -> bool:
    if now.label != then.label:
        return False
    scale = np.maximum(np.abs(now.numbers), np.abs(then.numbers))
    return bool(np.all(np.abs(now.numbers - then.numbers) <= tolerance * np.maximum(scale, 1e-6)))


def _cycle(blows: Sequence[Blow], events: Sequence[tuple[float, ...]], n: int) -> MachineCycle:
    own = blows[-n:]
    changes = [int(event[6]) for event in events[blows[-n - 1].event : blows[-1].event] if event[0] == VALVE]
    turns = changes.count(changes[0]) if changes else 1
    return MachineCycle(
        first=max(len(blows) - (_TWICE + 1) * n, 0),
        blows=n,
        valve_cycles=turns,
        kind=int(any(blow.rested for blow in own)),
        period=own[-1].time - blows[-n - 1].time,
        energy_lost=float(sum(blow.lost for blow in own)),
        blow_speed=max(blow.speed for blow in own),
    )
