"""What B77 does not tell: motions with chatter and rest, cascades, coexisting motions, the hammer that rests."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass

from percuss.paper.claim_common import ClaimTable, Trial, hydraulic, lower_curve, percent, pneumatic, upper_curve
from percuss.paper.claim_pneumatic import StartsEnd

_CYCLE = re.compile(r"z=(\d+)/(\d+)")


@dataclass(frozen=True)
class Finding:
    """Something that was found besides, in words with its numbers."""

    title: str
    text: str
    table: ClaimTable


def beyond(trial: Trial, ends: Sequence[StartsEnd]) -> list[Finding]:
    """The findings; `ends` are the experiments of claim a."""
    return [_chatter(ends), _cascade(trial), _coexisting(ends), _resting(trial), _dead(trial)]


def _chatter(ends: Sequence[StartsEnd]) -> Finding:
    rows = []
    for stable in (True, False):
        part = [end for end in ends if end.stable == stable]
        n = sum(end.starts for end in part)
        for distribution in dict.fromkeys(end.distribution for end in part):
            here = [end for end in part if end.distribution == distribution]
            starts = sum(end.starts for end in here)
            cycles = sum(end.resting for end in here)
            rows.append(("above the lower curve" if stable else "below it", distribution, percent(cycles, starts)))
        if n:
            total = sum(end.resting for end in part)
            rows.append(("above the lower curve" if stable else "below it", "all", percent(total, n)))
    cycles, starts = sum(end.resting for end in ends), sum(end.starts for end in ends)
    longest = max(
        (int(name[8:]) for end in ends for name in end.labels if name.startswith("chatter/") and name[8:].isdecimal()),
        default=0,
    )
    return Finding(
        "Chatter and rest",
        f"{percent(cycles, starts)} of the starts of claim a end in a cycle in which the bar comes to lie on the wall "
        "after ever smaller bounces (with R = 0 after one impact), is held there while the load pushes, and leaves "
        f"when it pulls; the longest such cycle has {longest} load periods.",
        ClaimTable("Starts of claim a that end in a cycle with rest", ("points", "starts", "share"), tuple(rows)),
    )


def _cascade(trial: Trial) -> Finding:
    rows, orders = [], []
    fractions = (1.02, 0.99, 0.95, 0.92, 0.91, 0.905, 0.9, 0.895, 0.89, 0.88, 0.86, 0.83, 0.8)
    each = trial.size.each(3 * len(fractions)) // 4 + 8
    for i, r in enumerate((0.5, 0.6, 0.7)):
        for fraction in fractions:
            trial.tell("beyond", i, 4)
            found = trial.of(pneumatic(r, fraction * lower_curve(r)), each, "wall")
            cycles = [(name, share) for name, share in found.labels.items() if _doubled(name)]
            orders += [_doubled(name) for name, _ in cycles]
            wandering = found.labels.get("aperiodic", (0.0, 0.0, 0.0))[0]
            shown = ", ".join(f"{name} {100 * share[0]:.3g} %" for name, share in cycles) or "–"
            rows.append((r, fraction, fraction * lower_curve(r), shown, 100 * wandering))
    return Finding(
        "Period doubling",
        "Below the lower curve of Fig. 5 the one-impact motion gives way to motions with 2, 4, … impacts in as many "
        f"load periods; the longest found has {max(orders, default=1)}.",
        ClaimTable(
            "Doubled motions about the lower curve, starts of `wall`",
            ("R", "of the lower curve", "p_0/p_1", "z=2^k/2^k", "aperiodic, %"),
            tuple(rows),
        ),
    )


def _doubled(label: str) -> int:
    """p when a label is z=p/p with p a power of 2; else 0."""
    found = _CYCLE.fullmatch(label)
    p, n = (int(found[1]), int(found[2])) if found else (0, 1)
    return p if p == n and p & (p - 1) == 0 else 0


def _coexisting(ends: Sequence[StartsEnd]) -> Finding:
    rows, several, points = [], 0, {(end.restitution, end.load_factor) for end in ends}
    for r, x in sorted(points):
        here = [end for end in ends if (end.restitution, end.load_factor) == (r, x)]
        names = sorted({name for end in here for name, (_, low, _) in end.labels.items() if low > 0.01})
        several += len(names) > 1
        if len(names) > 1:
            rows.append((r, x, x / upper_curve(r), len(names), ", ".join(names)))
    return Finding(
        "Coexisting motions",
        f"At {several} of the {len(points)} points of claim a more than one motion has, from one of the distributions, "
        "a share that is above 1 % with its whole interval: there the motion depends on the start.",
        ClaimTable(
            "Points with several motions", ("R", "p_0/p_1", "of the upper curve", "motions", "which"), tuple(rows)
        ),
    )


def _resting(trial: Trial) -> Finding:
    rows, regular = [], []
    kappas = (1.3, 1.4, 1.45, 1.5, 1.55, 1.6, 1.7, 1.8, 1.9)
    each = trial.size.each(4 * len(kappas)) // 4 + 8
    for kappa in kappas:
        trial.tell("beyond", 3, 4)
        found = trial.of(hydraulic(0.0, kappa), each, "field")
        share = found.labels.get("rest/1", (0.0, 0.0, 0.0))[0]
        shown = ", ".join(f"{name} {100 * values[0]:.3g} %" for name, values in list(found.labels.items())[:4])
        rate = float(found.columns["blow_rate"][found.attractor == 0].mean())
        rows.append((kappa, percent(round(share * each), each), rate, shown))
        if share == 1.0:
            regular.append(kappa)
    at = ", ".join(f"{kappa:g}" for kappa in regular) or "none of those tried"
    return Finding(
        "The hydraulic hammer that rests",
        "rest/1 is a perfectly regular hammer: the bar strikes once in a load period, lies on the wall until the load "
        f"turns, and leaves. With R = 0 every start ends in it for κ = {at}.",
        ClaimTable("R = 0, starts of `field`", ("κ", "in rest/1", "impacts per period", "motions"), tuple(rows)),
    )


def _dead(trial: Trial) -> Finding:
    """R = 0: an impact under a load that pushes is followed by rest, not by a flight."""
    rows, regular = [], []
    edge = 1.0 / math.hypot(1.0, math.pi) / upper_curve(0.0)  # where p(φ) = 0
    fractions = (0.88, 0.9, 0.92, 0.94, 0.96, 0.98, 0.995)
    each = trial.size.each(4 * len(fractions)) // 4 + 8
    for fraction in fractions:
        x = fraction * upper_curve(0.0)
        ratio = 1.0 - math.sqrt(1.0 - (math.pi * x) ** 2) / x
        found = trial.of(pneumatic(0.0, x), each, "field")
        one, rest = (round(found.labels.get(name, (0.0, 0.0, 0.0))[0] * each) for name in ("z=1/1", "rest/1"))
        rows.append((fraction, x, ratio, percent(one, each), percent(rest, each)))
        if rest == each:
            regular.append(fraction)
    at = ", ".join(f"{fraction:g}" for fraction in regular) or "none of those tried"
    return Finding(
        "The end of the range at R = 0",
        "A bar that does not rebound flies after its impact only where the load then pulls. B77's motion is stable up "
        f"to the upper curve of Fig. 5, but from {edge:.4f} of it on, p_0/p_1 = 1/√(1 + π²), it strikes while the load "
        f"pushes. All starts end in rest/1, the cycle with rest, at {at} of the upper curve.",
        ClaimTable(
            "R = 0, starts of `field`",
            ("of the upper curve", "p_0/p_1", "p(φ)/p_0", "in z=1/1", "in rest/1"),
            tuple(rows),
        ),
    )
