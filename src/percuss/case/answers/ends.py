"""Where a handful of random starts end: whether a hammer that can sustain a motion also finds it."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from percuss.case.answers.facts import Fact, Teller, json_of
from percuss.case.answers.numerals import picked
from percuss.errors import ParameterError, PercussError
from percuss.model.checks import count

if TYPE_CHECKING:
    from percuss.case.case import Case
    from percuss.model import System
    from percuss.simulate import Ensemble

STARTS = 24
"""Starts that `percuss steady` follows: of those that end otherwise one in ten is missed once in twelve times."""

DISTRIBUTION, SEED = "wall", 0
"""Of the starts, as `percuss experiment` draws them when nothing else is asked for."""

_MOST_STARTS = 1000
_MOST_MODES = 64  # elastic modes; more of them cost time and change no end
_LEAST_IMPACTS = 200
_WORK = 5e8  # starts times impacts times modes times harmonics, about half a second
_EVALUATIONS = 200  # for every impact; machines need fewer than 50, a bar that hovers before the wall any number


@dataclass(frozen=True)
class End:
    """One of the motions in which starts end.

    Attributes
    ----------
    label
        As `percuss.simulate.Trajectory.label`.
    starts
        How many end in it.
    blow_rate
        Main blows per load period, a completed chatter counted once; None where nothing strikes any more.
    delivered_power
        What the impacts take, per radian of the load; dimensionless; None where nothing strikes any more.
    """

    label: str
    starts: int
    blow_rate: float | None
    delivered_power: float | None


@dataclass(frozen=True)
class Ends:
    """Where random starts end.

    Attributes
    ----------
    followed
        How many starts.
    modes, impacts
        Elastic modes, and the most impacts of a start.
    ends
        The most frequent first.
    note
        Why none were followed, or some not to their end; else "".
    """

    followed: int
    modes: int
    impacts: int
    ends: tuple[End, ...]
    note: str = ""

    def to_json_dict(self, system: System) -> dict[str, Any]:
        """In plain values, with SI for a system that has scales."""
        return {
            **picked(self, "followed modes impacts note"),
            "distribution": DISTRIBUTION,
            "seed": SEED,
            "ends": [
                {**json_of(end, _END, Teller.of(system)), "share": end.starts / self.followed} for end in self.ends
            ],
        }


_END: tuple[Fact[End], ...] = (
    Fact("label", "motion", "what they settle on", "", lambda end: end.label),
    Fact("starts", "starts", "how many", "", lambda end: end.starts),
    Fact("blow_rate blow_rate_Hz", "main blows", "per load period or second", "cycles", lambda end: end.blow_rate),
    Fact("delivered_power delivered_power_kW", "power", "what the impacts take", "power",
         lambda end: end.delivered_power),
)  # fmt: skip
"""What one of the ends is."""


def not_followed(why: str) -> Ends:
    """No starts, and the reason."""
    return Ends(0, 0, 0, (), why)


def ends_of(case: Case, starts: int = STARTS, modes: int | None = None) -> Ends:
    """Where random starts of a case end, the same starts and motions as `percuss experiment` with so many starts.

    Loads the simulator; its first use on a computer compiles it, which takes up to a minute. A load of very many
    harmonics is followed for fewer impacts than an experiment takes, and a bar that hovers before the wall for fewer
    evaluations, so that it is quick all the same. Both are numbers: what comes out does not depend on the computer.
    """
    from percuss.case.answers.exploration import experiment_job_of

    number = count("starts", starts, most=_MOST_STARTS)
    simulation = case.simulation()
    kept = min(simulation.modes if modes is None else modes, _MOST_MODES)
    size = case.load().harmonics.size
    enough = max(_LEAST_IMPACTS, int(_WORK / (number * (kept + 8) * (size + 8))))
    impacts = min(simulation.stop.most_impacts, enough)
    try:
        job = experiment_job_of(case, number, DISTRIBUTION, SEED, modes=kept, impacts=impacts)
    except ParameterError:
        raise
    except PercussError as error:  # an undamped mode in resonance has no bounded motion
        return not_followed(error.message)
    from percuss.explore.attractors.drawn_starts import named
    from percuss.simulate import simulate_many

    most = _EVALUATIONS * impacts
    drawn = named(case.system(), DISTRIBUTION, number, SEED)
    many = simulate_many(case.system(), drawn, modes=job.modes, stop=job.stop, work=most)
    long = int(np.count_nonzero(many.outcome == "work"))
    note = f"{long} of {number} not followed to their end: each would take more than {most} evaluations of its motion"
    return Ends(number, job.modes, job.stop.most_impacts, _ends(many), note if long else "")


def _ends(many: Ensemble) -> tuple[End, ...]:
    names, rate = many.label, many.main_blow_rate
    power = many.energy_lost_per_period / (2.0 * np.pi)
    return tuple(
        End(name, number, _mean(rate[names == name]), _mean(power[names == name]))
        for name, number in Counter(names.tolist()).most_common()
    )


def _mean(values: np.typing.NDArray[np.float64]) -> float | None:
    """Over what is known; None when nothing is."""
    known = values[np.isfinite(values)]
    return float(known.mean()) if known.size else None
