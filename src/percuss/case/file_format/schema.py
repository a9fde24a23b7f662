"""What a case file may say: one pydantic model for every table of the SI form; the dimensionless one follows from it.

The models keep what the file says (SI quantities as text with their units), so that a case can be written back as it
was read; each table stands beside what is made of it, and `percuss.case.file_format.building` makes the whole. A new
table is a new optional field of both cases. The text below a key is what the reference prints.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from typing import Any, ClassVar, get_args

from pydantic import Field

from percuss.case.file_format.bodies import BarTable, BodyTable, SystemTable
from percuss.case.file_format.contact import BlowTable, ContactTable, DrillingTable, FeedTable, RockTable, ToolTable
from percuss.case.file_format.loads import AnyLoad
from percuss.case.file_format.start_and_simulation import SimulationTable, StartTable
from percuss.case.file_format.steel import SteelTable
from percuss.case.file_format.values import CaseTable, hints_of, keys_of, tables_in
from percuss.errors import did_you_mean


class StruckCase(CaseTable):
    """Tables of which one says how the bar leaves the wall."""

    struck_name: ClassVar[str]

    @property
    def struck(self) -> ContactTable | SystemTable | None:
        """That table; None where a case describes one blow."""
        found: ContactTable | SystemTable | None = getattr(self, self.struck_name)
        return found


class PhysicalCase(StruckCase):
    """The SI form: [bar], [load], [contact], what the bar strikes, and what a simulation takes."""

    struck_name = "contact"

    title: str | None = None
    """Free text."""
    bar: BarTable = Field(default_factory=BarTable)
    body: BodyTable | None = None
    load: AnyLoad | None = None
    contact: ContactTable | None = None
    tool: ToolTable | None = None
    feed: FeedTable | None = None
    rock: RockTable | None = None
    blow: BlowTable | None = None
    drilling: DrillingTable | None = None
    steel: SteelTable | None = None
    start: StartTable | None = None
    simulation: SimulationTable | None = None


def missing_tables(form: type[CaseTable], data: Mapping[str, Any]) -> list[str]:
    """The tables that a file lacks though it describes no blow, for which [load] and [contact] may be absent."""
    missing: list[str] = [name for name in ("load", "contact") if name in form.model_fields and name not in data]
    if missing == ["load"] and "body" in data:
        return missing
    if missing and any(name in data or did_you_mean(name, data) for name in ("tool", "rock", "blow")):
        return []
    return missing


@cache
def table_fields(form: type[CaseTable], kind: str | None) -> dict[str, list[str]]:
    """The keys that every table of a form takes, for a load of the given kind; '' is the top of the file."""
    found = {"": keys_of(form)}

    def add(place: str, hint: Any) -> None:
        tables = tables_in(hint)
        if place == "load":
            tables = [table for table in tables if kind in get_args(table.model_fields["kind"].annotation)]
            found[place] = ["kind"]
        for table in tables:
            found[place] = keys_of(table)
            for key, inner in zip(found[place], hints_of(table).values(), strict=True):
                add(f"{place}.{key}", inner)

    for name, hint in hints_of(form).items():
        add(name, hint)
    return found
