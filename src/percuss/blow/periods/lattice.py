"""Sections on a lattice: a wave takes one step through a cell, and a load period is a whole number of steps."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from percuss.blow.bodies import Rod, Sections, Target, Wall, rod_sections, striker_sections
from percuss.blow.kernels.lattice_records import (
    BIT_CONTACT,
    CONTACT_JOINT,
    ELASTIC,
    JOINT,
    MASS,
    TOOL,
    Bit,
    Face,
    HeldTool,
    LatticeDrag,
    LatticeMachine,
    LatticeRow,
)
from percuss.errors import ParameterError
from percuss.model import Load, System
from percuss.model.body import Damping, External
from percuss.model.checks import Array
from percuss.short_repr import ShortRepr

_TURN = 2.0 * math.pi
_SPREAD = 2.0  # times the steps asked for are the most that are tried
_ENOUGH = 1e-6  # rounding of the transit times that needs no further search
_AT_ONCE = 4096
_MOST_TRIED = 100_000
MOST_STEPS = 8_000_000
"""Steps of a load period: the work and the memory of a machine whose waves are very fast."""


@dataclass(frozen=True)
class Lattice(ShortRepr):
    """Cells that all sections are cut into.

    The masses keep their ratios to the whole, which is 1, and the impedances theirs to one another: all that rounding
    changes is how long waves take.

    Attributes
    ----------
    steps, step
        Of a load period, and the length of one in radians, 2π/`steps`.
    cells, striker
        Of each section of the striker, then of the rod, and how many of the sections are the striker's.
    impedances
        Of all sections; dimensionless, the striker's mass Σ Z_i n_i Δt is 1.
    rounding
        The greatest change of a section's transit time, over that of the striker.
    """

    steps: int
    step: float
    cells: tuple[int, ...]
    striker: int
    impedances: tuple[float, ...]
    rounding: float


def lattice_of(impedances: Array, transit_times: Array, striker: int, cells: int) -> Lattice:
    """The lattice that rounds transit times least, of those with so many cells in the striker up to twice as many."""
    whole = float(transit_times[:striker].sum())
    least = math.ceil(_TURN / whole * cells)
    if least > MOST_STEPS:
        wanted = f"a wave that takes at least {_TURN * cells / MOST_STEPS:.3g} radians through the bar"
        raise ParameterError("s", 1.0 / whole, wanted, "give fewer cells, or treat the impact as instantaneous")
    best, rounding = _best(transit_times, whole, least, math.ceil(_SPREAD * least) + 64)
    step = _TURN / best
    numbers = np.maximum(np.rint(transit_times / step), 1.0)
    scale = 1.0 / float((impedances * numbers * step)[:striker].sum())
    return Lattice(best, step, tuple(int(n) for n in numbers), striker, tuple((scale * impedances).tolist()), rounding)


def _best(transit_times: Array, whole: float, least: int, most: int) -> tuple[int, float]:
    """The first number of steps that rounds the transit times by nothing to speak of, else the one that does least."""
    best, rounding = 0, math.inf
    stride = -(-(most - least) // _MOST_TRIED)
    for start in range(least, most, _AT_ONCE * stride):
        tried = np.arange(start, min(start + _AT_ONCE * stride, most), stride)
        off = _rounding(transit_times, whole, tried)
        if off.min() < rounding:
            best, rounding = int(tried[off.argmin()]), float(off.min())
        if rounding <= _ENOUGH:
            break
    tried = np.arange(max(best - stride, least), best + stride + 1)
    off = _rounding(transit_times, whole, tried)
    return int(tried[off.argmin()]), float(off.min())


def _rounding(transit_times: Array, whole: float, tried: npt.NDArray[np.int64]) -> Array:
    steps = transit_times[None, :] * (tried[:, None] / _TURN)
    changes = np.abs(np.maximum(np.rint(steps), 1.0) - steps).max(axis=1)
    return np.asarray(changes * _TURN / tried / whole)


# ---- The law of damping on the lattice: what it takes from the velocities of the cells

_MOST_BLOCKS = 100  # whose velocities a matrix is for: its modes are those that last
_INTERVAL = 0.381966011250105  # of a wave's way through the bar; its multiples stay away from whole numbers
_CELLS_AT_ONCE = 0.012  # lost by the velocity of the first mode at each moment, unless …
_MOST_PARTS = 16  # … that would make the interval shorter than this part
_PATIENCE = 6.0  # transit times: contacts of blows are shorter, what lasts longer is a bar that is pressed
_QUIET = 0.12  # lost by every elastic mode in that time, where ringing is to be gone
_NONE = np.zeros((0, 0))


def drag_of(lattice: Lattice, damping: Damping) -> LatticeDrag:
    """What `damping` takes at each of its moments.

    The velocities are slowed as u_n' → u_n' exp(−d_n Δt), the strain stays: the second half of u_n'' + d_n u_n' +
    ω_n² u_n = p when the waves have had the first (splitting). The golden interval meets every mode at all of its
    phases, so that it loses d_n/2 of its amplitude per time. A bar that is pressed and at rest loses nothing. A blow
    takes too short a time for damping to matter, and is left alone: else its impulse would depend on where in it a
    moment of damping falls.
    """
    cells = sum(lattice.cells[: lattice.striker])
    interval = 0.0 if damping.is_zero else _interval(damping, cells * lattice.step) * cells
    time = interval * lattice.step
    if damping.is_zero or isinstance(damping, External):
        return _drag(lattice, interval, factor=math.expm1(-damping.rigid * time))
    block, impedance, steps = _blocks(lattice, max(1, round(cells / _MOST_BLOCKS)))
    mass = impedance * steps * lattice.step
    omega, shapes = _modes(mass, 0.5 * steps * lattice.step / impedance, float(steps.mean()) * lattice.step)
    taken = np.expm1(-time * np.append(damping.rigid, damping.of(omega)))
    root = np.sqrt(mass)
    matrix = np.ascontiguousarray((shapes * taken) @ shapes.T * root / root[:, None])
    return _drag(lattice, interval, finer=float(taken[-1]), matrix=matrix, block=block)


def _interval(damping: Damping, transit: float) -> float:
    """In transit times: so short that the first mode loses little at once."""
    lost = float(damping.of(np.array([math.pi / transit]))[0]) * _INTERVAL * transit
    return _INTERVAL / min(max(1, math.ceil(lost / _CELLS_AT_ONCE)), _MOST_PARTS)


def quiet_drag(lattice: Lattice) -> LatticeDrag:
    """What ends all ringing between blows: the same for all elastic modes, out of contact only."""
    cells = sum(lattice.cells[: lattice.striker])
    return _drag(lattice, _INTERVAL * cells, factor=math.expm1(-_QUIET), carried=True, patience=math.inf)


def _drag(
    lattice: Lattice,
    interval: float,
    *,
    factor: float = 0.0,
    finer: float = 0.0,
    carried: bool = False,
    matrix: Array = _NONE,
    patience: float | None = None,
    block: np.typing.NDArray[np.int64] | None = None,
) -> LatticeDrag:
    mass = np.repeat(lattice.impedances[: lattice.striker], lattice.cells[: lattice.striker]) * lattice.step
    wait = _PATIENCE * mass.size * lattice.step if patience is None else patience
    number = np.zeros(mass.size, dtype=np.int64) if block is None else block
    total = np.asarray(np.bincount(number, mass), dtype=float)
    room = np.zeros(mass.size), np.zeros(total.size), np.zeros(total.size)
    return LatticeDrag(factor, finer, carried, matrix, interval, wait, number, mass, total, *room)


def _blocks(lattice: Lattice, size: int) -> tuple[np.typing.NDArray[np.int64], Array, Array]:
    """The block of each cell, and the impedance and the steps of each block; blocks end where sections do."""
    numbers, impedance, steps, count = [], [], [], 0
    for z, cells in zip(lattice.impedances[: lattice.striker], lattice.cells, strict=False):
        blocks = max(1, round(cells / size))
        own = np.arange(cells) * blocks // cells
        numbers.append(count + own)
        impedance += [z] * blocks
        steps.append(np.bincount(own, minlength=blocks))
        count += blocks
    return np.concatenate(numbers), np.asarray(impedance), np.concatenate(steps).astype(float)


def _modes(mass: Array, half: Array, step: float) -> tuple[Array, Array]:
    """Frequencies and shapes of masses on springs: equal ones leap as waves do, λ = (2/Δt)² sin² ωΔt/2."""
    spring = 1.0 / (half[:-1] + half[1:])
    stiffness = np.diag(np.append(spring, 0.0) + np.append(0.0, spring)) - np.diag(spring, 1) - np.diag(spring, -1)
    root = np.sqrt(mass)
    square, shapes = np.linalg.eigh(stiffness / np.outer(root, root))
    angle = np.arcsin(np.clip(0.5 * step * np.sqrt(np.maximum(square[1:], 0.0)), 0.0, 1.0))
    return 2.0 / step * angle, shapes


# ---- A system and what it strikes as the records of the compiled room

_WAYS = 4.0  # of a wave through a tool without contact, and half a swing of its mass on the rock: then it may be fed


class LatticeUnits(NamedTuple):
    """What 1 is on the lattice: a mass, an angular frequency and a length, in the units of striker and rod."""

    mass: float
    rate: float
    length: float

    @property
    def force(self) -> float:
        """Of a force."""
        return self.mass * self.rate**2 * self.length

    @property
    def energy(self) -> float:
        """Of an energy."""
        return self.force * self.length


def _struck(target: Target, rod: Sections | None, units: LatticeUnits) -> tuple[Array, Array, float]:
    """Impedances and transit times of the sections before the far end, and the impedance there; dimensionless."""
    if rod is None:
        return np.zeros(0), np.zeros(0), math.inf
    impedances, transit = rod.impedance / (units.mass * units.rate), rod.transit * units.rate
    if isinstance(target, Rod) and target.end == "infinite":
        return impedances[:-1], transit[:-1], float(impedances[-1])
    return impedances, transit, math.inf


_NO_BIT = Bit(False, 1.0, 0.0, 0.0, 1.0, 0.0, False, 0.0)


def _bit(
    target: Target, units: LatticeUnits, scale: float, *, impedance: float, transit: float, pushed_back: bool
) -> Bit:
    """The far end of a tool that is fed; `scale` is that of the masses on the lattice, `transit` that of the tool."""
    if not isinstance(target, Rod) or target.end not in ("free", "rock"):
        return _NO_BIT
    rock = target.rock
    if rock is None and not pushed_back:
        raise ParameterError("pushed_back", False, "True for a rod with a free end, which nothing else brings back")
    stiffness = 0.0 if rock is None else rock.stiffness / (units.mass * units.rate**2)
    ratio, gap = (1.0, 0.0) if rock is None else (rock.unloading_ratio, rock.gap / units.length)
    wait = _WAYS * transit
    if stiffness:
        whole = sum(piece.mass for piece in target.pieces) + target.bit_mass
        wait += math.pi * math.sqrt(whole / units.mass / stiffness)
    mass = target.bit_mass / units.mass * scale
    return Bit(True, impedance, mass, stiffness * scale, ratio, gap, not pushed_back, wait)


def machine_record(
    system: System, target: Target, cells: int, *, pushed_back: bool, quiet: bool
) -> tuple[Lattice, LatticeMachine]:
    """The lattice of at least so many cells in the striker, and a machine at rest on it."""
    own, bar = striker_sections(system.body), system.bar
    units = LatticeUnits(1.0, 1.0, 1.0) if bar is None else LatticeUnits(bar.mass, system.angular_frequency, bar.length)
    rod = None if isinstance(target, Wall) else rod_sections(target, bar or system.body)
    lattice = _lattice(own, _struck(target, rod, units), cells)
    drag = quiet_drag(lattice) if quiet else drag_of(lattice, system.body.damping)
    load = load_means(system.load, lattice.steps)
    return lattice, _record(
        own, target, rod, units, lattice, drag, load, system.load.at, pushed_back=pushed_back, train=False
    )[0]


def train_record(
    striker: Sections, target: Rod, rod: Sections, units: LatticeUnits, cells: int, damping: Damping | None = None
) -> tuple[Lattice, LatticeMachine, LatticeUnits]:
    """A striker in SI before a tool that is struck again and again; a turn of the unit `rate` is the time between.

    With a `damping`, that of a machine of its own, whose tool is laid against fresh rock where it has no feed.

    The last units are those of what is on the lattice, on which masses are rounded with the transit times.
    """
    z = units.mass * units.rate
    own = Sections(striker.impedance / z, striker.transit * units.rate, striker.length, striker.speed, None)
    lattice = _lattice(own, _struck(target, rod, units), cells)
    train, load = damping is None, np.zeros(lattice.steps)
    drag = _drag(lattice, 0.0) if damping is None else drag_of(lattice, damping)
    machine, found = _record(own, target, rod, units, lattice, drag, load, 0, pushed_back=False, train=train)
    return lattice, machine, found


def _lattice(own: Sections, struck: tuple[Array, Array, float], cells: int) -> Lattice:
    z, times, _ = struck
    both = np.concatenate([own.impedance, z]), np.concatenate([own.transit, times])
    return lattice_of(*both, own.impedance.size, cells)


def _record(
    own: Sections,
    target: Target,
    rod: Sections | None,
    units: LatticeUnits,
    lattice: Lattice,
    drag: LatticeDrag,
    load: Array,
    load_at: int,
    *,
    pushed_back: bool,
    train: bool,
) -> tuple[LatticeMachine, LatticeUnits]:
    z, _, behind = _struck(target, rod, units)
    k = own.impedance.size
    scaled, numbers = np.asarray(lattice.impedances), lattice.cells[k:]
    scale = scaled[0] / own.impedance[0]
    behind *= scale
    held = isinstance(target, Rod) and (train or target.is_held)
    struck, last = float(scaled[k]) if z.size else behind, float(scaled[-1])
    impedances = scaled[k:]
    if held and isinstance(target, Rod) and target.end == "infinite":  # its last section as one cell
        impedances, numbers, last = np.append(impedances, behind), (*numbers, 1), behind
    transit = sum(lattice.cells[k:]) * lattice.step
    bit = _bit(target, units, scale, impedance=last, transit=transit, pushed_back=pushed_back)
    units = units._replace(mass=units.mass / scale)
    striker = float(scaled[k - 1])
    face = Face(2.0 / (1.0 / striker + 1.0 / struck), 1.0 / striker, 1.0 / struck, behind, pushed_back and not bit.fed)
    tool = _NOT_HELD
    if held and isinstance(target, Rod) and rod is not None:
        tool = _held(target, rod, np.asarray(numbers), units, train=train)
    machine = LatticeMachine(
        _chain(scaled[:k], lattice.cells[:k]), _chain(impedances, numbers), face, bit, load, load_at, lattice.step,
        drag, tool,
    )  # fmt: skip
    return machine, units


# ---- What holds a tool, on the lattice

_PLACES = 9  # in each section, where its force is looked at
_BIT_CONTACTS = 256  # in the log
_KINDS = {"mass": MASS, "elastic": ELASTIC, "contact": CONTACT_JOINT}


def _not_held() -> HeldTool:
    none, whole, wide = np.zeros(0), np.zeros(0, np.int64), np.zeros((0, 0))
    logs = np.zeros(0, JOINT), np.zeros(1, TOOL), np.zeros(0, BIT_CONTACT)
    rest = none, whole, none, none, none, none, np.zeros((0, 0), np.int64), wide, wide, wide, *logs
    return HeldTool(False, False, False, 0.0, -1, 0.0, 0.0, none, *rest)


_NOT_HELD = _not_held()


def _held(target: Rod, rod: Sections, cells: npt.NDArray[np.int64], units: LatticeUnits, *, train: bool) -> HeldTool:
    feed, n, stiff = target.feed, cells.size, units.mass * units.rate**2
    at, force = (-1, 0.0) if feed is None else (feed.at, feed.force / units.force)
    damper = (0.0, 0.0) if feed is None else (feed.stiffness / stiff, feed.damping / (units.mass * units.rate))
    steps, alpha = max(n - 1, 0), np.asarray(target.attenuation[:n])
    kind, mass, spring, dashpot = np.zeros(steps, np.int64), np.zeros(steps), np.zeros(steps), np.zeros(steps)
    slack, joint = np.full(steps, math.inf), np.zeros(steps, JOINT)
    joint["opened"] = joint["closed"] = -1.0
    for step, one in target.joint_at.items():
        i = step - 1
        kind[i], mass[i] = _KINDS[one.kind], one.mass / units.mass
        if (kind[i] == MASS and one.mass == 0.0) or one.slack == 0.0:  # a plain step
            kind[i] = 0
        spring[i], dashpot[i] = one.stiffness / stiff, one.damping / (units.mass * units.rate)
        slack[i] = math.inf if one.slack is None else one.slack / units.length
    if at > 0:
        kind[at - 1] = MASS
    length = np.where(np.isfinite(rod.length), rod.length, 0.0)
    cell = np.minimum((np.linspace(0.0, 1.0, _PLACES) * cells[:, None]).astype(np.int64), cells[:, None] - 1)
    way = (alpha * length / cells)[:, None]
    fades = np.exp(-way * (cell + 0.5)), np.exp(-way * (cells[:, None] - cell - 0.5))
    return HeldTool(
        True, train or feed is not None, not train and feed is not None, force, at, *damper,
        np.where(np.arange(n) >= at, force, 0.0), np.exp(-alpha * length), kind, mass, spring, dashpot, slack,
        cell, *fades, np.zeros((n, 2)), joint, np.zeros(1, TOOL), np.zeros(_BIT_CONTACTS, BIT_CONTACT),
    )  # fmt: skip


def _chain(impedances: Array, cells: tuple[int, ...]) -> LatticeRow:
    numbers = np.asarray(cells, dtype=np.int64)
    first: npt.NDArray[np.int64] = np.cumsum(numbers) - numbers
    total = int(numbers.sum())
    slot = np.zeros(numbers.size, dtype=np.int64)
    return LatticeRow(np.array(impedances), first, numbers, slot, np.zeros(total), np.zeros(total))


def load_means(load: Load, steps: int) -> Array:
    """Mean of the load over each of the equal steps of a period; shape (steps,)."""
    step = _TURN / steps
    if load.is_piecewise:
        return np.asarray(load.mean + np.diff(load.antiderivative(np.arange(steps + 1) * step)) / step)
    k = np.arange(load.coefficients.size)
    waves = load.coefficients.copy()
    waves[1:] *= np.expm1(1j * k[1:] * step) / (1j * k[1:] * step)
    folded = np.zeros(steps, dtype=complex)
    np.add.at(folded, k % steps, waves)
    return np.asarray((np.fft.ifft(folded) * steps).real)
