"""The motion through impacts at given times: every mode comes back after a cycle, so that p equations are left."""

import math

from percuss.compiled import inner
from percuss.steady.periodic.kernels.forced import forced
from percuss.steady.periodic.kernels.layout import (
    ALPHA,
    BEST,
    BETA,
    CLOSURE,
    DRAG,
    F_RATE,
    FADE,
    FLIGHT,
    FREE,
    GAMMA,
    GAP,
    GIVEN,
    OFF,
    PUSH,
    REBOUND,
    RESONANCE,
    RIGID,
    SPEED,
    STAY,
    TIME,
    U_FORCED,
    V_FORCED,
    A,
    B,
    C,
    E,
    F,
    U,
    V,
)
from percuss.steady.periodic.kernels.oscillator import phi1, phi2, propagated

__all__ = ["SINGULAR", "cycle_of", "passed", "returning"]

SINGULAR = 256.0 * 2.0**-52  # det(ξ − M_n) below this is rounding


@inner
def returning(a, b, c, e, xi, u, v):
    """(ξ − M)⁻¹(u, v) and the determinant; in resonance the shortest that fits best."""
    a, e = xi - a, xi - e
    divisor = a * e - b * c
    if abs(divisor) > SINGULAR:
        return (e * u + b * v) / divisor, (c * u + a * v) / divisor, divisor
    size = a * a + e * e + b * b + c * c
    size = size if size > 0.0 else 1.0
    return (a * u - c * v) / size, (e * v - b * u) / size, divisor


@inner
def cycle_of(carried, n, alpha, beta):
    """M_n, the map of a mode over a whole cycle with the times held."""
    a, b, c, e = 1.0, 0.0, 0.0, 1.0
    for i in range(carried.shape[2]):
        pa, pb, pc, pe = carried[A, n, i], carried[B, n, i], carried[C, n, i], carried[E, n, i]
        a, c = alpha * (pa * a + pb * c), beta * (pc * a + pe * c)
        b, e = alpha * (pa * b + pb * e), beta * (pc * b + pe * e)
    return a, b, c, e


@inner
def passed(room, times, period, kind, rebound):
    """The motion through impacts at times, with the mean velocity after the first one as `kind` says."""
    impacts = room.impacts
    p, d = impacts.shape[1], room.numbers[DRAG]
    for i in range(p):
        impacts[TIME, i] = times[i]
        flight = (times[i + 1] if i + 1 < p else times[0] + period) - times[i]
        impacts[FLIGHT, i] = flight
        impacts[FADE, i], impacts[STAY, i] = flight * phi1(d * flight), math.exp(-d * flight)
        impacts[OFF, i] = 0.0
    forced(room)
    room.whole[RESONANCE] = math.inf
    for i in range(p):
        impacts[SPEED, i] = 0.0
    for n in range(room.modal.shape[1]):
        elastic(room, n)
    for i in range(p):
        to, flight = (i + 1) % p, impacts[FLIGHT, i]
        off = impacts[OFF, i] + room.numbers[PUSH] * flight * flight * phi2(d * flight)
        impacts[OFF, i] = off + (impacts[U_FORCED, to] - impacts[U_FORCED, i])
    if room.numbers[FREE] != 0.0:
        rigid(room, period, kind, rebound)
    else:
        held(room, kind, rebound)


@inner
def elastic(room, n):
    """A mode: Φ_n over the flights, its states before the impacts, and what it adds to F_i and to the speeds."""
    modal, impacts, carried = room.modal, room.impacts, room.carried
    alpha, beta, p = room.numbers[ALPHA], room.numbers[BETA], room.impacts.shape[1]
    u, v = 0.0, 0.0
    for i in range(p):
        a, b, c, e = propagated(modal, n, impacts[FLIGHT, i])
        carried[A, n, i], carried[B, n, i], carried[C, n, i], carried[E, n, i] = a, b, c, e
        to = (i + 1) % p
        u, v = (
            alpha * (a * u + b * v) + (alpha - 1.0) * carried[F, n, to],
            beta * (c * u + e * v) + (beta - 1.0) * carried[F_RATE, n, to],
        )
    a, b, c, e = cycle_of(carried, n, alpha, beta)
    u, v, divisor = returning(a, b, c, e, 1.0, u, v)
    room.whole[RESONANCE] = min(room.whole[RESONANCE], abs(divisor))
    gamma = modal[GAMMA, n]
    for i in range(p):
        to = (i + 1) % p
        a, b, c, e = carried[A, n, i], carried[B, n, i], carried[C, n, i], carried[E, n, i]
        f, rate = carried[F, n, to], carried[F_RATE, n, to]
        u, v = a * u + b * v + f, c * u + e * v + rate
        carried[U, n, to], carried[V, n, to] = u, v
        impacts[SPEED, to] += gamma * v
        impacts[OFF, i] += gamma * u
        impacts[OFF, to] -= alpha * gamma * u
        u, v = alpha * u - f, beta * v - rate


@inner
def rigid(room, period, kind, first):
    """The velocity of the bar as a whole at the impacts, what it adds to F_i, and by how much it does not come back."""
    impacts, p = room.impacts, room.impacts.shape[1]
    if kind == BEST:
        first = best_rebound(room)
    elif kind != GIVEN:
        kept = room.numbers[BETA] ** p * math.exp(-room.numbers[DRAG] * period)
        first = carried_through(room, 0.0) / (1.0 - kept)
    last = carried_through(room, first)
    room.whole[CLOSURE] = last - first
    for i in range(p):
        impacts[OFF, i] += (impacts[REBOUND, i] - impacts[V_FORCED, i]) * impacts[FADE, i]
        impacts[SPEED, i] += impacts[RIGID, i]


@inner
def held(room, kind, given):
    """What is left of a body that is held: no motion as a whole, and its place at the impacts, not how it changes."""
    impacts, given = room.impacts, given if kind == GIVEN else 0.0
    room.whole[CLOSURE] = -given
    for i in range(impacts.shape[1]):
        impacts[FADE, i], impacts[STAY, i], impacts[RIGID, i], impacts[REBOUND, i] = 0.0, 0.0, 0.0, given
        impacts[OFF, i] = -room.numbers[GAP]
        for n in range(room.modal.shape[1]):
            impacts[OFF, i] += room.modal[GAMMA, n] * room.carried[U, n, i]


@inner
def carried_through(room, first):
    """The velocities before and after all impacts; returns that after the first one a cycle later."""
    impacts, p, mean = room.impacts, room.impacts.shape[1], room.numbers[PUSH]
    impacts[REBOUND, 0] = now = first
    for i in range(p):
        to = (i + 1) % p
        swing = (now - impacts[V_FORCED, i]) * impacts[STAY, i]
        impacts[RIGID, to] = swing + impacts[V_FORCED, to] + mean * impacts[FADE, i]
        now = room.numbers[BETA] * impacts[RIGID, to]
        if to:
            impacts[REBOUND, to] = now
    return now


@inner
def best_rebound(room):
    """The velocity after the first impact with the least Σ F_i², which is linear in it."""
    impacts, p = room.impacts, room.impacts.shape[1]
    carried_through(room, 0.0)
    share, above, below = 1.0, 0.0, 0.0
    for i in range(p):
        off = impacts[OFF, i] + (impacts[REBOUND, i] - impacts[V_FORCED, i]) * impacts[FADE, i]
        slope = share * impacts[FADE, i]
        above, below = above + slope * off, below + slope * slope
        share *= room.numbers[BETA] * impacts[STAY, i]
    return -above / below
