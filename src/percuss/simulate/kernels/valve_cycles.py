"""The search for a cycle of a machine: among the changes of its valve, by the state of all that moves and waits."""

from __future__ import annotations

from percuss.compiled import inlined, inner

MANY = 1000  # changes of state that are too many …
SHORT = 1e-6  # … within this time
SAME = 32  # last changes looked at
SHIFTS = 16  # longest cycle that makes a motion not irregular
LOOSE = 1e-3


@inlined
def remember(motion, controls):
    """The state just after a change of the valve, to be compared with later ones."""
    now, count, valve = motion.now, motion.count, controls.now
    z, memo = motion.z, controls.memo
    valve.memo_gap, valve.memo_rate, valve.memo_rigid = now.gap, now.gap_rate, now.rigid_rate
    valve.memo_time, valve.memo_state, valve.memo_last = valve.time, valve.state, valve.last
    valve.memo_waiting, valve.memo_changes, valve.memo_blows = valve.waiting, valve.changes, valve.blows
    valve.memo_rests, valve.memo_chatters, valve.memo_impacts = valve.rests, valve.chatters, count.impacts
    valve.memo_taken, valve.strongest = valve.taken, 0.0
    for j in range(z.shape[1]):
        memo[0, j], memo[1, j] = z[0, j], z[1, j]
    for i in range(valve.waiting):
        controls.memo_due[i] = controls.due[i]


@inlined
def returned(table, motion, controls, tolerance, scale):
    """Whether the state is the remembered one, each number to `tolerance` of its scale."""
    now, valve, z, memo = motion.now, controls.now, motion.z, controls.memo
    if valve.state != valve.memo_state or valve.last != valve.memo_last or valve.waiting != valve.memo_waiting:
        return False
    bound = tolerance * scale
    far = max(abs(now.gap - valve.memo_gap), abs(now.gap_rate - valve.memo_rate))
    far = max(far, abs(now.rigid_rate - valve.memo_rigid))
    if far > bound:
        return False
    for i in range(valve.waiting):
        if abs(controls.due[i] - controls.memo_due[i]) > tolerance:
            return False
    most = 0.0
    for j in range(z.shape[1]):
        off = max(abs(z[0, j] - memo[0, j]), abs(z[1, j] - memo[1, j]))
        most = max(most, off * (1.0 + table.modes.lam[j]))
    return most <= bound


@inner
def farthest(past, shift, first, last, scale):
    """Greatest distance of the changes number `first` … `last` − 1 from those `shift` before."""
    most, ring = 0.0, past.shape[0] - 1
    for i in range(first, last):
        a, b = past[i & ring], past[(i - shift) & ring]
        if a.state != b.state:
            return 1e9
        most = max(most, abs(a.interval - b.interval), abs(a.gap - b.gap) / scale, abs(a.rate - b.rate) / scale)
    return most


@inlined
def shortest(past, changes, seen, scale, tolerance):
    """The cycle of so many changes or, when a part of it comes back as well, that; 0 when that is still open.

    A motion that settles with a negative multiplier comes back after two cycles before it does after one: the distance
    of a part that still shrinks, by more than 1e-4 of itself in a cycle, is waited for.
    """
    for part in range(1, changes // 2 + 1):
        if changes % part or 2 * changes + part > min(seen, past.shape[0]):
            continue
        off = farthest(past, part, seen - changes, seen, scale)
        if off <= tolerance:
            return part
        if off < 1.0 and abs(off - farthest(past, part, seen - 2 * changes, seen - changes, scale)) > 1e-4 * off:
            return 0
    return changes


@inlined
def recurrence(table, motion, controls, tolerance):
    """The search for a cycle, after each change of the valve: Brent's; two returns with the same cycle confirm it."""
    now, valve, past = motion.now, controls.now, controls.past
    valve.changes += 1
    ring = past.shape[0] - 1
    last = past[(valve.changes - 1) & ring]
    last.interval, last.gap, last.rate, last.state = valve.time - valve.changed, now.gap, now.gap_rate, valve.state
    valve.changed = valve.time
    scale = table.bar.force + abs(now.gap_rate)
    since = valve.changes - valve.memo_changes
    if valve.memo_changes > 0 and returned(table, motion, controls, tolerance, scale):
        cycle = shortest(past, since, valve.changes, scale, tolerance)
        if cycle == 0:
            valve.confirmed, valve.cycle_changes = 0, 0
        else:
            turns = 0
            for i in range(valve.changes - cycle, valve.changes):
                turns += 1 if past[i & ring].state == valve.state else 0
            blows = (valve.blows - valve.memo_blows) * cycle // since
            if cycle == valve.cycle_changes and blows == valve.cycle_blows:
                valve.confirmed += 1
            else:
                valve.confirmed, valve.found_at = 1, valve.memo_impacts
            valve.cycle_changes, valve.cycle_blows, valve.cycle_turns = cycle, blows, turns
            valve.period = (valve.time - valve.memo_time) * cycle / since
            valve.cycle_taken = (valve.taken - valve.memo_taken) * cycle / since
            valve.cycle_speed = valve.strongest
            valve.cycle_kind = 1 if valve.rests > valve.memo_rests else 0
            if valve.chatters > valve.memo_chatters:
                valve.cycle_kind = 2
        remember(motion, controls)
    else:
        if valve.confirmed > 0 and since > valve.cycle_changes:
            valve.confirmed, valve.cycle_changes = 0, 0
        if valve.memo_changes == 0 or since >= valve.patience:
            valve.patience = max(2 * valve.patience, 1)
            remember(motion, controls)


@inner
def sliding(controls):
    """Whether the valve has changed `MANY` times within a `SHORT` time: it will not end at a port."""
    valve = controls.now
    valve.recent += 1
    if valve.recent < MANY:
        return False
    swift = valve.time - valve.window < SHORT
    valve.recent, valve.window = 0, valve.time
    return swift


@inner
def wandering(controls):
    """Whether no shift by up to `SHIFTS` brings the last changes of the valve back to `LOOSE`ly the same."""
    valve, past = controls.now, controls.past
    if valve.changes < SAME + SHIFTS:
        return 0
    top = 1e-300
    for i in range(valve.changes - SAME, valve.changes):
        one = past[i & (past.shape[0] - 1)]
        top = max(top, abs(one.rate), abs(one.gap))
    for shift in range(1, SHIFTS + 1):
        if farthest(past, shift, valve.changes - SAME, valve.changes, top) < LOOSE:
            return 0
    return 1
