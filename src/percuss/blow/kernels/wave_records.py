"""The records that the functions of this room share, and the codes in them. Python makes them; see `blow.tables`."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
Wholes = npt.NDArray[np.int64]

MOST_DEGREE = 24  # of a piece: enough for e^{−x} over a length of 10 to the last digit
WIDTH = MOST_DEGREE + 8  # numbers in a row of work
ROWS = 16
JOINED = 1e-15  # neighbouring constants that differ by less, in units of the striker's speed, are one exact piece
APART = 1e-14  # likewise, how far an exact piece may be from those that it was joined of; see `joined`
MOST_JOINED = 14  # the degree of such a piece
NOTHING = 2e-15  # likewise, a part of a fast motion that need not be followed
TRACED = 3  # rows that are no waves, before those of joints and feed
CHOPPED = 2e-17  # coefficients below it, in the same unit, are dropped at the end of a polynomial
TOUCH = 1e-14  # a speed that is no speed
FAR = 1 << 61  # a tick that never comes

# what is at the right end of the last section
WALL, ENDLESS, FREE, FIXED, ROCK = range(5)
# what is at a node besides a step and a mass: nothing; a spring with a dashpot; faces; a feed with a damper
RIGID, ELASTIC, CONTACT, FED = range(4)
# how bit and rock meet: loading deeper than ever, unloading and reloading, apart
LOAD, UNLOAD, OFF = range(3)
# what a call ends with
REACHED, FULL, PAUSED = range(3)


class BlowProblem(NamedTuple):
    """What strikes and what is struck. Impedances, speeds and times in the scales of the blow, times in ticks as well.

    Sections run from the driven end through the struck face to the far end; node i is at the left end of section i.
    `impedance`, `transit`: of each section, shape (S,). `joint_mass`: at each node, shape (S + 1,); last the bit.
    `preload`: the static force in each section; `decay`: what is left of a departure from it that has run through, both
    of shape (S,). `kind`, `spring`, `dashpot` at each node, and `traced`: its first row beyond those of every blow, or
    of faces the number of their record in the state, whose threads catch after `slack`, shape (records,).
    `load_start`, `load_force`: steps of the load, at the node `load_node`. `striker`: number of its sections.
    """

    impedance: Floats
    transit: Wholes
    joint_mass: Floats
    preload: Floats
    decay: Floats
    kind: Wholes
    spring: Floats
    dashpot: Floats
    traced: Wholes
    slack: Floats
    feed_force: float
    feed_stiffness: float
    feed_damping: float
    load_start: Wholes
    load_force: Floats
    load_node: int
    striker: int
    end: int
    stiffness: float
    unloading: float
    ratio: float
    tick: float
    near: int
    until: int


class WaveRows(NamedTuple):
    """Rows of pieces: 2i the wave to the right in section i, 2i + 1 to the left, then what is traced besides.

    These are the force at the struck face, the penetration, the force on the rock; of an elastic joint its force and
    its length, of a feed with a damper its force and the velocity while it acts. Piece k of row c leaves its
    end from the tick start[c, k] on. Its Chebyshev coefficients are first[c, k] and `degree` more in `pool` from `rest`
    on. `known`: until when a row goes; `cursor`: the piece that is being read; `spent`: how far the
    last piece may be from what it was joined of; `waves`: how many rows are waves. `joined`, `apart`: JOINED and APART,
    or more where small steps and bends are let go.
    """

    start: Wholes
    degree: Wholes
    first: Floats
    rest: Wholes
    pool: Floats
    pieces: Wholes
    known: Wholes
    cursor: Wholes
    used: Wholes
    spent: Floats
    waves: int
    joined: float
    apart: float


NOW = np.dtype(
    [
        ("gap", "f8"),
        ("penetration", "f8"),
        ("greatest", "f8"),  # penetration so far
        ("bit_velocity", "f8"),
        ("closed", "i8"),
        ("pressed", "i8"),  # whether the last thing noted was that the faces met
        ("arriving", "i8"),  # the gap has just become 0
        ("grazes", "i8"),
        ("noted", "i8"),  # times of meeting and parting
        ("branch", "i8"),
        ("steps", "i8"),
        ("flank", "i8"),  # of a thread: which of its flanks bears
        ("across", "i8"),  # the other one is met
        ("lifted", "i8"),  # whether the feed does not act
        ("fed_place", "f8"),
    ]
)


class State(NamedTuple):
    """Where each node is, and what it keeps. `now`: a record of the blow, then of each joint with faces.

    `contact`: ticks at which the faces of each record met and parted, in turn. `velocity`: of an elastic joint its
    length.
    """

    now: npt.NDArray[np.void]
    time: Wholes
    velocity: Floats
    contact: Wholes
    work: Floats
