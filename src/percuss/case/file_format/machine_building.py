"""A case whose load the piston switches has a machine in place of a system."""

from __future__ import annotations

from percuss.case.file_format.building import Parts, check_motion, extreme
from percuss.case.file_format.load_tables import ValveForce, ValveLoad
from percuss.case.file_format.problems import from_parameter
from percuss.case.file_format.schema import PhysicalCase, PlainCase
from percuss.case.file_format.valve_building import pressure_of
from percuss.errors import CaseError, ParameterError
from percuss.model import Machine

__all__ = ["check_clock", "machine_of"]


def check_clock(tables: PhysicalCase | PlainCase, file: str) -> None:
    """Refuse a machine that switches itself, where a load that keeps time by itself is asked for.

    Raises
    ------
    CaseError
        With the commands that answer for such a machine.
    """
    check_motion(tables, file)
    if isinstance(tables.load, ValveForce | ValveLoad):
        remedy = "'percuss machine' answers for a valve that the piston switches, and 'percuss simulate' from a start"
        raise CaseError(file, "load.kind", "valve", "expected a load that keeps time by itself", remedy)


def machine_of(tables: PhysicalCase | PlainCase, parts: Parts, file: str) -> Machine:
    """The machine of a case whose load the piston switches.

    Raises
    ------
    CaseError
        When the load is another, or does not fit the case.
    """
    check_motion(tables, file)
    table = tables.load
    if not isinstance(table, ValveForce | ValveLoad):
        assert table is not None
        remedy = "describe the valve by its states and ports; 'percuss steady' answers for a load that keeps time"
        raise CaseError(file, "load.kind", table.kind, "expected 'valve', a load that the piston switches", remedy)
    assert parts.valve is not None
    contact = parts.contact or parts.contact_of_blow(tables)
    try:
        if parts.bar is None:
            assert parts.body is not None
            machine = Machine(parts.body, parts.valve, contact, at=table.at)
        else:
            machine = Machine.from_si(parts.bar, parts.valve, contact, at=table.at, pressure=pressure_of(table))
    except ParameterError as error:
        raise from_parameter(error, file, "load", {}) from None
    except ArithmeticError:
        raise extreme(file, "") from None
    _check_scale(machine, file)
    return machine


_LEAST, _MOST = 1e-9, 1e12
"""Of dimensionless sizes: no machine is beyond, where a flight of no end would be followed for long."""


def _check_scale(machine: Machine, file: str) -> None:
    """Refuse sizes so far from each other that they are a slip of units."""
    valve = machine.valve
    sizes = {"load.states": max(abs(force) for _, force in valve.pairs), "load.chamber.force": abs(valve.chamber.force)}
    sizes["load.chamber.stiffness"] = valve.chamber.stiffness
    if valve.supply is not None:
        sizes |= {"load.supply.flow": valve.supply.flow, "load.supply.accumulator": valve.supply.compliance}
    for i, port in enumerate(valve.ports):
        sizes |= {f"load.ports[{i}].behind": port.behind or 0.0, f"load.ports[{i}].delay": port.delay}
    for key, size in sizes.items():
        if size > _MOST or (0.0 < size < _LEAST and not key.endswith("delay")):
            what = "a size with a bar length, its mass and the unit of time as 1"
            accepted = f"expected {what}, from {_LEAST:g} to {_MOST:g}; it is {size:.4g}"
            raise CaseError(file, key, None, accepted, "check the units of length, force and time")
