"""Claim e: where one-impact motions are stable."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from percuss.paper.claim_common import (
    DAMPED,
    HOLDS,
    NOT,
    PARTLY,
    Claim,
    Table,
    Trial,
    Verdict,
    hydraulic,
    lower_curve,
    pneumatic,
    stable_motions,
    upper_curve,
)
from percuss.paper.claim_hydraulic import Scatter
from percuss.simulate import Starts
from percuss.stability import stability_of
from percuss.steady import steady_states

COARSE = np.linspace(0.0, 0.98, 50).tolist()
"""Values of R for exact multipliers and simulations."""

PERIODS = (1, 2, 5)
VARIANTS = (("rigid, d = 0", 1e6, 0.0, 0), ("s = 20, 2πd = 0.03, N = 16", 20.0, DAMPED, 16))


@dataclass(frozen=True)
class Motions:
    """What was found for claim e.

    Parameters
    ----------
    range_points, range_open
        R and m that were tried, and at how many the lower curve lies below the upper one.
    exact_points, exact_stable
        R and m for which motions in the range were judged by exact multipliers, and for how many some are stable.
    simulated, returned
        Starts beside them, and how many come back.
    hydraulic_motions, hydraulic_stable
        Steady motions of the hydraulic hammer, and how many are stable by exact multipliers.
    hydraulic_waveform
        How many satisfy the criterion for a rigid, undamped bar.
    hydraulic_starts, hydraulic_settled
        Starts of claim d, and how many end in a one-impact motion.
    """

    range_points: int
    range_open: int
    exact_points: int
    exact_stable: int
    simulated: int
    returned: int
    hydraulic_motions: int
    hydraulic_stable: int
    hydraulic_waveform: int
    hydraulic_starts: int
    hydraulic_settled: int


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
        (Table("Exact multipliers", ("motions", "bar", "number", "stable"), tuple(rows)),),
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
