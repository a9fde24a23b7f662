"""A structure told by a table of its modes, as a finite-element program or a test in the laboratory gives it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from percuss.errors import ParameterError
from percuss.model.body.body import Body, Shape
from percuss.model.body.damping import Damping, Table
from percuss.model.body.held import MOST_GAP, HeldBody
from percuss.model.body.sized import Piece, SizedBody
from percuss.model.checks import Array, count, finite, non_negative, numbers, positive
from percuss.model.parameter import Parameter, of_field

__all__ = ["GAP", "MOST_MODES", "ModalBody", "SizedModes"]

MOST_MODES = 4096
_LEAST_SHARE = 1e-100  # of the greatest a_n: stands for a mode with a node at the contact

GAP: Parameter[Any] = of_field(
    "gap", "gap g", "distance from the contact to the wall without any force, negative where the wall presses"
)


@dataclass(frozen=True)
class ModalBody(HeldBody):
    """A structure with one gap, told by its modes: y = Σ a_n q_n − g, q_n'' + δ_n q_n' + ω_n² q_n = b_n p(t).

    Parameters
    ----------
    omega
        Frequencies ω_n > 0 per radian of the load; they are put in order.
    delta
        δ_n ≥ 0.
    contact
        a_n, each mode at the contact (modal mass 1).
    drive
        b_n, each mode where the load acts.
    gap
        g, of either sign: the wall presses where it is negative.

    Raises
    ------
    ParameterError
        For columns of unequal lengths, values out of range, or when nothing moves the contact or feels the load.

    Examples
    --------
    >>> from percuss.model import Kept, Load, ModalBody, System
    >>> body = ModalBody(omega=(0.6, 2.3), delta=(0.05, 0.1), contact=(1.0, 0.8), drive=(1.0, -0.5), gap=0.3)
    >>> print(System(body, Load.harmonic(0.2, 1.0), Kept(0.7)))
    System: 2 modes, the first ω = 0.6, gap 0.3, R = 0.7; mean 0.2, 1 harmonic, load factor 0.2
    """

    kind: ClassVar[str] = "modes"
    parameters: ClassVar[tuple[Parameter[Any], ...]] = (GAP,)

    omega: tuple[float, ...]
    delta: tuple[float, ...]
    contact: tuple[float, ...]
    drive: tuple[float, ...]
    gap: float = 0.0

    def __post_init__(self) -> None:
        columns = {name: getattr(self, name) for name in ("omega", "delta", "contact", "drive")}
        rows = checked_modes(columns, 1.0)
        for name, column in zip(columns, zip(*rows, strict=True), strict=True):
            object.__setattr__(self, name, column)
        object.__setattr__(self, "gap", _gap(self.gap))

    @property
    def s(self) -> float:  # type: ignore[override]
        """None: no wave runs through a table of modes."""
        raise ParameterError("s", "a table of modes", "a bar, through which waves run")

    @property
    def damping(self) -> Damping:  # type: ignore[override]
        """The damping of each mode."""
        return Table(self.delta)

    @property
    def transit_time(self) -> float:
        return 0.0

    @property
    def most_modes(self) -> int:
        return len(self.omega)

    def kept(self, modes: int) -> int:
        return min(modes, len(self.omega))

    def frequencies(self, count: int) -> Array:
        return np.array(self.omega[:count])

    def dampings(self, count: int) -> Array:
        return np.array(self.delta[:count])

    def inertia(self, count: int) -> Array:
        return np.asarray(1.0 / self._at_contact(count) ** 2)

    def shapes(self, x: Array, count: int) -> Shape:
        """At the load, x = 0, and at the contact, x = 1; the strain is unknown.

        Raises
        ------
        ParameterError
            For other places.
        """
        places = np.asarray(x, dtype=float)
        if not np.all((places == 0.0) | (places == 1.0)):
            raise ParameterError("x", x, "0 (the load) or 1 (the contact): a table of modes knows no other place")
        at_contact = self._at_contact(count)
        rows = np.where(places[:, None] == 0.0, np.array(self.drive[:count]) / at_contact, np.ones_like(at_contact))
        return Shape(rows, np.full(rows.shape, np.nan))

    def _at_contact(self, count: int) -> Array:
        """a_n, and next to nothing where it is 0."""
        found = np.array(self.contact)
        return np.where(found == 0.0, _LEAST_SHARE * np.abs(found).max(), found)[:count]

    def __str__(self) -> str:
        n = len(self.omega)
        return f"{n} mode{'s' if n > 1 else ''}, the first ω = {self.omega[0]:.6g}, gap {self.gap:.6g}"


def _gap(value: object) -> float:
    found = finite("gap", value)
    if abs(found) > MOST_GAP:
        raise ParameterError("gap", found, f"a gap between -{MOST_GAP:g} and {MOST_GAP:g}")
    return found


def checked_modes(columns: dict[str, Any], unit: float) -> list[tuple[float, float, float, float]]:
    """The rows of a table of modes by rising frequency; `unit` is what frequencies are divided by.

    Raises
    ------
    ParameterError
        By the name of the column, with the row counted from 1.
    """
    given = {name: numbers(name, values).reshape(-1).tolist() for name, values in columns.items()}
    size = len(given["omega"])
    if not 1 <= size <= MOST_MODES:
        raise ParameterError("omega", f"{size} modes", f"1 to {MOST_MODES} modes")
    for name, values in given.items():
        if len(values) != size:
            raise ParameterError(name, f"{len(values)} numbers", f"as many as omega has: {size}")
    for row in range(size):
        name = f"omega[{row + 1}]"
        positive(name, given["omega"][row])
        if not 1e-100 < given["omega"][row] / unit < 1e100:
            raise ParameterError(name, given["omega"][row], "a frequency of usual size")
        non_negative(f"delta[{row + 1}]", given["delta"][row])
    for name, what in (("contact", "moves the contact"), ("drive", "feels the load")):
        if not any(given[name]):
            raise ParameterError(name, "0 in every mode", f"a structure of which some mode {what}")
    return sorted(zip(given["omega"], given["delta"], given["contact"], given["drive"], strict=True))


@dataclass(frozen=True)
class SizedModes(SizedBody):
    """The same in SI: frequencies in rad/s, modes normalised to the modal mass 1 kg, the gap in m.

    Its scales are 1 kg and 1 m: the dimensionless displacements of the contact are metres.

    Parameters
    ----------
    omega, delta
        ω_n in rad/s and δ_n in 1/s.
    contact, drive
        a_n and b_n in 1/√kg.
    gap
        g in m.

    Raises
    ------
    ParameterError
        As `ModalBody`.
    """

    kind: ClassVar[str] = "modes"

    omega: tuple[float, ...]
    delta: tuple[float, ...]
    contact: tuple[float, ...]
    drive: tuple[float, ...]
    gap: float = 0.0

    def __post_init__(self) -> None:
        made = ModalBody(self.omega, self.delta, self.contact, self.drive, self.gap)
        for name in ("omega", "delta", "contact", "drive", "gap"):
            object.__setattr__(self, name, getattr(made, name))

    @property
    def length(self) -> float:  # type: ignore[override]
        """The scale of lengths, 1 m."""
        return 1.0

    @property
    def damping(self) -> Damping:  # type: ignore[override]
        return Table(self.delta)

    @property
    def mass(self) -> float:
        """The modal mass, 1 kg."""
        return 1.0

    @property
    def transit_time(self) -> float:
        return 0.0

    @property
    def pieces(self) -> tuple[Piece, ...]:
        """None are known."""
        return ()

    def body(self, angular_frequency: float) -> Body:
        scale = positive("angular_frequency", angular_frequency)
        omega, delta = (tuple(w / scale for w in values) for values in (self.omega, self.delta))
        return ModalBody(omega, delta, self.contact, self.drive, self.gap)

    def natural_frequencies(self, modes: int) -> Array:
        squares = np.array(self.omega) ** 2 - (0.5 * np.array(self.delta)) ** 2
        found = np.sqrt(np.maximum(squares, 0.0)) / (2.0 * np.pi)
        return np.asarray(found[: count("modes", modes, most=1 << 20)])

    def __str__(self) -> str:
        n = len(self.omega)
        return f"structure of {n} mode{'s' if n > 1 else ''}, {self.omega[0] / (2.0 * np.pi):.6g} Hz the first"
