"""The system: body, load and contact joined and made dimensionless, with the scales back to SI."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any, overload

import numpy as np
import numpy.typing as npt

from percuss.errors import ParameterError
from percuss.model.body import Body, External, HeldBody, ModalBody, Modes, SizedBody, UniformBar
from percuss.model.body.uniform import SIScales
from percuss.model.checks import (
    MOST_FORCE,
    Array,
    array,
    finite,
    force,
    instance,
    non_negative,
    numbers,
    positive,
    unit_interval,
)
from percuss.model.contact import Contact, Kept
from percuss.model.load import Load


@dataclass(frozen=True, init=False)
class System(SIScales):
    """A body, the load that drives it and the contact by which it strikes, all dimensionless.

    Researchers of B77's uniform bar make one from s, d, R and a load, `System(s=…, d=…, restitution=…, load=…)`;
    others from a body and a contact law; engineers with `System.from_si`.

    Parameters
    ----------
    load
        The dimensionless load P/(M L² Ω²), with the place where it acts.
    bar, frequency
        The body with its sizes in SI and the frequency (Hz) of the load's fundamental behind an SI system, or None.
    s, d, restitution
        Instead of `body` and `contact`: a uniform bar of wave speed s = C/(LΩ) > 0 and external damping
        d = D/(MΩ) ≥ 0, which keeps its strain at an impact with the coefficient of restitution R, 0 to 1 (B77).

    Examples
    --------
    >>> system = System(s=20.0, d=0.0048, restitution=0.6, load=Load.harmonic(0.9, 1.0))
    >>> print(system)
    System: s = 20, d = 0.0048, R = 0.6; mean 0.9, 1 harmonic, load factor 0.9
    >>> from percuss.model import Kept, Ratio, UniformBar
    >>> free = System(UniformBar(20.0, Ratio(1e-3)), Load.harmonic(0.9, 1.0), Kept(0.6))
    >>> free.s, free.d, free.restitution
    (20.0, 0.0, 0.6)
    """

    body: Body
    load: Load
    contact: Contact
    bar: SizedBody | None = None
    frequency: float | None = None

    @overload
    def __init__(
        self, body: Body, load: Load, contact: Contact, *, bar: SizedBody | None = None, frequency: float | None = None
    ) -> None: ...

    @overload
    def __init__(self, s: float, d: float, restitution: float, load: Load) -> None: ...

    def __init__(
        self,
        *given: Any,
        body: Body | None = None,
        load: Load | None = None,
        contact: Contact | None = None,
        bar: SizedBody | None = None,
        frequency: float | None = None,
        s: float | None = None,
        d: float | None = None,
        restitution: float | None = None,
    ) -> None:
        whole = body is not None or contact is not None or (bool(given) and isinstance(given[0], Body))
        names = ("body", "load", "contact") if whole else ("s", "d", "restitution", "load")
        named = {"body": body, "load": load, "contact": contact, "s": s, "d": d, "restitution": restitution}
        values = _matched(names, given, {name: value for name, value in named.items() if value is not None})
        if whole:
            self._set(**values, bar=bar, frequency=frequency)
        else:
            made = UniformBar(values["s"], External(non_negative("d", values["d"])))
            self._set(made, values["load"], Kept(unit_interval("restitution", values["restitution"])), bar, frequency)

    def _set(
        self, body: Body, load: Load, contact: Contact, bar: SizedBody | None = None, frequency: float | None = None
    ) -> None:
        if not isinstance(load, Load):
            raise ParameterError("load", load, "a Load")
        greatest = float(abs(load.coefficients).max())
        if not greatest <= MOST_FORCE:
            raise ParameterError("load", greatest, f"coefficients of at most {MOST_FORCE:g}")
        force("load", greatest), force("mean of the load", float(load.coefficients[0].real))
        if load.frequency is not None:
            raise ParameterError("load", str(load), "a dimensionless load", "use System.from_si for a load in newtons")
        instance("body", body, Body).place(load.at)
        instance("contact", contact, Contact).check(body)
        if not (body.is_free or contact.keeps_strain):
            raise ParameterError("contact", contact.kind, "the law that keeps the strain for a body that is held")
        if bar is not None:
            instance("bar", bar, SizedBody)
        if (bar is None) != (frequency is None):
            raise ParameterError("bar", bar, "a bar and a frequency together, or neither")
        if frequency is not None:
            frequency = positive("frequency", frequency)
        values = {"body": body, "load": load, "contact": contact, "bar": bar, "frequency": frequency}
        for name, value in values.items():
            object.__setattr__(self, name, value)

    @classmethod
    def from_si(cls, bar: SizedBody, load: Load, contact: Contact) -> System:
        """The system of a body in SI units, a load in newtons with its frequency, and a contact.

        ParameterError when the load has no frequency.
        """
        instance("bar", bar, SizedBody), instance("load", load, Load), instance("contact", contact, Contact)
        if load.frequency is None:
            raise ParameterError("frequency", None, "a frequency in Hz greater than 0")
        omega = 2.0 * math.pi * load.frequency
        force_scale = bar.mass * bar.length * omega**2
        made = load.scaled(1.0 / force_scale)
        return cls(bar.body(omega), made, contact, bar=bar, frequency=load.frequency)

    # -- the numbers of B77 --

    @property
    def s(self) -> float:
        """Wave speed: 1/(time of a wave from end to end), dimensionless; C/(LΩ) of a uniform bar."""
        return self.body.s

    @property
    def d(self) -> float:
        """Damping of the rigid motion, dimensionless: B77's D/(MΩ), 0 unless the damping is external."""
        return self.body.rigid_drag

    @property
    def push(self) -> float:
        """The mean force on the body as a whole: p_0 of the load, and 0 where the body is held."""
        return self.load.mean if self.body.is_free else 0.0

    @property
    def restitution(self) -> float:
        """Coefficient of restitution R, 0 to 1."""
        return self.contact.restitution

    # -- scales --

    def _si(self) -> tuple[SizedBody, float]:
        if self.bar is None or self.frequency is None:
            raise ParameterError("system", "dimensionless", "a system made from SI", "use System.from_si")
        return self.bar, 2.0 * math.pi * self.frequency

    @property
    def angular_frequency(self) -> float:
        """Ω in rad/s."""
        return self._si()[1]

    @property
    def stress_scale(self) -> float:
        """E at the striking end, in Pa; `stress` is that of any place."""
        return self._si()[0].pieces[-1].youngs_modulus

    def stress(self, x: npt.ArrayLike, strain: npt.ArrayLike) -> Array:
        """Stress in Pa where the strain is u_x, negative in compression: E of the section at each place times it.

        ParameterError for a system without sizes, places beyond the bar, and strains of another shape.

        Parameters
        ----------
        x
            Places from 0 at the driven end to 1, shape (n,).
        strain
            Dimensionless, shape (n,) or (n, …), as `Orbit.strain` and `Trajectory.strain` give it.
        """
        moduli, found = self._si()[0].youngs_modulus_at(array("x", x, 0.0, 1.0)), numbers("strain", strain)
        if found.shape[:1] != moduli.shape:
            raise ParameterError("strain", f"shape {found.shape}", f"a row for each of {moduli.size} places")
        return np.asarray((moduli * found.T).T)

    # -- neighbours --

    def with_restitution(self, restitution: float) -> System:
        """The same system with another coefficient of restitution."""
        return replace(self, contact=self.contact.with_restitution(restitution))

    def with_load(self, load: Load) -> System:
        """The same body and contact under another dimensionless load."""
        return replace(self, load=load)

    def uniform(self, s: float | None = None, d: float | None = None) -> System:
        """The same load and contact on a uniform bar with another s or external d, without the scales to SI.

        ParameterError when the body has other numbers than these.
        """
        if not isinstance(self.body, UniformBar):
            raise ParameterError("body", self.body.kind, "a uniform bar, which s and d describe")
        damping = self.body.damping if d is None else External(non_negative("d", d))
        body = UniformBar(self.body.s if s is None else s, damping)
        return System(body, self.load, self.contact)

    def with_load_factor(self, load_factor: float) -> System:
        """The same alternating load about the mean that makes p_0/p_k equal to `load_factor`.

        ParameterError when the load is constant.
        """
        present = self.load.harmonics
        if not present.size:
            raise ParameterError("load", str(self.load), "a load with an alternating part")
        mean = finite("load_factor", load_factor) * abs(complex(self.load.coefficients[present[0]]))
        return replace(self, load=self.load.with_mean(mean))

    def __str__(self) -> str:
        text = f"System: {self.body}, R = {self.restitution:.6g}{self._law()}; {str(self.load).removeprefix('Load: ')}"
        return text if self.bar is None else f"{text}; {self.frequency:.4g} Hz; {self.bar}"

    def _law(self) -> str:
        return "" if isinstance(self.contact, Kept) else f", strain {self.contact.kind}"


def _matched(names: tuple[str, ...], given: tuple[Any, ...], named: dict[str, Any]) -> dict[str, Any]:
    """The arguments of one of the two ways to make a system, None for what is missing; ParameterError for others."""
    if len(given) > len(names):
        raise ParameterError("system", len(given), f"{', '.join(names)}: no more without a name")
    values = dict.fromkeys(names) | dict(zip(names, given, strict=False))
    for name, value in named.items():
        if name not in names:
            raise ParameterError(name, value, "either body, load and contact or s, d, restitution and load, not both")
        if values[name] is not None:
            raise ParameterError(name, value, "one value, not two")
        values[name] = value
    return values


# ---- The structure of one mode that has its wall where it rests without force: rest and release of it are those of a
# bar
#
# While the wall holds the contact of such a structure it stands still, and has forgotten all that was before. The
# spring then presses or pulls as the load does: y = a q − g with q'' + d q' + ω² q = b p(t) is y'' + d y' + ω² y = γ p
# − ω² g, γ = a b. The wall feels γ p − ω² g, the structure leaves it where that changes from push to pull, and flies
# from y = 0 and y' = 0. (C. Budd and F. Dux, Phil. Trans. R. Soc. Lond. A 347 (1994) 365–389.)


def rests(system: System, modes: int) -> bool:
    """Whether what rests on the wall stands still, so that the load alone tells when it leaves: a bar, or one mode."""
    return system.body.is_free or modes == 1


def wall_load(system: System, modes: int) -> Load:
    """The load that pulls the contact off the wall; of one mode sign(γ) (p − ω² g/γ), ParameterError for more."""
    body = system.body
    if not isinstance(body, HeldBody):
        return system.load
    if not rests(system, modes):
        raise ParameterError(
            "modes", modes, "1 for the rest of a structure that is held: of several modes the others move on meanwhile"
        )
    known = body.modes(1, system.load.at)
    gamma, omega = float(known.gamma[0]), float(known.omega[0])
    offset = omega * omega * body.gap / gamma
    if not math.isfinite(offset):
        raise ParameterError("gap", body.gap, "a gap that forces of usual size can close")
    return system.load.with_mean(system.load.mean - offset).scaled(math.copysign(1.0, gamma))


def set_at_wall(system: System, modes: int) -> System:
    """The system whose impacts are those of a structure of one mode, with the wall at 0; all others as they are."""
    if system.body.is_free or modes > 1:
        return system
    load = wall_load(system, modes).acting_at(0)
    known = system.body.modes(1, system.load.at)
    contact = 1.0 / math.sqrt(float(known.inertia[0]))
    drive = abs(float(known.gamma[0])) / contact
    body = ModalBody((float(known.omega[0]),), (float(known.damping[0]),), (contact,), (drive,))
    return System(body, load, system.contact)


def half_swing(known: Modes) -> float:
    """How long the first mode goes on the way on which a force of one sign has put it; inf where it is overdamped."""
    half = 0.5 * float(known.damping[0])
    square = (float(known.omega[0]) - half) * (float(known.omega[0]) + half)
    return math.pi / math.sqrt(square) if square > 0.0 else math.inf
