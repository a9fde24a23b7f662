"""The dimensionless form of a case file: the SI form with plain numbers for text with a unit, made when needed."""

from __future__ import annotations

from types import UnionType
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal, TypeVar, Union, get_args, get_origin

from pydantic import Field, Tag

from percuss.case.file_format.bodies import BodyTable, SystemTable
from percuss.case.file_format.contact import BlowTable, ToolTable
from percuss.case.file_format.loads import AnyLoad, HistoryLoad
from percuss.case.file_format.schema import StruckCase
from percuss.case.file_format.start_and_simulation import SimulationTable, StartTable
from percuss.case.file_format.values import CaseTable, Force, Kind, PlainNumber, hints_of
from percuss.errors import ParameterError
from percuss.model import SteppedBar
from percuss.model.body import Body
from percuss.model.checks import positive

if TYPE_CHECKING:
    from percuss.blow import Rod, Wall


class PlainTool(CaseTable):
    """What the bar of a dimensionless case strikes: a wall, or an endless rod known by its impedance alone."""

    is_plain = True

    kind: Literal["rod", "wall"] | None = None
    """A rod, or a rigid wall. When left out: `"rod"`."""
    impedance: PlainNumber | None = None
    """Impedance of the endless rod, divided by that of the bar's last section. Allowed: greater than 0. When left out:
    only a wall has none."""
    gap: PlainNumber | None = None
    """Distance between the striking end and the struck face when the blow begins, in bar lengths. Allowed: 0 or
    greater. When left out: 0."""


def plain_target(tool: PlainTool | None, body: Body) -> Rod | Wall:
    """What a dimensionless body strikes; without a table [tool] a rigid wall."""
    from percuss.blow import Rod, Wall

    if tool is None:
        return Wall()
    gap = 0.0 if tool.gap is None else tool.gap
    if tool.kind == "wall":
        if tool.impedance is not None:
            raise ParameterError("impedance", tool.impedance, "no impedance of a wall", 'a rod has kind = "rod"')
        return Wall(gap)
    if tool.impedance is None:
        raise ParameterError("impedance", None, 'the impedance of the endless rod, or kind = "wall"')
    own = float(body.sections.impedance[-1]) if isinstance(body, SteppedBar) else body.s
    return Rod.of_impedance(positive("impedance", tool.impedance) * own, gap=gap)


class PlainHistoryLoad(HistoryLoad):
    """A recording beside a dimensionless system: `force_scale` is the force that counts as p = 1."""

    is_plain = True

    force_scale: Force
    """The force that counts as $p = 1$. Allowed: greater than 0."""


_PLAIN: dict[type[CaseTable], type[CaseTable]] = {ToolTable: PlainTool, HistoryLoad: PlainHistoryLoad}
"""The plain forms: those that do not follow from the SI form, and those that were made."""


def plain_form(table: type[CaseTable]) -> type[CaseTable]:
    """A subclass of a table with plain numbers for quantities, None for what only SI has; or the table itself."""
    if table not in _PLAIN:
        hints = hints_of(table)
        kept = {name: _plain_of(hint) for name, hint in hints.items() if table.in_plain.get(name, "") is not None}
        gone = {name: ClassVar[None] for name in hints.keys() - kept.keys()}
        if not gone and all(kept[name] == hints[name] for name in kept):
            _PLAIN[table] = table
            return table
        fields = table.model_fields
        content: dict[str, Any] = {
            name: Field(own.default, alias=own.alias) for name in kept if not (own := fields[name]).is_required()
        }
        about = (table.__doc__ or "").partition("\n")[0].removesuffix(".")
        content |= {"__annotations__": kept | gone, "__module__": table.__module__, "is_plain": True}
        content |= {"__doc__": f"{about}, in plain numbers.", "__reduce__": _reduced, **dict.fromkeys(gone)}
        _PLAIN[table] = type(f"Plain{table.__name__.removesuffix('Table')}", (table,), content)
    return _PLAIN[table]


def _reduced(table: CaseTable) -> tuple[Any, ...]:
    """A table of a form that is made here goes to other processes by the one that it is made from."""
    return _blank, (type(table).__bases__[0],), table.__getstate__()


def _blank(table: type[CaseTable]) -> CaseTable:
    form = plain_form(table)
    return form.__new__(form)


def _plain_of(hint: Any) -> Any:
    """What an annotation of the SI form is in the dimensionless one."""
    if isinstance(hint, type) and issubclass(hint, CaseTable):
        return plain_form(hint)
    origin, parts = get_origin(hint), get_args(hint)
    if origin is Annotated:
        plain = next((part.plain for part in parts[1:] if isinstance(part, Kind) and part.plain is not None), None)
        kept = parts[1:] if plain is None else tuple(part for part in parts[1:] if isinstance(part, Tag))
        plain = _plain_of(parts[0]) if plain is None else plain
        return Annotated[(plain, *kept)] if kept else plain
    if origin in (Union, UnionType):
        return Union[tuple(map(_plain_of, parts))]  # noqa: UP007  # of so many
    if origin is dict:
        return dict.__class_getitem__((parts[0], _plain_of(parts[1])))
    if origin is tuple and parts[1:] == (...,):
        return tuple.__class_getitem__((_plain_of(parts[0]), ...))
    return hint


if TYPE_CHECKING:
    T = TypeVar("T")
    PlainOf = Annotated[T, "plain"]
else:

    class PlainOf:
        """``PlainOf[hint]`` is the plain form of the hint."""

        def __class_getitem__(cls, hint: Any) -> Any:
            return _plain_of(hint)


class PlainCase(StruckCase):
    """The dimensionless form: [system], [load], what the bar strikes, and what a simulation takes."""

    struck_name = "system"

    title: str | None = None
    system: SystemTable
    body: PlainOf[BodyTable] | None = None
    load: PlainOf[AnyLoad] | None = None
    tool: PlainTool | None = None
    blow: PlainOf[BlowTable] | None = None
    start: PlainOf[StartTable] | None = None
    simulation: PlainOf[SimulationTable] | None = None
