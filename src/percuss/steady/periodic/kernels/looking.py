"""Whether a number is a multiplier of a motion: det K(ξ) for a real ξ."""

from percuss.compiled import entry
from percuss.steady.periodic.kernels.forced import prepared
from percuss.steady.periodic.kernels.linearised import bordered
from percuss.steady.periodic.kernels.passage import passed
from percuss.steady.periodic.kernels.solving import determinant

__all__ = ["singularity"]


@entry
def singularity(system, room, period, times, kind, rebound, xi):
    """det K(ξ) of the motion at times, each row taken by its length; K(ξ) itself is left in `matrix`."""
    prepared(system, room)
    passed(room, times, period, kind, rebound)
    bordered(room, xi)
    size = room.impacts.shape[1] + 1
    for i in range(size):
        for j in range(size):
            room.solving[i, j] = room.matrix[i, j]
    return determinant(room.solving, size)
