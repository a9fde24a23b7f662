"""Cycles of machines whose oil flows, as a curve over one parameter: the passage of a port that repeats."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple, cast

import numpy as np

from percuss.errors import PercussError
from percuss.explore.continuation.machine_cycles import MachineCurve
from percuss.explore.continuation.walk import CorrectorFailed, CurvePoint, Problem
from percuss.mechanics.oil import OilMotion
from percuss.model.checks import Array
from percuss.steady.oil.oil_cycle import OilUnknowns, PortPassage, cycle_at
from percuss.steady.self_excited.event_sequence import Fault
from percuss.steady.self_excited.valve_cycle import ValveCycle

_KEPT = 256  # motions


class PassageOf(NamedTuple):
    """The passage whose cycles a curve has: the port, the blows in a cycle, and its label."""

    port: int
    blows: int
    label: str


@dataclass(frozen=True, eq=False)
class OilCurve(MachineCurve):
    """The cycles of a family of machines through the passage of a port, with so many blows and N modes.

    The unknowns are what may change there, over their scales, and the period in `tick`s; the motion meets all that a
    machine meets, so that whatever is found is a motion.
    """

    passage: PortPassage = None  # type: ignore[assignment]
    difference = 1e-6

    @classmethod
    def through(cls, cycle: ValveCycle, family: Any, names: tuple[str, ...], units: tuple[float, ...]) -> OilCurve:
        """That of a cycle."""
        passage, tick = cycle.passage, cycle.period / (2.0 * np.pi)
        met = PassageOf(passage.port, passage.blows, cycle.label)
        return cls(family, names, units, met, cycle.modes, tick, passage)  # type: ignore[arg-type]

    @cached_property
    def own(self) -> OilUnknowns:
        """What may change at the passage."""
        return OilUnknowns.of(self.passage.numbers, self.passage.state)

    @cached_property
    def impacts(self) -> int:  # type: ignore[override]
        """Unknowns but for the parameter; the last of them is the period."""
        return self.own.size + 1

    @cached_property
    def scales(self) -> Array:
        """Of the unknowns at the passage."""
        return self.own.scales(self.passage.numbers)

    def _passage(self, x: Array) -> PortPassage:
        state = OilMotion.again(self.passage.numbers, self.passage.state).state
        self.own.put(state, x[: self.own.size] * self.scales, self.own.values(state))
        return replace(self.passage, state=state).of(self.system(*self.values(x)))

    def _returned(self, x: Array, directions: int) -> tuple[PortPassage, OilMotion]:
        passage = self._passage(x)
        motion = passage.returned(passage.state, directions)
        if motion is None or OilUnknowns.of(passage.numbers, motion.state) != self.own:
            raise CorrectorFailed("no motion")
        return passage, motion

    def residual(self, x: Array) -> Array:
        _, motion = self._returned(x, 0)
        off = self.own.values(motion.state) / self.scales - x[: self.own.size]
        return np.append(off, motion.time / self.tick - x[self.own.size])

    def linearised(self, x: Array) -> tuple[Array, Array]:
        passage, motion = self._returned(x, self.own.size)
        m = self.own.size
        slope, late = self.own.map(motion, passage.row)
        own = np.zeros((m + 1, m + 1))
        own[:m, :m] = slope * self.scales / self.scales[:, None] - np.eye(m)
        own[m, :m], own[m, m] = late * self.scales / self.tick, -1.0
        off = self.own.values(motion.state) / self.scales - x[:m]
        found = np.append(off, motion.time / self.tick - x[m])
        return np.hstack([own, self.by_differences(x, self.places)]), found

    def corrected(self, start: Array, normal: Array, along: Array, near: CurvePoint) -> CurvePoint:
        return Problem.corrected(self, start, normal, along, near)

    def system_at(self, x: Array) -> Any:
        return self.system(*self.values(x))

    def motion(self, x: Array) -> ValveCycle:
        """The motion at a point."""
        key = x[: self.places[-1] + 1].tobytes()
        if key not in self._motions:
            if len(self._motions) > _KEPT:
                self._motions.clear()
            passage, motion = self._returned(x, self.own.size)
            cycle = cycle_at(replace(passage, slope=self.own.map(motion, passage.row)[0]))
            if cycle is None:
                raise CorrectorFailed("no motion")
            self._motions[key] = cycle
        return self._motions[key]

    def unknowns(self, cycle: ValveCycle, *values: float) -> Array:
        """The point of a cycle."""
        state = cycle.passage.state
        return np.concatenate(
            [self.own.values(state) / self.scales, [cycle.period / self.tick], np.divide(values, self.units)]
        )

    def flips_about(self, first: CurvePoint, stop: CurvePoint) -> tuple[Callable[[Array], float], float]:
        def quick(x: Array) -> float:
            try:
                return self.flip(CurvePoint(x, x, 0))
            except PercussError:
                return float("nan")

        return quick, 0.0

    def doubled(self, x: Array) -> tuple[MachineCurve, Array] | None:
        """The curve of cycles of two of these, and its unknowns."""
        m = self.own.size
        blows, cycles = self.sequence.label.split("/")
        twice = PassageOf(self.passage.port, 2 * self.passage.blows, f"{2 * int(blows)}/{2 * int(cycles)}")
        wide = replace(self, sequence=cast("Any", twice), passage=replace(self.passage, blows=2 * self.passage.blows))
        return wide, np.concatenate([x[:m], [2.0 * x[m]], x[m + 1 :]])

    def halves(self, x: Array) -> tuple[Array, Array] | None:
        """The mean of the passages of both halves of a cycle, and their difference; None for an odd number of blows."""
        m = self.own.size
        if self.passage.blows % 2:
            return None
        half = replace(self._passage(x), blows=self.passage.blows // 2)
        motion = half.returned(half.state)
        if motion is None or OilUnknowns.of(half.numbers, motion.state) != self.own:
            raise CorrectorFailed("no motion")
        here, there = x[:m], self.own.values(motion.state) / self.scales
        return np.concatenate([0.5 * (here + there), [0.5 * x[m]], x[m + 1 :]]), there - here

    def halved(self, x: Array) -> MachineCurve | None:
        """The curve of cycles of half of these."""
        blows, cycles = self.sequence.label.split("/")
        label = f"{int(blows) // 2}/{max(int(cycles) // 2, 1)}"
        half = PassageOf(self.passage.port, self.passage.blows // 2, label)
        return replace(self, sequence=cast("Any", half), passage=replace(self.passage, blows=half.blows))

    # -- whatever is found is a motion: nothing has to be looked at besides --

    def reordered(self, x: Array) -> None:
        """None: the motion has the order of events that its machine tells."""

    def follows(self, x: Array) -> bool:
        """Whether there is a motion."""
        return self.fault(x) is None

    def fault(self, x: Array) -> Fault | None:
        """None, or that there is no motion."""
        try:
            self._returned(x, 0)
        except CorrectorFailed:
            return Fault("order", 0.0)
        return None

    def tests(self, x: Array, within: tuple[int, ...] | None = None) -> dict[str, float]:
        """None: see `fault`."""
        return {}
