"""One orbit as a section of the report: what it is, whether it can be sustained, and what to change if not."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from percuss.case.answers.numerals import counted, number, percent, quantity
from percuss.cli.report_parts import BAD, GOOD, Section
from percuss.cli.timed_section import timed_heading, timed_rows
from percuss.steady.reason import Reason

if TYPE_CHECKING:
    from percuss.case import OrbitAnswer
    from percuss.model import System, Timed
    from percuss.stability import Stability
    from percuss.steady import Drag, SIReport

__all__ = ["orbit_section"]

MOST_WARNINGS = 3
"""Warnings that a card shows; the rest is in the JSON."""


def orbit_section(answer: OrbitAnswer, name: str, law: Timed | None = None) -> Section:
    """The card of an orbit, with what a law of blows that take time makes of it."""
    orbit, judged, system = answer.orbit, answer.stability, answer.orbit.system
    verdict = "stable" if judged.stable else "unstable"
    possible = "possible" if orbit.admissible else "not possible"
    rows = [
        ("phase", _phase(orbit.phase, system)),
        ("possible", _possible(answer)),
        ("verdict", _verdict(judged)),
        ("margins", _margins(judged)),
        ("multipliers", _multipliers(judged)),
    ]
    if judged.disagreement:
        rows.append(("note", judged.disagreement))
    rows.append(("force at impact", _waveform(judged, system)))
    if orbit.impact_velocity > 0.0:
        rows += _si_rows(answer.si, answer.drag) if answer.si is not None else _plain_rows(answer)
        rows.append(("energy", _energy(answer)))
    else:
        rows.append(("blow", _no_blow(answer)))
    rows += timed_rows(answer, law)
    rows += [("warning", warning) for warning in orbit.warnings[:MOST_WARNINGS]]
    if len(orbit.warnings) > MOST_WARNINGS:
        rows.append(("", f"and {len(orbit.warnings) - MOST_WARNINGS} more; --json has them all"))
    tone = GOOD if answer.runs else BAD
    heading = f"{name}: {verdict}, {possible}{timed_heading(answer, law)}"
    return Section(heading, tuple(rows), tone, level=2)


def _phase(phase: float, system: System) -> str:
    text = f"{number(phase, 5)} rad = {number(math.degrees(phase))}°"
    return f"{text} = {quantity(phase * system.time_scale, 's')} into the load period" if system.is_si else text


def _possible(answer: OrbitAnswer) -> str:
    orbit, system = answer.orbit, answer.orbit.system
    if orbit.admissible and not orbit.proven:
        return "yes, as far as the sums over modes tell, but not proved: a touch between the blows cannot be ruled out"
    if orbit.admissible:
        return "yes: the bar strikes forward and stays clear of the wall between the blows"
    if orbit.violation is None or orbit.obstacle is Reason.NO_BLOW:
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
    return reason


def _margins(judged: Stability) -> str:
    """What becomes of a disturbance of the bar as a whole, and of one that rings."""
    found, ringing = judged.multipliers, judged.margin_ringing
    text = f"rhythm {number(judged.margin_rhythm, 3)}: an error in the time or the speed of a blow "
    text += f"{_becomes(found.rhythm)} with every impact"
    if ringing is None or found.ringing is None:
        return text
    text += f"; ringing {number(ringing, 3)}: the slowest elastic mode ({found.ringing_mode})"
    return f"{text} {_becomes(found.ringing)}"


def _becomes(modulus: float) -> str:
    return f"shrinks to {percent(modulus)}" if modulus < 1.0 else f"grows by a factor of {number(modulus)}"


def _multipliers(judged: Stability) -> str:
    exact, reduced = judged.multipliers, judged.reduced
    text = f"largest exact {number(exact.largest, 6)} ({counted(exact.modes, 'mode')})"
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
    text = f"{force}; a stable blow of a rigid, undamped bar needs a force between {lower} and {upper} (the mean)"
    if criterion.stable:
        return text
    if criterion.ratio >= criterion.upper:
        return f"{text}. The force is too large: let the blow fall where the load is below its mean"
    text += f". The force is too low: reduce the return force at the moment of impact to less than {lower.lstrip('-')}"
    needed = criterion.restitution_needed
    if needed is None:
        return text
    return f"{text}, or, with this force, strike with a restitution below {number(needed, 3)}"


def _no_blow(answer: OrbitAnswer) -> str:
    speed = -answer.orbit.impact_velocity
    told = number(speed, 6) if answer.si is None else f"{number(-answer.si.impact_velocity_m_s)} m/s"
    return f"none: the striking end would be leaving the wall at {told}" if speed else "none: the end would stand still"


def _si_rows(si: SIReport, drag: Drag) -> list[tuple[str, str]]:
    end, rigid = f"{number(si.impact_velocity_m_s)} m/s", f"{number(si.rigid_velocity_m_s)} m/s"
    apart = abs(si.rigid_velocity_m_s - si.impact_velocity_m_s) > 0.01 * abs(si.impact_velocity_m_s)
    speed = f"{end} at the striking end, {rigid} on average" if apart else end
    blow, taken = quantity(si.blow_energy_J, "J"), quantity(si.delivered_energy_J, "J")
    peak = "" if si.peak_stress_MPa is None else f"{number(si.peak_stress_MPa)} MPa peak, "
    momentum = f"momentum {number(si.momentum_N_s)} N·s per blow"
    return [
        ("blow", f"{blow}, of which {taken} taken by the impact (R); {speed}"),
        ("rate", f"{number(si.blow_rate_Hz)} Hz = {number(si.blow_rate_per_min)} blows/min"),
        ("power", _power(si)),
        ("stroke", f"{number(si.stroke_mm)} mm"),
        (
            "stress",
            f"{peak}for a contact of {number(si.contact_time_us)} µs",
        ),
        ("mean force", f"{quantity(1e3 * si.mean_force_kN, 'N')}; {momentum}"),
        *([("drag", _drag(si, drag))] if si.drag_N_s_m else []),
    ]


def _power(si: SIReport) -> str:
    """Where the power goes; the blows carry more than is put in where the rebound keeps much."""
    rate = si.blow_rate_Hz
    taken = si.delivered_energy_J * rate
    kept = 1e3 * si.percussive_power_kW - taken
    efficiency = "" if si.efficiency is None else f"; efficiency {percent(si.efficiency)} of the input"
    return (
        f"input {quantity(1e3 * si.input_power_kW, 'W')}; percussive {quantity(1e3 * si.percussive_power_kW, 'W')} "
        f"(energy before the impact times rate) = {quantity(taken, 'W')} taken by the impact + "
        f"{quantity(kept, 'W')} kept by the rebound{efficiency}"
    )


def _drag(si: SIReport, drag: Drag) -> str:
    text = f"c = {number(si.drag_N_s_m)} N·s/m: {quantity(1e3 * si.drag_force_kN, 'N')} at the striking speed, "
    text += f"{percent(drag.of_mean)} of the mean push"
    return text if drag.of_input is None else f"{text}; damping takes {percent(drag.of_input)} of the input"


def _plain_rows(answer: OrbitAnswer) -> list[tuple[str, str]]:
    orbit = answer.orbit
    speed = f"{number(orbit.impact_velocity, 6)} at the striking end, {number(orbit.rigid_velocity, 6)} on average"
    return [
        ("striking speed", speed),
        (
            "blow energy",
            f"{number(orbit.blow_energy, 6)}, of which {number(orbit.delivered_energy, 6)} taken by the impact (R)",
        ),
        ("stroke", number(orbit.stroke, 6)),
        *([("drag", _plain_drag(answer.drag))] if orbit.system.d else []),
    ]


def _plain_drag(drag: Drag) -> str:
    text = f"{number(drag.force)} at the striking speed, {percent(drag.of_mean)} of the mean push"
    return text if drag.of_input is None else f"{text}; damping takes {percent(drag.of_input)} of the input"


def _energy(answer: OrbitAnswer) -> str:
    orbit, system = answer.orbit, answer.orbit.system
    energy = orbit.energy
    values = (energy.input, energy.impact, energy.damping)
    if system.is_si:
        texts = [quantity(value * system.energy_scale, "J") for value in values]
    else:
        texts = [number(value, 5) for value in values]
    misses = abs(energy.imbalance) / max(abs(energy.input), abs(energy.impact), 1e-300)
    closing = f"closes to {number(misses, 2)} ({counted(orbit.modes, 'mode')})"
    return f"{texts[0]} in per impact = {texts[1]} to the impact + {texts[2]} to damping; {closing}"
