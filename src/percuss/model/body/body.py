"""What a body is: everything that the mechanics may ask of a bar, and nothing of how it is asked."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any, ClassVar, NamedTuple, TypeVar, cast

import numpy as np
import numpy.typing as npt

from percuss.errors import ParameterError
from percuss.model.body.damping import Damping, Lossless
from percuss.model.checks import Array, ComplexArray, count
from percuss.model.parameter import Parameter, of_field

# ---- What a body says of its elastic modes: frequencies, dampings and shapes


class Shape(NamedTuple):
    """Displacement along the bar and its slope, the strain u_x; equal shapes, dimensionless."""

    displacement: Array
    strain: Array


class ComplexShape(NamedTuple):
    """As `Shape`, of a harmonic motion: complex amplitudes."""

    displacement: ComplexArray
    strain: ComplexArray


@dataclass(frozen=True)
class Modes:
    """The elastic modes n = 1 … N of a free body under a load at one place; every array of shape (N,), dimensionless.

    Mode n moves as u = z_n(t) φ_n(x) φ_n(x_p), z_n'' + d_n z_n' + ω_n² z_n = p(t): B77's u_n. φ_n is scaled so that its
    modal mass is the mass of the body, 1.

    Parameters
    ----------
    omega, damping
        Undamped frequencies ω_n, increasing, per radian of the load, and d_n.
    inertia
        1/φ_n(1)²: the mass that the mode has at the striking end (uniform bar: 1/2). Never 0.
    at_load
        φ_n(x_p)/φ_n(1): the mode at the load, where the striking end moves by 1 (uniform bar, driven end: (−1)ⁿ).
    """

    omega: Array
    damping: Array
    inertia: Array
    at_load: Array

    @property
    def gamma(self) -> Array:
        """γ_n = φ_n(x_p) φ_n(1): z_n moves the striking end by γ_n z_n (uniform bar, driven end: 2(−1)ⁿ)."""
        return self.at_load / self.inertia

    @property
    def weight(self) -> Array:
        """φ_n(x_p)²: the kinetic energy is ½ Σ weight z_n'², the load's power p Σ weight z_n' (uniform bar: 2)."""
        return self.at_load**2 / self.inertia

    @property
    def end(self) -> Array:
        """|φ_n(1)|, at the striking end (uniform bar: √2)."""
        return 1.0 / np.sqrt(self.inertia)

    @property
    def size(self) -> int:
        """N."""
        return self.omega.size

    @property
    def is_damped(self) -> bool:
        """Whether every mode loses energy."""
        return bool(np.all(self.damping > 0.0))

    def stiffness(self, k: Array) -> ComplexArray:
        """ω_n² + ik d_n − k², shape (N, K): what divides the harmonics k of the load."""
        return np.asarray((self.omega**2)[:, None] + 1j * np.outer(self.damping, k) - (k**2)[None, :])

    def first(self, count: int) -> Modes:
        """The first `count` of them; itself when it has no more."""
        if count >= self.size:
            return self
        return Modes(self.omega[:count], self.damping[:count], self.inertia[:count], self.at_load[:count])


# ---- What a body is: everything that the mechanics may ask of a bar, and nothing of how it is asked

Kind = TypeVar("Kind", bound="Body")

_DIFFERENCES = 4096
"""Modes in which a damped bar differs from the lossless one that stands for it; those above differ like 1/n³."""

_AT_ONCE = 1 << 20  # modes × harmonics
_RESONANT = 1e-12
_BESIDE = 1e-9  # how far from the ends of a bar it is looked at for masses at them
IntArray = npt.NDArray[np.int64]

_KEPT = 1 << 16  # modes of the tables that are kept


class Body(ABC):
    """A free elastic bar in dimensionless form: length 1, mass 1, the time in radians of the load's fundamental.

    The load works at a place x_p, mostly the driven end x = 0; the striking end is x = 1. A body is a frozen dataclass
    that can be hashed, with the law of its `damping` as a field. To write one, write

    - `kind`: its word, by which `percuss.model.body.BODIES` must name it to be read back from JSON and archives,
    - `s`: one over the time of a wave from end to end, a field or a property,
    - `frequencies(count)`: ω_1 … ω_N of the free, undamped bar, none missed, however many are asked for,
    - `inertia(count)` and `shapes(x, count)`: its modes,
    - `static_shape(x, source)`: what a constant force bends, inertia relieved,
    - `frequency_floor(n)` and `coupling_bound`: bounds of all modes that nobody computes.

    Everything else follows: steady motions, stability, simulation, sweeps and pictures ask for no more. Some things may
    be written besides: `lossless_receptance` and `held_transfer`, where all modes together have a closed form, and
    `mass_before`, for speed and digits; `places`, where a load may act elsewhere than at the driven end; and
    `parameters`, what maps vary.

    Examples
    --------
    >>> from percuss.model.body import Ratio, UniformBar
    >>> bar = UniformBar(s=20.0, damping=Ratio(1e-3))
    >>> bar.modes(2).omega.round(3).tolist(), bar.modes(2).gamma.tolist()
    ([62.832, 125.664], [-2.0, 2.0])
    """

    kind: ClassVar[str]
    """Its word in JSON."""

    is_free: ClassVar[bool] = True
    """Whether nothing holds it, so that it moves as a whole, too; else it is a `HeldBody`."""

    parameters: ClassVar[tuple[Parameter[Any], ...]] = (
        of_field("s", "wave speed s", "one over the time of a wave from end to end, C/(LΩ) of a uniform bar"),
    )
    """Its own numbers that maps and sliders may vary, beside that of its damping: s, where that is a field."""

    s: float
    """Wave speed: 1/(time of a wave from one end to the other), in bar lengths per radian of the load."""

    damping: Damping
    """The law of its damping."""

    gap: float = 0.0
    """Distance from the contact to the wall without any force; a free body has none."""

    # -- to be written --

    @abstractmethod
    def frequencies(self, count: int) -> Array:
        """Undamped ω_n, n = 1 … `count`, increasing; shape (count,)."""

    @abstractmethod
    def inertia(self, count: int) -> Array:
        """1/φ_n(1)², n = 1 … `count`; shape (count,)."""

    @abstractmethod
    def shapes(self, x: Array, count: int) -> Shape:
        """φ_n(x)/φ_n(1) and its slope for n = 1 … `count`; each of shape (len(x), count)."""

    @abstractmethod
    def static_shape(self, x: Array, source: float = 0.0) -> Shape:
        """The elastic modes, all together, under a constant unit force at x = `source`; each of shape (len(x),).

        Σ_{n≥1} φ_n(x) φ_n(source)/ω_n²: the bar in uniform acceleration, the displacement of its centre of mass taken
        off. Where x is the source, the strain is that on the striking end's side.
        """

    @abstractmethod
    def frequency_floor(self, n: int) -> float:
        """A number f with ω_{n+j} ≥ f + jπs for every j ≥ 0; greater than 0 from n = 128 on."""

    @property
    @abstractmethod
    def coupling_bound(self) -> float:
        """A bound of |φ_n(x) φ_n(y)| for every mode and any two places (uniform bar: 2)."""

    # -- may be written --

    def dampings(self, count: int) -> Array:
        """d_n, n = 1 … `count`: by default what the law of damping says; shape (count,)."""
        return self.damping.of(self.frequencies(count))

    @property
    def places(self) -> tuple[float, ...]:
        """Where a load may act, by number: the driven end is 0."""
        return (0.0,)

    def lossless_receptance(self, z: ComplexArray, x: Array, source: float = 0.0) -> ComplexShape:
        """Σ_{n≥1} φ_n(x) φ_n(source)/(ω_n² − z²), and its slope; each of shape (K, len(x)).

        By default the sum of the modes that differ, with the static shape in place of all others. That costs digits
        where z is beyond the frequencies summed; bodies with a closed form write it here. `z`: complex frequencies,
        Im z ≤ 0, shape (K,).
        """
        n = _DIFFERENCES
        omega, shapes, static = self.frequencies(n), self.shapes(x, n), self.static_shape(x, source)
        at = self.shapes(np.array([source]), n).displacement[0] / self.inertia(n)
        more = at * (1.0 / (omega**2 - z[:, None] ** 2) - 1.0 / omega**2)
        return ComplexShape(
            np.asarray(more @ shapes.displacement.T + static.displacement),
            np.asarray(more @ shapes.strain.T + static.strain),
        )

    def mass_before(self, x: Array) -> Array:
        """Mass from the driven end to the places x, 0 to 1; shape (len(x),).

        A point mass at the driven end is before all places, one at the striking end before none. By default from the
        static shape: a force at a place drives the masses before and after it by the forces on its two sides, and so by
        the strains there.
        """
        found = []
        for place in np.clip(x, _BESIDE, 1.0 - _BESIDE).tolist():
            before, after = self.static_shape(np.array([np.nextafter(place, 0.0), place]), place).strain.tolist()
            found.append(before / (before - after))
        return np.array(found)

    # -- everything else follows --

    @property
    def rigid_drag(self) -> float:
        """d_0, the damping of the motion as a whole; 0 for a body that is held."""
        return self.damping.rigid if self.is_free else 0.0

    def kept(self, modes: int) -> int:
        """How many of so many modes it has: all of them, unless a table ends before."""
        return modes

    def chosen(self, modes: int) -> int:
        """The same where so many are asked for; ParameterError for none of a body that is held."""
        return self.kept(modes)

    @property
    def transit_time(self) -> float:
        """Time of a wave from one end to the other, 1/s."""
        return 1.0 / self.s

    def damped_by(self: Kind, damping: Damping) -> Kind:
        """The same body with another law of damping."""
        return cast("Kind", replace(cast("Any", self), damping=damping))

    def place(self, number: int) -> float:
        """x of the place with a number; ParameterError when the body has no such place."""
        if count("at", number, least=0) >= len(self.places):
            most = len(self.places) - 1
            wanted = f"a step of the bar, 0 (the driven end) to {most}" if most else "0: this bar has no steps"
            raise ParameterError("at", number, wanted)
        return self.places[number]

    def modes(self, count: int, at: int = 0) -> Modes:
        """The elastic modes 1 … `count` under a load at the place number `at`. Not to be written into."""
        return (_known_modes if count <= _KEPT else _modes)(self, count, at)

    def driven_shapes(self, x: Array, count: int, at: int = 0) -> Shape:
        """φ_n(x) φ_n(x_p) and its slope: the motion u_n (B77) makes at x; each of shape (len(x), count)."""
        gamma, shapes = self.modes(count, at).gamma, self.shapes(x, count)
        return Shape(shapes.displacement * gamma, shapes.strain * gamma)

    def static(self, x: Array, at: int = 0, count: int | None = None) -> Shape:
        """`static_shape` for a load at a place, of all modes or of the first ones; each of shape (len(x),)."""
        if count is None:
            return self.static_shape(x, self.place(at))
        rows, flexibility = self.driven_shapes(x, count, at), 1.0 / self.modes(count, at).omega ** 2
        return Shape(rows.displacement @ flexibility, rows.strain @ flexibility)

    def receptance(self, k: Array, x: Array, at: int = 0, count: int | None = None) -> ComplexShape:
        """g_k(x) = Σ_n φ_n(x) φ_n(x_p)/(ω_n² + ik d_n − k²) of the elastic modes, and its slope; shapes (K, len(x)).

        All modes, in closed form where body and damping have one, or the first `count`. `k`: numbers of harmonics,
        shape (K,), greater than 0.
        """
        x = np.asarray(x, dtype=float)
        if count is not None:
            rows, gains = self.driven_shapes(x, count, at), 1.0 / self.modes(count, at).stiffness(k)
            return ComplexShape((rows.displacement @ gains).T, (rows.strain @ gains).T)
        bar = self.damping.lossless(k)
        factor = bar.factor[:, None]
        whole = self.lossless_receptance(bar.z, x, self.place(at))
        if bar.exact:
            return ComplexShape(factor * whole.displacement, factor * whole.strain)
        rows = self.driven_shapes(x, _DIFFERENCES, at)
        off = self._off_lossless(k, bar, np.concatenate([rows.displacement, rows.strain]))
        count = x.size
        return ComplexShape(factor * whole.displacement + off[:, :count], factor * whole.strain + off[:, count:])

    def _off_lossless(self, k: Array, bar: Lossless, rows: Array) -> ComplexArray:
        """What the damped modes add to the lossless bar that stands for them: Σ rows[i, n] times it; shape (K, i)."""
        modes = self.modes(rows.shape[1])
        found = np.empty((k.size, rows.shape[0]), dtype=complex)
        width = max(1, _AT_ONCE // modes.size)
        for i in range(0, k.size, width):  # else thousands of harmonics would fill the memory
            part = slice(i, i + width)
            square = (modes.omega**2)[:, None]
            off = 1.0 / modes.stiffness(k[part]) - bar.factor[part] / (square - bar.z[part] ** 2)
            found[part] = (rows @ off).T
        return found

    def striking_receptance(self, k: Array) -> ComplexArray:
        """Σ_{n≥1} φ_n(1)²/(ω_n² + ik d_n − k²): force and motion at the striking end; shape (K,)."""
        bar, end = self.damping.lossless(k), np.array([1.0])
        whole = bar.factor * self.lossless_receptance(bar.z, end, 1.0).displacement[:, 0]
        if bar.exact:
            return np.asarray(whole)
        return np.asarray(whole + self._off_lossless(k, bar, 1.0 / self.modes(_DIFFERENCES).inertia[None, :])[:, 0])

    def held_transfer(self, k: Array, at: int = 0) -> ComplexArray:
        """Force at the wall per harmonic of the load while the striking end is held; inf in resonance; shape (K,).

        The receptances from the load to the striking end and of that end itself, the rigid motion with them.
        """
        rigid = -1.0 / (k * (k - 1j * self.rigid_drag))
        own = self.striking_receptance(k)
        there = rigid + self.receptance(k, np.array([1.0]), at).displacement[:, 0]
        resonant = np.abs(rigid + own) <= _RESONANT * (np.abs(rigid) + np.abs(own))
        return np.where(resonant, np.inf, there / np.where(resonant, 1.0, rigid + own))

    @property
    def is_harmonic(self) -> bool:
        """Whether no wave is sent back inside it, as in a uniform bar: every frequency is n times the first one."""
        return self.is_uniform

    @property
    def is_uniform(self) -> bool:
        """Whether mass and stiffness are spread evenly along x, as in a bar of one section."""
        return False

    def frequency(self, n: IntArray) -> Array:
        """ω_n of the modes with the numbers n ≥ 1; the shape of `n`."""
        return np.asarray(self.frequencies(int(n.max(initial=1)))[n - 1])

    def nearest(self, omega: npt.ArrayLike) -> IntArray:
        """Numbers n ≥ 1 of the elastic modes whose frequencies are nearest to `omega`; the shape of it."""
        wanted = np.asarray(omega, dtype=float)
        count = max(2, int(wanted.max(initial=0.0) / (np.pi * self.s)) + 2)
        while (found := self.frequencies(count))[-1] <= wanted.max(initial=0.0):
            count *= 2
        right = np.maximum(np.searchsorted(found, wanted), 1)
        return np.asarray(right + (found[right] - wanted < wanted - found[right - 1]))


def _modes(body: Body, count: int, at: int) -> Modes:
    omega, inertia = body.frequencies(count), body.inertia(count)
    at_load = body.shapes(np.array([body.place(at)]), count).displacement[0]
    found = Modes(omega, body.dampings(count), inertia, at_load)
    for values in (found.omega, found.damping, found.inertia, found.at_load):
        values.setflags(write=False)
    return found


_known_modes = lru_cache(maxsize=32)(_modes)


# ---- Bodies that something holds: structures with one gap, which move by their modes alone
#
# Such a body has no rigid motion. Its modes n = 1 … N are q_n'' + d_n q_n' + ω_n² q_n = b_n p(t), and the gap function
# is y = Σ a_n q_n − g ≤ 0, with a_n the mode at the contact, b_n the mode at the load (modal mass 1) and g the gap. In
# the words of `Modes`: 1/inertia = a_n², at_load = b_n/a_n, so that γ_n = a_n b_n and q_n = b_n z_n.

MOST_GAP = 1e12  # far beyond any gap: displacements keep some digits of an impact


class HeldBody(Body):
    """A structure that something holds, with a wall at a gap before its contact; `Body` says what to write.

    Besides, `most_modes` and `gap`; static shapes and bounds of modes that nobody computes mean nothing here: all are
    computed.
    """

    is_free: ClassVar[bool] = False

    @property
    @abstractmethod
    def most_modes(self) -> int:
        """How many modes it has, or as many as are taken unless more are asked for."""

    def chosen(self, modes: int | None) -> int:
        """As of any body; None for `most_modes`."""
        if modes == 0:
            raise ParameterError("modes", 0, "1 or more: a body that is held has no rigid motion beside its modes")
        return self.most_modes if modes is None else self.kept(modes)

    def flexibility(self, modes: int, at: int = 0) -> float:
        """Displacement of the contact under a constant unit force at the load, of the first modes."""
        known = self.modes(modes, at)
        return float(np.sum(known.gamma / known.omega**2))

    def bent(self, modes: int, at: int = 0) -> Array:
        """The modes z_n of the shape in which a force at the contact bends it, the contact moved by 1; shape (N,).

        A mode that the load does not drive has no share in it.
        """
        known = self.modes(modes, at)
        share = 1.0 / (known.inertia * known.omega**2)
        driven = known.gamma != 0.0
        return np.where(driven, share / np.where(driven, known.gamma, 1.0), 0.0) / float(share[driven].sum())

    def static_shape(self, x: Array, source: float = 0.0) -> Shape:
        n = self.most_modes
        shapes = self.shapes(np.asarray(x, dtype=float), n)
        from_source = self.shapes(np.array([source]), n).displacement[0] / self.inertia(n) / self.frequencies(n) ** 2
        return Shape(shapes.displacement @ from_source, shapes.strain @ from_source)

    def frequency_floor(self, n: int) -> float:
        raise _of_bars("a bound of its higher modes")

    @property
    def coupling_bound(self) -> float:
        raise _of_bars("a bound of its higher modes")

    def mass_before(self, x: Array) -> Array:
        raise _of_bars("the mass along it")

    def nearest(self, omega: Array) -> IntArray:  # type: ignore[override]
        known = self.frequencies(self.most_modes)
        return np.asarray(1 + np.argmin(np.abs(known[None, :] - np.asarray(omega, dtype=float)[..., None]), axis=-1))

    @property
    def is_harmonic(self) -> bool:
        return False


def need_free(body: Body, what: str) -> None:
    """Refuse a body that is held where the answer is one of bars that move as a whole.

    ParameterError with what was asked for.
    """
    if not body.is_free:
        raise _of_bars(what)


def _of_bars(what: str) -> ParameterError:
    return ParameterError("body", "held by a spring or a structure", f"a free bar for {what}")
