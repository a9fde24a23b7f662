"""When to stop following a motion, and what its end is called."""

from __future__ import annotations

from dataclasses import dataclass, replace

from percuss.errors import ParameterError
from percuss.model.checks import count, finite, flag, instance

DEFAULT_IMPACTS = 2000  # impacts after which a motion ends when nothing else is asked for

MAX_MODES = 4096  # the most elastic modes of a simulation

MOST_IMPACTS = 10**9

OUTCOMES = (
    "impacts", "time", "rest", "periodic", "departed", "work", "memory", "cancelled", "unresolved", "stalls"
)  # fmt: skip
"""How a simulation ends.

``impacts``, ``time``: the number or the time asked for is reached. ``rest``: the bar lies on the wall for good.
``periodic``: a periodic motion is found. ``departed``: the bar has left for good, which is proved. ``work``: one flight
needs far more evaluations than normal, e.g. a bar that hovers before the wall; what came before is whole. ``memory``:
the record has reached 1 GB; `Trajectory.continued` goes on, `simulate_many` keeps less.
``cancelled``: the caller said so. ``unresolved``: the bar was released twice in the same state, but rounding has a say
in how many load periods lie between. ``stalls``: the valve of a machine can never switch again, whatever blows are
left, which are followed as far as was asked for; see `percuss.simulate.STALLS`.
"""


@dataclass(frozen=True)
class Stop:
    """A stop rule: whichever comes first.

    Parameters
    ----------
    impacts
        The number of impacts from the start; 2000 when neither impacts nor time is given, 10⁶ with a time alone.
    time
        Time from the start, in radians of the load's fundamental; of a machine in its unit.
    periodic
        Whether to end when a periodic motion is found (two returns in a row to within `tolerance`).
    tolerance
        How near a state must come back to count as the same: phase in radians, velocities and modal amplitudes
        relative to the speed scale Σ|p_k| plus the striking speed; dimensionless.
    """

    impacts: int | None = None
    time: float | None = None
    periodic: bool = True
    tolerance: float = 1e-9

    def __post_init__(self) -> None:
        set_ = object.__setattr__
        if self.time is not None:
            time = finite("time", self.time, "a time greater than 0")
            if time <= 0.0:
                raise ParameterError("time", self.time, "a time greater than 0")
            set_(self, "time", time)
        if self.impacts is None:
            set_(self, "impacts", DEFAULT_IMPACTS if self.time is None else 10**6)
        else:
            set_(self, "impacts", count("impacts", self.impacts, least=0, most=MOST_IMPACTS))
        set_(self, "periodic", flag("periodic", self.periodic))
        tolerance = finite("tolerance", self.tolerance)
        if not 1e-13 <= tolerance <= 0.1:
            raise ParameterError("tolerance", self.tolerance, "a number from 1e-13 to 0.1")
        set_(self, "tolerance", tolerance)

    @property
    def most_impacts(self) -> int:
        """The number of impacts that ends the motion at the latest."""
        assert self.impacts is not None
        return self.impacts


def further(stop: Stop | None, earlier: Stop, impacts: int) -> Stop:
    """The rule of a motion that goes on: the one given, else as many impacts again, also past a periodic motion."""
    if stop is not None:
        return instance("stop", stop, Stop)
    return replace(earlier, impacts=2 * max(impacts, 1), time=None, periodic=False)
