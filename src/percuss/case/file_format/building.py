"""From the tables of a case to the objects of the model, with every refusal translated to its key.

Laws are refused by a `ParameterError` with the key of their table, which `Parts` gathers as one `CaseError`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar

from pydantic import BaseModel

from percuss.case.file_format.bodies import (
    COLUMNS,
    BodyTable,
    columns_of,
    plain_body,
    plain_damping,
    sized_body,
)
from percuss.case.file_format.contact import (
    NO_BIT,
    BlowQuestion,
    OwnBlow,
    blow_question,
    check_body,
    contact_of,
    drilling_of,
    fed,
    feed_of,
    law_of,
    own_blow,
    rock_of,
    sized_target,
    struck_alone,
    timed_law,
)
from percuss.case.file_format.loads import (
    HistoryLoad,
    ValveLoad,
    load_of,
    pressure_of,
    recorded_passages,
    room_of,
    valve_of,
)
from percuss.case.file_format.reading import from_parameter, raise_all, without_blow
from percuss.case.file_format.schema import PhysicalCase
from percuss.case.file_format.start_and_simulation import checked_simulation, checked_start
from percuss.case.file_format.steel import CaseSteel, steel_of
from percuss.case.file_format.values import above_zero, given_in, keyed
from percuss.errors import CaseError, HistoryError, ParameterError, did_you_mean
from percuss.model import Bar, Contact, HeldBody, Load, Machine, ModalBody, Mounted, SizedBody, System, Valve
from percuss.model.body import Body, SizedModes, SizedMounted
from percuss.model.contact import Timed

if TYPE_CHECKING:
    from percuss.blow import Rod, Wall
    from percuss.case.file_format.plain_form import PlainCase
    from percuss.model.checks import Array
    from percuss.recordings.history import HistoryReport
    from percuss.recordings.recording import Recording


# ---- A load from a recorded history that a case names, with every refusal translated to its key


class ReadHistory(NamedTuple):
    """The load of a recorded history, what was assumed in reading it, and its samples: times (s) and the force."""

    load: Load
    notes: tuple[str, ...]
    time: Array
    force: Array


def history_load(table: HistoryLoad, file: str, folder: Path) -> ReadHistory:
    """The load of a recorded history, whose file is looked for in the folder of the case file."""
    try:
        recording, force = _recorded(table, file, folder)
        frequency = None if table.frequency is None else above_zero("frequency", table.frequency, "frequency")
        load = Load.history(recording.time, force, frequency=frequency, harmonics=table.harmonics)
        if (counted := getattr(table, "force_scale", None)) is not None:  # of the dimensionless form
            load = load.scaled(1.0 / above_zero("force_scale", counted, "force"))
        load = replace(load, report=_with_channels(load.report, table, recording))
        return ReadHistory(load.acting_at(table.at), recording.notes, recording.time, force)
    except (ParameterError, HistoryError, OSError, ValueError) as error:
        raise _refused(error, table, file) from error


_VACUUM = 1e5  # Pa below the air around, of a gauge


def _with_channels(report: HistoryReport | None, table: HistoryLoad, recording: Recording) -> HistoryReport | None:
    """The report, with what is to say of a channel by itself: a limit hides in the difference of two."""
    from percuss.recordings.history import clipped_share, clipping

    if report is None:
        return report
    first = "the first channel" if table.column is None else f"column {table.column}"
    channels = [(first, recording.values)]
    if recording.opposing is not None:
        channels.append((f"column {table.opposing_column}", recording.opposing))
    said: list[str] = []
    for name, values in channels:
        said += clipping(clipped_share(values), f" of {name}") if len(channels) > 1 else []
        if recording.quantity == "pressure" and (lowest := float(values.min())) < -_VACUUM:
            least = f"{lowest / 1e5:.4g} bar"
            said.append(f"{name} falls to {least}, and no pressure is below −1 bar: check zero and unit of the sensor")
    return replace(report, warnings=(*report.warnings, *said))


def _refused(error: Exception, table: HistoryLoad, file: str) -> CaseError:
    """The refusal of a recording, with its key."""
    if isinstance(error, CaseError):
        return error
    if isinstance(error, ParameterError):
        return from_parameter(error, file, "load", table.model_dump(by_alias=True))
    if isinstance(error, HistoryError):
        return CaseError(file, "load.file", table.file, error.message, error.remedy)
    return CaseError(file, "load.file", table.file, f"cannot be read: {error}")  # as a path with a null character


def _recorded(table: HistoryLoad, file: str, folder: Path) -> tuple[Recording, Array]:
    """The recording that a case names, and the force on the bar."""
    from percuss.recordings.recording import read_recording  # only histories need it

    path = folder / table.file
    if not path.exists():
        raise CaseError(file, "load.file", table.file, f"no such file as {path}", _other_recordings(path))
    if path.is_dir():
        raise CaseError(file, "load.file", table.file, f"{path} is a directory", _other_recordings(path / "x"))
    rate = None if table.sample_rate is None else above_zero("sample_rate", table.sample_rate, "frequency")
    recording = read_recording(
        path,
        column=table.column,
        unit=table.unit,
        time_column=table.time_column,
        sample_rate=rate,
        opposing_column=table.opposing_column,
        start=table.start,
        end=table.end,
    )
    return recording, _recorded_force(table, recording, file)


def _recorded_force(table: HistoryLoad, recording: Recording, file: str) -> Array:
    """The force on the bar: of the one face, less that of the opposing one."""
    force = recording.values * _area(table.area, "area", recording.quantity, file)
    if recording.opposing is not None:
        return force - recording.opposing * _area(table.opposing_area, "opposing_area", recording.quantity, file)
    if table.opposing_area is not None:
        remedy = "name the column of the pressure that acts on it: opposing_column"
        raise CaseError(file, "load.opposing_area", table.opposing_area, "there is no opposing pressure", remedy)
    return force


def _area(given: str | None, name: str, quantity: str, file: str) -> float:
    """In m² for a pressure; 1 for a force, which takes none."""
    if quantity == "pressure":
        if given is None:
            remedy = f'give it as {name} = "6.5 cm^2"; or name another column or unit when the values are forces'
            raise CaseError(file, f"load.{name}", None, "a recorded pressure needs the area that it acts on", remedy)
        return above_zero(name, given, "area")
    if given is not None:
        remedy = f"leave {name} out, or name the column or unit of a pressure"
        raise CaseError(file, f"load.{name}", given, "the recorded values are forces, which need no area", remedy)
    return 1.0


def _other_recordings(path: Path) -> str:
    """A remedy that names the recordings lying where one was looked for."""
    try:
        names = [entry.name for entry in path.parent.iterdir() if entry.suffix.lower() != ".toml"]
    except OSError:
        return "the path is taken from the folder of the case file"
    return did_you_mean(path.name, names) or "the path is taken from the folder of the case file"


# ---- From the table [body] of a case to the structure that it describes

_OF_STRUCTURE = {"gap": "length", "spring": "stiffness", "dashpot": "dashpot"}
_OF_KIND = {"modes": ("file", *COLUMNS), "mounted": ("spring", "dashpot", "mass")}


_MODEL = {"delta": "damping", "stiffness": "spring", "rigid_mass": "mass"}
"""What the model calls the keys of a structure."""


def held_body(table: BodyTable, tables: PlainCase | PhysicalCase, folder: Path) -> HeldBody | SizedBody:
    """The structure of a case."""
    for kind, names in _OF_KIND.items():
        for name in names:
            if kind != table.kind and getattr(table, name) is not None:
                raise ParameterError(name, getattr(table, name), f'nothing: it belongs to kind = "{kind}"')
    si_case = isinstance(tables, PhysicalCase)
    for name in ("gap", "spring", "dashpot"):
        if si_case and isinstance(given := getattr(table, name), float | int):
            accepted = f"text with a number and a unit of {_OF_STRUCTURE[name]} in a case in SI"
            raise ParameterError(name, given, accepted)
    own = {"gap": 0.0, "dashpot": 0.0} | given_in(table)
    if table.kind == "modes":
        columns = columns_of(table, folder)
        with keyed(keys=_MODEL):
            return (SizedModes if si_case else ModalBody)(**columns, gap=own["gap"])
    if "spring" not in own:
        raise ParameterError("spring", None, "the spring of a body that is mounted")
    if isinstance(tables, PhysicalCase):
        bar = sized_body(tables.bar) if "bar" in tables.model_fields_set else None
        if bar is not None and not isinstance(bar, Bar):
            raise ParameterError("kind", table.kind, "a bar of one section in [bar]")
        if (bar is None) == (table.mass is None):
            wanted = "either a mass or a table [bar], not both"
            wanted = wanted if bar else 'a mass with its unit, for example "5 kg", or a table [bar]'
            raise ParameterError("mass", table.mass, wanted)
        with keyed(keys=_MODEL):
            return SizedMounted(own["spring"], own["dashpot"], bar, own.get("mass", 1.0), own["gap"])
    if table.mass is not None:
        raise ParameterError("mass", table.mass, "no mass: it is 1 in a dimensionless case")
    s = tables.system.s
    with_s = {} if s is None else {"s": s, "damping": plain_damping(tables.system)}
    with keyed(keys=_MODEL):
        return Mounted(own["spring"], own["dashpot"], gap=own["gap"], **with_s)  # type: ignore[arg-type]


def check_beside(tables: PhysicalCase | PlainCase) -> tuple[str, str, str] | None:
    """The table, key and words of what does not go with [body]; None for nothing."""
    table = tables.body
    assert table is not None
    for name in ("tool", "feed", "rock", "blow", "drilling"):
        if getattr(tables, name, None) is not None:
            return name, "", "no such table beside [body]: its contact is with a rigid wall"
    for key, only in (("law", "b77"), ("strain", "kept")):
        if tables.struck is not None and getattr(tables.struck, key) not in (None, only):
            return tables.struck_name, key, f'only "{only}" beside [body]'
    if tables.load is not None and tables.load.kind == "valve":
        return "load", "kind", "a load that keeps time beside [body]"
    if tables.load is not None and tables.load.at:
        return "load", "at", "0 beside [body]: its table says where the load acts"
    if not isinstance(tables, PhysicalCase):
        unfit = {"s", "d", "damping"} if table.kind == "modes" or tables.system.s is None else set()
        unfit |= {"impedances", "transit_times"}
        for name in sorted(unfit & tables.system.model_fields_set):
            return "system", name, "no such key beside this [body]"
    elif table.kind == "modes" and "bar" in tables.model_fields_set:
        return "bar", "", "no table [bar] beside a table of modes"
    return None


# ---- From the tables of a case to the objects of the model, with every refusal translated to its key


_LAST: dict[Any, tuple[tuple[object, ...], Any]] = {}


def _again(make: Callable[..., Any], *given: object) -> Any:
    """What is made of tables, or was last made of equal ones: cases over a parameter have most tables in common."""
    known = _LAST.get(make)
    if known is None or known[0] != given:
        _LAST[make] = known = given, make(*given)
    return known[1]


H = TypeVar("H", System, Machine)


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
        self.steel: CaseSteel | None = None
        self._own: dict[float, OwnBlow] = {}  # by their restitutions
        self._problems: list[CaseError] = []
        self._file = file
        if self._make_striker(tables, folder) and tables.struck is not None:
            make = partial(contact_of, bar=self.bar, tool=tables.tool is not None)
            self.contact = self._try(tables.struck_name, tables.struck, make)
        if isinstance(tables.load, ValveLoad):
            self.valve = self._try("load", tables.load, partial(_again, valve_of))
        elif isinstance(tables.load, HistoryLoad):
            self._try("load", tables.load, recorded_passages)
        elif tables.load is not None:
            self.load = self._try("load", tables.load, partial(_again, load_of))
        self._check_fit(tables)
        self._look_at_blow(tables)
        if tables.start is not None:
            self._try("start", tables.start, partial(_again, checked_start))
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
            name, make = "bar", partial(_again, sized_body)
            if tables.bar.length is None and tables.bar.sections is None:
                remedy = 'give it with its unit, for example length = "341 mm", or give sections'
                self._problems.append(CaseError(self._file, "bar.length", None, "missing", remedy))
                return True
        else:
            name, make = "system", plain_body
            if tables.system.s is None:
                found = "system.s", None, "missing", "add it, or a table [body] for a structure that is held"
            elif all(getattr(tables.system, key) is None for key in ("d", "damping", "impedances", "transit_times")):
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
            from percuss.case.file_format.plain_form import plain_target

            self.target = self._try("tool", tables.tool, lambda table: plain_target(table, striker))
        if self.target is not None:
            rock, feed = (tables.rock, tables.feed) if isinstance(tables, PhysicalCase) else (None, None)
            struck = self.target, rock, feed
            self.blow = self._try("blow", tables.blow, lambda table: _again(blow_question, table, striker, *struck))
        if self.blow is not None and isinstance(tables, PhysicalCase) and tables.drilling is not None:
            drilling = self._try("drilling", tables.drilling, drilling_of)
            self.blow = replace(self.blow, drilling=drilling)
            if tables.rock is None:
                remedy = "describe what is drilled in [rock]"
                self._problems.append(
                    CaseError(self._file, "drilling", None, "expected a table [rock] beside it", remedy)
                )

    def _target_in_si(self, tables: PhysicalCase, bar: SizedBody) -> None:
        before = len(self._problems)
        rock = None if tables.rock is None else self._try("rock", tables.rock, partial(_again, rock_of))
        if tables.rock is not None and tables.tool is None:
            accepted = "expected a table [tool] beside it: what the bar strikes, with the rock at its end"
            self._problems.append(CaseError(self._file, "rock", None, accepted, NO_BIT))
        if len(self._problems) == before:
            area = None if tables.contact is None else tables.contact.receiving_area
            self.target = self._try(
                "tool", tables.tool,
                lambda table: struck_alone(area, bar) if table is None else _again(sized_target, table, rock),
            )  # fmt: skip
            feed = None if tables.feed is None else self._try("feed", tables.feed, partial(_again, feed_of))
            if feed is not None and self.target is not None:
                struck = self.target
                self.target = self._try("feed", tables.feed, lambda _: fed(struck, feed))
        if tables.steel is not None and self.target is not None:
            target = self.target
            self.steel = self._try("steel", tables.steel, lambda table: _again(steel_of, table, bar, target))

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

    def with_own_blow(
        self, tables: PhysicalCase | PlainCase, made: Callable[[Contact], H], speed: Callable[[H], float]
    ) -> H:
        """The hammer whose restitution is that of its own blow, which is resolved by waves."""
        assert tables.struck is not None
        law = law_of(tables.struck, self.bar)
        own: OwnBlow = self._of_blow(tables, lambda _, question: own_blow(question, lambda r: speed(made(law(r)))))
        self._own[own.restitution] = own
        return made(law(own.restitution))

    def own_blow(self, hammer: System | Machine) -> OwnBlow:
        """The blow whose restitution a hammer has that was made with it."""
        return self._own[hammer.contact.restitution]

    def timed(self, tables: PhysicalCase | PlainCase, system: System) -> Timed | None:
        """The law of a blow that takes time, where the case names one."""
        own = self._own.get(system.contact.restitution)
        found: Timed | None = self._of_blow(
            tables, lambda table, asked: timed_law(table, asked if own is None else own.question, system)
        )
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
    def made(contact: Contact) -> System:
        try:
            if parts.bar is not None:
                return System.from_si(parts.bar, load, contact)
            assert parts.body is not None
            return System(parts.body, load, contact)
        except ParameterError as error:
            if error.name in _MEANING:
                raise _out_of_scale(error, tables, file) from None
            raise from_parameter(error, file, "load", {}) from None
        except ArithmeticError:
            raise extreme(file, "") from None

    return parts.with_own_blow(tables, made, _clocked_speed) if parts.contact is None else made(parts.contact)


def _clocked_speed(system: System) -> float:
    """Mean speed of the blows with one in each load period: what pushes in that time gives (1 + R) times it (B77)."""
    if not system.push > 0.0:
        accepted = "a load that pushes toward the tool, as the gap of [rock] makes the blow depend on its speed"
        raise ParameterError("restitution", None, accepted, "give a number from 0 to 1")
    return 2.0 * math.pi * system.push / system.contact.impulse * (system.speed_scale if system.is_si else 1.0)


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

    def made(contact: Contact) -> Machine:
        assert parts.valve is not None
        try:
            if parts.bar is not None:
                pressure = pressure_of(table)
                return Machine.from_si(parts.bar, parts.valve, contact, at=table.at, pressure=pressure)
            assert parts.body is not None
            return Machine(parts.body, parts.valve, contact, at=table.at)
        except ParameterError as error:
            raise from_parameter(error, file, "load", {}) from None
        except ArithmeticError:
            raise extreme(file, "") from None

    def speed(machine: Machine) -> float:
        room = room_of(table)
        return rigid_speed(machine, room if room is None or parts.bar is None else room / machine.length_scale)

    machine = parts.with_own_blow(tables, made, speed) if parts.contact is None else made(parts.contact)
    _check_scale(machine, file)
    return machine


def rigid_speed(machine: Machine, room: float | None) -> float:
    """Speed of the blow in the cycle of a rigid piston, in the units of the case; ParameterError without one blow."""
    from percuss.steady import self_excited_motion

    motion = self_excited_motion(machine, modes=0, room=room)
    cycle, obstacle = motion.cycle, motion.obstacle
    if cycle is None or cycle.blows > 1:
        why = "its cycle has several" if obstacle is None else f"{obstacle.words}; {obstacle.remedy}"
        raise ParameterError("restitution", None, "a machine that runs with one blow in a cycle", why)
    return float(cycle.blow_speed * (machine.speed_scale if machine.is_si else 1.0))


_LEAST, _MOST, _MOST_DRAG = 1e-9, 1e12, 1e4
"""Of dimensionless sizes: no machine is beyond, where a flight of no end would be followed for long."""


def _check_scale(machine: Machine, file: str) -> None:
    """Refuse sizes so far from each other that they are a slip of units."""
    valve = machine.valve
    sizes = {"load.states": max(abs(force) for _, force in valve.pairs), "load.chamber.force": abs(valve.chamber.force)}
    sizes["load.chamber.stiffness"] = valve.chamber.stiffness
    if valve.supply is not None:
        sizes |= {"load.supply.flow": valve.supply.flow, "load.supply.accumulator": valve.supply.compliance}
        gas, relief = valve.supply.gas, valve.supply.relief
        sizes |= {"load.supply.power": valve.supply.power or 0.0, "load.supply.start": valve.supply.start}
        sizes |= {} if relief is None else {"load.supply.relief": relief.pressure}
        sizes |= (
            {} if gas is None else {f"load.supply.accumulator.{k}": getattr(gas, k) for k in ("precharge", "volume")}
        )
    if valve.oil is not None:
        for key in ("tank", "spool", "leakage", "force"):
            sizes[{"tank": "load.oil.tank", "leakage": "load.supply.leakage"}.get(key, f"load.{key}")] = abs(
                getattr(valve.oil, key)
            )
        most = max(max(valve.oil.drag(name)) for name, _ in valve.pairs)
        if most > _MOST_DRAG:
            told = f"expected passages that take less: {most:.4g} of the motion in a bar length, at most {_MOST_DRAG:g}"
            raise CaseError(file, "load.orifices", None, told, "check drop, flow and area, and their units")
    for i, port in enumerate(valve.ports):
        given = {"behind": port.behind, "speed": port.speed, "delay": port.delay}
        sizes |= {f"load.ports[{i}].{name}": size or 0.0 for name, size in given.items()}
    for key, size in sizes.items():
        if size > _MOST or (0.0 < size < _LEAST and not key.endswith(("delay", "spool", "leakage", "force", "tank"))):
            what = "a size with a bar length, its mass and the unit of time as 1"
            accepted = f"expected {what}, from {_LEAST:g} to {_MOST:g}; it is {size:.4g}"
            raise CaseError(file, key, None, accepted, "check the units of length, force and time")
