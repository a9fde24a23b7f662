"""One motion or many, to their ends."""

from __future__ import annotations

import math

from percuss.compiled import entry, inner
from percuss.simulate.kernels.calls import Rules
from percuss.simulate.kernels.clock import set_clock
from percuss.simulate.kernels.codes import (
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
)
from percuss.simulate.kernels.cycles import forget_marked, mark, sure, wanders
from percuss.simulate.kernels.motion import fly
from percuss.simulate.kernels.place import put
from percuss.simulate.kernels.statistics import concluded

NUDGE = 1e-12  # change of R and d under which a cycle from release to release must stay the same to be stated


@inner
def released_as(table, motion, twin):
    """The twin of a motion set to the release that later ones are compared with, and d and R a little changed."""
    bar = table.bar
    bar.damping += NUDGE  # all three slow the bar down
    bar.half += 0.5 * NUDGE
    bar.restitution *= 1.0 - NUDGE
    twin.numbers[:] = 0.0
    twin.wholes[:] = 0
    twin.anchor[:] = 0.0
    twin.totals[:] = 0.0
    set_clock(table, twin.now, twin.count, motion.now.marked)
    twin.now.last_flight, twin.count.mode, twin.count.verdict = -1.0, RESTING, TWIN


@inner
def judged(motion, twin, code, until_cycle):
    """Whether the cycle between two equal releases is sure: its twin, with R and d changed by `NUDGE`, is the same.

    The twin begins with the same release; it must take as many load periods, and be laid down at the same phases to
    `LOOSE`. An error that grows by less than `LOOSE`/`NUDGE` from release to rest leaves of rounding a thousandth of
    that. `code`: how the twin ended. Returns how the motion ends with it: `PERIODIC`, `UNRESOLVED`, or `BY_WORK` when
    it is to go on.
    """
    count = motion.count
    off = abs(twin.now.laid - motion.now.laid)
    off = min(off % TURN, TURN - off % TURN)
    same = twin.count.cycle_periods == count.cycle_periods and twin.count.cycle_kind == count.cycle_kind
    if code == TO_VERIFY and same and off < LOOSE:
        sure(motion)
        return PERIODIC if until_cycle and count.confirmed >= 2 else BY_WORK
    count.verdict, count.cycle_impacts, count.cycle_periods = LOST_CYCLE, 0, 0
    if until_cycle:  # the means are those between the two releases
        forget_marked(motion)
    mark(motion)
    return UNRESOLVED if until_cycle else BY_WORK


@entry
def follow(table, starts, ends, rules, motion, twin, desk, log, none, stopped, members, tail):
    """Motions from all starts, one after the other; or one, from where it stands, where there are no starts.

    Everything is in this one function, with a single place that `fly` is called from: each function that calls another
    one is compiled with all of it again.

    Parameters
    ----------
    table, desk
        The system, and room to work in.
    starts, ends
        Where the motions begin, and load periods and phases at which they end, shape (starts, 2); `ends` has one row
        where there are no starts.
    rules
        When all of them end, besides.
    motion, twin
        The motion, and room for another one that tells whether a cycle between two releases is sure.
    log, none
        The record, which is full before it is too small, and an empty one.
    stopped
        Looked at between two motions, and from time to time: not 0 when there is to be an end.
    members, tail
        What is kept of each motion, and its last impacts. Of a motion without a start only
        `ended` and `wanders`.
    """
    bar, count, past = table.bar, motion.count, motion.past
    alone = starts.gap.shape[0] == 0
    for i in range(members.shape[0]):
        if stopped[0]:
            return i
        if not alone:
            put(table, motion, desk, starts, i)
        whole = (bar.damping, bar.half, bar.restitution, bar.mean)
        checked, code = False, BY_WORK
        while True:
            budget = rules.budget if alone else min(count.work + SLICE, rules.budget)
            own = Rules(
                ends[i, 0], ends[i, 1], rules.most_impacts, rules.until_cycle, rules.tolerance, rules.skip, budget
            )
            its = Rules(
                math.inf,
                0.0,
                2 * count.cycle_impacts + 256,
                rules.until_cycle and not checked,
                rules.tolerance,
                0,
                2 * count.work + SLICE,
            )
            who = twin if checked else motion
            code = fly(table, who, desk, its if checked else own, none if checked else log)
            if checked:
                checked = False
                bar.damping, bar.half, bar.restitution, bar.mean = whole
                code = judged(motion, twin, code, rules.until_cycle)
            elif code == TO_VERIFY:
                checked = True
                whole = (bar.damping, bar.half, bar.restitution, bar.mean)
                released_as(table, motion, twin)
                continue
            if alone or code != BY_WORK or count.work >= rules.budget or stopped[0]:
                break
        if alone:
            members[i].ended, members[i].wanders = code, wanders(past, count.impacts)
            continue
        if stopped[0] and code == BY_WORK:
            return i
        concluded(motion, code, members[i])
        kept = tail.shape[1]
        for j in range(min(kept, count.impacts)):
            last = past[(count.impacts - 1 - j) & (past.shape[0] - 1)]
            row = tail[i, kept - 1 - j]
            row.phase, row.speed, row.period = last.phase, last.speed, last.period
    return members.shape[0]
