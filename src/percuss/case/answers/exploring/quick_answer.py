"""The answer while a value is being moved: phases, both criteria and the figures in SI, without proofs."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from percuss.case.answers.facts import json_number, numbers, picked, plain, plain_of
from percuss.case.answers.heading import CLOCKED, clocked_because, motion_dict
from percuss.case.answers.steady_answer import WAVEFORM, reduced_dict, steady_answer, timed_period, with_blow
from percuss.case.answers.steady_report import ENDED, timed_sentences
from percuss.stability import Plane, exact_plane, reduced_criterion, stability_of, stability_plane, waveform_criterion
from percuss.stability.verdict import waveform_bounds
from percuss.steady import steady_states
from percuss.steady.figures import FIGURES, figures_in_si

if TYPE_CHECKING:
    from percuss.case.answers.steady_answer import OrbitAnswer, TimedAnswer, TimedPeriod
    from percuss.case.case import Case
    from percuss.explore import Boundaries
    from percuss.model import System
    from percuss.stability import ExactPlane
    from percuss.steady import Orbit, SteadyStates


_DIMENSIONLESS = ("phase", "impact_velocity", "rigid_velocity", "blow_energy")
_IN_SI = (
    "impact_velocity_m_s", "rigid_velocity_m_s", "blow_energy_J", "delivered_energy_J", "blow_rate_Hz",
    "blow_rate_per_min", "percussive_power_kW",
)  # fmt: skip
"""Figures that are products of what a root gives; the others need integrals."""


def quick_dict(
    case: Case, periods: int = 1, curve: int = 0, modes: int = 32, multipliers: bool = False
) -> dict[str, Any]:
    """All steady motions of a case with one impact in `periods` load periods, as far as a few milliseconds go."""
    # What needs a proof or an integral (admissible, violation, energy, stroke, efficiency) is left to `steady_answer`;
    # the rest agrees with it, to rounding. Under a law of blows that take time `phase` is that of the force's centroid,
    # as there, and `blow` says in lines what the law makes of the motion, `blow_alone` of those it alone has. `curve`
    # is the number of samples of v_f and p over a period; all `multipliers` take the longest.
    system, law = case.system(), case.timed_law()
    timed = None if law is None else timed_period(system, law, periods, None)
    states = steady_states(system, periods) if timed is None else timed.states.b77
    nearest = states.nearest
    judged = _judged(states, modes, multipliers)
    levels, motions = [(states.level, states.level_max)], [(True, found["stable"]) for found in judged]
    return {
        "m": int(states.periods),
        **picked(states, "level level_max exists note"),
        "nearest": None if nearest is None else picked(nearest, "load_factor restitution"),
        "clocked": CLOCKED if clocked_because(system.load, levels, motions) else "",
        "load_factor": json_number(system.load.load_factor),
        "restitution": json_number(system.restitution),
        "orbits": [
            _timed(_orbit(orbit, found), orbit, timed) for orbit, found in zip(states.orbits, judged, strict=True)
        ],
        "curve": _curve(states, curve) if curve else None,
        "motion": motion_dict(system),
        **({} if timed is None else {"blow_alone": [_told(timed, one) for one in timed.alone]}),
    }


def _judged(states: SteadyStates, modes: int, multipliers: bool) -> list[dict[str, Any]]:
    if multipliers or any(orbit.system.load.jumps for orbit in states.orbits):
        return [_by_multipliers(orbit, modes) for orbit in states.orbits]
    if not states.orbits:
        return []
    exact = _exact(states, modes)
    found = []
    for at, orbit in enumerate(states.orbits):
        if orbit.fold or not np.isfinite(exact.multiplier[at]):
            found.append(_by_multipliers(orbit, modes))
            continue
        told = {"modes": modes, "largest": exact.largest[at], "dominant_mode": exact.mode[at]}
        found.append(
            {
                **_UNKNOWN,
                **plain({"stable": exact.stable[at], "margin": exact.margin[at]}),
                "reduced": reduced_dict(reduced_criterion(orbit)),
                "waveform": plain_of(waveform_criterion(orbit), WAVEFORM),
                "multipliers": plain({**told, "rigid": None, "values": None}),
            }
        )
    return found


_UNKNOWN = dict.fromkeys(("margin_rhythm", "margin_ringing", "reason", "reduced", "waveform"))
"""What the page is told of a motion only where it is known."""


def _exact(states: SteadyStates, modes: int) -> ExactPlane:
    """The largest multipliers of all orbits at once: a plane of one cell, with the orbits as its branches."""
    system = states.system
    phase = np.array([orbit.phase for orbit in states.orbits])
    nothing = np.full(phase.shape, np.nan)
    cell = Plane(
        phase=phase,
        level=np.asarray(states.level),
        slope=nothing,
        sigma=nothing,
        a=np.full((3, phase.size), np.nan),
        schur=np.full((2, phase.size), np.nan),
        stable=np.zeros(phase.shape, dtype=bool),
        fold=np.array([orbit.fold for orbit in states.orbits], dtype=bool),
    )
    r, factor = system.restitution, system.load.load_factor
    return exact_plane(system, r, factor, states.periods, modes, plane=cell, workers=1)


def _by_multipliers(orbit: Orbit, modes: int) -> dict[str, Any]:
    verdict = stability_of(orbit, modes=modes)
    found = verdict.multipliers
    return {
        **picked(verdict, "stable margin margin_rhythm margin_ringing reason"),
        "reduced": reduced_dict(verdict.reduced),
        "waveform": plain_of(verdict.waveform, WAVEFORM),
        "multipliers": picked(found, "modes largest dominant_mode rigid values"),
    }


def _orbit(orbit: Orbit, judged: dict[str, Any]) -> dict[str, Any]:
    return {
        **plain({name: FIGURES[name].value(orbit) for name in _DIMENSIONLESS}),
        "fold": bool(orbit.fold),
        **judged,
        "si": plain(figures_in_si(orbit, _IN_SI)) if orbit.system.is_si else None,
    }


def _timed(told: dict[str, Any], orbit: Orbit, timed: TimedPeriod | None) -> dict[str, Any]:
    if timed is None:
        return told
    found = timed.continuing(orbit)
    return {**with_blow(told, found), "blow": _told(timed, found)}


def _told(timed: TimedPeriod, found: TimedAnswer | None) -> list[str]:
    lines = [ENDED] if found is None else [*timed_sentences(found), *found.orbit.warnings]
    return [f"{timed.states.law.law}: {lines[0]}", *lines[1:]]


def _curve(states: SteadyStates, points: int) -> dict[str, Any]:
    phase = np.linspace(0.0, 2.0 * math.pi, points)
    return {
        "phase": numbers(phase),
        "rigid_velocity": numbers(states.rigid_velocity(phase)),
        "load": numbers(states.system.load.value(phase)),
    }


# ---- The answer of a structure that is held while a value is being moved: its motions with one impact, and verdicts


def quick_structure_dict(case: Case, periods: int = 1) -> dict[str, Any]:
    """`quick_dict` of a structure: null what that has of a free bar alone."""
    answer = steady_answer(case, (periods,))
    states, load = answer.periods[0].states, answer.system.load
    return {
        "m": int(states.periods),
        **picked(states, "level level_max exists"),
        "nearest": None,
        "note": states.note or "The contact comes nowhere near the wall.",
        "clocked": "",
        "load_factor": json_number(load.load_factor),
        "restitution": json_number(answer.system.restitution),
        "orbits": [_motion(one) for one in answer.periods[0].orbits],
        "curve": None,
        "motion": motion_dict(answer.system),
    }


def _motion(one: OrbitAnswer) -> dict[str, Any]:
    told, found, stable = one.to_json_dict(), one.stability.multipliers, one.stability.stable
    in_si = one.orbit.system.is_si
    return {
        **{name: told[name] for name in ("phase", "impact_velocity", "blow_energy", "fold", "stable")},
        **_UNKNOWN,
        "margin": json_number(1.0 - found.largest),
        "reason": "stable" if stable else f"unstable: largest multiplier {found.largest:.3g}",
        "multipliers": picked(found, "modes largest dominant_mode") | {"rigid": None, "values": told["multipliers"]},
        "si": {name: told[name] for name in ("impact_velocity_m_s", "blow_energy_J")} if in_si else None,
    }


# ---- The curves behind a steady answer: v_f and the load over one period, and the branches over the load factor


def curves_dict(
    case: Case,
    periods: int = 1,
    points: int = 721,
    branches: int = 200,
    load_factor: Sequence[float] | None = None,
    modes: int = 32,
) -> dict[str, Any]:
    """v_f with its level, the load with the window of the waveform criterion, and all branches to the last fold."""
    system = case.system()
    states = steady_states(system, periods)
    phase = np.linspace(0.0, 2.0 * math.pi, points)
    load = system.load
    right = load.value(phase, "right")
    return {
        "m": int(states.periods),
        "phase": numbers(phase),
        "rigid_velocity": numbers(states.rigid_velocity(phase)),
        "load": numbers(load.value(phase, "left")),
        "load_right": numbers(right),
        "force_N": numbers(system.force_scale * right) if system.is_si else None,
        **picked(states, "level level_max"),
        "waveform": _waveform(system, states.orbits),
        "branches": _branches(system, periods, branches, load_factor, modes, states.level_max, states.level),
    }


def _waveform(system: System, orbits: Sequence[Any]) -> dict[str, Any]:
    found = [waveform_criterion(orbit) for orbit in orbits]
    lower, upper = waveform_bounds(system.contact)
    return {
        "lower": json_number(lower),
        "upper": json_number(upper),
        "mean": json_number(system.load.mean),
        "orbits": [
            {"phase": json_number(orbit.phase), **picked(one, "ratio force stable")}
            for orbit, one in zip(orbits, found, strict=True)
        ],
    }


def _branches(
    system: System,
    periods: int,
    count: int,
    load_factor: Sequence[float] | None,
    modes: int,
    level_max: float,
    level: float,
) -> dict[str, Any]:
    now = system.load.load_factor
    if load_factor is None:
        # the level is proportional to the mean load; with R = 1 and no damping it is 0, and there is no last fold
        highest = now * level_max / level if level > 0.0 else now
        low, high = 0.01 * highest, max(1.1 * highest, min(1.1 * now, 3.0 * highest))
    else:
        low, high = load_factor
    values = np.linspace(low, high, count)
    plane = stability_plane(system, system.restitution, values, periods)
    exact = exact_plane(system, system.restitution, values, periods, modes, plane=plane)
    there = [row for row in range(plane.phase.shape[0]) if np.isfinite(plane.phase[row]).any()]
    return {
        "load_factor": numbers(values),
        "restitution": json_number(system.restitution),
        "now": json_number(now),
        "phase": [numbers(plane.phase[row]) for row in there],
        "reduced_stable": [plane.stable[row].tolist() for row in there],
        "stable": [exact.stable[row].tolist() for row in there],
        "margin": [numbers(exact.margin[row]) for row in there],
    }


def boundaries_dict(found: Boundaries) -> dict[str, Any]:
    """Boundaries in plain values; null where a curve has no point."""
    return {
        **picked(found, "x_name y_name x"),
        "curves": [picked(curve, "kind branch x y phase") for curve in found.real],
        "failed": [[json_number(value), why] for value, why in found.failed],
    }
