"""Claim d: the hydraulic hammer settles nowhere, and its impact frequency scatters."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from percuss.model.checks import Array
from percuss.paper.claim_common import (
    DAMPED,
    HOLDS,
    NAMED,
    NOT,
    PARTLY,
    Claim,
    ClaimTable,
    Trial,
    Verdict,
    hydraulic,
    lower_curve,
    one_impact,
    percent,
    pneumatic,
    upper_curve,
)
from percuss.paper.claim_pneumatic import StartsEnd

RESTITUTIONS = (0.0, 0.2, 0.4, 0.6, 0.8)
KAPPAS = (1.05, 1.1, 1.2, 1.3, 1.4, 1.5, 1.6, 1.7, 1.8)
ELASTIC = tuple((r, kappa) for r in (0.2, 0.5, 0.8) for kappa in (1.2, 1.5))
LEAST, MOST = 0.05, 0.10
ALIKE = 0.10  # medians of the scatter from two distributions that differ by less than this part are alike


@dataclass(frozen=True)
class Scatter:
    """The starts of one distribution at one point: how many settle, and how the impacts of the others scatter."""

    restitution: float
    kappa: float
    distribution: str
    starts: int
    periodic: int
    resting: int  # of the periodic ones those with rest
    one_impact: int
    rate: float  # impacts per load period, mean over all starts
    main_rate: float  # the same of the main blows
    scatter: float  # median over the starts: standard deviation of the time between impacts over its mean
    main_scatter: float  # the same of the main blows
    spread: float  # half the range from the 5th to the 95th percentile of it, over the median
    between: float  # standard deviation over the starts of the rate of a whole motion, over its mean
    main: str  # the most frequent motion


def scatters_of(trial: Trial) -> list[Scatter]:
    """The experiments of claim d."""
    points = [(r, kappa) for r in RESTITUTIONS for kappa in KAPPAS]
    each, found = _each(trial), []
    for i, (r, kappa) in enumerate(points):
        trial.tell("d", i, len(points))
        found += [_scatter(trial, r, kappa, name, each) for name in NAMED]
    return found


def _each(trial: Trial) -> int:
    """Starts for each point: few, as each is followed through all its impacts."""
    return max(16, trial.size.each(len(RESTITUTIONS) * len(KAPPAS) * len(NAMED)) // 4)


def _impacts(trial: Trial) -> int:
    return max(trial.size.impacts // 2, 256)


def _scatter(trial: Trial, r: float, kappa: float, name: str, each: int, elastic: bool = False) -> Scatter:
    """One experiment; the elastic bar has s = 20, 2πd = 0.03 and 8 modes."""
    system = hydraulic(r, kappa, s=20.0, d=DAMPED) if elastic else hydraulic(r, kappa)
    result = trial.of(system, each, name, modes=8 if elastic else 0, impacts=_impacts(trial))
    c = result.columns
    with np.errstate(divide="ignore", invalid="ignore"):
        std, main = (c[f"{k}_std"] / c[f"{k}_mean"] for k in ("interval", "main_interval"))
    known = main[np.isfinite(main)]
    low, middle, high = np.percentile(known, (5, 50, 95)).tolist() if known.size else (0.0, 0.0, 0.0)
    return Scatter(
        restitution=r,
        kappa=kappa,
        distribution=name,
        starts=each,
        periodic=int((c["cycle_periods"] > 0).sum()),
        resting=int(((c["cycle_kind"] > 0) & (c["cycle_periods"] > 0)).sum()),
        one_impact=int(one_impact(result.label).sum()),
        rate=_mean(c["blow_rate"]),
        main_rate=_mean(c["main_blow_rate"]),
        scatter=_median(std),
        main_scatter=_median(main),
        spread=0.5 * (high - low) / middle if middle > 1e-9 else 0.0,
        between=_known(c["blow_rate"], lambda rates: rates.std() / rates.mean() if rates.mean() > 0.0 else np.nan),
        main=next(iter(result.labels)),
    )


def _known(values: Array, of: Callable[[Array], Any]) -> float:
    """Something of the values that are known; NaN without any."""
    known = values[np.isfinite(values)]
    return float(of(known)) if known.size else float("nan")


def _mean(values: Array) -> float:
    return _known(values, np.mean)


def _median(values: Array) -> float:
    return _known(values, np.median)


def _points(found: Sequence[Scatter]) -> list[list[Scatter]]:
    keys = dict.fromkeys((item.restitution, item.kappa) for item in found)
    return [[item for item in found if (item.restitution, item.kappa) == key] for key in keys]


def _alike(items: Sequence[Scatter]) -> bool:
    values = [item.main_scatter for item in items]
    return bool(np.isfinite(values).all()) and max(values) - min(values) <= ALIKE * max(max(values), 1e-6)


def parts_d(found: Sequence[Scatter]) -> dict[str, tuple[int, int]]:
    """For each part of the claim the points where it holds, and all points."""
    points = _points(found)
    tests = {
        "settles nowhere": lambda items: all(item.periodic == 0 for item in items),
        "main blows scatter by 5 to 10 %": lambda items: all(LEAST <= item.main_scatter <= MOST for item in items),
        "all impacts scatter by 5 to 10 %": lambda items: all(LEAST <= item.scatter <= MOST for item in items),
        "the rates of whole motions scatter by 5 to 10 %": lambda items: all(
            LEAST <= item.between <= MOST for item in items
        ),
        "the main blows come at the load's frequency, to 1 %": lambda items: all(
            abs(item.main_rate - 1.0) < 0.01 for item in items
        ),
        "the scatter does not depend on the start": _alike,
    }
    return {name: (sum(test(items) for items in points), len(points)) for name, test in tests.items()}


NEEDED = (
    "settles nowhere",
    "main blows scatter by 5 to 10 %",
    "the main blows come at the load's frequency, to 1 %",
    "the scatter does not depend on the start",
)


def verdict_d(found: Sequence[Scatter]) -> Verdict:
    """All parts of the claim at every point, at some, or at none together."""
    if not found:
        return Verdict(NOT, "nothing was tried")
    parts = parts_d(found)
    points = _points(found)
    together = [items for items in points if all(count == 1 for count, _ in (parts_d(items)[name] for name in NEEDED))]
    told = "; ".join(f"{name}: at {k} of {n} points" for name, (k, n) in parts.items())
    told += f"; all that is claimed together: at {len(together)} of {len(points)}"
    if together and len(together) < len(points):
        told += f" (R, κ = {', '.join(f'{i[0].restitution:g}, {i[0].kappa:g}' for i in together[:12])})"
    return Verdict(HOLDS if len(together) == len(points) else PARTLY if together else NOT, told)


def claim_d(trial: Trial, found: Sequence[Scatter]) -> Claim:
    """The hydraulic hammer settles nowhere; its impact frequency scatters about the load's by 5 to 10 %."""
    elastic = [_scatter(trial, r, kappa, "field", _each(trial), elastic=True) for r, kappa in ELASTIC]
    wandering = [item for item in found if item.periodic < 0.5 * item.starts]
    main = [item.main_scatter for item in wandering]
    points = _points(found)
    periodic, resting = sum(item.periodic for item in found), sum(item.resting for item in found)
    return Claim(
        "d",
        "the hydraulic hammer",
        "The hydraulic hammer settles on no periodic motion; the frequency of its impacts scatters about that of the "
        "load with a standard deviation of 5 to 10 %, which depends on R and κ but not on the start.",
        f"Rigid bar without damping under the exact square wave, R = {', '.join(f'{r:g}' for r in RESTITUTIONS)}, "
        f"κ = {', '.join(f'{k:g}' for k in KAPPAS)}; {found[0].starts} starts of each distribution, followed for "
        f"{_impacts(trial)} impacts unless they settle. Scatter: standard deviation of the time "
        "between impacts over its mean, without the first half of the impacts; all impacts, and main blows, for which "
        "a completed chatter counts once.",
        "A point (R, κ) is good when no start settles on a periodic motion, the main blows come at the load's "
        "frequency to 1 %, their scatter (median over the starts) is 5 to 10 %, and it differs by less than "
        f"{100 * ALIKE:g} % between the distributions. The claim holds when all points are good, and does not hold "
        "when none is.",
        verdict_d(found),
        sum(item.starts for item in found),
        {
            "points": len(points),
            **{name: k for name, (k, _) in parts_d(found).items()},
            "least scatter of main blows where most starts do not settle": min(main, default=None),
            "greatest scatter of them": max(main, default=None),
            "median scatter of them": float(np.median(main)) if main else None,
            "starts that settle": periodic / sum(item.starts for item in found),
            "of these on a cycle with rest": resting / periodic if periodic else None,
            "starts in a one-impact motion": sum(item.one_impact for item in found),
        },
        (
            _table("Scatter of the impacts", found),
            _table("The same of an elastic bar, s = 20, 2πd = 0.03, 8 modes, not in the verdict", elastic),
        ),
        (
            f"Of the motions that settle {percent(resting, periodic)} do so on a cycle with rest: the steps of the "
            "load release the bar always at the same phase, undeformed and without speed, so that a motion which has "
            "come to rest twice repeats itself from then on. How many settle therefore grows with the time that they "
            "are followed.",
        ),
    )


def _table(title: str, found: Sequence[Scatter]) -> ClaimTable:
    rows = []
    for items in _points(found):
        n, periodic = sum(item.starts for item in items), sum(item.periodic for item in items)
        rates, mains, scatters, between = (
            np.array([getattr(item, name) for item in items]) for name in ("rate", "main_rate", "scatter", "between")
        )
        blows = ", ".join(f"{100 * item.main_scatter:.3g}" for item in items)
        first, spread = items[0], 100 * max(item.spread for item in items)
        rows.append(
            (
                first.restitution, first.kappa, percent(periodic, n), _mean(rates), _mean(mains),
                100 * _median(scatters), blows, spread, 100 * _median(between), first.main,
            )
        )  # fmt: skip
    names = ", ".join(dict.fromkeys(item.distribution for item in found))
    columns = (
        "R", "κ", "settled", "impacts per period", "main blows per period", "scatter of all, %",
        f"of main blows, % ({names})", "spread over starts, ± % of it", "rates of whole motions, %", "most frequent",
    )  # fmt: skip
    return ClaimTable(title, columns, tuple(rows))


# ---- What B77 does not tell: motions with chatter and rest, cascades, coexisting motions, the hammer that rests

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
