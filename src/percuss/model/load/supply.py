"""What feeds the valve of a machine: a pump with a steady flow, and an accumulator whose pressure falls and rises."""

from __future__ import annotations

from dataclasses import dataclass

from percuss.model.checks import non_negative, positive

__all__ = ["Supply"]


@dataclass(frozen=True)
class Supply:
    """A pump of steady flow, and an accumulator from which the piston draws.

    The pressure π is a multiple of the one for which the forces of the valve's states hold. In the state k the piston
    is pushed by π p_k, and draws p_k u′ while it moves toward the wall with u′ (the area on which the pressure acts
    is the one that displaces oil), so that

        c π′ = q − p_k u′,   energy of the accumulator c π²/2.

    The accumulator is represented by its tangent: for a gas, c belongs to its volume V and exponent n by C = V/(n P).
    There is no relief valve, and no leakage.

    Parameters
    ----------
    flow
        q, what the pump gives: the power that its flow has at the pressure 1, Q P (dimensionless, of the unit of mass).
    compliance
        c of the accumulator: the volume that it gives up per pressure, times the square of that pressure, C P².
    start
        The pressure at the start, 0 or greater.

    Raises
    ------
    ParameterError
        When `flow` or `compliance` is not greater than 0, or `start` negative.

    References
    ----------
    H. E. Merritt, Hydraulic Control Systems, Wiley, 1967, on compressibility as the capacity of a chamber.

    Examples
    --------
    >>> Supply.of_oil(flow=2.2e-3, compliance=2.5e-11, pressure=160e5).flow
    35200.0
    """

    flow: float
    compliance: float
    start: float = 1.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "flow", positive("flow", self.flow))
        object.__setattr__(self, "compliance", positive("compliance", self.compliance))
        object.__setattr__(self, "start", non_negative("start", self.start))

    @classmethod
    def of_oil(cls, flow: float, compliance: float, pressure: float, start: float | None = None) -> Supply:
        """The supply in SI, for a valve in newtons and metres whose forces hold at a pressure.

        Parameters
        ----------
        flow
            Q of the pump, m³/s.
        compliance
            C of the accumulator, m³/Pa.
        pressure
            For which the forces of the states hold, Pa.
        start
            The pressure at the start, Pa; `pressure` by default.

        Raises
        ------
        ParameterError
            As of the class.
        """
        flow, compliance = positive("flow", flow), positive("compliance", compliance)
        pressure = positive("pressure", pressure)
        begins = 1.0 if start is None else non_negative("start", start) / pressure
        return cls(flow * pressure, compliance * pressure**2, begins)

    def scaled(self, power: float, energy: float) -> Supply:
        """The same supply in other units of power and of energy.

        Raises
        ------
        ParameterError
            When a number is not greater than 0.
        """
        return Supply(self.flow * positive("power", power), self.compliance * positive("energy", energy), self.start)
