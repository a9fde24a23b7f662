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

from percuss.compiled import inlined, inner
from percuss.simulate.kernels.bounds import blur, bounds_anew, bounds_at_anchor, smooth, smooth_and_drift, smooth_bounds
from percuss.simulate.kernels.modes import below, drift, elastic, elastic_apart, reach, reach_cubic
from percuss.simulate.kernels.motion_records import AWAY, CONTACT, EPS, GRAZE, NOTHING, OPEN, TIRED, TURN

# ---- The last piece of the way to a contact: where the rate decides it, and where it does not


@inlined
def refined(table, motion, desk, here, low, high, jerk, slip):
    """The root of the gap that is unique between two times, from a time, gap, rate and acceleration near it."""
    # Returns its time, the gap's rate there, how much later than the last evaluation it is, `slip`, and the
    # evaluations.
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
    """What becomes of a gap that is within its error of the wall while its rate does not decide."""
    # CONTACT, with two times between which the gap passes 0: it comes to more than its error. GRAZE, at its summit: it
    # does not. NOTHING: neither before `horizon`. Followed by steps over which the third derivative takes no more than
    # the error. `here`: time, gap, rate and acceleration. Returns what was found, the same there, the two times,
    # `slip`, and the evaluations.
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
        df, fv, fa, slip = elastic_apart(bar, modes, z, now, desk, t)
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


# ---- The first contact after an anchor, or the proof that there is none

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
    """The flight that followed a like impact a cycle ago, or the most alike of those 1, 2 and 4 ago; 0 without any."""
    now, count, past = motion.now, motion.count, motion.past
    n, ring, best, flight = count.impacts, past.shape[0] - 1, ALIKE, 0.0
    k = count.cycle_impacts if count.cycle_impacts < ring else 0
    for i in range(4):
        if n > k > 0:
            then = past[(n - 1 - k) & ring]
            turn = abs(now.phase - then.phase)
            turn = min(turn, TURN - turn)
            # those of one chatter are near each other, and not alike
            if turn < best and (count.period - then.period) * TURN + (now.phase - then.phase) > 3.0:
                later = past[(n - k) & ring]
                best, flight = turn, (later.period - then.period) * TURN + (later.phase - then.phase)
                if i == 0:
                    break
        k = 1 << i
    return flight


@inlined
def sure_rise(size, v, a, first, jerk, wide):
    """Whether y grows for a time `wide` about one with its rate and acceleration, whatever rounding did to them."""
    return v > size.rush + size.push * first + (abs(a) + size.crush + jerk * wide) * wide


@inner
def bent_back(guess, u, v, a, jerk, near):
    """Since when u − v h + a h²/2 + jerk h³/6, h counted back from a guess, is below 0 up to `near` it; or inf."""
    # Up to some h the last term is at most that in place of its third factor: a parabola. Looked for short of the root.
    ahead = 0.5 * a + math.sqrt(0.25 * a * a + (2.0 / 3.0) * jerk * max(v, 0.0))
    far = min(1.8 * v / ahead, guess) if ahead > 0.0 else guess
    begin, end = below(u, v, max(a + jerk * far / 3.0, 0.0))
    return guess - min(end, far, guess) if begin <= near < far else math.inf


@inlined
def tried(table, motion, desk, way, bounds, guess):
    """A time worth trying: since when the gap is known to be free when it is until some time after that, or inf."""
    # Returns that time, the time tried with gap, rate and acceleration there, in what time the gap passes 0, and
    # `slip`.
    now, size = motion.now, way.size
    ds, vs, sa, first, second = smooth_and_drift(table.bar, now, desk.osc, guess)
    df, fv, fa, slip = elastic(table.bar, table.modes, motion.z, now, desk, guess)
    y, v, a = now.gap + ds + df, vs + fv, sa + fa
    wrong = abs(y) + blur(size, guess, first, second)
    width, free_from = 2.0 * wrong / v, math.inf
    if v > 0.0 and sure_rise(size, v, a, first, bounds.jerk, width):  # y grows from before to after its root …
        top = max(ds + bounds.top + wrong, 0.0)
        free_from = guess - below_since(wrong, vs - bounds.sup1, top, vs, bounds.up, width)
        if free_from > guess:  # … and by its own Taylor polynomial, with what rounding may have done to it
            slow, bent = v - size.rush - size.push * first, a + size.crush
            free_from = bent_back(guess, wrong, slow, bent, bounds.jerk, width)
    return free_from, (guess, y, v, a), width, slip


@inlined
def let_go(table, motion, desk, way, begin, horizon):
    """The end of the time for which a flight is known to be free: OPEN, and all there is at the last time looked at."""
    # CONTACT: the load pushes again, and the bar is still, or back, on the wall. NOTHING: not before the horizon.
    bar, now = table.bar, motion.now
    here, part, df, noise, slip = (0.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 0.0, 0.0), 0.0, 0.0, 0.0
    for tries in range(9):  # the ripple of a finite number of modes may still lap at the wall
        tau = begin + tries * bar.ripple
        if tau >= horizon:
            return NOTHING, here, part, df, noise, slip, tries
        part = smooth_and_drift(bar, now, desk.osc, tau)
        df, fv, fa, slip = elastic_apart(bar, table.modes, motion.z, now, desk, tau)
        here = (tau, now.gap + part[0] + df, part[1] + fv, part[2] + fa)
        noise = blur(way.size, tau, part[3], part[4])
        if here[1] + noise < 0.0:
            return OPEN, here, part, df, noise, slip, tries + 1
        if here[2] > 0.0 or tries == 8:
            return CONTACT, here, part, df, noise, slip, tries + 1
    return CONTACT, here, part, df, noise, slip, 9


@inlined
def stepped(table, motion, desk, way, bounds, here, part, df, noise, risen, free_from, horizon):
    """How far the gap is free by the smooth part with a bound of the elastic one."""
    # `part`, `df`, `noise`: the smooth part, the elastic one and the error at the time of `here`. `risen`: when the
    # bounds of S'' were taken. OPEN up to a time; CONTACT when `free_from` is reached; NOTHING before the horizon;
    # AWAY. Returns that, the time, when the smooth part was last looked at, what it was then, how often, and the
    # bounds.
    bar, now, n, size = table.bar, motion.now, table.modes.omega.shape[0], way.size
    tau, t, at, looks = here[0], here[0], here[0], 0
    u1, u2 = here[1] + noise, now.gap + part[0] + bounds.top + noise
    for _ in range(200):
        rate, first = part[1], part[3]
        step = reach(u2, rate, bounds.up)
        if n and step <= 0.0:
            step = reach(u1, rate + bounds.sup1, bounds.up)
        if at > TURN and bar.spring == 0.0:  # … or, from afar, by the drift with a bound of all that oscillates …
            far = now.gap + now.drift * first + bar.mean * part[4] + way.beat + bounds.top + noise
            if far < 0.0:
                step = max(step, reach(far, now.drift + way.pull * first, bounds.up - bar.curve))
        if not at + step > t:
            break
        t = at + step
        if math.inf > t >= free_from:
            return CONTACT, t, at, part, noise, looks, bounds, risen
        if t >= horizon:
            return NOTHING, t, at, part, noise, looks, bounds, risen
        part = smooth_and_drift(bar, now, desk.osc, t)
        at, looks, rate = t, looks + 1, part[1]
        noise = blur(size, t, part[3], part[4])
        u2 = now.gap + part[0] + bounds.top + noise
        u1 = now.gap + part[0] + df + bounds.sup1 * (t - tau) + noise
        if bar.damping * (t - risen) > 0.25:
            risen, bounds = t, smooth_bounds(bar, way, bounds, part[3])
        curve, square = bounds.curve, rate * rate
        if rate > 0.0 and -2.0 * curve * u2 < square and (n == 0 or -u2 <= bounds.top or -u2 * curve < 1e-3 * square):
            break
        if n == 0 and step < 1e-14 * t:
            break
        if bar.mean <= 0.0 and bar.spring == 0.0 and away(bar, now, u2, t):
            return AWAY, t, at, part, noise, looks, bounds, risen
    return OPEN, t, at, part, noise, looks, bounds, risen


@inlined
def looked(table, motion, desk, way, bounds, here, part, at, tau, stuck, since, risen, horizon):
    """The gap at τ, and whether its rate and its bounds there decide: CONTACT, with two times between which it is 0."""
    # `part`: the smooth part when it was last looked at, `at`. `stuck`: whether there was no way on. Otherwise GRAZE,
    # NOTHING, or OPEN. `since`, `risen`: when the bounds were taken.
    bar, now, size, behind = table.bar, motion.now, way.size, here[0]
    if at != tau:
        part = smooth_and_drift(bar, now, desk.osc, tau)
    df, fv, fa, slip = elastic(bar, table.modes, motion.z, now, desk, tau)
    y, v, a, first = now.gap + part[0] + df, part[1] + fv, part[2] + fa, part[3]
    noise = blur(size, tau, first, part[4])
    ahead, certain = math.inf, False
    if y >= 0.0 and v > 0.0:  # the bounds from before hold for the time before as well
        ahead = 2.0 * (y + noise) / v
        certain = sure_rise(size, v, a, first, bounds.jerk, ahead)
    if table.modes.creeping.shape[0] > 0 or bar.wane * (tau - since) > 0.25:  # damping has taken its part
        since, risen = tau, tau
        bounds = bounds_anew(table, motion, desk, way, tau, first)
    if y < 0.0 and v > 0.0:
        ahead = 2.0 * (noise - y) / v
        certain = sure_rise(size, v, a, first, bounds.jerk, ahead)
    here, found, low, high, more = (tau, y, v, a), OPEN, 0.0, math.inf, 0
    if certain:  # y grows until it has surely passed 0
        found = CONTACT
        low, high = (tau, tau + ahead) if y < 0.0 else (max(tau - ahead, behind), tau)
    elif y > -noise or stuck:
        found, here, low, high, slip, more = approach(
            table, motion, desk, here, behind, noise, size, bounds.jerk, horizon, slip
        )
    return found, here, part, df, noise, (low, high), bounds, since, risen, slip, more + 1


@inlined
def next_contact(table, motion, desk, on_wall, begin, guess, horizon, limit):
    """The first contact after the anchor, or the proof that there is none before `horizon`."""
    # `begin` > 0: the flight up to there is known to be free. `guess` > 0: a time worth trying. Returns what was found,
    # its time, the gap's rate there, the number of evaluations of the modal sum, how much later than the last one the
    # contact is, and what `phasors` said.
    now = motion.now
    way, bounds = bounds_at_anchor(table, motion, desk)
    here, part = (0.0, now.gap, now.gap_rate, now.acceleration), (0.0, now.smooth_rate, 0.0, 0.0, 0.0)
    df, noise = 0.0, 0.0 if on_wall else way.size.at
    evaluations, looks, slip, since, risen, free_from = 0, 0, 0.0, 0.0, 0.0, math.inf
    there, width, span = here, 0.0, (0.0, math.inf)
    if 0.0 < guess < horizon:
        free_from, there, width, slip = tried(table, motion, desk, way, bounds, guess)
        evaluations = 1
    elif begin > 0.0:
        found, here, part, df, noise, slip, evaluations = let_go(table, motion, desk, way, begin, horizon)
        if found == NOTHING:
            return NOTHING, horizon, 0.0, evaluations, 0.0, 0.0
        if found == CONTACT:
            return CONTACT, here[0], max(here[2], 0.0), evaluations, 0.0, slip
    while True:
        found, t, at, part, noise, more, bounds, risen = stepped(
            table, motion, desk, way, bounds, here, part, df, noise, risen, free_from, horizon
        )
        looks += more
        if found == OPEN:
            if evaluations > 1 or not t > here[0]:  # … and by its own Taylor polynomial
                fall = min(here[1] + noise, 0.0)
                t = max(t, here[0] + reach_cubic(fall, here[2], here[3], bounds.jerk, bounds.up + bounds.sup2))
            if t >= horizon:
                return NOTHING, horizon, 0.0, evaluations + looks, 0.0, 0.0
            if t >= free_from:
                found = CONTACT
        if found == CONTACT:
            here, span = there, (guess, guess + width) if there[1] < 0.0 else (max(guess - width, 0.0), guess)
        elif found == OPEN:
            stuck = not t > here[0]
            if stuck:
                t = here[0] + EPS * max(here[0], 1e-300)
            found, here, part, df, noise, span, bounds, since, risen, slip, more = looked(
                table, motion, desk, way, bounds, here, part, at, t, stuck, since, risen, horizon
            )
            evaluations, free_from = evaluations + more, math.inf  # the phasors have moved on
        if found == CONTACT:
            tau, speed, late, slip, more = refined(table, motion, desk, here, span[0], span[1], bounds.jerk, slip)
            evaluations += more
            if tau <= horizon:
                return CONTACT, tau, speed, evaluations + looks, late, slip
            found = NOTHING
        if found == NOTHING:
            return NOTHING, horizon, 0.0, evaluations + looks, 0.0, 0.0
        if found == GRAZE:
            return GRAZE, here[0], 0.0, evaluations + looks, math.inf, 0.0
        if found == AWAY:
            return AWAY, t, 0.0, evaluations + looks, 0.0, 0.0
        if evaluations + looks >= limit:
            return TIRED, here[0], here[2], evaluations + looks, 0.0, 0.0


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
