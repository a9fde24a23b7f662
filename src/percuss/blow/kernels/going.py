"""The waves of a blow, carried on until a tick."""

from __future__ import annotations

from percuss.blow.kernels.layout import FULL, PAUSED, REACHED
from percuss.blow.kernels.nodes import FILLED, MOVES, carried_on, last_node
from percuss.compiled import entry


@entry
def go_on(problem, waves, state, target, budget):
    """Carry every node on to the target at least; REACHED, FULL when a row is full, PAUSED after `budget` steps.

    Each node goes as far as its arrivals are known. Where every node waits for a piece to be known as a whole, the one
    that is last goes on with a part of it.
    """
    last, used = last_node(problem), 0
    node, whole, moved, reached, slowest = 0, True, False, True, 0
    while used < budget:
        if state.time[node] < target:
            what = carried_on(problem, waves, state, node, whole)
            if what == FILLED:
                state.now[0].steps += used
                return FULL
            if what == MOVES or not whole:
                used += 1
                moved = True
                if not whole:  # all may go on as before
                    node, whole, moved, reached, slowest = 0, True, False, True, 0
                continue
        reached = reached and state.time[node] >= target
        if state.time[node] < state.time[slowest]:
            slowest = node
        node += 1
        if node > last:
            if reached:
                state.now[0].steps += used
                return REACHED
            node, whole = (0, True) if moved else (slowest, False)
            if whole:
                moved, reached, slowest = False, True, 0
    state.now[0].steps += used
    return PAUSED
