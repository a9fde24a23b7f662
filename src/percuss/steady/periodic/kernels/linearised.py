"""K(ξ) for a real ξ, with the change of the rigid velocity after the first impact as an unknown more."""

from percuss.compiled import inner
from percuss.steady.periodic.kernels.layout import (
    ALPHA,
    BETA,
    DRAG,
    FADE,
    FORCE,
    FREE,
    GAMMA,
    REBOUND,
    SPEED,
    SQUARE,
    STAY,
    A,
    B,
    C,
    E,
    U,
    V,
)
from percuss.steady.periodic.kernels.passage import cycle_of, returning

__all__ = ["bordered", "turning"]


@inner
def bordered(room, xi):
    """K(ξ) into the first p + 1 rows and columns of `matrix`, after `passed`."""
    matrix, impacts, rate = room.matrix, room.impacts, room.rows[0]
    p, beta, impulse = impacts.shape[1], room.numbers[BETA], 1.0 - room.numbers[BETA]
    for i in range(p + 1):
        for j in range(p + 1):
            matrix[i, j] = 0.0
        rate[i] = 0.0
    for n in range(room.modal.shape[1]):
        elastic_rows(room, n, xi)
    if room.numbers[FREE] == 0.0:
        for i in range(p):
            matrix[i, i] += beta * impacts[SPEED, i]
        matrix[p, p] = -1.0
        return
    rate[p] = 1.0
    for i in range(p):
        for j in range(p + 1):
            matrix[i, j] += impacts[FADE, i] * rate[j]
            rate[j] *= beta * impacts[STAY, i]
        to, turned = (i + 1, 1.0) if i + 1 < p else (0, xi)
        rate[to] -= turned * impulse * impacts[FORCE, to]
        matrix[i, i] -= beta * impacts[SPEED, i]
        matrix[i, to] += turned * impacts[SPEED, to]
    for j in range(p + 1):
        matrix[p, j] = rate[j]
    matrix[p, p] -= xi


@inner
def elastic_rows(room, n, xi):
    """What a mode adds: how each flight (row) moves the striking end per shift of an impact (column)."""
    matrix, carried, impacts = room.matrix, room.carried, room.impacts
    alpha, beta, p = room.numbers[ALPHA], room.numbers[BETA], impacts.shape[1]
    gamma, square = room.modal[GAMMA, n], room.modal[SQUARE, n]
    is_free = room.numbers[FREE] != 0.0
    ma, mb, mc, me = cycle_of(carried, n, alpha, beta)
    for j in range(p):
        kick = (alpha - beta) * carried[V, n, j]
        kick_rate = (alpha - beta) * square * carried[U, n, j] - (1.0 - beta) * impacts[FORCE, j]
        if j == 0:  # met at the end of the cycle, ξ times
            u, v = xi * kick, xi * kick_rate
        else:
            u, v = kick, kick_rate
            for i in range(j, p):
                a, b, c, e = carried[A, n, i], carried[B, n, i], carried[C, n, i], carried[E, n, i]
                u, v = alpha * (a * u + b * v), beta * (c * u + e * v)
        u, v, _ = returning(ma, mb, mc, me, xi, u, v)
        for i in range(p):
            a, b, c, e = carried[A, n, i], carried[B, n, i], carried[C, n, i], carried[E, n, i]
            start = u
            u, v = a * u + b * v, c * u + e * v
            matrix[i, j] += gamma * (u - start if is_free else start)
            u, v = alpha * u, beta * v
            if i + 1 == j:
                u, v = u + kick, v + kick_rate


@inner
def turning(room):
    """By how much the mean velocity just after the first impact grows if the impact is later, its state the same."""
    numbers, impacts = room.numbers, room.impacts
    return numbers[FREE] * (impacts[FORCE, 0] - numbers[DRAG] * impacts[REBOUND, 0])
