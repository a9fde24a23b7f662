"""The contact of a case by one blow resolved by waves: its restitution, its duration, how far the tool moves on."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from percuss.case.file_format.schema import ContactTable, SystemTable
from percuss.case.file_format.tool_building import BlowQuestion
from percuss.errors import ParameterError
from percuss.model.contact import Timed

if TYPE_CHECKING:
    from percuss.blow import EffectiveBlow, Rod, Wall
    from percuss.model import System

__all__ = ["blow_note", "blow_of", "law_note", "restitution_of", "timed_law"]

_SPENT = 1e-9
"""A restitution that is as good as 0: the bar has given its momentum away."""

_FORWARD = (
    "a bar of greater impedance than the tool's goes on after the blow and presses or strikes it again and again, in "
    "steps that on an endless tool never end: make the tool "
    "thicker or the bar thinner, or give a number from 0 to 1"
)


def blow_of(question: BlowQuestion) -> EffectiveBlow:
    """The blow of a bar on its tool, without a load; one that was computed before is remembered.

    Its contacts and its restitution do not depend on the speed, unless there is a gap in front of the rock. The window
    ends with `until`, where that is given.

    Raises
    ------
    ParameterError
        By a key of [contact], for a gap in front of the rock and no speed in [blow].
    """
    from percuss.blow import effective_blow

    rock = getattr(question.target, "rock", None)
    velocity = 1.0 if rock is None or rock.gap == 0.0 else question.velocity
    if not isinstance(velocity, float):
        remedy = 'for example velocity = "10 m/s"; without the gap one blow serves all speeds'
        accepted = "a velocity in [blow] beside the gap of [rock], as the blow depends on its speed"
        raise ParameterError("restitution", None, accepted, remedy)
    found = effective_blow(question.striker, question.target, velocity, until=question.until)
    if not found.contacts:
        remedy = "check the gap of [tool] and until in [blow]"
        raise ParameterError("restitution", None, "a blow of a bar that reaches the tool", remedy)
    return found


def restitution_of(question: BlowQuestion) -> float:
    """The restitution of a blow as B77's law takes it.

    Raises
    ------
    ParameterError
        For one that is none of a rebound, and of a blow that is not over.
    """
    from percuss.blow import Outcome

    blow = blow_of(question)
    if abs(blow.restitution) <= _SPENT:
        return 0.0
    usual = 0.0 <= blow.restitution <= 1.0
    if not usual and blow.outcome is Outcome.STILL_IN_CONTACT and question.until is None:
        accepted = f"a blow with a restitution from 0 to 1; on this tool R is {blow.restitution:.4g} so far"
        raise ParameterError("restitution", None, accepted, _FORWARD)
    if blow.outcome in (Outcome.STILL_IN_CONTACT, Outcome.GAP_CLOSING):
        accepted = f"a blow that is over; {blow.outcome.value}"
        raise ParameterError("restitution", None, accepted, "give a later end: until in [blow]")
    if not usual:
        accepted = f"a blow with a restitution from 0 to 1; that on this tool has R = {blow.restitution:.4g}"
        raise ParameterError("restitution", None, accepted, _FORWARD)
    return blow.restitution


def blow_note(blow: EffectiveBlow, question: BlowQuestion) -> str:
    """What is to be known of a restitution that is that of a blow, one sentence."""
    several = "one contact" if blow.contacts == 1 else f"{blow.contacts} contacts"
    share = f"{100.0 * blow.ringing:.2g} % of the energy stays in the bar as ringing"
    text = f"R = {blow.restitution:.4g} is that of the blow on the tool, resolved by waves: {several}; {share}"
    rock = getattr(question.target, "rock", None)
    if rock is None or rock.gap == 0.0:
        return text
    return f"{text}; it is that of the velocity in [blow], as the gap in front of the rock makes it depend on the speed"


def law_note(table: ContactTable | SystemTable | None) -> str:
    """Where a law of blows that take time counts and where it does not, one sentence; "" without one."""
    if table is None or table.law in (None, "b77"):
        return ""
    return (
        f"law {table.law}: steady motions have its phases and multipliers beside those of B77's impact; simulations, "
        "maps and boundaries have B77's impact with the same restitution"
    )


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
    if blow.duration is None or blow.centroid is None:
        accepted = f"a contact that ends; here {blow.outcome.value}"
        raise ParameterError("law", table.law, accepted, _FORWARD)
    time = 1.0 if system.bar is None else system.time_scale
    law = Timed(
        restitution_of(question),
        blow.duration / time,
        min(blow.centroid, blow.duration) / time,
        ringing_share=min(blow.ringing, 1.0),
        contacts=blow.contacts,
    )
    return replace(law, advance_per_impulse=_advance(table, question.target, blow) / time / law.impulse(1.0, 0.0))


_LAW_OF_ROCK = 'the penetration is known to law = "b77-blow"'


def _advance(table: ContactTable | SystemTable, target: Rod | Wall, blow: EffectiveBlow) -> float:
    """Advance of the tool per speed of the bar, in the unit of time of the blow."""
    from percuss.blow import Wall

    end = "wall" if isinstance(target, Wall) else target.end
    usual = {"rock": "residual penetration", "infinite": "kept"}.get(end, "pushed back")
    advance = table.advance or usual
    if advance not in (usual, "pushed back"):
        where = {"wall": "a wall", "rock": "a rod on rock", "infinite": "an endless rod"}
        accepted = f'"{usual}"' if usual == "pushed back" else f'"{usual}" or "pushed back"'
        raise ParameterError("advance", advance, f"{accepted} of {where.get(end, f'a rod with a {end} end')}")
    return 0.0 if advance == "pushed back" else blow.advance
