"""A motion by waves in plain values with the names that other programs read; every number finite or null."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from percuss.case.answers.json_values import number, numbers, plain

if TYPE_CHECKING:
    from percuss.blow.machine import MachineMotion

__all__ = ["waves_dict"]


def waves_dict(
    motion: MachineMotion, warnings: Sequence[str], beside: list[dict[str, Any]], last: int | None = None
) -> dict[str, Any]:
    """The JSON object of a motion by waves.

    Parameters
    ----------
    beside
        What the laws say, in plain values.
    last
        The number of last impacts to keep; None keeps all.
    """
    return {
        "outcome": motion.ending.name.lower(),
        "label": motion.label,
        "begin_time": number(motion.release.time),
        "end_time": number(motion.end_time),
        "grazes": motion.grazes,
        "pushed_back": motion.pushed_back,
        "quiet": motion.quiet,
        "lattice": {
            "steps": motion.lattice.steps,
            "cells": list(motion.lattice.cells),
            "rounding": number(motion.lattice.rounding),
        },
        "uncertainty": None if motion.uncertainty is None else plain(asdict(motion.uncertainty)),
        "warnings": list(warnings),
        "settled": _settled(motion),
        "energy": plain({**asdict(motion.energy), "error": motion.energy.error}),
        "beside": beside,
        "impacts": _impacts(motion, last),
    }


def _settled(motion: MachineMotion) -> dict[str, Any]:
    """The figures of a cycle, or of the last half of the impacts."""
    own, system = motion.cycle, motion.system
    found: dict[str, Any] = {
        "impacts": own.size,
        "phases": numbers(own.phase),
        "velocities": numbers(own.velocity),
        "restitutions": numbers(own.restitution),
        "ringing_shares": numbers(own.ringing_share),
        "blow_rate": number(motion.blow_rate),
        "impulse_per_period": number(motion.impulse_per_period),
        "delivered_power": number(motion.delivered_power),
        "rock_power": number(motion.rock_power),
        "si": None,
    }
    if system.is_si and system.frequency is not None:
        found["si"] = {
            "velocities_m_s": numbers(own.velocity * system.speed_scale),
            "durations_s": numbers(own.duration * system.time_scale),
            "peak_forces_N": numbers(own.peak_force * system.force_scale),
            "given_J": numbers(own.given * system.energy_scale),
            "rock_work_J": numbers(own.rock_work * system.energy_scale),
            "fed_m": numbers(own.fed * system.length_scale),
            "blow_rate_Hz": number(motion.blow_rate * system.frequency),
            "delivered_power_kW": number(1e-3 * motion.delivered_power * system.power_scale),
        }
    return found


def _impacts(motion: MachineMotion, last: int | None) -> list[dict[str, Any]]:
    every = motion.impacts
    part = every if last is None else every.part(slice(max(every.size - last, 0), every.size))
    seconds = motion.system.time_scale if motion.system.is_si else None
    return [
        {
            "start": number(part.start[i]),
            "start_s": None if seconds is None else number(part.start[i] * seconds),
            "end": number(part.end[i]),
            "contacts": int(part.contacts[i]),
            "phase": number(part.phase[i]),
            "impulse": number(part.impulse[i]),
            "velocity": number(part.velocity[i]),
            "mean_velocity_before": number(part.mean_before[i]),
            "mean_velocity_after": number(part.mean_after[i]),
            "restitution": number(part.restitution[i]),
            "peak_force": number(part.peak_force[i]),
            "ringing_share": number(part.ringing_share[i]),
            "given": number(part.given[i]),
            "rock_work": number(part.rock_work[i]),
            "fed": number(part.fed[i]),
        }
        for i in range(part.size)
    ]
