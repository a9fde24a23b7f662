"""Linear equations of motion with constant coefficients over one interval, driven by a polynomial, spectrally.

In Chebyshev coefficients w' = r becomes w_k = (r_{k−1} − r_{k+1})/2k (r_0 doubled), three terms a row. The rows are
solved from the last one up, w_k = α_k w_{k−1} + β_k, which loses no digits for decaying motions however fast they
decay; the value at the start then gives w_0.
"""

from __future__ import annotations

from percuss.blow.kernels.chebyshev import antiderivative, chopped, combined, greatest
from percuss.blow.kernels.wave_records import MOST_DEGREE, NOTHING
from percuss.compiled import inner


@inner
def relaxed(rate, half, q, n, start, w, least, work):
    """w' = −rate w + q on an interval of length 2·half, w(−1) = start. The degree, and whether that is enough."""
    # It is where what is left out is rounding of w, or `least`: a start that differs by rounding from where a fast
    # motion is at rest is no motion. `work` has two rows.
    top = MOST_DEGREE
    alpha, beta = work[0], work[1]
    a, two = rate * half, 0.0
    one = -a / (2.0 * (top + 1) + a)  # of the first row left out: for slow motions, and for fast ones
    for k in range(top, 0, -1):
        share = a / (2.0 * k)
        before = q[k - 1] if k - 1 <= n else 0.0
        if k == 1:  # of w − start, so that a motion at rest has no coefficients
            before = 2.0 * (before - rate * start)
        after = q[k + 1] if k + 1 <= n else 0.0
        below = 1.0 / (1.0 - share * one)
        two = (half * (before - after) / (2.0 * k) + share * two) * below
        one = -share * (2.0 if k == 1 else 1.0) * below
        alpha[k], beta[k] = one, two
    # Σ(−1)^k (A_k w_0 + B_k) = 0; the A_k alternate, so that nothing cancels
    factor, rest, a_sum, b_sum, sign = 1.0, 0.0, 1.0, 0.0, -1.0
    for k in range(1, top + 1):
        factor, rest = alpha[k] * factor, alpha[k] * rest + beta[k]
        a_sum += sign * factor
        b_sum += sign * rest
        sign = -sign
    w[0] = -b_sum / a_sum
    for k in range(1, top + 1):
        w[k] = alpha[k] * w[k - 1] + beta[k]
    w[0] += start
    size = greatest(w, top) + greatest(q, n) * half / (1.0 + a)
    enough = abs(w[top]) + abs(w[top - 1]) <= max(2e-16 * size, least)
    return chopped(w, top, 1e-17 * size), enough


@inner
def crept(stiffness, drag, half, q, n, place, speed, u, v, work):
    """u' = v, v' = −stiffness u − drag v + q with two real rates that differ, likewise; the degree, and the rate that
    it is not enough for, or 0.

    v less a rate times u decays with the other rate, by itself. The matrix of `oscillated` would lose the slow one
    beside the fast one. `work` has three rows.
    """
    fast = -0.5 * drag - (0.25 * drag * drag - stiffness) ** 0.5
    slow = stiffness / fast
    k, enough = relaxed(-fast, half, q, n, speed - slow * place, v, NOTHING, work)
    m, enough_too = relaxed(-slow, half, q, n, speed - fast * place, u, NOTHING, work)
    most, share = max(k, m), 1.0 / (slow - fast)
    for j in range(most + 1):
        one, other = v[j] if j <= k else 0.0, u[j] if j <= m else 0.0
        u[j] = share * (other - one)
        v[j] = share * (slow * other - fast * one)
    return most, -fast if not enough else -slow if not enough_too else 0.0


@inner
def oscillated(stiffness, drag, half, q, n, place, speed, u, v, work):
    """u' = v, v' = −stiffness u − drag v + q, likewise; the degree of both, and whether it is enough."""
    # The factors α_k are polynomials in the matrix of the motion, [[0, 1], [−stiffness, −drag]]. `work` has six rows.
    top = MOST_DEGREE
    m00, m01, m10, m11 = 0.0, -half, stiffness * half, drag * half  # −half times that matrix
    # of the first row left out, −s m (1 + s m)⁻¹
    s = 1.0 / (2.0 * (top + 1))
    det = 1.0 / ((1.0 + s * m00) * (1.0 + s * m11) - s * m01 * s * m10)
    p00, p01, p10, p11 = det * (1.0 + s * m11) - 1.0, -det * s * m01, -det * s * m10, det * (1.0 + s * m00) - 1.0
    b0, b1 = 0.0, 0.0
    for k in range(top, 0, -1):
        s = 1.0 / (2.0 * k)
        before = q[k - 1] if k - 1 <= n else 0.0
        twice = 2.0 if k == 1 else 1.0
        after = q[k + 1] if k + 1 <= n else 0.0
        # (I − s m α) w_k = −s m twice w_{k−1} + R_k + s m β
        n00, n01 = 1.0 - s * (m00 * p00 + m01 * p10), -s * (m00 * p01 + m01 * p11)
        n10, n11 = -s * (m10 * p00 + m11 * p10), 1.0 - s * (m10 * p01 + m11 * p11)
        r0 = s * (m00 * b0 + m01 * b1)
        r1 = s * (m10 * b0 + m11 * b1) + half * s * (twice * before - after)
        det = 1.0 / (n00 * n11 - n01 * n10)
        b0, b1 = det * (n11 * r0 - n01 * r1), det * (n00 * r1 - n10 * r0)
        t = -s * twice * det
        p00, p01, p10, p11 = (
            t * (n11 * m00 - n01 * m10),
            t * (n11 * m01 - n01 * m11),
            t * (n00 * m10 - n10 * m00),
            t * (n00 * m11 - n10 * m01),
        )
        work[0][k], work[1][k], work[2][k], work[3][k], work[4][k], work[5][k] = p00, p01, p10, p11, b0, b1
    f00, f01, f10, f11, g0, g1 = 1.0, 0.0, 0.0, 1.0, 0.0, 0.0
    a00, a01, a10, a11, c0, c1, sign = 1.0, 0.0, 0.0, 1.0, 0.0, 0.0, -1.0
    for k in range(1, top + 1):
        p00, p01, p10, p11 = work[0][k], work[1][k], work[2][k], work[3][k]
        f00, f01, f10, f11 = p00 * f00 + p01 * f10, p00 * f01 + p01 * f11, p10 * f00 + p11 * f10, p10 * f01 + p11 * f11
        g0, g1 = p00 * g0 + p01 * g1 + work[4][k], p10 * g0 + p11 * g1 + work[5][k]
        a00, a01, a10, a11 = a00 + sign * f00, a01 + sign * f01, a10 + sign * f10, a11 + sign * f11
        c0, c1, sign = c0 + sign * g0, c1 + sign * g1, -sign
    det = 1.0 / (a00 * a11 - a01 * a10)
    r0, r1 = place - c0, speed - c1
    u[0], v[0] = det * (a11 * r0 - a01 * r1), det * (a00 * r1 - a10 * r0)
    for k in range(1, top + 1):
        u[k] = work[0][k] * u[k - 1] + work[1][k] * v[k - 1] + work[4][k]
        v[k] = work[2][k] * u[k - 1] + work[3][k] * v[k - 1] + work[5][k]
    push = greatest(q, n) * half
    size_v = greatest(v, top) + push / (1.0 + drag * half)
    size_u = greatest(u, top) + half * push / (1.0 + half * (drag + half * stiffness))
    rate = max(drag, stiffness**0.5)
    enough = abs(v[top]) + abs(v[top - 1]) <= max(2e-16 * size_v, NOTHING)
    enough = enough and abs(u[top]) + abs(u[top - 1]) <= max(2e-16 * size_u, NOTHING / rate)
    return max(chopped(u, top, 1e-17 * size_u), chopped(v, top, 1e-17 * size_v)), enough


@inner
def swung(mass, drag, stiffness, weight, p, n, half, place, speed, u, v, q, work):
    """m u'' + drag u' + stiffness u = weight p likewise: the degree, whether it is enough, and its fastest rate."""
    # Without a mass of first order, and without a stiffness either a velocity that follows p. `q` is a row of its own.
    if mass > 0.0:
        combined(weight / mass, p, n, 0.0, p, 0, q)
        if 0.21 * (drag / mass) ** 2 > stiffness / mass:
            k, rate = crept(stiffness / mass, drag / mass, half, q, n, place, speed, u, v, work)
            return k, rate == 0.0, rate
        k, enough = oscillated(stiffness / mass, drag / mass, half, q, n, place, speed, u, v, work)
        return k, enough, max(drag / mass, (stiffness / mass) ** 0.5)
    if stiffness > 0.0:
        rate = stiffness / drag
        combined(weight / drag, p, n, 0.0, p, 0, q)
        k, enough = relaxed(rate, half, q, n, place, u, NOTHING * drag / stiffness, work)
        return combined(1.0, q, n, -rate, u, k, v), enough, rate
    k = combined(weight / drag, p, n, 0.0, p, 0, v) + 1
    v[k] = 0.0
    antiderivative(v, n, half, u)
    u[0] += place
    return k, True, 0.0


@inner
def shorter(start, stop, near, half, rate):
    """Where an interval ends that one polynomial follows, of a motion with such a rate."""
    share = min(0.5, 4.0 / (rate * half)) if rate * half > 8.0 else 0.5
    return start + max(8 * near, int(share * (stop - start)))
