"""The system: bar, load and contact joined and made dimensionless, with the scales back to SI."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from percuss.errors import ParameterError
from percuss.model.bar import Bar
from percuss.model.checks import finite, instance, non_negative, positive, unit_interval
from percuss.model.contact import Contact
from percuss.model.load import Load
from percuss.shown import Shown

__all__ = ["System"]

# Far beyond any bar: outside them the squares of the frequencies leave the range of double precision
LEAST_S, MOST_S, MOST_D, MOST_LOAD = 1e-4, 1e9, 1e6, 1e100


@dataclass(frozen=True)
class System(Shown):
    """A striking bar in the dimensionless form of B77 (3, 4): u_tt + d u_t − s² u_xx = 0, −s² u_x(0, t) = p(t).

    Researchers make one from s, d, R and a dimensionless load; engineers with `System.from_si`.

    Parameters
    ----------
    s
        Wave speed C/(LΩ), dimensionless, greater than 0.
    d
        Damping D/(MΩ), dimensionless, 0 or greater.
    restitution
        Coefficient of restitution R, 0 to 1.
    load
        The dimensionless load P/(M L² Ω²).
    bar, frequency
        The bar and the frequency (Hz) of the load's fundamental behind an SI system, or None.

    Raises
    ------
    ParameterError
        For values out of range, or a load in newtons.

    Examples
    --------
    >>> system = System(s=20.0, d=0.0048, restitution=0.6, load=Load.harmonic(0.9, 1.0))
    >>> print(system)
    System: s = 20, d = 0.0048, R = 0.6; mean 0.9, 1 harmonic, load factor 0.9
    """

    s: float
    d: float
    restitution: float
    load: Load
    bar: Bar | None = None
    frequency: float | None = None

    def __post_init__(self) -> None:
        set_ = object.__setattr__
        set_(self, "s", positive("s", self.s))
        set_(self, "d", non_negative("d", self.d))
        if not LEAST_S <= self.s <= MOST_S:
            raise ParameterError("s", self.s, f"a wave speed from {LEAST_S:g} to {MOST_S:g} bar lengths per radian")
        if self.d > MOST_D:
            raise ParameterError("d", self.d, f"a damping of at most {MOST_D:g}")
        set_(self, "restitution", unit_interval("restitution", self.restitution))
        if not isinstance(self.load, Load):
            raise ParameterError("load", self.load, "a Load")
        greatest = float(abs(self.load.coefficients).max())
        if not greatest <= MOST_LOAD:
            raise ParameterError("load", greatest, f"coefficients of at most {MOST_LOAD:g}")
        if self.load.frequency is not None:
            raise ParameterError(
                "load", str(self.load), "a dimensionless load", "use System.from_si for a load in newtons"
            )
        if self.bar is not None:
            instance("bar", self.bar, Bar)
        if (self.bar is None) != (self.frequency is None):
            raise ParameterError("bar", self.bar, "a bar and a frequency together, or neither")
        if self.frequency is not None:
            set_(self, "frequency", positive("frequency", self.frequency))

    @classmethod
    def from_si(cls, bar: Bar, load: Load, contact: Contact) -> System:
        """The system of a bar, a load in newtons with its frequency, and a contact.

        Raises
        ------
        ParameterError
            When the load has no frequency.
        """
        instance("bar", bar, Bar), instance("load", load, Load), instance("contact", contact, Contact)
        if load.frequency is None:
            raise ParameterError("frequency", None, "a frequency in Hz greater than 0")
        omega = 2.0 * math.pi * load.frequency
        force_scale = bar.mass_per_length * bar.length**2 * omega**2
        return cls(
            s=bar.wave_speed / (bar.length * omega),
            d=bar.damping / (bar.mass_per_length * omega),
            restitution=contact.restitution,
            load=load.scaled(1.0 / force_scale),
            bar=bar,
            frequency=load.frequency,
        )

    # -- scales --

    @property
    def is_si(self) -> bool:
        """Whether the scales back to SI are known."""
        return self.bar is not None

    def _si(self) -> tuple[Bar, float]:
        if self.bar is None or self.frequency is None:
            raise ParameterError("system", "dimensionless", "a system made from SI", "use System.from_si")
        return self.bar, 2.0 * math.pi * self.frequency

    @property
    def angular_frequency(self) -> float:
        """Ω in rad/s."""
        return self._si()[1]

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
        """M L² Ω² in N."""
        bar, omega = self._si()
        return bar.mass_per_length * (bar.length * omega) ** 2

    @property
    def energy_scale(self) -> float:
        """M L³ Ω² in J."""
        return self.force_scale * self.length_scale

    @property
    def power_scale(self) -> float:
        """M L³ Ω³ in W."""
        return self.energy_scale * self.angular_frequency

    @property
    def stress_scale(self) -> float:
        """E in Pa: stress is E times the strain u_x."""
        return self._si()[0].youngs_modulus

    # -- neighbours --

    def with_restitution(self, restitution: float) -> System:
        """The same system with another coefficient of restitution."""
        return replace(self, restitution=restitution)

    def with_load_factor(self, load_factor: float) -> System:
        """The same alternating load about the mean that makes p_0/p_k equal to `load_factor`.

        Raises
        ------
        ParameterError
            When the load is constant.
        """
        present = self.load.harmonics
        if not present.size:
            raise ParameterError("load", str(self.load), "a load with an alternating part")
        mean = finite("load_factor", load_factor) * abs(complex(self.load.coefficients[present[0]]))
        return replace(self, load=self.load.with_mean(mean))

    def __str__(self) -> str:
        text = (
            f"System: s = {self.s:.6g}, d = {self.d:.6g}, R = {self.restitution:.6g}; "
            f"{str(self.load).removeprefix('Load: ')}"
        )
        return text if self.bar is None else f"{text}; {self.frequency:.4g} Hz; {self.bar}"
