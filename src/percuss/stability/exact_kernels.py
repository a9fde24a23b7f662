"""The largest multiplier of many orbits, compiled: plain functions of numbers and arrays.

The linearised map is block-diagonal plus rank one (`percuss.stability.linear_map`), so that its multipliers are the
roots of a secular function 1 + Σ w_j/(μ − ξ_j), with poles ξ_j and residues w_j in closed form; they are found by
`percuss.stability.secular_kernels`. The poles are real where the impact keeps the strain.
"""

import math

from percuss.compiled import entry, inner, summed
from percuss.stability.secular_kernels import (
    IM,
    JUMP,
    JUMP_RATE,
    POLE,
    POLE_IM,
    RE,
    RESIDUE,
    RESIDUE_IM,
    STATE_ROWS,
    WORK_ROWS,
    all_together,
    beside_complex_poles,
    beside_poles,
    fits,
    foremost,
    joined,
    joined_in_plane,
)

__all__ = ["STATE_ROWS", "WORK_ROWS", "largest_multipliers"]

# rows of `bar`, for n = 0 … N: Φ_n over the impact period, exp(−d_n T), its root and 1 less that, d_n, ω_n, γ_n, and
# exp(−d_n T/2)(1 − cos λ_n T)
A, B, C, E, DECAY, HALF, LOSS, DAMPING, OMEGA, GAMMA, VERSINE = range(11)
BAR_ROWS = 11

TURNED = 4.0 * 2.0**-52  # as in percuss.steady.impact_state
ASIDE = 2.0  # as in percuss.stability.linear_map


@summed
def jumps(beta, alpha, mean, pull, forced, forced_rate, bar, period, work):
    """g_n and g_n' of the saltation matrix into `work`; returns the speed of the striking end before the impact.

    `mean`, `pull`: p_0 and p(φ) − p_0. `forced`, `forced_rate`: f_n less its static part, and f_n', n = 1 … N. The
    state before the impact solves (I − ΦD)(u, u') = (I − Φ)(f, f'), with D = diag(α, β) of the contact law.
    """
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
    """The trace of the map and that of its square; see `LinearMap.trace_of_square`."""
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
    """Poles, ascending, and residues into `work` where the strain is kept; see `LinearMap.partial_fractions`."""
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
            residue = gamma * ((a * pole - beta * decay) * g + b * pole * h) / width
            at = count
            while at > 0 and work[POLE, at - 1] > pole:
                work[POLE, at], work[RESIDUE, at] = work[POLE, at - 1], work[RESIDUE, at - 1]
                at -= 1
            work[POLE, at], work[RESIDUE, at] = pole, residue
            count += 1
    return count


@inner
def complex_fractions(beta, alpha, speed, bar, work):
    """Poles and residues into `work` where the strain is turned over; see `LinearMap.partial_fractions`."""
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


@entry
def largest_multipliers(beta, alpha, mean, pull, forced, forced_rate, bar, period, work, state, found, mode):
    """The multiplier of largest modulus of many orbits, and the mode that it belongs to.

    Parameters are arrays over the orbits, β and α those of their contact laws, `forced` and `forced_rate` with N
    columns; see `jumps`. Results: real and imaginary part into the rows of `found`, and `mode`, which is −1 where the
    roots failed their check.
    """
    for i in range(beta.shape[0]):
        mode[i] = -1
        found[0, i], found[1, i] = math.nan, math.nan
        speed = jumps(beta[i], alpha[i], mean[i], pull[i], forced[i], forced_rate[i], bar, period, work)
        if not 0.0 < abs(speed) < math.inf:
            continue
        trace, square = traces(beta[i], alpha[i], speed, bar, work)
        if not abs(trace) + abs(square) < math.inf:
            continue
        flat = alpha[i] > 0.0
        if flat:
            count = real_fractions(beta[i], alpha[i], speed, bar, work)
            live = joined(count, work)
            strong = beside_poles(live, work, state)
        else:
            count = complex_fractions(beta[i], alpha[i], speed, bar, work)
            live = joined_in_plane(count, work)
            strong = beside_complex_poles(live, work, state)
        if not all_together(live, strong, flat, work, state) or not fits(count, trace, square, work):
            continue
        j = foremost(count, work)
        found[0, i], found[1, i] = work[RE, j], work[IM, j]
        mode[i] = foremost_mode(complex(work[RE, j], work[IM, j]), beta[i], alpha[i], bar, work)
