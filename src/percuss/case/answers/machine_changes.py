"""How the energy and the rate of a machine that switches itself follow its pressure, ports, delays and restitution."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING

from percuss.steady import self_excited_motion

if TYPE_CHECKING:
    from percuss.model import Machine
    from percuss.steady.self_excited import SelfExcited

__all__ = ["Running", "Sensitivity", "pressure_curve", "sensitivities"]

_STEP = 0.1
"""Of a parameter: what a sensitivity is told for."""

_CURVE = tuple(round(0.5 + 0.05 * i, 2) for i in range(21))
"""Pressures of the curve, as multiples of that of the case."""


@dataclass(frozen=True)
class Sensitivity:
    """How energy and rate follow one parameter.

    Attributes
    ----------
    parameter
        "pressure", or "flow" and "accumulator" of a supply, "restitution", or a key of a port such as
        "ports[0].behind".
    energy, rate
        Relative change of the blow energy and of the blow rate for +10 % of the parameter: half the difference between
        +10 % and −10 %, or the difference to the one at which the machine runs; None when it runs at neither.
    stops
        What the machine does at −10 % and at +10 % when it does not run there, in words; None where it runs.
    """

    parameter: str
    energy: float | None
    rate: float | None
    stops: tuple[str | None, str | None]


@dataclass(frozen=True)
class Running:
    """A machine at another pressure: the factor, and relative to the case the blow energy and rate; None: stopped.

    With a supply the factor is that of the flow of its pump.
    """

    pressure: float
    energy: float | None
    rate: float | None


def sensitivities(motion: SelfExcited) -> tuple[Sensitivity, ...]:
    """Those of a machine that runs, of every parameter that is not 0; with the modes of its cycle."""
    if not motion.runs:
        return ()
    return tuple(_sensitivity(motion, name, changed) for name, changed in _parameters(motion.machine))


def pressure_curve(motion: SelfExcited) -> tuple[Running, ...]:
    """Energy and rate of a machine that runs at other pressures, up to where it stops, the gas being the same.

    With a supply, at other flows of the pump.
    """
    if not motion.runs:
        return ()
    below = [factor for factor in reversed(_CURVE) if factor < 1.0]
    found = {1.0: Running(1.0, 0.0, 0.0)}
    for way in (below, [factor for factor in _CURVE if factor > 1.0]):
        running = True
        for factor in way:
            other = _at(motion, _under(motion.machine, factor)) if running else None
            running = other is not None and other.runs
            energy, rate = _figures(motion, other) if running and other is not None else (None, None)
            found[factor] = Running(factor, energy, rate)
    return tuple(found[factor] for factor in sorted(found))


def _parameters(machine: Machine) -> Iterator[tuple[str, Callable[[float], Machine]]]:
    """The parameters, each with the machine at a multiple of it."""
    if machine.valve.supply is None:
        yield "pressure", partial(_under, machine)
    else:
        yield "flow", partial(_fed, machine, "flow")
        yield "accumulator", partial(_fed, machine, "compliance")
    for i, port in enumerate(machine.valve.ports):
        for key in ("behind", "delay"):
            if getattr(port, key):
                yield f"ports[{i}].{key}", partial(_with_port, machine, i, key)
    if machine.contact.rebounds:
        yield "restitution", partial(_rebounding, machine)


def _rebounding(machine: Machine, factor: float) -> Machine:
    """The machine with a multiple of its restitution, 1 at most."""
    contact = machine.contact
    return replace(machine, contact=contact.with_restitution(min(_times(contact.restitution, factor), 1.0)))


def _times(value: float, factor: float) -> float:
    return factor * value


def _under(machine: Machine, factor: float) -> Machine:
    """The machine under a multiple of its pressure, or of its pump's flow."""
    if machine.valve.supply is not None:
        return _fed(machine, "flow", factor)
    states = tuple((name, factor * force) for name, force in machine.valve.pairs)
    return machine.with_valve(replace(machine.valve, states=states))


def _fed(machine: Machine, name: str, factor: float) -> Machine:
    supply = machine.valve.supply
    assert supply is not None
    changed: dict[str, float] = {name: factor * getattr(supply, name)}
    return machine.with_valve(replace(machine.valve, supply=replace(supply, **changed)))


def _with_port(machine: Machine, number: int, key: str, factor: float) -> Machine:
    ports = list(machine.valve.ports)
    ports[number] = replace(ports[number], **{key: factor * getattr(ports[number], key)})
    return machine.with_valve(replace(machine.valve, ports=tuple(ports)))


def _sensitivity(motion: SelfExcited, name: str, changed: Callable[[float], Machine]) -> Sensitivity:
    less, more = (_at(motion, changed(1.0 + step)) for step in (-_STEP, _STEP))
    slopes = [
        tuple(sign * change for change in _figures(motion, other))
        for other, sign in ((less, -1.0), (more, 1.0))
        if other.runs
    ]
    energy, rate = (sum(column) / len(slopes) for column in zip(*slopes, strict=True)) if slopes else (None, None)
    stops = tuple(None if other.obstacle is None else other.obstacle.words for other in (less, more))
    return Sensitivity(name, energy, rate, (stops[0], stops[1]))


def _at(motion: SelfExcited, machine: Machine) -> SelfExcited:
    room = motion.room if math.isfinite(motion.room) else None
    return self_excited_motion(machine, modes=motion.modes, room=room)


def _figures(motion: SelfExcited, other: SelfExcited) -> tuple[float, float]:
    """By how much the energy and the rate of another cycle differ, relative to that of the case."""
    now, then = motion.cycle, other.cycle
    assert now is not None and then is not None
    return then.blow_energy / now.blow_energy - 1.0, (then.blows / then.period) / (now.blows / now.period) - 1.0
