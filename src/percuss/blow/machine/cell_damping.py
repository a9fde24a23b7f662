"""The law of damping on the lattice: what it takes from the velocities of the cells."""

from __future__ import annotations

import math

import numpy as np

from percuss.blow.kernels.machine_records import Drag
from percuss.blow.machine.lattice import Lattice
from percuss.model.body import Damping, External
from percuss.model.checks import Array

__all__ = ["drag_of", "quiet_drag"]

_MOST_BLOCKS = 100  # whose velocities a matrix is for: its modes are those that last
_INTERVAL = 0.381966011250105  # of a wave's way through the bar; its multiples stay away from whole numbers
_AT_ONCE = 0.012  # lost by the velocity of the first mode at each moment, unless …
_MOST_PARTS = 16  # … that would make the interval shorter than this part
_PATIENCE = 6.0  # transit times: contacts of blows are shorter, what lasts longer is a bar that is pressed
_QUIET = 0.12  # lost by every elastic mode in that time, where ringing is to be gone
_NONE = np.zeros((0, 0))


def drag_of(lattice: Lattice, damping: Damping) -> Drag:
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
    return _INTERVAL / min(max(1, math.ceil(lost / _AT_ONCE)), _MOST_PARTS)


def quiet_drag(lattice: Lattice) -> Drag:
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
) -> Drag:
    mass = np.repeat(lattice.impedances[: lattice.striker], lattice.cells[: lattice.striker]) * lattice.step
    wait = _PATIENCE * mass.size * lattice.step if patience is None else patience
    number = np.zeros(mass.size, dtype=np.int64) if block is None else block
    total = np.asarray(np.bincount(number, mass), dtype=float)
    room = np.zeros(mass.size), np.zeros(total.size), np.zeros(total.size)
    return Drag(factor, finer, carried, matrix, interval, wait, number, mass, total, *room)


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
    """Frequencies of the elastic modes, and all shapes, of masses that springs of their own half widths join.

    Leapfrog with one step for each mass moves a chain of equal ones as waves move: λ = (2/Δt)² sin² ωΔt/2.
    """
    spring = 1.0 / (half[:-1] + half[1:])
    stiffness = np.diag(np.append(spring, 0.0) + np.append(0.0, spring)) - np.diag(spring, 1) - np.diag(spring, -1)
    root = np.sqrt(mass)
    square, shapes = np.linalg.eigh(stiffness / np.outer(root, root))
    angle = np.arcsin(np.clip(0.5 * step * np.sqrt(np.maximum(square[1:], 0.0)), 0.0, 1.0))
    return 2.0 / step * angle, shapes
