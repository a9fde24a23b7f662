"""The table [steel]: what the steel of bar and tool bears in fatigue, by its grade or by figures of its maker."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any, Literal, NamedTuple

from percuss.case.file_format.values import CaseTable, Kind, Stress, given_in, keyed
from percuss.errors import ParameterError
from percuss.model import SizedBody
from percuss.model.checks import finite

if TYPE_CHECKING:
    from percuss.blow import Rod, Steel, Wall

Grade = Literal["42CrMo4 QT", "34CrNiMo6 QT", "30CrNiMo8 QT", "18CrNiMo7-6 carburised", "22NiCrMo12-5 carburised"]
GRADES: dict[Grade, float] = {
    "42CrMo4 QT": 900e6,
    "34CrNiMo6 QT": 1000e6,
    "30CrNiMo8 QT": 1100e6,
    "18CrNiMo7-6 carburised": 980e6,
    "22NiCrMo12-5 carburised": 1125e6,
}
"""Steels of hammers by their grades, with the least tensile strength (of the core where carburised) in Pa.

Quenched and tempered (QT) as EN 10083-3 has it for 40 to 100 mm; 18CrNiMo7-6 as DIN 17210 has it for 63 mm; drill
steel by the least hardness of the core that a maker recommends, 36 HRC, as ISO 18265 converts it.
"""
ASSUMED_GRADE: Grade = "42CrMo4 QT"


def _factors(value: Any) -> Any:
    if not isinstance(value, dict) or not all(type(one) in (int, float) for one in value.values()):
        raise ValueError('a table of factors by section, for example {"striker 1" = 1.6, "rod 0" = 2.0}')
    return {name: float(factor) for name, factor in value.items()}


class ToolSteelTable(CaseTable):
    """A steel by its grade, or by figures of its maker."""

    grade: Grade | None = None
    """The grade, which gives the tensile strength. When left out: `"42CrMo4 QT"`, or `ultimate` says it."""
    ultimate: Stress | None = None
    """Tensile strength. Allowed: greater than 0. When left out: that of `grade`."""
    fatigue_limit: Stress | None = None
    """Amplitude of stress about 0, in tension and compression, that a polished rod bears for ever. Allowed: greater
    than 0, below the tensile strength. When left out: it is 0.40 of the tensile strength."""
    slope: float | None = None
    """Slope $k$ of the S–N line above this limit, life ∝ 1/amplitude$^k$. Allowed: 1 or greater. When left out: that of
    the line from 0.75 of the tensile strength at 1000 cycles."""
    knee: float | None = None
    """Cycles at which the line reaches the limit. Allowed: more than 1000. When left out: a million."""


class SteelTable(ToolSteelTable):
    """The steel of bar and tool."""

    notch: Annotated[dict[str, float], Kind("table of numbers", _factors)] | None = None
    """Fatigue notch factors by section, as `percuss blow` names them: `{"striker 1" = 1.6, "rod 0" = 2.0}`. Allowed:
    none below 1. When left out: every section counts as smooth, as any does that is not named."""
    tool: ToolSteelTable | None = None
    """Another steel of the tool. When left out: that of the bar."""


class CaseSteel(NamedTuple):
    """The steels of bar and tool, what they are called, and the notch factors by section."""

    steel: Steel
    tool: Steel
    name: str
    tool_name: str
    notches: dict[str, float]


def steel_of(table: SteelTable | None, bar: SizedBody, target: Rod | Wall) -> CaseSteel:
    """What the table [steel] says, or what holds without it."""
    from percuss.blow import Rod

    own = SteelTable() if table is None else table
    steel = _steel(own)
    with keyed("tool."):
        tool = steel if own.tool is None else _steel(own.tool)
    rod = target.pieces if isinstance(target, Rod) else ()
    names = [f"{body} {i}" for body, pieces in (("striker", bar.pieces), ("rod", rod)) for i in range(len(pieces))]
    for name, factor in (own.notch or {}).items():
        if name not in names:
            raise ParameterError("notch", name, f"sections that there are: {', '.join(names)}")
        if not finite("notch", factor) >= 1.0:
            raise ParameterError("notch", factor, "factors of at least 1")
    return CaseSteel(steel, tool, _name(own), _name(own.tool or own), dict(own.notch or {}))


def _steel(table: ToolSteelTable) -> Steel:
    from percuss.blow import Steel

    if table.grade is not None and table.ultimate is not None:
        raise ParameterError("ultimate", table.ultimate, "either a grade or a tensile strength, not both")
    figures = {key: value for key, value in given_in(table).items() if key not in ("grade", "notch", "tool")}
    return Steel(**{"ultimate": GRADES[table.grade or ASSUMED_GRADE]} | figures)


def _name(table: ToolSteelTable) -> str:
    return table.grade or (ASSUMED_GRADE if table.ultimate is None else "of the case")
