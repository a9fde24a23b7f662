"""What a contact law is: how the body leaves the wall (B77 10, and others)."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from enum import Enum
from typing import ClassVar, TypeVar

import numpy as np
import numpy.typing as npt

from percuss.errors import ParameterError
from percuss.model.body.body import Body
from percuss.model.checks import Array, numbers, positive, unit_interval

# ---- The coefficient of restitution R, and what else is a function of it alone; of numbers and of arrays

X = TypeVar("X", float, Array)


def impedance_ratio(restitution: X) -> X:
    """(1 − R)/(1 + R): the impedance of a bar over that of the receiving rod from which it rebounds so (B77 10).

    0 of a rigid wall, R = 1; 1 of a rod like the bar, R = 0. It is also half the sum of the velocities before and after
    an impact over half their difference, which is how it comes into the level of B77 (14) and the bounds of B77 (36).

    Examples
    --------
    >>> impedance_ratio(0.6), restitution_of_ratio(0.25)
    (0.25, 0.6)
    """
    return (1.0 - restitution) / (1.0 + restitution)


def restitution_of_ratio(ratio: X) -> X:
    """R of an `impedance_ratio`, the function backwards, which is itself; from 0 to 1 for ratios from 1 to 0."""
    return (1.0 - ratio) / (1.0 + ratio)


def restitutions(values: npt.ArrayLike) -> Array:
    """An array of coefficients of restitution that has been looked at.

    ParameterError when one of them is no number from 0 to 1.
    """
    found = numbers("restitution", values, "numbers from 0 to 1")
    if not (np.all(found >= 0.0) and np.all(found <= 1.0)):
        raise ParameterError("restitution", values, "numbers from 0 to 1")
    return found


# ---- What a contact law is: how the body leaves the wall (B77 10, and others)

Kind = TypeVar("Kind", bound="Contact")


class Result(Enum):
    """Results of the theory that hold for some contact laws only; a law names those that hold for it."""

    LEVEL = "the condition v_f(φ) = c for the impact phase (B77 14)"
    REDUCED = "the reduced criterion of stability (B77 29–32), in the limit of a fast wave"
    FEEDBACK = "the feedback σ of the elastic modes in the reduced criterion (B77 29–31)"
    WAVEFORM = "the criterion of the waveform for the stability (B77 36, 41)"


@dataclass(frozen=True, init=False)
class Contact(ABC):
    """A law of impact that takes no time: each mode's displacement and velocity are multiplied by a number.

    (u_n, u_n') → D (u_n, u_n') with D = diag(α, −R) for the elastic modes; the velocity of the rigid motion turns to
    −R times itself, and its position is such that the striking end stays where it touches. To write a law, write a
    frozen dataclass with `strain_factor`, the words `kind` and `sentence`, what of the theory holds for it
    (`results`), and `check` when it does not fit every body. A law that turns velocities to another multiple of
    themselves than −R writes `velocity_factors`, too, and `restitutions_of`, the same backwards. Everything else
    follows: steady motions, multipliers, simulations and their energy ask for no more. What depends on R is asked of
    the law, by `velocity_factor`, `impulse` and the others below; nothing but the laws knows how it does.

    Parameters
    ----------
    restitution
        Coefficient of restitution R, from 0 to 1 (dimensionless).
    receiving_area, area
        Instead of `restitution`: the cross-sectional areas (m², or any one unit) of a long receiving rod of the
        same material and of the bar; then R = (A_s − A)/(A_s + A) (B77 10).

    Raises
    ------
    ParameterError
        When R is outside [0, 1], the receiving rod is thinner than the bar, or neither form is complete.

    Examples
    --------
    >>> from percuss.model.contact import Kept, Reversed
    >>> Kept(0.6).strain_factor, Reversed(0.6).strain_factor
    (1.0, -0.6)
    """

    kind: ClassVar[str]
    """Its word in case files and JSON, the value of `strain`."""

    law: ClassVar[str] = "b77"
    """The family of laws that it belongs to, in JSON: B77's impact without duration by a coefficient of restitution."""

    sentence: ClassVar[str]
    """What it does to the bar, for a report."""

    results: ClassVar[frozenset[Result]]
    """What of the theory holds for it."""

    elastic_growth: ClassVar[str] = ""
    """What must be said where elastic modes grow under it, or nothing."""

    restitution: float

    def __init__(
        self, restitution: float | None = None, *, receiving_area: float | None = None, area: float | None = None
    ) -> None:
        if restitution is not None and receiving_area is not None:
            raise ParameterError("receiving_area", receiving_area, "either restitution or receiving_area, not both")
        if receiving_area is not None:
            if area is None:
                raise ParameterError("area", area, "the bar's own area beside receiving_area")
            restitution = _of_areas(positive("receiving_area", receiving_area), positive("area", area))
        elif restitution is None:
            raise ParameterError("restitution", None, "a restitution from 0 to 1, or a receiving_area")
        object.__setattr__(self, "restitution", unit_interval("restitution", restitution))

    @property
    @abstractmethod
    def strain_factor(self) -> float:
        """α: what the displacement of every elastic mode, and so the strain, is multiplied by."""

    def check(self, body: Body) -> None:  # noqa: B027  # most laws fit every body
        """Refuse a body that the law does not hold for; ParameterError with the reason and the law to take instead."""

    @property
    def velocity_factor(self) -> float:
        """β, −R for B77's law: what the velocity of every mode is multiplied by."""
        return float(self.velocity_factors(self.restitution))

    @property
    def keeps_strain(self) -> bool:
        """Whether the strain just after an impact is that just before it, α = 1."""
        return self.strain_factor == 1.0

    @property
    def rebounds(self) -> bool:
        """Whether the striking end leaves the wall with a speed, R > 0; else it starts from rest."""
        return self.velocity_factor != 0.0

    @property
    def is_lossless(self) -> bool:
        """Whether an impact takes no energy, as with R = 1."""
        return self.energy_taken(1.0, 0.0) == 0.0 and self.energy_taken(0.0, 1.0) == 0.0

    @property
    def impulse(self) -> float:
        """1 − β, 1 + R for B77's law: the impulse of the wall over the momentum with which the body strikes."""
        return 1.0 - self.velocity_factor

    @property
    def impedance_ratio(self) -> float:
        """(1 + β)/(1 − β): the impedance of a body over that of a receiving rod from which it rebounds so (B77 10)."""
        return float(self.impedance_ratios(self.restitution))

    def velocity_factors(self, restitution: npt.ArrayLike) -> Array:
        """`velocity_factor` of laws of this kind with other restitutions, of any shape."""
        return -np.asarray(restitution, dtype=float)

    def impedance_ratios(self, restitution: npt.ArrayLike) -> Array:
        """`impedance_ratio` of laws of this kind with other restitutions, of any shape."""
        return np.asarray(impedance_ratio(-self.velocity_factors(restitution)))

    def restitutions_of(self, impedance_ratios: npt.ArrayLike) -> Array:
        """`impedance_ratios` backwards; less than 0, more than 1 or NaN where no restitution gives such a ratio."""
        return np.asarray(restitution_of_ratio(np.asarray(impedance_ratios, dtype=float)))

    def strain_factors(self, restitution: npt.ArrayLike) -> Array:
        """`strain_factor` of laws of this kind with other restitutions, of any shape."""
        given = np.asarray(restitution, dtype=float)
        kinds, which = np.unique(given, return_inverse=True)
        found = [self.with_restitution(float(value)).strain_factor for value in kinds]
        return np.array(found, dtype=float)[which].reshape(given.shape)

    @property
    def duration(self) -> float:
        """Time that the contact takes, in radians of the load: none."""
        return 0.0

    def after(self, displacement: Array, velocity: Array) -> tuple[Array, Array]:
        """Displacements and velocities of elastic modes just after an impact, from those just before; any shape."""
        return self.strain_factor * displacement, self.velocity_factor * velocity

    def energy_taken(self, kinetic: float, strain: float) -> float:
        """What an impact takes of the kinetic energy and of the strain energy just before it."""
        return (1.0 - self.velocity_factor**2) * kinetic + (1.0 - self.strain_factor**2) * strain

    def holds(self, result: Result) -> bool:
        """Whether a result of the theory holds for this law."""
        return result in self.results

    def need(self, result: Result) -> None:
        """Refuse to be asked for what does not hold for this law; ParameterError with the reason."""
        if not self.holds(result):
            raise ParameterError(
                "contact",
                self.kind,
                "a contact law that keeps the strain at the impact",
                f"{result.value} is derived for it; take the exact multipliers, which hold for every law",
            )

    def with_restitution(self: Kind, restitution: float) -> Kind:
        """The same law with another coefficient of restitution."""
        return replace(self, restitution=restitution)

    def __str__(self) -> str:
        return f"{type(self).__name__}: restitution R = {self.restitution:.4g}"


def _of_areas(receiving: float, own: float) -> float:
    if receiving < own:
        raise ParameterError(
            "receiving_area",
            receiving,
            f"at least the bar's own area, {own:.4g}",
            "a bar does not rebound from a thinner rod; give a restitution instead",
        )
    return (receiving - own) / (receiving + own)
