"""What a map can show for each of its cells."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

from percuss.blow.figures import FIGURES as BLOW_FIGURES
from percuss.errors import ParameterError
from percuss.explore.family import Family, drives_itself
from percuss.explore.jobs.job import Column
from percuss.model.checks import several
from percuss.steady.figures import FIGURES
from percuss.steady.multipliers import VERDICTS
from percuss.steady.self_excited.self_switching import Obstacle

BRANCHES = 8  # the most orbits of a cell whose phases are kept
CELL_OUTCOMES = ("ok", "does not push", "resonance", "not accurate", "no system", "failed", "no start")
"""How a cell ended, by number: ``outcome`` of every map.

``does not push``: the load is constant or its mean is not greater than 0: there is no steady motion to look for.
``resonance``: an undamped bar driven at one of its own frequencies. ``not accurate``: a computation failed its own
check. ``no system``: the parameters make none. ``no start``: the simulation has none to begin from, such as a steady
motion that does not exist there. From ``resonance`` on, what could not be computed holds NaN, −1 or False.
"""

REASONS = tuple(reason.value for reason in VERDICTS)
"""Why the orbit of a cell is stable or not, by number."""

Group = Literal["orbits", "exact", "rest", "simulation", "lyapunov", "blow", "transfer", "machine"]
"""What a quantity is of: the closed form, …, one blow by waves, a cycle with its own blow, the cycle of a machine."""


@dataclass(frozen=True)
class Quantity:
    """A quantity of a cell: its columns, what must be computed for it; `one`: it is of the most stable orbit."""

    columns: dict[str, Column]
    group: Group
    one: bool = False


def single(
    name: str, group: Group, meaning: str, dtype: str = "float64", unit: str = "", one: bool = False
) -> Quantity:
    """A quantity of one column of its own name."""
    return Quantity({name: Column(dtype, (), unit, meaning=meaning)}, group, one)


_LABEL = {
    "label_outcome": Column("int8", meaning="how the simulation ended, by its number in percuss.simulate.OUTCOMES"),
    "label_impacts": Column("int64", fill=0, meaning="p of the motion label z=p/n; 0 when no cycle was found"),
    "label_periods": Column("int64", fill=0, meaning="n of the motion label z=p/n"),
    "label_kind": Column("int8", fill=0, meaning="cycle without rest (0), with rest (1), with chatter and rest (2)"),
    "label_wanders": Column("bool", meaning="whether the last impacts do not come near any earlier ones"),
}

_BEST = "of the steady motion with the greatest stability margin"


def _figure(name: str) -> Quantity:
    """A figure of the most stable orbit, as `percuss.steady.figures` has it."""
    figure = FIGURES[name]
    return single(name, "orbits", f"{figure.label} {_BEST}: {figure.meaning}", unit=figure.unit, one=True)


def _of_blow(name: str) -> Quantity:
    """A figure of one blow, as `percuss.blow.figures` has it."""
    figure = BLOW_FIGURES[name]
    return single(name, "blow", f"{figure.label} of one blow by waves: {figure.meaning}", unit=figure.unit)


_EXPONENTS = {
    "lyapunov": single("lyapunov", "lyapunov", "greatest Lyapunov exponent of the impact map, per impact"),
    "lyapunov_all": Quantity(
        {"lyapunov_all": Column("float64", (BRANCHES,), meaning="Lyapunov exponents of the impact map, the greatest")},
        "lyapunov",
    ),
}

_TRANSFER = {
    "rock_power": single(
        "rock_power", "transfer", "power into the rock, of the hammer's own cycle and its blow by waves", unit="W"
    ),
    "overall_efficiency": single(
        "overall_efficiency", "transfer", "the same over what the load, the valve or the pump puts in"
    ),
    "rock_share": single("rock_share", "transfer", "work on the rock over the energy of that blow"),
    "rate_of_penetration": single(
        "rate_of_penetration", "transfer", "advance of the hole by that blow, as `[drilling]` has it", unit="m/s"
    ),
    "steel_tension": single("steel_tension", "transfer", "the greatest tension in the tool in that blow", unit="Pa"),
    "joint_openings": single("joint_openings", "transfer", "how often contact joints of the tool open in that blow"),
}

QUANTITIES: dict[str, Quantity] = {
    "exists": single("exists", "orbits", "whether a steady motion exists (B77 14)", "bool"),
    "orbits": single("orbits", "orbits", "number of steady motions, physically possible or not", "int16"),
    "phases": Quantity(
        {"phases": Column("float64", (BRANCHES,), "rad", meaning="impact phases of all steady motions, ascending")},
        "orbits",
    ),
    "phase": _figure("phase"),
    "reduced_stable": single("reduced_stable", "orbits", "whether one is stable by B77's reduced criterion", "bool"),
    "reduced_margin": single("reduced_margin", "orbits", "1 − largest modulus of the reduced criterion, the greatest"),
    "stable": single("stable", "exact", "whether one is stable by the exact multipliers", "bool"),
    "margin": single("margin", "exact", "1 − largest modulus of the exact multipliers, the greatest"),
    "margin_rhythm": single(
        "margin_rhythm", "exact", f"1 − largest modulus of the two multipliers of the rigid motion, {_BEST}", one=True
    ),
    "margin_ringing": single(
        "margin_ringing",
        "exact",
        f"1 − largest modulus of all other multipliers, {_BEST}; NaN without elastic modes",
        one=True,
    ),
    "reason": single("reason", "exact", f"why, {_BEST}: {', '.join(REASONS)}, by number", "int8", one=True),
    "admissible": single(
        "admissible", "orbits", f"whether the bar stays off the wall between impacts, {_BEST}", "bool", one=True
    ),
    **{name: _figure(name) for name in FIGURES if name not in ("phase", "blow_rate")},
    "rest": single("rest", "rest", "whether the bar can lie on the wall for good", "bool"),
    "label": Quantity(_LABEL, "simulation"),
    "blow_rate": single("blow_rate", "simulation", "impacts per load period"),
    "blow_scatter": single("blow_scatter", "simulation", "standard deviation of the intervals over their mean"),
    "main_blow_rate": single("main_blow_rate", "simulation", "impacts per load period, each chatter counted once"),
    "main_blow_scatter": single("main_blow_scatter", "simulation", "scatter of the main blows"),
    **_EXPONENTS,
    **_TRANSFER,
    **{name: _of_blow(name) for name in BLOW_FIGURES},
}  # fmt: skip
"""Everything that can be asked of a cell, by name."""

DEFAULT_QUANTITIES = ("exists", "orbits", "phase", "reduced_stable", "stable", "margin")

OF_FREE_BARS = {
    "reduced_stable": "B77's reduced criterion is one of bars that move as a whole: ask for stable",
    "reduced_margin": "B77's reduced criterion is one of bars that move as a whole: ask for margin",
    "rest": "what rests on the wall for good is a bar that moves as a whole",
}
"""What only a free bar has, and what to ask of a structure that is held."""


def checked(names: Sequence[str], known: Mapping[str, Quantity] = QUANTITIES) -> tuple[str, ...]:
    """The names, each once and in order; ParameterError with those that are `known` for another."""
    names = several("quantities", names, f"a list of names of quantities, such as {next(iter(known))}")
    for name in names:
        if not isinstance(name, str) or name not in known:
            raise ParameterError("quantities", name, f"one of {', '.join(known)}")
    if not names:
        raise ParameterError("quantities", list(names), f"one or more of {', '.join(known)}")
    return tuple(dict.fromkeys(names))


def needs(names: Sequence[str], known: Mapping[str, Quantity] = QUANTITIES) -> set[Group]:
    """The groups of what must be computed."""
    return {known[name].group for name in names}


def columns_of(names: Sequence[str], si: bool, known: Mapping[str, Quantity] = QUANTITIES) -> dict[str, Column]:
    """The columns of these quantities, after that of the outcome; without units of SI for dimensionless systems."""
    found = {"outcome": Column("int8", meaning=f"{', '.join(CELL_OUTCOMES)}, by number")}
    for name in names:
        for key, column in known[name].columns.items():
            unit = column.unit if si or column.unit == "rad" else ""
            found[key] = Column(column.dtype, column.shape, unit, column.fill, column.meaning)
    return found


# ---- What a map can show of machines that switch their own valves

STALLS = ("runs", *(obstacle.value for obstacle in Obstacle))
"""What keeps a machine from running with one blow in a cycle, by number: ``stall`` of a map; 0 when it runs."""


def _of_cycle(name: str, meaning: str, unit: str = "") -> Quantity:
    return single(name, "machine", f"{meaning}; NaN where the machine does not run", unit=unit)


MACHINE_QUANTITIES: dict[str, Quantity] = {
    "stall": single("stall", "machine", f"what keeps the machine from running: {', '.join(STALLS)}, by number", "int8"),
    "runs": single("runs", "machine", "whether it has a stable cycle with one blow", "bool"),
    "starts": single("starts", "machine", "whether it keeps striking when it starts at rest on the wall", "bool"),
    "blow_energy": _of_cycle("blow_energy", "kinetic energy just before the blow, all modes", "J"),
    "rate": _of_cycle("rate", "blows in a second; dimensionless: in a unit of time", "Hz"),
    "speed": _of_cycle("speed", "speed of the striking end just before the blow", "m/s"),
    "stroke": _of_cycle("stroke", "greatest distance of the striking end from the wall", "m"),
    "power": _of_cycle("power", "energy that the blows take, over time", "W"),
    "flow": _of_cycle(
        "flow", "what the valve draws from the supply, over time; dimensionless: over the area that it switches", "m³/s"
    ),
    "efficiency": _of_cycle("efficiency", "energy that the blows take over what the valve puts in"),
    "duty": _of_cycle("duty", "part of the period between the last rise of the force and the blow"),
    "multiplier": single("multiplier", "machine", "modulus of the greatest multiplier of the cycle with one blow"),
    **_EXPONENTS,
    **{name: quantity for name, quantity in QUANTITIES.items() if quantity.group in ("blow", "transfer")},
}
"""Everything that can be asked of a machine that switches its own valve, by name."""

DEFAULT_MACHINE_QUANTITIES = ("stall", "blow_energy", "rate", "stroke")


def known_quantities(family: Family) -> Mapping[str, Quantity]:
    """What can be asked of the systems, or of the machines, of a family."""
    return MACHINE_QUANTITIES if drives_itself(family) else QUANTITIES
