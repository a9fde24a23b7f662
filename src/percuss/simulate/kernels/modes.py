"""The elastic modes in flight: their phasors, their free motion, and their forced motion."""

from __future__ import annotations

import math

import numpy as np

from percuss.compiled import inlined, inlined_sums, inner
from percuss.simulate.kernels.motion_records import EPS, POWERS, SINGLY

# ---- Modes that are overdamped or close to it: they keep the value and the rate of their free motion

SHARES = np.append(0.0, 1.0 / np.arange(1.0, 26.0))


@inner
def creep(d, square, omega, tau):
    """g, h, h' and 1 − g of a mode that is overdamped or close to it, each without cancellation."""
    # h is the answer to a unit push, h(0) = 0 and h'(0) = 1, and g = ω² ∫h, so that the free motion is q − q(0) = q'(0)
    # h − q(0) g, with rate q'(0) h' − q(0) ω² h. `square`: λ² = ω² − d²/4, of either sign.
    x = d * tau
    if x < 1.0:  # the power series of h, its terms divided by τ
        y = omega * tau
        y *= y
        before, term, g, h, rate = 0.0, 1.0, 0.5, 1.0, 1.0
        for k in range(1, 24):
            before, term = term, -(x * term + y * before * SHARES[k]) * SHARES[k + 1]
            h += term
            g += term * SHARES[k + 2]
            rate += term * (k + 1)
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


@inner
def most_of(d, square, omega, q, q1, tau, start, start1):
    """Bounds of |q|, |q'|, |q''|, |q‴| from τ on for a mode that is overdamped or close to it."""
    # `q`, `q1`: value and rate at τ; `start`, `start1`: at the anchor. As 0 ≤ h ≤ 1/d and |1 − g| ≤ 1 (`creep`), |q| ≤
    # |q(τ)| + |q'(τ)|/d. With the two rates a < b of decay, p = q' + a q obeys p' = −b p: it fades at the quick one, q'
    # = p − a q, q'' = a² q − d p, q‴ = (a² + b d) p − a³ q, and nothing cancels.
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


@inner
def rising(modes, q, q1):
    """The most that Σ(q − q(τ)) of the creeping modes comes to from a time on, of their values and rates there."""
    most = 0.0
    for i in range(modes.creeping.shape[0]):
        j = modes.creeping[i]
        most += max(q1[j], 0.0) / modes.damping[j] + 1.0001 * max(-q[j], 0.0)  # h ≤ 1/d and g ≥ −1e-4, see `creep`
    return most * (1.0 + 1e-12)


@inner
def creeping(modes, z, work, tau):
    """Of the creeping modes: the most that Σ(q − q(0)) comes to from τ on, and bounds of its derivatives."""
    # q(τ) and the rest are read off `work`, where `elastic` left them.
    grown = 1.0 + 1e-12
    most, sup1, sup2, sup3 = rising(modes, work.aside_re, work.aside_im), 0.0, 0.0, 0.0
    for i in range(modes.creeping.shape[0]):
        j = modes.creeping[i]
        d, q, q1 = modes.damping[j], work.aside_re[j], work.aside_im[j]
        most += work.forced[j]
        _, one, two, three = most_of(d, modes.signed[j], modes.omega[j], q, q1, tau, z[0, j], z[1, j])
        sup1 += grown * one
        sup2 += grown * two
        sup3 += grown * three
    return most, sup1, sup2, sup3


@inner
def creep_sizes(bar, modes, z):
    """Of the creeping modes: what Σ|q − q(0)| is below at any time, and below times (1 − e^{−d_0τ})/d_0's integral …"""
    # … then Σ|q'(0)| and Σ(d|q'| + ω²|q|): what rounding is measured by. A mode damped less than the rigid motion has
    # no second bound.
    place, push, rate, curve = 0.0, 0.0, 0.0, 0.0
    for i in range(modes.creeping.shape[0]):
        j = modes.creeping[i]
        d, q, q1, square = modes.damping[j], abs(z[0, j]), abs(z[1, j]), modes.omega[j] * modes.omega[j]
        place += q
        push += square * q
        rate += q1
        curve += d * q1 + square * q
        if d < 0.999 * bar.damping:
            place += q1 / d
            push += 1e200 * (q + q1)
    return place, push, rate, curve


# ---- Functions of single numbers that come again and again, without cancellation and faster than those of the library


@inlined
def sine_cosine(x):
    """sin x and cos x together, each to 2e-16, by reduction to |x| ≤ π/4 in three parts and Taylor's polynomials."""
    # Its own sums are never reordered, whatever is said of those it is copied into: that would undo its rounding.
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


@inlined
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


@inlined
def sway(d, spring, tau):
    """The answer h to a unit push of a damped motion on a spring and its integral: `drift` with a frequency."""
    # h is 0 and h' = 1 − d h − ω² ∫h is 1 at τ = 0; smooth in d and ω, down to 0.
    if spring == 0.0:
        return drift(d, tau)
    return sprung(d, spring, tau)


@inner
def sprung(d, spring, tau):
    """`sway` on a spring."""
    square = spring * spring
    if d >= 1.9 * spring or spring * tau < 0.5:
        g, h, _, _ = creep(d, (spring - 0.5 * d) * (spring + 0.5 * d), spring, tau)
        return h, g / square
    half = 0.5 * d
    lam = math.sqrt((spring - half) * (spring + half))
    fade = math.exp(-half * tau)
    h = fade * math.sin(lam * tau) / lam
    return h, (1.0 - fade * math.cos(lam * tau) - half * h) / square


@inner
def ramped(d, spring, first, second, tau):
    """The integral of the second of what `sway` says: the answer to a unit ramp of the push."""
    x, y = d * tau, spring * tau
    if x > 1.0 or y > 1.0:
        return (tau - first - d * second) / (spring * spring)
    before, now, total = 0.0, 1.0, 1.0 / 6.0
    y *= y
    for n in range(1, 20):
        before, now = now, -(x * n * now + y * before) / (n * (n + 1.0))
        total += now / ((n + 2.0) * (n + 3.0))
    return tau * tau * tau * total


@inlined
def fading(half, tau):
    """e^{−hτ} and e^{−hτ} − 1, h half the damping."""
    x = half * tau
    if x < 0.04:
        xx = x * x
        fall = (1.0 / 120.0 - x * (1.0 / 720.0)) + xx * (1.0 / 5040.0 - x * (1.0 / 40320.0))
        fall = -x * ((1.0 - 0.5 * x) + xx * ((1.0 / 6.0 - x * (1.0 / 24.0)) + xx * fall))
        return 1.0 + fall, fall
    return math.exp(-x), math.expm1(-x)


@inlined
def reach(u, v, m):
    """How far u + v h + m h²/2 stays below 0 from h = 0 on, where it does reach 0 if m < 0; 0 when it is not below."""
    if u > 0.0 or (u == 0.0 and v >= 0.0):
        return 0.0
    root = math.sqrt(v * v - 2.0 * m * u)
    if v >= 0.0:
        return -2.0 * u / (v + root) if v + root > 0.0 else math.inf
    return (root - v) / m if m > 0.0 else math.inf


@inner
def reach_cubic(u, v, a, m, m2):
    """How far u + v h + a h²/2 + m h³/6 surely stays below 0, knowing besides that the curvature is at most `m2`."""
    # On [0, H] the third term is at most (m H/3) h²/2: a parabola for each H tried.
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


@inlined
def below(u, v, m):
    """From where to where u − v h + m h²/2 is below 0, for h ≥ 0; an empty span when it never is."""
    inside = v * v - 2.0 * m * u
    if v <= 0.0 or inside <= 0.0:
        return math.inf, 0.0
    both = v + math.sqrt(inside)
    return max(2.0 * u / both, 0.0), (both / m if m > 0.0 else math.inf)


# ---- The elastic modes in flight: their phasors, their free motion, and their forced motion

SMALL = 1e-3  # an angle whose fifth power does not matter


@inlined_sums
def powers(work, ar, ai, n):
    """(1 + a)ʲ − 1, j = 1 … n, into `work`: doubled in number at each round."""
    br, bi = ar + ar + (ar * ar - ai * ai), ai + ai + 2.0 * ar * ai
    work.re[0], work.im[0] = ar, ai
    if n > 1:
        work.re[1], work.im[1] = br, bi
    if n > 2:
        work.re[2], work.im[2] = ar + br + (ar * br - ai * bi), ai + bi + (ar * bi + ai * br)
    if n > 3:
        work.re[3], work.im[3] = br + br + (br * br - bi * bi), bi + bi + 2.0 * br * bi
    m = 4
    while m < n:
        ar, ai = work.re[m - 1], work.im[m - 1]
        for j in range(min(m, n - m)):
            br, bi = work.re[j], work.im[j]
            work.re[m + j] = ar + br + (ar * br - ai * bi)
            work.im[m + j] = ai + bi + (ar * bi + ai * br)
        m *= 2


@inlined
def phasors(bar, modes, work, tau):
    """e^{iλ_nτ} − 1 of the oscillating modes into `work`, but for a turn by −δ_n times the result."""
    # A harmonic spectrum needs the powers of one phasor. What damping takes from its frequencies, δ_n = ω_n − λ_n, is
    # left to the caller, or, when it is more than `SMALL`, each phasor is computed by itself. With the law `RATIO` the
    # damping is harmonic, too, and so are λ_n; then, and with `SINGLY`, the phasors have the damping in them.
    n = modes.omega.shape[0]
    if bar.law == SINGLY:
        damped_phasors(modes, work, tau)
        return 0.0
    if bar.delta * tau > SMALL:
        for j in range(n):
            sh, ch = sine_cosine(0.5 * modes.lam[j] * tau)
            work.re[j] = -2.0 * sh * sh
            work.im[j] = 2.0 * sh * ch
        return 0.0
    sh, ch = sine_cosine(0.5 * bar.base * tau)
    ar, ai = -2.0 * sh * sh, 2.0 * sh * ch
    if bar.law == POWERS:
        powers(work, ar, ai, n)
    else:
        _, fall = fading(bar.base_half, tau)
        powers(work, fall + ar + fall * ar, ai + fall * ai, n)
    for i in range(modes.creeping.shape[0]):
        j = modes.creeping[i]
        work.re[j], work.im[j] = 0.0, 0.0
    return tau if bar.law == POWERS else 0.0


@inner
def damped_phasors(modes, work, tau):
    """e^{(−d_n/2 + iλ_n)τ} − 1 of every oscillating mode by itself, and 0 of the others."""
    # `sine_cosine` without a branch, for vector code; and e^{−x} − 1 by Taylor's polynomial of x/2¹², squared twelve
    # times as e(2 + e), of which nothing is left beyond x = 64.
    n = modes.omega.shape[0]
    for j in range(n):
        angle = 0.5 * modes.lam[j] * tau
        x = min(modes.half[j] * tau, 64.0) * (1.0 / 4096.0)
        fall = x * ((1.0 / 120.0 - x * (1.0 / 720.0)) + x * x * (1.0 / 5040.0))
        fall = -x * ((1.0 - 0.5 * x) + x * x * (1.0 / 6.0 - x * (1.0 / 24.0)) + x * x * x * fall)
        for _ in range(12):
            fall = fall * (2.0 + fall)
        turns = (angle * 0.6366197723675814 + 6755399441055744.0) - 6755399441055744.0  # to the nearest whole number
        r = ((angle - turns * 1.5707963267341256) - turns * 6.077100506303966e-11) - turns * 2.0222662487111665e-21
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
        quadrant = turns - 4.0 * math.floor(0.25 * turns)
        odd = quadrant == 1.0 or quadrant == 3.0
        sine, cosine = (c, s) if odd else (s, c)
        re = -2.0 * sine * sine  # of twice the angle: the sign of the half does not matter
        im = -2.0 * sine * cosine if odd else 2.0 * sine * cosine
        work.re[j] = fall + re + fall * re
        work.im[j] = im + fall * im


@inlined_sums
def elastic(bar, modes, z, now, work, tau):
    """f(τ) − f(0), f'(τ), f''(τ) of the free elastic part, and what `phasors` returned; the phasors stay in `work`."""
    # There stand besides, for the creeping modes, q(τ) and q'(τ) (`aside`), and q(τ) − q(0) (`forced`).
    if modes.omega.shape[0] == 0:
        return 0.0, 0.0, 0.0, 0.0
    slip = phasors(bar, modes, work, tau)
    y, v, a = faded_together(bar, modes, z, now, work, slip, tau) if bar.law == POWERS else faded_singly(modes, z, work)
    for i in range(modes.creeping.shape[0]):
        j = modes.creeping[i]
        d, square = modes.damping[j], modes.omega[j] * modes.omega[j]
        g, h, hr, left = creep(d, modes.signed[j], modes.omega[j], tau)
        step = z[1, j] * h - z[0, j] * g
        q = z[1, j] * h + z[0, j] * left
        w = z[1, j] * hr - z[0, j] * (square * h)
        y += step
        v += w
        a += -d * w - square * q
        work.forced[j], work.aside_re[j], work.aside_im[j] = step, q, w
    return y, v, a, slip


@inner
def elastic_apart(bar, modes, z, now, work, tau):
    """`elastic`, made once for what is seldom done."""
    return elastic(bar, modes, z, now, work, tau)


@inlined_sums
def faded_together(bar, modes, z, now, work, slip, tau):
    """The oscillating part of `elastic` where one damping holds for all modes."""
    moved, rate, curve = 0.0, 0.0, 0.0
    for j in range(modes.omega.shape[0]):
        x = modes.delta[j] * slip
        xx = x * x
        c, s = xx * (xx * (1.0 / 24.0) - 0.5), x * (xx * (1.0 / 6.0) - 1.0)
        er, ei = work.re[j], work.im[j]
        er, ei = er + c + (er * c - ei * s), ei + s + (er * s + ei * c)
        zr, zi = z[0, j], z[1, j]
        step = zr * er - zi * ei
        moved += step
        rate += modes.lam[j] * (zi + zr * ei + zi * er)
        curve += modes.square[j] * (zr + step)
    d = 2.0 * bar.half
    fade, fall = fading(bar.half, tau)
    start = now.free_oscillating
    total = moved + start
    return (
        fade * moved + fall * start,
        -fade * (0.5 * d * total + rate),
        fade * (d * rate + 0.25 * d * d * total - curve),
    )


@inlined_sums
def faded_singly(modes, z, work):
    """The same where the phasors have the damping of each mode in them."""
    moved, rate, curve = 0.0, 0.0, 0.0
    for j in range(modes.omega.shape[0]):
        half, lam = modes.half[j], modes.lam[j]
        zr, zi = z[0, j] * modes.oscillates[j], z[1, j] * modes.oscillates[j]
        step = zr * work.re[j] - zi * work.im[j]
        re, im = zr + step, zi + zr * work.im[j] + zi * work.re[j]
        moved += step
        rate -= half * re + lam * im
        curve += (half * half - modes.square[j]) * re + 2.0 * half * lam * im
    return moved, rate, curve


@inlined_sums
def turn_modes(bar, modes, z, work, tau, late, slip):
    """The amplitudes of the free motion at τ."""
    # `late`: how much earlier the phasors in `work` were computed; inf when there are none near. `slip`: what `phasors`
    # returned then.
    n = modes.omega.shape[0]
    if n == 0:
        return
    anew = not abs(late) * bar.quickest + bar.delta * slip < SMALL
    if anew:
        slip, late = phasors(bar, modes, work, tau), 0.0
    for i in range(modes.creeping.shape[0]):
        j = modes.creeping[i]
        d, square, q, w = modes.damping[j], modes.omega[j] * modes.omega[j], work.aside_re[j], work.aside_im[j]
        if anew or not abs(late) * d < SMALL:
            _, h, rate, left = creep(d, modes.signed[j], modes.omega[j], tau)
            q, w = z[0, j] * left + z[1, j] * h, z[1, j] * rate - z[0, j] * (square * h)
        elif late != 0.0:  # by its Taylor polynomial from where `elastic` left it
            w2 = -d * w - square * q
            w3 = -d * w2 - square * w
            w4 = -d * w3 - square * w2
            w5 = -d * w4 - square * w3
            q += late * (w + late * (w2 / 2.0 + late * (w3 / 6.0 + late * (w4 / 24.0))))
            w += late * (w2 + late * (w3 / 2.0 + late * (w4 / 6.0 + late * (w5 / 24.0))))
        work.aside_re[j], work.aside_im[j] = q, w
    if bar.law == POWERS:
        fade, _ = fading(bar.half, tau)
        for j in range(n):
            x = modes.lam[j] * late - modes.delta[j] * slip
            xx = x * x
            c, s = fade + fade * (xx * (xx * (1.0 / 24.0) - 0.5)), fade * (x - x * (xx * (1.0 / 6.0)))
            er, ei = 1.0 + work.re[j], work.im[j]
            work.re[j] = er * c - ei * s
            work.im[j] = er * s + ei * c
    else:
        for j in range(n):
            x, fall = modes.lam[j] * late, -modes.half[j] * late
            xx = x * x
            fade = 1.0 + fall * (1.0 + fall * (0.5 + fall * (1.0 / 6.0 + fall * (1.0 / 24.0))))
            c, s = fade + fade * (xx * (xx * (1.0 / 24.0) - 0.5)), fade * (x - x * (xx * (1.0 / 6.0)))
            er, ei = 1.0 + work.re[j], work.im[j]
            work.re[j] = er * c - ei * s
            work.im[j] = er * s + ei * c
    for j in range(n):
        zr, zi = z[0, j], z[1, j]
        z[0, j] = zr * work.re[j] - zi * work.im[j]
        z[1, j] = zr * work.im[j] + zi * work.re[j]
    for i in range(modes.creeping.shape[0]):
        j = modes.creeping[i]
        z[0, j], z[1, j] = work.aside_re[j], work.aside_im[j]


@inlined_sums
def forced_modes(table, work, c, s, order):
    """Displacement (order 0) or velocity (1) of every q_n under the harmonics, or behind a ramp, into `work`."""
    # `c`, `s`: cosine and sine of the load phase.
    coupling, modes, ramp = table.coupling, table.modes, table.bar.ramp
    n = coupling.shape[2]
    for j in range(n):
        work.forced[j] = 0.0
    if ramp != 0.0:
        for j in range(n):
            late = -modes.damping[j] / (modes.omega[j] * modes.omega[j]) if order == 0 else 1.0
            work.forced[j] = ramp * modes.statics[j] * late
    wr, wi = 1.0, 0.0
    for k in range(coupling.shape[0]):
        wr, wi = wr * c - wi * s, wr * s + wi * c
        if order == 0:
            for j in range(n):
                work.forced[j] += coupling[k, 0, j] * wr - coupling[k, 1, j] * wi
        else:
            er, ei = (k + 1) * wr, (k + 1) * wi
            for j in range(n):
                work.forced[j] -= coupling[k, 0, j] * ei + coupling[k, 1, j] * er
