"""The motion of a machine on the lattice, step by step."""

from __future__ import annotations

import math

from percuss.blow.kernels.lattice_records import LOAD, OFF, REBOUNDED
from percuss.blow.kernels.tool_motion import bit_moved, carried_on, departure, recoil, recoiled, rock_replaced
from percuss.compiled import entry, inlined, inner, summed
from percuss.mechanics.oil_records import (
    AREA,
    COMPLIANCE,
    CORNER,
    CORNER_TO,
    DRAG_BACK,
    DRAG_OUT,
    FED,
    FLOW,
    FORCE,
    KAPPA,
    PRECHARGE,
    QUICKENING,
    RELIEF,
    SLOPE,
    SPOOL,
    TANK,
    TANKED,
)
from percuss.mechanics.oil_series import of_gas, pumped, supplied

# ---- A tool that is laid against fresh rock between blows


@inner
def fed(machine, now, count, alone):
    """Feed the tool when it has been left alone for long enough and the striker leaves it the room."""
    # It lies at rest against fresh rock then, deeper by what the last blow has left, or at its old place.
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
    for joint in range(machine.held.joint.size):
        one = machine.held.joint[joint]
        one.place, one.velocity, one.state = 0.0, 0.0, 0


# ---- What damping takes from the velocities of the striker's cells; their strain stays


@summed
def row_times(matrix, i, vector):
    """Row i of a matrix times a vector."""
    total = 0.0
    for j in range(vector.size):
        total += matrix[i, j] * vector[j]
    return total


@inlined
def places(cells, slot, cell):
    """Where the waves to the right and to the left are kept that are in a cell of a section now."""
    right, left = slot + cells - 1 - cell, slot + cell
    return right - cells if right >= cells else right, left - cells if left >= cells else left


@inlined
def gathered(chain, drag):
    """The velocity of every cell, in order of space, and its mean in every block."""
    at = 0
    drag.mean[:] = 0.0
    for i in range(chain.cells.size):
        first, cells, slot = chain.first[i], chain.cells[i], chain.slot[i]
        for cell in range(cells):
            right, left = places(cells, slot, cell)
            velocity = chain.right[first + right] + chain.left[first + left]
            drag.before[at] = velocity
            drag.mean[drag.block[at]] += drag.mass[at] * velocity
            at += 1
    for b in range(drag.mean.size):
        drag.mean[b] /= drag.total[b]


@inlined
def slowed(chain, drag, now):
    """Take velocity from every cell as the law of damping does in an interval."""
    gathered(chain, drag)
    carried = now.momentum if drag.carried else 0.0  # the mass is 1
    for b in range(drag.matrix.shape[0]):
        drag.change[b] = row_times(drag.matrix, b, drag.mean)
    at, taken = 0, 0.0
    for i in range(chain.cells.size):
        first, cells, slot = chain.first[i], chain.cells[i], chain.slot[i]
        for cell in range(cells):
            right, left = places(cells, slot, cell)
            before, block = drag.before[at], drag.block[at]
            if drag.matrix.size:
                change = drag.change[block] + drag.finer * (before - drag.mean[block])
            else:
                change = drag.factor * (before - carried)
            chain.right[first + right] += 0.5 * change
            chain.left[first + left] += 0.5 * change
            now.momentum += drag.mass[at] * change
            taken -= drag.mass[at] * change * (before + 0.5 * change)
            at += 1
    now.damped += taken
    now.energy -= taken


# ---- A step at the face of striker and rod: contact decided within the cell

_SAME_CONTACT = 1.5  # steps without contact that do not end one: smaller than a cell can tell


@inlined
def broken(before, here, after):
    """A cell's mean as two values: where in the cell the first ends, and both."""
    # The neighbours' values with the break that keeps the mean (Harten 1989: subcell resolution); the mean itself where
    # it lies outside them.
    if (here - after) * (before - here) <= 0.0:
        return 1.0, here, here
    return (here - after) / (before - after), before, after


@inner
def open_contact(now, count, contacts, time, momentum, step):
    """Begin the record of a contact, or go on with the last one after less than a cell without contact."""
    last = count.contacts - 1
    count.touching = count.struck = 1
    if last >= 0 and time - contacts[last].end < _SAME_CONTACT * step:
        return
    count.contacts += 1
    one = contacts[last + 1]
    one.start, one.end = time, time
    one.impulse, one.moment, one.peak, one.given = 0.0, 0.0, 0.0, 0.0
    one.momentum_before, one.energy_before = momentum, now.energy
    one.momentum_after, one.energy_after = momentum, now.energy
    one.averaged_before = one.averaged_after = now.averaged
    one.rock_before, one.advanced_before, one.blow = now.rock_work, now.advanced, count.blow
    one.left, one.stood = 0.0, 0.0


@inlined
def pressed(now, count, contacts, stiffness, rod, f, g, start, length, momentum):
    """A part of a cell in contact; returns the impulse."""
    force = stiffness * (f - g)
    one = contacts[count.contacts - 1]
    impulse = force * length
    one.impulse += impulse
    one.moment += impulse * (start + 0.5 * length - one.start)
    one.peak = max(one.peak, force)
    one.end = start + length
    one.momentum_after = momentum - impulse
    work = impulse * (2.0 * g + force * rod)
    one.given += work
    now.rod_work += work
    now.impulse += impulse
    return impulse


@inlined
def returned(now, face):
    """Put a rod that is pushed back where it was, as soon as the striker has left it the room."""
    if face.pushed_back and now.moved > 0.0 and now.gap >= now.moved:
        now.gap -= now.moved
        now.moved = 0.0


@inlined
def meeting(now, count, contacts, face, held, damped, push, time, step, f, f_next, g, g_next):
    """One step of the face: the waves that leave it into the striker and into the rod, means over the cell."""
    # f and g arrive (theory: v = f + g, N = Z (f − g)); `push` is the force that the load gives the striker meanwhile.
    near = 2.0 * step * (max(now.arrived, f, f_next) - min(now.met, g, g_next))
    if now.gap > near and not damped:  # out of reach
        now.momentum += push * step
        now.gap -= 2.0 * (f - g) * step
        now.moved += 2.0 * g * step
        now.arrived, now.met, count.touching = f, g, 0
        returned(now, face)
        return f, g, False
    first, f_left, f_right = broken(now.arrived, f, f_next)
    second, g_left, g_right = broken(now.met, g, g_next)
    back, ahead, at, touched = 0.0, 0.0, 0.0, False
    momentum = now.momentum
    while at < 1.0:
        end = 1.0
        if at < first < end:
            end = first
        if at < second < end:
            end = second
        a = f_left if at < first else f_right
        b = g_left if at < second else g_right
        length, stiffness, rod, open_, acting = (end - at) * step, face.stiffness, face.rod, b, False
        if damped:
            open_, rod, acting = recoil(
                held, held.tool[0].place, 1.0 / face.rod, 2.0 * a, b, length, now.gap == 0.0, face.striker
            )
            stiffness = 2.0 / (face.striker + rod)
        closing = a - open_
        start = time + at * step
        force = 0.0
        if now.gap > 0.0 and 2.0 * closing * length >= now.gap:
            free = now.gap / (2.0 * closing)
            now.gap, count.touching = 0.0, 0
            momentum += push * free
            now.moved += 2.0 * open_ * free
            back, ahead = back + a * free, ahead + b * free
            if damped:
                ahead += 2.0 * (open_ - b) * free
                recoiled(held, held.tool[0], 2.0 * open_, free, acting)
            start, length = start + free, max(length - free, 0.0)
            if damped:
                open_, rod, acting = recoil(
                    held, held.tool[0].place, 1.0 / face.rod, 2.0 * a, b, length, True, face.striker
                )
                stiffness = 2.0 / (face.striker + rod)
        if now.gap == 0.0 and closing > 0.0:
            if count.touching == 0:
                open_contact(now, count, contacts, start, momentum, step)
            touched = True
            impulse = pressed(now, count, contacts, stiffness, rod, a, open_, start, length, momentum + push * length)
            momentum += push * length - impulse
            force = impulse / length if length > 0.0 else 0.0
        else:
            momentum += push * length
            now.gap = max(now.gap - 2.0 * closing * length, 0.0)
            if now.gap > 0.0 or held.kept:  # a contact ends with its force
                count.touching = 0
        now.moved += (2.0 * open_ + force * rod) * length
        back += (a - force * face.striker) * length
        ahead += (b + force * rod) * length
        if damped:
            ahead += 2.0 * (open_ - b) * length
            recoiled(held, held.tool[0], 2.0 * open_ + force * rod, length, acting)
        at = end
    now.momentum = momentum
    now.arrived, now.met = f, g
    returned(now, face)
    return back / step, ahead / step, touched


# ---- The motion of a machine on the lattice, step by step


@inlined
def through(chain, entering, force, force_at):
    """One step of the waves at all inner steps of a chain; `force` acts at the step with the number `force_at`."""
    # `entering` goes into the first section at its left end. What comes out at both ends is read before by the caller,
    # who puts in afterwards what enters at the right end.
    right, left, slot, first = chain.right, chain.left, chain.slot, chain.first
    enters = entering
    for i in range(chain.cells.size):
        here = first[i] + slot[i]
        f = right[here]
        right[here] = enters
        if i + 1 < chain.cells.size:
            there = first[i + 1] + slot[i + 1]
            za, zb = chain.impedance[i], chain.impedance[i + 1]
            push = force if force_at == i + 1 else 0.0
            speed = (2.0 * (za * f + zb * left[there]) + push) / (za + zb)
            left[here] = speed - f
            enters = speed - left[there]


@inlined
def turned(chain):
    """The next slot of every section."""
    for i in range(chain.cells.size):
        chain.slot[i] += 1
        if chain.slot[i] == chain.cells[i]:
            chain.slot[i] = 0


@inlined
def from_the_end(machine, now, count, out):
    """The wave that comes back from the far end of the rod."""
    if machine.bit.fed:
        return bit_moved(machine.bit, now, count, out, machine.step) / machine.step - out
    z, behind = machine.rod.impedance[machine.rod.cells.size - 1], machine.face.behind
    return -out if math.isinf(behind) else out * (z - behind) / (z + behind)


@inlined
def stepped(machine, now, count, contacts):
    """One step of the whole machine."""
    bar, rod, face, step = machine.striker, machine.rod, machine.face, machine.step
    load, last = machine.load[count.step], bar.cells.size - 1
    time = now.time + count.step * step
    # what arrives at the ends, before new waves take its place
    here = bar.first[last] + bar.slot[last]
    after = bar.slot[last] + 1
    f = bar.right[here]
    f_next = bar.right[bar.first[last] + (after if after < bar.cells[last] else 0)]
    arrived = bar.left[bar.first[0] + bar.slot[0]]
    z = bar.impedance[0]
    if machine.load_at == 0:
        entering = arrived + load / z
        speed = arrived + entering
    else:
        entering = arrived
        at = machine.load_at
        a, b = bar.first[at - 1] + bar.slot[at - 1], bar.first[at] + bar.slot[at]
        za, zb = bar.impedance[at - 1], bar.impedance[at]
        speed = (2.0 * (za * bar.right[a] + zb * bar.left[b]) + load) / (za + zb)
    g, g_next = 0.0, 0.0
    held = machine.held
    if rod.cells.size:
        g = rod.left[rod.first[0] + rod.slot[0]]
        after = rod.slot[0] + 1
        g_next = rod.left[rod.first[0] + (after if after < rod.cells[0] else 0)]
        if held.active:
            g *= held.decay[0]
            g_next *= held.decay[0]
    work = load * speed * step
    given, moved = now.rod_work, now.moved
    through(bar, entering, load, machine.load_at)
    struck = count.struck
    damped = held.active and held.at == 0 and held.stiffness + held.damping > 0.0
    back, ahead, touched = meeting(now, count, contacts, face, held, damped, load, time, step, f, f_next, g, g_next)
    bar.left[here] = back
    if held.renews and struck == 0 and count.struck == 1:
        one = contacts[count.contacts - 1]
        one.left = departure(machine, now)
        one.stood = 1.0 if held.tool[0].rock_force > 0.0 else 0.0
    if held.active:
        if held.at == 0 and not damped:
            held.tool[0].place += now.moved - moved
            held.tool[0].force_work += held.force * (now.moved - moved)
            held.tool[0].feed_impulse += held.force * step
        carried_on(machine, now, count, ahead, time)
        turned(rod)
    elif rod.cells.size:
        end = rod.first[rod.cells.size - 1] + rod.slot[rod.cells.size - 1]
        out = rod.right[end]
        through(rod, ahead, 0.0, 0)
        rod.left[end] = from_the_end(machine, now, count, out)
        turned(rod)
    turned(bar)
    lost = bar.impedance[last] * step * (f * f - back * back)
    now.load_work += work
    now.energy += work - lost
    now.averaged += lost - (now.rod_work - given)
    if touched:
        contacts[count.contacts - 1].energy_after = now.energy
        contacts[count.contacts - 1].averaged_after = now.averaged
    elif machine.bit.fed and count.struck and not count.touching:
        if now.momentum < 0.0:
            count.struck = REBOUNDED
        elif count.struck == REBOUNDED and held.renews:
            rock_replaced(machine.bit, held, now, count)
        elif count.struck == REBOUNDED and not held.kept:
            fed(machine, now, count, time + step - contacts[count.contacts - 1].end)
    count.step += 1


@entry
def follow(machine, now, count, contacts, steps):
    """Go on for at most so many steps, to the end of the load's period or until the log is full; returns those done."""
    now, count = now[0], count[0]
    drag = machine.drag
    active = drag.interval > 0.0
    for done in range(steps):
        if count.contacts >= contacts.size - 2 or count.step >= machine.load.size:
            return done
        stepped(machine, now, count, contacts)
        if active and count.step >= now.next_drag:
            now.next_drag += drag.interval
            time = now.time + count.step * machine.step
            if not count.touching or time - contacts[count.contacts - 1].start > drag.patience:
                slowed(machine.striker, drag, now)
    return steps


@entry
def struck_again(machine, now, count, velocity, new_rock):
    """A fresh striker, free of stress, touches the face of the tool as it is; `new_rock`: in front of fresh rock."""
    now, count = now[0], count[0]
    bar, held, bit = machine.striker, machine.held, machine.bit
    now.momentum, now.energy = 0.0, 0.0
    for i in range(bar.cells.size):
        for cell in range(bar.cells[i]):
            bar.right[bar.first[i] + cell] = bar.left[bar.first[i] + cell] = 0.5 * velocity[i]
        mass = bar.impedance[i] * bar.cells[i] * machine.step
        now.momentum += mass * velocity[i]
        now.energy += 0.5 * mass * velocity[i] * velocity[i]
    now.arrived, now.gap = 0.5 * velocity[bar.cells.size - 1], 0.0
    count.contacts, count.touching, count.struck = 0, 0, 0
    if bit.fed and bit.stiffness > 0.0 and new_rock:
        rock_replaced(bit, held, now, count)
    tool = held.tool[0]
    tool.bit_contacts, tool.rock_peak = 0, tool.rock_force
    if tool.rock_force > 0.0:
        one = held.bit_log[0]
        one.start, one.end, one.impulse, one.peak = now.time, math.nan, 0.0, tool.rock_force
        tool.bit_contacts = 1
    for i in range(held.extreme.shape[0]):
        held.extreme[i, 0] = held.extreme[i, 1] = held.preload[i]


# ---- A striker that switches its own valve: the load of each step by the state, the ports that it enters, the orders


@inner
def demanded(valve, own, port, time):
    """A port demands its state: a demand like the last is ignored, others replace what would be due later."""
    if valve.to[port] == own.last:
        return
    due = time + valve.delay[port] / (1.0 + valve.law[QUICKENING] * (own.pressure - 1.0))
    kept = 0
    while kept < own.orders and own.due[kept] < due:
        kept += 1
    if kept < own.due.size:
        own.due[kept], own.to[kept] = due, valve.to[port]
        own.orders = kept + 1
    own.last = valve.to[port]


@inner
def joined(valve, own, time, step):
    """Means over a step of what the states join, into `mean`; orders that fall due in it are carried out."""
    at, end = time, time + step
    own.mean[:] = 0.0
    while True:
        due = max(own.due[0], at) if own.orders > 0 else math.inf
        until = min(due, own.stroke, end)
        span = until - at
        for j in range(own.mean.size):
            own.mean[j] += span * (own.blend[j] + 0.5 * span * own.slope[j])
            own.blend[j] += span * own.slope[j]
        at = until
        if until == end:
            break
        stroke = 0.0
        if due == until:
            own.state, stroke = own.to[0], valve.law[SPOOL]
            own.orders -= 1
            for i in range(own.orders):
                own.due[i], own.to[i] = own.due[i + 1], own.to[i + 1]
        own.stroke = at + stroke if stroke > 0.0 else math.inf
        for j in range(own.mean.size):
            aim = valve.joins[own.state, j]
            own.slope[j] = (aim - own.blend[j]) / stroke if stroke > 0.0 else 0.0
            own.blend[j] = own.blend[j] if stroke > 0.0 else aim
    for j in range(own.mean.size):
        own.mean[j] /= step


@inner
def driven(machine):
    """The velocity that the driven place has without a load, and what divides the load there."""
    bar, at = machine.striker, machine.load_at
    if at == 0:
        return 2.0 * bar.left[bar.first[0] + bar.slot[0]], bar.impedance[0]
    a, b = bar.first[at - 1] + bar.slot[at - 1], bar.first[at] + bar.slot[at]
    za, zb = bar.impedance[at - 1], bar.impedance[at]
    return 2.0 * (za * bar.right[a] + zb * bar.left[b]) / (za + zb), za + zb


@inner
def braked(load, free, z, out, back):
    """The load less b v|v| of the passages, and the velocity v = free + load/z with it."""
    without = free + load / z
    b = out if without > 0.0 else back
    if b == 0.0:
        return load, without
    v = math.copysign((math.sqrt(1.0 + 4.0 * b / z * abs(without)) - 1.0) * z / (2.0 * b), without)
    return load - b * v * abs(v), v


@entry
def follow_valve(machine, valve, own, now, count, contacts, steps):
    """Go on for at most so many steps, to the end of a turn of the lattice or until the log is full; returns those."""
    own, now, count = own[0], now[0], count[0]
    step, drag = machine.step, machine.drag
    for done in range(steps):
        if count.contacts >= contacts.size - 2 or count.step >= machine.load.size:
            return done
        time = now.time + count.step * step
        joined(valve, own, time, step)
        area, law = own.mean[AREA], valve.law
        place, speed, struck, fed_by = own.place, now.momentum, count.struck, now.advanced
        middle = place + 0.5 * step * speed
        pressure = own.pressure + 0.5 * step * own.rise
        load, drawn = pressure * area + law[FORCE] - law[KAPPA] * middle, 0.0
        if valve.flows:
            load += law[TANK] * own.mean[TANKED] + of_gas(law, middle)
            free, z = driven(machine)
            load, drawn = braked(load, free, z, own.mean[DRAG_OUT], own.mean[DRAG_BACK])
            drawn *= area
        machine.load[count.step] = load
        stepped(machine, now, count, contacts)
        moved = 0.5 * step * (speed + now.momentum)
        own.place += moved
        if now.advanced != fed_by:  # the housing follows the tool
            own.place -= now.advanced - fed_by
            place = own.place - moved
        if not valve.flows:
            own.taken += own.pressure * area * moved
            if law[FED] > 0.0:
                own.pressure += (law[FLOW] * step - area * moved) / law[COMPLIANCE]
        elif law[FED] > 0.0:
            limited = law[CORNER] < pressure < law[CORNER_TO]
            opened = pressure > law[RELIEF] and law[SLOPE] < math.inf
            own.taken += pressure * pumped(law, pressure, limited) * step
            rise, capacity, _ = supplied(law, pressure, drawn, limited, opened, pressure > law[PRECHARGE])
            own.rise = rise / capacity
            own.pressure = max(own.pressure + step * own.rise, 0.0)
            if own.pressure > law[RELIEF] and law[SLOPE] == math.inf:
                own.pressure, own.rise = law[RELIEF], 0.0
        else:
            own.taken += pressure * drawn * step
        if drag.interval > 0.0 and count.step >= now.next_drag:
            now.next_drag += drag.interval
            if not count.touching:
                slowed(machine.striker, drag, now)
        if struck == 0 and count.struck == 1:
            # places count from where the faces touch: steel that attenuates has crept a little since the last blow
            own.touched = 1
            own.place = (time + step - contacts[count.contacts - 1].start) * now.momentum
            place = own.place - moved
        blow = own.touched == 1 and not count.touching
        for port in range(valve.to.size):
            if valve.sign[port] == 0.0:
                if blow:
                    demanded(valve, own, port, time + step)
                continue
            before = valve.sign[port] * ((speed if valve.speed[port] else place) - valve.level[port])
            after = valve.sign[port] * ((now.momentum if valve.speed[port] else own.place) - valve.level[port])
            jumps = valve.speed[port] and (count.touching == 1 or own.touched == 1)
            if before <= 0.0 < after and not jumps:
                demanded(valve, own, port, time + step * before / (before - after))
        if blow:
            own.touched = 0
    return steps
