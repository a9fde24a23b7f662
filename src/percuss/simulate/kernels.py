"""The flight of the bar, its next contact and its impact, compiled: plain functions of numbers and arrays.

Everything that is compiled stands in this one file: numba's cache does not see a change in another one. The functions
neither allocate nor raise and know no object, so that the same source can be compiled for another device.

The state at an instant, the *anchor* (theory §§2, 8). The gap function is y = u_0 + Σ q_n with q_n = 2(−1)ⁿ u_n, and
every q_n is a forced part, known for all times, and a free one. The free part of an oscillating mode is
e^{−dτ/2} Re z_n e^{iλ_nτ}, τ after the anchor; the lowest `over` modes, overdamped or close to it, keep the value and
the rate of their free part instead. With them go the gap y, its rate, and the velocity of the mean of the bar.
Increments since the anchor are summed, never positions, so that flights of 1e-9 are as exact as flights of 1.

What is proved (`next_contact`). Let S be the gap less the free elastic part f. S and S' are cheap and |S''| has a known
bound; |f|, |f'|, |f''|, |f'''| are bounded by sums of amplitudes. From each anchor the gap is below the least of

    S + sup|f|,    S + f + sup|f'| h,    y + y'h + y''h²/2 + sup|y'''| h³/6,

each of which is stepped over with the bound of its own curvature, and never past its first root. The bounds fade with
the motion: they are taken anew as damping takes the free parts away, while the anchor stays. The contact itself is
accepted where y' exceeds what the curvature can take back before y has reached 0; the root is then unique between two
times, and Newton's method (Halley's form), held between them, converges to it. What rounding cannot decide, by the
error of what was really summed (`blur`), is returned as a graze. A motion that nearly repeats is spared the steps: the
flight after a like impact is tried first, and the same bounds, taken forward from the anchor and backward from there,
must leave no time between them.
"""

import math

from numba import njit

# -- layout of the arrays that the functions share ------------------------------------------------------------------

# par: numbers of the system. Of the smooth part of the gap: bounds REACH of its oscillation, RATE, CURVE and JERK of
# the derivatives. FORCE: Σ|p_k|, the speed scale. BEND: bound of |p''|. WAVE: time of a wave through the bar;
# RIPPLE: half a period of the shortest one. PUSHING: bound of the time for which the load never pulls, or inf. SWAY,
# SWING: what rounding is measured by, the sums Σk|amplitude| of the rigid oscillation and of all modes, which may be
# much more than their sum's.
D, R, BASE, MEAN, REACH, RATE, CURVE, JERK, FORCE, BEND, WAVE, RIPPLE, PUSHING, SWAY, SWING = range(15)
PARAMETERS = 15

# mode: one row of numbers for all elastic modes. λ, 1/λ, λ², δ and OSCILLATES (0 or 1) are 0 for the `over` lowest
# ones, so that loops run over all modes: numba makes vector code of those that start at 0 only. SIGNED: λ² as it is.
OMEGA, LAMBDA, INVERSE, SQUARE, DELTA, OSCILLATES, SIGNED, STATICS = range(8)
MODE_ROWS = 8
# work: one row for all modes: phasors, forced motion, and two to put by
PHASOR_RE, PHASOR_IM, FORCED, ASIDE_RE, ASIDE_IM = range(5)
WORK_ROWS = 5

# har: one row of numbers for all harmonics k = 1, 2, …: gap, rigid and load amplitudes
GAP_RE, GAP_IM, RIGID_RE, RIGID_IM, LOAD_RE, LOAD_IM = range(6)
HARMONIC_ROWS = 6

# now: the anchor, besides the amplitudes z. COSINE, SINE: of the phase. HOLD: time for which the flight is known to
# be free
GAP, GAP_RATE, RIGID_RATE, PHASE, COSINE, SINE, HOLD = range(7)
# … what is known of the flight from it
FREE, FREE_OSCILLATING, FREE_CURVE, SUP, SUP1, SUP2, SUP3, DRIFT, SMOOTH_RATE, ACCELERATION = range(7, 17)
# … and of the impacts up to it. LAST_PLACE: u_0 when the first step of the load last began, 0 when unknown
KINETIC_ENERGY, LAST_FLIGHT, SINCE, LAST_PLACE = range(17, 21)
# … PUSHES: time for which the load still pushes after an impact with RUN > 1. RELEASED: phase of the last release, −1
# when it is none of `releases`. MARKED: of the release that later ones are compared with. LAID: sum of the phases at
# which the bar was laid down since then
PUSHES, RELEASED, MARKED, LAID = range(21, 25)
NUMBERS = 25

# count: whole numbers of the anchor. RUN: impacts of the present sequence of ever shorter flights, under a load that
# pushes or each shorter than a wave through the bar takes: the load works on the other end, and a strained bar may
# bounce long after the load has begun to pull there. PILE: those of them that come without any time between
PERIOD, PIECE, MODE, IMPACTS, RUN, PILE, EVENTS, WORK = range(8)
# … and of the search for a cycle, see `recurrence`
ANCHOR, ANCHOR_PERIOD, PATIENCE, RESTS, CHATTERS, CYCLE_IMPACTS, CYCLE_PERIODS, CYCLE_KIND, CONFIRMED, FOUND_AT = range(
    8, 18
)
# … and among the releases, see `released_again`. RELEASE_PERIOD: of the last one. MARK, MARK_PERIOD: first impact after
# the release that is compared with, and its load period. MARK_CHATTERS: chatters since then
RELEASE_PERIOD, MARK, MARK_PERIOD, MARK_PATIENCE, MARK_RELEASES, MARK_CHATTERS, VERDICT = range(18, 25)
COUNTS = 25

# VERDICT on two equal releases: none yet, none in a twin yet, to be tested, the cycle is sure, or lost in rounding
UNSEEN, TWIN, ASKED, SURE, LOST_CYCLE = range(5)

# MODE of the anchor
FLYING, ON_WALL, RESTING, GRAZED = range(4)

# kinds of events
IMPACT, GRAZING, CHATTER, REST, RELEASE = range(5)
# columns of an event: of the floats, and of the integers
AT_PHASE, BEFORE, AFTER, LOST, KINETIC = range(5)
EVENT_NUMBERS = 5
KIND, AT_PERIOD, RESOLVED, IN_PIECE = range(4)
EVENT_COUNTS = 4
# columns of the state after an event, before the two rows of z
STATE_GAP, STATE_RIGID = range(2)
STATE_NUMBERS = 2

# what a call ends with
FULL, BY_IMPACTS, BY_TIME, AT_REST, PERIODIC, DEPARTED, BY_WORK, TO_VERIFY, UNRESOLVED = range(9)
# what a search for the next contact ends with
NOTHING, CONTACT, GRAZE, AWAY, TIRED = range(5)

TURN = 2.0 * math.pi
TURN_LOW = 2.4492935982947064e-16  # 2π less its double
EPS = 2.0**-52
CHATTER_TIME = 1e-5  # a chatter is completed when at most this time of it is left …
CHATTER_ERROR = 1e-13  # … and its end is known to this
NO_SPEED = 1e-13  # a rebound slower than this, of the speeds that occur, is no rebound
SMALL = 1e-3  # an angle whose fifth power does not matter
SLICE = 1 << 17  # evaluations of a member of an ensemble between two looks at the outside
WINDOW = 256  # last impacts kept for the classifier, at least; always a power of 2
SAME = 64  # of them looked at
SHIFTS = 32  # longest cycle that makes a motion "not aperiodic"
ALIKE = 1e-2  # phases of impacts after which the flight may be alike
LOOSE = 1e-3  # and how near it must come back
SETTLING = 100.0  # tolerances within which a state after a rest is still on its way to the one after the rest before
NUDGE = 1e-12  # change of R and d under which a cycle from release to release must stay the same to be stated …
FEW = 4  # … unless it has no more main blows than these

SUMS = {"reassoc", "contract", "nsz"}  # sums may be reordered; NaN and infinity keep their meaning


# -- the parts of a motion ------------------------------------------------------------------------------------------


@njit(cache=True, nogil=True, error_model="numpy")
def sine_cosine(x):
    """sin x and cos x together, each to 2e-16, by reduction to |x| ≤ π/4 in three parts and Taylor's polynomials.

    Never to be inlined into a function with reordered sums: they would undo its rounding.
    """
    if not abs(x) < 1e5:
        return math.sin(x), math.cos(x)
    turns = (x * 0.6366197723675814 + 6755399441055744.0) - 6755399441055744.0  # to the nearest whole number
    r = ((x - turns * 1.5707963267341256) - turns * 6.077100506303966e-11) - turns * 2.0222662487111665e-21
    q = r * r
    even = q * q
    s = (
        (-1.0 / 6.0 + q * (1.0 / 120.0))
        + even * ((-1.0 / 5040.0 + q * (1.0 / 362880.0)) + even * ((-1.0 / 39916800.0 + q * (1.0 / 6227020800.0))
        + even * (-1.0 / 1307674368000.0)))
    )  # fmt: skip
    c = (
        (1.0 / 24.0 - q * (1.0 / 720.0))
        + even * ((1.0 / 40320.0 - q * (1.0 / 3628800.0)) + even * ((1.0 / 479001600.0 - q * (1.0 / 87178291200.0))
        + even * (1.0 / 20922789888000.0)))
    )  # fmt: skip
    s = r + r * q * s
    c = 1.0 - (0.5 * q - even * c)
    which = int(turns)
    sine, cosine = (c, s) if which & 1 else (s, c)
    return -sine if which & 2 else sine, -cosine if (which + 1) & 2 else cosine


@njit(cache=True, nogil=True, error_model="numpy")
def drift(d, tau):
    """(1 − e^{−dτ})/d and its integral, for any d ≥ 0; theory §2, mode 0."""
    x = d * tau
    if x < 0.04:
        xx = x * x
        total = 1.0 / 40320.0 - x * (1.0 / 362880.0)
        total = (1.0 / 24.0 - x * (1.0 / 120.0)) + xx * ((1.0 / 720.0 - x * (1.0 / 5040.0)) + xx * total)
        total = (0.5 - x * (1.0 / 6.0)) + xx * total
        return tau * (1.0 - x * total), tau * tau * total
    if x < 0.5:
        term, total, k = 0.5, 0.5, 2.0
        while abs(term) > 1e-17:
            k += 1.0
            term *= -x / k
            total += term
        return tau * (1.0 - x * total), tau * tau * total
    first = -math.expm1(-x) / d
    return first, (tau - first) / d


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def smooth_and_drift(par, now, osc, tau):
    """S(τ) − S(0), S'(τ), S''(τ), the gap without the free elastic part; and what `drift` said."""
    d, b = par[D], now[DRIFT]
    first, second = drift(d, tau)
    y = b * first + par[MEAN] * second
    v = now[SMOOTH_RATE] + (par[MEAN] - d * b) * first
    a = (par[MEAN] - d * b) * (1.0 - d * first)
    if osc.shape[1]:
        sh, ch = sine_cosine(0.5 * tau)
        er1, ei1 = -2.0 * sh * sh, 2.0 * sh * ch  # e^{iτ} − 1, exact for small τ
        er, ei = er1, ei1
        for k in range(osc.shape[1]):
            if k:
                er, ei = er + er1 + (er * er1 - ei * ei1), ei + ei1 + (er * ei1 + ei * er1)
            g, h, n = osc[0, k], osc[1, k], k + 1.0
            y += g * er - h * ei
            v -= n * (g * ei + h * er)
            a -= n * n * (g * (1.0 + er) - h * ei)
    return y, v, a, first, second


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def smooth(par, now, osc, tau):
    """The first three of them."""
    y, v, a, _, _ = smooth_and_drift(par, now, osc, tau)
    return y, v, a


@njit(cache=True, nogil=True, error_model="numpy")
def rigid_rate(par, har, drifted, c, s):
    """u_0', the velocity of the mean of the bar: of its drift, and of its oscillation at a load phase."""
    wr, wi, v = c, s, drifted
    for k in range(har.shape[1]):
        if k:
            wr, wi = wr * c - wi * s, wr * s + wi * c
        v -= (k + 1) * (har[RIGID_RE, k] * wi + har[RIGID_IM, k] * wr)
    return v


@njit(cache=True, nogil=True, error_model="numpy")
def drifted(par, now, tau):
    """Velocity of the drift at τ."""
    first, _ = drift(par[D], tau)
    return now[DRIFT] + (par[MEAN] - par[D] * now[DRIFT]) * first


@njit(cache=True, nogil=True, error_model="numpy")
def load_at(har, mean, c, s):
    """p and p' of a load that is a Fourier series, at the phase whose cosine and sine are given."""
    wr, wi, p, rate = 1.0, 0.0, mean, 0.0
    for k in range(har.shape[1]):
        wr, wi = wr * c - wi * s, wr * s + wi * c
        p += har[LOAD_RE, k] * wr - har[LOAD_IM, k] * wi
        rate -= (k + 1) * (har[LOAD_RE, k] * wi + har[LOAD_IM, k] * wr)
    return p, rate


@njit(cache=True, nogil=True, error_model="numpy")
def creep(d, square, omega, tau):
    """g, h, h' and 1 − g of a mode that is overdamped or close to it, each without cancellation.

    h is the answer to a unit push, h(0) = 0 and h'(0) = 1, and g = ω² ∫h, so that the free motion is
    q − q(0) = q'(0) h − q(0) g, with rate q'(0) h' − q(0) ω² h. `square`: λ² = ω² − d²/4, of either sign.
    """
    x = d * tau
    if x < 1.0:  # the power series of h, its terms divided by τ
        y = omega * tau
        y *= y
        before, term, g, h, rate = 0.0, 1.0, 0.5, 1.0, 1.0
        k = 1.0
        while k < 24.0:
            before, term = term, -(x * term + y * before / k) / (k + 1.0)
            k += 1.0
            h += term
            g += term / (k + 1.0)
            rate += term * k
            if abs(term) + abs(before) * y < 1e-19:
                break
        g *= y
        return g, tau * h, rate, 1.0 - g
    half = 0.5 * d
    if square > 0.0:
        lam = math.sqrt(square)
        fade = math.exp(-0.5 * x)
        sine, cosine = math.sin(0.5 * lam * tau), math.cos(lam * tau)
        h = fade * (math.sin(lam * tau) / lam)
        slow = fade * cosine
        return fade * (2.0 * sine * sine) - math.expm1(-0.5 * x) - half * h, h, slow - half * h, slow + half * h
    kappa = math.sqrt(-square)
    rate = omega * omega / (half + kappa)  # of the slow part, d/2 − κ
    fade, spread = math.exp(-rate * tau), 2.0 * kappa * tau
    h = fade * (-math.expm1(-spread) / (2.0 * kappa) if spread > 1e-300 else tau)
    return -math.expm1(-rate * tau) - rate * h, h, fade * math.exp(-spread) - rate * h, fade + rate * h


@njit(cache=True, nogil=True, error_model="numpy")
def fading(d, tau):
    """e^{−dτ/2} and e^{−dτ/2} − 1."""
    x = 0.5 * d * tau
    if x < 0.04:
        xx = x * x
        fall = (1.0 / 120.0 - x * (1.0 / 720.0)) + xx * (1.0 / 5040.0 - x * (1.0 / 40320.0))
        fall = -x * ((1.0 - 0.5 * x) + xx * ((1.0 / 6.0 - x * (1.0 / 24.0)) + xx * fall))
        return 1.0 + fall, fall
    return math.exp(-x), math.expm1(-x)


@njit(cache=True, nogil=True, error_model="numpy", fastmath=SUMS)
def phasors(par, mode, work, over, tau):
    """e^{iλ_nτ} − 1 of the oscillating modes into `work`, but for a turn by −δ_n times the result.

    The spectrum nπs is harmonic: powers of one phasor, doubled in number at each round. What damping takes from the
    frequency, δ_n = nπs − λ_n, is left to the caller, or, when it is more than `SMALL`, each is computed by itself.
    """
    n = mode.shape[1]
    if over < n and mode[DELTA, over] * tau > SMALL:
        for j in range(over, n):
            sh, ch = sine_cosine(0.5 * mode[LAMBDA, j] * tau)
            work[0, j] = -2.0 * sh * sh
            work[1, j] = 2.0 * sh * ch
        for j in range(over):
            work[0, j], work[1, j] = 0.0, 0.0
        return 0.0
    sh, ch = sine_cosine(0.5 * par[BASE] * tau)
    ar, ai = -2.0 * sh * sh, 2.0 * sh * ch
    br, bi = ar + ar + (ar * ar - ai * ai), ai + ai + 2.0 * ar * ai
    work[0, 0], work[1, 0] = ar, ai
    if n > 1:
        work[0, 1], work[1, 1] = br, bi
    if n > 2:
        work[0, 2], work[1, 2] = ar + br + (ar * br - ai * bi), ai + bi + (ar * bi + ai * br)
    if n > 3:
        work[0, 3], work[1, 3] = br + br + (br * br - bi * bi), bi + bi + 2.0 * br * bi
    m = 4
    while m < n:
        ar, ai = work[0, m - 1], work[1, m - 1]
        for j in range(min(m, n - m)):
            br, bi = work[0, j], work[1, j]
            work[0, m + j] = ar + br + (ar * br - ai * bi)
            work[1, m + j] = ai + bi + (ar * bi + ai * br)
        m *= 2
    for j in range(over):
        work[0, j], work[1, j] = 0.0, 0.0
    return tau


@njit(cache=True, nogil=True, error_model="numpy", fastmath=SUMS)
def elastic(par, mode, z, now, work, over, tau):
    """f(τ) − f(0), f'(τ), f''(τ) of the free elastic part, and what `phasors` returned; the phasors stay in `work`.

    There stand besides, for the `over` modes, q(τ) and q'(τ) (ASIDE), and q(τ) − q(0) (FORCED).
    """
    n = mode.shape[1]
    if n == 0:
        return 0.0, 0.0, 0.0, 0.0
    d = par[D]
    slip = phasors(par, mode, work, over, tau)
    moved, rate, curve = 0.0, 0.0, 0.0
    for j in range(n):
        x = mode[DELTA, j] * slip
        xx = x * x
        c, s = xx * (xx * (1.0 / 24.0) - 0.5), x * (xx * (1.0 / 6.0) - 1.0)
        er, ei = work[0, j], work[1, j]
        er, ei = er + c + (er * c - ei * s), ei + s + (er * s + ei * c)
        zr, zi = z[0, j], z[1, j]
        step = zr * er - zi * ei
        moved += step
        rate += mode[LAMBDA, j] * (zi + zr * ei + zi * er)
        curve += mode[SQUARE, j] * (zr + step)
    fade, fall = fading(d, tau)
    start = now[FREE_OSCILLATING]
    total = moved + start
    y = fade * moved + fall * start
    v = -fade * (0.5 * d * total + rate)
    a = fade * (d * rate + 0.25 * d * d * total - curve)
    for j in range(over):
        square = mode[OMEGA, j] * mode[OMEGA, j]
        g, h, hr, left = creep(d, mode[SIGNED, j], mode[OMEGA, j], tau)
        step = z[1, j] * h - z[0, j] * g
        q = z[1, j] * h + z[0, j] * left
        w = z[1, j] * hr - z[0, j] * (square * h)
        y += step
        v += w
        a += -d * w - square * q
        work[FORCED, j], work[ASIDE_RE, j], work[ASIDE_IM, j] = step, q, w
    return y, v, a, slip


@njit(cache=True, nogil=True, error_model="numpy")
def most_of(d, square, omega, q, q1, tau, start, start1):
    """Bounds of |q|, |q'|, |q''|, |q‴| from τ on for a mode that is overdamped or close to it.

    `q`, `q1`: value and rate at τ; `start`, `start1`: at the anchor. As 0 ≤ h ≤ 1/d and |1 − g| ≤ 1 (`creep`),
    |q| ≤ |q(τ)| + |q'(τ)|/d. With the two rates a < b of decay, p = q' + a q obeys p' = −b p: it fades at the quick
    one, q' = p − a q, q'' = a² q − d p, q‴ = (a² + b d) p − a³ q, and nothing cancels.
    """
    most = abs(q) + abs(q1) / d
    if square >= 0.0:
        q2 = -d * q1 - omega * omega * q
        q3 = -d * q2 - omega * omega * q1
        q4 = -d * q3 - omega * omega * q2
        rounding = 8.0 * EPS * d * (abs(q1) + d * abs(q))  # all rates are near d/2
        one, two, three = abs(q1) + abs(q2) / d, abs(q2) + abs(q3) / d, abs(q3) + abs(q4) / d
        return most, one + rounding / d, two + 2.0 * rounding, three + 4.0 * rounding * d
    kappa = math.sqrt(-square)
    quick = 0.5 * d + kappa
    slow = omega * omega / quick
    p = (abs(start1 + slow * start) + 4.0 * EPS * (abs(start1) + slow * abs(start))) * math.exp(-quick * tau)
    one = slow * most
    two = slow * one
    return most, one + p, two + d * p, slow * two + (slow * slow + quick * d) * p


@njit(cache=True, nogil=True, error_model="numpy", fastmath=SUMS)
def amplitudes(par, mode, z, now, over):
    """f and f'' at the anchor, and bounds of |f|, |f'|, |f''|, |f'''| ever after."""
    d = par[D]
    f, rate, curve, sup, sup1, sup2, sup3 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for j in range(mode.shape[1]):
        zr, zi, w = z[0, j] * mode[OSCILLATES, j], z[1, j] * mode[OSCILLATES, j], mode[OMEGA, j]
        one, other = abs(zr), abs(zi)
        size = max(one, other) + 0.4142135623730951 * min(one, other)  # ≥ √(zr² + zi²), by 8 % at most
        f += zr
        rate += mode[LAMBDA, j] * zi
        curve += mode[SQUARE, j] * zr
        sup += size
        size *= w
        sup1 += size
        size *= w
        sup2 += size
        sup3 += size * w
    curve = 0.25 * d * d * f + d * rate - curve
    now[FREE_OSCILLATING] = f
    for j in range(over):
        q, q1 = z[0, j], z[1, j]
        f += q
        curve -= d * q1 + mode[OMEGA, j] * mode[OMEGA, j] * q
        most, most1, most2, most3 = most_of(d, mode[SIGNED, j], mode[OMEGA, j], q, q1, 0.0, q, q1)
        sup += most
        sup1 += most1
        sup2 += most2
        sup3 += most3
    now[FREE], now[FREE_CURVE] = f, curve
    grown = 1.0 + 1e-12  # the sums' own rounding
    now[SUP], now[SUP1], now[SUP2], now[SUP3] = sup * grown, sup1 * grown, sup2 * grown, sup3 * grown


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def look(par, har, now, osc):
    """What a flight from the anchor needs to know of the smooth part."""
    c, s = now[COSINE], now[SINE]
    wr, wi, rate, rigid, curve = c, s, 0.0, 0.0, 0.0
    for k in range(har.shape[1]):
        if k:
            wr, wi = wr * c - wi * s, wr * s + wi * c
        g = har[GAP_RE, k] * wr - har[GAP_IM, k] * wi
        h = har[GAP_RE, k] * wi + har[GAP_IM, k] * wr
        osc[0, k], osc[1, k], n = g, h, k + 1.0
        rate -= n * h
        curve -= n * n * g
        rigid -= n * (har[RIGID_RE, k] * wi + har[RIGID_IM, k] * wr)
    now[DRIFT] = now[RIGID_RATE] - rigid
    now[SMOOTH_RATE] = now[DRIFT] + rate
    now[ACCELERATION] = now[FREE_CURVE] + curve + par[MEAN] - par[D] * now[DRIFT]


# -- the next contact -----------------------------------------------------------------------------------------------


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def reach(u, v, m):
    """How far u + v h + m h²/2 stays below 0 from h = 0 on, where it does reach 0 if m < 0; 0 when it is not below."""
    if u > 0.0 or (u == 0.0 and v >= 0.0):
        return 0.0
    root = math.sqrt(v * v - 2.0 * m * u)
    if v >= 0.0:
        return -2.0 * u / (v + root) if v + root > 0.0 else math.inf
    return (root - v) / m if m > 0.0 else math.inf


@njit(cache=True, nogil=True, error_model="numpy")
def reach_cubic(u, v, a, m, m2):
    """How far u + v h + a h²/2 + m h³/6 surely stays below 0, knowing besides that the curvature is at most `m2`.

    On [0, H] the third term is at most (m H/3) h²/2: a parabola for each H tried.
    """
    best = reach(u, v, m2)
    width = 4.0 * best
    if a < 0.0:
        width = max(width, min(-1.5 * a / max(m, 1e-300), 1e9))
    for _ in range(4):
        if not best < width < math.inf:
            break
        curve = a + m * width / 3.0
        if curve <= 0.0 and v <= 0.0:
            got = width if u + v + curve < 0.0 else 0.0
        elif v * v < 2.0 * curve * u:
            got = width  # the top of the parabola lies below 0
        else:
            got = min(width, reach(u, v, curve))
        best = max(best, got)
        width *= 0.5
    return best


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def below(u, v, m):
    """From where to where u − v h + m h²/2 is below 0, for h ≥ 0; an empty span when it never is."""
    inside = v * v - 2.0 * m * u
    if v <= 0.0 or inside <= 0.0:
        return math.inf, 0.0
    both = v + math.sqrt(inside)
    return max(2.0 * u / both, 0.0), (both / m if m > 0.0 else math.inf)


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def below_since(u, v, over, speed, m, near):
    """Up to which h one of u − v h + m h²/2 and over − speed h + m h²/2 is below 0 from `near` on; −1: not there."""
    first, last = below(u, v, m)
    if not first <= near:
        return -1.0
    first, end = below(over, speed, m)
    return max(last, end) if first <= last else last


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def like_flight(now, count, past):
    """The flight that followed the most alike of the impacts 1, 2 and 4 before this one; 0 when none is like it."""
    n, ring, best, flight = count[IMPACTS], past.shape[1] - 1, ALIKE, 0.0
    for k in (1, 2, 4):
        if n > k:
            i, j = (n - 1 - k) & ring, (n - k) & ring
            turn = abs(now[PHASE] - past[0, i])
            turn = min(turn, TURN - turn)
            if turn < best:
                best, flight = turn, (past[2, j] - past[2, i]) * TURN + (past[0, j] - past[0, i])
    return flight


@njit(cache=True, nogil=True, error_model="numpy", fastmath=SUMS)
def ringing(mode, z, over):
    """Σ|z|, Σω|z|, Σω²|z|, Σω³|z| of the oscillating modes: bounds of their free part and its derivatives."""
    sup, sup1, sup2, sup3 = 0.0, 0.0, 0.0, 0.0
    for j in range(over, mode.shape[1]):
        one, other, w = abs(z[0, j]), abs(z[1, j]), mode[OMEGA, j]
        size = max(one, other) + 0.4142135623730951 * min(one, other)  # as in `amplitudes`
        sup += size
        size *= w
        sup1 += size
        size *= w
        sup2 += size
        sup3 += size * w
    return sup * (1.0 + 1e-12), sup1 * (1.0 + 1e-12), sup2 * (1.0 + 1e-12), sup3 * (1.0 + 1e-12)


@njit(cache=True, nogil=True, error_model="numpy")
def creeping(par, mode, z, work, over, tau):
    """Of the overdamped modes: the most that Σ(q − q(0)) comes to from τ on, and bounds of its derivatives.

    q(τ) and the rest are read off `work`, where `elastic` left them, unless τ is 0.
    """
    d, grown = par[D], 1.0 + 1e-12
    most, sup1, sup2, sup3 = 0.0, 0.0, 0.0, 0.0
    for j in range(over):
        q, q1 = z[0, j], z[1, j]
        if tau > 0.0:
            q, q1 = work[ASIDE_RE, j], work[ASIDE_IM, j]
            most += work[FORCED, j]
        most += grown * (max(q1, 0.0) / d + 1.0001 * max(-q, 0.0))  # h ≤ 1/d and g ≥ −1e-4, see `creep`
        _, one, two, three = most_of(d, mode[SIGNED, j], mode[OMEGA, j], q, q1, tau, z[0, j], z[1, j])
        sup1 += grown * one
        sup2 += grown * two
        sup3 += grown * three
    return most, sup1, sup2, sup3


@njit(cache=True, nogil=True, error_model="numpy")
def creep_sizes(par, mode, z, over):
    """Σ|q(0)|, Σω²|q(0)|, Σ|q'(0)| and Σ(d|q'| + ω²|q|) of the overdamped modes: what rounding is measured by."""
    place, push, rate, curve = 0.0, 0.0, 0.0, 0.0
    for j in range(over):
        square = mode[OMEGA, j] * mode[OMEGA, j]
        place += abs(z[0, j])
        push += square * abs(z[0, j])
        rate += abs(z[1, j])
        curve += par[D] * abs(z[1, j]) + square * abs(z[0, j])
    return place, push, rate, curve


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def blur(size, tau, first, second):
    """The rounding error of the gap at τ, where `first` and `second` are those of `drift`.

    It is some eps, already in `size`, times the sum of the absolute values of what is summed: the gap at the anchor;
    the drift b `first` + mean `second`; what the load's harmonics add, at most Σk|amplitude| τ or twice the amplitudes;
    the oscillating modes, whose phase is known to eps λτ while they last, e^{−dτ/2} τ ≤ 2/(e d); and the overdamped
    ones, |q'(0)| h + |q(0)| g with h ≤ `first` and g ≤ ω² `second` (`creep`).
    """
    at, drifting, push, swing, ring, lasting, place, creeps = size
    total = at + drifting * first + push * second + swing * min(tau, 2.0) + ring * min(tau, lasting)
    return total + min(place, creeps * second)


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def next_contact(par, mode, z, now, osc, work, over, on_wall, begin, guess, horizon, limit):
    """The first contact after the anchor, or the proof that there is none before `horizon`.

    `begin` > 0: the flight up to there is known to be free. `guess` > 0: a time worth trying. Returns what was found,
    its time, the gap's rate there, the number of evaluations of the modal sum, how much later than the last one the
    contact is, and what `phasors` said.
    """
    n, d = mode.shape[1], par[D]
    y0, free = now[GAP], now[FREE_OSCILLATING]
    pull = par[MEAN] - d * now[DRIFT]
    curve, up = par[CURVE] + abs(pull), par[CURVE] + max(pull, 0.0)
    ring, ring1, ring2, ring3 = now[SUP], now[SUP1], now[SUP2], now[SUP3]
    most, sup1, sup2, sup3 = 0.0, ring1, ring2, ring3
    error = EPS * (8.0 + 0.125 * n + 0.5 * osc.shape[1])
    drifting, place, creeps, crush = abs(now[DRIFT]) + par[SWAY], 0.0, 0.0, ring2
    if over:
        ring, ring1, ring2, ring3 = ringing(mode, z, over)
        most, sup1, sup2, sup3 = creeping(par, mode, z, work, over, 0.0)
        place, creeps, rush, crush = creep_sizes(par, mode, z, over)
        drifting, place, creeps, crush = drifting + rush, error * place, error * creeps, ring2 + crush
        sup1, sup2, sup3 = ring1 + sup1, ring2 + sup2, ring3 + sup3
    top, jerk = ring - free + most, par[JERK] + d * abs(pull) + sup3
    lasting = 2.0 / d if d > 0.0 else math.inf
    size = (
        error * abs(y0), error * drifting, error * abs(par[MEAN]), error * par[SWING], error * ring1, lasting,
        place, creeps,
    )  # fmt: skip
    rush, crush = error * (drifting + par[SWING] + ring1), error * (curve + crush)  # of the rate and the acceleration
    beat = par[REACH]
    for k in range(osc.shape[1]):
        beat -= osc[0, k]
    tau, y, v, a = 0.0, y0, now[GAP_RATE], now[ACCELERATION]
    ds, vs, df, first, second = 0.0, now[SMOOTH_RATE], 0.0, 0.0, 0.0
    noise = 0.0 if on_wall else size[0]
    evaluations, looks, slip, since, risen = 0, 0, 0.0, 0.0, 0.0
    low, high, behind = 0.0, math.inf, 0.0
    free_from, y_there, v_there, a_there, width = math.inf, 0.0, 0.0, 0.0, 0.0
    if 0.0 < guess < horizon:
        ds, vs, sa, first, second = smooth_and_drift(par, now, osc, guess)
        df, fv, fa, slip = elastic(par, mode, z, now, work, over, guess)
        evaluations += 1
        y_there, v_there, a_there = y0 + ds + df, vs + fv, sa + fa
        wrong = abs(y_there) + blur(size, guess, first, second)
        width = 2.0 * wrong / v_there
        # y grows from before to after its root …
        if v_there > 0.0 and v_there > rush + size[2] * first + (abs(a_there) + crush + jerk * width) * width:
            free_from = guess - below_since(wrong, vs - sup1, max(ds + top + wrong, 0.0), vs, up, width)
            if free_from > guess:
                free_from = math.inf
        ds, vs, df, first, second = 0.0, now[SMOOTH_RATE], 0.0, 0.0, 0.0
    elif begin > 0.0:
        for tries in range(9):  # the ripple of a finite number of modes may still lap at the wall
            tau = begin + tries * par[RIPPLE]
            if tau >= horizon:
                return NOTHING, horizon, 0.0, evaluations + looks, 0.0, 0.0
            ds, vs, sa, first, second = smooth_and_drift(par, now, osc, tau)
            df, fv, fa, slip = elastic(par, mode, z, now, work, over, tau)
            evaluations += 1
            y, v, a = y0 + ds + df, vs + fv, sa + fa
            noise = blur(size, tau, first, second)
            if y + noise < 0.0:
                break
            if v > 0.0 or tries == 8:  # the load pushes again: the bar is still, or back, on the wall
                return CONTACT, tau, max(v, 0.0), evaluations + looks, 0.0, slip
    while True:
        found = NOTHING
        # how far the gap is free by the smooth part with a bound of the elastic one …
        t, at, u1, u2 = tau, tau, y + noise, y0 + ds + top + noise
        for _ in range(200):
            step = reach(u2, vs, up)
            if n and step <= 0.0:
                step = reach(u1, vs + sup1, up)
            if at > TURN:  # … or, from afar, by the drift with a bound of all that oscillates …
                far = y0 + now[DRIFT] * first + par[MEAN] * second + beat + top + noise
                if far < 0.0:
                    step = max(step, reach(far, now[DRIFT] + pull * first, up - par[CURVE]))
            if not at + step > t:
                break
            gain = step
            t = at + step
            if math.inf > t >= free_from:
                found = CONTACT
                break
            if t >= horizon:
                return NOTHING, horizon, 0.0, evaluations + looks, 0.0, 0.0
            ds, vs, sa, first, second = smooth_and_drift(par, now, osc, t)
            at, looks = t, looks + 1
            noise = blur(size, t, first, second)
            u2 = y0 + ds + top + noise
            u1 = y0 + ds + df + sup1 * (t - tau) + noise
            if d * (t - risen) > 0.25:  # what is left of the drift's acceleration
                risen, left = t, pull * (1.0 - d * first)
                curve, up = par[CURVE] + abs(left), par[CURVE] + max(left, 0.0) + 4.0 * EPS * abs(pull)
            if vs > 0.0 and -2.0 * curve * u2 < vs * vs and (n == 0 or -u2 <= top or -u2 * curve < 1e-3 * vs * vs):
                break
            if n == 0 and gain < 1e-14 * t:
                break
            if par[MEAN] <= 0.0 and away(par, now, u2, t):
                return AWAY, t, 0.0, evaluations + looks, 0.0, 0.0
        if found == CONTACT:
            tau, y, v, a = guess, y_there, v_there, a_there
            low, high = (guess, guess + width) if y < 0.0 else (max(guess - width, 0.0), guess)
        if found == NOTHING:
            # … and by its own Taylor polynomial
            if evaluations > 1 or not t > tau:
                t = max(t, tau + reach_cubic(min(y + noise, 0.0), v, a, jerk, up + sup2))
            if t >= horizon:
                return NOTHING, horizon, 0.0, evaluations + looks, 0.0, 0.0
            stuck = not t > tau
            if stuck:
                t = tau + EPS * max(tau, 1e-300)
            behind, tau = tau, t
            if at != tau:
                ds, vs, sa, first, second = smooth_and_drift(par, now, osc, tau)
            df, fv, fa, slip = elastic(par, mode, z, now, work, over, tau)
            evaluations += 1
            y, v, a = y0 + ds + df, vs + fv, sa + fa
            noise = blur(size, tau, first, second)
            free_from = math.inf  # the phasors have moved on
            ahead, certain = math.inf, False
            if y >= 0.0 and v > 0.0:  # the bounds from before hold for the time before as well
                ahead = 2.0 * (y + noise) / v
                certain = v > rush + size[2] * first + (abs(a) + crush + jerk * ahead) * ahead
            if over or d * (tau - since) > 0.25:  # the bounds anew: damping has taken its part
                since, risen, left = tau, tau, pull * (1.0 - d * first)
                curve, up = par[CURVE] + abs(left), par[CURVE] + max(left, 0.0) + 4.0 * EPS * abs(pull)
                fade = math.exp(-0.5 * d * tau) * (1.0 + 1e-12)
                if over:
                    most, sup1, sup2, sup3 = creeping(par, mode, z, work, over, tau)
                    sup1, sup2, sup3 = sup1 + fade * ring1, sup2 + fade * ring2, sup3 + fade * ring3
                else:
                    sup1, sup2, sup3 = fade * ring1, fade * ring2, fade * ring3
                top = ring * fade - free + most
                jerk = par[JERK] + d * (abs(left) + 4.0 * EPS * abs(pull)) + sup3
            if y < 0.0 and v > 0.0:
                ahead = 2.0 * (noise - y) / v
                certain = v > rush + size[2] * first + (abs(a) + crush + jerk * ahead) * ahead
            if certain:  # y grows until it has surely passed 0
                found = CONTACT
                low, high = (tau, tau + ahead) if y < 0.0 else (max(tau - ahead, behind), tau)
            elif y > -noise or stuck:
                found, tau, y, v, a, low, high, slip, more = approach(
                    par, mode, z, now, osc, work, over, behind, tau, y, v, a, noise, size, jerk, horizon, slip
                )
                evaluations += more
                if found == GRAZE:
                    return GRAZE, tau, 0.0, evaluations + looks, math.inf, 0.0
                if found == NOTHING:
                    return NOTHING, horizon, 0.0, evaluations + looks, 0.0, 0.0
        if found == CONTACT:
            bend, h, settled = 0.0, 0.0, False  # y''', from the last two evaluations
            for i in range(60):
                root = math.sqrt(max(v * v - 2.0 * a * y, 0.0))
                h = -2.0 * y / (v + root) if v > 0.0 else math.inf  # to the root of the local parabola
                if low <= tau + h <= high:
                    close = h * h * jerk < 16.0 * EPS * v
                    near = abs(h) <= 4.0 * EPS * tau or abs(h * h * h) * (jerk + a * a / v) < EPS * min(tau, 8.0) * v
                    if close or (i and near):
                        tau, settled = tau + h, True
                        break
                    tau += h
                else:  # it would leave the two times between which y passes 0
                    h = 0.5 * (low + high) - tau
                    tau += h
                    if high - low <= 4.0 * EPS * high:
                        break
                before = a
                ds, vs, sa = smooth(par, now, osc, tau)
                df, fv, fa, slip = elastic(par, mode, z, now, work, over, tau)
                evaluations += 1
                y, v, a = y0 + ds + df, vs + fv, sa + fa
                bend = (a - before) / h if h != 0.0 else 0.0
                if y < 0.0:
                    low = tau
                else:
                    high = tau
            if tau > horizon:
                return NOTHING, horizon, 0.0, evaluations + looks, 0.0, 0.0
            if not settled:
                h = 0.0  # the last evaluation was made there
            speed = v + h * (a + 0.5 * h * bend)
            return CONTACT, tau, max(speed, 0.0), evaluations + looks, h, slip
        if evaluations + looks >= limit:
            return TIRED, tau, v, evaluations + looks, 0.0, 0.0


@njit(cache=True, nogil=True, error_model="numpy")
def approach(
    par, mode, z, now, osc, work, over, behind, tau, y, v, a, noise, size, jerk, horizon, slip
):  # fmt: skip
    """What becomes of a gap that is within its error of the wall while its rate does not decide.

    CONTACT, with two times between which the gap passes 0: it comes to more than its error. GRAZE, at its summit: it
    does not. NOTHING: neither before `horizon`. Followed by steps over which the third derivative takes no more than
    the error. Returns what was found, time, gap, rate and acceleration, the two times, `slip`, and the evaluations.
    """
    if v <= 0.0:
        return GRAZE, tau, y, v, a, behind, tau, slip, 0
    if y > noise:
        return CONTACT, tau, y, v, a, behind, tau, slip, 0
    low = tau if y < 0.0 else behind
    last, last_v, falls = math.inf, 0.0, False  # the rate is known to be 0 before `last`
    for i in range(200):
        if falls:  # between the two rates
            h = (last - tau) * min(max(v / (v - last_v), 0.1), 0.9)
        else:
            h = min((6.0 * noise / jerk) ** (1.0 / 3.0), -v / a if a < 0.0 else 2.0 * (abs(y) + noise) / v)
        t = min(tau + h, horizon)
        if not t > tau or (falls and not t < last):  # within the last digit of the time
            top = falls or -v > 4.0 * EPS * tau * a
            return (GRAZE if top else CONTACT), tau, y, v, a, low, tau, slip, i
        ds, vs, sa, first, second = smooth_and_drift(par, now, osc, t)
        df, fv, fa, slip = elastic(par, mode, z, now, work, over, t)
        y_t, v_t, a_t, noise = now[GAP] + ds + df, vs + fv, sa + fa, blur(size, t, first, second)
        if y_t > noise:
            return CONTACT, t, y_t, v_t, a_t, low, t, slip, i + 1
        if t >= horizon:
            return NOTHING, t, y_t, v_t, a_t, low, t, slip, i + 1
        if v_t <= 0.0:
            last, last_v, falls = t, v_t, True
            if (t - tau) * v < 0.1 * noise or y_t < -noise < y:
                return GRAZE, tau + (t - tau) * (v / (v - v_t)), y, v, a, low, t, slip, i + 1
        else:
            if y_t < 0.0:
                low = t
            if falls and (last - t) * v_t < 0.1 * noise:
                return GRAZE, t + (last - t) * (v_t / (v_t - last_v)), y_t, v_t, a_t, low, t, slip, i + 1
            tau, y, v, a = t, y_t, v_t, a_t
    return GRAZE, tau, y, v, a, low, tau, slip, 200


@njit(cache=True, nogil=True, error_model="numpy")
def away(par, now, u, tau):
    """Whether the bar has left for good: no later S can exceed `-top`, for a mean load that does not push."""
    first, _ = drift(par[D], tau)
    fade = 1.0 - par[D] * first
    speed = now[DRIFT] * fade + par[MEAN] * first  # of the drift, which only falls while the mean load pulls
    coming = 0.0
    if speed > 0.0:
        if par[D] == 0.0:
            if par[MEAN] == 0.0:
                return False
            coming = 0.5 * speed * speed / -par[MEAN]
        else:
            coming = speed / par[D]
    return u + coming + 2.0 * par[REACH] < 0.0


@njit(cache=True, nogil=True, error_model="numpy")
def release_phases(har, mean, bend, force, out):
    """Phases at which a Fourier series turns from push to pull, ascending, into `out`; returns how many there are.

    Stepped over with the bound of p'', like a flight; a touch of 0 within rounding is no pull.
    """
    if bend == 0.0:
        return 0
    t, found, least, pushed_at, blind = 0.0, 0, 64.0 * EPS * force, -1.0, 1e-9
    while t < TURN + 1e-6:
        p, rate = load_at(har, mean, math.cos(t), math.sin(t))
        if p > least:
            pushed_at = t
            t += max(reach(-p, -rate, bend), EPS * TURN)
        elif p < -least:
            if pushed_at >= 0.0 and found < out.shape[0]:
                low, high = pushed_at, t
                for _ in range(200):
                    middle = 0.5 * (low + high)
                    if load_at(har, mean, math.cos(middle), math.sin(middle))[0] > 0.0:
                        low = middle
                    else:
                        high = middle
                out[found] = high % TURN
                found += 1
            pushed_at = -1.0
            t += max(reach(p, rate, bend), EPS * TURN)
        else:
            t += blind
            blind *= 2.0
            continue
        blind = 1e-9
    return found


# -- moving the anchor ----------------------------------------------------------------------------------------------


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def turn_clock(now, count, tau):
    """The load phase after τ, in [0, 2π), and the load periods gone by."""
    phase = now[PHASE] + tau
    if phase >= TURN:
        turns = math.floor(phase / TURN)
        phase = (phase - turns * TURN) - turns * TURN_LOW
        if phase < 0.0:
            phase = 0.0
        elif phase >= TURN:
            phase -= TURN
            turns += 1.0
        count[PERIOD] += int(turns)
    now[PHASE] = phase
    now[SINE], now[COSINE] = sine_cosine(phase)


@njit(cache=True, nogil=True, error_model="numpy")
def set_phase(now, phase):
    """The phase put where it is known to be."""
    now[PHASE] = phase
    now[SINE], now[COSINE] = sine_cosine(phase)


@njit(cache=True, nogil=True, error_model="numpy", fastmath=SUMS)
def turn_modes(par, mode, z, work, over, tau, late, slip):
    """The amplitudes of the free motion at τ.

    `late`: how much earlier the phasors in `work` were computed; inf when there are none near. `slip`: what `phasors`
    returned then.
    """
    n, d = mode.shape[1], par[D]
    if n == 0:
        return
    if not abs(late) * mode[OMEGA, n - 1] + (mode[DELTA, over] * slip if over < n else 0.0) < SMALL:
        slip, late = phasors(par, mode, work, over, tau), 0.0
    fade, _ = fading(d, tau)
    for j in range(over):
        _, h, rate, left = creep(d, mode[SIGNED, j], mode[OMEGA, j], tau)
        work[ASIDE_RE, j] = z[0, j] * left + z[1, j] * h
        work[ASIDE_IM, j] = z[1, j] * rate - z[0, j] * (mode[OMEGA, j] * mode[OMEGA, j] * h)
    for j in range(n):
        x = mode[LAMBDA, j] * late - mode[DELTA, j] * slip
        xx = x * x
        c, s = fade + fade * (xx * (xx * (1.0 / 24.0) - 0.5)), fade * (x - x * (xx * (1.0 / 6.0)))
        er, ei = 1.0 + work[0, j], work[1, j]
        work[0, j] = er * c - ei * s
        work[1, j] = er * s + ei * c
    for j in range(n):
        zr, zi = z[0, j], z[1, j]
        z[0, j] = zr * work[0, j] - zi * work[1, j]
        z[1, j] = zr * work[1, j] + zi * work[0, j]
    for j in range(over):
        z[0, j], z[1, j] = work[ASIDE_RE, j], work[ASIDE_IM, j]


@njit(cache=True, nogil=True, error_model="numpy")
def advance(par, mode, z, now, osc, work, over, tau):
    """The anchor moved to τ under a constant load, without an impact; the clock is turned apart."""
    ds, vs, _ = smooth(par, now, osc, tau)
    df, fv, _, slip = elastic(par, mode, z, now, work, over, tau)
    now[RIGID_RATE] = drifted(par, now, tau)
    turn_modes(par, mode, z, work, over, tau, 0.0, slip)
    now[GAP] += ds + df
    now[GAP_RATE] = vs + fv


@njit(cache=True, nogil=True, error_model="numpy", fastmath=SUMS)
def forced_modes(coupling, work, c, s, order):
    """Displacement (order 0) or velocity (1) of every q_n under the harmonics, into `work`.

    `c`, `s`: cosine and sine of the load phase.
    """
    n = coupling.shape[2]
    for j in range(n):
        work[FORCED, j] = 0.0
    wr, wi = 1.0, 0.0
    for k in range(coupling.shape[0]):
        wr, wi = wr * c - wi * s, wr * s + wi * c
        if order == 0:
            for j in range(n):
                work[FORCED, j] += coupling[k, 0, j] * wr - coupling[k, 1, j] * wi
        else:
            er, ei = (k + 1) * wr, (k + 1) * wi
            for j in range(n):
                work[FORCED, j] -= coupling[k, 0, j] * ei + coupling[k, 1, j] * er


@njit(cache=True, nogil=True, error_model="numpy", fastmath=SUMS)
def kinetic_energy(par, mode, z, now, work, over):
    """½ ∫ u_t² dx, with the forced velocities in `work`."""
    d, total = par[D], 0.0
    for j in range(mode.shape[1]):
        rate = work[FORCED, j] - mode[LAMBDA, j] * z[1, j] - 0.5 * d * z[0, j]
        total += rate * rate * mode[OSCILLATES, j]
    for j in range(over):
        rate = work[FORCED, j] + z[1, j]
        total += rate * rate
    return 0.5 * now[RIGID_RATE] * now[RIGID_RATE] + 0.25 * total


@njit(cache=True, nogil=True, error_model="numpy", fastmath=SUMS)
def turn_over(par, mode, z, now, work, over):
    """The modal velocities times −R, with the forced ones in `work`; returns ½ ∫ u_t² dx before it."""
    d, r, total = par[D], par[R], 0.0
    for j in range(over):
        rate = work[FORCED, j] + z[1, j]
        total += rate * rate
        work[ASIDE_IM, j] = -r * z[1, j] - (1.0 + r) * work[FORCED, j]
    for j in range(mode.shape[1]):
        zr, zi, forced = z[0, j], z[1, j], work[FORCED, j]
        rate = forced - mode[LAMBDA, j] * zi - 0.5 * d * zr
        total += rate * rate * mode[OSCILLATES, j]
        z[1, j] = -r * zi - (1.0 + r) * mode[INVERSE, j] * (0.5 * d * zr - forced)
    for j in range(over):
        z[1, j] = work[ASIDE_IM, j]
    return 0.5 * now[RIGID_RATE] * now[RIGID_RATE] + 0.25 * total


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def impact(par, mode, coupling, z, now, work, over):
    """The velocity field turned over, u_t → −R u_t (B77 10), the displacements kept; the gap is set to 0."""
    if mode.shape[1]:
        forced_modes(coupling, work, now[COSINE], now[SINE], 1)
        now[KINETIC_ENERGY] = turn_over(par, mode, z, now, work, over)
        amplitudes(par, mode, z, now, over)
    else:
        now[KINETIC_ENERGY] = 0.5 * now[RIGID_RATE] * now[RIGID_RATE]
    now[RIGID_RATE] *= -par[R]
    now[GAP_RATE] *= -par[R]
    now[GAP] = 0.0


@njit(cache=True, nogil=True, error_model="numpy")
def undeformed(par, mode, coupling, z, now, work, over):
    """The bar at rest on the wall: all displacements and velocities 0, so that the free part is less the forced one."""
    d = par[D]
    forced_modes(coupling, work, now[COSINE], now[SINE], 0)
    for j in range(mode.shape[1]):
        z[0, j] = -work[FORCED, j] - par[MEAN] * mode[STATICS, j]
    forced_modes(coupling, work, now[COSINE], now[SINE], 1)
    for j in range(mode.shape[1]):
        if j < over:
            z[1, j] = -work[FORCED, j]
        else:
            z[1, j] = (work[FORCED, j] - 0.5 * d * z[0, j]) * mode[INVERSE, j]
    amplitudes(par, mode, z, now, over)
    now[GAP], now[GAP_RATE], now[RIGID_RATE] = 0.0, 0.0, 0.0


@njit(cache=True, nogil=True, error_model="numpy")
def place(par, mode, coupling, values, z, now, count, work, over, u, v, gap, phase, period, piece):
    """The anchor at a start: u_n and u_n', n = 0, 1, … (those left out are 0), the gap, the clock."""
    for i in range(NUMBERS):
        now[i] = 0.0
    for i in range(COUNTS):
        count[i] = 0
    d = par[D]
    if values.shape[0]:
        par[MEAN] = values[piece]
    count[PERIOD], count[PIECE] = period, piece
    set_phase(now, phase)
    still = v[0] == 0.0 and gap == 0.0
    rate = v[0]
    for j in range(mode.shape[1]):
        sign = 2.0 if j % 2 else -2.0
        z[0, j] = sign * u[j + 1] if j + 1 < u.shape[0] else 0.0
        z[1, j] = sign * v[j + 1] if j + 1 < v.shape[0] else 0.0
        still = still and z[0, j] == 0.0 and z[1, j] == 0.0
        rate += z[1, j]
    forced_modes(coupling, work, now[COSINE], now[SINE], 0)
    for j in range(mode.shape[1]):
        z[0, j] -= work[FORCED, j] + par[MEAN] * mode[STATICS, j]
    forced_modes(coupling, work, now[COSINE], now[SINE], 1)
    for j in range(mode.shape[1]):
        z[1, j] -= work[FORCED, j]
        if j >= over:
            z[1, j] = -mode[INVERSE, j] * (z[1, j] + 0.5 * d * z[0, j])
    now[GAP], now[GAP_RATE], now[RIGID_RATE], now[LAST_FLIGHT] = gap, rate, v[0], -1.0
    now[RELEASED] = -1.0
    amplitudes(par, mode, z, now, over)
    # undeformed, at rest and on the wall: released at once when the load pulls
    count[MODE] = RESTING if still else (ON_WALL if gap == 0.0 else FLYING)


@njit(cache=True, nogil=True, error_model="numpy")
def step_load(par, mode, z, now, count, over, breaks, values):
    """On to the next step of a piecewise constant load: the static shape jumps, so the free part jumps back."""
    piece = count[PIECE] + 1
    if piece == breaks.shape[0]:
        piece = 0
    old, new = par[MEAN], values[piece]
    for j in range(mode.shape[1]):
        jump = mode[STATICS, j] * (old - new)
        z[0, j] += jump
        if j >= over:
            z[1, j] -= 0.5 * par[D] * jump * mode[INVERSE, j]
    if breaks[piece] < now[PHASE]:
        count[PERIOD] += 1
    set_phase(now, breaks[piece])
    count[PIECE] = piece
    par[MEAN] = new
    amplitudes(par, mode, z, now, over)


@njit(cache=True, nogil=True, error_model="numpy")
def gone(par, mode, now, breaks, values):
    """Whether a bar under a load of steps has left for good; asked each time the first step begins.

    From period to period the mean of the bar moves by less and less when the load's mean does not push (d = 0), or by
    an amount that tends to a pull from one side (d > 0): once it has moved away in a period it moves away in all. Each
    step adds at most its static shape to the elastic amplitudes.
    """
    turn, mean, force, jumps = TURN, 0.0, 0.0, 0.0
    for i in range(values.shape[0]):
        length = (breaks[i + 1] if i + 1 < values.shape[0] else breaks[0] + TURN) - breaks[i]
        mean += values[i] * length
        force = max(force, abs(values[i]))
        jumps += abs(values[i] - values[i - 1])
    still, stiff = 0.0, 0.0
    for j in range(mode.shape[1]):
        still += mode[STATICS, j]
        stiff += abs(mode[STATICS, j])
    place = now[GAP] - now[FREE] - par[MEAN] * still
    before = now[LAST_PLACE]
    now[LAST_PLACE] = place
    if mean > 0.0 or before == 0.0:
        return False
    growth, later = 4.0 * jumps * stiff, 0.0
    if par[D] > 0.0 and mode.shape[1]:
        later = growth / -math.expm1(-min(0.5 * par[D], mode[OMEGA, 0] * mode[OMEGA, 0] / par[D]) * turn)
    if place - before + growth >= 0.0:
        if place - before >= 0.0 or par[D] == 0.0:
            return False
        growth = later
    swing = turn * (max(now[RIGID_RATE], 0.0) + 2.0 * force * turn)
    return place + swing + now[SUP] + force * stiff + growth < 0.0


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def to_break(now, count, breaks):
    """Time to the next step of the load."""
    if breaks.shape[0] == 0:
        return math.inf
    piece = count[PIECE] + 1
    if piece == breaks.shape[0]:
        ahead = breaks[0] - now[PHASE]
        return ahead if ahead >= 0.0 else ahead + TURN
    return max(breaks[piece] - now[PHASE], 0.0)


# -- chatter and rest -----------------------------------------------------------------------------------------------


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def chatter_left(par, now, osc, horizon):
    """Time until the impacts have piled up, theory §8.2, when that is certain and known to `CHATTER_ERROR`; else −1.

    Rebound speed w, acceleration P without damping, and its rate j: the flights 2w/P, 2Rw/P, … add up to
    T_0 = 2w/((1 − R)P), and to first order in j and d to T_0 (1 − d T_0/6 − j T_0/(3P)).
    """
    r, d, w = par[R], par[D], -now[GAP_RATE]
    push = now[ACCELERATION] - d * w
    if r >= 1.0 or r == 0.0 or push <= 0.0:  # without restitution the next impact is the last
        return -1.0
    left = 2.0 * w / ((1.0 - r) * push)
    if left > CHATTER_TIME or 2.0 * left > horizon:
        return -1.0
    drag = abs(par[MEAN] - d * now[DRIFT])
    known = (par[JERK] + d * (par[CURVE] + drag)) * left / push + d * left
    unknown = now[SUP3] * left / push
    if known + unknown > 0.1 or (known * known + unknown) * left > CHATTER_ERROR:
        return -1.0
    _, _, curve = smooth(par, now, osc, 0.0)
    rate = d * curve - d * (par[MEAN] - d * now[DRIFT])  # third derivative of S plus d times the second: no drift left
    for k in range(osc.shape[1]):
        n = k + 1.0
        rate += n * n * n * osc[1, k]
    return left * (1.0 - d * left / 6.0 - rate * left / (3.0 * push))


@njit(cache=True, nogil=True, error_model="numpy")
def all_energy(par, mode, coupling, z, now, work, over):
    """Kinetic and elastic energy of the bar at the anchor: ½ ∫ u_t² dx + ½ s² ∫ u_x² dx."""
    forced_modes(coupling, work, now[COSINE], now[SINE], 1)
    total = kinetic_energy(par, mode, z, now, work, over)
    forced_modes(coupling, work, now[COSINE], now[SINE], 0)
    for j in range(mode.shape[1]):
        q = mode[OMEGA, j] * (z[0, j] + work[FORCED, j] + par[MEAN] * mode[STATICS, j])
        total += 0.25 * q * q
    return total


@njit(cache=True, nogil=True, error_model="numpy")
def stays(par, har, now, count):
    """Whether a bar without rebound stays on the wall: pushed by the load or, bouncing in no time, by its own shape."""
    p, _ = load_at(har, par[MEAN], now[COSINE], now[SINE])
    struck = count[MODE] == ON_WALL
    return (struck and par[R] == 0.0 and p > 0.0) or now[ACCELERATION] >= 0.0


@njit(cache=True, nogil=True, error_model="numpy")
def pull_begins(par, har, now):
    """Time until a load that is 0 within rounding pulls; −1 when it pushes before, or stays 0 for a whole period."""
    t, blind, least = 0.0, 1e-9, 64.0 * EPS * par[FORCE]
    while t < TURN:
        t += blind
        blind *= 2.0
        s, c = sine_cosine(now[PHASE] + t)
        p, _ = load_at(har, par[MEAN], c, s)
        if abs(p) > least:
            return t if p < 0.0 else -1.0
    return -1.0


@njit(cache=True, nogil=True, error_model="numpy")
def pull_ahead(par, har, now, releases, values):
    """Time until the load pulls a resting bar off the wall, and the load phase then; −1 and now when it never does.

    `releases`: the phases at which the load begins to pull, ascending; for step loads the begin of those steps. A bar
    laid down within rounding after such a phase is released now and not a period later.
    """
    p, _ = load_at(har, par[MEAN], now[COSINE], now[SINE])
    least = 0.0 if values.shape[0] else 64.0 * EPS * par[FORCE]
    if p < -least:
        return 0.0, now[PHASE]
    wait, phase = -1.0, now[PHASE]
    if releases.shape[0]:
        wait, phase = releases[0] - now[PHASE] + TURN, releases[0]
        for i in range(releases.shape[0]):
            if releases[i] >= now[PHASE]:
                wait, phase = releases[i] - now[PHASE], releases[i]
                break
    if p <= least and least > 0.0:
        begins = pull_begins(par, har, now)
        if begins >= 0.0 and not 0.0 <= wait <= begins:
            return 0.0, now[PHASE]
    return wait, phase


@njit(cache=True, nogil=True, error_model="numpy")
def release_at(phase, releases):
    """A phase that is one of `releases`, to the last bit; −1 when it is none."""
    for i in range(releases.shape[0]):
        if releases[i] == phase:
            return phase
    return -1.0


@njit(cache=True, nogil=True, error_model="numpy")
def set_clock(par, now, count, breaks, values, phase):
    """The clock of a resting bar put to the next time of a load phase, with the step of the load that holds then.

    The phase is set as it is, so that each release at it is the same one to the last bit.
    """
    if phase < now[PHASE]:
        count[PERIOD] += 1
    set_phase(now, phase)
    if values.shape[0]:
        piece = values.shape[0] - 1
        for i in range(values.shape[0]):
            if breaks[i] <= phase:
                piece = i
        count[PIECE] = piece
        par[MEAN] = values[piece]


@njit(cache=True, nogil=True, error_model="numpy")
def first_pull(par, har, now):
    """A time from the release of a rigid bar on for which the load surely pulls: 0 when it jumps to a pull."""
    p, rate = load_at(har, par[MEAN], now[COSINE], now[SINE])
    if har.shape[1] == 0:
        return 0.0
    ahead = 0.5 * min(reach(min(p, 0.0), rate, par[BEND]), 1.0)
    if ahead < 1e-7:  # a zero of higher order
        ahead = 1e-7
        while ahead < 1.0 and p > -64.0 * EPS * par[FORCE]:
            ahead *= 2.0
            s, c = sine_cosine(now[PHASE] + ahead)
            p, rate = load_at(har, par[MEAN], c, s)
    return ahead


@njit(cache=True, nogil=True, error_model="numpy")
def pull_lasts(par, har, now, count, breaks, values):
    """Time from a release on until the load pushes again; inf when it never does.

    Up to then the end of the continuous bar only moves away from the wall: all that arrives there are pulls.
    """
    if values.shape[0]:
        ahead, piece = to_break(now, count, breaks), count[PIECE]
        for _ in range(values.shape[0]):
            piece = piece + 1 if piece + 1 < values.shape[0] else 0
            if values[piece] > 0.0:
                return ahead
            following = breaks[piece + 1] if piece + 1 < values.shape[0] else breaks[0] + TURN
            ahead += following - breaks[piece]
        return math.inf
    t, least = 0.0, 64.0 * EPS * par[FORCE]
    c, s = now[COSINE], now[SINE]
    while t < TURN and har.shape[1]:
        p, rate = load_at(har, par[MEAN], c, s)
        if p > least and t > 0.0:
            return t
        t += max(reach(min(p, 0.0), rate, par[BEND]), 1e-6)
        s, c = sine_cosine(now[PHASE] + t)
    return math.inf


# -- the record -----------------------------------------------------------------------------------------------------


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def record(kind, before, lost, z, now, count, numbers, wholes, states):
    """One event with the state after it, unless the record has no rows."""
    if numbers.shape[0] == 0:
        return
    i = count[EVENTS]
    count[EVENTS] += 1
    numbers[i, AT_PHASE] = now[PHASE]
    numbers[i, BEFORE] = before
    numbers[i, AFTER] = now[GAP_RATE]
    numbers[i, LOST] = lost
    numbers[i, KINETIC] = now[KINETIC_ENERGY] if kind == IMPACT else 0.0
    wholes[i, KIND] = kind
    wholes[i, AT_PERIOD] = count[PERIOD]
    wholes[i, RESOLVED] = count[RUN] if kind == CHATTER else 0
    wholes[i, IN_PIECE] = count[PIECE]
    if states.shape[0]:
        n = z.shape[1]
        states[i, STATE_GAP] = now[GAP]
        states[i, STATE_RIGID] = now[RIGID_RATE]
        for j in range(n):
            states[i, STATE_NUMBERS + j] = z[0, j]
            states[i, STATE_NUMBERS + n + j] = z[1, j]


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def remember(speed, z, now, count, anchor):
    """The state just after an impact, to be compared with later ones."""
    n = z.shape[1]
    anchor[0], anchor[1], anchor[2] = now[PHASE], speed, now[RIGID_RATE]
    for j in range(n):
        anchor[3 + j] = z[0, j]
        anchor[3 + n + j] = z[1, j]
    count[ANCHOR], count[ANCHOR_PERIOD] = count[IMPACTS], count[PERIOD]
    count[RESTS], count[CHATTERS] = 0, 0


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def returned(par, mode, speed, z, now, anchor, tolerance):
    """Whether the state is the remembered one, each number to `tolerance` of its scale."""
    turn = abs(now[PHASE] - anchor[0])
    if min(turn, TURN - turn) > tolerance:
        return False
    bound = tolerance * (par[FORCE] + abs(speed))
    if abs(speed - anchor[1]) > bound or abs(now[RIGID_RATE] - anchor[2]) > bound:
        return False
    n = z.shape[1]
    most = 0.0
    for j in range(n):
        off = max(abs(z[0, j] - anchor[3 + j]), abs(z[1, j] - anchor[3 + n + j]))
        most = max(most, off * (1.0 + mode[LAMBDA, j]))  # of displacements and of velocities
    return most <= bound


@njit(cache=True, nogil=True, error_model="numpy")
def apart(past, shift, first, last, scale):
    """Greatest distance of the impacts number `first` … `last` − 1 from those `shift` before, phases and speeds."""
    most, ring = 0.0, past.shape[1] - 1
    for i in range(first, last):
        a, b = i & ring, (i - shift) & ring
        turn = abs(past[0, a] - past[0, b])
        most = max(most, min(turn, TURN - turn), abs(past[1, a] - past[1, b]) / scale)
    return most


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def shortest(past, impacts, periods, seen, scale, tolerance):
    """The cycle of `impacts` impacts or, when a part of it comes back as well, that part; 0 when that is still open.

    A motion that settles with a negative multiplier comes back after two impacts before it does after one: the
    distance of a part that still shrinks, by more than 1e-4 of itself in a cycle, is waited for.
    """
    for part in range(1, impacts // 2 + 1):
        if impacts % part or (periods * part) % impacts or 2 * impacts + part > min(seen, past.shape[1]):
            continue
        now = apart(past, part, seen - impacts, seen, scale)
        if now <= tolerance:
            return part
        if abs(now - apart(past, part, seen - 2 * impacts, seen - impacts, scale)) > 1e-4 * now:
            return 0
    return impacts


@njit(cache=True, nogil=True, error_model="numpy")
def mark(now, count, sums):
    """The last release remembered, to be compared with later ones; at the first impact after it."""
    now[MARKED], now[LAID] = now[RELEASED], 0.0
    count[MARK], count[MARK_PERIOD] = count[IMPACTS], count[RELEASE_PERIOD]
    count[MARK_RELEASES], count[MARK_CHATTERS] = 0, 0
    if count[VERDICT] != SURE:
        for i in range(LAST_PERIOD):
            sums[MARKED_SUMS + i] += sums[i]
            sums[i] = 0.0


@njit(cache=True, nogil=True, error_model="numpy")
def sure(now, count, sums):
    """The cycle between two equal releases is one: the sums are those over it."""
    count[VERDICT], count[CONFIRMED] = SURE, 2
    for i in range(LAST_PERIOD):
        sums[MARKED_SUMS + i] = 0.0
    mark(now, count, sums)


@njit(cache=True, nogil=True, error_model="numpy")
def released_again(now, count, sums):
    """The search for a cycle among the releases, at the first impact after each: Brent's, as `recurrence`.

    A bar at rest leaves the wall undeformed and without speed, at a phase that is a number of the load: two releases at
    one phase are the same state, and the motion between them is a cycle. How many load periods it takes is known when
    rounding has not had a say in it: `verify` decides, unless the main blows are too few for errors to grow.
    """
    count[MARK_RELEASES] += 1
    if count[MARK] > 0 and now[RELEASED] == now[MARKED]:
        periods = count[RELEASE_PERIOD] - count[MARK_PERIOD]
        if count[VERDICT] <= TWIN:
            few = count[VERDICT] == UNSEEN and sums[STRUCK] <= FEW
            count[VERDICT], count[CONFIRMED], count[FOUND_AT] = ASKED, 0, count[MARK]
            count[CYCLE_IMPACTS], count[CYCLE_PERIODS] = count[IMPACTS] - count[MARK], periods
            count[CYCLE_KIND] = 2 if count[MARK_CHATTERS] else 1
            if few:
                sure(now, count, sums)
            return
        if count[VERDICT] == SURE:
            if periods == count[CYCLE_PERIODS]:
                count[CONFIRMED] += 1
            else:
                count[VERDICT], count[CONFIRMED], count[CYCLE_IMPACTS] = LOST_CYCLE, 0, 0
        mark(now, count, sums)
    elif count[MARK] == 0 or (count[MARK_RELEASES] >= count[MARK_PATIENCE] and count[VERDICT] <= TWIN):
        count[MARK_PATIENCE] = max(2 * count[MARK_PATIENCE], 1)
        mark(now, count, sums)


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def recurrence(par, mode, speed, fresh, z, now, count, anchor, past, sums, tolerance):
    """The search for a cycle, after each impact: Brent's, with the remembered state renewed at ever longer times.

    Each state is compared with the remembered one; a return gives a cycle of p impacts in n load periods, and is
    compared again from there on. Two returns with the same p and n confirm it. Where the bar rests, only the first
    impacts after a release (`fresh`) are compared: the last ones of a chatter are too much alike. A release at one of
    the phases where the load begins to pull is compared by that phase alone, see `released_again`.
    """
    since = count[IMPACTS] - count[ANCHOR]
    if fresh and now[RELEASED] >= 0.0:
        released_again(now, count, sums)
        if count[VERDICT] > TWIN:
            remember(speed, z, now, count, anchor)
        return
    if count[RESTS] > 0 and not fresh and since < 4 * count[PATIENCE]:
        return
    periods = count[PERIOD] - count[ANCHOR_PERIOD]
    if count[ANCHOR] > 0 and (fresh or count[RESTS] == 0) and returned(par, mode, speed, z, now, anchor, tolerance):
        ahead = now[PHASE] - anchor[0]
        if ahead < -math.pi:
            periods -= 1
        elif ahead > math.pi:
            periods += 1
        if periods > 0:
            cycle = since
            if count[RESTS] == 0:
                cycle = shortest(past, since, periods, count[IMPACTS], par[FORCE] + abs(speed), tolerance)
            if cycle == 0:
                count[CONFIRMED], count[CYCLE_IMPACTS] = 0, 0
            else:
                periods = periods * cycle // since
                if cycle == count[CYCLE_IMPACTS] and periods == count[CYCLE_PERIODS]:
                    count[CONFIRMED] += 1
                else:
                    count[CYCLE_IMPACTS], count[CYCLE_PERIODS], count[CONFIRMED] = cycle, periods, 1
                    count[FOUND_AT] = count[ANCHOR]
                    clear(sums)
            count[CYCLE_KIND] = 2 if count[CHATTERS] else (1 if count[RESTS] else 0)
            remember(speed, z, now, count, anchor)
            return
    if fresh and count[RESTS] == 1 and returned(par, mode, speed, z, now, anchor, SETTLING * tolerance):
        # nearly as one rest before: what settles from both sides in turn comes back after two rests before it does now
        count[CONFIRMED], count[CYCLE_IMPACTS] = 0, 0
        remember(speed, z, now, count, anchor)
        return
    if count[CONFIRMED] and since > count[CYCLE_IMPACTS]:
        count[CONFIRMED], count[CYCLE_IMPACTS] = 0, 0
    if count[ANCHOR] == 0 or since >= count[PATIENCE]:
        count[PATIENCE] = max(2 * count[PATIENCE], 1)
        remember(speed, z, now, count, anchor)


@njit(cache=True, nogil=True, error_model="numpy")
def wanders(past, impacts):
    """Whether no shift by up to `SHIFTS` impacts brings the last impacts back to `LOOSE`ly the same phases and speeds.

    `past`: phases, striking speeds and load periods of the last impacts, in a ring.
    """
    if impacts < SAME + SHIFTS:
        return False
    top, ring = 0.0, past.shape[1] - 1
    for i in range(impacts - SAME, impacts):
        top = max(top, abs(past[1, i & ring]))
    for shift in range(1, SHIFTS + 1):
        near = True
        for i in range(impacts - SAME, impacts):
            a, b = i & ring, (i - shift) & ring
            turn = abs(past[0, a] - past[0, b])
            if min(turn, TURN - turn) > LOOSE or abs(past[1, a] - past[1, b]) > LOOSE * top:
                near = False
                break
        if near:
            return False
    return True


# -- statistics -----------------------------------------------------------------------------------------------------

# sums: numbers of intervals, their sums and sums of squares, between all impacts, between main blows (a completed
# chatter is one blow, at its first impact), and of the sequence of ever shorter flights now open, with the striking
# speeds and kinetic energies of its impacts but the first …
ALL, ALL_TIME, ALL_SQUARES, MAIN, MAIN_TIME, MAIN_SQUARES = range(6)
OPEN, OPEN_TIME, OPEN_SQUARES, OPEN_SPEEDS, OPEN_BLOWS = range(6, 11)
OPENED = 5
# … the energy lost; of the main blows the sums of striking speeds and of kinetic energies, and their number …
TAKEN, SPEEDS, BLOWS, STRUCK = range(11, 15)
# … when the last impact and the last main blow came, whether that one ended in chatter, and whether there was one …
LAST_PERIOD, LAST_PHASE, MAIN_PERIOD, MAIN_PHASE, CHATTERED, BEGUN = range(15, 21)
# … and what the sums came to before the release that later ones are compared with: from there on they begin at 0
MARKED_SUMS = 21
SUMS_KEPT = MARKED_SUMS + LAST_PERIOD


@njit(cache=True, nogil=True, error_model="numpy")
def clear(sums):
    """The sums begun anew, now: at the first return of a cycle, and when the impacts to be discarded are over."""
    for i in range(LAST_PERIOD):
        sums[i] = sums[MARKED_SUMS + i] = 0.0


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def tally(speed, lost, now, count, sums):
    """An impact entered into the sums."""
    sums[TAKEN] += lost
    begun = sums[BEGUN] > 0.0
    gone = (count[PERIOD] - sums[LAST_PERIOD]) * TURN + (now[PHASE] - sums[LAST_PHASE])
    if begun:
        sums[ALL] += 1.0
        sums[ALL_TIME] += gone
        sums[ALL_SQUARES] += gone * gone
    if begun and count[RUN] > 1:
        sums[OPEN] += 1.0
        sums[OPEN_TIME] += gone
        sums[OPEN_SQUARES] += gone * gone
        sums[OPEN_SPEEDS] += speed
        sums[OPEN_BLOWS] += now[KINETIC_ENERGY]
    else:
        if begun:
            close_run(sums)
            if sums[CHATTERED] > 0.0:
                gone = (count[PERIOD] - sums[MAIN_PERIOD]) * TURN + (now[PHASE] - sums[MAIN_PHASE])
            sums[MAIN] += 1.0
            sums[MAIN_TIME] += gone
            sums[MAIN_SQUARES] += gone * gone
        sums[MAIN_PERIOD], sums[MAIN_PHASE], sums[CHATTERED] = count[PERIOD], now[PHASE], 0.0
        sums[SPEEDS] += speed
        sums[BLOWS] += now[KINETIC_ENERGY]
        sums[STRUCK] += 1.0
    sums[LAST_PERIOD], sums[LAST_PHASE], sums[BEGUN] = count[PERIOD], now[PHASE], 1.0


@njit(cache=True, nogil=True, error_model="numpy")
def close_run(sums):
    """The open sequence was no chatter: its impacts are main blows."""
    for i in range(3):
        sums[MAIN + i] += sums[OPEN + i]
    sums[SPEEDS] += sums[OPEN_SPEEDS]
    sums[BLOWS] += sums[OPEN_BLOWS]
    sums[STRUCK] += sums[OPEN]
    for i in range(OPENED):
        sums[OPEN + i] = 0.0


# -- the motion -----------------------------------------------------------------------------------------------------


@njit(cache=True, nogil=True, error_model="numpy")
def set_down(par, mode, coupling, z, now, count, sums, work, over, wait, numbers, wholes, states):
    """The bar comes to rest on the wall, after `wait` when chatter ends then: what motion and strain it has is lost."""
    lost = all_energy(par, mode, coupling, z, now, work, over)
    chatter = par[R] > 0.0 and (count[RUN] > 1 or wait > 0.0)  # without restitution there are finitely many impacts
    if wait > 0.0:
        turn_clock(now, count, wait)
    undeformed(par, mode, coupling, z, now, work, over)
    sums[TAKEN] += lost
    count[MODE] = RESTING
    now[LAID] += now[PHASE]
    if chatter:
        sums[CHATTERED] = 1.0
        for i in range(OPENED):
            sums[OPEN + i] = 0.0
        count[CHATTERS] += 1
        count[MARK_CHATTERS] += 1
        record(CHATTER, 0.0, lost, z, now, count, numbers, wholes, states)
        lost = 0.0
    count[RESTS] += 1
    record(REST, 0.0, lost, z, now, count, numbers, wholes, states)


@njit(cache=True, nogil=True, error_model="numpy")
def fly(
    par, mode, har, coupling, breaks, values, releases, over,
    z, now, count, anchor, past, sums,
    end_period, end_phase, most_impacts, until_cycle, tolerance, skip, budget,
    numbers, wholes, states, osc, work,
):  # fmt: skip
    """The motion from the anchor on, event after event, until a stop rule holds or the record is full.

    The anchor stays at the last event (or break of the load) when time ends, so that going on gives the same bits.
    """
    room = numbers.shape[0] - 4
    while True:
        if count[IMPACTS] >= most_impacts:
            return BY_IMPACTS
        if room > 0 and count[EVENTS] > room:
            return FULL
        if count[WORK] >= budget:
            return BY_WORK
        left = (end_period - count[PERIOD]) * TURN + (end_phase - now[PHASE])
        if count[MODE] == RESTING:
            wait, phase = pull_ahead(par, har, now, releases, values)
            if wait < 0.0:
                return AT_REST
            if wait >= left:
                return BY_TIME
            set_clock(par, now, count, breaks, values, phase)
            undeformed(par, mode, coupling, z, now, work, over)
            count[MODE], count[RUN] = ON_WALL, 0
            count[WORK] += 1
            if mode.shape[1]:
                now[HOLD] = max(pull_lasts(par, har, now, count, breaks, values), par[WAVE])
            else:
                now[HOLD] = first_pull(par, har, now)
            now[LAST_FLIGHT], now[SINCE] = -1.0, 0.0
            now[RELEASED] = release_at(phase, releases)
            count[RELEASE_PERIOD] = count[PERIOD]
            record(RELEASE, 0.0, 0.0, z, now, count, numbers, wholes, states)
            continue
        ahead = to_break(now, count, breaks)
        look(par, har, now, osc)
        found, tau, speed = NOTHING, 0.0, 0.0
        on_wall = count[MODE] == ON_WALL or count[MODE] == GRAZED
        if on_wall and now[HOLD] == 0.0:
            slow = NO_SPEED * (abs(now[DRIFT]) + par[RATE] + now[SUP1])
            if now[GAP_RATE] > slow:
                found, speed = CONTACT, now[GAP_RATE]
            elif now[GAP_RATE] >= -slow:
                if stays(par, har, now, count) or count[PILE] > 100:
                    set_down(par, mode, coupling, z, now, count, sums, work, over, 0.0, numbers, wholes, states)
                    continue
                now[GAP_RATE] = 0.0
            else:
                wait = chatter_left(par, now, osc, ahead)
                if wait >= left:
                    return BY_TIME
                if wait >= 0.0:
                    set_down(par, mode, coupling, z, now, count, sums, work, over, wait, numbers, wholes, states)
                    continue
        if found == NOTHING:
            if left <= 0.0:
                return BY_TIME
            horizon, guess = min(left, ahead), 0.0
            if count[MODE] == ON_WALL and now[LAST_FLIGHT] > 0.0 and now[HOLD] == 0.0:
                guess = like_flight(now, count, past)
            found, tau, speed, steps, late, slip = next_contact(
                par, mode, z, now, osc, work, over, on_wall, now[HOLD], guess, horizon, budget - count[WORK]
            )
            if found == NOTHING and left <= ahead:
                return BY_TIME if left < math.inf else DEPARTED  # nothing moved, so that going on gives the same bits
            count[WORK] += steps + 1
            if found == AWAY:
                found = NOTHING  # until the load's next step
                if breaks.shape[0] == 0 or left <= ahead:
                    return BY_TIME if left < math.inf else DEPARTED
            if found == TIRED:
                now[HOLD] = tau
                return BY_WORK
            if found == NOTHING:
                advance(par, mode, z, now, osc, work, over, ahead)
                step_load(par, mode, z, now, count, over, breaks, values)
                now[SINCE] += ahead
                count[MODE] = FLYING
                if now[HOLD] > 0.0:  # just released: not out of the wall's reach before the load pushes again
                    now[HOLD] = now[HOLD] - ahead if now[HOLD] - ahead > 1e-12 else 0.0
                    if now[HOLD] == 0.0 and now[GAP] >= 0.0:
                        now[GAP], count[MODE] = 0.0, ON_WALL
                if count[PIECE] == 0 and gone(par, mode, now, breaks, values):
                    return BY_TIME if left < math.inf else DEPARTED
                continue
            if found == GRAZE:  # the bar goes on from where it is, not from the wall
                ds, _, _ = smooth(par, now, osc, tau)
                df, _, _, _ = elastic(par, mode, z, now, work, over, tau)
                now[GAP] += ds + df
            if mode.shape[1] or found == GRAZE:
                rest = drifted(par, now, tau)
                turn_modes(par, mode, z, work, over, tau, late, slip)
                turn_clock(now, count, tau)
                now[RIGID_RATE] = rigid_rate(par, har, rest, now[COSINE], now[SINE])
            else:
                turn_clock(now, count, tau)
                now[RIGID_RATE] = speed
            if breaks.shape[0] and to_break(now, count, breaks) > ahead:
                set_phase(now, breaks[(count[PIECE] + 1) % breaks.shape[0]])  # rounded past the step
            now[SINCE] += tau
        now[HOLD], now[LAST_PLACE] = 0.0, 0.0
        count[MODE] = GRAZED if found == GRAZE else ON_WALL
        if found == GRAZE:
            amplitudes(par, mode, z, now, over)
            now[GAP_RATE] = 0.0
            count[PILE] = count[PILE] + 1 if tau < 4.0 * EPS else 0
            if count[PILE] > 100:
                now[HOLD], count[PILE] = 1e-8, 0
            record(GRAZING, 0.0, 0.0, z, now, count, numbers, wholes, states)
            continue
        now[GAP_RATE] = speed
        if count[RUN] == 1 and now[SINCE] < par[PUSHING]:  # here, as `strike` would count references to the arrays
            now[PUSHES] = push_left(har, par[MEAN], breaks, values, releases, now)
        strike(par, mode, coupling, z, now, count, anchor, past, sums, tolerance, skip, work, over,
               numbers, wholes, states)  # fmt: skip
        if count[VERDICT] == ASKED:
            return TO_VERIFY
        if until_cycle and count[CONFIRMED] >= 2:
            return PERIODIC


@njit(cache=True, nogil=True, error_model="numpy")
def push_left(har, mean, breaks, values, releases, now):
    """Time from the impact before this one until the load begins to pull; −1 when it pulled then already."""
    begin = now[PHASE] - now[SINCE]
    left = math.inf
    for i in range(releases.shape[0]):
        ahead = releases[i] - begin
        left = min(left, ahead - TURN * math.floor(ahead / TURN))
    if left < now[SINCE]:
        return left
    if values.shape[0]:
        begin -= TURN * math.floor(begin / TURN)
        piece = values.shape[0] - 1
        for i in range(values.shape[0]):
            if breaks[i] <= begin:
                piece = i
        return left if values[piece] >= 0.0 else -1.0
    s, c = sine_cosine(begin)
    p, _ = load_at(har, mean, c, s)
    return left if p >= 0.0 else -1.0


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def strike(
    par, mode, coupling, z, now, count, anchor, past, sums, tolerance, skip, work, over, numbers, wholes, states
):
    """One impact with all that is kept of it."""
    speed = now[GAP_RATE]
    impact(par, mode, coupling, z, now, work, over)
    lost = (1.0 - par[R] * par[R]) * now[KINETIC_ENERGY]
    fresh = now[LAST_FLIGHT] < 0.0
    if fresh:
        count[RUN], now[LAST_FLIGHT] = 1, math.inf
    else:
        if now[SINCE] < now[LAST_FLIGHT] and now[SINCE] < par[PUSHING]:
            now[PUSHES] -= now[SINCE]
            unfelt = mode.shape[1] > 0 and now[SINCE] < par[WAVE]  # a pull during the flight is not yet at the wall
            count[RUN] = count[RUN] + 1 if now[PUSHES] >= 0.0 or unfelt else 1
        else:
            count[RUN] = 1
        now[LAST_FLIGHT] = now[SINCE]
    count[PILE] = count[PILE] + 1 if now[SINCE] < 4.0 * EPS else 0
    now[SINCE] = 0.0
    count[IMPACTS] += 1
    tally(speed, lost, now, count, sums)
    if count[IMPACTS] == skip and count[CONFIRMED] == 0:
        if count[MARK] == 0:
            clear(sums)
        for j in range(LAST_PERIOD):
            sums[MARKED_SUMS + j] = -sums[j]  # those of the cycle that may have begun are kept
    i = (count[IMPACTS] - 1) & (past.shape[1] - 1)
    past[0, i], past[1, i], past[2, i] = now[PHASE], speed, count[PERIOD]
    record(IMPACT, speed, lost, z, now, count, numbers, wholes, states)
    if tolerance > 0.0:
        recurrence(par, mode, speed, fresh, z, now, count, anchor, past, sums, tolerance)


@njit(cache=True, nogil=True, error_model="numpy")
def verify(
    par, mode, har, coupling, breaks, values, releases, over, now, count, sums, until_cycle, tolerance,
    z, twin_now, twin_count, anchor, past, twin_sums, osc, work, none, nothing,
):  # fmt: skip
    """Whether the cycle between two equal releases is sure: its twin, with R and d changed by `NUDGE`, is the same.

    The twin begins with the same release; it must take as many load periods, and be laid down at the same phases to
    `LOOSE`. An error that grows by less than `LOOSE`/`NUDGE` from release to rest leaves of rounding a thousandth of
    that. `none` and `nothing` are empty records, the other arrays those of the twin. Returns how the motion ends with
    it: `PERIODIC`, `UNRESOLVED`, or `BY_WORK` when it is to go on.
    """
    d, r, mean = par[D], par[R], par[MEAN]
    par[D], par[R] = d + NUDGE, r * (1.0 - NUDGE)  # both slow the bar down
    for i in range(NUMBERS):
        twin_now[i] = 0.0
    for i in range(COUNTS):
        twin_count[i] = 0
    for i in range(anchor.shape[0]):
        anchor[i] = 0.0
    for i in range(SUMS_KEPT):
        twin_sums[i] = 0.0
    set_clock(par, twin_now, twin_count, breaks, values, now[MARKED])
    twin_now[LAST_FLIGHT], twin_count[MODE], twin_count[VERDICT] = -1.0, RESTING, TWIN
    code = fly(
        par, mode, har, coupling, breaks, values, releases, over, z, twin_now, twin_count, anchor, past, twin_sums,
        math.inf, 0.0, 2 * count[CYCLE_IMPACTS] + 256, False, tolerance, 0, 2 * count[WORK] + SLICE,
        none, nothing, none, osc, work,
    )  # fmt: skip
    par[D], par[R], par[MEAN] = d, r, mean
    apart = abs(twin_now[LAID] - now[LAID])
    apart = min(apart % TURN, TURN - apart % TURN)
    same = twin_count[CYCLE_PERIODS] == count[CYCLE_PERIODS] and twin_count[CYCLE_KIND] == count[CYCLE_KIND]
    if code == TO_VERIFY and same and apart < LOOSE:
        sure(now, count, sums)
        return PERIODIC if until_cycle and count[CONFIRMED] >= 2 else BY_WORK
    count[VERDICT], count[CYCLE_IMPACTS], count[CYCLE_PERIODS] = LOST_CYCLE, 0, 0
    if until_cycle:  # the means are those between the two releases
        for i in range(LAST_PERIOD):
            sums[MARKED_SUMS + i] = 0.0
    mark(now, count, sums)
    return UNRESOLVED if until_cycle else BY_WORK


# -- many motions ---------------------------------------------------------------------------------------------------

# columns of the whole numbers of a member, and of its means
ENDED, STRIKES, FIRST, PER_CYCLE, PERIODS, SORT, WANDERING = range(7)
MEMBER_COUNTS = 7
ENDED_AT, RATE_OF, MAIN_RATE, MEAN_INTERVAL, STD_INTERVAL, MEAN_MAIN, STD_MAIN, MEAN_SPEED, MEAN_BLOW, LOST_RATE = (
    range(10)
)
MEMBER_NUMBERS = 10


@njit(cache=True, nogil=True, error_model="numpy")
def spread(n, total, squares):
    """Mean and standard deviation from sums; NaN without any."""
    if n == 0.0:
        return math.nan, math.nan
    mean = total / n
    return mean, math.sqrt(max(squares / n - mean * mean, 0.0))


@njit(cache=True, nogil=True, error_model="numpy")
def conclude(now, count, past, sums, code, numbers, wholes):
    """What is kept of a member: how it ended, its cycle, and its means."""
    settled = count[CONFIRMED] >= 2
    if not (settled and count[CYCLE_KIND] == 2) and sums[CHATTERED] == 0.0:
        close_run(sums)
    for i in range(LAST_PERIOD):
        sums[i] += sums[MARKED_SUMS + i]
    mean, std = spread(sums[ALL], sums[ALL_TIME], sums[ALL_SQUARES])
    main, main_std = spread(sums[MAIN], sums[MAIN_TIME], sums[MAIN_SQUARES])
    numbers[ENDED_AT] = count[PERIOD] * TURN + now[PHASE]
    numbers[MEAN_INTERVAL], numbers[STD_INTERVAL] = mean, std
    numbers[MEAN_MAIN], numbers[STD_MAIN] = main, main_std
    numbers[RATE_OF], numbers[MAIN_RATE] = TURN / mean, TURN / main
    numbers[MEAN_SPEED], _ = spread(sums[STRUCK], sums[SPEEDS], 0.0)
    numbers[MEAN_BLOW], _ = spread(sums[STRUCK], sums[BLOWS], 0.0)
    numbers[LOST_RATE] = TURN * sums[TAKEN] / sums[ALL_TIME] if sums[ALL] > 0.0 else math.nan
    wholes[ENDED], wholes[STRIKES], wholes[FIRST] = code, count[IMPACTS], count[FOUND_AT] - 1 if settled else -1
    wholes[PER_CYCLE] = count[CYCLE_IMPACTS] if settled else 0
    wholes[PERIODS] = count[CYCLE_PERIODS] if settled else 0
    wholes[SORT] = count[CYCLE_KIND] if settled else 0
    wholes[WANDERING] = 1 if count[VERDICT] == LOST_CYCLE or wanders(past, count[IMPACTS]) else 0


@njit(cache=True, nogil=True, error_model="numpy")
def fly_many(
    par, mode, har, coupling, breaks, values, releases, over,
    displacement, velocity, gaps, periods, phases, pieces, ends, end_phases,
    most_impacts, until_cycle, tolerance, skip, budget, first, last, stopped,
    z, now, count, anchor, past, sums, osc, work, none, nothing,
    twin_z, twin_now, twin_count, twin_anchor, twin_past, twin_sums,
    numbers, wholes, tail,
):  # fmt: skip
    """Members `first` … `last` − 1, one after the other; `stopped` is looked at between them.

    `none` and `nothing` are empty records, the `twin_` arrays for `verify`. `tail`: phases, speeds and load periods of
    the last impacts of each.
    """
    for i in range(first, last):
        if stopped[0]:
            return i
        place(
            par, mode, coupling, values, z, now, count, work, over,
            displacement[i], velocity[i], gaps[i], phases[i], periods[i], pieces[i],
        )  # fmt: skip
        for j in range(anchor.shape[0]):
            anchor[j] = 0.0
        for j in range(SUMS_KEPT):
            sums[j] = 0.0
        code = BY_WORK
        while code == BY_WORK and count[WORK] < budget and not stopped[0]:
            code = fly(
                par, mode, har, coupling, breaks, values, releases, over, z, now, count, anchor, past, sums,
                ends[i], end_phases[i], most_impacts, until_cycle, tolerance, skip, min(count[WORK] + SLICE, budget),
                none, nothing, none, osc, work,
            )  # fmt: skip
            if code == TO_VERIFY:
                code = verify(
                    par, mode, har, coupling, breaks, values, releases, over, now, count, sums, until_cycle, tolerance,
                    twin_z, twin_now, twin_count, twin_anchor, twin_past, twin_sums, osc, work, none, nothing,
                )  # fmt: skip
        if stopped[0] and code == BY_WORK:
            return i
        conclude(now, count, past, sums, code, numbers[i], wholes[i])
        kept = tail.shape[2]
        for j in range(min(kept, count[IMPACTS])):
            at = (count[IMPACTS] - 1 - j) & (past.shape[1] - 1)
            for row in range(3):
                tail[i, row, kept - 1 - j] = past[row, at]
    return last
