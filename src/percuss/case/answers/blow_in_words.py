"""A blow in one sentence: where its energy went."""

from __future__ import annotations

from typing import TYPE_CHECKING

from percuss.case.answers.numerals import counted, number, percent

if TYPE_CHECKING:
    from percuss.case.answers.told_blow import ToldBlow

__all__ = ["blow_in_words"]

_NEGLIGIBLE = 1e-3
"""Share of the energy that is not worth a clause."""


def blow_in_words(answer: ToldBlow) -> str:
    """What one blow does, the first line of its report.

    Examples
    --------
    >>> from percuss.case import blow_answer, load_case
    >>> blow_in_words(blow_answer(load_case("laboratory-striker"))).split(" puts ")[0]
    'A blow of 29.8 J at 10 m/s'
    """
    blow = answer.blow
    before = blow.energy_before
    head = f"A blow of {answer.units.energy(before, 3)} at {answer.units.speed(blow.mean_velocity_before, 3)}"
    if not blow.contacts:
        return f"{head} does not reach the target in {answer.units.time(blow.until, 3)}."
    clauses = [_given(answer, before)]
    if blow.rigid_energy_after > _NEGLIGIBLE * before:
        way = "come back" if blow.mean_velocity_after < 0.0 else "stay"
        clauses.append(f"{answer.units.energy(blow.rigid_energy_after, 3)} {way} with the striker")
    if blow.vibration_energy_after > _NEGLIGIBLE * before:
        clauses.append(f"{answer.units.energy(blow.vibration_energy_after, 3)} ring in it")
    left = blow.rod_energy + blow.bit_kinetic_energy_after
    if blow.penetration is not None and left > _NEGLIGIBLE * before:
        clauses.append(f"{answer.units.energy(left, 3)} stay in the rod")
    sentence = f"{head} {clauses[0]}" + "".join(f"; {clause}" for clause in clauses[1:])
    return f"{sentence}; {_stress(answer)}{_how_often(answer)}."


def _given(answer: ToldBlow, before: float) -> str:
    blow = answer.blow

    def share(value: float) -> str:
        return f"{answer.units.energy(value, 3)}" + (f" ({percent(value / before)})" if before > 0.0 else "")

    if blow.penetration is not None:
        return f"puts {share(blow.rock_work)} into the rock"
    if answer.rod is not None:
        return f"puts {share(blow.work_through_face)} into the rod"
    return f"gives nothing to the wall: R = {number(blow.effective_restitution or 0.0)}"


def _stress(answer: ToldBlow) -> str:
    own = answer.peaks[0]
    name = "head" if len(own) > 1 else "striker"
    return f"the {name} sees {answer.units.stress(own[-1].compression, 3)}"


def _how_often(answer: ToldBlow) -> str:
    contacts = len(answer.blow.contacts)
    return "" if contacts == 1 else f", in {counted(contacts, 'contact')}"
