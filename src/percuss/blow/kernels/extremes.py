"""The greatest force in a section: f that left one end at s meets g that left the other at r if |s − r| ≤ τ.

N = Z (f(s) − g(r)), at the time (s + r + τ)/2, which is in the window; so the greatest N is that of all pairs.
"""

from __future__ import annotations

from percuss.blow.kernels.chebyshev import value
from percuss.blow.kernels.sums import part, piece_end
from percuss.compiled import entry, inner

SAMPLES = 65  # of a polynomial, between which a maximum is bracketed
GOLDEN = 0.6180339887498949


@inner
def _refined(c, n, d, m, a, b, e, g, low, high):
    """The greatest p(a + b x) − q(e + g x) for x from low to high, where it has one maximum; x."""
    x, y = high - GOLDEN * (high - low), low + GOLDEN * (high - low)
    fx = value(c, n, a + b * x) - value(d, m, e + g * x)
    fy = value(c, n, a + b * y) - value(d, m, e + g * y)
    for _ in range(44):
        if fx > fy:
            high, y, fy = y, x, fx
            x = high - GOLDEN * (high - low)
            fx = value(c, n, a + b * x) - value(d, m, e + g * x)
        else:
            low, x, fx = x, y, fy
            y = low + GOLDEN * (high - low)
            fy = value(c, n, a + b * y) - value(d, m, e + g * y)
    return 0.5 * (low + high)


@inner
def _along(c, n, d, m, a, b, e, g):
    """The greatest p(a + b x) − q(e + g x) for x in [−1, 1], and x."""
    best, at = -1e300, -1.0
    two, one, before = -1e300, -1e300, -1.0
    step = 2.0 / (SAMPLES - 1)
    for k in range(SAMPLES + 1):
        x = -1.0 + step * k
        now = -1e300
        if k < SAMPLES:
            now = value(c, n, a + b * x) - value(d, m, e + g * x)
            if now > best:
                best, at = now, x
        if k >= 2 and one >= two and one >= now and n + m > 0:
            top = _refined(c, n, d, m, a, b, e, g, before - step, min(1.0, x))
            found = value(c, n, a + b * top) - value(d, m, e + g * top)
            if found > best:
                best, at = found, top
        two, one, before = one, now, x
    return best, at


@entry
def piece_extremes(waves, row, found, work):
    """The greatest and the least value of each piece of a row, found[0] and found[1], and where in [−1, 1]."""
    c, zero, minus = work[6], work[7], work[8]
    zero[0] = 0.0
    for k in range(waves.pieces[row]):
        n = part(waves, row, k, waves.start[row, k], piece_end(waves, row, k), c, work)
        found[0, k] = found[1, k] = c[0]
        found[2, k] = found[3, k] = 0.0
        if n > 0:
            found[0, k], found[2, k] = _along(c, n, zero, 0, 0.0, 1.0, 0.0, 0.0)
            for j in range(n + 1):
                minus[j] = -c[j]
            least, found[3, k] = _along(minus, n, zero, 0, 0.0, 1.0, 0.0, 0.0)
            found[1, k] = -least


@inner
def _clipped(polygon, n, a, b, most, out):
    """A polygon of points (s, r) cut to a s + b r ≤ most; its number of corners."""
    count = 0
    for i in range(n):
        s, r = polygon[0, i], polygon[1, i]
        j = i + 1 if i + 1 < n else 0
        t, u = polygon[0, j], polygon[1, j]
        here, there = a * s + b * r - most, a * t + b * u - most
        if here <= 0.0:
            out[0, count], out[1, count] = s, r
            count += 1
        if (here < 0.0 < there) or (there < 0.0 < here):
            share = here / (here - there)
            out[0, count], out[1, count] = s + share * (t - s), r + share * (u - r)
            count += 1
    return count


@inner
def overlap(s1, s2, r1, r2, transit, end, work):
    """Corners of the pairs from two pieces that meet within the window, in work[12:14]; how many."""
    here, there = work[10:12], work[12:14]
    here[0, 0], here[1, 0], here[0, 1], here[1, 1] = s1, r1, s2, r1
    here[0, 2], here[1, 2], here[0, 3], here[1, 3] = s2, r2, s1, r2
    n = _clipped(here, 4, 1.0, -1.0, transit, there)
    n = _clipped(there, n, -1.0, 1.0, transit, here)
    n = _clipped(here, n, -1.0, -1.0, transit, there)
    n = _clipped(there, n, 1.0, 1.0, 2.0 * end - transit, here)
    for i in range(n):
        there[0, i], there[1, i] = here[0, i], here[1, i]
    return n


@entry
def greatest_pair(waves, row, transit, end, near, sign, high, low, work, found):
    """The greatest sign·(f − g) of all pairs that meet; found = value, s, r. `high`, `low`: of sign·f and sign·g."""
    best = -1e300
    least = 1e300
    for k in range(waves.pieces[row + 1]):
        least = min(least, low[0, k])
    first = 0
    for i in range(waves.pieces[row]):
        s1, s2 = waves.start[row, i], min(piece_end(waves, row, i), end)
        while first + 1 < waves.pieces[row + 1] and piece_end(waves, row + 1, first) <= s1 - transit:
            first += 1
        if s2 <= s1 or high[0, i] - least <= best:
            continue
        k = first
        while k < waves.pieces[row + 1]:
            r1, r2 = waves.start[row + 1, k], min(piece_end(waves, row + 1, k), end)
            if r1 >= s2 + transit - near:
                break
            met = s1 - r2 < transit - near and s2 + r2 > near - transit and s1 + r1 < 2 * end - transit - near
            if met and r2 > r1 and high[0, i] - low[0, k] > best:
                best = _pair(waves, row, i, k, transit, end, sign, high, low, best, work, found)
            k += 1
    found[0] = best


@inner
def _pair(waves, row, i, k, transit, end, sign, high, low, best, work, found):
    """The greatest of two pieces, where it exceeds what was found before."""
    s1, s2, r1, r2 = (
        waves.start[row, i],
        piece_end(waves, row, i),
        waves.start[row + 1, k],
        piece_end(waves, row + 1, k),
    )
    b1, b2 = min(s2, end), min(r2, end)
    bent_f, bent_g = waves.degree[row, i] > 0, waves.degree[row + 1, k] > 0
    top = 0.5 * (s1 + s2) + 0.5 * (s2 - s1) * high[1, i]
    bottom = 0.5 * (r1 + r2) + 0.5 * (r2 - r1) * low[1, k]
    feasible = abs(top - bottom) <= transit and -transit <= top + bottom <= 2.0 * end - transit
    if feasible and top <= b1 and bottom <= b2:
        found[1], found[2] = top, bottom
        return high[0, i] - low[0, k]
    n = overlap(float(s1), float(b1), float(r1), float(b2), float(transit), float(end), work)
    if n < 3:
        return best
    corners = work[12:14]
    if not bent_f and not bent_g:
        s, r = 0.0, 0.0
        for j in range(n):
            s += corners[0, j] / n
            r += corners[1, j] / n
        found[1], found[2] = s, r
        return high[0, i] - low[0, k]
    return _bent_pair(waves, row, i, k, n, sign, top, bottom, transit, end, best, work, found)


@inner
def _bent_pair(waves, row, i, k, n, sign, top, bottom, transit, end, best, work, found):
    """Along the edges of the polygon, and across it where one of the two has its extreme."""
    f, g, corners = work[6], work[7], work[12:14]
    s1, s2, r1, r2 = (
        waves.start[row, i],
        piece_end(waves, row, i),
        waves.start[row + 1, k],
        piece_end(waves, row + 1, k),
    )
    m, d = part(waves, row, i, s1, s2, f, work), part(waves, row + 1, k, r1, r2, g, work)
    for j in range(m + 1):
        f[j] *= sign
    for j in range(d + 1):
        g[j] *= sign
    for edge in range(n + 2):
        if edge < n:
            other = edge + 1 if edge + 1 < n else 0
            sa, ra, sb, rb = corners[0, edge], corners[1, edge], corners[0, other], corners[1, other]
        elif edge == n:  # s at the extreme of f, all r that it meets
            sa = sb = top
            ra = max(r1 * 1.0, top - transit, -transit - top)
            rb = min(r2 * 1.0, top + transit, 2.0 * end - transit - top)
        else:
            ra = rb = bottom
            sa = max(s1 * 1.0, bottom - transit, -transit - bottom)
            sb = min(s2 * 1.0, bottom + transit, 2.0 * end - transit - bottom)
        if edge >= n and (sb < sa or rb < ra or sa < s1 or sb > s2 or ra < r1 or rb > r2):
            continue
        a, b = (sa + sb - s1 - s2) / (s2 - s1), (sb - sa) / (s2 - s1)
        e, h = (ra + rb - r1 - r2) / (r2 - r1), (rb - ra) / (r2 - r1)
        most, x = _along(f, m, g, d, a, b, e, h)
        if most > best:
            best = most
            found[1], found[2] = 0.5 * (sa + sb) + 0.5 * (sb - sa) * x, 0.5 * (ra + rb) + 0.5 * (rb - ra) * x
    return best
