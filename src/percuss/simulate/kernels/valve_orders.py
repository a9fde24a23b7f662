"""Demands and orders of the valve, its record, and the time that goes by."""

from __future__ import annotations

from percuss.compiled import inlined, inner
from percuss.simulate.kernels.calls import STATE_NUMBERS
from percuss.simulate.kernels.codes import PORT


@inner
def enter(kind, before, lost, kinetic, detail, motion, controls, log):
    """One event with the state after it, unless the record has no rows."""
    if log.events.shape[0] == 0:
        return
    now, count, valve, z, states = motion.now, motion.count, controls.now, motion.z, log.states
    i = count.events
    count.events += 1
    event = log.events[i]
    event.time, event.before, event.after = valve.time + valve.time_low, before, now.gap_rate
    event.lost, event.kinetic, event.kind, event.state, event.detail = lost, kinetic, kind, valve.state, detail
    n = z.shape[1]
    if states.shape[0] == 0:
        return
    states[i, 0], states[i, 1] = now.gap, now.rigid_rate
    for j in range(n):
        states[i, STATE_NUMBERS + j] = z[0, j]
        states[i, STATE_NUMBERS + n + j] = z[1, j]


@inner
def demand(gear, motion, controls, port, rate, log):
    """A port demands its state: ignored when it was demanded last; a later demand replaces what would come after it.

    `rate`: of what the port reads.
    """
    valve, due, order, to = controls.now, controls.due, controls.order, gear.to[port]
    if to == valve.last:
        return
    valve.last = to
    while valve.waiting > 0 and due[valve.waiting - 1] >= gear.delay[port]:
        valve.waiting -= 1
    due[valve.waiting], order[valve.waiting] = gear.delay[port], to  # there is room: see `CROWDED`
    valve.waiting += 1
    enter(PORT, rate, 0.0, 0.0, port, motion, controls, log)


@inner
def next_order(controls):
    """The state of the order that is due first, which waits no longer."""
    valve, due, order = controls.now, controls.due, controls.order
    to = order[0]
    valve.waiting -= 1
    for i in range(valve.waiting):
        due[i], order[i] = due[i + 1], order[i + 1]
    return to


@inlined
def go_by(motion, controls, tau):
    """The time τ has gone by: the clock, exact to twice the digits, and all that counts down."""
    now, valve = motion.now, controls.now
    total = valve.time + tau
    back = total - valve.time
    valve.time_low += (valve.time - (total - back)) + (tau - back)
    valve.time = total
    for i in range(valve.waiting):
        controls.due[i] -= tau
    for j in range(controls.just.shape[0]):
        controls.just[j] = 0
    now.since += tau
    valve.clear -= tau
    valve.lap -= tau
    valve.awaited = valve.awaited - tau if valve.awaited > tau else 0.0
    now.hold = now.hold - tau if now.hold > tau else 0.0
