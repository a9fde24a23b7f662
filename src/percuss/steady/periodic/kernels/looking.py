"""What is asked of a motion at a point of a branch: its speeds, its equations, and det K(±1)."""

from percuss.compiled import entry
from percuss.steady.periodic.kernels.forced import prepared
from percuss.steady.periodic.kernels.layout import CLOSURE, GIVEN, OFF, SPEED
from percuss.steady.periodic.kernels.linearised import bordered
from percuss.steady.periodic.kernels.passage import passed
from percuss.steady.periodic.kernels.solving import determinant

__all__ = ["look_at", "matrix_of"]


@entry
def matrix_of(system, room, period, times, kind, rebound, xi):
    """The motion at times, with K(ξ) in `matrix`."""
    prepared(system, room)
    passed(room, times, period, kind, rebound)
    bordered(room, xi)


@entry
def look_at(system, room, period, x, found):
    """At x = (t_1 … t_p, r) the speeds, the p + 1 equations, det K(1) and det K(−1) into `found`.

    The determinants with each row taken by its length.
    """
    p = room.impacts.shape[1]
    prepared(system, room)
    passed(room, x, period, GIVEN, x[p])
    for i in range(p):
        found[i], found[p + i] = room.impacts[SPEED, i], room.impacts[OFF, i]
    found[2 * p] = room.whole[CLOSURE]
    for place in range(2):
        bordered(room, 1.0 if place == 0 else -1.0)
        for i in range(p + 1):
            for j in range(p + 1):
                room.solving[i, j] = room.matrix[i, j]
        found[2 * p + 1 + place] = determinant(room.solving, p + 1)
