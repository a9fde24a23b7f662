"""The end of chatter, and the bar at rest on the wall."""

from __future__ import annotations

from percuss.compiled import inlined, inner
from percuss.simulate.kernels.clock import turn_clock
from percuss.simulate.kernels.codes import CHATTER, ON_WALL, POWERS, REST, RESTING
from percuss.simulate.kernels.impact import all_energy, undeformed
from percuss.simulate.kernels.load import load_at
from percuss.simulate.kernels.log import record
from percuss.simulate.kernels.modes import forced_modes
from percuss.simulate.kernels.smooth import smooth
from percuss.simulate.kernels.statistics import forget_run

CHATTER_TIME = 1e-5  # a chatter is completed when at most this time of it is left …
CHATTER_ERROR = 1e-13  # … and its end is known to this


@inlined
def chatter_left(table, motion, desk, horizon):
    """Time until the impacts have piled up, theory §8.2, when that is certain and known to `CHATTER_ERROR`; else −1.

    Rebound speed w, acceleration P without damping, and its rate j: the flights 2w/P, 2Rw/P, … add up to
    T_0 = 2w/((1 − R)P), and to first order in j and d to T_0 (1 − d T_0/6 − j T_0/(3P)).
    Modes damped otherwise than the rigid motion are part of what is not known.
    """
    bar, now, osc = table.bar, motion.now, desk.osc
    r, d, w = bar.restitution, bar.damping, -now.gap_rate
    push = now.acceleration - d * w
    if r >= 1.0 or r == 0.0 or push <= 0.0:  # without restitution the next impact is the last
        return -1.0
    left = 2.0 * w / ((1.0 - r) * push)
    if left > CHATTER_TIME or 2.0 * left > horizon:
        return -1.0
    drag = abs(bar.mean - d * now.drift)
    known = (bar.jerk + d * (bar.curve + drag)) * left / push + d * left
    unknown = now.sup3 * left / push
    if bar.law != POWERS:
        unknown += otherwise_damped(table, motion, desk) / push
    if known + unknown > 0.1 or (known * known + unknown) * left > CHATTER_ERROR:
        return -1.0
    _, _, curve = smooth(bar, now, osc, 0.0)
    rate = d * curve - d * (bar.mean - d * now.drift)  # third derivative of S plus d times the second: no drift left
    for k in range(osc.shape[1]):
        n = k + 1.0
        rate += n * n * n * osc[1, k]
    return left * (1.0 - d * left / 6.0 - rate * left / (3.0 * push))


@inner
def otherwise_damped(table, motion, desk):
    """Σ|d_n − d_0||q_n'|: by how much the damping force differs from that of one damping for all modes."""
    bar, modes, now, z = table.bar, table.modes, motion.now, motion.z
    forced_modes(table.coupling, desk, now.cosine, now.sine, 1)
    total = 0.0
    for j in range(modes.omega.shape[0]):
        free = -modes.lam[j] * z[1, j] - modes.half[j] * z[0, j] if modes.oscillates[j] > 0.0 else z[1, j]
        total += abs((modes.damping[j] - bar.damping) * (free + desk.forced[j]))
    return total


@inlined
def held(table, motion):
    """Whether the load holds a bar on the wall that has just struck it, by a law that turns the strain over.

    That law is the sum of one contact, of the time 2/s in which a wave runs to and fro. A rebound whose mean the load
    turns round within that time is none: the contact has not ended before the next one begins. Bounces that are longer
    go on: where R is great, they may be fed by the law itself, as the mean of the bar steps back under the load.
    """
    bar, now = table.bar, motion.now
    if bar.strain == 1.0 or not 0.0 < bar.restitution < 1.0:
        return False
    p, _ = load_at(table.harmonics, bar.mean, now.cosine, now.sine)
    return 0.0 < now.last_flight < bar.contact and 0.0 <= -2.0 * now.rigid_rate <= p * bar.contact


@inner
def stays(table, now, count):
    """Whether a bar without rebound stays on the wall: pushed by the load or, bouncing in no time, by its own shape."""
    bar = table.bar
    p, _ = load_at(table.harmonics, bar.mean, now.cosine, now.sine)
    struck = count.mode == ON_WALL
    return (struck and bar.restitution == 0.0 and p > 0.0) or now.acceleration >= 0.0


@inner
def set_down(table, motion, desk, wait, log):
    """The bar comes to rest on the wall, after `wait` when chatter ends then: what motion and strain it has is lost."""
    bar, now, count = table.bar, motion.now, motion.count
    lost = all_energy(table, motion, desk)
    chatter = bar.restitution > 0.0 and (
        count.run > 1 or wait > 0.0
    )  # without restitution there are finitely many impacts
    if wait > 0.0:
        turn_clock(now, count, wait)
    undeformed(table, motion, desk)
    motion.sums[0].taken += lost
    count.mode = RESTING
    now.laid += now.phase
    if chatter:
        now.chattered = 1.0
        forget_run(motion)
        count.chatters += 1
        count.mark_chatters += 1
        record(CHATTER, 0.0, lost, motion, log)
        lost = 0.0
    count.rests += 1
    record(REST, 0.0, lost, motion, log)
