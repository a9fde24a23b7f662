"""All steady motions of a system whose blows take time, beside those of B77's law."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from percuss.errors import ParameterError
from percuss.model import System, Timed
from percuss.model.checks import Array, count, instance, numbers
from percuss.shown import Shown
from percuss.steady.orbit import Orbit
from percuss.steady.states import MAX_PERIODS, SteadyStates, steady_states
from percuss.steady.timed_orbit import TimedOrbit
from percuss.steady.timed_phases import TimedCondition, matched_roots, timed_condition
from percuss.steady.trigonometric import TURN

__all__ = ["TimedStates", "timed_states"]


@dataclass(frozen=True)
class TimedStates(Shown):
    """The steady motions with one blow every `periods` load periods under a law `Timed`.

    Parameters
    ----------
    system, law, periods
        The system, with the restitution of the law, the law, and m.
    b77
        The steady motions of B77's law with the same restitution.
    """

    system: System
    law: Timed
    periods: int
    b77: SteadyStates

    @cached_property
    def _condition(self) -> TimedCondition:
        return timed_condition(self.system, self.law, self.periods)

    @property
    def level(self) -> float:
        """What v_f − e p meets at the phases: c − a/T without drag."""
        return self._condition.level

    @property
    def level_max(self) -> float:
        """max (v_f − e p): motions exist while level ≤ level_max."""
        return self._condition.highest

    def curve(self, phase: npt.ArrayLike) -> Array:
        """v_f − e p at the given load phases (rad), right-sided at a jump of the load."""
        return self._condition.curve(numbers("phase", phase))

    @cached_property
    def orbits(self) -> tuple[TimedOrbit, ...]:
        """Every motion in order of phase, physically possible or not."""
        roots = self._condition.roots
        kept = self.b77.orbits
        phases, phases_b77 = np.array([root.phase for root in roots]), np.array([orbit.phase for orbit in kept])
        partners = matched_roots(
            phases,
            phases_b77,
            self.curve(_middles(phases)) - self.level,
            self.b77.rigid_velocity(_middles(phases_b77)) - self.b77.level,
        )
        return tuple(
            TimedOrbit(self.system, self.law, self.periods, *root, None if i is None else kept[i])
            for root, i in zip(roots, partners, strict=True)
        )

    @property
    def ended(self) -> tuple[Orbit, ...]:
        """The motions of B77's law that have no motion here: the duration of the blow ends them in a fold."""
        continued = {orbit.b77.phase for orbit in self.orbits if orbit.b77 is not None}
        return tuple(orbit for orbit in self.b77.orbits if orbit.phase not in continued)

    @property
    def exists(self) -> bool:
        """Whether any motion of this kind exists."""
        return bool(self._condition.roots)

    def __str__(self) -> str:
        head = f"z=1/{self.periods}, {self.law.law}: level {self.level:.6g}, max {self.level_max:.6g}, "
        return "\n".join([f"{head}{len(self.orbits)} orbits", *(f"  {orbit}" for orbit in self.orbits)])


def _middles(phases: Array) -> Array:
    """The phases half way from each to the next one round the circle."""
    return np.asarray(phases + 0.5 * np.diff(np.append(phases, phases[:1] + TURN)))


def timed_states(system: System, law: Timed, periods: int = 1, *, modes: int | None = None) -> TimedStates:
    """Every steady motion with one blow every `periods` load periods when the blow takes time.

    The phases are roots of v_f(φ) − e p(φ) = c(R) − a/T, with e = 2 t_J − t_c and the advance a = A J, and
    V(φ) = J/(1 + R) + e p(φ); a drag changes both a little. All roots are found, whatever the load. Right to first
    order in the duration over the period.

    Parameters
    ----------
    system
        The bar and its load; its restitution is replaced by that of the law.
    law
        The law of the blow.
    periods
        m, the load periods per blow.
    modes
        Elastic modes of the motions of B77's law beside it, as in `steady_states`.

    Returns
    -------
    TimedStates
        With every motion, and for each the motion of B77's law that it continues.

    Raises
    ------
    LoadError, ResonanceError
        As `steady_states`.
    ParameterError
        When the contact takes as long as the time from blow to blow, and for periods or modes out of range.

    Examples
    --------
    >>> from percuss import Load, System, Timed
    >>> system = System(s=20.0, d=0.0048, restitution=0.6, load=Load.harmonic(0.9, 1.0))
    >>> for orbit in timed_states(system, Timed.of_uniform_bar(20.0, 0.6)).orbits:
    ...     print(f"{orbit.phase:.6f} {orbit.phase_b77:.6f} {orbit.rigid_velocity:.6f} {orbit.admissible}")
    0.783913 0.800558 3.533740 True
    2.348080 2.331435 3.533740 True
    """
    instance("system", system, System), instance("law", law, Timed)
    m = count("periods", periods, most=MAX_PERIODS)
    if not law.duration < 2.0 * math.pi * m:
        raise ParameterError(
            "duration", law.duration, f"less than the time from blow to blow, {2.0 * math.pi * m:.4g} rad",
            "such a contact has no flight after it: resolve it by waves",
        )  # fmt: skip
    same = system if system.restitution == law.restitution else system.with_restitution(law.restitution)
    return TimedStates(same, law, m, steady_states(same, m, modes=modes))
