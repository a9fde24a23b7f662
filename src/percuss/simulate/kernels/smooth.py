"""The smooth part of the gap: all but the free elastic part (theory §2).

The drift of the bar as a whole, under the constant part of the load, and what the load's harmonics add. On a gas
chamber the drift is a motion on a spring; `bar.mean` is then its acceleration at the anchor, without drag.
"""

from __future__ import annotations

from percuss.compiled import inlined
from percuss.simulate.kernels.elementary import drift, sine_cosine, sway


@inlined
def smooth_and_drift(bar, now, osc, tau):
    """S(τ) − S(0), S'(τ), S''(τ), the gap without the free elastic part; and what `sway` said."""
    d, b = bar.damping, now.drift
    first, second = sway(d, bar.spring, tau)
    y = b * first + bar.mean * second
    v = now.smooth_rate + (bar.mean - d * b) * first
    a = (bar.mean - d * b) * (1.0 - d * first)
    if bar.spring > 0.0:
        square = bar.spring * bar.spring
        v -= square * b * second
        a -= square * ((bar.mean - d * b) * second + b * first)
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
    return y, v, a, first, second


@inlined
def smooth(bar, now, osc, tau):
    """The first three of them."""
    y, v, a, _, _ = smooth_and_drift(bar, now, osc, tau)
    return y, v, a


@inlined
def rigid_rate(bar, harmonics, drifted, c, s):
    """u_0', the velocity of the mean of the bar: of its drift, and of its oscillation at a load phase."""
    wr, wi, v = c, s, drifted
    for k in range(harmonics.gap_re.shape[0]):
        if k:
            wr, wi = wr * c - wi * s, wr * s + wi * c
        v -= (k + 1) * (harmonics.rigid_re[k] * wi + harmonics.rigid_im[k] * wr)
    return v


@inlined
def drifted(bar, now, tau):
    """Velocity of the drift at τ."""
    if bar.spring > 0.0:
        first, second = sway(bar.damping, bar.spring, tau)
        late = bar.spring * bar.spring * now.drift * second
        return now.drift + (bar.mean - bar.damping * now.drift) * first - late
    first, _ = drift(bar.damping, tau)
    return now.drift + (bar.mean - bar.damping * now.drift) * first


@inlined
def smooth_at_anchor(bar, harmonics, now, osc):
    """What a flight from the anchor needs to know of the smooth part."""
    c, s = now.cosine, now.sine
    wr, wi, rate, rigid, curve = c, s, 0.0, 0.0, 0.0
    for k in range(harmonics.gap_re.shape[0]):
        if k:
            wr, wi = wr * c - wi * s, wr * s + wi * c
        g = harmonics.gap_re[k] * wr - harmonics.gap_im[k] * wi
        h = harmonics.gap_re[k] * wi + harmonics.gap_im[k] * wr
        osc[0, k], osc[1, k], n = g, h, k + 1.0
        rate -= n * h
        curve -= n * n * g
        rigid -= n * (harmonics.rigid_re[k] * wi + harmonics.rigid_im[k] * wr)
    now.drift = now.rigid_rate - rigid
    now.smooth_rate = now.drift + rate
    now.acceleration = now.free_curve + curve + bar.mean - bar.damping * now.drift
