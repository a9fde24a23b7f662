"""The machine that switches its own valve: body, valve and contact joined, with the scales back to SI."""

from __future__ import annotations

from dataclasses import dataclass, replace

from percuss.errors import ParameterError
from percuss.model.body import Body, SizedBody
from percuss.model.checks import instance, positive
from percuss.model.contact import Contact
from percuss.model.load import Valve
from percuss.model.machine_modes import MachineModes, machine_modes
from percuss.shown import Shown

__all__ = ["Machine"]


@dataclass(frozen=True)
class Machine(Shown):
    """A body, the valve that drives it and the contact by which it strikes, all dimensionless.

    As `System`, but for what drives it: no clock, so that the unit of time is free. A machine in SI has the second for
    it (Ω = 1 rad/s), the length of its bar for the unit of length, its mass for that of mass.

    Parameters
    ----------
    body
        What strikes.
    valve
        States, ports and chamber; forces P/(M L Ω²), distances in bar lengths.
    contact
        How the body leaves the wall.
    at
        The number of the place where the valve's force acts, 0 for the driven end.
    bar
        The body with its sizes in SI, or None.
    pressure
        Of the supply (Pa), where it is known: energy over pressure is the volume that is drawn from it. Needs `bar`.

    Raises
    ------
    ParameterError
        When an argument is none of these, for a place that the body does not have, or a contact law that does not hold
        for the body.

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
        bar
            The body with its sizes.
        valve
            Forces in N, distances in m, delays in s, the stiffness of the chamber in N/m.
        contact, at, pressure
            As of the class.

        Raises
        ------
        ParameterError
            When an argument is none of these.
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

    @property
    def is_si(self) -> bool:
        """Whether the scales back to SI are known."""
        return self.bar is not None

    def _sized(self) -> SizedBody:
        if self.bar is None:
            raise ParameterError("machine", "dimensionless", "a machine made from SI", "use Machine.from_si")
        return self.bar

    @property
    def length_scale(self) -> float:
        """L in m."""
        return self._sized().length

    @property
    def time_scale(self) -> float:
        """1/Ω in s: one second."""
        self._sized()
        return 1.0

    @property
    def speed_scale(self) -> float:
        """LΩ in m/s."""
        return self.length_scale / self.time_scale

    @property
    def force_scale(self) -> float:
        """M L Ω² in N."""
        return self._sized().mass * self.length_scale / self.time_scale**2

    @property
    def energy_scale(self) -> float:
        """M L² Ω² in J."""
        return self.force_scale * self.length_scale

    @property
    def power_scale(self) -> float:
        """M L² Ω³ in W."""
        return self.energy_scale / self.time_scale

    def __str__(self) -> str:
        states = ", ".join(f"{name} {force:.4g}" for name, force in self.valve.pairs)
        gas = self.valve.chamber
        chamber = f"; chamber {gas.force:.4g} + {gas.stiffness:.4g} x" if gas.force or gas.stiffness else ""
        law = f"R = {self.contact.restitution:.6g}"
        text = f"Machine: {self.body}, {law}; valve {states}; {len(self.valve.ports)} ports{chamber}"
        return text if self.bar is None else f"{text}; {self.bar}"
