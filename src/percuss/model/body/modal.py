"""A structure told by a table of its modes, as a finite-element program or a test in the laboratory gives it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from percuss.errors import ParameterError
from percuss.model.body.body import MOST_GAP, Body, HeldBody, Shape
from percuss.model.body.damping import UNDAMPED, Damping, Table
from percuss.model.body.uniform import Bar, Piece, SizedBody, wave_speed
from percuss.model.checks import Array, finite, instance, non_negative, numbers, positive
from percuss.model.parameter import Parameter, of_field

MOST_MODES = 4096
_LEAST_SHARE = 1e-100  # of the greatest a_n: stands for a mode with a node at the contact

GAP: Parameter[Any] = of_field(
    "gap", "gap g", "distance from the contact to the wall without any force, negative where the wall presses"
)


@dataclass(frozen=True)
class _ModeTable:
    """The columns of a table of modes, checked and in the order of the frequencies; no wave runs through it."""

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
    def damping(self) -> Damping:
        return Table(self.delta)

    @property
    def transit_time(self) -> float:
        return 0.0


@dataclass(frozen=True)
class ModalBody(_ModeTable, HeldBody):  # type: ignore[override]  # the table has the damping
    """A structure with one gap, told by its modes: y = Σ a_n q_n − g, q_n'' + δ_n q_n' + ω_n² q_n = b_n p(t).

    Parameters
    ----------
    omega, delta
        Frequencies ω_n > 0 per radian of the load, which are put in order, and δ_n ≥ 0.
    contact, drive
        a_n, each mode at the contact (modal mass 1), and b_n, where the load acts.
    gap
        g, of either sign: the wall presses where it is negative.

    Examples
    --------
    >>> from percuss.model import Kept, Load, ModalBody, System
    >>> body = ModalBody(omega=(0.6, 2.3), delta=(0.05, 0.1), contact=(1.0, 0.8), drive=(1.0, -0.5), gap=0.3)
    >>> print(System(body, Load.harmonic(0.2, 1.0), Kept(0.7)))
    System: 2 modes, the first ω = 0.6, gap 0.3, R = 0.7; mean 0.2, 1 harmonic, load factor 0.2
    """

    kind: ClassVar[str] = "modes"
    parameters: ClassVar[tuple[Parameter[Any], ...]] = (GAP,)

    @property
    def s(self) -> float:  # type: ignore[override]
        """None: no wave runs through a table of modes."""
        raise ParameterError("s", "a table of modes", "a bar, through which waves run")

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
        """At the load, x = 0, and at the contact, x = 1; the strain is unknown; ParameterError for other places."""
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
    """The rows of a table of modes by rising frequency over `unit`; ParameterError by column and row from 1."""
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
class SizedModes(_ModeTable, SizedBody):  # type: ignore[override]  # likewise
    """The same in SI: frequencies in rad/s, modes normalised to the modal mass 1 kg, the gap in m.

    δ_n in 1/s, a_n and b_n in 1/√kg. Its scales are 1 kg and 1 m: the dimensionless displacements of the contact are
    metres. ParameterError as of `ModalBody`.
    """

    kind: ClassVar[str] = "modes"

    @property
    def length(self) -> float:  # type: ignore[override]
        """The scale of lengths, 1 m."""
        return 1.0

    @property
    def mass(self) -> float:
        """The modal mass, 1 kg."""
        return 1.0

    @property
    def pieces(self) -> tuple[Piece, ...]:
        """None are known."""
        return ()

    def body(self, angular_frequency: float) -> Body:
        scale = positive("angular_frequency", angular_frequency)
        omega, delta = (tuple(w / scale for w in values) for values in (self.omega, self.delta))
        return ModalBody(omega, delta, self.contact, self.drive, self.gap)

    def __str__(self) -> str:
        n = len(self.omega)
        return f"structure of {n} mode{'s' if n > 1 else ''}, {self.omega[0] / (2.0 * np.pi):.6g} Hz the first"


# ---- A uniform bar, or a rigid mass, on a spring and a dashpot at its driven end

_STEPS = 80
_USUAL = 32
MOST_STIFFNESS = 1e12


@dataclass(frozen=True)
class Mounted(HeldBody):
    """u_tt + d u_t − s² u_xx = 0 with s² u_x(0) = k u(0) + c u_t(0) − p(t), u_x(1) = 0, and the wall at u(1) = g.

    Modes cos q_n(1 − x) with q_n tan q_n = k/s² and ω_n = q_n s. The dashpot gives every mode its share
    δ_n = c φ_n(0)²; that it also joins modes, by c φ_m(0)φ_n(0), is left out, which is exact for a rigid mass, and
    else to the first order in c.

    Parameters
    ----------
    stiffness, dashpot
        k/(MΩ²) > 0, of a spring k on the mass M, and c/(MΩ) ≥ 0.
    s, damping
        Wave speed of the bar, inf for a rigid mass, and the law of damping of the bar itself.
    gap
        g, of either sign.

    Examples
    --------
    >>> from percuss.model import Mounted
    >>> Mounted(stiffness=4.0, dashpot=0.1).frequencies(3).tolist()
    [2.0]
    >>> Mounted(stiffness=4.0, dashpot=0.1, s=20.0).frequencies(2).round(4).tolist()
    [1.9967, 62.8955]
    """

    kind: ClassVar[str] = "mounted"
    parameters: ClassVar[tuple[Parameter[Any], ...]] = (
        *Body.parameters,
        of_field("stiffness", "spring k", "stiffness of the spring over MΩ²"),
        of_field("dashpot", "dashpot c", "force per velocity of the dashpot over MΩ"),
        GAP,
    )

    stiffness: float
    dashpot: float = 0.0
    s: float = math.inf
    damping: Damping = UNDAMPED
    gap: float = 0.0

    def __post_init__(self) -> None:
        for name, check in (("stiffness", positive), ("dashpot", non_negative)):
            value = check(name, getattr(self, name))
            if value > MOST_STIFFNESS:
                raise ParameterError(name, value, f"at most {MOST_STIFFNESS:g}")
            object.__setattr__(self, name, value)
        if self.s != math.inf:
            object.__setattr__(self, "s", wave_speed(self.s))
        instance("damping", self.damping, Damping)
        object.__setattr__(self, "gap", _gap(self.gap))

    @property
    def is_rigid(self) -> bool:
        """Whether it is a rigid mass."""
        return self.s == math.inf

    @property
    def most_modes(self) -> int:
        return 1 if self.is_rigid else _USUAL

    def kept(self, modes: int) -> int:
        return min(modes, 1) if self.is_rigid else min(modes, MOST_MODES)

    def wave_numbers(self, count: int) -> Array:
        """q_n, n = 1 … `count`; 0 of a rigid mass; shape (count,)."""
        if self.is_rigid:
            return np.zeros(self.kept(count))
        ratio, n = self.stiffness / self.s**2, np.arange(self.kept(count))
        low, high = np.zeros(n.size), np.full(n.size, 0.5 * np.pi)  # of q − nπ
        for _ in range(_STEPS):  # r sin r' = ratio cos r' has one root in each interval
            middle = 0.5 * (low + high)
            above = (n * np.pi + middle) * np.sin(middle) > ratio * np.cos(middle)
            low, high = np.where(above, low, middle), np.where(above, middle, high)
        return np.asarray(n * np.pi + self._polished(np.asarray(n * np.pi), np.asarray(0.5 * (low + high)), ratio))

    @staticmethod
    def _polished(whole: Array, part: Array, ratio: float) -> Array:
        """One step of Newton's method: bisection leaves a small first root few digits."""
        q = whole + part
        off = q * np.sin(part) - ratio * np.cos(part)
        slope = np.sin(part) + q * np.cos(part) + ratio * np.sin(part)
        return np.asarray(part - off / slope)

    def frequencies(self, count: int) -> Array:
        if self.is_rigid:
            return np.full(self.kept(count), math.sqrt(self.stiffness))
        return self.wave_numbers(count) * self.s

    def dampings(self, count: int) -> Array:
        at_spring = np.cos(self.wave_numbers(count)) ** 2 / self.inertia(count)
        return np.asarray(self.damping.of(self.frequencies(count)) + self.dashpot * at_spring)

    def inertia(self, count: int) -> Array:
        return np.asarray(0.5 * (1.0 + np.sinc(2.0 * self.wave_numbers(count) / np.pi)))

    def shapes(self, x: Array, count: int) -> Shape:
        q, places = self.wave_numbers(count), np.asarray(x, dtype=float)
        angles = np.outer(1.0 - places, q)
        return Shape(np.cos(angles), q * np.sin(angles))

    @property
    def transit_time(self) -> float:
        return 1.0 / self.s

    def __str__(self) -> str:
        what = "rigid mass" if self.is_rigid else f"s = {self.s:.6g}, {self.damping}"
        return f"{what} on a spring k = {self.stiffness:.6g} with c = {self.dashpot:.6g}, gap {self.gap:.6g}"


@dataclass(frozen=True)
class SizedMounted(SizedBody):
    """The same in SI: k in N/m, c in N·s/m, a bar, or without one a rigid mass in kg, and the gap in m.

    Its scales are the mass, and the length of the bar, 1 m without one. ParameterError for values out of range.
    """

    kind: ClassVar[str] = "mounted"

    spring: float
    dashpot: float = 0.0
    bar: Bar | None = None
    rigid_mass: float = 1.0
    gap: float = 0.0

    def __post_init__(self) -> None:
        for name, check in (("spring", positive), ("dashpot", non_negative), ("rigid_mass", positive)):
            object.__setattr__(self, name, check(name, getattr(self, name)))
        object.__setattr__(self, "gap", _gap(self.gap))
        if self.bar is not None:
            instance("bar", self.bar, Bar)

    @property
    def length(self) -> float:  # type: ignore[override]
        """Of the bar, in m; 1 m of a rigid mass."""
        return 1.0 if self.bar is None else self.bar.length

    @property
    def mass(self) -> float:
        """In kg."""
        return self.rigid_mass if self.bar is None else self.bar.mass

    @property
    def damping(self) -> Damping:  # type: ignore[override]
        """Of the bar itself."""
        return UNDAMPED if self.bar is None else self.bar.damping

    @property
    def transit_time(self) -> float:
        return 0.0 if self.bar is None else self.bar.transit_time

    @property
    def pieces(self) -> tuple[Piece, ...]:
        return () if self.bar is None else self.bar.pieces

    def body(self, angular_frequency: float) -> Body:
        scale = positive("angular_frequency", angular_frequency)
        k, c = self.spring / (self.mass * scale**2), self.dashpot / (self.mass * scale)
        gap = self.gap / self.length
        if self.bar is None:
            return Mounted(k, c, gap=gap)
        own = self.bar.body(scale)
        return Mounted(k, c, own.s, own.damping, gap)

    def __str__(self) -> str:
        what = f"mass of {self.mass:.6g} kg" if self.bar is None else str(self.bar)
        return f"{what} on a spring of {self.spring:.6g} N/m"
