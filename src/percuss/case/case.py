"""A case: one TOML file that describes a hammer, as an object."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pydantic import ValidationError

from percuss.case.answers.heading import clock_note
from percuss.case.file_format.bodies import damping_table, modes_in
from percuss.case.file_format.building import Parts, check_clock, check_motion, machine_of, recording_of, system_of
from percuss.case.file_format.contact import blow_note, law_note
from percuss.case.file_format.loads import HistoryLoad, ValveLoad, room_of
from percuss.case.file_format.reading import (
    case_form,
    checked_tables,
    parsed,
    text_of,
    toml_text,
    value_at,
    with_value,
    without_uncertainty,
)
from percuss.case.file_format.schema import PhysicalCase, missing_tables
from percuss.case.file_format.start_and_simulation import Simulation, simulation_of, start_of
from percuss.case.file_format.steel import steel_of
from percuss.errors import CaseError, ParameterError
from percuss.model import External, Kept, SizedBody, SteppedBar
from percuss.model.checks import count, mapping
from percuss.model.checks import path as checked_path
from percuss.model.checks import text as checked_text

if TYPE_CHECKING:
    from percuss.blow import Rod, Wall
    from percuss.case.file_format.building import ReadHistory
    from percuss.case.file_format.contact import BlowQuestion
    from percuss.case.file_format.loads import AnyLoad
    from percuss.case.file_format.plain_form import PlainCase
    from percuss.case.file_format.steel import CaseSteel
    from percuss.model import Load, Machine, System
    from percuss.model.checks import Array
    from percuss.model.contact import Timed
    from percuss.recordings.history import HistoryReport
    from percuss.simulate import Start

_KEYS = "keys of [simulation] and their values"


@dataclass(frozen=True)
class Case:
    """What a case file says, checked. Make one with `Case.read` or `Case.from_text`.

    Parameters
    ----------
    tables
        The tables in the SI form ([bar], [load], [contact]) or the dimensionless one ([system], [load]), either with
        [start] and [simulation] where it says how to simulate.
    file
        The name of the file, for messages.
    folder
        Where files that the case names are looked for.
    uncertain
        Numbers that are known within ±: their dotted keys, and the texts as they were given, ``"8.8 ± 0.3 cm^2"``.

    Raises
    ------
    CaseError
        When the tables do not describe a hammer; a file with several problems gives them all in one error.

    Examples
    --------
    >>> case = Case.from_text('''
    ... [system]
    ... s = 20.0
    ... d = 0.0048
    ... restitution = 0.6
    ... [load]
    ... kind = "harmonic"
    ... mean = 0.9
    ... amplitude = 1.0
    ... ''')
    >>> print(case.system())
    System: s = 20, d = 0.0048, R = 0.6; mean 0.9, 1 harmonic, load factor 0.9
    """

    tables: PhysicalCase | PlainCase
    file: str = field(default="<text>", compare=False)
    folder: Path = field(default=Path("."), compare=False)
    uncertain: tuple[tuple[str, str], ...] = ()

    def __post_init__(self) -> None:
        _ = self._parts  # everything but the recording is checked now

    @classmethod
    def read(cls, path: str | Path) -> Case:
        """The case in a file; ``-`` reads the standard input.

        Raises
        ------
        CaseError
            When the file cannot be read or is not a case.
        """
        name = checked_path("path", path)
        text = text_of(name)
        folder = Path(".") if name == "-" else Path(name).parent
        return cls.from_text(text, file="<stdin>" if name == "-" else name, folder=folder)

    @classmethod
    def from_text(cls, text: str, file: str = "<text>", folder: Path = Path(".")) -> Case:
        """The case in a TOML text; `file` names it in messages."""
        file, folder = checked_path("file", file), Path(checked_path("folder", folder))
        data = parsed(checked_text("text", text, "the text of a case in TOML"), file)
        nominal, uncertain = without_uncertainty(data, file)
        return cls(checked_tables(nominal, file), file, folder, uncertain)

    @property
    def title(self) -> str:
        """The title, or the name of the file when the case has none."""
        return self.tables.title or Path(self.file).stem

    @property
    def is_si(self) -> bool:
        """Whether the case is in SI units."""
        return isinstance(self.tables, PhysicalCase)

    @property
    def load_table(self) -> AnyLoad:
        """The table [load].

        Raises
        ------
        CaseError
            When the case describes one blow and has none.
        """
        check_motion(self.tables, self.file)
        assert self.tables.load is not None
        return self.tables.load

    @property
    def is_from_blow(self) -> bool:
        """Whether the restitution is that of the blow on the tool, which is resolved by waves."""
        return self.tables.struck is not None and self._parts.contact is None

    @cached_property
    def _parts(self) -> Parts:
        return Parts(self.tables, self.file, self.folder)

    @cached_property
    def _recording(self) -> ReadHistory | None:
        return recording_of(self.tables, self.file, self.folder)

    def load(self) -> Load:
        """The load as the case has it: in N with its frequency, or dimensionless; reads the recording when it is one.

        Raises
        ------
        CaseError
            When the recording cannot be read or used, the case describes one blow and has no load, or the piston
            switches its load.
        """
        check_clock(self.tables, self.file)
        load = self._parts.load if self._recording is None else self._recording.load
        assert load is not None  # the parts have raised otherwise
        return load

    @cached_property
    def _system(self) -> System:
        return self.with_load(self.load())

    def with_load(self, load: Load) -> System:
        """The system of this case under another load, in the units of `load`."""
        return system_of(self.tables, self._parts, load, self.file)

    def system(self) -> System:
        """The system that the case describes; reads the recording at the first call when the load is one.

        Raises
        ------
        CaseError
            When the recording cannot be read or used, or does not fit the case, or the case describes one blow only.
        """
        return self._system

    @property
    def is_machine(self) -> bool:
        """Whether the piston switches the load: the case then has a `machine` and no `system`."""
        return isinstance(self.tables.load, ValveLoad)

    @property
    def is_readable(self) -> bool:
        """Whether the load is a recording or steps, which may be read as those of a valve (`recorded_answer`)."""
        table = self.tables.load
        return table is not None and not self.is_machine and (table.kind == "history" or self.load().is_piecewise)

    @property
    def recorded_force(self) -> tuple[Array, Array] | None:
        """The samples that a recorded load was made from: their times (s), and the force; None of another load."""
        return None if self._recording is None else (self._recording.time, self._recording.force)

    def machine(self) -> Machine:
        """The machine of a case whose load the piston switches.

        Examples
        --------
        >>> from percuss.case import load_case
        >>> load_case("valve-breaker").machine().valve.start
        'return'
        """
        return self._machine

    @cached_property
    def _machine(self) -> Machine:
        return machine_of(self.tables, self._parts, self.file)

    def room(self) -> float | None:
        """How far behind the wall the piston of a machine can go, in bar lengths; None without a limit."""
        found = None if not isinstance(self.tables.load, ValveLoad) else room_of(self.tables.load)
        return found if found is None or not self.is_si else found / self.machine().length_scale

    # -- the blow --

    def tool(self) -> Rod | Wall:
        """What the bar strikes; without a table [tool] the rod of `receiving_area`, or a rigid wall.

        Examples
        --------
        >>> from percuss.case import load_case
        >>> load_case("laboratory-striker").tool().end
        'rock'
        """
        return self.blow_question().target

    def blow_question(self) -> BlowQuestion:
        """The blow that the tables [tool], [rock] and [blow] describe, as `percuss.blow.strike` is asked."""
        question = self._parts.blow
        if self.tables.body is not None:
            raise CaseError(self.file, "body", None, "a structure that is held: no blow of it is resolved by waves")
        assert question is not None  # the parts have raised otherwise
        return question

    def steel(self) -> CaseSteel:
        """The steels of bar and tool as the table [steel] has them, or what holds without it.

        Raises
        ------
        CaseError
            For a dimensionless case, which has no stresses.

        Examples
        --------
        >>> from percuss.case import load_case
        >>> load_case("laboratory-striker").steel().steel.ultimate
        900000000.0
        """
        striker, target = self.blow_question().striker, self.tool()
        if not isinstance(striker, SizedBody):
            accepted = "a dimensionless case has no stresses, and so no fatigue"
            raise CaseError(self.file, "", None, accepted, "describe bar and tool by their sizes, in [bar] and [tool]")
        return self._parts.steel or steel_of(None, striker, target)

    def timed_law(self) -> Timed | None:
        """The law of a blow that takes time, where [contact] or [system] names one; None for B77's impact.

        Raises
        ------
        CaseError
            When the blow on the tool gives no such law, or the case describes one blow only.
        """
        if self.tables.body is not None:
            return None
        return self._parts.timed(self.tables, self.system())

    @property
    def history_report(self) -> HistoryReport | None:
        """What was found in the recording, or None when the load is a formula."""
        return None if self.is_machine else self.system().load.report

    @property
    def notes(self) -> tuple[str, ...]:
        """What was assumed in reading the recording, of the load's clock and of the blow, one sentence each."""
        read = () if self._recording is None else self._recording.notes
        moves = self.is_from_blow and self.tables.load is not None
        from_blow = blow_note(self._parts.own_blow(self.hammer)) if moves else ""
        clock = "" if self.is_machine else clock_note(self.load())
        others = (clock, from_blow, law_note(self.tables.struck))
        return (*read, *(note for note in others if note))

    # -- simulation --

    def simulation(self) -> Simulation:
        """Modes and stop rule of the table [simulation]; what it leaves out has the defaults of `percuss.run`."""
        return simulation_of(self.tables.simulation, self.hammer)

    def start(self, modes: int | None = None) -> Start:
        """The start that the table [start] describes: by default at rest one bar length off the wall.

        Parameters
        ----------
        modes
            Elastic modes of the simulation, which a start on a steady motion depends on; by default those of
            [simulation].

        Raises
        ------
        CaseError
            When the case has no such steady motion.
        """
        from percuss.simulate.stop import MAX_MODES

        kept = self.simulation().modes if modes is None else count("modes", modes, least=0, most=MAX_MODES)
        return start_of(self.tables.start, self.hammer, kept, self.file)

    @property
    def hammer(self) -> System | Machine:
        """What moves: the machine of a case whose piston switches the load, else the system."""
        return self.machine() if self.is_machine else self.system()

    def changed(self, start: Mapping[str, Any] | None = None, simulation: Mapping[str, Any] | None = None) -> Case:
        """The same hammer with other keys in [simulation], or with another [start]; None leaves a table as it is.

        Parameters
        ----------
        start
            The keys of [start]; those that the case had are gone.
        simulation
            Keys of [simulation]; those that are not named stay as they are.

        Examples
        --------
        >>> from percuss.case import load_case
        >>> case = load_case("mini-breaker").changed(start={"position": "-20 mm"}, simulation={"impacts": 50})
        >>> round(case.start().displacement[0], 4), case.simulation().stop.impacts
        (-0.0625, 50)
        """
        data = parsed(self.to_toml(), self.file)
        if start is not None:
            data["start"] = dict(mapping("start", start, "keys of [start] and their values"))
        if simulation is not None:
            data["simulation"] = {**data.get("simulation", {}), **mapping("simulation", simulation, _KEYS)}
        return self._with(data)

    def varied(self, values: Mapping[str, Any]) -> Case:
        """The same case with other values of some keys, such as ``{"bar.length": "0.4 m"}``; None takes a key away.

        Examples
        --------
        >>> from percuss.case import load_case
        >>> case = load_case("mini-breaker")
        >>> case.varied({"bar.length": "0.4 m"}).system().s < case.system().s
        True
        """
        given = mapping("values", values, "dotted keys and their values")
        own = {key.partition(".")[0] for key in given} & self.tables.model_fields_set
        data = self.tables.model_dump(include=own, exclude_unset=True, by_alias=True)
        for key, value in given.items():
            try:
                if "." not in checked_text("values", key):
                    raise LookupError(key)
                data = with_value(data, key, value)
            except LookupError:
                remedy = "for example bar.length or bar.sections[0].length"
                raise ParameterError("values", key, "a key with its table", remedy) from None
        nominal, uncertain = without_uncertainty(data, self.file)
        if own == data.keys() and not uncertain and not self.uncertain:
            with suppress(ValidationError):  # which is told of all tables together
                fresh = {name: type(getattr(self.tables, name)).model_validate(nominal[name]) for name in own}
                return self._beside(self.tables.model_copy(update=fresh), ())
        return self._with({**self.to_dict(), **data})

    def _with(self, data: dict[str, Any]) -> Case:
        nominal, given = without_uncertainty(data, self.file)
        here, new = self.to_dict() if self.uncertain else {}, dict(given)
        kept = [pair for pair in self.uncertain if pair[0] not in new]
        kept = [pair for pair in kept if value_at(nominal, pair[0]) == value_at(here, pair[0])]
        return self._beside(checked_tables(nominal, self.file), (*kept, *given))

    def _beside(self, tables: PhysicalCase | PlainCase, uncertain: tuple[tuple[str, str], ...]) -> Case:
        """The case of other tables with the same recording, which is read once at most: it may be gone by now."""
        changed = Case(tables, self.file, self.folder, uncertain)
        if "_recording" in self.__dict__ and changed.tables.load == self.tables.load:
            changed.__dict__["_recording"] = self._recording
        return changed

    # -- writing --

    def to_dict(self) -> dict[str, Any]:
        """The tables as plain values, only those that were given; numbers without their ±."""
        return self.tables.model_dump(exclude_unset=True, by_alias=True)

    def to_toml(self) -> str:
        """TOML text that reads back as an equal case."""
        return toml_text(self.as_given())

    def as_given(self) -> dict[str, Any]:
        """The tables as `to_dict` has them, numbers with their ±."""
        tables = self.to_dict()
        for key, given in self.uncertain:
            tables = with_value(tables, key, given)
        return tables


def checked_case(case: object) -> None:
    if not isinstance(case, Case):
        raise ParameterError("case", case, "a Case", "make one with Case.read, Case.from_text or load_case")


# ---- Cases from tables that do not come from a file, and back: what programs and pages exchange

MAX_HARMONICS = 1024
"""The highest harmonic of a case that is taken from tables, unless the caller knows better."""


def case_of(tables: Mapping[str, Any], file: str = "case", harmonics: int = MAX_HARMONICS) -> Case:
    """The case that tables describe, as JSON has them; keys without a value (null) are taken as not given."""
    given = _given(tables)
    load, body = given.get("load"), given.get("body")
    if isinstance(body, dict) and "file" in body:
        remedy = "give its columns: omega, damping, contact and drive"
        raise CaseError(file, "body.file", body["file"], "a case cannot name a table of modes here", remedy)
    if isinstance(load, dict):
        if load.get("kind") == "history":
            remedy = "give the case and its recording together, or the load that the recording gives"
            raise CaseError(file, "load.kind", "history", "a case cannot name a recording here", remedy)
        check_harmonics(load, file, harmonics)
    nominal, uncertain = without_uncertainty(given, file)
    return Case(_checked(nominal, file), file, uncertain=uncertain)


def _given(table: Mapping[str, Any], deep: int = 2) -> dict[str, Any]:
    """The keys with a value; of a case, of its tables, and of those in them."""
    return {
        key: _given(value, deep - 1) if deep and isinstance(value, dict) else value
        for key, value in table.items()
        if value is not None
    }


def _checked(given: dict[str, Any], file: str) -> PhysicalCase | PlainCase:
    """The tables, checked; what is wrong is looked into only when something is, which takes longer than to be right."""
    form = case_form("system" in given)
    if not missing_tables(form, given) and {"bar", "body", "system"} & given.keys():
        with suppress(ValidationError):
            return form.model_validate(given)
    return checked_tables(given, file)


def check_harmonics(load: Mapping[str, Any], file: str, most: int) -> None:
    """Refuse a load with more harmonics than that, before arrays of their number are made."""
    pairs, breaks = load.get("coefficients"), load.get("breaks")
    number = len(pairs) - 1 if isinstance(pairs, list) else 0
    for key, value in (("harmonic", load.get("harmonic")), ("harmonics", load.get("harmonics"))):
        if isinstance(value, int) and value > most:
            raise CaseError(file, f"load.{key}", value, f"expected at most {most}")
    if number > most:
        raise CaseError(file, "load.coefficients", f"{number + 1} pairs", f"expected at most {most + 1} pairs")
    if isinstance(breaks, list) and len(breaks) > most:
        raise CaseError(file, "load.breaks", f"{len(breaks)} phases", f"expected at most {most} phases")


def json_tables(case: Case, *, as_given: bool = False) -> dict[str, Any]:
    """The tables of a case as JSON has them; only those that were given, numbers with their ± where it is asked for."""
    return {name: _json_value(table) for name, table in (case.as_given() if as_given else case.to_dict()).items()}


def _json_value(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _json_value(item) for key, item in value.items()}
    return [_json_value(item) for item in value] if isinstance(value, tuple | list) else value


def fourier_table(load: Load) -> dict[str, Any]:
    """The table [load] of a load by its harmonics: in N with a frequency, or in plain numbers."""
    table: dict[str, Any] = {
        "kind": "fourier",
        "coefficients": [[p.real, p.imag] for p in load.coefficients.tolist()],
        **({"at": load.at} if load.at else {}),
    }
    return table if load.frequency is None else {**table, "unit": "N", "frequency": f"{load.frequency!r} Hz"}


def system_table(hammer: System | Machine) -> dict[str, Any]:
    """The table [system] of a system or a machine."""
    body, law, contact = hammer.body, hammer.body.damping, hammer.contact
    table: dict[str, Any] = {"s": body.s, "restitution": contact.restitution}
    if isinstance(body, SteppedBar):
        table |= {"impedances": list(body.impedances), "transit_times": list(body.transit_times)}
    table |= {"d": law.rigid} if isinstance(law, External) else {"damping": damping_table(law)}
    return table if isinstance(contact, Kept) else {**table, "strain": contact.kind}


def without_files(case: Case) -> Case:
    """The same case with what its files hold in their place: a recording's harmonics, a table's columns."""
    load, body = case.tables.load, case.tables.body
    named = None if body is None else body.file
    if not isinstance(load, HistoryLoad) and named is None:
        return case
    tables = json_tables(case)
    if named is not None:
        case.system()  # which says by the key what is wrong with the file
        columns = {name: list(column) for name, column in modes_in(case.folder / named, named).items()}
        tables["body"] = {name: value for name, value in tables["body"].items() if name != "file"} | columns
    if isinstance(load, HistoryLoad):
        table = fourier_table(case.load())
        if load.is_plain:
            table = {key: table[key] for key in ("kind", "coefficients", "at") if key in table}
        tables["load"] = table
    return case_of(tables, case.file)
