"""A motion in short: its label, its transient, its blow rate, and what that means in SI units."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from percuss.model import System
from percuss.model.checks import Array
from percuss.shown import Shown
from percuss.simulate.events import CHATTER, IMPACT, Events

__all__ = ["Cycle", "SISummary", "Summary", "label_of", "main_blows", "summary_of"]

_TURN = 2.0 * np.pi
_FEW = 20  # impacts too few to throw half of them away
_SHOWN = 12  # most main blows of a cycle that are told one by one


@dataclass(frozen=True)
class Cycle(Shown):
    """A periodic motion that was found.

    Attributes
    ----------
    first
        The impact, numbered from 0, from which on the motion is on the cycle to within the tolerance.
    impacts, periods
        p impacts in n load periods.
    kind
        0: no rest; 1: with rest; 2: with rest at the end of complete chatter.
    """

    first: int
    impacts: int
    periods: int
    kind: int


@dataclass(frozen=True)
class SISummary(Shown):
    """The figures of a summary in the units of its field; each name ends in its unit. None where nothing strikes."""

    blow_rate_Hz: float | None
    main_blow_rate_Hz: float | None
    impact_velocity_m_s: float | None
    blow_energy_J: float | None
    delivered_energy_J: float | None
    delivered_power_kW: float | None
    cycle_velocities_m_s: tuple[float, ...] | None
    cycle_energies_J: tuple[float, ...] | None
    delivered_energy_per_period_J: float | None


@dataclass(frozen=True)
class Summary(Shown):
    """Means over the settled part of a motion; dimensionless.

    Attributes
    ----------
    impacts
        In the whole motion.
    first, last
        The settled part: from this impact to that one, numbered from 0. Whole cycles when a periodic motion was
        found, else the second half (all of them when they are fewer than 20, or when the bar has come to rest or left
        for good: then there are no rates).
    blow_rate, main_blow_rate
        Impacts per load period; main: a completed chatter counts once, at its first impact. None with fewer than two.
    interval_mean, interval_std
        Of the times between impacts, in radians; None with fewer than two impacts.
    main_interval_mean, main_interval_std
        The same between main blows.
    impact_velocity
        Mean striking speed of the main blows.
    blow_energy
        Mean kinetic energy just before a main blow, all modes.
    cycle_velocities, cycle_energies
        Striking speed and blow energy of each main blow of one cycle, in order of time; None when no periodic motion
        was found, or one with more than 12 main blows.
    energy_lost_per_period
        Taken by impacts, chatter and rest, per load period; None with fewer than two impacts.
    si
        For a system made from SI.
    """

    impacts: int
    first: int
    last: int
    blow_rate: float | None
    main_blow_rate: float | None
    interval_mean: float | None
    interval_std: float | None
    main_interval_mean: float | None
    main_interval_std: float | None
    impact_velocity: float | None
    blow_energy: float | None
    cycle_velocities: tuple[float, ...] | None
    cycle_energies: tuple[float, ...] | None
    energy_lost_per_period: float | None
    si: SISummary | None


def label_of(outcome: str, cycle: Cycle | None, wanders: bool) -> str:
    """The motion's name: ``z=p/n``, ``rest/n``, ``chatter/n``, ``rest``, ``departed``, ``aperiodic`` or ``undecided``.

    Parameters
    ----------
    outcome
        How the simulation ended.
    cycle
        The periodic motion, when one was found.
    wanders
        Whether the last impacts do not come near any of the ones before, or the period hangs on rounding.
    """
    if outcome in ("rest", "departed"):
        return outcome
    if cycle is not None:
        return (f"z={cycle.impacts}/{cycle.periods}", f"rest/{cycle.periods}", f"chatter/{cycle.periods}")[cycle.kind]
    return "aperiodic" if wanders else "undecided"


def main_blows(events: Events) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
    """Which of the impacts are main blows: all but the bounces of a completed chatter.

    Those are the impacts in front of its end, in an unbroken row, whose flight is shorter than the one before it while
    the load has not pulled, or shorter than a wave through the bar takes. The blow that they follow is the main one.
    """
    struck = np.flatnonzero(events.code == IMPACT)
    main = np.ones(struck.size, dtype=bool)
    for at in np.flatnonzero(events.code == CHATTER):
        last = int(np.searchsorted(struck, at))
        main[max(last - int(events.resolved[at]) + 1, 0) : last] = False
    return main


def summary_of(system: System, events: Events, cycle: Cycle | None, over: bool = False) -> Summary:
    """Means over the settled part of a motion: of the cycle, or of the second half when none was found.

    `over`: the motion has ended for good, in rest or by leaving; it has no rates then, and the rest is of all impacts.
    """
    struck = events.of("impact")
    n = len(struck)
    first, last = (0, max(n - 1, 0)) if over else _settled(events, struck, cycle)
    part = struck[first : last + 1]
    main = main_blows(events)[first : last + 1]
    if cycle is not None:
        main[:1] = main[-1:] = True
    blows = part[1:][main[1:]] if np.any(main[1:]) else part[main]
    mean, std = _spread(part.period[:0] if over else part.period, part.phase)
    main_mean, main_std = _spread(part.period[:0] if over else part.period[main], part.phase[main])
    taken = None
    if mean:
        at = np.flatnonzero(events.code == IMPACT)[[first, last]]  # not by time: rest may come with the impact
        taken = float(events.energy_lost[at[0] + 1 : at[1] + 1].sum()) / (mean * (len(part) - 1)) * _TURN
    speed = float(blows.impact_velocity.mean()) if len(blows) else None
    blow = float(blows.kinetic_energy.mean()) if len(blows) else None
    lost = float(blows.energy_lost.mean()) if len(blows) else None
    rate, main_rate = (None if not m else _TURN / m for m in (mean, main_mean))
    speeds, energies = _each(part[main], cycle)
    return Summary(
        n, first, last, rate, main_rate, mean, std, main_mean, main_std, speed, blow, speeds, energies, taken,
        _si(system, rate, main_rate, speed, blow, lost, taken, speeds, energies),
    )  # fmt: skip


Each = tuple[float, ...] | None


def _each(blows: Events, cycle: Cycle | None) -> tuple[Each, Each]:
    """Speeds and energies of the main blows of the last whole cycle; `blows` ends with the first one of the next."""
    if cycle is None or not len(blows):
        return None, None
    ahead = blows.time[-1] - blows.time
    one = blows[(ahead > 1e-6) & (ahead < cycle.periods * _TURN + 1e-6)]
    if not 0 < len(one) <= _SHOWN:
        return None, None
    return tuple(one.impact_velocity.tolist()), tuple(one.kinetic_energy.tolist())


def _settled(events: Events, struck: Events, cycle: Cycle | None) -> tuple[int, int]:
    """First and last impact of the settled part: whole cycles, that begin with a main blow."""
    n = len(struck)
    if cycle is None:
        return (n // 2 if n >= _FEW else 0), max(n - 1, 0)
    if cycle.kind == 0:
        return cycle.first, cycle.first + (n - 1 - cycle.first) // cycle.impacts * cycle.impacts
    released = np.searchsorted(struck.time, events.of("release").time, side="left")  # the first impacts after them
    begins = np.unique(released[(released >= cycle.first) & (released < n)])
    phases = struck.phase[begins]
    apart = np.abs(phases - phases[0]) if begins.size else phases
    same = begins[np.minimum(apart, _TURN - apart) < 1e-6]
    return (int(same[0]), int(same[-1])) if same.size > 1 else (cycle.first, n - 1)


def _spread(period: np.ndarray[tuple[int], np.dtype[np.int64]], phase: Array) -> tuple[float | None, float | None]:
    if period.size < 2:
        return None, None
    gone = np.diff(period) * _TURN + np.diff(phase)
    return float(gone.mean()), float(gone.std())


def _si(
    system: System,
    rate: float | None,
    main_rate: float | None,
    speed: float | None,
    blow: float | None,
    lost: float | None,
    taken: float | None,
    speeds: Each,
    energies: Each,
) -> SISummary | None:
    if system.frequency is None:
        return None
    f, energy = system.frequency, system.energy_scale

    def times(value: float | None, factor: float) -> float | None:
        return None if value is None else value * factor

    def each(values: Each, factor: float) -> Each:
        return None if values is None else tuple(value * factor for value in values)

    return SISummary(
        blow_rate_Hz=times(rate, f),
        main_blow_rate_Hz=times(main_rate, f),
        impact_velocity_m_s=times(speed, system.speed_scale),
        blow_energy_J=times(blow, energy),
        delivered_energy_J=times(lost, energy),
        delivered_power_kW=times(taken, 1e-3 * energy * f),
        cycle_velocities_m_s=each(speeds, system.speed_scale),
        cycle_energies_J=each(energies, energy),
        delivered_energy_per_period_J=times(taken, energy),
    )
