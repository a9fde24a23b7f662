"""The law of the waves in a uniform bar: velocity and strain turn over together at the impact."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from percuss.errors import ParameterError
from percuss.model.body.body import Body
from percuss.model.contact.contact import Contact, Result

__all__ = ["Reversed"]


@dataclass(frozen=True, init=False)
class Reversed(Contact):
    """u_t → −R u_t and u_x → −R u_x along the whole bar: what a round trip of the waves does. For uniform bars.

    While a uniform bar on a rod or a wall lets its waves run out and back once, each of them comes back −R times
    itself, velocity and strain alike. Phases and speeds of the steady motions differ from B77's at second order in the
    elastic motion only; every elastic multiplier has the modulus R e^{−d_n T/2}.

    Examples
    --------
    >>> print(Reversed(0.25))
    Reversed: restitution R = 0.25
    """

    kind: ClassVar[str] = "reversed"
    sentence: ClassVar[str] = "the impact turns velocity and strain over, as the waves in a uniform bar do"
    results: ClassVar[frozenset[Result]] = frozenset({Result.LEVEL, Result.REDUCED, Result.WAVEFORM})

    @property
    def strain_factor(self) -> float:
        return -self.restitution

    def check(self, body: Body) -> None:
        """Uniform bars only: a step sends back a part of a wave before it has met the far end.

        Raises
        ------
        ParameterError
            For any other body.
        """
        if body.kind != "uniform":
            remedy = 'take the law that keeps the strain: strain = "kept"'
            raise ParameterError("strain", "reversed", "a uniform bar for the law that reverses the strain", remedy)
