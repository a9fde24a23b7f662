"""What a case file may say: one pydantic model for every table of the SI form; the dimensionless one follows from it.

The models keep what the file says (SI quantities as text with their units), so that a case can be written back as it
was read; `percuss.case.file_format.building` makes the objects. The loads have a file of their own, and so have the
tables of bodies; a new table is a new optional field of both cases. The text below a key is what the reference prints.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from typing import Any, ClassVar, Literal, get_args

from pydantic import Field

from percuss.case.file_format.body_tables import (
    BarDamping,
    BlowTable,
    BodyTable,
    RockTable,
    SectionTables,
    SystemDamping,
    ToolTable,
)
from percuss.case.file_format.load_tables import AnyLoad
from percuss.case.file_format.values import (
    Area,
    CaseTable,
    Density,
    Drag,
    Length,
    NumberOrLength,
    NumberOrTime,
    NumberOrVelocity,
    Numbers,
    Restitution,
    Stress,
    hints_of,
    keys_of,
    tables_in,
)
from percuss.errors import did_you_mean

Strain = Literal["kept", "reversed"]
"""The contact laws by what they do to the strain."""

Law = Literal["b77", "b77-tau", "b77-blow"]
"""The laws of a blow: what is known of its restitution, its duration and its advance."""

Advance = Literal["kept", "pushed back", "residual penetration"]
"""How far the face of the tool is from one blow to the next."""


class BarTable(CaseTable):
    """The bar of a case in SI, uniform or of sections."""

    length: Length | None = None
    """Length from the driven to the striking end. Allowed: greater than 0. When left out: `sections` are needed."""
    area: Area | None = None
    """Area of the cross-section. Allowed: greater than 0. When left out: `diameter` is needed."""
    diameter: Length | None = None
    """Diameter of a solid round bar. Allowed: greater than 0. When left out: `area` is needed."""
    sections: SectionTables | None = None
    """Sections from the driven to the striking end, instead of `length`, `area` and `diameter`, see below. Allowed: up
    to 200 of them. When left out: the bar is uniform."""
    youngs_modulus: Stress | None = None
    """Young's modulus of the material. Allowed: greater than 0. When left out: steel, `"210 GPa"`."""
    density: Density | None = None
    """Density of the material. Allowed: greater than 0. When left out: steel, `"7850 kg/m^3"`."""
    damping_ratio: float | None = None
    """The damping as a share of the critical damping, the same for every elastic mode; the bar as a whole moves freely.
    Allowed: 0 to 1. When left out: 0.001, unless `damping` or `drag` says otherwise."""
    damping: BarDamping | None = None
    """The damping by another law, `{kind = "…", value = …}`, see below. When left out: `damping_ratio` holds."""
    drag: Drag | None = None
    """The damping as a force per velocity and per metre of bar, which brakes the bar as a whole, too. Allowed: 0 or
    greater. When left out: `damping_ratio` holds."""


class ContactTable(CaseTable):
    """How the bar leaves the wall."""

    restitution: Restitution | None = None
    """Coefficient of restitution, or `"from the blow"`: that of the blow on the tool, resolved by waves. Allowed: 0 to
    1. When left out: `receiving_area` is needed, or the law of the blow."""
    receiving_area: Area | None = None
    """Cross-section of a long rod of the same material that is struck. Allowed: at least that of the bar. When left
    out: `restitution` is needed."""
    strain: Strain | None = None
    """What the impact does to the strain in the bar: keep it, or turn it over together with the velocity, as the waves
    in a uniform bar do. When left out: `"reversed"`, but `"kept"` for a bar that is not uniform."""
    law: Law | None = None
    """What is known of the blow: B77's impact takes no time; `"b77-tau"` adds the time that a uniform bar is in
    contact; `"b77-blow"` takes restitution, duration and advance from one blow resolved by waves. When left out:
    `"b77"`."""
    advance: Advance | None = None
    """With a law that knows the duration: the tool keeps the advance that a blow gives it, is pushed back, or advances
    by what the rock does not give back. When left out: `"kept"`, but `"residual penetration"` of a tool on rock and
    `"pushed back"` of others that have an end."""


class SystemTable(CaseTable):
    """A dimensionless bar and its contact."""

    s: float | None = None
    r"""Wave speed $C/(L\Omega)$. Allowed: greater than 0. When left out: the case needs a table `[body]`."""
    d: float | None = None
    r"""External damping $D/(M\Omega)$, which brakes the bar as a whole, too. Allowed: 0 or greater. When left out:
    `damping` is needed, or `impedances`, beside which it is 0."""
    restitution: Restitution
    """Coefficient of restitution, or `"from the blow"`: that of the blow on the tool, resolved by waves. Allowed: 0 to
    1."""
    damping: SystemDamping | None = None
    """The damping by another law, `{kind = "…", value = …}`, see below; `d` is 0 or left out beside it. When left
    out: `d` holds."""
    impedances: Numbers | None = None
    """Impedances of the sections of a stepped bar from the driven to the striking end, in any one unit. Allowed:
    positive, up to 200 of them. When left out: the bar is uniform."""
    transit_times: Numbers | None = None
    """Times that a wave takes through these sections, in any one unit: together they count as 1/s. Allowed: positive,
    as many as `impedances`. When left out: the bar is uniform."""
    strain: Strain | None = None
    """What the impact does to the strain in the bar: keep it (B77), or turn it over together with the velocity, as the
    waves in a uniform bar do. When left out: `"kept"`."""
    law: Law | None = None
    """What is known of the blow, as in `[contact]`. When left out: `"b77"`."""
    advance: Advance | None = None
    """How far the tool advances from blow to blow, as in `[contact]`. When left out: `"kept"`, but
    `"pushed back"` of a wall."""


class StartTable(CaseTable):
    """Where a simulation starts: rigid, modal, on a steady motion, or drawn; in SI with units, or in plain numbers."""

    position: NumberOrLength | None = None
    """Rigid: position of the bar. With `orbit`, added to that motion, and 0 unless given. Allowed: 0 (on the wall) or
    less. When left out: −1, and 0 with a load of the kind `"valve"`."""
    velocity: NumberOrVelocity | None = None
    """Rigid: velocity of the bar, positive toward the wall. With `orbit`, added to that motion. When left out: 0."""
    time: NumberOrTime | None = None
    """Load phase at the start, in radians; not allowed with `orbit`, and for a valve, which starts at 0. When left out:
    0."""
    modal_displacement: Numbers | None = None
    r"""Modal: $u_0, u_1, \dots$, where $u(x) = u_0 + 2\sum u_n\cos n\pi x$. With `orbit`, added to that
    motion. When left out: 0."""
    modal_velocity: Numbers | None = None
    r"""Modal: $u_0', u_1', \dots$. With `orbit`, added to that motion. When left out: 0."""
    orbit: int | None = None
    """Just after the impact of this steady motion, numbered as `percuss steady` does. Allowed: 1 or greater."""
    periods: int | None = None
    """With `orbit`: load periods per impact of that motion. Allowed: 1 or greater. When left out: 1."""
    random: Literal["rigid", "still", "ringing"] | None = None
    """A random start: undeformed, undeformed and at rest, or with ringing modes."""
    seed: int | None = None
    """With `random`; the same seed gives the same start. Allowed: 0 or greater. When left out: 0."""


class SimulationTable(CaseTable):
    """How a simulation is made and when it ends; times with a unit, or in radians of the load's fundamental."""

    modes: int | None = None
    """Elastic modes; 0 is a rigid bar. Allowed: 0 to 4096. When left out: 32."""
    impacts: int | None = None
    """End after this many impacts. Allowed: 0 to 1e9. When left out: 2000, or a million with `time`."""
    time: NumberOrTime | None = None
    """End after this time from the start, in radians, or in the unit of time that a dimensionless valve has. Allowed:
    greater than 0. When left out: `impacts` decides."""
    periodic: bool | None = None
    """Whether to end when a periodic motion is found. When left out: true."""
    tolerance: float | None = None
    """How closely a state must return to count as the same. Allowed: 1e-13 to 0.1. When left out: 1e-9."""


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
    rock: RockTable | None = None
    blow: BlowTable | None = None
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
            for key, inner in hints_of(table).items():
                add(f"{place}.{key}", inner)

    for name, hint in hints_of(form).items():
        add(name, hint)
    return found
