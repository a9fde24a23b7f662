"""Claim a: where motions of the pneumatic hammer end."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from percuss.paper.claim_common import (
    NAMED,
    Claim,
    Size,
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

RESTITUTIONS = (0.0, 0.2, 0.4, 0.6, 0.8, 0.9)
FRACTIONS = (0.3, 0.5, 0.6, 0.7, 0.8, 0.9, 0.97)
"""Of the upper curve of Fig. 5, where claim a is tried."""


@dataclass(frozen=True)
class End:
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


def verdict_a(ends: Sequence[End], cycles_are_rest: bool = False) -> Verdict:
    """A point is one R and p_0/p_1; it is good when no start of any distribution ends otherwise."""
    others: dict[str, dict[tuple[float, float], int]] = {}
    for end in ends:
        points = others.setdefault(_region(end), {})
        key = (end.restitution, end.load_factor)
        points[key] = points.get(key, 0) + end.others - (end.resting if cycles_are_rest else 0)
    return tried((name, len(others[name]), sum(n == 0 for n in others[name].values())) for name in sorted(others))


def _region(end: End) -> str:
    where = "between the curves of Fig. 5" if end.stable else "below both curves"
    return f"{where}, {'p_0 ≥ p_1 (the load never pulls)' if end.load_factor >= 1.0 else 'p_0 < p_1'}"


def starts_each(size: Size) -> int:
    """Starts of each distribution at every point; the same ones at all of them."""
    return size.each(len(RESTITUTIONS) * len(FRACTIONS) * len(NAMED))


def ends_of(trial: Trial) -> list[End]:
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
                End(
                    r, x, x > lower_curve(r), name, each,
                    int(one_impact(label).sum()), int((label == "rest").sum()), int(resting.sum()),
                    int(np.isin(label, ("aperiodic", "undecided")).sum()), found.labels,
                )
            )  # fmt: skip
    return ends


def claim_a(trial: Trial, ends: Sequence[End]) -> Claim:
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
    table = Table(
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
