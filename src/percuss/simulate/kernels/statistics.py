"""Running sums over the impacts of a motion, and what is concluded from them."""

from __future__ import annotations

import math

from percuss.compiled import entry, inlined, inner
from percuss.simulate.kernels.codes import LOST_CYCLE, TURN
from percuss.simulate.kernels.cycles import wanders


@inlined
def tally(speed, lost, motion):
    """An impact entered into the sums."""
    now, count, sums = motion.now, motion.count, motion.sums[0]
    sums.taken += lost
    begun = now.begun > 0.0
    since = (count.period - now.struck_period) * TURN + (now.phase - now.struck_phase)
    if begun:
        sums.all += 1.0
        sums.all_time += since
        sums.all_squares += since * since
    if begun and count.run > 1:
        sums.open += 1.0
        sums.open_time += since
        sums.open_squares += since * since
        sums.open_speeds += speed
        sums.open_blows += now.kinetic_energy
    else:
        if begun:
            close_run(motion)
            if now.chattered > 0.0:
                since = (count.period - now.blow_period) * TURN + (now.phase - now.blow_phase)
            sums.main += 1.0
            sums.main_time += since
            sums.main_squares += since * since
        now.blow_period, now.blow_phase, now.chattered = count.period, now.phase, 0.0
        sums.speeds += speed
        sums.blows += now.kinetic_energy
        sums.struck += 1.0
    now.struck_period, now.struck_phase, now.begun = count.period, now.phase, 1.0


@inner
def close_run(motion):
    """The open sequence was no chatter: its impacts are main blows."""
    sums = motion.sums[0]
    sums.main += sums.open
    sums.main_time += sums.open_time
    sums.main_squares += sums.open_squares
    sums.speeds += sums.open_speeds
    sums.blows += sums.open_blows
    sums.struck += sums.open
    forget_run(motion)


@inner
def forget_run(motion):
    """No sequence is open any more."""
    sums = motion.sums[0]
    sums.open, sums.open_time, sums.open_squares, sums.open_speeds, sums.open_blows = 0.0, 0.0, 0.0, 0.0, 0.0


@inner
def spread(n, total, squares):
    """Mean and standard deviation from sums; NaN without any."""
    if n == 0.0:
        return math.nan, math.nan
    mean = total / n
    return mean, math.sqrt(max(squares / n - mean * mean, 0.0))


@inner
def concluded(motion, code, member):
    """What is kept of a member: how it ended, its cycle, and its means."""
    now, count, sums, totals = motion.now, motion.count, motion.sums[0], motion.totals
    settled = count.confirmed >= 2
    if not (settled and count.cycle_kind == 2) and now.chattered == 0.0:
        close_run(motion)
    for i in range(totals.shape[1]):
        totals[0, i] += totals[1, i]
    mean, std = spread(sums.all, sums.all_time, sums.all_squares)
    main, main_std = spread(sums.main, sums.main_time, sums.main_squares)
    member.end_time = count.period * TURN + now.phase
    member.interval_mean, member.interval_std = mean, std
    member.main_interval_mean, member.main_interval_std = main, main_std
    member.blow_rate, member.main_blow_rate = TURN / mean, TURN / main
    member.impact_velocity, _ = spread(sums.struck, sums.speeds, 0.0)
    member.blow_energy, _ = spread(sums.struck, sums.blows, 0.0)
    member.energy_lost_per_period = TURN * sums.taken / sums.all_time if sums.all > 0.0 else math.nan
    member.ended, member.strikes, member.first = code, count.impacts, count.found_at - 1 if settled else -1
    member.cycle_impacts = count.cycle_impacts if settled else 0
    member.cycle_periods = count.cycle_periods if settled else 0
    member.cycle_kind = count.cycle_kind if settled else 0
    member.wanders = 1 if count.verdict == LOST_CYCLE or wanders(motion.past, count.impacts) else 0


@entry
def conclude(motion, code, member):
    """What is kept of a motion that was followed by itself."""
    concluded(motion, code, member)
