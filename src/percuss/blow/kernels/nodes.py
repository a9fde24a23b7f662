"""What joins the sections: the driven end, steps with or without a mass, the face, the far end."""

from __future__ import annotations

from percuss.blow.kernels.chebyshev import (
    NEVER,
    antiderivative,
    combined,
    first_above,
    greatest,
    left,
    restricted,
    right,
)
from percuss.blow.kernels.linear_motion import relaxed, shorter, swung
from percuss.blow.kernels.rows import arriving_until, has_room, read, write
from percuss.blow.kernels.wave_records import (
    CONTACT,
    ELASTIC,
    ENDLESS,
    FAR,
    FED,
    FREE,
    FULL,
    LOAD,
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
def at_face(problem, waves, state, which, here, start, end):
    """Carry two faces on from start to end, or to the first meeting or parting before; where it stops.

    `which` is 0 of the struck face, and else the number of a joint whose thread catches where they part by its slack.
    """
    now, work = state.now[which], state.work
    into, back = 2 * here - 2, 2 * here + 1
    slack = problem.slack[which]
    f, g, d, h = work[6], work[7], work[8], work[9]
    wall = which == 0 and problem.end == WALL
    n = read(problem, waves, into, start, end, f, work)
    m = 0
    if wall:
        g[0] = 0.0
    else:
        m = read(problem, waves, back, start, end, g, work)
    k = combined(1.0, f, n, -1.0, g, m, d)
    if which > 0:  # of the waves as a whole: the thread has its preload
        d[0] += 0.5 * problem.preload[here] * (1.0 / problem.impedance[here - 1] + 1.0 / problem.impedance[here])
        combined(1.0 - 2.0 * now.flank, d, k, 0.0, d, 0, d)
    half = 0.5 * (end - start) * problem.tick
    place, when = NEVER, end
    for turn in range(MOST_TURNS):
        place = _turn(now, d, k, half, h, work, slack)
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
        _crossed(now, d, k)
        now.gap, now.closed = 0.0, 1 - now.closed
    stop = end if place == NEVER else when
    if stop < end:
        high = 2.0 * (stop - start) / (end - start) - 1.0
        restricted(f, n, -1.0, high, f, work)
        restricted(g, m, -1.0, high, g, work)
        restricted(d, k, -1.0, high, d, work)
    if which == 0:
        _leave(problem, waves, state, start, stop, f, n, g, m, d, k)
    else:
        _joint_leaves(problem, waves, state, which, here, start, stop, f, n, g, m, work[10])
    _faces_after(now, d, k, half, h, place, slack)
    return stop


@inner
def _crossed(now, d, k):
    """Faces that meet on the other side of the thread: what closes them there parts them here."""
    if now.across == 1:
        now.flank, now.across = 1 - now.flank, 0
        combined(-1.0, d, k, 0.0, d, 0, d)


@inner
def _faces_after(now, d, k, half, h, place, slack):
    """The gap at the end of a piece that ends with a meeting or parting, or with none (NEVER)."""
    if now.closed == 0 and place == NEVER:
        antiderivative(d, k, half, h)
        moved = now.gap - 2.0 * right(h, k + 1)
        now.arriving = 0
        if moved <= SHUT:
            now.arriving = 1 if now.gap > 0.0 and moved < now.gap else 0
            moved = 0.0
        elif moved >= slack - SHUT:
            now.arriving, now.flank, moved = 1, 1 - now.flank, 0.0
        now.gap = moved
    elif place != NEVER:
        now.arriving = 1 if now.gap > 0.0 else 0
        _crossed(now, d, k)
        now.gap, now.closed = 0.0, 1 - now.closed
        if now.arriving == 1:  # whether they meet there is for the next piece to say
            now.closed = 0


@inner
def _turn(now, d, k, half, h, work, slack):
    """Where the faces meet or part in this interval, or NEVER; `across` where they meet on the other side."""
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
    if meets == NEVER and slack >= FAR:
        return NEVER
    antiderivative(d, k, 2.0 * half, h)  # 2 ∫(f − g): how far they have come together
    h[0] -= now.gap
    meets = first_above(h, k + 1, SHUT, work)
    if slack < FAR:
        combined(-1.0, h, k + 1, 0.0, h, 0, h)
        h[0] -= slack
        caught = first_above(h, k + 1, SHUT, work)
        now.across = 1 if caught < meets else 0
        meets = min(meets, caught)
    return meets


@inner
def _leave(problem, waves, state, start, stop, f, n, g, m, d, k):
    """Write what leaves the face, and the force; note whether the faces have met or parted."""
    now, here, out = state.now[0], problem.striker, state.work[9]
    row, trace = 2 * here - 1, 2 * problem.impedance.size
    if now.closed != now.pressed:
        state.contact[0, now.noted] = start
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


@inner
def _joint_leaves(problem, waves, state, which, here, start, stop, f, n, g, m, out):
    """Write what leaves the faces of a joint: as from a step while they are closed, as from free ends while open."""
    now, work, d = state.now[which], state.work, state.work[11]
    if now.closed != now.pressed:
        state.contact[which, now.noted] = start
        now.noted += 1
        now.pressed = now.closed
    za, zb, force = problem.impedance[here - 1], problem.impedance[here], problem.preload[here]
    if now.closed == 1:
        k = combined(1.0, f, n, -1.0, g, m, d)
        r = (za - zb) / (za + zb)
        write(waves, 2 * here - 1, start, stop, out, combined(1.0, g, m, r, d, k, out), work)
        write(waves, 2 * here, start, stop, out, combined(1.0, f, n, r, d, k, out), work)
        return
    f[0] += force / za
    g[0] -= force / zb
    write(waves, 2 * here - 1, start, stop, f, n, work)
    write(waves, 2 * here, start, stop, g, m, work)


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
    # Where one polynomial cannot follow, the interval is made shorter, f with it. Of a bit that is fed the motion is
    # that about the place where the branch bears the feed; off the rock the feed pushes it.
    z, m, fed = problem.impedance[-1], problem.joint_mass[-1], problem.preload[-1]
    stiff, wave = _stiffness(problem, now), f[0]
    rest, push = (fed / stiff, 0.0) if stiff > 0.0 else (0.0, 0.5 * fed / z)
    place, q = now.penetration - _relaxed_at(problem, now) - rest, work[10]
    while True:
        half = 0.5 * (stop - start) * problem.tick
        f[0] = wave + push
        k, enough, rate = swung(m, z, stiff, 2.0 * z, f, n, half, place, now.bit_velocity, u, v, q, work)
        f[0] = wave
        if enough or stop - start <= 16 * problem.near:
            u[0] += rest
            return stop, n, k
        after = shorter(start, stop, problem.near, half, rate)
        restricted(f, n, -1.0, 2.0 * (after - start) / (stop - start) - 1.0, f, work)
        stop, wave = after, f[0]


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
    kind = problem.kind[node]
    moving = problem.joint_mass[node] > 0.0 or (node == sections and problem.end == ROCK) or kind in (ELASTIC, FED)
    if whole and end == known and end < problem.until and cut_known and (bent_end > end + near or moving):
        return STAYS
    if node == 0:
        stop = _at_driven_end(problem, waves, state, time, end, force)
    elif kind == FED:
        stop = at_feed(problem, waves, state, node, time, end)
    elif node == problem.striker or kind == CONTACT:
        stop = at_face(problem, waves, state, problem.traced[node], node, time, end)
    elif kind == ELASTIC:
        stop = _at_spring(problem, waves, state, node, time, end)
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
    kind, row = problem.kind[node], problem.traced[node]
    if kind in (ELASTIC, FED):
        rooms = rooms and has_room(waves, row) and has_room(waves, row + 1)
    elif kind == CONTACT:
        return rooms and state.now[row].noted + 2 < state.contact.shape[1]
    if node == problem.striker:
        return rooms and has_room(waves, 2 * sections) and state.now[0].noted + 2 < state.contact.shape[1]
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
        end = _shortened(problem, start, end, half, rate, f, n, g, m, work)
    write(waves, 2 * node - 1, start, end, out, combined(1.0, v, k, -1.0, f, n, out), state.work)
    write(waves, 2 * node, start, end, out, combined(1.0, v, k, -1.0, g, m, out), state.work)
    state.velocity[node] = right(v, k)
    return end


@inner
def _shortened(problem, start, end, half, rate, f, n, g, m, work):
    """Where an interval ends that one polynomial follows, with both waves on it."""
    after = shorter(start, end, problem.near, half, rate)
    high = 2.0 * (after - start) / (end - start) - 1.0
    restricted(f, n, -1.0, high, f, work)
    restricted(g, m, -1.0, high, g, work)
    return after


@inner
def _at_spring(problem, waves, state, node, start, end):
    """δ' = v_a − v_b, N = k δ + c δ': N (1 + c Y) = k δ + 2 c (f − g), Y = 1/Z_a + 1/Z_b; `velocity` keeps δ."""
    work = state.work
    f, g, d, delta, q, out = work[6], work[7], work[8], work[9], work[10], work[11]
    n = read(problem, waves, 2 * node - 2, start, end, f, work)
    m = read(problem, waves, 2 * node + 1, start, end, g, work)
    za, zb, stiffness, dashpot = (
        problem.impedance[node - 1],
        problem.impedance[node],
        problem.spring[node],
        problem.dashpot[node],
    )
    y = 1.0 / za + 1.0 / zb
    below = 1.0 / (1.0 + dashpot * y)
    rate = stiffness * y * below
    while True:
        half = 0.5 * (end - start) * problem.tick
        k = combined(2.0 * below, f, n, -2.0 * below, g, m, q)
        j, enough = relaxed(rate, half, q, k, state.velocity[node], delta, NOTHING / rate, work)
        if enough or end - start <= 16 * problem.near:
            break
        end = _shortened(problem, start, end, half, rate, f, n, g, m, work)
    k = combined(stiffness * below, delta, j, dashpot, q, k, d)
    row = problem.traced[node]
    write(waves, row, start, end, d, k, work)
    write(waves, row + 1, start, end, delta, j, work)
    write(waves, 2 * node - 1, start, end, out, combined(1.0, f, n, -1.0 / za, d, k, out), work)
    write(waves, 2 * node, start, end, out, combined(1.0, g, m, 1.0 / zb, d, k, out), work)
    state.velocity[node] = right(delta, j)
    return end


# ---- What presses the tool, where it has a spring or a dashpot: Q = max(0, F − k y − c v), at the face or at a step
#
# (Z_a + Z_b + c) v = 2 Z_a f + 2 Z_b g − k y − m v' of the departures while it acts; lifted, −F in place of k y and c.
# At a face that is open without Z_a. With the v of either, F − k y − c v has the sign of Q. And f − v/2, closed or
# open, has the sign of the force between the faces and of the speed at which they close.


@inner
def at_feed(problem, waves, state, node, start, end):
    """Carry a node that is fed through a damper on from start to end, or less far; where it stops."""
    now, work, faced = state.now[0], state.work, node == problem.striker
    f, g, push, y, v, d, h = work[6], work[7], work[8], work[9], work[10], work[11], work[12]
    n = read(problem, waves, 2 * node - 2, start, end, f, work)
    m = read(problem, waves, 2 * node + 1, start, end, g, work)
    meets, lifts, k, half = NEVER, NEVER, 0, 0.0
    for turn in range(MOST_TURNS + MOST_BRANCHES):
        last, before = turn == MOST_TURNS + MOST_BRANCHES - 1, now.closed
        if last and end - start > HOVER * problem.near:
            high = 2.0 * HOVER * problem.near / (end - start) - 1.0
            end = start + HOVER * problem.near
            restricted(f, n, -1.0, high, f, work)
            restricted(g, m, -1.0, high, g, work)
        end, k = _fed(problem, state, node, start, end, f, n, g, m, push, y, v)
        half = 0.5 * (end - start) * problem.tick
        combined(1.0, f, n, -0.5, v, k, d)
        meets, lifts = NEVER, NEVER
        if last:  # rounding has a say in what comes next: a little of it is done without looking
            break
        if faced:
            meets = _turn(now, d, max(n, k), half, h, work, FAR)
            if now.closed != before:
                continue
        lifts = _lifts(problem, now, y, v, k, h, work)
        place = min(meets, lifts)
        if place == NEVER:
            break
        when = start + round(0.5 * (1.0 + place) * (end - start))
        if when - start > problem.near:
            if end - when > problem.near:
                high = 2.0 * (when - start) / (end - start) - 1.0
                restricted(f, n, -1.0, high, f, work)
                restricted(g, m, -1.0, high, g, work)
                restricted(y, k, -1.0, high, y, work)
                restricted(v, k, -1.0, high, v, work)
                restricted(d, max(n, k), -1.0, high, d, work)
                end = when
                half = 0.5 * (end - start) * problem.tick
            break
        if meets <= lifts:
            now.gap, now.closed = 0.0, 1 - now.closed
        else:
            now.lifted = 1 - now.lifted
    _feed_leaves(problem, waves, state, node, start, end, f, n, g, m, y, v, k)
    now.fed_place, state.velocity[node] = right(y, k), right(v, k)
    if faced:
        _faces_after(now, d, max(n, k), half, h, meets if meets <= lifts else NEVER, FAR)
    if lifts < meets:
        now.lifted = 1 - now.lifted
    return end


@inner
def _fed(problem, state, node, start, end, f, n, g, m, push, y, v):
    """The motion of a fed node; how far, and its degree."""
    now, work = state.now[0], state.work
    mass, zb = problem.joint_mass[node], problem.impedance[node]
    za = problem.impedance[node - 1] if node > problem.striker or now.closed == 1 else 0.0
    drag, stiffness = za + zb, 0.0
    if now.lifted == 0:
        drag, stiffness = drag + problem.feed_damping, problem.feed_stiffness
    while True:
        half = 0.5 * (end - start) * problem.tick
        k = combined(2.0 * za, f, n if za > 0.0 else 0, 2.0 * zb, g, m, push)
        if now.lifted == 1:
            push[0] -= problem.feed_force
        place, speed = now.fed_place, state.velocity[node]
        k, enough, rate = swung(mass, drag, stiffness, 1.0, push, k, half, place, speed, y, v, work[13], work)
        if enough or end - start <= 16 * problem.near:
            return end, k
        end = _shortened(problem, start, end, half, rate, f, n, g, m, work)


@inner
def _lifts(problem, now, y, v, k, h, work):
    """Where the feed lifts off, or comes to act again; or NEVER."""
    least = TOUCH * (problem.feed_damping + 1.0) + 2e-15 * problem.feed_force
    combined(-problem.feed_stiffness, y, k, -problem.feed_damping, v, k, h)
    h[0] += problem.feed_force
    if now.lifted == 0:
        combined(-1.0, h, k, 0.0, h, 0, h)
    return first_above(h, k, least, work)


@inner
def _feed_leaves(problem, waves, state, node, start, end, f, n, g, m, y, v, k):
    """Write the waves that leave a fed node, the force between faces, that of the feed, and v while it acts."""
    now, work, out, row = state.now[0], state.work, state.work[13], problem.traced[node]
    faced = node == problem.striker
    if faced and now.closed != now.pressed:
        state.contact[0, now.noted] = start
        now.noted += 1
        now.pressed = now.closed
    if faced and now.closed == 0:
        write(waves, 2 * node - 1, start, end, f, n, work)
    else:
        write(waves, 2 * node - 1, start, end, out, combined(1.0, v, k, -1.0, f, n, out), work)
    if faced:
        za = problem.impedance[node - 1] * now.closed
        j = combined(2.0 * za, f, n, -za, v, k, out)
        write(waves, 2 * problem.impedance.size, start, end, out, j if now.closed == 1 else 0, work)
    write(waves, 2 * node, start, end, out, combined(1.0, v, k, -1.0, g, m, out), work)
    acts = 1.0 - now.lifted
    combined(-acts * problem.feed_stiffness, y, k, -acts * problem.feed_damping, v, k, out)
    out[0] += acts * problem.feed_force
    write(waves, row, start, end, out, k if now.lifted == 0 else 0, work)
    combined(acts, v, k, 0.0, v, 0, out)
    write(waves, row + 1, start, end, out, k if now.lifted == 0 else 0, work)


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
