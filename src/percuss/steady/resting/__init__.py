"""Cycles with rest on the wall: from each phase at which the load lets go, over chatter, to the next rest."""

from percuss.steady.resting.rest_cycles import FoundRestCycles, RestCycle, rest_cycles

__all__ = ["FoundRestCycles", "RestCycle", "rest_cycles"]
