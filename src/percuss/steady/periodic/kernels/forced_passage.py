"""The motion through impacts at given times, where its numbers stand, and its flights sample by sample."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from percuss.compiled import entry, inner, summed

# ---- Where numbers stand in the arrays

MEAN, PUSH, DRAG, ALPHA, BETA, FREE, GAP = range(7)
"""Of a system, first: p_0, and what of it pushes the body as a whole; d of that; α and β of the contact; whether the
body is free (1) or held (0), so that it has no motion as a whole; and the gap of one that is held."""
HEAD = 7
"""After these follow ω_n, d_n and γ_n, n = 1 … N, then k, Re p_k and Im p_k of K harmonics, or P breaks and values."""

# rows of `modal`: ω_n, d_n, γ_n, d_n/2, |ω_n² − d_n²/4|^½, whether it creeps, ω_n², and p_0/ω_n²
OMEGA, DAMPING, GAMMA, HALF_D, RATE, CREEPS, SQUARE, STATIC = range(8)
MODAL_ROWS = 8

# rows of `waves`: k, p_k, and what multiplies exp(ikt) in v_f and in its antiderivative
K, P_RE, P_IM, V_RE, V_IM, U_RE, U_IM = range(7)
WAVE_ROWS = 7

# rows of `steps`: where a piece begins, the force on it, its length, the force less the mean, v_f and its
# antiderivative at its begin
START, VALUE, LENGTH, PULL, KNOT_V, KNOT_U = range(6)
STEP_ROWS = 6

# rows of `impacts`: t_i, h_i, p(t_i), v_f and its antiderivative there, (1 − E_i)/d, E_i, the velocity of the bar as a
# whole just before and just after, the speed, and F_i
TIME, FLIGHT, FORCE, V_FORCED, U_FORCED, FADE, STAY, RIGID, REBOUND, SPEED, OFF = range(11)
IMPACT_ROWS = 11

# of each mode and impact: Φ_n(h_i), the state just before the impact, and the forced one
A, B, C, E, U, V, F, F_RATE = range(8)
CARRIED_ROWS = 8

# what holds for the motion as a whole
CLOSURE, RESONANCE = range(2)
WHOLE_ROWS = 2

GIVEN, RETURNING, BEST = range(3)
"""The mean velocity after the first impact: given; that which comes back; that which fits the wall best."""


class Room(NamedTuple):
    """The arrays in which one motion is computed; N modes, K harmonics or P steps, p impacts."""

    modal: npt.NDArray[np.float64]
    waves: npt.NDArray[np.float64]
    gains: npt.NDArray[np.float64]
    steps: npt.NDArray[np.float64]
    knots: npt.NDArray[np.float64]
    impacts: npt.NDArray[np.float64]
    carried: npt.NDArray[np.float64]
    turned: npt.NDArray[np.float64]
    numbers: npt.NDArray[np.float64]
    whole: npt.NDArray[np.float64]
    matrix: npt.NDArray[np.float64]
    solving: npt.NDArray[np.float64]
    rows: npt.NDArray[np.float64]
    now: npt.NDArray[np.float64]
    moved: npt.NDArray[np.float64]
    free: npt.NDArray[np.float64]
    spun: npt.NDArray[np.float64]
    stretch: npt.NDArray[np.float64]


def room_for(modes: int, waves: int, steps: int, impacts: int) -> Room:
    """Arrays of the sizes that are needed."""
    size, length = impacts + 2, HEAD + 3 * modes + (3 * waves or 2 * steps)
    return Room(
        modal=np.empty((MODAL_ROWS, modes)),
        waves=np.empty((WAVE_ROWS, waves)),
        gains=np.empty((2, modes, waves)),
        steps=np.empty((STEP_ROWS, steps)),
        knots=np.empty((2, modes, steps)),
        impacts=np.empty((IMPACT_ROWS, impacts)),
        carried=np.empty((CARRIED_ROWS, modes, impacts)),
        turned=np.empty((2, impacts, max(waves, 1))),
        numbers=np.empty(HEAD),
        whole=np.empty(WHOLE_ROWS),
        matrix=np.empty((size, size)),
        solving=np.empty((size, size + 1)),
        rows=np.empty((1, size)),
        now=np.empty(length),
        moved=np.empty(length),
        free=np.empty((8, modes)),
        spun=np.empty((6, waves)),
        stretch=np.empty(10),
    )


# ---- One damped oscillator, and the functions that stay exact as d → 0: `percuss.steady.oscillator` in plain numbers


@inner
def phi1(x):
    """(1 − exp(−x))/x."""
    return 1.0 if x == 0.0 else -math.expm1(-x) / x


@inner
def phi2(x):
    """(exp(−x) − 1 + x)/x²."""
    if abs(x) >= 0.1:
        return (math.expm1(-x) + x) / (x * x)
    series = 1.0 / 11.0
    for j in range(10, 1, -1):
        series = (1.0 - x * series) / j
    return series


@inner
def phi3(x):
    """(½ − phi2(x))/x."""
    if abs(x) >= 0.3:
        return (0.5 - phi2(x)) / x
    series = 0.0
    for j in range(15, 2, -1):
        series = (1.0 - x * series) / j
    return 0.5 * series


@inner
def propagated(modal, n, t):
    """Φ_n(t) = [[a, b], [c, e]]."""
    half_d, rate = modal[HALF_D, n], modal[RATE, n]
    angle = rate * t
    if modal[CREEPS, n] != 0.0:
        slow = math.exp(-modal[SQUARE, n] / (half_d + rate) * t)
        spread = 2.0 * angle
        cosine, b = 0.5 * slow * (1.0 + math.exp(-spread)), slow * t * phi1(spread)
    else:
        half = math.exp(-half_d * t) if half_d != 0.0 else 1.0
        cosine = half * math.cos(angle)
        b = half * (math.sin(angle) / rate if angle > 1e-12 else t)
    return cosine + half_d * b, b, -modal[SQUARE, n] * b, cosine - half_d * b


@inner
def versine(modal, n, t):
    """exp(−dt/2)(1 − cos λt)."""
    half = math.exp(-modal[HALF_D, n] * t)
    if modal[CREEPS, n] == 0.0:
        sine = math.sin(0.5 * modal[RATE, n] * t)
        return half * 2.0 * sine * sine
    slow = math.exp(-modal[SQUARE, n] / (modal[HALF_D, n] + modal[RATE, n]) * t)
    return half - 0.5 * slow * (1.0 + math.exp(-2.0 * modal[RATE, n] * t))


# ---- The forced motion of all modes at the impacts, for a load of harmonics or of steps

TURN = 2.0 * math.pi
SNAP = 8.0 * 2.0**-52  # as in percuss.model.load
WHOLE = 64.0 * 2.0**-52  # as in percuss.steady.forced


@inner
def prepared(system, room):
    """Take a system apart into the rows of `modal`, `waves` or `steps`, once for all times."""
    modal, waves, steps = room.modal, room.waves, room.steps
    modes, number, pieces = modal.shape[1], waves.shape[1], steps.shape[1]
    for i in range(HEAD):
        room.numbers[i] = system[i]
    for n in range(modes):
        omega, damping = system[HEAD + n], system[HEAD + modes + n]
        under = omega * omega - 0.25 * damping * damping
        modal[OMEGA, n], modal[DAMPING, n], modal[GAMMA, n] = omega, damping, system[HEAD + 2 * modes + n]
        modal[HALF_D, n], modal[SQUARE, n] = 0.5 * damping, omega * omega
        modal[RATE, n], modal[CREEPS, n] = math.sqrt(abs(under)), 1.0 if under < 0.0 else 0.0
        modal[STATIC, n] = system[MEAN] / (omega * omega)
    at = HEAD + 3 * modes
    for j in range(number):
        k, re, im = system[at + j], system[at + number + j], system[at + 2 * number + j]
        waves[K, j], waves[P_RE, j], waves[P_IM, j] = k, re, im
        factor = system[FREE] * complex(re, im) / complex(system[DRAG], k)
        waves[V_RE, j], waves[V_IM, j] = factor.real, factor.imag
        waves[U_RE, j], waves[U_IM, j] = factor.imag / k, -factor.real / k
        for n in range(modes):
            gain = complex(re, im) / complex(modal[SQUARE, n] - k * k, k * modal[DAMPING, n])
            room.gains[0, n, j], room.gains[1, n, j] = gain.real, gain.imag
    for j in range(pieces):
        steps[START, j], steps[VALUE, j] = system[at + j], system[at + pieces + j]
    if pieces:
        rigid_knots(room)
        for n in range(modes):
            modal_knots(room, n)


@inner
def rigid_knots(room):
    """v_f and its antiderivative at the begin of each step, as `PiecewiseResponse` has them."""
    steps, d, mean = room.steps, room.numbers[DRAG], room.numbers[MEAN]
    pieces, gone, v = steps.shape[1], 0.0, 0.0
    for j in range(pieces):
        end = steps[START, j + 1] if j + 1 < pieces else steps[START, 0] + TURN
        length, pull = end - steps[START, j], room.numbers[FREE] * (steps[VALUE, j] - mean)
        steps[LENGTH, j], steps[PULL, j] = length, pull
        gone += length
        rest = TURN - gone
        weight = -length * phi2(d * length) * math.exp(-d * rest) - rest * phi1(d * rest)
        v += pull * length * weight
    v /= TURN * phi1(d * TURN)
    u, area = 0.0, 0.0
    for j in range(pieces):
        length, pull = steps[LENGTH, j], steps[PULL, j]
        x = d * length
        steps[KNOT_V, j], steps[KNOT_U, j] = v, u
        area += u * length + v * length * length * phi2(x) + pull * length * length * length * phi3(x)
        u += v * length * phi1(x) + pull * length * length * phi2(x)
        v = v * math.exp(-x) + pull * length * phi1(x)
    for j in range(pieces):
        steps[KNOT_U, j] -= area / TURN


@inner
def modal_knots(room, n):
    """Departure from the static displacement, and velocity, of a mode at the begin of each step."""
    modal, steps, knots = room.modal, room.steps, room.knots
    pieces, square, omega = steps.shape[1], modal[SQUARE, n], modal[OMEGA, n]
    u, v = 0.0, 0.0
    for j in range(pieces):
        a, b, c, e = propagated(modal, n, steps[LENGTH, j])
        jump = (steps[VALUE, j] - steps[VALUE, (j + 1) % pieces]) / square
        u, v = a * u + b * v + jump, c * u + e * v
    swings = modal[DAMPING, n] == 0.0 and abs(omega - round(omega)) <= WHOLE * omega
    if swings:  # whole swings in a turn that the load does not drive: any state comes back
        u, v = 0.0, 0.0
    else:
        a, b, c, e = propagated(modal, n, TURN)
        loss = -math.expm1(-modal[HALF_D, n] * TURN)
        divisor = loss * loss + 2.0 * versine(modal, n, TURN)
        u, v = ((1.0 - e) * u + b * v) / divisor, (c * u + (1.0 - a) * v) / divisor
    for j in range(pieces):
        knots[0, n, j], knots[1, n, j] = u, v
        a, b, c, e = propagated(modal, n, steps[LENGTH, j])
        jump = (steps[VALUE, j] - steps[VALUE, (j + 1) % pieces]) / square
        u, v = a * u + b * v + jump, c * u + e * v
    if swings:
        own_swing(room, n)


@inner
def own_swing(room, n):
    """Take what an undriven mode swings at its own frequency off the knots: it is not a part of what is forced."""
    steps, knots, omega = room.steps, room.knots, room.modal[OMEGA, n]
    swing = complex(0.0, 0.0)
    for j in range(steps.shape[1]):
        start = complex(knots[0, n, j], -knots[1, n, j] / omega)
        back = complex(math.cos(steps[START, j] * omega), -math.sin(steps[START, j] * omega))
        twice = omega * steps[LENGTH, j]
        # (1 − exp(−2iωl))/(2iω)
        other = math.sin(twice) / omega * complex(math.cos(twice), -math.sin(twice))
        swing += back * (start * steps[LENGTH, j] + start.conjugate() * other)
    swing /= TURN
    for j in range(steps.shape[1]):
        here = swing * complex(math.cos(steps[START, j] * omega), math.sin(steps[START, j] * omega))
        knots[0, n, j] -= here.real
        knots[1, n, j] += omega * here.imag


@inner
def piece_at(steps, t):
    """The step that a time is on, of two the later one, and the time since its begin."""
    pieces, phase = steps.shape[1], t % TURN
    piece = pieces - 1
    for j in range(pieces):
        if steps[START, j] <= phase:
            piece = j
    for j in range(pieces):
        if abs(phase - steps[START, j]) <= SNAP * TURN:
            piece = j
            break
    if abs(phase - steps[START, 0] - TURN) <= SNAP * TURN:
        piece = 0
    since = (t - steps[START, piece]) % TURN
    return piece, 0.0 if since > steps[LENGTH, piece] + 1e-9 else since


@inner
def forced(room):
    """The forced motion at all impacts: force, v_f and its antiderivative, f_n and f_n'."""
    impacts = room.impacts
    for i in range(impacts.shape[1]):
        if room.steps.shape[1]:
            forced_by_steps(room, i)
        else:
            forced_by_waves(room, i)


@inner
def forced_by_steps(room, i):
    modal, steps, impacts, carried = room.modal, room.steps, room.impacts, room.carried
    d = room.numbers[DRAG]
    j, t = piece_at(steps, impacts[TIME, i])
    v, pull = steps[KNOT_V, j], steps[PULL, j]
    impacts[FORCE, i] = steps[VALUE, j]
    impacts[V_FORCED, i] = v * math.exp(-d * t) + pull * t * phi1(d * t)
    impacts[U_FORCED, i] = steps[KNOT_U, j] + v * t * phi1(d * t) + pull * t * t * phi2(d * t)
    for n in range(modal.shape[1]):
        a, b, c, e = propagated(modal, n, t)
        u, v = room.knots[0, n, j], room.knots[1, n, j]
        carried[F, n, i] = a * u + b * v + steps[VALUE, j] / modal[SQUARE, n]
        carried[F_RATE, n, i] = c * u + e * v


@inner
def forced_by_waves(room, i):
    modal, waves, impacts, carried, gains = room.modal, room.waves, room.impacts, room.carried, room.gains
    number, force, v, u = waves.shape[1], room.numbers[MEAN], 0.0, 0.0
    for j in range(number):
        angle = waves[K, j] * impacts[TIME, i]
        cosine, sine = math.cos(angle), math.sin(angle)
        room.turned[0, i, j], room.turned[1, i, j] = cosine, sine
        force += waves[P_RE, j] * cosine - waves[P_IM, j] * sine
        v += waves[V_RE, j] * cosine - waves[V_IM, j] * sine
        u += waves[U_RE, j] * cosine - waves[U_IM, j] * sine
    impacts[FORCE, i], impacts[V_FORCED, i], impacts[U_FORCED, i] = force, v, u
    for n in range(modal.shape[1]):
        moved, rate = modal[STATIC, n], 0.0
        for j in range(number):
            cosine, sine = room.turned[0, i, j], room.turned[1, i, j]
            moved += gains[0, n, j] * cosine - gains[1, n, j] * sine
            rate -= waves[K, j] * (gains[0, n, j] * sine + gains[1, n, j] * cosine)
        carried[F, n, i], carried[F_RATE, n, i] = moved, rate


# ---- The motion through impacts at given times: every mode comes back after a cycle, so that p equations are left

TURNED, CANCELLED = 4.0 * 2.0**-52, 8.0 * 2.0**-52  # as in percuss.steady.oscillator
CANCELS = 1e-6  # det(ξ − M_n) below this is found anew, without differences of ones


@inner
def returning(room, n, a, b, c, e, xi, u, v):
    """(ξ − M)⁻¹(u, v) and the determinant; in resonance the shortest that fits best."""
    a, e = xi - a, xi - e
    divisor, least = a * e - b * c, 0.0
    if abs(divisor) < CANCELS:
        a, b, c, e, least = away(room, n, xi)
        divisor = a * e - b * c
    if abs(divisor) > least:
        return (e * u + b * v) / divisor, (c * u + a * v) / divisor, divisor
    size = a * a + e * e + b * b + c * c
    size = size if size > 0.0 else 1.0
    return (a * u - c * v) / size, (e * v - b * u) / size, divisor


@inner
def away(room, n, xi):
    """ξ − a, b, c, ξ − e of M_n as `impact_chain.Blocks` has it, and what of det is rounding."""
    modal, carried, alpha, beta = room.modal, room.carried, room.numbers[ALPHA], room.numbers[BETA]
    whole_a, whole_e, off_a, off_e, b, c, period, terms = 1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for i in range(carried.shape[2]):
        sa, sb, sc, se = carried[A, n, i], carried[B, n, i], carried[C, n, i], carried[E, n, i]
        lag = modal[HALF_D, n] * sb
        cosine = sa - lag
        sign = math.copysign(1.0, cosine)
        near = cosine - sign
        if abs(cosine) > 0.5:
            loss = -math.expm1(-modal[HALF_D, n] * room.impacts[FLIGHT, i])
            near = (sb * sc + lag * lag) / (cosine + sign * (1.0 - loss)) - sign * loss
        off_a, c = alpha * (sa * off_a + (near + lag) * whole_a + sb * c), beta * (sc * (whole_a + off_a) + se * c)
        off_e, b = beta * (se * off_e + (near - lag) * whole_e + sc * b), alpha * (sa * b + sb * (whole_e + off_e))
        whole_a, whole_e = alpha * sign * whole_a, beta * sign * whole_e
        period, terms = period + room.impacts[FLIGHT, i], terms + 2.0 * abs(near) + abs(sb * sc)
    turned = TURNED * modal[OMEGA, n] * period
    least = CANCELLED * terms + 2.0 * (1.0 + beta if carried.shape[2] == 1 else 2.0) * turned * turned
    return (xi - whole_a) - off_a, b, c, (xi - whole_e) - off_e, least


@inner
def cycle_of(carried, n, alpha, beta):
    """M_n, the map of a mode over a whole cycle with the times held."""
    a, b, c, e = 1.0, 0.0, 0.0, 1.0
    for i in range(carried.shape[2]):
        pa, pb, pc, pe = carried[A, n, i], carried[B, n, i], carried[C, n, i], carried[E, n, i]
        a, c = alpha * (pa * a + pb * c), beta * (pc * a + pe * c)
        b, e = alpha * (pa * b + pb * e), beta * (pc * b + pe * e)
    return a, b, c, e


@entry
def passage(system, room, period, times, kind, rebound):
    """The motion of a system through impacts at times, into the arrays of its room."""
    prepared(system, room)
    passed(room, times, period, kind, rebound)


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
    u, v, divisor = returning(room, n, a, b, c, e, 1.0, u, v)
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


# ---- The flights of a motion sample by sample: their greatest maximum, and a proof that the bar stays off the wall
#
# On a stretch of a flight under one step of the load, or under harmonics on all of it, the gap function is
#
#     y(t) = level + Σ γ_n x_n(t) + Σ Re H_k exp(ikθ) + w t φ1(dt) + p t² φ2(dt),
#
# x_n free oscillations: about the static displacement for steps, without the waves, and else about the forced motion.

PER_WAVE, FEWEST, LEAST = 8.0, 96.0, 8  # samples in a period of the fastest mode, in a flight, in a stretch
PARTS, SMALLEST = 256, 16  # parts of a stretch, and samples in one, in which the bar may be proved to go one way
ROUNDS = 60
ROUNDING = 1e-12  # of the greatest |y| and of what it is the sum of

# rows of `free`: x_n and its rate at the begin of the stretch, at the sample, and Φ_n from sample to sample
X, X_RATE, NOW, NOW_RATE, PA, PB, PC, PE = range(8)
# rows of `spun`: H_k, exp(ikθ) at the sample, and from sample to sample
H_RE, H_IM, COSINE, SINE, TURN_COSINE, TURN_SINE = range(6)
# of the stretch: where it begins, the level, w, p, how long it is, a bound of |y''|, the size of the terms, and bounds
# of |y''| without the x_n, and of their |y'|, with what rounding makes of it, and of their |y|
BEGIN, LEVEL, DRIFT, FORCED, LONG, BEND, SIZE, STEADY_BEND, RINGING, SWING = range(10)
# found: the greatest maximum, when after the impact, in which flight; whether nothing is nearer than the proof sees
HEIGHT, WHEN, WHICH, PROVEN = range(4)


# a maximum that is left out: in which flight, when after the impact; and the impact about which all are
FLIGHT_APART, TIME_APART, IMPACT_APART = range(3)
SAME = 1e-4  # rad: a maximum as near to what is left out is left out


@entry
def flown(room, found, apart):
    """The greatest maximum inside the flights of the motion in a room, and whether the bar is proved to stay off."""
    ends_of_waves(room)
    found[HEIGHT], found[WHEN], found[WHICH], found[PROVEN] = -math.inf, 0.0, 0.0, 1.0
    for i in range(room.impacts.shape[1]):
        if room.impacts[SPEED, i] <= 0.0 or room.numbers[BETA] >= 0.0:
            found[PROVEN] = 0.0
        flight(room, i, found, apart)


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


@entry
def end_at(room, i, time, found):
    """y, y' and y'' of the striking end in a flight, at a time after its impact."""
    ends_of_waves(room)
    at, whole = room.stretch, room.impacts[FLIGHT, i]
    begun(room, i)
    if room.steps.shape[1] == 0:
        on_waves(room, i)
        found[0], found[1], found[2] = placed(room, time)
        return
    gone, level, rate, last = 0.0, 0.0, room.impacts[REBOUND, i], 0.0
    for _ in range(room.steps.shape[1] * (2 + int(whole / TURN))):
        last = on_step(room, i, gone, rate, level, last)
        if time <= gone + at[LONG] or gone + at[LONG] >= whole * (1.0 - 1e-14):
            break
        level, rate = left_behind(room)
        gone += at[LONG]
    found[0], found[1], found[2] = placed(room, time - gone)


@inner
def flight(room, i, found, apart):
    """One flight: its stretches, one after the other."""
    at, whole, time = room.stretch, room.impacts[FLIGHT, i], 0.0
    samples = max(FEWEST, PER_WAVE * begun(room, i) * whole / TURN)
    if room.steps.shape[1] == 0:
        on_waves(room, i)
        stretch(room, i, 0.0, whole, max(LEAST, int(samples)), found, apart)
        return
    rate, level, last = room.impacts[REBOUND, i], 0.0, 0.0
    for _ in range(room.steps.shape[1] * (2 + int(whole / TURN))):
        last = on_step(room, i, time, rate, level, last)
        long = at[LONG]
        level, rate = stretch(room, i, time, whole, max(LEAST, int(samples * long / whole)), found, apart)
        time += long
        if time >= whole * (1.0 - 1e-14):
            return
    found[PROVEN] = 0.0


@inner
def begun(room, i):
    """The x_n at the begin of a flight, and the highest frequency in it."""
    modal, free, carried = room.modal, room.free, room.carried
    alpha, beta, by_steps = room.numbers[ALPHA], room.numbers[BETA], room.steps.shape[1] > 0
    fastest = 1.0 if by_steps else room.waves[K, room.waves.shape[1] - 1]
    for n in range(modal.shape[1]):
        fastest = max(fastest, modal[OMEGA, n])
        free[X, n], free[X_RATE, n] = alpha * carried[U, n, i], beta * carried[V, n, i]
        if not by_steps:
            free[X, n] -= carried[F, n, i]
            free[X_RATE, n] -= carried[F_RATE, n, i]
    return fastest


@inner
def on_waves(room, i):
    """The stretch of a flight under harmonics: all of it."""
    impacts, at = room.impacts, room.stretch
    at[BEGIN], at[LONG] = impacts[TIME, i], impacts[FLIGHT, i]
    at[FORCED], at[DRIFT] = room.numbers[PUSH], impacts[REBOUND, i] - impacts[V_FORCED, i]
    at[LEVEL] = 0.0
    bounded(room, impacts[REBOUND, i])
    at[LEVEL] = -placed(room, 0.0)[0]


@inner
def on_step(room, i, time, rate, level, last):
    """The stretch under one step of the load, from a time of the flight and the force before on; returns the force."""
    impacts, modal, free, at, whole = room.impacts, room.modal, room.free, room.stretch, room.impacts[FLIGHT, i]
    piece, since = piece_at(room.steps, impacts[TIME, i] + time)
    long = min(room.steps[LENGTH, piece] - since, whole - time)
    if long <= 1e-12:  # at the very end of a step
        piece, long = (piece + 1) % room.steps.shape[1], 0.0
        long = min(room.steps[LENGTH, piece], whole - time)
    force = room.steps[VALUE, piece]
    for n in range(modal.shape[1]):
        free[X, n] += (last - force) / modal[SQUARE, n]
    at[BEGIN], at[LONG] = impacts[TIME, i] + time, long
    at[FORCED], at[DRIFT], at[LEVEL] = room.numbers[FREE] * force, rate, 0.0
    bounded(room, rate)
    at[LEVEL] = level - placed(room, 0.0)[0]
    return force


@inner
def left_behind(room):
    """The x_n moved to the end of the stretch; y and the velocity of the bar as a whole there."""
    at, modal, free, d = room.stretch, room.modal, room.free, room.numbers[DRAG]
    y, _, _ = placed(room, at[LONG])
    for n in range(modal.shape[1]):
        a, b, c, e = propagated(modal, n, at[LONG])
        u, v = free[X, n], free[X_RATE, n]
        free[X, n], free[X_RATE, n] = a * u + b * v, c * u + e * v
    return y, at[DRIFT] * math.exp(-d * at[LONG]) + at[FORCED] * at[LONG] * phi1(d * at[LONG])


@inner
def bounded(room, rebound):
    """A bound of |y''| on the stretch, and how large the terms of y are."""
    at, modal, waves, spun, free = room.stretch, room.modal, room.waves, room.spun, room.free
    d, push, long = room.numbers[DRAG], abs(at[FORCED]), at[LONG]
    swings, forces, rates, bend, size, ringing = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    at[STEADY_BEND] = push + d * abs(at[DRIFT])
    for j in range(waves.shape[1]):
        forces += math.hypot(waves[P_RE, j], waves[P_IM, j])
        rates += math.hypot(waves[V_RE, j], waves[V_IM, j])
        re, im = spun[H_RE, j] - waves[U_RE, j], spun[H_IM, j] - waves[U_IM, j]
        bend += waves[K, j] * waves[K, j] * math.hypot(re, im)
        far = math.hypot(spun[H_RE, j], spun[H_IM, j])
        at[STEADY_BEND] += waves[K, j] * waves[K, j] * far
        size += far
    for n in range(modal.shape[1]):
        omega = modal[OMEGA, n]
        swing = abs(modal[GAMMA, n]) * math.hypot(free[X, n], free[X_RATE, n] / omega)
        bend += swing * (modal[SQUARE, n] + modal[DAMPING, n] * omega)
        ringing += swing * omega
        swings += swing
    size += swings
    fastest = abs(rebound) + rates + rates + push * long
    at[BEND] = bend + room.numbers[FREE] * forces + push + d * fastest
    at[SIZE] = size + fastest * long
    at[SWING] = swings
    at[RINGING] = ringing + ROUNDING * (ringing + fastest)


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
def stretch(room, i, time, whole, number, found, apart):
    """Sample a stretch that begins at a time of its flight; y and the velocity of the bar as a whole at its end."""
    at, modal, free, waves, spun = room.stretch, room.modal, room.free, room.waves, room.spun
    step = at[LONG] / number
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
    part, last, skipped, below = max(SMALLEST, number // PARTS), 0, False, False
    wide = part
    while last < number:
        first, last = last, min(last + wide, number)
        middle, rest = steady(room, 0.5 * step * (first + last))
        half = 0.5 * step * (last - first)
        nearest = middle + at[SWING] + half * (abs(rest) + 0.5 * at[STEADY_BEND] * half) + small
        one_way = abs(rest) > at[RINGING] + at[STEADY_BEND] * half  # rising or falling: the x_n cannot turn it
        if nearest < 0.0 and (one_way or nearest < found[HEIGHT]):
            below, wide = True, 2 * wide  # off the wall, and no maximum there is the greatest
            continue
        if wide > part:
            last, wide = first, part
            continue
        if one_way:
            y, rate, _ = placed(room, last * step)
            leaves = time == 0.0 and first == 0 and rate < 0.0
            strikes = last == number and safe_stop < whole and rate > 0.0
            if not leaves and not strikes and max(y, -math.inf if below else before) + small >= 0.0:
                found[PROVEN] = 0.0
            before, speed, skipped, below = y, rate, True, False
            continue
        if below:
            before, speed, _ = placed(room, first * step)
        if skipped or below:
            moved(room, first * step)
            skipped, below = False, False
        for m in range(first + 1, last + 1):
            t = m * step
            y, rate = sampled(room, t)
            if speed > 0.0 and rate <= 0.0 and max(y, before) + 0.25 * (speed - rate) * step > found[HEIGHT]:
                top(room, i, time, t - step, t, found, apart)
            if time + t > safe_start and time + t - step < safe_stop and max(y, before) + reach + small >= 0.0:
                found[PROVEN] = 0.0
            before, speed = y, rate
    return left_behind(room)


@inner
def steady(room, t):
    """y and y' at a time of a stretch without the x_n."""
    at, waves, spun = room.stretch, room.waves, room.spun
    d = room.numbers[DRAG]
    fade = t * phi1(d * t)
    y = at[LEVEL] + at[DRIFT] * fade + at[FORCED] * t * t * phi2(d * t)
    rate = at[DRIFT] * math.exp(-d * t) + at[FORCED] * fade
    for j in range(waves.shape[1]):
        angle = waves[K, j] * (at[BEGIN] + t)
        cosine, sine = math.cos(angle), math.sin(angle)
        y += spun[H_RE, j] * cosine - spun[H_IM, j] * sine
        rate -= waves[K, j] * (spun[H_RE, j] * sine + spun[H_IM, j] * cosine)
    return y, rate


@inner
def moved(room, t):
    """The x_n and the harmonics at a time of the stretch, from which the next sample is taken."""
    at, modal, free, waves, spun = room.stretch, room.modal, room.free, room.waves, room.spun
    for n in range(modal.shape[1]):
        a, b, c, e = propagated(modal, n, t)
        u, v = free[X, n], free[X_RATE, n]
        free[NOW, n], free[NOW_RATE, n] = a * u + b * v, c * u + e * v
    for j in range(waves.shape[1]):
        angle = waves[K, j] * (at[BEGIN] + t)
        spun[COSINE, j], spun[SINE, j] = math.cos(angle), math.sin(angle)


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
def top(room, i, time, low, high, found, apart):
    """The maximum between two times of a stretch, noted where it is the greatest so far, and not left out."""
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
    known = float(i) == apart[FLIGHT_APART] and abs(time + t - apart[TIME_APART]) < SAME
    known = known or (float(i) == apart[IMPACT_APART] and time + t < SAME)
    last = float((i + 1) % room.impacts.shape[1]) == apart[IMPACT_APART]
    known = known or (last and time + t > room.impacts[FLIGHT, i] - SAME)
    if y > found[HEIGHT] and not known:
        found[HEIGHT], found[WHEN], found[WHICH] = y, time + t, float(i)
