"""The motion of a machine on the lattice, step by step."""

from __future__ import annotations

import math

from percuss.blow.kernels.machine_bit import bit_moved, fed
from percuss.blow.kernels.machine_drag import slowed
from percuss.blow.kernels.machine_face import meeting
from percuss.blow.kernels.machine_records import REBOUNDED
from percuss.compiled import entry, inlined


@inlined
def through(chain, entering, force, force_at):
    """One step of the waves at all inner steps of a chain; `force` acts at the step with the number `force_at`.

    `entering` goes into the first section at its left end. What comes out at both ends is read before by the caller,
    who puts in afterwards what enters at the right end.
    """
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
    if rod.cells.size:
        g = rod.left[rod.first[0] + rod.slot[0]]
        after = rod.slot[0] + 1
        g_next = rod.left[rod.first[0] + (after if after < rod.cells[0] else 0)]
    work = load * speed * step
    given = now.rod_work
    through(bar, entering, load, machine.load_at)
    back, ahead, touched = meeting(now, count, contacts, face, load, time, step, f, f_next, g, g_next)
    bar.left[here] = back
    if rod.cells.size:
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
        elif count.struck == REBOUNDED:
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
