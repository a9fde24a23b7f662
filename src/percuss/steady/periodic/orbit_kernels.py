"""The compiled functions for orbits, loaded where they are first used, as loading the compiler takes long."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any, NamedTuple

from percuss.kernel_cache import ensure_cache

__all__ = ["OrbitKernels", "orbit_kernels"]


class OrbitKernels(NamedTuple):
    """What Python calls; `percuss.steady.periodic.kernels` says what each does."""

    search: Callable[..., None]
    corrected: Callable[..., tuple[int, int]]
    derivatives: Callable[..., None]
    singularity: Callable[..., float]
    flown: Callable[..., None]


@cache
def orbit_kernels() -> OrbitKernels:
    """Load them, from numba's cache if they are there; else each is compiled when it is first called."""
    ensure_cache()
    from percuss.steady.periodic.kernels import flying, following, looking, searching

    found: Any = (searching.search, following.corrected, following.derivatives, looking.singularity, flying.flown)
    return OrbitKernels(*found)
