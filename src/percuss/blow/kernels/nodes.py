"""What joins the sections: the driven end, steps with or without a mass, the face, the far end."""

from __future__ import annotations

from percuss.blow.kernels.chebyshev import combined, restricted, right
from percuss.blow.kernels.face import at_face
from percuss.blow.kernels.layout import ENDLESS, FAR, FREE, NOTHING, ROCK
from percuss.blow.kernels.relaxation import relaxed
from percuss.blow.kernels.rock import at_rock
from percuss.blow.kernels.rows import arriving_until, has_room, read, write
from percuss.compiled import inlined, inner

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
