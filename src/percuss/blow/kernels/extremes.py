"""The greatest force in a section: f that left one end at s meets g that left the other at r if |s − r| ≤ τ.

N = Z (f(s) − g(r)), at the time (s + r + τ)/2, which is in the window; so the greatest N is that of all pairs.
"""

from __future__ import annotations

from percuss.blow.kernels.chebyshev import derivative, value
from percuss.blow.kernels.rows import part, piece_at, piece_end
from percuss.compiled import entry, inner

SAMPLES = 65  # of a slope, between which it falls through 0
BLOCK = 32  # pieces that are passed over together
UNKNOWN = 2.0  # a place that has not been looked for


@inner
def _slope(c, n, d, m, a, b, e, g, x):
    """Of p(a + b x) − q(e + g x), from the derivatives of p and q, of degrees n − 1 and m − 1."""
    found = 0.0
    if n > 0:
        found += b * value(c, n - 1, a + b * x)
    if m > 0:
        found -= g * value(d, m - 1, e + g * x)
    return found


@inner
def _top(c, n, d, m, a, b, e, g, low, high):
    """Where such a slope, positive at the one end and not at the other, is 0: by halving."""
    for _ in range(54):
        x = 0.5 * (low + high)
        if _slope(c, n, d, m, a, b, e, g, x) > 0.0:
            low = x
        else:
            high = x
    return 0.5 * (low + high)


@inner
def _along(c, n, d, m, a, b, e, g, work):
    """The greatest p(a + b x) − q(e + g x) for x in [−1, 1], and x: at an end, or where the slope falls through 0."""
    best, at = value(c, n, a - b) - value(d, m, e - g), -1.0
    found = value(c, n, a + b) - value(d, m, e + g)
    if found > best:
        best, at = found, 1.0
    if n + m == 0:
        return best, at
    dc, dd = work[8], work[9]
    derivative(c, n, dc)
    derivative(d, m, dd)
    step, before = 2.0 / (SAMPLES - 1), _slope(dc, n, dd, m, a, b, e, g, -1.0)
    for k in range(1, SAMPLES):
        x = -1.0 + step * k
        now = _slope(dc, n, dd, m, a, b, e, g, x)
        if before > 0.0 and now <= 0.0:
            top = _top(dc, n, dd, m, a, b, e, g, x - step, x)
            found = value(c, n, a + b * top) - value(d, m, e + g * top)
            if found > best:
                best, at = found, top
        before = now
    return best, at


@entry
def piece_bounds(waves, row, sign, found):
    """What sign·p of each piece of a row does not exceed, found[0], |T_k| ≤ 1; found[1], its place, is UNKNOWN."""
    for k in range(waves.pieces[row]):
        rest, most = waves.rest[row, k], sign * waves.first[row, k]
        for j in range(waves.degree[row, k]):
            most += abs(waves.pool[rest + j])
        found[0, k] = most
        found[1, k] = UNKNOWN if waves.degree[row, k] > 0 else 0.0


@inner
def _settle(waves, row, k, sign, found, work):
    """Put the greatest value of sign·p of a piece, and its place in [−1, 1], where its bound was."""
    if found[1, k] != UNKNOWN:
        return
    c, zero = work[6], work[7]
    zero[0] = 0.0
    n = part(waves, row, k, waves.start[row, k], piece_end(waves, row, k), c, work)
    for j in range(n + 1):
        c[j] *= sign
    found[0, k], found[1, k] = _along(c, n, zero, 0, 0.0, 1.0, 0.0, 0.0, work)


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
def greatest_pair(waves, row, transit, end, near, sign, order, high, low, highs, lows, work, found):
    """The greatest sign·(f − g) of all pairs that meet; found = value, s, r."""
    # `high`, `low`: bounds of sign·f and of −sign·g, as `piece_bounds` leaves them. `highs`, `lows`: the greatest of
    # every BLOCK of them. `order`: blocks of f, the greatest first. Blocks, and pieces, whose bounds together do not
    # exceed what has been found are passed over.
    best, size = -1e300, waves.pieces[row]
    for a in order:
        first, last = BLOCK * a, min(BLOCK * a + BLOCK, size)
        s1, s2 = waves.start[row, first], min(piece_end(waves, row, last - 1), end)
        if s2 <= s1:
            continue
        b = piece_at(waves, row + 1, s1 - transit) // BLOCK
        while b < lows.size and waves.start[row + 1, BLOCK * b] < s2 + transit:
            if highs[a] + lows[b] > best:
                for i in range(first, last):
                    if high[0, i] + lows[b] > best:
                        best = _block(waves, row, i, b, transit, end, near, sign, high, low, best, work, found)
            b += 1
    found[0] = best


@entry
def greatest_at(waves, row, before, after, end, near, sign, one, other, high, low, work, found):
    """The greatest sign·(one f(t − before) − other g(t − after)) over the window, where both weights are positive.

    `high`, `low` as `greatest_pair` has them, but looked for in no piece; found = value, t.
    """
    best, f, g, now = -1e300, work[6], work[7], 0
    i, k = piece_at(waves, row, -before), piece_at(waves, row + 1, -after)
    while now < end:
        ends, others = piece_end(waves, row, i) + before, piece_end(waves, row + 1, k) + after
        stop = min(ends, others, end)
        if stop - now > near and one * high[0, i] + other * low[0, k] > best:
            n = part(waves, row, i, now - before, stop - before, f, work)
            m = part(waves, row + 1, k, now - after, stop - after, g, work)
            for j in range(n + 1):
                f[j] *= sign * one
            for j in range(m + 1):
                g[j] *= sign * other
            most, x = _along(f, n, g, m, 0.0, 1.0, 0.0, 1.0, work)
            if most > best:
                best = most
                found[1] = now + 0.5 * (1.0 + x) * (stop - now)
        if ends <= stop:
            i += 1
        if others <= stop:
            k += 1
        if i >= waves.pieces[row] or k >= waves.pieces[row + 1]:
            break
        now = stop
    found[0] = best


@inner
def _block(waves, row, i, b, transit, end, near, sign, high, low, best, work, found):
    """The greatest of a piece of f and a block of g, where it exceeds what was found before."""
    for k in range(BLOCK * b, min(BLOCK * b + BLOCK, waves.pieces[row + 1])):
        if high[0, i] + low[0, k] > best and _meet(waves, row, i, k, transit, end, near):
            _settle(waves, row, i, sign, high, work)
            _settle(waves, row + 1, k, -sign, low, work)
            if high[0, i] + low[0, k] > best:
                best = _pair(waves, row, i, k, transit, end, sign, high, low, best, work, found)
    return best


@inner
def _meet(waves, row, i, k, transit, end, near):
    """Whether two pieces meet within the window."""
    s1, s2 = waves.start[row, i], min(piece_end(waves, row, i), end)
    r1, r2 = waves.start[row + 1, k], min(piece_end(waves, row + 1, k), end)
    if r2 <= r1 or s1 - r2 >= transit - near or r1 - s2 >= transit - near:
        return False
    return s2 > s1 and s2 + r2 > near - transit and s1 + r1 < 2 * end - transit - near


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
        return high[0, i] + low[0, k]
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
        return high[0, i] + low[0, k]
    return _bent_pair(waves, row, i, k, n, sign, transit, end, best, work, found)


@inner
def _bent_pair(waves, row, i, k, n, sign, transit, end, best, work, found):
    """Along the edges of the polygon, and across it where f has a maximum."""
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
    for edge in range(n):
        other = edge + 1 if edge + 1 < n else 0
        sa, ra, sb, rb = corners[0, edge], corners[1, edge], corners[0, other], corners[1, other]
        most, x = _along_line(f, m, g, d, s1, s2, r1, r2, sa, sb, ra, rb, work)
        if most > best:
            best = most
            found[1], found[2] = 0.5 * (sa + sb) + 0.5 * (sb - sa) * x, 0.5 * (ra + rb) + 0.5 * (rb - ra) * x
    peaks = work[14]
    for j in range(_peaks(f, m, work)):  # within, f has a maximum, perhaps not its greatest, with all r that it meets
        s = 0.5 * (s1 + s2) + 0.5 * (s2 - s1) * peaks[j]
        ra = max(r1 * 1.0, s - transit, -transit - s)
        rb = min(r2 * 1.0, s + transit, 2.0 * end - transit - s)
        if rb < ra or s > end:
            continue
        most, x = _along_line(f, m, g, d, s1, s2, r1, r2, s, s, ra, rb, work)
        if most > best:
            best = most
            found[1], found[2] = s, 0.5 * (ra + rb) + 0.5 * (rb - ra) * x
    return best


@inner
def _along_line(f, m, g, d, s1, s2, r1, r2, sa, sb, ra, rb, work):
    """The greatest f − g on a line of pairs, and where on it, from −1 to 1."""
    a, b = (sa + sb - s1 - s2) / (s2 - s1), (sb - sa) / (s2 - s1)
    e, h = (ra + rb - r1 - r2) / (r2 - r1), (rb - ra) / (r2 - r1)
    return _along(f, m, g, d, a, b, e, h, work)


@inner
def _peaks(c, n, work):
    """Places of the maxima of p inside [−1, 1], in work[14]; how many."""
    if n < 2:
        return 0
    slope, out = work[8], work[14]
    derivative(c, n, slope)
    count, step, before = 0, 2.0 / (SAMPLES - 1), value(slope, n - 1, -1.0)
    for k in range(1, SAMPLES):
        x = -1.0 + step * k
        now = value(slope, n - 1, x)
        if before > 0.0 and now <= 0.0:
            out[count] = _top(slope, n, slope, 0, 0.0, 1.0, 0.0, 0.0, x - step, x)
            count += 1
        before = now
    return count
