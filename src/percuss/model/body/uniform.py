"""The uniform bar of B77: one section, every sum over its modes in closed form."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import ClassVar, NamedTuple

import numpy as np
import numpy.typing as npt

from percuss.errors import ParameterError
from percuss.model.body.body import Body, ComplexShape, IntArray, Shape
from percuss.model.body.damping import UNDAMPED, Damping, External, Ratio, check_damping, share_of_critical
from percuss.model.checks import Array, ComplexArray, count, instance, non_negative, positive
from percuss.short_repr import ShortRepr

# Far beyond any bar: outside them the squares of the frequencies leave the range of double precision
LEAST_S, MOST_S = 1e-4, 1e9


def wave_speed(value: object) -> float:
    """`value` as the dimensionless wave speed s of a bar."""
    found = positive("s", value)
    if not LEAST_S <= found <= MOST_S:
        raise ParameterError("s", found, f"a wave speed from {LEAST_S:g} to {MOST_S:g} bar lengths per radian")
    return found


_RESONANT = 1e-12
_SERIES_BELOW = 0.5  # |q| below which sin q − q is taken from its series


@dataclass(frozen=True)
class UniformBar(Body):
    """A bar of one section (B77 3, 4): u_tt + d u_t − s² u_xx = 0, −s² u_x(0, t) = p(t), u_x(1, t) = 0.

    ω_n = nπs, φ_n = √2 cos nπx; displacements z_n are B77's u_n.

    `s` is the wave speed C/(LΩ) > 0, dimensionless; ParameterError for values out of range.
    """

    kind: ClassVar[str] = "uniform"

    s: float
    damping: Damping = UNDAMPED

    def __post_init__(self) -> None:
        object.__setattr__(self, "s", wave_speed(self.s))
        check_damping(self.damping)

    def frequencies(self, count: int) -> Array:
        return np.asarray(np.pi * self.s * np.arange(1, count + 1), dtype=float)

    def inertia(self, count: int) -> Array:
        return np.full(count, 0.5)

    def shapes(self, x: Array, count: int) -> Shape:
        n = np.pi * np.arange(1, count + 1)
        angles, turned = np.outer(x, n), np.where(np.arange(1, count + 1) % 2, -1.0, 1.0)  # (−1)ⁿ
        return Shape(turned * np.cos(angles), -turned * n * np.sin(angles))

    def static_shape(self, x: Array, source: float = 0.0) -> Shape:
        (near, side), (far, other) = _images(np.asarray(x, dtype=float), source)
        rise = 0.5 * (self._static(near) + self._static(far))
        return Shape(rise, 0.5 * (side * (near - 1.0) + other * (far - 1.0)) / self.s**2)

    def _static(self, x: Array) -> Array:
        return np.asarray((1.0 / 3.0 - x + 0.5 * x**2) / self.s**2)

    def mass_before(self, x: Array) -> Array:
        return np.array(x, dtype=float)

    def frequency_floor(self, n: int) -> float:
        return math.pi * self.s * n

    @property
    def coupling_bound(self) -> float:
        return 2.0

    def lossless_receptance(self, z: ComplexArray, x: Array, source: float = 0.0) -> ComplexShape:
        """(1/s²)[1/q² − cos q(1 − x)/(q sin q)] with q = z/s for a source at x = 0 (theory §4); else by images."""
        q = np.asarray(z / self.s, dtype=complex)
        (near, side), (far, other) = _images(np.asarray(x, dtype=float), source)
        shape, slope = _driven_at_0(self.s, q, near)
        if source == 0.0:
            return ComplexShape(shape, slope)
        second, second_slope = _driven_at_0(self.s, q, far)
        return ComplexShape(0.5 * (shape + second), 0.5 * (side * slope + other * second_slope))

    def held_transfer(self, k: Array, at: int = 0) -> ComplexArray:
        """cos qx_p/cos q (theory §4), for every damping of which one lossless bar stands for all modes."""
        bar = self.damping.lossless(k)
        if not bar.exact:
            return super().held_transfer(k, at)
        q, x = bar.z / self.s, self.place(at)
        there = _decaying(q, 1.0 - x) + _decaying(q, 1.0 + x)
        bottom = _decaying(q, 1.0) ** 2 + 1.0
        resonant = np.abs(bottom) < _RESONANT * np.maximum(1.0, np.abs(q))
        return np.where(resonant, np.inf, there / np.where(resonant, 1.0, bottom))

    @property
    def is_uniform(self) -> bool:
        return True

    def frequency(self, n: IntArray) -> Array:
        return np.asarray(np.pi * self.s * n, dtype=float)

    def nearest(self, omega: npt.ArrayLike) -> IntArray:
        n = np.maximum(np.rint(np.asarray(omega, dtype=float) / (math.pi * self.s)), 1.0)
        return np.asarray(n.astype(np.int64))

    def __str__(self) -> str:
        return f"s = {self.s:.6g}, {self.damping}"


def _decaying(q: ComplexArray, way: float) -> ComplexArray:
    """exp(−iq·way), which for Im q ≤ 0 never grows."""
    return np.asarray(np.exp(-1j * way * q.real - way * np.abs(q.imag)))


def _images(x: Array, source: float) -> tuple[tuple[Array, Array], tuple[Array, Array]]:
    """Two ways of a wave from the source: cos nπx cos nπp = ½ [cos nπ(x − p) + cos nπ(x + p)]; and slopes."""
    apart, back = x - source, 1.0 - (x + source)
    return (np.abs(apart), np.where(apart >= 0.0, 1.0, -1.0)), (1.0 - np.abs(back), np.where(back >= 0.0, 1.0, -1.0))


def _driven_at_0(s: float, wave: ComplexArray, x: Array) -> tuple[ComplexArray, ComplexArray]:
    """g(x) and its slope, all modes, for the wave numbers q; shapes (K, len(x))."""
    q, y = wave[:, None], (1.0 - x)[None, :]
    scale = 1.0 / s**2
    small = np.abs(q) < _SERIES_BELOW
    qs = np.where(small, q, 1.0)
    sine = np.sin(qs)
    top = 2.0 * np.sin(0.5 * qs * y) ** 2 - sinc_deficit(qs)
    near = top / (qs * sine)
    near_slope = -np.sin(qs * y) / sine
    ql = np.where(small, 1.0 - 1.0j, q)  # Im q ≤ 0: factors exp(−iq…) never overflow
    down, up = np.exp(-1j * ql * (1.0 - y)), np.exp(-1j * ql * (1.0 + y))
    bottom = 1.0 - np.exp(-2j * ql)
    far = 1.0 / ql**2 - 1j * (down + up) / (ql * bottom)
    far_slope = -(down - up) / bottom
    shape = np.asarray(scale * np.where(small, near, far), dtype=complex)
    return shape, np.asarray(scale * np.where(small, near_slope, far_slope), dtype=complex)


def sinc_deficit(q: ComplexArray) -> ComplexArray:
    """1 − sin q/q without cancellation near 0, where it is q²/6; any shape."""
    near = np.abs(q) < _SERIES_BELOW
    square, far = np.where(near, q, 0.0) ** 2, np.where(near, 1.0, q)
    total = np.zeros_like(square)
    for j in range(9, 0, -1):
        total = square / (2 * j * (2 * j + 1)) * (1.0 - total)
    return np.asarray(np.where(near, total, 1.0 - np.sin(far) / far))


# ---- A body with its sizes in SI: what joins a dimensionless `Body` to metres, kilograms and pascals


class Piece(NamedTuple):
    """A length of one cross-section and material, SI, from the driven end on; solid where only its area is known."""

    start: float
    end: float
    area: float
    youngs_modulus: float
    density: float
    diameter: float
    bore: float

    @property
    def impedance(self) -> float:
        """A sqrt(E ρ) in N·s/m."""
        return self.area * float(np.sqrt(self.youngs_modulus * self.density))

    @property
    def transit_time(self) -> float:
        """Time of a wave through it, in s."""
        return (self.end - self.start) * float(np.sqrt(self.density / self.youngs_modulus))

    @property
    def mass(self) -> float:
        """In kg."""
        return self.density * self.area * (self.end - self.start)


class SizedBody(ABC):
    """A body in SI units. To write one, write `length`, `damping`, `pieces` and `body`; everything else follows.

    A body with a mass that none of its pieces has, such as a point mass at an end, writes `mass`, too. Its blows cannot
    be resolved by waves (`percuss.blow`), which run through the pieces alone.
    """

    kind: ClassVar[str]
    """Its word in JSON, the same as its dimensionless body's."""

    length: float
    """L in m."""

    damping: Damping
    """The law of its damping, with times in s (`Damping.per_radian`)."""

    @property
    @abstractmethod
    def pieces(self) -> tuple[Piece, ...]:
        """Its sections from the driven end to the striking end."""

    @abstractmethod
    def body(self, angular_frequency: float) -> Body:
        """The dimensionless body under a load whose fundamental has the angular frequency Ω, in rad/s."""

    @property
    def mass(self) -> float:
        """Mass of the whole bar in kg."""
        return sum(piece.mass for piece in self.pieces)

    @property
    def transit_time(self) -> float:
        """Time of a wave from end to end, in s."""
        return sum(piece.transit_time for piece in self.pieces)

    @property
    def wave_speed(self) -> float:
        """Length over transit time, in m/s: C of a uniform bar."""
        return self.length / self.transit_time

    @property
    def contact_duration(self) -> float:
        """Twice the transit time, in s: a wave runs through the bar and back."""
        return 2.0 * self.transit_time

    @property
    def impedance(self) -> float:
        """A sqrt(E ρ) at the striking end, in N·s/m."""
        return self.pieces[-1].impedance

    @property
    def rigid_drag(self) -> float:
        """Force per velocity of the bar as a whole, in N·s/m."""
        return self.damping.rigid * self.mass

    def youngs_modulus_at(self, x: Array) -> Array:
        """Young's modulus in Pa at the places x, from 0 at the driven end to 1; same shape. Stress is E u_x."""
        ends = np.array([piece.end for piece in self.pieces[:-1]]) / self.length
        moduli = np.array([piece.youngs_modulus for piece in self.pieces])
        return np.asarray(moduli[np.searchsorted(ends, x, side="right")])

    def natural_frequencies(self, modes: int) -> Array:
        """Damped natural frequencies λ_n/2π in Hz of the elastic modes 1 … `modes`; 0 for a mode that is overdamped."""
        # any rate would do; with this one the numbers of a bar are of order 1
        rate = 1.0 / self.transit_time if self.transit_time > 0.0 else 1.0
        found = self.body(rate).modes(count("modes", modes, most=1 << 20))
        squares = np.maximum(found.omega**2 - (0.5 * found.damping) ** 2, 0.0)
        return np.asarray(rate * np.sqrt(squares) / (2.0 * np.pi))


class SIScales(ShortRepr, ABC):
    """What has a body with sizes behind it, `bar`, or none: its scales are that body's mass M and length L, and 1/Ω."""

    bar: SizedBody | None

    @abstractmethod
    def _si(self) -> tuple[SizedBody, float]:
        """The body with sizes, and Ω in rad/s; ParameterError without one."""

    @property
    def is_si(self) -> bool:
        """Whether the scales back to SI are known."""
        return self.bar is not None

    @property
    def length_scale(self) -> float:
        """L in m."""
        return self._si()[0].length

    @property
    def time_scale(self) -> float:
        """1/Ω in s."""
        return 1.0 / self._si()[1]

    @property
    def speed_scale(self) -> float:
        """LΩ in m/s."""
        bar, omega = self._si()
        return bar.length * omega

    @property
    def force_scale(self) -> float:
        """M L Ω² in N, M the mass of the whole."""
        bar, omega = self._si()
        return bar.mass * bar.length * omega**2

    @property
    def energy_scale(self) -> float:
        """M L² Ω² in J."""
        return self.force_scale * self.length_scale

    @property
    def power_scale(self) -> float:
        """M L² Ω³ in W."""
        return self.energy_scale * self._si()[1]


# ---- The uniform bar in SI units: a slender elastic rod of one cross-section and one material


@dataclass(frozen=True, init=False)
class Bar(SizedBody):
    """A uniform elastic bar in SI units; steel unless told otherwise.

    Parameters
    ----------
    length, youngs_modulus, density
        L in m, Young's modulus E in Pa, and kg/m³.
    area, diameter
        Cross-sectional area A in m², or the diameter in m of a solid round bar.
    damping, damping_ratio, drag
        A law of damping with its times in s; or ζ, the share of critical damping of every elastic mode
        (dimensionless), for `Ratio(ζ)`; or D, the force per metre of bar and per velocity, in N·s/m², for
        `External(D/M)`.

    Examples
    --------
    >>> bar = Bar(length=0.341, diameter=0.049, damping_ratio=1e-3)
    >>> print(bar)
    Bar: 341 mm × 1886 mm², 5.05 kg, C = 5172 m/s, impedance 7.66e+04 N·s/m, first mode 7584 Hz
    """

    kind: ClassVar[str] = "uniform"

    STEEL_MODULUS: ClassVar[float] = 210e9
    """Young's modulus of steel in Pa, unless told otherwise."""

    length: float
    area: float
    youngs_modulus: float
    density: float
    damping: Damping

    def __init__(
        self,
        length: float,
        area: float | None = None,
        youngs_modulus: float = STEEL_MODULUS,
        density: float = 7850.0,
        damping: Damping | None = None,
        *,
        diameter: float | None = None,
        damping_ratio: float | None = None,
        drag: float | None = None,
    ) -> None:
        set_ = object.__setattr__
        set_(self, "length", positive("length", length))
        set_(self, "youngs_modulus", positive("youngs_modulus", youngs_modulus))
        set_(self, "density", positive("density", density))
        if area is not None and diameter is not None:
            raise ParameterError("diameter", diameter, "either area or diameter, not both")
        if area is None and diameter is None:
            raise ParameterError("area", None, "an area (m²) or a diameter (m) greater than 0")
        round_area = None if diameter is None else math.pi / 4.0 * positive("diameter", diameter) ** 2
        set_(self, "area", positive("area", area if round_area is None else round_area))
        if not 0.0 < self.mass < math.inf:
            raise ParameterError("length", self.length, "sizes and a density that give the bar a finite mass")
        set_(self, "damping", self._law(damping, damping_ratio, drag))

    def _law(self, damping: Damping | None, ratio: float | None, drag: float | None) -> Damping:
        given = {"damping": damping, "damping_ratio": ratio, "drag": drag}
        several = [name for name, value in given.items() if value is not None]
        if len(several) > 1:
            raise ParameterError(several[1], given[several[1]], f"either {several[0]} or {several[1]}, not both")
        if ratio is not None:
            return Ratio(share_of_critical("damping_ratio", ratio))
        if drag is not None:
            return External(non_negative("drag", drag) / self.mass_per_length)
        return UNDAMPED if damping is None else instance("damping", damping, Damping)

    @property
    def pieces(self) -> tuple[Piece, ...]:
        """The one section that it is."""
        diameter = math.sqrt(4.0 / math.pi * self.area)
        return (Piece(0.0, self.length, self.area, self.youngs_modulus, self.density, diameter, 0.0),)

    def body(self, angular_frequency: float) -> UniformBar:
        """The dimensionless bar under a load whose fundamental has the angular frequency Ω, in rad/s."""
        omega = positive("angular_frequency", angular_frequency)
        return UniformBar(self.wave_speed / (self.length * omega), self.damping.per_radian(omega))

    @property
    def mass_per_length(self) -> float:
        """M in kg/m."""
        return self.density * self.area

    @property
    def mass(self) -> float:
        """Mass of the whole bar in kg."""
        return self.mass_per_length * self.length

    @property
    def wave_speed(self) -> float:
        """C = sqrt(EA/M) in m/s."""
        return math.sqrt(self.youngs_modulus / self.density)

    @property
    def impedance(self) -> float:
        """Mechanical impedance A sqrt(E ρ) in N·s/m."""
        return self.area * math.sqrt(self.youngs_modulus * self.density)

    def __str__(self) -> str:
        return (
            f"Bar: {1e3 * self.length:.4g} mm × {1e6 * self.area:.4g} mm², {self.mass:.3g} kg, "
            f"C = {self.wave_speed:.4g} m/s, impedance {self.impedance:.3g} N·s/m, "
            f"first mode {self.natural_frequencies(1)[0]:.4g} Hz"
        )
