"""Exact Floquet multipliers of an orbit with N elastic modes (not in B77; theory §5), and which motion each belongs to.

They are exact for the modes and the contact law of the system. What they say of the elastic modes is said by the law:
where an impact keeps the strain (B77) some of these may grow, where it turns the strain over, as waves in a uniform bar
do, their multipliers have a modulus of about R e^{−d_n T/2}.

A multiplier belongs to a mode by its participation factor l_n·r_n, the product of the mode's parts of its left and
right eigenvectors with l·r = 1 (Pérez-Arriaga, Verghese & Schweppe, IEEE Trans. PAS-101 (1982) 3117–3125). No scale of
the states enters. Over the modes the factors of one multiplier sum to 1, over the multipliers those of one mode to 2.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from enum import Enum
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING, Any, NamedTuple, Self

import numpy as np

from percuss.errors import ConvergenceError, ParameterError, extra_package
from percuss.halting import check_interrupted
from percuss.lazy_names import lent
from percuss.mechanics.flow import phi1
from percuss.mechanics.kernel_cache import ensure_cache
from percuss.model import Body, Machine, System
from percuss.model.checks import Array, ComplexArray, choice
from percuss.model.load import Side
from percuss.short_repr import ShortRepr
from percuss.steady.figures import figures_of
from percuss.steady.oscillator import flights

# ---- Why a steady motion can be sustained or not: one list of words for verdicts, maps, tables and the page


class Reason(Enum):
    """What decides whether a hammer can sustain a steady motion; its value is the word that files and tables have.

    The first six are verdicts on the stability of a motion, the next two say why a motion is not physical, the last
    one why there is none.

    Attributes
    ----------
    words
        The same in a few words; of the motions that are not physical, what the striking end does.

    Examples
    --------
    >>> Reason("flip") is Reason.FLIP, Reason.FLIP.words
    (True, 'the rigid motion grows and turns over with every impact (period doubling)')
    """

    words: str

    def __new__(cls, word: str, words: str) -> Self:
        made = object.__new__(cls)
        made._value_, made.words = word, words
        return made

    STABLE = "stable", "small disturbances die out"
    FOLD = "fold", "two motions meet here, or the motion lies beyond the place where they met"
    FLIP = "flip", "the rigid motion grows and turns over with every impact (period doubling)"
    SPIRAL = "spiral", "the rigid motion grows while its phase turns"
    ELASTIC = "elastic", "an elastic mode grows, where B77's reduced criterion says stable"
    NEUTRAL = "neutral", "the largest multiplier has the modulus 1, as far as rounding tells"
    NO_BLOW = "no blow", "does not strike forward"
    THROUGH_WALL = "through the wall", "passes through the wall"
    NO_MOTION = "no motion", "the level is above what the load can reach"


VERDICTS = tuple(Reason)[:6]
"""The reasons that are verdicts, in the order of the numbers by which maps and archives keep them."""


# ---- The linearised map from impact to impact, in the form that its structure gives it (theory §5)
#
# With ξ the perturbation of the modal state at fixed times, flight is ξ → Φ(T) ξ, block by block, and the impact is the
# saltation matrix S = D − g hᵀ/(h·ẋ⁻), which carries the change of the flight time. D = diag(α, β) in every mode, β =
# −R, the rigid one too: its position is set so that the striking end stays at 0, which for a state with y = 0 is α
# times itself. h is γ_n on the displacements, ẋ⁻ the velocity before the impact and g = Dẋ⁻ − ẋ⁺, in mode n ((α − β)
# w_n, (α − β) ω_n² u_n − (1 − β) p(φ)) with u_n, w_n just before the impact: the damping drops out. So M = S Φ is
# block-diagonal plus rank one. Where the strain turns over with the velocity, α = β, only the load is left in g.

_CHUNK = 256  # multipliers whose participation is worked out together

MAX_MODES = 16384  # a map may ask for more than the 4096 that an orbit's fields are bounded to


class MapBlocks(NamedTuple):
    """The flight over a time T of modes n = 0 … N, of a body that is held 1 … N; rows of `secular_kernels`.

    Φ_n = [[a, b], [c, e]]; E_n = exp(−d_n T) = det Φ_n, its root and 1 less that; d_n, ω_n (0 for the rigid mode), γ_n
    (1, then −2, 2, −2, … for a uniform bar that is driven at its end), and exp(−d_n T/2)(1 − cos λ_n T).
    """

    a: Array
    b: Array
    c: Array
    e: Array
    decay: Array
    half: Array
    loss: Array
    damping: Array
    omega: Array
    gamma: Array
    versine: Array


@lru_cache(maxsize=8)
def blocks(body: Body, at: int, period: float, modes: int) -> MapBlocks:
    """The flight of modes 0 … `modes`; the last few are kept. A body that is held has no rigid motion."""
    (known, step), drag = flights(body, at, period, modes), body.damping.rigid
    damping = np.append(drag, known.damping)
    rows = (
        np.append(1.0, step.a),
        np.append(period * float(phi1(drag * period)), step.b),
        np.append(0.0, step.c),
        np.append(np.exp(-drag * period), step.e),
        np.exp(-damping * period),
        np.exp(-0.5 * damping * period),
        -np.expm1(-0.5 * damping * period),
        damping,
        np.append(0.0, known.omega),
        np.append(1.0, known.gamma),
        np.append(0.0, step.versine),
    )
    return MapBlocks(*(row if body.is_free else row[1:] for row in rows))


@dataclass(frozen=True)
class LinearMap:
    """M = DΦ − g (hᵀΦ)/W in modes n = 0 … N, of a body that is held 1 … N.

    Parameters
    ----------
    blocks
        Φ_n and γ_n, and numbers of them that would cancel.
    g, g_velocity
        The two parts of g_n; arrays of as many.
    speed
        W, the speed of the striking end before the impact with these modes.
    velocity_factor, strain_factor
        β and α of the contact law.
    """

    blocks: MapBlocks
    g: Array
    g_velocity: Array
    speed: float
    velocity_factor: float
    strain_factor: float

    def dense(self) -> Array:
        """M as a full matrix of shape (2N + 2, 2N + 2); states ordered u_0, u_0', u_1, u_1', …"""
        (a, b, c, e, *_), size, gamma = self.blocks, self.g.size, self.blocks.gamma
        matrix = np.zeros((2 * size, 2 * size))
        even, odd = np.arange(0, 2 * size, 2), np.arange(1, 2 * size, 2)
        matrix[even, even], matrix[even, odd] = self.strain_factor * a, self.strain_factor * b
        matrix[odd, even], matrix[odd, odd] = self.velocity_factor * c, self.velocity_factor * e
        jump = np.stack([self.g, self.g_velocity], axis=1).reshape(-1) / self.speed
        flight = np.stack([gamma * a, gamma * b], axis=1).reshape(-1)
        return np.asarray(matrix - np.outer(jump, flight))

    def secular(self, mu: complex) -> complex:
        """det(M − μ)/det(DΦ − μ) = 1 − hᵀΦ(DΦ − μ)⁻¹g/W, whose zeros are the multipliers."""
        u, v, determinant = self._adjugate(mu, self.g, self.g_velocity)
        each = self._felt(u, v) / np.where(determinant == 0.0, 1e-300, determinant)
        return complex(1.0 - each.sum() / self.speed)

    # -- eigenvectors --

    def participation(self, multipliers: ComplexArray) -> ComplexArray:
        """How much the rigid motion takes part in each multiplier: l_0·r_0 with l·r = 1; shape as `multipliers`.

        With B = DΦ the eigenvectors are r = (B − μ)⁻¹g and l = (B − μ)⁻ᵀf, so that l_n·r_n is the n-th part of
        fᵀ(B − μ)⁻²g, the derivative of the secular function.
        """
        found = np.empty(multipliers.size, dtype=complex)
        for i in range(0, multipliers.size, _CHUNK):
            each = self._parts(multipliers[i : i + _CHUNK, None])
            with np.errstate(divide="ignore", invalid="ignore"):
                found[i : i + _CHUNK] = each[:, 0] / each.sum(axis=1)
        return np.where(np.isfinite(found), found, 0.0)

    def _parts(self, mu: ComplexArray) -> ComplexArray:
        """f_nᵀ(B_n − μ)⁻²g_n, relative to the greatest of each row; shape (multipliers, N + 1)."""
        u, v, determinant = self._adjugate(mu, self.g, self.g_velocity)
        u, v, _ = self._adjugate(mu, u, v)
        # (B − μ)⁻¹ = adj/det, twice; at a pole of one block all else is nothing beside it
        size = np.abs(determinant)
        least = size.min(axis=1, keepdims=True)
        ratio = np.where(size > 0.0, least, 1.0) / np.where(size > 0.0, determinant, 1.0)
        return np.asarray(self._felt(u, v) * ratio**2)

    def _felt(self, u: Any, v: Any) -> Any:
        """f_n of the vectors (u_n, v_n): how far each mode moves the striking end in a flight."""
        return self.blocks.gamma * (self.blocks.a * u + self.blocks.b * v)

    def _adjugate(self, mu: ComplexArray | complex, u: Any, v: Any) -> tuple[Any, Any, Any]:
        """adj(B_n − μ) of the vectors (u_n, v_n), and det(B_n − μ)."""
        (a, b, c, e, *_), beta, alpha = self.blocks, self.velocity_factor, self.strain_factor
        first, last = alpha * a - mu, beta * e - mu
        return last * u - alpha * b * v, first * v - beta * c * u, first * last - alpha * beta * b * c

    def shares(self, multiplier: complex) -> Array:
        """Share of each mode in the eigenvector of a multiplier; shape (N + 1,). See `energy_shares`."""
        u, v, determinant = self._adjugate(multiplier, self.g, self.g_velocity)
        scale = np.abs(determinant) ** 2 + (1e-300 + np.finfo(float).tiny)
        return energy_shares(self.blocks.omega, self.blocks.gamma, u, v, scale)


def map_at_impact(system: System, period: float, force: float, displacement: Array, velocity: Array) -> LinearMap:
    """The map of a motion of that period from just before the impact: p(φ), u_n (N,) and u_n' from mode 0 on."""
    contact, first = system.contact, 0 if system.body.is_free else 1
    alpha, beta = contact.strain_factor, contact.velocity_factor
    flight, velocity = blocks(system.body, system.load.at, period, displacement.size), velocity[first:]
    pull = contact.impulse * force - (alpha - beta) * flight.omega**2 * np.append(0.0, displacement)[first:]
    return LinearMap(flight, (alpha - beta) * velocity, -pull, float(flight.gamma @ velocity), beta, alpha)


@dataclass(frozen=True)
class CycleMap:
    """The map of a cycle of several events as a full matrix, states ordered u_0, u_0', u_1, u_1', …

    ω_n of the coordinates (0 for the rigid motion) and γ_n, (n,) each. What follows them, as the pressure of a supply
    and the times of pending orders, belongs to the motion as a whole.
    """

    matrix: Array
    omega: Array
    gamma: Array

    def dense(self) -> Array:
        """The matrix."""
        return self.matrix

    def participation(self, multipliers: ComplexArray) -> ComplexArray:
        """As of `LinearMap`; those of eigenvectors that are not of their own are 0."""
        values, right = np.linalg.eig(self.matrix)
        left = np.linalg.pinv(right)
        whole = [0, 1, *range(2 * self.omega.size, len(values))]
        each = (left[:, whole].T * right[whole]).sum(axis=0)
        return np.asarray(each[np.abs(multipliers[:, None] - values).argmin(axis=1)], dtype=complex)

    def shares(self, multiplier: complex) -> Array:
        """As of `LinearMap`."""
        values, right = np.linalg.eig(self.matrix)
        u, v = right[: 2 * self.omega.size, np.abs(values - multiplier).argmin()].reshape(-1, 2).T
        return energy_shares(self.omega, self.gamma, u, v)


def energy_shares(omega: Array, gamma: Array, u: ComplexArray, v: ComplexArray, scale: Any = 1.0) -> Array:
    """Share of each mode in an eigenvector by its energy |γ_n|/2 u_n², sum 1; the same when the bar is turned round."""
    counted = np.where(omega == 0.0, 1.0, 0.5 * np.abs(gamma))
    weight = counted * (np.abs(v) ** 2 + np.maximum(omega, 1.0) ** 2 * np.abs(u) ** 2) / scale
    return np.asarray(weight / weight.sum()) if weight.sum() > 0.0 else np.eye(1, weight.size)[0]


# ---- Exact Floquet multipliers of an orbit with N elastic modes (not in B77; theory §5), and which motion each belongs
# to

NEUTRAL = 1e-10  # moduli this close to 1 are neither stable nor unstable: rounding would decide
TURNING = 1e-6  # part of its modulus from which on the imaginary part of a multiplier makes it one of a pair that turns
_DENSE = 40  # up to this many modes a dense eigensolve is as fast
_DENSE_CHECK = 300  # up to this many it may stand in for roots that failed their check
_TINY = 1e-6  # multipliers this small beside the largest, or beside 1, are taken for 0
_NEAR = 64  # multipliers of very many modes among which each of the rigid motion is looked for


@dataclass(frozen=True)
class Multipliers(ShortRepr):
    """The Floquet multipliers of an orbit over its cycle, whatever its label; made by its `multipliers`.

    Parameters
    ----------
    modes
        N: modes 0 … N were kept.
    values
        All 2N + 2 multipliers, of a body that is held 2N, largest modulus first; complex, dimensionless. Of a cycle
        with rest, which forgets everything, two of 0. Of a machine that switches its own valve those of its map from
        cycle to cycle, without the neutral one, a shift in time.
    """

    label: str
    modes: int
    values: ComplexArray
    system: System | Machine = field(repr=False, compare=False)
    _map: LinearMap | CycleMap | None = field(repr=False, compare=False, default=None)
    _fewer: Callable[[int], Multipliers] | None = field(repr=False, compare=False, default=None)

    @property
    def moduli(self) -> Array:
        """Moduli, largest first."""
        return np.asarray(np.abs(self.values))

    @property
    def largest(self) -> float:
        """Largest modulus: less than 1 when the orbit is stable."""
        return float(np.abs(self.values).max())  # of equal ones the first in `values` may be an ulp off

    @property
    def stable(self) -> bool:
        """Whether small disturbances die out: the largest modulus is less than 1 by more than rounding."""
        return self.largest < 1.0 - NEUTRAL

    @property
    def verdict(self) -> Reason:
        """What the multipliers say, one of `percuss.steady.Reason`."""
        return reason_of(complex(self.values[0]), 1.0 - self.largest)

    def _shares(self, multiplier: complex) -> Array:
        return np.ones(1) if self._map is None else self._map.shares(multiplier)

    @property
    def _first(self) -> int:
        return 0 if self.system.body.is_free else 1

    @cached_property
    def dominant_mode(self) -> int:
        """The mode with the greatest share of energy in the eigenvector of the first; 0 is the rigid motion."""
        return self._first + int(np.argmax(self._shares(complex(self.values[0]))))

    @cached_property
    def rigid(self) -> tuple[int, ...]:
        """Places in `values` of the two that belong to the rigid motion: those in which it takes part most.

        Of a body that is held those of its first mode; of a machine with those of the pressure and the pending orders.
        """
        own = self.values.size - 2 * (self.modes - self._first)  # of which the elastic modes are none
        if self._map is None or own == self.values.size:
            return tuple(range(self.values.size))
        if self._fewer is None or self.modes <= _DENSE_CHECK:
            return _of_the_whole(self._map, self.values, own)
        return _matched(self._fewer(_DENSE), self._map, self.values)

    @cached_property
    def _slowest(self) -> int | None:
        """Place of the largest that is not of the rigid motion."""
        return next((i for i in range(self.values.size) if i not in self.rigid), None)

    @property
    def ringing_mode(self) -> int:
        """The mode that dominates the slowest of all others, 1 … N; 0 without elastic modes."""
        if self._slowest is None:
            return 0
        return self._first + 1 + int(np.argmax(self._shares(complex(self.values[self._slowest]))[1:]))

    @property
    def rhythm(self) -> float:
        """Largest modulus of the two multipliers of the rigid motion."""
        return float(np.abs(self.values[list(self.rigid)]).max())

    @property
    def ringing(self) -> float | None:
        """Largest modulus of those of the elastic modes; None when there are none."""
        return None if self._slowest is None else float(np.abs(self.values[self._slowest]))

    def __str__(self) -> str:
        word = "stable" if self.stable else "unstable" if self.largest > 1.0 + NEUTRAL else "neutral"
        return f"{self.label}: {word}, largest modulus {self.largest:.6g}, {self.modes} modes"


def multipliers_of(
    label: str, system: System, matrix: LinearMap | CycleMap, fewer: Callable[[int], Multipliers] | None = None
) -> Multipliers:
    """Those of a map; few modes go to a dense eigensolver, many of one impact to the secular function."""
    omega = matrix.blocks.omega if isinstance(matrix, LinearMap) else matrix.omega
    modes = omega.size - int(system.body.is_free)
    if isinstance(matrix, LinearMap) and modes > _DENSE:
        values = _secular(matrix)
    else:
        values = np.linalg.eigvals(matrix.dense()).astype(complex)
    order = np.lexsort((values.imag, -values.real, -np.round(np.abs(values), 13)))
    return Multipliers(label, modes, values[order], system, matrix, fewer)


def reason_of(first: complex, margin: float, fold: bool = False, unseen: bool = False) -> Reason:
    """What decides: the multiplier of largest modulus; `unseen`: by an elastic mode that B77's criterion cannot see."""
    if fold:
        return Reason.FOLD
    if margin > NEUTRAL:
        return Reason.STABLE
    if margin >= -NEUTRAL:
        return Reason.NEUTRAL
    if unseen:
        return Reason.ELASTIC
    if abs(first.imag) > TURNING * abs(first):
        return Reason.SPIRAL
    return Reason.FOLD if first.real > 0.0 else Reason.FLIP


def _of_the_whole(matrix: LinearMap | CycleMap, values: ComplexArray, own: int) -> tuple[int, ...]:
    """The multipliers, `own` of them, in which the motion as a whole takes part most."""
    # By the real part: where two multipliers meet, their factors grow without bound with opposite signs. Multipliers of
    # 0 (R = 0 has one in every block) have no eigenvectors of their own: together they have what the others leave of
    # `own`.
    size = values.size
    alive = int(np.count_nonzero(np.abs(values) > _TINY * max(1.0, float(np.abs(values[0])))))
    part = matrix.participation(values[:alive]).real
    found = np.argsort(-part, kind="stable")[:own].tolist()
    left, dead = own - float(part.sum()) if alive < size else 0.0, 0
    while dead < min(own, size - alive) and (dead + len(found) < own or left > part[found[-1]]):
        found, left, dead = found[: own - dead - 1], left - 1.0, dead + 1
    return (*sorted(found), *range(size - dead, size))


def _matched(few: Multipliers, matrix: LinearMap | CycleMap, values: ComplexArray) -> tuple[int, ...]:
    """Positions of the two rigid multipliers among those of very many modes: nearest to where few modes have them."""
    found: list[int] = []
    for one in few.values[list(few.rigid)]:
        near = np.argsort(np.abs(values - one), kind="stable")[:_NEAR]
        near = near[~np.isin(near, found)]
        lost = abs(one) <= _TINY * max(1.0, few.largest)
        part = matrix.participation(values[near]).real
        found.append(int(near[np.argmin(np.abs(values[near]))] if lost else near[np.argmax(part)]))
    return tuple(sorted(found))


def _secular(matrix: LinearMap) -> ComplexArray:
    """All roots of the secular function, believed only when all converged and two power sums fit the map."""
    ensure_cache()
    from percuss.steady import secular_kernels as kn  # only here is the compiler needed

    n = matrix.g.size
    work, state = np.zeros((kn.WORK_ROWS, 2 * n)), np.zeros((kn.STATE_ROWS, 2 * n), int)
    work[kn.JUMP, :n], work[kn.JUMP_RATE, :n] = matrix.g, matrix.g_velocity
    factors = matrix.velocity_factor, matrix.strain_factor
    check_interrupted()
    if kn.all_multipliers(*factors, matrix.speed, np.stack(matrix.blocks), work, state):
        return np.asarray(work[kn.RE] + 1j * work[kn.IM])
    if n <= _DENSE_CHECK:
        return np.asarray(np.linalg.eigvals(matrix.dense()).astype(complex))
    raise ConvergenceError(
        f"the multipliers of {n - 1} modes crowd too closely, velocities times {matrix.velocity_factor:g} at the "
        "impact: they miss the trace of their map",
        f"ask for at most {_DENSE_CHECK - 1} modes",
    )


# ---- What every periodic motion answers, whatever way it was found


class Repeating(ShortRepr):
    """A motion that repeats: what all of them are asked alike."""

    if TYPE_CHECKING:

        @property
        def system(self) -> System | Machine: ...
        @property
        def label(self) -> str: ...
        @property
        def modes(self) -> int: ...
        @property
        def times(self) -> tuple[float, ...]: ...
        @property
        def blow_energy(self) -> float: ...
        def _multipliers(self, side: Side) -> Multipliers: ...

    @property
    def rests(self) -> bool:
        """Whether the striking end lies on the wall for some time of every cycle, which erases all disturbances."""
        return False

    def multipliers(self, modes: int | None = None, *, side: Side = "right") -> Multipliers:
        """All multipliers over the cycle, exact for the body with the modes that the motion has.

        Parameters
        ----------
        modes
            None, or that number: others belong to another motion.
        side
            Which value of the load counts where it jumps at an impact.
        """
        if modes not in (None, self.modes):
            raise ParameterError("modes", modes, f"{self.modes}, the modes of the motion")
        choice("side", side, "left", "right")
        return self._multipliers(side)

    def judged(self, modes: int | None = None) -> Multipliers:
        """`multipliers`; where the load jumps at an impact, of the worse side."""
        found, load = self.multipliers(modes), self.system.load if isinstance(self.system, System) else None
        if load is None or "left" not in load.sides:
            return found
        if all(load.value(t, "left") == load.value(t) for t in self.times):
            return found
        return max(found, self.multipliers(modes, side="left"), key=lambda one: one.largest)

    @cached_property
    def _judged(self) -> Multipliers:
        return self.judged()

    @property
    def stable(self) -> bool:
        """Whether small disturbances die out; `percuss.stability.stability_of` says why, and by what margin."""
        return self.verdict is Reason.STABLE

    @property
    def verdict(self) -> Reason:
        """What the multipliers say; the worse side of a jump of the load decides."""
        return self._judged.verdict

    @property
    def figures(self) -> dict[str, float | None]:
        """The figures that maps and reports have, by name; dimensionless, None where there is none."""
        return figures_of(self)  # type: ignore[arg-type]  # each kind has what they need

    def follow(self, along: str, between: tuple[float, float] | None = None, **options: Any) -> Any:
        """The branch that it lies on; see `percuss.explore.follow`, which takes any motion first."""
        return lent("follow")(self, along, between, **options)


class FoundMotions(ShortRepr):
    """What a search found: length, number and iteration tell of its `orbits`, the motions."""

    if TYPE_CHECKING:

        @property
        def orbits(self) -> tuple[Any, ...]: ...

    def __len__(self) -> int:
        return len(self.orbits)

    def __iter__(self) -> Iterator[Any]:
        return iter(self.orbits)

    def __getitem__(self, number: int) -> Any:
        return self.orbits[number]

    def to_pandas(self) -> Any:
        """A row for each: its label, whether it is possible and stable, its phases and speeds, and its figures."""
        rows = [
            {"label": one.label, "admissible": one.admissible, "stable": one.stable, "times": one.times, **one.figures}
            for one in self
        ]
        return extra_package("pandas", "io").DataFrame(rows)
