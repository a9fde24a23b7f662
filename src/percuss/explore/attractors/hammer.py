"""What an experiment follows, as the machinery asks it: a system under a clock, or a machine that switches itself."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Protocol

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

    from percuss.explore.attractors.grouping import Attractor
    from percuss.explore.attractors.machine_attractors import MachineAttractor
    from percuss.explore.jobs.job import Column, Columns
    from percuss.model.checks import Array
    from percuss.simulate import MachineStarts, Starts, Stop

    AnyStarts = Starts | MachineStarts
    AnyAttractor = Attractor | MachineAttractor

__all__ = ["Hammer"]


class Hammer(Protocol):
    """Draws starts, follows them, and tells apart what they settle on; made by `hammers.hammer_of`."""

    @property
    def kind(self) -> str:
        """The name under which an archive has it: ``system`` or ``machine``."""
        ...

    @property
    def described(self) -> dict[str, Any]:
        """All that its motions depend on, of JSON's types."""
        ...

    @property
    def columns(self) -> Mapping[str, Column]:
        """What is kept of every motion."""
        ...

    @property
    def words(self) -> Mapping[str, Sequence[str]]:
        """Columns whose numbers stand for words, and the words."""
        ...

    @property
    def scales(self) -> Mapping[str, tuple[float, str]]:
        """What columns are multiplied by for SI, and their unit then; empty without scales."""
        ...

    @property
    def about(self) -> dict[str, Any]:
        """What a dataset says of the numbers as a whole."""
        ...

    def check(self, modes: int) -> None:
        """Raise now what every start would: a resonance, say."""
        ...

    # -- starts --

    def named(self, distribution: str, number: int, seed: int, first: int = 0) -> AnyStarts:
        """Starts of a named distribution; see `percuss.explore.attractors.start_distributions.named`."""
        ...

    def own(self, source: Any, seed: int) -> AnyStarts:
        """The rows of one's own distribution; see `percuss.explore.attractors.start_distributions.own`."""
        ...

    def value(self, where: str, name: object, value: object) -> tuple[str, float]:
        """A quantity of starts by its name, and its value as a number.

        Raises
        ------
        ParameterError
            When starts have no such quantity, or it no such value.
        """
        ...

    def on_a_grid(self, grid: dict[str, Array]) -> AnyStarts:
        """Starts of the striking end from columns of one length by name; what is not named is 0 or as usual."""
        ...

    def start_columns(self, displacements: int, velocities: int) -> dict[str, Column]:
        """The columns of starts with so many modal amplitudes."""
        ...

    def start_values(self, starts: AnyStarts) -> Columns:
        """Starts as columns."""
        ...

    def starts_from(self, columns: Columns) -> AnyStarts:
        """The starts that columns hold."""
        ...

    # -- motions --

    def rough_seconds(self, modes: int) -> float:
        """What one start takes, by rule of thumb."""
        ...

    def followed(
        self, starts: AnyStarts, modes: int, stop: Stop, threads: int | None, stopped: Callable[[], bool]
    ) -> Columns:
        """`columns` of the motions from all starts, each by itself."""
        ...

    def labels(self, columns: Columns) -> npt.NDArray[np.str_]:
        """What motion each is at its end."""
        ...

    def matched(self, columns: Columns, distance: float) -> npt.NDArray[np.int64]:
        """The number of the attractor of each motion, 0 for the most frequent."""
        ...

    def attractors(
        self, columns: Columns, number: npt.NDArray[np.int64], starts: AnyStarts, modes: int, stop: Stop
    ) -> tuple[AnyAttractor, ...]:
        """The attractors behind the numbers, in their order."""
        ...
