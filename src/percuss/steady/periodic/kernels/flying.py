"""The flights of a motion sample by sample: their greatest maximum, and a proof that the bar stays off the wall.

On a stretch of a flight under one step of the load, or under harmonics on all of it, the gap function is

    y(t) = level + Σ γ_n x_n(t) + Σ Re H_k exp(ikθ) + w t φ1(dt) + p t² φ2(dt),

x_n free oscillations: about the static displacement for steps, without the waves, and else about the forced motion.
"""

import math

from percuss.compiled import entry, inner, summed
from percuss.steady.periodic.kernels.forced_passage import TURN, phi1, phi2, piece_at, propagated
from percuss.steady.periodic.kernels.orbit_records import (
    ALPHA,
    BETA,
    DAMPING,
    DRAG,
    F_RATE,
    FLIGHT,
    FREE,
    GAMMA,
    LENGTH,
    OMEGA,
    P_IM,
    P_RE,
    PUSH,
    REBOUND,
    SPEED,
    SQUARE,
    TIME,
    U_IM,
    U_RE,
    V_FORCED,
    V_IM,
    V_RE,
    VALUE,
    F,
    K,
    U,
    V,
)

__all__ = ["flown"]

PER_WAVE, FEWEST, LEAST = 8.0, 96.0, 8  # samples in a period of the fastest mode, in a flight, in a stretch
ROUNDS = 60
ROUNDING = 1e-12  # of the greatest |y| and of what it is the sum of

# rows of `free`: x_n and its rate at the begin of the stretch, at the sample, and Φ_n from sample to sample
X, X_RATE, NOW, NOW_RATE, PA, PB, PC, PE = range(8)
# rows of `spun`: H_k, exp(ikθ) at the sample, and from sample to sample
H_RE, H_IM, COSINE, SINE, TURN_COSINE, TURN_SINE = range(6)
# of the stretch: where it begins, the level, w, p, how long it is, a bound of |y''|, the size of the terms
BEGIN, LEVEL, DRIFT, FORCED, LONG, BEND, SIZE = range(7)
# found: the greatest maximum, when after the impact, in which flight; whether nothing is nearer than the proof sees
HEIGHT, WHEN, WHICH, PROVEN = range(4)


@entry
def flown(room, found):
    """The greatest maximum inside the flights of the motion in a room, and whether the bar is proved to stay off."""
    ends_of_waves(room)
    found[HEIGHT], found[WHEN], found[WHICH], found[PROVEN] = -math.inf, 0.0, 0.0, 1.0
    for i in range(room.impacts.shape[1]):
        if room.impacts[SPEED, i] <= 0.0 or room.numbers[BETA] >= 0.0:
            found[PROVEN] = 0.0
        flight(room, i, found)


@inner
def ends_of_waves(room):
    """H_k: what the load moves the striking end by, the bar as a whole and its modes together."""
    spun, waves, modal = room.spun, room.waves, room.modal
    for j in range(waves.shape[1]):
        re, im = waves[U_RE, j], waves[U_IM, j]
        for n in range(modal.shape[1]):
            re += modal[GAMMA, n] * room.gains[0, n, j]
            im += modal[GAMMA, n] * room.gains[1, n, j]
        spun[H_RE, j], spun[H_IM, j] = re, im


@inner
def flight(room, i, found):
    """One flight: its stretches, one after the other."""
    impacts, modal, free, carried, at = room.impacts, room.modal, room.free, room.carried, room.stretch
    alpha, beta, by_steps = room.numbers[ALPHA], room.numbers[BETA], room.steps.shape[1] > 0
    whole, time = impacts[FLIGHT, i], 0.0
    fastest = 1.0 if by_steps else room.waves[K, room.waves.shape[1] - 1]
    for n in range(modal.shape[1]):
        fastest = max(fastest, modal[OMEGA, n])
        free[X, n], free[X_RATE, n] = alpha * carried[U, n, i], beta * carried[V, n, i]
        if not by_steps:
            free[X, n] -= carried[F, n, i]
            free[X_RATE, n] -= carried[F_RATE, n, i]
    samples = max(FEWEST, PER_WAVE * fastest * whole / TURN)
    if not by_steps:
        at[BEGIN], at[LONG] = impacts[TIME, i], whole
        at[FORCED], at[DRIFT] = room.numbers[PUSH], impacts[REBOUND, i] - impacts[V_FORCED, i]
        at[LEVEL] = 0.0
        bounded(room, impacts[REBOUND, i])
        at[LEVEL] = -placed(room, 0.0)[0]
        stretch(room, i, 0.0, whole, max(LEAST, int(samples)), found)
        return
    rate, level, last = impacts[REBOUND, i], 0.0, 0.0
    for _ in range(room.steps.shape[1] * (2 + int(whole / TURN))):
        piece, since = piece_at(room.steps, impacts[TIME, i] + time)
        long = min(room.steps[LENGTH, piece] - since, whole - time)
        if long <= 1e-12:  # at the very end of a step
            piece, long = (piece + 1) % room.steps.shape[1], 0.0
            long = min(room.steps[LENGTH, piece], whole - time)
        force = room.steps[VALUE, piece]
        for n in range(modal.shape[1]):
            free[X, n] += (last - force) / modal[SQUARE, n]
        last = force
        at[BEGIN], at[LONG] = impacts[TIME, i] + time, long
        at[FORCED], at[DRIFT], at[LEVEL] = room.numbers[FREE] * force, rate, 0.0
        bounded(room, rate)
        at[LEVEL] = level - placed(room, 0.0)[0]
        level, rate = stretch(room, i, time, whole, max(LEAST, int(samples * long / whole)), found)
        time += long
        if time >= whole * (1.0 - 1e-14):
            return
    found[PROVEN] = 0.0


@inner
def bounded(room, rebound):
    """A bound of |y''| on the stretch, and how large the terms of y are."""
    at, modal, waves, spun, free = room.stretch, room.modal, room.waves, room.spun, room.free
    d, push, long = room.numbers[DRAG], abs(at[FORCED]), at[LONG]
    swing, forces, rates, bend, size = 0.0, 0.0, 0.0, 0.0, 0.0
    for j in range(waves.shape[1]):
        forces += math.hypot(waves[P_RE, j], waves[P_IM, j])
        rates += math.hypot(waves[V_RE, j], waves[V_IM, j])
        re, im = spun[H_RE, j] - waves[U_RE, j], spun[H_IM, j] - waves[U_IM, j]
        bend += waves[K, j] * waves[K, j] * math.hypot(re, im)
        size += math.hypot(spun[H_RE, j], spun[H_IM, j])
    for n in range(modal.shape[1]):
        omega = modal[OMEGA, n]
        swing = abs(modal[GAMMA, n]) * math.hypot(free[X, n], free[X_RATE, n] / omega)
        bend += swing * (modal[SQUARE, n] + modal[DAMPING, n] * omega)
        size += swing
    fastest = abs(rebound) + rates + rates + push * long
    at[BEND] = bend + room.numbers[FREE] * forces + push + d * fastest
    at[SIZE] = size + fastest * long


@inner
def placed(room, t):
    """y, y' and y'' at a time of the stretch."""
    at, free, modal, waves, spun = room.stretch, room.free, room.modal, room.waves, room.spun
    d = room.numbers[DRAG]
    fade, stay = t * phi1(d * t), math.exp(-d * t)
    y = at[LEVEL] + at[DRIFT] * fade + at[FORCED] * t * t * phi2(d * t)
    rate = at[DRIFT] * stay + at[FORCED] * fade
    bend = (at[FORCED] - d * at[DRIFT]) * stay
    for j in range(waves.shape[1]):
        k = waves[K, j]
        angle = k * (at[BEGIN] + t)
        cosine, sine = math.cos(angle), math.sin(angle)
        here, ahead = spun[H_RE, j] * cosine - spun[H_IM, j] * sine, spun[H_RE, j] * sine + spun[H_IM, j] * cosine
        y, rate, bend = y + here, rate - k * ahead, bend - k * k * here
    for n in range(modal.shape[1]):
        a, b, c, e = propagated(modal, n, t)
        u, v, gamma = free[X, n], free[X_RATE, n], modal[GAMMA, n]
        u, v = a * u + b * v, c * u + e * v
        y, rate, bend = y + gamma * u, rate + gamma * v, bend - gamma * (modal[SQUARE, n] * u + modal[DAMPING, n] * v)
    return y, rate, bend


@inner
def stretch(room, i, time, whole, number, found):
    """Sample a stretch that begins at a time of its flight; y and the velocity of the bar as a whole at its end."""
    at, modal, free, waves, spun = room.stretch, room.modal, room.free, room.waves, room.spun
    d, step = room.numbers[DRAG], at[LONG] / number
    for n in range(modal.shape[1]):
        free[PA, n], free[PB, n], free[PC, n], free[PE, n] = propagated(modal, n, step)
        free[NOW, n], free[NOW_RATE, n] = free[X, n], free[X_RATE, n]
    for j in range(waves.shape[1]):
        angle, turn = waves[K, j] * at[BEGIN], waves[K, j] * step
        spun[COSINE, j], spun[SINE, j] = math.cos(angle), math.sin(angle)
        spun[TURN_COSINE, j], spun[TURN_SINE, j] = math.cos(turn), math.sin(turn)
    before, speed, _ = placed(room, 0.0)
    if time == 0.0:
        before, speed = 0.0, room.numbers[BETA] * room.impacts[SPEED, i]
    reach, small = 0.125 * at[BEND] * step * step, ROUNDING * at[SIZE]
    safe_start = -2.0 * room.numbers[BETA] * room.impacts[SPEED, i] / at[BEND] if time == 0.0 else 0.0
    coming = room.impacts[SPEED, (i + 1) % room.impacts.shape[1]]
    safe_stop = whole - 2.0 * coming / at[BEND] if time + at[LONG] >= whole * (1.0 - 1e-14) else whole
    for m in range(1, number + 1):
        t = m * step
        y, rate = sampled(room, t)
        if speed > 0.0 and rate <= 0.0 and max(y, before) + 0.25 * (speed - rate) * step > found[HEIGHT]:
            top(room, i, time, t - step, t, found)
        if time + t > safe_start and time + t - step < safe_stop and max(y, before) + reach + small >= 0.0:
            found[PROVEN] = 0.0
        before, speed = y, rate
    y, rate, _ = placed(room, at[LONG])
    for n in range(modal.shape[1]):
        a, b, c, e = propagated(modal, n, at[LONG])
        u, v = free[X, n], free[X_RATE, n]
        free[X, n], free[X_RATE, n] = a * u + b * v, c * u + e * v
    return y, at[DRIFT] * math.exp(-d * at[LONG]) + at[FORCED] * at[LONG] * phi1(d * at[LONG])


@summed
def sampled(room, t):
    """y and y' at the next sample."""
    at, modal, free, waves, spun = room.stretch, room.modal, room.free, room.waves, room.spun
    d, y, rate = room.numbers[DRAG], 0.0, 0.0
    for n in range(modal.shape[1]):
        u, v = free[NOW, n], free[NOW_RATE, n]
        now, ahead = free[PA, n] * u + free[PB, n] * v, free[PC, n] * u + free[PE, n] * v
        free[NOW, n], free[NOW_RATE, n] = now, ahead
        y, rate = y + modal[GAMMA, n] * now, rate + modal[GAMMA, n] * ahead
    for j in range(waves.shape[1]):
        cosine = spun[COSINE, j] * spun[TURN_COSINE, j] - spun[SINE, j] * spun[TURN_SINE, j]
        sine = spun[COSINE, j] * spun[TURN_SINE, j] + spun[SINE, j] * spun[TURN_COSINE, j]
        spun[COSINE, j], spun[SINE, j] = cosine, sine
        y += spun[H_RE, j] * cosine - spun[H_IM, j] * sine
        rate -= waves[K, j] * (spun[H_RE, j] * sine + spun[H_IM, j] * cosine)
    fade, stay = t * phi1(d * t), math.exp(-d * t)
    y += at[LEVEL] + at[DRIFT] * fade + at[FORCED] * t * t * phi2(d * t)
    return y, rate + at[DRIFT] * stay + at[FORCED] * fade


@inner
def top(room, i, time, low, high, found):
    """The maximum between two times of a stretch, noted where it is the greatest so far."""
    t = 0.5 * (low + high)
    for _ in range(ROUNDS):
        y, rate, bend = placed(room, t)
        if rate > 0.0:
            low = t
        else:
            high = t
        ahead = t - rate / bend if bend != 0.0 else low
        if not low < ahead < high:
            ahead = 0.5 * (low + high)
        if abs(ahead - t) <= 4.0 * 2.0**-52 * (abs(t) + 1e-3):
            break
        t = ahead
    y, rate, bend = placed(room, t)
    if y > found[HEIGHT]:
        found[HEIGHT], found[WHEN], found[WHICH] = y, time + t, float(i)
