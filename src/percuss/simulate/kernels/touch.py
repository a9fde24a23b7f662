"""The last piece of the way to a contact: where the rate decides it, and where it does not."""

from __future__ import annotations

import math

from percuss.compiled import inlined, inner
from percuss.simulate.kernels.codes import CONTACT, EPS, GRAZE, NOTHING
from percuss.simulate.kernels.modes import elastic
from percuss.simulate.kernels.rounding import blur
from percuss.simulate.kernels.smooth import smooth, smooth_and_drift


@inlined
def refined(table, motion, desk, here, low, high, jerk, slip):
    """The root of the gap that is unique between two times, from a time, gap, rate and acceleration near it.

    Returns its time, the gap's rate there, how much later than the last evaluation it is, `slip`, and the evaluations.
    """
    bar, modes, now, z = table.bar, table.modes, motion.now, motion.z
    tau, y, v, a = here
    bend, h, evaluations = 0.0, 0.0, 0  # y‴, from the last two evaluations
    for i in range(60):
        root = math.sqrt(max(v * v - 2.0 * a * y, 0.0))
        h = -2.0 * y / (v + root) if v > 0.0 else math.inf  # to the root of the local parabola
        if low <= tau + h <= high:
            close = h * h * jerk < 16.0 * EPS * v
            near = abs(h) <= 4.0 * EPS * tau or abs(h * h * h) * (jerk + a * a / v) < EPS * min(tau, 8.0) * v
            if close or (i and near):
                return tau + h, max(v + h * (a + 0.5 * h * bend), 0.0), h, slip, evaluations
            tau += h
        else:  # it would leave the two times between which y passes 0
            h = 0.5 * (low + high) - tau
            tau += h
            if high - low <= 4.0 * EPS * high:
                break
        before = a
        ds, vs, sa = smooth(bar, now, desk.osc, tau)
        df, fv, fa, slip = elastic(bar, modes, z, now, desk, tau)
        evaluations += 1
        y, v, a = now.gap + ds + df, vs + fv, sa + fa
        bend = (a - before) / h if h != 0.0 else 0.0
        if y < 0.0:
            low = tau
        else:
            high = tau
    return tau, max(v, 0.0), 0.0, slip, evaluations  # the last evaluation was made there


@inner
def approach(table, motion, desk, here, behind, noise, size, jerk, horizon, slip):
    """What becomes of a gap that is within its error of the wall while its rate does not decide.

    CONTACT, with two times between which the gap passes 0: it comes to more than its error. GRAZE, at its summit: it
    does not. NOTHING: neither before `horizon`. Followed by steps over which the third derivative takes no more than
    the error. `here`: time, gap, rate and acceleration. Returns what was found, the same there, the two times, `slip`,
    and the evaluations.
    """
    bar, modes, now, z, osc = table.bar, table.modes, motion.now, motion.z, desk.osc
    tau, y, v, a = here
    if v <= 0.0:
        return GRAZE, (tau, y, v, a), behind, tau, slip, 0
    if y > noise:
        return CONTACT, (tau, y, v, a), behind, tau, slip, 0
    low = tau if y < 0.0 else behind
    last, last_v, falls = math.inf, 0.0, False  # the rate is known to be 0 before `last`
    for i in range(200):
        if falls:  # between the two rates
            h = (last - tau) * min(max(v / (v - last_v), 0.1), 0.9)
        else:
            h = min((6.0 * noise / jerk) ** (1.0 / 3.0), -v / a if a < 0.0 else 2.0 * (abs(y) + noise) / v)
        t = min(tau + h, horizon)
        if not t > tau or (falls and not t < last):  # within the last digit of the time
            top = falls or -v > 4.0 * EPS * tau * a
            return (GRAZE if top else CONTACT), (tau, y, v, a), low, tau, slip, i
        ds, vs, sa, first, second = smooth_and_drift(bar, now, osc, t)
        df, fv, fa, slip = elastic(bar, modes, z, now, desk, t)
        y_t, v_t, a_t, noise = now.gap + ds + df, vs + fv, sa + fa, blur(size, t, first, second)
        if y_t > noise:
            return CONTACT, (t, y_t, v_t, a_t), low, t, slip, i + 1
        if t >= horizon:
            return NOTHING, (t, y_t, v_t, a_t), low, t, slip, i + 1
        if v_t <= 0.0:
            last, last_v, falls = t, v_t, True
            if (t - tau) * v < 0.1 * noise or y_t < -noise < y:
                return GRAZE, (tau + (t - tau) * (v / (v - v_t)), y, v, a), low, t, slip, i + 1
        else:
            if y_t < 0.0:
                low = t
            if falls and (last - t) * v_t < 0.1 * noise:
                return GRAZE, (t + (last - t) * (v_t / (v_t - last_v)), y_t, v_t, a_t), low, t, slip, i + 1
            tau, y, v, a = t, y_t, v_t, a_t
    return GRAZE, (tau, y, v, a), low, tau, slip, 200
