"""One motion or many, to their ends."""

from __future__ import annotations

import math

from percuss.simulate.kernels.clock import set_clock
from percuss.simulate.kernels.compiled import entry, inner
from percuss.simulate.kernels.cycles import forget_marked, mark, sure
from percuss.simulate.kernels.layout import (
    BY_WORK,
    LOOSE,
    LOST_CYCLE,
    PERIODIC,
    RESTING,
    SLICE,
    TO_VERIFY,
    TURN,
    TWIN,
    UNRESOLVED,
    Rules,
)
from percuss.simulate.kernels.motion import fly
from percuss.simulate.kernels.place import place
from percuss.simulate.kernels.statistics import conclude

NUDGE = 1e-12  # change of R and d under which a cycle from release to release must stay the same to be stated


@inner
def verify(table, motion, twin, desk, rules, none):
    """Whether the cycle between two equal releases is sure: its twin, with R and d changed by `NUDGE`, is the same.

    The twin begins with the same release; it must take as many load periods, and be laid down at the same phases to
    `LOOSE`. An error that grows by less than `LOOSE`/`NUDGE` from release to rest leaves of rounding a thousandth of
    that. `none` is an empty record. Returns how the motion ends with it: `PERIODIC`, `UNRESOLVED`, or `BY_WORK` when it
    is to go on.
    """
    bar, now, count = table.bar, motion.now, motion.count
    d, half, r, mean = bar.damping, bar.half, bar.restitution, bar.mean
    bar.damping, bar.half, bar.restitution = d + NUDGE, half + 0.5 * NUDGE, r * (1.0 - NUDGE)  # all slow the bar down
    twin.numbers[:] = 0.0
    twin.wholes[:] = 0
    twin.anchor[:] = 0.0
    twin.totals[:] = 0.0
    set_clock(table, twin.now, twin.count, now.marked)
    twin.now.last_flight, twin.count.mode, twin.count.verdict = -1.0, RESTING, TWIN
    code = fly(
        table,
        twin,
        desk,
        Rules(math.inf, 0.0, 2 * count.cycle_impacts + 256, False, rules.tolerance, 0, 2 * count.work + SLICE),
        none,
    )
    bar.damping, bar.half, bar.restitution, bar.mean = d, half, r, mean
    off = abs(twin.now.laid - now.laid)
    off = min(off % TURN, TURN - off % TURN)
    same = twin.count.cycle_periods == count.cycle_periods and twin.count.cycle_kind == count.cycle_kind
    if code == TO_VERIFY and same and off < LOOSE:
        sure(motion)
        return PERIODIC if rules.until_cycle and count.confirmed >= 2 else BY_WORK
    count.verdict, count.cycle_impacts, count.cycle_periods = LOST_CYCLE, 0, 0
    if rules.until_cycle:  # the means are those between the two releases
        forget_marked(motion)
    mark(motion)
    return UNRESOLVED if rules.until_cycle else BY_WORK


@entry
def follow(table, motion, twin, desk, rules, log, none):
    """A motion from its anchor on, until a stop rule holds or the record is full; see `fly` and `verify`."""
    code = fly(table, motion, desk, rules, log)
    if code == TO_VERIFY:
        code = verify(table, motion, twin, desk, rules, none)
    return code


@entry
def follow_many(table, starts, rules, end_periods, end_phases, motion, twin, desk, none, stopped, members, tail):
    """Motions from all starts, one after the other; `stopped` is looked at between them.

    `rules`: for all, but for the times when they end. `none` is an empty record, `twin` a motion for `verify`. What is
    kept of each goes into `members`, and its last impacts into `tail`. Returns how many are done.
    """
    count, past = motion.count, motion.past
    for i in range(members.shape[0]):
        if stopped[0]:
            return i
        place(table, motion, desk, starts, i)
        code = BY_WORK
        while code == BY_WORK and count.work < rules.budget and not stopped[0]:
            code = follow(
                table,
                motion,
                twin,
                desk,
                Rules(
                    end_periods[i],
                    end_phases[i],
                    rules.most_impacts,
                    rules.until_cycle,
                    rules.tolerance,
                    rules.skip,
                    min(count.work + SLICE, rules.budget),
                ),
                none,
                none,
            )
        if stopped[0] and code == BY_WORK:
            return i
        conclude(motion, code, members[i])
        kept = tail.shape[1]
        for j in range(min(kept, count.impacts)):
            last = past[(count.impacts - 1 - j) & (past.shape[0] - 1)]
            row = tail[i, kept - 1 - j]
            row.phase, row.speed, row.period = last.phase, last.speed, last.period
    return members.shape[0]
