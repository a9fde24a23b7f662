"""The first contact after an anchor, or the proof that there is none.

Let S be the gap less the free elastic part f. S and S' are cheap and |S''| has a known bound; |f|, |f'|, |f''|, |f‴|
are bounded by sums of amplitudes. From each anchor the gap is below the least of

    S + sup|f|,    S + f + sup|f'| h,    y + y'h + y''h²/2 + sup|y‴| h³/6,

each of which is stepped over with the bound of its own curvature, and never past its first root. The bounds fade with
the motion: they are taken anew as damping takes the free parts away, while the anchor stays. The contact itself is
accepted where y' exceeds what the curvature can take back before y has reached 0; the root is then unique between two
times, and Newton's method (Halley's form), held between them, converges to it. What rounding cannot decide, by the
error of what was really summed (`blur`), is returned as a graze. A motion that nearly repeats is spared the steps: the
flight after a like impact is tried first, and the same bounds, taken forward from the anchor and backward from there,
must leave no time between them.
"""

from __future__ import annotations

import math

from percuss.simulate.kernels.bounds import ringing, ringing_left
from percuss.simulate.kernels.codes import AWAY, CONTACT, EPS, GRAZE, NOTHING, POWERS, TIRED, TURN
from percuss.simulate.kernels.compiled import inlined, inner
from percuss.simulate.kernels.creeping import creeping
from percuss.simulate.kernels.elementary import below, drift, reach, reach_cubic
from percuss.simulate.kernels.modes import elastic
from percuss.simulate.kernels.rounding import blur, blur_of
from percuss.simulate.kernels.smooth import smooth_and_drift
from percuss.simulate.kernels.touch import approach, refined

ALIKE = 1e-2  # phases of impacts after which the flight may be alike


@inlined
def below_since(u, v, top, speed, m, near):
    """Up to which h one of u − v h + m h²/2 and top − speed h + m h²/2 is below 0 from `near` on; −1: not there."""
    first, last = below(u, v, m)
    if not first <= near:
        return -1.0
    first, end = below(top, speed, m)
    return max(last, end) if first <= last else last


@inlined
def like_flight(motion):
    """The flight that followed the most alike of the impacts 1, 2 and 4 before this one; 0 when none is like it."""
    now, count, past = motion.now, motion.count, motion.past
    n, ring, best, flight = count.impacts, past.shape[0] - 1, ALIKE, 0.0
    for k in (1, 2, 4):
        if n > k:
            i, j = (n - 1 - k) & ring, (n - k) & ring
            turn = abs(now.phase - past[i].phase)
            turn = min(turn, TURN - turn)
            if turn < best:
                best, flight = turn, (past[j].period - past[i].period) * TURN + (past[j].phase - past[i].phase)
    return flight


@inlined
def bounds_anew(bar, modes, motion, desk, ring, tau):
    """Bounds at τ: of the oscillating part f, of how much more the creeping one comes to, and of f', f'', f‴ of both.

    `ring`: those of the oscillating part at the anchor.
    """
    z, work = motion.z, desk
    if bar.law == POWERS:
        fade = math.exp(-bar.half * tau) * (1.0 + 1e-12)
        left, left1, left2, left3 = ring[0] * fade, ring[1] * fade, ring[2] * fade, ring[3] * fade
    else:
        grown = 1.0 + 1e-12
        left, left1, left2, left3 = ringing_left(modes, z, work)
        left, left1, left2, left3 = left * grown, left1 * grown, left2 * grown, left3 * grown
    most = 0.0
    if modes.creeping.shape[0]:
        most, sup1, sup2, sup3 = creeping(modes, z, work, tau)
        left1, left2, left3 = sup1 + left1, sup2 + left2, sup3 + left3
    return left, most, left1, left2, left3


@inlined
def next_contact(table, motion, desk, on_wall, begin, guess, horizon, limit):
    """The first contact after the anchor, or the proof that there is none before `horizon`.

    `begin` > 0: the flight up to there is known to be free. `guess` > 0: a time worth trying. Returns what was found,
    its time, the gap's rate there, the number of evaluations of the modal sum, how much later than the last one the
    contact is, and what `phasors` said.
    """
    bar, modes, now, z, osc = table.bar, table.modes, motion.now, motion.z, desk.osc
    n, d, creeps = modes.omega.shape[0], bar.damping, modes.creeping.shape[0] > 0
    y0, free = now.gap, now.free_oscillating
    pull = bar.mean - d * now.drift
    curve, up = bar.curve + abs(pull), bar.curve + max(pull, 0.0)
    ring = (now.sup, now.sup1, now.sup2, now.sup3)
    most, sup1, sup2, sup3 = 0.0, now.sup1, now.sup2, now.sup3
    if creeps:
        grown = 1.0 + 1e-12
        rung, rung1, rung2, rung3 = ringing(modes, z)
        ring = (rung * grown, rung1 * grown, rung2 * grown, rung3 * grown)
        most, sup1, sup2, sup3 = creeping(modes, z, desk, 0.0)
        sup1, sup2, sup3 = ring[1] + sup1, ring[2] + sup2, ring[3] + sup3
    top, jerk = ring[0] - free + most, bar.jerk + d * abs(pull) + sup3
    size = blur_of(bar, modes, motion, osc, ring[1], ring[2], curve)
    beat = bar.reach
    for k in range(osc.shape[1]):
        beat -= osc[0, k]
    tau, y, v, a = 0.0, y0, now.gap_rate, now.acceleration
    ds, vs, df, first, second = 0.0, now.smooth_rate, 0.0, 0.0, 0.0
    noise = 0.0 if on_wall else size.at
    evaluations, looks, slip, since, risen = 0, 0, 0.0, 0.0, 0.0
    low, high, behind = 0.0, math.inf, 0.0
    free_from, y_there, v_there, a_there, width = math.inf, 0.0, 0.0, 0.0, 0.0
    if 0.0 < guess < horizon:
        ds, vs, sa, first, second = smooth_and_drift(bar, now, osc, guess)
        df, fv, fa, slip = elastic(bar, modes, z, now, desk, guess)
        evaluations += 1
        y_there, v_there, a_there = y0 + ds + df, vs + fv, sa + fa
        wrong = abs(y_there) + blur(size, guess, first, second)
        width = 2.0 * wrong / v_there
        # y grows from before to after its root …
        if (
            v_there > 0.0
            and v_there > size.rush + size.push * first + (abs(a_there) + size.crush + jerk * width) * width
        ):
            free_from = guess - below_since(wrong, vs - sup1, max(ds + top + wrong, 0.0), vs, up, width)
            if free_from > guess:
                free_from = math.inf
        ds, vs, df, first, second = 0.0, now.smooth_rate, 0.0, 0.0, 0.0
    elif begin > 0.0:
        for tries in range(9):  # the ripple of a finite number of modes may still lap at the wall
            tau = begin + tries * bar.ripple
            if tau >= horizon:
                return NOTHING, horizon, 0.0, evaluations + looks, 0.0, 0.0
            ds, vs, sa, first, second = smooth_and_drift(bar, now, osc, tau)
            df, fv, fa, slip = elastic(bar, modes, z, now, desk, tau)
            evaluations += 1
            y, v, a = y0 + ds + df, vs + fv, sa + fa
            noise = blur(size, tau, first, second)
            if y + noise < 0.0:
                break
            if v > 0.0 or tries == 8:  # the load pushes again: the bar is still, or back, on the wall
                return CONTACT, tau, max(v, 0.0), evaluations + looks, 0.0, slip
    while True:
        found = NOTHING
        # how far the gap is free by the smooth part with a bound of the elastic one …
        t, at, u1, u2 = tau, tau, y + noise, y0 + ds + top + noise
        for _ in range(200):
            step = reach(u2, vs, up)
            if n and step <= 0.0:
                step = reach(u1, vs + sup1, up)
            if at > TURN:  # … or, from afar, by the drift with a bound of all that oscillates …
                far = y0 + now.drift * first + bar.mean * second + beat + top + noise
                if far < 0.0:
                    step = max(step, reach(far, now.drift + pull * first, up - bar.curve))
            if not at + step > t:
                break
            gain = step
            t = at + step
            if math.inf > t >= free_from:
                found = CONTACT
                break
            if t >= horizon:
                return NOTHING, horizon, 0.0, evaluations + looks, 0.0, 0.0
            ds, vs, sa, first, second = smooth_and_drift(bar, now, osc, t)
            at, looks = t, looks + 1
            noise = blur(size, t, first, second)
            u2 = y0 + ds + top + noise
            u1 = y0 + ds + df + sup1 * (t - tau) + noise
            if d * (t - risen) > 0.25:  # what is left of the drift's acceleration
                risen, left = t, pull * (1.0 - d * first)
                curve, up = bar.curve + abs(left), bar.curve + max(left, 0.0) + 4.0 * EPS * abs(pull)
            if vs > 0.0 and -2.0 * curve * u2 < vs * vs and (n == 0 or -u2 <= top or -u2 * curve < 1e-3 * vs * vs):
                break
            if n == 0 and gain < 1e-14 * t:
                break
            if bar.mean <= 0.0 and away(bar, now, u2, t):
                return AWAY, t, 0.0, evaluations + looks, 0.0, 0.0
        if found == CONTACT:
            tau, y, v, a = guess, y_there, v_there, a_there
            low, high = (guess, guess + width) if y < 0.0 else (max(guess - width, 0.0), guess)
        else:
            # … and by its own Taylor polynomial
            if evaluations > 1 or not t > tau:
                t = max(t, tau + reach_cubic(min(y + noise, 0.0), v, a, jerk, up + sup2))
            if t >= horizon:
                return NOTHING, horizon, 0.0, evaluations + looks, 0.0, 0.0
            stuck = not t > tau
            if stuck:
                t = tau + EPS * max(tau, 1e-300)
            behind, tau = tau, t
            if at != tau:
                ds, vs, sa, first, second = smooth_and_drift(bar, now, osc, tau)
            df, fv, fa, slip = elastic(bar, modes, z, now, desk, tau)
            evaluations += 1
            y, v, a = y0 + ds + df, vs + fv, sa + fa
            noise = blur(size, tau, first, second)
            free_from = math.inf  # the phasors have moved on
            ahead, certain = math.inf, False
            if y >= 0.0 and v > 0.0:  # the bounds from before hold for the time before as well
                ahead = 2.0 * (y + noise) / v
                certain = v > size.rush + size.push * first + (abs(a) + size.crush + jerk * ahead) * ahead
            if creeps or bar.wane * (tau - since) > 0.25:  # the bounds anew: damping has taken its part
                since, risen, left = tau, tau, pull * (1.0 - d * first)
                curve, up = bar.curve + abs(left), bar.curve + max(left, 0.0) + 4.0 * EPS * abs(pull)
                rung, most, sup1, sup2, sup3 = bounds_anew(bar, modes, motion, desk, ring, tau)
                top = rung - free + most
                jerk = bar.jerk + d * (abs(left) + 4.0 * EPS * abs(pull)) + sup3
            if y < 0.0 and v > 0.0:
                ahead = 2.0 * (noise - y) / v
                certain = v > size.rush + size.push * first + (abs(a) + size.crush + jerk * ahead) * ahead
            if certain:  # y grows until it has surely passed 0
                found = CONTACT
                low, high = (tau, tau + ahead) if y < 0.0 else (max(tau - ahead, behind), tau)
            elif y > -noise or stuck:
                here = (tau, y, v, a)
                found, here, low, high, slip, more = approach(
                    table, motion, desk, here, behind, noise, size, jerk, horizon, slip
                )
                tau, y, v, a = here
                evaluations += more
                if found == GRAZE:
                    return GRAZE, tau, 0.0, evaluations + looks, math.inf, 0.0
                if found == NOTHING:
                    return NOTHING, horizon, 0.0, evaluations + looks, 0.0, 0.0
        if found == CONTACT:
            tau, speed, late, slip, more = refined(table, motion, desk, (tau, y, v, a), low, high, jerk, slip)
            evaluations += more
            if tau > horizon:
                return NOTHING, horizon, 0.0, evaluations + looks, 0.0, 0.0
            return CONTACT, tau, speed, evaluations + looks, late, slip
        if evaluations + looks >= limit:
            return TIRED, tau, v, evaluations + looks, 0.0, 0.0


@inner
def away(bar, now, u, tau):
    """Whether the bar has left for good: no later S can exceed `-top`, for a mean load that does not push."""
    first, _ = drift(bar.damping, tau)
    fade = 1.0 - bar.damping * first
    speed = now.drift * fade + bar.mean * first  # of the drift, which only falls while the mean load pulls
    coming = 0.0
    if speed > 0.0:
        if bar.damping == 0.0:
            if bar.mean == 0.0:
                return False
            coming = 0.5 * speed * speed / -bar.mean
        else:
            coming = speed / bar.damping
    return u + coming + 2.0 * bar.reach < 0.0
