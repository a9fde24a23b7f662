"""The events of a motion, as columns, whatever drives it; and the motion in short."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any, Self, overload

import numpy as np
import numpy.typing as npt

from percuss.model import System
from percuss.model.checks import Array, choice
from percuss.short_repr import ShortRepr
from percuss.simulate.kernels.motion_records import LOST_CYCLE

KINDS = ("impact", "grazing", "chatter", "rest", "release", "port", "valve")
"""Kinds of events, in the order of their numbers; the last two are those of a machine."""

IMPACT, GRAZING, CHATTER, REST, RELEASE, PORT, VALVE = range(len(KINDS))

_TURN = 2.0 * np.pi
_NO_REBOUND = 1e-12  # of the greatest rebound
_NOTHING = 1e-300


@dataclass(frozen=True)
class Event(ShortRepr):
    """One event; see `Events`. `state`: the name of the valve's state; `port`: None but for a port's demand."""

    kind: str
    time: float
    phase: float
    impact_velocity: float
    rebound_velocity: float
    energy_lost: float
    resolved: int
    kinetic_energy: float
    period: int
    piece: int
    state: str | None = None
    port: int | None = None


@dataclass(frozen=True)
class Events(ShortRepr):
    """The events of a motion in order of time, one array for each quantity, all of shape (n,).

    ``events[i]`` is one `Event`; a slice, a mask or an array of numbers gives the `Events` of it.

    Attributes
    ----------
    kind
        What happened: ``impact``; ``grazing``, a touch that rounding does not tell from a miss, after which the bar
        goes on unchanged; ``chatter``, the end of infinitely many impacts in finite time; ``rest``, the bar lies on
        the wall from now on; ``release``, the load pulls it off. Of a machine besides: ``port``, a port demands a
        state that was not the last one demanded; ``valve``, the state of the valve has changed.
    period, phase
        When: load periods gone by, and the phase of the load in [0, 2π). Together they are exact however long the
        motion lasts. A machine has no clock: its period is 0, and its phase the time in the machine's unit.
    time
        2π · period + phase.
    impact_velocity, rebound_velocity
        Velocity u_t(1) of the striking end before and after the event; the first at a port is that of what it reads.
    energy_lost
        What the event takes from the bar. Rest takes what motion and strain is left.
    kinetic_energy
        Just before an impact, all modes: the blow energy. 0 for other events.
    resolved
        Of a chatter: how many of its impacts are recorded singly before it, the main blow first.
    piece
        Number of the load's step that holds, for a load of steps; of a machine that of the valve's state, after it.
    port
        The number of the port that demands; −1 for other events.
    states
        The names of the valve's states; none under a clock.
    """

    code: npt.NDArray[np.int8]
    period: npt.NDArray[np.int64]
    phase: Array
    impact_velocity: Array
    rebound_velocity: Array
    energy_lost: Array
    kinetic_energy: Array
    resolved: npt.NDArray[np.int64]
    piece: npt.NDArray[np.int64]
    port: npt.NDArray[np.int64]
    states: tuple[str, ...] = ()

    @property
    def time(self) -> Array:
        """2π · period + phase; shape (n,)."""
        return self.period * _TURN + self.phase

    @property
    def kind(self) -> npt.NDArray[np.str_]:
        """The kinds as words; shape (n,)."""
        return np.array(KINDS)[self.code]

    def of(self, kind: str) -> Self:
        """The events of one kind."""
        choice("kind", kind, *(KINDS if self.states else KINDS[:PORT]))
        which: npt.NDArray[np.bool_] = self.code == KINDS.index(kind)
        return self[which]

    @property
    def held_down(self) -> Array:
        """What each rest gave up at which the load held the bar in the time of one contact, over the greatest blow.

        Such a rest comes at once after an impact with a rebound, by a law that turns the strain over; of energies.
        """
        code, time, back, numbers = self.code, self.time, self.rebound_velocity, np.arange(len(self))
        last = np.maximum.accumulate(np.where(code == IMPACT, numbers, -1))
        laid = (code == CHATTER) | ((code == REST) & (np.roll(code, 1) != CHATTER))
        at = numbers[laid & (last >= 0)]
        slow = _NO_REBOUND * np.abs(back).max(initial=0.0)
        at = at[(time[at] == time[last[at]]) & (back[last[at]] < -slow)]
        return np.asarray(self.energy_lost[at] / self.kinetic_energy.max(initial=_NOTHING), dtype=float)

    def __str__(self) -> str:
        numbers = np.bincount(self.code, minlength=len(KINDS)).tolist()
        kinds = ", ".join(f"{n} {kind}" for n, kind in zip(numbers, KINDS, strict=True) if n)
        return f"Events: {kinds or 'none'}"

    def __len__(self) -> int:
        return int(self.code.size)

    @overload
    def __getitem__(self, which: int | np.integer) -> Event: ...
    @overload
    def __getitem__(self, which: slice | npt.NDArray[np.bool_] | npt.NDArray[np.intp]) -> Self: ...
    def __getitem__(
        self, which: int | np.integer | slice | npt.NDArray[np.bool_] | npt.NDArray[np.intp]
    ) -> Event | Self:
        """One event by its number, from the end when negative; the events of a slice, a mask or an array of numbers."""
        if isinstance(which, int | np.integer) and not isinstance(which, bool):
            return self._one(range(len(self))[which])
        return replace(self, **{name: column[which] for name, column in self.columns().items()})

    def __iter__(self) -> Iterator[Event]:
        return map(self._one, range(len(self)))

    def _one(self, i: int) -> Event:
        return Event(
            KINDS[self.code[i]],
            float(self.period[i] * _TURN + self.phase[i]),
            float(self.phase[i]),
            float(self.impact_velocity[i]),
            float(self.rebound_velocity[i]),
            float(self.energy_lost[i]),
            int(self.resolved[i]),
            float(self.kinetic_energy[i]),
            int(self.period[i]),
            int(self.piece[i]),
            self.states[self.piece[i]] if self.states else None,
            int(self.port[i]) if self.port[i] >= 0 else None,
        )

    def columns(self) -> dict[str, Any]:
        """What has an entry for each event, by name."""
        return {field.name: getattr(self, field.name) for field in fields(self) if field.name != "states"}


def joined(parts: Sequence[Events]) -> Events:
    """The events of several stretches of one motion, one after the other."""
    if len(parts) == 1:
        return parts[0]
    columns: dict[str, Any] = {
        name: np.concatenate([getattr(part, name) for part in parts]) for name in parts[0].columns()
    }
    return replace(parts[0], **columns)


# ---- A motion in short: its label, its transient, its blow rate, and what that means in SI units

_FEW = 20  # impacts too few to throw half of them away
_SHOWN = 12  # most main blows of a cycle that are told one by one


@dataclass(frozen=True)
class MotionCycle(ShortRepr):
    """A periodic motion that was found.

    Attributes
    ----------
    first
        The impact, numbered from 0, from which on the motion is on the cycle to within the tolerance.
    impacts, periods
        p impacts in n load periods; of a machine the main blows in a period, and how often the valve comes to the same
        state in it.
    kind
        0: no rest; 1: with rest; 2: with rest at the end of complete chatter.
    period, energy_lost, blow_speed
        Of a machine: the period in its unit of time, what blows, chatter and rest take in it, per unit of mass, and
        the striking speed of the strongest blow; 0 under a clock.
    """

    first: int
    impacts: int
    periods: int
    kind: int
    period: float = 0.0
    energy_lost: float = 0.0
    blow_speed: float = 0.0


@dataclass(frozen=True)
class SISummary(ShortRepr):
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
class Summary(ShortRepr):
    """Means over the settled part of a motion; dimensionless.

    Attributes
    ----------
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


OPEN_CYCLES = ("", "rest/?", "chatter/?")  # cycles with rest whose number of load periods hangs on rounding, by kind


def label_of(outcome: str, cycle: MotionCycle | None, wanders: bool, kind: int = 0) -> str:
    """``z=p/n``, ``rest/n``, ``chatter/n``, ``rest``, ``departed``, ``aperiodic`` or ``undecided``."""
    # Of a cycle with rest whose n hangs on rounding, `kind` 1 or 2 with chatter, ``rest/?`` or ``chatter/?``.
    # `wanders`: whether the last impacts come near none before.
    if outcome in ("rest", "departed"):
        return outcome
    if cycle is not None:
        return (f"z={cycle.impacts}/{cycle.periods}", f"rest/{cycle.periods}", f"chatter/{cycle.periods}")[cycle.kind]
    return OPEN_CYCLES[kind] if kind else "aperiodic" if wanders else "undecided"


def main_blows(events: Events) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
    """Which of the impacts are main blows: all but the bounces of a completed chatter."""
    # Those are the impacts in front of its end, in an unbroken row, whose flight is shorter than the one before it
    # while the load has not pulled, or shorter than a wave through the bar takes. The blow that they follow is the main
    # one.
    struck = np.flatnonzero(events.code == IMPACT)
    main = np.ones(struck.size, dtype=bool)
    for at in np.flatnonzero(events.code == CHATTER):
        last = int(np.searchsorted(struck, at))
        main[max(last - int(events.resolved[at]) + 1, 0) : last] = False
    return main


def summary_of(system: System, events: Events, cycle: MotionCycle | None, over: bool = False) -> Summary:
    """Means over the cycle, or the second half when none was found; over all, without rates, if it is `over`."""
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


def _each(blows: Events, cycle: MotionCycle | None) -> tuple[Each, Each]:
    """Speeds and energies of the main blows of the last whole cycle; `blows` ends with the first one of the next."""
    if cycle is None or not len(blows):
        return None, None
    ahead = blows.time[-1] - blows.time
    one = blows[(ahead > 1e-6) & (ahead < cycle.periods * _TURN + 1e-6)]
    if not 0 < len(one) <= _SHOWN:
        return None, None
    return tuple(one.impact_velocity.tolist()), tuple(one.kinetic_energy.tolist())


def _settled(events: Events, struck: Events, cycle: MotionCycle | None) -> tuple[int, int]:
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
    f, pace, energy = system.frequency, system.speed_scale, system.energy_scale
    scaled: dict[str, tuple[float | Each, float]] = {
        "blow_rate_Hz": (rate, f),
        "main_blow_rate_Hz": (main_rate, f),
        "impact_velocity_m_s": (speed, pace),
        "blow_energy_J": (blow, energy),
        "delivered_energy_J": (lost, energy),
        "delivered_power_kW": (taken, 1e-3 * energy * f),
        "cycle_velocities_m_s": (speeds, pace),
        "cycle_energies_J": (energies, energy),
        "delivered_energy_per_period_J": (taken, energy),
    }
    found: dict[str, Any] = {
        name: tuple(one * factor for one in value) if isinstance(value, tuple) else value and value * factor
        for name, (value, factor) in scaled.items()
    }
    return SISummary(**found)


# ---- A machine's motion in short: where it stalls, and its label

STALLS = ("on the tool", "in the chamber", "on a port", "leaves", "without pressure")
"""How a machine stalls: it lies on the wall and no order waits; it swings on the gas of its chamber, with ever
weaker blows or none; the valve switches to and fro at a port without end; it leaves and never comes back; the pressure
of its supply falls to 0. Each is proved."""


def machine_label(ended: str, cycle: MotionCycle | None, wanders: bool) -> str:
    """The motion's name, of one that `ended` so, one of `STALLS` among them."""
    # ``runs p/n``, p blows and n valve cycles in a period, as orbits are labelled; ``double blow p/n`` with two blows
    # or more in a valve cycle; ``runs rest/n`` or ``runs chatter/n`` with a rest on the wall; ``cycles without blow``;
    # ``stalls (…)``, see `STALLS`; ``irregular`` when the last changes of the valve come near none before, or
    # ``undecided`` where too little was followed to tell.
    if ended in STALLS:
        return f"stalls ({ended})"
    if cycle is None:
        return "irregular" if wanders else "undecided"
    if cycle.impacts == 0:
        return "cycles without blow"
    numbers = f"{cycle.impacts}/{cycle.periods}"
    if cycle.kind:
        return f"runs {('rest', 'chatter')[cycle.kind - 1]}/{cycle.periods}"
    return f"double blow {numbers}" if cycle.impacts >= 2 * cycle.periods else f"runs {numbers}"


def unresolved(count: npt.NDArray[Any]) -> int:
    """The kind of a cycle with rest whose number of load periods is lost, by the engine's whole numbers; else 0."""
    return int(count["cycle_kind"][0]) if count["verdict"][0] == LOST_CYCLE else 0
