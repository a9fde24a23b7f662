"""The ground floor: body, load and contact, and the system that joins them."""

from __future__ import annotations

from typing import TYPE_CHECKING

from percuss.lazy_names import lazy_names

if TYPE_CHECKING:
    from percuss.model.body import (
        UNDAMPED,
        Bar,
        Body,
        Damping,
        External,
        HeldBody,
        KelvinVoigt,
        ModalBody,
        Modes,
        Mounted,
        Ratio,
        Section,
        SectionedBar,
        Shape,
        SizedBody,
        SizedModes,
        SteppedBar,
        Table,
        UniformBar,
    )
    from percuss.model.contact import Contact, Kept, Result, Reversed, Timed
    from percuss.model.load import (
        Chamber,
        Cushion,
        GasAccumulator,
        Join,
        Jump,
        Load,
        Oil,
        OilChamber,
        Port,
        Relief,
        Supply,
        Valve,
    )
    from percuss.model.machine import Machine, MachineModes
    from percuss.model.system import System

__all__, __getattr__, __dir__ = lazy_names(__name__, __file__)
