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
from percuss.steady.self_excited.piston_legs import Piston
from percuss.steady.self_excited.rigid_cycle import under_pressure
from percuss.steady.self_excited.self_switching import Obstacle, piston_of, why_unstable

_OBSTACLES = (
    None,
    Obstacle.ON_THE_WALL,
    Obstacle.NO_PORT,
    Obstacle.NO_BLOW,
    Obstacle.DOUBLE_BLOW,
    Obstacle.OVERTAKEN,
    Obstacle.IRREGULAR,
)
"""By the numbers of `cycle_kernels`."""


@dataclass(frozen=True)
class RigidCycles:
    """What many rigid pistons do, per unit of mass; arrays of shape (n,), NaN where a piston has no cycle of one blow.

    Attributes
    ----------
    obstacles
        What keeps each from running with one blow in a cycle; None for one that runs.
    answered
        False where this has no answer, as with very many orders under way or a supply; `self_excited_motion` has.
    period, speed, energy, stroke, work, taken, duty
        As of a `ValveCycle` with one blow: speed and energy just before it.
    multiplier
        Modulus of the greatest multiplier.
    starts
        Whether it keeps going when it starts at rest on the wall; False where nobody asked.
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
    """What `self_excited_motion` tells of each of these machines with a rigid piston, without the flights.

    Parameters
    ----------
    machines
        With the same number of states, and of ports, each.
    rooms
        Of each, how far behind the wall it can go; without limit by default.
    starts
        Whether to look which of them start from rest.
    """
    ensure_cache()
    from percuss.steady.self_excited import cycle_kernels as kn  # only here is the compiler needed

    pistons = [piston_of(machine) for machine in machines]
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
    names = [{name: float(k) for k, (name, _) in enumerate(piston.valve.pairs)} for piston in pistons]
    forces = [[piston.valve.force(name) for name in own] for piston, own in zip(pistons, names, strict=True)]
    ports = [
        [
            (port.behind or 0.0, {"back": 1.0, "front": -1.0, None: 0.0}[port.side], own[port.to], port.delay)
            for port in piston.valve.ports
        ]
        for piston, own in zip(pistons, names, strict=True)
    ]
    pistons = [piston if piston.valve.supply is None else under_pressure(piston, 1.0) for piston in pistons]
    flights = [piston.flight(piston.valve.orders.last, 0.0, 0.0) for piston in pistons]
    laws = [(flight.stiffness, flight.drag, piston.factor) for flight, piston in zip(flights, pistons, strict=True)]
    first = [own[piston.valve.orders.last] for piston, own in zip(pistons, names, strict=True)]
    return np.array(forces), np.ascontiguousarray(np.array(ports).transpose(0, 2, 1)), np.array(laws), np.array(first)


def _judged(
    machines: Sequence[Machine],
    does: npt.NDArray[np.int64],
    told: Array,
    derivatives: Array,
    begun: npt.NDArray[np.bool_],
    limits: Array,
) -> RigidCycles:
    from percuss.steady.self_excited import piston_kernels as kn

    factor = np.array([machine.contact.velocity_factor for machine in machines])
    lossless = np.array(
        [machine.contact.is_lossless and machine.body.damping.is_zero for machine in machines], dtype=bool
    )
    does, told, begun = np.where(lossless, -1, does), np.where(lossless, np.nan, told), begun & ~lossless
    answered = does < len(_OBSTACLES)
    obstacles = [_OBSTACLES[code] if known else None for code, known in zip(does, answered, strict=True)]
    period, speed, stroke, rise = told[kn.DURATION], told[kn.SPEED], told[kn.FARTHEST], told[kn.RISE]
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
        tuple(obstacles), answered, period, speed, energy, stroke, told[kn.WORK], taken, duty, multiplier, begun
    )
