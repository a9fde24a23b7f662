"""The records of a system and of a motion; those of a call are in `calls`, the codes in them in `codes`.

A record of single numbers is one element of a structured array (`NOW`, `COUNT`, …), which Python and compiled code
change in place; a record of arrays is a `NamedTuple`. Python makes them, see `percuss.simulate.tables` and
`percuss.simulate.snapshot`; compiled functions only fill them.
"""

from __future__ import annotations

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
        ("mean", "f8"),  # the constant part of the load: its mean, or the step that holds
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
        ("wave", "f8"),  # time of a wave through the bar
        ("contact", "f8"),  # … and to and fro, which a contact takes
        ("ripple", "f8"),  # half a period of the shortest one
        ("pushing", "f8"),  # bound of the time for which the load never pulls, or inf
        # what rounding is measured by, the sums Σk|amplitude| of the rigid oscillation and of all modes, which may be
        # much more than their sum's
        ("sway", "f8"),
        ("swing", "f8"),
    ]
)


class Modes(NamedTuple):
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


class Table(NamedTuple):
    """A system. `coupling`: displacement of q_n under harmonic k, real and imaginary part, shape (K, 2, N).

    `breaks`, `values`: the steps of a piecewise constant load, otherwise empty. `releases`: phases at which the load
    begins to pull.
    """

    bar: Any  # a BAR
    modes: Modes
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

PAST = np.dtype([("phase", "f8"), ("speed", "f8"), ("period", "f8")])
"""One of the last impacts."""

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


class Motion(NamedTuple):
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


class Desk(NamedTuple):
    """Room to work in. `osc`: the load's harmonics at the anchor, shape (2, K); the others are rows for all modes.

    `re`, `im`: phasors less 1; `forced`: forced motion; `aside_re`, `aside_im`: to put by.
    """

    osc: Floats
    re: Floats
    im: Floats
    forced: Floats
    aside_re: Floats
    aside_im: Floats
