"""What a machine does that finds no tool, with the cushion that was assumed where the case describes none."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from percuss.case.answers.json_values import number
from percuss.case.answers.machine_units import in_units
from percuss.case.answers.numerals import number as spelled
from percuss.case.answers.numerals import quantity
from percuss.model import Cushion
from percuss.shown import Shown
from percuss.steady import RigidCycle, blank_blow

if TYPE_CHECKING:
    from percuss.model import Machine
    from percuss.steady import BlankBlow, SelfExcited

__all__ = ["ToldBlank", "told_blank"]

_ASSUMPTION = (
    "the case describes none; assumed is one that begins at the place of the blow, pushes with a constant force, stops "
    "the piston within 20 mm and gives nothing back"
)
_ASSUMED = 0.02  # m: in which the cushion stops the piston that a case without one is told with


@dataclass(frozen=True)
class ToldBlank(Shown):
    """What a machine does that finds no tool.

    Attributes
    ----------
    machine
        The machine.
    found
        The blank blow of its rigid piston.
    assumed
        Whether the cushion is one that was assumed.
    """

    machine: Machine
    found: BlankBlow
    assumed: bool

    @property
    def peak_pressure(self) -> float | None:
        """Of the oil in the cushion (Pa); None without the area on which it presses."""
        cushion = self.found.cushion
        if cushion is None or cushion.area is None or not self.machine.is_si:
            return None
        return self.found.peak_force * self.machine.force_scale / cushion.area

    @property
    def rows(self) -> tuple[tuple[str, str], ...]:
        """What a report tells."""
        found, machine = self.found, self.machine
        rows = []
        if self.assumed:
            rows.append(("cushion", _ASSUMPTION))
        rows.append(("speed", f"{in_units(machine, found.speed, 'speed')} past the place of the blow{self._brought}"))
        if 0.0 < found.depth < math.inf:
            where = "" if found.cushion is None or not found.cushion.beyond else self._reach
            rows.append(("depth", f"{in_units(machine, found.depth, 'length')} into the cushion{where}"))
            pressure = "" if self.peak_pressure is None else f", {spelled(self.peak_pressure / 1e5)} bar"
            rows.append(("peak force", f"{in_units(machine, found.peak_force, 'force')}{pressure}"))
            rows.append(("taken", f"{self._energy(found.taken)} by the cushion in the first pass"))
        rows.append(("then", self._then))
        return tuple(rows)

    @property
    def _brought(self) -> str:
        return f", with {self._energy(self.found.energy)}"

    @property
    def _reach(self) -> str:
        return f", {in_units(self.machine, self.found.reach, 'length')} beyond the place of the blow"

    def _energy(self, value: float) -> str:
        return quantity(value * self.machine.energy_scale, "J") if self.machine.is_si else spelled(value)

    @property
    def _then(self) -> str:
        found, machine = self.found, self.machine
        if found.ending == "strikes the front end":
            return f"it strikes the front end of the housing with {in_units(machine, found.front_speed, 'speed')}"
        if found.ending == "leaves":
            return "nothing holds the piston back: the cushion pushes less than the valve"
        if found.period is not None and found.again is not None:
            again, period = in_units(machine, found.again, "speed"), in_units(machine, found.period, "time")
            return f"the machine goes on without blows: the piston comes again every {period}, with {again}"
        if found.ending == "goes on":
            return f"the machine goes on without blows, and has not repeated itself after {found.passes} passes"
        where = "in the cushion" if found.ending == "stops in the cushion" else "where it reaches no port"
        after = "at once" if found.passes == 1 else f"after {found.passes} passes"
        return f"the machine stops {after}: the piston stays {where}"

    def to_json_dict(self) -> dict[str, Any]:
        """In plain values, dimensionless, and in SI under `si`."""
        found, machine = self.found, self.machine
        told: dict[str, Any] = {
            "cushion": _cushion(found.cushion),
            "assumed": self.assumed,
            "ending": found.ending,
            "passes": found.passes,
            "speed": number(found.speed),
            "reach": number(found.reach),
            "depth": number(found.depth),
            "peak_force": number(found.peak_force),
            "taken": number(found.taken),
            "front_speed": number(found.front_speed),
            "period": number(found.period),
            "again": number(found.again),
            "si": None,
        }
        if machine.is_si:
            told["si"] = {
                "energy_J": number(found.energy * machine.energy_scale),
                "depth_m": number(found.depth * machine.length_scale),
                "reach_m": number(found.reach * machine.length_scale),
                "peak_force_N": number(found.peak_force * machine.force_scale),
                "peak_pressure_Pa": number(self.peak_pressure),
                "taken_J": number(found.taken * machine.energy_scale),
                "front_speed_m_s": number(found.front_speed * machine.speed_scale),
                "period_s": None if found.period is None else number(found.period * machine.time_scale),
                "again_m_s": None if found.again is None else number(found.again * machine.speed_scale),
            }
        return told


def told_blank(rigid: SelfExcited) -> ToldBlank | None:
    """The blank blow of a machine; None without a cycle, or with neither a cushion nor sizes to assume one by."""
    machine, cycle = rigid.machine, rigid.cycle
    if not isinstance(cycle, RigidCycle):
        return None
    if machine.valve.cushion is not None:
        return ToldBlank(machine, blank_blow(rigid), False)
    if not machine.is_si:
        return None
    depth = _ASSUMED / machine.length_scale
    pushed = max(0.0, *(machine.valve.force(name) for name, _ in machine.valve.pairs))
    assumed = Cushion(force=cycle.blow_energy / depth + pushed)
    return ToldBlank(machine, blank_blow(rigid, cushion=assumed), True)


def _cushion(cushion: Cushion | None) -> dict[str, float | None] | None:
    names = ("beyond", "force", "stiffness", "length", "returned", "area")
    return None if cushion is None else {name: number(getattr(cushion, name)) for name in names}
