"""The motion through p impacts in n load periods, told by the times of the impacts alone.

Between impacts the modes are free of each other, and an impact multiplies each by itself: what couples them is when the
impacts fall. Given the times t_1 < … < t_p < t_1 + T, T = 2πn, every mode has one state that comes back after T, by one
2×2 solve, and the velocity of the bar as a whole one value, by one division. What is left are p equations: over each
flight the striking end comes back to the wall,

    F_i(t_1 … t_p) = Δ_i + e_{i+1}⁻ − e_i⁺ = 0,

with Δ_i the advance of the bar as a whole and e = Σ γ_n u_n what the elastic modes add at the striking end, before and
after the impacts. For p = 1 it is B77 (14). A body that is held has no motion as a whole, and its place is known: there
F_i = e_i⁻ − g, with the gap g. With the times held the states never gain energy from cycle to cycle, so
that violently unstable orbits are found as easily as stable ones. All of it is computed by `kernels`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cache, cached_property, lru_cache
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from percuss.mechanics.kernel_cache import ensure_cache
from percuss.model import Contact, Modes, System
from percuss.model.checks import Array, ComplexArray
from percuss.model.load import Side
from percuss.steady.oscillator import comes_back, refuse_resonance

# ---- The compiled functions, loaded where they are first used, as loading the compiler takes long


class OrbitKernels(NamedTuple):
    """What Python calls; `percuss.steady.periodic.kernels` says what each does."""

    passage: Callable[..., None]
    singularity: Callable[..., float]
    flown: Callable[..., None]
    end_at: Callable[..., None]
    search: Callable[..., None]
    corrected: Callable[..., tuple[int, int]]
    derivatives: Callable[..., None]


@cache
def orbit_kernels() -> OrbitKernels:
    """Load them, from numba's cache if they are there; else each is compiled when it is first called."""
    ensure_cache()
    from percuss.steady.periodic.kernels import forced_passage, searching

    found: Any = (
        forced_passage.passage, searching.singularity, forced_passage.flown, forced_passage.end_at,
        searching.search, searching.corrected, searching.derivatives,
    )  # fmt: skip
    return OrbitKernels(*found)


@dataclass(frozen=True)
class Numbers:
    """A system with modes 0 … N in one row, as `kernels.forced_passage` has it; N, harmonics, or load steps."""

    row: Array = field(repr=False)
    modes: int
    waves: int
    steps: int

    def room(self, impacts: int) -> Any:
        """The arrays for orbits with p impacts."""
        from percuss.steady.periodic.kernels.forced_passage import room_for

        return room_for(self.modes, self.waves, self.steps, impacts)


@lru_cache(maxsize=64)
def numbers_of(system: System, modes: int) -> Numbers:
    """The numbers of a system; the last ones are kept. Not to be written into."""
    refuse_resonance(system)
    load, contact = system.load, system.contact
    known = system.body.modes(modes, load.at)
    row = [load.mean, system.push, system.d, contact.strain_factor, contact.velocity_factor]
    row += [float(system.body.is_free), system.body.gap]
    for values in (known.omega, known.damping, known.gamma):
        row += values.tolist()
    if load.is_piecewise:
        return Numbers(np.array([*row, *load.breaks, *load.values]), modes, 0, len(load.breaks))
    k = load.harmonics
    p = load.coefficients[k]
    return Numbers(np.array([*row, *k.tolist(), *p.real.tolist(), *p.imag.tolist()]), modes, k.size, 0)


# ---- The map of an elastic mode through the cycle with the times held
#
# Near internal resonance every flight takes a mode through nearly whole half turns, and M_n is nearly the diagonal
# matrix of the impacts alone. What is left is found by itself, so that det(ξ − M_n) at ξ = ±1 is not a difference of
# ones.


class ChainBlocks(NamedTuple):
    """M_n = [[a, b], [c, e]], the map of the elastic modes over a whole cycle; every array of shape (N,).

    `whole_a`, `whole_e` are what a and e would be if each flight were the nearest number of half turns, without
    damping, `off_a`, `off_e` what they are besides; `terms`, `angle`, `factor` as for `comes_back`.
    """

    b: Array
    c: Array
    whole_a: Array
    whole_e: Array
    off_a: Array
    off_e: Array
    terms: Array
    angle: Array
    factor: float

    @staticmethod
    def of(contact: Contact, known: Modes, step: tuple[Array, ...], flights: Array) -> ChainBlocks:
        """The map over flights, shape (p,), with propagators a, b, c, e over each, shapes (p, N)."""
        alpha, beta, p = contact.strain_factor, contact.velocity_factor, flights.shape[-1]
        loss = -np.expm1(-0.5 * known.damping * flights[:, None])
        lag = 0.5 * known.damping * step[1]
        cosine = step[0] - lag
        sign = np.copysign(1.0, cosine)
        cancels = np.abs(cosine) > 0.5
        sum_of = np.where(cancels, cosine + sign * (1.0 - loss), 1.0)
        near = np.where(cancels, (step[1] * step[2] + lag**2) / sum_of - sign * loss, cosine - sign)
        one, none = np.ones(known.omega.size), np.zeros(known.omega.size)
        whole_a, whole_e, off_a, off_e, b, c = one, one, none, none, none, none
        for i in range(p):
            sa, sb, sc, se = (part[i] for part in step)
            a, e = near[i] + lag[i], near[i] - lag[i]
            off_a, c = alpha * (sa * off_a + a * whole_a + sb * c), beta * (sc * (whole_a + off_a) + se * c)
            off_e, b = beta * (se * off_e + e * whole_e + sc * b), alpha * (sa * b + sb * (whole_e + off_e))
            whole_a, whole_e = alpha * sign[i] * whole_a, beta * sign[i] * whole_e
        terms = (2.0 * np.abs(near) + np.abs(step[1] * step[2])).sum(axis=0)
        factor = 1.0 + beta if p == 1 else 2.0
        return ChainBlocks(b, c, whole_a, whole_e, off_a, off_e, terms, known.omega * flights.sum(), factor)

    def away(self, xi: complex | ComplexArray | Array) -> tuple[Any, Any, Any]:
        """ξ − a, ξ − e and det(ξ − M_n)."""
        a, e = (xi - self.whole_a) - self.off_a, (xi - self.whole_e) - self.off_e
        return a, e, a * e - self.b * self.c

    @property
    def resonant(self) -> npt.NDArray[np.bool_]:
        """Which modes come back after a cycle by themselves, so that their amplitude is free; shape (N,)."""
        return comes_back(self.away(1.0)[2], self.terms, self.angle, self.factor)

    @property
    def poles(self) -> ComplexArray:
        """The eigenvalues of all M_n; shape (2N,)."""
        a, e = self.whole_a + self.off_a, self.whole_e + self.off_e
        half = 0.5 * (a + e)
        root = np.sqrt((half**2 - (a * e - self.b * self.c)).astype(complex))
        return np.concatenate([half + root, half - root])


# ---- The motion, and its linearisation as p equations for the shifts of the times (theory: several impacts)
#
# With ρ the change of a mode's state at fixed times and δt_i the shift of impact i, a cycle later ξ times both,
#
#     ρ_{i+1} = D Φ(h_i) ρ_i + s_{i+1} δt_{i+1},   s = Dẋ⁻ − ẋ⁺ = ((α − β) v⁻, (α − β) ω² u⁻ − (1 − β) p),
#
# the saltation (Leine & Nijmeijer, Dynamics and Bifurcations of Non-Smooth Mechanical Systems, 2004, ch. 7). Every mode
# is eliminated, one 2×2 solve for each shift; that the striking end comes back to the wall over each flight is then
# K(ξ) δt = 0 (of a body that is held: that it is there at each impact). K(1) is the derivative of the equations for the
# times, and nothing is divided by the speed of an impact, so that all stays finite where one dies.

_NEUTRAL = 1e-3  # 1 − Πβ E_i below which the rigid velocity is an unknown of its own
_GIVEN, _RETURNING, _BEST = range(3)  # as in the kernels: the velocity after the first impact
_ROWS, _FORCE = (0, 1, 2, 7, 8, 9, 10), 2  # of `impacts`, in the order of `Passage`


@dataclass(frozen=True)
class ImpactChain:
    """p impacts in n load periods of a system with the modes 0 … N; the forced part is cut there as well."""

    system: System
    impacts: int
    periods: int
    modes: int

    @property
    def period(self) -> float:
        """T = 2πn."""
        return 2.0 * math.pi * self.periods

    @cached_property
    def known(self) -> Modes:
        """The elastic modes 1 … N."""
        return self.system.body.modes(self.modes, self.system.load.at)

    @property
    def is_neutral(self) -> bool:
        """Whether the rigid velocity is an unknown of its own, with an equation: R = 1, no drag, p even."""
        kept = self.system.contact.velocity_factor**self.impacts * math.exp(-self.system.d * self.period)
        return self.system.body.is_free and abs(1.0 - kept) < _NEUTRAL

    def passage(self, times: Array, rebound: float | None = None, side: Side = "right") -> Passage:
        """The motion through impacts at times in order, t_p < t_1 + T; shape (p,)."""
        # `rebound` is the rigid velocity just after the first impact; None for that which comes back after a cycle, or
        # where none or every one does, for that which brings the striking end back to the wall best. `side`: which
        # value of the load counts where it jumps at an impact.
        numbers = numbers_of(self.system, self.modes)
        room, kind = numbers.room(self.impacts), _GIVEN
        if rebound is None:
            rebound, kind = 0.0, _BEST if self.is_neutral else _RETURNING
        orbit_kernels().passage(numbers.row, room, self.period, times, kind, rebound)
        if side == "left":
            room.impacts[_FORCE] = self.system.load.value(times, side)
        return Passage(self, room, *(room.impacts[row] for row in _ROWS))


@dataclass(frozen=True, eq=False)
class Passage:
    """The motion through the impacts at given times; of what each impact has rows of the shape (p,), or (p, N)."""

    chain: ImpactChain
    room: Any
    times: Array
    flights: Array
    force: Array  # from one side where the load jumps
    rigid: Array  # the velocity of the bar as a whole just before, and just after
    rebound: Array
    speed: Array  # of the striking end just before
    gap: Array  # F_i

    @property
    def closure(self) -> float:
        """By how much the rigid velocity just after the first impact has changed after a cycle."""
        return float(self.room.whole[0])

    @property
    def step(self) -> tuple[Array, ...]:
        """a, b, c and e of the propagators over the flights; shapes (p, N)."""
        return tuple(self.room.carried[:4].transpose(0, 2, 1))

    @property
    def elastic(self) -> tuple[Array, ...]:
        """u_n and u_n' just before each impact, and the forced motion f_n and f_n' there; shapes (p, N)."""
        return tuple(self.room.carried[4:].transpose(0, 2, 1))

    @cached_property
    def blocks(self) -> ChainBlocks:
        """M_n."""
        return ChainBlocks.of(self.chain.system.contact, self.chain.known, self.step, self.flights)

    def bordered(self, xi: complex) -> Array | ComplexArray:
        """K(ξ) with the change of the rigid velocity as an unknown more, which is ξ times itself after a cycle."""
        if isinstance(xi, complex):
            return np.asarray(self.rational.matrices(np.array([xi]))[0])
        orbit_kernels().singularity(self.room, float(xi))
        size = self.chain.impacts + 1
        return np.array(self.room.matrix[:size, :size])

    @cached_property
    def singular(self) -> tuple[float, float]:
        """det K(1) and det K(−1), each row taken by its length: 0 at a fold, and at a flip."""
        fold, flip = (orbit_kernels().singularity(self.room, xi) for xi in (1.0, -1.0))
        return fold, flip

    @cached_property
    def rational(self) -> RationalMatrix:
        return RationalMatrix.of(self)


# ---- K(ξ) for many ξ at once: every mode is a pole of K(ξ) of rank two, which needs to be looked at only once
#
# With M_n the map of mode n through the cycle, r_j what the shift of impact j leaves of it a cycle later and R_i how
# its state after the first impact moves the striking end over flight i, K(ξ) is A_0 + ξA_1 + Σ R_i (ξ − M_n)⁻¹ r_j, the
# column of the first impact ξ times; and (ξ − M)⁻¹ = (ξ + adj)/det(ξ − M) for a 2×2 matrix.

_AWAY = 2.0  # a ξ that no mode has for an eigenvalue


class RationalMatrix(NamedTuple):
    """K(ξ) of one motion as a rational function of ξ, with the rigid velocity as an unknown more.

    `steady` and `turned` are A_0 and A_1, of shape (p + 1, p + 1); `first` and `second` γ_n R_i r_j and
    γ_n R_i adj(−M_n) r_j, of shape (N, p, p); `blocks` M_n.
    """

    steady: Array
    turned: Array
    first: Array
    second: Array
    blocks: ChainBlocks

    @staticmethod
    def of(passage: Passage) -> RationalMatrix:
        rows, columns, blocks = _rows(passage), _columns(passage), passage.blocks
        gamma, size = passage.chain.known.gamma, passage.chain.impacts + 1
        first = np.einsum("kin,kjn,n->nij", rows, columns, gamma)
        a, e = blocks.whole_a + blocks.off_a, blocks.whole_e + blocks.off_e
        turned = np.stack([-e * columns[0] + blocks.b * columns[1], blocks.c * columns[0] - a * columns[1]])
        second = np.einsum("kin,kjn,n->nij", rows, turned, gamma)
        modes = RationalMatrix(np.zeros((size, size)), np.zeros((size, size)), first, second, blocks)
        ends = [passage.bordered(xi) - modes.matrices(np.array([xi]))[0].real for xi in (_AWAY, -_AWAY)]
        return modes._replace(steady=0.5 * (ends[0] + ends[1]), turned=(ends[0] - ends[1]) / (2.0 * _AWAY))

    def matrices(self, xi: ComplexArray | Array) -> ComplexArray:
        """K(ξ) for an array of ξ, shape (m,); shape (m, p + 1, p + 1)."""
        xi = np.asarray(xi, dtype=complex)
        weight = 1.0 / self.blocks.away(xi[:, None])[2]
        p = self.steady.shape[0] - 1
        found: ComplexArray = np.asarray(self.steady + xi[:, None, None] * self.turned, dtype=complex)
        elastic = (xi[:, None] * weight) @ self.first.reshape(-1, p * p) + weight @ self.second.reshape(-1, p * p)
        elastic = elastic.reshape(-1, p, p)
        elastic[:, :, 0] *= xi[:, None]
        found[:, :p, :p] += elastic
        return found

    def directions(self, xi: ComplexArray | Array) -> ComplexArray:
        """det K(ξ) over its modulus; shape (m,)."""
        return np.asarray(np.linalg.slogdet(self.matrices(xi))[0])


def _rows(passage: Passage) -> Array:
    """R_i: how u_n and u_n' after the first impact move the striking end over each flight; shape (2, p, N)."""
    system, (p, modes) = passage.chain.system, passage.step[0].shape
    alpha, beta, is_free = system.contact.strain_factor, system.contact.velocity_factor, system.body.is_free
    now, found = np.eye(2)[:, :, None] * np.ones(modes), np.empty((2, p, modes))  # columns of u and u'
    for i in range(p):
        a, b, c, e = (part[i] for part in passage.step)
        moved = a * now[0] + b * now[1]
        found[:, i] = moved - now[0] if is_free else now[0]
        now = np.stack([alpha * moved, beta * (c * now[0] + e * now[1])])
    return found


def _columns(passage: Passage) -> Array:
    """r_j: what the shift of each impact leaves of u_n and u_n' at the end of the cycle; shape (2, p, N)."""
    contact, known, (place, rate, *_) = passage.chain.system.contact, passage.chain.known, passage.elastic
    alpha, beta = contact.strain_factor, contact.velocity_factor
    pull = (alpha - beta) * known.omega**2 * place
    found = np.stack([(alpha - beta) * rate, pull - contact.impulse * passage.force[:, None]])
    for i in range(1, passage.chain.impacts):
        a, b, c, e = (part[i] for part in passage.step)
        u, v = found[0, 1 : i + 1], found[1, 1 : i + 1]
        found[0, 1 : i + 1], found[1, 1 : i + 1] = alpha * (a * u + b * v), beta * (c * u + e * v)
    return found
