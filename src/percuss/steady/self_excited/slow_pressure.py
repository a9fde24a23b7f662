"""The pressure of a supply over a cycle: where it settles, how far it swings, and how a disturbance of it dies out."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from percuss.errors import ParameterError
from percuss.model.checks import Array, instance, numbers
from percuss.shown import Shown
from percuss.steady.self_excited.fed_cycle import under_pressure
from percuss.steady.self_excited.rigid_cycle import RigidCycle
from percuss.steady.self_excited.settled_cycle import continued
from percuss.steady.self_excited.supply_course import pressure_at, pressure_extremes, pressure_integral

__all__ = ["SlowPressure", "pressure_over", "slow_pressure"]

_STEP = 1e-4  # of the pressure


@dataclass(frozen=True)
class SlowPressure(Shown):
    """The pressure in a cycle, as a multiple of that for which the forces of the valve's states hold.

    Attributes
    ----------
    at_blow, mean, least, greatest
        Of the pressure.
    multiplier
        What is left of a disturbance of the pressure after a cycle: the multiplier whose direction is that of the
        pressure more than that of the speed. It flips at −1.
    slow_multiplier
        The same for an accumulator so great that the speed follows at once, 1 + (V/(C P)) d ln(T/V)/d ln P; None where
        the machine does not run under the mean pressure, as a constant one.
    """

    at_blow: float
    mean: float
    least: float
    greatest: float
    multiplier: complex
    slow_multiplier: float | None

    @property
    def ripple(self) -> float:
        """Greatest minus least, as a part of the mean."""
        return (self.greatest - self.least) / self.mean

    @property
    def memory(self) -> float:
        """Cycles in which a disturbance of the pressure falls to 1/e; infinite where it does not."""
        left = abs(self.multiplier)
        return math.inf if left >= 1.0 else -1.0 / math.log(left) if left > 0.0 else 0.0


def slow_pressure(cycle: RigidCycle) -> SlowPressure:
    """The pressure of a cycle that a supply feeds.

    Raises
    ------
    ParameterError
        When the cycle is one under a constant pressure.

    Notes
    -----
    Over a cycle P′ = P + (Q T(P) − V)/C, with V what the piston draws: a fast cycle empties the accumulator, and a low
    pressure makes a slow cycle. Without a gas chamber and delays V is constant, T goes with P^(−1/2), and the pressure
    only ever creeps back; with a stiff one, and a return that hardly reaches its port, it overshoots.

    Examples
    --------
    >>> from percuss.model import Kept, Machine, Port, Supply, UniformBar, Valve
    >>> from percuss.steady import self_excited_motion
    >>> ports = [Port("power", behind=1.0, side="back"), Port("return", on="impact")]
    >>> valve = Valve({"return": -0.4, "power": 1.8}, ports, supply=Supply(flow=0.7, compliance=15.0))
    >>> cycle = self_excited_motion(Machine(UniformBar(20.0), valve, Kept(0.2)), modes=0).cycle
    >>> pressure = slow_pressure(cycle)
    >>> print(f"{pressure.mean:.4f} ± {50 * pressure.ripple:.1f} %, multiplier {pressure.multiplier.real:.4f}")
    0.9835 ± 5.2 %, multiplier 0.9292
    """
    checked = _checked(cycle)
    spans = [pressure_extremes(one, checked.piston) for one in checked.segments]
    mean = math.fsum(pressure_integral(one, checked.piston) for one in checked.segments) / checked.period
    at_blow = checked.rebound.pressure
    assert at_blow is not None
    least, greatest = min(low for low, _ in spans), max(high for _, high in spans)
    return SlowPressure(at_blow, mean, least, greatest, _multiplier(checked), _slow_multiplier(checked, mean))


def pressure_over(cycle: RigidCycle, times: Array) -> Array:
    """The pressure at some times of a cycle that a supply feeds, repeated with its period; the shape of `times`.

    Raises
    ------
    ParameterError
        When the cycle is one under a constant pressure.
    """
    checked = _checked(cycle)
    within = np.mod(numbers("times", times), checked.period)
    segments = checked.segments
    begins = np.array([one.time for one in segments])
    which = np.maximum(np.searchsorted(begins, within, side="right") - 1, 0)
    found = [
        pressure_at(segments[i], checked.piston, t)
        for i, t in zip(which.flat, (within - begins[which]).flat, strict=True)
    ]
    return np.array(found, dtype=float).reshape(within.shape)


def _checked(cycle: object) -> RigidCycle:
    found = instance("cycle", cycle, RigidCycle)
    if found.piston.valve.supply is None:
        raise ParameterError("cycle", str(found), "a cycle with a supply", "give the valve a Supply")
    return found


def _multiplier(cycle: RigidCycle) -> complex:
    slope = cycle.slope
    values, vectors = np.linalg.eig(slope)
    size = np.abs(cycle.rebound.numbers)
    scale = np.where(size > 1e-150, size, cycle.period)  # a rebound of hardly any speed is as good as none
    parts = np.abs(vectors / scale[:, None])
    return complex(values[np.argmax(parts[-1] / np.maximum(parts.sum(axis=0), 1e-300))])


def _slow_multiplier(cycle: RigidCycle, mean: float) -> float | None:
    supply = cycle.piston.valve.supply
    assert supply is not None
    near, found = cycle.at_constant_pressure, []
    for pressure in (mean * (1.0 - _STEP), mean * (1.0 + _STEP)):
        other = continued(under_pressure(cycle.piston, pressure), near)
        if other is None:
            return None
        found.append(other.period * pressure / other.work)  # T/V
    slope = math.log(found[1] / found[0]) / math.log((1.0 + _STEP) / (1.0 - _STEP))
    return 1.0 + supply.flow * cycle.period / (supply.compliance * mean) * slope
