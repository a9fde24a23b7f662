"""One orbit as a section of the report: what it is, whether it can be kept up, and what to change if not."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from percuss.cli.blocks import BAD, GOOD, Section
from percuss.cli.numbers import number, percent, quantity

if TYPE_CHECKING:
    from percuss.case import OrbitAnswer
    from percuss.model import System
    from percuss.stability import Stability
    from percuss.steady import SIReport

__all__ = ["orbit_section"]

MOST_WARNINGS = 3
"""Warnings that a card shows; the rest is in the JSON."""


def orbit_section(answer: OrbitAnswer, name: str) -> Section:
    """The card of an orbit."""
    orbit, judged, system = answer.orbit, answer.stability, answer.orbit.system
    verdict = "stable" if judged.stable else "unstable"
    possible = "possible" if orbit.admissible else "not possible"
    rows = [
        ("phase", _phase(orbit.phase, system)),
        ("possible", _possible(answer)),
        ("verdict", _verdict(judged)),
        ("multipliers", _multipliers(judged)),
    ]
    if judged.disagreement:
        rows.append(("note", judged.disagreement))
    rows.append(("force at impact", _waveform(judged, system)))
    rows += _si_rows(answer.si) if answer.si is not None else _plain_rows(answer)
    rows.append(("energy", _energy(answer)))
    rows += [("warning", warning) for warning in orbit.warnings[:MOST_WARNINGS]]
    if len(orbit.warnings) > MOST_WARNINGS:
        rows.append(("", f"and {len(orbit.warnings) - MOST_WARNINGS} more; --json has them all"))
    tone = GOOD if answer.runs else BAD
    return Section(f"{name}: {verdict}, {possible}", tuple(rows), tone, level=2)


def _phase(phase: float, system: System) -> str:
    text = f"{number(phase, 5)} rad = {number(math.degrees(phase))}°"
    return f"{text} = {quantity(phase * system.time_scale, 's')} into the load period" if system.is_si else text


def _possible(answer: OrbitAnswer) -> str:
    orbit, system = answer.orbit, answer.orbit.system
    if orbit.admissible and not orbit.proven:
        return "yes as far as the sums reach, but not proved: a touch between the blows cannot be ruled out"
    if orbit.admissible:
        return "yes: the bar strikes forward and stays clear of the wall between the blows"
    if orbit.violation is None or orbit.impact_velocity <= 0.0:
        return "no: at the moment of impact the striking end would be moving away from the wall"
    time, depth = number(orbit.violation.time), number(orbit.violation.depth)
    if system.is_si:
        time = quantity(orbit.violation.time * system.time_scale, "s")
        depth = quantity(orbit.violation.depth * system.length_scale, "m")
    else:
        time += " rad"
    return f"no: {time} after the impact the striking end would be inside the wall, {depth} deep"


def _verdict(judged: Stability) -> str:
    verdict = "stable" if judged.stable else "unstable"
    reason = judged.reason if judged.reason.startswith(verdict) else f"{verdict}: {judged.reason}"
    return f"{reason} (margin {number(judged.margin, 3)})"


def _multipliers(judged: Stability) -> str:
    exact, reduced = judged.multipliers, judged.reduced
    text = f"largest exact {number(exact.largest, 6)} ({exact.modes} modes)"
    text += f"; reduced (B77) {number(max(float(x) for x in reduced.moduli), 6)}"
    if reduced.other_side is not None:
        text += f", {number(max(float(x) for x in reduced.other_side.moduli), 6)} on the other side of the jump"
    return text


def _waveform(judged: Stability, system: System) -> str:
    """The waveform criterion (theory §11) in words, and what to change."""
    criterion = judged.waveform
    values = (criterion.force, criterion.force_lower, criterion.force_upper)
    if system.is_si:
        force, lower, upper = (quantity(value * system.force_scale, "N") for value in values)
    else:
        force, lower, upper = (number(value) for value in values)
    text = f"{force}; a stable blow of a rigid, undamped bar needs it between {lower} and {upper} (the mean)"
    if criterion.stable:
        return text
    if criterion.ratio >= criterion.upper:
        return f"{text}. It is too large: let the blow fall where the load is below its mean"
    text = f"{text}. It is too low: lower the return force at the moment of impact to less than {lower.lstrip('-')}"
    needed = criterion.restitution_needed
    if needed is None:
        return text
    return f"{text}, or, with this force there, strike with a restitution below {number(needed, 3)}"


def _si_rows(si: SIReport) -> list[tuple[str, str]]:
    end, rigid = f"{number(si.impact_velocity_m_s)} m/s", f"{number(si.rigid_velocity_m_s)} m/s"
    apart = abs(si.rigid_velocity_m_s - si.impact_velocity_m_s) > 0.01 * abs(si.impact_velocity_m_s)
    speed = f"{end} at the striking end, {rigid} on average" if apart else end
    blow, taken = quantity(si.blow_energy_J, "J"), quantity(si.delivered_energy_J, "J")
    out, put_in = quantity(1e3 * si.percussive_power_kW, "W"), quantity(1e3 * si.input_power_kW, "W")
    efficiency = "" if si.efficiency is None else f", efficiency {percent(si.efficiency)}"
    momentum = f"momentum {number(si.momentum_N_s)} N·s per blow"
    return [
        ("blow", f"{blow}, of which {taken} delivered; {speed}"),
        ("rate", f"{number(si.blow_rate_Hz)} Hz = {number(si.blow_rate_per_min)} blows/min"),
        ("power", f"percussive {out}, input {put_in}{efficiency}"),
        ("stroke", f"{number(si.stroke_mm)} mm"),
        (
            "stress",
            f"{number(si.peak_stress_MPa)} MPa peak, for a contact of {number(si.contact_time_us)} µs",
        ),
        ("mean force", f"{quantity(1e3 * si.mean_force_kN, 'N')}; {momentum}"),
    ]


def _plain_rows(answer: OrbitAnswer) -> list[tuple[str, str]]:
    orbit = answer.orbit
    speed = f"{number(orbit.impact_velocity, 6)} at the striking end, {number(orbit.rigid_velocity, 6)} on average"
    return [
        ("striking speed", speed),
        (
            "blow energy",
            f"{number(orbit.blow_energy, 6)}, of which {number(orbit.delivered_energy, 6)} delivered",
        ),
        ("stroke", number(orbit.stroke, 6)),
    ]


def _energy(answer: OrbitAnswer) -> str:
    orbit, system = answer.orbit, answer.orbit.system
    energy = orbit.energy
    values = (energy.input, energy.impact, energy.damping)
    if system.is_si:
        texts = [quantity(value * system.energy_scale, "J") for value in values]
    else:
        texts = [number(value, 5) for value in values]
    misses = abs(energy.imbalance) / max(abs(energy.input), abs(energy.impact), 1e-300)
    closing = f"closes to {number(misses, 2)} ({orbit.modes} modes)"
    return f"{texts[0]} in per impact = {texts[1]} to the impact + {texts[2]} to damping; {closing}"
