"""Modes that are overdamped or close to it: they keep the value and the rate of their free motion."""

from __future__ import annotations

import math

from percuss.compiled import inner
from percuss.simulate.kernels.codes import EPS


@inner
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


@inner
def free_motion(d, square, omega, tau):
    """1 − g, h and h' of any mode: q = q(0) (1 − g) + q'(0) h, q' = q'(0) h' − q(0) ω² h."""
    if d < 1.9 * omega:
        lam, fade = math.sqrt(square), math.exp(-0.5 * d * tau)
        slow, h = fade * math.cos(lam * tau), fade * (math.sin(lam * tau) / lam)
        return slow + 0.5 * d * h, h, slow - 0.5 * d * h
    _, h, rate, left = creep(d, square, omega, tau)
    return left, h, rate


@inner
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


@inner
def creeping(modes, z, work, tau):
    """Of the creeping modes: the most that Σ(q − q(0)) comes to from τ on, and bounds of its derivatives.

    q(τ) and the rest are read off `work`, where `elastic` left them, unless τ is 0.
    """
    grown = 1.0 + 1e-12
    most, sup1, sup2, sup3 = 0.0, 0.0, 0.0, 0.0
    for i in range(modes.creeping.shape[0]):
        j = modes.creeping[i]
        d, q, q1 = modes.damping[j], z[0, j], z[1, j]
        if tau > 0.0:
            q, q1 = work.aside_re[j], work.aside_im[j]
            most += work.forced[j]
        most += grown * (max(q1, 0.0) / d + 1.0001 * max(-q, 0.0))  # h ≤ 1/d and g ≥ −1e-4, see `creep`
        _, one, two, three = most_of(d, modes.signed[j], modes.omega[j], q, q1, tau, z[0, j], z[1, j])
        sup1 += grown * one
        sup2 += grown * two
        sup3 += grown * three
    return most, sup1, sup2, sup3


@inner
def creep_sizes(bar, modes, z):
    """Of the creeping modes: what Σ|q − q(0)| is below at any time, and below times (1 − e^{−d_0τ})/d_0's integral …

    … then Σ|q'(0)| and Σ(d|q'| + ω²|q|): what rounding is measured by. A mode damped less than the rigid motion has no
    second bound.
    """
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
