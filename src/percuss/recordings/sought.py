"""What is looked for in a recording: forces and pressures of a load, or strains and stresses of a gauge."""

from __future__ import annotations

import re
from dataclasses import dataclass

__all__ = ["LOAD", "SOUGHT", "Sought"]


@dataclass(frozen=True)
class Sought:
    """The quantities that a column may be of, how such columns are called, and how messages speak of them.

    Parameters
    ----------
    dimensions
        Those of `percuss.units`, in the order in which a unit is tried.
    words
        What the heading of such a column begins with.
    named
        The quantities in a message.
    unit, heading
        A usual unit and a heading with it, for remedies.
    length
        How much of a record is needed besides samples, for a message.
    """

    dimensions: tuple[str, ...]
    words: re.Pattern[str]
    named: str
    unit: str
    heading: str
    length: str = ""

    @property
    def unit_remedy(self) -> str:
        """How to say what the unit is."""
        return f'give unit = "{self.unit}" (or "kN", …), or write it in the heading: "{self.heading} [{self.unit}]"'


LOAD = Sought(
    ("force", "pressure"),
    re.compile(
        r"(p|f|force|kraft|kraeften|druck|press\w*|pressure|tryck|pression|presion|paine|voima|fuerza|load|last)"
        r"(\d|\b|_)",
        re.IGNORECASE,
    ),
    "force or pressure",
    "bar",
    "pressure",
    ", over two whole cycles or more,",
)

_GAUGE = Sought(
    ("strain", "pressure", "force"),
    re.compile(
        r"(strain|stress|force|gauge|gage|eps|epsilon|ε|sigma|σ|dms|dehnung|spannung|kraft|töjning|tojning|spänning|"
        r"déformation|deformation|contrainte|f)(\d|\b|_)",
        re.IGNORECASE,
    ),
    "strain, stress or force",
    "µm/m",
    "strain",
)

SOUGHT = {"load": LOAD, "gauge": _GAUGE}
"""By the word that `read_recording` takes."""
