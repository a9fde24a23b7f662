"""One machine from several of its records: cycles of different speeds tell its ports from its delays."""

from __future__ import annotations

import math
from dataclasses import replace

from percuss.errors import ParameterError
from percuss.model.checks import instance, positive
from percuss.steady.recorded.machines_read import machine_read
from percuss.steady.recorded.port_and_delay import port_and_delay
from percuss.steady.recorded.recorded_valve import RecordedValve

__all__ = ["recorded_together"]


def recorded_together(
    first: RecordedValve, *others: RecordedValve, longest_delay: float | None = None
) -> RecordedValve:
    """The reading of the first record, with ports and delays that all records tell together.

    Ports and delays belong to the machine, forces and speeds to each record, at another pressure or with another feed
    force. The records must be in SI, so that their units are the same, and the blows of all must have been measured.

    Parameters
    ----------
    first
        Its forces, its contact and its notes are kept.
    others
        Readings of other records of the same machine.
    longest_delay
        The longest delay that the valve may have (s).

    Raises
    ------
    ParameterError
        When there are no others, one is dimensionless, or they switch in another order.
    """
    longest = math.inf if longest_delay is None else positive("longest_delay", longest_delay)
    read = (instance("first", first, RecordedValve), *(instance("others", one, RecordedValve) for one in others))
    if not others:
        raise ParameterError("others", "none", "one or more readings of other records of the same machine")
    for one in read:
        if not one.system.is_si:
            raise ParameterError("record", "dimensionless", "readings in SI, whose seconds and metres are the same")
        if one.system.length_scale != first.system.length_scale:
            raise ParameterError("record", "another body", "records of one machine")
        if [switch.to for switch in one.switches] != [switch.to for switch in first.switches]:
            raise ParameterError("record", [switch.to for switch in one.switches], "the same switches in each record")
    switches = tuple(
        replace(switch, found=port_and_delay(seen, longest), seen=seen)
        for switch, *same in zip(*(one.switches for one in read), strict=True)
        for seen in [tuple(one for switch_ in (switch, *same) for one in switch_.seen)]
    )
    delays = [switch.best_delay for switch in switches]
    machine = machine_read(
        first.system, first.machine.contact, list(first.forces), first.stiffness.value, switches, delays
    )
    return replace(first, switches=switches, machine=machine, cycles=sum(one.cycles for one in read))
