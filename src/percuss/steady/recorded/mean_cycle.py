"""The motion of the mean cycle: which of the possible blows it has, and what is done where there is none."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from percuss.errors import LoadError
from percuss.model import System
from percuss.model.checks import Array, finite
from percuss.steady.orbit import Orbit
from percuss.steady.phase_condition import phase_condition
from percuss.steady.recorded.edges import changes
from percuss.steady.recorded.force_record import ForceRecord
from percuss.steady.recorded.implied import Implied, implied_by_orbit, implied_by_record
from percuss.steady.states import SteadyStates

__all__ = ["MeanCycle", "mean_cycle", "measured_phase"]

_TURN = 2.0 * math.pi
_SAMPLES = 4096
_INTO = 1e-6  # of the stroke, how far rounding takes a piston through the wall


@dataclass(frozen=True)
class MeanCycle:
    """The mean cycle from blow to blow.

    Parameters
    ----------
    system
        The clocked system, with another mean load where that was needed for a motion.
    phase
        Of the load at the blow.
    motion
        In the unit of time of the machine.
    notes
        What was taken for granted.
    """

    system: System
    phase: float
    motion: Implied
    notes: tuple[str, ...]


def measured_phase(record: ForceRecord, phases: Array) -> float | None:
    """The mean phase of the load at the measured blows, or None without any."""
    if record.blows is None:
        return None
    struck = np.interp(record.blows, record.time, phases, left=np.nan, right=np.nan)
    struck = struck[np.isfinite(struck)]
    return float(np.angle(np.exp(1j * struck).mean()) % _TURN) if struck.size else None


def mean_cycle(states: SteadyStates, rate: float, blow: float | None, measured: float | None) -> MeanCycle:
    """The motion of the mean cycle.

    Parameters
    ----------
    states
        The motions under the clocked load.
    rate
        The load's phase that goes by in a unit of time of the machine.
    blow
        Phase at which the blow is: the nearest root is taken.
    measured
        Phase at which it was measured: the motion is the one that strikes there, whatever the restitution.
    """
    system = states.system
    if measured is not None:
        t = np.linspace(0.0, _TURN, _SAMPLES + 1)
        force = np.asarray(system.load.value(measured + t))
        motion = implied_by_record(t, force, np.array([0.0, _TURN]), system.d)
        note = "the blows are where they were measured, and the restitution is that of the record"
        return MeanCycle(system, measured, _in_time(motion, rate), (note,))
    if not states.orbits:
        orbit, note = _at_the_fold(states)
        return MeanCycle(orbit.system, orbit.phase, _in_time(implied_by_orbit(orbit), rate), (note,))
    fall = _TURN * float(np.argmin(changes(_sampled(system)))) / _SAMPLES
    wanted = fall if blow is None else finite("blow", blow)
    possible = [one for one in states.orbits if _stays_off(implied_by_orbit(one))]
    if not possible:
        raise LoadError(
            "the piston would pass through the wall in every motion that has the momentum of this load",
            "give the whole force on the piston, of a machine with one blow in a period",
        )
    orbit = min(possible, key=lambda one: abs(math.remainder(one.phase - wanted, _TURN)))
    notes = []
    if blow is None and len(possible) > 1:
        others = ", ".join(f"{one.phase:.4g}" for one in possible if one is not orbit)
        notes.append(
            f"where the blow falls was not measured: of the possible phases, {orbit.phase:.4g} rad is nearest to the "
            f"fall of the force ({others} rad besides)"
        )
    return MeanCycle(system, orbit.phase, _in_time(implied_by_orbit(orbit), rate), tuple(notes))


def _stays_off(motion: Implied) -> bool:
    """Whether the piston of a motion is behind the wall all the time."""
    return bool(motion.behind.min() >= -_INTO * motion.behind.max())


def _at_the_fold(states: SteadyStates) -> tuple[Orbit, str]:
    """The motion at the tip of v_f, which a smaller mean load allows: the blow as the force falls."""
    system, nearest = states.system, states.nearest
    assert nearest is not None
    arcs = phase_condition(system, 1).arcs
    tip = float(arcs.ends[int(np.argmax(arcs.velocities))]) % _TURN
    note = (
        f"no blow fits the whole load, so that its mean is taken {1.0 - nearest.mean / system.load.mean:.2g} of itself "
        "lower: then the blow comes just as the force falls"
    )
    return Orbit(system.with_load(system.load.with_mean(nearest.mean)), 1, tip, True), note


def _sampled(system: System) -> Array:
    return np.asarray(system.load.value(_TURN * np.arange(_SAMPLES) / _SAMPLES))


def _in_time(motion: Implied, rate: float) -> Implied:
    """The same motion in another unit of time."""
    return Implied(
        motion.time / rate, motion.force * rate**2, motion.behind, motion.velocity * rate, motion.blows / rate
    )
