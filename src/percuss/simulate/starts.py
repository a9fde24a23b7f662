"""Many starts at once, as columns."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from percuss.errors import ParameterError
from percuss.model import System
from percuss.model.checks import Array, instance, numbers, several
from percuss.shown import Shown
from percuss.simulate.drawn import DEFAULT_RANDOM_MODES, drawn
from percuss.simulate.start import MOST, Start

__all__ = ["Starts"]


@dataclass(frozen=True)
class Starts(Shown):
    """Starts of many motions. Make one with `rigid`, `of` or `random`.

    Parameters
    ----------
    displacement, velocity
        u_n and u_n' of each start, shape (starts, n); what a simulation has more of modes is 0. Dimensionless.
    gap
        u(1) ≤ 0 of each, shape (starts,): it holds whatever the number of modes.
    time
        Load phase (rad) of each, shape (starts,).

    Raises
    ------
    ParameterError
        For arrays that do not fit each other, numbers that are not finite, or striking ends beyond the wall.
    """

    displacement: Array
    velocity: Array
    gap: Array
    time: Array

    def __post_init__(self) -> None:
        for name, dimensions in (("displacement", 2), ("velocity", 2), ("gap", 1), ("time", 1)):
            given = getattr(self, name)
            if not (isinstance(given, np.ndarray) and given.dtype == float):
                given = numbers(name, given, f"finite numbers of at most {MOST:g}")
            values = np.array(given, order="C")
            rows = self.displacement.shape[0] if name != "displacement" else values.shape[0] if values.ndim else 1
            if values.ndim != dimensions or values.shape[0] != rows:
                accepted = f"an array of {rows} rows, {dimensions}-dimensional"
                raise ParameterError(name, f"shape {values.shape}", accepted)
            if not np.all(np.abs(values) <= MOST):
                raise ParameterError(name, values, f"finite numbers of at most {MOST:g}")
            values.setflags(write=False)
            object.__setattr__(self, name, values)
        if self.displacement.shape[1] < 1 or self.velocity.shape[1] < 1:
            raise ParameterError("displacement", f"shape {self.displacement.shape}", "at least u_0 of each start")
        if np.any(self.gap > 0.0):
            raise ParameterError("gap", float(self.gap.max()), "0 (on the wall) or less")

    # -- ways to make them --

    @classmethod
    def rigid(cls, position: npt.ArrayLike = -1.0, velocity: npt.ArrayLike = 0.0, time: npt.ArrayLike = 0.0) -> Starts:
        """Undeformed bars at `position` ≤ 0 with one velocity; the three are broadcast against each other."""
        given = numbers("position", position), numbers("velocity", velocity), numbers("time", time)
        try:
            columns = np.broadcast_arrays(*given)
        except ValueError:
            raise ParameterError("position", position, "numbers, and shapes that go with velocity and time") from None
        if not columns[0].size:
            raise ParameterError("position", position, "one or more starts")
        u, v, t = (column.reshape(-1) for column in columns)
        return cls(u[:, None], v[:, None], u, t)

    @classmethod
    def of(cls, starts: Sequence[Start], modes: int, systems: Sequence[System] = ()) -> Starts:
        """Single starts joined, for simulations with `modes` modes of one system, or of as many as starts."""
        listed = several("starts", starts, "one or more starts")
        checked = [instance("starts", start, Start) for start in listed]
        systems = [instance("systems", system, System) for system in several("systems", systems, "a list of systems")]
        apart = len({(system.body, system.load.at) for system in systems}) > 1
        if apart and len(checked) == 1:
            checked *= len(systems)
        whose = systems if apart and len(systems) == len(checked) else [*systems, None][:1] * len(checked)
        states = [start.state(modes, system) for start, system in zip(checked, whose, strict=True)]
        if not states:
            raise ParameterError("starts", starts, "one or more starts")
        u, v, gap = (np.array([state[i] for state in states]) for i in range(3))
        return cls(u, v, gap, np.array([start.time for start in checked]))

    @classmethod
    def random(
        cls,
        system: System,
        size: int,
        *,
        seed: int = 0,
        distribution: str = "rigid",
        modes: int = DEFAULT_RANDOM_MODES,
    ) -> Starts:
        """Starts drawn from a named distribution; the same seed gives the same starts.

        With the speed scale P = Σ|p_k| of the load, each number uniform and independent of the others:

        ``rigid``
            position from −5P to 0, velocity from −3P to 3P, load phase from 0 to 2π;
        ``still``
            the same with velocity 0;
        ``ringing``
            as ``rigid``, with elastic modes n = 1 … `modes` besides: velocity amplitudes normal with standard deviation
            P/(3n), phases from 0 to 2π. Position and velocity are those of the striking end and of the bar's mean.

        Parameters
        ----------
        system
            Whose load sets the scale.
        size
            How many.
        seed
            Of numpy's default generator.
        """
        return cls(*drawn(system, size, seed, distribution, modes))

    # -- as a sequence --

    def __len__(self) -> int:
        return int(self.gap.size)

    def __getitem__(self, i: int) -> Start:
        return Start(
            tuple(self.displacement[i].tolist()),
            tuple(self.velocity[i].tolist()),
            float(self.time[i]),
            gap=float(self.gap[i]),
        )

    def __iter__(self) -> Iterator[Start]:
        return (self[i] for i in range(len(self)))
