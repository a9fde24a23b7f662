"""What the instantaneous laws need of a blow: restitution, duration, force centroid, advance; computed once, kept."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

from percuss.blow.blow import Blow
from percuss.blow.parts import Outcome
from percuss.blow.striker import Striker, striker_sections
from percuss.blow.striking import strike
from percuss.blow.target import Rod, Target, Wall
from percuss.errors import ConvergenceError, ParameterError
from percuss.model.checks import positive

__all__ = ["EffectiveBlow", "effective_blow"]


@dataclass(frozen=True)
class EffectiveBlow:
    """One load-free blow of a striker without stress, by the few numbers that a law of contact needs.

    Parameters
    ----------
    restitution
        R_eff = −V_1/V_0; below 0 where the striker goes on.
    duration, centroid
        t_c and t_J from the start of the first contact; None where the contact never ends.
    advance
        How far the plane of impact moves in the blow, per speed of the striker, in s: J/Z of an endless rod that stays
        where it is left, the residual penetration of a rod on rock, 0 of a wall and of any other rod, which is pushed
        back.
    ringing
        Share of the energy before that rings in the striker afterwards.
    contacts
        How many there were.
    outcome
        How the window ended.
    """

    restitution: float
    duration: float | None
    centroid: float | None
    advance: float
    ringing: float
    contacts: int
    outcome: Outcome


def effective_blow(
    striker: Striker, target: Target, velocity: float = 1.0, *, until: float | None = None
) -> EffectiveBlow:
    """The blow of a striker on a target from rest, with the last 256 questions kept.

    Without gaps no time and no ratio depends on the velocity; the rock's law is homogeneous as well. The window ends as
    that of `strike` does, or with `until`.

    Raises
    ------
    ParameterError
        For anything that `strike` refuses.
    ConvergenceError
        When the blow has too many pieces of waves to be followed.

    Examples
    --------
    >>> from percuss.blow import Rod
    >>> from percuss.model import UniformBar
    >>> found = effective_blow(UniformBar(20.0), Rod.of_impedance(80.0))
    >>> round(found.restitution, 12), round(found.duration, 12), round(found.centroid, 12)
    (0.6, 0.1, 0.05)
    """
    striker_sections(striker)
    if not isinstance(target, Wall | Rod):
        raise ParameterError("target", target, "a Wall or a Rod")
    end = None if until is None else positive("until", until)
    return _known(striker, target, positive("velocity", velocity), end)


@lru_cache(maxsize=256)
def _known(striker: Striker, target: Target, velocity: float, until: float | None) -> EffectiveBlow:
    blow = strike(striker, target, velocity, until=until)
    if blow.outcome is Outcome.TOO_MANY_PIECES:
        raise ConvergenceError("the waves of this blow have too many pieces", "leave the shortest sections out")
    return EffectiveBlow(
        restitution=float(blow.effective_restitution or 0.0),
        duration=blow.contact_duration,
        centroid=blow.force_centroid,
        advance=_advance(blow) / velocity,
        ringing=blow.vibration_energy_after / blow.energy_before,
        contacts=len(blow.contacts),
        outcome=blow.outcome,
    )


def _advance(blow: Blow) -> float:
    if blow.residual_penetration is not None:
        return blow.residual_penetration
    if isinstance(blow.target, Rod) and blow.target.end == "infinite":
        return blow.impulse / blow.target.end_impedance
    return 0.0
