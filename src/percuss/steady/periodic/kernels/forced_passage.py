"""The motion through impacts at given times: every mode comes back after a cycle, so that p equations are left."""

from __future__ import annotations

import math

from percuss.compiled import entry, inner
from percuss.steady.periodic.kernels.orbit_records import (
    ALPHA,
    BEST,
    BETA,
    CLOSURE,
    CREEPS,
    DAMPING,
    DRAG,
    F_RATE,
    FADE,
    FLIGHT,
    FORCE,
    FREE,
    GAMMA,
    GAP,
    GIVEN,
    HALF_D,
    HEAD,
    KNOT_U,
    KNOT_V,
    LENGTH,
    MEAN,
    OFF,
    OMEGA,
    P_IM,
    P_RE,
    PULL,
    PUSH,
    RATE,
    REBOUND,
    RESONANCE,
    RIGID,
    SPEED,
    SQUARE,
    START,
    STATIC,
    STAY,
    TIME,
    U_FORCED,
    U_IM,
    U_RE,
    V_FORCED,
    V_IM,
    V_RE,
    VALUE,
    A,
    B,
    C,
    E,
    F,
    K,
    U,
    V,
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
