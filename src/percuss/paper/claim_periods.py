"""Claims b and c: which m are reached, and from how many starts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from percuss.explore.attractors.experiments import Experiment, wilson
from percuss.paper.claim_common import (
    NAMED,
    Claim,
    Table,
    Trial,
    Verdict,
    lower_curve,
    one_impact,
    percent,
    pneumatic,
    sentence,
    tried,
    upper_curve,
)
from percuss.simulate import Starts
from percuss.stability import stability_of
from percuss.steady import Orbit, steady_states

MOST_PERIODS = 8
NEAR = 1e-3
"""Starts beside an orbit differ from it by this, relative for the speed and in radians for the phase."""


@dataclass(frozen=True)
class Allowed:
    """A motion with one impact in m load periods that exists at a point: the later of its two phases."""

    periods: int
    phase: float
    velocity: float  # just after the impact
    in_range: bool  # between the curves of B77 (39)
    admissible: bool
    stable: bool  # by the exact multipliers


@dataclass(frozen=True)
class Reach:
    """How many starts beside a motion came to it."""

    restitution: float
    load_factor: float
    motion: Allowed
    starts: int
    reached: int


def allowed(restitution: float, load_factor: float, most: int = MOST_PERIODS) -> list[Allowed]:
    """The motions with one impact in m ≤ `most` load periods where p decreases through its mean (B77 36)."""
    system = pneumatic(restitution, load_factor)
    found = []
    for m in range(1, most + 1):
        orbits: tuple[Orbit, ...] = steady_states(system, m, modes=0).orbits
        for orbit in orbits:
            if np.cos(orbit.phase) < 0.0:
                within = lower_curve(restitution, m) < load_factor < upper_curve(restitution, m)
                stable = stability_of(orbit, modes=0).stable
                found.append(
                    Allowed(m, orbit.phase, orbit.rebound_velocity, within, orbit.admissible, stable)
                )  # fmt: skip
    return found


def points_b() -> list[tuple[float, float]]:
    """Points where more than one m exists."""
    grid = [(r, x) for r in (0.5, 0.6, 0.7, 0.8, 0.9) for x in (0.4, 0.6, 0.8, 0.89, 1.0, 1.2, 1.4, 2.0)]
    return [(r, x) for r, x in grid if x < upper_curve(r, 2)]


def verdict_b(reaches: Sequence[Reach]) -> Verdict:
    """A motion is reached when any start beside it ends in it."""
    groups = []
    for stable, name in ((True, "stable and admissible"), (False, "unstable, or through the wall")):
        part = [reach for reach in reaches if (reach.motion.stable and reach.motion.admissible) == stable]
        groups.append((f"motions that are {name}", len(part), sum(reach.reached > 0 for reach in part)))
    return tried(groups)


def claim_b(trial: Trial) -> Claim:
    """Where several m are possible, each can be reached by a proper start."""
    points = points_b()
    wanted = [(r, x, motion) for r, x in points for motion in allowed(r, x)]
    each, reaches = max(20, min(trial.size.each(len(wanted)) // 3, 2000)), []
    draw = np.random.default_rng(trial.seed)
    for i, (r, x, motion) in enumerate(wanted):
        trial.tell("b", i, len(wanted))
        off = NEAR * draw.standard_normal((2, each))
        starts = Starts.rigid(0.0, motion.velocity * (1.0 + off[0]), motion.phase + off[1])
        found = trial.of(pneumatic(r, x), each, starts)
        apart = np.abs(np.angle(np.exp(1j * (found.columns["phase"] - motion.phase))))
        with np.errstate(invalid="ignore"):
            there = (found.label == f"z=1/{motion.periods}") & (apart < 1e-3)
        reaches.append(Reach(r, x, motion, each, int(there.sum())))
    good = [reach for reach in reaches if reach.motion.stable and reach.motion.admissible]
    several = {(q.restitution, q.load_factor) for q in good}
    several = {p for p in several if sum((q.restitution, q.load_factor) == p for q in good) > 1}
    rows = tuple(
        (
            q.restitution, q.load_factor, q.motion.periods, q.motion.phase, "yes" if q.motion.in_range else "no",
            "yes" if q.motion.stable else "no", "yes" if q.motion.admissible else "no", percent(q.reached, q.starts),
        )
        for q in reaches
    )  # fmt: skip
    columns = ("R", "p_0/p_1", "m", "phase", "in the range (39)", "stable", "admissible", "of the starts beside it")
    return Claim(
        "b",
        "several m",
        "Where motions with one impact in m load periods are possible for several m, each of them is reached from a "
        "proper start.",
        f"Rigid bar without damping at {len(points)} points with more than one m up to {MOST_PERIODS}; {each} starts "
        f"beside every motion on the branch of decreasing load: on the wall, with the rebound speed times "
        f"1 + {NEAR:g}·N(0, 1) and the load phase off by {NEAR:g}·N(0, 1) rad.",
        "A motion is reached when a start ends in a z=1/m with its phase. The claim holds when all that exist are "
        "reached, and does not hold when none is.",
        verdict_b(reaches),
        sum(reach.starts for reach in reaches),
        {
            "points": len(points),
            "motions that exist": len(reaches),
            "stable and admissible": len(good),
            "of these reached": sum(reach.reached > 0 for reach in good),
            "points with several stable": len(several),
            "least share of starts beside a stable motion that come to it": min(
                (reach.reached / reach.starts for reach in good), default=None
            ),
            "others reached": sum(reach.reached > 0 for reach in reaches) - sum(reach.reached > 0 for reach in good),
        },
        (Table("Every motion that exists, and how many of the starts beside it end there", columns, rows),),
        ("What exists but is unstable is left by every disturbance; no start but the motion itself would do.",),
    )


# -- c --------------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Smallest:
    """How many random starts of one distribution end at the smallest m that is stable and admissible."""

    restitution: float
    load_factor: float
    periods: int
    distribution: str
    starts: int
    one_impact: int
    smallest: int


def verdict_c(found: Sequence[Smallest], among_one_impact: bool = False) -> Verdict:
    """A point and distribution is good when the interval of the share lies above 99 %."""
    groups = []
    for name in dict.fromkeys(item.distribution for item in found):
        part = [item for item in found if item.distribution == name]
        tested = [(item.smallest, item.one_impact if among_one_impact else item.starts) for item in part]
        groups.append((f"`{name}`", len(part), sum(wilson(k, n)[0] > 0.99 for k, n in tested)))
    return tried(groups)


def claim_c(trial: Trial) -> Claim:
    """Random starts end at the smallest allowed m in more than 99 % of the cases."""
    points: list[tuple[float, float, list[int]]] = []
    for r, x in [(0.7, 0.89), *((r, x) for r in (0.75, 0.8, 0.85, 0.9, 0.95) for x in (0.85, 1.0, 1.2))]:
        stable = [motion.periods for motion in allowed(r, x) if motion.stable and motion.admissible]
        if len(stable) > 1:
            points.append((r, x, stable))
    each, found, rows = trial.size.each(len(points) * len(NAMED)), [], []
    for i, (r, x, stable) in enumerate(points):
        for name in NAMED:
            trial.tell("c", i, len(points))
            result: Experiment = trial.of(pneumatic(r, x), each, name)
            label = result.label
            least = int((label == f"z=1/{stable[0]}").sum())
            found.append(Smallest(r, x, stable[0], name, each, int(one_impact(label).sum()), least))
            shown = ", ".join(f"{k} {100 * v[0]:.3g} %" for k, v in list(result.labels.items())[:5])
            ones = found[-1].one_impact
            rows.append((r, x, ", ".join(map(str, stable)), name, percent(least, each), percent(least, ones), shown))
    columns = ("R", "p_0/p_1", "stable m", "starts", "smallest m, of all", "of those in a z=1/m", "most frequent")
    among = verdict_c(found, among_one_impact=True)
    shares = [item.smallest / item.starts for item in found]
    parts = [item.smallest / item.one_impact for item in found if item.one_impact]
    numbers: dict[str, Any] = {
        "points": len(points),
        "least share": min(shares),
        "greatest share": max(shares),
        "least share of those in a one-impact motion": min(parts, default=None),
        "greatest share of those in a one-impact motion": max(parts, default=None),
        "verdict among those in a one-impact motion": among.verdict,
        "where then": among.where,
    }
    return Claim(
        "c",
        "the smallest m",
        "Where several m are allowed, random starts end at the smallest of them in more than 99 % of the cases.",
        f"Rigid bar without damping at {len(points)} points with more than one stable and admissible m up to "
        f"{MOST_PERIODS}; {each} starts of each distribution.",
        "A point and distribution is good when Wilson's interval of 95 % of the share that ends at the smallest stable "
        "and admissible m lies above 99 %. The claim holds when all are good, and does not hold when none is.",
        verdict_c(found),
        sum(item.starts for item in found),
        numbers,
        (Table("Shares of the smallest m", columns, tuple(rows)),),
        (f"Counted among the starts that end in any one-impact motion only, the claim {sentence(among)}.",),
    )
