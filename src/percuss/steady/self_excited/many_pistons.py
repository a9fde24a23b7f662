"""The cycles of many rigid pistons under their valves at once, compiled: what maps need of each."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from percuss.kernel_cache import ensure_cache
from percuss.model import Machine
from percuss.model.checks import Array
from percuss.steady.self_excited import piston_kernels as pk
from percuss.steady.self_excited.piston import Piston
from percuss.steady.self_excited.self_switching import OBSTACLES, Obstacle, why_unstable


@dataclass(frozen=True)
class RigidCycles:
    """What many rigid pistons do, as of a `ValveCycle`; shape (n,), NaN where a piston has no cycle of one blow.

    `answered` is False where this has no answer, as with very many orders under way or a supply; `starts` tells if it
    keeps going from rest on the wall, False where nobody asked. Only the modulus of the multiplier is told.
    """

    obstacles: tuple[Obstacle | None, ...]
    answered: npt.NDArray[np.bool_]
    period: Array
    speed: Array
    energy: Array
    stroke: Array
    work: Array
    taken: Array
    duty: Array
    multiplier: Array
    starts: npt.NDArray[np.bool_]


def rigid_cycles(
    machines: Sequence[Machine], rooms: Sequence[float | None] | None = None, *, starts: bool = False
) -> RigidCycles:
    """What `self_excited_motion` tells of each of these machines with a rigid piston, without the flights."""
    # All have as many states and ports; `rooms`: how far behind the wall each can go.
    ensure_cache()
    from percuss.steady.self_excited import cycle_kernels as kn  # only here is the compiler needed

    pistons = [Piston(machine) for machine in machines]
    fed = np.array([machine.valve.supply is not None for machine in machines], dtype=bool)
    n = len(pistons)
    does, told = np.full(n, kn.UNKNOWN, dtype=np.int64), np.full((n, kn.TOLD), np.nan)
    derivatives, begun = np.zeros((n, kn.NUMBERS, kn.NUMBERS)), np.zeros(n, dtype=np.bool_)
    if n:
        rows, slopes = np.zeros((kn.ROWS, kn.ROW)), np.zeros((kn.SLOPES, kn.NUMBERS))
        matrices, tells = np.zeros((kn.MATRICES, kn.NUMBERS, kn.NUMBERS + 1)), np.zeros((kn.ROWS, kn.TOLD))
        step = np.zeros(kn.NUMBERS)
        kn.cycles_of(*_packed(pistons), starts, rows, slopes, matrices, tells, step, does, told, derivatives, begun)
    does[fed] = kn.UNKNOWN
    limits = np.array([math.inf] * n if rooms is None else [math.inf if room is None else room for room in rooms])
    return _judged(machines, does, told.T, derivatives, begun, limits)


def _packed(pistons: Sequence[Piston]) -> tuple[npt.NDArray[np.float64], ...]:
    """Forces, ports, laws and first states as the kernels have them."""
    forces, ports, laws = (np.array([piston.numbers[i] for piston in pistons]) for i in range(3))
    first = [piston.names.index(piston.start.state) for piston in pistons]
    return forces, ports, laws, np.array(first, dtype=float)


def _judged(
    machines: Sequence[Machine],
    does: npt.NDArray[np.int64],
    told: Array,
    derivatives: Array,
    begun: npt.NDArray[np.bool_],
    limits: Array,
) -> RigidCycles:
    factor = np.array([machine.contact.velocity_factor for machine in machines])
    lossless = np.array(
        [machine.contact.is_lossless and machine.body.damping.is_zero for machine in machines], dtype=bool
    )
    does, told, begun = np.where(lossless, -1, does), np.where(lossless, np.nan, told), begun & ~lossless
    answered = does < len(OBSTACLES)
    obstacles = [OBSTACLES[code] if known else None for code, known in zip(does, answered, strict=True)]
    period, speed, stroke, rise = told[pk.DURATION], told[pk.SPEED], told[pk.FARTHEST], told[pk.RISE]
    multipliers = np.full((does.size, derivatives.shape[1]), np.nan, dtype=complex)
    there = np.flatnonzero(does == 0)
    multipliers[there] = np.linalg.eigvals(derivatives[there])
    for i in range(len(machines)):
        if lossless[i]:
            obstacles[i] = Obstacle.NO_LOSS
        elif does[i] == 0 and stroke[i] > limits[i]:
            obstacles[i] = Obstacle.NO_ROOM
        elif does[i] == 0 and not np.abs(multipliers[i]).max() < 1.0:
            obstacles[i] = why_unstable(complex(multipliers[i, np.argmax(np.abs(multipliers[i]))]))
    multiplier = np.abs(multipliers).max(axis=1)
    energy = 0.5 * speed**2
    taken = (1.0 - factor**2) * energy
    duty = np.where(rise < 0.0, 0.0, (period - rise) / period)
    return RigidCycles(
        tuple(obstacles), answered, period, speed, energy, stroke, told[pk.WORK], taken, duty, multiplier, begun
    )
