"""Contact laws: how a body leaves the wall. `Contact` says what one is; each law is a file."""

from percuss.model.contact.contact import Contact, Result
from percuss.model.contact.kept import Kept
from percuss.model.contact.restitution import impedance_ratio, restitution_of_ratio, restitutions
from percuss.model.contact.reversed import Reversed

__all__ = [
    "LAWS",
    "Contact",
    "Kept",
    "Result",
    "Reversed",
    "impedance_ratio",
    "restitution_of_ratio",
    "restitutions",
]

LAWS: dict[str, type[Contact]] = {law.kind: law for law in (Kept, Reversed)}
"""The laws by their word in case files."""
