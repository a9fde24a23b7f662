"""Steady motions and the reduced criterion over whole arrays of restitution and load factor at once."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from percuss.errors import ParameterError
from percuss.halting import look
from percuss.model import System
from percuss.model.checks import Array, count, instance, numbers
from percuss.model.contact import Result, restitutions
from percuss.shown import Shown
from percuss.stability.reduced import quadratic_coefficients, schur_quotients
from percuss.steady.level import level_at, level_of
from percuss.steady.phase_condition import phase_condition
from percuss.steady.phases import Arcs, forced_response
from percuss.steady.states import MAX_PERIODS
from percuss.steady.trigonometric import harmonic_sums, on_circle

__all__ = ["Plane", "stability_plane"]

_CHUNK = 1 << 15  # cells handled at once: their arrays stay in the cache


@dataclass(frozen=True)
class Plane(Shown):
    """Roots and reduced stability over an array of systems.

    The first axis numbers the branches: the monotone arcs of v_f, in order of phase, each holding at most one root.
    Where a branch holds none, its phase and numbers are NaN and `stable` is False. The other axes are those of the
    restitution and the load factor broadcast together.

    Parameters
    ----------
    phase
        Impact phases in [0, 2π).
    level
        c of B77 (14), without the branch axis.
    slope
        v_f'(φ)/p_0.
    sigma
        σ.
    a
        a_0, a_1, a_2, as the first axis of shape 3.
    schur
        Both quotients of B77 (32), as the first axis of shape 2.
    stable
        Whether both quotients are less than 1.
    """

    phase: Array
    level: Array
    slope: Array
    sigma: Array
    a: Array
    schur: Array
    stable: npt.NDArray[np.bool_]

    @property
    def roots(self) -> npt.NDArray[np.int64]:
        """Number of steady motions in every cell."""
        return np.asarray(np.count_nonzero(~np.isnan(self.phase), axis=0))


def stability_plane(system: System, restitution: npt.ArrayLike, load_factor: npt.ArrayLike, periods: int = 1) -> Plane:
    """Phases and B77's reduced criterion of a system for arrays of R and p_0/p_k, its alternating load kept.

    v_f does not depend on R or on the mean load, so that its arcs are cut once and every cell only asks where the arcs
    meet its level; for a contact law that changes the strain they are cut once for every R, and σ = 0. Cells in which
    the load does not push (load factor ≤ 0) hold no motion.

    Parameters
    ----------
    system
        Gives the body, the contact law and the alternating part of the load.
    restitution, load_factor
        Arrays that broadcast together; R in [0, 1].
    periods
        m.

    Raises
    ------
    ParameterError
        When R leaves [0, 1], a value is not finite, or the load is constant.

    Examples
    --------
    >>> import numpy as np
    >>> from percuss import Load, System
    >>> from percuss.stability import stability_plane
    >>> pneumatic = System(s=1e6, d=0.0, restitution=0.0, load=Load.harmonic(1.0, 1.0))
    >>> plane = stability_plane(pneumatic, np.array([[0.2], [0.6]]), np.array([0.45, 0.9]))
    >>> plane.roots
    array([[2, 0],
           [2, 2]])
    >>> plane.stable.any(axis=0)
    array([[ True, False],
           [False,  True]])
    """
    instance("system", system, System)
    m = count("periods", periods, most=MAX_PERIODS)
    rows, columns = restitutions(restitution), numbers("load_factor", load_factor)
    try:
        r, factor = np.broadcast_arrays(rows, columns)
    except ValueError:
        raise ParameterError("load_factor", load_factor, "numbers in a shape that fits the restitution's") from None
    if system.load.is_constant:
        raise ParameterError("load", str(system.load), "a load with an alternating part")
    unit = abs(complex(system.load.coefficients[system.load.harmonics[0]]))
    flat_r, mean = r.reshape(-1), factor.reshape(-1) * unit
    curves = list(phase_curves(system, m, flat_r))
    branches = max((curve.arcs.ends.size - 1 for curve in curves), default=0)
    out = np.full((8, branches, r.size), np.nan)
    target = level_at(mean, system.d, system.contact.impedance_ratios(flat_r), 2.0 * math.pi * m)
    for curve in curves:
        _fill(out, system, m, curve, target, flat_r, mean)
    shape = (branches, *r.shape)
    phase, slope, sigma, *rest = (x.reshape(shape) for x in out)
    a, schur = np.stack(rest[:3]), np.stack(rest[3:])
    with np.errstate(invalid="ignore"):
        stable = (schur[0] < 1.0) & (schur[1] < 1.0)
    return Plane(phase, target.reshape(r.shape), slope, sigma, a, schur, stable)


class PhaseCurve(NamedTuple):
    """The arcs of the curve that meets c less `raised` times the mean load at the impact phases, for some cells."""

    cells: slice | npt.NDArray[np.intp]
    arcs: Arcs
    raised: float


def phase_curves(system: System, periods: int, restitution: Array) -> Iterator[PhaseCurve]:
    """The curves for cells of a system with other R and mean loads, shape (n,); v_f for all where the strain is kept.

    Where the contact law changes the strain, each R has a curve (`percuss.steady.phase_condition`). Under steps of the
    load v_f stands for it, which is right to second order in 1/s.
    """
    response = forced_response(system)
    if system.contact.keeps_strain or not response.is_smooth:
        for i in range(0, restitution.size, _CHUNK):
            yield PhaseCurve(slice(i, i + _CHUNK), Arcs.of(response), 0.0)
        return
    pushed = system.with_load(system.load.with_mean(1.0))
    period = 2.0 * math.pi * periods
    values, which = np.unique(restitution, return_inverse=True)
    for i, value in enumerate(values):
        one = pushed.with_restitution(float(value))
        condition = phase_condition(one, periods)
        raised = level_of(one, period) - condition.level
        yield PhaseCurve(np.flatnonzero(which.reshape(-1) == i), condition.arcs, raised)


def _fill(
    out: Array, system: System, periods: int, curve: PhaseCurve, target: Array, restitution: Array, force: Array
) -> None:
    """Fill some cells: rows phase, slope, sigma, a_0, a_1, a_2 and both quotients, for every branch."""
    period, response, arcs = 2.0 * math.pi * periods, forced_response(system), curve.arcs
    elastic, feeds = response.by_harmonics, system.contact.holds(Result.FEEDBACK)
    beta, mean = system.contact.velocity_factors(restitution[curve.cells]), force[curve.cells]
    level = target[curve.cells] - curve.raised * mean
    end = elastic.end_shape() if feeds else np.zeros(elastic.k.size, dtype=complex)
    for branch in range(arcs.ends.size - 1):
        low, high = sorted((arcs.velocities[branch], arcs.velocities[branch + 1]))
        index = np.flatnonzero((level > low) & (level <= high) & (mean > 0.0))
        if not index.size:
            continue
        look()
        phase = arcs.invert(np.full(index.size, branch), level[index])
        k = elastic.k
        ringing, slope = harmonic_sums(phase, k, 1j * k * elastic.p * end, 1j * k * elastic.rigid_factor)
        if not response.is_smooth:
            slope = response.rigid_acceleration(phase)  # exact where the series would ring
        sigma, slope = ringing / (mean[index] * period), slope / mean[index]
        a_0, a_1, a_2 = quadratic_coefficients(system.d, beta[index], period, sigma, slope)
        first, second = schur_quotients(a_0, a_1, a_2)
        rows = (on_circle(phase), slope, sigma, a_0, a_1, a_2, first, second)
        places = index + curve.cells.start if isinstance(curve.cells, slice) else curve.cells[index]
        for row, values in zip(out[:, branch], rows, strict=True):
            row[places] = values
