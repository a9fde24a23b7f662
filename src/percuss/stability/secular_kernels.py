"""Roots of the secular function 1 + Σ w_j/(μ − ξ_j), compiled: plain functions of numbers and arrays.

A real pole whose residue is small beside the distance to its neighbours has one real root beside it, which Newton's
method finds in two or three steps; the others, and those of complex poles, are found together by Ehrlich's and Aberth's
method. The sum of all roots and the sum of their squares must then be the trace of the map and of its square, which
know nothing of poles: a root that was missed or found twice would show there.
"""

import math

from percuss.compiled import inner, summed

# rows of `work`, each of 2N + 2: poles and residues, roots, smallest steps so far, imaginary parts of the poles and
# residues where they have some; and g_n, g_n' (N + 1 of them)
POLE, RESIDUE, RE, IM, BEST, POLE_IM, RESIDUE_IM, JUMP, JUMP_RATE = range(9)
WORK_ROWS = 9
# rows of `state`: roots still moving, and for how many sweeps their steps have not shrunk
STRONG, STALLED = range(2)
STATE_ROWS = 2

EPS = 2.0**-52
TRACE = 1e-11  # error of the sums of the roots and of their squares, relative
TIE = 1e-13  # moduli this near are one, as in percuss.stability.multipliers
OUT = 1e150  # where a pole or a root is put that is not to count
NEAR = 0.25  # a first step of at most this part of the distance to the next pole: a root beside its pole
SWEEPS = 100
SETTLED = 1e-12  # steps below this that no longer shrink are rounding


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


@summed
def sums_in_plane(x, y, live, work):
    """The same where poles and residues are complex."""
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
            # where it would stand alone but in the crowd, as in percuss.stability.secular
            shift = -residue
            if abs(shift) > 0.6 * room:
                shift = math.copysign(0.6 * room, shift)
            tilt = 0.3 * min(abs(shift) + 1e-16, room)
            work[RE, j], work[IM, j] = pole + shift, tilt if j % 2 == 0 else -tilt
    return strong


@inner
def all_together(live, strong, flat, work, state):
    """Ehrlich's and Aberth's method for the roots in `state`; whether all settled. `flat`: all poles are real."""
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
            if flat:
                sr, si, dr, di, pr, pi = complex_sums(x, y, live, work)
            else:
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
