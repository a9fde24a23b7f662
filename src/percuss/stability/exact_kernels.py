"""The largest multiplier of many orbits, compiled: plain functions of numbers and arrays.

The linearised map is block-diagonal plus rank one (`percuss.stability.linear_map`), so that its multipliers are the
roots of the secular function 1 + Σ w_j/(μ − ξ_j), with real poles ξ_j and residues w_j in closed form. A pole whose
residue is small beside the distance to its neighbours has one real root beside it, which Newton's method finds in two
or three steps; the others are found together by Ehrlich's and Aberth's method. The sum of all roots and the sum of
their squares must then be the trace of the map and of its square, which know nothing of poles: a root that was missed
or found twice would show there.
"""

import math

from percuss.simulate.kernels.compiled import entry, inner, summed

# rows of `bar`: Φ_n over the impact period, frequency, c_n, and exp(−dT/2)(1 − cos λT), for n = 0 … N
A, B, C, E, OMEGA, SIGN, VERSINE = range(7)
BAR_ROWS = 7
# `span`: T, d, exp(−dT), exp(−dT/2), and 1 less that
PERIOD, DAMPING, DECAY, HALF, LOSS = range(5)
SPAN_NUMBERS = 5
# rows of `work`, each of 2N + 2: poles and residues, roots, smallest steps so far; and g_n, g_n' (N + 1 of them)
POLE, RESIDUE, RE, IM, BEST, JUMP, JUMP_RATE = range(7)
WORK_ROWS = 7
# rows of `state`: roots still moving, and for how many sweeps their steps have not shrunk
STRONG, STALLED = range(2)
STATE_ROWS = 2

EPS = 2.0**-52
TURNED = 4.0 * EPS  # as in percuss.steady.impact_state
TRACE = 1e-11  # error of the sums of the roots and of their squares, relative
TIE = 1e-13  # moduli this near are one, as in percuss.stability.multipliers
OUT = 1e150  # where a pole or a root is put that is not to count
NEAR = 0.25  # a first step of at most this part of the distance to the next pole: a root beside its pole
SWEEPS = 100
SETTLED = 1e-12  # steps below this that no longer shrink are rounding


@summed
def jumps(r, mean, pull, forced, forced_rate, bar, span, work):
    """g_n and g_n' of the saltation matrix into `work`; returns the speed of the striking end before the impact.

    `mean`, `pull`: p_0 and p(φ) − p_0. `forced`, `forced_rate`: f_n less its static part, and f_n', n = 1 … N.
    """
    period, d, half, loss = span[PERIOD], span[DAMPING], span[HALF], span[LOSS]
    rigid = mean * period / (1.0 + r)
    work[JUMP, 0], work[JUMP_RATE, 0] = (1.0 + r) * rigid, -(1.0 + r) * (mean + pull)
    speed = rigid
    for n in range(1, bar.shape[1]):
        omega, b, versine = bar[OMEGA, n], bar[B, n], bar[VERSINE, n]
        divisor = loss * (1.0 + r * half) + (1.0 - r) * versine - (1.0 + r) * 0.5 * d * b  # det(I − DΦ)
        slack = TURNED * omega * period
        z, w = 0.0, 0.0
        if divisor > 2.0 * (1.0 - r) * slack * slack:
            z = -(1.0 + r) * forced_rate[n - 1] * b / divisor
            w = forced_rate[n - 1] * (loss * loss + 2.0 * versine) / divisor
        work[JUMP, n] = (1.0 + r) * w
        work[JUMP_RATE, n] = -(1.0 + r) * (pull - omega * omega * (forced[n - 1] + z))
        speed += bar[SIGN, n] * w
    return speed


@inner
def partial_fractions(r, decay, speed, bar, work):
    """Poles, ascending, and residues into `work`; returns how many, the trace and the trace of the square.

    See `LinearMap.partial_fractions` and the traces there.
    """
    trace, square, carried, mixed, count = 0.0, 0.0, 0.0, 0.0, 0
    for n in range(bar.shape[1]):
        a, b, c, e = bar[A, n], bar[B, n], bar[C, n], bar[E, n]
        g, h, sign = work[JUMP, n], work[JUMP_RATE, n], bar[SIGN, n] / speed
        middle = a - r * e
        root = math.sqrt(middle * middle + 4.0 * r * decay)
        large = 0.5 * (middle - root if middle < 0.0 else middle + root)
        small = -r * decay / large if large != 0.0 else 0.0
        gap = large - small if large != small else 1.0
        for pole, width in ((large, gap), (small, -gap)):
            residue = sign * ((r * decay + a * pole) * g + b * pole * h) / width
            at = count
            while at > 0 and work[POLE, at - 1] > pole:
                work[POLE, at], work[RESIDUE, at] = work[POLE, at - 1], work[RESIDUE, at - 1]
                at -= 1
            work[POLE, at], work[RESIDUE, at] = pole, residue
            count += 1
        up, turned = a * g + b * h, -r * (c * g + e * h)
        trace += middle
        square += a * a - 2.0 * r * b * c + r * r * e * e
        carried += sign * up
        mixed += sign * (a * up + b * turned)
    return count, trace - carried, square - 2.0 * mixed + carried * carried


@inner
def joined(count, work):
    """Equal poles taken together; those without residue, and all but one of equal ones, are roots already.

    Returns how many are left, in front; their roots are not known, those behind are.
    """
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


@summed
def real_sums(x, live, work):
    """Σ w/(x − ξ) and its derivative."""
    total, slope = 0.0, 0.0
    for j in range(live):
        inverse = 1.0 / (x - work[POLE, j])
        part = work[RESIDUE, j] * inverse
        total += part
        slope -= part * inverse
    return total, slope


@summed
def complex_sums(x, y, live, work):
    """Σ w/(z − ξ), its derivative, and Σ 1/(z − ξ) − Σ 1/(z − root), at z = x + iy; real and imaginary parts."""
    sr, si, dr, di, pr, pi = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for j in range(live):
        off = x - work[POLE, j]
        inverse = 1.0 / (off * off + y * y)
        a, b, w = off * inverse, y * inverse, work[RESIDUE, j]
        sr += w * a
        si -= w * b
        dr -= w * (a * a - b * b)
        di += w * (a * b)
        gap, rise = x - work[RE, j], y - work[IM, j]
        inverse = 1.0 / (gap * gap + rise * rise)
        pr += a - gap * inverse
        pi += rise * inverse - b
    return sr, si, dr, 2.0 * di, pr, pi


@inner
def beside_poles(live, work, state):
    """The real roots that lie beside their poles; returns the number of the others, listed in `state`.

    Its steps at least halve, so that it stays in the nearer half of the way to the next pole: no root is found twice.
    """
    strong = 0
    for j in range(live):
        pole, residue = work[POLE, j], work[RESIDUE, j]
        room = min(
            pole - work[POLE, j - 1] if j > 0 else math.inf, work[POLE, j + 1] - pole if j + 1 < live else math.inf
        )
        work[POLE, j], work[RESIDUE, j] = OUT, 0.0
        x, found, most = pole, False, NEAR * room
        for _ in range(12):
            others, slope = real_sums(x, live, work)
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
            # where it would stand alone, off the real axis so that pairs can part
            shift = -residue
            if abs(shift) <= 0.5 and abs(shift) > 0.6 * room:
                shift = math.copysign(0.6 * room, shift)
            tilt = 0.3 * min(abs(shift) + 1e-16, room)
            work[RE, j], work[IM, j] = pole + shift, tilt if j % 2 == 0 else -tilt
    return strong


@inner
def all_together(live, strong, work, state):
    """Ehrlich's and Aberth's method for the roots listed in `state`; whether all settled."""
    for i in range(strong):
        state[STALLED, i] = 0
        work[BEST, i] = math.inf
    for _ in range(SWEEPS):
        moving = 0
        for i in range(strong):
            if state[STALLED, i] < 0:
                continue
            j = state[STRONG, i]
            x, y, pole, residue = work[RE, j], work[IM, j], work[POLE, j], work[RESIDUE, j]
            work[POLE, j], work[RESIDUE, j], work[RE, j], work[IM, j] = OUT, 0.0, OUT, 0.0
            sr, si, dr, di, pr, pi = complex_sums(x, y, live, work)
            away = complex(x - pole, y)
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
            work[POLE, j], work[RESIDUE, j] = pole, residue
            work[RE, j], work[IM, j] = x - step.real, y - step.imag
            here = math.hypot(x, y)
            if size < 0.5 * work[BEST, i]:
                work[BEST, i] = size
                state[STALLED, i] = 0
            else:
                state[STALLED, i] += 1
            rounding = size < SETTLED * max(1.0, here) and state[STALLED, i] >= 2
            if rounding or size <= 4.0 * EPS * max(here, 1e-3 * abs(away)):
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


@inner
def foremost_mode(mu, r, bar, work):
    """The mode with the greatest share of energy in the eigenvector of a multiplier; see `LinearMap.shares`."""
    best, most = 0, -1.0
    for n in range(bar.shape[1]):
        a, b, c, e = bar[A, n], bar[B, n], bar[C, n], bar[E, n]
        g, h = work[JUMP, n], work[JUMP_RATE, n]
        determinant = abs((a - mu) * (-r * e - mu) + r * b * c)
        u, v = abs((-r * e - mu) * g - b * h), abs(r * c * g + (a - mu) * h)
        stiff = max(bar[OMEGA, n], 1.0) * u
        weight = (v * v + stiff * stiff) / (determinant * determinant + 1e-300)
        if weight > most:
            best, most = n, weight
    return best


@entry
def largest_multipliers(r, mean, pull, forced, forced_rate, bar, span, work, state, found, mode):
    """The multiplier of largest modulus of many orbits, and the mode that it belongs to.

    Parameters are arrays over the orbits, `forced` and `forced_rate` with N columns; see `jumps`. Results: real and
    imaginary part into the rows of `found`, and `mode`, which is −1 where the roots failed their check.
    """
    for i in range(r.shape[0]):
        mode[i] = -1
        found[0, i], found[1, i] = math.nan, math.nan
        speed = jumps(r[i], mean[i], pull[i], forced[i], forced_rate[i], bar, span, work)
        if not 0.0 < abs(speed) < math.inf:
            continue
        count, trace, square = partial_fractions(r[i], span[DECAY], speed, bar, work)
        if not abs(trace) + abs(square) < math.inf:
            continue
        live = joined(count, work)
        strong = beside_poles(live, work, state)
        if not all_together(live, strong, work, state) or not fits(count, trace, square, work):
            continue
        j = foremost(count, work)
        found[0, i], found[1, i] = work[RE, j], work[IM, j]
        mode[i] = foremost_mode(complex(work[RE, j], work[IM, j]), r[i], bar, work)
