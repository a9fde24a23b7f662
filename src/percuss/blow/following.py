"""A blow carried on: as far as asked, or until no further contact is possible."""

from __future__ import annotations

from percuss.blow.kernels.going import go_on
from percuss.blow.kernels.layout import FULL, REACHED
from percuss.blow.tables import Tables, enlarged
from percuss.halting import look

__all__ = ["carried_to"]

_AT_ONCE = 1 << 14  # steps between two looks whether anybody still waits


def carried_to(held: Tables, target: int, most_pieces: int) -> tuple[Tables, bool]:
    """The blow with every node at least at the tick `target`; whether it got there.

    Raises
    ------
    Interrupted
        When the computation was told to stop.
    """
    while True:
        code = go_on(held.problem, held.waves, held.state, target, _AT_ONCE)
        if code == REACHED:
            return held, True
        if held.waves.pieces.sum() > most_pieces:
            return held, False
        if code == FULL:
            held = enlarged(held)
        look()
