"""The stepped bar: sections of different cross-section or material, joined end to end."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, fields
from functools import cached_property, lru_cache
from itertools import accumulate, pairwise
from typing import ClassVar, NamedTuple

import numpy as np
import numpy.typing as npt

from percuss.errors import ParameterError
from percuss.halting import check_interrupted
from percuss.model.body.body import Body, ComplexShape, Shape
from percuss.model.body.damping import UNDAMPED, Damping, check_damping
from percuss.model.body.uniform import Bar, Piece, SizedBody, sinc_deficit, wave_speed
from percuss.model.checks import Array, ComplexArray, instance, non_negative, numbers, positive, several

# ---- A chain of sections as its mechanics see it: impedances, transit times, and which point lies in which section

Numbers = npt.NDArray[np.intp]  # numbers of sections, from 0 on


class SectionChain:
    """Sections from the driven end to the striking end, of mass 1 and length 1 together.

    Only the ratios of impedances and lengths matter; without lengths the transit times stand for them. Attributes:
    `impedance` Z_i with Σ Z_i τ_i = 1, and `transit` τ_i, shape (K,); `before` and `after`, mass on the driven end's
    and on the striking end's side of the sections' boundaries, shape (K + 1,); `start` and `width`, where sections
    begin, from 0 to 1, and their lengths, shape (K,).
    """

    def __init__(self, impedances: Array, transit_times: Array, lengths: Array | None = None) -> None:
        self.transit = transit_times
        self.impedance = impedances / np.dot(impedances, transit_times)
        mass = self.impedance * transit_times
        self.before = np.append(0.0, np.cumsum(mass))
        self.after = np.append(np.cumsum(mass[::-1])[::-1], 0.0)
        sizes = transit_times if lengths is None else lengths
        ends = np.cumsum(sizes)
        self.start, self.width = np.append(0.0, ends[:-1]) / ends[-1], sizes / ends[-1]

    @property
    def size(self) -> int:
        """K."""
        return self.transit.size

    @cached_property
    def mirrored(self) -> SectionChain:
        """The same bar turned round."""
        return SectionChain(self.impedance[::-1], self.transit[::-1], self.width[::-1])

    @cached_property
    def slowness(self) -> Array:
        """Time of a wave per length, shape (K,): slopes along x are these times slopes along the wave's time."""
        return np.asarray(self.transit / self.width)

    @cached_property
    def stiffness(self) -> Array:
        """Force per strain, shape (K,)."""
        return np.asarray(self.impedance / self.slowness)

    @cached_property
    def lag(self) -> float:
        """Most by which the steps together can turn the phase of a wave: Σ arcsin |reflection coefficient|."""
        steps = pairwise(self.impedance.tolist())
        return float(sum(np.arcsin(abs(one - other) / (one + other)) for one, other in steps))

    def locate(self, x: Array) -> tuple[Numbers, Array]:
        """The section of each point, the later one at a step, and the time of a wave from its start to the point."""
        section = np.searchsorted(self.start[1:], x, side="right")
        begin, end = self.start[section], np.append(self.start[1:], 1.0)[section]  # a step is nowhere else
        share = np.clip((x - begin) / np.where(end > begin, end - begin, 1.0), 0.0, 1.0)
        return section, share * self.transit[section]

    def masses(self, section: Numbers, time: Array) -> tuple[Array, Array]:
        """Mass on both sides of points; neither is a difference from 1."""
        z, left = self.impedance[section], self.transit[section] - time
        return self.before[section] + z * time, self.after[section + 1] + z * left


@lru_cache(maxsize=64)
def chain(
    impedances: tuple[float, ...], transit_times: tuple[float, ...], lengths: tuple[float, ...] | None, s: float
) -> SectionChain:
    """The chain whose transit times add up to 1/s."""
    times = np.asarray(transit_times) / (s * float(np.sum(transit_times)))
    return SectionChain(np.asarray(impedances), times, None if lengths is None else np.asarray(lengths))


# ---- Receptance of a chain of sections at complex frequencies: all its modes together, by transfer matrices
#
# U is the motion with unit displacement at a free end, M the sum of all mass between there and a point, each part times
# its displacement: the force at the point is −z²M. U_L comes from the driven end, U_R from the striking end, and
# w = U_L M_R + U_R M_L is the same everywhere. The answer to a unit force at p is −U_L(a) U_R(b)/(z² w), a the one of x
# and p that is nearer to the driven end, b the other. Its rigid part −1/z² is taken off. Well below the first mode that
# would cancel, so there U = 1 − z²D and M = m − z²Q are told by D and Q, and z² drops out of the difference.

_DEEP = 50.0  # Im zτ beyond which the wave that fades away is nothing beside the other


class _Motion(NamedTuple):
    """(U, M) times e^{−log}, or (D, Q) and log 0; first axis frequencies."""

    first: ComplexArray
    second: ComplexArray
    log: Array


def elastic_receptance(
    sections: SectionChain, z: ComplexArray, x: Array, source: float, lowest: float
) -> tuple[ComplexArray, ComplexArray]:
    """Σ_{n≥1} φ_n(x) φ_n(p)/(ω_n² − z²) and its slope, (K, len(x)), p = `source`, Im z ≤ 0; `lowest` is ω_1."""
    shape = np.empty((z.size, x.size), complex)
    slope = np.empty_like(shape)
    slow = np.abs(z) <= min(0.5 * lowest, 1.0 / float(sections.transit.sum()))
    for chosen, answer in ((slow, _slow), (~slow, _fast)):
        if chosen.any():
            shape[chosen], slope[chosen] = answer(sections, z[chosen], x, source)
    return shape, slope


def _slow(sections: SectionChain, z: ComplexArray, x: Array, source: float) -> tuple[ComplexArray, ComplexArray]:
    """Well below the first mode."""
    square = (z * z)[:, None]
    at_x, at_p = _both(sections, z, x, True), _both(sections, z, np.array([source]), True)
    (here, (m_x, n_x)), (there, (m_p, n_p)) = at_x, at_p
    left = (x < source)[None, :]  # of the source
    d_left, q_left = (np.where(left, own, other) for own, other in zip(here[0][:2], there[0][:2], strict=True))
    d_right = np.where(left, there[1].first, here[1].first)
    near_d, near_q = (np.where(left, own, other) for own, other in zip(here[1][:2], there[1][:2], strict=True))
    m, n = np.where(left, m_x, m_p), np.where(left, n_x, n_p)
    u_left, m_left = 1.0 - square * d_left, m - square * q_left
    w = u_left * (n - square * near_q) + (1.0 - square * near_d) * m_left
    shape = (m * d_left - q_left + u_left * (d_right - near_q) - near_d * m_left) / w
    force = np.where(
        left,
        (m_x - square * here[0].second) * (1.0 - square * there[1].first),
        -(n_x - square * here[1].second) * (1.0 - square * there[0].first),
    )
    return shape, force / w / sections.stiffness[sections.locate(x)[0]]


def _fast(sections: SectionChain, z: ComplexArray, x: Array, source: float) -> tuple[ComplexArray, ComplexArray]:
    """Where the rigid part is not much greater than what is left without it."""
    square = (z * z)[:, None]
    (x_left, x_right), _ = _both(sections, z, x, False)
    (p_left, p_right), _ = _both(sections, z, np.array([source]), False)
    w = p_left.first * p_right.second + p_right.first * p_left.second
    left = (x < source)[None, :]
    fading = np.exp(np.where(left, x_left.log - p_left.log, x_right.log - p_right.log))
    product = np.where(left, x_left.first * p_right.first, p_left.first * x_right.first)
    force = np.where(left, x_left.second * p_right.first, -p_left.first * x_right.second)
    shape = 1.0 / square - product * fading / (square * w)
    return shape, force * fading / w / sections.stiffness[sections.locate(x)[0]]


def _both(
    sections: SectionChain, z: ComplexArray, x: Array, slow: bool
) -> tuple[tuple[_Motion, _Motion], tuple[Array, Array]]:
    """The motions from the driven and from the striking end at points, and the masses on both sides of these."""
    section, time = sections.locate(x)
    rest = sections.transit[section] - time
    masses = sections.masses(section, time)
    turned = sections.mirrored
    left = _motion(sections, z, section, time, slow)
    return (left, _motion(turned, z, sections.size - 1 - section, rest, slow)), masses


def _motion(sections: SectionChain, z: ComplexArray, section: Numbers, time: Array, slow: bool) -> _Motion:
    """The motion from the first section's start on, at points; shapes (K, len(section))."""
    still = np.zeros_like(z)
    starts = [_Motion(still if slow else still + 1.0, still, np.zeros(z.size))]
    z_i, tau, m = sections.impedance, sections.transit, sections.before
    for i in range(int(section.max(initial=0))):
        here = starts[-1]
        starts.append(_deviating(here, z, z_i[i], tau[i], m[i]) if slow else _growing(here, z, z_i[i], tau[i]))
    at = _Motion(*(np.stack(parts, axis=-1)[:, section] for parts in zip(*starts, strict=True)))
    z = z[:, None]
    return _deviating(at, z, z_i[section], time, m[section]) if slow else _growing(at, z, z_i[section], time)


def _growing(state: _Motion, z: ComplexArray, impedance: Array, time: Array) -> _Motion:
    """(U, M) after some time of a wave along a section, its growth in the logarithm."""
    q = z * time
    depth = np.minimum(-q.imag, _DEEP)
    scale = np.exp(-depth)
    cosine, sine = np.cos(q.real - 1j * depth) * scale, np.sin(q.real - 1j * depth) * scale / z
    u = state.first * cosine - z * z * state.second * sine / impedance
    m = state.second * cosine + impedance * state.first * sine
    size = np.abs(u) + np.abs(z * m) / impedance
    return _Motion(u / size, m / size, state.log - q.imag + np.log(size))


def _deviating(state: _Motion, z: ComplexArray, impedance: Array, time: Array, before: Array) -> _Motion:
    """(D, Q) after some time of a wave along a section; `before` is the mass behind its start."""
    d, rest, _ = state
    q = z * time
    cosine = np.cos(q)
    sine = time * (1.0 - sinc_deficit(q))  # sin(zt)/z
    bend = 0.5 * (time * (1.0 - sinc_deficit(0.5 * q))) ** 2  # (1 − cos zt)/z²
    lag = time**3 * _cubic(q)  # (t − sin(zt)/z)/z²
    return _Motion(
        bend + d * cosine + (before - z * z * rest) * sine / impedance,
        before * bend + rest * cosine + impedance * (lag + d * sine),
        state.log,
    )


def _cubic(q: ComplexArray) -> ComplexArray:
    """(q − sin q)/q³, 1/6 at 0."""
    tiny = np.abs(q) < 1e-3
    far = np.where(tiny, 1.0, q)
    return np.asarray(np.where(tiny, (1.0 - q * q / 20.0) / 6.0, sinc_deficit(far) / far**2))


# ---- Modes of a chain of sections by the Prüfer angle: every one of them, in order, without a determinant
#
# With u = r cos θ and N/(Zω) = r sin θ the angle grows by ωτ along a section and stays in its quadrant at a step, where
# tan θ' = (Z/Z') tan θ. The angle Θ(ω) at the far end grows with ω, and mode n is the one root of Θ(ω) = nπ: no mode
# can be missed, and none is found twice. Angles are kept as a number of half turns and a unit vector with cos θ ≥ 0:
# nothing is lost near the quarter turns, where a step of 10⁶ leaves nearly all angles.

_BLOCK = 4096  # modes found at a time: bounds the memory
_LEAST_END = 1e-75  # of |φ_n(1)|, where a mode hardly reaches the end: its square stays in the range of doubles
_ANGLE_ROUNDING = 4e-16
_MOST_STEPS = 200  # bisection alone needs half of them


class SectionWaves(NamedTuple):
    """Modes n = 1 … N: φ_n = Re(wave e^{iωt}), t from a section's start, φ_n(1) > 0; (N,), (K, N); mass 1."""

    omega: Array
    wave: ComplexArray
    end: Array


class _March(NamedTuple):
    """What a march from the first section to the last meets at the starts of sections, and at the end."""

    vectors: ComplexArray  # (K, N)
    turns: Array  # (K, N), half turns
    growths: Array  # (K, N), ln r
    angle: Array  # (N,), less the half turns, at the end
    turns_at_end: Array  # (N,)
    slope: Array  # (N,), dΘ/dω


def frequencies(sections: SectionChain, count: int) -> Array:
    """ω_1 … ω_N of the free chain; shape (count,)."""
    blocks = [np.arange(first, min(first + _BLOCK, count + 1.0)) for first in np.arange(1.0, count + 1.0, _BLOCK)]
    return np.concatenate([_roots(sections, block) for block in blocks])


@lru_cache(maxsize=8)
def waves(impedances: tuple[float, ...], transit_times: tuple[float, ...], count: int) -> SectionWaves:
    """The first modes of a chain whose transit times add up to 1; in another time each ω is greater by a factor."""
    sections = chain(impedances, transit_times, None, 1.0)
    omega = frequencies(sections, count)
    numbers = np.arange(1.0, count + 1.0)
    blocks = [slice(first, first + _BLOCK) for first in range(0, count, _BLOCK)]
    wave = np.concatenate([_waves(sections, omega[block], numbers[block]) for block in blocks], axis=1)
    end = np.maximum(np.abs(wave[-1]), _LEAST_END)
    for values in (omega, wave, end):
        values.setflags(write=False)
    return SectionWaves(omega, wave, end)


def _march(sections: SectionChain, omega: Array) -> _March:
    """Vector, half turns and ln r from θ = 0 at the start on."""
    phases = np.outer(sections.transit, omega)
    half = np.floor(phases / np.pi)
    turned = np.exp(1j * phases) * (1.0 - 2.0 * (half % 2.0))
    turned.imag = np.abs(turned.imag)  # rounding must not turn it back
    shape = phases.shape
    vectors, turns, growths = np.empty(shape, complex), np.empty(shape), np.empty(shape)
    vector, turn, growth = np.ones(shape[1], complex), np.zeros(shape[1]), np.zeros(shape[1])
    slope = np.zeros(shape[1])
    z, tau = sections.impedance.tolist(), sections.transit.tolist()
    for i in range(sections.size):
        vectors[i], turns[i], growths[i] = vector, turn, growth
        vector = vector * turned[i]
        over = vector.real < 0.0
        vector = np.where(over, -vector, vector)
        turn = turn + half[i] + over
        slope = slope + tau[i]
        if i + 1 < sections.size and z[i] != z[i + 1]:
            step = z[i] / z[i + 1]
            vector.imag *= step
            stretch = np.abs(vector)
            vector = vector / stretch
            growth = growth + np.log(stretch)
            slope = slope * (step / stretch**2)
    return _March(vectors, turns, growths, np.angle(vector), turn, slope)


def _roots(sections: SectionChain, numbers: Array) -> Array:
    """The roots of Θ(ω) = nπ: Newton's steps, halving wherever these leave the bracket or do not halve the error."""
    total = float(sections.transit.sum())
    omega = np.pi * numbers / total
    room = (sections.lag + 1e-9) / total
    low, high = np.maximum(omega - room, 0.0), omega + room
    error, todo = np.full(numbers.size, np.inf), np.arange(numbers.size)
    for _ in range(_MOST_STEPS):
        check_interrupted()
        here = omega[todo]
        end = _march(sections, here)
        off = (end.turns_at_end - numbers[todo]) * np.pi + end.angle
        low[todo] = np.where(off <= 0.0, here, low[todo])
        high[todo] = np.where(off >= 0.0, here, high[todo])
        step = off / end.slope
        newton = here - step
        slow = np.abs(off) > 0.5 * error[todo]
        middle = 0.5 * (low[todo] + high[todo])
        within = (newton > low[todo]) & (newton < high[todo])
        tight = np.abs(step) <= _ANGLE_ROUNDING * here
        done = tight | (high[todo] - low[todo] <= _ANGLE_ROUNDING * here)
        error[todo] = np.abs(off)
        omega[todo] = np.where(done, here, np.where(within & ~slow, newton, middle))
        todo = todo[~done]
        if not todo.size:
            break
    return omega


def _waves(sections: SectionChain, omega: Array, numbers: Array) -> ComplexArray:
    """The normalized waves of modes, (K, N), by marches from both ends, which meet where Z r r' is greatest."""
    left, right = _march(sections, omega), _march(sections.mirrored, omega)
    phases = np.outer(sections.transit, omega)
    back = right._replace(vectors=right.vectors[::-1], turns=right.turns[::-1], growths=right.growths[::-1])
    apart = (left.turns + back.turns - numbers) * np.pi + np.angle(left.vectors) + np.angle(back.vectors) + phases
    weight = np.log(sections.impedance)[:, None] + left.growths + back.growths
    near = np.abs(apart) <= np.maximum(0.5 * np.pi, np.abs(apart).min(axis=0))
    meet = np.argmax(np.where(near, weight, -np.inf), axis=0)
    sign = 1.0 - 2.0 * ((left.turns + numbers) % 2.0)
    from_left = sign * left.vectors
    from_right = (1.0 - 2.0 * (back.turns % 2.0)) * np.conj(back.vectors * np.exp(1j * phases))
    column = np.arange(numbers.size)
    growths = back.growths + (left.growths - back.growths)[meet, column]
    before = np.arange(sections.size)[:, None] <= meet
    units, growths = np.where(before, from_left, from_right), np.where(before, left.growths, growths)
    sizes = np.exp(growths - growths.max(axis=0))
    middles = (units * np.exp(0.5j * phases)).real ** 2  # cos² at the middle of the section
    shares = 2.0 * middles - (2.0 * middles - 1.0) * sinc_deficit(phases.astype(complex)).real
    mass = np.einsum("kn,k,kn->n", sizes**2, 0.5 * sections.impedance * sections.transit, shares)
    return np.asarray(units * (sizes / np.sqrt(mass)))


# ---- The stepped bar: sections of different cross-section or material, joined end to end

MOST_SECTIONS = 200  # sections of a bar: far more than a machine's, and few enough for thousands of modes in a second
MOST_JUMP = 1e6  # impedances of two neighbours that differ by more are a slip of units, not a bar
_MOST_RATIO = 1e15  # of two impedances, or two transit times: beyond it one of the sections is nothing
_LEAST_KEPT = 64
_ROUNDING = 1e-12  # by which equal impedances may differ


@dataclass(frozen=True)
class SteppedBar(Body):
    """A bar of sections, each with its impedance and the time that a wave takes through it.

    Nothing but these two numbers of a section enters the mechanics, and of them only the ratios: the mass of the bar is
    1, and the transit times add up to 1/s. A load may act at the driven end or at any step.

    Parameters
    ----------
    s
        One over the time of a wave from end to end, in radians of the load; dimensionless, greater than 0.
    impedances, transit_times
        Z_i = A_i √(E_i ρ_i) of the 1 to 200 sections from the driven end to the striking end, and times of a wave
        through them, each in any one unit.
    lengths
        Their lengths, in any one unit, which say where x is. Without them x runs with the transit time.

    Examples
    --------
    >>> from percuss.model.body import Ratio
    >>> bar = SteppedBar(5.0, impedances=(2.0, 1.0), transit_times=(1.0, 2.0), damping=Ratio(1e-3))
    >>> bar.modes(3).omega.round(4).tolist(), bar.modes(3).gamma.round(4).tolist()
    ([14.3297, 32.7941, 47.1239], [-1.7321, 1.7321, -2.0])
    """

    kind: ClassVar[str] = "stepped"

    s: float
    impedances: tuple[float, ...]
    transit_times: tuple[float, ...]
    damping: Damping = UNDAMPED
    lengths: tuple[float, ...] | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "s", wave_speed(self.s))
        check_damping(self.damping)
        count = len(_sections("impedances", self.impedances))
        for name in ("impedances", "transit_times", "lengths"):
            values = getattr(self, name)
            if name == "lengths" and values is None:
                continue
            found = _sections(name, values)
            if len(found) != count:
                raise ParameterError(name, f"{len(found)} of them", f"as many as there are impedances, {count}")
            object.__setattr__(self, name, found)
        self._check_jumps()

    def _check_jumps(self) -> None:
        for i, (one, other) in enumerate(pairwise(self.impedances), 1):
            if max(one, other) > (1.0 - 1e-9) * MOST_JUMP * min(one, other):
                wanted = f"a section whose impedance differs from its neighbour's by less than {MOST_JUMP:,.0f} times"
                raise ParameterError(f"impedances[{i}]", other, wanted, "check the units")

    @property
    def sections(self) -> SectionChain:
        """The sections as their mechanics see them."""
        return chain(self.impedances, self.transit_times, self.lengths, self.s)

    @property
    def places(self) -> tuple[float, ...]:
        """The driven end, 0, and the steps."""
        return tuple(self.sections.start.tolist())

    @property
    def is_harmonic(self) -> bool:
        """Its sections have the same impedance."""
        return max(self.impedances) <= (1.0 + _ROUNDING) * min(self.impedances)

    @property
    def is_uniform(self) -> bool:
        """Its sections have the same impedance and the same speed of waves."""
        slow = np.divide(self.transit_times, self.lengths or self.transit_times)
        return self.is_harmonic and bool(slow.max() <= (1.0 + _ROUNDING) * slow.min())

    def _waves(self, count: int) -> SectionWaves:
        """Of `count` modes and some more: the number is rounded up, so that few tables serve all questions."""
        found = waves(self.impedances, self.transit_times, max(_LEAST_KEPT, 1 << (count - 1).bit_length()))
        return found._replace(omega=self.s * found.omega)

    def frequencies(self, count: int) -> Array:
        return self._waves(count).omega[:count]

    def inertia(self, count: int) -> Array:
        return np.asarray(1.0 / self._waves(count).end[:count] ** 2)

    def shapes(self, x: Array, count: int) -> Shape:
        found, x = self._waves(count), np.asarray(x, dtype=float)
        omega, end = found.omega[:count], found.end[:count]
        section, time = self.sections.locate(x)
        here = found.wave[section, :count] * np.exp(1j * np.outer(time, omega))
        rise = -here.imag * omega * self.sections.slowness[section][:, None]
        return Shape(here.real / end, rise / end)

    def static_shape(self, x: Array, source: float = 0.0) -> Shape:
        """∫ T_x T_p/(EA), T_x the force along the bar that a unit force at x makes in uniform acceleration."""
        bar, x = self.sections, np.asarray(x, dtype=float)
        low, high = np.minimum(x, source), np.maximum(x, source)
        rise = _bending(bar, low)[0] + _bending(bar, high)[2] - (_bending(bar, high)[1] - _bending(bar, low)[1])
        section, time = bar.locate(x)
        before, after = bar.masses(section, time)
        return Shape(rise, np.where(x < source, before, -after) / bar.stiffness[section])

    def mass_before(self, x: Array) -> Array:
        bar = self.sections
        return bar.masses(*bar.locate(np.asarray(x, dtype=float)))[0]

    def frequency_floor(self, n: int) -> float:
        return self.s * (np.pi * n - self.sections.lag)

    @property
    def coupling_bound(self) -> float:
        """max 2/Σ_j m_j q_ij: r_j² ≥ q_ij r_i² at every angle at the steps, and Σ m_j r_j² = 2 for every mode."""
        bar = self.sections
        mass, least = bar.impedance * bar.transit, np.inf
        for i in range(bar.size):
            kept = 0.0
            for way in (range(i, bar.size), range(i - 1, -1, -1)):
                share, last = 1.0, i
                for j in way:
                    share *= min(1.0, bar.impedance[last] / bar.impedance[j]) ** 2
                    kept, last = kept + mass[j] * share, j
            least = min(least, kept)
        return float(2.0 / least)

    def lossless_receptance(self, z: ComplexArray, x: Array, source: float = 0.0) -> ComplexShape:
        z, x = np.asarray(z, dtype=complex), np.asarray(x, dtype=float)
        return ComplexShape(*elastic_receptance(self.sections, z, x, source, float(self.frequencies(1)[0])))

    def __str__(self) -> str:
        count = len(self.impedances)
        return f"s = {self.s:.6g}, {count} section{'s' if count > 1 else ''}, {self.damping}"


def _sections(name: str, values: object) -> tuple[float, ...]:
    accepted = f"numbers greater than 0, one for each of 1 to {MOST_SECTIONS} sections"
    found = np.atleast_1d(numbers(name, values, accepted))
    if found.ndim != 1:
        raise ParameterError(name, values, accepted)
    if not np.all(found > 0.0):
        i = int(np.argmin(found > 0.0))
        raise ParameterError(f"{name}[{i}]", float(found[i]), "a number greater than 0")
    if not 1 <= found.size <= MOST_SECTIONS:
        raise ParameterError(name, f"{found.size} of them", accepted)
    if not found.max() <= _MOST_RATIO * found.min():
        raise ParameterError(name, values, f"numbers that differ by at most a factor {_MOST_RATIO:g}")
    return tuple(found.tolist())


def _bending(bar: SectionChain, x: Array) -> tuple[Array, Array, Array]:
    """∫_0^x m²/EA, ∫_0^x m(1 − m)/EA and ∫_x^1 (1 − m)²/EA, m the mass from the driven end on; shapes like x."""
    section, time = bar.locate(x)
    edges = np.arange(bar.size)
    whole = _pieces(bar, edges, np.zeros(bar.size), bar.transit)
    first, second = _pieces(bar, section, np.zeros_like(time), time)[:2]
    third = _pieces(bar, section, time, bar.transit[section])[2]
    behind = [np.append(0.0, np.cumsum(values)) for values in whole[:2]]
    ahead = np.append(np.cumsum(whole[2][::-1])[::-1], 0.0)
    return behind[0][section] + first, behind[1][section] + second, ahead[section + 1] + third


def _pieces(bar: SectionChain, section: Numbers, start: Array, end: Array) -> tuple[Array, Array, Array]:
    """The three integrals over parts of sections, whose forces are linear along them."""
    (m, n), (mm, nn) = bar.masses(section, start), bar.masses(section, end)
    share = (end - start) / bar.impedance[section]
    squares = share * (m * m + m * mm + mm * mm) / 3.0, share * (n * n + n * nn + nn * nn) / 3.0
    return squares[0], share * (2.0 * m * n + m * nn + mm * n + 2.0 * mm * nn) / 6.0, squares[1]


# ---- The stepped bar in SI units: sections of any cross-section and material, joined end to end

_IMPEDANCE = re.compile(r"impedances\[(\d+)\]")


@dataclass(frozen=True)
class Section:
    """One section of a bar; steel unless told otherwise.

    Parameters
    ----------
    length
        In m; None for the endless last section of a rod that is struck, which no bar has.
    area, diameter
        Cross-sectional area in m², a bore taken off; or the outer diameter in m of a round section.
    bore
        Diameter in m of a hole along its axis.
    youngs_modulus, density
        In Pa and kg/m³.

    Examples
    --------
    >>> Section(0.25, diameter=0.04, bore=0.01).youngs_modulus
    210000000000.0
    """

    length: float | None
    area: float | None = None
    diameter: float | None = None
    bore: float = 0.0
    youngs_modulus: float = Bar.STEEL_MODULUS
    density: float = 7850.0

    def __post_init__(self) -> None:
        checks = {"bore": non_negative, "youngs_modulus": positive, "density": positive}
        if self.length is not None:
            checks["length"] = positive
        if (self.area is None) == (self.diameter is None):
            raise ParameterError("area", self.area, "either an area or a diameter")
        checks |= {"area": positive} if self.diameter is None else {"diameter": positive}
        for name, check in checks.items():
            object.__setattr__(self, name, check(name, getattr(self, name)))
        if self.diameter is not None and self.bore >= self.diameter:
            raise ParameterError("bore", self.bore, f"less than the diameter, {self.diameter:g}")

    def piece(self, start: float) -> Piece:
        """The same from a place on, in m; one without a length reaches to infinity."""
        if self.diameter is None:
            area = float(self.area or 0.0)
            outer = math.sqrt(4.0 / math.pi * area + self.bore**2)
        else:
            outer = self.diameter
            area = math.pi / 4.0 * (outer - self.bore) * (outer + self.bore)
        end = math.inf if self.length is None else start + self.length
        return Piece(start, end, area, self.youngs_modulus, self.density, outer, self.bore)


@dataclass(frozen=True)
class SectionedBar(SizedBody):
    """A bar of sections in SI units, such as a piston with a head and a shoulder.

    Parameters
    ----------
    sections
        From the driven end to the striking end, 1 to 200 of them; each a `Section`, or a dict of what makes one.

    Examples
    --------
    >>> piston = SectionedBar([Section(0.12, diameter=0.052), Section(0.25, diameter=0.04, bore=0.01)])
    >>> print(piston)
    SectionedBar: 2 sections, 370 mm × 1178 … 2124 mm², 4.31 kg, transit time 71.5 µs, first mode 6442 Hz
    """

    kind: ClassVar[str] = "stepped"

    sections: tuple[Section, ...]
    damping: Damping = UNDAMPED

    def __post_init__(self) -> None:
        given = several("sections", self.sections, "a list of sections")
        if not 1 <= len(given) <= MOST_SECTIONS:
            raise ParameterError("sections", f"{len(given)} of them", f"1 to {MOST_SECTIONS} sections")
        object.__setattr__(self, "sections", tuple(section_of(i, one) for i, one in enumerate(given)))
        for i, section in enumerate(self.sections):
            if section.length is None:
                raise ParameterError(f"sections[{i}].length", None, "a length in m", "only a struck rod can be endless")
        instance("damping", self.damping, Damping)
        if not (math.isfinite(self.mass) and self.mass > 0.0 and math.isfinite(self.length)):
            raise ParameterError("sections", "sizes", "sizes and densities that give the bar a finite mass")
        try:
            self.body(1.0 / self.transit_time)  # what cannot be a bar is refused here
        except ParameterError as error:
            if (jump := _IMPEDANCE.fullmatch(error.name)) is None:
                raise
            area = self.pieces[int(jump[1])].area
            raise ParameterError(f"sections[{jump[1]}].area", area, error.accepted, error.remedy) from None

    @cached_property
    def pieces(self) -> tuple[Piece, ...]:
        """Its sections from the driven end to the striking end."""
        return pieces_of(self.sections)

    @property
    def _lengths(self) -> tuple[float, ...]:
        return tuple(section.length for section in self.sections if section.length is not None)

    @property
    def length(self) -> float:  # type: ignore[override]  # what the contract reads
        """L in m."""
        return self.pieces[-1].end

    def body(self, angular_frequency: float) -> SteppedBar:
        """The dimensionless bar under a load whose fundamental has the angular frequency Ω, in rad/s."""
        omega = positive("angular_frequency", angular_frequency)
        return SteppedBar(
            1.0 / (self.transit_time * omega),
            tuple(piece.impedance for piece in self.pieces),
            tuple(piece.transit_time for piece in self.pieces),
            self.damping.per_radian(omega),
            self._lengths,
        )

    def __str__(self) -> str:
        count, areas = len(self.pieces), [1e6 * piece.area for piece in self.pieces]
        span = f"{min(areas):.4g}" if min(areas) == max(areas) else f"{min(areas):.4g} … {max(areas):.4g}"
        return (
            f"SectionedBar: {count} section{'s' if count > 1 else ''}, {1e3 * self.length:.4g} mm × {span} mm², "
            f"{self.mass:.3g} kg, transit time {1e6 * self.transit_time:.3g} µs, "
            f"first mode {self.natural_frequencies(1)[0]:.4g} Hz"
        )


def pieces_of(sections: tuple[Section, ...]) -> tuple[Piece, ...]:
    """The sections where they lie, from the first one on; an endless last one ends at infinity."""
    starts = accumulate((section.length or 0.0 for section in sections[:-1]), initial=0.0)
    return tuple(section.piece(start) for section, start in zip(sections, starts, strict=bool(sections)))


def section_of(number: int, given: object) -> Section:
    """A section, or the one that a dict makes; errors say which one it is."""
    name = f"sections[{number}]"
    if isinstance(given, Section):
        return given
    keys = [field.name for field in fields(Section)]
    if not isinstance(given, Mapping) or not {"length"} <= given.keys() <= set(keys):
        raise ParameterError(name, given, f"a Section, or a dict with a length and of {', '.join(keys[1:])}")
    try:
        return Section(**given)
    except ParameterError as error:
        raise ParameterError(f"{name}.{error.name}", error.value, error.accepted, error.remedy) from None
