"""The hammers that experiments follow, from systems and machines, and from archives."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from percuss.errors import ParameterError
from percuss.explore.attractors.clocked_hammer import ClockedHammer
from percuss.explore.attractors.switching_hammer import SwitchingHammer
from percuss.model import Machine, System
from percuss.model.described import machine_from, system_from

if TYPE_CHECKING:
    from percuss.explore.attractors.hammer import Hammer

__all__ = ["hammer_from", "hammer_of"]


def hammer_of(what: System | Machine) -> Hammer:
    """A system or a machine as an experiment asks it.

    Raises
    ------
    ParameterError
        For anything else.
    """
    if isinstance(what, System):
        return ClockedHammer(what)
    if isinstance(what, Machine):
        return SwitchingHammer(what)
    raise ParameterError("system", what, "a System, or a Machine that switches its own valve")


def hammer_from(ask: Mapping[str, Any]) -> System | Machine:
    """The system or machine that was asked for in an archive."""
    return machine_from(ask["machine"]) if "machine" in ask else system_from(ask["system"])
