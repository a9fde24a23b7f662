"""A motion by waves as the report that a person reads, beside that of the contact law."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from percuss.case.answers.numerals import counted, number, percent, quantity
from percuss.cli.report_parts import BAD, GOOD, PLAIN, Grid, Report, Section
from percuss.cli.system_section import system_section

if TYPE_CHECKING:
    from percuss.blow.machine import Impacts, MachineMotion
    from percuss.case import WavesAnswer
    from percuss.case.answers.waves_answer import Beside

__all__ = ["waves_report"]

_TURN = 2.0 * math.pi
_FEW = 4  # impacts of a cycle that are told one by one


def waves_report(answer: WavesAnswer, last: int | None) -> Report:
    """The report of `percuss simulate --contact waves` with the `last` impacts; None shows all of them."""
    sections: list[Section | Grid] = [
        system_section(answer.name, answer.system, answer.notes),
        _motion_section(answer),
        _laws_grid(answer),
    ]
    if last != 0 and answer.motion.impacts.size:
        sections.append(_impacts_grid(answer.motion, last))
    text, tone = _summary(answer)
    return Report(answer.title, text, tone, tuple(sections))


def _summary(answer: WavesAnswer) -> tuple[str, str]:
    motion = answer.motion
    if motion.label == "rest":
        return "By waves the hammer comes to rest on what it strikes (rest).", BAD
    if motion.label == "none":
        return "By waves the hammer strikes nothing (none).", BAD
    if motion.settled is None:
        return "By waves no periodic motion has been found (irregular).", PLAIN
    p, n = motion.settled.impacts, motion.settled.periods
    blows = "one blow" if p == 1 else f"{p} blows"
    periods = "every load period" if n == 1 else f"in {n} load periods"
    text = f"By waves the hammer settles on {blows} {periods} ({motion.label})"
    first = answer.beside[0]
    return f"{text}; by the law {first.law}: {first.label}.", GOOD


def _motion_section(answer: WavesAnswer) -> Section:
    motion, own = answer.motion, answer.motion.cycle
    length = motion.end_time - motion.release.time
    rows = [
        ("followed", f"{number(length / _TURN, 6)} load periods; {counted(motion.impacts.size, 'impact')}"),
        ("ended", motion.ending.value),
        ("struck", _struck(motion)),
    ]
    if own.size:
        which = "" if own.size <= _FEW else f" (the first {_FEW} of {own.size})"
        rows.append(("phase", f"{_each(own.phase[:_FEW], 5)} rad at the centroid of the force{which}"))
        rows.append(("speed", f"{_speeds(motion)}, of the rigid motion there"))
        rows.append(("restitution", f"{_each(own.restitution[:_FEW], 4)}, as these impacts have it"))
        rows.append(("contact", _contact(motion)))
        rows.append(("ringing", f"{percent(float(own.ringing_share.max()))} of the energy before the impact, at most"))
        rows.append(("blow rate", _rate(motion)))
    if answer.system.is_si:
        rows.append(("given", _given(motion)))
    rows.append(("lattice", _lattice(motion)))
    rows += [("warning", warning) for warning in answer.warnings]
    return Section("Motion by waves", tuple(rows))


def _struck(motion: MachineMotion) -> str:
    from percuss.blow import Wall

    if isinstance(motion.target, Wall):
        return "a rigid wall"
    end = motion.target.end
    stays = "is fed by what each blow leaves of the penetration" if end == "rock" else "stays where a blow has put it"
    how = "is pushed back after each blow" if motion.pushed_back else stays
    ringing = "; all ringing is made to end between blows" if motion.quiet else ""
    return f"{_RODS[end]}, which {how}{ringing}"


_RODS = {
    "infinite": "a rod with an endless end",
    "fixed": "a rod with a fixed end",
    "free": "a rod with a free end",
    "rock": "a rod on rock",
}


def _given(motion: MachineMotion) -> str:
    system, own = motion.system, motion.cycle
    text = f"{quantity(motion.delivered_power * system.power_scale, 'W')} to what is struck"
    if motion.rock_power:
        text += f"; the rock keeps {quantity(motion.rock_power * system.power_scale, 'W')} of it"
    deepest = float(own.fed.max()) if own.size else 0.0
    return f"{text}; fed by {quantity(deepest * system.length_scale, 'm', 3)} after a blow" if deepest else text


def _contact(motion: MachineMotion) -> str:
    own, system = motion.cycle, motion.system
    longest = float(own.duration.max())
    time = quantity(longest * system.time_scale, "s", 3) if system.is_si else f"{number(longest)} rad"
    transits = number(longest / system.body.transit_time, 3)
    many = f"; up to {counted(int(own.contacts.max()), 'contact')} an impact" if own.contacts.max() > 1 else ""
    return f"{time} at most, {transits} transit times of the bar{many}"


def _rate(motion: MachineMotion) -> str:
    system = motion.system
    if system.frequency is not None:
        return f"{number(motion.blow_rate * system.frequency, 6)} Hz"
    return f"{number(motion.blow_rate, 6)} per load period"


def _lattice(motion: MachineMotion) -> str:
    lattice, unsure = motion.lattice, motion.uncertainty
    text = (
        f"{sum(lattice.cells[: lattice.striker])} cells, transit times rounded by {lattice.rounding:.1g} of the bar's"
    )
    if unsure is not None and unsure.phase is not None and unsure.velocity is not None:
        text += f"; with half the cells phases differ by {unsure.phase:.1g} rad, speeds by {unsure.velocity:.1g}"
    return text


def _speeds(motion: MachineMotion) -> str:
    velocities, system = motion.velocities[:_FEW], motion.system
    return f"{_each(velocities * system.speed_scale)} m/s" if system.is_si else _each(velocities, 6)


def _each(values: object, digits: int = 4) -> str:
    """Values one after another; equal ones, as they are shown, once."""
    texts = list(dict.fromkeys(number(float(value), digits) for value in values))  # type: ignore[attr-defined]
    return ", ".join(texts)


# -- beside the laws ------------------------------------------------------------------------------------------------


def _laws_grid(answer: WavesAnswer) -> Grid:
    motion = answer.motion
    own = (
        "waves",
        motion.label,
        _each(motion.phases[:_FEW], 5),
        _plain_or_si(motion, motion.velocities[:_FEW]),
        number(motion.blow_rate, 5),
        "",
        "",
    )
    unit = " [m/s]" if motion.system.is_si else ""
    columns = ("", "settles on", "phase [rad]", f"speed{unit}", "blows per period", "phase less", "speed less")
    return Grid("Beside the laws", columns, (own, *(_law_row(motion, one) for one in answer.beside)))


def _law_row(motion: MachineMotion, one: Beside) -> tuple[str, ...]:
    return (
        one.law,
        one.label or "",
        _each(one.phases[:_FEW], 5),
        _plain_or_si(motion, one.velocities[:_FEW]),
        "" if one.blow_rate is None else number(one.blow_rate, 5),
        "" if one.phase_difference is None else f"{one.phase_difference:+.2g}",
        "" if one.velocity_difference is None else f"{100.0 * one.velocity_difference:+.2g} %",
    )


def _plain_or_si(motion: MachineMotion, velocities: object) -> str:
    scale = motion.system.speed_scale if motion.system.is_si else 1.0
    return _each([float(v) * scale for v in velocities], 4)  # type: ignore[attr-defined]


# -- impacts --------------------------------------------------------------------------------------------------------


def _impacts_grid(motion: MachineMotion, last: int | None) -> Grid:
    every, system = motion.impacts, motion.system
    part = every if last is None else every.part(slice(max(every.size - last, 0), every.size))
    shown = f"all {every.size}" if part.size == every.size else f"last {part.size} of {every.size}"
    time, speed = ("start [s]", "speed [m/s]") if system.is_si else ("start [rad]", "speed")
    columns = (time, "phase [rad]", "contacts", speed, "restitution", "ringing")
    return Grid(f"Impacts ({shown})", columns, tuple(_row(motion, part, i) for i in range(part.size)))


def _row(motion: MachineMotion, part: Impacts, i: int) -> tuple[str, ...]:
    system = motion.system
    time, speed = (system.time_scale, system.speed_scale) if system.is_si else (1.0, 1.0)
    return (
        f"{part.start[i] * time:.6f}",
        f"{part.phase[i]:.6f}",
        str(int(part.contacts[i])),
        f"{part.velocity[i] * speed:.5g}",
        f"{part.restitution[i]:.4f}",
        percent(float(part.ringing_share[i])),
    )
