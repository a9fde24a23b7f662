"""Claims a, b and c: where motions of the pneumatic hammer end, and which m are reached from how many starts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from percuss.explore.attractors.experiments import Experiment, wilson
from percuss.paper.claim_common import (
    NAMED,
    Claim,
    ClaimTable,
    Size,
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

RESTITUTIONS = (0.0, 0.2, 0.4, 0.6, 0.8, 0.9)
FRACTIONS = (0.3, 0.5, 0.6, 0.7, 0.8, 0.9, 0.97)  # of the upper curve of Fig. 5, where claim a is tried.


@dataclass(frozen=True)
class StartsEnd:
    """Where the starts of one point and one distribution ended."""

    restitution: float
    load_factor: float
    stable: bool  # above the lower curve of Fig. 5
    distribution: str
    starts: int
    one_impact: int  # z=1/m
    at_rest: int  # for good
    resting: int  # cycles with rest
    unsettled: int  # aperiodic or undecided
    labels: dict[str, tuple[float, float, float]]

    @property
    def others(self) -> int:
        """Neither a one-impact motion nor rest for good."""
        return self.starts - self.one_impact - self.at_rest


def verdict_a(ends: Sequence[StartsEnd], cycles_are_rest: bool = False) -> Verdict:
    """A point is one R and p_0/p_1; it is good when no start of any distribution ends otherwise."""
    others: dict[str, dict[tuple[float, float], int]] = {}
    for end in ends:
        points = others.setdefault(_region(end), {})
        key = (end.restitution, end.load_factor)
        points[key] = points.get(key, 0) + end.others - (end.resting if cycles_are_rest else 0)
    return tried((name, len(others[name]), sum(n == 0 for n in others[name].values())) for name in sorted(others))


def _region(end: StartsEnd) -> str:
    where = "between the curves of Fig. 5" if end.stable else "below both curves"
    return f"{where}, {'p_0 ≥ p_1 (the load never pulls)' if end.load_factor >= 1.0 else 'p_0 < p_1'}"


def starts_each(size: Size) -> int:
    """Starts of each distribution at every point; the same ones at all of them."""
    return size.each(len(RESTITUTIONS) * len(FRACTIONS) * len(NAMED))


def ends_of(trial: Trial) -> list[StartsEnd]:
    """The experiments of claim a."""
    points = [(r, f * upper_curve(r)) for r in RESTITUTIONS for f in FRACTIONS]
    each, ends = starts_each(trial.size), []
    for i, (r, x) in enumerate(points):
        for name in NAMED:
            trial.tell("a", i, len(points))
            found = trial.of(pneumatic(r, x), each, name)
            label = found.label
            resting = np.char.startswith(label, "chatter/") | np.char.startswith(label, "rest/")
            ends.append(
                StartsEnd(
                    r, x, x > lower_curve(r), name, each,
                    int(one_impact(label).sum()), int((label == "rest").sum()), int(resting.sum()),
                    int(np.isin(label, ("aperiodic", "undecided")).sum()), found.labels,
                )
            )  # fmt: skip
    return ends


def claim_a(trial: Trial, ends: Sequence[StartsEnd]) -> Claim:
    """Points below the upper curve of Fig. 5 always end in a one-impact motion or in rest."""
    word, kind = verdict_a(ends), verdict_a(ends, cycles_are_rest=True)
    starts = sum(end.starts for end in ends)
    one, rest, cycles = (sum(getattr(end, name) for end in ends) for name in ("one_impact", "at_rest", "resting"))
    rows = []
    for r in sorted({end.restitution for end in ends}):
        for x in sorted({end.load_factor for end in ends if end.restitution == r}):
            here = [end for end in ends if (end.restitution, end.load_factor) == (r, x)]
            n = sum(end.starts for end in here)
            top: dict[str, float] = {}
            for end in here:
                for name, (share, _, _) in end.labels.items():
                    top[name] = top.get(name, 0.0) + share * end.starts / n
            shown = ", ".join(f"{k} {100 * v:.3g} %" for k, v in sorted(top.items(), key=lambda kv: -kv[1])[:4])
            others = [percent(end.others, end.starts) for end in here]
            rows.append((r, x, x / upper_curve(r), "yes" if here[0].stable else "no", *others, shown))
    names = tuple(f"neither ({end})" for end in NAMED)
    table = ClaimTable(
        "Ends that are neither a one-impact motion nor rest for good, and the most frequent motions",
        ("R", "p_0/p_1", "of the upper curve", "above the lower", *names, "motions, all starts"),
        tuple(rows),
    )
    numbers = {
        "points": len(rows),
        "one-impact motions": one / starts,
        "rest for good": rest / starts,
        "cycles with rest": cycles / starts,
        "others": (starts - one - rest - cycles) / starts,
        "unsettled": sum(end.unsettled for end in ends) / starts,
        "verdict when a cycle with rest counts as rest": kind.verdict,
        "where then": kind.where,
    }
    return Claim(
        "a",
        "below the upper curve of Fig. 5",
        "Whatever the start, a pneumatic hammer whose p_0/p_1 lies below the upper curve of Fig. 5 ends in a motion "
        "with one impact in a whole number of load periods, or at rest.",
        f"Rigid bar without damping, R = {', '.join(f'{r:g}' for r in RESTITUTIONS)}, p_0/p_1 = "
        f"{', '.join(f'{f:g}' for f in FRACTIONS)} of the upper curve (1 + R)/(π(1 − R)); the starts of `wall`, "
        f"`field` and `gentle`, {ends[0].starts} each, followed for {trial.size.impacts} impacts at most.",
        "A point (R, p_0/p_1) is good when none of its starts, of any distribution, ends otherwise than in a z=1/m or "
        "in rest for good. The claim holds when all points are good, and does not hold when none is.",
        word,
        starts,
        numbers,
        (table,),
        (
            f"With the word *rest* read so that a cycle in which the bar lies on the wall for part of every period "
            f"counts as well, the claim {sentence(kind)}.",
        ),
    )


# ---- Claims b and c: which m are reached, and from how many starts

MOST_PERIODS = 8
NEAR = 1e-3  # starts beside an orbit differ from it by this, relative for the speed and in radians for the phase


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
class StartsReach:
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


def verdict_b(reaches: Sequence[StartsReach]) -> Verdict:
    """A motion is reached when any start beside it ends in it."""
    groups = []
    for stable, name in ((True, "stable and admissible"), (False, "unstable, or through the wall")):
        part = [reach for reach in reaches if (reach.motion.stable and reach.motion.admissible) == stable]
        groups.append((f"motions that are {name}", len(part), sum(reach.reached > 0 for reach in part)))
    return tried(groups)


def claim_b(trial: Trial) -> Claim:
    """Where several m are possible, each can be reached by a proper start."""
    grid = [(r, x) for r in (0.5, 0.6, 0.7, 0.8, 0.9) for x in (0.4, 0.6, 0.8, 0.89, 1.0, 1.2, 1.4, 2.0)]
    points = [(r, x) for r, x in grid if x < upper_curve(r, 2)]  # where more than one m exists
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
        reaches.append(StartsReach(r, x, motion, each, int(there.sum())))
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
        (ClaimTable("Every motion that exists, and how many of the starts beside it end there", columns, rows),),
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
        (ClaimTable("Shares of the smallest m", columns, tuple(rows)),),
        (f"Counted among the starts that end in any one-impact motion only, the claim {sentence(among)}.",),
    )
