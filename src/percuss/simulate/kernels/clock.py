"""The clock of the load."""

from __future__ import annotations

import math

from percuss.compiled import entry, inlined, inner
from percuss.simulate.kernels.modes import reach, sine_cosine
from percuss.simulate.kernels.motion_records import EPS, TURN, TURN_LOW


@inlined
def turn_clock(now, count, tau):
    """The load phase after τ, in [0, 2π), and the load periods gone by."""
    phase = now.phase + tau
    if phase >= TURN:
        turns = math.floor(phase / TURN)
        phase = (phase - turns * TURN) - turns * TURN_LOW
        if phase < 0.0:
            phase = 0.0
        elif phase >= TURN:
            phase -= TURN
            turns += 1.0
        count.period += int(turns)
    now.phase = phase
    now.sine, now.cosine = sine_cosine(phase)


@inner
def set_phase(now, phase):
    """The phase put where it is known to be."""
    now.phase = phase
    now.sine, now.cosine = sine_cosine(phase)


@inlined
def to_break(now, count, breaks):
    """Time to the next step of the load."""
    if breaks.shape[0] == 0:
        return math.inf
    piece = count.piece + 1
    if piece == breaks.shape[0]:
        ahead = breaks[0] - now.phase
        return ahead if ahead >= 0.0 else ahead + TURN
    return max(breaks[piece] - now.phase, 0.0)


@inlined
def set_load(bar, value):
    """The constant part of the load, with what follows from it."""
    bar.load = value
    bar.mean = 0.0 if bar.held > 0.0 else value
    bar.wall = bar.bears * value + bar.preload


@inner
def set_clock(table, now, count, phase):
    """The clock of a resting bar put to the next time of a load phase, with the step of the load that holds then."""
    # The phase is set as it is, so that each release at it is the same one to the last bit.
    bar, breaks, values = table.bar, table.breaks, table.values
    if phase < now.phase:
        count.period += 1
    set_phase(now, phase)
    if values.shape[0]:
        piece = values.shape[0] - 1
        for i in range(values.shape[0]):
            if breaks[i] <= phase:
                piece = i
        count.piece = piece
        set_load(bar, values[piece])


# ---- What the load does: its value, where it turns from push to pull, and for how long


@inner
def load_at(harmonics, mean, c, s):
    """p and p' of a load that is a Fourier series, at the phase whose cosine and sine are given."""
    wr, wi, p, rate = 1.0, 0.0, mean, 0.0
    for k in range(harmonics.gap_re.shape[0]):
        wr, wi = wr * c - wi * s, wr * s + wi * c
        p += harmonics.load_re[k] * wr - harmonics.load_im[k] * wi
        rate -= (k + 1) * (harmonics.load_re[k] * wi + harmonics.load_im[k] * wr)
    return p, rate


@entry
def release_phases(harmonics, mean, bend, force, out):
    """Phases at which a Fourier series turns from push to pull, ascending, into `out`; returns how many there are."""
    # Stepped over with the bound of p'', like a flight; a touch of 0 within rounding is no pull.
    if bend == 0.0:
        return 0
    t, found, least, pushed_at, blind = 0.0, 0, 64.0 * EPS * force, -1.0, 1e-9
    while t < TURN + 1e-6:
        p, rate = load_at(harmonics, mean, math.cos(t), math.sin(t))
        if p > least:
            pushed_at = t
            t += max(reach(-p, -rate, bend), EPS * TURN)
        elif p < -least:
            if pushed_at >= 0.0 and found < out.shape[0]:
                low, high = pushed_at, t
                for _ in range(200):
                    middle = 0.5 * (low + high)
                    if load_at(harmonics, mean, math.cos(middle), math.sin(middle))[0] > 0.0:
                        low = middle
                    else:
                        high = middle
                out[found] = high % TURN
                found += 1
            pushed_at = -1.0
            t += max(reach(p, rate, bend), EPS * TURN)
        else:
            t += blind
            blind *= 2.0
            continue
        blind = 1e-9
    return found


@inner
def pull_begins(bar, harmonics, now):
    """Time until a load that is 0 within rounding pulls; −1 when it pushes before, or stays 0 for a whole period."""
    t, blind, least = 0.0, 1e-9, 64.0 * EPS * bar.force
    while t < TURN:
        t += blind
        blind *= 2.0
        s, c = sine_cosine(now.phase + t)
        p, _ = load_at(harmonics, bar.wall, c, s)
        if abs(p) > least:
            return t if p < 0.0 else -1.0
    return -1.0


@inner
def pull_ahead(table, now):
    """Time until the load pulls a resting bar off the wall, and the load phase then; −1 and now when it never does."""
    # `releases`: the phases at which the load begins to pull, ascending; for step loads the begin of those steps. A bar
    # laid down within rounding after such a phase is released now and not a period later.
    bar, harmonics, releases = table.bar, table.harmonics, table.releases
    p, _ = load_at(harmonics, bar.wall, now.cosine, now.sine)
    least = 0.0 if table.values.shape[0] else 64.0 * EPS * bar.force
    if p < -least:
        return 0.0, now.phase
    wait, phase = -1.0, now.phase
    if releases.shape[0]:
        wait, phase = releases[0] - now.phase + TURN, releases[0]
        for i in range(releases.shape[0]):
            if releases[i] >= now.phase:
                wait, phase = releases[i] - now.phase, releases[i]
                break
    if p <= least and least > 0.0:
        begins = pull_begins(bar, harmonics, now)
        if begins >= 0.0 and not 0.0 <= wait <= begins:
            return 0.0, now.phase
    return wait, phase


@inner
def release_at(phase, releases):
    """A phase that is one of `releases`, to the last bit; −1 when it is none."""
    for i in range(releases.shape[0]):
        if releases[i] == phase:
            return phase
    return -1.0


@inner
def first_pull(bar, harmonics, now):
    """A time from the release of a rigid bar on for which the load surely pulls: 0 when it jumps to a pull."""
    p, rate = load_at(harmonics, bar.wall, now.cosine, now.sine)
    if harmonics.gap_re.shape[0] == 0:
        return 0.0
    ahead = 0.5 * min(reach(min(p, 0.0), rate, bar.bend), 1.0)
    if ahead < 1e-7:  # a zero of higher order
        ahead = 1e-7
        while ahead < 1.0 and p > -64.0 * EPS * bar.force:
            ahead *= 2.0
            s, c = sine_cosine(now.phase + ahead)
            p, rate = load_at(harmonics, bar.wall, c, s)
    return ahead


@inner
def pull_lasts(table, now, count):
    """Time from a release on until the load pushes again; inf when it never does."""
    # Up to then the end of the continuous bar only moves away from the wall: all that arrives there are pulls.
    bar, harmonics, breaks, values = table.bar, table.harmonics, table.breaks, table.values
    if values.shape[0]:
        ahead, piece = to_break(now, count, breaks), count.piece
        for _ in range(values.shape[0]):
            piece = piece + 1 if piece + 1 < values.shape[0] else 0
            if bar.bears * values[piece] + bar.preload > 0.0:
                return ahead
            following = breaks[piece + 1] if piece + 1 < values.shape[0] else breaks[0] + TURN
            ahead += following - breaks[piece]
        return math.inf
    t, least = 0.0, 64.0 * EPS * bar.force
    c, s = now.cosine, now.sine
    while t < TURN and harmonics.gap_re.shape[0]:
        p, rate = load_at(harmonics, bar.wall, c, s)
        if p > least and t > 0.0:
            return t
        t += max(reach(min(p, 0.0), rate, bar.bend), 1e-6)
        s, c = sine_cosine(now.phase + t)
    return math.inf


@inner
def push_left(table, now):
    """Time from the impact before this one until the load begins to pull; −1 when it pulled then already."""
    breaks, values, releases = table.breaks, table.values, table.releases
    begin = now.phase - now.since
    left = math.inf
    for i in range(releases.shape[0]):
        ahead = releases[i] - begin
        left = min(left, ahead - TURN * math.floor(ahead / TURN))
    if left < now.since:
        return left
    if values.shape[0]:
        begin -= TURN * math.floor(begin / TURN)
        piece = values.shape[0] - 1
        for i in range(values.shape[0]):
            if breaks[i] <= begin:
                piece = i
        return left if values[piece] >= 0.0 else -1.0
    s, c = sine_cosine(begin)
    p, _ = load_at(table.harmonics, table.bar.wall, c, s)
    return left if p >= 0.0 else -1.0
