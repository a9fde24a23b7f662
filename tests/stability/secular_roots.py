"""Roots of secular functions by the compiled method, without the dense eigenvalues that stand in where it fails."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from percuss.compiled import pipelines
from percuss.stability import LinearMap
from percuss.steady import secular_kernels as kn

Complex = NDArray[np.complex128]


@njit(error_model="numpy", _nrt=False, **pipelines()[1])  # type: ignore[untyped-decorator]
def _found(count: int, flat: bool, work: Any, state: Any) -> bool:
    live = kn.joined(count, work) if flat else kn.joined_in_plane(count, work)
    strong = kn.beside_poles(live, work, state) if flat else kn.beside_complex_poles(live, work, state)
    return bool(kn.all_together(live, strong, work, state))


def roots_of_poles(poles: NDArray[Any], residues: NDArray[Any]) -> Complex:
    """The zeros of 1 + Σ r_j/(μ − ξ_j); at least one pole."""
    flat, order = not np.iscomplexobj(poles), np.argsort(poles.real)
    work, state = np.zeros((kn.WORK_ROWS, poles.size)), np.zeros((kn.STATE_ROWS, poles.size), int)
    work[kn.POLE], work[kn.POLE_IM] = poles[order].real, poles[order].imag
    work[kn.RESIDUE], work[kn.RESIDUE_IM] = residues[order].real, residues[order].imag
    assert _found(poles.size, flat, work, state)
    return np.asarray(work[kn.RE] + 1j * work[kn.IM])


def secular_roots(matrix: LinearMap) -> Complex:
    """All multipliers of a map, which must pass the check by two traces."""
    n = matrix.g.size
    work, state = np.zeros((kn.WORK_ROWS, 2 * n)), np.zeros((kn.STATE_ROWS, 2 * n), int)
    work[kn.JUMP, :n], work[kn.JUMP_RATE, :n] = matrix.g, matrix.g_velocity
    factors = matrix.velocity_factor, matrix.strain_factor
    assert kn.all_multipliers(*factors, matrix.speed, np.stack(matrix.blocks), work, state) == 2 * n
    return np.asarray(work[kn.RE] + 1j * work[kn.IM])


def farthest(ours: NDArray[Any], theirs: NDArray[Any]) -> float:
    """The largest distance of two multisets of complex numbers under their best matching."""
    assert len(ours) == len(theirs)
    distance = np.abs(np.asarray(ours)[:, None] - np.asarray(theirs)[None, :])
    rows, columns = linear_sum_assignment(distance**2)
    return float(distance[rows, columns].max())
