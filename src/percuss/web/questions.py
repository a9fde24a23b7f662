"""The questions as the page sends them: one model each, which also writes the OpenAPI schema."""

from __future__ import annotations

from typing import Annotated, Any, Literal, Self

from pydantic import BaseModel, ConfigDict, Field, field_validator, model_validator
from pydantic_core import PydanticCustomError

Name = Annotated[str, Field(min_length=1, max_length=64)]
Text = Annotated[str, Field(max_length=200)]
Periods = Annotated[int, Field(ge=1, le=100, description="load periods per impact, m")]
Modes = Annotated[int, Field(ge=0, le=256, description="elastic modes")]
Impacts = Annotated[int, Field(ge=0, le=20_000, description="the most impacts of a motion")]


Values = Annotated[
    dict[str, float],
    Field(max_length=32, description="parameters by name, in the case's units", examples=[{"restitution": 0.2}]),
]

_RESTITUTION: dict[str, Any] = {"name": "restitution", "from": 0.0, "to": 0.9, "count": 5}
_RESTITUTION_RANGE: dict[str, Any] = {"name": "restitution", "from": 0.095, "to": 0.12}
_LOAD_FACTOR: dict[str, Any] = {"name": "load_factor", "from": 0.05, "to": 1.2}


def _check_upwards(low: float, high: float) -> None:
    if not low < high:
        raise PydanticCustomError("range", "expected a range from a lower to a higher value")


class _Asked(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True, allow_inf_nan=False)


class CaseAsked(_Asked):
    """A case: exactly one of the three."""

    case: dict[str, Any] | None = Field(None, description="the tables of a case file, as JSON")
    toml: Annotated[str, Field(max_length=200_000)] | None = Field(None, description="the text of a case file")
    machine: Annotated[str, Field(max_length=64)] | None = Field(
        None, description="a machine of the catalogue", examples=["mini-breaker"]
    )


class PlaceAsked(CaseAsked):
    """The case with other values of its parameters."""

    values: Values


class QuickAsked(CaseAsked):
    """The steady motions, as far as a few milliseconds go."""

    periods: Periods = 1
    curve: Annotated[int, Field(ge=0, le=1001)] = 0
    modes: Modes = 32
    multipliers: bool = False
    values: Values | None = Field(None, description="as POST /api/place; the answer then has the case's new tables")


class SteadyAsked(CaseAsked):
    """What ``percuss steady --json`` answers."""

    periods: Annotated[list[Periods], Field(min_length=1, max_length=8)] = [1]
    modes: Modes | None = None


class CurvesAsked(CaseAsked):
    """The curves over the load phase, and the branches over the load factor."""

    periods: Periods = 1
    points: Annotated[int, Field(ge=2, le=4001)] = 721
    branches: Annotated[int, Field(ge=2, le=1000)] = 200
    load_factor: Annotated[list[float], Field(min_length=2, max_length=2)] | None = None
    modes: Modes = 32

    @field_validator("load_factor")
    @classmethod
    def _upwards(cls, ends: list[float] | None) -> list[float] | None:
        if ends is not None:
            _check_upwards(*ends)
        return ends


class AxisAsked(_Asked):
    """An axis of a map: equal steps, or the values themselves."""

    name: Name
    unit: Annotated[str, Field(max_length=32)] = ""
    from_: float | None = Field(None, alias="from")
    to: float | None = None
    count: Annotated[int, Field(ge=1, le=2000)] | None = None
    values: Annotated[list[float], Field(min_length=1, max_length=2000)] | None = None


class RangeAsked(_Asked):
    """A parameter and a range of it."""

    name: Name
    from_: float = Field(alias="from")
    to: float


class AlongAsked(RangeAsked):
    """The same in the unit of the case, upwards."""

    unit: Annotated[str, Field(max_length=32)] = ""

    @model_validator(mode="after")
    def _upwards(self) -> Self:
        _check_upwards(self.from_, self.to)
        return self


class MapAsked(CaseAsked):
    """Quantities over a plane of two parameters."""

    x: Annotated[AxisAsked, Field(examples=[_RESTITUTION])]
    y: Annotated[AxisAsked, Field(examples=[{**_LOAD_FACTOR, "count": 4}])]
    quantities: Annotated[list[Name], Field(min_length=1, max_length=8)] = ["orbits", "reduced_stable"]
    periods: Periods = 1
    modes: Modes = 32
    impacts: Impacts | None = None


class BoundariesAsked(CaseAsked):
    """The curves in a plane at which motions begin, end or lose their stability."""

    x: Annotated[AxisAsked, Field(examples=[_RESTITUTION])]
    y: Annotated[RangeAsked, Field(examples=[_LOAD_FACTOR])]
    periods: Periods = 1
    criterion: Literal["reduced", "exact"] = "reduced"
    kinds: Annotated[list[Literal["fold", "flip", "spiral", "grazing"]], Field(min_length=1, max_length=4)] = [
        "fold",
        "flip",
    ]
    modes: Modes = 32


class _StartAsked(CaseAsked):
    start: dict[str, Any] | None = Field(None, description="keys of [start], in place of the case's")
    simulation: dict[str, Any] | None = Field(None, description="keys of [simulation], over the case's")


class SimulateAsked(_StartAsked):
    """What ``percuss simulate --json`` answers."""

    events: Annotated[int, Field(ge=0, le=20_000)] | None = Field(None, description="the last events only")


class _FieldsAsked(CaseAsked):
    cycles: Annotated[int, Field(ge=1, le=64)] = 1
    frames: Annotated[int, Field(ge=2, le=2000)] = 240
    places: Annotated[int, Field(ge=2, le=129)] = 33
    end_points: Annotated[int, Field(ge=2, le=20_000)] = 2000

    @property
    def sizes(self) -> dict[str, int]:
        """As what makes the frames takes them."""
        return {"cycles": self.cycles, "frames": self.frames, "places": self.places, "points": self.end_points}


class MotionAsked(_StartAsked, _FieldsAsked):
    """Fields of a motion over time: of a steady one, or of a simulation."""

    orbit: Annotated[int, Field(ge=1, le=4096)] | None = None
    periods: Periods = 1
    show: Literal["start", "settled"] = "settled"
    window: Annotated[list[float], Field(min_length=2, max_length=2)] | None = Field(
        None, description="only this part of the fields, in rad after `begin`"
    )


class OrbitsAsked(CaseAsked):
    """What ``percuss orbits --json`` answers, of one label."""

    label: Annotated[str, Field(max_length=16, examples=["1/1"], description="p/n, chatter/n or rest/n")]
    modes: Modes = 32
    tries: Annotated[int, Field(ge=1, le=2000)] = 400
    seed: Annotated[int, Field(ge=0, lt=2**53)] = 0


class FollowAsked(CaseAsked):
    """What ``percuss follow --json`` answers."""

    along: Annotated[AlongAsked, Field(examples=[_RESTITUTION_RANGE])]
    orbit: Annotated[str, Field(max_length=2000, description="2/1:3, 2/1:phases=1.2,4.5 or chatter/1:1")] = "1/1"
    switch: Annotated[int, Field(ge=0, le=16, description="how deep to go on at flips and grazings")] = 0
    modes: Modes = 32


class DiagramAsked(CaseAsked):
    """What simulations settle on over a parameter, and all branches, as ``percuss diagram --json`` has them."""

    along: Annotated[AlongAsked, Field(examples=[_RESTITUTION_RANGE])]
    values: Annotated[int, Field(ge=2, le=400)] = 120
    starts: Annotated[int, Field(ge=0, le=32, description="random starts at each value")] = 4
    runs: Annotated[int, Field(ge=0, le=12, description="motions that are taken along the values")] = 3
    modes: Modes = 32
    impacts: Annotated[int, Field(ge=1, le=20_000)] = 2000
    up_to: Annotated[str, Field(max_length=16)] | None = Field(
        None, description="the greatest label z=p/n whose branches are traced; null for no branches"
    )
    searched: Annotated[int, Field(ge=1, le=20, description="values at which orbits are searched for")] = 5
    switch: Annotated[int, Field(ge=0, le=4, description="how deep to go on at flips and grazings")] = 1
    tries: Annotated[int, Field(ge=1, le=400, description="random starts of each search")] = 100
    seed: Annotated[int, Field(ge=0, lt=2**53)] = 0


class PointCurvesAsked(CaseAsked):
    """What happens to an orbit, followed through two parameters, as ``percuss follow --curve all --json`` has it."""

    x: Annotated[AlongAsked, Field(examples=[_RESTITUTION_RANGE])]
    y: Annotated[AlongAsked, Field(examples=[_LOAD_FACTOR])]
    orbit: Annotated[str, Field(max_length=2000, description="2/1:3, 2/1:phases=1.2,4.5 or chatter/1:2")] = "1/1"
    modes: Modes = 32


class BranchMotionAsked(_FieldsAsked):
    """Fields of an orbit over time: that near the times of impacts, or the release, that a branch has at a value."""

    name: Name
    unit: Annotated[str, Field(max_length=32)] = ""
    value: float
    times: Annotated[list[float], Field(min_length=1, max_length=64)] | None = None
    release: float | None = Field(None, description="in place of times: when a cycle with rest is let go, rad")
    periods: Annotated[int, Field(ge=1, le=256, description="load periods of a cycle")] = 1
    modes: Modes = 32


class BlowAsked(CaseAsked):
    """One blow: fields along striker and tool over time, and what ``percuss blow --json`` answers."""

    show: Literal["start", "contact", "window"] = "start"
    frames: Annotated[int, Field(ge=2, le=601)] = 181
    cells: Annotated[int, Field(ge=2, le=400, description="places along each body, about")] = 120
    whole: bool = Field(True, description="with the answer of the whole blow")


class MachineAsked(CaseAsked):
    """A machine that switches itself: a cycle over time, and what ``percuss machine --json`` answers."""

    modes: Modes | None = None
    points: Annotated[int, Field(ge=2, le=2000, description="instants of the cycle")] = 401
    whole: bool = Field(True, description="with margins, sensitivities and the curve over the pressure")


class MachineStartAsked(_StartAsked):
    """A machine that switches itself from a start: its first blows over time."""

    blows: Annotated[int, Field(ge=1, le=100, description="shown at most")] = 12
    points: Annotated[int, Field(ge=2, le=20_000, description="instants")] = 2000


class ExperimentAsked(CaseAsked):
    """Random starts, and the share of them that ends in each motion."""

    starts: Annotated[int, Field(ge=1, le=100_000)] = 1000
    distribution: Literal["wall", "field", "gentle"] = "wall"
    seed: Annotated[int, Field(ge=0, lt=2**53)] = 0
    modes: Modes | None = None
    impacts: Annotated[int, Field(ge=1, le=20_000)] | None = None


class ExperimentFileAsked(ExperimentAsked):
    """The same experiment as a file; `first` limits it to its first starts, as those of a cancelled one."""

    format: Literal["nc", "csv"] = "nc"
    first: Annotated[int, Field(ge=1, le=100_000)] | None = None


class ReportAsked(CaseAsked):
    """A report in one file."""

    periods: Annotated[list[Periods], Field(min_length=1, max_length=8)] = [1]
    modes: Modes | None = None
    simulate: bool = False
    paper: Annotated[Literal["", "a4", "letter"], Field(description='of a PDF, to print and sign; "" for HTML')] = ""
    language: Literal["en", "de", "sv"] = "en"


Lines = Annotated[list[Text], Field(max_length=16)]


class HammerAsked(CaseAsked):
    """A question about the whole hammer, in the words of the command line."""

    question: Literal["design", "tolerance", "compare", "identify", "fatigue"]
    vary: Annotated[Lines, Field(description="KEY=LOW:HIGH, or KEY=±HALF")] = []
    limits: Annotated[Lines, Field(description="FIGURE<VALUE, FIGURE>VALUE or FIGURE=LOW..HIGH")] = []
    figure: Name = "rock_power"
    greatest: bool = True
    plane: Annotated[bool, Field(description="a design with the plane of its first two ranges")] = False
    beside: Annotated[Lines, Field(description="names of machines, or KEY=VALUE, KEY=VALUE")] = []
    given: Annotated[Lines, Field(description="KEY=±HALF, of numbers that are only given")] = []
    blows: Annotated[str, Field(max_length=900_000, description="a table of measured blows, as CSV")] = ""
    hammers: Annotated[int, Field(ge=20, le=10_000)] = 600
    modes: Modes | None = None
    seed: Annotated[int, Field(ge=0, lt=2**32)] = 0


class HistoryAsked(BaseModel):
    """How a recording is read: the name of its file, and keys of [load]."""

    name: Text
    column: Text = ""
    unit: Text = ""
    time_column: Text = ""
    sample_rate: Text = ""
    opposing_column: Text = ""
    opposing_area: Text = ""
    start: Text = Field("", alias="from")
    end: Text = Field("", alias="to")
    area: Text = ""
    frequency: Text = ""
    force_scale: Text = ""
    harmonics: Annotated[int, Field(ge=1, le=1024)] | None = None
