"""How blow energy and rate of a self-excited machine change with pressure, ports, delays and restitution."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

from percuss.errors import ParameterError
from percuss.model import Machine
from percuss.model.checks import instance
from percuss.shown import Shown
from percuss.steady.self_excited.rigid_cycle import RigidCycle
from percuss.steady.self_excited.self_switching import SelfExcited, piston_of, self_excited_motion
from percuss.steady.self_excited.settled_cycle import continued
from percuss.steady.self_excited.valve_cycle import ValveCycle

__all__ = ["Sensitivity", "sensitivities"]

_STEP = 1e-5  # of the quantity, or of its unit where it is 0


@dataclass(frozen=True)
class Sensitivity(Shown):
    """The derivatives of a cycle by one quantity of its machine.

    Attributes
    ----------
    quantity
        "pressure", a factor on the forces of all states, which is 1 without the chamber's, or in its place "flow" and
        "compliance" of a supply; "behind" and "delay" of a port; "restitution".
    port
        Number of the port; None for the others.
    value
        Of the quantity.
    energy, rate
        Derivatives of `blow_energy` and of 1/`period`; NaN where no cycle is found on either side.
    """

    quantity: str
    port: int | None
    value: float
    energy: float
    rate: float


def sensitivities(motion: SelfExcited) -> tuple[Sensitivity, ...]:
    """The derivatives of blow energy and rate, by differences of cycles that are solved for beside the one there is.

    Differences are central, but one-sided at a delay and a restitution of 0; relative error about 1e-8, and 1e-5.

    Parameters
    ----------
    motion
        The result of `self_excited_motion` for a machine that runs.

    Raises
    ------
    ParameterError
        When the machine does not run.

    Examples
    --------
    >>> from percuss.model import Kept, Machine, Port, UniformBar, Valve
    >>> from percuss.steady import self_excited_motion
    >>> ports = [Port("power", behind=1.0, side="back"), Port("return", on="impact")]
    >>> machine = Machine(UniformBar(20.0), Valve({"return": -0.4, "power": 1.8}, ports), Kept(0.2))
    >>> for one in sensitivities(self_excited_motion(machine, modes=0))[:2]:
    ...     print(one.quantity, f"{one.energy:.6f} {one.rate:.6f}")
    pressure 2.291667 0.158784
    behind 2.291667 -0.158784
    """
    instance("motion", motion, SelfExcited)
    if motion.cycle is None or not motion.runs:
        raise ParameterError("motion", str(motion), "a machine that runs")
    return tuple(_sensitivity(motion, motion.cycle, *quantity) for quantity in _quantities(motion.machine))


def _quantities(machine: Machine) -> Iterator[tuple[str, int | None, float]]:
    supply = machine.valve.supply
    if supply is None:
        yield "pressure", None, 1.0
    else:
        yield from (("flow", None, supply.flow), ("compliance", None, supply.compliance))
    for i, port in enumerate(machine.valve.ports):
        if port.behind is not None:
            yield "behind", i, port.behind
        yield "delay", i, port.delay
    yield "restitution", None, machine.contact.restitution


def _changed(machine: Machine, quantity: str, port: int | None, value: float) -> Machine:
    valve = machine.valve
    if quantity == "restitution":
        return replace(machine, contact=machine.contact.with_restitution(value))
    if port is None and valve.supply is not None:
        changed: dict[str, Any] = {quantity: value}
        return machine.with_valve(replace(valve, supply=replace(valve.supply, **changed)))
    if port is None:
        return machine.with_valve(replace(valve, states={name: force * value for name, force in valve.pairs}))
    ports = list(valve.ports)
    ports[port] = replace(ports[port], behind=value) if quantity == "behind" else replace(ports[port], delay=value)
    return machine.with_valve(replace(valve, ports=tuple(ports)))


def _sensitivity(motion: SelfExcited, cycle: ValveCycle, quantity: str, port: int | None, value: float) -> Sensitivity:
    step = _STEP * (value or (1.0 if quantity == "restitution" else cycle.period))
    highest = 1.0 if quantity == "restitution" else value + step
    found = []
    for other in (max(value - step, 0.0), min(value + step, highest)):
        near = _near(motion, cycle, _changed(motion.machine, quantity, port, other)) if other != value else cycle
        if near is not None:
            found.append((other, near.blow_energy, 1.0 / near.period))
    if len(found) < 2:
        return Sensitivity(quantity, port, value, float("nan"), float("nan"))
    (low, energy, rate), (high, more, faster) = found
    return Sensitivity(quantity, port, value, (more - energy) / (high - low), (faster - rate) / (high - low))


def _near(motion: SelfExcited, cycle: ValveCycle, machine: Machine) -> ValveCycle | None:
    """The cycle of a machine that differs little."""
    if isinstance(cycle, RigidCycle):
        return continued(piston_of(machine), cycle)
    return self_excited_motion(machine, modes=motion.modes, near=cycle).cycle
