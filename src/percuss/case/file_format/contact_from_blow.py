"""The contact of a case by one blow resolved by waves: its restitution, its duration, how far the tool moves on."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING, NamedTuple

from percuss.case.file_format.schema import ContactTable, SystemTable
from percuss.case.file_format.tool_building import BlowQuestion
from percuss.errors import ParameterError
from percuss.model.contact import Timed

if TYPE_CHECKING:
    from percuss.blow import Rod, Wall
    from percuss.model import System
    from percuss.model.body import Body, SizedBody

__all__ = ["OneBlow", "blow_note", "blow_of", "restitution_of", "timed_law"]

_SPENT = 1e-9
"""A restitution that is as good as 0: the bar has given its momentum away."""

_FORWARD = (
    "a bar of greater impedance than the tool's goes on after the blow and strikes again and again: make the tool "
    "thicker or the bar thinner, or give a number from 0 to 1"
)


class OneBlow(NamedTuple):
    """What a contact law is made of: in SI, or in the scales of a dimensionless bar.

    Attributes
    ----------
    restitution
        −(mean velocity after)/(mean velocity before).
    duration, force_centroid
        Times from the start of the first contact to the end of the last one, and to the centroid of the force; the
        duration is None where the contact outlasts the window.
    residual_per_impulse
        Penetration that the rock does not give back, per impulse.
    ringing_share
        Energy of the ringing that stays in the bar, per energy before the blow.
    contacts
        How many contacts it has.
    outcome
        How its window ended, in words.
    is_over
        Whether nothing speaks for another contact.
    """

    restitution: float
    duration: float | None
    force_centroid: float
    residual_per_impulse: float
    ringing_share: float
    contacts: int
    outcome: str
    is_over: bool


def blow_of(question: BlowQuestion) -> OneBlow:
    """The blow of a bar on its tool, without a load.

    Its contacts and its restitution do not depend on the speed, unless there is a gap in front of the rock. The window
    ends with `until`, where that is given. A blow that was computed before is remembered.

    Raises
    ------
    ParameterError
        By a key of [contact], for a gap in front of the rock and no speed in [blow].
    """
    rock = getattr(question.target, "rock", None)
    velocity: float | tuple[float, ...] | None = 1.0
    if rock is not None and rock.gap > 0.0:
        velocity = question.velocity
    if velocity is None:
        remedy = 'for example velocity = "10 m/s"; without the gap one blow serves all speeds'
        accepted = "a velocity in [blow] beside the gap of [rock], as the blow depends on its speed"
        raise ParameterError("restitution", None, accepted, remedy)
    return _blow(question.striker, question.target, velocity, question.until)


@lru_cache(maxsize=64)
def _blow(
    striker: SizedBody | Body, target: Rod | Wall, velocity: float | tuple[float, ...], until: float | None
) -> OneBlow:
    from percuss.blow import Outcome, strike

    found = strike(striker, target, velocity, until=until)
    restitution, centroid = found.effective_restitution, found.force_centroid
    if restitution is None or centroid is None:
        remedy = "check the velocity in [blow] and the gap of [tool]"
        raise ParameterError("restitution", None, "a blow of a bar that reaches the tool", remedy)
    residual = found.residual_penetration or 0.0
    return OneBlow(
        restitution,
        None if found.contacts[-1].end is None else found.contact_duration,
        centroid,
        residual / found.impulse,
        found.vibration_energy_after / found.kinetic_energy_before,
        len(found.contacts),
        found.outcome.value,
        found.outcome in (Outcome.OVER, Outcome.SPENT, Outcome.WINDOW_ENDED),
    )


def restitution_of(blow: OneBlow) -> float:
    """The restitution of a blow as B77's law takes it.

    Raises
    ------
    ParameterError
        For one that is none of a rebound.
    """
    if not blow.is_over:
        accepted = f"a blow that is over; {blow.outcome}"
        raise ParameterError("restitution", None, accepted, "give a later end: until in [blow]")
    if abs(blow.restitution) <= _SPENT:
        return 0.0
    if not 0.0 <= blow.restitution <= 1.0:
        accepted = f"a blow with a restitution from 0 to 1; that on this tool has R = {blow.restitution:.4g}"
        raise ParameterError("restitution", None, accepted, _FORWARD)
    return blow.restitution


def blow_note(blow: OneBlow) -> str:
    """What is to be known of a restitution that is that of a blow, one sentence."""
    several = "one contact" if blow.contacts == 1 else f"{blow.contacts} contacts"
    share = f"{100.0 * blow.ringing_share:.2g} % of the energy stays in the bar as ringing"
    return f"R = {blow.restitution:.4g} is that of the blow on the tool, resolved by waves: {several}; {share}"


def timed_law(table: ContactTable | SystemTable, question: BlowQuestion, system: System) -> Timed | None:
    """The law of a blow that takes time, as the table names it; None for B77's.

    Raises
    ------
    ParameterError
        By the key of the table.
    """
    if table.law == "b77-tau":
        advance = table.advance or "kept"
        if advance == "residual penetration":
            raise ParameterError("advance", advance, '"kept" or "pushed back" beside the law b77-tau', _LAW_OF_ROCK)
        return Timed.of_uniform_bar(system.s, system.restitution, advance)
    if table.law != "b77-blow":
        return None
    blow = blow_of(question)
    if blow.duration is None:
        raise ParameterError("law", table.law, f"a contact that ends; here {blow.outcome}", _FORWARD)
    time, mass = (1.0, 1.0) if system.bar is None else (system.time_scale, system.bar.mass)
    return Timed(
        restitution_of(blow),
        blow.duration / time,
        min(blow.force_centroid, blow.duration) / time,
        _advance(table, question.target, blow) * mass / time,
        min(blow.ringing_share, 1.0),
        blow.contacts,
    )


_LAW_OF_ROCK = 'the penetration is known to law = "b77-blow"'


def _advance(table: ContactTable | SystemTable, target: Rod | Wall, blow: OneBlow) -> float:
    """Advance of the tool per impulse, in the units of the blow."""
    from percuss.blow import Wall

    end = "wall" if isinstance(target, Wall) else target.end
    usual = {"rock": "residual penetration", "infinite": "kept"}.get(end, "pushed back")
    advance = table.advance or usual
    if advance == "pushed back":
        return 0.0
    if advance != usual:
        where = {"wall": "a wall", "rock": "a rod on rock", "infinite": "an endless rod"}.get(
            end, f"a rod with a {end} end"
        )
        accepted = f'"{usual}"' if usual == "pushed back" else f'"{usual}" or "pushed back"'
        raise ParameterError("advance", advance, f"{accepted} of {where}")
    if advance == "residual penetration":
        return blow.residual_per_impulse
    assert not isinstance(target, Wall)
    return 1.0 / (target.pieces[-1].impedance if target.pieces else target.face_impedance)
