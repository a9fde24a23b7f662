"""The dispatcher's answer to "what does one blow of this hammer do?"."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

import numpy as np

from percuss.case.answers.blows.drilling_answer import Drilled, drilled_sections, said_first
from percuss.case.answers.blows.transfer import BlowFatigue, assumed, blow_fatigue
from percuss.case.answers.facts import (
    BAD,
    GOOD,
    PLAIN,
    Fact,
    Grid,
    Report,
    ReportSection,
    Teller,
    counted,
    figures,
    grid_of,
    number,
    percent,
    picked,
    plain,
    plain_of,
    quantity,
    rows_of,
    said,
)
from percuss.case.case import checked_case
from percuss.case.file_format.building import rigid_speed
from percuss.errors import CaseError, HistoryError, ParameterError, extra_package
from percuss.model.body import Body, SizedBody
from percuss.model.body.uniform import Piece
from percuss.model.checks import Array, choice, flag, instance, non_negative, positive
from percuss.short_repr import ShortRepr

if TYPE_CHECKING:
    from xarray import Dataset

    from percuss.blow import Blow, ContactInterval, GaugeWaves, Peak, Rod, Trace, Wall
    from percuss.blow.gauges import RecordFit
    from percuss.blow.striking import Field
    from percuss.case.case import Case
    from percuss.case.file_format.contact import BlowQuestion
    from percuss.recordings import Recording
    from percuss.steady import Orbit


# ---- One blow of a case, and what of it is told: the waves at a gauge, sections with their sizes, values with units


@dataclass(frozen=True)
class BlowAnswer(ShortRepr):
    """One blow of a case, resolved by waves.

    Attributes
    ----------
    name, title, notes
        The case as it was named, its title, and what was assumed, one sentence each.
    blow
        The blow: contacts, forces, energies, stresses.
    gauge
        Place on the rod, from the struck face, that waves are told of: m, or dimensionless a time of a wave; None
        where there is no rod.
    measured
        What a strain gauge measured there, laid over the blow; None without a record.
    fatigue
        Fatigue of striker and rod by blows like this one; None where it was not asked for.
    drilled
        What holds the tool, and blows that follow each other; None for a wall.
    """

    name: str
    title: str
    blow: Blow
    speed: str
    gauge: float | None
    notes: tuple[str, ...] = ()
    measured: MeasuredGauge | None = None
    fatigue: BlowFatigue | None = None
    drilled: Drilled | None = None

    @property
    def is_si(self) -> bool:
        """Whether the striker has sizes; else mass, length and angular frequency are 1."""
        return isinstance(self.blow.striker, SizedBody)

    @property
    def gauge_force(self) -> tuple[float, float] | None:
        """The greatest and the least force at the gauge, the preload with it."""
        return None if self.gauge is None else self.blow.force_range_at(self.gauge)

    @property
    def waves(self) -> GaugeWaves | None:
        """The waves at the gauge."""
        return None if self.gauge is None else self.blow.waves_at(self.gauge)

    @property
    def rod(self) -> Rod | None:
        """The rod that is struck; None for a wall."""
        from percuss.blow import Rod

        return self.blow.target if isinstance(self.blow.target, Rod) else None

    @property
    def beta(self) -> float | None:
        """β = K₁T/Z of the first pulse, T long, in the longest section of the rod (Lundberg 1973).

        None without rock, pulse or energy, and on elastic rock, which keeps nothing.
        """
        rod, pulse, before = self.rod, self.blow.first_pulse, self.blow.energy_before
        if rod is None or rod.rock is None or pulse is None or not before > 0.0 or rod.rock.unloading_ratio == 1.0:
            return None
        longest = max(rod.pieces, key=lambda piece: piece.end - piece.start)
        return rod.rock.stiffness * pulse.length / longest.impedance

    @property
    def pieces(self) -> tuple[tuple[Piece, ...], tuple[Piece, ...]]:
        """Sections of the striker and of the rod with their sizes; empty where these are not known."""
        rod = self.rod
        own = self.blow.striker.pieces if isinstance(self.blow.striker, SizedBody) else ()
        return own, () if rod is None or not own else rod.pieces

    @property
    def peaks(self) -> tuple[tuple[Peak, ...], tuple[Peak, ...]]:
        """The greatest stresses of the striker's sections, and of the rod's."""
        from percuss.blow.bodies import striker_sections

        own = striker_sections(self.blow.striker).impedance.size
        return self.blow.peaks[:own], self.blow.peaks[own:]

    @property
    def tell(self) -> Teller:
        """Says its values with their units."""
        return Teller(None, self.is_si)

    @cached_property
    def formulas(self) -> tuple[Formula, ...]:
        """The closed forms that apply to such a blow, with what the waves gave."""
        return _formulas(self)

    @cached_property
    def left_out(self) -> tuple[tuple[str, str], ...]:
        """What the theory of one-dimensional waves leaves out of this blow, with its numbers."""
        return _left_out(self)

    def to_json_dict(self) -> dict[str, Any]:
        """The answer in plain values, as `percuss blow --json` prints it: SI units, or the scales of the bar."""
        blow = self.blow
        told: dict[str, Any] = {
            "case": self.name,
            "title": self.title,
            "units": "SI" if self.is_si else "dimensionless",
            "notes": list(self.notes),
            "velocity": None if blow.velocity is None else blow.velocity.tolist(),
            "velocity_from": self.speed,
            "until": blow.until,
            "outcome": blow.outcome.name.lower(),
            "outcome_in_words": blow.outcome.value,
            "fineness": blow.fineness.name.lower(),
            "contacts": [[one.start, one.end, one.impulse, one.peak_force] for one in blow.contacts],
            "touches_without_impulse": blow.grazes,
            **plain_of(self, STRIKER),
            **(plain_of(self, ROD) if self.rod is not None else {}),
            **(plain_of(self, ROCK) if blow.penetration is not None else {}),
            **({} if self.drilled is None else self.drilled.to_json_dict()),
        }
        if self.measured is not None:
            told["measured"] = self.measured.to_json_dict()
        if self.rod is not None:
            told["gauge"] = plain_of(self, GAUGE)
        if self.fatigue is not None:
            told["fatigue"] = self.fatigue.to_json_dict()
        return plain(told | _stress_dict(self))


# ---- One blow in plain values


def _share(name: str, more: str = "") -> Callable[[BlowAnswer, Teller], str]:
    """An energy, and what part it is of all that there was."""

    def words(answer: BlowAnswer, tell: Teller) -> str:
        blow, value = answer.blow, getattr(answer.blow, name)
        before = blow.energy_before + max(blow.load_work, 0.0)
        told = f"{tell(value, 'energy')} ({percent(value / before)})" if before > 0.0 else tell(value, "energy")
        return f"{told}, at {tell(getattr(blow, more), 'speed')}" if more else told

    return words


STRIKER: tuple[Fact[BlowAnswer], ...] = (
    Fact("energy_before", "before", "energy of the striker before the blow", "energy", "blow.energy_before"),
    Fact("load_work", "work of the load", "work of the load", "energy", "blow.load_work",
         lambda one, tell: tell(one.blow.load_work, "energy") if one.blow.load_work else None),
    Fact("work_through_face", "through the face",
         r"$\int N\,v\,dt$ of the rod's face: what the blow delivers; 0 for a wall", "energy",
         "blow.work_through_face", _share("work_through_face")),
    Fact("rigid_energy_after", "with the striker", r"$\frac12MV_1^2$", "energy", "blow.rigid_energy_after",
         _share("rigid_energy_after", "mean_velocity_after")),
    Fact("vibration_energy_after", "ringing in it", "the ringing of the striker", "energy",
         "blow.vibration_energy_after", _share("vibration_energy_after")),
    Fact("energy_error", "closes to", "by how much the balance of energy does not close, relative: rounding, or what "
         "`fineness` leaves out", "",
         "blow.energy_error", lambda one, _: f"energy {one.blow.energy_error:.1e}, momentum "
         f"{one.blow.momentum_error:.1e}, relative"),
    Fact("effective_restitution", "restitution", "$R=-V_1/V_0$", "", "blow.effective_restitution",
         "R = {blow.effective_restitution}"),
    Fact("contact_duration", "contact",
         "$t_c$, from the start of the first contact to the end of the last one; null without such an end", "",
         "blow.contact_duration", "{blow.contact_duration:time}; centroid of the force at {blow.force_centroid:time}"),
    *figures(r"""
force_centroid | $t_J$, centroid of the contact force after the start of the first contact | blow.force_centroid
momentum_error | the same of the balance of momentum | blow.momentum_error
striker_mass | mass of the striker | blow.striker_mass
mean_velocity_before | $V_0$, momentum of the striker over its mass, before the blow | blow.mean_velocity_before
mean_velocity_after | $V_1$, the same after it | blow.mean_velocity_after
striker_momentum_after | $MV_1$ | blow.striker_momentum_after
impulse | $J=\int N\,dt$ of all contacts | blow.impulse
restitution_from_impulse | $J/(MV_0)-1$, the same as $R$ if no load acts | blow.restitution_from_impulse
gap_after | distance between the faces at the end | blow.gap_after
kinetic_energy_before | the kinetic part of `energy_before` | blow.kinetic_energy_before
"""),
)  # fmt: skip
"""What a blow does to the striker."""


PULSE = figures(r"""
length | duration of the incident wave at the face, until its force falls to 0 or a returned wave arrives
rise | time from its start to its greatest force
peak | the greatest force
energy | $Z\int f^2dt$
momentum | $Z\int f\,dt$
""")


def _incident(answer: BlowAnswer, tell: Teller) -> str:
    """Its energy, and why it may be more than was sent into the rod."""
    assert answer.waves is not None
    passed, back = answer.waves.incident_energy, answer.waves.reflected_energy
    if passed <= answer.blow.work_through_face * (1.0 + _ALIKE):
        return tell(passed, "energy")
    text = f"{tell(passed, 'energy')}, more than the blow sends into the rod: waves that come back are sent on, and "
    return f"{text}counted again; less the reflected wave it is {tell(passed - back, 'energy')}"


def _preload(answer: BlowAnswer, tell: Teller) -> str | None:
    return tell(answer.waves.preload, "force") if answer.waves and answer.waves.preload else None


GAUGE: tuple[Fact[BlowAnswer], ...] = (
    Fact("place", "gauge", "from the struck face; in a dimensionless case the time that a wave takes from there", "",
         "gauge", "{gauge:length} from the face"),
    Fact("impedance", "", "$Z$ of the section", "", "waves.impedance"),
    Fact("incident_energy", "incident wave", r"$Z\int f^2dt$ over the window; what comes back to the struck face "
         "and is sent on counts again", "energy",
         "waves.incident_energy", _incident),
    Fact("reflected_energy", "reflected wave", r"$Z\int g^2dt$ over the window", "energy", "waves.reflected_energy"),
    Fact("tool_energy", "∫F²/Z dt", r"$\int F^2/Z\,dt$, the energy that passes only as long as nothing has come back",
         "energy", "waves.tool_energy",
         "{waves.tool_energy:energy}; the energy that passes only while nothing has come back"),
    Fact("preload", "preload", "static force there under the feed, which a gauge that is set to zero does not show",
         "force", "waves.preload", _preload),
    Fact("force_greatest", "", "the greatest force there, the preload with it", "",
         lambda one: None if one.gauge_force is None else one.gauge_force[0]),
    Fact("force_least", "", "the least, negative in tension", "",
         lambda one: None if one.gauge_force is None else one.gauge_force[1]),
)  # fmt: skip
ROD: tuple[Fact[BlowAnswer], ...] = (
    Fact("first_pulse", "first pulse", "only with a rod: see below; null if there was no contact", "",
         lambda one: None if one.blow.first_pulse is None else plain_of(one.blow.first_pulse, PULSE),
         "{blow.first_pulse.length:time} long, peak {blow.first_pulse.peak:force} after {blow.first_pulse.rise:time}, "
         "{blow.first_pulse.energy:energy}"),
    Fact("rod_energy_after", "left in the rod", "only with a rod: what is left in it, or has gone down an endless one",
         "energy", "blow.rod_energy"),
    *figures("""
gauge | only with a rod: the waves at one place, see below |
rod_momentum_after | only with a rod: likewise the momentum | blow.rod_momentum
bit_kinetic_energy_after | only with a rod: of the lumped mass at its end | blow.bit_kinetic_energy_after
"""),
)  # fmt: skip
"""What it does in the rod."""


ROCK: tuple[Fact[BlowAnswer], ...] = (
    Fact("rock_work", "work on it", "only with rock, as all keys down to `penetration_after`: work done on it",
         "energy", "blow.rock_work", "{blow.rock_work:energy}, of which {blow.rock_dissipated:energy} for good"),
    Fact("greatest_penetration", "penetration", "the deepest", "", "blow.greatest_penetration",
         "{blow.greatest_penetration:length}, of which {blow.residual_penetration:length} remain"),
    Fact("greatest_rock_force", "peak force", "the greatest force on the rock", "force", "blow.bit_force.peak"),
    Fact("beta", "β", r"$\beta=K_1T/Z$ of the first pulse, $T$ long, in the longest section of the rod; null without a "
         "pulse and on elastic rock", "", "beta",
         "{beta} = K₁T/Z of the first pulse; a rectangular one does most at 1.256"),
    Fact("efficiency", "efficiency", r"$\eta_1$, work on the rock over the energy before", "", "blow.efficiency",
         lambda one, tell: said(f"{{blow.efficiency:percent}} of the energy before the blow; it assumes "
                                f"{assumed(one.blow.target)}", one,
                                tell)),
    Fact("efficiency_with_rebound", "without rebound",
         r"$\eta_2$, the same with the energy of the rebounding striker taken off the energy before", "",
         "blow.efficiency_with_rebound",
         "{blow.efficiency_with_rebound:percent} without what rebounds with the striker"),
    *figures("""
rock_work_dissipated | what of the work stays in the rock | blow.rock_dissipated
rock_work_stored | what it could still give back | blow.rock_stored
residual_penetration | the penetration after unloading | blow.residual_penetration
penetration_after | that at the end of the window | blow.penetration_after
"""),
)  # fmt: skip
"""What it does in the rock."""


def _stress_dict(answer: BlowAnswer) -> dict[str, Any]:
    """The greatest compression and tension of each section: stress, or force of a dimensionless bar."""
    kind = "stress" if answer.is_si else "force"
    own, rod = answer.peaks
    found = {
        f"peak_compressive_{kind}": [peak.compression for peak in own],
        f"peak_tensile_{kind}": [peak.tension for peak in own],
        "peaks_of_striker": [picked(peak, _PEAK) for peak in own],
    }
    return found | ({"peaks_of_rod": [picked(peak, _PEAK) for peak in rod]} if rod else {})


_PEAK = "compression compression_place compression_time tension tension_place tension_time"


# ---- What formulas say of a blow beside what its waves gave, and what the theory of such waves leaves out

_ALIKE = 1e-9  # relative difference of two impedances, or two times, that counts as none


class Formula(NamedTuple):
    """A closed form that applies: its name, and what it says beside what the waves gave."""

    name: str
    text: str
    value: float
    found: float


def _formulas(answer: BlowAnswer) -> tuple[Formula, ...]:
    """The closed forms that apply to a blow; none under a load, and of sections with different speeds or losses."""
    from percuss.blow.bodies import striker_sections

    blow, rod = answer.blow, answer.rod
    if rod is not None and (rod.joint_at or any(rod.attenuation) or (rod.feed is not None and rod.feed.damping)):
        return ()
    alike = blow.velocity is not None and bool((blow.velocity == blow.velocity[0]).all())
    if not alike or blow.load_work != 0.0 or not blow.contacts:
        return ()
    z, tau = striker_sections(blow.striker).impedance, striker_sections(blow.striker).transit
    if z.size == 1:
        return _of_uniform(answer, float(z[0]), float(tau[0]))
    if z.size == 2 and answer.rod is None and abs(tau[0] - tau[1]) <= _ALIKE * tau[0]:
        return _of_two(answer, float(z[0]), float(z[1]))
    return ()


def _of_uniform(answer: BlowAnswer, z: float, tau: float) -> tuple[Formula, ...]:
    """A uniform striker on a wall, on an endless rod (St Venant 1867), on a bit in rock (Lundberg 1973)."""
    from percuss.blow.closed_forms import uniform_blow

    blow, rod = answer.blow, answer.rod
    speed, force = blow.mean_velocity_before, blow.contacts[0].peak_force
    if not speed > 0.0:
        return ()
    z2 = math.inf if rod is None else blow.waves_at(0.0).impedance
    known = uniform_blow(z, tau, speed, z2)
    found = [
        Formula(
            "first step", _beside(answer.tell(known.force, "force"), answer.tell(force, "force")), known.force, force
        )
    ]
    lasts = blow.contacts[0].end
    if known.restitution >= 0.0 and lasts is not None and _reaches_nothing(answer):
        took = lasts - blow.contacts[0].start
        said = f"2τ = {answer.tell(known.duration, 'time')}"
        found.append(Formula("contact", _beside(said, answer.tell(took, "time")), known.duration, took))
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


def _reaches_nothing(answer: BlowAnswer) -> bool:
    """Whether nothing comes back from the far end of what is struck."""
    return answer.rod is None or (answer.rod.end == "infinite" and len(answer.rod.sections) <= 1)


def _on_rock(answer: BlowAnswer, z: float, tau: float) -> list[Formula]:
    """One rectangular wave on a bit without mass: β = K₁ T/Z, T = 2τ (Lundberg 1973)."""
    from percuss.blow.closed_forms import BEST_BETA, best_efficiency, matched_efficiency

    rod, blow = answer.rod, answer.blow
    assert rod is not None and rod.rock is not None
    beta, gamma = 2.0 * tau * rod.rock.stiffness / z, rod.rock.unloading_ratio
    phi = 0.0 if rod.feed is None else 2.0 * rod.feed.force / (z * blow.mean_velocity_before)
    one, best = matched_efficiency(beta, gamma, phi), matched_efficiency(BEST_BETA, gamma, phi)
    wave, done = best_efficiency(beta, gamma), blow.rock_dissipated / blow.energy_before
    said = "2(1 − γ)(1 − e^−β)²/β" if phi == 0.0 else "2(1 − γ)[(1 − e^−β)² + φ(1 − e^−β)]/β"
    said += f" = {percent(one, 4)} at β = {number(beta)}" + (f", φ = {number(phi)} of the feed" if phi else "")
    return [
        Formula("Lundberg 1973", f"{_beside(said, percent(done, 4))}, later waves included", one, done),
        Formula("best β", f"{number(BEST_BETA)} gives {percent(best, 4)} with a rectangular wave", best, done),
        Formula("best wave", f"one that rises as e^(K₁t/Z) gives {percent(wave, 4)} at this β", wave, done),
    ]


def _of_two(answer: BlowAnswer, rear: float, head: float) -> tuple[Formula, ...]:
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


def _left_out(answer: BlowAnswer) -> tuple[tuple[str, str], ...]:
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


# ---- A blow in one sentence: where its energy went

_NEGLIGIBLE = 1e-3  # share of the energy that is not worth a clause


def blow_sentence(answer: BlowAnswer) -> str:
    """What one blow does, the first line of its report."""
    blow = answer.blow
    before = blow.energy_before
    head = "" if answer.fatigue is None else f"{answer.fatigue.sentence} "
    head += f"A blow of {answer.tell(before, 'energy', 3)} at {answer.tell(blow.mean_velocity_before, 'speed', 3)}"
    if not blow.contacts:
        return f"{head} does not reach the target in {answer.tell(blow.until, 'time', 3)}."
    clauses = [_given(answer, before)]
    if blow.rigid_energy_after > _NEGLIGIBLE * before:
        way = "come back" if blow.mean_velocity_after < 0.0 else "stay"
        clauses.append(f"{answer.tell(blow.rigid_energy_after, 'energy', 3)} {way} with the striker")
    if blow.vibration_energy_after > _NEGLIGIBLE * before:
        clauses.append(f"{answer.tell(blow.vibration_energy_after, 'energy', 3)} ring in it")
    left = blow.rod_energy + blow.bit_kinetic_energy_after
    if blow.penetration is not None and left > _NEGLIGIBLE * before:
        clauses.append(f"{answer.tell(left, 'energy', 3)} stay in the rod")
    sentence = f"{head} {clauses[0]}" + "".join(f"; {clause}" for clause in clauses[1:])
    often = "" if len(blow.contacts) == 1 else f", in {counted(len(blow.contacts), 'contact')}"
    return f"{sentence}; {_stress(answer)}{often}."


def _given(answer: BlowAnswer, before: float) -> str:
    blow = answer.blow

    def share(value: float) -> str:
        return f"{answer.tell(value, 'energy', 3)}" + (f" ({percent(value / before)})" if before > 0.0 else "")

    if blow.penetration is not None:
        return f"puts {share(blow.rock_work)} into the rock"
    if answer.rod is not None:
        return f"puts {share(blow.work_through_face)} into the rod"
    return f"gives nothing to the wall: R = {number(blow.effective_restitution or 0.0)}"


def _stress(answer: BlowAnswer) -> str:
    own = answer.peaks[0]
    name = "head" if len(own) > 1 else "striker"
    return f"the {name} sees {answer.tell(own[-1].compression, 'stress', 3)}"


# ---- The dispatcher's answer to "what does one blow of this hammer do?"

_MIDDLE = 0.5  # where a gauge is unless told otherwise, as a share of the first section of the rod


def blow_answer(
    case: Case,
    velocity: float | None = None,
    *,
    until: float | None = None,
    gauge: float | None = None,
    whole_field: bool = False,
    most_pieces: int | None = None,
    fatigue: bool = False,
) -> BlowAnswer:
    """One blow of a case.

    Parameters
    ----------
    velocity
        Of the striker toward the target, in m/s (dimensionless: lengths per radian), instead of that of the case.
    until
        End of the window in s (dimensionless: radians), instead of that of the case.
    gauge
        Where the waves are told of, m from the struck face (dimensionless: time of a wave); by default the middle of
        the rod's first section.
    whole_field
        Start from the whole field of the steady motion just before its impact, with its strain.
    most_pieces
        Of waves, as `percuss.blow.strike` counts them, after which the window is cut short.
    fatigue
        Whether to find the fatigue of striker and rod by blows like this one, as the table [steel] has it.

    Raises
    ------
    CaseError
        When the case has no speed and no steady motion to take it from, and for fatigue of a dimensionless case.
    MissingExtraError
        For fatigue without the package `rainflow`, of the extra `io`.

    Examples
    --------
    >>> from percuss.case import load_case
    >>> answer = blow_answer(load_case("laboratory-striker"))
    >>> answer.blow.energy_error < 1e-12
    True
    """
    from percuss.blow import Rod, strike  # loads the compiler

    checked_case(case)
    velocity, until = (None if x is None else positive(n, x) for n, x in (("velocity", velocity), ("until", until)))
    gauge = None if gauge is None else non_negative("gauge", gauge)
    question, steel = case.blow_question(), case.steel() if flag("fatigue", fatigue) else None
    if velocity is not None:
        if flag("whole_field", whole_field):
            raise ParameterError("velocity", velocity, "either a velocity or the field of the steady motion, not both")
        question = replace(question, velocity=velocity)
    if until is not None:
        question = replace(question, until=until)
    field: Field | None = None
    speed, notes = "as the case says" if velocity is None else "as asked for", _notes(case, question)
    given = question.velocity
    if given is None and case.is_machine and not whole_field:
        speed, given = "that of the machine's own cycle just before its blow", own_speed(case)
    elif whole_field or given is None:
        orbit, which = _motion(case)
        speed = f"that of steady motion {which} just before its impact"
        field, given = (_field_of(orbit, question.striker), None) if whole_field else (None, _mean_speed(orbit))
    most = {} if most_pieces is None else {"most_pieces": most_pieces}
    rod = question.target if isinstance(question.target, Rod) else None

    def struck(target: Rod | Wall, crater: float = 0.0) -> Blow:
        return strike(
            question.striker, target, given, until=question.until, load=question.load, load_at=question.load_at,
            field=field, crater=crater, **most,
        )  # fmt: skip

    drilled = None if rod is None else _drilled(case, question, rod, struck)
    found = struck(question.target) if drilled is None else drilled.blow
    answer = BlowAnswer(case.file, case.title, found, speed, _gauge(found, gauge), notes, drilled=drilled)
    if steel is None:
        return answer
    assumed = getattr(case.tables, "steel", None) is None
    return replace(answer, fatigue=blow_fatigue(found, steel, _own_rate(case), assumed))


def _drilled(case: Case, question: BlowQuestion, rod: Rod, struck: Callable[..., Blow]) -> Drilled:
    """The blows that the case asks for on its tool; refused by their keys."""
    from percuss.blow import blows_one_by_one

    if question.between == "waves" and question.number > 1:
        remedy = 'write between = "static" for blows one by one, or follow one'
        raise CaseError(case.file, "blow.between", "waves", 'expected "static": not followed yet', remedy)
    if question.number > 1 and question.crater == "same" and rod.rock is None:
        raise CaseError(case.file, "rock.crater", question.crater, 'expected "new" of a tool without rock')
    try:
        return Drilled(
            blows_one_by_one(
                struck, rod, number=question.number, crater=question.crater, rate=question.rate,
                blows_per_crater=question.blows_per_crater, drilling=question.drilling,
                of_machine=question.feed_of == "machine",
            )
        )  # fmt: skip
    except ParameterError as error:
        if error.name != "force":
            raise
        raise CaseError(case.file, "feed.force", error.value, f"expected {error.accepted}", error.remedy) from None


def _gauge(blow: Blow, asked: float | None) -> float | None:
    """The place of the gauge, checked; None where there is no rod."""
    from percuss.blow import Rod

    if asked is not None:
        blow.waves_at(asked)
        return asked
    if not isinstance(blow.target, Rod):
        return None
    pieces = blow.target.pieces if isinstance(blow.striker, SizedBody) and blow.target.impedance is None else ()
    first = pieces[0].end - pieces[0].start if pieces else float("inf")
    if first == float("inf"):
        return blow.striker.length if isinstance(blow.striker, SizedBody) else blow.striker.transit_time
    return _MIDDLE * first


def _notes(case: Case, question: BlowQuestion) -> tuple[str, ...]:
    from percuss.blow import Wall

    if case.tables.tool is None and isinstance(question.target, Wall):
        return ("the case has no [tool]: the bar strikes a rigid wall",)
    if case.tables.tool is None:
        return ("the case has no [tool]: the bar strikes an endless rod of the receiving area",)
    return ()


# -- the steady motion that a speed comes from ------------------------------------------------------------------------


def _motion(case: Case) -> tuple[Orbit, str]:
    """The steady motion to look at first, and its number."""
    from percuss.case.answers.steady_answer import steady_answer

    remedy = 'say how fast it strikes: velocity = "9 m/s" in [blow], or --velocity'
    if case.tables.load is None or getattr(case.tables, "contact", ...) is None:
        accepted = "a velocity, or a [load] and a [contact] whose steady motion has one"
        raise CaseError(case.file, "blow.velocity", None, accepted, remedy)
    if case.is_machine:
        told = "leave the field out, and the blow has the mean speed of the machine's own cycle"
        raise CaseError(case.file, "load.kind", "valve", "a load with a period for the field of a steady motion", told)
    answer = steady_answer(case)
    chosen = answer.chosen
    if chosen is None:
        raise CaseError(case.file, "blow.velocity", None, "a velocity: the case has no steady motion", remedy)
    number = answer.periods[0].orbits.index(chosen) + 1
    return chosen.orbit, str(number)


def own_speed(case: Case) -> float:
    """The bar's mean velocity before its blow, in the case's units; CaseError without a cycle of one blow."""
    if not case.is_machine:
        return _mean_speed(_motion(case)[0])
    try:
        return rigid_speed(case.machine(), case.room())
    except ParameterError as error:
        raise CaseError(case.file, "blow.velocity", None, error.accepted, error.remedy) from None


def _own_rate(case: Case) -> float | None:
    """Blows per second in the hammer's own cycle; None where it has none."""
    from percuss.steady import self_excited_motion

    try:
        motion = self_excited_motion(case.machine(), room=case.room()).cycle if case.is_machine else _motion(case)[0]
    except CaseError:
        return None
    return None if motion is None else motion.impacts / (motion.period * motion.system.time_scale)


def _mean_speed(orbit: Orbit) -> float:
    """Mean velocity of the bar just before the impact, in the units of the case."""
    system = orbit.system
    return orbit.rigid_velocity * (system.length_scale / system.time_scale if system.is_si else 1.0)


def _field_of(orbit: Orbit, striker: SizedBody | Body) -> Field:
    """Velocity and compressive force along the bar just before the impact, in the units of the case."""
    from percuss.blow.bodies import striker_sections

    system, sections = orbit.system, striker_sections(striker)
    scale = system.length_scale / system.time_scale if system.is_si else 1.0
    ends = np.cumsum(sections.length)[:-1] / sections.length.sum()
    stiffness = sections.impedance * sections.speed  # E A of each section

    def velocity(x: Array) -> Array:
        return scale * orbit.velocity(x, orbit.period)[:, 0]

    def force(x: Array) -> Array:
        return -stiffness[np.searchsorted(ends, x, side="right")] * orbit.strain(x, orbit.period)[:, 0]

    return velocity, force


# ---- Forces and waves of a blow over time, as a dataset for files

POINTS = 4001  # equal steps of the window, less one


def blow_dataset(answer: BlowAnswer) -> Dataset:
    """Forces, waves and penetration at equal steps of the window; at a jump the later value."""
    xarray = extra_package("xarray", "io")
    blow, waves, si = answer.blow, answer.waves, answer.is_si
    time = np.linspace(0.0, blow.until, POINTS)
    force = "N" if si else "1"
    traces: dict[str, tuple[Trace, str, str]] = {"face_force": (blow.face_force, force, "force between the faces")}
    if waves is not None:
        traces["incident"] = (waves.incident, force, "force of the wave from the face, at the gauge")
        traces["reflected"] = (waves.reflected, force, "force of the wave that comes back, at the gauge")
    if blow.bit_force is not None and blow.penetration is not None:
        traces["bit_force"] = (blow.bit_force, force, "force on the rock")
        traces["penetration"] = (blow.penetration, "m" if si else "1", "place of the bit, from the rock's surface")
    variables: dict[str, Any] = {
        name: ("time", trace.at(time), {"units": unit, "long_name": meaning})
        for name, (trace, unit, meaning) in traces.items()
    }
    about = {"units": "s" if si else "1", "long_name": "time from the start of the window"}
    attributes = {"title": answer.title, "answer": json.dumps(answer.to_json_dict(), allow_nan=False)}
    made: Dataset = xarray.Dataset(variables, {"time": ("time", time, about)}, attributes)
    return made


# ---- The report


_SHOWN = 12  # contacts that are listed one by one


def blow_report(answer: BlowAnswer) -> Report:
    def section(heading: str, *facts: Fact[BlowAnswer]) -> ReportSection:
        return ReportSection(heading, tuple(rows_of(answer, facts, answer.tell)))

    sections: list[ReportSection | Grid] = [_question(answer), _contacts(answer), section("Energy", *STRIKER)]
    if answer.rod is not None:
        sections.append(section("The wave in the rod", ROD[0], *GAUGE, *ROD[1:]))
    if answer.measured is not None:
        sections.append(ReportSection("Measured at the gauge", answer.measured.rows))
    if answer.blow.penetration is not None:
        sections.append(section("The rock", *ROCK))
    if answer.drilled is not None:
        sections += drilled_sections(answer.drilled, answer.tell)
    sections.append(_stresses(answer))
    if answer.fatigue is not None:
        sections += answer.fatigue.parts
    if answer.formulas:
        sections.append(ReportSection("In closed form", tuple((one.name, one.text) for one in answer.formulas)))
    if answer.left_out:
        sections.append(ReportSection("What one-dimensional waves leave out", answer.left_out))
    tone = GOOD if answer.blow.outcome.name in ("OVER", "SPENT") else PLAIN
    cut = answer.blow.outcome.name == "TOO_MANY_PIECES"
    return Report(answer.title, blow_sentence(answer), BAD if cut else tone, tuple(sections))


def _question(answer: BlowAnswer) -> ReportSection:
    blow, rod = answer.blow, answer.rod
    struck = "a rigid wall" if rod is None else _rod_sentence(answer)
    rows = [
        ("case", answer.name),
        ("striker", str(blow.striker)),
        ("it strikes", struck),
        *([] if answer.drilled is None else said_first(answer.drilled, answer.tell)),
        ("speed", f"{answer.tell(blow.mean_velocity_before, 'speed')}, {answer.speed}"),
        ("window", f"{answer.tell(blow.until, 'time')}; {blow.outcome.value}"),
    ]
    if blow.fineness.name != "EXACT":
        rows.append(("waves", blow.fineness.value))
    return ReportSection("The blow", (*rows, *(("note", note) for note in answer.notes)))


def _rod_sentence(answer: BlowAnswer) -> str:
    rod = answer.rod
    assert rod is not None
    if rod.impedance is not None:
        return f"an endless rod of impedance {number(rod.impedance)}"
    far = {"infinite": "endless", "free": "free at its end", "fixed": "fixed at its end", "rock": "with a bit on rock"}
    areas = [1e6 * piece.area for piece in rod.pieces]
    span = f"{number(min(areas))} … {number(max(areas))}" if min(areas) < max(areas) else number(areas[0])
    known = sum(section.length for section in rod.sections if section.length is not None)
    long = f"{quantity(known, 'm')}, " if known else ""
    mass = f", {number(rod.bit_mass)} kg at the end" if rod.bit_mass else ""
    return f"a rod of {counted(len(rod.pieces), 'section')}, {long}{span} mm², {far[rod.end]}{mass}"


def _contacts(answer: BlowAnswer) -> Grid | ReportSection:
    blow = answer.blow
    if not blow.contacts:
        return ReportSection("Contacts", (("none", "the striker has not reached the target in the window"),), BAD)
    more = len(blow.contacts) - _SHOWN
    heading = counted(len(blow.contacts), "contact")
    if more > 0:
        heading += f", of which the first {_SHOWN}"
    if blow.grazes:
        heading += f"; {counted(blow.grazes, 'touch').replace('touchs', 'touches')} without an impulse left out"
    return grid_of(heading, blow.contacts[:_SHOWN], CONTACT, answer.tell)


CONTACT: tuple[Fact[ContactInterval], ...] = (
    Fact("", "start", "from the start of the window", "time", "start", "{start:time}"),
    Fact("", "end", "of the contact", "time", "end", lambda one, tell: said("{end:time}", one, tell) or "still closed"),
    Fact("", "impulse", "of its force", "momentum", "impulse", "{impulse:momentum}"),
    Fact("", "peak force", "the greatest", "force", "peak_force", "{peak_force:force}"),
)  # fmt: skip
"""A contact as a report tells it."""


def _stresses(answer: BlowAnswer) -> Grid:
    own, rod = answer.peaks
    rows = [_peak(answer, f"striker {i}", one) for i, one in enumerate(own)]
    rows += [_peak(answer, f"rod {i}", one) for i, one in enumerate(rod)]
    what = "stress" if answer.is_si else "force"
    columns = ("section, from 0", f"compression ({what})", "where", "when", "tension", "where", "when")
    return Grid("Greatest stresses" if answer.is_si else "Greatest forces", columns, tuple(rows))


def _peak(answer: BlowAnswer, name: str, peak: Peak) -> tuple[str, ...]:
    def told(value: float, place: float | None, time: float | None) -> tuple[str, str, str]:
        if place is None or time is None:
            return "none", "", ""
        return answer.tell(value, "stress"), answer.tell(place, "length"), answer.tell(time, "time")

    first = told(peak.compression, peak.compression_place, peak.compression_time)
    return (name, *first, *told(peak.tension, peak.tension_place, peak.tension_time))


# ---- A record of a strain gauge, as it lies over the computed force of a blow


@dataclass(frozen=True)
class MeasuredGauge(ShortRepr):
    """A record of strain, stress or force at a gauge, laid over the computed force there.

    Attributes
    ----------
    file
        Where it was read.
    quantity
        "strain", "stress" or "force"; times E A, times A or as it is, it is the force at the gauge.
    sign
        1 where compression is positive in the record, −1 where it is negative.
    shift
        What is added to the record's time to make it that of the blow, s.
    zero
        What the record shows without a force, N in its own sign; it is taken off.
    scale
        The factor on the computed force that fits the record best; 1 where they agree.
    residual
        Root mean square of measured less computed force in the window, over the greatest computed force.
    residual_scaled
        The same with the factor.
    overlap
        Share of the blow's window that the record covers.
    time, force
        Shape (n,): the record on the clock of the blow, s, and N with compression positive.
    notes
        What was assumed, one sentence each.
    """

    file: str
    quantity: Literal["strain", "stress", "force"]
    sign: int
    shift: float
    zero: float
    scale: float
    residual: float
    residual_scaled: float
    overlap: float
    time: Array = field(repr=False)
    force: Array = field(repr=False)
    notes: tuple[str, ...] = ()

    @property
    def rows(self) -> tuple[tuple[str, str], ...]:
        """The lines of a report."""
        return (*rows_of(self, MEASURED, Teller(None, True)), *(("note", note) for note in self.notes))

    def to_json_dict(self) -> dict[str, Any]:
        """Its numbers in plain values, without the series."""
        return plain_of(self, MEASURED)


MEASURED: tuple[Fact[MeasuredGauge], ...] = (
    Fact("file", "record", "the record", "", "file",
         lambda one, _: f"{one.file}, {one.quantity}, compression {'positive' if one.sign > 0 else 'negative'}"),
    *figures("""
quantity | `"strain"`, `"stress"` or `"force"`
sign | 1 if compression is positive in the record, −1 if it is negative
"""),
    Fact("shift", "clock", "what is added to the record's time to make it that of the blow, in s", "", "shift",
         lambda one, _: f"{quantity(one.shift, 's', 5)} added to the time of the record"),
    Fact("zero", "zero", "what the record shows without a force, in N in its own sign; it is taken off", "", "zero",
         "{zero:force} taken off"),
    Fact("scale", "scale", "the factor on the computed force that fits the record best", "", "scale",
         "the record is {scale} times the computed force"),
    Fact("residual", "residual",
         "root mean square of measured less computed force in the window, over the greatest computed force", "",
         "residual", "{residual:percent} of the computed peak (rms); {residual_scaled:percent} after scaling"),
    Fact("residual_scaled", "", "the same with the factor `scale`", "", "residual_scaled"),
    Fact("overlap", "overlap", "share of the window that the record covers", "", "overlap",
         "the record covers {overlap:percent} of the window"),
    Fact("notes", "", "a list of texts: what was assumed", "", "notes"),
)  # fmt: skip
"""How a record fits a blow."""


_SIGNS = {"auto": None, "positive": 1, "negative": -1}
_FEW_SAMPLES = 10
"""Samples while a wave runs through the striker and back, below which the record says little of its shape."""
_PARTLY = 0.5
_UNLIKE = 0.15  # residual over the peak, after scaling, that is told of: a wrong place of the gauge gives more


def measured_gauge(
    answer: BlowAnswer,
    path: str | os.PathLike[str],
    *,
    column: str | int | None = None,
    unit: str | None = None,
    sample_rate: float | str | None = None,
    sign: Literal["auto", "positive", "negative"] = "auto",
) -> MeasuredGauge:
    """Lay a measured record over the computed force at the gauge of a blow.

    Parameters
    ----------
    answer
        What `blow_answer` gives, of a case in SI with a rod.
    path, column, unit, sample_rate
        As `percuss.recordings.read_recording` has them; strain, stress or force.
    sign
        How the record writes compression: "positive", "negative", or "auto" for the one that fits better.

    Raises
    ------
    HistoryError
        When the record cannot be read, is constant, or nothing in it resembles the computed force.
    ParameterError
        For a dimensionless case, for a wall, and where the area of the rod at the gauge is not known.

    Examples
    --------
    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> from percuss.case import blow_answer, load_case
    >>> answer = blow_answer(load_case("laboratory-striker"))
    >>> time = np.arange(0.0, answer.blow.until, 1e-6)
    >>> force = answer.waves.incident.at(time) + answer.waves.reflected.at(time)
    >>> with TemporaryDirectory() as folder:
    ...     file = Path(folder, "gauge.csv")
    ...     _ = file.write_text("t [s],force [N]\\n" + "".join(f"{t},{-1.02 * f}\\n" for t, f in zip(time, force)))
    ...     found = measured_gauge(answer, file)
    >>> found.sign, round(found.scale, 2)
    (-1, 1.02)
    """
    from percuss.blow.gauges import fitted_record
    from percuss.recordings import read_recording

    instance("answer", answer, BlowAnswer)
    choice("sign", sign, *_SIGNS)
    waves = answer.waves
    if waves is None:
        remedy = "the target is a wall: give the case a [tool]"
        raise ParameterError("measured", "a record", "a blow on a rod", remedy)
    if not answer.is_si:
        remedy = "describe the bar and the rod by their sizes, in [bar] and [tool]"
        raise ParameterError("measured", "a record", "a case in SI: the case is dimensionless", remedy)
    record = read_recording(path, column=column, unit=unit, sample_rate=sample_rate, sensor="gauge")
    force = record.values * _force_of_one(answer, record)
    try:
        fit = fitted_record(waves, answer.blow.until, record.time, force, sign=_SIGNS[sign])
    except ParameterError as error:
        raise HistoryError(f"expected {error.accepted}", error.remedy, str(record.path)) from None
    kind: Any = "stress" if record.quantity == "pressure" else record.quantity
    found = (fit.sign, fit.shift, fit.zero, fit.scale, fit.residual, fit.residual_scaled, fit.overlap)
    notes = (*record.notes, *_record_notes(answer, record, fit, sign == "auto"))
    series = record.time + fit.shift, fit.sign * (force - fit.zero)
    return MeasuredGauge(str(record.path), kind, *found, *series, notes)


def _force_of_one(answer: BlowAnswer, record: Recording) -> float:
    """The force in N, compression positive, that 1 in the record stands for."""
    if record.quantity == "force":
        return 1.0
    # the section of the rod under the gauge; of two that meet there, the later one, as for the waves
    place, pieces = answer.gauge, answer.pieces[1]
    piece = next((p for p in pieces if place is not None and place < p.end), pieces[-1] if pieces else None)
    if piece is None:
        remedy = "give the rod sections with area and youngs_modulus in [tool], or a record of force"
        raise ParameterError("measured", record.quantity, "a rod whose area at the gauge is known", remedy)
    return piece.area * (piece.youngs_modulus if record.quantity == "strain" else 1.0)  # N = E A ε


def _record_notes(answer: BlowAnswer, record: Recording, fit: RecordFit, chosen: bool) -> list[str]:
    from percuss.blow.bodies import striker_sections

    found = []
    if chosen:
        which = "positive" if fit.sign > 0 else "negative"
        found.append(f"compression is taken as {which} in the record, which fits better")
    there_and_back = 2.0 * float(striker_sections(answer.blow.striker).transit.sum())
    seen = there_and_back / float(np.median(np.diff(record.time)))
    if seen < _FEW_SAMPLES:
        found.append(f"only {number(seen, 2)} samples while a wave runs through the striker and back: sample faster")
    if fit.overlap < _PARTLY:
        found.append(f"the record covers only {percent(fit.overlap)} of the window: compare with a shorter --until")
    if fit.residual_scaled > _UNLIKE:
        found.append("the shapes differ: check the place of the gauge, the sections and the window")
    return found
