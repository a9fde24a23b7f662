"""What a whole hammer gives: the figures of its cycle, its oil and its blow, each by one name, and their ±."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

from percuss.case.answers.blows.transfer import transfer_of
from percuss.case.answers.facts import Fact, Grid, figures, measured, number, percent, plain_of, quantity
from percuss.errors import ParameterError, PercussError, did_you_mean
from percuss.model.checks import DEFAULT_MODES, text
from percuss.short_repr import ShortRepr
from percuss.stability import stability_of
from percuss.steady import Orbit, self_excited_motion, steady_states
from percuss.steady.figures import FIGURES
from percuss.units import si, unit_scale

if TYPE_CHECKING:
    from percuss.case.answers.blows.transfer import Transfer
    from percuss.case.file_format.contact import BlowQuestion
    from percuss.model import Machine, System
    from percuss.steady.self_excited.valve_cycle import ValveCycle


@dataclass(frozen=True)
class WholeHammer(ShortRepr):
    """A hammer in its steady motion, with what drives it and what it strikes.

    Attributes
    ----------
    motion
        The cycle that it is judged by; None where it has none.
    stopped
        Why it cannot sustain that motion; "" where it runs.
    tool
        The blow on the rod of the case, whatever its speed; None without one.
    """

    motion: Orbit | ValveCycle | None
    stopped: str
    tool: BlowQuestion | None

    @property
    def runs(self) -> bool:
        """Whether it can sustain its motion."""
        return not self.stopped

    @cached_property
    def transfer(self) -> Transfer | None:
        """Where the energy of the cycle goes, through its own blow by waves; None without a rod, or one blow."""
        return transfer_of(self.motion, self.tool)

    def value(self, name: str) -> float | None:
        """A figure by its name, in base units of SI, or dimensionless; None where the hammer has none."""
        return None if self.motion is None else whole_figure(name).value(self)


def whole_system(system: System, tool: BlowQuestion | None, periods: int = 1, modes: int | None = None) -> WholeHammer:
    """That of a load that keeps time: of its possible steady motions the one with the greatest margin of stability."""
    found = [(stability_of(orbit, modes=modes), orbit) for orbit in steady_states(system, periods, modes=modes).orbits]
    if not found:
        return WholeHammer(None, "no steady motion with one blow", tool)
    found.sort(key=lambda one: -one[0].margin)
    possible = next((one for one in found if one[1].admissible), None)
    if possible is None:
        return WholeHammer(found[0][1], "it would strike or rest in between", tool)
    return WholeHammer(possible[1], "" if possible[0].stable else "unstable", tool)


def whole_machine(
    machine: Machine,
    tool: BlowQuestion | None,
    room: float | None = None,
    modes: int | None = None,
    near: ValveCycle | None = None,
) -> WholeHammer:
    """That of a machine that switches its own valve; with elastic modes first looked for `near` another cycle.

    By default 32 elastic modes, and a rigid piston where the oil flows.
    """
    flows = machine.valve.flows
    kept = (0 if flows else DEFAULT_MODES) if modes is None else modes
    found = None
    if near is not None and (kept or flows):
        with suppress(PercussError):  # then it is looked for as any other
            found = self_excited_motion(machine, modes=kept, room=room, near=near)
    if found is None or not found.runs:
        found = self_excited_motion(machine, modes=kept, room=room)
    return WholeHammer(found.cycle, "" if found.obstacle is None else found.obstacle.value, tool)


# ---- Its figures


@dataclass(frozen=True)
class WholeFigure:
    """A figure of a `WholeHammer`: its label, its dimension as in `percuss.units`, its base unit and how it is found.

    `spoken`: the unit in which people say it, where that is not the base unit with a prefix.
    """

    label: str
    dimension: str
    unit: str
    value: Callable[[WholeHammer], float | None]
    spoken: str = ""

    def tell(self, value: float, is_si: bool, digits: int = 4) -> str:
        """A value with its unit."""
        if not is_si or not self.spoken:
            return measured(value, self.unit if is_si else "", digits)
        return f"{number(value / unit_scale(self.spoken, (self.dimension,), self.label)[0], digits)} {self.spoken}"

    def axis(self, greatest: float, is_si: bool) -> tuple[float, str]:
        """What base units are multiplied by on an axis that goes as far as this, and the unit there."""
        if not is_si or not self.unit:
            return 1.0, ""
        if self.spoken:
            return 1.0 / unit_scale(self.spoken, (self.dimension,), self.label)[0], self.spoken
        if not self.unit.isalpha() or self.unit == "rad" or greatest == 0.0:
            return 1.0, self.unit
        told = quantity(greatest, self.unit)
        return float(f"{float(told.split()[0]) / greatest:.0e}"), told.split()[1]

    def given(self, name: str, text: str, is_si: bool) -> float:
        """A value in base units from text such as ``70 Hz``; UnitError without its unit, or with another one's."""
        return si(text, self.dimension if is_si and self.dimension else "dimensionless", name)


_DIMENSIONS = {
    "J": "energy", "Pa": "pressure", "s": "time", "W": "power", "m": "length", "m/s": "velocity", "N": "force",
    "Hz": "frequency",
}  # fmt: skip


def _of_cycle(name: str) -> WholeFigure:
    figure = FIGURES[name]

    def value(one: WholeHammer) -> float | None:
        motion = one.motion
        return None if motion is None else figure.in_si(motion) if motion.system.is_si else figure.value(motion)

    return WholeFigure(figure.label, _DIMENSIONS.get(figure.unit, ""), figure.unit, value)


def _rebound(one: WholeHammer) -> float | None:
    speed = _of_cycle("rigid_velocity").value(one)
    return None if one.motion is None or speed is None else -one.motion.system.contact.velocity_factor * speed


def _margin(one: WholeHammer) -> float | None:
    return None if one.motion is None else 1.0 - one.motion.judged().largest


def _oil(one: WholeHammer) -> tuple[ValveCycle, float] | None:
    """The cycle of a machine, and the pressure for which its forces hold; None where that is not known."""
    if one.motion is None or isinstance(one.motion, Orbit):
        return None
    nominal = one.motion.system.pressure
    return None if nominal is None else (one.motion, nominal)


def _pressure(one: WholeHammer) -> float | None:
    """Mean of the supply."""
    oil = _oil(one)
    return None if oil is None else oil[0].mean_pressure * oil[1]


def _flow(one: WholeHammer) -> float | None:
    """Volume that a machine draws from its supply, over time."""
    if (oil := _oil(one)) is None:
        return None
    cycle, nominal = oil
    return cycle.drawn / cycle.period * cycle.system.power_scale / nominal


def _delivered(one: WholeHammer) -> float | None:
    """What the blows take over the input of a machine."""
    if one.motion is None or isinstance(one.motion, Orbit) or not one.motion.work > 0.0:
        return None
    return one.motion.taken / one.motion.work


def _of_transfer(name: str) -> Callable[[WholeHammer], float | None]:
    return lambda one: None if one.transfer is None else getattr(one.transfer, name)


def _stress(body: int, section: int | None = None) -> Callable[[WholeHammer], float | None]:
    """The greatest stress of the piston (0) or the steel (1), in one of its sections or in all."""

    def value(one: WholeHammer) -> float | None:
        if one.transfer is None:
            return None
        if section is None:
            peak = one.transfer.peaks[body]
            return None if peak is None else peak.stress
        sections = one.transfer.sections[body]
        if section >= len(sections):
            raise ParameterError("section", section, f"one of {len(sections)} sections, counted from 0")
        return max(sections[section].compression, sections[section].tension)

    return value


def _penetration(one: WholeHammer) -> float | None:
    """Advance of the hole in a second, as the table [drilling] says what a blow is worth."""
    if one.transfer is None or one.tool is None or one.tool.drilling is None:
        return None
    blow, drilling = one.transfer.blow, one.tool.drilling
    if blow.greatest_penetration is None:
        return None
    if drilling.specific_energy is not None:
        return blow.rock_dissipated / (drilling.area * drilling.specific_energy) / one.transfer.period
    return (drilling.crater_factor or 0.0) * (blow.residual_penetration or 0.0) / one.transfer.period


def _tension(one: WholeHammer) -> float | None:
    return None if one.transfer is None else max((peak.tension for peak in one.transfer.sections[1]), default=None)


def _openings(one: WholeHammer) -> float | None:
    """How often the joints of the tool that only push have opened in the blow."""
    from percuss.blow.drilling import joint_turns

    return None if one.transfer is None else float(sum(len(joint.opens) for joint in joint_turns(one.transfer.blow)))


WHOLE_FIGURES: dict[str, WholeFigure] = {
    **{name: _of_cycle(name) for name in FIGURES},
    "rebound_velocity": WholeFigure("rebound speed", "velocity", "m/s", _rebound),
    "flow": WholeFigure("oil flow", "flow", "m³/s", _flow, "l/min"),
    "pressure": WholeFigure("pressure of the supply", "pressure", "Pa", _pressure, "bar"),
    "efficiency": WholeFigure("efficiency of the drive", "", "", _delivered),
    "rock_power": WholeFigure("power into the rock", "power", "W", _of_transfer("rock_power")),
    "rock_energy": WholeFigure("energy into the rock", "energy", "J", _of_transfer("rock_energy")),
    "overall_efficiency": WholeFigure("overall efficiency", "", "", _of_transfer("overall_efficiency")),
    "rock_share": WholeFigure(
        "share of a blow into the rock",
        "",
        "",
        lambda one: None if one.transfer is None else one.transfer.blow.efficiency,
    ),
    "rate_of_penetration": WholeFigure("rate of penetration", "velocity", "m/s", _penetration),
    "steel_tension": WholeFigure("greatest tension in the steel", "pressure", "Pa", _tension),
    "joint_openings": WholeFigure("openings of joints in a blow", "", "", _openings),
    "piston.stress": WholeFigure("peak stress in the piston", "pressure", "Pa", _stress(0)),
    "steel.stress": WholeFigure("peak stress in the steel", "pressure", "Pa", _stress(1)),
    "margin": WholeFigure("margin", "", "", _margin),
}
"""Every figure by its name; `piston[i].stress` and `steel[i].stress` are those of one section."""

HEADLINE = ("blow_energy", "blow_rate", "impact_velocity", "stroke", "flow", "pressure", "rock_power", "piston.stress",
            "steel.stress", "stress", "margin")  # fmt: skip
"""The figures that matter, by their names."""

_SECTION = re.compile(r"(piston|steel)\[(\d{1,3})\]\.stress")


def whole_figure(name: str) -> WholeFigure:
    """A figure by its name; ParameterError with those that there are."""
    if text("figure", name) in WHOLE_FIGURES:
        return WHOLE_FIGURES[name]
    if match := _SECTION.fullmatch(name):
        body, section = match[1], int(match[2])
        label = f"peak stress in section {section} of the {body}"
        return WholeFigure(label, "pressure", "Pa", _stress(("piston", "steel").index(body), section))
    known = ", ".join([*WHOLE_FIGURES, "piston[i].stress", "steel[i].stress"])
    raise ParameterError("figure", name, f"one of {known}", did_you_mean(name, WHOLE_FIGURES))


# ---- What the ± of its numbers leaves of the figures

_SPOKEN = ("blow_energy", "blow_rate", "impact_velocity", "rock_power")
_MAIN = ("rock_power", "blow_energy", "impact_velocity")


@dataclass(frozen=True)
class UncertainFigure:
    """A figure of a hammer some of whose numbers are known within ± (base units of SI, or dimensionless).

    Attributes
    ----------
    half
        What its numbers leave it by: the root of the sum of the squares of what each leaves alone.
    shares
        Of that sum, by the keys of the numbers, the greatest first.
    bent
        Whether it is far from linear within the ±, so that `half` is a guess.
    """

    name: str
    value: float
    half: float
    shares: dict[str, float]
    bent: bool

    def tell(self, is_si: bool) -> str:
        """The value with its ±, to two digits of that."""
        factor, unit = WHOLE_FIGURES[self.name].axis(abs(self.value), is_si)
        value, half = self.value * factor, self.half * factor
        places = max(0, 1 - math.floor(math.log10(half))) if half < math.inf else 0
        return f"{value + 0.0:.{places}f} ± {half:.{places}f} {unit}".rstrip()


UNCERTAIN: tuple[Fact[UncertainFigure], ...] = figures(
    """
    name | the figure, as maps have it
    value | what it is, in the base unit of SI, or dimensionless
    half | its ±: the root of the sum of the squares of what the ± of each number makes alone
    shares | of that sum, by the keys of the case, the greatest first
    bent | whether the figure is far from linear within these ranges; then `percuss tolerance` says more
    """
)
"""A figure with its ±."""


@dataclass(frozen=True)
class FigureUncertainty(ShortRepr):
    """The figures of a hammer some of whose numbers are known within ±.

    Attributes
    ----------
    given
        These numbers, by their keys.
    figures
        Those that depend on them.
    stopped
        The ends at which the hammer does not run, and why.
    """

    given: tuple[tuple[str, str], ...]
    figures: tuple[UncertainFigure, ...]
    stopped: tuple[str, ...]
    is_si: bool

    def told(self, name: str) -> str | None:
        """A figure with its ±; None where it has none."""
        return next((one.tell(self.is_si) for one in self.figures if one.name == name), None)

    @property
    def sentence(self) -> str:
        """What is known of the headline figures, and what dominates."""
        rows = {one.name: one for one in self.figures}
        told = [f"{WHOLE_FIGURES[name].label} {rows[name].tell(self.is_si)}" for name in _SPOKEN if name in rows]
        said = f"As its numbers are known: {', '.join(told)}" if told else ""
        main = next((rows[name] for name in _MAIN if name in rows), None)
        if main is not None:
            key, share = next(iter(main.shares.items()))
            said += f"; mostly from {key}" if share < 0.995 and len(self.given) > 1 else f"; from {key}"
        said += "." if said else ""
        if self.stopped:
            said += f" Not all of these hammers run: {self.stopped[0]}."
        return said.strip()

    @property
    def grid(self) -> Grid:
        """The figures as a table of a report."""
        rows = []
        for one in self.figures:
            shares = ", ".join(f"{key} {percent(share)}" for key, share in one.shares.items() if share > 0.005)
            rows.append((WHOLE_FIGURES[one.name].label, one.tell(self.is_si), shares + (" (bent)" if one.bent else "")))
        rows += [("does not run", "", words) for words in self.stopped]
        given = ", ".join(f"{key} ({text})" for key, text in self.given)
        return Grid(f"By the ± of {given}", ("figure", "value", "from (shares of the variance)"), tuple(rows))

    def to_json_dict(self) -> dict[str, Any]:
        """The figures in plain values."""
        figures = [plain_of(one, UNCERTAIN) for one in self.figures]
        return {"sentence": self.sentence, "figures": figures, "stopped": list(self.stopped)}
