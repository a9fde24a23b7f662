"""The bit, with or without a mass, and the rock in front of it: loading, unloading and reloading, apart.

m v' + Z v + F = 2 Z f, u' = v, g = v − f. The force never jumps, so that rounding cannot decide between branches that
differ; every change of branch is a zero of a polynomial.
"""

from __future__ import annotations

from percuss.blow.kernels.chebyshev import antiderivative, combined, greatest, restricted, right
from percuss.blow.kernels.crossing import NEVER, first_above
from percuss.blow.kernels.layout import FREE, LOAD, NOTHING, OFF, TOUCH, UNLOAD
from percuss.blow.kernels.relaxation import crept, oscillated, relaxed
from percuss.blow.kernels.rows import read, write
from percuss.compiled import inner

MOST_TURNS = 8  # changes of branch at one instant
HOVER = 8  # times the shortest time: what is done without looking when there are more


@inner
def at_rock(problem, waves, state, start, end):
    """Carry the bit on from start to end, or less far; where it stops."""
    now, work = state.now[0], state.work
    row = 2 * problem.impedance.size - 2
    f, u, v, p = work[6], work[7], work[8], work[9]
    n = read(problem, waves, row, start, end, f, work)
    stop, when, place, k = end, end, NEVER, 0
    for turn in range(MOST_TURNS):
        stop, n, k = _moved(problem, now, start, stop, f, n, u, v, work)
        if turn == MOST_TURNS - 1:
            place = NEVER
            break
        if turn == MOST_TURNS - 2 and stop - start > HOVER * problem.near:  # rounding has a say in what comes next
            high = 2.0 * HOVER * problem.near / (stop - start) - 1.0
            stop = start + HOVER * problem.near
            restricted(f, n, -1.0, high, f, work)
            continue
        place = _turn(problem, now, u, v, k, p, work)
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
    _leave(problem, waves, state, now, start, stop, f, n, u, v, k, p)
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
    """Penetration, counted from where the branch has no force, and velocity; how far, and the degrees of f and these.

    Where one polynomial cannot follow, the interval is made shorter, f with it.
    """
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
def _turn(problem, now, u, v, k, p, work):
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
def _leave(problem, waves, state, now, start, stop, f, n, u, v, k, p):
    """Write the wave that goes back, the penetration and the force."""
    row, trace = 2 * problem.impedance.size - 1, 2 * problem.impedance.size
    write(waves, row, start, stop, p, combined(1.0, v, k, -1.0, f, n, p), state.work)
    m = combined(_stiffness(problem, now), u, k, 0.0, u, 0, p)
    write(waves, trace + 2, start, stop, p, m if _stiffness(problem, now) > 0.0 else 0, state.work)
    u[0] += _relaxed_at(problem, now)
    write(waves, trace + 1, start, stop, u, k, state.work)
    u[0] -= _relaxed_at(problem, now)
