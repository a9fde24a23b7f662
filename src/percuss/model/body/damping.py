"""How a body loses energy between impacts: one law for all its modes, the same laws for every kind of body."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

import numpy as np

from percuss.errors import ParameterError
from percuss.model.checks import Array, ComplexArray, instance, non_negative, numbers
from percuss.model.parameter import Parameter, of_field

MOST_DAMPING = 1e6  # far beyond any bar, in radians of the load

_SOME_LOSS = (1.0 - 0.02j) ** 0.5  # keeps a lossless bar that stands for a table of dampings off its resonances


class Lossless(NamedTuple):
    """The lossless bar that answers a harmonic alike: ω_n² + ik d_n − k² = (ω_n² − z²)/factor; `exact`: all n."""

    z: ComplexArray
    factor: ComplexArray
    exact: bool


class Damping(ABC):
    """A law of damping: d_n in u_n'' + d_n u_n' + ω_n² u_n = p for every elastic mode, and d_0 of the rigid motion.

    To write a law, write its words, `of` and `lossless`, `per_radian` where its numbers have units, and `rigid` where
    the law drags the whole bar. A number of it that maps and sliders may vary is named in `parameter`. Everything else
    follows: bodies ask for nothing more.
    """

    kind: ClassVar[str]
    """Its word in case files and JSON."""

    sentence: ClassVar[str]
    """What it does to the bar, for a report."""

    parameter: ClassVar[Parameter[Any] | None] = None
    """The one number that says how strong it is; None for a law that has no such number."""

    @abstractmethod
    def of(self, omega: Array) -> Array:
        """d_n of modes with the undamped frequencies ω_n, n = 1, 2, …; the same shape, dimensionless."""

    @abstractmethod
    def lossless(self, k: Array) -> Lossless:
        """The lossless bar that answers the harmonics k, shape (K,), as the damped one does (shared by all modes)."""

    @abstractmethod
    def per_radian(self, angular_frequency: float) -> Damping:
        """The same law with the time in radians of the load, from one with the time in seconds; Ω in rad/s."""

    @property
    def rigid(self) -> float:
        """d_0, the drag on the motion of the bar as a whole, dimensionless."""
        return 0.0

    @property
    @abstractmethod
    def is_zero(self) -> bool:
        """Whether no mode loses anything."""

    @property
    def is_even(self) -> bool:
        """Whether every mode, the rigid motion too, has the same d, as if waves in the bar just faded on their way."""
        return self.is_zero

    @property
    def words(self) -> str:
        """What it is, and what it does to the bar, for a report."""
        return "none" if self.is_zero else f"{self}: {self.sentence}"


def _limited(name: str, value: object) -> float:
    found = non_negative(name, value)
    if found > MOST_DAMPING:
        raise ParameterError(name, found, f"a damping of at most {MOST_DAMPING:g}")
    return found


def check_damping(damping: object) -> None:
    """Refuse what is no law of damping of a bar, and a drag beyond any bar's."""
    drag = instance("damping", damping, Damping).rigid
    if drag > MOST_DAMPING:
        raise ParameterError("d", drag, f"a damping of at most {MOST_DAMPING:g}")


def share_of_critical(name: str, value: object) -> float:
    """`value` as a share of critical damping."""
    found = non_negative(name, value)
    if found > 1.0:
        raise ParameterError(name, found, "a share of critical damping, 0 to 1 (steel: about 0.001)")
    return found


@dataclass(frozen=True)
class External(Damping):
    """B77's d: the same for every mode, the rigid one too, as of a viscous medium around the bar (B77 3).

    d = D/(MΩ), dimensionless; in SI, D/M in 1/s.
    """

    kind: ClassVar[str] = "external"
    sentence: ClassVar[str] = "every motion is braked alike, that of the bar as a whole, too (B77)"
    parameter: ClassVar[Parameter[Any]] = of_field("d", "damping d", "damping d = D/(MΩ)", (0.0, 0.1))
    d: float = 0.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "d", non_negative("d", self.d))

    def of(self, omega: Array) -> Array:
        return np.full(np.shape(omega), self.d)

    def lossless(self, k: Array) -> Lossless:
        return Lossless(np.asarray(np.sqrt(k * (k - 1j * self.d)), dtype=complex), np.ones(k.shape, complex), True)

    def per_radian(self, angular_frequency: float) -> External:
        return External(self.d / angular_frequency)

    @property
    def rigid(self) -> float:
        return self.d

    @property
    def is_zero(self) -> bool:
        return self.d == 0.0

    @property
    def is_even(self) -> bool:
        return True

    def __str__(self) -> str:
        return f"d = {self.d:.6g}"


UNDAMPED = External(0.0)
"""No damping at all."""


@dataclass(frozen=True)
class Ratio(Damping):
    """The same share ζ of critical damping, 0 to 1, for every elastic mode, d_n = 2ζω_n; the rigid motion is free."""

    kind: ClassVar[str] = "ratio"
    sentence: ClassVar[str] = (
        "the same share of critical damping in every elastic mode; the bar as a whole moves freely"
    )
    parameter: ClassVar[Parameter[Any]] = of_field(
        "damping_ratio", "damping ratio ζ", "share ζ of critical damping of every elastic mode", (0.0, 0.01), "ratio"
    )
    ratio: float = 0.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "ratio", share_of_critical("ratio", self.ratio))

    def of(self, omega: Array) -> Array:
        return np.asarray(2.0 * self.ratio * omega)

    def lossless(self, k: Array) -> Lossless:
        z = k * np.sqrt(1.0 - 2.0j * self.ratio)  # the modes in resonance, ω_n = k, are met exactly
        return Lossless(np.asarray(z, dtype=complex), np.ones(k.shape, complex), self.ratio == 0.0)

    def per_radian(self, angular_frequency: float) -> Ratio:
        return self

    @property
    def is_zero(self) -> bool:
        return self.ratio == 0.0

    def __str__(self) -> str:
        return f"damping ratio {self.ratio:.6g}"


@dataclass(frozen=True)
class KelvinVoigt(Damping):
    """A material whose stress follows the strain rate too, E(1 + η ∂/∂t): d_n = ηω_n²; the rigid motion is free.

    η is dimensionless (times Ω); in SI, in s.
    """

    kind: ClassVar[str] = "kelvin_voigt"
    sentence: ClassVar[str] = "of the material, as the square of the frequency; the bar as a whole moves freely"
    parameter: ClassVar[Parameter[Any]] = of_field(
        "eta", "material damping η", "η of a Kelvin–Voigt material, d_n = ηω_n²", (0.0, 1e-4)
    )
    eta: float = 0.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "eta", _limited("eta", self.eta))

    def of(self, omega: Array) -> Array:
        return np.asarray(self.eta * omega**2)

    def lossless(self, k: Array) -> Lossless:
        softer = 1.0 + 1j * self.eta * k
        return Lossless(np.asarray(k / np.sqrt(softer), dtype=complex), np.asarray(1.0 / softer), True)

    def per_radian(self, angular_frequency: float) -> KelvinVoigt:
        return KelvinVoigt(self.eta * angular_frequency)

    @property
    def is_zero(self) -> bool:
        return self.eta == 0.0

    def __str__(self) -> str:
        return f"Kelvin–Voigt η = {self.eta:.6g}"


@dataclass(frozen=True)
class Table(Damping):
    """d_n mode by mode, as measured; modes beyond the table have the damping ratio of its last one. No rigid drag.

    `values`: d_1, d_2, …, at least one, dimensionless; in SI, in 1/s.
    """

    kind: ClassVar[str] = "table"
    sentence: ClassVar[str] = "given mode by mode; the bar as a whole moves freely"
    values: tuple[float, ...] = (0.0,)

    def __post_init__(self) -> None:
        found = numbers("values", self.values).reshape(-1).tolist()
        if not found:
            raise ParameterError("values", self.values, "the damping of one mode or more")
        object.__setattr__(self, "values", tuple(non_negative(f"values[{n}]", one) for n, one in enumerate(found)))

    def of(self, omega: Array) -> Array:
        own = np.asarray(self.values)[: omega.size]
        if own.size == omega.size:
            return np.array(own)
        last = own.size - 1
        return np.concatenate([own, own[last] / omega[last] * omega[own.size :]])

    def lossless(self, k: Array) -> Lossless:
        z = k * (1.0 if self.is_zero else _SOME_LOSS)
        return Lossless(np.asarray(z, dtype=complex), np.ones(k.shape, complex), self.is_zero)

    def per_radian(self, angular_frequency: float) -> Table:
        return Table(tuple(value / angular_frequency for value in self.values))

    @property
    def is_zero(self) -> bool:
        return not any(self.values)

    def __str__(self) -> str:
        count = len(self.values)
        return f"damping of {count} mode{'s' if count > 1 else ''} given, the first {self.values[0]:.6g}"
