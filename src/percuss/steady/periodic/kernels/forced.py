"""The forced motion of all modes at the impacts, for a load of harmonics or of steps."""

import math

from percuss.compiled import inner
from percuss.steady.periodic.kernels.layout import (
    CREEPS,
    DAMPING,
    DRAG,
    F_RATE,
    FORCE,
    FREE,
    GAMMA,
    HALF_D,
    HEAD,
    KNOT_U,
    KNOT_V,
    LENGTH,
    MEAN,
    OMEGA,
    P_IM,
    P_RE,
    PULL,
    RATE,
    SQUARE,
    START,
    STATIC,
    TIME,
    U_FORCED,
    U_IM,
    U_RE,
    V_FORCED,
    V_IM,
    V_RE,
    VALUE,
    F,
    K,
)
from percuss.steady.periodic.kernels.oscillator import phi1, phi2, phi3, propagated, versine

__all__ = ["forced", "prepared"]

TURN = 2.0 * math.pi
SNAP = 8.0 * 2.0**-52  # as in percuss.model.load
WHOLE = 64.0 * 2.0**-52  # as in percuss.steady.piecewise


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
