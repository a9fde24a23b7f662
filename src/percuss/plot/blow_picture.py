"""The picture of one blow: force at the face, waves at the gauge, the x–t diagram, where the energy goes, stresses."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from percuss import palette
from percuss.model.checks import Array, having
from percuss.plot.canvas import COLOURS, INK, new_figure, ramp, style, titled

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from percuss.blow import AlongBody, Blow, Peak, Rod, StringState, Waves
    from percuss.model.body.sized import Piece

__all__ = ["ShownBlow", "blow"]

_TIMES, _PLACES = 400, 300
_SHOWN = 6.0
"""Transit times of the striker after the last contact that curves go on for."""


class ShownBlow(Protocol):
    """What an answer hands to its picture: a blow, a gauge on its rod, sections with their sizes, words for values."""

    @property
    def title(self) -> str: ...
    @property
    def blow(self) -> Blow: ...
    @property
    def gauge(self) -> float | None: ...
    @property
    def is_si(self) -> bool: ...
    @property
    def waves(self) -> Waves | None: ...
    @property
    def rod(self) -> Rod | None: ...
    @property
    def pieces(self) -> tuple[tuple[Piece, ...], tuple[Piece, ...]]: ...
    @property
    def peaks(self) -> tuple[tuple[Peak, ...], tuple[Peak, ...]]: ...
    @property
    def units(self) -> Any: ...
    @property
    def measured(self) -> Any: ...


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
    figure = new_figure(11.0, 10.0)
    with style():
        grid = figure.add_gridspec(3, 2)
        _face(figure.add_subplot(grid[0, 0]), answer)
        _gauge(figure.add_subplot(grid[0, 1]), answer)
        _lagrange(figure, figure.add_subplot(grid[1, :]), answer)
        right = figure.add_subplot(grid[2, 1])
        if answer.blow.penetration is not None:
            lower = grid[2, 0].subgridspec(1, 2)
            _loop(figure.add_subplot(lower[0]), answer)
            _energy(figure.add_subplot(lower[1]), answer)
        else:
            _energy(figure.add_subplot(grid[2, 0]), answer)
        _envelope(right, answer)
        titled(figure, answer.title)
    return figure


def _last(answer: ShownBlow) -> float:
    """The time that pictures end with: some transits after the last contact, or the end of the window."""
    from percuss.blow.striker import striker_sections

    sections, contacts = striker_sections(answer.blow.striker), answer.blow.contacts
    over = 0.0 if not contacts else contacts[-1].end or answer.blow.until
    return min(answer.blow.until, over + _SHOWN * float(sections.transit.sum()))


def _scales(answer: ShownBlow) -> tuple[tuple[float, str], tuple[float, str]]:
    """Factor and label of times and of forces."""
    if not answer.is_si:
        return (1.0, "time [rad]"), (1.0, "force")
    return (1e6, "time [µs]"), (1e-3, "force [kN]")


def _face(axes: Any, answer: ShownBlow) -> None:
    (clock, time), (scale, force) = _scales(answer)
    times, values = answer.blow.face_force.sampled(2000)
    axes.fill_between(times * clock, values * scale, color=COLOURS[0], alpha=0.15, linewidth=0.0)
    axes.plot(times * clock, values * scale, color=COLOURS[0])
    if answer.blow.bit_force is not None:
        times, values = answer.blow.bit_force.sampled(2000)
        axes.plot(times * clock, values * scale, color=COLOURS[1], label="on the rock")
        axes.plot([], [], color=COLOURS[0], label="at the face")
        axes.legend(loc="upper right")
    _window(axes, answer, time)
    axes.set_ylabel(force)
    axes.set_title("(a) force between the faces" + (" and on the rock" if answer.blow.bit_force is not None else ""))


def _window(axes: Any, answer: ShownBlow, label: str) -> None:
    axes.set_xlim(0.0, _last(answer) * _scales(answer)[0][0])
    axes.set_ylim(bottom=min(0.0, axes.get_ylim()[0]))
    axes.axhline(0.0, color=INK, linewidth=0.6)
    axes.set_xlabel(label)


def _gauge(axes: Any, answer: ShownBlow) -> None:
    (clock, time), (scale, force) = _scales(answer)
    waves = answer.waves
    if waves is None:
        axes.set_axis_off()
        axes.text(0.5, 0.5, "no rod to put a gauge on: the target is a wall", ha="center", transform=axes.transAxes)
        return
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
    axes.legend(loc="upper right")
    _window(axes, answer, time)
    axes.set_ylabel(force)
    place = "" if answer.gauge is None else f", {answer.units.place(answer.gauge)} from the face"
    axes.set_title(f"(b) at the gauge{place}")


# -- x–t diagram -------------------------------------------------------------------------------------------------------


def _lagrange(figure: Any, axes: Any, answer: ShownBlow) -> None:
    from matplotlib.colors import TwoSlopeNorm

    clock, time = _scales(answer)[0]
    last = _last(answer)
    times = np.linspace(0.0, last, _TIMES)
    states = [answer.blow.state_at(float(t)) for t in times]
    own, rod = _lengths(answer, states)
    shown = min(rod, 4.0 * own) if _endless(answer) else rod
    places = np.concatenate([np.linspace(-own, 0.0, _PLACES, endpoint=False), np.linspace(0.0, shown, _PLACES)])
    stress = np.array([_stress_along(answer, state, places, own) for state in states])
    scale = 1e-6 if answer.is_si else 1.0
    top = float(abs(stress).max()) * scale or 1.0
    image = axes.pcolormesh(
        places, times * clock, stress * scale, cmap=ramp(palette.STRAIN), norm=TwoSlopeNorm(0.0, -top, top),
        rasterized=True, shading="auto",
    )  # fmt: skip
    axes.axvline(0.0, color=INK, linewidth=1.0)
    for step in _steps(answer, own):
        if -own < step < shown:
            axes.axvline(step, color=INK, linewidth=0.4, linestyle=":")
    bar = figure.colorbar(image, ax=axes, fraction=0.03, pad=0.01)
    bar.set_label(f"stress [MPa], {palette.SIGN}" if answer.is_si else f"force, {palette.SIGN}")
    axes.set_xlabel("place from the struck face [m]" if answer.is_si else "place from the struck face")
    axes.set_ylabel(time)
    axes.set_title("(c) waves in the striker (left of the face) and in what it strikes")


def _endless(answer: ShownBlow) -> bool:
    return answer.rod is not None and answer.rod.end == "infinite"


def _lengths(answer: ShownBlow, states: list[StringState]) -> tuple[float, float]:
    """Length of the striker, and of the rod as far as waves have come."""
    own = max(float(state.striker.places[-1]) for state in states)
    rods = [float(state.rod.places[-1]) for state in states if state.rod is not None and state.rod.places.size]
    return own, max(rods, default=0.0)


def _steps(answer: ShownBlow, own: float) -> list[float]:
    """Where sections meet, from the struck face."""
    pieces, rod = answer.pieces
    return [piece.end - own for piece in pieces[:-1]] + [piece.end for piece in rod[:-1]]


def _stress_along(answer: ShownBlow, state: StringState, places: Array, own: float) -> Array:
    """Stress (force of a dimensionless bar) at places from the struck face, tension positive."""
    left = places < 0.0
    found = np.zeros(places.size)
    found[left] = _values(state.striker, places[left] + own, _areas(answer, 0))
    if state.rod is not None:
        found[~left] = _values(state.rod, places[~left], _areas(answer, 1))
    return -found


def _areas(answer: ShownBlow, which: int) -> Array:
    pieces = answer.pieces[which]
    return np.array([piece.area for piece in pieces]) if pieces else np.ones(1000)


def _values(along: AlongBody, places: Array, areas: Array) -> Array:
    """Stress at places along a body; nothing where no wave has come."""
    if not along.places.size:
        return np.zeros(places.size)
    values = along.force / areas[along.section]
    return np.asarray(np.interp(places, along.places, values, left=0.0, right=0.0))


# -- energy, rock, stresses --------------------------------------------------------------------------------------------


def _energy(axes: Any, answer: ShownBlow) -> None:
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
    axes.set_title("(e) where the energy went" if blow.penetration is not None else "(d) where the energy went")


def _loop(axes: Any, answer: ShownBlow) -> None:
    blow = answer.blow
    assert blow.penetration is not None and blow.bit_force is not None
    times = np.unique(np.concatenate([blow.penetration.times, np.linspace(0.0, blow.until, 4000)]))
    scales = (1e3, 1e-3) if answer.is_si else (1.0, 1.0)
    axes.plot(blow.penetration.at(times) * scales[0], blow.bit_force.at(times) * scales[1], color=COLOURS[1])
    axes.axhline(0.0, color=INK, linewidth=0.6)
    axes.set_xlabel("penetration [mm]" if answer.is_si else "penetration")
    axes.set_ylabel("force [kN]" if answer.is_si else "force")
    axes.set_title("(d) the rock")


def _envelope(axes: Any, answer: ShownBlow) -> None:
    own, rod = answer.peaks
    scale = 1e-6 if answer.is_si else 1.0
    edges = _edges(answer)
    for peaks, ends in zip((own, rod), edges, strict=True):
        if not peaks:
            continue
        for values, colour, name in (
            ([-peak.compression for peak in peaks], palette.STRAIN[1].light, "compression"),
            ([peak.tension for peak in peaks], palette.STRAIN[-2].light, "tension"),
        ):
            label = name if peaks is own else None
            axes.stairs(np.array(values) * scale, ends, color=colour, fill=True, alpha=0.55, label=label)
    axes.axvline(0.0, color=INK, linewidth=1.0)
    axes.axhline(0.0, color=INK, linewidth=0.6)
    axes.legend(loc="center right")
    axes.set_xlabel("place from the struck face [m]" if answer.is_si else "section")
    axes.set_ylabel("stress [MPa]" if answer.is_si else "force")
    mark = "(f)" if answer.blow.penetration is not None else "(e)"
    axes.set_title(f"{mark} greatest stress in each section" if answer.is_si else f"{mark} greatest force")


def _edges(answer: ShownBlow) -> tuple[Array, Array]:
    """Where the sections of striker and rod begin and end, from the struck face."""
    from percuss.blow.striker import striker_sections

    rod = answer.peaks[1]
    length = striker_sections(answer.blow.striker).length
    ends = np.append(0.0, np.cumsum(length)) - length.sum()
    if not rod:
        return ends, np.zeros(1)
    pieces = answer.pieces[1]
    known = [piece.end - piece.start for piece in pieces] if pieces else [float("inf")]
    widths = np.array([width if np.isfinite(width) else 2.0 * float(length.sum()) for width in known])
    return ends, np.append(0.0, np.cumsum(widths))
