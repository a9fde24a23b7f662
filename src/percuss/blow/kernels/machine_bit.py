"""The far end of a tool that is fed between blows: a bit, with or without a mass, on rock that yields.

m v' + Z v + F = 2 Z f, u' = v, g = v − f, with F = K u while the bit goes deeper than ever, K/γ (u − u_r) on the way
back and forward again, u_r = (1 − γ) u_m, and no force beyond (Lundberg 1973). f is its mean over a step.
"""

from __future__ import annotations

import math

from percuss.blow.kernels.machine_records import LOAD, OFF, UNLOAD
from percuss.compiled import inner

_MOST_TURNS = 8  # changes of branch within a step
_HALVINGS = 60
_CRITICAL = 1e-4  # |qt| below which a bit is as good as critically damped


@inner
def bit_after(z, m, k, f, w, v, t):
    """Where the bit is a time t later, and its velocity; w counts from where the branch has no force."""
    if m == 0.0:
        velocity = 2.0 * f - k / z * w
        moved = velocity * t if k == 0.0 else -velocity * z / k * math.expm1(-k / z * t)
        return w + moved, velocity - k / z * moved
    if k == 0.0:
        fall = -math.expm1(-z / m * t)
        return w + 2.0 * f * t + (v - 2.0 * f) * m / z * fall, v + (2.0 * f - v) * fall
    a, square = 0.5 * z / m, (0.5 * z / m) ** 2 - k / m
    q = math.sqrt(abs(square))
    if q * t < _CRITICAL:
        fade = math.exp(-a * t)
        c, s = fade * (1.0 + 0.5 * square * t * t), fade * t * (1.0 + square * t * t / 6.0)
    elif square > 0.0:
        slow, fast = math.exp((q - a) * t), math.exp(-(q + a) * t)
        c, s = 0.5 * (slow + fast), 0.5 * (slow - fast) / q
    else:
        fade = math.exp(-a * t)
        c, s = fade * math.cos(q * t), fade * math.sin(q * t) / q
    rest = 2.0 * z * f / k
    off = w - rest
    return rest + off * (c + a * s) + v * s, v * (c - a * s) - k / m * off * s


@inner
def leaves(branch, span, w, v):
    """Whether a bit there, and so fast, has left its branch."""
    if branch == LOAD:
        return v < 0.0
    if branch == OFF:
        return w > 0.0
    return w < 0.0 or w > span


@inner
def bit_moved(bit, now, count, f, step):
    """Carry the bit on by a step in which the mean wave f arrives; returns by how much it moved."""
    before, left = now.penetration, step
    if f == 0.0 and now.bit_velocity == 0.0 and now.greatest == 0.0 and before <= 0.0:
        return 0.0
    for turn in range(_MOST_TURNS):
        residual = (1.0 - bit.ratio) * now.greatest
        zero = 0.0 if count.branch == LOAD else residual
        k = bit.stiffness if count.branch == LOAD else bit.stiffness / bit.ratio if count.branch == UNLOAD else 0.0
        span = bit.ratio * now.greatest
        w, v = now.penetration - zero, now.bit_velocity
        if bit.mass == 0.0:
            v = 2.0 * f - k / bit.impedance * w
        if count.branch == LOAD and v < 0.0 and k > 0.0:
            count.branch = UNLOAD if now.greatest > 0.0 else OFF
            continue
        after, velocity = bit_after(bit.impedance, bit.mass, k, f, w, v, left)
        if turn == _MOST_TURNS - 1 or bit.stiffness == 0.0 or not leaves(count.branch, span, after, velocity):
            now.penetration, now.bit_velocity = zero + after, velocity
            break
        low, high = 0.0, left
        for _ in range(_HALVINGS):
            middle = 0.5 * (low + high)
            after, velocity = bit_after(bit.impedance, bit.mass, k, f, w, v, middle)
            if leaves(count.branch, span, after, velocity):
                high = middle
            else:
                low = middle
        after, now.bit_velocity = bit_after(bit.impedance, bit.mass, k, f, w, v, low)
        left -= low
        turned_over(now, count, zero + after, residual)
    if count.branch == LOAD:
        now.greatest = max(now.greatest, now.penetration)
    return now.penetration - before


@inner
def turned_over(now, count, penetration, residual):
    """The next branch, with the penetration where both meet."""
    if count.branch == LOAD:
        now.greatest = now.penetration = max(now.greatest, penetration)
        now.bit_velocity = 0.0
        count.branch = UNLOAD if now.greatest > 0.0 else OFF
    elif count.branch == OFF:
        now.penetration = residual
        count.branch = UNLOAD if now.greatest > 0.0 else LOAD
    elif 2.0 * penetration > residual + now.greatest:
        now.penetration, count.branch = now.greatest, LOAD
    else:
        now.penetration, count.branch = residual, OFF


@inner
def fed(machine, now, count, alone):
    """Feed the tool when it has been left alone for long enough and the striker leaves it the room.

    It lies at rest against fresh rock then, deeper by what the last blow has left, or at its old place.
    """
    bit = machine.bit
    residual = (1.0 - bit.ratio) * now.greatest
    advance = residual if bit.kept else 0.0
    gap = now.gap - now.moved + advance
    if alone < bit.wait or gap < 0.0:
        return
    now.gap, now.moved, now.met = gap, 0.0, 0.0
    now.advanced += advance
    now.rock_work += 0.5 * bit.stiffness * residual * now.greatest
    now.penetration, now.greatest, now.bit_velocity = -bit.gap, 0.0, 0.0
    count.branch = OFF if bit.gap > 0.0 else LOAD
    count.blow += 1
    count.struck = 0
    machine.rod.right[:] = 0.0
    machine.rod.left[:] = 0.0
