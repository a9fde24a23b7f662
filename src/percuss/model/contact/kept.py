"""B77's law: the velocity field turns over at the impact, the strain stays."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from percuss.model.contact.contact import Contact, Result


@dataclass(frozen=True, init=False)
class Kept(Contact):
    """u_t → −R u_t along the whole bar, and the displacement stays (B77 10). For any body.

    What it keeps can feed the elastic modes: multipliers of modulus greater than 1 that belong to them are a property
    of this law, not of bars, in which waves turn the strain over with the velocity (`Reversed`).

    Examples
    --------
    >>> print(Kept(0.25))
    Kept: restitution R = 0.25
    """

    kind: ClassVar[str] = "kept"
    sentence: ClassVar[str] = "the impact turns the velocity over and keeps the strain (B77)"
    results: ClassVar[frozenset[Result]] = frozenset(Result)
    elastic_growth: ClassVar[str] = (
        "that is a property of the contact law, which keeps the strain, not of bars: waves turn it over and die out"
    )

    @property
    def strain_factor(self) -> float:
        return 1.0
