"""The struck face: two ends that can push each other and never pull.

f arrives in the striker, g in the rod. The sign of f − g is that of the force while the faces are closed, and that of
the speed at which they close while they touch; contact is decided by it at every instant, without any impulse.
"""

from __future__ import annotations

from percuss.blow.kernels.chebyshev import antiderivative, combined, left, restricted, right
from percuss.blow.kernels.crossing import NEVER, first_above
from percuss.blow.kernels.layout import TOUCH, WALL
from percuss.blow.kernels.rows import read, write
from percuss.compiled import inner

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
    """Where the faces meet or part in this interval, or NEVER.

    With the gap 0 it is first settled whether they are closed now: by the sign of f − g, and where that is 0, by the
    sign it has next. Faces that touch, and come together at no speed, do not meet, however long that goes on.
    """
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
