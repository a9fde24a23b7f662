"""What a periodic motion of a machine that switches its own valve tells, whether its piston is rigid or elastic."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Literal

import numpy as np
import numpy.typing as npt

from percuss.errors import ParameterError
from percuss.model.checks import Array, ComplexArray, numbers, unit_interval
from percuss.shown import Shown
from percuss.steady.self_excited.piston_records import Switch, Uncovering
from percuss.steady.self_excited.ringing import Ringing

__all__ = ["Place", "ValveCycle", "checked_place"]

Place = Literal["centre"] | float
"""Of a body: its centre of mass, or from 0 (driven end) to 1 (striking end)."""


def checked_place(place: object) -> Place:
    """A place of the body, or an error."""
    if isinstance(place, str):
        if place != "centre":
            raise ParameterError("place", place, "'centre' or a place on the bar from 0 to 1")
        return "centre"
    return unit_interval("place", place)


class ValveCycle(Shown, ABC):
    """A periodic motion of a machine that switches its own valve; per unit of mass, as loads are.

    Time 0 is just after the last blow of the cycle; the longest flight comes first. Speeds of blows are those of the
    striking end just before.
    """

    # -- what each kind of cycle tells --

    @property
    @abstractmethod
    def blow_times(self) -> Array:
        """When the blows fall, the last one at the period."""

    @property
    @abstractmethod
    def blow_speeds(self) -> Array:
        """Speed just before each blow."""

    @property
    @abstractmethod
    def blow_energies(self) -> Array:
        """Kinetic energy just before each blow, that of the ringing with it."""

    @property
    @abstractmethod
    def switches(self) -> tuple[Switch, ...]:
        """Every change of the valve's state, in order of time."""

    @property
    @abstractmethod
    def uncoverings(self) -> tuple[Uncovering, ...]:
        """Where ports demand a new state, in order of time; blows that do are not among them."""

    @property
    @abstractmethod
    def stroke(self) -> float:
        """The greatest distance of the striking end from the wall."""

    @property
    @abstractmethod
    def work(self) -> float:
        """What the valve puts into the motion in a cycle; the blows, the damping and the rests take the same."""

    @property
    @abstractmethod
    def taken(self) -> float:
        """Energy that the blows of a cycle take."""

    @property
    @abstractmethod
    def taken_by_rest(self) -> float:
        """Energy lost on lying down: what the last blow left, for a piston at rest on the wall is undeformed."""

    @property
    @abstractmethod
    def level_difference(self) -> float:
        """The greatest force of the valve minus the least."""

    @property
    @abstractmethod
    def rests(self) -> bool:
        """Whether the piston lies on the wall for some time."""

    @property
    @abstractmethod
    def multipliers(self) -> ComplexArray:
        """Multipliers of the map from cycle to cycle, the greatest first, without the neutral one, a shift in time."""

    @abstractmethod
    def _displacement(self, within: Array, place: Place) -> Array:
        """Displacement of a place of the body at times of the cycle; the shape of `within`."""

    # -- what follows --

    @property
    def period(self) -> float:
        """Duration of the cycle."""
        return float(self.blow_times[-1])

    @property
    def blows(self) -> int:
        """Blows in a cycle."""
        return self.blow_times.size

    @property
    def blow_speed(self) -> float:
        """Speed just before the strongest blow."""
        return float(self.blow_speeds.max())

    @property
    def blow_energy(self) -> float:
        """Kinetic energy just before the strongest blow."""
        return float(self.blow_energies.max())

    @property
    def drawn(self) -> float:
        """Volume that the valve takes from the supply in a cycle, times the pressure for which its forces hold."""
        return self.work

    @property
    def swept_length(self) -> float:
        """Volume that the valve takes from the supply in a cycle, per area that it switches."""
        return self.drawn / self.level_difference if self.level_difference > 0.0 else 0.0

    @property
    def duty(self) -> float:
        """Part of the period between the last rise of the force and the blow that follows."""
        rises = [switch.time for switch in self.switches if switch.work > 0.0]
        if not rises:
            return 0.0
        blow = min(time for time in self.blow_times.tolist() if time >= rises[-1])
        return float((blow - rises[-1]) / self.period)

    @property
    def multiplier(self) -> complex:
        """The greatest multiplier: what is left of a disturbance after a cycle."""
        return complex(self.multipliers[0])

    @property
    def rhythm_multiplier(self) -> complex | None:
        """The greatest multiplier of the motion as a whole; None where it cannot be told from the ringing."""
        return self.multiplier

    @property
    def ringing(self) -> Ringing | None:
        """What rings longest; None where nothing is left of the ringing after a cycle, and of a rigid piston."""
        return None

    @property
    def stable(self) -> bool:
        """Whether disturbances die out."""
        return abs(self.multiplier) < 1.0

    def position(self, times: npt.ArrayLike, place: Place = 1.0) -> Array:
        """Displacement of a place of the body, 0 at the wall and negative behind it; the shape of `times`.

        Parameters
        ----------
        times
            Any; the motion is repeated with its period.
        place
            From 0 (driven end) to 1 (striking end), or "centre".

        Raises
        ------
        ParameterError
            When an argument is none of these.
        """
        found = np.mod(numbers("times", times), self.period)
        return self._displacement(np.asarray(found), checked_place(place))

    def __str__(self) -> str:
        blows = "1 blow" if self.blows == 1 else f"{self.blows} blows"
        return (
            f"{type(self).__name__}: {blows}, speed {self.blow_speed:.6g}, period {self.period:.6g}, "
            f"stroke {self.stroke:.6g}, multiplier {abs(self.multiplier):.4g}"
        )
