"""What a data sheet says of a machine's oil: areas, stroke and losses that explain pressure, flow, rate and energy."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from percuss.errors import ConvergenceError, ParameterError, extra_package
from percuss.model import Join, Machine, Oil, OilChamber, Valve
from percuss.model.checks import Array, positive
from percuss.short_repr import ShortRepr
from percuss.steady.oil.oil_cycle import near_oil, settled_oil
from percuss.steady.self_excited.valve_cycle import ValveCycle

_START = 0.15  # drop of every passage at the blow speed, over the pressure, where the machine has none
_FAR = 4.0  # of the logarithms of areas and places


@dataclass(frozen=True)
class DataSheetFit(ShortRepr):
    """A machine at a constant pressure with the flow, the rate and the energy of a data sheet.

    Attributes
    ----------
    machine, cycle
        The machine at the pressure of the sheet as the pressure 1, and its cycle.
    areas, places, passages
        What areas, places of ports, and ζ of the passages are multiplied by; `passages` where the machine had none are
        such that each takes this part of the pressure at the blow speed.
    lossless_energy
        Blow energy of the machine whose oil loses nothing, with the same flow and rate.
    """

    machine: Machine
    cycle: ValveCycle
    areas: float
    places: float
    passages: float
    lossless_energy: float

    def __str__(self) -> str:
        return f"DataSheetFit: areas × {self.areas:.4g}, places × {self.places:.4g}, passages × {self.passages:.4g}"


def with_chambers(valve: Valve) -> Valve:
    """A valve of two states with its chambers: front on the supply in both, rear on the supply or the tank."""
    if valve.oil is not None:
        return valve
    (back, pull), (power, push) = sorted(valve.pairs, key=lambda pair: pair[1])[:2]
    if len(valve.pairs) != 2 or not pull < 0.0 < push:
        raise ParameterError(
            "case", [name for name, _ in valve.pairs], "a valve with a state that returns and one that drives",
            "describe its chambers",
        )  # fmt: skip
    chambers = (OilChamber("rear", push - pull, "rear"), OilChamber("front", -pull, "front"))
    joins = {
        back: (Join("rear", "tank"), Join("front", "supply")), power: (Join("rear", "supply"), Join("front", "supply"))
    }  # fmt: skip
    return replace(valve, oil=Oil(chambers, {name: joins[name] for name, _ in valve.pairs}))


def data_sheet(machine: Machine, pressure: float, flow: float, rate: float, energy: float) -> DataSheetFit:
    """The areas, places of ports and losses with which a machine has the figures of a data sheet.

    A given pressure, flow and rate fix the volume of a cycle, and with it areas times stroke; the energy is that of the
    lossless machine less what its passages take (docs/oil.md, section 5).

    Parameters
    ----------
    pressure
        As a multiple of that for which the states hold.
    flow, rate, energy
        Flow times that pressure, blows per time, and energy of a blow, of the machine; per unit of mass.

    Raises
    ------
    ParameterError
        For a valve that has not two states, and figures whose blow power is beyond the input.
    ConvergenceError
        Where no areas, places and losses have these figures.
    """
    optimize = extra_package("scipy.optimize", "io")
    for name, value in (("pressure", pressure), ("flow", flow), ("rate", rate), ("energy", energy)):
        positive(name, value)
    factor = machine.contact.velocity_factor
    if (1.0 - factor * factor) * energy * rate > flow * pressure:
        wanted = f"at most {flow * pressure / rate / (1.0 - factor * factor):.6g}: all of the input"
        raise ParameterError(
            "energy", energy, wanted, "check pressure, flow and rate: this hammer gives more than it gets"
        )
    base = with_chambers(replace(machine.valve, supply=None))
    has_own = any(join.inward or join.outward for _, own in _oil(base).pairs for join in own)
    speed, known = math.sqrt(2.0 * energy), dict[bytes, ValveCycle | None]()
    last: list[ValveCycle] = []

    def made(x: Array) -> Machine:
        areas, places, passages = math.exp(x[0]), math.exp(x[1]), float(x[2])
        oil = _oil(base)
        chambers = tuple(replace(one, area=areas * one.area) for one in oil.chambers)
        size = {one.name: one.area for one in chambers}

        def lossy(join: Join) -> Join:
            if has_own:
                return replace(join, inward=passages * join.inward, outward=passages * join.outward)
            zeta = passages * pressure / (size[join.chamber] * speed) ** 2
            return replace(join, inward=zeta, outward=zeta)

        joins = {name: tuple(lossy(join) for join in own) for name, own in oil.pairs}
        ports = tuple(replace(one, behind=None if one.behind is None else places * one.behind) for one in base.ports)
        states = {name: areas * force for name, force in base.pairs}
        valve = replace(base, states=states, ports=ports, oil=replace(oil, chambers=chambers, joins=joins))
        return machine.with_valve(valve.at_pressure(pressure))

    def cycle_of(x: Array) -> ValveCycle | None:
        key = x.tobytes()
        if key not in known:
            there = made(x)
            found = near_oil(there, last[-1]) if last else None
            found = found or settled_oil(there).cycle
            known[key] = found if found is not None and found.blows == 1 and found.oil is not None else None
            if known[key] is not None:
                last[:] = [found]  # type: ignore[list-item]  # it is one
        return known[key]

    def off(x: Array) -> Array:
        cycle = cycle_of(x)
        if cycle is None or cycle.oil is None:
            return np.full(3, 3.0)
        found = (
            cycle.oil.pumped / cycle.period / (flow * pressure),
            1.0 / (cycle.period * rate),
            cycle.main_energy / energy,
        )
        return np.log(found)

    def solved(passages: float) -> Array:
        """Areas and places with the flow and the rate, at these losses."""

        def of_two(y: Array) -> Array:
            return off(np.append(y, passages))[:2]

        found = optimize.least_squares(of_two, np.zeros(2), bounds=(-_FAR, _FAR), xtol=1e-12, ftol=1e-14, gtol=1e-14)
        return np.append(found.x, passages)

    tiny = 1e-9
    free = solved(tiny)
    if float(np.abs(off(free)[:2]).max()) > 1e-6:
        raise ConvergenceError(
            "no areas and places of ports give this flow at this rate", remedy="check them, or the mass of the piston"
        )
    lossless = float(energy * math.exp(off(free)[2]))
    if lossless < energy:
        told = (
            f"the lossless machine of this pressure, flow and rate strikes with {lossless / energy:.4g} of that energy"
        )
        raise ParameterError("energy", energy, "an energy that losses leave", f"{told}: check the figures")
    start = np.append(free[:2], 1.0 if has_own else _START)
    found = optimize.least_squares(
        off, start, bounds=([-_FAR, -_FAR, 0.0], [_FAR, _FAR, 1e3]), xtol=1e-13, ftol=1e-15, gtol=1e-15
    )
    cycle = cycle_of(found.x)
    if cycle is None or float(np.abs(off(found.x)).max()) > 1e-6:
        raise ConvergenceError("no losses in passages explain these figures", remedy="check them against each other")
    areas, places = (math.exp(one) for one in found.x[:2])
    return DataSheetFit(cycle.machine, cycle, areas, places, float(found.x[2]), lossless)


def _oil(valve: Valve) -> Oil:
    assert valve.oil is not None
    return valve.oil
