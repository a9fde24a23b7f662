"""One steady motion with one impact every m load periods, as a value: is it possible, what does it carry?"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from percuss.model.checks import Array, count
from percuss.steady.admissible import Contactless, Violation, flight_check
from percuss.steady.energy import Energy
from percuss.steady.motion import Motion
from percuss.steady.reason import Reason
from percuss.steady.warnings import drag_warnings, resonance_warnings

__all__ = ["Orbit"]

_MOST_IMPACTS = 10**7


@dataclass(frozen=True)
class Orbit(Motion):
    """A steady motion with one impact every `periods` load periods; made by `steady_states`.

    Times are in radians of the load's fundamental **after the impact**, from 0 to `period`; positions are
    fractions of the length. All quantities are dimensionless (theory §1); `si_report` gives them in SI.

    Parameters
    ----------
    system
        What vibrates.
    periods
        m, the load periods per impact.
    phase
        φ, the phase of the load at the impact, in [0, 2π).
    fold
        Whether the phase is a double root of B77 (14): two steady motions meet here.
    requested_modes
        None: the continuous bar; the forced part is summed over all modes and the transient part over as many as
        `tolerance` asks for. A number N: the bar of modes 0 … N, forced part included, exactly as a simulation with N
        modes moves.
    tolerance
        Wanted error of the striking end's position, relative to the stroke.
    """

    @cached_property
    def energy(self) -> Energy:
        """Energy over one impact period: put in by the load, taken by damping and by the impact."""
        return Energy(*self.response.exchange(self), self.delivered_energy)

    def impact_history(self, impacts: int) -> Array:
        """The first `impacts` impacts from load time φ on: one row each of absolute time (rad of the load), load phase,
        striking speed and rebound velocity of the striking end; shape (impacts, 4), dimensionless.
        """
        n = np.arange(count("impacts", impacts, most=_MOST_IMPACTS))
        row = [self.phase, self.phase, self.impact_velocity, self.rebound_velocity]
        return np.asarray(np.tile(row, (n.size, 1)) + np.outer(n, [self.period, 0.0, 0.0, 0.0]))

    # -- is it real --

    @cached_property
    def _flight(self) -> Contactless:
        return flight_check(self)

    @property
    def violation(self) -> Violation | None:
        """Where the bar would pass through the wall between two impacts, or None."""
        return self._flight.violation

    @property
    def proven(self) -> bool:
        """Whether the absence of a touch between the impacts, or the first one, is proved."""
        return self._flight.proven

    @property
    def obstacle(self) -> Reason | None:
        """Why the motion is not physical: `Reason.NO_BLOW` or `Reason.THROUGH_WALL`; None for one that is."""
        if not self.impact_velocity > 0.0:
            return Reason.NO_BLOW
        return None if self.violation is None else Reason.THROUGH_WALL

    @property
    def admissible(self) -> bool:
        """Whether the motion is physical: it strikes forward, and y(t) < 0 for 0 < t < T."""
        return self.obstacle is None

    @cached_property
    def warnings(self) -> tuple[str, ...]:
        """A strong drag, near-resonances of the load or the impacts with elastic modes, a tolerance not reached."""
        return (*drag_warnings(self), *resonance_warnings(self, self.stroke, self.proven))

    @cached_property
    def stroke(self) -> float:
        """Range of the striking end's position over the impact period."""
        top = 0.0 if self.violation is None else self.highest[1]  # y ≤ 0 = y(0) unless it passes the wall
        return top - self.lowest[1]

    @cached_property
    def highest(self) -> tuple[float, float]:
        """Time and value of the greatest y over the period; 0 at the impact when the orbit is admissible."""
        return self._extreme(1.0)

    @cached_property
    def lowest(self) -> tuple[float, float]:
        """Time and value of the least y over the period."""
        return self._extreme(-1.0)

    @cached_property
    def _coarse(self) -> tuple[Array, Array]:
        detail = min(max(4, 2 * int(self.system.load.harmonics.max(initial=1))), 128)
        t = np.linspace(0.0, self.period, 16 * self.periods * detail + 1)
        return t, self.end_motion(t, self.truncation.few)[0]

    def _extreme(self, sign: float) -> tuple[float, float]:
        """A first look with few modes, two closer ones with more, and the place where the speed vanishes with all."""
        t, y = self._coarse
        for points in (33, 17):
            best = int(np.argmax(sign * y))
            t = np.linspace(t[max(best - 1, 0)], t[min(best + 1, t.size - 1)], points)
            y, speed = self.end_motion(t, self.truncation.some)
        best = int(np.argmax(sign * y))
        other = min(max(best + (1 if sign * speed[best] > 0.0 else -1), 0), t.size - 1)
        turn = t[best]
        if speed[best] * speed[other] < 0.0:
            turn += (t[other] - t[best]) * speed[best] / (speed[best] - speed[other])
        times = np.array([t[best], turn])
        values = self.end_motion(times, self.modes)[0]
        last = int(np.argmax(sign * values))
        return float(times[last]), float(values[last])

    def __str__(self) -> str:
        where = "admissible" if self.admissible else "not admissible"
        return (
            f"Orbit z=1/{self.periods}: phase {self.phase:.6f} rad, striking speed {self.impact_velocity:.6g}, "
            f"{where}, {self.modes} mode{'s' if self.modes != 1 else ''} (error {self.error_bound:.1e} of the stroke)"
        )
