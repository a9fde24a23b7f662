"""What lies beyond the ends of a branch of cycles with rest, in a sentence."""

from __future__ import annotations

from collections.abc import Sequence

from percuss.steady import RestCycle
from percuss.steady.resting.chain import Chain

__all__ = ["after_change", "after_grazing", "after_onset", "another_rest", "without_release"]


def _who(cycle: RestCycle) -> str:
    return "bar" if cycle.system.body.is_free else "structure"


def without_release(cycle: RestCycle) -> str:
    """Where the load no longer lets go."""
    return f"the load never turns from push to pull: the {_who(cycle)} rests on the wall for good"


def after_grazing(cycle: RestCycle, touch: bool) -> str:
    """Beyond a touch, or the death of an impact."""
    told = f"the {_who(cycle)} touches the wall in a flight, and strikes it there beyond" if touch else "an impact dies"
    elastic = cycle.modes > 0 and cycle.system.body.is_free
    then = "what follows jumps" if elastic else "what follows changes as the root of the distance from here"
    return f"{told}: {then}"


def after_onset(cycle: RestCycle) -> str:
    """Beyond an onset."""
    what = "the end of the chatter" if cycle.chatters else "the impact before the rest"
    if cycle.chatters and cycle.modes and cycle.system.body.is_free:
        return f"{what} meets the next release; beyond, the bar laid down is let go at once"
    told = f"{what} meets the next release, and the {_who(cycle)} is not laid down before it"
    if cycle.chatters and cycle.system.contact.keeps_strain:
        told += f"; beyond, motions z=p/{cycle.periods} have p growing without bound as this point is approached"
    return told


def another_rest(cycle: RestCycle) -> str:
    """Beyond the place at which a rest more begins."""
    return f"the {_who(cycle)} comes to rest once more: just before another release, which an impact meets here"


def after_change(cycle: RestCycle, chains: Sequence[Chain]) -> str:
    """Beyond any other change, after which these chains follow the release."""
    if any(chain.chatters for chain in chains) is cycle.chatters:
        return f"the {_who(cycle)} comes back to this release after other rests"
    if cycle.chatters:
        return f"without rebound the {_who(cycle)} rests at its first impact under a push: rest/{cycle.periods}"
    return f"with rebound, however little, the {_who(cycle)} chatters to its rest: chatter/{cycle.periods}"
