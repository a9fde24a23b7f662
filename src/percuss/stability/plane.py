"""Steady motions and the reduced criterion over whole arrays of restitution and load factor at once."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from percuss.errors import ParameterError, PercussError
from percuss.halting import check_interrupted, on_threads
from percuss.mechanics.kernel_cache import ensure_cache
from percuss.model import System
from percuss.model.checks import DEFAULT_MODES, Array, ComplexArray, at_once, count, instance, numbers
from percuss.model.contact import restitutions
from percuss.model.load import Side
from percuss.short_repr import ShortRepr
from percuss.stability.verdict import coefficients_at, schur_quotients
from percuss.steady import Orbit
from percuss.steady.forced import Response, forced_response
from percuss.steady.multipliers import NEUTRAL, TURNING, blocks
from percuss.steady.phases import Arcs, grows, level_at, level_of, phase_condition
from percuss.steady.states import MAX_PERIODS
from percuss.steady.trigonometric import on_circle

_CHUNK = 1 << 15  # cells handled at once: their arrays stay in the cache


@dataclass(frozen=True)
class Plane(ShortRepr):
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
    fold
        Whether two motions meet in the root.
    """

    phase: Array
    level: Array
    slope: Array
    sigma: Array
    a: Array
    schur: Array
    stable: npt.NDArray[np.bool_]
    fold: npt.NDArray[np.bool_]

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
    out, fold = np.full((8, branches, r.size), np.nan), np.zeros((branches, r.size), dtype=bool)
    target = level_at(mean, system.d, system.contact.impedance_ratios(flat_r), 2.0 * math.pi * m)
    for curve in curves:
        _fill(out, fold, system, m, curve, target, flat_r, mean)
    shape = (branches, *r.shape)
    phase, slope, sigma, *rest = (x.reshape(shape) for x in out)
    a, schur = np.stack(rest[:3]), np.stack(rest[3:])
    with np.errstate(invalid="ignore"):
        stable = (schur[0] < 1.0) & (schur[1] < 1.0)
    return Plane(phase, target.reshape(r.shape), slope, sigma, a, schur, stable, fold.reshape(shape))


class PhaseCurve(NamedTuple):
    """The arcs of the curve that meets c less `raised` times the mean load at the impact phases, for some cells."""

    cells: slice | npt.NDArray[np.intp]
    arcs: Arcs
    raised: float


def phase_curves(system: System, periods: int, restitution: Array) -> Iterator[PhaseCurve]:
    """Curves for cells with other R and mean loads, (n,); v_f where the strain is kept, and under load steps."""
    response = forced_response(system)
    if system.contact.keeps_strain or not response.is_smooth:
        for i in range(0, restitution.size, _CHUNK):
            yield PhaseCurve(slice(i, i + _CHUNK), Arcs.of(response), 0.0)
        return
    pushed = system.with_load(system.load.with_mean(1.0))
    values, which = np.unique(restitution, return_inverse=True)
    for i, value in enumerate(values):
        arcs, raised = _raised(pushed.with_restitution(float(value)), periods)
        yield PhaseCurve(np.flatnonzero(which.reshape(-1) == i), arcs, raised)


@lru_cache(maxsize=256)  # every strip of a map has the same ones
def _raised(pushed: System, periods: int) -> tuple[Arcs, float]:
    """The arcs of a system with mean load 1, and by how much they are raised."""
    condition = phase_condition(pushed, periods)
    return condition.arcs, level_of(pushed, 2.0 * math.pi * periods) - condition.level


def _fill(
    out: Array,
    fold: npt.NDArray[np.bool_],
    system: System,
    periods: int,
    curve: PhaseCurve,
    target: Array,
    restitution: Array,
    force: Array,
) -> None:
    """Fill some cells: rows phase, slope, sigma, a_0, a_1, a_2 and both quotients, and folds, for every branch."""
    period, response, arcs = 2.0 * math.pi * periods, forced_response(system), curve.arcs
    beta, mean = system.contact.velocity_factors(restitution[curve.cells]), force[curve.cells]
    level = target[curve.cells] - curve.raised * mean
    for branch in range(arcs.ends.size - 1):
        low, high = sorted((arcs.velocities[branch], arcs.velocities[branch + 1]))
        index = np.flatnonzero((level > low) & (level <= high) & (mean > 0.0))
        if not index.size:
            continue
        check_interrupted()
        phase = arcs.invert(np.full(index.size, branch), level[index])
        exact = None if response.is_smooth else response.rigid_acceleration(phase)
        slope, sigma, a = coefficients_at(system, period, phase, mean[index], beta[index], exact)
        rows = (on_circle(phase), slope, sigma, *a, *schur_quotients(*a))
        places = index + curve.cells.start if isinstance(curve.cells, slice) else curve.cells[index]
        for row, values in zip(out[:, branch], rows, strict=True):
            row[places] = values
        fold[branch, places] = arcs.folded(rows[0], level[index])


# ---- Exact multipliers over whole arrays of restitution and load factor at once (theory §5)

KINDS = ("", "rigid, real +", "rigid, real −", "rigid, complex", "elastic")
"""What the largest multiplier belongs to: of the rigid motion positive (fold), negative (flip) or one of a pair
(spiral), or an elastic mode; empty where there is none."""

OUTCOMES = ("no motion", "done", "grows", "unsolved")
"""How a root came out.

``no motion``: there is none. ``grows``: with R = 1 and no damping nothing takes the energy that the load puts into the
elastic modes, so that the steady motion of the rigid bar is none of the elastic one. ``unsolved``: the multipliers
failed their check.
"""

MAX_PLANE_MODES = 1024  # the cost of a cell grows like N²
_EXACT_CHUNK = 4096  # orbits handled at once ...
_WORK = 1 << 16  # ... fewer of many modes: between two portions it can be told to stop
_NO_MOTION, _DONE, _GROWS, _UNSOLVED = range(len(OUTCOMES))


@dataclass(frozen=True)
class ExactPlane(ShortRepr):
    """The largest multiplier of every root of a `Plane`; the arrays have the shape of its phases.

    Attributes
    ----------
    multiplier
        The multiplier of largest modulus (of a pair, the one turning backward); where the load jumps at the impact,
        the worse of both sides. NaN where there is no root, or no answer.
    mode
        The mode with the greatest share in its eigenvector: 0 is the rigid motion; −1 where there is no answer.
    outcome
        Numbers of `OUTCOMES`.
    """

    plane: Plane
    modes: int
    multiplier: ComplexArray
    mode: npt.NDArray[np.int16]
    outcome: npt.NDArray[np.int8]

    @property
    def largest(self) -> Array:
        """Largest modulus."""
        return np.asarray(np.abs(self.multiplier))

    @property
    def margin(self) -> Array:
        """1 less the largest modulus: positive when stable. Per impact."""
        return 1.0 - self.largest

    @property
    def stable(self) -> npt.NDArray[np.bool_]:
        """Whether small disturbances die out, by the rule of `stability_of`."""
        return np.asarray((self.margin > NEUTRAL) & ~self.plane.fold)

    @property
    def kind(self) -> npt.NDArray[np.int8]:
        """What the multiplier belongs to: numbers of `KINDS`."""
        first = self.multiplier
        turns = np.abs(first.imag) > TURNING * np.abs(first)
        rigid = np.where(turns, 3, np.where(first.real > 0.0, 1, 2))
        return np.where(self.mode < 0, 0, np.where(self.mode > 0, 4, rigid)).astype(np.int8)


def exact_plane(
    system: System,
    restitution: npt.ArrayLike,
    load_factor: npt.ArrayLike,
    periods: int = 1,
    modes: int = DEFAULT_MODES,
    *,
    plane: Plane | None = None,
    workers: int | None = None,
) -> ExactPlane:
    """Exact multipliers of all steady motions of a system, for arrays of R and p_0/p_k, its alternating load kept.

    Parameters
    ----------
    system, restitution, load_factor, periods
        As `stability_plane` takes them.
    modes
        N, 0 to 1024.
    plane
        What `stability_plane` gave for the same arguments, when it is known already.
    workers
        How many threads; by default as many as cores. The results are the same for any number.

    Raises
    ------
    ResonanceError
        When an undamped bar is driven at one of its own frequencies.

    Examples
    --------
    >>> import numpy as np
    >>> from percuss import Load, System
    >>> from percuss.stability import exact_plane
    >>> pneumatic = System(s=20.0, d=0.0048, restitution=0.0, load=Load.harmonic(1.0, 1.0))
    >>> found = exact_plane(pneumatic, 0.6, np.array([0.45, 0.9, 2.0]))
    >>> found.stable.any(axis=0)
    array([False,  True, False])
    """
    instance("system", system, System)
    n, m = count("modes", modes, least=0, most=MAX_PLANE_MODES), count("periods", periods)
    known = stability_plane(system, restitution, load_factor, m) if plane is None else instance("plane", plane, Plane)
    r, factor = np.broadcast_arrays(np.asarray(restitution, dtype=float), np.asarray(load_factor, dtype=float))
    if known.phase.shape[1:] != r.shape:
        raise ParameterError("plane", f"shape {known.phase.shape[1:]}", f"a plane of the shape {r.shape} asked for")
    job = _Job(system, m, n, known, np.asarray(r), np.asarray(factor))
    job.work_off(at_once(workers))
    return job.result()


class _Job:
    """The roots of one plane in a row, and what comes of each."""

    def __init__(self, system: System, periods: int, modes: int, plane: Plane, r: Array, factor: Array) -> None:
        self.system, self.periods, self.modes, self.plane = system, periods, modes, plane
        self.where = np.flatnonzero(~np.isnan(plane.phase))  # of the flat phases
        cell = self.where % max(r.size, 1)
        unit = abs(complex(system.load.coefficients[system.load.harmonics[0]]))
        self.phase = plane.phase.reshape(-1)[self.where]
        self.r, self.mean = r.reshape(-1)[cell], factor.reshape(-1)[cell] * unit
        load = system.load.with_mean(0.0)
        # of no mean and any R: the same one while these are moved
        self.response: Response = forced_response(system.with_load(load).with_restitution(0.0))
        self.pull = {side: np.asarray(load.value(self.phase, side)) for side in load.sides}
        self.multiplier = np.full(self.where.size, np.nan, dtype=complex)
        self.mode = np.full(self.where.size, -1, dtype=np.int16)
        self.period = 2.0 * np.pi * periods
        self.bar = np.stack(blocks(system.body, system.load.at, self.period, modes))  # numba wants it writable
        self.velocity_factor = system.contact.velocity_factors(self.r)
        self.strain_factor = system.contact.strain_factors(self.r)

    def work_off(self, threads: int) -> None:
        """All roots on the threads, each portion by itself."""
        size = min(_EXACT_CHUNK, max(1, _WORK // (self.modes + 1)))
        portions = [slice(i, i + size) for i in range(0, self.where.size, size)]
        on_threads(self._portion, portions, threads)

    def _portion(self, part: slice) -> None:
        """One portion: the right side of a jump for all, the left side besides for those on one."""
        index = np.arange(self.where.size)[part]
        self.multiplier[index], self.mode[index] = self._largest(index, "right")
        jumped = index[self.pull["left"][index] != self.pull["right"][index]] if "left" in self.pull else index[:0]
        if jumped.size:
            other, mode = self._largest(jumped, "left")
            worse = ~(np.abs(other) <= np.abs(self.multiplier[jumped]))  # also where one side has no answer
            self.multiplier[jumped[worse]], self.mode[jumped[worse]] = other[worse], mode[worse]

    def _largest(self, index: npt.NDArray[np.intp], side: Side) -> tuple[ComplexArray, npt.NDArray[np.int16]]:
        ensure_cache()
        from percuss.steady import secular_kernels as kn  # only here is the compiler needed

        f, rate = (np.ascontiguousarray(x.T) for x in self.response.modal_apart(self.modes, self.phase[index]))
        work, state = np.zeros((kn.WORK_ROWS, 2 * self.modes + 2)), np.zeros((kn.STATE_ROWS, 2 * self.modes + 2), int)
        found, mode = np.empty((2, index.size)), np.empty(index.size, dtype=np.int16)
        kn.largest_multipliers(
            self.velocity_factor[index], self.strain_factor[index], self.mean[index], self.pull[side][index], f, rate,
            self.bar, self.period, work, state, found, mode,
        )  # fmt: skip
        values = found[0] + 1j * found[1]
        for i in np.flatnonzero(mode < 0):
            values[i], mode[i] = self._alone(int(index[i]), side)
        return values, mode

    def _alone(self, i: int, side: Side) -> tuple[complex, int]:
        """A root whose multipliers failed their check, as a single orbit."""
        load = self.system.load.with_mean(float(self.mean[i]))
        try:
            system = self.system.with_restitution(float(self.r[i])).with_load(load)
            found = Orbit(system, self.periods, float(self.phase[i])).multipliers(self.modes, side=side)
        except (PercussError, ArithmeticError, np.linalg.LinAlgError):
            return complex(np.nan, np.nan), -1
        return complex(found.values[0]), found.dominant_mode

    def result(self) -> ExactPlane:
        """The answers put where their roots are."""
        shape, grown = self.plane.phase.shape, np.zeros(self.where.size, dtype=bool)
        for i in range(0, self.where.size if self.system.d == 0.0 else 0, _EXACT_CHUNK):
            part = slice(i, i + _EXACT_CHUNK)
            grown[part] = grows(self.system, self.phase[part], self.periods, modes=self.modes, restitution=self.r[part])
        self.multiplier[grown], self.mode[grown] = complex(np.nan, np.nan), -1
        outcome = np.where(grown, _GROWS, np.where(self.mode < 0, _UNSOLVED, _DONE))

        def spread(values: Any, fill: complex) -> Any:
            whole = np.full(self.plane.phase.size, fill, dtype=values.dtype)
            whole[self.where] = values
            return whole.reshape(shape)

        return ExactPlane(
            self.plane, self.modes, spread(self.multiplier, complex(np.nan, np.nan)), spread(self.mode, -1),
            spread(outcome.astype(np.int8), _NO_MOTION),
        )  # fmt: skip
