"""The records of a system, of a motion, and of a call, and the codes in them.

A record of single numbers is one element of a structured array (`NOW`, `COUNT`, …), which Python and compiled code
change in place; a record of arrays is a `NamedTuple`. Python makes them, see `percuss.simulate.engine`; compiled
functions only fill them.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
Wholes = npt.NDArray[np.int64]

# -- a system -------------------------------------------------------------------------------------------------------

BAR = np.dtype(
    [
        ("damping", "f8"),  # of the rigid motion
        ("spring", "f8"),  # its own frequency on a gas chamber, 0 without one
        ("whole", "f8"),  # its modal mass where its place is that of the striking end: 1 without a chamber
        ("restitution", "f8"),
        ("load", "f8"),  # the constant part of the load: its mean, or the step that holds …
        ("mean", "f8"),  # … what of it pushes the bar as a whole …
        ("wall", "f8"),  # … and of the force that the wall feels from the body at rest: `bears` load + `preload`
        ("bears", "f8"),
        ("preload", "f8"),
        ("held", "f8"),  # 1 for a structure, which does not move as a whole and rests in the shape that it has
        ("ramp", "f8"),  # rate at which the force on the modes grows, as a pump fills an accumulator; else 0
        ("lift", "f8"),  # … at which the rigid motion is pushed more and more, which a chamber or accumulator holds
        ("climb", "f8"),  # … and the velocity of what is seen that comes of it, without the rigid motion
        ("strain", "f8"),  # what an impact multiplies the elastic displacements by: 1, or −R
        ("law", "i8"),  # how the phasors of the modes are computed
        ("base", "f8"),  # frequency of which those of all modes are multiples, where they are
        ("base_half", "f8"),  # … and half the damping that goes with it, with the law RATIO
        ("half", "f8"),  # half the damping of all modes, with the law POWERS
        ("delta", "f8"),  # greatest ω_n − λ_n, with the law POWERS
        ("quickest", "f8"),  # greatest frequency
        ("wane", "f8"),  # greatest damping of an oscillating mode
        ("lasting", "f8"),  # 2/d of the least damped one, inf without damping
        ("linger", "f8"),  # the slowest rate at which free elastic motion dies out
        # bounds of the oscillation of the smooth part of the gap, and of its derivatives
        ("reach", "f8"),
        ("rate", "f8"),
        ("curve", "f8"),
        ("jerk", "f8"),
        ("force", "f8"),  # Σ|p_k|, the speed scale
        ("bend", "f8"),  # bound of |p''|
        ("wave", "f8"),  # time of a wave through the bar; of a structure half a swing of its first mode
        ("contact", "f8"),  # … and to and fro, which a contact takes
        ("ripple", "f8"),  # half a period of the shortest one
        ("pushing", "f8"),  # bound of the time for which the load never pulls, or inf
        # what rounding is measured by, the sums Σk|amplitude| of the rigid oscillation and of all modes, which may be
        # much more than their sum's
        ("sway", "f8"),
        ("swing", "f8"),
    ]
)


class ModeTable(NamedTuple):
    """The elastic modes, each array of shape (N,).

    `lam`, `inverse`, `square`, `delta` and `oscillates` (0 or 1) are 0 for the `creeping` modes, so that loops run over
    all modes: numba makes vector code of those that start at 0 only.
    """

    omega: Floats
    lam: Floats  # λ_n
    inverse: Floats  # 1/λ_n
    square: Floats  # λ_n²
    signed: Floats  # λ_n² as it is, negative where overdamped
    damping: Floats  # d_n
    half: Floats  # d_n/2, 0 for the creeping modes
    delta: Floats  # what damping takes from the frequency, ω_n − λ_n
    oscillates: Floats
    statics: Floats  # q_n under a constant unit load
    unit: Floats  # q_n of u_n = 1
    inertia: Floats  # kinetic energy is Σ inertia q_n'²
    creeping: Wholes  # numbers of the modes that are overdamped or close to it


class Harmonics(NamedTuple):
    """Amplitudes of the harmonics k = 1 … K of the gap, of the rigid motion and of the load, each of shape (K,)."""

    gap_re: Floats
    gap_im: Floats
    rigid_re: Floats
    rigid_im: Floats
    load_re: Floats
    load_im: Floats


class MotionTable(NamedTuple):
    """A system. `coupling`: displacement of q_n under harmonic k, real and imaginary part, shape (K, 2, N).

    `breaks`, `values`: the steps of a piecewise constant load, otherwise empty. `releases`: phases at which the load
    begins to pull.
    """

    bar: Any  # a BAR
    modes: ModeTable
    harmonics: Harmonics
    coupling: Floats
    breaks: Floats
    values: Floats
    releases: Floats


# -- a motion -------------------------------------------------------------------------------------------------------

NOW = np.dtype(
    [
        # the anchor, besides the amplitudes z
        ("gap", "f8"),
        ("gap_rate", "f8"),
        ("rigid_rate", "f8"),
        ("phase", "f8"),
        ("cosine", "f8"),  # of the phase
        ("sine", "f8"),
        ("hold", "f8"),  # time for which the flight is known to be free
        # … what is known of the flight from it
        ("free", "f8"),  # the free elastic part f
        ("free_oscillating", "f8"),
        ("free_curve", "f8"),  # f''
        ("sup", "f8"),  # bounds of |f|, |f'|, |f''|, |f'''|
        ("sup1", "f8"),
        ("sup2", "f8"),
        ("sup3", "f8"),
        ("drift", "f8"),
        ("smooth_rate", "f8"),
        ("acceleration", "f8"),
        # … and of the impacts up to it
        ("kinetic_energy", "f8"),
        ("last_flight", "f8"),
        ("since", "f8"),
        ("last_place", "f8"),  # u_0 when the first step of the load last began, 0 when unknown
        ("pushes", "f8"),  # time for which the load still pushes after an impact with count.run > 1
        ("released", "f8"),  # phase of the last release, −1 when it is none of `releases`
        ("marked", "f8"),  # … of the release that later ones are compared with
        ("laid", "f8"),  # sum of the phases at which the bar was laid down since then
        # the impact that later ones are compared with, besides its amplitudes
        ("anchor_phase", "f8"),
        ("anchor_speed", "f8"),
        ("anchor_rigid_rate", "f8"),
        # when the last impact and the last main blow came, whether that one ended in chatter, whether there was one
        ("struck_period", "f8"),
        ("struck_phase", "f8"),
        ("blow_period", "f8"),
        ("blow_phase", "f8"),
        ("chattered", "f8"),
        ("begun", "f8"),
    ]
)

COUNT = np.dtype(
    [
        ("period", "i8"),
        ("piece", "i8"),
        ("mode", "i8"),
        ("impacts", "i8"),
        # impacts of the present sequence of ever shorter flights, under a load that pushes or each shorter than a wave
        # through the bar takes: the load works on the other end, and a strained bar may bounce long after the load has
        # begun to pull there
        ("run", "i8"),
        ("pile", "i8"),  # those of them that come without any time between
        ("events", "i8"),
        ("work", "i8"),
        # the search for a cycle, see `recurrence`
        ("anchor", "i8"),
        ("anchor_period", "i8"),
        ("patience", "i8"),
        ("rests", "i8"),
        ("chatters", "i8"),
        ("cycle_impacts", "i8"),
        ("cycle_periods", "i8"),
        ("cycle_kind", "i8"),
        ("confirmed", "i8"),
        ("found_at", "i8"),
        # … and among the releases, see `released_again`
        ("release_period", "i8"),  # of the last one
        ("mark", "i8"),  # first impact after the release that is compared with, and its load period
        ("mark_period", "i8"),
        ("mark_patience", "i8"),
        ("mark_releases", "i8"),
        ("mark_chatters", "i8"),  # chatters since then
        ("verdict", "i8"),
    ]
)

PAST = np.dtype([("phase", "f8"), ("speed", "f8"), ("period", "f8")])  # one of the last impacts
SUMS = np.dtype(
    [
        # number of intervals, their sum and sum of squares: between all impacts, between main blows (a completed
        # chatter is one blow, at its first impact) …
        ("all", "f8"),
        ("all_time", "f8"),
        ("all_squares", "f8"),
        ("main", "f8"),
        ("main_time", "f8"),
        ("main_squares", "f8"),
        # … and of the sequence of ever shorter flights now open, with the striking speeds and kinetic energies of its
        # impacts but the first
        ("open", "f8"),
        ("open_time", "f8"),
        ("open_squares", "f8"),
        ("open_speeds", "f8"),
        ("open_blows", "f8"),
        ("taken", "f8"),  # the energy lost
        # of the main blows the sums of striking speeds and of kinetic energies, and their number
        ("speeds", "f8"),
        ("blows", "f8"),
        ("struck", "f8"),
    ]
)


class KernelState(NamedTuple):
    """One motion: all that its next event depends on.

    `now`, `count`: a NOW and a COUNT; `numbers`, `wholes` are their memory as plain arrays, to be set to 0 in one go.
    `z`: amplitudes, shape (2, N). `anchor`: those of the impact that later ones are compared with. `past`: the last
    impacts, in a ring. `sums`: the SUMS since the release that later ones are compared with, and those before it;
    `totals` is their memory, of shape (2, 15).
    """

    z: Floats
    now: Any
    count: Any
    anchor: Floats
    past: npt.NDArray[np.void]
    sums: npt.NDArray[np.void]
    numbers: Floats
    wholes: Wholes
    totals: Floats


class Workspace(NamedTuple):
    """Room to work in. `osc`: the load's harmonics at the anchor, shape (2, K); the others are rows for all modes.

    `re`, `im`: phasors less 1; `forced`: forced motion; `aside_re`, `aside_im`: to put by.
    """

    osc: Floats
    re: Floats
    im: Floats
    forced: Floats
    aside_re: Floats
    aside_im: Floats


# ---- The records of a call: when a motion ends, where motions start, what is recorded, and what is kept of each


class Rules(NamedTuple):
    """When a motion ends. `skip`: impacts that the sums leave out; `budget`: evaluations at which the call returns."""

    end_period: float
    end_phase: float
    most_impacts: int
    until_cycle: bool
    tolerance: float
    skip: int
    budget: int


EVENT = np.dtype(
    [
        ("phase", "f8"),  # of a machine the time since the start
        ("before", "f8"),  # rate of the striking end, or of what a port reads
        ("after", "f8"),
        ("lost", "f8"),
        ("kinetic", "f8"),
        ("kind", "i8"),
        ("period", "i8"),
        ("resolved", "i8"),
        ("piece", "i8"),  # of a machine the state of the valve, after it
        ("port", "i8"),  # −1 but for a demand
    ]
)


class Log(NamedTuple):
    """The record of a stretch of motion: EVENTs, and the state after each: gap, u_0', and the two rows of z.

    No rows for none.
    """

    events: npt.NDArray[np.void]
    states: Floats


STATE_NUMBERS = 2  # columns of a state before its amplitudes


class StartRows(NamedTuple):
    """u_n and u_n', n = 0, 1, …, of the starts of many motions, rows; their gaps, and their clocks."""

    displacement: Floats
    velocity: Floats
    gap: Floats
    phase: Floats
    period: Wholes
    piece: Wholes


MEMBER = np.dtype(
    [
        ("ended", "i8"),
        ("strikes", "i8"),
        ("first", "i8"),
        ("cycle_impacts", "i8"),
        ("cycle_periods", "i8"),
        ("cycle_kind", "i8"),
        ("wanders", "i8"),
        ("end_time", "f8"),
        ("blow_rate", "f8"),
        ("main_blow_rate", "f8"),
        ("interval_mean", "f8"),
        ("interval_std", "f8"),
        ("main_interval_mean", "f8"),
        ("main_interval_std", "f8"),
        ("impact_velocity", "f8"),
        ("blow_energy", "f8"),
        ("energy_lost_per_period", "f8"),
        # of machines, in their kernels' unit of time
        ("stalled", "i8"),
        ("period", "f8"),
        ("blow_speed", "f8"),
    ]
)
"""What is kept of a member of an ensemble."""


# ---- Numbers that the functions of this room share, and the codes in their records

TURN = 2.0 * math.pi
TURN_LOW = 2.4492935982947064e-16  # 2π less its double
EPS = 2.0**-52
SLICE = 1 << 17  # evaluations of a member of an ensemble between two looks at the outside
STRIDE = 1 << 24  # … times modes, of a motion by itself or a machine
WINDOW = 256  # last impacts kept for the classifier, at least; always a power of 2
LOOSE = 1e-3  # how near impacts must come back to be of one cycle, when nothing more is asked

# -- codes ----------------------------------------------------------------------------------------------------------

# what the anchor is, `count.mode`
FLYING, ON_WALL, RESTING, GRAZED = range(4)
# kinds of events: numbers of NumPy, as a Python number is a type of its own for which `record` is compiled again
IMPACT, GRAZING, CHATTER, REST, RELEASE, PORT, VALVE = np.arange(7)
NO_PORT = np.int64(-1)
# what a call ends with, or that the motion goes on
FULL, BY_IMPACTS, BY_TIME, AT_REST, PERIODIC, DEPARTED, BY_WORK, TO_VERIFY, UNRESOLVED, GOES_ON = range(10)
# … and that of a machine: it orbits in its chamber for ever, or switches without end at a port; or more orders wait
# than there is room for;
IN_CHAMBER, ON_PORT, CROWDED = 10, 11, 12
# … or the state of its valve changes, and its modes with it; or the pressure of its supply has fallen to 0
HANDED, EMPTY = 13, 14
# what a search for the next contact ends with, or that it is still open
NOTHING, CONTACT, GRAZE, AWAY, TIRED, OPEN = range(6)
# … and what a port's next crossing is: it is entered, left, neither before a horizon, or neither ever
ENTERS, LEAVES, NOWHERE, NEVER = 6, 7, 8, 9
# `count.verdict` on two equal releases: none yet, none in a twin yet, to be tested, the cycle is sure, lost in rounding
UNSEEN, TWIN, ASKED, SURE, LOST_CYCLE = range(5)
# `bar.law`: the frequencies are multiples of one, and one damping holds for all; frequencies and dampings are multiples
# of one; each mode by itself
POWERS, RATIO, SINGLY = range(3)


# ---- The records of a machine that switches its own valve, beside those of a system
#
# The state at an instant is that of a bar under a constant load, with the modes of the machine: decoupled motions m_i,
# of which the first takes the part of the rigid motion, on the spring of the gas chamber if there is one. q_i is what
# m_i moves the striking end by. Besides, there are the state of the valve and the orders that wait for their time.


class Gear(NamedTuple):
    """The valve: `forces` (S,) of its states; the others (P,) for each port.

    `to`: the state demanded. `edge`: distance of the port behind the wall. `side`: 1 where the region is in front of
    it, −1 behind it, 0 for the blow. `speeds`: 1 where it reads a velocity, whose edge has the other sign. `ratio`
    (P, N+1): what q_i moves the place that the port reads by; `rigid`: 1 where it reads the rigid motion alone. `gain`:
    acceleration of q_0 under a unit force. On a chamber, `still`: what the port reads under a constant unit force;
    `sway`: how far at most it is from there, of the root of twice the energy about that place.

    With a supply c π' = `flow` − p u': the accumulator is a spring of p²/c, so that each state of the valve has modes,
    and a Gear, of its own. The force is that of `forces` and `slope` times the charge c π + p u, which grows with the
    flow; `draw` is p, `slope` p/c. What p acts on is a last row of `ratio`, which sees when the pressure falls to 0.
    `bend` (P,): what is read of the elastic modes under a constant unit force. `soft`: 1/c; `quickening`: as of a
    `Supply`.
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
    bend: Floats
    speeds: Wholes
    flow: float
    draw: float
    slope: float
    soft: float
    quickening: float


START = np.dtype(
    [
        ("gap", "f8"),
        ("gap_rate", "f8"),
        ("rigid_rate", "f8"),
        ("charge", "f8"),
        ("mode", "i8"),
        ("state", "i8"),
        ("last", "i8"),
        ("waiting", "i8"),
        ("asked", "i8"),  # whether the ports whose region is occupied demand at once, in their order
    ]
)
"""Where a machine starts: as in NOW, COUNT and VALVE_NOW."""


class MachineStarts(NamedTuple):
    """Starts of many motions: STARTs, the amplitudes (starts, 2, N), and the orders that wait, rows."""

    rows: npt.NDArray[np.void]
    z: Floats
    due: Floats
    order: Wholes


VALVE_NOW = np.dtype(
    [
        ("time", "f8"),  # since the start …
        ("time_low", "f8"),  # … and what its rounding has lost
        ("clear", "f8"),  # time from the anchor on for which no contact is possible
        ("awaited", "f8"),  # time to the contact that was found already, after what came first; 0 for none
        ("lap", "f8"),  # time after a release for which the ripple of the modes may lap at the wall
        ("window", "f8"),  # time at which the last `MANY` changes of state began
        ("changed", "f8"),  # time of the last change of state
        ("force", "f8"),  # of the state, on the modes: without what is in their spring
        ("charge", "f8"),  # c π + p u of a supply, else 0
        ("state", "i8"),
        ("before", "i8"),  # … and the state before the last change
        ("handed", "i8"),  # whether the change to the state is not yet done
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
        ("memo_charge", "f8"),
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

    `table`, `alone` and `gear` have one more axis in front, with a row for each state of the valve or, where these have
    the same modes, one for all; `creeping` ends with −1. `turns`: what makes q_i of a state's modes (second axis) of
    those of another (first). `eye`: the motion as a port sees it, which is as a striking end would; `spot` the same of
    the rigid motion. `words`: the memory of `controls.now`.
    """

    table: MotionTable
    alone: MotionTable
    gear: Gear
    turns: Floats
    motion: KernelState
    eye: KernelState
    spot: KernelState
    desk: Workspace
    bench: Workspace
    controls: Controls
    words: Wholes


class ValveArguments(NamedTuple):
    """Of a plant, the valve that its motion has besides that of a bar; None in its place under a clock."""

    gear: Gear
    controls: Controls


class PortView(NamedTuple):
    """Of a plant, what ports see with."""

    alone: MotionTable
    eye: KernelState
    spot: KernelState
    bench: Workspace
