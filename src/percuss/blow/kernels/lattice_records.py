"""The records of a machine on the lattice: chains of cells, the face, the load, and what is told of each contact."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
Wholes = npt.NDArray[np.int64]


class LatticeRow(NamedTuple):
    """Sections on a lattice of equal cells: a wave takes one step through a cell.

    `right` and `left` hold the waves f and g of every cell, section after section, as rings: what leaves a section at
    slot `slot` was put in there `cells` steps before. In space, the cell next to the right end is the slot of `right`,
    the cell next to the left end that of `left`.
    """

    impedance: Floats
    first: Wholes
    cells: Wholes
    slot: Wholes
    right: Floats
    left: Floats


class Face(NamedTuple):
    """Where striker and rod meet, and what lies behind the rod's last section.

    `stiffness` is the contact force over f − g, `rod` is 1/Z of what is struck (0: a wall). `behind` is the impedance
    after the rod's last section, inf for a fixed end; `pushed_back` says that the rod returns as soon as there is room.
    """

    stiffness: float
    striker: float
    rod: float
    behind: float
    pushed_back: bool


class LatticeDrag(NamedTuple):
    """What takes velocity now and then: a matrix for blocks of cells, or, where that is empty, a factor for all cells.

    `factor` and `finer` are factors less 1; `finer` is for what the cells of a block have beyond their mean. `carried`:
    whether the bar as a whole is left alone by `factor`. `interval`: steps between; 0 for never.
    `patience`: the time that a contact lasts before the damping
    acts in it. `block`: of each cell; `mass` of each cell, `total` of each block. `before`, `mean`
    and `change` are room to work in.
    """

    factor: float
    finer: float
    carried: bool
    matrix: Floats
    interval: float
    patience: float
    block: Wholes
    mass: Floats
    total: Floats
    before: Floats
    mean: Floats
    change: Floats


class Bit(NamedTuple):
    """The far end of a tool that is fed between blows: a bit on rock, or a free end, before which `stiffness` is 0.

    `fed` is false of a rod that needs none of this. `impedance` is that of the last section, `ratio` the share of the
    penetration that springs back, `gap` the distance from bit to rock before a blow. `kept`: whether the tool is fed by
    what the bit has gone deeper; else it comes back to its place. `wait`: the time without contact before it is fed.
    """

    fed: bool
    impedance: float
    mass: float
    stiffness: float
    ratio: float
    gap: float
    kept: bool
    wait: float


class HeldTool(NamedTuple):
    """What holds a tool: its feed, what joins its sections, what its steel takes; and what became of all that.

    The rings hold departures from the static state, before the steel has taken its part. `active` is false of a tool
    that needs none of this. `kept`: whether it stays as blows leave it; else it is laid against fresh rock after each.
    `renews`: whether the rock is replaced when the striker turns forward again.

    `force`, `at`, `stiffness` and `damping` are those of the feed Q = max(0, F − k_d y − c_d y′). Of each section:
    `preload`, the static force N_0, and `decay`, e^{−αL}. Of each step: `kind` of the joint with `mass`, `spring`,
    `dashpot` and `slack`, inf for no limit. `cell`, `fade_right` and `fade_left` say where in each section its force is
    looked at, (sections, places); `extreme` keeps the least and the greatest, (sections, 2).
    """

    active: bool
    kept: bool
    renews: bool
    force: float
    at: int
    stiffness: float
    damping: float
    preload: Floats
    decay: Floats
    kind: Wholes
    mass: Floats
    spring: Floats
    dashpot: Floats
    slack: Floats
    cell: Wholes
    fade_right: Floats
    fade_left: Floats
    extreme: Floats
    joint: npt.NDArray[np.void]
    tool: npt.NDArray[np.void]
    bit_log: npt.NDArray[np.void]


STEP, MASS, ELASTIC, CONTACT_JOINT = range(4)  # what joins two sections; a step that is fed is a mass, which may be 0
SHUT, OPEN, CAUGHT = range(3)  # how the faces of a contact joint stand

JOINT = np.dtype(
    [
        ("place", "f8"),  # of a mass; departure of a spring's compression; gap of a contact joint
        ("velocity", "f8"),  # of a mass
        ("loss", "f8"),  # in its dashpot
        ("opened", "f8"),  # when it first opened, and shut again; -1 for never
        ("closed", "f8"),
        ("widest", "f8"),
        ("state", "i8"),
        ("openings", "i8"),
    ]
)

TOOL = np.dtype(
    [
        ("place", "f8"),  # y of the fed node since the static state
        ("force_work", "f8"),  # F ∫ v dt, −k_d ∫ y v dt and c_d ∫ v² dt while it acts
        ("spring_work", "f8"),
        ("damper_loss", "f8"),
        ("feed_impulse", "f8"),  # ∫ Q dt
        ("steel_loss", "f8"),  # of waves that have arrived
        ("out", "f8"),  # through the end of an endless rod
        ("rock_impulse", "f8"),
        ("rock_force", "f8"),  # now
        ("rock_peak", "f8"),
        ("bit_contacts", "i8"),  # in the log
        ("renewals", "i8"),
        ("standing", "i8"),  # of those, with the bit on the rock
    ]
)

BIT_CONTACT = np.dtype([("start", "f8"), ("end", "f8"), ("impulse", "f8"), ("peak", "f8")])


LOAD, UNLOAD, OFF = range(3)  # how bit and rock meet: deeper than ever, back and again forward, apart

REBOUNDED = 2

NOW = np.dtype(
    [
        ("gap", "f8"),  # between the faces; exactly 0 in contact
        ("moved", "f8"),  # by which blows have moved the rod's face since it was pushed back
        ("momentum", "f8"),  # of the striker
        ("energy", "f8"),  # of the striker's cells
        ("arrived", "f8"),  # the wave that reached the striker's face a step before
        ("met", "f8"),  # the wave that reached the rod's face a step before
        ("load_work", "f8"),
        ("rod_work", "f8"),
        ("damped", "f8"),
        ("averaged", "f8"),  # energy that the means over cells in which a contact starts or ends do not show
        ("impulse", "f8"),
        ("time", "f8"),  # of the beginning of the load's present period
        ("next_drag", "f8"),  # the step of this period at which velocity is taken next
        ("penetration", "f8"),  # of the bit into the rock; below 0 before it
        ("greatest", "f8"),  # penetration in this blow
        ("bit_velocity", "f8"),
        ("rock_work", "f8"),  # that the rock keeps, of the blows before this one
        ("advanced", "f8"),  # by which the tool has been fed
    ]
)

COUNT = np.dtype(
    [
        ("step", "i8"),  # in the load's present period
        ("touching", "i8"),
        ("contacts", "i8"),  # in the log
        ("branch", "i8"),  # of the rock's force
        ("blow", "i8"),  # how many times the tool has been fed
        ("struck", "i8"),  # since it was: 0 for no contact, 1 for one, REBOUNDED where the striker has gone back since
    ]
)

CONTACT = np.dtype(
    [
        ("start", "f8"),
        ("end", "f8"),
        ("impulse", "f8"),
        ("moment", "f8"),  # ∫ N (t − start) dt
        ("peak", "f8"),
        ("momentum_before", "f8"),
        ("momentum_after", "f8"),
        ("energy_before", "f8"),
        ("energy_after", "f8"),
        ("averaged_before", "f8"),
        ("averaged_after", "f8"),
        ("given", "f8"),  # ∫ N v dt at the rod's face
        ("rock_before", "f8"),
        ("advanced_before", "f8"),
        ("left", "f8"),  # of a tool that is held: energy departing from its static state as a blow begins
        ("stood", "f8"),  # and 1 if the bit was on the rock then
        ("blow", "i8"),
    ]
)


class LatticeMachine(NamedTuple):
    """All that a stretch of motion needs: chains, face and far end, the load of every step of a period, the damping."""

    striker: LatticeRow
    rod: LatticeRow
    face: Face
    bit: Bit
    load: Floats
    load_at: int
    step: float
    drag: LatticeDrag
    held: HeldTool


class LatticeValve(NamedTuple):
    """What drives a striker that switches its own valve, in the units of the lattice.

    `law` and `joins`, of each state, are tables of `percuss.mechanics.oil`, and `flows` tells whether the oil loses
    anything. Of each port: the state it demands, `to`, whether it reads a `speed`, where its region begins, `level`, on
    which side of it, `sign` (0: it is the blow that demands), and the `delay`.
    """

    law: Floats
    joins: Floats
    flows: bool
    to: Wholes
    speed: npt.NDArray[np.bool_]
    level: Floats
    sign: Floats
    delay: Floats


MOST_ORDERS = 64

VALVE = np.dtype(
    [
        ("state", "i8"),
        ("last", "i8"),  # demanded
        ("orders", "i8"),  # that wait
        ("due", "f8", (MOST_ORDERS,)),
        ("to", "i8", (MOST_ORDERS,)),
        ("place", "f8"),  # of the centre of the striker, 0 where its end touches the tool at rest
        ("pressure", "f8"),
        ("taken", "f8"),  # from the supply, ∫ π p_k u′ dt
        ("touched", "i8"),  # whether the blow that began last has not demanded yet
        ("blend", "f8", (4,)),  # of the joins of the states, while the spool moves; by which it changes; until when
        ("slope", "f8", (4,)),
        ("stroke", "f8"),
        ("mean", "f8", (4,)),  # of the blend over a step
        ("rise", "f8"),  # of the pressure in a time
    ]
)
