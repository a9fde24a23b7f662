"""Functions of single numbers that come again and again, without cancellation and faster than those of the library."""

from __future__ import annotations

import math

from percuss.compiled import inlined, inner
from percuss.simulate.kernels.creeping import creep


@inner
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


@inner
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


@inner
def sway(d, spring, tau):
    """The answer h to a unit push of a damped motion on a spring and its integral: `drift` with a frequency.

    h is 0 and h' = 1 − d h − ω² ∫h is 1 at τ = 0; smooth in d and ω, down to 0.
    """
    if spring == 0.0:
        return drift(d, tau)
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


@inlined
def below(u, v, m):
    """From where to where u − v h + m h²/2 is below 0, for h ≥ 0; an empty span when it never is."""
    inside = v * v - 2.0 * m * u
    if v <= 0.0 or inside <= 0.0:
        return math.inf, 0.0
    both = v + math.sqrt(inside)
    return max(2.0 * u / both, 0.0), (both / m if m > 0.0 else math.inf)
