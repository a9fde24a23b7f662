"""Where the motions of an experiment start: named distributions, and rows drawn from one's own."""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from percuss.errors import ParameterError
from percuss.explore.attractors.motion_columns import some
from percuss.model.checks import Array, count

if TYPE_CHECKING:
    from percuss.explore.attractors.motion_columns import Own
    from percuss.model import System
    from percuss.simulate import Starts

__all__ = [
    "BLOCK",
    "DISTRIBUTIONS",
    "FIELD_DEPTH",
    "FIELD_SPEED",
    "GENTLE_SPEED",
    "blocks",
    "checked_name",
    "drawn",
    "named",
]

DISTRIBUTIONS = ("wall", "field", "gentle")
"""The named distributions of starts; all rigid, the elastic modes at rest, the load phase uniform."""

FIELD_DEPTH, FIELD_SPEED, GENTLE_SPEED = 20.0, 5.0, 0.2

BLOCK = 65_536
"""Rows that are drawn together, from a stream of their own: a portion of an experiment draws only its blocks."""

_TURN = 2.0 * np.pi


def named(system: System, distribution: str, number: int, seed: int = 0, first: int = 0) -> Starts:
    """Starts drawn from a named distribution; which they are does not depend on how many are drawn.

    ``wall``
        On the wall, leaving with the speed \\|N(0, 1)\\|·2πp_0/(1 + R), load phase uniform. 2πp_0/(1 + R) is the
        striking speed of the undamped motion with one impact in every load period.
    ``field``
        Position uniform in [−20, 0], velocity 5·N(0, 1), load phase uniform.
    ``gentle``
        On the wall, leaving with a speed uniform in (0, 0.2), load phase uniform.

    All are rigid, with the elastic modes at rest; dimensionless. A bar that leaves has a velocity below 0. Every
    column of every `BLOCK` rows has a stream of its own, spawned from the seed by numpy's `SeedSequence`.

    Parameters
    ----------
    system
        Whose load and restitution set the speed of ``wall``.
    distribution
        One of `DISTRIBUTIONS`.
    number
        How many.
    seed
        0 or greater.
    first
        Row of the endless table of this seed with which to begin.

    Raises
    ------
    ParameterError
        For an unknown name, or ``wall`` with a load that does not push.

    Examples
    --------
    >>> from percuss import Load, System
    >>> system = System(s=20.0, d=0.0, restitution=0.6, load=Load.harmonic(0.9, 1.0))
    >>> starts = named(system, "gentle", 1000, seed=1)
    >>> len(starts), bool((starts.velocity < 0.0).all()), bool((starts.gap == 0.0).all())
    (1000, True, True)
    """
    from percuss.simulate import Starts

    checked_name(distribution)
    position, velocity, time = blocks(distribution, number, seed, first)
    speed = _TURN * system.load.mean / system.contact.impulse
    if distribution == "wall" and speed <= 0.0:
        raise ParameterError(
            "distribution", "wall", "a load that pushes (mean greater than 0)", "use 'field' or 'gentle', or a file"
        )
    return Starts.rigid(position, speed * velocity if distribution == "wall" else velocity, time)


def checked_name(distribution: str) -> None:
    """Refuse a distribution that has no name here."""
    if distribution not in DISTRIBUTIONS:
        raise ParameterError("distribution", distribution, f"one of {', '.join(DISTRIBUTIONS)}, or a file")


def blocks(distribution: str, number: int, seed: int, first: int = 0) -> Array:
    """Position, velocity and load phase of rows of a distribution, shape (3, rows), with the scales of `named`."""
    last = first + count("starts", number)
    seed = count("seed", seed, least=0)
    return np.concatenate([_block(distribution, block, seed)[:, part] for block, part in _parts(first, last)], axis=1)


def _parts(first: int, last: int) -> Iterator[tuple[int, slice]]:
    """The blocks of the rows `first` … `last` − 1, and what of each is asked for."""
    for block in range(first // BLOCK, (last - 1) // BLOCK + 1):
        yield block, slice(max(first - block * BLOCK, 0), min(last - block * BLOCK, BLOCK))


@lru_cache(maxsize=4)  # a worker takes one portion of a block after the other
def _block(distribution: str, block: int, seed: int) -> Array:
    """Position, velocity and time of one block, shape (3, rows); velocities of ``wall`` over its speed."""
    first, second, third = (
        np.random.default_rng(stream) for stream in np.random.SeedSequence(seed, spawn_key=(block,)).spawn(3)
    )
    found = np.zeros((3, BLOCK))
    found[2] = _TURN * first.random(BLOCK)
    if distribution == "field":
        found[0] = -FIELD_DEPTH * second.random(BLOCK)
        found[1] = FIELD_SPEED * third.standard_normal(BLOCK)
    elif distribution == "gentle":
        found[1] = -GENTLE_SPEED * (1.0 - third.random(BLOCK))  # (0, 0.2]: never without speed
    else:
        found[1] = -np.abs(third.standard_normal(BLOCK))
    found.setflags(write=False)
    return found


def drawn(rows: Own, number: int, seed: int = 0, first: int = 0) -> Own:
    """`number` starts of given rows, by chance with replacement; which they are does not depend on how many."""
    last = first + count("starts", number)
    seed = count("seed", seed, least=0)
    which = np.concatenate([_chosen(len(rows), block, seed)[part] for block, part in _parts(first, last)])
    return some(rows, which)


@lru_cache(maxsize=4)
def _chosen(rows: int, block: int, seed: int) -> npt.NDArray[np.int64]:
    stream = np.random.SeedSequence(seed, spawn_key=(block, 3))  # beside the three of `_block`
    return np.random.default_rng(stream).integers(0, rows, BLOCK)
