"""The stepped bar: sections of different cross-section or material, joined end to end."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import ClassVar

import numpy as np

from percuss.errors import ParameterError
from percuss.model.body.body import Body, ComplexShape, Shape
from percuss.model.body.chain import Chain, Numbers, chain
from percuss.model.body.chain_receptance import elastic_receptance
from percuss.model.body.damping import MOST_DAMPING, UNDAMPED, Damping
from percuss.model.body.prufer_angle import Waves, waves
from percuss.model.body.uniform import LEAST_S, MOST_S
from percuss.model.checks import Array, ComplexArray, instance, numbers, positive

__all__ = ["MOST_SECTIONS", "SteppedBar"]

MOST_SECTIONS = 200
"""Sections of a bar: far more than a machine's, and few enough for thousands of modes in a second."""

MOST_JUMP = 1e6
"""Impedances of two neighbours that differ by more are a slip of units, not a bar."""

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
    impedances
        Z_i = A_i √(E_i ρ_i) of the sections from the driven end to the striking end, in any one unit; 1 to 200.
    transit_times
        Times of a wave through them, in any one unit.
    damping
        The law of damping.
    lengths
        Their lengths, in any one unit, which say where x is. Without them x runs with the transit time.

    Raises
    ------
    ParameterError
        For values out of range, or numbers of sections that differ.

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
        object.__setattr__(self, "s", positive("s", self.s))
        if not LEAST_S <= self.s <= MOST_S:
            raise ParameterError("s", self.s, f"a wave speed from {LEAST_S:g} to {MOST_S:g} bar lengths per radian")
        if instance("damping", self.damping, Damping).rigid > MOST_DAMPING:
            raise ParameterError("d", self.damping.rigid, f"a damping of at most {MOST_DAMPING:g}")
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
    def sections(self) -> Chain:
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

    def _waves(self, count: int) -> Waves:
        """Of `count` modes and some more: the number is rounded up, so that few tables serve all questions."""
        return waves(self.impedances, self.transit_times, self.s, max(_LEAST_KEPT, 1 << (count - 1).bit_length()))

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


def _bending(bar: Chain, x: Array) -> tuple[Array, Array, Array]:
    """∫_0^x m²/EA, ∫_0^x m(1 − m)/EA and ∫_x^1 (1 − m)²/EA, m the mass from the driven end on; shapes like x."""
    section, time = bar.locate(x)
    edges = np.arange(bar.size)
    whole = _pieces(bar, edges, np.zeros(bar.size), bar.transit)
    first, second = _pieces(bar, section, np.zeros_like(time), time)[:2]
    third = _pieces(bar, section, time, bar.transit[section])[2]
    behind = [np.append(0.0, np.cumsum(values)) for values in whole[:2]]
    ahead = np.append(np.cumsum(whole[2][::-1])[::-1], 0.0)
    return behind[0][section] + first, behind[1][section] + second, ahead[section + 1] + third


def _pieces(bar: Chain, section: Numbers, start: Array, end: Array) -> tuple[Array, Array, Array]:
    """The three integrals over parts of sections, whose forces are linear along them."""
    (m, n), (mm, nn) = bar.masses(section, start), bar.masses(section, end)
    share = (end - start) / bar.impedance[section]
    squares = share * (m * m + m * mm + mm * mm) / 3.0, share * (n * n + n * nn + nn * nn) / 3.0
    return squares[0], share * (2.0 * m * n + m * nn + mm * n + 2.0 * mm * nn) / 6.0, squares[1]
