"""What joins the sections: the driven end, steps with or without a mass, the face, the far end."""

from __future__ import annotations

from percuss.blow.kernels.chebyshev import (
    NEVER,
    antiderivative,
    chopped,
    combined,
    first_above,
    greatest,
    left,
    restricted,
    right,
)
from percuss.blow.kernels.rows import arriving_until, has_room, read, write
from percuss.blow.kernels.wave_records import (
    ENDLESS,
    FAR,
    FREE,
    FULL,
    LOAD,
    MOST_DEGREE,
    NOTHING,
    OFF,
    PAUSED,
    REACHED,
    ROCK,
    TOUCH,
    UNLOAD,
    WALL,
)
from percuss.compiled import entry, inlined, inner

# ---- The struck face: two ends that can push each other and never pull
#
# f arrives in the striker, g in the rod. The sign of f − g is that of the force while the faces are closed, and that of
# the speed at which they close while they touch; contact is decided by it at every instant, without any impulse.

MOST_TURNS = 6  # meetings and partings at one instant
HOVER = 8  # times the shortest time
SHUT = 4e-15  # a gap, in the striker's speed times its transit time, that is none


@inner
def at_face(problem, waves, state, start, end):
    """Carry the face on from start to end, or to the first meeting or parting before; where it stops."""
    now, work, here = state.now[0], state.work, problem.striker
    into, back = 2 * here - 2, 2 * here + 1
    f, g, d, h = work[6], work[7], work[8], work[9]
    wall = problem.end == WALL
    n = read(problem, waves, into, start, end, f, work)
    m = 0
    if wall:
        g[0] = 0.0
    else:
        m = read(problem, waves, back, start, end, g, work)
    k = combined(1.0, f, n, -1.0, g, m, d)
    half = 0.5 * (end - start) * problem.tick
    place, when = NEVER, end
    for turn in range(MOST_TURNS):
        place = _turn(now, d, k, half, h, work)
        if turn == MOST_TURNS - 1 and place != NEVER:
            # rounding has a say in what comes next: a little of it is done without looking
            place = NEVER
            if end - start <= HOVER * problem.near:
                break
            high = 2.0 * HOVER * problem.near / (end - start) - 1.0
            end = start + HOVER * problem.near
            restricted(f, n, -1.0, high, f, work)
            restricted(g, m, -1.0, high, g, work)
            restricted(d, k, -1.0, high, d, work)
            half = 0.5 * (end - start) * problem.tick
        if place == NEVER:
            break
        when = start + round(0.5 * (1.0 + place) * (end - start))
        if when - start > problem.near:
            if end - when <= problem.near:
                place, when = 1.0, end
            break
        now.gap, now.closed = 0.0, 1 - now.closed
    stop = end if place == NEVER else when
    if stop < end:
        high = 2.0 * (stop - start) / (end - start) - 1.0
        restricted(f, n, -1.0, high, f, work)
        restricted(g, m, -1.0, high, g, work)
        restricted(d, k, -1.0, high, d, work)
    _leave(problem, waves, state, start, stop, f, n, g, m, d, k)
    if now.closed == 0 and place == NEVER:
        antiderivative(d, k, half, h)
        moved = now.gap - 2.0 * right(h, k + 1)
        now.arriving = 0
        if moved <= SHUT:
            now.arriving = 1 if now.gap > 0.0 and moved < now.gap else 0
            moved = 0.0
        now.gap = moved
    elif place != NEVER:
        now.arriving = 1 if now.gap > 0.0 else 0
        now.gap, now.closed = 0.0, 1 - now.closed
        if now.arriving == 1:  # whether they meet there is for the next piece to say
            now.closed = 0
    return stop


@inner
def _turn(now, d, k, half, h, work):
    """Where the faces meet or part in this interval, or NEVER."""
    # With the gap 0 it is first settled whether they are closed now: by the sign of f − g, and where that is 0, by the
    # sign it has next. Faces that touch, and come together at no speed, do not meet, however long that goes on.
    meets = 0.0
    if now.gap == 0.0:
        begins = left(d, k)
        if begins > TOUCH:
            now.closed = 1
        elif begins < -TOUCH:
            now.closed = 0
        elif now.arriving == 1 or now.closed == 0 or k == 0:
            combined(-1.0, d, k, 0.0, d, 0, h)
            meets = first_above(d, k, TOUCH, work)
            now.closed = 1 if meets < first_above(h, k, TOUCH, work) else 0
        if now.arriving == 1 and now.closed == 0:
            now.grazes += 1
        now.arriving = 0
    if now.closed == 1:
        combined(-1.0, d, k, 0.0, d, 0, h)
        return first_above(h, k, TOUCH, work)
    if meets == NEVER:
        return NEVER
    antiderivative(d, k, 2.0 * half, h)  # 2 ∫(f − g): how far they have come together
    h[0] -= now.gap
    return first_above(h, k + 1, SHUT, work)


@inner
def _leave(problem, waves, state, start, stop, f, n, g, m, d, k):
    """Write what leaves the face, and the force; note whether the faces have met or parted."""
    now, here, out = state.now[0], problem.striker, state.work[9]
    row, trace = 2 * here - 1, 2 * problem.impedance.size
    if now.closed != now.pressed:
        state.contact[now.noted] = start
        now.noted += 1
        now.pressed = now.closed
    za = problem.impedance[here - 1]
    if problem.end == WALL:
        sign = -1.0 if now.closed == 1 else 1.0
        write(waves, row, start, stop, out, combined(sign, f, n, 0.0, f, 0, out), state.work)
        write(waves, trace, start, stop, out, combined(2.0 * za * now.closed, f, n, 0.0, f, 0, out), state.work)
        return
    zb = problem.impedance[here]
    if now.closed == 1:
        r = (za - zb) / (za + zb)
        write(waves, row, start, stop, out, combined(1.0, g, m, r, d, k, out), state.work)
        write(waves, row + 1, start, stop, out, combined(1.0, f, n, r, d, k, out), state.work)
        write(waves, trace, start, stop, out, combined(2.0 * za * zb / (za + zb), d, k, 0.0, d, 0, out), state.work)
    else:
        write(waves, row, start, stop, f, n, state.work)
        write(waves, row + 1, start, stop, g, m, state.work)
        out[0] = 0.0
        write(waves, trace, start, stop, out, 0, state.work)


# ---- Linear equations of motion with constant coefficients over one interval, driven by a polynomial, spectrally
#
# In Chebyshev coefficients w' = r becomes w_k = (r_{k−1} − r_{k+1})/2k (r_0 doubled), three terms a row. The rows are
# solved from the last one up, w_k = α_k w_{k−1} + β_k, which loses no digits for decaying motions however fast they
# decay; the value at the start then gives w_0.


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


# ---- The bit, with or without a mass, and the rock in front of it: loading, unloading and reloading, apart
#
# m v' + Z v + F = 2 Z f, u' = v, g = v − f. The force never jumps, so that rounding cannot decide between branches that
# differ; every change of branch is a zero of a polynomial.

MOST_BRANCHES = 8  # changes of branch at one instant


@inner
def at_rock(problem, waves, state, start, end):
    """Carry the bit on from start to end, or less far; where it stops."""
    now, work = state.now[0], state.work
    row = 2 * problem.impedance.size - 2
    f, u, v, p = work[6], work[7], work[8], work[9]
    n = read(problem, waves, row, start, end, f, work)
    stop, when, place, k = end, end, NEVER, 0
    for turn in range(MOST_BRANCHES):
        stop, n, k = _moved(problem, now, start, stop, f, n, u, v, work)
        if turn == MOST_BRANCHES - 1:
            place = NEVER
            break
        if turn == MOST_BRANCHES - 2 and stop - start > HOVER * problem.near:  # rounding has a say in what comes next
            high = 2.0 * HOVER * problem.near / (stop - start) - 1.0
            stop = start + HOVER * problem.near
            restricted(f, n, -1.0, high, f, work)
            continue
        place = _branch_turns(problem, now, u, v, k, p, work)
        if place == NEVER:
            break
        when = start + round(0.5 * (1.0 + place) * (stop - start))
        if when - start > problem.near:
            if stop - when <= problem.near:
                place, when = 1.0, stop
            break
        _changed(problem, now, False, 0.0)
    if place != NEVER and when < stop:
        high = 2.0 * (when - start) / (stop - start) - 1.0
        restricted(f, n, -1.0, high, f, work)
        restricted(u, k, -1.0, high, u, work)
        restricted(v, k, -1.0, high, v, work)
        stop = when
    _bit_leaves(problem, waves, state, now, start, stop, f, n, u, v, k, p)
    now.bit_velocity = right(v, k)
    now.penetration = right(u, k) + _relaxed_at(problem, now)
    if place != NEVER:
        _changed(problem, now, True, now.penetration)
    elif now.branch == LOAD:
        now.greatest = max(now.greatest, now.penetration)
        now.penetration = now.greatest
    return stop


@inner
def _relaxed_at(problem, now):
    """The penetration at which the branch has no force."""
    return 0.0 if now.branch == LOAD else (1.0 - problem.ratio) * now.greatest


@inner
def _stiffness(problem, now):
    return problem.stiffness if now.branch == LOAD else problem.unloading if now.branch == UNLOAD else 0.0


@inner
def _moved(problem, now, start, stop, f, n, u, v, work):
    """Penetration, from where the branch has no force, and velocity; how far, and the degrees of f and these."""
    # Where one polynomial cannot follow, the interval is made shorter, f with it.
    z, m = problem.impedance[-1], problem.joint_mass[-1]
    stiff, place, q = _stiffness(problem, now), now.penetration - _relaxed_at(problem, now), work[10]
    while True:
        half = 0.5 * (stop - start) * problem.tick
        enough = True
        if m > 0.0:
            combined(2.0 * z / m, f, n, 0.0, f, 0, q)
            if 0.21 * (z / m) ** 2 > stiff / m:
                k, rate = crept(stiff / m, z / m, half, q, n, place, now.bit_velocity, u, v, work)
                enough = rate == 0.0
            else:
                k, enough = oscillated(stiff / m, z / m, half, q, n, place, now.bit_velocity, u, v, work)
                rate = max(z / m, (stiff / m) ** 0.5)
        elif stiff > 0.0:
            combined(2.0, f, n, 0.0, f, 0, q)
            k, enough = relaxed(stiff / z, half, q, n, place, u, NOTHING * z / stiff, work)
            k = combined(1.0, q, n, -stiff / z, u, k, v)
            rate = stiff / z
        else:
            k, rate = combined(2.0, f, n, 0.0, f, 0, v) + 1, 0.0
            v[k] = 0.0
            antiderivative(v, n, half, u)
            u[0] += place
        if enough or stop - start <= 16 * problem.near:
            return stop, n, k
        share = min(0.5, 4.0 / (rate * half)) if rate * half > 8.0 else 0.5
        after = start + max(8 * problem.near, int(share * (stop - start)))
        restricted(f, n, -1.0, 2.0 * (after - start) / (stop - start) - 1.0, f, work)
        stop = after


@inner
def _branch_turns(problem, now, u, v, k, p, work):
    """Where the branch ends in this interval, or NEVER. A branch that is wrong from the start ends at −1."""
    if problem.end == FREE:
        return NEVER
    least = TOUCH / max(1.0, problem.unloading) + 2e-15 * (now.greatest + greatest(u, k))
    if now.branch == LOAD:
        combined(-1.0, v, k, 0.0, v, 0, p)
        return first_above(p, k, TOUCH, work)
    if now.branch == OFF:
        return first_above(u, k, least, work)
    span = problem.ratio * now.greatest
    u[0] -= span
    deeper = first_above(u, k, least, work)
    u[0] += span
    combined(-1.0, u, k, 0.0, u, 0, p)
    apart = first_above(p, k, least, work)
    return min(deeper, apart)


@inner
def _changed(problem, now, later, penetration):
    """The next branch, with the penetration set to where they meet."""
    residual = (1.0 - problem.ratio) * now.greatest
    if now.branch == LOAD:
        now.branch = UNLOAD if now.greatest > 0.0 or penetration > 0.0 else OFF
        if later:
            now.greatest = max(now.greatest, penetration)
            now.bit_velocity = 0.0
        now.penetration = now.greatest
    elif now.branch == OFF:
        now.penetration = residual
        now.branch = UNLOAD if now.greatest > 0.0 else LOAD
    elif 2.0 * now.penetration > residual + now.greatest:
        now.penetration, now.branch = now.greatest, LOAD
    else:
        now.penetration, now.branch = residual, OFF


@inner
def _bit_leaves(problem, waves, state, now, start, stop, f, n, u, v, k, p):
    """Write the wave that goes back, the penetration and the force."""
    row, trace = 2 * problem.impedance.size - 1, 2 * problem.impedance.size
    write(waves, row, start, stop, p, combined(1.0, v, k, -1.0, f, n, p), state.work)
    m = combined(_stiffness(problem, now), u, k, 0.0, u, 0, p)
    write(waves, trace + 2, start, stop, p, m if _stiffness(problem, now) > 0.0 else 0, state.work)
    u[0] += _relaxed_at(problem, now)
    write(waves, trace + 1, start, stop, u, k, state.work)
    u[0] -= _relaxed_at(problem, now)


# ---- What joins the sections: the driven end, steps with or without a mass, the face, the far end

STAYS, MOVES, FILLED = range(3)


@inlined
def carried_on(problem, waves, state, node, whole):
    """Carry a node on by one piece; with `whole`, only where that cuts no piece because others are not known yet."""
    time, near, sections = state.time[node], problem.near, problem.impedance.size
    from_left, from_right = 2 * node - 2, 2 * node + 1
    has_left, has_right = node > 0, node < sections
    if not _all_rooms(problem, waves, state, node):
        return FILLED
    known, end = FAR, FAR
    cut_known = True  # whether what limits the step can still be extended
    bent_end = 0  # the latest end of a piece that is no constant
    if has_left:
        end, known, bent_end, cut_known = _limits(problem, waves, from_left, time, end, known, bent_end, cut_known)
    if has_right:
        end, known, bent_end, cut_known = _limits(problem, waves, from_right, time, end, known, bent_end, cut_known)
    force, until = _load(problem, node, time)
    end = min(end, until, problem.until)
    if end - time <= near and end < problem.until:
        return STAYS
    if problem.until - end <= near:
        end = problem.until
    moving = problem.joint_mass[node] > 0.0 or (node == sections and problem.end == ROCK)
    if whole and end == known and end < problem.until and cut_known and (bent_end > end + near or moving):
        return STAYS
    if node == 0:
        stop = _at_driven_end(problem, waves, state, time, end, force)
    elif node == problem.striker:
        stop = at_face(problem, waves, state, time, end)
    elif node < sections:
        if problem.joint_mass[node] > 0.0:
            stop = _at_joint(problem, waves, state, node, time, end, force)
        else:
            stop = _at_step(problem, waves, state, node, time, end, force)
    elif problem.end == ROCK or problem.joint_mass[node] > 0.0:
        stop = at_rock(problem, waves, state, time, end)
    else:
        out = state.work[6]
        n = read(problem, waves, from_left, time, end, out, state.work)
        sign = 1.0 if problem.end == FREE else -1.0
        write(waves, from_left + 1, time, end, out, combined(sign, out, n, 0.0, out, 0, out), state.work)
        stop = end
    state.time[node] = stop
    return MOVES


@inner
def last_node(problem):
    """The number of the last node that anything happens at."""
    size = problem.impedance.size
    return size if problem.end != ENDLESS else size - 1


@inner
def _all_rooms(problem, waves, state, node):
    sections = problem.impedance.size
    rooms = (node == 0 or has_room(waves, 2 * node - 1)) and (node == sections or has_room(waves, 2 * node))
    if node == problem.striker:
        return rooms and has_room(waves, 2 * sections) and state.now[0].noted + 2 < state.contact.size
    if node == sections:
        return rooms and has_room(waves, 2 * sections + 1) and has_room(waves, 2 * sections + 2)
    return rooms


@inner
def _limits(problem, waves, row, time, end, known, bent_end, constant):
    until = arriving_until(problem, waves, row, time)
    whole = waves.known[row] + problem.transit[row >> 1]
    bent = waves.degree[row, waves.cursor[row]] > 0
    if bent:
        bent_end = max(bent_end, until)
    last = waves.cursor[row] == waves.pieces[row] - 1
    if until < end:
        constant = last and not bent
    return min(end, until), min(known, whole), bent_end, constant


@inner
def _load(problem, node, time):
    """The force of the load at a node, and until when it holds."""
    force = 0.0
    if node != problem.load_node:
        return force, FAR
    for k in range(problem.load_start.size):
        if problem.load_start[k] > time + problem.near:
            return force, problem.load_start[k]
        force = problem.load_force[k]
    return force, FAR


@inner
def _at_driven_end(problem, waves, state, start, end, force):
    out = state.work[6]
    n = read(problem, waves, 1, start, end, out, state.work)
    out[0] += force / problem.impedance[0]
    write(waves, 0, start, end, out, n, state.work)
    return end


@inner
def _at_step(problem, waves, state, node, start, end, force):
    work = state.work
    f, g, d, out = work[6], work[7], work[8], work[9]
    n = read(problem, waves, 2 * node - 2, start, end, f, work)
    m = read(problem, waves, 2 * node + 1, start, end, g, work)
    k = combined(1.0, f, n, -1.0, g, m, d)
    za, zb = problem.impedance[node - 1], problem.impedance[node]
    r, push = (za - zb) / (za + zb), force / (za + zb)
    k_out = combined(1.0, g, m, r, d, k, out)
    out[0] += push
    write(waves, 2 * node - 1, start, end, out, k_out, state.work)
    k_out = combined(1.0, f, n, r, d, k, out)
    out[0] += push
    write(waves, 2 * node, start, end, out, k_out, state.work)
    return end


@inner
def _at_joint(problem, waves, state, node, start, end, force):
    """m v' = 2 Z_a f + 2 Z_b g − (Z_a + Z_b) v + Q."""
    work = state.work
    f, g, v, q, out = work[6], work[7], work[8], work[9], work[10]
    n = read(problem, waves, 2 * node - 2, start, end, f, work)
    m = read(problem, waves, 2 * node + 1, start, end, g, work)
    za, zb, mass = problem.impedance[node - 1], problem.impedance[node], problem.joint_mass[node]
    while True:
        half = 0.5 * (end - start) * problem.tick
        k = combined(2.0 * za / mass, f, n, 2.0 * zb / mass, g, m, q)
        q[0] += force / mass
        rate = (za + zb) / mass
        k, enough = relaxed(rate, half, q, k, state.velocity[node], v, NOTHING, work)
        if enough or end - start <= 16 * problem.near:
            break
        share = min(0.5, 4.0 / (rate * half)) if rate * half > 8.0 else 0.5
        after = start + max(8 * problem.near, int(share * (end - start)))
        high = 2.0 * (after - start) / (end - start) - 1.0
        restricted(f, n, -1.0, high, f, work)
        restricted(g, m, -1.0, high, g, work)
        end = after
    write(waves, 2 * node - 1, start, end, out, combined(1.0, v, k, -1.0, f, n, out), state.work)
    write(waves, 2 * node, start, end, out, combined(1.0, v, k, -1.0, g, m, out), state.work)
    state.velocity[node] = right(v, k)
    return end


# ---- The waves of a blow, carried on until a tick


@entry
def go_on(problem, waves, state, target, budget):
    """Carry every node on to the target at least; REACHED, FULL when a row is full, PAUSED after `budget` steps."""
    # Each node goes as far as its arrivals are known. Where every node waits for a piece to be known as a whole, the
    # one that is last goes on with a part of it.
    last, used = last_node(problem), 0
    node, whole, moved, reached, slowest = 0, True, False, True, 0
    while used < budget:
        if state.time[node] < target:
            what = carried_on(problem, waves, state, node, whole)
            if what == FILLED:
                state.now[0].steps += used
                return FULL
            if what == MOVES or not whole:
                used += 1
                moved = True
                if not whole:  # all may go on as before
                    node, whole, moved, reached, slowest = 0, True, False, True, 0
                continue
        reached = reached and state.time[node] >= target
        if state.time[node] < state.time[slowest]:
            slowest = node
        node += 1
        if node > last:
            if reached:
                state.now[0].steps += used
                return REACHED
            node, whole = (0, True) if moved else (slowest, False)
            if whole:
                moved, reached, slowest = False, True, 0
    state.now[0].steps += used
    return PAUSED
