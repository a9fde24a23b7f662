"""What the claims of B77 have in common: how much is tried, how it is told, and how a verdict is reached."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from percuss.case.answers.facts import picked, plain
from percuss.errors import Interrupted
from percuss.explore.attractors.drawn_starts import DISTRIBUTIONS
from percuss.explore.attractors.experiments import Experiment, experiment, wilson
from percuss.model import Load, System
from percuss.simulate import Starts, Stop
from percuss.stability import stability_of
from percuss.steady import steady_states

HOLDS, PARTLY, NOT = "holds", "holds only where", "does not hold"  # the verdicts

DAMPED = 0.03 / (2.0 * math.pi)  # d of B77's damped curves, 2πd = 0.03

RIGID = 1e6  # s of a bar that is as good as rigid: what remains of the elastic terms is of the order 1/s²


@dataclass(frozen=True)
class Size:
    """How much is tried for each claim: starts, and impacts of each at most."""

    starts: int
    impacts: int = 2000

    def each(self, points: int) -> int:
        """Starts for each of so many points; at least 8."""
        return max(8, self.starts // max(points, 1))


@dataclass(frozen=True)
class ClaimsProgress:
    """How far the audit has come: which part, and how many of its steps are done."""

    part: str
    done: int
    steps: int


@dataclass(frozen=True)
class Trial:
    """What every claim is given: the size, the seed, and who watches."""

    size: Size
    seed: int
    watcher: Callable[[ClaimsProgress], object] | None = None

    def tell(self, part: str, done: int, steps: int) -> None:
        """Say how far it is; Interrupted when whoever watches wants no more."""
        if self.watcher is not None and self.watcher(ClaimsProgress(part, done, steps)):
            raise Interrupted(done, steps, None, "nothing is written before all claims are tried")

    def of(
        self,
        system: System,
        starts: int,
        distribution: str | Starts,
        *,
        modes: int = 0,
        impacts: int | None = None,
        tolerance: float = 1e-9,
    ) -> Experiment:
        stop = Stop(impacts=self.size.impacts if impacts is None else impacts, tolerance=tolerance)
        return experiment(system, starts, distribution, self.seed, modes=modes, stop=stop, workers=1, threads=None)


@dataclass(frozen=True)
class Verdict:
    """What the numbers say, by the rule that is stated with the claim."""

    verdict: str
    where: str


@dataclass(frozen=True)
class ClaimTable:
    """Rows of numbers and words with their headings."""

    title: str
    columns: tuple[str, ...]
    rows: tuple[tuple[Any, ...], ...]

    def records(self) -> list[dict[str, Any]]:
        """One object for each row, finite numbers or null."""
        return [plain(dict(zip(self.columns, row, strict=True))) for row in self.rows]


@dataclass(frozen=True)
class Claim:
    """A claim in our words, what tried it, the rule for the verdict, and all found; `letter`: a to f as listed."""

    letter: str
    title: str
    claim: str
    done: str
    rule: str
    verdict: Verdict
    starts: int
    numbers: dict[str, Any]
    tables: tuple[ClaimTable, ...] = ()
    remarks: tuple[str, ...] = ()

    def to_json_dict(self) -> dict[str, Any]:
        """Plain values for ``claims.json``."""
        return {
            **picked(self, "title claim done rule"),
            **picked(self.verdict, "verdict where"),
            **picked(self, "starts numbers"),
            "tables": [{"title": table.title, "rows": table.records()} for table in self.tables],
            "remarks": list(self.remarks),
        }


# -- verdicts -------------------------------------------------------------------------------------------------------


def tried(groups: Iterable[tuple[str, int, int]]) -> Verdict:
    """The verdict on something tried at points in groups (name, points, good points): it holds at all, some or none."""
    counted = [(name, points, good) for name, points, good in groups if points]
    points, good = sum(n for _, n, _ in counted), sum(k for _, _, k in counted)
    told = "; ".join(f"{name}: at {k} of {n} points" for name, n, k in counted)
    if not points:
        return Verdict(NOT, "nothing was tried")
    return Verdict(HOLDS if good == points else NOT if good == 0 else PARTLY, told)


def sentence(verdict: Verdict) -> str:
    return {PARTLY: "holds only at some points", NOT: "does not hold"}.get(verdict.verdict, "holds") + (
        f" ({verdict.where})" if verdict.where else ""
    )


def percent(count: int, of: int) -> str:
    """A share with its interval of 95 %.

    >>> percent(8, 10)
    '80 % [49, 94.3]'
    """
    if not of:
        return "–"
    low, high = wilson(count, of)
    return f"{100.0 * count / of:.3g} % [{100.0 * low:.3g}, {100.0 * high:.3g}]"


# -- B77's systems --------------------------------------------------------------------------------------------------


def pneumatic(restitution: float, load_factor: float, *, s: float = RIGID, d: float = 0.0) -> System:
    """B77's pneumatic hammer, p(t) = p_0 + p_1 cos t with p_1 = 1; rigid and undamped unless told otherwise."""
    return System(s=s, d=d, restitution=restitution, load=Load.harmonic(load_factor, 1.0))


def hydraulic(restitution: float, kappa: float, *, s: float = RIGID, d: float = 0.0) -> System:
    """B77's hydraulic hammer, a square wave of amplitude 1 with exact steps."""
    return System(s=s, d=d, restitution=restitution, load=Load.square(1.0, kappa))


def upper_curve(restitution: float, periods: int = 1) -> float:
    """Greatest p_0/p_1 of a motion with one impact in m load periods, rigid and undamped (B77 38)."""
    return (1.0 + restitution) / (math.pi * periods * (1.0 - restitution))


def lower_curve(restitution: float, periods: int = 1, sigma: float = 0.0) -> float:
    """Least p_0/p_1 at which it is stable (B77 39); `sigma` is σ_p of B77 (37), 0 for a rigid bar."""
    r, m = restitution, periods
    stiff = 2.0 * (1.0 + r * r + (1.0 - r * r) * sigma)
    return float((1.0 + r) ** 2 / math.hypot(stiff, math.pi * m * (1.0 - r * r)))


def one_impact(labels: Sequence[str] | np.ndarray[Any, Any]) -> np.ndarray[Any, np.dtype[np.bool_]]:
    """Which labels are those of a motion with one impact in m load periods."""
    return np.char.startswith(np.asarray(labels, dtype=str), "z=1/")


NAMED = DISTRIBUTIONS


def stable_motions(system: System, periods: int, modes: int) -> list[bool]:
    """Of each admissible motion with one impact in so many periods, whether it is stable by exact multipliers."""
    orbits = steady_states(system, periods, modes=modes).orbits
    return [stability_of(orbit, modes=modes).stable for orbit in orbits if orbit.admissible]
