"""The ground floor: body, load and contact, and the system that joins them."""

from percuss.model.body import (
    UNDAMPED,
    Bar,
    Body,
    Damping,
    External,
    KelvinVoigt,
    Modes,
    Ratio,
    Section,
    SectionedBar,
    Shape,
    SizedBody,
    SteppedBar,
    Table,
    UniformBar,
)
from percuss.model.contact import Contact, Kept, Result, Reversed, Timed
from percuss.model.load import Chamber, Cushion, Jump, Load, Port, Supply, Valve
from percuss.model.machine import Machine
from percuss.model.machine_modes import MachineModes
from percuss.model.system import System

__all__ = [
    "UNDAMPED",
    "Bar",
    "Body",
    "Chamber",
    "Contact",
    "Cushion",
    "Damping",
    "External",
    "Jump",
    "KelvinVoigt",
    "Kept",
    "Load",
    "Machine",
    "MachineModes",
    "Modes",
    "Port",
    "Ratio",
    "Result",
    "Reversed",
    "Section",
    "SectionedBar",
    "Shape",
    "SizedBody",
    "SteppedBar",
    "Supply",
    "System",
    "Table",
    "Timed",
    "UniformBar",
    "Valve",
]
