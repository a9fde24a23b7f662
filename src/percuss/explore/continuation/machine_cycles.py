"""Cycles of machines that switch their own valve, as a curve over one parameter or two: equations, and what ends them.

The unknowns are the times of the guarded events of one order of events, ports and blows, the last of which is the
period; see `percuss.steady.self_excited.event_sequence`. The equations know nothing of what else the bar might meet, so
that they go on smoothly beyond every end of the branch: there a margin changes its sign, which is how it is located.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from percuss.errors import PercussError
from percuss.explore.continuation.branch import BranchEvent
from percuss.explore.continuation.branch_events import outside
from percuss.explore.continuation.orbit_curve import ParameterRows
from percuss.explore.continuation.walk import CorrectorFailed, CurvePoint, Problem
from percuss.explore.family import SwitchingFamily
from percuss.halting import check_interrupted
from percuss.mechanics.cycle import Cycle, closure_kernels
from percuss.model import Machine
from percuss.model.checks import Array
from percuss.steady.self_excited.event_sequence import EventSequence, Fault, reordered, sequence_in
from percuss.steady.self_excited.valve_cycle import ValveCycle

# ---- The cycles of an order of events

_KEPT = 256  # motions
_MOST_STEPS, _CLOSE, _LONGEST = 16, 1e-7, 0.5
_MOST_ROWS, _RATE_WITHIN, _ROW_WITHIN = 8, 1e-4, 1e-9  # of the unit of the parameter
_SILENT = 2.0 * math.log(1e3)  # of a mode within a cycle, from which on nothing of it comes back
_ROUNDED, _INSTANT = 1e-8, 1e-7  # of a flight, before its end; of the period: nothing is met in a shorter flight


@dataclass(frozen=True)
class MachineCurve(Problem):
    """The cycles of a family of machines with an order of events and N modes; times are counted in `tick`s."""

    family: SwitchingFamily
    names: tuple[str, ...]
    units: tuple[float, ...]
    sequence: EventSequence
    modes: int
    tick: float
    periods = 1
    difference = 1e-5

    @cached_property
    def impacts(self) -> int:  # type: ignore[override]
        """How many of the unknowns are times."""
        return sum(event.kind != "due" for event in self.sequence.events)

    @property
    def places(self) -> tuple[int, ...]:
        return tuple(range(self.impacts, self.impacts + len(self.names)))

    @property
    def label(self) -> str:
        """Blows and valve cycles."""
        return self.sequence.label

    def of(self, sequence: EventSequence) -> MachineCurve:
        """The cycles of another order of events, of the same machines."""
        return replace(self, sequence=sequence)

    # -- machines and motions --

    def system(self, *values: float) -> Machine:  # type: ignore[override]
        """The machine at values of the parameters; PercussError where there is none."""
        known = self._machines
        if values not in known:
            if len(known) > _KEPT:
                known.clear()
            known[values] = self.family.machine(dict(zip(self.names, values, strict=True)))
        return known[values]

    @cached_property
    def _machines(self) -> dict[tuple[float, ...], Machine]:
        return {}

    def refusal(self, *values: float) -> PercussError | None:
        """Why there is no machine."""
        try:
            self.system(*values)
        except PercussError as error:
            return error
        return None

    @cached_property
    def _motions(self) -> dict[bytes, ValveCycle]:
        return {}

    def motion(self, x: Array) -> ValveCycle:
        """The motion at a point."""
        key = x[: self.places[-1] + 1].tobytes()
        if key not in self._motions:
            if len(self._motions) > _KEPT:
                self._motions.clear()
            machine = self.system(*self.values(x))
            with np.errstate(all="ignore"):  # a guard that is met without speed
                self._motions[key] = self.sequence.cycle(machine, self.modes, self.times(x))
        return self._motions[key]

    def times(self, x: Array) -> Array:
        """The unknown times, in the unit of the machines."""
        return x[: self.impacts] * self.tick

    def value(self, x: Array) -> float:
        """The parameter at a point, or the first of two."""
        return self.values(x)[0]

    def unknowns(self, cycle: ValveCycle, *values: float) -> Array:
        """The point of a cycle."""
        return np.append(self.sequence.unknowns(cycle) / self.tick, np.divide(values, self.units))

    # -- the equations --

    def _closed(self, x: Array) -> Any:
        with np.errstate(all="ignore"):
            found = self.sequence.closed(self.system(*self.values(x)), self.modes, self.times(x))
        if not np.all(np.isfinite(found.slope)):
            raise CorrectorFailed("no motion")
        return found

    def residual(self, x: Array) -> Array:
        return np.asarray(self._closed(x).error)

    def matrix(self, x: Array) -> Array:
        return self.linearised(x)[0]

    def linearised(self, x: Array) -> tuple[Array, Array]:
        closed = self._closed(x)
        return np.hstack([closed.slope * self.tick, self.by_differences(x, self.places)]), np.asarray(closed.error)

    @cached_property
    def rows(self) -> ParameterRows[Cycle]:
        """The numbers of the cycle for compiled functions, over its one parameter."""
        return ParameterRows(self._posed, self.units[0])

    def _posed(self, value: float) -> Cycle:
        return self.sequence.posed(self.system(value), self.modes)

    @cached_property
    def _rooms(self) -> dict[int, Any]:
        return {}

    def _room(self, posed: Cycle) -> Any:
        return self._rooms.get(posed.row.size) or self._rooms.setdefault(posed.row.size, posed.room)

    def corrected(self, start: Array, normal: Array, along: Array, near: CurvePoint) -> CurvePoint:
        """As of other curves, over one parameter, by compiled functions."""
        check_interrupted()
        x, m, unit, steps = np.array(start), self.impacts, self.units[0], 0
        matrix, tangent = np.empty((m, m + 1)), np.empty(m + 1)
        try:
            for _ in range(_MOST_ROWS):
                base, posed, rate = self.rows.near(self.value(x), _RATE_WITHIN * unit)
                ended, taken = closure_kernels().corrected(
                    posed.row, rate, base, unit, self.tick, self._room(posed), x, normal, along,
                    (_MOST_STEPS, _CLOSE, _LONGEST), matrix, tangent,
                )  # fmt: skip
                if ended:
                    raise CorrectorFailed("no convergence, or a step too long")
                steps = steps or taken
                x = np.where(normal == 1.0, start, x)
                near_it = abs(self.value(x) - base) <= _ROW_WITHIN * unit
                if near_it or self.rows.fits(base, rate, self.value(x)):
                    return CurvePoint(x, tangent, steps, matrix, self)
        except PercussError as error:
            raise CorrectorFailed(str(error)) from error
        raise CorrectorFailed("no convergence")

    def flights(self, x: Array) -> Array:
        """The period alone: that events keep their order is looked at as what ends a branch."""
        return x[self.impacts - 1 : self.impacts]

    def apart(self, x: Array, first: Array) -> Array:
        return x - first

    def along(self, cycles: Sequence[ValveCycle]) -> dict[str, Any]:
        """What a branch has of cycles, by the names of its columns."""
        return {
            "times": np.array([cycle.blow_times for cycle in cycles]),
            "speeds": np.array([cycle.blow_speeds for cycle in cycles]),
            "cycle_times": np.array([cycle.period for cycle in cycles]),
            "energies": np.array([float(cycle.blow_energies.mean()) for cycle in cycles]),
        }

    # -- numbers that vanish where stability changes --

    def unstable(self, x: Array) -> int:
        """How many multipliers are outside; they are found only where powers of the map do not shrink."""
        cycle = self.motion(x)
        return 0 if cycle.contraction < 1.0 else outside(cycle.multipliers().values)

    def fold(self, point: CurvePoint) -> float:
        """Where a multiplier is 1."""
        matrix = self.matrix(point.x) if point.matrix is None else point.matrix
        own = matrix[:, : self.impacts]
        return float(np.linalg.det(own / np.linalg.norm(matrix, axis=1, keepdims=True)))

    def flip(self, point: CurvePoint) -> float:
        """Where a multiplier is −1."""
        found = self.motion(point.x).slope
        with np.errstate(all="ignore"):
            return float(np.linalg.det(np.eye(len(found)) + found))

    def flips_about(self, first: CurvePoint, stop: CurvePoint) -> tuple[Callable[[Array], float], float]:
        """A quick `flip` between two points, and by how much (rad) the fastest mode that still rings goes on."""
        # the numbers of machines in between are taken to change evenly
        here, there = (self.value(point.x) for point in (first, stop))
        posed, other = self._posed(here), self._posed(there)
        room, size = self._room(posed), 2 * posed.size + posed.supplied + posed.wrapped
        found, past = np.empty((size, size)), int(self.modes == 0)
        unit = np.eye(size - past)

        def quick(x: Array) -> float:
            share = (self.value(x) - here) / (there - here) if there != here else 0.0
            room.numbers[:] = posed.row + share * (other.row - posed.row)
            with np.errstate(all="ignore"):
                good = closure_kernels().solved(room, self.times(x), 0, found)
                return float(np.linalg.det(unit + found[past:, past:])) if good else np.nan

        modes, faster = posed.flows[0].modes, other.flows[0].modes.omega
        spans = [np.diff(self.times(point.x), prepend=0.0) for point in (first, stop)]
        turned = np.abs(np.outer(modes.omega, spans[0]) - np.outer(faster, spans[1])).sum(axis=1)
        return quick, float(turned[modes.damping * spans[0].sum() < _SILENT].max(initial=0.0))

    # -- orders of events with twice and half as many blows --

    def doubled(self, x: Array) -> tuple[MachineCurve, Array] | None:
        """The curve of cycles of two of these, and its unknowns; None where there is no such order."""
        m, rhythm = self.impacts, self.motion(x).rhythm
        later = rhythm.period
        blows = rhythm.blow_times + tuple(time + later for time in rhythm.blow_times)
        passages = rhythm.passages + tuple((time + later, port) for time, port in rhythm.passages)
        twice = replace(rhythm, blow_times=blows, passages=passages, lying=(), sticking=False)
        sequence = sequence_in(self.motion(x).valve, twice)
        return None if sequence is None else (self.of(sequence), np.concatenate([x[:m], x[:m] + x[m - 1], x[m:]]))

    def halves(self, x: Array) -> tuple[Array, Array] | None:
        """The mean of both halves of a cycle, and their difference; None for an odd number of events."""
        m, known = self.impacts, self._half
        if known is None:
            return None
        first, second = x[: m // 2], x[m // 2 : m] - x[m // 2 - 1]
        return np.concatenate([0.5 * (first + second), x[m:]]), second - first

    @cached_property
    def _half(self) -> bool | None:
        events, half = self.sequence.events, len(self.sequence.events) // 2
        alike = [(one.kind, one.port, one.state, one.last) for one in events]
        return True if len(events) % 2 == 0 and alike[:half] == alike[half:] else None

    def halved(self, x: Array) -> MachineCurve | None:
        """The curve of cycles of half of these."""
        rhythm = self.motion(x).rhythm
        p, q = len(rhythm.blow_times) // 2, len(rhythm.passages) // 2
        times, passages = rhythm.blow_times[:p], rhythm.passages[:q]
        half = replace(rhythm, blow_times=times, passages=passages, lying=(), sticking=False)
        sequence = sequence_in(self.motion(x).valve, half)
        return None if sequence is None else self.of(sequence)

    # -- orders of events beside this one --

    def reordered(self, x: Array) -> tuple[MachineCurve, Array] | None:
        """The curve of the order in which a valve has the events of times that are in another; None for none."""
        cycle = self.motion(x)
        rhythm = reordered(cycle.machine.valve, cycle.rhythm)
        sequence = None if rhythm is None else sequence_in(cycle.machine.valve, rhythm)
        if rhythm is None or sequence is None or sequence == self.sequence:
            return None
        times = np.array([time for time, _ in rhythm.guarded]) / self.tick
        return self.of(sequence), np.append(times, x[self.impacts :])

    def follows(self, x: Array) -> bool:
        """Whether a machine does this, in the order that its valve tells of the times."""
        cycle = self.motion(x)
        return self.fault(x) is None and sequence_in(cycle.machine.valve, cycle.rhythm) == self.sequence

    # -- whether a machine does this --

    def fault(self, x: Array) -> Fault | None:
        """The first thing that is not as the order of events says, but for what rounding makes of their places."""
        cycle = self.motion(x)
        spans = [one.duration for one in cycle.flights]
        seen = [0.0 if 0.0 <= span < _INSTANT * cycle.period else span * (1.0 - _ROUNDED) for span in spans]
        flights = tuple(replace(one, duration=span) for one, span in zip(cycle.flights, seen, strict=True))
        found = self.sequence.fault(replace(cycle, flights=flights))
        if found is None and self.sequence.drops and sequence_in(cycle.machine.valve, cycle.rhythm) != self.sequence:
            return Fault("order", 0.0)  # an order is due before the one that replaced it is
        return found

    def tests(self, x: Array, within: tuple[int, ...] | None = None) -> dict[str, float]:
        """What changes its sign where the order of events ends; see `EventSequence.tests`."""
        return self.sequence.tests(self.motion(x), within)

    def test(self, name: str, x: Array) -> float | None:
        """One of them; None where the order of events has none of this name."""
        kind, which = kind_of(name)
        in_flight = kind in (BranchEvent.TOUCH, BranchEvent.PORT_TOUCH, BranchEvent.PRESSURE_GONE)
        return self.tests(x, (which,) if in_flight else ()).get(name)


def kind_of(test: str) -> tuple[BranchEvent, int]:
    """What happens where a test of an order of events changes its sign, and the number of the event or the flight."""
    name, _, number = test.partition(" ")
    return _KINDS[name], int(number.partition(".")[0])


_KINDS = {
    "blow": BranchEvent.DEATH, "port": BranchEvent.PORT_LOST, "order": BranchEvent.CORNER,
    "wall": BranchEvent.TOUCH, "edge": BranchEvent.PORT_TOUCH, "pressure": BranchEvent.PRESSURE_GONE,
    "rest": BranchEvent.ONSET,
}  # fmt: skip
OF_FAULTS = {
    "order": BranchEvent.CORNER, "direction": BranchEvent.PORT_LOST, "wall": BranchEvent.TOUCH,
    "port": BranchEvent.PORT_TOUCH, "pressure": BranchEvent.PRESSURE_GONE,
}  # fmt: skip
"""What ends a branch by the kind of a fault, where no test tells it."""
