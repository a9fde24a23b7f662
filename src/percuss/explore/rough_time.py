"""How long items take, by rule of thumb: whether a job is small enough for one process, the same on every machine."""

from __future__ import annotations

from collections.abc import Collection

_CELL = {"orbits": 2e-3, "exact": 2e-3, "rest": 1e-4, "blow": 8e-3}
_OF_ARRAYS = {"orbits": 1e-5, "exact": 1e-4}
_FUNCTION = 1e-3


def seconds_of_start(modes: int, clock: bool = True) -> float:
    """Seconds that it takes to follow one start, under a clock or of a machine, until its motion is found."""
    return 3e-4 * (1.0 + modes / 8.0) if clock else 5e-4 * (1.0 + modes / 32.0)


def seconds_of_cell(groups: Collection[str], modes: int, simulated: int, functions: int = 0) -> float:
    """Seconds that one cell of a map takes, computed by itself, for these groups of quantities.

    Parameters
    ----------
    groups
        As `percuss.explore.quantities.needs` gives them.
    modes, simulated
        N of the multipliers and of the simulations.
    functions
        How many there are of one's own.
    """
    found = sum(_CELL.get(group, 0.0) for group in groups) + functions * _FUNCTION
    if "exact" in groups:
        found += 1e-3 * (modes / 32.0) ** 2
    if "simulation" in groups:
        found += seconds_of_start(simulated)
    if "machine" in groups:
        found += 3e-4 + 6e-4 * modes
    if "lyapunov" in groups:
        found += 4e-3 * (1.0 + simulated / 8.0)
    return found


def seconds_of_plane_cell(groups: Collection[str], modes: int) -> float:
    """Seconds that one cell takes in a map whose cells are computed at once, as arrays."""
    return sum(_OF_ARRAYS.get(group, 0.0) for group in groups) * (1.0 + (modes / 32.0) ** 2)
