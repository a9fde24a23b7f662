"""The elastic modes in flight: their phasors, their free motion, and their forced motion."""

from __future__ import annotations

import math

from percuss.compiled import inner, summed
from percuss.simulate.kernels.codes import POWERS, SINGLY
from percuss.simulate.kernels.creeping import creep
from percuss.simulate.kernels.elementary import fading, sine_cosine

SMALL = 1e-3  # an angle whose fifth power does not matter


@summed
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


@inner
def phasors(bar, modes, work, tau):
    """e^{iλ_nτ} − 1 of the oscillating modes into `work`, but for a turn by −δ_n times the result.

    A harmonic spectrum needs the powers of one phasor. What damping takes from its frequencies, δ_n = ω_n − λ_n, is
    left to the caller, or, when it is more than `SMALL`, each phasor is computed by itself. With the law `RATIO` the
    damping is harmonic, too, and so are λ_n; then, and with `SINGLY`, the phasors have the damping in them.
    """
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
    """e^{(−d_n/2 + iλ_n)τ} − 1 of every oscillating mode by itself, and 0 of the others.

    `sine_cosine` without a branch, for vector code; and e^{−x} − 1 by Taylor's polynomial of x/2¹², squared twelve
    times as e(2 + e), of which nothing is left beyond x = 64.
    """
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


@summed
def elastic(bar, modes, z, now, work, tau):
    """f(τ) − f(0), f'(τ), f''(τ) of the free elastic part, and what `phasors` returned; the phasors stay in `work`.

    There stand besides, for the creeping modes, q(τ) and q'(τ) (`aside`), and q(τ) − q(0) (`forced`).
    """
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


@summed
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


@summed
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


@summed
def turn_modes(bar, modes, z, work, tau, late, slip):
    """The amplitudes of the free motion at τ.

    `late`: how much earlier the phasors in `work` were computed; inf when there are none near. `slip`: what `phasors`
    returned then.
    """
    n = modes.omega.shape[0]
    if n == 0:
        return
    if not abs(late) * bar.quickest + bar.delta * slip < SMALL:
        slip, late = phasors(bar, modes, work, tau), 0.0
    for i in range(modes.creeping.shape[0]):
        j = modes.creeping[i]
        square = modes.omega[j] * modes.omega[j]
        _, h, rate, left = creep(modes.damping[j], modes.signed[j], modes.omega[j], tau)
        work.aside_re[j] = z[0, j] * left + z[1, j] * h
        work.aside_im[j] = z[1, j] * rate - z[0, j] * (square * h)
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


@summed
def forced_modes(coupling, work, c, s, order):
    """Displacement (order 0) or velocity (1) of every q_n under the harmonics, into `work`.

    `c`, `s`: cosine and sine of the load phase.
    """
    n = coupling.shape[2]
    for j in range(n):
        work.forced[j] = 0.0
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
