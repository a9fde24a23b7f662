"""The machine that switches its own valve: body, valve and contact joined, with the scales back to SI."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from percuss.errors import ParameterError, PercussError
from percuss.halting import interruptible
from percuss.model.body import Body, SizedBody
from percuss.model.body.uniform import SIScales
from percuss.model.checks import Array, count, instance, non_negative, numbers, positive
from percuss.model.contact import Contact
from percuss.model.load import Load, Valve

# ---- The free motions of a body whose driven end a gas chamber holds: the rigid motion and the modes, coupled by it

_MOST = 1 << 14


@dataclass(frozen=True)
class MachineModes:
    """Coordinates m_0 … m_N of a body on a gas chamber, each of which moves by itself; arrays of shape (N + 1,).

    m_i'' + damping_i m_i' + ω_i² m_i = driven_i p under the force p of the valve, without the chamber's stiffness,
    which is in ω. The modal masses are 1: the kinetic energy is ½ Σ m_i'². Without a chamber m_0 is the motion of the
    centre of mass, ω_0 = 0, and the others are the body's own modes, of modal mass 1.

    Parameters
    ----------
    omega
        Undamped frequencies, increasing.
    damping
        d_i: of the law of the body at these frequencies; the drag on the body as a whole for i = 0.
    end
        What m_i = 1 moves the striking end by.
    driven
        … and the place where the valve's force acts.
    mixing
        V, orthogonal, shape (N + 1, N + 1): r = V m are the body's own coordinates of modal mass 1, r_0 the position of
        the centre of mass. The identity without a chamber.
    """

    omega: Array
    damping: Array
    end: Array
    driven: Array
    mixing: Array

    @property
    def size(self) -> int:
        """N, the elastic modes."""
        return self.omega.size - 1

    @property
    def centre(self) -> Array:
        """What m_i = 1 moves the centre of mass by."""
        return np.asarray(self.mixing[0])

    def at(self, body: Body, x: Array) -> Array:
        """What m_i = 1 moves the places x (0 at the driven end to 1) of the body by; shape (len(x), N + 1)."""
        instance("body", body, Body)
        x = numbers("x", x)
        if np.any((x < 0.0) | (x > 1.0)):
            raise ParameterError("x", x, "places from 0 (driven end) to 1")
        own = np.ones((x.size, 1))
        if self.size:
            own = np.hstack([own, body.shapes(x, self.size).displacement * body.modes(self.size).end])
        return np.asarray(own @ self.mixing)


def _machine_modes(body: Body, at: int, stiffness: float, elastic: int) -> MachineModes:
    own = body.modes(elastic, at) if elastic else None
    omega = np.zeros(elastic + 1)
    end, driven = np.ones(elastic + 1), np.ones(elastic + 1)
    damping = np.full(elastic + 1, body.damping.rigid)
    if own is not None:
        omega[1:], end[1:], driven[1:], damping[1:] = own.omega, own.end, own.end * own.at_load, own.damping
    mixing = np.eye(elastic + 1)
    if stiffness > 0.0:
        # rank one beside a diagonal: every frequency rises, none beyond the next one before
        matrix = np.diag(omega**2) + stiffness * np.outer(driven, driven)
        squares, mixing = np.linalg.eigh(matrix) if elastic < _QUICK else interruptible(lambda: np.linalg.eigh(matrix))
        omega = np.sqrt(np.maximum(squares, 0.0))
        if elastic:
            damping[1:] = body.damping.of(omega[1:])
        mixing = mixing * np.where(mixing.T @ end < 0.0, -1.0, 1.0)
        end, driven = mixing.T @ end, mixing.T @ driven
    found = MachineModes(omega, damping, end, driven, mixing)
    for values in (omega, damping, end, driven, mixing):
        values.setflags(write=False)
    return found


_QUICK = 300  # modes of which the matrix takes no tenth of a second; 4096 take a minute

_known = lru_cache(maxsize=32)(_machine_modes)


def machine_modes(body: Body, at: int, stiffness: float, elastic: int) -> MachineModes:
    """The free motions of a body on a gas chamber κ = `stiffness` at the place `at`, N = `elastic`; read-only."""
    body.place(at)
    return _known(body, at, non_negative("stiffness", stiffness), count("modes", elastic, least=0, most=_MOST))


# ---- The machine that switches its own valve: body, valve and contact joined, with the scales back to SI


@dataclass(frozen=True)
class Machine(SIScales):
    """A body, the valve that drives it and the contact by which it strikes, all dimensionless.

    As `System`, but for what drives it: no clock, so that the unit of time is free. A machine in SI has the second for
    it (Ω = 1 rad/s), the length of its bar for the unit of length, its mass for that of mass.

    Parameters
    ----------
    valve
        States, ports and chamber; forces P/(M L Ω²), distances in bar lengths.
    at
        The number of the place where the valve's force acts, 0 for the driven end.
    bar
        The body with its sizes in SI, or None.
    pressure
        Of the supply (Pa), where it is known: energy over pressure is the volume that is drawn from it. Needs `bar`.

    Examples
    --------
    >>> from percuss.model import Kept, Port, UniformBar, Valve
    >>> ports = [Port("power", behind=1.0, side="back"), Port("return", on="impact")]
    >>> machine = Machine(UniformBar(20.0), Valve({"return": -0.4, "power": 1.8}, ports), Kept(0.2))
    >>> machine.modes(2).omega.round(3).tolist()
    [0.0, 62.832, 125.664]
    """

    body: Body
    valve: Valve
    contact: Contact
    at: int = 0
    bar: SizedBody | None = None
    pressure: float | None = None

    def __post_init__(self) -> None:
        instance("body", self.body, Body).place(self.at)
        instance("valve", self.valve, Valve)
        instance("contact", self.contact, Contact).check(self.body)
        if self.bar is not None:
            instance("bar", self.bar, SizedBody)
        if self.pressure is not None:
            if self.bar is None:
                raise ParameterError("pressure", self.pressure, "a machine with sizes", "use Machine.from_si")
            object.__setattr__(self, "pressure", positive("pressure", self.pressure))

    @classmethod
    def from_si(
        cls, bar: SizedBody, valve: Valve, contact: Contact, *, at: int = 0, pressure: float | None = None
    ) -> Machine:
        """The machine of a body in SI units and of a valve in newtons, metres and seconds.

        Parameters
        ----------
        valve
            Forces in N, distances in m, delays in s, the stiffness of the chamber in N/m.
        contact, at, pressure
            As of the class.
        """
        instance("bar", bar, SizedBody), instance("valve", valve, Valve)
        made = valve.scaled(1.0 / (bar.mass * bar.length), 1.0 / bar.length)
        return cls(bar.body(1.0), made, contact, at=at, bar=bar, pressure=pressure)

    def modes(self, count: int) -> MachineModes:
        """The free motions of the body on the gas of the chamber: the piston as a whole, and `count` elastic modes."""
        return machine_modes(self.body, self.at, self.valve.chamber.stiffness, count)

    @property
    def drag(self) -> float:
        """d of the motion of the body as a whole, dimensionless."""
        return self.body.damping.rigid

    def with_valve(self, valve: Valve) -> Machine:
        """The same body and contact under another valve."""
        return replace(self, valve=valve)

    # -- scales --

    def _si(self) -> tuple[SizedBody, float]:
        if self.bar is None:
            raise ParameterError("machine", "dimensionless", "a machine made from SI", "use Machine.from_si")
        return self.bar, 1.0  # the unit of time is one second

    def __str__(self) -> str:
        states = ", ".join(f"{name} {force:.4g}" for name, force in self.valve.pairs)
        gas = self.valve.chamber
        chamber = f"; chamber {gas.force:.4g} + {gas.stiffness:.4g} x" if gas.force or gas.stiffness else ""
        law = f"R = {self.contact.restitution:.6g}"
        text = f"Machine: {self.body}, {law}; valve {states}; {len(self.valve.ports)} ports{chamber}"
        return text if self.bar is None else f"{text}; {self.bar}"


def check_closed_form(machine: Machine) -> None:
    """Refuse a machine whose oil flows, of which there is no closed form."""
    if machine.valve.flows:
        raise PercussError(
            "this is not computed for a machine whose oil flows: there is no closed form of its motion",
            "leave out what its oil loses; percuss machine, simulate, follow and sweep take it",
        )


# ---- Whether a load switches back and forth between two levels, as a valve does
#
# The levels are found as for a pulse (IEEE Std 181): the medians of the values above and below the middle of the range.
# The load switches when it is within 15 % of their distance of one of them for at least 70 % of the period. A square
# wave is for 100 % of it, one of five harmonics for 87 %, a trapezoid with edges of a fifth of the period for 72 %; a
# harmonic load is for 41 %, a triangle for 30 %.

NEAR = 0.15  # how near a level, as a part of the distance of the two, the load counts as at it
LEAST_SHARE = 0.7  # part of the period from which on a load at its levels switches
_SAMPLES = 2048
_PER_HARMONIC = 8


@dataclass(frozen=True)
class TwoLevels:
    """The two levels of a load that switches, in its unit, and the part of the period that it is at one of them."""

    high: float
    low: float
    share: float


def switching_of(load: Load) -> TwoLevels | None:
    """The levels of a load that switches between two, or None, as of a clipped record: those are the sensor's."""
    instance("load", load, Load)
    if load.is_constant or (load.report is not None and load.report.clipped):
        return None
    values = _period(load)
    above = values > 0.5 * (float(values.max()) + float(values.min()))
    high, low = float(np.median(values[above])), float(np.median(values[~above]))
    away = np.minimum(np.abs(values - high), np.abs(values - low))
    share = float(np.mean(away <= NEAR * (high - low)))
    return TwoLevels(high, low, share) if share >= LEAST_SHARE else None


def _period(load: Load) -> Array:
    """The load at evenly spaced phases."""
    size = load.coefficients.size
    n = max(_SAMPLES, _PER_HARMONIC * size)
    if load.is_piecewise:
        return load.value(2.0 * np.pi * (np.arange(n) + 0.5) / n)
    waves = np.zeros(n, dtype=complex)
    waves[:size] = load.coefficients
    return np.asarray(n * np.fft.ifft(waves).real)
