"""In the picture of a steady answer: the motions of a law of blows that take time, beside those of B77's law."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from percuss.plot.canvas import COLOURS, INK

if TYPE_CHECKING:
    from percuss.model.checks import Array
    from percuss.plot.judged_motions import JudgedMotions, JudgedTimed
    from percuss.steady import Orbit

__all__ = ["timed_marks", "timed_phase"]

_FEW = 2  # numbers of load periods that are told one by one in the legend


def timed_marks(axes: Any, answer: JudgedMotions, phases: Array) -> str:
    """The curve v_f − e p with its levels, and a diamond at the phase of every force's centroid; the panel's title."""
    low, high = axes.get_ylim()
    found = _all(answer)
    if found and found[0][1].states.law.arm != 0.0:
        axes.plot(phases, found[0][1].states.curve(phases), color=INK, linewidth=0.8, linestyle=":")
    for i, timed in found:
        colour, states = COLOURS[i % len(COLOURS)], timed.states
        if not low < states.level < high:
            continue
        of = "" if len(answer.periods) == 1 else f", m = {states.periods}"
        label = f"level, {states.law.law}{of}" if i < _FEW else None
        axes.axhline(states.level, color=colour, linestyle=":", linewidth=1.1, label=label)
        for one in timed.orbits:
            fill = colour if one.stability.stable else "white"
            mark = {"marker": "D" if one.orbit.admissible else "x", "markersize": 5, "markeredgewidth": 1.2}
            axes.plot(
                [one.orbit.phase], [states.level], color=colour, markerfacecolor=fill, clip_on=False, zorder=4, **mark
            )
    if not found:
        return ""
    axes.plot([], [], "D", color=INK, markersize=5, label="centroid of the force")
    return f"(a) phases by B77's law; ◆ by {found[0][1].states.law.law}"


def timed_phase(answer: JudgedMotions, orbit: Orbit) -> str:
    """The phase of the motion that continues one of B77's law, behind its mark; empty without such a law."""
    for _, timed in _all(answer):
        if timed.states.periods == orbit.periods:
            found = (one.orbit.phase for one in timed.orbits if one.orbit.phase_b77 == orbit.phase)
            phase = next(found, None)
            return f", ◆ {'none' if phase is None else f'{phase:.3f}'}"
    return ""


def _all(answer: JudgedMotions) -> list[tuple[int, JudgedTimed]]:
    return [(i, period.timed) for i, period in enumerate(answer.periods) if period.timed is not None]
