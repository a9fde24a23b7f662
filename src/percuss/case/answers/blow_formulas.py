"""What formulas say of a blow beside what its waves gave, and what the theory of such waves leaves out."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

from percuss.case.answers.numerals import number, percent, quantity
from percuss.errors import ParameterError

if TYPE_CHECKING:
    from percuss.case.answers.told_blow import ToldBlow

__all__ = ["Formula", "formulas", "left_out"]

_ALIKE = 1e-9
"""Relative difference of two impedances, or two times, that counts as none."""


class Formula(NamedTuple):
    """A closed form that applies: its name, and what it says beside what the waves gave."""

    name: str
    text: str
    value: float
    found: float


def formulas(answer: ToldBlow) -> tuple[Formula, ...]:
    """The closed forms that apply to a blow; none under a load, or where sections have different speeds."""
    from percuss.blow.striker import striker_sections

    blow = answer.blow
    alike = blow.velocity is not None and bool((blow.velocity == blow.velocity[0]).all())
    if not alike or blow.load_work != 0.0 or not blow.contacts:
        return ()
    z, tau = striker_sections(blow.striker).impedance, striker_sections(blow.striker).transit
    if z.size == 1:
        return _of_uniform(answer, float(z[0]), float(tau[0]))
    if z.size == 2 and answer.rod is None and abs(tau[0] - tau[1]) <= _ALIKE * tau[0]:
        return _of_two(answer, float(z[0]), float(z[1]))
    return ()


def _of_uniform(answer: ToldBlow, z: float, tau: float) -> tuple[Formula, ...]:
    """A uniform striker on a wall, on an endless rod (St Venant 1867), on a bit in rock (Lundberg 1973)."""
    from percuss.blow.closed_forms import uniform_blow

    blow, rod = answer.blow, answer.rod
    speed, force = blow.mean_velocity_before, blow.contacts[0].peak_force
    if not speed > 0.0:
        return ()
    z2 = math.inf if rod is None else blow.waves_at(0.0).impedance
    known = uniform_blow(z, tau, speed, z2)
    found = [
        Formula("first step", _beside(answer.units.force(known.force), answer.units.force(force)), known.force, force)
    ]
    lasts = blow.contacts[0].end
    if known.restitution >= 0.0 and lasts is not None and _reaches_nothing(answer):
        took = lasts - blow.contacts[0].start
        said = f"2τ = {answer.units.time(known.duration)}"
        found.append(Formula("contact", _beside(said, answer.units.time(took)), known.duration, took))
        value, of_waves = known.restitution, blow.effective_restitution or 0.0
        said = "R = (Z₂ − Z₁)/(Z₂ + Z₁) = " + number(value, 6) if rod is not None else "R = 1"
        found.append(Formula("restitution", _beside(said, number(of_waves, 6)), value, of_waves))
    if known.restitution < 0.0 and _reaches_nothing(answer):
        said = f"each step of 2τ leaves {percent(-known.restitution)} of the speed: the striker stays on the rod"
        found.append(Formula("staircase", said, -known.restitution, -known.restitution))
    matched = abs(z - z2) <= _ALIKE * z
    if matched and rod is not None and rod.rock is not None and rod.bit_mass == 0.0 and len(rod.pieces) == 1:
        found += _on_rock(answer, z, tau)
    return tuple(found)


def _reaches_nothing(answer: ToldBlow) -> bool:
    """Whether nothing comes back from the far end of what is struck."""
    return answer.rod is None or (answer.rod.end == "infinite" and len(answer.rod.sections) <= 1)


def _on_rock(answer: ToldBlow, z: float, tau: float) -> list[Formula]:
    """One rectangular wave on a bit without mass: β = K₁ T/Z, T = 2τ (Lundberg 1973)."""
    from percuss.blow.closed_forms import BEST_BETA, best_efficiency, matched_efficiency

    rod, blow = answer.rod, answer.blow
    assert rod is not None and rod.rock is not None
    beta, gamma = 2.0 * tau * rod.rock.stiffness / z, rod.rock.unloading_ratio
    one, best = matched_efficiency(beta, gamma), matched_efficiency(BEST_BETA, gamma)
    wave, done = best_efficiency(beta, gamma), blow.rock_dissipated / blow.energy_before
    said = f"2(1 − γ)(1 − e^−β)²/β = {percent(one, 4)} at β = {number(beta)}"
    return [
        Formula("Lundberg 1973", f"{_beside(said, percent(done, 4))}, later waves included", one, done),
        Formula("best β", f"{number(BEST_BETA)} gives {percent(best, 4)} with a rectangular wave", best, done),
        Formula("best wave", f"one that rises as e^(K₁t/Z) gives {percent(wave, 4)} at this β", wave, done),
    ]


def _of_two(answer: ToldBlow, rear: float, head: float) -> tuple[Formula, ...]:
    """Two sections of equal transit time on a wall: R = 1 − 2ρ²."""
    from percuss.blow.closed_forms import two_section_restitution

    try:
        value = two_section_restitution(rear, head)
    except ParameterError:  # the blow has another course
        return ()
    found = answer.blow.effective_restitution or 0.0
    said = f"R = 1 − 2ρ² = {number(value, 6)} with ρ = (Z₁ − Z₂)/(Z₁ + Z₂)"
    return (Formula("two sections", _beside(said, number(found, 6)), value, found),)


def _beside(said: str, found: str) -> str:
    return f"{said}; the waves give {found}"


# -- what is left out -------------------------------------------------------------------------------------------------


def left_out(answer: ToldBlow) -> tuple[tuple[str, str], ...]:
    """What the theory leaves out, with its own numbers; nothing for a dimensionless bar."""
    own, rod = answer.pieces
    if not own:
        return ()
    widest = max((*own, *rod), key=lambda piece: piece.diameter)
    speed = math.sqrt(widest.youngs_modulus / widest.density)
    cross = widest.diameter / speed
    rows = [
        (
            "rise",
            f"a wave takes {quantity(cross, 's', 3)} across the widest section, {quantity(widest.diameter, 'm')}: "
            "steps of the force rise over about that time, and ripples follow them (Pochhammer and Chree)",
        )
    ]
    pulse = answer.blow.first_pulse
    if pulse is not None and math.isfinite(pulse.length):
        ratio = pulse.length / cross
        rows.append(("pulse", f"{number(ratio, 2)} times as long as that" + ("" if ratio > 10.0 else ": short for it")))
    first = own[-1]
    stress = 0.5 * math.sqrt(first.youngs_modulus * first.density) * abs(answer.blow.mean_velocity_before)
    rows.append(
        (
            "yield",
            f"ρ c v/2 = {quantity(stress, 'Pa', 3)} is the stress of the head on a rod like it; beyond the yield "
            "stress of the faces, and where they are crowned, contact is no longer elastic and flat",
        )
    )
    return tuple(rows)
