"""The picture of one blow: forces, waves over place and time, greatest stresses, the rock, where the energy goes."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from percuss.model.checks import having
from percuss.plot.blow_along import greatest_stresses, waves_along
from percuss.plot.canvas import COLOURS, INK, legend_above, new_figure, style, titled

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from percuss.plot.shown_blow import ShownBlow

__all__ = ["blow"]

_SHOWN = 3.0
"""Transit times of the striker after the last force that curves go on for."""
_FELT = 1e-3
"""Share of its peak that counts as a force on the rock."""


def blow(answer: ShownBlow) -> Figure:
    """Draw one blow.

    Parameters
    ----------
    answer
        What `percuss.case.blow_answer` gives.

    Raises
    ------
    ParameterError
        For anything else.
    MissingExtraError
        When matplotlib is not installed.
    """
    having("answer", answer, ("title", "blow", "gauge", "units"), "the answer of percuss.case.blow_answer")
    beside, below = (_energy, []) if answer.rod is None else (_gauge, [_energy])
    below = ([_efficiency] if answer.beta is not None else []) + below
    below = ([_loop] if answer.blow.penetration is not None else []) + below
    figure = new_figure(11.0, 12.5 if below else 9.5)
    with style():
        grid = figure.add_gridspec(4 if below else 3, 2)
        _face(figure.add_subplot(grid[0, 0]), answer, "(a)")
        beside(figure.add_subplot(grid[0, 1]), answer, "(b)")
        waves = figure.add_subplot(grid[1, :])
        waves_along(figure, waves, answer, _last(answer), "(c)")
        greatest_stresses(figure.add_subplot(grid[2, :], sharex=waves), answer, "(d)")
        if below:
            lower = grid[3, :].subgridspec(1, len(below))
            for i, draw in enumerate(below):
                draw(figure.add_subplot(lower[i]), answer, f"({'efg'[i]})")
        titled(figure, answer.title)
    return figure


def _last(answer: ShownBlow) -> float:
    """The time at which pictures end: some transits after the last force at face or rock, or the end of the window."""
    from percuss.blow.striker import striker_sections

    sections, contacts, rock = striker_sections(answer.blow.striker), answer.blow.contacts, answer.blow.bit_force
    over = 0.0 if not contacts else contacts[-1].end or answer.blow.until
    if rock is not None:
        felt = np.flatnonzero(rock.piece_peaks > _FELT * rock.peak)
        over = max(over, float(rock.times[felt[-1] + 1]) if felt.size else 0.0)
    return min(answer.blow.until, over + _SHOWN * float(sections.transit.sum()))


def _scales(answer: ShownBlow) -> tuple[tuple[float, str], tuple[float, str]]:
    """Factor and label of times and of forces."""
    if not answer.is_si:
        return (1.0, "time [rad]"), (1.0, "force")
    return (1e6, "time [µs]"), (1e-3, "force [kN]")


def _face(axes: Any, answer: ShownBlow, mark: str) -> None:
    (clock, time), (scale, force) = _scales(answer)
    times, values = answer.blow.face_force.sampled(2000)
    axes.fill_between(times * clock, values * scale, color=COLOURS[0], alpha=0.15, linewidth=0.0)
    axes.plot(times * clock, values * scale, color=COLOURS[0])
    if answer.blow.bit_force is not None:
        times, values = answer.blow.bit_force.sampled(2000)
        axes.plot(times * clock, values * scale, color=COLOURS[1], label="on the rock")
        axes.plot([], [], color=COLOURS[0], label="at the face")
        legend_above(axes)
    _window(axes, answer, time)
    axes.set_ylabel(force)
    axes.set_title(f"{mark} force between the faces" if answer.blow.bit_force is None else f"{mark} forces")


def _window(axes: Any, answer: ShownBlow, label: str) -> None:
    axes.set_xlim(0.0, _last(answer) * _scales(answer)[0][0])
    axes.set_ylim(bottom=min(0.0, axes.get_ylim()[0]))
    axes.axhline(0.0, color=INK, linewidth=0.6)
    axes.set_xlabel(label)


def _gauge(axes: Any, answer: ShownBlow, mark: str) -> None:
    (clock, time), (scale, force) = _scales(answer)
    waves = answer.waves
    assert waves is not None  # there is a rod
    times = np.unique(
        np.concatenate([waves.incident.times, waves.reflected.times, np.linspace(0, _last(answer), 2000)])
    )
    inside = np.repeat(times, 2)
    one = np.stack([waves.incident.before(times), waves.incident.at(times)], axis=1).ravel()
    two = np.stack([waves.reflected.before(times), waves.reflected.at(times)], axis=1).ravel()
    axes.plot(inside * clock, (one + two) * scale, color=COLOURS[0], label="force F")
    axes.plot(inside * clock, (one - two) * scale, color=COLOURS[1], linestyle="--", label="Z · velocity")
    if answer.measured is not None:
        seen = (answer.measured.time >= 0.0) & (answer.measured.time <= _last(answer))
        record = answer.measured.time[seen] * clock, answer.measured.force[seen] * scale
        axes.plot(*record, color=INK, linewidth=0.9, label="measured")
    legend_above(axes)
    _window(axes, answer, time)
    axes.set_ylabel(force)
    place = "" if answer.gauge is None else f" at {answer.units.place(answer.gauge)}"
    axes.set_title(f"{mark} gauge{place}")


# -- energy and rock ---------------------------------------------------------------------------------------------------


def _energy(axes: Any, answer: ShownBlow, mark: str) -> None:
    blow = answer.blow
    parts = [("with the striker", blow.rigid_energy_after), ("ringing in it", blow.vibration_energy_after)]
    if answer.rod is not None:
        parts.append(("in the rod", blow.rod_energy + blow.bit_kinetic_energy_after))
    if blow.penetration is not None:
        parts += [("rock, for good", blow.rock_dissipated), ("rock, springs back", blow.rock_stored)]
    names, values = [name for name, _ in parts][::-1], [value for _, value in parts][::-1]
    before = blow.energy_before + max(blow.load_work, 0.0) or 1.0
    axes.barh(names, [100.0 * value / before for value in values], color=COLOURS[2], alpha=0.8)
    for i, value in enumerate(values):
        axes.text(100.0 * value / before + 1.0, i, answer.units.energy(value, 3), va="center", fontsize=7.5)
    axes.set_xlim(0.0, 1.3 * max(100.0 * value / before for value in values) + 1.0)
    axes.set_xlabel("share of the energy before [%]")
    axes.set_title(f"{mark} where the energy went")


def _loop(axes: Any, answer: ShownBlow, mark: str) -> None:
    blow = answer.blow
    assert blow.penetration is not None and blow.bit_force is not None
    times = np.unique(np.concatenate([blow.penetration.times, np.linspace(0.0, blow.until, 4000)]))
    scales = (1e3, 1e-3) if answer.is_si else (1.0, 1.0)
    axes.plot(blow.penetration.at(times) * scales[0], blow.bit_force.at(times) * scales[1], color=COLOURS[1])
    axes.axhline(0.0, color=INK, linewidth=0.6)
    axes.set_xlabel("penetration [mm]" if answer.is_si else "penetration")
    axes.set_ylabel("force [kN]" if answer.is_si else "force")
    axes.set_title(f"{mark} the rock")


def _efficiency(axes: Any, answer: ShownBlow, mark: str) -> None:
    """The blow beside one rectangular wave on the same rock, and the best wave (Lundberg 1973)."""
    from percuss.blow.closed_forms import best_efficiency, matched_efficiency

    beta, rod = answer.beta, answer.rod
    assert beta is not None and rod is not None and rod.rock is not None
    gamma = rod.rock.unloading_ratio
    places = np.linspace(0.02, max(4.0, 1.5 * beta), 200)
    axes.plot(
        places, [100.0 * matched_efficiency(x, gamma) for x in places], color=COLOURS[0], label="rectangular wave"
    )
    axes.plot(places, [100.0 * best_efficiency(x, gamma) for x in places], color=COLOURS[0], linestyle=":",
              label="best wave")  # fmt: skip
    share = 100.0 * answer.blow.rock_dissipated / answer.blow.energy_before
    axes.plot(beta, share, "o", color=COLOURS[1], label="this blow, all its waves")
    axes.legend(loc="lower right")
    axes.set_ylim(bottom=0.0)
    axes.set_xlabel("β = K₁T/Z of the first pulse")
    axes.set_ylabel("kept by the rock [%]")
    axes.set_title(f"{mark} efficiency")
