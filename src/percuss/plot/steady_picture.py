"""The picture of a steady answer: where the phases come from, the load, the gap, the multipliers and the waves."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from percuss.case.answers.steady_answer import PeriodAnswer, judged
from percuss.model.checks import having
from percuss.plot.canvas import (
    COLOURS,
    INK,
    Units,
    canvas,
    draw_measured,
    draw_waves,
    measured_panels,
    nothing,
    phase_axis,
    units_of,
    wall,
)
from percuss.steady import SteadyStates

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from percuss.case.answers.steady_answer import OrbitAnswer, SteadyAnswer, TimedPeriod
    from percuss.model import System
    from percuss.model.checks import Array
    from percuss.steady import Orbit
    from percuss.steady.recorded.force_record import MeasuredForce


# ---- What is drawn: the motions of an answer, or of bare steady states, each with its verdict


class _Motions(NamedTuple):
    title: str
    system: System
    periods: tuple[PeriodAnswer, ...]
    chosen: OrbitAnswer | None
    measured: MeasuredForce | None = None
    tool: object = None

    @property
    def coloured(self) -> list[tuple[str, OrbitAnswer]]:
        """Every orbit with the colour of its m; of a held structure those that strike: each has one striking back."""
        every = [(_colour(i), found) for i, period in enumerate(self.periods) for found in period.orbits]
        return [pair for pair in every if self.system.body.is_free or pair[1].orbit.impact_velocity > 0.0]

    @property
    def timed(self) -> list[tuple[int, TimedPeriod]]:
        """What a law of blows that take time says, with the place of each m."""
        return [(i, period.timed) for i, period in enumerate(self.periods) if period.timed is not None]


def _colour(i: int) -> str:
    return COLOURS[i % len(COLOURS)]


# ---- In the picture of a steady answer: the motions of a law of blows that take time, beside those of B77's law

_FEW = 2  # numbers of load periods that are told one by one in the legend


def _timed_marks(axes: Any, answer: _Motions, phases: Array) -> str:
    """The curve v_f − e p with its levels, and a diamond at the phase of every force's centroid; the panel's title."""
    low, high = axes.get_ylim()
    found = answer.timed
    if found and found[0][1].states.law.arm != 0.0:
        axes.plot(phases, found[0][1].states.curve(phases), color=INK, linewidth=0.8, linestyle=":")
    for i, timed in found:
        colour, states = _colour(i), timed.states
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


def _timed_phase(answer: _Motions, orbit: Orbit) -> str:
    """The phase of the motion that continues one of B77's law, behind its mark; empty without such a law."""
    for _, timed in answer.timed:
        if timed.states.periods == orbit.periods:
            found = (one.orbit.phase for one in timed.orbits if one.orbit.phase_b77 == orbit.phase)
            phase = next(found, None)
            return f", ◆ {'none' if phase is None else f'{phase:.3f}'}"
    return ""


# ---- The picture of a steady answer: where the phases come from, the load, the gap, the multipliers and the waves

POINTS = 721  # samples of a curve over one load period

EDGE = 1.7  # how far the panel of the multipliers reaches; what lies beyond is an arrow at its edge


def steady(answer: SteadyAnswer | SteadyStates) -> Figure:
    """Draw a steady answer, or the steady states of any system, with units or without.

    Five panels: (a) v_f over the phase with the level of every m, whose crossings are the impact phases; (b) the load
    over one period with the moments of impact and the band of the waveform criterion, over the record that it was made
    from, cycle for cycle, with what it leaves of it; (c) the striking end's gap
    between two impacts; (d) the multipliers on the unit circle; (e) the stress along the bar over time. Under a law of
    blows that take time (a) also shows its curve and its levels, with the phases of the force's centroid; all other
    panels are those of B77's law, and (c) names both phases. A structure that is held has no v_f and no waves: three
    panels show its load, its contact before the wall, and its multipliers.

    Examples
    --------
    >>> from percuss.case import load_case, steady_answer
    >>> from percuss.plot import steady
    >>> len(steady(steady_answer(load_case("laboratory-striker"))).axes) >= 5
    True

    >>> from percuss import Load, System, steady_states
    >>> system = System(s=20.0, d=0.0048, restitution=0.6, load=Load.harmonic(0.9, 1.0))
    >>> len(steady(steady_states(system)).axes) >= 5
    True
    """
    if isinstance(answer, SteadyStates):
        judged_orbits = tuple(map(judged, answer.orbits))
        chosen = min(judged_orbits, key=lambda one: (not one.runs, not one.orbit.admissible), default=None)
        shown = _Motions(str(answer.system), answer.system, (PeriodAnswer(answer, judged_orbits),), chosen)
    else:
        having("answer", answer, ("system", "periods", "running"), "what percuss.case.steady_answer gives")
        shown = _Motions(answer.title, answer.system, answer.periods, answer.chosen, answer.measured, answer.tool)
    units = units_of(shown.system)
    if not shown.system.body.is_free:
        return _of_structure(shown, units)
    with canvas(11.0, 7.0, shown.title) as figure:
        grid = figure.add_gridspec(2, 3)
        _phases(figure.add_subplot(grid[0, 0]), shown)
        load, left = measured_panels(figure, grid[0, 1], shown.measured)
        _load(load, shown, units)
        if shown.measured is not None and left is not None:
            draw_measured(load, left, shown.measured, 2.0 * math.pi, units)
        _gap(figure.add_subplot(grid[0, 2]), shown, units)
        _multipliers(figure.add_subplot(grid[1, 0]), shown)
        _waves(figure, figure.add_subplot(grid[1, 1:]), shown, units)
        _laws(figure, shown)
    return figure


def _of_structure(shown: _Motions, units: Units) -> Figure:
    with canvas(11.0, 4.0, shown.title) as figure:
        load, contact, multipliers = figure.subplots(1, 3)
        _load(load, shown, units)
        _gap(contact, shown, units)
        _multipliers(multipliers, shown)
        contact.set_ylabel("contact from the wall" + (" [mm]" if shown.system.is_si else " [dimensionless]"))
        load.set_title("(a) load, with the moments of impact")
        contact.set_title("(b) the contact between two impacts")
        multipliers.set_title("(c) multipliers: stable inside the circle")
        _laws(figure, shown)
    return figure


def _laws(figure: Figure, answer: _Motions) -> None:
    """What the motions rest on, in small print: the law of the contact and that of the damping."""
    system = answer.system
    engine = figure.get_layout_engine()
    assert engine is not None
    low = 0.16 / figure.get_figheight()
    engine.set(rect=(0.0, low, 1.0, 1.0 - low))  # type: ignore[call-arg]  # of the constrained layout
    damping = f"; damping: {system.body.damping.words}" if system.body.is_free else ""
    text = f"{system.contact.sentence}{damping}"
    figure.text(0.99, 0.004, text, ha="right", va="bottom", fontsize=6.5, color=INK)


def _marker(found: OrbitAnswer, colour: str) -> dict[str, Any]:
    """Solid: stable; open: unstable; cross: cannot happen."""
    if not found.orbit.admissible:
        return {"marker": "x", "markersize": 7, "color": colour, "markeredgewidth": 1.8}
    fill = colour if found.stability.stable else "white"
    return {"marker": "o", "markersize": 7, "color": colour, "markerfacecolor": fill, "markeredgewidth": 1.6}


def _phases(axes: Any, answer: _Motions) -> None:
    phases = np.linspace(0.0, 2.0 * math.pi, POINTS)
    curve = answer.periods[0].states.rigid_velocity(phases)
    axes.plot(phases, curve, color=INK)
    low, high = _limits(curve, [period.states.level for period in answer.periods])
    beyond = []
    for i, period in enumerate(answer.periods):
        colour = _colour(i)
        level = period.states.level
        if not low < level < high:
            beyond.append(str(period.states.periods))
            continue
        label = f"level, m = {period.states.periods}" if len(answer.periods) <= 6 else None
        axes.axhline(level, color=colour, linestyle="--", linewidth=1.1, label=label)
        for found in period.orbits:
            axes.plot([found.orbit.phase], [level], clip_on=False, zorder=3, **_marker(found, colour))
    if beyond:
        axes.plot([], [], " ", label=f"m = {', '.join(beyond[:6])}{', …' * (len(beyond) > 6)}: far above")
    other = _timed_marks(axes, answer, phases)
    axes.set(title=other or "(a) impact phases: where $v_f$ meets the level", ylabel="$v_f$ [dimensionless]")
    phase_axis(axes)
    for text, key in (("stable", {"markerfacecolor": INK}), ("unstable", {"markerfacecolor": "white"})):
        axes.plot([], [], "o", color=INK, label=text, **key)
    axes.plot([], [], "x", color=INK, label="not possible")
    rows = (len(axes.get_legend_handles_labels()[0]) + 1) // 2
    axes.set_ylim(low - 0.09 * rows * (high - low), high)  # room below the curve, where nothing is drawn
    axes.legend(loc="lower center", ncols=2)


def _limits(curve: Any, levels: list[float]) -> tuple[float, float]:
    """Limits that show the curve whole and those levels that are not far off."""
    low, high = float(np.min(curve)), float(np.max(curve))
    span = (high - low) or 1.0
    near = [level for level in levels if low - span < level < high + span]
    low, high = min([low, *near]), max([high, *near])
    return low - 0.1 * span, high + 0.1 * span


def _load(axes: Any, answer: _Motions, units: Units) -> None:
    load = answer.system.load
    phases, values = _load_curve(answer)
    axes.plot(phases, values * units.force, color=INK)
    axes.axhline(0.0, color=INK, linewidth=0.6)
    shown = answer.coloured
    banded = bool(shown) and answer.system.body.is_free
    if banded:
        band = shown[0][1].stability.waveform
        lower, upper = band.force_lower * units.force, band.force_upper * units.force
        axes.axhspan(lower, upper, color=COLOURS[2], alpha=0.15, linewidth=0, label="stable if the blow falls here")
    for colour, found in shown:
        force = float(load.value(found.orbit.phase)) * units.force
        axes.plot([found.orbit.phase], [force], clip_on=False, zorder=3, **_marker(found, colour))
    axes.set(title="(b) load, with the moments of impact", ylabel=units.force_label)
    phase_axis(axes)
    if banded:
        axes.legend(loc="best")


def _load_curve(answer: _Motions) -> tuple[Any, Any]:
    load = answer.system.load
    phases = np.linspace(0.0, 2.0 * math.pi, POINTS)
    values = load.value(phases)
    edges = np.array([jump.phase for jump in load.jumps])
    if edges.size:
        both = [value for jump in load.jumps for value in (jump.before, jump.after)]
        phases = np.concatenate([phases, np.repeat(edges, 2)])
        values = np.concatenate([values, both])
        order = np.argsort(phases, kind="stable")
        phases, values = phases[order], values[order]
    return phases, values


def _gap(axes: Any, answer: _Motions, units: Units) -> None:
    axes.set(title="(c) the striking end between two blows", xlabel=units.time_label, ylabel=units.length_label)
    shown = answer.coloured
    for colour, found in shown:
        t = np.linspace(0.0, found.orbit.period, POINTS * found.orbit.periods)
        line = "-" if found.runs else (0, (4, 2)) if found.orbit.admissible else ":"
        label = f"φ = {found.orbit.phase:.3f}{_timed_phase(answer, found.orbit)}" if len(shown) <= 8 else None
        axes.plot(t * units.time, found.orbit.motion(t) * units.length, color=colour, linestyle=line, label=label)
    if not shown:
        _none(axes)
        return
    wall(axes, answer.tool)
    axes.set_xlim(left=0.0)
    axes.margins(y=0.12)
    if len(shown) <= 8:
        low, high = axes.get_ylim()  # room below the curves, where nothing is drawn
        axes.set_ylim(low - 0.06 * ((len(shown) + 1) // 2) * (high - low), high)
        axes.legend(loc="lower center", ncols=2)


def _multipliers(axes: Any, answer: _Motions) -> None:
    circle = np.exp(1j * np.linspace(0.0, 2.0 * math.pi, 361))
    axes.fill(circle.real, circle.imag, color=COLOURS[2], alpha=0.12, linewidth=0)
    axes.plot(circle.real, circle.imag, color=INK, linewidth=0.9)
    axes.axhline(0.0, color=INK, linewidth=0.4)
    axes.axvline(0.0, color=INK, linewidth=0.4)
    axes.set_title("(d) multipliers: stable inside the circle")
    axes.set_aspect("equal")
    axes.set_xlim(-EDGE, EDGE)
    axes.set_ylim(-EDGE, EDGE)
    axes.set(xlabel="real part", ylabel="imaginary part")
    beyond: list[tuple[complex, str]] = []
    for colour, found in answer.coloured:
        values = np.asarray(found.stability.multipliers.values)
        size = np.maximum(np.abs(values.real), np.abs(values.imag))
        inside, outside = values[size < EDGE], values[size >= EDGE]
        fill = colour if found.stability.stable else "none"
        axes.scatter(inside.real, inside.imag, s=16, facecolors=fill, edgecolors=colour, linewidths=0.9)
        beyond += [(complex(value), colour) for value in outside]
    _far_off(axes, beyond)
    if not answer.coloured:
        axes.text(0.0, 0.3, "no steady motion", ha="center", color=INK)


def _far_off(axes: Any, values: list[tuple[complex, str]]) -> None:
    """An arrow at the edge of the panel, with the modulus, for every multiplier that lies beyond it."""
    heights: dict[int, int] = {}  # labels on one side are stacked
    for value, colour in values:
        edge = value * EDGE / max(abs(value.real), abs(value.imag))
        side = round(2.0 * math.atan2(edge.imag, edge.real) / math.pi) % 4
        heights[side] = heights.get(side, 0) + 1
        at = (0.78 * edge.real, 0.78 * edge.imag + 0.14 * heights[side])
        arrow = {"arrowstyle": "->", "color": colour, "linewidth": 0.9}
        text = f"{abs(value):.3g}"
        axes.annotate(text, (edge.real, edge.imag), at, color=colour, fontsize=7.5, ha="center", arrowprops=arrow)


def _waves(figure: Figure, axes: Any, answer: _Motions, units: Units) -> None:
    chosen = answer.chosen
    if chosen is None:
        axes.set_title("(e) waves in the bar")
        _none(axes)
        return
    orbit = chosen.orbit
    what = units.stress_label.split(" [")[0]
    peak = "" if chosen.si is None else f", {chosen.si.peak_stress_MPa:.0f} MPa at first contact,"
    title = f"(e) {what} along the bar between two blows, φ = {orbit.phase:.3f}"
    axes.set_title(f"{title}\nthe {what} of the blow itself{peak} is not in it")
    strain = orbit.strain(np.linspace(0.0, 1.0, 101), np.linspace(0.0, orbit.period, 600))
    draw_waves(figure, axes, answer.system, strain, (0.0, orbit.period * units.time), units)
    axes.set_xlabel(units.time_label)


def _none(axes: Any) -> None:
    axes.set(xticks=[], yticks=[])
    nothing(axes, "no steady motion")
