"""The records of a machine that switches its own valve, beside those of `layout`.

The state at an instant is that of a bar under a constant load, with the modes of the machine: decoupled motions m_i, of
which the first takes the part of the rigid motion, on the spring of the gas chamber if there is one. q_i is what m_i
moves the striking end by. Besides, there are the state of the valve and the orders that wait for their time.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from percuss.simulate.kernels.layout import Desk, Floats, Motion, Table, Wholes

VALVE_EVENT = np.dtype(
    [
        ("time", "f8"),  # since the start
        ("before", "f8"),  # rate of the striking end, or of what a port reads
        ("after", "f8"),
        ("lost", "f8"),
        ("kinetic", "f8"),
        ("kind", "i8"),
        ("state", "i8"),  # of the valve, after it
        ("detail", "i8"),  # number of the port; of a chatter, how many of its impacts are recorded
    ]
)


class ValveLog(NamedTuple):
    """The record of a stretch of motion: VALVE_EVENTs, and the state after each, as in `Log`; no rows for none."""

    events: npt.NDArray[np.void]
    states: Floats


class Gear(NamedTuple):
    """The valve: `forces` (S,) of its states; the others (P,) for each port.

    `to`: the state demanded. `edge`: distance of the port behind the wall. `side`: 1 where the region is in front of
    it, −1 behind it, 0 for the blow. `ratio` (P, N+1): what q_i moves the place that the port reads by; `rigid`: 1
    where it reads the rigid motion alone. `gain`: acceleration of q_0 under a unit force. On
    a chamber, `still`: what the port reads under a constant unit force; `sway`: how far at most it is from there, of
    the root of twice the energy about that place.
    """

    forces: Floats
    to: Wholes
    edge: Floats
    side: Floats
    delay: Floats
    ratio: Floats
    rigid: Wholes
    gain: float
    still: Floats
    sway: Floats


VALVE_NOW = np.dtype(
    [
        ("time", "f8"),  # since the start …
        ("time_low", "f8"),  # … and what its rounding has lost
        ("clear", "f8"),  # time from the anchor on for which no contact is possible
        ("awaited", "f8"),  # time to the contact that was found already, after what came first; 0 for none
        ("lap", "f8"),  # time after a release for which the ripple of the modes may lap at the wall
        ("window", "f8"),  # time at which the last `MANY` changes of state began
        ("changed", "f8"),  # time of the last change of state
        ("state", "i8"),
        ("last", "i8"),  # the last demand
        ("waiting", "i8"),  # orders that wait
        ("fresh", "i8"),  # whether no contact was found since the last change
        ("pulled", "i8"),  # whether the force has pulled since the last impact
        ("changes", "i8"),
        ("recent", "i8"),  # those in the window
        ("blows", "i8"),  # main blows: a completed chatter counts once
        ("rests", "i8"),
        ("chatters", "i8"),
        ("taken", "f8"),  # energy lost so far
        ("strongest", "f8"),  # striking speed since the remembered state
        ("stalled", "i8"),  # whether nothing but ever weaker blows can follow, on the gas of the chamber
        ("pauses", "i8"),  # looks at a motion in the chamber in which nothing happens
        # the state that later ones are compared with, at a change of the valve
        ("memo_gap", "f8"),
        ("memo_rate", "f8"),
        ("memo_rigid", "f8"),
        ("memo_time", "f8"),
        ("memo_taken", "f8"),
        ("memo_state", "i8"),
        ("memo_last", "i8"),
        ("memo_waiting", "i8"),
        ("memo_changes", "i8"),
        ("memo_blows", "i8"),
        ("memo_rests", "i8"),
        ("memo_chatters", "i8"),
        ("memo_impacts", "i8"),
        ("patience", "i8"),
        # the cycle that was found: its period, changes of state, blows, valve cycles, and where it begins
        ("period", "f8"),
        ("cycle_taken", "f8"),
        ("cycle_speed", "f8"),
        ("cycle_changes", "i8"),
        ("cycle_blows", "i8"),
        ("cycle_turns", "i8"),
        ("cycle_kind", "i8"),
        ("confirmed", "i8"),
        ("found_at", "i8"),
    ]
)

TURNING = np.dtype([("interval", "f8"), ("gap", "f8"), ("rate", "f8"), ("state", "i8")])
"""One of the last changes of the valve."""


class Controls(NamedTuple):
    """What of a machine changes besides the bar.

    `now`: a VALVE_NOW. `usual` (S,), `usual_cross` (P,): how long after a change of state the contact came last, for
    each state, and the crossing of each port. `due`, `order`: the orders that wait, time left and state; a motion whose
    orders might not find room there ends, CROWDED, to be carried on with longer ones. `cross`, `kind`, `just`: of each
    port the time of its next crossing, what that is, and whether it was crossed at this very moment. `memo`: the
    amplitudes remembered, shape (2, N), and `memo_due` the times left. `past`: the last changes, in a ring.
    """

    now: Any
    usual: Floats
    usual_cross: Floats
    due: Floats
    order: Wholes
    cross: Floats
    kind: Wholes
    just: Wholes
    memo: Floats
    memo_due: Floats
    past: npt.NDArray[np.void]


class Plant(NamedTuple):
    """A machine and its motion. `alone`, `spot`, `bench`: the rigid motion by itself, as a system without modes.

    `eye`: the motion as a port sees it, which is as a striking end would; `spot` the same of the rigid motion.
    """

    table: Table
    alone: Table
    gear: Gear
    motion: Motion
    eye: Motion
    spot: Motion
    desk: Desk
    bench: Desk
    controls: Controls


class Drive(NamedTuple):
    """Of a plant, what nearly all of its functions work with: the fewer arrays, the less there is to compile."""

    table: Table
    gear: Gear
    motion: Motion
    desk: Desk
    controls: Controls


class Sight(NamedTuple):
    """Of a plant, what ports see with."""

    alone: Table
    eye: Motion
    spot: Motion
    bench: Desk
