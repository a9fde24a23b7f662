"""Roots of the secular function 1 + Σ w_j/(μ − ξ_j), compiled: plain functions of numbers and arrays.

A real pole whose residue is small beside the distance to its neighbours has one real root beside it, which Newton's
method finds in two or three steps; the others, and those of complex poles, are found together by Ehrlich's and Aberth's
method. The sum of all roots and the sum of their squares must then be the trace of the map and of its square, which
know nothing of poles: a root that was missed or found twice would show there.
"""

from __future__ import annotations

import math

from percuss.compiled import entry, inner, summed

# rows of `work`, each of 2N + 2: poles and residues, roots, smallest steps so far, imaginary parts of the poles and
# residues where they have some; and g_n, g_n' (N + 1 of them)
POLE, RESIDUE, RE, IM, BEST, POLE_IM, RESIDUE_IM, JUMP, JUMP_RATE = range(9)
WORK_ROWS = 9
# rows of `state`: roots still moving, and for how many sweeps their steps have not shrunk
STRONG, STALLED = range(2)
STATE_ROWS = 2

EPS = 2.0**-52
TRACE = 1e-11  # error of the sums of the roots and of their squares, relative
TIE = 1e-13  # moduli this near are one, as in percuss.steady.multipliers
OUT = 1e150  # where a pole or a root is put that is not to count
NEAR = 0.25  # a first step of at most this part of the distance to the next pole: a root beside its pole
SWEEPS = 400
MANY = 512  # poles from which on what the far ones add is interpolated
LEAF = 32  # poles that are taken one by one
NODES = 22  # of Chebyshev, to 5.8^−22 where no pole is nearer to an interval than its length
SETTLED = 1e-12  # steps below this that no longer shrink are rounding
LOOSE, PATIENCE = 1e-7, 12  # in a crowd larger ones, after so many sweeps


@inner
def joined(count, work):
    """Equal poles taken together; those without residue, and all but one of equal ones, are roots already."""
    # Returns how many are left, in front; their roots are not known, those behind are.
    scale = max(1.0, abs(work[POLE, 0]), abs(work[POLE, count - 1]))
    live, behind, i = 0, count, 0
    while i < count:
        pole, total, last = work[POLE, i], work[RESIDUE, i], work[POLE, i]
        i += 1
        while i < count and work[POLE, i] - last <= 4.0 * EPS * scale:
            last = work[POLE, i]
            total += work[RESIDUE, i]
            behind -= 1
            work[RE, behind], work[IM, behind] = last, 0.0
            i += 1
        if abs(total) > EPS * EPS * scale:
            work[POLE, live], work[RESIDUE, live] = pole, total
            live += 1
        else:
            behind -= 1
            work[RE, behind], work[IM, behind] = pole, 0.0
    return live


@inner
def joined_in_plane(count, work):
    """The same of complex poles, in any order."""
    scale = 1.0
    for i in range(count):
        scale = max(scale, abs(work[POLE, i]))
    width, live, behind = 4.0 * EPS * scale, 0, count
    for i in range(count):
        x, y, w, v = work[POLE, i], work[POLE_IM, i], work[RESIDUE, i], work[RESIDUE_IM, i]
        twin = -1
        for j in range(live):
            if abs(work[POLE, j] - x) <= width and abs(work[POLE_IM, j] - y) <= width:
                twin = j
                break
        if twin >= 0:
            work[RESIDUE, twin] += w
            work[RESIDUE_IM, twin] += v
            behind -= 1
            work[RE, behind], work[IM, behind] = x, y
        else:
            work[POLE, live], work[POLE_IM, live], work[RESIDUE, live], work[RESIDUE_IM, live] = x, y, w, v
            live += 1
    i = 0
    while i < live:  # those without residue: the last one takes their place
        if abs(work[RESIDUE, i]) + abs(work[RESIDUE_IM, i]) > EPS * EPS * scale:
            i += 1
            continue
        live -= 1
        behind -= 1
        work[RE, behind], work[IM, behind] = work[POLE, i], work[POLE_IM, i]
        work[POLE, i], work[POLE_IM, i] = work[POLE, live], work[POLE_IM, live]
        work[RESIDUE, i], work[RESIDUE_IM, i] = work[RESIDUE, live], work[RESIDUE_IM, live]
    return live


@summed
def real_sums(x, first, last, work):
    """Σ w/(x − ξ) over some poles, and its derivative."""
    total, slope = 0.0, 0.0
    for j in range(first, last):
        inverse = 1.0 / (x - work[POLE, j])
        part = work[RESIDUE, j] * inverse
        total += part
        slope -= part * inverse
    return total, slope


@summed
def sums_in_plane(x, y, live, work):
    """Σ w/(z − ξ), its derivative, and Σ 1/(z − ξ) − Σ 1/(z − root), at z = x + iy; real and imaginary parts."""
    sr, si, dr, di, pr, pi = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for j in range(live):
        off, up = x - work[POLE, j], y - work[POLE_IM, j]
        inverse = 1.0 / (off * off + up * up)
        a, b, w, v = off * inverse, up * inverse, work[RESIDUE, j], work[RESIDUE_IM, j]
        tr, ti = w * a + v * b, v * a - w * b  # residue/(z − pole)
        sr += tr
        si += ti
        dr -= tr * a + ti * b
        di -= ti * a - tr * b
        gap, rise = x - work[RE, j], y - work[IM, j]
        inverse = 1.0 / (gap * gap + rise * rise)
        pr += a - gap * inverse
        pi += rise * inverse - b
    return sr, si, dr, di, pr, pi


@inner
def beside_complex_poles(live, work, state):
    """First guesses beside complex poles, turned a little so that two of a pair can part; all are listed in `state`."""
    for j in range(live):
        state[STRONG, j] = j
        w, v = work[RESIDUE, j], work[RESIDUE_IM, j]
        work[RE, j] = work[POLE, j] - (w - 0.1 * v)
        work[IM, j] = work[POLE_IM, j] - (v + 0.1 * w)
    return live


# What many real poles add far from them is smooth. Intervals are halved until few poles are left in each; at each level
# the sum over the poles that are not near (nearer than the length of the interval), and its derivative, are known at
# nodes: interpolated from those of the interval that was halved, and added to by the poles that were near it and are
# near no more. So all sums take time in proportion to the poles, and to the levels. Ends and near poles of a level are
# in `state`, its middle, half length and sums in the row BEST of `work`, behind what the nodes have in common.

ENDS, FROM, UPTO = range(3)  # of a level in the row STALLED
LEVEL = 2 * NODES + 2


@inner
def halved(begin, end, level, live, work, state):
    """An interval of the poles `begin` … `end` − 1, as `level`, in that of the level above."""
    before = work[POLE, begin - 1] if begin else 2.0 * work[POLE, 0] - work[POLE, 1]
    after = work[POLE, end] if end < live else 2.0 * work[POLE, live - 1] - work[POLE, live - 2]
    left, right = 0.5 * (before + work[POLE, begin]), 0.5 * (work[POLE, end - 1] + after)
    first, last = state[STALLED, 3 * (level - 1) + FROM], state[STALLED, 3 * (level - 1) + UPTO]
    low, high = begin, end
    while low > first and work[POLE, low - 1] > 2.0 * left - right:
        low -= 1
    while high < last and work[POLE, high] < 2.0 * right - left:
        high += 1
    at, here, middle, half = level * LEVEL, 3 * level, 0.5 * (left + right), 0.5 * (right - left)
    work[BEST, at], work[BEST, at + 1] = middle, half
    state[STALLED, here + ENDS], state[STALLED, here + FROM], state[STALLED, here + UPTO] = end, low, high
    for k in range(NODES):
        x = middle + half * work[BEST, k]
        below, below_slope = real_sums(x, first, low, work)
        above, above_slope = real_sums(x, high, last, work)
        far, far_slope = far_sums(x, level - 1, work)
        work[BEST, at + 2 + k] = below + above + far
        work[BEST, at + 2 + NODES + k] = below_slope + above_slope + far_slope


@inner
def far_sums(x, level, work):
    """What the poles that are not near an interval add at a place in it, and the derivative, from its nodes."""
    if level == 0:
        return 0.0, 0.0
    at = level * LEVEL
    place = (x - work[BEST, at]) / work[BEST, at + 1]
    total, slope, weights = 0.0, 0.0, 0.0
    for k in range(NODES):
        off = place - work[BEST, k]
        weight = work[BEST, NODES + k] / (off if off != 0.0 else 1e-300)
        total += weight * work[BEST, at + 2 + k]
        slope += weight * work[BEST, at + 2 + NODES + k]
        weights += weight
    return total / weights, slope / weights


@inner
def beside_poles(live, work, state):
    """The real roots that lie beside their poles; returns the number of the others, listed in `state`."""
    if live <= MANY:
        return beside_some(0, live, 0, live, 0, 0, live, work, state)
    strong, begin, level, deepest = 0, 0, 0, work.shape[1] // LEVEL - 1
    for k in range(NODES):
        angle = (k + 0.5) * math.pi / NODES
        work[BEST, k], work[BEST, NODES + k] = math.cos(angle), math.sin(angle) * (1.0 if k % 2 == 0 else -1.0)
    state[STALLED, ENDS], state[STALLED, FROM], state[STALLED, UPTO] = live, 0, live
    while begin < live:
        end = state[STALLED, 3 * level + ENDS]
        while end - begin > LEAF and level < deepest:
            middle, low, high = 0.5 * (work[POLE, begin] + work[POLE, end - 1]), begin + 1, end - 1
            while low < high:
                between = (low + high) // 2
                if work[POLE, between] < middle:
                    low = between + 1
                else:
                    high = between
            level, end = level + 1, low
            halved(begin, end, level, live, work, state)
        first, last = state[STALLED, 3 * level + FROM], state[STALLED, 3 * level + UPTO]
        strong = beside_some(begin, end, first, last, level, strong, live, work, state)
        begin = end
        while level > 0 and state[STALLED, 3 * level + ENDS] <= begin:
            level -= 1
        if begin < live and level < deepest:
            level += 1
            halved(begin, state[STALLED, 3 * (level - 1) + ENDS], level, live, work, state)
    return strong


@inner
def beside_some(begin, end, first, last, level, strong, live, work, state):
    """The same of the poles `begin` … `end` − 1, an interval of `level`, to which `first` … `last` − 1 are near."""
    # Its steps at least halve, so that it stays in the nearer half of the way to the next pole: no root is found twice.
    for j in range(begin, end):
        pole, residue = work[POLE, j], work[RESIDUE, j]
        room = min(
            pole - work[POLE, j - 1] if j > 0 else math.inf, work[POLE, j + 1] - pole if j + 1 < live else math.inf
        )
        work[POLE, j], work[RESIDUE, j] = OUT, 0.0
        x, found, most = pole, False, NEAR * room
        for _ in range(12):
            others, slope = real_sums(x, first, last, work)
            if level > 0:
                far, far_slope = far_sums(x, level, work)
                others += far
                slope += far_slope
            away = x - pole
            step = (away * (1.0 + others) + residue) / (1.0 + others + away * slope)
            if not abs(step) <= most:
                break
            x -= step
            most = 0.5 * abs(step)
            if abs(step) <= 2.0 * EPS * max(abs(x), abs(pole)):
                found = True
                break
        work[POLE, j], work[RESIDUE, j] = pole, residue
        if found:
            work[RE, j], work[IM, j] = x, 0.0
        else:
            state[STRONG, strong] = j
            strong += 1
            # where it would stand alone but in the crowd, as in percuss.steady.multipliers
            shift = -residue
            if abs(shift) > 0.6 * room:
                shift = math.copysign(0.6 * room, shift)
            tilt = 0.3 * min(abs(shift) + 1e-16, room)
            work[RE, j], work[IM, j] = pole + shift, tilt if j % 2 == 0 else -tilt
    return strong


@inner
def all_together(live, strong, work, state):
    """Ehrlich's and Aberth's method for the roots in `state`; whether all settled."""
    for i in range(strong):
        state[STALLED, i] = 0
        work[BEST, i] = math.inf
    for _ in range(SWEEPS):
        moving = 0
        for i in range(strong):
            if state[STALLED, i] < 0:
                continue
            j = state[STRONG, i]
            x, y = work[RE, j], work[IM, j]
            pole, residue = complex(work[POLE, j], work[POLE_IM, j]), complex(work[RESIDUE, j], work[RESIDUE_IM, j])
            work[POLE, j], work[RESIDUE, j], work[RE, j], work[IM, j] = OUT, 0.0, OUT, 0.0
            work[RESIDUE_IM, j] = 0.0
            sr, si, dr, di, pr, pi = sums_in_plane(x, y, live, work)
            work[RESIDUE_IM, j] = residue.imag
            away = complex(x, y) - pole
            one, slope, pull = complex(1.0 + sr, si), complex(dr, di), complex(pr, pi)
            newton = (away * one + residue) / (one + away * slope)
            step = newton / (1.0 + newton * pull)
            size = abs(step)
            if not size < math.inf:
                step = 1e-3 * (abs(away) + abs(residue)) * complex(0.6, 0.8)
                size = abs(step)
            limit = 0.5 * abs(away) + abs(residue) + 0.05
            if size > limit:
                step *= limit / size
            work[POLE, j], work[RESIDUE, j] = pole.real, residue.real
            work[RE, j], work[IM, j] = x - step.real, y - step.imag
            here = math.hypot(x, y)
            if size < 0.5 * work[BEST, i]:
                work[BEST, i] = size
                state[STALLED, i] = 0
            else:
                state[STALLED, i] += 1
            rounding = size < SETTLED * max(1.0, here) and state[STALLED, i] >= 2
            if (
                rounding
                or (size < LOOSE and state[STALLED, i] >= PATIENCE)
                or size <= 4.0 * EPS * max(here, 1e-3 * abs(away))
            ):
                state[STALLED, i] = -1
            else:
                moving += 1
        if moving == 0:
            return True
    return False


@summed
def fits(count, trace, square, work):
    """Whether all roots add up to the trace of the map, and their squares to that of its square."""
    sr, si, qr, qi, largest = 0.0, 0.0, 0.0, 0.0, 0.0
    for j in range(count):
        x, y = work[RE, j], work[IM, j]
        sr += x
        si += y
        qr += x * x - y * y
        qi += 2.0 * x * y
        largest = max(largest, x * x + y * y)
    scale = max(1.0, math.sqrt(largest))
    room = TRACE * math.sqrt(count)
    first, second = math.hypot(sr - trace, si), math.hypot(qr - square, qi)
    return first <= room * scale and second <= room * scale * scale


@inner
def foremost(count, work):
    """Number of the root of largest modulus; of equal ones that with the larger real, the smaller imaginary part."""
    best, modulus = 0, math.hypot(work[RE, 0], work[IM, 0])
    for j in range(1, count):
        other = math.hypot(work[RE, j], work[IM, j])
        x, y = work[RE, j] - work[RE, best], work[IM, j] - work[IM, best]
        if other > modulus + TIE or (other > modulus - TIE and (x > TIE or (x > -TIE and y < 0.0))):
            best, modulus = j, other
    return best


# ---- The multipliers of a map, and the largest ones of many orbits
#
# The linearised map is block-diagonal plus rank one (`Orbit.linear_map`), so that its multipliers are the
# roots of det(M − μ)/det(DΦ − μ) = 1 + (1/W) Σ γ_n [(a_n g_n + b_n g_n') μ − β E_n g_n]/Q_n(μ), Q_n = det(D Φ_n − μ) =
# μ² − (α a_n + β e_n) μ + α β E_n: a secular function with poles and residues in closed form.

# rows of `bar`, for n = 0 … N: those of percuss.steady.multipliers.MapBlocks
A, B, C, E, DECAY, HALF, LOSS, DAMPING, OMEGA, GAMMA, VERSINE = range(11)

TURNED = 4.0 * 2.0**-52  # as in percuss.steady.oscillator
ASIDE = 2.0  # where a pole is put that stands in for one of the rigid motion


@summed
def jumps(beta, alpha, mean, pull, forced, forced_rate, bar, period, work):
    """g_n and g_n' of the saltation matrix into `work`; returns the speed of the striking end before the impact."""
    # `mean`, `pull`: p_0 and p(φ) − p_0. `forced`, `forced_rate`: f_n less its static part, and f_n', n = 1 … N. The
    # state before the impact solves (I − ΦD)(u, u') = (I − Φ)(f, f'), with D = diag(α, β) of the contact law.
    speed, bent, turning, impulse, apart = 0.0, 0.0, 1.0 - alpha, 1.0 - beta, alpha - beta
    for n in range(1, bar.shape[1]):
        omega, b, versine, half, loss = bar[OMEGA, n], bar[B, n], bar[VERSINE, n], bar[HALF, n], bar[LOSS, n]
        drag, square = 0.5 * bar[DAMPING, n] * b, omega * omega
        turned, rest = 1.0 - beta * half, turning + alpha * loss
        divisor = rest * turned + (alpha + beta) * versine - apart * drag  # det(I − DΦ)
        slack = TURNED * omega * period
        own, by_rate, w = 1.0, 0.0, 0.0
        if divisor > 2.0 * abs(alpha + beta) * slack * slack:
            own = (loss * turned + (1.0 + beta) * versine - impulse * drag) / divisor
            by_rate = -impulse * b / divisor
            w = forced_rate[n - 1] * (loss * rest + (1.0 + alpha) * versine + turning * drag)
            w = (w + turning * b * (square * forced[n - 1] + mean)) / divisor
        swing = own * forced[n - 1] + by_rate * forced_rate[n - 1]
        work[JUMP, n] = apart * w
        work[JUMP_RATE, n] = apart * square * swing - impulse * pull - mean * (impulse - apart * own)
        speed += bar[GAMMA, n] * w
        if turning != 0.0:
            bent += bar[GAMMA, n] * (swing + own * mean / square)
    # what the load gives in a period, less what drag takes as the bar returns to where the impact moves it from
    rigid = (mean * period + bar[DAMPING, 0] * turning * bent) / impulse
    work[JUMP, 0], work[JUMP_RATE, 0] = apart * rigid, -impulse * (mean + pull)
    return rigid + speed


@inner
def traces(beta, alpha, speed, bar, work):
    """The trace of M = B − g fᵀ/W and of its square, tr B² − 2 fᵀBg/W + (fᵀg/W)²; B = DΦ, f = Φᵀh."""
    trace, square, carried, mixed = 0.0, 0.0, 0.0, 0.0
    for n in range(bar.shape[1]):
        a, b, c, e = bar[A, n], bar[B, n], bar[C, n], bar[E, n]
        g, h, gamma = work[JUMP, n], work[JUMP_RATE, n], bar[GAMMA, n] / speed
        up, turned = a * g + b * h, beta * (c * g + e * h)
        trace += alpha * a + beta * e
        square += alpha * alpha * a * a + 2.0 * alpha * beta * b * c + beta * beta * e * e
        carried += gamma * up
        mixed += gamma * (alpha * a * up + b * turned)
    return trace - carried, square - 2.0 * mixed + carried * carried


@inner
def real_fractions(beta, alpha, speed, bar, work):
    """Poles, ascending, and residues into `work` where the law keeps strain, α > 0: all poles are real."""
    count = 0
    for n in range(bar.shape[1]):
        a, b, decay = bar[A, n], bar[B, n], bar[DECAY, n]
        g, h, gamma = work[JUMP, n], work[JUMP_RATE, n], bar[GAMMA, n] / speed
        middle = alpha * a + beta * bar[E, n]
        root = math.sqrt(middle * middle - 4.0 * alpha * beta * decay)
        large = 0.5 * (middle - root if middle < 0.0 else middle + root)
        small = alpha * beta * decay / large if large != 0.0 else 0.0
        gap = large - small if large != small else 1.0
        for pole, width in ((large, gap), (small, -gap)):
            work[POLE, count] = pole
            work[RESIDUE, count] = gamma * ((a * pole - beta * decay) * g + b * pole * h) / width
            count += 1
    step = 1 if count <= MANY else count // 2
    while step > 0:  # Shell's sorting; of few poles, by insertion
        for i in range(step, count):
            pole, residue, at = work[POLE, i], work[RESIDUE, i], i
            while at >= step and work[POLE, at - step] > pole:
                work[POLE, at], work[RESIDUE, at] = work[POLE, at - step], work[RESIDUE, at - step]
                at -= step
            work[POLE, at], work[RESIDUE, at] = pole, residue
        step = 1 if step == 2 else int(step / 2.25)
    return count


@inner
def complex_fractions(beta, alpha, speed, bar, work):
    """Poles and residues into `work` where the strain is turned over: β times the eigenvalues of Φ_n, many in pairs."""
    # Without drag both poles of the rigid motion are β then, and one is put elsewhere by the factor (μ − α)/(μ − 2): no
    # zero moves.
    others = 0.0
    for n in range(1, bar.shape[1]):
        a, b, e, decay = bar[A, n], bar[B, n], bar[E, n], bar[DECAY, n]
        g, h, gamma = work[JUMP, n], work[JUMP_RATE, n], bar[GAMMA, n] / speed
        slope, constant = gamma * (a * g + b * h), -gamma * beta * decay * g
        middle = 0.5 * (alpha * a + beta * e)
        square = 0.25 * (alpha * a - beta * e) ** 2 + alpha * beta * b * bar[C, n]
        half = complex(math.sqrt(square), 0.0) if square > 0.0 else complex(0.0, math.sqrt(-square))
        apart = abs(half) > 1e-150
        for i in range(2):
            pole = middle + half if i == 0 else middle - half
            residue = complex(slope if i == 0 else 0.0, 0.0)
            if apart:
                residue = (slope * pole + constant) / (2.0 * half if i == 0 else -2.0 * half)
            others += (residue / (ASIDE - pole)).real
            residue *= (pole - alpha) / (pole - ASIDE)
            at = 2 * n + i
            work[POLE, at], work[POLE_IM, at] = pole.real, pole.imag
            work[RESIDUE, at], work[RESIDUE_IM, at] = residue.real, residue.imag
    drag, gamma = beta * bar[DECAY, 0], bar[GAMMA, 0] / speed
    slope = gamma * (bar[A, 0] * work[JUMP, 0] + bar[B, 0] * work[JUMP_RATE, 0])
    constant = -gamma * drag * work[JUMP, 0]
    work[POLE, 0], work[POLE, 1] = ASIDE, drag
    work[RESIDUE, 0] = (ASIDE - alpha) * (1.0 + others) + (slope * ASIDE + constant) / (ASIDE - drag)
    work[RESIDUE, 1] = (slope * drag + constant) / (drag - ASIDE)
    for at in range(2):
        work[POLE_IM, at], work[RESIDUE_IM, at] = 0.0, 0.0
    return 2 * bar.shape[1]


@inner
def foremost_mode(mu, beta, alpha, bar, work):
    """The mode with the greatest share of energy in the eigenvector of a multiplier; see `LinearMap.shares`."""
    best, most = 0, -1.0
    for n in range(bar.shape[1]):
        a, b, c, e = bar[A, n], bar[B, n], bar[C, n], bar[E, n]
        g, h = work[JUMP, n], work[JUMP_RATE, n]
        determinant = abs((alpha * a - mu) * (beta * e - mu) - alpha * beta * b * c)
        u, v = abs((beta * e - mu) * g - alpha * b * h), abs((alpha * a - mu) * h - beta * c * g)
        stiff = max(bar[OMEGA, n], 1.0) * u
        counted = 0.5 * abs(bar[GAMMA, n]) if n else 1.0
        weight = counted * (v * v + stiff * stiff) / (determinant * determinant + 1e-300)
        if weight > most:
            best, most = n, weight
    return best


@inner
def solved(beta, alpha, speed, bar, work, state):
    """All multipliers into `work`, from g_n and g_n' there; their number, or 0 where they failed their check."""
    trace, square = traces(beta, alpha, speed, bar, work)
    if not abs(trace) + abs(square) < math.inf:
        return 0
    flat = alpha > 0.0
    if flat:
        count = real_fractions(beta, alpha, speed, bar, work)
        live = joined(count, work)
        strong = beside_poles(live, work, state)
    else:
        count = complex_fractions(beta, alpha, speed, bar, work)
        live = joined_in_plane(count, work)
        strong = beside_complex_poles(live, work, state)
    return count if all_together(live, strong, work, state) and fits(count, trace, square, work) else 0


@entry
def all_multipliers(beta, alpha, speed, bar, work, state):
    """All multipliers of one map, into the rows RE and IM of `work`; their number, or 0."""
    return solved(beta, alpha, speed, bar, work, state)


@entry
def largest_multipliers(beta, alpha, mean, pull, forced, forced_rate, bar, period, work, state, found, mode):
    """The multiplier of largest modulus of many orbits, and the mode that it belongs to."""
    # Parameters are arrays over the orbits, β and α those of their contact laws, `forced` and `forced_rate` with N
    # columns; see `jumps`. Results: real and imaginary part into the rows of `found`, and `mode`, which is −1 where the
    # roots failed their check.
    for i in range(beta.shape[0]):
        mode[i] = -1
        found[0, i], found[1, i] = math.nan, math.nan
        speed = jumps(beta[i], alpha[i], mean[i], pull[i], forced[i], forced_rate[i], bar, period, work)
        if not 0.0 < abs(speed) < math.inf:
            continue
        count = solved(beta[i], alpha[i], speed, bar, work, state)
        if count == 0:
            continue
        j = foremost(count, work)
        found[0, i], found[1, i] = work[RE, j], work[IM, j]
        mode[i] = foremost_mode(complex(work[RE, j], work[IM, j]), beta[i], alpha[i], bar, work)
