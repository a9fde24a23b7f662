"""Each switch of a recorded force with the motion before it: when, where and in which direction it was seen."""

from __future__ import annotations

import math

import numpy as np

from percuss.model.checks import Array
from percuss.steady.recorded.edges import WINDOW
from percuss.steady.recorded.force_record import Cycles
from percuss.steady.recorded.implied import Implied
from percuss.steady.recorded.machines_read import RecordedSwitch, state_names
from percuss.steady.recorded.port_and_delay import Doubt, Seen, port_and_delay, spread

__all__ = ["recorded_switch"]

_RESOLVED = 0.3  # of the time between samples: the deviation of an edge that lies anywhere between two
_PAST_TURN = 0.1
_AT_ONCE = 1.0 / 512.0  # of a period: a fall no farther from the blow than this is ordered by it


def recorded_switch(
    j: int, number: list[int], forces: list[float], edges: Array, motion: Implied, cycles: Cycles | None, longest: float
) -> RecordedSwitch:
    """One switch of a cycle, from all cycles in which it was seen.

    Parameters
    ----------
    j
        Which edge.
    number, forces
        Of the stretch after each edge its state, and the forces of the states.
    edges
        Times after the blow, of the mean cycle.
    motion, cycles
        Of the mean cycle, and of the single ones where they are known.
    longest
        The longest delay that the valve may have.
    """
    jump = forces[number[j]] - forces[number[j - 1]]
    period = float(motion.blows[-1])
    since = float(edges[j]) if 2.0 * edges[j] < period else float(edges[j]) - period
    still = since * float(motion.at(edges[j] % period)[1]) >= 0.0
    by_blow = jump < 0.0 and since > -_AT_ONCE * period and still
    whole, times = _twice(motion), edges[j : j + 1]
    if cycles is not None:
        whole, times = cycles.motion, cycles.switches[:, j]
    found = [one for t in times if (one := _seen(whole, float(t), jump > 0.0)) is not None]
    if not found:
        cycles, whole = None, _twice(motion)
        found = [one for one in [_seen(whole, float(edges[j]), jump > 0.0)] if one is not None]
    x, v = whole.at([one.time for one in found])
    after = [one.time - whole.blows[np.argmin(np.abs(whole.blows - one.time))] for one in found]
    sample = period / motion.time.size if cycles is None else cycles.sample
    total = math.sqrt(sum((forces[a] - forces[b]) ** 2 for a, b in zip(number, number[-1:] + number[:-1], strict=True)))
    doubt = _doubt(cycles, jump, total, period)
    seen = tuple(one._replace(doubt=doubt) for one in found)
    half = 0.5 * sample  # nothing is known better
    return RecordedSwitch(
        to=state_names(len(forces))[number[j]],
        jump=jump,
        time=spread(np.array(after), half),
        behind=spread(x, half * float(np.abs(v).mean())),
        velocity=spread(v, half * abs(jump)),
        side="back" if jump > 0.0 else "front",
        by_blow=by_blow,
        found=port_and_delay(seen, longest),
        seen=seen,
    )


def _doubt(cycles: Cycles | None, jump: float, jumps: float, period: float) -> Doubt | None:
    """What a record with measured blows leaves in doubt; None where the motion of each single cycle is not known.

    An edge that lies anywhere between two samples counts as noise of the force, as its momentum does; `jumps` is the
    root of the sum of the squares of all jumps.
    """
    if cycles is None or cycles.blows != "measured":
        return None
    momentum = cycles.noise * math.sqrt(2.0 * WINDOW * period * cycles.sample)
    time = math.hypot(_RESOLVED * cycles.sample, momentum / jump)
    between = _RESOLVED * cycles.sample * jumps / math.sqrt(period)
    return Doubt(time, math.hypot(cycles.noise * math.sqrt(cycles.sample), between))


def _seen(motion: Implied, time: float, rises: bool) -> Seen | None:
    """A switch and the times between which its port was passed: on the way back where the force rises."""
    flight = int(np.searchsorted(motion.blows, time, side="right")) - 1
    if not math.isfinite(time) or not 0 <= flight < motion.blows.size - 1:
        return None
    if rises:
        begin = float(motion.blows[flight])
        return Seen(motion, time, begin, min(time, _farthest(motion, flight)), True)
    if motion.at(time)[1] < 0.0:
        return _falling(motion, time, flight, time)
    return None if flight == 0 else _falling(motion, time, flight - 1, float(motion.blows[flight]))


def _falling(motion: Implied, time: float, flight: int, last: float) -> Seen:
    """A port passed on the way to the wall; a little after the turn at the earliest, where it would be touched only."""
    turn = _farthest(motion, flight)
    return Seen(motion, time, turn + _PAST_TURN * (last - turn), last, False)


def _farthest(motion: Implied, flight: int) -> float:
    """When the piston turns, in one flight."""
    inside = (motion.time > motion.blows[flight]) & (motion.time < motion.blows[flight + 1])
    return float(motion.time[inside][np.argmax(motion.behind[inside])])


def _twice(motion: Implied) -> Implied:
    """The mean cycle with the one before it, the blow between them at the time 0."""
    period = float(motion.blows[-1])
    force, behind, velocity = (np.tile(row, 2) for row in (motion.force, motion.behind, motion.velocity))
    time = np.concatenate([motion.time - period, motion.time])
    return Implied(time, force, behind, velocity, np.array([-period, 0.0, period]))
