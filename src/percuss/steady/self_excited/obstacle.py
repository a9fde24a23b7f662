"""What keeps a machine that switches itself from running with one blow in a cycle, and what would be needed."""

from __future__ import annotations

import math
from enum import Enum
from typing import Self, TypedDict

import numpy as np

from percuss.steady.self_excited.elastic_cycle import ElasticCycle
from percuss.steady.self_excited.piston_records import Leg, Piston, Rebound
from percuss.steady.self_excited.rigid_cycle import RigidCycle

__all__ = ["Obstacle", "Reasoned", "latest_return", "why_more_blows", "why_none", "why_several", "why_unstable"]

_LATELY = 12  # flights that tell what a machine without a cycle does


class Obstacle(Enum):
    """What keeps a self-excited machine from running with one blow in a cycle; its value is the word for it.

    Attributes
    ----------
    words
        What happens.
    remedy
        What to do about it.

    Examples
    --------
    >>> Obstacle("stays on the wall").remedy
    'make the return force pull the piston away from the wall at the wall, against the chamber'
    """

    words: str
    remedy: str

    def __new__(cls, word: str, words: str, remedy: str) -> Self:
        made = object.__new__(cls)
        made._value_, made.words, made.remedy = word, words, remedy
        return made

    NO_LOSS = (
        "no loss",
        "nothing takes the energy that the valve puts in, so that the piston strikes faster with every blow",
        "give a restitution below 1, or a drag",
    )
    ON_THE_WALL = (
        "stays on the wall",
        "the piston lies on the wall, is pushed towards it, and no order is pending",
        "make the return force pull the piston away from the wall at the wall, against the chamber",
    )
    NO_PORT = (
        "reaches no port",
        "the piston comes to no port that would change the state, and does not strike",
        "put the port nearer to the wall, make the return force greater, or the chamber softer",
    )
    BOUNCES = (
        "bounces",
        "the bar strikes again and again and comes to no port",
        "make the restitution or the return force greater, or put the port nearer to the wall",
    )
    NO_ROOM = (
        "no room",
        "the piston goes farther back than there is room",
        "put the rear port nearer to the wall, shorten its delay, or make the power force greater",
    )
    NO_BLOW = (
        "cycles without a blow",
        "the valve turns the piston round before it strikes",
        "put the front port nearer to the wall, or give it a longer delay",
    )
    DOUBLE_BLOW = (
        "double blow",
        "the return comes late: the piston has fallen back to the wall and strikes again",
        "shorten the delay of the return, or make its force greater",
    )
    OVERTAKEN = (
        "order overtaken",
        "the rebound reaches the rear port before the return is due, and its demand replaces the order",
        "shorten the delay of the return, or put the rear port farther from the wall",
    )
    FLIP = (
        "flip",
        "weak and strong blows alternate, farther and farther apart (period doubling)",
        "shorten the delay of the return, or lower the restitution",
    )
    SPIRAL = (
        "spiral",
        "a slow beat of the blows grows: two multipliers are beyond the unit circle, as of ringing that the blows feed",
        "damp the elastic modes, or take the contact law that turns the strain over with the velocity",
    )
    GROWS = (
        "grows",
        "a disturbance grows from blow to blow, as of ringing that the blows feed",
        "damp the elastic modes, or take the contact law that turns the strain over with the velocity",
    )
    HUNTS = (
        "pressure swings",
        "a strong blow leaves the next one a lower pressure: blows and pressure go up and down, farther and farther",
        "take a greater accumulator, more flow, or a softer gas behind the piston",
    )
    NO_PRESSURE = (
        "no pressure",
        "the pressure of the supply falls to 0: the piston draws more than pump and accumulator give",
        "take a greater accumulator, more flow, or a smaller stroke",
    )
    UNEVEN = (
        "uneven blows",
        "the blows differ from each other, and repeat after a few of them",
        "damp the elastic modes, or lower the restitution",
    )
    IRREGULAR = (
        "irregular",
        "the blows do not repeat",
        "shorten the delays, or lower the restitution",
    )


class Reasoned(TypedDict, total=False):
    """An obstacle, and the number that decides: as it is, and as it would have to be."""

    obstacle: Obstacle
    found: float | None
    needed: float | None


def why_unstable(multiplier: complex) -> Obstacle:
    """How a cycle with a multiplier of modulus 1 or more is left."""
    if multiplier.imag != 0.0:
        return Obstacle.SPIRAL
    return Obstacle.FLIP if multiplier.real < 0.0 else Obstacle.GROWS


def why_more_blows(cycle: ElasticCycle) -> Obstacle:
    """Why a cycle of an elastic machine has several blows: the valve changes once for each of them, or less often."""
    first = cycle.switches[0].to
    turns = sum(switch.to == first for switch in cycle.switches)
    return Obstacle.UNEVEN if turns >= cycle.blows else Obstacle.DOUBLE_BLOW


def why_none(piston: Piston, legs: list[Leg]) -> Reasoned:
    """What the last flights of a machine without a cycle tell of it."""
    last = legs[-1]
    if last.ending == "no pressure":
        return {"obstacle": Obstacle.NO_PRESSURE}
    if last.ending == "on the wall" and piston.valve.supply is not None:
        return {"obstacle": Obstacle.ON_THE_WALL}
    if last.ending == "on the wall":
        state = last.switches[-1].to if last.switches else _state_before(piston, legs)
        return {"obstacle": Obstacle.ON_THE_WALL, "found": piston.valve.force(state), "needed": 0.0}
    if last.ending == "no blow" or (last.ending == "nothing follows" and last.uncoverings):
        nearest = min(min([s.behind, *s.flight.turning_places(s.duration)]) for s in last.segments[1:])
        return {"obstacle": Obstacle.NO_BLOW, "found": nearest, "needed": 0.0}
    if last.ending == "nothing follows":
        reached, ports = last.farthest, piston.valve.ports
        beyond = [p.behind for p in ports if p.behind is not None and p.side == "back" and p.behind > reached]
        return {"obstacle": Obstacle.NO_PORT, "found": reached, "needed": min(beyond, default=None)}
    again = [leg for leg in legs[-_LATELY:] if not leg.switches]
    return {"obstacle": Obstacle.DOUBLE_BLOW if again else Obstacle.IRREGULAR}


def _state_before(piston: Piston, legs: list[Leg]) -> str:
    """The state in which the last flight began; the first one begins in the state that pulls most."""
    if len(legs) == 1:
        return min(piston.valve.pairs, key=lambda pair: pair[1])[0]
    rebound = legs[-2].rebound
    assert rebound is not None
    return rebound.state


def why_several(piston: Piston, cycle: RigidCycle) -> Reasoned:
    """Why a cycle has several blows: an order was replaced, or came too late after the strongest blow."""
    if any(leg.dropped for leg in cycle.legs):
        return {"obstacle": Obstacle.OVERTAKEN}
    if piston.valve.supply is not None:
        again = any(not leg.switches for leg in cycle.legs)
        return {"obstacle": Obstacle.DOUBLE_BLOW if again else Obstacle.HUNTS}
    strongest = int(np.argmax(cycle.blow_speeds))
    legs = cycle.legs[strongest + 1 :] + cycle.legs[: strongest + 1]
    rebound, passed = cycle.legs[strongest].rebound, 0.0
    assert rebound is not None
    for leg in legs:
        if leg.switches:
            first = leg.switches[0]
            return {
                "obstacle": Obstacle.DOUBLE_BLOW,
                "found": passed + first.time,
                "needed": latest_return(piston, rebound, first.to),
            }
        passed += leg.duration
    return {"obstacle": Obstacle.IRREGULAR}


def latest_return(piston: Piston, rebound: Rebound, to: str) -> float | None:
    """The latest time after a blow at which a state keeps the piston from falling back to the wall; None for none."""
    from scipy.optimize import brentq  # slow to import

    falling = piston.flight(rebound.state, 0.0, rebound.speed)
    back = falling.first_crossing([(0.0, -1)], math.inf)
    if back is None:
        return math.inf if rebound.speed > 0.0 else 0.0

    def nearest(due: float) -> float:
        x, v = falling.at(due)
        pulled = piston.flight(to, x, v)
        turn = pulled.turning_time
        return pulled.at(turn)[0] if math.isfinite(turn) else math.copysign(x, v)

    early, late = falling.turning_time, back.time
    return float(brentq(nearest, early, late)) if nearest(early) > 0.0 >= nearest(late) else None
