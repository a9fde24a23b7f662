"""Claims e and f: where one-impact motions are stable, and what the stiffness of the bar does to that."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from percuss.model import System
from percuss.model.body import UniformBar
from percuss.paper.claim_common import (
    DAMPED,
    HOLDS,
    NOT,
    PARTLY,
    Claim,
    ClaimTable,
    Trial,
    Verdict,
    hydraulic,
    lower_curve,
    percent,
    pneumatic,
    stable_motions,
    upper_curve,
)
from percuss.paper.claim_hydraulic import Scatter
from percuss.simulate import Starts
from percuss.stability import stability_of
from percuss.steady import steady_states

COARSE = np.linspace(0.0, 0.98, 50).tolist()  # values of R for exact multipliers and simulations
PERIODS = (1, 2, 5)
VARIANTS = (("rigid, d = 0", 1e6, 0.0, 0), ("s = 20, 2πd = 0.03, N = 16", 20.0, DAMPED, 16))


@dataclass(frozen=True)
class Motions:
    """What was found for claim e: how many were tried of each kind, and of how many it is so."""

    range_points: int  # R and m
    range_open: int  # where the lower curve lies below the upper one
    exact_points: int  # R and m whose range was judged by exact multipliers
    exact_stable: int  # where some motion is stable by them
    simulated: int  # starts beside these motions
    returned: int  # that come back
    hydraulic_motions: int  # steady motions of the hydraulic hammer
    hydraulic_stable: int  # by exact multipliers
    hydraulic_waveform: int  # by the criterion for a rigid, undamped bar
    hydraulic_starts: int  # those of claim d
    hydraulic_settled: int  # that end in a one-impact motion


def verdict_e(found: Motions) -> Verdict:
    """The pneumatic part and the hydraulic part, each by closed form, multipliers and simulation."""
    tests = {
        "a range between the curves": found.range_open == found.range_points > 0,
        "stable in it": found.exact_stable == found.exact_points > 0,
        "starts beside it come back": found.returned == found.simulated > 0,
        "no hydraulic motion is stable": found.hydraulic_stable == 0 and found.hydraulic_waveform == 0,
        "no hydraulic start ends in one": found.hydraulic_settled == 0,
    }
    told = (
        f"pneumatic: a stable range at {found.range_open} of {found.range_points} (R, m), stable by exact multipliers "
        f"in it {found.exact_stable} of {found.exact_points}, {found.returned} of {found.simulated} starts "
        f"beside it come back; hydraulic: {found.hydraulic_stable} of {found.hydraulic_motions} motions stable by "
        f"exact multipliers and {found.hydraulic_waveform} by the waveform criterion, {found.hydraulic_settled} of "
        f"{found.hydraulic_starts} starts end in a one-impact motion"
    )
    good = sum(tests.values())
    failed = [name for name, passed in tests.items() if not passed]
    where = told if not failed else f"{told}; what fails: {', '.join(failed)}"
    return Verdict(HOLDS if good == len(tests) else NOT if good == 0 else PARTLY, where)


def claim_e(trial: Trial, scatters: Sequence[Scatter]) -> Claim:
    """The pneumatic hammer has a stable range for every R, the hydraulic none."""
    fine = [(r, m) for r in np.linspace(0.0, 0.999, 1000).tolist() for m in range(1, 11)]
    opened = sum(lower_curve(r, m) < upper_curve(r, m) for r, m in fine)
    rows, without, hydraulic_waveform, counts = [], "", 0, []
    for name, s, d, modes in VARIANTS:
        bad = _without_range(trial, s, d, modes)
        exact = len(COARSE) * len(PERIODS)
        rows.append(("pneumatic, some p_0/p_1 of the range", name, exact, exact - len(bad)))
        without = ", ".join(f"({r:.2g}, {m})" for r, m in bad)
        motions, stable, waveform = _hydraulic(trial, s, d, modes)
        rows.append(("hydraulic, all motions with m = 1", name, motions, stable))
        hydraulic_waveform += waveform if modes == 0 else 0
        counts.append((exact - len(bad), motions, stable))
    each = max(8, min(trial.size.each(len(COARSE)), 1000) // 4)
    simulated, returned = _simulated(trial, each)
    found = Motions(
        len(fine), opened, exact, counts[0][0], simulated, returned, sum(n for _, n, _ in counts),
        sum(n for _, _, n in counts), hydraulic_waveform, sum(item.starts for item in scatters),
        sum(item.one_impact for item in scatters),
    )  # fmt: skip
    narrow = min(fine, key=lambda p: 1.0 - lower_curve(*p) / upper_curve(*p))
    return Claim(
        "e",
        "stable ranges",
        "The pneumatic hammer has a range of p_0/p_1 with a stable one-impact motion for every R, the hydraulic hammer "
        "has none.",
        "Pneumatic: the curves of B77 (38, 39), rigid and undamped, at 1000 values of R from 0 to 0.999 and m = 1 … "
        "10; exact multipliers at nine places of the range at 50 values of R and m = 1, 2, 5; starts beside the "
        f"motion with m = 1, {each} for each R, off by 0.001. Hydraulic: every root of B77 (14) at 20 values of R and "
        "25 of κ, exact multipliers on both sides of the jump and the waveform criterion; and the starts of claim d.",
        "The claim holds when the range is open at all R and m, the rigid motion is stable in it by exact multipliers, "
        "all starts beside it come back, and no motion of the hydraulic hammer is stable or reached. It does not hold "
        "when none of this is so.",
        verdict_e(found),
        simulated,
        {
            **{name: getattr(found, name) for name in Motions.__dataclass_fields__},
            "narrowest range, part of the upper curve": 1.0 - lower_curve(*narrow) / upper_curve(*narrow),
            "at R": narrow[0],
            "and m": narrow[1],
            "R and m with a stable motion, elastic modes and damping": f"{counts[1][0]} of {exact}",
            "without, as (R, m)": without or None,
        },
        (ClaimTable("Exact multipliers", ("motions", "bar", "number", "stable"), tuple(rows)),),
    )


def _without_range(trial: Trial, s: float, d: float, modes: int) -> list[tuple[float, int]]:
    """R and m for which no motion in the range is stable by exact multipliers."""
    bad = []
    for i, r in enumerate(COARSE):
        trial.tell("e", i, 2 * len(COARSE))
        for m in PERIODS:
            if not any(any(stable_motions(pneumatic(r, x, s=s, d=d), m, modes)) for x in _loads(r, m, d)):
                bad.append((r, m))
    return bad


def _hydraulic(trial: Trial, s: float, d: float, modes: int) -> tuple[int, int, int]:
    """Motions of the hydraulic hammer, how many are stable by exact multipliers, and by the waveform criterion."""
    counted = good = waveform = 0
    for i, r in enumerate(np.linspace(0.0, 0.95, 20).tolist()):
        trial.tell("e", len(COARSE) + i, 2 * len(COARSE))
        for kappa in np.linspace(1.02, 1.98, 25).tolist():
            for orbit in steady_states(hydraulic(r, kappa, s=s, d=d), 1, modes=modes).orbits:
                judged = stability_of(orbit, modes=modes)
                counted, good = counted + 1, good + judged.stable
                waveform += judged.waveform.stable
    return counted, good, waveform


def _simulated(trial: Trial, each: int) -> tuple[int, int]:
    """Starts beside the motion in the middle of the range, m = 1, and how many come back to it."""
    draw = np.random.default_rng(trial.seed)
    simulated = returned = 0
    for r in COARSE:
        x = 0.5 * (lower_curve(r) + upper_curve(r))
        orbit = steady_states(pneumatic(r, x), 1, modes=0).orbits[-1]
        off = 1e-3 * draw.standard_normal((2, each))
        starts = Starts.rigid(0.0, orbit.rebound_velocity * (1.0 + off[0]), orbit.phase + off[1])
        labels = trial.of(pneumatic(r, x), each, starts, impacts=20_000).label
        simulated, returned = simulated + each, returned + int((labels == "z=1/1").sum())
    return simulated, returned


def _loads(r: float, m: int, d: float) -> list[float]:
    """Load factors over the stable range; with damping, as far below the fold as they are without."""
    low, high = lower_curve(r, m), upper_curve(r, m)
    fold = high
    if d:
        nearest = steady_states(pneumatic(r, 10.0 * high, d=d), m).nearest
        fold = high if nearest is None else nearest.load_factor
    return [fold * (low + f * (high - low)) / high for f in np.linspace(0.1, 0.9, 9).tolist()]


# ---- Claim f: what the stiffness of the bar does to stability

SPEEDS = (0.4, 1.0, 2.0, 5.0, 8.0, 20.0, 50.0, 100.0)
STIFF = 10.0  # sπ from which on a bar counts as stiff
FEW_PERCENT = 0.01
_LOOSE: dict[str, Any] = {"impacts": 5000, "tolerance": 1e-3}  # elastic modes ring for thousands of impacts
MODES = 16
RESTITUTIONS = (0.2, 0.4, 0.6, 0.8)  # restitutions at which the stable range is looked at

FRACTIONS = tuple(np.linspace(0.05, 0.95, 9).tolist())  # places in that range, from its lower end to its upper one

POINTS = ((0.4, 0.6), (0.6, 0.9), (0.8, 1.2))  # (R, p_0/p_1) of the random starts


@dataclass(frozen=True)
class Stiffness:
    """One s and d beside the rigid bar, m = 1."""

    s: float
    d: float
    threshold: float  # greatest relative change of the lower curve over R, by B77's σ; NaN with damping
    cells: int  # of R and p_0/p_1 in the range where the rigid bar is stable
    agree: int  # of these, where the elastic one is, exactly
    growth: float  # greatest modulus of a multiplier in these cells
    starts: int  # at each of some points, with N modes
    largest_shift: float  # of the share of z=1/1 against the rigid bar with the same starts
    noise: float  # what such a difference may be by chance (three standard deviations of two samples)

    @property
    def first(self) -> float:
        """The first natural frequency, sπ: B77's measure of stiffness."""
        return float(UniformBar(self.s).frequencies(1)[0])

    @property
    def same(self) -> dict[str, bool]:
        """Each test by itself."""
        return {
            "the lower curve moves by less than 1 %": not self.threshold > FEW_PERCENT,
            "stable where the rigid bar is": self.cells > 0 and self.agree == self.cells,
            "the same shares of random starts": self.largest_shift <= self.noise,
        }


def verdict_f(found: Sequence[Stiffness]) -> Verdict:
    """Among the stiff bars: everything the same, something, or nothing."""
    stiff = [item for item in found if item.first >= STIFF]
    if not stiff:
        return Verdict(NOT, "nothing was tried")
    names = list(stiff[0].same)
    told = []
    for name in names:
        bad = [item for item in stiff if not item.same[name]]
        text = "at all" if not bad else f"not at {', '.join(_name(item) for item in bad)}"
        told.append(f"{name}: {text}")
    passed = [all(item.same.values()) for item in stiff]
    where = "; ".join(told)
    if any(passed) and not all(passed):
        good = ", ".join(_name(item) for item, whole in zip(stiff, passed, strict=True) if whole)
        where = f"all tests are passed by {good}; {where}"
    tests = [value for item in stiff for value in item.same.values()]
    return Verdict(HOLDS if all(passed) else PARTLY if any(tests) else NOT, where)


def _name(item: Stiffness) -> str:
    return f"s = {item.s:g} {'with damping' if item.d else 'undamped'}"


def _kept(s: float, d: float) -> tuple[int, int, float, tuple[float, float], str]:
    """By exact multipliers: cells of the rigid bar's range, how many stay stable, the greatest modulus, where, why."""
    cells = agree = 0
    growth, worst, why = 0.0, (math.nan, math.nan), ""
    for r in RESTITUTIONS:
        low, high = lower_curve(r), upper_curve(r)
        for fraction in FRACTIONS:
            x = low + fraction * (high - low)
            if not any(stable_motions(pneumatic(r, x, d=d), 1, 0)):
                continue  # damping has moved the range of the rigid bar a little
            cells += 1
            orbits = steady_states(pneumatic(r, x, s=s, d=d), 1, modes=MODES).orbits
            judged = [stability_of(orbit, modes=MODES) for orbit in orbits if np.cos(orbit.phase) < 0.0]
            agree += any(one.stable for one in judged)
            best = min(judged, key=lambda one: one.multipliers.largest, default=None)
            if best is not None and best.multipliers.largest > growth:
                growth, worst, why = best.multipliers.largest, (r, x), best.reason
    return cells, agree, growth, worst, why


def _moved(s: float) -> float:
    """Greatest relative change of the lower curve, by σ_p of B77 (37) in closed form."""
    stiff = 0.5 * ((1.0 / s) / math.sin(1.0 / s) - 1.0)
    return max(abs(lower_curve(r, 1, (1.0 - r) / (1.0 + r) * stiff) / lower_curve(r) - 1.0) for r in RESTITUTIONS)


def _share(trial: Trial, starts: int, system: System, **options: Any) -> float:
    return float((trial.of(system, starts, "wall", **options, **_LOOSE).label == "z=1/1").mean())


def _shift(share: float, other: float, starts: int) -> tuple[float, float]:
    """By how much two shares differ, and what that may be by chance."""
    noise = 3.0 * math.sqrt((share * (1 - share) + other * (1 - other) + 1.0 / starts) / starts)
    return abs(other - share), noise


def claim_f(trial: Trial) -> Claim:
    """For m = 1 and sπ ≫ 1 the stiffness does not matter."""
    each = trial.size.each(len(POINTS) * (2 * len(SPEEDS) + 2))
    found: list[Stiffness] = []
    rows = []
    for d in (0.0, DAMPED):
        rigid = [_share(trial, each, pneumatic(r, x, d=d)) for r, x in POINTS]
        for s in SPEEDS:
            trial.tell("f", len(found), 2 * len(SPEEDS))
            cells, agree, growth, worst, why = _kept(s, d)
            elastic = [_share(trial, each, pneumatic(r, x, s=s, d=d), modes=8) for r, x in POINTS]
            shifts = [_shift(one, other, each) for one, other in zip(rigid, elastic, strict=True)]
            shift, noise = max(shifts, key=lambda pair: pair[0] - pair[1])
            threshold, damping = (math.nan, "2πd = 0.03") if d else (_moved(s), "none")
            found.append(Stiffness(s, d, threshold, cells, agree, growth, each, shift, noise))
            exact = (percent(agree, cells), growth, *worst, why)
            rows.append((s, found[-1].first, damping, 100 * threshold, *exact, 100 * shift, 100 * noise))
    return _told(found, rows, each)


def _told(found: Sequence[Stiffness], rows: Sequence[tuple[Any, ...]], each: int) -> Claim:
    columns = (
        "s", "sπ", "damping", "lower curve moves by, %", "stable where the rigid bar is", "greatest multiplier", "at R",
        "p_0/p_1", "reason there", "share of z=1/1 shifts by, points", "by chance up to",
    )  # fmt: skip
    stiff = [item for item in found if item.first >= STIFF]
    return Claim(
        "f",
        "stiffness",
        "For m = 1 and sπ much greater than 1 the stiffness of the bar does not matter.",
        f"Pneumatic hammer, s = {', '.join(f'{s:g}' for s in SPEEDS)}, without damping and with 2πd = 0.03, beside the "
        f"rigid bar: the lower curve of B77 (39) with its σ; exact multipliers of {MODES} modes at "
        f"{len(RESTITUTIONS) * len(FRACTIONS)} points of the stable range; {each} starts of `wall` with 8 modes "
        "(called periodic when they return to 0.001: the elastic modes ring for thousands of impacts) at "
        f"(R, p_0/p_1) = {', '.join(f'({r:g}, {x:g})' for r, x in POINTS)}.",
        f"A bar with sπ ≥ {STIFF:g} passes when the lower curve moves by less than 1 %, the motion is stable wherever "
        "the rigid one is, and the share of random starts that end in z=1/1 differs by less than three standard "
        "deviations. The claim holds when all such bars pass all tests, and does not hold when none passes any.",
        verdict_f(found),
        each * len(POINTS) * (2 * len(SPEEDS) + 2),
        {
            "greatest shift of the lower curve, sπ ≥ 10": max(
                i.threshold for i in stiff if not math.isnan(i.threshold)
            ),
            "points that stay stable undamped, sπ ≥ 10": sum(item.agree for item in stiff if item.d == 0.0),
            "of so many undamped": sum(item.cells for item in stiff if item.d == 0.0),
            "points that stay stable damped, sπ ≥ 10": sum(item.agree for item in stiff if item.d > 0.0),
            "of so many damped": sum(item.cells for item in stiff if item.d > 0.0),
            "greatest multiplier undamped, sπ ≥ 10": max(item.growth for item in stiff if item.d == 0.0),
            "greatest multiplier damped, sπ ≥ 10": max(item.growth for item in stiff if item.d > 0.0),
        },
        (ClaimTable("Elastic bars beside the rigid one", columns, tuple(rows)),),
        _remark(stiff),
    )


def _remark(stiff: Sequence[Stiffness]) -> tuple[str, ...]:
    """What the elastic modes do, when they do it."""
    lost = [item for item in stiff if item.agree < item.cells]
    if not lost:
        return ()
    shown = ", ".join(f"{_name(item)}: {item.cells - item.agree} of {item.cells} points" for item in lost)
    worst = max(item.growth for item in lost)
    return (
        f"Where the elastic bar is unstable and the rigid one is not ({shown}), an elastic mode grows, by at most "
        f"{worst:.6f} per impact. B77's reduced criterion does not see it: it holds the elastic modes to be stable "
        "whenever there is damping, and says nothing of them without. The growth is a property of the paper's contact "
        "law, which keeps the strain at the impact, not of bars: waves turn the strain over, and the modes die out.",
    )
