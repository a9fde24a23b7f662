"""The nodes of a tool on the lattice: bit and rock, joints, feed and recoil damper, each in closed form in a cell."""

from __future__ import annotations

import math

from percuss.blow.kernels.lattice_records import (
    CAUGHT,
    CONTACT_JOINT,
    ELASTIC,
    LOAD,
    MASS,
    OFF,
    OPEN,
    SHUT,
    UNLOAD,
)
from percuss.compiled import inlined, inner

# ---- The far end of a tool that is fed between blows: a bit, with or without a mass, on rock that yields
#
# m v' + Z v + F = 2 Z f, u' = v, g = v − f, with F = K u while the bit goes deeper than ever, K/γ (u − u_r) on the way
# back and forward again, u_r = (1 − γ) u_m, and no force beyond (Lundberg 1973). f is its mean over a step.

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


# ---- What joins two sections of a tool, and what holds it there
#
# f and g are the departures that arrive, means over a cell; N_0 is the static force. Returned are the mean velocities
# of both faces, from which g_a = v_a − f_a and f_b = v_b − g_b.

_AT_REST = 1e-13  # of a force over an impedance: rounding of a static state opens no joint


@inner
def pull(held, total, mass, drive, place, velocity):
    """Q of the acting feed: F − k_d y − c_d v, which is above 0 exactly while it acts."""
    if mass == 0.0:
        velocity = (drive - held.stiffness * place) / (total + held.damping)
    return held.force - held.stiffness * place - held.damping * velocity


@inner
def fed_node(held, tool, joint, total, mass, drive, step):
    """Carry a fed step on: m v' + (Z_a + Z_b + c_d) v + k_d y = 2 Z_a f + 2 Z_b g, lifted without Q."""
    left, begun = step, tool.place
    acting = pull(held, total, mass, drive, tool.place, joint.velocity) > 0.0
    for turn in range(_MOST_TURNS):
        z, k, b = total, 0.0, drive - held.force
        if acting:
            z, k, b = total + held.damping, held.stiffness, drive
        y, v = tool.place, joint.velocity
        after, velocity = bit_after(z, mass, k, 0.5 * b / z, y, v, left)
        length = left
        turns = (pull(held, total, mass, drive, after, velocity) > 0.0) != acting and turn < _MOST_TURNS - 1
        if turns:
            low, high = 0.0, left
            for _ in range(_HALVINGS):
                length = 0.5 * (low + high)
                after, velocity = bit_after(z, mass, k, 0.5 * b / z, y, v, length)
                if (pull(held, total, mass, drive, after, velocity) > 0.0) != acting:
                    high = length
                else:
                    low = length
        moved = after - y
        if acting:
            square = (drive * moved - 0.5 * k * (after * after - y * y)) / z  # ∫ v² dt
            if mass > 0.0:
                square -= 0.5 * mass * (velocity * velocity - v * v) / z
            tool.force_work += held.force * moved
            tool.spring_work -= 0.5 * k * (after * after - y * y)
            tool.damper_loss += held.damping * square
            tool.feed_impulse += held.force * length + total * moved - drive * length
            if mass > 0.0:
                tool.feed_impulse += mass * (velocity - v)
        tool.place, joint.velocity = after, velocity
        if not turns:
            break
        left -= length
        acting = not acting
    return (tool.place - begun) / step


@inner
def elastic_joint(joint, spring, dashpot, y, f, g, step):
    """The mean of N − N_0: N (1 + c Y) = k δ + 2 c (f − g), δ' = 2 (f − g) − Y N."""
    rate, wide = y * spring / (1.0 + dashpot * y), 2.0 * (f - g)
    slope = (wide - y * spring * joint.place) / (1.0 + dashpot * y)  # δ' when the cell begins
    moved = -slope * math.expm1(-rate * step) / rate
    joint.place += moved
    joint.loss -= dashpot * slope * slope * math.expm1(-2.0 * rate * step) / (2.0 * rate)
    return (wide - moved / step) / y


@inner
def contact_joint(joint, slack, preload, y, f, g, time, step):
    """The mean of N − N_0: a step while N > 0, open with free faces, caught by the thread at the slack."""
    force = preload + 2.0 * (f - g) / y  # if the faces are shut, or caught
    pressed, left = 0.0, step
    if abs(force * y) < _AT_REST and joint.state == SHUT:
        return force - preload
    if (joint.state == SHUT and force < 0.0) or (joint.state == CAUGHT and force > 0.0):
        if joint.state == SHUT:
            joint.openings += 1
            if joint.opened < 0.0:
                joint.opened = time
        joint.state = OPEN
    if joint.state == OPEN:
        after = joint.place - force * y * left
        bound = 0.0 if force > 0.0 else slack
        if (force > 0.0 and after <= 0.0) or (force < 0.0 and after >= slack):
            left -= (joint.place - bound) / (force * y)
            joint.state, joint.place = SHUT if force > 0.0 else CAUGHT, bound
            if force > 0.0 and joint.closed < 0.0:
                joint.closed = time + step - left
        else:
            joint.place, left = after, 0.0
        joint.widest = max(joint.widest, joint.place)
    pressed = force * left
    return pressed / step - preload


@inner
def joined(held, i, za, zb, f, g, time, step):
    """The mean velocities of both faces of the step behind section i."""
    kind, joint, total = held.kind[i], held.joint[i], za + zb
    drive = 2.0 * (za * f + zb * g)
    if kind == MASS:
        if held.at == i + 1:
            v = fed_node(held, held.tool[0], joint, total, held.mass[i], drive, step)
        else:
            before = joint.place
            joint.place, joint.velocity = bit_after(
                total, held.mass[i], 0.0, 0.5 * drive / total, before, joint.velocity, step
            )
            v = (joint.place - before) / step
        return v, v
    if kind == ELASTIC:
        force = elastic_joint(joint, held.spring[i], held.dashpot[i], 1.0 / za + 1.0 / zb, f, g, step)
    elif kind == CONTACT_JOINT:
        force = contact_joint(joint, held.slack[i], held.preload[i], 1.0 / za + 1.0 / zb, f, g, time, step)
    else:
        return drive / total, drive / total
    return 2.0 * f - force / za, 2.0 * g + force / zb


@inner
def recoil(held, place, z, closing, g, length, shut, striker):
    """At the struck face: half the velocity of the open face, what a force there adds, and whether the feed acts."""
    # k_d y is taken in the middle of the part of a cell that is `length` long; `closing` is twice the wave that
    # arrives in the striker, `striker` 1/Z of it, `shut` whether the faces touch.
    own = z + held.damping + 0.5 * held.stiffness * length
    free = (2.0 * z * g - held.stiffness * place) / own
    v = free
    if shut and closing > free:
        v += (closing - free) / (striker + 1.0 / own) / own
    if held.force - held.stiffness * (place + 0.5 * v * length) - held.damping * v > 0.0:
        return 0.5 * free, 1.0 / own, True
    return g - 0.5 * held.force / z, 1.0 / z, False


@inlined
def recoiled(held, tool, v, length, acting):
    """A part of a cell in which the struck face has moved with v: what the feed has done there."""
    moved = v * length
    if acting:
        middle = tool.place + 0.5 * moved
        tool.force_work += held.force * moved
        tool.spring_work -= held.stiffness * middle * moved
        tool.damper_loss += held.damping * v * moved
        tool.feed_impulse += held.force * length - held.stiffness * middle * length - held.damping * moved
    tool.place += moved


# ---- The far end of a tool that is held, and its rock


@inner
def bit_held(machine, now, count, f, time):
    """Carry the bit on by a step in which the departure f arrives; returns the departure that goes back."""
    bit, tool, step, last = machine.bit, machine.held.tool[0], machine.step, machine.rod.cells.size - 1
    static = machine.held.preload[last]
    total = f + 0.5 * static / bit.impedance
    before, speed = now.penetration - (1.0 - bit.ratio) * now.greatest, now.bit_velocity
    moved = bit_moved(bit, now, count, total, step)
    impulse = bit.impedance * (2.0 * total * step - moved)
    if bit.mass > 0.0:
        impulse -= bit.mass * (now.bit_velocity - speed)
    force, after = bit_force(bit, now, count), now.penetration - (1.0 - bit.ratio) * now.greatest
    n = tool.bit_contacts
    if force > 0.0 or tool.rock_force > 0.0:
        tool.rock_impulse += impulse
        tool.rock_peak = max(tool.rock_peak, force)
        if tool.rock_force == 0.0 and n < machine.held.bit_log.size:
            one = machine.held.bit_log[n]
            one.start = time + (step * before / (before - after) if before < 0.0 < after else 0.0)
            one.impulse, one.peak, one.end = 0.0, 0.0, math.nan
            tool.bit_contacts += 1
        if tool.bit_contacts > 0:
            one = machine.held.bit_log[tool.bit_contacts - 1]
            one.impulse += impulse
            one.peak = max(one.peak, force)
            if force == 0.0:
                one.end = time + (step * before / (before - after) if after < 0.0 < before else step)
    tool.rock_force = force
    return moved / step - f


@inlined
def bit_force(bit, now, count):
    """The force on the rock now."""
    if count.branch == LOAD:
        return max(bit.stiffness * now.penetration, 0.0)
    if count.branch == OFF:
        return 0.0
    return max(bit.stiffness / bit.ratio * (now.penetration - (1.0 - bit.ratio) * now.greatest), 0.0)


@inner
def rock_replaced(bit, held, now, count):
    """Lay fresh rock before the bit at equal force; a bit that is off keeps its distance."""
    # u = u_m = F/K_1, or u − u_r with u_m = 0; the tool is fed by what the bit has gone deeper
    tool = held.tool[0]
    before, force = now.penetration, bit_force(bit, now, count)
    now.rock_work += 0.5 * bit.stiffness * (1.0 - bit.ratio) * now.greatest * now.greatest
    if force > 0.0:
        now.penetration = now.greatest = force / bit.stiffness
        count.branch = LOAD
    else:
        now.penetration = min(now.penetration - (1.0 - bit.ratio) * now.greatest, 0.0)
        now.greatest = 0.0
        count.branch = OFF
    now.rock_work -= 0.5 * bit.stiffness * (1.0 - bit.ratio) * now.greatest * now.greatest
    advance = before - now.penetration
    now.advanced += advance
    tool.place -= advance
    tool.renewals += 1
    if force > 0.0:
        tool.standing += 1
    count.blow += 1
    count.struck = 0


@inner
def departure(machine, now):
    """Energy of what departs from the static state in the tool, its masses and the springs of its joints."""
    rod, held = machine.rod, machine.held
    total = 0.5 * machine.bit.mass * now.bit_velocity * now.bit_velocity
    for i in range(rod.cells.size):
        cells, sum_ = rod.cells[i], 0.0
        fade = held.decay[i] ** (2.0 / cells)  # of the energy, in a cell
        for wave in (rod.right, rod.left):
            share = held.decay[i] ** (1.0 / cells)
            for j in range(cells - 1, -1, -1):  # from the wave that has just entered on
                at = rod.slot[i] + j
                if at >= cells:
                    at -= cells
                sum_ += share * wave[rod.first[i] + at] * wave[rod.first[i] + at]
                share *= fade
        total += rod.impedance[i] * machine.step * sum_
    for i in range(held.kind.size):
        one = held.joint[i]
        if held.kind[i] == ELASTIC:
            total += 0.5 * held.spring[i] * one.place * one.place
        total += 0.5 * held.mass[i] * one.velocity * one.velocity
    return total


# ---- One step of all waves in a tool that is held


@inlined
def looked_at(held, right, left, first, cells, slot, i, z):
    """Note the forces at some places of a section."""
    for p in range(held.cell.shape[1]):
        at = held.cell[i, p]
        there, back = slot + cells - 1 - at, slot + at
        if there >= cells:
            there -= cells
        if back >= cells:
            back -= cells
        force = held.preload[i] + z * (
            held.fade_right[i, p] * right[first + there] - held.fade_left[i, p] * left[first + back]
        )
        held.extreme[i, 0] = min(held.extreme[i, 0], force)
        held.extreme[i, 1] = max(held.extreme[i, 1], force)


@inlined
def lost_on_the_way(z, step, static, before, after):
    """Energy that steel takes from a wave, with the static one that it goes along with."""
    return z * step * (before - after) * (2.0 * static + before + after)


@inner
def carried_on(machine, now, count, entering, time):
    """One step of the waves in the tool; `entering` goes in at the struck face."""
    rod, held, step = machine.rod, machine.held, machine.step
    tool, last, enters = held.tool[0], rod.cells.size - 1, entering
    here = rod.first[0] + rod.slot[0]
    static = 0.5 * held.preload[0] / rod.impedance[0]
    tool.steel_loss += lost_on_the_way(rod.impedance[0], step, -static, rod.left[here], held.decay[0] * rod.left[here])
    for i in range(rod.cells.size):
        looked_at(held, rod.right, rod.left, rod.first[i], rod.cells[i], rod.slot[i], i, rod.impedance[i])
        here, z = rod.first[i] + rod.slot[i], rod.impedance[i]
        raw = rod.right[here]
        f, static = held.decay[i] * raw, 0.5 * held.preload[i] / z
        tool.steel_loss += lost_on_the_way(z, step, static, raw, f)
        rod.right[here] = enters
        if i < last:
            there, zb = rod.first[i + 1] + rod.slot[i + 1], rod.impedance[i + 1]
            raw = rod.left[there]
            g = held.decay[i + 1] * raw
            tool.steel_loss += lost_on_the_way(zb, step, -0.5 * held.preload[i + 1] / zb, raw, g)
            va, vb = joined(held, i, z, zb, f, g, time, step)
            rod.left[here] = va - f
            enters = vb - g
        elif machine.bit.fed:
            rod.left[here] = bit_held(machine, now, count, f, time)
        else:
            behind = machine.face.behind
            back = -f if math.isinf(behind) else f * (z - behind) / (z + behind)
            rod.left[here] = back
            tool.out += z * step * (f + back) * (f - back + 2.0 * static)
