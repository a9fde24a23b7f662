"""The waves of a blow, carried on until a tick."""

from __future__ import annotations

from percuss.blow.kernels.layout import FULL, PAUSED, REACHED
from percuss.blow.kernels.nodes import FILLED, MOVES, STAYS, carried_on, last_node
from percuss.compiled import entry


@entry
def go_on(problem, waves, state, target, budget):
    """Carry every node on to the target at least; REACHED, FULL when a row is full, PAUSED after `budget` steps.

    Each node goes as far as its arrivals are known. Where every node waits for a piece to be known as a whole, the one
    that is last goes on with a part of it.
    """
    last, used = last_node(problem), 0
    while used < budget:
        moved, reached, slowest = False, True, 0
        for node in range(last + 1):
            while state.time[node] < target:
                what = carried_on(problem, waves, state, node, True)
                if what == FILLED:
                    return FULL
                if what == STAYS:
                    break
                moved = True
                used += 1
            reached = reached and state.time[node] >= target
            if state.time[node] < state.time[slowest]:
                slowest = node
        if reached:
            state.now[0].steps += used
            return REACHED
        if not moved:
            what = carried_on(problem, waves, state, slowest, False)
            if what == FILLED:
                return FULL
            used += 1
            if what != MOVES:  # the last one can always go on
                break
    state.now[0].steps += used
    return PAUSED
