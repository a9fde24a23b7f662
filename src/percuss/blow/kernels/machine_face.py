"""A step at the face of striker and rod: contact decided within the cell."""

from __future__ import annotations

from percuss.blow.kernels.machine_records import Floats
from percuss.compiled import inlined, inner

_SAME_CONTACT = 1.5  # steps without contact that do not end one: smaller than a cell can tell


@inlined
def broken(before, here, after):
    """A cell's mean as two values: where in the cell the first ends, and both.

    The neighbours' values with the break that keeps the mean (Harten 1989: subcell resolution); the mean itself where
    it lies outside them.
    """
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


@inlined
def pressed(now, count, contacts, face, f, g, start, length, momentum):
    """A part of a cell in contact; returns the impulse."""
    force = face.stiffness * (f - g)
    one = contacts[count.contacts - 1]
    impulse = force * length
    one.impulse += impulse
    one.moment += impulse * (start + 0.5 * length - one.start)
    one.peak = max(one.peak, force)
    one.end = start + length
    one.momentum_after = momentum - impulse
    work = impulse * (2.0 * g + force * face.rod)
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
def meeting(now, count, contacts, face, push, time, step, f, f_next, g, g_next):
    """One step of the face: the waves that leave it into the striker and into the rod, means over the cell.

    f and g arrive (theory: v = f + g, N = Z (f − g)); `push` is the force that the load gives the striker meanwhile.
    """
    if now.gap > 2.0 * step * (max(now.arrived, f, f_next) - min(now.met, g, g_next)):  # out of reach
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
        length, closing = (end - at) * step, a - b
        start = time + at * step
        force = 0.0
        if now.gap > 0.0 and 2.0 * closing * length >= now.gap:
            free = now.gap / (2.0 * closing)
            now.gap, count.touching = 0.0, 0
            momentum += push * free
            now.moved += 2.0 * b * free
            back, ahead = back + a * free, ahead + b * free
            start, length = start + free, max(length - free, 0.0)
        if now.gap == 0.0 and closing > 0.0:
            if count.touching == 0:
                open_contact(now, count, contacts, start, momentum, step)
            touched = True
            impulse = pressed(now, count, contacts, face, a, b, start, length, momentum + push * length)
            momentum += push * length - impulse
            force = impulse / length if length > 0.0 else 0.0
        else:
            momentum += push * length
            now.gap = max(now.gap - 2.0 * closing * length, 0.0)
            if now.gap > 0.0:
                count.touching = 0
        now.moved += (2.0 * b + force * face.rod) * length
        back += (a - force * face.striker) * length
        ahead += (b + force * face.rod) * length
        at = end
    now.momentum = momentum
    now.arrived, now.met = f, g
    returned(now, face)
    return back / step, ahead / step, touched


__all__ = ["Floats", "meeting"]
