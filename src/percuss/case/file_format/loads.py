"""The table [load] of a case: one pydantic model for every kind of load in SI, and the load or the valve made of it.

A new load is a new class, a place in the union below the tables, and what is made of it. The text below a key is what
the reference prints; what stands there for a key of one load holds for the loads after it that say nothing.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Annotated, Any, ClassVar, Literal, NamedTuple

from pydantic import BeforeValidator, Discriminator, Field, Tag, ValidationInfo

from percuss.case.file_format.oil import (
    BULK_MODULUS,
    Chambers,
    GasAccumulatorTable,
    Joins,
    OilTable,
    Orifices,
    SupplyTable,
    WaysTable,
    gas_of,
    oil_of,
    relief_of,
    slope_of,
    ways_of,
)
from percuss.case.file_format.values import (
    Area,
    CaseTable,
    Coefficients,
    Column,
    Force,
    ForceOrPressure,
    ForceUnit,
    Frequency,
    Kind,
    Length,
    Numbers,
    PlainNumber,
    Speed,
    Stiffness,
    Stress,
    Time,
    Volume,
    above_zero,
    given_in,
    keyed,
    list_of,
    number_of,
)
from percuss.errors import ParameterError, UnitError, did_you_mean
from percuss.model import Chamber, Cushion, Load, Oil, Port, Supply, Valve
from percuss.units import si

# ---- The table [load] of a machine that switches its own valve: states, ports, gas chamber


class AreasTable(CaseTable):
    """A state by the areas on which the pressure of the supply acts."""

    front: Area | None = None
    """Area at which the pressure pushes the piston back. Allowed: 0 or greater. When left out: none."""
    rear: Area | None = None
    """Area at which it pushes the piston toward the wall. Allowed: 0 or greater. When left out: none."""


class ChamberTable(CaseTable):
    """A gas chamber behind the piston, such as the nitrogen of a breaker, the same in every state."""

    force: Force | None = None
    """Its force toward the wall while the bar is at the wall. When left out: none."""
    stiffness: Stiffness | None = None
    """How much that force grows for each distance behind the wall. Allowed: 0 or greater. When left out: none."""
    area: Area | None = None
    """Of the piston in a polytropic gas, beside `volume` and `exponent` in the place of `stiffness`. Allowed: greater
    than 0."""
    volume: Volume | None = None
    """Of that gas while the bar is at the wall. Allowed: greater than 0."""
    exponent: PlainNumber | None = None
    """n of that gas, whose force grows with the power −n of its volume. Allowed: greater than 0. When left out: the
    force grows by `stiffness`."""


class CushionTable(CaseTable):
    """What stops the piston at the front when it finds no tool, such as oil that it traps."""

    in_plain: ClassVar = {"area": None}

    beyond: Length | None = None
    """Where it begins: distance beyond the wall. Allowed: 0 or greater. When left out: at the wall."""
    force: Force | None = None
    """With which it pushes back at its beginning. Allowed: 0 or greater. When left out: none."""
    stiffness: Stiffness | None = None
    """How much that force grows with the depth. Allowed: 0 or greater. When left out: not at all."""
    length: Length | None = None
    """Depth at which the piston strikes the front of the housing. Allowed: greater than 0. When left out: no end."""
    returned: float | None = None
    """Part of the energy that it gives back. Allowed: 0 (oil that is throttled) to 1 (a spring). When left out: 0."""
    area: Area | None = None
    """Of the piston's ring that presses on the oil, for its pressure. Allowed: greater than 0. When left out: no
    pressure is told."""


def _reads(value: Any, info: ValidationInfo) -> Any:
    if value == "centre" or (isinstance(value, int | float) and not isinstance(value, bool) and 0.0 <= value <= 1.0):
        return value
    raise ParameterError("reads", value, '"centre", or a place on the bar from 0 (driven end) to 1 (striking end)')


Reads = Annotated[str | float, Kind('`"centre"` or number', _reads)]  # whose place a port reads


class PortTable(CaseTable):
    """What demands a state: a port that the piston uncovers, or the blow."""

    to: str
    """The state that is demanded."""
    behind: Length | None = None
    """Distance of the port's edge from the wall. Allowed: greater than 0. When left out: `speed` or `on` is needed."""
    side: Literal["back", "front"] | None = None
    """Where the port is uncovered: with the bar farther from the wall than its edge, or nearer; of a speed, away from
    the wall, or toward it. When left out: `on` is needed."""
    delay: Time | None = None
    """From the demand to the change of the state. Allowed: 0 or greater. When left out: none."""
    reads: Reads | None = None
    """Whose distance from the wall, or speed, counts: `"centre"`, that of the centre of mass, or that of a place on the
    bar from 0 (driven end) to 1 (striking end). When left out: `"centre"`."""
    on: Literal["impact"] | None = None
    """Every blow demands the state; instead of `behind` and `side`. When left out: it is a port."""
    speed: Speed | None = None
    """In the place of `behind`: the port opens where the bar comes to be faster than that, between blows. Allowed:
    greater than 0. When left out: a place is read."""


def _named(example: str) -> Callable[[Any], Any]:
    """A check that a value is a table with at least one name."""

    def checked(value: Any) -> Any:
        if not isinstance(value, dict) or not value:
            raise ValueError(f"a table with the force of each state, for example {example}")
        return value

    return checked


def _written(value: Any) -> str:
    if isinstance(value, dict) and any(own in ("supply", "tank") for own in value.values()):
        return "joins"
    return "areas" if isinstance(value, dict | AreasTable) else "force"


def _force(value: Any, info: ValidationInfo) -> Any:
    """A force with its unit, in words of its own where it is none."""
    if not isinstance(value, str):
        remedy = "or areas beside a pressure: {front = …, rear = …}"
        raise UnitError("states", value, 'a force with its unit, such as "-13 kN"', remedy)
    return value


State = Annotated[
    Annotated[Force, BeforeValidator(_force), Tag("force")]
    | Annotated[AreasTable, Tag("areas")]
    | Annotated[Joins, Tag("joins")],
    Discriminator(_written),
]
"""A state in SI."""
PlainState = Annotated[
    Annotated[PlainNumber, Tag("force")] | Annotated[Joins, Tag("joins")],
    Discriminator(lambda value: "joins" if isinstance(value, dict) else "force"),
]
"""A state without units."""

PlainStates = Annotated[dict[str, PlainState], Kind("table of numbers", _named("{return = -0.3, power = 1.0}"))]
States = Annotated[
    dict[str, State],
    Kind("table of forces or tables", _named('{return = "-13 kN", power = "12 kN"}'), plain=PlainStates),
]
Ports = Annotated[tuple[PortTable, ...], list_of("ports", '{behind = …, side = "back", to = "power"}')]


class ValveLoad(CaseTable):
    """A load that the piston switches."""

    in_plain: ClassVar = {
        "pressure": None,
        "states": "The force of each state, positive toward the wall and without that of `chamber`. Allowed: up to "
        "64 of them.",
        "cushion": "What stops the piston when it finds no tool. When left out: nothing is told of that.",
    }

    kind: Literal["valve"]
    """The kind of load, which decides the other keys."""
    states: States
    """The force of each state, positive toward the wall and without that of `chamber`: text with a unit, or with
    `pressure` the areas that it acts on, `{front = "8 cm^2", rear = "16 cm^2"}`, or what it joins the `chambers` to,
    `{front = "supply", rear = "tank"}`. Allowed: up to 64 of them."""
    ports: Ports
    """What demands states, in order, see below. Allowed: up to 64 of them."""
    start_state: str | None = None
    """The state at the start. When left out: the first one."""
    pressure: Stress | None = None
    """The pressure of the supply, for states by areas, and for the oil that a cycle takes. Allowed: greater than 0.
    When left out: the states are forces, and no oil flow is told."""
    chamber: ChamberTable | None = None
    """A gas chamber behind the piston, see below. When left out: there is none."""
    cushion: CushionTable | None = None
    """What stops the piston when it finds no tool, see below; it does not touch the blows. When left out: one of 20 mm
    is assumed."""
    supply: SupplyTable | None = None
    """A pump and an accumulator, see below; needs `pressure`, for which the states hold, and states by areas or
    chambers. When left out: the pressure is constant."""
    chambers: Chambers | None = None
    """The chambers of oil by their names, see below; `states` join them. When left out: the states are forces or
    areas."""
    orifices: Orifices | None = None
    """What the passages of these chambers take, see below. When left out: nothing."""
    oil: OilTable | None = None
    """The oil, and the line to the tank, see below. When left out: that line has no pressure."""
    spool: Time | None = None
    """Time in which the spool goes from one state to the next. Allowed: 0 or greater. When left out: none."""
    force: Force | None = None
    """A constant force toward the wall beside all others, such as the weight. When left out: none."""
    room: Length | None = None
    """How far behind the wall the piston can go. Allowed: greater than 0. When left out: without limit."""
    at: int = 0
    """Where the load acts: 0, the driven end, or the number of a step of the bar, counted from there. Allowed: 0 or
    greater."""


# ---- The loads that keep time by themselves


class HarmonicLoad(CaseTable):
    """A load of one harmonic."""

    in_plain: ClassVar = {"area": None, "frequency": None}

    kind: Literal["harmonic"]
    """The kind of load, which decides the other keys."""
    mean: ForceOrPressure
    """Mean of the load, positive toward the wall."""
    amplitude: ForceOrPressure
    """Amplitude of the alternating part."""
    harmonic: int = 1
    """The multiple of the fundamental. Allowed: 1 to 4096."""
    area: Area | None = None
    """The area that a pressure acts on. Allowed: greater than 0. When left out: the load is a force."""
    frequency: Frequency
    """Frequency of the fundamental. Allowed: greater than 0."""
    at: int = 0
    """Where the load acts: 0, the driven end, or the number of a step of the bar, counted from there. Allowed: 0 or
    greater."""


class SquareLoad(CaseTable):
    """A load of two steps in a period."""

    in_plain: ClassVar = {"area": None, "frequency": None}

    kind: Literal["square"]
    amplitude: ForceOrPressure
    """The load alternates between plus and minus this value. Allowed: greater than 0."""
    kappa: float
    """The load is positive for a fraction κ/2 of each period. Allowed: between 0 and 2."""
    harmonics: int = 64
    """How many Fourier coefficients are kept beside the exact steps. Allowed: 1 to 4096."""
    area: Area | None = None
    frequency: Frequency
    at: int = 0


class StepsLoad(CaseTable):
    """A load of steps."""

    in_plain: ClassVar = {"unit": None, "area": None, "frequency": None}

    kind: Literal["steps"]
    breaks: Numbers
    """Load phases at which the load jumps, in radians, increasing, from 0 to less than 2π. Allowed: from 2 to 1000 of
    them."""
    values: Numbers
    """The load from each of these phases to the next. Allowed: one for each phase."""
    unit: ForceUnit
    """Unit of the values."""
    harmonics: int = 64
    """How many Fourier coefficients are kept beside the exact steps. Allowed: 1 to 4096."""
    area: Area | None = None
    frequency: Frequency
    at: int = 0


class FourierLoad(CaseTable):
    """A load by its Fourier coefficients."""

    in_plain: ClassVar = {"unit": None, "area": None, "frequency": None}

    kind: Literal["fourier"]
    coefficients: Coefficients
    """Fourier coefficients from $p_0$ (the mean, imaginary part 0) up. Allowed: 1 to 4097 pairs."""
    unit: ForceUnit
    """Unit of the coefficients."""
    area: Area | None = None
    frequency: Frequency
    at: int = 0


class HistoryLoad(CaseTable):
    """A load that was recorded."""

    in_plain: ClassVar = {"passage": None, "opposing_passage": None}

    kind: Literal["history"]
    file: str
    """Path relative to the case file; CSV or other text, or `.mat`, `.wav`, `.h5`, `.tdms` with `percuss[io]`."""
    area: Area | None = None
    frequency: Frequency | None = None
    """Frequency of the fundamental. Allowed: greater than 0. When left out: found from the record."""
    harmonics: Annotated[int, Field(ge=1)] | None = None
    """How many harmonics to keep. When left out: those that stand out from the scatter of the cycles."""
    column: Column | None = None
    """Which column or channel holds the values. When left out: the header tells."""
    unit: str | None = None
    """Unit of the values, of force or pressure. When left out: the header tells."""
    time_column: Column | None = None
    """Which column or channel holds the times. When left out: the header tells."""
    sample_rate: Frequency | None = None
    """Sample rate, for a file that holds no times, or wrong ones. Allowed: greater than 0. When left out: the file
    tells."""
    opposing_column: Column | None = None
    """Which column or channel holds the pressure (or force) on the opposing face, which pushes back: the load is
    pressure × `area` − opposing pressure × `opposing_area`. When left out: there is none."""
    opposing_area: Area | None = None
    """The area that the opposing pressure acts on. Allowed: greater than 0."""
    passage: WaysTable | None = None
    """What the passage takes between the place where the pressure was recorded and `area`, see below; the force stays
    what was recorded, and `percuss machine` tells the share of it. When left out: nothing."""
    opposing_passage: WaysTable | None = None
    """The same of the opposing pressure. When left out: nothing."""
    start: Time | None = Field(None, alias="from")
    """Where the part of the record that is used begins, on the clock of the record; dates and times of day count from
    the first sample. When left out: at the first sample."""
    end: Time | None = Field(None, alias="to")
    """Where that part ends. When left out: at the last sample."""
    at: int = 0


class RecordedPassage(NamedTuple):
    """A passage to a face of a recorded pressure: its key, area, sign of its force, and ζ towards and away from it."""

    key: str
    area: float
    sign: float
    ways: tuple[float, float]


def recorded_passages(table: HistoryLoad) -> tuple[RecordedPassage, ...]:
    """Those that a table names."""
    found = []
    for key, beside, sign in (("passage", "area", 1.0), ("opposing_passage", "opposing_area", -1.0)):
        if (given := getattr(table, key)) is not None:
            if (area := getattr(table, beside)) is None:
                raise ParameterError(key, None, "a passage to an area with a recorded pressure", f"give {beside}")
            found.append(RecordedPassage(key, above_zero(beside, area, "area"), sign, ways_of(given, key)))
    return tuple(found)


AnyLoad = Annotated[
    HarmonicLoad | SquareLoad | FourierLoad | HistoryLoad | StepsLoad | ValveLoad, Field(discriminator="kind")
]
"""The loads of the SI form."""


# ---- From the table [load] of a case to a load, except recordings

_MOST_STEPS = 1000  # steps of a load; each of the thousands of harmonics is a sum over them


def load_of(table: AnyLoad) -> Load:
    """The load that a formula describes: in N with its frequency, or dimensionless."""
    hertz, square_metres = getattr(table, "frequency", None), getattr(table, "area", None)
    frequency = None if hertz is None else above_zero("frequency", hertz, "frequency")
    area = None if square_metres is None else above_zero("area", square_metres, "area")

    def number(value: float | str, name: str) -> float:
        if not isinstance(value, str):
            return value
        if area is not None:
            return si(value, "pressure", name) * area
        with keyed(remedies={name: 'a pressure also needs the area that it acts on: area = "6.5 cm^2"'}):
            return si(value, "force", name)

    given = getattr(table, "unit", None)
    unit = 1.0 if given is None else number(f"1 {given}", "unit")
    if isinstance(table, HarmonicLoad):
        mean, amplitude = number(table.mean, "mean"), number(table.amplitude, "amplitude")
        load = Load.harmonic(mean, amplitude, table.harmonic, frequency=frequency)
    elif isinstance(table, SquareLoad):
        load = Load.square(number(table.amplitude, "amplitude"), table.kappa, table.harmonics, frequency=frequency)
    elif isinstance(table, StepsLoad):
        if len(table.breaks) > _MOST_STEPS:
            raise ParameterError("breaks", f"{len(table.breaks)} phases", f"at most {_MOST_STEPS}")
        load = Load.steps(table.breaks, [unit * p for p in table.values], table.harmonics, frequency=frequency)
    else:
        assert isinstance(table, FourierLoad)
        load = Load.fourier([unit * complex(re, im) for re, im in table.coefficients], frequency=frequency)
    return load.acting_at(table.at)


# ---- From the table [load] of a machine that switches itself to its valve

_PRESSURE = "give pressure, that of the supply, or the forces of the states"
_BEHIND = "the wall is at 0, and the distance is counted away from it"
_BEYOND = "one that began behind the wall would take part of every blow, which is not in the model"


def valve_of(table: ValveLoad) -> Valve:
    """The valve that a table describes: in N, m and s, or dimensionless; what else the table says is checked, too."""
    pressure, room = pressure_of(table), room_of(table)
    oil = None if not _flows(table) else _oil(table, pressure)
    states = {name: _state_force(name, given, pressure, oil) for name, given in table.states.items()}
    ports = []
    for i, own in enumerate(table.ports):
        with keyed(f"ports[{i}].", remedies={"behind": _BEHIND}):
            ports.append(Port(**given_in(own)))
        if room is not None and (ports[i].behind or 0.0) >= room:
            accepted = f"a port within the room, {table.room}"
            raise ParameterError(f"ports[{i}].behind", own.behind, accepted, "the piston cannot reach it")
    with keyed("chamber."):
        chamber = Chamber() if table.chamber is None else _chamber(table.chamber)
    with keyed("cushion.", remedies={"beyond": _BEYOND}):
        cushion = None if table.cushion is None else Cushion(**given_in(table.cushion))
    supply = None if table.supply is None else _supply(table, table.supply, pressure)
    try:
        made = Valve(states, tuple(ports), table.start_state, chamber, cushion, supply, oil)
        return made if made.flows else replace(made, oil=None)
    except ParameterError as error:
        name = {"start": "start_state"}.get(error.name, error.name).replace("']", "").replace("['", ".")
        near = did_you_mean(error.value, table.states) if name.endswith((".to", "start_state")) else ""
        raise ParameterError(name, error.value, error.accepted, near or error.remedy) from None


def pressure_of(table: ValveLoad) -> float | None:
    """The pressure of the supply in Pa, or None."""
    return None if table.pressure is None else above_zero("pressure", table.pressure, "pressure")


def room_of(table: ValveLoad) -> float | None:
    """How far behind the wall the piston can go: in m, or dimensionless; None without a limit."""
    return None if table.room is None else above_zero("room", table.room, "length")


def _flows(table: ValveLoad) -> bool:
    """Whether a table says anything of oil that is more than areas and a pump."""
    supply, beyond = table.supply, (table.chambers, table.orifices, table.oil, table.spool, table.force)
    more = supply is not None and (supply.leakage is not None)
    return more or any(one is not None for one in beyond)


def _oil(table: ValveLoad, pressure: float | None) -> Oil:
    if not table.is_plain and pressure is None:
        raise ParameterError("pressure", None, "the pressure for which the figures hold, beside chambers", _PRESSURE)
    if table.orifices and not table.chambers:
        raise ParameterError("chambers", None, "the chambers that the orifices lead to", "name them, and join them")
    for name, state in table.states.items():
        if isinstance(state, str | float | int):
            remedy = 'give the chambers that it joins, {front = "supply", rear = "tank"}'
            raise ParameterError(f"states.{name}", state, "chambers or areas, beside oil that flows", remedy)
    spool = 0.0 if table.spool is None else number_of("spool", table.spool, "time")
    force = 0.0 if table.force is None else number_of("force", table.force, "force")
    with keyed():
        return oil_of(table, 1.0 if pressure is None else pressure, spool, force)


def _chamber(own: ChamberTable) -> Chamber:
    """The gas behind the piston: its tangent, or the gas itself by area, volume and exponent."""
    given = given_in(own)
    gas = {name: given.pop(name, None) for name in ("area", "volume", "exponent")}
    if all(value is None for value in gas.values()):
        return Chamber(**given)
    for name, value in gas.items():
        if value is None:
            raise ParameterError(name, None, "area, volume and exponent of a polytropic gas, or its stiffness")
        if not value > 0.0:
            raise ParameterError(name, getattr(own, name), "a value greater than 0")
    if own.stiffness is not None:
        raise ParameterError("stiffness", own.stiffness, "nothing beside a volume", "the volume tells the stiffness")
    force = given.get("force", 0.0)
    if not force > 0.0:
        raise ParameterError("force", own.force, "the force of the gas at the wall, greater than 0")
    return Chamber(force, gas["exponent"] * force * gas["area"] / gas["volume"], gas["exponent"])


def _state_force(name: str, given: Any, pressure: float | None, oil: Oil | None) -> float:
    key = f"states.{name}"
    if isinstance(given, dict):
        assert oil is not None
        return float(oil.areas(name, "supply"))
    if not isinstance(given, AreasTable):
        return number_of(key, given, "force")
    if pressure is None:
        raise ParameterError(key, None, "a force, as there is no pressure for the areas", _PRESSURE)
    areas: dict[str, float] = given_in(given, f"{key}.")
    for side, area in areas.items():
        if area < 0.0:
            raise ParameterError(f"{key}.{side}", getattr(given, side), "an area, 0 or greater")
    return pressure * (areas.get("rear", 0.0) - areas.get("front", 0.0))


def _supply(table: ValveLoad, own: SupplyTable, pressure: float | None) -> Supply | None:
    if own.flow is None:
        for name in ("accumulator", "start", "power", "slip", "relief", "line"):
            if getattr(own, name) is not None:
                raise ParameterError("supply.flow", None, f"the flow of the pump, beside supply.{name}")
        return None
    flow = above_zero("supply.flow", own.flow, "flow")
    if own.accumulator is None:
        raise ParameterError("supply.accumulator", None, "the accumulator beside a pump, such as 2.5 cm^3/bar")
    start = None if own.start is None else number_of("supply.start", own.start, "pressure")
    if start is not None and start < 0.0:
        raise ParameterError("supply.start", own.start, "a pressure, 0 or greater")
    for name, state in table.states.items():
        if not table.is_plain and isinstance(state, str):
            remedy = "a piston displaces oil by the areas on which its pressure acts"
            raise ParameterError(f"states.{name}", state, "areas, {front = …, rear = …}, beside a supply", remedy)
    if not table.is_plain and pressure is None:
        raise ParameterError("pressure", None, "the pressure for which the states hold, beside a supply", _PRESSURE)
    unit = 1.0 if pressure is None else pressure
    gas = None
    if isinstance(own.accumulator, GasAccumulatorTable):
        gas = gas_of(own.accumulator, unit)
        line = 0.0 if own.line is None else number_of("supply.line", own.line, "volume")
        if line < 0.0:
            raise ParameterError("supply.line", own.line, "a volume, 0 or greater")
        compliance = line / (1.0 if table.is_plain else BULK_MODULUS)
    elif own.line is None:
        compliance = above_zero("supply.accumulator", own.accumulator, "compliance")
    else:
        remedy = "give the accumulator by its gas, or its volume per pressure with that of the line in it"
        raise ParameterError("supply.line", own.line, "an accumulator with gas beside it", remedy)
    with keyed("supply."):
        return Supply(
            flow * unit,
            compliance * unit**2,
            1.0 if start is None else start / unit,
            0.0 if own.quickening is None else own.quickening,
            0.0 if own.slip is None else slope_of(own.slip, "slip") * unit**2,
            None if own.power is None else above_zero("power", own.power, "power"),
            None if own.relief is None else relief_of(own.relief, unit),
            gas,
        )
