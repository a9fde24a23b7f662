"""The law of the waves in a uniform bar: velocity and strain turn over together at the impact."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from percuss.errors import ParameterError
from percuss.model.body.body import Body
from percuss.model.contact.contact import Contact, Result


@dataclass(frozen=True, init=False)
class Reversed(Contact):
    """u_t → −R u_t and u_x → −R u_x along the whole bar: what a round trip of the waves does. For uniform bars.

    While a uniform bar on a rod or a wall lets its waves run out and back once, each of them comes back −R times
    itself, velocity and strain alike. Phases and speeds of the steady motions differ from B77's at second order in the
    elastic motion only.

    The multipliers of the elastic modes are −R e^{−d_n T/2 ± iλ_n T}, moved by the load alone, and by p(φ)/W beside ω_n
    only. With the same damping for all modes and the rigid motion they stay on the circle of the modulus R e^{−dT/2},
    until two of them, or one of them and one of the rigid motion, meet on it; such a pair leaves it for two places
    mirrored in it, for a fast wave by some per cent of R.

    Of B77's criterion of stability the limit s → ∞ holds, which is that of the rigid bar, and so does that of the
    waveform; its feedback σ does not. There the elastic modes act on the two multipliers of the rigid motion at second
    order in 1/s, as their velocities at the impact; here at first order, by Σ γ_n b_n/(μ² + R t_n μ + R² E_n), which
    follows the fraction of a swing that the modes are in at the impact and is no quadratic in μ.

    Examples
    --------
    >>> print(Reversed(0.25))
    Reversed: restitution R = 0.25
    """

    kind: ClassVar[str] = "reversed"
    sentence: ClassVar[str] = "the impact turns velocity and strain over, as the waves in a uniform bar do"
    results: ClassVar[frozenset[Result]] = frozenset(Result) - {Result.FEEDBACK}

    @property
    def strain_factor(self) -> float:
        return -self.restitution

    def check(self, body: Body) -> None:
        """Bars that send no wave back inside them: a step returns a part of one before it has met the far end.

        ParameterError for a body whose impedance is not the same all along.
        """
        if not body.is_harmonic:
            remedy = 'take the law that keeps the strain: strain = "kept"'
            raise ParameterError("strain", "reversed", "a uniform bar for the law that reverses the strain", remedy)
