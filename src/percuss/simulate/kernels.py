"""The flight of the bar, its next contact and its impact, compiled: plain functions of numbers and arrays.

Everything that is compiled stands in this one file: numba's cache does not see a change in another one. The functions
neither allocate nor raise and know no object, so that the same source can be compiled for another device.

The state at an instant, the *anchor* (theory §§2, 8). The gap function is y = u_0 + Σ q_n with q_n = 2(−1)ⁿ u_n, and
every q_n is a forced part, known for all times, and a free one. The free part of an oscillating mode is
e^{−dτ/2} Re z_n e^{iλ_nτ}, τ after the anchor; the lowest `over` modes, overdamped or close to it, keep the value and
(rate + d/2 · value) of their free part instead. With them go the gap y, its rate, and the velocity of the mean of the
bar. Increments since the anchor are summed, never positions, so that flights of 1e-9 are as exact as flights of 1.

What is proved (`next_contact`). Let S be the gap less the free elastic part f. S and S' are cheap and |S''| has a known
bound; |f|, |f'|, |f''|, |f'''| are bounded by sums of amplitudes. From each anchor the gap is below the least of

    S + sup|f|,    S + f + sup|f'| h,    y + y'h + y''h²/2 + sup|y'''| h³/6,

each of which is stepped over with the bound of its own curvature, and never past its first root. The contact itself is
accepted where y' exceeds what the curvature can take back before y has reached 0; the root is then unique and Newton's
method (Halley's form) converges to it. What rounding cannot decide is returned as a graze. A motion that nearly repeats
is spared the steps: the flight after a like impact is tried first, and the same bounds, taken forward from the anchor
and backward from there, must leave no time between them.
"""

import math

from numba import njit

# -- layout of the arrays that the functions share ------------------------------------------------------------------

# par: numbers of the system. Of the smooth part of the gap: bounds REACH of its oscillation, RATE, CURVE and JERK of
# the derivatives. FORCE: Σ|p_k|, the speed scale. BEND: bound of |p''|. WAVE: time of a wave through the bar;
# RIPPLE: half a period of the shortest one.
D, R, BASE, MEAN, REACH, RATE, CURVE, JERK, FORCE, BEND, WAVE, RIPPLE = range(12)
PARAMETERS = 12

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
NUMBERS = 21

# count: whole numbers of the anchor. RUN: impacts of the present sequence of ever shorter flights. PILE: those of them
# that come without any time between
PERIOD, PIECE, MODE, IMPACTS, RUN, PILE, EVENTS, WORK = range(8)
# … and of the search for a cycle, see `recurrence`
ANCHOR, ANCHOR_PERIOD, PATIENCE, RESTS, CHATTERS, CYCLE_IMPACTS, CYCLE_PERIODS, CYCLE_KIND, CONFIRMED, FOUND_AT = range(
    8, 18
)
COUNTS = 18

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
FULL, BY_IMPACTS, BY_TIME, AT_REST, PERIODIC, DEPARTED, BY_WORK = range(7)
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
def smooth(par, now, osc, tau):
    """S(τ) − S(0), S'(τ), S''(τ): the gap without the free elastic part."""
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
def damped_pair(d, square, omega, tau):
    """C and S of the free motion q = q(0) C + (q'(0) + d q(0)/2) S of a mode with λ² = `square` of either sign."""
    if square > 0.0:
        lam = math.sqrt(square)
        fade = math.exp(-0.5 * d * tau)
        return fade * math.cos(lam * tau), fade * math.sin(lam * tau) / lam
    kappa = math.sqrt(-square)
    fade = math.exp(-omega * omega / (0.5 * d + kappa) * tau)
    both = math.exp(-2.0 * kappa * tau)
    if kappa * tau < 1e-8:
        return fade * 0.5 * (1.0 + both), fade * tau
    return fade * 0.5 * (1.0 + both), fade * -math.expm1(-2.0 * kappa * tau) / (2.0 * kappa)


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
    """f(τ) − f(0), f'(τ), f''(τ) of the free elastic part, and what `phasors` returned; the phasors stay in `work`."""
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
        c, s = damped_pair(d, mode[SIGNED, j], mode[OMEGA, j], tau)
        q0, g0 = z[0, j], z[1, j]
        q = q0 * c + g0 * s
        g = g0 * c - mode[SIGNED, j] * q0 * s
        w = g - 0.5 * d * q
        y += q - q0
        v += w
        a += -d * w - mode[OMEGA, j] * mode[OMEGA, j] * q
    return y, v, a, slip


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
        # q and its derivatives obey one equation: |q| ≤ |q(0)| + (2/d)|q'(0) + d q(0)/2| for each of them
        square = mode[OMEGA, j] * mode[OMEGA, j]
        q = z[0, j]
        q1 = z[1, j] - 0.5 * d * q
        q2 = -d * q1 - square * q
        q3 = -d * q2 - square * q1
        q4 = -d * q3 - square * q2
        f += q
        curve += q2
        sup += abs(q) + abs(2.0 * q1 / d + q)
        sup1 += abs(q1) + abs(2.0 * q2 / d + q1)
        sup2 += abs(q2) + abs(2.0 * q3 / d + q2)
        sup3 += abs(q3) + abs(2.0 * q4 / d + q3)
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


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def next_contact(par, mode, z, now, osc, work, over, on_wall, begin, guess, horizon, limit):
    """The first contact after the anchor, or the proof that there is none before `horizon`.

    `begin` > 0: the flight up to there is known to be free. `guess` > 0: a time worth trying. Returns what was found,
    its time, the gap's rate there, the number of evaluations of the modal sum, how much later than the last one the
    contact is, and what `phasors` said.
    """
    n = mode.shape[1]
    y0, free = now[GAP], now[FREE]
    curve = par[CURVE] + abs(par[MEAN] - par[D] * now[DRIFT])
    up = par[CURVE] + max(par[MEAN] - par[D] * now[DRIFT], 0.0)
    jerk = par[JERK] + par[D] * abs(par[MEAN] - par[D] * now[DRIFT]) + now[SUP3]
    top = now[SUP] - free
    speed = abs(now[DRIFT]) + par[RATE] + now[SUP1]
    error = EPS * (8.0 + 0.125 * (n + osc.shape[1]))
    tau, y, v, a = 0.0, y0, now[GAP_RATE], now[ACCELERATION]
    ds, vs, df = 0.0, now[SMOOTH_RATE], 0.0
    noise = 0.0 if on_wall else error * abs(y0)
    evaluations, looks, slip = 0, 0, 0.0
    free_from, y_there, v_there, a_there = math.inf, 0.0, 0.0, 0.0
    if 0.0 < guess < horizon:
        ds, vs, sa = smooth(par, now, osc, guess)
        df, fv, fa, slip = elastic(par, mode, z, now, work, over, guess)
        evaluations += 1
        y_there, v_there, a_there = y0 + ds + df, vs + fv, sa + fa
        wrong = abs(y_there) + error * (abs(y0) + (speed + abs(par[MEAN]) * guess) * guess)
        ahead = 2.0 * wrong / v_there
        if v_there > 0.0 and v_there > (abs(a_there) + jerk * ahead) * ahead:  # y grows from before to after its root …
            free_from = guess - below_since(wrong, vs - now[SUP1], max(ds + top + wrong, 0.0), vs, up, ahead)
            if free_from > guess:
                free_from = math.inf
        ds, vs, df = 0.0, now[SMOOTH_RATE], 0.0
    elif begin > 0.0:
        for tries in range(9):  # the ripple of a finite number of modes may still lap at the wall
            tau = begin + tries * par[RIPPLE]
            if tau >= horizon:
                return NOTHING, horizon, 0.0, evaluations + looks, 0.0, 0.0
            ds, vs, sa = smooth(par, now, osc, tau)
            df, fv, fa, slip = elastic(par, mode, z, now, work, over, tau)
            evaluations += 1
            y, v, a = y0 + ds + df, vs + fv, sa + fa
            noise = error * (abs(y0) + (speed + abs(par[MEAN]) * tau) * tau)
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
                step = reach(u1, vs + now[SUP1], up)
            if not at + step > t:
                break
            gain = step
            t = at + step
            if math.inf > t >= free_from:
                found = CONTACT
                break
            if t >= horizon:
                return NOTHING, horizon, 0.0, evaluations + looks, 0.0, 0.0
            ds, vs, sa = smooth(par, now, osc, t)
            at, looks = t, looks + 1
            noise = error * (abs(y0) + (speed + abs(par[MEAN]) * t) * t)
            u2 = y0 + ds + top + noise
            u1 = y0 + ds + df + now[SUP1] * (t - tau) + noise
            if vs > 0.0 and -2.0 * curve * u2 < vs * vs and (n == 0 or -u2 <= top or -u2 * curve < 1e-3 * vs * vs):
                break
            if n == 0 and gain < 1e-14 * t:
                break
            if par[MEAN] <= 0.0 and away(par, now, u2, t):
                return AWAY, t, 0.0, evaluations + looks, 0.0, 0.0
        if found == CONTACT:
            tau, y, v, a = guess, y_there, v_there, a_there
        if found == NOTHING:
            # … and by its own Taylor polynomial
            if evaluations > 1 or not t > tau:
                t = max(t, tau + reach_cubic(min(y + noise, 0.0), v, a, jerk, up + now[SUP2]))
            if t >= horizon:
                return NOTHING, horizon, 0.0, evaluations + looks, 0.0, 0.0
            stuck = not t > tau
            if stuck:
                t = tau + EPS * max(tau, 1e-300)
            tau = t
            if at != tau:
                ds, vs, sa = smooth(par, now, osc, tau)
            df, fv, fa, slip = elastic(par, mode, z, now, work, over, tau)
            evaluations += 1
            y, v, a = y0 + ds + df, vs + fv, sa + fa
            noise = error * (abs(y0) + (speed + abs(par[MEAN]) * tau) * tau)
            free_from = math.inf  # the phasors have moved on
            if v > 0.0:
                ahead = 2.0 * (abs(y) + noise) / v
                if v > (abs(a) + jerk * ahead) * ahead:  # y grows until it has surely passed 0
                    found = CONTACT
            if found == NOTHING and (y > -noise or stuck):
                found, top = touch(tau, y, v, a, noise)
                if found == GRAZE:
                    found, top = (GRAZE, top) if top < horizon else (NOTHING, horizon)
                    return found, top, 0.0, evaluations + looks, math.inf, 0.0
        if found == CONTACT:
            bend, h, settled = 0.0, 0.0, False  # y''', from the last two evaluations
            for i in range(12):
                h = -2.0 * y / (v + math.sqrt(max(v * v - 2.0 * a * y, 0.0)))  # root of the local parabola
                tau = max(tau + h, 0.0)
                close = h * h * jerk < 16.0 * EPS * v
                if close or (i and (abs(h) <= 4.0 * EPS * tau or abs(h * h * h) * (jerk + a * a / v) < EPS * tau * v)):
                    settled = True
                    break
                before = a
                ds, vs, sa = smooth(par, now, osc, tau)
                df, fv, fa, slip = elastic(par, mode, z, now, work, over, tau)
                evaluations += 1
                y, v, a = y0 + ds + df, max(vs + fv, 1e-300), sa + fa
                bend = (a - before) / h if h != 0.0 else 0.0
            if tau > horizon:
                return NOTHING, horizon, 0.0, evaluations + looks, 0.0, 0.0
            if not settled:
                h = 0.0  # the last evaluation was made there
            return CONTACT, tau, v + h * (a + 0.5 * h * bend), evaluations + looks, h, slip
        if evaluations + looks >= limit:
            return TIRED, tau, v, evaluations + looks, 0.0, 0.0


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
def touch(tau, y, v, a, noise):
    """What to call a gap that is within its error of the wall while the rate does not decide; a graze with its time."""
    if v <= 0.0:
        return GRAZE, tau
    if a >= 0.0 or y - 0.5 * v * v / a > 2.0 * noise:
        return CONTACT, tau
    return GRAZE, tau - v / a


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
        c, s = damped_pair(d, mode[SIGNED, j], mode[OMEGA, j], tau)
        work[ASIDE_RE, j] = z[0, j] * c + z[1, j] * s
        work[ASIDE_IM, j] = z[1, j] * c - mode[SIGNED, j] * z[0, j] * s
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
        rate = work[FORCED, j] + z[1, j] - 0.5 * d * z[0, j]
        total += rate * rate
    return 0.5 * now[RIGID_RATE] * now[RIGID_RATE] + 0.25 * total


@njit(cache=True, nogil=True, error_model="numpy", fastmath=SUMS)
def turn_over(par, mode, z, now, work, over):
    """The modal velocities times −R, with the forced ones in `work`; returns ½ ∫ u_t² dx before it."""
    d, r, total = par[D], par[R], 0.0
    for j in range(over):
        rate = work[FORCED, j] + z[1, j] - 0.5 * d * z[0, j]
        total += rate * rate
        work[ASIDE_IM, j] = -r * z[1, j] + (1.0 + r) * (0.5 * d * z[0, j] - work[FORCED, j])
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
            z[1, j] = -work[FORCED, j] + 0.5 * d * z[0, j]
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
        z[1, j] += 0.5 * d * z[0, j] - work[FORCED, j]
        if j >= over:
            z[1, j] *= -mode[INVERSE, j]
    now[GAP], now[GAP_RATE], now[RIGID_RATE], now[LAST_FLIGHT] = gap, rate, v[0], -1.0
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
        if j < over:
            z[1, j] += 0.5 * par[D] * jump
        else:
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
    if r >= 1.0 or push <= 0.0:
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
def pull_ahead(par, har, now, releases, values):
    """Time until the load pulls a resting bar off the wall, and the load phase then; −1 and now when it never does.

    `releases`: the phases at which the load begins to pull, ascending; for step loads the begin of those steps.
    """
    p, _ = load_at(har, par[MEAN], now[COSINE], now[SINE])
    if p < (0.0 if values.shape[0] else -64.0 * EPS * par[FORCE]):
        return 0.0, now[PHASE]
    if releases.shape[0] == 0:
        return -1.0, now[PHASE]
    for i in range(releases.shape[0]):
        if releases[i] >= now[PHASE]:
            return releases[i] - now[PHASE], releases[i]
    return releases[0] - now[PHASE] + TURN, releases[0]


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
def pull_lasts(par, har, now, most):
    """Time from a release on, `most` at most, until a Fourier series pushes again."""
    if har.shape[1] == 0:
        return most
    t, least = 0.0, 64.0 * EPS * par[FORCE]
    c, s = now[COSINE], now[SINE]
    for _ in range(10000):
        p, rate = load_at(har, par[MEAN], c, s)
        if t >= most or (p > least and t > 0.0):
            return min(t, most)
        t += max(reach(min(p, 0.0), rate, par[BEND]), 1e-6)
        s, c = sine_cosine(now[PHASE] + t)
    return min(t, most)


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


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def recurrence(par, mode, speed, fresh, z, now, count, anchor, past, sums, tolerance):
    """The search for a cycle, after each impact: Brent's, with the remembered state renewed at ever longer times.

    Each state is compared with the remembered one; a return gives a cycle of p impacts in n load periods, and is
    compared again from there on. Two returns with the same p and n confirm it. Where the bar rests, only the first
    impacts after a release (`fresh`) are compared: the last ones of a chatter are too much alike.
    """
    since = count[IMPACTS] - count[ANCHOR]
    if count[RESTS] > 0 and not fresh and since < 4 * count[PATIENCE]:
        return
    periods = count[PERIOD] - count[ANCHOR_PERIOD]
    if count[ANCHOR] > 0 and returned(par, mode, speed, z, now, anchor, tolerance):
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
# chatter is one blow, at its first impact), and of the sequence of ever shorter flights now open …
ALL, ALL_TIME, ALL_SQUARES, MAIN, MAIN_TIME, MAIN_SQUARES, OPEN, OPEN_TIME, OPEN_SQUARES = range(9)
# … the energy lost, the sums of the striking speeds and of the kinetic energies, the number of impacts …
TAKEN, SPEEDS, BLOWS, STRUCK = range(9, 13)
# … when the last impact and the last main blow came, whether that one ended in chatter, and whether there was one
LAST_PERIOD, LAST_PHASE, MAIN_PERIOD, MAIN_PHASE, CHATTERED, BEGUN = range(13, 19)
SUMS_KEPT = 19


@njit(cache=True, nogil=True, error_model="numpy")
def clear(sums):
    """The sums begun anew, now: at the first return of a cycle, and when the impacts to be discarded are over."""
    for i in range(LAST_PERIOD):
        sums[i] = 0.0


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def tally(speed, lost, now, count, sums):
    """An impact entered into the sums."""
    sums[TAKEN] += lost
    sums[SPEEDS] += speed
    sums[BLOWS] += now[KINETIC_ENERGY]
    sums[STRUCK] += 1.0
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
    else:
        if begun:
            close_run(sums)
            if sums[CHATTERED] > 0.0:
                gone = (count[PERIOD] - sums[MAIN_PERIOD]) * TURN + (now[PHASE] - sums[MAIN_PHASE])
            sums[MAIN] += 1.0
            sums[MAIN_TIME] += gone
            sums[MAIN_SQUARES] += gone * gone
        sums[MAIN_PERIOD], sums[MAIN_PHASE], sums[CHATTERED] = count[PERIOD], now[PHASE], 0.0
    sums[LAST_PERIOD], sums[LAST_PHASE], sums[BEGUN] = count[PERIOD], now[PHASE], 1.0


@njit(cache=True, nogil=True, error_model="numpy")
def close_run(sums):
    """The open sequence was no chatter: its impacts are main blows."""
    for i in range(3):
        sums[MAIN + i] += sums[OPEN + i]
        sums[OPEN + i] = 0.0


# -- the motion -----------------------------------------------------------------------------------------------------


@njit(cache=True, nogil=True, error_model="numpy")
def set_down(par, mode, coupling, z, now, count, sums, work, over, wait, numbers, wholes, states):
    """The bar comes to rest on the wall, after `wait` when chatter ends then: what motion and strain it has is lost."""
    lost = all_energy(par, mode, coupling, z, now, work, over)
    if wait > 0.0:
        turn_clock(now, count, wait)
    undeformed(par, mode, coupling, z, now, work, over)
    sums[TAKEN] += lost
    count[MODE] = RESTING
    if count[RUN] > 1 or wait > 0.0:
        sums[CHATTERED], sums[OPEN], sums[OPEN_TIME], sums[OPEN_SQUARES] = 1.0, 0.0, 0.0, 0.0
        count[CHATTERS] += 1
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
            now[HOLD] = pull_lasts(par, har, now, par[WAVE]) if mode.shape[1] else first_pull(par, har, now)
            now[LAST_FLIGHT], now[SINCE] = -1.0, 0.0
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
                if now[HOLD] > 0.0:  # just released: not out of the wall's reach before the load may push again
                    now[HOLD] = max(now[HOLD] - ahead, 0.0) if par[MEAN] < 0.0 else 0.0
                    if now[HOLD] == 0.0 and now[GAP] >= 0.0:
                        now[GAP], count[MODE] = 0.0, ON_WALL
                if count[PIECE] == 0 and gone(par, mode, now, breaks, values):
                    return BY_TIME if left < math.inf else DEPARTED
                continue
            if mode.shape[1]:
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
            now[GAP], now[GAP_RATE] = 0.0, 0.0
            count[PILE] = count[PILE] + 1 if tau < 4.0 * EPS else 0
            if count[PILE] > 100:
                now[HOLD], count[PILE] = 1e-8, 0
            record(GRAZING, 0.0, 0.0, z, now, count, numbers, wholes, states)
            continue
        now[GAP_RATE] = speed
        strike(par, mode, coupling, z, now, count, anchor, past, sums, tolerance, skip, work, over,
               numbers, wholes, states)  # fmt: skip
        if until_cycle and count[CONFIRMED] >= 2:
            return PERIODIC


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
        count[RUN] = count[RUN] + 1 if now[SINCE] < now[LAST_FLIGHT] else 1
        now[LAST_FLIGHT] = now[SINCE]
    count[PILE] = count[PILE] + 1 if now[SINCE] < 4.0 * EPS else 0
    now[SINCE] = 0.0
    count[IMPACTS] += 1
    tally(speed, lost, now, count, sums)
    if count[IMPACTS] == skip and count[CONFIRMED] == 0:
        clear(sums)
    i = (count[IMPACTS] - 1) & (past.shape[1] - 1)
    past[0, i], past[1, i], past[2, i] = now[PHASE], speed, count[PERIOD]
    record(IMPACT, speed, lost, z, now, count, numbers, wholes, states)
    if tolerance > 0.0:
        recurrence(par, mode, speed, fresh, z, now, count, anchor, past, sums, tolerance)


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
    wholes[WANDERING] = 1 if wanders(past, count[IMPACTS]) else 0


@njit(cache=True, nogil=True, error_model="numpy")
def fly_many(
    par, mode, har, coupling, breaks, values, releases, over,
    displacement, velocity, gaps, periods, phases, pieces, ends, end_phases,
    most_impacts, until_cycle, tolerance, skip, budget, first, last, stopped,
    z, now, count, anchor, past, sums, osc, work, none, nothing,
    numbers, wholes, tail,
):  # fmt: skip
    """Members `first` … `last` − 1, one after the other; `stopped` is looked at between them.

    `none` and `nothing` are empty records. `tail`: phases, speeds and load periods of the last impacts of each.
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
        if stopped[0] and code == BY_WORK:
            return i
        conclude(now, count, past, sums, code, numbers[i], wholes[i])
        kept = tail.shape[2]
        for j in range(min(kept, count[IMPACTS])):
            at = (count[IMPACTS] - 1 - j) & (past.shape[1] - 1)
            for row in range(3):
                tail[i, row, kept - 1 - j] = past[row, at]
    return last
