"""What ends a branch of cycles with rest, told by the impacts that follow the releases on either side."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np

from percuss.explore.continuation.rest_branch import RestBranchPoint, RestEvent
from percuss.explore.continuation.rest_words import (
    after_change,
    after_grazing,
    after_onset,
    another_rest,
    without_release,
)
from percuss.model.contact.falling_push import FallingPush
from percuss.steady import RestCycle
from percuss.steady.resting.chain import Chain

__all__ = ["alike", "rest_end", "short_rest"]

_JUMP = 1.4  # factor by which a flight may change in a step
_AHEAD = 1.5
_SHORT = 1e-2  # rad of rest below which the rest is about to vanish
_FEW = 1e-3  # of the greatest speed: slower impacts belong to the chatter


def rest_end(value: float, cycle: RestCycle, chains: tuple[Chain, ...], is_system: bool) -> RestBranchPoint:
    """What ends the branch between a cycle and what was followed just beyond."""
    if not is_system:
        return RestBranchPoint(RestEvent.NO_SYSTEM, value, cycle, "there is no such system")
    if not chains:
        return RestBranchPoint(RestEvent.RELEASE_LOST, value, cycle, without_release(cycle))
    other = _first_other(cycle.chains, chains)
    if other is not None:
        kind, phase, impact = other
        return RestBranchPoint(kind, value, cycle, after_grazing(cycle, kind is RestEvent.TOUCH), phase, impact)
    if float(cycle.rest_times.min()) < short_rest(cycle):
        return RestBranchPoint(RestEvent.ONSET, value, cycle, after_onset(cycle))
    waits = [np.mod(after.release - (one.rest or math.nan), 2.0 * math.pi) for one, after in pairwise(chains)]
    if waits and float(np.nanmin([*waits, math.inf])) < _SHORT:
        return RestBranchPoint(RestEvent.ONSET, value, cycle, another_rest(cycle))
    return RestBranchPoint(RestEvent.CHANGE, value, cycle, after_change(cycle, chains))


def short_rest(cycle: RestCycle) -> float:
    """The rest, in rad of the load, below which the rest of a cycle is about to vanish.

    By a law that turns the strain over the bar is held 1/(2c) contacts before the load lets go: see `FallingPush`.
    """
    contact, restitution = cycle.system.contact, -cycle.system.contact.velocity_factor
    if contact.keeps_strain or not 0.0 < restitution < 1.0:
        return _SHORT
    return max(_SHORT, _AHEAD * cycle.system.body.transit_time / FallingPush(restitution).critical)


def alike(chains: tuple[Chain, ...], others: tuple[Chain, ...]) -> bool:
    """Whether the same impacts follow each release, so that the second chains go on from the first ones."""
    return len(chains) == len(others) and _first_other(chains, others) is None


def _first_other(chains: tuple[Chain, ...], others: tuple[Chain, ...]) -> tuple[RestEvent, float, int] | None:
    """The first impact that one of the chains has and the other has not, its phase and its number; None for none."""
    before = 0
    for one, other in zip(chains, others, strict=False):
        if not (one.impacts and other.impacts):
            continue
        last, its_last = one.release, other.release
        many = min(_notable(one), _notable(other))
        for number, (mine, its) in enumerate(zip(one.impacts[:many], other.impacts[:many], strict=True), 1):
            ratio = (its.time - its_last) / (mine.time - last)
            slow, fast = sorted((mine.speed, its.speed))
            if not 1.0 / _JUMP < ratio < _JUMP or slow < _FEW * fast:
                touch = its.speed < mine.speed  # what is born or dies is slow
                where = its.time if touch else mine.time
                kind = RestEvent.TOUCH if touch else RestEvent.DEATH
                return kind, float(np.mod(where, 2.0 * math.pi)), before + number
            last, its_last = mine.time, its.time
        before += len(one.impacts)
    return None


def _notable(chain: Chain) -> int:
    """How many impacts there are up to the last that is not of the end of a chatter."""
    fastest = max(impact.speed for impact in chain.impacts)
    return max(i for i, impact in enumerate(chain.impacts, 1) if impact.speed >= _FEW * fastest)
