"""The picture of one blow: forces, waves over place and time, greatest stresses, the rock, where the energy goes."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from percuss import palette
from percuss.model.checks import Array, having
from percuss.plot.canvas import COLOURS, INK, Units, canvas, legend_above, ramp

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from percuss.blow.bodies import Sections
    from percuss.case.answers.blows.blow_answer import BlowAnswer
    from percuss.case.answers.blows.repeated_answer import RepeatedAnswer
    from percuss.case.answers.blows.valve_waves_answer import ValveWavesAnswer
    from percuss.case.answers.blows.waves_answer import WavesAnswer
    from percuss.case.answers.exploring.best_answer import BestAnswer


_PLACE = "place from the struck face"
_PLAIN = Units("time [rad]", "force", _PLACE, "velocity", "force")
_SI = Units("time [µs]", "force [kN]", f"{_PLACE} [m]", "velocity [m/s]", "stress [MPa]", 1e6, 1e-3, stress=1e-6)


def _axes_of(answer: BlowAnswer) -> Units:
    return _SI if answer.is_si else _PLAIN


# ---- What happens along striker and rod in a blow: the waves over place and time, and the greatest stresses

_TIMES, _CELLS = 400, 300
_REACH = 4.0  # of an endless rod: lengths of the striker that are shown


def waves_along(figure: Any, axes: Any, answer: BlowAnswer, last: float, mark: str) -> None:
    """The stress over place and time."""
    from matplotlib.colors import TwoSlopeNorm

    scales = _axes_of(answer)
    edges = np.linspace(0.0, last, _TIMES + 1)
    own, rod = answer.blow.cells_over_time(0.5 * (edges[1:] + edges[:-1]), _CELLS, _reach(answer))
    bodies = [(own.edges - own.edges[-1], own.force / _areas(answer, 0)[own.section])]
    if rod is not None:
        bodies.append((rod.edges, rod.force / _areas(answer, 1)[rod.section]))
    top = max(float(abs(stress).max()) for _, stress in bodies) * scales.stress or 1.0
    for places, stress in bodies:
        image = axes.pcolormesh(
            places, edges * scales.time, -scales.stress * stress, cmap=ramp(palette.STRAIN),
            norm=TwoSlopeNorm(0.0, -top, top), rasterized=True,
        )  # fmt: skip
    _draw_steps(axes, answer)
    axes.set_xlim(bodies[0][0][0], bodies[-1][0][-1])
    bar = figure.colorbar(image, ax=axes, fraction=0.03, pad=0.01)
    bar.set_label(f"{scales.stress_label}, {palette.SIGN}")
    title = f"{mark} waves in the striker (left of the face) and in what it strikes"
    axes.set(ylabel=scales.time_label, xlabel=scales.length_label, title=title)


def greatest_stresses(axes: Any, answer: BlowAnswer, mark: str) -> None:
    """The greatest compression and tension at every place, with the exact ones of the sections as dots."""
    scales = _axes_of(answer)
    bodies = [body for body in answer.blow.force_envelope(_CELLS, _reach(answer)) if body is not None]
    kinds = (
        ("compression", -scales.stress, palette.STRAIN[1].light),
        ("tension", scales.stress, palette.STRAIN[-2].light),
    )
    for which, body in enumerate(bodies):
        start = -float(body.edges[-1]) if which == 0 else 0.0
        area = _areas(answer, which)
        for name, sign, colour in kinds:
            values = sign * getattr(body, name) / area[body.section]
            axes.stairs(values, body.edges + start, color=colour, fill=True, alpha=0.55,
                        label=name if which == 0 else None)  # fmt: skip
            for peak in answer.peaks[which]:
                place = getattr(peak, f"{name}_place")
                if place is not None:
                    axes.plot(place + start, sign * getattr(peak, name), ".", color=INK, markersize=4.0)
    _draw_steps(axes, answer)
    axes.axhline(0.0, color=INK, linewidth=0.6)
    axes.plot([], [], ".", color=INK, markersize=4.0, label="greatest of a section")
    legend_above(axes)
    title = f"{mark} greatest {scales.stress_label.partition(' ')[0]} at each place"
    axes.set(xlabel=scales.length_label, ylabel=scales.stress_label, title=title)


_SAFE = 10.0  # safety factors beyond which nobody asks


def fatigue_along(axes: Any, answer: BlowAnswer, mark: str) -> None:
    """The safety factor at places of striker and rod, and where it governs."""
    fatigue = answer.fatigue
    assert fatigue is not None
    start = {"striker": -float(_striker(answer).length.sum()), "rod": 0.0}
    for i, one in enumerate(fatigue.fatigue.sections):
        places, factors = one.places + start[one.body], one.factors
        if places.size == 1:  # endless
            places, factors = np.array([places[0], places[0] + _reach(answer)]), np.repeat(factors, 2)
        axes.plot(places, np.minimum(factors, _SAFE), ".-", color=COLOURS[0], markersize=3.5,
                  label="at the places looked at" if i == 0 else None)  # fmt: skip
    worst = fatigue.governing.fatigue
    where = worst.place + start[worst.body]
    axes.plot(
        where, min(worst.factor, _SAFE), "o", color=COLOURS[1], label=f"governs: {worst.name}, {worst.factor:.3g}"
    )
    low = 0.8 * min(1.0, worst.factor)
    axes.axhspan(0.0, 1.0, color=COLOURS[1], alpha=0.1, linewidth=0.0, label="cycles above the fatigue limit")
    _draw_steps(axes, answer)
    axes.set_yscale("log")
    ticks = [tick for tick in (0.1, 0.2, 0.5, 1.0, 2.0, 5.0, _SAFE) if tick >= low]
    axes.set_yticks(ticks, [f"{tick:g}" for tick in ticks])
    axes.minorticks_off()
    axes.set_ylim(low, _SAFE)
    legend_above(axes)
    axes.set(xlabel=_SI.length_label, ylabel="safety factor", title=f"{mark} fatigue")


def _striker(answer: BlowAnswer) -> Sections:
    from percuss.blow.bodies import striker_sections

    return striker_sections(answer.blow.striker)


def _reach(answer: BlowAnswer) -> float:
    """How far an endless rod is shown: m, or times of a wave."""
    sections = _striker(answer)
    return _REACH * float((sections.length if answer.is_si else sections.transit).sum())


def _lengths(answer: BlowAnswer) -> tuple[Array, Array]:
    """Of the sections of striker and rod."""
    from percuss.blow.bodies import rod_sections

    rod = answer.rod
    return _striker(answer).length, np.zeros(0) if rod is None else rod_sections(rod, answer.blow.striker).length


def _draw_steps(axes: Any, answer: BlowAnswer) -> None:
    """Where sections meet, and the struck face."""
    own, rod = _lengths(answer)
    for step in (*(np.cumsum(own)[:-1] - own.sum()).tolist(), *np.cumsum(rod)[:-1].tolist()):
        axes.axvline(step, color=INK, linewidth=0.4, linestyle=":")
    axes.axvline(0.0, color=INK, linewidth=1.0)


def _areas(answer: BlowAnswer, which: int) -> Array:
    """Of the sections of striker or rod; 1 where they are not known, so that stresses are forces."""
    pieces = answer.pieces[which]
    return np.array([piece.area for piece in pieces]) if pieces else np.ones(_lengths(answer)[which].size)


# ---- The picture of one blow: forces, waves over place and time, greatest stresses, the rock, where the energy goes

_SHOWN = 3.0  # transit times of the striker after the last force that curves go on for
_FELT = 1e-3  # share of its peak that counts as a force on the rock


def blow(answer: BlowAnswer) -> Figure:
    """Draw one blow."""
    having("answer", answer, ("title", "blow", "gauge", "peaks"), "the answer of percuss.case.blow_answer")
    beside, below = (_energy, []) if answer.rod is None else (_gauge, [_energy])
    below = ([_efficiency] if answer.beta is not None else []) + below
    below = ([_loop] if answer.blow.penetration is not None else []) + below
    rows = 3 + (answer.fatigue is not None) + bool(below)
    with canvas(11.0, 3.0 * rows + 0.5, answer.title) as figure:
        grid = figure.add_gridspec(rows, 2)
        _face(figure.add_subplot(grid[0, 0]), answer, "(a)")
        beside(figure.add_subplot(grid[0, 1]), answer, "(b)")
        waves = figure.add_subplot(grid[1, :])
        waves_along(figure, waves, answer, _last(answer), "(c)")
        greatest_stresses(figure.add_subplot(grid[2, :], sharex=waves), answer, "(d)")
        if answer.fatigue is not None:
            fatigue_along(figure.add_subplot(grid[3, :], sharex=waves), answer, "(e)")
        if below:
            lower = grid[rows - 1, :].subgridspec(1, len(below))
            for i, draw in enumerate(below):
                draw(figure.add_subplot(lower[i]), answer, f"({'efgh'[rows - 4 + i]})")
    return figure


def _last(answer: BlowAnswer) -> float:
    """The time at which pictures end: some transits after the last force at face or rock, or the end of the window."""
    sections, contacts, rock = _striker(answer), answer.blow.contacts, answer.blow.bit_force
    over = 0.0 if not contacts else contacts[-1].end or answer.blow.until
    if rock is not None:
        felt = np.flatnonzero(rock.piece_peaks > _FELT * rock.peak)
        over = max(over, float(rock.times[felt[-1] + 1]) if felt.size else 0.0)
    return min(answer.blow.until, over + _SHOWN * float(sections.transit.sum()))


def _face(axes: Any, answer: BlowAnswer, mark: str) -> None:
    scales = _axes_of(answer)
    clock, scale = scales.time, scales.force
    times, values = answer.blow.face_force.sampled(2000)
    axes.fill_between(times * clock, values * scale, color=COLOURS[0], alpha=0.15, linewidth=0.0)
    axes.plot(times * clock, values * scale, color=COLOURS[0])
    if answer.blow.bit_force is not None:
        times, values = answer.blow.bit_force.sampled(2000)
        axes.plot(times * clock, values * scale, color=COLOURS[1], label="on the rock")
        axes.plot([], [], color=COLOURS[0], label="at the face")
        legend_above(axes)
    _window(axes, answer, scales)
    axes.set_title(f"{mark} force between the faces" if answer.blow.bit_force is None else f"{mark} forces")


def _window(axes: Any, answer: BlowAnswer, scales: Units) -> None:
    axes.set_xlim(0.0, _last(answer) * scales.time)
    axes.set_ylim(bottom=min(0.0, axes.get_ylim()[0]))
    axes.axhline(0.0, color=INK, linewidth=0.6)
    axes.set(xlabel=scales.time_label, ylabel=scales.force_label)


def _gauge(axes: Any, answer: BlowAnswer, mark: str) -> None:
    scales = _axes_of(answer)
    clock, scale = scales.time, scales.force
    waves = answer.waves
    assert waves is not None  # there is a rod
    even = np.linspace(0, _last(answer), 2000)
    times = np.unique(np.concatenate([waves.incident.times, waves.reflected.times, even]))
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
    _window(axes, answer, scales)
    place = "" if answer.gauge is None else f" at {answer.tell(answer.gauge, 'length')}"
    axes.set_title(f"{mark} gauge{place}")


# -- energy and rock ---------------------------------------------------------------------------------------------------


def _energy(axes: Any, answer: BlowAnswer, mark: str) -> None:
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
        axes.text(100.0 * value / before + 1.0, i, answer.tell(value, "energy", 3), va="center", fontsize=7.5)
    axes.set_xlim(0.0, 1.3 * max(100.0 * value / before for value in values) + 1.0)
    axes.set(xlabel="share of the energy before [%]", title=f"{mark} where the energy went")


def _loop(axes: Any, answer: BlowAnswer, mark: str) -> None:
    blow = answer.blow
    assert blow.penetration is not None and blow.bit_force is not None
    times = np.unique(np.concatenate([blow.penetration.times, np.linspace(0.0, blow.until, 4000)]))
    scales, deep = _axes_of(answer), 1e3 if answer.is_si else 1.0
    axes.plot(blow.penetration.at(times) * deep, blow.bit_force.at(times) * scales.force, color=COLOURS[1])
    axes.axhline(0.0, color=INK, linewidth=0.6)
    axes.set(
        xlabel="penetration [mm]" if answer.is_si else "penetration",
        ylabel=scales.force_label,
        title=f"{mark} the rock",
    )


def _efficiency(axes: Any, answer: BlowAnswer, mark: str) -> None:
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
    axes.set(xlabel="β = K₁T/Z of the first pulse", ylabel="kept by the rock [%]", title=f"{mark} efficiency")


# ---- The picture of blows that follow each other: penetration and energy of each, what is left between them, shares


def repeated(answer: RepeatedAnswer) -> Figure:
    """Draw blows that follow each other: of each penetration and energies, what is left in the tool; the shares."""
    having("answer", answer, ("title", "train", "shares"), "the answer of percuss.case.repeated_answer")
    blows = answer.train.blows
    at = np.arange(1, len(blows) + 1)
    first = len(blows) - len(answer.train.settled) + 1

    def figures(name: str, scale: float = 1.0) -> Array:
        return scale * np.array([getattr(blow, name) for blow in blows])

    with canvas(11.0, 7.0, answer.title) as figure:
        grid = figure.add_gridspec(2, 2)
        deep, energy, left = (figure.add_subplot(grid[place]) for place in ((0, 0), (0, 1), (1, 0)))
        for axes, rows, scale in (
            (deep, {"greatest_penetration": "greatest", "advance": "deeper at rest"}, 1e3),
            (energy, {"rock_work": "into the rock", "returned_energy": "with the striker",
                      "recoil_damper_loss": "recoil damper", "steel_loss": "steel", "joint_loss": "joints"}, 1.0),
            (left, {"energy_left": "left in the tool"}, 1.0),
        ):  # fmt: skip
            for (name, label), colour in zip(rows.items(), COLOURS, strict=False):
                axes.plot(at, figures(name, scale), ".-", color=colour, linewidth=0.9, label=label)
            if first > 1:
                axes.axvspan(first - 0.5, at[-1] + 0.5, color=INK, alpha=0.06, linewidth=0.0)
            axes.axhline(0.0, color=INK, linewidth=0.6)
            axes.locator_params(axis="x", integer=True)
            axes.set_xlabel("blow")
        off = ~figures("stands").astype(bool)
        if answer.train.target.rock is not None and off.any():
            left.plot(at[off], figures("energy_left")[off], "o", color=COLOURS[1], fillstyle="none",
                      label="bit off the rock")  # fmt: skip
        legend_above(deep)
        energy.set_ylim(top=1.4 * energy.get_ylim()[1])
        energy.legend(loc="upper right", ncols=2)
        legend_above(left)
        deep.set(ylabel="penetration [mm]", title="(a) penetration")
        energy.set(ylabel="energy [J]", title="(b) where the energy of each blow goes")
        left.set(ylabel="energy [J]", title="(c) before the next blow")
        shares = {name: 100.0 * share for name, share in answer.named_shares}
        axes = figure.add_subplot(grid[1, 1])
        axes.barh(list(shares)[::-1], list(shares.values())[::-1], color=COLOURS[2], alpha=0.8)
        axes.axvline(0.0, color=INK, linewidth=0.6)
        axes.set(xlabel="share of the energy of the striker [%]", title="(d) in the mean over the régime")
    return figure


# ---- The picture of a motion with every contact by waves: speed, rebound, what rock and tool keep, impact by impact


def by_waves(answer: WavesAnswer | ValveWavesAnswer) -> Figure:
    """Draw a motion by waves, impact by impact: speeds, restitution, and where the energy of the blow goes."""
    having("answer", answer, ("title", "motion", "warnings"), "the answer of waves_answer or valve_waves_answer")
    motion: Any = answer.motion
    system = getattr(answer, "system", None)
    own, is_si = motion.impacts, system is None or system.is_si
    if system is None:  # a machine with its own units on the lattice
        speed, energy = motion.units.rate * motion.units.length, motion.units.energy
    else:
        speed, energy = (system.speed_scale, system.energy_scale) if is_si else (1.0, 1.0)
    at = np.arange(1, own.size + 1)
    struck = (
        ("(a) mean velocity of the striker", " [m/s]", "velocity", speed,
         {"before": own.mean_before, "after": own.mean_after}),
        ("(b) restitution", "", "−V after/V before", 1.0, {"": -own.mean_after / own.mean_before}),
        ("(c) energy", " [J]", "energy", energy,
         {"given to what is struck": own.given, "kept by the rock": own.rock_work}
         | ({"left in the tool before": own.energy_left} if own.energy_left.any() else {})),
    )  # fmt: skip
    with canvas(11.0, 7.5, answer.title) as figure:
        for axes, (title, unit, label, scale, rows) in zip(figure.subplots(3, 1, sharex=True), struck, strict=True):
            for (name, values), colour in zip(rows.items(), COLOURS, strict=False):
                axes.plot(at, scale * values, ".-", color=colour, linewidth=0.8, label=name)
            axes.axhline(0.0, color=INK, linewidth=0.6)
            axes.set(ylabel=label + (unit if is_si else ""), title=title)
            if len(rows) > 1:
                legend_above(axes)
        axes.set_xlabel("impact")
        axes.locator_params(axis="x", integer=True)
    return figure


# ---- The picture of a best blow beside that of the case as it is: forces at the face and on the rock, shapes, stresses

_BEST_SHOWN = 1.5  # times the end of the last contact that curves go on for


def best(answer: BestAnswer) -> Figure:
    """Draw what a search for the best blow has found."""
    having("answer", answer, ("own", "best", "spans"), "the answer of percuss.case.best_answer")
    both = ((answer.own, COLOURS[0], "the case"), (answer.best, COLOURS[1], "best"))
    with canvas(10.0, 8.0, answer.own.title) as figure:
        grid = figure.add_gridspec(2, 2)
        draw_forces(figure.add_subplot(grid[0, 0]), both, "face_force", "(a) force between the faces")
        right = figure.add_subplot(grid[0, 1])
        if answer.own.blow.bit_force is None:
            draw_stresses(right, both, "(b) greatest stress of each section")
        else:
            draw_forces(right, both, "bit_force", "(b) force on the rock")
            draw_stresses(figure.add_subplot(grid[1, 1]), both, "(d) greatest stress of each section")
        _shapes(figure.add_subplot(grid[1, 0]), both)
    return figure


def draw_forces(axes: Any, both: Any, name: str, title: str) -> None:
    """A force of several blows over time: of each the answer, its colour and its name."""
    scales, last = _axes_of(both[0][0]), 0.0
    for one, colour, label in both:
        times, values = getattr(one.blow, name).sampled(4000)
        axes.plot(times * scales.time, values * scales.force, color=colour, label=label)
        moving = np.flatnonzero(values > 1e-3 * values.max(initial=0.0))
        last = max(last, float(times[moving[-1]]) if moving.size else 0.0)
    axes.set_xlim(0.0, min(_BEST_SHOWN * last, float(both[0][0].blow.until)) * scales.time or None)
    axes.axhline(0.0, color=INK, linewidth=0.6)
    axes.set(xlabel=scales.time_label, ylabel=scales.force_label, title=title)
    legend_above(axes)


def _shapes(axes: Any, both: Any) -> None:
    """Areas along striker and rod."""
    axes.set_title("(c) area along striker and rod")
    if not both[0][0].is_si:
        axes.set_axis_off()
        axes.text(0.5, 0.5, "a dimensionless bar has no areas", ha="center", transform=axes.transAxes)
        return
    for one, colour, label in both:
        own, rod = one.pieces
        long = own[-1].end
        known = [piece for piece in rod if np.isfinite(piece.end)]
        edges = [own[0].start - long, *(piece.end - long for piece in own), *(piece.end for piece in known)]
        areas = [1e6 * piece.area for piece in (*own, *known)]
        axes.stairs(areas, edges, color=colour, label=label, baseline=0.0)
    axes.axvline(0.0, color=INK, linewidth=0.6)
    axes.set(xlabel="place from the struck face [m]", ylabel="area [mm²]")
    legend_above(axes)


def draw_stresses(axes: Any, both: Any, title: str) -> None:
    """The greatest stress of every section of several blows, as bars side by side."""
    scales, wide = _axes_of(both[0][0]), 0.8 / len(both)
    parts = [(part, i) for i, part in enumerate(("striker", "rod"))]
    names = [f"{part} {k}" for part, i in parts for k in range(max(len(one.peaks[i]) for one, *_ in both))]
    for number, (one, colour, label) in enumerate(both):
        values = {
            f"{part} {k}": scales.stress * max(peak.compression, peak.tension)
            for part, i in parts
            for k, peak in enumerate(one.peaks[i])
        }
        places = np.arange(len(names)) + (number - 0.5 * (len(both) - 1)) * wide
        axes.bar(places, [values.get(name, 0.0) for name in names], wide, color=colour, label=label)
    axes.set_xticks(np.arange(len(names)), names, rotation=30)
    axes.set(ylabel=scales.stress_label, title=title)
    legend_above(axes)
