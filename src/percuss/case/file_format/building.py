"""From the tables of a case to the objects of the model, with every refusal translated to its key.

Laws are refused by a `ParameterError` with the key of their table, which `Parts` gathers as one `CaseError`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pydantic import BaseModel

from percuss.case.file_format.body_building import (
    NO_BIT,
    BlowQuestion,
    blow_question,
    check_beside,
    held_body,
    plain_body,
    plain_target,
    rock_of,
    sized_body,
    sized_target,
)
from percuss.case.file_format.load_building import ReadHistory, history_load, load_of, pressure_of, valve_of
from percuss.case.file_format.load_tables import HistoryLoad, ValveLoad
from percuss.case.file_format.reading import from_parameter, raise_all, without_blow
from percuss.case.file_format.schema import ContactTable, PhysicalCase, SystemTable
from percuss.case.file_format.start_and_simulation import checked_simulation, checked_start
from percuss.case.file_format.values import FROM_THE_BLOW
from percuss.errors import CaseError, ParameterError
from percuss.model import Contact, Kept, Load, Machine, Reversed, SizedBody, System, UniformBar, Valve
from percuss.model.body import Body
from percuss.model.contact import LAWS, Timed
from percuss.units import si

if TYPE_CHECKING:
    from percuss.blow import EffectiveBlow, Rod, Wall
    from percuss.case.file_format.plain_form import PlainCase


# ---- From the tables [contact] and [system] of a case to the law of the contact, as far as no blow is resolved for it


def contact_of(table: ContactTable | SystemTable, bar: SizedBody | None, tool: bool) -> Contact | None:
    """The law of the contact; None where it depends on a bar that could not be made, or on the blow.

    `tool` tells whether the case says what the bar strikes.
    """
    area = getattr(table, "receiving_area", None)
    if area is not None and table.restitution is not None:
        raise ParameterError("receiving_area", area, "either restitution or receiving_area, not both")
    _check_law(table, tool or area is not None)
    if table.law == "b77-blow" or table.restitution == FROM_THE_BLOW:
        return None
    law = law_of(table, bar)
    if area is not None:
        receiving = si(area, "area", "receiving_area")
        return None if bar is None else law(receiving_area=receiving, area=bar.pieces[-1].area)
    if table.restitution is None:
        remedy = f'that of the blow on the tool is restitution = "{FROM_THE_BLOW}"' if tool else ""
        raise ParameterError("restitution", None, "a restitution from 0 to 1, or a receiving_area", remedy)
    assert not isinstance(table.restitution, str)
    return law(table.restitution)


def law_of(table: ContactTable | SystemTable, bar: SizedBody | None) -> type[Contact]:
    """The law that the table names; else B77's, but in SI what the waves in a uniform bar do."""
    if table.strain is not None:
        return LAWS[table.strain]
    uniform = isinstance(table, ContactTable) and (bar is None or bar.kind == UniformBar.kind)
    return Reversed if uniform else Kept


def check_body(table: ContactTable | SystemTable, law: type[Contact], body: Body) -> None:
    """Refuse a body that the laws of the table do not hold for."""
    law(0.0).check(body)
    if table.law == "b77-tau" and not body.is_harmonic:
        remedy = 'take law = "b77-blow", which holds for any bar'
        raise ParameterError("law", table.law, "a uniform bar for the law b77-tau", remedy)


def _check_law(table: ContactTable | SystemTable, target: bool) -> None:
    """Refuse a law of the blow that lacks what it is made of; `target` tells whether the case says what is struck."""
    given = table.restitution
    if table.advance is not None and table.law in (None, "b77"):
        remedy = 'take it away, or write law = "b77-tau" or "b77-blow"'
        raise ParameterError("advance", table.advance, "a law that knows the duration of the blow beside it", remedy)
    if table.law == "b77-blow" and given not in (None, FROM_THE_BLOW):
        accepted = "no number beside the law b77-blow, which takes it from the blow"
        remedy = f'write restitution = "{FROM_THE_BLOW}", or take law = "b77" for a number'
        raise ParameterError("restitution", given, accepted, remedy)
    if not target and (table.law == "b77-blow" or given == FROM_THE_BLOW):
        key, remedy = ("law" if table.law == "b77-blow" else "restitution"), 'a rigid wall is kind = "wall" in [tool]'
        raise ParameterError(key, getattr(table, key), "a table [tool] that says what the bar strikes", remedy)


# ---- The contact of a case by one blow resolved by waves: its restitution, its duration, how far the tool moves on

_SPENT = 1e-9
"""A restitution that is as good as 0: the bar has given its momentum away."""

_FORWARD = (
    "a bar of greater impedance than the tool's goes on after the blow and presses or strikes it again and again, in "
    "steps that on an endless tool never end: make the tool "
    "thicker or the bar thinner, or give a number from 0 to 1"
)


def blow_of(question: BlowQuestion) -> EffectiveBlow:
    """The blow of a bar on its tool, without a load; one that was computed before is remembered.

    Its contacts and its restitution do not depend on the speed, unless there is a gap in front of the rock. The window
    ends with `until`, where that is given.
    """
    from percuss.blow import effective_blow

    rock = getattr(question.target, "rock", None)
    velocity = 1.0 if rock is None or rock.gap == 0.0 else question.velocity
    if not isinstance(velocity, float):
        remedy = 'for example velocity = "10 m/s"; without the gap one blow serves all speeds'
        accepted = "a velocity in [blow] beside the gap of [rock], as the blow depends on its speed"
        raise ParameterError("restitution", None, accepted, remedy)
    found = effective_blow(question.striker, question.target, velocity, until=question.until)
    if not found.contacts:
        remedy = "check the gap of [tool] and until in [blow]"
        raise ParameterError("restitution", None, "a blow of a bar that reaches the tool", remedy)
    return found


def restitution_of(question: BlowQuestion) -> float:
    """The restitution of a blow as B77's law takes it."""
    from percuss.blow import BlowOutcome

    blow = blow_of(question)
    if abs(blow.restitution) <= _SPENT:
        return 0.0
    usual = 0.0 <= blow.restitution <= 1.0
    if not usual and blow.outcome is BlowOutcome.STILL_IN_CONTACT and question.until is None:
        accepted = f"a blow with a restitution from 0 to 1; on this tool R is {blow.restitution:.4g} so far"
        raise ParameterError("restitution", None, accepted, _FORWARD)
    if blow.outcome in (BlowOutcome.STILL_IN_CONTACT, BlowOutcome.GAP_CLOSING):
        accepted = f"a blow that is over; {blow.outcome.value}"
        raise ParameterError("restitution", None, accepted, "give a later end: until in [blow]")
    if not usual:
        accepted = f"a blow with a restitution from 0 to 1; that on this tool has R = {blow.restitution:.4g}"
        raise ParameterError("restitution", None, accepted, _FORWARD)
    return blow.restitution


def blow_note(blow: EffectiveBlow, question: BlowQuestion) -> str:
    """What is to be known of a restitution that is that of a blow, one sentence."""
    several = "one contact" if blow.contacts == 1 else f"{blow.contacts} contacts"
    share = f"{100.0 * blow.ringing:.2g} % of the energy stays in the bar as ringing"
    text = f"R = {blow.restitution:.4g} is that of the blow on the tool, resolved by waves: {several}; {share}"
    rock = getattr(question.target, "rock", None)
    if rock is None or rock.gap == 0.0:
        return text
    return f"{text}; it is that of the velocity in [blow], as the gap in front of the rock makes it depend on the speed"


def law_note(table: ContactTable | SystemTable | None) -> str:
    """Where a law of blows that take time counts and where it does not, one sentence; "" without one."""
    if table is None or table.law in (None, "b77"):
        return ""
    return (
        f"law {table.law}: steady motions have its phases and multipliers beside those of B77's impact; simulations, "
        "maps and boundaries have B77's impact with the same restitution"
    )


def timed_law(table: ContactTable | SystemTable, question: BlowQuestion, system: System) -> Timed | None:
    """The law of a blow that takes time, as the table names it; None for B77's."""
    if table.law == "b77-tau":
        advance = table.advance or "kept"
        if advance == "residual penetration":
            raise ParameterError("advance", advance, '"kept" or "pushed back" beside the law b77-tau', _LAW_OF_ROCK)
        return Timed.of_uniform_bar(system.s, system.restitution, advance)
    if table.law != "b77-blow":
        return None
    blow = blow_of(question)
    if blow.duration is None or blow.centroid is None:
        accepted = f"a contact that ends; here {blow.outcome.value}"
        raise ParameterError("law", table.law, accepted, _FORWARD)
    time = 1.0 if system.bar is None else system.time_scale
    law = Timed(
        restitution_of(question),
        blow.duration / time,
        min(blow.centroid, blow.duration) / time,
        ringing_share=min(blow.ringing, 1.0),
        contacts=blow.contacts,
    )
    return replace(law, advance_per_impulse=_advance(table, question.target, blow) / time / law.impulse(1.0, 0.0))


_LAW_OF_ROCK = 'the penetration is known to law = "b77-blow"'


def _advance(table: ContactTable | SystemTable, target: Rod | Wall, blow: EffectiveBlow) -> float:
    """Advance of the tool per speed of the bar, in the unit of time of the blow."""
    from percuss.blow import Wall

    end = "wall" if isinstance(target, Wall) else target.end
    usual = {"rock": "residual penetration", "infinite": "kept"}.get(end, "pushed back")
    advance = table.advance or usual
    if advance not in (usual, "pushed back"):
        where = {"wall": "a wall", "rock": "a rod on rock", "infinite": "an endless rod"}
        accepted = f'"{usual}"' if usual == "pushed back" else f'"{usual}" or "pushed back"'
        raise ParameterError("advance", advance, f"{accepted} of {where.get(end, f'a rod with a {end} end')}")
    return 0.0 if advance == "pushed back" else blow.advance


# ---- From the tables of a case to the objects of the model, with every refusal translated to its key


class Parts:
    """The objects behind the tables of a case, as far as they can be made without reading a recording."""

    def __init__(self, tables: PhysicalCase | PlainCase, file: str, folder: Path = Path(".")) -> None:
        self.bar: SizedBody | None = None
        self.body: Body | None = None
        self.contact: Contact | None = None
        self.load: Load | None = None
        self.valve: Valve | None = None
        self.target: Rod | Wall | None = None
        self.blow: BlowQuestion | None = None
        self._problems: list[CaseError] = []
        self._file = file
        if self._make_striker(tables, folder) and tables.struck is not None:
            make = partial(contact_of, bar=self.bar, tool=tables.tool is not None)
            self.contact = self._try(tables.struck_name, tables.struck, make)
        if isinstance(tables.load, ValveLoad):
            self.valve = self._try("load", tables.load, valve_of)
        elif tables.load is not None and not isinstance(tables.load, HistoryLoad):
            self.load = self._try("load", tables.load, load_of)
        self._check_fit(tables)
        self._look_at_blow(tables)
        if tables.start is not None:
            self._try("start", tables.start, checked_start)
        if tables.simulation is not None:
            self._try("simulation", tables.simulation, checked_simulation)
        if self._problems:
            raise_all(self._problems)

    def _make_striker(self, tables: PhysicalCase | PlainCase, folder: Path) -> bool:
        """The body, in SI or not; whether what the contact needs of it can be told."""
        found: tuple[str, object, str, str] | None = None  # what is wrong with the tables as a whole
        make: Callable[..., SizedBody | Body]
        if tables.body is not None:
            name, make = "body", partial(held_body, tables=tables, folder=folder)
            if (unfit := check_beside(tables)) is not None:
                place, key, accepted = unfit
                held = getattr(getattr(tables, place), key) if key else None
                found = f"{place}.{key}" if key else place, held, f"expected {accepted}", ""
        elif isinstance(tables, PhysicalCase):
            name, make = "bar", sized_body
            if tables.bar.length is None and tables.bar.sections is None:
                remedy = 'give it with its unit, for example length = "341 mm", or give sections'
                self._problems.append(CaseError(self._file, "bar.length", None, "missing", remedy))
                return True
        else:
            name, make = "system", plain_body
            if tables.system.s is None:
                found = "system.s", None, "missing", "add it, or a table [body] for a structure that is held"
            elif not _says_its_damping(tables.system):
                remedy = 'add it, or a law of damping: damping = {kind = "ratio", value = 0.001}'
                found = "system.d", None, "missing", remedy
        if found is not None:
            self._problems.append(CaseError(self._file, *found))
            return False
        body = self._try(name, getattr(tables, name), make)
        if isinstance(tables, PhysicalCase):
            self.bar = body
        else:
            self.body = body
        return True

    def _look_at_blow(self, tables: PhysicalCase | PlainCase) -> None:
        """What the bar strikes, and the blow that is asked for."""
        striker = self.bar or self.body
        if striker is None or tables.body is not None:
            return
        if isinstance(striker, SizedBody):
            assert isinstance(tables, PhysicalCase)
            self._target_in_si(tables, striker)
        else:
            self.target = self._try("tool", tables.tool, lambda table: plain_target(table, striker))
        if self.target is not None:
            self.blow = self._try("blow", tables.blow, lambda table: blow_question(table, striker, self.target))

    def _target_in_si(self, tables: PhysicalCase, bar: SizedBody) -> None:
        before = len(self._problems)
        rock = None if tables.rock is None else self._try("rock", tables.rock, rock_of)
        if tables.rock is not None and tables.tool is None:
            accepted = "expected a table [tool] beside it: what the bar strikes, with the rock at its end"
            self._problems.append(CaseError(self._file, "rock", None, accepted, NO_BIT))
        if len(self._problems) == before:
            make = partial(sized_target, rock=rock, contact=tables.contact, bar=bar)
            self.target = self._try("tool", tables.tool, make)

    def _check_fit(self, tables: PhysicalCase | PlainCase) -> None:
        """Whether the body takes the law of the contact, and the load at its place."""
        body = self.body
        if self.bar is not None:  # the load, and so the time that counts as 1, may be unknown yet
            body = _some_body(self.bar)
        if body is None:
            return
        if tables.struck is not None:
            law = law_of(tables.struck, self.bar)
            self._try(tables.struck_name, tables.struck, lambda table: check_body(table, law, body))
        if (self.load, self.valve) != (None, None) or isinstance(tables.load, HistoryLoad):
            self._try("load", tables.load, lambda table: body.place(table.at))

    def contact_of_blow(self, tables: PhysicalCase | PlainCase) -> Contact:
        """The contact whose restitution is that of the blow, which is resolved by waves."""
        assert tables.struck is not None
        law = law_of(tables.struck, self.bar)
        found: Contact = self._of_blow(tables, lambda _, question: law(restitution_of(question)))
        return found

    def timed(self, tables: PhysicalCase | PlainCase, system: System) -> Timed | None:
        """The law of a blow that takes time, where the case names one."""
        found: Timed | None = self._of_blow(tables, partial(timed_law, system=system))
        return found

    def _of_blow(self, tables: PhysicalCase | PlainCase, make: Any) -> Any:
        found = self._try(tables.struck_name, tables.struck, lambda own: make(own, self.blow))
        if self._problems:
            raise_all(self._problems)
        return found

    def _try(self, name: str, table: BaseModel | None, make: Any) -> Any:
        try:
            return make(table)
        except ParameterError as error:
            given = {} if table is None else table.model_dump(by_alias=True)
            self._problems.append(from_parameter(error, self._file, name, given))
        except ArithmeticError:
            self._problems.append(extreme(self._file, name))
        return None


def _says_its_damping(table: SystemTable) -> bool:
    """Whether the damping is given, or the bar is stepped: then it has none unless it is given."""
    return (table.d, table.damping, table.impedances, table.transit_times) != (None, None, None, None)


def _some_body(bar: SizedBody) -> Body | None:
    """The body under a load that takes as long as a wave from end to end; None when that is out of scale."""
    try:
        return bar.body(1.0 / bar.transit_time)
    except (ParameterError, ArithmeticError):
        return None


def recording_of(tables: PhysicalCase | PlainCase, file: str, folder: Path) -> ReadHistory | None:
    """The load of the recording that a case names, or None when its load is a formula."""
    return history_load(tables.load, file, folder) if isinstance(tables.load, HistoryLoad) else None


def check_motion(tables: PhysicalCase | PlainCase, file: str) -> None:
    """Refuse a case that describes one blow and no load or contact, when a motion is asked for."""
    missing = [name for name in ("load", "contact") if getattr(tables, name, ...) is None]
    if missing:
        raise_all([without_blow(file, name) for name in missing])


def system_of(tables: PhysicalCase | PlainCase, parts: Parts, load: Load, file: str) -> System:
    """The system of a case."""
    contact = parts.contact or parts.contact_of_blow(tables)
    try:
        if parts.bar is None:
            assert parts.body is not None
            system = System(parts.body, load, contact)
        else:
            system = System.from_si(parts.bar, load, contact)
    except ParameterError as error:
        if error.name in _MEANING:
            raise _out_of_scale(error, tables, file) from None
        raise from_parameter(error, file, "load", {}) from None
    except ArithmeticError:
        raise extreme(file, "") from None
    return system


_MEANING = {
    "s": "the wave speed C/(LΩ) is s",
    "d": "the damping D/(MΩ) is d",
    "eta": "the damping ηΩ",
    "load": "the load P/(M L² Ω²)",
}
"""What of a system may be out of scale, by the name that the model has for it."""


def _out_of_scale(error: ParameterError, tables: PhysicalCase | PlainCase, file: str) -> CaseError:
    """A dimensionless number that no hammer has, told in the words of the case."""
    if not isinstance(tables, PhysicalCase):
        key = "load" if error.name == "load" else f"system.{error.name}"
        return CaseError(file, key, error.value, f"expected {error.accepted}", "check the scales")
    remedy = "check the units of length, frequency, damping and force"
    return CaseError(file, _MEANING[error.name], error.value, f"expected {error.accepted}", remedy)


def extreme(file: str, key: str) -> CaseError:
    """The problem of a case whose numbers cannot be computed with."""
    return CaseError(file, key, None, "sizes so large or small that numbers overflow", "check the units")


# ---- A case whose load the piston switches has a machine in place of a system


def check_clock(tables: PhysicalCase | PlainCase, file: str) -> None:
    """Refuse a machine that switches itself, where a load that keeps time by itself is asked for."""
    check_motion(tables, file)
    if isinstance(tables.load, ValveLoad):
        remedy = "'percuss machine' answers for a valve that the piston switches, and 'percuss simulate' from a start"
        raise CaseError(file, "load.kind", "valve", "expected a load that keeps time by itself", remedy)


def machine_of(tables: PhysicalCase | PlainCase, parts: Parts, file: str) -> Machine:
    """The machine of a case whose load the piston switches."""
    check_motion(tables, file)
    table = tables.load
    if not isinstance(table, ValveLoad):
        assert table is not None
        remedy = "describe the valve by its states and ports; 'percuss steady' answers for a load that keeps time"
        raise CaseError(file, "load.kind", table.kind, "expected 'valve', a load that the piston switches", remedy)
    assert parts.valve is not None
    contact = parts.contact or parts.contact_of_blow(tables)
    try:
        if parts.bar is None:
            assert parts.body is not None
            machine = Machine(parts.body, parts.valve, contact, at=table.at)
        else:
            machine = Machine.from_si(parts.bar, parts.valve, contact, at=table.at, pressure=pressure_of(table))
    except ParameterError as error:
        raise from_parameter(error, file, "load", {}) from None
    except ArithmeticError:
        raise extreme(file, "") from None
    _check_scale(machine, file)
    return machine


_LEAST, _MOST = 1e-9, 1e12
"""Of dimensionless sizes: no machine is beyond, where a flight of no end would be followed for long."""


def _check_scale(machine: Machine, file: str) -> None:
    """Refuse sizes so far from each other that they are a slip of units."""
    valve = machine.valve
    sizes = {"load.states": max(abs(force) for _, force in valve.pairs), "load.chamber.force": abs(valve.chamber.force)}
    sizes["load.chamber.stiffness"] = valve.chamber.stiffness
    if valve.supply is not None:
        sizes |= {"load.supply.flow": valve.supply.flow, "load.supply.accumulator": valve.supply.compliance}
    for i, port in enumerate(valve.ports):
        sizes |= {f"load.ports[{i}].behind": port.behind or 0.0, f"load.ports[{i}].delay": port.delay}
    for key, size in sizes.items():
        if size > _MOST or (0.0 < size < _LEAST and not key.endswith("delay")):
            what = "a size with a bar length, its mass and the unit of time as 1"
            accepted = f"expected {what}, from {_LEAST:g} to {_MOST:g}; it is {size:.4g}"
            raise CaseError(file, key, None, accepted, "check the units of length, force and time")
