"""The tangent vector of a simulated motion, compiled: how it grows from impact to impact.

The load does not depend on the state, so a small difference at fixed times moves freely between two impacts, whatever
the load does, and at an impact goes through the saltation matrix (theory §5; `percuss.stability.linear_map`). All in
q_n = 2(−1)ⁿ u_n, whose sum with u_0 is the gap.
"""

import math

from numba import njit

IMPACT = 0
TURN = 2.0 * math.pi
LATE = 1e-9  # an event this little after a step of the load was at it, before it


@njit(cache=True, nogil=True, error_model="numpy")
def free_pair(d, omega, square, tau):
    """C and S of the free motion q = q(0) C + (q'(0) + d q(0)/2) S of a mode with λ² = `square` of either sign."""
    if square > 0.0:
        lam, fade = math.sqrt(square), math.exp(-0.5 * d * tau)
        angle = lam * tau
        return fade * math.cos(angle), fade * (math.sin(angle) / lam)
    rate = math.sqrt(-square)
    fade, spread = math.exp(-omega * omega / (0.5 * d + rate) * tau), 2.0 * rate * tau
    reach = -math.expm1(-spread) / (2.0 * rate) if spread > 1e-300 else tau
    return 0.5 * fade * (1.0 + math.exp(-spread)), fade * reach


@njit(cache=True, nogil=True, error_model="numpy")
def flown(d, omega, square, tau, first, second):
    """Free oscillations for a time τ, in place: values and (rates + d/2 · values), each of shape (2, N)."""
    for n in range(omega.shape[0]):
        c, s = free_pair(d, omega[n], square[n], tau)
        for row in range(2):
            q, g = first[row, n], second[row, n]
            first[row, n] = q * c + g * s
            second[row, n] = g * c - square[n] * q * s


@njit(cache=True, nogil=True, error_model="numpy")
def log_growths(
    code, gone, phase, piece, speed, force, value, slope, shape, rate,
    omega, square, statics, sign, breaks, values, d, r, first, second, growth,
):  # fmt: skip
    """Logarithm of the growth of a small difference over each flight and impact, into `growth`; returns how many.

    Events are rows: the first is an impact, all others impacts or grazes. `gone`: time since the one before. `value`,
    `slope`: the free motion after the event; `shape`, `rate`: the forced one, q_n and q_n'. `first`, `second`: room for
    two rows of N numbers, the motion and the difference.
    """
    modes, impacts = omega.shape[0], 0
    moved, drifting = 1.0, 1.0  # of the rigid motion
    for n in range(modes):
        first[1, n], second[1, n] = 1.0 / (n + 2.0), omega[n] / (n + 2.0)
    for i in range(1, code.shape[0]):
        for n in range(modes):
            first[0, n], second[0, n] = value[i - 1, n], slope[i - 1, n]
        ahead = -math.expm1(-d * gone[i]) / d if d > 0.0 else gone[i]
        moved += ahead * drifting
        drifting *= 1.0 - d * ahead
        left, at, step = gone[i], phase[i - 1], piece[i - 1]
        while breaks.shape[0]:
            following = step + 1 if step + 1 < breaks.shape[0] else 0
            ahead = breaks[following] - at
            if following == 0 and ahead < 0.0:
                ahead += TURN
            ahead = max(ahead, 0.0)
            if step == piece[i] and ahead >= left - LATE:
                break
            flown(d, omega, square, ahead, first, second)
            for n in range(modes):  # the static shape jumps, so the free part jumps back
                jump = statics[n] * (values[step] - values[following])
                first[0, n] += jump
                second[0, n] += 0.5 * d * jump
            left, at, step = left - ahead, breaks[following], following
        flown(d, omega, square, left, first, second)
        if code[i] != IMPACT:
            continue
        total, rigid = moved, speed[i]
        for n in range(modes):
            total += first[1, n]
            rigid -= second[0, n] - 0.5 * d * first[0, n] + rate[i, n]
        jump = (1.0 + r) * total / speed[i]
        moved -= rigid * jump
        drifting = force[i] * jump - r * drifting
        size = moved * moved + drifting * drifting
        for n in range(modes):
            before = second[0, n] - 0.5 * d * first[0, n] + rate[i, n]
            turned = -r * (second[1, n] - 0.5 * d * first[1, n])
            u = first[1, n] - before * jump
            v = turned + (sign[n] * force[i] - omega[n] * omega[n] * (value[i, n] + shape[i, n])) * jump
            first[1, n], second[1, n] = u, v + 0.5 * d * u
            size += omega[n] * omega[n] * u * u + v * v
        size = math.sqrt(size)
        growth[impacts] = math.log(size) if size > 0.0 else -math.inf
        impacts += 1
        if not 0.0 < size < math.inf:
            return impacts
        moved /= size
        drifting /= size
        for n in range(modes):
            first[1, n] /= size
            second[1, n] /= size
    return impacts
